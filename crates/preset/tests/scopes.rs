//! `only`, `mask` and `units`: what they become, and what is said about bad ones.

mod common;

use common::{check, errors};
use wirework_core::Curve;
use wirework_preset::{
    Action, Channel, Effect, KeyedWire, Limits, Mask, Named, Only, Parsed, PresetErrorKind, Typed, Units,
    parse,
};
use wirework_wrinkle::Wrinkle;

const WIRE: &str = "curve: Polyline([(0, 0, 0), (1, 0, 0)]), scale: 2";

fn parsed(text: &str) -> Parsed {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{text}\n{errors}"))
}

/// A deformation and a wrinkle with the same fields.
fn effects(fields: &str) -> [String; 2] {
    [
        format!("Deform(wires: [Wire({WIRE})], {fields})"),
        format!("Wrinkle(pattern: Drawn([Polyline([(0, 0, 0), (1, 0, 0)])]), {fields})"),
    ]
}

fn effect(text: &str) -> Effect {
    parsed(text).preset.effects.remove(0)
}

fn wire(fields: &str) -> KeyedWire {
    match effect(&format!("Deform(wires: [Wire({WIRE}, {fields})])")).action {
        Action::Deform(mut deform) => deform.wires.remove(0),
        Action::Wrinkle(_) | Action::Stitch(_) | Action::Ik(_) => panic!(),
    }
}

fn names(only: Option<&Only>) -> Vec<&str> {
    only.map_or_else(Vec::new, |only| only.names().iter().map(|name| name.name.as_str()).collect())
}

#[test]
fn every_effect_has_a_scope() {
    for text in effects("") {
        let effect = effect(&text);
        assert_eq!((effect.only, effect.mask, effect.units), (None, None, Units::Metres));
    }
    for text in effects("only: Nodes([\"a\", \"b c\"]), mask: VertexColor(A), units: Bounds") {
        let effect = effect(&text);
        assert!(matches!(effect.only, Some(Only::Nodes(_))));
        assert_eq!(names(effect.only.as_ref()), ["a", "b c"]);
        assert_eq!(
            (effect.mask, effect.units),
            (Some(Mask::VertexColor { channel: Channel::A, typed: Named::new("A") }), Units::Bounds)
        );
    }
    for text in effects("only: None, mask: None, units: Metres") {
        assert_eq!(effect(&text).only, None);
    }
}

#[test]
fn a_stack_keeps_the_scope_of_each_effect() {
    let [first, second] = effects("only: Joints([\"arm\"])");
    let [third, _] = effects("units: Bounds");
    let stack = parsed(&format!("Stack([{first}, Stack([{second}, {third}])])")).preset;
    let found: Vec<_> = stack.effects.iter().map(|e| (names(e.only.as_ref()).len(), e.units)).collect();
    assert_eq!(found, [(1, Units::Metres), (1, Units::Metres), (0, Units::Bounds)]);
}

#[test]
fn a_wire_has_its_own_scope() {
    assert_eq!((wire("").only(), wire("").mask()), (None, None));
    let wire = wire("only: Some(Materials([\"skin\"])), mask: Image(\"a/b.png\")");
    assert_eq!((names(wire.only()), wire.only().map(Only::what)), (vec!["skin"], Some("material")));
    let Some(Mask::Image { file, channel }) = wire.mask() else { panic!() };
    assert_eq!((file.name.as_str(), *channel), ("a/b.png", Channel::R));
}

#[test]
fn an_image_names_its_channel_or_takes_red() {
    for (mask, expected) in [
        ("Image(\"m.png\")", Channel::R),
        ("Image(\"m.png\", G)", Channel::G),
        ("Image(file: \"m.png\")", Channel::R),
        ("Image(channel: B, file: \"m.png\")", Channel::B),
    ] {
        let Some(Mask::Image { file, channel }) = wire(&format!("mask: {mask}")).mask().cloned() else {
            panic!()
        };
        assert_eq!((file.name.as_str(), channel), ("m.png", expected), "{mask}");
    }
}

