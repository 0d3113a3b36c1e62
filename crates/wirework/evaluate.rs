//! An effect on a surface, at any time.
//!
//! What can be done once is: points are bound when the evaluation is made, creases are laid then. Each effect works on the
//! result of the one before; it is bound again only where that result has changed. Its creases are laid once all the same,
//! on that result at 0 s, and stay on the same material of what moves below them; those that travel do so over that material.
//!
//! `units: Bounds` are parts of the object at rest, for all effects of a list alike. A lattice stays where it is, whatever the
//! effects before it have done to the object.

mod portions;

use std::time::{Duration, Instant};

use thiserror::Error;
use wirework_asset::AssetError;
use wirework_core::{BindError, Lattice, LatticeError, Wire};
use wirework_ik::IkError;
use wirework_preset::{Action, BoundsFrame, Effect, Units};
use wirework_surface::Bounds;
use wirework_wrinkle::{WrinkleError, WrinkleWarning};

use crate::fit::Fit;
use crate::limbs::bare_limbs;
use crate::mask::{EffectMasks, Masks};
use crate::posing::Posing;
use crate::stage::Stage;

/// Effects bound to the points of a surface.
///
/// ```
/// use wirework::{Evaluation, parse, preset::Limits, surface::grid};
///
/// let mesh = grid([2.0, 2.0], [8, 8], [0.0, 1.0, 0.0])?;
/// let text = "Deform(wires: [Wire(
///     curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]),
///     pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 1, 0), (1, 1, 0)])]),
///     radius: 0.5,
/// )])";
/// let preset = parse(text.as_bytes(), &Limits::default())?.preset;
///
/// let triangles = mesh.triangles()?;
/// let mut effect = Evaluation::new(&preset.effects, &mesh.positions, &triangles)?;
/// let mut points = mesh.positions.clone();
/// effect.at(0.25, &mut points)?;
/// assert_eq!(points[4 * 9 + 4], [0.0, 0.25, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Evaluation<'a> {
    points: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    pub(crate) stages: Vec<Stage>,
    /// What an effect works on that is not the first.
    base: Vec<[f32; 3]>,
    spent: Spent,
    /// The clip that poses what effects from the first limb on work on.
    pub(crate) posing: Option<Posing<'a>>,
    /// Of names and images that effects ask for.
    pub(crate) warnings: Vec<String>,
}

/// Time spent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Laying creases and binding points, and looking how the surface is compressed where that drives them.
    pub bind: Duration,
    /// Deforming points by wires and lattices, nothing else.
    pub deform: Duration,
}

/// Why an effect cannot be evaluated. Effects count from 0, in the order of their list.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// Points cannot be bound to the wires.
    #[error("effect {effect}: {error}")]
    Bind {
        /// Which effect.
        effect: usize,
        /// Why.
        error: BindError,
    },
    /// The creases cannot be laid on the surface.
    #[error("effect {effect}: {error}")]
    Wrinkle {
        /// Which effect.
        effect: usize,
        /// Why.
        error: WrinkleError,
    },
    /// Points cannot be bound to a lattice.
    #[error("effect {effect}: {error}")]
    Lattice {
        /// Which effect.
        effect: usize,
        /// Why.
        error: LatticeError,
    },
    /// A clip poses a chain so that it is no limb.
    #[error("effect {effect}: {error}")]
    Limb {
        /// Which effect.
        effect: usize,
        /// Why.
        error: IkError,
    },
    /// The clip that poses what effects work on is malformed.
    #[error("{0}")]
    Clip(Box<AssetError>),
    /// An effect counts in parts of an object that has no size.
    #[error(
        "effect {effect}: `units: Bounds` needs an object with an extent; all points of this one are at one place"
    )]
    NoExtent {
        /// Which effect.
        effect: usize,
    },
    /// An effect with `only` or `mask`, with pieces, with joints of a model or a goal on a curve is to be bound to bare points.
    #[error(
        "effect {effect} has `only`, `mask`, pieces, a skin's joints or a goal on a curve, which need more than points"
    )]
    Scoped {
        /// Which effect.
        effect: usize,
    },
    /// The buffer has another length than the surface has points.
    #[error("the surface has {points} points, the buffer holds {found}")]
    PointCount {
        /// Points of the surface.
        points: usize,
        /// Length of the buffer.
        found: usize,
    },
}

