//! Joints beside joints: nothing moves until they do, and then what lies near them.

use std::path::Path;

use serde_json::{Value, json};
use wirework_asset::{Clip, ErrorClass, Gltf, JointTrack, Knot, Limits, Rest, Split, Tracks};

mod make;
use make::{Doc, skinned};
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::{close, pose, strip, track};
mod moving;
use moving::{noise, scene};

const ONE: [f32; 4] = [1.0, 0.0, 0.0, 0.0];

fn knot(along: f64, at: [f64; 3]) -> Knot {
    Knot { along, at }
}

fn split(node: usize, knots: &[Knot]) -> Split<'_> {
    Split { node, along: 0.0, knots }
}

/// How far up the strip vertices of a rest lie.
fn heights(rest: &Rest) -> Vec<f32> {
    rest.positions.iter().map(|p| p[1]).collect()
}

/// Joints and weights of a primitive's first set, as they are written.
fn hanging(gltf: &Gltf, mesh: usize) -> (u64, Vec<[u16; 4]>, Vec<[f32; 4]>) {
    let glb = gltf.to_glb().unwrap();
    let doc = gltf::Gltf::from_slice_without_validation(&glb).unwrap();
    let blob = doc.blob.as_deref().unwrap();
    let primitive = doc.meshes().nth(mesh).unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(blob));
    let accessor = &gltf.json()["meshes"][mesh]["primitives"][0]["attributes"]["JOINTS_0"];
    let kind = &gltf.json()["accessors"][accessor.as_u64().unwrap() as usize]["componentType"];
    let joints = reader.read_joints(0).unwrap().into_u16().collect();
    (kind.as_u64().unwrap(), joints, reader.read_weights(0).unwrap().into_f32().collect())
}

/// What was there is there, but for what splitting has to change.
fn assert_kept(before: &Gltf, after: &Gltf) {
    let (old, new) = (before.json(), after.json());
    for (key, value) in old.as_object().unwrap() {
        match key.as_str() {
            "accessors" | "bufferViews" | "animations" | "materials" | "scenes" | "textures" | "images" => {
                let count = value.as_array().unwrap().len();
                assert_eq!(new[key].as_array().unwrap()[..count], value.as_array().unwrap()[..], "{key}");
            }
            "nodes" => {
                for (k, (old, new)) in
                    value.as_array().unwrap().iter().zip(new[key].as_array().unwrap()).enumerate()
                {
                    for (part, value) in old.as_object().unwrap() {
                        match part.as_str() {
                            "mesh" => {}
                            "children" => {
                                let count = value.as_array().unwrap().len();
                                assert_eq!(
                                    new[part].as_array().unwrap()[..count],
                                    value.as_array().unwrap()[..]
                                );
                            }
                            _ => assert_eq!(new[part], *value, "node {k} {part}"),
                        }
                    }
                }
            }
            "skins" => {
                for (old, new) in value.as_array().unwrap().iter().zip(new[key].as_array().unwrap()) {
                    let joints = old["joints"].as_array().unwrap();
                    assert_eq!(new["joints"].as_array().unwrap()[..joints.len()], joints[..]);
                    assert_eq!(new.get("skeleton"), old.get("skeleton"));
                }
            }
            "meshes" => assert!(new[key].as_array().unwrap().len() >= value.as_array().unwrap().len()),
            "buffers" => {}
            _ => assert_eq!(new[key], *value, "{key}"),
        }
    }
    // The chunk of the old one is a prefix of the new one's.
    let chunk = |gltf: &Gltf| {
        let glb = gltf.to_glb().unwrap();
        let text = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        glb[20 + text + 8..].to_vec()
    };
    let (old_chunk, new_chunk) = (chunk(before), chunk(after));
    let length = old["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
    assert!(new_chunk[..length] == old_chunk[..length]);
}

/// All vertices are where they were: at rest and in all clips.
fn assert_still(before: &Gltf, after: &Gltf, most: f32) {
    let (old, new) = (before.rest().unwrap(), after.rest().unwrap());
    let near = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= most)
    };
    assert!(near(&old.positions, &new.positions));
    for clip in 0..before.clip_names().len() {
        let mut players = [before.player(&old, Some(clip)).unwrap(), after.player(&new, Some(clip)).unwrap()];
        let end = players[0].duration();
        for k in 0..7 {
            let seconds = end * f64::from(k) / 6.0;
            let [a, b] = players.each_mut().map(|player| pose(player, seconds, None));
            assert!(near(&a[0], &b[0]), "clip {clip} at {seconds} s");
        }
    }
}

