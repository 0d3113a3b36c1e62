//! Points in tiles of a thousand, coordinates side by side: the unit of binding, deforming and parallelism.

use glam::DVec3;
use rayon::prelude::*;

use crate::block::BLOCK;
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

    #[inline(always)]
    pub(crate) fn position(&self, i: usize) -> DVec3 {
        to_dvec3(self.point(i))
    }
}

/// A ball about some points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

/// A box: its least and greatest corners.
type Bounds = (DVec3, DVec3);

impl Ball {
    fn about((low, high): Bounds) -> Self {
        Self { center: 0.5 * (low + high), radius: 0.5 * (high - low).length() }
    }

    /// The ball about the box of those points that are finite; nothing where none is.
    pub(crate) fn of(points: impl Iterator<Item = DVec3>) -> Option<Self> {
        bounds(points).map(Self::about)
    }
}

/// The box of the points that are finite; nothing where none is.
fn bounds(points: impl Iterator<Item = DVec3>) -> Option<Bounds> {
    let finite = points.filter(|p| p.is_finite());
    finite.map(|p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Least and largest number of a coordinate; an infinity where one is not finite, or none is there.
fn range(row: &[f32]) -> (f64, f64) {
    let (mut low, mut high, mut sum) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8], [0.0; 8]);
    let (eights, rest) = row.as_chunks::<8>();
    let mut take = |i: usize, x: f32| {
        low[i] = if x < low[i] { x } else { low[i] };
        high[i] = if x > high[i] { x } else { high[i] };
        // Zero for finite numbers, NaN for others.
        sum[i] += x * 0.0;
    };
    for eight in eights {
        for (i, &x) in eight.iter().enumerate() {
            take(i, x);
        }
    }
    rest.iter().enumerate().for_each(|(i, &x)| take(i, x));
    if sum.iter().any(|s| *s != 0.0) {
        return (f64::NEG_INFINITY, f64::INFINITY);
    }
    let (low, high) = (low.into_iter().reduce(f32::min), high.into_iter().reduce(f32::max));
    (low.map_or(f64::INFINITY, f64::from), high.map_or(f64::NEG_INFINITY, f64::from))
}

impl Tile {
    /// The box of points `start .. end`.
    fn bounds(&self, start: usize, end: usize) -> Option<Bounds> {
        let ((x0, x1), (y0, y1), (z0, z1)) =
            (range(&self.x[start..end]), range(&self.y[start..end]), range(&self.z[start..end]));
        let (low, high) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
        if low.is_finite() && high.is_finite() {
            return Some((low, high));
        }
        bounds((start..end).map(|i| to_dvec3(self.point(i))))
    }
}

/// Where the points of a tile lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Balls {
    pub(crate) tile: Option<Ball>,
    pub(crate) blocks: [Option<Ball>; TILE / BLOCK],
}

impl Balls {
    fn new(tile: &Tile, count: usize) -> Self {
        let block = |i: usize| tile.bounds((i * BLOCK).min(count), ((i + 1) * BLOCK).min(count));
        let blocks: [Option<Bounds>; TILE / BLOCK] = std::array::from_fn(block);
        let whole = blocks.iter().flatten().copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        Self { tile: whole.map(Ball::about), blocks: blocks.map(|b| b.map(Ball::about)) }
    }
}

/// All points, and the order in which they are searched.
#[derive(Clone, Debug)]
pub(crate) struct Tiles {
    /// The points in their own order.
    pub(crate) list: Vec<Tile>,
    pub(crate) count: usize,
    /// The points by Morton code and their indices, where their own order is scattered.
    sorted: Option<(Vec<Tile>, Vec<u32>)>,
    /// Where the points of each tile lie, in the order of search.
    pub(crate) balls: Vec<Balls>,
}

impl Tiles {
    pub(crate) fn new(points: &[[f32; 3]]) -> Self {
        let list: Vec<Tile> = points.par_chunks(TILE).map(Tile::new).collect();
        let balls = Self::measure(&list, points.len());
        if !scattered(&balls) {
            return Self { list, count: points.len(), sorted: None, balls };
        }
        let order = morton_order(points);
        let gathered = order
            .par_chunks(TILE)
            .map(|chunk| Tile::new(&chunk.iter().map(|&i| points[i as usize]).collect::<Vec<_>>()));
        let sorted: Vec<Tile> = gathered.collect();
        let balls = Self::measure(&sorted, points.len());
        Self { list, count: points.len(), sorted: Some((sorted, order)), balls }
    }

