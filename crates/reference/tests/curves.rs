//! Curves, lengths and feet against closed forms.

use wirework_core::{Curve, CurveKind};
use wirework_reference::{at_length, closest, derivative, length, point, segment_count, tangent};

const KINDS: [CurveKind; 6] = [
    CurveKind::BSpline { degree: 1 },
    CurveKind::BSpline { degree: 2 },
    CurveKind::BSpline { degree: 3 },
    CurveKind::Polyline,
    CurveKind::CatmullRom,
    CurveKind::Bezier,
];

fn near(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
    (0..3).all(|i| (a[i] - b[i]).abs() <= tolerance)
}

fn zigzag(count: usize) -> Vec<[f32; 3]> {
    (0..count).map(|i| [i as f32, (i * i % 5) as f32, (i * 3 % 4) as f32 * 0.5]).collect()
}

/// As many points as a Bézier chain needs too.
fn curve(kind: CurveKind, closed: bool) -> Curve {
    Curve::new(kind, closed, zigzag(if closed { 6 } else { 7 })).unwrap()
}

#[test]
fn open_curves_start_and_end_at_their_points() {
    for kind in KINDS {
        let c = curve(kind, false);
        let [first, last] = [c.points()[0], c.points()[6]].map(|p| p.map(f64::from));
        assert!(near(point(&c, 0.0), first, 0.0) && near(point(&c, 1.0), last, 0.0), "{kind:?}");
    }
}

#[test]
fn closed_curves_meet_themselves() {
    for kind in KINDS {
        let c = curve(kind, true);
        assert!(near(point(&c, 0.0), point(&c, 1.0), 1e-12), "{kind:?}");
    }
}

#[test]
fn the_derivative_is_the_slope_of_the_points() {
    for (kind, closed) in KINDS.into_iter().flat_map(|k| [(k, false), (k, true)]) {
        let c = curve(kind, closed);
        for i in 0..50 {
            let (u, h) = ((f64::from(i) + 0.37) / 50.0, 1e-6);
            let (a, b) = (point(&c, u - h), point(&c, u + h));
            let slope = [0, 1, 2].map(|i| (b[i] - a[i]) / (2.0 * h));
            assert!(near(derivative(&c, u), slope, 1e-5), "{kind:?} {closed} at {u}");
        }
    }
}

#[test]
fn a_clamped_cubic_of_four_points_is_their_bezier() {
    let points = zigzag(4);
    let spline = Curve::bspline(3, points.clone()).unwrap();
    let bezier = Curve::new(CurveKind::Bezier, false, points).unwrap();
    for i in 0..=20 {
        let u = f64::from(i) / 20.0;
        assert!(near(point(&spline, u), point(&bezier, u), 1e-13));
    }
}

#[test]
fn a_periodic_cubic_is_the_uniform_basis() {
    // At a joint (c₀ + 4 c₁ + c₂) / 6, in the middle of a segment (c₀ + 23 c₁ + 23 c₂ + c₃) / 48.
    let c = Curve::new(CurveKind::BSpline { degree: 3 }, true, zigzag(6)).unwrap();
    for segment in 0..6 {
        let p = |i: usize| c.points()[(segment + i) % 6].map(f64::from);
        let joint = [0, 1, 2].map(|k| (p(0)[k] + 4.0 * p(1)[k] + p(2)[k]) / 6.0);
        let middle = [0, 1, 2].map(|k| (p(0)[k] + 23.0 * (p(1)[k] + p(2)[k]) + p(3)[k]) / 48.0);
        let u = segment as f64 / 6.0;
        assert!(near(point(&c, u), joint, 1e-12) && near(point(&c, u + 0.5 / 6.0), middle, 1e-12));
    }
}

#[test]
fn splines_of_evenly_spaced_points_on_a_line_reproduce_it() {
    // Greville abscissae of the clamped cubic with three segments give x(u) = u.
    let x = [0.0, 1.0 / 9.0, 1.0 / 3.0, 2.0 / 3.0, 8.0 / 9.0, 1.0].map(|x: f64| [x as f32, 0.0, 0.0]);
    let c = Curve::bspline(3, x.to_vec()).unwrap();
    for i in 0..=30 {
        let u = f64::from(i) / 30.0;
        assert!((point(&c, u)[0] - u).abs() < 1e-7);
    }
}

#[test]
fn too_few_points_lower_the_degree() {
    for closed in [false, true] {
        let of = |degree, count| Curve::new(CurveKind::BSpline { degree }, closed, zigzag(count)).unwrap();
        for (count, degree) in [(2, 1), (3, 2)] {
            let (low, high) = (of(degree, count), of(3, count));
            assert_eq!(segment_count(&low), segment_count(&high));
            assert_eq!(point(&low, 0.3), point(&high, 0.3));
        }
    }
}

