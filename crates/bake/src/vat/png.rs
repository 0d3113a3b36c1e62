//! PNG of 16 bits a channel.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError};

use super::STEPS;

/// Writes `width`×`height` texels, red, green and blue from 0 to 1, rows from the top. No colour space is named: the numbers are no
/// colours.
///
/// # Errors
///
/// What `out` says.
pub fn write_png(texels: &[[f32; 3]], [width, height]: [usize; 2], out: &mut dyn Write) -> io::Result<()> {
    encode(texels, [width, height], out).map_err(|error| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

fn encode(
    texels: &[[f32; 3]],
    [width, height]: [usize; 2],
    out: &mut dyn Write,
) -> Result<(), EncodingError> {
    let mut encoder = Encoder::new(out, width as u32, height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Sixteen);
    encoder.set_compression(Compression::Balanced);
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer()?;
    let mut line = Vec::with_capacity(6 * width);
    for row in texels.chunks_exact(width.max(1)) {
        line.clear();
        let steps = row.as_flattened().iter().map(|&t| (f64::from(t) * STEPS).round() as u16);
        line.extend(steps.flat_map(u16::to_be_bytes));
        rows.write_all(&line)?;
    }
    rows.finish()
}
