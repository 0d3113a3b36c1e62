//! How fine a subject has to be for the effects that ask for it.

use std::path::Path;

use wirework_asset::Limits;
use wirework_core::Keyed;
use wirework_preset::{Action, Effect};
use wirework_wrinkle::{Creases, Drawn, Motion, Pattern, SurfaceView, Wrinkle, creases};

use crate::evaluate::bounds_frame;
use crate::mask::{Masks, masks};
use crate::refine::Refinement;
use crate::unfit::unfit;
use crate::{EvaluateError, JobError, Schedule, Subject};

/// Between two moments at which creases are looked for they go so many parts of their thickness at most, so that the bands that they fold
/// overlap. Above 2 something between would stay coarse.
const STRIDE: f64 = 0.5;
/// Moments for creases that move, at least, however slow they are: what is dropped onto a surface may jump.
const FEW: usize = 48;
/// And at most, each of which takes as long as laying the creases. Creases that go farther than 2000 times their thickness may pass over edges
/// that stay too long; the last ones are such that some of every part of the way is seen.
const MOST: usize = 4096;
/// How much faster than its mean speed an eased track is at most.
const EASE: f64 = 1.5;

/// The time in which effects are looked at, seconds: from 0, or earlier, to the later of the end and the last moment asked for, so that the
/// frames of an effect all have the same mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    from: f64,
    to: f64,
}

impl Span {
    /// Of an effect that lasts so long.
    pub(crate) fn new(duration: f64) -> Self {
        Self { from: 0.0, to: duration }
    }

    /// Lengthened to take in a moment, where one is asked for.
    pub(crate) fn at(self, seconds: Option<f64>) -> Self {
        seconds.map_or(self, |s| Self { from: self.from.min(s), to: self.to.max(s) })
    }

    /// Lengthened to take in what is asked for.
    pub(crate) fn with(self, schedule: &Schedule) -> Self {
        let (first, last) = schedule.ends();
        Self { from: self.from.min(first), to: self.to.max(last) }
    }
}

/// The subject made finer where effects that ask for it fold it at any time, and their masks on it. Effects are looked for where they act on
/// the rest.
///
/// # Errors
///
/// As [`Subject::refined`]; the pattern of an effect does not fit the subject; a name or an image that one asks for is not there.
pub(crate) fn refined(
    subject: Subject,
    effects: &[Effect],
    span: Span,
    (folder, limits): (&Path, &Limits),
) -> Result<(Subject, Masks, Refinement), JobError> {
    let made = masks(&subject, effects, folder, limits)?.complete()?;
    if !effects.iter().any(|effect| effect.refine) {
        return Ok((subject, made, Refinement::default()));
    }
    let frame = bounds_frame(subject.bounds());
    let mut wanted = vec![f32::INFINITY; subject.points.len()];
    for (index, effect) in effects.iter().enumerate().filter(|(_, effect)| effect.refine) {
        let Action::Wrinkle(wrinkle) = effect.placed(&frame).action else { continue };
        let fail = |error| unfit(&subject.origin, effects)(EvaluateError::Wrinkle { effect: index, error });
        let surface = SurfaceView { positions: &subject.points, triangles: &subject.triangles };
        let mut creases = creases(&surface, &wrinkle).map_err(fail)?;
        let mut own = vec![f32::INFINITY; subject.points.len()];
        want(&mut creases, &wrinkle, span, &mut own).map_err(fail)?;
        let factors = made.of_effects.get(index).and_then(|masks| masks.of_effect());
        keep(&mut wanted, &own, factors, &subject.triangles);
    }
    let (subject, refinement) = subject.refined(&wanted, limits)?;
    if refinement.meshes.is_empty() {
        return Ok((subject, made, refinement));
    }
    // Both at once might be more than the limits allow.
    drop(made);
    let made = masks(&subject, effects, folder, limits)?.complete()?;
    Ok((subject, made, refinement))
}

