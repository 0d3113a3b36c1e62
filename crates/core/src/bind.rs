//! Binding and deforming: \[SF98\] §2, "computed once", and §6, "must be recalculated only if the reference curve is changed".

use std::cell::RefCell;

use rayon::prelude::*;
use thiserror::Error;

use crate::attributes::{copy_influence, largest_radius, same_influence};
use crate::bound_wire::{BoundWire, UNBOUND, same_places};
use crate::deform::{DeformTile, Scratch};
use crate::influence::Measure;
use crate::mask::{self, Mask};
use crate::runs::Runs;
use crate::tiles::{TILE, Tile, Tiles};
use crate::weights::{self, Weights, WeightsError};
use crate::wire::WireError;
use crate::{Blend, Wire};

/// A wire whose radius grows beyond what its points were bound for is bound anew for so much more, lest a steady growth
/// bind in every frame.
const REACH_SLACK: f32 = 1.25;

/// Distances from two wires of a group tie when they differ by less than this part of the largest coordinate: by the rounding
/// of float64 only. Where a wire is cut in two the first half's end would otherwise stand for feet on the second half as far
/// away as the tolerance's square root.
const GROUP_TIE: f64 = 1e-13;

/// Why points cannot be bound or deformed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BindError {
    /// A wire has a value outside its range.
    #[error("wire {wire}: {error}")]
    Wire {
        /// Which wire, from 0.
        wire: usize,
        /// What is wrong with it.
        error: WireError,
    },
    /// A value of the blend is NaN or infinite.
    #[error("the blend's {0} is not finite")]
    Blend(&'static str),
    /// More points than 32 bits count.
    #[error("{0} points are more than 2³² − 1")]
    TooManyPoints(usize),
    /// A mask does not hold a number for each point, or names points that are not there or out of order.
    #[error("a mask of {found} numbers does not fit {points} points")]
    MaskCount {
        /// Points to be bound.
        points: usize,
        /// Length of the mask.
        found: usize,
    },
    /// The wires given are not as many as were bound.
    #[error("{bound} wires were bound, {found} are given")]
    WireCount {
        /// Wires that were bound.
        bound: usize,
        /// Wires given.
        found: usize,
    },
    /// The buffer does not hold as many points as were bound.
    #[error("{bound} points were bound, the buffer holds {found}")]
    PointCount {
        /// Points that were bound.
        bound: usize,
        /// Length of the buffer.
        found: usize,
    },
}

/// Points bound to wires: for every wire the points in its reach, their feet and influences.
///
/// Made once; [`Binding::deform_into`] then follows the wires at little cost.
#[derive(Clone, Debug)]
pub struct Binding {
    tiles: Tiles,
    wires: Vec<BoundWire>,
    /// About one over the size of the scene, a power of two.
    unit: f32,
    /// Wires of a group are equally near when their distances differ by less.
    tie: f64,
}

thread_local! {
    /// Grows to what the busiest tile needs and stays, so that a frame allocates nothing.
    static SCRATCH: RefCell<Scratch> = const { RefCell::new((Vec::new(), None)) };
}

impl Binding {
    /// Binds `points` (any number, in any order) to the reference curves of `wires`.
    ///
    /// A point with a coordinate that is NaN or infinite is bound to nothing and stays what it is. Uses rayon's
    /// current pool; the result does not depend on its size.
    pub fn new(wires: &[Wire], points: &[[f32; 3]]) -> Result<Self, BindError> {
        Self::masked(wires, points, &[])
    }

