//! An effect on a surface, at any time.
//!
//! What can be done once is: points are bound when the evaluation is made, creases are laid then. In a stack each
//! effect works on the result of the one before; it is bound again only where that result has changed. Its creases are
//! laid once all the same, on that result at 0 s, and stay on the same material of what moves below them.

use std::time::{Duration, Instant};

use thiserror::Error;
use wirework_core::{BindError, Binding, Blend, Wire};
use wirework_preset::Effect;
use wirework_wrinkle::{Creases, SurfaceView, WrinkleError, creases};

use crate::weld::bits;

/// An effect bound to the points of a surface.
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
/// let mut effect = Evaluation::new(&preset.effect, &mesh.positions, &triangles)?;
/// let mut points = mesh.positions.clone();
/// effect.at(0.25, &mut points)?;
/// assert_eq!(points[4 * 9 + 4], [0.0, 0.25, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Evaluation<'a> {
    points: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    stages: Vec<Stage<'a>>,
    /// What the effect of a stack works on that is not the first.
    base: Vec<[f32; 3]>,
    spent: Spent,
}

/// Time spent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Laying creases and binding points.
    pub bind: Duration,
    /// Deforming points by wires, nothing else.
    pub deform: Duration,
}

/// Why an effect cannot be evaluated. Effects count from 0, in the order of their stack.
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
    /// The buffer has another length than the surface has points.
    #[error("the surface has {points} points, the buffer holds {found}")]
    PointCount {
        /// Points of the surface.
        points: usize,
        /// Length of the buffer.
        found: usize,
    },
}

impl<'a> Evaluation<'a> {
    /// Binds an effect to a surface: points in any order, triangles that index them (only wrinkles need any). A stack is
    /// worked out once, at 0 s, so that an effect that does not fit the one before it is found here.
    pub fn new(
        effect: &'a Effect,
        points: &'a [[f32; 3]],
        triangles: &'a [[u32; 3]],
    ) -> Result<Self, EvaluateError> {
        let mut stages = Vec::new();
        flatten(effect, &mut stages);
        let mut spent = Spent::default();
        if let Some(first) = stages.first_mut() {
            first.bind(0.0, points, triangles, &mut spent)?;
        }
        let mut new = Self { points, triangles, stages, base: Vec::new(), spent };
        if new.stages.len() > 1 {
            new.at(0.0, &mut points.to_vec())?;
            // Nobody has asked for a moment yet.
            new.spent.deform = Duration::ZERO;
            new.stages.iter_mut().for_each(|stage| stage.reached = false);
        }
        Ok(new)
    }

    /// The points at `seconds`, into a buffer as long as the points are many. A point that nothing moves keeps its bits.
    pub fn at(&mut self, seconds: f64, out: &mut [[f32; 3]]) -> Result<(), EvaluateError> {
        if out.len() != self.points.len() {
            return Err(EvaluateError::PointCount { points: self.points.len(), found: out.len() });
        }
        for (index, stage) in self.stages.iter_mut().enumerate() {
            let base = if index == 0 {
                self.points
            } else {
                self.base.clear();
                self.base.extend_from_slice(out);
                &self.base
            };
            if index > 0 && !stage.is_bound_to(base) {
                stage.bind(seconds, base, self.triangles, &mut self.spent)?;
                stage.bound_to.clear();
                stage.bound_to.extend_from_slice(base);
            }
            stage.deform(seconds, out, &mut self.spent)?;
        }
        Ok(())
    }

    /// How many wires there are, over all effects that were evaluated.
    pub fn wire_count(&self) -> usize {
        self.stages.iter().map(|stage| stage.wires.len()).sum()
    }

    /// The effects, from 0, that have been evaluated and have reached no point at any time.
    pub fn idle(&self) -> impl Iterator<Item = usize> {
        let idle = |(index, stage): (usize, &Stage<'_>)| (!stage.reached).then_some(index);
        self.stages.iter().enumerate().filter_map(idle)
    }

    /// The time spent so far.
    pub fn spent(&self) -> Spent {
        self.spent
    }
}

/// One effect of a stack.
#[derive(Debug)]
struct Stage<'a> {
    index: usize,
    effect: &'a Effect,
    blend: Blend,
    wires: Vec<Wire>,
    /// The creases as they were laid at 0 s.
    laid: Option<Creases>,
    /// The creases where they are now, if the surface moves.
    moved: Option<Creases>,
    binding: Option<Binding>,
    /// The points it is bound to; kept only where they may change.
    bound_to: Vec<[f32; 3]>,
    reached: bool,
}

