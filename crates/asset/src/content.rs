//! Bytes of files in parts, each as its maker had it: what is large is not copied to be put behind something else.

use std::ops::{Deref, Range};

/// Bytes of a file, or numbers whose bytes they are.
#[derive(Clone, Debug)]
pub struct Content(Kind);

#[derive(Clone, Debug)]
enum Kind {
    /// All bytes from one on.
    Bytes(Vec<u8>, usize),
    /// Numbers whose bytes in memory are in the order of files.
    Floats(Vec<f32>),
}

impl Content {
    /// Numbers as files have them, the lowest byte first.
    pub(crate) fn floats(mut values: Vec<f32>) -> Self {
        if cfg!(target_endian = "big") {
            for value in &mut values {
                *value = f32::from_bits(value.to_bits().to_le());
            }
        }
        Self(Kind::Floats(values))
    }

    /// A range of `bytes`, where it is: to move it to the front of its memory would be to copy it.
    pub(crate) fn cut(mut bytes: Vec<u8>, range: Range<usize>) -> Self {
        bytes.truncate(range.end);
        let start = range.start.min(bytes.len());
        Self(Kind::Bytes(bytes, start))
    }

    fn truncate(&mut self, length: usize) {
        match &mut self.0 {
            Kind::Bytes(bytes, start) => bytes.truncate(start.saturating_add(length)),
            Kind::Floats(values) => values.truncate(length / size_of::<f32>()),
        }
    }
}

impl From<Vec<u8>> for Content {
    fn from(bytes: Vec<u8>) -> Self {
        Self(Kind::Bytes(bytes, 0))
    }
}

impl Deref for Content {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &self.0 {
            Kind::Bytes(bytes, start) => bytes.get(*start..).unwrap_or_default(),
            Kind::Floats(values) => bytemuck::must_cast_slice(values),
        }
    }
}

impl PartialEq for Content {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Eq for Content {}

/// Bytes that grow at their end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contents {
    parts: Vec<Content>,
    /// Where each part ends.
    ends: Vec<usize>,
}

impl Contents {
    pub(crate) fn len(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn push(&mut self, part: Content) {
        if !part.is_empty() {
            self.ends.push(self.len() + part.len());
            self.parts.push(part);
        }
    }

    pub(crate) fn append(&mut self, other: Self) {
        other.parts.into_iter().for_each(|part| self.push(part));
    }

    /// Adds zeros up to a multiple of 4, and gives the length.
    pub(crate) fn align(&mut self) -> usize {
        let missing = self.len().next_multiple_of(4) - self.len();
        self.push(vec![0; missing].into());
        self.len()
    }

    /// The bytes of a range that lies within one part, as each buffer view does.
    pub(crate) fn get(&self, range: Range<usize>) -> Option<&[u8]> {
        let part = self.ends.partition_point(|&end| end < range.end.max(range.start.saturating_add(1)));
        let Some(bytes) = self.parts.get(part) else {
            return (range.is_empty() && range.end <= self.len()).then_some(&[]);
        };
        let first = self.ends[part] - bytes.len();
        bytes.get(range.start.checked_sub(first)?..range.end.checked_sub(first)?)
    }

    /// Replaces bytes of the first part, where they lie in it and it is no numbers.
    pub(crate) fn overwrite(&mut self, offset: usize, by: &[u8]) {
        let Some(Content(Kind::Bytes(bytes, start))) = self.parts.first_mut() else { return };
        let place = bytes.get_mut(*start..).and_then(|bytes| bytes.get_mut(offset..)?.get_mut(..by.len()));
        if let Some(place) = place {
            place.copy_from_slice(by);
        }
    }

    pub(crate) fn truncate(&mut self, length: usize) {
        while self.len() > length {
            self.ends.pop();
            let Some(mut last) = self.parts.pop() else { return };
            last.truncate(length.saturating_sub(self.len()));
            self.push(last);
        }
    }

    pub(crate) fn into_parts(self) -> Vec<Content> {
        self.parts
    }
}

impl From<Content> for Contents {
    fn from(part: Content) -> Self {
        let mut out = Self::default();
        out.push(part);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> Contents {
        let mut out = Contents::from(Content::cut((0..9).collect(), 2..7));
        assert_eq!(out.align(), 8);
        out.push(Content::floats(vec![1.0, -2.5]));
        out
    }

    #[test]
    fn parts_are_the_bytes_they_would_be_in_one() {
        let out = three();
        let one = [&[2, 3, 4, 5, 6, 0, 0, 0][..], &1_f32.to_le_bytes(), &(-2.5_f32).to_le_bytes()].concat();
        assert_eq!(out.into_parts().iter().map(|part| &**part).collect::<Vec<_>>().concat(), one);
    }

    #[test]
    fn a_range_is_found_within_its_part_only() {
        let out = three();
        assert_eq!(out.get(0..5), Some(&[2, 3, 4, 5, 6][..]));
        assert_eq!(out.get(12..16), Some(&(-2.5_f32).to_le_bytes()[..]));
        assert_eq!((out.get(4..6), out.get(12..17), out.get(17..17)), (None, None, None));
        assert_eq!((out.get(5..5), out.get(16..16)), (Some(&[][..]), Some(&[][..])));
        assert_eq!(Contents::default().get(0..0), Some(&[][..]));
    }

    #[test]
    fn what_is_cut_off_is_gone() {
        for length in [16, 12, 8, 6, 3, 0] {
            let mut out = three();
            out.truncate(length);
            assert_eq!(out.len(), length);
        }
    }
}
