//! \[SF98\] §2: the displacement `ΔP` that one wire gives the points of one run.
//!
//! With `v = P − R(p)` and `F` known since binding: scale `v`, twist it about `R′`, turn it with the bend from `R′` to
//! `W′`, translate by `(W − R)·F`, and take the difference to where it was. Every step is exact where it does nothing, so
//! that an unmoved wire gives exact zeros.
//!
//! Points go through in chunks of [`CHUNK`]: gathered from the tile, computed in vectors as wide as the processor has them,
//! scattered back. No step calls a library function or fuses multiplication and addition, so that every processor gives
//! the same bits.
//!
//! # Deviations
//!
//! The paper's step 1 as printed, `P + v·(1 + (s − 1)F)`, moves every point even at `s = 1`; it must start from `R(p)`. Its
//! axis `W′×R′` turns the wrong way.

use glam::DVec3;
use pulp::Simd;

use crate::follow::tangent_near_joint;
use crate::frame::{CellFrame, Frame, Turn};
use crate::simd::{FloatMask, Floats, Vectors};
use crate::spans::ZERO_TANGENT;
use crate::tiles::{TILE, Tile};
use crate::trig::{atan_unit, sin_cos};

/// Points gathered at a time: a multiple of every vector's width.
const CHUNK: usize = 64;

/// Squared length below which a tangent (in units of its bound) is zero.
const NO_TANGENT: f32 = (ZERO_TANGENT * ZERO_TANGENT) as f32;

/// Squared sine below which opposite tangents have no axis of their own.
const OPPOSITE: f32 = (crate::rotation::OPPOSITE * crate::rotation::OPPOSITE) as f32;

type Lane = [f32; CHUNK];

/// What one wire does to the points of one tile.
#[derive(Clone, Debug)]
pub(crate) struct Displacements {
    pub(crate) x: [f32; TILE],
    pub(crate) y: [f32; TILE],
    pub(crate) z: [f32; TILE],
    /// `F`, for the local blend.
    pub(crate) influence: [f32; TILE],
    /// `m`.
    pub(crate) exponent: f32,
    /// The wire's own, for the pinned blend.
    pub(crate) amplitude: f32,
}

impl Displacements {
    pub(crate) fn new() -> Self {
        let zero = [0.0; TILE];
        Self { x: zero, y: zero, z: zero, influence: zero, exponent: 1.0, amplitude: 1.0 }
    }

    pub(crate) fn clear(&mut self) {
        for row in [&mut self.x, &mut self.y, &mut self.z, &mut self.influence] {
            row.fill(0.0);
        }
    }
}

/// Feet of a run: indices in the tile, places in the segment, influences; all of one length.
#[derive(Clone, Copy)]
pub(crate) struct RunPoints<'a> {
    pub(crate) index: &'a [u16],
    pub(crate) t: &'a [f32],
    pub(crate) influence: &'a [f32],
    /// Shares of the feet, where a point has several; else empty.
    pub(crate) weight: &'a [f32],
    /// What is left of scale, rotation, amplitude and twist, where domain curves bound them; else empty.
    pub(crate) fades: [&'a [f32]; 4],
}

// Places in `RunPoints::fades`.
const SCALE: usize = 0;
const ROTATION: usize = 1;
const AMPLITUDE: usize = 2;
const TWIST: usize = 3;

/// Up to [`CHUNK`] points of a run. What the cell's polynomials do not give is looked up beforehand.
struct Chunk {
    t: Lane,
    influence: Lane,
    /// `P` relative to the frame's origin, then `ΔP`.
    p: [Lane; 3],
    /// `W − R`, `R′` and `W′` by arc length.
    d: [Lane; 3],
    r_tangent: [Lane; 3],
    w_tangent: [Lane; 3],
    /// The rotation vector of transported frames.
    turn: [Lane; 3],
    /// What is left of each attribute; read only where `faded`.
    fades: [Lane; 4],
    faded: [bool; 4],
}

