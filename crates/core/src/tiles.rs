//! Points in tiles of a thousand, coordinates side by side: the unit of binding, deforming and parallelism.

use glam::DVec3;
use rayon::prelude::*;

use crate::closest::BLOCK;
use crate::spans::to_dvec3;

/// Points a tile: its coordinates and accumulators stay in the first-level cache, and a point's index fits 16 bits.
pub(crate) const TILE: usize = 1024;

/// Points are taken as scattered, and searched in Morton order, when a block of consecutive ones is this many times as
/// wide as a block of neighbours would be. Meshes come in between: rows of a grid of a million points give 11.
const SCATTERED: f64 = 20.0;

/// Up to [`TILE`] consecutive points; the rest is padding.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    pub(crate) x: [f32; TILE],
    pub(crate) y: [f32; TILE],
    pub(crate) z: [f32; TILE],
}

impl Tile {
    fn new(points: &[[f32; 3]]) -> Self {
        let mut tile = Self { x: [0.0; TILE], y: [0.0; TILE], z: [0.0; TILE] };
        for (i, p) in points.iter().enumerate().take(TILE) {
            (tile.x[i], tile.y[i], tile.z[i]) = (p[0], p[1], p[2]);
        }
        tile
    }

    #[inline(always)]
    pub(crate) fn point(&self, i: usize) -> [f32; 3] {
        let i = i & (TILE - 1);
        [self.x[i], self.y[i], self.z[i]]
    }
}

/// A box's centre and half diagonal; nothing for no finite point.
pub(crate) fn ball(points: impl Iterator<Item = DVec3>) -> Option<(DVec3, f64)> {
    let finite = points.filter(|p| p.is_finite());
    let (low, high) = finite
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    (low.x <= high.x).then(|| (0.5 * (low + high), 0.5 * (high - low).length()))
}

/// All points, and the order in which they are searched.
#[derive(Clone, Debug)]
pub(crate) struct Tiles {
    pub(crate) tiles: Vec<Tile>,
    pub(crate) count: usize,
    /// A permutation that makes blocks compact, where the points' own order does not.
    pub(crate) order: Option<Vec<u32>>,
}

impl Tiles {
    pub(crate) fn new(points: &[[f32; 3]]) -> Self {
        let tiles = points.par_chunks(TILE).map(Tile::new).collect();
        let order = scattered(points).then(|| morton_order(points));
        Self { tiles, count: points.len(), order }
    }

    pub(crate) fn point(&self, i: usize) -> DVec3 {
        to_dvec3(self.tiles[i / TILE].point(i % TILE))
    }

    /// The index of the `i`-th point in the order of search.
    #[inline(always)]
    pub(crate) fn searched(&self, i: usize) -> usize {
        self.order.as_ref().map_or(i, |order| order[i] as usize)
    }
}

fn scattered(points: &[[f32; 3]]) -> bool {
    let Some((_, whole)) = ball(points.iter().map(|p| to_dvec3(*p))) else { return false };
    let blocks = points.len().div_ceil(BLOCK);
    let radii = points.chunks(BLOCK).filter_map(|c| ball(c.iter().map(|p| to_dvec3(*p))));
    let mean = radii.map(|(_, r)| r).sum::<f64>() / blocks as f64;
    // Points of a surface: a block covers its share of the area.
    mean > SCATTERED * whole / (blocks as f64).sqrt()
}

/// Indices by the Morton code of their points (Morton 1966), equal codes by index.
fn morton_order(points: &[[f32; 3]]) -> Vec<u32> {
    let (center, radius) = ball(points.iter().map(|p| to_dvec3(*p))).unwrap_or_default();
    let scale = if radius > 0.0 { 1023.0 / (2.0 * radius) } else { 0.0 };
    let code = |p: &[f32; 3]| {
        let q = ((to_dvec3(*p) - center + radius) * scale).clamp(DVec3::ZERO, DVec3::splat(1023.0));
        spread(q.x as u32) | spread(q.y as u32) << 1 | spread(q.z as u32) << 2
    };
    let mut keys: Vec<(u32, u32)> = points.iter().map(code).zip(0..).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|(_, i)| i).collect()
}

/// Two zero bits before each of ten bits.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> Vec<[f32; 3]> {
        (0..n * n).map(|i| [(i % n) as f32, 0.0, (i / n) as f32]).collect()
    }

    #[test]
    fn rows_of_a_grid_are_not_scattered_and_shuffled_points_are() {
        let rows = grid(300);
        assert!(Tiles::new(&rows).order.is_none());
        let shuffled: Vec<_> = (0..rows.len()).map(|i| rows[i * 7919 % rows.len()]).collect();
        let tiles = Tiles::new(&shuffled);
        let mut order = tiles.order.clone().unwrap();
        let blocks = order.chunks(BLOCK).map(|b| ball(b.iter().map(|&i| tiles.point(i as usize))).unwrap().1);
        assert!(blocks.sum::<f64>() / (rows.len() as f64 / BLOCK as f64) < 20.0);
        order.sort_unstable();
        assert!(order.into_iter().eq(0..rows.len() as u32));
    }

    #[test]
    fn points_that_are_nowhere_do_not_disturb_the_others() {
        let mut points = grid(40);
        points[3] = [f32::NAN, 0.0, f32::INFINITY];
        assert!(ball(points.iter().map(|p| to_dvec3(*p))).unwrap().1.is_finite());
        let tiles = Tiles::new(&points);
        assert_eq!(tiles.tiles[0].point(2), [2.0, 0.0, 0.0]);
    }
}
