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
        let end =
            self.growing.and_then(|index| self.buffers.get(index)).map_or(0, |buffer| buffer.bytes.len());
        end.saturating_sub(length)..end
    }

    fn find(
        &self,
        hash: u64,
        count: usize,
        with_bounds: bool,
        indices: &[u8],
        values: &[u8],
    ) -> Option<usize> {
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
        let index = gltf.append_deltas(deltas, true).unwrap();
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
    fn equal_content_is_written_once() {
        let mut gltf = document();
        let (first, _) = back(&mut gltf, &[[1.0; 3]; 4]);
        let (other, _) = back(&mut gltf, &[[2.0; 3]; 4]);
        let length = gltf.to_glb().unwrap().len();
        assert_eq!((back(&mut gltf, &[[1.0; 3]; 4]).0, back(&mut gltf, &[[2.0; 3]; 4]).0), (first, other));
        assert_eq!(gltf.to_glb().unwrap().len(), length);
        assert_ne!(gltf.append_deltas(&[[1.0; 3]; 4], false).unwrap(), first, "without bounds it is another");
    }
}
