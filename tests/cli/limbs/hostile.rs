//! Limbs of extreme numbers: finite vertices, or an error with the code of what is at fault; never a panic.

use std::fmt::Write;

use super::made::figure;
use crate::place::Place;
use crate::wrinkles::vertices;

/// Applies a preset. It is done and all that is written is finite, or it is refused and nothing is written.
#[track_caller]
fn survives(place: &Place, preset: &str, input: &str) -> bool {
    place.write("limb.ron", preset);
    let _ = std::fs::remove_file(place.path("out.obj"));
    let done = place.run(&format!("apply limb.ron {input} -o out.obj --at 0.5 -q --threads 1"));
    let (code, err) = (done.code(), done.err());
    assert!([0, 3, 4, 5].contains(&code), "exit code {code} of {preset}: {err}");
    assert!(!err.contains("bug") && !err.contains("panic"), "{preset}: {err}");
    let written = place.files().contains(&"out.obj".to_owned());
    assert_eq!(written, code == 0, "{preset}: {err}");
    if written {
        let points = vertices(&place.read("out.obj"));
        assert!(points.iter().all(|p| p.is_finite()), "{preset}");
    }
    written
}

fn limb(joints: &str, fields: &str) -> String {
    format!(
        "Ik(object: Tube(from: (0, 0, 0), to: (2, 0, 0), radius: 0.2, sides: 5, rings: 9), chain: Joints([{joints}]), {fields})"
    )
}

const JOINTS: &str = "(0, 0, 0), (1, 0, 0), (2, 0, 0)";
const KINDS: [&str; 6] = [
    "elasticity: 0",
    "elasticity: 0.5, curve: Chain",
    "elasticity: 1",
    "elasticity: 0.5, limits: [10, 10], scale_by: Local, tip: Hold((10, 20, 30))",
    "elasticity: 0.7, stiffness: [1, 0], pole: (0, 1, 0), twist: 90",
    "elasticity: 0.3, pins: [(0, (0, 0, 0)), (1, (1, 0.2, 0))], softness: 1",
];

#[test]
fn goals_anywhere() {
    let place = Place::new();
    let mut done = 0;
    for goal in [
        "(0, 0, 0)",
        "(-0.0, -0.0, -0.0)",
        "(1e-30, 0, 0)",
        "(1e-45, 1e-45, 0)",
        "(-2, 0, 0)",
        "(-1e-9, 1e-12, 0)",
        "(1, 0, 0)",
        "(2.0000002, 0, 0)",
        "(1e30, -1e30, 1)",
        "(1e38, 0, 0)",
        "(3.4e38, 3.4e38, -3.4e38)",
    ] {
        for kind in KINDS {
            done += u32::from(survives(&place, &limb(JOINTS, &format!("goal: {goal}, {kind}")), ""));
        }
    }
    // A limb reaches what it can; nothing about that is refused.
    assert_eq!(done, 66);
}

#[test]
fn joints_anywhere() {
    let place = Place::new();
    let mut done = 0;
    for joints in [
        "(0, 0, 0), (1e-30, 0, 0), (2e-30, 0, 0)",
        "(0, 0, 0), (1e-45, 0, 0), (1e-45, 1e-45, 0)",
        "(0, 0, 0), (1e30, 0, 0), (2e30, 0, 0)",
        "(-3.4e38, 0, 0), (3.4e38, 0, 0), (3.4e38, 3.4e38, 0)",
        "(0, 0, 0), (1, 0, 0), (0, 0, 0)",
        "(0, 0, 0), (1, 0, 0), (0, 0, 1e-20)",
        "(1e8, 0, 0), (1e8, 100, 0), (1e8, 200, 8)",
        "(-0.0, 0, 0), (1, -0.0, 0), (2, 0, -0.0)",
        "(0, 0, 0), (1, 1e-4, 0), (2, 0, 0)",
    ] {
        for goal in ["(0.5, 0.5, 0.5)", "(0, 0, 0)", "(1e30, 0, 0)"] {
            for kind in KINDS {
                done += u32::from(survives(&place, &limb(joints, &format!("goal: {goal}, {kind}")), ""));
            }
        }
    }
    // But for the widest, which overflow.
    assert!(done >= 150, "{done}");
}

