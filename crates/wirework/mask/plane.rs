//! One channel of a PNG or JPEG file, read as numbers from 0 to 1.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use image::DynamicImage;
use wirework_asset::Limits;
use wirework_preset::Channel;

use crate::decode::{Refusal, decode};

/// A channel of an image, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Plane {
    /// Reads a channel: with 8 or 16 bits, of grey or colour. Grey is red, green and blue at once; alpha is 1 where there is
    /// none. Numbers are taken as they are stored: neither a colour space nor a rotation by metadata is undone.
    pub(super) fn read(path: &Path, channel: Channel, limits: &Limits) -> Result<Self, Refusal> {
        let bytes = bytes(path, limits)?;
        // The numbers of one channel stand beside what the decoder makes.
        let image = decode(&bytes, size_of::<f32>(), limits)?;
        let (width, height) = (image.width() as usize, image.height() as usize);
        let plane = Self { width, height, values: values(&image, channel) };
        let full = !plane.values.is_empty() && plane.values.len() == plane.width.saturating_mul(plane.height);
        if full { Ok(plane) } else { Err(Refusal::new("has no pixel that can be read")) }
    }

    /// The value at texture coordinates, `v` downwards as glTF has it: bilinear between the centres of the pixels. From 0 to 1
    /// the image ends at its edges, so that what is mapped once over meets no colour of the opposite edge; beyond, it repeats
    /// without end.
    pub(super) fn at(&self, u: f32, v: f32) -> f32 {
        let (x, y) = (Between::new(u, self.width), Between::new(v, self.height));
        let value = |x: usize, y: usize| self.values.get(y * self.width + x).copied().map_or(1.0, f64::from);
        // In this form equal values give that value exactly.
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let row = |y: usize| mix(value(x.first, y), value(x.second, y), x.part);
        mix(row(y.first), row(y.second), y.part) as f32
    }
}

/// A place between two neighbouring pixels.
struct Between {
    first: usize,
    second: usize,
    part: f64,
}

impl Between {
    fn new(coordinate: f32, count: usize) -> Self {
        let coordinate = f64::from(coordinate);
        let place = |part: f64| part * count as f64 - 0.5;
        let place = if (0.0..=1.0).contains(&coordinate) {
            place(coordinate).clamp(0.0, count.saturating_sub(1) as f64)
        } else {
            place(coordinate - coordinate.floor())
        };
        let below = place.floor();
        // From −1, before the first centre, to the last pixel; where it is clamped to a centre, `part` is 0.
        let first =
            if below < 0.0 { count.saturating_sub(1) } else { (below as usize).min(count.saturating_sub(1)) };
        let second = if first + 1 < count { first + 1 } else { 0 };
        Self { first, second, part: place - below }
    }
}

fn bytes(path: &Path, limits: &Limits) -> Result<Vec<u8>, Refusal> {
    let limit = limits.file_bytes;
    let read = || {
        let mut out = Vec::new();
        // Whatever is no file may have no end, or wait for one who writes into it.
        if std::fs::metadata(path)?.is_file() {
            File::open(path)?.take(limit.saturating_add(1)).read_to_end(&mut out)?;
        } else {
            return Err(std::io::Error::other("it is no file"));
        }
        Ok(out)
    };
    let out = read().map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            Refusal::new("is not there; its path is relative to the preset's folder")
        }
        _ => Refusal::new(format!("cannot be read: {error}")),
    })?;
    if out.len() as u64 > limit { Err(Refusal::too_large(limit, "--max-file-bytes")) } else { Ok(out) }
}

/// A channel of all pixels, from 0 to 1.
fn values(image: &DynamicImage, channel: Channel) -> Vec<f32> {
    let channels = usize::from(image.color().channel_count());
    let offset = match (channels, channel) {
        (1 | 3, Channel::A) => {
            return vec![1.0; image.width() as usize * image.height() as usize];
        }
        (2, Channel::A) => 1,
        (1 | 2, _) => 0,
        (_, channel) => channel as usize,
    };
    if let Some(flat) = image.as_flat_samples_u8() {
        return every(flat.samples, channels, offset, u8::MAX);
    }
    match image.as_flat_samples_u16() {
        Some(flat) => every(flat.samples, channels, offset, u16::MAX),
        // No PNG or JPEG has floats.
        None => Vec::new(),
    }
}

/// Of each `channels` samples the one at `offset`, in parts of the largest there is.
fn every<T: Copy + Into<f32>>(samples: &[T], channels: usize, offset: usize, most: T) -> Vec<f32> {
    let value = |pixel: &[T]| pixel.get(offset).map_or(1.0, |&sample| sample.into() / most.into());
    samples.chunks_exact(channels.max(1)).map(value).collect()
}
