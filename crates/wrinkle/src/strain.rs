//! Creases that the surface's own compression raises.
//!
//! How much a surface is pushed together across a crease is the length of the crease's sideways direction after over before it
//! moved, read in each triangle round a node and averaged by area: a mean of metrics, so that it neither depends on the
//! triangulation nor takes bending for shortening.

use std::collections::{HashSet, VecDeque};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use wirework_surface::Terrain;

use crate::WrinkleError;
use crate::crease::Crease;
use crate::ground::{Ground, wide};
use crate::spread::Spread;

/// How compression raises creases. However short the stretch that is compressed, a fold rises and fades along its crease over about its
/// thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// The part of its length that the surface loses across a crease when that begins to rise, 0 or greater. Default 0.02.
    pub from: f32,
    /// And when it stands full, greater than `from`. Default 0.2.
    pub to: f32,
    /// The distance over which compression is averaged, in the unit of the surface, > 0. Default none: twice the thickness.
    pub radius: Option<f32>,
    /// The time over which compression is averaged, in seconds, 0 or greater. Default 0.1. It needs a record of more than one moment.
    pub settle: f32,
}

impl Default for Strain {
    fn default() -> Self {
        Self { from: 0.02, to: 0.2, radius: None, settle: 0.1 }
    }
}

impl Strain {
    pub(crate) fn check(&self) -> Result<(), WrinkleError> {
        let refuse = |field, expected, found| Err(WrinkleError::Value { field, expected, found });
        if !(0.0..1.0).contains(&self.from) {
            return refuse("from", "at least 0 and less than 1", self.from);
        }
        if !(self.to > self.from && self.to <= 1.0) {
            return refuse("to", "greater than `from`, at most 1", self.to);
        }
        if let Some(found) = self.radius.filter(|radius| !(*radius > 0.0 && radius.is_finite())) {
            return refuse("radius", "greater than 0", found);
        }
        if !(self.settle >= 0.0 && self.settle.is_finite()) {
            return refuse("settle", "0 or greater", self.settle);
        }
        Ok(())
    }

    /// The part of its height that a crease has at a compression: smoothly from 0 to 1.
    fn raise(&self, compression: f32) -> f64 {
        let (from, to) = (f64::from(self.from), f64::from(self.to));
        let x = ((f64::from(compression) - from) / (to - from)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }
}

/// What reads the compression of a surface at the nodes of creases.
#[derive(Clone, Debug)]
pub(crate) struct Gauges {
    /// For each crease a list for each node.
    nodes: Vec<Vec<Gauge>>,
}

/// At one node: the triangles round it.
#[derive(Clone, Debug)]
struct Gauge(Vec<Strand>);

/// The sideways direction in one triangle, as a sum of its edges from the first corner.
#[derive(Clone, Copy, Debug)]
struct Strand {
    corners: [u32; 3],
    along: [f32; 2],
    /// Its part of the mean, over its length at rest once that is known.
    weight: f32,
    /// Its part of the mean.
    share: f32,
}

/// A triangle of which less than this part of its length is left has collapsed: parts of a model are hidden by scaling them to nothing,
/// and no cloth is pushed together so far. It says nothing of compression.
pub(crate) const COLLAPSED: f32 = 1e-3;

/// Triangles that a gauge looks at, at most: of more, some of all distances stand for the others. With 128 an arm of twice as many
/// triangles a way had folds 8 % of their height off those of the coarser one; looked at whole, 0.8 %.
const MOST_STRANDS: usize = 1024;
/// Triangles round a node that are looked at, at most, the nearest: a radius that holds more is larger than any fold.
const MOST_SEEN: usize = 1 << 14;

impl Gauges {
    /// At the nodes of creases where they were laid; `radius` in the unit of the surface.
    pub(crate) fn new(ground: &Ground, creases: &[Crease], radius: f64) -> Self {
        let nodes = |crease: &Crease| {
            let points: Vec<DVec3> = crease.reference.points().iter().map(|p| wide(*p)).collect();
            let node = |(i, anchor): (usize, &crate::ground::Anchor)| {
                let ahead = points[(i + 1).min(points.len() - 1)] - points[i.saturating_sub(1)];
                let normal = wide(crease.lift[i]).normalize_or_zero();
                let across = normal.cross(ahead).normalize_or_zero();
                Gauge::new(&ground.terrain, anchor.triangle, points[i], across, radius)
            };
            crease.anchors.iter().enumerate().map(node).collect()
        };
        Self { nodes: creases.par_iter().map(nodes).collect() }
    }

