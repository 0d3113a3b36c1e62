//! Checked views of accessors: every byte that is read has been shown to lie within its view, its view within its
//! buffer, and the count within the budget, before anything is allocated.

use rayon::prelude::*;

use crate::document::Gltf;
use crate::error::AssetError;
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};

/// So many elements are converted by one thread at a time.
const BLOCK: usize = 1 << 12;

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

    /// The component that `bytes` start with, 0 where there are too few.
    fn value(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => bytes.first().map_or(0.0, |&b| f64::from(b.cast_signed())),
            Self::U8 => bytes.first().map_or(0.0, |&b| f64::from(b)),
            Self::I16 => first(bytes).map_or(0.0, |b| f64::from(i16::from_le_bytes(b))),
            Self::U16 => first(bytes).map_or(0.0, |b| f64::from(u16::from_le_bytes(b))),
            Self::U32 => first(bytes).map_or(0.0, |b| f64::from(u32::from_le_bytes(b))),
            Self::F32 => first(bytes).map_or(0.0, |b| f64::from(f32::from_le_bytes(b))),
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

    /// What a normalised component is divided by, and the least that it can then be.
    fn scale(self) -> (f64, f64) {
        match self {
            Self::I8 => (127.0, -1.0),
            Self::U8 => (255.0, 0.0),
            Self::I16 => (32_767.0, -1.0),
            Self::U16 => (65_535.0, 0.0),
            Self::U32 | Self::F32 => (1.0, f64::NEG_INFINITY),
        }
    }
}

fn first<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
    bytes.first_chunk::<N>().copied()
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

impl<'a> Accessor<'a> {
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

    /// All elements as `N` floats each; normalised integers as the standard says. `N` is [`Accessor::lanes`].
    pub(crate) fn floats<const N: usize>(&self, budget: &mut Budget) -> Result<Vec<[f32; N]>, AssetError> {
        if self.component == Component::F32 {
            return self.elements(budget, 0.0, plain);
        }
        let (scale, least) = self.range();
        let convert = |value: f64| (value / scale).max(least) as f32;
        match self.component {
            Component::I8 => self.elements(budget, 0.0, |[b]| convert(f64::from(u8::cast_signed(b)))),
            Component::U8 => self.elements(budget, 0.0, |[b]| convert(f64::from(b))),
            Component::I16 => self.elements(budget, 0.0, |b| convert(f64::from(i16::from_le_bytes(b)))),
            Component::U16 => self.elements(budget, 0.0, |b| convert(f64::from(u16::from_le_bytes(b)))),
            Component::U32 | Component::F32 => {
                self.elements(budget, 0.0, |b| convert(f64::from(u32::from_le_bytes(b))))
            }
        }
    }

    /// All elements as `N` unsigned integers each; the component type is an unsigned one.
    pub(crate) fn uints<const N: usize>(&self, budget: &mut Budget) -> Result<Vec<[u32; N]>, AssetError> {
        match self.component.size() {
            1 => self.elements(budget, 0, |[b]| u32::from(b)),
            2 => self.elements(budget, 0, |b| u32::from(u16::from_le_bytes(b))),
            _ => self.elements(budget, 0, u32::from_le_bytes),
        }
    }

    /// Scalars that stand side by side as groups of `N`; nothing where they do not, or are no whole groups.
    pub(crate) fn grouped<const N: usize>(&self) -> Option<Self> {
        let base = self.base.filter(|base| base.stride == self.component.size())?;
        let whole = self.lanes == 1 && self.sparse.is_none() && self.count.is_multiple_of(N);
        let base = Strided { stride: N * base.stride, ..base };
        whole.then_some(Self { count: self.count / N, lanes: N, base: Some(base), ..*self })
    }

    /// All elements as `N` integers of 8 or 16 bits without sign each; the component type is one of those.
    pub(crate) fn shorts<const N: usize>(&self, budget: &mut Budget) -> Result<Vec<[u16; N]>, AssetError> {
        match self.component.size() {
            1 => self.elements(budget, 0, |[b]| u16::from(b)),
            _ => self.elements(budget, 0, u16::from_le_bytes),
        }
    }

