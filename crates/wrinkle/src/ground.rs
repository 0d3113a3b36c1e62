//! The surface under the creases.

use glam::DVec3;
use wirework_surface::{Nearest, NearestError, Step, Terrain};

use crate::{SurfaceView, WrinkleError};

/// A surface ready to receive creases.
#[derive(Debug)]
pub(crate) struct Ground {
    pub(crate) nearest: Nearest,
    pub(crate) terrain: Terrain,
}

/// A point of the surface and the outward direction there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footing {
    pub(crate) position: DVec3,
    /// Of length 1.
    pub(crate) normal: DVec3,
    /// Where that is on the surface, however it moves.
    pub(crate) anchor: Anchor,
}

/// A point of a surface by its material: a triangle, and the weights of its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub(crate) triangle: u32,
    pub(crate) weights: [f64; 3],
}

impl Anchor {
    pub(crate) fn of(step: &Step) -> Self {
        Self { triangle: step.triangle, weights: step.weights }
    }

    /// The corner that is not there or not finite, if there is one.
    pub(crate) fn check(&self, surface: &SurfaceView<'_>) -> Result<(), NearestError> {
        let triangle = self.triangle as usize;
        let corners = surface.triangles.get(triangle).ok_or(NearestError::NoFaces)?;
        let good =
            |v: &&u32| surface.positions.get(**v as usize).is_some_and(|p| p.iter().all(|c| c.is_finite()));
        match corners.iter().find(|v| !good(v)) {
            Some(&vertex) => Err(NearestError::Vertex { triangle, vertex }),
            None => Ok(()),
        }
    }
}

impl Ground {
    pub(crate) fn new(surface: &SurfaceView<'_>) -> Result<Self, WrinkleError> {
        Ok(Self {
            nearest: Nearest::new(surface.positions, surface.triangles)?,
            terrain: Terrain::new(surface.positions, surface.triangles)?,
        })
    }

    /// The nearest point of the surface; `None` only where `p` is out of range.
    pub(crate) fn step(&self, p: DVec3) -> Option<Step> {
        let hit = self.nearest.nearest(p.as_vec3().to_array())?;
        Some(self.terrain.step(&hit))
    }

    /// What stands at a point of the surface; `None` where it has no normal.
    pub(crate) fn footing(&self, step: &Step) -> Option<Footing> {
        let normal = self.terrain.normal_at(step)?;
        let position = DVec3::from(step.position);
        Some(Footing { position, normal: DVec3::from(normal), anchor: Anchor::of(step) })
    }

    /// The same where the surface has moved to `positions`.
    pub(crate) fn footing_on(&self, anchor: &Anchor, positions: &[[f32; 3]]) -> Option<Footing> {
        let (position, normal) = self.terrain.moved(anchor.triangle, anchor.weights, positions)?;
        Some(Footing { position: DVec3::from(position), normal: DVec3::from(normal), anchor: *anchor })
    }

    /// How far a point is from the surface.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        let hit = self.nearest.nearest(p.as_vec3().to_array());
        hit.map_or(f64::INFINITY, |hit| f64::from(hit.distance))
    }
}

pub(crate) fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}
