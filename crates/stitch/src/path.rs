//! From what a preset says of an edge to vertices of a border.

use crate::border::Border;
use crate::error::EdgeFault;
use crate::settings::{Edge, Run, Side};
use crate::surfaces::{Piece, Surfaces, wide};

/// A point may be so far off a border, in parts of the piece's size, to name a vertex of it; beyond, something else was meant.
const NEAR: f32 = 0.1;

/// Vertices of a border in a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Path {
    pub(crate) vertices: Vec<u32>,
    /// Whether behind the last comes the first.
    pub(crate) closed: bool,
}

impl Path {
    /// The vertices of an edge.
    pub(crate) fn of(edge: &Edge, piece: &Piece, surfaces: &Surfaces<'_>) -> Result<Self, EdgeFault> {
        let path = match edge.run {
            Run::Side(side) => side_of(edge.piece, side, surfaces)?,
            Run::Between { from, to, long } => between(from, to, long, piece, surfaces)?,
            Run::Loop(point) => {
                let (border, first) = nearest(point, piece, surfaces)?;
                let mut vertices = whole(border, surfaces)?.vertices.clone();
                vertices.rotate_left(first);
                Self { vertices, closed: true }
            }
        };
        if path.length(surfaces) > 0.0 { Ok(path) } else { Err(EdgeFault::NoLength) }
    }

    /// The first and the last vertex; none of a loop.
    pub(crate) fn ends(&self) -> Option<[u32; 2]> {
        let ends = || Some([*self.vertices.first()?, *self.vertices.last()?]);
        if self.closed { None } else { ends() }
    }

    /// The vertices that are no ends.
    pub(crate) fn inner(&self) -> &[u32] {
        match self.vertices.len() {
            _ if self.closed => &self.vertices,
            0 | 1 => &[],
            count => &self.vertices[1..count - 1],
        }
    }

    /// How many segments it has.
    pub(crate) fn segments(&self) -> usize {
        self.vertices.len().saturating_sub(usize::from(!self.closed))
    }

    /// The lengths of its segments.
    pub(crate) fn lengths(&self, surfaces: &Surfaces<'_>) -> Vec<f64> {
        let count = self.vertices.len();
        let at = |i: usize| surfaces.at(self.vertices[i % count]);
        (0..self.segments()).map(|i| at(i).distance(at(i + 1))).collect()
    }

    fn length(&self, surfaces: &Surfaces<'_>) -> f64 {
        self.lengths(surfaces).iter().sum()
    }
}

fn side_of(piece: usize, side: Side, surfaces: &Surfaces<'_>) -> Result<Path, EdgeFault> {
    let sides = surfaces.sides.get(piece).and_then(Option::as_ref).ok_or(EdgeFault::NoSides)?;
    let mut vertices = sides[side as usize].clone();
    vertices.dedup();
    let closed = vertices.len() > 2 && vertices.first() == vertices.last();
    if closed {
        vertices.pop();
    }
    Ok(Path { vertices, closed })
}

/// The border nearest to a point, and the place in it of the nearest vertex.
fn nearest<'p>(
    point: [f32; 3],
    piece: &'p Piece,
    surfaces: &Surfaces<'_>,
) -> Result<(&'p Border, usize), EdgeFault> {
    let off = |vertex: u32| surfaces.at(vertex).distance_squared(wide(point));
    let places =
        piece.borders.iter().flat_map(|border| (0..border.vertices.len()).map(move |at| (border, at)));
    let found = places.min_by(|(b, i), (c, j)| off(b.vertices[*i]).total_cmp(&off(c.vertices[*j])));
    found.ok_or(EdgeFault::NoBorder)
}

fn whole<'p>(border: &'p Border, surfaces: &Surfaces<'_>) -> Result<&'p Border, EdgeFault> {
    match border.branch {
        Some(vertex) => Err(EdgeFault::Branches { at: surfaces.at(vertex).as_vec3().to_array() }),
        None => Ok(border),
    }
}

/// One end of a run; refuses a point that no border is near to.
fn end<'p>(
    field: &'static str,
    point: [f32; 3],
    piece: &'p Piece,
    surfaces: &Surfaces<'_>,
) -> Result<(&'p Border, usize), EdgeFault> {
    let (border, at) = nearest(point, piece, surfaces)?;
    let count = border.vertices.len();
    let here = surfaces.at(border.vertices[at]);
    let beside = [at + 1, at + count - 1].map(|i| surfaces.at(border.vertices[i % count]).distance(here));
    let distance = here.distance(wide(point)) as f32;
    if distance > (NEAR * piece.size).max(beside[0].max(beside[1]) as f32) {
        return Err(EdgeFault::OffBorder { field, distance, nearest: here.as_vec3().to_array() });
    }
    Ok((border, at))
}

fn between(
    from: [f32; 3],
    to: [f32; 3],
    long: bool,
    piece: &Piece,
    surfaces: &Surfaces<'_>,
) -> Result<Path, EdgeFault> {
    let (border, first) = end("from", from, piece, surfaces)?;
    let (other, last) = end("to", to, piece, surfaces)?;
    if !std::ptr::eq(border, other) {
        return Err(EdgeFault::Apart);
    }
    let border = whole(border, surfaces)?;
    if first == last {
        return Err(EdgeFault::OneEnd);
    }
    let count = border.vertices.len();
    let way = |steps: usize, turn: usize| -> Path {
        let vertices = (0..=steps).map(|i| border.vertices[(first + i * turn) % count]).collect();
        Path { vertices, closed: false }
    };
    let ahead = way((last + count - first) % count, 1);
    let back = way((first + count - last) % count, count - 1);
    let lengths = [&ahead, &back].map(|path| path.length(surfaces));
    Ok(if (lengths[0] <= lengths[1]) == long { back } else { ahead })
}
