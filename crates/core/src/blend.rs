//! \[SF98\] §4: the displacements of many wires become one.
//!
//! `lerp( lerp(Σ ΔPᵢ wᵢ^mᵢ / Σ wᵢ^mᵢ, Σ ΔPᵢ, crossing), Σ ΔPᵢ Fᵢ^k / Σ Fᵢ^k, localize )`, `wᵢ = ‖ΔPᵢ‖ / max ‖ΔPⱼ‖`, over the wires that
//! move the point; in the local part over all that reach it.
//!
//! Where all `m` are 0, 1 or 2 alike the weights are 1, `‖ΔPᵢ‖`, `‖ΔPᵢ‖²`: the common factor cancels. Otherwise they
//! are powers of two of `mᵢ·log₂ wᵢ`, less the largest of these at the point, so that none overflows.

use pulp::Simd;

use crate::Blend;
use crate::kernel::Displacements;
use crate::simd::{Floats, Vectors};
use crate::tiles::{TILE, Tile};
use crate::trig::{exp2_where, log2};

type Row = [f32; TILE];

/// Sums over wires for the points of a tile.
pub(crate) struct Sums {
    weighted: [Row; 3],
    weight: Row,
    plain: [Row; 3],
    local: [Row; 3],
    local_weight: Row,
    /// The largest `log₂ ‖ΔPᵢ‖`, or `k·log₂ F`, of a point's wires.
    largest: Row,
    /// The largest exponent of two of a point's weights.
    peak: Row,
}

const ZERO: Row = [0.0; TILE];

/// Stands for the logarithm of zero; finite, so that differences are numbers.
const NOTHING: f32 = -1e30;

/// `1 − G` of a point that lies on a reference, where it is 0: so far below the steps of f32 that others, however near, do not count
/// beside it. Were it one of these steps, they would pull at such points by some 1e-5 of what they do.
const ON_REFERENCE: f32 = f32::EPSILON * f32::EPSILON;

/// Reads the `i`-th vector of a row.
#[inline(always)]
fn read<S: Simd>(simd: S, row: &Row, i: usize) -> Floats<S> {
    Floats(simd, Floats::<S>::vectors(row)[i])
}

/// Adds to the `i`-th vector of a row.
#[inline(always)]
fn add<S: Simd>(row: &mut Row, i: usize, x: Floats<S>) {
    let row = Floats::<S>::vectors_mut(row);
    row[i] = (Floats(x.0, row[i]) + x).1;
}

#[inline(always)]
fn add3<S: Simd>(rows: &mut [Row; 3], i: usize, x: Vectors<S>) {
    let [rx, ry, rz] = rows;
    add(rx, i, x.0[0]);
    add(ry, i, x.0[1]);
    add(rz, i, x.0[2]);
}

/// `G / (1 − G)` of a wire in the pinned blend, by its own amplitude and its influence.
pub(crate) fn pinned_weight(amplitude: f32, influence: f64) -> f64 {
    let g = f64::from(amplitude.clamp(0.0, 1.0)) * influence;
    g / (1.0 - g).max(f64::from(ON_REFERENCE))
}

impl Displacements {
    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, i: usize) -> Vectors<S> {
        Vectors([read(simd, &self.x, i), read(simd, &self.y, i), read(simd, &self.z, i)])
    }
}

impl Sums {
    pub(crate) fn new() -> Self {
        let zero3 = [ZERO; 3];
        Self {
            weighted: zero3,
            weight: ZERO,
            plain: zero3,
            local: zero3,
            local_weight: ZERO,
            largest: ZERO,
            peak: ZERO,
        }
    }

