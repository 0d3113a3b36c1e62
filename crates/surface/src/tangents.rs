//! Tangents that follow a deformation, for normal maps.
//!
//! A normal map is painted in a frame of normal, tangent and bitangent that its painter and its renderer must both have;
//! the frame nearly all of them have is that of `MikkTSpace` (Mikkelsen, *Simulation of Wrinkled Surfaces Revisited*, 2008):
//! the direction in which `u` grows on a triangle, `∂P/∂u = (Δv₂·e₁ − Δv₁·e₂) / (Δu₁Δv₂ − Δu₂Δv₁)`, is laid into the plane
//! of the vertex's normal at each corner, made a unit vector, weighted by the corner's angle, and summed round the vertex.
//!
//! Here that sum moves what the author has. Vertices of one position, normal and tangent form a *group*; a group has a
//! computed tangent at rest and one now, and its new tangent stands to normal and computed tangent of now as the old
//! one did to those of the rest. So where the author's tangents are Mikkelsen's, they stay Mikkelsen's; others,
//! such as those of turned texture coordinates, keep their angle to it. A rigid motion turns tangents exactly, what has
//! not moved keeps its bits, and a group shares its tangent bit for bit. Lengths and angles to the normal stay as well:
//! a unit tangent perpendicular to its normal is one afterwards. Handedness is no part of it: a continuous deformation
//! does not change it.
//!
//! # Deviations
//!
//! - `MikkTSpace` joins vertices of one position, normal and texture coordinates, then parts them by handedness. Groups know
//!   neither: where both sides of a texture seam or of a mirrored texture have one tangent at rest they have one afterwards.
//! - Angles are those of the rest, as for normals: no arc cosine a frame.
//!
//! # Notes
//!
//! Running `MikkTSpace` itself each frame was tried, by the crate `bevy_mikktspace`, which is the oracle of the tests: it is
//! serial, welds anew what has not changed, and its result belongs to corners, not vertices. On a sphere of half a million
//! vertices (one thread of a virtual core) it took 11 s a frame, this 0.30 s, [`Normals`](crate::Normals) 0.092 s. At rest both
//! agree to 0.01 degrees; on a torus, a sphere and a capped tube bent, twisted or waved, so that tangents turn by 30 to 140
//! degrees, to less than 0.1 in the mean of all vertices and 3.3 at the worst, at the rim of a cap.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::normals::{CHUNK, NormalsError, check_indices, check_length, turn};
use crate::vector::wide;

/// A direction whose part in the plane of the normal is shorter than the root of this stands on the plane: what is left of it is
/// rounding.
const UPRIGHT: f32 = 1e-10;

/// Where the weighted sum of unit directions is shorter than the root of this, of angles of some radians, they cancel.
const CANCELLED: f32 = 1e-10;

/// The group of vertices without a tangent.
const NO_GROUP: u32 = u32::MAX;

/// The rest state of a model: its groups, and the faces round each.
#[derive(Clone, Debug)]
pub struct Tangents {
    faces: Vec<Face>,
    /// Tangents at rest.
    rest: Vec<[f32; 3]>,
    group: Vec<u32>,
    groups: Vec<Group>,
    /// Where the faces of each group start in `fans`, and where the last ends.
    fan_starts: Vec<u32>,
    /// `(face, weight)`.
    fans: Vec<(u32, f32)>,
}

/// A triangle on which texture coordinates grow.
#[derive(Clone, Copy, Debug)]
struct Face {
    corners: [u32; 3],
    /// `u` grows along `e₁·a + e₂·b`.
    along: [f64; 2],
}

/// Vertices of one position, normal and tangent.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// One of them.
    vertex: u32,
    normal: [f32; 3],
    tangent: [f32; 3],
    /// The computed tangent at rest, zero where there is none.
    computed: [f32; 3],
}

/// What [`Tangents::update_into`] works in; keep one for every task that calls it, so that frames allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct TangentsBuffer {
    faces: Vec<[f32; 3]>,
    groups: Vec<[f32; 3]>,
}

