//! What lies near a line on a surface, by ways over the surface.
//!
//! A wire reaches through the air: from the front of a shirt to its back. Here the places near a line are found from neighbour to
//! neighbour, starting where the line lies, so that another sheet of the surface is never met; and where the surface turns away
//! from the line, as at a hem, their distance is measured along it, so that what lies behind fades rather than steps.
//!
//! Distances over the surface are those of a front that marches from triangle to triangle (Kimmel and Sethian, "Computing
//! geodesic paths on manifolds", 1998): within a few percent, which the fade does not show.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};

use crate::terrain::{Step, Terrain};

/// Ways over the surface up to so many radii count as if through the air: more than a surface that turns by less than
/// [`FACING`] can ask for, and than the march overestimates.
const FULL: f64 = 1.6;
/// From so many radii on nothing of it counts.
const GONE: f64 = 2.2;
/// How far in radii, through the air, a way of [`GONE`] radii over the surface may stray before it ends within one: places
/// are sought so far, lest those beyond a hem come up all at once when it comes near.
const STRAY: f64 = f64::midpoint(1.0, GONE);
/// The cosine between the normals of the line and of a place above which a way over the surface is no longer than
/// [`FULL`] times that through the air.
const FACING: f64 = 0.7;

/// Vertices near a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Near {
    /// Which, rising.
    pub vertices: Vec<u32>,
    /// For each of them a factor from 0 to 1; empty: 1 each.
    pub factors: Vec<f32>,
}

/// Room for [`Terrain::near`], to be used again.
#[derive(Clone, Debug, Default)]
pub struct NearBuffer {
    /// For each place the square of its distance from the line, and the point of the line that is nearest; what is not touched
    /// is [`UNKNOWN`].
    air: Vec<(f32, u32)>,
    touched: Vec<u32>,
    stack: Vec<u32>,
    /// A bit for each vertex.
    bits: Vec<u64>,
    /// For each place its distance over the surface, and whether that is final. Filled in where it is needed.
    over: Vec<(f64, bool)>,
    marched: Vec<u32>,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

const UNKNOWN: (f32, u32) = (f32::INFINITY, u32::MAX);

impl Terrain {
    /// The vertices within `radius` of a line through points of the surface, as far as the surface leads there. All vertices at
    /// one position are found together.
    pub fn near(&self, line: &[Step], radius: f64, buffer: &mut NearBuffer) -> Near {
        let count = self.adjacency.place_of.len();
        buffer.air.resize(count, UNKNOWN);
        buffer.bits.resize(count.div_ceil(64), 0);
        let mut search = Search { terrain: self, line: Line::new(self, line), radius, buffer };
        search.flood();
        let mut places = search.within();
        let mut over = Vec::new();
        if search.doubtful(&places) {
            search.march();
            places.retain(|&place| search.over(place) < GONE * radius);
            over.extend(places.iter().map(|&place| fade(search.over(place) / radius) as f32));
            for place in buffer.marched.drain(..) {
                buffer.over[place as usize] = (f64::INFINITY, false);
            }
        }
        for place in buffer.touched.drain(..) {
            buffer.air[place as usize] = UNKNOWN;
        }
        self.vertices(&places, &over, &mut buffer.bits)
    }

    /// The vertices that ways of at most `reach` over the surface lead to from a line through points of it, rising, and how long
    /// the shortest is: within a few percent.
    pub fn ways(&self, line: &[Step], reach: f64, buffer: &mut NearBuffer) -> Vec<(u32, f64)> {
        let mut search = Search { terrain: self, line: Line::new(self, line), radius: reach / GONE, buffer };
        search.march();
        let mut out = Vec::new();
        for place in std::mem::take(&mut buffer.marched) {
            let (over, _) = std::mem::replace(&mut buffer.over[place as usize], (f64::INFINITY, false));
            if over <= reach {
                out.extend(self.at_place(place).map(|vertex| (vertex, over)));
            }
        }
        out.sort_unstable_by_key(|(vertex, _)| *vertex);
        out
    }

