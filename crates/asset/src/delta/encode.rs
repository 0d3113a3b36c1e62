//! What displacements are, looked at once, and the smaller of their two forms.

use rayon::prelude::*;

use crate::attributes::bounds;
use crate::content::Content;
use crate::error::AssetError;
use crate::limits::reserve;

/// About what a sparse accessor takes more JSON than a dense one.
const SPARSE_JSON: usize = 200;

/// So many displacements are looked at several times while they are near.
const BLOCK: usize = 1 << 10;

/// So many are one thread's at a time: enough that handing them out costs nothing.
const SHARE: usize = 16 * BLOCK;

/// Bits of a word.
const WORD: usize = 64;

/// Displacements as they are written.
pub(super) struct Encoded {
    /// Bytes of an index and the indices, for a sparse accessor.
    pub(super) indices: Option<(usize, Vec<u8>)>,
    pub(super) values: Content,
}

/// What has to be known of displacements before they are written.
pub(super) struct Survey {
    /// Which are not 0: bits from the lowest on, in words.
    moved: Vec<u64>,
    /// How many those are.
    changed: usize,
    /// Equal for equal content, the signs of zeros aside.
    pub(super) hash: u64,
    /// The least and the largest of each component, where they are asked for.
    pub(super) bounds: Option<Bounds>,
}

impl Survey {
    pub(super) fn of(deltas: &[[f32; 3]], with_bounds: bool) -> Self {
        let shares: Vec<Self> =
            deltas.par_chunks(SHARE).map(|share| Self::of_share(share, with_bounds)).collect();
        let moved = Vec::with_capacity(deltas.len().div_ceil(WORD));
        let mut out = Self { moved, changed: 0, hash: deltas.len() as u64, bounds: None };
        for share in &shares {
            out.moved.extend_from_slice(&share.moved);
            out.changed += share.changed;
            out.hash = step(out.hash.rotate_left(29), share.hash);
            out.bounds = joined(out.bounds, share.bounds);
        }
        out
    }

    fn of_share(deltas: &[[f32; 3]], with_bounds: bool) -> Self {
        let moved = Vec::with_capacity(deltas.len().div_ceil(WORD));
        let mut out = Self { moved, changed: 0, hash: 0, bounds: None };
        for block in deltas.chunks(BLOCK) {
            for group in block.chunks(WORD) {
                let bits = group.iter().enumerate();
                let word = bits.fold(0, |word, (i, delta)| word | u64::from(moves(delta)) << i);
                out.moved.push(word);
                out.changed += word.count_ones() as usize;
            }
            out.hash = mix(out.hash, block.as_flattened());
            out.bounds = joined(out.bounds, with_bounds.then(|| bounds(block)));
        }
        out
    }

    /// The last that is not 0; 0 if there is none.
    fn last(&self) -> usize {
        let word = self.moved.iter().rposition(|&word| word != 0);
        word.map_or(0, |k| k * WORD + self.moved[k].ilog2() as usize)
    }

    pub(super) fn encode(&self, deltas: Vec<[f32; 3]>) -> Result<Encoded, AssetError> {
        let size = match self.last() {
            0..=0xff => 1,
            0x100..=0xffff => 2,
            _ => 4,
        };
        if self.changed > 0 && self.changed * (12 + size) + SPARSE_JSON >= deltas.len() * 12 {
            return Ok(Encoded { indices: None, values: Content::floats(deltas.into_flattened()) });
        }
        let (indices, values) = if self.changed > 0 {
            self.gathered(deltas, size)?
        } else {
            // The first stands for all.
            let first = deltas.first().map(|delta| (vec![0; size], vec![*delta]));
            first.unwrap_or_default()
        };
        Ok(Encoded { indices: Some((size, indices)), values: Content::floats(values.into_flattened()) })
    }

    /// The bytes of the indices of displacements that are not 0, `size` each, and those: moved together in the memory they are in,
    /// for to be given new memory takes longer.
    fn gathered(
        &self,
        mut deltas: Vec<[f32; 3]>,
        size: usize,
    ) -> Result<(Vec<u8>, Vec<[f32; 3]>), AssetError> {
        let shares = deltas.par_chunks_mut(SHARE).zip(self.moved.par_chunks(SHARE / WORD)).enumerate();
        let shares = shares.map(|(k, (share, moved))| to_front(share, moved, (k * SHARE, size)));
        let shares: Vec<Vec<u8>> = shares.collect::<Result<_, _>>()?;
        let mut indices = reserve(self.changed * size)?;
        let mut end = 0;
        for (k, share) in shares.iter().enumerate() {
            let (start, count) = (k * SHARE, share.len() / size);
            deltas.copy_within(start..start + count, end);
            end += count;
            indices.extend_from_slice(share);
        }
        deltas.truncate(end);
        deltas.shrink_to_fit();
        Ok((indices, deltas))
    }
}

