//! Spoiled documents: any answer but a panic.

use proptest::prelude::*;
use serde_json::{Value, json};
use wirework_asset::{Gltf, Limits};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::triangle;

fn full() -> make::Doc {
    let mut doc = triangle(json!({ "skin": 0 }));
    doc.node(json!({ "translation": [0, 0, 3], "children": [2] }));
    doc.node(json!({ "rotation": [0, 0, 0, 1], "weights": [0.5], "mesh": 0 }));
    let joints =
        doc.accessor(json!({ "componentType": 5121, "type": "VEC4", "count": 3 }), &[0, 1, 0, 0].repeat(3));
    let weights = doc.floats("VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(3));
    let colors = doc.floats("VEC3", &[0.0, 0.5, 1.0].repeat(3));
    let deltas = doc.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let uvs = doc.floats("VEC2", &[0.25; 6]);
    doc.json["images"] = json!([{ "uri": "data:image/png;base64,AQID" }]);
    doc.json["samplers"] = json!([{ "wrapS": 33071 }]);
    doc.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    let transform = json!({ "KHR_texture_transform": { "offset": [0.5, 0], "rotation": 1, "texCoord": 0 } });
    doc.json["materials"] = json!([{ "alphaMode": "MASK", "pbrMetallicRoughness": {
        "baseColorFactor": [1, 1, 1, 1], "baseColorTexture": { "index": 0, "extensions": transform },
    } }]);
    let indices =
        doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": 3 }), &[0, 0, 1, 0, 2, 0]);
    let (at, values) = (doc.view(&[1]), doc.view(&7.0_f32.to_le_bytes().repeat(3)));
    doc.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": values },
    });
    doc.json["skins"] = json!([{ "joints": [1, 2] }]);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] = json!(joints);
    primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    primitive["attributes"]["COLOR_0"] = json!(colors);
    primitive["targets"] = json!([{ "POSITION": deltas }]);
    primitive["indices"] = json!(indices);
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["material"] = json!(0);
    let times = doc.floats("SCALAR", &[0.0, 1.0]);
    let track = doc.floats("SCALAR", &[0.0, 1.0]);
    let turns = doc.floats("VEC4", &[0.0, 0.0, 0.0, 1.0].repeat(6));
    doc.json["animations"] = json!([{
        "samplers": [
            { "input": times, "output": track },
            { "input": times, "output": turns, "interpolation": "CUBICSPLINE" },
        ],
        "channels": [
            { "sampler": 0, "target": { "node": 2, "path": "weights" } },
            { "sampler": 1, "target": { "node": 1, "path": "rotation" } },
        ],
    }]);
    doc
}

/// All that can be done with a document.
fn use_it(glb: &[u8]) -> bool {
    let Ok(mut gltf) = Gltf::from_slice(glb, "spoiled", &Limits::default()) else { return false };
    let Ok(rest) = gltf.rest() else { return false };
    let joints = gltf.joint_nodes();
    assert!(gltf.joint_weights(&rest, &joints).is_ok() && gltf.vertices_of_materials(&rest, &[0]).is_ok());
    let _ = (gltf.colors(&rest), gltf.mesh_nodes(&[0, 1]));
    let (looks, _) = gltf.looks(&rest);
    for (part, look) in looks.iter().enumerate() {
        let Some(texture) = &look.texture else { continue };
        let _ = (gltf.texture_coordinates(&rest, part, texture), gltf.image(texture.image).is_ok());
    }
    assert!(gltf.strokes(&rest).is_ok());
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for clip in [None, Some(0)] {
        let Ok(mut player) = gltf.player(&rest, clip) else { continue };
        for seconds in [0.0, 0.5] {
            let _ = player.pose_into(seconds, None, &mut positions, &mut normals);
            assert!(positions.as_flattened().iter().all(|c| c.is_finite()));
        }
    }
    let moved: Vec<[f32; 3]> = rest.positions.iter().map(|p| [p[0], p[1] + 1.0, p[2]]).collect();
    let mut still = gltf.clone();
    let _ = still.set_still(&rest, &moved, None, None);
    let _ = still.to_glb();
    for part in &rest.parts {
        let deltas = rest.to_local(part.block, &moved, None, None);
        let Ok(position) = gltf.append_deltas(deltas.positions, true) else { continue };
        let target = wirework_asset::MorphTarget { position, normal: None, tangent: None };
        let target = wirework_asset::MeshTarget { name: "a".into(), primitives: vec![target] };
        let _ = gltf.add_targets_by_node(part.mesh, &[(part.node, &[target])]);
        let _ = gltf.default_weights(part.node);
    }
    gltf.to_glb().is_ok()
}