    /// All vertices at places, with the factors of these, rising.
    fn vertices(&self, places: &[u32], factors: &[f32], bits: &mut [u64]) -> Near {
        if !factors.is_empty() {
            let all = |(&factor, &place): (&f32, &u32)| self.at_place(place).map(move |v| (v, factor));
            let mut all: Vec<(u32, f32)> = factors.iter().zip(places).flat_map(all).collect();
            all.sort_unstable_by_key(|(vertex, _)| *vertex);
            let (vertices, factors) = all.into_iter().unzip();
            return Near { vertices, factors };
        }
        // Bits are in order; sorting would take as long as finding them did.
        let mut count = 0;
        let (mut low, mut high) = (bits.len(), 0);
        let mut mark = |vertex: u32| {
            let word = vertex as usize / 64;
            bits[word] |= 1 << (vertex % 64);
            (low, high) = (low.min(word), high.max(word + 1));
            count += 1;
        };
        for &place in places {
            self.at_place(place).for_each(&mut mark);
        }
        let mut vertices = Vec::with_capacity(count);
        for (word, bits) in bits.iter_mut().enumerate().take(high).skip(low) {
            let mut left = std::mem::take(bits);
            while left != 0 {
                vertices.push(word as u32 * 64 + left.trailing_zeros());
                left &= left - 1;
            }
        }
        Near { vertices, factors: Vec::new() }
    }
}

impl Terrain {
    /// The longest edge at a place.
    fn longest(&self, place: u32) -> f64 {
        let here = self.positions[place as usize];
        let length = |&corner: &u32| self.positions[corner as usize].distance(here);
        self.adjacency.beside(place).iter().map(length).fold(0.0, f64::max)
    }
}

/// 1 up to [`FULL`], 0 from [`GONE`] on.
fn fade(radii: f64) -> f64 {
    let x = ((radii - FULL) / (GONE - FULL)).clamp(0.0, 1.0);
    1.0 - x * x * (3.0 - 2.0 * x)
}

/// A line on the surface.
struct Line<'a> {
    steps: &'a [Step],
    points: Vec<Vec3>,
    /// Zero where there is none.
    normals: Vec<DVec3>,
    /// The square of half the longest way between two points: so much farther than the line a point of it may be.
    slack: f32,
}

impl<'a> Line<'a> {
    fn new(terrain: &Terrain, steps: &'a [Step]) -> Self {
        let normal = |step: &Step| terrain.normal(step.triangle, DVec3::from(step.weights));
        let points: Vec<Vec3> = steps.iter().map(|step| DVec3::from(step.position).as_vec3()).collect();
        let longest = points.windows(2).map(|pair| pair[0].distance_squared(pair[1])).fold(0.0, f32::max);
        let normals = steps.iter().map(|step| normal(step).unwrap_or_default()).collect();
        Self { steps, points, normals, slack: longest / 4.0 }
    }

    /// The point near number `from` that is nearest to `p`, and the square of its distance.
    #[inline]
    fn descend(&self, p: Vec3, from: u32) -> (f32, u32) {
        let off = |i: usize| self.points[i].distance_squared(p);
        let (mut at, mut least) = (from as usize, off(from as usize));
        let start = at;
        while at + 1 < self.points.len() {
            let next = off(at + 1);
            if next >= least {
                break;
            }
            (at, least) = (at + 1, next);
        }
        while at <= start {
            let Some(before) = at.checked_sub(1) else { break };
            let next = off(before);
            if next >= least {
                break;
            }
            (at, least) = (before, next);
        }
        (least, at as u32)
    }

    /// How far a place is from the line near its point `from`.
    fn distance(&self, p: DVec3, from: u32) -> f64 {
        let (_, at) = self.descend(p.as_vec3(), from);
        let at = at as usize;
        let before = at.checked_sub(1).map(|before| self.segment(p, before));
        let after = (at + 1 < self.points.len()).then(|| self.segment(p, at));
        let own = DVec3::from(self.steps[at].position).distance_squared(p);
        before.into_iter().chain(after).fold(own, f64::min).sqrt()
    }

    /// The squared distance from the segment between a point and the next.
    fn segment(&self, p: DVec3, i: usize) -> f64 {
        let [a, b] = [i, i + 1].map(|i| DVec3::from(self.steps[i].position));
        let square = (b - a).length_squared();
        let x = if square > 0.0 { ((p - a).dot(b - a) / square).clamp(0.0, 1.0) } else { 0.0 };
        a.lerp(b, x).distance_squared(p)
    }
}

struct Search<'a> {
    terrain: &'a Terrain,
    line: Line<'a>,
    radius: f64,
    buffer: &'a mut NearBuffer,
}

