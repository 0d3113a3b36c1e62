//! One effect of a list, bound to the result of the one before.

mod portion;

use std::time::Instant;

use wirework_core::{BindError, Binding, Blend, Lattice, LatticeBinding, Weights, WeightsError, Wire};
use wirework_preset::{Action, BoundsFrame, Deform, Effect};
use wirework_stitch::Surfaces;
use wirework_surface::Near;
use wirework_wrinkle::{Creases, SurfaceView, WrinkleWarning, creases};

use crate::limbs::Reach;
use crate::mask::{EffectMasks, WireMask};
use crate::posing::Posing;
use crate::sew::Part;
use crate::weld::bits;
use crate::{EvaluateError, Spent};

pub(crate) use portion::{Portion, Take};

/// One effect of a list.
#[derive(Debug)]
pub(crate) struct Stage {
    /// Which effect it is, or a part of.
    pub(crate) index: usize,
    base: Base,
    /// What it does, in metres.
    action: Action,
    blend: Blend,
    masks: EffectMasks,
    pub(crate) wires: Vec<Wire>,
    creases: Option<Creases>,
    seams: Option<Part>,
    reach: Option<Reach>,
    /// What each crease, or the wire along each edge, may move.
    near: Vec<Near>,
    /// Whether a clip, or the effects before over all their time, have told how the surface is compressed.
    told: bool,
    fineness: Fineness,
    /// That edges are too long for the folds, where they are longest at the moments so far.
    coarse: Option<WrinkleWarning>,
    /// Of the points, or else of the lattice's control points.
    binding: Option<Binding>,
    lattice: Option<Ffd>,
    /// The points it is bound to; kept only where they may change.
    bound_to: Vec<[f32; 3]>,
    /// Whether it has reached a point at any time that was asked for.
    pub(crate) reached: bool,
}

/// What a stage works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Base {
    /// The rest, which never changes.
    Rest,
    /// What the effects before it make of that, or a clip.
    Result,
    /// What a clip poses together with the joints of a limb: that keeps to the feet of the rest.
    Posed,
}

