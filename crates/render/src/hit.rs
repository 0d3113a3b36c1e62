//! The surface that a sample sees, rebuilt from the triangle's number.
//!
//! The ray through the sample is met with the triangle in space, so that normals and texture coordinates come out with
//! perspective, whatever the triangle was cut into on the screen.

use glam::Vec3;

use crate::raster::{NONE, Seen};
use crate::scene::Scene;
use crate::space::{Geometry, Space};

/// The owner of samples that see the ground.
pub(crate) const GROUND: u32 = u32::MAX;
/// Rays start this far over the surface, times the depth where that is above 1: further than rounding, nearer than any
/// fold that can be seen.
const LIFT: f32 = 1e-4;
/// How far a ray's start may move off a triangle towards the smooth surface it stands for, in parts of the triangle's
/// longest edge. A well-cut sphere needs an eighth at most; more would let light into corners.
const BULGE: f32 = 0.15;

/// A point of a surface, seen.
#[derive(Clone, Copy)]
pub(crate) struct Hit {
    pub(crate) position: Vec3,
    /// The shading normal, unit, facing the camera.
    pub(crate) normal: Vec3,
    /// The triangle's own normal, unit, on the same side.
    pub(crate) face: Vec3,
    /// Where rays start.
    pub(crate) origin: Vec3,
    /// The part, or [`GROUND`].
    pub(crate) owner: u32,
    /// The corners' shares.
    pub(crate) weights: [f32; 3],
    /// The triangle, or [`NONE`].
    pub(crate) triangle: u32,
}

/// What can be seen, and from where.
#[derive(Clone, Copy)]
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) geometry: &'a Geometry,
    pub(crate) space: &'a Space,
    /// Samples along a pixel's side.
    pub(crate) samples: usize,
}

impl Stage<'_> {
    /// What is seen at a place of the picture (in samples): the triangle found there or the ground before it.
    pub(crate) fn hit(&self, seen: Seen, [x, y]: [f32; 2]) -> Option<Hit> {
        let ray = self.space.ray(x, y);
        let ground = self.space.ground_depth(ray).filter(|depth| 1.0 / depth > seen.nearness);
        if let Some(depth) = ground {
            let (position, normal) = (ray * depth, self.space.up);
            let origin = position + normal * LIFT * depth.max(1.0);
            return Some(Hit {
                position,
                normal,
                face: normal,
                origin,
                owner: GROUND,
                weights: [0.0; 3],
                triangle: NONE,
            });
        }
        (seen.triangle != NONE).then(|| self.surface(seen.triangle, ray))
    }

    fn surface(&self, triangle: u32, ray: Vec3) -> Hit {
        let [a, b, c] = self.geometry.corners(triangle);
        let (e1, e2) = (b - a, c - a);
        let weights = meet(ray, a, e1, e2);
        let position = a + e1 * weights[1] + e2 * weights[2];
        let toward = (-position).normalize_or(Vec3::Z);
        let mut face = e1.cross(e2).normalize_or(toward);
        let normals = self.geometry.triangles[triangle as usize].map(|v| self.geometry.normals[v as usize]);
        let mut normal = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
        if normals.contains(&Vec3::ZERO) || normal.length_squared() < 1e-6 {
            normal = face;
        }
        normal = normal.normalize_or(face);
        // The normals know the outside better than the winding.
        let winding = if face.dot(normal) < 0.0 { -1.0 } else { 1.0 };
        let side = if (face * winding).dot(toward) < 0.0 { -1.0 } else { 1.0 };
        face *= winding * side;
        normal *= side;
        // A smooth normal may turn away from the camera near the silhouette; light would leak from behind.
        let away = normal.dot(toward);
        if away < 0.0 {
            normal = (normal - toward * away).normalize_or(face);
        }
        // The triangle stands for a surface that bulges over it: without this, coarse meshes show their facets where
        // light grazes them. (J. Hanika, "Hacking the Shadow Terminator", 2021.)
        let mut lifted = position;
        for ((corner, n), weight) in [a, b, c].into_iter().zip(normals).zip(weights) {
            let n = n * side;
            lifted -= n * (weight * (position - corner).dot(n).min(0.0));
        }
        let reach = BULGE * e1.length().max(e2.length()).max((c - b).length());
        let bulge = (lifted - position).clamp_length_max(reach);
        let origin = position + bulge + face * LIFT * position.z.abs().max(1.0);
        let owner = self.geometry.part(triangle) as u32;
        Hit { position, normal, face, origin, owner, weights, triangle }
    }
}

/// The shares of the corners `a`, `a + e1`, `a + e2` where a ray from the origin meets their plane, moved into the triangle.
pub(crate) fn meet(ray: Vec3, a: Vec3, e1: Vec3, e2: Vec3) -> [f32; 3] {
    let r = ray.cross(a);
    let det = -ray.dot(e1.cross(e2));
    let (u, v) = ((e2.dot(r) / det).clamp(0.0, 1.0), (-e1.dot(r) / det).clamp(0.0, 1.0));
    let over = (u + v).max(1.0);
    let (u, v) = (u / over, v / over);
    // Seen exactly from its edge.
    if u.is_finite() && v.is_finite() { [1.0 - u - v, u, v] } else { [1.0 / 3.0; 3] }
}