    /// The same with masks: `masks[i]`, where there is one, multiplies `F` of wire `i`. May be shorter than `wires`.
    pub fn masked(
        wires: &[Wire],
        points: &[[f32; 3]],
        masks: &[Option<Mask<'_>>],
    ) -> Result<Self, BindError> {
        check(wires)?;
        if u32::try_from(points.len()).is_err() {
            return Err(BindError::TooManyPoints(points.len()));
        }
        check_masks(masks, points.len())?;
        let tiles = Tiles::new(points);
        let whole = tiles.ball().map_or(0.0, |ball| ball.radius);
        let unit = if whole > 0.0 { (-whole.log2().round()).exp2() as f32 } else { 1.0 };
        let of_points = tiles.ball().map_or(0.0, |ball| ball.center.abs().max_element() + ball.radius);
        let of_curves = wires.iter().flat_map(|w| w.reference.points()).flatten().map(|c| f64::from(c.abs()));
        let tie = GROUP_TIE * of_curves.fold(of_points, f64::max);
        let kept = mask::keep(masks);
        let mut binding = Self { tiles, wires: Vec::new(), unit, tie };
        let mask = |index: usize| kept.get(index).cloned().flatten();
        binding.wires.extend(wires.iter().enumerate().map(|(i, wire)| BoundWire::new(wire, mask(i))));
        for index in 0..wires.len() {
            let reach = binding.reach(wires, index);
            binding.wires[index].find(reach, &binding.tiles);
        }
        for index in 0..wires.len() {
            binding.sort_group(index);
        }
        Ok(binding)
    }

    /// Binds all wires anew, with other masks in the place of those that they were bound with. For wires whose reference moves, and
    /// with it where they may act; [`Binding::deform_into`] does the same where only references moved.
    pub fn rebind(&mut self, wires: &[Wire], masks: &[Option<Mask<'_>>]) -> Result<(), BindError> {
        check(wires)?;
        check_masks(masks, self.tiles.count)?;
        if wires.len() != self.wires.len() {
            return Err(BindError::WireCount { bound: self.wires.len(), found: wires.len() });
        }
        let kept = mask::keep(masks).into_iter().chain(std::iter::repeat(None));
        for (bound, mask) in self.wires.iter_mut().zip(kept) {
            (bound.mask, bound.reach) = (mask, UNBOUND);
        }
        self.update(wires);
        Ok(())
    }

    /// Takes along what was bound: points and references have moved together, as a skin moves them, to `points` and to the references of
    /// `wires`. Every point keeps its feet and its influences, those it was bound with, wherever it is nearest to now. Wires keep the
    /// kind and the number of their control points; what else changed of them counts as in [`Binding::deform_into`].
    pub fn carry(&mut self, wires: &[Wire], points: &[[f32; 3]]) -> Result<(), BindError> {
        check(wires)?;
        if wires.len() != self.wires.len() {
            return Err(BindError::WireCount { bound: self.wires.len(), found: wires.len() });
        }
        if points.len() != self.tiles.count {
            return Err(BindError::PointCount { bound: self.tiles.count, found: points.len() });
        }
        self.tiles = Tiles::new(points);
        for (bound, wire) in self.wires.iter_mut().zip(wires) {
            bound.carry(&wire.reference);
        }
        Ok(())
    }

    /// Number of points bound.
    pub fn point_count(&self) -> usize {
        self.tiles.count
    }

    /// Number of pairs of a point and a wire in whose reach it lies; the influence of some may be 0.
    pub fn pair_count(&self) -> usize {
        self.wires.iter().map(|w| w.runs.pair_count()).sum()
    }

    /// Whether any wire has an influence above 0 on any point.
    pub fn reaches(&self) -> bool {
        self.wires.iter().any(|w| w.runs.reach())
    }

    /// Deforms the bound points by the present state of `wires` into `out`: \[SF98\] §2 for each wire, §4 for all.
    ///
    /// `wires` are those that were bound, with whatever pose and attributes they have now. A wire whose reference moved,
    /// whose locators changed place or whose radius grew beyond its bound reach is bound anew, the others are not.
    /// Otherwise nothing is allocated after the first call. Points that no wire moves keep their bits.
    pub fn deform_into(
        &mut self,
        wires: &[Wire],
        blend: &Blend,
        out: &mut [[f32; 3]],
    ) -> Result<(), BindError> {
        check(wires)?;
        blend.check().map_err(BindError::Blend)?;
        if wires.len() != self.wires.len() {
            return Err(BindError::WireCount { bound: self.wires.len(), found: wires.len() });
        }
        if out.len() != self.tiles.count {
            return Err(BindError::PointCount { bound: self.tiles.count, found: out.len() });
        }
        self.update(wires);
        for (bound, wire) in self.wires.iter_mut().zip(wires) {
            bound.frame.build(wire, &bound.spans, &bound.lengths, &bound.cells);
        }
        let (bound, unit) = (&self.wires, self.unit);
        let work = |(index, (tile, out)): (usize, (&Tile, &mut [[f32; 3]]))| {
            SCRATCH.with_borrow_mut(|scratch| {
                pulp::Arch::new().dispatch(DeformTile {
                    bound,
                    wires,
                    blend,
                    unit,
                    index,
                    tile,
                    scratch,
                    out,
                });
            });
        };
        if rayon::current_num_threads() == 1 {
            self.tiles.list.iter().zip(out.chunks_mut(TILE)).enumerate().for_each(work);
        } else {
            self.tiles.list.par_iter().zip(out.par_chunks_mut(TILE)).enumerate().for_each(work);
        }
        Ok(())
    }

    /// What the bound points have of the control points of `wires`, in their present state: `P + Σ weight·(Wⱼ − Rⱼ)` is what
    /// [`Binding::deform_into`] makes of each for any pose, as long as nothing but poses moves. Wires count as there; their poses do not.
    ///
    /// # Errors
    ///
    /// Wires that do more than translate (rotation or twist other than 0, scale other than 1), that are posed by arc length or are
    /// Catmull-Rom splines; points that several wires reach, unless `localize` or `crossing` is 1.
    pub fn weights(&mut self, wires: &[Wire], blend: &Blend) -> Result<Weights, WeightsError> {
        check(wires)?;
        blend.check().map_err(BindError::Blend)?;
        if wires.len() != self.wires.len() {
            return Err(BindError::WireCount { bound: self.wires.len(), found: wires.len() }.into());
        }
        self.update(wires);
        weights::weights(&self.wires, wires, blend, self.tiles.count)
    }

    /// Rebinds what has to be.
    fn update(&mut self, wires: &[Wire]) {
        for (bound, wire) in self.wires.iter_mut().zip(wires) {
            if !same_places(&bound.wire, wire) {
                let old_group = bound.wire.group;
                *bound = BoundWire { left: old_group, ..BoundWire::new(wire, bound.mask.clone()) };
            }
        }
        for index in 0..wires.len() {
            let (wire, reach) = (&wires[index], self.reach(wires, index));
            let bound = &mut self.wires[index];
            let anew = bound.reach == UNBOUND;
            if reach > bound.reach {
                copy_influence(wire, &mut bound.wire);
                bound.find(if anew { reach } else { reach * REACH_SLACK }, &self.tiles);
                bound.found_anew = true;
            } else if !same_influence(&bound.wire, wire) {
                copy_influence(wire, &mut bound.wire);
                let measure = Measure { wire, spans: &bound.spans, cells: &bound.cells };
                bound.runs.measure(measure, &self.tiles);
            }
        }
        // Only now are the feet of all rivals known.
        for index in 0..wires.len() {
            // Of most there is none, and no need to look at all others for each.
            let Some(group) = self.wires[index].wire.group else { continue };
            let concerns = |other: &BoundWire| {
                other.found_anew && (other.wire.group == Some(group) || other.left == Some(group))
            };
            if self.wires.iter().any(concerns) {
                self.sort_group(index);
            }
        }
        for bound in &mut self.wires {
            (bound.found_anew, bound.left) = (false, None);
        }
    }

    /// How far a wire's feet matter, but for its domain curves: its own radius, and in a group the reach of all, since the
    /// nearest wire keeps the others off.
    fn reach(&self, wires: &[Wire], index: usize) -> f32 {
        let own = largest_radius(&wires[index]);
        if wires[index].group.is_none() {
            return own;
        }
        let same = |(wire, _): &(&Wire, &BoundWire)| wire.group == wires[index].group;
        let reach = |(wire, bound): (&Wire, &BoundWire)| largest_radius(wire).max(bound.domain_reach());
        wires.iter().zip(&self.wires).filter(same).map(reach).fold(own, f32::max)
    }

    /// Makes the runs of a wire of a group from its feet: of the points that are nearest to this wire.
    fn sort_group(&mut self, index: usize) {
        let bound = &self.wires[index];
        let group = bound.wire.group;
        if group.is_none() {
            return;
        }
        let rivals = |&(other, w): &(usize, &BoundWire)| other != index && w.wire.group == group;
        let rivals: Vec<(usize, &BoundWire)> = self.wires.iter().enumerate().filter(rivals).collect();
        let acts = |i: usize| {
            let own = bound.found.feet[i].distance;
            // A wire that is masked out at a point is no rival there.
            let at = |rival: &BoundWire| {
                let out = rival.mask.as_ref().is_some_and(|mask| mask.at(i) <= 0.0);
                if out { f64::INFINITY } else { rival.found.feet[i].distance }
            };
            let nearest = rivals.iter().map(|(_, rival)| at(rival)).fold(own, f64::min);
            let near = |distance: f64| distance <= nearest + self.tie;
            near(own) && !rivals.iter().any(|(other, rival)| *other < index && near(at(rival)))
        };
        let runs = Runs::new(bound.bound(), &self.tiles, &bound.found, &acts);
        self.wires[index].runs = runs;
    }
}

fn check_masks(masks: &[Option<Mask<'_>>], points: usize) -> Result<(), BindError> {
    match masks.iter().flatten().find_map(|mask| mask.misfit(points)) {
        Some(found) => Err(BindError::MaskCount { points, found }),
        None => Ok(()),
    }
}

fn check(wires: &[Wire]) -> Result<(), BindError> {
    let fault = |(wire, w): (usize, &Wire)| w.check().err().map(|error| BindError::Wire { wire, error });
    wires.iter().enumerate().find_map(fault).map_or(Ok(()), Err)
}

#[cfg(test)]
#[path = "bind_tests.rs"]
mod tests;