#[test]
fn what_hangs_on_a_joint_is_shared_out_by_hats() {
    let mut gltf = strip().open().unwrap();
    let before = gltf.clone();
    let rest = gltf.rest().unwrap();
    let knots = [
        knot(-0.5, [0.0, -0.5, 0.0]),
        knot(0.0, [9.0; 3]),
        knot(0.5, [0.0, 0.5, 0.0]),
        knot(2.0, [0.0, 2.0, 0.0]),
    ];
    // Two at each of these places, all below the second pair on the first joint alone, the last on the second alone.
    let along = [0.0, 0.25, 0.5, 1.25, -3.0, 9.0];
    let split = Split { node: 1, along: 0.0, knots: &knots };
    let nodes = gltf.split_joints(&rest, &[split], &along).unwrap();
    assert_eq!(
        nodes,
        [vec![None, None, Some(3), Some(4)]],
        "nothing hangs on the first, and the joint itself is one"
    );
    let json = gltf.json();
    assert_eq!(json["nodes"][3], json!({ "name": "joint_1_1", "translation": [0.0, 0.5, 0.0] }));
    assert_eq!(json["nodes"][1]["children"], json!([2, 3, 4]));
    assert_eq!(json["skins"][0]["joints"], json!([1, 2, 3, 4]));
    let (kind, joints, weights) = hanging(&gltf, 0);
    assert_eq!(kind, 5121);
    let half = [0.5, 0.5, 0.0, 0.0];
    // Half of the fourth hangs on the second joint, which is not split.
    assert_eq!(joints[..4], [[0, 0, 0, 0], [0, 2, 0, 0], [2, 1, 0, 0], [2, 1, 3, 0]]);
    assert_eq!(weights[..4], [ONE, half, half, [0.25, 0.5, 0.25, 0.0]]);
    assert_eq!((joints[4][0], joints[5][0], weights[4], weights[5]), (1, 1, ONE, ONE));
    assert_kept(&before, &gltf);
    assert_still(&before, &gltf, 1e-6);

    // The new joint moves what hangs on it.
    let lift = JointTrack { node: 3, translations: vec![[0.0, 0.5, 4.0]], ..JointTrack::default() };
    gltf.add_tracks(
        &Clip::New("lift".into()),
        &Tracks { times: &[0.0], joints: &[lift], ..Tracks::default() },
    )
    .unwrap();
    let rest = gltf.rest().unwrap();
    let [moved, _] = pose(&mut gltf.player(&rest, Some(0)).unwrap(), 0.0, None);
    let by = |v: usize| moved[v][2] - rest.positions[v][2];
    assert!(
        [(0, 0.0), (1, 2.0), (2, 2.0), (3, 1.0), (4, 0.0)].iter().all(|&(v, z)| (by(v) - z).abs() < 1e-6),
        "{moved:?}"
    );
}

#[test]
fn everything_stays_whatever_shows_and_moves_it() {
    let mut doc = scene();
    doc.json["nodes"][1]["name"] = json!("arm");
    doc.json["nodes"][2]["name"] = json!("arm_1");
    // The same mesh by another skin of the same joints, the other way round and without matrices, and by a node that no scene shows.
    let far = doc.node(json!({ "mesh": 0, "skin": 1 }));
    doc.node(json!({ "mesh": 0, "skin": 0 }));
    doc.json["skins"].as_array_mut().unwrap().push(json!({ "joints": [2, 1, 4] }));
    doc.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(far));
    let before = doc.open().unwrap();
    let mut gltf = before.clone();
    let rest = gltf.rest().unwrap();
    let knots: Vec<Knot> = (1..9)
        .map(|k| knot(f64::from(k) * 0.3, [0.1 * f64::from(k), f64::from(noise(k as usize)), 0.7]))
        .collect();
    let splits = [1, 2].map(|node| Split { node, along: f64::from(node as u8) - 1.0, knots: &knots });
    let nodes = gltf.split_joints(&rest, &splits, &heights(&rest)).unwrap();
    let json = gltf.json();
    assert_kept(&before, &gltf);
    assert_still(&before, &gltf, 1e-6);
    // Each skin has all of the new joints, behind its own.
    let new: Vec<usize> = nodes.iter().flatten().flatten().copied().collect();
    assert!(new.len() > 4);
    assert_eq!(json["skins"][0]["joints"], json!([vec![1, 2], new.clone()].concat()));
    assert_eq!(json["skins"][1]["joints"], json!([vec![2, 1, 4], new.clone()].concat()));
    // Nodes without skin, and the one that nobody reads, keep the mesh; those with skins have one each.
    let mesh = |node: usize| json["nodes"][node]["mesh"].as_u64().unwrap();
    assert_eq!((mesh(3), mesh(5), mesh(7)), (0, 0, 0));
    let own = [mesh(0), mesh(6)];
    assert!(own.contains(&1) && own.contains(&2), "{own:?}");
    assert_eq!(json["meshes"][0], doc.json["meshes"][0]);
    let names: Vec<&str> = new.iter().map(|&node| json["nodes"][node]["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"arm_1_1") && names.contains(&"arm_2"), "{names:?}");
    let mut all: Vec<&str> =
        json["nodes"].as_array().unwrap().iter().filter_map(|node| node["name"].as_str()).collect();
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count, "no name comes twice");
}

