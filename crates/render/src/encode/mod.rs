//! Pictures as files.

mod animation;
mod apng;
mod dither;
mod gif;
mod palette;
mod png;
mod timing;

use thiserror::Error;

pub use animation::{Animation, AnimationKind};
pub use png::png;

use crate::Picture;

/// Why there is no file.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// A side is 0 or above [`MAX_SIDE`](crate::MAX_SIDE).
    #[error("a picture of {width}×{height} pixels: each side must be 1 to {} pixels", crate::MAX_SIDE)]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// A picture's sides do not go with its pixels.
    #[error("a picture of {width}×{height} pixels cannot have {pixels} of them")]
    Pixels {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels it has.
        pixels: usize,
    },
    /// A frame's size is not that of its animation.
    #[error("a frame of {width}×{height} pixels does not fit into an animation of another size")]
    OtherSize {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// Frames a second that are no number from [`Animation::FPS`].
    #[error("{fps} frames a second: 0.01 to 1000 are possible")]
    Fps {
        /// What was asked for.
        fps: f64,
    },
    /// An animation without frames.
    #[error("an animation needs at least one frame")]
    Empty,
    /// The format's own writer refused, which it should not.
    #[error("the picture cannot be written: {0}")]
    Format(String),
}

impl EncodeError {
    fn format(error: &dyn std::fmt::Display) -> Self {
        Self::Format(error.to_string())
    }
}

/// Refuses sides that no picture has.
fn check_size([width, height]: [u32; 2]) -> Result<(), EncodeError> {
    let possible = 1..=crate::MAX_SIDE;
    if possible.contains(&width) && possible.contains(&height) {
        Ok(())
    } else {
        Err(EncodeError::Size { width, height })
    }
}

/// Refuses a picture that is none.
fn check(picture: &Picture) -> Result<(), EncodeError> {
    let Picture { width, height, ref pixels } = *picture;
    check_size([width, height])?;
    if pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(EncodeError::Pixels { width, height, pixels: pixels.len() });
    }
    Ok(())
}
