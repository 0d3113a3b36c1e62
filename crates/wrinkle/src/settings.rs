//! What a wrinkle is, as a preset says it.

use wirework_core::{Blend, Curve, Keyed};

use crate::{Curtain, Strain, WrinkleError};

/// Creases of a pattern at most, branches included: each has 8 spans at least.
pub(crate) const MOST_CREASES: usize = crate::creases::MOST_SPANS / 8;

/// The settings of a wrinkle. Lengths are in the unit of the surface. [`Wrinkle::new`] has the defaults.
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
    /// 0 as given, 1 the most jitter: each crease is shifted sideways by up to `thickness` (drawn) or two fifths of the
    /// distance to the next, loses up to half of its height, and up to a quarter of its length at either end. Default 0.
    pub randomness: f32,
    /// Of the jitter: the same seed gives the same creases. Default 0.
    pub seed: u64,
    /// Whether the creases move over the surface. Default [`Motion::Anchored`].
    pub motion: Motion,
    /// The part of its length that the folded cloth has lost, from 0 to below 1: heights are such that the folded cross-section
    /// is as long as it was before. Takes the place of `intensity`. Default none.
    pub compression: Option<f32>,
    /// Compression of the surface as what raises the creases: they have their height where and when the surface is pushed
    /// together across them. Default none: they stand at all times.
    pub drive: Option<Strain>,
    /// How creases that reach the same point become one displacement. Default that of wires.
    pub blend: Blend,
}

/// Where creases run. All but drawn ones are laid out on the surface, by geodesics from a centre, and wrap round it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pattern {
    /// Along given curves, dropped onto the surface by nearest point. The origin of each is its first end; a closed
    /// curve spreads from there both ways.
    Drawn(Vec<Drawn>),
    /// Parallel lines along the first axis, equally spread over the extent across; the origin of each is its end behind.
    Tangential(Layout),
    /// Lines from the centre out to half the extent along, the first along the first axis, with branches; their origin is the
    /// centre. The extent across is not used.
    Radial(Layout, Branches),
    /// Rings round the centre out to half the extent along; their origin is the centre. The extent across is not used.
    Ripple(Layout),
    /// Across the surface's own compression, where that is greatest in the course of its motion. [`Field`](crate::Field) makes drawn
    /// ones of it; until then there is nothing to lay. Needs a drive.
    Auto {
        /// Creases at most, at least 1.
        creases: u32,
    },
}

/// A curve that is dropped onto the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// The curve at 0 s.
    pub curve: Curve,
    /// Its control points, as many, where they move.
    pub points: Option<Keyed<Vec<[f32; 3]>>>,
}

/// Where a pattern lies and how large it is, measured on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Its middle: the point of the surface nearest to this.
    pub center: [f32; 3],
    /// Its first axis, laid into the surface; the second is normal × first.
    pub direction: [f32; 3],
    /// Extent along the first axis and across it, > 0.
    pub size: [f32; 2],
    /// Number of creases, at least 1.
    pub creases: u32,
}

/// Side branches of radial creases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Branches {
    /// Branches of a crease, and of each branch that has any.
    pub count: u32,
    /// How often branches branch; 0 none.
    pub depth: u32,
}

/// Whether creases move over the surface.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Motion {
    /// They stay.
    #[default]
    Anchored,
    /// Their references slide over the surface with them. Folds stop at a border.
    Travelling {
        /// Along and across, in units a second; of a ripple the first is outwards, and rings that leave come in again at the
        /// centre. Radial creases move with their centre, drawn ones each along itself and across.
        velocity: [f32; 2],
    },
    /// Their references stay, and the wires hang from their origins as ropes: \[SF98\] Figure 16. `intensity` lifts them off the
    /// surface besides. Branches hang from their stems, without pulling at them. Not for closed creases.
    Curtain(Box<Curtain>),
}

impl Motion {
    /// How fast creases travel along and across; what does not travel has no velocity.
    pub(crate) fn velocity(&self) -> [f64; 2] {
        match self {
            Self::Travelling { velocity } => velocity.map(f64::from),
            Self::Anchored | Self::Curtain(_) => [0.0; 2],
        }
    }
}

impl From<Curve> for Drawn {
    fn from(curve: Curve) -> Self {
        Self { curve, points: None }
    }
}

impl Drawn {
    /// The curve at a moment.
    pub(crate) fn at(&self, seconds: f64) -> Curve {
        let posed = self.points.as_ref().and_then(|points| self.curve.posed(points.at(seconds)).ok());
        posed.unwrap_or_else(|| self.curve.clone())
    }
}

impl Wrinkle {
    /// Creases along `curves`, everything else as by default.
    pub fn drawn(curves: Vec<Curve>) -> Self {
        Self::new(Pattern::Drawn(curves.into_iter().map(Drawn::from).collect()))
    }

