//! Vertices of different rests that are sent to equal places.

use serde_json::json;
use wirework_asset::{Gltf, NewMesh, Rest};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::strip;
#[expect(dead_code, reason = "each test file uses its own part")]
mod moving;
use moving::noise;

const PAIRS: usize = 500;

/// A mesh without a transform, of pairs of points on both sides of a seam.
fn pairs() -> (Gltf, Rest) {
    let place = |v: usize, k: usize| 3.0 * noise(6 * (v / 2) + k) + 0.1 * noise(6 * v + 3 + k);
    let positions: Vec<[f32; 3]> = (0..2 * PAIRS).map(|v| std::array::from_fn(|k| place(v, k))).collect();
    let mesh = NewMesh { name: "pairs", positions: &positions, normals: None, uvs: None, triangles: &[] };
    let gltf = Gltf::from_meshes("pairs", &[mesh]).unwrap();
    let rest = gltf.rest().unwrap();
    (gltf, rest)
}

/// Both points of each pair in the middle between them, but for the last pair, which stays.
fn welded(rest: &Rest) -> Vec<[f32; 3]> {
    let mut out = rest.positions.clone();
    for pair in out.as_chunks_mut::<2>().0.iter_mut().take(PAIRS - 1) {
        let [a, b] = *pair;
        *pair = [std::array::from_fn(|k| f32::midpoint(a[k], b[k])); 2];
    }
    out
}

#[test]
fn a_still_has_the_bits_that_it_is_given() {
    let (mut gltf, rest) = pairs();
    let wanted = welded(&rest);
    gltf.set_still(&rest, &wanted, None, None).unwrap();
    assert_eq!(gltf.rest().unwrap().positions, wanted);
    // Much nearer to 0 than any displacement of the vertices could take them.
    let (mut gltf, rest) = pairs();
    let tiny = vec![[1e-20, -3e-33, 1e-9]; 2 * PAIRS];
    gltf.set_still(&rest, &tiny, None, None).unwrap();
    assert_eq!(gltf.rest().unwrap().positions, tiny);
}

#[test]
fn a_target_leads_nearly_all_of_them_to_one_place() {
    let (gltf, rest) = pairs();
    let wanted = welded(&rest);
    let deltas = rest.to_local(0, &wanted, None, None);
    let sum =
        |v: usize| -> [f32; 3] { std::array::from_fn(|k| rest.positions[v][k] + deltas.positions[v][k]) };
    let reached = (0..2 * PAIRS).filter(|&v| sum(v) == wanted[v]).count();
    let met = (0..PAIRS - 1).filter(|k| sum(2 * k) == sum(2 * k + 1)).count();
    // Where they are on different sides of 0, or much farther from it than the middle, there is no float that leads there.
    assert!(reached * 100 > 98 * 2 * PAIRS && met * 100 > 97 * PAIRS, "{reached} reached, {met} met");
    assert_eq!(deltas.positions[2 * PAIRS - 2..], [[0.0; 3]; 2]);
    let mut player = gltf.player(&rest, None).unwrap();
    let [positions, _] = play::pose(&mut player, 0.0, Some(&[deltas]));
    for (found, wanted) in positions.iter().zip(&wanted) {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 5e-7), "{found:?} {wanted:?}");
    }
}

#[test]
fn joints_at_their_places_are_no_transform_and_morphs_are_one() {
    let mut doc = strip();
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    let wanted = vec![[1e-20, 0.1, 0.7]; 6];
    gltf.set_still(&rest, &wanted, None, None).unwrap();
    assert_eq!(gltf.rest().unwrap().positions, wanted);
    // Base, target and displacement add up to the place, though not to its bits.
    let lift = doc.floats("VEC3", &[0.0, 0.0, 0.3].repeat(6));
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": lift }]);
    doc.json["meshes"][0]["weights"] = json!([0.5]);
    let mut gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    gltf.set_still(&rest, &wanted, None, None).unwrap();
    for found in gltf.rest().unwrap().positions {
        assert!(found.iter().zip(wanted[0]).all(|(a, b)| (a - b).abs() < 5e-7), "{found:?}");
    }
}