impl Search<'_> {
    fn over(&self, place: u32) -> f64 {
        self.buffer.over[place as usize].0
    }

    /// The square of a distance from the line, as points of it have it.
    fn square(&self, distance: f64) -> f32 {
        (distance * distance) as f32 + self.line.slack
    }

    /// Places within the radius, and a few beyond.
    fn within(&self) -> Vec<u32> {
        let most = self.square(self.radius);
        let within = |place: &&u32| self.buffer.air[**place as usize].0 < most;
        self.buffer.touched.iter().filter(within).copied().collect()
    }

    /// Whether one of the places faces another way than the line.
    fn doubtful(&self, places: &[u32]) -> bool {
        let facing = |&place: &u32| {
            let (_, point) = self.buffer.air[place as usize];
            self.terrain.normals[place as usize].dot(self.line.normals[point as usize]) > FACING
        };
        !places.iter().all(facing)
    }

    /// Finds distances through the air, from neighbour to neighbour.
    fn flood(&mut self) {
        let terrain = self.terrain;
        let stray = self.square(STRAY * self.radius);
        for from in 0..self.line.steps.len() {
            for place in terrain.adjacency.triangles[self.line.steps[from].triangle as usize] {
                self.offer(place, from as u32);
                // The line lies in this triangle, however far its corners are; but so far that the square is beyond f32.
                if self.buffer.air[place as usize] != UNKNOWN {
                    self.buffer.stack.push(place);
                }
            }
        }
        while let Some(place) = self.buffer.stack.pop() {
            let (_, from) = self.buffer.air[place as usize];
            for &next in terrain.adjacency.beside(place) {
                if self.offer(next, from) {
                    let air = self.buffer.air[next as usize].0;
                    // A long edge may lead out of the radius and into it again.
                    if air < stray || f64::from(air).sqrt() < self.radius + terrain.longest(next) {
                        self.buffer.stack.push(next);
                    }
                }
            }
        }
    }

    /// Takes up the distance of a place from the line near its point `from`, if that is the least so far.
    #[inline]
    fn offer(&mut self, place: u32, from: u32) -> bool {
        let known = self.buffer.air[place as usize];
        // From a point beside the one that is nearest one comes to that again.
        if known.1.abs_diff(from) <= 1 {
            return false;
        }
        let found = self.line.descend(self.terrain.positions[place as usize].as_vec3(), from);
        if found.0 >= known.0 {
            return false;
        }
        if known.1 == u32::MAX {
            self.buffer.touched.push(place);
        }
        self.buffer.air[place as usize] = found;
        true
    }

    /// Finds distances over the surface, up to [`GONE`] radii.
    fn march(&mut self) {
        self.buffer.over.resize(self.terrain.positions.len(), (f64::INFINITY, false));
        for from in 0..self.line.steps.len() {
            for place in self.terrain.adjacency.triangles[self.line.steps[from].triangle as usize] {
                let distance = self.line.distance(self.terrain.positions[place as usize], from as u32);
                self.reach(place, distance);
            }
        }
        while let Some(Reverse((_, place))) = self.buffer.heap.pop() {
            let (over, settled) = &mut self.buffer.over[place as usize];
            if *settled {
                continue;
            }
            *settled = true;
            if *over < GONE * self.radius {
                self.spread(place);
            }
        }
    }

    /// Offers the neighbours of a settled place their distances.
    fn spread(&mut self, place: u32) {
        let terrain = self.terrain;
        let (here, own) = (terrain.positions[place as usize], self.over(place));
        for &triangle in terrain.adjacency.fan(place) {
            let corners = terrain.adjacency.triangles[triangle as usize];
            for next in corners.into_iter().filter(|&next| next != place) {
                let there = terrain.positions[next as usize];
                let along = own + here.distance(there);
                let third = corners.into_iter().find(|&c| c != place && c != next);
                let ahead = third.filter(|&third| self.buffer.over[third as usize].1).and_then(|third| {
                    front(there, (here, own), (terrain.positions[third as usize], self.over(third)))
                });
                self.reach(next, ahead.map_or(along, |ahead| ahead.min(along)));
            }
        }
    }

    fn reach(&mut self, place: u32, over: f64) {
        let known = &mut self.buffer.over[place as usize];
        if over < known.0 {
            if known.0 == f64::INFINITY {
                self.buffer.marched.push(place);
            }
            known.0 = over;
            // Distances are not negative, so that their bits are in their order.
            self.buffer.heap.push(Reverse((over.to_bits(), place)));
        }
    }
}

/// When a straight front that passes two places at these distances passes a third, if it gets there between the two.
fn front(p: DVec3, (a, at): (DVec3, f64), (b, bt): (DVec3, f64)) -> Option<f64> {
    let (e, f) = (b - a, p - a);
    let base = e.length();
    let (x, slope) = (f.dot(e) / base, (bt - at) / base);
    if !(base > 0.0 && slope.abs() < 1.0) {
        return None;
    }
    let y = (f.length_squared() - x * x).max(0.0).sqrt();
    // The front's way to p crosses the base at the place x − y·slope / √(1 − slope²).
    let rise = (1.0 - slope * slope).sqrt();
    let crossing = x - y * slope / rise;
    (0.0..=base).contains(&crossing).then_some(at + x * slope + y * rise)
}

#[cfg(test)]
#[path = "near_tests.rs"]
mod tests;
