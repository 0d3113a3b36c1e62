//! What the tests bake: real files and a small scene, and a motion.

use std::path::{Path, PathBuf};

use glam::DVec3;
use wirework_asset::{Gltf, Limits, NewMesh, Rest};
use wirework_bake::{Baked, Baker, Frame, Settings};

pub(crate) const ASSETS: [&str; 10] = [
    "rigged/cesium_man.glb",
    "rigged/robot.glb",
    "rigged/fox.glb",
    "tube/skinned_cylinder.gltf",
    "morph/morph_stress_test.gltf",
    "multi/milk_truck.gltf",
    "multi/texture_transform_test.gltf",
    "layout/box_interleaved.glb",
    "layout/simple_sparse_accessor.gltf",
    "layout/box_vertex_colors.glb",
];

/// A file of the shared assets, where present.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets").join(name);
    if !path.exists() {
        eprintln!("skipped: the shared assets are not present ({name})");
        return None;
    }
    Some(path)
}

/// A bump that runs through the scene: vertices within reach move, the others keep their bits.
pub(crate) fn bump(rest: &Rest, phase: f64) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let points: Vec<DVec3> = rest.positions.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let min = points.iter().fold(DVec3::INFINITY, |a, p| a.min(*p));
    let max = points.iter().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p));
    let (middle, size) = (min + 0.7 * (max - min), (max - min).max_element());
    let mut positions = rest.positions.clone();
    let mut normals = vec![[0.0, 1.0, 0.0]; positions.len()];
    for block in &rest.blocks {
        if let Some(given) = &block.normals {
            normals[block.first..block.first + block.count].copy_from_slice(given);
        }
    }
    for (i, p) in points.iter().enumerate() {
        let x = (*p - middle).length() / (0.75 * size);
        if x < 1.0 && phase > 0.0 {
            let lift = DVec3::new(0.1, 0.2, -0.05) * size * phase * (1.0 - x * x).powi(2);
            positions[i] = (*p + lift).to_array().map(|c| c as f32);
            let n = DVec3::from_array(normals[i].map(f64::from)) + lift / size;
            normals[i] = n.normalize().to_array().map(|c| c as f32);
        }
    }
    (positions, normals)
}

/// All vertices at a moment.
pub(crate) fn frame<'a>(
    moment: &'a Rest,
    positions: &'a [[f32; 3]],
    normals: Option<&'a [[f32; 3]]>,
) -> Frame<'a> {
    Frame { moment, positions, normals, tangents: None }
}

pub(crate) const PHASES: [f64; 5] = [0.0, 0.5, 1.0, 0.5, 0.0];

pub(crate) fn baked(gltf: Gltf, rest: &Rest) -> Baked {
    let mut baker = Baker::new(gltf, rest, Settings::default());
    for (k, phase) in PHASES.iter().enumerate() {
        let (positions, normals) = bump(rest, *phase);
        baker.push(k as f64 / 24.0, &frame(rest, &positions, Some(&normals))).unwrap();
    }
    baker.finish().unwrap()
}

/// Two nodes, one turned and mirrored, that show one mesh: the deltas differ, so the mesh is copied.
pub(crate) fn instances() -> Gltf {
    let mesh = NewMesh {
        name: "sheet",
        positions: &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        normals: Some(&[[0.0, 0.0, 1.0]; 4]),
        uvs: None,
        triangles: &[[0, 1, 2], [0, 2, 3]],
    };
    let glb = Gltf::from_meshes("sheet", &[mesh]).unwrap().to_glb().unwrap();
    let mut json = json_of(&glb);
    json["nodes"] = serde_json::json!([
        { "mesh": 0 },
        { "mesh": 0, "translation": [0.5, 0, 0], "rotation": [0, 0.6, 0, 0.8], "scale": [-1, 2, 1] },
        { "mesh": 0 },
    ]);
    json["scenes"][0]["nodes"] = serde_json::json!([0, 1, 2]);
    Gltf::from_slice(&with_json(&glb, &json), "instances", &Limits::default()).unwrap()
}

/// The JSON of a GLB.
pub(crate) fn json_of(glb: &[u8]) -> serde_json::Value {
    serde_json::from_slice(&glb[20..20 + json_length(glb)]).unwrap()
}

pub(crate) fn json_length(glb: &[u8]) -> usize {
    u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize
}

/// The BIN chunk of a GLB.
pub(crate) fn bin_of(glb: &[u8]) -> &[u8] {
    glb.get(20 + json_length(glb) + 8..).unwrap_or(&[])
}

/// The GLB with other JSON.
pub(crate) fn with_json(glb: &[u8], json: &serde_json::Value) -> Vec<u8> {
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().div_ceil(4) * 4, b' ');
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&text);
    out.extend(&glb[20 + json_length(glb)..]);
    let total = out.len() as u32;
    out[8..12].copy_from_slice(&total.to_le_bytes());
    out
}
