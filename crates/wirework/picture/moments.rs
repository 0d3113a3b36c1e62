//! Which moments are shown.

use wirework_preset::Preset;

use crate::picture::output::PictureTarget;
use crate::picture::show::Show;
use crate::picture::{PictureJob, When};
use crate::{JobError, Schedule, schedule};

/// Parts into which the time is cut to find the moment at which most has moved: halves, thirds and quarters are among
/// them, where presets like to have their keys.
const PARTS: u32 = 12;

/// The moments: the number of the frame, and the time in seconds. Never empty.
pub(crate) fn moments(
    job: &PictureJob<'_>,
    target: &PictureTarget,
    show: &mut Show<'_>,
) -> Result<Vec<(u32, f64)>, JobError> {
    let length = Length::of(job.preset(), show);
    let all = schedule(&job.when, length.seconds, length.animated, job.fps, job.max_frames)?;
    match (target, &job.when) {
        (PictureTarget::Still, When::All) => Ok(vec![(0, telling(&length, show)?)]),
        (PictureTarget::Sheet(count), when) => Ok(sheet(*count, when, &length, &all)),
        _ => Ok(all.moments().collect()),
    }
}

/// Moments at which to look how far things reach: those that are shown, and for a few pictures of something that moves the
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

    fn part(&self, k: u32, of: u32) -> f64 {
        self.seconds * f64::from(k) / f64::from(of.max(1))
    }
}

/// The moment at which the effect has moved most: of equal ones the first.
fn telling(length: &Length, show: &mut Show<'_>) -> Result<f64, JobError> {
    let mut best = (0.0, 0.0);
    for k in 0..=PARTS {
        let seconds = length.part(k, PARTS);
        if !length.animated || show.evaluation().is_none() {
            break;
        }
        show.places(seconds, false)?;
        // Rounding must not tell a moment from its mirror image.
        if show.moved() > best.0 * (1.0 + 1e-6) {
            best = (show.moved(), seconds);
        }
    }
    Ok(best.1)
}

/// `count` moments from the first to the last.
fn sheet(count: u32, when: &When, length: &Length, all: &Schedule) -> Vec<(u32, f64)> {
    let (first, last) = match (when, all) {
        (When::Frames(_), Schedule::Frames { frames, fps }) => {
            (f64::from(frames.start) / fps, f64::from(frames.end - 1) / fps)
        }
        _ => (0.0, length.seconds),
    };
    if !length.animated {
        return vec![(0, first)];
    }
    let part = |k: u32| first + (last - first) * f64::from(k) / f64::from((count - 1).max(1));
    (0..count).map(|k| (k, part(k))).collect()
}
