//! Edges cut where it is said, so that a surface has vertices where another one has them.
//!
//! A triangle is cut into a fan from the corner across the edge. Where two or three of its edges are cut, each further
//! edge is whole in one part of the fan before, which is cut in the same way. No vertex comes up but on the edges that
//! are named, so that the other edges, and the triangles behind them, stay.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use super::mesh::{Vertices, sides as face_sides};
use super::{MeshSubdivision, SubdivideError, SubdivideLimits, Subdivision, sides};
use crate::{Corner, Mesh};

/// Where an edge is to be cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// The two ends of the edge: places.
    pub ends: [u32; 2],
    /// How far each new place lies from the first end towards the second, as a part of the way: above 0, rising, below 1.
    pub shares: Vec<f64>,
}

impl Cut {
    /// For each cut its new places, in order. They are numbered behind the old ones, of which there are so many, in the
    /// order of the cuts.
    pub fn places(cuts: &[Self], places: usize) -> Vec<Vec<u32>> {
        let mut first = places as u32;
        let of_cut = |cut: &Self| {
            let range = first..first.saturating_add(cut.shares.len() as u32);
            first = range.end;
            range.collect()
        };
        cuts.iter().map(of_cut).collect()
    }
}

/// Cuts edges, in all triangles that have them: one at a border, two inside, and at a seam those on both of its sides.
///
/// `place_of` is for each vertex its place, of which there are so many: vertices at one place are on the two sides of a seam.
/// [`Cut::places`] tells which the new places are. The parents of new vertices are old ones, the first of them at the
/// first end of its cut; new vertices are numbered by the cuts, then by their parents, whatever the order of the triangles.
///
/// Shares may be so close to each other that the new positions are equal; the places are different ones all the same.
///
/// # Errors
///
/// [`SubdivideError`]; more than `limits` allow, before room for it is taken.
pub fn cut_edges(
    triangles: &[[u32; 3]],
    place_of: &[u32],
    places: usize,
    cuts: &[Cut],
    limits: SubdivideLimits,
) -> Result<Subdivision, SubdivideError> {
    let beyond = |what, index: u32, count| SubdivideError::Index { what, index: index as usize, count };
    if let Some(&place) = place_of.iter().find(|&&place| place as usize >= places) {
        return Err(beyond("place", place, places));
    }
    let count = place_of.len();
    if let Some(&vertex) = triangles.as_flattened().iter().find(|&&vertex| vertex as usize >= count) {
        return Err(beyond("vertex", vertex, count));
    }
    let wanted = by_edge(cuts, places)?;
    let cutting = Cutting::new(triangles, place_of, cuts, &wanted);
    let is_found = |&cut: &usize| cutting.edges.binary_search_by_key(&cut, |edge| edge.0).is_ok();
    if let Some(cut) = (0..cuts.len()).find(|cut| !is_found(cut)) {
        return Err(SubdivideError::Edge(cut));
    }
    cutting.check(triangles.len(), places, limits)?;
    Ok(cutting.run(triangles, places))
}

impl Mesh {
    /// Cuts edges of faces; `place_of` is for each of [`Mesh::positions`] its place, of which there are so many.
    ///
    /// A face none of whose edges is cut stays as it is. Others become triangles: those of [`Mesh::triangles`], and their
    /// parts. [`Cut::places`] tells which the new places are; each has a position for every pair of old ones that the cut
    /// edge has.
    ///
    /// # Errors
    ///
    /// [`SubdivideError`]. Vertices are counted as a renderer has them: by position, texture coordinate and normal.
    pub fn cut(
        &self,
        place_of: &[u32],
        places: usize,
        cuts: &[Cut],
        limits: SubdivideLimits,
    ) -> Result<MeshSubdivision, SubdivideError> {
        self.check()?;
        if place_of.len() != self.positions.len() {
            let (index, count) = (place_of.len(), self.positions.len());
            return Err(SubdivideError::Index { what: "vertex", index, count });
        }
        let wanted = by_edge(cuts, places)?;
        let place = |side: [Corner; 2]| side.map(|corner| place_of[corner.position as usize]);
        let own = self.faces().flat_map(face_sides).map(|side| sorted(place(side)));
        let own: HashSet<[u32; 2]> = own.filter(|edge| wanted.contains_key(edge)).collect();
        // A diagonal is no edge, even of a face that is cut elsewhere.
        if let Some(cut) = cuts.iter().position(|cut| !own.contains(&sorted(cut.ends))) {
            return Err(SubdivideError::Edge(cut));
        }
        let vertices = Vertices::of(self);
        let is_cut = |p, q| wanted.get(&sorted([p, q])).is_some_and(|&cut| !cuts[cut].shares.is_empty());
        let (touched, triangles) = self.touched(place_of, &vertices, is_cut);
        let of_vertices: Vec<u32> = vertices.corners.iter().map(|c| place_of[c.position as usize]).collect();
        let cutting = Cutting::new(&triangles, &of_vertices, cuts, &wanted);
        cutting.check(triangles.len(), places, limits)?;
        let parts = cutting.run(&triangles, places);
        Ok(self.assemble(&touched, vertices, &parts))
    }
}

fn sorted([p, q]: [u32; 2]) -> [u32; 2] {
    [p.min(q), p.max(q)]
}

