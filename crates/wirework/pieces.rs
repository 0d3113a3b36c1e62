//! The pieces that a stitch joins, on the points of a subject.

mod gather;

use std::collections::HashMap;

use wirework_preset::{Object, Shape};
use wirework_surface::Cut;

/// Which points belong to which piece. Without pieces both lists are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pieces {
    /// The pieces, in the order in which they were given.
    pub list: Vec<SubjectPiece>,
    /// For each of [`Subject::points`](crate::Subject::points) its piece, an index into `list`, or [`Pieces::NONE`].
    pub of_points: Vec<u32>,
}

/// A piece of a subject.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SubjectPiece {
    /// Its name.
    pub name: String,
    /// The points of its four sides, where it is a patch or a grid: `u = 0` and `u = 1` as `v` grows, `v = 0` and `v = 1` as `u`
    /// grows. The `u` of a grid runs along its first side and its `v` along its second, from the vertex that is listed first.
    pub sides: Option<[Vec<u32>; 4]>,
    /// Whether no two of its points are one because they are at one place.
    pub(crate) distinct: bool,
    /// The nodes of the document that stand for it, where it has more than the one of its name.
    pub(crate) nodes: Vec<usize>,
}

impl Pieces {
    /// The piece of a point that belongs to none.
    pub const NONE: u32 = u32::MAX;

    /// The pieces of points, from those of the positions of a model; sides are lists of positions before, of points after.
    pub(crate) fn of_model(
        mut list: Vec<SubjectPiece>,
        of_positions: &[u32],
        point_of: &[u32],
        points: usize,
    ) -> Self {
        if list.is_empty() {
            return Self::default();
        }
        let mut of_points = vec![Self::NONE; points];
        for (&piece, &point) in of_positions.iter().zip(point_of) {
            if let Some(slot) = of_points.get_mut(point as usize) {
                *slot = piece.min(*slot);
            }
        }
        for side in list.iter_mut().filter_map(|piece| piece.sides.as_mut()).flatten() {
            renumber(side, point_of);
        }
        Self { list, of_points }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The piece of a point.
    pub(crate) fn of(&self, point: u32) -> u32 {
        self.of_points.get(point as usize).copied().unwrap_or(Self::NONE)
    }

    /// The nodes that a piece of that name stands for besides.
    pub(crate) fn nodes(&self, name: &str) -> &[usize] {
        self.list.iter().find(|piece| piece.name == name).map_or(&[], |piece| &piece.nodes)
    }

    /// The pieces of a finer subject: for each new point, behind the old ones, the two that it lies between; where each `halves` the
    /// edge of these, sides take it up.
    pub(crate) fn grown(mut self, new: impl Iterator<Item = ([u32; 2], u32)>, halves: bool) -> Self {
        if self.is_empty() {
            return self;
        }
        let new: Vec<_> = new.collect();
        for &([a, b], point) in &new {
            let piece = self.of(a).min(self.of(b));
            let count = self.of_points.len().max(point as usize + 1);
            self.of_points.resize(count, Self::NONE);
            self.of_points[point as usize] = piece;
        }
        if halves {
            self.refine_sides(new.into_iter());
        }
        self
    }

    /// The sides with the new points of cuts between theirs.
    pub(crate) fn cut_sides(&mut self, cuts: &[Cut], points: &[Vec<u32>]) {
        let known: HashMap<[u32; 2], (&Cut, &Vec<u32>)> =
            cuts.iter().zip(points).map(|(cut, new)| (sorted(cut.ends), (cut, new))).collect();
        for side in self.list.iter_mut().filter_map(|piece| piece.sides.as_mut()).flatten() {
            let mut out = Vec::with_capacity(side.len());
            for (i, &point) in side.iter().enumerate() {
                out.push(point);
                let Some(&next) = side.get(i + 1) else { continue };
                match known.get(&sorted([point, next])) {
                    Some((cut, new)) if cut.ends[0] == point => out.extend(new.iter()),
                    Some((_, new)) => out.extend(new.iter().rev()),
                    None => {}
                }
            }
            *side = out;
        }
    }

    /// The sides with the new points between theirs: each new one is in the middle of two.
    fn refine_sides(&mut self, new: impl Iterator<Item = ([u32; 2], u32)>) {
        let mut sides = self.list.iter_mut().filter_map(|piece| piece.sides.as_mut()).flatten().peekable();
        if sides.peek().is_none() {
            return;
        }
        let middles: HashMap<[u32; 2], u32> = new.map(|(ends, middle)| (sorted(ends), middle)).collect();
        for side in sides {
            let mut out = Vec::with_capacity(side.len());
            // The ends that are still ahead, the next one last.
            let mut ahead: Vec<u32> = side.iter().rev().copied().collect();
            while let Some(next) = ahead.pop() {
                let middle = out.last().and_then(|&last| Some((last, *middles.get(&sorted([last, next]))?)));
                match middle.filter(|&(last, middle)| middle != last && middle != next) {
                    Some((_, middle)) => ahead.extend([next, middle]),
                    None => out.push(next),
                }
            }
            *side = out;
        }
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Each number of a list by what it now is.
pub(crate) fn renumber(list: &mut [u32], now: &[u32]) {
    for number in list {
        *number = now.get(*number as usize).copied().unwrap_or_default();
    }
}

/// The positions of the four sides of an object that has them.
fn sides(object: &Object) -> Option<[Vec<u32>; 4]> {
    // The number of the vertex at (i, j), `i` along `u`.
    type Number = fn([u32; 2], u32, u32) -> u32;
    let (cells, at): ([u32; 2], Number) = match &object.shape {
        Shape::Patch { tessellation, .. } => (*tessellation, |[_, v], i, j| i * (v + 1) + j),
        Shape::Grid { cells, .. } => (*cells, |[u, _], i, j| j * (u + 1) + i),
        _ => return None,
    };
    let [u, v] = cells;
    let along_v = |i: u32| (0..=v).map(|j| at(cells, i, j)).collect();
    let along_u = |j: u32| (0..=u).map(|i| at(cells, i, j)).collect();
    Some([along_v(0), along_v(u), along_u(0), along_u(v)])
}

#[cfg(test)]
#[path = "pieces_tests.rs"]
mod tests;
