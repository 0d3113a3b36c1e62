//! Reading and writing a million vertices, beside reading and writing the same bytes plainly, all in one run.
//!
//! `cargo bench -p wirework-asset` prints medians of several rounds by turns, and every figure as a ratio to the plain operation
//! of its round: machines differ and vary, and most of both is memory that the system hands out. Nothing is kept of the files.

use std::fs::{self, File};
use std::hint::black_box;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use wirework_asset::{
    Clip, Format, Gltf, Limits, MeshTarget, MorphTarget, OutputFile, WeightTrack, write_files,
};

/// Vertices along a side of the grid.
const SIDE: usize = 1000;

/// Rounds, of which the median counts.
const ROUNDS: usize = 9;

/// Targets that are written, each of positions and normals.
const TARGETS: usize = 4;

/// How vertices are stored.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Plain,
    Placed,
    Skinned,
    Quantised,
    Interleaved,
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("in.glb");
    for (name, kind) in [
        ("plain", Kind::Plain),
        ("plain, node turned and scaled", Kind::Placed),
        ("skinned", Kind::Skinned),
        ("quantised", Kind::Quantised),
        ("interleaved", Kind::Interleaved),
    ] {
        fs::write(&path, glb(kind)).expect("a disk");
        reading(name, &path);
    }
    fs::write(&path, glb(Kind::Plain)).expect("a disk");
    all_writing(&path, &folder.path().join("out.glb"));
}

fn reading(name: &str, path: &Path) {
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..ROUNDS {
        times[0].push(seconds(|| fs::read(path).expect("a file")));
        times[1].push(seconds(|| Gltf::read(path, &Limits::default()).expect("a document")));
        times[2].push(seconds(|| {
            let gltf = Gltf::read(path, &Limits::default()).expect("a document");
            let rest = gltf.rest().expect("geometry");
            (gltf, rest)
        }));
    }
    let size = fs::metadata(path).expect("a file").len() as f64 / 1e6;
    let [plain, read, rest] = times;
    println!("{name}, {size:.0} MB: plain read {:.1} ms", median(&plain) * 1e3);
    report("Gltf::read", &read, &plain);
    report("Gltf::read and rest", &rest, &plain);
}

/// Which vertices a target moves.
type Moved = fn(usize) -> bool;

/// Appending and writing targets, by what they move and how much of them is held in memory.
fn all_writing(input: &Path, out: &Path) {
    let gltf = Gltf::read(input, &Limits::default()).expect("a document");
    let all: Moved = |_| true;
    // Every fourth row of sixteen; a quarter of all, without a pattern.
    let clustered: Moved = |i| (i / SIDE / 16).is_multiple_of(4);
    let scattered: Moved = |i| (i as u32).wrapping_mul(0x9e37_79b1).wrapping_mul(0x85eb_ca6b) >> 30 == 0;
    for (name, moved, held) in [
        ("dense", all, usize::MAX),
        ("a quarter of vertices, together,", clustered, usize::MAX),
        ("a quarter of vertices, scattered,", scattered, usize::MAX),
        ("dense, none held in memory,", all, 0),
    ] {
        let mut gltf = gltf.clone();
        gltf.spill_beyond(held, out.parent());
        writing(name, &gltf, moved, out);
    }
}

fn writing(name: &str, gltf: &Gltf, moved: Moved, out: &Path) {
    let count = SIDE * SIDE;
    let value = |i: usize, k: usize| {
        if moved(i) { [0.001, ((i + k) % 97) as f32 * 0.01, k as f32 + 1.0] } else { [0.0; 3] }
    };
    let frame = |k: usize| (0..count).map(|i| value(i, k)).collect();
    let deltas: Vec<Vec<[f32; 3]>> = (0..2 * TARGETS).map(frame).collect();
    let mut times: [Vec<f64>; 6] = Default::default();
    let mut size = 0;
    for round in 0..ROUNDS {
        let mut own = || {
            let mut copy = gltf.clone();
            times[0].push(animate(&mut copy, &deltas));
            let mut files = Vec::new();
            times[1].push(seconds(|| files = copy.into_files(out, Format::Glb).expect("a document")));
            times[2].push(seconds(|| write_files(&files).expect("a disk")));
            files
        };
        let files = own();
        let bytes = fs::read(out).expect("the file");
        size = bytes.len();
        fs::remove_file(out).expect("the file");
        times[5].push(seconds(|| unsynced(&files[0], out)));
        fs::remove_file(out).expect("the file");
        drop(files);
        // By turns in either order: what the disk still has to do for one is in the way of the other.
        let plain = [(3, true), (4, false)];
        for (slot, sync) in if round % 2 == 0 { plain } else { [plain[1], plain[0]] } {
            times[slot].push(seconds(|| plain_write(out, &bytes, sync)));
            fs::remove_file(out).expect("the file");
        }
    }
    let [animate, files, write, synced, unsynced_plain, unsynced] = times;
    println!("{TARGETS} targets with normals, {name} {:.0} MB", size as f64 / 1e6);
    println!(
        "  plain write {:.1} ms, and flushed {:.1} ms",
        median(&unsynced_plain) * 1e3,
        median(&synced) * 1e3
    );
    let sum =
        |parts: &[&Vec<f64>]| (0..ROUNDS).map(|i| parts.iter().map(|p| p[i]).sum()).collect::<Vec<f64>>();
    report("append targets and clip, beside flushed", &animate, &synced);
    report("files, beside flushed", &files, &synced);
    report("write_files, beside flushed", &write, &synced);
    report("all, beside flushed", &sum(&[&animate, &files, &write]), &synced);
    report("files and unflushed, beside unflushed", &sum(&[&files, &unsynced]), &unsynced_plain);
    report("all unflushed, beside unflushed", &sum(&[&animate, &files, &unsynced]), &unsynced_plain);
}