    /// The blended displacement of every point of the tile, into the first of `wires`. `unit` is about one over the
    /// size of the scene, so that squares neither overflow nor vanish.
    #[inline(always)]
    pub(crate) fn combine<S: Simd>(
        &mut self,
        simd: S,
        wires: &mut [Displacements],
        blend: &Blend,
        unit: f32,
    ) {
        let Some(m) = wires.first().map(|w| w.exponent) else { return };
        let alike = wires.iter().all(|w| w.exponent == m);
        let unit = Floats::splat(simd, unit);
        self.weighted.iter_mut().chain([&mut self.weight]).for_each(|row| row.fill(0.0));
        match m {
            // Nothing of it would be left.
            _ if blend.localize == 1.0 => {}
            0.0 if alike => self.weigh::<S, 0>(unit, wires),
            1.0 if alike => self.weigh::<S, 1>(unit, wires),
            2.0 if alike => self.weigh::<S, 2>(unit, wires),
            _ => self.weigh_powers(simd, wires),
        }
        if blend.crossing != 0.0 {
            self.add_plain(simd, wires);
        }
        if blend.localize != 0.0 {
            if blend.pinned {
                self.add_pinned(simd, wires);
            } else {
                self.add_local(Floats::splat(simd, blend.locality), wires);
            }
        }
        let Some(out) = wires.first_mut() else { return };
        for (axis, out) in [&mut out.x, &mut out.y, &mut out.z].into_iter().enumerate() {
            self.finish(simd, axis, blend, out);
        }
    }

    /// Weights that are whole powers `M` of the displacements' lengths.
    #[inline(always)]
    fn weigh<S: Simd, const M: u8>(&mut self, unit: Floats<S>, wires: &[Displacements]) {
        let (zero, one) = (Floats::splat(unit.0, 0.0), Floats::splat(unit.0, 1.0));
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                let d = wire.read(unit.0, i);
                let w = match M {
                    0 => zero.less(largest(d)).select(one, zero),
                    1 => square(d, unit).sqrt(),
                    _ => square(d, unit),
                };
                add3(&mut self.weighted, i, d.times(w));
                add(&mut self.weight, i, w);
            }
        }
    }

    #[inline(always)]
    fn weigh_powers<S: Simd>(&mut self, simd: S, wires: &[Displacements]) {
        (self.largest, self.peak) = ([NOTHING; TILE], [NOTHING; TILE]);
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                keep_larger(&mut self.largest, i, log_length(wire.read(simd, i)));
            }
        }
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                let log = log_length(wire.read(simd, i));
                keep_larger(&mut self.peak, i, power(wire.exponent, log, read(simd, &self.largest, i)));
            }
        }
        let nothing = Floats::splat(simd, NOTHING);
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                let d = wire.read(simd, i);
                let log = log_length(d);
                let power = power(wire.exponent, log, read(simd, &self.largest, i));
                let w = exp2_where(nothing.less(log), power - read(simd, &self.peak, i));
                add3(&mut self.weighted, i, d.times(w));
                add(&mut self.weight, i, w);
            }
        }
    }

    #[inline(always)]
    fn add_plain<S: Simd>(&mut self, simd: S, wires: &[Displacements]) {
        self.plain.iter_mut().for_each(|row| row.fill(0.0));
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                add3(&mut self.plain, i, wire.read(simd, i));
            }
        }
    }

    /// `F^k` is taken relative to the largest, so that a large `k` leaves the sum something to divide by.
    #[inline(always)]
    fn add_local<S: Simd>(&mut self, locality: Floats<S>, wires: &[Displacements]) {
        let simd = locality.0;
        self.local.iter_mut().chain([&mut self.local_weight]).for_each(|row| row.fill(0.0));
        self.largest.fill(NOTHING);
        let (zero, nothing) = (Floats::splat(simd, 0.0), Floats::splat(simd, NOTHING));
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                let f = read(simd, &wire.influence, i);
                keep_larger(&mut self.largest, i, zero.less(f).select(locality * log2(f), nothing));
            }
        }
        for wire in wires {
            for i in 0..TILE / S::F32_LANES {
                let f = read(simd, &wire.influence, i);
                let w = exp2_where(zero.less(f), locality * log2(f) - read(simd, &self.largest, i));
                add3(&mut self.local, i, wire.read(simd, i).times(w));
                add(&mut self.local_weight, i, w);
            }
        }
    }

    /// The local part by `G / (1 − G)`; on several references at once, as where they meet, all have the same say.
    #[inline(always)]
    fn add_pinned<S: Simd>(&mut self, simd: S, wires: &[Displacements]) {
        self.local.iter_mut().chain([&mut self.local_weight]).for_each(|row| row.fill(0.0));
        let (one, least) = (Floats::splat(simd, 1.0), Floats::splat(simd, ON_REFERENCE));
        for wire in wires {
            let amplitude = Floats::splat(simd, wire.amplitude.clamp(0.0, 1.0));
            for i in 0..TILE / S::F32_LANES {
                let g = amplitude * read(simd, &wire.influence, i);
                let rest = one - g;
                let w = g / least.less(rest).select(rest, least);
                add3(&mut self.local, i, wire.read(simd, i).times(w));
                add(&mut self.local_weight, i, w);
            }
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, axis: usize, blend: &Blend, out: &mut Row) {
        for (i, out) in Floats::<S>::vectors_mut(out).iter_mut().enumerate() {
            let mut sum = quotient(read(simd, &self.weighted[axis], i), read(simd, &self.weight, i));
            if blend.crossing != 0.0 {
                let crossing = Floats::splat(simd, blend.crossing);
                sum = sum + (read(simd, &self.plain[axis], i) - sum) * crossing;
            }
            if blend.localize != 0.0 {
                let local = quotient(read(simd, &self.local[axis], i), read(simd, &self.local_weight, i));
                sum = sum + (local - sum) * Floats::splat(simd, blend.localize);
            }
            *out = sum.1;
        }
    }
}

