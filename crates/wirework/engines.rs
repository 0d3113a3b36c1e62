//! What engines make of a document: what each takes, what it refuses, and what morph targets cost it in memory.
//!
//! A document that the standard allows need not load everywhere. What is said here is of three.js r187, Bevy up to 0.19 (by way of the
//! `gltf` crate 1.4.1), Godot 4, Blender 5.0, Babylon.js 9, and of phones, by what their sources say, their makers have been told, or
//! runs of them have shown. Nothing is said of what is not known: that no finding names an engine promises nothing.
//!
//! Memory, summed over the primitives of all meshes, each of `V` vertices and `T` targets, a mesh once however many nodes show it:
//!
//! | engine | bytes | why |
//! |---|---|---|
//! | three.js, Babylon.js | `16 V T`, with normals `32 V T`; on JavaScript's heap `28 V T`, with normals `56 V T` | a target is a layer of an RGBA32F texture |
//! | Bevy | `48 V T`; up to 0.18, and without storage buffers, `36 V T` | 9 floats, and 3 for their alignment, whatever a target has |
//! | Godot | `12 V` for each position, normal and tangent of each target | what is sparse becomes dense |
//! | Blender | `12 V T` | shape keys are positions |
//!
//! What phones take is not known.

mod findings;
mod sheet;

use std::collections::BTreeSet;
use std::fmt;

use serde::Serialize;
use serde_json::Value;
use wirework_asset::Gltf;

use findings::findings;
use sheet::{Primitive, Sheet};

const THREE: &str = "three.js";
const BEVY: &str = "Bevy";
const GODOT: &str = "Godot";
const BLENDER: &str = "Blender";
const BABYLON: &str = "Babylon.js";
const PHONES: &str = "phones";

/// What engines make of a document.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Engines {
    /// The most morph targets that a mesh has.
    pub targets: usize,
    /// What morph targets take of memory in each engine: one entry an engine, in a fixed order.
    pub memory: Vec<EngineMemory>,
    /// What an engine does not load, or does not show as it is meant, and why; at most one for an engine and a reason.
    pub findings: Vec<Finding>,
}

/// What the morph targets of a document take of an engine's memory.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct EngineMemory {
    /// The engine, as in [`Finding::engine`].
    pub engine: &'static str,
    /// Bytes of textures or arrays; none where it is not known.
    pub bytes: Option<u64>,
    /// Bytes of JavaScript's heap besides; none where there is none, or it is not known.
    pub heap_bytes: Option<u64>,
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// It takes memory that does nothing.
    Costs,
    /// Something is not shown as it is meant, everywhere or on some devices.
    Degrades,
    /// The document, or the mesh, does not load.
    Refuses,
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum About {
    /// How many morph targets a mesh has.
    Targets,
    /// How many vertices have targets.
    Vertices,
    /// Primitives of a mesh have unequal numbers of targets.
    UnequalTargets,
    /// The weights of a mesh with targets are not written.
    Weights,
    /// Names of targets.
    Names,
    /// Attributes of targets that are not used.
    Attributes,
    /// Primitives that share their vertices.
    SharedVertices,
    /// Vertices on more than four joints.
    Influences,
    /// How many joints a skin has.
    Joints,
    /// Meshes with targets and without normals.
    Normals,
    /// Kinds of primitives.
    Primitives,
    /// Names of nodes that clips move.
    Nodes,
    /// How many targets are at work at a time.
    Influencers,
    /// A required extension.
    Extension,
    /// Accessors without data.
    Accessors,
    /// Clips that move something other than nodes.
    Clips,
    /// Scenes.
    Scenes,
}

