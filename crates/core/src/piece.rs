//! One stretch of a curve, and the feet that many points have on it.
//!
//! The feet are rising roots of `g(s) = (R(s) − P)·R′(s)`, see [`closest`](crate::closest).

use glam::DVec3;
use pulp::Simd;

use crate::block::{BLOCK, Block, Feet, Row};
use crate::quintic::{self, Bernstein};
use crate::simd::Doubles;
use crate::spans::Cubic;

/// A piece turns by at most about this (radians), so that a point nearer than twice the piece's radius of curvature
/// rarely sees more than one sign change.
const TURN: f64 = 0.5;

/// More pieces a segment than this cost more in culling than they save in isolation.
const MOST_PIECES: usize = 8;

/// Newton steps done on all lanes of a block; a lane that has not settled by then takes the bracketed road.
const STEPS: usize = 6;

/// A lane has settled when its last step was below this: the next would be below its square.
const SETTLED: f64 = 1e-8;

/// Bounds of distances are widened by this part, more than they can be wrong by rounding.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A foot within this of a closed curve's end, in parts of a piece, is at its start: rounding puts it on either side.
const CLOSED: f64 = 1e-12;

/// The same where the curve comes to a standstill there: feet are found to the square root of the rounding, and the curve
/// moves by the square of this.
const CLOSED_STILL: f64 = 1e-5;

// What a point has on a piece; a mark is a sum of these, kept as a number among numbers.
/// The piece's start is a foot.
const START: f64 = 1.0;
/// The curve's end is a foot.
const END: f64 = 2.0;
/// Exactly one foot lies inside.
pub(crate) const SINGLE: f64 = 4.0;
/// Several sign changes: feet are to be isolated.
const SEVERAL: f64 = 8.0;

/// A stretch of one segment, `s ∈ [0, 1]`.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    span: u32,
    t0: f64,
    width: f64,
    pub(crate) cubic: Cubic,
    /// Powers of `R·R′`; those of `P·R′` are taken from the cubic.
    powers: [f64; 6],
    /// `g` in the Bernstein basis is `a − P·b`.
    pub(crate) a: Bernstein,
    pub(crate) b: [DVec3; 6],
    /// The last row of the piece before, where there is one.
    pub(crate) before: Option<(f64, DVec3)>,
    /// Whether the curve ends here.
    pub(crate) last: bool,
    /// Within this of the end, in parts of the piece, a closed curve is back at its start; 0 where it is not.
    pub(crate) closes: f64,
    /// Whether all of the piece is the start of a closed curve, which stands still from here to its end.
    pub(crate) rests: bool,
    /// The chord's start, direction and inverse squared length, and how far the piece strays from it.
    chord: (DVec3, DVec3, f64),
    pub(crate) stray: f64,
}

impl Piece {
    pub(crate) fn new(span: usize, t0: f64, width: f64, mut cubic: Cubic, origin: DVec3) -> Self {
        cubic.0[0] -= origin;
        let c = &cubic.0;
        let d = [c[1], 2.0 * c[2], 3.0 * c[3]];
        let mut powers = [0.0; 6];
        for (i, r) in c.iter().enumerate() {
            for (j, r1) in d.iter().enumerate() {
                powers[i + j] += r.dot(*r1);
            }
        }
        let (start, end) = (c[0], cubic.at(1.0));
        let chord = end - start;
        let inverse = if chord == DVec3::ZERO { 0.0 } else { 1.0 / chord.length_squared() };
        // ‖R(s) − chord(s)‖ ≤ max ‖R″‖ / 8, and R″ is linear in s; a little more for rounding.
        let bend = (2.0 * c[2]).length().max((2.0 * c[2] + 6.0 * c[3]).length());
        let stray = bend / 8.0 * (1.0 + 1e-9) + 1e-14 * (start.length() + end.length());
        Self {
            span: span as u32,
            t0,
            width,
            a: quintic::from_powers(&powers),
            b: quintic::from_powers(&d),
            powers,
            before: None,
            last: false,
            closes: 0.0,
            rests: false,
            chord: (start, chord, inverse),
            stray,
            cubic,
        }
    }

    /// Segment and place in it at `s`; where a closed curve closes, its start: of two parameters the smaller.
    #[inline(always)]
    pub(crate) fn place(&self, s: f64) -> (u32, f64) {
        if self.rests || s > 1.0 - self.closes { (0, 0.0) } else { (self.span, self.t0 + self.width * s) }
    }

    /// A closed curve comes back to its start here.
    pub(crate) fn close(&mut self) {
        self.closes = if self.cubic.tangent(1.0) == DVec3::ZERO { CLOSED_STILL } else { CLOSED };
        self.rests = self.is_point();
    }

