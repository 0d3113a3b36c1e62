//! `Ik`: what it says, and what is said about it where it is wrong or odd.

mod common;

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use common::{check, errors};
use wirework_core::{Closest, Curve, Keyed};
use wirework_ik::{ChainCurve, Ik, Influence, Pin, ScaleBy, Tip};
use wirework_preset::{
    Action, BoundsFrame, Chain, Effect, Goal, Limb, Limits, Parsed, PresetErrorKind, Units, parse,
};

fn parsed(text: &str) -> Parsed {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{text}\n{errors}"))
}

fn effect(text: &str) -> Effect {
    parsed(text).preset.effects.remove(0)
}

fn limb(text: &str) -> Limb {
    match effect(text).action {
        Action::Ik(limb) => *limb,
        other => panic!("{other:?}"),
    }
}

/// A limb of two bones with more fields.
fn with(fields: &str) -> String {
    format!(
        "Ik(\n  chain: Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0)]), goal: (2, 0, 0),\n  /* größe */ {fields},\n)"
    )
}

/// A limb of a skin with more fields.
fn of_skin(fields: &str) -> String {
    with(fields).replace("Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0)])", "Skin(root: \"arm\", tip: \"hand\")")
}

fn with_chain(chain: &str) -> String {
    format!("Ik(\n  goal: (2, 0, 0),\n  chain: {chain},\n)")
}

fn with_goal(goal: &str) -> String {
    format!("Ik(\n  chain: Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0)]),\n  goal: {goal},\n)")
}

fn keys<T: wirework_core::Interpolate>(keys: &[(f64, T)]) -> Keyed<T> {
    Keyed::keys(keys.to_vec(), false).expect("keys")
}

