//! Bytes of files in parts, each as its maker had it: what is large is not copied to be put behind something else.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::Range;
use std::sync::Arc;

use crate::error::AssetError;
use crate::store::{Store, Stored};

/// Bytes of a file, or numbers whose bytes they are: in memory, or kept out of it in a file without a name.
#[derive(Clone, Debug)]
pub struct Content(Kind);

#[derive(Clone, Debug)]
enum Kind {
    /// All bytes from one on.
    Bytes(Vec<u8>, usize),
    /// Numbers whose bytes in memory are in the order of files.
    Floats(Vec<f32>),
    Stored(Stored),
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

    /// The same, out of memory.
    pub(crate) fn stored(self, store: &Arc<Store>) -> Result<Self, AssetError> {
        match self.held() {
            Ok(bytes) => store.add(bytes).map(|stored| Self(Kind::Stored(stored))),
            Err(_) => Ok(self),
        }
    }

    /// How many bytes it has.
    pub fn len(&self) -> usize {
        match self.held() {
            Ok(bytes) => bytes.len(),
            Err(stored) => stored.len(),
        }
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Its bytes. Those that were kept out of memory are in it from then on.
    ///
    /// # Errors
    ///
    /// Of class [`ErrorClass::Io`](crate::ErrorClass::Io): the file that keeps them cannot be read.
    pub fn bytes(&self) -> Result<&[u8], AssetError> {
        self.held().or_else(Stored::bytes)
    }

    /// Puts its bytes behind others.
    pub(crate) fn read_onto(&self, out: &mut Vec<u8>) -> Result<(), AssetError> {
        match self.held() {
            Ok(bytes) => out.extend_from_slice(bytes),
            Err(stored) => stored.read_onto(out)?,
        }
        Ok(())
    }

    /// Writes a range of its bytes to a file; out of another, where they are there.
    pub(crate) fn write(&self, range: Range<usize>, out: &mut BufWriter<&File>) -> io::Result<()> {
        match self.held() {
            Ok(bytes) => out.write_all(bytes.get(range).unwrap_or_default()),
            Err(stored) => {
                out.flush()?;
                stored.copy(range, out.get_mut())
            }
        }
    }

    /// Whether its bytes from `offset` on begin with these.
    fn holds(&self, offset: usize, bytes: &[u8]) -> Result<bool, AssetError> {
        match self.held() {
            Ok(own) => Ok(own.get(offset..).is_some_and(|own| own.starts_with(bytes))),
            Err(stored) => stored.holds(offset, bytes),
        }
    }

    /// Its bytes if they are in memory, else what knows where they are.
    fn held(&self) -> Result<&[u8], &Stored> {
        match &self.0 {
            Kind::Bytes(bytes, start) => Ok(bytes.get(*start..).unwrap_or_default()),
            Kind::Floats(values) => Ok(bytemuck::must_cast_slice(values)),
            Kind::Stored(stored) => Err(stored),
        }
    }

    fn truncate(&mut self, length: usize) {
        match &mut self.0 {
            Kind::Bytes(bytes, start) => bytes.truncate(start.saturating_add(length)),
            Kind::Floats(values) => values.truncate(length / size_of::<f32>()),
            Kind::Stored(stored) => stored.truncate(length),
        }
    }
}

impl From<Vec<u8>> for Content {
    fn from(bytes: Vec<u8>) -> Self {
        Self(Kind::Bytes(bytes, 0))
    }
}

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

    /// The bytes of a range that lies within one part, as each buffer view does; none of any other.
    pub(crate) fn get(&self, range: Range<usize>) -> Result<Option<&[u8]>, AssetError> {
        let Some((part, first)) = self.part(&range) else {
            return Ok((range.is_empty() && range.end <= self.len()).then_some(&[]));
        };
        let (Some(start), Some(end)) = (range.start.checked_sub(first), range.end.checked_sub(first)) else {
            return Ok(None);
        };
        Ok(part.bytes()?.get(start..end))
    }

    /// Whether that range has these bytes. What is kept out of memory stays there.
    pub(crate) fn holds(&self, range: &Range<usize>, bytes: &[u8]) -> Result<bool, AssetError> {
        if range.len() != bytes.len() {
            return Ok(false);
        }
        let Some((part, first)) = self.part(range) else { return Ok(bytes.is_empty()) };
        range.start.checked_sub(first).map_or(Ok(false), |start| part.holds(start, bytes))
    }

    /// The part in which a range ends, and where it begins.
    fn part(&self, range: &Range<usize>) -> Option<(&Content, usize)> {
        let index = self.ends.partition_point(|&end| end < range.end.max(range.start.saturating_add(1)));
        let part = self.parts.get(index)?;
        Some((part, self.ends.get(index)? - part.len()))
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
        let parts = out.into_parts();
        assert_eq!(parts.iter().map(|part| part.bytes().unwrap()).collect::<Vec<_>>().concat(), one);
    }

    #[test]
    fn a_range_is_found_within_its_part_only() {
        let out = three();
        let get = |range| out.get(range).unwrap();
        assert_eq!(get(0..5), Some(&[2, 3, 4, 5, 6][..]));
        assert_eq!(get(12..16), Some(&(-2.5_f32).to_le_bytes()[..]));
        assert_eq!((get(4..6), get(12..17), get(17..17)), (None, None, None));
        assert_eq!((get(5..5), get(16..16)), (Some(&[][..]), Some(&[][..])));
        assert_eq!(Contents::default().get(0..0).unwrap(), Some(&[][..]));
        let holds = |range, bytes: &[u8]| out.holds(&range, bytes).unwrap();
        assert!(holds(1..3, &[3, 4]) && holds(12..16, &(-2.5_f32).to_le_bytes()) && holds(0..0, &[]));
        assert!(
            !holds(1..3, &[3, 5])
                && !holds(1..3, &[3, 4, 5])
                && !holds(4..6, &[6, 0])
                && !holds(17..18, &[0])
        );
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
