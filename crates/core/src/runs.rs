//! Bound points in runs: for every tile and cell the points whose feet lie there, ten bytes a point.
//!
//! All points of a run share the cell's polynomials, so that the deformation loads their coefficients once and then
//! streams through indices, places and influences.

use rayon::prelude::*;

use crate::attributes::{Attribute, value};
use crate::block::{BLOCK, Feet};
use crate::cells::{Cell, Cells};
use crate::closest::{Candidate, Pieces};
use crate::kernel::RunPoints;
use crate::tiles::{Balls, TILE, Tile, Tiles};
use crate::{Wire, spans::Spans};

/// A point's foot as it is kept: segment, place in it and distance; an infinite distance means no foot in reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StoredFoot {
    pub(crate) span: u32,
    pub(crate) t: f32,
    pub(crate) distance: f64,
}

const NO_FOOT: StoredFoot = StoredFoot { span: 0, t: 0.0, distance: f64::INFINITY };

/// Consecutive bound points of one tile and cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) cell: u32,
    pub(crate) start: u32,
    pub(crate) end: u32,
}

/// All runs of one wire.
#[derive(Clone, Debug, Default)]
pub(crate) struct Runs {
    /// Index of the point in its tile.
    pub(crate) index: Vec<u16>,
    /// Place of the foot in its segment.
    pub(crate) t: Vec<f32>,
    /// `F`.
    pub(crate) influence: Vec<f32>,
    /// Distance from the foot; cold, read only when radii or the density change. In float64, for a point at the very
    /// edge of the influence counts in the blend, or does not.
    distance: Vec<f64>,
    list: Vec<Run>,
    /// The first run of each tile, and the number of runs at the end.
    tiles: Vec<u32>,
}

impl Runs {
    /// Runs of a tile.
    #[inline]
    pub(crate) fn of_tile(&self, tile: usize) -> &[Run] {
        match (self.tiles.get(tile), self.tiles.get(tile + 1)) {
            (Some(&start), Some(&end)) => &self.list[start as usize..end as usize],
            _ => &[],
        }
    }

    /// The points of a run.
    #[inline(always)]
    pub(crate) fn points(&self, run: &Run) -> RunPoints<'_> {
        let range = run.start as usize..run.end as usize;
        RunPoints {
            index: &self.index[range.clone()],
            t: &self.t[range.clone()],
            influence: &self.influence[range],
        }
    }

    /// Finds the feet of all points within `reach` and sorts them into runs, a tile at a time.
    pub(crate) fn bind(
        wire: &Wire,
        spans: &Spans,
        cells: &Cells,
        pieces: &Pieces,
        tiles: &Tiles,
        reach: f64,
    ) -> Self {
        if tiles.order().is_some() {
            let feet = find_feet(pieces, tiles, reach);
            return Self::new(wire, spans, cells, &feet, &|_| true);
        }
        let all = pieces.all();
        let part = |(i, (tile, balls)): (usize, (&Tile, &Balls))| {
            let mut feet = [NO_FOOT; TILE];
            let feet = &mut feet[..(tiles.count - i * TILE).min(TILE)];
            let reached = search_tile(pieces, tile, balls, &all, reach, feet);
            if reached { tile_runs(cells, feet, |_| true) } else { Self::default() }
        };
        let parts = tiles.searched().par_iter().zip(&tiles.balls).enumerate().map(part).collect();
        Self::join(wire, spans, cells, parts)
    }

    /// Sorts the feet that `acts` admits into runs.
    pub(crate) fn new(wire: &Wire, spans: &Spans, cells: &Cells, feet: &[StoredFoot], acts: Acts) -> Self {
        let parts = feet
            .par_chunks(TILE)
            .enumerate()
            .map(|(tile, feet)| tile_runs(cells, feet, |i| acts(tile * TILE + i)))
            .collect();
        Self::join(wire, spans, cells, parts)
    }

    /// The runs of all tiles one after the other, with their influence.
    fn join(wire: &Wire, spans: &Spans, cells: &Cells, parts: Vec<Self>) -> Self {
        let count = parts.iter().map(|p| p.index.len()).sum();
        let mut all = Self {
            index: Vec::with_capacity(count),
            t: Vec::with_capacity(count),
            distance: Vec::with_capacity(count),
            ..Self::default()
        };
        for part in parts {
            let offset = all.index.len() as u32;
            all.tiles.push(all.list.len() as u32);
            all.list.extend(part.list.iter().map(|r| Run {
                start: r.start + offset,
                end: r.end + offset,
                ..*r
            }));
            all.index.extend(part.index);
            all.t.extend(part.t);
            all.distance.extend(part.distance);
        }
        all.tiles.push(all.list.len() as u32);
        all.influence.resize(count, 0.0);
        all.measure(wire, spans, cells);
        all
    }

    /// Computes `F` anew from the distances: after a change of radii or density.
    pub(crate) fn measure(&mut self, wire: &Wire, spans: &Spans, cells: &Cells) {
        let n = spans.cubics.len() as f64;
        let varies = wire.locators.iter().any(|l| l.radius.is_some());
        let uniform = value(wire, Attribute::Radius, 0.0);
        for run in &self.list {
            for i in run.start as usize..run.end as usize {
                let u = match cells.list[run.cell as usize] {
                    Cell::Stretch { span, .. } => (span as f64 + f64::from(self.t[i])) / n,
                    Cell::Joint { u, .. } => u,
                };
                let radius = if varies { value(wire, Attribute::Radius, u) } else { uniform };
                self.influence[i] = wire.density.at(self.distance[i] / radius) as f32;
            }
        }
    }
}

