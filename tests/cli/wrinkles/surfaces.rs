//! On surfaces of every kind: seams, borders, several shells, nodes that turn and scale, patches, stacks.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3, EulerRot};

use super::made::document;
use super::{HIGH, WIDE, obj, section, sheet, shut};
use crate::document::Document;
use crate::place::Place;
use crate::player::play;

/// Two folds on a sheet of 2 m.
const FOLDS: &str =
    "Wrinkle(size: (1.2, 0.8), creases: 2, direction: (1, 0, 0), thickness: 0.1, intensity: 0.03";

fn sheet_of_two() -> (Vec<DVec3>, Vec<[usize; 3]>) {
    sheet([-1.0, -1.0], [1.0, 1.0], [50, 80])
}

#[test]
fn a_node_that_turns_scales_and_mirrors_changes_nothing_in_the_world() {
    let place = Place::new();
    let (points, faces) = sheet_of_two();
    place.write("sheet.obj", obj(&points, &faces));
    let (flat, _) = place.still_of(&format!("{FOLDS})"), "sheet.obj", 0.0);
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.4, -0.8, 1.9);
    for (scale, split) in [
        (DVec3::ONE, true),
        (DVec3::splat(0.01), false),
        (DVec3::new(2.0, 0.5, 3.0), false),
        (DVec3::new(-1.5, 1.0, 0.7), true),
    ] {
        let node = DMat4::from_scale_rotation_translation(scale, turn, DVec3::new(0.3, -0.2, 0.5));
        let doc = document(&points, &faces, node, split);
        place.write("sheet.glb", doc.glb());
        place.write("folds.ron", format!("{FOLDS}, propagation: Keys([(0, 0), (1, 1)]))"));
        place.run("apply folds.ron sheet.glb -o out.glb -q").expect(0);
        let out = Document::open(&place.path("out.glb"));
        let [rest, now] = [0.0, 1.0].map(|t| play(&out, Some("wirework"), t).swap_remove(0));
        let corners: Vec<usize> =
            if split { faces.iter().flatten().copied().collect() } else { (0..points.len()).collect() };
        for ((v, rest), now) in corners.iter().zip(&rest).zip(&now) {
            assert!(rest.distance(points[*v]) < 1e-5, "{rest}");
            assert!(now.distance(flat[*v]) < 0.01 * HIGH, "scale {scale}: {now} is not {}", flat[*v]);
        }
    }
}

#[test]
fn seams_are_crossed_as_if_they_were_not_there() {
    let place = Place::new();
    let objects = [
        // The seam of a tube runs through +X, that of a globe too.
        ("Tube(from: (0, -1, 0), to: (0, 1, 0), radius: 0.3, sides: 64, rings: 81)", DVec3::X * 0.3),
        ("Sphere(center: (0, 0, 0), radius: 0.4, segments: (128, 64))", DVec3::X * 0.4),
        ("Sphere(center: (0, 0, 0), radius: 0.4, segments: (128, 64))", DVec3::Y * 0.4),
        (
            "Box(min: (-0.3, -0.3, -0.3), max: (0.3, 0.3, 0.3), cells: (24, 24, 24))",
            DVec3::new(0.3, 0.1, 0.1),
        ),
    ];
    for (object, center) in objects {
        for pattern in ["Tangential", "Ripple", "Radial"] {
            let preset = format!(
                "Wrinkle(object: {object}, center: ({}, {}, {}), direction: (0, 0.1, 1), size: (0.8, 0.6), creases: 3, \
                 pattern: {pattern}, thickness: 0.08, intensity: {HIGH}, propagation: Keys([(0, 0), (1, 1)]))",
                center.x, center.y, center.z
            );
            place.write("seam.ron", &preset);
            let told = place.run("apply seam.ron -o seam.glb").expect(0).err();
            assert!(!told.contains("[border]") && !told.contains("[non-manifold]"), "{told}");
            let out = Document::open(&place.path("seam.glb"));
            let [rest, now] = [0.0, 1.0].map(|t| play(&out, Some("wirework"), t).swap_remove(0));
            shut(&rest, &now);
            // And the same as without a seam.
            let one = place.still(&preset, 1.0);
            let whole: HashMap<[i64; 3], DVec3> = place
                .still(&preset, 0.0)
                .iter()
                .map(|p| (*p * 1e4).round().to_array().map(|c| c as i64))
                .zip(one)
                .collect();
            for (p, q) in rest.iter().zip(&now) {
                let same = whole[&(*p * 1e4).round().to_array().map(|c| c as i64)];
                assert!(same.distance(*q) < 2e-3 * HIGH + 2e-4, "{object} {pattern}: {q}, not {same}");
            }
        }
    }
}

