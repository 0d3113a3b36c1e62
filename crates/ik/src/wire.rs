//! A limb as a wire.
//!
//! \[SF98\] §5.3: "The curve then deforms the object geometry associated with the joint hierarchy as a wire. We use a large dropoff radius `r`
//! so we can assume that every point on the geometry will track the curve equally and precisely", and "the arc-length of the wire
//! curve is used to modulate the wire scale factor `s`": `s = (L₀/L)^(volume/2)`, with which a tube keeps its volume, since that is its
//! length times the square of its radius.
//!
//! Frames are transported from the root, where they turn as the plane of the bend does: first with the line to the goal, then within the plane.
//! The least rotation of the first bone alone would flip where a bow turns that bone against its rest. The difference is a twist that is the
//! same all along.
//!
//! Points of `R` and `W` belong together by parameter: joints to joints, so that a stiff bone keeps its skin. A bone's curve runs
//! through points of it, at fractions that stay, so where a bone stretches the curve along it does, evenly.

use glam::{DQuat, DVec3};
use wirework_core::{Bend, Curve, CurveKind, Locator, Wire};

use crate::error::IkError;
use crate::limb::{Limb, Pose};
use crate::settings::{ChainCurve, Ik, Influence, ScaleBy, Tip};
use crate::turn::{aside, least_rotation};

/// A radius at which `F`, in float32, is 1 wherever there are points.
const EVERYWHERE: f32 = 1e15;

/// Degree of the paper's curve.
const CHAIN_DEGREE: u8 = 3;

/// The fraction of the last bone over which a held tip comes to its direction, where the curve has none of its own.
const HELD: f64 = 0.25;

/// The largest such fraction: the point before it may be half the bone away.
const MOST_HELD: f64 = 0.4;

/// Steps in which frames go along a segment of the paper's curve; one along those of the rounded one, which are plane.
const STEPS: usize = 32;

/// Locators in each segment of the curve, where attributes change along it: between them twist and scale are linear in the parameter
/// and not in the length. Where the speed in a segment doubles, twist is off by a thousandth of what it gains there.
const LOCATORS: usize = 8;

/// Local stretch of less than this counts as this: where a curve stands still the scale would have no end.
const LEAST_STRETCH: f64 = 0.05;

/// The curve of a chain at rest.
#[derive(Clone, Debug)]
pub(crate) struct Spine {
    reference: Curve,
    length: f64,
    /// Parameters of locators, rising, and the arc length up to each; empty where no attribute changes along the limb.
    stops: Vec<f64>,
    along: Vec<f64>,
    /// The parameter nearest to the middle of each bone.
    middles: Vec<f64>,
}

impl Spine {
    pub(crate) fn new(joints: &[DVec3], settings: &Ik) -> Result<Self, IkError> {
        let points = controls(joints, settings, held_direction(joints, DQuat::IDENTITY));
        let degree = match settings.curve {
            ChainCurve::Rounded(_) => 2,
            ChainCurve::Chain => CHAIN_DEGREE,
        };
        let segments = points.len() - usize::from(degree).min(points.len() - 1);
        let reference = Curve::bspline(degree, points).map_err(|_| IkError::NotFinite { joint: 0 })?;
        let steps = segments * LOCATORS;
        let stops: Vec<f64> = if is_uneven(settings) {
            (0..=steps).map(|i| i as f64 / steps as f64).collect()
        } else {
            Vec::new()
        };
        let along = reference.lengths(stops.iter().copied());
        let length = reference.lengths([1.0])[0];
        let middle = |pair: &[DVec3]| {
            let foot = reference.closest(pair[0].midpoint(pair[1]).as_vec3().to_array());
            foot.map_or(0.5, |foot| f64::from(foot.u))
        };
        let middles = joints.windows(2).map(middle).collect();
        Ok(Self { reference, length, stops, along, middles })
    }
}

/// Whether scale or twist may change along the limb.
fn is_uneven(settings: &Ik) -> bool {
    settings.scale_by == ScaleBy::Local
        || settings.tip != Tip::Follow
        || settings.twist.values().any(|twist| *twist != 0.0)
}

/// The direction of the last bone at rest, turned.
fn held_direction(joints: &[DVec3], turn: DQuat) -> DVec3 {
    let [.., before, tip] = joints else { return DVec3::ZERO };
    turn * (tip - before).normalize_or_zero()
}

