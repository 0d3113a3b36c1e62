use super::*;
use serde_json::json;

/// A mesh of a primitive whose position accessor is `at`, with as many targets as are given, of these attributes.
fn mesh(name: &str, at: usize, targets: usize, attributes: &[&str]) -> Value {
    let target: Value =
        attributes.iter().map(|key| ((*key).to_owned(), json!(1))).collect::<serde_json::Map<_, _>>().into();
    json!({
        "name": name, "weights": vec![0; targets],
        "primitives": [{ "attributes": { "POSITION": at }, "targets": vec![target; targets] }],
    })
}

/// A document of these meshes; accessor 0 has 1000 vertices, accessor 1 has 10.
fn document(meshes: &[Value]) -> Value {
    json!({
        "asset": { "version": "2.0" }, "meshes": meshes,
        "accessors": [{ "bufferView": 0, "count": 1000 }, { "bufferView": 0, "count": 10 }],
    })
}

/// Findings as they are told, but for those that cost only, and for what is rare.
fn told(json: &Value) -> Vec<String> {
    let findings = of_json(json).findings.into_iter();
    let findings = findings.filter(|f| f.severity > Severity::Costs && f.about != About::Influencers);
    findings.map(|finding| finding.to_string()).collect()
}

#[test]
fn targets_beyond_attributes_are_told() {
    let of = |targets: usize| {
        let findings = of_json(&document(&[mesh("drop", 1, targets, &["POSITION"])])).findings;
        findings
            .into_iter()
            .filter(|f| f.about == About::Influencers)
            .map(|f| f.to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(of(8), [""; 0]);
    let place = "Babylon.js without textures of targets (WebGL1, Mali-G72)";
    let what =
        "mesh \"drop\" has 9 targets, and it shows at most 8 at a time there, the first that are not 0";
    assert_eq!(of(9), [format!("{place}: {what}")]);
}

fn costs(json: &Value) -> Vec<String> {
    let findings = of_json(json).findings.into_iter();
    findings
        .filter(|finding| finding.severity == Severity::Costs)
        .map(|finding| finding.to_string())
        .collect()
}

#[test]
fn memory_is_that_of_the_table() {
    let plain =
        of_json(&document(&[mesh("a", 0, 3, &["POSITION"]), mesh("b", 1, 5, &["POSITION", "NORMAL"])]));
    assert_eq!(plain.targets, 5);
    let bytes: Vec<_> = plain.memory.iter().map(|m| (m.engine, m.bytes, m.heap_bytes)).collect();
    let (a, b) = (1000 * 3, 10 * 5);
    assert_eq!(
        bytes,
        [
            ("three.js", Some(16 * a + 32 * b), Some(28 * a + 56 * b)),
            ("Bevy", Some(48 * (a + b)), None),
            ("Godot", Some(12 * a + 24 * b), None),
            ("Blender", Some(12 * (a + b)), None),
            ("Babylon.js", Some(16 * a + 32 * b), Some(28 * a + 56 * b)),
            ("phones", None, None),
        ]
    );
    // Normals in one target alone: the textures of all have them, arrays that are dense do not.
    let mut some = mesh("a", 1, 3, &["POSITION"]);
    some["primitives"][0]["targets"][1] = json!({ "NORMAL": 1, "TANGENT": 1 });
    let some = of_json(&document(&[some]));
    let of = |engine: usize| some.memory[engine].bytes;
    assert_eq!((of(0), of(1), of(2), of(3)), (Some(32 * 30), Some(48 * 30), Some(12 * 40), Some(12 * 30)));
    let none = of_json(&document(&[mesh("a", 0, 0, &[])]));
    assert_eq!((none.targets, none.memory[0].bytes, none.findings.len()), (0, Some(0), 0));
}

#[test]
fn targets_beyond_a_limit_are_told_and_at_it_are_not() {
    for (targets, engines) in [
        (64, vec![]),
        (65, vec!["Bevy up to 0.17"]),
        (241, vec!["Bevy up to 0.17"]),
        (242, vec!["Bevy up to 0.17", "phones"]),
        (256, vec!["Bevy up to 0.17", "phones"]),
        (257, vec!["Bevy up to 0.17", "Bevy from 0.18", "three.js", "Babylon.js", "phones"]),
    ] {
        let told = told(&document(&[mesh("drop", 1, targets, &["POSITION"])]));
        let heads: Vec<_> = told.iter().filter_map(|line| line.split_once(": mesh \"drop\" has ")).collect();
        assert_eq!(heads.iter().map(|(engine, _)| *engine).collect::<Vec<_>>(), engines, "{told:?}");
        assert!(heads.iter().all(|(_, rest)| rest.starts_with(&format!("{targets} targets, "))), "{told:?}");
    }
    let many = [("a", 65), ("b", 3), ("c\u{1b}", 120), ("d", 120)];
    let many = document(&many.map(|(name, targets)| mesh(name, 1, targets, &["POSITION"])));
    assert_eq!(
        told(&many),
        ["Bevy up to 0.17: mesh \"c\\u{1b}\" has 120 targets, it takes 64; so with 2 more"]
    );
    assert_eq!(of_json(&many).findings[0].meshes, [0, 2, 3]);
    // One without a name goes by its number.
    let mut nameless = mesh("", 1, 65, &["POSITION"]);
    nameless.as_object_mut().unwrap().remove("name");
    assert_eq!(told(&document(&[nameless])), ["Bevy up to 0.17: mesh 0 has 65 targets, it takes 64"]);
}

#[test]
fn what_else_is_found_of_meshes_is_told() {
    let joints = "mesh \"drop\" may hang on more than four joints a vertex (JOINTS_1), it takes four";
    let bare = "Bevy: mesh \"drop\" has targets, indices and no normals: it makes some, for which it copies vertices, and leaves targets as \
                they were, so that these move others";
    let of = |primitive: Value| json!({ "primitives": [primitive] });
    let position = json!({ "POSITION": 1 });
    let cases: [(Value, &[&str]); 11] = [
        (
            json!({ "weights": null }),
            &["Bevy in older versions: mesh \"drop\" has 3 targets and no list of weights"],
        ),
        (
            json!({ "extras": { "targetNames": ["a:b", "c", "d:"] } }),
            &["Godot: mesh \"drop\" has 2 names of targets with a colon, which it replaces"],
        ),
        (
            json!({ "primitives": [{ "attributes": { "POSITION": 0 } }, { "attributes": { "POSITION": 1 }, "targets": [{}, {}] }] }),
            &["Blender in some versions: mesh \"drop\" has 2 targets more in one primitive than in another"],
        ),
        (
            json!({ "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_1": 4 } }] }),
            &[&format!("three.js: {joints}"), &format!("Bevy: {joints}")],
        ),
        (
            json!({ "primitives": [{ "attributes": { "POSITION": 2 }, "targets": [{ "POSITION": 0 }] }] }),
            &[
                "Bevy up to 0.18: mesh \"drop\" has targets for 466034 vertices in a primitive, its textures take 466033",
            ],
        ),
        (of(json!({ "attributes": position, "indices": 0, "targets": [{}] })), &[bare]),
        (of(json!({ "attributes": position, "indices": 0, "mode": 5, "targets": [{}] })), &[]),
        (of(json!({ "attributes": { "POSITION": 1, "NORMAL": 1 }, "indices": 0, "targets": [{}] })), &[]),
        (of(json!({ "attributes": position, "targets": [{}] })), &[]),
        (
            of(json!({ "attributes": position, "mode": 2 })),
            &["Bevy: mesh \"drop\" has line loops or triangle fans"],
        ),
        (
            of(json!({ "attributes": position, "mode": 6 })),
            &["Bevy: mesh \"drop\" has line loops or triangle fans"],
        ),
    ];
    for (changes, want) in cases {
        let mut json = document(&[mesh("drop", 1, 3, &["POSITION"])]);
        json["accessors"].as_array_mut().unwrap().push(json!({ "bufferView": 0, "count": 466_034 }));
        for (key, value) in changes.as_object().unwrap() {
            let mesh = json["meshes"][0].as_object_mut().unwrap();
            if value.is_null() {
                mesh.remove(key)
            } else {
                mesh.insert(key.clone(), value.clone())
            };
        }
        assert_eq!(told(&json), want);
    }
    let mut large = document(&[mesh("drop", 0, 1, &["POSITION"])]);
    large["accessors"][0]["count"] = json!(466_033);
    assert_eq!(told(&large), [""; 0]);
}

