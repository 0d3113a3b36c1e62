//! Finer copies of meshes: nothing of the input moves, and what is new lies between what was there.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde_json::{Value, json};
use wirework_asset::{Gltf, Limits, Refined, Rest};
use wirework_surface::{SubdivideLimits, Subdivision, subdivide_vertices};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;
use make::{Doc, skinned, triangle};

const ANY: SubdivideLimits = SubdivideLimits { vertices: 1 << 22, triangles: 1 << 23 };

/// Refines all of a document.
fn refined(gltf: &mut Gltf, longest: f32) -> (Rest, Subdivision, Refined) {
    let rest = gltf.rest().unwrap();
    let wanted = vec![longest; rest.positions.len()];
    let finer = subdivide_vertices(&rest.positions, &rest.triangles, &wanted, ANY).unwrap();
    let found = gltf.refine(&rest, &finer).unwrap();
    assert_eq!(found.vertex_of.len(), found.rest.positions.len());
    assert_eq!(found.rest.triangles.len(), finer.triangles.len());
    (rest, finer, found)
}

/// For each vertex of the subdivision where the refined rest has it.
fn places(rest: &Rest, finer: &Subdivision, found: &Refined) -> Vec<[f32; 3]> {
    let mut out = vec![[f32::NAN; 3]; rest.positions.len() + finer.parents.len()];
    for (p, &v) in found.rest.positions.iter().zip(&found.vertex_of) {
        out[v as usize] = *p;
    }
    out
}

fn vector(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

/// Everything that was there is there, where it was.
fn assert_kept(before: &Gltf, after: &Gltf) {
    let (old, new) = (before.json(), after.json());
    for (key, value) in old.as_object().unwrap() {
        match value {
            Value::Array(list) if key != "nodes" && key != "buffers" => {
                assert_eq!(new[key].as_array().unwrap()[..list.len()], list[..], "{key}");
            }
            Value::Array(list) if key == "nodes" => {
                for (a, b) in list.iter().zip(new[key].as_array().unwrap()) {
                    let mut b = b.clone();
                    if a.get("mesh").is_some() {
                        b["mesh"] = a["mesh"].clone();
                    }
                    assert_eq!(*a, b);
                }
            }
            Value::Array(_) => {}
            value => assert_eq!(&new[key], value, "{key}"),
        }
    }
    if old["buffers"].as_array().is_some_and(|list| list.iter().any(|buffer| buffer.get("uri").is_some())) {
        return;
    }
    let bin = |gltf: &Gltf| {
        gltf::Glb::from_slice(&gltf.to_glb().unwrap()).unwrap().bin.map(std::borrow::Cow::into_owned)
    };
    let (old, new) = (bin(before).unwrap_or_default(), bin(after).unwrap_or_default());
    assert!(new.starts_with(&old), "the old bytes are the first of the new ones");
}

/// The values of an attribute of the first primitive of a mesh, as another reader has them.
fn accessor<'a>(gltf: &'a Gltf, mesh: usize, pointer: &str) -> &'a Value {
    let primitive = &gltf.json()["meshes"][mesh]["primitives"][0];
    &gltf.json()["accessors"][primitive.pointer(pointer).unwrap().as_u64().unwrap() as usize]
}

fn bytes(gltf: &Gltf, accessor: &Value) -> Vec<u8> {
    let glb = gltf.to_glb().unwrap();
    let bin = gltf::Glb::from_slice(&glb).unwrap().bin.unwrap().into_owned();
    let view = &gltf.json()["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    bin[start..][..view["byteLength"].as_u64().unwrap() as usize].to_vec()
}

fn floats(gltf: &Gltf, accessor: &Value) -> Vec<f32> {
    bytes(gltf, accessor).as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)).collect()
}

