//! What bounds a wire: domain curves, directions, feet; and references that move.

mod common;

use std::f32::consts::{FRAC_PI_2, PI};

use common::{check, errors};
use wirework_core::{Bounded, Closest, Curve, Wire};
use wirework_preset::{Action, KeyedWire, Limits, Parsed, PresetErrorKind, parse};

fn parsed(text: &str) -> Parsed {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{text}\n{errors}"))
}

/// A wire along X that swells, with more fields.
fn text(fields: &str) -> String {
    format!("Deform(wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), scale: 2, {fields})])")
}

fn keyed(fields: &str) -> KeyedWire {
    match parsed(&text(fields)).preset.effects.remove(0).action {
        Action::Deform(mut deform) => deform.wires.remove(0),
        Action::Wrinkle(_) | Action::Stitch(_) | Action::Ik(_) => panic!(),
    }
}

fn wire_at(fields: &str, seconds: f64) -> Wire {
    keyed(fields).at(seconds)
}

/// The bytes and the text of each warning.
fn warnings(text: &str) -> Vec<(usize, String)> {
    parsed(text).warnings.into_iter().map(|w| (w.span.start, w.message)).collect()
}

/// Checks that there is one warning, at the mark.
fn warns(fields: &str, message: &str) {
    let marked = text(fields);
    let found = warnings(&marked.replace(['«', '»'], ""));
    let [(at, text)] = found.as_slice() else { panic!("{marked}\n{found:?}") };
    assert_eq!(Some(*at), marked.find('«'), "{marked}\n{text}");
    assert!(text.contains(message), "{marked}\n{text}");
}

#[test]
fn domains_have_the_documented_defaults() {
    let wire = wire_at("domains: [Domain(curve: Polyline([(0, 0, 1), (1, 0, 1)]))]", 0.0);
    let curve = Curve::polyline(vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]).unwrap();
    assert_eq!(wire.domains, [wirework_core::Domain::new(curve)]);
    assert_eq!(wire_at("domains: []", 0.0), wire_at("", 0.0));
}

#[test]
fn domains_move_with_all_they_have() {
    let fields = "domains: [
        (curve: Polyline([(0, 0, 1), (1, 0, 1)]), bounds: Twist),
        Domain(curve: Polyline([(0, 0, 1), (1, 0, 1)]), delta: Keys([(0, 0), (2, 0.5)]), exponent: Ease([(0, 1), (2, -1)]),
               pose: Keys([(0, [(0, 0, 1), (1, 0, 1)]), (2, [(0, 0, 3), (1, 2, 1)])]), bounds: Amplitude)]";
    let keyed = keyed(fields);
    let mut wire = keyed.at(0.0);
    keyed.at_into(1.0, &mut wire);
    assert_eq!(wire, keyed.at(1.0));
    let [still, moving] = wire.domains.as_slice() else { panic!() };
    assert_eq!((still.curve.points()[0], still.bounds), ([0.0, 0.0, 1.0], Bounded::Twist));
    assert_eq!(moving.curve.points(), [[0.0, 0.0, 2.0], [1.0, 1.0, 1.0]]);
    assert_eq!((moving.delta, moving.exponent, moving.bounds), (0.25, 0.0, Bounded::Amplitude));
    let preset = parsed(&text(fields)).preset;
    assert_eq!((preset.duration, preset.animated), (2.0, true));
}

