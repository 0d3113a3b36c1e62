//! Maps as PNG files. They are numbers, not colours: none is marked as sRGB.

use png::{BitDepth, ColorType, DeflateCompression, Encoder, EncodingError, Filter};

use super::{MapError, Maps};

/// Deflate's level, as of pictures.
const LEVEL: u8 = 6;
/// Shares in one file: red, green, blue, alpha.
pub const CHANNELS: usize = 4;

/// Bits of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// 256 steps.
    #[default]
    Eight,
    /// 65536 steps.
    Sixteen,
}

impl Depth {
    /// The step of a number from 0 to 1; halves are rounded up, so that the middle is 128, or 32768.
    fn step(self, x: f64) -> u16 {
        let most: u16 = match self {
            Self::Eight => 0xff,
            Self::Sixteen => 0xffff,
        };
        (x.clamp(0.0, 1.0) * f64::from(most) + 0.5).floor() as u16
    }

    fn push(self, x: f64, out: &mut Vec<u8>) {
        let step = self.step(x);
        match self {
            Self::Eight => out.push(step as u8),
            Self::Sixteen => out.extend(step.to_be_bytes()),
        }
    }
}

/// What is written into a file besides its pixels: a keyword of Latin letters, and a text.
pub type Texts<'a> = &'a [(&'a str, &'a str)];

/// The normal map: RGB, `(n + 1) / 2`, flat at (128, 128, 255) or (32768, 32768, 65535). Green is up; `flip_green` turns it down, as
/// DirectX has it.
///
/// # Errors
///
/// [`MapError::Format`], which should not be.
pub fn normals(maps: &Maps, depth: Depth, flip_green: bool, texts: Texts<'_>) -> Result<Vec<u8>, MapError> {
    let mut bytes = Vec::with_capacity(maps.normals.len() * 3 * if depth == Depth::Eight { 1 } else { 2 });
    for &[x, y, z] in &maps.normals {
        let y = if flip_green { -y } else { y };
        for c in [x, y, z] {
            depth.push(f64::from(c) * 0.5 + 0.5, &mut bytes);
        }
    }
    write(&bytes, maps.size, (ColorType::Rgb, depth), texts)
}

/// The heights: grey of 16 bits, `height / reach / 2 + 1/2`, 0 m at 32768. All is in the middle where `reach` is 0.
///
/// # Errors
///
/// [`MapError::Format`], which should not be.
pub fn gray(maps: &Maps, reach: f32, texts: Texts<'_>) -> Result<Vec<u8>, MapError> {
    let mut bytes = Vec::with_capacity(maps.heights.len() * 2);
    for &height in &maps.heights {
        let part = if reach > 0.0 { f64::from(height) / f64::from(reach) } else { 0.0 };
        Depth::Sixteen.push(part * 0.5 + 0.5, &mut bytes);
    }
    write(&bytes, maps.size, (ColorType::Grayscale, Depth::Sixteen), texts)
}

/// Shares, of `count` those from `first` on, as many as a file has channels: RGBA of 8 bits, grey where there is one in all. Channels
/// that nobody has are 0, alpha 1.
///
/// # Errors
///
/// [`MapError::Format`], which should not be.
pub fn shares(maps: &Maps, first: usize, count: usize) -> Result<Vec<u8>, MapError> {
    let kind = if count == 1 { ColorType::Grayscale } else { ColorType::Rgba };
    let channels = if count == 1 { 1 } else { CHANNELS };
    let mut bytes = Vec::with_capacity(maps.normals.len() * channels);
    for texel in maps.shares.chunks(count.max(1)) {
        for channel in 0..channels {
            let none = if channel + 1 == CHANNELS { 1.0 } else { 0.0 };
            let share = texel.get(first + channel).map_or(none, |share| f64::from(*share));
            Depth::Eight.push(share, &mut bytes);
        }
    }
    write(&bytes, maps.size, (kind, Depth::Eight), &[])
}

fn write(
    bytes: &[u8],
    size: [u32; 2],
    kind: (ColorType, Depth),
    texts: Texts<'_>,
) -> Result<Vec<u8>, MapError> {
    encode(bytes, size, kind, texts).map_err(|error| MapError::Format(error.to_string()))
}

fn encode(
    bytes: &[u8],
    [width, height]: [u32; 2],
    (color, depth): (ColorType, Depth),
    texts: Texts<'_>,
) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(match depth {
        Depth::Eight => BitDepth::Eight,
        Depth::Sixteen => BitDepth::Sixteen,
    });
    encoder.set_deflate_compression(DeflateCompression::Level(LEVEL));
    encoder.set_filter(Filter::Adaptive);
    for (keyword, text) in texts {
        encoder.add_text_chunk((*keyword).to_owned(), (*text).to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}
