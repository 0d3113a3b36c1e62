//! Bound points in runs: for every tile and cell the points whose feet lie there, ten bytes a point.
//!
//! All points of a run share the cell's polynomials, so that the deformation loads their coefficients once and then
//! streams through indices, places and influences. A point with several feet ([`Closest::Blended`](crate::Closest)) stands in several
//! runs, or several times in one, each time with a weight.

use rayon::prelude::*;

use crate::Wire;
use crate::cells::Cells;
use crate::domain::Side;
use crate::influence::{FADES, Measure};
use crate::kernel::RunPoints;
use crate::mask::KeptMask;
use crate::search::{Found, Sought, StoredFoot};
use crate::tiles::{Balls, TILE, Tile, Tiles};

/// Consecutive bound points of one tile and cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) cell: u32,
    pub(crate) start: u32,
    pub(crate) end: u32,
}

/// The bound points of one tile, by their cell. Lists that nothing asks for are empty.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileRuns {
    pub(crate) list: Vec<Run>,
    /// Index of the point in its tile.
    pub(crate) index: Vec<u16>,
    /// Place of the foot in its segment.
    pub(crate) t: Vec<f32>,
    /// `F`.
    pub(crate) influence: Vec<f32>,
    /// The foot's share among the feet of its point.
    pub(crate) weight: Vec<f32>,
    /// What domain curves leave of the attributes of [`FADES`].
    pub(crate) fades: [Vec<f32>; FADES.len()],
    // What follows is cold: read only when the influence changes.
    /// Distance from the foot. In float64, for a point at the very edge of the influence counts in the blend, or does not.
    pub(crate) distance: Vec<f64>,
    /// What multiplies `F`.
    pub(crate) mask: Vec<f32>,
    /// How the points stand to each domain curve.
    pub(crate) sides: Vec<Vec<Side>>,
}

/// All runs of one wire, a tile after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Runs(Vec<TileRuns>);

/// A wire prepared for binding.
#[derive(Clone, Copy)]
pub(crate) struct Bound<'a> {
    pub(crate) wire: &'a Wire,
    pub(crate) cells: &'a Cells,
    pub(crate) sought: Sought<'a>,
    /// What multiplies `F`.
    pub(crate) mask: Option<&'a KeptMask>,
}

/// Whether a wire acts on a point, by the point's index.
pub(crate) type Acts<'a> = &'a (dyn Fn(usize) -> bool + Sync);

impl TileRuns {
    /// The points of a run.
    #[inline(always)]
    pub(crate) fn points(&self, run: &Run) -> RunPoints<'_> {
        let range = run.start as usize..run.end as usize;
        let [scale, rotation, amplitude, twist] = &self.fades;
        RunPoints {
            index: &self.index[range.clone()],
            t: &self.t[range.clone()],
            influence: &self.influence[range.clone()],
            weight: self.weight.get(range.clone()).unwrap_or_default(),
            fades: [
                scale.get(range.clone()).unwrap_or_default(),
                rotation.get(range.clone()).unwrap_or_default(),
                amplitude.get(range.clone()).unwrap_or_default(),
                twist.get(range).unwrap_or_default(),
            ],
        }
    }
}

impl Runs {
    /// Runs of a tile.
    #[inline]
    pub(crate) fn of_tile(&self, tile: usize) -> Option<&TileRuns> {
        self.0.get(tile).filter(|runs| !runs.list.is_empty())
    }

    /// How many bound points there are.
    pub(crate) fn pair_count(&self) -> usize {
        self.0.iter().map(|runs| runs.index.len()).sum()
    }

    /// Whether the wire has an influence above 0 anywhere.
    pub(crate) fn reach(&self) -> bool {
        self.0.iter().any(|runs| runs.influence.iter().any(|f| *f > 0.0))
    }

    /// Finds the feet of all points and sorts them into runs, a tile at a time.
    pub(crate) fn bind(bound: Bound<'_>, tiles: &Tiles) -> Self {
        if tiles.order().is_some() {
            return Self::new(bound, tiles, &bound.sought.everywhere(tiles), &|_| true);
        }
        let all = bound.sought.pieces.all();
        let part = |(i, (tile, balls)): (usize, (&Tile, &Balls))| {
            let count = (tiles.count - i * TILE).min(TILE);
            if bound.mask.is_some_and(|mask| mask.of(i * TILE..i * TILE + count).is_none()) {
                return TileRuns::default();
            }
            let found = bound.sought.tile(tile, balls, &all, count);
            found.map_or_else(TileRuns::default, |found| bound.sort(tile, i * TILE, &found, &|_| true))
        };
        Self(tiles.searched().par_iter().zip(&tiles.balls).enumerate().map(part).collect())
    }

