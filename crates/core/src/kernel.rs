//! [SF98] §2: the displacement `ΔP` that one wire gives the points of one run.
//!
//! With `v = P − R(p)` and `F` known since binding: scale `v`, twist it about `R′`, turn it with the bend from `R′` to
//! `W′`, translate by `(W − R)·F`, and take the difference to where it was. Every step is exact where it does nothing, so
//! that an unmoved wire gives exact zeros.
//!
//! Points go through in lanes of [`CHUNK`]: gathered from the tile, computed in loops over plain arrays, which compile to
//! vector code of whatever width the processor has, and scattered back. No step calls a library function or fuses
//! multiplication and addition, so that every processor gives the same bits.
//!
//! # Deviations
//!
//! The paper's step 1 as printed, `P + v·(1 + (s − 1)F)`, moves every point even at `s = 1`; it must start from `R(p)`. Its
//! axis `W′×R′` turns the wrong way.

use crate::frame::{CellFrame, Frame, Turn};
use crate::spans::{Spans, ZERO_TANGENT};
use crate::tiles::{TILE, Tile};
use crate::trig::{atan_unit, sin_cos};

/// Points computed side by side; their intermediate values fill a fifth of a first-level cache.
const CHUNK: usize = 64;

/// Vectors are full up to this many lanes, so that no remainder loop runs.
const PAD: usize = 16;

/// Squared length below which a tangent (in units of its bound) is zero.
const NO_TANGENT: f32 = (ZERO_TANGENT * ZERO_TANGENT) as f32;

/// Squared sine below which opposite tangents have no axis of their own.
const OPPOSITE: f32 = (crate::rotation::OPPOSITE * crate::rotation::OPPOSITE) as f32;

type Lane = [f32; CHUNK];

/// Three coordinates, side by side.
#[derive(Clone, Copy)]
struct Lanes3 {
    x: Lane,
    y: Lane,
    z: Lane,
}

const ZERO: Lane = [0.0; CHUNK];
const ZERO3: Lanes3 = Lanes3 { x: ZERO, y: ZERO, z: ZERO };

impl Lanes3 {
    #[inline(always)]
    fn at(&self, i: usize) -> [f32; 3] {
        [self.x[i], self.y[i], self.z[i]]
    }

    #[inline(always)]
    fn set(&mut self, i: usize, v: [f32; 3]) {
        (self.x[i], self.y[i], self.z[i]) = (v[0], v[1], v[2]);
    }
}

/// What one wire does to the points of one tile.
#[derive(Clone, Debug)]
pub(crate) struct Displacements {
    pub(crate) x: [f32; TILE],
    pub(crate) y: [f32; TILE],
    pub(crate) z: [f32; TILE],
    /// `F`, kept only where the local blend wants it.
    pub(crate) influence: [f32; TILE],
    /// `m`.
    pub(crate) exponent: f32,
}

impl Displacements {
    pub(crate) fn new() -> Self {
        let zero = [0.0; TILE];
        Self { x: zero, y: zero, z: zero, influence: zero, exponent: 1.0 }
    }

    pub(crate) fn clear(&mut self) {
        (self.x, self.y, self.z, self.influence) = ([0.0; TILE], [0.0; TILE], [0.0; TILE], [0.0; TILE]);
    }
}

/// Feet of a run: indices in the tile, places in the segment, influences; all of one length.
#[derive(Clone, Copy)]
pub(crate) struct RunPoints<'a> {
    pub(crate) index: &'a [u16],
    pub(crate) t: &'a [f32],
    pub(crate) influence: &'a [f32],
}

/// Displaces the points of one run.
#[inline(always)]
pub(crate) fn displace(
    tile: &Tile,
    frame: &Frame,
    cell: &CellFrame,
    points: RunPoints,
    out: &mut Displacements,
) {
    let chunks = points.index.chunks(CHUNK).zip(points.t.chunks(CHUNK)).zip(points.influence.chunks(CHUNK));
    for ((index, t), influence) in chunks {
        let mut lanes = Lanes::gather(tile, frame.origin, index, t, influence);
        lanes.place(cell);
        if cell.by_length {
            lanes.place_by_length(frame, cell, index.len());
        }
        if cell.twist != [0.0; 4] {
            lanes.twist(cell);
        }
        match cell.turn {
            Turn::None => {}
            Turn::Tangent => lanes.bend(cell),
            Turn::Table => lanes.turn_by(cell, index.len(), |t| frame.turns.at(cell.place + f64::from(t))),
            Turn::Vector(vector) => lanes.turn_by(cell, index.len(), |_| vector),
        }
        lanes.finish(cell);
        lanes.scatter(index, out);
    }
}

