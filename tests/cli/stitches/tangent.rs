//! `continuity: Tangent`: what is left of the crease at a seam goes to nothing as faces get smaller.

use glam::DVec3;

use super::{EXACT, ONE, Patch, apart, at, diagonal, edges, pair, sewn};
use crate::place::Place;

/// Two planes that meet under 40 degrees, a gap of 0.2 between them.
fn roof(cells: [usize; 2]) -> [Patch; 2] {
    let slope = 20_f64.to_radians().tan();
    [
        Patch::new(cells, |u, v| DVec3::new(u - 1.1, (u - 1.0) * slope, 2.0 * v - 1.0)),
        Patch::new(cells, |u, v| DVec3::new(u + 0.1, -u * slope, 2.0 * v - 1.0)),
    ]
}

/// The normals of the faces along both edges: each from a quad, towards ∂u × ∂v.
fn normals(patches: &[Patch; 2], now: &[DVec3]) -> [Vec<DVec3>; 2] {
    let [left, right] = patches;
    let [v, first] = [left.cells[1], left.count()];
    let quad = |corner: usize| {
        let [a, b, c, d] = [corner, corner + 1, corner + v + 2, corner + v + 1].map(|i| now[i]);
        (c - a).cross(b - d).normalize()
    };
    [
        (0..v).map(|j| quad((left.cells[0] - 1) * (v + 1) + j)).collect(),
        (0..right.cells[1]).map(|j| quad(first + j)).collect(),
    ]
}

/// The greatest angle between them, in degrees.
fn crease(patches: &[Patch; 2], now: &[DVec3]) -> f64 {
    let [a, b] = normals(patches, now);
    a.iter().zip(&b).map(|(n, m)| n.cross(*m).length().atan2(n.dot(*m)).to_degrees()).fold(0.0, f64::max)
}

#[test]
fn a_roof_has_no_ridge() {
    let place = Place::new();
    for bias in [0.5, 0.0, 0.8] {
        let creases = [10, 30, 90].map(|u| {
            let patches = roof([u, 8]);
            let fields = format!("radius: 0.6, bias: {bias}, correspondence: Parameter");
            let plain = place.still(&sewn(&patches, &fields), 0.0);
            assert!(crease(&patches, &plain) > 30.0, "in position only, there is one");
            let now = place.still(&sewn(&patches, &format!("{fields}, continuity: Tangent")), 0.0);
            let [a, b] = edges(&patches);
            assert!(apart(&at(&now, &a), &at(&now, &b)) <= ONE * diagonal(&now));
            assert!(apart(&at(&now, &a), &at(&plain, &a)) < EXACT * diagonal(&now), "it lies where it lay");
            crease(&patches, &now)
        });
        let falls = creases.windows(2).all(|pair| pair[1] < pair[0] / 2.0);
        assert!(falls && creases[2] < 1.0, "bias {bias}: {creases:?}");
    }
}

#[test]
fn surfaces_that_bend_meet_smoothly() {
    let place = Place::new();
    let fields = "radius: 0.6, correspondence: Parameter";
    let creases = [16, 48, 144].map(|n| {
        let patches = pair([n, n], [n, n]);
        let plain = place.still(&sewn(&patches, fields), 0.0);
        assert!(crease(&patches, &plain) > 10.0);
        crease(&patches, &place.still(&sewn(&patches, &format!("{fields}, continuity: Tangent")), 0.0))
    });
    assert!(creases.windows(2).all(|pair| pair[1] < pair[0]) && creases[2] < 1.0, "{creases:?}");
}

/// With bias 0 the left side is not turned, and the right one takes all of the angle.
#[test]
fn the_side_on_which_the_seam_lies_keeps_its_plane() {
    let place = Place::new();
    let patches = roof([60, 8]);
    let rest = place.rest_points(&patches);
    for (bias, stays) in [(0.0, 0), (1.0, 1)] {
        let fields = format!("radius: 0.6, bias: {bias}, continuity: Tangent");
        let now = place.still(&sewn(&patches, &fields), 0.0);
        let [own, all] = [0..patches[0].count(), 0..rest.len()];
        let own = if stays == 0 { own } else { own.end..all.end };
        assert!(apart(&rest[own.clone()], &now[own]) < EXACT * diagonal(&rest), "bias {bias}");
        assert!(crease(&patches, &now) < 1.0, "bias {bias}: {}", crease(&patches, &now));
    }
}

/// Closed only in part, the planes are turned in part, and what is torn is not turned.
#[test]
fn what_is_torn_keeps_its_plane() {
    let place = Place::new();
    let patches = roof([60, 20]);
    let rest = place.rest_points(&patches);
    let fields = "radius: 0.3, continuity: Tangent, correspondence: Parameter, \
                  tears: [Tear(at: 0.5, width: 0.8, plateau: 0.9)]";
    let now = place.still(&sewn(&patches, fields), 0.0);
    let [before, after] = [&rest, &now].map(|points| normals(&patches, points));
    for side in 0..2 {
        for j in [9, 10] {
            assert!(before[side][j].angle_between(after[side][j]) < 1e-3, "side {side}, face {j}");
        }
        assert!(before[side][0].angle_between(after[side][0]) > 0.3, "side {side}: the end is sewn");
    }
}