#[test]
fn domains_of_attributes_that_do_nothing_are_warnings() {
    let domain = |bounds: &str| {
        format!("domains: [Domain(curve: Polyline([(0, 0, 1), (1, 0, 1)]), bounds: {bounds})]")
    };
    warns(&domain("«Twist»"), "this domain curve bounds nothing: the wire's `twist` is 0");
    warns(&domain("«Rotation»"), "the wire's pose is its curve");
    let moved = "pose: [(0, 1, 0), (1, 0, 0)], ";
    warns(&format!("{moved}rotation: 0, {}", domain("«Rotation»")), "the wire's `rotation` is 0");
    // The wire of `warns` swells.
    let plain = text(&format!("{moved}{}", domain("Scale"))).replace("scale: 2, ", "");
    let found = warnings(&plain);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (found[0].0, found[0].1.contains("`scale` is 1")),
        (plain.find("Scale").unwrap(), true),
        "{found:?}"
    );
    for fields in [
        domain("Influence"),
        domain("Scale"),
        domain("Amplitude"),
        format!("{moved}{}", domain("Rotation")),
        format!("twist: 90, {}", domain("Twist")),
        format!("twist: Keys([(0, 0), (1, 1)]), {}", domain("Twist")),
        format!("locators: [Locator(u: 0, twist: 0), Locator(u: 1, twist: 9)], {}", domain("Twist")),
    ] {
        assert_eq!(warnings(&text(&fields)), [], "{fields}");
    }
}

#[test]
fn everything_that_moves_sets_the_duration() {
    for field in [
        "direction: Keys([(0, (0, 1, 0)), (3, (0, 1, 1))])",
        "direction: (0, 1, 0), angle: Keys([(0, 90), (3, 100)])",
        "closest: Blended(Keys([(0, 0.1), (3, 0.2)]))",
        "reference: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (3, [(0, 0, 0), (2, 0, 0)])])",
        "locators: [Locator(u: 0, direction: Keys([(0, (0, 1, 0)), (3, (0, 1, 1))]))]",
        "locators: [Locator(u: 0, direction: (0, 1, 0), angle: Keys([(0, 40), (3, 50)]))]",
        "domains: [Domain(curve: Polyline([(0, 0, 1)]), delta: Keys([(0, 0), (3, 0.2)]))]",
        "domains: [Domain(curve: Polyline([(0, 0, 1)]), exponent: Keys([(0, 0), (3, 0.2)]))]",
        "domains: [Domain(curve: Polyline([(0, 0, 1)]), pose: Keys([(0, [(0, 0, 1)]), (3, [(0, 0, 2)])]))]",
    ] {
        let found = parsed(&text(field));
        assert_eq!((found.preset.duration, found.preset.animated), (3.0, true), "{field}");
        assert_eq!(found.warnings, [], "{field}");
        // Every key changes the wire, and a wire moved there and back is as it was.
        let keyed = keyed(field);
        let (first, mut moved) = (keyed.at(0.0), keyed.at(1.5));
        assert_ne!(first, moved, "{field}");
        keyed.at_into(3.0, &mut moved);
        assert_eq!(moved, keyed.at(3.0), "{field}");
        keyed.at_into(0.0, &mut moved);
        assert_eq!(moved, first, "{field}");
        assert_eq!(first.check(), Ok(()), "{field}");
    }
}

#[test]
fn directions_and_angles() {
    let wire = wire_at("", 0.0);
    assert_eq!((wire.direction, wire.angle), (None, PI));
    let wire = wire_at("direction: (0, 3, 0), angle: 90", 0.0);
    assert_eq!((wire.direction, wire.angle), (Some([0.0, 3.0, 0.0]), FRAC_PI_2));
    let fields =
        "locators: [Locator(u: 0, direction: (0, 1, 0)), Locator(u: 0.5, angle: Keys([(0, 0.5), (1, 180)])),
        Locator(u: 1, direction: Keys([(0, (0, 0, 2)), (1, (1, 1, 0))]))]";
    let wire = wire_at(fields, 0.5);
    let found: Vec<_> = wire.locators.iter().map(|l| (l.direction, l.angle)).collect();
    let half = 90.25_f64.to_radians();
    assert!((f64::from(found[1].1.unwrap()) - half).abs() < 1e-6);
    assert_eq!(
        found.iter().map(|f| f.0).collect::<Vec<_>>(),
        [Some([0.0, 1.0, 0.0]), None, Some([0.5, 0.5, 1.0])]
    );
}

