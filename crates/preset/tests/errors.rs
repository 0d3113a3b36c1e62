//! Bad presets, and what is said about them: line, column, path, message, help.

mod common;

use common::{check, errors};
use wirework_preset::{Limits, PresetErrorKind, parse};

/// A wire with one more field.
fn in_wire(field: &str) -> String {
    format!(
        "Deform(\n  wires: [\n    Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), {field}),\n  ],\n)"
    )
}

/// A wrinkle with one more field.
fn in_wrinkle(field: &str) -> String {
    format!("Wrinkle(\n  pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])]),\n  {field},\n)")
}

/// An effect with an object.
fn with_object(object: &str) -> String {
    format!("Deform(object: {object}, wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]))])")
}

#[test]
fn values_out_of_range_are_refused_at_the_value() {
    for (field, message) in [
        ("radius: «0»", "`radius` must be greater than 0, found 0"),
        ("radius: «-0.5»", "greater than 0, found -0.5"),
        ("radius: «NaN»", "a finite number, found NaN"),
        ("radius: «1e39»", "a finite number, found 1e39"),
        ("radius: «1e-60»", "greater than 0"),
        ("scale: «inf»", "`scale` must be a finite number"),
        ("scale: «-inf»", "finite"),
        ("amplitude: «NaN»", "finite"),
        ("exponent: «NaN»", "finite"),
        ("twist: Keys([(0, 1), (1, «inf»)])", "`twist` must be a finite number"),
        ("twist: «1e12»", "`twist` must be within 1000000 degrees"),
        ("twist: Ease([(0, 1), (1, «-1000001»)])", "`twist` must be within 1000000 degrees"),
        ("locators: [Locator(u: 0, twist: «1e7»)]", "`twist` must be within 1000000 degrees"),
        ("radius: Keys([(0, 1), (1, «0»)])", "greater than 0"),
        ("radius: Keys([(0, 1), («0», 2)])", "must come after the one before, at 0 s; found 0 s"),
        ("radius: Ease([(2, 1), («1.5», 2)])", "must come after the one before, at 2 s; found 1.5 s"),
        ("radius: Keys([(«NaN», 1)])", "finite"),
        ("radius: «Keys([])»", "at least one key"),
        ("pose: «[(0, 0, 0)]»", "a pose has as many points as its curve, 2; found 1"),
        ("pose: Keys([(0, [(0, 0, 0), (1, 0, 0)]), (1, «[(0, 0, 0)]»)])", "as many points as its curve"),
        ("pose: [(0, 0, 0), (1, «NaN», 0)]", "finite"),
        ("locators: [Locator(u: «1.5»)]", "`u` must lie from 0 to 1, found 1.5"),
        ("locators: [Locator(u: «-0.1»)]", "from 0 to 1"),
        ("locators: [Locator(u: 0.5), Locator(u: «0.2»)]", "locators stand by rising `u`"),
        ("locators: [Locator(u: 0, radius: «0»)]", "greater than 0"),
        ("locators: [Locator(u: 0, scale: 1), «Locator(u: 0, scale: 2)»]", "carries `scale` already"),
        ("density: Profile([«(0, 0.5)»])", "contradicts f(0) = 1"),
        ("density: Profile([(0.2, 0.5), «(0.4, 0.6)»])", "not above it"),
        ("density: Profile([(0.2, 0.5), «(0.2, 0.4)»])", "to the right of the one before"),
        ("density: Profile([(«1.5», 0.5)])", "from 0 to 1"),
    ] {
        check(&in_wire(field), PresetErrorKind::Value, message, None);
    }
}

