//! One document behind another shows what both showed, and plays what both played.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};
use wirework_asset::{Format, Gltf, Limits, write_files};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;

use make::{Doc, skinned, triangle};
use play::{strip, track};

/// A strip whose second joint turns, and whose clip has a name.
fn playing(name: &str, turn: f32) -> Doc {
    let mut doc = strip();
    let half = (turn / 2.0).sin_cos();
    track(&mut doc, 2, "rotation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half.0, half.1]);
    doc.json["animations"][0]["name"] = json!(name);
    doc
}

fn positions(glb: &[u8], clip: Option<usize>, seconds: f64) -> Vec<DVec3> {
    let shown = oracle::evaluate_clip(glb, |_| clip, seconds, true);
    shown.into_iter().flat_map(|part| part.positions).collect()
}

/// Vertices wherever they stand in a list: the order of roots is not that of files.
fn sorted(mut list: Vec<DVec3>) -> Vec<DVec3> {
    list.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
    list
}

fn reread(gltf: &Gltf) -> Gltf {
    let again = Gltf::from_slice(&gltf.to_glb().unwrap(), "merged.glb", &Limits::default()).unwrap();
    assert_eq!(again.warnings(), []);
    again
}

#[test]
fn both_are_shown_and_played() {
    for (a, b) in [
        (playing("one", 0.8), playing("two", -0.5)),
        (triangle(json!({ "translation": [0, 2, 0] })), playing("two", 0.3)),
        (playing("one", 0.3), skinned([0.5, 0.5, 0.0, 0.0])),
    ] {
        let [a, b] = [a, b].map(|mut doc| {
            // The other reader shows no document without a scene.
            let roots: &[usize] =
                if doc.json["nodes"].as_array().unwrap().len() > 1 { &[0, 1] } else { &[0] };
            doc.json["scenes"] = json!([{ "nodes": roots }]);
            doc
        });
        let (first, second) = (a.glb(), b.glb());
        let mut gltf = a.open().unwrap();
        let before = gltf.json().clone();
        gltf.merge(b.open().unwrap(), "other").unwrap();
        for key in ["nodes", "meshes", "accessors", "bufferViews"] {
            let old = before[key].as_array().unwrap();
            assert_eq!(&gltf.json()[key].as_array().unwrap()[..old.len()], old, "{key} do not move");
        }
        let merged = reread(&gltf).to_glb().unwrap();
        let rest = [positions(&first, None, 0.0), positions(&second, None, 0.0)].concat();
        assert!(sorted(positions(&merged, None, 0.0)) == sorted(rest), "the rest of both");
        let clips = |doc: &Doc| doc.json.get("animations").map_or(0, |list| list.as_array().unwrap().len());
        for clip in 0..clips(&a) + clips(&b) {
            let own = clip.checked_sub(clips(&a));
            let expected =
                [positions(&first, own.is_none().then_some(clip), 0.7), positions(&second, own, 0.7)]
                    .concat();
            assert!(sorted(positions(&merged, Some(clip), 0.7)) == sorted(expected), "clip {clip}");
        }
    }
}

#[test]
fn the_roots_get_a_node_of_the_name_and_skinned_meshes_stay_roots() {
    let mut gltf = triangle(json!({})).open().unwrap();
    let roots = gltf.merge(strip().open().unwrap(), "sleeve").unwrap();
    assert_eq!(roots, [4, 1]);
    assert_eq!(gltf.json()["nodes"][4], json!({ "name": "sleeve", "children": [2] }));
    assert_eq!(gltf.json()["skins"][0]["joints"], json!([2, 3]));
    assert_eq!(gltf.json()["scenes"], json!([{ "nodes": [0, 4, 1] }]));
    assert_eq!(gltf.json()["scene"], 0);
    // A single root that has the name is the node.
    let roots = gltf.merge(triangle(json!({ "name": "back" })).open().unwrap(), "back").unwrap();
    assert_eq!((roots, gltf.node_count()), (vec![5], 6));
    assert_eq!(gltf.json()["scenes"], json!([{ "nodes": [0, 4, 1, 5] }]));
    assert_eq!(reread(&gltf).rest().unwrap().positions.len(), 3 + 6 + 3);
}

#[test]
fn a_scene_that_is_shown_takes_it_and_others_are_left() {
    let mut own = triangle(json!({}));
    own.json["scenes"] = json!([{}, { "nodes": [0] }]);
    own.json["scene"] = json!(1);
    let mut other = triangle(json!({}));
    other.node(json!({ "mesh": 0, "translation": [0, 0, 3] }));
    other.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [0] }]);
    let mut gltf = own.open().unwrap();
    gltf.merge(other.open().unwrap(), "one").unwrap();
    assert_eq!(gltf.json()["scenes"], json!([{}, { "nodes": [0, 3] }]));
    assert_eq!(gltf.json()["nodes"][3]["children"], json!([2]));
    assert!(gltf.warnings().iter().any(|warning| warning.code == "merged-scenes"));
    assert_eq!(reread(&gltf).rest().unwrap().positions.len(), 6);
}

