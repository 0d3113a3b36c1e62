//! Rings round a centre: the ends of geodesics of one length.
//!
//! Beyond half the way round a tube rings pass through themselves, as waves do.

use std::f64::consts::TAU;

use wirework_surface::{Step, Stop, Walker};

use crate::ground::{Ground, MOST_CROSSINGS_OF_RAYS};
use crate::pattern::{Line, Lines};
use crate::random::{Jitter, unit};
use crate::trace::{Trace, position};
use crate::{Layout, Motion, Wrinkle, WrinkleError};

/// Rays in the length of a thickness on the outermost ring, and how many there are at least, for its shape, and at most.
const RAYS_A_THICKNESS: f64 = 3.0;
const RAYS: std::ops::RangeInclusive<usize> = 64..=1024;
/// Neighbouring points of a ring so many times farther apart than on a plane, and farther than a thickness, do not belong
/// together: something has parted the rays.
const PARTED: f64 = 6.0;
/// The most jitter of a radius, in parts of the distance between rings.
const SIDEWAYS: f64 = 0.4;
/// The least radius of a ring, in parts of the thickness: one that comes in at the centre has no height there.
const LEAST: f64 = 0.05;
/// Rays go on beyond the last ring by this factor, so that where it meets a border is known.
const BEYOND: f64 = 1.25;
/// Where rings run, each grows to its height over the first of these steps between rings, and sinks over the one beyond the last.
const EASE: f64 = 1.0;

/// Geodesics from the centre in all directions.
#[derive(Debug)]
pub(crate) struct Rays {
    list: Vec<Ray>,
}

#[derive(Debug)]
struct Ray {
    steps: Vec<Step>,
    lengths: Vec<f64>,
    stop: Stop,
}

impl Ray {
    fn new(mut walker: Walker<'_>, length: f64) -> Self {
        let (mut steps, mut lengths) = (vec![walker.step()], vec![0.0]);
        let (_, stop) = walker.walk(length, |way, step| {
            steps.push(step);
            lengths.push(way);
        });
        Self { steps, lengths, stop }
    }

    fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Why a ring of a radius ends beside it.
    fn end_at(&self, radius: f64) -> End {
        match self.stop {
            // It goes on, elsewhere; or it was given up, far beyond all that belongs together.
            Stop::Arrived => End::Parted,
            _ if self.length() >= radius => End::Parted,
            stop => End::Stopped(stop),
        }
    }

    fn end(&self) -> Option<&Step> {
        self.steps.last()
    }

    /// Its point at a distance from the centre; none beyond its end.
    fn at(&self, ground: &Ground, distance: f64) -> Option<Step> {
        if distance > self.length() {
            return None;
        }
        let next = self.lengths.partition_point(|&l| l < distance);
        if next == 0 {
            return self.steps.first().copied();
        }
        let (a, b) = (self.lengths[next - 1], self.lengths[next]);
        // Of two that are equal the second is meant.
        let x = if b > a { (distance - a) / (b - a) } else { 1.0 };
        let p = position(&self.steps[next - 1]).lerp(position(&self.steps[next]), x);
        ground.terrain.within(self.steps[next].triangle, p.to_array()).or_else(|| ground.step(p))
    }
}

/// A part of a ring.
struct Arc {
    points: Vec<Step>,
    /// Why it ends on either side; none where it is the whole.
    ends: Option<[End; 2]>,
}

/// Why a ring ends.
#[derive(Clone, Copy)]
enum End {
    /// The next ray has come to its end before.
    Stopped(Stop),
    /// The next ray is somewhere else.
    Parted,
}

/// A ring at a moment.
struct Ring {
    radius: f64,
    strength: f64,
}

impl Rays {
    /// From a walker at the centre, as far as any ring gets.
    pub(crate) fn new(
        ground: &Ground,
        center: &Walker<'_>,
        outer: f64,
        settings: &Wrinkle,
        thickness: f64,
    ) -> Result<Self, WrinkleError> {
        let farthest = if travels(settings) { 2.0 * outer } else { outer };
        let wanted = TAU * outer / thickness * RAYS_A_THICKNESS;
        let count = (wanted as usize).clamp(*RAYS.start(), *RAYS.end());
        let length = farthest * (BEYOND + f64::from(settings.randomness));
        ground.check_walks(count, length, MOST_CROSSINGS_OF_RAYS)?;
        let ray = |i: usize| {
            let mut walker = center.clone();
            walker.turn(TAU * i as f64 / count as f64);
            Ray::new(walker, length)
        };
        Ok(Self { list: (0..count).map(ray).collect() })
    }

