//! Tangents: which materials look at them, how they are read, and the way back to the space of their mesh.

use std::ops::Range;

use serde_json::{Map, Value};

use crate::accessor::{Accessor, Component};
use crate::attributes::{QUANTIZATION, add, texture_coordinates};
use crate::document::Gltf;
use crate::edit::whole;
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::limits::{Budget, filled};

/// Its direction is relative to the tangents, with or without a texture.
const ANISOTROPY: &str = "KHR_materials_anisotropy";

impl Gltf {
    /// The set of texture coordinates whose tangents the materials of a primitive look at: those of the first normal map.
    /// None where no material looks at tangents.
    ///
    /// A material that `KHR_materials_variants` offers counts as one of its own does: a viewer may choose it. A malformed one is
    /// none: materials are not what an effect reads.
    pub(crate) fn tangent_set(&self, primitive: Json<'_>) -> Option<usize> {
        let primitive = primitive.value();
        let mappings = primitive.pointer("/extensions/KHR_materials_variants/mappings");
        let offered = mappings.and_then(Value::as_array).into_iter().flatten();
        let materials = std::iter::once(primitive).chain(offered).filter_map(|holder| holder.get("material"));
        let mut materials = materials.filter_map(|material| self.list("materials").get(whole(material)?));
        materials.find_map(set_of)
    }
}

/// The set of texture coordinates of the first normal map of a material: its own, else that of an extension.
fn set_of(material: &Value) -> Option<usize> {
    if let Some(set) = material.as_object().and_then(normal_map) {
        return Some(set);
    }
    let extensions = material.get("extensions")?.as_object()?;
    let map = extensions.values().filter_map(Value::as_object).find_map(normal_map);
    let brushed = || {
        let texture = extensions.get(ANISOTROPY)?.get("anisotropyTexture");
        Some(texture.map_or(0, texture_set))
    };
    map.or_else(brushed)
}

/// The set of a member such as `normalTexture` or `clearcoatNormalTexture`.
fn normal_map(holder: &Map<String, Value>) -> Option<usize> {
    let is_map = |key: &str| key == "normalTexture" || key.ends_with("NormalTexture");
    holder.iter().find(|(key, _)| is_map(key)).map(|(_, info)| texture_set(info))
}

fn texture_set(info: &Value) -> usize {
    let moved = info.pointer("/extensions/KHR_texture_transform/texCoord");
    moved.or_else(|| info.get("texCoord")).and_then(whole).unwrap_or(0)
}

/// The tangents of a primitive in the space of its mesh, without handedness and without its morph targets.
///
/// None without normals, for the standard then has tangents ignored, and, with a warning, where they are not what the standard
/// asks for: a file whose tangents nobody looks at is not refused for them.
pub(crate) fn read(
    gltf: &Gltf,
    primitive: Json<'_>,
    budget: &mut Budget,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Vec<[f32; 3]>>, AssetError> {
    let attributes = primitive.need("attributes")?;
    let (Some(reference), Some(_)) = (attributes.get("TANGENT")?, attributes.get("NORMAL")?) else {
        return Ok(None);
    };
    let accessor = gltf.accessor(reference)?;
    let values = if fits(gltf, &accessor) { accessor.floats::<4>(budget)? } else { Vec::new() };
    if values.len() != accessor.count || values.as_flattened().iter().any(|c| !c.is_finite()) {
        let message = "the tangents are not four finite numbers a vertex; they are left as they are";
        warnings.push(Warning::new("tangents", accessor.json.place(), message));
        return Ok(None);
    }
    Ok(Some(values.iter().map(|&[x, y, z, _]| [x, y, z]).collect()))
}

/// Adds the morph targets of a primitive to its tangents, each times its weight.
pub(crate) fn morph(
    gltf: &Gltf,
    primitive: Json<'_>,
    weights: &[f64],
    tangents: &mut Vec<[f32; 3]>,
    budget: &mut Budget,
) -> Result<(), AssetError> {
    let Some(targets) = primitive.get("targets")? else { return Ok(()) };
    for (target, &weight) in targets.items()?.zip(weights) {
        add(gltf, target.get("TANGENT")?, weight, Some(tangents), budget)?;
    }
    Ok(())
}

/// A primitive with a normal map.
pub(crate) struct Mapped<'a> {
    pub(crate) primitive: Json<'a>,
    /// The set of texture coordinates of the map.
    pub(crate) set: usize,
    /// Its triangles among those of the scene.
    pub(crate) triangles: Range<usize>,
}

/// The texture coordinates that the tangents of a block belong to, the vertices `range` of a scene with these `triangles`;
/// nothing where that is the first set. Primitives of it may be `mapped` on different sets: a vertex takes that of the first one
/// that has it, and what none has that of the first of all. A set that is not there is nothing or zeros.
pub(crate) fn coordinates(
    gltf: &Gltf,
    mapped: &[Mapped<'_>],
    range: Range<usize>,
    triangles: &[[u32; 3]],
    budget: &mut Budget,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Vec<[f32; 2]>>, AssetError> {
    let mut read = |primitive, set| texture_coordinates(gltf, primitive, set, budget, warnings);
    let first = match mapped.first() {
        Some(first) if mapped.iter().any(|other| other.set != 0) => first,
        _ => return Ok(None),
    };
    let mut out = read(first.primitive, first.set)?.unwrap_or_default();
    if mapped.iter().all(|other| other.set == first.set) {
        return Ok(Some(out));
    }
    out.resize(range.len(), [0.0; 2]);
    let mut taken = filled(range.len(), false)?;
    for Mapped { primitive, set, triangles: own } in mapped {
        let uvs = if *set == first.set { None } else { Some(read(*primitive, *set)?.unwrap_or_default()) };
        for &vertex in triangles.get(own.clone()).unwrap_or(&[]).as_flattened() {
            let v = vertex as usize - range.start;
            if !std::mem::replace(&mut taken[v], true)
                && let Some(uvs) = &uvs
            {
                out[v] = uvs.get(v).copied().unwrap_or_default();
            }
        }
    }
    Ok(Some(out))
}

fn fits(gltf: &Gltf, accessor: &Accessor<'_>) -> bool {
    let float = accessor.component == Component::F32 && !accessor.normalized;
    let small = !matches!(accessor.component, Component::F32 | Component::U32) && gltf.uses(QUANTIZATION);
    accessor.lanes == 4 && (float || small)
}
