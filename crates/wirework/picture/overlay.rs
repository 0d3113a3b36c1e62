//! The wires of an effect as lines over a picture.

use wirework_core::{Curve, Wire};
use wirework_render::{Dots, Line, LineKind, Scene};

use crate::Evaluation;

/// Points of a drawn curve, about: enough for it to look smooth across a large picture. And the least for a segment.
const POINTS: usize = 160;
const PER_SEGMENT: usize = 8;
/// Widths in a picture of [`ROWS`], pixels; they grow with the picture.
const WIDTH: f32 = 2.4;
const THIN: f32 = 1.1;
const DOT: f32 = 8.0;
const ROWS: f32 = 540.0;
/// Lines of small pictures do not get thinner than this, in parts of their width.
const LEAST: f32 = 0.6;

/// Puts the wires of an effect into a scene that is shown `rows` pixels high, as they were at the moment that was last worked out;
/// `before` the effect only where they lie at rest. What is drawn later lies on top.
pub(crate) fn draw(evaluation: &Evaluation<'_>, before: bool, rows: u32, scene: &mut Scene) {
    let factor = thickness(rows);
    let mut add = |kind: LineKind, points: Vec<[f32; 3]>, width: f32| {
        scene.lines.push(Line { points, color: kind.color(), width: width * factor, kind });
    };
    if !before {
        for (size, controls) in evaluation.lattices() {
            lattice_lines(size, controls).for_each(|points| add(LineKind::Lattice, points, THIN));
        }
    }
    let wires = || evaluation.wires();
    wires().for_each(|wire| add(LineKind::Reference, smooth(&wire.reference), WIDTH));
    for domain in wires().flat_map(|wire| &wire.domains) {
        add(LineKind::Domain, smooth(&domain.curve), WIDTH);
    }
    if before {
        return;
    }
    for curve in wires().filter_map(posed) {
        add(LineKind::Wire, smooth(&curve), WIDTH);
    }
    let locators = wires().filter_map(|wire| Some((posed(wire)?, wire)));
    let points = |(curve, wire): (Curve, &Wire)| {
        wire.locators.iter().map(|locator| curve.point(locator.u)).collect::<Vec<_>>()
    };
    let points: Vec<[f32; 3]> = locators.flat_map(points).collect();
    if !points.is_empty() {
        let kind = LineKind::Locator;
        scene.dots.push(Dots { points, color: kind.color(), width: DOT * factor, kind });
    }
}

/// Points that hold all that is drawn of an effect between them.
pub(crate) fn reach(evaluation: &Evaluation<'_>) -> Vec<[f32; 3]> {
    let mut points: Vec<[f32; 3]> =
        evaluation.lattices().flat_map(|(_, controls)| controls).copied().collect();
    for wire in evaluation.wires() {
        let domains = wire.domains.iter().map(|domain| &domain.curve);
        points.extend(std::iter::once(&wire.reference).chain(domains).flat_map(smooth));
        points.extend(posed(wire).iter().flat_map(smooth));
    }
    points
}

/// Points along a curve, close enough together to look smooth.
fn smooth(curve: &Curve) -> Vec<[f32; 3]> {
    // There are about as many segments as control points.
    curve.sampled((POINTS / curve.points().len()).max(PER_SEGMENT))
}

/// The factor on widths in a picture of so many rows.
pub(crate) fn thickness(rows: u32) -> f32 {
    (rows as f32 / ROWS).max(LEAST)
}

/// `W`.
fn posed(wire: &Wire) -> Option<Curve> {
    wire.reference.posed(wire.pose.clone()).ok()
}

/// The lines along the three axes of a grid of control points, X fastest.
fn lattice_lines([l, m, n]: [usize; 3], controls: &[[f32; 3]]) -> impl Iterator<Item = Vec<[f32; 3]>> {
    let at = move |i: usize, j: usize, k: usize| controls.get((k * m + j) * l + i).copied();
    let pairs = |a: usize, b: usize| (0..a).flat_map(move |i| (0..b).map(move |j| (i, j)));
    let x = pairs(m, n).map(move |(j, k)| (0..l).filter_map(|i| at(i, j, k)).collect());
    let y = pairs(l, n).map(move |(i, k)| (0..m).filter_map(|j| at(i, j, k)).collect());
    let z = pairs(l, m).map(move |(i, j)| (0..n).filter_map(|k| at(i, j, k)).collect());
    x.chain(y).chain(z)
}
