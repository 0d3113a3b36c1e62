//! The random rigs meet what they are there for.

use wirework_core::{Bounded, Closest, CurveKind};
use wirework_reference::{Random, Rig, Scene};

#[test]
fn a_hundred_rigs_meet_every_kind_and_move_a_good_part_of_their_points() {
    let mut kinds = Vec::new();
    let (mut moved, mut all) = (0, 0);
    for seed in 0..100 {
        let rig = Rig::new(seed);
        kinds.extend(rig.wires.iter().map(|w| (w.reference.kind(), w.reference.closed())));
        let scene = Scene::new(&rig.wires, &rig.blend);
        for (i, &p) in rig.points.iter().enumerate().step_by(3) {
            let q = scene.deform_masked(p, &rig.masks_at(i));
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
    for seed in 0..30 {
        let rig = Rig::new(seed).at_rest();
        let scene = Scene::new(&rig.wires, &rig.blend);
        for &p in rig.points.iter().step_by(2) {
            assert_eq!(scene.deform(p), p.map(f64::from), "seed {seed}");
        }
    }
}

#[test]
fn a_hundred_rigs_meet_every_bound() {
    let mut met = [0; 12];
    for rig in (0..100).map(Rig::new) {
        for (wire, mask) in rig.wires.iter().zip(&rig.masks) {
            assert_eq!(wire.check(), Ok(()));
            let kinds =
                [Bounded::Influence, Bounded::Scale, Bounded::Rotation, Bounded::Amplitude, Bounded::Twist];
            let domains = |bounds| wire.domains.iter().filter(|d| d.bounds == bounds).count();
            let features = [
                wire.direction.is_some(),
                wire.direction.is_none() && wire.locators.iter().any(|l| l.direction.is_some()),
                wire.closest != Closest::Smallest,
                mask.is_some(),
                domains(Bounded::Influence) > 1,
                wire.domains.iter().any(|d| d.exponent < 0.0),
                wire.domains.iter().any(|d| d.delta > 0.0) && !wire.domains.iter().any(|d| d.delta == 0.0),
            ];
            let all = features.into_iter().chain(kinds.map(|kind| domains(kind) > 0));
            all.enumerate().for_each(|(i, met_here)| met[i] += usize::from(met_here));
        }
    }
    assert!(met.iter().all(|&n| n >= 8), "{met:?}");
}

#[test]
fn masks_go_with_their_points() {
    let rig = (0..100).map(Rig::new).find(|rig| rig.masks.iter().any(Option::is_some)).unwrap();
    let mut shuffled = rig.clone();
    shuffled.shuffle(&mut Random::new(1));
    let pairs = |rig: &Rig| {
        let one = |i: usize| {
            (rig.points[i].map(f32::to_bits), rig.masks_at(i).iter().map(|m| m.to_bits()).collect())
        };
        let mut pairs: Vec<([u32; 3], Vec<u32>)> = (0..rig.points.len()).map(one).collect();
        pairs.sort_unstable();
        pairs
    };
    assert_ne!(rig.points, shuffled.points);
    assert_eq!(pairs(&rig), pairs(&shuffled));
    assert!(rig.masks.iter().flatten().all(|mask| mask.len() == rig.points.len()));
}