/// Moves displacements of a share that are not 0 to its front, and gives the bytes of their indices, which count from `first` and have
/// `size` bytes each.
fn to_front(
    share: &mut [[f32; 3]],
    moved: &[u64],
    (first, size): (usize, usize),
) -> Result<Vec<u8>, AssetError> {
    let mut indices = reserve(size * moved.iter().map(|word| word.count_ones() as usize).sum::<usize>())?;
    let mut count = 0;
    for (k, &word) in moved.iter().enumerate() {
        let mut left = word;
        while left != 0 {
            let i = k * WORD + left.trailing_zeros() as usize;
            left &= left - 1;
            share[count] = share[i];
            count += 1;
            // As one number where it is one, not byte after byte.
            match ((first + i) as u32).to_le_bytes() {
                bytes if size == 4 => indices.extend_from_slice(&bytes),
                bytes => indices.extend_from_slice(&bytes[..size]),
            }
        }
    }
    Ok(indices)
}

/// Whether a displacement is not 0, of whatever sign: asked of the bits of its numbers at once.
fn moves(delta: &[f32; 3]) -> bool {
    let [x, y, z] = delta.map(f32::to_bits);
    (x | y | z) << 1 != 0
}

/// The least and the largest of each component.
pub(super) type Bounds = ([f32; 3], [f32; 3]);

/// The bounds of two runs of vectors, of equal numbers that of the first.
fn joined(before: Option<Bounds>, after: Option<Bounds>) -> Option<Bounds> {
    let (Some((lowest, highest)), Some((low, high))) = (before, after) else { return before.or(after) };
    Some((
        std::array::from_fn(|k| if low[k] < lowest[k] { low[k] } else { lowest[k] }),
        std::array::from_fn(|k| if high[k] > highest[k] { high[k] } else { highest[k] }),
    ))
}

/// Goes on with a hash: in four strands, so that none waits for the other. It need not withstand anybody, for what
/// has the same hash is compared.
fn mix(hash: u64, values: &[f32]) -> u64 {
    /// So many numbers lose the signs of zeros at a time: compilers do that with vectors if nothing else is done meanwhile.
    const RUN: usize = 128;
    let mut strands = [hash, hash ^ 1, hash ^ 2, hash ^ 3];
    let (runs, rest) = values.as_chunks::<RUN>();
    for run in runs {
        let words = run.map(unsigned);
        for group in words.as_chunks::<8>().0 {
            for (strand, [low, high]) in strands.iter_mut().zip(group.as_chunks::<2>().0) {
                *strand = step(*strand, u64::from(*low) | u64::from(*high) << 32);
            }
        }
    }
    let last = rest.iter().fold(hash, |state, &value| step(state, u64::from(unsigned(value))));
    strands.iter().fold(last, |state, strand| step(state.rotate_left(29), *strand))
}

fn step(state: u64, word: u64) -> u64 {
    /// Odd, and its bits without a pattern: from the golden ratio.
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    (state ^ word).wrapping_mul(FACTOR)
}

/// The bits of a number, without its sign if it is a zero: adding 0 takes it off.
fn unsigned(value: f32) -> u32 {
    (value + 0.0).to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_make_what_one_pass_would() {
        for count in [SHARE - 1, SHARE, SHARE + 1, 3 * SHARE + WORD + 5] {
            let own =
                |i: usize| if i % 7 == 3 || i + 1 == count { [0.0, -0.0, i as f32 + 1.0] } else { [-0.0; 3] };
            let deltas: Vec<[f32; 3]> = (0..count).map(own).collect();
            let encoded = Survey::of(&deltas, true).encode(deltas.clone()).unwrap();
            let kept: Vec<usize> = (0..count).filter(|&i| deltas[i][2] > 0.0).collect();
            let (size, indices) = encoded.indices.unwrap();
            let bytes: Vec<u8> =
                kept.iter().flat_map(|&i| (i as u32).to_le_bytes()[..size].to_vec()).collect();
            let values: Vec<f32> = kept.iter().flat_map(|&i| deltas[i]).collect();
            assert!(size == if count > 1 << 16 { 4 } else { 2 } && indices == bytes);
            assert_eq!(encoded.values.bytes(), Content::floats(values).bytes());
        }
    }
}
