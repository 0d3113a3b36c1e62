//! Where seams meet: one point, in whatever order they are written.

use glam::DVec3;

use super::{EXACT, ONE, Patch, Side, apart, at, diagonal};
use crate::place::Place;

const ALONG: usize = 12;
/// Names of the quarters, by the signs of x and z.
const QUARTERS: [(&str, f64, f64); 4] =
    [("pp", 1.0, 1.0), ("mp", -1.0, 1.0), ("mm", -1.0, -1.0), ("pm", 1.0, -1.0)];
/// Which quarters are sewn along which side; all begin in the middle.
const SEAMS: [(usize, usize, Side); 4] =
    [(0, 1, Side::UMin), (1, 2, Side::VMin), (3, 2, Side::UMin), (0, 3, Side::VMin)];
const BIASES: [f64; 4] = [0.5, 0.3, 0.6, 0.45];

/// Four sheets about the origin, none as high as the next, all bent.
fn quarters() -> [Patch; 4] {
    [0, 1, 2, 3].map(|k: usize| {
        let (_, x, z) = QUARTERS[k];
        let high = [0.0, 0.12, -0.08, 0.2][k];
        Patch::new([ALONG, ALONG], |u, v| {
            let gap = 0.1 + 0.02 * k as f64;
            DVec3::new(
                x * (gap + u + 0.1 * v * v),
                high + 0.15 * u * v - 0.1 * v * v,
                z * (gap + v - 0.05 * u),
            )
        })
    })
}

fn seam(number: usize, fields: &str) -> String {
    let (a, b, side) = SEAMS[number];
    let side = if matches!(side, Side::UMin) { "UMin" } else { "VMin" };
    let edge = |quarter: usize| format!("Edge(piece: \"{}\", side: {side})", QUARTERS[quarter].0);
    format!(
        "Seam(a: {}, b: {}, bias: {}, correspondence: Parameter, {fields})",
        edge(a),
        edge(b),
        BIASES[number]
    )
}

fn stitch(seams: &[String], order: &str) -> String {
    let pieces: Vec<String> =
        quarters().iter().zip(QUARTERS).map(|(patch, (name, ..))| patch.piece(name)).collect();
    format!("Stitch(patches: [{}], seams: [{}], order: {order})", pieces.join(", "), seams.join(", "))
}

/// All four in this order.
fn all(order: [usize; 4], fields: &str) -> Vec<String> {
    order.iter().map(|&number| seam(number, fields)).collect()
}

/// The vertices of both edges of a seam, from the middle outwards.
fn edges(number: usize) -> [Vec<usize>; 2] {
    let (a, b, side) = SEAMS[number];
    let patches = quarters();
    [a, b].map(|quarter| {
        let before: usize = patches[..quarter].iter().map(Patch::count).sum();
        patches[quarter].side(side).into_iter().map(|i| i + before).collect()
    })
}

/// Where a seam would lie by itself.
fn alone(rest: &[DVec3], number: usize) -> Vec<DVec3> {
    let [a, b] = edges(number).map(|edge| at(rest, &edge));
    a.into_iter().zip(b).map(|(p, q)| p.lerp(q, BIASES[number])).collect()
}

fn permutations() -> Vec<[usize; 4]> {
    let mut out = Vec::new();
    for code in 0..256_usize {
        let order = [code % 4, code / 4 % 4, code / 16 % 4, code / 64];
        if (0..4).all(|number| order.contains(&number)) {
            out.push(order);
        }
    }
    out
}

#[test]
fn four_seams_meet_in_the_mean_of_their_ends_and_follow() {
    let place = Place::new();
    let rest = place.rest_points(&quarters());
    let now = place.still(&stitch(&all([0, 1, 2, 3], ""), "Simultaneous"), 0.0);
    let size = diagonal(&rest);
    let seams = [0, 1, 2, 3].map(|number| alone(&rest, number));
    let corner = seams.iter().map(|seam| seam[0]).sum::<DVec3>() / 4.0;
    for (number, seam) in seams.iter().enumerate() {
        let follow = |(j, p): (usize, &DVec3)| *p + (corner - seam[0]) * (1.0 - j as f64 / ALONG as f64);
        let want: Vec<DVec3> = seam.iter().enumerate().map(follow).collect();
        let [a, b] = edges(number).map(|edge| at(&now, &edge));
        assert!(apart(&a, &b) <= ONE * size, "seam {number} is not shut");
        assert!(apart(&a, &want) < EXACT * size, "seam {number} lies elsewhere");
        assert!(a[0].distance(edges(0).map(|edge| now[edge[0]])[0]) <= ONE * size, "the corner is one point");
    }
}

#[test]
fn all_24_orders_agree() {
    let place = Place::new();
    let orders = permutations();
    assert_eq!(orders.len(), 24);
    for fields in ["radius: 0.5", "radius: 0.5, continuity: Tangent"] {
        let [first, rest @ ..] = orders.as_slice() else { panic!("24") };
        let want = place.still(&stitch(&all(*first, fields), "Simultaneous"), 0.0);
        for order in rest {
            let now = place.still(&stitch(&all(*order, fields), "Simultaneous"), 0.0);
            assert!(apart(&now, &want) <= 1e-5 * diagonal(&want), "{fields}: {order:?}");
        }
    }
}

