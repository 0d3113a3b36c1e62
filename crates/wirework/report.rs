//! What an application of an effect did, and what it took.

use serde::Serialize;
use wirework_bake::{Bake, NodeBake, Played};

use crate::{CacheFacts, Engines, FinerMesh, VatFacts};

/// Counts and times. As JSON it is the command's report.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Report {
    /// Points of the object: positions of an OBJ file or a preset's object, vertices of a glTF scene.
    pub points: usize,
    /// Wires, over all effects.
    pub wires: usize,
    /// Moments that were worked out: 1 for a still.
    pub frames: usize,
    /// Threads that worked.
    pub threads: usize,
    /// Laying creases and binding points, and looking where and when the surface is compressed, milliseconds.
    pub bind_ms: f64,
    /// The wire deformation of all frames, nothing else, milliseconds.
    pub deform_ms: f64,
    /// The normals of all frames, milliseconds.
    pub normals_ms: f64,
    /// Baking, encoding and writing the files, milliseconds.
    pub write_ms: f64,
    /// All of it, reading the input included, milliseconds.
    pub total_ms: f64,
    /// The most memory the process has held so far, bytes; 0 where the system does not tell (other than Linux).
    pub peak_bytes: u64,
    /// The clip that the animation was added as; none for a still, an OBJ, or where a clip of the input takes the effect.
    pub clip: Option<NewClip>,
    /// The skeleton that plays the effect, where joints do.
    pub skeleton: Option<Skeleton>,
    /// How well morph targets play the effect, where they are key poses or a basis.
    pub bake: Option<BakeReport>,
    /// The meshes that were subdivided, as effects with `refine: Auto` ask for.
    pub refined: Vec<FinerMesh>,
    /// The point caches.
    pub caches: Vec<CacheFacts>,
    /// The vertex animation texture, where there is one.
    pub vat: Option<VatFacts>,
    /// What engines make of the document that is written; none of an OBJ.
    pub engines: Option<Engines>,
    /// What was repaired, passed over, or is hardly meant.
    pub warnings: Vec<String>,
    /// What is worth knowing and no fault of anything: engines that do not take what was added.
    pub notes: Vec<String>,
}

/// A clip that was added to a document.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct NewClip {
    /// Its number, from 0: so many clips stand before it.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// The clips before it that could take the effect: those that move no weights of their own.
    pub could_join: Vec<usize>,
    /// The clip whose tracks it has besides, since the effect starts from what that shows.
    pub plays: Option<usize>,
}

/// How well morph targets play an effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BakeReport {
    /// How far a vertex is at most from where the effect has it, metres, at any time that was looked at: at and between all frames.
    pub error: f64,
    /// The same as a part of the model's diagonal.
    pub error_of_diagonal: f64,
    /// By which angle a normal is off at most, degrees. Where the surface folds over itself, or collapses, that may be large.
    pub normal_degrees: f64,
    /// The mean angle of those that turn, degrees.
    pub normal_mean_degrees: f64,
    /// How many moments were sampled: the frames, and more where the motion is not straight between them.
    pub samples: usize,
    /// What each node that moves plays.
    pub nodes: Vec<NodeReport>,
}

/// What a node plays.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct NodeReport {
    /// The node.
    pub node: usize,
    /// `keys`: poses, linear in between; or `basis`: shapes, whose weighted sums all poses are.
    pub bake: &'static str,
    /// How many morph targets its mesh got.
    pub targets: usize,
    /// How many keys their weights have.
    pub keys: usize,
}

impl From<Played> for BakeReport {
    fn from(played: Played) -> Self {
        let node = |node: &NodeBake| NodeReport {
            node: node.node,
            bake: if node.bake == Bake::Basis { "basis" } else { "keys" },
            targets: node.targets,
            keys: node.keys,
        };
        Self {
            error: played.error,
            error_of_diagonal: played.of_diagonal,
            normal_degrees: played.normals.to_degrees(),
            normal_mean_degrees: played.normals_mean.to_degrees(),
            samples: played.samples,
            nodes: played.nodes.iter().map(node).collect(),
        }
    }
}

/// A skeleton that plays an effect, and how well.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Skeleton {
    /// Joints that get tracks: the limb's, those made for it, and those below that go elsewhere than the one above them; of wires one
    /// a control point.
    pub joints: usize,
    /// How many of them were made for it.
    pub made: usize,
    /// On how many joints a vertex hangs at most, of wires; 0 for a limb.
    pub influences: usize,
    /// How many times as far as the control points of each wire its joints go: 1 but for amplitudes below 0 or above 1, and for wires
    /// that add up (`crossing: 1`). Empty for a limb.
    pub gains: Vec<f64>,
    /// How far a vertex is at most from where the effect itself has it, metres, as looked at in all frames and twice between all keys. What hangs on a limb in part is
    /// turned by its part of the turn by the effect, and goes its part of the way by a skeleton: no number of joints makes up for that.
    /// Wires that only translate leave what float32 rounds, and between keys of eased poses about 5e-6 of the diagonal.
    pub residual: f64,
    /// The same as a part of the model's diagonal.
    pub residual_of_diagonal: f64,
    /// When that is, seconds.
    pub seconds: f64,
    /// How far a normal is at most from where the effect has it, degrees, at any of these: joints turn normals by their own turns, so
    /// that those that only move leave them as they are, and an effect has them follow the surface.
    pub normals_degrees: f64,
}

/// A skeleton that is farther off than this part of the diagonal is hardly what was meant.
const FAR_OFF: f64 = 0.05;

impl Skeleton {
    /// That it is far from the effect, where it is.
    pub(crate) fn warning(&self) -> Option<String> {
        let Self { residual_of_diagonal, influences, .. } = self;
        (*residual_of_diagonal > FAR_OFF).then(|| {
            format!(
                "the skeleton is off by {:.0} % of the diagonal{} [skeleton-off]",
                100.0 * residual_of_diagonal,
                // Of wires.
                if *influences > 0 { "" } else {
                    ": does all that follows the limb hang on its joints? `SkinWeights` moves what does, `--joints` lets bones bend"
                }
            )
        })
    }
}

impl Report {
    /// The report as one JSON object with a line a member.
    pub fn to_json(&self) -> String {
        // Numbers and text only: this cannot fail.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}

/// The most memory this process has held so far, bytes; 0 where the system does not tell.
pub(crate) fn peak_bytes() -> u64 {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return 0 };
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kib.unwrap_or(0) * 1024
}
