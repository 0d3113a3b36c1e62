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

use glam::DVec3;

use crate::Step;
use crate::geodesic::Terrain;

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
    /// For each place what is known of it; what is not touched is [`UNKNOWN`].
    found: Vec<Found>,
    touched: Vec<u32>,
    queue: Vec<u32>,
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

#[derive(Clone, Copy, Debug)]
struct Found {
    /// Distance from the line through the air.
    air: f64,
    /// Distance over the surface.
    over: f64,
    /// The point of the line that is nearest.
    point: u32,
    /// Whether `over` is final.
    settled: bool,
}

const UNKNOWN: Found = Found { air: f64::INFINITY, over: f64::INFINITY, point: u32::MAX, settled: false };

impl Terrain {
    /// The vertices within `radius` of a line through points of the surface, as far as the surface leads there. All vertices at
    /// one position are found together.
    pub fn near(&self, line: &[Step], radius: f64, buffer: &mut NearBuffer) -> Near {
        buffer.found.resize(self.adjacency.place_of.len(), UNKNOWN);
        let mut search = Search { terrain: self, line: Line::new(self, line), radius, buffer };
        search.flood();
        let mut near = Near { vertices: search.within(), factors: Vec::new() };
        if search.doubtful(&near.vertices) {
            search.march();
            near.vertices.retain(|&place| search.over(place) < GONE * radius);
            self.add_split(&mut near.vertices);
            near.vertices.sort_unstable();
            let place = |vertex: &u32| self.adjacency.place_of[*vertex as usize];
            let factor = |vertex| fade(search.over(place(vertex)) / radius) as f32;
            near.factors = near.vertices.iter().map(factor).collect();
        } else {
            self.add_split(&mut near.vertices);
            near.vertices.sort_unstable();
        }
        for place in buffer.touched.drain(..) {
            buffer.found[place as usize] = UNKNOWN;
        }
        near
    }

    /// Adds the other vertices at the places of vertices.
    fn add_split(&self, vertices: &mut Vec<u32>) {
        for i in 0..vertices.len() {
            vertices.extend(self.adjacency.split(vertices[i]).iter().map(|(_, vertex)| vertex));
        }
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
    points: Vec<DVec3>,
    /// Zero where there is none.
    normals: Vec<DVec3>,
}

impl<'a> Line<'a> {
    fn new(terrain: &Terrain, steps: &'a [Step]) -> Self {
        let normal = |step: &Step| terrain.normal(step.triangle, DVec3::from(step.weights));
        Self {
            steps,
            points: steps.iter().map(|step| DVec3::from(step.position)).collect(),
            normals: steps.iter().map(|step| normal(step).unwrap_or_default()).collect(),
        }
    }

    /// The point near number `from` that is nearest to `p`, and how near the line comes there.
    fn descend(&self, p: DVec3, from: usize) -> (f64, usize) {
        let off = |i: usize| self.points[i].distance_squared(p);
        let (mut at, mut least) = (from, off(from));
        for step in [1, usize::MAX] {
            loop {
                let next = at.wrapping_add(step);
                if next >= self.points.len() || off(next) >= least {
                    break;
                }
                (at, least) = (next, off(next));
            }
        }
        let before = at.checked_sub(1).map(|before| self.segment(p, before));
        let after = (at + 1 < self.points.len()).then(|| self.segment(p, at));
        let nearest = before.into_iter().chain(after).fold(least, f64::min);
        (nearest.sqrt(), at)
    }

    /// The squared distance from the segment between a point and the next.
    fn segment(&self, p: DVec3, i: usize) -> f64 {
        let (a, b) = (self.points[i], self.points[i + 1]);
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
        self.buffer.found[place as usize].over
    }

    /// Places within the radius.
    fn within(&self) -> Vec<u32> {
        let within = |place: &&u32| self.buffer.found[**place as usize].air < self.radius;
        self.buffer.touched.iter().filter(within).copied().collect()
    }

    /// Whether one of the places faces another way than the line.
    fn doubtful(&self, places: &[u32]) -> bool {
        let facing = |&place: &u32| {
            let point = self.buffer.found[place as usize].point;
            self.terrain.normals[place as usize].dot(self.line.normals[point as usize]) > FACING
        };
        !places.iter().all(facing)
    }

    /// Finds distances through the air, from neighbour to neighbour.
    fn flood(&mut self) {
        let terrain = self.terrain;
        for from in 0..self.line.steps.len() {
            for place in terrain.adjacency.triangles[self.line.steps[from].triangle as usize] {
                self.offer(place, from);
                // The line lies in this triangle, however far its corners are.
                self.buffer.queue.push(place);
            }
        }
        while let Some(place) = self.buffer.queue.pop() {
            let from = self.buffer.found[place as usize].point as usize;
            for &triangle in terrain.adjacency.fan(place) {
                for next in terrain.adjacency.triangles[triangle as usize] {
                    if self.offer(next, from) {
                        self.buffer.queue.push(next);
                    }
                }
            }
        }
    }

    /// Takes up the distance of a place from the line near its point `from`, if that is the least so far. Returns whether its
    /// neighbours are to hear of it.
    fn offer(&mut self, place: u32, from: usize) -> bool {
        let known = self.buffer.found[place as usize];
        if known.point as usize == from {
            return false;
        }
        let (air, point) = self.line.descend(self.terrain.positions[place as usize], from);
        if air >= known.air {
            return false;
        }
        if known.point == u32::MAX {
            self.buffer.touched.push(place);
        }
        self.buffer.found[place as usize] = Found { air, point: point as u32, ..known };
        // A long edge may lead out of the radius and into it again.
        air < STRAY * self.radius || air < self.radius + self.longest(place)
    }

    /// The longest edge at a place.
    fn longest(&self, place: u32) -> f64 {
        let (adjacency, positions) = (&self.terrain.adjacency, &self.terrain.positions);
        let corners = adjacency.fan(place).iter().flat_map(|&t| adjacency.triangles[t as usize]);
        let length = |corner: u32| positions[corner as usize].distance(positions[place as usize]);
        corners.map(length).fold(0.0, f64::max)
    }

    /// Finds distances over the surface, up to [`GONE`] radii.
    fn march(&mut self) {
        for from in 0..self.line.steps.len() {
            for place in self.terrain.adjacency.triangles[self.line.steps[from].triangle as usize] {
                let (air, _) = self.line.descend(self.terrain.positions[place as usize], from);
                self.reach(place, air);
            }
        }
        while let Some(Reverse((_, place))) = self.buffer.heap.pop() {
            let found = &mut self.buffer.found[place as usize];
            if found.settled {
                continue;
            }
            found.settled = true;
            if found.over < GONE * self.radius {
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
                let ahead =
                    third.filter(|&third| self.buffer.found[third as usize].settled).and_then(|third| {
                        front(there, (here, own), (terrain.positions[third as usize], self.over(third)))
                    });
                self.reach(next, ahead.map_or(along, |ahead| ahead.min(along)));
            }
        }
    }

    fn reach(&mut self, place: u32, over: f64) {
        let known = &mut self.buffer.found[place as usize];
        if over < known.over {
            if known.point == u32::MAX && known.over == f64::INFINITY {
                self.buffer.touched.push(place);
            }
            known.over = over;
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
