//! `Stitch`: what it says, and what is said about it where it is wrong or odd.

mod common;

use common::{check, errors};
use wirework_core::{Density, Keyed};
use wirework_preset::{Action, Limits, Parsed, PresetErrorKind, Shape, Stitching, Units, parse};
use wirework_stitch::{
    Continuity, Edge, Order, Pairing, Reversed, Run, Seam, Side, Stitch, StitchError, Tear,
};

fn parsed(text: &str) -> Parsed {
    parse(text.as_bytes(), &Limits::default()).unwrap_or_else(|errors| panic!("{text}\n{errors}"))
}

fn stitching(text: &str) -> Stitching {
    match parsed(text).preset.effects.remove(0).action {
        Action::Stitch(stitching) => *stitching,
        other => panic!("{other:?}"),
    }
}

/// The edges of a seam of two nodes.
const EDGES: &str = "a: Edge(piece: \"a\", side: UMax), b: Edge(piece: \"b\", side: UMin)";

/// A stitch of two nodes with more fields of its one seam.
fn in_seam(fields: &str) -> String {
    format!("Stitch(\n  seams: [\n    Seam({EDGES}, {fields}),\n  ],\n)")
}

fn in_tear(fields: &str) -> String {
    in_seam(&format!("tears: [Tear(at: 0.5, width: 0.2), Tear({fields})]"))
}

/// A stitch with an edge `a`, of two pieces: a grid and a tube.
fn with_edge(edge: &str) -> String {
    format!(
        "Stitch(patches: [Piece(name: \"sheet\", object: Grid(size: (1, 1))),\n  Piece(name: \"sleeve\", object: Tube(from: \
         (0, 0, 0), to: (1, 0, 0), radius: 1, caps: false))],\n  seams: [Seam(a: {edge}, b: Edge(piece: \"sheet\", \
         side: VMin))])"
    )
}

/// A stitch with pieces.
fn with_patches(patches: &str) -> String {
    format!("Stitch(\n  patches: [{patches}],\n  seams: [Seam({EDGES})])")
}

fn names(stitching: &Stitching) -> Vec<&str> {
    stitching.pieces.iter().map(|piece| piece.name.name.as_str()).collect()
}

fn ease(keys: &[(f64, f32)]) -> Keyed<f32> {
    Keyed::keys(keys.to_vec(), true).expect("keys")
}

#[test]
fn what_is_left_out_is_the_default() {
    let found = stitching(&format!("Stitch(seams: [({EDGES})])"));
    let edge = |piece, side| Edge { piece, run: Run::Side(side) };
    let seam = Seam::new(edge(0, Side::UMax), edge(1, Side::UMin));
    assert_eq!(found.stitch, Stitch { seams: vec![seam], order: Order::Simultaneous });
    assert_eq!(names(&found), ["a", "b"]);
    let torn = stitching(&in_seam("tears: [(at: 0.5, width: 0.25)]"));
    assert_eq!(torn.stitch.seams[0].tears, [Tear::new(0.5, 0.25)]);
}