impl From<AssetError> for EvaluateError {
    fn from(error: AssetError) -> Self {
        Self::Clip(Box::new(error))
    }
}

impl EvaluateError {
    /// Which effect it is about, from 0; none where it is about none.
    pub fn effect(&self) -> Option<usize> {
        match self {
            Self::Bind { effect, .. }
            | Self::Wrinkle { effect, .. }
            | Self::Limb { effect, .. }
            | Self::Lattice { effect, .. }
            | Self::NoExtent { effect }
            | Self::Scoped { effect } => Some(*effect),
            Self::PointCount { .. } | Self::Clip(_) => None,
        }
    }
}

impl<'a> Evaluation<'a> {
    /// Binds effects to a surface: points in any order, triangles that index them (only wrinkles need any). Each effect after
    /// the first is worked out once, at 0 s, so that one that does not fit the one before it is found here.
    ///
    /// The effects of a preset are in its `effects`. Those with `only` or `mask`, stitches, and limbs whose joints or goals are a model's or travel a curve, need an asset:
    /// [`Subject::bind`](crate::Subject::bind) is for them. It also knows how long the effects last, which `settle` of a wrinkle
    /// needs that those before it drive; here that is driven by what they do at the same moment.
    pub fn new(
        effects: &[Effect],
        points: &'a [[f32; 3]],
        triangles: &'a [[u32; 3]],
    ) -> Result<Self, EvaluateError> {
        let scoped =
            |effect: &Effect| EffectMasks::wanted(effect) || matches!(effect.action, Action::Stitch(_));
        if let Some(effect) = effects.iter().position(scoped) {
            return Err(EvaluateError::Scoped { effect });
        }
        let bounds = Bounds::of(points);
        let fit = Fit { limbs: bare_limbs(effects, bounds)?, ..Fit::default() };
        Self::fitted(effects, fit, points, triangles, bounds)
    }

    /// The same with what effects have of a subject, and with the box that `units: Bounds` are parts of.
    pub(crate) fn fitted(
        effects: &[Effect],
        fit: Fit,
        points: &'a [[f32; 3]],
        triangles: &'a [[u32; 3]],
        bounds: Option<Bounds>,
    ) -> Result<Self, EvaluateError> {
        let frame = bounds_frame(bounds);
        let in_bounds = |effect: &Effect| effect.units == Units::Bounds;
        if let Some(effect) = effects.iter().position(in_bounds).filter(|_| !has_extent(&frame)) {
            return Err(EvaluateError::NoExtent { effect });
        }
        let Fit { masks: Masks { of_effects, warnings, missing: _ }, seams, limbs } = fit;
        let masks = of_effects.into_iter().chain(std::iter::repeat_with(EffectMasks::default));
        let seams = seams.into_iter().chain(std::iter::repeat_with(Vec::new));
        let mut limbs = limbs.into_iter();
        let mut stages: Vec<Stage> = Vec::with_capacity(effects.len());
        for (index, ((effect, masks), seams)) in effects.iter().zip(masks).zip(seams).enumerate() {
            let mut limb = limbs.next().flatten();
            // Seams that are sewn one after the other are a stage each.
            let sews = matches!(effect.action, Action::Stitch(_));
            let parts = if sews { seams.into_iter().map(Some).collect() } else { vec![None] };
            for seams in parts {
                let first = stages.is_empty();
                let fitted = (seams, limb.take());
                stages.push(Stage::new((index, first), effect, &frame, masks.clone(), fitted));
            }
        }
        let mut spent = Spent::default();
        if let Some(first) = stages.first_mut() {
            first.follow(0.0, (points, points), triangles, &mut spent)?;
        }
        let mut new = Self { points, triangles, stages, base: Vec::new(), spent, posing: None, warnings };
        if new.stages.len() > 1 {
            new.at(0.0, &mut points.to_vec())?;
            new.unasked();
        }
        Ok(new)
    }

    /// The points at `seconds`, into a buffer as long as the points are many. A point that nothing moves keeps its bits.
    pub fn at(&mut self, seconds: f64, out: &mut [[f32; 3]]) -> Result<(), EvaluateError> {
        if out.len() != self.points.len() {
            return Err(EvaluateError::PointCount { points: self.points.len(), found: out.len() });
        }
        self.before(usize::MAX, seconds, out)
    }

