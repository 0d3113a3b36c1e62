//! Seams along the borders of meshes that have no sides: runs between points, the long way round, slits.

use glam::DVec3;

use super::{ONE, apart, at, diagonal};
use crate::place::Place;
use crate::wrinkles::{obj, sheet};

const N: usize = 40;

/// A sheet over [-1, 1]² whose middle line is cut open from z = -0.5 to z = 0.5, both halves drawn back from it, the right one more.
/// With its lips, from end to end.
fn slit() -> (Vec<DVec3>, Vec<[usize; 3]>, [Vec<usize>; 2]) {
    let (mut points, mut faces) = sheet([-1.0, -1.0], [1.0, 1.0], [N, N]);
    let middle = |j: usize| N / 2 * (N + 1) + j;
    // The ends of the cut stay one vertex.
    let mut lips = [vec![middle(N / 4)], vec![middle(N / 4)]];
    for j in N / 4 + 1..3 * N / 4 {
        let (old, new) = (middle(j), points.len());
        points.push(points[old]);
        let is_right = |i: &usize| *i < (N + 1) * (N + 1) && *i / (N + 1) > N / 2;
        for face in faces.iter_mut().filter(|face| face.iter().any(is_right)) {
            face.iter_mut().filter(|i| **i == old).for_each(|i| *i = new);
        }
        lips[0].push(old);
        lips[1].push(new);
    }
    for lip in &mut lips {
        lip.push(middle(3 * N / 4));
    }
    let new = (N + 1) * (N + 1);
    for (i, p) in points.iter_mut().enumerate() {
        let wide = 0.1 * (1.0 - (p.z / 0.5).powi(2)).max(0.0);
        let right = i >= new || p.x > 0.0;
        let fall = (1.0 - p.x.abs()).powi(3);
        *p +=
            if right { DVec3::new(wide, 0.3 * wide, 0.0) } else { DVec3::new(-0.4 * wide, 0.0, 0.0) } * fall;
    }
    (points, faces, lips)
}

fn lips(left_is_long: bool) -> String {
    let edge =
        |long: bool| format!("Edge(piece: \"cloth\", from: (0, 0, -0.5), to: (0, 0, 0.5), long: {long})");
    format!("a: {}, b: {}", edge(left_is_long), edge(!left_is_long))
}

#[test]
fn a_slit_is_sewn_shut() {
    let place = Place::new();
    let (points, faces, [left, right]) = slit();
    place.write("cloth.obj", obj(&points, &faces));
    let cloth = "Piece(name: \"cloth\", object: File(\"cloth.obj\"))";
    for (long, bias) in [(false, "0.5"), (true, "0.2")] {
        let seam = format!("Seam({}, bias: {bias}, correspondence: Parameter, radius: 0.3)", lips(long));
        let now = place.still(&format!("Stitch(patches: [{cloth}], seams: [{seam}])"), 0.0);
        assert!(apart(&at(&points, &left), &at(&points, &right)) > 0.13, "it gapes at rest");
        assert!(apart(&at(&now, &left), &at(&now, &right)) <= ONE * diagonal(&now), "it is shut");
        let share = if long { 0.8 } else { 0.5 };
        for (&i, &k) in left.iter().zip(&right) {
            let want = points[i].lerp(points[k], share);
            assert!(now[i].distance(want) < 1e-5, "at {} it lies at {}, not {want}", points[i], now[i]);
        }
        // What is beyond the radius of both lips stays.
        for (p, q) in points.iter().zip(&now).filter(|(p, _)| p.x.abs() > 0.45 || p.z.abs() > 0.85) {
            assert!(p.distance(*q) < 1e-6, "{p} comes to {q}");
        }
    }
}

/// Each lip is moved by its own wire, although both are near to all of it: neither goes through the other.
#[test]
fn lips_do_not_cross() {
    let place = Place::new();
    let (points, faces, [left, right]) = slit();
    place.write("cloth.obj", obj(&points, &faces));
    let seam = format!("Seam({}, radius: 0.6)", lips(false));
    let preset = format!("Stitch(patches: [\"cloth\"], seams: [{seam}])");
    let (now, _) = place.still_of(&preset, "cloth.obj", 0.0);
    // Rows across the slit keep their order.
    for (k, j) in (N / 4 + 1..3 * N / 4).enumerate() {
        let half = |columns: std::ops::Range<usize>| columns.map(move |i| i * (N + 1) + j);
        let row: Vec<usize> =
            half(0..N / 2 + 1).chain([right[k + 1]]).chain(half(N / 2 + 1..N + 1)).collect();
        assert_eq!(row[N / 2], left[k + 1]);
        for (points, least) in [(&points, 0.0), (&now, -1e-6)] {
            let steps = row.windows(2).map(|pair| points[pair[1]].x - points[pair[0]].x);
            let narrowest = steps.fold(f64::MAX, f64::min);
            assert!(narrowest >= least, "row {j} turns back by {narrowest}");
        }
    }
}

#[test]
fn the_long_way_round_is_the_other_three_sides() {
    let place = Place::new();
    let (points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [8, 8]);
    place.write("cloth.obj", obj(&points, &faces));
    // A frame that is far above, its border as long as three sides.
    for (long, moved) in [(false, 9), (true, 25)] {
        let preset = format!(
            "Stitch(
                patches: [
                    Piece(name: \"cloth\", object: File(\"cloth.obj\")),
                    Piece(name: \"rail\", object: Grid(size: (6, 1), cells: (24, 2), translation: (0, 1, 3))),
                ],
                seams: [Seam(
                    a: Edge(piece: \"cloth\", from: (-1, 0, -1), to: (1, 0, -1), long: {long}),
                    b: Edge(piece: \"rail\", side: VMin), bias: 1, radius: 0.1)])"
        );
        let now = place.still(&preset, 0.0);
        let count = now[..81].iter().filter(|p| p.y > 0.5).count();
        assert_eq!(count, moved, "long: {long}");
        // From one end of the rail to the other.
        let width = now[..81].iter().filter(|p| p.y > 0.5).map(|p| p.x.abs()).fold(0.0, f64::max);
        assert!((width - 3.0).abs() < 1e-5, "{width}");
    }
}
