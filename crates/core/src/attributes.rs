//! \[SF98\] §3.1, locators: attributes as functions of the parameter along a wire.
//!
//! Between two neighbouring locators (of any attributes) an attribute is one polynomial of the parameter: constant,
//! linear, or cubic with [`Interpolation::Smooth`]. Points are bound to *cells*, segments cut at the locators, so
//! that a run of points shares these polynomials as it shares the curve's.

use crate::{Domain, Interpolation, Locator, Wire};

/// An attribute a wire's locators may carry.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Attribute {
    Radius,
    Scale,
    Rotation,
    Amplitude,
    Twist,
    Angle,
    /// One coordinate of the direction; meaningless where [`is_directional`] is not.
    Direction(usize),
}

impl Attribute {
    fn of_wire(self, wire: &Wire) -> f32 {
        match self {
            Self::Radius => wire.radius,
            Self::Scale => wire.scale,
            Self::Rotation => wire.rotation,
            Self::Amplitude => wire.amplitude,
            Self::Twist => wire.twist,
            Self::Angle => wire.angle,
            Self::Direction(axis) => wire.direction.map_or(0.0, |d| d[axis]),
        }
    }

    fn of_locator(self, locator: &Locator) -> Option<f32> {
        match self {
            Self::Radius => locator.radius,
            Self::Scale => locator.scale,
            Self::Rotation => locator.rotation,
            Self::Amplitude => locator.amplitude,
            Self::Twist => locator.twist,
            Self::Angle => locator.angle,
            Self::Direction(axis) => locator.direction.map(|d| d[axis]),
        }
    }
}

/// A locator's place and value.
type Stop = (f64, f64);

/// The two locators that bracket `u` and carry the attribute; the same one twice beyond the ends of an open curve.
/// On a closed curve the places may lie outside `[0, 1]`. `None` where no locator carries it.
fn bracket(wire: &Wire, attribute: Attribute, u: f64) -> Option<(Stop, Stop)> {
    let stop = |l: &Locator| attribute.of_locator(l).map(|value| (f64::from(l.u), f64::from(value)));
    let stops = || wire.locators.iter().filter_map(stop);
    let (first, last) = (stops().next()?, stops().next_back()?);
    let before = stops().rev().find(|s| s.0 <= u);
    let after = stops().find(|s| s.0 > u);
    let closed = wire.reference.closed();
    let turn = if closed { 1.0 } else { 0.0 };
    Some(match (before, after) {
        (Some(a), Some(b)) => (a, b),
        (Some(a), None) if closed => (a, (first.0 + turn, first.1)),
        (None, Some(b)) if closed => ((last.0 - turn, last.1), b),
        (Some(a), None) => (a, a),
        (None, Some(b)) => (b, b),
        (None, None) => (first, first),
    })
}

/// The attribute as powers of `τ`, where `u = start + width·τ`, valid about `inside`, a parameter strictly within one cell.
///
/// With `start` the beginning of the cell no power is large where it counts, however close together locators stand.
pub(crate) fn polynomial(wire: &Wire, attribute: Attribute, start: f64, width: f64, inside: f64) -> [f64; 4] {
    let Some(((ua, a), (ub, b))) = bracket(wire, attribute, inside) else {
        return [f64::from(attribute.of_wire(wire)), 0.0, 0.0, 0.0];
    };
    let rise = b - a;
    if ub <= ua || rise == 0.0 {
        return [a, 0.0, 0.0, 0.0];
    }
    // x = x₀ + x₁ τ runs from 0 to 1 between the locators.
    let (x0, x1) = ((start - ua) / (ub - ua), width / (ub - ua));
    match wire.interpolation {
        Interpolation::Linear => [a + rise * x0, rise * x1, 0.0, 0.0],
        Interpolation::Smooth => {
            // 3x² − 2x³ in powers of τ.
            let [c0, c1, c2, c3] = [
                x0 * x0 * (3.0 - 2.0 * x0),
                6.0 * x0 * x1 * (1.0 - x0),
                3.0 * x1 * x1 * (1.0 - 2.0 * x0),
                -2.0 * x1 * x1 * x1,
            ];
            [a + rise * c0, rise * c1, rise * c2, rise * c3]
        }
    }
}

/// The largest radius anywhere along the wire: no point farther away is moved.
pub(crate) fn largest_radius(wire: &Wire) -> f32 {
    let carried = wire.locators.iter().filter_map(|l| l.radius);
    carried.reduce(f32::max).unwrap_or(wire.radius)
}

