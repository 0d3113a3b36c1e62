//! One sheet in every form that a document may store it in: the same preset takes its vertices to the same places.

use glam::{DMat4, DQuat, DVec3};
use percent_encoding::{NON_ALPHANUMERIC, percent_encode, utf8_percent_encode};
use serde_json::{Value, json};

use crate::document::Document;
use crate::make::Doc;
use crate::place::Place;
use crate::player::play;

/// How far vertices may be from where they belong, in parts of the diagonal.
const CLOSE: f64 = 2e-5;
const COLUMNS: usize = 13;
const ROWS: usize = 9;
/// Metres of a unit of the sheet's integers: a power of two.
const UNIT: f64 = 1.0 / 32.0;

/// A wire along x that rises by half a metre in a second.
const RISE: &str = "Deform(wires: [Wire(
    curve: Polyline(points: [(-1, 0, 0.1), (1, 0, 0.1)]), radius: 0.6,
    pose: Keys([(0, [(-1, 0, 0.1), (1, 0, 0.1)]), (1, [(-1, 0.5, 0.1), (1, 0.5, 0.1)])]),
)])";

/// Where [`RISE`] takes a point.
fn risen(p: DVec3, t: f64) -> DVec3 {
    let foot = DVec3::new(p.x.clamp(-1.0, 1.0), 0.0, 0.1);
    let x = (p.distance(foot) / 0.6).min(1.0);
    p + DVec3::Y * ((1.0 - x * x).powi(2) * 0.5 * t)
}

/// The vertices of a folded sheet as integers of 7 bits.
fn sheet() -> Vec<[i32; 3]> {
    let vertex = |v: usize| {
        let [i, j] = [v % COLUMNS, v / COLUMNS].map(|k| i32::try_from(k).unwrap());
        [8 * (i - 6), 6 * (j % 3) - 6, 10 * (j - 4)]
    };
    (0..COLUMNS * ROWS).map(vertex).collect()
}

/// Where they are in the world, metres.
fn world() -> Vec<DVec3> {
    sheet().into_iter().map(|p| DVec3::from_array(p.map(f64::from)) * UNIT).collect()
}

/// The corners of its cells, counter-clockwise from above.
fn cells() -> Vec<[u32; 4]> {
    let cell = |k: usize| {
        let v = (k / (COLUMNS - 1) * COLUMNS + k % (COLUMNS - 1)) as u32;
        [v, v + COLUMNS as u32, v + COLUMNS as u32 + 1, v + 1]
    };
    (0..(COLUMNS - 1) * (ROWS - 1)).map(cell).collect()
}

fn triangles() -> Vec<u32> {
    cells().into_iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]).collect()
}

/// Vectors as floats, one after the other.
fn flat(points: &[DVec3]) -> Vec<f32> {
    points.iter().flat_map(|p| p.as_vec3().to_array()).collect()
}

fn indices(doc: &mut Doc, kind: u32, list: &[u32]) -> Value {
    let bytes = list.iter().flat_map(|&i| match kind {
        5121 => vec![u8::try_from(i).unwrap()],
        5123 => (i as u16).to_le_bytes().to_vec(),
        _ => i.to_le_bytes().to_vec(),
    });
    let bytes: Vec<u8> = bytes.collect();
    json!(doc.accessor(json!({ "componentType": kind, "type": "SCALAR", "count": list.len() }), &bytes))
}

/// A document that shows one mesh of these primitives by one node.
fn shown(mut doc: Doc, primitives: &Value, mut node: Value) -> Doc {
    doc.json["meshes"] = json!([{ "primitives": primitives }]);
    node["mesh"] = json!(0);
    doc.json["nodes"].as_array_mut().unwrap().insert(0, node);
    doc.json["scenes"] = json!([{ "nodes": [0] }]);
    doc
}

/// The sheet as floats in a space that `matrix` takes to the world.
fn floats(matrix: DMat4) -> (Doc, Value) {
    let mut doc = Doc::new();
    let inverse = matrix.inverse();
    let positions: Vec<DVec3> = world().into_iter().map(|p| inverse.transform_point3(p)).collect();
    let attributes = json!({
        "POSITION": doc.floats("VEC3", &flat(&positions)),
        "NORMAL": doc.floats("VEC3", &[0.0, 1.0, 0.0].repeat(COLUMNS * ROWS)),
    });
    (doc, attributes)
}

