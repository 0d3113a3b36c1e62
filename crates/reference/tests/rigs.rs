//! The random rigs meet what they are there for.

use wirework_core::CurveKind;
use wirework_reference::{Rig, Scene, deform};

#[test]
fn a_hundred_rigs_meet_every_kind_and_move_a_good_part_of_their_points() {
    let mut kinds = Vec::new();
    let (mut moved, mut all) = (0, 0);
    for seed in 0..100 {
        let rig = Rig::new(seed);
        kinds.extend(rig.wires.iter().map(|w| (w.reference.kind(), w.reference.closed())));
        for (p, q) in rig.points.iter().zip(deform(&rig.wires, &rig.blend, &rig.points)) {
            assert!(q.iter().all(|c| c.is_finite()), "seed {seed}, {p:?}");
            moved += usize::from(p.map(f64::from) != q);
            all += 1;
        }
    }
    for kind in [1, 2, 3].map(|degree| CurveKind::BSpline { degree }).into_iter().chain([
        CurveKind::Polyline,
        CurveKind::CatmullRom,
        CurveKind::Bezier,
    ]) {
        assert!(kinds.contains(&(kind, false)) && kinds.contains(&(kind, true)), "{kind:?}");
    }
    assert!(moved * 2 > all && moved < all, "{moved} of {all}");
}

#[test]
fn rest_moves_nothing() {
    for seed in 0..60 {
        let rig = Rig::new(seed).at_rest();
        let scene = Scene::new(&rig.wires, &rig.blend);
        for &p in &rig.points {
            assert_eq!(scene.deform(p), p.map(f64::from), "seed {seed}");
        }
    }
}
