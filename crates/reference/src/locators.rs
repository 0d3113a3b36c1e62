//! \[SF98\] §3.1: attributes of a wire where its locators put them.

use glam::DVec3;
use wirework_core::{Interpolation, Locator, Wire};

/// What a wire does at one place along it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attributes {
    pub(crate) radius: f64,
    pub(crate) scale: f64,
    pub(crate) rotation: f64,
    pub(crate) amplitude: f64,
    pub(crate) twist: f64,
    /// Of any length; interpolated ones may vanish.
    pub(crate) direction: Option<DVec3>,
    pub(crate) angle: f64,
}

impl Attributes {
    pub(crate) fn at(wire: &Wire, u: f64) -> Self {
        let value = |own, of: fn(&Locator) -> Option<f32>| attribute(wire, u, own, of);
        Self {
            radius: value(wire.radius, |l| l.radius),
            scale: value(wire.scale, |l| l.scale),
            rotation: value(wire.rotation, |l| l.rotation),
            amplitude: value(wire.amplitude, |l| l.amplitude),
            twist: value(wire.twist, |l| l.twist),
            direction: direction(wire, u),
            angle: value(wire.angle, |l| l.angle),
        }
    }
}

/// None where neither the wire nor any locator has one.
fn direction(wire: &Wire, u: f64) -> Option<DVec3> {
    let own = wire.locators.iter().find_map(|l| l.direction).or(wire.direction)?;
    let [x, y, z] = wire.direction.unwrap_or(own);
    Some(DVec3::new(
        attribute(wire, u, x, |l| l.direction.map(|d| d[0])),
        attribute(wire, u, y, |l| l.direction.map(|d| d[1])),
        attribute(wire, u, z, |l| l.direction.map(|d| d[2])),
    ))
}

/// Between the two bracketing locators that carry it, constant beyond the ends (round a closed curve there are
/// none); the wire's own value where no locator carries it.
fn attribute(wire: &Wire, u: f64, own: f32, of: fn(&Locator) -> Option<f32>) -> f64 {
    let carried: Vec<(f64, f64)> =
        wire.locators.iter().filter_map(|l| Some((f64::from(l.u), f64::from(of(l)?)))).collect();
    let (Some(&first), Some(&last)) = (carried.first(), carried.last()) else { return f64::from(own) };
    let next = carried.iter().find(|l| l.0 > u);
    let previous = carried.iter().rev().find(|l| l.0 <= u);
    let closed = wire.reference.closed();
    let (a, b) = match (previous, next) {
        (Some(&a), Some(&b)) => (a, b),
        (Some(&a), None) if closed => (a, (first.0 + 1.0, first.1)),
        (None, Some(&b)) if closed => ((last.0 - 1.0, last.1), b),
        (Some(&one), None) | (None, Some(&one)) => return one.1,
        (None, None) => return f64::from(own),
    };
    if b.0 <= a.0 {
        return a.1;
    }
    let x = (u - a.0) / (b.0 - a.0);
    let x = match wire.interpolation {
        Interpolation::Linear => x,
        Interpolation::Smooth => x * x * (3.0 - 2.0 * x),
    };
    a.1 * (1.0 - x) + b.1 * x
}
