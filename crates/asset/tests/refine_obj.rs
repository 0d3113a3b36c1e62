//! OBJ files with finer meshes keep their text.

use std::path::Path;

use wirework_asset::{ErrorClass, Limits, Obj};
use wirework_surface::{Cut, SubdivideLimits, Wanted};

const ANY: SubdivideLimits = SubdivideLimits { vertices: 1 << 20, triangles: 1 << 21 };

fn read(text: &[u8]) -> Obj {
    Obj::from_slice(text, "made.obj", &Limits::default()).unwrap()
}

/// The file with edges as long as is wanted at each position.
fn refined(obj: &Obj, longest: &[f32]) -> Obj {
    let place_of: Vec<u32> = (0..obj.mesh.positions.len() as u32).collect();
    let wanted = Wanted { places: &obj.mesh.positions, place_of: &place_of, longest };
    let finer = obj.mesh.subdivide(&wanted, ANY).unwrap();
    let found = obj.refined(&finer, &Limits::default()).unwrap();
    assert_eq!(found.mesh.positions, finer.apply(&obj.mesh).positions);
    assert_eq!(found.mesh.corners, finer.corners);
    found
}

fn text(obj: &Obj) -> String {
    String::from_utf8(obj.write(&obj.mesh)).unwrap()
}

#[test]
fn what_is_not_cut_stays_byte_for_byte() {
    let file =
        b"# two sheets\nmtllib a.mtl\no one\nv 0 0 0 1 0 0\nv 2 0 0 0 0 1\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
        usemtl red\nf 1/1 2/2 3/3 # all of it\ng two\nv 9 0 0\nv 9.50 0 0\nv 9 0.5 0\nvn 0 0 1\nusemtl blue\n\
        f -3//-1 -2//-1 -1//-1\nl -1 1 -3\nodd statement";
    let obj = read(file);
    let found = refined(&obj, &[1.5; 6]);
    let expected = "# two sheets\nmtllib a.mtl\no one\nv 0 0 0 1 0 0\nv 2 0 0 0 0 1\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
        usemtl red\nv 9 0 0\nv 9.50 0 0\nv 9 0.5 0\nvn 0 0 1\nv 1 0 0 0.5 0 0.5\nv 0 1 0\nv 1 1 0\nvt 0.5 0\nvt 0 0.5\nvt 0.5 0.5\n\
        f 1/1 7/4 8/5\nf 7/4 2/2 9/6\nf 8/5 9/6 3/3\nf 7/4 9/6 8/5\n\
        g two\nusemtl blue\nf 4//1 5//1 6//1\nl 6 1 4\nodd statement";
    assert_eq!(text(&found), expected);
    assert_eq!(found.warnings, obj.warnings);
    let red = found.of_materials(&["red"]).of_positions;
    assert_eq!(red, [true, true, true, false, false, false, true, true, true]);
    assert_eq!(found.in_groups(&["two"]).of_positions[3..6], [true; 3]);
    assert_eq!(text(&refined(&obj, &[5.0; 6])).as_bytes(), file, "fine enough");
}

#[test]
fn quads_become_triangles_where_they_are_cut_and_ends_of_lines_stay() {
    let file = b"v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nv 9 0 0\r\nv 9 9 0\r\nf 1 2 3 4\r\nf 2 5 6 3";
    let found = refined(&read(file), &[1.1, 1.1, 1.1, 1.1, 5.0, 5.0]);
    let text = text(&found);
    assert!(text.contains("\r\nf 1 2 3 4\r\n"), "{text}");
    assert!(text.lines().filter(|line| line.starts_with("f ")).count() > 4, "{text}");
    assert!(!text.contains("\n\n") && !text.ends_with('\n'));
}

#[test]
fn limits_and_other_meshes_are_refused() {
    let obj = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let wanted = Wanted { places: &obj.mesh.positions, place_of: &[0, 1, 2], longest: &[0.3; 3] };
    let finer = obj.mesh.subdivide(&wanted, ANY).unwrap();
    let error = obj.refined(&finer, &Limits { vertices: 10, ..Limits::default() }).unwrap_err();
    assert_eq!(error.class, ErrorClass::Limit);
    assert!(error.expected.contains("--max-vertices"), "{error}");
}

#[test]
fn real_files_keep_what_they_say() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    if !shared.exists() {
        return;
    }
    for file in
        ["garment/male_casualsuit04.obj", "garment/plane_30x30.obj", "body/spot.obj", "body/male1591.obj"]
    {
        let obj = Obj::read(&shared.join(file), &Limits::default()).unwrap();
        let size = obj.mesh.positions.iter().flatten().fold(0.0_f32, |a, c| a.max(c.abs()));
        let found = refined(&obj, &vec![size / 60.0; obj.mesh.positions.len()]);
        assert!(found.mesh.positions.len() > obj.mesh.positions.len(), "{file}");
        let count = |obj: &Obj| {
            let other = |line: &&str| !["v ", "vt ", "vn ", "f "].iter().any(|kind| line.starts_with(kind));
            text(obj).lines().filter(other).count()
        };
        assert_eq!(count(&obj), count(&found), "{file}");
        assert_eq!(obj.material_names(), found.material_names());
        assert_eq!(obj.group_names(), found.group_names());
    }
}

#[test]
fn edges_cut_elsewhere_take_texture_coordinates_and_colours_along() {
    let obj = read(
        b"v 0 0 0 1 0 0\nv 2 0 0 0 0 1\nv 2 2 0 0 1 0\nv 0 2 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
        f 1/1/1 2/2/1 3/3/1 4/4/1\n",
    );
    let cuts = [Cut { ends: [1, 0], shares: vec![0.25, 0.75] }, Cut { ends: [2, 3], shares: vec![0.125] }];
    let finer = obj.mesh.cut(&[0, 1, 2, 3], 4, &cuts, ANY).unwrap();
    let found = obj.refined(&finer, &Limits::default()).unwrap();
    let text = text(&found);
    for line in [
        "v 1.5 0 0 0.25 0 0.75",
        "v 0.5 0 0 0.75 0 0.25",
        "v 1.75 2 0 0.125 1 0.125",
        "vt 0.75 0",
        "vt 0.25 0",
        "vt 0.875 1",
    ] {
        assert!(text.lines().any(|own| own == line), "{line} in\n{text}");
    }
    assert_eq!(found.mesh.face_ends.len(), 2 + 3);
    assert!(found.mesh.normals.len() == 1 && found.mesh.corners == finer.corners);
}
