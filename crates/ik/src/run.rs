//! Bones between two joints that are held, and how they reach from the one to the other: rigid, or as rubber.

use glam::{DQuat, DVec3};

use crate::bow::Bows;
use crate::root::root;
use crate::turn::{aside, least_rotation};

/// A chain that encloses less than this part of the square of its length with the line between its ends is straight: joints in float32
/// are no more exact.
const STRAIGHT: f64 = 1e-6;

/// Ends nearer than this part of the length give no direction.
const POINT: f64 = 1e-9;

/// Even steps in which bones are brought to a span, and steps that then make it exact.
const STEPS: usize = 16;
const EXACT: usize = 16;

/// The most that a joint turns in such a step, radians.
const LARGEST_TURN: f64 = 0.2;

/// Within this part of the length from the goal at rest a pole that does not lie in the plane of the rest has not turned the limb
/// altogether: at rest it has not turned it at all.
const EASED: f64 = 0.1;

/// No bone is squashed to less than this part of its length where it would be turned round.
const SHORTEST: f64 = 0.01;

/// The bend, as a part of the square of the length, that tells a straight chain to which side it bends: well above [`STRAIGHT`], and
/// nothing beside a bend that is seen.
const BEND: f64 = 1e-5;

/// A run of bones at rest.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// Each bone as a vector.
    pub(crate) bones: Vec<DVec3>,
    pub(crate) lengths: Vec<f64>,
    /// Their sum.
    pub(crate) total: f64,
    /// From the first joint to the last.
    chord: DVec3,
    span: f64,
    /// The unit vector along it.
    direction: DVec3,
    /// The unit normal of the plane in which it bends: turning about it, one bone leads to the next.
    pub(crate) normal: DVec3,
    bows: Bows,
    /// The bow that spans as much as the bones do at rest: the angles of its bones.
    angles: Vec<f64>,
    /// From the bones of that bow to those of the rest, as rotation vectors.
    aside: Vec<DVec3>,
    is_bow: bool,
    is_straight: bool,
}

/// How far rubber stretches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// As factors on the length at rest.
    pub(crate) most: f64,
    pub(crate) least: f64,
    /// Which part of the way to the greatest length is eased.
    pub(crate) softness: f64,
}

impl Run {
    /// The bones between neighbouring ones of at least two joints. `bend` is the normal that a straight chain has, and a part of that of
    /// a nearly straight one; of any length, 0 where there is none.
    pub(crate) fn new(joints: &[DVec3], bend: DVec3) -> Self {
        let bones: Vec<DVec3> = joints.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let lengths: Vec<f64> = bones.iter().map(|bone| bone.length()).collect();
        let total: f64 = lengths.iter().sum();
        let chord = joints[joints.len() - 1] - joints[0];
        let span = chord.length();
        let first = bones[0] / lengths[0];
        let mut direction = if span > POINT * total { chord / span } else { first };
        let area: DVec3 =
            joints.windows(2).map(|pair| (pair[0] - joints[0]).cross(pair[1] - joints[0])).sum();
        let is_straight = span > total * (1.0 - STRAIGHT * STRAIGHT) || {
            let corner = |pair: &[DVec3]| pair[0].cross(pair[1]).length();
            bones.windows(2).map(corner).fold(0.0, f64::max) < STRAIGHT * total * total
        };
        let normal = Self::normal_of(&bones, area + bend, direction, total);
        if span <= POINT * total {
            // Closed: the line between its ends is where a bow has it.
            direction = normal.cross(aside(normal));
        }
        let bows = Bows::new(lengths.clone());
        let arch = if is_straight { 0.0 } else { bows.spanning(span) };
        let mut run = Self {
            bones,
            lengths,
            total,
            chord,
            span,
            direction,
            normal,
            bows,
            angles: Vec::new(),
            aside: Vec::new(),
            is_bow: true,
            is_straight,
        };
        run.bows.angles_into(arch, &mut run.angles);
        let from_bow = |(bone, angle): (&DVec3, &f64)| {
            least_rotation(run.in_plane(*angle), *bone, || run.normal).to_scaled_axis()
        };
        run.aside = run.bones.iter().zip(&run.angles).map(from_bow).collect();
        run.is_bow = run.aside.iter().all(|turn| turn.length() < STRAIGHT);
        run
    }

    /// The normal of the plane of a bend: the area that the chain encloses, or else its sharpest corner, or else so that it bends
    /// towards the coordinate axis least aligned with it.
    fn normal_of(bones: &[DVec3], area: DVec3, direction: DVec3, total: f64) -> DVec3 {
        let noise = STRAIGHT * total * total;
        let across = |v: DVec3| (v - direction * direction.dot(v)).normalize_or_zero();
        if area.length() > noise {
            let normal = across(area);
            if normal != DVec3::ZERO {
                return normal;
            }
        }
        let corners = bones.windows(2).map(|pair| pair[0].cross(pair[1]));
        let sharpest = corners.fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
        if sharpest.length() > noise {
            let normal = across(sharpest);
            if normal != DVec3::ZERO {
                return normal;
            }
        }
        aside(direction).cross(direction)
    }

