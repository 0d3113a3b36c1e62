//! How many vertices each node, joint and material has: what an effect that is limited to one of them can move. All of
//! them are counted in one pass over what is read.

use std::collections::BTreeMap;

use crate::document::Gltf;
use crate::edit::whole;
use crate::error::AssetError;
use crate::graph::Graph;
use crate::json::Json;
use crate::limits::{Budget, reserve};
use crate::rest::{Part, Rest};
use crate::skin::Influences;

/// A node by which vertices can be chosen: it shows a mesh, stands for nodes below it that show one, or is a joint.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct NodeCensus {
    /// The node.
    pub node: usize,
    /// The mesh that it shows.
    pub mesh: Option<usize>,
    /// The nodes it stands for, those of [`Gltf::mesh_nodes`]: 1 if it shows a mesh, else as many as show one below it.
    pub mesh_nodes: usize,
    /// The vertices of the scene that these show, as in [`Gltf::vertices_of_nodes`].
    pub vertices: usize,
    /// The skins it is a joint of, rising.
    pub joint_of: Vec<usize>,
    /// The vertices of the scene that hang on it as a joint, as in [`Gltf::joint_weights`].
    pub joint_vertices: usize,
    /// Where it is in the world at rest.
    pub position: [f32; 3],
}

impl Gltf {
    /// The nodes by which vertices of `rest`, the rest of this document, can be chosen; rising.
    ///
    /// # Errors
    ///
    /// Nodes, joints or weights that are malformed, or the limits.
    pub fn node_census(&self, rest: &Rest) -> Result<Vec<NodeCensus>, AssetError> {
        self.census_of_nodes(rest).map_err(|error| error.in_file(&self.file))
    }

    fn census_of_nodes(&self, rest: &Rest) -> Result<Vec<NodeCensus>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        // They were told when the rest was read.
        let mut told = Vec::new();
        let graph = self.graph(&mut budget, &mut told)?;
        let mut out = shown(&graph, rest);
        for (index, skin) in self.list("skins").iter().enumerate() {
            let joints = skin.get("joints").and_then(|joints| joints.as_array()).into_iter().flatten();
            for joint in joints.filter_map(whole) {
                if let Some(entry) = out.get_mut(joint)
                    && entry.joint_of.last() != Some(&index)
                {
                    entry.joint_of.push(index);
                }
            }
        }
        for part in rest.first_parts().into_iter().flatten() {
            let count = rest.blocks.get(part.block).map_or(0, |block| block.count);
            self.count_joints(part, count, &mut out, &mut budget)?;
        }
        out.retain(|entry| entry.mesh_nodes > 0 || !entry.joint_of.is_empty());
        Ok(out)
    }

    /// Adds the `count` vertices of `part` to the joints they hang on.
    fn count_joints(
        &self,
        part: &Part,
        count: usize,
        nodes: &mut [NodeCensus],
        budget: &mut Budget,
    ) -> Result<(), AssetError> {
        let node = self.root().need("nodes")?.item(part.node)?;
        let Some(skin) = node.get("skin")? else { return Ok(()) };
        let (_, skin) = self.follow("skins", skin)?;
        let joints = skin.need("joints")?.items()?.map(Json::uint);
        let joints: Vec<usize> = joints.collect::<Result<_, AssetError>>()?;
        let attributes = self.primitive(part)?.need("attributes")?;
        // What is wrong with the weights was told when the rest was read.
        let influences = Influences::read(self, attributes, count, joints.len(), budget, &mut Vec::new())?;
        let mut held: Vec<usize> = Vec::new();
        for v in 0..count {
            held.clear();
            held.extend(influences.of(v).filter_map(|(joint, _)| joints.get(joint as usize)));
            // A node may be a joint of the skin several times.
            held.sort_unstable();
            held.dedup();
            for &node in &held {
                if let Some(entry) = nodes.get_mut(node) {
                    entry.joint_vertices += 1;
                }
            }
        }
        Ok(())
    }

    /// For each material how many vertices of `rest`, the rest of this document, it has, as in
    /// [`Gltf::vertices_of_materials`].
    ///
    /// # Errors
    ///
    /// Indices that are malformed, or the limits.
    pub fn material_census(&self, rest: &Rest) -> Result<Vec<usize>, AssetError> {
        self.census_of_materials(rest).map_err(|error| error.in_file(&self.file))
    }

    fn census_of_materials(&self, rest: &Rest) -> Result<Vec<usize>, AssetError> {
        let mut out = vec![0; self.material_count()];
        let mut add = |material: Option<usize>, count: usize| {
            if let Some(slot) = material.and_then(|material| out.get_mut(material)) {
                *slot += count;
            }
        };
        let mut parts: BTreeMap<usize, Vec<&Part>> = BTreeMap::new();
        for part in &rest.parts {
            parts.entry(part.block).or_default().push(part);
        }
        let mut budget = Budget::new(&self.limits);
        for (block, parts) in parts {
            let count = rest.blocks.get(block).map_or(0, |block| block.count);
            let mut materials: Vec<Option<usize>> = parts.iter().map(|part| part.material).collect();
            materials.sort_unstable();
            materials.dedup();
            if let [one] = materials[..] {
                add(one, count);
                continue;
            }
            let of = self.materials_of_vertices(&parts, &materials, count, &mut budget)?;
            let mut counts = vec![0; materials.len()];
            let mut unused = 0;
            for used in of {
                match used {
                    Used::Never => unused += 1,
                    Used::By(k) => counts[k as usize] += 1,
                    Used::ByMany => {}
                }
            }
            for (&material, count) in materials.iter().zip(counts) {
                add(material, count + unused);
            }
        }
        Ok(out)
    }

    /// Which of `materials`, which are sorted, use each vertex of a block of `count` that has these parts.
    fn materials_of_vertices(
        &self,
        parts: &[&Part],
        materials: &[Option<usize>],
        count: usize,
        budget: &mut Budget,
    ) -> Result<Vec<Used>, AssetError> {
        let mut out: Vec<Used> = reserve(count)?;
        out.resize(count, Used::Never);
        for part in parts {
            let Ok(k) = materials.binary_search(&part.material) else { continue };
            match self.indices(self.primitive(part)?, count, budget)? {
                None => out.iter_mut().for_each(|used| used.note(k as u32)),
                // They are below the number of vertices.
                Some(indices) => indices.iter().for_each(|&i| out[i as usize].note(k as u32)),
            }
        }
        Ok(out)
    }
}