fn plain(node: Value, matrix: DMat4) -> Doc {
    let (mut doc, attributes) = floats(matrix);
    let indices = indices(&mut doc, 5123, &triangles());
    shown(doc, &json!([{ "attributes": attributes, "indices": indices }]), node)
}

/// With indices of another type, in another order, or without any.
fn topologies() -> Vec<(String, Doc)> {
    let mut out = Vec::new();
    for kind in [5121, 5123, 5125] {
        let (mut doc, attributes) = floats(DMat4::IDENTITY);
        let indices = indices(&mut doc, kind, &triangles());
        let primitives = json!([{ "attributes": attributes, "indices": indices }]);
        out.push((format!("indices of type {kind}"), shown(doc, &primitives, json!({}))));
    }
    let mut doc = Doc::new();
    let corners: Vec<DVec3> = triangles().into_iter().map(|v| world()[v as usize]).collect();
    let attributes = json!({ "POSITION": doc.floats("VEC3", &flat(&corners)) });
    out.push(("no indices".to_owned(), shown(doc, &json!([{ "attributes": attributes }]), json!({}))));
    // Rows as one strip, joined by triangles without area.
    let (mut doc, attributes) = floats(DMat4::IDENTITY);
    let row = |j: u32| {
        let pair = move |i: u32| [j * COLUMNS as u32 + i, (j + 1) * COLUMNS as u32 + i];
        let row: Vec<u32> = (0..COLUMNS as u32).flat_map(pair).collect();
        [vec![row[0]], row.clone(), vec![row[row.len() - 1]]].concat()
    };
    let strip: Vec<u32> = (0..ROWS as u32 - 1).flat_map(row).collect();
    let indices_of_strip = indices(&mut doc, 5121, &strip);
    let primitives = json!([{ "attributes": attributes, "indices": indices_of_strip, "mode": 5 }]);
    out.push(("a strip".to_owned(), shown(doc, &primitives, json!({}))));
    // Every cell as a fan; all of them share their vertices.
    let (mut doc, attributes) = floats(DMat4::IDENTITY);
    let fan = |cell: [u32; 4]| json!({ "attributes": attributes, "indices": indices(&mut doc, 5121, &cell), "mode": 6 });
    let primitives = Value::Array(cells().into_iter().map(fan).collect());
    out.push(("fans".to_owned(), shown(doc, &primitives, json!({}))));
    for (mode, name) in [(0, "points"), (1, "lines"), (2, "a loop"), (3, "a line")] {
        let (doc, attributes) = floats(DMat4::IDENTITY);
        let mut attributes = attributes;
        attributes.as_object_mut().unwrap().remove("NORMAL");
        let primitives = json!([{ "attributes": attributes, "mode": mode }]);
        out.push((name.to_owned(), shown(doc, &primitives, json!({}))));
    }
    out
}

/// Small integers, normalised and not, with a node that undoes it.
fn quantised() -> Vec<(String, Doc)> {
    let mut out = Vec::new();
    // The type, what one unit of the sheet is in it, the integer at the origin, and what a normalised 1 is.
    for (kind, unit, zero, one) in [
        (5120, 1, 0, 127.0),
        (5121, 1, 128, 255.0),
        (5122, 300, -77, 32_767.0),
        (5123, 500, 32_000, 65_535.0),
    ] {
        for normalized in [false, true] {
            let mut doc = Doc::new();
            let size = if kind < 5122 { 1 } else { 2 };
            let lanes = |p: [i32; 3]| {
                let bytes = p.map(|c| (c * unit + zero).to_le_bytes()[..size].to_vec()).concat();
                [bytes, vec![0xee; size]].concat()
            };
            let bytes: Vec<u8> = sheet().into_iter().flat_map(lanes).collect();
            let positions = doc.accessor(
                json!({ "componentType": kind, "normalized": normalized, "type": "VEC3", "count": COLUMNS * ROWS }),
                &bytes,
            );
            doc.json["bufferViews"][0]["byteStride"] = json!(4 * size);
            let normals = doc.accessor(
                json!({ "componentType": 5120, "normalized": true, "type": "VEC3", "count": COLUMNS * ROWS }),
                &[0, 127, 0, 0].repeat(COLUMNS * ROWS),
            );
            doc.json["bufferViews"][1]["byteStride"] = json!(4);
            for list in ["extensionsUsed", "extensionsRequired"] {
                doc.json[list] = json!(["KHR_mesh_quantization"]);
            }
            let integer = UNIT / f64::from(unit);
            let scale = if normalized { integer * one } else { integer };
            let origin = -f64::from(zero) * integer;
            let node = json!({ "scale": [scale, scale, scale], "translation": [origin, origin, origin] });
            let indices = indices(&mut doc, 5123, &triangles());
            let attributes = json!({ "POSITION": positions, "NORMAL": normals });
            let primitives = json!([{ "attributes": attributes, "indices": indices }]);
            out.push((format!("type {kind}, normalised: {normalized}"), shown(doc, &primitives, node)));
        }
    }
    out
}

