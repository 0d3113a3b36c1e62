//! Wires that only translate as a skeleton: a joint a control point, which moves as that does and turns nothing.
//!
//! Such a wire moves a point by `Σ wⱼ·(Wⱼ − Rⱼ)` over its control points, with weights `wⱼ = a·F·Nⱼ` that are known once it is bound
//! ([`wirework_core::Weights`]). That is what a skin makes of joints that translate, with the rest of the weight on one that stays: no
//! approximation, but for rounding.
//!
//! Weights of a skin lie between 0 and 1. Where amplitudes, or wires that add up, lead beyond, the joints of a wire go so many
//! times as far as its control points, or the other way, and the weights are as much smaller.

use std::collections::BTreeSet;

use glam::DVec3;
use wirework_asset::{Gltf, Hung, NewJoint, NewSkin, Rest};
use wirework_bake::{Bone, BoneBaker, BonePose, World};
use wirework_core::{Weights, WeightsError, Wire};
use wirework_preset::{Deform, KeyedWire, PoseKeys};

use super::keys::{PART, straightened};
use super::{Animated, WORLD, allowed, check_unmoved, refused};
use crate::error::count;
use crate::film::Film;
use crate::{Job, JobError, Schedule, Skeleton};

/// The most joints that vertices hang on: two sets of four. More sets are hardly read anywhere.
const MOST_INFLUENCES: usize = 8;

/// How far joints of eased poses may be off between keys, in parts of the diagonal: such a skin is meant to be the wire itself, and keys are
/// small.
const OF_EASED: f64 = 5e-6;

/// What viewers that read one set of joints play.
const ONE_SET: usize = 4;

/// The most joints there may be: no engine takes as many.
const MOST_JOINTS: usize = 4096;

/// Weights below this are the rounding of the others in float32, and no reason for a joint more.
const LEAST: f64 = 3e-8;

/// Times that are no farther apart, relatively, are one.
const ROUNDING: f64 = 1e-12;

/// Weights that add up to no more than this are 1: influences are kept in float32.
const WHOLE: f64 = 1.0 + 1e-6;

impl Film<'_> {
    /// The model with joints for the control points of wires.
    pub(super) fn wires(
        &mut self,
        job: &Job<'_>,
        mut gltf: Gltf,
        rest: &Rest,
        point_of: &[u32],
    ) -> Result<Animated, JobError> {
        let net = self.motion.is_net();
        let typed = self.motion.effects().first().and_then(|effect| effect.typed.listed("wires"));
        let Some(stage) = self.motion.evaluation.lone_wires() else {
            return Err(self.not_alone());
        };
        let Some(deform) = stage.drawn().cloned() else { return Err(self.not_alone()) };
        let name = |wire: usize| match typed {
            // The wires of a `WireLattice` are many in one place.
            Some(typed) if typed != deform.wires.len() => format!("wire {wire}"),
            _ => format!("wires[{wire}]"),
        };
        check(job, &deform, net, name)?;
        let mut wires: Vec<Wire> = deform.wires.iter().map(at_start).collect();
        let weights = stage.weights(&wires).map_err(|error| refused(&told(&error, name)))?;
        let hanging = Hanging::new(&wires, &weights, name)?;
        let shown = shown(&gltf, rest, |vertex| hanging.is_moved(point_of[vertex]))?;
        let Hung { joints: nodes, shown } = match shown.as_slice() {
            [] => Hung { joints: Vec::new(), shown: Vec::new() },
            shown => hanging.make(&mut gltf, rest, shown, point_of)?,
        };
        let rest = gltf.rest()?;
        let bones: Vec<Bone> = nodes.iter().map(|&node| Bone { node, parent: None }).collect();
        let (warnings, influences) = (hanging.warnings(), hanging.most.min(MOST_INFLUENCES));
        let gains = hanging.gains;
        let mut baker = BoneBaker::new(&bones);
        let mut look = |frame: usize, seconds: f64| {
            deform.wires.iter().zip(&mut wires).for_each(|(keyed, wire)| keyed.at_into(seconds, wire));
            let places = wires.iter().zip(&gains).flat_map(|(wire, gain)| places(wire, *gain));
            // Nothing to hang on: there are no joints.
            let places: Vec<World> = places.take(bones.len()).collect();
            BonePose::new(&bones, frame, |_| WORLD, &places)
        };
        let off = |middle: &BonePose, ends: (&BonePose, &BonePose)| middle.off(&bones, ends, PART, 0.0);
        let mut take = |seconds: f64, pose: &BonePose| baker.push(seconds, pose);
        let times = times(&deform.wires, &self.schedule);
        straightened(&times, allowed(&rest, job.tolerance.min(OF_EASED)), &mut look, &off, &mut take)?;
        let joints = bones.len();
        let skeleton = Skeleton { joints, made: joints, influences, gains, ..Skeleton::default() };
        Ok(Animated { gltf, rest, shown, baker, skeleton, warnings })
    }
}

