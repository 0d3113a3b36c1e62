//! What cannot be a limb: a clear word at its place in the preset, the right exit code, and nothing written.

use super::made::figure;
use super::object;
use crate::place::Place;
use crate::stitches::faults::{refused, refused_on};

/// A limb of the tube with these fields on a line of their own.
fn with(fields: &str) -> String {
    format!(
        "Ik(\n    object: {},\n    chain: Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]),\n    goal: (2, 1, 0),\n    {fields},\n)",
        object()
    )
}

fn chain(chain: &str) -> String {
    format!("Ik(\n    object: {},\n    chain: {chain},\n    goal: (2, 1, 0),\n)", object())
}

/// A limb of the figure with these fields on a line of their own.
fn skin(fields: &str) -> String {
    format!("Ik(\n    {fields},\n)")
}

/// Applies it to the figure.
#[track_caller]
fn refused_on_figure(marked: &str, words: &[&str]) {
    let place = Place::new();
    place.write("figure.glb", figure(true).glb());
    refused_on(&place, marked, "figure.glb", words);
}

const ARM: &str = "chain: Skin(root: \"upper\", tip: \"hand\")";

#[test]
fn chains_without_bones_are_refused() {
    for (joints, word) in [
        ("«[]»", "a chain of no joints"),
        ("«[(0, 0, 0)]»", "a chain of one joint has no bone"),
        ("[(0, 0, 0), «(0, 0, 0)»]", "joint 1 lies on joint 0"),
        ("[(0, 0, 0), (1, 0, 0), «(1, 0, -0.0)»]", "joint 2 lies on joint 1"),
        ("[(0, 0, 0), (1e30, 0, 0), «(1e30, 1, 0)»]", "joint 2 all but lies on joint 1"),
        ("[(0, 0, 0), (1, «NaN», 0)]", "`chain` must be a finite number"),
        ("[(0, 0, 0), (1, «inf», 0)]", "`chain` must be a finite number"),
        ("[(0, 0, 0), (1, «1e39», 0)]", "chain"),
    ] {
        refused(&chain(&format!("Joints({joints})")), &[word, "chain"]);
    }
    // Joints of a model, too: one at its parent's place.
    let place = Place::new();
    let mut flat = figure(false);
    flat.json["nodes"][3]["translation"] = serde_json::json!([0, 0, 0]);
    place.write("flat.glb", flat.glb());
    let marked = "Ik(\n    goal: (1, 1, 1),\n    chain: «Skin»(root: \"upper\", tip: \"hand\"),\n)";
    refused_on(&place, marked, "flat.glb", &["joint 1 is at the place of joint 0", "chain"]);
}

#[test]
fn a_skin_is_one_from_a_joint_down_to_another() {
    let place = Place::new();
    place.write("figure.glb", figure(true).glb());
    for (chain, words) in [
        ("Skin(root: \"upper\", tip: «\"upper\"»)", &["a chain of one joint has no bone"][..]),
        ("Skin(root: «\"uper\"», tip: \"hand\")", &["figure.glb", "\"uper\"", "did you mean \"upper\"?"]),
        ("Skin(root: \"upper\", tip: «\"hnad\"»)", &["figure.glb", "\"hnad\"", "did you mean \"hand\"?"]),
        (
            "Skin(root: \"hand\", tip: «\"upper\"»)",
            &["\"upper\" is not below \"hand\"", "the other way round"],
        ),
        ("Skin(root: \"target\", tip: «\"hand\"»)", &["\"hand\" is not below \"target\""]),
        ("Skin(root: \"fore\", tip: «\"target\"»)", &["\"target\" is not below \"fore\""]),
    ] {
        refused_on(&place, &skin(&format!("goal: (1, 1, 1), chain: {chain}")), "figure.glb", words);
    }
    place.write("fault.ron", skin("goal: (1, 1, 1), chain: Skin(root: \"target\", tip: \"hand\")"));
    let told = place.run("apply fault.ron figure.glb --dry-run").expect(4).err();
    assert!(!told.contains("the other way round"), "that would help nothing: {told}");
    for influence in ["influence: All", "influence: SkinWeights"] {
        let chain = "chain: Skin(root: \"uper\", tip: \"hand\")";
        place.write("fault.ron", format!("Ik({chain}, goal: (1, 1, 1), {influence})"));
        let told = place.run("apply fault.ron figure.glb --dry-run").expect(4).err();
        assert_eq!(told.matches("figure.glb: ").count(), 1, "{influence}: {told}");
    }
}

#[test]
fn chains_and_goals_of_a_model_need_one() {
    let place = Place::new();
    place.write("tube.obj", place.tube_at_rest());
    let chain = skin("goal: (1, 1, 1), chain: «Skin»(root: \"upper\", tip: \"hand\")");
    let goal = skin("chain: Joints([(0, 0, 0), (3, 0, 0)]), goal: «Node(\"hand\")»");
    let own = |text: &str| text.replacen("Ik(", &format!("Ik(object: {}, ", object()), 1);
    refused_on(&place, &chain, "tube.obj", &["the object has no joints", "chain"]);
    refused(&own(&chain), &["the object has no joints", "chain"]);
    // A node is named.
    let goal = goal.replace("«Node(\"hand\")»", "«Node»(\"hand\")");
    for err in [place.run_on("tube.obj", &goal), place.run_on("", &own(&goal))] {
        assert!(err.contains("the object has no nodes") && err.contains("goal"), "{err}");
        assert!(err.contains("fault.ron:2:"), "{err}");
    }
    let unknown = skin(&format!("{ARM}, goal: Node(«\"tagret\"»)"));
    refused_on_figure(&unknown, &["figure.glb", "\"tagret\"", "did you mean \"target\"?"]);
}

