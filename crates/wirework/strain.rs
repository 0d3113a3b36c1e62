//! The compression of a model by one of its clips, or by effects, for the effects that it drives.

use std::path::Path;
use std::time::Instant;

use wirework_asset::{Gltf, Limits, Rest};
use wirework_core::Blend;
use wirework_preset::{Action, Deform, Effect, Preset};
use wirework_wrinkle::{Drawn, Field, Pattern, SurfaceView, Wrinkle, WrinkleError};

use crate::evaluate::bounds_frame;
use crate::film::find_clip;
use crate::fit::Fit;
use crate::limbs::limbs;
use crate::mask::masks;
use crate::reach::which;
use crate::sew::sew;
use crate::unfit::unfit;
use crate::{EvaluateError, Evaluation, JobError, Model, Subject};

/// Looks at a clip in steps of so many seconds: twice as fine as what films show.
const STEP: f64 = 1.0 / 60.0;
/// Moments at which effects are looked at that come before one that follows their compression.
const MOMENTS: u32 = 48;
/// Looks at a clip at most; of a longer one in coarser steps.
const MOST: usize = 4096;
/// Looks at effects before another at most, each of which costs as much as a frame. Of more than 17 s in coarser steps, which may miss what
/// lasts but a moment, and average over less than `settle` where a step is longer than a third of that.
const MOST_BEFORE: usize = 1024;

/// The clip that drives an effect, or poses what a limb is part of or reaches for: the one asked for, or else the first. None where no effect looks
/// at one, or there is no clip.
///
/// # Errors
///
/// There is no clip of that name.
pub(crate) fn driving_clip(
    effects: &[Effect],
    model: &Model,
    wanted: Option<&str>,
) -> Result<Option<usize>, JobError> {
    let Model::Gltf { gltf, .. } = model else { return Ok(None) };
    let driven = |effect: &Effect| match &effect.action {
        Action::Wrinkle(wrinkle) => wrinkle.drive.is_some(),
        Action::Ik(limb) => limb.watches(),
        _ => false,
    };
    if !effects.iter().any(driven) {
        return Ok(None);
    }
    match wanted {
        Some(wanted) => find_clip(gltf, wanted).map(Some),
        None => Ok((!gltf.clip_names().is_empty()).then_some(0)),
    }
}

/// How long a clip of a model is, seconds; 0 without one.
///
/// # Errors
///
/// The clip is malformed.
pub(crate) fn clip_seconds(model: &Model, clip: Option<usize>) -> Result<f64, JobError> {
    let (Model::Gltf { gltf, rest }, Some(_)) = (model, clip) else { return Ok(0.0) };
    Ok(gltf.player(rest, clip)?.duration())
}

/// How long an effect lasts, and whether it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Length {
    pub(crate) seconds: f64,
    pub(crate) animated: bool,
}

impl Length {
    /// What the preset says.
    pub(crate) fn of(preset: &Preset) -> Self {
        Self { seconds: preset.duration, animated: preset.animated }
    }

    /// The same where a clip of so many seconds drives the effect.
    pub(crate) fn with_clip(self, preset: &Preset, clip: f64) -> Self {
        let seconds = if preset.follows_clip { self.seconds.max(clip) } else { self.seconds };
        Self { seconds, animated: self.animated || clip > 0.0 }
    }
}

/// The effects of a preset, with drawn creases in the place of those that are to be looked for where the subject is compressed: by the
/// clip that is asked for or the first, or else by the effects before. One that finds nothing keeps its place and does nothing, with a
/// warning.
///
/// # Errors
///
/// There is no such clip, or nothing that moves the subject; an effect before does not fit it.
pub(crate) fn found(
    subject: &Subject,
    preset: &Preset,
    (folder, limits): (&Path, &Limits),
    clip: Option<&str>,
) -> Result<(Vec<Effect>, Vec<String>), JobError> {
    let (mut effects, mut warnings) = (Vec::new(), Vec::new());
    let frame = bounds_frame(subject.bounds());
    for (index, effect) in preset.effects.iter().enumerate() {
        let placed = effect.placed(&frame);
        let Action::Wrinkle(wrinkle) = &placed.action else {
            effects.push(effect.clone());
            continue;
        };
        if !matches!(wrinkle.pattern, Pattern::Auto { .. }) {
            effects.push(effect.clone());
            continue;
        }
        let fail =
            |error| unfit(&subject.origin, &preset.effects)(EvaluateError::Wrinkle { effect: index, error });
        let surface = SurfaceView { positions: &subject.points, triangles: &subject.triangles };
        let mut field = Field::new(&surface).map_err(fail)?;
        let before = (effects.as_slice(), preset.effects.as_slice());
        let moved =
            moments(subject, before, preset.duration, (folder, limits), clip, &mut |now| field.add(now))?;
        if !moved {
            return Err(fail(WrinkleError::Unmoved));
        }
        let lines = field.lines(wrinkle);
        if lines.is_empty() {
            warnings.push(format!(
                "the wrinkle{}: nothing is compressed enough to crease [no-strain]",
                which(index)
            ));
            effects.push(inert(placed));
            continue;
        }
        let pattern = Pattern::Drawn(lines.into_iter().map(Drawn::from).collect());
        let action = Action::Wrinkle(Box::new(Wrinkle { pattern, ..(**wrinkle).clone() }));
        effects.push(Effect { action, ..placed });
    }
    Ok((effects, warnings))
}