#[test]
fn what_is_left_out_is_the_default() {
    let chain = Chain::Joints(vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let goal = Goal::Point(Keyed::Constant([2.0, 0.0, 0.0]));
    let rest = Limb { chain, goal, ik: Ik::default() };
    let spelt_out = "version: 1, object: None, duration: None, only: None, mask: None, units: Metres, curve: Rounded(0.25), \
                     pole: Auto, elasticity: 0.5, stiffness: [], limits: [], pins: [], max_stretch: 2, min_stretch: 0.3, \
                     softness: 0.1, volume: 1, scale_by: Length, twist: 0, tip: Follow, influence: All, closest: Smallest";
    for fields in ["", spelt_out, "curve: Rounded"] {
        let parsed = parsed(&with(fields).replace("*/ ,", "*/"));
        let [effect] = parsed.preset.effects.as_slice() else { panic!() };
        assert_eq!(effect.action, Action::Ik(Box::new(rest.clone())), "{fields}");
        assert_eq!((effect.units, effect.refine), (Units::Metres, false));
        assert_eq!(parsed.warnings, []);
    }
}

#[test]
fn every_field_is_read() {
    let found = limb(
        "Ik(
            chain: Joints([(0, 0, 0), (1, 2, 3), (4, 5, 6), (7, 8, 9)]), goal: Ease([(0, (7, 8, 9)), (2, (1, 1, 1))]),
            curve: Chain, pole: Keys([(0, (0, 1, 0)), (1, (0, 2, 0))]), elasticity: Keys([(0, 0), (1, 1)]),
            stiffness: [0, 0.5, 1], limits: [45, 90, 180], pins: [(0, (1, 0, 0)), (2, Keys([(0, (4, 5, 6)), (3, (4, 5, 7))]))],
            max_stretch: 1.5, min_stretch: 0.25, softness: 0.75, volume: 0.125, scale_by: Local, twist: Keys([(0, 0), (1, 720)]),
            tip: Hold((90, -45, 0)), influence: Radius(0.375), closest: Blended(0.625), only: Joints([\"x\"]), units: Bounds,
        )",
    );
    let ease = Keyed::keys(vec![(0.0, [7.0, 8.0, 9.0]), (2.0, [1.0; 3])], true).expect("keys");
    assert_eq!(found.goal, Goal::Point(ease));
    let joints = vec![[0.0; 3], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]];
    assert_eq!(found.chain, Chain::Joints(joints));
    let settings = Ik {
        curve: ChainCurve::Chain,
        pole: Some(keys(&[(0.0, [0.0, 1.0, 0.0]), (1.0, [0.0, 2.0, 0.0])])),
        elasticity: keys(&[(0.0, 0.0), (1.0, 1.0)]),
        stiffness: vec![0.0, 0.5, 1.0],
        limits: vec![FRAC_PI_4, FRAC_PI_2, PI],
        pins: vec![
            Pin { joint: 0, point: Keyed::Constant([1.0, 0.0, 0.0]) },
            Pin { joint: 2, point: keys(&[(0.0, [4.0, 5.0, 6.0]), (3.0, [4.0, 5.0, 7.0])]) },
        ],
        max_stretch: 1.5,
        min_stretch: 0.25,
        softness: 0.75,
        volume: 0.125,
        scale_by: ScaleBy::Local,
        twist: keys(&[(0.0, 0.0), (1.0, 4.0 * PI)]),
        tip: Tip::Hold([FRAC_PI_2, -FRAC_PI_4, 0.0]),
        influence: Influence::Radius(0.375),
        closest: Closest::Blended(0.625),
    };
    assert_eq!(found.ik, settings);
}

#[test]
fn what_stands_alone_is_read() {
    for (fields, change) in [
        ("curve: Rounded(0.5)", Ik { curve: ChainCurve::Rounded(0.5), ..Ik::default() }),
        ("pole: (0, 1, 2)", Ik { pole: Some(Keyed::Constant([0.0, 1.0, 2.0])), ..Ik::default() }),
        ("limits: [90]", Ik { limits: vec![FRAC_PI_2], ..Ik::default() }),
        ("influence: SkinWeights", Ik { influence: Influence::SkinWeights, ..Ik::default() }),
        ("max_stretch: 1", Ik { max_stretch: 1.0, ..Ik::default() }),
        ("min_stretch: 1, softness: 1", Ik { min_stretch: 1.0, softness: 1.0, ..Ik::default() }),
        ("elasticity: 1", Ik { elasticity: Keyed::Constant(1.0), ..Ik::default() }),
        ("twist: -90", Ik { twist: Keyed::Constant(-FRAC_PI_2), ..Ik::default() }),
    ] {
        assert_eq!(limb(&of_skin(fields)).ik, change, "{fields}");
    }
    // The least angle there is stays greater than 0.
    assert_eq!(limb(&of_skin("limits: [1e-45]")).ik.limits, [f32::MIN_POSITIVE]);
}

#[test]
fn chains_of_a_skin_know_their_names() {
    let named = "Skin(root: «\"arm\"», tip: \"hand\")";
    for (chain, paths) in [
        (named, ["chain.root", "chain.tip"]),
        ("Skin((root: «\"arm\"», tip: \"hand\"))", ["chain.root", "chain.tip"]),
        ("Skin(«\"arm\"», \"hand\")", ["chain[0]", "chain[1]"]),
    ] {
        let text = with_chain(chain);
        let Chain::Skin { root, tip } = limb(&text.replace(['«', '»'], "")).chain else { panic!() };
        assert_eq!([root.name.as_str(), tip.name.as_str()], ["arm", "hand"]);
        let error = root.unknown("joint", &["Arm", "hand"]);
        let column = 1 + text.lines().nth(2).and_then(|line| line.find('«')).expect("a mark");
        assert_eq!((error.line, error.column, error.path.as_str()), (3, column, paths[0]), "{chain}");
        assert_eq!(tip.refused("it does not hang below").path, paths[1]);
    }
}

#[test]
fn a_goal_is_a_point_a_curve_or_a_node() {
    let text = with_goal("Node(\"target\")");
    let Goal::Node(name) = limb(&text).goal else { panic!() };
    let error = name.unknown("node", &["targets"]);
    assert_eq!((error.line, error.column, error.path.as_str()), (3, 14, "goal"));
    assert_eq!(error.help.as_deref(), Some("did you mean \"targets\"?"));
    let curve = Curve::polyline(vec![[2.0, 0.0, 0.0], [1.0, 1.0, 0.0]]).expect("a curve");
    for typed in
        ["Polyline([(2, 0, 0), (1, 1, 0)])", "Polyline(points: [(2, 0, 0), (1, 1, 0)], closed: false)"]
    {
        assert_eq!(limb(&with_goal(&format!("Curve({typed})"))).goal, Goal::Curve(curve.clone()));
    }
    let closed = limb(&with_goal(
        "Curve(BSpline(degree: 2, points: [(2, 0, 0), (1, 1, 0), (0, 1, 1)], closed: true))",
    ));
    assert!(matches!(closed.goal, Goal::Curve(curve) if curve.closed()));
}

#[test]
fn what_moves_is_as_long_as_its_last_key() {
    let of = |text: &str| {
        let preset = parsed(text).preset;
        (preset.duration, preset.animated, preset.follows_clip, preset.driven)
    };
    assert_eq!(of(&with("pole: (0, 1, 0), twist: 90")), (0.0, false, false, false), "a still");
    for field in [
        "elasticity: Keys([(0, 1), (2.5, 0.5)])",
        "twist: Keys([(0, 1), (2.5, 0.5)])",
        "pole: Keys([(0, (0, 1, 0)), (2.5, (0, 0, 1))])",
        "pins: [(0, (0, 0, 0)), (1, Ease([(0, (1, 0, 0)), (2.5, (1, 1, 0))]))]",
    ] {
        assert_eq!(of(&with(field)), (2.5, true, false, false), "{field}");
        assert_eq!(of(&of_skin(field)), (2.5, true, true, true), "{field}");
    }
    assert_eq!(of(&with("twist: Keys([(0, 1), (2.5, 1)])")), (2.5, false, false, false));
    let keyed = with_goal("Keys([(0, (2, 0, 0)), (3, (1, 0, 0))])");
    assert_eq!(of(&keyed), (3.0, true, false, false));
    let short = keyed.replace("Ik(", "Ik(duration: Some(2),");
    assert_eq!(of(&short), (2.0, true, false, false));
    assert_eq!(parsed(&short).warnings[0].path, "duration");
    // A curve takes the time there is.
    let curve = with_goal("Curve(Polyline([(2, 0, 0), (1, 1, 0)]))");
    assert_eq!(of(&curve), (2.0, true, false, false));
    assert_eq!(of(&curve.replace("Ik(", "Ik(duration: 5,")), (5.0, true, false, false));
    assert_eq!(of(&curve.replace("Ik(", "Ik(twist: Keys([(0, 0), (3, 1)]),")), (3.0, true, false, false));
    // A node and a skin, that of a clip.
    for text in [with_goal("Node(\"target\")"), of_skin("volume: 0.5")] {
        assert_eq!(of(&text), (0.0, false, true, true), "{text}");
        assert_eq!(of(&text.replace("Ik(", "Ik(duration: 5,")), (5.0, false, false, true), "{text}");
    }
}

#[test]
fn values_out_of_range_are_refused_at_the_value() {
    use PresetErrorKind::Value;
    for (field, message) in [
        ("elasticity: «1.5»", "`elasticity` must lie from 0 to 1, found 1.5"),
        ("elasticity: Keys([(0, 0), (1, «-0.5»)])", "`elasticity` must lie from 0 to 1, found -0.5"),
        ("elasticity: «NaN»", "`elasticity` must be a finite number"),
        ("stiffness: [0, «2»]", "`stiffness` must lie from 0 to 1, found 2"),
        ("stiffness: «1»", "a list of numbers, one a bone"),
        ("limits: [90, «0»]", "`limits` must be greater than 0 and at most 180, found 0"),
        ("limits: [«180.5», 90]", "greater than 0 and at most 180, found 180.5"),
        ("limits: [«NaN», 90]", "`limits` must be a finite number"),
        ("limits: «90»", "a list of degrees, one a joint"),
        ("max_stretch: «0.5»", "`max_stretch` must be 1 or greater, found 0.5"),
        ("max_stretch: «inf»", "`max_stretch` must be a finite number, found inf"),
        ("max_stretch: «1e39»", "`max_stretch` must be a finite number, found 1e39"),
        ("min_stretch: «-0.5»", "`min_stretch` must lie from 0 to 1"),
        ("min_stretch: «1.5»", "`min_stretch` must lie from 0 to 1"),
        ("softness: «-0.5»", "`softness` must lie from 0 to 1"),
        ("softness: «Keys([(0, 1)])»", "expected a number, found `Keys`"),
        ("volume: «1.5»", "`volume` must lie from 0 to 1"),
        ("scale_by: «1»", "expected `Length` or `Local`, found `1`"),
        ("scale_by: «Local(1)»", "`Local` stands alone"),
        ("twist: «1e7»", "`twist` must be within 1000000 degrees either way"),
        ("twist: Keys([(0, 0), (1, «inf»)])", "`twist` must be a finite number"),
        ("curve: Rounded(«0»)", "`fraction` must be greater than 0 and at most 0.5, found 0"),
        ("curve: Rounded(«0.75»)", "greater than 0 and at most 0.5, found 0.75"),
        ("curve: «Rounded(0.25, 0.25)»", "expected `Rounded(fraction)`"),
        ("curve: «Rounded(fraction: 0.25)»", "expected `Rounded(fraction)`"),
        ("curve: «Chain(1)»", "`Chain` stands alone"),
        ("curve: «0.25»", "expected `Rounded` or `Chain`, found `0.25`"),
        ("pole: (0, «NaN», 0)", "`pole` must be a finite number"),
        ("pole: Keys([(0, (0, 1, 0)), («0», (0, 1, 0))])", "must come after the one before"),
        ("pole: «1»", "a point `(x, y, z)`, found `1`"),
        ("pole: «Auto(1)»", "`Auto` stands alone"),
        ("tip: Hold((0, 0, «NaN»))", "`tip` must be a finite number"),
        ("tip: Hold((0, «1e7», 0))", "`tip` must be within 1000000 degrees"),
        ("tip: Hold(«(0, 0)»)", "expected degrees `(x, y, z)`, found 2 values"),
        ("tip: «Hold(0, 0, 0)»", "expected `Hold((x, y, z))`"),
        ("tip: «Hold»", "expected `Hold((x, y, z))`"),
        ("tip: «Follow(1)»", "`Follow` stands alone"),
        ("tip: «(0, 0, 0)»", "expected `Follow` or `Hold`"),
        ("influence: Radius(«0»)", "`radius` must be greater than 0, found 0"),
        ("influence: Radius(«NaN»)", "`radius` must be a finite number"),
        ("influence: «Radius»", "expected `Radius(r)`"),
        ("influence: «Radius(r: 1)»", "expected `Radius(r)`"),
        ("influence: «0.5»", "expected `All`, `Radius` or `SkinWeights`"),
        ("influence: «SkinWeights(1)»", "stands alone"),
        ("closest: Blended(«0»)", "`width` must be greater than 0"),
        ("closest: Blended(«Keys([(0, 1)])»)", "expected a number, found `Keys`"),
        ("closest: «Smallest(1)»", "stands alone"),
        ("duration: «0»", "`duration` must be greater than 0"),
        ("version: «0»", "at least 1"),
        ("only: «Joints([])»", "at least one name"),
    ] {
        check(&with(field), Value, message, None);
    }
    let place = &errors(&with("pins: [(0, (0, 0, 0)), (1, Keys([(0, (1, inf, 0))]))]"))[0];
    assert_eq!((place.line, place.column, place.path.as_str()), (3, 56, "pins[1][1][0][1]"));
}

#[test]
fn chains_are_refused_at_the_joint() {
    use PresetErrorKind::{Name, Value};
    for (chain, message) in [
        ("Joints(«[]»)", "a chain of no joints has no bone; it needs two joints or more"),
        ("Joints(«[(0, 0, 0)]»)", "a chain of one joint has no bone"),
        ("Joints([(0, 0, 0), (1, 0, 0), «(1, 0, 0)»])", "joint 2 lies on joint 1: a bone has a length"),
        ("Joints([(0, 0, 0), «(-0.0, 0, 0)», (1, 0, 0)])", "joint 1 lies on joint 0"),
        ("Joints([(0, 0, 0), «(0, 0, 0)»])", "joint 1 lies on joint 0"),
        ("Joints([(0, 0, 0), (1, 0, 0), «(1.0000005, 0, 0)», (1, 0, 1)])", "joint 2 all but lies on joint 1"),
        ("Joints([(-3e38, 0, 0), (3e38, 0, 0), «(3e38, 1, 0)»])", "joint 2 all but lies on joint 1"),
        ("Joints([(0, 0, 0), (1, «NaN», 0)])", "`chain` must be a finite number"),
        ("Joints([(0, 0, 0), «(1, 0)»])", "expected a point `(x, y, z)`, found 2 values"),
        ("Joints(«1»)", "a list of points"),
        ("«Joints»", "expected `Joints([(x, y, z), ..])`"),
        ("«Joints((0, 0, 0), (1, 0, 0))»", "expected `Joints([(x, y, z), ..])`"),
        ("«[(0, 0, 0), (1, 0, 0)]»", "expected `Joints([(x, y, z), ..])` or `Skin(root:"),
        ("«Skin»", "expected `Skin(root: \"name\", tip: \"name\")`"),
        ("«Skin(\"a\")»", "`Skin(field: value, ..)`"),
        ("Skin(\"a\", «1»)", "the name of a joint in quotes, found `1`"),
        ("Skin(root: «a», tip: \"b\")", "the name of a joint in quotes, found `a`"),
        (
            "Skin(root: \"a\", tip: «\"a\"»)",
            "a chain of one joint has no bone; `tip` is the joint at the other",
        ),
        ("Skin(\"a\", «\"a\"»)", "a chain of one joint has no bone"),
    ] {
        check(&with_chain(chain), Value, message, None);
    }
    for (chain, message, help) in [
        ("«Skin»(root: \"a\")", "`Skin` needs a field `tip`", None),
        ("«Skin»(tip: \"a\")", "`Skin` needs a field `root`", None),
        ("Skin(root: \"a\", tip: \"b\", «tips»: 1)", "`Skin` has no field `tips`", Some("`tip`")),
        ("«Joint»([(0, 0, 0), (1, 0, 0)])", "there is no chain `Joint`", Some("`Joints`")),
    ] {
        check(&with_chain(chain), Name, message, help);
    }
    // As near as this, and nearer where the chain is small, joints are two.
    for chain in [
        "[(0, 0, 0), (1, 0, 0), (1, 2e-6, 0)]",
        "[(0, 0, 0), (1e-40, 0, 0)]",
        "[(-3e38, 0, 0), (3e38, 0, 0)]",
    ] {
        assert_eq!(errors(&with_chain(&format!("Joints({chain})"))), [], "{chain}");
    }
    let all = errors(&with_chain("Joints([(0, 0, 0), (0, 0, 0), (1, 0, 0), (1, 0, 0)])"));
    assert_eq!(all.iter().map(|error| error.path.as_str()).collect::<Vec<_>>(), ["chain[1]", "chain[3]"]);
}

#[test]
fn goals_are_refused_at_the_value() {
    use PresetErrorKind::{Name, Value};
    for (goal, message) in [
        ("(0, «NaN», 0)", "`goal` must be a finite number"),
        ("Keys([(0, (0, 0, 0)), (1, (0, 0, «inf»))])", "`goal` must be a finite number"),
        ("«Keys([])»", "`Keys` needs at least one key"),
        ("«1»", "expected a point `(x, y, z)`, found `1`"),
        ("Curve(«Polyline([(1, 0, 0)])»)", "a goal goes along its curve, and this one is a single point"),
        ("Curve(«CatmullRom([(1, 0, 0), (1, 0, 0), (1, -0.0, 0)])»)", "a single point"),
        ("Curve(Polyline(«[]»))", "at least one control point"),
        ("Curve(«(1, 0, 0)»)", "expected a curve such as `BSpline("),
        ("«Curve»", "expected `Curve(..)` around a curve"),
        ("«Curve(points: [])»", "expected `Curve(..)` around a curve"),
        ("Node(«1»)", "the name of a node in quotes, found `1`"),
        ("«Node»", "expected `Node(\"name\")`"),
        ("«Node(\"a\", \"b\")»", "expected `Node(\"name\")`"),
    ] {
        check(&with_goal(goal), Value, message, None);
    }
    for (goal, message, help) in [
        ("«Nod»(\"a\")", "a point `(x, y, z)`, `Curve(..)`, `Node(\"name\")`, `Keys(", Some("`Node`")),
        ("«Kyes»([(0, (0, 0, 0))])", "or `Ease([..])`, found `Kyes`", Some("`Keys`")),
        ("«Polyline»([(0, 0, 0), (1, 0, 0)])", "stands in `Curve(..)`", Some("write `Curve(Polyline(..))`")),
        ("Curve(«Polylin»([(0, 0, 0), (1, 0, 0)]))", "no curve `Polylin`", Some("`Polyline`")),
    ] {
        check(&with_goal(goal), Name, message, help);
    }
}

#[test]
fn lists_fit_the_chain() {
    use PresetErrorKind::Value;
    for (field, message) in [
        ("stiffness: «[0]»", "`stiffness` has one number a bone; this chain has 2, found 1"),
        ("stiffness: «[0, 0, 1]»", "this chain has 2, found 3"),
        (
            "limits: «[90]»",
            "one angle a joint; this chain has 3, or 2 without the tip, which needs none; found 1",
        ),
        ("limits: «[90, 90, 90, 90]»", "found 4"),
        (
            "pins: [(«2», (2, 0, 0))]",
            "a pin holds one of joints 0 to 1 of this chain of 3, found `2`, the tip, which",
        ),
        ("pins: [(0, (0, 0, 0)), («7», (2, 0, 0))]", "joints 0 to 1 of this chain of 3, found `7`"),
        ("pins: [(1, (0, 0, 0)), (0, (0, 0, 0)), («1», (2, 0, 0))]", "joint 1 is pinned before this one"),
        ("pins: [(«-1», (2, 0, 0))]", "a whole number"),
        ("pins: [(«1.5», (2, 0, 0))]", "a whole number"),
        ("pins: [(1, «1»)]", "a point `(x, y, z)`, found `1`"),
        ("pins: [«(1, 0, 0)»]", "a pin `(joint, point)`, found 3 values"),
        ("pins: «(1, (0, 0, 0))»", "a list of pins"),
    ] {
        check(&with(field), Value, message, None);
    }
    let paths = |fields: &str| errors(&with(fields)).into_iter().map(|e| e.path).collect::<Vec<_>>();
    assert_eq!(paths("pins: [(0, (0, 0, 0)), (2, (2, 0, 0))]"), ["pins[1][0]"]);
    assert_eq!(paths("stiffness: [2]"), ["stiffness", "stiffness[0]"], "both are said");
    assert_eq!(paths("limits: [181]"), ["limits", "limits[0]"]);
    let one = with("pins: [(«1», (0, 0, 0))]").replace(", (2, 0, 0)])", "])");
    check(&one, Value, "a pin holds joint 0 of this chain of 2, found `1`, the tip", None);
    for good in
        ["stiffness: [0, 1], limits: [1, 2]", "limits: [1, 2, 3]", "pins: [(1, (0, 0, 0)), (0, (0, 0, 0))]"]
    {
        assert_eq!(errors(&with(good)), [], "{good}");
    }
    // What a skin's chain has is known later; that a joint is pinned twice is known now.
    let fields = "stiffness: [1], limits: [1, 2, 3, 4, 5], pins: [(9, (0, 0, 0))]";
    assert_eq!(errors(&of_skin(fields)), []);
    check(&of_skin("pins: [(9, (0, 0, 0)), («9», (0, 0, 0))]"), Value, "joint 9 is pinned before", None);
    // Where the chain is bad that is all that is said.
    check(&with("stiffness: [1]").replace("(0, 0, 0)", "«1»"), Value, "a point", None);
}

#[test]
fn names_that_do_not_exist_are_refused_with_the_nearest_one() {
    use PresetErrorKind::Name;
    for (field, message, help) in [
        ("«stretch»: 1", "`Ik` has no field `stretch`; expected `version`, `object`", None),
        ("«elastcity»: 1", "no field `elastcity`", Some("`elasticity`")),
        ("«refine»: Auto", "`Ik` has no field `refine`", None),
        (
            "curve: «Round»(0.5)",
            "no value of `curve` `Round`; expected `Rounded` or `Chain`",
            Some("`Rounded`"),
        ),
        ("pole: «Aut»", "expected `Auto`, a point `(x, y, z)`, `Keys(", Some("`Auto`")),
        ("scale_by: «Lenght»", "no value of `scale_by` `Lenght`", Some("`Length`")),
        ("tip: «Hld»((0, 0, 0))", "no value of `tip` `Hld`; expected `Follow` or `Hold`", Some("`Hold`")),
        ("influence: «SkinWeight»", "no influence `SkinWeight`", Some("`SkinWeights`")),
        ("closest: «Blend»(1)", "no value of `closest`", Some("`Blended`")),
        ("elasticity: «Kyes»([(0, 1)])", "a number, `Keys", Some("`Keys`")),
    ] {
        check(&with(field), Name, message, help);
    }
    check("«Ik»(goal: (0, 0, 0))", Name, "`Ik` needs a field `chain`", None);
    check("«Ik»(chain: Skin(\"a\", \"b\"))", Name, "`Ik` needs a field `goal`", None);
    let goals = "Ik(chain: Skin(\"a\", \"b\"), «gaol»: (0, 0, 0))";
    check(goals, Name, "`Ik` has no field `gaol`", Some("`goal`"));
    check(
        "«IK»()",
        Name,
        "no effect `IK`; expected `Deform`, `Wrinkle`, `Stitch`, `Ik` or `Stack`",
        Some("`Ik`"),
    );
}

#[test]
fn what_does_nothing_is_warned_of() {
    for (fields, path, message) in [
        ("pole: «(0, 1, 0)», elasticity: 1", "pole", "`pole` has no effect with `elasticity` 1"),
        ("pole: «(0, 1, 0)», elasticity: Keys([(0, 1), (1, 1)])", "pole", "a rubber band has no bend"),
        ("stiffness: «[0, 1]», elasticity: 0", "stiffness", "`stiffness` has no effect with `elasticity` 0"),
        ("softness: «0.5», max_stretch: 1", "softness", "`softness` has no effect with `max_stretch` 1"),
    ] {
        let text = with(fields);
        let warnings = parsed(&text.replace(['«', '»'], "")).warnings;
        let [warning] = warnings.as_slice() else { panic!("{text}\n{warnings:#?}") };
        let end = text.find('»').expect("a mark") - '«'.len_utf8();
        assert_eq!(warning.span, text.find('«').expect("a mark")..end, "{text}");
        assert_eq!((warning.line, warning.path.as_str()), (3, path), "{text}");
        assert!(warning.message.contains(message), "{warning:?}");
    }
    for fields in [
        "pole: (0, 1, 0), elasticity: Keys([(0, 0), (1, 1)])",
        "pole: Auto, elasticity: 1",
        "pole: (0, 1, 0), elasticity: 1, stiffness: [1, 0]",
        "stiffness: [0, 0], elasticity: 0",
        "stiffness: [1, 1], elasticity: 1",
        "stiffness: [1, 1], elasticity: Keys([(0, 0), (1, 0.5)])",
        "max_stretch: 1",
        "max_stretch: 1, softness: 0",
        "influence: SkinWeights",
    ] {
        assert_eq!(parsed(&with(fields)).warnings, [], "{fields}");
    }
}

#[test]
fn bounds_scale_what_is_a_length_or_a_place() {
    let fields = "units: Bounds, pole: (0, 0.5, 0), pins: [(0, Keys([(0, (0, 0, 0)), (1, (0.25, 0, 0))]))], influence: Radius(0.5),
        closest: Blended(0.25), stiffness: [0, 1], limits: [90, 90], max_stretch: 3, twist: 90, tip: Hold((90, 0, 0)),
        curve: Rounded(0.5), elasticity: 0.75, min_stretch: 0.5, softness: 0.5, volume: 0.5";
    let frame = BoundsFrame { center: [1.0, 2.0, 3.0], size: 4.0 };
    let placed = |text: &str| {
        let effect = effect(text);
        let placed = effect.placed(&frame);
        assert_eq!((effect.units, placed.units), (Units::Bounds, Units::Metres));
        match (effect.action, placed.action) {
            (Action::Ik(before), Action::Ik(after)) => (*before, *after),
            other => panic!("{other:?}"),
        }
    };
    let (before, after) = placed(&with(fields));
    let joints = vec![[1.0, 2.0, 3.0], [5.0, 2.0, 3.0], [9.0, 2.0, 3.0]];
    assert_eq!(after.chain, Chain::Joints(joints));
    assert_eq!(after.goal, Goal::Point(Keyed::Constant([9.0, 2.0, 3.0])));
    let settings = Ik {
        pole: Some(Keyed::Constant([1.0, 4.0, 3.0])),
        pins: vec![Pin { joint: 0, point: keys(&[(0.0, [1.0, 2.0, 3.0]), (1.0, [2.0, 2.0, 3.0])]) }],
        influence: Influence::Radius(2.0),
        closest: Closest::Blended(1.0),
        ..before.ik
    };
    assert_eq!(after.ik, settings);
    let keyed = with_goal("Keys([(0, (0, 0, 0)), (2, (0, 0.5, 0))])").replace("Ik(", "Ik(units: Bounds,");
    let track = keys(&[(0.0, [1.0, 2.0, 3.0]), (2.0, [1.0, 4.0, 3.0])]);
    assert_eq!(placed(&keyed).1.goal, Goal::Point(track));
    let curved = with_goal("Curve(Polyline([(0, 0, 0), (0, 0.5, 0)]))").replace("Ik(", "Ik(units: Bounds,");
    let Goal::Curve(curve) = placed(&curved).1.goal else { panic!() };
    assert_eq!(curve.points(), [[1.0, 2.0, 3.0], [1.0, 4.0, 3.0]]);
    // What has a name stays where it is.
    let skin = of_skin("units: Bounds").replace("goal: (2, 0, 0)", "goal: Node(\"target\")");
    let (before, after) = placed(&skin);
    assert_eq!(after, before);
    assert_eq!(
        effect(&with("pole: (0, 1, 0)")).placed(&frame).action,
        effect(&with("pole: (0, 1, 0)")).action
    );
}

#[test]
fn errors_that_are_found_later_have_a_place() {
    let fields =
        "stiffness: [0, 1], limits: [90, 45], pins: [(0, (0, 0, 0)), (1, (1, 0, 0))], pole: (0, 1, 0)";
    let plain = with(fields);
    let doubled = format!("Ik(({})", plain.replacen("Ik(", "", 1));
    for (text, path) in [(plain.clone(), ""), (doubled, ""), (format!("Stack([{plain}])"), "[0].")] {
        let effect = effect(&text);
        for (field, typed) in [
            ("chain", "Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0)])"),
            ("chain[1]", "(1, 0, 0)"),
            ("goal", "(2, 0, 0)"),
            ("stiffness", "[0, 1]"),
            ("stiffness[1]", "1"),
            ("limits", "[90, 45]"),
            ("limits[1]", "45"),
            ("pins[1]", "(1, (1, 0, 0))"),
            ("pins[1][0]", "1"),
            ("pole", "(0, 1, 0)"),
        ] {
            let error = effect.typed.error(field, PresetErrorKind::Value, "no", None);
            assert_eq!((&text[error.span], error.path), (typed, format!("{path}{field}")), "{text}");
        }
        let untyped = effect.typed.error("elasticity", PresetErrorKind::Value, "no", None);
        assert_eq!(&text[untyped.span], "Ik");
        assert_eq!(effect.typed.listed("pins"), Some(2));
    }
    let text = with_chain("Skin(root: \"arm\", tip: \"hand\")");
    let error = effect(&text).typed.error("chain", PresetErrorKind::Value, "no", None);
    assert_eq!((&text[error.span], error.line, error.column), ("Skin", 3, 10), "a struct by its name");
}

#[test]
fn limbs_are_the_same_with_both_parentheses_and_an_explicit_some() {
    let plain =
        "object: Tube(from: (0, 0, 0), to: (2, 0, 0), radius: 0.2), only: Nodes([\"a\"]), duration: 3";
    let spelt = "object: Some(Tube(from: (0, 0, 0), to: (2, 0, 0), radius: 0.2)), only: Some(Nodes([\"a\"])), duration: Some(3)";
    let doubled = format!("Ik(({})", with(spelt).replacen("Ik(", "", 1));
    let [plain, spelt, doubled] = [with(plain), with(spelt), doubled].map(|text| parsed(&text).preset);
    assert_eq!(plain.duration, 3.0);
    assert!(plain.object.is_some() && plain.effects[0].only.is_some());
    assert_eq!(spelt, plain);
    assert_eq!(doubled, plain);
}

#[test]
fn only_the_first_effect_brings_an_object() {
    let second = with("object: «Sphere(radius: 1)»");
    check(
        &format!("Stack([{}, {second}])", of_skin("volume: 1")),
        PresetErrorKind::Value,
        "only the first effect of a stack names the object",
        None,
    );
}
