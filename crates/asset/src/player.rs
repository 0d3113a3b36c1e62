//! A clip played: where all vertices are at any time of it.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::{DAffine3, DVec3};

use crate::attributes::{self, Local};
use crate::channels::Channel;
use crate::document::Gltf;
use crate::error::{AssetError, ErrorClass, Place, Warning};
use crate::graph::{Graph, Pose};
use crate::json::Json;
use crate::limits::{Budget, Of};
use crate::local::LocalDeltas;
use crate::rest::{Block, Part, Rest};
use crate::shown::default_weights;
use crate::skin::{Influences, Skin};
use crate::track::Path;
use crate::way::{Way, double, place};

/// Plays one clip of a document, or none.
///
/// All that a clip needs is read and checked when the player is made, but for morph targets: they are read at the
/// times at which they count.
#[derive(Clone, Debug)]
pub struct Player<'a> {
    pub(crate) gltf: &'a Gltf,
    pub(crate) graph: Graph,
    pub(crate) channels: Vec<Channel>,
    pub(crate) skins: Vec<Posed>,
    pub(crate) shapes: Vec<Shape<'a>>,
    /// One a block of the rest.
    pub(crate) pieces: Vec<Piece>,
    /// The weights of the morph targets of each node that shows some.
    pub(crate) weights: BTreeMap<usize, Vec<f64>>,
    warnings: Vec<Warning>,
    /// The vertices of a shape, morphed; kept for its memory.
    pub(crate) morphed: Local,
}

/// A skin with its matrices at the time that was played last.
#[derive(Clone, Debug)]
pub(crate) struct Posed {
    pub(crate) skin: Skin,
    pub(crate) matrices: Vec<DAffine3>,
}

/// The vertices of a primitive, for all nodes that show it by the same skin.
#[derive(Clone, Debug)]
pub(crate) struct Shape<'a> {
    pub(crate) primitive: Json<'a>,
    pub(crate) base: Local,
    influences: Option<Influences>,
    /// Tangents without morph targets, once they were asked for.
    pub(crate) tangents: Option<Vec<[f32; 3]>>,
}

/// A block of the rest: how a node shows a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) node: usize,
    pub(crate) shape: usize,
    pub(crate) skin: Option<usize>,
}

impl Gltf {
    /// A player of `clip`, an index into [`Gltf::clip_names`], for the vertices of `rest`, the rest of this document.
    /// Without a clip it plays the rest.
    ///
    /// Channels that move no property of a node, as those of `KHR_animation_pointer`, are passed over with a warning.
    ///
    /// # Errors
    ///
    /// A clip that is not there or is malformed: times that fall, values of another type or number, two channels of
    /// one property, a channel of a node that has a matrix. What [`Gltf::rest`] refuses; the limits.
    pub fn player(&self, rest: &Rest, clip: Option<usize>) -> Result<Player<'_>, AssetError> {
        self.read_player(rest, clip).map_err(|error| error.in_file(&self.file))
    }

    fn read_player(&self, rest: &Rest, clip: Option<usize>) -> Result<Player<'_>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        // What is wrong with nodes and meshes was told when the rest was read.
        let mut told = Vec::new();
        let graph = self.graph(&mut budget, &mut told)?;
        let mut warnings = Vec::new();
        let channels = match clip {
            None => Vec::new(),
            Some(clip) => self.channels(clip, &graph, &mut budget, &mut warnings)?,
        };
        let mut reader = Reader { gltf: self, graph: &graph, budget, skins: Vec::new(), shapes: Vec::new() };
        let (mut known_skins, mut known_shapes) = (BTreeMap::new(), BTreeMap::new());
        let (mut pieces, mut weights) = (Vec::new(), BTreeMap::new());
        let mut first = 0;
        for (block, part) in rest.blocks.iter().zip(rest.first_parts()) {
            let part = part.filter(|part| reader.fits(part, block) && block.first == first);
            let Some(part) = part else { return Err(other_document()) };
            let skin = match graph.nodes[part.node].skin {
                None => None,
                Some(index) => Some(match known_skins.entry(index) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(slot) => *slot.insert(reader.skin(index)?),
                }),
            };
            let shape = match known_shapes.entry((part.mesh, part.primitive, skin)) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(slot) => *slot.insert(reader.shape(part, block.count, skin)?),
            };
            if let Entry::Vacant(slot) = weights.entry(part.node) {
                slot.insert(reader.weights(part)?);
            }
            pieces.push(Piece { node: part.node, shape, skin });
            first += block.count;
        }
        let Reader { skins, shapes, .. } = reader;
        let morphed = Local::default();
        Ok(Player { gltf: self, graph, channels, skins, shapes, pieces, weights, warnings, morphed })
    }
}