#[test]
fn wrinkle_values_out_of_range_are_refused_at_the_value() {
    for (field, message) in [
        ("thickness: «-0.1»", "`thickness` must be greater than 0"),
        ("thickness: Keys([(0, 0.1), (1, «0»)])", "greater than 0"),
        ("stiffness: «1.5»", "`stiffness` must lie from 0 to 1"),
        ("propagation: Keys([(0, «-1»)])", "`propagation` must lie from 0 to 1"),
        ("resistance: «2»", "from 0 to 1"),
        ("randomness: «-1»", "from 0 to 1"),
        ("intensity: «NaN»", "finite"),
        ("seed: «-1»", "whole number"),
        ("seed: «1.5»", "whole number"),
        ("creases: «0»", "at least 1"),
        ("size: (1, «0»)", "greater than 0"),
        ("direction: «(0, 0, 0)»", "must not be (0, 0, 0)"),
        ("duration: «0»", "`duration` must be greater than 0"),
        ("duration: «-1»", "greater than 0"),
        ("blend: Blend(crossing: «1.1»)", "`crossing` must lie from 0 to 1"),
        ("blend: Blend(localize: «-1»)", "`localize`"),
        ("blend: Blend(locality: «-1»)", "0 or greater"),
        ("blend: Blend(exponent: «NaN»)", "finite"),
    ] {
        check(&in_wrinkle(field), PresetErrorKind::Value, message, None);
    }
    let curve = "Wrinkle(pattern: Drawn([Polyline(points: «[]»)]))";
    check(curve, PresetErrorKind::Value, "at least one control point", None);
    check("Wrinkle(pattern: «Drawn([])»)", PresetErrorKind::Value, "at least one curve", None);
}

#[test]
fn curves_and_objects_are_refused_at_the_value() {
    for (curve, message) in [
        ("BSpline(points: «[]»)", "at least one control point"),
        ("BSpline(degree: «4», points: [(0, 0, 0)])", "1, 2 or 3, found 4"),
        ("BSpline(degree: «0», points: [(0, 0, 0)])", "at least 1"),
        ("Bezier(points: «[(0, 0, 0), (1, 0, 0)]»)", "3n + 1 points, not 2"),
        ("Bezier(closed: true, points: «[(0, 0, 0), (1, 0, 0)]»)", "3n points, not 2"),
        ("Polyline(points: [(0, 0, «inf»)])", "finite"),
        ("Polyline(points: [«(0, 0)»])", "expected a point `(x, y, z)`, found 2 values"),
        ("Polyline(points: [«[0, 0, 0]»])", "expected a point `(x, y, z)`, found a list"),
        ("Polyline(points: [«0»])", "expected a point `(x, y, z)`, found `0`"),
    ] {
        check(&format!("Deform(wires: [Wire(curve: {curve})])"), PresetErrorKind::Value, message, None);
    }
    for (object, message) in [
        ("Grid(size: (1, 1), cells: («0», 1))", "at least 1"),
        ("Grid(size: («0», 1))", "greater than 0"),
        ("Grid(size: (1, 1), normal: «(0, 0, 0)»)", "must not be (0, 0, 0)"),
        ("Tube(from: (0, 0, 0), to: «(0, 0, 0)», radius: 1)", "`to` must differ from `from`"),
        ("Tube(from: (0, 0, 0), to: (1, 0, 0), radius: «0»)", "greater than 0"),
        ("Tube(from: (0, 0, 0), to: (1, 0, 0), radius: 1, sides: «2»)", "at least 3"),
        ("Tube(from: (0, 0, 0), to: (1, 0, 0), radius: 1, rings: «1»)", "at least 2"),
        ("Sphere(radius: «-1»)", "greater than 0"),
        ("Sphere(radius: 1, segments: (64, «1»))", "at least 2"),
        ("Box(min: (0, 0, 0), max: «(1, 0, 1)»)", "greater than `min` along each axis"),
        ("Points(«[]»)", "at least one point"),
        ("File(«\"\"»)", "path"),
        ("Patch(points: [[(0, 0, 0), (1, 0, 0)], «[(0, 0, 0)]»])", "row 1"),
        ("Patch(points: «[[(0, 0, 0), (1, 0, 0)]]»)", "two control points or more along u"),
        ("Patch(points: [«[(0, 0, 0)]», [(1, 0, 0)]])", "along v"),
        ("Patch(degree: (3, «4»), points: [[(0, 0, 0), (1, 0, 0)], [(0, 0, 0), (1, 0, 0)]])", "1, 2 or 3"),
        ("Sphere(radius: 1, scale: «0»)", "must not be 0"),
        ("Sphere(radius: 1, scale: «(1, 0, 1)»)", "must not be 0"),
        ("Sphere(radius: 1, rotation: (0, «NaN», 0))", "finite"),
    ] {
        check(&with_object(object), PresetErrorKind::Value, message, None);
    }
    for object in [
        "«Grid»(size: (1, 1), cells: (4294967295, 4294967295))",
        "«Grid»(size: (1, 1), cells: (4096, 4096))",
        "«Box»(min: (0, 0, 0), max: (1, 1, 1), cells: (4000, 4000, 1))",
    ] {
        check(&with_object(object), PresetErrorKind::Limit, "the limit is 16777216 (--max-vertices", None);
        let wide = Limits { vertices: u64::MAX, ..Limits::default() };
        let text = with_object(object).replace(['«', '»'], "");
        // What no vertex numbering holds stays a limit; whatever else was asked for passes.
        match parse(text.as_bytes(), &wide) {
            Ok(_) => assert!(!object.contains("4294967295")),
            Err(errors) => assert!(errors.is_limit() && errors.to_string().contains("no flag"), "{errors}"),
        }
    }
    let text = with_object("Grid(size: (1, 1), cells: (4294967295, 4294967295))");
    assert!(parse(text.as_bytes(), &Limits::default()).unwrap_err().is_limit());
}

