//! Real models: what an effect does not touch comes out as it went in, and what it moves moves.

use std::path::Path;

use wirework::asset::{Gltf, Limits, Obj};

use crate::oracle;
use crate::place::{Place, shared};

fn preset(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("presets").join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_character_waves_and_walks() {
    let Some(path) = shared("rigged/cesium_man.glb") else { return };
    let place = Place::new();
    let arm = preset("deform/arm.ron");
    place.run_with(["apply", &arm, path.to_str().unwrap(), "-o", "man.glb"], b"").expect(0);
    let before = Gltf::read(&path, &Limits::default()).unwrap();
    let after = Gltf::read(&place.path("man.glb"), &Limits::default()).unwrap();
    // The walk, the texture and the skin are what they were; the new clip stands behind.
    let (old, new) = (before.json(), after.json());
    for key in ["skins", "materials", "textures", "images", "samplers", "scenes", "asset"] {
        assert_eq!(old.get(key), new.get(key), "{key}");
    }
    assert_eq!(old["animations"][0], new["animations"][0]);
    assert_eq!(after.clip_names(), [None, Some("wirework")]);
    let count = old["accessors"].as_array().unwrap().len();
    assert_eq!(new["accessors"].as_array().unwrap()[..count], old["accessors"].as_array().unwrap()[..]);

    let glb = place.read("man.glb");
    let rest = before.rest().unwrap();
    for (seconds, moves) in [(0.0, false), (0.5, true), (2.0, false)] {
        let shown = oracle::evaluate(&glb, Some("wirework"), seconds);
        let [oracle::Shown { node: _, primitive: 0, positions, normals: Some(normals), .. }] =
            shown.as_slice()
        else {
            panic!("one primitive with normals")
        };
        assert_eq!((positions.len(), normals.len()), (rest.positions.len(), rest.positions.len()));
        let far = positions.iter().zip(&rest.positions).map(|(now, p)| {
            let p = glam::DVec3::from_array(p.map(f64::from));
            (now.distance(p), p)
        });
        let diagonal = oracle::diagonal(&shown);
        let (mut hand, mut legs) = (0.0_f64, 0.0_f64);
        for (distance, p) in far {
            if p.z > 0.4 {
                hand = hand.max(distance);
            }
            if p.y < 0.6 {
                legs = legs.max(distance);
            }
        }
        assert!(legs / diagonal < 1e-6, "at {seconds} s the legs move by {legs}");
        assert_eq!(hand > 0.2, moves, "at {seconds} s the hand moves by {hand}");
    }
}

#[test]
fn a_cow_keeps_its_text_and_its_seams() {
    let Some(path) = shared("body/spot.obj") else { return };
    let place = Place::new();
    let input = path.to_str().unwrap();
    place.write(
        "horn.ron",
        "Deform(wires: [Wire(curve: Polyline(points: [(0, 0.5, -0.8), (0, 0.9, -0.8)]), radius: 0.4,
            pose: Keys([(0, [(0, 0.5, -0.8), (0, 0.9, -0.8)]), (1, [(0, 0.5, -0.8), (0.2, 1.1, -0.8)])]))])",
    );
    place.run_with(["apply", "horn.ron", input, "-o", "rest.obj", "--at", "0"], b"").expect(0);
    assert!(place.read("rest.obj") == std::fs::read(&path).unwrap(), "at rest the text is what it was");
    place.run_with(["apply", "horn.ron", input, "-o", "still.obj", "--at", "1"], b"").expect(0);
    let (before, after) = (
        Obj::read(&path, &Limits::default()).unwrap(),
        Obj::read(&place.path("still.obj"), &Limits::default()).unwrap(),
    );
    assert_eq!(
        (before.mesh.corners.len(), before.mesh.uvs.len()),
        (after.mesh.corners.len(), after.mesh.uvs.len())
    );
    let moved = before.mesh.positions.iter().zip(&after.mesh.positions).filter(|(a, b)| a != b).count();
    assert!(moved > 100 && moved < before.mesh.positions.len() / 2, "{moved}");

    // As a GLB its vertices part at texture seams, and stay together.
    place.run_with(["apply", "horn.ron", input, "-o", "spot.glb"], b"").expect(0);
    let shown = &oracle::evaluate(&place.read("spot.glb"), Some("wirework"), 1.0)[0];
    assert!(shown.positions.len() > before.mesh.positions.len());
    let key = |p: &glam::DVec3| p.to_array().map(|c| (c * 1e5).round() as i64);
    let places: std::collections::BTreeSet<_> = shown.positions.iter().map(key).collect();
    let points: std::collections::BTreeSet<_> =
        after.mesh.positions.iter().map(|p| key(&glam::DVec3::from_array(p.map(f64::from)))).collect();
    assert!(places.len() <= points.len() + 16, "{} places of {} points", places.len(), points.len());
}

#[test]
fn one_preset_fits_many_kinds_of_files() {
    let place = Place::new();
    place.write(
        "any.ron",
        "Deform(wires: [Wire(curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 500, pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.2, 0), (1, 0.2, 0)])]))])",
    );
    for name in [
        "rigged/robot.glb",
        "rigged/fox.glb",
        "tube/skinned_cylinder.gltf",
        "tube/tube.obj",
        "garment/plane_30x30.obj",
        "morph/morph_stress_test.gltf",
        "multi/milk_truck.gltf",
        "layout/simple_sparse_accessor.gltf",
        "layout/box_interleaved.glb",
    ] {
        let Some(path) = shared(name) else { return };
        let input = path.to_str().unwrap();
        for out in ["out.glb", "out_####.obj"] {
            place.run_with(["apply", "any.ron", input, "-o", out, "--fps", "2"], b"").expect(0);
        }
        place.run_with(["apply", "any.ron", input, "-o", "still.glb", "--at", "1"], b"").expect(0);
        place.run_with(["inspect", "out.glb"], b"").expect(0);
        let counts = [place.path("out.glb"), place.path("still.glb"), path.clone()].map(|path| {
            let done = place.run_with(["inspect", path.to_str().unwrap(), "--json"], b"").expect(0);
            let facts: gltf::json::Value = gltf::json::deserialize::from_str(&done.out()).unwrap();
            (facts["triangles"].as_u64(), facts["animations"].as_array().unwrap().len())
        });
        assert_eq!(counts[0], (counts[2].0, counts[2].1 + 1), "{name}");
        assert_eq!(counts[1], counts[2], "{name}");
    }
    let Some(draco) = shared("rigged/fox_draco.glb") else { return };
    let err =
        place.run_with(["apply", "any.ron", draco.to_str().unwrap(), "-o", "no.glb"], b"").expect(3).err();
    assert!(err.contains("KHR_draco_mesh_compression") && err.contains("/extensionsRequired/0"), "{err}");
}