    /// Lays the rings of a moment.
    pub(crate) fn lay(
        &self,
        ground: &Ground,
        layout: &Layout,
        settings: &Wrinkle,
        seconds: f64,
        thickness: f64,
        lines: &mut Lines,
    ) {
        let outer = f64::from(layout.size[0]) / 2.0;
        let spacing = outer / f64::from(layout.creases);
        for (index, ring) in rings(layout, settings, seconds).into_iter().enumerate() {
            let before = lines.list.len();
            let radius = ring.radius.max(LEAST * thickness);
            let gap = (radius * TAU / self.list.len() as f64 * PARTED).max(thickness);
            for Arc { points, ends } in self.arcs(ground, radius, gap) {
                let closed = ends.is_none();
                for end in ends.iter().flatten() {
                    match *end {
                        End::Stopped(stop) => lines.note(stop, radius, radius),
                        End::Parted => lines.parted += 1,
                    }
                }
                let trace = Trace::along(ground, &points, gap);
                if trace.length() > 0.0 {
                    let fraction = ring.radius / outer;
                    lines.list.push(Line {
                        trace,
                        closed,
                        range: (fraction, fraction),
                        strength: ring.strength,
                        spacing: (spacing, spacing),
                        index,
                        fork: None,
                    });
                }
            }
            lines.outside += usize::from(lines.list.len() == before);
        }
    }

    /// The points of a ring, in one closed piece whose last point is its first, or in several where rays end before it or part.
    fn arcs(&self, ground: &Ground, radius: f64, gap: f64) -> Vec<Arc> {
        let count = self.list.len();
        let points: Vec<Option<Step>> = self.list.iter().map(|ray| ray.at(ground, radius)).collect();
        let joined = |i: usize| match (&points[i], &points[(i + 1) % count]) {
            (Some(a), Some(b)) => position(a).distance(position(b)) <= gap,
            _ => false,
        };
        let Some(parted) = (0..count).find(|&i| !joined(i)) else {
            let first = points[0];
            let points = points.into_iter().chain([first]).flatten().collect();
            return vec![Arc { points, ends: None }];
        };
        let (mut arcs, mut arc) = (Vec::new(), Vec::new());
        let mut start = End::Parted;
        for i in (parted + 1..=parted + count).map(|i| i % count) {
            let Some(point) = points[i] else { continue };
            if arc.is_empty() {
                let before = (i + count - 1) % count;
                start = self.list[before].end_at(radius);
                arc.extend(self.border(ground, i, before, radius));
            }
            arc.push(point);
            if !joined(i) {
                let after = (i + 1) % count;
                arc.extend(self.border(ground, i, after, radius));
                let ends = Some([start, self.list[after].end_at(radius)]);
                arcs.push(Arc { points: std::mem::take(&mut arc), ends });
            }
        }
        arcs
    }

    /// Where a ring meets the border between a ray that gets to it and a neighbour that does not.
    fn border(&self, ground: &Ground, reaches: usize, ends: usize, radius: f64) -> Option<Step> {
        let (long, short) = (&self.list[reaches], &self.list[ends]);
        let (from, to) = (short.length(), long.length());
        if from >= radius || short.stop == Stop::Arrived || to <= from {
            return None;
        }
        let x = (radius - from) / (to - from);
        ground.step(position(short.end()?).lerp(position(long.end()?), x))
    }
}

/// The rings of a moment. Travelling ones run outwards, sink beyond the last and come in again at the centre, for which
/// there is one more, at rest without a height.
fn rings(layout: &Layout, settings: &Wrinkle, seconds: f64) -> Vec<Ring> {
    let outer = f64::from(layout.size[0]) / 2.0;
    let spacing = outer / f64::from(layout.creases);
    let random = f64::from(settings.randomness);
    let jittered = |index: usize, radius: f64| {
        let off = random * (2.0 * unit(settings.seed, index, Jitter::Sideways) - 1.0);
        let strength = 1.0 - 0.5 * random * unit(settings.seed, index, Jitter::Height);
        (radius + SIDEWAYS * spacing * off, strength)
    };
    let count = layout.creases as usize;
    let Motion::Travelling { velocity: [out, _] } = settings.motion else {
        let ring = |index| {
            let (radius, strength) = jittered(index, (index + 1) as f64 * spacing);
            Ring { radius, strength }
        };
        return (0..count).map(ring).collect();
    };
    let cycle = outer + spacing;
    let ring = |index| {
        let way = (index + 1) as f64 * spacing + f64::from(out) * seconds;
        // Where a ring goes out and comes in again it is not to have a height, wherever jitter puts it.
        let place = way.rem_euclid(cycle);
        let (radius, strength) = jittered(index, place);
        let ease = |x: f64| {
            let x = (x / (EASE * spacing)).clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        };
        Ring { radius: radius.max(0.0), strength: strength * ease(place) * ease(cycle - place) }
    };
    (0..=count).map(ring).collect()
}

fn travels(settings: &Wrinkle) -> bool {
    matches!(settings.motion, Motion::Travelling { .. })
}

#[cfg(test)]
#[path = "ripple_tests.rs"]
mod tests;
