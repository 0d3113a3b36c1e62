//! The vertices of a primitive as its mesh stores them, and its morph targets.

use serde_json::Value;

use crate::accessor::{Accessor, Component};
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::limits::Budget;

/// The extension that lets positions and normals be small integers.
pub(crate) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// Vertices in the space of their mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Local {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
}

/// How many morph targets each primitive of a mesh has; all must have as many.
pub(crate) fn target_count(primitives: Json<'_>) -> Result<usize, AssetError> {
    let mut count = None;
    if primitives.array()?.is_empty() {
        return Err(primitives.fault("at least one primitive"));
    }
    for primitive in primitives.items()? {
        let targets = primitive.get("targets")?.map_or(Ok(0), |targets| targets.array().map(<[_]>::len))?;
        let expected = *count.get_or_insert(targets);
        if targets != expected {
            let expected = format!("{expected}, as the mesh's first primitive has");
            return Err(primitive.found(format!("{targets} morph targets"), expected));
        }
    }
    Ok(count.unwrap_or(0))
}

/// Checks that all attributes of a primitive and of its targets exist and are equally long. Gives which accessor
/// each of them is, by name, for two primitives with the same list have the same vertices.
pub(crate) fn check(gltf: &Gltf, primitive: Json<'_>) -> Result<Vec<(String, usize)>, AssetError> {
    let mut list = Vec::new();
    let mut count = None;
    let mut one = |name: String, reference: Json<'_>| -> Result<(), AssetError> {
        let accessor = gltf.accessor(reference)?;
        let (expected, ref first) = *count.get_or_insert((accessor.count, name.clone()));
        if accessor.count != expected {
            return Err(reference.found(
                format!("accessor {} of {} elements", accessor.index, accessor.count),
                format!("{expected} elements, as {first} has"),
            ));
        }
        list.push((name, accessor.index));
        Ok(())
    };
    for (name, reference) in primitive.need("attributes")?.members()? {
        one(name.to_owned(), reference)?;
    }
    if let Some(targets) = primitive.get("targets")? {
        for (i, target) in targets.items()?.enumerate() {
            for (name, reference) in target.members()? {
                one(format!("{name} of target {i}"), reference)?;
            }
        }
    }
    list.sort_unstable();
    Ok(list)
}

impl Local {
    /// Reads positions and normals, without morph targets.
    pub(crate) fn read(
        gltf: &Gltf,
        primitive: Json<'_>,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, AssetError> {
        let attributes = primitive.need("attributes")?;
        let accessor = vectors(gltf, attributes.need("POSITION")?)?;
        let positions = finite(&accessor, accessor.floats::<3>(budget)?)?;
        check_bounds(&accessor, &positions, warnings)?;
        let normals = match attributes.get("NORMAL")? {
            None => None,
            Some(reference) => {
                let accessor = vectors(gltf, reference)?;
                Some(finite(&accessor, accessor.floats::<3>(budget)?)?)
            }
        };
        Ok(Self { positions, normals })
    }

    /// Adds the morph targets of the primitive, each times its weight. Those of weight 0 are checked but not read.
    pub(crate) fn morph(
        &mut self,
        gltf: &Gltf,
        primitive: Json<'_>,
        weights: &[f64],
        budget: &mut Budget,
    ) -> Result<(), AssetError> {
        let Some(targets) = primitive.get("targets")? else { return Ok(()) };
        for (target, &weight) in targets.items()?.zip(weights) {
            add(gltf, target.get("POSITION")?, weight, Some(&mut self.positions), budget)?;
            add(gltf, target.get("NORMAL")?, weight, self.normals.as_mut(), budget)?;
        }
        Ok(())
    }
}

/// The accessor of positions, normals or their deltas.
pub(crate) fn vectors<'a>(gltf: &'a Gltf, reference: Json<'_>) -> Result<Accessor<'a>, AssetError> {
    let accessor = gltf.accessor(reference)?;
    let small = !matches!(accessor.component, Component::F32 | Component::U32) && gltf.uses(QUANTIZATION);
    let float = accessor.component == Component::F32 && !accessor.normalized;
    if accessor.lanes == 3 && (float || small) {
        return Ok(accessor);
    }
    let expected = format!("VEC3 of floats, or of small integers with {QUANTIZATION}");
    Err(accessor.json.found("an accessor of another type", expected))
}

fn finite(accessor: &Accessor<'_>, values: Vec<[f32; 3]>) -> Result<Vec<[f32; 3]>, AssetError> {
    if all_finite(values.as_flattened()) {
        return Ok(values);
    }
    match values.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
        Some(i) => Err(accessor.json.found(format!("element {i} is {:?}", values[i]), "finite numbers")),
        None => Ok(values),
    }
}

