//! What a wrinkle is, as a preset says it, and what can be wrong with it.

use thiserror::Error;
use wirework_core::{Blend, Curve, Keyed};
use wirework_surface::NearestError;

/// The settings of a wrinkle. Lengths are in the unit of the surface. [`Wrinkle::drawn`] has the defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrinkle {
    /// Where the creases run.
    pub pattern: Pattern,
    /// Half the width of a crease: how far its influence reaches, > 0. Default 0.08.
    pub thickness: Keyed<f32>,
    /// Height of the crest over the undeformed surface; negative makes a groove. Default 0.05.
    pub intensity: Keyed<f32>,
    /// 0 a sharp crease, 0.5 the paper's quartic, 1 a broad fold; the height stays. Default 0.3.
    pub stiffness: f32,
    /// 0 full height all along, 1 dies out towards the far end. Default 0.
    pub resistance: f32,
    /// How far the front has come, as a fraction of each crease: 0 nothing moves, 1 all of it stands. Default 1.
    pub propagation: Keyed<f32>,
    /// 0 as given, 1 the most jitter: each crease is shifted sideways by up to `thickness`, loses up to half of its
    /// height, and up to a quarter of its length at either end. Default 0.
    pub randomness: f32,
    /// Of the jitter: the same seed gives the same creases. Default 0.
    pub seed: u64,
    /// How creases that reach the same point become one displacement. Default that of wires.
    pub blend: Blend,
}

/// Where creases run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pattern {
    /// Along given curves, dropped onto the surface by nearest point. The origin of each is its first end; a closed
    /// curve spreads from there both ways.
    Drawn(Vec<Curve>),
}

impl Wrinkle {
    /// Creases along `curves`, everything else as by default.
    pub fn drawn(curves: Vec<Curve>) -> Self {
        Self {
            pattern: Pattern::Drawn(curves),
            thickness: Keyed::Constant(0.08),
            intensity: Keyed::Constant(0.05),
            stiffness: 0.3,
            resistance: 0.0,
            propagation: Keyed::Constant(1.0),
            randomness: 0.0,
            seed: 0,
            blend: Blend::default(),
        }
    }

    pub(crate) fn check(&self) -> Result<(), WrinkleError> {
        for &found in self.thickness.values() {
            if !(found > 0.0 && found.is_finite()) {
                return Err(WrinkleError::Value { field: "thickness", expected: "greater than 0", found });
            }
        }
        for &found in self.intensity.values() {
            if !found.is_finite() {
                return Err(WrinkleError::Value { field: "intensity", expected: "finite", found });
            }
        }
        let single =
            [("stiffness", self.stiffness), ("resistance", self.resistance), ("randomness", self.randomness)];
        let keyed = self.propagation.values().map(|&found| ("propagation", found));
        for (field, found) in single.into_iter().chain(keyed) {
            if !(0.0..=1.0).contains(&found) {
                return Err(WrinkleError::Value { field, expected: "between 0 and 1", found });
            }
        }
        let Pattern::Drawn(curves) = &self.pattern;
        if curves.is_empty() { Err(WrinkleError::NoCurves) } else { Ok(()) }
    }

    /// Whether the height varies along a crease at any time.
    pub(crate) fn varies(&self) -> bool {
        self.resistance > 0.0 || self.propagation.values().any(|&p| p < 1.0)
    }
}

/// The surface that is wrinkled, at rest.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceView<'a> {
    /// Positions of its vertices. Equal positions are one point of the surface.
    pub positions: &'a [[f32; 3]],
    /// Its faces, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
}

/// Why there are no creases.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WrinkleError {
    /// A setting is out of range.
    #[error("`{field}` must be {expected}, not {found}")]
    Value {
        /// Its name.
        field: &'static str,
        /// What it must be.
        expected: &'static str,
        /// A value it has or takes.
        found: f32,
    },
    /// There is nothing to wrinkle, or the surface refers to vertices that are not there.
    #[error(transparent)]
    Surface(#[from] NearestError),
    /// The creases are so many and so thin that following them all would take for ever.
    #[error(
        "creases of thickness {thickness} need {needed} spans in all, the most are {}: use a larger `thickness` or \
         fewer curves",
        crate::crease::MOST_SPANS
    )]
    TooFine {
        /// The least thickness.
        thickness: f32,
        /// Spans they would have.
        needed: usize,
    },
    /// The pattern has no curves.
    #[error("a drawn pattern needs at least one curve")]
    NoCurves,
    /// No point of a drawn curve comes as near to the surface as the curve is long: it was drawn for something else.
    #[error("curve {curve} is {length} long but nowhere nearer to the surface than {distance}")]
    TooFar {
        /// Which curve, from 0.
        curve: usize,
        /// Its least distance from the surface.
        distance: f32,
        /// Its length.
        length: f32,
    },
    /// A drawn curve becomes a point on the surface.
    #[error("curve {curve} comes down on the surface as a point")]
    Collapsed {
        /// Which curve, from 0.
        curve: usize,
    },
    /// There is no outside where a crease should rise: only triangles without area.
    #[error("the surface has no normal where curve {curve} lies")]
    NoNormal {
        /// Which curve, from 0.
        curve: usize,
    },
}
