//! Small models made here: what an effect does not touch comes out as it went in, and what it moves is where it belongs.

use std::collections::BTreeSet;
use std::fmt::Write;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use crate::make::Doc;
use crate::oracle;
use crate::place::Place;

/// How far what is written may be from the closed form, in metres of a scene of 4 m.
const CLOSE: f64 = 1e-5;
/// What stands for a texture: images are copied, never looked into.
const TEXTURE: &[u8] = b"\x89PNG\r\n\x1a\nnot a picture, and not to be touched";
const RADIUS: f64 = 0.7;

/// A wire from (0, 0, 3) along x that rises by half a metre in a second.
const RISE: &str = "Deform(wires: [Wire(
    curve: Polyline(points: [(0, 0, 3), (3, 0, 3)]), radius: 0.7,
    pose: Keys([(0, [(0, 0, 3), (3, 0, 3)]), (1, [(0, 0.5, 3), (3, 0.5, 3)])]),
)])";

/// Where [`RISE`] takes a point.
fn risen(p: DVec3, t: f64) -> DVec3 {
    let foot = DVec3::new(p.x.clamp(0.0, 3.0), 0.0, 3.0);
    let x = (p.distance(foot) / RADIUS).min(1.0);
    p + DVec3::Y * ((1.0 - x * x).powi(2) * 0.5 * t)
}

/// A textured strip along x on two joints, the second bent by a quarter turn about y against how it was bound, with a
/// clip, and with things that nobody knows. Its node's own place does not count, as it is skinned.
fn strip() -> Doc {
    let mut doc = Doc::new();
    let columns = 0..=8;
    let each = |value: &dyn Fn(f32, f32) -> Vec<f32>| -> Vec<f32> {
        columns.clone().flat_map(|i| [-0.1, 0.1].map(|y| value(i as f32 / 4.0, y)).concat()).collect()
    };
    let attributes = json!({
        "POSITION": doc.floats("VEC3", &each(&|x, y| vec![x, y, 0.0])),
        "NORMAL": doc.floats("VEC3", &each(&|_, _| vec![0.0, 0.0, 1.0])),
        "TEXCOORD_0": doc.floats("VEC2", &each(&|x, y| vec![x / 2.0, y + 0.5])),
        "WEIGHTS_0": doc.floats("VEC4", &each(&|x, _| vec![1.0 - x / 2.0, x / 2.0, 0.0, 0.0])),
        "JOINTS_0": doc.accessor(
            json!({ "componentType": 5121, "type": "VEC4", "count": 18 }), &[0, 1, 0, 0].repeat(18)),
    });
    let quads = (0..8_u16).flat_map(|i| [0, 2, 1, 1, 2, 3].map(|k| 2 * i + k));
    let indices: Vec<u8> = quads.flat_map(u16::to_le_bytes).collect();
    let indices = doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": 48 }), &indices);
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": indices, "material": 0 }));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    doc.node(json!({ "mesh": mesh, "skin": 0, "translation": [100, 0, 0] }));
    doc.node(json!({ "name": "hip", "translation": [0, 0, 3], "children": [2] }));
    doc.node(json!({ "name": "knee", "translation": [1, 0, 0], "rotation": [0, half, 0, half] }));
    let mut binds = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    binds.extend(glam::Mat4::from_translation(Vec3::new(-1.0, 0.0, 0.0)).to_cols_array());
    let binds = doc.floats("MAT4", &binds);
    let times = doc.floats("SCALAR", &[0.0, 1.0]);
    doc.json["accessors"][times]["min"] = json!([0.0]);
    doc.json["accessors"][times]["max"] = json!([1.0]);
    let turns = doc.floats("VEC4", &[0.0, half, 0.0, half, 0.0, 0.0, 0.0, 1.0]);
    let image = doc.view(TEXTURE);
    for (key, value) in [
        ("scene", json!(0)),
        ("scenes", json!([{ "nodes": [0, 1] }])),
        ("skins", json!([{ "joints": [1, 2], "inverseBindMatrices": binds }])),
        ("images", json!([{ "bufferView": image, "mimeType": "image/png" }])),
        ("samplers", json!([{ "wrapS": 33071 }])),
        ("textures", json!([{ "source": 0, "sampler": 0 }])),
        (
            "materials",
            json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }, "extras": { "a": 1.50 } }]),
        ),
        (
            "animations",
            json!([{
                "name": "walk",
                "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
                "samplers": [{ "input": times, "output": turns }],
            }]),
        ),
        ("extensionsUsed", json!(["EXT_nobody_knows"])),
        ("extensions", json!({ "EXT_nobody_knows": { "deep": [1, null, "x"] } })),
    ] {
        doc.json[key] = value;
    }
    doc
}

/// The two chunks of a GLB.
fn chunks(glb: &[u8]) -> (Value, Vec<u8>) {
    let length = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let json = length(12);
    let bin = 20 + json;
    let value = serde_json::from_slice(&glb[20..bin]).unwrap();
    (value, glb[bin + 8..bin + 8 + length(bin)].to_vec())
}

