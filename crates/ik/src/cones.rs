//! Joints that may turn only so far.
//!
//! The bone at a joint keeps within a cone about the direction that it has at rest, carried along by the bone before it: by the least
//! rotation at each joint, from the root on. Where a pose leaves its cones it is turned back into them, and then, in turn, towards its goal by
//! all joints at once and back into them: joints at their border give their part to the others. Where the goal can be
//! reached so, or nearly, the pose follows it as the one without cones does. Where it cannot there may be two ways to come near it, to one
//! side and to the other, and the pose steps from the one to the other.

use glam::{DMat3, DQuat, DVec3};

use crate::turn::{aside, least_rotation};

/// Rounds of turning joints at most: where half of them stand at their borders each round leaves half of what is missing.
const ROUNDS: usize = 40;

/// A round that brings the end nearer by less than this part of the length is one in vain.
const NEARER: f64 = 1e-4;

/// After so many of these in a row it comes no nearer.
const STALLED: u32 = 3;

/// Added to what a turn of all joints moves the end by, as a part of that, so that a limb that points at its goal does not thrash.
const DAMPING: f64 = 0.3;

/// Joints that stand at their borders give their part to the others, which may bring these to theirs: so often.
const PASSES: usize = 3;

/// A bone this near to the border of its cone, radians, begins to feel it.
const ROOM: f64 = 0.05;

/// The most that a joint turns in a round, radians.
const LARGEST_TURN: f64 = 0.5;

/// This part of the length from the goal is there.
const THERE: f64 = 1e-6;

/// The cones of consecutive bones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cones<'a> {
    /// The bones at rest.
    pub(crate) rest: &'a [DVec3],
    /// Half angles, radians; none is free.
    pub(crate) angles: &'a [f64],
    /// How the bone before has turned from its rest.
    pub(crate) before: DQuat,
}

impl Cones<'_> {
    /// Turns bones into their cones, each with all that come after it. Gives of each the axis about which it turns out of its cone, and how
    /// much room is left there: 0 at the border ..= 1 well inside.
    fn clamp(&self, bones: &mut [DVec3], borders: &mut Vec<(DVec3, f64)>) {
        let mut frame = self.before;
        borders.clear();
        for i in 0..bones.len() {
            let axis = frame * self.rest[i];
            let across = axis.cross(bones[i]);
            let limit = self.angles.get(i).copied().unwrap_or(f64::INFINITY);
            let angle = across.length().atan2(axis.dot(bones[i]));
            if angle > limit {
                let about = across.try_normalize().unwrap_or_else(|| aside(axis.normalize_or_zero()));
                let back = DQuat::from_axis_angle(about, limit - angle);
                bones[i..].iter_mut().for_each(|bone| *bone = back * *bone);
            }
            borders.push((across.normalize_or_zero(), ((limit - angle) / ROOM).clamp(0.0, 1.0)));
            frame = least_rotation(axis, bones[i], || aside(axis.normalize_or_zero())) * frame;
        }
    }

    /// The bones turned into their cones, and so that their end is as near to where it was as it can be.
    pub(crate) fn reached(&self, mut bones: Vec<DVec3>) -> Vec<DVec3> {
        if !self.angles.is_empty() {
            let end = bones.iter().sum();
            self.reach(&mut bones, end);
        }
        bones
    }

    /// How the last bone has turned from its rest.
    pub(crate) fn after(&self, bones: &[DVec3]) -> DQuat {
        self.rest.iter().zip(bones).fold(self.before, |frame, (rest, bone)| {
            let axis = frame * *rest;
            least_rotation(axis, *bone, || aside(axis.normalize_or_zero())) * frame
        })
    }

    /// By how much the bone that is farthest out of its cone is so, radians; negative inside.
    fn excess(&self, bones: &[DVec3]) -> f64 {
        let mut frame = self.before;
        let excess = |(i, bone): (usize, &DVec3)| {
            let axis = frame * self.rest[i];
            frame = least_rotation(axis, *bone, || aside(axis.normalize_or_zero())) * frame;
            axis.angle_between(*bone) - self.angles.get(i).copied().unwrap_or(f64::INFINITY)
        };
        bones.iter().enumerate().map(excess).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Takes bones back towards their rest until they are inside their cones.
    fn inside(&self, bones: &mut [DVec3]) {
        let turns: Vec<DVec3> = self
            .rest
            .iter()
            .zip(&*bones)
            .map(|(rest, bone)| {
                let axis = self.before * *rest;
                least_rotation(axis, *bone, || aside(axis.normalize_or_zero())).to_scaled_axis()
            })
            .collect();
        let lengths: Vec<f64> = bones.iter().map(|bone| bone.length()).collect();
        let mut place = |part: f64| {
            for (i, bone) in bones.iter_mut().enumerate() {
                let axis = (self.before * self.rest[i]).normalize_or_zero();
                *bone = DQuat::from_scaled_axis(turns[i] * part) * axis * lengths[i];
            }
            self.excess(bones)
        };
        let part = crate::root::root(&mut place, 0.0, 1.0);
        place(part);
    }

    /// Turns bones into their cones, and so that their end comes as near to a goal as it can.
    pub(crate) fn reach(&self, bones: &mut [DVec3], goal: DVec3) {
        if self.excess(bones) > 0.0 {
            self.inside(bones);
        }
        let total: f64 = bones.iter().map(|bone| bone.length()).sum();
        let (mut least, mut stalled) = (f64::INFINITY, 0);
        let mut borders = Vec::with_capacity(bones.len());
        self.clamp(bones, &mut borders);
        for _ in 0..ROUNDS {
            let end: DVec3 = bones.iter().sum();
            let miss = goal - end;
            let far = miss.length();
            stalled = if far > least - NEARER * total { stalled + 1 } else { 0 };
            least = least.min(far);
            if far < THERE * total || stalled == STALLED {
                return;
            }
            step(bones, (miss, end), &borders);
            self.clamp(bones, &mut borders);
        }
    }
}

