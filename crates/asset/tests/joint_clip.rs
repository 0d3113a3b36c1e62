//! Tracks of joints, in clips of their own and in clips that are there, and clips that are copied.

use serde_json::{Value, json};
use wirework_asset::{Clip, Gltf, JointTrack, Limits, Place, Tracks, WeightTrack};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, triangle};
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::{close, pose, strip, track};
mod moving;
use moving::scene;

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

fn joint(node: usize, rotations: &[[f32; 4]]) -> JointTrack {
    JointTrack { node, rotations: rotations.to_vec(), ..JointTrack::default() }
}

fn add(gltf: &mut Gltf, clip: &Clip, joints: &[JointTrack], source: Option<usize>) -> Option<usize> {
    gltf.add_tracks(clip, &Tracks { times: &[0.0, 1.0, 2.0], weights: &[], joints, source }).unwrap()
}

fn new() -> Clip {
    Clip::New("limb".to_owned())
}

/// The values of the output of a channel, read back by another reader.
fn values(gltf: &Gltf, clip: usize, channel: usize) -> (Vec<f32>, Vec<f32>) {
    let glb = gltf.to_glb().unwrap();
    let doc = gltf::Gltf::from_slice_without_validation(&glb).unwrap();
    let blob = doc.blob.as_deref().unwrap();
    let channel = doc.animations().nth(clip).unwrap().channels().nth(channel).unwrap();
    let reader = channel.reader(|_| Some(blob));
    let out = match reader.read_outputs().unwrap() {
        gltf::animation::util::ReadOutputs::Rotations(values) => values.into_f32().flatten().collect(),
        gltf::animation::util::ReadOutputs::MorphTargetWeights(values) => values.into_f32().collect(),
        gltf::animation::util::ReadOutputs::Translations(values)
        | gltf::animation::util::ReadOutputs::Scales(values) => values.flatten().collect(),
    };
    (reader.read_inputs().unwrap().collect(), out)
}

#[test]
fn joints_turn_the_shorter_way() {
    let mut gltf = strip().open().unwrap();
    // A right angle about z, twice, of other lengths and signs.
    let turns = [[0.0, 0.0, 0.0, 2.0], [0.0, 0.0, -HALF, -HALF], [0.0, 0.0, 3.0, 0.0]];
    assert_eq!(add(&mut gltf, &new(), &[joint(2, &turns)], None), Some(0));
    let (times, written) = values(&gltf, 0, 0);
    assert_eq!(times, [0.0, 1.0, 2.0]);
    for (k, want) in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, HALF, HALF, 0.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
        assert!((written[k] - want).abs() < 1e-6, "{written:?}");
    }
    let animation = &gltf.json()["animations"][0];
    assert_eq!(animation["samplers"][0]["interpolation"], "LINEAR");
    assert_eq!(animation["channels"], json!([{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }]));
    let input = animation["samplers"][0]["input"].as_u64().unwrap() as usize;
    let input = &gltf.json()["accessors"][input];
    assert_eq!((&input["min"], &input["max"]), (&json!([0.0]), &json!([2.0])));
    let rest = gltf.rest().unwrap();
    let [positions, _] = pose(&mut gltf.player(&rest, Some(0)).unwrap(), 0.5, None);
    // Half a right angle about (0, 1): vertex 5 stands at (1, 1) from there.
    assert!(close(positions[5], [0.0, 1.0 + std::f32::consts::SQRT_2, 0.0]), "{:?}", positions[5]);
}

#[test]
fn what_never_changes_has_one_key_or_none() {
    let three = |value: [f32; 3]| vec![value; 3];
    let own = JointTrack {
        node: 2,
        translations: three([0.0, 1.0, 0.0]),
        rotations: vec![[0.0, 0.0, 0.0, -5.0]; 3],
        scales: three([1.0; 3]),
    };
    let doc = strip();
    let mut gltf = doc.open().unwrap();
    assert_eq!(add(&mut gltf, &new(), std::slice::from_ref(&own), None), None);
    assert_eq!(gltf.json(), doc.open().unwrap().json(), "nothing is added");
    let mut gltf = doc.open().unwrap();
    let other = JointTrack { scales: three([2.0; 3]), ..own.clone() };
    add(&mut gltf, &new(), &[other], None);
    let channels = &gltf.json()["animations"][0]["channels"];
    assert_eq!(channels, &json!([{ "sampler": 0, "target": { "node": 2, "path": "scale" } }]));
    assert_eq!(values(&gltf, 0, 0), (vec![0.0], vec![2.0; 3]));
    // What the copied clip moves is held by a key even where that is the node's own.
    let mut doc = strip();
    track(&mut doc, 2, "rotation", "LINEAR", &[0.0, 4.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, HALF, HALF]);
    let mut gltf = doc.open().unwrap();
    assert_eq!(add(&mut gltf, &new(), &[own], Some(0)), Some(1));
    assert_eq!(gltf.json()["animations"][1]["channels"].as_array().unwrap().len(), 1);
    assert_eq!(values(&gltf, 1, 0), (vec![0.0], vec![0.0, 0.0, 0.0, -1.0]));
}

