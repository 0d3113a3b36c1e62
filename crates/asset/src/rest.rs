//! The rest geometry of a document: what its scene shows before the effect, in world space, and the way back from
//! the world to the space of each mesh.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use wirework_surface::{Corner, Mesh};

use crate::attributes::{self, Local};
use crate::document::Gltf;
use crate::error::{AssetError, ErrorClass, Warning};
use crate::graph::{Graph, floats};
use crate::json::Json;
use crate::limits::{Budget, Of};
use crate::primitive::Mode;
use crate::skin::{Influences, Skin};
use crate::tangent::{self, Mapped};
use crate::way::{Way, double, place, single};

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
    /// Unit normals in world space, if the input has normals.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Unit tangents in world space without their handedness, if the input has them besides normals; 0 where one is 0.
    pub tangents: Option<Vec<[f32; 3]>>,
    /// The first set of texture coordinates, if the input has one.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// The texture coordinates that the tangents belong to, where they are another set.
    tangent_uvs: Option<Vec<[f32; 2]>>,
    /// Normals in the mesh's space, morphs applied.
    local_normals: Option<Vec<[f32; 3]>>,
    /// Tangents in the mesh's space, morphs applied.
    local_tangents: Option<Vec<[f32; 3]>>,
    frame: Frame,
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

/// The transforms of a block.
#[derive(Clone, Debug)]
enum Frame {
    Node(Way),
    /// Those of vertices are blended when they are needed: to keep them takes six times the memory of their shares.
    Skin {
        influences: Influences,
        joints: Arc<[DAffine3]>,
        mirrored: bool,
    },
}

/// Displacements of a block in the space of its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalDeltas {
    /// What to add to each position of the mesh, exactly 0 where the world position is that of the rest.
    pub positions: Vec<[f32; 3]>,
    /// What to add to each normal; none where the block has no normals.
    pub normals: Option<Vec<[f32; 3]>>,
    /// What to add to each tangent, whose handedness stays; none where the block has no tangents.
    pub tangents: Option<Vec<[f32; 3]>>,
    /// How many vertices should have moved but cannot, because their transform is singular.
    pub stuck: usize,
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

/// A node that shows a mesh.
struct Shown<'a> {
    gltf: &'a Gltf,
    graph: &'a Graph,
    node: usize,
    mesh: usize,
    joints: Option<&'a Arc<[DAffine3]>>,
}

