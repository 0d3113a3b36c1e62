//! How displacements turn the normals of a smooth surface that is given by flat triangles.
//!
//! The displacements are a field in space, and what a viewer shades is a smooth surface close to the triangles. So its tangents `t`,
//! perpendicular to the vertex's normal, become `t + ∂Δ/∂t`, the gradient that the triangles round the vertex have in their own
//! planes, weighted by angle; the normal now is perpendicular to those.
//!
//! # Notes
//!
//! The least rotation between the means of the triangles' normals, which is how normals of morph targets follow, was tried first.
//! Displacements along the normals of a coarse tube part at its edges; the strip between them has the
//! direction of the smooth normal, but next to the edge that is a turn by half of the angle between the sides: each crest had a
//! bright and a dark mark where it crossed an edge. Here such a strip is a stretch along the surface, and turns nothing.

use glam::DVec3;
use rayon::prelude::*;
use wirework_surface::Distinct;

use super::frame::wide;

/// A triangle whose area is less than this part of what its edges span has no plane.
const SLIVER: f64 = 1e-9;
/// A tangent of which less than this is left in a triangle's plane has no direction there.
const UPRIGHT: f64 = 1e-3;

/// What is to be added to the unit normals of a fine surface where its vertices move by `moved`, so that they are of length 1
/// again; exactly 0 where nothing round a vertex has moved otherwise than it. Vertices of one position and normal are one. Lists are one entry
/// a vertex.
///
/// # Panics
///
/// If lists are not equally long, or an index is out of range.
pub fn turned(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    triangles: &[[u32; 3]],
    moved: &[[f32; 3]],
) -> Vec<[f32; 3]> {
    let row = |i: usize| {
        let ([x, y, z], [u, v, w]) = (positions[i], normals[i]);
        [x, y, z, u, v, w]
    };
    let Distinct { of, first } = Distinct::new(positions.len(), row);
    let faces: Vec<Option<Face>> = triangles.par_iter().map(|t| Face::new(*t, positions, moved)).collect();
    let mut starts = vec![0_usize; first.len() + 1];
    for &vertex in triangles.as_flattened() {
        starts[of[vertex as usize] as usize + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut next = starts.clone();
    let mut fans = vec![(0_u32, 0_u8); triangles.len() * 3];
    for (face, triangle) in triangles.iter().enumerate() {
        for (corner, &vertex) in triangle.iter().enumerate() {
            let slot = &mut next[of[vertex as usize] as usize];
            fans[*slot] = (face as u32, corner as u8);
            *slot += 1;
        }
    }
    let one = |group: usize| {
        let normal = wide(normals[first[group] as usize]);
        let fan = fans[starts[group]..starts[group + 1]].iter();
        turn(
            normal,
            fan.filter_map(|&(face, corner)| Some((faces[face as usize].as_ref()?, corner as usize))),
        )
    };
    let groups: Vec<[f32; 3]> = (0..first.len()).into_par_iter().map(one).collect();
    of.par_iter().map(|&group| groups[group as usize]).collect()
}

/// A triangle, how it has moved, and the weights of its corners.
struct Face {
    /// Unit normal.
    normal: DVec3,
    /// The gradients of the shares of its second and third corner.
    gradients: [DVec3; 2],
    /// How far these have moved beyond the first.
    ways: [DVec3; 2],
    angles: [f64; 3],
}

impl Face {
    fn new(vertices: [u32; 3], positions: &[[f32; 3]], moved: &[[f32; 3]]) -> Option<Self> {
        let corners = vertices.map(|v| wide(positions[v as usize]));
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let n = e.cross(f);
        let square = n.length_squared();
        if square <= SLIVER * SLIVER * e.length_squared() * f.length_squared() || square == 0.0 {
            return None;
        }
        let [a, b, c] = vertices.map(|v| wide(moved[v as usize]));
        let angle = |k: usize| {
            let (e, f) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
            e.cross(f).length().atan2(e.dot(f))
        };
        Some(Self {
            normal: n / square.sqrt(),
            gradients: [f.cross(n) / square, n.cross(e) / square],
            ways: [b - a, c - a],
            angles: [0, 1, 2].map(angle),
        })
    }

    /// How displacements grow along a unit direction, as it lies in the triangle's plane.
    fn along(&self, direction: DVec3) -> DVec3 {
        let flat = direction - self.normal * self.normal.dot(direction);
        let length = flat.length();
        if length < UPRIGHT {
            return DVec3::ZERO;
        }
        let [b, c] = self.gradients.map(|gradient| gradient.dot(flat) / length);
        self.ways[0] * b + self.ways[1] * c
    }
}

fn turn<'a>(normal: DVec3, fan: impl Iterator<Item = (&'a Face, usize)>) -> [f32; 3] {
    let n = normal.normalize_or_zero();
    if n == DVec3::ZERO {
        return [0.0; 3];
    }
    let tangents: [DVec3; 2] = n.any_orthonormal_pair().into();
    let (mut sums, mut weight) = ([DVec3::ZERO; 2], 0.0);
    for (face, corner) in fan {
        let own = face.angles[corner];
        weight += own;
        for (sum, tangent) in sums.iter_mut().zip(tangents) {
            *sum += face.along(tangent) * own;
        }
    }
    if sums == [DVec3::ZERO; 2] {
        return [0.0; 3];
    }
    let [s, t] = [0, 1].map(|k| tangents[k] + sums[k] / weight);
    let now = s.cross(t).normalize_or_zero();
    // Where the surface is drawn to a line it has no side, and keeps the one that it had.
    if now == DVec3::ZERO { [0.0; 3] } else { (now - n).as_vec3().to_array() }
}
