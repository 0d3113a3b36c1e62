//! Checked views of accessors: every byte that is read has been shown to lie within its view, its view within its
//! buffer, and the count within the budget, before anything is allocated.

mod numbers;

use crate::document::Gltf;
use crate::error::AssetError;
use crate::json::Json;

/// What a component of an element is stored as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn read(json: Json<'_>) -> Result<Self, AssetError> {
        Ok(match json.uint()? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(json.fault("a component type: 5120 to 5123, 5125 or 5126")),
        })
    }

    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Its number in the standard.
    pub(crate) fn code(self) -> u32 {
        match self {
            Self::I8 => 5120,
            Self::U8 => 5121,
            Self::I16 => 5122,
            Self::U16 => 5123,
            Self::U32 => 5125,
            Self::F32 => 5126,
        }
    }
}

/// Elements at equal distances.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that replace others.
#[derive(Clone, Copy, Debug)]
struct Sparse<'a> {
    index_type: Component,
    indices: &'a [u8],
    values: &'a [u8],
}

/// A checked accessor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accessor<'a> {
    pub(crate) index: usize,
    pub(crate) json: Json<'a>,
    pub(crate) count: usize,
    pub(crate) component: Component,
    /// Components of an element.
    pub(crate) lanes: usize,
    pub(crate) normalized: bool,
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

impl Gltf {
    /// The accessor that `reference` names, with all its ranges checked.
    pub(crate) fn accessor<'a>(&'a self, reference: Json<'_>) -> Result<Accessor<'a>, AssetError> {
        let accessor = self.declared(reference)?;
        accessor.check_rising()?;
        Ok(accessor)
    }

    /// The same by what the document says of it; nothing of its data is looked at, so that this takes no time.
    pub(crate) fn declared<'a>(&'a self, reference: Json<'_>) -> Result<Accessor<'a>, AssetError> {
        let (index, json) = self.follow("accessors", reference)?;
        let component = Component::read(json.need("componentType")?)?;
        let kind = json.need("type")?;
        let lanes = match kind.string()? {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" | "MAT2" => 4,
            "MAT3" => 9,
            "MAT4" => 16,
            _ => return Err(kind.fault("an accessor type: SCALAR, VEC2 to VEC4 or MAT2 to MAT4")),
        };
        let count = json.need("count")?.uint()?;
        if count == 0 {
            return Err(json.need("count")?.fault("at least one element"));
        }
        let normalized = match json.get("normalized")? {
            None => false,
            Some(flag) => flag.value().as_bool().ok_or_else(|| flag.fault("true or false"))?,
        };
        let size = element_size(component, lanes);
        let base = match json.get("bufferView")? {
            None => None,
            Some(view) => Some(self.strided(json, view, count, component, size)?),
        };
        let sparse = match json.get("sparse")? {
            None => None,
            Some(sparse) => Some(self.sparse(sparse, count, size)?),
        };
        Ok(Accessor { index, json, count, component, lanes, normalized, base, sparse })
    }

