//! Real files, each with things planted into it that nobody knows: what is written differs from what was read by
//! additions and by the edits that additions need, and by nothing else.

use std::path::{Path, PathBuf};

use serde_json::Value;
use wirework::asset::{Gltf, Limits};

use crate::document::{Difference, Document, beside, chunks, differences, glb, list, plant, uris};
use crate::oracle::{self, Shown};
use crate::place::{Place, shared};

/// How far what is played may be from the still of that moment, in parts of the diagonal.
const PLAYED: f64 = 1e-4;
/// Frames a second, of an effect of one second.
const FPS: f64 = 8.0;

/// Reaches into every object, whatever its size.
const ANY: &str = "Deform(units: Bounds, wires: [Wire(
    curve: Polyline(points: [(-0.5, 0, 0), (0.5, 0, 0)]), radius: 1.5,
    pose: Keys([(0, [(-0.5, 0, 0), (0.5, 0, 0)]), (1, [(-0.5, 0.2, 0.1), (0.5, 0.3, 0)])]),
)])";

/// The shared documents but those whose geometry is compressed.
fn documents() -> Vec<PathBuf> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let kind = path.extension().and_then(|kind| kind.to_str()).unwrap_or_default();
            match kind {
                _ if path.is_dir() => walk(&path, out),
                "glb" | "gltf" => out.push(path),
                _ => {}
            }
        }
    }
    let Some(folder) = shared("") else { return Vec::new() };
    let mut all = Vec::new();
    walk(&folder, &mut all);
    all.retain(|path| !["draco", "meshopt"].iter().any(|kind| path.display().to_string().contains(kind)));
    all.sort();
    all
}

/// Copies a document with its files into a folder and plants things into it.
fn planted(from: &Path, folder: &Path) -> PathBuf {
    let to = folder.join(from.file_name().expect("a name"));
    let bytes = std::fs::read(from).expect("a file");
    if bytes.starts_with(b"glTF") {
        let (mut json, bin) = chunks(&bytes);
        plant(&mut json);
        std::fs::write(&to, glb(&json, bin.as_deref())).expect("a file");
        return to;
    }
    let mut json: Value = serde_json::from_slice(&bytes).expect("JSON");
    for uri in uris(&json) {
        let copy = beside(&to, &uri);
        std::fs::create_dir_all(copy.parent().expect("a folder")).expect("a folder");
        std::fs::copy(beside(from, &uri), copy).expect("a file");
    }
    plant(&mut json);
    std::fs::write(&to, serde_json::to_vec(&json).expect("JSON")).expect("a file");
    to
}

/// Whether the contract allows a difference between a document and itself with an effect in it.
fn allowed(difference: &Difference, old: &Document, glb_out: bool) -> bool {
    let Difference { path, old: before, new: after } = difference;
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    let count = |key: &str| list(&old.json, key).len() as u64;
    let added = before.is_none();
    let number = after.as_ref().and_then(Value::as_u64);
    match path.as_slice() {
        // Behind what there was.
        ["accessors" | "bufferViews" | "buffers" | "animations" | "meshes"]
        | ["accessors" | "bufferViews" | "buffers" | "animations" | "meshes", _]
        // The morph targets of a mesh, their default weights and their names.
        | ["meshes", _, "primitives", _, "targets"]
        | ["meshes", _, "primitives", _, "targets", _]
        // Zeros of what other targets of the primitive have.
        | ["meshes", _, "primitives", _, "targets", _, "POSITION" | "NORMAL" | "TANGENT"]
        | ["meshes" | "nodes", _, "weights", _]
        | ["meshes", _, "weights" | "extras"]
        | ["meshes", _, "extras", "targetNames"]
        | ["meshes", _, "extras", "targetNames", _]
        // A sampler of its own for such weights, where the old one is shared.
        | ["animations", _, "samplers", _] => added,
        // A node whose mesh needs other deltas than those of another node points to a copy.
        ["nodes", _, "mesh"] => number.is_some_and(|mesh| mesh >= count("meshes")),
        // A track of weights is continued for the new targets, in a new accessor.
        ["animations", _, "samplers", _, "output"] => number.is_some_and(|output| output >= count("accessors")),
        ["animations", _, "channels", _, "sampler"] => number.is_some(),
        // The BIN chunk grows.
        ["buffers", "0", "byteLength"] => old.bin.is_some() || glb_out,
        // A chunk in a file of its own.
        ["buffers", "0", "uri"] if !glb_out => added && old.bin.is_some(),
        // Many buffers and images become one chunk; which bytes views have is looked at elsewhere.
        ["buffers", ..]
        | ["bufferViews", _, "buffer" | "byteOffset"]
        | ["images", _, "uri" | "bufferView" | "mimeType"] => glb_out && old.bin.is_none(),
        _ => false,
    }
}

fn opens(path: &Path) -> bool {
    gltf::Gltf::from_slice(&std::fs::read(path).expect("a file")).is_ok()
}

