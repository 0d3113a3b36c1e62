//! A surface with edges as short as is wanted, by halving edges; nothing that is there moves.
//!
//! Whether an edge is halved follows from its two ends alone, so that all triangles at it agree and no T-junction can
//! arise; and it is asked of *places*, which the vertices on both sides of a seam share, so that no crack can. A triangle
//! of which one, two or three edges are halved becomes two, three or four: two by the line to the opposite corner,
//! three by the shorter of the two possible diagonals, which is what halving the longer edge first gives, four by the
//! three middles. Each part has at least a quarter of the area, and at least about half of the smallest angle
//! ([RS75]: halving longest edges), and turns the same way. Rounds go on until every edge is short enough.
//!
//! The wanted length is a field over the surface: given at the corners, [graded](grade), and linear along edges, so that
//! it is the same field in every round. To let a new vertex want the lesser of what its parents want would never come
//! to an end: at a long edge that nobody wants shorter, ever shorter edges would meet ever flatter triangles.
//!
//! [RS75] I. Rosenberg, F. Stenger, "A lower bound on the angles of triangles constructed by bisecting the longest
//! side", Mathematics of Computation 29, 1975.

mod cut;
#[cfg(test)]
mod cut_tests;
mod grade;
mod mesh;
#[cfg(test)]
mod tests;

use glam::DVec3;
use thiserror::Error;

use crate::Distinct;
use crate::vector::{narrow, wide};
pub use cut::{Cut, cut_edges};
pub(crate) use grade::graded;
pub use mesh::MeshSubdivision;

/// An edge may be longer than wanted by this part of it, so that a mesh whose edges are just as long as wanted is left
/// alone: with f32 its edges are so only up to rounding. Without it the work could be four times as much for nothing.
const SLACK: f64 = 1e-4;
/// More than the edges that rounding keeps from being halved, in parts of the distance from the origin.
const STEPS_OF_F32: f64 = 64.0 * f32::EPSILON as f64;

/// An edge is not halved where a half, its end rounded to f32, would be longer than this part of it: what is a few steps
/// of f32 long gets no shorter, and would be halved for ever.
const HALF: f64 = 0.75;

/// How long edges may be.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Where something is, each place once: vertices at one place are on the two sides of a seam.
    pub places: &'a [[f32; 3]],
    /// For each vertex its place.
    pub place_of: &'a [u32],
    /// For each place the longest an edge there may be, above 0 and in the unit of the places; infinite where it does
    /// not matter.
    ///
    /// Between places it is at most linear, and grows by at most half of the way along edges. So a triangle gets no edge
    /// longer than *all* its corners want, but one whose corners do not care may be coarse in the middle: whoever wants
    /// fine triangles somewhere says so at all corners of the triangles there.
    pub longest: &'a [f32],
}

/// How much of it there may be, old and new together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubdivideLimits {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
}

impl SubdivideLimits {
    /// Refuses so many in all where they are too many.
    fn check(self, vertices: u64, triangles: u64) -> Result<(), SubdivideError> {
        // Indices have 32 bits.
        let most = self.vertices.min(u64::from(u32::MAX));
        if vertices <= most && triangles <= self.triangles {
            Ok(())
        } else {
            Err(SubdivideError::TooMany { vertices, triangles })
        }
    }
}

/// A finer surface, in terms of the one it is made from. Old vertices and places keep their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Subdivision {
    /// For each new vertex, numbered behind the old ones, the two that it lies between; both come before it. Vertices that
    /// share a place have parents that share theirs.
    pub parents: Vec<[u32; 2]>,
    /// For each new vertex how far it lies from its first parent towards the second, as a part of the way from 0 to 1;
    /// empty where all lie in the middle.
    pub shares: Vec<f64>,
    /// For each new vertex its place.
    pub place_of: Vec<u32>,
    /// For each new place, numbered behind the old ones, the two that it lies between.
    pub place_parents: Vec<[u32; 2]>,
    /// The same of new places as [`Subdivision::shares`] of new vertices.
    pub place_shares: Vec<f64>,
    /// All triangles, those of one old triangle together, in the order of the old ones.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the old one that it is, or is a part of; rising.
    pub sources: Vec<u32>,
}

