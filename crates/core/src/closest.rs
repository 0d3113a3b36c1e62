//! The exact closest point of a curve, [SF98] §2: `p_R` minimises `‖P − R(u)‖` over the whole curve; of equally near
//! feet the smallest `u`.
//!
//! Each segment is cut into pieces of little turning. The feet on a piece are rising roots of
//! `g(s) = (R(s) − P)·R′(s)`, whose Bernstein coefficients are `aₖ − P·bₖ` with `aₖ, bₖ` known beforehand: six dot
//! products a point and piece. No sign change, no foot; one, exactly one, found by Newton's method on 64 points side
//! by side; more, isolated by [`quintic`](crate::quintic). A joint of two pieces is a foot where `g` passes there from
//! negative to positive. So no foot is missed, whatever the cut; the cut only keeps the slow road rare.
//!
//! # Notes
//!
//! Only local minima are compared, never samples: of feet whose distances differ by less than [`TIE`] the first is
//! kept, and a tolerance on the distance of a sample would move the foot by the tolerance's square root.
//!
//! Pieces are tried nearest first, so that the best distance soon keeps off the others; tried along the curve, points at
//! some distance from it saw half of its pieces, and binding took twice as long.

use glam::DVec3;
use pulp::Simd;

use crate::quintic::{self, Bernstein};
use crate::simd::Doubles;
use crate::spans::{Cubic, Spans, to_array, to_dvec3};
use crate::tiles::{Ball, Tile};
use crate::{Curve, curve};

/// Two feet tie when their distances differ by less than this part of the largest coordinate: rounding the input to
/// float32 moves distances by as much, so a curve that is symmetric as written may not be so as stored.
pub(crate) const TIE: f64 = 2.4e-7;

/// Points that are searched side by side.
pub(crate) const BLOCK: usize = 64;

/// A piece turns by at most about this (radians), so that a point nearer than twice the piece's radius of curvature
/// rarely sees more than one sign change.
const TURN: f64 = 0.5;

/// More pieces a segment than this cost more in culling than they save in isolation.
const MOST_PIECES: usize = 8;

/// Newton steps done on all lanes of a block; a lane that has not settled by then takes the bracketed road.
const STEPS: usize = 6;

/// A lane has settled when its last step was below this: the next would be below its square.
const SETTLED: f64 = 1e-8;

/// The closest point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// `p_R`, 0 to 1.
    pub u: f32,
    /// `‖P − R(p_R)‖`.
    pub distance: f32,
    /// `R(p_R)`.
    pub point: [f32; 3],
}

impl Curve {
    /// The point of the curve closest to `point`; of equally near ones the one with the smallest `u`.
    ///
    /// `None` where a coordinate of `point` is NaN or infinite.
    pub fn closest(&self, point: [f32; 3]) -> Option<Foot> {
        curve::check_finite(&[point]).ok()?;
        let spans = Spans::new(self);
        let pieces = Pieces::new(&spans);
        let mut block = Block::new();
        block.push(to_dvec3(point), &pieces);
        let mut feet = Feet::new();
        pieces.search(pulp::Scalar, &block, &pieces.all(), f64::INFINITY, &mut feet);
        let (span, t) = (feet.span[0] as usize, feet.t[0]);
        let u = (span as f64 + t) / spans.cubics.len() as f64;
        let point = to_array(spans.cubics[span].at(t));
        Some(Foot { u: u as f32, distance: feet.distance[0] as f32, point })
    }
}

/// A curve prepared for closest points.
#[derive(Clone, Debug)]
pub(crate) struct Pieces {
    pub(crate) list: Vec<Piece>,
    /// Everything is relative to this, so that a curve far from the origin loses nothing.
    origin: DVec3,
    /// A ball about the curve.
    pub(crate) ball: Ball,
    /// The largest coordinate, which scales [`TIE`].
    reach: f64,
}

/// A stretch of one segment, `s ∈ [0, 1]`.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    span: u32,
    t0: f64,
    width: f64,
    cubic: Cubic,
    /// Powers of `R·R′`; those of `P·R′` are taken from the cubic.
    powers: [f64; 6],
    /// `g` in the Bernstein basis is `a − P·b`.
    a: Bernstein,
    b: [DVec3; 6],
    /// The last row of the piece before, where there is one.
    before: Option<(f64, DVec3)>,
    /// Whether the curve ends here.
    last: bool,
    /// The chord's start, direction and inverse squared length, and how far the piece strays from it.
    chord: (DVec3, DVec3, f64),
    stray: f64,
}

