//! The same preset on a finer mesh, and on other triangles, gives the same surface; meshes that are too coarse become finer.

use std::collections::HashMap;

use glam::DVec3;
use serde_json::Value;

use super::made::arm;
use super::{HIGH, WIDE, obj, sheet, shut, triangles, vertices};
use crate::document::{Document, differences, list};
use crate::place::Place;

fn key(p: DVec3) -> [i64; 3] {
    (p * 2e4).round().to_array().map(|c| c as i64)
}

/// The largest difference where two meshes have a vertex in common at rest, in parts of the intensity, and how many those are.
fn differ(coarse: [&[DVec3]; 2], fine: [&[DVec3]; 2]) -> (f64, usize) {
    let moved: HashMap<[i64; 3], DVec3> =
        fine[0].iter().map(|p| key(*p)).zip(fine[1].iter().copied()).collect();
    let pairs = coarse[0].iter().zip(coarse[1]).filter_map(|(p, q)| Some((moved.get(&key(*p))?, q)));
    let (mut most, mut count) = (0.0_f64, 0);
    for (p, q) in pairs {
        most = most.max(p.distance(*q) / HIGH);
        count += 1;
    }
    (most, count)
}

#[test]
fn a_mesh_four_times_finer_has_the_same_surface() {
    let place = Place::new();
    let objects = [
        (
            "Grid(size: (2, 2), cells: (84, 84))",
            "Grid(size: (2, 2), cells: (336, 336))",
            "(0.03, 0, -0.07)",
            "(1, 0, 0.3)",
        ),
        (
            "Tube(from: (0, -1, 0), to: (0, 1, 0), radius: 0.3, sides: 64, rings: 81, caps: false)",
            "Tube(from: (0, -1, 0), to: (0, 1, 0), radius: 0.3, sides: 256, rings: 321, caps: false)",
            "(0.05, 0.02, 0.3)",
            "(0.4, 1, 0)",
        ),
        (
            "Sphere(center: (0, 0, 0), radius: 0.6, segments: (128, 64))",
            "Sphere(center: (0, 0, 0), radius: 0.6, segments: (512, 256))",
            "(0.1, 0.2, 0.6)",
            "(0.4, 1, 0)",
        ),
    ];
    let mut worst = Vec::new();
    for (coarse, fine, center, direction) in objects {
        for pattern in ["Tangential", "Ripple", "Radial, branches: (count: 2, depth: 1)"] {
            let run = |object: &str, intensity: f64| {
                let preset = format!(
                    "Wrinkle(object: {object}, center: {center}, direction: {direction}, size: (1.1, 0.8), creases: 4, \
                     pattern: {pattern}, thickness: {WIDE}, intensity: {intensity}, stiffness: 0.5)"
                );
                place.still(&preset, 0.0)
            };
            let (most, count) =
                differ([&run(coarse, 0.0), &run(coarse, HIGH)], [&run(fine, 0.0), &run(fine, HIGH)]);
            let name = coarse.split('(').next().unwrap();
            worst.push(format!("{name} {pattern}: {most:.4}"));
            assert!(count > 4000, "{count} in common");
        }
    }
    eprintln!("{worst:#?}");
    let over = worst.iter().filter(|line| line.rsplit(' ').next().unwrap().parse::<f64>().unwrap() > 0.02);
    assert_eq!(over.count(), 0, "{worst:#?}");
}