    /// A pattern, everything else as by default.
    pub fn new(pattern: Pattern) -> Self {
        Self {
            pattern,
            thickness: Keyed::Constant(0.08),
            intensity: Keyed::Constant(0.05),
            stiffness: 0.3,
            resistance: 0.0,
            propagation: Keyed::Constant(1.0),
            randomness: 0.0,
            seed: 0,
            motion: Motion::default(),
            compression: None,
            drive: None,
            blend: Blend::default(),
        }
    }

    /// Refuses values out of range, patterns without creases and those with too many.
    pub fn check(&self) -> Result<(), WrinkleError> {
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
        if let Some(found) = self.compression.filter(|c| !(0.0..1.0).contains(c)) {
            let expected = "at least 0 and less than 1";
            return Err(WrinkleError::Value { field: "compression", expected, found });
        }
        if let Motion::Travelling { velocity } = self.motion
            && let Some(found) = velocity.into_iter().find(|v| !v.is_finite())
        {
            return Err(WrinkleError::Value { field: "velocity", expected: "finite", found });
        }
        if let Some(strain) = &self.drive {
            strain.check()?;
            if self.moves() {
                return Err(WrinkleError::DrivenMoves);
            }
        }
        if let Motion::Curtain(curtain) = &self.motion {
            curtain.check()?;
            let closed = |curves: &[Drawn]| curves.iter().any(|drawn| drawn.curve.closed());
            if matches!(&self.pattern, Pattern::Ripple(_))
                || matches!(&self.pattern, Pattern::Drawn(curves) if closed(curves))
            {
                return Err(WrinkleError::ClosedRopes);
            }
        }
        self.check_pattern()
    }

    fn check_pattern(&self) -> Result<(), WrinkleError> {
        let layout = match &self.pattern {
            Pattern::Drawn(curves) if curves.is_empty() => return Err(WrinkleError::NoCurves),
            Pattern::Drawn(_) => return Ok(()),
            Pattern::Auto { .. } if self.drive.is_none() => return Err(WrinkleError::Undriven),
            Pattern::Auto { creases: 0 } => return Err(WrinkleError::NoCreases),
            Pattern::Auto { .. } => return self.check_count(),
            Pattern::Tangential(layout) | Pattern::Radial(layout, _) | Pattern::Ripple(layout) => layout,
        };
        if layout.creases == 0 {
            return Err(WrinkleError::NoCreases);
        }
        for found in layout.size {
            if !(found > 0.0 && found.is_finite()) {
                return Err(WrinkleError::Value { field: "size", expected: "greater than 0", found });
            }
        }
        self.check_count()
    }

    fn check_count(&self) -> Result<(), WrinkleError> {
        let creases = self.crease_count();
        if creases > MOST_CREASES { Err(WrinkleError::TooMany { creases }) } else { Ok(()) }
    }

    /// How many creases the pattern has, branches included.
    pub fn crease_count(&self) -> usize {
        match &self.pattern {
            Pattern::Drawn(curves) => curves.len(),
            Pattern::Tangential(layout) | Pattern::Ripple(layout) => layout.creases as usize,
            Pattern::Auto { creases } => *creases as usize,
            Pattern::Radial(layout, branches) => {
                let mut each = 1_usize;
                for _ in 0..branches.depth.min(MOST_CREASES as u32) {
                    if branches.count == 0 || each > MOST_CREASES {
                        break;
                    }
                    each = each.saturating_mul(branches.count as usize).saturating_add(1);
                }
                each.saturating_mul(layout.creases as usize)
            }
        }
    }

    /// The length of each crease where the surface has room for it.
    pub(crate) fn lengths(&self) -> Vec<f64> {
        let count = self.crease_count();
        match &self.pattern {
            Pattern::Drawn(curves) => curves.iter().map(|drawn| f64::from(drawn.curve.length())).collect(),
            Pattern::Tangential(layout) => vec![f64::from(layout.size[0]); count],
            Pattern::Radial(layout, _) => vec![f64::from(layout.size[0]) / 2.0; count],
            Pattern::Auto { .. } => Vec::new(),
            Pattern::Ripple(layout) => {
                let outer = f64::from(layout.size[0]) * std::f64::consts::PI;
                (1..=count).map(|ring| outer * ring as f64 / count as f64).collect()
            }
        }
    }

    /// Whether the creases move over the surface.
    pub fn moves(&self) -> bool {
        let keyed =
            |drawn: &Drawn| drawn.points.as_ref().is_some_and(|points| points.values().nth(1).is_some());
        self.motion.velocity() != [0.0; 2]
            || matches!(&self.pattern, Pattern::Drawn(curves) if curves.iter().any(keyed))
    }

    /// Whether the height varies along a crease at any time.
    pub(crate) fn varies(&self) -> bool {
        self.resistance > 0.0 || self.drive.is_some() || self.propagation.values().any(|&p| p < 1.0)
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
