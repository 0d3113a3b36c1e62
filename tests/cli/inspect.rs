//! What `inspect` says about an asset is what `only` and `mask` of a preset can use.

use serde_json::{Value, json};

use crate::make::{Doc, skinned, triangle};
use crate::place::{Place, shared};

/// The JSON and the lines of a file.
fn inspect(place: &Place, file: &str) -> (Value, String) {
    let json = place.run_with(["inspect", file, "--json"], b"").expect(0).out();
    let table = place.run_with(["inspect", file], b"").expect(0).out();
    (serde_json::from_str(&json).unwrap(), table)
}

/// A skinned triangle on two joints, and a bare node with another one below it that has colours and coordinates.
fn character() -> Doc {
    let mut doc = skinned([0.75, 0.25, 0.0, 0.0]);
    doc.json["nodes"][0]["name"] = json!("body");
    doc.json["nodes"][1]["name"] = json!("arm\u{1b}[2J");
    doc.json["nodes"][2]["translation"] = json!([-0.0001, 0.5, -1]);
    let attributes = doc.json["meshes"][0]["primitives"][0]["attributes"].clone();
    let mut painted = json!({ "POSITION": attributes["POSITION"], "NORMAL": attributes["NORMAL"] });
    painted["COLOR_0"] = json!(doc.floats("VEC3", &[0.5; 9]));
    painted["TEXCOORD_0"] = json!(doc.floats("VEC2", &[0.5; 6]));
    let mesh = doc.mesh(&json!({ "attributes": painted, "material": 1 }));
    doc.json["materials"] = json!([{ "name": "spare" }, {}]);
    doc.node(json!({ "name": "hat", "children": [4] }));
    doc.node(json!({ "mesh": mesh }));
    doc.node(json!({ "name": "camera" }));
    doc
}

#[test]
fn all_that_a_preset_can_name_is_listed() {
    let place = Place::new();
    place.write("in.glb", character().glb());
    let (facts, table) = inspect(&place, "in.glb");
    for line in [
        "nodes        6",
        "node 0       \"body\": shows mesh 0, 3 vertices",
        "node 1       \"arm\\u{1b}[2J\": joint of skin 0 at (0.000, 0.000, 3.000), 2 vertices",
        "node 2       (no name): joint of skin 0 at (0.000, 0.500, 2.000), 2 vertices",
        "node 3       \"hat\": above 1 mesh node, 3 vertices",
        "node 4       (no name): shows mesh 1, 3 vertices",
        "mesh 0       (no name): 1 primitive, 3 vertices, 1 triangle, 0 morph targets, no vertex colours, no texture coordinates",
        "mesh 1       (no name): 1 primitive, 3 vertices, 1 triangle, 0 morph targets, vertex colours, texture coordinates",
        "material 0   \"spare\": 0 vertices",
        "material 1   (no name): 3 vertices",
    ] {
        assert!(table.lines().any(|found| found == line), "{line} in\n{table}");
    }
    assert!(!table.contains("node 5"), "a node that nothing can be limited to is only counted:\n{table}");
    assert_eq!(
        facts["selectable_nodes"][0],
        json!({
            "node": 0, "name": "body", "mesh": 0, "mesh_nodes": 1, "vertices": 3,
            "joint_of": [], "joint_vertices": 0, "position": [100.0, 0.0, 0.0],
        })
    );
    let arm = &facts["selectable_nodes"][1];
    assert_eq!(
        (&arm["joint_of"], &arm["joint_vertices"], &arm["mesh"]),
        (&json!([0]), &json!(2), &Value::Null)
    );
    assert_eq!(facts["selectable_nodes"].as_array().unwrap().len(), 5);
    assert_eq!(
        facts["materials"],
        json!([{ "name": "spare", "vertices": 0 }, { "name": null, "vertices": 3 }])
    );
    assert_eq!(
        (&facts["meshes"][1]["colored_vertices"], &facts["meshes"][0]["mapped_vertices"]),
        (&json!(3), &json!(0))
    );
    assert_eq!(facts["groups"], json!([]));

    // And a preset that names all of it, by name or number, finds it.
    for only in
        ["Nodes([\"body\", \"hat\", \"4\"])", "Materials([\"1\"])", "Joints([\"arm\\u{1b}[2J\", \"2\"])"]
    {
        place.write(
            "only.ron",
            format!("Deform(only: {only}, wires: [Wire(curve: Polyline(points: [(0, 0, 3), (1, 0, 3)]), radius: 9, twist: 9)])"),
        );
        let err = place.run("apply only.ron in.glb -o out.glb --at 0").expect(0).err();
        assert!(!err.contains("only"), "{err}");
    }
}

