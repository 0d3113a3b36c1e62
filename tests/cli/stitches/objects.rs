//! What pieces can be, and what comes back of each.

use glam::DVec3;

use super::{EXACT, Film, ONE, Patch, apart, at, diagonal, edges, lines, pair, sewn, straight};
use crate::place::Place;
use crate::wrinkles::vertices;

const CELLS: [usize; 2] = [10, 12];

/// From the first to the last point of an edge.
fn run(piece: &str, points: &[DVec3], edge: &[usize]) -> String {
    let [from, to] = [edge[0], edge[edge.len() - 1]].map(|i| points[i]);
    let point = |p: DVec3| format!("({}, {}, {})", p.x, p.y, p.z);
    format!("Edge(piece: \"{piece}\", from: {}, to: {})", point(from), point(to))
}

/// The seam of a pair, with the ends of its edges named by points.
fn seam(points: &[DVec3], patches: &[Patch; 2], fields: &str) -> String {
    let [a, b] = edges(patches);
    format!("Seam(a: {}, b: {}, {fields})", run("left", points, &a), run("right", points, &b))
}

#[test]
fn each_piece_is_a_node_and_an_obj_lists_them_in_order() {
    let place = Place::new();
    let patches = pair(CELLS, [14, 12]);
    let preset = sewn(&patches, "closure: Keys([(0, 0), (1, 1)])");
    let film = place.film(&preset, "");
    assert_eq!(film.names(), ["left", "right"]);
    let rest = place.rest_points(&patches);
    for (seconds, frame) in [(0.0, 0.0), (0.5, 12.0 / 24.0), (1.0, 1.0)] {
        let still = place.still(&preset, seconds);
        let [left, right] = film.at(Some(frame)).try_into().unwrap();
        assert_eq!([left.len(), right.len()], patches.each_ref().map(Patch::count));
        let off = apart(&[left, right].concat(), &still);
        assert!(off < 1e-4 * diagonal(&rest), "at {seconds} s the two differ by {off}");
    }
    assert!(apart(&film.at(None).concat(), &rest) < ONE * diagonal(&rest), "at rest nothing is sewn");
    let text = String::from_utf8(place.read("still.obj")).unwrap();
    let objects: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("o ")).collect();
    assert_eq!(objects, ["left", "right"]);
}

