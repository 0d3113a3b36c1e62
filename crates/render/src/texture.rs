//! A base colour picture and its smaller copies.

use crate::RenderError;
use crate::tone::decode_table;

/// A picture on a surface, repeated in both directions, with a chain of halved copies made when it is loaded, so that
/// it does not shimmer where it is small.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The largest first, each half of the one before (rounded down, at least 1).
    levels: Vec<Level>,
}

/// One copy. Kept as sRGB bytes: a quarter of the memory, decoded by a table of 256 numbers.
#[derive(Clone, Debug)]
struct Level {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Texture {
    /// A texture of sRGB pixels with alpha (which is not used), row by row from the top left.
    pub fn new(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Result<Self, RenderError> {
        if width == 0 || height == 0 || pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(RenderError::Texture { width, height, pixels: pixels.len() });
        }
        let mut last = Level { width, height, pixels };
        let mut levels = vec![];
        while last.width > 1 || last.height > 1 {
            let next = last.halved();
            levels.push(std::mem::replace(&mut last, next));
        }
        levels.push(last);
        Ok(Self { levels })
    }

    /// The number of pixels.
    pub(crate) fn texels(&self) -> f32 {
        self.levels.first().map_or(1.0, |l| l.width as f32 * l.height as f32)
    }

    /// Linear colour at `uv`, between the four nearest pixels of the copy in which `texels` pixels of the original are
    /// about one.
    pub(crate) fn sample(&self, uv: [f32; 2], texels: f32) -> [f32; 3] {
        // Half the binary logarithm, rounded: the exponent of 2 · texels, halved.
        let exponent = ((texels.max(1.0) * 2.0).to_bits() >> 23) as usize - 127;
        let Some(level) = self.levels.get((exponent / 2).min(self.levels.len() - 1)) else { return [1.0; 3] };
        level.sample(uv)
    }
}

impl Level {
    fn halved(&self) -> Self {
        let table = decode_table();
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 3];
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let texel =
                        self.texel((2 * x + dx).min(self.width - 1), (2 * y + dy).min(self.height - 1));
                    for (s, c) in sum.iter_mut().zip(texel) {
                        *s += table[c as usize] * 0.25;
                    }
                }
                let [r, g, b] = sum.map(crate::tone::encode);
                pixels.push([r, g, b, 255]);
            }
        }
        Self { width, height, pixels }
    }

    fn texel(&self, x: u32, y: u32) -> [u8; 3] {
        let index = y as usize * self.width as usize + x as usize;
        self.pixels.get(index).map_or([255; 3], |&[r, g, b, _]| [r, g, b])
    }

    fn sample(&self, uv: [f32; 2]) -> [f32; 3] {
        let table = decode_table();
        let (x0, x1, fx) = between(uv[0], self.width);
        let (y0, y1, fy) = between(uv[1], self.height);
        let mut sum = [0.0; 3];
        for (x, y, w) in [
            (x0, y0, (1.0 - fx) * (1.0 - fy)),
            (x1, y0, fx * (1.0 - fy)),
            (x0, y1, (1.0 - fx) * fy),
            (x1, y1, fx * fy),
        ] {
            for (s, c) in sum.iter_mut().zip(self.texel(x, y)) {
                *s += table[c as usize] * w;
            }
        }
        sum
    }
}

/// The two pixels beside coordinate `u` and how far it is from the first to the second.
fn between(u: f32, size: u32) -> (u32, u32, f32) {
    let at = (u - u.floor()) * size as f32 - 0.5;
    let first = at.floor();
    let wrap = |i: f32| (i as i64).rem_euclid(i64::from(size)) as u32;
    (wrap(first), wrap(first + 1.0), at - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(size: u32) -> Texture {
        let at = |i: u32| {
            if (i % size + i / size).is_multiple_of(2) { [255, 255, 255, 255] } else { [0, 0, 0, 255] }
        };
        Texture::new(size, size, (0..size * size).map(at).collect()).unwrap()
    }

    #[test]
    fn pixels_repeat_and_blend_halfway() {
        let texture = Texture::new(2, 1, vec![[255, 0, 0, 255], [0, 0, 255, 255]]).unwrap();
        for turn in [-3.0, 0.0, 5.0] {
            assert_eq!(texture.sample([0.25 + turn, 0.5], 1.0), [1.0, 0.0, 0.0]);
            assert_eq!(texture.sample([0.75 + turn, 0.5], 1.0), [0.0, 0.0, 1.0]);
            assert_eq!(texture.sample([0.5 + turn, 0.5], 1.0), [0.5, 0.0, 0.5]);
            assert_eq!(texture.sample([turn, 0.5], 1.0), [0.5, 0.0, 0.5]);
        }
    }

    #[test]
    fn small_copies_are_means_of_light_not_of_bytes() {
        let texture = checker(8);
        assert_eq!(texture.sample([1.0 / 16.0; 2], 1.0), [1.0; 3]);
        for texels in [4.0, 16.0, 64.0, 1e9] {
            let [r, ..] = texture.sample([0.3, 0.6], texels);
            assert!((r - 0.5).abs() < 0.005, "{r} at {texels}");
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(matches!(Texture::new(0, 0, vec![]), Err(RenderError::Texture { .. })));
        assert!(matches!(Texture::new(2, 2, vec![[0; 4]; 3]), Err(RenderError::Texture { pixels: 3, .. })));
    }
}