    /// Whether the piece is a single point.
    fn is_point(&self) -> bool {
        self.cubic.0[1..] == [DVec3::ZERO; 3]
    }

    pub(crate) fn outermost(&self) -> f64 {
        self.chord.0.length().max((self.chord.0 + self.chord.1).length()) + self.stray
    }

    /// A ball about the piece, relative to the curve's origin.
    pub(crate) fn ball(&self) -> (DVec3, f64) {
        let (start, chord, _) = self.chord;
        (start + 0.5 * chord, 0.5 * chord.length() + self.stray)
    }

    /// Whether no point of the piece lies ahead of `p` in the direction `v`.
    #[inline(always)]
    pub(crate) fn lies_behind(&self, p: DVec3, v: DVec3) -> bool {
        let (start, chord, _) = self.chord;
        let ahead = (start - p).dot(v);
        // The stray is an upper bound already, widened for rounding.
        ahead.max(ahead + chord.dot(v)) + self.stray * v.length() <= 0.0
    }

    #[inline(always)]
    pub(crate) fn chord_distance(&self, p: DVec3) -> f64 {
        let (start, chord, inverse) = self.chord;
        let w = p - start;
        let h = (w.dot(chord) * inverse).clamp(0.0, 1.0);
        (w - h * chord).length()
    }

    #[inline(always)]
    pub(crate) fn coefficients(&self, p: DVec3) -> Bernstein {
        std::array::from_fn(|k| self.a[k] - p.dot(self.b[k]))
    }

    /// What the block's points have on this piece; nothing where it lies beyond their `reach`.
    #[inline(always)]
    pub(crate) fn mark<S: Simd>(&self, simd: S, block: &Block, reach: &Row, marks: &mut Row) {
        let (zero, one) = (Doubles::splat(simd, 0.0), Doubles::splat(simd, 1.0));
        let (before_a, before_b) = self.before.unwrap_or((-1.0, DVec3::ZERO));
        let ends = if self.last { END } else { 0.0 };
        let stray = Doubles::splat(simd, self.stray);
        for (i, mark) in Doubles::<S>::vectors_mut(marks).iter_mut().enumerate() {
            *mark = zero.1;
            let p = block.vectors(simd, i);
            let bound = (Doubles(simd, Doubles::<S>::vectors(reach)[i]) + stray)
                * Doubles::splat(simd, 1.0 + ROUNDING);
            let near = self.chord_squares(p).at_most(bound * bound);
            if simd.first_true_m64s(near.1) >= S::F64_LANES {
                continue;
            }
            let first = Doubles::splat(simd, self.a[0]) - Doubles::dot(p, self.b[0]);
            let starts_below = first.less(zero);
            let mut below = starts_below;
            let mut changes = zero;
            for k in 1..6 {
                let c = Doubles::splat(simd, self.a[k]) - Doubles::dot(p, self.b[k]);
                let next = c.less(zero);
                changes = changes + ((below & !next) | (next & !below)).number(1.0);
                below = next;
            }
            let single = starts_below & !below & changes.at_most(one);
            let left = Doubles::splat(simd, before_a) - Doubles::dot(p, before_b);
            let begins = left.less(zero) & !starts_below;
            let found = begins.number(START)
                + below.number(ends)
                + single.number(SINGLE)
                + one.less(changes).number(SEVERAL);
            *mark = near.select(found, zero).1;
        }
    }

    /// Squared distances of points from the chord.
    #[inline(always)]
    fn chord_squares<S: Simd>(&self, p: [Doubles<S>; 3]) -> Doubles<S> {
        let simd = p[0].0;
        let (start, chord, inverse) = self.chord;
        let (zero, one) = (Doubles::splat(simd, 0.0), Doubles::splat(simd, 1.0));
        let wx = p[0] - Doubles::splat(simd, start.x);
        let wy = p[1] - Doubles::splat(simd, start.y);
        let wz = p[2] - Doubles::splat(simd, start.z);
        let h = Doubles::dot([wx, wy, wz], chord) * Doubles::splat(simd, inverse);
        let h = h.less(zero).select(zero, h);
        let h = one.less(h).select(one, h);
        let x = wx - h * Doubles::splat(simd, chord.x);
        let y = wy - h * Doubles::splat(simd, chord.y);
        let z = wz - h * Doubles::splat(simd, chord.z);
        x * x + y * y + z * z
    }

    /// Feet of a point whose mark is more than a single one.
    pub(crate) fn offer_marked(&self, lane: usize, mark: f64, block: &Block, feet: &mut Feet) {
        let mark = mark as u8;
        let has = |what: f64| mark & what as u8 != 0;
        if has(START) {
            feet.offer(lane, self, block, 0.0);
        }
        if has(SEVERAL) || has(SINGLE) {
            quintic::rising_roots(&self.coefficients(block.at(lane)), &mut |s| {
                feet.offer(lane, self, block, s);
            });
        }
        if has(END) {
            feet.offer(lane, self, block, 1.0);
        }
    }

