//! \[SF98\] §3.2: where bound points stand to a domain curve `D`.
//!
//! For a point `P` with its foot `R(p)` and the foot `D(p_D)` on the domain curve: the radius that the domain sets,
//! `‖R(p) − D(p_D)‖`, and the cosine of the angle at `R(p)` between `D(p_D)` and `P`. Where the cosine is negative the domain says
//! nothing, and for most such points no foot on `D` is sought: the whole of `D` near them lies behind.

use glam::DVec3;
use pulp::Simd;

use crate::Curve;
use crate::block::{BLOCK, Feet};
use crate::closest::{Candidate, Pieces};
use crate::spans::Spans;
use crate::tiles::Ball;

/// A cosine no larger is that of a right angle: the feet are known no better. Without a transition the sign of a rounding would
/// choose between two radii.
const SQUARE: f64 = 1e-9;

/// How a bound point stands to a domain curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// `‖R(p) − D(p_D)‖`, 0 where the domain curve says nothing.
    pub(crate) distance: f64,
    /// `cosangle`.
    cosine: f64,
}

impl Side {
    pub(crate) const BEHIND: Self = Self { distance: 0.0, cosine: -1.0 };

    /// The radius for a wire of radius `r`.
    #[inline]
    pub(crate) fn radius(self, delta: f64, r: f64) -> f64 {
        if self.cosine <= 0.0 {
            r
        } else if self.cosine >= delta {
            self.distance
        } else {
            let x = self.cosine / delta;
            r + (self.distance - r) * (x * x * (3.0 - 2.0 * x))
        }
    }
}

/// A domain curve prepared for closest points.
#[derive(Clone, Debug)]
pub(crate) struct DomainCurve {
    spans: Spans,
    pieces: Pieces,
    all: Vec<Candidate>,
    /// Whether it bounds the influence, and so may make a wire reach farther than its radius.
    extends: bool,
}

/// A bound point and its foot.
#[derive(Clone, Copy)]
pub(crate) struct Footed {
    pub(crate) point: DVec3,
    pub(crate) foot: DVec3,
}

impl DomainCurve {
    pub(crate) fn new(curve: &Curve, extends: bool) -> Self {
        let spans = Spans::new(curve);
        let pieces = Pieces::new(&spans, 0.0);
        let all = pieces.all();
        Self { spans, pieces, all, extends }
    }

    /// How far the wire's influence may come on the side of a point.
    pub(crate) fn reaches(&self, side: Side) -> f64 {
        if self.extends { side.distance } else { 0.0 }
    }

    /// No foot of the wire with these `pieces` is farther from the foot on this curve.
    pub(crate) fn reach(&self, pieces: &Pieces) -> f64 {
        let apart = self.pieces.ball.center.distance(pieces.ball.center);
        if self.extends { apart + self.pieces.ball.radius + pieces.ball.radius } else { 0.0 }
    }

    /// The pieces that may hold the foot of a point in a ball.
    pub(crate) fn near(&self, ball: Ball) -> Vec<Candidate> {
        let mut near = Vec::new();
        self.pieces.cull(ball, f64::INFINITY, &self.all, &mut near);
        near
    }

    /// The same as [`Self::reach`] for points whose feet lie on the pieces `near`, and on `own` of this curve.
    pub(crate) fn reach_near(&self, pieces: &Pieces, near: &[Candidate], own: &[Candidate]) -> f64 {
        if !self.extends {
            return 0.0;
        }
        let own: Vec<Ball> = own.iter().map(|c| self.pieces.ball_of(*c)).collect();
        let far = |ball: Ball| {
            let apart = |own: &Ball| own.center.distance(ball.center) + own.radius + ball.radius;
            own.iter().map(apart).fold(0.0, f64::max)
        };
        near.iter().map(|c| far(pieces.ball_of(*c))).fold(0.0, f64::max)
    }

    /// Where up to [`BLOCK`] points stand, in the same order, whose feet lie on the pieces `among`.
    #[inline(always)]
    pub(crate) fn stand<S: Simd>(
        &self,
        simd: S,
        points: &[Footed],
        among: &[Candidate],
        near: &mut Vec<Candidate>,
        out: &mut Vec<Side>,
    ) {
        let start = out.len();
        out.resize(start + points.len(), Side::BEHIND);
        let Some(ball) = Ball::of(points.iter().map(|p| p.point)) else { return };
        self.pieces.cull(ball, f64::INFINITY, among, near);
        let (mut block, mut feet) = (self.pieces.block(), Feet::new());
        let mut lanes = [0_u8; BLOCK];
        for (i, p) in points.iter().enumerate().take(BLOCK) {
            if !self.pieces.lie_behind(near, p.foot, p.point - p.foot) {
                lanes[block.count & (BLOCK - 1)] = i as u8;
                block.push(p.point);
            }
        }
        if block.count == 0 {
            return;
        }
        self.pieces.search(simd, &block, near, f64::INFINITY, &mut feet);
        for (k, &lane) in lanes.iter().enumerate().take(block.count) {
            let Footed { point, foot } = points[lane as usize];
            let to_domain = self.spans.cubics[feet.span[k] as usize].at(feet.t[k]) - foot;
            let v = point - foot;
            let (distance, length) = (to_domain.length(), v.length());
            let cosine = to_domain.dot(v) / (distance * length);
            if cosine > SQUARE {
                out[start + lane as usize] = Side { distance, cosine };
            }
        }
    }
}