#[test]
fn every_field_is_read() {
    let found = stitching(
        "Stitch(
            patches: [Piece(name: \"front\", object: Patch(points: [[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]])),
                      Piece(name: \"back\"), \"collar\"],
            seams: [
                Seam(a: Edge(piece: \"front\", side: VMax), b: Edge(piece: \"back\", from: (1, 2, 3), to: (4, 5, 6)),
                     reversed: true, bias: 0.25, closure: Ease([(0, 0), (1, 0.5)]), radius: 0.5, scale: -2,
                     density: Sextic, correspondence: Parameter, continuity: Tangent, weld: false),
                Seam(a: Edge(piece: \"collar\", loop: (7, 8, 9)), b: Edge(piece: \"back\", from: (1, 2, 3), to: (4, 5, 6), long: true),
                     reversed: false, correspondence: Closest, weld: true, tears: [
                        Tear(at: 0.125, width: Keys([(0, 0), (3, 1)]), opening: 0.75, gape: -0.5, plateau: 0.375)]),
            ],
            order: Sequential, only: Nodes([\"x\"]), units: Bounds,
        )",
    );
    assert_eq!(names(&found), ["front", "back", "collar"]);
    let patch = found.pieces[0].object.as_ref().map(|object| &object.shape);
    assert!(matches!(patch, Some(Shape::Patch { .. })));
    assert!(found.pieces[1].object.is_none() && found.pieces[2].object.is_none());
    let between =
        |long| Edge { piece: 1, run: Run::Between { from: [1.0, 2.0, 3.0], to: [4.0, 5.0, 6.0], long } };
    let first = Seam {
        reversed: Reversed::Given(true),
        bias: Keyed::Constant(0.25),
        closure: ease(&[(0.0, 0.0), (1.0, 0.5)]),
        radius: Keyed::Constant(0.5),
        scale: Keyed::Constant(-2.0),
        density: Density::Sextic,
        pairing: Pairing::Parameter,
        continuity: Continuity::Tangent,
        ..Seam::new(Edge { piece: 0, run: Run::Side(Side::VMax) }, between(false))
    };
    let tear = Tear {
        width: Keyed::keys(vec![(0.0, 0.0), (3.0, 1.0)], false).expect("keys"),
        opening: Keyed::Constant(0.75),
        gape: Keyed::Constant(-0.5),
        plateau: Keyed::Constant(0.375),
        ..Tear::new(0.125, 1.0)
    };
    let second = Seam {
        reversed: Reversed::Given(false),
        pairing: Pairing::Closest,
        weld: true,
        tears: vec![tear],
        ..Seam::new(Edge { piece: 2, run: Run::Loop([7.0, 8.0, 9.0]) }, between(true))
    };
    assert_eq!(found.stitch, Stitch { seams: vec![first, second], order: Order::Sequential });
    assert_eq!(found.stitch.check(), Ok(()));
}

#[test]
fn pieces_are_numbered_as_they_are_listed_or_first_used() {
    let seams = "seams: [Seam(a: Edge(piece: \"b\", side: UMax), b: Edge(piece: \"a\", side: UMin)),
                         Seam(a: Edge(piece: \"a\", side: UMax), b: Edge(piece: \"c\", side: UMin))]";
    for patches in ["", "patches: [], "] {
        let found = stitching(&format!("Stitch({patches}{seams})"));
        assert_eq!(names(&found), ["b", "a", "c"]);
        assert_eq!(found.stitch.seams[1].a.piece, 1);
        let error = found.pieces[2].name.unknown("node", &["d", "sleeve"]);
        assert_eq!((error.line, error.column, error.path.as_str()), (2, 79, "seams[1].b.piece"));
    }
    let found = stitching(&format!("Stitch(patches: [\"c\", \"a\", (name: \"b\", object: None)], {seams})"));
    assert_eq!(names(&found), ["c", "a", "b"]);
    assert_eq!(found.stitch.seams[1].b.piece, 0);
    let error = found.pieces[0].name.refused("it has no faces");
    assert_eq!((error.column, error.path.as_str()), (18, "patches[0]"));
    assert_eq!(found.pieces[2].name.refused("").path, "patches[2].name");
}

#[test]
fn what_moves_is_as_long_as_its_last_key() {
    let of = |text: &str| {
        let preset = parsed(text).preset;
        (preset.duration, preset.animated)
    };
    assert_eq!(of(&in_seam("")), (0.0, false));
    for field in ["bias", "closure", "radius", "scale"] {
        assert_eq!(of(&in_seam(&format!("{field}: Keys([(0, 1), (2.5, 0.5)])"))), (2.5, true), "{field}");
    }
    for field in ["opening", "gape", "plateau"] {
        let keys = format!("at: 0, width: 1, {field}: Ease([(0, 0), (4, 1)])");
        assert_eq!(of(&in_tear(&keys)), (4.0, true), "{field}");
    }
    assert_eq!(of(&in_tear("at: Keys([(0, 0.5), (3, 0.5)]), width: 1")), (3.0, false));
    assert_eq!(of(&in_tear("at: 1, width: Keys([(0, 0), (3, 0.5)])")), (3.0, true));
    let short = in_seam("bias: Keys([(0, 0), (3, 1)])").replace("Stitch(", "Stitch(duration: 2,");
    assert_eq!(of(&short), (2.0, true));
    assert_eq!(parsed(&short).warnings[0].path, "duration");
}

#[test]
fn values_out_of_range_are_refused_at_the_value() {
    use PresetErrorKind::Value;
    for (field, message) in [
        ("bias: «1.5»", "`bias` must lie from 0 to 1, found 1.5"),
        ("closure: Keys([(0, 0), (1, «-0.5»)])", "`closure` must lie from 0 to 1"),
        ("closure: Keys([(1, 0), («1», 0.5)])", "after the one before"),
        ("radius: «0»", "`radius` must be greater than 0"),
        ("radius: Ease([(0, 1), (1, «0»)])", "greater than 0"),
        ("scale: «NaN»", "`scale` must be a finite number"),
        ("reversed: «1»", "expected `Auto`, `true` or `false`, found `1`"),
        ("reversed: «Auto(1)»", "stands alone"),
        ("weld: «1»", "`true` or `false`"),
        ("tears: «1»", "a list of tears"),
        ("density: «1»", "`Quartic`"),
    ] {
        check(&in_seam(field), Value, message, None);
    }
    for (fields, message) in [
        (
            "at: «1.5», width: 0.2",
            "`at` must lie from 0 to 1, found 1.5: there the tear lies outside the seam",
        ),
        ("at: Keys([(0, 0), (1, «-0.25»)]), width: 0.2", "outside the seam"),
        ("at: «NaN», width: 0.2", "`at` must be a finite number"),
        ("at: 0, width: «0»", "`width` must be greater than 0"),
        ("at: 0, width: Keys([(0, 0), (1, «-1»)])", "`width` must be 0 or greater"),
        ("at: 0, width: 1, opening: «2»", "`opening` must lie from 0 to 1"),
        ("at: 0, width: 1, gape: «inf»", "`gape` must be a finite number"),
        ("at: 0, width: 1, plateau: «-1»", "`plateau` must lie from 0 to 1"),
    ] {
        check(&in_tear(fields), Value, message, None);
    }
    check("Stitch(seams: «[]»)", Value, "a stitch needs at least one seam", None);
    check("Stitch(seams: «1»)", Value, "a list of seams", None);
    assert_eq!(StitchError::NoSeams.to_string(), errors("Stitch(seams: [])")[0].message);
    let place = &errors(&in_tear("at: 2, width: 0.2"))[0];
    assert_eq!((place.line, place.path.as_str()), (3, "seams[0].tears[1].at"));
}

#[test]
fn names_that_do_not_exist_are_refused_with_the_nearest_one() {
    use PresetErrorKind::Name;
    let long = "tears: [Tear(at: 0, width: 1, «openin»: 1)]";
    for (field, message, help) in [
        ("«stitched»: 1", "`Seam` has no field `stitched`; expected `a`, `b`, `reversed`", None),
        ("«radios»: 1", "no field `radios`", Some("`radius`")),
        (long, "`Tear` has no field `openin`", Some("`opening`")),
        ("reversed: «Aut»", "no value of `reversed` `Aut`; expected `Auto`, `true` or", Some("`Auto`")),
        ("correspondence: «Arclenght»", "no correspondence", Some("`ArcLength`")),
        ("continuity: «Tangents»", "no continuity", Some("`Tangent`")),
        ("density: «Quartik»", "no density", Some("`Quartic`")),
        ("bias: «Kyes»([(0, 1)])", "a number, `Keys", Some("`Keys`")),
        ("tears: [«Tears»(at: 0, width: 1)]", "no struct `Tears`", Some("`Tear`")),
    ] {
        check(&in_seam(field), Name, message, help);
    }
    let order = format!("Stitch(seams: [Seam({EDGES})], order: «Sequentiel»)");
    check(&order, Name, "no order `Sequentiel`", Some("`Sequential`"));
    check("«Stich»(seams: [])", Name, "no effect `Stich`", Some("`Stitch`"));
    let patch = format!("Stitch(«patch»: [], seams: [Seam({EDGES})])");
    check(&patch, Name, "`Stitch` has no field `patch`; expected", Some("`patches`"));
    check("«Stitch»()", Name, "`Stitch` needs a field `seams`", None);
    let one = "Stitch(seams: [«Seam»(a: Edge(piece: \"a\", side: UMax))])";
    check(one, Name, "`Seam` needs a field `b`", None);
    check(&in_tear("width: 1").replace("), Tear", "), «Tear»"), Name, "`Tear` needs a field `at`", None);
    check(&in_tear("at: 1").replace("), Tear", "), «Tear»"), Name, "`Tear` needs a field `width`", None);
    check(&with_patches("«Piece»(object: None)"), Name, "`Piece` needs a field `name`", None);
    check(
        &with_patches("\"a\", Piece(name: \"b\", «objet»: None)"),
        Name,
        "no field `objet`",
        Some("`object`"),
    );
}

#[test]
fn an_edge_names_one_of_the_pieces() {
    let edge = "Edge(piece: «\"sleve\"», side: UMax)";
    let message = "there is no piece \"sleve\"; there are \"sheet\", \"sleeve\"";
    check(&with_edge(edge), PresetErrorKind::Name, message, Some("did you mean \"sleeve\"?"));
    let error = &errors(&with_edge(edge).replace(['«', '»'], ""))[0];
    assert_eq!((error.line, error.column, error.path.as_str()), (3, 31, "seams[0].a.piece"));
    check(&with_edge("Edge(piece: «3», side: UMax)"), PresetErrorKind::Value, "the name of a piece", None);
    let empty =
        "Stitch(seams: [Seam(a: Edge(piece: «\"\"», side: UMax), b: Edge(piece: \"b\", side: UMin))])";
    check(empty, PresetErrorKind::Value, "a piece needs a name", None);
    // What is wrong with the pieces is all that is said where their names may be those that were meant.
    check(
        &with_patches("\"a\", Piece(name: «2»)"),
        PresetErrorKind::Value,
        "the name of a piece in quotes",
        None,
    );
}

#[test]
fn an_edge_is_said_in_one_way() {
    use PresetErrorKind::{Name, Value};
    let point = "(0, 0, 0)";
    for (edge, kind, message) in [
        ("«Edge»(piece: \"sheet\")", Name, "needs a field `side`, or `from` and `to`, or `loop`"),
        ("«Edge»(piece: \"sheet\", side: None)", Name, "needs a field `side`, or"),
        ("«Edge»(piece: \"sheet\", long: true)", Name, "needs a field `side`, or"),
        ("«Edge»(piece: \"sheet\", from: P)", Name, "needs a field `to`: `from` and `to` go together"),
        ("«Edge»(piece: \"sheet\", to: P, long: true)", Name, "needs a field `from`"),
        ("«Edge»(side: UMax)", Name, "`Edge` needs a field `piece`"),
        ("«Edge(piece: \"sheet\", side: UMax, loop: P)»", Value, "this one has `side` and `loop`"),
        ("«Edge(piece: \"sheet\", side: UMax, to: P)»", Value, "has `side` and `from` and `to`"),
        ("«Edge(piece: \"sheet\", loop: P, from: P, to: P, side: VMin)»", Value, "an edge is a `side`, or"),
        ("Edge(piece: \"sheet\", side: UMax, long: «true»)", Value, "`long` is which way to go"),
        ("Edge(piece: \"sheet\", loop: P, long: «false»)", Value, "`long` is which way to go"),
        ("Edge(piece: \"sheet\", from: P, to: P, long: «1»)", Value, "`true` or `false`"),
        ("Edge(piece: \"sheet\", from: «1», to: P)", Value, "a point `(x, y, z)`"),
        ("Edge(piece: \"sheet\", loop: (0, 0, «NaN»))", Value, "finite"),
        ("Edge(piece: \"sheet\", side: «\"UMax\"»)", Value, "expected `UMin`, `UMax`, `VMin` or `VMax`"),
        ("«\"sheet\"»", Value, "`Edge(field: value, ..)`"),
        ("Edge(piece: \"sleeve\", side: «UMin»)", Value, "only patches and grids of a preset have the sides"),
    ] {
        check(&with_edge(&edge.replace('P', point)), kind, message, None);
    }
    for (edge, message, near) in [
        ("Edge(piece: \"sheet\", side: «UMx»)", "there is no side `UMx`", "`UMax`"),
        ("Edge(piece: \"sheet\", «sid»: UMax)", "`Edge` has no field `sid`", "`side`"),
        ("Edge(piece: \"sheet\", «form»: P, to: P)", "`Edge` has no field `form`", "`from`"),
        ("Edge(«pice»: \"sheet\", side: UMax)", "`Edge` has no field `pice`", "`piece`"),
    ] {
        check(&with_edge(&edge.replace('P', point)), Name, message, Some(near));
    }
    let path = |edge: &str| errors(&with_edge(edge))[0].path.clone();
    assert_eq!(path("Edge(piece: \"sleeve\", side: UMin)"), "seams[0].a.side");
    assert_eq!(path("Edge(piece: \"sheet\", side: UMin, long: true)"), "seams[0].a.long");
    assert_eq!(path("Edge(piece: \"sheet\")"), "seams[0].a");
    let spelt_out = "Edge(piece: \"sheet\", side: Some(UMax), from: None, to: None, long: None, loop: None)";
    assert_eq!(errors(&with_edge(spelt_out)), []);
    assert_eq!(errors(&with_edge("Edge(piece: \"sleeve\", loop: (0, 0, 0))")), []);
}

#[test]
fn both_edges_of_a_seam_are_not_one() {
    for edge in [
        "Edge(piece: \"a\", side: UMax)",
        "Edge(piece: \"a\", loop: (0, 1, 2))",
        "Edge(piece: \"a\", from: (0, 1, 2), to: (3, 4, 5))",
    ] {
        let text = format!("Stitch(seams: [«Seam»(a: {edge}, b: {edge})])");
        check(&text, PresetErrorKind::Value, "both edges run along the same border", None);
    }
    let sides = "Stitch(seams: [Seam(a: Edge(piece: \"a\", side: UMin), b: Edge(piece: \"a\", side: UMax))])";
    assert_eq!(errors(sides), []);
}

#[test]
fn pieces_are_refused_at_their_place() {
    use PresetErrorKind::{Limit, Name, Value};
    let patch = "Patch(points: [[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]], deform: «ControlPoints»)";
    let deform = format!("Piece(name: \"a\", object: {patch}), \"b\"");
    for (patches, kind, message) in [
        (deform.as_str(), Value, "deformed by the points of its surface"),
        ("\"a\", «\"a\"»", Value, "there is a piece \"a\" before this one"),
        ("\"a\", Piece(name: «\"a\"», object: Grid(size: (1, 1)))", Value, "before this one"),
        ("«\"\"», \"a\", \"b\"", Value, "a piece needs a name"),
        ("«1»", Value, "the name of a piece in quotes, found `1`"),
        ("«(\"a\")»", Value, "`Piece(field: value, ..)`"),
        ("Piece(name: \"a\", object: Grid(size: («0», 1))), \"b\"", Value, "greater than 0"),
        (
            "Piece(name: \"a\", object: Grid(size: (1, 1), cells: (3000, 3000))), \"b\", «Piece»(name: \"c\", object: \
             Grid(size: (1, 1), cells: (3000, 3000)))",
            Limit,
            "the pieces up to this one have 18012002 vertices, the limit is 16777216",
        ),
    ] {
        check(&with_patches(patches), kind, message, None);
    }
    check(
        &with_patches("\"b\", Piece(name: \"a\", object: «Gird»(size: (1, 1)))"),
        Name,
        "no object",
        Some("`Grid`"),
    );
    let text = with_patches(&deform).replace(['«', '»'], "");
    assert_eq!(errors(&text)[0].path, "patches[0].object.deform");
}

#[test]
fn only_the_first_effect_brings_objects() {
    let piece = |object: &str| with_patches(&format!("Piece(name: \"a\", object: {object}), \"b\""));
    let grid = "Grid(size: (1, 1))";
    let stack = format!("Stack([{}, {}])", in_seam(""), piece(&format!("«{grid}»")));
    check(&stack, PresetErrorKind::Value, "only the first effect of a stack names the object", None);
    assert_eq!(errors(&stack.replace(['«', '»'], ""))[0].path, "[1].patches[0].object");
    assert_eq!(errors(&format!("Stack([{}, {}])", piece(grid), in_seam(""))), []);
}

#[test]
fn what_does_nothing_is_warned_of() {
    for (text, path, message) in [
        (in_seam("closure: 0"), "seams[0].closure", "with `closure` 0 this seam never sews"),
        (in_seam("closure: Keys([(0, 0), (1, 0)])"), "seams[0].closure", "never sews"),
        (in_seam("closure: 0, weld: true"), "seams[0].closure", "never sews"),
        (in_seam("closure: 0.5, weld: true"), "seams[0].weld", "with `closure` below 1"),
        (in_seam("density: Linear, continuity: Tangent"), "seams[0].density", "leaves a crease"),
        (in_tear("at: 0, width: 1, opening: 0"), "seams[0].tears[1].opening", "this tear never opens"),
        (in_tear("at: 0, width: Keys([(0, 0)])"), "seams[0].tears[1].width", "this tear never opens"),
    ] {
        let warnings = parsed(&text).warnings;
        let [warning] = warnings.as_slice() else { panic!("{text}\n{warnings:#?}") };
        assert_eq!((warning.line, warning.path.as_str()), (3, path), "{text}");
        assert!(warning.message.contains(message), "{warning:?}");
    }
    for text in [
        in_seam("closure: Keys([(0, 0), (1, 0.5)])"),
        in_seam("closure: Keys([(0, 0), (1, 1)]), weld: true"),
        in_seam("closure: 0.5"),
        in_seam("density: Linear"),
        in_tear("at: 0, width: Keys([(0, 0), (1, 0.5)]), gape: 0"),
    ] {
        assert_eq!(parsed(&text).warnings, [], "{text}");
    }
}

#[test]
fn bounds_scale_what_is_a_length_or_a_place() {
    let text = format!(
        "Stitch(units: Bounds, seams: [
            Seam({EDGES}, radius: 0.5, bias: 0.25, tears: [Tear(at: 0.5, width: 0.25, gape: -0.125, plateau: 0.5)]),
            Seam(a: Edge(piece: \"a\", from: (0, 0.5, 0), to: (-0.5, 0, 1)), b: Edge(piece: \"b\", loop: (0, 0, 0.25)))])"
    );
    let effect = parsed(&text).preset.effects.remove(0);
    let frame = wirework_preset::BoundsFrame { center: [1.0, 2.0, 3.0], size: 4.0 };
    let placed = effect.placed(&frame);
    assert_eq!((effect.units, placed.units), (Units::Bounds, Units::Metres));
    let Action::Stitch(stitching) = placed.action else { panic!() };
    let [sides, points] = stitching.stitch.seams.as_slice() else { panic!() };
    assert_eq!(sides.radius, Keyed::Constant(2.0));
    assert_eq!(sides.bias, Keyed::Constant(0.25));
    let tear = Tear { gape: Keyed::Constant(-0.5), plateau: Keyed::Constant(0.5), ..Tear::new(0.5, 0.25) };
    assert_eq!(sides.tears, [tear]);
    // The default is in these units, too.
    assert_eq!(points.radius, Keyed::Constant(1.6));
    assert_eq!(points.a.run, Run::Between { from: [1.0, 4.0, 3.0], to: [-1.0, 2.0, 7.0], long: false });
    assert_eq!(points.b.run, Run::Loop([1.0, 2.0, 4.0]));
}

#[test]
fn seams_are_the_same_with_both_parentheses() {
    let plain = stitching(&in_seam("weld: true, tears: [Tear(at: 0.5, width: 0.25)]"));
    let doubled = in_seam("weld: true, tears: [Tear((at: 0.5, width: 0.25))]")
        .replace("Edge(piece: \"a\", side: UMax)", "Edge((piece: \"a\", side: UMax))");
    assert_eq!(stitching(&doubled), plain);
    let patch = "Patch((points: [[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]], deform: «ControlPoints»))";
    let text = with_patches(&format!("Piece(name: \"a\", object: {patch}), \"b\""));
    check(&text, PresetErrorKind::Value, "points of its surface", None);
}
