//! One rope, step by step.
//!
//! Position-based dynamics with small steps: velocities take up gravity, wind and damping, nodes go where these lead, and are
//! then drawn to the nearest shape in which links have their lengths ([`Links`]); what they have moved is their velocity. Bending
//! ([`Bending`]) changes where nodes go, before that.
//!
//! The scheme is implicit: energy is lost, never gained. A swing of angular frequency `ω` loses `½ ω² dt` of its width
//! a second: nothing one sees of the swing of a curtain, half in a second of the waves of 40 rad/s that run along it.

use glam::DVec3;

use crate::bending::Bending;
use crate::links::Links;

/// Steps a second. The loss above is what decides, at 240 it would be twice as much; no link is too short and no rope too taut for any.
pub(crate) const RATE: u32 = 480;
/// A top that moves farther than this part of its rope's length in a step takes the rope along as it is: it is cut rather than
/// pulled, the more so the farther it moves. Pulls up to the rope's length in a frame of film are felt in full; ropes would whirl
/// round for seconds after harder ones.
const FARTHEST: f64 = 1.0 / 20.0;
/// A rope of which no node moves farther than this part of its length in a step stays where it is, so that rounding never shows: a
/// rope that hangs straight stays to the bit. Wind or a slant of a ten millionth of gravity is lost by it.
const STILL: f64 = 1e-12;

/// A rope that hangs from its top. Positions are relative to where its top is at rest.
#[derive(Clone, Debug)]
pub(crate) struct Rope {
    pub(crate) rest: Vec<DVec3>,
    pub(crate) links: Links,
    bending: Option<Bending>,
    length: f64,
    /// Where the nodes are, and where they were a step ago.
    pub(crate) nodes: Vec<DVec3>,
    pub(crate) before: Vec<DVec3>,
    velocities: Vec<DVec3>,
    wanted: Vec<DVec3>,
}

impl Rope {
    /// A rope at rest through `nodes`, at least one, the first at the origin, no two neighbours equal.
    pub(crate) fn new(nodes: Vec<DVec3>, stiffness: f64) -> Self {
        let links = Links::new(&nodes);
        let bending = Bending::new(&links, &nodes, stiffness, 1.0 / f64::from(RATE));
        let (length, zero) = (links.lengths.iter().sum(), vec![DVec3::ZERO; nodes.len()]);
        Self {
            links,
            bending,
            length,
            nodes: nodes.clone(),
            before: nodes.clone(),
            velocities: zero.clone(),
            wanted: zero,
            rest: nodes,
        }
    }

    /// At rest again.
    pub(crate) fn restart(&mut self) {
        self.nodes.copy_from_slice(&self.rest);
        self.before.copy_from_slice(&self.rest);
        self.velocities.fill(DVec3::ZERO);
        self.links.slacken();
        self.bending.iter_mut().for_each(Bending::restart);
    }

    /// One step: the top to `top`, everything else by `acceleration`; `damping` is a rate.
    pub(crate) fn step(&mut self, top: DVec3, acceleration: DVec3, damping: f64) {
        let (rate, step) = (f64::from(RATE), 1.0 / f64::from(RATE));
        self.before.copy_from_slice(&self.nodes);
        let carried = cut(top - self.nodes[0], FARTHEST * self.length);
        let left = 1.0 / (1.0 + damping * step);
        for ((wanted, node), velocity) in self.wanted.iter_mut().zip(&mut self.nodes).zip(&self.velocities) {
            *node += carried;
            *wanted = *node + (*velocity + acceleration * step) * left * step;
        }
        self.wanted[0] = top;
        if let Some(bending) = &mut self.bending {
            bending.bend(&mut self.wanted);
        }
        self.links.hold(&self.wanted, &mut self.nodes);
        let mut farthest = 0.0_f64;
        for ((velocity, node), before) in self.velocities.iter_mut().zip(&self.nodes).zip(&self.before) {
            *velocity = (*node - *before - carried) * rate;
            farthest = farthest.max((*node - *before).length());
        }
        if farthest <= STILL * self.length && top == self.before[0] {
            self.nodes.copy_from_slice(&self.before);
            self.velocities.fill(DVec3::ZERO);
        }
        if let Some(bending) = &mut self.bending {
            bending.carry(&self.before, &self.nodes);
        }
    }

    /// Where the nodes are between the step before and this one, with the top at `top`, in `out`.
    pub(crate) fn between(&self, share: f64, top: DVec3, out: &mut Vec<DVec3>) {
        let ends = self.before.iter().zip(&self.nodes);
        // Against the top, so that links keep their directions where it jumps.
        let [first, last] = [self.before[0], self.nodes[0]];
        out.clear();
        out.extend(ends.map(|(a, b)| {
            let (a, b) = (*a - first, *b - last);
            top + a + (b - a) * share
        }));
        self.links.lay(out);
    }
}

/// What a rope does not feel of its top moving by `way`: nothing up to `reach`, nearly all far beyond, without a jump.
fn cut(way: DVec3, reach: f64) -> DVec3 {
    let long = way.length();
    if long > reach { way * (1.0 - (reach / long).powi(2)) } else { DVec3::ZERO }
}

#[cfg(test)]
#[path = "rope_tests.rs"]
mod tests;
