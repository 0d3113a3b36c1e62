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

use std::ops::Range;

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
    /// Computes `F` of the bound points of a tile, and what domain curves leave of each attribute: a pass for each factor there
    /// is.
    pub(crate) fn tile(self, tile: &Tile, runs: &mut TileRuns) {
        let mut influence = std::mem::take(&mut runs.influence);
        influence.resize(runs.index.len(), 0.0);
        for run in &runs.list {
            let range = run.start as usize..run.end as usize;
            let cell = self.cells.list[run.cell as usize];
            let radius = Along::new(self, cell, Attribute::Radius);
            self.radial(range.clone(), radius, runs, &mut influence);
            if is_directional(self.wire) {
                self.direct(range, cell, tile, runs, &mut influence);
            }
        }
        for (f, mask) in influence.iter_mut().zip(&runs.mask) {
            *f = (f64::from(*f) * f64::from(*mask)) as f32;
        }
        runs.influence = influence;
        if runs.fades.iter().any(|fade| !fade.is_empty()) {
            self.fade(runs);
        }
    }

    fn radial(self, range: Range<usize>, radius: Along, runs: &TileRuns, influence: &mut [f32]) {
        let wire = self.wire;
        if !wire.domains.iter().any(|domain| domain.bounds == Bounded::Influence) {
            for i in range {
                influence[i] = wire.density.at(runs.distance[i] / radius.at(runs.t[i])) as f32;
            }
            return;
        }
        for i in range {
            let (v, r) = (runs.distance[i], radius.at(runs.t[i]));
            influence[i] = bounded(wire, Bounded::Influence, v, r, &runs.sides, i) as f32;
        }
    }

    /// Multiplies by the directional dropoff.
    fn direct(self, range: Range<usize>, cell: Cell, tile: &Tile, runs: &TileRuns, influence: &mut [f32]) {
        let (spans, n) = (self.spans, self.spans.cubics.len());
        let direction = Direction {
            axis: [0, 1, 2].map(|axis| Along::new(self, cell, Attribute::Direction(axis))),
            angle: Along::new(self, cell, Attribute::Angle),
        };
        for i in range {
            if influence[i] > 0.0 {
                let (span, place) = cell.place(f64::from(runs.t[i]), n);
                let point = tile.position(runs.index[i] as usize);
                let from_r = point - spans.cubics[span].at(place);
                let (tangent, extent) = (spans.tangent_in(span, place), point.abs().max_element());
                let turn = direction.turn(runs.t[i], from_r, tangent, extent);
                influence[i] = (f64::from(influence[i]) * self.wire.density.at(turn)) as f32;
            }
        }
    }

    /// What domain curves of an attribute leave of it: it acts by the lesser of their influence and the wire's.
    fn fade(self, runs: &mut TileRuns) {
        let wire = self.wire;
        for run in &runs.list {
            let radius = Along::new(self, self.cells.list[run.cell as usize], Attribute::Radius);
            for i in run.start as usize..run.end as usize {
                let (v, r) = (runs.distance[i], radius.at(runs.t[i]));
                let radial = bounded(wire, Bounded::Influence, v, r, &runs.sides, i);
                for (bounds, fade) in FADES.into_iter().zip(&mut runs.fades) {
                    if let Some(fade) = fade.get_mut(i) {
                        let own = bounded(wire, bounds, v, r, &runs.sides, i);
                        *fade = if own < radial { (own / radial) as f32 } else { 1.0 };
                    }
                }
            }
        }
    }
}

/// An attribute in one cell.
#[derive(Clone, Copy)]
struct Along {
    /// Powers of the distance from the cell's start.
    powers: [f64; 4],
    start: f64,
}

impl Along {
    fn new(measure: Measure<'_>, cell: Cell, attribute: Attribute) -> Self {
        let powers = cell.attribute(measure.wire, attribute, measure.spans.cubics.len());
        Self { powers, start: if let Cell::Stretch { t0, .. } = cell { t0 } else { 0.0 } }
    }

    #[inline]
    fn at(&self, t: f32) -> f64 {
        let ([a, b, c, d], tau) = (self.powers, f64::from(t) - self.start);
        a + tau * (b + tau * (c + tau * d))
    }
}

/// A directional dropoff in one cell.
struct Direction {
    axis: [Along; 3],
    angle: Along,
}

impl Direction {
    /// `φ / a` of a point that lies at `v` from its foot, with coordinates up to `extent`. `φ` is 0 on the curve, and where the axis
    /// or the point lies along it.
    fn turn(&self, t: f32, v: DVec3, tangent: DVec3, extent: f64) -> f64 {
        let across = |v: DVec3, size: f64| {
            let flat = v - tangent * v.dot(tangent);
            if flat.length_squared() <= ALONG * ALONG * size * size { DVec3::ZERO } else { flat }
        };
        let axis = DVec3::from_array([0, 1, 2].map(|i| self.axis[i].at(t)));
        let (axis, v) = (across(axis, axis.length()), across(v, v.length().max(extent)));
        if axis == DVec3::ZERO || v == DVec3::ZERO {
            return 0.0;
        }
        axis.cross(v).length().atan2(axis.dot(v)) / self.angle.at(t)
    }
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