#[test]
fn a_node_gets_a_finer_copy_and_all_else_stays() {
    let mut doc = triangle(json!({ "translation": [0, 0, 5] }));
    doc.node(json!({ "mesh": 0, "scale": [0.1, 0.1, -0.1] }));
    doc.json["meshes"][0]["name"] = json!("sheet");
    doc.json["meshes"][0]["extras"] = json!({ "mine": [1] });
    doc.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "EXT_mine": {}, "CESIUM_primitive_outline": { "indices": 0 } });
    let before = doc.open().unwrap();
    let mut gltf = before.clone();
    let (rest, finer, found) = refined(&mut gltf, 0.5);
    assert_kept(&before, &gltf);
    assert_eq!((rest.positions.len(), finer.parents.len()), (6, 6), "the small one is fine enough");
    let [mesh] = found.meshes.as_slice() else { panic!("{:?}", found.meshes) };
    assert_eq!(
        (mesh.mesh, mesh.copy, mesh.nodes.as_slice(), mesh.before, mesh.after),
        (0, 1, &[0][..], 3, 9)
    );
    assert_eq!(gltf.json()["nodes"][1]["mesh"], 0);
    let copy = &gltf.json()["meshes"][1];
    assert_eq!((&copy["name"], &copy["extras"]), (&json!("sheet"), &json!({ "mine": [1] })));
    assert_eq!(copy["primitives"][0]["extensions"], json!({ "EXT_mine": {} }));
    let position = accessor(&gltf, 1, "/attributes/POSITION");
    assert_eq!((&position["min"], &position["max"]), (&json!([0.0, 0.0, 0.0]), &json!([1.0, 1.0, 0.0])));
    assert!(found.rest.warnings == rest.warnings);
    let other = Gltf::from_slice(&gltf.to_glb().unwrap(), "again", &Limits::default()).unwrap();
    assert_eq!(other.rest().unwrap().positions, found.rest.positions);
}

#[test]
fn nodes_that_need_the_same_share_a_copy() {
    let mut doc = triangle(json!({}));
    doc.node(json!({ "mesh": 0, "translation": [7, 0, 0] }));
    doc.node(json!({ "mesh": 0, "scale": [2, 2, -2] }));
    let mut gltf = doc.open().unwrap();
    let (.., found) = refined(&mut gltf, 0.6);
    let nodes: Vec<&[usize]> = found.meshes.iter().map(|mesh| mesh.nodes.as_slice()).collect();
    assert_eq!(nodes, [&[0, 1][..], &[2]]);
    // A mirrored one is turned as the mesh has it: outwards in the world.
    for triangle in &found.rest.triangles[found.rest.parts[2].first_triangle..] {
        let [a, b, c] = triangle.map(|v| vector(found.rest.positions[v as usize]));
        assert!((b - a).cross(c - a).z < 0.0);
    }
}

#[test]
fn strips_and_fans_become_lists_and_lines_stay() {
    for (mode, indices, triangles) in [
        (5, Some(vec![0_u8, 1, 2, 3]), 2),
        (6, None, 2),
        (4, Some(vec![0, 1, 2, 2, 1, 3]), 2),
        (1, None, 0),
        (0, None, 0),
    ] {
        let mut doc = Doc::new();
        let square = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 2.0, 2.0, 0.0];
        let mut primitive =
            json!({ "attributes": { "POSITION": doc.floats("VEC3", &square) }, "mode": mode });
        if let Some(indices) = indices {
            let accessor = json!({ "componentType": 5121, "type": "SCALAR", "count": indices.len() });
            primitive["indices"] = json!(doc.accessor(accessor, &indices));
        }
        let mesh = doc.mesh(&primitive);
        doc.node(json!({ "mesh": mesh }));
        let before = doc.open().unwrap();
        let mut gltf = before.clone();
        let (rest, finer, found) = refined(&mut gltf, 1.0);
        assert_eq!(rest.triangles.len(), triangles, "{mode}");
        if triangles == 0 {
            assert_eq!(gltf.json(), before.json(), "{mode}");
            continue;
        }
        assert!(finer.triangles.len() >= 16 && found.meshes.len() == 1);
        assert_eq!(gltf.json()["meshes"][1]["primitives"][0].get("mode"), None);
        let area = |rest: &Rest| -> f64 {
            let at = |v: u32| vector(rest.positions[v as usize]);
            rest.triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).z * 0.5).sum()
        };
        assert!((area(&found.rest) - area(&rest)).abs() < 1e-9, "{mode}");
    }
}

