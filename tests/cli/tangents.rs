//! Tangents of normal-mapped models: they follow the effect, through mirrored nodes and skins, and only where they are seen.

use glam::DVec3;
use serde_json::{Value, json};

use crate::document::Document;
use crate::make::Doc;
use crate::oracle::{self, Shown};
use crate::place::Place;

/// A wire from (0, 0, 3) along x that rises by a quarter of a metre in a second: no more, as it would fold the gutter.
const RISE: &str = "Deform(wires: [Wire(
    curve: Polyline(points: [(0, 0, 3), (3, 0, 3)]), radius: 0.7,
    pose: Keys([(0, [(0, 0, 3), (3, 0, 3)]), (1, [(0, 0.25, 3), (3, 0.25, 3)])]),
)])";

/// How far played tangents may be from the closed form, degrees: faces are 5 cm wide, and some tangents turn by 30. It is
/// half of that with faces of half the width: the wire's reach ends with a jump of the second derivative.
const CLOSE: f64 = 2.0;
const COLUMNS: usize = 41;
const ROWS: usize = 41;

fn risen(p: DVec3) -> DVec3 {
    let foot = DVec3::new(p.x.clamp(0.0, 3.0), 0.0, 3.0);
    let x = (p.distance(foot) / 0.7).min(1.0);
    p + DVec3::Y * ((1.0 - x * x).powi(2) * 0.25)
}

/// Where [`risen`] takes a direction at a point.
fn carried(p: DVec3, t: DVec3) -> DVec3 {
    let h = 1e-6;
    ((risen(p + h * t) - risen(p - h * t)) / (2.0 * h)).normalize()
}