    /// The same, knowing where the surface is at rest.
    pub(crate) fn against(mut self, rest: &[[f32; 3]]) -> Self {
        self.nodes.par_iter_mut().flatten().for_each(|gauge| gauge.against(rest));
        self
    }

    /// The compression at every node, one crease after the other, of the surface at `now` against its rest: 0 none, 1 all of
    /// the length is gone, negative where it is stretched.
    pub(crate) fn read(&self, now: &[[f32; 3]]) -> Vec<f32> {
        let all: Vec<&Gauge> = self.nodes.iter().flatten().collect();
        all.par_iter().with_min_len(16).map(|gauge| gauge.read(now)).collect()
    }
}

impl Gauge {
    /// From the triangles round a point that lies in one of them.
    fn new(terrain: &Terrain, triangle: u32, at: DVec3, across: DVec3, radius: f64) -> Self {
        let mut strands = Vec::new();
        let (mut seen, mut queue) = (HashSet::from([triangle]), VecDeque::from([triangle]));
        while let Some(triangle) = queue.pop_front() {
            let corners = terrain.corners_of(triangle).map(DVec3::from);
            let center = (corners[0] + corners[1] + corners[2]) / 3.0;
            let x = center.distance(at) / radius;
            let first = strands.is_empty();
            if x >= 1.0 && !first {
                continue;
            }
            // Where triangles are larger than the radius, the one it lies in says all.
            let kernel = if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 };
            let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            if let Some(along) = along(corners, across) {
                let weight = (kernel.max(1e-6) * area) as f32;
                strands.push(Strand { corners: terrain.places_of(triangle), along, weight, share: 0.0 });
            }
            for next in terrain.neighbours(triangle) {
                if seen.len() < MOST_SEEN && seen.insert(next) {
                    queue.push_back(next);
                }
            }
        }
        let count = strands.len();
        if count > MOST_STRANDS {
            // They are in the order of their distance.
            strands = (0..MOST_STRANDS).map(|i| strands[i * count / MOST_STRANDS]).collect();
        }
        Self(strands)
    }

    fn against(&mut self, rest: &[[f32; 3]]) {
        for strand in &mut self.0 {
            let length = strand.length(rest);
            (strand.share, strand.weight) =
                if length > 0.0 { (strand.weight, strand.weight / length) } else { (0.0, 0.0) };
        }
        let sum: f32 = self.0.iter().map(|strand| strand.share).sum();
        if sum > 0.0 {
            for strand in &mut self.0 {
                (strand.share, strand.weight) = (strand.share / sum, strand.weight / sum);
            }
        }
    }

    fn read(&self, now: &[[f32; 3]]) -> f32 {
        let (mut left, mut known) = (0.0, 0.0);
        for strand in &self.0 {
            let length = strand.weight * strand.length(now);
            // NaN is not greater.
            if length > COLLAPSED * strand.share && length.is_finite() {
                (left, known) = (left + length, known + strand.share);
            }
        }
        // Without a triangle that has an area nothing is known.
        if known > 0.0 { 1.0 - left / known } else { 0.0 }
    }
}

impl Strand {
    #[inline]
    fn length(&self, positions: &[[f32; 3]]) -> f32 {
        let [Some(a), Some(b), Some(c)] = self.corners.map(|corner| positions.get(corner as usize)) else {
            return f32::NAN;
        };
        let (a, b, c) = (Vec3::from(*a), Vec3::from(*b), Vec3::from(*c));
        ((b - a) * self.along[0] + (c - a) * self.along[1]).length()
    }
}

