//! Where errors are that are found only when an effect meets an object.

use wirework_preset::{Effect, Limits, PresetErrorKind, Typed, parse};

const STACK: &str = "Stack([
    Deform(wires: [
        Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)])),
        Wire(curve: Polyline([(0, 0, 1), (1, 0, 1)]), radius: 2),
    ], lattice: Some(Lattice(min: (0, 0, 0), max: (1, 1, 1)))),
    Stack([Wrinkle(pattern: Drawn([Polyline([(0, 0, 0), (1, 0, 0)]), Polyline([(0, 0, 1), (1, 0, 1)])]), thickness: 1.5)]),
    Wrinkle((center: (0, 3, 0), drive: Some(Strain(from: 0.3, to: 0.5)))),
])";

fn effects(text: &str) -> Vec<Effect> {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{errors}")).preset.effects
}

/// What stands at the place of an error about a field, and the path there.
fn at(text: &str, effect: usize, field: &str) -> (String, String) {
    let error = effects(text)[effect].typed.error(field, PresetErrorKind::Value, "no", None);
    let before = &text[..error.span.start];
    let line = 1 + before.matches('\n').count();
    let first = before.rsplit('\n').next().unwrap().trim_start_matches('\u{feff}');
    assert_eq!((error.line, error.column), (line, 1 + first.chars().count()), "{field}");
    assert_eq!((error.message.as_str(), error.kind), ("no", PresetErrorKind::Value));
    (text[error.span].to_owned(), error.path)
}

#[test]
fn an_error_is_at_the_field_as_typed() {
    let place = |effect, field| at(STACK, effect, field);
    let is = |text: &str, path: &str| (text.to_owned(), path.to_owned());
    assert_eq!(place(0, "wires[1].radius"), is("2", "[0].wires[1].radius"));
    assert_eq!(place(0, "wires[1]"), is("Wire", "[0].wires[1]"), "a struct by its name");
    assert_eq!(place(0, "lattice"), is("Lattice", "[0].lattice"), "within `Some`");
    assert_eq!(place(0, "lattice.max[1]"), is("1", "[0].lattice.max[1]"));
    assert_eq!(place(1, "thickness"), is("1.5", "[1][0].thickness"), "a stack within a stack");
    assert_eq!(place(1, "pattern[1]"), is("Polyline([(0, 0, 1), (1, 0, 1)])", "[1][0].pattern[1]"));
    assert_eq!(place(2, "center"), is("(0, 3, 0)", "[2].center"), "within both parentheses");
    assert_eq!(place(2, "drive.from"), is("0.3", "[2].drive.from"));
}

#[test]
fn what_was_not_typed_is_missed_where_it_would_stand() {
    let place = |effect, field| at(STACK, effect, field);
    let is = |text: &str, path: &str| (text.to_owned(), path.to_owned());
    for (effect, path) in [(0, "[0]"), (1, "[1][0]"), (2, "[2]")] {
        let name = if effect == 0 { "Deform" } else { "Wrinkle" };
        assert_eq!(place(effect, ""), is(name, path));
        assert_eq!(place(effect, "size.width[3]"), is(name, path));
    }
    assert_eq!(place(2, "drive.radius"), is("Strain", "[2].drive"));
    assert_eq!(place(1, "pattern[9]").1, "[1][0].pattern");
    let listed = |field| effects(STACK)[0].typed.listed(field);
    assert_eq!(
        [listed("wires"), listed("wires[1].radius"), listed("blend"), listed("")],
        [Some(2), None, None, None]
    );
    for odd in ["[0", "]", "..", "wires[x]", "wires[-1].radius", "[", "center[99999999999999999999]"] {
        place(0, odd);
    }
}

#[test]
fn a_lone_effect_and_a_byte_order_mark() {
    let text = "\u{feff}\n  Wrinkle(center: (0, 3, 0))";
    assert_eq!(at(text, 0, "center"), ("(0, 3, 0)".to_owned(), "center".to_owned()));
    assert_eq!(at(text, 0, ""), ("Wrinkle".to_owned(), String::new()));
    assert_eq!(at("\u{feff}Wrinkle()", 0, "size"), ("Wrinkle".to_owned(), String::new()));
}

#[test]
fn an_effect_of_a_program_stands_nowhere() {
    let error = Typed::default().error("center", PresetErrorKind::Name, "no", Some("help".to_owned()));
    assert_eq!((error.line, error.column, error.span, error.path.as_str()), (1, 1, 0..0, ""));
    assert_eq!((error.kind, error.help.as_deref()), (PresetErrorKind::Name, Some("help")));
    // Wherever they stand, equal effects are equal, and a message that shows one stays short.
    let [one, two] = ["Wrinkle()", "\n\nWrinkle(creases: 5)"].map(|text| effects(text).remove(0));
    assert_eq!(one, two);
    assert!(format!("{:?}", one.typed).len() < 20);
}
