//! Clips of documents small enough to know the answer.

use serde_json::json;
use wirework_asset::{LocalDeltas, Place};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, skinned, triangle};
mod play;
use play::{channel, close, pose, refused, strip, track};

/// The positions of the first clip at a time.
fn at(doc: &Doc, seconds: f64) -> Vec<[f32; 3]> {
    let gltf = doc.open().unwrap();
    let mut player = gltf.player(&gltf.rest().unwrap(), Some(0)).unwrap();
    assert!(player.warnings().is_empty(), "{:?}", player.warnings());
    let [positions, _] = pose(&mut player, seconds, None);
    positions
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
