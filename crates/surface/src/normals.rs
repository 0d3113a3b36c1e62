//! Normals that follow a deformation and keep the hard edges of the rest.
//!
//! A renderer's vertices split at texture seams and hard edges. Vertices with the same position and the same normal
//! form one *group*: they are one point of a smooth piece of the surface. A group has a computed normal, the mean
//! of the unit normals of all faces round its vertices, at rest and deformed; a vertex's new normal is the one it
//! had, turned by the least rotation between the two. So what the author chose is carried along, a neighbourhood
//! that has not moved keeps its bits, and the vertices of a group share their normal bit for bit.
//!
//! The faces are weighted by the angle they have *at rest* at the vertex. By angle, so that neither the size of the
//! triangles nor the way quads are cut matters; at rest, so that a frame needs no arc cosine, a face drawn to a
//! sliver keeps a bounded say, and weights cannot jump.
//!
//! Work is a pass over the faces, then a gather over the groups in a fixed order, then a pass over the
//! vertices; each result is written by one task alone, so any number of threads gives the same bits.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use thiserror::Error;

use crate::distinct::Distinct;
use crate::smooth::angles;
use crate::vector::wide;

/// Items a task takes at a time. Smaller spreads better, larger costs less; results do not depend on it.
pub(crate) const CHUNK: usize = 4096;

/// Where the cosine between the two computed normals is below this the rotation is found in f64: in f32 the formula
/// divides two numbers that have cancelled.
const WIDE_BELOW: f32 = -0.9;

/// Below this squared sine of its angle a triangle's normal is found in f64: in f32 it would be off by 1e-4.
const SLIVER: f32 = 1e-6;

/// Squared areas that are far from the ends of f32's range.
const SAFE: std::ops::Range<f32> = 1e-30..1e30;

/// Where the weighted sum of unit normals is shorter than the root of this, of angles of some radians, it is rounding.
const CANCELLED: f32 = 1e-10;

/// A sine below this is the rounding of unit vectors to f32, and any perpendicular is as good an axis.
const OPPOSITE: f64 = 1e-7;

/// The rest state of a model: its groups, and the faces round each.
#[derive(Clone, Debug)]
pub struct Normals {
    triangles: Vec<[u32; 3]>,
    rest: Vec<[f32; 3]>,
    group: Vec<u32>,
    /// Where the faces of each group start in `fans`, and where the last ends.
    fan_starts: Vec<u32>,
    /// `(face, weight)`.
    fans: Vec<(u32, f32)>,
    computed: Vec<[f32; 3]>,
}

/// What [`Normals::update_into`] works in; keep one for every task that calls it, so that frames allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct NormalsBuffer {
    faces: Vec<[f32; 3]>,
    groups: Vec<[f32; 3]>,
}

/// Why normals or tangents cannot be set up or updated.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NormalsError {
    /// A list has another length than there are vertices.
    #[error("{vertices} vertices need as many {what}, not {found}")]
    Length {
        /// `"positions"`, `"normals"`, `"tangents"` or `"texture coordinates"`.
        what: &'static str,
        /// Vertices of the model.
        vertices: usize,
        /// What was given.
        found: usize,
    },
    /// A triangle refers to a vertex that is not there.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {vertices}")]
    Index {
        /// The triangle, from 0.
        triangle: usize,
        /// The index that was used.
        vertex: u32,
        /// Vertices of the model.
        vertices: usize,
    },
}

impl Normals {
    /// From the rest positions, rest normals and triangles of all vertices of a model.
    ///
    /// Several primitives are one model, their vertices one after the other: a smooth surface cut into materials then
    /// stays smooth. Normals need not have length 1; they keep the length they have.
    pub fn new(
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, NormalsError> {
        let vertices = positions.len();
        check_length("normals", vertices, normals.len())?;
        check_indices(vertices, triangles)?;
        let (group, groups) = group(positions, normals);
        let (fan_starts, fans) = fans(positions, triangles, &group, groups);
        let mut model = Self {
            triangles: triangles.to_vec(),
            rest: normals.to_vec(),
            group,
            fan_starts,
            fans,
            computed: Vec::new(),
        };
        let mut buffer = NormalsBuffer::default();
        model.compute(positions, &mut buffer);
        model.computed = buffer.groups;
        Ok(model)
    }

    /// The normals of the deformed `positions`.
    ///
    /// A vertex keeps its rest normal, bit for bit, where nothing round it has moved, where it is in no face, and where
    /// the computed normal is zero or not finite, at rest or now.
    pub fn update_into(
        &self,
        positions: &[[f32; 3]],
        buffer: &mut NormalsBuffer,
        out: &mut [[f32; 3]],
    ) -> Result<(), NormalsError> {
        check_length("positions", self.rest.len(), positions.len())?;
        check_length("normals", self.rest.len(), out.len())?;
        self.compute(positions, buffer);
        let now = &buffer.groups;
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
            for (i, out) in out.iter_mut().enumerate() {
                let vertex = chunk * CHUNK + i;
                let group = self.group[vertex] as usize;
                *out = turn(self.rest[vertex], self.computed[group], now[group]);
            }
        });
        Ok(())
    }

    /// The computed normal of each group, zero where there is none, into `buffer.groups`.
    fn compute(&self, positions: &[[f32; 3]], buffer: &mut NormalsBuffer) {
        buffer.faces.resize(self.triangles.len(), [0.0; 3]);
        buffer.groups.resize(self.fan_starts.len().saturating_sub(1), [0.0; 3]);
        let faces = &mut buffer.faces;
        faces.par_iter_mut().zip(&self.triangles).with_min_len(CHUNK).for_each(|(face, triangle)| {
            *face = face_direction(triangle.map(|i| positions[i as usize]));
        });
        let faces = &buffer.faces;
        buffer.groups.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(group, out)| {
            let fan = self.fan_starts[group] as usize..self.fan_starts[group + 1] as usize;
            let sum: Vec3 = self.fans[fan].iter().map(|&(f, w)| Vec3::from(faces[f as usize]) * w).sum();
            *out = if sum.length_squared() > CANCELLED { sum.normalize_or_zero() } else { Vec3::ZERO }
                .to_array();
        });
    }
}

