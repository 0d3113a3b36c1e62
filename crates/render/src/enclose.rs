//! Whether a point lies inside, for a camera that should not.
//!
//! The generalised winding number: the solid angles of all triangles as seen from the point, over 4π. It is 1 inside a
//! closed surface, 0 outside, and degrades gracefully: under an open tube it is the share of the sky that the tube hides.
//! Solid angles: A. van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle", 1983. Winding numbers of triangle
//! soups: A. Jacobson, L. Kavan, O. Sorkine, "Robust Inside-Outside Segmentation using Generalized Winding Numbers", 2013.

use glam::DVec3;
use rayon::prelude::*;

use crate::scene::Part;

/// Triangles a thread adds up at once. The sums of chunks are added in their order, whatever the number of threads.
const CHUNK: usize = 4096;

/// How often a part's triangles wind round a point, counter-clockwise seen from outside. Triangles that refer to no
/// vertex and those that the point lies on add nothing.
pub(crate) fn winding(part: &Part, point: DVec3) -> f64 {
    let corner = |v: u32| part.positions.get(v as usize).map(|p| DVec3::from(p.map(f64::from)) - point);
    let angle = |triangle: &[u32; 3]| match triangle.map(corner) {
        [Some(a), Some(b), Some(c)] => solid_angle(a, b, c),
        _ => 0.0,
    };
    let sums: Vec<f64> =
        part.triangles.par_chunks(CHUNK).map(|chunk| chunk.iter().map(angle).sum()).collect();
    sums.iter().sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// The solid angle of a triangle seen from the origin, positive where it turns its back.
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    let angle = 2.0 * a.dot(b.cross(c)).atan2(below);
    if angle.is_finite() { angle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octant_is_an_eighth_of_all_directions() {
        for scale in [1e-6, 1.0, 1e12] {
            let angle = solid_angle(DVec3::X * scale, DVec3::Y * 3.0 * scale, DVec3::Z * scale);
            assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{angle}");
        }
        assert_eq!(solid_angle(DVec3::X, DVec3::X, DVec3::Y), 0.0);
        assert_eq!(solid_angle(DVec3::ZERO, DVec3::X, DVec3::Y), 0.0);
        assert_eq!(solid_angle(DVec3::NAN, DVec3::X, DVec3::Y), 0.0);
    }
}