    /// The direction at an angle against the line between the ends, in the plane of the bend.
    fn in_plane(&self, angle: f64) -> DVec3 {
        self.direction * angle.cos() + self.normal.cross(self.direction) * angle.sin()
    }

    /// The bones of the shape that spans a distance which they can span.
    ///
    /// It bends as the bow does that spans as much, and keeps of what the rest has beside its own bow the less the nearer it comes to where
    /// bones are straight, or a closed bow. What that spans too much or too little the turns of joints make up that change it most.
    fn shape(&self, distance: f64) -> Vec<DVec3> {
        let mut angles = Vec::new();
        self.bows.angles_into(self.bows.spanning(distance), &mut angles);
        if self.is_bow {
            return angles
                .iter()
                .zip(&self.lengths)
                .map(|(angle, length)| self.in_plane(*angle) * *length)
                .collect();
        }
        let end = if distance < self.span { self.bows.least() } else { self.total };
        let kept = ((distance - end) / (self.span - end)).clamp(0.0, 1.0);
        let bone = |(i, angle): (usize, &f64)| {
            let turned = DQuat::from_scaled_axis(self.aside[i] * kept) * self.in_plane(self.angles[i]);
            DQuat::from_axis_angle(self.normal, angle - self.angles[i]) * turned * self.lengths[i]
        };
        spanned(angles.iter().enumerate().map(bone).collect(), self.total, distance)
    }

    /// The bones, of their own lengths, so that they reach from `base` to `goal`, or as far towards it as they can.
    pub(crate) fn rigid(&self, base: DVec3, goal: DVec3, pole: Option<DVec3>) -> Vec<DVec3> {
        let to = goal - base;
        let distance = to.length();
        let ahead = if distance > POINT * self.total { to / distance } else { self.direction };
        if distance >= self.total {
            return self.lengths.iter().map(|length| ahead * *length).collect();
        }
        let bones = self.shape(distance);
        let chord: DVec3 = bones.iter().sum();
        let level = if chord.length() > POINT * self.total {
            least_rotation(chord, self.direction, || self.normal)
        } else {
            DQuat::IDENTITY
        };
        let pole = pole.map(|pole| pole - base);
        let side = DQuat::from_axis_angle(ahead, self.towards(to, pole));
        let turn = side * least_rotation(self.direction, ahead, || self.normal) * level;
        bones.into_iter().map(|bone| turn * bone).collect()
    }

    /// How what hangs on the bones turns as their end moves to `to`, counted from their first joint: with the line between their ends, and
    /// with the plane in which they bend where they are bent at rest.
    pub(crate) fn turn(&self, to: DVec3, pole: Option<DVec3>) -> DQuat {
        let turn = least_rotation(self.direction, to, || self.normal);
        if self.is_straight {
            return turn;
        }
        DQuat::from_axis_angle(to.normalize_or(self.direction), self.towards(to, pole)) * turn
    }

    /// The angle about the line to the goal that brings the bend to the side of a pole, both counted from the first joint.
    fn towards(&self, to: DVec3, pole: Option<DVec3>) -> f64 {
        let Some(pole) = pole else { return 0.0 };
        let ahead = to.normalize_or(self.direction);
        let across = |v: DVec3| v - ahead * ahead.dot(v);
        // A bow bulges away from where its bones turn to.
        let bulge = self.direction.cross(self.normal);
        let now = least_rotation(self.direction, ahead, || self.normal) * bulge;
        let wanted = across(pole);
        if wanted.length() <= POINT * self.total {
            return 0.0;
        }
        let angle = now.cross(wanted).dot(ahead).atan2(now.dot(wanted));
        // At rest nothing turns.
        let moved = to.distance(self.chord) / (EASED * self.total);
        if self.is_straight || moved >= 1.0 { angle } else { angle * moved * moved * (3.0 - 2.0 * moved) }
    }

