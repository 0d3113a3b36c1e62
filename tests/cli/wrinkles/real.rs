//! Real models: cloth, the sleeves of a suit, a man who walks, a robot.

use std::collections::BTreeSet;

use glam::DVec3;

use super::vertices;
use crate::document::{Document, differences, list};
use crate::oracle;
use crate::place::{Place, shared};

#[test]
fn a_cloth_has_its_folds() {
    let Some(path) = shared("garment/plane_30x30.obj") else { return };
    let place = Place::new();
    let rest = vertices(&std::fs::read(&path).unwrap());
    let model = path.to_str().unwrap();
    let side = rest.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max) * 2.0;
    for (preset, refined) in [
        ("Wrinkle(units: Bounds, size: (0.8, 0.7), creases: 3, thickness: 0.1, intensity: 0.02)", false),
        (
            "Wrinkle(units: Bounds, size: (0.8, 0.7), creases: 7, thickness: 0.04, intensity: 0.02, refine: Auto)",
            true,
        ),
    ] {
        place.write("cloth.ron", preset);
        let told = place
            .run_with(["apply", "cloth.ron", model, "-o", "cloth.obj", "--at", "0"], b"")
            .expect(0)
            .err();
        let now = vertices(&place.read("cloth.obj"));
        assert_eq!(now.len() > rest.len(), refined, "{told}");
        assert!(!told.contains("warning"), "{told}");
        let moved = now.iter().zip(&rest).map(|(q, p)| q.distance(*p)).fold(0.0, f64::max);
        assert!(moved > 0.9 * 0.02 * side && moved < 1.01 * 0.02 * side || refined, "{moved} of {side}");
    }
}

#[test]
fn a_sleeve_wrinkles_and_the_chest_does_not() {
    let Some(path) = shared("garment/male_casualsuit04.obj") else { return };
    let place = Place::new();
    let rest = vertices(&std::fs::read(&path).unwrap());
    let far = rest.iter().map(|p| p.x).fold(f64::MIN, f64::max);
    let on = rest.iter().copied().filter(|p| p.x > 0.7 * far).collect::<Vec<_>>();
    let middle = on.iter().sum::<DVec3>() / on.len() as f64;
    let tall =
        rest.iter().map(|p| p.y).fold(f64::MIN, f64::max) - rest.iter().map(|p| p.y).fold(f64::MAX, f64::min);
    let (length, thick, high) = (0.15 * tall, 0.012 * tall, 0.004 * tall);
    place.write(
        "sleeve.ron",
        format!(
            "Wrinkle(center: ({}, {}, {}), direction: (0, 0, 1), size: ({length}, {}), creases: 4, thickness: {thick}, \
             intensity: {high}, refine: Auto)",
            middle.x, middle.y + 0.03 * tall, middle.z, length / 2.0
        ),
    );
    let done = place
        .run_with(["apply", "sleeve.ron", path.to_str().unwrap(), "-o", "suit.obj", "--at", "0"], b"")
        .expect(0);
    let now = vertices(&place.read("suit.obj"));
    let moved: Vec<(DVec3, f64)> = rest.iter().zip(&now).map(|(p, q)| (*p, p.distance(*q))).collect();
    let top = moved.iter().map(|m| m.1).fold(0.0, f64::max);
    assert!(top > 0.3 * high && top < 1.05 * high, "{top} of {high}: {}", done.err());
    assert!(moved.iter().all(|(p, far_off)| *far_off == 0.0 || p.x > 0.3 * far), "the chest stays");
    assert!(now.len() > rest.len(), "it became finer");
}

/// What a run may change in a document: all that was there is equal but for what it appends to.
fn kept(old: &Document, new: &Document) {
    assert!(new.bin.as_ref().unwrap().starts_with(old.bin.as_ref().unwrap()), "the binary chunk is a prefix");
    for key in ["accessors", "bufferViews", "meshes", "skins", "materials", "textures", "images", "samplers"]
    {
        let count = list(&old.json, key).len();
        assert!(list(&new.json, key)[..count] == list(&old.json, key)[..], "{key}");
    }
    let changed: BTreeSet<String> = differences(&old.json, &new.json)
        .iter()
        .filter(|difference| difference.old.is_some())
        .map(|difference| difference.path.join("/"))
        .collect();
    let told = |path: &String| path.ends_with("/mesh") || path == "buffers/0/byteLength";
    assert!(changed.iter().all(told), "{changed:?}");
}