fn leaves(value: &Value, at: &str, out: &mut Vec<String>) {
    out.push(at.to_owned());
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| leaves(value, &format!("{at}/{key}"), out)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(k, value)| leaves(value, &format!("{at}/{k}"), out));
        }
        _ => {}
    }
}

#[test]
fn the_document_is_good_before_it_is_spoiled() {
    assert!(use_it(&full().glb()));
}

#[test]
fn every_value_replaced_by_any_other() {
    let good = full();
    let mut all = Vec::new();
    leaves(&good.json, "", &mut all);
    let bad = [
        Value::Null,
        json!(true),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(1.5),
        json!(4_294_967_295_u64),
        json!(9_223_372_036_854_775_807_u64),
        json!(1e300),
        json!(""),
        json!([]),
        json!([null]),
        json!({}),
        json!([0, 0]),
    ];
    for pointer in all.iter().filter(|pointer| !pointer.is_empty()) {
        for value in &bad {
            let mut doc = full();
            *doc.json.pointer_mut(pointer).unwrap() = value.clone();
            let _ = use_it(&doc.glb());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn flipped_bytes(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut glb = full().glb();
        for (index, byte) in changes {
            *index.get_mut(&mut glb) = byte;
        }
        let _ = use_it(&glb);
    }
}

#[test]
fn a_view_no_buffer_can_hold_stays_as_it_is_with_a_warning() {
    let buffer = json!({ "uri": "data:;base64,AAAAAA==", "byteLength": 4 });
    let view = json!({ "buffer": 1, "byteOffset": u64::MAX, "byteLength": 4 });
    let json = json!({
        "asset": { "version": "2.0" }, "buffers": [buffer, buffer],
        "bufferViews": [{ "buffer": 1, "byteLength": 4 }, view],
    });
    let gltf = Gltf::from_slice(json.to_string().as_bytes(), "far.gltf", &Limits::default()).unwrap();
    let warnings: Vec<String> = gltf.warnings().iter().map(ToString::to_string).collect();
    assert!(matches!(&warnings[..], [one] if one.starts_with("/bufferViews/1/byteLength: ")), "{warnings:?}");
    let back = Gltf::from_slice(&gltf.to_glb().unwrap(), "far.glb", &Limits::default()).unwrap();
    let moved = json!({ "buffer": 0, "byteLength": 4, "byteOffset": 4 });
    assert_eq!(back.json()["bufferViews"], json!([moved, view]));
}

#[test]
fn the_key_that_numbers_are_read_by_is_refused() {
    let read = |extras: &str| {
        let text = format!("{{\"asset\":{{\"version\":\"2.0\"}},\n\"extras\":{extras}}}");
        Gltf::from_slice(text.as_bytes(), "a.gltf", &Limits::default())
    };
    for extras in [
        r#"{"$serde_json::private::Number":"5"}"#,
        r#"{"\u0024serde_json::private::Number" : "5"}"#,
        r#"["\\", {"\u0024\u0073erde_json::private::\u004eumber":"5"}]"#,
        r#"{"$serde_json::private::Number":7}"#,
    ] {
        let error = read(extras).unwrap_err().to_string();
        assert!(error.starts_with("a.gltf:2: ") && error.contains("private::Number"), "{error}");
    }
    for extras in [r#"["$serde_json::private::Number"]"#, r#"{"$serde_json":"\""}"#, r#"{"a\"$":1.50}"#] {
        let gltf = read(extras).unwrap();
        assert_eq!(gltf.json()["extras"].to_string(), extras);
    }
    for text in ["\"", "\"\\", "\"$\\", "{\"$serde_json::private::Number\""] {
        assert!(Gltf::from_slice(text.as_bytes(), "a.gltf", &Limits::default()).is_err());
    }
}

#[test]
fn new_documents_keep_within_the_limits_of_the_caller() {
    let mesh = wirework_asset::NewMesh {
        name: "p",
        positions: &[[0.0; 3]; 3],
        normals: None,
        uvs: None,
        triangles: &[[0, 1, 2]],
    };
    let within = |vertices, indices| {
        Gltf::from_meshes_within("p", &[mesh], &Limits { vertices, indices, ..Limits::default() })
    };
    assert!(within(3, 3).is_ok_and(|gltf| gltf.rest().is_ok()));
    for (vertices, indices, flag) in [(2, 3, "--max-vertices"), (3, 2, "--max-indices")] {
        let error = within(vertices, indices).unwrap_err();
        assert_eq!(error.class, wirework_asset::ErrorClass::Limit);
        assert!(error.to_string().contains(flag), "{error}");
    }
}
