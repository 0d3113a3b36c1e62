//! The ropes of a curtain at any moment.

use glam::DVec3;
use rayon::prelude::*;
use wirework_core::{Interpolate, Keyed};

use crate::ground::wide;
use crate::rope::{RATE, Rope};
use crate::wind::Wind;
use crate::{Curtain, Rail};

/// The last second that is simulated; later the ropes stay as they are then. Longer than any clip, and no time asked for by mistake
/// takes for ever.
pub(crate) const LAST: f64 = 600.0;
/// Nodes of a rope are this part of its length apart at least. What lies between is carried along, and no rope costs more than 256 links.
const CLOSEST: f64 = 1.0 / 256.0;

/// Simulated ropes. They go on from where they are when the time rises, and begin again when it falls; what they are at a
/// moment does not depend on what was asked for before.
#[derive(Clone, Debug)]
pub(crate) struct Ropes {
    ropes: Vec<Hung>,
    forces: Forces,
}

/// What all ropes feel.
#[derive(Clone, Debug)]
struct Forces {
    gravity: DVec3,
    damping: f64,
    wind: Wind,
    /// Steps before 0 s.
    settle: u64,
}

/// A rope, what it hangs from, and the points it carries.
#[derive(Clone, Debug)]
struct Hung {
    rope: Rope,
    top: Keyed<Place>,
    /// Where `top` is at 0 s.
    start: DVec3,
    carried: Vec<Carried>,
    /// Which rope, for its gusts.
    index: usize,
    /// Steps it has made.
    steps: u64,
    nodes: Vec<DVec3>,
}

/// A given point: the share `below` of the way from node `node` to the next.
#[derive(Clone, Copy, Debug)]
struct Carried {
    node: usize,
    below: f64,
}

/// A point in 64 bits, since rounding to 32 at 480 steps a second would be felt as a tremor.
#[derive(Clone, Copy, Debug)]
struct Place(DVec3);

impl Interpolate for Place {
    fn interpolate(a: &Self, b: &Self, x: f64) -> Self {
        Self(a.0 * (1.0 - x) + b.0 * x)
    }
}

impl Ropes {
    /// Ropes at rest along lines of points, each from its top to its free end. `seed` is that of the gusts.
    pub(crate) fn new(lines: &[Vec<DVec3>], curtain: &Curtain, seed: u64) -> Self {
        let stiffness = f64::from(curtain.stiffness);
        let hang =
            |(index, line): (usize, &Vec<DVec3>)| Hung::new(line, index, curtain.rail.as_ref(), stiffness);
        let forces = Forces {
            gravity: wide(curtain.gravity),
            damping: f64::from(curtain.damping),
            wind: Wind::new(curtain, seed),
            settle: (f64::from(curtain.settle) * f64::from(RATE)).round() as u64,
        };
        Self { ropes: lines.iter().enumerate().map(hang).collect(), forces }
    }

    /// How far the given points are from where they were given, at `seconds`; before 0 s as at 0 s, after [`LAST`] as then.
    pub(crate) fn at(&mut self, seconds: f64, out: &mut Vec<Vec<DVec3>>) {
        let seconds = if seconds > 0.0 { seconds.min(LAST) } else { 0.0 };
        out.resize_with(self.ropes.len(), Vec::new);
        let forces = &self.forces;
        self.ropes.par_iter_mut().zip(out).for_each(|(rope, out)| rope.at(seconds, forces, out));
    }
}

impl Hung {
    fn new(line: &[DVec3], index: usize, rail: Option<&Rail>, stiffness: f64) -> Self {
        let first = line.first().copied().unwrap_or_default();
        let relative: Vec<DVec3> = line.iter().map(|point| *point - first).collect();
        let (nodes, carried) = strung(&relative);
        let top = rail.map_or(Keyed::Constant(Place(DVec3::ZERO)), |rail| track(rail, first));
        let (start, rope) = (top.at(0.0).0, Rope::new(nodes, stiffness));
        Self { rope, top, start, carried, index, steps: 0, nodes: Vec::new() }
    }

    fn at(&mut self, seconds: f64, forces: &Forces, out: &mut Vec<DVec3>) {
        let exact = seconds * f64::from(RATE);
        let whole = exact.floor();
        // The step after, so that the moment lies between two.
        let wanted = forces.settle + whole as u64 + 1;
        if wanted < self.steps {
            self.rope.restart();
            self.steps = 0;
        }
        while self.steps < wanted {
            self.steps += 1;
            let now = (self.steps as f64 - forces.settle as f64) / f64::from(RATE);
            let acceleration = forces.gravity + forces.wind.at(now, self.index);
            let top = self.top(now);
            self.rope.step(top, acceleration, forces.damping);
        }
        let top = self.top(seconds);
        self.rope.between(exact - whole, top, &mut self.nodes);
        let moved = |node: usize| self.nodes[node] - self.rope.rest[node];
        out.clear();
        out.extend(self.carried.iter().map(|carried| {
            let above = moved(carried.node);
            if carried.below > 0.0 { above.lerp(moved(carried.node + 1), carried.below) } else { above }
        }));
    }

    /// How far the top is from where it is at 0 s.
    fn top(&self, seconds: f64) -> DVec3 {
        self.top.at(seconds.max(0.0)).0 - self.start
    }
}

/// The way of the place of `rail` that is nearest to `top` at 0 s. The curve is linear in its points, so that its place at the keys
/// is all there is to know.
fn track(rail: &Rail, top: DVec3) -> Keyed<Place> {
    let posed =
        |points: &Vec<[f32; 3]>| rail.curve.posed(points.clone()).unwrap_or_else(|_| rail.curve.clone());
    let foot = posed(&rail.points.at(0.0)).closest(top.as_vec3().to_array());
    let u = foot.map_or(0.0, |foot| foot.u);
    rail.points.map(|points| Place(wide(posed(points).point(u))))
}

/// The nodes of a rope along a line, and where on it the line's points are.
fn strung(line: &[DVec3]) -> (Vec<DVec3>, Vec<Carried>) {
    let mut along = Vec::with_capacity(line.len());
    let mut total = 0.0;
    for (i, point) in line.iter().enumerate() {
        total += i.checked_sub(1).map_or(0.0, |before| point.distance(line[before]));
        along.push(total);
    }
    let mut nodes = vec![line.first().copied().unwrap_or_default()];
    let mut stations = vec![0.0];
    for (point, &way) in line.iter().zip(&along) {
        if total > 0.0 && point.distance(nodes[nodes.len() - 1]) >= CLOSEST * total {
            nodes.push(*point);
            stations.push(way);
        }
    }
    let carried = |&way: &f64| {
        let node = stations.partition_point(|station| *station <= way) - 1;
        let below =
            stations.get(node + 1).map_or(0.0, |next| (way - stations[node]) / (next - stations[node]));
        Carried { node, below }
    };
    (nodes, along.iter().map(carried).collect())
}

#[cfg(test)]
#[path = "ropes_tests.rs"]
mod tests;