#[test]
fn feet() {
    assert_eq!(wire_at("closest: Smallest", 0.0).closest, Closest::Smallest);
    assert_eq!(wire_at("closest: Blended(0.25)", 7.0).closest, Closest::Blended(0.25));
    assert_eq!(wire_at("closest: Blended(Keys([(0, 1), (1, 2)]))", 0.5).closest, Closest::Blended(1.5));
    // A group and blended feet go together.
    let two = "Wire(curve: Polyline([(0, 0, 0)]), scale: 2, closest: Blended(1), group: \"g\"),".repeat(2);
    assert_eq!(errors(&format!("Deform(wires: [{two}])")), []);
}

#[test]
fn a_reference_moves_and_a_pose_follows_it() {
    let moves = "reference: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (2, [(0, 4, 0), (1, 0, 2)])])";
    let keyed = keyed(moves);
    let mut wire = keyed.at(0.0);
    assert_eq!(keyed.reference().points(), [[0.0; 3], [1.0, 0.0, 0.0]]);
    for (seconds, y, z) in [(0.0, 0.0, 0.0), (1.0, 2.0, 1.0), (9.0, 4.0, 2.0)] {
        keyed.at_into(seconds, &mut wire);
        assert_eq!(wire.reference.points(), [[0.0, y, 0.0], [1.0, 0.0, z]]);
        assert_eq!(wire.pose, wire.reference.points());
        assert_eq!(wire, keyed.at(seconds));
    }
    let pose = "pose: [(0, 1, 0), (1, 1, 0)]";
    let wire = wire_at(&format!("{moves}, {pose}"), 1.0);
    assert_eq!(wire.pose, [[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(wire.reference.points(), [[0.0, 2.0, 0.0], [1.0, 0.0, 1.0]]);
    // One that stays lies where it says.
    let wire = wire_at("reference: [(0, 9, 0), (1, 9, 0)]", 5.0);
    assert_eq!((wire.reference.points()[0], wire.pose[0]), ([0.0, 9.0, 0.0], [0.0, 9.0, 0.0]));
}

#[test]
fn a_wire_is_still_where_its_pose_is_its_reference_at_all_times() {
    let still = |fields: &str| {
        let text = format!("Deform(wires: [Wire(curve: Polyline([(0, 0, 0)]), {fields})])");
        let found = warnings(&text);
        assert!(found.len() <= 1, "{text}\n{found:?}");
        found.iter().any(|(_, message)| message.contains("moves nothing"))
    };
    let moves = |key: &str| format!("{key}: Keys([(0, [(0, 0, 0)]), (1, [(0, 1, 0)])])");
    assert!(still(""));
    assert!(still("direction: (0, 1, 0), angle: 30"));
    assert!(still(&moves("reference")), "the pose follows");
    assert!(still(&format!("{}, {}", moves("reference"), moves("pose"))), "they move together");
    assert!(!still(&moves("pose")));
    assert!(!still(&format!("{}, pose: [(0, 0, 0)]", moves("reference"))), "the pose stays behind");
    assert!(!still("reference: [(0, 0, 0)], pose: [(0, 1, 0)]"));
    assert!(still("reference: [(0, 1, 0)], pose: [(0, 1, 0)]"));
    assert!(
        !still("reference: [(0, 1, 0)], pose: [(0, 0, 0)]"),
        "the pose is the curve, but not the reference"
    );
    assert!(!still(&format!("{}, {}", moves("reference"), moves("pose").replace("(1,", "(2,"))));
}

#[test]
fn bad_bounds_are_refused_at_their_place() {
    let domain =
        |fields: &str| format!("domains: [Domain(curve: Polyline([(0, 0, 1), (1, 0, 1)]), {fields})]");
    for (field, message) in [
        (domain("delta: «1»"), "`delta` must lie from 0 to less than 1, found 1"),
        (domain("delta: «-0.1»"), "`delta` must lie from 0 to less than 1, found -0.1"),
        (domain("delta: «0.99999999»"), "`delta` must lie from 0 to less than 1, found 0.99999999"),
        (domain("delta: Keys([(0, 0.5), (1, «1.5»)])"), "`delta` must lie"),
        (domain("exponent: «NaN»"), "`exponent` must be a finite number"),
        (domain("pose: «[(0, 0, 1)]»"), "a pose has as many points as its curve, 2; found 1"),
        (domain("pose: Keys([(0, «[]»)])"), "a pose has as many points as its curve, 2; found 0"),
        ("domains: «Domain(curve: 1)»".into(), "expected a list of domain curves"),
        ("angle: «0», direction: (0, 1, 0)".into(), "`angle` must be greater than 0, found 0"),
        ("angle: Ease([(0, 90), (1, «-1»)])".into(), "`angle` must be greater than 0, found -1"),
        ("angle: «1e7»".into(), "`angle` must be within 1000000 degrees"),
        ("direction: «(0, 0, 0)»".into(), "a direction must not be (0, 0, 0)"),
        ("direction: Keys([(0, (0, 1, 0)), (1, «(0, 0, 0)»)])".into(), "a direction must not be (0, 0, 0)"),
        ("direction: Keys([(0, (0, 1, 0)), (1, «(0, -3, 0)»)])".into(), "cannot turn straight round"),
        ("direction: (0, «inf», 0)".into(), "finite"),
        ("direction: «1»".into(), "expected a point `(x, y, z)`, found `1`"),
        ("locators: [Locator(u: 0, direction: «(0, 0, 0)»)]".into(), "must not be (0, 0, 0)"),
        ("locators: [Locator(u: 0, angle: «-90», direction: (0, 1, 0))]".into(), "greater than 0"),
        (
            "locators: [Locator(u: 0, direction: (0, 1, 0)), «Locator(u: 0, direction: (0, 0, 1))»]".into(),
            "carries `direction` already",
        ),
        ("closest: Blended(«0»)".into(), "`width` must be greater than 0, found 0"),
        ("closest: «Blended(width: 0.2)»".into(), "the width stands alone, without a name: `Blended(0.2)`"),
        ("closest: «Blended(width: Keys([(0, 1)]))»".into(), "without a name: `Blended(width)`"),
        ("closest: Blended(Keys([(0, 1), (1, «-1»)]))".into(), "`width` must be greater than 0"),
        ("closest: «Blended»".into(), "expected `Blended(width)`"),
        ("closest: «Smallest(1)»".into(), "`Smallest` stands alone"),
        ("closest: «0.5»".into(), "expected `Smallest` or `Blended(width)`, found `0.5`"),
        ("reference: «[(0, 0, 0)]»".into(), "a reference has as many points as its curve, 2; found 1"),
        ("reference: Keys([(0, «[]»)])".into(), "a reference has as many points as its curve, 2; found 0"),
    ] {
        check(&text(&field), PresetErrorKind::Value, message, None);
    }
    for (field, message, help) in [
        (domain("bounds: «Sclae»"), "no value of `bounds` `Sclae`; expected `Influence`, `Scale`", "`Scale`"),
        (domain("«dleta»: 0"), "`Domain` has no field `dleta`", "`delta`"),
        ("closest: «Smalest»".into(), "no value of `closest` `Smalest`", "`Smallest`"),
        ("closest: «Blend»(1)".into(), "no value of `closest` `Blend`", "`Blended`"),
        ("domains: [«Domian»(curve: Polyline([(0, 0, 1)]))]".into(), "no struct `Domian`", "`Domain`"),
    ] {
        check(&text(&field), PresetErrorKind::Name, message, Some(help));
    }
    check(
        &text("domains: [«Domain»(delta: 0)]"),
        PresetErrorKind::Name,
        "`Domain` needs a field `curve`",
        None,
    );
}

#[test]
fn a_domain_curve_on_the_reference_is_refused() {
    let message = "this one lies on it";
    for curve in [
        "Polyline([(0, 0, 0), (1, 0, 0)])",
        "Polyline([(1, 0, 0), (0, 0, 0)])",
        "Polyline([(0.25, 0, 0), (0.5, 0, 0)])",
        "BSpline([(0, 0, 0), (0.2, 0, 0), (0.7, 0, 0), (1, 0, 0)])",
        "Polyline([(0.3, 0, 0)])",
        "Polyline([(0, 0, 1e-7), (1, 0, 1e-7)])",
    ] {
        check(&text(&format!("domains: [Domain(curve: «{curve}»)]")), PresetErrorKind::Value, message, None);
    }
    let posed = "domains: [Domain(curve: Polyline([(0, 0, 5)]), pose: «[(0.5, 0, 0)]»)]";
    check(&text(posed), PresetErrorKind::Value, message, None);
    // Far from the origin float32 cannot tell it from the reference, either.
    let far =
        "Deform(wires: [Wire(curve: BSpline([(1000, 7, 0), (1000.3, 7.1, 0), (1001, 7, 0.4)]), scale: 2,
        domains: [Domain(curve: «BSpline([(1000, 7, 0), (1000.3, 7.1, 0), (1001, 7, 0.4)])»)])])";
    check(far, PresetErrorKind::Value, message, None);
    // One that goes with a moving reference.
    let keys = "Keys([(0, [(0, 0, 0), (1, 0, 0)]), (2, [(0, 4, 0), (1, 0, 2)])])";
    let both = format!(
        "reference: {keys}, domains: [Domain(curve: Polyline([(0, 0, 0), (1, 0, 0)]), pose: «{keys}»)]"
    );
    check(&text(&both), PresetErrorKind::Value, message, None);
}

