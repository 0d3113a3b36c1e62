//! `weld`: both sides become one row of vertices, in whatever is written.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{Film, ONE, Patch, Side, diagonal, edges, pair, sewn, straight};
use crate::document::list;
use crate::place::Place;
use crate::wrinkles::vertices;

/// The corners of each face of an OBJ, as vertices from 0.
fn faces(text: &[u8]) -> Vec<Vec<usize>> {
    let corner = |word: &str| word.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
    let lines = std::str::from_utf8(text).unwrap().lines();
    lines.filter_map(|line| line.strip_prefix("f ")).map(|l| l.split(' ').map(corner).collect()).collect()
}

/// How many edges of faces lie at one face only, and at more than two.
fn borders(faces: &[Vec<usize>]) -> (usize, usize) {
    let mut count: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for face in faces {
        for (i, &a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            *count.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    (count.values().filter(|n| **n == 1).count(), count.values().filter(|n| **n > 2).count())
}

#[test]
fn a_still_lists_the_vertices_of_a_weld_once() {
    let place = Place::new();
    let patches = pair([6, 8], [6, 13]);
    place.write("weld.ron", sewn(&patches, "weld: true"));
    place.run("apply weld.ron -o weld.obj --at 0 --strict").expect(0);
    let text = place.read("weld.obj");
    // Of the two edges, 9 and 14 vertices, one row with the ends in common.
    let row = 9 + 14 - 2;
    let inner: usize = patches.iter().map(Patch::count).sum::<usize>() - 9 - 14;
    assert_eq!(vertices(&text).len(), inner + row);
    // Round the two: their other sides, and no edge of the seam.
    assert_eq!(borders(&faces(&text)), (4 * 6 + 8 + 13, 0));
}

#[test]
fn a_torn_weld_is_one_only_where_it_holds() {
    let place = Place::new();
    let patches = straight(0.2, [6, 20]);
    place.write("weld.ron", sewn(&patches, "weld: true, tears: [Tear(at: 0.5, width: 0.4)]"));
    place.run("apply weld.ron -o weld.obj --at 0 -q").expect(0);
    let text = place.read("weld.obj");
    let all: usize = patches.iter().map(Patch::count).sum();
    let lost = all - vertices(&text).len();
    assert!((10..20).contains(&lost), "{lost} became one");
    let (one, more) = borders(&faces(&text));
    assert!(one > 4 * 6 + 2 * 20 && more == 0, "open along the tear");
}

/// Both sides of the seam of a document: pairs of vertices of "left" and "right" at one place, as far as numbers in files that are added go.
fn joined(left: &[DVec3], right: &[DVec3]) -> Vec<[usize; 2]> {
    let near = |p: &DVec3, q: &DVec3| p.distance(*q) < ONE * diagonal(left);
    let pairs = left.iter().enumerate();
    pairs.filter_map(|(i, p)| Some([i, right.iter().position(|q| near(p, q))?])).collect()
}

#[test]
fn a_document_has_both_sides_at_one_place() {
    let place = Place::new();
    let patches = pair([6, 8], [6, 13]);
    let film = place.film(&sewn(&patches, "weld: true, closure: Keys([(0, 0), (1, 1)])"), "");
    let [left, right] = film.at(Some(1.0)).try_into().unwrap();
    assert_eq!(joined(&left, &right).len(), 9 + 14 - 2);
    place.write("still.ron", sewn(&patches, "weld: true"));
    place.run("apply still.ron -o still.glb --at 0 -q").expect(0);
    let still = Film::open(&place, "still.glb");
    let [left, right] = still.at(None).try_into().unwrap();
    let pairs = joined(&left, &right);
    assert_eq!(pairs.len(), 9 + 14 - 2);
    let attributes = |mesh: usize| &list(&still.0.json, "meshes")[mesh]["primitives"][0]["attributes"];
    let normals = [0, 1].map(|mesh| still.0.elements(&attributes(mesh)["NORMAL"]));
    for [a, b] in pairs {
        let [p, q] = [&normals[0][a], &normals[1][b]].map(|n| DVec3::from_slice(n));
        assert!(p.distance(q) < 1e-5, "{p} and {q}");
    }
    for (mesh, points) in [left, right].iter().enumerate() {
        let uvs = attributes(mesh)["TEXCOORD_0"].as_u64().unwrap() as usize;
        assert_eq!(list(&still.0.json, "accessors")[uvs]["count"], points.len());
    }
}

/// A seam between whole borders that are named by their ends.
fn between(patches: &[Patch; 2], points: &[DVec3], fields: &str) -> String {
    let run = |name: &str, edge: &[usize]| {
        let [p, q] =
            [points[edge[0]], points[edge[edge.len() - 1]]].map(|p| format!("({}, {}, {})", p.x, p.y, p.z));
        format!("Edge(piece: \"{name}\", from: {p}, to: {q})")
    };
    let [a, b] = edges(patches);
    format!("Seam(a: {}, b: {}, {fields})", run("left", &a), run("right", &b))
}

#[test]
fn pieces_of_files_are_welded() {
    let place = Place::new();
    let patches = straight(0.2, [4, 6]);
    let patches = [patches[0].clone(), Patch { cells: [4, 9], ..patches[1].clone() }];
    let points = place.rest_points(&patches);
    let wire = "Wire(curve: Polyline(points: [(9, 9, 9), (9, 9, 8)]), radius: 0.1)";
    place.write("right.ron", format!("Deform(object: {}, wires: [{wire}])", patches[1].object()));
    place.run("apply right.ron -o right.glb --at 0 -q").expect(0);
    let seam = between(&patches, &points, "weld: true");
    place.write(
        "weld.ron",
        format!(
            "Stitch(patches: [{}, Piece(name: \"right\", object: File(\"right.glb\"))], seams: [{seam}])",
            patches[0].piece("left")
        ),
    );
    place.run("apply weld.ron -o weld.glb --at 0 -q").expect(0);
    let [left, right] = Film::open(&place, "weld.glb").at(None).try_into().unwrap();
    // 7 and 10 vertices, 4 of them common.
    assert_eq!(joined(&left, &right).len(), 7 + 10 - 4);
}

/// The edges of files are one row in an OBJ, too.
#[test]
fn an_obj_of_the_input_is_welded() {
    let place = Place::new();
    let sheets =
        "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 2 0 0\nv 3 0 0\nv 3 0 1\nv 2 0 1\nf 1 4 3 2\nf 5 8 7 6\n";
    place.write("in.obj", sheets);
    place.write(
        "weld.ron",
        "Stitch(patches: [\"in\"], seams: [Seam(weld: true, a: Edge(piece: \"in\", from: (1, 0, 0), to: (1, 0, 1)),
            b: Edge(piece: \"in\", from: (2, 0, 0), to: (2, 0, 1)))])",
    );
    place.run("apply weld.ron in.obj -o out.obj --at 0 -q").expect(0);
    let text = place.read("out.obj");
    assert_eq!((vertices(&text).len(), borders(&faces(&text))), (6, (6, 0)));
}

#[test]
fn one_edge_is_welded_twice_and_one_after_the_other() {
    let place = Place::new();
    let patches = straight(0.2, [4, 6]);
    let patches = [patches[0].clone(), Patch { cells: [4, 9], ..patches[1].clone() }];
    let third = Patch::flat([1.5, 2.5], [-1.0, 1.0], [4, 4]);
    let seam = |b: &str| {
        format!(
            "Seam(weld: true, bias: 0, a: Edge(piece: \"left\", side: UMax), b: Edge(piece: \"{b}\", side: UMin))"
        )
    };
    let [left, right] = &patches;
    let (left, right) = (left.piece("left"), right.piece("right"));
    let third = third.piece("third");
    let both = format!("[{}, {}]", seam("right"), seam("third"));
    place.write(
        "order.ron",
        format!("Stitch(patches: [{left}, {right}, {third}], seams: {both}, order: Sequential)"),
    );
    place.write(
        "stack.ron",
        format!(
            "Stack([Stitch(patches: [{left}, {right}, {third}], seams: [{}]), \
             Stitch(patches: [\"left\", \"third\"], seams: [{}])])",
            seam("right"),
            seam("third")
        ),
    );
    for preset in ["order.ron", "stack.ron"] {
        place.run(&format!("apply {preset} -o out.obj --at 0 --strict")).expect(0);
        let text = place.read("out.obj");
        // Sixths, ninths and quarters in one row, of which each edge has a face of every sheet.
        let (row, inner) = (7 + 6 + 2, 4 * (7 + 10 + 5));
        assert_eq!(vertices(&text).len(), inner + row, "{preset}");
        assert_eq!(borders(&faces(&text)), (3 * 2 * 4 + 6 + 9 + 4, row - 1), "{preset}");
    }
}

#[test]
fn what_the_weld_may_not_move_stays_where_it_is() {
    let place = Place::new();
    let patches = straight(0.2, [4, 6]);
    let rest = place.rest_points(&patches);
    let preset = sewn(&patches, "weld: true").replacen("Stitch(", "Stitch(only: Nodes([\"left\"]), ", 1);
    let now = place.still(&preset, 0.0);
    assert_eq!(now.len(), rest.len(), "nothing has come together");
    for i in patches[1].side(Side::UMin) {
        let i = i + patches[0].count();
        assert_eq!(now[i], rest[i]);
    }
}

#[test]
fn sides_that_face_opposite_ways_are_told() {
    let place = Place::new();
    let [left, right] = straight(0.2, [4, 6]);
    let mut turned = right.clone();
    turned.points.iter_mut().for_each(|row| row.reverse());
    for (right, warned) in [(right, false), (turned, true)] {
        place.write("weld.ron", sewn(&[left.clone(), right], "weld: true"));
        let err = place.run("apply weld.ron -o out.glb --at 0").expect(0).err();
        assert_eq!(err.contains("seam 0 is welded") && err.contains("[facing]"), warned, "{err}");
    }
}
