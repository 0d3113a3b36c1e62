//! Parallel creases: geodesics that leave one across the pattern at right angles.

use std::f64::consts::FRAC_PI_2;

use wirework_surface::{Stop, Walker};

use crate::pattern::{Line, Lines};
use crate::random::{Jitter, unit};
use crate::trace::{Trace, Walked};
use crate::travel::{room, stop};
use crate::{Layout, Wrinkle};

/// The most jitter sideways, in parts of the spacing: neighbours keep a fifth of it between them.
const SIDEWAYS: f64 = 0.4;
/// The most jitter of the direction, radians: a crease as long as ten spacings still stays off its neighbours.
const ASKEW: f64 = 0.06;
/// The most that is lost of a crease at either end.
const SHORTER: f64 = 0.25;
/// A line shorter than this part of its crease is none.
const COLLAPSED: f64 = 1e-3;

/// Lays the creases from a walker at the centre who looks along them.
pub(crate) fn lay(
    center: &Walker<'_>,
    layout: &Layout,
    settings: &Wrinkle,
    seconds: f64,
    thickness: f64,
    lines: &mut Lines,
) {
    let [length, width] = layout.size.map(f64::from);
    let spacing = width / f64::from(layout.creases);
    let random = f64::from(settings.randomness);
    let jitter = |index, what| random * (2.0 * unit(settings.seed, index, what) - 1.0);
    let velocity = settings.motion.velocity();
    let way = velocity[1] * seconds;
    let room = if way == 0.0 { f64::INFINITY } else { across(center, width, way, thickness) };
    // Folds that come to a border gather there; those behind stay behind.
    let gathered = spacing.min(thickness);
    for index in 0..layout.creases as usize {
        let middle = (index as f64 + 0.5) / f64::from(layout.creases) - 0.5;
        let at = middle * width + SIDEWAYS * spacing * jitter(index, Jitter::Sideways);
        let ahead = if way < 0.0 { index } else { layout.creases as usize - 1 - index };
        let room = room - way.signum() * at - gathered * ahead as f64;
        let Some(mut walker) = foot(center, at, stop(way, room, thickness)) else {
            lines.outside += 1;
            continue;
        };
        walker.turn(ASKEW * jitter(index, Jitter::Askew));
        let trim = |what| SHORTER * random * unit(settings.seed, index, what) * length;
        let range = (trim(Jitter::Start) - length / 2.0, length / 2.0 - trim(Jitter::End));
        let shift = along(&walker, range, velocity[0] * seconds, thickness);
        let walked = Trace::straight(&walker, (range.0 + shift, range.1 + shift));
        if walked.trace.length() < COLLAPSED * length {
            lines.outside += 1;
            continue;
        }
        let fraction = |way: f64| (way - shift) / length + 0.5;
        let wanted = (range.0 + shift, range.1 + shift);
        let Walked { trace, range, stops } = walked;
        lines.note(stops.0, range.0 - wanted.0, length);
        lines.note(stops.1, wanted.1 - range.1, length);
        lines.list.push(Line {
            trace,
            closed: false,
            range: (fraction(range.0), fraction(range.1)),
            strength: 1.0 - 0.5 * random * unit(settings.seed, index, Jitter::Height),
            spacing: (spacing, spacing),
            index,
            fork: None,
        });
    }
}

/// How far it is from the centre across the pattern to a border, in the direction of the sign of `way`; infinite where none of the folds
/// is to slow down for it yet.
fn across(center: &Walker<'_>, width: f64, way: f64, thickness: f64) -> f64 {
    let mut walker = center.clone();
    walker.turn(FRAC_PI_2 * way.signum());
    // The foremost is half the width ahead, and the others gather over at most the width behind it.
    room(&walker, 2.0 * width + way.abs(), thickness)
}

/// Someone who has gone `rest` across from the centre and `way` on, and looks along again; none where the surface does not go so far
/// at rest.
fn foot<'a>(center: &Walker<'a>, rest: f64, way: f64) -> Option<Walker<'a>> {
    let at = rest + way;
    let side = FRAC_PI_2 * at.signum();
    let mut walker = center.clone();
    walker.turn(side);
    let (walked, stop) = walker.walk(at.abs(), |_, _| {});
    // Having come to a border on its way it stands there by rounding.
    let there = stop == Stop::Arrived || (way != 0.0 && at.abs() - walked < 1e-3 * way.abs());
    walker.turn(-side);
    there.then_some(walker)
}

/// How far a crease has gone along itself: its front end stops at a border.
fn along(walker: &Walker<'_>, range: (f64, f64), way: f64, thickness: f64) -> f64 {
    if way == 0.0 {
        return 0.0;
    }
    let mut ahead = walker.clone();
    if way < 0.0 {
        ahead.turn(std::f64::consts::PI);
    }
    let end = if way < 0.0 { -range.0 } else { range.1 };
    stop(way, room(&ahead, end + way.abs(), thickness) - end, thickness)
}

#[cfg(test)]
#[path = "tangential_tests.rs"]
mod tests;
