//! What is in an asset or a preset, as plain facts.

mod parts;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;
use serde_json::Value;
use wirework_asset::{Gltf, Limits};
use wirework_preset::{Action, Effect, Mask, Object, Only, Parsed, PatchDeform, Shape, Units};
use wirework_surface::Bounds;

use crate::JobError;
use crate::subject::{Model, Subject};

pub use parts::{NodeFacts, PartFacts};
use parts::{broken_colors, groups, materials, named_parts, nodes, of_mesh};

/// What is in a glTF or OBJ file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AssetFacts {
    /// `glb`, `gltf` or `obj`.
    pub container: &'static str,
    /// Vertices that the scene shows, a mesh once for each of its nodes.
    pub vertices: usize,
    /// Triangles that it shows.
    pub triangles: usize,
    /// The box round what is shown at rest, in world space.
    pub bounds: Option<BoundsFacts>,
    /// Nodes of the document.
    pub nodes: usize,
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
    /// What is not right, and what is done about it.
    pub warnings: Vec<String>,
    /// Why effects refuse it; nothing else is known then.
    pub refused: Option<String>,
}

impl AssetFacts {
    /// The facts of a file that [`inspect_asset`] refuses.
    pub fn of_refused(error: &JobError) -> Self {
        Self { refused: Some(error.to_string()), ..Self::default() }
    }
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

/// Reads an asset, its geometry too, and tells what is in it.
///
/// # Errors
///
/// As [`Subject::read`].
pub fn inspect_asset(path: &Path, limits: &Limits) -> Result<AssetFacts, JobError> {
    let subject = Subject::read(path, limits)?;
    let mut warnings = subject.warnings();
    let mut facts = match &subject.model {
        Model::Mesh { mesh, name, obj } => AssetFacts {
            container: "obj",
            meshes: vec![of_mesh(mesh, obj.as_deref(), subject.triangles.len(), &mut warnings)],
            groups: groups(name, mesh, obj.as_deref()),
            materials: obj.as_ref().map_or_else(Vec::new, |obj| named_parts(obj.material_census())),
            ..AssetFacts::default()
        },
        Model::Gltf { gltf, rest } => AssetFacts {
            selectable_nodes: nodes(gltf, rest)?,
            materials: materials(gltf, rest)?,
            ..of_document(gltf, path)
        },
    };
    if let Model::Gltf { gltf, rest } = &subject.model
        && facts.meshes.iter().any(|mesh| mesh.colored_vertices > 0)
    {
        warnings.extend(gltf.colors(rest).err().map(|error| broken_colors(&error)));
    }
    facts.vertices = subject.position_count();
    facts.triangles = subject.triangles.len();
    facts.bounds = Bounds::of(&subject.points).map(|b| BoundsFacts { min: b.min, max: b.max });
    facts.warnings = warnings;
    Ok(facts)
}

fn of_document(gltf: &Gltf, path: &Path) -> AssetFacts {
    let json = gltf.json();
    let names =
        |key: &str| list(json, key).iter().filter_map(|name| name.as_str().map(str::to_owned)).collect();
    let skin = |skin: &Value| SkinFacts { name: name(skin), joints: list(skin, "joints").len() };
    let mut magic = [0; 4];
    let binary =
        File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok_and(|()| &magic == b"glTF");
    AssetFacts {
        container: if binary { "glb" } else { "gltf" },
        nodes: gltf.node_count(),
        meshes: list(json, "meshes").iter().map(|mesh| of_gltf_mesh(json, mesh)).collect(),
        skins: list(json, "skins").iter().map(skin).collect(),
        animations: list(json, "animations").iter().map(|animation| of_animation(json, animation)).collect(),
        extensions_used: names("extensionsUsed"),
        extensions_required: names("extensionsRequired"),
        ..AssetFacts::default()
    }
}

fn of_gltf_mesh(json: &Value, mesh: &Value) -> MeshFacts {
    let count = |accessor: Option<usize>| {
        let accessor = accessor.and_then(|index| list(json, "accessors").get(index));
        accessor.and_then(|accessor| number(accessor, "count")).unwrap_or(0)
    };
    let primitives = list(mesh, "primitives");
    let mut facts = MeshFacts { name: name(mesh), primitives: primitives.len(), ..MeshFacts::default() };
    // Positions, each with whether a primitive has colours or texture coordinates for them.
    let mut seen: BTreeMap<Option<usize>, (bool, bool)> = BTreeMap::new();
    for primitive in primitives {
        let attribute = |key| primitive.get("attributes").and_then(|attributes| number(attributes, key));
        let position = attribute("POSITION");
        let (colored, mapped) = seen.entry(position).or_default();
        *colored |= attribute("COLOR_0").is_some();
        *mapped |= attribute("TEXCOORD_0").is_some();
        let corners =
            number(primitive, "indices").map_or_else(|| count(position), |index| count(Some(index)));
        facts.triangles += match number(primitive, "mode").unwrap_or(4) {
            4 => corners / 3,
            5 | 6 => corners.saturating_sub(2),
            _ => 0,
        };
        facts.morph_targets = facts.morph_targets.max(list(primitive, "targets").len());
    }
    for (position, (colored, mapped)) in seen {
        let vertices = count(position);
        facts.vertices += vertices;
        facts.colored_vertices += if colored { vertices } else { 0 };
        facts.mapped_vertices += if mapped { vertices } else { 0 };
    }
    facts
}

fn of_animation(json: &Value, animation: &Value) -> AnimationFacts {
    let end = |sampler: &Value| {
        let input = list(json, "accessors").get(number(sampler, "input")?)?;
        list(input, "max").first()?.as_f64()
    };
    AnimationFacts {
        name: name(animation),
        channels: list(animation, "channels").len(),
        duration: list(animation, "samplers").iter().filter_map(end).fold(0.0, f64::max),
    }
}

fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn name(json: &Value) -> Option<String> {
    json.get("name")?.as_str().map(str::to_owned)
}

fn number(json: &Value, key: &str) -> Option<usize> {
    json.get(key)?.as_u64()?.try_into().ok()
}

/// What is in a preset.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PresetFacts {
    /// The kind of its own object, if it has one: `Grid`, `File` and so on.
    pub object: Option<&'static str>,
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
    /// `Deform` or `Wrinkle`.
    pub effect: &'static str,
    /// How many wires it draws; those of a wire lattice count each.
    pub wires: usize,
    /// Cells of the lattice that the wires move, if there is one.
    pub lattice: Option<[u8; 3]>,
    /// What it may move, as in the preset; none: everything. Wires may have more of their own.
    pub only: Option<String>,
    /// Its painted falloff, as in the preset.
    pub mask: Option<String>,
    /// What its lengths are counted in: `Metres` or `Bounds`.
    pub units: &'static str,
}

impl PresetFacts {
    /// The facts of a preset that has been read.
    pub fn of(parsed: &Parsed) -> Self {
        let preset = &parsed.preset;
        Self {
            object: preset.object.as_ref().map(of_object),
            effects: preset.effects.iter().map(of_effect).collect(),
            duration: preset.duration,
            animated: preset.animated,
            warnings: parsed.warnings.iter().map(ToString::to_string).collect(),
        }
    }
}

fn of_effect(effect: &Effect) -> EffectFacts {
    let (name, wires, lattice) = match &effect.action {
        Action::Deform(deform) => ("Deform", deform.wires.len(), deform.lattice.map(|lattice| lattice.cells)),
        Action::Wrinkle(wrinkle) => ("Wrinkle", wrinkle.crease_count(), None),
    };
    let mask = |mask: &Mask| match mask {
        Mask::VertexColor { channel, .. } => format!("VertexColor({channel:?})"),
        Mask::Image { file, channel } => format!("Image({:?}, {channel:?})", file.name),
    };
    EffectFacts {
        effect: name,
        wires,
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
