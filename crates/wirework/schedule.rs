//! Which moments of an effect are worked out.

use std::ops::Range;

use thiserror::Error;

/// Products of a duration and a frame rate this close to a whole number are that number: 2.2 s at 25 frames a second
/// are 55 frames, not 55.00000000000001. Relative, well above the rounding of f64 and below any frame.
const WHOLE: f64 = 1e-9;

/// What is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum When {
    /// All frames of an effect that moves, else a still.
    #[default]
    All,
    /// Frames by number, half open.
    Frames(Range<u32>),
    /// A still at a time in seconds.
    At(f64),
}

/// The moments to work out; never empty.
#[derive(Clone, Debug, PartialEq)]
pub enum Schedule {
    /// One moment, in seconds.
    Still(f64),
    /// Frames by number, half open; frame `k` is at `k / fps` seconds.
    Frames {
        /// Which frames.
        frames: Range<u32>,
        /// Frames a second.
        fps: f64,
    },
}

/// Why there is no schedule.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ScheduleError {
    /// The frame rate is not positive and finite.
    #[error("the frame rate must be a positive number, not {0}")]
    FrameRate(f64),
    /// The time of the still is not finite.
    #[error("the time of a still must be a finite number of seconds, not {0}")]
    Time(f64),
    /// A range without frames.
    #[error("the range {}..{} holds no frames", .0.start, .0.end)]
    Empty(Range<u32>),
    /// Two frames would be at the same time: files keep times as 32-bit floats.
    #[error("at {fps} frames a second, frame {frame} and the one before it fall on the same time")]
    Dense {
        /// Frames a second.
        fps: f64,
        /// The last frame.
        frame: u32,
    },
    /// More frames than allowed.
    #[error("{} frames are more than the {limit} that are allowed (--max-frames raises it)", short(*.frames))]
    TooMany {
        /// How many there are.
        frames: f64,
        /// How many may be.
        limit: u32,
    },
}

/// A number that may have hundreds of digits.
fn short(number: f64) -> String {
    if number < 1e15 { number.to_string() } else { format!("{number:.1e}") }
}

/// The moments of an effect of `duration` seconds: frame `k` at `k / fps` seconds, the last one ⌈duration · fps⌉.
///
/// ```
/// use wirework::{Schedule, When, schedule};
///
/// assert_eq!(schedule(&When::All, 1.5, true, 24.0, 1000)?, Schedule::Frames { frames: 0..37, fps: 24.0 });
/// assert_eq!(schedule(&When::All, 1.5, false, 24.0, 1000)?, Schedule::Still(0.0));
/// # Ok::<(), wirework::ScheduleError>(())
/// ```
pub fn schedule(
    when: &When,
    duration: f64,
    animated: bool,
    fps: f64,
    max_frames: u32,
) -> Result<Schedule, ScheduleError> {
    if !(fps > 0.0 && fps.is_finite()) {
        return Err(ScheduleError::FrameRate(fps));
    }
    let frames = match when {
        When::At(seconds) if seconds.is_finite() => return Ok(Schedule::Still(*seconds)),
        When::At(seconds) => return Err(ScheduleError::Time(*seconds)),
        When::All if !animated => return Ok(Schedule::Still(0.0)),
        When::All => {
            let last = last_frame(duration, fps);
            if last >= f64::from(max_frames) {
                return Err(ScheduleError::TooMany { frames: last + 1.0, limit: max_frames });
            }
            0..last as u32 + 1
        }
        When::Frames(frames) => frames.clone(),
    };
    let count = frames.end.saturating_sub(frames.start);
    if count == 0 {
        return Err(ScheduleError::Empty(frames));
    }
    if count > max_frames {
        return Err(ScheduleError::TooMany { frames: f64::from(count), limit: max_frames });
    }
    let time = |frame: u32| (f64::from(frame) / fps) as f32;
    let last = frames.end - 1;
    if !time(last).is_finite() || (last > frames.start && time(last - 1) == time(last)) {
        return Err(ScheduleError::Dense { fps, frame: last });
    }
    Ok(Schedule::Frames { frames, fps })
}

/// What is nearer to a frame than this part of the way to the next is there.
const AT_FRAME: f64 = 1e-3;

fn last_frame(duration: f64, fps: f64) -> f64 {
    let exact = (duration * fps).max(0.0);
    let whole = exact.round();
    if (exact - whole).abs() <= WHOLE * whole { whole } else { exact.ceil() }
}

