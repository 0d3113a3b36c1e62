//! A box of quads.

use glam::{DVec3, UVec3};

use super::{Builder, PrimitiveError, check_count, check_finite, check_size};
use crate::Mesh;
use crate::vector::wide;

/// The surface of the box from `min` to `max`, `cells` quads along each axis.
///
/// The vertices are the lattice points `(i, j, k)` on the surface, `i` running fastest, then `j`, then `k`:
/// `(l + 1)(m + 1)(n + 1) − (l − 1)(m − 1)(n − 1)` of them. Faces come by side: −X, +X, −Y, +Y, −Z, +Z. Edges are
/// hard; each side has texture coordinates of its own from 0 to 1.
pub fn cuboid(min: [f32; 3], max: [f32; 3], cells: [u32; 3]) -> Result<Mesh, PrimitiveError> {
    check_finite("min", &min)?;
    check_finite("max", &max)?;
    if let Some(axis) = (0..3).find(|&a| max[a] <= min[a]) {
        return Err(PrimitiveError::EmptyBox { axis: ['X', 'Y', 'Z'][axis] });
    }
    check_count("cells", 1, &cells)?;
    let [l, m, n] = cells.map(|c| c.saturating_add(1));
    check_size(&[[l, m], [l, m], [m, n], [m, n], [n, l], [n, l]])?;
    let cells = UVec3::from(cells);
    let lattice = Lattice { cells };
    let mut builder = Builder::default();
    for k in 0..=cells.z {
        for j in 0..=cells.y {
            let inner = k > 0 && k < cells.z && j > 0 && j < cells.y;
            // Of a row inside only its two ends are on the surface.
            for i in (0..=cells.x).step_by(if inner { cells.x as usize } else { 1 }) {
                let x = UVec3::new(i, j, k).as_dvec3() / cells.as_dvec3();
                builder.position(wide(min) * (1.0 - x) + wide(max) * x);
            }
        }
    }
    for axis in 0..3 {
        side(&mut builder, &lattice, axis, false);
        side(&mut builder, &lattice, axis, true);
    }
    builder.finish("max")
}

/// Which vertex a lattice point on the surface is.
struct Lattice {
    cells: UVec3,
}

impl Lattice {
    fn vertex(&self, at: UVec3) -> u32 {
        let UVec3 { x: l, y: m, z: n } = self.cells;
        let (full, row) = ((l + 1) * (m + 1), l + 1);
        let hollow = 2 * (l + 1) + 2 * (m - 1);
        let layer = match at.z {
            0 => 0,
            k => full + (k - 1) * hollow,
        };
        if at.z == 0 || at.z == n {
            return layer + at.y * row + at.x;
        }
        match at.y {
            0 => layer + at.x,
            y if y == m => layer + row + 2 * (m - 1) + at.x,
            y => layer + row + 2 * (y - 1) + u32::from(at.x > 0),
        }
    }
}

/// The quads of the side at the least or greatest coordinate along `axis`.
fn side(builder: &mut Builder, lattice: &Lattice, axis: usize, greatest: bool) {
    // a × b points outwards.
    let (mut a, mut b) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut outwards = DVec3::ZERO;
    outwards[axis] = if greatest { 1.0 } else { -1.0 };
    if !greatest {
        std::mem::swap(&mut a, &mut b);
    }
    let normal = builder.normal(outwards);
    let (na, nb) = (lattice.cells[a], lattice.cells[b]);
    let first = builder.mesh.uvs.len() as u32;
    for j in 0..=nb {
        for i in 0..=na {
            builder.uv(f64::from(i) / f64::from(na), f64::from(j) / f64::from(nb));
        }
    }
    let corner = |i: u32, j: u32| {
        let mut at = UVec3::ZERO;
        (at[a], at[b]) = (i, j);
        at[axis] = if greatest { lattice.cells[axis] } else { 0 };
        [lattice.vertex(at), first + j * (na + 1) + i, normal]
    };
    for j in 0..nb {
        for i in 0..na {
            builder.face(&[corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::conformance;
    use super::*;

    #[test]
    fn counts_volume_and_order() {
        for [l, m, n] in [[8, 8, 8], [1, 1, 1], [1, 4, 2], [5, 1, 3], [2, 3, 1]] {
            let mesh = cuboid([-1.0, 0.0, 2.0], [1.0, 3.0, 2.5], [l, m, n]).unwrap();
            let count = (l + 1) * (m + 1) * (n + 1) - (l - 1) * (m - 1) * (n - 1);
            assert_eq!(mesh.positions.len() as u32, count);
            assert_eq!(mesh.face_ends.len() as u32, 2 * (l * m + m * n + n * l));
            assert!((conformance::check(&mesh, true) - 3.0).abs() < 1e-5);
            let key = |p: &[f32; 3]| [p[2], p[1], p[0]];
            assert!(mesh.positions.windows(2).all(|w| key(&w[0]) < key(&w[1])));
        }
    }

    #[test]
    fn sides_are_flat_and_hard() {
        let mesh = cuboid([0.0; 3], [1.0; 3], [2, 3, 4]).unwrap();
        for face in mesh.faces() {
            let n = mesh.normals[face[0].normal.unwrap() as usize];
            let axis = n.iter().position(|&c| c != 0.0).unwrap();
            let wall = if n[axis] > 0.0 { 1.0 } else { 0.0 };
            assert!(face.iter().all(|c| mesh.positions[c.position as usize][axis] == wall));
        }
    }

    #[test]
    fn bad_arguments_are_named() {
        let error = |max, cells| cuboid([0.0; 3], max, cells).unwrap_err();
        assert_eq!(error([1.0, 0.0, 1.0], [1, 1, 1]), PrimitiveError::EmptyBox { axis: 'Y' });
        assert_eq!(error([1.0, 1.0, f32::NAN], [1, 1, 1]), PrimitiveError::NotFinite { argument: "max" });
        assert_eq!(
            error([1.0; 3], [1, 0, 1]),
            PrimitiveError::TooFew { argument: "cells", least: 1, found: 0 }
        );
        assert!(matches!(error([1.0; 3], [u32::MAX; 3]), PrimitiveError::TooLarge { .. }));
    }
}
