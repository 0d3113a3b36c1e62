use glam::DVec3;
use wirework_core::{Curve, Keyed};
use wirework_surface::grid;

use crate::ground::wide;
use crate::test_support::{lay, plane, wires};
use crate::{Drawn, Motion, Pattern, Wrinkle, WrinkleWarning};

#[test]
fn drawn_creases_travel_along_themselves_and_across() {
    let mesh = plane(64);
    let line = Curve::polyline(vec![[-0.5, 0.2, 0.3], [0.5, 0.2, 0.3]]).unwrap();
    let with = |velocity| {
        let settings = Wrinkle {
            motion: Motion::Travelling { velocity },
            thickness: Keyed::Constant(0.1),
            ..Wrinkle::drawn(vec![line.clone()])
        };
        let mut creases = lay(&mesh, &settings).unwrap();
        move |seconds: f64| {
            creases.at(seconds, None).unwrap();
            let wire = wires(&creases, seconds).remove(0);
            assert!(wire.pose.iter().all(|p| (p[1] - 0.05).abs() < 1e-6));
            [0.0, 1.0].map(|u| wide(wire.reference.point(u)))
        }
    };
    let near = |found: [DVec3; 2], expected: [[f64; 2]; 2]| {
        for (found, [x, z]) in found.into_iter().zip(expected) {
            assert!(found.distance(DVec3::new(x, 0.0, z)) < 1e-5, "{found} for {x}, {z}");
        }
    };
    // Across is normal × along: −z.
    let mut across = with([0.0, 0.2]);
    near(across(2.0), [[-0.5, -0.1], [0.5, -0.1]]);
    near(across(30.0), [[-0.5, -1.0], [0.5, -1.0]]);
    let mut along = with([0.1, 0.0]);
    near(along(3.0), [[-0.2, 0.3], [0.8, 0.3]]);
    near(along(60.0), [[0.0, 0.3], [1.0, 0.3]]);
    let mut back = with([-0.1, 0.0]);
    near(back(2.0), [[-0.7, 0.3], [0.3, 0.3]]);
    near(back(60.0), [[-1.0, 0.3], [0.0, 0.3]]);
}

#[test]
fn drawn_creases_follow_the_keys_of_their_curves() {
    let mesh = plane(64);
    let curve = Curve::polyline(vec![[-0.5, 0.1, 0.0], [0.5, 0.1, 0.0]]).unwrap();
    let keys = vec![(0.0, curve.points().to_vec()), (1.0, vec![[-0.5, 0.1, 0.4], [0.5, 0.1, 0.8]])];
    let drawn = Drawn { curve, points: Some(Keyed::keys(keys, false).unwrap()) };
    let mut creases = lay(&mesh, &Wrinkle::new(Pattern::Drawn(vec![drawn]))).unwrap();
    assert!(creases.moves());
    for (seconds, z) in [(0.0, [0.0, 0.0]), (0.5, [0.2, 0.4]), (2.0, [0.4, 0.8])] {
        creases.at(seconds, None).unwrap();
        let wire = wires(&creases, seconds).remove(0);
        for (u, z) in [0.0, 1.0].into_iter().zip(z) {
            let p = wire.reference.point(u);
            assert!((f64::from(p[2]) - z).abs() < 1e-4 && p[1].abs() < 1e-6, "{p:?} at {seconds}");
        }
    }
}

#[test]
fn jitter_follows_its_seed_and_its_bounds() {
    let mesh = grid([4.0; 2], [8, 8], [0.0, 1.0, 0.0]).unwrap();
    let line = Curve::polyline(vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]).unwrap();
    let with = |randomness, seed| {
        let settings = Wrinkle { randomness, seed, ..Wrinkle::drawn(vec![line.clone(); 20]) };
        wires(&lay(&mesh, &settings).unwrap(), 0.0)
    };
    assert_eq!(with(0.0, 1), with(0.0, 2));
    assert_eq!(with(1.0, 1), with(1.0, 1));
    let jittered = with(1.0, 3);
    let mut extent = [(f32::INFINITY, f32::NEG_INFINITY); 4];
    for wire in &jittered {
        let (a, b) = (wire.reference.point(0.0), wire.reference.point(1.0));
        let crest = wire.pose[0][1];
        for (range, value) in extent.iter_mut().zip([a[2], crest, a[0], b[0]]) {
            *range = (range.0.min(value), range.1.max(value));
        }
    }
    let [side, height, start, end] = extent;
    assert!(side.0 >= -0.0801 && side.0 < -0.02 && side.1 <= 0.0801 && side.1 > 0.02, "{side:?}");
    assert!(height.0 >= 0.0249 && height.0 < 0.035 && height.1 <= 0.0501 && height.1 > 0.04, "{height:?}");
    assert!(start.0 >= -1.0 && start.1 <= -0.499 && start.1 > -0.8, "{start:?}");
    assert!(end.1 <= 1.0 && end.0 >= 0.499 && end.0 < 0.8, "{end:?}");
}

#[test]
fn a_curve_that_passes_a_border_says_so() {
    let mesh = plane(64);
    let said = |points: Vec<[f32; 3]>| {
        let curve = Curve::polyline(points).unwrap();
        let settings = Wrinkle { thickness: Keyed::Constant(0.1), ..Wrinkle::drawn(vec![curve]) };
        lay(&mesh, &settings).unwrap().warnings().to_vec()
    };
    let border = |ends| vec![WrinkleWarning::Border { ends }];
    // High over the surface, and past its end by less than its thickness.
    assert_eq!(said(vec![[-0.8, 0.7, 0.0], [0.8, 0.1, 0.1]]), []);
    assert_eq!(said(vec![[-0.8, 0.1, 0.0], [1.09, 0.1, 0.1]]), []);
    // Along the border.
    assert_eq!(said(vec![[-0.8, 0.3, 1.0], [0.8, 0.3, 1.0]]), []);
    assert_eq!(said(vec![[-0.8, 0.1, 0.0], [1.4, 0.1, 0.1]]), border(1));
    assert_eq!(said(vec![[-1.4, 0.1, 0.0], [1.4, 0.1, 0.1]]), border(2));
    // Over a corner, and out and in again.
    assert_eq!(said(vec![[0.0, 0.1, 0.0], [1.5, 0.1, 1.5]]), border(1));
    assert_eq!(said(vec![[0.0, 0.1, 0.5], [1.5, 0.1, 0.0], [0.0, 0.1, -0.5]]), border(1));
}