impl Pieces {
    pub(crate) fn new(spans: &Spans) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for cubic in &spans.cubics {
            for p in [cubic.at(0.0), cubic.at(1.0)] {
                (low, high) = (low.min(p), high.max(p));
            }
        }
        let origin = 0.5 * (low + high);
        let mut list = Vec::new();
        for (span, cubic) in spans.cubics.iter().enumerate() {
            let count = piece_count(cubic);
            for i in 0..count {
                let (t0, t1) = (i as f64 / count as f64, (i + 1) as f64 / count as f64);
                list.push(Piece::new(span, t0, t1 - t0, cubic.part(t0, t1), origin));
            }
        }
        let rows: Vec<(f64, DVec3)> = list.iter().map(|p| (p.a[5], p.b[5])).collect();
        let count = list.len();
        for (i, piece) in list.iter_mut().enumerate() {
            piece.before = match i {
                0 if !spans.closed => None,
                0 => Some(rows[count - 1]),
                _ => Some(rows[i - 1]),
            };
            piece.last = i + 1 == count && !spans.closed;
        }
        let radius = list.iter().map(Piece::outermost).fold(0.0, f64::max);
        Self { list, origin, ball: Ball { center: origin, radius }, reach: low.abs().max(high.abs()).max_element() }
    }

    /// The pieces of `among` that may hold the closest point, within `reach`, of a point in the ball, each with a lower
    /// bound of its distance from such a point; nearest first.
    pub(crate) fn cull(&self, ball: Ball, reach: f64, among: &[Candidate], out: &mut Vec<Candidate>) {
        out.clear();
        let (center, radius) = (ball.center - self.origin, ball.radius);
        let mut bound = reach;
        for candidate in among {
            let piece = &self.list[candidate.piece as usize];
            let distance = piece.chord_distance(center);
            // Each point of the chord has a point of the curve within the stray, and each point of the ball its centre
            // within the radius.
            bound = bound.min((distance + piece.stray + radius) * (1.0 + ROUNDING));
            let lower = (distance - piece.stray - radius) * (1.0 - ROUNDING);
            out.push(Candidate { lower, piece: candidate.piece });
        }
        out.retain(|c| c.lower <= bound);
        out.sort_unstable_by(|a, b| a.lower.total_cmp(&b.lower).then(a.piece.cmp(&b.piece)));
    }

    /// All pieces as candidates.
    pub(crate) fn all(&self) -> Vec<Candidate> {
        (0..self.list.len() as u32).map(|piece| Candidate { lower: 0.0, piece }).collect()
    }

    /// The closest feet of a block's points on the pieces `candidates`, nearest first; points farther than `reach`
    /// may get a worse foot or none.
    #[inline(always)]
    pub(crate) fn search<S: Simd>(
        &self,
        simd: S,
        block: &Block,
        candidates: &[Candidate],
        reach: f64,
        feet: &mut Feet,
    ) {
        feet.distance = [f64::INFINITY; BLOCK];
        feet.reach = [reach; BLOCK];
        let mut marks = [0.0; BLOCK];
        let mut lanes = [0_u8; BLOCK];
        for candidate in candidates {
            if !feet.within(candidate.lower, block.count) {
                break;
            }
            let piece = &self.list[candidate.piece as usize];
            piece.mark(simd, block, &feet.reach, &mut marks);
            let mut count = 0;
            for (lane, &mark) in marks.iter().enumerate().take(block.count) {
                if mark == SINGLE {
                    lanes[count & (BLOCK - 1)] = lane as u8;
                    count += 1;
                } else if mark != 0.0 {
                    piece.offer_marked(lane, mark, block, feet);
                }
            }
            piece.settle(simd, block, &lanes[..count], feet);
        }
    }
}

/// A piece that may hold the closest point of some points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// None of the points is nearer to the piece than this.
    lower: f64,
    piece: u32,
}

/// Bounds of distances are widened by this part, more than they can be wrong by rounding.
const ROUNDING: f64 = 1e-9;

/// One number a point of a block.
type Row = [f64; BLOCK];

// What a point has on a piece; a mark is a sum of these, kept as a number among numbers.
/// The piece's start is a foot.
const START: f64 = 1.0;
/// The curve's end is a foot.
const END: f64 = 2.0;
/// Exactly one foot lies inside.
const SINGLE: f64 = 4.0;
/// Several sign changes: feet are to be isolated.
const SEVERAL: f64 = 8.0;