/// Seconds that it takes to append targets, each as soon as it has been made, and the clip that plays them.
fn animate(gltf: &mut Gltf, deltas: &[Vec<[f32; 3]>]) -> f64 {
    let mut targets = Vec::new();
    let mut deltas = deltas.iter();
    let mut time = 0.0;
    for k in 0..TARGETS {
        let mut next = |bounds| {
            let own = deltas.next().expect("deltas").clone();
            let mut accessor = 0;
            time += seconds(|| accessor = gltf.append_deltas(own, bounds).expect("memory"));
            accessor
        };
        let (position, normal) = (next(true), Some(next(false)));
        targets.push(MeshTarget {
            name: format!("t{k}"),
            primitives: vec![MorphTarget { position, normal, tangent: None }],
        });
    }
    let times: Vec<f32> = (0..TARGETS).map(|k| k as f32).collect();
    let weights = (0..TARGETS * TARGETS).map(|i| if i % (TARGETS + 1) == 0 { 1.0 } else { 0.0 }).collect();
    time + seconds(|| {
        gltf.add_targets(0, &targets).expect("a mesh");
        gltf.add_clip(
            &Clip::New("clip".to_owned()),
            &times,
            &[WeightTrack { node: 0, times: None, weights }],
        )
        .expect("a node");
    })
}

fn plain_write(path: &Path, bytes: &[u8], sync: bool) {
    let mut file = File::create(path).expect("a disk");
    file.write_all(bytes).expect("a disk");
    if sync {
        file.sync_all().expect("a disk");
    }
}

fn unsynced(file: &OutputFile, path: &Path) {
    let mut out = File::create(path).expect("a disk");
    file.parts.iter().for_each(|part| out.write_all(part.bytes().expect("a disk")).expect("a disk"));
}

/// A document under construction.
struct Doc {
    json: Value,
    bin: Vec<u8>,
}

