//! One seam: where it lies, how far surfaces follow, what stays.

use std::collections::BTreeSet;

use glam::DVec3;

use super::{EXACT, ONE, apart, at, diagonal, edges, lines, off, pair, sewn, straight};
use crate::place::Place;
use crate::wrinkles::vertices;

const CELLS: [usize; 2] = [16, 20];
const SEWN: &str = "correspondence: Parameter, radius: 0.4";

#[test]
fn edges_of_a_closed_seam_coincide_halfway() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let (rest, now) = (place.rest_points(&patches), place.still(&sewn(&patches, SEWN), 0.0));
    let [a, b] = edges(&patches);
    let close = ONE * diagonal(&rest);
    assert!(apart(&at(&rest, &a), &at(&rest, &b)) > 0.4, "they are apart at rest");
    assert!(apart(&at(&now, &a), &at(&now, &b)) <= close);
    let halfway: Vec<DVec3> =
        at(&rest, &a).into_iter().zip(at(&rest, &b)).map(|(p, q)| p.midpoint(q)).collect();
    assert!(apart(&at(&now, &a), &halfway) < EXACT * diagonal(&rest));
}

#[test]
fn what_is_farther_than_the_radius_keeps_its_bits() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let text = place.rest(&patches);
    let rest = vertices(&text);
    place.write("sewn.ron", sewn(&patches, SEWN));
    place.run("apply sewn.ron -o sewn.obj --at 0 -q").expect(0);
    let now = place.read("sewn.obj");
    let edges = edges(&patches);
    let mut counts = [0, 0];
    for (i, (before, after)) in lines(&text).into_iter().zip(lines(&now)).enumerate() {
        let own = usize::from(i >= patches[0].count());
        let away = off(rest[i], &at(&rest, &edges[own]));
        // The edge is smooth between its vertices, so that a straight line is a little off it.
        if away > 0.402 {
            assert_eq!(before, after, "vertex {i}, {away} from its edge");
            counts[0] += 1;
        } else if away < 0.36 {
            assert_ne!(before, after, "vertex {i}, {away} from its edge");
            counts[1] += 1;
        }
    }
    assert!(counts.iter().all(|&count| count > 150), "{counts:?}");
}

#[test]
fn a_bias_of_0_or_1_leaves_that_edge() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let text = place.rest(&patches);
    let rest = vertices(&text);
    let edges = edges(&patches);
    for (bias, stays) in [("0", 0), ("1", 1)] {
        place.write("sewn.ron", sewn(&patches, &format!("{SEWN}, bias: {bias}")));
        place.run("apply sewn.ron -o sewn.obj --at 0 -q").expect(0);
        let text_now = place.read("sewn.obj");
        let (before, after) = (lines(&text), lines(&text_now));
        for &i in &edges[stays] {
            assert_eq!(before[i], after[i], "bias {bias}, vertex {i}");
        }
        let now = vertices(&text_now);
        let gap = apart(&at(&now, &edges[1 - stays]), &at(&rest, &edges[stays]));
        assert!(gap <= ONE * diagonal(&rest), "bias {bias}: {gap}");
        // And so does the surface behind it, whose wire has not moved.
        let own = if stays == 0 { 0..patches[0].count() } else { patches[0].count()..rest.len() };
        assert!(before[own.clone()] == after[own], "bias {bias} moves the surface that stays");
    }
}

#[test]
fn the_seam_lies_where_a_keyed_bias_has_it() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let rest = place.rest_points(&patches);
    let [a, b] = edges(&patches);
    let preset = sewn(&patches, &format!("{SEWN}, bias: Keys([(0, 0), (2, 1)])"));
    for seconds in [0.3, 1.0, 1.9] {
        let now = place.still(&preset, seconds);
        let bias = seconds / 2.0;
        let seam: Vec<DVec3> =
            at(&rest, &a).into_iter().zip(at(&rest, &b)).map(|(p, q)| p.lerp(q, bias)).collect();
        for edge in [&a, &b] {
            assert!(apart(&at(&now, edge), &seam) < EXACT * diagonal(&rest), "bias {bias}");
        }
    }
}

