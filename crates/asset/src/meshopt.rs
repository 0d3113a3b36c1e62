//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views whose bytes are there in compressed form.
//!
//! Such a view lies in a buffer without data of its own, marked `fallback`. What it decodes to is put there in memory, so that
//! whoever reads accessors need not know; nothing of it is written. A view of a buffer that does have its data is read from that.

use std::collections::BTreeMap;

use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{
    BufferView, Filter, Mode, decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_vertex_buffer,
};

use crate::document::{Gltf, Source};
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::save::VIEW_EXTENSIONS;

/// Whether a buffer without a URI is one that compressed views decode into.
pub(crate) fn is_fallback(buffer: Json<'_>) -> bool {
    let extensions = buffer.value().get("extensions");
    let flag = |name: &str| extensions.and_then(|e| e.get(name)?.get("fallback")?.as_bool()) == Some(true);
    VIEW_EXTENSIONS.iter().any(|name| flag(name))
}

/// What a compressed view says of itself.
struct Layout {
    mode: Mode,
    filter: Packing,
    count: usize,
    stride: usize,
    /// Whether newer streams may be there, as the extension of the standard's own has them.
    newer: bool,
}

/// What is done to decoded attributes.
#[derive(Clone, Copy, PartialEq)]
enum Packing {
    Known(Filter),
    Color,
}

impl Layout {
    fn read(json: Json<'_>, extension: &str) -> Result<Self, AssetError> {
        let newer = extension == "KHR_meshopt_compression";
        let mode = json.need("mode")?;
        let filter = match json.get("filter")? {
            None => Packing::Known(Filter::None),
            Some(filter) if newer && filter.string()? == "COLOR" => Packing::Color,
            Some(filter) => Packing::Known(
                Filter::parse(filter.string()?)
                    .map_err(|_| filter.fault("NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL"))?,
            ),
        };
        Ok(Self {
            mode: Mode::parse(mode.string()?).map_err(|_| mode.fault("ATTRIBUTES, TRIANGLES or INDICES"))?,
            filter,
            count: json.need("count")?.uint()?,
            stride: json.need("byteStride")?.uint()?,
            newer,
        })
    }

    fn bytes(&self) -> Option<usize> {
        self.count.checked_mul(self.stride)
    }

    fn decode(&self, source: &[u8], workspace: &mut Workspace) -> Result<Vec<u8>, meshoptimizer_rs::Error> {
        let Self { mode, filter, count, stride, newer } = *self;
        if let Packing::Known(filter) = filter
            && !(newer && mode == Mode::Attributes)
        {
            return BufferView::new(mode, filter, count, stride)?.decode(source, workspace);
        }
        // A filter on indices is refused there; this one has no such view.
        if mode != Mode::Attributes {
            return Err(meshoptimizer_rs::Error::InvalidParameter);
        }
        let mut data = decode_vertex_buffer(count, stride, source, workspace)?;
        match filter {
            Packing::Known(Filter::None) => Ok(()),
            Packing::Known(Filter::Octahedral) => decode_filter_oct(&mut data, count, stride, workspace),
            Packing::Known(Filter::Quaternion) => decode_filter_quat(&mut data, count, stride, workspace),
            Packing::Known(Filter::Exponential) => decode_filter_exp(&mut data, count, stride, workspace),
            Packing::Color => decode_filter_color(&mut data, count, stride, workspace),
        }?;
        Ok(data)
    }
}

impl Gltf {
    /// Decodes all compressed views of buffers that have no data. What cannot be decoded is an error for whoever reads it.
    pub(crate) fn decode_views(&mut self) -> Result<(), AssetError> {
        if !self.buffers.iter().any(|buffer| buffer.source == Source::Fallback) {
            return Ok(());
        }
        let mut workspace = Workspace::default();
        let (mut decoded, mut undecoded) = (Vec::new(), BTreeMap::new());
        if let Some(views) = self.table("bufferViews")? {
            for (index, view) in views.items()?.enumerate() {
                match self.decode_view(view, &mut workspace) {
                    Ok(Some((buffer, offset, bytes))) => decoded.push((buffer, offset, bytes)),
                    Ok(None) => {}
                    Err(error) => drop(undecoded.insert(index, error)),
                }
            }
        }
        let told = |error| Warning::instead(error, "compressed-view", "whatever reads it is refused");
        self.warnings.extend(undecoded.values().map(told));
        self.undecoded = undecoded;
        for (buffer, offset, bytes) in decoded {
            if let Some(buffer) = self.buffers.get_mut(buffer) {
                buffer.bytes.overwrite(offset, &bytes);
            }
        }
        Ok(())
    }

    /// The buffer, the offset in it and the bytes of a compressed view; nothing where it is not one of those.
    fn decode_view(
        &self,
        view: Json<'_>,
        workspace: &mut Workspace,
    ) -> Result<Option<(usize, usize, Vec<u8>)>, AssetError> {
        let Some(extensions) = view.get("extensions")? else { return Ok(None) };
        let buffer = view.need("buffer")?.index("buffer", self.buffers.len())?;
        let Some(parent) = self.buffers.get(buffer).filter(|buffer| buffer.source == Source::Fallback) else {
            return Ok(None);
        };
        for name in VIEW_EXTENSIONS {
            let Some(json) = extensions.get(name)? else { continue };
            let layout = Layout::read(json, name)?;
            let stride = view.get("byteStride")?.map(Json::uint).transpose()?;
            let length = view.need("byteLength")?.uint()?;
            if layout.bytes() != Some(length) || stride.is_some_and(|stride| stride != layout.stride) {
                let found = format!("{} elements of {} bytes", layout.count, layout.stride);
                return Err(json.found(found, format!("the {length} bytes of its view")));
            }
            let offset = view.uint_or("byteOffset", 0)?;
            if offset.checked_add(length).is_none_or(|end| end > parent.length) {
                return Err(
                    view.found("a range beyond its buffer", format!("{} bytes at most", parent.length))
                );
            }
            let bytes = layout.decode(self.range(json)?, workspace).map_err(|error| {
                json.found(format!("data that cannot be decoded ({error})"), "a compressed view")
            })?;
            return Ok(Some((buffer, offset, bytes)));
        }
        Ok(None)
    }

    /// The bytes that a view, or what compresses one, names by buffer, offset and length.
    pub(crate) fn range<'a>(&'a self, json: Json<'a>) -> Result<&'a [u8], AssetError> {
        let buffer = json.need("buffer")?.index("buffer", self.buffers.len())?;
        let buffer = self.buffers.get(buffer).ok_or_else(|| json.fault("a buffer"))?;
        let offset = json.uint_or("byteOffset", 0)?;
        let length = json.need("byteLength")?;
        let range = offset.checked_add(length.uint()?).filter(|&end| end <= buffer.length);
        let bytes = range.map_or(Ok(None), |end| buffer.bytes.get(offset..end))?;
        bytes.ok_or_else(|| {
            length.found(
                format!("{} bytes from byte {offset}", length.value()),
                format!("a range within the {} bytes of the buffer", buffer.length),
            )
        })
    }
}
