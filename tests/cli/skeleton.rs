//! Limbs as skeletons: joints made for them or the model's own, and what is said of how well they play.

use std::f32::consts::TAU;

use glam::DVec3;
use serde_json::Value;
use wirework::asset::{Clip, Gltf, JointTrack, NewJoint, NewMesh, NewSkin, Tracks};

use crate::document::{Difference, Document, differences};
use crate::oracle;
use crate::place::{Place, shared};
use crate::wrinkles::vertices;

const SIDES: usize = 8;
/// Frames a second of effects of one second.
const FPS: usize = 6;

/// A sleeve about the x axis from −0.5 to 2.2, a ring of points every tenth.
fn sleeve() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let rings = 28;
    let point = |k: usize| {
        let angle = (k % SIDES) as f32 / SIDES as f32 * TAU;
        [(k / SIDES) as f32 * 0.1 - 0.5, 0.1 * angle.cos(), 0.1 * angle.sin()]
    };
    let quad = |k: usize| {
        let (a, b) = (k, k / SIDES * SIDES + (k + 1) % SIDES);
        let [a, b, c, d] = [a, b, a + SIDES, b + SIDES].map(|v| v as u32);
        [[a, b, d], [a, d, c]]
    };
    ((0..rings * SIDES).map(point).collect(), (0..(rings - 1) * SIDES).flat_map(quad).collect())
}

fn bare() -> Gltf {
    let (positions, triangles) = sleeve();
    let mesh =
        NewMesh { name: "sleeve", positions: &positions, normals: None, uvs: None, triangles: &triangles };
    Gltf::from_meshes("sleeve", &[mesh]).unwrap()
}