#[test]
fn a_vertex_whose_places_are_taken_gets_the_nearer_joint() {
    // Three more joints, so that the first vertex hangs on four; the second has one place left, the third two.
    let mut doc = skinned([0.25; 4]);
    for _ in 0..2 {
        let joint = doc.node(json!({}));
        doc.json["skins"][0]["joints"].as_array_mut().unwrap().push(json!(joint));
    }
    let binds: Vec<f32> = (0..64).map(|k| if k % 16 % 5 == 0 { 1.0 } else { 0.0 }).collect();
    doc.json["skins"][0]["inverseBindMatrices"] = json!(doc.floats("MAT4", &binds));
    let joints = doc.accessor(
        json!({ "componentType": 5121, "type": "VEC4", "count": 3 }),
        &[0, 1, 2, 3, 0, 1, 2, 0, 0, 1, 0, 0],
    );
    // As bytes, normalised.
    let weights = doc.accessor(
        json!({ "componentType": 5121, "normalized": true, "type": "VEC4", "count": 3 }),
        &[64, 64, 64, 63, 155, 50, 50, 0, 200, 55, 0, 0],
    );
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
    let before = doc.open().unwrap();
    let mut gltf = before.clone();
    let rest = gltf.rest().unwrap();
    let knots = [knot(1.0, [1.0, 0.0, 0.0])];
    let splits = [1, 2].map(|node| Split { node, along: 0.0, knots: &knots });
    gltf.split_joints(&rest, &splits, &[0.75, 0.5, 0.25]).unwrap();
    let (_, joints, weights) = hanging(&gltf, 0);
    // 4 and 5 are the new ones of the first and the second joint. The largest share gets the place that is left.
    assert_eq!(joints[0], [4, 5, 2, 3]);
    assert!(weights[0].iter().zip([64, 64, 64, 63]).all(|(w, of)| (w * 255.0 - of as f32).abs() < 1e-4));
    assert_eq!(joints[1], [0, 1, 2, 4]);
    assert!(weights[1].iter().zip([77.5, 50.0, 50.0, 77.5]).all(|(w, of)| (w * 255.0 - of).abs() < 1e-4));
    assert_eq!(joints[2], [0, 1, 4, 5]);
    assert!(weights[2].iter().zip([150.0, 41.25, 50.0, 13.75]).all(|(w, of)| (w * 255.0 - of).abs() < 1e-4));
    assert!(gltf.json()["meshes"][0]["primitives"][0]["attributes"].get("JOINTS_1").is_none());
    assert_still(&before, &gltf, 1e-6);
    assert_kept(&before, &gltf);
}

#[test]
fn many_joints_are_counted_in_sixteen_bits_and_views_may_be_interleaved() {
    let mut doc = strip();
    // Joints and weights of a vertex side by side, the weights sparse besides: a set of its own for the first vertex.
    let mut bytes = Vec::new();
    for v in 0..6_u8 {
        bytes.extend([u8::from(v > 3), 0, 0, 0]);
        bytes.extend(ONE.iter().flat_map(|w| w.to_le_bytes()));
    }
    let view = doc.view(&bytes);
    doc.json["bufferViews"][view]["byteStride"] = json!(20);
    let [at, values] =
        [vec![0, 0], [0.25_f32, 0.75, 0.0, 0.0].iter().flat_map(|w| w.to_le_bytes()).collect()]
            .map(|bytes: Vec<u8>| doc.view(&bytes));
    let list = doc.json["accessors"].as_array_mut().unwrap();
    list.push(json!({ "bufferView": view, "componentType": 5121, "type": "VEC4", "count": 6 }));
    list.push(json!({ "bufferView": view, "byteOffset": 4, "componentType": 5126, "type": "VEC4", "count": 6,
        "sparse": { "count": 1, "indices": { "bufferView": at, "componentType": 5123 }, "values": { "bufferView": values } } }));
    let count = list.len();
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(count - 2), json!(count - 1));
    // 300 joints that move nothing.
    for _ in 0..300 {
        let joint = doc.node(json!({}));
        doc.json["skins"][0]["joints"].as_array_mut().unwrap().push(json!(joint));
    }
    doc.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    track(&mut doc, 2, "translation", "LINEAR", &[0.0, 2.0], &[0.0, 1.0, 0.0, 0.0, 1.0, 4.0]);
    let before = doc.open().unwrap();
    let mut gltf = before.clone();
    let rest = gltf.rest().unwrap();
    let knots = [knot(1.0, [0.0, 1.0, 0.0]), knot(2.0, [0.0, 2.0, 0.0])];
    let along: Vec<f32> = heights(&rest).iter().map(|y| y * 0.7).collect();
    gltf.split_joints(&rest, &[Split { node: 1, along: 0.0, knots: &knots }], &along).unwrap();
    let (kind, joints, weights) = hanging(&gltf, 0);
    assert_eq!((kind, joints[2], weights[0]), (5123, [0, 302, 0, 0], [0.25, 0.75, 0.0, 0.0]));
    let binds = gltf.json()["skins"][0]["inverseBindMatrices"].as_u64().unwrap() as usize;
    let joints = gltf.json()["skins"][0]["joints"].as_array().unwrap().len();
    assert_eq!(gltf.json()["accessors"][binds]["count"], joints);
    assert_kept(&before, &gltf);
    assert_still(&before, &gltf, 1e-6);
}

