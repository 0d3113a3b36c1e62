//! PNG.
//!
//! # Notes
//!
//! Bytes and milliseconds of one picture of 960×540 (a folded sheet; others are alike), tried with the filters and levels
//! that `png` has:
//!
//! | filter | fdeflate | level 4 | level 6 | level 9 |
//! |---|---|---|---|---|
//! | adaptive by sums | 285 k, 3 | 174 k, 15 | 152 k, 42 | 135 k, 130 |
//! | adaptive by entropy | 260 k, 5 | 163 k, 17 | 141 k, 40 | 127 k, 118 |
//! | sub | 266 k, 2 | 157 k, 13 | 133 k, 35 | 119 k, 111 |
//!
//! Sub alone wins on smooth surfaces by a little and loses on textures by more.

use png::{BitDepth, ColorType, DeflateCompression, Encoder, EncodingError, Filter, SrgbRenderingIntent};

use super::{EncodeError, check};
use crate::Picture;

/// Deflate's level for a still: higher takes three times as long for a tenth less.
const LEVEL: u8 = 6;

/// A picture as a PNG file: opaque RGB of 8 bits, marked as sRGB. The same picture gives the same bytes.
pub fn png(picture: &Picture) -> Result<Vec<u8>, EncodeError> {
    check(picture)?;
    let effort = DeflateCompression::Level(LEVEL);
    write(&rgb(&picture.pixels), [picture.width, picture.height], effort).map_err(|e| EncodeError::format(&e))
}

/// Pixels without their alpha.
pub(super) fn rgb(pixels: &[[u8; 4]]) -> Vec<u8> {
    pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()
}

/// A file of RGB pixels.
pub(super) fn write(
    rgb: &[u8],
    [width, height]: [u32; 2],
    effort: DeflateCompression,
) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_deflate_compression(effort);
    encoder.set_filter(Filter::MinEntropy);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(file)
}
