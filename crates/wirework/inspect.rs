//! What is in an asset or a preset, as plain facts.

mod asset;
mod parts;

use serde::Serialize;
use wirework_preset::{
    Action, Effect, Mask, Object, Only, Parsed, PatchDeform, Piece, Preset, Shape, Stitching, Units,
};
use wirework_stitch::{Edge, Seam};

pub use asset::{RefusedAsset, inspect_asset};
pub(crate) use asset::{list, number};
pub use parts::{NodeFacts, PartFacts};

use crate::Engines;

/// What is in a glTF or OBJ file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AssetFacts {
    /// `glb`, `gltf` or `obj`; none where it is none of them.
    pub container: Option<&'static str>,
    /// Vertices that the scene shows, a mesh once for each of its nodes. None where the file is refused before.
    pub vertices: Option<usize>,
    /// Triangles that it shows.
    pub triangles: Option<usize>,
    /// The box round what is shown at rest, in world space.
    pub bounds: Option<BoundsFacts>,
    /// The borders of what is shown, the longest first, at most 64: seams run along them. Vertices at one place are one.
    pub borders: Vec<BorderFacts>,
    /// Nodes of the document; an OBJ has none.
    pub nodes: Option<usize>,
    /// Those of them that `only` of a preset can name to some effect.
    pub selectable_nodes: Vec<NodeFacts>,
    /// Objects and groups of an OBJ, which are its nodes; without any the file is one, with its own name.
    pub groups: Vec<PartFacts>,
    /// Meshes.
    pub meshes: Vec<MeshFacts>,
    /// Materials; in an OBJ those that it uses.
    pub materials: Vec<PartFacts>,
    /// Skins.
    pub skins: Vec<SkinFacts>,
    /// Animations.
    pub animations: Vec<AnimationFacts>,
    /// Extensions that are used.
    pub extensions_used: Vec<String>,
    /// Extensions that a reader must know.
    pub extensions_required: Vec<String>,
    /// What engines make of it; none of an OBJ, and of a file that is refused for anything but an extension.
    pub engines: Option<Engines>,
    /// What is not right, and what is done about it.
    pub warnings: Vec<String>,
    /// Why effects refuse it; of the rest there is what can be told nevertheless.
    pub refused: Option<String>,
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BoundsFacts {
    /// The least coordinates.
    pub min: [f32; 3],
    /// The greatest coordinates.
    pub max: [f32; 3],
}

/// A border: edges with a face on one side only, one after the other.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BorderFacts {
    /// How many vertices it has.
    pub vertices: usize,
    /// Its length, metres.
    pub length: f32,
    /// The middle of its box.
    pub middle: [f32; 3],
    /// One of its vertices.
    pub vertex: [f32; 3],
}

/// A mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MeshFacts {
    /// Its name.
    pub name: Option<String>,
    /// Its primitives.
    pub primitives: usize,
    /// Their vertices; those that primitives share count once.
    pub vertices: usize,
    /// Their triangles; in an OBJ those its polygons are cut into.
    pub triangles: usize,
    /// Its morph targets.
    pub morph_targets: usize,
    /// Those of its vertices that have a colour, which `mask: VertexColor(..)` reads.
    pub colored_vertices: usize,
    /// Those that have texture coordinates, at which `mask: Image(..)` is read.
    pub mapped_vertices: usize,
}

/// A skin.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SkinFacts {
    /// Its name.
    pub name: Option<String>,
    /// How many joints it has.
    pub joints: usize,
}

/// An animation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AnimationFacts {
    /// Its name.
    pub name: Option<String>,
    /// Its channels.
    pub channels: usize,
    /// The time of its last key, seconds.
    pub duration: f64,
}

/// What is in a preset.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PresetFacts {
    /// The kind of its own object, if it has one: `Grid`, `File` and so on.
    pub object: Option<&'static str>,
    /// Whether it runs on what it brings along, without an input.
    pub complete: bool,
    /// Its effects in their order, one unless it is a stack.
    pub effects: Vec<EffectFacts>,
    /// Its length in seconds.
    pub duration: f64,
    /// Whether anything moves in time.
    pub animated: bool,
    /// What is hardly meant.
    pub warnings: Vec<String>,
}