/// The wire at 0 s; one that moves all its control points alike turns nothing, whatever it says of that.
fn at_start(keyed: &KeyedWire) -> Wire {
    let mut wire = keyed.at(0.0);
    if keyed.translates() {
        wire.rotation = 0.0;
        wire.locators.iter_mut().for_each(|locator| locator.rotation = None);
    }
    wire
}

/// Refuses what the weights cannot tell: what other than poses moves, and what is more than wires.
fn check(job: &Job<'_>, deform: &Deform, net: bool, name: impl Fn(usize) -> String) -> Result<(), JobError> {
    if net {
        return Err(refused("the object is a patch, and its control points have no skin"));
    }
    if deform.lattice.is_some() {
        return Err(refused("`lattice`: the wires move its control points, and these the object"));
    }
    if job.joints > 0 {
        let message =
            "`--joints` puts joints on the bones of a limb; wires have one a control point: leave it out";
        return Err(JobError::Request(message.to_owned()));
    }
    let unsteady = |(i, wire): (usize, &KeyedWire)| Some(format!("{}.{}", name(i), wire.unsteady()?));
    if let Some(field) = deform.wires.iter().enumerate().find_map(unsteady) {
        let why = format!("`{field}` moves in time, and the weights of a skin do not; only `pose` may");
        return Err(refused(&why));
    }
    let joints: usize = deform.wires.iter().map(|wire| wire.reference().points().len()).sum();
    if joints > MOST_JOINTS {
        return Err(refused(&format!(
            "a skeleton may have {MOST_JOINTS} joints, and {joints} control points need one each"
        )));
    }
    Ok(())
}

/// Why wires are no weights, by their fields.
fn told(error: &WeightsError, name: impl Fn(usize) -> String) -> String {
    match error {
        WeightsError::Attribute { wire, locator, attribute, found, expected } => {
            let locator = locator.map_or_else(String::new, |locator| format!(".locators[{locator}]"));
            format!(
                "`{}{locator}.{attribute}` is {found}, and the joint of a control point only moves: with `{attribute}: {expected}` it is exact",
                name(*wire)
            )
        }
        WeightsError::ArcLength { wire } => format!(
            "`{}.correspondence` is `ArcLength`, and which point of the pose belongs to a vertex changes with it: with `Parameter` it is exact",
            name(*wire)
        ),
        WeightsError::CatmullRom { wire } => format!(
            "`{}.curve` is a `CatmullRom`, which is not linear in its points: a `BSpline` or a `Bezier` is",
            name(*wire)
        ),
        WeightsError::Blend { wires: [a, b], .. } => format!(
            "`{}` and `{}` reach the same vertices, and blend there by how far they move: with `localize: 1`, `crossing: 1` or one `group` the \
             weights are fixed",
            name(*a),
            name(*b)
        ),
        other => other.to_string(),
    }
}

/// The nodes of which a vertex is moved.
fn shown(gltf: &Gltf, rest: &Rest, is_moved: impl Fn(usize) -> bool) -> Result<Vec<usize>, JobError> {
    let moved = |block: &wirework_asset::Block| (block.first..block.first + block.count).any(&is_moved);
    let nodes: BTreeSet<usize> =
        rest.blocks.iter().filter(|block| moved(block)).map(|block| block.node).collect();
    let nodes: Vec<usize> = nodes.into_iter().collect();
    check_unmoved(gltf, &nodes)?;
    Ok(nodes)
}