#[test]
fn settings_at_their_ends() {
    let place = Place::new();
    let mut done = 0;
    for fields in [
        "max_stretch: 1, min_stretch: 1, softness: 0",
        "max_stretch: 3e38, softness: 1, elasticity: 1",
        "max_stretch: 1e30, softness: 0",
        "min_stretch: 0, elasticity: 1",
        "curve: Rounded(1e-30)",
        "curve: Rounded(1e-45)",
        "twist: 1e7",
        "twist: 1e30",
        "limits: [1e-30, 1e-30], elasticity: 0",
        "limits: [180, 180], elasticity: 0",
        "pole: (1e38, 1e38, 0)",
        "pole: (0, 0, 0)",
        "pole: (1e-40, 0, 0)",
        "pins: [(0, (1e38, 0, 0)), (1, (-1e38, 0, 0))]",
        "pins: [(0, (1, 0, 0)), (1, (1, 0, 0))]",
        "pins: [(1, (0, 0, 0))], elasticity: 1",
        "stiffness: [1, 1], elasticity: 1",
        "stiffness: [1e-30, 1], elasticity: 1",
        "stiffness: [0.99999994, 1], elasticity: 1",
        "influence: Radius(1e-30)",
        "influence: Radius(3e38)",
        "closest: Blended(3e38)",
        "closest: Blended(1e-30)",
        "tip: Hold((1e30, -1e30, 0))",
        "elasticity: Keys([(-1e30, 0), (1e30, 1)]), duration: 1",
        "units: Bounds",
    ] {
        for goal in ["(0.1, 0, 0)", "(0, 0, 0)", "(-5, 0.1, 0)"] {
            for volume in ["volume: 1", "volume: 1, scale_by: Local"] {
                let preset = limb(JOINTS, &format!("goal: {goal}, {fields}, {volume}"));
                done += u32::from(survives(&place, &preset, ""));
            }
        }
    }
    // A few are out of range.
    assert!(done >= 130, "{done}");
}

#[test]
fn limbs_of_many_joints() {
    let place = Place::new();
    let mut joints = String::new();
    for i in 0..100 {
        let _ = write!(joints, "({}, {}, 0), ", f64::from(i) * 0.02, f64::from(i % 3) * 0.004);
    }
    let mut pins = String::new();
    for i in 0..99 {
        let _ = write!(pins, "({i}, (1, 0.{i}, 0)), ");
    }
    for goal in ["(1, 1, 0.3)", "(0, 0, 0)", "(1e38, 0, 0)", "(-1.9, 0, 0)"] {
        for fields in [
            "elasticity: 0".to_owned(),
            "elasticity: 0.5, scale_by: Local, twist: 90".to_owned(),
            format!("elasticity: 0.3, limits: [{}]", "5, ".repeat(99)),
            format!("elasticity: 1, stiffness: [{}]", "0, 1, 0.5, ".repeat(33)),
            format!("pins: [{pins}]"),
        ] {
            assert!(
                survives(&place, &limb(&joints, &format!("goal: {goal}, {fields}")), ""),
                "{goal} {fields}"
            );
        }
    }
}

#[test]
fn objects_anywhere() {
    let place = Place::new();
    for (name, text) in [
        ("none.obj", "# nothing\n"),
        ("one.obj", "v 0 0 0\n"),
        ("far.obj", "v 1e38 0 0\nv -1e38 0 0\nv 0 1e38 1\nf 1 2 3\n"),
        ("tiny.obj", "v 1e-38 0 0\nv 0 1e-45 0\nv 0 0 0\nf 1 2 3\n"),
        ("odd.obj", "v nan 0 0\nv 0 inf 0\nv 0 0 1\nf 1 2 3\n"),
    ] {
        place.write(name, text);
        for kind in KINDS {
            for units in ["Metres", "Bounds"] {
                let fields = format!("goal: (0.4, 1, 0), units: {units}, {kind}");
                survives(&place, &limb(JOINTS, &fields), name);
            }
        }
    }
}

#[test]
fn joints_of_a_model_that_is_squashed_or_blown_up() {
    let place = Place::new();
    let preset = |fields: &str| {
        format!(
            "Ik(chain: Skin(root: \"upper\", tip: \"hand\"), influence: SkinWeights, goal: Node(\"target\"), {fields})"
        )
    };
    for scale in ["0", "1e-30", "1e30", "-1", "3e38"] {
        let mut doc = figure(true);
        let scale: serde_json::Value = serde_json::from_str(&format!("[{scale}, {scale}, {scale}]")).unwrap();
        doc.json["nodes"][1]["scale"] = scale;
        place.write("figure.glb", doc.glb());
        for kind in KINDS {
            survives(&place, &preset(kind), "figure.glb");
        }
    }
}
