//! Which nodes are above and below which.
//!
//! All of it asks the nodes' own lists of children, whether a scene shows them or not. Each answer ends, whatever the lists say;
//! whether they form trees is checked where a rest is read.

use serde_json::Value;

use crate::document::Gltf;
use crate::edit::whole;

impl Gltf {
    /// The node that has `node` among its children; none for a root.
    pub fn parent(&self, node: usize) -> Option<usize> {
        self.list("nodes").iter().position(|above| children(above).any(|child| child == node))
    }

    /// The children of a node, in their order.
    pub fn children(&self, node: usize) -> Vec<usize> {
        self.list("nodes").get(node).into_iter().flat_map(children).collect()
    }

    /// The nodes from `root` down to `tip`, both of them included; just the one where they are the same. None where `root` is not
    /// above `tip`, or where one of them does not exist.
    pub fn node_path(&self, root: usize, tip: usize) -> Option<Vec<usize>> {
        let nodes = self.list("nodes");
        let mut parents = vec![None; nodes.len()];
        for (above, node) in nodes.iter().enumerate() {
            for child in children(node) {
                if let Some(slot @ None) = parents.get_mut(child) {
                    *slot = Some(above);
                }
            }
        }
        let mut path = vec![tip];
        let mut at = tip;
        while at != root {
            at = (*parents.get(at)?)?;
            if path.len() > nodes.len() {
                return None;
            }
            path.push(at);
        }
        path.reverse();
        (root < nodes.len()).then_some(path)
    }

    /// All nodes below `node`, rising; not `node` itself.
    pub fn descendants(&self, node: usize) -> Vec<usize> {
        let nodes = self.list("nodes");
        let mut seen = vec![false; nodes.len()];
        let mut stack = vec![node];
        while let Some(above) = stack.pop() {
            for child in nodes.get(above).into_iter().flat_map(children) {
                if seen.get(child) == Some(&false) {
                    seen[child] = true;
                    stack.push(child);
                }
            }
        }
        (0..nodes.len()).filter(|&below| seen[below] && below != node).collect()
    }
}

fn children(node: &Value) -> impl Iterator<Item = usize> {
    node.get("children").and_then(Value::as_array).into_iter().flatten().filter_map(whole)
}
