//! Tracks of the transforms of nodes: what of them is worth a channel.

use std::collections::BTreeSet;

use glam::DQuat;
use serde_json::json;

use crate::document::Gltf;
use crate::error::{AssetError, Place};
use crate::graph::Pose;
use crate::limits::Budget;
use crate::parts::NodeParts;

/// The transform of one node in the space of its parent at all keys. A property without values is not moved.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointTrack {
    /// The node.
    pub node: usize,
    /// Metres: one value a key, or none at all.
    pub translations: Vec<[f32; 3]>,
    /// Quaternions x, y, z, w of any length but 0 and of either sign: one value a key, or none at all. They are written
    /// normalised, and so that players take the shorter way between two keys.
    pub rotations: Vec<[f32; 4]>,
    /// One value a key, or none at all.
    pub scales: Vec<[f32; 3]>,
}

/// One property of one node, as it is written.
pub(crate) struct Curve {
    pub(crate) node: usize,
    pub(crate) path: &'static str,
    pub(crate) values: Values,
    /// Whether the one value counts at all times.
    pub(crate) constant: bool,
}

pub(crate) enum Values {
    Vectors(Vec<[f32; 3]>),
    Rotations(Vec<[f32; 4]>),
}

impl Gltf {
    /// What of `tracks` needs a channel in a clip of so many `keys` that `moved` these properties so far.
    pub(crate) fn joint_curves(
        &self,
        keys: usize,
        tracks: &[JointTrack],
        moved: &BTreeSet<(usize, &str)>,
    ) -> Result<Vec<Curve>, AssetError> {
        if tracks.is_empty() {
            return Ok(Vec::new());
        }
        // What is wrong with nodes was told when the rest was read.
        let graph = self.graph(&mut Budget::new(&self.limits), &mut Vec::new())?;
        let mut out = Vec::new();
        for track in tracks {
            let node = track.node;
            let Some(own) = graph.nodes.get(node) else {
                let found = format!("a track of node {node}");
                let place = Place::Pointer("/nodes".to_owned());
                return Err(AssetError::new(place, found, crate::json::one_of("node", graph.nodes.len())));
            };
            let own = NodeParts::of(&own.pose).ok_or_else(|| sheared(node))?;
            let translations = vectors(node, "translation", keys, &track.translations)?;
            let rotations = rotations(node, keys, &track.rotations)?;
            let scales = vectors(node, "scale", keys, &track.scales)?;
            let same = |all: &[[f32; 3]], own: [f64; 3]| *all == [own.map(|c| c as f32)];
            let turn = own.rotation.map(|c| c as f32);
            let turned = rotations != [turn] && rotations != [turn.map(|c| -c)];
            let curves = [
                ("translation", !same(&translations, own.translation), Values::Vectors(translations)),
                ("rotation", turned, Values::Rotations(rotations)),
                ("scale", !same(&scales, own.scale), Values::Vectors(scales)),
            ];
            for (path, differs, values) in curves {
                let count = values.len();
                if count > 0 && (differs || moved.contains(&(node, path))) {
                    out.push(Curve { node, path, values, constant: count < keys });
                }
            }
        }
        Ok(out)
    }

    /// Gives a node with a matrix the translation, rotation and scale that make it.
    pub(crate) fn unfold_matrix(&mut self, node: usize) -> Result<(), AssetError> {
        let json = self.root().need("nodes")?.item(node)?;
        let Some(matrix) = json.get("matrix")? else { return Ok(()) };
        let matrix = crate::graph::affine(matrix.floats::<16>()?, matrix, &mut Vec::new())?;
        let parts = NodeParts::of(&Pose::Matrix(matrix)).ok_or_else(|| sheared(node))?;
        let entry = self.entry_mut("nodes", node)?;
        entry.shift_remove("matrix");
        entry.insert("translation".to_owned(), json!(parts.translation));
        entry.insert("rotation".to_owned(), json!(parts.rotation.map(|c| c.clamp(-1.0, 1.0))));
        entry.insert("scale".to_owned(), json!(parts.scale));
        Ok(())
    }
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::Vectors(values) => values.len(),
            Self::Rotations(values) => values.len(),
        }
    }
}

fn sheared(node: usize) -> AssetError {
    let place = Place::Pointer(format!("/nodes/{node}/matrix"));
    let expected = "translation, rotation and scale, or a matrix of them: no other can be animated";
    AssetError::new(place, "a matrix that is sheared, or has no inverse", expected)
}

/// One value where all are the same.
fn folded<const N: usize>(mut values: Vec<[f32; N]>) -> Vec<[f32; N]> {
    if values.iter().all(|value| *value == values[0]) {
        values.truncate(1);
    }
    values
}

fn check(node: usize, what: &str, keys: usize, values: usize) -> Result<(), AssetError> {
    if values == 0 || values == keys {
        return Ok(());
    }
    let found = format!("{values} values for the {what} of node {node}");
    Err(AssetError::file(found, format!("{keys}, one a key, or none")))
}

fn vectors(node: usize, what: &str, keys: usize, values: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, AssetError> {
    check(node, what, keys, values.len())?;
    match values.iter().position(|value| value.iter().any(|c| !c.is_finite())) {
        Some(key) => {
            Err(AssetError::file(format!("the {what} {:?} of node {node}", values[key]), "finite numbers"))
        }
        None => Ok(folded(values.to_vec())),
    }
}

fn rotations(node: usize, keys: usize, values: &[[f32; 4]]) -> Result<Vec<[f32; 4]>, AssetError> {
    check(node, "rotation", keys, values.len())?;
    let mut out: Vec<[f32; 4]> = Vec::with_capacity(values.len());
    let mut before: Option<DQuat> = None;
    for value in values {
        let raw = DQuat::from_array(value.map(f64::from));
        let length = raw.length();
        if !(length > 0.0 && length.is_finite()) {
            let found = format!("the rotation {value:?} of node {node}");
            return Err(AssetError::file(found, "finite quaternions of a length above 0"));
        }
        let mut turn = raw / length;
        if before.is_some_and(|before| before.dot(turn) < 0.0) {
            turn = -turn;
        }
        before = Some(turn);
        out.push(turn.to_array().map(|c| c as f32));
    }
    Ok(folded(out))
}