impl Piece {
    fn new(span: usize, t0: f64, width: f64, mut cubic: Cubic, origin: DVec3) -> Self {
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
            chord: (start, chord, inverse),
            stray,
            cubic,
        }
    }

    fn outermost(&self) -> f64 {
        self.chord.0.length().max((self.chord.0 + self.chord.1).length()) + self.stray
    }

    #[inline(always)]
    fn chord_distance(&self, p: DVec3) -> f64 {
        let (start, chord, inverse) = self.chord;
        let w = p - start;
        let h = (w.dot(chord) * inverse).clamp(0.0, 1.0);
        (w - h * chord).length()
    }

    #[inline(always)]
    fn coefficients(&self, p: DVec3) -> Bernstein {
        std::array::from_fn(|k| self.a[k] - p.dot(self.b[k]))
    }

    /// What the block's points have on this piece; nothing where it lies beyond their `reach`.
    #[inline(always)]
    fn mark<S: Simd>(&self, simd: S, block: &Block, reach: &Row, marks: &mut Row) {
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
    fn offer_marked(&self, lane: usize, mark: f64, block: &Block, feet: &mut Feet) {
        let mark = mark as u8;
        let has = |what: f64| mark & what as u8 != 0;
        if has(START) {
            feet.offer(lane, self, block, 0.0);
        }
        if has(SEVERAL) || has(SINGLE) {
            quintic::rising_roots(&self.coefficients(block.at(lane)), &mut |s| feet.offer(lane, self, block, s));
        }
        if has(END) {
            feet.offer(lane, self, block, 1.0);
        }
    }

    /// Newton's method on all `lanes` at once, each of which has exactly one foot on this piece.
    #[inline(always)]
    fn settle<S: Simd>(&self, simd: S, block: &Block, lanes: &[u8], feet: &mut Feet) {
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
            change = value / slope;
            let moved = x - change;
            let moved = moved.less(zero).select(zero, moved);
            x = one.less(moved).select(one, moved);
            let size = change.less(zero).select(-change, change);
            change = zero.less(slope).select(size, one);
            if simd.first_true_m64s(settled.at_most(change).1) >= S::F64_LANES {
                break;
            }
        }
        (x, change)
    }
}