    /// The bones as a rubber band from `base` to `goal`: each takes its part of the motion of the end, by its length, but for stiff ones: these
    /// turn as rigid ones do, and the others take up the difference by their shares. Where that makes them longer than
    /// they may be they straighten out. Where it makes them shorter they stay as short as they may be and bend: as rigid bones that have
    /// their lengths and their shape then.
    pub(crate) fn elastic(
        &self,
        base: DVec3,
        goal: DVec3,
        pole: Option<DVec3>,
        (shares, stiffness): (&[f64], &[f64]),
        stretch: Stretch,
    ) -> Vec<DVec3> {
        let to = goal - base;
        let reach = stretch.eased(to.length(), self.total);
        let ahead = to.normalize_or(self.direction);
        let pole = pole.map(|pole| pole - base);
        let stiff = stiffness.iter().any(|k| *k > 0.0);
        let sheared = |far: f64| -> Vec<DVec3> {
            let pull = (ahead * far - self.chord) / self.total;
            let mut bones: Vec<DVec3> =
                self.bones.iter().zip(&self.lengths).map(|(b, l)| b + pull * *l).collect();
            if stiff {
                let rigid = self.rigid(DVec3::ZERO, ahead * far, pole);
                for ((bone, rigid), k) in bones.iter_mut().zip(rigid).zip(stiffness) {
                    *bone = bone.lerp(rigid, *k);
                }
                let left = ahead * far - bones.iter().sum::<DVec3>();
                bones.iter_mut().zip(shares).for_each(|(bone, share)| *bone += left * *share);
            }
            bones
        };
        let floor = if stiff { self.span - self.give(shares, stretch) } else { 0.0 };
        let mut far = reach.max(floor);
        let mut bones = sheared(far);
        let (most, least) = (stretch.most * self.total, stretch.least * self.total);
        if length(&bones) < least {
            far = root(|far| length(&sheared(far)) - least, far, far + self.span + least);
            bones = sheared(far);
        }
        let own = length(&bones);
        if own > most {
            let straight: Vec<DVec3> = bones.iter().map(|bone| ahead * (bone.length() * far / own)).collect();
            let between = |part: f64| straight.iter().zip(&bones).map(move |(s, b)| s.lerp(*b, part));
            let part = root(|part| between(part).map(DVec3::length).sum::<f64>() - most, 0.0, 1.0);
            bones = between(part).collect();
        }
        if far <= reach {
            return bones;
        }
        let mut joints = vec![DVec3::ZERO];
        joints.extend(bones.iter().scan(DVec3::ZERO, |joint, bone| {
            *joint += *bone;
            Some(*joint)
        }));
        // What is straight bends to the side to which the rest does.
        let bend = self.turn(to, pole) * self.normal * (BEND * self.total * self.total);
        Run::new(&joints, bend).rigid(DVec3::ZERO, ahead * reach, pole)
    }

    /// By how much the ends may come nearer to each other before the first bone of a straight chain is as short as it may be.
    fn give(&self, shares: &[f64], stretch: Stretch) -> f64 {
        let most = 1.0 - stretch.least.max(SHORTEST);
        self.lengths
            .iter()
            .zip(shares)
            .map(|(length, share)| length * most / share)
            .fold(f64::INFINITY, f64::min)
    }
}

/// Bones brought to a span by the turns of joints that change it most, in even steps: what comes out depends on the span alone, and
/// continuously, for it is a flow along one path.
fn spanned(mut bones: Vec<DVec3>, total: f64, span: f64) -> Vec<DVec3> {
    for step in 0..STEPS + EXACT {
        let chord: DVec3 = bones.iter().sum();
        let now = chord.length();
        let steps_left = STEPS.saturating_sub(step).max(1);
        let change = (span - now) / steps_left as f64;
        if step >= STEPS && change.abs() < POINT * total {
            break;
        }
        // Turning all from a joint on by ω changes the span by ω·(t × c), t from that joint to the end, c along the chord.
        let ahead = chord.normalize_or(DVec3::X);
        let mut rest_of_it = chord;
        let ways: Vec<DVec3> = bones
            .iter()
            .map(|bone| {
                let way = rest_of_it.cross(ahead);
                rest_of_it -= *bone;
                way
            })
            .collect();
        let sum: f64 = ways.iter().skip(1).map(|way| way.length_squared()).sum();
        if sum <= POINT * POINT * total * total {
            break;
        }
        let largest = ways.iter().skip(1).map(|way| way.length()).fold(0.0, f64::max) * change.abs() / sum;
        let part = change / sum * if largest > LARGEST_TURN { LARGEST_TURN / largest } else { 1.0 };
        let mut turn = DVec3::ZERO;
        for (bone, way) in bones.iter_mut().zip(&ways).skip(1) {
            turn += *way * part;
            *bone = DQuat::from_scaled_axis(turn) * *bone;
        }
    }
    bones
}

/// The sum of the lengths of bones.
fn length(bones: &[DVec3]) -> f64 {
    bones.iter().map(|bone| bone.length()).sum()
}

impl Stretch {
    /// A distance, eased into the greatest length.
    fn eased(self, distance: f64, total: f64) -> f64 {
        let most = self.most * total;
        let soft = self.softness * (most - total);
        let onset = most - soft;
        if distance <= onset || soft <= 0.0 {
            return distance.min(most);
        }
        onset + soft * (1.0 - (-(distance - onset) / soft).exp())
    }
}
