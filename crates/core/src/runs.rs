//! Bound points in runs: for every tile and cell the points whose feet lie there, ten bytes a point.
//!
//! All points of a run share the cell's polynomials, so that the deformation loads their coefficients once and then
//! streams through indices, places and influences. A point with several feet ([`Closest::Blended`](crate::Closest)) stands in several
//! runs, or several times in one, each time with a weight.

use pulp::Simd;
use rayon::prelude::*;

use crate::Wire;
use crate::block::BLOCK;
use crate::cells::Cells;
use crate::domain::{DomainCurve, Footed, Side};
use crate::influence::{FADES, Measure};
use crate::kernel::RunPoints;
use crate::search::{Found, NO_FOOT, Sought, StoredFoot};
use crate::spans::Spans;
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
    pub(crate) spans: &'a Spans,
    pub(crate) cells: &'a Cells,
    pub(crate) sought: Sought<'a>,
    /// What multiplies `F`, a number a point.
    pub(crate) mask: Option<&'a [f32]>,
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

    /// Finds the feet of all points and sorts them into runs, a tile at a time.
    pub(crate) fn bind(bound: Bound<'_>, tiles: &Tiles) -> Self {
        if tiles.order().is_some() {
            let found = bound.sought.everywhere(tiles);
            return Self::new(bound, tiles, &found, &|_| true);
        }
        let all = bound.sought.pieces.all();
        let part = |(i, (tile, balls)): (usize, (&Tile, &Balls))| {
            let mut feet = [NO_FOOT; TILE];
            let feet = &mut feet[..(tiles.count - i * TILE).min(TILE)];
            let more = bound.sought.tile(tile, balls, &all, feet);
            bound.sort(tile, i, TileFeet { closest: feet, more: &more }, &|_| true)
        };
        Self(tiles.searched().par_iter().zip(&tiles.balls).enumerate().map(part).collect())
    }

    /// Sorts the feet that `acts` admits into runs.
    pub(crate) fn new(bound: Bound<'_>, tiles: &Tiles, found: &Found, acts: Acts) -> Self {
        let part = |(i, (tile, closest)): (usize, (&Tile, &[StoredFoot]))| {
            let first = (i * TILE) as u32;
            let from = found.more.partition_point(|(point, _)| *point < first);
            let to = found.more.partition_point(|(point, _)| *point < first + TILE as u32);
            let more: Vec<(u32, StoredFoot)> =
                found.more[from..to].iter().map(|(point, foot)| (point - first, *foot)).collect();
            bound.sort(tile, i, TileFeet { closest, more: &more }, acts)
        };
        Self(tiles.list.par_iter().zip(found.feet.par_chunks(TILE)).enumerate().map(part).collect())
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

/// Feet of one tile: the closest of each point, and further ones.
#[derive(Clone, Copy)]
struct TileFeet<'a> {
    closest: &'a [StoredFoot],
    more: &'a [(u32, StoredFoot)],
}

impl TileFeet<'_> {
    /// Index of the point, and the foot.
    #[inline]
    fn at(self, slot: u32) -> (usize, StoredFoot) {
        let slot = slot as usize;
        match self.closest.get(slot) {
            Some(foot) => (slot, *foot),
            None => {
                let (point, foot) = self.more[slot - self.closest.len()];
                (point as usize, foot)
            }
        }
    }
}

