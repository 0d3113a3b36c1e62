use std::f64::consts::TAU;

use glam::DVec3;
use wirework_core::Keyed;
use wirework_surface::{Corner, Mesh, tube};

use crate::ground::wide;
use crate::test_support::{LAYOUT, deform, lay, plane, wires};
use crate::{Layout, Motion, Pattern, Wrinkle, WrinkleWarning};

#[test]
fn rings_are_as_far_from_the_centre_as_they_are_to() {
    let layout = Layout { center: [0.1, 0.3, -0.2], creases: 4, ..LAYOUT };
    let wires = wires(&lay(&plane(50), &Wrinkle::new(Pattern::Ripple(layout))).unwrap(), 0.0);
    assert_eq!(wires.len(), 4);
    for (i, wire) in wires.iter().enumerate() {
        assert!(wire.reference.closed());
        for k in 0..40 {
            let r = wide(wire.reference.point(k as f32 / 40.0)).distance(DVec3::new(0.1, 0.0, -0.2));
            assert!((r - 0.125 * (i + 1) as f64).abs() < 5e-4, "ring {i}: {r}");
        }
    }
}

#[test]
fn a_ripple_reaches_round_a_tube() {
    let radius = 0.3;
    let mesh = tube([0.0, -2.0, 0.0], [0.0, 2.0, 0.0], radius, 64, 161, false).unwrap();
    let size = (f64::from(radius) * TAU) as f32;
    let layout =
        Layout { center: [0.3, 0.0, 0.0], size: [size, 1.0], creases: 3, direction: [0.0, 1.0, 0.0] };
    let laid =
        lay(&mesh, &Wrinkle { thickness: Keyed::Constant(0.06), ..Wrinkle::new(Pattern::Ripple(layout)) })
            .unwrap();
    let out = deform(&mesh, &laid, 0.0);
    // The far side is half the circumference away, where the last ring touches itself.
    let risen = |p: [f32; 3]| f64::from(p[0].hypot(p[2])) - f64::from(radius);
    let far = out.iter().filter(|p| p[1].abs() < 1e-3 && p[0] < -0.299).map(|p| risen(*p));
    let highest = far.fold(0.0, f64::max);
    assert!((highest - 0.05).abs() < 0.003, "{highest}");
    let near =
        out.iter().filter(|p| p[1].abs() < 1e-3 && p[0] > 0.299).map(|p| risen(*p)).fold(0.0, f64::max);
    assert!(near < 0.01, "{near}");
}

#[test]
fn travelling_rings_come_in_again_without_a_step() {
    let layout = Layout { creases: 3, ..LAYOUT };
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity: [0.2, 0.0] },
        thickness: Keyed::Constant(0.08),
        ..Wrinkle::new(Pattern::Ripple(layout))
    };
    let mesh = plane(80);
    for seed in 0..4 {
        let mut jittered = lay(&mesh, &Wrinkle { randomness: 1.0, seed, ..settings.clone() }).unwrap();
        let mut before = deform(&mesh, &jittered, 0.0);
        for i in 1..=400 {
            jittered.at(f64::from(i) * 0.01, None).unwrap();
            let now = deform(&mesh, &jittered, f64::from(i) * 0.01);
            let pairs = before.iter().zip(&now).map(|(a, b)| wide(*a).distance(wide(*b)));
            let step = pairs.fold(0.0, f64::max);
            assert!(step < 0.006, "seed {seed}, step {i}: {step}");
            before = now;
        }
    }
    let mut creases = lay(&mesh, &settings).unwrap();
    let mut at = |seconds: f64| {
        creases.at(seconds, None).unwrap();
        deform(&mesh, &creases, seconds)
    };
    let still = lay(&mesh, &Wrinkle { motion: Motion::Anchored, ..settings.clone() }).unwrap();
    let rest = deform(&mesh, &still, 0.0);
    let worst = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.iter().zip(b).map(|(a, b)| wide(*a).distance(wide(*b))).fold(0.0, f64::max)
    };
    assert!(worst(&rest, &at(0.0)) < 1e-5);
    let mut before = at(0.0);
    for i in 1..=250 {
        let now = at(f64::from(i) * 0.02);
        assert!(worst(&before, &now) < 0.01, "step {i}: {}", worst(&before, &now));
        before = now;
    }
    // A cycle is one ring longer than the pattern.
    assert!(worst(&rest, &at((0.5 + 0.5 / 3.0) / 0.2)) < 1e-4);
}

