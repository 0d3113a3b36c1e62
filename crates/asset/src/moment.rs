//! What a document shows at a moment of a clip, as a rest: with the ways from the meshes to the world as they are then.

use std::sync::Arc;

use glam::DAffine3;

use crate::error::{AssetError, Place};
use crate::frame::Frame;
use crate::limits::{Budget, Of};
use crate::player::{Piece, Player, Shape, other_document};
use crate::rest::{Block, Rest};
use crate::tangent;

impl Player<'_> {
    /// Makes `rest`, which is the rest that the player was made with or a clone of it, what the document shows at a time
    /// of the clip: positions, normals, tangents and weights of morph targets, and the ways of vertices to the world and
    /// back. Triangles, parts and warnings stay. Times outside the keys are those of the nearest key.
    ///
    /// What takes a [`Rest`] then works at that moment: of the displacements that [`Rest::to_local`] gives, those of vertices
    /// that are where the clip has them are exactly 0, and [`Player::pose_into`] with the others, at the same time, gives
    /// the positions that they were made of.
    ///
    /// Without a clip `rest` keeps its bits, or gets back those that it had before another player changed them.
    ///
    /// # Errors
    ///
    /// As [`Player::pose_into`]; the rest of another document. After the former `rest` is no whole moment, but may be used again.
    pub fn rest_into(&mut self, seconds: f64, rest: &mut Rest) -> Result<(), AssetError> {
        let file = &self.gltf.file;
        self.moment(seconds, rest).map_err(|error| error.in_file(file))
    }

    fn moment(&mut self, seconds: f64, rest: &mut Rest) -> Result<(), AssetError> {
        if !self.fits(rest) {
            return Err(other_document());
        }
        self.settle(seconds)?;
        let mut budget = Budget::new(&self.gltf.limits);
        // Positions and normals, and once more those that are morphed.
        budget.charge(Of::ExpandedBytes, rest.positions.len() as u64 * 48, || Place::File)?;
        let joints = self.skins.iter().map(|posed| Arc::from(posed.matrices.as_slice()));
        let joints: Vec<Arc<[DAffine3]>> = joints.collect();
        for (&piece, block) in self.pieces.iter().zip(&mut rest.blocks) {
            let shape = &mut self.shapes[piece.shape];
            if block.local_tangents.is_some() && shape.tangents.is_none() {
                shape.tangents = tangent::read(self.gltf, shape.primitive, &mut budget, &mut Vec::new())?;
            }
            let weights = self.weights.get(&piece.node).map_or(&[][..], Vec::as_slice);
            block.weights.clear();
            block.weights.extend(weights.iter().map(|&weight| weight as f32));
            let shape = &*shape;
            let local = shape.morphed(self.gltf, weights, &mut self.morphed, &mut budget)?;
            let positions = &mut rest.positions[block.first..block.first + block.count];
            positions.copy_from_slice(&local.positions);
            block.local_normals.clone_from(&local.normals);
            block.normals.clone_from(&local.normals);
            let normals = block.normals.as_deref_mut().unwrap_or_default();
            let world = &self.graph.world[piece.node];
            let joints = piece.skin.and_then(|skin| joints.get(skin));
            block.frame.follow(world, joints, positions, normals).map_err(|found| {
                shape.primitive.found(format!("{found} at {seconds} s"), "vertices in the range of floats")
            })?;
            if let (Some(local), Some(base)) = (&mut block.local_tangents, &shape.tangents) {
                local.clone_from(base);
                tangent::morph(self.gltf, shape.primitive, weights, local, &mut budget)?;
                block.tangents = Some(block.frame.tangents(local));
            }
        }
        Ok(())
    }

    /// Whether a rest is made as that of this player.
    fn fits(&self, rest: &Rest) -> bool {
        let mut first = 0;
        let mut fits = |(piece, block): (&Piece, &Block)| {
            let Shape { base, .. } = &self.shapes[piece.shape];
            let skin = piece.skin.map(|skin| self.skins[skin].skin.joints.len());
            let joints = match &block.frame {
                Frame::Node(_) => None,
                Frame::Skin { joints, .. } => Some(joints.len()),
            };
            let (start, count) = (first, base.positions.len());
            first += count;
            (block.node, block.first, block.count) == (piece.node, start, count) && joints == skin
        };
        rest.blocks.len() == self.pieces.len()
            && self.pieces.iter().zip(&rest.blocks).all(&mut fits)
            && rest.positions.len() == first
    }
}