#[test]
fn only_the_side_that_the_wire_is_on_moves() {
    let place = Place::new();
    // A shirt of two sheets, 2 cm apart, and a bag closed all round: folds of 10 cm would reach through.
    let bag = "Box(min: (-1, -0.01, -1), max: (1, 0.01, 1), cells: (50, 1, 80))";
    for pattern in
        ["Tangential", "Ripple", "Radial", "Drawn([Polyline([(-0.5, 0.01, 0.2), (0.5, 0.01, 0)])])"]
    {
        let preset = |intensity: f64| {
            format!(
                "Wrinkle(object: {bag}, center: (0, 0.01, 0), size: (1, 0.8), pattern: {pattern}, thickness: {WIDE}, \
                 intensity: {intensity})"
            )
        };
        let (rest, now) = (place.still(&preset(0.0), 0.0), place.still(&preset(HIGH), 0.0));
        let most = |side: f64| {
            let pairs = rest.iter().zip(&now).filter(|(p, _)| p.y * side > 0.005);
            pairs.map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
        };
        assert!(most(1.0) > 0.9 * HIGH, "{pattern}: {}", most(1.0));
        assert_eq!(most(-1.0), 0.0, "{pattern}: the back");
    }
}

#[test]
fn a_border_ends_a_crease_with_a_word_and_another_shell_stays() {
    let place = Place::new();
    let (mut points, mut faces) = sheet([-1.0, -1.0], [0.4, 1.0], [35, 80]);
    let (more, others) = sheet([0.41, -1.0], [1.0, 1.0], [15, 80]);
    let old = points.len();
    points.extend(&more);
    faces.extend(others.iter().map(|face| face.map(|v| v + old)));
    place.write("two.obj", obj(&points, &faces));
    let (now, told) = place.still_of(&format!("{FOLDS})"), "two.obj", 0.0);
    assert!(told.contains("a border of the surface cuts creases short 2 times [border]"), "{told}");
    assert!(told.contains("[apart]"), "{told}");
    assert!(now[old..] == points[old..], "the other shell stays");
    let crest: Vec<&DVec3> = now.iter().filter(|p| (p.z - 0.2).abs() < 1e-4 && p.x.abs() < 0.41).collect();
    assert!(crest.len() > 20);
    for p in crest.iter().filter(|p| p.x.abs() < 0.405) {
        assert!((p.y / HIGH - 1.0).abs() < 0.03, "full height up to the border: {p}");
    }
    // A pattern that lies beside it in part.
    let preset = "Wrinkle(size: (0.5, 6), creases: 6, thickness: 0.1, intensity: 0.03)";
    let (now, told) = place.still_of(preset, "two.obj", 0.0);
    assert!(
        told.contains("4 of 6 creases lie beyond the surface and are left out [outside-surface]"),
        "{told}"
    );
    assert_eq!(super::crests(&section(&now, 0.0), HIGH).len(), 2);
}

#[test]
fn an_edge_of_three_faces_ends_a_crease_with_a_word() {
    let place = Place::new();
    let (mut points, mut faces) = sheet([-1.0, -1.0], [0.4, 1.0], [35, 80]);
    let (more, others) = sheet([0.4, -1.0], [1.0, 1.0], [15, 80]);
    let [flat, wall] = [0, 1].map(|i| points.len() + i * more.len());
    points.extend(&more);
    points.extend(more.iter().map(|p| DVec3::new(0.4, p.x - 0.4, p.z)));
    for base in [flat, wall] {
        faces.extend(others.iter().map(|face| face.map(|v| v + base)));
    }
    place.write("three.obj", obj(&points, &faces));
    let (now, told) = place.still_of(&format!("{FOLDS})"), "three.obj", 0.0);
    assert!(told.contains("an edge where the surface is not a manifold"), "{told}");
    // No jump: it stops where the sheets meet, and what reaches beyond is the round end of the fold.
    for (p, q) in points.iter().zip(&now) {
        let beyond = (p.x - 0.4).max(p.y);
        assert!(beyond < 1.02 * WIDE || p == q, "{p} to {q}");
        assert!(p.distance(*q) < 1.01 * HIGH, "{p} to {q}");
    }
    let crest = now.iter().filter(|p| (p.z - 0.2).abs() < 1e-4 && p.x < 0.37 && p.x > -0.55);
    crest.for_each(|p| assert!((p.y / HIGH - 1.0).abs() < 0.03, "{p}"));
}