#[test]
fn a_name_knows_its_place() {
    let text = "Deform(\n  only: Joints([\"hip\",\n    \"elbo_L\"]),\n  wires: [Wire(curve: Polyline([(0, 0, 0)]), scale: 2)],\n)";
    let mut bytes = b"\xef\xbb\xbf".to_vec();
    bytes.extend_from_slice(text.as_bytes());
    let preset = parse(&bytes, &Limits::default()).unwrap().preset;
    let only = preset.effects[0].only.clone().unwrap();
    let name = &only.names()[1];
    let error = name.unknown(only.what(), &["hip", "elbow_L", "elbow_R"]);
    assert_eq!((error.line, error.column, error.path.as_str()), (3, 5, "only[1]"));
    assert_eq!(bytes.get(error.span.clone()), Some(&b"\"elbo_L\""[..]));
    assert_eq!(error.message, "there is no joint \"elbo_L\"; there are \"hip\", \"elbow_L\", \"elbow_R\"");
    assert_eq!(
        (error.help.as_deref(), error.kind),
        (Some("did you mean \"elbow_L\"?"), PresetErrorKind::Name)
    );
    assert_eq!(name.unknown("joint", &[]).message, "there is no joint \"elbo_L\"; there are none");
    let many: Vec<String> = (0..30).map(|i| format!("bone{i}\n")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let error = name.unknown("joint", &many);
    assert!(error.message.ends_with("and 22 more") && !error.message.contains('\n'), "{}", error.message);
    assert_eq!(error.help, None);
    let refused = name.refused("no image here");
    assert_eq!(
        (refused.line, refused.kind, refused.message.as_str()),
        (3, PresetErrorKind::Value, "no image here")
    );
}

#[test]
fn a_program_writes_effects_as_a_preset_does() {
    let file = Named::new("m.png");
    let written = Effect {
        action: Action::Wrinkle(Box::new(Wrinkle::drawn(vec![
            Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0]]).unwrap(),
        ]))),
        only: Some(Only::Joints(vec![Named::new("arm")])),
        mask: Some(Mask::Image { file: file.clone(), channel: Channel::B }),
        refine: false,
        typed: Typed::default(),
        units: Units::Bounds,
    };
    let [_, text] = effects("only: Joints([\"arm\"]), mask: Image(\"m.png\", B), units: Bounds");
    assert_eq!(written, effect(&text));
    let error = file.refused("no image here");
    assert_eq!((error.line, error.column, error.span, error.path.as_str()), (1, 1, 0..0, ""));
}

#[test]
fn equal_names_are_equal_wherever_they_stand() {
    let named = |text: &str| -> Named {
        let Some(Only::Nodes(names)) = effect(text).only else { panic!() };
        names[0].clone()
    };
    let [a, b] = effects("only: Nodes([\"a\"])");
    assert_eq!(named(&a), named(&b));
    assert_ne!(named(&a), named(&b.replace("\"a\"", "\"b\"")));
}

#[test]
fn bad_scopes_are_refused_at_their_place() {
    use PresetErrorKind::{Name, Value};
    for (field, kind, message, help) in [
        ("only: «Nodes([])»", Value, "`Nodes` needs at least one name", None),
        ("only: «Joints»", Value, "expected a list of names `Joints([\"name\", ..])`", None),
        (
            "only: Joints(«\"arm\"»)",
            Value,
            "expected a list of names `Joints([\"name\", ..])`, found the text",
            None,
        ),
        ("only: Joints([«7»])", Value, "expected a name in quotes, found `7`", None),
        (
            "only: «[\"arm\"]»",
            Value,
            "expected `Nodes([\"name\", ..])`, `Materials([..])` or `Joints([..])`",
            None,
        ),
        ("only: «Joint»([\"arm\"])", Name, "no value of `only` `Joint`", Some("did you mean `Joints`?")),
        ("mask: VertexColor(«X»)", Name, "no channel `X`; expected `R`, `G`, `B` or `A`", None),
        ("mask: VertexColor(«r»)", Name, "no channel `r`", Some("did you mean `R`?")),
        ("mask: «VertexColor»", Value, "expected `VertexColor(R)` or `Image(\"mask.png\", R)`", None),
        ("mask: «VertexColour»(R)", Name, "no mask `VertexColour`", Some("did you mean `VertexColor`?")),
        ("mask: Image(«\"\"»)", Value, "a path must not be empty", None),
        ("mask: Image(«7», R)", Value, "the path of an image in quotes", None),
        ("mask: «Image(\"a\", R, G)»", Value, "expected `Image(\"mask.png\", R)`", None),
        ("mask: Image(«fiel»: \"a.png\")", Name, "no field `fiel`", Some("did you mean `file`?")),
        ("units: «Metre»", Name, "no value of `units` `Metre`", Some("did you mean `Metres`?")),
        ("units: «Bounds(1)»", Value, "`Bounds` stands alone", None),
    ] {
        for text in effects(field) {
            check(&text, kind, message, help);
        }
        if !field.starts_with("units") {
            check(&format!("Deform(wires: [Wire({WIRE}, {field})])"), kind, message, help);
        }
    }
    let on_a_wire = format!("Deform(wires: [Wire({WIRE}, «units»: Bounds)])");
    check(&on_a_wire, Name, "`Wire` has no field `units`", None);
}

#[test]
fn a_name_that_stands_twice_is_a_warning() {
    let text = format!("Deform(wires: [Wire({WIRE})], only: Nodes([\"a\", \"b\", \"a\"]))");
    let found = parsed(&text).warnings;
    let [warning] = found.as_slice() else { panic!("{found:?}") };
    assert_eq!((warning.message.as_str(), warning.path.as_str()), ("\"a\" stands here twice", "only[2]"));
    assert_eq!(warning.span.start, text.rfind("\"a\"").unwrap());
}

#[test]
fn the_points_of_a_lattice_have_no_names_and_no_colours() {
    let lattice = "lattice: Lattice(min: (0, 0, 0), max: (1, 1, 1))";
    for field in ["only: «Nodes([\"a\"])»", "mask: «VertexColor(R)»"] {
        let text = format!("Deform(wires: [Wire({WIRE}, {field})], {lattice})");
        check(&text, PresetErrorKind::Value, "cannot move a lattice", None);
    }
    let text = format!(
        "Deform(wires: [Wire({WIRE}, only: None)], {lattice}, only: Nodes([\"a\"]), mask: VertexColor(R))"
    );
    assert_eq!(errors(&text), []);
}