/// How the points of a subject hang on joints: 0 is the one that stays, then come those of the wires, one a control point.
struct Hanging<'a> {
    wires: &'a [Wire],
    gains: Vec<f64>,
    /// Of each point its joints and their weights, the largest first; at most [`MOST_INFLUENCES`].
    rows: Vec<Vec<(u16, f32)>>,
    /// How many joints a point needs at most, and how many need more than [`ONE_SET`] and than [`MOST_INFLUENCES`].
    most: usize,
    beyond: [usize; 2],
}

impl<'a> Hanging<'a> {
    fn new(wires: &'a [Wire], weights: &Weights, name: impl Fn(usize) -> String) -> Result<Self, JobError> {
        let gains = gains(wires, weights).map_err(|wire| {
            refused(&format!("`{}.amplitude` is below 0 at some places and above at others", name(wire)))
        })?;
        let starts: Vec<usize> = wires
            .iter()
            .scan(1, |next, wire| {
                let first = *next;
                *next += wire.reference.points().len();
                Some(first)
            })
            .collect();
        let mut out = Self { wires, gains, rows: Vec::new(), most: 0, beyond: [0; 2] };
        for point in 0..weights.point_count() {
            let mut row: Vec<(u16, f64)> = Vec::new();
            for part in weights.of(point) {
                let weight = part.weight / out.gains[part.wire as usize];
                if weight > LEAST {
                    row.push(((starts[part.wire as usize] + part.control as usize) as u16, weight));
                }
            }
            let stays = 1.0 - row.iter().map(|(_, weight)| weight).sum::<f64>();
            if stays > LEAST || row.is_empty() {
                row.push((0, stays));
            }
            row.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            out.most = out.most.max(row.len());
            for (beyond, most) in out.beyond.iter_mut().zip([ONE_SET, MOST_INFLUENCES]) {
                *beyond += usize::from(row.len() > most);
            }
            row.truncate(MOST_INFLUENCES);
            out.rows.push(row.into_iter().map(|(joint, weight)| (joint, weight as f32)).collect());
        }
        Ok(out)
    }

    /// Whether a point hangs on more than the joint that stays.
    fn is_moved(&self, point: u32) -> bool {
        self.rows.get(point as usize).is_some_and(|row| row.iter().any(|(joint, _)| *joint > 0))
    }