/// All places of all vertices when a clip is played.
fn played(gltf: &Gltf, clip: usize, seconds: f64) -> Vec<[f32; 3]> {
    pose(&mut gltf.player(&gltf.rest().unwrap(), Some(clip)).unwrap(), seconds, None)[0].clone()
}

/// The clip of the scene, with a channel of a material besides.
fn with_pointer() -> Doc {
    let mut doc = scene();
    let pointer = json!({ "KHR_animation_pointer": { "pointer": "/nodes/5/extras" } });
    let clip = &mut doc.json["animations"][0];
    let samplers = clip["samplers"].as_array_mut().unwrap();
    // As names and other members of the source, which say nothing of ours.
    samplers[0]["extras"] = json!({ "kept": true });
    clip["name"] = json!("walk");
    clip["extras"] = json!("of the walk");
    let channels = clip["channels"].as_array_mut().unwrap();
    channels.push(json!({ "sampler": 1, "target": { "path": "pointer", "extensions": pointer } }));
    doc
}

#[test]
fn a_new_clip_may_play_another_too() {
    let doc = with_pointer();
    let mut gltf = doc.open().unwrap();
    let before = gltf.json().clone();
    let turns = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, HALF, HALF], [0.0, 0.0, 0.0, 1.0]];
    let new = add(&mut gltf, &new(), &[joint(2, &turns)], Some(0)).unwrap();
    let json = gltf.json();
    assert_eq!(json["animations"][0], before["animations"][0], "the source stays");
    for table in ["accessors", "bufferViews"] {
        let (old, now) = (before[table].as_array().unwrap(), json[table].as_array().unwrap());
        assert_eq!(now[..old.len()], old[..]);
        assert_eq!(now.len(), old.len() + 2, "times and values of one track");
    }
    let (old, now) = (&before["animations"][0], &json["animations"][new]);
    assert_eq!((&now["name"], now.get("extras")), (&json!("limb"), None));
    let target = |channel: &Value| channel["target"].clone();
    let [old_channels, channels] = [old, now].map(|clip| clip["channels"].as_array().unwrap().clone());
    // The turn of node 2 came first; ours comes last.
    let mut expected: Vec<Value> = old_channels[1..].iter().map(target).collect();
    expected.push(json!({ "node": 2, "path": "rotation" }));
    assert_eq!(channels.iter().map(target).collect::<Vec<Value>>(), expected);
    for (channel, from) in channels.iter().zip(&old_channels[1..]) {
        let sampler = |clip: &Value, channel: &Value| {
            clip["samplers"][channel["sampler"].as_u64().unwrap() as usize].clone()
        };
        assert_eq!(sampler(now, channel), sampler(old, from));
    }
    assert_eq!(now["samplers"].as_array().unwrap().len(), old["samplers"].as_array().unwrap().len());
    // All but what hangs on node 2 is where the walk has it.
    let (ours, walk) = (played(&gltf, new, 1.0), played(&gltf, 0, 1.0));
    let same = |v: usize| ours[v] == walk[v];
    assert!(!(4..6).any(same) && (0..2).chain(6..18).all(same), "{ours:?} {walk:?}");
}

#[test]
fn a_property_has_one_channel_by_whatever_name() {
    let mut doc = scene();
    let pointers =
        ["/nodes/2/rotation", "/nodes/2/weights/0", "/nodes/2", "/nodes/x/rotation", "/nodes/5/rotation"];
    for pointer in pointers {
        let pointer = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        let channel = json!({ "sampler": 0, "target": { "path": "pointer", "extensions": pointer } });
        doc.json["animations"][0]["channels"].as_array_mut().unwrap().push(channel);
    }
    let mut gltf = doc.open().unwrap();
    let turns = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, HALF, HALF], [0.0, 0.0, 0.0, 1.0]];
    let new = add(&mut gltf, &new(), &[joint(2, &turns)], Some(0)).unwrap();
    let channels = gltf.json()["animations"][new]["channels"].as_array().unwrap();
    let kept = channels
        .iter()
        .filter_map(|channel| channel.pointer("/target/extensions/KHR_animation_pointer/pointer")?.as_str());
    assert_eq!(kept.collect::<Vec<&str>>(), pointers[1..]);
}

