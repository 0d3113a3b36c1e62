//! Accessors of displacements: sparse where that is smaller, and each content written once.

mod encode;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use serde_json::json;

use crate::document::Gltf;
use crate::edit::{FLOAT, VERTICES, set_bounds};
use crate::error::AssetError;
use crate::store::Spill;

use encode::{Encoded, Survey};

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
