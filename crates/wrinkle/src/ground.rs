//! The surface under the creases.

use glam::DVec3;
use wirework_surface::{Nearest, NearestError, Step, Terrain};

use crate::{SurfaceView, WrinkleError};

/// Triangles that the creases of a moment may cross: a second of work, which travelling ones take in each frame. Five that have gone
/// sixty metres over edges of two millimetres cross a fifth of that.
pub(crate) const MOST_CROSSINGS: f64 = (1 << 20) as f64;
/// Triangles that the rays of a ripple may cross, once for all frames: a few seconds, and half a gigabyte.
pub(crate) const MOST_CROSSINGS_OF_RAYS: f64 = (1 << 22) as f64;

/// A surface ready to receive creases.
#[derive(Debug)]
pub(crate) struct Ground {
    pub(crate) nearest: Nearest,
    pub(crate) terrain: Terrain,
    /// The side of a square as large as its triangles are in the mean: the way between two edges of a line over it.
    spacing: f64,
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
        let nearest = Nearest::new(surface.positions, surface.triangles)?;
        let terrain = Terrain::new(surface.positions, surface.triangles)?;
        let area = |triangle: u32| {
            let [a, b, c] = terrain.corners_of(triangle).map(DVec3::from);
            (b - a).cross(c - a).length() / 2.0
        };
        let area: f64 = (0..surface.triangles.len() as u32).map(area).sum();
        if area == 0.0 {
            return Err(WrinkleError::NoArea);
        }
        let spacing = (area / surface.triangles.len() as f64).sqrt();
        Ok(Self { nearest, terrain, spacing })
    }

    /// Refuses so many lines of a length where to walk them all would take for ever: on a surface without an end, such as a
    /// sphere, they go round and round.
    pub(crate) fn check_walks(&self, lines: usize, length: f64, most: f64) -> Result<(), WrinkleError> {
        let crossings = lines as f64 * length / self.spacing;
        if crossings > most {
            return Err(WrinkleError::TooLong { lines, length: length as f32 });
        }
        Ok(())
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
