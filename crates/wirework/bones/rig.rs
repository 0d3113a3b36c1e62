//! Where the joints of a limb's skeleton come from.
//!
//! A chain that stands in the preset gets joints made for it, on the curve of the limb, between which vertices hang by arc length; `F`
//! below 1 leaves the rest of a vertex to a joint that stays. A chain of the model's own gets joints on its bones, on which hangs what
//! hung on the joint where the bone begins, by arc length too.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use wirework_asset::{Gltf, Hung, Knot, NewJoint, NewSkin, Rest, Split, printable};
use wirework_bake::World;
use wirework_core::{Curve, Foot};
use wirework_ik::{Influence, Limb};

use super::{By, Joint, Rigged};
use crate::JobError;
use crate::limbs::Reach;

/// On how many joints a vertex of a made skeleton hangs: the two between which it lies, and the one that stays.
const EACH: usize = 3;

/// Influences this near to 1 are 1.
const WHOLE: f32 = 1e-6;

/// Joints that are made for a limb at most: no engine takes as many.
const MOST_MADE: usize = 4096;

/// Makes joints on the curve of a limb, `between` of them on each bone, and hangs all that is shown on them.
pub(super) fn make(
    mut gltf: Gltf,
    rest: &Rest,
    limb: &Limb,
    (factors, point_of): (Option<&[f32]>, &[u32]),
    between: usize,
) -> Result<Rigged, JobError> {
    let mut shown: Vec<usize> = rest.blocks.iter().map(|block| block.node).collect();
    shown.dedup();
    super::check_unmoved(&gltf, &shown)?;
    let bones = limb.joints().count().saturating_sub(1);
    if bones.saturating_mul(between + 1) > MOST_MADE {
        let message = format!(
            "{bones} bones with {between} joints more on each: a skeleton may have {MOST_MADE} joints; lower `--joints`"
        );
        return Err(JobError::Request(message));
    }
    let places = limb.places(between);
    let curve = &limb.wire().reference;
    let lengths = curve.lengths(places.iter().copied());
    let (feet, along) = feet(rest, curve);
    let names: Vec<String> = std::iter::once("limb_rest".to_owned())
        .chain((0..places.len()).map(|i| format!("limb_{i:02}")))
        .collect();
    let at: Vec<[f64; 3]> = curve.at(places.iter().copied()).into_iter().map(|(place, _)| place).collect();
    let radius = radius(limb);
    let (mut indices, mut weights) = (Vec::new(), Vec::new());
    let mut stays = false;
    for ((foot, along), point) in feet.iter().zip(&along).zip(point_of) {
        let factor = factors.and_then(|factors| factors.get(*point as usize)).copied().unwrap_or(1.0);
        let near =
            radius.map_or(1.0, |radius| density(foot.map_or(f32::INFINITY, |foot| foot.distance) / radius));
        let (own, by) = hanging(&lengths, *along, factor * near);
        stays |= by[EACH - 1] > 0.0;
        indices.extend(own);
        weights.extend(by);
    }
    // Where nothing stays there is no joint for it.
    let first = usize::from(stays);
    let joint = |(i, name): (usize, &'_ String)| {
        let above = if i > 0 { at[i - 1] } else { [0.0; 3] };
        let step: [f32; 3] = std::array::from_fn(|k| (at[i][k] - above[k]) as f32);
        (name.clone(), (i > 0).then(|| first + i - 1), step)
    };
    let mut joints: Vec<(String, Option<usize>, [f32; 3])> =
        if stays { vec![(names[0].clone(), None, [0.0; 3])] } else { Vec::new() };
    joints.extend(names[1..].iter().enumerate().map(joint));
    let joints: Vec<NewJoint<'_>> =
        joints.iter().map(|(name, parent, at)| NewJoint::at(name, *parent, *at)).collect();
    for (slot, index) in indices.iter_mut().enumerate() {
        // The last of each vertex is the one that stays.
        *index = if slot % EACH == EACH - 1 { 0 } else { *index + first as u16 };
    }
    let skin = NewSkin { name: "limb", joints: &joints, each: EACH, indices: &indices, weights: &weights };
    let Hung { joints: nodes, shown } = gltf.add_skin(rest, &shown, &skin)?;
    let rest = gltf.rest()?;
    let joint = |(i, (node, place)): (usize, (&usize, &f64))| Joint {
        node: *node,
        parent: i.checked_sub(1),
        limb: 0,
        by: By::Curve(*place),
    };
    let joints: Vec<Joint> = nodes[first..].iter().zip(&places).enumerate().map(joint).collect();
    Ok(Rigged { gltf, rest, made: joints.len(), joints, shown })
}

