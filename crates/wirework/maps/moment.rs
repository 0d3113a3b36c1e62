//! Which moment the maps are of, and over which their weights are looked at.

use crate::maps::job::{MapJob, squares};
use crate::motion::Motion;
use crate::{JobError, Progress, When, schedule};

/// Parts into which the time is cut to find the moment at which most has moved, as of pictures.
const PARTS: u32 = 12;
/// Sums of squares this close, in parts of them, are the same.
const SAME: f64 = 1e-6;

/// How long an effect lasts, and whether it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Length {
    pub(crate) seconds: f64,
    pub(crate) animated: bool,
}

impl Length {
    /// Where a clip of so many seconds drives it.
    pub(crate) fn new(job: &MapJob<'_>, clip: f64) -> Self {
        Self { seconds: job.preset.duration.max(clip), animated: job.preset.animated || clip > 0.0 }
    }

    /// The times at which weights are looked at, seconds.
    pub(crate) fn times(&self, job: &MapJob<'_>) -> Result<Vec<f64>, JobError> {
        let all = schedule(&When::All, self.seconds, self.animated, job.fps, job.max_frames)?;
        Ok(all.moments().map(|(_, seconds)| seconds).collect())
    }
}

/// The moment at which the effect has moved most: of equal ones the first, 0 s where nothing moves.
pub(crate) fn telling(
    length: &Length,
    motion: &mut Motion<'_>,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<f64, JobError> {
    if !length.animated {
        return Ok(0.0);
    }
    let (mut most, mut found) = (0.0, 0.0);
    for k in 0..=PARTS {
        let seconds = length.seconds * f64::from(k) / f64::from(PARTS);
        motion.at(seconds)?;
        let moved = squares(motion);
        // Rounding must not tell a moment from its mirror image.
        if moved > most * (1.0 + SAME) {
            (most, found) = (moved, seconds);
        }
        progress(Progress { done: k as usize + 1, frames: PARTS as usize + 1 });
    }
    Ok(found)
}