    /// Makes the joints, and hangs what `shown` show on them. Gives the joints of the control points.
    fn make(
        &self,
        gltf: &mut Gltf,
        rest: &Rest,
        shown: &[usize],
        point_of: &[u32],
    ) -> Result<Hung, JobError> {
        let mut names = vec!["wires".to_owned()];
        let mut places = vec![[0.0; 3]];
        for (w, wire) in self.wires.iter().enumerate() {
            names.extend((0..wire.reference.points().len()).map(|p| format!("wire{w}_p{p}")));
            places.extend_from_slice(wire.reference.points());
        }
        let joint = |(i, (name, place)): (usize, (&'_ String, &[f32; 3]))| {
            let parent = (i > 0).then_some(0);
            (name.clone(), parent, *place)
        };
        let joints: Vec<_> = names.iter().zip(&places).enumerate().map(joint).collect();
        let joints: Vec<NewJoint<'_>> =
            joints.iter().map(|(name, parent, at)| NewJoint::at(name, *parent, *at)).collect();
        let each = self.most.clamp(1, MOST_INFLUENCES);
        let (mut indices, mut weights) = (Vec::new(), Vec::new());
        for block in rest.blocks.iter().filter(|block| shown.contains(&block.node)) {
            for point in &point_of[block.first..block.first + block.count] {
                let mut row = self.rows.get(*point as usize).into_iter().flatten();
                for _ in 0..each {
                    let (joint, weight) = row.next().copied().unwrap_or((0, 0.0));
                    indices.push(joint);
                    weights.push(weight);
                }
            }
        }
        let skin = NewSkin { name: "wires", joints: &joints, each, indices: &indices, weights: &weights };
        let mut hung = gltf.add_skin(rest, shown, &skin)?;
        hung.joints.remove(0);
        Ok(hung)
    }

    fn warnings(&self) -> Vec<String> {
        let [four, eight] = self.beyond;
        let mut out = Vec::new();
        if four > 0 {
            let hang = if four == 1 { "hangs" } else { "hang" };
            out.push(format!(
                "{} {hang} on more than {ONE_SET} joints, up to {}: viewers that read {ONE_SET}, as three.js and Bevy do, show them elsewhere; where \
                 wires do not meet, curves of degree 2 or 1 need no more [skin-influences]",
                count(four, "point"),
                self.most.min(MOST_INFLUENCES)
            ));
        }
        if eight > 0 {
            let has = if eight == 1 { "has" } else { "have" };
            out.push(format!(
                "{} {has} weights of more than {MOST_INFLUENCES} joints, up to {}: the largest {MOST_INFLUENCES} are kept [skin-pruned]",
                count(eight, "point"),
                self.most
            ));
        }
        out
    }
}

/// How many times as far as its control points the joints of each wire are to go, so that weights lie between 0 and 1.
///
/// # Errors
///
/// A wire whose weights have both signs.
fn gains(wires: &[Wire], weights: &Weights) -> Result<Vec<f64>, usize> {
    // The sum of a wire's weights at a point, wire by wire.
    let sums = |point: usize| {
        let of_wires = weights.of(point).chunk_by(|a, b| a.wire == b.wire);
        of_wires.map(|own| (own[0].wire as usize, own.iter().map(|part| part.weight).sum::<f64>()))
    };
    let points = 0..weights.point_count();
    let (mut least, mut most) = (vec![0.0_f64; wires.len()], vec![0.0_f64; wires.len()]);
    for (wire, sum) in points.clone().flat_map(sums) {
        (least[wire], most[wire]) = (least[wire].min(sum), most[wire].max(sum));
    }
    let mut gains = Vec::with_capacity(wires.len());
    for (wire, (least, most)) in least.into_iter().zip(most).enumerate() {
        let size = most.max(-least);
        // Rounding has no sign.
        if least < -LEAST * size.max(1.0) && most > LEAST * size.max(1.0) {
            return Err(wire);
        }
        // No weight is larger than the amplitude, which is a number that means something.
        let gain = if size > WHOLE { amplitude(&wires[wire]).max(size / WHOLE) } else { 1.0 };
        gains.push(if most >= -least { gain } else { -gain });
    }
    let all = |point: usize| sums(point).map(|(wire, sum)| sum / gains[wire]).sum::<f64>();
    let together = points.map(all).fold(1.0, f64::max);
    if together > WHOLE {
        for gain in &mut gains {
            *gain *= together;
        }
    }
    Ok(gains)
}

/// The largest amplitude along a wire, whatever its sign.
fn amplitude(wire: &Wire) -> f64 {
    let carried =
        wire.locators.iter().filter_map(|locator| locator.amplitude).reduce(|a, b| a.abs().max(b.abs()));
    f64::from(carried.unwrap_or(wire.amplitude).abs())
}

/// Where the joints of a wire are.
fn places(wire: &Wire, gain: f64) -> Vec<World> {
    let place = |(rest, now): (&[f32; 3], &[f32; 3])| {
        let [rest, now] = [rest, now].map(|p| DVec3::from_array(p.map(f64::from)));
        let at = if gain == 1.0 { now } else { rest + (now - rest) * gain };
        [WORLD[0], WORLD[1], WORLD[2], at.to_array()]
    };
    wire.reference.points().iter().zip(&wire.pose).map(place).collect()
}

/// When joints get keys at least: where poses have theirs and at both ends, and in every frame where a pose is eased.
fn times(wires: &[KeyedWire], schedule: &Schedule) -> Vec<f64> {
    let keys: Vec<PoseKeys> = wires.iter().map(KeyedWire::pose_keys).collect();
    let (first, last) = schedule.ends();
    let inside = keys.iter().flat_map(|keys| keys.times.iter().copied());
    let mut times: Vec<f64> = inside.filter(|time| (first..last).contains(time)).collect();
    times.extend([first, last]);
    if keys.iter().any(|keys| !keys.linear) {
        times.extend(schedule.moments().map(|(_, seconds)| seconds));
    }
    times.sort_by(f64::total_cmp);
    times.dedup_by(|later, time| *later - *time <= ROUNDING * (1.0 + time.abs()));
    times
}