/// What stands in the place of an effect that does nothing, so that the others keep their numbers.
fn inert(effect: Effect) -> Effect {
    let nothing = Deform { wires: Vec::new(), blend: Blend::default(), lattice: None };
    Effect { action: Action::Deform(nothing), refine: false, ..effect }
}

/// Shows the points of a subject as a clip moves them, or else the effects `before` of `all`, at moments in their order. Returns whether there is
/// anything that moves them.
fn moments(
    subject: &Subject,
    (before, all): (&[Effect], &[Effect]),
    duration: f64,
    (folder, limits): (&Path, &Limits),
    clip: Option<&str>,
    see: &mut dyn FnMut(&[[f32; 3]]),
) -> Result<bool, JobError> {
    if let Model::Gltf { gltf, rest } = &subject.model
        && (clip.is_some() || !gltf.clip_names().is_empty())
    {
        let clip = clip.map_or(Ok(0), |wanted| find_clip(gltf, wanted))?;
        play(gltf, rest, &subject.point_of, &subject.points, clip, |now| see(now))?;
        return Ok(true);
    }
    if before.is_empty() {
        return Ok(false);
    }
    let masks = masks(subject, before, folder, limits)?.complete()?;
    let seams = sew(subject, before, &masks)?;
    let fit = Fit { masks, seams, limbs: limbs(subject, before, duration)? };
    let fail = unfit(&subject.origin, all);
    let bounds = subject.bounds();
    let mut effects =
        Evaluation::fitted(before, fit, &subject.points, &subject.triangles, bounds).map_err(&fail)?;
    sense_before(&mut effects, duration).map_err(&fail)?;
    let mut now = subject.points.clone();
    for moment in 0..=MOMENTS {
        effects.at(duration * f64::from(moment) / f64::from(MOMENTS), &mut now).map_err(&fail)?;
        see(&now);
    }
    Ok(true)
}

/// Plays a clip of the scene whose points effects move, and tells them how the surface is compressed.
///
/// # Errors
///
/// The clip is malformed.
pub(crate) fn sense(
    evaluation: &mut Evaluation<'_>,
    gltf: &Gltf,
    rest: &Rest,
    point_of: &[u32],
    clip: usize,
) -> Result<(), JobError> {
    let (start, spent) = (Instant::now(), evaluation.spent());
    let mut sensing = Sensing::new(evaluation);
    let points = evaluation.points();
    let step = play(gltf, rest, point_of, points, clip, |now| sensing.read(evaluation, now))?;
    evaluation.record(step, sensing.readings);
    evaluation.sensed(spent.bind + start.elapsed());
    Ok(())
}

/// Tells effects that no clip drives how those before them compress the surface in the course of `duration` seconds, whichever moments
/// are asked for.
///
/// # Errors
///
/// An effect does not fit the one before.
pub(crate) fn sense_before(evaluation: &mut Evaluation<'_>, duration: f64) -> Result<(), EvaluateError> {
    let (start, spent) = (Instant::now(), evaluation.spent());
    let mut now = Vec::new();
    let (step, steps) = steps(duration, MOST_BEFORE);
    // In their order: what one does is part of what drives the next.
    for effect in 1..evaluation.effect_count() {
        if !evaluation.listens(effect) {
            continue;
        }
        now.resize(evaluation.points().len(), [0.0; 3]);
        let mut readings = Vec::new();
        for i in 0..=steps {
            evaluation.before(effect, step * i as f64, &mut now)?;
            readings.push(evaluation.compression(effect, &now));
        }
        evaluation.record_one(effect, step, readings);
    }
    if !now.is_empty() {
        evaluation.sensed(spent.bind + start.elapsed());
    }
    Ok(())
}

/// Equal steps of time in a duration: how long one is, and how many there are, at most so many; none where it does not last.
fn steps(duration: f64, most: usize) -> (f64, usize) {
    let steps = ((duration / STEP).ceil() as usize).min(most);
    (duration / steps.max(1) as f64, steps)
}

/// Plays a clip and shows where the points are in equal steps of time. Returns a step, seconds.
fn play(
    gltf: &Gltf,
    rest: &Rest,
    point_of: &[u32],
    points: &[[f32; 3]],
    clip: usize,
    mut see: impl FnMut(&[[f32; 3]]),
) -> Result<f64, JobError> {
    let mut player = gltf.player(rest, Some(clip))?;
    let (step, steps) = steps(player.duration(), MOST);
    let (mut positions, mut normals) = (rest.positions.clone(), Vec::new());
    let mut now = points.to_vec();
    for i in 0..=steps {
        player.pose_into(step * i as f64, None, &mut positions, &mut normals)?;
        // Backwards, so that the first vertex at a place speaks for it.
        for (&point, position) in point_of.iter().zip(&positions).rev() {
            if let Some(place) = now.get_mut(point as usize) {
                *place = *position;
            }
        }
        see(&now);
    }
    Ok(step)
}

/// Readings for each effect, at each time.
struct Sensing {
    readings: Vec<Vec<Vec<f32>>>,
}

impl Sensing {
    fn new(evaluation: &Evaluation<'_>) -> Self {
        Self { readings: vec![Vec::new(); evaluation.effect_count()] }
    }

    fn read(&mut self, evaluation: &Evaluation<'_>, now: &[[f32; 3]]) {
        for (effect, readings) in self.readings.iter_mut().enumerate() {
            readings.push(evaluation.compression(effect, now));
        }
    }
}
