//! Skeletons made for meshes that have none.

use serde_json::json;
use wirework_asset::{Clip, Gltf, Hung, JointTrack, NewJoint, NewMesh, NewSkin, Rest, Tracks};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, triangle};
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::{pose, strip};
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;

const NONE: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// A chain along x, a joint at each whole number, the second one turned and scaled.
fn chain(count: usize) -> Vec<NewJoint<'static>> {
    let joint = |k: usize| NewJoint {
        name: ["shoulder", "elbow", "wrist", "hand", "tip"][k % 5],
        parent: k.checked_sub(1),
        translation: [if k == 0 { 0.25 } else { 1.0 }, 0.5, 0.0],
        rotation: if k == 1 { [0.6, 0.0, 0.0, 0.8] } else { NONE },
        scale: if k == 1 { [1.0, 2.0, 0.5] } else { [1.0; 3] },
    };
    (0..count).map(joint).collect()
}

/// Has `nodes` hang on so many joints, on `each` of them every vertex.
fn hang(gltf: &mut Gltf, rest: &Rest, nodes: &[usize], joints: &[NewJoint<'_>], each: usize) -> Hung {
    let vertices: usize =
        rest.blocks.iter().filter(|block| nodes.contains(&block.node)).map(|block| block.count).sum();
    let indices: Vec<u16> =
        (0..vertices * each).map(|k| ((k % each + k / each) % joints.len()) as u16).collect();
    let weights: Vec<f32> = (0..vertices * each).map(|k| 1.0 + (k % 7) as f32).collect();
    gltf.add_skin(rest, nodes, &NewSkin { name: "limb", joints, each, indices: &indices, weights: &weights })
        .unwrap()
}

fn diagonal(rest: &Rest) -> f32 {
    let spread = |k: usize| {
        let all = || rest.positions.iter().map(|p| p[k]);
        all().fold(f32::MIN, f32::max) - all().fold(f32::MAX, f32::min)
    };
    (0..3).map(|k| spread(k).powi(2)).sum::<f32>().sqrt()
}

/// The rest is where it was, by this reader and by another, and nothing of a skinned mesh's node counts for nothing.
fn check(gltf: &Gltf, before: &Rest, shown: &[(usize, usize)]) {
    let again = gltf.rest().unwrap();
    let nodes = gltf.json()["nodes"].as_array().unwrap();
    for (node, json) in nodes.iter().enumerate().filter(|(_, json)| json.get("skin").is_some()) {
        assert!(gltf.parent(node).is_none(), "{node}");
        assert!(["matrix", "translation", "rotation", "scale"].iter().all(|key| json.get(key).is_none()));
    }
    // In the order in which they were shown before.
    let node_now = |node: usize| shown.iter().find(|(old, _)| *old == node).map_or(node, |(_, new)| *new);
    let now = |part: &wirework_asset::Part| {
        let same = |p: &wirework_asset::Part| (p.node, p.primitive) == (node_now(part.node), part.primitive);
        again.parts.iter().position(same).unwrap()
    };
    let known = |code| before.warnings.iter().any(|warning| warning.code == code);
    assert!(again.warnings.iter().all(|warning| known(warning.code)), "{:?}", again.warnings);
    let played = oracle::evaluate(&gltf.to_glb().unwrap(), None, 0.0);
    for part in &before.parts {
        let place = now(part);
        let (block, own) = (&before.blocks[part.block], &again.blocks[again.parts[place].block]);
        for (v, found) in played[place].positions.iter().enumerate() {
            let (want, ours) = (before.positions[block.first + v], again.positions[own.first + v]);
            let off = (*found - glam::DVec3::from_array(want.map(f64::from))).length();
            let apart = ours.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let most = 1e-6 * diagonal(before);
            assert!(off < f64::from(most) && apart < most, "{found} {ours:?} for {want:?}");
        }
        for (a, b) in block.normals.iter().flatten().zip(own.normals.iter().flatten()) {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_new_document_gets_a_skeleton() {
    let positions: Vec<[f32; 3]> = (0..40).map(|k| [(k / 4) as f32 * 0.4, (k % 4) as f32, 0.3]).collect();
    let tube =
        NewMesh { name: "tube", positions: &positions, normals: None, uvs: None, triangles: &[[0, 1, 4]] };
    for (count, each) in [(1, 1), (3, 2), (5, 4), (5, 5), (300, 9)] {
        let mut gltf = Gltf::from_meshes("limb", &[tube]).unwrap();
        let rest = gltf.rest().unwrap();
        let Hung { joints, shown } = hang(&mut gltf, &rest, &[0], &chain(count), each);
        assert_eq!(shown, [(0, 0)]);
        assert_eq!(joints, (1..=count).collect::<Vec<usize>>());
        let json = gltf.json();
        assert_eq!(json["scenes"][0]["nodes"], json!([0, 1]));
        assert_eq!((&json["nodes"][0]["skin"], &json["nodes"][1]["name"]), (&json!(0), &json!("shoulder")));
        assert_eq!((&json["skins"][0]["skeleton"], &json["skins"][0]["joints"]), (&json!(1), &json!(joints)));
        let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
        for set in 0..=each.div_ceil(4) {
            assert_eq!(attributes.get(format!("JOINTS_{set}")).is_some(), set < each.div_ceil(4));
        }
        let kind = &json["accessors"][attributes["JOINTS_0"].as_u64().unwrap() as usize]["componentType"];
        assert_eq!(kind, &json!(if count > 256 { 5123 } else { 5121 }));
        check(&gltf, &rest, &shown);
        gltf::Gltf::from_slice(&gltf.to_glb().unwrap()).unwrap();
    }
}

#[test]
fn vertices_follow_their_joints() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
    let mesh =
        NewMesh { name: "arm", positions: &positions, normals: None, uvs: None, triangles: &[[0, 2, 3]] };
    let mut gltf = Gltf::from_meshes("arm", &[mesh]).unwrap();
    let rest = gltf.rest().unwrap();
    let joint = |name, parent, x| NewJoint {
        name,
        parent,
        translation: [x, 0.0, 0.0],
        rotation: NONE,
        scale: [1.0; 3],
    };
    let joints = [joint("upper", None, 0.0), joint("lower", Some(0), 1.0)];
    // The one weight of the elbow comes twice, one of the tip is nothing.
    let (indices, weights) = ([0, 0, 1, 1, 1, 0, 1, 0], [1.0, 0.0, 0.5, 0.5, 2.0, 0.0, 1.0, 0.0]);
    let skin = NewSkin { name: "arm", joints: &joints, each: 2, indices: &indices, weights: &weights };
    let nodes = gltf.add_skin(&rest, &[0], &skin).unwrap().joints;
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let bend =
        JointTrack { node: nodes[1], rotations: vec![NONE, [0.0, 0.0, half, half]], ..JointTrack::default() };
    let tracks = Tracks { times: &[0.0, 1.0], joints: &[bend], ..Tracks::default() };
    gltf.add_tracks(&Clip::New("bend".into()), &tracks).unwrap();
    let rest = gltf.rest().unwrap();
    let [positions, _] = pose(&mut gltf.player(&rest, Some(0)).unwrap(), 1.0, None);
    let wanted = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(positions.iter().zip(wanted).all(|(a, b)| play::close(*a, b)), "{positions:?}");
}

/// A mesh of two primitives that three nodes show, one of them below a node that is moved, turned and scaled.
fn shared() -> Doc {
    let mut doc = triangle(json!({ "translation": [1, 0, 0], "name": "a" }));
    let more = doc.floats("VEC3", &[0.0, 0.0, 1.0, 3.0, 0.0, 1.0, 0.0, 2.0, 1.0]);
    let joints = doc.accessor(json!({ "componentType": 5121, "type": "VEC4", "count": 3 }), &[0; 12]);
    let primitives = doc.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": more, "JOINTS_1": joints } }));
    doc.node(json!({ "mesh": 0, "scale": [-2, 1, 1], "name": "b" }));
    doc.node(json!({ "children": [1], "rotation": [0.6, 0, 0, 0.8], "translation": [0, 5, 0] }));
    doc.node(json!({ "mesh": 0, "translation": [0, 0, -3], "name": "c" }));
    doc.json["scenes"] = json!([{ "nodes": [0, 2, 3] }, { "nodes": [3] }, { "nodes": [2] }]);
    doc
}

#[test]
fn nodes_of_an_input_hang_where_they_are() {
    let doc = shared();
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let mut joints = chain(3);
    joints[2].parent = None;
    let Hung { joints: nodes, shown } = hang(&mut gltf, &rest, &[1, 0], &joints, 3);
    let json = gltf.json();
    assert_eq!((nodes, &json["nodes"][7]), (vec![4, 5, 6], &json!({ "name": "limb", "children": [4, 6] })));
    // One of them leaves its parent, both their places.
    assert_eq!(shown, [(0, 0), (1, 1)]);
    assert_eq!(
        json["scenes"],
        json!([{ "nodes": [0, 2, 1, 3, 7] }, { "nodes": [3] }, { "nodes": [2, 1, 7] }])
    );
    assert!(json["nodes"][2].get("children").is_none() && json["nodes"][1]["name"] == "b");
    // Two places, two skins of the same joints; the node that is not asked for keeps the mesh.
    let of = |node: usize, key: &str| json["nodes"][node].get(key).and_then(serde_json::Value::as_u64);
    assert_eq!([0, 1, 3].map(|node| of(node, "skin")), [Some(0), Some(1), None]);
    assert_eq!([0, 1, 3].map(|node| of(node, "mesh")), [Some(1), Some(2), Some(0)]);
    assert_eq!(json["meshes"][0], doc.json["meshes"][0]);
    assert!(json["meshes"][1]["primitives"][1]["attributes"].get("JOINTS_1").is_none());
    check(&gltf, &rest, &shown);
    // All of them: the last one needs no copy.
    let mut gltf = doc.open().unwrap();
    let Hung { shown, .. } = hang(&mut gltf, &rest, &[0, 1, 3], &chain(2), 2);
    assert_eq!(gltf.json()["nodes"][3]["mesh"], 0);
    assert_eq!(gltf.json()["meshes"].as_array().unwrap().len(), 3);
    check(&gltf, &rest, &shown);
}

#[test]
fn a_node_that_is_more_than_its_mesh_stays_and_another_shows_it() {
    let mut doc = shared();
    let offsets = doc.floats("VEC3", &[0.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.0, 0.0, 0.5]);
    for primitive in doc.json["meshes"][0]["primitives"].as_array_mut().unwrap() {
        primitive["targets"] = json!([{ "POSITION": offsets }]);
    }
    doc.json["nodes"][1]["camera"] = json!(0);
    doc.json["nodes"][1]["weights"] = json!([0.25]);
    doc.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }]);
    let times = doc.floats("SCALAR", &[0.0, 1.0]);
    doc.json["accessors"][times]["min"] = json!([0.0]);
    doc.json["accessors"][times]["max"] = json!([1.0]);
    let output = doc.floats("SCALAR", &[0.25, 1.0]);
    let pointer = json!({ "KHR_animation_pointer": { "pointer": "/nodes/1/weights/0" } });
    doc.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": output }],
        "channels": [
            { "sampler": 0, "target": { "node": 1, "path": "weights" } },
            { "sampler": 0, "target": { "path": "pointer", "extensions": pointer } },
        ],
    }]);
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let Hung { shown, .. } = hang(&mut gltf, &rest, &[1], &chain(3), 2);
    assert_eq!(shown, [(1, 7)]);
    let json = gltf.json();
    let mut left = doc.json["nodes"][1].clone();
    for key in ["mesh", "weights"] {
        left.as_object_mut().unwrap().remove(key);
    }
    assert_eq!(json["nodes"][1], left);
    assert_eq!(json["nodes"][2], doc.json["nodes"][2], "its parent");
    assert_eq!(json["nodes"][7], json!({ "name": "b", "mesh": 1, "weights": [0.25], "skin": 0 }));
    assert_eq!(json["scenes"][2], json!({ "nodes": [2, 7, 4] }));
    let channels = &json["animations"][0]["channels"];
    assert_eq!(channels[0]["target"], json!({ "node": 7, "path": "weights" }));
    assert_eq!(
        channels[1].pointer("/target/extensions/KHR_animation_pointer/pointer"),
        Some(&json!("/nodes/7/weights/0"))
    );
    // The other reader does not know pointers.
    doc.json["animations"][0]["channels"].as_array_mut().unwrap().pop();
    let mut gltf = doc.open().unwrap();
    hang(&mut gltf, &rest, &[1], &chain(3), 2);
    check(&gltf, &rest, &shown);
}