/// A gutter along x whose texture runs aslant: one half with a normal map on the second set of coordinates, one without any.
/// A mirrored node shows it, and another one by a blend of two joints, which shears it: of the same weights everywhere, for a skin's
/// tangents leave out how weights change along the surface, and are then not quite those of the coordinates.
fn gutter() -> Doc {
    let mut doc = Doc::new();
    let points: Vec<[f32; 2]> = (0..COLUMNS * ROWS)
        .map(|k| [(k % COLUMNS) as f32 * 0.05 - 2.0, (k / COLUMNS) as f32 * 0.05 - 1.0])
        .collect();
    let each = |value: &dyn Fn(f32, f32) -> Vec<f32>| -> Vec<f32> {
        points.iter().flat_map(|&[x, y]| value(x, y)).collect()
    };
    let unit = |v: [f32; 3]| glam::Vec3::from(v).normalize().to_array().to_vec();
    let mut attributes = json!({
        "POSITION": doc.floats("VEC3", &each(&|x, y| vec![x, y, 0.2 * y * y])),
        "NORMAL": doc.floats("VEC3", &each(&|_, y| unit([0.0, -0.4 * y, 1.0]))),
        "TANGENT": doc.floats("VEC4", &each(&|_, y| [unit([1.0, 0.5, 0.2 * y]), vec![-1.0]].concat())),
        "TEXCOORD_0": doc.floats("VEC2", &each(&|_, _| vec![0.5, 0.5])),
        "TEXCOORD_1": doc.floats("VEC2", &each(&|x, y| vec![x + 0.5 * y, y - 0.5 * x])),
    });
    let position = attributes["POSITION"].as_u64().unwrap() as usize;
    doc.json["accessors"][position]["min"] = json!([-2.0, -1.0, 0.0]);
    doc.json["accessors"][position]["max"] = json!([0.0, 1.0, f64::from(0.2_f32)]);
    let mut half = |rows: std::ops::Range<usize>| {
        let quads = rows.flat_map(|j| (0..COLUMNS - 1).map(move |i| j * COLUMNS + i));
        let corners = quads.flat_map(|v| [0, 1, COLUMNS, COLUMNS, 1, COLUMNS + 1].map(|k| (v + k) as u16));
        let bytes: Vec<u8> = corners.flat_map(u16::to_le_bytes).collect();
        let count = bytes.len() / 2;
        doc.accessor(json!({ "componentType": 5123, "type": "SCALAR", "count": count }), &bytes)
    };
    let halves = [half(0..ROWS / 2), half(ROWS / 2..ROWS - 1)];
    let primitives = |attributes: &Value| {
        let one = |k: usize| json!({ "attributes": attributes, "indices": halves[k], "material": k });
        json!({ "primitives": [one(0), one(1)] })
    };
    let plain = primitives(&attributes);
    let weights = each(&|_, _| vec![0.3, 0.7, 0.0, 0.0]);
    attributes["WEIGHTS_0"] = json!(doc.floats("VEC4", &weights));
    let joints = [0, 1, 0, 0].repeat(COLUMNS * ROWS);
    let joints_type = json!({ "componentType": 5121, "type": "VEC4", "count": COLUMNS * ROWS });
    attributes["JOINTS_0"] = json!(doc.accessor(joints_type, &joints));
    doc.json["meshes"] = json!([plain, primitives(&attributes)]);
    let mut binds = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    binds.extend(glam::Mat4::from_translation(glam::Vec3::X).to_cols_array());
    let binds = doc.floats("MAT4", &binds);
    doc.json["skins"] = json!([{ "joints": [2, 3], "inverseBindMatrices": binds }]);
    doc.json["nodes"] = json!([
        { "mesh": 0, "scale": [-1.2, 1, 1], "rotation": [0.1, 0, 0, 0.995], "translation": [0.3, 0, 3] },
        { "mesh": 1, "skin": 0 },
        { "translation": [2, 0, 3], "children": [3] },
        { "translation": [-1, 0, 0], "rotation": [0, 0.5, 0, 0.866], "scale": [1, 1.5, 1] },
    ]);
    doc.json["scene"] = json!(0);
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    let image = doc.view(b"\x89PNG\r\n\x1a\nnot a picture");
    doc.json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    doc.json["materials"] = json!([{ "normalTexture": { "index": 0, "texCoord": 1 } }, {}]);
    doc
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Checks the tangents of `now` against the closed form; gives how many have moved.
fn follow(rest: &[Shown], now: &[Shown], only: impl Fn(usize) -> bool) -> usize {
    let mut moved = 0;
    for (rest, now) in rest.iter().zip(now) {
        let [before, after] = [rest, now].map(|shown| shown.tangents.as_ref().unwrap());
        let normals = now.normals.as_ref().unwrap();
        for (v, &p) in rest.positions.iter().enumerate().filter(|_| only(rest.primitive)) {
            // A row at the border sees half of the faces only; at the end of the wire the motion has a kink.
            let border = p.x.abs() < 0.1
                || (v % COLUMNS).min(v / COLUMNS) == 0
                || v % COLUMNS == COLUMNS - 1
                || v / COLUMNS == ROWS - 1;
            let exact = carried(p, before[v]);
            let off = degrees(after[v], exact);
            assert!(border || off < CLOSE, "{off} degrees at {p}, node {}", rest.node);
            assert!(after[v].dot(normals[v]).abs() < 1e-4, "perpendicular at {p}");
            moved += usize::from(degrees(before[v], exact) > 4.0 * CLOSE);
        }
    }
    moved
}

fn json_of(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// The numbers of the tangents of a primitive, as the `gltf` crate reads them.
fn tangents(glb: &[u8], mesh: usize, primitive: usize) -> Vec<[f32; 4]> {
    let doc = gltf::Gltf::from_slice(glb).unwrap();
    let mesh = doc.meshes().nth(mesh).unwrap();
    let primitive = mesh.primitives().nth(primitive).unwrap();
    primitive.reader(|_| doc.blob.as_deref()).read_tangents().unwrap().collect()
}

#[test]
fn an_animation_morphs_tangents_where_a_normal_map_is() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    let input = gutter().glb();
    place.write("in.glb", &input);
    place.run("apply rise.ron in.glb -o out.glb --fps 4 --bake frames").expect(0);
    let glb = place.read("out.glb");
    let json = json_of(&glb);
    for mesh in json["meshes"].as_array().unwrap() {
        let names = |primitive: usize| -> Vec<Vec<&str>> {
            let targets = mesh["primitives"][primitive]["targets"].as_array().unwrap();
            targets.iter().map(|t| t.as_object().unwrap().keys().map(String::as_str).collect()).collect()
        };
        assert!(
            names(0).len() == 4 && names(0).iter().all(|keys| keys == &["POSITION", "NORMAL", "TANGENT"])
        );
        assert!(names(1).iter().all(|keys| keys == &["POSITION", "NORMAL"]), "nothing looks at those");
        assert_eq!(
            mesh["primitives"][0]["attributes"]["TANGENT"],
            json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"]
        );
    }
    let rest = oracle::evaluate(&input, None, 0.0);
    let now = oracle::evaluate(&glb, Some("wirework"), 1.0);
    assert!(follow(&rest, &now, |primitive| primitive == 0) > 500);
    // What no wire reaches has deltas of exactly 0.
    let doc = gltf::Gltf::from_slice(&glb).unwrap();
    for (shown, mesh) in rest.iter().step_by(2).zip(doc.meshes()) {
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| doc.blob.as_deref());
        let (_, _, deltas) = reader.read_morph_targets().last().unwrap();
        let mut still = 0;
        for (d, &p) in deltas.unwrap().zip(&shown.positions) {
            let far = (-2..=2)
                .all(|k| risen(p + DVec3::Y * 0.05 * f64::from(k)) == p + DVec3::Y * 0.05 * f64::from(k));
            let far = far && p.distance(DVec3::new(p.x.clamp(0.0, 3.0), 0.0, 3.0)) > 0.9;
            assert!(!far || d == [0.0; 3], "{d:?} at {p}");
            still += usize::from(far);
        }
        assert!(still > 100);
    }
}

