//! A polygon mesh with shared positions, as OBJ has it.

use thiserror::Error;

use crate::triangulate::Triangulator;

/// Polygons over shared positions, texture coordinates and normals; without faces a set of points.
///
/// Each position stands once, however many corners use it, so that deforming `positions` can open no seam.
/// The fields are public, so a mesh may be wrong: what reads one calls [`Mesh::check`] first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Texture coordinates, referred to by [`Corner::uv`]; may be empty. `v` points up, as in OBJ.
    pub uvs: Vec<[f32; 2]>,
    /// Unit normals, referred to by [`Corner::normal`]; may be empty.
    pub normals: Vec<[f32; 3]>,
    /// The corners of all faces, one face after the other, counter-clockwise seen from outside.
    pub corners: Vec<Corner>,
    /// Where each face ends in `corners`: face `i` is `corners[face_ends[i − 1] .. face_ends[i]]`.
    pub face_ends: Vec<u32>,
}

/// One corner of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    /// Index into [`Mesh::positions`].
    pub position: u32,
    /// Index into [`Mesh::uvs`].
    pub uv: Option<u32>,
    /// Index into [`Mesh::normals`].
    pub normal: Option<u32>,
}

/// What is wrong with a mesh.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A position, texture coordinate or normal is NaN or infinite.
    #[error("{what} {index} is not finite")]
    NotFinite {
        /// `"position"`, `"uv"` or `"normal"`.
        what: &'static str,
        /// Which one, from 0.
        index: usize,
    },
    /// A corner refers to a position, texture coordinate or normal that is not there.
    #[error("a corner of face {face} refers to {what} {index}, but there are {count}")]
    Index {
        /// The face, from 0.
        face: usize,
        /// `"position"`, `"uv"` or `"normal"`.
        what: &'static str,
        /// The index that was used.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A face has fewer than three corners.
    #[error("face {face} has {corners} corners, not three or more")]
    FaceSize {
        /// The face, from 0.
        face: usize,
        /// Its corners.
        corners: usize,
    },
    /// The face ends fall, or do not end where the corners end.
    #[error("the faces end at corner {faces}, the corners at {corners}")]
    FaceEnds {
        /// The end of the first face that is wrong, or of the last face.
        faces: u32,
        /// The number of corners.
        corners: usize,
    },
}

impl Mesh {
    /// Refuses indices out of range, faces of fewer than three corners and numbers that are not finite.
    pub fn check(&self) -> Result<(), MeshError> {
        finite("position", &self.positions)?;
        finite("uv", &self.uvs)?;
        finite("normal", &self.normals)?;
        let mut start = 0;
        for (face, &end) in self.face_ends.iter().enumerate() {
            if end < start || end as usize > self.corners.len() {
                return Err(MeshError::FaceEnds { faces: end, corners: self.corners.len() });
            }
            if end - start < 3 {
                return Err(MeshError::FaceSize { face, corners: (end - start) as usize });
            }
            for corner in &self.corners[start as usize..end as usize] {
                self.check_corner(face, *corner)?;
            }
            start = end;
        }
        if start as usize != self.corners.len() {
            return Err(MeshError::FaceEnds { faces: start, corners: self.corners.len() });
        }
        Ok(())
    }

    fn check_corner(&self, face: usize, corner: Corner) -> Result<(), MeshError> {
        for (what, index, count) in [
            ("position", Some(corner.position), self.positions.len()),
            ("uv", corner.uv, self.uvs.len()),
            ("normal", corner.normal, self.normals.len()),
        ] {
            if let Some(index) = index.filter(|&i| i as usize >= count) {
                return Err(MeshError::Index { face, what, index, count });
            }
        }
        Ok(())
    }