#[test]
fn what_costs_and_does_nothing_is_told() {
    let all = document(&[mesh("drop", 0, 3, &["POSITION", "NORMAL", "TANGENT"])]);
    let normals =
        "Blender: mesh \"drop\" has normals in 3 targets, which it does not use: it works out its own";
    assert_eq!(
        costs(&all),
        ["three.js: mesh \"drop\" has tangents in 3 targets, which it does not use", normals]
    );
    // Three materials on the same vertices are three times the textures, of which two are copies.
    let mut split = mesh("drop", 0, 3, &["POSITION"]);
    let primitive = split["primitives"][0].clone();
    split["primitives"] = json!([primitive, primitive, primitive]);
    let split = document(&[split]);
    let want = format!(
        "three.js: mesh \"drop\" has primitives that share their vertices: copies of their targets take {} bytes",
        2 * 16 * 1000 * 3
    );
    assert_eq!(costs(&split), [want]);
    assert_eq!(of_json(&split).memory[0].bytes, Some(3 * 16 * 1000 * 3));
}

#[test]
fn what_refuses_a_document_is_told() {
    let mut json = document(&[]);
    json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    json["scenes"] = json!([{ "nodes": [0] }]);
    json["animations"] = json!([{ "channels": [{ "target": { "node": 0, "path": "weights" } }] }]);
    assert_eq!(told(&json), [""; 0], "what is used need not be known");
    json["extensionsRequired"] = json!(["EXT_meshopt_compression", "KHR_mesh_quantization"]);
    json["accessors"][0] = json!({ "count": 3 });
    json["accessors"][1] = json!({ "count": 3, "sparse": {} });
    json["accessors"].as_array_mut().unwrap().push(json!({ "count": 3 }));
    json["scenes"] = json!([{}]);
    json["animations"][0]["channels"][0]["target"] = json!({ "path": "pointer" });
    let empty = "accessor 0 has neither a buffer view nor sparse values; so with 1 more";
    assert_eq!(
        told(&json),
        [
            "Bevy: the document requires EXT_meshopt_compression, KHR_mesh_quantization",
            "Godot: the document requires EXT_meshopt_compression, KHR_mesh_quantization",
            "Blender: the document requires EXT_meshopt_compression",
            &format!("Bevy: {empty}"),
            &format!("SharpGLTF: {empty}"),
            &format!("UnityGLTF: {empty}"),
            "Godot before 4.1: accessor 1 has sparse values and no buffer view, for whose zeros it takes other bytes or nothing",
            "Bevy: animation 0 has a channel that names no node",
            "Bevy: scene 0 has no list of nodes",
        ]
    );
}

