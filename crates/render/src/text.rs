//! Words on a picture: Noto Sans Mono, drawn beforehand in a few sizes, on a soft plate that makes any ground readable.
//!
//! # Notes
//!
//! A dark plate with light letters was tried: the legend's dark colours drown on it.

use glam::Vec3;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

use crate::Picture;
use crate::tone::{decode_table, encode};

/// Heights of lines that letters are drawn in, pixels; above the fourth they are enlarged ones.
const HEIGHTS: [u32; 9] = [16, 20, 24, 32, 48, 64, 96, 128, 256];
/// A line of text takes this much of a picture's height if it can: 16 pixels of 540.
const SHARE: f32 = 16.0 / 540.0;
/// Linear colours of the plate and of what is written on it, and how dense the plate is. Light, since the darkest and the
/// lightest colour of [`LineKind`](crate::LineKind) can both be told apart on it (the latter by its rim).
const PLATE: Vec3 = Vec3::new(0.80, 0.81, 0.83);
const INK: Vec3 = Vec3::new(0.012, 0.013, 0.016);
const DENSITY: f32 = 0.70;

/// Letters of one size.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Font {
    /// The height of a line, pixels.
    pub(crate) height: u32,
    raster: RasterHeight,
    /// How much the drawn letters are enlarged.
    scale: u32,
}

impl Font {
    /// The size that goes with a picture of `rows` rows: the nearest below what is wanted, at least the smallest.
    pub(crate) fn fitting(rows: u32) -> Self {
        let wanted = rows as f32 * SHARE * 1.01;
        let height = HEIGHTS.iter().rev().copied().find(|&h| h as f32 <= wanted).unwrap_or(HEIGHTS[0]);
        Self::of(height)
    }

    fn of(height: u32) -> Self {
        let (raster, drawn) = match height {
            ..20 => (RasterHeight::Size16, 16),
            20..24 => (RasterHeight::Size20, 20),
            24 | 48 | 96 => (RasterHeight::Size24, 24),
            _ => (RasterHeight::Size32, 32),
        };
        Self { height, raster, scale: height / drawn }
    }

    /// The next smaller size, if there is one.
    pub(crate) fn smaller(self) -> Option<Self> {
        HEIGHTS.iter().rev().copied().find(|&h| h < self.height).map(Self::of)
    }

    /// The width of every letter, pixels.
    pub(crate) fn advance(self) -> u32 {
        get_raster_width(FontWeight::Regular, self.raster) as u32 * self.scale
    }

    /// The width of a text, pixels.
    pub(crate) fn width(self, text: &str) -> u32 {
        self.advance().saturating_mul(u32::try_from(text.chars().count()).unwrap_or(u32::MAX))
    }

    /// Writes one line with its upper left corner at `at`. What the font has no letter for becomes a question mark; what
    /// lies outside the picture is left out.
    pub(crate) fn write(self, picture: &mut Picture, text: &str, [mut left, top]: [i64; 2]) {
        let raster = |letter| get_raster(letter, FontWeight::Regular, self.raster);
        for glyph in text.chars().filter_map(|letter| raster(letter).or_else(|| raster('?'))) {
            for y in 0..self.height {
                for x in 0..self.advance() {
                    // Dark letters look thin where they are mixed as light is: coverage counts for more.
                    let share = sample(&glyph, [x, y], self.scale);
                    let share = share * (1.5 - 0.5 * share);
                    if share > 0.0 {
                        blend(picture, [left + i64::from(x), top + i64::from(y)], INK, share);
                    }
                }
            }
            left += i64::from(self.advance());
        }
    }
}

/// How much of a pixel a letter covers, between the four nearest of the drawn ones where it is enlarged.
fn sample(glyph: &RasterizedChar, at: [u32; 2], scale: u32) -> f32 {
    let drawn = |x: i64, y: i64| match (usize::try_from(x), usize::try_from(y)) {
        (Ok(x), Ok(y)) => f32::from(glyph.pixel(x, y).unwrap_or(0)) / 255.0,
        _ => 0.0,
    };
    if scale == 1 {
        return drawn(at[0].into(), at[1].into());
    }
    let [(x, fx), (y, fy)] = at.map(|i| {
        let place = (i as f32 + 0.5) / scale as f32 - 0.5;
        (place.floor() as i64, place - place.floor())
    });
    let [above, below] = [y, y + 1].map(|y| drawn(x, y) * (1.0 - fx) + drawn(x + 1, y) * fx);
    above * (1.0 - fy) + below * fy
}