#[test]
fn a_domain_curve_that_meets_the_reference_is_a_warning() {
    for curve in [
        "Polyline([(1, 0, 0), (2, 0, 0)])",
        "Polyline([(0, 0, 0), (0, 0, 1)])",
        "Polyline([(0.3, 0, -1), (0.35, 0, 1.234)])",
        "Polyline([(0.3, 1, 0), (0.35, 0, 0), (0.4, 1, 0)])",
    ] {
        warns(&format!("domains: [Domain(curve: «{curve}»)]"), "touches the wire's reference");
    }
    for apart in ["Polyline([(0, 0, 0.001), (1, 0, 0.001)])", "Polyline([(1.0001, 0, 0), (2, 0, 0)])"] {
        assert_eq!(warnings(&text(&format!("domains: [Domain(curve: {apart})]"))), []);
    }
    let grows = "domains: [Domain(curve: Polyline([(0, 0, 9), (1, 0, 9)]),
        pose: Keys([(0, [(0, 0, 1), (1, 0, 1)]), (1, «[(0, 0, 0), (1, 0, 0)]»)]))]";
    warns(grows, "at 1 s this domain curve lies on the wire's reference");
    let comes = "reference: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (2, [(0, 1, 0), (1, 1, 0)])]),
        domains: [Domain(curve: «Polyline([(0, 1, 0), (1, 1, 0)])»)]";
    warns(comes, "at 2 s this domain curve lies on the wire's reference");
}