#[test]
fn wrong_types_say_what_was_expected_and_found() {
    for (field, message) in [
        ("radius: «\"big\"»", "expected a number, found the text \"big\""),
        ("radius: «true»", "expected a number, found `true`"),
        ("radius: «[1]»", "expected a number, found a list"),
        ("radius: «(1, 2)»", "expected a number, found 2 values in parentheses"),
        ("radius: Keys(«0.5»)", "expected a list of keys `[(seconds, value), ..]`, found `0.5`"),
        ("radius: «Keys(1, 2)»", "expected `Keys([(seconds, value), ..])`"),
        ("radius: Keys([«0.5»])", "expected a key `(seconds, value)`, found `0.5`"),
        ("radius: Keys([«(0, 1, 2)»])", "expected a key"),
        ("radius: Keys([(«\"a\"», 2)])", "expected a number of seconds"),
        ("pose: «1»", "expected a list of points"),
        ("density: «1»", "expected `Quartic`, `Sextic`, `Smoothstep`, `Linear` or `Profile`"),
        ("density: «Quartic(1)»", "`Quartic` stands alone"),
        ("group: «7»", "expected the name of a group in quotes, found `7`"),
        ("locators: «Locator(u: 0)»", "expected a list of locators"),
        ("bend: «\"Tangent\"»", "expected `Tangent` or `Transport`, found the text"),
    ] {
        check(&in_wire(field), PresetErrorKind::Value, message, None);
    }
    check("«[1, 2]»", PresetErrorKind::Value, "expected an effect", None);
    check("Deform(wires: «[]»)", PresetErrorKind::Value, "at least one wire", None);
    check("«Stack([])»", PresetErrorKind::Value, "at least one effect", None);
}