/// Floats between other floats, and sparse ones.
fn scattered() -> Vec<(String, Doc)> {
    let (points, count) = (world(), COLUMNS * ROWS);
    let mut doc = Doc::new();
    let vertex = |p: &DVec3| {
        let [x, y, z] = p.as_vec3().to_array();
        [[9.0, 9.0].as_slice(), &[0.0, 1.0, 0.0], &[x, y, z]].concat()
    };
    let all: Vec<f32> = points.iter().flat_map(vertex).collect();
    let bytes: Vec<u8> = [7.0_f32].iter().chain(&all).flat_map(|x| x.to_le_bytes()).collect();
    let normals = doc
        .accessor(json!({ "componentType": 5126, "type": "VEC3", "count": count, "byteOffset": 12 }), &bytes);
    doc.json["bufferViews"][0]["byteStride"] = json!(32);
    doc.json["accessors"].as_array_mut().unwrap().push(
        json!({ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count, "byteOffset": 24 }),
    );
    let list = indices(&mut doc, 5123, &triangles());
    let primitives = json!([{ "attributes": { "POSITION": 1, "NORMAL": normals }, "indices": list }]);
    let mut out = vec![("interleaved".to_owned(), shown(doc, &primitives, json!({})))];
    for (name, base, every, kind) in [
        ("sparse over others", true, 3, 5121),
        ("sparse over nothing", false, 1, 5123),
        ("sparse, all", true, 1, 5125),
    ] {
        let mut doc = Doc::new();
        let which: Vec<u32> = (0..count as u32).step_by(every).collect();
        let accessor = json!({ "componentType": 5126, "type": "VEC3", "count": count });
        let positions = if base {
            let wrong = |(v, p): (usize, &DVec3)| if v % every == 0 { DVec3::splat(1e3) } else { *p };
            doc.floats("VEC3", &flat(&points.iter().enumerate().map(wrong).collect::<Vec<_>>()))
        } else {
            doc.json["accessors"] = json!([accessor]);
            0
        };
        let values: Vec<DVec3> = which.iter().map(|&v| points[v as usize]).collect();
        let bytes: Vec<u8> = flat(&values).iter().flat_map(|x| x.to_le_bytes()).collect();
        let values = doc.view(&bytes);
        let width = if kind == 5125 { 4 } else { (kind - 5119) as usize / 2 };
        let bytes: Vec<u8> = which.iter().flat_map(|i| i.to_le_bytes()[..width].to_vec()).collect();
        let view = doc.view(&bytes);
        doc.json["accessors"][positions]["sparse"] = json!({
            "count": which.len(),
            "indices": { "bufferView": view, "componentType": kind },
            "values": { "bufferView": values },
        });
        let list = indices(&mut doc, 5123, &triangles());
        let primitives = json!([{ "attributes": { "POSITION": positions }, "indices": list }]);
        out.push((name.to_owned(), shown(doc, &primitives, json!({}))));
    }
    out
}

fn turned() -> DQuat {
    DQuat::from_euler(glam::EulerRot::XYZ, 0.7, -1.1, 2.0)
}

/// A node and the matrix that it says.
fn node(scale: DVec3, rotation: DQuat, translation: DVec3) -> (Value, DMat4) {
    let json = json!({
        "scale": scale.to_array(), "rotation": rotation.to_array(), "translation": translation.to_array(),
    });
    (json, DMat4::from_scale_rotation_translation(scale, rotation, translation))
}