/// Displaces the points of one run.
#[inline(always)]
pub(crate) fn displace<S: Simd>(
    simd: S,
    tile: &Tile,
    frame: &Frame,
    cell: &CellFrame,
    points: RunPoints,
    out: &mut Displacements,
) {
    const ZERO: Lane = [0.0; CHUNK];
    const ZERO3: [Lane; 3] = [ZERO; 3];
    let mut chunk = Chunk {
        t: ZERO,
        influence: ZERO,
        p: ZERO3,
        d: ZERO3,
        r_tangent: ZERO3,
        w_tangent: ZERO3,
        turn: ZERO3,
        fades: [ZERO; 4],
        faded: [0, 1, 2, 3].map(|i: usize| !points.fades[i].is_empty()),
    };
    let chunks = points.index.chunks(CHUNK).zip(points.t.chunks(CHUNK)).zip(points.influence.chunks(CHUNK));
    for (number, ((index, t), influence)) in chunks.enumerate() {
        chunk.gather(tile, frame.origin, index, t, influence);
        for i in 0..chunk.fades.len() {
            if chunk.faded[i] {
                let fade = &points.fades[i][number * CHUNK..];
                chunk.fades[i][..index.len()].copy_from_slice(&fade[..index.len()]);
            }
        }
        if cell.by_length {
            chunk.follow_length(frame, cell, index.len());
        }
        match cell.turn {
            Turn::Table => chunk.look_up(index.len(), |t| frame.turns.at(cell.place + f64::from(t))),
            Turn::Vector(vector) => chunk.look_up(index.len(), |_| vector),
            Turn::None | Turn::Tangent => {}
        }
        for vector in 0..index.len().div_ceil(S::F32_LANES) {
            chunk.displace(simd, cell, vector);
        }
        let weight = points.weight.get(number * CHUNK..).unwrap_or_default();
        chunk.scatter(index, influence, weight, out);
    }
}

impl RunPoints<'_> {
    /// `F` alone, where nothing moves.
    #[inline(always)]
    pub(crate) fn anchor(&self, out: &mut Displacements) {
        for (i, (&k, &f)) in self.index.iter().zip(self.influence).enumerate() {
            let w = self.weight.get(i).copied().unwrap_or(1.0);
            out.influence[k as usize & (TILE - 1)] += w * f;
        }
    }
}

impl Chunk {
    #[inline(always)]
    fn gather(&mut self, tile: &Tile, origin: [f32; 3], index: &[u16], t: &[f32], influence: &[f32]) {
        self.t[..t.len()].copy_from_slice(t);
        self.influence[..influence.len()].copy_from_slice(influence);
        for (i, &k) in index.iter().enumerate().take(CHUNK) {
            let k = k as usize & (TILE - 1);
            self.p[0][i] = tile.x[k] - origin[0];
            self.p[1][i] = tile.y[k] - origin[1];
            self.p[2][i] = tile.z[k] - origin[2];
        }
    }

    /// Displacements and influences to their points; of feet with a `weight` added up.
    #[inline(always)]
    fn scatter(&self, index: &[u16], influence: &[f32], weight: &[f32], out: &mut Displacements) {
        if weight.is_empty() {
            for (i, &k) in index.iter().enumerate().take(CHUNK) {
                let k = k as usize & (TILE - 1);
                out.x[k] = self.p[0][i];
                out.y[k] = self.p[1][i];
                out.z[k] = self.p[2][i];
                out.influence[k] = influence[i];
            }
            return;
        }
        for (i, (&k, &w)) in index.iter().zip(weight).enumerate().take(CHUNK) {
            let k = k as usize & (TILE - 1);
            out.x[k] += w * self.p[0][i];
            out.y[k] += w * self.p[1][i];
            out.z[k] += w * self.p[2][i];
            out.influence[k] += w * influence[i];
        }
    }

    /// `W − R` and both unit tangents at the same fraction of arc length; in float64, so that what is equal on both curves
    /// differs by exactly nothing.
    fn follow_length(&mut self, frame: &Frame, cell: &CellFrame, count: usize) {
        for i in 0..count {
            let (r_span, t) = (cell.place as usize, f64::from(self.t[i]));
            let (w_span, w_t) = frame.places.at(cell.place + t, &frame.w);
            let d = frame.w.cubics[w_span].at(w_t) - frame.r.cubics[r_span].at(t);
            set(&mut self.d, i, d);
            set(&mut self.r_tangent, i, frame.r.tangent_in(r_span, t));
            set(&mut self.w_tangent, i, tangent_near_joint(&frame.w, w_span, w_t));
        }
    }

