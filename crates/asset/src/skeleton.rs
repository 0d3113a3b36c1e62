//! Skeletons made for meshes that have none: joints, a skin, and how the vertices hang on it.

use std::collections::BTreeSet;

use glam::{DAffine3, DQuat, DVec3};
use serde_json::{Value, json};

use crate::document::Gltf;
use crate::edit::{VERTICES, drop_compressed, whole};
use crate::error::AssetError;
use crate::graph::{columns, unit};
use crate::hang::{Hanging, Vertices};
use crate::limits::Budget;
use crate::rest::{Part, Rest};

/// A joint of a new skeleton, at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewJoint<'a> {
    /// The name of its node.
    pub name: &'a str,
    /// The joint that it hangs on, one before it in the list; none for one that hangs on nothing.
    pub parent: Option<usize>,
    /// In the space of its parent, metres.
    pub translation: [f32; 3],
    /// A quaternion x, y, z, w of length 1.
    pub rotation: [f32; 4],
    /// Along its own axes, none 0.
    pub scale: [f32; 3],
}

impl<'a> NewJoint<'a> {
    /// One at a place of its parent's space, with axes as its parent has them.
    pub fn at(name: &'a str, parent: Option<usize>, translation: [f32; 3]) -> Self {
        Self { name, parent, translation, rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
    }
}

/// A skeleton, and how vertices hang on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewSkin<'a> {
    /// The name of the skin, and of a node above the joints where several hang on nothing.
    pub name: &'a str,
    /// At least one, at most 65 536.
    pub joints: &'a [NewJoint<'a>],
    /// On how many joints each vertex may hang, at least one.
    pub each: usize,
    /// So many indices of joints a vertex, one vertex after the other.
    pub indices: &'a [u16],
    /// Their weights, from 0; those of a vertex add up to more than 0, and are written so that they add up to 1.
    pub weights: &'a [f32],
}

/// What hangs on a new skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct Hung {
    /// The nodes of the joints, in their order.
    pub joints: Vec<usize>,
    /// Each node whose mesh hangs on them, and the one that shows it now.
    pub shown: Vec<(usize, usize)>,
}

/// The joints of a skeleton in the world, and their nodes.
struct Bones {
    nodes: Vec<usize>,
    world: Vec<DAffine3>,
    /// The node that all of them are, or are below.
    root: usize,
}

fn fault<T>(found: impl Into<String>, expected: impl Into<String>) -> Result<T, AssetError> {
    Err(AssetError::file(found, expected))
}

impl Gltf {
    /// Has what `nodes` show hang on a new skeleton, so that at rest every vertex stays where it is.
    ///
    /// `rest` is the rest of this document; the vertices of the skin are those of its blocks that `nodes` show, in their order.
    /// Joints are appended to the nodes, and to each scene that shows one of `nodes`. From now on only the joints say where
    /// their meshes are, whatever moves the nodes, so a mesh is shown by a root without a transform: by its node, which leaves its parent,
    /// or by a new one where that carries more than a mesh. Blocks of the rest may come in another order then, if others stay between
    /// them. A mesh that other nodes show too is copied. Vertices on more than four joints get a second set of joints and weights, and so on, the largest
    /// weights first. The rest of the document has to be read anew.
    ///
    /// # Errors
    ///
    /// Nodes that show nothing of `rest`, or have a skin; a parent that does not come before its joint, joints without an inverse,
    /// numbers that are not finite; lists of another length than vertices × [`NewSkin::each`], indices of no joint, a vertex
    /// without weight. Nothing is changed then.
    pub fn add_skin(&mut self, rest: &Rest, nodes: &[usize], skin: &NewSkin<'_>) -> Result<Hung, AssetError> {
        self.append_skin(rest, nodes, skin).map_err(|error| error.in_file(&self.file))
    }

