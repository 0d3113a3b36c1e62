//! Rest geometry of documents small enough to know the answer.

use serde_json::json;
use wirework_asset::{ErrorClass, Mode, Place};

mod make;
use make::{Doc, skinned, triangle};

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn parents_and_matrices_place_a_mesh() {
    // Column by column: x goes to y, y to −x, and everything 10 along z.
    let matrix = json!([0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 10, 1]);
    let mut doc = triangle(json!({ "matrix": matrix }));
    doc.node(json!({ "children": [0], "translation": [1, 0, 0], "scale": [2, 2, 2] }));
    let rest = doc.rest().unwrap();
    assert!(close(rest.positions[1], [1.0, 2.0, 20.0]), "{:?}", rest.positions);
    assert!(close(rest.positions[2], [-1.0, 0.0, 20.0]));
    assert!(close(rest.blocks[0].normals.as_ref().unwrap()[0], [0.0, 0.0, 1.0]));
    assert_eq!(rest.triangles, [[0, 1, 2]]);
}

#[test]
fn a_mirrored_node_keeps_the_outside_outside() {
    let rest = triangle(json!({ "scale": [-1, 1, 1] })).rest().unwrap();
    assert_eq!(rest.triangles, [[0, 2, 1]]);
    assert!(close(rest.blocks[0].normals.as_ref().unwrap()[0], [0.0, 0.0, 1.0]));
}

#[test]
fn normals_go_through_the_inverse_transpose() {
    let mut doc = Doc::new();
    let positions = doc.floats("VEC3", &[0.0; 9]);
    let n = 0.5_f32.sqrt();
    let normals = doc.floats("VEC3", &[n, n, 0.0].repeat(3));
    let mesh = doc.mesh(&json!({ "attributes": { "POSITION": positions, "NORMAL": normals } }));
    doc.node(json!({ "mesh": mesh, "scale": [2, 1, 1] }));
    let rest = doc.rest().unwrap();
    let length = 1.25_f32.sqrt();
    assert!(close(rest.blocks[0].normals.as_ref().unwrap()[0], [0.5 / length, 1.0 / length, 0.0]));
}

#[test]
fn a_skin_poses_the_vertices_and_its_node_does_not() {
    let rest = skinned([0.5, 0.5, 0.0, 0.0]).rest().unwrap();
    // Joint 1 is where it was bound, joint 2 is 3 along z from there.
    assert!(close(rest.positions[0], [0.0, 0.0, 1.5]));
    assert!(close(rest.positions[1], [1.0, 0.0, 0.0]));
    assert!(close(rest.positions[2], [0.0, 1.0, 3.0]));
    assert!(rest.warnings.iter().all(|w| w.code == "bounds"), "{:?}", rest.warnings);
}

#[test]
fn weights_are_normalised_with_a_warning() {
    let rest = skinned([0.2, 0.2, 0.0, 0.0]).rest().unwrap();
    assert!(close(rest.positions[0], [0.0, 0.0, 1.5]));
    assert!(rest.warnings.iter().any(|w| w.code == "weights-sum"));
    let rest = skinned([0.0; 4]).rest().unwrap();
    assert!(close(rest.positions[0], [0.0; 3]));
    assert!(rest.warnings.iter().any(|w| w.code == "weights-zero"));
    for bad in [f32::NAN, -0.5] {
        assert_eq!(skinned([bad, 1.0, 0.0, 0.0]).rest().unwrap_err().class, ErrorClass::Asset);
    }
}

#[test]
fn default_morph_weights_are_part_of_the_rest() {
    let mut doc = triangle(json!({}));
    let deltas = doc.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": deltas }]);
    doc.json["meshes"][0]["weights"] = json!([0.5]);
    assert_eq!(doc.rest().unwrap().positions[0], [0.0, 0.0, 1.0]);
    doc.json["nodes"][0]["weights"] = json!([0.25]);
    assert_eq!(doc.rest().unwrap().positions[0], [0.0, 0.0, 0.5]);
    doc.json["nodes"][0]["weights"] = json!([0.25, 0]);
    assert_eq!(doc.rest().unwrap_err().place, Place::Pointer("/nodes/0/weights".into()));
}

