//! Binding and deforming: \[SF98\] §2, "computed once", and §6, "must be recalculated only if the reference curve is changed".

use std::cell::RefCell;

use rayon::prelude::*;
use thiserror::Error;

use crate::arclength::ArcLength;
use crate::attributes::{copy_influence, largest_radius, same_influence};
use crate::blend::{self, Sums};
use crate::cells::Cells;
use crate::closest::Pieces;
use crate::frame::Frame;
use crate::kernel::{Displacements, displace};
use crate::runs::{Runs, StoredFoot, find_feet};
use crate::spans::Spans;
use crate::tiles::{TILE, Tile, Tiles};
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

/// One wire's part of a binding.
#[derive(Clone, Debug)]
struct BoundWire {
    /// The state the points were bound in.
    wire: Wire,
    /// Feet were sought up to this distance.
    reach: f32,
    spans: Spans,
    lengths: ArcLength,
    cells: Cells,
    runs: Runs,
    /// Kept only in a group, where the nearest wire is chosen again when one of them moves.
    feet: Vec<StoredFoot>,
    frame: Frame,
}

/// Room for the wires of one tile.
type Scratch = (Vec<Displacements>, Option<Box<Sums>>);

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

    /// The same with masks: `masks[i]`, where there is one, multiplies `F` of wire `i`, a number from 0 to 1 for each point.
    pub fn masked(wires: &[Wire], points: &[[f32; 3]], masks: &[Option<&[f32]>]) -> Result<Self, BindError> {
        let _ = masks;
        check(wires)?;
        if u32::try_from(points.len()).is_err() {
            return Err(BindError::TooManyPoints(points.len()));
        }
        let tiles = Tiles::new(points);
        let whole = tiles.ball().map_or(0.0, |ball| ball.radius);
        let unit = if whole > 0.0 { (-whole.log2().round()).exp2() as f32 } else { 1.0 };
        let of_points = tiles.ball().map_or(0.0, |ball| ball.center.abs().max_element() + ball.radius);
        let of_curves = wires.iter().flat_map(|w| w.reference.points()).flatten().map(|c| f64::from(c.abs()));
        let tie = GROUP_TIE * of_curves.fold(of_points, f64::max);
        let mut binding = Self { tiles, wires: Vec::new(), unit, tie };
        for index in 0..wires.len() {
            let bound = BoundWire::new(&wires[index], group_radius(wires, index), &binding.tiles);
            binding.wires.push(bound);
        }
        for index in 0..wires.len() {
            binding.sort_group(index);
        }
        Ok(binding)
    }

    /// Number of points bound.
    pub fn point_count(&self) -> usize {
        self.tiles.count
    }

    /// Number of pairs of a point and a wire that reaches it.
    pub fn pair_count(&self) -> usize {
        self.wires.iter().map(|w| w.runs.index.len()).sum()
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

    /// Rebinds what has to be.
    fn update(&mut self, wires: &[Wire]) {
        for index in 0..wires.len() {
            let (wire, bound) = (&wires[index], &self.wires[index]);
            let radius = group_radius(wires, index);
            let places = |w: &Wire, i: usize| w.locators.get(i).map(|l| l.u);
            let moved = bound.wire.reference != wire.reference
                || bound.wire.group != wire.group
                || bound.wire.locators.len() != wire.locators.len()
                || (0..wire.locators.len()).any(|i| places(wire, i) != places(&bound.wire, i));
            if moved || radius > bound.reach {
                let reach = if moved { radius } else { radius * REACH_SLACK };
                let old_group = bound.wire.group;
                self.wires[index] = BoundWire::new(wire, reach, &self.tiles);
                for other in 0..wires.len() {
                    let group = self.wires[other].wire.group;
                    if group == wire.group || group == old_group {
                        self.sort_group(other);
                    }
                }
            } else if !same_influence(&bound.wire, wire) {
                let bound = &mut self.wires[index];
                copy_influence(wire, &mut bound.wire);
                bound.runs.measure(wire, &bound.spans, &bound.cells);
            }
        }
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
            let own = bound.feet[i].distance;
            let nearest = rivals.iter().map(|(_, rival)| rival.feet[i].distance).fold(own, f64::min);
            let near = |distance: f64| distance <= nearest + self.tie;
            near(own) && !rivals.iter().any(|(other, rival)| *other < index && near(rival.feet[i].distance))
        };
        let runs = Runs::new(&bound.wire, &bound.spans, &bound.cells, &bound.feet, &acts);
        self.wires[index].runs = runs;
    }
}

impl BoundWire {
    fn new(wire: &Wire, reach: f32, tiles: &Tiles) -> Self {
        let spans = Spans::new(&wire.reference);
        let pieces = Pieces::new(&spans);
        let cells = Cells::new(wire, &spans);
        let mut bound = Self {
            lengths: ArcLength::new(&spans),
            wire: wire.clone(),
            reach,
            runs: Runs::default(),
            feet: Vec::new(),
            frame: Frame::default(),
            cells,
            spans,
        };
        if wire.group.is_some() {
            bound.feet = find_feet(&pieces, tiles, f64::from(reach));
        } else {
            bound.runs = Runs::bind(wire, &bound.spans, &bound.cells, &pieces, tiles, f64::from(reach));
        }
        bound
    }
}

fn check(wires: &[Wire]) -> Result<(), BindError> {
    let fault = |(wire, w): (usize, &Wire)| w.check().err().map(|error| BindError::Wire { wire, error });
    wires.iter().enumerate().find_map(fault).map_or(Ok(()), Err)
}

/// How far a wire's feet matter: its own reach, and in a group that of all, since the nearest wire keeps the others off.
fn group_radius(wires: &[Wire], index: usize) -> f32 {
    let wire = &wires[index];
    let same = |w: &&Wire| wire.group.is_some() && w.group == wire.group;
    wires.iter().filter(same).chain([wire]).map(largest_radius).fold(0.0, f32::max)
}

/// Deforms one tile; compiled for the vector instructions the processor has.
struct DeformTile<'a> {
    bound: &'a [BoundWire],
    wires: &'a [Wire],
    blend: &'a Blend,
    unit: f32,
    index: usize,
    tile: &'a Tile,
    scratch: &'a mut Scratch,
    out: &'a mut [[f32; 3]],
}

impl pulp::WithSimd for DeformTile<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let (displacements, sums) = self.scratch;
        let mut used = 0;
        for (bound, wire) in self.bound.iter().zip(self.wires) {
            let runs = bound.runs.of_tile(self.index);
            // A wire that has not moved still anchors its surroundings in the local blend.
            if runs.is_empty() || (bound.frame.still && self.blend.localize == 0.0) {
                continue;
            }
            if displacements.len() == used {
                displacements.push(Displacements::new());
            }
            let out = &mut displacements[used];
            out.clear();
            out.exponent = wire.exponent.unwrap_or(self.blend.exponent);
            used += 1;
            for run in runs {
                let cell = &bound.frame.cells[run.cell as usize];
                let points = bound.runs.points(run);
                if !cell.still {
                    displace(simd, self.tile, &bound.frame, cell, points, out);
                } else if self.blend.localize != 0.0 {
                    for (&k, &f) in points.index.iter().zip(points.influence) {
                        out.influence[k as usize & (TILE - 1)] = f;
                    }
                }
            }
        }
        let used = &mut displacements[..used];
        if used.len() > 1 {
            sums.get_or_insert_with(|| Box::new(Sums::new())).combine(simd, used, self.blend, self.unit);
        }
        blend::write(self.tile, used.first(), self.out);
    }
}
