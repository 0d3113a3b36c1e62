//! Joints and weights of new vertices, and where a skin has them at rest.

use glam::{DAffine3, DVec3};

use super::Added;
use crate::accessor::Component;
use crate::attributes::Local;
use crate::document::Gltf;
use crate::error::AssetError;
use crate::json::Json;
use crate::limits::Budget;
use crate::rest::{Part, Rest};
use crate::way::{double, single};

/// A shift of less than this part of the edge is rounding, and left out: what moves together then plays as interpolated.
const NOTHING: f64 = 1e-5;
/// A shift of more than this part of the edge is left out: where the two ends are turned against each other so much the blend
/// is all but singular, and what puts the vertex in its place at rest would throw it out of every other pose.
const TOO_FAR: f64 = 0.5;

/// How far the weights of a vertex may be from adding up to 1, for each that is not 0: what the Khronos validator takes.
const SUM: f64 = 2e-7;

/// What vertices hang on: as many pairs of a joint and a weight each as all their sets have, unused ones of weight 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Influences {
    pub(super) sets: usize,
    pub(super) pairs: Vec<(u32, f32)>,
}

impl Influences {
    /// Those of the old vertices; none where sets are missing, or not of the standard's types.
    pub(super) fn read(
        gltf: &Gltf,
        attributes: Json<'_>,
        budget: &mut Budget,
    ) -> Result<Option<Self>, AssetError> {
        let mut sets = Vec::new();
        while let Some(set) = read_set(gltf, attributes, sets.len(), budget)? {
            sets.push(set);
        }
        let named = |prefix: &str| -> Result<usize, AssetError> {
            Ok(attributes.members()?.filter(|(name, _)| name.starts_with(prefix)).count())
        };
        let Some((first, _)) = sets.first() else { return Ok(None) };
        if named("JOINTS_")? != sets.len() || named("WEIGHTS_")? != sets.len() {
            return Ok(None);
        }
        let mut pairs = crate::limits::reserve(first.len().saturating_mul(4 * sets.len()))?;
        for v in 0..first.len() {
            let start = pairs.len();
            for (joints, weights) in &sets {
                pairs.extend(joints[v].into_iter().zip(weights[v]));
            }
            repair(&mut pairs[start..]);
        }
        Ok(Some(Self { sets: sets.len(), pairs }))
    }

    fn of(&self, vertex: u32) -> &[(u32, f32)] {
        let room = 4 * self.sets;
        self.pairs.get(vertex as usize * room..(vertex as usize + 1) * room).unwrap_or(&[])
    }

    /// Adds a vertex between two: of what each hangs on its share, the largest of it. Says whether both hang on the same.
    pub(super) fn push_between(&mut self, [a, b]: [u32; 2], towards: f64) -> bool {
        let (a, b) = (shares(self.of(a)), shares(self.of(b)));
        let same = a == b;
        let part = |of: f64| move |(joint, share)| (joint, of * share);
        let both = a.into_iter().map(part(1.0 - towards)).chain(b.into_iter().map(part(towards)));
        let mut list = merged(both.collect());
        // By weight, and where that decides nothing by number: both sides of a seam come to the same order.
        list.sort_by(|(i, s), (j, t)| t.total_cmp(s).then(i.cmp(j)));
        let room = 4 * self.sets;
        list.truncate(room);
        let sum: f64 = list.iter().map(|(_, share)| share).sum();
        let pairs = list.iter().map(|&(joint, share)| (joint, (share / sum) as f32));
        self.pairs.extend(pairs.chain(std::iter::repeat((0, 0.0))).take(room));
        same
    }

    /// The matrix of the vertex that was added last.
    fn last_matrix(&self, joints: &[DAffine3]) -> Option<DAffine3> {
        let last = self.pairs.len().checked_sub(4 * self.sets)?;
        let (mut out, mut sum) = (DAffine3::ZERO, 0.0);
        for &(joint, weight) in self.pairs[last..].iter().filter(|(_, weight)| *weight > 0.0) {
            let (matrix, weight) = (joints.get(joint as usize)?, f64::from(weight));
            out.matrix3 += matrix.matrix3 * weight;
            out.translation += matrix.translation * weight;
            sum += weight;
        }
        out.matrix3 *= 1.0 / sum;
        out.translation /= sum;
        Some(out)
    }
}

/// Makes weights add up, and names no joint without a weight: the copy is not to be wrong where the original is.
fn repair(pairs: &mut [(u32, f32)]) {
    let used = pairs.iter().filter(|(_, weight)| *weight != 0.0).count();
    let sum: f64 = pairs.iter().map(|&(_, weight)| f64::from(weight)).sum();
    if used == 0 || sum <= 0.0 {
        return;
    }
    let off = (sum - 1.0).abs() > SUM * used as f64;
    for (joint, weight) in pairs {
        if *weight == 0.0 {
            *joint = 0;
        } else if off {
            *weight = (f64::from(*weight) / sum) as f32;
        }
    }
}