/// Whether the wire has a directional dropoff.
pub(crate) fn is_directional(wire: &Wire) -> bool {
    wire.direction.is_some() || wire.locators.iter().any(|l| l.direction.is_some())
}

/// Whether two wires, bound to the same points by the same feet and domain curves, have the same influence at every one.
pub(crate) fn same_influence(a: &Wire, b: &Wire) -> bool {
    let of_locator = |l: &Locator| (l.u, l.radius, l.direction, l.angle);
    let of_domain = |d: &Domain| (d.delta, d.exponent);
    a.radius == b.radius
        && a.density == b.density
        && a.interpolation == b.interpolation
        && (a.direction, a.angle) == (b.direction, b.angle)
        && a.locators.iter().map(of_locator).eq(b.locators.iter().map(of_locator))
        && a.domains.iter().map(of_domain).eq(b.domains.iter().map(of_domain))
}

/// Takes over what [`same_influence`] compares, from a wire with as many locators and domains; a profile is copied only where
/// it changed.
pub(crate) fn copy_influence(from: &Wire, to: &mut Wire) {
    (to.radius, to.interpolation) = (from.radius, from.interpolation);
    (to.direction, to.angle) = (from.direction, from.angle);
    if to.density != from.density {
        to.density.clone_from(&from.density);
    }
    for (from, to) in from.locators.iter().zip(&mut to.locators) {
        (to.radius, to.direction, to.angle) = (from.radius, from.direction, from.angle);
    }
    for (from, to) in from.domains.iter().zip(&mut to.domains) {
        (to.delta, to.exponent) = (from.delta, from.exponent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Curve, CurveKind};

    fn value(wire: &Wire, attribute: Attribute, u: f64) -> f64 {
        polynomial(wire, attribute, u, 0.0, u)[0]
    }

    fn wire(closed: bool, locators: Vec<Locator>) -> Wire {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        let reference = Curve::new(CurveKind::Polyline, closed, points).unwrap();
        Wire { locators, scale: 5.0, ..Wire::new(reference) }
    }

    fn scale_at(u: f32, scale: f32) -> Locator {
        Locator { u, scale: Some(scale), ..Locator::default() }
    }

    #[test]
    fn between_locators_linear_beyond_them_constant() {
        let w = wire(
            false,
            vec![scale_at(0.2, 1.0), Locator { u: 0.5, ..Locator::default() }, scale_at(0.6, 3.0)],
        );
        let at = |u| value(&w, Attribute::Scale, u);
        for (u, s) in [(0.0, 1.0), (0.2, 1.0), (0.4, 2.0), (0.5, 2.5), (0.6, 3.0), (1.0, 3.0)] {
            assert!((at(u) - s).abs() < 1e-6, "{u}: {} is not {s}", at(u));
        }
        assert_eq!(value(&w, Attribute::Radius, 0.3), 1.0, "an attribute nobody carries is the wire's");
    }

    #[test]
    fn locators_wrap_on_a_closed_curve() {
        let w = wire(true, vec![scale_at(0.25, 0.0), scale_at(0.75, 1.0)]);
        let at = |u| value(&w, Attribute::Scale, u);
        for (u, s) in [(0.0, 0.5), (0.1, 0.3), (0.9, 0.7), (1.0, 0.5)] {
            assert!((at(u) - s).abs() < 1e-6, "{u}: {} is not {s}", at(u));
        }
    }

    #[test]
    fn the_polynomial_of_a_cell_is_the_value() {
        let mut w = wire(false, vec![scale_at(0.1, 1.0), scale_at(0.9, -2.0)]);
        for interpolation in [Interpolation::Linear, Interpolation::Smooth] {
            w.interpolation = interpolation;
            let p = polynomial(&w, Attribute::Scale, 0.5, 0.5, 0.7);
            for i in 0..=8 {
                let t = f64::from(i) / 10.0;
                let x = (0.5 + 0.5 * t - 0.1) / 0.8;
                let x = if interpolation == Interpolation::Smooth { x * x * (3.0 - 2.0 * x) } else { x };
                let found = p[0] + t * (p[1] + t * (p[2] + t * p[3]));
                assert!((found - (1.0 - 3.0 * x)).abs() < 1e-6);
            }
        }
    }
}
