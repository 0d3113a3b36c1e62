//! Faults in what nobody reads are told, each once and at its place; documents without any are told nothing.

use std::path::Path;

use serde_json::{Value, json};
use wirework_asset::{Gltf, Limits, Place};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, skinned, triangle};

/// A document with an entry in every table, most of them in nothing that its scene shows.
fn full() -> Doc {
    let mut doc = skinned([0.75, 0.25, 0.0, 0.0]);
    doc.json["accessors"][0]["min"] = json!([0, 0, 0]);
    doc.json["accessors"][0]["max"] = json!([1, 1, 0]);
    let times = doc.floats("SCALAR", &[0.0, 1.0]);
    let turns = doc.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let (at, values) = (doc.view(&[1]), doc.view(&7.0_f32.to_le_bytes().repeat(3)));
    let spare = doc.floats("VEC3", &[0.0; 9]);
    doc.json["accessors"][spare]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": values },
    });
    let delta = json!({ "POSITION": spare });
    doc.mesh(&json!({ "attributes": { "POSITION": spare, "_ROUGH": times }, "targets": [delta], "mode": 0 }));
    doc.node(json!({ "camera": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }));
    let info = json!({ "index": 0, "texCoord": 0 });
    for (key, value) in [
        ("scene", json!(0)),
        ("scenes", json!([{ "nodes": [0, 1] }, { "name": "other", "nodes": [3] }])),
        (
            "images",
            json!([{ "uri": "data:image/png;base64,AQID" }, { "bufferView": at, "mimeType": "image/png" }]),
        ),
        ("samplers", json!([{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071 }])),
        ("textures", json!([{ "source": 0, "sampler": 0 }, {}])),
        (
            "materials",
            json!([{
                "pbrMetallicRoughness": {
                    "baseColorFactor": [1, 1, 1, 1], "baseColorTexture": info, "metallicFactor": 0.5,
                },
                "normalTexture": { "index": 1, "scale": 2 }, "occlusionTexture": { "index": 1, "strength": 1 },
                "emissiveFactor": [0, 0, 0], "alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": true,
            }]),
        ),
        (
            "animations",
            json!([{
                "samplers": [{ "input": times, "output": turns, "interpolation": "STEP" }],
                "channels": [{ "sampler": 0, "target": { "node": 1, "path": "rotation" } }],
            }]),
        ),
        (
            "cameras",
            json!([
                { "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } },
                { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 2, "znear": 1 } },
            ]),
        ),
    ] {
        doc.json[key] = value;
    }
    doc
}

/// Codes and places of what is told of a document and of its rest.
fn told(doc: &Doc) -> Vec<(&'static str, String)> {
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let place = |place: &Place| match place {
        Place::Pointer(pointer) => pointer.clone(),
        _ => String::new(),
    };
    let all = gltf.warnings().iter().chain(&rest.warnings).filter(|warning| warning.code != "bounds");
    all.map(|warning| (warning.code, place(&warning.place))).collect()
}

/// Sets the value at a pointer; nothing takes it away.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (above, key) = pointer.rsplit_once('/').unwrap();
    match json.pointer_mut(above).unwrap() {
        Value::Object(object) if value == json!("gone") => drop(object.shift_remove(key)),
        Value::Object(object) => drop(object.insert(key.to_owned(), value)),
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{pointer}"),
    }
}

#[test]
fn a_document_as_it_should_be_is_told_nothing() {
    assert_eq!(told(&full()), []);
}