    /// The points as the effects before one move them. The buffer is as long as the points are many.
    pub(crate) fn before(
        &mut self,
        effect: usize,
        seconds: f64,
        out: &mut [[f32; 3]],
    ) -> Result<(), EvaluateError> {
        let posed = self.posed_from();
        if let Some(posing) = &mut self.posing {
            let start = Instant::now();
            posing.settle(seconds)?;
            self.stages.iter_mut().try_for_each(|stage| stage.follow_nodes(posing))?;
            self.spent.bind += start.elapsed();
        }
        let before = self.stages.iter_mut().take_while(|stage| stage.index < effect);
        for (number, stage) in before.enumerate() {
            if let Some(posing) = self.posing.as_mut().filter(|_| Some(number) == posed) {
                match number {
                    0 => out.copy_from_slice(posing.points()),
                    _ => posing.pose(seconds, out)?,
                }
            }
            let mut base = self.points;
            if number > 0 || posed == Some(0) {
                self.base.clear();
                self.base.extend_from_slice(out);
                base = &self.base;
            }
            stage.follow(seconds, (self.points, base), self.triangles, &mut self.spent)?;
            stage.deform(seconds, out, &mut self.spent)?;
        }
        Ok(())
    }

    /// Notes that nobody has asked for the moments so far.
    fn unasked(&mut self) {
        self.spent.deform = Duration::ZERO;
        self.stages.iter_mut().for_each(|stage| stage.reached = false);
    }

    /// One more than the number of the last effect that does something.
    pub(crate) fn effect_count(&self) -> usize {
        self.stages.last().map_or(0, |stage| stage.index + 1)
    }

    /// An effect, or the first part of one.
    fn stage(&self, effect: usize) -> Option<&Stage> {
        self.stages.iter().find(|stage| stage.index == effect)
    }

    /// Whether compression of the surface drives an effect.
    pub fn is_driven(&self) -> bool {
        self.stages.iter().any(Stage::is_driven)
    }

    /// The compression that drives an effect, where the points have moved to `now`; for [`Evaluation::record`].
    pub(crate) fn compression(&self, effect: usize, now: &[[f32; 3]]) -> Vec<f32> {
        self.stage(effect).map_or_else(Vec::new, |stage| stage.compression(now))
    }

    /// Tells each effect the compression that drives it, at equal steps from 0 s on. Without that an effect is driven by what the
    /// effects before it do: so are those behind a limb, which compresses more than a clip alone.
    pub(crate) fn record(&mut self, step: f64, readings: Vec<Vec<Vec<f32>>>) {
        let limb = self.stages.iter().find(|stage| stage.reach().is_some()).map(|stage| stage.index);
        for (effect, readings) in readings.into_iter().enumerate().take(limb.unwrap_or(usize::MAX)) {
            self.record_one(effect, step, readings);
        }
    }

    /// Whether an effect is driven by those before it, and is to be told of all moments of these.
    pub(crate) fn listens(&self, effect: usize) -> bool {
        self.stage(effect).is_some_and(Stage::listens)
    }

    /// Tells one effect the compression that drives it, as [`Evaluation::record`] does.
    pub(crate) fn record_one(&mut self, effect: usize, step: f64, readings: Vec<Vec<f32>>) {
        if let Some(stage) = self.stages.iter_mut().find(|stage| stage.index == effect) {
            stage.record(step, readings);
        }
    }

    /// Notes that with looking how the surface is compressed binding has taken so long in all; moments that were looked at for it were
    /// not asked for.
    pub(crate) fn sensed(&mut self, bind: Duration) {
        self.spent.bind = bind;
        self.unasked();
    }

    /// Notes that the surface has been made finer where effects ask for that.
    pub(crate) fn set_refined(&mut self) {
        self.stages.iter_mut().for_each(Stage::set_refined);
    }

    /// Whether an effect works on a surface that has been made finer for it.
    pub(crate) fn is_refined(&self, effect: usize) -> bool {
        self.stage(effect).is_some_and(Stage::is_refined)
    }

