//! Displacements as morph targets of nodes, and the clip that plays them.

use std::collections::{BTreeMap, BTreeSet};

use wirework_asset::{
    Block, Clip, Gltf, LocalDeltas, MeshTarget, MorphTarget, Rest, Tracks, WeightTrack, printable,
};

use crate::error::BakeError;
use crate::settings::{Bake, CROWDED, Settings};

/// All vertices at one moment, in world space.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The rest of the document, or what [`Player::rest_into`](wirework_asset::Player::rest_into) makes of it at this moment of a clip that plays meanwhile.
    pub moment: &'a Rest,
    /// Deformed positions, as many as [`Rest::positions`].
    pub positions: &'a [[f32; 3]],
    /// Unit normals, as many; they matter only where the input has normals. What equals [`Block::normals`], bit for bit, stays as it is.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Unit tangents, as many; they matter only where the input is [normal mapped](wirework_asset::Part::normal_mapped): no other
    /// material looks at them, and each target would make every frame of an engine dearer.
    pub tangents: Option<&'a [[f32; 3]]>,
}

/// The displacements of all blocks at a moment, in the spaces of their meshes.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    /// Seconds.
    pub(crate) time: f64,
    pub(crate) blocks: Vec<LocalDeltas>,
    /// Of each block the weights of its mesh's own targets.
    pub(crate) weights: Vec<Vec<f32>>,
    /// How many vertices should have moved but cannot.
    pub(crate) stuck: usize,
}

/// A node whose mesh gets targets.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) index: usize,
    pub(crate) mesh: usize,
    /// How many targets the mesh has of its own.
    pub(crate) own: usize,
    /// For each primitive its block of vertices, and whether its targets have tangents.
    pub(crate) primitives: Vec<(usize, bool)>,
    /// The blocks, each once.
    pub(crate) blocks: Vec<usize>,
}

/// A document on its way to more targets.
#[derive(Debug)]
pub(crate) struct Writer<'a> {
    pub(crate) gltf: Gltf,
    pub(crate) rest: &'a Rest,
    pub(crate) settings: Settings,
    pub(crate) nodes: Vec<Node>,
    /// The blocks with a primitive that has tangents for a normal map.
    mapped: BTreeSet<usize>,
    /// Of all frames so far, the most vertices that should have moved but cannot.
    pub(crate) stuck: usize,
}

/// Targets of a node, one for each content.
#[derive(Debug, Default)]
pub(crate) struct Poses {
    pub(crate) targets: Vec<MeshTarget>,
    /// Which target has this content.
    known: BTreeMap<Vec<MorphTarget>, usize>,
}

/// What one node plays.
#[derive(Debug)]
pub(crate) struct NodeClip {
    pub(crate) targets: Vec<MeshTarget>,
    pub(crate) track: WeightTrack,
}

/// What was baked.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Baked {
    /// The document with targets and clip.
    pub gltf: Gltf,
    /// How many targets were added, over all meshes; a mesh that is copied counts again.
    pub targets: usize,
    /// How many nodes move. With 0 the document is as it was.
    pub nodes: usize,
    /// Vertices that should have moved but cannot, because their transform is singular.
    pub stuck: usize,
    /// How well it plays; none for [`Bake::Frames`](crate::Bake::Frames), which is exact at its frames.
    pub played: Option<Played>,
}

/// How well a bake plays the motion.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Played {
    /// How far a vertex is off at most, metres: a bound where the motion was sampled, and measured between frames.
    pub error: f64,
    /// The same as a part of the diagonal of the rest's bounds.
    pub of_diagonal: f64,
    /// By which angle a normal is off at most, radians, measured between frames. Where the surface folds over itself, or collapses, it
    /// may be large.
    pub normals: f64,
    /// The mean angle of those that turn.
    pub normals_mean: f64,
    /// How many moments the motion was sampled at: frames, and moments between frames where it is not straight there.
    pub samples: usize,
    /// What each node that moves plays.
    pub nodes: Vec<NodeBake>,
}

