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
    /// \[SF98\] §3.1, directional dropoff: `F` is multiplied by `f(φ / angle)`, `φ` the angle between this axis and `P − R(p)`,
    /// both seen along `R′(p)`; 0 where one of them has no such direction, on the curve for instance. Of any length but 0.
    /// Default none: all directions alike.
    pub direction: Option<[f32; 3]>,
    /// Where the directional dropoff ends, radians, > 0. Default π: nothing moves on the far side of the wire.
    pub angle: f32,
    /// \[SF98\] §3.2: curves that bound what the wire does. Default none.
    pub domains: Vec<Domain>,
    /// Which feet of a point count. Default the closest alone.
    pub closest: Closest,
    /// Of the wires of one group only the one whose `R` is nearest acts at a point; of equally near ones the
    /// first; one that a mask keeps off the point is no rival there. So a wire cut into several deforms as one (§4). Default none.
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
            direction: None,
            angle: std::f32::consts::PI,
            domains: Vec::new(),
            closest: Closest::Smallest,
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
    /// A direction is zero, NaN or infinite.
    #[error("the direction {0:?} is zero or not finite")]
    Direction([f32; 3]),
    /// An angle of a directional dropoff is not positive and finite.
    #[error("the angle {0} is not positive")]
    Angle(f32),
    /// The `delta` of a domain curve lies outside `[0, 1)`.
    #[error("the delta {delta} of domain {index} lies outside [0, 1)")]
    Delta {
        /// Which domain, from 0.
        index: usize,
        /// Its delta.
        delta: f32,
    },
    /// The width of [`Closest::Blended`] is not positive and finite.
    #[error("the width {0} of blended feet is not positive")]
    Width(f32),
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
        finite("exponent", self.exponent.unwrap_or(1.0), |_| None)?;
        self.check_bounds()
    }

    /// Whether what bounds the influence is in range.
    fn check_bounds(&self) -> Result<(), WireError> {
        let directions = self.locators.iter().filter_map(|l| l.direction).chain(self.direction);
        for direction in directions {
            if direction == [0.0; 3] || direction.iter().any(|c| !c.is_finite()) {
                return Err(WireError::Direction(direction));
            }
        }
        let positive = |x: f32| x > 0.0 && x.is_finite();
        let mut angles = self.locators.iter().filter_map(|l| l.angle).chain([self.angle]);
        if let Some(angle) = angles.find(|a| !positive(*a)) {
            return Err(WireError::Angle(angle));
        }
        for (index, &Domain { delta, exponent, .. }) in self.domains.iter().enumerate() {
            if !(0.0..1.0).contains(&delta) {
                return Err(WireError::Delta { index, delta });
            }
            if !exponent.is_finite() {
                return Err(WireError::NotFinite("exponent of a domain"));
            }
        }
        match self.closest {
            Closest::Blended(width) if !positive(width) => Err(WireError::Width(width)),
            _ => Ok(()),
        }
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
    /// Axis of the directional dropoff there, of any length but 0; interpolated coordinate by coordinate.
    pub direction: Option<[f32; 3]>,
    /// Angle of the directional dropoff there, radians, > 0.
    pub angle: Option<f32>,
}

/// \[SF98\] §3.2: a curve `D` that bounds what a wire does on the side where it lies.
///
/// With `cosangle` the cosine of the angle at `R(p)` between `D(p_D)` and `P` the radius is the wire's own where
/// `cosangle ≤ 0`, `‖R(p) − D(p_D)‖` where `cosangle ≥ delta`, and between the two runs as `3x² − 2x³` from the one to the other.
/// A point on `R` has `F = 1`. §4: several domains give `F = Σ Fⱼ·Fⱼ^mⱼ / Σ Fⱼ^mⱼ` over those with `Fⱼ > 0`; with an `m` of 0 or
/// less `F` therefore steps where one of them ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Domain {
    /// `D`.
    pub curve: Curve,
    /// `δ ∈ [0, 1)`: above 0 the influence is continuous from one side to the other. Default 0.
    pub delta: f32,
    /// `m`: positive makes a union of several domains, negative tends towards the smallest. Default 1.
    pub exponent: f32,
    /// What it bounds. Default the influence.
    pub bounds: Bounded,
}

impl Domain {
    /// The domain curve that bounds the influence, without a transition.
    pub fn new(curve: Curve) -> Self {
        Self { curve, delta: 0.0, exponent: 1.0, bounds: Bounded::Influence }
    }
}

/// What a domain curve bounds: the influence `F` itself, or how one attribute acts.
///
/// An attribute with domain curves of its own acts by the `F` that these would give where that is less than the wire's (both before
/// direction and mask): the scale tends to 1 and the others to 0 as a point nears `D`, and on the far side nothing changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounded {
    /// `F`.
    #[default]
    Influence,
    /// `s − 1`.
    Scale,
    /// The rotation factor.
    Rotation,
    /// The amplitude.
    Amplitude,
    /// The twist.
    Twist,
}

/// Which feet of a point count, §2 and §6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Closest {
    /// The closest alone; of equally near ones that with the smallest `u`. The deformation steps where the foot jumps, across the
    /// medial axis of a bent wire.
    #[default]
    Smallest,
    /// All local minima of the distance that are nearer than the least one plus this width, > 0. `ΔP` and `F` are means of the
    /// feet's own, by shares that fall to 0 as a foot's distance reaches that end and as it stops being a minimum; so the
    /// deformation steps nowhere but where a whole stretch of curve is equally near, as at the centre of an arc.
    ///
    /// Of two feet at distances `d₁ ≤ d₂`, parted by a stretch of curve that is farther by `width`, the farther has the share
    /// `t²(3 − 2t)`, `t = (1 − (d₂ − d₁)/width)/2`. In general the shares come of flooding the valleys of the distance along the
    /// curve: water rises to the least distance plus `width`; at level `h` a valley with floor `a` weighs `B(h − a)`, `B(s) = q /
    /// (1 − q)`, `q = t²(3 − 2t)`, `t = s / (2 width)`; where two pools meet, at `s`, their feet share the new pool as the pools
    /// weighed, and what it weighs more than its deepest valley alone fades as `1 − 3x² + 2x³`, `x = (h − s)/width`. At most 64
    /// feet of a point count; of feet with no ridge between them, as where control points coincide, that with the smallest `u`.
    Blended(f32),
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
    /// Whether the local blend weighs wires by `G / (1 − G)` in place of `F^k`, `G = F` times the wire's own amplitude, clamped to
    /// 0 ..= 1: a point on a reference curve is then moved by that wire alone, whatever others reach it, and the blend is smooth all
    /// the same; a wire of amplitude 0 has no say. \[SF98\] §5.2 needs it where seams meet. Default no.
    pub pinned: bool,
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
        Self { exponent: 1.0, crossing: 0.0, localize: 0.0, locality: 1.0, pinned: false }
    }
}
