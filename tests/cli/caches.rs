//! Point caches, read by what the formats say, against the OBJ files of the same frames.

use serde_json::{Value, json};

use crate::limbs::made::figure;
use crate::make::Doc;
use crate::place::Place;
use crate::wrinkles::made::{ARM, arm};

/// A cache as its reader has it.
#[derive(Debug, PartialEq)]
struct Cache {
    /// Of a `.pc2`: the first frame and the frames from one sample to the next.
    start: Option<[f32; 2]>,
    /// Of an `.mdd`.
    times: Vec<f32>,
    frames: Vec<Vec<[f32; 3]>>,
}

fn word(bytes: &[u8], at: usize, big: bool) -> u32 {
    let word = bytes[at..at + 4].try_into().unwrap();
    if big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
}

fn samples(bytes: &[u8], start: usize, [points, frames]: [usize; 2], big: bool) -> Vec<Vec<[f32; 3]>> {
    assert_eq!(bytes.len(), start + 12 * points * frames, "{points} points in {frames} frames");
    let number = |at: usize| f32::from_bits(word(bytes, at, big));
    let point = |at: usize| [number(at), number(at + 4), number(at + 8)];
    let frame = |k: usize| (0..points).map(|i| point(start + 12 * (k * points + i))).collect();
    (0..frames).map(frame).collect()
}

fn pc2(bytes: &[u8]) -> Cache {
    assert_eq!((&bytes[..12], word(bytes, 12, false)), (&b"POINTCACHE2\0"[..], 1));
    let counts = [16, 28].map(|at| word(bytes, at, false) as usize);
    let start = [20, 24].map(|at| f32::from_bits(word(bytes, at, false)));
    Cache { start: Some(start), times: Vec::new(), frames: samples(bytes, 32, counts, false) }
}

fn mdd(bytes: &[u8]) -> Cache {
    let [frames, points] = [0, 4].map(|at| word(bytes, at, true) as usize);
    let times = (0..frames).map(|k| f32::from_bits(word(bytes, 8 + 4 * k, true))).collect();
    Cache { start: None, times, frames: samples(bytes, 8 + 4 * frames, [points, frames], true) }
}

/// The vertices of an OBJ file.
fn vertices(text: &[u8]) -> Vec<[f32; 3]> {
    let text = std::str::from_utf8(text).unwrap();
    let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
    let point = |line: &str| -> [f32; 3] {
        let numbers: Vec<f32> = line.split_whitespace().take(3).map(|n| n.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    lines.map(point).collect()
}

#[track_caller]
fn same(a: &[[f32; 3]], b: &[[f32; 3]], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}");
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!(a, b, "{what}: point {i}");
    }
}

/// A cache of both kinds as well as an OBJ a frame; gives the cache.
#[track_caller]
fn as_objs(place: &Place, line: &str, frames: std::ops::Range<u32>) -> Cache {
    place.run(&format!("apply {line} -o f_####.obj --cache a.pc2 --cache a.mdd -q")).expect(0);
    let (first, second) = (pc2(&place.read("a.pc2")), mdd(&place.read("a.mdd")));
    assert_eq!(first.frames, second.frames);
    assert_eq!(first.frames.len(), frames.len());
    for (k, frame) in frames.zip(&first.frames) {
        same(frame, &vertices(&place.read(&format!("f_{k:04}.obj"))), &format!("{line}: frame {k}"));
    }
    Cache { times: second.times, ..first }
}