#[test]
fn parts_of_the_bounds_are_metres_of_another_size() {
    let place = Place::new();
    let preset = |unit: &str, by: f64, wide: f64| {
        format!(
            "Wrinkle(object: Grid(size: ({0}, {0}), cells: (50, 80)), units: {unit}, center: ({1}, 0, 0), size: ({2}, {3}), \
             creases: 2, thickness: {4}, intensity: {5}, motion: Travelling(velocity: (0, {1})))",
            wide,
            0.1 * by,
            0.6 * by,
            0.4 * by,
            0.05 * by,
            0.015 * by
        )
    };
    let metres = place.still(&preset("Metres", 30.0, 30.0), 0.5);
    let parts = place.still(&preset("Bounds", 1.0, 30.0), 0.5);
    assert!(metres.iter().map(|p| p.y).fold(0.0, f64::max) > 0.4);
    for (a, b) in metres.iter().zip(&parts) {
        assert!(a.distance(*b) < 1e-4, "{a} {b}");
    }
}

#[test]
fn only_and_masks_hold_what_they_hold() {
    let place = Place::new();
    let (points, faces) = sheet_of_two();
    let mut doc = document(&points, &faces, DMat4::IDENTITY, false);
    // The same again, in its place, under another name.
    doc.node(serde_json::json!({ "name": "lining", "mesh": 0, "translation": [0, -0.001, 0] }));
    doc.json["scenes"] = serde_json::json!([{ "nodes": [0, 1] }]);
    place.write("both.glb", doc.glb());
    place.write("only.ron", format!("{FOLDS}, only: Nodes([\"sheet\"]))"));
    place.run("apply only.ron both.glb -o out.glb --at 0 -q").expect(0);
    let shown = play(&Document::open(&place.path("out.glb")), None, 0.0);
    let top = |i: usize| shown[i].iter().map(|p| p.y).fold(f64::MIN, f64::max);
    assert!((top(0) / HIGH - 1.0).abs() < 0.03, "{}", top(0));
    assert!((top(1) + 0.001).abs() < 1e-7, "the lining stays: {}", top(1));
    image::DynamicImage::ImageLuma8(image::ImageBuffer::from_pixel(2, 2, image::Luma([51])))
        .save(place.path("fifth.png"))
        .unwrap();
    let masked = format!("{FOLDS}, object: Grid(size: (2, 2), cells: (50, 80)), mask: Image(\"fifth.png\"))");
    let top = place.still(&masked, 0.0).iter().map(|p| p.y).fold(0.0, f64::max);
    assert!((top / (0.2 * HIGH) - 1.0).abs() < 0.03, "{top}");
}

#[test]
fn patches_are_wrinkled() {
    let place = Place::new();
    // A flat one, its outside ∂u × ∂v = Z × X up, and the half of a tube.
    let flat = "Patch(degree: (1, 1), points: [[(-1, 0, -1), (1, 0, -1)], [(-1, 0, 1), (1, 0, 1)]], tessellation: (100, 100))";
    let points = place.still(&format!("{FOLDS}, object: {flat})"), 0.0);
    let found = super::crests(&section(&points, 0.0), HIGH);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found.iter().all(|c| (c.1 / HIGH - 1.0).abs() < 0.03 && (c.0.abs() - 0.2).abs() < 0.011),
        "{found:?}"
    );
    let bow = "Patch(degree: (1, 2), points: [[(-1, 0, 0.5), (-1, 0.7, 0), (-1, 0, -0.5)], [(1, 0, 0.5), (1, 0.7, 0), (1, 0, -0.5)]], tessellation: (80, 80))";
    let preset = |high: f64| {
        format!(
            "Wrinkle(object: {bow}, center: (0, 0.35, 0), size: (1.2, 0.6), creases: 1, thickness: 0.1, intensity: {high})"
        )
    };
    let (rest, now) = (place.still(&preset(0.0), 0.0), place.still(&preset(HIGH), 0.0));
    let most = rest.iter().zip(&now).map(|(p, q)| (q.y - p.y).abs()).fold(0.0, f64::max);
    assert!((most / HIGH - 1.0).abs() < 0.03, "{most}");
}

#[test]
fn in_a_stack_folds_stand_on_what_is_below() {
    let place = Place::new();
    let preset = "Stack([
        Deform(object: Grid(size: (2, 2), cells: (50, 80)), wires: [Wire(curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]),
            pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.5, 0), (1, 0.5, 0)])]), radius: 50)]),
        Wrinkle(size: (1.2, 0.8), creases: 2, thickness: 0.1, intensity: 0.03),
        Wrinkle(size: (1.2, 0.8), creases: 2, thickness: 0.1, intensity: 0.03, blend: Blend(crossing: 1)),
    ])";
    for (t, floor) in [(0.0, 0.0), (1.0, 0.5)] {
        let crest = place.still(preset, t);
        let crest = crest.iter().filter(|p| (p.z.abs() - 0.2).abs() < 2e-3 && p.x.abs() < 0.5);
        let heights: Vec<f64> = crest.map(|p| p.y - floor).collect();
        assert!(heights.len() > 40);
        // The second stands on the first.
        assert!(heights.iter().all(|h| (h / (2.0 * HIGH) - 1.0).abs() < 0.04), "at {t} s: {heights:?}");
    }
}
