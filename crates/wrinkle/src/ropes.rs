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

/// So many moments that were asked for are remembered, those of the last use: who looks between two frames comes back to both.
const REMEMBERED: usize = 8;

/// Simulated ropes. They go on from the last moment before the one that is asked for of those they remember, or begin again; what they
/// are at a moment does not depend on what was asked for before.
#[derive(Clone, Debug)]
pub(crate) struct Ropes {
    trees: Vec<Tree>,
    forces: Forces,
}

/// A rope that hangs from a rail, or stays, and those that hang from it, each behind the one it hangs from.
#[derive(Clone, Debug)]
struct Tree {
    ropes: Vec<Hung>,
    /// Steps they have made.
    steps: u64,
    /// How they were after other numbers of steps, that of the last use at the end.
    known: Vec<(u64, Vec<Rope>)>,
}

/// What a rope hangs from where that is another, one of those before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hook {
    pub(crate) rope: usize,
    /// The share `below` of the way from its given point `point` to the next.
    pub(crate) point: usize,
    pub(crate) below: f64,
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
    top: Top,
    carried: Vec<Carried>,
    /// Which rope, for its gusts.
    index: usize,
    /// Where the nodes are at the moment, and how far the given points have moved.
    nodes: Vec<DVec3>,
    moved: Vec<DVec3>,
}

/// What the top of a rope follows.
#[derive(Clone, Debug)]
enum Top {
    /// A way, and where that is at 0 s.
    Rail(Keyed<Place>, DVec3),
    /// A rope of its tree, by its number there.
    Rope(Hook),
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
    /// Ropes at rest along lines of points, each from its top to its free end; those with a hook, where there is one for them, hang
    /// from the rope before them that it names. `seed` is that of the gusts.
    pub(crate) fn new(lines: &[Vec<DVec3>], hooks: &[Option<Hook>], curtain: &Curtain, seed: u64) -> Self {
        let mut trees: Vec<Tree> = Vec::new();
        let mut root = 0;
        for (index, line) in lines.iter().enumerate() {
            let first = line.first().copied().unwrap_or_default();
            // Ropes are in the order in which they branch.
            let hook = hooks.get(index).copied().flatten().filter(|hook| (root..index).contains(&hook.rope));
            let top = match hook {
                Some(hook) => Top::Rope(Hook { rope: hook.rope - root, ..hook }),
                None => Top::rail(curtain.rail.as_ref(), first),
            };
            let hung = Hung::new(line, index, top, f64::from(curtain.stiffness));
            match trees.last_mut() {
                Some(tree) if hook.is_some() => tree.ropes.push(hung),
                _ => {
                    root = index;
                    trees.push(Tree { ropes: vec![hung], steps: 0, known: Vec::new() });
                }
            }
        }
        let forces = Forces {
            gravity: wide(curtain.gravity),
            damping: f64::from(curtain.damping),
            wind: Wind::new(curtain, seed),
            settle: (f64::from(curtain.settle) * f64::from(RATE)).round() as u64,
        };
        Self { trees, forces }
    }

    /// How far the given points are from where they were given, at `seconds`; before 0 s as at 0 s, after [`LAST`] as then.
    pub(crate) fn at(&mut self, seconds: f64, out: &mut Vec<Vec<DVec3>>) {
        let seconds = if seconds > 0.0 { seconds.min(LAST) } else { 0.0 };
        let forces = &self.forces;
        self.trees.par_iter_mut().for_each(|tree| tree.at(seconds, forces));
        out.resize_with(self.trees.iter().map(|tree| tree.ropes.len()).sum(), Vec::new);
        let ropes = self.trees.iter().flat_map(|tree| &tree.ropes);
        ropes.zip(out).for_each(|(rope, out)| out.clone_from(&rope.moved));
    }
}

