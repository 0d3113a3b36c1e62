//! Lines on the surface: fine polylines with their arc length.

use glam::DVec3;
use wirework_surface::{Step, Stop, Walker};

use crate::ground::{Footing, Ground};
use crate::travel::stop;

/// How often a jump is halved, a point of the surface put between.
const HALVINGS: u32 = 5;

/// A line on the surface.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trace {
    steps: Vec<Step>,
    /// Arc length up to each step.
    lengths: Vec<f64>,
    /// The triangle in which each step and the next lie; none where nobody walked there.
    triangles: Vec<Option<u32>>,
    /// What is used of it, as lengths.
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl Trace {
    /// Over the surface by points of it, which may be some way apart; where two are more than `jump` apart, points of the surface
    /// are put between.
    pub(crate) fn along(ground: &Ground, points: &[Step], jump: f64) -> Self {
        let mut trace = Self::default();
        if let Some(first) = points.first() {
            (trace.steps, trace.lengths) = (vec![*first], vec![0.0]);
        }
        for point in points.iter().skip(1) {
            trace.extend(ground, point, jump, HALVINGS);
        }
        trace
    }

    /// Goes on to `point`, over the surface rather than through the air where it is far.
    fn extend(&mut self, ground: &Ground, point: &Step, jump: f64, halvings: u32) {
        let Some(last) = self.steps.last().map(position) else { return };
        let way = last.distance(position(point));
        if way > jump && halvings > 0 {
            if let Some(middle) = ground.step((last + position(point)) * 0.5) {
                self.extend(ground, &middle, jump, halvings - 1);
            }
            self.extend(ground, point, jump, halvings - 1);
        } else if way > 0.0 {
            self.to += way;
            self.steps.push(*point);
            self.triangles.push(None);
            self.lengths.push(self.to);
        }
    }

    /// Straight ahead and back from where a walker stands, from `range.0` to `range.1` as signed ways; why it ended short of each, if it did, and
    /// the signed ways it got to.
    pub(crate) fn straight(walker: &Walker<'_>, range: (f64, f64)) -> Walked {
        let mut back = walker.clone();
        back.turn(std::f64::consts::PI);
        let mut behind = Self::ahead(&mut back, -range.1, -range.0);
        let ahead = Self::ahead(&mut walker.clone(), range.0, range.1);
        behind.trace.reverse();
        let start = if range.0 < 0.0 { -behind.reached } else { range.0.min(ahead.reached) };
        let end = if range.1 > 0.0 { ahead.reached } else { range.1.max(-behind.reached) };
        behind.trace.append(ahead.trace);
        Walked { trace: behind.trace, range: (start, end), stops: (behind.stop, ahead.stop) }
    }

    /// The part from `from` to `to` of the way ahead, if any of it is ahead.
    fn ahead(walker: &mut Walker<'_>, from: f64, to: f64) -> Ahead {
        let mut ahead = Ahead { trace: Self::default(), reached: 0.0, stop: Stop::Arrived };
        if to <= 0.0 {
            return ahead;
        }
        let from = from.max(0.0);
        let (skipped, stop) = walker.walk(from, |_, _| {});
        (ahead.reached, ahead.stop) = (skipped, stop);
        let trace = &mut ahead.trace;
        (trace.steps, trace.lengths) = (vec![walker.step()], vec![0.0]);
        if stop == Stop::Arrived {
            let (walked, stop) = walker.walk(to - from, |way, step| {
                trace.triangles.push(Some(step.triangle));
                trace.steps.push(step);
                trace.lengths.push(way);
            });
            (ahead.reached, ahead.stop) = (skipped + walked, stop);
            trace.to = walked;
        }
        ahead
    }

    /// Slides what is used of it by a signed way along itself, and straight on beyond its end, up to a border, where it stops over
    /// the last `ease`.
    pub(crate) fn slide(&mut self, ground: &Ground, way: f64, ease: f64) {
        if way < 0.0 {
            self.reverse();
        }
        let spare = (self.lengths.last().copied().unwrap_or(0.0) - self.to).max(0.0);
        let beyond = self.onward(ground, (way.abs() + ease - spare).max(0.0));
        let room = match &beyond {
            Some(Ahead { stop: Stop::Arrived, .. }) => f64::INFINITY,
            Some(ahead) => spare + ahead.reached,
            None => spare,
        };
        if let Some(ahead) = beyond {
            let used = (self.from, self.to);
            self.to = self.lengths.last().copied().unwrap_or(0.0);
            self.append(ahead.trace);
            (self.from, self.to) = used;
        }
        let gone = stop(way.abs(), room, ease);
        self.from += gone;
        self.to += gone;
        if way < 0.0 {
            self.reverse();
        }
    }

    /// The way straight on from its end.
    fn onward(&self, ground: &Ground, way: f64) -> Option<Ahead> {
        let [.., before, last] = self.steps.as_slice() else { return None };
        let heading = position(last) - position(before);
        let mut walker = ground.terrain.walker_at(last, heading.to_array())?;
        Some(Self::ahead(&mut walker, 0.0, way)).filter(|ahead| !ahead.trace.steps.is_empty())
    }

    fn reverse(&mut self) {
        self.steps.reverse();
        self.triangles.reverse();
        self.lengths.reverse();
        let length = self.lengths.first().copied().unwrap_or(0.0);
        self.lengths.iter_mut().for_each(|l| *l = length - *l);
        (self.from, self.to) = (length - self.to, length - self.from);
    }

    /// Adds a line that starts where this one ends.
    fn append(&mut self, next: Self) {
        if self.steps.is_empty() {
            *self = next;
            return;
        }
        let length = self.to;
        self.steps.extend(next.steps.into_iter().skip(1));
        self.triangles.extend(next.triangles);
        self.lengths.extend(next.lengths.into_iter().skip(1).map(|l| length + l));
        self.to += next.to;
    }

    /// Its length, what was trimmed left out.
    pub(crate) fn length(&self) -> f64 {
        self.to - self.from
    }

    /// Its points on the surface, what was trimmed left out.
    pub(crate) fn steps(&self, ground: &Ground) -> Vec<Step> {
        let inner = |(_, length): &(&Step, &f64)| self.from < **length && **length < self.to;
        let between = self.steps.iter().zip(&self.lengths).filter(inner).map(|(step, _)| *step);
        let (start, end) = (self.step(ground, 0.0), self.step(ground, 1.0));
        start.into_iter().chain(between).chain(end).collect()
    }

    /// What stands at a fraction `0 ..= 1` of the length.
    pub(crate) fn footing(&self, ground: &Ground, fraction: f64) -> Option<Footing> {
        ground.footing(&self.step(ground, fraction)?)
    }

    /// The point of the surface at a fraction `0 ..= 1` of the length.
    fn step(&self, ground: &Ground, fraction: f64) -> Option<Step> {
        let s = self.from + (self.to - self.from) * fraction;
        if self.steps.len() < 2 {
            return self.steps.first().copied();
        }
        let next = self.lengths.partition_point(|&l| l <= s).clamp(1, self.lengths.len() - 1);
        let (a, b) = (self.lengths[next - 1], self.lengths[next]);
        // A last step may be too short to be seen in the length.
        let x = if b > a { ((s - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
        let p = position(&self.steps[next - 1]).lerp(position(&self.steps[next]), x);
        let within = self
            .triangles
            .get(next - 1)
            .copied()
            .flatten()
            .and_then(|triangle| ground.terrain.within(triangle, p.to_array()));
        within.or_else(|| ground.step(p))
    }
}

/// A line straight over the surface.
pub(crate) struct Walked {
    pub(crate) trace: Trace,
    /// From where to where it got, as signed ways from the walker.
    pub(crate) range: (f64, f64),
    /// Why it ended behind and ahead.
    pub(crate) stops: (Stop, Stop),
}

struct Ahead {
    trace: Trace,
    reached: f64,
    stop: Stop,
}

pub(crate) fn position(step: &Step) -> DVec3 {
    DVec3::from(step.position)
}