/// Why a surface cannot be subdivided.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SubdivideError {
    /// Lists of places, or an index, do not fit each other.
    #[error("{what} {index} is beyond the {count} there are")]
    Index {
        /// `"place"` or `"vertex"`.
        what: &'static str,
        /// The index, or the length of a list.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A wanted length is not above 0, or a place is not finite.
    #[error("place {0} is not finite, or its wanted length is not above 0")]
    Place(usize),
    /// An edge that is to be cut is none of the surface's, or is another cut's too.
    #[error("cut {0} is of an edge that is not there, or that is cut already")]
    Edge(usize),
    /// Where an edge is to be cut is not between its ends, or not in order.
    #[error("the shares of cut {0} do not rise from 0 to 1, both left out")]
    Shares(usize),
    /// The mesh is not consistent.
    #[error(transparent)]
    Mesh(#[from] crate::MeshError),
    /// There would be too many vertices or triangles.
    #[error("the subdivided surface has {vertices} vertices and {triangles} triangles, or more")]
    TooMany {
        /// As many as had been counted then, old ones too: there may be more.
        vertices: u64,
        /// The same of triangles.
        triangles: u64,
    },
}

/// Halves edges until each is at most as long as both its ends want.
///
/// The result does not depend on the order of the triangles, but for their own order: new vertices are numbered by the
/// places of their parents, round by round. An edge of a few steps of f32 stays. A surface fine enough comes
/// back as it is.
///
/// # Errors
///
/// [`SubdivideError`]; more than `limits` allow, before room for it is taken.
pub fn subdivide(
    triangles: &[[u32; 3]],
    wanted: &Wanted<'_>,
    limits: SubdivideLimits,
) -> Result<Subdivision, SubdivideError> {
    check(triangles.as_flattened(), wanted)?;
    let place = |&v: &u32| wanted.place_of[v as usize];
    let edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(|t| sides(*t).map(|edge| edge.map(|v| place(&v)))).collect();
    let at: Vec<DVec3> = wanted.places.iter().map(|&p| wide(p)).collect();
    let longest = graded(&at, wanted.longest, &edges);
    let count = wanted.place_of.len();
    Halving { at, longest, place_of: wanted.place_of.to_vec(), old: count, limits }.run(triangles)
}

/// The same for vertices with a wanted length each. Those whose positions are equal are at one place, where the least
/// of their lengths counts.
///
/// # Errors
///
/// As [`subdivide`].
pub fn subdivide_vertices(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    longest: &[f32],
    limits: SubdivideLimits,
) -> Result<Subdivision, SubdivideError> {
    if positions.len() != longest.len() {
        return Err(SubdivideError::Index { what: "vertex", index: longest.len(), count: positions.len() });
    }
    let Distinct { of, first } = Distinct::new(positions.len(), |i| positions[i]);
    let places: Vec<[f32; 3]> = first.iter().map(|&vertex| positions[vertex as usize]).collect();
    let mut least = vec![f32::INFINITY; places.len()];
    for (&place, &wanted) in of.iter().zip(longest) {
        let slot = &mut least[place as usize];
        // What is not above 0 stays, for it is refused.
        *slot = if wanted > *slot { *slot } else { wanted };
    }
    subdivide(triangles, &Wanted { places: &places, place_of: &of, longest: &least }, limits)
}

impl Subdivision {
    /// Whether nothing is new.
    pub fn is_empty(&self) -> bool {
        self.parents.is_empty()
    }

    /// Behind the old positions that of each new place or vertex between its parents, rounded once: equal parents and
    /// shares give equal positions, bit for bit. Without `shares` it is the middle.
    pub fn between(positions: &[[f32; 3]], parents: &[[u32; 2]], shares: &[f64]) -> Vec<[f32; 3]> {
        let mut out = Vec::with_capacity(positions.len() + parents.len());
        out.extend_from_slice(positions);
        for (&[a, b], share) in parents.iter().zip(shares_or_half(shares)) {
            out.push(narrow(mix(wide(out[a as usize]), wide(out[b as usize]), share)));
        }
        out
    }

    /// How far each new vertex lies from its first parent towards the second: [`Subdivision::shares`], or half for all.
    pub fn vertex_shares(&self) -> impl Iterator<Item = f64> {
        shares_or_half(&self.shares).take(self.parents.len())
    }
}

/// As many halves as are asked for where there are no shares.
fn shares_or_half(shares: &[f64]) -> impl Iterator<Item = f64> {
    let halves = if shares.is_empty() { usize::MAX } else { 0 };
    shares.iter().copied().chain(std::iter::repeat_n(0.5, halves))
}

/// What lies between two. At half the products are exact, so that it is the bits of half their sum.
fn mix(p: DVec3, q: DVec3, share: f64) -> DVec3 {
    p * (1.0 - share) + q * share
}

fn check(vertices: &[u32], wanted: &Wanted<'_>) -> Result<(), SubdivideError> {
    let Wanted { places, place_of, longest } = wanted;
    let beyond = |what, index, count| Err(SubdivideError::Index { what, index, count });
    if longest.len() != places.len() {
        return beyond("place", longest.len(), places.len());
    }
    if let Some(&place) = place_of.iter().find(|&&place| place as usize >= places.len()) {
        return beyond("place", place as usize, places.len());
    }
    if let Some(&vertex) = vertices.iter().find(|&&v| v as usize >= place_of.len()) {
        return beyond("vertex", vertex as usize, place_of.len());
    }
    let bad = |(p, &length): (&[f32; 3], &f32)| {
        let finite = p.iter().all(|c| c.is_finite());
        !finite || length.is_nan() || length <= 0.0
    };
    places.iter().zip(*longest).position(bad).map_or(Ok(()), |place| Err(SubdivideError::Place(place)))
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn middle(p: DVec3, q: DVec3) -> DVec3 {
    (p + q) * 0.5
}

/// An edge between two vertices: their places, the lesser first, then the vertices in the same order.
type Edge = (u32, u32, u32, u32);

/// The work between rounds.
pub(crate) struct Halving {
    /// Where the places are, and how long edges may be there.
    pub(crate) at: Vec<DVec3>,
    pub(crate) longest: Vec<f64>,
    /// Of the vertices.
    pub(crate) place_of: Vec<u32>,
    /// How many vertices there were.
    pub(crate) old: usize,
    pub(crate) limits: SubdivideLimits,
}

impl Halving {
    pub(crate) fn run(mut self, triangles: &[[u32; 3]]) -> Result<Subdivision, SubdivideError> {
        self.check_areas(triangles)?;
        let places = self.at.len();
        let (mut parents, mut place_parents) = (Vec::new(), Vec::new());
        let mut done: Vec<(u32, [u32; 3])> = Vec::with_capacity(triangles.len());
        let mut open: Vec<(u32, [u32; 3])> = (0..).zip(triangles.iter().copied()).collect();
        loop {
            let mut edges = self.long_edges(&open);
            if edges.is_empty() {
                break;
            }
            // Each of them makes its triangle two.
            let triangles = done.len() + open.len() + edges.len();
            edges.sort_unstable();
            edges.dedup();
            self.count(edges.len(), triangles)?;
            let first = self.place_of.len() as u32;
            self.halve(&edges, &mut parents, &mut place_parents);
            let middle_of = |edge| edges.binary_search(&edge).ok().map(|k| first + k as u32);
            let mut parts = Vec::with_capacity(2 * open.len());
            for (source, triangle) in open.drain(..) {
                let middles = sides(triangle).map(|side| middle_of(self.edge(side)));
                if middles == [None; 3] {
                    done.push((source, triangle));
                } else {
                    self.cut(triangle, middles, |part| parts.push((source, part)));
                }
            }
            open = parts;
        }
        done.append(&mut open);
        // A stable sort: the parts of a triangle in the order in which they came.
        done.sort_by_key(|(source, _)| *source);
        let place_of = self.place_of.split_off(self.old);
        debug_assert_eq!(self.at.len(), places + place_parents.len());
        let (sources, triangles) = done.into_iter().unzip();
        Ok(Subdivision { parents, place_of, place_parents, triangles, sources, ..Subdivision::default() })
    }

    /// Refuses before anything is made what the areas alone say will be too many triangles: none of those that come out of one
    /// is larger than an equilateral one of the longest edge that its corners want.
    fn check_areas(&self, triangles: &[[u32; 3]]) -> Result<(), SubdivideError> {
        let least = |triangle: &[u32; 3]| {
            let places = triangle.map(|v| self.place_of[v as usize] as usize);
            let corners = places.map(|place| self.at[place]);
            let [a, b, c] = corners;
            let wanted =
                places.into_iter().map(|place| self.longest[place]).fold(0.0, f64::max) * (1.0 + SLACK);
            // Edges of a few steps of f32 stay, however short they are wanted.
            let step = corners.into_iter().map(DVec3::length).fold(0.0, f64::max) * STEPS_OF_F32;
            let largest = 3.0_f64.sqrt() / 4.0 * wanted.max(step).powi(2);
            let parts = (b - a).cross(c - a).length() / 2.0 / largest;
            if parts > 1.0 { parts } else { 1.0 }
        };
        let least: f64 = triangles.iter().map(least).sum();
        self.count(0, least as usize)
    }

    fn edge(&self, [v, w]: [u32; 2]) -> Edge {
        let (p, q) = (self.place_of[v as usize], self.place_of[w as usize]);
        if p <= q { (p, q, v, w) } else { (q, p, w, v) }
    }

    /// Whether the edge between two places is to be halved.
    pub(crate) fn is_long(&self, p: u32, q: u32) -> bool {
        let (p, q) = (p as usize, q as usize);
        let (a, b) = (self.at[p], self.at[q]);
        let least = self.longest[p].min(self.longest[q]) * (1.0 + SLACK);
        let length = a.distance_squared(b);
        length > least * least && {
            let between = wide(narrow(middle(a, b)));
            a.distance_squared(between).max(b.distance_squared(between)) <= HALF * HALF * length
        }
    }

    /// The edges of some triangles that are to be halved, each once for every triangle at it.
    fn long_edges(&self, open: &[(u32, [u32; 3])]) -> Vec<Edge> {
        let all = open.iter().flat_map(|(_, triangle)| sides(*triangle)).map(|side| self.edge(side));
        all.filter(|&(p, q, ..)| self.is_long(p, q)).collect()
    }

    /// Refuses so many more vertices, and so many triangles in all, where they are too many.
    fn count(&self, more: usize, triangles: usize) -> Result<(), SubdivideError> {
        self.limits.check(self.place_of.len() as u64 + more as u64, triangles as u64)
    }

    /// Adds the middles of edges, which are sorted: those of one pair of places share a place.
    fn halve(&mut self, edges: &[Edge], parents: &mut Vec<[u32; 2]>, place_parents: &mut Vec<[u32; 2]>) {
        for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let &[(p, q, ..), ..] = group else { continue };
            let place = self.at.len() as u32;
            place_parents.push([p, q]);
            let (p, q) = (p as usize, q as usize);
            self.at.push(wide(narrow(middle(self.at[p], self.at[q]))));
            // Neither is infinite: what an end wants has been taken on to the other.
            self.longest.push((self.longest[p] + self.longest[q]) * 0.5);
            for &(_, _, v, w) in group {
                parents.push([v, w]);
                self.place_of.push(place);
            }
        }
    }

    /// Cuts a triangle at the middles of its sides.
    fn cut(&self, [a, b, c]: [u32; 3], [ab, bc, ca]: [Option<u32>; 3], mut part: impl FnMut([u32; 3])) {
        match (ab, bc, ca) {
            (None, None, None) => part([a, b, c]),
            (Some(m), None, None) => [[a, m, c], [m, b, c]].into_iter().for_each(part),
            (None, Some(m), None) => [[b, m, a], [m, c, a]].into_iter().for_each(part),
            (None, None, Some(m)) => [[c, m, b], [m, a, b]].into_iter().for_each(part),
            (None, Some(m), Some(n)) => self.cut_corner([a, b, m, n], c, part),
            (Some(n), None, Some(m)) => self.cut_corner([b, c, m, n], a, part),
            (Some(m), Some(n), None) => self.cut_corner([c, a, m, n], b, part),
            (Some(ab), Some(bc), Some(ca)) => {
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().for_each(part);
            }
        }
    }

    /// Cuts a corner off, and the quadrangle `a b m n` that is left along its shorter diagonal; where both are as long
    /// along the one from the lesser position, which does not depend on numbers.
    fn cut_corner(&self, [a, b, m, n]: [u32; 4], corner: u32, mut part: impl FnMut([u32; 3])) {
        let at = |v: u32| self.at[self.place_of[v as usize] as usize];
        let (from_a, from_b) = (at(a).distance_squared(at(m)), at(b).distance_squared(at(n)));
        let order = from_a.total_cmp(&from_b).then_with(|| lesser(at(a), at(b)));
        part([n, m, corner]);
        if order.is_le() {
            [[a, b, m], [a, m, n]].into_iter().for_each(part);
        } else {
            [[a, b, n], [b, m, n]].into_iter().for_each(part);
        }
    }
}

fn lesser(p: DVec3, q: DVec3) -> std::cmp::Ordering {
    p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z))
}
