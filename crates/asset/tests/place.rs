//! Placing a scene moves what it shows, and no index.

use serde_json::{Value, json};
use wirework_surface::Transform;

mod make;
use make::{Doc, skinned, triangle};

const PLACE: Transform =
    Transform { translation: [1.0, -2.0, 0.5], rotation: [20.0, 30.0, -70.0], scale: [2.0, -0.5, 1.5] };

/// Places a document and compares it with its moved rest; gives the JSON after.
fn moved(doc: &Doc) -> Value {
    let mut expected = doc.rest().unwrap().positions;
    PLACE.apply_to_points(&mut expected).unwrap();
    let mut gltf = doc.open().unwrap();
    let before = gltf.json()["nodes"].as_array().unwrap().clone();
    gltf.place(&PLACE).unwrap();
    let after = gltf.json()["nodes"].as_array().unwrap().clone();
    assert_eq!(after[..before.len()], before);
    let glb = gltf.to_glb().unwrap();
    let found = wirework_asset::Gltf::from_slice(&glb, "placed.glb", &wirework_asset::Limits::default())
        .unwrap()
        .rest()
        .unwrap()
        .positions;
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(&expected) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
    }
    gltf.json().clone()
}

#[test]
fn what_a_scene_shows_is_moved() {
    let mut doc = triangle(json!({ "translation": [0, 1, 0] }));
    doc.node(json!({ "children": [0], "rotation": [0, 0, 1, 0] }));
    doc.node(json!({ "mesh": 0 }));
    // Without a scene all roots are shown, and the new node is the only one.
    assert_eq!(moved(&doc)["nodes"][3]["children"], json!([1, 2]));
    doc.json["scenes"] = json!([{ "nodes": [] }, { "nodes": [2, 1] }]);
    doc.json["scene"] = json!(1);
    let json = moved(&doc);
    assert_eq!(json["scenes"], json!([{ "nodes": [] }, { "nodes": [3] }]));
}

#[test]
fn skins_move_with_their_joints() {
    let json = moved(&skinned([0.5, 0.5, 0.0, 0.0]));
    let nodes = json["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), 4);
    let is_mesh = |child: &Value| nodes[child.as_u64().unwrap() as usize].get("skin").is_some();
    let moved = nodes[3]["children"].as_array().unwrap();
    assert!(!moved.is_empty() && !moved.iter().any(is_mesh), "a skinned mesh stays a root: {nodes:?}");
}

#[test]
fn a_scene_that_shares_roots_stays_valid() {
    let mut doc = triangle(json!({}));
    doc.node(json!({ "mesh": 0, "translation": [0, 0, 7] }));
    doc.json["scenes"] = json!([{ "nodes": [0, 1] }, { "nodes": [1] }]);
    let json = moved(&doc);
    assert_eq!(json["scenes"], json!([{ "nodes": [2, 3] }, { "nodes": [3] }]));
    doc.json["scenes"] = json!([{ "nodes": [0, 1] }, { "nodes": [1, 0] }]);
    assert_eq!(moved(&doc)["scenes"], json!([{ "nodes": [2] }, { "nodes": [2] }]));
}

#[test]
fn what_cannot_be_placed_is_refused_and_the_identity_does_nothing() {
    let mut doc = triangle(json!({}));
    doc.node(json!({ "children": [0] }));
    doc.json["scenes"] = json!([{ "nodes": [0] }]);
    let mut gltf = doc.open().unwrap();
    let before = gltf.json().clone();
    gltf.place(&Transform::default()).unwrap();
    let error = gltf.place(&PLACE).unwrap_err();
    assert!(error.to_string().contains("/nodes/0"), "{error}");
    assert!(gltf.place(&Transform { scale: [f32::NAN; 3], ..PLACE }).is_err());
    assert_eq!(*gltf.json(), before);
}
