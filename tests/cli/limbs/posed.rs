//! Limbs of a skin, over the clip that poses it.

use glam::DVec3;

use super::apart;
use super::made::{ARM, SECONDS, TARGET, figure, middle, played, ring, shoulder, target, trunk};
use crate::document::{Document, chunks, glb, list};
use crate::place::Place;
use crate::wrinkles::vertices;

/// How far frames may be off that are written as they are, in metres of a figure of 1.5 m.
const FRAMES: f64 = 2e-5;

fn arm(goal: &str, fields: &str) -> String {
    format!("Ik(chain: Skin(root: \"upper\", tip: \"hand\"), influence: SkinWeights, goal: {goal}, {fields})")
}

fn place() -> Place {
    let place = Place::new();
    place.write("figure.glb", figure(true).glb());
    place.write("still.glb", figure(false).glb());
    place
}

/// Applies a preset to the figure; gives the input and the result.
fn applied(place: &Place, preset: &str, more: &str) -> [Vec<u8>; 2] {
    place.write("arm.ron", preset);
    place.run(&format!("apply arm.ron figure.glb -o out.glb -q {more}")).expect(0);
    ["figure.glb", "out.glb"].map(|name| place.read(name))
}

#[test]
fn a_hand_gets_to_its_goal_wherever_a_clip_has_the_arm() {
    let place = place();
    for (elasticity, more, clip) in [
        (0.0, "--bake frames --fps 8", "wirework"),
        (0.0, "--bake frames --fps 8 --into swing", "swing"),
        (1.0, "--bake frames --fps 8 --into swing", "swing"),
        (0.5, "--fps 8", "wirework"),
    ] {
        let preset = arm("Node(\"target\")", &format!("elasticity: {elasticity}"));
        let [old, new] = applied(&place, &preset, more);
        // The default tolerance is a ten thousandth of the diagonal.
        let close = if more.contains("frames") { FRAMES } else { 2e-4 };
        for frame in 0..=16 {
            let t = f64::from(frame) / 8.0;
            let (before, after) = (played(&old, Some("swing"), t), played(&new, Some(clip), t));
            let hand = middle(&after, &ring(0.8));
            assert!(
                hand.distance(target(t)) < close,
                "{elasticity} {more} at {t} s: {hand}, not {}",
                target(t)
            );
            assert!(middle(&before, &ring(0.8)).distance(target(t)) > 0.05, "the clip alone is elsewhere");
            for v in trunk() {
                assert!(before[v] == after[v], "{more} at {t} s: vertex {v} of the trunk moves");
            }
        }
    }
}

#[test]
fn bones_of_a_clip_keep_their_length_when_rigid() {
    let place = place();
    let [_, new] =
        applied(&place, &arm("Node(\"target\")", "elasticity: 0"), "--bake frames --fps 4 --into swing");
    let bone = ARM[0].distance(ARM[1]);
    for frame in 0..=8 {
        let now = played(&new, Some("swing"), f64::from(frame) / 4.0);
        // Between rings of one bone, away from the elbow, which the clip's weights spread.
        for (from, to) in [(0.35, 0.4), (0.6, 0.65)] {
            let [a, b] = [from, to].map(|x| middle(&now, &ring(x)));
            assert!(
                (a.distance(b) / (bone * 0.05 / 0.3) - 1.0).abs() < 0.02,
                "frame {frame}: {}",
                a.distance(b)
            );
        }
    }
}

#[test]
fn a_shoulder_is_between_what_moves_and_what_does_not() {
    let place = place();
    for goal in ["Node(\"target\")", "(0.5, 1.6, 0.2)"] {
        let [old, new] = applied(&place, &arm(goal, "elasticity: 0"), "--bake frames --fps 4");
        let whole = arm(goal, "elasticity: 0").replace("SkinWeights", "All");
        let [_, all] = applied(&place, &whole, "--bake frames --fps 4");
        let mut moved = 0;
        for frame in 0..=8 {
            let t = f64::from(frame) / 4.0;
            let before = played(&old, Some("swing"), t);
            let [some, full] = [&new, &all].map(|glb| played(glb, Some("wirework"), t));
            for v in shoulder() {
                let [part, full] = [&some, &full].map(|now| now[v].distance(before[v]));
                if full > 1e-3 {
                    assert!(part > 0.0 && part < full, "vertex {v} at {t} s: {part} of {full}");
                    moved += 1;
                }
            }
            // All of the weight of what is farther down is the arm's.
            for x in [0.35, 0.5, 0.9] {
                for v in ring(x) {
                    assert!(some[v].distance(full[v]) < FRAMES, "vertex {v} at {t} s");
                }
            }
        }
        assert!(moved > 100, "{moved}");
    }
}