impl Schedule {
    /// How many moments there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Still(_) => 1,
            Self::Frames { frames, .. } => frames.len(),
        }
    }

    /// The first moment and the last, in seconds.
    pub(crate) fn ends(&self) -> (f64, f64) {
        match self {
            Self::Still(seconds) => (*seconds, *seconds),
            Self::Frames { frames, fps } => {
                let last = frames.end.saturating_sub(1).max(frames.start);
                (f64::from(frames.start) / fps, f64::from(last) / fps)
            }
        }
    }

    /// The times of all moments, and in between those of `keys`, in order, that are not at one of them all the same.
    pub(crate) fn times_with(&self, keys: &[f64]) -> Vec<f64> {
        let mut times: Vec<f64> = self.moments().map(|(_, seconds)| seconds).collect();
        let Self::Frames { fps, .. } = self else { return times };
        let (first, last) = self.ends();
        for &key in keys.iter().filter(|key| (first..last).contains(*key)) {
            let place = times.partition_point(|time| *time < key);
            let around = times[place.saturating_sub(1)..].iter().take(2);
            // Files keep times as 32-bit floats.
            let is_other = |time: &f64| (time - key).abs() * fps > AT_FRAME && *time as f32 != key as f32;
            if around.into_iter().all(is_other) {
                times.insert(place, key);
            }
        }
        times
    }

    /// The moments in their order: the number of the frame (0 for a still), and its time in seconds.
    pub fn moments(&self) -> impl Iterator<Item = (u32, f64)> + use<> {
        let (frames, fps, offset) = match self {
            Self::Still(seconds) => (0..1, 1.0, *seconds),
            Self::Frames { frames, fps } => (frames.clone(), *fps, 0.0),
        };
        frames.map(move |frame| (frame, f64::from(frame) / fps + offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_frame_is_the_first_at_or_after_the_end() {
        let count = |duration, fps| schedule(&When::All, duration, true, fps, 10_000).unwrap().count();
        assert_eq!(count(3.0, 24.0), 73);
        assert_eq!(count(1.01, 24.0), 26);
        // 2.2 · 25 is 55.00000000000001 in f64, and 8.2 · 30 is 245.99999999999997.
        assert_eq!(count(2.2, 25.0), 56);
        assert_eq!(count(8.2, 30.0), 247);
        assert_eq!(count(1e-6, 24.0), 2);
    }

    #[test]
    fn keys_between_frames_are_moments_too() {
        let frames = schedule(&When::Frames(2..6), 1.0, true, 10.0, 100).unwrap();
        let keys = [0.1, 0.2, 0.23, 0.230_01, 0.300_01, 0.31, 0.5, 0.6];
        assert_eq!(frames.times_with(&keys), [0.2, 0.23, 0.3, 0.31, 0.4, 0.5]);
        assert_eq!(frames.times_with(&[]), [0.2, 0.3, 0.4, 0.5]);
        assert_eq!(Schedule::Still(0.3).times_with(&keys), [0.3]);
    }

    #[test]
    fn frames_and_stills() {
        let schedule = |when, fps| schedule(&when, 2.0, true, fps, 100);
        let some = schedule(When::Frames(5..7), 10.0).unwrap();
        assert_eq!(some.moments().collect::<Vec<_>>(), [(5, 0.5), (6, 0.6)]);
        assert_eq!(schedule(When::At(1.5), 10.0).unwrap().moments().collect::<Vec<_>>(), [(0, 1.5)]);
        assert!(matches!(schedule(When::Frames(5..5), 10.0), Err(ScheduleError::Empty(_))));
        assert!(matches!(schedule(When::All, 0.0), Err(ScheduleError::FrameRate(_))));
        assert!(matches!(schedule(When::All, 1e9), Err(ScheduleError::TooMany { .. })));
        let far = schedule(When::All, 1e300).unwrap_err().to_string();
        assert!(far.starts_with("2.0e300 frames are more"), "{far}");
        assert!(matches!(schedule(When::Frames(0..101), 1.0), Err(ScheduleError::TooMany { .. })));
        assert!(matches!(schedule(When::At(f64::NAN), 1.0), Err(ScheduleError::Time(_))));
        let far = When::Frames(4_000_000_000..4_000_000_002);
        assert!(matches!(schedule(far, 24.0), Err(ScheduleError::Dense { .. })));
    }
}
