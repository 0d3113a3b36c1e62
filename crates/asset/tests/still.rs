//! Stills, new documents and files.

use serde_json::json;
use wirework_asset::{Format, Gltf, Limits, NewMesh, Rest, same_file, write_files};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;
use make::triangle;

fn lifted(rest: &Rest, only: impl Fn(usize) -> bool) -> Vec<[f32; 3]> {
    let lift = |(i, p): (usize, &[f32; 3])| if only(i) { [p[0], p[1] + 0.5, p[2]] } else { *p };
    rest.positions.iter().enumerate().map(lift).collect()
}

fn check(gltf: &Gltf, wanted: &[[f32; 3]]) {
    let shown = oracle::evaluate(&gltf.to_glb().unwrap(), None, 0.0);
    let found = shown.iter().flat_map(|s| &s.positions);
    assert_eq!(found.clone().count(), wanted.len());
    for (found, wanted) in found.zip(wanted) {
        assert!(
            (*found - glam::DVec3::from_array(wanted.map(f64::from))).length() < 1e-6,
            "{found} {wanted:?}"
        );
    }
}

#[test]
fn a_still_is_the_deformed_state() {
    let mut doc = triangle(json!({ "scale": [-2, 1, 3], "rotation": [0.6, 0, 0, 0.8] }));
    doc.json["scenes"] = json!([{ "nodes": [0] }]);
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let wanted = lifted(&rest, |i| i != 0);
    let normals = vec![[1.0, 0.0, 0.0]; 3];
    assert_eq!(gltf.set_still(&rest, &wanted, Some(&normals), None).unwrap(), 0);
    check(&gltf, &wanted);
    let again = gltf.rest().unwrap();
    assert!(again.warnings.is_empty(), "{:?}", again.warnings);
    for n in again.blocks[0].normals.as_ref().unwrap() {
        assert!((n[0] - 1.0).abs() < 1e-6);
    }
    assert_eq!(gltf.json()["accessors"].as_array().unwrap().len(), 4, "the old accessors stay");
}

#[test]
fn a_node_that_does_not_move_keeps_the_mesh() {
    let mut doc = triangle(json!({}));
    doc.node(json!({ "mesh": 0, "translation": [5, 0, 0] }));
    doc.node(json!({ "mesh": 0, "translation": [9, 0, 0] }));
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let wanted = lifted(&rest, |i| i >= 3);
    gltf.set_still(&rest, &wanted, None, None).unwrap();
    check(&gltf, &wanted);
    let mesh = |node: usize| gltf.json()["nodes"][node]["mesh"].as_u64().unwrap();
    assert_eq!((mesh(0), mesh(1), mesh(2)), (0, 1, 1));
    assert_eq!(gltf.json()["meshes"][0], doc.json["meshes"][0]);
}

#[test]
fn new_documents_hold_what_they_are_given() {
    let positions = [[0.0, 0.1, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];
    let sheet = NewMesh {
        name: "front",
        positions: &positions,
        normals: Some(&[[0.0, 1.0, 0.0]; 3]),
        uvs: Some(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        triangles: &[[0, 1, 2]],
    };
    let points = NewMesh { name: "points", normals: None, uvs: None, triangles: &[], ..sheet };
    let gltf = Gltf::from_meshes("preset", &[sheet, points]).unwrap();
    let rest = gltf.rest().unwrap();
    assert_eq!(rest.positions, [positions, positions].concat());
    assert_eq!(rest.triangles, [[0, 1, 2]]);
    assert!(rest.warnings.is_empty(), "{:?}", rest.warnings);
    assert_eq!((gltf.node_name(0), gltf.node_name(1)), (Some("front"), Some("points")));
    gltf::Gltf::from_slice(&gltf.to_glb().unwrap()).unwrap();
    assert!(Gltf::from_meshes("x", &[NewMesh { triangles: &[[0, 1, 3]], ..sheet }]).is_err());
    assert!(Gltf::from_meshes("x", &[NewMesh { positions: &[[f32::NAN; 3]; 3], ..sheet }]).is_err());
    assert!(Gltf::from_meshes("x", &[NewMesh { positions: &[], ..points }]).is_err());
}

#[test]
fn both_formats_hold_the_same_scene() {
    let folder = tempfile::tempdir().unwrap();
    let doc = triangle(json!({}));
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let wanted = lifted(&rest, |_| true);
    gltf.set_still(&rest, &wanted, None, None).unwrap();
    // GLB to glTF, and that to a GLB and to a glTF in another folder.
    let first = folder.path().join("a b.gltf");
    write_files(&gltf.files(&first, Format::of(&first).unwrap()).unwrap()).unwrap();
    assert!(folder.path().join("a b.bin").exists());
    let gltf = Gltf::read(&first, &Limits::default()).unwrap();
    assert_eq!(gltf.rest().unwrap().positions, wanted);
    let glb = folder.path().join("c.GLB");
    write_files(&gltf.files(&glb, Format::of(&glb).unwrap()).unwrap()).unwrap();
    assert_eq!(Gltf::read(&glb, &Limits::default()).unwrap().rest().unwrap().positions, wanted);
    let mut gltf = gltf;
    let rest = gltf.rest().unwrap();
    gltf.set_still(&rest, &lifted(&rest, |_| true), None, None).unwrap();
    let second = folder.path().join("sub/d.gltf");
    std::fs::create_dir(second.parent().unwrap()).unwrap();
    write_files(&gltf.files(&second, Format::Gltf).unwrap()).unwrap();
    let mut names: Vec<_> =
        std::fs::read_dir(folder.path().join("sub")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a b.bin", "d.gltf", "d_wirework.bin"], "the old buffer is copied, ours is its own");
    assert_eq!(
        std::fs::read(folder.path().join("a b.bin")).unwrap(),
        std::fs::read(folder.path().join("sub/a b.bin")).unwrap()
    );
    let there = Gltf::read(&second, &Limits::default()).unwrap().rest().unwrap();
    assert_eq!(there.positions, lifted(&rest, |_| true));
    assert!(!same_file(&first, &second));
}

#[test]
fn a_scene_becomes_an_obj_of_triangles() {
    let mut doc = triangle(json!({}));
    let uvs = doc.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.25]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    let rest = doc.rest().unwrap();
    let text = wirework_asset::write_obj(&rest.to_mesh(&rest.positions, rest.blocks[0].normals.as_deref()));
    let lines = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 0.75\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 1/1/1 2/2/2 3/3/3\n";
    assert_eq!(String::from_utf8(text).unwrap(), lines);
}
