//! The rest geometry of a document: what its scene shows before the effect, in world space.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use glam::DAffine3;
use wirework_surface::{Corner, Mesh};

use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::frame::Frame;
use crate::limits::Budget;
use crate::primitive::Mode;
use crate::shown::Shown;
use crate::skin::Skin;

/// Everything the scene of a document shows, as one set of vertices in world space.
///
/// A mesh that several nodes show is there once a node.
#[derive(Clone, Debug, Default)]
pub struct Rest {
    /// World positions of all vertices, one [`Block`] after the other.
    pub positions: Vec<[f32; 3]>,
    /// All triangles, indices into `positions`, counter-clockwise seen from outside; part after part.
    pub triangles: Vec<[u32; 3]>,
    /// The runs of vertices.
    pub blocks: Vec<Block>,
    /// The primitives that are shown: nodes as the scene lists them, primitives as their mesh lists them.
    pub parts: Vec<Part>,
    /// What was repaired on the way, or could not be.
    pub warnings: Vec<Warning>,
}

/// A run of vertices of one node. Primitives of a mesh that share their attributes share a block.
#[derive(Clone, Debug)]
pub struct Block {
    /// The node that shows it.
    pub node: usize,
    /// That node's mesh.
    pub mesh: usize,
    /// The first of its vertices.
    pub first: usize,
    /// How many there are, at least 1.
    pub count: usize,
    /// The weights with which the mesh's morph targets are in the positions, one a target.
    pub weights: Vec<f32>,
    /// Unit normals in world space, if the input has normals.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Unit tangents in world space without their handedness, if the input has them besides normals; 0 where one is 0.
    pub tangents: Option<Vec<[f32; 3]>>,
    /// The first set of texture coordinates, if the input has one.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// The texture coordinates that the tangents belong to, where they are another set.
    pub(crate) tangent_uvs: Option<Vec<[f32; 2]>>,
    /// Normals in the mesh's space, morphs applied.
    pub(crate) local_normals: Option<Vec<[f32; 3]>>,
    /// Tangents in the mesh's space, morphs applied.
    pub(crate) local_tangents: Option<Vec<[f32; 3]>>,
    pub(crate) frame: Frame,
}

/// One primitive as a node shows it.
#[derive(Clone, Debug)]
pub struct Part {
    /// The node that shows it.
    pub node: usize,
    /// That node's mesh.
    pub mesh: usize,
    /// The primitive within the mesh.
    pub primitive: usize,
    /// Its material, if it has one.
    pub material: Option<usize>,
    /// Whether it has tangents, and a material that looks at them: one with a normal map, or with anisotropy.
    pub normal_mapped: bool,
    /// What its vertices are joined to.
    pub mode: Mode,
    /// Its vertices: an index into [`Rest::blocks`].
    pub block: usize,
    /// The first of its triangles in [`Rest::triangles`].
    pub first_triangle: usize,
    /// How many triangles it has.
    pub triangle_count: usize,
}

impl Gltf {
    /// Reads the rest geometry of the document's scene: the one that `scene` names, else the first, else all nodes.
    ///
    /// Positions are those of the rest: node transforms applied, skins as their joint nodes pose them (a skinned
    /// mesh ignores the transform of its own node), morph targets by the default weights of node or mesh.
    ///
    /// # Errors
    ///
    /// What is read here and malformed or larger than the limits; a scene without any vertex.
    pub fn rest(&self) -> Result<Rest, AssetError> {
        self.read_rest().map_err(|error| error.in_file(&self.file))
    }