/// The effects of nested stacks in their order.
fn flatten<'a>(effect: &'a Effect, stages: &mut Vec<Stage<'a>>) {
    let blend = match effect {
        Effect::Stack(effects) => return effects.iter().for_each(|effect| flatten(effect, stages)),
        Effect::Deform(deform) => deform.blend,
        Effect::Wrinkle(wrinkle) => wrinkle.blend,
    };
    stages.push(Stage {
        index: stages.len(),
        effect,
        blend,
        wires: Vec::new(),
        laid: None,
        moved: None,
        binding: None,
        bound_to: Vec::new(),
        reached: false,
    });
}

impl Stage<'_> {
    fn is_bound_to(&self, points: &[[f32; 3]]) -> bool {
        let same = |(a, b): (&[f32; 3], &[f32; 3])| bits(*a) == bits(*b);
        self.binding.is_some()
            && self.bound_to.len() == points.len()
            && self.bound_to.iter().zip(points).all(same)
    }

    fn bind(
        &mut self,
        seconds: f64,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        spent: &mut Spent,
    ) -> Result<(), EvaluateError> {
        let start = Instant::now();
        if let Effect::Wrinkle(wrinkle) = self.effect {
            let surface = SurfaceView { positions: points, triangles };
            let fail = |error| EvaluateError::Wrinkle { effect: self.index, error };
            match &self.laid {
                None => self.laid = Some(creases(&surface, wrinkle).map_err(fail)?),
                Some(laid) => self.moved = Some(laid.moved(&surface).map_err(fail)?),
            }
        }
        self.move_wires(seconds);
        let bound = Binding::new(&self.wires, points);
        self.binding = Some(bound.map_err(|error| EvaluateError::Bind { effect: self.index, error })?);
        spent.bind += start.elapsed();
        Ok(())
    }

    fn move_wires(&mut self, seconds: f64) {
        match self.effect {
            Effect::Deform(deform) if self.wires.is_empty() => {
                self.wires = deform.wires.iter().map(|wire| wire.at(seconds)).collect();
            }
            Effect::Deform(deform) => {
                for (keyed, wire) in deform.wires.iter().zip(&mut self.wires) {
                    keyed.at_into(seconds, wire);
                }
            }
            Effect::Wrinkle(_) => {
                if let Some(creases) = self.moved.as_ref().or(self.laid.as_ref()) {
                    creases.wires_at(seconds, &mut self.wires);
                }
            }
            Effect::Stack(_) => {}
        }
    }

    fn deform(&mut self, seconds: f64, out: &mut [[f32; 3]], spent: &mut Spent) -> Result<(), EvaluateError> {
        self.move_wires(seconds);
        let Some(binding) = &mut self.binding else { return Ok(()) };
        let start = Instant::now();
        let result = binding.deform_into(&self.wires, &self.blend, out);
        spent.deform += start.elapsed();
        self.reached |= binding.pair_count() > 0;
        result.map_err(|error| EvaluateError::Bind { effect: self.index, error })
    }
}

#[cfg(test)]
mod tests {
    use wirework_preset::{Limits, Preset, parse};
    use wirework_surface::grid;

    use super::*;

    const RAISED: &str =
        "curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 0.5, pose: [(-1, 1, 0), (1, 1, 0)]";
    const RISING: &str = "curve: Polyline(points: [(-1, 1, 0), (1, 1, 0)]), radius: 0.5, \
                          pose: Keys([(0, [(-1, 1, 0), (1, 1, 0)]), (1, [(-1, 2, 0), (1, 2, 0)])])";

    fn stack(first: &str, second: &str) -> Preset {
        let text =
            format!("Stack([Deform(wires: [Wire({first})]), Stack([Deform(wires: [Wire({second})])])])");
        parse(text.as_bytes(), &Limits::default()).unwrap().preset
    }

