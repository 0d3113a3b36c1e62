//! Models made here: sheets in a document, and an arm that bends.

use std::f64::consts::TAU;

use glam::{DMat4, DVec3};
use serde_json::{Value, json};

use crate::make::Doc;

/// Triangles of points given in the world, shown by a node of this transform, with a normal and texture coordinates for each
/// point. Shared vertices stay shared, or each corner is a vertex of its own.
pub(super) fn document(points: &[DVec3], faces: &[[usize; 3]], node: DMat4, split: bool) -> Doc {
    let (corners, mut faces): (Vec<usize>, Vec<[usize; 3]>) = if split {
        let corners = faces.iter().flatten().copied().collect();
        (corners, (0..faces.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    } else {
        ((0..points.len()).collect(), faces.to_vec())
    };
    if node.determinant() < 0.0 {
        // A mirror turns faces over.
        for face in &mut faces {
            face.swap(1, 2);
        }
    }
    let back = node.inverse();
    let local = corners.iter().flat_map(|&v| back.transform_point3(points[v]).as_vec3().to_array());
    let local: Vec<f32> = local.collect();
    let mut doc = Doc::new();
    let positions = doc.floats("VEC3", &local);
    bounds(&mut doc, positions, &local);
    let uvs: Vec<f32> = corners.iter().enumerate().flat_map(|(i, _)| [i as f32 * 1e-3, 0.5]).collect();
    let uvs = doc.floats("VEC2", &uvs);
    let indices = indices(&mut doc, &faces);
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": indices }));
    doc.node(json!({ "name": "sheet", "mesh": mesh, "matrix": node.to_cols_array() }));
    doc.json["scenes"] = json!([{ "nodes": [0] }]);
    doc
}

/// `min` and `max` of an accessor of positions.
fn bounds(doc: &mut Doc, accessor: usize, positions: &[f32]) {
    for (key, choose) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
        let bound = [0, 1, 2].map(|a| positions.iter().skip(a).step_by(3).copied().reduce(choose).unwrap());
        doc.json["accessors"][accessor][key] = json!(bound);
    }
}

fn indices(doc: &mut Doc, faces: &[[usize; 3]]) -> usize {
    let bytes: Vec<u8> = faces.iter().flatten().flat_map(|v| (*v as u32).to_le_bytes()).collect();
    let accessor = json!({ "componentType": 5125, "type": "SCALAR", "count": 3 * faces.len() });
    doc.accessor(accessor, &bytes)
}

/// The radius of [`arm`], and its length along x, the elbow in its middle.
pub(crate) const ARM: (f64, f64) = (0.1, 1.0);
/// Seconds of its clip, and the angle by which it bends, degrees.
pub(super) const BENDING: (f64, f64) = (2.0, 100.0);

/// A tube along x of so many sides and rings of quadrangles on two joints, with a seam of texture coordinates, and a clip "bend" that
/// bends it up at the elbow, round z, and back.
pub(crate) fn arm(sides: usize, rings: usize) -> Doc {
    let (radius, length) = ARM;
    let mut doc = Doc::new();
    let vertex = |i: usize, j: usize| {
        let angle = TAU * (j % sides) as f64 / sides as f64;
        let x = (i as f64 / rings as f64 - 0.5) * length;
        (x, DVec3::new(0.0, angle.cos(), angle.sin()))
    };
    let each = |value: &dyn Fn(f64, DVec3, usize) -> Vec<f64>| -> Vec<f32> {
        let all = (0..=rings).flat_map(|i| (0..=sides).map(move |j| (i, j)));
        all.flat_map(|(i, j)| {
            let (x, out) = vertex(i, j);
            value(x, out, j)
        })
        .map(|v| v as f32)
        .collect()
    };
    // From one joint to the other over 0.24 m about the elbow, smoothly.
    let bent = |x: f64| {
        let x = ((x + 0.12) / 0.24).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    let count = (sides + 1) * (rings + 1);
    let placed = each(&|x, out, _| (out * radius + DVec3::X * x).to_array().to_vec());
    let positions = doc.floats("VEC3", &placed);
    bounds(&mut doc, positions, &placed);
    let attributes = json!({
        "POSITION": positions,
        "NORMAL": doc.floats("VEC3", &each(&|_, out, _| out.to_array().to_vec())),
        "TEXCOORD_0": doc.floats("VEC2", &each(&|x, _, j| vec![x, j as f64 / sides as f64])),
        "WEIGHTS_0": doc.floats("VEC4", &each(&|x, _, _| vec![1.0 - bent(x), bent(x), 0.0, 0.0])),
        "JOINTS_0": doc.accessor(
            json!({ "componentType": 5121, "type": "VEC4", "count": count }), &[0, 1, 0, 0].repeat(count)),
    });
    let at = |i: usize, j: usize| i * (sides + 1) + j;
    let cell = |i: usize, j: usize| {
        // Y towards Z is right-handed about X: outside is left of the way round.
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, c, b], [a, d, c]]
    };
    let faces: Vec<[usize; 3]> = (0..rings).flat_map(|i| (0..sides).flat_map(move |j| cell(i, j))).collect();
    let faces: Vec<[usize; 3]> = faces.into_iter().map(outwards(sides)).collect();
    let indices = indices(&mut doc, &faces);
    let mesh = doc.mesh(&json!({ "attributes": attributes, "indices": indices }));
    doc.node(json!({ "name": "arm", "mesh": mesh, "skin": 0 }));
    doc.node(json!({ "name": "upper", "translation": [-length / 2.0, 0, 0], "children": [2] }));
    doc.node(json!({ "name": "lower", "translation": [length / 2.0, 0, 0] }));
    let bind = |x: f64| DMat4::from_translation(DVec3::X * -x).as_mat4().to_cols_array();
    let binds = doc.floats("MAT4", &[bind(-length / 2.0), bind(0.0)].concat());
    doc.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    doc.json["animations"] = json!([bending(&mut doc)]);
    doc
}

/// Sees to it that faces look outwards, whichever way they were listed.
fn outwards(sides: usize) -> impl Fn([usize; 3]) -> [usize; 3] {
    move |face| {
        let at = |v: usize| {
            let angle = TAU * (v % (sides + 1)) as f64 / sides as f64;
            DVec3::new((v / (sides + 1)) as f64, angle.cos(), angle.sin())
        };
        let [a, b, c] = face.map(at);
        let out = ((a + b + c) / 3.0).with_x(0.0);
        if (b - a).cross(c - a).dot(out) > 0.0 { face } else { [face[0], face[2], face[1]] }
    }
}

fn bending(doc: &mut Doc) -> Value {
    let keys = 33;
    let (seconds, most) = BENDING;
    let times: Vec<f64> = (0..keys).map(|k| seconds * f64::from(k) / f64::from(keys - 1)).collect();
    let turns = times.iter().flat_map(|t| {
        let half = most.to_radians() * (1.0 - (TAU * t / seconds).cos()) / 4.0;
        [0.0, 0.0, half.sin() as f32, half.cos() as f32]
    });
    let turns: Vec<f32> = turns.collect();
    let times: Vec<f32> = times.iter().map(|t| *t as f32).collect();
    let input = doc.floats("SCALAR", &times);
    doc.json["accessors"][input]["min"] = json!([0.0]);
    doc.json["accessors"][input]["max"] = json!([seconds]);
    let output = doc.floats("VEC4", &turns);
    json!({
        "name": "bend",
        "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
        "samplers": [{ "input": input, "output": output }],
    })
}
