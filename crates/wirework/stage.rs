//! One effect of a list, bound to the result of the one before.

use std::time::Instant;

use wirework_core::{BindError, Binding, Blend, Lattice, LatticeBinding, Wire};
use wirework_preset::{Action, BoundsFrame, Effect};
use wirework_wrinkle::{Creases, SurfaceView, creases};

use crate::mask::EffectMasks;
use crate::weld::bits;
use crate::{EvaluateError, Spent};

/// One effect of a list.
#[derive(Debug)]
pub(crate) struct Stage {
    index: usize,
    /// What it does, in metres.
    action: Action,
    blend: Blend,
    masks: EffectMasks,
    pub(crate) wires: Vec<Wire>,
    /// The creases as they were laid at 0 s.
    laid: Option<Creases>,
    /// The creases where they are now, if the surface moves.
    moved: Option<Creases>,
    /// Of the points, or else of the lattice's control points.
    binding: Option<Binding>,
    lattice: Option<Ffd>,
    /// The points it is bound to; kept only where they may change.
    bound_to: Vec<[f32; 3]>,
    /// Whether it has reached a point at any time that was asked for.
    pub(crate) reached: bool,
}

/// \[SF98\] §6, Figure 21: a lattice that wires move, and that moves the points.
#[derive(Debug)]
struct Ffd {
    lattice: Lattice,
    binding: Option<LatticeBinding>,
    /// Its control points where they are now.
    controls: Vec<[f32; 3]>,
}

impl Stage {
    pub(crate) fn new(index: usize, effect: &Effect, frame: &BoundsFrame, masks: EffectMasks) -> Self {
        let action = effect.placed(frame).action;
        let (blend, lattice) = match &action {
            Action::Deform(deform) => (deform.blend, deform.lattice),
            Action::Wrinkle(wrinkle) => (wrinkle.blend, None),
        };
        let ffd = |lattice: Lattice| Ffd { lattice, binding: None, controls: Vec::new() };
        Self {
            index,
            action,
            blend,
            masks,
            wires: Vec::new(),
            laid: None,
            moved: None,
            binding: None,
            lattice: lattice.map(ffd),
            bound_to: Vec::new(),
            reached: false,
        }
    }

    /// Binds the effect to `base`, what it works on at `seconds`; does nothing where it is bound to that already.
    pub(crate) fn follow(
        &mut self,
        seconds: f64,
        base: &[[f32; 3]],
        triangles: &[[u32; 3]],
        spent: &mut Spent,
    ) -> Result<(), EvaluateError> {
        let same = |(a, b): (&[f32; 3], &[f32; 3])| bits(*a) == bits(*b);
        if self.binding.is_some()
            && self.bound_to.len() == base.len()
            && self.bound_to.iter().zip(base).all(same)
        {
            return Ok(());
        }
        self.bind(seconds, base, triangles, spent)?;
        self.bound_to.clear();
        self.bound_to.extend_from_slice(base);
        Ok(())
    }

    pub(crate) fn bind(
        &mut self,
        seconds: f64,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        spent: &mut Spent,
    ) -> Result<(), EvaluateError> {
        let start = Instant::now();
        let effect = self.index;
        if let Action::Wrinkle(wrinkle) = &self.action {
            let surface = SurfaceView { positions: points, triangles };
            let fail = |error| EvaluateError::Wrinkle { effect, error };
            match &self.laid {
                None => self.laid = Some(creases(&surface, wrinkle).map_err(fail)?),
                Some(laid) => self.moved = Some(laid.moved(&surface).map_err(fail)?),
            }
        }
        self.move_wires(seconds);
        let fail = |error| EvaluateError::Bind { effect, error };
        match &mut self.lattice {
            None => {
                let masks = self.masks.of_wires(self.wires.len());
                self.binding = Some(Binding::masked(&self.wires, points, &masks).map_err(fail)?);
            }
            Some(ffd) => {
                // The control points at rest stay where they are, whatever the object does.
                if self.binding.is_none() {
                    ffd.controls = ffd.lattice.points();
                    self.binding = Some(Binding::new(&self.wires, &ffd.controls).map_err(fail)?);
                }
                let bound = LatticeBinding::new(&ffd.lattice, points, self.masks.of_effect());
                ffd.binding = Some(bound.map_err(|error| EvaluateError::Lattice { effect, error })?);
            }
        }
        spent.bind += start.elapsed();
        Ok(())
    }

    fn move_wires(&mut self, seconds: f64) {
        match &self.action {
            Action::Deform(deform) if self.wires.is_empty() => {
                self.wires = deform.wires.iter().map(|wire| wire.at(seconds)).collect();
            }
            Action::Deform(deform) => {
                for (keyed, wire) in deform.wires.iter().zip(&mut self.wires) {
                    keyed.at_into(seconds, wire);
                }
            }
            Action::Wrinkle(_) => {
                if let Some(creases) = self.moved.as_ref().or(self.laid.as_ref()) {
                    creases.wires_at(seconds, &mut self.wires);
                }
            }
        }
    }

    /// The points as the effect moves them at `seconds`, into `out`.
    pub(crate) fn deform(
        &mut self,
        seconds: f64,
        out: &mut [[f32; 3]],
        spent: &mut Spent,
    ) -> Result<(), EvaluateError> {
        self.move_wires(seconds);
        let Some(binding) = &mut self.binding else { return Ok(()) };
        let start = Instant::now();
        let effect = self.index;
        let fail = |error: BindError| EvaluateError::Bind { effect, error };
        match &mut self.lattice {
            None => binding.deform_into(&self.wires, &self.blend, out).map_err(fail)?,
            Some(Ffd { binding: bound, controls, .. }) => {
                binding.deform_into(&self.wires, &self.blend, controls).map_err(fail)?;
                if let Some(bound) = bound {
                    bound
                        .deform_into(controls, out)
                        .map_err(|error| EvaluateError::Lattice { effect, error })?;
                }
            }
        }
        spent.deform += start.elapsed();
        self.reached = self.reached || (binding.reaches() && !self.is_empty_lattice());
        Ok(())
    }

    /// The lattice's control points along each axis, and where they are.
    pub(crate) fn lattice(&self) -> Option<([usize; 3], &[[f32; 3]])> {
        self.lattice.as_ref().map(|ffd| (ffd.lattice.size(), ffd.controls.as_slice()))
    }

    /// Whether there is a lattice that holds no point.
    pub(crate) fn is_empty_lattice(&self) -> bool {
        let bound = self.lattice.as_ref().and_then(|ffd| ffd.binding.as_ref());
        bound.is_some_and(|bound| bound.held() == 0)
    }

    /// The lattice, and how many points that it might move lie outside of it.
    pub(crate) fn outside(&self) -> Option<(Lattice, usize)> {
        let ffd = self.lattice.as_ref()?;
        Some((ffd.lattice, ffd.binding.as_ref()?.outside()))
    }
}
