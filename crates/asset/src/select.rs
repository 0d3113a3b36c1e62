//! Which vertices of a scene belong to nodes, to materials and to joints.

use std::collections::BTreeSet;

use crate::document::Gltf;
use crate::edit::whole;
use crate::error::AssetError;
use crate::limits::Budget;
use crate::rest::{Part, Rest};
use crate::skin::Influences;

/// How much vertices hang on some joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointWeights {
    /// For each vertex the sum of its weights for these joints over the sum of all its weights, from 0 to 1.
    pub of_vertices: Vec<f32>,
    /// Those of the joints on which any vertex hangs, rising.
    pub used: Vec<usize>,
}

impl Gltf {
    /// All nodes that are joints of a skin, rising.
    pub fn joint_nodes(&self) -> Vec<usize> {
        let joints = self.list("skins").iter().filter_map(|skin| skin.get("joints")?.as_array()).flatten();
        let nodes: BTreeSet<usize> = joints.filter_map(whole).collect();
        nodes.into_iter().filter(|&node| node < self.node_count()).collect()
    }

    /// The nodes that `nodes` stand for, rising: each itself if it shows a mesh, else all below it that show one.
    ///
    /// Exporters put an object's mesh in its own node, or in nodes below a bare one that carries the name. A node with
    /// a mesh does not stand for its children, so that it can be told from them.
    pub fn mesh_nodes(&self, nodes: &[usize]) -> Vec<usize> {
        let list = self.list("nodes");
        let shows = |node: usize| list.get(node).is_some_and(|node| node.get("mesh").is_some());
        let (own, mut stack): (Vec<usize>, Vec<usize>) = nodes.iter().partition(|&&node| shows(node));
        let mut out: BTreeSet<usize> = own.into_iter().collect();
        let mut seen: BTreeSet<usize> = stack.iter().copied().collect();
        while let Some(node) = stack.pop() {
            let children = list.get(node).and_then(|node| node.get("children")?.as_array());
            for child in children.into_iter().flatten().filter_map(whole) {
                if seen.insert(child) {
                    stack.push(child);
                    out.extend(shows(child).then_some(child));
                }
            }
        }
        out.into_iter().collect()
    }

    /// For each vertex of `rest`, the rest of this document, whether one of `nodes` shows it.
    pub fn vertices_of_nodes(&self, rest: &Rest, nodes: &[usize]) -> Vec<bool> {
        let nodes: BTreeSet<usize> = nodes.iter().copied().collect();
        let mut out = vec![false; rest.positions.len()];
        for block in rest.blocks.iter().filter(|block| nodes.contains(&block.node)) {
            out.iter_mut().skip(block.first).take(block.count).for_each(|slot| *slot = true);
        }
        out
    }

    /// For each vertex of `rest`, the rest of this document, whether all primitives that use it have one of
    /// `materials`.
    ///
    /// Exporters often give all primitives of a mesh the same vertices, of which each uses its own. Vertices that none
    /// uses belong to the primitives that have them.
    ///
    /// # Errors
    ///
    /// Indices that are malformed, or the limits.
    pub fn vertices_of_materials(&self, rest: &Rest, materials: &[usize]) -> Result<Vec<bool>, AssetError> {
        self.of_materials(rest, materials).map_err(|error| error.in_file(&self.file))
    }

    fn of_materials(&self, rest: &Rest, materials: &[usize]) -> Result<Vec<bool>, AssetError> {
        let materials: BTreeSet<usize> = materials.iter().copied().collect();
        let has = |part: &Part| part.material.is_some_and(|material| materials.contains(&material));
        // For each block whether a part of it has one of the materials, and whether one has not.
        let mut found = vec![(false, false); rest.blocks.len()];
        for part in &rest.parts {
            if let Some((with, without)) = found.get_mut(part.block) {
                *if has(part) { with } else { without } = true;
            }
        }
        let mut out = vec![false; rest.positions.len()];
        for (block, _) in rest.blocks.iter().zip(&found).filter(|(_, found)| found.0) {
            out.iter_mut().skip(block.first).take(block.count).for_each(|slot| *slot = true);
        }
        let mut budget = Budget::new(&self.limits);
        for part in rest.parts.iter().filter(|part| !has(part)) {
            let block = rest.blocks.get(part.block).filter(|_| found[part.block] == (true, true));
            let Some(slots) = block.and_then(|block| out.get_mut(block.first..)?.get_mut(..block.count))
            else {
                continue;
            };
            match self.indices(self.primitive(part)?, slots.len(), &mut budget)? {
                None => slots.fill(false),
                // They are below the number of vertices.
                Some(indices) => indices.iter().for_each(|&i| slots[i as usize] = false),
            }
        }
        Ok(out)
    }

    /// For each vertex of `rest`, the rest of this document, how much of it hangs on `joints`, which are nodes.
    ///
    /// All sets of joints and weights count. A vertex without any weight hangs on its first joint, as it is shown; one
    /// without skin hangs on nothing, and has 0.
    ///
    /// # Errors
    ///
    /// Joints or weights that are malformed, or the limits.
    pub fn joint_weights(&self, rest: &Rest, joints: &[usize]) -> Result<JointWeights, AssetError> {
        let joints: BTreeSet<usize> = joints.iter().copied().collect();
        let mut budget = Budget::new(&self.limits);
        let mut out = vec![0.0; rest.positions.len()];
        let mut used = BTreeSet::new();
        for (block, part) in rest.blocks.iter().zip(rest.first_parts()) {
            let slots = out.get_mut(block.first..).and_then(|slots| slots.get_mut(..block.count));
            if let (Some(part), Some(slots)) = (part, slots) {
                self.part_weights(part, &joints, slots, &mut used, &mut budget)
                    .map_err(|error| error.in_file(&self.file))?;
            }
        }
        Ok(JointWeights { of_vertices: out, used: used.into_iter().collect() })
    }

    fn part_weights(
        &self,
        part: &Part,
        joints: &BTreeSet<usize>,
        out: &mut [f32],
        used: &mut BTreeSet<usize>,
        budget: &mut Budget,
    ) -> Result<(), AssetError> {
        let node = self.root().need("nodes")?.item(part.node)?;
        let Some(skin) = node.get("skin")? else { return Ok(()) };
        let (_, skin) = self.follow("skins", skin)?;
        // For each joint of the skin its node, where that is one of those asked for.
        let chosen = skin.need("joints")?.items()?.map(|joint| Ok(joints.get(&joint.uint()?).copied()));
        let chosen: Vec<Option<usize>> = chosen.collect::<Result<_, AssetError>>()?;
        let attributes = self.primitive(part)?.need("attributes")?;
        let mut hit = vec![false; chosen.len()];
        // What is wrong with the weights was told when the rest was read.
        let influences =
            Influences::read(self, attributes, out.len(), chosen.len(), budget, &mut Vec::new())?;
        for (v, slot) in out.iter_mut().enumerate() {
            let (mut of, mut all) = (0.0, 0.0);
            for (joint, weight) in influences.of(v) {
                let Some(known) = chosen.get(joint as usize) else { continue };
                let weight = f64::from(weight);
                of += known.map_or(0.0, |_| weight);
                all += weight;
                hit[joint as usize] = true;
            }
            *slot = if all > 0.0 { (of / all) as f32 } else { 0.0 };
        }
        used.extend(chosen.iter().zip(hit).filter_map(|(node, hit)| node.filter(|_| hit)));
        Ok(())
    }
}
