//! Skins: the matrix that takes a vertex of a skinned mesh to the world, blended from its joints.

use glam::{DAffine3, DMat3, DVec3};

use crate::accessor::Component;
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::graph::{Graph, affine};
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};

/// How far the sum of a vertex's weights may be from 1 before it is worth a warning: a unit of 8-bit weights.
const WEIGHT_SLACK: f64 = 1.0 / 255.0;

/// The matrices of a skin: joint world × inverse bind.
pub(crate) fn joint_matrices(
    gltf: &Gltf,
    skin: Json<'_>,
    graph: &Graph,
    budget: &mut Budget,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<DAffine3>, AssetError> {
    let joints = skin.need("joints")?;
    let count = joints.array()?.len();
    if count == 0 {
        return Err(joints.fault("at least one joint"));
    }
    budget
        .charge(Of::ExpandedBytes, count.saturating_mul(size_of::<DAffine3>()) as u64, || joints.place())?;
    let mut out = reserve(count)?;
    for joint in joints.items()? {
        out.push(graph.world[joint.index("node", graph.nodes.len())?]);
    }
    if let Some(reference) = skin.get("inverseBindMatrices")? {
        let accessor = gltf.accessor(reference)?;
        if accessor.component != Component::F32 || accessor.lanes != 16 {
            return Err(accessor
                .json
                .found("an accessor of another type", "inverse bind matrices: MAT4 of floats"));
        }
        if accessor.count < count {
            return Err(accessor
                .json
                .need("count")?
                .fault(format!("a matrix for each of the {count} joints")));
        }
        for (matrix, inverse) in out.iter_mut().zip(accessor.floats::<16>(budget)?) {
            *matrix *= affine(inverse.map(f64::from), accessor.json, warnings)?;
        }
    }
    Ok(out)
}

/// The matrix of each of the `count` vertices of a primitive, from all of its `JOINTS_n` and `WEIGHTS_n`.
pub(crate) fn vertex_matrices(
    gltf: &Gltf,
    attributes: Json<'_>,
    count: usize,
    joints: &[DAffine3],
    budget: &mut Budget,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<DAffine3>, AssetError> {
    budget.charge(Of::ExpandedBytes, count.saturating_mul(size_of::<(DAffine3, f64)>()) as u64, || {
        attributes.place()
    })?;
    let mut out = reserve(count)?;
    out.resize(count, DAffine3::ZERO);
    let mut sums: Vec<f64> = reserve(count)?;
    sums.resize(count, 0.0);
    let first = each_weight(gltf, attributes, joints.len(), budget, |v, joint, weight| {
        let matrix = joints[joint];
        out[v].matrix3 += matrix.matrix3 * weight;
        out[v].translation += matrix.translation * weight;
        sums[v] += weight;
    })?;
    normalise(&mut out, &sums, &first, joints, attributes, warnings);
    Ok(out)
}

/// Visits vertex, joint and weight of all `JOINTS_n` and `WEIGHTS_n` in their order; joints are below `joints`. Gives
/// the joints of the first set, of which the first one holds a vertex without any weight.
pub(crate) fn each_weight(
    gltf: &Gltf,
    attributes: Json<'_>,
    joints: usize,
    budget: &mut Budget,
    mut visit: impl FnMut(usize, usize, f64),
) -> Result<Vec<[u32; 4]>, AssetError> {
    let mut first = Vec::new();
    for set in 0.. {
        let (joint_key, weight_key) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
        if set > 0 && attributes.value().get(&joint_key).is_none() {
            break;
        }
        let indices = joint_indices(gltf, find(attributes, &joint_key)?, joints, budget)?;
        let weights = joint_weights(gltf, find(attributes, &weight_key)?, budget)?;
        for (v, (indices, weights)) in indices.iter().zip(&weights).enumerate() {
            for (&joint, &weight) in indices.iter().zip(weights) {
                visit(v, joint as usize, f64::from(weight));
            }
        }
        if set == 0 {
            first = indices;
        }
    }
    Ok(first)
}

fn find<'a>(attributes: Json<'a>, key: &str) -> Result<Json<'a>, AssetError> {
    let found = attributes.members()?.find(|(name, _)| *name == key);
    found.map(|(_, json)| json).ok_or_else(|| {
        attributes.found(format!("a skinned mesh without {key}"), "JOINTS_n and WEIGHTS_n in pairs from 0")
    })
}