/// A document with each extension that refers to something.
fn extended(unknown: bool) -> Doc {
    let mut doc = triangle(json!({ "extensions": {
        "KHR_lights_punctual": { "light": 0 }, "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } },
    } }));
    let json = &mut doc.json;
    json["extensions"] = json!({
        "KHR_lights_punctual": { "lights": [{ "type": "point" }] },
        "KHR_materials_variants": { "variants": [{ "name": "red" }, { "name": "blue" }] },
    });
    json["images"] = json!([{ "uri": "data:image/png;base64,iVBORw0KGgo=" }]);
    json["textures"] = json!([{ "source": 0, "extensions": { "KHR_texture_basisu": { "source": 0 } } }]);
    json["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 } },
        "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatTexture": { "index": 0 } } },
    }]);
    json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [{ "material": 0, "variants": [1] }] } });
    json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_variants"]);
    if unknown {
        json["nodes"][0]["extensions"]["ACME_links"] = json!({ "to": 0, "weight": 0.5 });
        json["extensions"]["ACME_links"] = json!({ "root": 0 });
    }
    doc
}

#[test]
fn what_extensions_refer_to_moves_along() {
    let mut gltf = extended(false).open().unwrap();
    let mut other = extended(true);
    let time = other.floats("SCALAR", &[0.0, 1.0]);
    other.json["animations"] = json!([{
        "samplers": [{ "input": time, "output": time }],
        "channels": [{ "sampler": 0, "target": { "path": "pointer", "extensions": {
            "KHR_animation_pointer": { "pointer": "/extensions/KHR_lights_punctual/lights/0/intensity" } } } }],
    }]);
    other.json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_lights_punctual"]);
    let extended = other.open().unwrap();
    gltf.merge(extended, "other").unwrap();
    let json = gltf.json();
    let at = |pointer: &str| json.pointer(pointer).unwrap_or_else(|| panic!("{pointer}")).clone();
    for (pointer, expected) in [
        ("/nodes/1/extensions/KHR_lights_punctual/light", json!(1)),
        ("/nodes/1/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION", json!(2)),
        ("/nodes/1/extensions/ACME_links/to", json!(0)),
        ("/extensions/ACME_links", json!({ "root": 0 })),
        ("/extensions/KHR_lights_punctual/lights", json!([{ "type": "point" }, { "type": "point" }])),
        ("/textures/1/extensions/KHR_texture_basisu/source", json!(1)),
        ("/materials/1/pbrMetallicRoughness/baseColorTexture", json!({ "index": 1, "texCoord": 1 })),
        ("/materials/1/extensions/KHR_materials_clearcoat/clearcoatTexture/index", json!(1)),
        ("/materials/1/extensions/KHR_materials_clearcoat/clearcoatFactor", json!(1)),
        (
            "/meshes/1/primitives/0/extensions/KHR_materials_variants/mappings",
            json!([{ "material": 1, "variants": [3] }]),
        ),
        ("/animations/0/samplers/0", json!({ "input": 4, "output": 4 })),
        (
            "/animations/0/channels/0/target/extensions/KHR_animation_pointer/pointer",
            json!("/extensions/KHR_lights_punctual/lights/1/intensity"),
        ),
        (
            "/extensionsUsed",
            json!(["KHR_lights_punctual", "KHR_materials_variants", "KHR_materials_clearcoat"]),
        ),
        // Data in a URI is data in the document.
        ("/images/1/bufferView", json!(json["bufferViews"].as_array().unwrap().len() - 1)),
    ] {
        assert_eq!(at(pointer), expected, "{pointer}");
    }
    let told: Vec<_> = gltf.warnings().iter().filter(|w| w.code == "merged-extension").collect();
    assert!(told.len() == 1 && told[0].message.contains("ACME_links"), "{told:?}");
}