/// What an engine does not make of a document, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Finding {
    /// `three.js`, `Bevy`, `Godot`, `Blender`, `Babylon.js`, `phones` (WebGL2 on some of them), `SharpGLTF` or `UnityGLTF`.
    pub engine: &'static str,
    /// Which versions of it, as in `up to 0.17`; none: all that are known.
    pub versions: Option<&'static str>,
    /// How bad it is.
    pub severity: Severity,
    /// What it is about.
    pub about: About,
    /// The meshes it is about, rising; the message names the one with most. Empty where it is about none.
    pub meshes: Vec<usize>,
    /// What is found, with numbers.
    pub message: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { engine, versions, message, .. } = self;
        match versions {
            Some(versions) => write!(f, "{engine} {versions}: {message}"),
            None => write!(f, "{engine}: {message}"),
        }
    }
}

/// What engines make of a document. It is judged by its JSON alone, and whatever that holds is fine.
pub fn engines(gltf: &Gltf) -> Engines {
    of_json(gltf.json())
}

/// The same by the JSON.
pub(crate) fn of_json(json: &Value) -> Engines {
    let sheet = Sheet::of(json);
    Engines {
        targets: sheet.meshes.iter().map(|mesh| mesh.targets).max().unwrap_or(0),
        memory: memory(&sheet),
        findings: findings(&sheet),
    }
}

/// What three.js takes for a target of one vertex: a texel of its layer, two with normals.
fn three_bytes(primitive: &Primitive) -> u64 {
    if primitive.normals > 0 { 32 } else { 16 }
}

/// See the table above.
fn memory(sheet: &Sheet<'_>) -> Vec<EngineMemory> {
    let sum = |of: &dyn Fn(&Primitive) -> u64| {
        let primitives = sheet.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let bytes = primitives.map(|primitive| primitive.vertices.saturating_mul(of(primitive)));
        Some(bytes.fold(0, u64::saturating_add))
    };
    let targets = |primitive: &Primitive| primitive.targets as u64;
    let heap = |primitive: &Primitive| if primitive.normals > 0 { 56 } else { 28 };
    let dense = |p: &Primitive| (p.positions + p.normals + p.tangents) as u64;
    let layers = |engine| EngineMemory {
        engine,
        bytes: sum(&|primitive| three_bytes(primitive) * targets(primitive)),
        heap_bytes: sum(&|primitive| heap(primitive) * targets(primitive)),
    };
    let plain = |engine, bytes| EngineMemory { engine, bytes, heap_bytes: None };
    vec![
        layers(THREE),
        plain(BEVY, sum(&|primitive| 48 * targets(primitive))),
        plain(GODOT, sum(&|primitive| 12 * dense(primitive))),
        plain(BLENDER, sum(&|primitive| 12 * targets(primitive))),
        layers(BABYLON),
        plain(PHONES, None),
    ]
}

impl Engines {
    /// What of this an effect has brought about, `before` being what was said of its input: targets and joints that an engine does not take, or
    /// does not play as they are meant. What else effects add is read everywhere, or told by those that add it.
    pub(crate) fn note(&self, before: &Self) -> Option<String> {
        let known = |finding: &Finding| -> BTreeSet<usize> {
            let same = before.findings.iter().filter(|known| {
                (known.engine, known.versions, known.about)
                    == (finding.engine, finding.versions, finding.about)
            });
            same.flat_map(|known| known.meshes.iter().copied()).collect()
        };
        let of_targets = |finding: &&Finding| {
            matches!(
                finding.about,
                About::Targets | About::Vertices | About::Normals | About::Nodes | About::Joints
            )
        };
        let new = |finding: &&Finding| {
            let known = known(finding);
            finding.meshes.iter().any(|mesh| !known.contains(mesh))
                || finding.meshes.is_empty() && !before.findings.contains(finding)
        };
        let told: Vec<String> =
            self.findings.iter().filter(of_targets).filter(new).map(ToString::to_string).collect();
        (!told.is_empty()).then(|| format!("{} [engines]", told.join("; ")))
    }
}

#[cfg(test)]
#[path = "engines/tests.rs"]
mod tests;
