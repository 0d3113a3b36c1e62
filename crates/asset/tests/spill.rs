//! What is written does not depend on how much of it was held in memory.

use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use wirework_asset::{
    ErrorClass, Format, Gltf, Limits, MeshTarget, MorphTarget, NewMesh, OutputFile, write_files,
};

/// Vertices of the mesh.
const COUNT: usize = 60;

/// A document that came as a `.glb`, or as a `.gltf` whose data stay where they are.
fn document(format: Format) -> Gltf {
    let positions = [[0.5; 3]; COUNT];
    let mesh =
        NewMesh { name: "m", positions: &positions, normals: None, uvs: None, triangles: &[[0, 1, 2]] };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(if format == Format::Glb { "in.glb" } else { "in.gltf" });
    write_files(&Gltf::from_meshes("m", &[mesh]).unwrap().into_files(&path, format).unwrap()).unwrap();
    Gltf::read(&path, &Limits::default()).unwrap()
}

/// Displacements of which every `step`th vertex has one.
fn moved(step: usize, seed: u8) -> Vec<[f32; 3]> {
    let value = f32::from(seed) + 1.0;
    (0..COUNT).map(|i| if i % step == 0 { [value, i as f32, -value] } else { [0.0, -0.0, 0.0] }).collect()
}

/// Appends one target after the other and gives their accessors.
fn append(gltf: &mut Gltf, all: &[(usize, u8)]) -> Vec<usize> {
    all.iter().map(|&(step, seed)| gltf.append_deltas(moved(step, seed), seed % 2 == 0).unwrap()).collect()
}

/// The files as they are on the disk, once each part has gone there.
fn written(gltf: Gltf, format: Format) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let name = if format == Format::Glb { "out.glb" } else { "out.gltf" };
    let files: Vec<OutputFile> = gltf.into_files(&folder.path().join(name), format).unwrap();
    write_files(&files).unwrap();
    let name = |file: &OutputFile| file.path.file_name().unwrap().to_string_lossy().into_owned();
    let read = |file: &OutputFile| {
        let bytes = std::fs::read(&file.path).unwrap();
        assert_eq!(bytes, file.bytes().unwrap());
        (name(file), bytes)
    };
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), files.len(), "nothing else is left");
    files.iter().map(read).collect()
}

const FORMATS: [Format; 2] = [Format::Glb, Format::Gltf];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn bytes_are_the_same_wherever_they_waited(
        // Few kinds, so that many are equal.
        all in vec((prop::sample::select(&[1_usize, 2, 7, 59, 60, 1000][..]), 0_u8..4), 0..14),
        held in 0_usize..4000,
        from in prop::sample::select(&FORMATS[..]),
        to in prop::sample::select(&FORMATS[..]),
    ) {
        let mut plain = document(from);
        plain.spill_beyond(usize::MAX, None);
        let mut spilled = plain.clone();
        spilled.spill_beyond(held, None);
        prop_assert_eq!(append(&mut spilled, &all), append(&mut plain, &all));
        prop_assert_eq!(spilled.to_glb().unwrap(), plain.to_glb().unwrap());
        prop_assert!(written(spilled, to) == written(plain, to));
    }
}

#[test]
fn equal_content_is_found_wherever_it_waits() {
    let all = [(1, 0), (1, 2), (7, 2)];
    for held in [0, 12 * COUNT, usize::MAX] {
        let mut gltf = document(Format::Glb);
        gltf.spill_beyond(held, None);
        let first = append(&mut gltf, &all);
        let length = gltf.to_glb().unwrap().len();
        assert_eq!(append(&mut gltf, &all), first, "held {held}");
        assert_eq!(gltf.to_glb().unwrap().len(), length);
    }
}

#[test]
fn copies_that_go_on_by_themselves_do_not_disturb_each_other() {
    let [one, other] = [(1, 4), (7, 6)];
    let mut gltf = document(Format::Glb);
    gltf.spill_beyond(0, None);
    append(&mut gltf, &[(1, 0), (2, 2)]);
    let mut copy = gltf.clone();
    // By turns, so that their stretches of the file lie between each other.
    for (step, seed) in [one, other, (1, 8)] {
        append(&mut gltf, &[(step, seed)]);
        append(&mut copy, &[(step, seed + 1), (2, 2)]);
    }
    let alone = |more: &[(usize, u8)]| {
        let mut gltf = document(Format::Glb);
        append(&mut gltf, &[(1, 0), (2, 2)]);
        append(&mut gltf, more);
        gltf.to_glb().unwrap()
    };
    let of_copy = copy.to_glb().unwrap();
    drop(copy);
    assert!(gltf.to_glb().unwrap() == alone(&[one, other, (1, 8)]));
    assert!(of_copy == alone(&[(1, 5), (7, 7), (1, 9)]));
}

#[test]
fn what_waits_outside_can_be_read_as_before() {
    let mut gltf = document(Format::Glb);
    gltf.spill_beyond(0, None);
    let position = append(&mut gltf, &[(1, 2)])[0];
    let primitives = vec![MorphTarget { position, normal: None, tangent: None }];
    gltf.add_targets(0, &[MeshTarget { name: "t".to_owned(), primitives }]).unwrap();
    let again = Gltf::from_slice(&gltf.to_glb().unwrap(), "again", &Limits::default()).unwrap();
    assert_eq!(gltf.rest().unwrap().positions, again.rest().unwrap().positions);
    let mut player = gltf.player(&gltf.rest().unwrap(), None).unwrap();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    player.pose_into(0.0, None, &mut positions, &mut normals).unwrap();
    assert_eq!(positions, again.rest().unwrap().positions);
}

#[test]
fn a_file_waits_without_a_name_where_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let mut gltf = document(Format::Glb);
    gltf.spill_beyond(0, Some(folder.path()));
    append(&mut gltf, &[(1, 0)]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    // Where there is no such folder, the system's serves.
    gltf.spill_beyond(0, Some(Path::new("no/such/folder")));
    append(&mut gltf, &[(1, 1)]);
    let mut plain = document(Format::Glb);
    append(&mut plain, &[(1, 0), (1, 1)]);
    assert!(gltf.to_glb().unwrap() == plain.to_glb().unwrap());
    let file = gltf.into_files(&folder.path().join("none/out.glb"), Format::Glb).unwrap();
    assert_eq!(write_files(&file).unwrap_err().class, ErrorClass::Io);
}