/// Whether all numbers are finite, asked many at a time: stopping at the first one that is not would be slower.
fn all_finite(values: &[f32]) -> bool {
    values.chunks(1024).all(|chunk| chunk.iter().fold(true, |all, c| all & c.is_finite()))
}

/// Adds `weight` times a morph target; a target of weight 0 is not read.
pub(crate) fn add(
    gltf: &Gltf,
    reference: Option<Json<'_>>,
    weight: f64,
    to: Option<&mut Vec<[f32; 3]>>,
    budget: &mut Budget,
) -> Result<(), AssetError> {
    let (Some(reference), Some(to)) = (reference, to) else { return Ok(()) };
    let accessor = vectors(gltf, reference)?;
    if weight == 0.0 {
        return Ok(());
    }
    let mut bad = None;
    accessor.each_float::<3>(budget, |i, delta| {
        if delta.iter().any(|d| !d.is_finite()) {
            bad.get_or_insert((i, delta));
        }
        for (c, d) in to.get_mut(i).into_iter().flatten().zip(delta) {
            *c = (f64::from(*c) + weight * f64::from(d)) as f32;
        }
    })?;
    match bad {
        Some((i, delta)) => Err(accessor.json.found(format!("element {i} is {delta:?}"), "finite numbers")),
        None => Ok(()),
    }
}

/// Missing or wrong bounds harm viewers, not us. What is no list of numbers was told when the document was read.
fn check_bounds(
    accessor: &Accessor<'_>,
    values: &[[f32; 3]],
    warnings: &mut Vec<Warning>,
) -> Result<(), AssetError> {
    if accessor.normalized {
        return Ok(());
    }
    let told = |key| {
        let stated = accessor.json.value().get(key);
        stated.is_some_and(|stated| !stated.as_array().is_some_and(|list| list.iter().all(Value::is_number)))
    };
    if told("min") || told("max") {
        return Ok(());
    }
    let (min, max) = bounds(values);
    let agrees = |key: &'static str, bound: [f32; 3]| -> Result<bool, AssetError> {
        let Some(stated) = accessor.json.get(key)? else { return Ok(false) };
        let Some(stated) = stated.value().as_array() else { return Ok(false) };
        let stated = stated.iter().map(|value| value.as_f64().map(|x| x as f32));
        Ok(stated.eq(bound.map(Some)))
    };
    if !(agrees("min", min)? && agrees("max", max)?) {
        let message = "min and max are missing or are not those of the data; they are not used";
        warnings.push(Warning::new("bounds", accessor.json.place(), message));
    }
    Ok(())
}

/// The least and the largest of each component.
pub(crate) fn bounds<const N: usize>(values: &[[f32; N]]) -> ([f32; N], [f32; N]) {
    /// Bounds that are kept side by side: those of every eighth value, so that none waits for the one before.
    const LANES: usize = 8;
    let first = values.first().copied().unwrap_or([0.0; N]);
    let (mut min, mut max) = ([first; LANES], [first; LANES]);
    let (groups, rest) = values.as_chunks::<LANES>();
    for group in groups {
        let (lows, highs) = (min.as_flattened_mut().iter_mut(), max.as_flattened_mut().iter_mut());
        for ((low, high), &c) in lows.zip(highs).zip(group.as_flattened()) {
            *low = if c < *low { c } else { *low };
            *high = if c > *high { c } else { *high };
        }
    }
    let fold = |all: &[[f32; N]], pick: fn(f32, f32) -> f32| {
        let pair = |a: [f32; N], b: &[f32; N]| std::array::from_fn(|k| pick(a[k], b[k]));
        all.iter().chain(rest).fold(first, pair)
    };
    (fold(&min, |a, b| if b < a { b } else { a }), fold(&max, |a, b| if b > a { b } else { a }))
}

/// A set of texture coordinates, if the primitive has it.
pub(crate) fn texture_coordinates(
    gltf: &Gltf,
    primitive: Json<'_>,
    set: usize,
    budget: &mut Budget,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Vec<[f32; 2]>>, AssetError> {
    let key = format!("TEXCOORD_{set}");
    let found = primitive.need("attributes")?.members()?.find(|(name, _)| *name == key);
    let Some((_, reference)) = found else { return Ok(None) };
    let accessor = gltf.accessor(reference)?;
    let uvs = if accessor.lanes == 2 { Some(accessor.floats::<2>(budget)?) } else { None };
    let uvs = uvs.filter(|uvs| all_finite(uvs.as_flattened()));
    if uvs.is_none() {
        let message = "the texture coordinates are no pairs of finite numbers; they are left as they are";
        warnings.push(Warning::new("texcoord", accessor.json.place(), message));
    }
    Ok(uvs)
}
