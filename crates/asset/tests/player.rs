//! Clips of documents small enough to know the answer.

use serde_json::{Value, json};
use wirework_asset::{AssetError, ErrorClass, LocalDeltas, Place, Player};

mod make;
use make::{Doc, skinned, triangle};

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// Adds a channel to the only clip.
fn channel(doc: &mut Doc, node: usize, path: &str, interpolation: &str, input: usize, output: usize) {
    if doc.json.get("animations").is_none() {
        doc.json["animations"] = json!([{ "samplers": [], "channels": [] }]);
    }
    let clip = &mut doc.json["animations"][0];
    let samplers = clip["samplers"].as_array_mut().unwrap();
    samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
    let channel = json!({ "sampler": samplers.len() - 1, "target": { "node": node, "path": path } });
    clip["channels"].as_array_mut().unwrap().push(channel);
}

fn track(doc: &mut Doc, node: usize, path: &str, interpolation: &str, times: &[f32], values: &[f32]) {
    let kind = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    let (input, output) = (doc.floats("SCALAR", times), doc.floats(kind, values));
    channel(doc, node, path, interpolation, input, output);
}

fn pose(player: &mut Player<'_>, seconds: f64, deltas: Option<&[LocalDeltas]>) -> [Vec<[f32; 3]>; 2] {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    player.pose_into(seconds, deltas, &mut positions, &mut normals).unwrap();
    assert_eq!(positions.len(), normals.len());
    [positions, normals]
}

/// The positions of the first clip at a time.
fn at(doc: &Doc, seconds: f64) -> Vec<[f32; 3]> {
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    assert!(player.warnings().is_empty(), "{:?}", player.warnings());
    let [positions, _] = pose(&mut player, seconds, None);
    positions
}

fn refused(doc: &Doc) -> AssetError {
    let gltf = doc.open().unwrap();
    gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap_err()
}

/// A turn about z, in degrees, as a quaternion.
fn turn(degrees: f32) -> [f32; 4] {
    let (sin, cos) = (degrees / 2.0).to_radians().sin_cos();
    [0.0, 0.0, sin, cos]
}

#[test]
fn each_interpolation_is_its_closed_form() {
    let keys = [1.0, 3.0];
    let linear = [1.0, 0.0, 0.0, 5.0, 4.0, 0.0];
    // In-tangent, value, out-tangent of each key.
    let cubic =
        [[9.0, 9.0, 9.0, 1.0, 0.0, 0.0, 0.5, 0.0, 1.0], [0.0, -1.0, 0.0, 5.0, 4.0, 0.0, 9.0, 9.0, 9.0]];
    for (interpolation, values) in
        [("STEP", &linear[..]), ("LINEAR", &linear), ("CUBICSPLINE", cubic.as_flattened())]
    {
        let mut doc = triangle(json!({ "translation": [7, 7, 7] }));
        track(&mut doc, 0, "translation", interpolation, &keys, values);
        for seconds in [-1.0_f64, 0.0, 1.0, 1.5, 2.0, 2.9999, 3.0, 100.0] {
            let x = ((seconds - 1.0) / 2.0).clamp(0.0, 1.0) as f32;
            let want = match interpolation {
                "STEP" if seconds < 3.0 => [1.0, 0.0, 0.0],
                "STEP" => [5.0, 4.0, 0.0],
                "LINEAR" => [1.0 + 4.0 * x, 4.0 * x, 0.0],
                _ => {
                    let (x2, x3) = (x * x, x * x * x);
                    let (one, leave) = (3.0 * x2 - 2.0 * x3, 2.0 * (x3 - 2.0 * x2 + x));
                    let arrive = 2.0 * (x3 - x2);
                    [1.0 + 4.0 * one + 0.5 * leave, 4.0 * one - arrive, leave]
                }
            };
            let found = at(&doc, seconds)[0];
            assert!(close(found, want), "{interpolation} at {seconds}: {found:?} for {want:?}");
        }
    }
}

#[test]
fn rotations_take_the_shorter_way_at_an_even_pace() {
    let far = turn(90.0).map(|c| -c);
    for to in [turn(90.0), far] {
        let mut doc = triangle(json!({}));
        track(&mut doc, 0, "rotation", "LINEAR", &[0.0, 3.0], &[turn(0.0), to].concat());
        for degrees in [0.0_f32, 10.0, 30.0, 45.0, 77.0, 90.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let found = at(&doc, f64::from(degrees) / 30.0);
            assert!(close(found[1], [cos, sin, 0.0]) && close(found[2], [-sin, cos, 0.0]), "{found:?}");
        }
    }
    // Half the way of a spline without tangents is the mean, whose length is not 1.
    let mut doc = triangle(json!({}));
    let zero = [0.0; 4];
    let values = [zero, turn(0.0), zero, zero, turn(90.0), zero].concat();
    track(&mut doc, 0, "rotation", "CUBICSPLINE", &[0.0, 1.0], &values);
    let half = 0.5_f32.sqrt();
    assert!(close(at(&doc, 0.5)[1], [half, half, 0.0]));
    // A quaternion without length is no rotation.
    let mut doc = triangle(json!({}));
    track(&mut doc, 0, "rotation", "LINEAR", &[0.0, 1.0], &[0.0; 8]);
    assert!(close(at(&doc, 0.5)[1], [1.0, 0.0, 0.0]));
}