/// The checked cuts by their ends, the lesser first.
fn by_edge(cuts: &[Cut], places: usize) -> Result<HashMap<[u32; 2], usize>, SubdivideError> {
    let mut out = HashMap::with_capacity(cuts.len());
    for (k, Cut { ends: [p, q], shares }) in cuts.iter().enumerate() {
        if let Some(&end) = [p, q].into_iter().find(|&&end| end as usize >= places) {
            return Err(SubdivideError::Index { what: "place", index: end as usize, count: places });
        }
        let inside = shares.iter().all(|&share| share > 0.0 && share < 1.0);
        if !inside || !shares.is_sorted_by(|a, b| a < b) {
            return Err(SubdivideError::Shares(k));
        }
        if p == q || out.insert(sorted([*p, *q]), k).is_some() {
            return Err(SubdivideError::Edge(k));
        }
    }
    Ok(out)
}

/// An edge between two vertices that is cut: which cut it is, and the vertices at the ends of that, in its order.
type CutEdge = (usize, u32, u32);

struct Cutting<'a> {
    place_of: &'a [u32],
    cuts: &'a [Cut],
    /// For the two places of an edge, the lesser first, its cut.
    wanted: &'a HashMap<[u32; 2], usize>,
    /// Each once, rising.
    edges: Vec<CutEdge>,
    /// For each of them how many triangles have it.
    uses: Vec<u64>,
}

impl<'a> Cutting<'a> {
    fn new(
        triangles: &[[u32; 3]],
        place_of: &'a [u32],
        cuts: &'a [Cut],
        wanted: &'a HashMap<[u32; 2], usize>,
    ) -> Self {
        let mut out = Self { place_of, cuts, wanted, edges: Vec::new(), uses: Vec::new() };
        let all = triangles.iter().flat_map(|triangle| sides(*triangle));
        let mut all: Vec<CutEdge> = all.filter_map(|side| Some(out.edge(side)?.0)).collect();
        all.sort_unstable();
        for group in all.chunk_by(|a, b| a == b) {
            out.edges.extend(group.first());
            out.uses.push(group.len() as u64);
        }
        out
    }

    /// The cut edge that a side of a triangle is, and whether it runs against it.
    fn edge(&self, [v, w]: [u32; 2]) -> Option<(CutEdge, bool)> {
        let [p, q] = [v, w].map(|vertex| self.place_of[vertex as usize]);
        let cut = *self.wanted.get(&sorted([p, q]))?;
        Some(if self.cuts[cut].ends[0] == p { ((cut, v, w), false) } else { ((cut, w, v), true) })
    }

    fn check(&self, triangles: usize, places: usize, limits: SubdivideLimits) -> Result<(), SubdivideError> {
        let count = |cut: usize| self.cuts[cut].shares.len() as u64;
        let vertices = self.edges.iter().map(|edge| count(edge.0)).sum::<u64>() + self.place_of.len() as u64;
        let parts = self.edges.iter().zip(&self.uses).map(|(edge, uses)| uses * count(edge.0)).sum::<u64>();
        let triangles = triangles as u64 + parts;
        limits.check(vertices, triangles)?;
        // Places have 32 bits too.
        let places = (0..self.cuts.len()).map(count).sum::<u64>() + places as u64;
        SubdivideLimits { vertices: u64::MAX, ..limits }.check(places, triangles)
    }

    fn run(&self, triangles: &[[u32; 3]], places: usize) -> Subdivision {
        let mut out = Subdivision::default();
        let mut first_places = Vec::with_capacity(self.cuts.len());
        for Cut { ends, shares } in self.cuts {
            first_places.push((places + out.place_parents.len()) as u32);
            out.place_parents.extend(shares.iter().map(|_| *ends));
            out.place_shares.extend(shares);
        }
        // For each edge its new vertices.
        let mut new = Vec::with_capacity(self.edges.len());
        for &(cut, v, w) in &self.edges {
            let shares = &self.cuts[cut].shares;
            let first = (self.place_of.len() + out.parents.len()) as u32;
            new.push(first..first + shares.len() as u32);
            out.parents.extend(shares.iter().map(|_| [v, w]));
            out.shares.extend(shares);
            out.place_of.extend((first_places[cut]..).take(shares.len()));
        }
        for (source, &triangle) in (0..).zip(triangles) {
            self.split(triangle, &new, &mut out.triangles);
            out.sources.resize(out.triangles.len(), source);
        }
        out
    }

    /// Cuts a triangle at the new vertices of its sides, in an order that is the same whichever of its corners comes first.
    fn split(&self, triangle: [u32; 3], new: &[Range<u32>], parts: &mut Vec<[u32; 3]>) {
        let first = parts.len();
        parts.push(triangle);
        let cut = |side| self.edge(side).map(|(edge, is_turned)| (edge, is_turned, side));
        let mut cut_sides = sides(triangle).map(cut);
        cut_sides.sort_unstable();
        for (edge, is_turned, [u, w]) in cut_sides.into_iter().flatten() {
            let Ok(k) = self.edges.binary_search(&edge) else { continue };
            // An empty fan would still turn the triangle to another corner.
            if new[k].is_empty() {
                continue;
            }
            let whole = (first..parts.len()).find_map(|i| Some((i, opposite(parts[i], [u, w])?)));
            let Some((i, across)) = whole else { continue };
            let mut between: Vec<u32> = new[k].clone().collect();
            if is_turned {
                between.reverse();
            }
            let ends = between.iter().copied().chain([w]);
            let starts = [u].into_iter().chain(between.iter().copied());
            parts.splice(i..=i, starts.zip(ends).map(|(v, next)| [v, next, across]));
        }
    }
}

/// The corner across a side of a triangle.
fn opposite([a, b, c]: [u32; 3], side: [u32; 2]) -> Option<u32> {
    sides([a, b, c]).into_iter().zip([c, a, b]).find_map(|(own, across)| (own == side).then_some(across))
}
