//! Whatever the bytes are: no panic, and an error lies within the source.

use proptest::prelude::*;
use wirework_preset::{Limits, TEMPLATES, parse, template};

/// Reads bytes and checks what every answer must be.
fn read(bytes: &[u8]) {
    let Err(errors) = parse(bytes, &Limits::default()) else { return };
    assert!(!errors.errors().is_empty());
    for error in errors.errors() {
        assert!(error.span.start <= error.span.end && error.span.end <= bytes.len(), "{error:?}");
        assert!(error.line >= 1 && error.column >= 1);
        assert!(error.message.len() < 2_000 && !error.message.chars().any(char::is_control), "{error:?}");
        if let Ok(text) = std::str::from_utf8(bytes) {
            assert!(
                text.is_char_boundary(error.span.start) && text.is_char_boundary(error.span.end),
                "{error:?}"
            );
        }
    }
}

fn source() -> impl Strategy<Value = Vec<u8>> {
    prop::sample::select(TEMPLATES.to_vec()).prop_map(|name| template(name).unwrap().as_bytes().to_vec())
}

/// Pieces of presets, and what breaks parsers.
const TOKENS: &[&str] = &[
    "Deform",
    "Wrinkle",
    "Stitch",
    "Ik",
    "Joints",
    "Skin",
    "Rounded",
    "Hold",
    "Radius",
    "Curve",
    "Node",
    "Stack",
    "Piece",
    "Seam",
    "Edge",
    "Tear",
    "UMax",
    "Auto",
    "Wire",
    "Keys",
    "Ease",
    "Some",
    "None",
    "Locator",
    "Domain",
    "WireLattice",
    "Move",
    "Lattice",
    "Blended",
    "Nodes",
    "Image",
    "BSpline",
    "Grid",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "::",
    " ",
    "\n",
    "//",
    "/*",
    "*/",
    "\"",
    "\\",
    "'",
    "'a'",
    "b'x'",
    "r\"",
    "r#\"",
    "\"#",
    "r#a",
    "b\"",
    "br\"",
    "#![enable(implicit_some)]",
    "#!",
    "0",
    "-1",
    "1e400",
    "0x1F",
    "1_000",
    "1..2",
    "..",
    "inf",
    "-inf",
    "NaN",
    "true",
    "false",
    "()",
    "wires:",
    "curve:",
    "points:",
    "object:",
    "radius:",
    "reference:",
    "direction:",
    "moves:",
    "patches:",
    "seams:",
    "piece:",
    "side:",
    "from:",
    "loop:",
    "tears:",
    "lines:",
    "chain:",
    "goal:",
    "pins:",
    "stiffness:",
    "limits:",
    "root:",
    "tip:",
    "only:",
    "version:",
    "é",
    "🦀",
    "\u{feff}",
    "\u{200e}",
    "\u{0}",
    "ª",
    "x.y",
    "+",
    "-",
    ".",
    "1f32",
    "2u8",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn truncated_presets(bytes in source(), at in 0.0..1.0_f64) {
        let end = (bytes.len() as f64 * at) as usize;
        read(&bytes[..end]);
        read(&bytes[end..]);
    }

    #[test]
    fn edited_presets(mut bytes in source(), edits in prop::collection::vec((0.0..1.0_f64, any::<u8>(), 0_u8..3), 1..6)) {
        for (at, byte, what) in edits {
            let at = (bytes.len() as f64 * at) as usize;
            match what {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => drop(bytes.remove(at)),
            }
        }
        read(&bytes);
    }

    #[test]
    fn swapped_tokens(bytes in source(), edits in prop::collection::vec((0.0..1.0_f64, 0..TOKENS.len(), 0_usize..6), 1..4)) {
        let mut text = String::from_utf8(bytes).unwrap();
        for (at, token, length) in edits {
            let start = text.floor_char_boundary((text.len() as f64 * at) as usize);
            let end = text.floor_char_boundary((start + length).min(text.len()));
            text.replace_range(start..end.max(start), TOKENS[token]);
        }
        read(text.as_bytes());
    }

    #[test]
    fn token_soup(tokens in prop::collection::vec(0..TOKENS.len(), 0..40)) {
        let text: String = tokens.into_iter().map(|i| TOKENS[i]).collect();
        read(text.as_bytes());
        read(format!("Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), pose: {text})])").as_bytes());
        read(format!("Stitch(patches: [{text}], seams: [Seam(a: Edge(piece: \"a\", {text}), b: {text}, tears: [{text}])])").as_bytes());
        read(format!("Ik(chain: {text}, goal: {text}, pins: [{text}], pole: {text})").as_bytes());
        read(format!("Ik(chain: Joints([(0, 0, 0), (1, 0, 0), {text}]), goal: Curve({text}), limits: [{text}], {text})").as_bytes());
    }

    #[test]
    fn any_text(text in "\\PC{0,60}") {
        read(text.as_bytes());
        read(format!("Deform({text})").as_bytes());
    }

    /// `ron` decides what is RON: what it accepts is never called a syntax error, and never read differently.
    #[test]
    fn the_tree_agrees_with_ron(tokens in prop::collection::vec(0..TOKENS.len(), 0..12)) {
        let value: String = tokens.into_iter().map(|i| TOKENS[i]).collect();
        let text = format!("Deform(wires: [{value}])");
        let valid = ron::from_str::<serde::de::IgnoredAny>(&text).is_ok();
        // Maps and ranges are RON, but stand in no preset.
        if valid && !text.contains(['{', '}']) && !text.contains("..") && let Err(errors) = parse(text.as_bytes(), &Limits::default()) {
            for error in errors.errors() {
                prop_assert_ne!(error.kind, wirework_preset::PresetErrorKind::Syntax, "{}\n{}", text, error);
            }
        }
    }
}