/// Takes what an effect wants where it moves something: at the corners of triangles of which a corner may move at all.
fn keep(wanted: &mut [f32], own: &[f32], factors: Option<&[f32]>, triangles: &[[u32; 3]]) {
    let mut take = |point: usize| {
        if let (Some(wanted), Some(own)) = (wanted.get_mut(point), own.get(point)) {
            *wanted = wanted.min(*own);
        }
    };
    let Some(factors) = factors else { return (0..own.len()).for_each(take) };
    let moves = |point: &u32| factors.get(*point as usize).is_none_or(|factor| *factor > 0.0);
    for point in triangles.iter().filter(|triangle| triangle.iter().any(moves)).flatten() {
        take(*point as usize);
    }
}

/// Notes the edges that creases want at any time.
pub(crate) fn want(
    creases: &mut Creases,
    wrinkle: &Wrinkle,
    span: Span,
    wanted: &mut [f32],
) -> Result<(), wirework_wrinkle::WrinkleError> {
    creases.want_edges(wanted);
    for seconds in moments(wrinkle, span) {
        creases.at(seconds, None)?;
        creases.want_edges(wanted);
    }
    Ok(())
}

/// The moments at which creases that move are looked for, none for others.
fn moments(wrinkle: &Wrinkle, Span { from, to }: Span) -> Vec<f64> {
    if !wrinkle.moves() {
        return Vec::new();
    }
    let least = wrinkle.thickness.values().copied().fold(f32::INFINITY, f32::min);
    let stride = STRIDE * f64::from(least);
    let speed = match wrinkle.motion {
        Motion::Travelling { velocity: [along, across] } => f64::from(along).hypot(f64::from(across)),
        _ => 0.0,
    };
    let tracks: Vec<&Keyed<Vec<[f32; 3]>>> = match &wrinkle.pattern {
        Pattern::Drawn(curves) => curves.iter().filter_map(|drawn: &Drawn| drawn.points.as_ref()).collect(),
        _ => Vec::new(),
    };
    // Between keys speeds are alike; what is fast there is looked at often only there.
    let mut ends: Vec<f64> = tracks.iter().flat_map(|track| track.times()).collect();
    ends.retain(|time| *time > from && *time < to);
    ends.sort_unstable_by(f64::total_cmp);
    ends.dedup();
    let skip = ends.len().div_ceil(MOST / 2).max(1);
    let ends: Vec<f64> = [from].into_iter().chain(ends.into_iter().step_by(skip)).chain([to]).collect();
    let pieces: Vec<(f64, f64)> = ends.windows(2).map(|pair| (pair[0], pair[1])).collect();
    let strides = |&(a, b): &(f64, f64)| {
        let keyed = tracks.iter().map(|track| EASE * farthest(&track.at(a), &track.at(b)));
        ((speed * (b - a) + keyed.fold(0.0, f64::max)) / stride).clamp(0.0, f64::from(u32::MAX))
    };
    let all: f64 = pieces.iter().map(strides).sum();
    let room = MOST.saturating_sub(pieces.len()) as f64;
    let few = FEW as f64 / pieces.len().max(1) as f64;
    let mut moments = vec![from];
    for piece @ (a, b) in &pieces {
        let count = (strides(piece) * (room / all).min(1.0)).max(few).ceil() as u32;
        moments.extend((1..=count).map(|i| a + (b - a) * f64::from(i) / f64::from(count)));
    }
    moments
}

/// The largest distance between points and where they have gone.
fn farthest(from: &[[f32; 3]], to: &[[f32; 3]]) -> f64 {
    let way = |(a, b): (&[f32; 3], &[f32; 3])| {
        a.iter().zip(b).map(|(a, b)| (f64::from(*b) - f64::from(*a)).powi(2)).sum::<f64>().sqrt()
    };
    from.iter().zip(to).map(way).fold(0.0, f64::max)
}

#[cfg(test)]
#[path = "fineness_tests.rs"]
mod tests;