    /// The corners of each face in turn. A face whose ends are wrong ([`Mesh::check`]) is empty.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[Corner]> {
        (0..self.face_ends.len()).map(|face| {
            let start = if face == 0 { 0 } else { self.face_ends[face - 1] as usize };
            self.corners.get(start..self.face_ends[face] as usize).unwrap_or(&[])
        })
    }

    /// The faces as triangles of indices into [`Mesh::corners`].
    ///
    /// A face of `n` corners gives `n − 2` triangles with its orientation, one face after the other in the order
    /// of the faces. Every corner of a face stands in at least one of them. Strictly convex faces are fans from
    /// their first corner; others are cut in the plane of their mean normal.
    pub fn corner_triangles(&self) -> Result<Vec<[u32; 3]>, MeshError> {
        self.check()?;
        let mut triangles = Vec::with_capacity(self.corners.len().saturating_sub(2 * self.face_ends.len()));
        let mut triangulator = Triangulator::default();
        let mut start = 0;
        for face in self.faces() {
            let polygon = face.iter().map(|c| self.positions[c.position as usize]);
            triangulator.triangulate(polygon, start, &mut triangles);
            start += face.len() as u32;
        }
        Ok(triangles)
    }

    /// The triangles of [`Mesh::corner_triangles`], in the same order, as indices into [`Mesh::positions`].
    pub fn triangles(&self) -> Result<Vec<[u32; 3]>, MeshError> {
        let mut triangles = self.corner_triangles()?;
        for triangle in &mut triangles {
            *triangle = triangle.map(|corner| self.corners[corner as usize].position);
        }
        Ok(triangles)
    }
}

fn finite<const N: usize>(what: &'static str, values: &[[f32; N]]) -> Result<(), MeshError> {
    match values.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
        Some(index) => Err(MeshError::NotFinite { what, index }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(position: u32) -> Corner {
        Corner { position, uv: None, normal: None }
    }

    fn square() -> Mesh {
        Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            corners: (0..4).map(corner).collect(),
            face_ends: vec![4],
            ..Mesh::default()
        }
    }

    #[test]
    fn faces_become_fans_in_their_order() {
        let mut mesh = square();
        mesh.corners.extend([corner(3), corner(2), corner(0)]);
        mesh.face_ends.push(7);
        assert_eq!(mesh.corner_triangles().unwrap(), [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
        assert_eq!(mesh.triangles().unwrap(), [[0, 1, 2], [0, 2, 3], [3, 2, 0]]);
        assert_eq!(mesh.faces().map(<[Corner]>::len).collect::<Vec<_>>(), [4, 3]);
    }

    #[test]
    fn wrong_indices_are_errors_and_never_panics() {
        let mut mesh = square();
        mesh.corners[2].position = 9;
        assert_eq!(mesh.triangles(), Err(MeshError::Index { face: 0, what: "position", index: 9, count: 4 }));
        let mut mesh = square();
        mesh.corners[0].uv = Some(0);
        assert_eq!(mesh.check(), Err(MeshError::Index { face: 0, what: "uv", index: 0, count: 0 }));
        let mut mesh = square();
        mesh.corners[3].normal = Some(u32::MAX);
        assert!(matches!(mesh.check(), Err(MeshError::Index { what: "normal", .. })));
        for ends in [vec![3], vec![5], vec![4, 4], vec![4, 2], vec![2, 4], vec![]] {
            let mesh = Mesh { face_ends: ends, ..square() };
            assert!(mesh.triangles().is_err(), "{:?}", mesh.face_ends);
            assert_eq!(mesh.faces().count(), mesh.face_ends.len());
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_errors() {
        let mut mesh = square();
        mesh.positions[1][2] = f32::NAN;
        assert_eq!(mesh.check(), Err(MeshError::NotFinite { what: "position", index: 1 }));
        let mesh = Mesh { uvs: vec![[0.0, f32::INFINITY]], ..square() };
        assert_eq!(mesh.check(), Err(MeshError::NotFinite { what: "uv", index: 0 }));
    }

    #[test]
    fn an_empty_mesh_and_a_point_set_have_no_triangles() {
        assert_eq!(Mesh::default().triangles(), Ok(vec![]));
        let points = Mesh { positions: vec![[1.0; 3]; 3], ..Mesh::default() };
        assert_eq!(points.triangles(), Ok(vec![]));
    }
}