    /// The effects, from 0, whose creases the clip does not compress enough to raise them: the most there is, and when.
    pub(crate) fn unraised(&self) -> impl Iterator<Item = (usize, (f32, f64))> {
        self.stages.iter().filter_map(|stage| Some((stage.index, stage.unraised()?)))
    }

    /// What creases lack: each with its effect, from 0.
    pub(crate) fn crease_warnings(&self) -> impl Iterator<Item = (usize, &WrinkleWarning)> {
        self.stages.iter().flat_map(|stage| stage.warnings().map(move |w| (stage.index, w)))
    }

    /// The effects, from 0, that compression is to drive and that nothing tells of any.
    pub(crate) fn unmoved(&self) -> impl Iterator<Item = usize> {
        self.stages.iter().filter_map(|stage| stage.is_unmoved().then_some(stage.index))
    }

    /// How many wires there are, over all effects that were evaluated.
    pub fn wire_count(&self) -> usize {
        self.stages.iter().map(|stage| stage.wires.len()).sum()
    }

    /// The effects, from 0, that have been evaluated and have reached no point at any time.
    pub fn idle(&self) -> impl Iterator<Item = usize> {
        // An effect of several parts is idle where all of them are.
        let parts = self.stages.chunk_by(|a, b| a.index == b.index);
        parts.filter(|parts| parts.iter().all(|part| !part.reached)).map(|parts| parts[0].index)
    }

    /// The effects, from 0, with a lattice that does not hold all points they might move: its box, and how many points lay
    /// outside of it when they were last bound. These stay where they are.
    pub fn outside(&self) -> impl Iterator<Item = (usize, Lattice, usize)> {
        let outside = |stage: &Stage| {
            let (lattice, points) = stage.outside().filter(|(_, points)| *points > 0)?;
            Some((stage.index, lattice, points))
        };
        self.stages.iter().filter_map(outside)
    }

    /// Whether an effect has nothing that could move a point.
    pub(crate) fn is_inert(&self, effect: usize) -> bool {
        self.stage(effect).is_some_and(Stage::is_inert)
    }

    /// Whether an effect has a lattice in which no point lies.
    pub(crate) fn is_empty_lattice(&self, effect: usize) -> bool {
        self.stage(effect).is_some_and(Stage::is_empty_lattice)
    }

    /// The wires of all effects, as they were at the moment that was last worked out: those of a wrinkle along its creases.
    pub fn wires(&self) -> impl Iterator<Item = &Wire> {
        self.stages.iter().flat_map(|stage| &stage.wires)
    }

    /// What seams lack: each with its effect, from 0.
    pub(crate) fn seam_warnings(&self) -> impl Iterator<Item = (usize, String)> {
        let told = |stage: &Stage| -> Vec<(usize, String)> {
            stage.seam_warnings().into_iter().map(|warning| (stage.index, warning)).collect()
        };
        self.stages.iter().flat_map(told)
    }

    /// Points that are to be one where seams are welded, in groups, and how far they have come: 0 apart, 1 one point; at the moment that
    /// was last worked out.
    pub fn joints(&self) -> impl Iterator<Item = (&[u32], f32)> {
        self.stages.iter().flat_map(Stage::joints)
    }

    /// The lattices of effects, as they were then: control points along X, Y and Z, and where they are, X fastest.
    pub fn lattices(&self) -> impl Iterator<Item = ([usize; 3], &[[f32; 3]])> {
        self.stages.iter().filter_map(Stage::lattice)
    }

    /// The points at rest.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        self.points
    }

    /// The time spent so far.
    pub fn spent(&self) -> Spent {
        self.spent
    }
}

/// What `units: Bounds` are parts of; it has an extent or not.
pub(crate) fn bounds_frame(bounds: Option<Bounds>) -> BoundsFrame {
    bounds.map_or(BoundsFrame { center: [0.0; 3], size: 0.0 }, |bounds| BoundsFrame {
        center: bounds.center(),
        size: bounds.largest_side(),
    })
}

/// Whether there is a size to count in.
pub(crate) fn has_extent(frame: &BoundsFrame) -> bool {
    frame.size > 0.0 && frame.size.is_finite() && frame.center.iter().all(|c| c.is_finite())
}

#[cfg(test)]
#[path = "evaluate_tests.rs"]
mod tests;