impl Place {
    /// What is said of a preset that is refused, marks aside.
    #[track_caller]
    fn run_on(&self, input: &str, marked: &str) -> String {
        self.write("fault.ron", marked.replace(['«', '»'], ""));
        let files = self.files();
        let err = self.run(&format!("apply fault.ron {input} -o out.glb")).expect(4).err();
        assert_eq!(self.files(), files, "nothing is written");
        err
    }
}

#[test]
fn numbers_that_are_none_are_refused_at_their_place() {
    let goal = |goal: &str| with("volume: 1").replace("goal: (2, 1, 0)", &format!("goal: {goal}"));
    refused(&goal("(0, «NaN», 0)"), &["`goal` must be a finite number"]);
    refused(&goal("(«-inf», 0, 0)"), &["`goal` must be a finite number"]);
    refused(&goal("Keys([(0, (0, 0, 0)), (1, (0, 0, «inf»))])"), &["`goal` must be a finite number"]);
    refused(&goal("Curve(«Polyline([(1, 0, 0)])»)"), &["a single point"]);
    for (fields, word) in [
        ("elasticity: «1.5»", "elasticity"),
        ("elasticity: Keys([(0, 0), (1, «-0.1»)])", "elasticity"),
        ("stiffness: [0, «1.01», 0]", "stiffness[1]"),
        ("stiffness: [0, «-1», 0]", "stiffness[1]"),
        ("stiffness: «[0, 1]»", "this chain has 3, found 2"),
        ("stiffness: «[0, 1, 0, 0]»", "this chain has 3, found 4"),
        ("limits: «[10]»", "limits"),
        ("limits: [10, «0», 10]", "limits[1]"),
        ("limits: [10, «181», 10]", "limits[1]"),
        ("pins: [(«3», (0, 0, 0))]", "the tip, which has the goal"),
        ("pins: [(«9», (0, 0, 0))]", "joints 0 to 2"),
        ("pins: [(1, (0, 0, 0)), («1», (0, 0, 0))]", "joint 1 is pinned before"),
        ("pins: [(1, (0, «NaN», 0))]", "pins[0]"),
        ("pole: (0, «inf», 0)", "pole"),
        ("max_stretch: «0.9»", "max_stretch"),
        ("min_stretch: «1.1»", "min_stretch"),
        ("softness: «-0.1»", "softness"),
        ("volume: «2»", "volume"),
        ("twist: «NaN»", "twist"),
        ("curve: Rounded(«0.6»)", "curve"),
        ("curve: Rounded(«0»)", "curve"),
        ("influence: Radius(«0»)", "influence"),
        ("influence: «SkinWeight»", "did you mean `SkinWeights`?"),
        ("«elastcity»: 1", "did you mean `elasticity`?"),
    ] {
        refused(&with(fields), &[word]);
    }
}

#[test]
fn what_does_not_fit_the_joints_of_a_model_is_refused_when_they_are_known() {
    let goal = "goal: (0.5, 1.5, 0.3)";
    for (fields, words) in [
        ("stiffness: «[0.5]»", &["1 value", "2, one a bone"][..]),
        ("stiffness: «[0, 0, 0.5]»", &["3 values", "2, one a bone"]),
        ("limits: «[10, 20, 30, 40]»", &["4 values"]),
        ("pins: [«(2, (0, 0, 0))»]", &["holds joint 2", "the tip has the goal"]),
        ("pins: [«(7, (0, 0, 0))»]", &["holds joint 7", "joints 0 to 1"]),
    ] {
        refused_on_figure(&skin(&format!("{ARM}, {goal},\n    {fields}")), words);
    }
    refused_on_figure(
        &skin(&format!("{ARM}, {goal},\n    stiffness: [0, «1.5»]")),
        &["stiffness[1]", "from 0 to 1"],
    );
    // Weights are of joints of a model.
    let marked = format!("Ik(chain: Joints([(0, 0, 0), (1, 0, 0)]), {goal},\n    influence: «SkinWeights»)");
    refused_on_figure(&marked, &["`SkinWeights` are those of joints of a model", "chain: Skin(..)"]);
    refused(&with("influence: «SkinWeights»"), &["`SkinWeights` are those of joints of a model"]);
}

#[test]
fn check_inspect_and_render_tell_of_limbs() {
    let place = Place::new();
    place.write("limb.ron", with("elasticity: Keys([(0, 0), (1.5, 1)])"));
    assert_eq!(place.run("check limb.ron --strict").expect(0).err(), "limb.ron: ok\n");
    let table = place.run("inspect limb.ron").expect(0).out();
    assert_eq!(table, "object       Tube\neffect 0     Ik: 1 wire\nduration     1.5 s\nanimated     yes\n");
    place.write("idle.ron", with("stiffness: [1, 1, 1], elasticity: 0"));
    let told = place.run("check idle.ron").expect(0).err();
    assert!(told.contains("`stiffness` has no effect with `elasticity` 0"), "{told}");
    place.run("check idle.ron --strict").expect(4);
    place.write("figure.glb", figure(true).glb());
    place.write("arm.ron", skin(&format!("{ARM}, goal: Node(\"target\"), influence: SkinWeights")));
    place.run("check arm.ron").expect(0);
    place.run("check arm.ron --on figure.glb").expect(0);
    place.write("bad.ron", skin(&format!("{ARM}, goal: Node(\"tagret\")")));
    let told = place.run("check bad.ron --on figure.glb").expect(4).err();
    assert!(told.contains("did you mean \"target\"?"), "{told}");
    place.run("render arm.ron figure.glb -o out.png --at 0.5 --fast --size 32x32 --wires").expect(0);
    assert!(place.read("out.png").starts_with(b"\x89PNG"));
}