fn joint_indices(
    gltf: &Gltf,
    reference: Json<'_>,
    joints: usize,
    budget: &mut Budget,
) -> Result<Vec<[u32; 4]>, AssetError> {
    let accessor = gltf.accessor(reference)?;
    if !matches!(accessor.component, Component::U8 | Component::U16)
        || accessor.normalized
        || accessor.lanes != 4
    {
        return Err(accessor
            .json
            .found("an accessor of another type", "joints: VEC4 of 8 or 16 bit unsigned integers"));
    }
    let indices = accessor.uints::<4>(budget)?;
    match indices.iter().flatten().find(|&&joint| joint as usize >= joints) {
        Some(joint) => Err(accessor.json.found(format!("joint {joint}"), format!("joints below {joints}"))),
        None => Ok(indices),
    }
}

fn joint_weights(gltf: &Gltf, reference: Json<'_>, budget: &mut Budget) -> Result<Vec<[f32; 4]>, AssetError> {
    let accessor = gltf.accessor(reference)?;
    let typed = match accessor.component {
        Component::F32 => !accessor.normalized,
        Component::U8 | Component::U16 => accessor.normalized,
        _ => false,
    };
    if !typed || accessor.lanes != 4 {
        let expected = "weights: VEC4 of floats or of normalised 8 or 16 bit unsigned integers";
        return Err(accessor.json.found("an accessor of another type", expected));
    }
    let weights = accessor.floats::<4>(budget)?;
    match weights.iter().flatten().find(|weight| !weight.is_finite() || **weight < 0.0) {
        Some(weight) => Err(accessor.json.found(format!("the weight {weight}"), "finite weights from 0")),
        None => Ok(weights),
    }
}

/// Divides by the sums of the weights. Without any weight a vertex hangs on its first joint.
fn normalise(
    matrices: &mut [DAffine3],
    sums: &[f64],
    first: &[[u32; 4]],
    joints: &[DAffine3],
    attributes: Json<'_>,
    warnings: &mut Vec<Warning>,
) {
    let (mut off, mut none) = (0_usize, 0_usize);
    for ((matrix, &sum), indices) in matrices.iter_mut().zip(sums).zip(first) {
        if sum <= 0.0 {
            none += 1;
            *matrix = joints[indices[0] as usize];
            continue;
        }
        off += usize::from((sum - 1.0).abs() > WEIGHT_SLACK);
        if sum != 1.0 {
            matrix.matrix3 *= 1.0 / sum;
            matrix.translation /= sum;
        }
    }
    if off > 0 {
        let message = format!("the weights of {off} vertices do not add up to 1; they are normalised");
        warnings.push(Warning::new("weights-sum", attributes.place(), message));
    }
    if none > 0 {
        let message = format!("{none} vertices have no weight at all; each is bound to its first joint");
        warnings.push(Warning::new("weights-zero", attributes.place(), message));
    }
}

/// The inverse of the linear part of `matrix`, unless it is singular.
pub(crate) fn inverse(matrix: &DAffine3) -> Option<DMat3> {
    /// A volume this small, of the box that the columns would span if they were perpendicular, means that a whole
    /// direction is lost: displacements along it would be blown up by the inverse.
    const SINGULAR: f64 = 1e-9;
    let m = matrix.matrix3;
    let size = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length);
    let box_volume = size.iter().product::<f64>();
    let largest = size.iter().copied().fold(0.0, f64::max);
    let flat = size.iter().any(|&s| s < SINGULAR * largest) || m.determinant().abs() < SINGULAR * box_volume;
    (largest > 0.0 && box_volume > 0.0 && !flat).then(|| m.inverse()).filter(DMat3::is_finite)
}