#[test]
fn every_prefix_of_a_template() {
    for name in TEMPLATES {
        let text = template(name).unwrap();
        for end in (0..text.len()).step_by(7) {
            read(&text.as_bytes()[..end]);
        }
    }
}

#[test]
fn a_large_preset_takes_a_moment_only() {
    use std::fmt::Write as _;
    let mut text = "Deform(wires: [Wire(curve: Polyline(points: [".to_owned();
    for i in 0..100_000 {
        write!(text, "({}, 0.25, -1e-3), ", f64::from(i) * 0.01).unwrap();
    }
    text.push_str("]), scale: 2)])");
    let start = std::time::Instant::now();
    assert!(parse(text.as_bytes(), &Limits::default()).is_ok());
    // Some 0.1 s here; more than linear time would be minutes.
    println!("{} bytes in {:?}", text.len(), start.elapsed());
    assert!(start.elapsed().as_secs() < 10);
}

/// `count` pieces of a preset; `#` becomes the number of each.
fn repeated(piece: &str, count: usize) -> String {
    (0..count).map(|i| piece.replace('#', &i.to_string())).collect()
}

#[test]
fn much_of_anything_takes_a_moment_only() {
    for (before, piece, after) in [
        ("Deform(", "a#: 0,", ")"),
        ("Deform(", "a: 0,", ")"),
        ("Deform(only: Nodes([", "\"#\",", "]))"),
        ("Deform(only: Nodes([", "\"a\",", "]))"),
        ("Deform(wires: [", "Wire(curve: Polyline([(0, 0, 0)]), group: \"#\"),", "])"),
        ("Deform(wires: [Wire(curve: Polyline([(0, 0, 0)]), locators: [", "Locator(u: 0),", "])])"),
        ("Deform(wires: [Wire(curve: Polyline([", "(0, true, 0),", "]))])"),
        ("Stitch(patches: [", "\"#\",", "], seams: [])"),
        ("Stitch(patches: [", "\"a\",", "], seams: [])"),
        ("Stitch(patches: [\"abc\"], seams: [", "Seam(a: Edge(piece: \"b#\", loop: (0, 0, 0))),", "])"),
        (
            "Stitch(seams: [",
            "Seam(a: Edge(piece: \"#\", side: UMin), b: Edge(piece: \"b#\", side: UMin)),",
            "])",
        ),
        ("Stitch(seams: [Seam(tears: [", "Tear(at: 2, width: 0),", "])])"),
        ("Ik(goal: (1, 0, 0), chain: Joints([", "(#, 0, 0),", "]))"),
        ("Ik(goal: (1, 0, 0), chain: Joints([", "(0, 0, 0),", "]))"),
        ("Ik(chain: Skin(\"a\", \"b\"), goal: (1, 0, 0), pins: [", "(#, (0, 0, 0)),", "])"),
        ("Ik(chain: Skin(\"a\", \"b\"), goal: (1, 0, 0), pins: [", "(1, (0, 0, 0)),", "])"),
        ("Ik(chain: Skin(\"a\", \"b\"), goal: (1, 0, 0), limits: [", "0,", "])"),
        ("Ik(chain: Skin(\"a\", \"b\"), goal: Curve(CatmullRom([", "(#, 1, 0),", "])))"),
    ] {
        let text = format!("{before}{}{after}", repeated(piece, 40_000));
        let start = std::time::Instant::now();
        let noted = match parse(text.as_bytes(), &Limits::default()) {
            Ok(parsed) => parsed.warnings.len(),
            Err(errors) => errors.errors().len(),
        };
        // Some 0.2 s here without optimization; where time is quadratic, more than 10 s.
        assert!(start.elapsed().as_secs() < 5, "{piece}: {:?}", start.elapsed());
        assert!(noted <= 32, "{piece}: {noted}");
    }
}
