//! Morph targets of an input beside ours: whatever they have or lack, engines that play mixed targets by rules of their own
//! show what the standard says.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::document::{Document, list};
use crate::make::Doc;
use crate::place::Place;

/// The weights that play: those of the input's three targets by default, and the effect at its end.
const SECONDS: f64 = 1.0;

/// A quad in two primitives, which a wire along x lifts, and three targets that have little in common.
fn mixed() -> Doc {
    let mut doc = Doc::new();
    let mut primitives = Vec::new();
    for count in [3, 4] {
        let corners = [[-0.5, 0.0, -0.1], [0.5, 0.0, -0.1], [0.0, 0.0, 0.3], [0.25, 0.0, 0.2]];
        let positions = doc.floats("VEC3", corners[..count].as_flattened());
        let normals = doc.floats("VEC3", &[0.0, 1.0, 0.0].repeat(count));
        let colors = doc.floats("VEC4", &[0.25, 0.5, 0.75, 1.0].repeat(count));
        let uvs = doc.floats("VEC2", &[0.5, 0.25].repeat(count));
        let mut delta = |kind: &str, value: &[f32]| doc.floats(kind, &value.repeat(count));
        let targets = json!([
            { "POSITION": delta("VEC3", &[0.0, 0.0, 0.5]) },
            { "NORMAL": delta("VEC3", &[0.5, 0.0, 0.0]) },
            { "POSITION": delta("VEC3", &[0.25, 0.0, 0.0]), "COLOR_0": delta("VEC4", &[0.5, 0.0, 0.0, 0.0]),
              "TEXCOORD_0": delta("VEC2", &[0.0, 0.5]) },
        ]);
        let attributes =
            json!({ "POSITION": positions, "NORMAL": normals, "COLOR_0": colors, "TEXCOORD_0": uvs });
        primitives.push(json!({ "attributes": attributes, "targets": targets }));
    }
    let mesh = doc.mesh(&Value::Null);
    doc.json["meshes"][mesh] = json!({ "primitives": primitives, "weights": [0.5, 0.25, 0.5] });
    doc.node(json!({ "mesh": mesh }));
    doc.json["scenes"] = json!([{ "nodes": [0] }]);
    doc
}

/// What stands for a displacement that a target has not, where another has one.
#[derive(Clone, Copy)]
enum Missing {
    /// Nothing, as the standard says.
    Zero,
    /// The attribute itself, as three.js has it.
    Base,
}

/// An attribute of a primitive with its targets, all at these weights.
fn morphed(
    document: &Document,
    primitive: &Value,
    key: &str,
    weights: &[f64],
    missing: Missing,
) -> Vec<Vec<f64>> {
    let base = document.elements(&primitive["attributes"][key]);
    let mut out = base.clone();
    let targets = list(primitive, "targets");
    let any = targets.iter().any(|target| target.get(key).is_some());
    assert_eq!(targets.len(), weights.len());
    for (target, weight) in targets.iter().zip(weights) {
        let deltas = match (target.get(key), missing) {
            (Some(reference), _) => document.elements(reference),
            (None, Missing::Base) if any => base.clone(),
            (None, _) => continue,
        };
        for (value, delta) in out.iter_mut().flatten().zip(deltas.iter().flatten()) {
            *value += weight * delta;
        }
    }
    out
}

/// The weights of the first clip's last key.
fn last_weights(document: &Document) -> Vec<f64> {
    let sampler = &document.json["animations"][0]["samplers"][0];
    let [times, weights] = ["input", "output"].map(|key| document.elements(&sampler[key]).concat());
    assert!((times.last().unwrap() - SECONDS).abs() < 1e-6);
    weights[weights.len() / times.len() * (times.len() - 1)..].to_vec()
}

#[test]
fn mixed_targets_play_alike_by_every_rule() {
    let place = Place::new();
    place.write("in.glb", mixed().glb());
    place.run("apply lift.ron in.glb -o out.glb --fps 2").expect(0);
    let (old, new) = (Document::open(&place.path("in.glb")), Document::open(&place.path("out.glb")));
    let weights = last_weights(&new);
    let pairs = list(&old.json["meshes"][0], "primitives").iter();
    for (before, after) in pairs.zip(list(&new.json["meshes"][0], "primitives")) {
        let targets = list(after, "targets");
        assert!(targets.len() > 3, "{after}");
        let keys =
            |target: &Value| -> BTreeSet<String> { target.as_object().unwrap().keys().cloned().collect() };
        assert!(targets.iter().all(|target| keys(target) == keys(&targets[0])), "{targets:?}");
        for (old, new) in list(before, "targets").iter().zip(targets) {
            for (key, accessor) in old.as_object().unwrap() {
                assert_eq!(&new[key], accessor, "what a target had");
            }
        }
        for target in targets {
            for reference in target.as_object().unwrap().values() {
                let accessor = &new.json["accessors"][reference.as_u64().unwrap() as usize];
                assert!(accessor.get("bufferView").or(accessor.get("sparse")).is_some(), "{accessor}");
            }
            let position = &new.json["accessors"][target["POSITION"].as_u64().unwrap() as usize];
            let old = targets.iter().take(3).any(|old| old["POSITION"] == target["POSITION"]);
            assert!(old || position["min"].is_array() && position["max"].is_array(), "{position}");
        }
        for key in ["POSITION", "NORMAL", "COLOR_0", "TEXCOORD_0"] {
            let [zero, base] =
                [Missing::Zero, Missing::Base].map(|missing| morphed(&new, after, key, &weights, missing));
            assert_eq!(zero, base, "{key}");
            // What the input's own targets do is what they did: ours add to places and normals alone.
            if matches!(key, "COLOR_0" | "TEXCOORD_0") {
                assert_eq!(zero, morphed(&old, before, key, &weights[..3], Missing::Zero), "{key}");
            }
        }
        let lifted = morphed(&new, after, "POSITION", &weights, Missing::Base);
        let rest = morphed(&old, before, "POSITION", &weights[..3], Missing::Zero);
        assert!(lifted.iter().zip(&rest).any(|(p, q)| p[1] > q[1] + 0.01), "{lifted:?} from {rest:?}");
        assert!(
            lifted.iter().zip(&rest).all(|(p, q)| (p[0], p[2]) == (q[0], q[2])),
            "{lifted:?} from {rest:?}"
        );
    }
}

#[test]
fn targets_that_are_alike_get_nothing() {
    let place = Place::new();
    let mut doc = mixed();
    for primitive in doc.json["meshes"][0]["primitives"].as_array_mut().unwrap() {
        let zero = primitive["targets"][1]["NORMAL"].clone();
        let place = primitive["targets"][0]["POSITION"].clone();
        primitive["targets"] = json!([{ "POSITION": place, "NORMAL": zero }]);
    }
    doc.json["meshes"][0]["weights"] = json!([0.5]);
    place.write("in.glb", doc.glb());
    place.run("apply lift.ron in.glb -o out.glb --fps 2").expect(0);
    let new = Document::open(&place.path("out.glb"));
    for k in 0..2 {
        let at = |json: &Value| json["meshes"][0]["primitives"][k]["targets"][0].clone();
        assert_eq!(at(&new.json), at(&doc.json));
    }
}