#[test]
fn unknown_names_get_the_nearest_valid_one() {
    for (field, message, help) in [
        (
            "«raduis»: 1",
            "`Wire` has no field `raduis`; expected `curve`, `pose`, `radius`",
            "did you mean `radius`?",
        ),
        (
            "radius: «Kyes»([(0, 1)])",
            "expected a number, `Keys([(seconds, value), ..])` or `Ease([..])`, found `Kyes`",
            "`Keys`",
        ),
        ("pose: «Eas»([(0, [])])", "found `Eas`", "`Ease`"),
        ("density: «quartic»", "no density `quartic`", "`Quartic`"),
        ("bend: «Tranport»", "no bend `Tranport`; expected `Tangent` or `Transport`", "`Transport`"),
        ("correspondence: «Arclength»", "no correspondence", "`ArcLength`"),
        ("interpolation: «Smoth»", "no interpolation", "`Smooth`"),
        ("locators: [Locator(u: 0, «raidus»: 1)]", "`Locator` has no field `raidus`", "`radius`"),
        ("locators: [«Locater»(u: 0)]", "no struct `Locater`", "`Locator`"),
        ("closest: «Smalest»", "no value of `closest` `Smalest`", "`Smallest`"),
    ] {
        check(&in_wire(field), PresetErrorKind::Name, message, Some(help));
    }
    check("«Deforn»(wires: [])", PresetErrorKind::Name, "no effect `Deforn`", Some("`Deform`"));
    check(&with_object("«Gird»(size: (1, 1))"), PresetErrorKind::Name, "no object `Gird`", Some("`Grid`"));
    check(
        "Deform(wires: [Wire(curve: «Bspline»(points: []))])",
        PresetErrorKind::Name,
        "no curve",
        Some("`BSpline`"),
    );
    check("Wrinkle(pattern: «Drown»([]))", PresetErrorKind::Name, "no pattern", Some("`Drawn`"));
    check(
        "Deform(wires: [«Wier»(curve: Polyline(points: []))])",
        PresetErrorKind::Name,
        "no wire",
        Some("`Wire`"),
    );
    check(&in_wire("«zebra»: 1"), PresetErrorKind::Name, "has no field `zebra`", None);
    check(&in_wire("radius: 1, «radius»: 2"), PresetErrorKind::Name, "stands here twice", None);
    check("Deform(wires: [«Wire»(radius: 1)])", PresetErrorKind::Name, "`Wire` needs a field `curve`", None);
    check("Deform(wires: [«(»radius: 1)])", PresetErrorKind::Name, "`Wire` needs a field `curve`", None);
    check("Deform(«wirse»: [])", PresetErrorKind::Name, "has no field `wirse`", Some("`wires`"));
}

#[test]
fn parts_of_wrinkles_are_refused_at_their_place() {
    use PresetErrorKind::{Name, Value};
    for (text, kind, message, help) in [
        ("Wrinkle(pattern: «Ripples»)", Name, "no pattern `Ripples`", Some("`Ripple`")),
        ("Wrinkle(pattern: «Radial(3)»)", Value, "stands alone", None),
        ("Wrinkle(motion: «Traveling»(velocity: (1, 0)))", Name, "no motion", Some("`Travelling`")),
        ("Wrinkle(motion: Travelling(velocity: «1»))", Value, "`(along, across)`", None),
        ("Wrinkle(motion: Travelling(velocity: (1, 0), «speed»: 1))", Name, "no field `speed`", None),
        ("Wrinkle(compression: «1»)", Value, "from 0 to less than 1", None),
        ("Wrinkle(compression: «-0.1»)", Value, "from 0 to less than 1", None),
        ("Wrinkle(drive: «Stain»())", Name, "no drive", Some("`Strain`")),
        ("Wrinkle(drive: Strain(from: 0.3, to: «0.2»))", Value, "greater than `from`", None),
        ("Wrinkle(drive: Strain(from: «0.5»))", Value, "less than `to`", None),
        ("Wrinkle(drive: Strain(radius: «0»))", Value, "greater than 0", None),
        ("Wrinkle(drive: Strain(«form»: 0.1))", Name, "no field `form`", Some("`from`")),
        ("Wrinkle(refine: «Fine»)", Name, "no refine", None),
        ("Wrinkle(pattern: Radial, branches: («cuont»: 3))", Name, "no field `cuont`", Some("`count`")),
        ("Wrinkle(creases: «0»)", Value, "at least 1", None),
        ("Wrinkle(creases: «1000000»)", Value, "are more than", None),
        ("Wrinkle(pattern: Radial, branches: «(count: 9, depth: 9)»)", Value, "are more than", None),
        (
            "Wrinkle(motion: «Travelling(velocity: (1, 0))», drive: Strain())",
            Value,
            "stay where they are",
            None,
        ),
        (
            "Wrinkle(pattern: Drawn([Polyline(«Keys([(0, [(0,0,0)]), (1, [])])»)]))",
            Value,
            "another number of points",
            None,
        ),
        ("Wrinkle(pattern: «Auto»)", Value, "needs `drive", None),
        ("Wrinkle(pattern: Ripple, motion: «Curtain()»)", Value, "have none", None),
        ("Wrinkle(motion: Curtain(gusts: «2»))", Value, "from 0 to 1", None),
        ("Wrinkle(motion: Curtain(rail: «Polylin»([(0, 0, 0)])))", Name, "no curve", Some("`Polyline`")),
        ("Wrinkle(motion: «Curtain(settle: 61)»)", Value, "between 0 and 60", None),
        ("Wrinkle(size: (1, «0»))", Value, "greater than 0", None),
        ("Wrinkle(direction: «(0, 0, 0)»)", Value, "must not be (0, 0, 0)", None),
    ] {
        check(text, kind, message, help);
    }
    for field in [
        "motion: Anchored",
        "branches: (count: 0, depth: 0)",
        "compression: None",
        "drive: None",
        "refine: Off",
        "units: Metres",
        "only: None",
        "mask: None",
    ] {
        assert_eq!(errors(&in_wrinkle(field)), []);
    }
}