type Set = (Vec<[u32; 4]>, Vec<[f32; 4]>);

fn read_set(
    gltf: &Gltf,
    attributes: Json<'_>,
    set: usize,
    budget: &mut Budget,
) -> Result<Option<Set>, AssetError> {
    let (joint_key, weight_key) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
    let find = |key: &str| -> Result<Option<Json<'_>>, AssetError> {
        Ok(attributes.members()?.find(|(name, _)| *name == key).map(|(_, json)| json))
    };
    let (Some(joints), Some(weights)) = (find(&joint_key)?, find(&weight_key)?) else { return Ok(None) };
    let (joints, weights) = (gltf.accessor(joints)?, gltf.accessor(weights)?);
    let small = |component| matches!(component, Component::U8 | Component::U16);
    let plain = small(joints.component) && !joints.normalized;
    let shares = if weights.component == Component::F32 {
        !weights.normalized
    } else {
        small(weights.component) && weights.normalized
    };
    if !plain || !shares || joints.lanes != 4 || weights.lanes != 4 || joints.count != weights.count {
        return Ok(None);
    }
    let (joints, weights) = (joints.uints::<4>(budget)?, weights.floats::<4>(budget)?);
    Ok(weights.as_flattened().iter().all(|weight| weight.is_finite()).then_some((joints, weights)))
}

/// What a vertex hangs on, in shares that add up to 1, by joint; a vertex without any weight on its first joint.
fn shares(pairs: &[(u32, f32)]) -> Vec<(u32, f64)> {
    let list: Vec<(u32, f64)> =
        pairs.iter().filter(|(_, w)| *w > 0.0).map(|&(j, w)| (j, f64::from(w))).collect();
    let sum: f64 = list.iter().map(|(_, weight)| weight).sum();
    if sum <= 0.0 {
        return vec![(pairs.first().map_or(0, |pair| pair.0), 1.0)];
    }
    merged(list.into_iter().map(|(joint, weight)| (joint, weight / sum)).collect())
}

/// Each joint once, rising.
fn merged(mut list: Vec<(u32, f64)>) -> Vec<(u32, f64)> {
    list.sort_by_key(|(joint, _)| *joint);
    list.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    list
}

impl Gltf {
    /// For a skin what to add to what lies between the parents of a block's new vertices, so that at rest they lie as far
    /// between their parents in the world; elsewhere, and where that is nothing for all, nothing.
    ///
    /// Two ends that hang on other joints are taken to the world in two ways; the middle, which is taken there in half of
    /// either, would leave the chord by a quarter of the edge times their difference. In the pose in which the skin was
    /// bound there is none.
    pub(super) fn shifts(
        &self,
        rest: &Rest,
        block: usize,
        part: &Part,
        added: &Added,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; 3]>, AssetError> {
        let block = &rest.blocks[block];
        let Some(joints) = block.joints() else { return Ok(Vec::new()) };
        let primitive = self.primitive(part)?;
        let attributes = primitive.need("attributes")?;
        let Some(mut influences) = Influences::read(self, attributes, budget)? else { return Ok(Vec::new()) };
        let mut local = Local::read(self, primitive, budget, &mut Vec::new())?;
        let weights: Vec<f64> = self.default_weights(part.node).into_iter().map(f64::from).collect();
        local.morph(self, primitive, &weights, budget)?;
        let mut own: Vec<DVec3> = local.positions.iter().map(|&p| double(p)).collect();
        let shown = &rest.positions[block.first..block.first + block.count];
        let mut world: Vec<DVec3> = shown.iter().map(|&p| double(p)).collect();
        let mut out = Vec::with_capacity(added.parents.len());
        for (&[a, b], &share) in added.parents.iter().zip(&added.shares) {
            let mix = |list: &[DVec3]| list[a as usize] * (1.0 - share) + list[b as usize] * share;
            let (between, chord) = (mix(&own), mix(&world));
            let edge = own[a as usize].distance(own[b as usize]);
            let same = influences.push_between([a, b], share);
            let there = || {
                let matrix = influences.last_matrix(joints)?;
                let shift = matrix.inverse().transform_point3(chord) - between;
                let length = shift.length();
                (length >= NOTHING * edge && length <= TOO_FAR * edge).then_some(shift)
            };
            let shift = if same { None } else { there() }.unwrap_or(DVec3::ZERO);
            own.push(between + shift);
            world.push(chord);
            out.push(single(shift));
        }
        Ok(if out.iter().all(|shift| *shift == [0.0; 3]) { Vec::new() } else { out })
    }
}
