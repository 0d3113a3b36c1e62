//! Skins: the matrix that takes a vertex of a skinned mesh to the world, blended from its joints.

use glam::DAffine3;
use rayon::prelude::*;

use crate::accessor::Component;
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::graph::affine;
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};

/// How far the sum of a vertex's weights may be from 1 before it is worth a warning: a unit of 8-bit weights.
const WEIGHT_SLACK: f64 = 1.0 / 255.0;

/// So many vertices are looked at by one thread at a time.
const BLOCK: usize = 1 << 12;

/// The joints of a skin, and where they were bound.
#[derive(Clone, Debug)]
pub(crate) struct Skin {
    /// Their nodes.
    pub(crate) joints: Vec<usize>,
    /// Their inverse bind matrices; empty where all are the identity.
    pub(crate) inverse: Vec<DAffine3>,
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
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Influences {
    /// At least one. A vertex has a weight above 0 in one of them.
    pub(crate) sets: Vec<Set>,
}

/// Four joints of the skin and their weights for each vertex, as the file has them; those of weight 0 do not count.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Set {
    pub(crate) joints: Vec<[u16; 4]>,
    pub(crate) weights: Vec<[f32; 4]>,
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
        let mut out = Self { sets: Vec::new() };
        for set in 0.. {
            let (joint_key, weight_key) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
            if set > 0 && attributes.value().get(&joint_key).is_none() {
                break;
            }
            let (joint_json, weight_json) = (find(attributes, &joint_key)?, find(attributes, &weight_key)?);
            let joints = joint_indices(gltf, joint_json, joints, budget)?;
            let weights = joint_weights(gltf, weight_json, budget)?;
            if joints.len() != count || weights.len() != count {
                let found = format!("{} joints and {} weights", joints.len(), weights.len());
                return Err(joint_json.found(found, format!("{count} of each, as there are vertices")));
            }
            out.sets.push(Set { joints, weights });
        }
        let (off, none) = out.complete();
        warn(off, none, attributes, warnings);
        Ok(out)
    }

    /// Binds vertices without weights to their first joint. Gives how many have weights that do not add up, and how many none.
    fn complete(&mut self) -> (usize, usize) {
        let Some((first, others)) = self.sets.split_first_mut() else { return (0, 0) };
        let total = |weights: &[f32; 4]| weights.iter().map(|&weight| f64::from(weight)).sum::<f64>();
        let vertex = |(v, weights): (usize, &mut [f32; 4])| {
            let others = others.iter().filter_map(|set| set.weights.get(v)).map(total);
            let sum = others.fold(total(weights), |sum, more| sum + more);
            if sum <= 0.0 {
                weights[0] = 1.0;
                return (0, 1);
            }
            (usize::from((sum - 1.0).abs() > WEIGHT_SLACK), 0)
        };
        let vertices = first.weights.par_iter_mut().with_min_len(BLOCK).enumerate();
        vertices.map(vertex).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    }

    /// The joints of a vertex and their weights, which are above 0 and need not add up to 1.
    pub(crate) fn of(&self, vertex: usize) -> impl Iterator<Item = (u32, f32)> {
        let pairs = self.sets.iter().flat_map(move |set| {
            let (joints, weights) = (set.joints[vertex], set.weights[vertex]);
            joints.map(u32::from).into_iter().zip(weights)
        });
        pairs.filter(|&(_, weight)| weight > 0.0)
    }

    /// How many places for joints each vertex has.
    pub(crate) fn slots(&self) -> usize {
        4 * self.sets.len()
    }

    /// A joint of a vertex and its weight.
    pub(crate) fn slot(&self, vertex: usize, slot: usize) -> (u16, f32) {
        let set = &self.sets[slot / 4];
        (set.joints[vertex][slot % 4], set.weights[vertex][slot % 4])
    }

    pub(crate) fn set(&mut self, vertex: usize, slot: usize, (joint, weight): (u16, f32)) {
        let set = &mut self.sets[slot / 4];
        set.joints[vertex][slot % 4] = joint;
        set.weights[vertex][slot % 4] = weight;
    }

    /// The memory that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        let vertices: usize = self.sets.iter().map(|set| set.joints.len()).sum();
        vertices as u64 * 24
    }

    /// The matrix of a vertex, from the matrices of the joints.
    pub(crate) fn matrix(&self, vertex: usize, joints: &[DAffine3]) -> DAffine3 {
        let mut out = DAffine3::ZERO;
        let mut sum = 0.0;
        for set in &self.sets {
            for (&joint, &weight) in set.joints[vertex].iter().zip(&set.weights[vertex]) {
                if weight > 0.0 {
                    let (matrix, weight) = (&joints[joint as usize], f64::from(weight));
                    out.matrix3 += matrix.matrix3 * weight;
                    out.translation += matrix.translation * weight;
                    sum += weight;
                }
            }
        }
        if sum != 1.0 {
            out.matrix3 *= 1.0 / sum;
            out.translation /= sum;
        }
        out
    }
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
) -> Result<Vec<[u16; 4]>, AssetError> {
    let accessor = gltf.accessor(reference)?;
    let typed = matches!(accessor.component, Component::U8 | Component::U16) && !accessor.normalized;
    if !typed || accessor.lanes != 4 {
        let expected = "joints: VEC4 of 8 or 16 bit unsigned integers";
        return Err(accessor.json.found("an accessor of another type", expected));
    }
    let indices = accessor.shorts::<4>(budget)?;
    let bad = |joint: u16| usize::from(joint) >= joints;
    // Most have no bad one, and the largest is found many at a time.
    if indices.par_chunks(BLOCK).map(largest).max().is_none_or(|largest| !bad(largest)) {
        return Ok(indices);
    }
    match indices.iter().flatten().find(|&&joint| bad(joint)) {
        Some(joint) => Err(accessor.json.found(format!("joint {joint}"), format!("joints below {joints}"))),
        None => Ok(indices),
    }
}

fn largest(indices: &[[u16; 4]]) -> u16 {
    indices.as_flattened().iter().copied().max().unwrap_or(0)
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
    let good = |weight: f32| (0.0..=f32::MAX).contains(&weight);
    let all_good = |weights: &[[f32; 4]]| weights.as_flattened().iter().fold(true, |all, &w| all & good(w));
    if weights.par_chunks(BLOCK).all(all_good) {
        return Ok(weights);
    }
    match weights.iter().flatten().find(|&&weight| !good(weight)) {
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