#[test]
fn pieces_of_all_kinds_keep_their_own_names() {
    let place = Place::new();
    place.write("cloth.obj", "v 3 0 -1\nv 3 0 1\nv 4 0 1\nv 4 0 -1\nf 1 2 3 4\n");
    let film = place.film(
        "Stitch(
            patches: [
                Piece(name: \"a grid\", object: Grid(size: (1, 2), cells: (2, 1), translation: (2.2, 0, 0))),
                Piece(name: \"cloth\", object: File(\"cloth.obj\")),
                Piece(name: \"ball\", object: Sphere(center: (0, 5, 0), radius: 1)),
            ],
            seams: [Seam(a: Edge(piece: \"a grid\", side: UMax),
                b: Edge(piece: \"cloth\", from: (3, 0, -1), to: (3, 0, 1)),
                closure: Keys([(0, 0), (1, 1)]))])",
        "",
    );
    assert_eq!(film.names(), ["a grid", "cloth", "ball"]);
    let [grid, cloth, ball] = film.at(Some(1.0)).try_into().unwrap();
    let sewn = |points: &[DVec3]| points.iter().filter(|p| (p.x - 2.85).abs() < 1e-4).count();
    assert_eq!([sewn(&grid), sewn(&cloth)], [2, 2]);
    assert_eq!(apart(&ball, &film.at(None)[2]), 0.0);
}

/// The sides of a grid: u runs along its first size, v along its second.
#[test]
fn grids_are_sewn_along_each_side() {
    let place = Place::new();
    for (side, opposite, far) in [
        ("UMax", "UMin", "1.4, 0, 0"),
        ("UMin", "UMax", "-1.4, 0, 0"),
        ("VMax", "VMin", "0, 0, 1.4"),
        ("VMin", "VMax", "0, 0, -1.4"),
    ] {
        let now = place.still(
            &format!(
                "Stitch(
                    patches: [
                        Piece(name: \"here\", object: Grid(size: (1, 1), cells: (6, 6))),
                        Piece(name: \"there\", object: Grid(size: (1, 1), cells: (6, 6), translation: ({far}))),
                    ],
                    seams: [Seam(a: Edge(piece: \"here\", side: {side}), b: Edge(piece: \"there\", side: {opposite}))])"
            ),
            0.0,
        );
        let far: Vec<f64> = far.split(", ").map(|n| n.parse().unwrap()).collect();
        let far = DVec3::from_slice(&far);
        // A gap of 0.4, and the seam in its middle.
        let on = |p: &&DVec3| (p.dot(far) / 1.4 - 0.7).abs() < 1e-5;
        let [here, there] = [&now[..49], &now[49..]].map(|own| own.iter().filter(on).count());
        assert_eq!([here, there], [7, 7], "{side}");
    }
}

#[test]
fn tubes_are_sewn_all_round() {
    let place = Place::new();
    let tube = |name: &str, from: f64, radius: f64, turned: f64| {
        format!(
            "Piece(name: \"{name}\", object: Tube(from: (0, {from}, 0), to: (0, {}, 0), radius: {radius},
                sides: 24, rings: 6, caps: false, rotation: (0, {turned}, 0)))",
            from + 1.0
        )
    };
    // The upper one is wider, and turned by five of its sides.
    let preset = |fields: &str| {
        format!(
            "Stitch(patches: [{}, {}], seams: [Seam(a: Edge(piece: \"low\", loop: (0, 1, 0.4)),
                b: Edge(piece: \"high\", loop: (0.6, 1.3, 0)), {fields})])",
            tube("low", 0.0, 0.4, 0.0),
            tube("high", 1.3, 0.6, 75.0)
        )
    };
    for (bias, high, radius) in [(0.5, 1.15, 0.5), (0.0, 1.0, 0.4), (1.0, 1.3, 0.6)] {
        let now = place.still(&preset(&format!("bias: {bias}, radius: 0.5")), 0.0);
        let [a, b] = [&now[5 * 24..6 * 24], &now[6 * 24..7 * 24]];
        for p in a.iter().chain(b) {
            let off = (p.y - high).abs().max((p.x.hypot(p.z) - radius).abs());
            assert!(off < 1e-4, "bias {bias}: {p}");
        }
        // Each vertex meets that of the other whose direction is its own.
        let shut = a.iter().all(|p| b.iter().any(|q| p.distance(*q) < 1e-6 * diagonal(&now)));
        assert!(shut, "bias {bias}");
        assert!(now[..24].iter().all(|p| p.y == 0.0), "the far end stays");
    }
}

#[test]
fn nodes_of_an_input_are_sewn_as_objects_are() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let fields = "closure: Keys([(0, 0), (1, 1)]), radius: 0.5";
    let want = place.still(&sewn(&patches, fields), 1.0);
    place.write("rest.ron", sewn(&patches, fields));
    place.run("apply rest.ron -o in.glb --at 0 -q").expect(0);
    place.run("apply rest.ron -o in.obj --at 0 -q").expect(0);
    let seam = seam(&place.rest_points(&patches), &patches, fields);
    for pieces in ["patches: [\"left\", \"right\"], ", "patches: [Piece(name: \"right\"), \"left\"], ", ""] {
        place.write("sew.ron", format!("Stitch({pieces}seams: [{seam}])"));
        place.run("apply sew.ron in.glb -o out.glb -q").expect(0);
        let film = Film::open(&place, "out.glb");
        assert_eq!(film.names(), ["left", "right"]);
        let off = apart(&film.at(Some(1.0)).concat(), &want);
        assert!(off < 1e-4 * diagonal(&want), "{pieces}: {off}");
        // The objects of an OBJ are pieces, too.
        place.run("apply sew.ron in.obj -o out.obj --at 1 -q").expect(0);
        let off = apart(&vertices(&place.read("out.obj")), &want);
        assert!(off < EXACT * diagonal(&want), "{pieces}: {off}");
    }
}

#[test]
fn a_node_of_an_input_and_an_object_of_the_preset_are_sewn() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let fields = "closure: Keys([(0, 0), (1, 1)])";
    let want = place.still(&sewn(&patches, fields), 1.0);
    // The left one moved and turned by its node, with something beside it that is no piece.
    place.write(
        "in.ron",
        format!(
            "Stitch(patches: [{}, Piece(name: \"beside\", object: Grid(size: (1, 1), cells: (2, 2), translation: (0, -3, 0)))],
                seams: [Seam(a: Edge(piece: \"left\", side: UMax), b: Edge(piece: \"beside\", side: UMin), closure: 0)])",
            patches[0].piece("left")
        ),
    );
    place.run("apply in.ron -o in.glb --at 0 -q").expect(0);
    let [a, _] = edges(&patches);
    let left = run("left", &place.rest_points(&patches), &a);
    let seam = format!("Seam(a: {left}, b: Edge(piece: \"right\", side: UMin), {fields})");
    let right = patches[1].piece("right");
    place.write("sew.ron", format!("Stitch(patches: [\"left\", {right}], seams: [{seam}])"));
    place.run("apply sew.ron in.glb -o out.glb -q").expect(0);
    let film = Film::open(&place, "out.glb");
    assert_eq!(film.names(), ["left", "beside", "right"]);
    let [left, beside, right] = film.at(Some(1.0)).try_into().unwrap();
    assert!(apart(&[left, right].concat(), &want) < 1e-4 * diagonal(&want));
    assert!(beside.iter().all(|p| p.y == -3.0));
}

/// Lengths in parts of what all pieces take up together, about its centre.
#[test]
fn bounds_scale_with_the_pieces() {
    let place = Place::new();
    for size in [1.0, 10.0] {
        let patches = straight(0.2, CELLS).map(|mut patch| {
            for p in patch.points.iter_mut().flatten() {
                *p = *p * size + DVec3::new(5.0, 2.0, 0.0);
            }
            patch
        });
        let preset = |units: &str, unit: f64| {
            let tear = format!("Tear(at: 0.5, width: 0.3, gape: {})", 0.02 * unit);
            let fields = format!("radius: {}, tears: [{tear}]", 0.2 * unit);
            sewn(&patches, &fields).replace("Stitch(", &format!("Stitch(units: {units}, "))
        };
        let bounds = place.still(&preset("Bounds", 1.0), 0.0);
        let metres = place.still(&preset("Metres", 2.4 * size), 0.0);
        assert!(apart(&bounds, &metres) < EXACT * diagonal(&metres), "at size {size}");
        let rest = place.rest_points(&patches);
        assert!(apart(&bounds, &rest) > 0.19 * size, "it is sewn");
        // Points of edges, too.
        let run = |piece: &str, x: f64| {
            format!("Edge(piece: \"{piece}\", from: ({x}, 0, {}), to: ({x}, 0, {}))", -1.0 / 2.4, 1.0 / 2.4)
        };
        let [left, right] = [patches[0].piece("left"), patches[1].piece("right")];
        let tear = "Tear(at: 0.5, width: 0.3, gape: 0.02)";
        let named = place.still(
            &format!(
                "Stitch(units: Bounds, patches: [{left}, {right}], seams: [Seam(a: {}, b: {}, radius: 0.2, tears: [{tear}])])",
                run("left", -0.2 / 2.4),
                run("right", 0.2 / 2.4)
            ),
            0.0,
        );
        assert!(apart(&named, &bounds) < EXACT * diagonal(&metres), "at size {size}, by points");
    }
}

#[test]
fn only_one_piece_may_move() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let text = place.rest(&patches);
    let free = place.still(&sewn(&patches, ""), 0.0);
    let preset = sewn(&patches, "").replace("Stitch(", "Stitch(only: Nodes([\"left\"]), ");
    let now = place.still(&preset, 0.0);
    let count = patches[0].count();
    assert!(lines(&text)[count..] == lines(&place.read("still.obj"))[count..], "\"right\" keeps its bits");
    assert!(apart(&now[..count], &free[..count]) < EXACT * diagonal(&free), "\"left\" goes as it went");
    let [a, b] = edges(&patches);
    assert!(apart(&at(&now, &a), &at(&now, &b)) > 0.2);
}