impl Tangents {
    /// From the rest positions, rest normals, rest tangents (without handedness), texture coordinates and triangles of all
    /// vertices of a model; lists are one entry a vertex.
    ///
    /// A vertex whose tangent or normal is zero has no tangent. Several primitives are one model, their vertices one after the
    /// other, as for [`Normals`](crate::Normals). Coordinates that are not there can be all zero: then tangents turn with the
    /// normals. Which way `v` runs does not matter.
    ///
    /// # Errors
    ///
    /// A list of another length, an index out of range, more than 2³² − 2 vertices.
    pub fn new(
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        tangents: &[[f32; 3]],
        uvs: &[[f32; 2]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, NormalsError> {
        let vertices = positions.len();
        check_length("normals", vertices, normals.len())?;
        check_length("tangents", vertices, tangents.len())?;
        check_length("texture coordinates", vertices, uvs.len())?;
        check_indices(vertices, triangles)?;
        let (group, groups) = group(positions, normals, tangents);
        let has = |triangle: &&[u32; 3]| triangle.iter().any(|&v| group[v as usize] != NO_GROUP);
        let faces: Vec<Face> =
            triangles.iter().filter(has).filter_map(|&corners| Face::new(corners, uvs)).collect();
        let (fan_starts, fans) = fans(positions, normals, &faces, &group, groups.len());
        let mut model = Self { faces, rest: tangents.to_vec(), group, groups, fan_starts, fans };
        let mut buffer = TangentsBuffer::default();
        model.compute(positions, normals, &mut buffer, |_, computed, _| computed);
        for (group, computed) in model.groups.iter_mut().zip(buffer.groups) {
            group.computed = computed;
        }
        Ok(model)
    }

    /// The tangents of the deformed `positions`, whose deformed `normals` are those of
    /// [`Normals::update_into`](crate::Normals::update_into).
    ///
    /// A vertex keeps its rest tangent, bit for bit, where nothing round it has moved, and where its normal is zero. Where there is no
    /// computed tangent at rest or now (no face on which `u` grows, or directions that cancel) it turns with the normal.
    ///
    /// # Errors
    ///
    /// A list of another length than there are vertices.
    pub fn update_into(
        &self,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        buffer: &mut TangentsBuffer,
        out: &mut [[f32; 3]],
    ) -> Result<(), NormalsError> {
        let vertices = self.rest.len();
        check_length("positions", vertices, positions.len())?;
        check_length("normals", vertices, normals.len())?;
        check_length("tangents", vertices, out.len())?;
        self.compute(positions, normals, buffer, Group::carry);
        let now = &buffer.groups;
        let old = self.rest.par_iter().zip(&self.group);
        out.par_iter_mut().zip(old).with_min_len(CHUNK).for_each(|(out, (rest, &group))| {
            // Equal but for the sign of a zero: a vertex has its own.
            *out = *now.get(group as usize).filter(|now| *now != rest).unwrap_or(rest);
        });
        Ok(())
    }

    /// What `finish` makes of each group, its computed tangent (zero where there is none) and its normal, into
    /// `buffer.groups`.
    fn compute(
        &self,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        buffer: &mut TangentsBuffer,
        finish: impl Fn(&Group, [f32; 3], [f32; 3]) -> [f32; 3] + Sync,
    ) {
        buffer.faces.resize(self.faces.len(), [0.0; 3]);
        buffer.groups.resize(self.groups.len(), [0.0; 3]);
        let directions = &mut buffer.faces;
        directions.par_iter_mut().zip(&self.faces).with_min_len(CHUNK).for_each(|(direction, face)| {
            *direction = face.direction(positions);
        });
        let directions = &buffer.faces;
        let groups = buffer.groups.par_iter_mut().zip(&self.groups).enumerate().with_min_len(CHUNK);
        groups.for_each(|(index, (out, group))| {
            let fan = self.fan_starts[index] as usize..self.fan_starts[index + 1] as usize;
            let normal = normals[group.vertex as usize];
            let n = Vec3::from(normal).normalize_or_zero();
            let across = |d: Vec3| d - n * n.dot(d);
            let mut sum = Vec3::ZERO;
            for &(face, weight) in &self.fans[fan] {
                let d = across(Vec3::from(directions[face as usize]));
                let square = d.length_squared();
                if square > UPRIGHT {
                    sum += d * (weight / square.sqrt());
                }
            }
            let computed = if sum.length_squared() > CANCELLED {
                // Once more: what is left of a sum that nearly cancels is not quite in the plane.
                across(sum.normalize_or_zero()).normalize_or_zero()
            } else {
                Vec3::ZERO
            };
            *out = finish(group, computed.to_array(), normal);
        });
    }
}

impl Face {
    /// None where texture coordinates span no area.
    fn new(corners: [u32; 3], uvs: &[[f32; 2]]) -> Option<Self> {
        let [a, b, c] = corners.map(|v| uvs[v as usize].map(f64::from));
        let (du, dv) = ([b[0] - a[0], c[0] - a[0]], [b[1] - a[1], c[1] - a[1]]);
        let area = du[0] * dv[1] - du[1] * dv[0];
        let along = [dv[1] / area, -dv[0] / area];
        (area != 0.0 && along.iter().all(|x| x.is_finite())).then_some(Self { corners, along })
    }

    /// The unit direction in which `u` grows, zero where there is none. In f64: it is a difference of edges, and cancels on
    /// long triangles.
    fn direction(&self, positions: &[[f32; 3]]) -> [f32; 3] {
        let [a, b, c] = self.corners.map(|v| wide(positions[v as usize]));
        let direction = (b - a) * self.along[0] + (c - a) * self.along[1];
        direction.normalize_or_zero().as_vec3().to_array()
    }
}

impl Group {
    /// The tangent that stands to the computed tangent and the normal of now as the rest's does to those of the rest.
    fn carry(&self, computed: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
        if self.computed == computed && self.normal == normal {
            return self.tangent;
        }
        let [t, n, m] = [self.tangent, self.normal, normal].map(Vec3::from);
        let (n, m) = (n.normalize_or_zero(), m.normalize_or_zero());
        if m == Vec3::ZERO {
            return self.tangent;
        }
        let (c, d) = (Vec3::from(self.computed), Vec3::from(computed));
        if c == Vec3::ZERO || d == Vec3::ZERO {
            return turn(self.tangent, n.to_array(), m.to_array());
        }
        let carried = d * t.dot(c) + m.cross(d) * t.dot(n.cross(c)) + m * t.dot(n);
        if carried.is_finite() { carried.to_array() } else { self.tangent }
    }
}

/// The group of each vertex, numbered as they first occur, and the groups, not computed yet.
fn group(positions: &[[f32; 3]], normals: &[[f32; 3]], tangents: &[[f32; 3]]) -> (Vec<u32>, Vec<Group>) {
    let mut seen = HashMap::new();
    let mut groups = Vec::new();
    // Adding 0 makes −0 equal to 0.
    let bits = |v: [f32; 3]| v.map(|c| (c + 0.0).to_bits());
    let of = |vertex: usize| {
        let (normal, tangent) = (normals[vertex], tangents[vertex]);
        if tangent == [0.0; 3] || normal == [0.0; 3] {
            return NO_GROUP;
        }
        *seen.entry([positions[vertex], normal, tangent].map(bits)).or_insert_with(|| {
            groups.push(Group { vertex: vertex as u32, normal, tangent, computed: [0.0; 3] });
            groups.len() as u32 - 1
        })
    };
    ((0..positions.len()).map(of).collect(), groups)
}

/// The faces round each group, by rising face, with their angles at rest.
fn fans(
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    faces: &[Face],
    group: &[u32],
    groups: usize,
) -> (Vec<u32>, Vec<(u32, f32)>) {
    let of = |vertex: u32| Some(group[vertex as usize] as usize).filter(|&group| group < groups);
    let mut starts = vec![0_u32; groups + 1];
    for group in faces.iter().flat_map(|face| face.corners).filter_map(of) {
        starts[group + 1] += 1;
    }
    for i in 0..groups {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut fans = vec![(0, 0.0); starts[groups] as usize];
    for (index, face) in faces.iter().enumerate() {
        let corners = face.corners.map(|v| wide(positions[v as usize]));
        for (k, &vertex) in face.corners.iter().enumerate() {
            let Some(slot) = of(vertex).and_then(|group| next.get_mut(group)) else { continue };
            let normal = wide(normals[vertex as usize]).normalize_or_zero();
            let edges = [corners[(k + 1) % 3], corners[(k + 2) % 3]].map(|p| p - corners[k]);
            fans[*slot as usize] = (index as u32, angle_about(normal, edges) as f32);
            *slot += 1;
        }
    }
    (starts, fans)
}

/// The angle between two edges as they look along a unit normal, radians.
fn angle_about(normal: DVec3, edges: [DVec3; 2]) -> f64 {
    let [e, f] = edges.map(|e| e - normal * normal.dot(e));
    e.cross(f).length().atan2(e.dot(f))
}

#[cfg(test)]
#[path = "tangents_tests.rs"]
mod tests;
