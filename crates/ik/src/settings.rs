//! What a limb is, as a preset says it.

use std::ops::RangeInclusive;

use wirework_core::{Closest, Keyed, LARGEST_TWIST};

use crate::error::IkError;

/// The settings of a limb: all but where its joints are and where its tip is to go. Lengths are in the unit of the joints; bones
/// count from the root, bone `i` leads from joint `i` to joint `i + 1`.
#[derive(Clone, Debug, PartialEq)]
pub struct Ik {
    /// What becomes of the bones at joints. Default [`ChainCurve::Rounded`] of 0.25.
    pub curve: ChainCurve,
    /// A point towards which the limb bends: its inner joints lie on that side of the line from root to goal, in the plane of the
    /// three. Default none: the bend that the chain has at rest.
    pub pole: Option<Keyed<[f32; 3]>>,
    /// \[SF98\] §5.3: 0 rigid bones ..= 1 a rubber band. Default 0.5.
    pub elasticity: Keyed<f32>,
    /// Of each bone, 0 ..= 1: at 1 it keeps its length and turns as a rigid one does, whatever the elasticity, and the others give.
    /// Empty, which is the default: 0 for all.
    pub stiffness: Vec<f32>,
    /// Of each joint but the tip, in radians, > 0: how far its bone may turn from its direction at rest as the bone before it carries
    /// that. Empty, which is the default: as far as it likes. One for the tip may stand at the end and does nothing.
    pub limits: Vec<f32>,
    /// Joints that are held. Default none.
    pub pins: Vec<Pin>,
    /// The greatest length, as a factor on that at rest, ≥ 1. Default 2.
    pub max_stretch: f32,
    /// The least length that it is squashed to, as a factor on that at rest, 0 ..= 1: nearer goals bend it instead. Default 0.3.
    pub min_stretch: f32,
    /// Which part of the way from the length at rest to the greatest is eased, 0 ..= 1. Default 0.1.
    pub softness: f32,
    /// How much of the volume is kept, 0 ..= 1: the radial scale is `(L₀/L)^(volume/2)`. Default 1.
    pub volume: f32,
    /// What `L` is. Default [`ScaleBy::Length`].
    pub scale_by: ScaleBy,
    /// Turn about the limb at its tip, radians, spread by arc length; two turns are 4π. Default 0.
    pub twist: Keyed<f32>,
    /// Which way the tip points. Default [`Tip::Follow`].
    pub tip: Tip,
    /// What follows the limb. Default [`Influence::All`].
    pub influence: Influence,
    /// Which feet of a point on the curve count, as of any wire. Default [`Closest::Smallest`].
    pub closest: Closest,
}

impl Default for Ik {
    fn default() -> Self {
        Self {
            curve: ChainCurve::Rounded(0.25),
            pole: None,
            elasticity: Keyed::Constant(0.5),
            stiffness: Vec::new(),
            limits: Vec::new(),
            pins: Vec::new(),
            max_stretch: 2.0,
            min_stretch: 0.3,
            softness: 0.1,
            volume: 1.0,
            scale_by: ScaleBy::Length,
            twist: Keyed::Constant(0.0),
            tip: Tip::Follow,
            influence: Influence::All,
            closest: Closest::Smallest,
        }
    }
}

/// \[SF98\] §5.3: the curve that takes the place of a joint chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChainCurve {
    /// Along the bones, rounded at joints: degree 2, its control points are the joints and, on both sides of each inner joint, the points
    /// at this fraction of the bone from it, > 0 and ≤ 0.5.
    Rounded(f32),
    /// The paper's: the joints are the control polygon of a cubic B-spline.
    Chain,
}

/// A joint that is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// Which joint, from 0; not the tip, which has the goal.
    pub joint: usize,
    /// Where.
    pub point: Keyed<[f32; 3]>,
}

/// What the scale of a limb follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScaleBy {
    /// The length of the whole limb.
    #[default]
    Length,
    /// The stretch of the curve at each place.
    Local,
}

/// Which way the tip of a limb points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Tip {
    /// As the limb does.
    #[default]
    Follow,
    /// It keeps an orientation: turned from its rest by these angles about X, then Y, then Z, radians.
    Hold([f32; 3]),
}