    fn append_skin(&mut self, rest: &Rest, nodes: &[usize], skin: &NewSkin<'_>) -> Result<Hung, AssetError> {
        let nodes: BTreeSet<usize> = nodes.iter().copied().collect();
        let graph = self.graph(&mut Budget::new(&self.limits), &mut Vec::new())?;
        for &node in &nodes {
            let shown = graph.nodes.get(node).filter(|node| node.mesh.is_some() && node.skin.is_none());
            let of_rest =
                |part: &Part| part.node == node && shown.is_some_and(|shown| shown.mesh == Some(part.mesh));
            if !rest.parts.iter().any(of_rest) {
                let skinned = graph.nodes.get(node).is_some_and(|node| node.skin.is_some());
                let found = format!("node {node}{}", if skinned { ", which has a skin already" } else { "" });
                return fault(found, "nodes that show a mesh, and have no skin");
            }
        }
        let world = world(skin.joints)?;
        let vertices: usize = rest.blocks.iter().filter(|b| nodes.contains(&b.node)).map(|b| b.count).sum();
        let hanging = Hanging::read(skin, vertices)?;
        let bones = self.append_bones(skin, world)?;
        // Joints must be in the scene of what hangs on them.
        self.show_in_scenes(&graph, &nodes, (bones.root, false))?;
        self.hang(rest, &nodes, &hanging)?;
        let mut skins: Vec<(DAffine3, usize)> = Vec::new();
        let mut of_nodes = Vec::with_capacity(nodes.len());
        for &node in &nodes {
            let own = graph.world[node];
            let index = match skins.iter().find(|(known, _)| *known == own) {
                Some((_, index)) => *index,
                None => self.append_binding(skin.name, &bones, &own)?,
            };
            skins.push((own, index));
            of_nodes.push((node, index));
        }
        // Each new root goes right behind the one it was below: backwards, so that they keep their order.
        let place = |node: &usize| graph.shown.iter().position(|shown| shown == node);
        of_nodes.sort_by_key(|(node, _)| std::cmp::Reverse(place(node)));
        let mut shown = Vec::with_capacity(nodes.len());
        for (node, skin) in of_nodes {
            let root = self.root_mesh(&graph, node)?;
            self.entry_mut("nodes", root)?.insert("skin".to_owned(), json!(skin));
            shown.push((node, root));
        }
        shown.sort_unstable();
        Ok(Hung { joints: bones.nodes, shown })
    }

    /// Appends the nodes of the joints, and one above them where several hang on nothing.
    fn append_bones(&mut self, skin: &NewSkin<'_>, world: Vec<DAffine3>) -> Result<Bones, AssetError> {
        let first = self.table_mut("nodes")?.len();
        let below = |parent: Option<usize>| -> Vec<usize> {
            let of = skin.joints.iter().enumerate().filter(|(_, joint)| joint.parent == parent);
            of.map(|(k, _)| first + k).collect()
        };
        for (k, joint) in skin.joints.iter().enumerate() {
            self.append("nodes", bone(joint, &below(Some(k))))?;
        }
        let root = match below(None).as_slice() {
            [root] => *root,
            roots => self.append("nodes", json!({ "name": skin.name, "children": roots }))?,
        };
        Ok(Bones { nodes: (first..first + skin.joints.len()).collect(), world, root })
    }

    /// Gives the primitives that `nodes` show their joints and weights.
    fn hang(&mut self, rest: &Rest, nodes: &BTreeSet<usize>, hanging: &Hanging) -> Result<(), AssetError> {
        let mut first = 0;
        for (index, block) in rest.blocks.iter().enumerate().filter(|(_, b)| nodes.contains(&b.node)) {
            let vertices = hanging.vertices(first..first + block.count);
            first += block.count;
            let attributes = self.append_vertices_of(vertices)?;
            // Other than the block's where an earlier block of the node had it copied.
            let own = self.list("nodes")[block.node].get("mesh").and_then(whole);
            let mut mesh = own.unwrap_or(block.mesh);
            if mesh == block.mesh && self.nodes_of(mesh).len() > 1 {
                mesh = self.copy_mesh(mesh, &[block.node])?;
            }
            for part in rest.parts.iter().filter(|part| part.block == index) {
                let primitive = self.primitives_mut(mesh)?.get_mut(part.primitive);
                let Some(primitive) = primitive.and_then(Value::as_object_mut) else { continue };
                drop_compressed(primitive);
                let Some(own) = primitive.get_mut("attributes").and_then(Value::as_object_mut) else {
                    continue;
                };
                own.retain(|key, _| !key.starts_with("JOINTS_") && !key.starts_with("WEIGHTS_"));
                for (set, [joints, weights]) in attributes.iter().enumerate() {
                    own.insert(format!("JOINTS_{set}"), json!(joints));
                    own.insert(format!("WEIGHTS_{set}"), json!(weights));
                }
            }
        }
        Ok(())
    }

