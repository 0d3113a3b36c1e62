//! A figure made here: a trunk with an arm on three joints, a clip that moves them all, and a node that is a goal.

use std::f64::consts::TAU;

use glam::{DMat4, DQuat, DVec3};
use serde_json::{Value, json};

use crate::make::Doc;
use crate::oracle;

/// Where the joints of the arm are at rest.
pub(super) const ARM: [DVec3; 3] =
    [DVec3::new(0.2, 1.4, 0.0), DVec3::new(0.5, 1.4, -0.05), DVec3::new(0.8, 1.4, 0.0)];
/// Where the node "target" is at rest, and where the clip has it in the end.
pub(super) const TARGET: [DVec3; 2] = [DVec3::new(0.6, 1.2, 0.3), DVec3::new(0.5, 1.65, 0.25)];
/// Seconds of the clip "swing".
pub(super) const SECONDS: f64 = 2.0;
/// Vertices round the arm, and round the trunk.
const SIDES: usize = 12;
/// Rings of the arm, the middle of each 0.025 m farther along x, from the shoulder on.
const RINGS: usize = 29;
const TRUNK: usize = 11;

/// A vertex at rest, and its weights on hips, upper arm, forearm and hand.
type Vertex = (DVec3, [f64; 4]);

/// A node, what of it moves, and how in time.
type Track<'a> = (usize, &'a str, &'a dyn Fn(f64) -> Vec<f64>);

fn vertices() -> Vec<Vertex> {
    let round = |axis: [DVec3; 2], radius: f64| {
        (0..SIDES).map(move |j| {
            let angle = TAU * j as f64 / SIDES as f64;
            (axis[0] * angle.cos() + axis[1] * angle.sin()) * radius
        })
    };
    let mut out = Vec::new();
    for i in 0..TRUNK {
        let center = DVec3::Y * (0.6 + 0.8 * i as f64 / (TRUNK - 1) as f64);
        out.extend(round([DVec3::Z, DVec3::X], 0.15).map(|p| (center + p, [1.0, 0.0, 0.0, 0.0])));
    }
    let smooth = |x: f64, from: f64, to: f64| {
        let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    for i in 0..RINGS {
        let x = 0.2 + 0.025 * i as f64;
        let bone = if x < 0.5 { [ARM[0], ARM[1]] } else { [ARM[1], ARM[2]] };
        let center = bone[0] + (bone[1] - bone[0]) * ((x - bone[0].x) / 0.3);
        let (arm, fore, hand) = (smooth(x, 0.18, 0.32), smooth(x, 0.42, 0.58), smooth(x, 0.7, 0.776));
        let weights = [1.0 - arm, arm * (1.0 - fore), arm * fore * (1.0 - hand), hand];
        // Across its bone, so that what is round stays so about its middle.
        let across = (bone[1] - bone[0]).cross(DVec3::Y).normalize();
        out.extend(round([DVec3::Y, across], 0.05).map(|p| (center + p, weights)));
    }
    out
}

/// Vertices of the trunk: none of their weight is on the arm.
pub(super) fn trunk() -> Vec<usize> {
    (0..TRUNK * SIDES).collect()
}

/// Those of the ring of the arm at this place along x at rest.
pub(super) fn ring(x: f64) -> Vec<usize> {
    let ring = ((x - 0.2) / 0.025).round() as usize;
    (0..SIDES).map(|j| (TRUNK + ring) * SIDES + j).collect()
}

/// Vertices of which some weight is on the arm and some is not.
pub(super) fn shoulder() -> Vec<usize> {
    let between = |weights: [f64; 4]| weights[0] > 1e-6 && weights[0] < 1.0 - 1e-6;
    let found = vertices().into_iter().enumerate().filter(|(_, (_, weights))| between(*weights));
    found.map(|(v, _)| v).collect()
}

/// The figure. Its hips and all that hangs on them move in the clip "swing", if `moves`.
pub(crate) fn figure(moves: bool) -> Doc {
    let mut doc = Doc::new();
    let all = vertices();
    let flat = |value: &dyn Fn(&Vertex) -> Vec<f64>| -> Vec<f32> {
        all.iter().flat_map(value).map(|x| x as f32).collect()
    };
    let positions = doc.floats("VEC3", &flat(&|(p, _)| p.to_array().to_vec()));
    for (key, choose) in [("min", DVec3::min as fn(DVec3, DVec3) -> DVec3), ("max", DVec3::max)] {
        let bound = all.iter().map(|(p, _)| *p).reduce(choose).unwrap();
        doc.json["accessors"][positions][key] = json!(bound.as_vec3().to_array());
    }
    let attributes = json!({
        "POSITION": positions,
        "WEIGHTS_0": doc.floats("VEC4", &flat(&|(_, weights)| weights.to_vec())),
        "JOINTS_0": doc.accessor(
            json!({ "componentType": 5121, "type": "VEC4", "count": all.len() }),
            &[0, 1, 2, 3].repeat(all.len()),
        ),
    });
    let mut faces = Vec::new();
    for [first, rings] in [[0, TRUNK], [TRUNK, RINGS]] {
        for (i, j) in (first..first + rings - 1).flat_map(|i| (0..SIDES).map(move |j| (i, j))) {
            let [a, b] = [i * SIDES + j, i * SIDES + (j + 1) % SIDES];
            faces.extend([a, b, b + SIDES, a, b + SIDES, a + SIDES]);
        }
    }
    let bytes: Vec<u8> = faces.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect();
    let indices =
        doc.accessor(json!({ "componentType": 5125, "type": "SCALAR", "count": faces.len() }), &bytes);
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": indices }));
    doc.node(json!({ "name": "figure", "mesh": mesh, "skin": 0 }));
    doc.node(json!({ "name": "hips", "children": [2] }));
    for (i, name) in ["upper", "fore", "hand"].into_iter().enumerate() {
        let from = if i == 0 { DVec3::ZERO } else { ARM[i - 1] };
        let mut node = json!({ "name": name, "translation": (ARM[i] - from).to_array() });
        if i < 2 {
            node["children"] = json!([i + 3]);
        }
        doc.node(node);
    }
    doc.node(json!({ "name": "target", "translation": TARGET[0].to_array() }));
    let binds =
        [DVec3::ZERO, ARM[0], ARM[1], ARM[2]].map(|p| DMat4::from_translation(-p).as_mat4().to_cols_array());
    let binds = doc.floats("MAT4", &binds.concat());
    doc.json["skins"] = json!([{ "joints": [1, 2, 3, 4], "inverseBindMatrices": binds }]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 5] }]);
    if moves {
        doc.json["animations"] = json!([swing(&mut doc)]);
    }
    doc
}