#[test]
fn what_cannot_be_split_is_refused_and_nothing_is_changed() {
    let doc = strip();
    let rest = doc.rest().unwrap();
    let good = [knot(0.5, [0.0, 0.5, 0.0]), knot(1.0, [0.0, 1.0, 0.0])];
    let along = heights(&rest);
    let refused = |doc: &Doc, splits: &[Split<'_>], along: &[f32], limits: Limits| {
        let mut gltf = Gltf::from_slice(&doc.glb(), "made.glb", &limits).unwrap();
        let before = gltf.json().clone();
        let error = gltf.split_joints(&rest, splits, along).unwrap_err();
        assert_eq!(*gltf.json(), before);
        error
    };
    let all = Limits::default();
    refused(&doc, &[split(7, &good)], &along, all);
    refused(&doc, &[split(1, &good), split(1, &good)], &along, all);
    refused(&doc, &[split(1, &[good[1], good[0]])], &along, all);
    refused(&doc, &[split(1, &[knot(f64::NAN, [0.0; 3])])], &along, all);
    refused(&doc, &[split(1, &[knot(0.5, [f64::INFINITY, 0.0, 0.0])])], &along, all);
    refused(&doc, &[split(1, &good)], &along[1..], all);
    refused(&doc, &[split(1, &good)], &[f32::NAN; 6], all);
    let far = refused(&doc, &[split(1, &[knot(0.5, [1e300; 3])])], &along, all);
    assert!(far.to_string().contains("/skins/0"), "{far}");
    let error = refused(&doc, &[split(1, &good)], &along, Limits { nodes: 3, ..all });
    assert_eq!(error.class, ErrorClass::Limit);
    let mut broken = strip();
    broken.json["skins"].as_array_mut().unwrap().push(json!({ "joints": [1], "inverseBindMatrices": 0 }));
    let error = refused(&broken, &[split(1, &good)], &along, all);
    assert!(error.to_string().contains("/accessors/0"), "{error}");
    // Nothing to split changes nothing.
    let mut gltf = doc.open().unwrap();
    assert_eq!(
        gltf.split_joints(&rest, &[split(0, &good), split(2, &[])], &along).unwrap(),
        [vec![None; 2], vec![]]
    );
    assert_eq!(*gltf.json(), *doc.open().unwrap().json());
    assert!(close(rest.positions[0], gltf.rest().unwrap().positions[0]));
}

#[test]
fn real_characters_stay_as_they_are() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets/rigged");
    for name in ["cesium_man.glb", "fox.glb", "fox_meshopt.glb", "robot.glb"] {
        let path = folder.join(name);
        if !path.exists() {
            eprintln!("the shared assets are not present: {name} is passed over");
            continue;
        }
        let before = Gltf::read(&path, &Limits::default()).unwrap();
        let mut gltf = before.clone();
        let rest = gltf.rest().unwrap();
        let bounds =
            |pick: fn(f32, f32) -> f32| rest.positions.iter().flatten().copied().reduce(pick).unwrap();
        let size = bounds(f32::max) - bounds(f32::min);
        let knots: Vec<Knot> =
            (0..9).map(|k| knot(f64::from(k) / 8.0, [0.05 * f64::from(k), 0.1, 0.0])).collect();
        let joints = gltf.joint_nodes();
        let splits: Vec<Split<'_>> =
            joints.iter().map(|&node| Split { node, along: 0.4, knots: &knots }).collect();
        let along: Vec<f32> = rest.positions.iter().map(|p| p[1] / size).collect();
        let new = gltf.split_joints(&rest, &splits, &along).unwrap();
        assert!(new.iter().flatten().flatten().count() > 20, "{name}");
        assert_still(&before, &gltf, 1e-6 * size);
        let plain = |gltf: &Gltf| -> Value { gltf.json()["animations"].clone() };
        assert_eq!(plain(&before), plain(&gltf));
        if name != "fox_meshopt.glb" {
            assert_kept(&before, &gltf);
        }
    }
}