/// Below nodes that scale, turn and mirror.
fn placed() -> Vec<(String, Doc)> {
    let there = DVec3::new(0.5, -2.0, 3.0);
    let mut out = Vec::new();
    for (name, scale, rotation) in [
        ("scaled", DVec3::new(2.0, 0.5, 3.0), DQuat::IDENTITY),
        ("turned", DVec3::ONE, turned()),
        ("mirrored", DVec3::new(-1.0, 1.0, 1.0), turned()),
        ("inside out", DVec3::new(-0.01, -0.01, -0.01), turned()),
    ] {
        let (node, matrix) = node(scale, rotation, there);
        out.push((name.to_owned(), plain(node, matrix)));
    }
    // Below a turned and unevenly scaled one the matrix shears.
    let (outer, a) = node(DVec3::new(1.0, 4.0, 0.5), turned().inverse(), there);
    let (_, b) = node(DVec3::new(-2.0, 1.0, 1.0), turned(), -there);
    let mut doc = plain(json!({ "matrix": b.to_cols_array() }), a * b);
    let parent = doc.node(outer);
    doc.json["nodes"][parent]["children"] = json!([0]);
    doc.json["scenes"] = json!([{ "nodes": [parent] }]);
    out.push(("sheared".to_owned(), doc));
    out
}

/// On joints that all stand as they were bound, moved together. The node's own place does not count.
fn skinned() -> Vec<(String, Doc)> {
    let mut out = Vec::new();
    for (sets, wide, kind) in
        [(1, false, 5126), (1, true, 5121), (1, false, 5123), (2, false, 5126), (2, true, 5123)]
    {
        let bound = node(DVec3::splat(2.0), turned(), DVec3::new(1.0, 2.0, -1.0)).1;
        let (mut doc, mut attributes) = floats(bound);
        let count = COLUMNS * ROWS;
        for set in 0..sets {
            let joint = |v: usize, k: usize| ((v + 3 * k + set) % 5) as u16;
            let all = (0..count).flat_map(|v| (0..4).map(move |k| joint(v, k)));
            let bytes: Vec<u8> = if wide {
                all.flat_map(u16::to_le_bytes).collect()
            } else {
                all.map(|joint| joint as u8).collect()
            };
            let kind_of_joint = if wide { 5123 } else { 5121 };
            let joints = json!({ "componentType": kind_of_joint, "type": "VEC4", "count": count });
            attributes[format!("JOINTS_{set}")] = json!(doc.accessor(joints, &bytes));
            // In two sets the first has a third of the weight and the second two thirds; of each its first joint has 2 parts
            // of 5.
            let share = if sets == 1 { 1.0 } else { (set + 1) as f64 / 3.0 };
            let weights = [2.0, 1.0, 1.0, 1.0].map(|parts| share * parts / 5.0);
            let bytes: Vec<u8> = (0..count)
                .flat_map(|_| weights)
                .flat_map(|w| match kind {
                    5121 => vec![(w * 255.0).round() as u8],
                    5123 => ((w * 65_535.0).round() as u16).to_le_bytes().to_vec(),
                    _ => (w as f32).to_le_bytes().to_vec(),
                })
                .collect();
            let mut accessor = json!({ "componentType": kind, "type": "VEC4", "count": count });
            if kind != 5126 {
                accessor["normalized"] = json!(true);
            }
            attributes[format!("WEIGHTS_{set}")] = json!(doc.accessor(accessor, &bytes));
        }
        let list = indices(&mut doc, 5123, &triangles());
        let own = json!({ "skin": 0, "translation": [50, 60, 70], "scale": [3, 3, 3] });
        let mut doc = shown(doc, &json!([{ "attributes": attributes, "indices": list }]), own);
        let mut binds = Vec::new();
        let joints: Vec<usize> = (0..5)
            .map(|k| {
                let (json, matrix) =
                    node(DVec3::ONE, turned() * f64::from(k - 2).signum(), DVec3::X * f64::from(k));
                binds.extend((matrix.inverse() * bound).as_mat4().to_cols_array());
                doc.node(json)
            })
            .collect();
        let binds = doc.floats("MAT4", &binds);
        doc.json["skins"] = json!([{ "joints": joints, "inverseBindMatrices": binds }]);
        let roots: Vec<usize> = [0].into_iter().chain(joints).collect();
        doc.json["scenes"] = json!([{ "nodes": roots }]);
        out.push((format!("{sets} sets of weights of type {kind}, wide joints: {wide}"), doc));
    }
    out
}