fn starts_with(new: &Value, old: &Value, key: &str) {
    let [new, old] = [new, old].map(|value| value[key].as_array().unwrap());
    assert_eq!(new[..old.len()], old[..], "{key}");
}

#[test]
fn a_skinned_textured_clip_keeps_all_and_rises_where_it_stands() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    let input = strip().glb();
    place.write("in.glb", &input);
    let (old, old_bin) = chunks(&input);
    let rest = &oracle::evaluate(&input, None, 0.0)[0].positions;
    for (flags, clip) in [("", "wirework"), (" --into walk", "walk")] {
        let err = place.run(&format!("apply rise.ron in.glb -o out.glb{flags}")).expect(0).err();
        let told = " s; its clip is 1 \"wirework\", --into 0 joins it with the input's own\n";
        assert_eq!(
            (err.matches("its clip").count(), err.ends_with(told)),
            (usize::from(flags.is_empty()), flags.is_empty()),
            "{err}"
        );
        let line = format!("apply rise.ron in.glb -o out.glb{flags}");
        for still in [" -q", " --at 1"].iter().filter(|_| flags.is_empty()) {
            assert!(!place.run(&format!("{line}{still}")).expect(0).err().contains("its clip"), "{still}");
        }
        place.run(&line).expect(0);
        let glb = place.read("out.glb");
        let (new, new_bin) = chunks(&glb);
        for key in
            ["scene", "scenes", "skins", "images", "samplers", "textures", "materials", "extensions", "nodes"]
        {
            assert_eq!(old[key], new[key], "{key}");
        }
        starts_with(&new, &old, "bufferViews");
        starts_with(&new, &old, "accessors");
        assert!(new_bin.starts_with(&old_bin), "the old bytes stand first");
        assert!(old_bin.windows(TEXTURE.len()).any(|bytes| bytes == TEXTURE));
        let clips = new["animations"].as_array().unwrap();
        if flags.is_empty() {
            assert_eq!((clips.len(), &clips[0]), (2, &old["animations"][0]), "a clip of its own, behind");
        } else {
            assert_eq!(clips.len(), 1);
            starts_with(&clips[0], &old["animations"][0], "channels");
            starts_with(&clips[0], &old["animations"][0], "samplers");
        }
        for t in [0.0, 0.5, 1.0] {
            let shown = oracle::evaluate(&glb, Some(clip), t);
            assert_eq!((shown.len(), shown[0].positions.len()), (1, 18));
            for (now, &before) in shown[0].positions.iter().zip(rest) {
                let want = risen(before, f64::from(t));
                assert!(now.distance(want) < CLOSE, "{before} at {t} s: {now}, not {want}");
            }
        }
    }
    let moved = rest.iter().filter(|&&p| risen(p, 1.0) != p).count();
    assert!((4..18).contains(&moved), "some of it moves, and some does not: {moved}");
}

/// A prism about the x axis whose texture is cut open along one edge, with all that a text may hold besides.
fn prism() -> String {
    const SIDES: u32 = 8;
    let mut text = "# made by hand\nmtllib none.mtl\no prism\n".to_owned();
    for i in 0..2 * SIDES {
        let angle = f64::from(i % SIDES) / f64::from(SIDES) * std::f64::consts::TAU;
        let (y, z) = (0.3 * angle.cos(), 3.0 + 0.3 * angle.sin());
        writeln!(text, "v {} {y:.6} {z:.6}", f64::from(i / SIDES)).unwrap();
    }
    for i in 0..2 * (SIDES + 1) {
        let u = f64::from(i % (SIDES + 1)) / f64::from(SIDES);
        writeln!(text, "vt {u:.4} {}", i / (SIDES + 1)).unwrap();
    }
    text.push_str("usemtl skin\ns 1\n");
    for i in 0..SIDES {
        let next = (i + 1) % SIDES;
        let corners = [(i, i), (next, i + 1), (next + SIDES, i + SIDES + 2), (i + SIDES, i + SIDES + 1)];
        let corners = corners.map(|(v, t)| format!("{}/{}", v + 1, t + 1)).join(" ");
        writeln!(text, "f {corners}").unwrap();
    }
    text + "# the end\n"
}

