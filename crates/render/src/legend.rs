//! What the colours of lines and dots mean.

use glam::{Vec2, Vec3};

use crate::compose::{inset, padding};
use crate::lines::{RIM_DENSITY, RIM_SHADE};
use crate::text::{Font, blend, plate};
use crate::{LineKind, Picture};

/// Sizes in parts of the height of a line of text: a stroke's length, its width, a disc's diameter, from either to its word,
/// from a word to the next stroke.
const LENGTH: f32 = 1.5;
const WIDTH: f32 = 0.19;
const DISC: f32 = 0.56;
const SPACE: f32 = 0.5;
const APART: f32 = 1.1;

/// Writes what the kinds of lines mean on a plate at the lower left: each kind once, in the order of [`LineKind`], with a
/// stroke or disc in its colour, in as many rows as it takes. Nothing for no kinds. A kind that the picture has no room for
/// is left out.
pub fn legend(picture: &mut Picture, kinds: &[LineKind]) {
    let mut kinds = kinds.to_vec();
    kinds.sort_unstable();
    kinds.dedup();
    let font = Font::fitting(picture.height);
    let room = picture.width.saturating_sub(2 * (inset(font) + padding(font)));
    let (entries, [width, rows]) = places(&kinds, font, room);
    let size = [width + 2 * padding(font), rows * pitch(font) + font.height / 4];
    if entries.is_empty() || size[1] + 2 * inset(font) > picture.height {
        return;
    }
    let left = i64::from(inset(font));
    let top = i64::from(picture.height) - i64::from(size[1]) - left;
    plate(picture, [left, top], size, font.height / 4);
    let unit = font.height as f32;
    for (kind, [x, row]) in entries {
        let x = left + i64::from(padding(font) + x);
        let y = top + i64::from(font.height / 8 + row * pitch(font));
        swatch(picture, kind, [x, y], unit);
        let word = x + ((LENGTH + SPACE) * unit) as i64;
        font.write(picture, kind.label(), [word, y]);
    }
}

/// From a row of the legend to the next, pixels.
fn pitch(font: Font) -> u32 {
    font.height + font.height / 8
}

/// Where each kind's stroke begins, from the left and in which row; the width and the number of rows of all.
fn places(kinds: &[LineKind], font: Font, room: u32) -> (Vec<(LineKind, [u32; 2])>, [u32; 2]) {
    let [stroke, apart] = [LENGTH + SPACE, APART].map(|s| (s * font.height as f32) as u32);
    let (mut entries, mut at, mut widest) = (vec![], [0, 0], 0);
    for &kind in kinds {
        let width = stroke + font.width(kind.label());
        if width > room {
            continue;
        }
        if at[0] + width > room {
            at = [0, at[1] + 1];
        }
        entries.push((kind, at));
        widest = widest.max(at[0] + width);
        at[0] += width + apart;
    }
    (entries, [widest, at[1] + 1])
}

/// A stroke or disc with the rim that lines have.
fn swatch(picture: &mut Picture, kind: LineKind, [left, top]: [i64; 2], unit: f32) {
    let length = LENGTH * unit;
    let (ends, radius) = if kind.is_dot() {
        ([length * 0.5; 2], DISC * unit * 0.5)
    } else {
        ([WIDTH * unit, length - WIDTH * unit], WIDTH * unit * 0.5)
    };
    let (rim, color) = (0.075 * unit, Vec3::from(kind.color()));
    for y in 0..unit as i64 {
        for x in 0..length as i64 {
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let distance = at.distance(Vec2::new(at.x.clamp(ends[0], ends[1]), unit * 0.53));
            let [core, whole] = [radius, radius + rim].map(|r| (r + 0.5 - distance).clamp(0.0, 1.0));
            if whole > 0.0 {
                blend(picture, [left + x, top + y], color * RIM_SHADE, (whole - core) * RIM_DENSITY);
                blend(picture, [left + x, top + y], color, core);
            }
        }
    }
}
