//! Whether two pictures look alike.
//!
//! On one machine they are equal, byte for byte. Elsewhere the system's `sin` and `pow`, in the shapes of objects and some falloffs, may
//! round otherwise: a vertex moves by a millionth, and a sample at an edge shows what is beside it. That changes a
//! pixel by up to a quarter, but only a few of them; and a ray in a hundred thousand meets something else, which the blur spreads to
//! one or two steps of 255. Anything that one sees in a picture of half a million bytes, a fold that is lower by a
//! tenth, a shadow that is gone, changes thousands of pixels by more.

use std::io::Cursor;

use image::codecs::gif::GifDecoder;
use image::{AnimationDecoder, RgbImage};

/// A pixel differs where one of its channels does by more than this. A palette's colours are further apart.
const STEP: u8 = 4;
const PALETTE_STEP: u8 = 12;
/// Parts of all pixels that may differ.
const SHARE: f64 = 1e-3;
/// How far all channels may be off in the mean.
const MEAN: f64 = 0.25;
const PALETTE_MEAN: f64 = 0.4;
/// How much differences are enlarged to be seen.
const GAIN: u8 = 8;

/// One picture, or the frames of an animation.
pub(crate) struct Frames {
    palette: bool,
    list: Vec<RgbImage>,
}

impl Frames {
    pub(crate) fn decode(bytes: &[u8]) -> Self {
        let palette = bytes.starts_with(b"GIF8");
        let list = if palette {
            let decoder = GifDecoder::new(Cursor::new(bytes)).expect("a GIF");
            let frames = decoder.into_frames().collect_frames().expect("frames");
            frames
                .into_iter()
                .map(|frame| image::DynamicImage::from(frame.into_buffer()).into_rgb8())
                .collect()
        } else {
            vec![image::load_from_memory(bytes).expect("a picture").into_rgb8()]
        };
        Self { palette, list }
    }
}

/// How the second looks other than the first; nothing where it does not.
pub(crate) fn differ(expected: &Frames, actual: &Frames) -> Option<String> {
    if expected.list.len() != actual.list.len() {
        return Some(format!("{} frames, not {}", actual.list.len(), expected.list.len()));
    }
    let (step, most) = if expected.palette { (PALETTE_STEP, PALETTE_MEAN) } else { (STEP, MEAN) };
    expected.list.iter().zip(&actual.list).enumerate().find_map(|(frame, (a, b))| {
        if a.dimensions() != b.dimensions() {
            return Some(format!("{:?} pixels, not {:?}", b.dimensions(), a.dimensions()));
        }
        let pairs = || a.as_raw().iter().zip(b.as_raw());
        let mean = pairs().map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.as_raw().len() as f64;
        let pixels = a.pixels().zip(b.pixels());
        let off = pixels.filter(|(a, b)| a.0.iter().zip(&b.0).any(|(a, b)| a.abs_diff(*b) > step)).count();
        let share = off as f64 / f64::from(a.width() * a.height());
        (share > SHARE || mean > most).then(|| {
            format!("frame {frame} differs in {:.2} % of its pixels, by {mean:.2} in the mean", share * 100.0)
        })
    })
}

/// Expected, difference and actual from left to right, of an animation its middle.
pub(crate) fn strip(expected: Option<&Frames>, actual: &Frames) -> RgbImage {
    let middle = |frames: &Frames| frames.list[frames.list.len() / 2].clone();
    let b = middle(actual);
    let a = expected.map_or_else(|| RgbImage::new(b.width(), b.height()), middle);
    let (width, height) = (a.width().max(b.width()), a.height().max(b.height()));
    let mut out = RgbImage::new(3 * width, height);
    let get = |image: &RgbImage, x: u32, y: u32| image.get_pixel_checked(x, y).copied();
    for y in 0..height {
        for x in 0..width {
            let (p, q) = (get(&a, x, y), get(&b, x, y));
            let difference = |p: image::Rgb<u8>, q: image::Rgb<u8>| {
                image::Rgb(std::array::from_fn(|k| p.0[k].abs_diff(q.0[k]).saturating_mul(GAIN)))
            };
            let columns = [p, p.zip(q).map(|(p, q)| difference(p, q)), q];
            for (pixel, k) in columns.into_iter().zip(0..) {
                out.put_pixel(k * width + x, y, pixel.unwrap_or(image::Rgb([0; 3])));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(pixels: impl Fn(u32, u32) -> u8) -> Frames {
        let image = RgbImage::from_fn(100, 100, |x, y| image::Rgb([pixels(x, y); 3]));
        Frames { palette: false, list: vec![image] }
    }

    #[test]
    fn what_is_seen_is_told_from_what_is_rounded() {
        let grey = || frames(|_, _| 100);
        assert_eq!(differ(&grey(), &grey()), None);
        assert_eq!(differ(&grey(), &frames(|x, y| 100 + u8::from(x == y) * 2)), None, "rounding");
        assert_eq!(differ(&grey(), &frames(|x, _| 100 + u8::from(x == 7) * 3)), None, "still no step");
        assert!(
            differ(&grey(), &frames(|x, y| if x == 7 && y < 20 { 150 } else { 100 })).is_some(),
            "an edge"
        );
        assert!(differ(&grey(), &frames(|_, _| 101)).is_some(), "a light");
        assert_eq!(strip(Some(&grey()), &frames(|_, _| 110)).get_pixel(150, 50).0, [80; 3]);
    }
}