#[test]
fn a_cache_has_the_vertices_of_the_objs() {
    let place = Place::new();
    let cache = as_objs(&place, "lift.ron --fps 8", 0..9);
    assert_eq!((cache.start, cache.frames[0].len()), (Some([0.0, 1.0]), 17 * 17));
    assert_eq!(cache.times, (0..9_u8).map(|k| f32::from(k) / 8.0).collect::<Vec<_>>());
    assert!(cache.frames[8].iter().any(|p| p[1] == 0.5), "the ridge has risen");
    let part = as_objs(&place, "lift.ron --fps 8 --frames 3..5", 3..5);
    assert_eq!((part.start, part.times), (Some([3.0, 1.0]), vec![0.375, 0.5]));
    assert_eq!(part.frames, cache.frames[3..5]);
    // As the output itself.
    for name in ["b.pc2", "b.mdd"] {
        let done = place.run(&format!("apply lift.ron --fps 8 --frames 3..5 -o {name}")).expect(0);
        assert!(done.err().contains(&format!("{name}: 2 frames of 289 points")), "{}", done.err());
        assert_eq!(place.read(name), place.read(&name.replace('b', "a")));
    }
    // And alone.
    place.run("apply lift.ron --fps 8 --frames 3..5 --cache c.pc2").expect(0);
    assert_eq!(place.read("c.pc2"), place.read("a.pc2"));
    let left: Vec<String> = place.files().into_iter().filter(|name| name.starts_with('.')).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_still_is_one_sample() {
    let place = Place::new();
    place.run("apply lift.ron --at 0.5 --fps 8 -o a.pc2 --cache a.mdd --report report.json").expect(0);
    place.run("apply lift.ron --at 0.5 -o a.obj").expect(0);
    let (first, second) = (pc2(&place.read("a.pc2")), mdd(&place.read("a.mdd")));
    assert_eq!((first.start, second.times, first.frames.len()), (Some([4.0, 1.0]), vec![0.5], 1));
    assert_eq!(first.frames, second.frames);
    same(&first.frames[0], &vertices(&place.read("a.obj")), "a still");
    let report: Value = serde_json::from_slice(&place.read("report.json")).unwrap();
    assert_eq!(report["caches"][1], json!({ "path": "a.mdd", "points": 289, "frames": 1 }));
}

#[test]
fn a_clip_that_drives_the_effect_is_in_the_cache() {
    let place = Place::new();
    place.write("arm.glb", arm(16, 24).glb());
    let round = 0.999 * std::f64::consts::TAU * ARM.0;
    place.write(
        "strain.ron",
        format!(
            "Wrinkle(center: (0, {}, 0), direction: (0, 0, 1), size: ({round}, 0.2), creases: 3, thickness: 0.03, \
             intensity: 0.012, drive: Strain)",
            ARM.0
        ),
    );
    let cache = as_objs(&place, "strain.ron arm.glb --fps 4", 0..9);
    let moved = |k: usize| {
        let pairs = cache.frames[0].iter().zip(&cache.frames[k]);
        pairs.map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f32::max)
    };
    assert!(moved(4) > 0.1, "the arm bends: {}", moved(4));
    // A limb on what a clip poses.
    place.write("figure.glb", figure(true).glb());
    place.write(
        "limb.ron",
        "Ik(chain: Skin(root: \"upper\", tip: \"hand\"), influence: SkinWeights, goal: Node(\"target\"))",
    );
    as_objs(&place, "limb.ron figure.glb --fps 4", 0..9);
    // What a skeleton only comes near, the cache has exactly.
    place.run("apply limb.ron figure.glb --fps 4 --bake skin -o skin.glb --cache skin.pc2 -q").expect(0);
    assert_eq!(place.read("skin.pc2"), place.read("a.pc2"));
}