#[test]
fn a_newer_version_is_refused_before_its_fields_are_judged() {
    for text in [
        "Deform(version: «2», wires: 7, nonsense: 1)",
        "Stitch(version: «2»)",
        "Novelty(version: «99»)",
        "Stack([Deform(wires: 7), Wrinkle(version: «2»)])",
    ] {
        check(text, PresetErrorKind::Version, "newer than this tool", Some("newer"));
    }
    check(&in_wrinkle("version: «0»"), PresetErrorKind::Value, "at least 1", None);
    check(&in_wrinkle("version: «\"1\"»"), PresetErrorKind::Value, "whole number", None);
    assert_eq!(errors(&in_wrinkle("version: 1")), []);
}

#[test]
fn syntax_errors_stand_where_they_are() {
    for (text, message, help) in [
        ("Deform(wires: [1 «2»])", "expected `,` or a closing bracket, found `2`", None),
        ("Deform(wires: 1 «x»: 2)", "expected `,` or a closing bracket, found `x`", None),
        (
            "Deform(\n  wires: [Wire(\n«»",
            "expected `)`, the preset ends",
            Some("line 2, column 15 is not closed"),
        ),
        ("Deform(wires: [(1«]»)", "expected `)`, found `]`", Some("line 1, column 16 is not closed")),
        ("Deform() «extra»", "expected nothing after the preset, found `extra`", None),
        ("«»", "ends too early", None),
        ("Deform(wires «[»])", "expected `:`, `,` or a closing bracket, found `[`", None),
        ("«{»1: 2}", "expected a value", None),
        ("Deform(wires: [], group: «\"»abc)", "expected end of string", None),
    ] {
        check(text, PresetErrorKind::Syntax, message, help);
    }
}

#[test]
fn a_value_without_a_name_beside_a_named_field() {
    let wire = |curve: &str| format!("Deform(wires: [\n  Wire(curve: {curve}, radius: 2),\n])");
    for (text, field, help) in [
        (wire("Polyline([(0, 0, 0), (1, 0, 0)], «closed»: true)"), "closed", "write `points: [..]`"),
        (
            wire("BSpline( /* ( */ [(0, 0, 0)],\n  «degree» : 2, closed: true)"),
            "degree",
            "write `points: [..]`",
        ),
        (wire("CatmullRom(\n // points: here )\n [(0, 0, 0)], «closed»: true)"), "closed", "`points: [..]`"),
        (with_object("File(\"a(b].glb\", «scale»: 2)"), "scale", "write `path: \"..\"`"),
        (with_object("Points([(0, 0, 0)], «scale»: 2)"), "scale", "write `points: [..]`"),
        (in_wire("mask: Image(\"m.png\", «channel»: R)"), "channel", "write `file: \"..\"`"),
        (in_wire("locators: [Locator(0.5, «scale»: 2)]"), "scale", "write `field: value` for each"),
    ] {
        let message = format!("a value without a name cannot stand beside the named field `{field}`");
        check(&text, PresetErrorKind::Syntax, &message, Some(help));
    }
    // A list has no fields at all.
    check(
        "Deform(wires: [a«:» 1])",
        PresetErrorKind::Syntax,
        "expected `,` or a closing bracket, found `:`",
        None,
    );
}

