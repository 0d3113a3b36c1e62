//! Which moments are shown.

use wirework_preset::Preset;

use crate::picture::output::PictureTarget;
use crate::picture::show::Show;
use crate::picture::{PictureJob, When};
use crate::{JobError, schedule};

/// Parts into which the time is cut to find the moment at which most has moved: halves, thirds and quarters are among
/// them, where presets like to have their keys.
const PARTS: u32 = 12;
/// Sums of squares this close, in parts of them, are the same.
const SAME: f64 = 1e-6;

/// The moments: the number of the frame, and the time in seconds; never empty. And whether the one of a still was chosen for how far
/// the effect has moved then.
pub(crate) fn moments(
    job: &PictureJob<'_>,
    target: &PictureTarget,
    show: &mut Show<'_>,
) -> Result<(Vec<(u32, f64)>, bool), JobError> {
    let length = Length::of(job.preset(), show);
    let frames = || schedule(&job.when, length.seconds, length.animated, job.fps, job.max_frames);
    match (target, &job.when) {
        (PictureTarget::Still, When::All) => {
            let found = telling(&length, show)?;
            Ok((vec![(0, found.unwrap_or(0.0))], found.is_some()))
        }
        (PictureTarget::Sheet(count), When::All) => Ok((sheet(*count, 0.0, length.end()), false)),
        (PictureTarget::Sheet(count), _) => {
            let times: Vec<f64> = frames()?.moments().map(|(_, seconds)| seconds).collect();
            let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
            Ok((sheet(*count, first, last), false))
        }
        _ => Ok((frames()?.moments().collect(), false)),
    }
}

/// Moments at which to look how far things reach, worked out once more than those that are shown: deforming costs little beside
/// rendering. Those that are shown, and for a few pictures of something that moves the
/// whole of the time, so that a still, a sheet and a later still are framed alike.
pub(crate) fn looked_at(job: &PictureJob<'_>, shown: &[(u32, f64)], show: &Show<'_>) -> Vec<f64> {
    let length = Length::of(job.preset(), show);
    let few = shown.len() <= PARTS as usize;
    let spread = (0..=PARTS).filter(|_| few && length.animated).map(|k| length.part(k, PARTS));
    shown.iter().map(|&(_, seconds)| seconds).chain(spread).collect()
}

struct Length {
    seconds: f64,
    animated: bool,
}

impl Length {
    fn of(preset: Option<&Preset>, show: &Show<'_>) -> Self {
        let (own, moves) = preset.map_or((0.0, false), |preset| (preset.duration, preset.animated));
        let clip = show.clip_duration();
        Self { seconds: own.max(clip), animated: moves || clip > 0.0 }
    }

    /// The last moment at which anything may move.
    fn end(&self) -> f64 {
        if self.animated { self.seconds } else { 0.0 }
    }

    fn part(&self, k: u32, of: u32) -> f64 {
        self.seconds * f64::from(k) / f64::from(of.max(1))
    }
}

/// The moment at which the effect has moved most: of equal ones the first; none where nothing moves.
fn telling(length: &Length, show: &mut Show<'_>) -> Result<Option<f64>, JobError> {
    if !length.animated || !show.has_effect() {
        return Ok(None);
    }
    let (mut most, mut found) = (0.0, None);
    for seconds in (0..=PARTS).map(|k| length.part(k, PARTS)) {
        show.places(seconds, false)?;
        // Rounding must not tell a moment from its mirror image.
        if show.moved() > most * (1.0 + SAME) {
            (most, found) = (show.moved(), Some(seconds));
        }
    }
    Ok(found)
}

/// `count` moments from the first to the last; one where these are the same.
fn sheet(count: u32, first: f64, last: f64) -> Vec<(u32, f64)> {
    let count = if first < last { count } else { 1 };
    let part = |k: u32| first + (last - first) * f64::from(k) / f64::from((count - 1).max(1));
    (0..count).map(|k| (k, part(k))).collect()
}
