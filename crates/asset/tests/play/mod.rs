//! Clips made by hand, and what they are played with.

use serde_json::json;
use wirework_asset::{AssetError, LocalDeltas, Player};

use crate::make::Doc;

pub(crate) fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// Adds a channel to the only clip.
pub(crate) fn channel(
    doc: &mut Doc,
    node: usize,
    path: &str,
    interpolation: &str,
    input: usize,
    output: usize,
) {
    if doc.json.get("animations").is_none() {
        doc.json["animations"] = json!([{ "samplers": [], "channels": [] }]);
    }
    let clip = &mut doc.json["animations"][0];
    let samplers = clip["samplers"].as_array_mut().unwrap();
    samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
    let channel = json!({ "sampler": samplers.len() - 1, "target": { "node": node, "path": path } });
    clip["channels"].as_array_mut().unwrap().push(channel);
}

pub(crate) fn track(
    doc: &mut Doc,
    node: usize,
    path: &str,
    interpolation: &str,
    times: &[f32],
    values: &[f32],
) {
    let kind = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    let (input, output) = (doc.floats("SCALAR", times), doc.floats(kind, values));
    channel(doc, node, path, interpolation, input, output);
}

pub(crate) fn pose(
    player: &mut Player<'_>,
    seconds: f64,
    deltas: Option<&[LocalDeltas]>,
) -> [Vec<[f32; 3]>; 2] {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    player.pose_into(seconds, deltas, &mut positions, &mut normals).unwrap();
    assert_eq!(positions.len(), normals.len());
    [positions, normals]
}

pub(crate) fn refused(doc: &Doc) -> AssetError {
    let gltf = doc.open().unwrap();
    gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap_err()
}

/// A strip along y of three pairs of vertices, half way up a second joint, in a node that does not count.
pub(crate) fn strip() -> Doc {
    let mut doc = Doc::new();
    let points: Vec<f32> = (0..6).flat_map(|i| [(i % 2) as f32, (i / 2) as f32, 0.0]).collect();
    let positions = doc.floats("VEC3", &points);
    let normals = doc.floats("VEC3", &[0.0, 1.0, 0.0].repeat(6));
    let joints = doc.accessor(
        json!({ "componentType": 5121, "type": "VEC4", "count": 6 }),
        &[[0, 0, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]].concat(),
    );
    let (one, half) = ([1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]);
    let weights = doc.floats("VEC4", &[one, one, half, half, one, one].concat());
    let mut binds =
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].repeat(2);
    binds[16 + 13] = -1.0;
    let binds = doc.floats("MAT4", &binds);
    let indices = doc.accessor(
        json!({ "componentType": 5121, "type": "SCALAR", "count": 12 }),
        &[0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5],
    );
    let attributes = json!({
        "POSITION": positions, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights,
    });
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": indices }));
    doc.node(json!({ "mesh": mesh, "skin": 0, "translation": [50, 0, 0] }));
    doc.node(json!({ "children": [2] }));
    doc.node(json!({ "translation": [0, 1, 0] }));
    doc.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    doc
}