/// The control points of the curve through a chain; a held tip comes in from `direction`.
fn controls(joints: &[DVec3], settings: &Ik, direction: DVec3) -> Vec<[f32; 3]> {
    let mut points = vec![joints[0]];
    let rounded = match settings.curve {
        ChainCurve::Rounded(part) => Some(f64::from(part)),
        ChainCurve::Chain => None,
    };
    for corner in joints.windows(3) {
        match rounded {
            Some(part) => {
                // Where a bone is rounded up to its middle from both ends, that is one point: with two the curve would stand still there.
                if part < 0.5 || points.len() == 1 {
                    points.push(corner[1].lerp(corner[0], part));
                }
                points.extend([corner[1], corner[1].lerp(corner[2], part)]);
            }
            None => points.push(corner[1]),
        }
    }
    let [.., before, tip] = joints else { return Vec::new() };
    if let Tip::Hold(_) = settings.tip {
        points.push(tip - direction * (tip.distance(*before) * rounded.unwrap_or(HELD).min(MOST_HELD)));
    }
    points.push(*tip);
    points.iter().map(|point| point.as_vec3().to_array()).collect()
}

/// What becomes of a bone: its points go to `to + rotation·S·(P − from)`, where `S` scales by `stretch` along `along` and by `scale` across
/// it. As good as the limb's own wire along a straight bone, and the tip's share of what lies beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoneFrame {
    /// Where the joint is at rest.
    pub from: [f64; 3],
    /// Where it is now.
    pub to: [f64; 3],
    /// The turn of the bone, at its middle; a unit quaternion, `[x, y, z, w]`.
    pub rotation: [f64; 4],
    /// The direction of the bone at rest, a unit vector; of the tip that of the last bone.
    pub along: [f64; 3],
    /// Its length, as a factor on that at rest; of the tip the scale.
    pub stretch: f64,
    /// The radial scale.
    pub scale: f64,
}

impl Limb {
    /// The wire at rest: its reference is the curve of the chain.
    pub fn wire(&self) -> Wire {
        let mut wire = Wire::new(self.spine.reference.clone());
        wire.radius = match self.settings.influence {
            Influence::Radius(radius) => radius,
            Influence::All | Influence::SkinWeights => EVERYWHERE,
        };
        wire.bend = Bend::Transport;
        wire.closest = self.settings.closest;
        let locator =
            |u: &f64| Locator { u: *u as f32, twist: Some(0.0), scale: Some(1.0), ..Locator::default() };
        wire.locators = self.spine.stops.iter().map(locator).collect();
        wire
    }

