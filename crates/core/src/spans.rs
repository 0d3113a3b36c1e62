//! A curve as polynomials: one cubic a segment, in float64.
//!
//! Every kind of [`Curve`] becomes the same list of cubics in `t ∈ [0, 1]`, so that closest points, arc lengths and
//! the deformation know only these. All kinds but Catmull-Rom are linear in their control points and are built
//! from differences of neighbours: points that coincide give exact zeros, and so do two equal curves.

use glam::DVec3;

use crate::{Curve, CurveKind};

/// Below this part of a segment's largest derivative a derivative counts as zero, and has no direction: the
/// derivative at the end of a segment is a sum that carries the rounding of its terms.
pub(crate) const ZERO_TANGENT: f64 = 1e-6;

/// `c₀ + c₁ t + c₂ t² + c₃ t³`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cubic(pub(crate) [DVec3; 4]);

impl Cubic {
    pub(crate) fn at(&self, t: f64) -> DVec3 {
        let c = &self.0;
        c[0] + t * (c[1] + t * (c[2] + t * c[3]))
    }

    pub(crate) fn derivative(&self, t: f64) -> DVec3 {
        let c = &self.0;
        c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])
    }

    /// The unit tangent, or zero.
    pub(crate) fn tangent(&self, t: f64) -> DVec3 {
        unit_or_zero(self.derivative(t), self.speed_bound())
    }

    /// An upper bound of the derivative's length.
    pub(crate) fn speed_bound(&self) -> f64 {
        let c = &self.0;
        c[1].length() + 2.0 * c[2].length() + 3.0 * c[3].length()
    }

    /// The part from `t0` to `t1` as a cubic of its own.
    pub(crate) fn part(&self, t0: f64, t1: f64) -> Self {
        let c = &self.0;
        let h = t1 - t0;
        let second = c[2] + 3.0 * t0 * c[3];
        Self([self.at(t0), h * self.derivative(t0), h * h * second, h * h * h * c[3]])
    }
}

/// `v` as a unit vector, or zero where it is negligible beside `bound`.
pub(crate) fn unit_or_zero(v: DVec3, bound: f64) -> DVec3 {
    let length = v.length();
    if length <= bound * ZERO_TANGENT || length == 0.0 { DVec3::ZERO } else { v / length }
}

/// A curve's segments.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spans {
    pub(crate) cubics: Vec<Cubic>,
    pub(crate) closed: bool,
}

impl Spans {
    pub(crate) fn new(curve: &Curve) -> Self {
        let mut spans = Self::default();
        spans.build(curve.kind(), curve.closed(), curve.points().len(), |i| to_dvec3(curve.points()[i]));
        spans
    }

    /// Builds the segments of a curve of `count` points, into the buffer that is already there.
    pub(crate) fn build(
        &mut self,
        kind: CurveKind,
        closed: bool,
        count: usize,
        point: impl Fn(usize) -> DVec3,
    ) {
        self.cubics.clear();
        self.closed = closed && count > 1;
        match kind {
            _ if count == 1 => self.cubics.push(Cubic([point(0), DVec3::ZERO, DVec3::ZERO, DVec3::ZERO])),
            CurveKind::BSpline { degree } => {
                bspline(&mut self.cubics, usize::from(degree).min(count - 1), closed, count, point);
            }
            CurveKind::Polyline => bspline(&mut self.cubics, 1, closed, count, point),
            CurveKind::CatmullRom => catmull_rom(&mut self.cubics, closed, count, point),
            CurveKind::Bezier => bezier(&mut self.cubics, closed, count, point),
        }
    }

    /// The segment that holds `u` and the place in it.
    pub(crate) fn locate(&self, u: f64) -> (usize, f64) {
        let n = self.cubics.len();
        let x = u.clamp(0.0, 1.0) * n as f64;
        let span = (x.floor() as usize).min(n - 1);
        (span, x - span as f64)
    }

    pub(crate) fn at(&self, u: f64) -> DVec3 {
        let (span, t) = self.locate(u);
        self.cubics[span].at(t)
    }

    /// Whether the curve has a direction anywhere.
    pub(crate) fn moves(&self) -> bool {
        self.cubics.iter().any(|c| c.0[1..] != [DVec3::ZERO; 3])
    }

    /// The unit tangent at `u`, or zero. At a joint of two segments the normalised mean of both sides.
    pub(crate) fn tangent(&self, u: f64) -> DVec3 {
        let (span, t) = self.locate(u);
        self.tangent_in(span, t)
    }

    /// The same at a place of a segment, so that both ends of a joint give the same.
    pub(crate) fn tangent_in(&self, span: usize, t: f64) -> DVec3 {
        if t <= 0.0 {
            self.joint_tangent(span)
        } else if t >= 1.0 {
            self.joint_tangent(span + 1)
        } else {
            self.cubics[span].tangent(t)
        }
    }