    fn look_up(&mut self, count: usize, turn: impl Fn(f32) -> [f32; 3]) {
        for i in 0..count {
            let [x, y, z] = turn(self.t[i]);
            (self.turn[0][i], self.turn[1][i], self.turn[2][i]) = (x, y, z);
        }
    }

    /// `ΔP` of the `i`-th vector of points, in place of `P`.
    #[inline(always)]
    fn displace<S: Simd>(&mut self, simd: S, cell: &CellFrame, i: usize) {
        let one = Floats::splat(simd, 1.0);
        let (t, f) = (load(simd, &self.t, i), load(simd, &self.influence, i));
        let rest = load3(simd, &self.p, i) - Vectors::polynomial(t, &cell.r);
        let mut v = rest.times(one + self.attribute(cell, SCALE, t, i) * f);
        let twists = cell.twist != [0.0; 4];
        if twists || cell.turn != Turn::None {
            let r_tangent = if cell.by_length {
                load3(simd, &self.r_tangent, i)
            } else {
                Vectors::polynomial(t, &cell.r_tangent)
            };
            if twists {
                v = twisted(v, r_tangent, self.attribute(cell, TWIST, t, i) * f);
            }
            if cell.turn != Turn::None {
                let w_tangent = if cell.by_length {
                    load3(simd, &self.w_tangent, i)
                } else {
                    Vectors::polynomial(t, &cell.w_tangent)
                };
                let amount = self.attribute(cell, ROTATION, t, i) * f;
                v = if cell.turn == Turn::Tangent {
                    bent(v, r_tangent, w_tangent, amount)
                } else {
                    turned(v, r_tangent, w_tangent, load3(simd, &self.turn, i), amount)
                };
            }
        }
        let d = if cell.by_length { load3(simd, &self.d, i) } else { Vectors::polynomial(t, &cell.d) };
        let moved = ((v - rest) + d.times(f)).times(self.attribute(cell, AMPLITUDE, t, i));
        for axis in 0..3 {
            Floats::<S>::vectors_mut(&mut self.p[axis])[i] = moved.0[axis].1;
        }
    }

    /// An attribute of the `i`-th vector of points, at places `t`; of the scale, how much it differs from 1.
    #[inline(always)]
    fn attribute<S: Simd>(&self, cell: &CellFrame, which: usize, t: Floats<S>, i: usize) -> Floats<S> {
        let powers = match which {
            SCALE => &cell.scale,
            ROTATION => &cell.rotation,
            AMPLITUDE => &cell.amplitude,
            _ => &cell.twist,
        };
        let value = if cell.uniform {
            Floats::splat(t.0, powers[0])
        } else {
            (t - Floats::splat(t.0, cell.t0)).polynomial(powers)
        };
        if self.faded[which] { value * load(t.0, &self.fades[which], i) } else { value }
    }
}

fn set(lanes: &mut [Lane; 3], i: usize, v: DVec3) {
    let v = v.as_vec3();
    (lanes[0][i], lanes[1][i], lanes[2][i]) = (v.x, v.y, v.z);
}

#[inline(always)]
fn load<S: Simd>(simd: S, lane: &Lane, i: usize) -> Floats<S> {
    Floats(simd, Floats::<S>::vectors(lane)[i])
}

#[inline(always)]
fn load3<S: Simd>(simd: S, lanes: &[Lane; 3], i: usize) -> Vectors<S> {
    Vectors([load(simd, &lanes[0], i), load(simd, &lanes[1], i), load(simd, &lanes[2], i)])
}