#[test]
fn rotations_and_weights_may_be_normalised_integers() {
    let half = 0.5_f32.sqrt();
    let (byte, short) = ((half * 127.0).round() as i8, (half * 32_767.0).round() as i16);
    let shorts: Vec<u8> =
        [0, 0, 0, 32_767, 0, 0, short, short].iter().flat_map(|c| c.to_le_bytes()).collect();
    let words: Vec<u8> =
        [0, 0, 0, 65_535_u16, 0, 0, 46_340, 46_340].iter().flat_map(|c| c.to_le_bytes()).collect();
    let bytes: Vec<u8> = [0, 0, 0, 127, 0, 0, byte, byte].iter().map(|c| c.to_le_bytes()[0]).collect();
    let encodings =
        [(5120, bytes), (5121, vec![0, 0, 0, 255, 0, 0, 180, 180]), (5122, shorts), (5123, words)];
    for (component, bytes) in encodings {
        let mut doc = triangle(json!({}));
        let input = doc.floats("SCALAR", &[0.0, 1.0]);
        let output = doc.accessor(
            json!({ "componentType": component, "type": "VEC4", "count": 2, "normalized": true }),
            &bytes,
        );
        channel(&mut doc, 0, "rotation", "LINEAR", input, output);
        assert!(close(at(&doc, 1.0)[1], [0.0, 1.0, 0.0]), "{component}: {:?}", at(&doc, 1.0));
        let (sin, cos) = 30.0_f32.to_radians().sin_cos();
        assert!(close(at(&doc, 1.0 / 3.0)[1], [cos, sin, 0.0]), "{component}");
        doc.json["accessors"][output]["normalized"] = json!(false);
        assert_eq!(refused(&doc).place, Place::Pointer(format!("/accessors/{output}")));
    }
    let mut doc = morphing();
    let input = doc.floats("SCALAR", &[0.0, 1.0]);
    let scalars = json!({ "componentType": 5121, "type": "SCALAR", "count": 4, "normalized": true });
    let output = doc.accessor(scalars, &[0, 0, 51, 255]);
    channel(&mut doc, 0, "weights", "LINEAR", input, output);
    assert!(close(at(&doc, 0.5)[0], [0.1, 0.0, 1.0]), "{:?}", at(&doc, 0.5));
}