    /// The unit tangents left and right of joint `joint` (before segment `joint`); zero where there is no segment.
    pub(crate) fn joint_sides(&self, joint: usize) -> (DVec3, DVec3) {
        let n = self.cubics.len();
        let (before, after) = if self.closed {
            (Some((joint + n - 1) % n), Some(joint % n))
        } else {
            (joint.checked_sub(1), (joint < n).then_some(joint))
        };
        let left = before.map_or(DVec3::ZERO, |i| self.cubics[i].tangent(1.0));
        let right = after.map_or(DVec3::ZERO, |i| self.cubics[i].tangent(0.0));
        (left, right)
    }

    pub(crate) fn joint_tangent(&self, joint: usize) -> DVec3 {
        let (left, right) = self.joint_sides(joint);
        unit_or_zero(left + right, 1.0)
    }
}

pub(crate) fn to_dvec3(p: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

pub(crate) fn to_array(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// How many segments a B-spline has.
fn bspline_spans(degree: usize, closed: bool, count: usize) -> usize {
    if closed { count } else { count - degree }
}

fn bspline(out: &mut Vec<Cubic>, degree: usize, closed: bool, count: usize, point: impl Fn(usize) -> DVec3) {
    let spans = bspline_spans(degree, closed, count);
    out.extend((0..spans).map(|span| bspline_span(span, degree, closed, count, &point)));
}

/// De Boor's recursion on polynomials: each step mixes neighbours `a + (b − a)·α(t)` with `α` linear in `t`.
fn bspline_span(
    span: usize,
    degree: usize,
    closed: bool,
    count: usize,
    point: impl Fn(usize) -> DVec3,
) -> Cubic {
    let spans = bspline_spans(degree, closed, count);
    // Knots in units of one segment; segment `i` lies between knots i and i + 1.
    let knot = |j: f64| if closed { j } else { j.clamp(0.0, spans as f64) };
    let mut d = [Cubic::default(); 4];
    for (j, d) in d.iter_mut().enumerate().take(degree + 1) {
        d.0[0] = point((span + j) % count);
    }
    for level in 1..=degree {
        for j in (level..=degree).rev() {
            let first = knot((span + j) as f64 - degree as f64);
            let width = knot((span + 1 + j - level) as f64) - first;
            let alpha = [(span as f64 - first) / width, 1.0 / width];
            d[j] = mix(&d[j - 1], &d[j], alpha);
        }
    }
    d[degree]
}

/// `a + (b − a)·(α₀ + α₁ t)`; the product has no term of fourth degree, since the recursion starts at constants.
fn mix(a: &Cubic, b: &Cubic, alpha: [f64; 2]) -> Cubic {
    let mut c = *a;
    for i in 0..4 {
        let difference = b.0[i] - a.0[i];
        c.0[i] += difference * alpha[0];
        if i < 3 {
            c.0[i + 1] += difference * alpha[1];
        }
    }
    c
}

/// How many segments a Bézier chain has.
fn bezier_spans(closed: bool, count: usize) -> usize {
    if closed { count / 3 } else { (count - 1) / 3 }
}

fn bezier(out: &mut Vec<Cubic>, closed: bool, count: usize, point: impl Fn(usize) -> DVec3) {
    out.extend((0..bezier_spans(closed, count)).map(|span| bezier_span(span, count, &point)));
}

fn bezier_span(span: usize, count: usize, point: impl Fn(usize) -> DVec3) -> Cubic {
    let [p0, p1, p2, p3] = [0, 1, 2, 3].map(|j| point((3 * span + j) % count));
    let (d0, d1, d2) = (p1 - p0, p2 - p1, p3 - p2);
    Cubic([p0, 3.0 * d0, 3.0 * (d1 - d0), d2 - 2.0 * d1 + d0])
}

/// What a segment has of one control point: its number, and the powers of `t` of its factor `Nⱼ`.
pub(crate) type Factor = (usize, [f64; 4]);

/// For each segment of a curve what it has of its control points: `Σ Nⱼ(t)·Pⱼ`. None for a kind that is not linear in them.
pub(crate) fn factors(kind: CurveKind, closed: bool, count: usize) -> Option<Vec<Vec<Factor>>> {
    // The curve of one control point at 1 and all others at 0, built as every curve is.
    let only = |control: usize| move |i: usize| if i == control { DVec3::X } else { DVec3::ZERO };
    let powers = |cubic: Cubic| cubic.0.map(|c| c.x);
    let degree = match kind {
        _ if count == 1 => return Some(vec![vec![(0, [1.0, 0.0, 0.0, 0.0])]]),
        CurveKind::CatmullRom => return None,
        CurveKind::Bezier => {
            let factor = |span, j| {
                let control = (3 * span + j) % count;
                (control, powers(bezier_span(span, count, only(control))))
            };
            // A closed segment by itself ends with the point that it starts with.
            let own = |span| (0..4.min(count)).map(|j| factor(span, j)).collect();
            return Some((0..bezier_spans(closed, count)).map(own).collect());
        }
        CurveKind::BSpline { degree } => usize::from(degree).min(count - 1),
        CurveKind::Polyline => 1,
    };
    let factor = |span, j| {
        let control = (span + j) % count;
        (control, powers(bspline_span(span, degree, closed, count, only(control))))
    };
    let own = |span| (0..=degree).map(|j| factor(span, j)).collect();
    Some((0..bspline_spans(degree, closed, count)).map(own).collect())
}

/// Barry and Goldman's centripetal spline in Hermite form.
fn catmull_rom(out: &mut Vec<Cubic>, closed: bool, count: usize, point: impl Fn(usize) -> DVec3) {
    let spans = if closed { count } else { count - 1 };
    for span in 0..spans {
        let (b, c) = (point(span), point((span + 1) % count));
        let a = if closed || span > 0 { point((span + count - 1) % count) } else { 2.0 * b - c };
        let d = if closed || span + 2 < count { point((span + 2) % count) } else { 2.0 * c - b };
        let [h0, h1, h2] = [b - a, c - b, d - c].map(|v| v.length().sqrt());
        if h1 == 0.0 {
            out.push(Cubic([b, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO]));
            continue;
        }
        // As a neighbour comes to coincide, its secant vanishes and so does the tangent.
        let tangent = |before: DVec3, ha: f64, after: DVec3, hb: f64, own: DVec3| {
            if ha == 0.0 || hb == 0.0 {
                DVec3::ZERO
            } else {
                own + h1 * ((before / ha + after / hb) - own / h1 - (before + after) / (ha + hb))
            }
        };
        let m0 = tangent(b - a, h0, c - b, h1, c - b);
        let m1 = tangent(c - b, h1, d - c, h2, c - b);
        let chord = c - b;
        out.push(Cubic([b, m0, 3.0 * chord - 2.0 * m0 - m1, m0 + m1 - 2.0 * chord]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle_points(n: usize) -> Vec<[f32; 3]> {
        let angle = |i: usize| std::f32::consts::TAU * i as f32 / n as f32;
        (0..n).map(|i| [angle(i).cos(), angle(i).sin(), 0.1 * i as f32]).collect()
    }

    #[test]
    fn open_bsplines_start_and_end_at_their_points_and_join_smoothly() {
        for degree in 1..=3 {
            let points = circle_points(7);
            let spans = Spans::new(&Curve::bspline(degree, points.clone()).unwrap());
            assert_eq!(spans.cubics.len(), 7 - usize::from(degree));
            assert!(spans.at(0.0).distance(to_dvec3(points[0])) < 1e-12);
            assert!(spans.at(1.0).distance(to_dvec3(points[6])) < 1e-12);
            for w in spans.cubics.windows(2) {
                assert!(w[0].at(1.0).distance(w[1].at(0.0)) < 1e-12);
                if degree > 1 {
                    assert!(w[0].derivative(1.0).distance(w[1].derivative(0.0)) < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_closed_cubic_starts_at_the_mean_of_its_first_three_points() {
        let p = circle_points(5);
        let curve = Curve::new(CurveKind::BSpline { degree: 3 }, true, p.clone()).unwrap();
        let spans = Spans::new(&curve);
        let start = (to_dvec3(p[0]) + 4.0 * to_dvec3(p[1]) + to_dvec3(p[2])) / 6.0;
        assert!(spans.at(0.0).distance(start) < 1e-12);
        assert!(spans.at(1.0).distance(start) < 1e-12);
    }

    #[test]
    fn catmull_rom_passes_through_its_points() {
        for closed in [false, true] {
            let mut p = circle_points(6);
            p[3] = p[2];
            let curve = Curve::new(CurveKind::CatmullRom, closed, p.clone()).unwrap();
            let spans = Spans::new(&curve);
            for (i, cubic) in spans.cubics.iter().enumerate() {
                assert!(cubic.at(0.0).distance(to_dvec3(p[i])) < 1e-12);
                assert!(cubic.at(1.0).distance(to_dvec3(p[(i + 1) % 6])) < 1e-12);
            }
        }
    }

    #[test]
    fn a_part_is_the_same_curve() {
        let spans = Spans::new(&Curve::bspline(3, circle_points(4)).unwrap());
        let part = spans.cubics[0].part(0.25, 0.75);
        for i in 0..=10 {
            let s = f64::from(i) / 10.0;
            assert!(part.at(s).distance(spans.cubics[0].at(0.25 + 0.5 * s)) < 1e-14);
        }
    }

    #[test]
    fn the_tangent_of_a_corner_is_the_mean_and_of_a_hairpin_zero() {
        let corner = Curve::polyline(vec![[0.0; 3], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]).unwrap();
        let mean = Spans::new(&corner).tangent(0.5);
        assert!(mean.distance(DVec3::new(1.0, 1.0, 0.0).normalize()) < 1e-12);
        let back = Curve::polyline(vec![[0.0; 3], [5.0, 0.0, 0.0], [0.0; 3]]).unwrap();
        assert_eq!(Spans::new(&back).tangent(0.5), DVec3::ZERO);
    }
}