#[test]
fn a_still_has_new_tangents_whatever_the_material() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    let input = gutter().glb();
    place.write("in.glb", &input);
    place.run("apply rise.ron in.glb -o still.glb --at 1").expect(0);
    let still = place.read("still.glb");
    let [rest, now] = [&input, &still].map(|glb| oracle::evaluate(glb, None, 0.0));
    assert!(follow(&rest, &now, |_| true) > 1000);
    for mesh in 0..2 {
        let (old, new) = (tangents(&input, mesh, 0), tangents(&still, mesh, 1));
        assert!(old.iter().zip(&new).all(|(old, new)| old[3].to_bits() == new[3].to_bits()));
        let changed = old.iter().zip(&new).filter(|(old, new)| old != new).count();
        assert!((200..old.len() - 200).contains(&changed), "{changed}");
    }
}

#[test]
fn without_a_normal_map_no_tangents_are_morphed() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    let mut doc = gutter();
    doc.json["materials"] = json!([{ "occlusionTexture": { "index": 0 } }, {}]);
    place.write("in.glb", doc.glb());
    place.run("apply rise.ron in.glb -o out.glb --fps 4 --bake frames").expect(0);
    for mesh in json_of(&place.read("out.glb"))["meshes"].as_array().unwrap() {
        let targets = mesh["primitives"][0]["targets"].as_array().unwrap();
        assert!(
            targets.iter().all(|target| target.get("TANGENT").is_none() && target.get("NORMAL").is_some())
        );
    }
}

/// The gutter with a normal map on each half, on the second set of coordinates and on the first: either set runs over its own half
/// only, and both halves share all vertices.
fn two_sets() -> Doc {
    let mut doc = gutter();
    doc.json["materials"][1] = json!({ "normalTexture": { "index": 0 } });
    let attributes = doc.json["meshes"][0]["primitives"][0]["attributes"].clone();
    let [first, second] = ["TEXCOORD_0", "TEXCOORD_1"].map(|key| {
        let accessor = &doc.json["accessors"][attributes[key].as_u64().unwrap() as usize];
        let view = &doc.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        view["byteOffset"].as_u64().unwrap() as usize
    });
    for vertex in (ROWS / 2 + 1) * COLUMNS..ROWS * COLUMNS {
        let [plain, aslant] = [first, second].map(|start| start + 8 * vertex);
        let own: [u8; 8] = doc.bin[aslant..aslant + 8].try_into().unwrap();
        doc.bin.copy_within(plain..plain + 8, aslant);
        doc.bin[plain..plain + 8].copy_from_slice(&own);
    }
    doc
}

