//! Skinned meshes at the root of their scenes, without a transform: above and at their nodes none counts, and validators say so.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::clip::target_of;
use crate::document::Gltf;
use crate::edit::whole;
use crate::error::AssetError;
use crate::graph::{Graph, walk};

/// What places a node.
const PLACE: [&str; 4] = ["matrix", "translation", "rotation", "scale"];

const POINTER: &str = "/target/extensions/KHR_animation_pointer/pointer";

impl Gltf {
    /// Has a root without a transform show the mesh of `node`, and gives its index: the node itself where it is nothing but the place of its
    /// mesh, else a new one of its name, which takes the mesh and its weights over, moved ones too.
    pub(crate) fn root_mesh(&mut self, graph: &Graph, node: usize) -> Result<usize, AssetError> {
        let own = self.entry_mut("nodes", node)?;
        let parent = graph.nodes[node].parent;
        if parent.is_none() && PLACE.iter().all(|key| !own.contains_key(*key)) {
            return Ok(node);
        }
        let is_more = ["children", "camera", "extensions"].iter().any(|key| own.contains_key(*key));
        if is_more || self.is_joint(node) || self.is_moved(node) {
            return self.split_mesh(graph, node);
        }
        let own = self.entry_mut("nodes", node)?;
        own.retain(|key, _| !PLACE.contains(&key.as_str()));
        if let Some(parent) = parent {
            let above = self.entry_mut("nodes", parent)?;
            let children = above.get_mut("children").and_then(Value::as_array_mut);
            let is_left = children.is_some_and(|children| {
                children.retain(|child| whole(child) != Some(node));
                !children.is_empty()
            });
            if !is_left {
                above.remove("children");
            }
            self.show_in_scenes(graph, &BTreeSet::from([node]), (node, true))?;
        }
        Ok(node)
    }

    fn split_mesh(&mut self, graph: &Graph, node: usize) -> Result<usize, AssetError> {
        let own = self.entry_mut("nodes", node)?;
        let mut new = serde_json::Map::new();
        new.extend(own.get("name").map(|name| ("name".to_owned(), name.clone())));
        new.extend(
            ["mesh", "weights"].into_iter().filter_map(|key| Some((key.to_owned(), own.remove(key)?))),
        );
        let new = self.append("nodes", Value::Object(new))?;
        let clips = self.json.get_mut("animations").and_then(Value::as_array_mut);
        for clip in clips.into_iter().flatten() {
            let channels = clip.get_mut("channels").and_then(Value::as_array_mut);
            for channel in channels.into_iter().flatten() {
                let Some((of, path)) = target_of(channel) else { continue };
                if of != node || path.split('/').next() != Some("weights") {
                    continue;
                }
                let place = format!("/nodes/{new}/{path}");
                if let Some(pointer) = channel.pointer_mut(POINTER) {
                    *pointer = json!(place);
                } else {
                    channel["target"]["node"] = json!(new);
                }
            }
        }
        self.show_in_scenes(graph, &BTreeSet::from([node]), (new, true))?;
        Ok(new)
    }

    /// Adds a root to the scenes that show one of `nodes`, as they were in `graph`: behind all others, or where it takes the place of one
    /// of them behind the root that this is below.
    pub(crate) fn show_in_scenes(
        &mut self,
        graph: &Graph,
        nodes: &BTreeSet<usize>,
        (root, replaces): (usize, bool),
    ) -> Result<(), AssetError> {
        let shows = |start: &Value| {
            let start = whole(start).filter(|&start| start < graph.nodes.len());
            start.is_some_and(|start| walk(&graph.nodes, &[start]).iter().any(|node| nodes.contains(node)))
        };
        for scene in 0..self.list("scenes").len() {
            let list = self.entry_mut("scenes", scene)?.get_mut("nodes").and_then(Value::as_array_mut);
            let Some(list) = list else { continue };
            if let Some(place) = list.iter().position(shows) {
                list.insert(if replaces { place + 1 } else { list.len() }, json!(root));
            }
        }
        Ok(())
    }

    /// Whether a clip moves a node itself, or anything of it but weights.
    fn is_moved(&self, node: usize) -> bool {
        let moves = |channel: &Value| {
            target_of(channel).is_some_and(|(of, path)| of == node && !path.starts_with("weights"))
        };
        let clips = self.list("animations").iter();
        clips.filter_map(|clip| clip.get("channels")?.as_array()).flatten().any(moves)
    }

    fn is_joint(&self, node: usize) -> bool {
        let has = |skin: &Value| {
            let joints = skin.get("joints").and_then(Value::as_array);
            joints.into_iter().flatten().chain(skin.get("skeleton")).any(|joint| whole(joint) == Some(node))
        };
        self.list("skins").iter().any(has)
    }
}