impl Shown<'_> {
    fn read(&self, rest: &mut Rest, budget: &mut Budget) -> Result<(), AssetError> {
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
        let local_tangents = tangent::read(self.gltf, primitive, weights, budget, &mut rest.warnings)?;
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
        let tangents = local_tangents.as_ref().map(|tangents| {
            tangents.iter().enumerate().map(|(v, &t)| frame.way(v).tangent(double(t))).collect()
        });
        if normals.is_none() && Mode::read(primitive)? as u8 >= Mode::Triangles as u8 {
            let message = "there are no normals; they are computed where they are needed";
            rest.warnings.push(Warning::new("normals-missing", attributes.place(), message));
        }
        rest.blocks.push(Block {
            node: self.node,
            mesh: self.mesh,
            first,
            count,
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
            let mut turns = 0;
            for (v, p) in local.iter_mut().enumerate() {
                let matrix = influences.matrix(v, joints);
                *p = place(&matrix, double(*p)).map_err(fault)?;
                turns += handedness(&matrix.matrix3.transpose());
                if let Some(normal) = normals.get_mut(v) {
                    *normal = Way::new(&matrix).normal(double(*normal));
                }
            }
            Frame::Skin { influences, joints: Arc::clone(joints), mirrored: turns < 0 }
        } else {
            let matrix = &self.graph.world[self.node];
            let way = Way::new(matrix);
            for p in &mut local {
                *p = place(matrix, double(*p)).map_err(fault)?;
            }
            for n in normals {
                *n = way.normal(double(*n));
            }
            Frame::Node(way)
        };
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

impl Frame {
    fn way(&self, vertex: usize) -> Cow<'_, Way> {
        match self {
            Self::Node(way) => Cow::Borrowed(way),
            Self::Skin { influences, joints, .. } => Cow::Owned(Way::new(&influences.matrix(vertex, joints))),
        }
    }

    /// Whether most of it turns right-handed into left-handed, which turns triangles round.
    fn mirrored(&self) -> bool {
        match self {
            Self::Node(way) => handedness(&way.transpose) < 0,
            Self::Skin { mirrored, .. } => *mirrored,
        }
    }
}

/// The sign of the determinant; 0 where there is none.
fn handedness(matrix: &DMat3) -> i64 {
    matrix.determinant().partial_cmp(&0.0).map_or(0, |order| order as i64)
}

impl Rest {
    /// Takes the deformed state of the vertices of `block` back to the space of its mesh.
    ///
    /// `positions`, `normals` and `tangents` are those of *all* vertices, as long as [`Rest::positions`], in world space. What
    /// equals the rest, bit for bit, gets deltas of exactly 0; elsewhere position + delta, taken through node or
    /// skin, is the deformed position, and normal + delta, of length 1, points along the deformed normal. So does tangent + delta
    /// along the tangent; one that is 0 stays as it is.
    pub fn to_local<'a>(
        &'a self,
        block: usize,
        positions: &[[f32; 3]],
        normals: Option<&'a [[f32; 3]]>,
        tangents: Option<&'a [[f32; 3]]>,
    ) -> LocalDeltas {
        let mut out = LocalDeltas::default();
        let Some(b) = self.blocks.get(block) else { return out };
        let range = b.first..b.first + b.count;
        let (Some(rest), Some(now)) = (self.positions.get(range.clone()), positions.get(range.clone()))
        else {
            return out;
        };
        let given = |list: Option<&'a [[f32; 3]]>| list.and_then(|list| list.get(range.clone()));
        let normals = Directions::new(b.normals.as_deref(), b.local_normals.as_deref(), given(normals));
        let tangents = Directions::new(b.tangents.as_deref(), b.local_tangents.as_deref(), given(tangents));
        out.positions.reserve_exact(b.count);
        let room = |_: &Directions<'_>| Vec::with_capacity(b.count);
        out.normals = normals.as_ref().map(room);
        out.tangents = tangents.as_ref().map(room);
        for (v, (p, q)) in rest.iter().zip(now).enumerate() {
            let delta = double(*q) - double(*p);
            let moves = delta != DVec3::ZERO;
            let [normal, tangent] = [&normals, &tangents].map(|list| list.as_ref().and_then(|d| d.turned(v)));
            let way = (moves || normal.is_some() || tangent.is_some()).then(|| b.frame.way(v));
            let way = way.as_deref();
            let inverse = way.and_then(|way| way.inverse);
            out.stuck += usize::from(moves && inverse.is_none());
            let local = inverse.filter(|_| moves).map_or(DVec3::ZERO, |inverse| inverse * delta);
            out.positions.push(clean(single(local)));
            // Normals go back by the transpose, what lies along the surface by the inverse.
            if let Some(list) = &mut out.normals {
                let back = way.filter(|_| inverse.is_some()).map(|way| way.transpose);
                list.push(direction_delta(back, normal));
            }
            if let Some(list) = &mut out.tangents {
                list.push(direction_delta(inverse, tangent));
            }
        }
        out
    }
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
}

/// Unit directions of a block: at rest in the world, in the mesh, and now in the world.
struct Directions<'a> {
    rest: &'a [[f32; 3]],
    base: &'a [[f32; 3]],
    now: &'a [[f32; 3]],
}

impl<'a> Directions<'a> {
    fn new(
        rest: Option<&'a [[f32; 3]]>,
        base: Option<&'a [[f32; 3]]>,
        now: Option<&'a [[f32; 3]]>,
    ) -> Option<Self> {
        Some(Self { rest: rest?, base: base?, now: now? })
    }

    /// The direction of a vertex in the mesh, and now in the world; nothing where it is that of the rest.
    fn turned(&self, v: usize) -> Option<[[f32; 3]; 2]> {
        let now = *self.now.get(v)?;
        (*self.rest.get(v)? != now).then_some([*self.base.get(v)?, now])
    }
}

/// What to add to a direction of a mesh so that it points, in the world, where it is to; `back` takes one back, but for its length.
fn direction_delta(back: Option<DMat3>, turned: Option<[[f32; 3]; 2]>) -> [f32; 3] {
    let (Some(back), Some([base, now])) = (back, turned) else { return [0.0; 3] };
    let target = (back * double(now)).normalize_or_zero();
    if target == DVec3::ZERO { [0.0; 3] } else { clean(single(target - double(base))) }
}

/// Turns `−0` into `0` and what is not finite into 0, so that equal deltas have equal bits.
fn clean(v: [f32; 3]) -> [f32; 3] {
    v.map(|c| if c.is_finite() { c + 0.0 } else { 0.0 })
}
