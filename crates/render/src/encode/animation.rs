//! Frames one after the other.

use super::apng::Apng;
use super::gif::Gif;
use super::{EncodeError, check, check_size};
use crate::Picture;

/// A file format of moving pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AnimationKind {
    /// 255 colours for all frames together, mixed in a pattern that stays where it is. Plays everywhere.
    Gif,
    /// All colours as they are. Plays in browsers; elsewhere its first frame is seen.
    Apng,
}

/// A file of moving pictures in the making, which repeats for ever. Frames are kept compressed.
///
/// ```
/// use wirework_render::{Animation, AnimationKind, Picture};
///
/// let mut animation = Animation::new(AnimationKind::Gif, [8, 8], 24.0)?;
/// for light in [40, 200] {
///     animation.push(&Picture { width: 8, height: 8, pixels: vec![[light, light, light, 255]; 64] })?;
/// }
/// assert!(animation.finish()?.starts_with(b"GIF89a"));
/// # Ok::<(), wirework_render::EncodeError>(())
/// ```
pub struct Animation {
    size: [u32; 2],
    fps: f64,
    frames: Frames,
}

enum Frames {
    Gif(Box<Gif>),
    Apng(Apng),
}

impl Animation {
    /// The least and the most frames a second.
    pub const FPS: [f64; 2] = [0.01, 1000.0];

    /// An animation without frames yet: of `size` pixels across and down, each frame shown for 1/`fps` seconds.
    ///
    /// A GIF counts in hundredths of a second: its frames take turns so that the whole is as long as it should be, and above
    /// 50 frames a second, which players do not keep up with, some are left out.
    ///
    /// # Errors
    ///
    /// [`EncodeError::Size`] and [`EncodeError::Fps`].
    pub fn new(kind: AnimationKind, size: [u32; 2], fps: f64) -> Result<Self, EncodeError> {
        check_size(size)?;
        let [least, most] = Self::FPS;
        if !(least..=most).contains(&fps) {
            return Err(EncodeError::Fps { fps });
        }
        let frames = match kind {
            AnimationKind::Gif => Frames::Gif(Box::new(Gif::new(size))),
            AnimationKind::Apng => Frames::Apng(Apng::new(size)),
        };
        Ok(Self { size, fps, frames })
    }

    /// Adds a frame.
    ///
    /// # Errors
    ///
    /// [`EncodeError::OtherSize`] and [`EncodeError::Pixels`]; the animation stays as it was.
    pub fn push(&mut self, picture: &Picture) -> Result<(), EncodeError> {
        check(picture)?;
        let (width, height) = (picture.width, picture.height);
        if [width, height] != self.size {
            return Err(EncodeError::OtherSize { width, height });
        }
        match &mut self.frames {
            Frames::Gif(gif) => gif.push(&picture.pixels),
            Frames::Apng(apng) => apng.push(&picture.pixels),
        }
    }

    /// The file. The same frames give the same bytes, whatever the number of threads.
    ///
    /// # Errors
    ///
    /// [`EncodeError::Empty`].
    pub fn finish(self) -> Result<Vec<u8>, EncodeError> {
        match self.frames {
            Frames::Gif(gif) => gif.finish(self.fps),
            Frames::Apng(apng) => apng.finish(self.fps),
        }
    }
}

/// Columns and rows, from the first to the last.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Area {
    pub(super) left: usize,
    pub(super) top: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Area {
    /// The smallest in which all pixels lie that differ; one pixel if none does.
    pub(super) fn changed<T: PartialEq>(before: &[T], after: &[T], columns: usize) -> Self {
        let (mut x, mut y) = ([usize::MAX, 0], [usize::MAX, 0]);
        for (row, (a, b)) in before.chunks(columns).zip(after.chunks(columns)).enumerate() {
            let differ = |(a, b): (&T, &T)| a != b;
            let Some(first) = a.iter().zip(b).position(differ) else { continue };
            let last = a.iter().zip(b).rposition(differ).unwrap_or(first);
            x = [x[0].min(first), x[1].max(last)];
            y = [y[0].min(row), row];
        }
        if y[0] > y[1] {
            return Self { left: 0, top: 0, width: 1, height: 1 };
        }
        Self { left: x[0], top: y[0], width: x[1] - x[0] + 1, height: y[1] - y[0] + 1 }
    }

    /// What lies in it of a list of rows.
    pub(super) fn cut<T: Copy>(self, pixels: &[T], columns: usize) -> Vec<T> {
        let rows = pixels.chunks(columns).skip(self.top).take(self.height);
        rows.flat_map(|row| row.iter().skip(self.left).take(self.width).copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_hold_what_differs_and_no_more() {
        let before = vec![0; 5 * 4];
        let mut after = before.clone();
        let one = Area { left: 0, top: 0, width: 1, height: 1 };
        assert_eq!(Area::changed(&before, &after, 5), one);
        (after[5 + 3], after[10 + 1], after[10 + 2]) = (1, 2, 3);
        let area = Area::changed(&before, &after, 5);
        assert_eq!(area, Area { left: 1, top: 1, width: 3, height: 2 });
        assert_eq!(area.cut(&after, 5), [0, 0, 1, 2, 3, 0]);
        after[19] = 1;
        assert_eq!(Area::changed(&before, &after, 5), Area { left: 1, top: 1, width: 4, height: 3 });
    }
}
