//! Frames of a document that plays a clip meanwhile: a viewer that plays only our clip shows both.

use glam::DVec3;
use serde_json::Value;
use wirework_asset::{Clip, Gltf, Limits, Rest};
use wirework_bake::{BakeError, Baker, Settings};

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;
use common::{bin_of, frame, shared};
#[path = "../../asset/tests/make/mod.rs"]
#[expect(dead_code, reason = "each test file uses its own part")]
mod make;
#[path = "../../asset/tests/moving/mod.rs"]
mod moving;
#[path = "../../asset/tests/play/mod.rs"]
#[expect(dead_code, reason = "each test file uses its own part")]
mod play;
use moving::{noise, scene};
#[path = "../../asset/tests/oracle/mod.rs"]
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;

/// How far played positions may be from the frame, in parts of the diagonal.
const FRAME: f64 = 1e-5;

const KEYS: usize = 6;

/// All vertices of a moment moved, more and more, but for every fourth and for those of the blocks that `stay`.
fn bent(moment: &Rest, key: usize, stay: &[usize]) -> [Vec<[f32; 3]>; 2] {
    let mut positions = moment.positions.clone();
    let mut normals = vec![[0.0, 1.0, 0.0]; positions.len()];
    let size = positions.iter().flatten().fold(0.0_f32, |most, c| most.max(c.abs()));
    for (b, block) in moment.blocks.iter().enumerate() {
        let range = block.first..block.first + block.count;
        if let Some(own) = &block.normals {
            normals[range.clone()].copy_from_slice(own);
        }
        for v in range.filter(|v| v % 4 != 3 && key > 0 && !stay.contains(&b)) {
            for k in 0..3 {
                positions[v][k] += 0.05 * size * key as f32 * noise(9 * v + k);
                normals[v][k] += 0.1 * noise(5 * v + k);
            }
            let n = DVec3::from_array(normals[v].map(f64::from)).normalize_or_zero();
            normals[v] = n.to_array().map(|c| c as f32);
        }
    }
    [positions, normals]
}

/// A time, and positions and normals of all vertices.
type Frame = (f64, [Vec<[f32; 3]>; 2]);

fn baked(glb: &[u8], stay: &[usize]) -> (Gltf, Vec<Frame>, Rest) {
    let gltf = Gltf::from_slice(glb, "clip", &Limits::default()).unwrap();
    let rest = gltf.rest().unwrap();
    let mut player = gltf.player(&rest, Some(0)).unwrap();
    let mut baker = Baker::new(gltf.clone(), &rest, Settings { source: Some(0), ..Settings::default() });
    let (mut moment, mut frames) = (rest.clone(), Vec::new());
    for key in 0..KEYS {
        let seconds = f64::from((player.duration() * key as f64 / (KEYS - 1) as f64) as f32);
        player.rest_into(seconds, &mut moment).unwrap();
        let [positions, normals] = bent(&moment, key, stay);
        baker.push(seconds, &frame(&moment, &positions, Some(&normals))).unwrap();
        frames.push((seconds, [positions, normals]));
    }
    (baker.finish().unwrap().gltf, frames, rest)
}

fn check(name: &str, glb: &[u8]) {
    let (out, frames, rest) = baked(glb, &[]);
    let written = out.to_glb().unwrap();
    assert!(bin_of(&written).starts_with(bin_of(glb)), "{name}: the old chunk is no prefix");
    let new = out.clip_names().len() - 1;
    for (seconds, [positions, normals]) in frames {
        let shown = oracle::evaluate_clip(&written, |_| Some(new), seconds, true);
        let diagonal = oracle::diagonal(&shown);
        for (part, shown) in rest.parts.iter().zip(&shown) {
            let block = &rest.blocks[part.block];
            for v in 0..block.count {
                let want = DVec3::from_array(positions[block.first + v].map(f64::from));
                let off = (shown.positions[v] - want).length() / diagonal;
                assert!(off <= FRAME, "{name} at {seconds}: vertex {v} is off by {off:e}");
                if let Some(played) = &shown.normals {
                    let want = DVec3::from_array(normals[block.first + v].map(f64::from));
                    let off = (played[v] - want).length();
                    assert!(off < 1e-4 || want.length() < 0.5, "{name} at {seconds}: normal {v} {off:e}");
                }
            }
        }
    }
}

#[test]
fn our_clip_alone_plays_clip_and_effect() {
    check("scene", &scene().glb());
    for name in ["rigged/cesium_man.glb", "rigged/fox.glb", "rigged/robot.glb"] {
        let Some(path) = shared(name) else { return };
        check(name, &std::fs::read(path).unwrap());
    }
}

#[test]
fn nodes_that_do_not_move_play_the_clip_as_it_was() {
    let glb = scene().glb();
    let before = scene().open().unwrap();
    let (out, ..) = baked(&glb, &[0]);
    let clips = out.json()["animations"].as_array().unwrap();
    let tracks = |clip: &Value| {
        let list = clip["channels"].as_array().unwrap().iter();
        let list = list
            .map(|channel| (channel["target"]["node"].as_u64().unwrap(), channel["target"]["path"].clone()));
        list.collect::<Vec<(u64, Value)>>()
    };
    let weights = Value::from("weights");
    // The track of node 5 is ours now, and node 3 has got one; that of node 0, whose mesh has grown, has grown with it.
    let mut expected = tracks(&before.json()["animations"][0]);
    assert_eq!(expected.pop(), Some((5, weights.clone())));
    expected.extend([(3, weights.clone()), (5, weights)]);
    assert_eq!(tracks(&clips[1]), expected);
    let written = out.to_glb().unwrap();
    for seconds in [0.0, 0.5, 1.7] {
        let shown = |clip| oracle::evaluate_clip(&written, |_| Some(clip), seconds, true).remove(0).positions;
        assert_eq!(shown(0), shown(1), "at {seconds}");
    }
}

#[test]
fn a_moment_of_another_document_is_refused() {
    let gltf = scene().open().unwrap();
    let rest = gltf.rest().unwrap();
    let mut other = rest.clone();
    other.blocks.swap(0, 1);
    let settings = Settings { clip: Some(Clip::New("x".into())), ..Settings::default() };
    let mut baker = Baker::new(gltf, &rest, settings);
    let refused = baker.push(0.0, &frame(&other, &rest.positions, None));
    assert!(matches!(refused, Err(BakeError::Frame { .. })));
    other.positions.pop();
    let refused = baker.push(0.0, &frame(&other, &rest.positions, None));
    assert!(matches!(refused, Err(BakeError::VertexCount { .. })));
}