pub(crate) fn other_document() -> AssetError {
    AssetError::file("vertices of another document", "the rest of this one")
}

/// Reads what a player needs of the document.
struct Reader<'a, 'g> {
    gltf: &'a Gltf,
    graph: &'g Graph,
    budget: Budget,
    skins: Vec<Posed>,
    shapes: Vec<Shape<'a>>,
}

impl Reader<'_, '_> {
    /// Whether the document has the node of a part, and it shows the part's mesh.
    fn fits(&self, part: &Part, block: &Block) -> bool {
        let node = self.graph.nodes.get(part.node);
        part.node == block.node && node.is_some_and(|node| node.mesh == Some(part.mesh))
    }

    fn skin(&mut self, index: usize) -> Result<usize, AssetError> {
        let json = self.gltf.root().need("skins")?.item(index)?;
        let skin = Skin::read(self.gltf, json, self.graph.nodes.len(), &mut self.budget, &mut Vec::new())?;
        self.skins.push(Posed { skin, matrices: Vec::new() });
        Ok(self.skins.len() - 1)
    }

    fn shape(&mut self, part: &Part, count: usize, skin: Option<usize>) -> Result<usize, AssetError> {
        let primitive = self.gltf.primitive(part)?;
        let mut told = Vec::new();
        attributes::check(self.gltf, primitive)?;
        let base = Local::read(self.gltf, primitive, &mut self.budget, &mut told)?;
        if base.positions.len() != count {
            return Err(other_document());
        }
        let influences = match skin.and_then(|skin| self.skins.get(skin)) {
            None => None,
            Some(Posed { skin, .. }) => {
                let attributes = primitive.need("attributes")?;
                let joints = skin.joints.len();
                let budget = &mut self.budget;
                Some(Influences::read(self.gltf, attributes, count, joints, budget, &mut told)?)
            }
        };
        self.shapes.push(Shape { primitive, base, influences, tangents: None });
        Ok(self.shapes.len() - 1)
    }

    /// The default weights of the node of a part.
    fn weights(&self, part: &Part) -> Result<Vec<f64>, AssetError> {
        let mesh = self.gltf.root().need("meshes")?.item(part.mesh)?;
        let targets = attributes::target_count(mesh.need("primitives")?)?;
        let own = self.graph.nodes[part.node].weights.as_deref();
        default_weights(self.gltf, part.node, own, mesh, targets)
    }
}

