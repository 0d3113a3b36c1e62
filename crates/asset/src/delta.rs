//! Accessors of displacements: sparse where that is smaller, and each content written once.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;
use serde_json::json;

use crate::attributes::bounds;
use crate::content::Content;
use crate::document::Gltf;
use crate::edit::{FLOAT, VERTICES, set_bounds};
use crate::error::AssetError;
use crate::limits::reserve;
use crate::store::Spill;

/// About what a sparse accessor takes more JSON than a dense one.
const SPARSE_JSON: usize = 200;

/// So many displacements are looked at several times while they are near.
const BLOCK: usize = 1 << 10;

/// So many are one thread's at a time: enough that handing them out costs nothing.
const SHARE: usize = 16 * BLOCK;

/// Bits of a word.
const WORD: usize = 64;

/// What has been written so far, by a hash of its content.
#[derive(Clone, Debug, Default)]
pub(crate) struct Written {
    by_hash: BTreeMap<u64, Vec<Entry>>,
}

#[derive(Clone, Debug)]
struct Entry {
    count: usize,
    with_bounds: bool,
    /// Bytes of the growing buffer; empty for a dense accessor.
    indices: Range<usize>,
    values: Range<usize>,
    accessor: usize,
}

/// Displacements as they are written.
struct Encoded {
    /// Bytes of an index and the indices, for a sparse accessor.
    indices: Option<(usize, Vec<u8>)>,
    values: Content,
}

impl Gltf {
    /// The accessor of displacements, one `VEC3` a vertex; written unless an equal one has been written before.
    /// With `with_bounds` it has `min` and `max`, as positions need them. They are kept as they are until the document is written.
    ///
    /// Without any displacement it is a sparse accessor with one explicit zero, which every reader understands; an
    /// accessor with neither data nor sparse elements, though valid, is refused by several.
    ///
    /// # Errors
    ///
    /// Of class [`ErrorClass::Limit`](crate::ErrorClass::Limit): they do not fit into memory. Of class
    /// [`ErrorClass::Io`](crate::ErrorClass::Io): the file that takes what is not held there, of which [`Gltf::spill_beyond`] tells,
    /// cannot be made, written or read. Misshapen tables of the document.
    pub fn append_deltas(&mut self, deltas: Vec<[f32; 3]>, with_bounds: bool) -> Result<usize, AssetError> {
        let (count, survey) = (deltas.len(), Survey::of(&deltas, with_bounds));
        let encoded = survey.encode(deltas)?;
        if let Some(accessor) = self.find(survey.hash, count, with_bounds, &encoded)? {
            return Ok(accessor);
        }
        let Encoded { indices, values } = encoded;
        let indices = indices.map(|(size, bytes)| Ok((size, self.spill.keep(bytes.into())?))).transpose()?;
        let values = self.spill.keep(values)?;
        let length = values.len();
        let mut accessor = json!({});
        let mut index_range = 0..0;
        if let Some((size, bytes)) = indices {
            let (indices, of_indices) = (bytes.len() / size, bytes.len());
            let index_view = self.append_view(bytes, None)?;
            index_range = self.last(of_indices);
            let value_view = self.append_view(values, None)?;
            let kind = match size {
                1 => 5121,
                2 => 5123,
                _ => 5125,
            };
            accessor = json!({ "componentType": FLOAT, "count": count, "type": "VEC3", "sparse": {
                "count": indices,
                "indices": { "bufferView": index_view, "componentType": kind },
                "values": { "bufferView": value_view },
            } });
        } else {
            let view = self.append_view(values, Some(VERTICES))?;
            accessor = json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": "VEC3" });
        }
        set_bounds(&mut accessor, survey.bounds);
        let accessor = self.append("accessors", accessor)?;
        let entry = Entry { count, with_bounds, indices: index_range, values: self.last(length), accessor };
        self.written.by_hash.entry(survey.hash).or_default().push(entry);
        Ok(accessor)
    }

    /// Says how many `bytes` of displacements are held in memory until the document is written, by default [`HELD_BYTES`]: all of them
    /// up to that many, and what comes then goes to a file without a name, from which it is copied when the document is
    /// written. What is written does not depend on it. Copies of the document share the file, and it goes with the last of them or
    /// with the process, however that ends.
    ///
    /// The file is in `folder`, or where that takes none, or none is said, in the system's folder for temporary files, which may be
    /// small or in memory itself. The folder of the output is better: there must be room for the whole file in it anyway, and copying
    /// within one file system is cheap; so long as both are there they take twice that room.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), wirework_asset::AssetError> {
    /// # use wirework_asset::{Gltf, HELD_BYTES, Limits};
    /// # use std::path::Path;
    /// let mut gltf = Gltf::read(Path::new("in.glb"), &Limits::default())?;
    /// gltf.spill_beyond(HELD_BYTES / 2, Some(Path::new("out")));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// [`HELD_BYTES`]: crate::HELD_BYTES
    pub fn spill_beyond(&mut self, bytes: usize, folder: Option<&Path>) {
        self.spill = Spill::new(bytes, folder);
    }