#[test]
fn files_of_another_folder_are_taken_in() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let document = |name: &str, image: &[u8]| {
        let mut doc = triangle(json!({}));
        doc.json["buffers"] = json!([{ "byteLength": doc.bin.len(), "uri": "data.bin" }]);
        doc.json["images"] = json!([{ "uri": "image.png" }, { "uri": "strange" }, { "uri": "missing.png" }]);
        write(&format!("{name}/data.bin"), &doc.bin);
        write(&format!("{name}/image.png"), image);
        write(&format!("{name}/strange"), b"odd");
        let path = write(&format!("{name}/doc.gltf"), &serde_json::to_vec(&doc.json).unwrap());
        Gltf::read(&path, &Limits::default()).unwrap()
    };
    let [one, two] = [b"\x89PNG one", b"\x89PNG two"];
    let mut gltf = document("a", one);
    gltf.merge(document("b", two), "b").unwrap();
    for out in ["out/merged.gltf", "out.glb"].map(|name| folder.path().join(name)) {
        std::fs::create_dir_all(out.parent().unwrap()).unwrap();
        write_files(&gltf.files(&out, Format::of(&out).unwrap()).unwrap()).unwrap();
        let again = Gltf::read(&out, &Limits::default()).unwrap();
        let image = |index| again.image(index).unwrap().bytes.into_owned();
        assert_eq!((image(0), image(3), image(4)), (one.to_vec(), two.to_vec(), b"odd".to_vec()));
        assert_eq!(again.rest().unwrap().positions.len(), 6);
    }
}

fn found(folder: &Path, out: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found(&path, out) } else { out.push(path) }
    }
    out.sort();
}

#[test]
fn real_files_are_merged_two_by_two() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    let mut list = Vec::new();
    found(&assets, &mut list);
    list.retain(|path| path.extension().is_some_and(|e| e == "glb" || e == "gltf"));
    list.retain(|path| path.metadata().unwrap().len() < 4 << 20);
    let mut before: Option<(Gltf, Vec<[f32; 3]>)> = None;
    for path in list {
        let Ok(gltf) = Gltf::read(&path, &Limits::default()) else { continue };
        let Ok(rest) = gltf.rest() else { continue };
        if let Some((mut first, own)) = before.take() {
            let (kept, before) = (first.clone(), first.warnings().len() + gltf.warnings().len());
            first.merge(gltf.clone(), "other").unwrap();
            let again = Gltf::from_slice(&first.to_glb().unwrap(), "merged.glb", &Limits::default()).unwrap();
            let all = again.rest().unwrap().positions;
            assert!(all.len() == own.len() + rest.positions.len(), "{}", path.display());
            assert!(
                sorted_bits(&all) == sorted_bits(&[own, rest.positions.clone()].concat()),
                "{}",
                path.display()
            );
            assert!(again.warnings().len() <= before, "{}: {:?}", path.display(), again.warnings());
            let old = kept.json()["nodes"].as_array().unwrap();
            assert!(first.json()["nodes"].as_array().unwrap()[..old.len()] == old[..]);
        }
        before = Some((gltf, rest.positions));
    }
}

fn sorted_bits(list: &[[f32; 3]]) -> Vec<[u32; 3]> {
    let mut out: Vec<_> = list.iter().map(|p| p.map(f32::to_bits)).collect();
    out.sort_unstable();
    out
}

#[test]
fn what_is_malformed_is_refused_in_its_own_name() {
    let mut bad = triangle(json!({}));
    bad.node(json!({ "children": [9] }));
    let mut gltf = triangle(json!({})).open().unwrap();
    let error = gltf.merge(bad.open().unwrap(), "bad").unwrap_err();
    assert!(error.to_string().starts_with("made.glb: /nodes/1/children/0"), "{error}");
    let mut child = triangle(json!({}));
    child.node(json!({ "children": [0] }));
    child.json["scenes"] = json!([{ "nodes": [0] }]);
    assert!(gltf.merge(child.open().unwrap(), "child").is_err());
    assert_eq!(gltf.json()["nodes"], Value::from(vec![json!({ "mesh": 0 })]));
}