#[test]
fn all_semantic_errors_are_found_at_once() {
    let text = in_wire("radius: 0, scale: NaN, bend: Foo, locators: [Locator(u: 3, twist: inf)]");
    let found = errors(&text);
    let paths: Vec<&str> = found.iter().map(|error| error.path.as_str()).collect();
    let wire = |rest: &str| format!("wires[0].{rest}");
    assert_eq!(
        paths,
        [wire("radius"), wire("scale"), wire("bend"), wire("locators[0].u"), wire("locators[0].twist")]
    );
    assert!(found.is_sorted_by_key(|error| error.span.start));
}

#[test]
fn the_object_stands_on_the_first_effect_of_a_stack() {
    let wires = "wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), scale: 2)]";
    let text = format!("Stack([Deform({wires}), Deform(object: «Sphere(radius: 1)», {wires})])");
    check(&text, PresetErrorKind::Value, "only the first effect of a stack names the object", None);
    let text = format!("Stack([Stack([Deform(object: Sphere(radius: 1), {wires})]), Deform({wires})])");
    assert_eq!(errors(&text), []);
}

#[test]
fn columns_count_characters_and_control_characters_are_escaped() {
    check(
        "/* größe → 🦀 */ Deform(«\u{fc}\u{fc}»: 1, wires: [Wire(curve: Polyline(points: [(0, 0, 0)]))])",
        PresetErrorKind::Name,
        "üü",
        None,
    );
    let found = errors(&in_wire("radius: \"a\u{7}\u{1b}[31mred\u{202e}\""));
    assert!(!found[0].message.chars().any(|c| c.is_control() || c == '\u{202e}'), "{}", found[0].message);
    assert!(found[0].message.contains("\\u{1b}[31mred"), "{}", found[0].message);
    let found = errors(&in_wire(&format!("radius: \"{}\"", "x".repeat(100_000))));
    assert!(found[0].message.len() < 300);
}

#[test]
fn bytes_that_are_no_text_and_marks_before_it() {
    let good = in_wrinkle("seed: 1");
    let with_mark = [b"\xef\xbb\xbf", good.as_bytes()].concat();
    assert!(parse(&with_mark, &Limits::default()).is_ok());
    let bad = [b"\xef\xbb\xbf", in_wire("radius: 0").as_bytes()].concat();
    let error = parse(&bad, &Limits::default()).unwrap_err().errors()[0].clone();
    assert_eq!(&bad[error.span.clone()], b"0");
    assert_eq!((error.line, error.column), (3, 67));
    let mut broken = good.clone().into_bytes();
    broken[12] = 0xff;
    let error = parse(&broken, &Limits::default()).unwrap_err().errors()[0].clone();
    assert_eq!((error.kind, error.line, error.column, error.span.start), (PresetErrorKind::Syntax, 2, 4, 12));
    let utf16: Vec<u8> = "Deform()".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(parse(&[b"\xff\xfe".to_vec(), utf16].concat(), &Limits::default()).is_err());
}

#[test]
fn size_and_depth_are_limits() {
    let limits = Limits { bytes: 100, ..Limits::default() };
    let errors_found = parse(&[b' '; 101], &limits).unwrap_err();
    assert!(errors_found.is_limit() && errors_found.to_string().contains("--max-preset-bytes"));
    for (open, close) in [("[", "]"), ("(", ")"), ("Some(", ")"), ("{", "}")] {
        for depth in [129, 100_000] {
            let text = format!("Deform(wires: {}{})", open.repeat(depth), close.repeat(depth));
            let found = parse(text.as_bytes(), &Limits::default()).unwrap_err();
            assert!(found.is_limit(), "{open} {depth}: {found}");
        }
        let start = std::time::Instant::now();
        let text = format!("Deform(wires: {}1{})", open.repeat(120), close.repeat(120));
        assert!(parse(text.as_bytes(), &Limits::default()).is_err());
        assert!(start.elapsed().as_secs() < 5, "{open}: nesting must not cost exponential time");
    }
}