#[test]
fn one_point_is_a_point() {
    for (kind, closed) in KINDS.into_iter().flat_map(|k| [(k, false), (k, true)]) {
        if kind == CurveKind::Bezier && closed {
            continue;
        }
        let c = Curve::new(kind, closed, vec![[1.0, 2.0, 3.0]]).unwrap();
        assert_eq!(point(&c, 0.4), [1.0, 2.0, 3.0]);
        assert_eq!((tangent(&c, 0.4), length(&c), at_length(&c, 0.5)), ([0.0; 3], 0.0, None));
        let foot = closest(&c, [1.0, 2.0, 7.0]);
        assert_eq!((foot.u, foot.distance), (0.0, 4.0));
    }
}

#[test]
fn catmull_rom_passes_its_points_and_evenly_spaced_is_the_uniform_one() {
    for closed in [false, true] {
        let c = curve(CurveKind::CatmullRom, closed);
        let n = segment_count(&c);
        for (i, p) in c.points().iter().enumerate() {
            assert!(near(point(&c, i as f64 / n as f64), p.map(f64::from), 1e-12));
        }
    }
    // Equal distances give equal knots: the middle of a segment is (−a + 9 b + 9 c − d) / 16.
    let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 1.0, 0.0]];
    let c = Curve::new(CurveKind::CatmullRom, false, points).unwrap();
    assert!(near(point(&c, 0.5), [1.0, 0.5, 0.0], 1e-12));
    // At an end the neighbour is mirrored: a = 2 b − c = (−1, 0, 0).
    assert!(near(point(&c, 0.5 / 3.0), [(1.0 + 9.0 - 1.0) / 16.0, -1.0 / 16.0, 0.0], 1e-12));
}

#[test]
fn coincident_neighbours_of_catmull_rom_are_a_constant_segment_and_the_limit_beside_it() {
    let with = |gap: f32| {
        let points = vec![[0.0; 3], [1.0, 1.0, 0.0], [1.0 + gap, 1.0, 0.0], [2.0, 0.0, 1.0], [4.0, 0.0, 0.0]];
        Curve::new(CurveKind::CatmullRom, false, points).unwrap()
    };
    let c = with(0.0);
    for i in 0..=10 {
        let u = 0.25 + f64::from(i) / 40.0;
        assert!(near(point(&c, u), [1.0, 1.0, 0.0], 1e-15));
    }
    for i in 0..=40 {
        let u = f64::from(i) / 40.0;
        assert!(near(point(&c, u), point(&with(1e-6), u), 2e-3), "at {u}");
    }
}

#[test]
fn a_corner_has_the_mean_tangent_and_cancelling_ones_none() {
    let c = Curve::polyline(vec![[0.0; 3], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 0.0]]).unwrap();
    let half = 0.5_f64.sqrt();
    assert!(near(tangent(&c, 1.0 / 3.0), [half, half, 0.0], 1e-15));
    assert_eq!(tangent(&c, 2.0 / 3.0), [0.0; 3]);
    assert_eq!((tangent(&c, 0.0), tangent(&c, 1.0)), ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0]));
    let square = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let square = Curve::new(CurveKind::Polyline, true, square).unwrap();
    for u in [0.0, 1.0] {
        assert!(
            near(tangent(&square, u), [half, -half, 0.0], 1e-15),
            "the start of a closed curve is a joint"
        );
    }
}

#[test]
fn a_zero_tangent_on_one_side_is_left_out() {
    // A handle of no length: the curve stops at the joint and goes on round the corner.
    let mut points = zigzag(7);
    (points[2], points[3], points[4]) = ([3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0]);
    let c = Curve::new(CurveKind::Bezier, false, points.clone()).unwrap();
    assert_eq!(tangent(&c, 0.5), [0.0, 1.0, 0.0]);
    points[4] = points[3];
    assert_eq!(tangent(&Curve::new(CurveKind::Bezier, false, points).unwrap(), 0.5), [0.0; 3]);
}

#[test]
fn lengths_have_closed_forms() {
    // y = x² from 0 to 1 as a quadratic B-spline; a line at uneven speed; a polyline.
    let parabola = Curve::bspline(2, vec![[0.0; 3], [0.5, 0.0, 0.0], [1.0, 1.0, 0.0]]).unwrap();
    let exact = 0.5 * 5.0_f64.sqrt() + 0.25 * 2.0_f64.asinh();
    assert!((length(&parabola) - exact).abs() < 1e-12);
    let uneven = Curve::bspline(3, [0.0, 0.5, 4.0, 4.5, 9.0].map(|x| [x, 0.0, 0.0]).to_vec()).unwrap();
    assert!((length(&uneven) - 9.0).abs() < 1e-12);
    for i in 0..=20 {
        let s = f64::from(i) / 20.0;
        let u = at_length(&uneven, s).unwrap();
        assert!((point(&uneven, u)[0] - 9.0 * s).abs() < 1e-9);
    }
    let square =
        Curve::new(CurveKind::Polyline, true, vec![[0.0; 3], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0]]).unwrap();
    assert_eq!(length(&square), 12.0);
    assert_eq!(at_length(&square, 0.25), Some(1.0 / 3.0));
}

