//! The primitives a preset can name, as meshes with normals and texture coordinates.
//!
//! Each position stands once. The order of the vertices is part of each primitive's documentation and stays.
//! Faces run counter-clockwise seen from outside. Hard edges and texture seams are separate normals and texture
//! coordinates at the corners; `u` and `v` run so that `∂P/∂u × ∂P/∂v` points outwards (no mirrored texture).

mod cuboid;
mod grid;
mod sphere;
mod tube;

use glam::DVec3;
use thiserror::Error;

pub use cuboid::cuboid;
pub use grid::grid;
pub use sphere::sphere;
pub use tube::tube;

use crate::vector::narrow;
use crate::{Corner, Mesh};

/// The most vertices a primitive may have: then the numbers of its corners, some four a vertex, fit into 32 bits. What
/// memory there is for is the caller's to judge.
pub const MAX_VERTICES: u64 = 1 << 28;

/// Why arguments do not make a primitive. `argument` is the name of the function's argument.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PrimitiveError {
    /// A number is NaN or infinite, or so large that a vertex would be.
    #[error("`{argument}` must be finite and within the range of f32")]
    NotFinite {
        /// Which argument.
        argument: &'static str,
    },
    /// A size or radius is zero or negative.
    #[error("`{argument}` must be greater than 0")]
    NotPositive {
        /// Which argument.
        argument: &'static str,
    },
    /// A count is too small to make a surface.
    #[error("`{argument}` must be at least {least}, not {found}")]
    TooFew {
        /// Which argument.
        argument: &'static str,
        /// The least that works.
        least: u32,
        /// What was given.
        found: u32,
    },
    /// The normal has no length.
    #[error("`{argument}` must not be the zero vector")]
    ZeroVector {
        /// Which argument.
        argument: &'static str,
    },
    /// Both ends of a tube are the same point.
    #[error("`to` must differ from `from`")]
    SameEnds,
    /// A box has no extent along an axis.
    #[error("`max` must be greater than `min` along {axis}")]
    EmptyBox {
        /// `X`, `Y` or `Z`.
        axis: char,
    },
    /// More than [`MAX_VERTICES`].
    #[error("{vertices} vertices are more than the {MAX_VERTICES} a primitive may have")]
    TooLarge {
        /// How many there would be.
        vertices: u64,
    },
}

fn check_finite(argument: &'static str, values: &[f32]) -> Result<(), PrimitiveError> {
    if values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(PrimitiveError::NotFinite { argument }) }
}

fn check_positive(argument: &'static str, values: &[f32]) -> Result<(), PrimitiveError> {
    check_finite(argument, values)?;
    if values.iter().all(|&v| v > 0.0) { Ok(()) } else { Err(PrimitiveError::NotPositive { argument }) }
}

fn check_count(argument: &'static str, least: u32, values: &[u32]) -> Result<(), PrimitiveError> {
    match values.iter().find(|&&v| v < least) {
        Some(&found) => Err(PrimitiveError::TooFew { argument, least, found }),
        None => Ok(()),
    }
}

/// Refuses more than [`MAX_VERTICES`] in all of `sheets`, each of two counts of vertices.
fn check_size(sheets: &[[u32; 2]]) -> Result<(), PrimitiveError> {
    let vertices =
        sheets.iter().map(|[a, b]| u64::from(*a).saturating_mul(u64::from(*b))).fold(0, u64::saturating_add);
    if vertices > MAX_VERTICES { Err(PrimitiveError::TooLarge { vertices }) } else { Ok(()) }
}

/// A mesh while it is put together.
#[derive(Default)]
struct Builder {
    mesh: Mesh,
}

impl Builder {
    fn position(&mut self, p: DVec3) -> u32 {
        self.mesh.positions.push(narrow(p));
        self.mesh.positions.len() as u32 - 1
    }

    fn normal(&mut self, n: DVec3) -> u32 {
        self.mesh.normals.push(narrow(n));
        self.mesh.normals.len() as u32 - 1
    }

    fn uv(&mut self, u: f64, v: f64) -> u32 {
        self.mesh.uvs.push([u as f32, v as f32]);
        self.mesh.uvs.len() as u32 - 1
    }

    /// A face of corners `(position, uv, normal)`.
    fn face(&mut self, corners: &[[u32; 3]]) {
        let corner =
            |&[position, uv, normal]: &[u32; 3]| Corner { position, uv: Some(uv), normal: Some(normal) };
        self.mesh.corners.extend(corners.iter().map(corner));
        self.mesh.face_ends.push(self.mesh.corners.len() as u32);
    }

    /// The mesh, unless rounding to f32 took a position beyond its range.
    fn finish(self, argument: &'static str) -> Result<Mesh, PrimitiveError> {
        check_finite(argument, self.mesh.positions.as_flattened())?;
        Ok(self.mesh)
    }
}

/// What every primitive must be; used by the tests of each.
#[cfg(test)]
mod conformance {
    use std::collections::{HashMap, HashSet};

    use super::*;
    use crate::vector::wide;

    /// Distinct positions, consistent orientation, unit normals that agree with the faces, unmirrored UVs; closed
    /// where `closed`. Returns the enclosed volume.
    pub(super) fn check(mesh: &Mesh, closed: bool) -> f64 {
        mesh.check().unwrap();
        let distinct: HashSet<_> = mesh.positions.iter().map(|p| p.map(f32::to_bits)).collect();
        assert_eq!(distinct.len(), mesh.positions.len(), "a position stands twice");
        let used: HashSet<_> = mesh.corners.iter().map(|c| c.position).collect();
        assert_eq!(used.len(), mesh.positions.len(), "a position is in no face");
        let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
        for face in mesh.faces() {
            for (i, corner) in face.iter().enumerate() {
                let (a, b) = (corner.position, face[(i + 1) % face.len()].position);
                assert!(a != b);
                *edges.entry((a, b)).or_default() += 1;
            }
        }
        assert!(edges.values().all(|&n| n == 1), "two faces run along one edge in the same direction");
        if closed {
            assert!(edges.keys().all(|&(a, b)| edges.contains_key(&(b, a))), "an edge is open");
        }
        check_corners(mesh);
        let at = |i: u32| wide(mesh.positions[i as usize]);
        mesh.triangles().unwrap().iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum()
    }

    fn check_corners(mesh: &Mesh) {
        for triangle in mesh.corner_triangles().unwrap() {
            let corners = triangle.map(|c| mesh.corners[c as usize]);
            let [a, b, c] = corners.map(|c| wide(mesh.positions[c.position as usize]));
            let normal = (b - a).cross(c - a);
            assert!(normal.length() > 0.0, "a triangle has no area");
            for corner in corners {
                let n = wide(mesh.normals[corner.normal.unwrap() as usize]);
                assert!((n.length() - 1.0).abs() < 1e-6);
                assert!(n.dot(normal.normalize()) > 0.2, "normal {n} on a face towards {normal}");
            }
            let [p, q, r] = corners.map(|c| mesh.uvs[c.uv.unwrap() as usize].map(f64::from));
            let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            assert!(area > 0.0, "mirrored UVs");
            assert!([p, q, r].iter().flatten().all(|&x| (0.0..=1.0).contains(&x)));
        }
    }
}
