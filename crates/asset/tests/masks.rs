//! Colours, joint weights and names: what masks are made of.

use serde_json::json;
use wirework_asset::{ErrorClass, Gltf, Limits, Obj, Place};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{Doc, skinned, triangle};

fn attribute(doc: &mut Doc, name: &str, accessor: usize) {
    doc.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
}

fn colors(doc: &Doc) -> Result<Option<Vec<[f32; 4]>>, wirework_asset::AssetError> {
    let gltf = doc.open().unwrap();
    let mut blocks = gltf.colors(&gltf.rest().unwrap())?;
    assert_eq!(blocks.len(), 1);
    Ok(blocks.remove(0))
}

#[test]
fn colours_of_all_types_are_read_as_the_standard_says() {
    let mut doc = triangle(json!({}));
    assert_eq!(colors(&doc).unwrap(), None);
    let accessor = doc.floats("VEC3", &[0.25, 0.5, 1.0, -1.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    attribute(&mut doc, "COLOR_0", accessor);
    let black = [0.0, 0.0, 0.0, 1.0];
    assert_eq!(colors(&doc).unwrap().unwrap(), [[0.25, 0.5, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0], black]);

    let accessor = doc.floats("VEC4", &[0.25, 0.5, 1.0, 0.75].repeat(3));
    attribute(&mut doc, "COLOR_0", accessor);
    assert_eq!(colors(&doc).unwrap().unwrap(), [[0.25, 0.5, 1.0, 0.75]; 3]);

    let bytes = json!({ "componentType": 5121, "type": "VEC4", "count": 3, "normalized": true });
    let accessor = doc.accessor(bytes.clone(), &[0, 51, 102, 255].repeat(3));
    attribute(&mut doc, "COLOR_0", accessor);
    assert_eq!(colors(&doc).unwrap().unwrap(), [[0.0, 0.2, 0.4, 1.0]; 3]);

    let words: Vec<u8> = [0_u16, 13107, 65535].repeat(4).iter().flat_map(|c| c.to_le_bytes()).collect();
    let accessor = doc.accessor(
        json!({ "componentType": 5123, "type": "VEC3", "count": 3, "normalized": true }),
        &words[..24],
    );
    // Three words of two bytes each, eight bytes apart.
    let view = doc.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    doc.json["bufferViews"][view]["byteStride"] = json!(8);
    attribute(&mut doc, "COLOR_0", accessor);
    let found = colors(&doc).unwrap().unwrap();
    assert_eq!(found, [[0.0, 0.2, 1.0, 1.0], [0.2, 1.0, 0.0, 1.0], [1.0, 0.0, 0.2, 1.0]]);
}

#[test]
fn broken_colours_harm_only_those_who_read_them() {
    let mut doc = triangle(json!({}));
    let bad = [
        doc.floats("VEC3", &[f32::NAN; 9]),
        doc.floats("VEC2", &[0.0; 6]),
        doc.accessor(json!({ "componentType": 5121, "type": "VEC4", "count": 3 }), &[0; 12]),
    ];
    for accessor in bad {
        attribute(&mut doc, "COLOR_0", accessor);
        let error = colors(&doc).unwrap_err();
        assert_eq!((error.class, error.file.as_str()), (ErrorClass::Asset, "made.glb"));
        assert_eq!(error.place, Place::Pointer(format!("/accessors/{accessor}")));
    }
    // A sparse accessor without data asks for memory that the file does not have.
    let count = 3;
    doc.json["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "componentType": 5126, "type": "VEC3", "count": count }));
    let last = doc.json["accessors"].as_array().unwrap().len() - 1;
    attribute(&mut doc, "COLOR_0", last);
    let limits = Limits { expanded_bytes: 300, ..Limits::default() };
    let gltf = Gltf::from_slice(&doc.glb(), "made.glb", &limits).unwrap();
    let rest = gltf.rest().unwrap();
    assert!(gltf.colors(&rest).is_ok());
    let limits = Limits { expanded_bytes: 80, ..limits };
    let gltf = Gltf::from_slice(&doc.glb(), "made.glb", &limits).unwrap();
    assert_eq!(gltf.colors(&rest).unwrap_err().class, ErrorClass::Limit);
}

/// Of `skinned`: vertex 0 has these weights for nodes 1 and 2, vertex 1 hangs on node 1, vertex 2 on node 2.
fn hold(weights: [f32; 4], joints: &[usize]) -> (Vec<f32>, Vec<usize>) {
    let gltf = skinned(weights).open().unwrap();
    let held = gltf.joint_weights(&gltf.rest().unwrap(), joints).unwrap();
    (held.of_vertices, held.used)
}

#[test]
fn joint_weights_are_parts_of_the_whole() {
    let weights = [0.5, 0.25, 0.0, 0.25];
    assert_eq!(hold(weights, &[1]), (vec![0.75, 1.0, 0.0], vec![1]));
    assert_eq!(hold(weights, &[2]), (vec![0.25, 0.0, 1.0], vec![2]));
    assert_eq!(hold(weights, &[2, 1, 1]), (vec![1.0; 3], vec![1, 2]));
    assert_eq!(hold(weights, &[0, 9]), (vec![0.0; 3], vec![]));
    // What does not add up is normalised, in parts of any kind exactly to 1.
    assert_eq!(hold([0.2, 0.2, 0.0, 0.0], &[2]).0[0], 0.5);
    assert_eq!(hold([0.1, 0.7, 0.3, 0.9], &[1, 2]).0[0], 1.0);
    // Without any weight a vertex is shown at its first joint.
    assert_eq!(hold([0.0; 4], &[1]).0[0], 1.0);
    assert_eq!(hold([0.0; 4], &[2]).0[0], 0.0);
    let gltf = skinned(weights).open().unwrap();
    assert_eq!(gltf.joint_nodes(), [1, 2]);
}

#[test]
fn all_sets_of_weights_count_and_what_has_no_skin_hangs_on_nothing() {
    let mut doc = skinned([0.5, 0.0, 0.0, 0.0]);
    let joints =
        doc.accessor(json!({ "componentType": 5121, "type": "VEC4", "count": 3 }), &[1, 0, 0, 0].repeat(3));
    let weights = doc.floats("VEC4", &[0.5, 0.0, 0.0, 0.0].repeat(3));
    attribute(&mut doc, "JOINTS_1", joints);
    attribute(&mut doc, "WEIGHTS_1", weights);
    let mesh = doc.json["nodes"][0]["mesh"].clone();
    doc.node(json!({ "mesh": mesh }));
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let held = gltf.joint_weights(&rest, &[2]).unwrap();
    let third = (0.5 / 1.5) as f32;
    let by_node = |node: usize| rest.blocks.iter().find(|block| block.node == node).unwrap().first;
    let (skin, bare) = (by_node(0), by_node(3));
    assert_eq!(held.of_vertices[skin..skin + 3], [0.5, third, 1.0]);
    assert_eq!(held.of_vertices[bare..bare + 3], [0.0; 3]);
}

#[test]
fn a_node_stands_for_its_mesh_and_a_bare_node_for_all_below_it() {
    let mut doc = triangle(json!({ "name": "a", "children": [1] }));
    for node in [
        json!({ "name": "b", "mesh": 0 }),
        json!({ "name": "bare", "children": [3, 4] }),
        json!({ "children": [0] }),
        json!({ "mesh": 0 }),
        json!({ "name": "empty" }),
    ] {
        doc.node(node);
    }
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    assert_eq!(gltf.mesh_nodes(&[0]), [0]);
    assert_eq!(gltf.mesh_nodes(&[2]), [0, 1, 4]);
    assert_eq!(gltf.mesh_nodes(&[0, 3]), [0, 1]);
    assert_eq!(gltf.mesh_nodes(&[5, 99]), [0_usize; 0]);
    let of = gltf.vertices_of_nodes(&rest, &[1]);
    for block in &rest.blocks {
        assert!(of[block.first..block.first + block.count].iter().all(|&of| of == (block.node == 1)));
    }
    assert_eq!(of.iter().filter(|&&of| of).count(), 3);
}

#[test]
fn a_vertex_has_a_material_where_all_its_primitives_have() {
    // Two triangles of one vertex set, 0 1 2 and 1 2 3, and a vertex that none uses.
    let mut doc = Doc::new();
    let positions = doc.floats("VEC3", &[0.0; 15]);
    let lists = [[0, 1, 2], [1, 2, 3]].map(|list: [u8; 3]| {
        doc.accessor(json!({ "componentType": 5121, "type": "SCALAR", "count": 3 }), &list)
    });
    let primitive = |indices: usize, material: usize| json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": material });
    let mesh = doc.mesh(&primitive(lists[0], 0));
    doc.json["meshes"][mesh]["primitives"].as_array_mut().unwrap().push(primitive(lists[1], 1));
    doc.json["materials"] = json!([{ "name": "cloth" }, { "name": "skin" }, {}]);
    doc.node(json!({ "mesh": mesh }));
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let of = |materials: &[usize]| gltf.vertices_of_materials(&rest, materials).unwrap();
    assert_eq!(of(&[0]), [true, false, false, false, true]);
    assert_eq!(of(&[1]), [false, false, false, true, true]);
    assert_eq!(of(&[0, 1]), [true; 5]);
    assert_eq!(of(&[2]), [false; 5]);
    assert_eq!(of(&[]), [false; 5]);
    assert_eq!(
        (gltf.material_count(), gltf.material_name(1), gltf.material_name(2)),
        (3, Some("skin"), None)
    );
    // A primitive that lists no indices uses them all.
    doc.json["meshes"][mesh]["primitives"][1].as_object_mut().unwrap().shift_remove("indices");
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    assert_eq!(gltf.vertices_of_materials(&rest, &[0]).unwrap(), [false; 5]);
    assert_eq!(gltf.vertices_of_materials(&rest, &[1]).unwrap(), [false, false, false, true, true]);
}

const PARTS: &str = "o body one
v 0 0 0 1 0 0.5
v 1 0 0
v 1 1 0 2
v 0 1 0
usemtl red \\
  paint # not this
f 1 2 3
g arm left
f 3 4 1
o hat
usemtl blue
f 2 3 4
g
v 5 5 5
";

#[test]
fn groups_and_materials_of_faces_come_from_the_text() {
    let obj = Obj::from_slice(PARTS.as_bytes(), "made.obj", &Limits::default()).unwrap();
    assert_eq!(obj.group_names(), ["arm", "body one", "default", "hat", "left"]);
    assert_eq!(obj.material_names(), ["blue", "red paint"]);
    let of = |names: &[&str]| obj.in_groups(names).of_positions;
    assert_eq!(of(&["body one"]), [true, false, false, false, false]);
    assert_eq!(of(&["body one", "hat"]), [true, true, true, true, true]);
    assert_eq!(of(&["hat", "left"]), [false, false, false, true, true]);
    assert_eq!(of(&["default"]), [false, false, false, false, true]);
    assert_eq!(of(&["arm"]), of(&["left"]));
    assert_eq!(obj.of_materials(&["blue"]).of_positions, [false, false, false, false, true]);
    assert_eq!(obj.of_materials(&["none"]).of_positions, [false; 5]);
    let used = |names: &[&str]| Vec::from_iter(obj.in_groups(names).used);
    assert_eq!(used(&["arm", "default", "hat", "none"]), ["arm", "hat"], "no face is in the last group");
    assert_eq!(used(&["body one"]), ["body one"]);
    let colors = obj.colors().unwrap().unwrap();
    assert_eq!(colors, [Some([1.0, 0.0, 0.5, 1.0]), None, None, None, None]);
}

#[test]
fn points_of_a_cloud_are_in_the_group_of_their_line() {
    let obj =
        Obj::from_slice(b"\xef\xbb\xbfg a\nv 0 0 0\ng b\nv 1 0 0 0.5 7 -1\n", "p.obj", &Limits::default())
            .unwrap();
    assert_eq!(obj.in_groups(&["b"]).of_positions, [false, true]);
    assert_eq!(obj.colors().unwrap().unwrap()[1], Some([0.5, 1.0, 0.0, 1.0]));
    let plain = Obj::from_slice(b"v 0 0 0\n", "p.obj", &Limits::default()).unwrap();
    assert_eq!(plain.colors().unwrap(), None);
    assert!(plain.group_names().is_empty() && plain.material_names().is_empty());
    let broken = Obj::from_slice(b"v 0 0 0\nv 0 0 0 1 1 nan\n", "p.obj", &Limits::default()).unwrap();
    let error = broken.colors().unwrap_err();
    assert_eq!((error.place, error.file.as_str()), (Place::Line(2), "p.obj"));
}
