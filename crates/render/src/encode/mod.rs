//! Pictures as files.

mod png;

use thiserror::Error;

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
    /// The format's own writer refused, which it should not.
    #[error("the picture cannot be written: {0}")]
    Format(String),
}

impl EncodeError {
    fn format(error: &dyn std::fmt::Display) -> Self {
        Self::Format(error.to_string())
    }
}

/// Refuses a picture that is none.
fn check(picture: &Picture) -> Result<(), EncodeError> {
    let Picture { width, height, ref pixels } = *picture;
    if !(1..=crate::MAX_SIDE).contains(&width) || !(1..=crate::MAX_SIDE).contains(&height) {
        return Err(EncodeError::Size { width, height });
    }
    if pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(EncodeError::Pixels { width, height, pixels: pixels.len() });
    }
    Ok(())
}
