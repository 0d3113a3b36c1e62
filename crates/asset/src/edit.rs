//! Appending to a document: entries after entries, bytes after bytes. Nothing that is there moves.

use serde_json::{Map, Value, json};

use crate::attributes::bounds;
use crate::content::{Content, Contents};
use crate::document::{Buffer, Gltf, Source};
use crate::error::{AssetError, Place};

/// `bufferView.target` of vertex data.
pub(crate) const VERTICES: u32 = 34962;
/// `bufferView.target` of indices.
pub(crate) const INDICES: u32 = 34963;
/// Component types.
pub(crate) const FLOAT: u32 = 5126;

/// The value at `pointer` is no object or array where one is needed.
fn misshapen(pointer: impl Into<String>, expected: &str) -> AssetError {
    AssetError::new(Place::Pointer(pointer.into()), "a value of another kind", expected)
}

impl Gltf {
    /// The table `key`, made where it is missing.
    pub(crate) fn table_mut(&mut self, key: &str) -> Result<&mut Vec<Value>, AssetError> {
        let root = self.json.as_object_mut().ok_or_else(|| misshapen("", "an object"))?;
        let table = root.entry(key).or_insert_with(|| json!([]));
        table.as_array_mut().ok_or_else(|| misshapen(format!("/{key}"), "an array"))
    }

    /// The object `index` of the table `key`.
    pub(crate) fn entry_mut(
        &mut self,
        key: &str,
        index: usize,
    ) -> Result<&mut Map<String, Value>, AssetError> {
        let entry = self.table_mut(key)?.get_mut(index).and_then(Value::as_object_mut);
        entry.ok_or_else(|| misshapen(format!("/{key}/{index}"), "an object"))
    }

    /// Appends to the table `key` and gives the index.
    pub(crate) fn append(&mut self, key: &str, value: Value) -> Result<usize, AssetError> {
        let table = self.table_mut(key)?;
        table.push(value);
        Ok(table.len() - 1)
    }

    /// The primitives of a mesh.
    pub(crate) fn primitives_mut(&mut self, mesh: usize) -> Result<&mut Vec<Value>, AssetError> {
        let primitives = self.entry_mut("meshes", mesh)?.get_mut("primitives").and_then(Value::as_array_mut);
        primitives.ok_or_else(|| misshapen(format!("/meshes/{mesh}/primitives"), "an array"))
    }

    /// The buffer that takes new data: the BIN chunk, or one that is added.
    pub(crate) fn growing(&mut self) -> Result<usize, AssetError> {
        if let Some(index) = self.growing {
            return Ok(index);
        }
        let index = if self.buffers.first().is_some_and(|buffer| buffer.source == Source::Bin) {
            0
        } else {
            let (bytes, source) = match self.orphan.take() {
                Some(bytes) if self.buffers.is_empty() => (bytes, Source::Bin),
                orphan => {
                    self.orphan = orphan;
                    (
                        Contents::default(),
                        if self.binary && self.buffers.is_empty() { Source::Bin } else { Source::New },
                    )
                }
            };
            let length = bytes.len();
            self.buffers.push(Buffer { bytes, length, source });
            self.append("buffers", json!({ "byteLength": length }))?
        };
        self.growing = Some(index);
        Ok(index)
    }

    /// Appends bytes as a buffer view and gives its index.
    pub(crate) fn append_view(
        &mut self,
        content: impl Into<Content>,
        target: Option<u32>,
    ) -> Result<usize, AssetError> {
        let content = content.into();
        let length = content.len();
        let index = self.growing()?;
        let buffer = self.buffers.get_mut(index).ok_or_else(|| misshapen("/buffers", "a buffer"))?;
        let offset = buffer.bytes.align();
        buffer.bytes.push(content);
        buffer.length = buffer.bytes.len();
        let end = buffer.length;
        self.entry_mut("buffers", index)?.insert("byteLength".to_owned(), json!(end));
        let mut view = json!({ "buffer": index, "byteOffset": offset, "byteLength": length });
        if let (Some(target), Some(view)) = (target, view.as_object_mut()) {
            view.insert("target".to_owned(), json!(target));
        }
        self.append("bufferViews", view)
    }