    fn read_rest(&self) -> Result<Rest, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let mut rest = Rest::default();
        let graph = self.graph(&mut budget, &mut rest.warnings)?;
        let mut skins = BTreeMap::new();
        for &node in &graph.shown {
            self.check_instancing(node, &mut rest.warnings)?;
            let Some(mesh) = graph.nodes[node].mesh else { continue };
            let joints = match graph.nodes[node].skin {
                None => None,
                Some(index) => Some(match skins.entry(index) {
                    Entry::Occupied(known) => &*known.into_mut(),
                    Entry::Vacant(place) => {
                        let json = self.root().need("skins")?.item(index)?;
                        let nodes = graph.nodes.len();
                        let skin = Skin::read(self, json, nodes, &mut budget, &mut rest.warnings)?;
                        let mut matrices = Vec::new();
                        skin.matrices_into(&graph.world, &mut matrices);
                        &*place.insert(Arc::from(matrices))
                    }
                }),
            };
            let shown = Shown { gltf: self, graph: &graph, node, mesh, joints };
            shown.read(&mut rest, &mut budget)?;
        }
        if rest.positions.is_empty() {
            return Err(AssetError::file("a scene without any vertex", "geometry"));
        }
        merge_warnings(&mut rest.warnings);
        Ok(rest)
    }

    fn check_instancing(&self, node: usize, warnings: &mut Vec<Warning>) -> Result<(), AssetError> {
        const INSTANCING: &str = "EXT_mesh_gpu_instancing";
        let json = self.root().need("nodes")?.item(node)?;
        if json.value().get("extensions").is_some_and(|extensions| extensions.get(INSTANCING).is_some()) {
            let message = format!("{INSTANCING} is not evaluated: the mesh is read where its node is");
            warnings.push(Warning::new("instancing", json.place(), message));
        }
        Ok(())
    }
}

/// The same repair at the same place need not be told once an instance.
fn merge_warnings(warnings: &mut Vec<Warning>) {
    let mut seen = std::collections::BTreeSet::new();
    warnings.retain(|warning| seen.insert(warning.to_string()));
}

impl Rest {
    /// The triangles of the scene as a polygon mesh with these positions and normals of all vertices, for an OBJ file.
    /// A corner has the texture coordinates and the normal of its vertex, if there are any; `v` runs upwards.
    pub fn to_mesh(&self, positions: &[[f32; 3]], normals: Option<&[[f32; 3]]>) -> Mesh {
        let mut uvs = Vec::new();
        let mut uv_of: Vec<Option<u32>> = vec![None; positions.len()];
        for block in &self.blocks {
            let Some(list) = &block.uvs else { continue };
            for (slot, uv) in uv_of.iter_mut().skip(block.first).zip(list) {
                *slot = Some(uvs.len() as u32);
                uvs.push([uv[0], 1.0 - uv[1]]);
            }
        }
        let corner = |&position: &u32| Corner {
            position,
            uv: uv_of.get(position as usize).copied().flatten(),
            normal: normals.filter(|normals| (position as usize) < normals.len()).map(|_| position),
        };
        Mesh {
            positions: positions.to_vec(),
            uvs,
            normals: normals.map(<[_]>::to_vec).unwrap_or_default(),
            corners: self.triangles.as_flattened().iter().map(corner).collect(),
            face_ends: (1..=self.triangles.len() as u32).map(|k| 3 * k).collect(),
        }
    }
}

impl Block {
    /// The texture coordinates that the tangents belong to: at each vertex those of the first normal map on a primitive that has it,
    /// else those of the block's first normal map, else the first set.
    pub fn tangent_uvs(&self) -> Option<&[[f32; 2]]> {
        let uvs = self.tangent_uvs.as_ref().or(self.uvs.as_ref());
        uvs.map(Vec::as_slice).filter(|uvs| uvs.len() == self.count)
    }

    /// Whether its triangles are turned round in the world.
    pub(crate) fn mirrored(&self) -> bool {
        self.frame.mirrored()
    }

    /// The matrices of its skin's joints, at rest; none without a skin.
    pub(crate) fn joints(&self) -> Option<&[DAffine3]> {
        match &self.frame {
            Frame::Node(_) => None,
            Frame::Skin { joints, .. } => Some(joints),
        }
    }
}