/// The joints of the model's own chains, limb after limb.
pub(super) fn split_all(
    gltf: Gltf,
    rest: Rest,
    limbs: &[&Reach],
    between: usize,
) -> Result<Rigged, JobError> {
    check_apart(&gltf, limbs)?;
    let mut all = Rigged { gltf, rest, joints: Vec::new(), made: 0, shown: Vec::new() };
    for (limb, reach) in limbs.iter().enumerate() {
        let Rigged { gltf, rest, joints, made, shown } = split(all.gltf, all.rest, reach, between)?;
        let first = all.joints.len();
        let later = |joint: Joint| Joint { parent: joint.parent.map(|parent| first + parent), limb, ..joint };
        all.joints.extend(joints.into_iter().map(later));
        all = Rigged { gltf, rest, joints: all.joints, made: all.made + made, shown };
    }
    Ok(all)
}

/// Refuses limbs that carry the same joints: each starts from where the clip has them, and none takes the other along.
fn check_apart(gltf: &Gltf, limbs: &[&Reach]) -> Result<(), JobError> {
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    for (limb, reach) in limbs.iter().enumerate() {
        for own in carried(gltf, reach.nodes(), |_| (0.0, 0.0)) {
            let Some(other) = taken.insert(own.node, limb) else { continue };
            let name = gltf
                .node_name(own.node)
                .map_or_else(|| own.node.to_string(), |name| format!("{:?}", printable(name)));
            return Err(super::refused(&format!(
                "limbs {other} and {limb} both take joint {name} along, and expected are limbs of which none hangs below another"
            )));
        }
    }
    Ok(())
}

/// The joints of the model's own chain, and what hangs on them; where `between` is not 0 with so many more to a bone.
///
/// Whatever the chain's joints carry hangs on one of them, but the limb takes it along by where on its curve it is: so all joints
/// below are taken along too, but for those that go where the one above them goes.
fn split(mut gltf: Gltf, rest: Rest, reach: &Reach, between: usize) -> Result<Rigged, JobError> {
    let still = gltf.player(&rest, None)?;
    let world = |node: usize| still.node_transform(node).unwrap_or(super::WORLD);
    let line = Line::new(reach.rest(), between);
    let carried = carried(&gltf, reach.nodes(), |node| line.locate(world(node)[3].map(|c| c as f32)));
    let knots: Vec<Vec<Knot>> = carried.iter().map(|own| line.knots(&world(own.node), between)).collect();
    drop(still);
    let splits: Vec<Split<'_>> = carried
        .iter()
        .zip(&knots)
        .map(|(own, knots)| Split { node: own.node, along: own.along, knots })
        .collect();
    let mut new = Vec::new();
    let mut after = None;
    if between > 0 {
        let along: Vec<f32> = rest.positions.par_iter().map(|place| line.locate(*place).0 as f32).collect();
        new = gltf.split_joints(&rest, &splits, &along)?;
        after = Some(gltf.rest()?);
    }
    let rest = after.unwrap_or(rest);
    let bone = |own: &Carried| own.bone.filter(|bone| between == 0 && bone + 1 < reach.nodes().len());
    let is_moved = moved(&carried, |own| bone(own).is_some());
    let mut joints: Vec<Joint> = Vec::new();
    let mut places: Vec<Option<usize>> = Vec::new();
    for (k, own) in carried.iter().enumerate() {
        let parent = own.parent.and_then(|parent| places[parent]);
        let near = |step, u| By::Near { own: own.node, step, u };
        let mut this = None;
        if is_moved[k] {
            let by = bone(own).map_or(near(DVec3::ZERO, own.u), By::Bone);
            joints.push(Joint { node: own.node, parent, limb: 0, by });
            this = Some(joints.len() - 1);
        }
        places.push(this);
        for ((node, knot), u) in new.get(k).into_iter().flatten().zip(&knots[k]).zip(&line.parameters) {
            if let (Some(node), Some(this)) = (node, this) {
                joints.push(Joint {
                    node: *node,
                    parent: Some(this),
                    limb: 0,
                    by: near(DVec3::from_array(knot.at), *u),
                });
            }
        }
    }
    let made = new.iter().flatten().flatten().count();
    Ok(Rigged { gltf, rest, joints, made, shown: Vec::new() })
}

/// A joint of the model that a limb carries.
struct Carried {
    node: usize,
    /// The one above it, one before it in the list.
    parent: Option<usize>,
    /// Its number in the chain.
    bone: Option<usize>,
    /// How far along the limb it is, and the parameter of the curve there.
    along: f64,
    u: f64,
}

/// The chain's joints and all below them, parents first.
fn carried(gltf: &Gltf, chain: &[usize], locate: impl Fn(usize) -> (f64, f64)) -> Vec<Carried> {
    let Some(&root) = chain.first() else { return Vec::new() };
    let mut out: Vec<Carried> = Vec::new();
    let mut stack = vec![(root, None)];
    while let Some((node, parent)) = stack.pop() {
        let bone = chain.iter().position(|own| *own == node);
        let (along, u) = locate(node);
        let along = bone.map_or(along, |bone| bone as f64);
        out.push(Carried { node, parent, bone, along, u });
        let this = Some(out.len() - 1);
        stack.extend(gltf.children(node).into_iter().rev().map(|child| (child, this)));
    }
    out
}