#[test]
fn each_primitive_of_a_shared_block_has_its_own_set_of_coordinates() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    let input = two_sets().glb();
    place.write("in.glb", &input);
    place.run("apply rise.ron in.glb -o out.glb --fps 4 --bake frames").expect(0);
    place.run("apply rise.ron in.glb -o still.glb --at 1").expect(0);
    let rest = oracle::evaluate(&input, None, 0.0);
    for now in [
        oracle::evaluate(&place.read("out.glb"), Some("wirework"), 1.0),
        oracle::evaluate(&place.read("still.glb"), None, 0.0),
    ] {
        for primitive in 0..2 {
            assert!(follow(&rest, &now, |shown| shown == primitive) > 500);
        }
    }
}

/// The gutter with its tangents as small integers of a component type, and in the extension that allows them.
fn quantised(kind: u32) -> Doc {
    let mut doc = gutter();
    let old = doc.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"].clone();
    let accessor = &doc.json["accessors"][old.as_u64().unwrap() as usize];
    let (count, view) =
        (accessor["count"].as_u64().unwrap() as usize, accessor["bufferView"].as_u64().unwrap());
    let start = doc.json["bufferViews"][view as usize]["byteOffset"].as_u64().unwrap() as usize;
    let (floats, _) = doc.bin[start..start + 16 * count].as_chunks::<4>();
    let floats = floats.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let bytes: Vec<u8> = match kind {
        5120 => floats.map(|x| ((x * 127.0).round() as i8).cast_unsigned()).collect(),
        _ => floats.flat_map(|x| ((x * 32_767.0).round() as i16).to_le_bytes()).collect(),
    };
    let json = json!({ "componentType": kind, "normalized": true, "type": "VEC4", "count": count });
    let new = doc.accessor(json, &bytes);
    for primitive in doc.json["meshes"]
        .as_array_mut()
        .unwrap()
        .iter_mut()
        .flat_map(|m| m["primitives"].as_array_mut().unwrap())
    {
        primitive["attributes"]["TANGENT"] = json!(new);
    }
    doc.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    doc
}

/// The tangents of the first primitive of a mesh, in its own space, with its last target at full weight if it has any: of a file, from
/// bare bytes.
fn local_tangents(place: &Place, file: &str, mesh: usize) -> Vec<(DVec3, f64)> {
    let document = Document::open(&place.path(file));
    let primitive = &document.json["meshes"][mesh]["primitives"][0];
    let base = document.elements(&primitive["attributes"]["TANGENT"]);
    let target = primitive.get("targets").and_then(|targets| targets.as_array()?.last()?.get("TANGENT"));
    let deltas = target.map_or_else(|| vec![vec![0.0; 3]; base.len()], |target| document.elements(target));
    let sum =
        |(base, delta): (&Vec<f64>, Vec<f64>)| (DVec3::from_slice(base) + DVec3::from_slice(&delta), base[3]);
    base.iter().zip(deltas).map(sum).collect()
}

#[test]
fn quantised_tangents_follow_as_floats_do() {
    let place = Place::new();
    place.write("rise.ron", RISE);
    place.write("float.glb", gutter().glb());
    // Half a step of each component, twice: at rest and in what follows from it.
    for (kind, close) in [(5120, 0.8), (5122, 0.01)] {
        place.write("in.glb", quantised(kind).glb());
        for (flags, out) in [("--fps 4", "moving.glb"), ("--at 1", "still.glb")] {
            place.run(&format!("apply rise.ron float.glb -o of_{out} {flags}")).expect(0);
            let err = place.run(&format!("apply rise.ron in.glb -o {out} {flags}")).expect(0).err();
            assert!(!err.contains("tangents"), "{err}");
            for mesh in 0..2 {
                let rest = local_tangents(&place, "in.glb", mesh);
                let [float, small] =
                    [format!("of_{out}"), out.to_owned()].map(|file| local_tangents(&place, &file, mesh));
                let mut turned = 0;
                for (((float, _), (small, side)), (rest, _)) in float.iter().zip(&small).zip(&rest) {
                    assert!(degrees(*float, *small) < close, "{float} became {small} in {out} of {kind}");
                    assert!(*side == -1.0, "the handedness stays");
                    turned += usize::from(degrees(*rest, *small) > 4.0 * CLOSE);
                }
                assert!(turned > 200, "{turned}");
            }
        }
    }
}
