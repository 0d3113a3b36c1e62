//! Curves as data: a kind, control points, open or closed.
//!
//! `u` runs from 0 to 1 along a curve and is uniform per segment for every kind: segment `i` of `n` covers
//! `[i/n, (i+1)/n]`, whatever its length.

use thiserror::Error;

use crate::arclength::ArcLength;
use crate::spans::{Spans, to_array};

/// How control points define a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// Non-rational B-spline, `degree` 1 to 3. Open: clamped uniform knots, so that it starts and ends at its
    /// first and last control points; `n` points give `n − degree` segments. Closed: periodic uniform knots;
    /// `n` points give `n` segments, and segment `i` is made of points `i ..= i + degree` (modulo `n`).
    /// With too few points the degree drops to `n − 1`.
    BSpline {
        /// 1, 2 or 3.
        degree: u8,
    },
    /// Straight segments between the points.
    Polyline,
    /// Centripetal Catmull-Rom spline: interpolates its points; the knot distance of two neighbours is the
    /// square root of their distance. Beyond the ends of an open curve the neighbour is mirrored at the end
    /// (`2 P₀ − P₁`).
    CatmullRom,
    /// Chain of cubic Bézier segments that share their end points: `3 n + 1` points open, `3 n` closed.
    Bezier,
}

/// A parametric curve in space, `u ∈ [0, 1]`. \[SF98\] §2: the free-form curves `R`, `W`; §3.2: `D`.
///
/// The fields are private: a `Curve` that exists has at least one finite control point, and as many as its kind needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    kind: CurveKind,
    closed: bool,
    points: Vec<[f32; 3]>,
}

/// Why control points do not make a curve.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// There are no control points.
    #[error("a curve needs at least one control point")]
    Empty,
    /// A control point is NaN or infinite.
    #[error("control point {index} is not finite")]
    NotFinite {
        /// Which one, from 0.
        index: usize,
    },
    /// The degree of a B-spline is not 1, 2 or 3.
    #[error("the degree of a B-spline is 1, 2 or 3, not {degree}")]
    Degree {
        /// The degree that was asked for.
        degree: u8,
    },
    /// The number of points does not fit a Bézier chain.
    #[error("{} Bézier chain has {} points, not {count}", if *.closed { "a closed" } else { "an open" },
            if *.closed { "3n" } else { "3n + 1" })]
    BezierCount {
        /// The number of points given.
        count: usize,
        /// Whether the chain is closed.
        closed: bool,
    },
    /// A pose has another number of points than the curve it poses.
    #[error("the curve has {expected} control points, its pose {found}")]
    PoseCount {
        /// Points of the curve.
        expected: usize,
        /// Points of the pose.
        found: usize,
    },
}

impl Curve {
    /// Makes a curve of `kind` through or along `points`.
    pub fn new(kind: CurveKind, closed: bool, points: Vec<[f32; 3]>) -> Result<Self, CurveError> {
        if points.is_empty() {
            return Err(CurveError::Empty);
        }
        if let CurveKind::BSpline { degree } = kind
            && !(1..=3).contains(&degree)
        {
            return Err(CurveError::Degree { degree });
        }
        let count = points.len();
        if kind == CurveKind::Bezier && (count % 3 != usize::from(!closed) || count == 0) {
            return Err(CurveError::BezierCount { count, closed });
        }
        check_finite(&points)?;
        Ok(Self { kind, closed, points })
    }

    /// A clamped B-spline of `degree` 1 to 3, the usual wire.
    pub fn bspline(degree: u8, points: Vec<[f32; 3]>) -> Result<Self, CurveError> {
        Self::new(CurveKind::BSpline { degree }, false, points)
    }

    /// An open polyline.
    pub fn polyline(points: Vec<[f32; 3]>) -> Result<Self, CurveError> {
        Self::new(CurveKind::Polyline, false, points)
    }

    /// A curve of the same kind with other control points, as many as this one has.
    pub fn posed(&self, points: Vec<[f32; 3]>) -> Result<Self, CurveError> {
        if points.len() != self.points.len() {
            return Err(CurveError::PoseCount { expected: self.points.len(), found: points.len() });
        }
        check_finite(&points)?;
        Ok(Self { kind: self.kind, closed: self.closed, points })
    }

    /// How the control points define the curve.
    pub fn kind(&self) -> CurveKind {
        self.kind
    }

    /// Whether the curve's end is its start.
    pub fn closed(&self) -> bool {
        self.closed
    }

    /// The control points; never empty, all finite.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }
}

pub(crate) fn check_finite(points: &[[f32; 3]]) -> Result<(), CurveError> {
    match points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        Some(index) => Err(CurveError::NotFinite { index }),
        None => Ok(()),
    }
}

impl Curve {
    /// The point at `u`; outside `[0, 1]` the end's.
    pub fn point(&self, u: f32) -> [f32; 3] {
        to_array(Spans::new(self).at(f64::from(u)))
    }

    /// The unit tangent at `u`, zero where the curve stands still. At a corner the normalised mean of the unit
    /// tangents of both sides.
    pub fn tangent(&self, u: f32) -> [f32; 3] {
        let spans = Spans::new(self);
        let count = spans.cubics.len() as f64;
        // The parameter of a joint is seldom a float32 number.
        let joint = (f64::from(u) * count).round() / count;
        let at_joint = joint as f32 == u;
        to_array(spans.tangent(if at_joint { joint } else { f64::from(u) }))
    }

    /// The points at several parameters, each clamped to `[0, 1]`, and the unit tangents there: zero where there is none, the mean
    /// of both sides at a corner. In double precision, for those who compute with differences of them.
    pub fn at(&self, parameters: impl IntoIterator<Item = f64>) -> Vec<([f64; 3], [f64; 3])> {
        let spans = Spans::new(self);
        parameters.into_iter().map(|u| (spans.at(u).to_array(), spans.tangent(u).to_array())).collect()
    }

    /// Arc length.
    pub fn length(&self) -> f32 {
        ArcLength::new(&Spans::new(self)).total() as f32
    }

    /// Points at equal steps of `u`, `per_segment` (at least 1) to each segment, both ends included: a drawing of the curve
    /// that has all its corners. A closed curve ends with its first point; a single control point is one point.
    pub fn sampled(&self, per_segment: usize) -> Vec<[f32; 3]> {
        let spans = Spans::new(self);
        let per_segment = per_segment.max(1);
        let Some(last) = spans.cubics.last() else {
            return self.points.first().copied().into_iter().collect();
        };
        let steps = (0..per_segment).map(|i| i as f64 / per_segment as f64);
        let inner = spans.cubics.iter().flat_map(|cubic| steps.clone().map(|t| to_array(cubic.at(t))));
        inner.chain([to_array(last.at(1.0))]).collect()
    }

    /// `count` points at equal steps of arc length, both ends included; on a closed curve without the last.
    pub fn spread(&self, count: usize) -> Vec<[f32; 3]> {
        let spans = Spans::new(self);
        let lengths = ArcLength::new(&spans);
        let steps = if spans.closed { count } else { count.saturating_sub(1) }.max(1);
        (0..count)
            .map(|i| {
                let (span, t) = lengths.inverse(&spans, lengths.total() * i as f64 / steps as f64);
                to_array(spans.cubics[span].at(t))
            })
            .collect()
    }
}