#[test]
fn attributes_are_halved_in_types_that_hold_them() {
    let mut doc = triangle(json!({}));
    let uvs = doc.accessor(
        json!({ "componentType": 5123, "type": "VEC2", "count": 3, "normalized": true }),
        &[0, 0, 0, 0, 255, 255, 0, 0, 0, 0, 255, 255],
    );
    let tangents = doc.floats("VEC4", &[1.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0, -1.0, 0.0, 0.0, -1.0]);
    let colors = doc.accessor(
        json!({ "componentType": 5121, "type": "VEC4", "count": 3, "normalized": true }),
        &[0, 51, 255, 255, 255, 51, 0, 0, 0, 0, 0, 255],
    );
    let own = doc.accessor(
        json!({ "componentType": 5120, "type": "VEC3", "count": 3 }),
        &[1, 2, 0xff, 0, 4, 4, 0xfc, 0, 100, 0, 0, 0],
    );
    doc.json["bufferViews"][3 + 2]["byteStride"] = json!(4);
    let plain = doc.floats("SCALAR", &[0.5, 1.0, 3.0]);
    let deltas = doc.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    let attributes = &mut primitive["attributes"];
    for (name, index) in
        [("TEXCOORD_0", uvs), ("TANGENT", tangents), ("COLOR_0", colors), ("_OWN", own), ("_PLAIN", plain)]
    {
        attributes[name] = json!(index);
    }
    primitive["targets"] = json!([{ "POSITION": deltas }]);
    doc.json["meshes"][0]["weights"] = json!([0.25]);
    doc.json["meshes"][0]["extras"] = json!({ "targetNames": ["up"] });
    let before = doc.open().unwrap();
    let mut gltf = before.clone();
    // The longest edge only: the second vertex is lifted a quarter.
    let (rest, finer, found) = refined(&mut gltf, 1.1);
    assert_eq!(finer.parents.len(), 1, "{finer:?}");
    assert_kept(&before, &gltf);
    let [a, b] = finer.parents[0];
    assert_eq!([a, b], [1, 2]);
    let read = |name: &str| floats(&gltf, accessor(&gltf, 1, &format!("/attributes/{name}")));
    assert_eq!(read("POSITION")[9..], [0.5, 0.5, 0.0]);
    assert_eq!(read("NORMAL")[9..], [0.0, 0.0, 1.0]);
    assert_eq!(read("TEXCOORD_0")[6..], [0.5, 0.5]);
    assert_eq!(read("COLOR_0")[12..], [0.5, 0.1, 0.0, 0.5]);
    assert_eq!(read("_PLAIN"), [0.5, 1.0, 3.0, 2.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_eq!(read("TANGENT")[12..], [-half, half, 0.0, -1.0]);
    let own = accessor(&gltf, 1, "/attributes/_OWN");
    assert_eq!((&own["componentType"], own.get("normalized")), (&json!(5120), None));
    assert_eq!(bytes(&gltf, own)[12..], [52, 2, 0xfe, 0], "52, 2, −2, and a gap");
    assert_eq!(gltf.json()["meshes"][1]["extras"]["targetNames"], json!(["up"]));
    assert_eq!(gltf.target_count(1), 1);
    assert_eq!(places(&rest, &finer, &found)[3], [0.5, 0.5, 0.125]);
}

#[test]
fn quantised_positions_become_floats_of_the_same_value() {
    let mut doc = Doc::new();
    doc.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let positions = doc.accessor(
        json!({ "componentType": 5122, "type": "VEC3", "count": 3, "normalized": true, "min": [0, 0, 0], "max": [3, 7, 0] }),
        &[0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0x7f, 0, 0, 0, 0, 0, 0, 1, 0, 0x33, 3, 0, 0, 0, 0],
    );
    doc.json["bufferViews"][0]["byteStride"] = json!(8);
    let mesh = doc.mesh(&json!({ "attributes": { "POSITION": positions } }));
    doc.node(json!({ "mesh": mesh, "scale": [3, 3, 3] }));
    let mut gltf = doc.open().unwrap();
    let (rest, finer, found) = refined(&mut gltf, 0.7);
    let now = places(&rest, &finer, &found);
    assert_eq!(now[..3], rest.positions);
    assert!(finer.parents.len() >= 4);
    assert_eq!(accessor(&gltf, 1, "/attributes/POSITION")["componentType"], 5126);
}

#[test]
fn weights_are_those_of_both_ends_and_add_up() {
    // Joints 0 and 1; the second is turned about z, so that the ends go different ways.
    for (turn, weights) in
        [(0.0_f64, [0.5, 0.5, 0.0, 0.0]), (0.6, [1.0, 0.0, 0.0, 0.0]), (3.1, [0.25, 0.75, 0.0, 0.0])]
    {
        let mut doc = skinned(weights);
        doc.json["nodes"][2]["rotation"] = json!([0.0, 0.0, (turn / 2.0).sin(), (turn / 2.0).cos()]);
        let before = doc.open().unwrap();
        let mut gltf = before.clone();
        let (rest, finer, found) = refined(&mut gltf, 0.9);
        assert_kept(&before, &gltf);
        let now = places(&rest, &finer, &found);
        assert_eq!(now[..3], rest.positions, "old vertices keep their bits");
        for (k, &[a, b]) in finer.parents.iter().enumerate() {
            let [a, b, middle] = [a as usize, b as usize, 3 + k].map(|v| vector(now[v]));
            let off = middle.distance((a + b) * 0.5);
            let allowed = if turn > 1.0 { 0.5 * a.distance(b) } else { 2e-6 * (1.0 + middle.length()) };
            assert!(off <= allowed, "{off} off the chord at {turn}");
        }
        let weights = floats(&gltf, accessor(&gltf, 1, "/attributes/WEIGHTS_0"));
        for vertex in weights.chunks(4) {
            assert!((vertex.iter().map(|&w| f64::from(w)).sum::<f64>() - 1.0).abs() < 2e-7, "{vertex:?}");
        }
        assert_eq!(accessor(&gltf, 1, "/attributes/JOINTS_0")["componentType"], 5121);
    }
}

#[test]
fn the_largest_influences_are_kept() {
    let mut doc = triangle(json!({ "skin": 0 }));
    let joints: Vec<usize> = (0..8).map(|k| doc.node(json!({ "translation": [0, k, 0] }))).collect();
    doc.json["skins"] = json!([{ "joints": joints }]);
    let all = [0, 1, 2, 3, 4, 5, 6, 7, 0, 0, 0, 0];
    let indices = doc.accessor(
        json!({ "componentType": 5123, "type": "VEC4", "count": 3 }),
        &all.map(u16::to_le_bytes).concat(),
    );
    let weights = doc.floats("VEC4", &[0.4, 0.3, 0.2, 0.1, 0.1, 0.2, 0.3, 0.4, 1.0, 0.0, 0.0, 0.0]);
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(indices);
    attributes["WEIGHTS_0"] = json!(weights);
    let mut gltf = doc.open().unwrap();
    let (_, finer, _) = refined(&mut gltf, 0.99);
    let at = 3 + finer.parents.iter().position(|parents| *parents == [0, 1]).unwrap();
    let weights = floats(&gltf, accessor(&gltf, 1, "/attributes/WEIGHTS_0"));
    let joints = bytes(&gltf, accessor(&gltf, 1, "/attributes/JOINTS_0"));
    assert_eq!(joints[8 * at..8 * at + 8], [0, 0, 7, 0, 1, 0, 6, 0]);
    let expected = [0.4, 0.4, 0.3, 0.3].map(|w: f32| w / 1.4);
    for (found, expected) in weights[4 * at..4 * at + 4].iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6);
    }
}

