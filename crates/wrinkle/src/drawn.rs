//! Drawn creases: curves dropped onto the surface by nearest point.

use glam::DVec3;
use wirework_core::Curve;
use wirework_surface::Step;

use crate::ground::{Ground, wide};
use crate::pattern::Line;
use crate::random::{Jitter, unit};
use crate::trace::{Trace, position};
use crate::travel::{room, stop};
use crate::{Wrinkle, WrinkleError};

/// Samples of a drawn curve: at least so many, for its shape, and at most, for the time it takes.
const SAMPLES: std::ops::RangeInclusive<usize> = 65..=4097;
/// Samples in the length of a thickness: what happens between two of them is small against the crease.
const SAMPLES_A_THICKNESS: f32 = 4.0;
/// A curve whose trace on the surface is shorter than this part of it has collapsed.
const COLLAPSED: f64 = 1e-3;
/// Two neighbouring samples this many times farther apart than they were drawn have jumped over a part of the surface.
pub(crate) const JUMP: f64 = 4.0;

/// A curve may be drawn past a border by so many thicknesses, lest its crease end before that, without a word.
const PAST: f64 = 2.0;

/// Drops curve number `index` onto the surface, jittered as the settings say. Besides, how often it passes a border.
pub(crate) fn drop(
    ground: &Ground,
    curve: &Curve,
    index: usize,
    settings: &Wrinkle,
    seconds: f64,
    thickness: f32,
) -> Result<(Line, usize), WrinkleError> {
    let length = curve.length();
    let wanted = (length / thickness * SAMPLES_A_THICKNESS) as usize;
    let mut drawn: Vec<DVec3> =
        curve.spread(wanted.clamp(*SAMPLES.start(), *SAMPLES.end())).into_iter().map(wide).collect();
    let distance = drawn.iter().map(|&p| ground.distance(p)).fold(f64::INFINITY, f64::min);
    if length <= 0.0 {
        return Err(WrinkleError::Collapsed { curve: index });
    }
    if distance > f64::from(length) {
        return Err(WrinkleError::TooFar { curve: index, distance: distance as f32, length });
    }
    if curve.closed() {
        drawn.push(drawn[0]);
    }
    let gap = f64::from(length) / (drawn.len() - 1) as f64;
    let mut points: Vec<Step> = drawn.iter().filter_map(|&p| ground.step(p)).collect();
    let passed = passed(ground, &drawn, &points, PAST * f64::from(thickness));
    let random = f64::from(settings.randomness);
    let shift = random * f64::from(thickness) * (2.0 * unit(settings.seed, index, Jitter::Sideways) - 1.0);
    if shift != 0.0 {
        points = sideways(ground, &points, shift, curve.closed());
    }
    let [along, across] = settings.motion.velocity().map(|v| v * seconds);
    if across != 0.0 {
        points = travel(ground, &points, across, f64::from(thickness), curve.closed());
    }
    let mut trace = Trace::along(ground, &points, gap * JUMP);
    if trace.to <= COLLAPSED * f64::from(length) {
        return Err(WrinkleError::Collapsed { curve: index });
    }
    if !curve.closed() {
        let trim = |what| random * 0.25 * unit(settings.seed, index, what);
        trace.from = trim(Jitter::Start) * trace.to;
        trace.to -= trim(Jitter::End) * trace.to;
        if along != 0.0 {
            trace.slide(ground, along, f64::from(thickness));
        }
    }
    let strength = 1.0 - 0.5 * random * unit(settings.seed, index, Jitter::Height);
    // One fold by itself takes up what its own width lacks.
    let spacing = (2.0 * f64::from(thickness), 2.0 * f64::from(thickness));
    let line =
        Line { trace, closed: curve.closed(), range: (0.0, 1.0), strength, spacing, index, fork: None };
    Ok((line, passed))
}

/// How often a drawn line leaves the surface: stretches of it whose feet on the surface lie on a border, farther than `far` beside them.
fn passed(ground: &Ground, drawn: &[DVec3], feet: &[Step], far: f64) -> usize {
    let beyond = |(p, foot): (&DVec3, &Step)| {
        let off = *p - position(foot);
        let beside = || ground.footing(foot).map_or(0.0, |f| (off - f.normal * off.dot(f.normal)).length());
        off.length() > far && ground.terrain.on_border(foot) && beside() > far
    };
    let beyond: Vec<bool> = drawn.iter().zip(feet).map(beyond).collect();
    let stretches = beyond.chunk_by(|a, b| a == b).filter(|stretch| stretch[0]).count();
    // The last point of a closed line is its first.
    let again = stretches > 1 && beyond[0] && drawn.first() == drawn.last();
    stretches - usize::from(again)
}

/// The points gone across their line, each straight ahead over the surface and up to a border.
fn travel(ground: &Ground, points: &[Step], way: f64, thickness: f64, closed: bool) -> Vec<Step> {
    let gone = |i: usize| {
        let across = across(ground, points, i, closed) * way.signum();
        let walker = ground.terrain.walker_at(&points[i], across.to_array());
        let Some(mut walker) = walker else { return points[i] };
        let room = room(&walker, way.abs(), thickness);
        walker.walk(stop(way.abs(), room, thickness), |_, _| {});
        walker.step()
    };
    (0..points.len()).map(gone).collect()
}

/// The points moved across their line by `shift` and dropped again.
fn sideways(ground: &Ground, points: &[Step], shift: f64, closed: bool) -> Vec<Step> {
    let moved = |i: usize| ground.step(position(&points[i]) + across(ground, points, i, closed) * shift);
    (0..points.len()).filter_map(moved).collect()
}

/// The unit direction across a line of points, normal × along, at one of them.
fn across(ground: &Ground, points: &[Step], i: usize, closed: bool) -> DVec3 {
    let last = points.len().saturating_sub(1);
    // The last point of a closed line is its first.
    let i = if closed && i == last { 0 } else { i };
    let before = if closed && i == 0 { &points[last - 1] } else { &points[i.saturating_sub(1)] };
    let along = position(&points[(i + 1).min(last)]) - position(before);
    let normal = ground.footing(&points[i]).map_or(DVec3::ZERO, |f| f.normal);
    normal.cross(along).normalize_or_zero()
}

#[cfg(test)]
#[path = "drawn_tests.rs"]
mod tests;