/// What a node plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NodeBake {
    /// The node.
    pub node: usize,
    /// [`Bake::Keys`](crate::Bake::Keys) or [`Bake::Basis`](crate::Bake::Basis).
    pub bake: Bake,
    /// How many targets its mesh got.
    pub targets: usize,
    /// How many keys its track has.
    pub keys: usize,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(mut gltf: Gltf, rest: &'a Rest, settings: Settings) -> Self {
        for warning in settings.crowded(&gltf, rest) {
            gltf.warn(CROWDED, warning);
        }
        let mut nodes: Vec<Node> = Vec::new();
        for part in &rest.parts {
            if nodes.last().is_none_or(|known| known.index != part.node) {
                let (index, mesh, own) = (part.node, part.mesh, gltf.target_count(part.mesh));
                nodes.push(Node { index, mesh, own, primitives: Vec::new(), blocks: Vec::new() });
            }
            if let Some(node) = nodes.last_mut() {
                node.primitives.push((part.block, part.normal_mapped));
                if !node.blocks.contains(&part.block) {
                    node.blocks.push(part.block);
                }
            }
        }
        let mapped = rest.parts.iter().filter(|part| part.normal_mapped).map(|part| part.block).collect();
        Self { gltf, rest, settings, nodes, mapped, stuck: 0 }
    }

    /// Takes a frame back to the spaces of the meshes. `index` is its number, for messages.
    pub(crate) fn sample(&self, index: usize, time: f64, frame: &Frame<'_>) -> Result<Sample, BakeError> {
        self.check(index, frame)?;
        let Frame { moment, positions, normals, tangents } = *frame;
        let local = |block| {
            let tangents = tangents.filter(|_| self.mapped.contains(&block));
            moment.to_local(block, positions, normals, tangents)
        };
        let blocks: Vec<LocalDeltas> = (0..moment.blocks.len()).map(local).collect();
        let stuck = blocks.iter().map(|deltas| deltas.stuck).sum();
        Ok(Sample {
            time,
            blocks,
            weights: moment.blocks.iter().map(|block| block.weights.clone()).collect(),
            stuck,
        })
    }

    fn check(&self, index: usize, frame: &Frame<'_>) -> Result<(), BakeError> {
        let Frame { moment, positions, normals, tangents } = *frame;
        let expected = self.rest.positions.len();
        let lists = [Some(positions), normals, tangents, Some(&moment.positions)];
        for found in lists.into_iter().flatten().map(<[_]>::len) {
            if found != expected {
                return Err(BakeError::VertexCount { frame: index, found, expected });
            }
        }
        let alike = |(a, b): (&Block, &Block)| {
            (a.node, a.mesh, a.first, a.count) == (b.node, b.mesh, b.first, b.count)
                && a.normals.is_some() == b.normals.is_some()
        };
        let alike = moment.blocks.len() == self.rest.blocks.len()
            && moment.blocks.iter().zip(&self.rest.blocks).all(alike);
        if !alike {
            return Err(BakeError::Frame { frame: index, problem: "is of another document" });
        }
        if ![Some(positions), normals, tangents].into_iter().flatten().all(all_finite) {
            return Err(BakeError::Frame { frame: index, problem: "has a vertex that is not finite" });
        }
        Ok(())
    }

    /// Whether the targets of a block have tangents.
    pub(crate) fn is_mapped(&self, block: usize) -> bool {
        self.mapped.contains(&block)
    }

    /// The weights of a node's own targets at a moment.
    pub(crate) fn own_weights(&self, node: usize, sample: &Sample) -> Vec<f32> {
        let Node { own, blocks, .. } = &self.nodes[node];
        let weights = blocks.first().and_then(|&block| sample.weights.get(block));
        let weight = |k: usize| weights.and_then(|weights| weights.get(k)).copied().unwrap_or(0.0);
        (0..*own).map(weight).collect()
    }

    /// Whether anything of a node differs from the rest.
    pub(crate) fn moves(&self, node: usize, sample: &Sample) -> bool {
        self.nodes[node].blocks.iter().filter_map(|&block| sample.blocks.get(block)).any(LocalDeltas::moves)
    }

    /// The target of a block: zeros for what the block has and `deltas` have not, as each target of a primitive has the same
    /// attributes.
    pub(crate) fn block(&mut self, block: usize, deltas: LocalDeltas) -> Result<MorphTarget, BakeError> {
        let (count, normals) =
            self.rest.blocks.get(block).map_or((0, false), |block| (block.count, block.normals.is_some()));
        let mapped = self.mapped.contains(&block);
        let mut append = |own: Option<Vec<[f32; 3]>>, with_bounds| {
            self.gltf.append_deltas(own.unwrap_or_else(|| vec![[0.0; 3]; count]), with_bounds)
        };
        let position = append(Some(deltas.positions).filter(|own| !own.is_empty()), true)?;
        let normal = normals.then(|| append(deltas.normals, false)).transpose()?;
        let tangent = mapped.then(|| append(deltas.tangents, false)).transpose()?;
        Ok(MorphTarget { position, normal, tangent })
    }

    /// The target of a node from those of its blocks; what has none stays.
    pub(crate) fn content(
        &mut self,
        node: usize,
        of_block: impl Fn(usize) -> Option<MorphTarget>,
    ) -> Result<Vec<MorphTarget>, BakeError> {
        let primitives = self.nodes[node].primitives.clone();
        let filled = primitives.into_iter().map(|(block, mapped)| {
            let target = of_block(block).map_or_else(|| self.block(block, LocalDeltas::default()), Ok)?;
            Ok(MorphTarget { tangent: target.tangent.filter(|_| mapped), ..target })
        });
        filled.collect()
    }

    /// How a message names the mesh of a node.
    pub(crate) fn mesh_name(&self, node: usize) -> String {
        let mesh = self.nodes[node].mesh;
        let name = self.gltf.mesh_name(mesh);
        name.map_or_else(|| mesh.to_string(), |name| format!("\"{}\"", printable(name)))
    }

    /// Adds targets and clip to the document; `clips` are those of the nodes, `times` the keys of tracks without their own.
    pub(crate) fn finish(self, times: &[f32], clips: Vec<NodeClip>) -> Result<Baked, BakeError> {
        let Self { mut gltf, settings, nodes, stuck, .. } = self;
        let mut meshes: BTreeMap<usize, Vec<(usize, &[MeshTarget])>> = BTreeMap::new();
        for (node, clip) in nodes.iter().zip(&clips) {
            meshes.entry(node.mesh).or_default().push((node.index, &clip.targets));
        }
        for (mesh, targets) in meshes {
            gltf.add_targets_by_node(mesh, &targets)?;
        }
        let moving: Vec<NodeClip> = clips.into_iter().filter(|clip| !clip.targets.is_empty()).collect();
        let targets = moving.iter().map(|clip| clip.targets.len()).sum();
        let tracks: Vec<WeightTrack> = moving.into_iter().map(|clip| clip.track).collect();
        let clip = settings.clip.unwrap_or_else(|| Clip::New(gltf.unused_clip_name("wirework")));
        gltf.add_tracks(
            &clip,
            &Tracks { times, weights: &tracks, source: settings.source, ..Tracks::default() },
        )?;
        if stuck > 0 {
            gltf.warn(
                "singular",
                format!("{stuck} vertices stay where they are: their transform has no inverse"),
            );
        }
        Ok(Baked { gltf, targets, nodes: tracks.len(), stuck, played: None })
    }
}