#[test]
fn a_cusp_is_measured() {
    // x = (1 − 2t)²: there and back.
    let cusp = Curve::bspline(2, vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]).unwrap();
    assert!((length(&cusp) - 2.0).abs() < 1e-12);
}

#[test]
fn feet_on_a_line_are_projections() {
    let c = Curve::polyline(vec![[0.0; 3], [4.0, 0.0, 0.0]]).unwrap();
    for (p, u, distance) in
        [([1.0, 2.0, 0.0], 0.25, 2.0), ([-3.0, 4.0, 0.0], 0.0, 5.0), ([6.0, 0.0, 0.0], 1.0, 2.0)]
    {
        let foot = closest(&c, p);
        assert!((foot.u - u).abs() < 1e-13 && (foot.distance - distance).abs() < 1e-13, "{foot:?}");
        assert!(!foot.ambiguous && foot.sharpness > 0.99);
    }
}

#[test]
fn feet_are_no_farther_than_any_sample() {
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    };
    for (kind, closed) in KINDS.into_iter().flat_map(|k| [(k, false), (k, true)]) {
        let c = curve(kind, closed);
        let samples: Vec<[f64; 3]> = (0..=20_000).map(|i| point(&c, f64::from(i) / 20_000.0)).collect();
        for _ in 0..40 {
            let p = [random() * 9.0 - 1.0, random() * 7.0 - 1.0, random() * 4.0 - 1.0];
            let distance = |q: &[f64; 3]| (0..3).map(|i| (q[i] - p[i]).powi(2)).sum::<f64>().sqrt();
            let least = samples.iter().map(distance).fold(f64::INFINITY, f64::min);
            let foot = closest(&c, p);
            assert!(foot.distance <= least + 1e-5, "{kind:?} {closed} {p:?}: {foot:?}, sampled {least}");
            assert!((distance(&point(&c, foot.u)) - foot.distance).abs() < 1e-12);
        }
    }
}

#[test]
fn the_smallest_parameter_wins_a_tie() {
    let vee = Curve::polyline(vec![[-1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]).unwrap();
    let foot = closest(&vee, [0.0, 1.0, 0.0]);
    assert!((foot.u - 0.25).abs() < 1e-12 && foot.ambiguous, "{foot:?}");
    // One bit off the middle still ties, a part in a million does not.
    let foot = closest(&vee, [f64::from(1e-7_f32), 1.0, 0.0]);
    assert!((foot.u - 0.25).abs() < 1e-6);
    assert!(closest(&vee, [1e-6, 1.0, 0.0]).u > 0.7);
    let square = vec![[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]];
    let square = Curve::new(CurveKind::Polyline, true, square).unwrap();
    assert!((closest(&square, [0.0; 3]).u - 0.125).abs() < 1e-12);
}

#[test]
fn on_a_constant_stretch_the_foot_is_its_start() {
    let c = Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]).unwrap();
    assert_eq!(closest(&c, [1.0, 3.0, 0.0]).u, 1.0 / 3.0);
}

#[test]
fn a_foot_beside_a_standstill_is_found() {
    // Segment 0 is a point and segment 1 leaves it from standstill.
    let points = vec![[0.0, 2.0, 1.0], [0.0, 2.0, 1.0], [2.0, 1.0, 0.0], [-1.0, 1.0, -2.0]];
    let c = Curve::new(CurveKind::CatmullRom, false, points).unwrap();
    for t in [1e-3, 4e-3, 7e-3] {
        let u = (1.0 + t) / 3.0;
        let on = point(&c, u);
        assert!((closest(&c, on).u - u).abs() < 1e-9, "{:?}", closest(&c, on));
    }
}

#[test]
fn the_sharpness_vanishes_on_the_evolute() {
    // y = x²/2 has radius of curvature 1 at its bottom.
    let c = Curve::bspline(2, vec![[-1.0, 0.5, 0.0], [0.0, -0.5, 0.0], [1.0, 0.5, 0.0]]).unwrap();
    assert!(closest(&c, [0.0, 1.0, 0.0]).sharpness.abs() < 1e-6);
    assert!((closest(&c, [0.0, 0.5, 0.0]).sharpness - 0.5).abs() < 1e-6);
}
