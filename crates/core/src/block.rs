//! Points searched side by side, and their best feet so far.

use glam::DVec3;
use pulp::Simd;

use crate::piece::Piece;
use crate::simd::Doubles;
use crate::tiles::Tile;

/// Two feet tie when their distances differ by less than this part of the largest coordinate: rounding the input to
/// float32 moves distances by as much, so a curve that is symmetric as written may not be so as stored.
pub(crate) const TIE: f64 = 2.4e-7;

/// Points that are searched side by side.
pub(crate) const BLOCK: usize = 64;

/// One number a point of a block.
pub(crate) type Row = [f64; BLOCK];

/// Up to [`BLOCK`] points, as coordinates side by side, relative to the curve's origin.
pub(crate) struct Block {
    pub(crate) x: Row,
    pub(crate) y: Row,
    pub(crate) z: Row,
    /// [`TIE`] in units of length.
    tie: Row,
    pub(crate) count: usize,
    origin: DVec3,
    /// The largest coordinate of the curve.
    reach: f64,
    /// Feet this much farther than the closest count too.
    width: f64,
}

impl Block {
    pub(crate) fn new(origin: DVec3, reach: f64, width: f64) -> Self {
        let zero = [0.0; BLOCK];
        Self { x: zero, y: zero, z: zero, tie: zero, count: 0, origin, reach, width }
    }

    /// Takes `count` points of a tile, from `start` on.
    #[inline(always)]
    pub(crate) fn fill(&mut self, tile: &Tile, start: usize, count: usize) {
        self.count = count;
        let end = start + count;
        let rows = tile.x[start..end].iter().zip(&tile.y[start..end]).zip(&tile.z[start..end]);
        let origin = self.origin;
        for (i, ((&x, &y), &z)) in rows.enumerate().take(BLOCK) {
            let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
            (self.x[i], self.y[i], self.z[i]) = (x - origin.x, y - origin.y, z - origin.z);
            let largest = x.abs().max(y.abs()).max(z.abs());
            self.tie[i] = TIE * largest.max(self.reach);
        }
    }

    /// Adds a point; at most [`BLOCK`] of them.
    #[inline(always)]
    pub(crate) fn push(&mut self, p: DVec3) {
        let i = self.count & (BLOCK - 1);
        let q = p - self.origin;
        (self.x[i], self.y[i], self.z[i]) = (q.x, q.y, q.z);
        self.tie[i] = TIE * p.abs().max_element().max(self.reach);
        self.count += 1;
    }

    #[inline(always)]
    pub(crate) fn vectors<S: Simd>(&self, simd: S, i: usize) -> [Doubles<S>; 3] {
        [
            Doubles(simd, Doubles::<S>::vectors(&self.x)[i]),
            Doubles(simd, Doubles::<S>::vectors(&self.y)[i]),
            Doubles(simd, Doubles::<S>::vectors(&self.z)[i]),
        ]
    }

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> DVec3 {
        let lane = lane & (BLOCK - 1);
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

/// The best feet so far of a block's points.
pub(crate) struct Feet {
    pub(crate) distance: Row,
    pub(crate) t: Row,
    pub(crate) span: [u32; BLOCK],
    /// The least distance of all feet so far; the best foot may tie with it.
    least: Row,
    /// The least distance but one.
    second: Row,
    /// Farther feet are no use: the least distance and a tie, or how far feet are sought.
    reach: Row,
}

impl Feet {
    pub(crate) fn new() -> Self {
        let zero = [0.0; BLOCK];
        let none = [f64::INFINITY; BLOCK];
        Self { distance: none, t: zero, span: [0; BLOCK], least: none, second: none, reach: zero }
    }

    /// Forgets all feet; new ones are sought up to `reach`.
    pub(crate) fn reset(&mut self, reach: f64) {
        self.distance = [f64::INFINITY; BLOCK];
        self.least = [f64::INFINITY; BLOCK];
        self.second = [f64::INFINITY; BLOCK];
        self.reach = [reach; BLOCK];
    }

    /// How far feet are of use, a number a point.
    #[inline(always)]
    pub(crate) fn reach(&self) -> &Row {
        &self.reach
    }

    /// Whether another foot than the closest is nearer than that one plus `width`, of those that were sought.
    pub(crate) fn has_rival(&self, lane: usize, width: f64) -> bool {
        self.second[lane] < self.least[lane] + width
    }

    /// Whether a foot at `distance` would be of use to any point.
    #[inline(always)]
    pub(crate) fn within(&self, distance: f64, count: usize) -> bool {
        self.reach.iter().take(count).any(|r| distance <= *r)
    }

    /// Takes the foot at `s` if it is nearer than the best by more than a tie, or ties with it at a smaller parameter.
    #[inline(always)]
    pub(crate) fn offer(&mut self, lane: usize, piece: &Piece, block: &Block, s: f64) {
        let lane = lane & (BLOCK - 1);
        let distance = piece.cubic.at(s).distance(block.at(lane));
        let tie = block.tie[lane];
        let (span, t) = piece.place(s);
        let before = self.least[lane];
        let (least, next) = if distance < before { (distance, before) } else { (before, distance) };
        self.least[lane] = least;
        self.second[lane] = if next < self.second[lane] { next } else { self.second[lane] };
        let beaten = self.distance[lane] > least + tie;
        let earlier = (span, t) < (self.span[lane], self.t[lane]);
        if beaten || (earlier && distance <= least + tie) {
            (self.distance[lane], self.span[lane], self.t[lane]) = (distance, span, t);
        }
        let useful = least + tie + block.width;
        self.reach[lane] = if useful < self.reach[lane] { useful } else { self.reach[lane] };
    }
}
