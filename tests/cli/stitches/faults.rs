//! What cannot be sewn: a clear word at its place in the preset, the right exit code, and nothing written.

use super::Patch;
use crate::place::Place;

/// Applies a preset in which what is at fault stands between « and », and looks for the caret there.
#[track_caller]
pub(crate) fn refused(marked: &str, words: &[&str]) {
    refused_on(&Place::new(), marked, "", words);
}

#[track_caller]
pub(crate) fn refused_on(place: &Place, marked: &str, input: &str, words: &[&str]) {
    let (before, after) = marked.split_once('«').expect("a mark");
    let (fault, behind) = after.split_once('»').expect("its end");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap().chars().count() + 1;
    place.write("fault.ron", format!("{before}{fault}{behind}"));
    let files = place.files();
    let err = place.run(&format!("apply fault.ron {input} -o out.glb")).expect(4).err();
    assert_eq!(place.files(), files, "nothing is written");
    for word in words {
        assert!(err.contains(word), "no {word:?} in {err}");
    }
    assert!(err.contains(&format!("fault.ron:{line}:{column}\n")), "not at {line}:{column}: {err}");
    assert!(err.contains(&"^".repeat(fault.chars().count())), "no caret below {fault}: {err}");
}

const LEFT: &str = "Edge(piece: \"left\", side: UMax)";
const RIGHT: &str = "Edge(piece: \"right\", side: UMin)";