#[test]
fn other_triangles_have_the_same_surface() {
    let place = Place::new();
    let (points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [70, 90]);
    // The same quadrangles cut the other way, in another order.
    let (n, m) = (70, 90);
    let at = |i: usize, j: usize| i * (m + 1) + j;
    let mut other = Vec::new();
    for j in (0..m).rev() {
        for i in 0..n {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            other.extend(if (i + j).is_multiple_of(2) {
                [[a, b, d], [b, c, d]]
            } else {
                [[a, b, c], [a, c, d]]
            });
        }
    }
    place.write("one.obj", obj(&points, &faces));
    place.write("other.obj", obj(&points, &other));
    for pattern in ["Tangential", "Ripple", "Radial"] {
        let preset = format!(
            "Wrinkle(direction: (1, 0, 0.37), pattern: {pattern}, thickness: {WIDE}, intensity: {HIGH}, size: (1.2, 1))"
        );
        let [one, other] = ["one.obj", "other.obj"].map(|name| place.still_of(&preset, name, 0.0).0);
        let most = one.iter().zip(&other).map(|(p, q)| p.distance(*q) / HIGH).fold(0.0, f64::max);
        assert!(most < 0.005, "{pattern}: {most}");
    }
}

/// The longest edge of a triangle that a fold moves.
pub(super) fn longest(rest: &[DVec3], now: &[DVec3], faces: &[[usize; 3]]) -> f64 {
    let moved = |v: &usize| rest[*v].distance(now[*v]) > 1e-7;
    let edges = faces
        .iter()
        .filter(|face| face.iter().any(moved))
        .flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]);
    edges.map(|(a, b)| rest[a].distance(rest[b])).fold(0.0, f64::max)
}

#[test]
fn a_coarse_grid_is_refined_where_folds_reach() {
    let place = Place::new();
    for motion in ["", "motion: Travelling(velocity: (0, 0.2)), "] {
        let preset = |intensity: f64, refine: &str| {
            format!(
                "Wrinkle(object: Grid(size: (2, 2), cells: (8, 8)), size: (0.8, 0.4), creases: 2, thickness: {WIDE}, \
                 intensity: {intensity}, {motion}refine: {refine})"
            )
        };
        place.write("off.ron", preset(HIGH, "Off"));
        let told = place.run("apply off.ron -o off.obj --at 0").expect(0).err();
        assert!(told.contains("[coarse]") && told.contains("0.25"), "with the figure: {told}");
        let rest = place.still(&preset(0.0, "Auto"), 0.0);
        for t in [0.0, 1.0] {
            let now = place.still(&preset(HIGH, "Auto"), t);
            let text = place.read("still.obj");
            let faces = triangles(&text);
            assert_eq!(now.len(), rest.len());
            let edge = longest(&rest, &now, &faces);
            assert!(edge <= WIDE / 3.0 * 1.001, "{edge}");
            let top = now.iter().map(|p| p.y).fold(0.0, f64::max);
            assert!((top / HIGH - 1.0).abs() < 0.03, "{top}");
        }
        let first = place.still(&preset(0.0, "Off"), 0.0);
        assert!(rest[..81] == first[..], "the old vertices stand first");
        assert!(rest.len() < 20_000, "only where folds reach: {}", rest.len());
    }
}

