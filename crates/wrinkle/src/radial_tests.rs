use std::f64::consts::TAU;

use glam::DVec3;
use wirework_core::{Keyed, Wire};
use wirework_surface::grid;

use crate::ground::wide;
use crate::test_support::{LAYOUT, lay, plane, wires};
use crate::{Branches, Curtain, Layout, Motion, Pattern, Wrinkle};

#[test]
fn radial_creases_start_along_the_direction_and_turn_towards_across() {
    let layout = Layout { creases: 6, ..LAYOUT };
    let laid = lay(&plane(40), &Wrinkle::new(Pattern::Radial(layout, Branches::default()))).unwrap();
    let wires = wires(&laid, 0.0);
    assert_eq!(wires.len(), 6);
    for (i, wire) in wires.iter().enumerate() {
        let angle = TAU * i as f64 / 6.0;
        let ahead = DVec3::new(angle.cos(), 0.0, -angle.sin());
        assert!(wide(wire.reference.point(1.0)).distance(ahead * 0.5) < 1e-5);
        let inner = wide(wire.reference.point(0.0));
        assert!(inner.distance(ahead * inner.length()) < 1e-5 && inner.length() <= 0.05);
    }
}

#[test]
fn branches_leave_their_stems_left_and_right() {
    let layout = Layout { creases: 3, ..LAYOUT };
    let branches = Branches { count: 2, depth: 2 };
    let settings = Wrinkle::new(Pattern::Radial(layout, branches));
    assert_eq!(settings.crease_count(), 3 * (1 + 2 + 4));
    let wires = wires(&lay(&plane(40), &settings).unwrap(), 0.0);
    assert_eq!(wires.len(), 21);
    let (start, end) =
        (|i: usize| wide(wires[i].reference.point(0.0)), |i: usize| wide(wires[i].reference.point(1.0)));
    // Stem, its first branch, that one's two, its second branch, ..
    for (parent, child, side) in [(0, 1, 1.0), (0, 4, -1.0), (1, 2, 1.0), (1, 3, -1.0)] {
        let stem = end(parent) - start(parent);
        let x = (start(child) - start(parent)).dot(stem) / stem.length_squared();
        assert!((start(child) - start(parent) - stem * x).length() < 1e-5 && x > 0.2 && x < 0.8);
        let left = DVec3::Y.cross(stem);
        assert!((end(child) - start(child)).dot(left) * side > 0.0);
        assert!(end(child).length() < 0.5);
    }
}

#[test]
fn branches_of_a_curtain_stay_on_their_stems() {
    // An upright sheet; the stems hang from the middle of it.
    let mesh = grid([2.0; 2], [40; 2], [0.0, 0.0, 1.0]).unwrap();
    let layout = Layout { direction: [0.3, -1.0, 0.0], size: [1.6, 1.0], creases: 3, ..LAYOUT };
    let curtain = Curtain { wind: Keyed::Constant([2.0, 0.0, 6.0]), ..Curtain::default() };
    for stiffness in [0.0, 0.4] {
        let settings = Wrinkle {
            motion: Motion::Curtain(Box::new(Curtain { stiffness, ..curtain.clone() })),
            ..Wrinkle::new(Pattern::Radial(layout, Branches { count: 2, depth: 2 }))
        };
        let laid = lay(&mesh, &settings).unwrap();
        let rest = wires(&laid, 0.0);
        for seconds in [0.0, 0.4, 1.1] {
            let wires = wires(&laid, seconds);
            for (stem, branch) in [(0, 1), (0, 4), (1, 2), (4, 6), (7, 8)] {
                let from = rest[branch].reference.point(0.0);
                let foot = rest[stem].reference.closest(from).unwrap();
                let posed =
                    |wire: &Wire, u: f32| wide(wire.reference.posed(wire.pose.clone()).unwrap().point(u));
                let off = posed(&wires[stem], foot.u).distance(posed(&wires[branch], 0.0));
                assert!(off < 0.01 * 0.08, "{branch} is {off} off {stem} at {seconds}");
            }
        }
    }
}