impl Poses {
    /// The target with this content: a new one of this name, unless there is one.
    pub(crate) fn take(&mut self, content: Vec<MorphTarget>, name: impl FnOnce() -> String) -> usize {
        if let Some(&known) = self.known.get(&content) {
            return known;
        }
        let count = self.targets.len();
        self.targets.push(MeshTarget { name: name(), primitives: content.clone() });
        self.known.insert(content, count);
        count
    }

    pub(crate) fn has(&self, content: &[MorphTarget]) -> bool {
        self.known.contains_key(content)
    }
}

/// The time of a key as files keep it, behind that of the one before.
pub(crate) fn key_time(frame: usize, time: f64, before: Option<f32>) -> Result<f32, BakeError> {
    let seconds = time as f32;
    if seconds.is_finite() && seconds >= 0.0 && before.is_none_or(|before| before < seconds) {
        return Ok(seconds);
    }
    Err(BakeError::Frame { frame, problem: "does not come after the one before it, or before second 0" })
}

/// Asked many at a time: stopping at the first number that is not finite would be slower.
fn all_finite(values: &[[f32; 3]]) -> bool {
    let finite = |block: &[f32]| block.iter().fold(true, |all, c| all & c.is_finite());
    values.as_flattened().chunks(1024).all(finite)
}

/// The text with all but letters, digits, `-` and `_` replaced.
pub(crate) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}
