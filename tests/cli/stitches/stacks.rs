//! Stitches among other effects: what is sewn stays shut, whatever moves before or behind.

use glam::DVec3;

use super::{EXACT, Film, ONE, Patch, apart, at, diagonal, edges, pair, sewn};
use crate::place::Place;
use crate::wrinkles::vertices;

const CELLS: [usize; 2] = [12, 16];
/// Lifts and turns what is near to the seam and right of it, more and more.
const WAVE: &str = "wires: [Wire(
    curve: BSpline(degree: 2, points: [(-0.4, 0, -0.6), (0.2, 0, 0), (0.3, 0, 0.9)]),
    pose: Keys([
        (0, [(-0.4, 0, -0.6), (0.2, 0, 0), (0.3, 0, 0.9)]),
        (0.4, [(-0.3, 0.3, -0.7), (0.2, 0.1, 0), (0.1, 0.4, 1)]),
        (1, [(-0.4, 0.6, -0.2), (0.3, 0.5, 0), (0.5, -0.4, 0.8)]),
    ]),
    radius: 0.7,
)]";
const FRAMES: usize = 25;

/// Both edges at each frame of a sequence of OBJ files.
fn frames(place: &Place, preset: &str, input: &str, patches: &[Patch; 2]) -> Vec<[Vec<DVec3>; 2]> {
    place.write("stack.ron", preset);
    place.run(&format!("apply stack.ron {input} -o f####.obj --fps 24 -q")).expect(0);
    let edges = edges(patches);
    let frame = |frame: usize| {
        let now = vertices(&place.read(&format!("f{frame:04}.obj")));
        edges.each_ref().map(|edge| at(&now, edge))
    };
    (0..FRAMES).map(frame).collect()
}

#[test]
fn what_is_sewn_stays_shut_while_a_wire_moves_it() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let stitch = sewn(&patches, "correspondence: Parameter");
    let still = place.still(&stitch, 0.0);
    let frames = frames(&place, &format!("Stack([{stitch}, Deform({WAVE})])"), "", &patches);
    let mut most: f64 = 0.0;
    for (frame, [a, b]) in frames.iter().enumerate() {
        assert!(apart(a, b) <= ONE * diagonal(&still), "frame {frame}: {}", apart(a, b));
        most = most.max(apart(a, &at(&still, &edges(&patches)[0])));
    }
    assert!(most > 0.3, "the wire moves the seam");
}

#[test]
fn a_wrinkle_rises_from_what_is_sewn() {
    let place = Place::new();
    let patches = pair([24, 32], [24, 32]);
    let stitch = sewn(&patches, "correspondence: Parameter");
    let still = place.still(&stitch, 0.0);
    let crease = "Polyline([(-0.9, 0.2, -0.5), (-0.9, 0.2, 0.5)])";
    let wrinkle = format!("Wrinkle(pattern: Drawn([{crease}]), thickness: 0.15, intensity: 0.04)");
    let now = place.still(&format!("Stack([{stitch}, {wrinkle}])"), 0.0);
    let high = apart(&still, &now);
    assert!((0.03..0.041).contains(&high), "the crease is {high} high");
    let [a, b] = edges(&patches);
    assert!(apart(&at(&now, &a), &at(&now, &b)) <= ONE * diagonal(&still));
}

/// The edges that are sewn are those that the effects before have moved.
#[test]
fn the_seam_follows_what_moves_before_it() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    place.write("rest.ron", sewn(&patches, "closure: Keys([(0, 0), (1, 1)])"));
    place.run("apply rest.ron -o in.obj --at 0 -q").expect(0);
    place.run("apply rest.ron -o in.glb --at 0 -q").expect(0);
    let rest = place.rest_points(&patches);
    let [a, b] = edges(&patches);
    let run = |name: &str, edge: &[usize]| {
        let [from, to] =
            [rest[edge[0]], rest[edge[edge.len() - 1]]].map(|p| format!("({}, {}, {})", p.x, p.y, p.z));
        format!("Edge(piece: \"{name}\", from: {from}, to: {to})")
    };
    let seam = format!("Seam(a: {}, b: {}, correspondence: Parameter)", run("left", &a), run("right", &b));
    let stitch = format!("Stitch(patches: [\"left\", \"right\"], seams: [{seam}])");
    let moved = frames(&place, &format!("Deform({WAVE})"), "in.obj", &patches);
    let sewn = frames(&place, &format!("Stack([Deform({WAVE}), {stitch}])"), "in.obj", &patches);
    let size = diagonal(&rest);
    for (frame, (moved, [a, b])) in moved.iter().zip(&sewn).enumerate() {
        assert!(apart(a, b) <= ONE * size, "frame {frame}: {}", apart(a, b));
        let halfway: Vec<DVec3> = moved[0].iter().zip(&moved[1]).map(|(p, q)| p.midpoint(*q)).collect();
        assert!(apart(a, &halfway) < EXACT * size, "frame {frame}");
    }
    assert!(apart(&moved[0][0], &moved[FRAMES - 1][0]) > 0.1, "the edges move");
    // The same as an animation: within its tolerance, to which both sides may miss.
    place.write("stack.ron", format!("Stack([Deform({WAVE}), {stitch}])"));
    place.run("apply stack.ron in.glb -o out.glb -q").expect(0);
    let film = Film::open(&place, "out.glb");
    let first = edges(&patches)[0][0];
    for (frame, [a, _]) in sewn.iter().enumerate() {
        let now = film.at(Some(frame as f64 / 24.0)).concat();
        assert!(now[first].distance(a[0]) < 1.01e-4 * size, "frame {frame}");
    }
}