#[test]
fn colours_that_no_mask_can_read_are_a_warning() {
    let place = Place::new();
    let mut doc = character();
    let broken = doc.floats("VEC3", &[f32::NAN; 9]);
    doc.json["meshes"][1]["primitives"][0]["attributes"]["COLOR_0"] = json!(broken);
    place.write("in.glb", doc.glb());
    place.write("in.obj", "v 0 0 0 red 0 0\nv 1 0 0\n");
    for file in ["in.glb", "in.obj"] {
        let err = place.run_with(["inspect", file], b"").expect(0).err();
        assert!(err.contains("[colors]") && err.contains(file), "{err}");
        let facts = inspect(&place, file).0;
        let last = facts["warnings"].as_array().unwrap().last().unwrap().as_str().unwrap();
        assert!(last.ends_with("[colors]"), "{facts}");
    }
}

/// Files of every kind of fault in what an effect reads, each with its exit code and a part of what is said.
fn refused() -> Vec<(&'static str, Vec<u8>, i32, &'static str)> {
    let edited = |edit: &dyn Fn(&mut Value)| {
        let mut doc = character();
        edit(&mut doc.json);
        doc.glb()
    };
    let whole = character().glb();
    vec![
        ("cut.glb", whole[..whole.len() - 5].to_vec(), 3, ": byte 8: found"),
        ("text.gltf", b"{\n\"asset\": }".to_vec(), 3, ":2: found"),
        ("old.glb", edited(&|json| json["asset"]["version"] = json!("1.0")), 3, ": /asset/version: found"),
        (
            "packed.glb",
            edited(&|json| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
            3,
            ": /extensionsRequired/0: found the required extension KHR_draco_mesh_compression",
        ),
        (
            "lost.gltf",
            br#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "lost.bin", "byteLength": 4}]}"#.to_vec(),
            3,
            ": /buffers/0/uri: found",
        ),
        (
            "view.glb",
            edited(&|json| json["bufferViews"][0]["byteLength"] = json!(1e6)),
            3,
            ": /bufferViews/0",
        ),
        ("long.glb", edited(&|json| json["accessors"][0]["count"] = json!(9999)), 3, ": /accessors/0: found"),
        (
            "mode.glb",
            edited(&|json| json["meshes"][0]["primitives"][0]["mode"] = json!(9)),
            3,
            ": /meshes/0/primitives/0/mode: found 9",
        ),
        ("cycle.glb", edited(&|json| json["nodes"][2]["children"] = json!([1])), 3, ": /nodes/"),
        (
            "skin.glb",
            edited(&|json| json["skins"][0]["joints"][1] = json!(77)),
            3,
            ": /skins/0/joints/1: found",
        ),
        ("empty.glb", edited(&|json| json["scenes"] = json!([{}])), 3, ": found a scene without any vertex"),
        ("face.obj", b"v 0 0 0\nf 1 2 3\n".to_vec(), 3, ":2: found"),
        ("big.obj", b"v 0 0 0\n".repeat(400), 5, "--max-vertices"),
        ("what.stl", b"solid\n".to_vec(), 3, ": found a file of unknown kind"),
    ]
}

#[test]
fn what_apply_refuses_inspect_refuses_in_the_same_words() {
    let place = Place::new();
    for (name, bytes, code, part) in refused() {
        place.write(name, bytes);
        let applied =
            place.run(&format!("apply lift.ron {name} -o out.glb --max-vertices 300")).expect(code).err();
        assert!(
            applied.contains(&format!("{name}{part}")) || code == 5 && applied.contains(part),
            "{applied}"
        );
        let table = place.run(&format!("inspect {name} --max-vertices 300")).expect(code);
        let last = format!("refused      {}", applied.trim_start_matches("error: "));
        assert!(table.err() == applied && table.out().ends_with(&last), "{name}: {}", table.out());
        let json = place.run(&format!("inspect {name} --json --max-vertices 300")).expect(code);
        let facts: Value = serde_json::from_str(&json.out()).unwrap();
        assert_eq!(
            (json.err(), format!("error: {}\n", facts["refused"].as_str().unwrap())),
            (applied.clone(), applied)
        );
    }
    place.write("fine.glb", character().glb());
    assert_eq!(inspect(&place, "fine.glb").0["refused"], Value::Null);
}

#[test]
fn what_can_be_told_of_a_refused_file_is_told() {
    let place = Place::new();
    let mut doc = character();
    doc.json["cameras"] = json!([{}]);
    doc.json["skins"][0]["name"] = json!("bones");
    doc.json["animations"] = json!([{ "name": "walk", "channels": [], "samplers": [] }]);
    // Where the work ends: a required extension, a buffer, geometry.
    let (mut packed, mut lost, mut long) = (doc.json.clone(), doc.json.clone(), doc.json.clone());
    packed["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    lost["buffers"] = json!([{ "uri": "none.bin", "byteLength": 4 }]);
    long["accessors"][1]["count"] = json!(9999);
    for (name, json) in [("packed.glb", packed), ("lost.gltf", lost), ("long.glb", long)] {
        let bytes = if name.ends_with("glb") {
            Doc { json, bin: doc.bin.clone() }.glb()
        } else {
            json.to_string().into_bytes()
        };
        place.write(name, bytes);
        let done = place.run_with(["inspect", name, "--json"], b"").expect(3);
        let facts: Value = serde_json::from_str(&done.out()).unwrap();
        assert_eq!(facts["container"], name.rsplit_once('.').unwrap().1, "{name}");
        for (key, value) in [
            ("nodes", json!(6)),
            ("vertices", Value::Null),
            ("bounds", Value::Null),
            ("materials", json!([{ "name": "spare", "vertices": null }, { "name": null, "vertices": null }])),
            ("skins", json!([{ "name": "bones", "joints": 2 }])),
            ("animations", json!([{ "name": "walk", "channels": 0, "duration": 0.0 }])),
        ] {
            assert_eq!(facts[key], value, "{name}: {key}");
        }
        assert_eq!(facts["meshes"][1]["mapped_vertices"], json!(3), "{name}");
        // Besides why it is refused, which is told once; there is no output to which it could pass.
        let missing =
            format!("{name}: /cameras/0: found no \"type\", expected the property \"type\" [missing]");
        assert_eq!(facts["warnings"], json!([missing]), "{name}");
        let table = place.run_with(["inspect", name], b"").expect(3);
        for line in ["nodes        6", "material 0   \"spare\"", "skin 0       \"bones\": 2 joints"] {
            assert!(table.out().lines().any(|found| found == line), "{line} in\n{}", table.out());
        }
        assert!(!table.out().contains("shown "), "{}", table.out());
    }
    // Of another version nothing is known but its name.
    place.write("old.gltf", r#"{"asset": {"version": "1.0"}, "nodes": {"a": {}}, "buffers": {"b": {}}}"#);
    let facts = place.run_with(["inspect", "old.gltf", "--json"], b"").expect(3).out();
    let facts: Value = serde_json::from_str(&facts).unwrap();
    assert_eq!((&facts["container"], &facts["warnings"]), (&json!("gltf"), &json!([])));
}

#[test]
fn what_effects_will_say_of_a_model_is_said() {
    let place = Place::new();
    place.write(
        "bounds.ron",
        "Deform(units: Bounds, wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), radius: 9, \
         twist: Keys([(0, 0), (1, 9)]))])",
    );
    let mut many = triangle(json!({}));
    let delta = many.floats("VEC3", &[0.5; 9]);
    many.json["meshes"][0]["primitives"][0]["targets"] =
        Value::Array(vec![json!({ "POSITION": delta }); 240]);
    place.write("many.glb", many.glb());
    place.write("one.obj", "v 1 2 3\nv 1 2 3\n");
    let mut flat = triangle(json!({ "scale": [0, 0, 0] }));
    flat.json["accessors"][0]["min"] = json!([0, 0, 0]);
    flat.json["accessors"][0]["max"] = json!([1, 1, 0]);
    place.write("one.glb", flat.glb());
    for (file, code, tag) in [("many.glb", 0, "own-targets"), ("one.obj", 3, ""), ("one.glb", 3, "")] {
        let applied = place.run(&format!("apply bounds.ron {file} --dry-run --fps 4")).expect(code).err();
        let facts = inspect(&place, file).0;
        let warnings = facts["warnings"].as_array().unwrap();
        let told = |tag: &str| warnings.iter().filter(|w| w.as_str().unwrap().ends_with(tag)).count();
        assert_eq!(told("[own-targets]"), usize::from(tag == "own-targets"), "{file}: {warnings:?}");
        assert_eq!(told("[no-extent]"), usize::from(code == 3), "{file}: {warnings:?}");
        assert!(applied.contains(tag) && applied.contains("extent") == (code == 3), "{file}: {applied}");
    }
}

#[test]
fn groups_and_materials_of_an_obj_are_listed_with_their_vertices() {
    let place = Place::new();
    place.write(
        "in.obj",
        "mtllib none.mtl\no left arm\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nusemtl skin\nf 1/1 2 3\n\
         g hand\nusemtl nail\nf 2 3 4\n",
    );
    let (facts, table) = inspect(&place, "in.obj");
    for line in [
        "group        \"hand\": 1 vertex",
        "group        \"left arm\": 4 vertices",
        "mesh 0       (no name): 1 primitive, 4 vertices, 2 triangles, 0 morph targets, vertex colours at 2 vertices, texture coordinates at 1 vertex",
        "material     \"nail\": 1 vertex",
        "material     \"skin\": 1 vertex",
    ] {
        assert!(table.lines().any(|found| found == line), "{line} in\n{table}");
    }
    assert_eq!(
        facts["groups"],
        json!([{ "name": "hand", "vertices": 1 }, { "name": "left arm", "vertices": 4 }])
    );
    assert_eq!(facts["selectable_nodes"], json!([]));
    // A file without groups is one node, which a preset calls as the file is called.
    place.write("bare cow.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let (_, table) = inspect(&place, "bare cow.obj");
    assert!(
        table.contains("group        \"bare cow\": 3 vertices\n") && !table.contains("material"),
        "{table}"
    );
}

#[test]
fn the_arm_of_a_character_can_be_found() {
    let Some(path) = shared("rigged/cesium_man.glb") else { return };
    let place = Place::new();
    let (facts, table) = inspect(&place, path.to_str().unwrap());
    let nodes = facts["selectable_nodes"].as_array().unwrap();
    let joints: Vec<&Value> = nodes.iter().filter(|node| node["joint_of"] == json!([0])).collect();
    assert_eq!(joints.len(), 19);
    assert!(joints.iter().all(|joint| joint["joint_vertices"].as_u64().unwrap() > 0), "{table}");
    // Shoulder, elbow and hand, further and further out to the side on which z grows; each holds a part of the arm.
    let arm = [13, 14, 15].map(|number| *joints.iter().find(|joint| joint["node"] == json!(number)).unwrap());
    let z = |joint: &Value| joint["position"][2].as_f64().unwrap();
    assert!(0.0 < z(arm[0]) && z(arm[0]) < z(arm[1]) && z(arm[1]) < z(arm[2]), "{table}");
    let body = nodes.iter().find(|node| node["mesh"] == json!(0)).unwrap();
    assert_eq!((&body["vertices"], &facts["materials"][0]["vertices"]), (&json!(3273), &json!(3273)));
    assert_eq!(facts["meshes"][0]["mapped_vertices"], json!(3273));
}