#[test]
fn a_direction_along_the_wire_is_refused() {
    let message = "this one runs along it";
    for field in [
        "direction: «(1, 0, 0)»",
        "direction: «(-7, 0.0001, 0)»",
        "direction: Keys([(0, (0, 1, 0)), (1, «(2, 0, 0)»)])",
        "locators: [Locator(u: 0.5, direction: «(3, 0, 0)»)]",
        "locators: [Locator(u: 0, direction: (0, 1, 0)), Locator(u: 1, direction: Keys([(0, (0, 1, 0)), (1, «(1, 0, 0)»)]))]",
    ] {
        check(&text(field), PresetErrorKind::Value, message, None);
    }
    // At the corner the tangent is the mean of both sides'.
    let bent = "Deform(wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0), (1, 1, 0)]), scale: 2, MORE)])";
    let at_corner = bent.replace("MORE", "locators: [Locator(u: 0.5, direction: «(1, 1, 0)»)]");
    check(&at_corner, PresetErrorKind::Value, message, None);
    for good in [
        "direction: (0, 1, 0)",
        "direction: (1, 0.01, 0)",
        "direction: (1e30, 1e30, 0)",
        "direction: (1e-40, 1e-40, 0)",
    ] {
        assert_eq!(warnings(&text(good)), [], "{good}");
    }
    // A wire that is a point has no sides.
    assert_eq!(
        warnings("Deform(wires: [Wire(curve: Polyline([(0, 0, 0)]), scale: 2, direction: (1, 0, 0))])"),
        []
    );
}

