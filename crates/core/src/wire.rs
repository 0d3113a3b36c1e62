//! \[SF98\] §2: the wire ⟨W, R, s, r, f⟩ as data, §3.1: its locators, §4: how several are blended.
//!
//! Everything here is the state at one moment; what moves in time is kept as [`Keyed`](crate::Keyed) values by
//! whoever animates it.

use thiserror::Error;

use crate::{Curve, CurveError, Density, curve};

/// One wire at one moment. The defaults of [`Wire::new`] deform nothing: `W = R`, `s = 1`, no twist.
#[derive(Clone, Debug, PartialEq)]
pub struct Wire {
    /// `R`: where the wire lies on the undeformed object. Points are bound to it; moving it rebinds this wire.
    pub reference: Curve,
    /// The control points of `W`, as many as `R` has; `W` is a curve of the same kind.
    pub pose: Vec<[f32; 3]>,
    /// `r > 0`: how far from `R` the wire reaches. Default 1.
    pub radius: f32,
    /// `s`: radial scale about `R`, 1 leaves it. Default 1.
    pub scale: f32,
    /// How much of the bend from `R′` to `W′` the object follows: 0 shears, 1 stays tangent. Default 1.
    pub rotation: f32,
    /// Factor on the whole displacement. Default 1.
    pub amplitude: f32,
    /// Turn about `R′` in radians, unwrapped: 4π is two turns. Default 0.
    pub twist: f32,
    /// `f`. Default [`Density::Quartic`], the paper's.
    pub density: Density,
    /// Attributes along the wire, by rising `u`. Default none.
    pub locators: Vec<Locator>,
    /// How attributes run between locators. Default linear.
    pub interpolation: Interpolation,
    /// Which point of `W` belongs to `R(p)`. Default the same parameter.
    pub correspondence: Correspondence,
    /// How the bend is measured. Default the angle of the tangents.
    pub bend: Bend,
    /// Of the wires of one group only the one whose `R` is nearest acts at a point; of equally near ones the
    /// first. So a wire cut into several deforms as one (§4). Default none.
    pub group: Option<u32>,
    /// This wire's own `m` in the blend, §4. Default the blend's.
    pub exponent: Option<f32>,
}

impl Wire {
    /// The wire that lies on `reference` and moves nothing yet.
    pub fn new(reference: Curve) -> Self {
        Self {
            pose: reference.points().to_vec(),
            reference,
            radius: 1.0,
            scale: 1.0,
            rotation: 1.0,
            amplitude: 1.0,
            twist: 0.0,
            density: Density::Quartic,
            locators: Vec::new(),
            interpolation: Interpolation::Linear,
            correspondence: Correspondence::Parameter,
            bend: Bend::Tangent,
            group: None,
            exponent: None,
        }
    }
}

/// Radians. Beyond, a float32 angle says nothing of the direction within a turn.
pub const LARGEST_TWIST: f32 = 1e6;