/// Hips that drift and turn, an arm that swings about two axes, a target that goes straight.
fn swing(doc: &mut Doc) -> Value {
    const KEYS: u32 = 17;
    let times: Vec<f64> = (0..KEYS).map(|k| SECONDS * f64::from(k) / f64::from(KEYS - 1)).collect();
    let wave = |t: f64| (TAU * t / SECONDS).sin();
    let turn = |axis: DVec3, angle: f64| DQuat::from_axis_angle(axis, angle).to_array().to_vec();
    let tracks: [Track<'_>; 5] = [
        (1, "translation", &|t| vec![0.05 * wave(t), 0.02 * t, 0.0]),
        (1, "rotation", &|t| turn(DVec3::Y, 0.1 * wave(t))),
        (2, "rotation", &|t| turn(DVec3::Z, 0.5 * t - 0.2)),
        (3, "rotation", &|t| turn(DVec3::Y, -0.4 * t)),
        (5, "translation", &|t| TARGET[0].lerp(TARGET[1], t / SECONDS).to_array().to_vec()),
    ];
    let input = doc.floats("SCALAR", &times.iter().map(|t| *t as f32).collect::<Vec<_>>());
    doc.json["accessors"][input]["min"] = json!([0.0]);
    doc.json["accessors"][input]["max"] = json!([SECONDS]);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for (node, path, at) in tracks {
        let values: Vec<f32> = times.iter().flat_map(|t| at(*t)).map(|x| x as f32).collect();
        let output = doc.floats(if path == "rotation" { "VEC4" } else { "VEC3" }, &values);
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
        samplers.push(json!({ "input": input, "output": output }));
    }
    json!({ "name": "swing", "channels": channels, "samplers": samplers })
}

/// Where the vertices of a document are as a clip of it plays, or at rest.
pub(super) fn played(glb: &[u8], clip: Option<&str>, seconds: f64) -> Vec<DVec3> {
    let choose = |document: &gltf::Document| {
        clip.map(|name| document.animations().position(|a| a.name() == Some(name)).expect("the clip"))
    };
    oracle::evaluate_clip(glb, choose, seconds, true).swap_remove(0).positions
}

/// Where the target is at a moment of the clip.
pub(super) fn target(seconds: f64) -> DVec3 {
    TARGET[0].lerp(TARGET[1], (seconds / SECONDS).clamp(0.0, 1.0))
}

/// The middle of some points.
pub(super) fn middle(points: &[DVec3], of: &[usize]) -> DVec3 {
    of.iter().map(|&v| points[v]).sum::<DVec3>() / of.len() as f64
}
