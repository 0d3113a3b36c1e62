//! \[SF98\] §2, `p_R`: the parameter of the point of a curve closest to a point, the smallest on a tie.
//!
//! `(C − P)·C′` is sampled densely in each segment; wherever it turns from falling to rising a local minimum is
//! bisected; a joint is one too where the distance falls towards it from both sides. The least of all is the foot.

use crate::curve::{Place, at, segment_count, slope};
use crate::wide;
use glam::DVec3;
use wirework_core::Curve;

/// Two local minima tie when their distances differ by less than this part of the largest absolute coordinate
/// among the curve's control points and the point: twice the spacing of float32 (2⁻²³), which is what storing the
/// input moves a distance by. Only minima tie: within a tolerance on the distance the parameter is free to its
/// square root, so a neighbour of the foot must not stand in for it.
pub const TIE: f64 = 2.4e-7;

/// Other minima nearer than this part of the same coordinate make a foot ambiguous.
const CLOSE: f64 = 1e-5;

/// Minima nearer than this in parameter, in segments, are one.
const APART: f64 = 1e-3;

/// The point of a curve closest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// `p_R ∈ [0, 1]`.
    pub u: f64,
    /// `‖P − R(p_R)‖`.
    pub distance: f64,
    /// `R(p_R)`.
    pub point: [f64; 3],
    /// Whether another local minimum, at another place, is less than 1e-5 of the largest absolute coordinate
    /// farther (or ties).
    pub ambiguous: bool,
    /// How sharp the minimum is: half the second derivative of the squared distance over `‖R′‖²`, 1 along a straight
    /// line, 0 on the evolute. 1 at a joint where the distance turns sharply.
    pub sharpness: f64,
    pub(crate) place: Place,
}

/// The foot of `p` on `curve`; for a point that is not finite the curve's start, at an infinite distance.
pub fn closest(curve: &Curve, p: [f64; 3]) -> Foot {
    Samples::new(curve).closest(DVec3::from_array(p))
}

/// Cells of even size a segment is cut into to find the minima.
const EVEN: usize = 128;

/// The cells at both ends of a segment are halved this often again, outwards: where a curve starts from standstill it
/// turns within a small part of a cell.
const FINER: usize = 16;

/// Cells a segment is cut into.
const CELLS: usize = EVEN + 2 * FINER;

/// Where the `i`-th edge of the cells lies, 0 to 1.
fn edge(i: usize) -> f64 {
    let width = 1.0 / EVEN as f64;
    let near_end = |i: usize| if i == 0 { 0.0 } else { width / (1_u64 << (FINER + 1 - i)) as f64 };
    match i {
        _ if i <= FINER => near_end(i),
        _ if i >= CELLS - FINER => 1.0 - near_end(CELLS - i),
        _ => (i - FINER) as f64 * width,
    }
}

/// A cell halved so often is down to the rounding of `t`.
const HALVINGS: usize = 48;

/// A foot this near to a joint, in segments, is the joint.
const JOINT: f64 = 1e-12;

/// A curve sampled once for many points.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    pub(crate) curve: Curve,
    /// Of each segment, point and derivative at the `CELLS + 1` edges of its cells.
    edges: Vec<Vec<(DVec3, DVec3)>>,
    /// The largest absolute coordinate of the control points.
    extent: f64,
}

impl Samples {
    pub(crate) fn new(curve: &Curve) -> Self {
        let sample = |segment, i: usize| {
            let place = Place { segment, t: edge(i) };
            (at(curve, place), slope(curve, place))
        };
        let edges = (0..segment_count(curve))
            .map(|segment| (0..=CELLS).map(|i| sample(segment, i)).collect())
            .collect();
        let extent = curve.points().iter().map(|&p| wide(p).abs().max_element()).fold(0.0, f64::max);
        Self { curve: curve.clone(), edges, extent }
    }

    /// The largest absolute coordinate of the curve and a point: what tolerances are measured in.
    pub(crate) fn extent(&self, p: DVec3) -> f64 {
        self.extent.max(p.abs().max_element())
    }

    pub(crate) fn closest(&self, p: DVec3) -> Foot {
        let curve = &self.curve;
        let start = Place { segment: 0, t: 0.0 };
        if !p.is_finite() {
            let point = at(curve, start).to_array();
            let distance = f64::INFINITY;
            return Foot { u: 0.0, distance, point, ambiguous: false, sharpness: 1.0, place: start };
        }
        let minima = self.minima(p);
        let least = minima.iter().map(|m| m.1).fold(f64::INFINITY, f64::min);
        let extent = self.extent(p);
        let first = minima.iter().find(|m| m.1 <= least + TIE * extent);
        let (place, distance) = first.copied().unwrap_or((start, at(curve, start).distance(p)));
        let n = segment_count(curve) as f64;
        let apart = |other: Place| {
            let away = (other.u(curve) - place.u(curve)).abs();
            let away = if curve.closed() { away.min(1.0 - away) } else { away };
            away * n > APART
        };
        let ambiguous = minima.iter().any(|m| m.1 <= least + CLOSE * extent && apart(m.0));
        Foot { ambiguous, ..self.foot(p, place, distance) }
    }