impl Player<'_> {
    /// The last key of the clip, seconds; 0 without a clip.
    pub fn duration(&self) -> f64 {
        self.channels.iter().map(|channel| channel.track.end()).fold(0.0, f64::max)
    }

    /// Whether anything may change in time: a track with more than one key.
    pub fn moves(&self) -> bool {
        self.channels.iter().any(|channel| channel.track.moves())
    }

    /// What was passed over, or repaired, in the clip.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Where all vertices are at a time of the clip, in world space and in the order of [`Rest::positions`], and their
    /// normals: of length 1, or 0 in blocks without normals. Times outside the keys are those of the nearest key.
    ///
    /// `deltas`, one entry a block as [`Rest::to_local`] gives them, are added to the vertices of the meshes as a morph
    /// target of weight 1 would be: skins and nodes take them along. Entries that are missing move nothing.
    ///
    /// Without a clip and deltas the positions are those of the rest, bit for bit. Triangles stay those of the rest.
    ///
    /// # Errors
    ///
    /// A place beyond the range of floats, morph targets with numbers that are not finite, the limits. What is in
    /// `positions` and `normals` then is no whole pose.
    pub fn pose_into(
        &mut self,
        seconds: f64,
        deltas: Option<&[LocalDeltas]>,
        positions: &mut Vec<[f32; 3]>,
        normals: &mut Vec<[f32; 3]>,
    ) -> Result<(), AssetError> {
        let file = &self.gltf.file;
        self.pose(seconds, deltas, positions, normals).map_err(|error| error.in_file(file))
    }

    fn pose(
        &mut self,
        seconds: f64,
        deltas: Option<&[LocalDeltas]>,
        positions: &mut Vec<[f32; 3]>,
        normals: &mut Vec<[f32; 3]>,
    ) -> Result<(), AssetError> {
        self.settle(seconds)?;
        let count: usize =
            self.pieces.iter().map(|piece| self.shapes[piece.shape].base.positions.len()).sum();
        let mut budget = Budget::new(&self.gltf.limits);
        // Positions and normals, and once more those that are morphed.
        budget.charge(Of::ExpandedBytes, count as u64 * 48, || Place::File)?;
        for out in [&mut *positions, &mut *normals] {
            out.clear();
            out.try_reserve(count).map_err(|_| {
                AssetError::file(format!("{count} vertices"), "vertices that fit into memory")
                    .of_class(ErrorClass::Limit)
            })?;
        }
        for (index, piece) in self.pieces.iter().enumerate() {
            let shape = &self.shapes[piece.shape];
            let weights = self.weights.get(&piece.node).map_or(&[][..], Vec::as_slice);
            let local = shape.morphed(self.gltf, weights, &mut self.morphed, &mut budget)?;
            let matrices = piece.skin.map(|skin| self.skins[skin].matrices.as_slice());
            let posed = Pieced { local, influences: shape.influences.as_ref().zip(matrices) };
            let none = LocalDeltas::default();
            let deltas = deltas.and_then(|deltas| deltas.get(index)).unwrap_or(&none);
            posed.place(&self.graph.world[piece.node], deltas, positions, normals).map_err(|found| {
                shape.primitive.found(format!("{found} at {seconds} s"), "vertices in the range of floats")
            })?;
        }
        Ok(())
    }

    /// Takes nodes, skins and weights to a time.
    pub(crate) fn settle(&mut self, seconds: f64) -> Result<(), AssetError> {
        for Channel { node, path, track } in &self.channels {
            if let Path::Weights(_) = path {
                if let Some(weights) = self.weights.get_mut(node) {
                    track.sample(seconds, weights);
                }
                continue;
            }
            // A node with a matrix has no track.
            let Pose::Parts { translation, rotation, scale } = &mut self.graph.nodes[*node].pose else {
                continue;
            };
            match path {
                Path::Translation => *translation = track.vector(seconds),
                Path::Rotation => *rotation = track.rotation(seconds),
                _ => *scale = track.vector(seconds),
            }
        }
        self.graph.settle().map_err(|node| {
            let found = format!("a transform that overflows at {seconds} s");
            AssetError::new(Place::Pointer(format!("/nodes/{node}")), found, "finite transforms")
        })?;
        for Posed { skin, matrices } in &mut self.skins {
            skin.matrices_into(&self.graph.world, matrices);
        }
        Ok(())
    }
}

impl Shape<'_> {
    /// The vertices with these weights of morph targets, in `buffer` where any of them counts.
    pub(crate) fn morphed<'b>(
        &'b self,
        gltf: &Gltf,
        weights: &[f64],
        buffer: &'b mut Local,
        budget: &mut Budget,
    ) -> Result<&'b Local, AssetError> {
        if weights.iter().all(|&weight| weight == 0.0) {
            return Ok(&self.base);
        }
        buffer.positions.clone_from(&self.base.positions);
        buffer.normals.clone_from(&self.base.normals);
        buffer.morph(gltf, self.primitive, weights, budget)?;
        Ok(buffer)
    }
}

/// The vertices of a piece at a time, in the space of the mesh, and what takes those of a skin to the world.
struct Pieced<'b> {
    local: &'b Local,
    influences: Option<(&'b Influences, &'b [DAffine3])>,
}

impl Pieced<'_> {
    /// Appends vertices and normals in the world; `node` is where the node is.
    fn place(
        &self,
        node: &DAffine3,
        deltas: &LocalDeltas,
        positions: &mut Vec<[f32; 3]>,
        normals: &mut Vec<[f32; 3]>,
    ) -> Result<(), &'static str> {
        let normal_deltas = deltas.normals.as_deref().unwrap_or(&[]);
        let rigid = Way::new(node);
        for (v, &p) in self.local.positions.iter().enumerate() {
            let skinned = self.influences.map(|(influences, joints)| influences.matrix(v, joints));
            positions.push(place(skinned.as_ref().unwrap_or(node), moved(p, deltas.positions.get(v)))?);
            let normal = self.local.normals.as_ref().and_then(|normals| normals.get(v));
            normals.push(normal.map_or([0.0; 3], |&n| {
                let way = skinned.as_ref().map_or(rigid, Way::new);
                way.normal(moved(n, normal_deltas.get(v)))
            }));
        }
        Ok(())
    }
}

/// A vector and what is added to it; where that is nothing its bits stay.
fn moved(v: [f32; 3], delta: Option<&[f32; 3]>) -> DVec3 {
    match delta {
        Some(&delta) if delta != [0.0; 3] => double(v) + double(delta),
        _ => double(v),
    }
}
