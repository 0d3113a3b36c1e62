//! Placing a whole scene: a node above its roots.

use std::collections::BTreeSet;

use glam::DQuat;
use serde_json::{Value, json};
use wirework_surface::Transform;

use crate::document::Gltf;
use crate::edit::whole;
use crate::error::{AssetError, Place};
use crate::graph::Graph;
use crate::limits::Budget;

impl Gltf {
    /// Moves all that the scene shows: appends a node with `transform`, whose children are the scene's root nodes,
    /// and shows it in their place. No index moves, and clips play as before, in the placed scene.
    ///
    /// Joints move along, and with them the vertices of skins. A skinned mesh's own place does not count, so it stays a
    /// root, as the standard recommends. A scene that shares some of the roots but not all is shown them at their new place too: then each root gets a
    /// node above it of its own. The identity changes nothing.
    ///
    /// # Errors
    ///
    /// A number that is not finite; nodes that are malformed; a node of the scene that is another node's child.
    pub fn place(&mut self, transform: &Transform) -> Result<(), AssetError> {
        self.place_scene(transform).map_err(|error| error.in_file(&self.file))
    }

    fn place_scene(&mut self, transform: &Transform) -> Result<(), AssetError> {
        if *transform == Transform::default() {
            return Ok(());
        }
        let numbers = [transform.translation, transform.rotation, transform.scale];
        if numbers.as_flattened().iter().any(|x| !x.is_finite()) {
            return Err(AssetError::file("a placement that is not finite", "finite numbers"));
        }
        let graph = self.graph(&mut Budget::new(&self.limits), &mut Vec::new())?;
        let mut roots = self.roots(&graph)?;
        roots.retain(|&root| !graph.nodes[root].is_carried_by_joints());
        if roots.is_empty() {
            return Ok(());
        }
        // The node above each node, once there is one.
        let mut above: Vec<Option<usize>> = vec![None; graph.nodes.len()];
        if self.shares_part(&roots, graph.nodes.len()) {
            for root in roots {
                above[root] = Some(self.append("nodes", node(transform, &[root]))?);
            }
        } else {
            let one = self.append("nodes", node(transform, &roots))?;
            for root in roots {
                above[root] = Some(one);
            }
        }
        for scene in self.json.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(list) = scene.get_mut("nodes").and_then(Value::as_array_mut) {
                show_above(list, &above);
            }
        }
        Ok(())
    }

    /// The root nodes that the scene shows, each once.
    pub(crate) fn roots(&self, graph: &Graph) -> Result<Vec<usize>, AssetError> {
        let Some(mut listed) = self.scene_nodes(graph.nodes.len())? else { return Ok(graph.roots()) };
        for &node in &listed {
            if let Some(parent) = graph.nodes[node].parent {
                let place = Place::Pointer(format!("/nodes/{node}"));
                let found = format!("a node of the scene that is a child of node {parent}");
                return Err(AssetError::new(place, found, "root nodes only, to place the scene"));
            }
        }
        let mut seen = BTreeSet::new();
        listed.retain(|&node| seen.insert(node));
        Ok(listed)
    }

    /// Whether a scene shows some of `roots` but not all.
    fn shares_part(&self, roots: &[usize], count: usize) -> bool {
        let mut root = vec![false; count];
        for &node in roots {
            root[node] = true;
        }
        self.list("scenes").iter().any(|scene| {
            let listed = scene.get("nodes").and_then(Value::as_array).into_iter().flatten();
            let shown: BTreeSet<usize> =
                listed.filter_map(whole).filter(|&node| root.get(node).is_some_and(|&root| root)).collect();
            !shown.is_empty() && shown.len() < roots.len()
        })
    }
}

/// In the list of a scene the nodes above in place of theirs, each where the first of its children stood.
fn show_above(list: &mut Vec<Value>, above: &[Option<usize>]) {
    let mut shown = BTreeSet::new();
    list.retain_mut(|value| match whole(value).and_then(|node| *above.get(node)?) {
        Some(node) => {
            *value = json!(node);
            shown.insert(node)
        }
        None => true,
    });
}

/// A node with what differs from the identity.
fn node(transform: &Transform, children: &[usize]) -> Value {
    let rest = Transform::default();
    let mut node = json!({ "children": children });
    if transform.translation != rest.translation {
        node["translation"] = json!(transform.translation.map(f64::from));
    }
    if transform.rotation != rest.rotation {
        let [x, y, z] = transform.rotation.map(|degrees| f64::from(degrees).to_radians());
        let turn = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
        node["rotation"] = json!(turn.normalize().to_array());
    }
    if transform.scale != rest.scale {
        node["scale"] = json!(transform.scale.map(f64::from));
    }
    node
}
