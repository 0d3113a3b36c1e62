//! A flat rectangle of quads.

use super::{Builder, PrimitiveError, check_count, check_finite, check_positive, check_size};
use crate::Mesh;
use crate::vector::{frame, wide};

/// A rectangle about the origin, facing `normal` (of any length but 0).
///
/// `size` and `cells` are along X and Z for the normal `+Y`; for another normal the rectangle is turned by the
/// least rotation of `+Y` to it (for `−Y` by half a turn about X). Vertex `j · (cells[0] + 1) + i` is the one
/// `i` cells along the first side and `j` along the second, from the corner with the least coordinates (before the turn).
/// `u` runs along the first side, `v` against the second.
pub fn grid(size: [f32; 2], cells: [u32; 2], normal: [f32; 3]) -> Result<Mesh, PrimitiveError> {
    check_positive("size", &size)?;
    check_count("cells", 1, &cells)?;
    check_size(&[cells.map(|c| c.saturating_add(1))])?;
    check_finite("normal", &normal)?;
    let axis = wide(normal).try_normalize().ok_or(PrimitiveError::ZeroVector { argument: "normal" })?;
    let [e1, _, e2] = frame(axis);
    let [nx, nz] = cells;
    let mut builder = Builder::default();
    let normal = builder.normal(axis);
    for j in 0..=nz {
        for i in 0..=nx {
            let (x, z) = (f64::from(i) / f64::from(nx), f64::from(j) / f64::from(nz));
            let along = |side: f32, x: f64| f64::from(side) * (x - 0.5);
            builder.position(e1 * along(size[0], x) + e2 * along(size[1], z));
            builder.uv(x, 1.0 - z);
        }
    }
    for j in 0..nz {
        for i in 0..nx {
            let a = j * (nx + 1) + i;
            let b = a + nx + 1;
            builder.face(&[a, b, b + 1, a + 1].map(|p| [p, p, normal]));
        }
    }
    builder.finish("size")
}

#[cfg(test)]
mod tests {
    use super::super::conformance;
    use super::*;

    #[test]
    fn a_grid_lies_in_the_plane_of_its_normal() {
        for normal in [[0.0, 1.0, 0.0], [0.0, -2.0, 0.0], [1.0, 0.0, 0.0], [0.3, -0.4, 0.5]] {
            let mesh = grid([2.0, 3.0], [4, 5], normal).unwrap();
            conformance::check(&mesh, false);
            assert_eq!((mesh.positions.len(), mesh.face_ends.len()), (5 * 6, 20));
            let n = wide(normal).normalize();
            assert!(mesh.positions.iter().all(|&p| wide(p).dot(n).abs() < 1e-6));
            let triangles = mesh.triangles().unwrap();
            let at = |i: u32| wide(mesh.positions[i as usize]);
            let area: f64 =
                triangles.iter().map(|t| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).dot(n) / 2.0).sum();
            assert!((area - 6.0).abs() < 1e-5, "{area}");
        }
    }

    #[test]
    fn with_normal_y_the_sides_are_x_and_z() {
        let mesh = grid([2.0, 4.0], [2, 1], [0.0, 1.0, 0.0]).unwrap();
        let expected =
            [[-1., 0., -2.], [0., 0., -2.], [1., 0., -2.], [-1., 0., 2.], [0., 0., 2.], [1., 0., 2.]];
        assert_eq!(mesh.positions, expected);
    }

    #[test]
    fn bad_arguments_are_named() {
        let up = [0.0, 1.0, 0.0];
        let error = |size, cells, normal| grid(size, cells, normal).unwrap_err();
        assert_eq!(error([0.0, 1.0], [1, 1], up), PrimitiveError::NotPositive { argument: "size" });
        assert_eq!(error([1.0, f32::NAN], [1, 1], up), PrimitiveError::NotFinite { argument: "size" });
        assert_eq!(
            error([1.0, 1.0], [1, 0], up),
            PrimitiveError::TooFew { argument: "cells", least: 1, found: 0 }
        );
        assert_eq!(error([1.0, 1.0], [1, 1], [0.0; 3]), PrimitiveError::ZeroVector { argument: "normal" });
        assert!(matches!(error([1.0, 1.0], [u32::MAX, u32::MAX], up), PrimitiveError::TooLarge { .. }));
    }
}