/// `‖ΔP‖²` in units of the scene.
#[inline(always)]
fn square<S: Simd>(d: Vectors<S>, unit: Floats<S>) -> Floats<S> {
    let d = d.times(unit);
    d.dot(d)
}

/// The largest coordinate.
#[inline(always)]
fn largest<S: Simd>(d: Vectors<S>) -> Floats<S> {
    let (x, y, z) = (d.0[0].abs(), d.0[1].abs(), d.0[2].abs());
    let xy = x.less(y).select(y, x);
    xy.less(z).select(z, xy)
}

/// `log₂ ‖ΔP‖`, of displacements however small.
#[inline(always)]
fn log_length<S: Simd>(d: Vectors<S>) -> Floats<S> {
    let simd = d.0[0].0;
    let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
    let size = largest(d);
    let moves = zero.less(size);
    let size = moves.select(size, one);
    let unit = d.times(one / size);
    let log = log2(size) + Floats::splat(simd, 0.5) * log2(unit.dot(unit));
    moves.select(log, Floats::splat(simd, NOTHING))
}

/// `m·log₂ w` of a wire whose displacement has length `2^log`, beside the largest.
#[inline(always)]
fn power<S: Simd>(exponent: f32, log: Floats<S>, largest: Floats<S>) -> Floats<S> {
    let nothing = Floats::splat(log.0, NOTHING);
    nothing.less(log).select(Floats::splat(log.0, exponent) * (log - largest), nothing)
}

#[inline(always)]
fn keep_larger<S: Simd>(row: &mut Row, i: usize, x: Floats<S>) {
    let row = Floats::<S>::vectors_mut(row);
    let old = Floats(x.0, row[i]);
    row[i] = old.less(x).select(x, old).1;
}

/// `a / b`, 0 where nothing was weighed.
#[inline(always)]
fn quotient<S: Simd>(a: Floats<S>, b: Floats<S>) -> Floats<S> {
    let (zero, one) = (Floats::splat(a.0, 0.0), Floats::splat(a.0, 1.0));
    let weighed = zero.less(b);
    weighed.select(a / weighed.select(b, one), zero)
}

/// Writes the tile's points, displaced; a point whose displacement is zero keeps its bits.
#[inline(always)]
pub(crate) fn write(tile: &Tile, displaced: Option<&Displacements>, out: &mut [[f32; 3]]) {
    let Some(d) = displaced else {
        for (i, out) in out.iter_mut().enumerate().take(TILE) {
            *out = tile.point(i);
        }
        return;
    };
    let moved = |p: f32, d: f32| if d == 0.0 { p } else { p + d };
    for (i, out) in out.iter_mut().enumerate().take(TILE) {
        *out = [moved(tile.x[i], d.x[i]), moved(tile.y[i], d.y[i]), moved(tile.z[i], d.z[i])];
    }
}