/// What is lost between two files.
fn check_document(input: &Path, output: &Path) {
    let name = format!("{} as {}", input.display(), output.display());
    let (old, new) = (Document::open(input), Document::open(output));
    let glb_out = new.bin.is_some();
    for difference in differences(&old.json, &new.json) {
        assert!(allowed(&difference, &old, glb_out), "{name}: {difference:?}");
    }
    for view in 0..list(&old.json, "bufferViews").len() {
        assert!(old.view(view) == new.view(view), "{name}: buffer view {view}");
    }
    for (k, bytes) in old.buffers.iter().enumerate() {
        let length = old.json["buffers"][k]["byteLength"].as_u64().expect("a length") as usize;
        if old.bin.is_none() && glb_out {
            assert!(
                new.buffers[0].windows(length).any(|window| window == &bytes[..length]),
                "{name}: buffer {k}"
            );
        } else {
            assert!(new.buffers[k].starts_with(&bytes[..length]), "{name}: buffer {k}");
        }
    }
    if let (Some(old), Some(new)) = (&old.bin, &new.bin) {
        assert!(new.starts_with(old), "{name}: the old chunk stands first");
    }
    for (k, image) in list(&old.json, "images").iter().enumerate() {
        let Some(uri) = image["uri"].as_str().filter(|uri| !uri.starts_with("data:")) else { continue };
        let before = std::fs::read(beside(input, uri)).expect("an image");
        let image = &new.json["images"][k];
        let after = match image["uri"].as_str() {
            Some(uri) => std::fs::read(beside(output, uri)).expect("an image"),
            None => new.view(image["bufferView"].as_u64().expect("a view") as usize).to_vec(),
        };
        assert!(before == after, "{name}: image {k}");
    }
    assert!(!opens(input) || opens(output), "{name}: another reader opened the input and refuses the output");
}

fn as_glb(path: &Path) -> Vec<u8> {
    Gltf::read(path, &Limits::default())
        .and_then(|gltf| gltf.to_glb())
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The largest distance between two evaluations, in parts of the diagonal.
fn apart(a: &[Shown], b: &[Shown]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b).flat_map(|(a, b)| {
        assert_eq!((a.node, a.positions.len()), (b.node, b.positions.len()));
        a.positions.iter().zip(&b.positions)
    });
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max) / oracle::diagonal(b).max(f64::MIN_POSITIVE)
}

/// Clips of the input play in the output as they did.
fn check_clips(name: &str, input: &[u8], output: &[u8], clips: usize) {
    for clip in 0..clips {
        for seconds in [0.0, 0.31, 0.77, 5.0] {
            let [old, new] =
                [input, output].map(|glb| oracle::evaluate_clip(glb, |_| Some(clip), seconds, true));
            let far = apart(&new, &old);
            assert!(far <= 1e-6, "{name}: clip {clip} at {seconds} s is {far} of the diagonal off");
        }
    }
}

fn check(input: &Path) -> f64 {
    let place = Place::new();
    place.write("any.ron", ANY);
    for folder in ["in", "out"] {
        std::fs::create_dir(place.path(folder)).expect("a folder");
    }
    let input = planted(input, &place.path("in"));
    let name = input.display().to_string();
    let before = as_glb(&input);
    let clips = list(&Document::open(&input).json, "animations").len();
    let mut worst = 0.0_f64;
    for out in ["out/out.glb", "out/out.gltf", "in/beside.gltf"] {
        let args = ["apply", "any.ron", &name, "-o", out, "--fps", "8", "-q"];
        place.run_with(args, b"").expect(0);
        check_document(&input, &place.path(out));
        let after = as_glb(&place.path(out));
        check_clips(&name, &before, &after, clips);
        for frame in [0, 3, 8] {
            let seconds = f64::from(frame) / FPS;
            let at = seconds.to_string();
            if !out.ends_with("glb") && frame != 3 {
                continue;
            }
            place.run_with(["apply", "any.ron", &name, "-o", "still.glb", "--at", &at, "-q"], b"").expect(0);
            let still = oracle::evaluate(&place.read("still.glb"), None, 0.0);
            let played = oracle::evaluate(&after, Some("wirework"), seconds as f32);
            let far = apart(&played, &still);
            assert!(far <= PLAYED, "{name} as {out} at {seconds} s: {far} of the diagonal");
            worst = worst.max(far);
            let moved = apart(&still, &oracle::evaluate(&before, None, 0.0));
            assert_eq!(moved > 0.01, frame > 0, "{name} at {seconds} s moves by {moved}");
        }
    }
    worst
}

#[test]
fn real_files_lose_nothing_and_play_what_stills_show() {
    let all = documents();
    let worst = all.iter().map(|path| check(path)).fold(0.0, f64::max);
    eprintln!("{} files; played positions are off by {worst:e} of the diagonal at most", all.len());
}