    /// Visits the elements in their order, as [`Accessor::floats`] gives them, without keeping them. Of an accessor
    /// without a view only the elements that are not 0. Charged as if they were kept, for that bounds the time.
    pub(crate) fn each_float<const N: usize>(
        &self,
        budget: &mut Budget,
        mut visit: impl FnMut(usize, [f32; N]),
    ) -> Result<(), AssetError> {
        self.charge::<f32, N>(budget)?;
        let size = self.component.size();
        let (scale, least) = self.range();
        let element = |bytes: &[u8]| {
            let mut out = [0.0; N];
            for (slot, bytes) in out.iter_mut().zip(bytes.chunks_exact(size)) {
                *slot = (self.component.value(bytes) / scale).max(least) as f32;
            }
            out
        };
        let mut replaced = self.replaced(size * N).peekable();
        match self.base {
            None => replaced.for_each(|(i, bytes)| visit(i, element(bytes))),
            Some(base) => {
                for (i, bytes) in base.bytes.chunks(base.stride).take(self.count).enumerate() {
                    let bytes = replaced.next_if(|(at, _)| *at == i).map_or(bytes, |(_, bytes)| bytes);
                    visit(i, element(bytes));
                }
            }
        }
        Ok(())
    }

    /// What components are divided by, and the least that they can then be.
    fn range(&self) -> (f64, f64) {
        if self.normalized { self.component.scale() } else { (1.0, f64::NEG_INFINITY) }
    }

    fn charge<T, const N: usize>(&self, budget: &mut Budget) -> Result<(), AssetError> {
        if self.lanes != N {
            return Err(self.json.need("type")?.fault(format!("a type of {N} components")));
        }
        let bytes = (self.count as u64).saturating_mul(size_of::<[T; N]>() as u64);
        budget.charge(Of::ExpandedBytes, bytes, || self.json.place())
    }

    /// The elements that replace others, of `size` bytes each, and which. They are below the count.
    fn replaced(&self, size: usize) -> impl Iterator<Item = (usize, &'a [u8])> + use<'a> {
        let sparse = self.sparse;
        sparse.into_iter().flat_map(move |s| s.indices().zip(s.values.chunks_exact(size)))
    }

    /// All elements, their components of `S` bytes converted one by one.
    fn elements<T: Copy + Send + Sync, const S: usize, const N: usize>(
        &self,
        budget: &mut Budget,
        zero: T,
        convert: impl Fn([u8; S]) -> T + Sync,
    ) -> Result<Vec<[T; N]>, AssetError> {
        self.charge::<T, N>(budget)?;
        // There is room already, which none of what fills it makes again.
        let mut out = reserve(self.count)?;
        let element = |bytes: &[u8]| converted(bytes, zero, &convert);
        match self.base {
            None => out.resize(self.count, [zero; N]),
            // The same once more in a form that compilers turn into vector instructions.
            Some(base) if base.stride == S * N => {
                let elements = base.bytes.as_chunks().0.as_chunks::<N>().0;
                let elements = elements.get(..self.count).unwrap_or(elements).par_iter();
                let converted = elements.with_min_len(BLOCK).map(|components| components.map(&convert));
                converted.collect_into_vec(&mut out);
            }
            Some(base) => {
                let elements = base.bytes.par_chunks(base.stride).take(self.count).with_min_len(BLOCK);
                elements.map(element).collect_into_vec(&mut out);
            }
        }
        for (i, bytes) in self.replaced(S * N) {
            if let Some(slot) = out.get_mut(i) {
                *slot = element(bytes);
            }
        }
        Ok(out)
    }
}

/// The `N` components that `bytes` start with, of `S` bytes each.
fn converted<T: Copy, const S: usize, const N: usize>(
    bytes: &[u8],
    zero: T,
    convert: impl Fn([u8; S]) -> T,
) -> [T; N] {
    bytes.as_chunks().0.first_chunk::<N>().map_or([zero; N], |components| components.map(convert))
}

/// A float as it is, but for NaN, which goes the way of what is infinite: as with other types, there is a least value.
fn plain(bytes: [u8; 4]) -> f32 {
    f32::from_le_bytes(bytes).max(f32::NEG_INFINITY)
}
