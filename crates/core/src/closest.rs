//! The exact closest point of a curve, \[SF98\] §2: `p_R` minimises `‖P − R(u)‖` over the whole curve; of equally near
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
//! Only local minima are compared, never samples: of feet whose distances differ by less than [`TIE`](crate::block::TIE) the first is
//! kept, and a tolerance on the distance of a sample would move the foot by the tolerance's square root.
//!
//! Pieces are tried nearest first, so that the best distance soon keeps off the others; tried along the curve, points at
//! some distance from it saw half of its pieces, and binding took twice as long.

use glam::DVec3;
use pulp::Simd;

use crate::block::{BLOCK, Block, Feet, TIE};
use crate::piece::{Piece, ROUNDING, SINGLE, piece_count};
use crate::spans::{Spans, to_array, to_dvec3};
use crate::tiles::Ball;
use crate::{Curve, curve};

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
        let pieces = Pieces::new(&spans, 0.0);
        let mut block = pieces.block();
        block.push(to_dvec3(point));
        let mut feet = Feet::new();
        pieces.search(pulp::Scalar, &block, &pieces.all(), f64::INFINITY, &mut feet);
        let (span, t) = (feet.span[0] as usize, feet.t[0]);
        let u = ((span as f64 + t) / spans.cubics.len() as f64) as f32;
        // Where a closed curve closes, the smallest parameter is 0.
        let u = if spans.closed && u == 1.0 { 0.0 } else { u };
        let point = to_array(spans.cubics[span].at(t));
        Some(Foot { u, distance: feet.distance[0] as f32, point })
    }
}

/// A curve prepared for closest points.
#[derive(Clone, Debug)]
pub(crate) struct Pieces {
    pub(crate) list: Vec<Piece>,
    /// Everything is relative to this, so that a curve far from the origin loses nothing.
    origin: DVec3,
    pub(crate) closed: bool,
    /// A ball about the curve.
    pub(crate) ball: Ball,
    /// The largest coordinate, which scales ties.
    reach: f64,
    /// Feet this much farther than the closest count too.
    pub(crate) width: f64,
}

impl Pieces {
    pub(crate) fn new(spans: &Spans, width: f64) -> Self {
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
        // A curve that is a single point has no way round; it starts and ends there.
        let closed = spans.closed && spans.moves();
        let rows: Vec<(f64, DVec3)> = list.iter().map(|p| (p.a[5], p.b[5])).collect();
        let count = list.len();
        for (i, piece) in list.iter_mut().enumerate() {
            piece.before = match i {
                0 if !closed => None,
                0 => Some(rows[count - 1]),
                _ => Some(rows[i - 1]),
            };
            piece.last = i + 1 == count && !closed;
        }
        for piece in list.iter_mut().rev().take_while(|_| closed) {
            piece.close();
            if !piece.rests {
                break;
            }
        }
        let radius = list.iter().map(Piece::outermost).fold(0.0, f64::max);
        Self {
            list,
            origin,
            closed,
            ball: Ball { center: origin, radius },
            reach: low.abs().max(high.abs()).max_element(),
            width,
        }
    }

    /// A ball about one of the pieces.
    pub(crate) fn ball_of(&self, candidate: Candidate) -> Ball {
        let (center, radius) = self.list[candidate.piece as usize].ball();
        Ball { center: self.origin + center, radius }
    }

    /// Whether none of the pieces `among` has a point ahead of `p` in the direction `v`.
    #[inline(always)]
    pub(crate) fn lie_behind(&self, among: &[Candidate], p: DVec3, v: DVec3) -> bool {
        let p = p - self.origin;
        for candidate in among {
            if !self.list[candidate.piece as usize].lies_behind(p, v) {
                return false;
            }
        }
        true
    }

    /// The pieces of `among` that may hold a foot that counts, within `reach`, of a point in the ball, each with a lower
    /// bound of its distance from such a point; nearest first.
    pub(crate) fn cull(&self, ball: Ball, reach: f64, among: &[Candidate], out: &mut Vec<Candidate>) {
        out.clear();
        let (center, radius) = (ball.center - self.origin, ball.radius);
        // A foot that ties with the closest one may come before it.
        let tie = self.width + TIE * self.reach.max(ball.center.abs().max_element() + radius);
        let mut bound = reach;
        for candidate in among {
            let piece = &self.list[candidate.piece as usize];
            let distance = piece.chord_distance(center);
            // Each point of the chord has a point of the curve within the stray, and each point of the ball its centre
            // within the radius.
            bound = bound.min((distance + piece.stray + radius) * (1.0 + ROUNDING) + tie);
            let lower = (distance - piece.stray - radius) * (1.0 - ROUNDING);
            out.push(Candidate { lower, piece: candidate.piece });
        }
        out.retain(|c| c.lower <= bound);
        out.sort_unstable_by(|a, b| a.lower.total_cmp(&b.lower).then(a.piece.cmp(&b.piece)));
    }

    /// An empty block to be searched here.
    pub(crate) fn block(&self) -> Block {
        Block::new(self.origin, self.reach, self.width)
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
        feet.reset(reach);
        let mut marks = [0.0; BLOCK];
        let mut lanes = [0_u8; BLOCK];
        for candidate in candidates {
            if !feet.within(candidate.lower, block.count) {
                break;
            }
            let piece = &self.list[candidate.piece as usize];
            piece.mark(simd, block, feet.reach(), &mut marks);
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
    fn where_a_closed_curve_closes_the_parameter_is_zero() {
        // Passes through its start once more, halfway.
        let points = vec![[0.0; 3], [0.3, -0.7, 0.0], [-0.7, 0.0, -0.7], [0.7, 0.0, 0.7], [-0.3, 0.7, 0.0]];
        let curve = Curve::new(CurveKind::Polyline, true, points).unwrap();
        assert_eq!(curve.closest([0.0; 3]).unwrap().u, 0.0);
        for i in 0..50_u8 {
            // Symmetric about its start: rounding decides on which side of it the foot is found.
            let a = 0.1 + f32::from(i) * 0.013;
            let points = vec![[a, 0.0, 0.0], [0.0, 0.0, a], [-a, 0.0, 0.0], [0.0, 0.0, -a]];
            let curve = Curve::new(CurveKind::BSpline { degree: 2 }, true, points).unwrap();
            let start = curve.point(0.0);
            assert!(curve.closest(start.map(|c| c * 3.0)).unwrap().u < 1e-6, "{a}");
        }
    }

    #[test]
    fn a_closed_curve_whose_first_point_is_written_again_starts_there() {
        for kind in [CurveKind::Polyline, CurveKind::CatmullRom] {
            let ring = vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [-1.0, 0.0, 0.0]];
            let foot = Curve::new(kind, true, ring).unwrap().closest([-3.0, -1.0, 0.0]).unwrap();
            assert!(foot.u == 0.0 && foot.point == [-1.0, 0.0, 0.0], "{kind:?}: {foot:?}");
        }
    }

    #[test]
    fn a_closed_curve_that_is_a_point_has_feet() {
        let point = Curve::new(CurveKind::Polyline, true, vec![[0.5, 0.5, 0.0]; 3]).unwrap();
        assert_eq!(point.closest([0.5, 3.5, 4.0]).map(|foot| (foot.u, foot.distance)), Some((0.0, 5.0)));
    }

    #[test]
    fn a_tie_does_not_move_the_foot() {
        let curve =
            Curve::bspline(3, vec![[-1.0, 0.0, 0.0], [-0.3, 0.2, 0.0], [0.3, 0.2, 0.0], [1.0, 0.0, 0.0]]);
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
