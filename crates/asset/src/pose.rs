//! Where nodes are when a clip is played, and documents that keep them there.

use std::collections::BTreeMap;

use glam::DVec3;
use serde_json::{Value, json};

use crate::document::Gltf;
use crate::error::AssetError;
use crate::graph::Pose;
use crate::parts::NodeParts;
use crate::player::Player;
use crate::track::Path;

/// What a clip makes of one node at a moment: only the properties that it moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodePose {
    /// The node.
    pub node: usize,
    /// In the space of its parent, metres.
    pub translation: Option<[f64; 3]>,
    /// A quaternion x, y, z, w of length 1.
    pub rotation: Option<[f64; 4]>,
    /// Along the node's own axes.
    pub scale: Option<[f64; 3]>,
    /// The weights of the morph targets of its mesh.
    pub weights: Option<Vec<f64>>,
}

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

    /// What the clip makes of the nodes that it moves, at the time that was played last, in the order of the nodes: for
    /// [`Gltf::pose_nodes`]. Weights only of nodes that show something of the rest.
    pub fn node_poses(&self) -> Vec<NodePose> {
        let mut out: BTreeMap<usize, NodePose> = BTreeMap::new();
        for channel in &self.channels {
            let node = channel.node;
            let pose = out.entry(node).or_insert_with(|| NodePose { node, ..NodePose::default() });
            let own = self.graph.nodes.get(node).map(|node| node.pose);
            match (channel.path, own) {
                (Path::Weights(_), _) => pose.weights = self.weights.get(&node).cloned(),
                (Path::Translation, Some(Pose::Parts { translation, .. })) => {
                    pose.translation = Some(translation.to_array());
                }
                (Path::Rotation, Some(Pose::Parts { rotation, .. })) => {
                    pose.rotation = Some(rotation.to_array());
                }
                (Path::Scale, Some(Pose::Parts { scale, .. })) => pose.scale = Some(scale.to_array()),
                // A node with a matrix has no track.
                (_, Some(Pose::Matrix(_)) | None) => {}
            }
        }
        out.into_values().collect()
    }
}

impl Gltf {
    /// Has nodes stand as a clip has them at a moment, so that a still shows that moment: their own translation, rotation, scale and
    /// weights become those of `poses`, which [`Player::node_poses`] gives. Clips stay, and play as before.
    ///
    /// Morph targets that have been appended to a mesh since keep the weights that they have. A still of what was deformed at that
    /// moment is this, and [`Gltf::set_still`] with the rest of the moment.
    ///
    /// # Errors
    ///
    /// A node that is not there.
    pub fn pose_nodes(&mut self, poses: &[NodePose]) -> Result<(), AssetError> {
        for pose in poses {
            self.pose_node(pose).map_err(|error| error.in_file(&self.file))?;
        }
        Ok(())
    }

    fn pose_node(&mut self, pose: &NodePose) -> Result<(), AssetError> {
        // Where there are more weights than the pose has, the document's own stand behind.
        let weights = pose.weights.as_ref().map(|own| {
            let further = self.default_weights(pose.node).into_iter().map(f64::from).skip(own.len());
            own.iter().copied().chain(further).collect::<Vec<f64>>()
        });
        let entry = self.entry_mut("nodes", pose.node)?;
        let clamped = |turn: [f64; 4]| turn.map(|c| c.clamp(-1.0, 1.0));
        let all: [(&str, Option<Value>); 4] = [
            ("translation", pose.translation.map(|v| json!(v))),
            ("rotation", pose.rotation.map(|turn| json!(clamped(turn)))),
            ("scale", pose.scale.map(|v| json!(v))),
            ("weights", weights.map(|weights| json!(weights))),
        ];
        for (key, value) in all {
            if let Some(value) = value {
                entry.insert(key.to_owned(), value);
            }
        }
        Ok(())
    }
}
