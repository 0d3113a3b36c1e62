//! Pictures side by side, and what is written on them.

use crate::text::{Font, plate};
use crate::{MAX_SIDE, Picture, RenderError};

/// Between and beside pictures of a row: dark, so that their backgrounds look lit.
const GAP: [u8; 4] = [24, 25, 28, 255];
/// What stands for the end of a text that is too long.
const CUT: &str = "..";

/// A place for a caption.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Corner {
    /// Above, on the left.
    #[default]
    TopLeft,
    /// Above, on the right.
    TopRight,
    /// Below, on the left, where [`legend`](crate::legend) goes too.
    BottomLeft,
    /// Below, on the right.
    BottomRight,
}

/// Pictures side by side from left to right with `gap` dark pixels between them, none round them. Lower ones than the
/// highest stand in the middle of the height.
///
/// # Errors
///
/// [`RenderError::Size`] for no pictures, or if the row would be longer than [`MAX_SIDE`].
pub fn row(pictures: &[Picture], gap: u32) -> Result<Picture, RenderError> {
    let gaps = u64::from(gap) * pictures.len().saturating_sub(1) as u64;
    let wide = pictures.iter().map(|p| u64::from(p.width)).sum::<u64>().saturating_add(gaps);
    let width = u32::try_from(wide).unwrap_or(u32::MAX);
    let height = pictures.iter().map(|p| p.height).max().unwrap_or(0);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(RenderError::Size { width, height });
    }
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for (i, picture) in pictures.iter().enumerate() {
            if i > 0 {
                pixels.resize(pixels.len() + gap as usize, GAP);
            }
            let columns = picture.width as usize;
            let line = y.checked_sub((height - picture.height) / 2).map(|y| y as usize * columns);
            let line = line.and_then(|start| picture.pixels.get(start..start + columns));
            match line {
                Some(line) => pixels.extend_from_slice(line),
                None => pixels.resize(pixels.len() + columns, GAP),
            }
        }
    }
    Ok(Picture { width, height, pixels })
}

/// Writes one line on a plate in a corner. Its size goes with the picture's height, 16 pixels at 540 rows or fewer, and is
/// smaller where the line would not fit; what does not fit at 16 pixels is cut, and shown by two dots. An empty text, and a
/// picture too small for two letters, are left as they are. Letters outside of Latin-1 become question marks.
pub fn caption(picture: &mut Picture, text: &str, corner: Corner) {
    let mut font = Font::fitting(picture.height);
    let free = |font: Font| picture.width.saturating_sub(2 * (inset(font) + padding(font)));
    while font.width(text) > free(font) {
        match font.smaller() {
            Some(smaller) => font = smaller,
            None => break,
        }
    }
    let letters = (free(font) / font.advance()) as usize;
    if text.is_empty() || letters < 2 || font.height + 2 * inset(font) > picture.height {
        return;
    }
    let text = if text.chars().count() > letters {
        text.chars().take(letters - CUT.len()).chain(CUT.chars()).collect()
    } else {
        text.to_owned()
    };
    let size = [font.width(&text) + 2 * padding(font), font.height + font.height / 4];
    let far = |side: u32, length: u32| i64::from(side) - i64::from(length) - i64::from(inset(font));
    let near = i64::from(inset(font));
    let (right, bottom) = (far(picture.width, size[0]), far(picture.height, size[1]));
    let at = match corner {
        Corner::TopLeft => [near, near],
        Corner::TopRight => [right, near],
        Corner::BottomLeft => [near, bottom],
        Corner::BottomRight => [right, bottom],
    };
    plate(picture, at, size, font.height / 4);
    font.write(picture, &text, [at[0] + i64::from(padding(font)), at[1] + i64::from(font.height / 8)]);
}

/// From the picture's edge to a plate, pixels.
pub(crate) fn inset(font: Font) -> u32 {
    font.height / 2
}

/// From a plate's edge to the words on it, pixels.
pub(crate) fn padding(font: Font) -> u32 {
    font.height * 7 / 16
}
