//! Append-only: what was in the document is in the result, at its place and with its bytes.

use serde_json::{Value, json};
use wirework_asset::{Format, Gltf, Limits};

mod common;
use common::{ASSETS, baked, bin_of, instances, json_of, shared, with_json};

/// Every difference between two documents must be an addition, or one of the edits that targets need.
fn check_diff(name: &str, path: &str, old: &Value, new: &Value) {
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            let mut kept = b.keys().filter(|key| a.contains_key(*key));
            assert!(
                a.keys().all(|key| kept.next() == Some(key)),
                "{name}{path}: members dropped or reordered"
            );
            for key in b.keys().filter(|key| !a.contains_key(*key)) {
                let addition = matches!(
                    (path.split('/').nth(1).unwrap_or(""), key.as_str()),
                    ("", "animations" | "accessors" | "bufferViews" | "buffers")
                        | ("meshes", "weights" | "extras" | "targets")
                );
                let names = path.ends_with("/extras") && key == "targetNames";
                let zeros = path.contains("/targets/");
                assert!(addition || names || zeros, "{name}{path}/{key}: added");
            }
            for (key, value) in a {
                check_diff(name, &format!("{path}/{key}"), value, &b[key]);
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            assert!(a.len() <= b.len(), "{name}{path}: elements dropped");
            let last = path.rsplit('/').next().unwrap_or("");
            let grows = [
                "accessors",
                "bufferViews",
                "buffers",
                "animations",
                "meshes",
                "targets",
                "weights",
                "targetNames",
                "samplers",
            ];
            assert!(a.len() == b.len() || grows.contains(&last), "{name}{path}: elements added");
            for (k, value) in a.iter().enumerate() {
                check_diff(name, &format!("{path}/{k}"), value, &b[k]);
            }
        }
        _ => {
            let parts: Vec<&str> = path.split('/').skip(1).collect();
            let allowed = matches!(
                parts.as_slice(),
                ["buffers", "0", "byteLength"]
                    | ["nodes", _, "mesh"]
                    | ["animations", _, "samplers", _, "output"]
                    | ["animations", _, "channels", _, "sampler"]
            );
            assert!(old == new || allowed, "{name}{path}: {old} became {new}");
        }
    }
}

#[test]
fn real_files_keep_what_they_had() {
    for name in ASSETS {
        let Some(path) = shared(name) else { return };
        let gltf = Gltf::read(&path, &Limits::default()).unwrap();
        // A `.gltf` is made a `.glb` first: the embedding is an edit of its own.
        let before = if path.extension().is_some_and(|extension| extension == "glb") {
            std::fs::read(&path).unwrap()
        } else {
            gltf.to_glb().unwrap()
        };
        let gltf = Gltf::from_slice(&before, name, &Limits::default()).unwrap();
        assert_eq!(bin_of(&gltf.to_glb().unwrap()), bin_of(&before), "{name}: untouched");
        let strict = gltf::Gltf::from_slice(&before).is_ok();
        let rest = gltf.rest().unwrap();
        let out = baked(gltf, &rest).gltf;
        let after =
            out.files(std::path::Path::new("out.glb"), Format::Glb).unwrap().pop().unwrap().bytes().unwrap();
        assert!(bin_of(&after).starts_with(bin_of(&before)), "{name}: the old chunk is no prefix");
        check_diff(name, "", &json_of(&before), &json_of(&after));
        if strict {
            gltf::Gltf::from_slice(&after).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let run = || {
        let gltf = instances();
        let rest = gltf.rest().unwrap();
        baked(gltf, &rest).gltf.to_glb().unwrap()
    };
    assert_eq!(run(), run());
}

/// A document with morph targets, default weights, and clips that move them in all ways.
fn animated() -> Gltf {
    let mut gltf = instances();
    let targets = |position| wirework_asset::MeshTarget {
        name: "own".into(),
        primitives: vec![wirework_asset::MorphTarget { position, normal: None, tangent: None }],
    };
    let position = gltf.append_deltas(vec![[0.0, 0.0, 1.0]; 4], true).unwrap();
    gltf.add_targets(0, &[targets(position), targets(position)]).unwrap();
    let track =
        |node, weights: &[f32]| wirework_asset::WeightTrack { node, times: None, weights: weights.to_vec() };
    let clip = wirework_asset::Clip::New("own".into());
    gltf.add_clip(&clip, &[0.0, 1.0], &[track(0, &[0.0, 0.25, 1.0, 0.5])]).unwrap();
    let glb = gltf.to_glb().unwrap();
    let mut json = json_of(&glb);
    json["nodes"][1]["weights"] = json!([0.5, 0.25]);
    json["meshes"][0]["extras"]["targetNames"] = json!(["one"]);
    // One sampler for weights and, wrongly but readably, for another node's mesh.
    let mut cubic = json["animations"][0].clone();
    cubic["samplers"][0]["interpolation"] = json!("CUBICSPLINE");
    let output = json["accessors"].as_array().unwrap().len();
    let view =
        json["accessors"][cubic["samplers"][0]["output"].as_u64().unwrap() as usize]["bufferView"].clone();
    json["accessors"].as_array_mut().unwrap().push(json!({
        "componentType": 5126, "type": "SCALAR", "count": 12, "sparse": {
            "count": 1, "indices": { "bufferView": view, "componentType": 5121 }, "values": { "bufferView": view, "byteOffset": 8 },
        },
    }));
    cubic["samplers"][0]["output"] = json!(output);
    cubic["channels"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "sampler": 0, "target": { "node": 2, "path": "scale" } }));
    json["animations"].as_array_mut().unwrap().push(cubic);
    Gltf::from_slice(&with_json(&glb, &json), "animated", &Limits::default()).unwrap()
}

