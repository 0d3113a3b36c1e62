//! Topology of a primitive: which of its vertices make triangles.

use crate::accessor::{Accessor, Component};
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};

/// What the vertices of a primitive are joined to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Single points.
    Points,
    /// Separate segments.
    Lines,
    /// A closed line.
    LineLoop,
    /// An open line.
    LineStrip,
    /// Separate triangles, the default.
    Triangles,
    /// Triangles of three successive vertices each.
    TriangleStrip,
    /// Triangles about the first vertex.
    TriangleFan,
}

impl Mode {
    pub(crate) fn read(primitive: Json<'_>) -> Result<Self, AssetError> {
        let Some(mode) = primitive.get("mode")? else { return Ok(Self::Triangles) };
        Ok(match mode.uint()? {
            0 => Self::Points,
            1 => Self::Lines,
            2 => Self::LineLoop,
            3 => Self::LineStrip,
            4 => Self::Triangles,
            5 => Self::TriangleStrip,
            6 => Self::TriangleFan,
            _ => return Err(mode.fault("a mode from 0 to 6")),
        })
    }
}

impl Gltf {
    /// The triangles of a primitive with `count` vertices, counter-clockwise; none for points and lines. Triangles
    /// that name a vertex twice are left out.
    pub(crate) fn triangles(
        &self,
        primitive: Json<'_>,
        count: usize,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<[u32; 3]>, AssetError> {
        let mode = Mode::read(primitive)?;
        let accessor = self.index_accessor(primitive)?.filter(|_| mode == Mode::Triangles);
        if let Some(grouped) = accessor.and_then(|accessor| accessor.grouped::<3>()) {
            budget.charge(Of::Indices, 3 * grouped.count as u64, || grouped.json.place())?;
            let mut out = grouped.uints::<3>(budget)?;
            check_indices(&grouped, out.as_flattened(), count)?;
            let number = out.len();
            budget.charge(Of::ExpandedBytes, (number as u64).saturating_mul(12), || primitive.place())?;
            out.retain(|&triangle| distinct(triangle));
            warn_of_dropped(number - out.len(), primitive, warnings);
            return Ok(out);
        }
        let indices = self.indices(primitive, count, budget)?;
        let length = indices.as_ref().map_or(count, Vec::len);
        let at = |i: usize| indices.as_ref().map_or(i as u32, |indices| indices[i]);
        let triangle = |a: usize, b: usize, c: usize| [at(a), at(b), at(c)];
        let number = match mode {
            Mode::Triangles => length / 3,
            Mode::TriangleStrip | Mode::TriangleFan => length.saturating_sub(2),
            _ => 0,
        };
        if mode == Mode::Triangles && !length.is_multiple_of(3) {
            let message =
                format!("{length} corners are no whole number of triangles; the last ones are left out");
            warnings.push(Warning::new("corners", primitive.place(), message));
        }
        budget.charge(Of::ExpandedBytes, (number as u64).saturating_mul(12), || primitive.place())?;
        let mut out = reserve(number)?;
        let all = (0..number).map(|i| match mode {
            Mode::TriangleStrip => triangle(i, i + 1 + i % 2, i + 2 - i % 2),
            Mode::TriangleFan => triangle(i + 1, i + 2, 0),
            _ => triangle(3 * i, 3 * i + 1, 3 * i + 2),
        });
        out.extend(all.filter(|&triangle| distinct(triangle)));
        if mode == Mode::Triangles {
            warn_of_dropped(number - out.len(), primitive, warnings);
        }
        Ok(out)
    }

    /// The indices of a primitive, all of them below `count`; none where it has no list of them.
    pub(crate) fn indices(
        &self,
        primitive: Json<'_>,
        count: usize,
        budget: &mut Budget,
    ) -> Result<Option<Vec<u32>>, AssetError> {
        let Some(accessor) = self.index_accessor(primitive)? else {
            budget.charge(Of::Indices, count as u64, || primitive.place())?;
            return Ok(None);
        };
        budget.charge(Of::Indices, accessor.count as u64, || accessor.json.place())?;
        let indices = accessor.uints::<1>(budget)?.into_flattened();
        check_indices(&accessor, &indices, count)?;
        Ok(Some(indices))
    }

    /// The accessor of the indices of a primitive, if it has any: unsigned scalars.
    fn index_accessor<'a>(&'a self, primitive: Json<'_>) -> Result<Option<Accessor<'a>>, AssetError> {
        let Some(reference) = primitive.get("indices")? else { return Ok(None) };
        let accessor = self.accessor(reference)?;
        let unsigned = matches!(accessor.component, Component::U8 | Component::U16 | Component::U32);
        if !unsigned || accessor.normalized || accessor.lanes != 1 {
            return Err(accessor.json.found("an accessor of another type", "indices: unsigned scalars"));
        }
        Ok(Some(accessor))
    }
}

/// Checks that all indices are below `count` and none is the largest of its type, which restarts primitives.
fn check_indices(accessor: &Accessor<'_>, indices: &[u32], count: usize) -> Result<(), AssetError> {
    let restart = match accessor.component.size() {
        1 => u32::from(u8::MAX),
        2 => u32::from(u16::MAX),
        _ => u32::MAX,
    };
    let bad = |i: u32| i as usize >= count || i == restart;
    // Most have no bad one, and the largest is found many at a time.
    if indices.iter().copied().max().is_none_or(|largest| !bad(largest)) {
        return Ok(());
    }
    match indices.iter().position(|&i| bad(i)) {
        None => Ok(()),
        Some(k) => Err(accessor.json.found(
            format!("index {} at element {k}", indices[k]),
            format!("indices below {count}, the number of vertices"),
        )),
    }
}

fn distinct([a, b, c]: [u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// Tells of triangles that name a vertex twice.
fn warn_of_dropped(number: usize, primitive: Json<'_>, warnings: &mut Vec<Warning>) {
    if number > 0 {
        let message = format!("{number} triangles name a vertex twice; they are left out");
        warnings.push(Warning::new("zero-area", primitive.place(), message));
    }
}