/// How many pieces keep each one's turning small.
fn piece_count(cubic: &Cubic) -> usize {
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

/// Up to [`BLOCK`] points, as coordinates side by side, relative to the curve's origin.
pub(crate) struct Block {
    x: [f64; BLOCK],
    y: [f64; BLOCK],
    z: [f64; BLOCK],
    /// [`TIE`] in units of length.
    tie: [f64; BLOCK],
    count: usize,
}

impl Block {
    pub(crate) fn new() -> Self {
        let zero = [0.0; BLOCK];
        Self { x: zero, y: zero, z: zero, tie: zero, count: 0 }
    }

    /// Takes `count` points of a tile, from `start` on.
    #[inline(always)]
    pub(crate) fn fill(&mut self, tile: &Tile, start: usize, count: usize, pieces: &Pieces) {
        self.count = count;
        let end = start + count;
        let rows = tile.x[start..end].iter().zip(&tile.y[start..end]).zip(&tile.z[start..end]);
        let origin = pieces.origin;
        for (i, ((&x, &y), &z)) in rows.enumerate().take(BLOCK) {
            let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
            (self.x[i], self.y[i], self.z[i]) = (x - origin.x, y - origin.y, z - origin.z);
            let largest = x.abs().max(y.abs()).max(z.abs());
            self.tie[i] = TIE * largest.max(pieces.reach);
        }
    }

    /// Adds a point; at most [`BLOCK`] of them.
    #[inline(always)]
    fn push(&mut self, p: DVec3, pieces: &Pieces) {
        let i = self.count & (BLOCK - 1);
        let q = p - pieces.origin;
        (self.x[i], self.y[i], self.z[i]) = (q.x, q.y, q.z);
        self.tie[i] = TIE * p.abs().max_element().max(pieces.reach);
        self.count += 1;
    }

    #[inline(always)]
    fn vectors<S: Simd>(&self, simd: S, i: usize) -> [Doubles<S>; 3] {
        [
            Doubles(simd, Doubles::<S>::vectors(&self.x)[i]),
            Doubles(simd, Doubles::<S>::vectors(&self.y)[i]),
            Doubles(simd, Doubles::<S>::vectors(&self.z)[i]),
        ]
    }

    #[inline(always)]
    fn at(&self, lane: usize) -> DVec3 {
        let lane = lane & (BLOCK - 1);
        DVec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

/// The best feet so far of a block's points.
pub(crate) struct Feet {
    pub(crate) distance: Row,
    pub(crate) t: Row,
    pub(crate) span: [u32; BLOCK],
    /// Farther feet are no use: the best distance and a tie, or how far feet are sought.
    reach: Row,
}

impl Feet {
    pub(crate) fn new() -> Self {
        let zero = [0.0; BLOCK];
        Self { distance: [f64::INFINITY; BLOCK], t: zero, span: [0; BLOCK], reach: zero }
    }

    /// Whether a foot at `distance` would be of use to any point.
    #[inline(always)]
    fn within(&self, distance: f64, count: usize) -> bool {
        self.reach.iter().take(count).any(|r| distance <= *r)
    }

    /// Takes the foot at `s` if it is nearer than the best by more than a tie, or ties with it at a smaller parameter.
    #[inline(always)]
    fn offer(&mut self, lane: usize, piece: &Piece, block: &Block, s: f64) {
        let lane = lane & (BLOCK - 1);
        let distance = piece.cubic.at(s).distance(block.at(lane));
        let (best, tie) = (self.distance[lane], block.tie[lane]);
        let t = piece.t0 + piece.width * s;
        let earlier = (piece.span, t) < (self.span[lane], self.t[lane]);
        if distance < best - tie || (distance <= best + tie && (earlier || best == f64::INFINITY)) {
            (self.distance[lane], self.span[lane], self.t[lane]) = (distance, piece.span, t);
            let useful = distance + tie;
            self.reach[lane] = if useful < self.reach[lane] { useful } else { self.reach[lane] };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CurveKind;
    use proptest::prelude::*;

    fn brute(spans: &Spans, p: DVec3) -> (f64, f64) {
        const SAMPLES: usize = 4000;
        let n = SAMPLES * spans.cubics.len();
        let best = (0..=n)
            .map(|i| i as f64 / n as f64)
            .min_by(|a, b| spans.at(*a).distance(p).total_cmp(&spans.at(*b).distance(p)))
            .unwrap();
        (best, spans.at(best).distance(p))
    }

    fn point() -> impl Strategy<Value = [f32; 3]> {
        // A coarse lattice: coincident and collinear points, ties, points on the curve.
        prop::array::uniform3(prop_oneof![
            (-4_i32..=4).prop_map(|i| i as f32 * 0.5),
            (-1000_i32..=1000).prop_map(|i| i as f32 * 0.002)
        ])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn no_sample_is_nearer(points in prop::collection::vec(point(), 1..9), kind in 0..6, p in point()) {
            let (kind, closed) = match kind {
                0 => (CurveKind::BSpline { degree: 2 }, false),
                1 => (CurveKind::BSpline { degree: 3 }, false),
                2 => (CurveKind::BSpline { degree: 3 }, true),
                3 => (CurveKind::Polyline, true),
                4 => (CurveKind::CatmullRom, false),
                _ => (CurveKind::CatmullRom, true),
            };
            let curve = Curve::new(kind, closed, points).unwrap();
            let spans = Spans::new(&curve);
            let foot = curve.closest(p).unwrap();
            let (u, distance) = brute(&spans, to_dvec3(p));
            prop_assert!(f64::from(foot.distance) <= distance + 1e-6, "{foot:?} but {distance} at {u}");
            let own = spans.at(f64::from(foot.u)).distance(to_dvec3(p));
            prop_assert!((own - f64::from(foot.distance)).abs() < 1e-5, "{foot:?} is not on the curve: {own}");
        }
    }

    #[test]
    fn equally_near_feet_give_the_smallest_parameter() {
        // Not symmetric in float32, though it is as written.
        let curve = Curve::polyline(vec![[0.1, 1.0, 0.0], [0.1, 0.3, 0.0], [0.7, 0.3, 0.0], [0.7, 1.0, 0.0]]);
        let foot = curve.unwrap().closest([0.4, 0.9, 0.0]).unwrap();
        assert!(foot.u < 1.0 / 3.0, "{foot:?}");
        let square = vec![[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]];
        let square = Curve::new(CurveKind::Polyline, true, square).unwrap();
        assert_eq!(square.closest([0.0; 3]).unwrap().u, 0.125);
        assert_eq!(square.closest([2.0, 2.0, 0.0]).unwrap().u, 0.0);
    }

    #[test]
    fn a_tie_does_not_move_the_foot() {
        let curve = Curve::bspline(3, vec![[-1.0, 0.0, 0.0], [-0.3, 0.2, 0.0], [0.3, 0.2, 0.0], [1.0, 0.0, 0.0]]);
        let foot = curve.unwrap().closest([0.0, 5.0, 0.0]).unwrap();
        assert!((foot.u - 0.5).abs() < 1e-6, "{foot:?}");
    }

    #[test]
    fn points_that_are_nowhere_have_no_foot() {
        let curve = Curve::polyline(vec![[0.0; 3]]).unwrap();
        assert_eq!(curve.closest([f32::NAN, 0.0, 0.0]), None);
        assert_eq!(curve.closest([3.0, 4.0, 0.0]).unwrap().distance, 5.0);
    }
}
