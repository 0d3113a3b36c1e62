//! [SF98] §4: the displacements of many wires become one.
//!
//! `lerp( lerp(Σ ΔPᵢ wᵢ^mᵢ / Σ wᵢ^mᵢ, Σ ΔPᵢ, crossing), Σ ΔPᵢ Fᵢ^k / Σ Fᵢ^k, localize )`, `wᵢ = ‖ΔPᵢ‖ / max ‖ΔPⱼ‖`, over the wires that
//! move the point; in the local part over all that reach it.
//!
//! Where all `m` are 0, 1 or 2 alike the weights are 1, `‖ΔPᵢ‖`, `‖ΔPᵢ‖²`: the common factor cancels. Otherwise they
//! are powers of two of `mᵢ·log₂ wᵢ`, less the largest of these at the point, so that none overflows.

use crate::Blend;
use crate::kernel::Displacements;
use crate::tiles::{TILE, Tile};
use crate::trig::{exp2, log2};

type Row = [f32; TILE];

/// Sums over wires for the points of a tile.
pub(crate) struct Sums {
    weighted: [Row; 3],
    weight: Row,
    plain: [Row; 3],
    local: [Row; 3],
    local_weight: Row,
    /// The largest `log₂ ‖ΔPᵢ‖`, then the largest exponent of two.
    largest: Row,
    peak: Row,
}

const ZERO: Row = [0.0; TILE];

/// Stands for the logarithm of zero.
const NOTHING: f32 = f32::NEG_INFINITY;

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
    pub(crate) fn combine(&mut self, wires: &mut [Displacements], blend: &Blend, unit: f32) {
        let Some(first) = wires.first() else { return };
        if wires.len() == 1 {
            return;
        }
        let m = first.exponent;
        let alike = wires.iter().all(|w| w.exponent == m);
        (self.weighted, self.weight) = ([ZERO; 3], ZERO);
        match m {
            0.0 if alike => self.weigh(wires, unit, |square| f32::from(u8::from(square > 0.0))),
            1.0 if alike => self.weigh(wires, unit, f32::sqrt),
            2.0 if alike => self.weigh(wires, unit, |square| square),
            _ => self.weigh_powers(wires, unit),
        }
        if blend.crossing != 0.0 {
            self.add_plain(wires);
        }
        if blend.localize != 0.0 {
            self.add_local(wires, blend.locality);
        }
        let Some(out) = wires.first_mut() else { return };
        for (axis, out) in [&mut out.x, &mut out.y, &mut out.z].into_iter().enumerate() {
            self.finish(axis, blend, out);
        }
    }

    #[inline(always)]
    fn weigh(&mut self, wires: &[Displacements], unit: f32, weight: impl Fn(f32) -> f32) {
        for wire in wires {
            for i in 0..TILE {
                let w = weight(square(wire, i, unit));
                self.weighted[0][i] += w * wire.x[i];
                self.weighted[1][i] += w * wire.y[i];
                self.weighted[2][i] += w * wire.z[i];
                self.weight[i] += w;
            }
        }
    }

    #[inline(always)]
    fn weigh_powers(&mut self, wires: &[Displacements], unit: f32) {
        (self.largest, self.peak) = ([NOTHING; TILE], [NOTHING; TILE]);
        for wire in wires {
            for i in 0..TILE {
                self.largest[i] = larger(self.largest[i], half_log(square(wire, i, unit)));
            }
        }
        for wire in wires {
            for i in 0..TILE {
                let power = power(wire, i, unit, self.largest[i]);
                self.peak[i] = larger(self.peak[i], power);
            }
        }
        for wire in wires {
            for i in 0..TILE {
                let power = power(wire, i, unit, self.largest[i]);
                let w = if power > NOTHING { exp2(power - self.peak[i]) } else { 0.0 };
                self.weighted[0][i] += w * wire.x[i];
                self.weighted[1][i] += w * wire.y[i];
                self.weighted[2][i] += w * wire.z[i];
                self.weight[i] += w;
            }
        }
    }

    #[inline(always)]
    fn add_plain(&mut self, wires: &[Displacements]) {
        self.plain = [ZERO; 3];
        for wire in wires {
            for i in 0..TILE {
                self.plain[0][i] += wire.x[i];
                self.plain[1][i] += wire.y[i];
                self.plain[2][i] += wire.z[i];
            }
        }
    }

    #[inline(always)]
    fn add_local(&mut self, wires: &[Displacements], locality: f32) {
        (self.local, self.local_weight) = ([ZERO; 3], ZERO);
        // F^k is taken relative to the largest F, so that a large k leaves the sum something to divide by.
        self.largest = [NOTHING; TILE];
        for wire in wires {
            for i in 0..TILE {
                self.largest[i] = larger(self.largest[i], locality * log2_or_nothing(wire.influence[i], locality));
            }
        }
        for wire in wires {
            for i in 0..TILE {
                let f = wire.influence[i];
                let power = locality * log2_or_nothing(f, locality) - self.largest[i];
                let w = if f > 0.0 { exp2(power) } else { 0.0 };
                self.local[0][i] += w * wire.x[i];
                self.local[1][i] += w * wire.y[i];
                self.local[2][i] += w * wire.z[i];
                self.local_weight[i] += w;
            }
        }
    }

    #[inline(always)]
    fn finish(&self, axis: usize, blend: &Blend, out: &mut Row) {
        for i in 0..TILE {
            let mut sum = quotient(self.weighted[axis][i], self.weight[i]);
            if blend.crossing != 0.0 {
                sum += (self.plain[axis][i] - sum) * blend.crossing;
            }
            if blend.localize != 0.0 {
                sum += (quotient(self.local[axis][i], self.local_weight[i]) - sum) * blend.localize;
            }
            out[i] = sum;
        }
    }
}

#[inline(always)]
fn square(wire: &Displacements, i: usize, unit: f32) -> f32 {
    let (x, y, z) = (wire.x[i] * unit, wire.y[i] * unit, wire.z[i] * unit);
    x * x + y * y + z * z
}

/// `log₂ ‖ΔP‖` of the square.
#[inline(always)]
fn half_log(square: f32) -> f32 {
    if square > 0.0 { 0.5 * log2(square) } else { NOTHING }
}

/// `m·log₂ w`.
#[inline(always)]
fn power(wire: &Displacements, i: usize, unit: f32, largest: f32) -> f32 {
    let log = half_log(square(wire, i, unit));
    if log > NOTHING { wire.exponent * (log - largest) } else { NOTHING }
}

/// `log₂ f`; for no influence the value that loses every comparison after multiplication by `locality`.
#[inline(always)]
fn log2_or_nothing(f: f32, locality: f32) -> f32 {
    if f > 0.0 { log2(f) } else if locality < 0.0 { f32::INFINITY } else { NOTHING }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

#[inline(always)]
fn quotient(a: f32, b: f32) -> f32 {
    if b > 0.0 { a / b } else { 0.0 }
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
