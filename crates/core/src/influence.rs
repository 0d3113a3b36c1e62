//! The influence `F` of a wire on its bound points: \[SF98\] §2 by distance, §3.1 by direction, §3.2 and §4 by domain curves.
//!
//! `F = f(‖v‖ / r) · f(φ / a) · mask` with `v = P − R(p)`. Domain curves put their own radius in the place of `r`; several give
//! `Σ Fⱼ·Fⱼ^mⱼ / Σ Fⱼ^mⱼ`. All of it is known at binding; a change of radius, angle or density measures it anew from what
//! was kept then.
//!
//! # Deviations
//!
//! The paper compares `cosangle`, a dot product of vectors as long as they are, with `δ ∈ (0, 1)`, and moves with it from `r` to the
//! domain's radius. Both need a cosine, so here the vectors are normalised.

use glam::DVec3;

use crate::attributes::{Attribute, is_directional};
use crate::cells::{Cell, Cells};
use crate::domain::Side;
use crate::runs::TileRuns;
use crate::spans::Spans;
use crate::tiles::Tile;
use crate::{Bounded, Density, Wire};

/// Attributes that domain curves may bound, in the order of [`TileRuns::fades`].
pub(crate) const FADES: [Bounded; 4] =
    [Bounded::Scale, Bounded::Rotation, Bounded::Amplitude, Bounded::Twist];

/// A projection shorter than this part of the vector, or of the coordinates, is rounding: the vector runs along the tangent.
const ALONG: f64 = 1e-12;

/// What the influence depends on.
#[derive(Clone, Copy)]
pub(crate) struct Measure<'a> {
    pub(crate) wire: &'a Wire,
    pub(crate) spans: &'a Spans,
    pub(crate) cells: &'a Cells,
}

impl Measure<'_> {
    /// Computes `F` of the bound points of a tile, and what domain curves leave of each attribute.
    pub(crate) fn tile(self, tile: &Tile, runs: &mut TileRuns) {
        let Self { wire, spans, cells } = self;
        let n = spans.cubics.len();
        let directional = is_directional(wire);
        runs.influence.resize(runs.index.len(), 0.0);
        for run in &runs.list {
            let cell = cells.list[run.cell as usize];
            let powers = |attribute| cell.attribute(wire, attribute, n);
            let radius = powers(Attribute::Radius);
            let t0 = if let Cell::Stretch { t0, .. } = cell { t0 } else { 0.0 };
            let direction = directional.then(|| Direction {
                axis: [0, 1, 2].map(|axis| powers(Attribute::Direction(axis))),
                angle: powers(Attribute::Angle),
            });
            for i in run.start as usize..run.end as usize {
                let t = f64::from(runs.t[i]);
                let (v, r) = (runs.distance[i], at(&radius, t - t0));
                let radial = bounded(wire, Bounded::Influence, v, r, &runs.sides, i);
                let mut f = radial;
                if let Some(direction) = direction.as_ref().filter(|_| f > 0.0) {
                    let (span, place) = cell.place(t, n);
                    let point = tile.position(runs.index[i] as usize);
                    let from_r = point - spans.cubics[span].at(place);
                    let (tangent, extent) = (spans.tangent_in(span, place), point.abs().max_element());
                    f *= wire.density.at(direction.turn(t - t0, from_r, tangent, extent));
                }
                if let Some(mask) = runs.mask.get(i) {
                    f *= f64::from(*mask);
                }
                runs.influence[i] = f as f32;
                for (bounds, fade) in FADES.into_iter().zip(&mut runs.fades) {
                    if let Some(fade) = fade.get_mut(i) {
                        let own = bounded(wire, bounds, v, r, &runs.sides, i);
                        // The attribute then acts by the lesser of the two.
                        *fade = if own < radial { (own / radial) as f32 } else { 1.0 };
                    }
                }
            }
        }
    }
}

/// A directional dropoff in one cell: powers of the distance from the cell's start.
struct Direction {
    axis: [[f64; 4]; 3],
    angle: [f64; 4],
}

