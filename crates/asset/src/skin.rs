//! Skins: the matrix that takes a vertex of a skinned mesh to the world, blended from its joints.

use glam::DAffine3;

use crate::accessor::Component;
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::graph::affine;
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};

/// How far the sum of a vertex's weights may be from 1 before it is worth a warning: a unit of 8-bit weights.
const WEIGHT_SLACK: f64 = 1.0 / 255.0;

/// The joints of a skin, and where they were bound.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// Their nodes.
    pub(crate) joints: Vec<usize>,
    /// Their inverse bind matrices; empty where all are the identity.
    inverse: Vec<DAffine3>,
}

impl Skin {
    /// Reads a skin of a document with so many `nodes`.
    pub(crate) fn read(
        gltf: &Gltf,
        skin: Json<'_>,
        nodes: usize,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, AssetError> {
        let list = skin.need("joints")?;
        let count = list.array()?.len();
        if count == 0 {
            return Err(list.fault("at least one joint"));
        }
        let bytes = count.saturating_mul(2 * size_of::<DAffine3>() + size_of::<usize>());
        budget.charge(Of::ExpandedBytes, bytes as u64, || list.place())?;
        let mut joints = reserve(count)?;
        for joint in list.items()? {
            joints.push(joint.index("node", nodes)?);
        }
        let mut inverse = Vec::new();
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
            inverse = reserve(count)?;
            for matrix in accessor.floats::<16>(budget)?.iter().take(count) {
                inverse.push(affine(matrix.map(f64::from), accessor.json, warnings)?);
            }
        }
        Ok(Self { joints, inverse })
    }

    /// The matrices of the joints, joint world × inverse bind, where the nodes are at `world`.
    pub(crate) fn matrices_into(&self, world: &[DAffine3], out: &mut Vec<DAffine3>) {
        out.clear();
        out.extend(self.joints.iter().map(|&joint| world[joint]));
        for (matrix, inverse) in out.iter_mut().zip(&self.inverse) {
            *matrix *= *inverse;
        }
    }
}

/// How the vertices of a primitive hang on the joints of its skin.
#[derive(Clone, Debug)]
pub(crate) struct Influences {
    /// Joints of the skin and their weights as the file has them, vertex after vertex. A vertex has at least one; a
    /// weight is above 0.
    list: Vec<(u32, f32)>,
    /// Where those of each vertex end.
    ends: Vec<usize>,
}

impl Influences {
    /// Reads all `JOINTS_n` and `WEIGHTS_n` of a primitive of `count` vertices; joints are below `joints`. A vertex
    /// without any weight hangs on its first joint.
    pub(crate) fn read(
        gltf: &Gltf,
        attributes: Json<'_>,
        count: usize,
        joints: usize,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, AssetError> {
        let sets = sets(gltf, attributes, joints, budget)?;
        let each = size_of::<usize>() + sets.len().saturating_mul(4 * size_of::<(u32, f32)>());
        budget.charge(Of::ExpandedBytes, count.saturating_mul(each) as u64, || attributes.place())?;
        let above = sets.iter().flat_map(|(_, weights)| weights.as_flattened()).filter(|&&w| w > 0.0).count();
        let mut out = Self { list: reserve(above.saturating_add(count))?, ends: reserve(count)? };
        let (mut off, mut none) = (0_usize, 0_usize);
        for v in 0..count {
            let mut sum = 0.0;
            for (indices, weights) in &sets {
                let (Some(indices), Some(weights)) = (indices.get(v), weights.get(v)) else { continue };
                let pairs = indices.iter().copied().zip(weights.iter().copied());
                out.list.extend(pairs.filter(|&(_, weight)| weight > 0.0));
                sum += weights.iter().map(|&weight| f64::from(weight)).sum::<f64>();
            }
            if sum <= 0.0 {
                none += 1;
                let first = sets.first().and_then(|(indices, _)| indices.get(v));
                out.list.push((first.map_or(0, |indices| indices[0]), 1.0));
            } else {
                off += usize::from((sum - 1.0).abs() > WEIGHT_SLACK);
            }
            out.ends.push(out.list.len());
        }
        warn(off, none, attributes, warnings);
        Ok(out)
    }

    /// The joints of a vertex and their weights, which need not add up to 1.
    pub(crate) fn of(&self, vertex: usize) -> &[(u32, f32)] {
        let first = if vertex == 0 { 0 } else { self.ends[vertex - 1] };
        &self.list[first..self.ends[vertex]]
    }

    /// The matrix of a vertex, from the matrices of the joints.
    pub(crate) fn matrix(&self, vertex: usize, joints: &[DAffine3]) -> DAffine3 {
        let mut out = DAffine3::ZERO;
        let mut sum = 0.0;
        for &(joint, weight) in self.of(vertex) {
            let (matrix, weight) = (&joints[joint as usize], f64::from(weight));
            out.matrix3 += matrix.matrix3 * weight;
            out.translation += matrix.translation * weight;
            sum += weight;
        }
        if sum != 1.0 {
            out.matrix3 *= 1.0 / sum;
            out.translation /= sum;
        }
        out
    }
}

/// Joints and weights of each vertex, four at a time.
type Set = (Vec<[u32; 4]>, Vec<[f32; 4]>);

fn sets(
    gltf: &Gltf,
    attributes: Json<'_>,
    joints: usize,
    budget: &mut Budget,
) -> Result<Vec<Set>, AssetError> {
    let mut out = Vec::new();
    for set in 0.. {
        let (joint_key, weight_key) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
        if set > 0 && attributes.value().get(&joint_key).is_none() {
            break;
        }
        let indices = joint_indices(gltf, find(attributes, &joint_key)?, joints, budget)?;
        out.push((indices, joint_weights(gltf, find(attributes, &weight_key)?, budget)?));
    }
    Ok(out)
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

/// Tells of `off` vertices whose weights do not add up, and of `none` that have none.
fn warn(off: usize, none: usize, attributes: Json<'_>, warnings: &mut Vec<Warning>) {
    if off > 0 {
        let message = format!("the weights of {off} vertices do not add up to 1; they are normalised");
        warnings.push(Warning::new("weights-sum", attributes.place(), message));
    }
    if none > 0 {
        let message = format!("{none} vertices have no weight at all; each is bound to its first joint");
        warnings.push(Warning::new("weights-zero", attributes.place(), message));
    }
}
