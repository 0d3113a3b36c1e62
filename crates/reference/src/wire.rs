//! \[SF98\] §2: what one wire does to one point.
//!
//! With `v = P − R(p)`, `F = f(‖v‖ / r)` (or as the domain curves have it) times the directional dropoff times the mask, and
//! every attribute taken at `p = p_R`:
//! 1. scale: `v ← v·(1 + (s − 1)·F)`. As printed, `P_s = P + …` moves every point even at `s = 1`; read
//!    `R(p) + …`.
//! 2. twist, then bend: `v` turns about `R′(p)` by `twist·F`, then about `R′ × W′` by `θ·F·rotation`. As printed,
//!    `W′ × R′` turns the wrong way.
//! 3. translate: `P_def = R(p) + v + (W(p′) − R(p))·F`.
//! 4. `ΔP = amplitude·(P_def − P)`.
//!
//! Domain curves that bound an attribute multiply its effect. With several feet `ΔP` and `F` are means over them.

use crate::bounds::{Domains, angle_about};
use crate::curve::{at, direction};
use crate::feet::shares;
use crate::foot::{Foot, Samples};
use crate::length::Lengths;
use crate::locators::Attributes;
use crate::rotation::{least, turn};
use crate::transport::{Transport, partner};
use glam::DVec3;
use wirework_core::{Bend, Bounded, Correspondence, Curve, Density, Wire};

/// `F` of one wire at `p`.
///
/// # Panics
/// When the pose is not one of the reference (another number of points, or one not finite).
pub fn influence(wire: &Wire, p: [f64; 3]) -> f64 {
    Prepared::new(wire).act(DVec3::from_array(p), 1.0).0
}

/// `ΔP` of one wire at `p`.
///
/// # Panics
/// As [`influence`].
pub fn displacement(wire: &Wire, p: [f64; 3]) -> [f64; 3] {
    Prepared::new(wire).act(DVec3::from_array(p), 1.0).1.to_array()
}

/// A wire with what is worth computing once for many points.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub(crate) wire: Wire,
    pub(crate) feet: Samples,
    domains: Domains,
    pose: Curve,
    lengths: Option<(Lengths, Lengths)>,
    transport: Option<Transport>,
}

impl Prepared {
    pub(crate) fn new(wire: &Wire) -> Self {
        let reference = &wire.reference;
        let pose = reference.posed(wire.pose.clone()).expect("a pose of the reference");
        // An unmoved wire has p′ = p to the bit.
        let by_length = wire.correspondence == Correspondence::ArcLength && pose != *reference;
        let lengths = by_length.then(|| (Lengths::new(reference), Lengths::new(&pose)));
        let transport =
            (wire.bend == Bend::Transport).then(|| Transport::new(reference, &pose, lengths.clone()));
        let (feet, domains) = (Samples::new(reference), Domains::new(wire));
        Self { feet, domains, wire: wire.clone(), pose, lengths, transport }
    }

    /// `F` and `ΔP`, all feet considered.
    pub(crate) fn act(&self, p: DVec3, mask: f64) -> (f64, DVec3) {
        let feet = shares(&self.feet, self.wire.closest, p);
        let by_foot = feet.iter().map(|(foot, share)| {
            let f = self.influence(p, foot) * mask;
            (f * share, self.displacement(p, foot, f) * *share)
        });
        by_foot.fold((0.0, DVec3::ZERO), |sum, one| (sum.0 + one.0, sum.1 + one.1))
    }

    /// The influence by distance and domain curves.
    fn radial(&self, p: DVec3, foot: &Foot) -> f64 {
        let radius = Attributes::at(&self.wire, foot.u).radius;
        let bounded = self.domains.influence(Bounded::Influence, p, DVec3::from_array(foot.point), radius);
        bounded.unwrap_or_else(|| density(&self.wire.density, foot.distance / radius))
    }

    /// `F` for a point with this foot, without the mask.
    fn influence(&self, p: DVec3, foot: &Foot) -> f64 {
        if !p.is_finite() {
            return 0.0;
        }
        let attributes = Attributes::at(&self.wire, foot.u);
        let on = DVec3::from_array(foot.point);
        let radial = self.radial(p, foot);
        let Some(axis) = attributes.direction else { return radial };
        let tangent = direction(&self.wire.reference, foot.place);
        let angle = angle_about(tangent, axis, p - on, self.feet.extent(p));
        radial * density(&self.wire.density, angle / attributes.angle)
    }

    /// The attributes at a foot, as far as domain curves let them act on `p`.
    fn attributes(&self, p: DVec3, foot: &Foot) -> Attributes {
        let own = Attributes::at(&self.wire, foot.u);
        let on = DVec3::from_array(foot.point);
        // An attribute acts by the lesser of its own domains' influence and the wire's.
        let radial = self.radial(p, foot);
        let part = |bounds| match self.domains.influence(bounds, p, on, own.radius) {
            Some(bounded) if bounded < radial => bounded / radial,
            _ => 1.0,
        };
        Attributes {
            scale: 1.0 + (own.scale - 1.0) * part(Bounded::Scale),
            rotation: own.rotation * part(Bounded::Rotation),
            amplitude: own.amplitude * part(Bounded::Amplitude),
            twist: own.twist * part(Bounded::Twist),
            ..own
        }
    }

    /// `ΔP` for a point with this foot and `F`.
    fn displacement(&self, p: DVec3, foot: &Foot, f: f64) -> DVec3 {
        if f == 0.0 {
            return DVec3::ZERO;
        }
        let reference = &self.wire.reference;
        let attributes = self.attributes(p, foot);
        let place = foot.place;
        let partner = partner(self.lengths.as_ref(), place);
        let rest = p - at(reference, place);
        let r_tangent = direction(reference, place);

        let scaled = rest * (1.0 + (attributes.scale - 1.0) * f);
        let twisted = turn(scaled, r_tangent * (attributes.twist * f));
        let bend = match &self.transport {
            None => least(r_tangent, direction(&self.pose, partner)),
            Some(transport) => transport.vector(place, partner),
        };
        let bent = turn(twisted, bend * (f * attributes.rotation));

        let translation = (at(&self.pose, partner) - at(reference, place)) * f;
        attributes.amplitude * ((bent - rest) + translation)
    }
}

/// `f(x)`, §2.
pub(crate) fn density(density: &Density, x: f64) -> f64 {
    match density {
        _ if x >= 1.0 => 0.0,
        Density::Quartic => (1.0 - x * x).powi(2),
        Density::Sextic => (1.0 - x * x).powi(3),
        // 1 − 3x² + 2x³, in factors, so that it does not round below 0.
        Density::Smoothstep => (1.0 - x).powi(2) * (1.0 + 2.0 * x),
        Density::Linear => 1.0 - x,
        Density::Fold(q) => (1.0 - x.powf(f64::from(*q))).powi(2),
        // Plain data with a private inside: its own tests check it.
        Density::Profile(_) => density.at(x).max(0.0),
    }
}