/// All that morph targets and weights of a document may move, as one number.
fn most(glb: &Document) -> f64 {
    let primitives = list(&glb.json, "meshes").iter().flat_map(|mesh| list(mesh, "primitives"));
    let targets = primitives.flat_map(|primitive| list(primitive, "targets"));
    let deltas = targets.filter_map(|target| target.get("POSITION")).flat_map(|p| glb.elements(p).concat());
    deltas.map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn a_goal_that_is_the_hand_itself_changes_nothing() {
    let place = place();
    for fields in
        ["elasticity: 0", "elasticity: 0.6, pole: (0, 9, 3)", "elasticity: 1, curve: Chain, scale_by: Local"]
    {
        for more in ["--bake frames", "", "--into swing"] {
            applied(&place, &arm("Node(\"hand\")", fields), more);
            let found = most(&Document::open(&place.path("out.glb")));
            assert!(found == 0.0, "{fields} {more}: {found}");
        }
    }
    // What does move is seen so.
    applied(&place, &arm("Node(\"target\")", ""), "--bake frames");
    assert!(most(&Document::open(&place.path("out.glb"))) > 0.1);
}

#[test]
fn stills_and_sequences_show_the_clip_and_the_effect() {
    let place = place();
    let preset = arm("Node(\"target\")", "elasticity: 0.3");
    let [old, new] = applied(&place, &preset, "--bake frames --fps 4 --into swing");
    place.run("apply arm.ron figure.glb -o still.obj --at 0.75 -q").expect(0);
    place.run("apply arm.ron figure.glb -o still.glb --at 0.75 -q").expect(0);
    place.run("apply arm.ron figure.glb -o f####.obj --fps 4 -q").expect(0);
    place.run("apply arm.ron figure.glb -o g####.obj --fps 4 --frames 3..4 -q --threads 1").expect(0);
    let shown = played(&new, Some("swing"), 0.75);
    assert!(apart(&shown, &played(&old, Some("swing"), 0.75)) > 0.05, "the effect is seen");
    assert!(apart(&shown, &played(&old, None, 0.0)) > 0.1, "the clip is seen");
    let still = vertices(&place.read("still.obj"));
    assert!(apart(&still, &shown) < FRAMES, "{}", apart(&still, &shown));
    assert!(place.read("f0003.obj") == place.read("still.obj"));
    assert!(place.read("g0003.obj") == place.read("still.obj"));
    let held = played(&place.read("still.glb"), None, 0.0);
    assert!(apart(&held, &shown) < FRAMES, "{}", apart(&held, &shown));
}

#[test]
fn what_follows_a_skin_depends_on_no_other_frame_and_no_thread() {
    let place = place();
    let preset =
        arm("Curve(BSpline(points: [(0.5, 1.5, 0.3), (0.2, 1.9, 0.1), (0.9, 1.0, 0.3)]))", "elasticity: 0.3");
    applied(&place, &preset, "--threads 1 --fps 12");
    let one = place.read("out.glb");
    applied(&place, &preset, "--threads 2 --fps 12");
    assert!(one == place.read("out.glb"));
    place.run("apply arm.ron figure.glb -o f####.obj --fps 3 -q").expect(0);
    for k in 0..=6 {
        let still = place.of(&preset, "figure.glb", f64::from(k) / 3.0);
        assert!(still == vertices(&place.read(&format!("f{k:04}.obj"))), "frame {k}");
    }
}

#[test]
fn a_goal_that_stands_still_holds_the_hand_while_the_body_moves() {
    let place = place();
    let goal = DVec3::new(0.55, 1.3, 0.3);
    let [_, new] = applied(&place, &arm("(0.55, 1.3, 0.3)", ""), "--bake frames --fps 8 --into swing");
    let at = |t: f64| played(&new, Some("swing"), t);
    for frame in 0..=16 {
        let hand = middle(&at(f64::from(frame) / 8.0), &ring(0.8));
        assert!(hand.distance(goal) < FRAMES, "frame {frame}: {hand}");
    }
    assert!(middle(&at(0.5), &trunk()).distance(middle(&at(1.5), &trunk())) > 0.05, "the body moves");
}

#[test]
fn without_a_clip_joints_and_goals_are_where_they_rest() {
    let place = place();
    let preset = arm("Node(\"target\")", "elasticity: 0");
    let now = place.of(&preset, "still.glb", 0.0);
    let hand = middle(&now, &ring(0.8));
    assert!(hand.distance(TARGET[0]) < FRAMES, "{hand}");
    let rest = place.untouched("still.glb", 0.0);
    assert!(trunk().iter().all(|&v| now[v] == rest[v]));
    assert!(apart(&place.of(&arm("Node(\"hand\")", ""), "still.glb", 0.0), &rest) == 0.0);
    // The clip says how long it lasts, and which it is can be said.
    place.write("arm.ron", preset);
    let told = place.run("apply arm.ron figure.glb --dry-run --fps 10").expect(0).err();
    assert!(told.contains(&format!("{} frames", 10.0 * SECONDS + 1.0)), "{told}");
    let told = place.run("apply arm.ron figure.glb -o no.glb --clip swnig").expect(2).err();
    assert!(told.contains("swing"), "{told}");
    assert!(!place.files().contains(&"no.glb".to_owned()));
}

#[test]
fn a_goal_moves_with_its_node_though_the_joints_are_the_presets_own() {
    let place = place();
    let joints: Vec<String> = ARM.iter().map(|joint| super::point(*joint)).collect();
    let fields = "only: Joints([\"upper\", \"fore\", \"hand\"]), elasticity: 0";
    let preset = format!("Ik(chain: Joints([{}]), goal: Node(\"target\"), {fields})", joints.join(", "));
    let mut still = figure(true);
    // Only the target moves.
    let animation = &mut still.json["animations"][0];
    animation["channels"] = serde_json::json!([animation["channels"][4]]);
    place.write("figure.glb", still.glb());
    let [old, new] = applied(&place, &preset, "--bake frames --fps 4");
    for frame in 0..=8 {
        let t = f64::from(frame) / 4.0;
        let (before, after) = (played(&old, Some("swing"), t), played(&new, Some("wirework"), t));
        let hand = middle(&after, &ring(0.8));
        assert!(hand.distance(target(t)) < FRAMES, "at {t} s: {hand}, not {}", target(t));
        assert!(trunk().iter().all(|&v| before[v] == after[v]));
    }
}

#[test]
fn what_a_limb_is_put_into_is_what_it_starts_from() {
    let place = place();
    place.write("arm.ron", arm("Node(\"target\")", "elasticity: 0"));
    // A model of two clips: the first one goes in steps.
    let (mut json, bin) = chunks(&place.read("figure.glb"));
    let mut still = json["animations"][0].clone();
    still["name"] = "steps".into();
    for sampler in still["samplers"].as_array_mut().unwrap() {
        sampler["interpolation"] = "STEP".into();
    }
    json["animations"].as_array_mut().unwrap().insert(0, still);
    place.write("two.glb", glb(&json, bin.as_deref()));
    let run = |more: &str| {
        place.run(&format!("apply arm.ron two.glb -o out.glb -q --fps 8 {more}")).expect(0);
        place.read("out.glb")
    };
    assert!(run("--into swing") == run("--into swing --clip swing"));
    assert!(run("--into swing") != run("--into steps"));
    let told = place.run("apply arm.ron two.glb -o no.glb --into swing --clip steps").expect(2).err();
    assert!(told.contains("another clip than `--clip`"), "{told}");
    // The hand is at its goal in the clip that it was put into.
    let new = run("--into swing");
    for t in [0.25, 1.0, 1.5] {
        assert!(middle(&played(&new, Some("swing"), t), &ring(0.8)).distance(target(t)) < 2e-4, "{t}");
    }
}

#[test]
fn a_clip_that_ends_before_the_effect_is_told() {
    let place = place();
    let preset = |seconds: f64| {
        arm(&format!("Keys([(0, (0.6, 1.2, 0)), ({seconds}, (0.5, 1.3, 0))])"), "elasticity: 0")
    };
    place.write("long.ron", preset(SECONDS + 1.0));
    let told = place.run("apply long.ron figure.glb -o out.glb --fps 4").expect(0).err();
    assert!(told.contains("[clip-ends]"), "{told}");
    place.write("as_long.ron", preset(SECONDS));
    let told = place.run("apply as_long.ron figure.glb -o out.glb --fps 4").expect(0).err();
    assert!(!told.contains("[clip-ends]"), "{told}");
    // A limb of a skin that all of it follows is hardly meant.
    let all = preset(1.0).replace("influence: SkinWeights, ", "");
    place.write("all.ron", all);
    let told = place.run("check all.ron").expect(0).err();
    assert!(told.contains("`influence: SkinWeights` is for that"), "{told}");
}
