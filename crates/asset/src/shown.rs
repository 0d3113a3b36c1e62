//! A mesh as a node of the scene shows it: its primitives read, and taken to the world.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DAffine3;

use crate::attributes::{self, Local};
use crate::document::Gltf;
use crate::error::{AssetError, ErrorClass, Warning};
use crate::frame::Frame;
use crate::graph::{Graph, floats};
use crate::json::Json;
use crate::limits::{Budget, Of};
use crate::primitive::Mode;
use crate::rest::{Block, Part, Rest};
use crate::skin::Influences;
use crate::tangent::{self, Mapped};
use crate::way::Way;

/// A node that shows a mesh.
pub(crate) struct Shown<'a> {
    pub(crate) gltf: &'a Gltf,
    pub(crate) graph: &'a Graph,
    pub(crate) node: usize,
    pub(crate) mesh: usize,
    pub(crate) joints: Option<&'a Arc<[DAffine3]>>,
}

impl Shown<'_> {
    pub(crate) fn read(&self, rest: &mut Rest, budget: &mut Budget) -> Result<(), AssetError> {
        let mesh = self.gltf.root().need("meshes")?.item(self.mesh)?;
        let primitives = mesh.need("primitives")?;
        let count = primitives.array()?.len();
        budget.charge(Of::Primitives, count as u64, || primitives.place())?;
        let targets = attributes::target_count(primitives)?;
        let own = self.graph.nodes[self.node].weights.as_deref();
        let weights = default_weights(self.gltf, self.node, own, mesh, targets)?;
        let mut blocks: BTreeMap<Vec<(String, usize)>, usize> = BTreeMap::new();
        let mut sets: BTreeMap<usize, Vec<Mapped<'_>>> = BTreeMap::new();
        for (index, primitive) in primitives.items()?.enumerate() {
            let list = attributes::check(self.gltf, primitive)?;
            if !list.iter().any(|(key, _)| key == "POSITION") {
                let message = "the primitive has no positions; it is passed over";
                rest.warnings.push(Warning::new("positions-missing", primitive.place(), message));
                continue;
            }
            let block = if let Some(&block) = blocks.get(&list) {
                block
            } else {
                self.block(primitive, &weights, rest, budget)?;
                blocks.insert(list, rest.blocks.len() - 1);
                rest.blocks.len() - 1
            };
            self.part(index, primitive, block, rest, budget)?;
            let set = self.gltf.tangent_set(primitive).filter(|_| rest.blocks[block].tangents.is_some());
            if let (Some(set), Some(part)) = (set, rest.parts.last_mut()) {
                part.normal_mapped = true;
                let triangles = part.first_triangle..part.first_triangle + part.triangle_count;
                sets.entry(block).or_default().push(Mapped { primitive, set, triangles });
            }
        }
        for (block, mapped) in sets {
            let Rest { blocks, triangles, warnings, .. } = &mut *rest;
            let range = blocks[block].first..blocks[block].first + blocks[block].count;
            blocks[block].tangent_uvs =
                tangent::coordinates(self.gltf, &mapped, range, triangles, budget, warnings)?;
        }
        Ok(())
    }

    /// Reads the vertices of a primitive as a new block.
    fn block(
        &self,
        primitive: Json<'_>,
        weights: &[f64],
        rest: &mut Rest,
        budget: &mut Budget,
    ) -> Result<(), AssetError> {
        let mut local = Local::read(self.gltf, primitive, budget, &mut rest.warnings)?;
        local.morph(self.gltf, primitive, weights, budget)?;
        let uvs = attributes::texture_coordinates(self.gltf, primitive, 0, budget, &mut rest.warnings)?;
        let mut local_tangents = tangent::read(self.gltf, primitive, budget, &mut rest.warnings)?;
        if let Some(tangents) = &mut local_tangents {
            tangent::morph(self.gltf, primitive, weights, tangents, budget)?;
        }
        let count = local.positions.len();
        budget.charge(Of::Vertices, count as u64, || primitive.place())?;
        let ways = if self.joints.is_some() { size_of::<Way>() as u64 } else { 0 };
        let each = 36 + ways + if local_tangents.is_some() { 24 } else { 0 };
        budget.charge(Of::ExpandedBytes, count as u64 * each, || primitive.place())?;
        let first = rest.positions.len();
        if u32::try_from(first.saturating_add(count)).is_err() {
            return Err(primitive
                .found("more vertices than 32 bits count", "fewer: no flag raises this")
                .of_class(ErrorClass::Limit));
        }
        let attributes = primitive.need("attributes")?;
        let mut normals = local.normals.clone();
        let world_normals = normals.as_deref_mut().unwrap_or_default();
        let frame = self.place(local.positions, world_normals, attributes, rest, budget)?;
        let tangents = local_tangents.as_ref().map(|tangents| frame.tangents(tangents));
        if normals.is_none() && Mode::read(primitive)? as u8 >= Mode::Triangles as u8 {
            let message = "there are no normals; they are computed where they are needed";
            rest.warnings.push(Warning::new("normals-missing", attributes.place(), message));
        }
        rest.blocks.push(Block {
            node: self.node,
            mesh: self.mesh,
            first,
            count,
            weights: weights.iter().map(|&weight| weight as f32).collect(),
            normals,
            tangents,
            uvs,
            tangent_uvs: None,
            local_normals: local.normals,
            local_tangents,
            frame,
        });
        Ok(())
    }

    /// Appends the world positions of vertices, in place of `local` where they are the first, and takes their normals
    /// to the world.
    fn place(
        &self,
        mut local: Vec<[f32; 3]>,
        normals: &mut [[f32; 3]],
        attributes: Json<'_>,
        rest: &mut Rest,
        budget: &mut Budget,
    ) -> Result<Frame, AssetError> {
        let fault = |found: &str| {
            AssetError::new(attributes.place(), found, "vertices in the range of floats that fit into memory")
        };
        if !rest.positions.is_empty() {
            rest.positions.try_reserve(local.len()).map_err(|_| fault("more vertices than fit"))?;
        }
        let frame = if let Some(joints) = self.joints {
            let (count, warnings) = (local.len(), &mut rest.warnings);
            let influences = Influences::read(self.gltf, attributes, count, joints.len(), budget, warnings)?;
            Frame::of_skin(influences, Arc::clone(joints), &mut local, normals)
        } else {
            Frame::of_node(&self.graph.world[self.node], &mut local, normals)
        };
        let frame = frame.map_err(fault)?;
        if rest.positions.is_empty() {
            rest.positions = local;
        } else {
            rest.positions.append(&mut local);
        }
        Ok(frame)
    }

    fn part(
        &self,
        index: usize,
        primitive: Json<'_>,
        block: usize,
        rest: &mut Rest,
        budget: &mut Budget,
    ) -> Result<(), AssetError> {
        let (first, count) = (rest.blocks[block].first, rest.blocks[block].count);
        let mut triangles = self.gltf.triangles(primitive, count, budget, &mut rest.warnings)?;
        let mirrored = rest.blocks[block].frame.mirrored();
        if first > 0 {
            triangles.as_flattened_mut().iter_mut().for_each(|corner| *corner += first as u32);
        }
        if mirrored {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
        }
        let material = primitive.get("material")?.map(|m| self.gltf.follow("materials", m)).transpose()?;
        rest.parts.push(Part {
            node: self.node,
            mesh: self.mesh,
            primitive: index,
            material: material.map(|(index, _)| index),
            normal_mapped: false,
            mode: Mode::read(primitive)?,
            block,
            first_triangle: rest.triangles.len(),
            triangle_count: triangles.len(),
        });
        if rest.triangles.is_empty() {
            rest.triangles = triangles;
        } else {
            rest.triangles.append(&mut triangles);
        }
        Ok(())
    }
}

/// The default weights of the `targets` morph targets of a mesh as a node shows it: the node's `own`, else the mesh's.
pub(crate) fn default_weights(
    gltf: &Gltf,
    node: usize,
    own: Option<&[f64]>,
    mesh: Json<'_>,
    targets: usize,
) -> Result<Vec<f64>, AssetError> {
    let (weights, place) = match (own, mesh.get("weights")?) {
        (Some(own), _) => (own.to_vec(), gltf.root().need("nodes")?.item(node)?.need("weights")?),
        (None, Some(json)) => (floats(json)?, json),
        (None, None) => return Ok(vec![0.0; targets]),
    };
    if weights.len() != targets {
        return Err(
            place.found(format!("{} weights", weights.len()), format!("{targets}, one a morph target"))
        );
    }
    Ok(weights)
}