/// Mixes a linear colour into a pixel, if the picture has it.
pub(crate) fn blend(picture: &mut Picture, [x, y]: [i64; 2], color: Vec3, share: f32) {
    if x < 0 || y < 0 || x >= i64::from(picture.width) {
        return;
    }
    let index = y as u64 * u64::from(picture.width) + x as u64;
    let Some(pixel) = usize::try_from(index).ok().and_then(|i| picture.pixels.get_mut(i)) else { return };
    let table = decode_table();
    let [r, g, b, alpha] = *pixel;
    let mixed = Vec3::from([r, g, b].map(|c| table[c as usize])).lerp(color, share);
    *pixel = [encode(mixed.x), encode(mixed.y), encode(mixed.z), alpha];
}

/// A light plate with round, soft corners under what is to be written on it.
pub(crate) fn plate(picture: &mut Picture, [left, top]: [i64; 2], [width, height]: [u32; 2], radius: u32) {
    let half = [width, height].map(|side| side as f32 * 0.5);
    let radius = (radius as f32).min(half[0]).min(half[1]);
    for y in 0..height {
        for x in 0..width {
            let [dx, dy] = [(x, half[0]), (y, half[1])]
                .map(|(i, half)| ((i as f32 + 0.5 - half).abs() - half + radius).max(0.0));
            let inside = (radius - (dx * dx + dy * dy).sqrt() + 0.5).clamp(0.0, 1.0);
            blend(picture, [left + i64::from(x), top + i64::from(y)], PLATE, inside * DENSITY);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank(width: u32, height: u32) -> Picture {
        Picture { width, height, pixels: vec![[128, 128, 128, 255]; (width * height) as usize] }
    }

    #[test]
    fn letters_grow_with_the_picture() {
        for (rows, height) in [(1, 16), (90, 16), (540, 16), (720, 20), (1080, 32), (2160, 64), (16_384, 256)]
        {
            assert_eq!(Font::fitting(rows).height, height, "{rows}");
        }
        for height in HEIGHTS {
            let font = Font::of(height);
            assert_eq!(font.height, height);
            assert_eq!(font.scale * font.raster.val() as u32, height);
        }
        assert_eq!(Font::of(24).smaller(), Some(Font::of(20)));
        assert_eq!(Font::of(16).smaller(), None);
    }

    #[test]
    fn text_stays_in_its_lines_and_in_the_picture() {
        for height in [16, 24, 32, 64] {
            let font = Font::of(height);
            let mut picture = blank(300, 100);
            font.write(&mut picture, "gÄ|", [10, 20]);
            let touched = |p: &&(usize, &[u8; 4])| p.1[0] != 128;
            let all: Vec<(usize, &[u8; 4])> = picture.pixels.iter().enumerate().collect();
            let mut count = 0;
            for (i, _) in all.iter().filter(touched) {
                let (x, y) = ((i % 300) as u32, (i / 300) as u32);
                assert!((10..10 + font.width("gÄ|")).contains(&x) && (20..20 + height).contains(&y));
                count += 1;
            }
            assert!(count > 40);
        }
        let mut picture = blank(30, 10);
        Font::of(64).write(&mut picture, "WWWW", [-40, -30]);
        plate(&mut picture, [-5, -5], [1000, 1000], 7);
    }

    #[test]
    fn letters_it_has_not_are_question_marks() {
        let written = |text: &str| {
            let mut picture = blank(40, 20);
            Font::of(16).write(&mut picture, text, [2, 2]);
            picture
        };
        assert_eq!(written("a漢\n"), written("a??"));
        assert_ne!(written("aé"), written("a?"));
    }
}