fn output_of(json: &Value, clip: usize, channel: usize) -> &Value {
    let animation = &json["animations"][clip];
    let sampler = animation["channels"][channel]["sampler"].as_u64().unwrap() as usize;
    let output = animation["samplers"][sampler]["output"].as_u64().unwrap() as usize;
    &json["accessors"][output]
}

#[test]
fn other_clips_weights_and_names_are_continued() {
    let gltf = animated();
    let rest = gltf.rest().unwrap();
    let before = gltf.json().clone();
    let out = baked(gltf, &rest).gltf;
    let json = out.json();
    check_diff("animated", "", &before, json);
    // Two targets of its own, two of ours.
    assert_eq!(json["nodes"][1]["weights"], json!([0.5, 0.25, 0, 0]));
    assert_eq!(json["meshes"][0]["weights"], json!([0, 0, 0, 0]));
    let names = json!(["one", "target_1", "wirework_f0001", "wirework_f0002"]);
    assert_eq!(json["meshes"][0]["extras"]["targetNames"], names);
    assert_eq!(output_of(json, 0, 0)["count"], 2 * 4);
    assert_eq!(output_of(json, 1, 0)["count"], 2 * 4 * 3);
    assert_eq!(output_of(json, 1, 1)["count"], 12, "the channel that shares the sampler keeps its data");
    assert_eq!(output_of(json, 2, 0)["count"], 5 * 4);
    let glb = out.to_glb().unwrap();
    let doc = gltf::Gltf::from_slice(&glb).unwrap();
    let blob = doc.blob.as_deref().unwrap();
    let channel = doc.animations().next().unwrap().channels().next().unwrap();
    let outputs = channel.reader(|_| Some(blob)).read_outputs().unwrap();
    let gltf::animation::util::ReadOutputs::MorphTargetWeights(values) = outputs else { panic!() };
    assert_eq!(values.into_f32().collect::<Vec<f32>>(), [0.0, 0.25, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0]);
}

#[test]
fn unknown_chunks_numbers_and_extensions_survive() {
    let glb = instances().to_glb().unwrap();
    let mut json = json_of(&glb);
    json["extensions"] = json!({ "VENDOR_thing": { "deep": [1, { "a": null }] } });
    json["extras"] = serde_json::from_str("1.000000000000000000000000001").unwrap();
    let mut glb = with_json(&glb, &json);
    let chunk = b"\x04\0\0\0ABCD1234";
    glb.extend(chunk);
    let total = glb.len() as u32;
    glb[8..12].copy_from_slice(&total.to_le_bytes());
    let gltf = Gltf::from_slice(&glb, "chunks", &Limits::default()).unwrap();
    let rest = gltf.rest().unwrap();
    let out = baked(gltf, &rest).gltf.to_glb().unwrap();
    assert!(out.ends_with(chunk));
    check_diff("chunks", "", &json, &json_of(&out));
    assert_eq!(json_of(&out)["extras"].to_string(), "1.000000000000000000000000001");
}