/// The sleeve on a body and an arm, which meet over so many metres.
fn arm(over: f32) -> Gltf {
    let mut gltf = bare();
    let rest = gltf.rest().unwrap();
    let joint = |(k, name): (usize, &'static str)| NewJoint {
        name,
        parent: k.checked_sub(1),
        translation: [
            if k == 0 {
                -0.5
            } else if k == 1 {
                0.5
            } else {
                1.0
            },
            0.0,
            0.0,
        ],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    let joints: Vec<NewJoint<'_>> =
        ["body", "upper", "lower", "hand"].into_iter().enumerate().map(joint).collect();
    let (mut indices, mut weights) = (Vec::new(), Vec::new());
    for [x, ..] in &rest.positions {
        // The nearest border between two joints.
        let border = (x + 1e-4).round().clamp(0.0, 2.0);
        let part = ((x - border) / over.max(1e-3) + 0.5).clamp(0.0, 1.0);
        indices.extend([border as u16, border as u16 + 1]);
        weights.extend([1.0 - part, part]);
    }
    let skin = NewSkin { name: "arm", joints: &joints, each: 2, indices: &indices, weights: &weights };
    gltf.add_skin(&rest, &[0], &skin).unwrap();
    gltf
}

/// The arm with a clip in which the body and the upper arm turn.
fn waving() -> Gltf {
    let mut gltf = arm(0.3);
    let turn = |angle: f32| [0.0, 0.0, (angle / 2.0).sin(), (angle / 2.0).cos()];
    let track = |name: &str, angle: f32| JointTrack {
        node: (0..9).find(|&node| gltf.node_name(node) == Some(name)).unwrap(),
        rotations: vec![turn(0.0), turn(angle), turn(angle * 0.5)],
        ..JointTrack::default()
    };
    let joints = [track("body", 0.4), track("upper", -0.7)];
    let tracks = Tracks { times: &[0.0, 0.5, 1.0], joints: &joints, ..Tracks::default() };
    gltf.add_tracks(&Clip::New("wave".into()), &tracks).unwrap();
    gltf
}

/// A limb on the sleeve, with these fields.
fn limb(chain: &str, fields: &str) -> String {
    format!("Ik({chain}, goal: Keys([(0, (2, 0, 0)), (1, (1.1, 1.1, 0.4))]), {fields})")
}

const OWN: &str = "chain: Skin(root: \"upper\", tip: \"hand\"), influence: SkinWeights";
const MADE: &str = "chain: Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0)])";

/// All vertices when a clip is played.
fn played(glb: &[u8], clip: usize, seconds: f64) -> Vec<DVec3> {
    oracle::evaluate_clip(glb, |_| Some(clip), seconds, true)
        .into_iter()
        .flat_map(|shown| shown.positions)
        .collect()
}

fn far(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

impl Place {
    /// Bakes `limb.ron` on a model as a skeleton, into `out.glb`: what the report says of it.
    fn skeleton(&self, input: &str, options: &str) -> Value {
        let line = format!(
            "apply limb.ron {input} -o out.glb --bake skin --fps {FPS} --report out.json -q {options}"
        );
        self.run(&line).expect(0);
        let report: Value = serde_json::from_slice(&self.read("out.json")).unwrap();
        report["skeleton"].clone()
    }

    /// The vertices that the effect has at a frame.
    fn frame_of(&self, input: &str, frame: usize) -> Vec<DVec3> {
        self.moment_of(input, frame as f64 / FPS as f64)
    }

    fn moment_of(&self, input: &str, seconds: f64) -> Vec<DVec3> {
        self.run(&format!("apply limb.ron {input} --at {seconds} -o still.obj -q")).expect(0);
        vertices(&self.read("still.obj"))
    }

    /// The residual that is told of `out.glb`: it is what is played at the time that is told, and at no frame or between frames is more.
    #[track_caller]
    fn residual(&self, told: &Value, input: &str, clip: usize) -> f64 {
        let glb = self.read("out.glb");
        let off = |seconds: f64| far(&played(&glb, clip, seconds), &self.moment_of(input, seconds));
        let [residual, seconds] = ["residual", "seconds"].map(|key| told[key].as_f64().unwrap());
        assert!(
            (off(seconds) - residual).abs() < 2e-6,
            "{residual} is told at {seconds} s, {} is played",
            off(seconds)
        );
        for k in 0..4 * FPS {
            let seconds = (k / 4) as f64 + [0.0, 0.237, 0.5, 0.831][k % 4];
            let off = off(seconds / FPS as f64);
            assert!(off < residual + 1e-5 + 0.02 * residual, "{off} at frame {seconds}, {residual} is told");
        }
        residual
    }
}

#[test]
fn a_made_skeleton_plays_as_is_told_and_better_with_more_joints() {
    let place = Place::new();
    place.write("bare.glb", bare().to_glb().unwrap());
    place.write("limb.ron", limb(MADE, "elasticity: 0.4"));
    let mut before = f64::INFINITY;
    for (between, count) in [(0, 3), (1, 5), (3, 9), (7, 17)] {
        let told = place.skeleton("bare.glb", &format!("--joints {between}"));
        assert_eq!((&told["joints"], &told["made"]), (&count.into(), &count.into()));
        let residual = place.residual(&told, "bare.glb", 0);
        let part = told["residual_of_diagonal"].as_f64().unwrap();
        assert!((part * 2.7_f64.hypot(0.08_f64.sqrt()) - residual).abs() < 1e-6);
        assert!(residual < 0.7 * before, "{residual} after {before}");
        before = residual;
    }
    assert!(before < 0.02, "{before}");
    // At rest nothing is off, and no morph target was made.
    let rest = far(&played(&place.read("out.glb"), 0, 0.0), &place.frame_of("bare.glb", 0));
    assert!(rest < 1e-6, "{rest}");
    let json = Document::open(&place.path("out.glb")).json;
    assert!(json["meshes"][0]["primitives"][0].get("targets").is_none());
}

#[test]
fn what_a_made_limb_does_not_reach_stays_on_a_joint_of_its_own() {
    let place = Place::new();
    // A second mesh, which `only` leaves out.
    let (positions, triangles) = sleeve();
    let aside: Vec<[f32; 3]> = positions.iter().map(|&[x, y, z]| [x, y, z + 1.0]).collect();
    let mesh = |name, positions| NewMesh { name, positions, normals: None, uvs: None, triangles: &triangles };
    let gltf = Gltf::from_meshes("two", &[mesh("sleeve", &positions), mesh("aside", &aside)]).unwrap();
    place.write("two.glb", gltf.to_glb().unwrap());
    let still = |fields: &str, stays: &dyn Fn(DVec3) -> bool| {
        place.write("limb.ron", limb(MADE, fields));
        let told = place.skeleton("two.glb", "--joints 5");
        assert_eq!((&told["joints"], &told["made"]), (&13.into(), &13.into()), "{fields}");
        place.residual(&told, "two.glb", 0);
        let names = Document::open(&place.path("out.glb")).json["nodes"].to_string();
        assert!(names.contains("limb_rest"), "{names}");
        let (rest, now) = (place.frame_of("two.glb", 0), played(&place.read("out.glb"), 0, 1.0));
        let mut some = [false; 2];
        for (p, q) in rest.iter().zip(&now) {
            let near = p.distance(*q) < 1e-6;
            assert!(near || !stays(*p), "{fields}: {p} is at {q}");
            some[usize::from(near)] = true;
        }
        assert_eq!(some, [true; 2], "{fields}");
    };
    still("only: Nodes([\"sleeve\"])", &|p| p.z > 0.5);
    still("influence: Radius(0.4)", &|p| p.z > 0.5);
    // Within the radius all of it follows in part.
    still("influence: Radius(0.15)", &|p| p.x < -0.2 || p.z > 0.5);
}

/// Whether a model that is baked as a skeleton may differ so from what it was.
fn allowed(difference: &Difference, old: &Value, finer: bool) -> bool {
    let Difference { path, old: before, new } = difference;
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    let added = before.is_none();
    let number = new.as_ref().and_then(Value::as_u64);
    let behind = |key: &str| number.is_some_and(|n| n >= old[key].as_array().map_or(0, Vec::len) as u64);
    match path.as_slice() {
        ["accessors" | "bufferViews" | "animations", _] | ["animations", _, "channels" | "samplers", _] => {
            added
        }
        ["buffers", "0", "byteLength"] => true,
        ["animations", _, "channels", _, "sampler"] => number.is_some(),
        ["nodes", _] | ["nodes", _, "children"] | ["nodes", _, "children", _] | ["skins", _, "joints", _] => {
            finer && added
        }
        ["skins", _, "inverseBindMatrices"] => finer && behind("accessors"),
        ["meshes", _, "primitives", _, "attributes", "JOINTS_0" | "WEIGHTS_0"] => {
            finer && behind("accessors")
        }
        _ => false,
    }
}

#[test]
fn own_joints_follow_a_limb_over_a_clip_and_nothing_else_changes() {
    let place = Place::new();
    place.write("arm.glb", waving().to_glb().unwrap());
    let old = Document::open(&place.path("arm.glb"));
    place.write("limb.ron", limb(OWN, "elasticity: 0.5"));
    let mut residuals = Vec::new();
    for (joints, into) in [(0, "new"), (0, "wave"), (3, "new"), (3, "wave"), (7, "new")] {
        let told = place.skeleton("arm.glb", &format!("--joints {joints} --into {into}"));
        assert_eq!(told["made"] == 0, joints == 0, "{told}");
        let new = Document::open(&place.path("out.glb"));
        let clip = usize::from(into == "new");
        residuals.push(place.residual(&told, "arm.glb", clip));
        for difference in differences(&old.json, &new.json) {
            let path = &difference.path;
            assert!(allowed(&difference, &old.json, joints > 0), "{joints} {into}: {difference:?}");
            assert!(
                into == "wave" || path[0] != "animations" || path.len() == 2,
                "the old clip stays: {path:?}"
            );
        }
        let bin = |document: &Document| document.bin.clone().unwrap();
        let length = old.json["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
        assert!(bin(&new)[..length] == bin(&old)[..length]);
        // The body goes where the clip has it, to the bit of what is told.
        let (before, after) = (place.read("arm.glb"), place.read("out.glb"));
        for frame in 0..=FPS {
            let seconds = frame as f64 / FPS as f64;
            let [a, b] = [played(&before, 0, seconds), played(&after, clip, seconds)];
            let rest = place.frame_of("arm.glb", 0);
            let body = rest.iter().zip(a.iter().zip(&b)).filter(|(p, _)| p.x < -0.21);
            assert!(body.map(|(_, (a, b))| a.distance(*b)).fold(0.0, f64::max) < 1e-6);
            if into == "new" {
                // The old clip plays as it did, whatever joints there are.
                assert!(far(&a, &played(&after, 0, seconds)) < 1e-6, "{joints} joints at {seconds} s");
            }
        }
    }
    assert!((residuals[0] - residuals[1]).abs() < 1e-6 && (residuals[2] - residuals[3]).abs() < 1e-6);
    assert!(residuals[2] < 0.5 * residuals[0] && residuals[4] < 0.6 * residuals[2], "{residuals:?}");
}

#[test]
fn what_eases_in_and_out_within_a_frame_is_followed() {
    let place = Place::new();
    place.write("arm.glb", arm(0.3).to_glb().unwrap());
    let goal = "goal: Ease([(0, (2, 0, 0)), (1, (2.6, 0, 0))]), elasticity: 1, volume: 0";
    place.write("limb.ron", format!("Ik({OWN}, {goal})"));
    place.run("apply limb.ron arm.glb -o out.glb --bake skin --fps 1 --report out.json -q").expect(0);
    let report: Value = serde_json::from_slice(&place.read("out.json")).unwrap();
    let slow = place.residual(&report["skeleton"], "arm.glb", 0);
    // As many frames as there are keys tell no less.
    let told = place.skeleton("arm.glb", "");
    assert!((place.residual(&told, "arm.glb", 0) - slow).abs() < 5e-4, "{told}, {slow}");
}

#[test]
fn a_key_of_the_preset_that_files_cannot_tell_from_a_frame_is_that_frame() {
    let place = Place::new();
    place.write("arm.glb", arm(0.3).to_glb().unwrap());
    let goal = "goal: Keys([(0, (2, 0, 0)), (64.000002, (1.1, 1.1, 0.4)), (65, (2, 0, 0))])";
    place.write("limb.ron", format!("Ik({OWN}, {goal})"));
    for bake in ["skin", "keys"] {
        let frames = "--fps 1000 --frames 63998..64003";
        place.run(&format!("apply limb.ron arm.glb -o out.glb --bake {bake} {frames} -q")).expect(0);
    }
}

#[test]
fn bones_that_only_turn_are_exact_between_joints() {
    let place = Place::new();
    place.write("arm.glb", arm(0.0).to_glb().unwrap());
    place.write("limb.ron", limb(OWN, "elasticity: 0, volume: 0"));
    place.skeleton("arm.glb", "");
    let glb = place.read("out.glb");
    for frame in 0..=FPS {
        let now = played(&glb, 0, frame as f64 / FPS as f64);
        let (rest, still) = (place.frame_of("arm.glb", 0), place.frame_of("arm.glb", frame));
        // The curve is rounded near the elbow, and the first ring hangs on the body too: a share of a turn is a turn by a share to the
        // effect, and a share of the way to a skin.
        let away = |x: f64| (0.05..0.74).contains(&x) || x > 1.26;
        let bones = rest.iter().zip(now.iter().zip(&still)).filter(|(p, _)| away(p.x));
        let off = bones.map(|(_, (a, b))| a.distance(*b)).fold(0.0, f64::max);
        assert!(off < 1e-5 * 2.7, "frame {frame}: {off}");
    }
}

/// The sleeve on a body in its middle and an arm to each side, with a clip in which the body turns.
fn two_arms() -> Gltf {
    let mut gltf = bare();
    let rest = gltf.rest().unwrap();
    let joint = |name, parent, x: f32| NewJoint::at(name, parent, [x, 0.0, 0.0]);
    let joints = [
        joint("body", None, 0.85),
        joint("upper.r", Some(0), 0.25),
        joint("lower.r", Some(1), 0.5),
        joint("hand.r", Some(2), 0.5),
        joint("upper.l", Some(0), -0.25),
        joint("lower.l", Some(4), -0.5),
        joint("hand.l", Some(5), -0.5),
    ];
    let (mut indices, mut weights) = (Vec::new(), Vec::new());
    for [x, ..] in &rest.positions {
        let along = (x - 0.85).abs() + 1e-4;
        let border = ((along - 0.25) / 0.5).round().clamp(0.0, 2.0);
        let part = ((along - 0.25 - 0.5 * border) / 0.2 + 0.5).clamp(0.0, 1.0);
        let side = |joint: f32| if joint > 0.0 && *x < 0.85 { joint as u16 + 3 } else { joint as u16 };
        indices.extend([side(border), side(border + 1.0)]);
        weights.extend([1.0 - part, part]);
    }
    let skin = NewSkin { name: "arms", joints: &joints, each: 2, indices: &indices, weights: &weights };
    gltf.add_skin(&rest, &[0], &skin).unwrap();
    let turn = |angle: f32| [0.0, (angle / 2.0).sin(), 0.0, (angle / 2.0).cos()];
    let node = (0..9).find(|&node| gltf.node_name(node) == Some("body")).unwrap();
    let rotations = vec![turn(0.0), turn(0.3), turn(-0.2)];
    let joints = [JointTrack { node, rotations, ..JointTrack::default() }];
    let tracks = Tracks { times: &[0.0, 0.5, 1.0], joints: &joints, ..Tracks::default() };
    gltf.add_tracks(&Clip::New("turn".into()), &tracks).unwrap();
    gltf
}

#[test]
fn two_limbs_are_one_skeleton() {
    let place = Place::new();
    place.write("arms.glb", two_arms().to_glb().unwrap());
    let reach = |side: &str, [from, to]: [&str; 2]| {
        format!(
            "Ik(chain: Skin(root: \"upper.{side}\", tip: \"hand.{side}\"), influence: SkinWeights, elasticity: 0.4,
                goal: Keys([(0, {from}), (1, {to})]))"
        )
    };
    let right = reach("r", ["(2.1, 0, 0)", "(1.5, 0.6, 0.3)"]);
    let left = reach("l", ["(-0.4, 0, 0)", "(-0.7, 0.3, -0.5)"]);
    place.write("limb.ron", &right);
    let rest = place.frame_of("arms.glb", 0);
    for joints in [0, 3] {
        let options = format!("--joints {joints}");
        let [of_left, of_right] = [&left, &right].map(|preset| {
            place.write("limb.ron", preset);
            let told = place.skeleton("arms.glb", &options);
            let glb = place.read("out.glb");
            (told, (0..=FPS).map(|frame| played(&glb, 1, frame as f64 / FPS as f64)).collect::<Vec<_>>())
        });
        place.write("limb.ron", format!("Stack([{left}, {right}])"));
        let told = place.skeleton("arms.glb", &options);
        for field in ["joints", "made"] {
            let [a, b, both] = [&of_left.0, &of_right.0, &told].map(|told| told[field].as_u64().unwrap());
            assert_eq!(both, a + b, "{field}");
        }
        let residual = place.residual(&told, "arms.glb", 1);
        let alone = [&of_left.0, &of_right.0].map(|told| told["residual"].as_f64().unwrap());
        assert!((residual - alone[0].max(alone[1])).abs() < 1e-5, "{residual}, alone {alone:?}");
        // Each side is as its limb alone has it.
        let glb = place.read("out.glb");
        for frame in 0..=FPS {
            let both = played(&glb, 1, frame as f64 / FPS as f64);
            for (v, place) in both.iter().enumerate() {
                let own = if rest[v].x < 0.85 { &of_left.1 } else { &of_right.1 };
                let off = own[frame][v].distance(*place);
                assert!(off < 1e-5, "{joints} joints, frame {frame}, vertex {v}: {off}");
            }
        }
    }
}

#[test]
fn what_hangs_below_the_chain_goes_where_the_limb_takes_it() {
    let Some(path) = shared("rigged/robot.glb") else { return };
    let place = Place::new();
    let input = path.to_str().unwrap();
    // The tip is one of three palms that hang on the lower arm, at one place.
    place.write(
        "limb.ron",
        "Ik(chain: Skin(root: \"UpperArm.L\", tip: \"Palm2.L\"), influence: SkinWeights,
            goal: Keys([(0, (2.69, 2.449, -0.032)), (1, (1.8, 3.7, 0.9))]))",
    );
    let residual = |options: &str| place.skeleton(input, options)["residual_of_diagonal"].as_f64().unwrap();
    let residuals = ["", "--joints 3", "--joints 7"].map(residual);
    assert!(residuals[0] < 0.04, "{residuals:?}");
    assert!(residuals[1] < 0.5 * residuals[0] && residuals[2] < 0.6 * residuals[1], "{residuals:?}");
}

#[test]
fn what_no_skeleton_can_do_is_refused() {
    let place = Place::new();
    place.write("arm.glb", arm(0.3).to_glb().unwrap());
    let lift = "Deform(wires: [Wire(curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 0.5, \
                pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.5, 0), (1, 0.5, 0)])]))])";
    let folds = "Wrinkle(creases: 2)";
    let own = limb(OWN, "");
    let limb = limb(MADE, "");
    for (name, preset, found) in [
        ("folds.ron", folds.to_owned(), "`Wrinkle`"),
        ("stack.ron", format!("Stack([{limb}, {lift}])"), "`Ik` of `Joints`, `Deform`"),
        ("before.ron", format!("Stack([{lift}, {limb}])"), "`Deform`, `Ik` of `Joints`"),
        ("two.ron", format!("Stack([{limb}, {limb}])"), "`Ik` of `Joints`, `Ik` of `Joints`"),
        ("mixed.ron", format!("Stack([{own}, {limb}])"), "`Ik` of `Skin`, `Ik` of `Joints`"),
    ] {
        place.write(name, preset);
        let told =
            place.run(&format!("apply {name} arm.glb -o out.glb --bake skin --frames 0..3")).expect(2).err();
        let said = format!(
            "found {found}, expected one `Ik`, or more of them if all are of `Skin`, or one `Deform`"
        );
        assert!(told.contains(&said), "{name}: {told}");
        assert!(!place.files().contains(&"out.glb".to_owned()), "{name}");
    }
    let forearm = own.replace("root: \"upper\"", "root: \"lower\"").replace("(2, 0, 0)", "(2, 0, 0.1)");
    place.write("limb.ron", format!("Stack([{own}, {forearm}])"));
    let told = place.run("apply limb.ron arm.glb -o out.glb --bake skin").expect(2).err();
    assert!(told.contains("limbs 0 and 1 both take joint \"lower\" along"), "{told}");
    place.write("limb.ron", &limb);
    // What has a skin of its own gets no second one.
    let told = place.run("apply limb.ron arm.glb -o out.glb --bake skin").expect(3).err();
    assert!(told.contains("have no skin"), "{told}");
    place.run("apply limb.ron arm.glb -o out.glb --bake skin --joints 65").expect(2);
    for what in ["out.glb --at 0.5", "out.obj --at 0.5", "out_####.obj"] {
        let told = place.run(&format!("apply limb.ron arm.glb -o {what} --bake skin")).expect(2).err();
        assert!(told.contains("`--bake skin` writes tracks of joints"), "{what}: {told}");
    }
    let told = place.run("apply limb.ron arm.glb -o out.glb --joints 3").expect(2).err();
    assert!(told.contains("it needs `--bake skin`"), "{told}");
    assert!(place.files().iter().all(|file| !file.starts_with("out")), "{:?}", place.files());
}

#[test]
fn threads_change_no_byte() {
    let place = Place::new();
    place.write("arm.glb", waving().to_glb().unwrap());
    place.write("bare.glb", bare().to_glb().unwrap());
    for (input, chain) in [("arm.glb", OWN), ("bare.glb", MADE)] {
        place.write("limb.ron", limb(chain, ""));
        let bytes = ["1", "2"].map(|threads| {
            place.skeleton(input, &format!("--joints 4 --threads {threads}"));
            place.read("out.glb")
        });
        assert!(bytes[0] == bytes[1], "{input}");
    }
}
