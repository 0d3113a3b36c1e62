//! Played back by another evaluation, the frames are what was pushed.

use std::path::{Path, PathBuf};

use glam::DVec3;
use wirework_asset::{Clip, Format, Gltf, Limits, Rest, write_files};
use wirework_bake::{BakeError, Baker, Settings};

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;
use common::{ASSETS, PHASES, baked, bump, frame, instances, shared};

#[path = "../../asset/tests/oracle/mod.rs"]
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;

/// How far played positions may be from the frame, in parts of the diagonal.
const FRAME: f64 = 1e-5;
/// And where the frame is the rest.
const REST: f64 = 1e-6;

/// Compares a played document with the frames.
fn check_played(name: &str, rest: &Rest, glb: &[u8]) {
    for (k, phase) in PHASES.iter().enumerate() {
        let (positions, normals) = bump(rest, *phase);
        let shown = oracle::evaluate(glb, Some("wirework"), k as f32 / 24.0);
        let diagonal = oracle::diagonal(&shown);
        assert_eq!(shown.len(), rest.parts.len(), "{name}");
        for (part, shown) in rest.parts.iter().zip(&shown) {
            assert_eq!((part.node, part.primitive), (shown.node, shown.primitive), "{name}");
            let block = &rest.blocks[part.block];
            assert_eq!(block.count, shown.positions.len(), "{name}");
            for v in 0..block.count {
                let want = DVec3::from_array(positions[block.first + v].map(f64::from));
                let bound = if *phase == 0.0 { REST } else { FRAME };
                let off = (shown.positions[v] - want).length() / diagonal;
                assert!(off <= bound, "{name}: frame {k}, node {}, vertex {v} is off by {off:e}", part.node);
                if let (Some(played), Some(_)) = (&shown.normals, &block.normals) {
                    let want = DVec3::from_array(normals[block.first + v].map(f64::from));
                    if want.length() > 0.5 {
                        assert!(
                            (played[v] - want).length() < 1e-4,
                            "{name}: normal {v} {} {want}",
                            played[v]
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn real_files_play_the_frames() {
    let keep = std::env::var_os("WIREWORK_KEEP").map(PathBuf::from);
    for name in ASSETS {
        let Some(path) = shared(name) else { return };
        let gltf = Gltf::read(&path, &Limits::default()).unwrap();
        let rest = gltf.rest().unwrap();
        let out = baked(gltf, &rest);
        assert!(out.targets > 0 && out.nodes > 0, "{name}");
        let glb = out.gltf.to_glb().unwrap();
        if let Some(folder) = &keep {
            for (format, extension) in [(Format::Glb, "glb"), (Format::Gltf, "gltf")] {
                let stem = Path::new(name).file_stem().unwrap();
                let file = folder.join(stem).join(stem).with_extension(extension);
                std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                write_files(&out.gltf.files(&file, format).unwrap()).unwrap();
            }
        }
        check_played(name, &rest, &glb);
    }
}

#[test]
fn instances_that_move_differently_get_copies_and_equal_ones_share() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let out = baked(gltf, &rest);
    check_played("instances", &rest, &out.gltf.to_glb().unwrap());
    let json = out.gltf.json();
    assert_eq!(json["meshes"].as_array().unwrap().len(), 2);
    let mesh = |node: usize| json["nodes"][node]["mesh"].as_u64().unwrap();
    assert_eq!((mesh(0), mesh(1), mesh(2)), (0, 1, 0));
}

#[test]
fn equal_frames_share_a_target_and_rest_frames_have_none() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let out = baked(gltf, &rest);
    for mesh in 0..2 {
        let names = out.gltf.json()["meshes"][mesh]["extras"]["targetNames"].as_array().unwrap();
        assert_eq!(names, &["wirework_f0001", "wirework_f0002"]);
        assert_eq!(out.gltf.json()["meshes"][mesh]["weights"], serde_json::json!([0, 0]));
    }
    let gltf = instances();
    let before = gltf.to_glb().unwrap();
    let mut baker = Baker::new(gltf, &rest, Settings::default());
    let (positions, normals) = bump(&rest, 0.0);
    baker.push(0.0, &frame(&rest, &positions, Some(&normals))).unwrap();
    baker.push(1.0, &frame(&rest, &positions, Some(&normals))).unwrap();
    let out = baker.finish().unwrap();
    assert_eq!((out.targets, out.nodes), (0, 0));
    assert_eq!(out.gltf.to_glb().unwrap(), before, "nothing moves, nothing changes");
}

#[test]
fn a_budget_of_targets_says_what_fits() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let settings = Settings { max_targets: 2, ..Settings::default() };
    let mut baker = Baker::new(gltf, &rest, settings);
    let mut result = Ok(());
    for k in 0..4 {
        let (positions, _) = bump(&rest, f64::from(k) / 4.0);
        result = result.and_then(|()| baker.push(f64::from(k), &frame(&rest, &positions, None)));
    }
    match result.unwrap_err() {
        BakeError::TooManyTargets { fit, frame, .. } => assert_eq!((fit, frame), (2, 3)),
        other => panic!("{other}"),
    }
}

#[test]
fn a_mesh_with_too_many_targets_of_its_own_is_baked_all_the_same() {
    let baked = |gltf: Gltf, max_targets| {
        let rest = gltf.rest().unwrap();
        let mut baker = Baker::new(gltf, &rest, Settings { max_targets, ..Settings::default() });
        for k in 0..3 {
            let (positions, _) = bump(&rest, 1.0 + f64::from(k));
            baker.push(f64::from(k), &frame(&rest, &positions, None))?;
        }
        baker.finish()
    };
    let first = baked(instances(), 240).unwrap().gltf;
    let known = first.warnings().len();
    assert!(baked(first.clone(), 4).is_err(), "with one place left its own are counted");
    let second = baked(first, 3).unwrap();
    let warned = second.gltf.warnings().iter().skip(known).filter(|w| w.code == "own-targets").count();
    assert!(second.targets > 0 && warned > 0, "{:?}", second.gltf.warnings());
}

#[test]
fn bad_frames_are_refused() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let mut baker = Baker::new(gltf, &rest, Settings::default());
    let n = rest.positions.len();
    assert!(matches!(
        baker.push(0.0, &frame(&rest, &vec![[0.0; 3]; n - 1], None)),
        Err(BakeError::VertexCount { .. })
    ));
    assert!(matches!(
        baker.push(0.0, &frame(&rest, &vec![[f32::NAN; 3]; n], None)),
        Err(BakeError::Frame { .. })
    ));
    assert!(matches!(baker.push(-1.0, &frame(&rest, &rest.positions, None)), Err(BakeError::Frame { .. })));
    baker.push(1.0, &frame(&rest, &rest.positions, None)).unwrap();
    assert!(matches!(baker.push(1.0, &frame(&rest, &rest.positions, None)), Err(BakeError::Frame { .. })));
}

#[test]
fn a_second_effect_goes_behind_the_first() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let first = baked(gltf, &rest).gltf.to_glb().unwrap();
    let gltf = Gltf::from_slice(&first, "first", &Limits::default()).unwrap();
    let again = gltf.rest().unwrap();
    assert_eq!(again.positions, rest.positions);
    let out = baked(gltf, &again);
    let glb = out.gltf.to_glb().unwrap();
    assert_eq!(out.gltf.clip_names(), [Some("wirework"), Some("wirework_2")]);
    check_played("first clip", &rest, &glb);
    let names = &out.gltf.json()["meshes"][0]["extras"]["targetNames"];
    assert_eq!(names[2], "wirework_f0001_2");
    let settings = Settings { clip: Some(Clip::Into(0)), ..Settings::default() };
    let gltf = Gltf::from_slice(&first, "first", &Limits::default()).unwrap();
    let mut baker = Baker::new(gltf, &again, settings);
    let (positions, normals) = bump(&again, 1.0);
    baker.push(0.0, &frame(&again, &positions, Some(&normals))).unwrap();
    assert!(matches!(baker.finish(), Err(BakeError::Asset(_))), "a clip holds one weight track a node");
}