/// Two grids, a ball and a tube that is open at both ends, with these seams on a line of their own.
fn stitch(seams: &str) -> String {
    format!(
        "Stitch(
    patches: [
        Piece(name: \"left\", object: Grid(size: (1, 2), cells: (4, 8), translation: (-0.7, 0, 0))),
        Piece(name: \"right\", object: Grid(size: (1, 2), cells: (4, 8), translation: (0.7, 0, 0))),
        Piece(name: \"ball\", object: Sphere(center: (0, 0, 0), radius: 1, segments: (16, 8))),
        Piece(name: \"tube\", object: Tube(from: (0, 0, 0), to: (0, 1, 0), radius: 1, sides: 16, rings: 5, caps: false)),
    ],
    seams: [
        {seams}
    ],
)"
    )
}

fn seam(a: &str, b: &str) -> String {
    stitch(&format!("Seam(a: {a}, b: {b})"))
}

#[test]
fn edges_that_are_none_are_refused_at_their_place() {
    let piece = |name: &str| format!("Edge(piece: \"{name}\", ");
    let [left, ball, tube] = ["left", "ball", "tube"].map(piece);
    // A point in the middle of a sheet, as either end.
    let words = ["off the border of the piece", "no boundary runs here"];
    refused(&seam(&format!("{left}from: «(-0.7, 0, 0)», to: (-0.2, 0, 1))"), RIGHT), &words);
    refused(&seam(&format!("{left}from: (-0.2, 0, 1), to: «(-0.7, 0, 0)»)"), RIGHT), &words);
    // A closed surface has none at all.
    for run in ["loop: (0, 1, 0)", "from: (0, 1, 0), to: (1, 0, 0)"] {
        refused(&seam(&format!("«Edge»(piece: \"ball\", {run})"), RIGHT), &["the piece has no border"]);
    }
    for piece in [&ball, &tube] {
        refused(&seam(&format!("{piece}side: «UMin»)"), RIGHT), &["only patches and grids"]);
    }
    let ends = "from: (1, 0, 0), to: (1, 1, 0))";
    refused(
        &seam(&format!("«Edge»(piece: \"tube\", {ends}"), RIGHT),
        &["`from` and `to` lie on two borders"],
    );
    refused(&seam(&format!("{left}side: «UMiddle»)"), RIGHT), &["UMin", "VMax"]);
}

#[test]
fn edges_without_length_are_refused() {
    let ends = "from: (-0.2, 0, 1), to: (-0.2, 0, 0.99))";
    refused(&seam(&format!("«Edge»(piece: \"left\", {ends}"), RIGHT), &["the edge has no length"]);
    // The tip of a patch that is a triangle.
    let mut tip = Patch::flat([0.0, 1.0], [0.0, 1.0], [6, 6]);
    let point = tip.points[3][0];
    tip.points[3].fill(point);
    let other = Patch::flat([1.5, 2.5], [0.0, 1.0], [6, 6]);
    let preset = |a: &str, b: &str| {
        let pieces = [tip.piece("tip"), other.piece("other")].join(", ");
        format!("Stitch(patches: [{pieces}],\n    seams: [Seam(a: {a}, b: {b})])")
    };
    let good = "Edge(piece: \"other\", side: UMin)";
    refused(&preset("«Edge»(piece: \"tip\", side: UMax)", good), &["the edge has no length", "seams[0].a"]);
    refused(&preset(good, "«Edge»(piece: \"tip\", side: UMax)"), &["the edge has no length", "seams[0].b"]);
}

#[test]
fn names_that_nothing_has_are_refused_with_the_nearest() {
    let words = ["there is no piece \"rigth\"", "did you mean \"right\"?", "seams[0].b.piece"];
    refused(&seam(LEFT, "Edge(piece: «\"rigth\"», side: UMin)"), &words);
    let twice = seam(LEFT, RIGHT).replace("name: \"right\"", "name: «\"left\"»");
    refused(&twice, &["there is a piece \"left\" before this one"]);
    // Of an input.
    let place = Place::new();
    place.write("both.ron", seam(LEFT, RIGHT));
    place.run("apply both.ron -o in.glb --at 0 -q").expect(0);
    let run = |x: f64| format!("from: ({x}, 0, -1), to: ({x}, 0, 1)");
    let ends = [run(-0.2), run(0.2)];
    let listed = format!(
        "Stitch(patches: [\"left\",\n    «\"rihgt\"»], seams: [Seam(a: Edge(piece: \"left\", {}), b: Edge(piece: \"rihgt\", {}))])",
        ends[0], ends[1]
    );
    let words = ["in.glb: there is no piece \"rihgt\"", "did you mean \"right\"?"];
    refused_on(&place, &listed, "in.glb", &words);
    let named = format!(
        "Stitch(seams: [Seam(a: Edge(piece: \"left\", {}),\n    b: Edge(piece: «\"rihgt\"», {}))])",
        ends[0], ends[1]
    );
    refused_on(&place, &named, "in.glb", &words);
}

#[test]
fn seams_that_have_no_two_edges_of_their_own_are_refused() {
    let itself = ["both edges run along the same border"];
    refused(&stitch(&format!("«Seam»(a: {LEFT}, b: {LEFT})")), &itself);
    // The same run by other words, the whole or a part of it, either way.
    for run in ["from: (-0.2, 0, -1), to: (-0.2, 0, 1)", "from: (-0.2, 0, 0.5), to: (-0.2, 0, -0.5)"] {
        refused(&stitch(&format!("«Seam»(a: {LEFT}, b: Edge(piece: \"left\", {run}))")), &itself);
    }
    let tube = "Edge(piece: \"tube\", loop: (0, 1, 0))";
    refused(&stitch(&format!("«Seam»(a: {tube}, b: {tube})")), &itself);
    for (a, b) in [(tube, RIGHT), (LEFT, tube)] {
        refused(
            &stitch(&format!("«Seam»(a: {a}, b: {b})")),
            &["one edge is a whole loop, the other has two ends"],
        );
    }
    // Two seams on one border: the same edge, and stretches that overlap.
    let [far, other] =
        ["Edge(piece: \"right\", side: UMax)", "Edge(piece: \"left\", from: (-0.2, 0, 0), to: (-0.7, 0, 1))"];
    for edge in [LEFT, other] {
        let seams = format!("Seam(a: {LEFT}, b: {RIGHT}),\n        «Seam»(a: {edge}, b: {far})");
        refused(&stitch(&seams), &["this seam and seam 0 share more than ends", "seams[1]"]);
    }
}

#[test]
fn settings_out_of_range_are_refused_at_their_place() {
    for (fields, word) in [
        ("tears: [Tear(at: «1.2», width: 0.1)]", "there the tear lies outside the seam"),
        ("tears: [Tear(at: «-0.1», width: 0.1)]", "`at` must lie from 0 to 1"),
        ("tears: [Tear(at: Keys([(0, 0.5), (1, «1.5»)]), width: 0.1)]", "outside the seam"),
        ("tears: [Tear(at: 0.5, width: «-0.1»)]", "`width` must be greater than 0"),
        ("tears: [Tear(at: 0.5, width: «0»)]", "`width` must be greater than 0"),
        ("tears: [Tear(at: 0.5, width: 0.1, opening: «2»)]", "`opening` must lie from 0 to 1"),
        ("tears: [«Tear»(at: 0.5)]", "width"),
        ("bias: «1.5»", "`bias` must lie from 0 to 1"),
        ("closure: «-1»", "`closure` must lie from 0 to 1"),
        ("radius: «0»", "`radius` must be greater than 0"),
        ("scale: «nan»", "nan"),
        ("correspondence: «Nearest»", "Closest"),
        ("continuity: «Tangnet»", "did you mean `Tangent`?"),
        ("reversed: «Yes»", "Auto"),
        ("«tear»: []", "did you mean `tears`?"),
    ] {
        refused(&stitch(&format!("Seam(a: {LEFT}, b: {RIGHT},\n            {fields})")), &[word]);
    }
    refused("Stitch(patches: [\"a\"], seams: «[]»)", &["at least one seam"]);
}

#[test]
fn what_stands_behind_another_effect_brings_no_objects() {
    let first = stitch(&format!("Seam(a: {LEFT}, b: {RIGHT})"));
    let again = "Stitch(patches: [Piece(name: \"left\", object: «Grid(size: (1, 1))»)], seams: [Seam(\
                 a: Edge(piece: \"left\", side: UMax), b: Edge(piece: \"left\", side: UMin))])";
    refused(&format!("Stack([{first},\n{again}])"), &["only the first effect of a stack names the object"]);
    // What it calls its pieces the first one must have.
    let unknown = "Stitch(patches: [\"left\", «\"middle\"»], seams: [Seam(a: Edge(piece: \"left\", \
                   from: (-0.2, 0, -1), to: (-0.2, 0, 1)), b: Edge(piece: \"middle\", loop: (0, 0, 0)))])";
    refused(&format!("Stack([{first},\n{unknown}])"), &["there is no piece \"middle\""]);
}

#[test]
fn without_pieces_there_is_nothing_to_sew() {
    let place = Place::new();
    let seam = format!("Seam(a: {LEFT}, b: {RIGHT})");
    for preset in [
        format!("Stitch(patches: [\"left\", \"right\"], seams: [{seam}])"),
        format!("Stitch(seams: [{seam}])"),
    ] {
        place.write("none.ron", preset);
        let err = place.run("apply none.ron -o out.glb").expect(4).err();
        assert!(err.contains("names no object to work on"), "{err}");
        assert_eq!(place.files(), ["lift.ron", "none.ron"]);
    }
}