/// In the second of three scenes, the first of which shows something else.
fn staged() -> Vec<(String, Doc)> {
    let mut doc = plain(json!({}), DMat4::IDENTITY);
    let decoy = doc.floats("VEC3", &[0.0, 0.0, 0.1, 1.0, 0.0, 0.1, 0.0, 0.0, 1.0]);
    let mesh = doc.mesh(&json!({ "attributes": { "POSITION": decoy } }));
    let other = doc.node(json!({ "mesh": mesh }));
    doc.json["scenes"] = json!([{ "nodes": [other] }, { "nodes": [0] }, { "nodes": [0, other] }]);
    doc.json["scene"] = json!(1);
    vec![("one of three scenes".to_owned(), doc)]
}

fn everything() -> Vec<(String, Doc)> {
    [topologies(), quantised(), scattered(), placed(), skinned(), staged()].into_iter().flatten().collect()
}

/// Checks the vertices of each of the output's primitives, which at rest are at `rest`.
#[track_caller]
fn check(name: &str, shown: &[Vec<DVec3>], rest: &[Vec<DVec3>], seconds: f64) {
    let all = world();
    let diagonal =
        all.iter().fold(DVec3::MIN, |a, p| a.max(*p)) - all.iter().fold(DVec3::MAX, |a, p| a.min(*p));
    assert_eq!(shown.len(), rest.len(), "{name}");
    for (shown, rest) in shown.iter().zip(rest) {
        assert_eq!(shown.len(), rest.len(), "{name}");
        for (v, (now, p)) in shown.iter().zip(rest).enumerate() {
            let off = now.distance(risen(*p, seconds)) / diagonal.length();
            assert!(off < CLOSE, "{name}: vertex {v} at {seconds} s: {now} for {}", risen(*p, seconds));
        }
    }
}

/// What a document shows at rest, in the places of the sheet without the error of how it is stored.
fn rest_of(name: &str, document: &Document) -> Vec<Vec<DVec3>> {
    let exact = world();
    let near = |p: DVec3| {
        let found = exact.iter().find(|q| q.distance(p) < 1e-5);
        *found.unwrap_or_else(|| panic!("{name}: {p} is no vertex of the sheet: the test is wrong"))
    };
    play(document, None, 0.0).into_iter().map(|list| list.into_iter().map(near).collect()).collect()
}

/// Applies the preset to `input` and checks animation and still in all formats.
fn applied(place: &Place, name: &str, input: &str) {
    let rest = rest_of(name, &Document::open(&place.path(input)));
    for out in ["out/out.glb", "out/out.gltf"] {
        place.run_with(["apply", "rise.ron", input, "-o", out, "--fps", "4", "-q"], b"").expect(0);
        let document = Document::open(&place.path(out));
        for seconds in [0.0, 0.25, 0.5, 1.0] {
            check(name, &play(&document, Some("wirework"), seconds), &rest, seconds);
        }
        check(name, &play(&document, None, 0.0), &rest, 0.0);
        place.run_with(["apply", "rise.ron", input, "-o", out, "--at", "0.7", "-q"], b"").expect(0);
        check(name, &play(&Document::open(&place.path(out)), None, 0.0), &rest, 0.7);
    }
}

fn rise() -> Place {
    let place = Place::new();
    place.write("rise.ron", RISE);
    std::fs::create_dir(place.path("out")).expect("a folder");
    place
}

#[test]
fn how_numbers_are_stored_does_not_matter() {
    let place = rise();
    let all = everything();
    assert!(all.len() > 30);
    for (name, doc) in all {
        place.write("in.glb", doc.glb());
        applied(&place, &name, "in.glb");
    }
}