/// What follows a limb.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Influence {
    /// Everything: `F` is 1 everywhere, the paper's large radius.
    #[default]
    All,
    /// What is near: `F` falls to 0 at this distance from the chain, > 0.
    Radius(f32),
    /// What hangs on the chain's joints, and on those below them, as far as it does by its weights. `F` is the sum of these; what a
    /// chain's joints carry only a skin knows, so that here it is the same as [`Influence::All`].
    SkinWeights,
}

/// A range and how a message says it.
const UNIT: (&str, RangeInclusive<f32>) = ("from 0 to 1", 0.0..=1.0);

impl Ik {
    /// Whether every value is in its range, for a chain of so many joints.
    pub(crate) fn check(&self, joints: usize) -> Result<(), IkError> {
        let bones = joints.saturating_sub(1);
        let count = |field, found: usize, most: usize, expected: String| {
            if found == 0 || (bones..=most).contains(&found) {
                return Ok(());
            }
            Err(IkError::Count { field, joints, found, expected })
        };
        count("stiffness", self.stiffness.len(), bones, format!("{bones}, one a bone, or none"))?;
        count(
            "limits",
            self.limits.len(),
            joints,
            format!("{bones}, one a joint but the tip, {joints} with one that does nothing, or none"),
        )?;
        let one = |field, value: f32, (expected, range): (&'static str, RangeInclusive<f32>)| {
            // NaN lies in no range.
            if range.contains(&value) && value.is_finite() {
                return Ok(());
            }
            Err(IkError::Value { field, index: None, expected, found: value })
        };
        let each = |field, values: &[f32], within: &(&'static str, RangeInclusive<f32>)| {
            let bad = values.iter().position(|value| one(field, *value, within.clone()).is_err());
            bad.map_or(Ok(()), |index| {
                Err(IkError::Value { field, index: Some(index), expected: within.0, found: values[index] })
            })
        };
        let all = |field, track: &Keyed<f32>, within: &(&'static str, RangeInclusive<f32>)| {
            track.values().try_for_each(|value| one(field, *value, within.clone()))
        };
        if let ChainCurve::Rounded(part) = self.curve {
            one("curve", part, ("greater than 0 and at most 0.5", f32::MIN_POSITIVE..=0.5))?;
        }
        all("elasticity", &self.elasticity, &UNIT)?;
        each("stiffness", &self.stiffness, &UNIT)?;
        each("limits", &self.limits, &("an angle greater than 0", f32::MIN_POSITIVE..=f32::MAX))?;
        one("max_stretch", self.max_stretch, ("1 or more", 1.0..=f32::MAX))?;
        one("min_stretch", self.min_stretch, UNIT)?;
        one("softness", self.softness, UNIT)?;
        one("volume", self.volume, UNIT)?;
        all("twist", &self.twist, &("an angle up to a million radians", -LARGEST_TWIST..=LARGEST_TWIST))?;
        if let Tip::Hold(angles) = self.tip {
            each("tip", &angles, &("an angle", f32::MIN..=f32::MAX))?;
        }
        if let Influence::Radius(radius) = self.influence {
            one("influence", radius, ("a length greater than 0", f32::MIN_POSITIVE..=f32::MAX))?;
        }
        if let Closest::Blended(width) = self.closest {
            one("closest", width, ("a length greater than 0", f32::MIN_POSITIVE..=f32::MAX))?;
        }
        self.check_points(bones)
    }

    fn check_points(&self, bones: usize) -> Result<(), IkError> {
        let finite = |field, index, track: &Keyed<[f32; 3]>| {
            let mut coordinates = track.values().flatten();
            coordinates.find(|c| !c.is_finite()).map_or(Ok(()), |&found| {
                Err(IkError::Value { field, index, expected: "a finite point", found })
            })
        };
        self.pole.iter().try_for_each(|pole| finite("pole", None, pole))?;
        for (index, pin) in self.pins.iter().enumerate() {
            let joint = pin.joint;
            if joint >= bones {
                return Err(IkError::Pin { pin: index, joint, last: bones.saturating_sub(1) });
            }
            if self.pins[..index].iter().any(|earlier| earlier.joint == joint) {
                return Err(IkError::Pinned { pin: index, joint });
            }
            finite("pins", Some(index), &pin.point)?;
        }
        Ok(())
    }
}
