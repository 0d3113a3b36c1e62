//! Points and lines of a scene.

use crate::document::Gltf;
use crate::error::AssetError;
use crate::limits::{Budget, Of, reserve};
use crate::primitive::Mode;
use crate::rest::{Part, Rest};

/// The points or lines of one part.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stroke {
    /// The part: an index into [`Rest::parts`].
    pub part: usize,
    /// Its vertices, indices into [`Rest::positions`]. A closed line ends with the vertex it begins with.
    pub points: Vec<u32>,
    /// Where each line ends in `points`, rising; empty where they are single points.
    pub line_ends: Vec<usize>,
}

impl Stroke {
    /// The lines, each of at least two vertices; none of single points.
    pub fn lines(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.line_ends.iter().copied());
        starts.zip(&self.line_ends).filter_map(|(start, &end)| self.points.get(start..end))
    }
}

impl Gltf {
    /// The points and lines of `rest`, the rest of this document: one entry for each part of them, in their order.
    /// Segments that continue each other are one line.
    ///
    /// # Errors
    ///
    /// Indices that are malformed; the limits.
    pub fn strokes(&self, rest: &Rest) -> Result<Vec<Stroke>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let drawn = |(_, part): &(usize, &Part)| (part.mode as u8) < Mode::Triangles as u8;
        let parts = rest.parts.iter().enumerate().filter(drawn);
        parts
            .map(|(index, part)| self.stroke(rest, index, part, &mut budget))
            .collect::<Result<_, _>>()
            .map_err(|error| error.in_file(&self.file))
    }

    fn stroke(
        &self,
        rest: &Rest,
        index: usize,
        part: &Part,
        budget: &mut Budget,
    ) -> Result<Stroke, AssetError> {
        let (first, count) = rest.blocks.get(part.block).map_or((0, 0), |block| (block.first, block.count));
        let primitive = self.primitive(part)?;
        let indices = self.indices(primitive, count, budget)?;
        let length = indices.as_ref().map_or(count, Vec::len);
        let at = |i: usize| (first as u32).saturating_add(indices.as_ref().map_or(i as u32, |list| list[i]));
        // A vertex and an end each, and one more that closes a loop.
        let bytes = (length as u64).saturating_add(1).saturating_mul(size_of::<(u32, usize)>() as u64);
        budget.charge(Of::ExpandedBytes, bytes, || primitive.place())?;
        let mut out =
            Stroke { part: index, points: reserve(length.saturating_add(1))?, line_ends: Vec::new() };
        match part.mode {
            Mode::Lines => {
                out.line_ends = reserve(length / 2)?;
                for k in 0..length / 2 {
                    out.segment(at(2 * k), at(2 * k + 1));
                }
                out.line_ends.extend((!out.points.is_empty()).then_some(out.points.len()));
            }
            Mode::Points => out.points.extend((0..length).map(at)),
            // A single vertex makes no line.
            _ if length < 2 => {}
            mode => {
                out.points.extend((0..length).map(at));
                out.points.extend((mode == Mode::LineLoop).then(|| at(0)));
                out.line_ends.push(out.points.len());
            }
        }
        Ok(out)
    }
}

impl Stroke {
    /// Adds a segment to lines of which the last one has no end yet.
    fn segment(&mut self, from: u32, to: u32) {
        if self.points.last() != Some(&from) {
            self.line_ends.extend((!self.points.is_empty()).then_some(self.points.len()));
            self.points.push(from);
        }
        self.points.push(to);
    }
}