/// Which joints need tracks: those that go elsewhere than the one above them, and all above those. `stretched` are such as nothing
/// else goes with.
fn moved(carried: &[Carried], stretched: impl Fn(&Carried) -> bool) -> Vec<bool> {
    let goes_with = |own: &Carried| {
        let above = own.parent.map(|parent| &carried[parent]);
        above.is_some_and(|above| above.u == own.u && !stretched(above) && own.bone.is_none())
    };
    let mut out: Vec<bool> = carried.iter().map(|own| !goes_with(own)).collect();
    for k in (0..out.len()).rev() {
        if let Some(parent) = carried[k].parent.filter(|_| out[k]) {
            out[parent] = true;
        }
    }
    out
}

/// The curve of a limb at rest, with knots at the joints and at equal parts of its bones.
struct Line {
    curve: Curve,
    joints: Vec<DVec3>,
    /// Of the knots: how far along they are, in bones, the parameters of the curve, and the arc lengths up to there.
    along: Vec<f64>,
    parameters: Vec<f64>,
    lengths: Vec<f64>,
}

impl Line {
    fn new(limb: &Limb, between: usize) -> Self {
        let curve = limb.wire().reference;
        let joints: Vec<DVec3> = limb.joints().map(DVec3::from_array).collect();
        let steps = between + 1;
        let last = steps * (joints.len() - 1);
        let along: Vec<f64> = (0..=last).map(|k| k as f64 / steps as f64).collect();
        let mut reached = 0.0_f64;
        let parameter = |k: usize| {
            let place = on_bones(&joints, along[k]).as_vec3().to_array();
            let foot = curve.closest(place).map_or(0.0, |foot| f64::from(foot.u));
            // They rise, wherever a bent limb comes near itself.
            reached = if k == last { 1.0 } else { reached.max(if k == 0 { 0.0 } else { foot }) };
            reached
        };
        let parameters: Vec<f64> = (0..=last).map(parameter).collect();
        let lengths = curve.lengths(parameters.iter().copied());
        Self { curve, joints, along, parameters, lengths }
    }

    /// How far along a place is, in bones, and the parameter of its foot.
    fn locate(&self, place: [f32; 3]) -> (f64, f64) {
        let u = self.curve.closest(place).map_or(0.0, |foot| f64::from(foot.u));
        let length = self.curve.lengths([u])[0];
        let after = self.lengths.partition_point(|known| *known <= length).clamp(1, self.lengths.len() - 1);
        let (a, b) = (self.lengths[after - 1], self.lengths[after]);
        let part = if b > a { ((length - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        (self.along[after - 1] + part * (self.along[after] - self.along[after - 1]), u)
    }

    /// The knots, in the space of a joint.
    fn knots(&self, joint: &World, between: usize) -> Vec<Knot> {
        let [x, y, z, at] = joint.map(DVec3::from_array);
        let inverse = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), at).inverse();
        if between == 0 || !inverse.is_finite() {
            return Vec::new();
        }
        let knot = |&along: &f64| Knot {
            along,
            at: inverse.transform_point3(on_bones(&self.joints, along)).to_array(),
        };
        self.along.iter().map(knot).collect()
    }
}

/// The place so many bones along a chain.
fn on_bones(joints: &[DVec3], along: f64) -> DVec3 {
    let bone = (along as usize).min(joints.len() - 2);
    joints[bone].lerp(joints[bone + 1], along - bone as f64)
}

/// The feet of vertices on the curve of a limb, and the arc lengths up to them.
fn feet(rest: &Rest, curve: &Curve) -> (Vec<Option<Foot>>, Vec<f64>) {
    let feet: Vec<Option<Foot>> =
        rest.positions.par_iter().map(|position| curve.closest(*position)).collect();
    let along = curve.lengths(feet.iter().map(|foot| foot.map_or(0.0, |foot| f64::from(foot.u))));
    (feet, along)
}

/// How far a limb reaches.
fn radius(limb: &Limb) -> Option<f32> {
    match limb.settings().influence {
        Influence::Radius(radius) => Some(radius),
        Influence::All | Influence::SkinWeights => None,
    }
}

/// `f` of a limb's wire, the paper's.
fn density(x: f32) -> f32 {
    if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 }
}

/// The two joints between which a vertex lies, and one that stays; and its weights. `lengths` are the arc lengths up to the joints, `along`
/// that up to the vertex's foot.
fn hanging(lengths: &[f64], along: f64, influence: f32) -> ([u16; EACH], [f32; EACH]) {
    let before = lengths.partition_point(|length| *length <= along).clamp(1, lengths.len() - 1) - 1;
    let (a, b) = (lengths[before], lengths[before + 1]);
    let part = if b > a { ((along - a) / (b - a)).clamp(0.0, 1.0) as f32 } else { 0.0 };
    let whole = if influence > 1.0 - WHOLE { 1.0 } else { influence };
    ([before as u16, before as u16 + 1, 0], [whole * (1.0 - part), whole * part, 1.0 - whole])
}