    fn measure(tiles: &[Tile], count: usize) -> Vec<Balls> {
        let of_tile = |(i, tile): (usize, &Tile)| Balls::new(tile, (count - i * TILE).min(TILE));
        tiles.par_iter().enumerate().map(of_tile).collect()
    }

    /// The tiles in the order of search.
    pub(crate) fn searched(&self) -> &[Tile] {
        self.sorted.as_ref().map_or(&self.list, |(tiles, _)| tiles)
    }

    /// The index of each point in the order of search, where that is not the points' own.
    pub(crate) fn order(&self) -> Option<&[u32]> {
        self.sorted.as_ref().map(|(_, order)| order.as_slice())
    }

    /// A ball about all points.
    pub(crate) fn ball(&self) -> Option<Ball> {
        hull(self.balls.iter().filter_map(|b| b.tile))
    }
}

/// The ball about the box of some balls.
fn hull(balls: impl Iterator<Item = Ball>) -> Option<Ball> {
    bounds(balls.flat_map(|b| [b.center - b.radius, b.center + b.radius])).map(Ball::about)
}

fn scattered(balls: &[Balls]) -> bool {
    let blocks = || balls.iter().flat_map(|b| b.blocks).flatten();
    let Some(whole) = hull(blocks()) else { return false };
    let count = blocks().count() as f64;
    let mean = blocks().map(|b| b.radius).sum::<f64>() / count;
    // Points of a surface: a block covers its share of the area.
    mean > SCATTERED * whole.radius / count.sqrt()
}

/// Indices by the Morton code of their points (Morton 1966), equal codes by index.
fn morton_order(points: &[[f32; 3]]) -> Vec<u32> {
    let Some((low, high)) = bounds(points.iter().map(|p| to_dvec3(*p))) else { return Vec::new() };
    let side = (high - low).max_element();
    let scale = if side > 0.0 { 1023.0 / side } else { 0.0 };
    let code = |p: &[f32; 3]| {
        let q = ((to_dvec3(*p) - low) * scale).clamp(DVec3::ZERO, DVec3::splat(1023.0));
        spread(q.x as u32) | spread(q.y as u32) << 1 | spread(q.z as u32) << 2
    };
    let mut keys: Vec<(u32, u32)> = points.iter().map(code).zip(0..).collect();
    let mut sorted = keys.clone();
    // Three counting sorts by ten bits each: a third of the time of a comparison sort at a million points.
    for shift in [0, 10, 20] {
        let digit = |key: &(u32, u32)| (key.0 >> shift & 1023) as usize;
        let mut starts = [0_u32; 1025];
        for key in &keys {
            starts[digit(key) + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        for key in &keys {
            let next = &mut starts[digit(key)];
            sorted[*next as usize] = *key;
            *next += 1;
        }
        std::mem::swap(&mut keys, &mut sorted);
    }
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
    fn a_ball_holds_its_points() {
        let points = grid(50);
        for (tile, balls) in Tiles::new(&points).list.iter().zip(&Tiles::new(&points).balls) {
            for (i, ball) in balls.blocks.iter().enumerate() {
                let Some(ball) = ball else { continue };
                let inside = |k: usize| to_dvec3(tile.point(k)).distance(ball.center) <= ball.radius + 1e-9;
                assert!((i * BLOCK..(i + 1) * BLOCK).all(|k| k >= points.len() % TILE || inside(k)));
            }
        }
    }

    #[test]
    fn rows_of_a_grid_are_not_scattered_and_shuffled_points_are() {
        let rows = grid(300);
        assert!(Tiles::new(&rows).order().is_none());
        let shuffled: Vec<_> = (0..rows.len()).map(|i| rows[i * 7919 % rows.len()]).collect();
        let tiles = Tiles::new(&shuffled);
        let mut order = tiles.order().unwrap().to_vec();
        let blocks: Vec<Ball> = tiles.balls.iter().flat_map(|b| b.blocks).flatten().collect();
        assert!(blocks.iter().map(|b| b.radius).sum::<f64>() / (blocks.len() as f64) < 20.0);
        let first = tiles.searched()[0].point(5);
        assert_eq!(first, shuffled[order[5] as usize]);
        order.sort_unstable();
        assert!(order.into_iter().eq(0..rows.len() as u32));
    }

    #[test]
    fn points_that_are_nowhere_do_not_disturb_the_others() {
        let mut points = grid(40);
        points[3] = [f32::NAN, 0.0, f32::INFINITY];
        let tiles = Tiles::new(&points);
        assert!(tiles.ball().unwrap().radius < 100.0 && tiles.balls[0].blocks[0].unwrap().radius < 100.0);
        assert_eq!(tiles.list[0].point(2), [2.0, 0.0, 0.0]);
    }
}