#[test]
fn quantised_interleaved_sparse_and_absent_data_are_read() {
    let mut doc = triangle(json!({}));
    let data: Vec<u8> =
        [[-127_i8, 0, 127, 9], [-128, 64, 0, 9], [1, 2, 3, 9]].concat().iter().map(|&b| b as u8).collect();
    let accessor =
        doc.accessor(json!({ "componentType": 5120, "type": "VEC3", "count": 3, "normalized": true }), &data);
    let view = doc.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
    doc.json["bufferViews"][view]["byteStride"] = json!(4);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
    assert!(doc.rest().is_err(), "small integers need the extension");
    doc.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let positions = doc.rest().unwrap().positions;
    assert!(close(positions[0], [-1.0, 0.0, 1.0]) && close(positions[1], [-1.0, 64.0 / 127.0, 0.0]));
    doc.json["accessors"][accessor]["normalized"] = json!(false);
    assert_eq!(doc.rest().unwrap().positions[1], [-128.0, 64.0, 0.0]);

    let (indices, values) = (doc.view(&[1, 0]), doc.view(&7.0_f32.to_le_bytes().repeat(3)));
    let sparse = json!({
        "count": 1, "indices": { "bufferView": indices, "componentType": 5123 }, "values": { "bufferView": values },
    });
    doc.json["accessors"][0]["sparse"] = sparse.clone();
    doc.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(0);
    assert_eq!(doc.rest().unwrap().positions, [[0.0; 3], [7.0; 3], [0.0, 1.0, 0.0]]);
    doc.json["accessors"][0].as_object_mut().unwrap().shift_remove("bufferView");
    assert_eq!(doc.rest().unwrap().positions, [[0.0; 3], [7.0; 3], [0.0; 3]]);
    doc.json["accessors"][0].as_object_mut().unwrap().shift_remove("sparse");
    assert_eq!(doc.rest().unwrap().positions, [[0.0; 3]; 3]);
    doc.json["accessors"][0]["count"] = json!(4_000_000_000_u64);
    doc.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    assert_eq!(doc.rest().unwrap_err().class, ErrorClass::Limit, "zeros are charged before they are made");
}

#[test]
fn all_modes_give_their_triangles() {
    let expected: [(Mode, &[[u32; 3]]); 7] = [
        (Mode::Points, &[]),
        (Mode::Lines, &[]),
        (Mode::LineLoop, &[]),
        (Mode::LineStrip, &[]),
        (Mode::Triangles, &[[0, 1, 2], [2, 1, 3]]),
        (Mode::TriangleStrip, &[[0, 1, 2], [2, 1, 3], [1, 3, 0]]),
        (Mode::TriangleFan, &[[1, 2, 0], [2, 1, 0], [1, 3, 0]]),
    ];
    for (mode, (kind, triangles)) in expected.iter().enumerate() {
        for (component, size) in [(5121, 1), (5123, 2), (5125, 4)] {
            let mut doc = Doc::new();
            let positions = doc.floats("VEC3", &[0.0; 12]);
            let list: &[u32] = match kind {
                Mode::TriangleStrip => &[0, 1, 2, 3, 1, 1, 0],
                Mode::Triangles | Mode::TriangleFan => &[0, 1, 2, 2, 1, 3],
                _ => &[0, 1, 2, 3],
            };
            let list = if *kind == Mode::TriangleFan { &[0, 1, 2, 1, 3][..] } else { list };
            let bytes: Vec<u8> = list.iter().flat_map(|i| i.to_le_bytes()[..size].to_vec()).collect();
            let indices = doc.accessor(
                json!({ "componentType": component, "type": "SCALAR", "count": list.len() }),
                &bytes,
            );
            let primitive =
                json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode });
            let mesh = doc.mesh(&primitive);
            doc.node(json!({ "mesh": mesh }));
            let rest = doc.rest().unwrap();
            assert_eq!(rest.parts[0].mode, *kind);
            let want: Vec<[u32; 3]> = match kind {
                // 0 1 2 | 2 1 3 | 2 3 1 | the rest is degenerate.
                Mode::TriangleStrip => vec![[0, 1, 2], [1, 3, 2], [2, 3, 1]],
                _ => triangles.to_vec(),
            };
            assert_eq!(rest.triangles, want, "{kind:?}");
        }
    }
}

#[test]
fn the_scene_decides_what_is_shown() {
    let mut doc = triangle(json!({}));
    let mesh = doc.json["nodes"][0]["mesh"].clone();
    doc.node(json!({ "mesh": mesh, "translation": [9, 0, 0] }));
    assert_eq!(doc.rest().unwrap().parts.len(), 2, "without scenes all roots");
    doc.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [0] }]);
    assert_eq!(doc.rest().unwrap().positions[0], [9.0, 0.0, 0.0], "the first scene");
    doc.json["scene"] = json!(1);
    assert_eq!(doc.rest().unwrap().positions[0], [0.0; 3]);
    doc.json["scenes"][1]["nodes"] = json!([]);
    assert_eq!(doc.rest().unwrap_err().expected, "geometry");
}

#[test]
fn primitives_with_the_same_attributes_share_their_vertices() {
    let mut doc = triangle(json!({}));
    let primitive = doc.json["meshes"][0]["primitives"][0].clone();
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let rest = doc.rest().unwrap();
    assert_eq!((rest.blocks.len(), rest.parts.len(), rest.positions.len()), (1, 2, 3));
}

