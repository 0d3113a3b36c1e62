//! Documents whose nodes stand as a clip has them at a moment.

use serde_json::json;

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::{close, pose};
mod moving;
use moving::{noise, scene};

#[test]
fn nodes_stand_where_the_clip_has_them() {
    let mut gltf = scene().open().unwrap();
    let before = gltf.json().clone();
    let rest = gltf.rest().unwrap();
    let source = gltf.clone();
    let mut player = source.player(&rest, Some(0)).unwrap();
    for seconds in [1.3, 0.4] {
        let [positions, _] = pose(&mut player, seconds, None);
        gltf.pose_nodes(&player.node_poses()).unwrap();
        let again = gltf.rest().unwrap();
        assert!(positions.iter().zip(&again.positions).all(|(a, b)| close(*a, *b)));
    }
    // Only what the clip moves is written: node 4 is not, and of node 3 the rotation.
    let nodes = &gltf.json()["nodes"];
    assert_eq!(nodes[4], before["nodes"][4]);
    let mut third = nodes[3].clone();
    third.as_object_mut().unwrap().remove("rotation");
    assert_eq!(third, before["nodes"][3]);
    assert_eq!(
        (&gltf.json()["animations"], &gltf.json()["meshes"]),
        (&before["animations"], &before["meshes"])
    );
    assert!(gltf.player(&rest, None).unwrap().node_poses().is_empty());
}

#[test]
fn a_still_of_a_moment_shows_clip_and_effect() {
    let mut gltf = scene().open().unwrap();
    let rest = gltf.rest().unwrap();
    let source = gltf.clone();
    let mut player = source.player(&rest, Some(0)).unwrap();
    let mut moment = rest.clone();
    player.rest_into(0.8, &mut moment).unwrap();
    let mut wanted = moment.positions.clone();
    wanted.iter_mut().enumerate().skip(1).for_each(|(v, p)| p[v % 3] += 0.3 * noise(v));
    gltf.pose_nodes(&player.node_poses()).unwrap();
    assert_eq!(gltf.set_still(&moment, &wanted, None, None).unwrap(), 0);
    let found = gltf.rest().unwrap().positions;
    assert!(found.iter().zip(&wanted).all(|(a, b)| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 5e-6)));
    assert_eq!(found[0], moment.positions[0]);
}

#[test]
fn weights_of_later_targets_stay() {
    let mut gltf = scene().open().unwrap();
    let rest = gltf.rest().unwrap();
    let source = gltf.clone();
    let mut player = source.player(&rest, Some(0)).unwrap();
    pose(&mut player, 2.0, None);
    let position = gltf.append_deltas(vec![[0.0, 1.0, 0.0]; 6], true).unwrap();
    let target = wirework_asset::MorphTarget { position, normal: None, tangent: None };
    gltf.add_targets(0, &[wirework_asset::MeshTarget { name: "ours".into(), primitives: vec![target] }])
        .unwrap();
    gltf.pose_nodes(&player.node_poses()).unwrap();
    assert_eq!(gltf.json()["nodes"][0]["weights"], json!([1.0, 0.5, 0.0]));
    let nowhere = wirework_asset::NodePose { node: 99, ..Default::default() };
    assert!(gltf.pose_nodes(&[nowhere]).is_err());
}