/// Whether its surface is made finer where it needs that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fineness {
    /// It is as it is.
    AsItIs,
    /// It is to be, or could not be.
    Wanted,
    /// It has been.
    Made,
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
    /// An effect, or the part of it that `seams` are: which it is, and whether it is the first of all.
    pub(crate) fn new(
        (index, on_rest): (usize, bool),
        effect: &Effect,
        frame: &BoundsFrame,
        masks: EffectMasks,
        (seams, reach): (Option<Part>, Option<Reach>),
    ) -> Self {
        let action = effect.placed(frame).action;
        let (blend, lattice) = match &action {
            Action::Deform(deform) => (deform.blend, deform.lattice),
            Action::Wrinkle(wrinkle) => (wrinkle.blend, None),
            Action::Ik(_) => (Blend::default(), None),
            Action::Stitch(_) => {
                (seams.as_ref().map_or_else(Blend::default, |part| part.seams.blend()), None)
            }
        };
        let ffd = |lattice: Lattice| Ffd { lattice, binding: None, controls: Vec::new() };
        Self {
            index,
            base: if on_rest { Base::Rest } else { Base::Result },
            action,
            blend,
            masks,
            wires: Vec::new(),
            creases: None,
            near: seams.as_ref().map_or_else(Vec::new, |part| part.seams.near().to_vec()),
            seams,
            reach,
            told: false,
            fineness: if effect.refine { Fineness::Wanted } else { Fineness::AsItIs },
            coarse: None,
            binding: None,
            lattice: lattice.map(ffd),
            bound_to: Vec::new(),
            reached: false,
        }
    }

    fn on_rest(&self) -> bool {
        self.base == Base::Rest
    }

    /// Binds the effect to `base`, what it works on at `seconds`, where the points were at `rest` before all effects; does nothing where
    /// it is bound to that already and its references stay. What the first effect works on never changes.
    pub(crate) fn follow(
        &mut self,
        seconds: f64,
        (rest, base): (&[[f32; 3]], &[[f32; 3]]),
        triangles: &[[u32; 3]],
        spent: &mut Spent,
    ) -> Result<(), EvaluateError> {
        if self.base == Base::Posed {
            return self.carry(seconds, base, spent);
        }
        let same = |(a, b): (&[f32; 3], &[f32; 3])| bits(*a) == bits(*b);
        let settled =
            self.on_rest() || (self.bound_to.len() == base.len() && self.bound_to.iter().zip(base).all(same));
        let first = self.binding.is_none();
        let there = settled && !first;
        if there && !self.creases.as_ref().is_some_and(Creases::moves) {
            return Ok(());
        }
        let start = Instant::now();
        self.bind(seconds, base, triangles, there)?;
        spent.bind += start.elapsed();
        if there || self.on_rest() {
            return Ok(());
        }
        self.hear(rest, base, first);
        self.bound_to.clear();
        self.bound_to.extend_from_slice(base);
        Ok(())
    }

    /// Takes a limb along with the model that a clip poses, to a moment.
    fn carry(&mut self, seconds: f64, base: &[[f32; 3]], spent: &mut Spent) -> Result<(), EvaluateError> {
        let start = Instant::now();
        self.move_wires(seconds);
        if let Some(binding) = &mut self.binding {
            let fail = |error| EvaluateError::Bind { effect: self.index, error };
            binding.carry(&self.wires, base).map_err(fail)?;
        }
        spent.bind += start.elapsed();
        Ok(())
    }

    /// Takes the compression of what it works on as its drive, where nothing tells of another.
    fn hear(&mut self, rest: &[[f32; 3]], base: &[[f32; 3]], first: bool) {
        let Some(creases) = self.creases.as_mut().filter(|_| !self.told) else { return };
        if first && creases.is_driven() {
            creases.rest(rest);
        }
        let reading = creases.compression(base);
        creases.record(0.0, vec![reading]);
    }

    /// Brings the references to a moment and binds `points` to them; where these are `there`, since they are those it is bound to, only
    /// what the references have changed.
    fn bind(
        &mut self,
        seconds: f64,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        there: bool,
    ) -> Result<(), EvaluateError> {
        let effect = self.index;
        self.lay(seconds, points, triangles)?;
        let bound = self.wires.len();
        self.move_wires(seconds);
        let fail = |error| EvaluateError::Bind { effect, error };
        let Some(ffd) = &mut self.lattice else {
            let masks = self.masks.of_wires(&self.near, self.wires.len());
            let masks: Vec<_> = masks.iter().map(WireMask::borrow).collect();
            // A border that cuts a crease, or no longer does, changes how many there are.
            match self.binding.as_mut().filter(|_| there && self.wires.len() == bound) {
                Some(binding) => binding.rebind(&self.wires, &masks).map_err(fail)?,
                None => self.binding = Some(Binding::masked(&self.wires, points, &masks).map_err(fail)?),
            }
            return Ok(());
        };
        // The control points at rest stay where they are, whatever the object does.
        if self.binding.is_none() {
            ffd.controls = ffd.lattice.points();
            self.binding = Some(Binding::new(&self.wires, &ffd.controls).map_err(fail)?);
        }
        let bound = LatticeBinding::new(&ffd.lattice, points, self.masks.of_effect());
        ffd.binding = Some(bound.map_err(|error| EvaluateError::Lattice { effect, error })?);
        Ok(())
    }

    /// Brings creases to a moment: lays them, if that is still to be done, and takes them, and seams, along with the surface.
    fn lay(
        &mut self,
        seconds: f64,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<(), EvaluateError> {
        let on_rest = self.on_rest();
        if let Some(Part { seams, piece_of, .. }) = self.seams.as_mut().filter(|_| !on_rest) {
            let surfaces = Surfaces { positions, triangles, piece_of, sides: &[] };
            match seams.renewed(&surfaces) {
                Ok(now) => *seams = now,
                // An edge that has shrunk to a point leads to what it did before.
                Err(_) => seams.follow(positions),
            }
            self.near = seams.near().to_vec();
        }
        let Action::Wrinkle(wrinkle) = &self.action else { return Ok(()) };
        let effect = self.index;
        let fail = |error| EvaluateError::Wrinkle { effect, error };
        let surface = SurfaceView { positions, triangles };
        let laid = self.creases.is_none();
        let creases = match &mut self.creases {
            Some(creases) => creases,
            none => none.insert(creases(&surface, wrinkle).map_err(fail)?),
        };
        if !laid || seconds != 0.0 {
            creases.at(seconds, (!laid && !on_rest).then_some(&surface)).map_err(fail)?;
        }
        if laid || creases.moves() {
            self.near = creases.near();
            self.coarse = coarser(self.coarse.take(), creases.coarse());
        }
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
            Action::Ik(_) => {
                if let Some(reach) = &self.reach {
                    if self.wires.is_empty() {
                        self.wires.push(reach.wire());
                    }
                    reach.wire_into(seconds, &mut self.wires[0]);
                }
            }
            Action::Wrinkle(_) => {
                if let Some(creases) = &mut self.creases {
                    creases.wires_at(seconds, &mut self.wires);
                }
            }
            Action::Stitch(_) => {
                if let Some(Part { seams, .. }) = &mut self.seams {
                    seams.wires_at(seconds, &mut self.wires);
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
        if let Some(Part { seams, .. }) = &self.seams {
            let free = |point: u32| self.masks.of_effect().is_none_or(|mask| mask[point as usize] >= 1.0);
            for pin in seams.pins().iter().filter(|pin| free(pin.point)) {
                out[pin.point as usize] = pin.goal;
            }
        }
        spent.deform += start.elapsed();
        self.reached = self.reached || (binding.reaches() && !self.is_empty_lattice());
        Ok(())
    }

    /// What multiplies the effect as a whole, a factor for each point.
    pub(crate) fn factors(&self) -> Option<&[f32]> {
        self.masks.of_effect()
    }

    /// The wires of a `Deform`, in metres, where it is one.
    pub(crate) fn drawn(&self) -> Option<&Deform> {
        if let Action::Deform(deform) = &self.action { Some(deform) } else { None }
    }

    /// What points have of the control points of `wires`, which are its own at a moment. None of an effect that is not bound yet.
    pub(crate) fn weights(&mut self, wires: &[Wire]) -> Result<Weights, WeightsError> {
        self.binding
            .as_mut()
            .map_or_else(|| Ok(Weights::default()), |bound| bound.weights(wires, &self.blend))
    }

    /// The limb, where it is one.
    pub(crate) fn reach(&self) -> Option<&Reach> {
        self.reach.as_ref()
    }

    /// Whether it is a limb of joints that a clip may move.
    pub(crate) fn hangs_on_nodes(&self) -> bool {
        self.reach.as_ref().is_some_and(|reach| !reach.nodes().is_empty())
    }

    /// Notes that it works on what a clip poses.
    pub(crate) fn leave_rest(&mut self) {
        self.base = if self.hangs_on_nodes() { Base::Posed } else { Base::Result };
    }

    /// Takes up where the nodes are that a limb looks at.
    pub(crate) fn follow_nodes(&mut self, posing: &Posing<'_>) -> Result<(), EvaluateError> {
        let effect = self.index;
        let Some(reach) = &mut self.reach else { return Ok(()) };
        reach.follow(|node| posing.place(node)).map_err(|error| EvaluateError::Limb { effect, error })
    }

    /// Whether it has nothing that could move a point.
    pub(crate) fn is_inert(&self) -> bool {
        matches!(&self.action, Action::Deform(deform) if deform.wires.is_empty())
    }

    /// Whether compression of the surface drives it.
    pub(crate) fn is_driven(&self) -> bool {
        self.creases.as_ref().is_some_and(Creases::is_driven)
    }

    /// Whether it is driven by what nothing tells it.
    pub(crate) fn is_unmoved(&self) -> bool {
        self.is_driven() && !self.told && self.on_rest()
    }

    /// The greatest compression that it was told of, and when, where that raises nothing.
    pub(crate) fn unraised(&self) -> Option<(f32, f64)> {
        self.creases.as_ref().filter(|_| self.told)?.unraised()
    }

    /// The compression at its creases.
    pub(crate) fn compression(&self, now: &[[f32; 3]]) -> Vec<f32> {
        self.creases.as_ref().map_or_else(Vec::new, |creases| creases.compression(now))
    }

    /// Tells it the compression in time.
    pub(crate) fn record(&mut self, step: f64, readings: Vec<Vec<f32>>) {
        if let Some(creases) = self.creases.as_mut().filter(|creases| creases.is_driven()) {
            creases.record(step, readings);
            self.told = true;
        }
    }

    /// What the creases lack.
    pub(crate) fn warnings(&self) -> impl Iterator<Item = &WrinkleWarning> {
        let all = self.creases.as_ref().map_or(&[][..], Creases::warnings).iter();
        // What is still to be made finer is not too coarse.
        let coarse = self.coarse.iter().filter(|_| self.fineness != Fineness::Wanted);
        all.filter(|warning| !matches!(warning, WrinkleWarning::Coarse { .. })).chain(coarse)
    }

    /// What the seams lack, by their numbers in the stitch.
    pub(crate) fn seam_warnings(&self) -> Vec<String> {
        self.seams.as_ref().map_or_else(Vec::new, Part::warnings)
    }

    /// Points that are to be one, and how far they have come.
    pub(crate) fn joints(&self) -> impl Iterator<Item = (&[u32], f32)> {
        self.seams.iter().flat_map(|part| part.seams.joints())
    }

    /// Notes that its surface has been made finer where it asked for that. It does not ask where a mask lets nothing move, and whether
    /// that is coarse is no matter.
    pub(crate) fn set_refined(&mut self) {
        if self.fineness == Fineness::Wanted && self.masks.of_effect().is_none() {
            self.fineness = Fineness::Made;
        }
    }

    /// Whether its surface has been made finer where it asked for that.
    pub(crate) fn is_refined(&self) -> bool {
        self.fineness == Fineness::Made
    }

    /// Whether it is driven by the effects before it, and has not been told of all moments.
    pub(crate) fn listens(&self) -> bool {
        !self.on_rest() && self.is_driven() && !self.told
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

/// The worse of two warnings about long edges.
fn coarser(a: Option<WrinkleWarning>, b: Option<WrinkleWarning>) -> Option<WrinkleWarning> {
    let edge = |warning: &Option<WrinkleWarning>| match warning {
        Some(WrinkleWarning::Coarse { edge, .. }) => *edge,
        _ => 0.0,
    };
    if edge(&b) > edge(&a) { b } else { a }
}
