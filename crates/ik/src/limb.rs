//! A chain of joints and how it reaches for a goal.
//!
//! \[SF98\] §5.3: "the control polygon of the curve acts like an articulated rigid body", and "a rubberband like behavior by transforming
//! the control points of the curve proportionally along the joint chain based on the motion of the end effector". The paper gives no
//! solver. Here the rigid body takes the shape between its rest and a bow ([`crate::bow`]) that spans the distance to the goal; the plane
//! in which it bends is that of the rest, turned by the least rotation from the direction of the rest to that of the goal.
//! Nothing is remembered from one moment to the next.

use glam::{DQuat, DVec3};
use wirework_core::Keyed;

use crate::cones::Cones;
use crate::error::IkError;
use crate::run::{Run, Stretch};
use crate::settings::Ik;
use crate::turn::{double, least_rotation};
use crate::wire::Spine;

/// Joints nearer to each other than this part of the chain's length are at one place.
const COINCIDENT: f64 = 1e-6;

/// How much of the bend of a chain at rest one that has moved takes over, as a part of the square of its length: so a limb that a clip
/// stretches straight keeps its bend. A twentieth is the area under an elbow bent by 12°.
const KEPT: f64 = 0.05;

/// A chain of joints as a limb, at rest.
#[derive(Clone, Debug)]
pub struct Limb {
    pub(crate) settings: Ik,
    pub(crate) joints: Vec<DVec3>,
    pub(crate) spine: Spine,
    /// Between joints that are held, from the root to the tip.
    runs: Vec<Run>,
    /// Of each bone: its part in the motion of the end of its run.
    shares: Vec<f64>,
    /// Of each bone 0 ..= 1.
    stiffness: Vec<f64>,
    limits: Vec<f64>,
}

/// Where the joints of a limb are at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    pub(crate) joints: Vec<DVec3>,
    /// How the plane of the first bend has turned from its rest.
    pub(crate) turn: DQuat,
}

impl Pose {
    /// The joints, from the root to the tip.
    pub fn joints(&self) -> impl Iterator<Item = [f64; 3]> {
        self.joints.iter().map(DVec3::to_array)
    }

    /// The sum of the lengths of the bones.
    pub fn length(&self) -> f64 {
        self.joints.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }
}

impl Limb {
    /// A limb with these joints at rest, from the root to the tip.
    ///
    /// # Errors
    ///
    /// Fewer than two joints, two at one place, a setting out of range or of another number than the chain asks for.
    pub fn new(joints: &[[f32; 3]], settings: &Ik) -> Result<Self, IkError> {
        let joints: Vec<DVec3> = joints.iter().map(|joint| double(*joint)).collect();
        check_joints(&joints)?;
        settings.check(joints.len())?;
        let bones = joints.len() - 1;
        let mut stiffness: Vec<f64> = settings.stiffness.iter().map(|k| f64::from(*k)).collect();
        stiffness.resize(bones, 0.0);
        let mut limb = Self {
            settings: settings.clone(),
            runs: Vec::new(),
            shares: Vec::new(),
            limits: settings.limits.iter().take(bones).map(|limit| f64::from(*limit)).collect(),
            stiffness,
            spine: Spine::new(&joints, settings)?,
            joints,
        };
        limb.divide(|_| DVec3::ZERO);
        Ok(limb)
    }

    /// The same limb where its joints have moved to, as by a clip: a chain of another rest. It takes over as much of this one's bend
    /// as keeps an arm that is stretched out from bending the other way.
    ///
    /// # Errors
    ///
    /// Another number of joints, two at one place, one that is not finite.
    pub fn moved(&self, joints: &[[f32; 3]]) -> Result<Self, IkError> {
        if joints.len() != self.joints.len() {
            return Err(IkError::Joints { found: joints.len() });
        }
        let joints: Vec<DVec3> = joints.iter().map(|joint| double(*joint)).collect();
        check_joints(&joints)?;
        let spine = Spine::new(&joints, &self.settings)?;
        let mut limb = Self {
            settings: self.settings.clone(),
            joints,
            spine,
            runs: Vec::new(),
            shares: Vec::new(),
            stiffness: self.stiffness.clone(),
            limits: self.limits.clone(),
        };
        let mut first = 0;
        let carried: Vec<DVec3> = self
            .runs
            .iter()
            .map(|run| {
                let last = first + run.bones.len();
                let (was, is) =
                    (self.joints[last] - self.joints[first], limb.joints[last] - limb.joints[first]);
                first = last;
                least_rotation(was, is, || run.normal) * run.normal * (KEPT * run.total * run.total)
            })
            .collect();
        limb.divide(|run| carried[run]);
        Ok(limb)
    }