    /// The foot at a place, taken for the only one.
    pub(crate) fn foot(&self, p: DVec3, place: Place, distance: f64) -> Foot {
        Foot {
            u: place.u(&self.curve),
            distance,
            point: at(&self.curve, place).to_array(),
            ambiguous: false,
            sharpness: self.sharpness(p, place),
            place,
        }
    }

    /// Every local minimum of the distance by rising `u`: place and distance.
    pub(crate) fn minima(&self, p: DVec3) -> Vec<(Place, f64)> {
        let mut minima = self.turns(p, 1.0);
        for segment in 0..self.edges.len() {
            minima.extend(self.joint(p, Place { segment, t: 0.0 }));
        }
        if !self.curve.closed() {
            minima.extend(self.joint(p, Place { segment: self.edges.len() - 1, t: 1.0 }));
        }
        minima.sort_by(|a, b| a.0.u(&self.curve).total_cmp(&b.0.u(&self.curve)));
        minima
    }

    /// Every place where the distance may be greatest on a stretch of the curve, but for the stretch's ends: local
    /// maxima, and all joints.
    pub(crate) fn ridges(&self, p: DVec3) -> Vec<(Place, f64)> {
        let joints = (0..self.edges.len()).map(|segment| {
            let place = Place { segment, t: 0.0 };
            (place, at(&self.curve, place).distance(p))
        });
        self.turns(p, -1.0).into_iter().chain(joints).collect()
    }

    /// Where within a segment the distance, times `sign`, turns from falling to rising.
    fn turns(&self, p: DVec3, sign: f64) -> Vec<(Place, f64)> {
        let mut turns = Vec::new();
        for (segment, edges) in self.edges.iter().enumerate() {
            let rise: Vec<f64> = edges.iter().map(|&(c, slope)| sign * (c - p).dot(slope)).collect();
            for cell in 0..CELLS {
                // A zero at the segment's very end is the joint's business.
                let at_end = cell + 1 == CELLS && rise[CELLS] == 0.0;
                if rise[cell] < 0.0 && rise[cell + 1] >= 0.0 && !at_end {
                    turns.push(self.bisect(p, segment, cell, sign));
                }
            }
        }
        turns
    }

    fn bisect(&self, p: DVec3, segment: usize, cell: usize, sign: f64) -> (Place, f64) {
        let (mut low, mut high) = (edge(cell), edge(cell + 1));
        for _ in 0..HALVINGS {
            let t = 0.5 * (low + high);
            let place = Place { segment, t };
            let falls = sign * (at(&self.curve, place) - p).dot(slope(&self.curve, place)) < 0.0;
            *(if falls { &mut low } else { &mut high }) = t;
        }
        let t = if high > 1.0 - JOINT {
            1.0
        } else if high < JOINT {
            0.0
        } else {
            high
        };
        let place = Place { segment, t };
        (place, at(&self.curve, place).distance(p))
    }

    /// The joint at a place, if the distance does not fall away from it on either side.
    fn joint(&self, p: DVec3, place: Place) -> Option<(Place, f64)> {
        let (before, after) = place.joint(&self.curve)?;
        let here = at(&self.curve, place).distance(p);
        let falls = |segment: usize, end: usize, inside: usize, outwards: f64| {
            let edges = &self.edges[segment];
            let rise = outwards * (edges[end].0 - p).dot(edges[end].1);
            // Where the slope says nothing (a zero tangent, a foot on the joint) the next sample does.
            if rise == 0.0 { edges[inside].0.distance(p) < here } else { rise < 0.0 }
        };
        let left = before.is_some_and(|segment| falls(segment, CELLS, CELLS - 1, -1.0));
        let right = after.is_some_and(|segment| falls(segment, 0, 1, 1.0));
        (!left && !right).then_some((place, here))
    }

    fn sharpness(&self, p: DVec3, place: Place) -> f64 {
        /// Step of the numerical derivative, in segments.
        const STEP: f64 = 1e-5;
        let rise = |t: f64| {
            let place = Place { segment: place.segment, t };
            (at(&self.curve, place) - p).dot(slope(&self.curve, place))
        };
        let speed = slope(&self.curve, place).length_squared();
        let edge_slope = |t: f64| rise(t).abs() > 1e-9 * (speed.sqrt() * self.extent(p));
        if speed == 0.0 || ((place.t == 0.0 || place.t == 1.0) && edge_slope(place.t)) {
            return 1.0;
        }
        let (low, high) = ((place.t - STEP).max(0.0), (place.t + STEP).min(1.0));
        (rise(high) - rise(low)) / (high - low) / speed
    }
}
