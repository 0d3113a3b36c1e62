//! The counts of nodes, joints, materials and groups, against the functions that choose by each of them alone.

use std::collections::BTreeMap;

use serde_json::json;
use wirework_asset::{Gltf, Limits, NodeCensus, Obj, Rest};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, skinned, triangle};

fn count(chosen: &[bool]) -> usize {
    chosen.iter().filter(|chosen| **chosen).count()
}

/// Compares every number with what the choice of that one node, joint or material finds.
fn check(gltf: &Gltf, rest: &Rest) -> Vec<NodeCensus> {
    let census = gltf.node_census(rest).unwrap();
    let joints = gltf.joint_nodes();
    let mut listed = Vec::new();
    for entry in &census {
        let node = entry.node;
        let shown = gltf.mesh_nodes(&[node]);
        assert_eq!(entry.mesh_nodes, shown.len(), "node {node}");
        assert_eq!(entry.vertices, count(&gltf.vertices_of_nodes(rest, &shown)), "node {node}");
        let held = gltf.joint_weights(rest, &[node]).unwrap().of_vertices;
        assert_eq!(entry.joint_vertices, held.iter().filter(|weight| **weight > 0.0).count(), "node {node}");
        assert_eq!(entry.joint_of.is_empty(), !joints.contains(&node), "node {node}");
        listed.push(node);
    }
    for node in 0..gltf.node_count() {
        let wanted = joints.contains(&node) || !gltf.mesh_nodes(&[node]).is_empty();
        assert_eq!(listed.contains(&node), wanted, "node {node}");
    }
    let materials = gltf.material_census(rest).unwrap();
    assert_eq!(materials.len(), gltf.material_count());
    for (material, &found) in materials.iter().enumerate() {
        let chosen = gltf.vertices_of_materials(rest, &[material]).unwrap();
        assert_eq!(found, count(&chosen), "material {material}");
    }
    census
}

fn check_doc(doc: &Doc) -> Vec<NodeCensus> {
    let gltf = doc.open().unwrap();
    check(&gltf, &gltf.rest().unwrap())
}

#[test]
fn joints_have_their_vertices_and_their_place() {
    for weights in [[0.5, 0.25, 0.0, 0.25], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0; 4]] {
        let mut doc = skinned(weights);
        // A parent that is no joint moves its joints, and stands for no mesh.
        doc.json["nodes"][1]["translation"] = json!([1, 0, 0]);
        doc.json["nodes"][2]["translation"] = json!([0, 2, 0]);
        doc.node(json!({ "translation": [0, 0, -3], "scale": [2, 2, 2], "children": [1] }));
        let census = check_doc(&doc);
        let place = |node: usize| census.iter().find(|entry| entry.node == node).unwrap().position;
        assert_eq!((place(1), place(2)), ([2.0, 0.0, -3.0], [2.0, 4.0, -3.0]));
        assert_eq!(census.iter().map(|entry| entry.node).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(census[1].joint_of, [0]);
        assert_eq!((census[0].mesh, census[1].mesh), (Some(0), None));
    }
}

#[test]
fn a_joint_that_holds_a_vertex_twice_holds_it_once() {
    let mut doc = skinned([0.5, 0.25, 0.0, 0.25]);
    let joints =
        doc.accessor(json!({ "componentType": 5121, "type": "VEC4", "count": 3 }), &[1, 0, 1, 0].repeat(3));
    let weights = doc.floats("VEC4", &[0.5, 0.0, 0.25, 0.0].repeat(3));
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) = (json!(joints), json!(weights));
    let mut second = doc.json["skins"][0].clone();
    second["joints"] = json!([2, 2, 2, 1]);
    second.as_object_mut().unwrap().remove("inverseBindMatrices");
    doc.json["skins"].as_array_mut().unwrap().push(second);
    doc.node(json!({ "mesh": 0, "skin": 1 }));
    let census = check_doc(&doc);
    assert_eq!(census.iter().find(|entry| entry.node == 2).unwrap().joint_of, [0, 1]);
    // All three of both meshes: by the second set of weights of the first; and all joints that the other uses are it.
    assert_eq!(census.iter().find(|entry| entry.node == 2).unwrap().joint_vertices, 6);
}

#[test]
fn bare_nodes_stand_for_all_meshes_below_them() {
    let mut doc = triangle(json!({ "name": "a", "children": [1] }));
    for node in [
        json!({ "mesh": 0 }),
        json!({ "children": [3, 4] }),
        json!({ "children": [0] }),
        json!({ "mesh": 0 }),
        json!({ "name": "empty" }),
        json!({ "mesh": 0, "name": "not in the scene" }),
    ] {
        doc.node(node);
    }
    doc.json["scenes"] = json!([{ "nodes": [2, 5] }]);
    let census = check_doc(&doc);
    let rows: Vec<_> = census.iter().map(|entry| (entry.node, entry.mesh_nodes, entry.vertices)).collect();
    assert_eq!(rows, [(0, 1, 3), (1, 1, 3), (2, 3, 9), (3, 2, 6), (4, 1, 3), (6, 1, 0)]);
}