#[test]
fn what_the_limits_forbid_is_refused() {
    let mut doc = triangle(json!({}));
    doc.node(json!({ "mesh": 0 }));
    let limits = Limits { vertices: 20, ..Limits::default() };
    let mut gltf = Gltf::from_slice(&doc.glb(), "small", &limits).unwrap();
    let rest = gltf.rest().unwrap();
    let finer = subdivide_vertices(&rest.positions, &rest.triangles, &[0.2; 6], ANY).unwrap();
    let error = gltf.refine(&rest, &finer).unwrap_err();
    assert_eq!(error.class, wirework_asset::ErrorClass::Limit, "{error}");
    // One of something else.
    let mut gltf = doc.open().unwrap();
    let odd = Subdivision { parents: vec![[0, 5]], triangles: vec![[0, 1, 6]; 9], ..finer };
    assert!(gltf.refine(&rest, &odd).is_err());
}

fn shared() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    path.exists().then_some(path)
}

/// Refines a real file to a fortieth of its size and plays it.
fn real(path: &Path, parts: f32) -> usize {
    let name = path.display().to_string();
    let before = Gltf::read(path, &Limits::default()).unwrap();
    let mut gltf = before.clone();
    let size = {
        let rest = before.rest().unwrap();
        let bounds = wirework_surface::Bounds::of(&rest.positions).unwrap();
        (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f32::max)
    };
    let (rest, finer, found) = refined(&mut gltf, size / parts);
    assert_kept(&before, &gltf);
    let now = places(&rest, &finer, &found);
    assert_eq!(now[..rest.positions.len()], rest.positions[..], "{name}");
    let (mut off, mut worst) = (0, 0.0_f64);
    for (k, &[a, b]) in finer.parents.iter().enumerate() {
        let [a, b, middle] = [a as usize, b as usize, rest.positions.len() + k].map(|v| vector(now[v]));
        let far = middle.distance((a + b) * 0.5);
        worst = worst.max(far / f64::from(size));
        off += usize::from(far > 2e-6 * f64::from(size).max(middle.length()));
    }
    assert!(
        off * 500 <= finer.parents.len(),
        "{name}: {off} of {} off the chord, by {worst}",
        finer.parents.len()
    );
    // Another reader sees the same, and old vertices play as they did.
    let clips = before.clip_names().len();
    for clip in (0..clips).map(Some).chain([None]).take(2) {
        let old = oracle::evaluate_clip(&before.to_glb().unwrap(), |_| clip, 0.4, true);
        let new = oracle::evaluate_clip(&gltf.to_glb().unwrap(), |_| clip, 0.4, true);
        assert_eq!(old.len(), new.len());
        for (a, b) in old.iter().zip(&new) {
            assert!(b.positions.len() >= a.positions.len());
            for (p, q) in a.positions.iter().zip(&b.positions) {
                assert!(p.distance(*q) <= 1e-6 * f64::from(size), "{name}: {p} {q}");
            }
        }
    }
    finer.parents.len()
}