#[test]
fn what_nobody_reads_is_told_once_and_comes_out_as_it_is() {
    let gone = json!("gone");
    // Accessor 7 is that of the mesh that no node shows.
    assert_eq!(full().json["accessors"].as_array().unwrap().len(), 8);
    for (pointer, value, code, place) in [
        // Another type than the standard's.
        ("/animations/0/channels/0", json!("turn"), "value", None),
        ("/animations/0/channels", json!({}), "value", None),
        ("/animations/0/name", json!(7), "value", None),
        ("/animations/0/samplers/0/interpolation", json!("SMOOTH"), "value", None),
        ("/animations/0/channels/0/target/path", json!("rotate"), "value", None),
        ("/cameras/0/perspective/yfov", json!("wide"), "value", None),
        ("/cameras/0/type", json!(1), "value", None),
        ("/cameras", json!({}), "value", None),
        ("/materials/0", json!(null), "value", None),
        ("/materials/0/emissiveFactor", json!([1, 1]), "value", None),
        ("/materials/0/emissiveFactor/1", json!(null), "value", None),
        ("/materials/0/alphaMode", json!("HALF"), "value", None),
        ("/materials/0/doubleSided", json!(1), "value", None),
        ("/materials/0/extensions", json!([]), "value", None),
        ("/meshes/1/primitives/0/mode", json!(7), "value", None),
        ("/meshes/1/primitives/0/targets", json!([[]]), "value", Some("/meshes/1/primitives/0/targets/0")),
        ("/meshes/0/name", json!(null), "value", None),
        ("/images/0/uri", json!(3), "value", None),
        ("/samplers/0/wrapS", json!(1), "value", None),
        ("/samplers/0/magFilter", json!("linear"), "value", None),
        ("/scenes/1/nodes/0", json!(-1), "value", None),
        ("/textures/1", json!([]), "value", None),
        ("/nodes/3/name", json!({}), "value", None),
        ("/skins/0/name", json!(0), "value", None),
        ("/asset/generator", json!(1), "value", None),
        ("/extensionsUsed", json!([1]), "value", Some("/extensionsUsed/0")),
        // Names by number of what is not there.
        ("/animations/0/channels/0/sampler", json!(1), "index", None),
        ("/animations/0/channels/0/target/node", json!(4), "index", None),
        ("/animations/0/samplers/0/output", json!(99), "index", None),
        ("/materials/0/normalTexture/index", json!(2), "index", None),
        ("/textures/0/sampler", json!(1), "index", None),
        ("/textures/0/source", json!(2), "index", None),
        ("/scenes/1/nodes/0", json!(4), "index", None),
        ("/nodes/3/camera", json!(2), "index", None),
        ("/skins/0/skeleton", json!(4), "index", None),
        ("/meshes/1/primitives/0/attributes/_ROUGH", json!(8), "index", None),
        ("/meshes/1/primitives/0/targets/0/POSITION", json!(8), "index", None),
        ("/meshes/1/primitives/0/material", json!(1), "index", None),
        ("/images/1/bufferView", json!(99), "index", None),
        ("/accessors/7/bufferView", json!(99), "index", None),
        ("/accessors/7/sparse/values/bufferView", json!(99), "index", None),
        // Lacks what must be there.
        ("/cameras/0/type", gone.clone(), "missing", Some("/cameras/0")),
        ("/cameras/1/orthographic", gone.clone(), "missing", Some("/cameras/1")),
        ("/cameras/1/orthographic/zfar", gone.clone(), "missing", Some("/cameras/1/orthographic")),
        ("/images/0/uri", gone.clone(), "missing", Some("/images/0")),
        ("/images/1/mimeType", gone.clone(), "missing", Some("/images/1")),
        ("/animations/0/samplers/0/input", gone.clone(), "missing", Some("/animations/0/samplers/0")),
        ("/animations/0/channels/0/target", gone.clone(), "missing", Some("/animations/0/channels/0")),
        ("/materials/0/normalTexture/index", gone.clone(), "missing", Some("/materials/0/normalTexture")),
        ("/meshes/1/primitives", gone.clone(), "missing", Some("/meshes/1")),
        ("/accessors/7/count", gone.clone(), "missing", Some("/accessors/7")),
        ("/accessors/7/sparse/count", gone, "missing", Some("/accessors/7/sparse")),
        // Says together what cannot be.
        ("/accessors/7/count", json!(9999), "accessor", Some("/accessors/7")),
        ("/accessors/7/count", json!(0), "accessor", None),
        ("/accessors/7/sparse/count", json!(9), "accessor", None),
        ("/accessors/7/byteOffset", json!(2), "accessor", None),
        ("/bufferViews/8/byteLength", json!(99_999), "view", None),
        ("/bufferViews/8/byteLength", json!(0), "view", None),
        ("/bufferViews/8/byteStride", json!(5), "view", None),
    ] {
        let mut doc = full();
        set(&mut doc.json, pointer, value.clone());
        let expected = place.unwrap_or(pointer).to_owned();
        assert_eq!(told(&doc), [(code, expected)], "{pointer} := {value}");
        let back = Gltf::from_slice(&doc.open().unwrap().to_glb().unwrap(), "b", &Limits::default()).unwrap();
        let at = |json: &Value| json.pointer(pointer).cloned();
        assert_eq!(at(back.json()), at(&doc.json), "{pointer}");
    }
}

#[test]
fn what_extensions_bring_is_nobodys_business() {
    let mut doc = full();
    let target = &mut doc.json["animations"][0]["channels"][0]["target"];
    *target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/a" } } });
    doc.json["materials"][0]["extensions"] = json!({ "EXT_x": { "index": 99 } });
    doc.json["materials"][0]["unknown"] = json!({ "index": -1 });
    doc.json["images"][0] = json!({ "extensions": { "EXT_x": { "uri": 3 } } });
    doc.json["nodes"][3]["extras"] = json!([null]);
    assert_eq!(told(&doc), []);
}

#[test]
fn many_faults_are_told_in_few_words() {
    let mut doc = triangle(json!({}));
    let told = |doc: &Doc| -> Vec<String> {
        doc.open().unwrap().warnings().iter().map(ToString::to_string).collect()
    };
    doc.json["cameras"] = Value::Array(vec![json!({}); 20]);
    assert!(
        matches!(&told(&doc)[..], [.., last] if told(&doc).len() == 20 && last.starts_with("/cameras/19"))
    );
    doc.json["cameras"] = Value::Array(vec![json!({}); 100_000]);
    let all = told(&doc);
    assert_eq!(all.len(), 21);
    assert!(all[20].starts_with("and 99980 more faults"), "{}", all[20]);
}

#[test]
fn real_files_are_told_nothing() {
    let mut files = 0;
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let document = path.extension().is_some_and(|kind| kind == "glb" || kind == "gltf");
            let Ok(gltf) = Gltf::read(&path, &Limits::default()) else { continue };
            assert!(document && gltf.warnings().is_empty(), "{}: {:?}", path.display(), gltf.warnings());
            files += 1;
        }
    }
    eprintln!("{files} files");
}