#[test]
fn a_stitch_is_sewn_onto_the_result_of_another() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    // Half shut and then shut is shut; the second finds the pieces by the names that the first gave them.
    let half = sewn(&patches, "closure: 0.5, correspondence: Parameter");
    let seam = "Seam(a: Edge(piece: \"left\", side: UMax), b: Edge(piece: \"right\", side: UMin), bias: 0.5,
        correspondence: Parameter)";
    let now = place
        .still(&format!("Stack([{half}, Stitch(patches: [\"left\", \"right\"], seams: [{seam}])])"), 0.0);
    let once = place.still(&sewn(&patches, "correspondence: Parameter"), 0.0);
    let [a, b] = edges(&patches);
    assert!(apart(&at(&now, &a), &at(&now, &b)) <= ONE * diagonal(&now));
    assert!(apart(&at(&now, &a), &at(&once, &a)) < EXACT * diagonal(&now));
}

/// What a seam may move is measured on what moves below it, at each moment.
#[test]
fn influence_ends_where_the_surface_is_now() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let at = |x: f64| format!("[({x}, 0, -2), ({x}, 0, 2)]");
    let stack = |pose: String| {
        let wire = format!("Wire(curve: Polyline(points: {}), pose: {pose}, radius: 1)", at(-1.2));
        let [left, right] = &patches;
        let (left, right) = (left.piece("left"), right.piece("right"));
        let seam = |fields: &str| {
            format!(
                "Seam(a: Edge(piece: \"left\", side: UMax), b: Edge(piece: \"right\", side: UMin), {fields})"
            )
        };
        // The first stitch only brings the pieces along.
        format!(
            "Stack([Stitch(patches: [{left}, {right}], seams: [{}]), Deform(wires: [{wire}]), Stitch(seams: [{}])])",
            seam("closure: 0"),
            seam("radius: 0.3, correspondence: Parameter")
        )
    };
    let moving = place.still(&stack(format!("Keys([(0, {}), (1, {})])", at(-1.2), at(-0.5))), 1.0);
    let there = place.still(&stack(at(-0.5)), 1.0);
    assert!(apart(&moving, &there) < EXACT * diagonal(&there), "{}", apart(&moving, &there));
}

/// Effects before a stitch are looked at with their masks: what they may not move is where it was.
#[test]
fn edges_are_looked_for_where_masks_leave_them() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    place.write("rest.ron", sewn(&patches, "closure: Keys([(0, 0), (1, 1)])"));
    place.run("apply rest.ron -o in.glb --at 0 -q").expect(0);
    let rest = place.rest_points(&patches);
    let [_, b] = edges(&patches);
    let [from, to] = [rest[b[0]], rest[b[b.len() - 1]]].map(|p| format!("({}, {}, {})", p.x, p.y, p.z));
    let lift = "Wire(curve: Polyline(points: [(0, 0, -9), (0, 0, 9)]), \
                pose: [(0, 3, -9), (0, 3, 9)], radius: 90)";
    place.write(
        "stack.ron",
        format!(
            "Stack([Deform(only: Nodes([\"left\"]), wires: [{lift}]), Stitch(seams: [Seam(\
             a: Edge(piece: \"left\", from: (-0.3, 3, -0.8), to: (-0.3, 3, 0.8)), \
             b: Edge(piece: \"right\", from: {from}, to: {to}))])])"
        ),
    );
    place.run("apply stack.ron in.glb -o out.glb --at 0 -q").expect(0);
}

#[test]
fn later_stitches_name_nodes_of_their_own() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let third = Patch::flat([1.5, 2.5], [-0.8, 0.7], CELLS);
    let [left, right] = &patches;
    let seam = |a: &str, b: &str, fields: &str| {
        format!(
            "Seam(a: Edge(piece: \"{a}\", loop: (0, 0, 0)), b: Edge(piece: \"{b}\", loop: (0, 0, 0)){fields})"
        )
    };
    place.write(
        "rest.ron",
        format!(
            "Stitch(patches: [{}, {}, {}], seams: [{}])",
            left.piece("left"),
            right.piece("right"),
            third.piece("third"),
            seam("left", "right", ", closure: 0")
        ),
    );
    place.run("apply rest.ron -o in.glb --at 0 -q").expect(0);
    place.write(
        "stack.ron",
        format!(
            "Stack([Stitch(seams: [{}]), Stitch(seams: [{}])])",
            seam("left", "right", ", closure: 0.2"),
            seam("right", "third", ", closure: 0.2")
        ),
    );
    place.run("apply stack.ron in.glb -o out.glb --at 0 -q").expect(0);
}