    /// Brings [`Limb::wire`], of this limb or of the one that it was [moved](Limb::moved) from, to a pose at a time in seconds.
    pub fn wire_into(&self, pose: &Pose, seconds: f64, wire: &mut Wire) {
        let held = match self.settings.tip {
            Tip::Follow => DQuat::IDENTITY,
            Tip::Hold(angles) => {
                let [x, y, z] = angles.map(f64::from);
                DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x)
            }
        };
        wire.reference.clone_from(&self.spine.reference);
        wire.pose = controls(&pose.joints, &self.settings, held_direction(&self.joints, held));
        self.stretch_into(pose, wire);
        self.twist_into(pose, seconds, held, wire);
    }

    /// Sets the twist: what the limb is to have, from the root on as its plane turns; where its tip is held so that it ends with `held`.
    fn twist_into(&self, pose: &Pose, seconds: f64, held: DQuat, wire: &mut Wire) {
        wire.twist = 0.0;
        wire.locators.iter_mut().for_each(|locator| locator.twist = Some(0.0));
        let (mut root, mut tip) = (0.0, f64::from(self.settings.twist.at(seconds)));
        if pose.joints != self.joints {
            let bone = |joints: &[DVec3]| joints[1] - joints[0];
            let own =
                least_rotation(pose.turn * bone(&self.joints), bone(&pose.joints), || DVec3::X) * pose.turn;
            let (rest, now) = (bone(&self.joints).normalize_or_zero(), bone(&pose.joints));
            // What the wire does there without a twist.
            let bend = least_rotation(rest, now, || rest.cross(aside(rest)));
            root = roll(bend, own, rest);
        }
        if self.settings.tip != Tip::Follow {
            let Ok(now) = wire.reference.posed(wire.pose.clone()) else { return };
            let [rest, now] = [&wire.reference, &now].map(transported);
            let start = least_rotation(rest.first, now.first, || rest.first.cross(aside(rest.first)));
            let bend = now.turn * start * rest.turn.inverse();
            tip += within_turn(roll(bend, held, rest.last) - root);
        }
        wire.twist = root as f32;
        let Spine { along, length, .. } = &self.spine;
        for (locator, along) in wire.locators.iter_mut().zip(along) {
            locator.twist = Some((root + tip * along / length) as f32);
        }
    }

    /// Sets the scale of the wire by its length.
    fn stretch_into(&self, pose: &Pose, wire: &mut Wire) {
        let Spine { reference, length, stops, along, .. } = &self.spine;
        wire.scale = 1.0;
        // A pose that overflows is refused where it is bound.
        let Ok(now) = reference.posed(wire.pose.clone()) else { return };
        let exponent = -0.5 * f64::from(self.settings.volume);
        let scale = |stretch: f64| {
            let scale = stretch.max(LEAST_STRETCH).powf(exponent) as f32;
            if scale.is_finite() { scale } else { 1.0 }
        };
        let at_rest = pose.joints == self.joints;
        if self.settings.scale_by == ScaleBy::Length {
            let stretch = now.lengths([1.0])[0] / length;
            wire.scale = if at_rest { 1.0 } else { scale(stretch) };
            wire.locators.iter_mut().for_each(|locator| locator.scale = Some(wire.scale));
            return;
        }
        let stretched = now.lengths(stops.iter().copied());
        let last = stops.len().saturating_sub(1);
        for (i, locator) in wire.locators.iter_mut().enumerate() {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            let stretch = (stretched[b] - stretched[a]) / (along[b] - along[a]);
            locator.scale = Some(if at_rest { 1.0 } else { scale(stretch) });
        }
    }

    /// Parameters of the curve at the joints, and at `between` points on each bone between two of them, at equal distances: from 0 to 1, rising.
    pub fn places(&self, between: usize) -> Vec<f64> {
        let steps = between + 1;
        let curve = &self.spine.reference;
        let on_bone = |pair: &[DVec3]| -> Vec<f64> {
            let place = |i: usize| pair[0].lerp(pair[1], i as f64 / steps as f64).as_vec3().to_array();
            (0..steps).filter_map(|i| curve.closest(place(i)).map(|foot| f64::from(foot.u))).collect()
        };
        let mut all: Vec<f64> = self.joints.windows(2).flat_map(on_bone).skip(1).collect();
        all.retain(|u| *u > 0.0 && *u < 1.0);
        all.sort_by(f64::total_cmp);
        all.dedup();
        [0.0].into_iter().chain(all).chain([1.0]).collect()
    }

    /// What becomes of each bone, and of what hangs on the tip, where `wire` is [in this pose](Limb::wire_into): for those who animate
    /// bones. One for each joint.
    pub fn bone_frames(&self, pose: &Pose, wire: &Wire) -> Vec<BoneFrame> {
        let places: Vec<f64> = self.spine.middles.iter().copied().chain([1.0]).collect();
        let stations = wire.stations(&places);
        let bones = self.joints.len() - 1;
        let frame = |(j, station): (usize, &wirework_core::Station)| {
            let bone = j.min(bones - 1);
            let (rest, now) =
                (self.joints[bone + 1] - self.joints[bone], pose.joints[bone + 1] - pose.joints[bone]);
            let mut rotation = DQuat::from_array(station.rotation);
            let mut stretch = station.scale;
            if j < bones {
                rotation = least_rotation(rotation * rest, now, || DVec3::X) * rotation;
                stretch = now.length() / rest.length();
            }
            BoneFrame {
                from: self.joints[j].to_array(),
                to: pose.joints[j].to_array(),
                rotation: rotation.normalize().to_array(),
                along: rest.normalize_or_zero().to_array(),
                stretch,
                scale: station.scale,
            }
        };
        stations.iter().enumerate().map(frame).collect()
    }
}

/// A frame carried along a curve.
struct Transported {
    /// The tangents at both ends.
    first: DVec3,
    last: DVec3,
    /// The turn from the one to the other.
    turn: DQuat,
}

/// Carries a frame from the start of a curve to its end, without turning it about the tangent: in a plane, the least rotation does that, and
/// else in small steps.
fn transported(curve: &Curve) -> Transported {
    let degree = match curve.kind() {
        CurveKind::BSpline { degree } => usize::from(degree).min(curve.points().len() - 1),
        _ => 1,
    };
    let segments = curve.points().len() - degree;
    let steps = segments * if degree > 2 { STEPS } else { 1 };
    let at = curve.at((0..=steps).map(|i| i as f64 / steps as f64));
    let tangents: Vec<DVec3> = at.into_iter().map(|(_, tangent)| DVec3::from_array(tangent)).collect();
    let turn = tangents.windows(2).fold(DQuat::IDENTITY, |turn, pair| {
        (least_rotation(pair[0], pair[1], || aside(pair[0])) * turn).normalize()
    });
    Transported { first: tangents[0], last: tangents[steps], turn }
}

/// The angle about a tangent that is left between how a wire bends there and how it is to turn, from −π to π.
fn roll(bend: DQuat, turn: DQuat, tangent: DVec3) -> f64 {
    let left = bend.inverse() * turn;
    within_turn(2.0 * left.xyz().dot(tangent).atan2(left.w))
}

/// The same angle from −π to π.
fn within_turn(angle: f64) -> f64 {
    angle - (angle / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