impl Bound<'_> {
    /// The runs of the `number`-th tile from the feet of its points.
    fn sort(self, tile: &Tile, number: usize, feet: TileFeet<'_>, acts: Acts) -> TileRuns {
        let first = number * TILE;
        let mask = self.mask.map(|mask| &mask[first..]);
        let admits = |&slot: &u32| {
            let (point, foot) = feet.at(slot);
            let reaches = foot.distance < self.sought.reach
                || (foot.distance.is_finite() && !self.sought.domains.is_empty());
            reaches && mask.is_none_or(|mask| mask[point] > 0.0) && acts(first + point)
        };
        let slots = (0..(feet.closest.len() + feet.more.len()) as u32).filter(admits);
        let (mut runs, mut slots) = self.by_cell(slots, feet);
        if slots.is_empty() {
            return runs;
        }
        if !self.sought.domains.is_empty() {
            let task = Stand { bound: self, tile, feet, slots: &slots, list: &runs.list };
            runs.sides = pulp::Arch::new().dispatch(task);
            self.drop_unreached(&mut runs, &mut slots, feet);
        }
        let count = slots.len();
        runs.index.reserve_exact(count);
        runs.t.reserve_exact(count);
        runs.distance.reserve_exact(count);
        for &slot in &slots {
            let (point, foot) = feet.at(slot);
            runs.index.push(point as u16);
            runs.t.push(foot.t);
            runs.distance.push(foot.distance);
        }
        if !feet.more.is_empty() {
            runs.weight = slots.iter().map(|&slot| feet.at(slot).1.weight).collect();
        }
        if let Some(mask) = mask {
            runs.mask = slots.iter().map(|&slot| mask[feet.at(slot).0]).collect();
        }
        for (bounds, fade) in FADES.into_iter().zip(&mut runs.fades) {
            if self.wire.domains.iter().any(|domain| domain.bounds == bounds) {
                fade.resize(count, 1.0);
            }
        }
        Measure { wire: self.wire, spans: self.spans, cells: self.cells }.tile(tile, &mut runs);
        runs
    }

    /// Counting sort of feet by cell; within a cell they keep their order.
    fn by_cell(self, slots: impl Iterator<Item = u32>, feet: TileFeet<'_>) -> (TileRuns, Vec<u32>) {
        let cell = |slot: u32| {
            let (_, foot) = feet.at(slot);
            (self.cells.find(foot.span, foot.t), slot)
        };
        let bound: Vec<(u32, u32)> = slots.map(cell).collect();
        let mut starts = vec![0; self.cells.list.len() + 1];
        for &(cell, _) in &bound {
            starts[cell as usize + 1] += 1;
        }
        let mut runs = TileRuns::default();
        for cell in 0..self.cells.list.len() {
            let (start, end) = (starts[cell], starts[cell] + starts[cell + 1]);
            if start < end {
                runs.list.push(Run { cell: cell as u32, start, end });
            }
            starts[cell + 1] = end;
        }
        let mut sorted = vec![0; bound.len()];
        for &(cell, slot) in &bound {
            let next = &mut starts[cell as usize];
            sorted[*next as usize] = slot;
            *next += 1;
        }
        (runs, sorted)
    }

    /// Drops the feet that neither the wire's radius nor a domain curve can reach.
    fn drop_unreached(self, runs: &mut TileRuns, slots: &mut Vec<u32>, feet: TileFeet<'_>) {
        let reach: Vec<bool> = (0..slots.len())
            .map(|i| {
                let extends = |(side, domain): (&Vec<Side>, &DomainCurve)| domain.reaches(side[i]);
                let far =
                    runs.sides.iter().zip(self.sought.domains).map(extends).fold(self.sought.reach, f64::max);
                feet.at(slots[i]).1.distance < far
            })
            .collect();
        let mut kept = 0;
        for run in &mut runs.list {
            let inside = &reach[run.start as usize..run.end as usize];
            run.start = kept;
            kept += inside.iter().filter(|reaches| **reaches).count() as u32;
            run.end = kept;
        }
        runs.list.retain(|run| run.start < run.end);
        let mut flags = reach.iter();
        slots.retain(|_| flags.next() == Some(&true));
        for side in &mut runs.sides {
            let mut flags = reach.iter();
            side.retain(|_| flags.next() == Some(&true));
        }
    }
}

/// How the points of a tile stand to the domain curves; compiled for the vector instructions the processor has.
struct Stand<'a> {
    bound: Bound<'a>,
    tile: &'a Tile,
    feet: TileFeet<'a>,
    slots: &'a [u32],
    list: &'a [Run],
}

impl pulp::WithSimd for Stand<'_> {
    type Output = Vec<Vec<Side>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Bound { spans, cells, sought, .. } = self.bound;
        let mut sides: Vec<Vec<Side>> = vec![Vec::with_capacity(self.slots.len()); sought.domains.len()];
        let (mut near, mut points) = (Vec::new(), Vec::with_capacity(BLOCK));
        for run in self.list {
            let cell = cells.list[run.cell as usize];
            // Feet in one cell lie together, and so do their points.
            for slots in self.slots[run.start as usize..run.end as usize].chunks(BLOCK) {
                points.clear();
                for &slot in slots {
                    let (point, foot) = self.feet.at(slot);
                    let (span, t) = cell.place(f64::from(foot.t), spans.cubics.len());
                    points.push(Footed { point: self.tile.position(point), foot: spans.cubics[span].at(t) });
                }
                for (domain, out) in sought.domains.iter().zip(&mut sides) {
                    domain.stand(simd, &points, &mut near, out);
                }
            }
        }
        sides
    }
}
