//! GIF.

use std::io::Cursor;

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use png::{Decoder, DeflateCompression};
use rayon::prelude::*;

use super::EncodeError;
use super::animation::Area;
use super::dither::Mixtures;
use super::palette::Tally;
use super::png::{rgb, write};
use super::timing::delays;

/// Frames that are mapped at once. More would take more memory, fewer leave threads without work.
const BATCH: usize = 16;

/// Frames for a GIF. Its colours depend on all of them, so they are kept until the end, as quickly made PNG.
pub(super) struct Gif {
    size: [u32; 2],
    frames: Vec<Vec<u8>>,
    tally: Tally,
    last: Vec<[u8; 4]>,
}

impl Gif {
    pub(super) fn new(size: [u32; 2]) -> Self {
        Self { size, frames: vec![], tally: Tally::new(), last: vec![] }
    }

    pub(super) fn push(&mut self, pixels: &[[u8; 4]]) -> Result<(), EncodeError> {
        let frame = write(&rgb(pixels), self.size, DeflateCompression::FdeflateUltraFast);
        self.frames.push(frame.map_err(|e| EncodeError::format(&e))?);
        // What stays as it was is counted once: what moves should not be drowned by what does not.
        for (i, &[r, g, b, a]) in pixels.iter().enumerate() {
            if self.last.get(i) != Some(&[r, g, b, a]) {
                self.tally.add([r, g, b]);
            }
        }
        self.last.clear();
        self.last.extend_from_slice(pixels);
        Ok(())
    }

    pub(super) fn finish(self, fps: f64) -> Result<Vec<u8>, EncodeError> {
        if self.frames.is_empty() {
            return Err(EncodeError::Empty);
        }
        let palette = self.tally.palette();
        let clear = palette.len() as u8;
        let mixtures = Mixtures::new(self.tally, &palette);
        let mut colors: Vec<u8> = palette.into_iter().flatten().collect();
        colors.extend([0; 3]);
        let [width, height] = self.size.map(|side| side as u16);
        let format = |e: gif::EncodingError| EncodeError::format(&e);
        let mut encoder = Encoder::new(Vec::new(), width, height, &colors).map_err(format)?;
        encoder.set_repeat(Repeat::Infinite).map_err(format)?;
        // The picture before, as indices.
        let mut before: Vec<u8> = vec![];
        for batch in delays(self.frames.len(), fps).chunks(BATCH) {
            let indices = |(frame, _): &(usize, u16)| map(&self.frames[*frame], &mixtures);
            let mapped = batch.par_iter().map(indices).collect::<Result<Vec<_>, EncodeError>>()?;
            let made: Vec<Frame<'_>> = (0..batch.len())
                .into_par_iter()
                .map(|i| {
                    let before = if i == 0 { &before } else { &mapped[i - 1] };
                    Frame { delay: batch[i].1, ..frame(before, &mapped[i], usize::from(width), clear) }
                })
                .collect();
            for frame in &made {
                encoder.write_lzw_pre_encoded_frame(frame).map_err(format)?;
            }
            before = mapped.into_iter().next_back().unwrap_or_default();
        }
        encoder.into_inner().map_err(format)
    }
}

/// A kept frame as indices of the palette.
fn map(frame: &[u8], mixtures: &Mixtures) -> Result<Vec<u8>, EncodeError> {
    let format = |e: png::DecodingError| EncodeError::format(&e);
    let mut reader = Decoder::new(Cursor::new(frame)).read_info().map_err(format)?;
    let columns = reader.info().width as usize;
    let mut colors = vec![0; reader.output_buffer_size().unwrap_or(0)];
    reader.next_frame(&mut colors).map_err(format)?;
    let (pixels, _) = colors.as_chunks::<3>();
    let rows = pixels.chunks(columns).enumerate();
    Ok(rows.flat_map(|(y, row)| row.iter().enumerate().map(move |(x, c)| mixtures.index(*c, x, y))).collect())
}

/// What changes from one picture to the next; `clear` where nothing does. The whole picture if there is none before.
fn frame(before: &[u8], after: &[u8], columns: usize, clear: u8) -> Frame<'static> {
    let whole = Area { left: 0, top: 0, width: columns, height: after.len() / columns };
    let area = if before.is_empty() { whole } else { Area::changed(before, after, columns) };
    let mut buffer = area.cut(after, columns);
    if !before.is_empty() {
        let before = area.cut(before, columns);
        buffer.iter_mut().zip(before).filter(|(a, b)| **a == *b).for_each(|(a, _)| *a = clear);
    }
    let mut frame = Frame {
        left: area.left as u16,
        top: area.top as u16,
        width: area.width as u16,
        height: area.height as u16,
        buffer: buffer.into(),
        dispose: DisposalMethod::Keep,
        transparent: (!before.is_empty()).then_some(clear),
        ..Frame::default()
    };
    frame.make_lzw_pre_encoded();
    frame
}