#[test]
fn what_cannot_hang_is_refused_and_nothing_is_changed() {
    let doc = shared();
    let rest = doc.rest().unwrap();
    let joints = chain(2);
    let refused = |nodes: &[usize], joints: &[NewJoint<'_>], indices: &[u16], weights: &[f32]| {
        let mut gltf = doc.open().unwrap();
        let skin = NewSkin { name: "limb", joints, each: 1, indices, weights };
        assert!(gltf.add_skin(&rest, nodes, &skin).is_err());
        assert_eq!(gltf.json(), doc.open().unwrap().json());
    };
    let (zeros, ones) = ([0; 6], [1.0; 6]);
    refused(&[2], &joints, &zeros, &ones);
    refused(&[9], &joints, &zeros, &ones);
    refused(&[0], &[], &zeros, &ones);
    refused(&[0], &joints, &zeros[1..], &ones[1..]);
    refused(&[0], &joints, &[2; 6], &ones);
    refused(&[0], &joints, &zeros, &[0.0; 6]);
    refused(&[0], &joints, &zeros, &[-1.0; 6]);
    refused(&[0], &joints, &zeros, &[f32::NAN; 6]);
    refused(&[0], &[joints[1], joints[0]], &zeros, &ones);
    refused(&[0], &[NewJoint { scale: [0.0, 1.0, 1.0], ..joints[0] }], &zeros, &ones);
    refused(&[0], &[NewJoint { translation: [f32::NAN; 3], ..joints[0] }], &zeros, &ones);
    let skinned = strip();
    let rest = skinned.rest().unwrap();
    let skin = NewSkin { name: "limb", joints: &joints, each: 1, indices: &zeros, weights: &ones };
    assert!(skinned.open().unwrap().add_skin(&rest, &[0], &skin).is_err(), "it has a skin");
}
