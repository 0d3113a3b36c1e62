//! One crease: a wire whose crest stands over a line on the surface.
//!
//! `R` passes through points of the surface at equal steps of arc length, so that its parameter *is* the fraction of
//! arc length; `W = R + height · N`, with `N` the outward unit normals. Both are quadratic B-splines of
//! the same nodes ([`fit`](crate::fit)). The wire only translates (`rotation` 0): bending the object with the
//! slope of the crest would lean the fold over.
//!
//! # How fine
//!
//! A point of the surface at distance `e` from `R` rises by `F = (1 − (e/r)^q)²` instead of 1, a loss of about
//! `2 (e/r)^q`: for the loss to stay under 1 %, a sharp crease (`q = 1`) must keep to 0.005 of its thickness, the quartic
//! (`q = 2`) to 0.07. `N` between its nodes may be off by another 1 %. Together they keep the crest within 3 %. A crease
//! starts with a span a third of the thickness, which on a surface of radius `ρ` leaves `e` about
//! `(r/3)⁴/(400 ρ³)`, and is refined where the surface (an edge, a facet) asks for more.

use wirework_core::{Curve, CurveKind};
use wirework_surface::Step;

use crate::fit::{interpolate, nodes};
use crate::ground::{Anchor, Footing, Ground, wide};
use crate::pattern::{Fork, Line};

/// The part of the height that may be lost because `R` leaves the surface.
const LOSS: f64 = 0.01;
/// How far `R` may leave the surface however little it costs, in parts of the thickness: what a viewer of the wires
/// would see.
const OFF_SURFACE: f64 = 0.05;
/// How far `N` may be from length 1 between its nodes.
const OFF_UNIT: f64 = 0.01;
/// Spans in the length of a thickness at the coarsest, and how often they are halved at most: a hard edge across
/// a crease never gets within [`LOSS`], and a span of 1/24 of the thickness cuts it by 1/70.
pub(crate) const SPANS_A_THICKNESS: f64 = 3.0;
const HALVINGS: usize = 3;
/// Spans of a crease: enough to follow a bend, and not so many that a tiny thickness takes for ever.
pub(crate) const SPANS: std::ops::RangeInclusive<usize> = 8..=1024;

#[derive(Clone, Debug)]
pub(crate) struct Crease {
    pub(crate) reference: Curve,
    /// What a height of 1 adds to each control point.
    pub(crate) lift: Vec<[f32; 3]>,
    /// Where on the surface each control point's node lies.
    pub(crate) anchors: Vec<Anchor>,
    /// Distance of each control point's node from the origin, as a fraction of the crease.
    pub(crate) fractions: Vec<f64>,
    /// The distance to the next creases at each node.
    pub(crate) spacings: Vec<f64>,
    /// Its own part of the height.
    pub(crate) strength: f64,
    /// The line on the surface, where it was laid.
    pub(crate) steps: Vec<Step>,
    /// Which crease of the pattern it is, or is a part of.
    pub(crate) index: usize,
    /// What it branches off.
    pub(crate) fork: Option<Fork>,
}

/// How fine creases are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fineness {
    /// Length of a span at the coarsest.
    span: f64,
    /// How far `R` may be off the surface.
    off: f64,
    /// Spans at least.
    least: usize,
    /// Spans up to which a crease may be refined.
    most: usize,
}

impl Fineness {
    /// For folds of a thickness and an exponent, with so many spans at least and at most.
    pub(crate) fn new(thickness: f64, q: f64, least: usize, most: usize) -> Self {
        Self {
            span: thickness / SPANS_A_THICKNESS,
            off: thickness * (LOSS / 2.0).powf(1.0 / q).min(OFF_SURFACE),
            least,
            most,
        }
    }
}

impl Crease {
    /// `None` where the surface has no normal.
    pub(crate) fn new(ground: &Ground, line: &Line, fineness: &Fineness) -> Option<Self> {
        let coarsest = (line.trace.length() / fineness.span).ceil() as usize;
        let mut spans = coarsest.clamp(fineness.least, *SPANS.end());
        for _ in 0..HALVINGS {
            let crease = Self::of_spans(ground, line, spans)?;
            if spans >= fineness.most || crease.follows(ground, fineness.off) {
                return Some(crease);
            }
            spans = (spans * 2).min(fineness.most);
        }
        Self::of_spans(ground, line, spans)
    }

    fn of_spans(ground: &Ground, line: &Line, spans: usize) -> Option<Self> {
        let nodes = nodes(spans, line.closed);
        let footings: Option<Vec<Footing>> = nodes.iter().map(|&u| line.trace.footing(ground, u)).collect();
        let footings = footings?;
        let (reference, lift) = through(&footings, line.closed)?;
        // A closed crease grows both ways from its first end.
        let along = |u: f64| if line.closed { 2.0 * u.min(1.0 - u) } else { u };
        let between = |(a, b): (f64, f64)| nodes.iter().map(move |&u| a + (b - a) * along(u)).collect();
        Some(Self {
            reference,
            lift,
            anchors: footings.iter().map(|footing| footing.anchor).collect(),
            fractions: between(line.range),
            spacings: between(line.spacing),
            strength: line.strength,
            steps: line.trace.steps(ground),
            index: line.index,
            fork: line.fork,
        })
    }

    /// Its curves where the vertices have moved to `positions`; `None` where the surface has no normal there.
    pub(crate) fn moved(&self, ground: &Ground, positions: &[[f32; 3]]) -> Option<(Curve, Vec<[f32; 3]>)> {
        let footings: Option<Vec<Footing>> =
            self.anchors.iter().map(|anchor| ground.footing_on(anchor, positions)).collect();
        through(&footings?, self.reference.closed())
    }

    /// The place of a fraction of its length among its control points: a node, and the share of the way to the next.
    pub(crate) fn place(&self, fraction: f64) -> (usize, f64) {
        let nodes = nodes(self.lift.len().saturating_sub(2), false);
        let next = nodes.partition_point(|&u| u <= fraction).clamp(1, nodes.len() - 1);
        let (a, b) = (nodes[next - 1], nodes[next]);
        (next - 1, ((fraction - a) / (b - a)).clamp(0.0, 1.0))
    }

    /// Whether it keeps to the surface and to its height between the nodes: where spans meet.
    fn follows(&self, ground: &Ground, allowed: f64) -> bool {
        let Ok(lift) = self.reference.posed(self.lift.clone()) else { return true };
        let mut joints = self.reference.sampled(1).into_iter().zip(lift.sampled(1));
        joints.all(|(point, lift)| {
            ground.distance(wide(point)) <= allowed && (wide(lift).length() - 1.0).abs() <= OFF_UNIT
        })
    }
}

/// The reference curve through points of the surface, and what a height of 1 adds to each of its control points.
fn through(footings: &[Footing], closed: bool) -> Option<(Curve, Vec<[f32; 3]>)> {
    let points = |value: fn(&Footing) -> glam::DVec3| -> Vec<[f32; 3]> {
        let values: Vec<glam::DVec3> = footings.iter().map(value).collect();
        interpolate(&values, closed).iter().map(|p| p.as_vec3().to_array()).collect()
    };
    let reference = Curve::new(CurveKind::BSpline { degree: 2 }, closed, points(|f| f.position)).ok()?;
    Some((reference, points(|f| f.normal)))
}