#[test]
fn nodes_of_one_path_of_names_are_told_where_clips_move_any() {
    let nodes = |nodes: Value, moved: &[usize]| {
        let channels: Vec<Value> =
            moved.iter().map(|node| json!({ "target": { "node": node, "path": "weights" } })).collect();
        told(&json!({ "nodes": nodes, "animations": [{ "channels": channels }] }))
    };
    let told = |nodes: &str, more: &str| {
        vec![format!(
            "Bevy: nodes {nodes} have the same names from the root on, by which it finds what clips move: each plays what is for the \
             others{more}"
        )]
    };
    let arms = json!([
        { "name": "a", "children": [1, 2, 3] }, { "name": "arm" }, { "name": "arm" }, { "name": "leg" },
        { "name": "b", "children": [5] }, { "name": "arm" }, {}, {}, { "name": "a" },
    ]);
    assert_eq!(nodes(arms.clone(), &[1, 2]), told("1, 2", ""));
    assert_eq!(nodes(arms.clone(), &[2]), told("1, 2", ""), "what rests beside it moves, too");
    for moved in [&[0, 3, 4, 6, 7][..], &[5], &[]] {
        assert_eq!(nodes(arms.clone(), moved), [""; 0], "{moved:?}");
    }
    assert_eq!(nodes(arms, &[0, 1, 8]), told("0, 8", "; so with 1 more"), "roots, too");
    // Loops, and children that two have or nobody.
    let odd = json!([{ "children": [0, 1] }, { "children": [0, 7] }, { "children": [1, -1] }, 3]);
    assert_eq!(nodes(odd, &[0, 1, 2, 3, 9]), [""; 0]);
}

