//! What is no limb, and says so; and limbs that a clip has moved.

use glam::DVec3;
use wirework_core::{Closest, Keyed};
use wirework_ik::{ChainCurve, Ik, IkError, Influence, Limb, Pin, Tip};

/// Three bones along X.
const JOINTS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];

/// The message and the field of what is wrong.
fn fault(joints: &[[f32; 3]], settings: &Ik) -> (String, String) {
    let error = Limb::new(joints, settings).unwrap_err();
    (error.path(), error.to_string())
}

fn with(change: impl FnOnce(&mut Ik)) -> (String, String) {
    let mut settings = Ik::default();
    change(&mut settings);
    fault(&JOINTS, &settings)
}

fn told((path, message): (&str, &str), found: &(String, String)) {
    assert_eq!(path, found.0);
    assert!(found.1.contains(message), "{}: {message}", found.1);
}

#[test]
fn chains_without_bones_are_refused() {
    told(("chain", "at least two joints, found 0"), &fault(&[], &Ik::default()));
    told(("chain", "at least two joints, found 1"), &fault(&[[0.0; 3]], &Ik::default()));
    told(
        ("chain", "joint 1 is at the place of joint 0"),
        &fault(&[[1.0; 3], [1.0; 3], [2.0; 3]], &Ik::default()),
    );
    // As good as one place.
    let near = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1e-7, 0.0]];
    told(("chain", "joint 2 is at the place of joint 1"), &fault(&near, &Ik::default()));
    told(("chain", "joint 1 is not finite"), &fault(&[[0.0; 3], [f32::NAN, 0.0, 0.0]], &Ik::default()));
    // A short bone beside long ones is one.
    assert!(Limb::new(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1e-4, 0.0]], &Ik::default()).is_ok());
}

#[test]
fn settings_out_of_range_are_refused() {
    told(
        ("curve", "greater than 0 and at most 0.5, not 0.6"),
        &with(|ik| ik.curve = ChainCurve::Rounded(0.6)),
    );
    told(("curve", "not 0"), &with(|ik| ik.curve = ChainCurve::Rounded(0.0)));
    told(("elasticity", "from 0 to 1, not 1.5"), &with(|ik| ik.elasticity = Keyed::Constant(1.5)));
    told(("elasticity", "not NaN"), &with(|ik| ik.elasticity = Keyed::Constant(f32::NAN)));
    told(("stiffness[1]", "not -0.1"), &with(|ik| ik.stiffness = vec![0.0, -0.1, 1.0]));
    told(("stiffness", "2 values for 4 joints, expected 3"), &with(|ik| ik.stiffness = vec![0.0; 2]));
    told(("stiffness", "4 values"), &with(|ik| ik.stiffness = vec![0.0; 4]));
    told(("limits", "5 values for 4 joints"), &with(|ik| ik.limits = vec![1.0; 5]));
    told(("limits[2]", "greater than 0, not 0"), &with(|ik| ik.limits = vec![1.0, 1.0, 0.0]));
    told(("max_stretch", "1 or more, not 0.9"), &with(|ik| ik.max_stretch = 0.9));
    told(("max_stretch", "not inf"), &with(|ik| ik.max_stretch = f32::INFINITY));
    told(("min_stretch", "not 1.1"), &with(|ik| ik.min_stretch = 1.1));
    told(("softness", "not -1"), &with(|ik| ik.softness = -1.0));
    told(("volume", "not 2"), &with(|ik| ik.volume = 2.0));
    told(("twist", "not 2000000"), &with(|ik| ik.twist = Keyed::Constant(2e6)));
    told(("tip[1]", "not NaN"), &with(|ik| ik.tip = Tip::Hold([0.0, f32::NAN, 0.0])));
    told(("influence", "greater than 0, not -1"), &with(|ik| ik.influence = Influence::Radius(-1.0)));
    told(("closest", "greater than 0, not 0"), &with(|ik| ik.closest = Closest::Blended(0.0)));
    told(
        ("pole", "a finite point, not inf"),
        &with(|ik| ik.pole = Some(Keyed::Constant([0.0, f32::INFINITY, 0.0]))),
    );
    for fits in [vec![1.0; 3], vec![1.0; 4]] {
        assert!(Limb::new(&JOINTS, &Ik { limits: fits, ..Ik::default() }).is_ok());
    }
}

#[test]
fn pins_hold_joints_that_are_there_once() {
    let pin = |joint| Pin { joint, point: Keyed::Constant([0.0; 3]) };
    told(("pins[0]", "joint 3, but only joints 0 to 2"), &with(|ik| ik.pins = vec![pin(3)]));
    told(("pins[1]", "joint 1, which an earlier pin"), &with(|ik| ik.pins = vec![pin(1), pin(1)]));
    let bad = Pin { joint: 1, point: Keyed::Constant([f32::NAN; 3]) };
    told(("pins[0]", "a finite point"), &with(|ik| ik.pins = vec![bad]));
}

#[test]
fn an_arm_that_a_clip_stretches_keeps_its_bend() {
    // Bent towards −Z at rest; a clip turns it and stretches it until it is straight, and a little beyond.
    let rest = Limb::new(
        &[[0.0; 3], [1.0, 0.0, -0.3], [2.0, 0.0, 0.0]],
        &Ik { elasticity: Keyed::Constant(0.0), ..Ik::default() },
    )
    .unwrap();
    for over in [-0.05, -0.01, 0.0, 0.01] {
        let limb = rest.moved(&[[0.0; 3], [0.0, 1.0, over], [0.0, 2.0, 0.0]]).unwrap();
        let joints: Vec<DVec3> = limb.pose([0.0, 1.2, 0.0], 0.0).joints().map(DVec3::from_array).collect();
        assert!(joints[1].z < -0.5, "{over}: {}", joints[1]);
        // Its own pose is its rest all the same.
        let still: Vec<[f64; 3]> = limb.pose(limb.tip(), 0.0).joints().collect();
        assert!(still.into_iter().eq(limb.joints()));
    }
    assert_eq!(rest.moved(&[[0.0; 3], [1.0; 3]]).unwrap_err(), IkError::Joints { found: 2 });
}
