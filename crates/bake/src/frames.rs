//! One morph target a frame, played one after the other by weights of 1 and 0, linear in between.

use wirework_asset::{Gltf, MorphTarget, Rest, WeightTrack};

use crate::error::BakeError;
use crate::settings::Settings;
use crate::writer::{Baked, Frame, NodeClip, Poses, Writer, key_time, plain};

/// Takes frames one after the other.
#[derive(Debug)]
pub struct Baker<'a> {
    writer: Writer<'a>,
    times: Vec<f32>,
    nodes: Vec<NodeTrack>,
}

/// What becomes of one node.
#[derive(Debug, Default)]
struct NodeTrack {
    poses: Poses,
    /// For each frame its target; none where it equals the rest.
    frames: Vec<Option<usize>>,
    /// For each frame the weights of the targets of its own.
    weights: Vec<f32>,
}

impl<'a> Baker<'a> {
    /// A baker for the geometry `rest` of `gltf`. A mesh that has as many targets of its own as are allowed gets a
    /// warning, and its own are not counted: nothing the baker does could keep the limit.
    pub fn new(gltf: Gltf, rest: &'a Rest, settings: Settings) -> Self {
        let writer = Writer::new(gltf, rest, settings);
        let nodes = writer.nodes.iter().map(|_| NodeTrack::default()).collect();
        Self { writer, times: Vec::new(), nodes }
    }

    /// Takes the next frame, of a time in seconds. What equals its moment, bit for bit, stays as the document has it, or as a clip that
    /// plays meanwhile has it; what does not goes back to meshes through their nodes and skins as they are then.
    /// The weights of a mesh's own targets, which our track holds beside ours, are those of the moment, linear in between.
    ///
    /// # Errors
    ///
    /// A time that does not come after the one before; vertices that are not finite, or of another number than the rest's; more targets
    /// than are allowed; a document that cannot be edited.
    pub fn push(&mut self, time: f64, frame: &Frame<'_>) -> Result<(), BakeError> {
        let index = self.times.len();
        let seconds = key_time(index, time, self.times.last().copied())?;
        let sample = self.writer.sample(index, time, frame)?;
        self.writer.stuck = self.writer.stuck.max(sample.stuck);
        let own: Vec<Vec<f32>> =
            (0..self.nodes.len()).map(|node| self.writer.own_weights(node, &sample)).collect();
        let mut written = Vec::with_capacity(sample.blocks.len());
        for (block, deltas) in sample.blocks.into_iter().enumerate() {
            written.push(if deltas.moves() { Some(self.writer.block(block, deltas)?) } else { None });
        }
        for (node, own) in own.into_iter().enumerate() {
            let target = self.target(node, &written, time)?;
            let track = &mut self.nodes[node];
            track.frames.push(target);
            track.weights.extend(own);
        }
        self.times.push(seconds);
        Ok(())
    }

    /// The target of a node at a frame: a new one, unless an earlier frame was the same; none where nothing of it moves.
    fn target(
        &mut self,
        node: usize,
        written: &[Option<MorphTarget>],
        time: f64,
    ) -> Result<Option<usize>, BakeError> {
        let of_block = |block: usize| written.get(block).copied().flatten();
        if self.writer.nodes[node].blocks.iter().all(|&block| of_block(block).is_none()) {
            return Ok(None);
        }
        let content = self.writer.content(node, of_block)?;
        let (frame, poses) = (self.times.len(), &mut self.nodes[node].poses);
        let (own, fit) = (self.writer.nodes[node].own, poses.targets.len());
        if fit >= self.writer.settings.room(own) && !poses.has(&content) {
            return Err(BakeError::TooManyTargets {
                mesh: self.writer.mesh_name(node),
                limit: self.writer.settings.max_targets,
                own,
                fit,
                frame,
                seconds: time,
            });
        }
        let prefix = &self.writer.settings.prefix;
        Ok(Some(poses.take(content, || format!("{}_f{frame:04}", plain(prefix)))))
    }

    /// Adds targets and clip to the document.
    ///
    /// # Errors
    ///
    /// A document that cannot be edited; a clip that there is not, or that moves weights of the same nodes already.
    pub fn finish(self) -> Result<Baked, BakeError> {
        let Self { writer, times, nodes } = self;
        let clips = writer.nodes.iter().zip(nodes).map(|(node, track)| track.clip(node.index, node.own));
        let clips = clips.collect();
        writer.finish(&times, clips)
    }
}

impl NodeTrack {
    /// At each frame the weights of the mesh's own targets, then ours: a single 1, or none.
    fn clip(self, node: usize, own: usize) -> NodeClip {
        let count = self.poses.targets.len();
        let mut weights = Vec::with_capacity(self.frames.len() * (own + count));
        for (k, frame) in self.frames.iter().enumerate() {
            weights.extend(&self.weights[k * own..(k + 1) * own]);
            weights.extend((0..count).map(|k| if Some(k) == *frame { 1.0 } else { 0.0 }));
        }
        NodeClip { targets: self.poses.targets, track: WeightTrack { node, times: None, weights } }
    }
}