pub(crate) fn check_length(what: &'static str, vertices: usize, found: usize) -> Result<(), NormalsError> {
    if vertices == found { Ok(()) } else { Err(NormalsError::Length { what, vertices, found }) }
}

pub(crate) fn check_indices(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), NormalsError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(NormalsError::Index { triangle, vertex, vertices });
        }
    }
    Ok(())
}

/// A triangle's unit normal, zero where there is none. In f64 where f32 would cancel or leave its range.
fn face_direction([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let (e, f) = (Vec3::from(b) - Vec3::from(a), Vec3::from(c) - Vec3::from(a));
    let normal = e.cross(f);
    let (square, scale) = (normal.length_squared(), e.length_squared() * f.length_squared());
    if square > SLIVER * scale && SAFE.contains(&square) {
        return (normal / square.sqrt()).to_array();
    }
    let normal = (wide(b) - wide(a)).cross(wide(c) - wide(a));
    normal.normalize_or_zero().as_vec3().to_array()
}

/// The group of each vertex, numbered as they first occur, and how many there are.
fn group(positions: &[[f32; 3]], normals: &[[f32; 3]]) -> (Vec<u32>, usize) {
    let row = |i: usize| {
        let ([x, y, z], [u, v, w]) = (positions[i], normals[i]);
        [x, y, z, u, v, w]
    };
    let Distinct { of, first } = Distinct::new(positions.len(), row);
    (of, first.len())
}

/// The faces round each group, by rising face, with their angles at rest.
fn fans(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    group: &[u32],
    groups: usize,
) -> (Vec<u32>, Vec<(u32, f32)>) {
    let mut starts = vec![0_u32; groups + 1];
    for &vertex in triangles.iter().flatten() {
        starts[group[vertex as usize] as usize + 1] += 1;
    }
    for i in 0..groups {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut fans = vec![(0, 0.0); triangles.len() * 3];
    let at_rest =
        |triangle: &[u32; 3]| angles(triangle.map(|i| wide(positions[i as usize]))).map(|a| a as f32);
    let weights: Vec<[f32; 3]> = triangles.par_iter().with_min_len(CHUNK).map(at_rest).collect();
    for (face, (triangle, weights)) in triangles.iter().zip(weights).enumerate() {
        for (&vertex, weight) in triangle.iter().zip(weights) {
            let slot = &mut next[group[vertex as usize] as usize];
            fans[*slot as usize] = (face as u32, weight);
            *slot += 1;
        }
    }
    (starts, fans)
}

/// `normal` turned by the least rotation from the unit vector `from` to the unit vector `to`; unchanged where either
/// is zero. Opposite directions: half a turn about a fixed perpendicular.
pub(crate) fn turn(normal: [f32; 3], from: [f32; 3], to: [f32; 3]) -> [f32; 3] {
    if from == to || from == [0.0; 3] || to == [0.0; 3] {
        return normal;
    }
    let (n, a, b) = (Vec3::from(normal), Vec3::from(from), Vec3::from(to));
    let c = a.dot(b);
    let v = a.cross(b);
    let turned = if c > WIDE_BELOW {
        n * c + v.cross(n) + v * (v.dot(n) / (1.0 + c))
    } else {
        turn_far(wide(normal), wide(from), wide(to)).as_vec3()
    };
    if turned.is_finite() { turned.to_array() } else { normal }
}

/// The same for directions that are nearly opposite.
fn turn_far(n: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    let v = a.cross(b);
    let axis =
        if v.length() > OPPOSITE { v.normalize() } else { a.any_orthogonal_vector().normalize_or_zero() };
    let angle = v.length().atan2(a.dot(b));
    let (sin, cos) = angle.sin_cos();
    n * cos + axis.cross(n) * sin + axis * (axis.dot(n) * (1.0 - cos))
}

#[cfg(test)]
#[path = "normals_tests.rs"]
mod tests;