/// `v` rotated about `R′` by `angle`.
#[inline(always)]
fn twisted<S: Simd>(v: Vectors<S>, r: Vectors<S>, angle: Floats<S>) -> Vectors<S> {
    let (zero, one) = (Floats::splat(angle.0, 0.0), Floats::splat(angle.0, 1.0));
    let square = r.dot(r);
    let has_tangent = Floats::splat(angle.0, NO_TANGENT).less(square);
    let inverse = one / has_tangent.select(square, one).sqrt();
    rotated(v, r.times(inverse), has_tangent.select(angle, zero))
}

/// `v` rotated about `R′×W′` by `θ·amount`.
///
/// With `a = |R′||W′|`, `s = |R′×W′|` and `c = a + R′·W′`, `tan(θ/4) = s / (c + √(2ac))`, of which the arc tangent needs no
/// branch; where the angle is obtuse `c = s² / (a − R′·W′)` keeps it exact.
#[inline(always)]
fn bent<S: Simd>(v: Vectors<S>, r: Vectors<S>, w: Vectors<S>, amount: Floats<S>) -> Vectors<S> {
    let simd = amount.0;
    let (zero, one, two) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0), Floats::splat(simd, 2.0));
    let (r2, w2, cosine, axis) = (r.dot(r), w.dot(w), r.dot(w), r.cross(w));
    let (square, s2) = (r2 * w2, axis.dot(axis));
    let (a, s) = (square.sqrt(), s2.sqrt());
    let obtuse = cosine.less(zero);
    let c = obtuse.select(s2 / (a - cosine), a + cosine);
    let opposite = obtuse & s2.less(Floats::splat(simd, OPPOSITE) * square);
    let quarter = s / (c + (two * a * c).sqrt());
    let half_turn = Floats::splat(simd, std::f32::consts::PI);
    let theta = opposite.select(half_turn, Floats::splat(simd, 4.0) * atan_unit(quarter));
    let turns = has_tangents(r2, w2) & (zero.less(s) | opposite);
    let fixed = perpendicular(r);
    let axis = Vectors::select(opposite, fixed, axis);
    let length = opposite.select(fixed.dot(fixed).sqrt(), s);
    let inverse = one / turns.select(length, one);
    rotated(v, axis.times(inverse), turns.select(theta * amount, zero))
}

/// `v` rotated by the vector `turn`, times `amount`.
#[inline(always)]
fn turned<S: Simd>(
    v: Vectors<S>,
    r: Vectors<S>,
    w: Vectors<S>,
    turn: Vectors<S>,
    amount: Floats<S>,
) -> Vectors<S> {
    let (zero, one) = (Floats::splat(amount.0, 0.0), Floats::splat(amount.0, 1.0));
    let length = turn.dot(turn).sqrt();
    let turns = zero.less(length) & has_tangents(r.dot(r), w.dot(w));
    let inverse = one / turns.select(length, one);
    rotated(v, turn.times(inverse), turns.select(length * amount, zero))
}

/// Whether neither curve stands still, by the squares of their tangents.
#[inline(always)]
fn has_tangents<S: Simd>(r2: Floats<S>, w2: Floats<S>) -> FloatMask<S> {
    let least = Floats::splat(r2.0, NO_TANGENT);
    least.less(r2) & least.less(w2)
}

/// `v` rotated about the unit vector `axis` (Rodrigues); `v` itself at angle 0.
#[inline(always)]
fn rotated<S: Simd>(v: Vectors<S>, axis: Vectors<S>, angle: Floats<S>) -> Vectors<S> {
    let (sine, cosine) = sin_cos(angle);
    let side = axis.cross(v);
    let inward = axis.cross(side);
    v + (side.times(sine) + inward.times(Floats::splat(angle.0, 1.0) - cosine))
}

/// As [`crate::rotation::fixed_perpendicular`], not normalised.
#[inline(always)]
fn perpendicular<S: Simd>(a: Vectors<S>) -> Vectors<S> {
    let (x, y, z) = (a.0[0].abs(), a.0[1].abs(), a.0[2].abs());
    let (zero, one) = (Floats::splat(x.0, 0.0), Floats::splat(x.0, 1.0));
    let first = x.at_most(y) & x.at_most(z);
    let second = !first & y.at_most(z);
    let third = !(first | second);
    a.cross(Vectors([first.select(one, zero), second.select(one, zero), third.select(one, zero)]))
}