#[test]
fn an_obj_keeps_its_text_and_its_seam_stays_shut() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    let text = prism();
    place.write("in.obj", &text);
    place.run("apply rise.ron in.obj -o rest.obj --at 0").expect(0);
    assert!(place.read("rest.obj") == text.as_bytes(), "at rest the text is what it was");
    place.run("apply rise.ron in.obj -o still.obj --at 1").expect(0);
    let still = String::from_utf8(place.read("still.obj")).unwrap();
    assert_eq!(still.lines().count(), text.lines().count());
    let mut want = Vec::new();
    for (now, before) in still.lines().zip(text.lines()) {
        let point = |line: &str| {
            let mut numbers = line.strip_prefix("v ")?.split_whitespace().map(|n| n.parse().unwrap());
            Some(DVec3::new(numbers.next()?, numbers.next()?, numbers.next()?))
        };
        match (point(before), point(now)) {
            (Some(before), Some(now)) => {
                assert!(now.distance(risen(before, 1.0)) < CLOSE, "{before}: {now}");
                want.push(risen(before, 1.0));
            }
            _ => assert_eq!(now, before),
        }
    }
    assert_eq!(want.len(), 16);

    // As a GLB its vertices part at the seam of the texture, and stay together.
    place.run("apply rise.ron in.obj -o out.glb").expect(0);
    let shown = &oracle::evaluate(&place.read("out.glb"), Some("wirework"), 1.0)[0].positions;
    assert!(shown.len() > 16, "{} vertices", shown.len());
    let places: BTreeSet<_> = shown.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    assert_eq!(places.len(), 16, "each place once");
    for p in shown {
        assert!(want.iter().any(|want| want.distance(*p) < CLOSE), "{p}");
    }
}

/// Quads and a concave pentagon in groups, counted from behind, with colours, and with libraries that nobody may open.
const GROUPS: &str = "mtllib outside.mtl ../outside.mtl /dev/zero\n\
    o table\ng top left\nv 0 0 3 1 0 0\nv 1 0 3 0.5 0.25 0\nv 1 0.1 3.1 0 1 0\nv 0 0.1 3.1 0 0 1\nusemtl oak\ns off\nf -4 -3 -2 -1\n\
    g bottom\nv 0 0 3.2\nv 2 0 3.2\nv 2 0 3.4\nv 1 0 3.25\nv 0 0 3.4\nusemtl \u{6a2b}\nf -5 -4 -3 -2 -1\nf 1 2 -4 5\nl -9 -8\n";

/// A file that blocks whoever opens it.
#[cfg(unix)]
fn trap(path: &std::path::Path) {
    assert!(std::process::Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}

#[cfg(unix)]
#[test]
fn an_obj_keeps_groups_polygons_and_colours_and_opens_no_library() {
    let place = Place::new();
    std::fs::create_dir(place.path("in")).unwrap();
    trap(&place.path("outside.mtl"));
    trap(&place.path("in/outside.mtl"));
    place.write("rise.ron", RISE);
    place.write("in/in.obj", GROUPS);
    place.run("apply rise.ron in/in.obj -o out.obj --at 1").expect(0);
    let out = String::from_utf8(place.read("out.obj")).unwrap();
    assert_eq!(out.lines().count(), GROUPS.lines().count());
    let mut moved = 0;
    for (now, before) in out.lines().zip(GROUPS.lines()) {
        let Some(numbers) = before.strip_prefix("v ") else {
            assert_eq!(now, before);
            continue;
        };
        let split = |line: &str| line.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let (now, before) = (split(&now[2..]), split(numbers));
        assert_eq!((&now[3..], now.len()), (&before[3..], before.len()), "colours stay as they are");
        let point = |words: &[String]| DVec3::from_array([0, 1, 2].map(|k| words[k].parse().unwrap()));
        let (p, q) = (point(&before), point(&now));
        assert!(q.distance(risen(p, 1.0)) < CLOSE, "{p}: {q}");
        moved += usize::from(p != q);
    }
    assert_eq!(moved, 9);

    // The same shape in triangles, none of which leaves the pentagon or turns over.
    place.run("apply rise.ron in/in.obj -o out.glb --at 0").expect(0);
    place.run("inspect in/in.obj").expect(0);
    place.run("render in/in.obj -o out.png --size 16x16 --fast").expect(0);
    let (json, bin) = chunks(&place.read("out.glb"));
    let of = |reference: &Value| {
        let accessor = &json["accessors"][reference.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
        (accessor["count"].as_u64().unwrap() as usize, accessor["componentType"].clone(), &bin[start..])
    };
    let primitive = &json["meshes"][0]["primitives"][0];
    let (count, kind, bytes) = of(&primitive["indices"]);
    let index = |k: usize| match kind.as_u64() {
        Some(5121) => usize::from(bytes[k]),
        Some(5123) => usize::from(u16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]])),
        _ => u32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap()) as usize,
    };
    let (_, _, bytes) = of(&primitive["attributes"]["POSITION"]);
    let number = |k: usize| f64::from(f32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap()));
    let vertex = |v: usize| DVec3::new(number(3 * v), number(3 * v + 1), number(3 * v + 2));
    let area = |k: usize| {
        let [a, b, c] = [0, 1, 2].map(|corner| vertex(index(3 * k + corner)));
        (b - a).cross(c - a).y / 2.0
    };
    assert_eq!(count / 3, 2 + 3 + 2);
    let areas: Vec<f64> = (0..count / 3).map(area).collect();
    assert!(areas[2..5].iter().all(|&area| area < 0.0), "{areas:?}");
    // Its shoelace area: 0.4 less the notch of 0.15 below the line from (2, 3.4) to (0, 3.4).
    assert!((areas[2..5].iter().sum::<f64>() + (0.4 - 0.15)).abs() < 1e-6, "{areas:?}");
}