/// Whether a wire acts on a point, by the point's index.
pub(crate) type Acts<'a> = &'a (dyn Fn(usize) -> bool + Sync);

/// Counting sort of a tile's feet by cell; within a cell by index.
fn tile_runs(cells: &Cells, feet: &[StoredFoot], acts: impl Fn(usize) -> bool) -> Runs {
    let bound: Vec<(u32, u16)> = (0..feet.len())
        .filter(|&i| feet[i].distance.is_finite() && acts(i))
        .map(|i| (cells.find(feet[i].span, feet[i].t), i as u16))
        .collect();
    let mut starts = vec![0; cells.list.len() + 1];
    for &(cell, _) in &bound {
        starts[cell as usize + 1] += 1;
    }
    let mut runs = Runs::default();
    for cell in 0..cells.list.len() {
        let (start, end) = (starts[cell], starts[cell] + starts[cell + 1]);
        if start < end {
            runs.list.push(Run { cell: cell as u32, start, end });
        }
        starts[cell + 1] = end;
    }
    runs.index.resize(bound.len(), 0);
    for &(cell, i) in &bound {
        let next = &mut starts[cell as usize];
        runs.index[*next as usize] = i;
        *next += 1;
    }
    runs.t = runs.index.iter().map(|&i| feet[i as usize].t).collect();
    runs.distance = runs.index.iter().map(|&i| feet[i as usize].distance).collect();
    runs
}

/// The feet of all points within `reach` of the curve.
pub(crate) fn find_feet(pieces: &Pieces, tiles: &Tiles, reach: f64) -> Vec<StoredFoot> {
    let mut feet = vec![NO_FOOT; tiles.count];
    let all = pieces.all();
    let tasks = feet.par_chunks_mut(TILE).zip(tiles.searched()).zip(&tiles.balls);
    tasks.for_each(|((out, tile), balls)| {
        search_tile(pieces, tile, balls, &all, reach, out);
    });
    let Some(order) = tiles.order() else { return feet };
    let mut by_index = vec![NO_FOOT; tiles.count];
    for (foot, &i) in feet.iter().zip(order) {
        by_index[i as usize] = *foot;
    }
    by_index
}

/// Searches the points of a tile, as many as `out` holds; whether the curve may reach any.
fn search_tile(
    pieces: &Pieces,
    tile: &Tile,
    balls: &Balls,
    all: &[Candidate],
    reach: f64,
    out: &mut [StoredFoot],
) -> bool {
    let Some(ball) = balls.tile else { return false };
    let apart = ball.center.distance(pieces.ball.center) - ball.radius - pieces.ball.radius;
    if apart > reach {
        return false;
    }
    pulp::Arch::new().dispatch(Search { pieces, tile, balls, all, reach, out });
    true
}

/// The search, compiled for the vector instructions the processor has.
struct Search<'a> {
    pieces: &'a Pieces,
    tile: &'a Tile,
    balls: &'a Balls,
    all: &'a [Candidate],
    reach: f64,
    out: &'a mut [StoredFoot],
}

impl pulp::WithSimd for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self { pieces, tile, balls, all, reach, out } = self;
        let (mut of_tile, mut candidates) = (Vec::new(), Vec::new());
        let Some(ball) = balls.tile else { return };
        pieces.cull(ball, reach, all, &mut of_tile);
        let (mut block, mut feet) = (pieces.block(), Feet::new());
        for ((k, out), ball) in out.chunks_mut(BLOCK).enumerate().zip(balls.blocks) {
            let Some(ball) = ball else { continue };
            pieces.cull(ball, reach, &of_tile, &mut candidates);
            if candidates.is_empty() {
                continue;
            }
            block.fill(tile, k * BLOCK, out.len());
            pieces.search(simd, &block, &candidates, reach, &mut feet);
            for (i, out) in out.iter_mut().enumerate().take(BLOCK) {
                if feet.distance[i] < reach {
                    let (span, t, distance) = (feet.span[i], feet.t[i] as f32, feet.distance[i]);
                    *out = StoredFoot { span, t, distance };
                }
            }
        }
    }
}