impl Doc {
    fn push(&mut self, key: &str, value: Value) -> usize {
        let list = self.json[key].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    fn accessor(
        &mut self,
        kind: &str,
        component: u32,
        count: usize,
        bytes: &[u8],
        stride: Option<usize>,
    ) -> usize {
        let view = self.view(bytes, stride);
        let normalized = !matches!(component, 5125 | 5126) && kind != "JOINTS";
        let kind = if kind == "JOINTS" { "VEC4" } else { kind };
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind, "normalized": normalized }),
        )
    }

    fn glb(mut self) -> Vec<u8> {
        self.json["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        let mut text = serde_json::to_vec(&self.json).expect("JSON");
        text.resize(text.len().div_ceil(4) * 4, b' ');
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((12 + 16 + text.len() + self.bin.len()).to_le_bytes().iter().take(4));
        for (kind, data) in [(b"JSON", &text), (b"BIN\0", &self.bin)] {
            out.extend((data.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(data);
        }
        out
    }
}

/// A position, a normal and texture coordinates.
type Vertex = ([f32; 3], [f32; 3], [f32; 2]);

fn vertices() -> Vec<Vertex> {
    let at = |i: usize| i as f32 / (SIDE - 1) as f32;
    let vertex = |i: usize| {
        let (x, z) = (at(i % SIDE), at(i / SIDE));
        let slope = 0.9 * (9.0 * x).cos();
        let length = (1.0 + slope * slope).sqrt();
        ([x, 0.1 * (9.0 * x).sin(), z], [-slope / length, 1.0 / length, 0.0], [x, z])
    };
    (0..SIDE * SIDE).map(vertex).collect()
}

fn glb(kind: Kind) -> Vec<u8> {
    let vertices = vertices();
    let count = vertices.len();
    let mut doc = Doc {
        json: json!({
            "asset": { "version": "2.0" }, "accessors": [], "bufferViews": [], "scene": 0,
            "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        }),
        bin: Vec::new(),
    };
    let floats = |pick: &dyn Fn(&Vertex) -> Vec<f32>| -> Vec<u8> {
        vertices.iter().flat_map(pick).flat_map(f32::to_le_bytes).collect()
    };
    let mut attributes = match kind {
        Kind::Quantised => quantised(&mut doc, &vertices),
        Kind::Interleaved => {
            let bytes = floats(&|v| [v.0.as_slice(), &v.1, &v.2].concat());
            let position = doc.accessor("VEC3", 5126, count, &bytes, Some(32));
            let mut other = |kind: &str, offset: usize| {
                doc.push("accessors", json!({ "bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": count, "type": kind }))
            };
            json!({ "POSITION": position, "NORMAL": other("VEC3", 12), "TEXCOORD_0": other("VEC2", 24) })
        }
        _ => json!({
            "POSITION": doc.accessor("VEC3", 5126, count, &floats(&|v| v.0.to_vec()), None),
            "NORMAL": doc.accessor("VEC3", 5126, count, &floats(&|v| v.1.to_vec()), None),
            "TEXCOORD_0": doc.accessor("VEC2", 5126, count, &floats(&|v| v.2.to_vec()), None),
        }),
    };
    match kind {
        Kind::Skinned => skin(&mut doc, &vertices, &mut attributes),
        Kind::Placed => doc.json["nodes"][0]["rotation"] = json!([0.0, 0.6, 0.0, 0.8]),
        Kind::Quantised => doc.json["nodes"][0]["scale"] = json!([1.5, 1.5, 1.5]),
        _ => {}
    }
    let indices = doc.accessor("SCALAR", 5125, 6 * (SIDE - 1) * (SIDE - 1), &indices(), None);
    doc.json["meshes"] = json!([{ "primitives": [{ "attributes": attributes, "indices": indices }] }]);
    doc.glb()
}

fn quantised(doc: &mut Doc, vertices: &[Vertex]) -> Value {
    doc.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    for (p, n, uv) in vertices {
        positions.extend(p.iter().flat_map(|c| ((c * 32_767.0) as i16).to_le_bytes()));
        positions.extend([0; 2]);
        normals.extend(n.iter().flat_map(|c| ((c * 127.0) as i8).to_le_bytes()));
        normals.push(0);
        uvs.extend(uv.iter().flat_map(|c| ((c * 65_535.0) as u16).to_le_bytes()));
    }
    let count = vertices.len();
    json!({
        "POSITION": doc.accessor("VEC3", 5122, count, &positions, Some(8)),
        "NORMAL": doc.accessor("VEC3", 5120, count, &normals, Some(4)),
        "TEXCOORD_0": doc.accessor("VEC2", 5123, count, &uvs, None),
    })
}

/// Two joints beside each other, of which every vertex has its shares.
fn skin(doc: &mut Doc, vertices: &[Vertex], attributes: &mut Value) {
    let joints: Vec<u8> = vertices.iter().flat_map(|_| [0, 1, 0, 0]).collect();
    let weights: Vec<u8> =
        vertices.iter().flat_map(|(p, ..)| [1.0 - p[0], p[0], 0.0, 0.0]).flat_map(f32::to_le_bytes).collect();
    attributes["JOINTS_0"] = json!(doc.accessor("JOINTS", 5121, vertices.len(), &joints, None));
    let last = doc.json["accessors"].as_array().map_or(0, Vec::len) - 1;
    doc.json["accessors"][last]["normalized"] = json!(false);
    attributes["WEIGHTS_0"] = json!(doc.accessor("VEC4", 5126, vertices.len(), &weights, None));
    doc.json["nodes"][0]["skin"] = json!(0);
    doc.json["nodes"].as_array_mut().expect("nodes").extend([
        json!({ "translation": [0.0, 0.1, 0.0] }),
        json!({ "rotation": [0.0, 0.6, 0.0, 0.8], "scale": [1.1, 1.0, 1.0] }),
    ]);
    doc.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    doc.json["skins"] = json!([{ "joints": [1, 2] }]);
}

fn indices() -> Vec<u8> {
    let mut out = Vec::with_capacity(24 * SIDE * SIDE);
    for z in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let a = z * SIDE + x;
            for i in [a, a + SIDE, a + 1, a + 1, a + SIDE, a + SIDE + 1] {
                out.extend_from_slice(&(i as u32).to_le_bytes());
            }
        }
    }
    out
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