impl Tree {
    fn at(&mut self, seconds: f64, forces: &Forces) {
        let exact = seconds * f64::from(RATE);
        let whole = exact.floor();
        // The step after, so that the moment lies between two.
        self.walk(forces.settle + whole as u64 + 1, forces);
        self.each(|hung, before| {
            let top = hung.top.at(seconds, |rope, point| before[rope].carry(&before[rope].nodes, point));
            hung.rope.between(exact - whole, top, &mut hung.nodes);
            let mut moved = std::mem::take(&mut hung.moved);
            moved.clear();
            moved.extend((0..hung.carried.len()).map(|point| hung.carry(&hung.nodes, point)));
            hung.moved = moved;
        });
    }

    /// Goes to where so many steps have been made, and says how many it has made on the way.
    fn walk(&mut self, wanted: u64, forces: &Forces) -> u64 {
        self.recall(wanted);
        let first = self.steps;
        while self.steps < wanted {
            self.steps += 1;
            let now = (self.steps as f64 - forces.settle as f64) / f64::from(RATE);
            self.each(|hung, before| {
                let top = hung.top.at(now, |rope, point| before[rope].carry(&before[rope].rope.nodes, point));
                let acceleration = forces.gravity + forces.wind.at(now, hung.index);
                hung.rope.step(top, acceleration, forces.damping);
            });
        }
        if self.known.last().is_none_or(|(steps, _)| *steps != wanted) {
            self.known.push((wanted, self.ropes.iter().map(|hung| hung.rope.clone()).collect()));
            let over = self.known.len().saturating_sub(REMEMBERED);
            self.known.drain(..over);
        }
        self.steps - first
    }

    /// Goes to the last known number of steps up to `wanted`, or to none.
    fn recall(&mut self, wanted: u64) {
        let before = self.known.iter().enumerate().filter(|(_, (steps, _))| *steps <= wanted);
        let best = before.max_by_key(|(_, (steps, _))| *steps).map(|(index, (steps, _))| (index, *steps));
        match best {
            Some((_, steps)) if steps <= self.steps && self.steps <= wanted => {}
            Some((index, steps)) => {
                let known = self.known.remove(index);
                self.ropes.iter_mut().zip(&known.1).for_each(|(hung, rope)| hung.rope.clone_from(rope));
                self.known.push(known);
                self.steps = steps;
            }
            None if self.steps <= wanted => {}
            None => {
                self.ropes.iter_mut().for_each(|hung| hung.rope.restart());
                self.steps = 0;
            }
        }
    }

    /// Each rope after those it hangs from, which are given with it.
    fn each(&mut self, work: impl Fn(&mut Hung, &[Hung])) {
        for i in 0..self.ropes.len() {
            let (before, from) = self.ropes.split_at_mut(i);
            work(&mut from[0], before);
        }
    }
}

impl Hung {
    fn new(line: &[DVec3], index: usize, top: Top, stiffness: f64) -> Self {
        let first = line.first().copied().unwrap_or_default();
        let relative: Vec<DVec3> = line.iter().map(|point| *point - first).collect();
        let (nodes, carried) = strung(&relative);
        let rope = Rope::new(nodes, stiffness);
        Self { rope, top, carried, index, nodes: Vec::new(), moved: Vec::new() }
    }

    /// How far a given point has moved where the nodes are at `nodes`.
    fn carry(&self, nodes: &[DVec3], point: usize) -> DVec3 {
        let Some(&Carried { node, below }) = self.carried.get(point) else { return DVec3::ZERO };
        let moved = |node: usize| nodes[node] - self.rope.rest[node];
        if below > 0.0 { moved(node).lerp(moved(node + 1), below) } else { moved(node) }
    }
}

impl Top {
    fn rail(rail: Option<&Rail>, top: DVec3) -> Self {
        let way = rail.map_or(Keyed::Constant(Place(DVec3::ZERO)), |rail| track(rail, top));
        let start = way.at(0.0).0;
        Self::Rail(way, start)
    }

    /// How far it is from where it is at 0 s; `carry` tells how far a given point of a rope has moved.
    fn at(&self, seconds: f64, carry: impl Fn(usize, usize) -> DVec3) -> DVec3 {
        match self {
            Self::Rail(way, start) => way.at(seconds.max(0.0)).0 - *start,
            Self::Rope(Hook { rope, point, below }) => {
                carry(*rope, *point).lerp(carry(*rope, *point + 1), *below)
            }
        }
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