#[test]
fn a_direction_along_a_part_of_the_wire_is_a_warning() {
    let bent = |fields: &str| {
        let marked = format!(
            "Deform(wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0), (1, 1, 0)]), scale: 2, {fields})])"
        );
        let found = warnings(&marked.replace(['«', '»'], ""));
        let [(at, text)] = found.as_slice() else { panic!("{marked}\n{found:?}") };
        assert_eq!(Some(*at), marked.find('«'), "{marked}\n{text}");
        text.clone()
    };
    assert!(bent("direction: «(0, 1, 0)»").contains("at u = 0.53125 this direction runs along the wire"));
    assert!(bent("direction: «(1, 0, 0)»").contains("at u = 0 "));
    let turns = "reference: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (1, [(0, 0, 0), (0, 1, 0)])]), pose: [(0, 0, 0), (1, 0, 0)]";
    warns(&format!("{turns}, direction: «(0, 1, 0)»"), "runs along the wire");
    let round = "locators: [Locator(u: 0, direction: (0, 1, 0)), Locator(u: 1, direction: «(0, -2, 0)»)]";
    warns(round, "passes (0, 0, 0)");
}

#[test]
fn angles_without_directions_and_overridden_directions_are_warnings() {
    warns("angle: «90»", "`angle` has no effect without a `direction`");
    warns("locators: [Locator(u: 0, angle: «90»)]", "`angle` has no effect without a `direction`");
    assert_eq!(warnings(&text("angle: 180")), []);
    assert_eq!(warnings(&text("angle: 90, locators: [Locator(u: 0, direction: (0, 1, 0))]")), []);
    warns(
        "direction: «(0, 1, 0)», locators: [Locator(u: 0, direction: (0, 0, 1))]",
        "the wire's `direction` has no effect",
    );
    assert_eq!(warnings(&text("direction: None, locators: [Locator(u: 0, direction: (0, 0, 1))]")), []);
    warns(
        "direction: (0, 1, 0), angle: «90», locators: [Locator(u: 0, angle: 30)]",
        "the wire's `angle` has no effect",
    );
}

#[test]
fn many_points_and_keys_are_checked_in_a_moment() {
    let many = |count: u32, one: fn(u32) -> String| (0..count).map(one).collect::<Vec<_>>().concat();
    let points = many(20_000, |i| format!("({i}, 0, 0),"));
    let locators = many(20_000, |i| format!("Locator(u: {}, direction: (0, 1, 0)),", f64::from(i) / 2e4));
    let keys = many(20_000, |i| format!("({i}, [(0, 0, {})]),", 1 + i % 7));
    let turns = many(20_000, |i| format!("({i}, (0, {}, 1)),", i % 5));
    let domains = many(5_000, |i| format!("Domain(curve: Polyline([(0, 0, {})])),", i + 1));
    let wire = |fields: &str| format!("Wire(curve: Polyline([{points}]), scale: 2, {fields})");
    let moved = format!("Keys([(0, [{points}]), (1, [{points}])])");
    for wires in [
        wire(&format!("locators: [{locators}]")),
        wire(&format!("direction: Keys([{turns}])")),
        wire(&format!("direction: Keys([{turns}]), reference: {moved}")),
        wire(&format!(
            "domains: [Domain(curve: Polyline([(0, 0, 1)]), pose: Keys([{keys}]))], reference: {moved}"
        )),
        wire(&format!("domains: [{domains}], reference: {moved}")),
        format!(
            "Wire(curve: Polyline([(0, 0, 0)]), scale: 2, domains: [{domains}], reference: Keys([{}])),",
            keys.replace(" 0, ", " 1, ")
        ),
    ] {
        let text = format!("Deform(wires: [{wires}])");
        let start = std::time::Instant::now();
        assert!(parse(text.as_bytes(), &Limits::default()).is_ok());
        println!("{} bytes in {:?}", text.len(), start.elapsed());
        // At most some 2 s for the checks; all pairs would be hours.
        assert!(start.elapsed().as_secs() < 20);
    }
}