#[test]
fn rings_that_a_border_cuts_are_arcs_up_to_it() {
    let layout = Layout { center: [0.7, 0.0, 0.0], size: [1.2, 1.0], creases: 3, ..LAYOUT };
    let laid = lay(&plane(80), &Wrinkle::new(Pattern::Ripple(layout))).unwrap();
    let wires = wires(&laid, 0.0);
    assert_eq!(wires.len(), 3);
    assert!(laid.warnings().contains(&WrinkleWarning::Border { ends: 4 }));
    for (wire, r) in wires.iter().zip([0.2, 0.4, 0.6]) {
        assert_eq!(wire.reference.closed(), r < 0.3);
        for k in 0..=50 {
            let p = wide(wire.reference.point(k as f32 / 50.0));
            assert!((p.distance(DVec3::new(0.7, 0.0, 0.0)) - r).abs() < 2e-3, "{p}");
        }
        if r > 0.3 {
            assert!(
                (wire.reference.point(0.0)[0] - 1.0).abs() < 1e-4
                    && (wire.reference.point(1.0)[0] - 1.0).abs() < 1e-4
            );
        }
    }
}

#[test]
fn rings_say_what_cuts_them() {
    let layout = Layout { center: [-0.3, 0.0, 0.0], size: [1.4, 1.0], creases: 1, ..LAYOUT };
    let ripple = Wrinkle::new(Pattern::Ripple(layout));
    let said = |mesh: &Mesh| {
        let coarse = |w: &WrinkleWarning| matches!(w, WrinkleWarning::Coarse { .. });
        let mut all = lay(mesh, &ripple).unwrap().warnings().to_vec();
        all.retain(|w| !coarse(w));
        all
    };
    assert_eq!(said(&plane(40)), []);
    // A fin stands on the sheet along x = 0.2, where three faces meet.
    let mut mesh = plane(40);
    let rows: Vec<u32> = (0..mesh.positions.len() as u32)
        .filter(|&v| (mesh.positions[v as usize][0] - 0.2).abs() < 1e-4)
        .collect();
    for pair in rows.windows(2) {
        let top = mesh.positions.len() as u32;
        let [x, _, z] = mesh.positions[pair[0] as usize];
        mesh.positions.push([x, 0.5, z]);
        let corner = |position| Corner { position, uv: None, normal: None };
        mesh.corners.extend([pair[0], pair[1], top].map(corner));
        mesh.face_ends.push(mesh.corners.len() as u32);
    }
    assert_eq!(said(&mesh), [WrinkleWarning::NonManifold { ends: 2 }]);
    // The border of the sheet.
    let layout = Layout { center: [0.7, 0.0, 0.0], size: [1.2, 1.0], creases: 1, ..LAYOUT };
    let cut = Wrinkle::new(Pattern::Ripple(layout));
    assert!(lay(&plane(80), &cut).unwrap().warnings().contains(&WrinkleWarning::Border { ends: 2 }));
}

#[test]
fn the_front_of_a_ripple_runs_outwards() {
    let keys = Keyed::keys(vec![(0.0, 0.0), (1.0, 1.0)], false).unwrap();
    let layout = Layout { creases: 4, ..LAYOUT };
    let laid =
        lay(&plane(80), &Wrinkle { propagation: keys, ..Wrinkle::new(Pattern::Ripple(layout)) }).unwrap();
    let risen = |seconds| wires(&laid, seconds).iter().filter(|w| w.pose[0][1] > 0.04).count();
    assert_eq!([0.0, 0.3, 0.6, 0.8, 1.0].map(risen), [0, 1, 2, 3, 4]);
}
