//! Where nodes are when a clip is played.

use glam::DVec3;

use crate::parts::NodeParts;
use crate::player::Player;

impl Player<'_> {
    /// The world transform of a node at the time that was played last, or at rest before: columns x, y, z, and where it is.
    /// None where there is no such node.
    pub fn node_transform(&self, node: usize) -> Option<[[f64; 3]; 4]> {
        let world = self.graph.world.get(node)?;
        let axes = world.matrix3;
        Some(
            [axes.x_axis, axes.y_axis, axes.z_axis, world.translation].map(|column: DVec3| column.to_array()),
        )
    }

    /// The transform of a node in the space of its parent, at the time that was played last, or at rest before. None where there
    /// is no such node, or it has a matrix that no translation, rotation and scale make.
    pub fn node_parts(&self, node: usize) -> Option<NodeParts> {
        NodeParts::of(&self.graph.nodes.get(node)?.pose)
    }
}