#[test]
fn a_point_on_a_closed_seam_is_moved_by_that_seam_alone() {
    let place = Place::new();
    let with = |radii: [f64; 4]| {
        let seams: Vec<String> =
            (0..4).map(|number| seam(number, &format!("radius: {}", radii[number]))).collect();
        place.still(&stitch(&seams, "Simultaneous"), 0.0)
    };
    let narrow = with([0.4; 4]);
    for number in 0..4 {
        let mut radii = [0.9, 1.3, 0.15, 1.1];
        radii[number] = 0.4;
        let wide = with(radii);
        for edge in edges(number) {
            let moved = apart(&at(&narrow, &edge), &at(&wide, &edge));
            assert!(moved <= ONE * diagonal(&narrow), "seam {number} moves by {moved}");
        }
        assert!(apart(&narrow, &wide) > 0.01, "other points follow other radii");
    }
}

#[test]
fn a_seam_that_is_apart_is_as_none() {
    let place = Place::new();
    let mut seams = all([0, 1, 2, 3], "")[..3].to_vec();
    let want = place.still(&stitch(&seams, "Simultaneous"), 0.0);
    seams.push(seam(3, "closure: Keys([(0, 0), (1, 1)])"));
    let preset = stitch(&seams, "Simultaneous");
    assert!(apart(&place.still(&preset, 0.0), &want) <= ONE * diagonal(&want));
    // And once it is closed, all four are.
    let four = place.still(&stitch(&all([0, 1, 2, 3], ""), "Simultaneous"), 0.0);
    assert!(apart(&place.still(&preset, 1.0), &four) <= ONE * diagonal(&four));
    assert!(apart(&four, &want) > 0.02);
}

/// A seam that is torn at the corner does not part the others there, and opens all the same.
#[test]
fn a_tear_that_reaches_the_corner_leaves_it_to_the_others() {
    let place = Place::new();
    let rest = place.rest_points(&quarters());
    let whole = place.still(&stitch(&all([0, 1, 2, 3], ""), "Simultaneous"), 0.0);
    let close = 1e-5 * diagonal(&rest);
    for (tear, middle, half) in [
        ("Tear(at: 0, width: 0.6)", 0.0, 0.3),
        ("Tear(at: 0.15, width: 0.5)", 0.15, 0.25),
        ("Tear(at: 0, width: 0.6, plateau: 0.9)", 0.0, 0.3),
    ] {
        let mut seams = all([0, 1, 2, 3], "");
        seams[2] = seam(2, &format!("tears: [{tear}]"));
        let torn = place.still(&stitch(&seams, "Simultaneous"), 0.0);
        let corners = [0, 2].map(|number| edges(number).map(|edge| torn[edge[0]])).concat();
        for corner in &corners[1..] {
            assert!(corner.distance(corners[0]) < close, "{tear}: the corner parts: {corners:?}");
        }
        for number in [0, 1, 3] {
            let [a, b] = edges(number).map(|edge| at(&torn, &edge));
            assert!(apart(&a, &b) < close, "{tear}: seam {number} stays shut");
        }
        let plateau = if tear.contains("plateau") { 0.9 } else { 0.0 };
        let gap = |points: &[DVec3], j: usize| edges(2).map(|edge| points[edge[j]]);
        for j in 1..=ALONG {
            let t = j as f64 / ALONG as f64;
            let x = (((t - middle).abs() / half - plateau) / (1.0 - plateau)).max(0.0);
            let open = if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 };
            let ([p, q], [own, other], [seam, _]) = (gap(&torn, j), gap(&rest, j), gap(&whole, j));
            // Beside the corner it is on its way.
            let on = if t < 0.12 { 0.2 } else { 2.0 * EXACT };
            for (now, rest) in [(p, own), (q, other)] {
                let off = now.distance(seam.lerp(rest, open));
                assert!(off <= on, "{tear}: vertex {j} is {off} off where a tear of {open} has it");
            }
        }
    }
}

#[test]
fn one_after_the_other_depends_on_the_order() {
    let place = Place::new();
    let together = place.still(&stitch(&all([0, 1, 2, 3], ""), "Simultaneous"), 0.0);
    let orders = [[0, 1, 2, 3], [3, 2, 1, 0]];
    let found = orders.map(|order| place.still(&stitch(&all(order, ""), "Sequential"), 0.0));
    for (now, order) in found.iter().zip(orders) {
        assert!(apart(now, &together) > 0.01, "{order:?} is as together");
        // The last one is shut; those before may be torn again by those behind.
        let [a, b] = edges(order[3]).map(|edge| at(now, &edge));
        assert!(apart(&a, &b) <= ONE * diagonal(now), "{order:?}");
    }
    assert!(apart(&found[0], &found[1]) > 0.01);
    // A single seam is the same in both.
    let [one, same] =
        ["Sequential", "Simultaneous"].map(|order| place.still(&stitch(&[seam(1, "")], order), 0.0));
    assert_eq!(apart(&one, &same), 0.0);
}
