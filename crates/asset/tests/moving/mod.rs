//! A scene in which everything moves: skins, nodes and morph targets.

use serde_json::json;

use crate::make::Doc;
use crate::play::{strip, track};

/// Numbers from −1 to 1 without a pattern, the same ones every time.
pub(crate) fn noise(seed: usize) -> f32 {
    let mut x = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^= x >> 29;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (x >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
}

/// A skinned strip with a morph target, and its mesh shown twice without skin: by a node that turns below one that is scaled
/// unevenly, and by one that is mirrored and morphed otherwise. All of it moves.
pub(crate) fn scene() -> Doc {
    let mut doc = strip();
    let tangents: Vec<f32> = (0..6).flat_map(|_| [1.0, 0.0, 0.0, -1.0]).collect();
    let tangents = doc.floats("VEC4", &tangents);
    let lift: Vec<f32> = (0..18).map(|k| noise(k) * 0.5).collect();
    let (lift, lean) = (doc.floats("VEC3", &lift), doc.floats("VEC3", &[0.25, 0.0, 0.5].repeat(6)));
    let turn = doc.floats("VEC3", &[0.0, 0.5, 0.0].repeat(6));
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TANGENT"] = json!(tangents);
    primitive["targets"] =
        json!([{ "POSITION": lift, "NORMAL": lean, "TANGENT": turn }, { "POSITION": lift }]);
    doc.json["meshes"][0]["weights"] = json!([0.25, 0]);
    doc.node(json!({ "mesh": 0, "translation": [3, 0, 1] }));
    doc.node(json!({ "children": [3], "scale": [1, 2, 0.5] }));
    doc.node(json!({ "mesh": 0, "scale": [-1, 1, 1], "weights": [0, 1] }));
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 4, 5] }]);
    let (half, ends) = (0.5_f32.sqrt(), [0.0, 2.0]);
    track(&mut doc, 2, "rotation", "LINEAR", &ends, &[0.0, 0.0, 0.0, 1.0, half, 0.0, 0.0, half]);
    track(&mut doc, 1, "translation", "LINEAR", &ends, &[0.0, 0.0, 0.0, 0.0, 1.0, 4.0]);
    track(&mut doc, 2, "scale", "LINEAR", &ends, &[1.0, 1.0, 1.0, 0.5, 1.5, 1.0]);
    track(&mut doc, 3, "rotation", "LINEAR", &ends, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.6, 0.0, 0.8]);
    track(&mut doc, 0, "weights", "LINEAR", &ends, &[0.0, 0.0, 1.0, 0.5]);
    track(&mut doc, 5, "weights", "LINEAR", &ends, &[0.0, 1.0, 1.0, 0.0]);
    doc
}