#[test]
fn a_closure_of_0_is_the_identity_and_between_all_is_linear() {
    let place = Place::new();
    let patches = pair(CELLS, CELLS);
    let text = place.rest(&patches);
    let rest = vertices(&text);
    let preset = sewn(&patches, &format!("{SEWN}, scale: 1.3, closure: Keys([(1, 0), (2, 1)])"));
    for seconds in ["0", "1"] {
        place.write("sewn.ron", &preset);
        place.run(&format!("apply sewn.ron -o sewn.obj --at {seconds} -q")).expect(0);
        assert!(lines(&text) == lines(&place.read("sewn.obj")), "something moved at {seconds} s");
    }
    let closed = place.still(&preset, 2.0);
    assert!(apart(&rest, &closed) > 0.2);
    for seconds in [1.25, 1.5, 1.875] {
        let now = place.still(&preset, seconds);
        let between: Vec<DVec3> = rest.iter().zip(&closed).map(|(p, q)| p.lerp(*q, seconds - 1.0)).collect();
        assert!(apart(&now, &between) < EXACT * diagonal(&rest), "at {seconds} s");
    }
}

/// The closed form at straight edges 0.4 apart: at distance d all moves by 0.2·f(d/r), after what `scale` does to d.
#[test]
fn surfaces_follow_as_radius_scale_and_density_say() {
    let place = Place::new();
    let patches = straight(0.2, [25, 8]);
    let rest = place.rest_points(&patches);
    let quartic: fn(f64) -> f64 = |x| (1.0 - x * x).powi(2);
    let linear: fn(f64) -> f64 = |x| 1.0 - x;
    let cases = [
        ("radius: 0.5", 0.5, 1.0, quartic),
        ("radius: 0.25", 0.25, 1.0, quartic),
        ("radius: 0.5, scale: 1.4", 0.5, 1.4, quartic),
        ("radius: 0.5, density: Linear", 0.5, 1.0, linear),
    ];
    for (fields, radius, scale, density) in cases {
        let now = place.still(&sewn(&patches, fields), 0.0);
        for (p, q) in rest.iter().zip(&now) {
            let d = p.x.abs() - 0.2;
            let f = if d < radius { density(d / radius) } else { 0.0 };
            let x = p.x.signum() * (0.2 + d * (1.0 + (scale - 1.0) * f) - 0.2 * f);
            let want = DVec3::new(x, 0.0, p.z);
            assert!(q.distance(want) < EXACT * diagonal(&rest), "{fields}: {p} comes to {q}, not {want}");
        }
    }
}

#[test]
fn edges_that_run_the_other_way_are_turned_or_left_as_said() {
    let place = Place::new();
    let [left, mut right] = pair(CELLS, CELLS);
    let straight = place.still(&sewn(&[left.clone(), right.clone()], SEWN), 0.0);
    for row in &mut right.points {
        row.reverse();
    }
    let patches = [left, right];
    let [a, mut b] = edges(&patches);
    let seam = at(&straight, &a);
    b.reverse();
    for reversed in ["Auto", "true"] {
        let now = place.still(&sewn(&patches, &format!("{SEWN}, reversed: {reversed}")), 0.0);
        for edge in [&a, &b] {
            assert!(apart(&at(&now, edge), &seam) < EXACT * diagonal(&now), "reversed: {reversed}");
        }
    }
    // Crosswise, but sewn: each vertex with that of the same number.
    b.reverse();
    let now = place.still(&sewn(&patches, &format!("{SEWN}, reversed: false")), 0.0);
    assert!(apart(&at(&now, &a), &at(&now, &b)) <= ONE * diagonal(&now));
    assert!(apart(&at(&now, &a), &seam) > 0.5);
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let place = Place::new();
    let fields = "continuity: Tangent, closure: Keys([(0, 0), (1, 1)]), \
                  tears: [Tear(at: Keys([(0, 0.2), (1, 0.8)]), width: 0.4, gape: 0.05)]";
    place.write("sewn.ron", sewn(&pair([30, 40], [50, 34]), fields));
    let mut all = BTreeSet::new();
    for threads in [1, 2, 2] {
        place.run(&format!("apply sewn.ron -o out.glb --threads {threads} -q")).expect(0);
        all.insert(place.read("out.glb"));
    }
    assert_eq!(all.len(), 1);
}
