//! The space pictures are made in: the camera at the origin looking along −Z, X right, Y up, and the picture's height at
//! the camera's target as unit. Every tolerance is in that unit, so that a flea and a galaxy are drawn alike.

use glam::{DVec3, Vec3};

use crate::camera::Pose;
use crate::scene::Scene;
use crate::settings::FARTHEST;
use crate::{Camera, RenderError, Settings};

/// How far below its height the ground lies, so that what lies flat on it is not half in it.
const GROUND_GAP: f32 = 1.5e-3;

/// The way from the world to samples.
pub(crate) struct Space {
    pose: Pose,
    /// Samples from the middle to where the ray at 45 degrees meets the picture.
    pub(crate) focal: f32,
    /// The middle of the picture, samples.
    pub(crate) center: [f32; 2],
    /// Samples across and down.
    pub(crate) size: [usize; 2],
    /// The world's +Y.
    pub(crate) up: Vec3,
    /// The ground: the points whose product with `up` is this.
    pub(crate) ground: Option<f32>,
}

impl Space {
    pub(crate) fn new(
        camera: &Camera,
        settings: &Settings,
        ground: Option<f32>,
    ) -> Result<Self, RenderError> {
        let pose = camera.pose()?;
        let size = settings.size.map(|side| (side * settings.samples) as usize);
        let focal = (size[1] as f64 * 0.5 / pose.half) as f32;
        let center = size.map(|side| side as f32 * 0.5);
        let up = (pose.rotation * DVec3::Y).as_vec3();
        let ground = ground
            .map(|y| ((f64::from(y) - pose.eye.y) / pose.height) as f32 - GROUND_GAP)
            // Not seen from below, and then it should take no light away either.
            .filter(|&g| g < 0.0 && g > -FARTHEST);
        Ok(Self { pose, focal, center, size, up, ground })
    }

    /// A position of the world here.
    fn point(&self, p: [f32; 3]) -> Vec3 {
        (self.pose.rotation * (DVec3::from(p.map(f64::from)) - self.pose.eye) / self.pose.height).as_vec3()
    }

    /// Positions of the world here; refuses those too far away.
    pub(crate) fn points(
        &self,
        owner: &'static str,
        number: usize,
        points: &[[f32; 3]],
        out: &mut Vec<Vec3>,
    ) -> Result<(), RenderError> {
        let start = out.len();
        out.extend(points.iter().map(|&p| self.point(p)));
        match out[start..].iter().position(|p| p.abs().max_element() >= FARTHEST) {
            Some(index) => Err(RenderError::TooFar { owner, number, index }),
            None => Ok(()),
        }
    }

    /// A direction of the world here.
    fn direction(&self, d: [f32; 3]) -> Vec3 {
        let d = DVec3::from(d.map(f64::from));
        (self.pose.rotation * d).try_normalize().map_or(Vec3::ZERO, DVec3::as_vec3)
    }

    /// The direction through a sample, scaled to depth 1.
    pub(crate) fn ray(&self, x: f32, y: f32) -> Vec3 {
        Vec3::new((x - self.center[0]) / self.focal, (self.center[1] - y) / self.focal, -1.0)
    }

    /// Where a point in front of the camera is seen, in samples.
    pub(crate) fn project(&self, p: Vec3) -> [f32; 2] {
        let scale = self.focal / -p.z;
        [self.center[0] + p.x * scale, self.center[1] - p.y * scale]
    }

    /// The depth at which the ray meets the ground.
    pub(crate) fn ground_depth(&self, ray: Vec3) -> Option<f32> {
        let fall = self.up.dot(ray);
        let depth = self.ground? / fall;
        (fall < 0.0 && depth < FARTHEST).then_some(depth)
    }
}

/// All triangles of a scene in one list, in the space of the picture.
pub(crate) struct Geometry {
    pub(crate) positions: Vec<Vec3>,
    /// Unit, or zero where there is none.
    pub(crate) normals: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// For each part its first triangle and first vertex.
    pub(crate) starts: Vec<[u32; 2]>,
}

impl Geometry {
    pub(crate) fn new(scene: &Scene, space: &Space) -> Result<Self, RenderError> {
        let count = |of: fn(&crate::Part) -> usize| scene.parts.iter().map(of).sum();
        let vertices: usize = count(|p| p.positions.len());
        let mut geometry = Self {
            positions: Vec::with_capacity(vertices),
            normals: Vec::with_capacity(vertices),
            triangles: Vec::with_capacity(count(|p| p.triangles.len())),
            starts: Vec::with_capacity(scene.parts.len()),
        };
        for (number, part) in scene.parts.iter().enumerate() {
            let first = geometry.positions.len() as u32;
            geometry.starts.push([geometry.triangles.len() as u32, first]);
            space.points("part", number, &part.positions, &mut geometry.positions)?;
            geometry.normals.extend(
                part.normals
                    .iter()
                    .map(|&n| if n.iter().all(|c| c.is_finite()) { space.direction(n) } else { Vec3::ZERO }),
            );
            geometry.normals.resize(geometry.positions.len(), Vec3::ZERO);
            geometry.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        Ok(geometry)
    }

    pub(crate) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// The part a triangle is of.
    pub(crate) fn part(&self, triangle: u32) -> usize {
        self.starts.partition_point(|s| s[0] <= triangle).saturating_sub(1)
    }
}
