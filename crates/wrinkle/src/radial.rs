//! Creases out from a centre, and their branches.

use std::f64::consts::TAU;

use wirework_surface::Walker;

use crate::pattern::{Fork, Line, Lines};
use crate::random::{Jitter, unit};
use crate::trace::Trace;
use crate::travel::{room, stop};
use crate::{Branches, Layout, Wrinkle};

/// Where creases begin, in parts of the thickness and of their length, the lesser: all of them in one point would be a
/// spike of many wires.
const INNER: (f64, f64) = (0.5, 0.1);
/// The most jitter of the direction, in parts of the angle between neighbours.
const ASKEW: f64 = 0.4;
/// The most that is lost of a crease at its outer end, and at its inner one.
const SHORTER: f64 = 0.25;
/// The angle of a branch to its stem, radians, and the most jitter of it: as veins of leaves have it.
const FORK: (f64, f64) = (0.7, 0.25);
/// The length of a branch in parts of what is left of its stem.
const BRANCH: f64 = 0.6;
/// A line shorter than this part of the pattern is none.
const COLLAPSED: f64 = 1e-3;

/// Lays the creases from a walker at the centre who looks along the first.
pub(crate) fn lay(
    mut center: Walker<'_>,
    layout: &Layout,
    branches: Branches,
    settings: &Wrinkle,
    seconds: f64,
    thickness: f64,
    lines: &mut Lines,
) {
    travel(&mut center, settings, seconds, thickness);
    let outer = f64::from(layout.size[0]) / 2.0;
    let step = TAU / f64::from(layout.creases);
    let random = f64::from(settings.randomness);
    let mut laying = Laying { settings, branches, outer, step, next: layout.creases as usize, lines };
    let inner = (INNER.0 * thickness).min(INNER.1 * outer);
    for index in 0..layout.creases as usize {
        let mut walker = center.clone();
        let askew = ASKEW * random * (2.0 * unit(settings.seed, index, Jitter::Askew) - 1.0);
        walker.turn(step * (index as f64 + askew));
        let trim = |what| SHORTER * random * unit(settings.seed, index, what) * outer;
        let range = (inner + trim(Jitter::Start), outer - trim(Jitter::End));
        laying.stem(&walker, range, Start { origin: 0.0, index, depth: 0, fork: None });
    }
}

/// The centre slides over the surface, and stops at a border.
fn travel(center: &mut Walker<'_>, settings: &Wrinkle, seconds: f64, thickness: f64) {
    let [along, across] = settings.motion.velocity();
    if [along, across] == [0.0; 2] {
        return;
    }
    let (way, angle) = (along.hypot(across) * seconds, across.atan2(along));
    center.turn(angle);
    center.walk(stop(way, room(center, way, thickness), thickness), |_, _| {});
    center.turn(-angle);
}

struct Laying<'a> {
    settings: &'a Wrinkle,
    branches: Branches,
    outer: f64,
    /// The angle between neighbours.
    step: f64,
    /// Number of the next branch.
    next: usize,
    lines: &'a mut Lines,
}

/// Where a crease starts.
#[derive(Clone, Copy)]
struct Start {
    /// The way from the centre.
    origin: f64,
    index: usize,
    /// How often it has branched before.
    depth: u32,
    fork: Option<Fork>,
}

impl Laying<'_> {
    /// A crease straight ahead over a range of ways from a walker, and its branches.
    fn stem(&mut self, walker: &Walker<'_>, range: (f64, f64), start: Start) {
        let Start { origin, index, depth, fork } = start;
        let walked = Trace::straight(walker, range);
        if walked.trace.length() < COLLAPSED * self.outer {
            self.lines.outside += usize::from(depth == 0);
            return;
        }
        self.lines.note(walked.stops.1, range.1 - walked.range.1, self.outer);
        let random = f64::from(self.settings.randomness);
        let stem = self.lines.list.len();
        let ends = (origin + walked.range.0, origin + walked.range.1);
        self.lines.list.push(Line {
            trace: walked.trace,
            closed: false,
            range: (ends.0 / self.outer, ends.1 / self.outer),
            strength: 1.0 - 0.5 * random * unit(self.settings.seed, index, Jitter::Height),
            spacing: (ends.0 * self.step, ends.1 * self.step),
            index,
            fork,
        });
        if depth < self.branches.depth {
            for branch in 0..self.branches.count {
                let fork = Some(Fork { stem, at: 0.0 });
                self.branch(walker, walked.range, branch, Start { depth: depth + 1, fork, ..start });
            }
        }
    }

    /// Branch number `branch` of a stem over a range of ways from a walker: left and right in turn, equally spread.
    fn branch(&mut self, stem: &Walker<'_>, range: (f64, f64), branch: u32, start: Start) {
        let length = range.1;
        let index = self.next;
        self.next += 1;
        let random = f64::from(self.settings.randomness);
        let jitter = |what| random * (2.0 * unit(self.settings.seed, index, what) - 1.0);
        let place =
            (f64::from(branch) + 1.0 + 0.4 * jitter(Jitter::Sideways)) / f64::from(self.branches.count + 1);
        let side = if branch.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut walker = stem.clone();
        walker.walk(place * length, |_, _| {});
        walker.turn(side * (FORK.0 + FORK.1 * jitter(Jitter::Askew)));
        let left = (1.0 - place) * length * BRANCH;
        let at = ((place * length - range.0) / (length - range.0)).clamp(0.0, 1.0);
        let fork = start.fork.map(|fork| Fork { at, ..fork });
        let origin = start.origin + place * length;
        self.stem(&walker, (0.0, left), Start { origin, index, fork, ..start });
    }
}

#[cfg(test)]
#[path = "radial_tests.rs"]
mod tests;
