use super::*;
use wirework_core::Curve;
use wirework_surface::grid;
use wirework_wrinkle::Layout;

fn travelling(velocity: [f32; 2]) -> Wrinkle {
    let layout =
        Layout { center: [0.0, 0.0, 19.0], direction: [1.0, 0.0, 0.0], size: [0.4, 0.2], creases: 1 };
    let motion = Motion::Travelling { velocity };
    Wrinkle { motion, thickness: Keyed::Constant(0.1), ..Wrinkle::new(Pattern::Tangential(layout)) }
}

#[test]
fn creases_that_travel_fast_leave_no_gap() {
    let mesh = grid([1.0, 40.0], [20, 800], [0.0, 1.0, 0.0]).unwrap();
    let subject = Subject::from_mesh("strip", mesh).unwrap();
    let wrinkle = travelling([0.0, 19.0]);
    let surface = SurfaceView { positions: &subject.points, triangles: &subject.triangles };
    let mut creases = creases(&surface, &wrinkle).unwrap();
    let mut wanted = vec![f32::INFINITY; subject.points.len()];
    want(&mut creases, &wrinkle, Span::new(2.0), &mut wanted).unwrap();
    let on_the_way = |p: &[f32; 3]| p[0].abs() < 0.2 && p[2].abs() < 18.9;
    let missed =
        subject.points.iter().zip(&wanted).filter(|(p, wanted)| on_the_way(p) && !wanted.is_finite());
    assert_eq!(missed.count(), 0);
    let wide =
        subject.points.iter().zip(&wanted).filter(|(p, wanted)| p[0].abs() > 0.4 && wanted.is_finite());
    assert_eq!(wide.count(), 0, "and nothing beside it");
}

#[test]
fn moments_are_as_many_as_the_way_asks_for_within_bounds() {
    let count = |wrinkle: &Wrinkle, to| moments(wrinkle, Span::new(to)).len();
    assert_eq!(count(&travelling([0.0; 2]), 2.0), 0, "what stays is looked at once");
    assert_eq!(count(&travelling([0.0, 1e-3]), 2.0), FEW + 1);
    assert_eq!(count(&travelling([3.0, 4.0]), 2.0), 201, "10 m in strides of 0.05");
    for velocity in [1e6, 1e30, f32::MAX] {
        assert!((MOST / 2..=MOST + 1).contains(&count(&travelling([velocity, 0.0]), 2.0)));
    }
    assert!(count(&travelling([1.0, 0.0]), f64::MAX) <= MOST + 1);
    // Beyond the effect's own end, and before 0 s, where that is asked for.
    let span = Span::new(2.0).with(&Schedule::Still(5.0)).with(&Schedule::Still(-1.0));
    let looked = moments(&travelling([0.1, 0.0]), span);
    assert_eq!((looked.first(), looked.last()), (Some(&-1.0), Some(&5.0)));
    assert!(looked.is_sorted());
    let frames = Schedule::Frames { frames: 12..25, fps: 12.0 };
    assert_eq!(Span::new(1.0).with(&frames), Span { from: 0.0, to: 2.0 });
}

#[test]
fn a_keyed_curve_is_looked_at_often_where_it_is_fast() {
    let line = |z: f32| vec![[-0.2, 0.0, z], [0.2, 0.0, z]];
    let drawn = |keys: Vec<(f64, Vec<[f32; 3]>)>| {
        let curve = Curve::polyline(line(0.0)).unwrap();
        let points = Some(Keyed::keys(keys, true).unwrap());
        let thickness = Keyed::Constant(0.1);
        Wrinkle { thickness, ..Wrinkle::new(Pattern::Drawn(vec![Drawn { curve, points }])) }
    };
    // 10 m in a tenth of a second, and then hardly any.
    let wrinkle = drawn(vec![(0.0, line(0.0)), (0.1, line(10.0)), (9.0, line(10.1))]);
    let looked = moments(&wrinkle, Span::new(9.0));
    let track = Keyed::keys(vec![(0.0, 0.0_f32), (0.1, 10.0), (9.0, 10.1)], true).unwrap();
    let strides = looked.windows(2).map(|pair| track.at(pair[1]) - track.at(pair[0]));
    assert!(strides.fold(0.0, f32::max) <= 0.0501 && looked.len() < 400, "{}", looked.len());
    let many = (0..20_000).map(|i| (f64::from(i), line(i as f32))).collect();
    assert!(moments(&drawn(many), Span::new(20_000.0)).len() <= MOST + 2);
}

#[test]
fn points_that_cannot_move_want_nothing() {
    // Two triangles in a row, and a third apart; of the last point's factor the second triangle knows nothing.
    let triangles = [[0, 1, 2], [1, 2, 3], [3, 4, 5]];
    let mut wanted = vec![f32::INFINITY; 6];
    wanted[3] = 0.5;
    keep(&mut wanted, &[0.1; 6], Some(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), &triangles);
    assert_eq!(wanted, [0.1, 0.1, 0.1, 0.1, f32::INFINITY, f32::INFINITY]);
    keep(&mut wanted, &[0.2; 6], None, &triangles);
    assert_eq!(wanted, [0.1, 0.1, 0.1, 0.1, 0.2, 0.2]);
}
