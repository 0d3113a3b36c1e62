//! \[SF98\] §3.1, directional dropoff, §3.2 and §4, domain curves: what bounds the influence besides the radius.

use crate::foot::Samples;
use crate::wire::density;
use glam::DVec3;
use wirework_core::{Bounded, Density, Wire};

/// The domain curves of a wire, ready for many points.
#[derive(Clone, Debug)]
pub(crate) struct Domains {
    density: Density,
    domains: Vec<Prepared>,
}

#[derive(Clone, Debug)]
struct Prepared {
    feet: Samples,
    delta: f64,
    exponent: f64,
    bounds: Bounded,
}

impl Domains {
    pub(crate) fn new(wire: &Wire) -> Self {
        let domains = wire.domains.iter().map(|domain| Prepared {
            feet: Samples::new(&domain.curve),
            delta: domain.delta.into(),
            exponent: domain.exponent.into(),
            bounds: domain.bounds,
        });
        Self { domains: domains.collect(), density: wire.density.clone() }
    }

    /// The radial influence, `f(‖P − R(p)‖ / radius)`, by the domains of this kind: `Σ Fⱼ·Fⱼ^mⱼ / Σ Fⱼ^mⱼ` over
    /// those with `Fⱼ > 0`. None where there are no domains of the kind.
    pub(crate) fn influence(&self, bounds: Bounded, p: DVec3, on: DVec3, own: f64) -> Option<f64> {
        let domains: Vec<&Prepared> = self.domains.iter().filter(|d| d.bounds == bounds).collect();
        if domains.is_empty() {
            return None;
        }
        let of_domain = |domain: &&Prepared| {
            let f = density(&self.density, p.distance(on) / domain.radius(p, on, own));
            (f > 0.0).then(|| (domain.exponent * f.ln(), f))
        };
        // Logarithms of the weights, so that no power overflows.
        let terms: Vec<(f64, f64)> = domains.iter().filter_map(of_domain).collect();
        let top = terms.iter().map(|t| t.0).fold(f64::NEG_INFINITY, f64::max);
        let weight = |log: f64| (log - top).exp();
        let weights: f64 = terms.iter().map(|t| weight(t.0)).sum();
        let sum: f64 = terms.iter().map(|t| weight(t.0) * t.1).sum();
        Some(if terms.is_empty() { 0.0 } else { sum / weights })
    }
}

/// A cosine this small is 0, on whose two sides the radius differs where `δ` is 0: points placed square to a domain curve are so
/// to the rounding of float64 only.
const SQUARE: f64 = 1e-9;

impl Prepared {
    /// How far the wire reaches towards `p`, whose foot is `on`.
    fn radius(&self, p: DVec3, on: DVec3, own: f64) -> f64 {
        let to_domain = DVec3::from_array(self.feet.closest(p).point) - on;
        // A zero vector has no angle: 0.
        let cosangle = to_domain.normalize_or_zero().dot((p - on).normalize_or_zero());
        if cosangle <= SQUARE {
            own
        } else if cosangle >= self.delta {
            to_domain.length()
        } else {
            let x = cosangle / self.delta;
            own + (to_domain.length() - own) * (x * x * (3.0 - 2.0 * x))
        }
    }
}

/// A vector seen along the wire is zero where it is shorter than this part of itself, or of the largest coordinate: the
/// rounding of float64.
const ALONG: f64 = 1e-12;

/// `φ`: the angle between `direction` and `v`, both projected perpendicular to the unit `tangent` (which may be zero: then
/// neither is); 0 where one of them vanishes. `extent` is the largest coordinate `v` comes from.
pub(crate) fn angle_about(tangent: DVec3, direction: DVec3, v: DVec3, extent: f64) -> f64 {
    let across = |v: DVec3| v - tangent * tangent.dot(v);
    let (axis, arm) = (across(direction), across(v));
    if axis.length() <= ALONG * direction.length() || arm.length() <= ALONG * v.length().max(extent) {
        return 0.0;
    }
    let (axis, arm) = (axis.normalize(), arm.normalize());
    axis.cross(arm).length().atan2(axis.dot(arm))
}
