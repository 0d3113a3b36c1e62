//! What a part of an effect does alone: some of its wires, the others where they lie at rest.

use std::ops::Range;

use wirework_core::Wire;
use wirework_preset::Action;
use wirework_wrinkle::Pattern;

use super::Stage;
use crate::EvaluateError;

/// A part of an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Portion {
    /// Which effect, from 0.
    pub(crate) effect: usize,
    /// Which of its creases, or wires, from 0; all of them for what cannot be divided.
    pub(crate) lines: Range<usize>,
}

/// Takes a part, where the points were before its effect, and where the part alone has them.
pub(crate) type Take<'a> = dyn FnMut(Portion, &[[f32; 3]], &[[f32; 3]]) + 'a;

impl Stage {
    /// The parts of the effect, `most` at most: its creases or wires in their order, as many neighbours in each as in any other.
    pub(crate) fn portions(&self, most: usize) -> Vec<Portion> {
        let count = self.line_count();
        let parts = count.min(if self.lattice.is_some() { 1 } else { most }).max(1);
        let bound = |part: usize| part * count / parts;
        (0..parts).map(|part| Portion { effect: self.index, lines: bound(part)..bound(part + 1) }).collect()
    }

    /// Creases of a wrinkle as its pattern counts them, else wires.
    fn line_count(&self) -> usize {
        match &self.action {
            Action::Wrinkle(wrinkle) => match &wrinkle.pattern {
                Pattern::Drawn(curves) => curves.len(),
                Pattern::Tangential(layout) | Pattern::Radial(layout, _) | Pattern::Ripple(layout) => {
                    layout.creases as usize
                }
                // What is still to be looked for lays none.
                _ => 0,
            },
            _ => self.wires.len(),
        }
    }

    /// The points as one part of the effect moves them at the moment that was last worked out, into `out`.
    pub(crate) fn deform_portion(
        &mut self,
        portion: &Portion,
        out: &mut [[f32; 3]],
    ) -> Result<(), EvaluateError> {
        let last = self.line_count().saturating_sub(1);
        let lines: Vec<usize> = match &self.creases {
            Some(creases) => creases.lines().map(|line| line.min(last)).collect(),
            None => (0..self.wires.len()).collect(),
        };
        if self.lattice.is_some() {
            return Ok(());
        }
        let Some(binding) = &mut self.binding else { return Ok(()) };
        let mut wires = self.wires.clone();
        for (wire, line) in wires.iter_mut().zip(lines) {
            if !portion.lines.contains(&line) {
                rest(wire);
            }
        }
        let effect = self.index;
        binding.deform_into(&wires, &self.blend, out).map_err(|error| EvaluateError::Bind { effect, error })
    }
}

/// Takes all that it does from a wire. It stays an anchor for others.
fn rest(wire: &mut Wire) {
    wire.amplitude = 0.0;
    for locator in &mut wire.locators {
        locator.amplitude = locator.amplitude.map(|_| 0.0);
    }
}