#[test]
fn a_long_chain_of_nodes_is_counted_at_once() {
    let length = 20_000;
    let mut doc = triangle(json!({ "children": [1] }));
    for node in 1..length {
        doc.node(json!({ "mesh": 0, "children": [node + 1] }));
    }
    doc.node(json!({ "mesh": 0 }));
    doc.json["nodes"][0].as_object_mut().unwrap().remove("mesh");
    let gltf = doc.open().unwrap();
    let census = gltf.node_census(&gltf.rest().unwrap()).unwrap();
    assert_eq!((census[0].mesh_nodes, census[0].vertices), (length, 3 * length));
}

#[test]
fn materials_that_share_vertices_count_their_own() {
    let mut doc = triangle(json!({}));
    let positions = doc.floats("VEC3", &[0.0; 21]);
    let list = |doc: &mut Doc, list: &[u16]| {
        let bytes: Vec<u8> = list.iter().flat_map(|i| i.to_le_bytes()).collect();
        let accessor = json!({ "componentType": 5123, "type": "SCALAR", "count": list.len() });
        doc.accessor(accessor, &bytes)
    };
    let indices = [list(&mut doc, &[0, 1, 2]), list(&mut doc, &[2, 3, 4]), list(&mut doc, &[4, 5, 0])];
    let part = |indices: Option<usize>, material: Option<usize>| {
        let mut part = json!({ "attributes": { "POSITION": positions } });
        part.as_object_mut().unwrap().extend(
            [("indices", indices), ("material", material)]
                .into_iter()
                .filter_map(|(key, value)| Some((key.to_owned(), json!(value?)))),
        );
        part
    };
    let [a, b, c] = indices.map(Some);
    doc.json["materials"] = json!([{}, {}, {}]);
    for (parts, counts) in [
        // Vertex 6 is in no triangle, and so belongs to all.
        (vec![part(a, Some(0)), part(b, Some(1)), part(c, Some(0))], [4, 2, 0]),
        (vec![part(a, Some(2)), part(b, None), part(c, Some(0))], [2, 0, 2]),
        (vec![part(a, Some(1)), part(b, Some(1))], [0, 7, 0]),
        (vec![part(a, Some(0)), part(None, Some(1))], [0, 4, 0]),
    ] {
        doc.json["meshes"][0]["primitives"] = json!(parts);
        check_doc(&doc);
        let gltf = doc.open().unwrap();
        assert_eq!(gltf.material_census(&gltf.rest().unwrap()).unwrap(), counts);
    }
}

fn obj(text: &str) -> Obj {
    Obj::from_slice(text.as_bytes(), "made.obj", &Limits::default()).unwrap()
}

fn check_obj(obj: &Obj) {
    let each = |names: Vec<String>, chosen: &dyn Fn(&str) -> usize| -> BTreeMap<String, usize> {
        names.into_iter().map(|name| (name.clone(), chosen(&name))).collect()
    };
    let groups = each(obj.group_names(), &|name| count(&obj.in_groups(&[name]).of_positions));
    assert_eq!(obj.group_census(), groups);
    let materials = each(obj.material_names(), &|name| count(&obj.of_materials(&[name]).of_positions));
    assert_eq!(obj.material_census(), materials);
}

#[test]
fn groups_and_materials_of_an_obj_have_their_positions() {
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 2 2\n";
    let text = format!(
        "o one thing\n{points}usemtl red\nf 1 2 3\ng a b a\nusemtl blue\nf 2 3 4\ng\ng b c\nf -2 2 1\nv 9 9 9\no\nusemtl none\nv 8 8 8\n"
    );
    let obj = obj(&text);
    check_obj(&obj);
    let found = obj.group_census();
    assert_eq!(found["one thing"], 6, "{found:?}");
    // All faces of the fourth position are in `b`, some of the second are not.
    assert_eq!((found["a"], found["b"], found["c"], found["default"]), (0, 2, 1, 0), "{found:?}");
    assert_eq!(
        obj.material_census(),
        [("blue", 2), ("none", 1), ("red", 0)].map(|(name, n)| (name.to_owned(), n)).into()
    );
}

#[test]
fn random_groups_count_as_each_of_them_alone() {
    // A linear congruential generator: the same files every time.
    let mut state = 7_u64;
    let mut roll = |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    for _ in 0..200 {
        let mut lines = vec!["v 0 0 0".to_owned(), "v 1 0 0".to_owned(), "v 0 1 0".to_owned()];
        let mut points = 3;
        for _ in 0..30 {
            lines.push(match roll(7) {
                0 => format!("g {}", ["", "a", "b", "a b", "b c d", "c"][roll(6) as usize]),
                1 => format!("o {}", ["", "a", "e f"][roll(3) as usize]),
                2 => format!("usemtl {}", ["", "a", "b c"][roll(3) as usize]),
                3 => {
                    points += 1;
                    "v 0 1 2".to_owned()
                }
                _ => format!("f {} {} {}", roll(points) + 1, roll(points) + 1, roll(points) + 1),
            });
        }
        let text = lines.join("\n");
        check_obj(&obj(&text));
    }
    check_obj(&obj("g cloud\nv 0 0 0\ng other\nv 1 1 1\n"));
}

#[test]
fn real_characters_count_as_each_joint_alone() {
    for name in ["rigged/cesium_man.glb", "rigged/robot.glb", "multi/milk_truck.gltf"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets").join(name);
        if !path.exists() {
            eprintln!("the shared assets are not present: {name} is passed over");
            continue;
        }
        let gltf = Gltf::read(&path, &Limits::default()).unwrap();
        check(&gltf, &gltf.rest().unwrap());
    }
}
