//! The numbers of accessors, converted: all at once by as many threads as there are, or one by one without keeping them.

use rayon::prelude::*;

use super::{Accessor, Component, Strided};
use crate::error::AssetError;
use crate::limits::{Budget, Of, reserve};

/// So many elements are converted by one thread at a time.
const BLOCK: usize = 1 << 12;

impl Component {
    /// The component that `bytes` start with, 0 where there are too few.
    pub(super) fn value(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => bytes.first().map_or(0.0, |&b| f64::from(b.cast_signed())),
            Self::U8 => bytes.first().map_or(0.0, |&b| f64::from(b)),
            Self::I16 => first(bytes).map_or(0.0, |b| f64::from(i16::from_le_bytes(b))),
            Self::U16 => first(bytes).map_or(0.0, |b| f64::from(u16::from_le_bytes(b))),
            Self::U32 => first(bytes).map_or(0.0, |b| f64::from(u32::from_le_bytes(b))),
            Self::F32 => first(bytes).map_or(0.0, |b| f64::from(f32::from_le_bytes(b))),
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

impl<'a> Accessor<'a> {
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