    /// Divides the chain at joints that are held.
    fn divide(&mut self, bend: impl Fn(usize) -> DVec3) {
        let mut held: Vec<usize> =
            self.settings.pins.iter().map(|pin| pin.joint).filter(|j| *j > 0).collect();
        held.sort_unstable();
        held.push(self.joints.len() - 1);
        let mut first = 0;
        for (index, last) in held.into_iter().enumerate() {
            let run = Run::new(&self.joints[first..=last], bend(index));
            let soft: Vec<f64> =
                run.lengths.iter().zip(&self.stiffness[first..last]).map(|(l, k)| l * (1.0 - k)).collect();
            let whole: f64 = soft.iter().sum();
            // Where nothing gives there is nothing to share; the elasticity is 0 then.
            let whole = if whole > 0.0 { whole } else { f64::INFINITY };
            self.shares.extend(soft.iter().map(|soft| soft / whole));
            self.runs.push(run);
            first = last;
        }
    }

    /// The joints at rest, from the root to the tip.
    pub fn joints(&self) -> impl Iterator<Item = [f64; 3]> {
        self.joints.iter().map(DVec3::to_array)
    }

    /// Where the tip is at rest.
    pub fn tip(&self) -> [f64; 3] {
        self.joints[self.joints.len() - 1].to_array()
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &Ik {
        &self.settings
    }

    /// The joints as they reach for a goal at a time in seconds. With the goal where the tip is at rest, and pins where their joints are,
    /// they are at rest, exactly.
    pub fn pose(&self, goal: [f64; 3], seconds: f64) -> Pose {
        let at = |track: &Keyed<[f32; 3]>| double(track.at(seconds));
        let goal = DVec3::from_array(goal);
        let mut held: Vec<(usize, DVec3)> =
            self.settings.pins.iter().map(|pin| (pin.joint, at(&pin.point))).collect();
        held.push((self.joints.len() - 1, goal));
        if held.iter().all(|(joint, place)| *place == self.joints[*joint]) {
            return Pose { joints: self.joints.clone(), turn: DQuat::IDENTITY };
        }
        held.sort_by_key(|(joint, _)| *joint);
        let root = if held[0].0 == 0 { held.remove(0).1 } else { self.joints[0] };
        let pole = self.settings.pole.as_ref().map(at);
        let elasticity = f64::from(self.settings.elasticity.at(seconds)).clamp(0.0, 1.0);
        let turn = self.runs[0].turn(held[0].1 - root, pole.map(|pole| pole - root));
        let bones = self.bones(root, &held, pole, elasticity);
        let mut joints = vec![root];
        joints.extend(bones.iter().scan(root, |joint, bone| {
            *joint += *bone;
            Some(*joint)
        }));
        Pose { joints, turn }
    }

    /// The bones between rigid and elastic.
    fn bones(
        &self,
        root: DVec3,
        held: &[(usize, DVec3)],
        pole: Option<DVec3>,
        elasticity: f64,
    ) -> Vec<DVec3> {
        let stretch = Stretch {
            most: f64::from(self.settings.max_stretch),
            least: f64::from(self.settings.min_stretch),
            softness: f64::from(self.settings.softness),
        };
        let mut all = Vec::with_capacity(self.joints.len() - 1);
        let (mut base, mut before) = (root, DQuat::IDENTITY);
        for (run, (last, goal)) in self.runs.iter().zip(held) {
            let own = last - run.bones.len()..*last;
            let limits = self.limits.get(own.clone()).unwrap_or_default();
            let cones = Cones { rest: &run.bones, angles: limits, before };
            let (shares, stiffness) = (&self.shares[own.clone()], &self.stiffness[own]);
            let part = elasticity * stiffness.iter().map(|k| 1.0 - k).fold(0.0, f64::max);
            let rigid = || cones.reached(run.rigid(base, *goal, pole));
            let elastic = || cones.reached(run.elastic(base, *goal, pole, (shares, stiffness), stretch));
            let bones = match part {
                0.0 => rigid(),
                1.0 => elastic(),
                // A mean of what keeps within cones need not.
                part => cones.reached(rigid().iter().zip(elastic()).map(|(r, e)| r.lerp(e, part)).collect()),
            };
            before = cones.after(&bones);
            base += bones.iter().sum::<DVec3>();
            all.extend(bones);
        }
        all
    }
}

fn check_joints(joints: &[DVec3]) -> Result<(), IkError> {
    if joints.len() < 2 {
        return Err(IkError::Joints { found: joints.len() });
    }
    let total: f64 = joints.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    if let Some(joint) = joints.iter().position(|joint| !joint.is_finite()) {
        return Err(IkError::NotFinite { joint });
    }
    let near = |pair: &[DVec3]| pair[0].distance(pair[1]) <= COINCIDENT * total;
    match joints.windows(2).position(near) {
        Some(bone) => Err(IkError::Coincident { joint: bone + 1 }),
        None => Ok(()),
    }
}
