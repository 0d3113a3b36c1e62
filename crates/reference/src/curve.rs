//! Curves: points, derivatives and tangents, each kind by its own definition.
//!
//! Inside the crate a place on a curve is a segment and `t ∈ [0, 1]` in it, `u = (segment + t) / segments`; so
//! the two sides of a joint are two places. Derivatives are by `t`.

use crate::wide;
use glam::DVec3;
use wirework_core::{Curve, CurveKind};

/// `C(u)`, `u ∈ [0, 1]`; beyond that the ends.
pub fn point(curve: &Curve, u: f64) -> [f64; 3] {
    let place = Place::at(curve, u);
    at(curve, place).to_array()
}

/// `C′(u)`, by `u`; at a joint the derivative of the segment that starts there.
pub fn derivative(curve: &Curve, u: f64) -> [f64; 3] {
    let place = Place::at(curve, u);
    (slope(curve, place) * segment_count(curve) as f64).to_array()
}

/// The unit tangent at `u`, or zero: at a joint the normalised mean of both sides.
pub fn tangent(curve: &Curve, u: f64) -> [f64; 3] {
    direction(curve, Place::at(curve, u)).to_array()
}

/// How many segments share the parameter range evenly. A single point counts as one.
pub fn segment_count(curve: &Curve) -> usize {
    let n = curve.points().len();
    let count = match (curve.kind(), curve.closed()) {
        (CurveKind::Bezier, _) => n / 3,
        (_, true) => n,
        (CurveKind::BSpline { .. }, false) => n - degree(curve),
        (CurveKind::Polyline | CurveKind::CatmullRom, false) => n - 1,
    };
    count.max(1)
}

/// A place on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Which segment, from 0.
    pub(crate) segment: usize,
    /// Where in it, 0 to 1.
    pub(crate) t: f64,
}

impl Place {
    /// A `u` this near to a joint, in segments, is the joint: `i / n · n` is not always `i`.
    const JOINT: f64 = 1e-12;

    pub(crate) fn at(curve: &Curve, u: f64) -> Self {
        let last = segment_count(curve) - 1;
        let x = u.clamp(0.0, 1.0) * (last + 1) as f64;
        let x = if (x - x.round()).abs() < Self::JOINT { x.round() } else { x };
        let segment = (x.floor() as usize).min(last);
        Self { segment, t: x - segment as f64 }
    }

    pub(crate) fn u(self, curve: &Curve) -> f64 {
        (self.segment as f64 + self.t) / segment_count(curve) as f64
    }

    /// The segments to the left and the right of the joint at this place; none when it lies inside one. At the end
    /// of an open curve one is missing.
    pub(crate) fn joint(self, curve: &Curve) -> Option<(Option<usize>, Option<usize>)> {
        let n = segment_count(curve);
        let j = match self.t {
            0.0 => self.segment,
            1.0 => self.segment + 1,
            _ => return None,
        };
        let before = if j > 0 { Some(j - 1) } else { curve.closed().then(|| n - 1) };
        let after = if j < n { Some(j) } else { curve.closed().then_some(0) };
        Some((before, after))
    }
}

/// The unit tangent, or zero.
pub(crate) fn direction(curve: &Curve, place: Place) -> DVec3 {
    let unit = |segment, t| one_sided_direction(curve, Place { segment, t });
    match place.joint(curve) {
        None => unit(place.segment, place.t),
        Some((before, after)) => mean_direction(
            before.map_or(DVec3::ZERO, |segment| unit(segment, 1.0)),
            after.map_or(DVec3::ZERO, |segment| unit(segment, 0.0)),
        ),
    }
}

/// A derivative this short beside the segment's largest is zero: float32 control points fold a curve back on itself no
/// more exactly, and a foot on the fold would turn by the last bit of its parameter.
const STANDSTILL: f64 = 1e-6;

/// So is one this short beside the largest coordinate: it is the rounding of float64.
const ROUNDING: f64 = 1e-14;

/// The unit tangent as seen from within the place's segment, or zero.
pub(crate) fn one_sided_direction(curve: &Curve, place: Place) -> DVec3 {
    let here = slope(curve, place);
    let speed = |t| slope(curve, Place { t, ..place }).length();
    let largest = speed(0.0).max(speed(0.5)).max(speed(1.0));
    let extent = curve.points().iter().map(|&p| wide(p).abs().max_element()).fold(0.0, f64::max);
    let nothing = (STANDSTILL * largest).max(ROUNDING * extent);
    if here.length() <= nothing { DVec3::ZERO } else { here.normalize_or_zero() }
}

/// Two unit tangents whose sum is shorter than this cancel: what is left of them is rounding.
const CANCELLED: f64 = 1e-6;

pub(crate) fn mean_direction(left: DVec3, right: DVec3) -> DVec3 {
    let sum = left + right;
    if sum.length() < CANCELLED { DVec3::ZERO } else { sum.normalize() }
}

/// `C` at a place.
pub(crate) fn at(curve: &Curve, place: Place) -> DVec3 {
    evaluate(curve, place).0
}

/// `C′` at a place, by `t`.
pub(crate) fn slope(curve: &Curve, place: Place) -> DVec3 {
    evaluate(curve, place).1
}