/// Why a wire cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WireError {
    /// The pose does not fit the reference curve, or is not finite.
    #[error(transparent)]
    Pose(#[from] CurveError),
    /// A radius is not positive and finite.
    #[error("the radius {0} is not positive")]
    Radius(f32),
    /// Another attribute, of the wire or of a locator, is NaN or infinite.
    #[error("the {0} is not finite")]
    NotFinite(&'static str),
    /// A twist is larger than [`LARGEST_TWIST`].
    #[error("the twist of {0} radians is larger than {LARGEST_TWIST}")]
    Twist(f32),
    /// The exponent of [`Density::Fold`] is below 1 or not finite.
    #[error("the fold's exponent {0} is not 1 or more")]
    Fold(f32),
    /// A locator lies outside the curve or before the one before it.
    #[error("locator {index} lies outside the curve or out of order")]
    Locator {
        /// Which locator, from 0.
        index: usize,
    },
}

impl Wire {
    /// Whether every value is in its range.
    pub fn check(&self) -> Result<(), WireError> {
        let (expected, found) = (self.reference.points().len(), self.pose.len());
        if expected != found {
            return Err(CurveError::PoseCount { expected, found }.into());
        }
        curve::check_finite(&self.pose)?;
        let mut u = 0.0;
        for (index, locator) in self.locators.iter().enumerate() {
            if !(u..=1.0).contains(&locator.u) {
                return Err(WireError::Locator { index });
            }
            u = locator.u;
        }
        let carried = |get: fn(&Locator) -> Option<f32>| self.locators.iter().filter_map(get);
        let mut radii = carried(|l| l.radius).chain([self.radius]);
        if let Some(radius) = radii.find(|r| !(*r > 0.0 && r.is_finite())) {
            return Err(WireError::Radius(radius));
        }
        let finite = |name, own: f32, get| {
            let all_are = carried(get).chain([own]).all(f32::is_finite);
            if all_are { Ok(()) } else { Err(WireError::NotFinite(name)) }
        };
        finite("scale", self.scale, |l| l.scale)?;
        finite("rotation", self.rotation, |l| l.rotation)?;
        finite("amplitude", self.amplitude, |l| l.amplitude)?;
        finite("twist", self.twist, |l| l.twist)?;
        let mut twists = carried(|l| l.twist).chain([self.twist]);
        if let Some(twist) = twists.find(|t| t.abs() > LARGEST_TWIST) {
            return Err(WireError::Twist(twist));
        }
        if let Density::Fold(q) = self.density
            && !(q >= 1.0 && q.is_finite())
        {
            return Err(WireError::Fold(q));
        }
        finite("exponent", self.exponent.unwrap_or(1.0), |_| None)
    }
}

/// \[SF98\] §3.1: values of a wire's attributes at one place along it, any subset of them.
///
/// At a parameter `p` an attribute is interpolated between the two bracketing locators that carry it, is
/// constant beyond the first and the last, and overrides the wire's own value. On a closed curve locators wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Locator {
    /// Where, `0 ..= 1` along `R`.
    pub u: f32,
    /// Radius of influence there, > 0.
    pub radius: Option<f32>,
    /// Radial scale there.
    pub scale: Option<f32>,
    /// Rotation factor there.
    pub rotation: Option<f32>,
    /// Amplitude there.
    pub amplitude: Option<f32>,
    /// Twist there, radians.
    pub twist: Option<f32>,
}

/// How attributes run between two locators.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    #[default]
    Linear,
    /// `3x² − 2x³`: flat at every locator.
    Smooth,
}

/// Which point `p′` of `W` belongs to the point `p` of `R`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correspondence {
    /// The same parameter.
    #[default]
    Parameter,
    /// The same fraction of arc length.
    ArcLength,
}

/// How the bend from `R` to `W` is measured, §2 step 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bend {
    /// The least rotation from `R′` to `W′`. It steps where `W′` passes `−R′`.
    #[default]
    Tangent,
    /// The rotation between frames transported along `R` and `W` from `u = 0`, where it is the least rotation;
    /// its angle is continued along the curve, so that it never steps.
    Transport,
}

/// \[SF98\] §4: how the displacements `ΔPᵢ` of several wires become one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// `m`: 0 the mean, large the largest, negative towards the smallest. Default 1.
    pub exponent: f32,
    /// Share of the plain sum `Σ ΔPᵢ`, 0 ..= 1. Default 0.
    pub crossing: f32,
    /// Share of the local blend, in which a wire that has not moved anchors its surroundings, 0 ..= 1. Default 0.
    pub localize: f32,
    /// `k`: exponent of `F` in the local blend. Default 1.
    pub locality: f32,
}

impl Blend {
    /// Whether every value is a number; the name of one that is not.
    pub fn check(&self) -> Result<(), &'static str> {
        let values = [
            ("exponent", self.exponent),
            ("crossing", self.crossing),
            ("localize", self.localize),
            ("locality", self.locality),
        ];
        values.into_iter().find(|(_, v)| !v.is_finite()).map_or(Ok(()), |(name, _)| Err(name))
    }
}

impl Default for Blend {
    fn default() -> Self {
        Self { exponent: 1.0, crossing: 0.0, localize: 0.0, locality: 1.0 }
    }
}
