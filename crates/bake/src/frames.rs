//! One morph target a frame, played one after the other by weights of 1 and 0, linear in between.

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;
use wirework_asset::{
    AssetError, Block, Clip, Gltf, LocalDeltas, MeshTarget, MorphTarget, Rest, Tracks, WeightTrack, printable,
};

use crate::settings::{CROWDED, Settings};

/// Why frames cannot be baked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The document cannot be edited.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// A mesh would need more targets than are allowed.
    #[error(
        "the mesh {mesh} needs more than {limit} morph targets ({own} are its own): {fit} of ours fit, which is \
             until frame {frame} at {seconds} s; lower the frame rate, bake fewer frames or raise the limit \
             (--max-targets)"
    )]
    TooManyTargets {
        /// The name of the mesh or its index, control characters escaped.
        mesh: String,
        /// The limit.
        limit: usize,
        /// How many targets the mesh has of its own.
        own: usize,
        /// How many of ours fit.
        fit: usize,
        /// The first frame that does not fit, from 0.
        frame: usize,
        /// Its time.
        seconds: f64,
    },
    /// A frame has another number of vertices than the rest.
    #[error("frame {frame} has {found} vertices, the rest {expected}")]
    VertexCount {
        /// Which frame, from 0.
        frame: usize,
        /// Vertices of the frame.
        found: usize,
        /// Vertices of the rest.
        expected: usize,
    },
    /// A deformed vertex or the time of a frame is not a finite number, or times do not rise.
    #[error("frame {frame} {problem}")]
    Frame {
        /// Which frame, from 0.
        frame: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
}

/// What was baked.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The document with targets and clip.
    pub gltf: Gltf,
    /// How many targets were added, over all meshes; a mesh that is copied counts again.
    pub targets: usize,
    /// How many nodes move. With 0 the document is as it was.
    pub nodes: usize,
    /// Vertices that should have moved but cannot, because their transform is singular.
    pub stuck: usize,
}

/// Takes frames one after the other.
#[derive(Debug)]
pub struct Baker<'a> {
    gltf: Gltf,
    rest: &'a Rest,
    /// The blocks with a primitive that has tangents for a normal map.
    mapped: BTreeSet<usize>,
    settings: Settings,
    times: Vec<f32>,
    nodes: Vec<NodeTrack>,
    stuck: usize,
}

/// What becomes of one node.
#[derive(Debug)]
struct NodeTrack {
    node: usize,
    mesh: usize,
    /// How many targets the mesh has of its own.
    own: usize,
    /// For each primitive its block of vertices, and whether its targets have tangents.
    blocks: Vec<(usize, bool)>,
    targets: Vec<MeshTarget>,
    /// Which target has this content.
    known: BTreeMap<Vec<MorphTarget>, usize>,
    /// For each frame its target; none where it equals the rest.
    frames: Vec<Option<usize>>,
    /// For each frame the weights of the targets of its own.
    weights: Vec<f32>,
}

impl<'a> Baker<'a> {
    /// A baker for the geometry `rest` of `gltf`. A mesh that has as many targets of its own as are allowed gets a
    /// warning, and its own are not counted: nothing the baker does could keep the limit.
    pub fn new(mut gltf: Gltf, rest: &'a Rest, settings: Settings) -> Self {
        for warning in settings.crowded(&gltf, rest) {
            gltf.warn(CROWDED, warning);
        }
        let mut nodes: Vec<NodeTrack> = Vec::new();
        for part in &rest.parts {
            if nodes.last().is_none_or(|track| track.node != part.node) {
                let own = gltf.target_count(part.mesh);
                nodes.push(NodeTrack {
                    node: part.node,
                    mesh: part.mesh,
                    own,
                    blocks: Vec::new(),
                    targets: Vec::new(),
                    known: BTreeMap::new(),
                    frames: Vec::new(),
                    weights: Vec::new(),
                });
            }
            if let Some(track) = nodes.last_mut() {
                track.blocks.push((part.block, part.normal_mapped));
            }
        }
        let mapped = rest.parts.iter().filter(|part| part.normal_mapped).map(|part| part.block).collect();
        Self { gltf, rest, mapped, settings, times: Vec::new(), nodes, stuck: 0 }
    }