#[test]
fn where_numbers_are_stored_does_not_matter() {
    let place = rise();
    std::fs::create_dir(place.path("späte daten")).expect("a folder");
    let doc = plain(json!({}), DMat4::IDENTITY);
    // The last view, the indices, has a buffer of its own.
    let start = doc.json["bufferViews"][2]["byteOffset"].as_u64().unwrap() as usize;
    let buffers = [&doc.bin[..start], &doc.bin[start..]];
    let escaped = |text: &str| utf8_percent_encode(text, NON_ALPHANUMERIC).to_string();
    let data = |bytes: &[u8]| {
        let text = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
        format!("data:application/octet-stream;base64,{text}")
    };
    let (odd, deep) = ("a b%20#ü?.bin", "späte daten/日本.bin");
    for (name, bytes) in
        [("in.bin", buffers[0]), ("in2.bin", buffers[1]), (odd, buffers[0]), (deep, buffers[1])]
    {
        place.write(name, bytes);
    }
    for (name, uris) in [
        ("files", ["in.bin".to_owned(), "in2.bin".to_owned()]),
        ("a dot", ["./in.bin".to_owned(), "././/in2.bin".to_owned()]),
        ("escaped names", [escaped(odd), escaped(deep).replace("%2F", "/")]),
        ("bare names", [odd.replace('%', "%25"), deep.to_owned()]),
        ("data", [data(buffers[0]), data(buffers[1])]),
        ("a file and data", [escaped(odd), data(buffers[1])]),
    ] {
        let mut json = doc.json.clone();
        json["buffers"] = uris
            .iter()
            .zip(buffers)
            .map(|(uri, bytes)| json!({ "uri": uri, "byteLength": bytes.len() }))
            .collect();
        json["bufferViews"][2]["buffer"] = json!(1);
        json["bufferViews"][2].as_object_mut().unwrap().remove("byteOffset");
        place.write("in.gltf", serde_json::to_vec(&json).unwrap());
        applied(&place, name, "in.gltf");
    }
    // Data that is not base64 is escaped bytes.
    let mut json = doc.json.clone();
    json["buffers"] = json!([{ "uri": format!("data:,{}", percent_encode(&doc.bin, NON_ALPHANUMERIC)), "byteLength": doc.bin.len() }]);
    place.write("in.gltf", serde_json::to_vec(&json).unwrap());
    place.run("apply rise.ron in.gltf -o out/out.glb --at 0.7").expect(0);
    let shown = play(&Document::open(&place.path("out/out.glb")), None, 0.0);
    check("escaped bytes", &shown, &[world()], 0.7);
}

#[test]
fn every_instance_of_a_mesh_moves_as_where_it_stands() {
    let place = rise();
    let mut doc = plain(json!({}), DMat4::IDENTITY);
    let mut matrices = vec![DMat4::IDENTITY];
    for (scale, rotation, translation) in [
        (DVec3::ONE, DQuat::IDENTITY, DVec3::new(0.2, 0.1, 0.3)),
        (DVec3::new(-1.0, 1.0, 1.0), turned(), DVec3::ZERO),
        (DVec3::ONE, DQuat::IDENTITY, DVec3::Y * 100.0),
        (DVec3::ONE, DQuat::IDENTITY, DVec3::ZERO),
    ] {
        let (mut json, matrix) = node(scale, rotation, translation);
        json["mesh"] = json!(0);
        doc.node(json);
        matrices.push(matrix);
    }
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 2, 3, 4] }]);
    place.write("in.glb", doc.glb());
    let each = |matrix: &DMat4| world().into_iter().map(|p| matrix.transform_point3(p)).collect();
    let rest: Vec<Vec<DVec3>> = matrices.iter().map(each).collect();
    place.run("apply rise.ron in.glb -o out/out.glb --fps 4").expect(0);
    let document = Document::open(&place.path("out/out.glb"));
    for seconds in [0.0, 0.5, 1.0] {
        check("instances", &play(&document, Some("wirework"), seconds), &rest, seconds);
    }
    place.run("apply rise.ron in.glb -o out/out.glb --at 0.7").expect(0);
    check("instances", &play(&Document::open(&place.path("out/out.glb")), None, 0.0), &rest, 0.7);
    assert_eq!(
        document.json["meshes"].as_array().unwrap().len(),
        3,
        "what moves alike shares a mesh, and what does not move"
    );
}