#[test]
fn a_channel_that_is_there_plays_ours() {
    let doc = scene();
    let mut gltf = doc.open().unwrap();
    let before = gltf.json()["animations"][0].clone();
    let turns = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, HALF, HALF], [0.0, 0.0, 0.0, 1.0]];
    assert_eq!(add(&mut gltf, &Clip::Into(0), &[joint(2, &turns), joint(1, &turns)], Some(9)), Some(0));
    let after = &gltf.json()["animations"][0];
    let (old, now) = (before["samplers"].as_array().unwrap(), after["samplers"].as_array().unwrap());
    assert_eq!((&now[..old.len()], now.len()), (&old[..], old.len() + 2));
    let (old, now) = (before["channels"].as_array().unwrap(), after["channels"].as_array().unwrap());
    assert_eq!(now[0], json!({ "sampler": 6, "target": { "node": 2, "path": "rotation" } }));
    assert_eq!(now[1..old.len()], old[1..]);
    assert_eq!(now[old.len()..], [json!({ "sampler": 7, "target": { "node": 1, "path": "rotation" } })]);
    let weights = [WeightTrack { node: 5, times: None, weights: vec![0.0; 6] }];
    let tracks = Tracks { times: &[0.0, 1.0, 2.0], weights: &weights, ..Tracks::default() };
    let error = gltf.add_tracks(&Clip::Into(0), &tracks).unwrap_err();
    assert_eq!(error.place, Place::Pointer("/animations/0/channels/5".into()));
}

#[test]
fn a_matrix_becomes_what_makes_it() {
    let mut doc = strip();
    doc.json["nodes"][2] =
        json!({ "matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 0, 1, 0, 1], "name": "m" });
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let moved = JointTrack {
        node: 2,
        translations: vec![[0.0, 1.0, 0.0], [1.0; 3], [2.0; 3]],
        ..JointTrack::default()
    };
    add(&mut gltf, &new(), &[moved], None);
    let node = &gltf.json()["nodes"][2];
    assert!(node.get("matrix").is_none() && node["name"] == "m" && node["scale"] == json!([2.0, 2.0, 2.0]));
    let again = gltf.rest().unwrap();
    assert!(rest.positions.iter().zip(&again.positions).all(|(a, b)| close(*a, *b)));
    let [positions, _] = pose(&mut gltf.player(&again, Some(0)).unwrap(), 0.0, None);
    assert!(rest.positions.iter().zip(&positions).all(|(a, b)| close(*a, *b)));
    doc.json["nodes"][2]["matrix"][5] = json!(0.5);
    let mut gltf = doc.open().unwrap();
    let tracks = Tracks { times: &[0.0], joints: &[joint(2, &[[0.0, 0.0, 0.0, 1.0]])], ..Tracks::default() };
    let error = gltf.add_tracks(&new(), &tracks).unwrap_err();
    assert_eq!(error.place, Place::Pointer("/nodes/2/matrix".into()));
}

#[test]
fn tracks_that_cannot_be_are_refused_and_nothing_is_added() {
    let doc = triangle(json!({}));
    let unit = [0.0, 0.0, 0.0, 1.0];
    let refused = |times: &[f32], joints: &[JointTrack], source: Option<usize>| {
        let mut gltf = doc.open().unwrap();
        let tracks = Tracks { times, joints, source, ..Tracks::default() };
        assert!(gltf.add_tracks(&new(), &tracks).is_err());
        assert_eq!(gltf.json(), doc.open().unwrap().json());
    };
    let ends = [0.0, 1.0];
    refused(&[1.0, 1.0], &[joint(0, &[unit; 2])], None);
    refused(&[-1.0, 1.0], &[joint(0, &[unit; 2])], None);
    refused(&[0.0, f32::NAN], &[joint(0, &[unit; 2])], None);
    refused(&ends, &[joint(0, &[unit; 3])], None);
    refused(&ends, &[joint(1, &[unit; 2])], None);
    refused(&ends, &[joint(0, &[unit, [0.0; 4]])], None);
    refused(&ends, &[joint(0, &[unit, [f32::INFINITY; 4]])], None);
    refused(&ends, &[joint(0, &[unit; 2]), joint(0, &[unit; 2])], None);
    refused(&ends, &[joint(0, &[unit; 2])], Some(0));
    let far = JointTrack { translations: vec![[f32::NAN; 3]; 2], ..JointTrack::default() };
    refused(&ends, &[far], None);
}

#[test]
fn old_bytes_are_a_prefix() {
    let glb = scene().glb();
    let mut gltf = Gltf::from_slice(&glb, "scene", &Limits::default()).unwrap();
    add(
        &mut gltf,
        &new(),
        &[joint(2, &[[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]])],
        Some(0),
    );
    let bin = |glb: &[u8]| {
        let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        glb[28 + json..].to_vec()
    };
    assert!(bin(&gltf.to_glb().unwrap()).starts_with(&bin(&glb)));
}