#[test]
fn faults_are_named_by_their_place() {
    type Fault = (&'static str, fn(&mut Doc));
    let faults: [Fault; 12] = [
        ("/nodes/0/children", |doc| doc.json["nodes"][0]["children"] = json!([0])),
        ("/nodes/0/children/0", |doc| doc.json["nodes"][0]["children"] = json!([7])),
        ("/nodes/0/matrix", |doc| doc.json["nodes"][0]["matrix"] = json!(vec![1; 17])),
        ("/nodes/0/mesh", |doc| doc.json["nodes"][0]["mesh"] = json!(3)),
        ("/accessors/0/componentType", |doc| doc.json["accessors"][0]["componentType"] = json!(5124)),
        ("/accessors/0", |doc| doc.json["accessors"][0]["count"] = json!(4)),
        ("/accessors/0/byteOffset", |doc| doc.json["accessors"][0]["byteOffset"] = json!(2)),
        ("/accessors/0/byteOffset", |doc| doc.json["accessors"][0]["byteOffset"] = json!(-4)),
        ("/bufferViews/0/byteStride", |doc| doc.json["bufferViews"][0]["byteStride"] = json!(13)),
        ("/bufferViews/0/byteLength", |doc| doc.json["bufferViews"][0]["byteLength"] = json!(4000)),
        ("/meshes/0/primitives/0/attributes/NORMAL", |doc| doc.json["accessors"][1]["count"] = json!(2)),
        ("/extensionsRequired/0", |doc| doc.json["extensionsRequired"] = json!(["VENDOR_storage"])),
    ];
    for (pointer, spoil) in faults {
        let mut doc = triangle(json!({}));
        spoil(&mut doc);
        let error = doc.rest().unwrap_err();
        assert_eq!(error.place, Place::Pointer(pointer.into()), "{error}");
        assert_eq!((error.class, error.file.as_str()), (ErrorClass::Asset, "made.glb"));
    }
}

#[test]
fn indices_and_joints_out_of_range_are_refused() {
    let mut doc = triangle(json!({}));
    for bad in [3_u8, 255] {
        let indices =
            doc.accessor(json!({ "componentType": 5121, "type": "SCALAR", "count": 3 }), &[0, 1, bad]);
        doc.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        assert!(doc.rest().unwrap_err().found.contains(&format!("index {bad} at element 2")));
    }
    let mut doc = skinned([1.0, 0.0, 0.0, 0.0]);
    doc.json["skins"][0]["joints"] = json!([1]);
    assert!(doc.rest().unwrap_err().found.contains("joint 1"));
}

#[test]
fn deltas_come_back_through_node_and_skin() {
    let mut doc = skinned([0.5, 0.5, 0.0, 0.0]);
    doc.json["nodes"][1]["scale"] = json!([2, 2, 2]);
    let rest = doc.rest().unwrap();
    let mut moved = rest.positions.clone();
    for p in &mut moved {
        p[0] += 1.0;
    }
    let deltas = rest.to_local(0, &moved, None, None);
    assert!(deltas.positions.iter().all(|d| close(*d, [0.5, 0.0, 0.0])), "{deltas:?}");
    assert!(!rest.to_local(0, &rest.positions, rest.blocks[0].normals.as_deref(), None).moves());
}

#[test]
fn a_singular_transform_lets_nothing_move() {
    let mut doc = triangle(json!({ "scale": [1, 1, 0] }));
    let rest = doc.rest().unwrap();
    let mut moved = rest.positions.clone();
    moved[1][0] += 1.0;
    let deltas = rest.to_local(0, &moved, None, None);
    assert_eq!((deltas.stuck, deltas.moves()), (1, false));
    doc.json["nodes"][0]["scale"] = json!([1e-30, 1e-30, 1e-30]);
    let rest = doc.rest().unwrap();
    assert!(rest.to_local(0, &[[1e-30; 3]; 3], None, None).moves(), "small is not singular");
}

/// [`skinned`] with tangents along x, and these materials.
fn with_tangents(tangents: &[f32], materials: &serde_json::Value) -> Doc {
    let mut doc = skinned([0.5, 0.5, 0.0, 0.0]);
    let tangents = doc.floats("VEC4", tangents);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TANGENT"] = json!(tangents);
    primitive["material"] = json!(0);
    doc.json["materials"] = materials.clone();
    doc
}

const ALONG_X: [f32; 12] = [1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0];

#[test]
fn tangents_go_through_the_linear_part_and_back() {
    let mut doc = with_tangents(&ALONG_X, &json!([{ "normalTexture": { "index": 0 } }]));
    // A quarter turn about y: x becomes −z; and −3 times that.
    let half = 0.5_f64.sqrt();
    doc.json["nodes"][1]["rotation"] = json!([0, half, 0, half]);
    doc.json["nodes"][1]["scale"] = json!([-3, 1, 1]);
    let rest = doc.rest().unwrap();
    let tangents = rest.blocks[0].tangents.clone().unwrap();
    assert!(close(tangents[0], [0.0, 0.0, 1.0]) && close(tangents[1], [0.0, 0.0, 1.0]), "{tangents:?}");
    assert_eq!(tangents[2], [0.0; 3], "none stays none");
    assert!(rest.parts[0].normal_mapped);
    assert_eq!(rest.to_local(0, &rest.positions, None, Some(&tangents)).tangents.unwrap(), [[0.0; 3]; 3]);
    let slanted = [[0.0, half as f32, half as f32], tangents[1], tangents[2]];
    let deltas = rest.to_local(0, &rest.positions, None, Some(&slanted));
    // (0, 1, 1) in the world is (1/3, 1, 0) in the mesh.
    let back = [1.0 / 10.0_f32.sqrt(), 3.0 / 10.0_f32.sqrt(), 0.0];
    let found = deltas.tangents.as_ref().unwrap();
    assert!(close(found[0], [back[0] - 1.0, back[1], 0.0]), "{found:?}");
    assert!(deltas.moves() && found[1] == [0.0; 3] && found[2] == [0.0; 3]);
}

#[test]
fn materials_that_look_at_tangents_are_known() {
    let mapped = |material: serde_json::Value| {
        with_tangents(&ALONG_X, &json!([material])).rest().unwrap().parts[0].normal_mapped
    };
    assert!(mapped(json!({ "normalTexture": { "index": 0 } })));
    let coat = json!({ "KHR_materials_clearcoat": { "clearcoatNormalTexture": { "index": 0 } } });
    assert!(mapped(json!({ "extensions": coat })));
    assert!(mapped(json!({ "extensions": { "KHR_materials_anisotropy": {} } })), "brushed along them");
    assert!(!mapped(json!({ "occlusionTexture": { "index": 0 }, "extensions": { "X": {} } })));
    for broken in [json!(null), json!([]), json!({ "extensions": 3 })] {
        assert!(!mapped(broken));
    }
    let mut doc = with_tangents(&ALONG_X, &json!([{}, { "normalTexture": { "index": 0 } }]));
    let variants = json!({ "mappings": [{ "variants": [0], "material": 1 }] });
    doc.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_materials_variants": variants });
    assert!(doc.rest().unwrap().parts[0].normal_mapped, "one of its variants does");
}

#[test]
fn the_coordinates_of_the_normal_map_count() {
    let info = json!({ "index": 0, "texCoord": 1 });
    let mut doc = with_tangents(&ALONG_X, &json!([{ "normalTexture": info }]));
    let sets = [0.0, 1.0, 2.0].map(|set| doc.floats("VEC2", &[set; 6]));
    for (k, set) in sets.into_iter().enumerate() {
        doc.json["meshes"][0]["primitives"][0]["attributes"][format!("TEXCOORD_{k}")] = json!(set);
    }
    let found = |doc: &Doc| doc.rest().unwrap().blocks[0].tangent_uvs().map(|uvs| uvs[0][0]);
    assert_eq!(found(&doc), Some(1.0));
    let transform = json!({ "KHR_texture_transform": { "texCoord": 2, "rotation": 1 } });
    doc.json["materials"][0]["normalTexture"]["extensions"] = transform;
    assert_eq!(found(&doc), Some(2.0), "the extension's set counts, its transform does not");
    doc.json["materials"][0]["normalTexture"] = json!({ "index": 0, "texCoord": 7 });
    assert_eq!(found(&doc), None);
    doc.json["materials"][0] = json!({});
    assert_eq!(found(&doc), Some(0.0));
}

#[test]
fn tangents_that_are_none_are_left_with_a_warning() {
    let mut endless = ALONG_X;
    endless[5] = f32::NAN;
    let map = json!([{ "normalTexture": { "index": 0 } }]);
    let rest = with_tangents(&endless, &map).rest().unwrap();
    assert!(rest.blocks[0].tangents.is_none() && !rest.parts[0].normal_mapped);
    assert!(rest.warnings.iter().any(|warning| warning.code == "tangents"), "{:?}", rest.warnings);
    let mut doc = with_tangents(&ALONG_X, &map);
    doc.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    let rest = doc.rest().unwrap();
    assert!(rest.blocks[0].tangents.is_none(), "without normals the standard has them ignored");
    assert!(rest.warnings.iter().all(|warning| warning.code != "tangents"));
}
