//! Clips that are malformed, and what is passed over in others.

use serde_json::{Value, json};
use wirework_asset::{ErrorClass, Place};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, triangle};
mod play;
use play::{close, pose, refused, strip, track};

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
