//! Reading an asset for what is in it, as far as it goes.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;
use thiserror::Error;
use wirework_asset::{Gltf, Limits, Obj, Outline, Place, Rest, Warning, printable};
use wirework_bake::{CROWDED, Settings};
use wirework_stitch::border_loops;
use wirework_surface::{Bounds, Mesh};

use super::parts::{broken_colors, groups, materials, named_parts, nodes, of_mesh};
use super::{AnimationFacts, AssetFacts, BorderFacts, BoundsFacts, MeshFacts, PartFacts, SkinFacts};
use crate::engines::{engines, of_json};
use crate::evaluate::{bounds_frame, has_extent};
use crate::subject::{FileKind, Model, Subject};
use crate::{JobError, MeshPart};

/// An asset that effects refuse, and what can be told of it nevertheless.
#[derive(Debug, Error)]
#[error("{error}")]
#[non_exhaustive]
pub struct RefusedAsset {
    /// What was read before, and why it is refused.
    pub facts: AssetFacts,
    /// Why it is refused.
    pub error: JobError,
}

/// Reads an asset, its geometry too, and tells what is in it.
///
/// # Errors
///
/// As [`Subject::read`], with what could be read before.
pub fn inspect_asset(path: &Path, limits: &Limits) -> Result<AssetFacts, Box<RefusedAsset>> {
    let refused = |facts: AssetFacts, error: JobError| {
        let facts = AssetFacts { refused: Some(error.to_string()), ..facts };
        Box::new(RefusedAsset { facts, error })
    };
    let subject =
        Subject::read(path, limits).map_err(|error| refused(outline(path, limits, &error), error))?;
    let mut facts = match &subject.model {
        Model::Mesh { mesh, parts, obj } => of_obj(parts, mesh, obj.as_deref(), &subject),
        Model::Gltf { gltf, rest } => {
            let mut facts = of_document(gltf.json(), gltf.is_binary());
            facts.warnings = subject.warnings();
            facts.engines = Some(engines(gltf));
            match of_scene(gltf, rest, &mut facts) {
                Ok(()) => facts,
                Err(error) => {
                    // Of a file that is refused nothing is repaired or passed through.
                    let AssetFacts { warnings, .. } = outline(path, limits, &error);
                    return Err(refused(AssetFacts { warnings, engines: None, ..facts }, error));
                }
            }
        }
    };
    facts.vertices = Some(subject.position_count());
    facts.triangles = Some(subject.triangles.len());
    facts.borders = borders(&subject.points, &subject.triangles);
    facts.bounds = Bounds::of(&subject.points).map(|b| BoundsFacts { min: b.min, max: b.max });
    if !has_extent(&bounds_frame(subject.bounds())) {
        let file = printable(&path.display().to_string());
        let found = "all points are at one place: effects in `units: Bounds` refuse it";
        facts.warnings.push(format!("{file}: {found} [no-extent]"));
    }
    Ok(facts)
}

/// More borders than this nobody sews; a mesh of loose triangles has as many as it has faces.
const MOST_BORDERS: usize = 64;

fn borders(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<BorderFacts> {
    let of = |vertices: Vec<u32>| {
        let places: Vec<[f32; 3]> = vertices.iter().map(|&vertex| points[vertex as usize]).collect();
        let next = places.iter().cycle().skip(1);
        let step = |(p, q): (&[f32; 3], &[f32; 3])| {
            [0, 1, 2].map(|k| p[k] - q[k]).map(|c| c * c).iter().sum::<f32>().sqrt()
        };
        BorderFacts {
            vertices: vertices.len(),
            length: places.iter().zip(next).map(step).sum(),
            middle: Bounds::of(&places).map_or([0.0; 3], |bounds| bounds.center()),
            vertex: places.first().copied().unwrap_or_default(),
        }
    };
    let mut all: Vec<BorderFacts> = border_loops(triangles).into_iter().map(of).collect();
    all.sort_by(|a, b| b.length.total_cmp(&a.length));
    all.truncate(MOST_BORDERS);
    all
}

/// What can be told of a file that is refused, but for why it is.
fn outline(path: &Path, limits: &Limits, error: &JobError) -> AssetFacts {
    match FileKind::of(path) {
        Some(FileKind::Gltf) => {
            let Ok(outline) = Outline::read(path, limits) else { return AssetFacts::default() };
            let file = printable(&path.display().to_string());
            let other = |warning: &&Warning| !matches!(error, JobError::Asset(e) if e.place == warning.place);
            let warnings = outline.warnings.iter().filter(other);
            let warnings = warnings.map(|warning| format!("{file}: {warning}")).collect();
            // What else refuses an extension, its JSON tells.
            let engines = refuses_extension(error).then(|| of_json(&outline.json));
            AssetFacts { engines, warnings, ..of_document(&outline.json, outline.binary) }
        }
        Some(FileKind::Obj) if path.is_file() => {
            AssetFacts { container: Some("obj"), ..AssetFacts::default() }
        }
        _ => AssetFacts::default(),
    }
}

/// Whether it is an extension for which a document is refused.
fn refuses_extension(error: &JobError) -> bool {
    let JobError::Asset(error) = error else { return false };
    matches!(&error.place, Place::Pointer(pointer) if pointer.starts_with("/extensionsRequired"))
}

fn of_obj(parts: &[MeshPart], mesh: &Mesh, obj: Option<&Obj>, subject: &Subject) -> AssetFacts {
    let mut warnings = subject.warnings();
    AssetFacts {
        container: Some("obj"),
        meshes: vec![of_mesh(mesh, obj, subject.triangles.len(), &mut warnings)],
        groups: groups(parts, obj),
        materials: obj.map_or_else(Vec::new, |obj| named_parts(obj.material_census())),
        warnings,
        ..AssetFacts::default()
    }
}

/// What the geometry of a document says besides.
fn of_scene(gltf: &Gltf, rest: &Rest, facts: &mut AssetFacts) -> Result<(), JobError> {
    facts.selectable_nodes = nodes(gltf, rest)?;
    facts.materials = materials(gltf, rest)?;
    if facts.meshes.iter().any(|mesh| mesh.colored_vertices > 0) {
        facts.warnings.extend(gltf.colors(rest).err().map(|error| broken_colors(&error)));
    }
    let file = printable(gltf.file());
    let crowded = Settings::default().crowded(gltf, rest).into_iter();
    facts.warnings.extend(crowded.map(|warning| format!("{file}: {warning} [{CROWDED}]")));
    Ok(())
}

/// What the JSON of a document says.
fn of_document(json: &Value, binary: bool) -> AssetFacts {
    let names =
        |key: &str| list(json, key).iter().filter_map(|name| name.as_str().map(str::to_owned)).collect();
    let skin = |skin: &Value| SkinFacts { name: name(skin), joints: list(skin, "joints").len() };
    let material = |material: &Value| PartFacts { name: name(material), vertices: None };
    AssetFacts {
        container: Some(if binary { "glb" } else { "gltf" }),
        nodes: Some(list(json, "nodes").len()),
        meshes: list(json, "meshes").iter().map(|mesh| of_gltf_mesh(json, mesh)).collect(),
        materials: list(json, "materials").iter().map(material).collect(),
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

pub(crate) fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn name(json: &Value) -> Option<String> {
    json.get("name")?.as_str().map(str::to_owned)
}

pub(crate) fn number(json: &Value, key: &str) -> Option<usize> {
    json.get(key)?.as_u64()?.try_into().ok()
}