    /// Appends joints and weights: for each set its two accessors.
    pub(crate) fn append_vertices_of(&mut self, sets: Vec<Vertices>) -> Result<Vec<[usize; 2]>, AssetError> {
        let mut out = Vec::with_capacity(sets.len());
        for Vertices { joints, component, weights } in sets {
            let view = self.append_view(joints, Some(VERTICES))?;
            let joints = self.append(
                "accessors",
                json!({ "bufferView": view, "componentType": component, "count": weights.len(), "type": "VEC4" }),
            )?;
            out.push([joints, self.append_vertices(weights, false)?]);
        }
        Ok(out)
    }

    /// Appends a skin for meshes whose space is at `mesh` in the world.
    fn append_binding(&mut self, name: &str, bones: &Bones, mesh: &DAffine3) -> Result<usize, AssetError> {
        let bind = |joint: &DAffine3| columns(&(joint.inverse() * *mesh));
        let matrices: Vec<[f32; 16]> = bones.world.iter().map(bind).collect();
        if matrices.as_flattened().iter().any(|c| !c.is_finite()) {
            return fault("a skin whose matrices overflow", "joints within the range of floats");
        }
        let matrices = self.append_tuples(matrices, "MAT4")?;
        self.append(
            "skins",
            json!({
                "name": name,
                "joints": bones.nodes,
                "inverseBindMatrices": matrices,
                "skeleton": bones.root,
            }),
        )
    }
}

/// Where the joints are in the world; they are checked on the way.
fn world(joints: &[NewJoint<'_>]) -> Result<Vec<DAffine3>, AssetError> {
    if joints.is_empty() || joints.len() > 1 << 16 {
        return fault(format!("{} joints", joints.len()), "1 to 65 536");
    }
    let mut out: Vec<DAffine3> = Vec::with_capacity(joints.len());
    for (k, joint) in joints.iter().enumerate() {
        let above = match joint.parent {
            None => DAffine3::IDENTITY,
            Some(parent) if parent < k => out[parent],
            Some(parent) => {
                return fault(format!("joint {k} on joint {parent}"), "joints behind their parents");
            }
        };
        let [translation, scale] =
            [joint.translation, joint.scale].map(|v| DVec3::from_array(v.map(f64::from)));
        let rotation = unit(DQuat::from_array(joint.rotation.map(f64::from)));
        let world = above * DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        if !(world.is_finite() && world.inverse().is_finite() && scale.cmpne(DVec3::ZERO).all()) {
            return fault(format!("joint {k} without an inverse"), "finite transforms, no scale 0");
        }
        out.push(world);
    }
    Ok(out)
}

/// The node of a joint, with what differs from the identity.
fn bone(joint: &NewJoint<'_>, children: &[usize]) -> Value {
    let mut node = json!({ "name": joint.name });
    if !children.is_empty() {
        node["children"] = json!(children);
    }
    let NewJoint { translation, rotation, scale, .. } = *joint;
    if translation != [0.0; 3] {
        node["translation"] = json!(translation.map(f64::from));
    }
    let turn = unit(DQuat::from_array(rotation.map(f64::from)));
    if turn != DQuat::IDENTITY {
        node["rotation"] = json!(turn.to_array().map(|c| c.clamp(-1.0, 1.0)));
    }
    if scale != [1.0; 3] {
        node["scale"] = json!(scale.map(f64::from));
    }
    node
}