/// An effect of a preset.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct EffectFacts {
    /// `Deform`, `Wrinkle` or `Stitch`.
    pub effect: &'static str,
    /// How many wires it draws; those of a wire lattice count each, and each seam has two.
    pub wires: usize,
    /// The pieces that a stitch names.
    pub pieces: Vec<PieceFacts>,
    /// The seams of a stitch.
    pub seams: Vec<SeamFacts>,
    /// Cells of the lattice that the wires move, if there is one.
    pub lattice: Option<[u8; 3]>,
    /// What it may move, as in the preset; none: everything. Wires may have more of their own.
    pub only: Option<String>,
    /// Its painted falloff, as in the preset.
    pub mask: Option<String>,
    /// What its lengths are counted in: `Metres` or `Bounds`.
    pub units: &'static str,
}

/// A piece of a stitch.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PieceFacts {
    /// Its name.
    pub name: String,
    /// The kind of its object; none: the node of its name.
    pub object: Option<&'static str>,
}

/// A seam of a stitch.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SeamFacts {
    /// The names of the pieces whose edges `a` and `b` are.
    pub pieces: [String; 2],
    /// How many tears it has.
    pub tears: usize,
    /// Whether the result is one surface along it.
    pub weld: bool,
}

impl PresetFacts {
    /// The facts of a preset that has been read.
    pub fn of(parsed: &Parsed) -> Self {
        let preset = &parsed.preset;
        Self {
            object: preset.object.as_ref().map(of_object),
            complete: preset.object.is_some() || brings_pieces(preset),
            effects: preset.effects.iter().map(of_effect).collect(),
            duration: preset.duration,
            animated: preset.animated,
            warnings: parsed.warnings.iter().map(ToString::to_string).collect(),
        }
    }
}

/// Whether all that its stitch sews comes along as pieces with objects.
fn brings_pieces(preset: &Preset) -> bool {
    let pieces = preset.pieces();
    !pieces.is_empty() && pieces.iter().all(|piece| piece.object.is_some())
}

fn of_stitching(stitching: &Stitching) -> (Vec<PieceFacts>, Vec<SeamFacts>) {
    let piece = |piece: &Piece| PieceFacts {
        name: piece.name.name.clone(),
        object: piece.object.as_ref().map(of_object),
    };
    let name = |edge: &Edge| {
        stitching.pieces.get(edge.piece).map(|piece| piece.name.name.clone()).unwrap_or_default()
    };
    let seam = |seam: &Seam| SeamFacts {
        pieces: [name(&seam.a), name(&seam.b)],
        tears: seam.tears.len(),
        weld: seam.weld,
    };
    (stitching.pieces.iter().map(piece).collect(), stitching.stitch.seams.iter().map(seam).collect())
}

fn of_effect(effect: &Effect) -> EffectFacts {
    let (name, wires, lattice) = match &effect.action {
        Action::Deform(deform) => ("Deform", deform.wires.len(), deform.lattice.map(|lattice| lattice.cells)),
        Action::Wrinkle(wrinkle) => ("Wrinkle", wrinkle.crease_count(), None),
        Action::Stitch(stitching) => ("Stitch", 2 * stitching.stitch.seams.len(), None),
        Action::Ik(_) => ("Ik", 1, None),
    };
    let (pieces, seams) = match &effect.action {
        Action::Stitch(stitching) => of_stitching(stitching),
        _ => Default::default(),
    };
    let mask = |mask: &Mask| match mask {
        Mask::VertexColor { channel, .. } => format!("VertexColor({channel:?})"),
        Mask::Image { file, channel } => format!("Image({:?}, {channel:?})", file.name),
    };
    EffectFacts {
        effect: name,
        wires,
        pieces,
        seams,
        lattice,
        only: effect.only.as_ref().map(of_only),
        mask: effect.mask.as_ref().map(mask),
        units: match effect.units {
            Units::Metres => "Metres",
            Units::Bounds => "Bounds",
        },
    }
}

fn of_only(only: &Only) -> String {
    let kind = match only {
        Only::Nodes(_) => "Nodes",
        Only::Materials(_) => "Materials",
        Only::Joints(_) => "Joints",
    };
    let names: Vec<&str> = only.names().iter().map(|named| named.name.as_str()).collect();
    format!("{kind}({names:?})")
}

fn of_object(object: &Object) -> &'static str {
    match &object.shape {
        Shape::Grid { .. } => "Grid",
        Shape::Tube { .. } => "Tube",
        Shape::Sphere { .. } => "Sphere",
        Shape::Box { .. } => "Box",
        Shape::Points(_) => "Points",
        Shape::Patch { deform: PatchDeform::ControlPoints, .. } => "Patch (control points)",
        Shape::Patch { .. } => "Patch",
        Shape::File(_) => "File",
    }
}