    /// The height of the middle at each time, and whether anything was bound after the first.
    fn heights(preset: &Preset, times: &[f64]) -> (Vec<f32>, bool) {
        let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
        let mut effect = Evaluation::new(&preset.effect, &mesh.positions, &[]).unwrap();
        let mut out = mesh.positions.clone();
        let mut bound = Vec::new();
        let mut at = |&time: &f64| {
            effect.at(time, &mut out).unwrap();
            bound.push(effect.spent().bind);
            out[12][1]
        };
        let heights = times.iter().map(&mut at).collect();
        (heights, bound.first() != bound.last())
    }

    #[test]
    fn a_stack_binds_again_only_where_the_result_before_has_changed() {
        let (found, again) = heights(&stack(RAISED, RISING), &[0.0, 0.5, 1.0]);
        assert_eq!((found, again), (vec![1.0, 1.5, 2.0], false));
        // Before 1 s the first effect has not come to where the second lies; then it has left the ground.
        let down =
            "curve: Polyline(points: [(-1, 2, 0), (1, 2, 0)]), radius: 0.5, pose: [(-1, 5, 0), (1, 5, 0)]";
        let rising = RISING.replace("(-1, 1, 0), (1, 1, 0)", "(-1, 0, 0), (1, 0, 0)");
        let (found, again) = heights(&stack(&rising, down), &[0.0, 0.5, 1.0]);
        assert_eq!((found, again), (vec![0.0, 1.0, 5.0], true));
    }

    #[test]
    fn a_crease_stays_on_its_material_when_the_surface_moves() {
        // All of the grid goes sideways, across the crease, and up: a wire with a radius far beyond it, moved as a whole.
        let wrinkle =
            "Wrinkle(pattern: Drawn([Polyline(points: [(-0.8, 0, 0), (0.8, 0, 0)])]), thickness: 0.2)";
        let carry = "Deform(wires: [Wire(curve: Polyline(points: [(-2, 0, 0), (2, 0, 0)]), radius: 1e6, \
                     pose: Keys([(0, [(-2, 0, 0), (2, 0, 0)]), (1, [(-2, 0.25, 0.5), (2, 0.25, 0.5)])]))])";
        let read = |text: &str| parse(text.as_bytes(), &Limits::default()).unwrap().preset;
        let (alone, stack) = (read(wrinkle), read(&format!("Stack([{carry}, {wrinkle}])")));
        let mesh = grid([2.0, 2.0], [32, 32], [0.0, 1.0, 0.0]).unwrap();
        let triangles = mesh.triangles().unwrap();
        let mut want = mesh.positions.clone();
        Evaluation::new(&alone.effect, &mesh.positions, &triangles).unwrap().at(0.0, &mut want).unwrap();
        assert!(want[16 * 33 + 16][1] > 0.049, "there is a crest in the middle");
        // The still of a moment must not depend on the moments before it.
        for times in [&[0.0, 0.5, 1.0][..], &[1.0], &[0.5, 1.0, 0.0]] {
            let mut effect = Evaluation::new(&stack.effect, &mesh.positions, &triangles).unwrap();
            let mut out = mesh.positions.clone();
            for &t in times {
                effect.at(t, &mut out).unwrap();
                let way = [0.0, 0.25 * t as f32, 0.5 * t as f32];
                for (i, (found, want)) in out.iter().zip(&want).enumerate() {
                    let off = (0..3).map(|a| (found[a] - want[a] - way[a]).abs()).fold(0.0, f32::max);
                    assert!(off < 2e-5, "vertex {i} at {t} s of {times:?}: {found:?}, {off} off");
                }
            }
        }
    }

    #[test]
    fn effects_that_reach_nothing_are_named_and_buffers_checked() {
        let far = RAISED.replace("0, 0)", "9, 9)").replace("1, 0)", "9, 9)");
        let preset = stack(&far, RAISED);
        let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
        let mut effect = Evaluation::new(&preset.effect, &mesh.positions, &[]).unwrap();
        let mut out = mesh.positions.clone();
        effect.at(0.0, &mut out).unwrap();
        assert_eq!(effect.idle().collect::<Vec<_>>(), [0]);
        assert_eq!(effect.wire_count(), 2);
        assert_eq!(effect.at(0.0, &mut out[1..]), Err(EvaluateError::PointCount { points: 25, found: 24 }));
    }
}