#[test]
fn a_refined_model_says_so_and_loses_nothing() {
    let place = Place::new();
    place.write("arm.glb", arm(12, 16).glb());
    let preset = |refine: &str| {
        format!(
            "Wrinkle(center: (0, 0.1, 0), direction: (0, 0, 1), size: (0.25, 0.2), creases: 2, thickness: 0.04, \
             intensity: 0.01, propagation: Keys([(0, 0), (1, 1)]), refine: {refine})"
        )
    };
    place.write("off.ron", preset("Off"));
    place.write("auto.ron", preset("Auto"));
    let told = place.run("apply off.ron arm.glb -o off.glb --at 0").expect(0).err();
    assert!(told.contains("[coarse]"), "{told}");
    let told = place.run("apply auto.ron arm.glb -o fine.glb").expect(0).err();
    assert!(!told.contains("[coarse]") && told.contains("where it folds"), "{told}");
    let [old, new] = ["arm.glb", "fine.glb"].map(|name| Document::open(&place.path(name)));
    let bytes = old.bin.as_ref().unwrap();
    assert!(new.bin.as_ref().unwrap().starts_with(bytes), "the old binary chunk is a prefix of the new one");
    // All that was there is equal, but for the length of the buffer and the mesh of the node.
    let lists = ["accessors", "bufferViews", "meshes", "nodes", "skins", "animations", "buffers"];
    for difference in differences(&old.json, &new.json) {
        let path = difference.path.join("/");
        let added = difference.old.is_none()
            && (lists.contains(&difference.path[0].as_str()) && difference.path.len() == 2
                || difference.path.len() == 1);
        assert!(added || path == "buffers/0/byteLength" || path == "nodes/0/mesh", "{difference:?}");
    }
    let mesh = |document: &Document| document.json["nodes"][0]["mesh"].as_u64().unwrap() as usize;
    assert_eq!((mesh(&old), mesh(&new)), (0, list(&old.json, "meshes").len()));
    let copy = &new.json["meshes"][mesh(&new)]["primitives"][0];
    for attribute in ["POSITION", "NORMAL", "TEXCOORD_0", "JOINTS_0", "WEIGHTS_0"] {
        let index = copy["attributes"][attribute].as_u64().unwrap_or_else(|| panic!("no {attribute}"));
        assert!(index as usize >= list(&old.json, "accessors").len());
    }
    let weights = new.elements(&copy["attributes"]["WEIGHTS_0"]);
    assert!(weights.iter().all(|w| (w.iter().sum::<f64>() - 1.0).abs() < 1e-5));
    // It is fine enough where it folds, and has no crack: what lies between is on the old surface.
    let of = |key: &str| new.elements(&copy[key]).concat();
    let faces: Vec<usize> = of("indices").into_iter().map(|i| i as usize).collect();
    let faces: Vec<[usize; 3]> = faces.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
    let points: Vec<DVec3> =
        new.elements(&copy["attributes"]["POSITION"]).iter().map(|p| DVec3::from_slice(p)).collect();
    place.run("apply auto.ron arm.glb -o still.glb --at 1").expect(0);
    let shown = crate::oracle::evaluate(&place.read("still.glb"), None, 0.0);
    let edge = longest(&points, &shown[0].positions, &faces);
    assert!(edge <= 0.04 / 3.0 * 1.001, "{edge}");
    let moved = points.iter().zip(&shown[0].positions).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
    assert!((moved / 0.01 - 1.0).abs() < 0.05, "{moved}");
    shut(&points, &shown[0].positions);
}

#[test]
fn a_model_that_is_fine_enough_stays_as_it_is() {
    let place = Place::new();
    place.write("arm.glb", arm(96, 160).glb());
    place.write(
        "auto.ron",
        "Wrinkle(center: (0, 0.1, 0), direction: (0, 0, 1), size: (0.25, 0.2), creases: 2, thickness: 0.04, intensity: 0.01, refine: Auto)",
    );
    let told = place.run("apply auto.ron arm.glb -o fine.glb").expect(0).err();
    assert!(!told.contains("where it folds") && !told.contains("warning"), "{told}");
    let new = Document::open(&place.path("fine.glb"));
    assert_eq!(new.json["meshes"].as_array().map(Vec::len), Some(1));
    assert_eq!(new.json["nodes"][0]["mesh"], Value::from(0));
}

#[test]
fn text_of_an_obj_stays_when_it_is_refined() {
    let place = Place::new();
    let (points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [8, 8]);
    place.write("sheet.obj", obj(&points, &faces));
    let preset =
        format!("Wrinkle(size: (1, 0.4), creases: 2, thickness: {WIDE}, intensity: {HIGH}, refine: Auto)");
    let (now, told) = place.still_of(&preset, "sheet.obj", 0.0);
    assert!(told.contains("sheet: 81 vertices are"), "{told}");
    let top = now.iter().map(|p| p.y).fold(0.0, f64::max);
    assert!((top / HIGH - 1.0).abs() < 0.03, "{top}");
    assert!(
        vertices(&place.read("still.obj"))[..81].iter().zip(&points).all(|(p, q)| p.x == q.x && p.z == q.z)
    );
}