    /// Sorts the feet of the points that `acts` admits into runs.
    pub(crate) fn new(bound: Bound<'_>, tiles: &Tiles, found: &Found, acts: Acts) -> Self {
        let part = |(i, tile): (usize, &Tile)| {
            let first = i * TILE;
            bound.sort(tile, first, &found.part(first, (first + TILE).min(tiles.count)), acts)
        };
        Self(tiles.list.par_iter().enumerate().map(part).collect())
    }

    /// Computes `F` anew: after a change of radii, the density, directions or what domain curves do.
    pub(crate) fn measure(&mut self, measure: Measure<'_>, tiles: &Tiles) {
        let work = |(runs, tile): (&mut TileRuns, &Tile)| measure.tile(tile, runs);
        if rayon::current_num_threads() == 1 {
            self.0.iter_mut().zip(&tiles.list).for_each(work);
        } else {
            self.0.par_iter_mut().zip(&tiles.list).for_each(work);
        }
    }
}

impl Bound<'_> {
    /// The runs of a tile whose first point is number `first`, from the feet of its points.
    fn sort(self, tile: &Tile, first: usize, found: &Found, acts: Acts) -> TileRuns {
        let closest = found.feet.len();
        let mask = match self.mask.map(|mask| mask.of(first..first + closest)) {
            Some(None) => return TileRuns::default(),
            Some(mask) => mask,
            None => None,
        };
        let mask = mask.as_deref();
        // Slots: the closest feet, then the further ones.
        let at = |slot: u32| match found.feet.get(slot as usize) {
            Some(foot) => (slot as usize, *foot),
            None => (found.more[slot as usize - closest].0 as usize, found.more[slot as usize - closest].1),
        };
        let admits = |point: usize, foot: &StoredFoot| {
            foot.distance.is_finite() && mask.is_none_or(|mask| mask[point] > 0.0) && acts(first + point)
        };
        let mut bound: Vec<(u32, u32)> = Vec::with_capacity(closest + found.more.len());
        for (point, foot) in found.feet.iter().enumerate() {
            if admits(point, foot) {
                bound.push((self.cells.find(foot.span, foot.t), point as u32));
            }
        }
        for (slot, (point, foot)) in found.more.iter().enumerate() {
            if admits(*point as usize, foot) {
                bound.push((self.cells.find(foot.span, foot.t), (closest + slot) as u32));
            }
        }
        if bound.is_empty() {
            return TileRuns::default();
        }
        let (list, slots) = by_cell(self.cells.list.len(), &bound);
        let count = slots.len();
        let mut runs = TileRuns {
            list,
            index: Vec::with_capacity(count),
            t: Vec::with_capacity(count),
            distance: Vec::with_capacity(count),
            ..TileRuns::default()
        };
        for &slot in &slots {
            let (point, foot) = at(slot);
            runs.index.push(point as u16);
            runs.t.push(foot.t);
            runs.distance.push(foot.distance);
        }
        if !found.more.is_empty() {
            runs.weight = slots.iter().map(|&slot| at(slot).1.weight).collect();
        }
        if let Some(mask) = mask {
            runs.mask = slots.iter().map(|&slot| mask[at(slot).0]).collect();
        }
        for (sides, more) in found.sides.iter().zip(&found.more_sides) {
            let side = |&slot: &u32| {
                sides.get(slot as usize).copied().unwrap_or_else(|| more[slot as usize - closest])
            };
            runs.sides.push(slots.iter().map(side).collect());
        }
        for (bounds, fade) in FADES.into_iter().zip(&mut runs.fades) {
            if self.wire.domains.iter().any(|domain| domain.bounds == bounds) {
                fade.resize(count, 1.0);
            }
        }
        Measure { wire: self.wire, spans: self.sought.spans, cells: self.cells }.tile(tile, &mut runs);
        runs
    }
}

/// Counting sort of slots by cell; within a cell they keep their order.
fn by_cell(cells: usize, bound: &[(u32, u32)]) -> (Vec<Run>, Vec<u32>) {
    let mut starts = vec![0; cells + 1];
    for &(cell, _) in bound {
        starts[cell as usize + 1] += 1;
    }
    let mut runs = Vec::new();
    for cell in 0..cells {
        let (start, end) = (starts[cell], starts[cell] + starts[cell + 1]);
        if start < end {
            runs.push(Run { cell: cell as u32, start, end });
        }
        starts[cell + 1] = end;
    }
    let mut slots = vec![0; bound.len()];
    for &(cell, slot) in bound {
        let next = &mut starts[cell as usize];
        slots[*next as usize] = slot;
        *next += 1;
    }
    (runs, slots)
}