#[test]
fn real_files_are_refined_without_a_loss() {
    let Some(shared) = shared() else { return };
    for (file, parts) in [
        ("rigged/cesium_man.glb", 60.0),
        ("rigged/robot.glb", 60.0),
        ("rigged/fox.glb", 60.0),
        ("tube/skinned_cylinder.gltf", 40.0),
        ("morph/morph_stress_test.gltf", 40.0),
        ("multi/milk_truck.gltf", 60.0),
        ("multi/texture_transform_test.gltf", 30.0),
        ("layout/box_interleaved.glb", 10.0),
        ("layout/box_vertex_colors.glb", 10.0),
    ] {
        assert!(real(&shared.join(file), parts) > 0, "{file}");
    }
}

/// Between ends that hang on the same joints, a new vertex plays in the middle of them.
#[test]
fn new_vertices_follow_a_clip_between_their_parents() {
    let Some(shared) = shared() else { return };
    let before = Gltf::read(&shared.join("rigged/cesium_man.glb"), &Limits::default()).unwrap();
    let mut gltf = before.clone();
    let (rest, finer, found) = refined(&mut gltf, 0.03);
    let clip = Some(0).filter(|_| !before.clip_names().is_empty());
    let mut player = gltf.player(&found.rest, clip).unwrap();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    player.pose_into(0.7, None, &mut positions, &mut normals).unwrap();
    let mut now = vec![DVec3::NAN; rest.positions.len() + finer.parents.len()];
    for (p, &v) in positions.iter().zip(&found.vertex_of) {
        now[v as usize] = vector(*p);
    }
    // What each vertex hangs on.
    let mut hangs = vec![Vec::new(); now.len()];
    for joint in gltf.joint_nodes() {
        let weights = gltf.joint_weights(&found.rest, &[joint]).unwrap().of_vertices;
        for (&v, weight) in found.vertex_of.iter().zip(weights) {
            hangs[v as usize].push(weight);
        }
    }
    let mut alike = 0;
    for (k, &[a, b]) in finer.parents.iter().enumerate() {
        let [a, b, new] = [a as usize, b as usize, rest.positions.len() + k];
        let same = hangs[a].iter().zip(&hangs[b]).all(|(v, w)| (v - w).abs() < 1e-6);
        let off = now[new].distance((now[a] + now[b]) * 0.5);
        assert!(!same || off < 4e-6, "{off} off the chord");
        assert!(off < 0.75 * now[a].distance(now[b]));
        alike += usize::from(same);
    }
    assert!(alike > 50, "{alike} of {}", finer.parents.len());
}

#[test]
fn hostile_files_are_refined_or_refused() {
    let Some(folder) = shared().map(|assets| assets.join("../hostile")).filter(|folder| folder.exists())
    else {
        return;
    };
    let limits = Limits { expanded_bytes: 64 << 20, vertices: 200_000, ..Limits::default() };
    let mut folders = vec![folder];
    let (mut done, mut refused) = (0, 0);
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let Ok(mut gltf) = Gltf::read(&path, &limits) else { continue };
            let Ok(rest) = gltf.rest() else { continue };
            let size = rest.positions.as_flattened().iter().fold(1e-3_f32, |a, c| a.max(c.abs()));
            let wanted = vec![size / 8.0; rest.positions.len()];
            let limits = SubdivideLimits { vertices: 100_000, triangles: 200_000 };
            let Ok(finer) = subdivide_vertices(&rest.positions, &rest.triangles, &wanted, limits) else {
                refused += 1;
                continue;
            };
            match gltf.refine(&rest, &finer) {
                Ok(found) => done += usize::from(found.vertex_of.len() >= rest.positions.len()),
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(done > 20, "{done} refined, {refused} refused");
}