#[test]
fn nodes_carry_each_other_and_mirror() {
    let mut doc = triangle(json!({ "translation": [1, 0, 0], "scale": [-1, 1, 1] }));
    doc.node(json!({ "children": [0], "translation": [0, 0, 5] }));
    doc.node(json!({ "children": [1] }));
    track(&mut doc, 2, "scale", "LINEAR", &[0.0, 1.0], &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    track(&mut doc, 1, "rotation", "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)].concat());
    let found = at(&doc, 1.0);
    // Mirrored, moved to x = 1, turned to y, moved to z = 5, three times as large.
    assert!(close(found[0], [0.0, 3.0, 15.0]) && close(found[1], [0.0, 0.0, 15.0]), "{found:?}");
    assert!(close(found[2], [-3.0, 3.0, 15.0]), "{found:?}");
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    assert_eq!((player.duration(), player.moves()), (1.0, true));
    let [_, normals] = pose(&mut player, 0.7, None);
    assert!(close(normals[0], [0.0, 0.0, 1.0]));
}

/// A strip along y of three pairs of vertices, half way up a second joint, in a node that does not count.
fn strip() -> Doc {
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

#[test]
fn a_strip_of_two_bones_bends() {
    let mut doc = strip();
    track(&mut doc, 2, "rotation", "LINEAR", &[0.0, 2.0], &[turn(0.0), turn(120.0)].concat());
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    for degrees in [0.0_f32, 30.0, 60.0, 90.0, 120.0] {
        let [positions, normals] = pose(&mut player, f64::from(degrees) / 60.0, None);
        let (sin, cos) = degrees.to_radians().sin_cos();
        assert!(close(positions[1], [1.0, 0.0, 0.0]) && close(normals[1], [0.0, 1.0, 0.0]));
        // About (0, 1, 0): wholly, and by the mean of turned and unturned.
        assert!(close(positions[5], [cos - sin, 1.0 + sin + cos, 0.0]), "{degrees}: {:?}", positions[5]);
        assert!(close(positions[3], [f32::midpoint(1.0, cos), 1.0 + sin / 2.0, 0.0]), "{degrees}");
        assert!(close(normals[5], [-sin, cos, 0.0]), "{degrees}");
    }
}

/// A triangle with two targets, along x and along z, weights from the mesh.
fn morphing() -> Doc {
    let mut doc = triangle(json!({}));
    let x = doc.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    let z = doc.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let lean = doc.floats("VEC3", &[0.0, 1.0, 0.0].repeat(3));
    doc.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": x, "NORMAL": lean }, { "POSITION": z }]);
    doc.json["meshes"][0]["weights"] = json!([0, 0.5]);
    doc
}

#[test]
fn weights_come_from_the_clip_else_the_node_else_the_mesh() {
    let mut doc = morphing();
    track(&mut doc, 0, "translation", "LINEAR", &[0.0], &[0.0, 0.0, 0.0]);
    assert!(close(at(&doc, 0.0)[0], [0.0, 0.0, 1.0]));
    doc.json["nodes"][0]["weights"] = json!([2, 0]);
    assert!(close(at(&doc, 0.0)[0], [2.0, 0.0, 0.0]));
    track(&mut doc, 0, "weights", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 1.0, 3.0]);
    assert!(close(at(&doc, 0.5)[0], [0.5, 0.0, 3.0]));
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    let [_, normals] = pose(&mut player, 1.0, None);
    let half = 0.5_f32.sqrt();
    assert!(close(normals[0], [0.0, half, half]), "{normals:?}");
    assert!(close(pose(&mut player, 0.0, None)[0][0], [0.0; 3]), "nothing of the time before is left");

    // At each key two in-tangents, two values, two out-tangents.
    let mut doc = morphing();
    let values = [0.0, 0.0, 1.0, 0.0, 4.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
    track(&mut doc, 0, "weights", "CUBICSPLINE", &[0.0, 2.0], &values);
    assert!(close(at(&doc, 1.0)[0], [1.0 + 0.125 * 2.0 * 4.0, 0.0, 1.0]), "{:?}", at(&doc, 1.0));
}

#[test]
fn deltas_are_added_after_morphs_and_before_skins() {
    let mut doc = strip();
    let up = doc.floats("VEC3", &[0.0, 0.0, 1.0].repeat(6));
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": up }]);
    track(&mut doc, 2, "rotation", "LINEAR", &[0.0, 1.0], &[turn(0.0), turn(90.0)].concat());
    track(&mut doc, 0, "weights", "LINEAR", &[0.0, 1.0], &[0.0, 3.0]);
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let mut moved = rest.positions.clone();
    moved[5][0] += 0.5;
    let normals = vec![[1.0, 0.0, 0.0]; 6];
    let deltas = [rest.to_local(0, &moved, Some(&normals), None)];
    let mut player = gltf.player(&rest, Some(0)).unwrap();
    let [positions, normals] = pose(&mut player, 1.0, Some(&deltas));
    // Vertex 5 is at (1.5, 1) from the joint, which turns by a right angle.
    assert!(close(positions[5], [-1.0, 2.5, 3.0]), "{:?}", positions[5]);
    assert!(close(positions[4], [-1.0, 1.0, 3.0]) && close(normals[4], [0.0, 1.0, 0.0]), "{normals:?}");
    assert!(close(normals[0], [1.0, 0.0, 0.0]));
    let mut still = gltf.player(&rest, None).unwrap();
    assert_eq!((still.duration(), still.moves()), (0.0, false));
    assert_eq!(pose(&mut still, 1.0, Some(&deltas))[0], moved);
    assert_eq!(pose(&mut still, 1.0, Some(&[]))[0], rest.positions, "without deltas nothing moves");
    let short = [LocalDeltas { positions: vec![[1.0; 3]], ..LocalDeltas::default() }];
    assert_eq!(pose(&mut still, 0.0, Some(&short))[0][1..], rest.positions[1..]);
}

#[test]
fn without_a_clip_all_is_as_at_rest() {
    for doc in [skinned([0.3, 0.3, 0.0, 0.0]), skinned([0.0; 4]), morphing(), strip()] {
        let gltf = doc.open().unwrap();
        let rest = gltf.rest().unwrap();
        let [positions, normals] = pose(&mut gltf.player(&rest, None).unwrap(), 3.0, None);
        assert_eq!(positions, rest.positions);
        assert_eq!(Some(normals), rest.blocks[0].normals);
    }
}

#[test]
fn tracks_of_no_property_of_a_node_are_passed_over() {
    let mut doc = triangle(json!({}));
    track(
        &mut doc,
        0,
        "translation",
        "LINEAR",
        &[0.0, 0.0, 2.0],
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0, 0.0, 0.0],
    );
    let clip = &mut doc.json["animations"][0];
    let pointer = json!({ "KHR_animation_pointer": { "pointer": "/materials/0/alphaCutoff" } });
    for target in [
        json!({ "path": "pointer", "extensions": pointer }),
        json!({ "path": "rotation" }),
        json!({ "node": 0, "path": "colour\n" }),
    ] {
        clip["channels"].as_array_mut().unwrap().push(json!({ "sampler": 0, "target": target }));
    }
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    let codes: Vec<_> = player.warnings().iter().map(|w| w.code).collect();
    assert_eq!(codes, ["key-times", "track", "track", "track"]);
    assert!(player.warnings().iter().all(|w| !w.to_string().contains('\n')));
    assert_eq!(player.duration(), 2.0);
    // Of two keys at one time the second counts.
    assert!(close(pose(&mut player, 0.0, None)[0][0], [1.0, 0.0, 0.0]));
    assert!(close(pose(&mut player, f64::NAN, None)[0][0], [0.0; 3]), "no time is the first key");
}

fn sampler(doc: &mut Doc) -> &mut Value {
    &mut doc.json["animations"][0]["samplers"][0]
}

#[test]
fn faults_of_a_clip_are_named_by_their_place() {
    type Fault = (&'static str, fn(&mut Doc));
    let faults: [Fault; 14] = [
        ("/animations", |doc| doc.json["animations"] = json!([])),
        ("/animations/0", |doc| doc.json["animations"][0] = json!({ "channels": [] })),
        ("/animations/0/channels/0/sampler", |doc| {
            doc.json["animations"][0]["channels"][0]["sampler"] = json!(1);
        }),
        ("/animations/0/channels/0/target/node", |doc| {
            doc.json["animations"][0]["channels"][0]["target"]["node"] = json!(9);
        }),
        ("/animations/0/channels/0/target/node", |doc| {
            doc.json["animations"][0]["channels"][0]["target"]["path"] = json!("weights");
        }),
        ("/animations/0/channels/0/target/path", |doc| {
            doc.json["animations"][0]["channels"][0]["target"]["path"] = json!(1);
        }),
        ("/animations/0/channels/0/target/node", |doc| {
            doc.json["nodes"][0] =
                json!({ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
        }),
        ("/animations/0/channels/1/target", |doc| {
            let again = doc.json["animations"][0]["channels"][0].clone();
            doc.json["animations"][0]["channels"].as_array_mut().unwrap().push(again);
        }),
        ("/animations/0/samplers/0/interpolation", |doc| sampler(doc)["interpolation"] = json!("linear")),
        ("/accessors/3", |doc| sampler(doc)["interpolation"] = json!("CUBICSPLINE")),
        ("/accessors/3", |doc| sampler(doc)["input"] = json!(3)),
        ("/accessors/4", |doc| {
            let falling = doc.floats("SCALAR", &[1.0, 0.5]);
            sampler(doc)["input"] = json!(falling);
        }),
        ("/accessors/4", |doc| {
            let endless = doc.floats("SCALAR", &[0.0, f32::INFINITY]);
            sampler(doc)["input"] = json!(endless);
        }),
        ("/accessors/4", |doc| {
            let values = doc.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0]);
            sampler(doc)["output"] = json!(values);
        }),
    ];
    for (pointer, spoil) in faults {
        let mut doc = triangle(json!({}));
        track(&mut doc, 0, "translation", "LINEAR", &[0.0, 1.0], &[0.0; 6]);
        spoil(&mut doc);
        let error = refused(&doc);
        assert_eq!(error.place, Place::Pointer(pointer.into()), "{error}");
        assert_eq!((error.class, error.file.as_str()), (ErrorClass::Asset, "made.glb"));
    }
    let doc = triangle(json!({}));
    assert!(refused(&doc).to_string().contains("a clip 0"));
    let (gltf, other) = (doc.open().unwrap(), strip().rest().unwrap());
    assert!(gltf.player(&other, None).unwrap_err().found.contains("another document"));
}

#[test]
fn a_pose_beyond_floats_is_an_error() {
    let huge = [0.0, 0.0, 0.0, 3e38, 0.0, 0.0];
    let mut doc = triangle(json!({}));
    doc.node(json!({ "children": [0], "scale": [1e10, 1, 1] }));
    track(&mut doc, 0, "translation", "LINEAR", &[0.0, 1.0], &huge);
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    assert!(player.pose_into(0.0, None, &mut positions, &mut normals).is_ok());
    let error = player.pose_into(1.0, None, &mut positions, &mut normals).unwrap_err();
    assert_eq!(error.place, Place::Pointer("/meshes/0/primitives/0".into()), "{error}");
    assert!(player.pose_into(0.0, None, &mut positions, &mut normals).is_ok(), "it can be played on");
    assert_eq!(positions.len(), 3);
}