    /// Appends vertex attributes of `N` floats as a dense accessor and gives its index.
    pub(crate) fn append_vertices<const N: usize>(
        &mut self,
        values: Vec<[f32; N]>,
        with_bounds: bool,
    ) -> Result<usize, AssetError> {
        let (count, bounds) = (values.len(), with_bounds.then(|| bounds(&values)));
        let view = self.append_view(Content::floats(values.into_flattened()), Some(VERTICES))?;
        let mut accessor = json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": format!("VEC{N}"),
        });
        set_bounds(&mut accessor, bounds);
        self.append("accessors", accessor)
    }

    /// Appends scalars for an animation and gives the accessor's index.
    pub(crate) fn append_scalars(
        &mut self,
        values: Vec<f32>,
        with_bounds: bool,
    ) -> Result<usize, AssetError> {
        let (count, bounds) = (values.len(), with_bounds.then(|| bounds(values.as_chunks::<1>().0)));
        let view = self.append_view(Content::floats(values), None)?;
        let mut accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": "SCALAR" });
        set_bounds(&mut accessor, bounds);
        self.append("accessors", accessor)
    }

    /// Appends vectors or matrices that are no vertex data, `kind` such as `VEC4`, and gives the accessor's index.
    pub(crate) fn append_tuples<const N: usize>(
        &mut self,
        values: Vec<[f32; N]>,
        kind: &str,
    ) -> Result<usize, AssetError> {
        let count = values.len();
        let view = self.append_view(Content::floats(values.into_flattened()), None)?;
        let accessor = json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind });
        self.append("accessors", accessor)
    }

    /// Appends indices of `count` vertices and gives the accessor's index.
    pub(crate) fn append_indices(&mut self, flat: &[u32], count: usize) -> Result<usize, AssetError> {
        // 65 535 is no index of 16 bits: it restarts primitives.
        let short = u16::try_from(count).is_ok();
        let mut bytes = crate::limits::reserve(flat.len() * if short { 2 } else { 4 })?;
        for &index in flat {
            bytes.extend_from_slice(&index.to_le_bytes()[..if short { 2 } else { 4 }]);
        }
        let view = self.append_view(bytes, Some(INDICES))?;
        let kind = if short { 5123 } else { 5125 };
        let accessor =
            json!({ "bufferView": view, "componentType": kind, "count": flat.len(), "type": "SCALAR" });
        self.append("accessors", accessor)
    }

    /// A copy of a mesh at the end of the table, for nodes that need it changed in another way.
    pub(crate) fn copy_mesh(&mut self, mesh: usize, nodes: &[usize]) -> Result<usize, AssetError> {
        let copy = Value::Object(self.entry_mut("meshes", mesh)?.clone());
        let index = self.append("meshes", copy)?;
        for &node in nodes {
            self.entry_mut("nodes", node)?.insert("mesh".to_owned(), json!(index));
        }
        Ok(index)
    }

    /// Finds meshes for nodes that need `mesh` changed, nodes that need the same change one together: the mesh itself for the first of
    /// them where all that show it are among the nodes, copies for all others.
    pub(crate) fn meshes_for<C: PartialEq>(
        &mut self,
        mesh: usize,
        changes: Vec<(usize, C)>,
    ) -> Result<Vec<(usize, C)>, AssetError> {
        let mut original_is_free = changes.len() == self.nodes_of(mesh).len();
        let mut groups: Vec<(C, Vec<usize>)> = Vec::new();
        for (node, change) in changes {
            match groups.iter_mut().find(|(known, _)| *known == change) {
                Some((_, list)) => list.push(node),
                None => groups.push((change, vec![node])),
            }
        }
        let mut out = Vec::with_capacity(groups.len());
        for (change, nodes) in groups {
            out.push((if original_is_free { mesh } else { self.copy_mesh(mesh, &nodes)? }, change));
            original_is_free = false;
        }
        Ok(out)
    }

    /// All nodes that show `mesh`, in any scene or none.
    pub(crate) fn nodes_of(&self, mesh: usize) -> Vec<usize> {
        let nodes = self.json.get("nodes").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let shows = |node: &Value| node.get("mesh").is_some_and(|value| whole(value) == Some(mesh));
        nodes.iter().enumerate().filter(|(_, node)| shows(node)).map(|(index, _)| index).collect()
    }
}

/// A whole number as [`Json::uint`](crate::json::Json::uint) reads it.
pub(crate) fn whole(value: &Value) -> Option<usize> {
    crate::json::Json::root(value).uint().ok()
}

/// Sets `min` and `max`, if there are any. An `f64` holds each `f32` exactly, and prints so that it is read back exactly.
pub(crate) fn set_bounds<const N: usize>(accessor: &mut Value, bounds: Option<([f32; N], [f32; N])>) {
    let numbers = |bound: [f32; N]| Value::Array(bound.iter().map(|&c| json!(f64::from(c))).collect());
    if let (Some(accessor), Some((min, max))) = (accessor.as_object_mut(), bounds) {
        accessor.insert("min".to_owned(), numbers(min));
        accessor.insert("max".to_owned(), numbers(max));
    }
}

/// Takes compressed copies of the geometry off a primitive: they would contradict what is changed.
pub(crate) fn drop_compressed(primitive: &mut Map<String, Value>) {
    if let Some(extensions) = primitive.get_mut("extensions").and_then(Value::as_object_mut) {
        extensions.shift_remove("KHR_draco_mesh_compression");
        if extensions.is_empty() {
            primitive.shift_remove("extensions");
        }
    }
}
