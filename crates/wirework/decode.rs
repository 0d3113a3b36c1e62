//! PNG and JPEG images from memory, within limits.

use std::io::Cursor;

use image::error::ImageError;
use image::{DynamicImage, ImageReader};
use wirework_asset::{Limits, printable};

/// Why an image cannot be used: what follows its name in a sentence.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub(crate) message: String,
    /// Whether a limit is the reason.
    pub(crate) limit: bool,
}

impl Refusal {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), limit: false }
    }

    pub(crate) fn too_large(bytes: u64, flag: &str) -> Self {
        Self {
            message: format!("needs more than the {bytes} bytes that are allowed ({flag} raises it)"),
            limit: true,
        }
    }
}

/// Decodes an image; what is made of it, `beside` bytes a pixel, counts towards the limit too.
pub(crate) fn decode(bytes: &[u8], beside: usize, limits: &Limits) -> Result<DynamicImage, Refusal> {
    let reader = || {
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        reader.map_err(|error| Refusal::new(format!("cannot be read: {error}")))
    };
    let (width, height) = reader()?.into_dimensions().map_err(|error| unreadable(&error, limits))?;
    let made = (u64::from(width) * u64::from(height)).saturating_mul(beside as u64);
    let Some(left) = limits.expanded_bytes.checked_sub(made) else {
        return Err(Refusal::too_large(limits.expanded_bytes, "--max-expanded-bytes"));
    };
    let mut decoder = reader()?;
    let mut decoding = image::Limits::default();
    decoding.max_alloc = Some(left);
    decoder.limits(decoding);
    decoder.decode().map_err(|error| unreadable(&error, limits))
}

fn unreadable(error: &ImageError, limits: &Limits) -> Refusal {
    match error {
        ImageError::Limits(_) => Refusal::too_large(limits.expanded_bytes, "--max-expanded-bytes"),
        ImageError::Unsupported(_) => Refusal::new("is no PNG or JPEG that can be read"),
        _ => Refusal::new(format!("cannot be read: {}", printable(&error.to_string()))),
    }
}