struct Lanes {
    count: usize,
    t: Lane,
    influence: Lane,
    /// `P` relative to the frame's origin, then `v`, then `ΔP`.
    v: Lanes3,
    /// `v` as it was.
    rest: Lanes3,
    /// `W − R`.
    d: Lanes3,
    r_tangent: Lanes3,
    w_tangent: Lanes3,
}

impl Lanes {
    #[inline(always)]
    fn gather(tile: &Tile, origin: [f32; 3], index: &[u16], t: &[f32], influence: &[f32]) -> Self {
        let mut lanes = Self {
            count: index.len().next_multiple_of(PAD).min(CHUNK),
            t: ZERO,
            influence: ZERO,
            v: ZERO3,
            rest: ZERO3,
            d: ZERO3,
            r_tangent: ZERO3,
            w_tangent: ZERO3,
        };
        lanes.t[..t.len()].copy_from_slice(t);
        lanes.influence[..influence.len()].copy_from_slice(influence);
        for (i, &k) in index.iter().enumerate().take(CHUNK) {
            let k = k as usize & (TILE - 1);
            lanes.v.x[i] = tile.x[k] - origin[0];
            lanes.v.y[i] = tile.y[k] - origin[1];
            lanes.v.z[i] = tile.z[k] - origin[2];
        }
        lanes
    }

    /// `v`, scaled, and the curves at the feet.
    #[inline(always)]
    fn place(&mut self, cell: &CellFrame) {
        for i in 0..self.count.min(CHUNK) {
            let (t, f) = (self.t[i], self.influence[i]);
            let v = sub(self.v.at(i), cubic(&cell.r, t));
            self.rest.set(i, v);
            self.d.set(i, cubic(&cell.d, t));
            self.r_tangent.set(i, quadratic(&cell.r_tangent, t));
            self.w_tangent.set(i, quadratic(&cell.w_tangent, t));
            self.v.set(i, scaled(v, 1.0 + attribute(&cell.scale, cell.uniform, t) * f));
        }
    }

    /// The same for `W` at the same fraction of arc length.
    #[inline(always)]
    fn place_by_length(&mut self, frame: &Frame, cell: &CellFrame, count: usize) {
        let w: &Spans = &frame.w;
        let origin = crate::spans::to_dvec3(frame.origin);
        for i in 0..count.min(CHUNK) {
            let (span, t) = frame.places.at(cell.place + f64::from(self.t[i]), w);
            let on_w = (w.cubics[span].at(t) - origin).as_vec3().to_array();
            self.d.set(i, sub(on_w, cubic(&cell.r, self.t[i])));
            self.w_tangent
                .set(i, crate::follow::tangent_near_joint(w, span, t).as_vec3().to_array());
        }
    }

    /// Rotates `v` about `R′` by `twist·F`.
    #[inline(always)]
    fn twist(&mut self, cell: &CellFrame) {
        for i in 0..self.count.min(CHUNK) {
            let r = self.r_tangent.at(i);
            let square = dot(r, r);
            let has_tangent = square > NO_TANGENT;
            let inverse = 1.0 / if has_tangent { square } else { 1.0 }.sqrt();
            let angle = attribute(&cell.twist, cell.uniform, self.t[i]) * self.influence[i];
            let angle = if has_tangent { angle } else { 0.0 };
            self.v.set(i, rotated(self.v.at(i), scaled(r, inverse), angle));
        }
    }