/// Two quads beside each other, both called alike, the second moved by its node.
fn pair() -> Doc {
    let mut doc = Doc::new();
    let positions = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -0.2, 1.0, 0.0, -0.2]);
    let indices: Vec<u8> = [0_u16, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": 6 }), &indices);
    doc.json["accessors"][positions]["min"] = json!([0.0, 0.0, -0.2]);
    doc.json["accessors"][positions]["max"] = json!([1.0, 0.0, 0.0]);
    let mesh = doc.mesh(&json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    doc.node(json!({ "name": "a/quad", "mesh": mesh }));
    doc.node(json!({ "name": "a:quad", "mesh": mesh, "translation": [0, 0, 0.25] }));
    doc
}

#[test]
fn each_node_may_have_a_cache_of_its_own() {
    let place = Place::new();
    place.write("pair.glb", pair().glb());
    let line = "apply lift.ron pair.glb --fps 4 --cache all.pc2 --cache {node}.pc2 -o out.glb";
    let done = place.run(line).expect(0);
    let told =
        "2 meshes are in one cache, one behind the other: \"a/quad\" from vertex 0, \"a:quad\" from vertex 4";
    assert!(done.err().contains(told) && done.err().contains("[cache-of-many]"), "{}", done.err());
    let [all, first, second] =
        ["all.pc2", "a_quad.pc2", "a_quad_2.pc2"].map(|name| pc2(&place.read(name)).frames);
    for (k, frame) in all.iter().enumerate() {
        assert_eq!([first[k].clone(), second[k].clone()].concat(), *frame, "frame {k}");
    }
    assert!(first[4] != second[4] && all.len() == 5);
    let quiet = place.run("apply lift.ron pair.glb --fps 4 --cache {node}.mdd").expect(0);
    assert!(!quiet.err().contains("cache-of-many"), "{}", quiet.err());
    // Beside the caches the document is what it is without.
    place.run("apply lift.ron pair.glb --fps 4 -o alone.glb -q").expect(0);
    assert_eq!(place.read("out.glb"), place.read("alone.glb"));
    // Pieces of a stitch are nodes as well; what is sewn stays apart, as in a sequence.
    place.write(
        "sew.ron",
        "Stitch(patches: [
            Piece(name: \"left\", object: Grid(size: (1, 1), cells: (4, 4), translation: (-0.6, 0, 0))),
            Piece(name: \"right\", object: Grid(size: (1, 1), cells: (4, 4), translation: (0.6, 0, 0)))],
          seams: [Seam(a: Edge(piece: \"left\", from: (-0.1, 0, 0.5), to: (-0.1, 0, -0.5)),
                       b: Edge(piece: \"right\", from: (0.1, 0, 0.5), to: (0.1, 0, -0.5)), weld: true,
                       closure: Keys([(0, 0), (1, 1)]))])",
    );
    as_objs(&place, "sew.ron --fps 4", 0..5);
    place.run("apply sew.ron --fps 4 --cache {node}.pc2 --at 1").expect(0);
    assert_eq!(pc2(&place.read("left.pc2")).frames[0].len(), 25);
    assert_eq!(pc2(&place.read("right.pc2")).frames[0].len(), 25);
}

#[test]
fn vertices_that_primitives_share_are_told_of() {
    let place = Place::new();
    // All of them twice; one triangle each, which is another order; one of the two triangles.
    let indices = |doc: &mut Doc, list: &[u16]| {
        let bytes: Vec<u8> = list.iter().flat_map(|i| i.to_le_bytes()).collect();
        doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": list.len() }), &bytes)
    };
    for (lists, remade) in [
        ([[0, 1, 2, 2, 1, 3].as_slice(), &[0, 1, 2, 2, 1, 3]].as_slice(), Some(8)),
        (&[&[0, 1, 2], &[2, 1, 3]], Some(6)),
        (&[&[0, 1, 2]], Some(3)),
        (&[&[2, 1, 3, 0, 1, 2]], None),
    ] {
        let mut doc = pair();
        let first = doc.json["meshes"][0]["primitives"][0].clone();
        let primitives: Vec<Value> = lists
            .iter()
            .map(|list| json!({ "attributes": first["attributes"], "indices": indices(&mut doc, list) }))
            .collect();
        doc.json["meshes"][0]["primitives"] = json!(primitives);
        place.write("pair.glb", doc.glb());
        let done = place.run("apply lift.ron pair.glb --fps 4 --cache {node}.pc2").expect(0);
        let told = remade.map(|n| format!("the cache has all 4 of them, Blender makes {n} of its own"));
        assert_eq!(done.err().contains("[cache-order]"), told.is_some(), "{lists:?}: {}", done.err());
        assert!(told.is_none_or(|told| done.err().contains(&told)), "{lists:?}: {}", done.err());
    }
    place.write("pair.glb", pair().glb());
    place.run("apply lift.ron pair.glb --fps 4 --cache all.pc2 --strict").expect(3);
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let place = Place::new();
    place.write("pair.glb", pair().glb());
    place.write("preset.pc2", crate::place::LIFT);
    std::fs::create_dir(place.path("folder.pc2")).unwrap();
    let before = place.files();
    for (code, line) in [
        (2, "apply lift.ron -o a.glb --cache x.txt"),
        (2, "apply lift.ron -o a.glb --cache x"),
        (2, "apply lift.ron -o a.pc2 --cache a.pc2"),
        (2, "apply lift.ron -o a.pc2 --cache ./a.pc2"),
        (2, "apply lift.ron -o a.glb --cache a.mdd --cache a.mdd"),
        (2, "apply preset.pc2 -o a.glb --cache preset.pc2"),
        (2, "apply preset.pc2 -o preset.pc2"),
        (2, "apply preset.pc2 -o preset.pc2 --in-place"),
        (2, "apply lift.ron -o a.glb --cache a.pc2 --report a.pc2"),
        (2, "apply lift.ron pair.glb -o a_quad_2.pc2 --cache {node}.pc2"),
        (2, "apply lift.ron pair.glb --cache {node}.pc2 --report a_quad.pc2"),
        (2, "apply lift.ron -o a.pc2 --bake skin"),
        (2, "apply lift.ron pair.glb -o a.pc2 --into 0"),
        (2, "apply lift.ron pair.glb --cache a.pc2 --into nope"),
        (2, "apply lift.ron --cache a.pc2 --bake skin"),
        (2, "apply lift.ron --cache a_####.pc2"),
        (2, "apply lift.ron -o a_####.mdd"),
        (2, "apply lift.ron -o a.glb --tolerance -1"),
        (1, "apply lift.ron -o a.glb --cache nowhere/a.pc2"),
        (1, "apply lift.ron -o a.glb --cache folder.pc2"),
        (1, "apply lift.ron -o nowhere/a.pc2"),
        (5, "apply lift.ron -o a.pc2 --max-frames 3"),
    ] {
        let done = place.run(line);
        assert_eq!(done.code(), code, "{line}: {}", done.err());
        assert_eq!(place.files(), before, "{line}");
    }
    place.run("apply lift.ron --dry-run --cache a.pc2").expect(0);
    assert_eq!(place.files(), before);
}

#[test]
fn threads_do_not_count() {
    let place = Place::new();
    for threads in [1, 2, 5] {
        place.run(&format!("apply lift.ron --fps 8 -o {threads}.pc2 --threads {threads} -q")).expect(0);
        assert_eq!(place.read(&format!("{threads}.pc2")), place.read("1.pc2"));
    }
}
