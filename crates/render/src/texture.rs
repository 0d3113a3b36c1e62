//! A base colour picture and its smaller copies.

use crate::RenderError;
use crate::tone::decode_table;

/// What is beyond the edges of a picture on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The pixels at the edge.
    Clamp,
    /// The picture again, every other time mirrored.
    Mirror,
}

/// A picture on a surface, with a chain of halved copies made when it is loaded, so that
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
    /// A texture of sRGB pixels with alpha (used by [`Part::cutoff`](crate::Part::cutoff) only), row by row from the top
    /// left.
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

    /// Linear colour and alpha at `uv`, between the four nearest pixels of the copy in which `texels` pixels of the
    /// original are about one.
    pub(crate) fn sample(&self, uv: [f32; 2], texels: f32, wrap: [Wrap; 2]) -> [f32; 4] {
        // Half the binary logarithm, rounded: the exponent of 2 · texels, halved.
        let exponent = ((texels.max(1.0) * 2.0).to_bits() >> 23) as usize - 127;
        let Some(level) = self.levels.get((exponent / 2).min(self.levels.len() - 1)) else { return [1.0; 4] };
        level.sample(uv, wrap)
    }
}

impl Level {
    fn halved(&self) -> Self {
        let table = decode_table();
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 4];
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let [r, g, b, a] =
                        self.texel((2 * x + dx).min(self.width - 1), (2 * y + dy).min(self.height - 1));
                    let [r, g, b] = [r, g, b].map(|c| table[c as usize]);
                    for (s, c) in sum.iter_mut().zip([r, g, b, f32::from(a)]) {
                        *s += c * 0.25;
                    }
                }
                let [r, g, b, a] = sum;
                let [r, g, b] = [r, g, b].map(crate::tone::encode);
                pixels.push([r, g, b, a.round() as u8]);
            }
        }
        Self { width, height, pixels }
    }

    fn texel(&self, x: u32, y: u32) -> [u8; 4] {
        let index = y as usize * self.width as usize + x as usize;
        self.pixels.get(index).copied().unwrap_or([255; 4])
    }

    fn sample(&self, uv: [f32; 2], wrap: [Wrap; 2]) -> [f32; 4] {
        let table = decode_table();
        let (x0, x1, fx) = between(uv[0], self.width, wrap[0]);
        let (y0, y1, fy) = between(uv[1], self.height, wrap[1]);
        let mut sum = [0.0; 4];
        for (x, y, w) in [
            (x0, y0, (1.0 - fx) * (1.0 - fy)),
            (x1, y0, fx * (1.0 - fy)),
            (x0, y1, (1.0 - fx) * fy),
            (x1, y1, fx * fy),
        ] {
            let [r, g, b, a] = self.texel(x, y);
            let [r, g, b] = [r, g, b].map(|c| table[c as usize]);
            for (s, c) in sum.iter_mut().zip([r, g, b, f32::from(a) / 255.0]) {
                *s += c * w;
            }
        }
        sum
    }
}

/// The two pixels beside coordinate `u` and how far it is from the first to the second.
fn between(u: f32, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let u = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Clamp => u.clamp(0.0, 1.0),
        Wrap::Mirror => 1.0 - (u - 2.0 * (u * 0.5).floor() - 1.0).abs(),
    };
    let at = u * size as f32 - 0.5;
    let first = at.floor();
    let side = i64::from(size);
    let pixel = |i: f32| match wrap {
        Wrap::Repeat => (i as i64).rem_euclid(side) as u32,
        Wrap::Clamp | Wrap::Mirror => (i as i64).clamp(0, side - 1) as u32,
    };
    (pixel(first), pixel(first + 1.0), at - first)
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

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    #[test]
    fn pixels_repeat_and_blend_halfway() {
        let texture = Texture::new(2, 1, vec![[255, 0, 0, 255], [0, 0, 255, 51]]).unwrap();
        for turn in [-3.0, 0.0, 5.0] {
            let at = |u: f32| texture.sample([u + turn, 0.5], 1.0, REPEAT);
            assert_eq!(at(0.25), [1.0, 0.0, 0.0, 1.0]);
            assert_eq!(at(0.75), [0.0, 0.0, 1.0, 0.2]);
            assert_eq!(at(0.5), [0.5, 0.0, 0.5, 0.6]);
            assert_eq!(at(0.0), [0.5, 0.0, 0.5, 0.6]);
        }
    }

    #[test]
    fn beyond_the_edge_is_the_edge_or_the_mirror() {
        let texture = Texture::new(4, 1, [0, 1, 2, 3].map(|i| [255, 255, 255, i * 85]).to_vec()).unwrap();
        let alpha = |u: f32, wrap| texture.sample([u, 0.5], 1.0, [wrap, Wrap::Repeat])[3] * 3.0;
        for (u, repeat, clamp, mirror) in [
            (0.125, 0.0, 0.0, 0.0),
            (0.875, 3.0, 3.0, 3.0),
            (1.0, 1.5, 3.0, 3.0),
            (1.125, 0.0, 3.0, 3.0),
            (1.875, 3.0, 3.0, 0.0),
            (2.0, 1.5, 3.0, 0.0),
            (-0.125, 3.0, 0.0, 0.0),
            (-0.375, 2.0, 0.0, 1.0),
            (-1.125, 3.0, 0.0, 3.0),
            (1e20, 1.5, 3.0, 0.0),
        ] {
            for (wrap, expected) in [(Wrap::Repeat, repeat), (Wrap::Clamp, clamp), (Wrap::Mirror, mirror)] {
                assert!((alpha(u, wrap) - expected).abs() < 1e-5, "{wrap:?} {u}: {}", alpha(u, wrap));
            }
        }
    }

    #[test]
    fn small_copies_are_means_of_light_not_of_bytes() {
        let texture = checker(8);
        assert_eq!(texture.sample([1.0 / 16.0; 2], 1.0, REPEAT), [1.0; 4]);
        for texels in [4.0, 16.0, 64.0, 1e9] {
            let [r, ..] = texture.sample([0.3, 0.6], texels, REPEAT);
            assert!((r - 0.5).abs() < 0.005, "{r} at {texels}");
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(matches!(Texture::new(0, 0, vec![]), Err(RenderError::Texture { .. })));
        assert!(matches!(Texture::new(2, 2, vec![[0; 4]; 3]), Err(RenderError::Texture { pixels: 3, .. })));
    }
}
