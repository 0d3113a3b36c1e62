//! Faults in what the effect does not touch: told once, passed through, refused with `--strict`.

use serde_json::{Value, json};

use crate::document::chunks;
use crate::make::{Doc, triangle};
use crate::place::Place;

/// A triangle that [`crate::place::LIFT`] lifts, with faults of every kind in what nothing reads.
fn faulty() -> (Doc, Vec<(&'static str, &'static str)>) {
    let mut doc = triangle(json!({}));
    doc.json["accessors"][0]["min"] = json!([0, 0, 0]);
    doc.json["accessors"][0]["max"] = json!([1, 1, 0]);
    let spare = doc.floats("VEC3", &[0.0; 3]);
    doc.json["accessors"][spare]["count"] = json!(7);
    for (key, value) in [
        ("animations", json!([{ "samplers": [], "channels": ["walk"] }])),
        ("cameras", json!([{}])),
        ("textures", json!([{ "sampler": 3 }])),
        ("materials", json!([{ "emissiveTexture": { "index": 1 } }])),
        ("scenes", json!([{ "nodes": [0] }, { "nodes": [99] }])),
    ] {
        doc.json[key] = value;
    }
    let faults = vec![
        ("/accessors/2: found 7 elements of 12 bytes", "accessor"),
        ("/animations/0/channels/0: found \"walk\", expected an object", "value"),
        ("/cameras/0: found no \"type\"", "missing"),
        ("/materials/0/emissiveTexture/index: found texture 1, expected texture 0 to 0", "index"),
        ("/scenes/1/nodes/0: found node 99, expected node 0 to 0", "index"),
        ("/textures/0/sampler: found sampler 3, expected no sampler: there are none", "index"),
    ];
    (doc, faults)
}

/// Ends the test unless these faults are told of `in.glb`, each once, and nothing else.
#[track_caller]
fn expect(err: &str, level: &str, faults: &[(&str, &str)]) {
    for (found, code) in faults {
        let line = |line: &&str| {
            line.starts_with(&format!("{level}: in.glb: {found}"))
                && line.ends_with(&format!("; it is passed through as it is [{code}]"))
        };
        assert_eq!(err.lines().filter(line).count(), 1, "{found} in\n{err}");
    }
    assert_eq!(err.lines().filter(|line| line.contains("in.glb: /")).count(), faults.len(), "{err}");
}

#[test]
fn what_the_effect_does_not_touch_passes_through_with_a_warning() {
    let place = Place::new();
    let (doc, faults) = faulty();
    place.write("in.glb", doc.glb());
    expect(&place.run("apply lift.ron in.glb -o out.glb --at 1").expect(0).err(), "warning", &faults);
    let out = chunks(&place.read("out.glb")).0;
    for key in ["cameras", "textures", "materials", "scenes", "animations"] {
        assert_eq!(out[key], doc.json[key], "{key}");
    }
    let inspected = place.run_with(["inspect", "in.glb", "--json"], b"").expect(0);
    expect(&inspected.err(), "warning", &faults);
    let facts: Value = serde_json::from_str(&inspected.out()).unwrap();
    assert_eq!(facts["warnings"].as_array().unwrap().len(), faults.len());
}

#[test]
fn strict_refuses_them() {
    let place = Place::new();
    let (doc, faults) = faulty();
    place.write("in.glb", doc.glb());
    let line = "apply lift.ron in.glb -o out.glb --at 1 --strict";
    expect(&place.run(line).expect(3).err(), "error", &faults);
    let line = "render lift.ron in.glb -o out.png --at 1 --fast --size 32x32 --strict";
    expect(&place.run(line).expect(3).err(), "error", &faults);
    assert_eq!(place.files(), ["in.glb", "lift.ron"]);
}

#[test]
fn what_a_picture_looks_at_is_not_told_twice() {
    let place = Place::new();
    let mut doc = triangle(json!({}));
    doc.json["accessors"][0]["min"] = json!([0, 0, 0]);
    doc.json["accessors"][0]["max"] = json!([1, 1, 0]);
    let uvs = doc.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let times = doc.floats("SCALAR", &[0.0, 1.0]);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["material"] = json!(0);
    doc.json["images"] = json!([{}]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    doc.json["materials"] = json!([{ "alphaMode": "HALF", "pbrMetallicRoughness": {
        "baseColorTexture": { "index": 0 }, "baseColorFactor": "red",
    } }]);
    doc.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": times }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "turn" } }],
    }]);
    place.write("in.glb", doc.glb());
    let err = place.run("render in.glb -o out.png --fast --size 32x32").expect(0).err();
    let faults = [
        ("/animations/0/channels/0/target/path: found \"turn\"", "value"),
        ("/images/0: found no \"uri\"", "missing"),
        ("/materials/0/alphaMode: found \"HALF\"", "value"),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor: found \"red\"", "value"),
    ];
    expect(&err, "warning", &faults);
}