    /// Newton's method on all `lanes` at once, each of which has exactly one foot on this piece.
    #[inline(always)]
    pub(crate) fn settle<S: Simd>(&self, simd: S, block: &Block, lanes: &[u8], feet: &mut Feet) {
        const ZERO: Row = [0.0; BLOCK];
        if lanes.is_empty() {
            return;
        }
        let (mut p, mut s, mut step) = ([ZERO; 3], ZERO, ZERO);
        for (i, &lane) in lanes.iter().enumerate().take(BLOCK) {
            let lane = lane as usize & (BLOCK - 1);
            (p[0][i], p[1][i], p[2][i]) = (block.x[lane], block.y[lane], block.z[lane]);
        }
        for i in 0..lanes.len().div_ceil(S::F64_LANES) {
            let x = Doubles(simd, Doubles::<S>::vectors(&p[0])[i]);
            let y = Doubles(simd, Doubles::<S>::vectors(&p[1])[i]);
            let z = Doubles(simd, Doubles::<S>::vectors(&p[2])[i]);
            let (place, change) = self.newton([x, y, z]);
            Doubles::<S>::vectors_mut(&mut s)[i] = place.1;
            Doubles::<S>::vectors_mut(&mut step)[i] = change.1;
        }
        for (i, &lane) in lanes.iter().enumerate().take(BLOCK) {
            let lane = lane as usize & (BLOCK - 1);
            let settled = step[i] < SETTLED;
            let s = if settled { s[i] } else { quintic::single_root(&self.coefficients(block.at(lane))) };
            feet.offer(lane, self, block, s);
        }
    }

    /// Steps towards the only root of `g` for each of some points: the place, and the last step.
    #[inline(always)]
    fn newton<S: Simd>(&self, p: [Doubles<S>; 3]) -> (Doubles<S>, Doubles<S>) {
        let simd = p[0].0;
        let c = &self.cubic.0;
        let g0 = Doubles::splat(simd, self.powers[0]) - Doubles::dot(p, c[1]);
        let g1 = Doubles::splat(simd, self.powers[1]) - Doubles::dot(p, 2.0 * c[2]);
        let g2 = Doubles::splat(simd, self.powers[2]) - Doubles::dot(p, 3.0 * c[3]);
        let g3 = Doubles::splat(simd, self.powers[3]);
        let g4 = Doubles::splat(simd, self.powers[4]);
        let g5 = Doubles::splat(simd, self.powers[5]);
        let (h2, h3) = (g2 + g2, g3 * Doubles::splat(simd, 3.0));
        let (h4, h5) = (g4 * Doubles::splat(simd, 4.0), g5 * Doubles::splat(simd, 5.0));
        let end = Doubles::splat(simd, self.a[5]) - Doubles::dot(p, self.b[5]);
        let (zero, one) = (Doubles::splat(simd, 0.0), Doubles::splat(simd, 1.0));
        let settled = Doubles::splat(simd, SETTLED);
        let mut x = g0 / (g0 - end);
        let mut change = one;
        for _ in 0..STEPS {
            let value = g0 + x * (g1 + x * (g2 + x * (g3 + x * (g4 + x * g5))));
            let slope = g1 + x * (h2 + x * (h3 + x * (h4 + x * h5)));
            let step = value / slope;
            let moved = x - step;
            let moved = moved.less(zero).select(zero, moved);
            let moved = one.less(moved).select(one, moved);
            let size = step.less(zero).select(-step, step);
            // A lane that has settled stays, however many steps its neighbours take: every width gives the same bits.
            let goes_on = settled.at_most(change);
            x = goes_on.select(moved, x);
            change = goes_on.select(zero.less(slope).select(size, one), change);
            if simd.first_true_m64s(settled.at_most(change).1) >= S::F64_LANES {
                break;
            }
        }
        (x, change)
    }
}

/// How many pieces keep each one's turning small.
pub(crate) fn piece_count(cubic: &Cubic) -> usize {
    let c = &cubic.0;
    if c[2] == DVec3::ZERO && c[3] == DVec3::ZERO {
        return 1;
    }
    // Control points of R′.
    let d = [c[1], c[1] + c[2], c[1] + 2.0 * c[2] + 3.0 * c[3]];
    let turning: f64 = d.windows(2).map(|w| w[0].angle_between(w[1])).filter(|a| a.is_finite()).sum();
    let turning = if d.contains(&DVec3::ZERO) { turning + 1.0 } else { turning };
    ((turning / TURN).ceil() as usize).clamp(1, MOST_PIECES)
}
