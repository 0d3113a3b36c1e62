//! The frame that a viewer interpolates on the rest, and the tangents that make it.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DMat3, DVec3};

use super::Corner;

/// A frame whose vectors span less than this has no inverse worth its name.
const FLAT: f64 = 1e-6;

/// Normal, tangent and bitangent at the corners of a triangle of the rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    normals: [DVec3; 3],
    tangents: [DVec3; 3],
    bitangents: [DVec3; 3],
    uvs: [[f64; 2]; 3],
}

impl Frame {
    /// None where texture coordinates span no area, or a corner has no tangent.
    pub(super) fn new(face: &[Corner; 3]) -> Option<Self> {
        let normals = face.map(|corner| wide(corner.normal).normalize_or_zero());
        let tangents = face.map(|corner| {
            let [x, y, z, _] = corner.tangent;
            wide([x, y, z]).normalize_or_zero()
        });
        let bitangents = [0, 1, 2].map(|k| {
            let sign = if face[k].tangent[3] < 0.0 { -1.0 } else { 1.0 };
            (normals[k].cross(tangents[k]) * sign).normalize_or_zero()
        });
        let uvs = face.map(|corner| corner.uv.map(f64::from));
        let new = Self { normals, tangents, bitangents, uvs };
        let area = double_area(&uvs);
        let whole = bitangents.iter().all(|b| *b != DVec3::ZERO);
        (area != 0.0 && area.is_finite() && whole).then_some(new)
    }

    /// Normal of the rest at texture coordinates, and the matrix from its tangent space to the world; none where that has no inverse.
    pub(super) fn at(&self, uv: [f64; 2]) -> Option<(DVec3, DMat3)> {
        let weights = weights(&self.uvs, uv)?;
        let [n, t, b] = [&self.normals, &self.tangents, &self.bitangents].map(|list| {
            (list[0] * weights[0] + list[1] * weights[1] + list[2] * weights[2]).normalize_or_zero()
        });
        let matrix = DMat3::from_cols(t, b, n);
        (matrix.determinant().abs() > FLAT).then_some((n, matrix))
    }
}

/// The shares of the corners of a triangle at a point of the plane: not below 0, for a sample may lie beyond an edge by a rounding, and 1 in
/// all. None where it has no area.
pub fn weights(corners: &[[f64; 2]; 3], p: [f64; 2]) -> Option<[f64; 3]> {
    let [a, b, c] = *corners;
    let all = [[p, b, c], [a, p, c], [a, b, p]].map(|t| double_area(&t));
    let sign = double_area(corners).signum();
    let all = all.map(|area| (area * sign).max(0.0));
    let sum: f64 = all.iter().sum();
    (sum > 0.0 && sum.is_finite()).then(|| all.map(|area| area / sum))
}

/// Twice the signed area of a triangle in the plane.
pub(super) fn double_area([a, b, c]: &[[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

pub(super) fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// The tangents that a glTF viewer computes where a file has none, at the corners of each triangle: `MikkTSpace`'s, with bitangents
/// that point *up* the map, against `v`. Zero where there is none. Lists are one entry a vertex.
///
/// # Panics
///
/// If an index is out of range of a list.
pub fn tangents(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    uvs: &[[f32; 2]],
    triangles: &[[u32; 3]],
) -> Vec<[[f32; 4]; 3]> {
    let out = vec![[[0.0; 4]; 3]; triangles.len()];
    let mut faces = Faces { positions, normals, uvs, triangles, out };
    // It refuses only what has no faces.
    drop(generate_tangents(&mut faces));
    faces.out
}

struct Faces<'a> {
    positions: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
    uvs: &'a [[f32; 2]],
    triangles: &'a [[u32; 3]],
    out: Vec<[[f32; 4]; 3]>,
}

impl Faces<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.triangles[face][corner] as usize
    }
}

impl Geometry for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // Upwards, so that bitangents are, too.
        let [u, v] = self.uvs[self.vertex(face, corner)];
        [u, 1.0 - v]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.out[face][corner] = space.map_or([0.0; 4], |space| space.tangent_encoded());
    }
}
