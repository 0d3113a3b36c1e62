//! Stitches as animations: shut where they are shut in every frame, for as long as something moves, below nodes of any kind.

use glam::DVec3;
use serde_json::json;

use super::{Film, ONE, Patch, apart, at, diagonal, edges, pair, sewn, straight};
use crate::document::{chunks, glb};
use crate::place::Place;

const ALONG: usize = 24;

/// Both edges of the seam of these patches, as an animation has them.
fn both(patches: &[Patch; 2], film: &Film, seconds: Option<f64>) -> [Vec<DVec3>; 2] {
    let all = film.at(seconds).concat();
    edges(patches).map(|edge| at(&all, &edge))
}

#[test]
fn no_crack_shows_where_a_moving_tear_is_not() {
    let place = Place::new();
    let patches = pair([10, ALONG], [10, ALONG]);
    let size = diagonal(&place.rest_points(&patches));
    let tear = "Tear(at: Keys([(0, 0.1), (2, 0.9)]), width: 0.3, gape: 0.05)";
    let preset = sewn(&patches, &format!("correspondence: Parameter, tears: [{tear}]"));
    // A bake within a tolerance has both edges within it.
    for (bake, apart) in [("", 2e-4), ("--bake frames", ONE)] {
        let film = place.film(&preset, bake);
        let mut widest: f64 = 0.0;
        for frame in 0..=48 {
            let seconds = f64::from(frame) / 24.0;
            let middle = 0.1 + 0.4 * seconds;
            let [a, b] = both(&patches, &film, Some(seconds));
            for (j, (p, q)) in a.iter().zip(&b).enumerate() {
                if (j as f64 / ALONG as f64 - middle).abs() >= 0.15 {
                    assert!(p.distance(*q) <= apart * size, "frame {frame}, vertex {j}: {}", p.distance(*q));
                }
                widest = widest.max(p.distance(*q));
            }
        }
        assert!(widest > 0.3, "the tear opens");
    }
}

/// The last key of any part of a seam ends the animation.
#[test]
fn all_that_is_keyed_counts_for_the_duration() {
    let place = Place::new();
    let patches = straight(0.2, [4, 6]);
    for (fields, frames) in [
        ("closure: Keys([(0, 0), (0.5, 1)])", 13),
        ("bias: Keys([(0, 0), (1, 1)])", 25),
        ("radius: Ease([(0, 0.2), (1.5, 1)])", 37),
        ("scale: Keys([(0, 1), (2, 1.5)])", 49),
        ("tears: [Tear(at: 0.5, width: 0.2, opening: Keys([(0, 0), (2.25, 1)]))]", 55),
        ("tears: [Tear(at: 0.5, width: 0.2, gape: Keys([(0, 0), (0.25, 0.1)]))]", 7),
        ("radius: 0.3", 1),
    ] {
        place.write("keyed.ron", sewn(&patches, fields));
        let report = place.run("apply keyed.ron --dry-run --report -").expect(0).out();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        assert_eq!(report["frames"], frames, "{fields}");
        assert_eq!(report["wires"], 2, "{fields}");
    }
}

/// Edges are named, and the seam lies, in the world, wherever nodes have put their meshes.
#[test]
fn nodes_that_are_moved_turned_and_scaled_are_sewn_in_the_world() {
    let place = Place::new();
    let patches = pair([10, ALONG], [10, ALONG]);
    place.write("rest.ron", sewn(&patches, "closure: 0"));
    place.run("apply rest.ron -o rest.glb --at 0 -q").expect(0);
    let (mut json, bin) = chunks(&place.read("rest.glb"));
    let turned = [("translation", json!([-0.3, 0.4, 0.2])), ("scale", json!([-2.0, 0.5, 1.5]))];
    for (key, value) in turned {
        json["nodes"][0][key] = value;
    }
    json["nodes"][1]["rotation"] = json!([0.0, 0.6, 0.0, 0.8]);
    place.write("in.glb", glb(&json, bin.as_deref()));
    let rest = both(&patches, &Film::open(&place, "in.glb"), None);
    let run = |name: &str, edge: &[DVec3]| {
        let [from, to] = [edge[0], edge[ALONG]].map(|p| format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z));
        format!("Edge(piece: \"{name}\", from: {from}, to: {to})")
    };
    let [a, b] = [run("left", &rest[0]), run("right", &rest[1])];
    let fields = "closure: Keys([(0, 0), (1, 1)]), reversed: false, correspondence: Parameter";
    place.write("sew.ron", format!("Stitch(seams: [Seam(a: {a}, b: {b}, {fields})])"));
    place.run("apply sew.ron in.glb -o out.glb --bake frames -q").expect(0);
    let film = Film::open(&place, "out.glb");
    let size = diagonal(&film.at(None).concat());
    let [a, b] = both(&patches, &film, Some(1.0));
    let halfway: Vec<DVec3> = rest[0].iter().zip(&rest[1]).map(|(p, q)| p.midpoint(*q)).collect();
    assert!(apart(&rest[0], &rest[1]) > 0.5);
    // What frames may miss.
    assert!(apart(&a, &halfway) < 1e-5 * size && apart(&b, &halfway) < 1e-5 * size);
    let [left, right] = [film.at(None), film.at(Some(0.0))].map(|pieces| pieces.concat());
    assert!(apart(&left, &right) < ONE * size, "apart at first");
}
