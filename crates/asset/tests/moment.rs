//! A moment of a clip as a rest: what is deformed then goes back through nodes, skins and morphs as they are then.

use glam::DVec3;
use wirework_asset::{Gltf, LocalDeltas, Rest};

#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
use make::Doc;
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use play::{pose, strip};
mod moving;
use moving::{noise, scene};

fn direction(seed: usize) -> [f32; 3] {
    let raw =
        DVec3::new(1.5 + f64::from(noise(seed)), f64::from(noise(seed + 1)), f64::from(noise(seed + 2)));
    raw.normalize().to_array().map(|c| c as f32)
}

fn open(doc: &Doc) -> (Gltf, Rest) {
    let gltf = doc.open().unwrap();
    let rest = gltf.rest().unwrap();
    (gltf, rest)
}

/// What differs between two rests, to the bit.
fn same(a: &Rest, b: &Rest) {
    let bits = |list: &[[f32; 3]]| list.as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<u32>>();
    assert_eq!(bits(&a.positions), bits(&b.positions));
    for (a, b) in a.blocks.iter().zip(&b.blocks) {
        assert_eq!(a.normals.as_deref().map(bits), b.normals.as_deref().map(bits));
        assert_eq!(a.tangents.as_deref().map(bits), b.tangents.as_deref().map(bits));
        assert_eq!(a.weights, b.weights);
    }
}

#[test]
fn a_moment_is_what_the_player_shows() {
    let (gltf, rest) = open(&scene());
    let mut player = gltf.player(&rest, Some(0)).unwrap();
    let mut moment = rest.clone();
    for seconds in [0.0, 0.6, 2.0, 1.1] {
        player.rest_into(seconds, &mut moment).unwrap();
        let [positions, normals] = pose(&mut player, seconds, None);
        assert_eq!(moment.positions, positions);
        for block in &moment.blocks {
            assert_eq!(block.normals.as_deref(), Some(&normals[block.first..][..block.count]));
        }
        assert_eq!((&moment.triangles, moment.parts.len()), (&rest.triangles, rest.parts.len()));
    }
    let [skinned, plain, mirrored] = &moment.blocks[..] else { panic!("three blocks") };
    let near = |a: &[f32], b: [f32; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(&skinned.weights, [0.55, 0.275]) && near(&plain.weights, [0.25, 0.0]));
    assert!(near(&mirrored.weights, [0.55, 0.45]));
}

#[test]
fn what_is_deformed_at_a_moment_is_played_at_that_moment() {
    let (gltf, rest) = open(&scene());
    let mut player = gltf.player(&rest, Some(0)).unwrap();
    let mut moment = rest.clone();
    for seconds in [0.0, 0.3, 0.9, 1.5, 2.0, 7.0] {
        player.rest_into(seconds, &mut moment).unwrap();
        let count = moment.positions.len();
        let moved = |v: usize| v % 4 != 3;
        let (mut positions, mut normals, mut tangents) =
            (moment.positions.clone(), vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
        for block in &moment.blocks {
            normals[block.first..][..block.count].copy_from_slice(block.normals.as_ref().unwrap());
            tangents[block.first..][..block.count].copy_from_slice(block.tangents.as_ref().unwrap());
        }
        for v in (0..count).filter(|&v| moved(v)) {
            positions[v] = std::array::from_fn(|k| positions[v][k] + noise(90 * v + k));
            normals[v] = direction(70 * v);
            tangents[v] = direction(50 * v + 3);
        }
        let local = |block| moment.to_local(block, &positions, Some(&normals), Some(&tangents));
        let deltas: Vec<LocalDeltas> = (0..moment.blocks.len()).map(local).collect();
        for (block, deltas) in moment.blocks.iter().zip(&deltas) {
            assert_eq!(deltas.stuck, 0);
            for v in (0..block.count).filter(|v| !moved(block.first + v)) {
                assert_eq!(deltas.positions[v], [0.0; 3]);
                assert_eq!(deltas.normals.as_ref().unwrap()[v], [0.0; 3]);
                assert_eq!(deltas.tangents.as_ref().unwrap()[v], [0.0; 3]);
            }
        }
        let [played, turned] = pose(&mut player, seconds, Some(&deltas));
        // The diagonal is about 8.
        for v in 0..count {
            for (found, wanted) in [(played[v], positions[v]), (turned[v], normals[v])] {
                let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 5e-6, "{seconds}: {v}: {found:?} for {wanted:?}");
            }
        }
    }
}

#[test]
fn without_a_clip_the_bits_of_the_rest_stay() {
    let (gltf, rest) = open(&scene());
    let mut again = rest.clone();
    gltf.player(&rest, Some(0)).unwrap().rest_into(1.3, &mut again).unwrap();
    assert_ne!(again.positions, rest.positions);
    gltf.player(&rest, None).unwrap().rest_into(1.3, &mut again).unwrap();
    same(&again, &rest);
    // And with them the ways: nothing moves, and what moves goes the same way.
    let mut moved = rest.positions.clone();
    for p in &mut moved {
        p[1] += 0.25;
    }
    for block in 0..rest.blocks.len() {
        let by = |rest: &Rest| rest.to_local(block, &moved, None, None);
        assert_eq!(by(&again), by(&rest));
    }
}

#[test]
fn the_rest_of_another_document_is_refused() {
    let (gltf, rest) = open(&scene());
    let (_, mut other) = open(&strip());
    assert!(gltf.player(&rest, Some(0)).unwrap().rest_into(0.0, &mut other).is_err());
    let mut short = rest.clone();
    short.positions.pop();
    assert!(gltf.player(&rest, Some(0)).unwrap().rest_into(0.0, &mut short).is_err());
    let mut unskinned = rest.clone();
    unskinned.blocks.swap(0, 1);
    assert!(gltf.player(&rest, Some(0)).unwrap().rest_into(0.0, &mut unskinned).is_err());
}