impl Direction {
    /// `φ / a` of a point that lies at `v` from its foot, with coordinates up to `extent`. `φ` is 0 on the curve, and where the axis
    /// or the point lies along it.
    fn turn(&self, tau: f64, v: DVec3, tangent: DVec3, extent: f64) -> f64 {
        let across = |v: DVec3, size: f64| {
            let flat = v - tangent * v.dot(tangent);
            if flat.length_squared() <= ALONG * ALONG * size * size { DVec3::ZERO } else { flat }
        };
        let axis = DVec3::from_array([0, 1, 2].map(|i| at(&self.axis[i], tau)));
        let (axis, v) = (across(axis, axis.length()), across(v, v.length().max(extent)));
        if axis == DVec3::ZERO || v == DVec3::ZERO {
            return 0.0;
        }
        axis.cross(v).length().atan2(axis.dot(v)) / at(&self.angle, tau)
    }
}

fn at(powers: &[f64; 4], tau: f64) -> f64 {
    powers[0] + tau * (powers[1] + tau * (powers[2] + tau * powers[3]))
}

/// `F` by the distance `v`, where `r` is the wire's radius, with the domain curves that bound `what`.
#[inline]
fn bounded(wire: &Wire, what: Bounded, v: f64, r: f64, sides: &[Vec<Side>], i: usize) -> f64 {
    let one = |radius: f64| within(&wire.density, v, radius);
    let mut bounding = wire.domains.iter().zip(sides).filter(|(domain, _)| domain.bounds == what);
    let Some((first, side)) = bounding.next() else { return one(r) };
    let f = one(side[i].radius(f64::from(first.delta), r));
    let Some((second, side)) = bounding.next() else { return f };
    let mut sum = Sum::default();
    sum.add(f, f64::from(first.exponent));
    sum.add(one(side[i].radius(f64::from(second.delta), r)), f64::from(second.exponent));
    for (domain, side) in bounding {
        sum.add(one(side[i].radius(f64::from(domain.delta), r)), f64::from(domain.exponent));
    }
    sum.mean()
}

/// `f(v / radius)`; 1 on the curve, whatever the radius.
fn within(density: &Density, v: f64, radius: f64) -> f64 {
    if v == 0.0 { 1.0 } else { density.at(v / radius) }
}

/// `Σ F·F^m / Σ F^m` with powers relative to the largest, so that none overflows.
#[derive(Default)]
struct Sum {
    /// The largest `m·ln F` so far; nothing so far without a weight.
    top: f64,
    weighted: f64,
    weight: f64,
}

impl Sum {
    fn add(&mut self, f: f64, exponent: f64) {
        if f <= 0.0 {
            return;
        }
        let log = exponent * f.ln();
        if self.weight > 0.0 && log > self.top {
            let less = (self.top - log).exp();
            (self.weighted, self.weight) = (self.weighted * less, self.weight * less);
        }
        self.top = if self.weight > 0.0 { self.top.max(log) } else { log };
        let weight = (log - self.top).exp();
        (self.weighted, self.weight) = (self.weighted + weight * f, self.weight + weight);
    }

    fn mean(&self) -> f64 {
        if self.weight > 0.0 { self.weighted / self.weight } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(list: &[(f64, f64)]) -> f64 {
        let mut sum = Sum::default();
        for (f, m) in list {
            sum.add(*f, *m);
        }
        sum.mean()
    }

    #[test]
    fn the_exponents_lean_to_the_largest_or_the_smallest() {
        assert!((mean(&[(0.5, 1.0), (0.25, 1.0)]) - (0.25 + 0.0625) / 0.75).abs() < 1e-15);
        assert!((mean(&[(0.5, -1.0), (0.25, -1.0)]) - 2.0 / 6.0).abs() < 1e-15);
        assert!((mean(&[(0.5, 400.0), (0.25, 400.0)]) - 0.5).abs() < 1e-12);
        assert!((mean(&[(0.5, -4000.0), (0.25, -4000.0), (0.0, -1.0)]) - 0.25).abs() < 1e-12);
        assert_eq!(mean(&[(0.0, 1.0), (0.0, -2.0)]), 0.0);
    }
}
