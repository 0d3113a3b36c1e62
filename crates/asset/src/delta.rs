//! Accessors of displacements: sparse where that is smaller, and each content written once.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use serde_json::json;

use crate::document::Gltf;
use crate::edit::{FLOAT, VERTICES, bytes_of, set_bounds};
use crate::error::AssetError;

/// About what a sparse accessor takes more JSON than a dense one.
const SPARSE_JSON: usize = 200;

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

/// Displacements as bytes.
struct Encoded {
    /// Bytes of an index and the indices, for a sparse accessor.
    indices: Option<(usize, Vec<u8>)>,
    values: Vec<u8>,
}

impl Gltf {
    /// The accessor of displacements, one `VEC3` a vertex; written unless an equal one has been written before.
    /// With `with_bounds` it has `min` and `max`, as positions need them.
    ///
    /// Without any displacement it is a sparse accessor with one explicit zero, which every reader understands; an
    /// accessor with neither data nor sparse elements, though valid, is refused by several.
    pub fn append_deltas(&mut self, deltas: &[[f32; 3]], with_bounds: bool) -> Result<usize, AssetError> {
        let encoded = encode(deltas)?;
        let index_bytes = encoded.indices.as_ref().map_or(&[][..], |(_, bytes)| bytes);
        let mut hasher = DefaultHasher::new();
        (deltas.len(), with_bounds, index_bytes, &encoded.values).hash(&mut hasher);
        let hash = hasher.finish();
        if let Some(accessor) = self.find(hash, deltas.len(), with_bounds, index_bytes, &encoded.values) {
            return Ok(accessor);
        }
        let mut accessor = json!({ "componentType": FLOAT, "count": deltas.len(), "type": "VEC3" });
        let (indices, values) = match &encoded.indices {
            None => {
                let view = self.append_view(&encoded.values, Some(VERTICES))?;
                accessor = json!({
                    "bufferView": view, "componentType": FLOAT, "count": deltas.len(), "type": "VEC3",
                });
                (0..0, self.last(encoded.values.len()))
            }
            Some((size, bytes)) => {
                let index_view = self.append_view(bytes, None)?;
                let indices = self.last(bytes.len());
                let value_view = self.append_view(&encoded.values, None)?;
                let kind = match size {
                    1 => 5121,
                    2 => 5123,
                    _ => 5125,
                };
                if let Some(accessor) = accessor.as_object_mut() {
                    let sparse = json!({
                        "count": encoded.values.len() / 12,
                        "indices": { "bufferView": index_view, "componentType": kind },
                        "values": { "bufferView": value_view },
                    });
                    accessor.insert("sparse".to_owned(), sparse);
                }
                (indices, self.last(encoded.values.len()))
            }
        };
        if with_bounds {
            set_bounds(&mut accessor, deltas.iter().map(<[f32; 3]>::as_slice));
        }
        let accessor = self.append("accessors", accessor)?;
        let entry = Entry { count: deltas.len(), with_bounds, indices, values, accessor };
        self.written.by_hash.entry(hash).or_default().push(entry);
        Ok(accessor)
    }

    /// The range of the last `length` bytes of the growing buffer.
    fn last(&self, length: usize) -> Range<usize> {
        let end = self.growing.and_then(|index| self.buffers.get(index)).map_or(0, |buffer| buffer.bytes.len());
        end.saturating_sub(length)..end
    }

    fn find(&self, hash: u64, count: usize, with_bounds: bool, indices: &[u8], values: &[u8]) -> Option<usize> {
        let bytes = &self.buffers.get(self.growing?)?.bytes;
        let same = |entry: &&Entry| {
            entry.count == count
                && entry.with_bounds == with_bounds
                && bytes.get(entry.indices.clone()) == Some(indices)
                && bytes.get(entry.values.clone()) == Some(values)
        };
        self.written.by_hash.get(&hash)?.iter().find(same).map(|entry| entry.accessor)
    }
}

fn encode(deltas: &[[f32; 3]]) -> Result<Encoded, AssetError> {
    let changed: Vec<usize> = (0..deltas.len()).filter(|&i| deltas[i] != [0.0; 3]).collect();
    let size = match changed.last().copied().unwrap_or(0) {
        0..=0xff => 1,
        0x100..=0xffff => 2,
        _ => 4,
    };
    if !changed.is_empty() && changed.len() * (12 + size) + SPARSE_JSON >= deltas.len() * 12 {
        return Ok(Encoded { indices: None, values: bytes_of(deltas.as_flattened())? });
    }
    let changed = if changed.is_empty() { vec![0] } else { changed };
    let indices = changed.iter().flat_map(|&i| (i as u32).to_le_bytes().into_iter().take(size)).collect();
    let values: Vec<f32> = changed.iter().filter_map(|&i| deltas.get(i)).flatten().copied().collect();
    Ok(Encoded { indices: Some((size, indices)), values: bytes_of(&values)? })
}
