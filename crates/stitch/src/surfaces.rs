//! The surfaces under a stitch: pieces of one list of points.

use glam::DVec3;
use wirework_surface::{Near, NearBuffer, Step, Terrain};

use crate::border::{Border, borders};

/// Ways over the surface are compared up to so many radii, as far as an edge may act.
const REACH: f64 = 2.2;

/// Pieces as points and triangles. Points of two pieces may lie in one place and are two all the same.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// All points.
    pub positions: &'a [[f32; 3]],
    /// Triangles between points of one piece each, counter-clockwise seen from outside; others do not count.
    pub triangles: &'a [[u32; 3]],
    /// For each point the number of its piece, [`u32::MAX`] where it is of none. Empty: all points are piece 0.
    pub piece_of: &'a [u32],
    /// For each piece its sides as lists of points, if it has any: `UMin` and `UMax` in the direction of growing `v`, `VMin` and
    /// `VMax` in that of growing `u`. Pieces behind the end of the list have none.
    pub sides: &'a [Option<[Vec<u32>; 4]>],
}

/// One piece by itself.
pub(crate) struct Piece {
    /// Its points, rising.
    points: Vec<u32>,
    pub(crate) borders: Vec<Border>,
    /// Its largest extent.
    pub(crate) size: f32,
    /// Its surface, on its own points; none without faces.
    terrain: Option<Terrain>,
    buffer: NearBuffer,
}

/// Pieces by their numbers, each taken out when it is asked for.
pub(crate) struct Pieces<'a> {
    pub(crate) surfaces: &'a Surfaces<'a>,
    list: Vec<Option<Piece>>,
    /// The points of each piece, rising, and its triangles by those.
    parts: Vec<(Vec<u32>, Vec<[u32; 3]>)>,
}

impl<'a> Pieces<'a> {
    pub(crate) fn new(surfaces: &'a Surfaces<'a>) -> Self {
        let own = surfaces.piece_of.iter().filter(|piece| **piece != u32::MAX).max();
        let count = own.map_or(usize::from(surfaces.piece_of.is_empty()), |last| *last as usize + 1);
        // No more pieces than points, lest a number out of range take all memory.
        let count = count.min(surfaces.positions.len()).max(surfaces.sides.len());
        let mut parts = vec![(Vec::new(), Vec::new()); count];
        let piece_of = |point: u32| match surfaces.piece_of.get(point as usize) {
            Some(&piece) => piece as usize,
            None if surfaces.piece_of.is_empty() => 0,
            None => usize::MAX,
        };
        let mut numbers = Vec::with_capacity(surfaces.positions.len());
        for point in 0..surfaces.positions.len() as u32 {
            let Some((points, _)) = parts.get_mut(piece_of(point)) else {
                numbers.push(0);
                continue;
            };
            numbers.push(points.len() as u32);
            points.push(point);
        }
        for triangle in surfaces.triangles {
            let [a, b, c] = triangle.map(piece_of);
            // One that refers to no point is none.
            let there = triangle.iter().all(|point| (*point as usize) < numbers.len());
            if let Some((_, triangles)) = parts.get_mut(a).filter(|_| a == b && b == c && there) {
                triangles.push(triangle.map(|point| numbers[point as usize]));
            }
        }
        Self { surfaces, list: (0..count).map(|_| None).collect(), parts }
    }

    /// A piece; none that is not there.
    pub(crate) fn get(&mut self, number: usize) -> Option<&mut Piece> {
        let (surfaces, part) = (self.surfaces, self.parts.get_mut(number)?);
        let slot = self.list.get_mut(number)?;
        Some(slot.get_or_insert_with(|| Piece::new(surfaces, std::mem::take(part))))
    }
}

impl Surfaces<'_> {
    pub(crate) fn at(&self, point: u32) -> DVec3 {
        self.positions.get(point as usize).map_or(DVec3::ZERO, |p| wide(*p))
    }
}

impl Piece {
    fn new(surfaces: &Surfaces<'_>, (points, triangles): (Vec<u32>, Vec<[u32; 3]>)) -> Self {
        let mut borders = borders(&triangles);
        for border in &mut borders {
            border.vertices.iter_mut().for_each(|vertex| *vertex = points[*vertex as usize]);
            border.branch = border.branch.map(|vertex| points[vertex as usize]);
        }
        let positions: Vec<[f32; 3]> =
            points.iter().map(|&point| surfaces.positions[point as usize]).collect();
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in positions.iter().map(|p| wide(*p)) {
            (min, max) = (min.min(p), max.max(p));
        }
        let size = if points.is_empty() { 0.0 } else { (max - min).length() as f32 };
        let terrain = Terrain::unwelded(&positions, &triangles).ok();
        Self { points, borders, size, terrain, buffer: NearBuffer::default() }
    }

    fn local(&self, point: u32) -> Option<u32> {
        self.points.binary_search(&point).ok().map(|local| local as u32)
    }

    fn line(&self, path: &[u32]) -> Vec<Step> {
        let terrain = self.terrain.as_ref();
        path.iter().filter_map(|&point| terrain?.at_vertex(self.local(point)?)).collect()
    }

    /// What the piece leads to within `radius` of some of its points in a row; all of it where it has no faces. With another such row it is
    /// shared between the two: where a slit is shut, the cloth on either side is to follow its own edge.
    pub(crate) fn near(&mut self, path: &[u32], beside: Option<&[u32]>, radius: f32) -> Near {
        let (line, radius) = (self.line(path), f64::from(radius));
        let other = beside.map(|beside| self.line(beside));
        let Some(terrain) = &self.terrain else {
            return Near { vertices: self.points.clone(), factors: Vec::new() };
        };
        let mut near = terrain.near(&line, radius, &mut self.buffer);
        if let Some(other) = other {
            let [own, other] =
                [line, other].map(|line| terrain.ways(&line, REACH * radius, &mut self.buffer));
            share(&mut near, &own, &other);
        }
        near.vertices.iter_mut().for_each(|vertex| *vertex = self.points[*vertex as usize]);
        near
    }

    /// The triangles of the piece at each of some of its points.
    pub(crate) fn fans(&self, path: &[u32]) -> Vec<Vec<[u32; 3]>> {
        let fan = |&point: &u32| {
            let (Some(terrain), Some(local)) = (&self.terrain, self.local(point)) else { return Vec::new() };
            let corners = |&triangle: &u32| terrain.places_of(triangle).map(|v| self.points[v as usize]);
            terrain.fan(local).iter().map(corners).collect()
        };
        path.iter().map(fan).collect()
    }
}

/// Lowers the factors of vertices that are nearer to another line, by ways over the surface.
fn share(near: &mut Near, own: &[(u32, f64)], other: &[(u32, f64)]) {
    near.factors.resize(near.vertices.len(), 1.0);
    let way = |ways: &[(u32, f64)], vertex: u32| {
        let found = ways.binary_search_by_key(&vertex, |(vertex, _)| *vertex);
        found.map_or(f64::INFINITY, |at| ways[at].1)
    };
    for (factor, &vertex) in near.factors.iter_mut().zip(&near.vertices) {
        let (own, other) = (way(own, vertex), way(other, vertex));
        // 0 half-way or nearer to the own line, 1 where the other is three times as near.
        let x = match (own.is_finite(), other.is_finite()) {
            (true, true) if own > other => (2.0 * (own - other) / (own + other)).min(1.0),
            (false, true) => 1.0,
            _ => 0.0,
        };
        *factor *= (1.0 - x * x * (3.0 - 2.0 * x)) as f32;
    }
}

pub(crate) fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}