    /// Takes the next frame: its time in seconds, and positions, normals and tangents of all vertices in world space, as long
    /// as [`Rest::positions`]. A normal matters only where the input has normals; what equals [`Block::normals`],
    /// bit for bit, stays as it is. So with tangents, which only primitives that are [normal mapped] get: no other material
    /// looks at them, and each target would make every frame of an engine dearer.
    ///
    /// [`Block::normals`]: wirework_asset::Block::normals
    /// [normal mapped]: wirework_asset::Part::normal_mapped
    pub fn push(
        &mut self,
        time: f64,
        positions: &[[f32; 3]],
        normals: Option<&[[f32; 3]]>,
        tangents: Option<&[[f32; 3]]>,
    ) -> Result<(), BakeError> {
        self.push_from(self.rest, time, positions, normals, tangents)
    }

    /// Takes the next frame as [`Baker::push`] does, of a document that plays a clip meanwhile: `moment` is the rest of the baker
    /// as [`Player::rest_into`] makes it of that moment of the clip. What equals *it* stays as the clip has it; what does
    /// not goes back to meshes through their nodes and skins as they are then. The weights of a mesh's own targets, which our
    /// track holds beside ours, are those of the moment, linear in between.
    ///
    /// [`Player::rest_into`]: wirework_asset::Player::rest_into
    pub fn push_from(
        &mut self,
        moment: &Rest,
        time: f64,
        positions: &[[f32; 3]],
        normals: Option<&[[f32; 3]]>,
        tangents: Option<&[[f32; 3]]>,
    ) -> Result<(), BakeError> {
        self.check(time, positions, [normals, tangents])?;
        self.check_moment(moment)?;
        let mut stuck = 0;
        let mut moved = Vec::with_capacity(moment.blocks.len());
        for block in 0..moment.blocks.len() {
            let tangents = tangents.filter(|_| self.mapped.contains(&block));
            let deltas = moment.to_local(block, positions, normals, tangents);
            stuck += deltas.stuck;
            moved.push(if deltas.moves() { Some(self.write(block, deltas)?) } else { None });
        }
        for index in 0..self.nodes.len() {
            let blocks = self.nodes[index].blocks.clone();
            let content: Vec<_> =
                blocks.iter().map(|&(block, _)| moved.get(block).copied().flatten()).collect();
            let target = if content.iter().all(Option::is_none) {
                None
            } else {
                let mut filled = Vec::with_capacity(blocks.len());
                for (&(block, mapped), target) in blocks.iter().zip(content) {
                    let target = target.map_or_else(|| self.write(block, LocalDeltas::default()), Ok)?;
                    filled.push(MorphTarget { tangent: target.tangent.filter(|_| mapped), ..target });
                }
                Some(self.target(index, filled, time)?)
            };
            let track = &mut self.nodes[index];
            track.frames.push(target);
            let weights = blocks.first().and_then(|&(block, _)| moment.blocks.get(block));
            let weights = weights.map_or(&[][..], |block| &block.weights);
            track.weights.extend((0..track.own).map(|k| weights.get(k).copied().unwrap_or(0.0)));
        }
        self.stuck = self.stuck.max(stuck);
        self.times.push(time as f32);
        Ok(())
    }

    fn check(
        &self,
        time: f64,
        positions: &[[f32; 3]],
        directions: [Option<&[[f32; 3]]>; 2],
    ) -> Result<(), BakeError> {
        let (frame, expected) = (self.times.len(), self.rest.positions.len());
        for found in [Some(positions), directions[0], directions[1]].into_iter().flatten().map(<[_]>::len) {
            if found != expected {
                return Err(BakeError::VertexCount { frame, found, expected });
            }
        }
        let fault = |problem| Err(BakeError::Frame { frame, problem });
        let seconds = time as f32;
        if !(seconds.is_finite() && seconds >= 0.0 && self.times.last().is_none_or(|&last| last < seconds)) {
            return fault("does not come after the one before it, or before second 0");
        }
        if !directions.into_iter().flatten().chain([positions]).all(all_finite) {
            return fault("has a vertex that is not finite");
        }
        Ok(())
    }

