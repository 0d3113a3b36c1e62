//! What `inspect` and `apply` say of the engines that are to load a document.

use serde_json::{Value, json};

use crate::make::{Doc, triangle};
use crate::place::Place;

/// A triangle that is called `drop`, with so many targets of positions and normals.
fn drop_of(targets: usize) -> Doc {
    let mut doc = triangle(json!({}));
    let delta = doc.floats("VEC3", &[0.5; 9]);
    doc.json["accessors"][delta]["min"] = json!([0.5, 0.5, 0.5]);
    doc.json["accessors"][delta]["max"] = json!([0.5, 0.5, 0.5]);
    let mesh = &mut doc.json["meshes"][0];
    mesh["name"] = json!("drop");
    mesh["weights"] = json!(vec![0; targets]);
    mesh["primitives"][0]["targets"] = json!(vec![json!({ "POSITION": delta, "NORMAL": delta }); targets]);
    doc
}

/// The lines of the table about engines.
fn rows(table: &str) -> Vec<&str> {
    let names = ["engines", "three.js", "Bevy", "Godot", "Blender", "Babylon.js", "phones", "SharpGLTF"];
    table.lines().filter(|line| names.iter().any(|name| line.starts_with(&format!("{name} ")))).collect()
}

#[test]
fn inspect_has_a_line_for_each_engine_and_one_for_each_finding() {
    let place = Place::new();
    place.write("plain.glb", triangle(json!({})).glb());
    let table = place.run("inspect plain.glb").expect(0).out();
    assert_eq!(rows(&table), ["engines      ok: three.js, Bevy, Godot, Blender, Babylon.js, phones"]);

    place.write("drop.glb", drop_of(120).glb());
    let table = place.run("inspect drop.glb").expect(0).out();
    assert_eq!(
        rows(&table),
        [
            "three.js     ok: 120 morph targets, 11.5 kB, 20.2 kB of JavaScript's heap",
            "Bevy         120 morph targets, 17.3 kB",
            "Bevy         refuses up to 0.17: mesh \"drop\" has 120 targets, it takes 64",
            "Godot        ok: 120 morph targets, 8.6 kB",
            "Blender      ok: 120 morph targets, 4.3 kB",
            "Blender      costs: mesh \"drop\" has normals in 120 targets, which it does not use: it works out its own",
            "Babylon.js   120 morph targets, 11.5 kB, 20.2 kB of JavaScript's heap",
            "Babylon.js   degrades without textures of targets (WebGL1, Mali-G72): mesh \"drop\" has 120 targets, and it shows at most 8 at a time \
             there, the first that are not 0",
            "phones       ok: 120 morph targets",
        ]
    );
    let json = place.run("inspect drop.glb --json").expect(0).out();
    let facts: Value = serde_json::from_str(&json).unwrap();
    let engines = &facts["engines"];
    assert_eq!(engines["targets"], json!(120));
    assert_eq!(
        engines["memory"][0],
        json!({ "engine": "three.js", "bytes": 120 * 3 * 32, "heap_bytes": 120 * 3 * 56 })
    );
    assert_eq!(
        engines["findings"][0],
        json!({
            "engine": "Bevy", "versions": "up to 0.17", "severity": "refuses", "about": "targets", "meshes": [0],
            "message": "mesh \"drop\" has 120 targets, it takes 64",
        })
    );
}

#[test]
fn of_what_is_refused_for_an_extension_alone_engines_are_told() {
    let place = Place::new();
    let mut doc = drop_of(1);
    doc.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    place.write("draco.glb", doc.glb());
    let table = place.run("inspect draco.glb").expect(3).out();
    assert!(
        table.contains("Godot        refuses: the document requires KHR_draco_mesh_compression\n"),
        "{table}"
    );
    let mut doc = drop_of(1);
    doc.json["accessors"][0]["count"] = json!(9999);
    place.write("long.glb", doc.glb());
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (file, code) in [("long.glb", 3), ("a.obj", 0)] {
        assert_eq!(rows(&place.run(&format!("inspect {file}")).expect(code).out()), [""; 0], "{file}");
        let facts = place.run(&format!("inspect {file} --json")).expect(code).out();
        assert_eq!(serde_json::from_str::<Value>(&facts).unwrap()["engines"], Value::Null, "{file}");
    }
}

/// The report of a run, and what is said meanwhile.
fn apply(place: &Place, options: &str) -> (Value, String) {
    let done = place.run(&format!("apply lift.ron {options} --report -")).expect(0);
    (serde_json::from_str(&done.out()).unwrap(), done.err())
}

#[test]
fn apply_reports_what_engines_make_of_it_and_tells_what_it_adds() {
    let place = Place::new();
    let (report, err) = apply(&place, "-o out.glb");
    assert!(!err.contains("[engines]"), "an ordinary run is quiet: {err}");
    let inspected = place.run("inspect out.glb --json").expect(0).out();
    let inspected: Value = serde_json::from_str(&inspected).unwrap();
    assert_eq!(report["engines"], inspected["engines"], "both judge the same document");
    assert_eq!(report["engines"]["targets"], inspected["meshes"][0]["morph_targets"]);

    let (report, err) = apply(&place, "-o many.glb --bake frames --fps 100");
    let warned: Vec<&str> = err.lines().filter(|line| line.contains("[engines]")).collect();
    assert_eq!(warned.len(), 1, "{err}");
    let targets = &report["engines"]["targets"];
    assert!(warned[0].contains(&format!(" has {targets} targets, it takes 64 [engines]")), "{err}");
    place.run("apply lift.ron -o many.glb --bake frames --fps 100 --strict").expect(0);

    // What an input has already is not of the effect's making.
    place.write("drop.glb", drop_of(120).glb());
    let (report, err) = apply(&place, "drop.glb -o out.glb");
    assert!(!err.contains("[engines]"), "{err}");
    assert!(report["engines"]["findings"][0]["message"].as_str().unwrap().contains("it takes 64"));
    assert_eq!(apply(&place, "-o out.obj --at 1").0["engines"], Value::Null);
    assert_eq!(apply(&place, "-o out.glb --at 1").0["engines"]["targets"], json!(0));
}
