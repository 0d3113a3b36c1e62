//! Edges cut elsewhere than in the middle: what is new lies as far between what was there.

use serde_json::json;
use wirework_asset::{Gltf, Refined, Rest};
use wirework_surface::{Cut, SubdivideLimits, Subdivision, cut_edges};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::{skinned, triangle};

const ANY: SubdivideLimits = SubdivideLimits { vertices: 1 << 20, triangles: 1 << 21 };

/// Cuts edges of a document whose vertices are all at places of their own.
fn cut(gltf: &mut Gltf, cuts: &[Cut]) -> (Rest, Subdivision, Refined) {
    let rest = gltf.rest().unwrap();
    let places: Vec<u32> = (0..rest.positions.len() as u32).collect();
    let finer = cut_edges(&rest.triangles, &places, places.len(), cuts, ANY).unwrap();
    let found = gltf.refine(&rest, &finer).unwrap();
    assert_eq!(found.rest.triangles.len(), finer.triangles.len());
    (rest, finer, found)
}

fn at(ends: [u32; 2], shares: &[f64]) -> Cut {
    Cut { ends, shares: shares.to_vec() }
}

/// The bytes of an attribute of the finer mesh.
fn bytes(gltf: &Gltf, name: &str) -> Vec<u8> {
    let json = gltf.json();
    let index = json["meshes"][1]["primitives"][0]["attributes"][name].as_u64().unwrap() as usize;
    let view = &json["bufferViews"][json["accessors"][index]["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let bin = gltf::Glb::from_slice(&gltf.to_glb().unwrap()).unwrap().bin.unwrap().into_owned();
    bin[start..][..view["byteLength"].as_u64().unwrap() as usize].to_vec()
}

fn floats(gltf: &Gltf, name: &str) -> Vec<f32> {
    bytes(gltf, name).as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)).collect()
}

fn mix<const N: usize>(a: [f32; N], b: [f32; N], share: f64) -> [f32; N] {
    std::array::from_fn(|k| (f64::from(a[k]) * (1.0 - share) + f64::from(b[k]) * share) as f32)
}

#[test]
fn attributes_and_targets_lie_as_far_between() {
    let mut doc = triangle(json!({}));
    let uvs = doc.floats("VEC2", &[0.0, 0.0, 0.5, 1.0, 1.0, 0.0]);
    let tangents = doc.floats("VEC4", &[1.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0, 1.0, 0.0, 0.0, -1.0]);
    let colors = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.5, 0.25, 0.0, 1.0, 0.75]);
    let own = doc.accessor(
        json!({ "componentType": 5120, "type": "VEC4", "count": 3 }),
        &[1, 2, 0xff, 0, 4, 4, 0xfc, 0, 100, 0, 1, 0],
    );
    let deltas = doc.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    for (name, index) in [("TEXCOORD_0", uvs), ("TANGENT", tangents), ("COLOR_0", colors), ("_OWN", own)] {
        primitive["attributes"][name] = json!(index);
    }
    primitive["targets"] = json!([{ "POSITION": deltas }]);
    doc.json["meshes"][0]["weights"] = json!([0.5]);
    let mut gltf = doc.open().unwrap();
    let (rest, finer, found) = cut(&mut gltf, &[at([1, 2], &[0.25, 0.9])]);
    assert_eq!((finer.parents.len(), finer.triangles.len()), (2, 3));
    let read = |name: &str| floats(&gltf, name);
    assert_eq!(read("POSITION")[9..12], [0.75, 0.25, 0.0]);
    assert_eq!(
        read("TEXCOORD_0")[6..],
        [mix([0.5, 1.0], [1.0, 0.0], 0.25), mix([0.5, 1.0], [1.0, 0.0], 0.9)].concat()
    );
    assert_eq!(read("COLOR_0")[9..12], [0.75, 0.625, 0.375]);
    let length = (0.75_f64.powi(2) + 0.25_f64.powi(2)).sqrt();
    let [x, y] = [0.25 / length, 0.75 / length].map(|c| c as f32);
    assert_eq!(read("TANGENT")[12..16], [x, y, 0.0, -1.0]);
    assert_eq!(read("NORMAL")[9..], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    // 28, 3, −2.75 and 90.4, 0.4, 0.5, which goes up.
    assert_eq!(bytes(&gltf, "_OWN")[12..], [28, 3, 0xfd, 0, 90, 0, 1, 0]);
    // The second vertex is lifted by half, and so is what lies near it.
    assert_eq!(found.rest.positions[..3], rest.positions);
    assert_eq!(found.rest.positions[3], [0.75, 0.25, 0.375]);
    assert_eq!(found.rest.positions[4], mix([1.0, 0.0, 0.5], [0.0, 1.0, 0.0], 0.9));
}

#[test]
fn weights_are_shared_and_the_rest_lies_on_the_edge() {
    let mut doc = skinned([0.5, 0.5, 0.0, 0.0]);
    let turn = 0.3_f64;
    doc.json["nodes"][2]["rotation"] = json!([0.0, 0.0, turn.sin(), turn.cos()]);
    let mut gltf = doc.open().unwrap();
    let (rest, finer, found) = cut(&mut gltf, &[at([2, 1], &[0.3]), at([0, 1], &[0.1, 0.6])]);
    for (k, (&[a, b], &share)) in finer.parents.iter().zip(&finer.shares).enumerate() {
        let wanted = mix(rest.positions[a as usize], rest.positions[b as usize], share);
        let place = found.vertex_of.iter().position(|&v| v as usize == 3 + k).unwrap();
        for (there, wanted) in found.rest.positions[place].iter().zip(wanted) {
            assert!((there - wanted).abs() < 2e-5, "{there} for {wanted}");
        }
    }
    let weights = floats(&gltf, "WEIGHTS_0");
    let joints = bytes(&gltf, "JOINTS_0");
    // From the second joint to the first, and from both to the first.
    let wanted = [[(1, 0.7), (0, 0.3)], [(0, 0.55), (1, 0.45)], [(0, 0.8), (1, 0.2)]];
    for (k, wanted) in wanted.into_iter().enumerate() {
        let start = 4 * (3 + k);
        let sum: f64 = weights[start..start + 4].iter().map(|&w| f64::from(w)).sum();
        assert!((sum - 1.0).abs() < 2e-7, "{sum}");
        for (i, (joint, weight)) in wanted.into_iter().enumerate() {
            assert_eq!(joints[start + i], joint);
            assert!((weights[start + i] - weight).abs() < 1e-6, "{k}: {}", weights[start + i]);
        }
    }
}

#[test]
fn shares_of_something_else_are_refused() {
    let doc = triangle(json!({}));
    let rest = doc.open().unwrap().rest().unwrap();
    let finer = cut_edges(&rest.triangles, &[0, 1, 2], 3, &[at([0, 1], &[0.2, 0.4])], ANY).unwrap();
    for shares in [vec![0.2], vec![0.2, 1.5], vec![f64::NAN, 0.5]] {
        let odd = Subdivision { shares, ..finer.clone() };
        assert!(doc.open().unwrap().refine(&rest, &odd).is_err());
    }
    assert!(doc.open().unwrap().refine(&rest, &finer).is_ok());
}