    /// The range of the last `length` bytes of the growing buffer.
    fn last(&self, length: usize) -> Range<usize> {
        let end =
            self.growing.and_then(|index| self.buffers.get(index)).map_or(0, |buffer| buffer.bytes.len());
        end.saturating_sub(length)..end
    }

    fn find(
        &self,
        hash: u64,
        count: usize,
        with_bounds: bool,
        encoded: &Encoded,
    ) -> Result<Option<usize>, AssetError> {
        let Some(buffer) = self.growing.and_then(|index| self.buffers.get(index)) else { return Ok(None) };
        let indices = encoded.indices.as_ref().map_or(&[][..], |(_, bytes)| bytes);
        let values = encoded.values.bytes()?;
        let known = self.written.by_hash.get(&hash).map_or(&[][..], Vec::as_slice);
        for entry in known.iter().filter(|entry| entry.count == count && entry.with_bounds == with_bounds) {
            if buffer.bytes.holds(&entry.indices, indices)? && buffer.bytes.holds(&entry.values, values)? {
                return Ok(Some(entry.accessor));
            }
        }
        Ok(None)
    }
}

/// What has to be known of displacements before they are written.
struct Survey {
    /// Which are not 0: bits from the lowest on, in words.
    moved: Vec<u64>,
    /// How many those are.
    changed: usize,
    /// Equal for equal content, the signs of zeros aside.
    hash: u64,
    /// The least and the largest of each component, where they are asked for.
    bounds: Option<Bounds>,
}

impl Survey {
    fn of(deltas: &[[f32; 3]], with_bounds: bool) -> Self {
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

    fn encode(&self, deltas: Vec<[f32; 3]>) -> Result<Encoded, AssetError> {
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
type Bounds = ([f32; 3], [f32; 3]);

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
    use crate::{Limits, NewMesh};

    fn document() -> Gltf {
        let mesh = NewMesh { name: "p", positions: &[[0.0; 3]], normals: None, uvs: None, triangles: &[] };
        let glb = Gltf::from_meshes("made", &[mesh]).unwrap().to_glb().unwrap();
        Gltf::from_slice(&glb, "made", &Limits::default()).unwrap()
    }

    /// Writes deltas and reads them back.
    fn back(gltf: &mut Gltf, deltas: &[[f32; 3]]) -> (usize, serde_json::Value) {
        let index = gltf.append_deltas(deltas.to_vec(), true).unwrap();
        let reference = json!(index);
        let accessor = gltf.accessor(crate::json::Json::root(&reference)).unwrap();
        let mut budget = crate::limits::Budget::new(&Limits::default());
        assert_eq!(accessor.floats::<3>(&mut budget).unwrap(), deltas);
        (index, accessor.json.value().clone())
    }

    #[test]
    fn sparse_where_smaller_and_dense_elsewhere() {
        let mut gltf = document();
        for count in [1, 255, 256, 257, 65_536, 65_537, 70_000] {
            let mut deltas = vec![[0.0; 3]; count];
            let (_, zero) = back(&mut gltf, &deltas);
            assert_eq!(zero["sparse"]["count"], 1, "all zeros");
            assert_eq!((&zero["min"], &zero["max"]), (&json!([0.0, 0.0, 0.0]), &json!([0.0, 0.0, 0.0])));
            deltas[count - 1] = [0.1, -2.0, 0.0];
            let (_, one) = back(&mut gltf, &deltas);
            assert_eq!(one.get("sparse").is_some(), count > 20, "{count}");
            if count > 20 {
                let kind = if count <= 256 {
                    5121
                } else if count <= 65_536 {
                    5123
                } else {
                    5125
                };
                assert_eq!(one["sparse"]["indices"]["componentType"], kind);
                let bounds = json!([[0.0, -2.0, 0.0], [f64::from(0.1_f32), 0.0, 0.0]]);
                assert_eq!(json!([one["min"], one["max"]]), bounds);
            }
            let (_, all) = back(&mut gltf, &vec![[1.0; 3]; count]);
            assert!(all.get("sparse").is_none());
        }
    }

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

    #[test]
    fn equal_content_is_written_once() {
        let mut gltf = document();
        let (first, _) = back(&mut gltf, &[[1.0; 3]; 4]);
        let (other, _) = back(&mut gltf, &[[2.0; 3]; 4]);
        let length = gltf.to_glb().unwrap().len();
        assert_eq!((back(&mut gltf, &[[1.0; 3]; 4]).0, back(&mut gltf, &[[2.0; 3]; 4]).0), (first, other));
        assert_eq!(gltf.to_glb().unwrap().len(), length);
        assert_ne!(
            gltf.append_deltas(vec![[1.0; 3]; 4], false).unwrap(),
            first,
            "without bounds it is another"
        );
    }
}
