//! Bakes that are longer than what is held in memory of them.

use std::path::Path;

use wirework::{Job, apply, parse, preset};

/// Something of every vertex, some vertices and none moves.
const PRESET: &str = "Deform(object: Grid(size: (2, 2), cells: (99, 99)), wires: [Wire(
    curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 3,
    pose: Ease([(0, [(-1, 0, 0), (1, 0, 0)]), (0.5, [(-1, 0.3, 0), (1, 0.1, 0)]), (0.75, [(-1, 0.3, 0), (1, 0.1, 0)])]),
), Wire(
    curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 0.3,
    pose: Keys([(0.5, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0, 0.1), (1, 0, 0.1)])]),
)])";

/// Applies it and gives every file of the folder that it wrote into.
fn files(out: &str, held_bytes: usize, threads: usize) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let parsed =
        parse(PRESET.as_bytes(), &preset::Limits::default()).unwrap_or_else(|errors| panic!("{errors}"));
    let out = folder.path().join(out);
    let job = Job {
        output: Some(&out),
        held_bytes,
        threads: Some(threads),
        bake: wirework::bake::Bake::Frames,
        ..Job::new(&parsed.preset, Path::new("long.ron"))
    };
    assert_eq!(apply(&job, &mut |_| {}).unwrap().frames, 25);
    let mut files: Vec<(String, Vec<u8>)> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

#[test]
fn what_is_written_does_not_depend_on_what_is_held() {
    for (out, count) in [("out.glb", 1), ("out.gltf", 2)] {
        let whole = files(out, usize::MAX, 2);
        assert_eq!(whole.len(), count);
        assert!(whole.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() > 3_000_000);
        for (held, threads) in [(0, 2), (1_000_000, 1), (1_000_000, 3)] {
            assert!(files(out, held, threads) == whole, "{out}, {held} held, {threads} threads");
        }
    }
}