#[test]
fn a_walk_raises_creases_behind_the_knees() {
    let Some(path) = shared("rigged/cesium_man.glb") else { return };
    let place = Place::new();
    // Creases across the back of the left knee.
    place.write(
        "walk.ron",
        "Wrinkle(center: (0.1, 0.5, -0.1), direction: (1, 0, 0), size: (0.2, 0.25), creases: 4, thickness: 0.03, \
         intensity: 0.015, drive: Strain(from: 0.02, to: 0.15), refine: Auto)",
    );
    let input = path.to_str().unwrap();
    let told = place
        .run_with(["apply", "walk.ron", input, "-o", "out.glb", "--bake", "frames"], b"")
        .expect(0)
        .err();
    let [old, new] = [Document::open(&path), Document::open(&place.path("out.glb"))];
    kept(&old, &new);
    assert_eq!(list(&new.json, "animations")[0], list(&old.json, "animations")[0], "the walk is what it was");
    let clip = list(&new.json, "animations").len() - 1;
    assert_eq!(clip, 1, "{told}");
    let glb = place.read("out.glb");
    // The creases alone, in the pose of the rest.
    let frame = |t: f64| oracle::evaluate(&glb, Some("wirework"), t as f32).swap_remove(0).positions;
    let frames: Vec<Vec<DVec3>> = (0..=48).map(|k| frame(f64::from(k) / 24.0)).collect();
    let rest = oracle::evaluate(&glb, None, 0.0).swap_remove(0).positions;
    let height = |k: usize| frames[k].iter().zip(&rest).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
    let heights: Vec<f64> = (0..frames.len()).map(height).collect();
    let (low, high) =
        (heights.iter().copied().fold(1.0, f64::min), heights.iter().copied().fold(0.0, f64::max));
    eprintln!("a walk: creases from {low:.4} to {high:.4}; {told}");
    assert!(high > 0.003 && low < 0.6 * high, "they rise and sink: {heights:?}");
    let steps: Vec<f64> = heights.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    assert!(steps.iter().all(|s| *s < 0.6 * high), "smoothly: {steps:?}");
    let head = rest.iter().zip(&frames[12]).filter(|(p, _)| p.y > 1.0);
    assert!(head.map(|(p, q)| p.distance(*q)).fold(0.0, f64::max) < 1e-6, "the head stays");
}

#[test]
fn a_robot_keeps_its_clips_and_wears_its_wrinkles() {
    let Some(path) = shared("rigged/robot.glb") else { return };
    let place = Place::new();
    let input = path.to_str().unwrap();
    place.write(
        "dent.ron",
        "Wrinkle(units: Bounds, center: (0, 0, 0.2), direction: (1, 0, 0), size: (0.3, 0.2), creases: 3, thickness: 0.02, \
         intensity: 0.01, propagation: Keys([(0, 0), (1, 1)]), refine: Auto)",
    );
    let told = place
        .run_with(["apply", "dent.ron", input, "-o", "out.glb", "--into", "Robot_Walking"], b"")
        .expect(0)
        .err();
    let [old, new] = [Document::open(&path), Document::open(&place.path("out.glb"))];
    assert!(new.bin.as_ref().unwrap().starts_with(old.bin.as_ref().unwrap()));
    let names = |document: &Document| -> Vec<String> {
        list(&document.json, "animations").iter().map(|clip| clip["name"].to_string()).collect()
    };
    assert_eq!(names(&old), names(&new));
    assert_eq!(old.json["skins"], new.json["skins"]);
    // While it walks they ride on it: their height over the walk alone is what it is at rest.
    let bytes = [std::fs::read(&path).unwrap(), place.read("out.glb")];
    let clip =
        |document: &gltf::Document| document.animations().position(|a| a.name() == Some("Robot_Walking"));
    let offset = |t: f64| {
        let [a, b] = [&bytes[0], &bytes[1]].map(|glb| oracle::evaluate_clip(glb, clip, t, true));
        let pairs = a.iter().zip(&b).flat_map(|(a, b)| a.positions.iter().zip(&b.positions));
        pairs.map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
    };
    let size = oracle::diagonal(&oracle::evaluate(&bytes[0], None, 0.0));
    let (start, end) = (offset(0.0), offset(0.95));
    eprintln!("a robot of {size}: {start} to {end}; {told}");
    assert!(start < 1e-5 * size, "{start}");
    assert!(end > 0.0005 * size && end < 0.05 * size, "{end} of {size}");
}
