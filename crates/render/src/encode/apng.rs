//! Animated PNG (<https://www.w3.org/TR/png-3/#apng-frame-based-animation>).
//!
//! `png` wants the number of frames before the first of them, and compresses on one thread. So each frame is compressed by
//! itself as it comes, and the file is put together at the end.

use png::chunk;
use png::{BitDepth, ColorType, DeflateCompression, Encoder, EncodingError, SrgbRenderingIntent};

use super::EncodeError;
use super::animation::Area;
use super::png::{rgb, write};
use super::timing::fraction;

/// Deflate's level: a third of the time of a still's, for an eighth more bytes.
const LEVEL: u8 = 4;

/// Frames for an animated PNG.
pub(super) struct Apng {
    size: [u32; 2],
    frames: Vec<(Area, Vec<u8>)>,
    last: Vec<[u8; 4]>,
}

impl Apng {
    pub(super) fn new(size: [u32; 2]) -> Self {
        Self { size, frames: vec![], last: vec![] }
    }

    /// Keeps what differs from the frame before.
    pub(super) fn push(&mut self, pixels: &[[u8; 4]]) -> Result<(), EncodeError> {
        let [columns, rows] = self.size.map(|side| side as usize);
        let area = if self.frames.is_empty() {
            Area { left: 0, top: 0, width: columns, height: rows }
        } else {
            Area::changed(&self.last, pixels, columns)
        };
        let size = [area.width as u32, area.height as u32];
        let file = write(&rgb(&area.cut(pixels, columns)), size, DeflateCompression::Level(LEVEL));
        let file = file.map_err(|e| EncodeError::format(&e))?;
        self.frames.push((area, image_data(&file)));
        self.last.clear();
        self.last.extend_from_slice(pixels);
        Ok(())
    }

    pub(super) fn finish(self, fps: f64) -> Result<Vec<u8>, EncodeError> {
        if self.frames.is_empty() {
            return Err(EncodeError::Empty);
        }
        self.assemble(fraction(fps)).map_err(|e| EncodeError::format(&e))
    }

    fn assemble(&self, (over, under): (u16, u16)) -> Result<Vec<u8>, EncodingError> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, self.size[0], self.size[1]);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        // How many frames, and how often: 0 is for ever.
        let count = self.frames.len() as u32;
        writer.write_chunk(chunk::acTL, &[count.to_be_bytes(), [0; 4]].concat())?;
        let mut number = 0_u32;
        let mut next = || {
            number = number.wrapping_add(1);
            number.wrapping_sub(1).to_be_bytes()
        };
        for (i, (area, data)) in self.frames.iter().enumerate() {
            let mut control = next().to_vec();
            for place in [area.width, area.height, area.left, area.top] {
                control.extend((place as u32).to_be_bytes());
            }
            control.extend([over.to_be_bytes(), under.to_be_bytes()].concat());
            // Left as it is afterwards, and not blended with what is there.
            control.extend([0, 0]);
            writer.write_chunk(chunk::fcTL, &control)?;
            if i == 0 {
                writer.write_chunk(chunk::IDAT, data)?;
            } else {
                writer.write_chunk(chunk::fdAT, &[&next()[..], data].concat())?;
            }
        }
        writer.finish()?;
        Ok(file)
    }
}

/// The compressed pixels in a PNG file of ours.
fn image_data(file: &[u8]) -> Vec<u8> {
    const SIGNATURE: usize = 8;
    let mut data = vec![];
    let mut rest = file.get(SIGNATURE..).unwrap_or(&[]);
    // Length, name, data and checksum, chunk after chunk.
    while let Some((head, tail)) = rest.split_at_checked(8) {
        let [a, b, c, d, name @ ..] = head else { break };
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        let Some((body, after)) = tail.split_at_checked(length) else { break };
        if name == chunk::IDAT.0 {
            data.extend_from_slice(body);
        }
        rest = after.get(4..).unwrap_or(&[]);
    }
    data
}