/// Turns all joints at once so that the end moves by `miss`, as far as it can to first order and cones let it: the least of all such
/// turns, in the sum of their squares.
fn step(bones: &mut [DVec3], (miss, end): (DVec3, DVec3), borders: &[(DVec3, f64)]) {
    let mut joint = DVec3::ZERO;
    let arm = |bone: &DVec3| {
        let arm = end - joint;
        joint += *bone;
        arm
    };
    let arms: Vec<DVec3> = bones.iter().map(arm).collect();
    let reach: f64 = arms.iter().map(|arm| arm.length_squared()).sum();
    let damping = DAMPING * reach.sqrt() * miss.length();
    let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
    // By what a push on the end moves it: every joint turns by `arm × push`, which moves the end by that `× arm`.
    let free =
        arms.iter().fold(DMat3::from_diagonal(DVec3::splat(damping + reach)), |m, arm| m - outer(*arm));
    let mut turns = vec![DVec3::ZERO; bones.len()];
    // How much of what would take a bone out of its cone is left to it.
    let mut left = vec![1.0; bones.len()];
    for _ in 0..PASSES {
        // What joints at their borders hold back of a turn about `out` they hold back of the way of the end along `out × arm`.
        let ways = || arms.iter().zip(borders).zip(&left);
        let held = ways().filter(|(_, left)| **left < 1.0);
        let moved = held.fold(free, |m, ((arm, (out, _)), left)| m - outer(out.cross(*arm)) * (1.0 - left));
        let push = moved.inverse() * miss;
        if !push.is_finite() {
            return;
        }
        for (turn, ((arm, (out, _)), left)) in turns.iter_mut().zip(ways()) {
            let whole = arm.cross(push);
            *turn = whole - *out * (out.dot(whole) * (1.0 - left));
        }
        let mut changed = false;
        for ((left, turn), (out, slack)) in left.iter_mut().zip(&turns).zip(borders) {
            if turn.dot(*out) > 0.0 && *left != *slack {
                (*left, changed) = (*slack, true);
            }
        }
        if !changed {
            break;
        }
    }
    let largest = turns.iter().map(|turn| turn.length()).fold(0.0, f64::max);
    let part = if largest > LARGEST_TURN { LARGEST_TURN / largest } else { 1.0 };
    let mut sum = DVec3::ZERO;
    for (bone, turn) in bones.iter_mut().zip(&turns) {
        sum += *turn * part;
        *bone = DQuat::from_scaled_axis(sum) * *bone;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Run;

    /// Numbers from 0 to 1 without a pattern.
    fn noise(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A pose within cones, from random turns.
    fn posed(rest: &[DVec3], angles: &[f64], seed: &mut u64) -> Vec<DVec3> {
        let mut frame = DQuat::IDENTITY;
        let bone = |(rest, limit): (&DVec3, &f64)| {
            let axis = frame * *rest;
            let (across, turn) = (aside(axis.normalize()), noise(seed) * std::f64::consts::TAU);
            let about = DQuat::from_axis_angle(axis.normalize(), turn) * across;
            let bone = DQuat::from_axis_angle(about, 0.97 * limit * noise(seed).sqrt()) * axis;
            frame = least_rotation(axis, bone, || about) * frame;
            bone
        };
        rest.iter().zip(angles).map(bone).collect()
    }

    #[test]
    fn what_cones_can_reach_they_mostly_do() {
        let mut seed = 7;
        let (mut reached, mut all) = (0, 0);
        for count in 2..9 {
            for _ in 0..100 {
                let rest: Vec<DVec3> = (0..count)
                    .map(|_| {
                        DVec3::new(1.0, noise(&mut seed) - 0.5, noise(&mut seed) - 0.5)
                            * (0.3 + noise(&mut seed))
                    })
                    .collect();
                let angles: Vec<f64> = (0..count).map(|_| 0.2 + noise(&mut seed)).collect();
                let goal: DVec3 = posed(&rest, &angles, &mut seed).iter().sum();
                let mut joints = vec![DVec3::ZERO];
                joints.extend(rest.iter().scan(DVec3::ZERO, |joint, bone| {
                    *joint += *bone;
                    Some(*joint)
                }));
                let run = Run::new(&joints, DVec3::ZERO);
                let mut bones = run.rigid(DVec3::ZERO, goal, None);
                let cones = Cones { rest: &rest, angles: &angles, before: DQuat::IDENTITY };
                cones.reach(&mut bones, goal);
                assert!(cones.excess(&bones) < 1e-9);
                for (bone, rest) in bones.iter().zip(&rest) {
                    assert!((bone.length() - rest.length()).abs() < 1e-9);
                }
                all += 1;
                reached += u32::from(bones.iter().sum::<DVec3>().distance(goal) < 1e-3 * run.total);
            }
        }
        assert!(reached * 100 >= all * 99, "{reached} of {all}");
    }
}
