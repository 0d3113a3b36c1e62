//! OBJ files.

use proptest::prelude::*;
use wirework_asset::{Limits, Obj, ObjPart, Place, write_obj, write_obj_parts};
use wirework_surface::{Corner, Mesh};

fn read(text: &[u8]) -> Result<Obj, wirework_asset::AssetError> {
    Obj::from_slice(text, "made.obj", &Limits::default())
}

const SHEET: &[u8] = b"# a sheet\r\nmtllib ../../secret.mtl\r\no caf\xe9\r\nv 0 0 0 0.1 0.2 0.3\r\nv\t1.50\t0 \\\r\n 0\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\nvt 1 0 0\r\nvn 0 0 2\r\nusemtl x\r\nf 1/1/1 2/2/1 -2/-1/-1\r\nf 1 3 4 # rest\r\nl 1 2\r\np -1\r\n";

#[test]
fn all_forms_of_corners_are_read() {
    let obj = read(SHEET).unwrap();
    let mesh = &obj.mesh;
    assert_eq!(mesh.positions, [[0.0; 3], [1.5, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!((mesh.normals.as_slice(), mesh.uvs.len()), (&[[0.0, 0.0, 1.0]][..], 2));
    assert_eq!(mesh.face_ends, [3, 6]);
    assert_eq!(mesh.corners[2], Corner { position: 2, uv: Some(1), normal: Some(0) });
    assert_eq!(mesh.corners[5], Corner { position: 3, uv: None, normal: None });
    assert!(obj.warnings.is_empty());
    assert_eq!(obj.write(mesh), SHEET, "what does not move comes back byte for byte");
}

#[test]
fn only_the_numbers_that_move_change() {
    let obj = read(SHEET).unwrap();
    let mut mesh = obj.mesh.clone();
    mesh.positions[0] = [0.1, -2.0, 1e-7];
    mesh.positions[1][0] = 3.0;
    let text = obj.write(&mesh);
    let expected = String::from_utf8_lossy(SHEET)
        .replace("v 0 0 0 0.1", "v 0.1 -2 0.0000001 0.1")
        .replace("1.50\t0 \\\r\n 0", "3 0 0");
    assert_eq!(String::from_utf8_lossy(&text), expected);
    assert_eq!(read(&text).unwrap().mesh, mesh);
}

#[test]
fn normals_may_be_others_than_the_file_has() {
    let obj = read(SHEET).unwrap();
    let mut mesh = obj.mesh.clone();
    mesh.normals = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for (k, corner) in mesh.corners.iter_mut().enumerate() {
        corner.normal = Some(k as u32 / 3);
    }
    let text = obj.write(&mesh);
    assert_eq!(read(&text).unwrap().mesh, mesh);
    let text = String::from_utf8_lossy(&text).into_owned();
    assert!(
        text.contains("usemtl x\r\nvn 1 0 0\nvn 0 1 0\nf 1/1/1 2/2/1 3/2/1\r\nf 1//2 3//2 4//2\r\nl 1 2"),
        "{text}"
    );
}

#[test]
fn faults_are_named_by_their_line() {
    for (text, line) in [
        ("v 0 0 0\nv 1 0\n", 2),
        ("v 0 0 nan\n", 1),
        ("v 0 0 1e39\n", 1),
        ("v 0 0 0\n\nf 1 1 2\n", 3),
        ("v 0 0 0\nf 1 1\n", 2),
        ("v 0 0 0\nf 1 1 0\n", 2),
        ("v 0 0 0\nf 1 1 -2\n", 2),
        ("v 0 0 0\nf 1 1 1/1\n", 2),
        ("v 0 0 0\nf 1 1 1/1/1/1\n", 2),
        ("v 0 0 \\\n0\nf / / /\n", 3),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", 2),
    ] {
        let error = read(text.as_bytes()).unwrap_err();
        assert_eq!(error.place, Place::Line(line), "{text:?}: {error}");
    }
    assert!(read(b"V 0 0 0\n").is_err() && read(b"").is_err());
    assert_eq!(read(b"v 0 0 0\nvoxel 1\n").unwrap().warnings[0].place, Place::Line(2));
}

#[test]
fn vertices_alone_are_a_point_set() {
    let obj = read(b"\xef\xbb\xbfv 1 2 3\nv 4 5 6").unwrap();
    assert!(obj.mesh.face_ends.is_empty());
    assert_eq!(write_obj(&obj.mesh), b"v 1 2 3\nv 4 5 6\n");
    let moved = Mesh { positions: vec![[1.0; 3], [4.0, 5.0, 6.0]], ..obj.mesh.clone() };
    assert_eq!(obj.write(&moved), b"\xef\xbb\xbfv 1 1 1\nv 4 5 6");
}

proptest! {
    #[test]
    fn numbers_come_back_as_they_were(bits in prop::collection::vec(any::<u32>(), 3..30)) {
        let numbers: Vec<f32> = bits.into_iter().map(f32::from_bits).filter(|x| x.is_finite()).collect();
        let positions: Vec<[f32; 3]> = numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        prop_assume!(!positions.is_empty());
        let mesh = Mesh { positions, ..Mesh::default() };
        let back = read(&write_obj(&mesh)).unwrap().mesh;
        let bits = |mesh: &Mesh| mesh.positions.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&back), bits(&mesh));
    }

    #[test]
    fn no_text_makes_it_panic(text in "([vfl \\\\\n/0-9.#-]|vn |vt |f 1 1 1\n|v 0 0 0\n){0,80}") {
        if let Ok(obj) = read(text.as_bytes()) {
            prop_assert_eq!(obj.write(&obj.mesh), text.as_bytes());
            let moved = Mesh { normals: vec![[0.0, 1.0, 0.0]], ..obj.mesh.clone() };
            let _ = obj.write(&moved);
        }
    }
}

#[test]
fn parts_are_objects_one_behind_the_other() {
    let corner = |position| Corner { position, uv: None, normal: None };
    let mesh = Mesh {
        positions: (0..6).map(|i| [i as f32, 0.0, 0.0]).collect(),
        corners: [0, 1, 2, 4, 5, 3].map(corner).to_vec(),
        face_ends: vec![3, 6],
        ..Mesh::default()
    };
    let part = |name: &str, positions, faces| ObjPart { name: name.into(), positions, faces };
    let text = write_obj_parts(&mesh, &[part("a b", 3, 0..1), part(" #c\n", 6, 1..2)]);
    let expected = "o a b\nv 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\no _c_\nv 3 0 0\nv 4 0 0\nv 5 0 0\nf 5 6 4\n";
    assert_eq!(String::from_utf8(text.clone()).unwrap(), expected);
    let obj = Obj::from_slice(&text, "parts.obj", &Limits::default()).unwrap();
    assert_eq!(
        (obj.mesh.clone(), obj.in_groups(&["a b"]).of_positions[..4].to_vec()),
        (mesh.clone(), vec![true, true, true, false])
    );
    // A position that another part's faces need first is listed there, under the number it has.
    let text = write_obj_parts(&mesh, &[part("last", 3, 1..2), part("first", 6, 0..1)]);
    assert_eq!(
        Obj::from_slice(&text, "parts.obj", &Limits::default()).unwrap().mesh.positions,
        mesh.positions
    );
}