#[test]
fn more_joints_than_a_buffer_has_are_told() {
    let skins = |counts: [usize; 3]| {
        told(&json!({ "skins": counts.map(|count| json!({ "joints": vec![0; count] })) }))
    };
    assert_eq!(skins([3, 256, 1]), [""; 0]);
    let shows = "of which it shows 256 where there are no storage buffers, as in WebGL2; so with 1 more";
    assert_eq!(skins([257, 3, 265]), [format!("Bevy: skin 0 has 265 joints, {shows}")]);
}

/// Bevy reads by the `gltf` crate: what is said of Bevy's reading, that crate does.
#[test]
fn the_reader_of_bevy_refuses_what_is_said_of_it() {
    let good = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": 36, "uri": "data:," }], "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 1],
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }], "scenes": [{ "nodes": [0] }],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
            "samplers": [{ "input": 0, "output": 0 }],
        }],
    });
    let refuses = |json: &Value| gltf::Gltf::from_slice(json.to_string().as_bytes()).is_err();
    for name in [
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_texture_transform",
        "KHR_materials_volume",
        "KHR_materials_clearcoat",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "VENDOR_what",
    ] {
        let mut json = good.clone();
        json["extensionsRequired"] = json!([name]);
        assert_eq!(refuses(&json), told(&json).iter().any(|told| told.starts_with("Bevy: ")), "{name}");
    }
    let edits: [fn(&mut Value); 8] = [
        |_| (),
        |json| json["extensionsRequired"] = json!(["KHR_mesh_quantization"]),
        |json| json["extensionsRequired"] = json!(["EXT_meshopt_compression"]),
        |json| json["extensionsRequired"] = json!(["KHR_meshopt_compression"]),
        |json| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        |json| drop(json["accessors"][0].as_object_mut().unwrap().remove("bufferView")),
        |json| json["scenes"] = json!([{}]),
        |json| drop(json["animations"][0]["channels"][0]["target"].as_object_mut().unwrap().remove("node")),
    ];
    for (index, edit) in edits.iter().enumerate() {
        let mut json = good.clone();
        edit(&mut json);
        let findings = of_json(&json).findings;
        let told = findings.iter().any(|f| f.engine == "Bevy" && f.severity == Severity::Refuses);
        assert_eq!((refuses(&json), told), (index > 0, index > 0), "{index}: {findings:?}");
    }
}

#[test]
fn whatever_the_json_holds_is_fine() {
    let huge = json!({ "bufferView": 0, "count": u64::MAX });
    let mut json = document(&[mesh("a", 0, 300, &["POSITION", "NORMAL"]), mesh("b", 7, 1, &["POSITION"])]);
    json["accessors"][0] = huge;
    json["accessors"][1] = json!("none");
    assert_eq!(of_json(&json).memory[0].bytes, Some(u64::MAX));
    let twice = json["meshes"][0]["primitives"][0].clone();
    json["meshes"][0]["primitives"] = json!([twice, twice, 1, {}]);
    for odd in
        [json, json!(null), json!([]), json!({ "meshes": [1, { "primitives": { "a": 1 } }], "scenes": 2 })]
    {
        drop(of_json(&odd));
    }
}

#[test]
fn a_warning_tells_what_is_new_alone() {
    let of = |counts: [usize; 2]| {
        of_json(&document(&counts.map(|targets| mesh("drop", 1, targets, &["POSITION", "NORMAL"]))))
    };
    let warning = |before, after| of(after).note(&of(before));
    assert_eq!(warning([0, 0], [64, 64]), None);
    assert_eq!(warning([100, 0], [110, 3]), None);
    let bevy = "Bevy up to 0.17: mesh \"drop\" has 120 targets, it takes 64";
    assert_eq!(warning([0, 0], [120, 3]).unwrap(), format!("{bevy} [engines]"));
    assert_eq!(warning([120, 0], [120, 65]).unwrap(), format!("{bevy}; so with 1 more [engines]"));
    let both = warning([120, 0], [250, 0]).unwrap();
    assert_eq!(both, "phones: mesh \"drop\" has 250 targets, above 241 some show nothing of it [engines]");
}