    /// Whether it is a moment of the rest.
    fn check_moment(&self, moment: &Rest) -> Result<(), BakeError> {
        let (frame, expected, found) = (self.times.len(), self.rest.positions.len(), moment.positions.len());
        if found != expected {
            return Err(BakeError::VertexCount { frame, found, expected });
        }
        let alike = |(a, b): (&Block, &Block)| {
            (a.node, a.mesh, a.first, a.count) == (b.node, b.mesh, b.first, b.count)
                && a.normals.is_some() == b.normals.is_some()
        };
        let alike = moment.blocks.len() == self.rest.blocks.len()
            && moment.blocks.iter().zip(&self.rest.blocks).all(alike);
        if alike { Ok(()) } else { Err(BakeError::Frame { frame, problem: "is of another document" }) }
    }

    /// The target of a block: zeros for what the block has and `deltas` have not, as each target of a primitive has the same
    /// attributes.
    fn write(&mut self, block: usize, deltas: LocalDeltas) -> Result<MorphTarget, BakeError> {
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

    /// The target of a node with this content: a new one, unless an earlier frame was the same.
    fn target(&mut self, index: usize, content: Vec<MorphTarget>, time: f64) -> Result<usize, BakeError> {
        let frame = self.times.len();
        let track = &mut self.nodes[index];
        if let Some(&known) = track.known.get(&content) {
            return Ok(known);
        }
        let count = track.targets.len();
        let counted = if track.own >= self.settings.max_targets { 0 } else { track.own };
        if counted + count >= self.settings.max_targets {
            let name = self.gltf.mesh_name(track.mesh);
            return Err(BakeError::TooManyTargets {
                mesh: name.map_or_else(|| track.mesh.to_string(), |name| format!("\"{}\"", printable(name))),
                limit: self.settings.max_targets,
                own: track.own,
                fit: count,
                frame,
                seconds: time,
            });
        }
        let name = format!("{}_f{frame:04}", plain(&self.settings.prefix));
        track.targets.push(MeshTarget { name, primitives: content.clone() });
        track.known.insert(content, count);
        Ok(count)
    }

    /// Adds targets and clip to the document.
    pub fn finish(self) -> Result<Baked, BakeError> {
        let Self { mut gltf, settings, times, nodes, stuck, .. } = self;
        let mut meshes: BTreeMap<usize, Vec<(usize, &[MeshTarget])>> = BTreeMap::new();
        for track in &nodes {
            meshes.entry(track.mesh).or_default().push((track.node, &track.targets));
        }
        for (mesh, targets) in meshes {
            gltf.add_targets_by_node(mesh, &targets)?;
        }
        let moving: Vec<&NodeTrack> = nodes.iter().filter(|track| !track.targets.is_empty()).collect();
        let tracks: Vec<WeightTrack> = moving.iter().map(|track| track.weights()).collect();
        let clip = settings.clip.unwrap_or_else(|| Clip::New(gltf.unused_clip_name("wirework")));
        gltf.add_tracks(
            &clip,
            &Tracks { times: &times, weights: &tracks, source: settings.source, ..Tracks::default() },
        )?;
        let targets = moving.iter().map(|track| track.targets.len()).sum();
        if stuck > 0 {
            gltf.warn(
                "singular",
                format!("{stuck} vertices stay where they are: their transform has no inverse"),
            );
        }
        Ok(Baked { gltf, targets, nodes: moving.len(), stuck })
    }
}

impl NodeTrack {
    /// At each frame the weights of the mesh's own targets, then ours: a single 1, or none.
    fn weights(&self) -> WeightTrack {
        let mut weights = Vec::with_capacity(self.frames.len() * (self.own + self.targets.len()));
        for (k, frame) in self.frames.iter().enumerate() {
            weights.extend(&self.weights[k * self.own..(k + 1) * self.own]);
            weights.extend((0..self.targets.len()).map(|k| if Some(k) == *frame { 1.0 } else { 0.0 }));
        }
        WeightTrack { node: self.node, weights }
    }
}

/// Asked many at a time: stopping at the first number that is not finite would be slower.
fn all_finite(values: &[[f32; 3]]) -> bool {
    let finite = |block: &[f32]| block.iter().fold(true, |all, c| all & c.is_finite());
    values.as_flattened().chunks(1024).all(finite)
}

/// The text with all but letters, digits, `-` and `_` replaced.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}