    /// The bytes of the view that `reference` names, the first of them, and its stride if it has one.
    pub(crate) fn view<'a>(
        &'a self,
        reference: Json<'_>,
    ) -> Result<(&'a [u8], usize, Option<usize>), AssetError> {
        let (index, view) = self.follow("bufferViews", reference)?;
        if let Some(error) = self.undecoded.get(&index) {
            return Err(error.clone());
        }
        let bytes = self.range(view)?;
        if bytes.is_empty() {
            return Err(view.need("byteLength")?.fault("at least one byte"));
        }
        let offset = view.uint_or("byteOffset", 0)?;
        let stride = match view.get("byteStride")? {
            None => None,
            Some(json) => {
                let stride = json.uint()?;
                if !(4..=252).contains(&stride) || stride % 4 != 0 {
                    return Err(json.fault("a multiple of 4 from 4 to 252"));
                }
                Some(stride)
            }
        };
        Ok((bytes, offset, stride))
    }

    fn strided<'a>(
        &'a self,
        json: Json<'a>,
        view: Json<'_>,
        count: usize,
        component: Component,
        size: usize,
    ) -> Result<Strided<'a>, AssetError> {
        let (bytes, start, stride) = self.view(view)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(view
                .found(format!("a view with a stride of {stride}"), format!("a stride of at least {size}")));
        }
        let offset = json.uint_or("byteOffset", 0)?;
        if !start.wrapping_add(offset).is_multiple_of(component.size()) {
            let place = json.get("byteOffset")?.unwrap_or(json);
            let found = format!("data from byte {} of the buffer", start.saturating_add(offset));
            return Err(place.found(found, format!("a multiple of {}", component.size())));
        }
        let end = (count - 1)
            .checked_mul(stride)
            .and_then(|n| n.checked_add(size))
            .and_then(|n| n.checked_add(offset));
        match end.filter(|&end| end <= bytes.len()).and_then(|end| bytes.get(offset..end)) {
            Some(bytes) => Ok(Strided { bytes, stride }),
            None => Err(json.found(
                format!("{count} elements of {size} bytes, {stride} apart, from byte {offset}"),
                format!("elements within the {} bytes of the buffer view", bytes.len()),
            )),
        }
    }

    /// `count` packed elements of `size` bytes in a view that `json` names.
    fn packed<'a>(&'a self, json: Json<'a>, count: usize, size: usize) -> Result<&'a [u8], AssetError> {
        let (bytes, _, _) = self.view(json.need("bufferView")?)?;
        let offset = json.uint_or("byteOffset", 0)?;
        count
            .checked_mul(size)
            .and_then(|length| length.checked_add(offset))
            .and_then(|end| bytes.get(offset..end))
            .ok_or_else(|| {
                json.found(
                    format!("{count} elements of {size} bytes from byte {offset}"),
                    format!("elements within the {} bytes of the buffer view", bytes.len()),
                )
            })
    }

    fn sparse<'a>(&'a self, json: Json<'a>, of: usize, size: usize) -> Result<Sparse<'a>, AssetError> {
        let count = json.need("count")?.uint()?;
        if count == 0 || count > of {
            return Err(json.need("count")?.fault(format!("1 to {of}, the elements of the accessor")));
        }
        let index_json = json.need("indices")?;
        let index_type = index_type(index_json.need("componentType")?)?;
        let indices = self.packed(index_json, count, index_type.size())?;
        let values = self.packed(json.need("values")?, count, size)?;
        Ok(Sparse { index_type, indices, values })
    }
}

/// The type of an index.
fn index_type(json: Json<'_>) -> Result<Component, AssetError> {
    let component = Component::read(json)?;
    match component {
        Component::U8 | Component::U16 | Component::U32 => Ok(component),
        _ => Err(json.fault("an unsigned type: 5121, 5123 or 5125")),
    }
}

/// Bytes of one element; the columns of small matrices start at multiples of 4.
fn element_size(component: Component, lanes: usize) -> usize {
    match (component.size(), lanes) {
        (size, 9) => (3 * size).div_ceil(4) * 4 * 3,
        (size, lanes) => size * lanes,
    }
}

impl<'a> Sparse<'a> {
    fn indices(&self) -> impl Iterator<Item = usize> + use<'a> {
        let index_type = self.index_type;
        self.indices.chunks_exact(index_type.size()).map(move |bytes| index_type.value(bytes) as usize)
    }
}

impl Accessor<'_> {
    /// Checks that sparse elements come in their order, each once.
    fn check_rising(&self) -> Result<(), AssetError> {
        let (of, mut least) = (self.count, 0);
        for index in self.sparse.iter().flat_map(Sparse::indices) {
            if index < least || index >= of {
                let place = self.json.need("sparse")?.need("indices")?;
                return Err(place.found(format!("index {index}"), format!("rising indices below {of}")));
            }
            least = index + 1;
        }
        Ok(())
    }
}