/// Point and derivative by `t`.
fn evaluate(curve: &Curve, Place { segment, t }: Place) -> (DVec3, DVec3) {
    let n = curve.points().len();
    let closed = curve.closed();
    let control = |i: usize| wide(curve.points()[if closed { i % n } else { i.min(n - 1) }]);
    match curve.kind() {
        CurveKind::Polyline => line(control(segment), control(segment + 1), t),
        CurveKind::Bezier if n < 3 => (control(0), DVec3::ZERO),
        CurveKind::Bezier => {
            let points: Vec<DVec3> = (0..4).map(|i| control(3 * segment + i)).collect();
            let ends: Vec<DVec3> = points.windows(2).map(|w| 3.0 * (w[1] - w[0])).collect();
            (de_casteljau(points, t), de_casteljau(ends, t))
        }
        CurveKind::BSpline { .. } => {
            let d = degree(curve);
            let points = (0..=d).map(|i| control(segment + i)).collect();
            de_boor(points, &knots(curve, segment), segment as f64 + t)
        }
        CurveKind::CatmullRom => {
            let (b, c) = (control(segment), control(segment + 1));
            let a = if segment > 0 { control(segment - 1) } else { 2.0 * b - c };
            let a = if closed { control(segment + n - 1) } else { a };
            let d = if closed || segment + 2 < n { control(segment + 2) } else { 2.0 * c - b };
            barry_goldman([a, b, c, d], t)
        }
    }
}

fn line(a: DVec3, b: DVec3, t: f64) -> (DVec3, DVec3) {
    (mix(a, b, t), b - a)
}

/// Written so that both ends come out exactly.
fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a * (1.0 - t) + b * t
}

fn de_casteljau(mut points: Vec<DVec3>, t: f64) -> DVec3 {
    while points.len() > 1 {
        points = points.windows(2).map(|w| mix(w[0], w[1], t)).collect();
    }
    points[0]
}

/// The degree in effect: no more than the points allow.
fn degree(curve: &Curve) -> usize {
    match curve.kind() {
        CurveKind::BSpline { degree } => usize::from(degree).min(curve.points().len() - 1),
        _ => 1,
    }
}

/// The `2 d` knots that the points of a segment see. Knots count segments: `x = segment + t`. Open: `0` and the
/// number of segments `d + 1` times each (clamped), the whole numbers between them once. Closed: all whole numbers.
fn knots(curve: &Curve, segment: usize) -> Vec<f64> {
    let d = degree(curve);
    let end = segment_count(curve) as f64;
    let knot = |i: f64| if curve.closed() { i } else { i.clamp(0.0, end) };
    (1..=2 * d).map(|i| knot((segment + i) as f64 - d as f64)).collect()
}

/// De Boor's recursion: `d + 1` points and the `2 d` knots around `x`. The derivative is the spline of degree
/// `d − 1` over the differences of the points.
fn de_boor(points: Vec<DVec3>, knots: &[f64], x: f64) -> (DVec3, DVec3) {
    let d = points.len() - 1;
    if d == 0 {
        return (points[0], DVec3::ZERO);
    }
    let differences =
        (0..d).map(|i| d as f64 * (points[i + 1] - points[i]) / (knots[i + d] - knots[i])).collect();
    (de_boor_point(points, knots, x), de_boor_point(differences, &knots[1..2 * d - 1], x))
}

fn de_boor_point(mut points: Vec<DVec3>, knots: &[f64], x: f64) -> DVec3 {
    let d = points.len() - 1;
    for round in 1..=d {
        points = (0..=d - round)
            .map(|i| {
                let (low, high) = (knots[i + round - 1], knots[i + d]);
                mix(points[i], points[i + 1], (x - low) / (high - low))
            })
            .collect();
    }
    points[0]
}

/// Centripetal Catmull-Rom from the second to the third of four points: the pyramid of Barry and Goldman 1988,
/// knots apart by the square root of the points' distance. Where two neighbours coincide their knots do, and what
/// is interpolated between them is that one point, which is the limit as they approach; where these are the
/// middle two the whole segment is that point.
fn barry_goldman(p: [DVec3; 4], t: f64) -> (DVec3, DVec3) {
    if p[1] == p[2] {
        return (p[1], DVec3::ZERO);
    }
    let mut knot = [0.0; 4];
    for i in 1..4 {
        knot[i] = knot[i - 1] + p[i].distance(p[i - 1]).sqrt();
    }
    let span = knot[2] - knot[1];
    let x = knot[1] * (1.0 - t) + knot[2] * t;
    // Values and derivatives by x.
    let mut row: Vec<(DVec3, DVec3)> = p.iter().map(|&p| (p, DVec3::ZERO)).collect();
    for width in 1..4 {
        row = (0..row.len() - 1)
            .map(|i| {
                // The last round spans the middle interval, the one before it two, the first one.
                let (low, high) = match width {
                    1 => (knot[i], knot[i + 1]),
                    2 => (knot[i], knot[i + 2]),
                    _ => (knot[1], knot[2]),
                };
                let (a, b) = (row[i], row[i + 1]);
                if high == low {
                    return (a.0, DVec3::ZERO);
                }
                let s = (x - low) / (high - low);
                (mix(a.0, b.0, s), mix(a.1, b.1, s) + (b.0 - a.0) / (high - low))
            })
            .collect();
    }
    (row[0].0, row[0].1 * span)
}
