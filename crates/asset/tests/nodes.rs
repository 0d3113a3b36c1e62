//! Nodes: who is above whom, and where they are at a moment.

use serde_json::json;

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, triangle};
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::{pose, track};

/// A triangle in the scene, and beside the scene a tree: 1 above 2 and 5, 2 above 3 above 4.
fn tree() -> Doc {
    let mut doc = triangle(json!({}));
    doc.node(json!({ "children": [2, 5], "translation": [1, 2, 3] }));
    doc.node(json!({ "children": [3], "rotation": [0, 0, 0.6, 0.8], "scale": [2, 2, 2] }));
    doc.node(json!({ "children": [4], "matrix": [0, 3, 0, 0, -1, 0, 0, 0, 0, 0, -2, 0, 5, 6, 7, 1] }));
    doc.node(json!({ "matrix": [1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }));
    doc.node(json!({ "matrix": [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }));
    doc.json["scenes"] = json!([{ "nodes": [0] }]);
    doc
}

#[test]
fn paths_go_down_from_an_ancestor() {
    let gltf = tree().open().unwrap();
    assert_eq!(
        (gltf.parent(4), gltf.parent(2), gltf.parent(1), gltf.parent(9)),
        (Some(3), Some(1), None, None)
    );
    assert_eq!(gltf.node_path(1, 4), Some(vec![1, 2, 3, 4]));
    assert_eq!(gltf.node_path(2, 3), Some(vec![2, 3]));
    assert_eq!(gltf.node_path(5, 5), Some(vec![5]));
    for (root, tip) in [(4, 1), (5, 4), (0, 3), (9, 9), (1, 9), (9, 1)] {
        assert_eq!(gltf.node_path(root, tip), None, "{root} to {tip}");
    }
    assert_eq!(gltf.descendants(1), [2, 3, 4, 5]);
    assert_eq!(gltf.descendants(3), [4]);
    assert!(gltf.descendants(4).is_empty() && gltf.descendants(9).is_empty());
    // Circles are refused where a rest is read; until then they are no endless walk.
    let mut doc = tree();
    doc.json["nodes"][4]["children"] = json!([1, 4]);
    let gltf = doc.open().unwrap();
    assert!(gltf.rest().is_err());
    assert_eq!((gltf.node_path(0, 4), gltf.descendants(4)), (None, vec![1, 2, 3, 5]));
}

fn near<const N: usize>(a: [f64; N], b: [f64; N]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn transforms_and_parts_are_those_of_the_moment() {
    let mut doc = tree();
    track(&mut doc, 2, "translation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 8.0]);
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let mut player = gltf.player(&rest, Some(0)).unwrap();
    pose(&mut player, 1.0, None);
    assert_eq!(player.node_transform(1).unwrap()[3], [1.0, 2.0, 3.0]);
    let [x, y, z, at] = player.node_transform(2).unwrap();
    assert!(near(x, [0.56, 1.92, 0.0]) && near(y, [-1.92, 0.56, 0.0]) && near(z, [0.0, 0.0, 2.0]));
    assert!(near(at, [1.0, 2.0, 7.0]), "{at:?}");
    let parts = player.node_parts(2).unwrap();
    assert!(near(parts.translation, [0.0, 0.0, 4.0]) && near(parts.rotation, [0.0, 0.0, 0.6, 0.8]));
    assert_eq!(parts.scale, [2.0; 3]);
    assert!(player.node_transform(6).is_none() && player.node_parts(6).is_none());
}

#[test]
fn a_matrix_has_parts_unless_it_is_sheared_or_flat() {
    let gltf = tree().open().unwrap();
    let rest = gltf.rest().unwrap();
    let player = gltf.player(&rest, None).unwrap();
    let parts = player.node_parts(3).unwrap();
    assert_eq!(parts.translation, [5.0, 6.0, 7.0]);
    assert!(near(parts.scale, [-3.0, 1.0, 2.0]), "{parts:?}");
    let q = glam::DQuat::from_array(parts.rotation);
    let turned = glam::DMat3::from_quat(q) * glam::DMat3::from_diagonal(parts.scale.into());
    assert!(near(turned.to_cols_array(), [0.0, 3.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -2.0]), "{turned}");
    assert!(player.node_parts(4).is_none() && player.node_parts(5).is_none());
}