/// By how many of some materials a vertex is used.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Used {
    Never,
    By(u32),
    ByMany,
}

impl Used {
    fn note(&mut self, material: u32) {
        *self = match *self {
            Self::Never => Self::By(material),
            Self::By(other) if other == material => Self::By(material),
            _ => Self::ByMany,
        };
    }
}

/// All nodes, with what they show and where they are.
fn shown(graph: &Graph, rest: &Rest) -> Vec<NodeCensus> {
    let nodes = graph.nodes.iter().zip(&graph.world).enumerate();
    let mut out: Vec<NodeCensus> = nodes
        .map(|(node, (own, world))| NodeCensus {
            node,
            mesh: own.mesh,
            mesh_nodes: usize::from(own.mesh.is_some()),
            position: world.translation.to_array().map(|c| c as f32),
            ..NodeCensus::default()
        })
        .collect();
    for block in &rest.blocks {
        if let Some(entry) = out.get_mut(block.node) {
            entry.vertices += block.count;
        }
    }
    // From the leaves upwards: what is at a node and below it. A node is done when all its children are.
    let mut below: Vec<(usize, usize)> = out.iter().map(|entry| (entry.mesh_nodes, entry.vertices)).collect();
    let mut children = vec![0_usize; below.len()];
    for parent in graph.nodes.iter().filter_map(|node| node.parent) {
        children[parent] += 1;
    }
    let mut done: Vec<usize> = (0..below.len()).filter(|&node| children[node] == 0).collect();
    while let Some(node) = done.pop() {
        let entry = &mut out[node];
        if entry.mesh.is_none() {
            (entry.mesh_nodes, entry.vertices) = below[node];
        }
        if let Some(parent) = graph.nodes[node].parent {
            let (nodes, vertices) = below[node];
            below[parent].0 += nodes;
            below[parent].1 += vertices;
            children[parent] -= 1;
            if children[parent] == 0 {
                done.push(parent);
            }
        }
    }
    out
}
