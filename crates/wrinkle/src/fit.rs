//! Quadratic B-splines through given points.
//!
//! A crease needs a curve that lies on the surface, is smooth (at a corner of `R` the nearest point jumps), and
//! whose `W − R` is linear in its control points, so that a part that has not risen is exactly at rest. Catmull-Rom
//! curves fail the last: their knots follow the pose. Quadratic B-splines have all three, and their nearest point
//! costs a cubic where a cubic's costs a quintic.
//!
//! The points are prescribed at the *nodes* (Greville abscissae): one a control point, at the middle of each span and
//! at both ends of an open curve.

use glam::DVec3;

/// Sweeps of the Gauss-Seidel iteration. The system is diagonally dominant, 3/4 against 2 · 1/8 (at worst 5/8
/// against 3/8), and each sweep gains a decimal: this is double precision.
const SWEEPS: usize = 24;

/// The parameters of the nodes of a curve of `spans` spans, one a control point: `spans + 2` of them open, `spans`
/// closed.
pub(crate) fn nodes(spans: usize, closed: bool) -> Vec<f64> {
    let n = spans as f64;
    if closed {
        // Span i is made of the points i to i + 2 and its middle lies at point i + 1.
        return (0..spans).map(|j| (j as f64 - 0.5).rem_euclid(n) / n).collect();
    }
    let middle = |i| (i as f64 + 0.5) / n;
    std::iter::once(0.0).chain((0..spans).map(middle)).chain([1.0]).collect()
}

/// The control points of the curve that has `values` at its [`nodes`]; at least 3 of them.
pub(crate) fn interpolate(values: &[DVec3], closed: bool) -> Vec<DVec3> {
    let count = values.len();
    let mut points = values.to_vec();
    for _ in 0..SWEEPS {
        for i in 0..count {
            let (before, after) = (points[(i + count - 1) % count], points[(i + 1) % count]);
            points[i] = match (closed, i, count - 1 - i) {
                (false, 0, _) | (false, _, 0) => values[i],
                // One span alone is a Bézier; else only the span at an end has other basis functions.
                (false, 1, 1) => (values[i] - (before + after) * 0.25) / 0.5,
                (false, 1, _) => (values[i] - before * 0.25 - after * 0.125) / 0.625,
                (false, _, 1) => (values[i] - before * 0.125 - after * 0.25) / 0.625,
                _ => (values[i] - (before + after) * 0.125) / 0.75,
            };
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use wirework_core::{Curve, CurveKind};

    use super::*;

    #[test]
    fn the_curve_passes_through_its_values() {
        for closed in [false, true] {
            for spans in [1, 2, 3, 4, 9, 40] {
                if closed && spans < 3 {
                    continue;
                }
                let nodes = nodes(spans, closed);
                let value = |u: &f64| DVec3::new((u * 6.0).cos(), (u * 12.0).sin(), u * (1.0 - u));
                let values: Vec<DVec3> = nodes.iter().map(value).collect();
                let points = interpolate(&values, closed);
                let points: Vec<_> = points.iter().map(|p| p.as_vec3().to_array()).collect();
                let curve = Curve::new(CurveKind::BSpline { degree: 2 }, closed, points).unwrap();
                for (u, value) in nodes.iter().zip(&values) {
                    let found = DVec3::from(curve.point(*u as f32).map(f64::from));
                    assert!(found.distance(*value) < 1e-5, "{closed} {spans} at {u}: {found} {value}");
                }
            }
        }
    }

    #[test]
    fn constants_stay_constant() {
        for closed in [false, true] {
            for point in interpolate(&[DVec3::ONE; 7], closed) {
                assert!(point.distance(DVec3::ONE) < 1e-14);
            }
        }
    }
}
