//! The road from a model of a million vertices to an animated one, beside plain reads and writes of the same bytes.
//!
//! `cargo bench -p wirework --bench apply` prints medians of several rounds by turns, and every figure as a ratio to the plain operation of
//! its round. Nothing is kept of the files.

use std::fs::{self, File};
use std::hint::black_box;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use wirework::asset::{Format, Gltf, Limits, NewMesh, write_files};
use wirework::preset::{Limits as PresetLimits, Preset};
use wirework::surface::grid;
use wirework::{Job, Subject, When, apply, parse};

/// Cells along a side of the grid, one less than vertices.
const CELLS: u32 = 999;

/// Rounds, of which the median counts.
const ROUNDS: usize = 7;

/// Frames of the animation: the first is the rest, the others a target each.
const FRAMES: u32 = 5;

/// A wire that reaches every vertex.
const PRESET: &str = "
    Deform(
        wires: [Wire(
            curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]),
            pose: Keys([(0.0, [(-1, 0, 0), (1, 0, 0)]), (1.0, [(-1, 0.3, 0), (1, 0.1, 0)])]),
            radius: 3,
        )],
    )
";

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join("in.glb"), folder.path().join("out.glb"));
    model(&input);
    reading(&input);
    applying(&input, &output);
}

/// A grid with normals and texture coordinates.
fn model(path: &Path) {
    let mesh = grid([2.0, 2.0], [CELLS, CELLS], [0.0, 1.0, 0.0]).expect("a grid");
    let normals = vec![[0.0, 1.0, 0.0]; mesh.positions.len()];
    let uvs: Vec<[f32; 2]> = mesh.positions.iter().map(|p| [p[0], p[2]]).collect();
    let triangles = mesh.triangles().expect("triangles");
    let mesh = NewMesh {
        name: "grid",
        positions: &mesh.positions,
        normals: Some(&normals),
        uvs: Some(&uvs),
        triangles: &triangles,
    };
    let gltf = Gltf::from_meshes("grid", &[mesh]).expect("a document");
    write_files(&gltf.into_files(path, Format::Glb).expect("a file")).expect("a disk");
}

fn reading(path: &Path) {
    let mut times: [Vec<f64>; 3] = Default::default();
    let limits = Limits::default();
    for _ in 0..ROUNDS {
        times[0].push(seconds(|| fs::read(path).expect("a file")));
        times[1].push(seconds(|| {
            let gltf = Gltf::read(path, &limits).expect("a document");
            (gltf.rest().expect("geometry"), gltf)
        }));
        times[2].push(seconds(|| Subject::read(path, &limits).expect("a model")));
    }
    let [plain, rest, subject] = times;
    let size = fs::metadata(path).expect("a file").len() as f64 / 1e6;
    println!("{size:.0} MB: plain read {:.1} ms", median(&plain) * 1e3);
    report("Gltf::read and rest", &rest, &plain);
    report("Subject::read", &subject, &plain);
}

fn applying(input: &Path, output: &Path) {
    let parsed = parse(PRESET.as_bytes(), &PresetLimits::default()).expect("a preset");
    let preset: &Preset = &parsed.preset;
    let mut times: [Vec<f64>; 7] = Default::default();
    let mut size = 0;
    for _ in 0..ROUNDS {
        let job = Job {
            input: Some(input),
            output: Some(output),
            when: When::Frames(0..FRAMES),
            ..Job::new(preset, Path::new("bench.ron"))
        };
        let mut done = None;
        times[0].push(seconds(|| done = Some(apply(&job, &mut |_| ()).expect("an asset"))));
        let done = done.expect("a report");
        let parts = [done.bind_ms, done.deform_ms, done.normals_ms, done.write_ms];
        parts.iter().zip(&mut times[1..]).for_each(|(ms, list)| list.push(ms / 1e3));
        let bytes = fs::read(output).expect("the file");
        size = bytes.len();
        for (slot, sync) in [(5, true), (6, false)] {
            fs::remove_file(output).expect("the file");
            times[slot].push(seconds(|| plain_write(output, &bytes, sync)));
        }
        fs::remove_file(output).expect("the file");
    }
    let [all, bind, deform, normals, write, synced, unsynced] = times;
    println!("apply, {FRAMES} frames, {:.0} MB", size as f64 / 1e6);
    println!("  plain write {:.1} ms, and flushed {:.1} ms", median(&unsynced) * 1e3, median(&synced) * 1e3);
    for (name, times) in [("binding", &bind), ("deforming", &deform), ("normals", &normals)] {
        report(&format!("{name}, beside flushed"), times, &synced);
    }
    report("baking and writing, beside flushed", &write, &synced);
    report("all, beside flushed", &all, &synced);
}

fn plain_write(path: &Path, bytes: &[u8], sync: bool) {
    let mut file = File::create(path).expect("a disk");
    file.write_all(bytes).expect("a disk");
    if sync {
        file.sync_all().expect("a disk");
    }
}

fn report(name: &str, times: &[f64], plain: &[f64]) {
    let ratios: Vec<f64> = times.iter().zip(plain).map(|(a, b)| a / b).collect();
    println!("  {name:40} {:8.1} ms  {:6.2} times", median(times) * 1e3, median(&ratios));
}

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    let out = black_box(work());
    let time = start.elapsed().as_secs_f64();
    drop(out);
    time
}

fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}