/// A direction, laid into a triangle, as a sum of its edges from the first corner; none where the triangle has no area or
/// stands across the direction.
fn along(corners: [DVec3; 3], direction: DVec3) -> Option<[f32; 2]> {
    let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
    let normal = e.cross(f).try_normalize()?;
    let flat = (direction - normal * direction.dot(normal)).try_normalize()?;
    let area = e.cross(f).dot(normal);
    let x = flat.cross(f).dot(normal) / area;
    let y = e.cross(flat).dot(normal) / area;
    (x.is_finite() && y.is_finite()).then_some([x as f32, y as f32])
}

/// Running means in a window.
const MEANS: usize = 3;

/// The mean of each reading and so many on either side; beyond the ends readings are what they are there. By sums so far, so that a wide
/// window takes no longer than a narrow one.
fn mean(readings: &[Vec<f32>], half: usize) -> Vec<Vec<f32>> {
    let (Some(first), Some(last)) = (readings.first(), readings.last()) else { return Vec::new() };
    let half = half.min(readings.len());
    if half == 0 {
        return readings.to_vec();
    }
    let mut sums = vec![vec![0.0; first.len()]];
    for reading in readings {
        let before = &sums[sums.len() - 1];
        sums.push(before.iter().zip(reading).map(|(sum, r)| sum + f64::from(*r)).collect());
    }
    let count = readings.len();
    let at = |i: usize| {
        let (from, to) = (i.saturating_sub(half), (i + half + 1).min(count));
        let (early, late) = ((from + half - i) as f64, (i + half + 1 - to) as f64);
        let node = |k: usize| {
            let sum = sums[to][k] - sums[from][k];
            let ends = early * f64::from(first[k]) + late * f64::from(last[k]);
            ((sum + ends) / (2 * half + 1) as f64) as f32
        };
        (0..first.len()).map(node).collect()
    };
    (0..count).into_par_iter().map(at).collect()
}

/// What compression does to creases in time: at equal steps from 0 s on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record {
    step: f64,
    /// One after the other: the part of their height that all nodes have.
    heights: Vec<Vec<f32>>,
    most: Option<(f32, f64)>,
}

impl Record {
    /// Of readings at equal steps in seconds, averaged over the time that creases take to settle: three running means one after the other, a
    /// window that falls off to either side, so that what rises does so smoothly. What they raise is spread along the creases.
    pub(crate) fn new(step: f64, mut readings: Vec<Vec<f32>>, strain: &Strain, spread: &Spread) -> Self {
        // A clip without a length has one moment.
        if step > 0.0 {
            let half = (f64::from(strain.settle) / (2.0 * MEANS as f64) / step).round() as usize;
            for _ in 0..MEANS {
                readings = mean(&readings, half);
            }
        }
        let of = |(i, reading): (usize, &Vec<f32>)| {
            let most = reading.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            (most, step * i as f64)
        };
        let all = readings.iter().enumerate().filter(|(_, reading)| !reading.is_empty()).map(of);
        let most = all.reduce(|a, b| if b.0 > a.0 { b } else { a });
        let raised = |reading: &Vec<f32>| {
            let heights: Vec<f32> = reading.iter().map(|c| strain.raise(*c) as f32).collect();
            spread.apply(&heights)
        };
        Self { step, heights: readings.par_iter().map(raised).collect(), most }
    }

    /// The greatest compression there is at any time, and when, seconds; none where nothing is known.
    pub(crate) fn most(&self) -> Option<(f32, f64)> {
        self.most
    }

    /// What part of their height the nodes have at a time; before the first reading and after the last what they have there.
    pub(crate) fn raise(&self, seconds: f64, node: usize) -> f64 {
        let Some(last) = self.heights.len().checked_sub(1) else { return 0.0 };
        let x = if self.step > 0.0 { (seconds / self.step).clamp(0.0, last as f64) } else { 0.0 };
        let i = (x.floor() as usize).min(last.saturating_sub(1));
        let at = |i: usize| self.heights[i.min(last)].get(node).map_or(0.0, |height| f64::from(*height));
        at(i) + (at(i + 1) - at(i)) * (x - i as f64)
    }
}

#[cfg(test)]
#[path = "strain_tests.rs"]
mod tests;