    /// Rotates `v` about `R′×W′` by `θ·F·rotation`.
    ///
    /// With `a = |R′||W′|`, `s = |R′×W′|` and `c = a + R′·W′`, `tan(θ/4) = s / (c + √(2ac))`, of which the arc tangent
    /// needs no branch; where the angle is obtuse `c = s² / (a − R′·W′)` keeps it exact.
    #[inline(always)]
    fn bend(&mut self, cell: &CellFrame) {
        for i in 0..self.count.min(CHUNK) {
            let (r, w) = (self.r_tangent.at(i), self.w_tangent.at(i));
            let (r2, w2) = (dot(r, r), dot(w, w));
            let axis = cross(r, w);
            let cosine = dot(r, w);
            let (square, s2) = (r2 * w2, dot(axis, axis));
            let (a, s) = (square.sqrt(), s2.sqrt());
            let obtuse = cosine < 0.0;
            let c = if obtuse { s2 / (a - cosine) } else { a + cosine };
            let opposite = obtuse && s2 < OPPOSITE * square;
            let quarter = s / (c + (2.0 * a * c).sqrt());
            let theta = if opposite { std::f32::consts::PI } else { 4.0 * atan_unit(quarter) };
            let has_tangents = r2 > NO_TANGENT && w2 > NO_TANGENT;
            let turns = has_tangents && (s > 0.0 || opposite);
            let fixed = perpendicular(r);
            let axis = if opposite { fixed } else { axis };
            let length = if opposite { dot(fixed, fixed).sqrt() } else { s };
            let inverse = 1.0 / if turns { length } else { 1.0 };
            let angle = theta * self.influence[i] * attribute(&cell.rotation, cell.uniform, self.t[i]);
            let angle = if turns { angle } else { 0.0 };
            self.v.set(i, rotated(self.v.at(i), scaled(axis, inverse), angle));
        }
    }

    /// Rotates `v` by the vector that `turn` gives for each foot, times `F·rotation`.
    #[inline(always)]
    fn turn_by(&mut self, cell: &CellFrame, count: usize, turn: impl Fn(f32) -> [f32; 3]) {
        let mut vector = ZERO3;
        for i in 0..count.min(CHUNK) {
            vector.set(i, turn(self.t[i]));
        }
        for i in 0..self.count.min(CHUNK) {
            let u = vector.at(i);
            let length = dot(u, u).sqrt();
            let (r, w) = (self.r_tangent.at(i), self.w_tangent.at(i));
            let turns = length > 0.0 && dot(r, r) > NO_TANGENT && dot(w, w) > NO_TANGENT;
            let inverse = 1.0 / if turns { length } else { 1.0 };
            let angle = length * self.influence[i] * attribute(&cell.rotation, cell.uniform, self.t[i]);
            let angle = if turns { angle } else { 0.0 };
            self.v.set(i, rotated(self.v.at(i), scaled(u, inverse), angle));
        }
    }

    /// `ΔP = amplitude·(v − rest + (W − R)·F)`.
    #[inline(always)]
    fn finish(&mut self, cell: &CellFrame) {
        for i in 0..self.count.min(CHUNK) {
            let a = attribute(&cell.amplitude, cell.uniform, self.t[i]);
            let moved = sub(self.v.at(i), self.rest.at(i));
            let carried = scaled(self.d.at(i), self.influence[i]);
            self.v.set(i, scaled(add(moved, carried), a));
        }
    }

    #[inline(always)]
    fn scatter(&self, index: &[u16], out: &mut Displacements) {
        for (i, &k) in index.iter().enumerate().take(CHUNK) {
            let k = k as usize & (TILE - 1);
            out.x[k] = self.v.x[i];
            out.y[k] = self.v.y[i];
            out.z[k] = self.v.z[i];
            out.influence[k] = self.influence[i];
        }
    }
}

#[inline(always)]
fn attribute(p: &[f32; 4], uniform: bool, t: f32) -> f32 {
    if uniform { p[0] } else { p[0] + t * (p[1] + t * (p[2] + t * p[3])) }
}

#[inline(always)]
fn cubic(c: &[[f32; 3]; 4], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| c[0][k] + t * (c[1][k] + t * (c[2][k] + t * c[3][k])))
}

#[inline(always)]
fn quadratic(c: &[[f32; 3]; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| c[0][k] + t * (c[1][k] + t * c[2][k]))
}

#[inline(always)]
fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn scaled(a: [f32; 3], s: f32) -> [f32; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `v` rotated about the unit vector `axis` (Rodrigues); `v` itself at angle 0.
#[inline(always)]
fn rotated(v: [f32; 3], axis: [f32; 3], angle: f32) -> [f32; 3] {
    let (sine, cosine) = sin_cos(angle);
    let side = cross(axis, v);
    let inward = cross(axis, side);
    add(v, add(scaled(side, sine), scaled(inward, 1.0 - cosine)))
}

/// As [`crate::rotation::fixed_perpendicular`], not normalised.
#[inline(always)]
fn perpendicular(a: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = a.map(f32::abs);
    let first = x <= y && x <= z;
    let second = !first && y <= z;
    let axis = [f32::from(u8::from(first)), f32::from(u8::from(second)), f32::from(u8::from(!first && !second))];
    cross(a, axis)
}
