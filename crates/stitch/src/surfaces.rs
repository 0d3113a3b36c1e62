//! The surfaces under a stitch: pieces of one list of points.

use std::collections::BTreeMap;

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
    /// Triangles between points of one piece each, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// For each point the number of its piece; a number beyond `sides` is of none. Empty: all points are piece 0.
    pub piece_of: &'a [u32],
    /// For each piece its sides as lists of points, if it has any: `UMin` and `UMax` in the direction of growing `v`, `VMin` and
    /// `VMax` in that of growing `u`.
    pub sides: &'a [Option<[Vec<u32>; 4]>],
}

/// One piece by itself.
pub(crate) struct Piece {
    /// Its points, rising.
    pub(crate) points: Vec<u32>,
    /// Its triangles, by those.
    triangles: Vec<[u32; 3]>,
    pub(crate) borders: Vec<Border>,
    /// Its largest extent.
    pub(crate) size: f32,
}

/// Pieces by their numbers, each taken out when it is asked for.
pub(crate) struct Pieces<'a> {
    pub(crate) surfaces: &'a Surfaces<'a>,
    pub(crate) list: Vec<Option<Piece>>,
}

impl Pieces<'_> {
    pub(crate) fn get(&mut self, number: usize) -> &Piece {
        if self.list.len() <= number {
            self.list.resize_with(number + 1, || None);
        }
        self.list[number].get_or_insert_with(|| self.surfaces.piece(number))
    }
}

impl Surfaces<'_> {
    /// Takes one piece out.
    pub(crate) fn piece(&self, piece: usize) -> Piece {
        let is_own = |point: u32| match self.piece_of.get(point as usize) {
            Some(&of) => of as usize == piece,
            None => self.piece_of.is_empty() && piece == 0,
        };
        let points: Vec<u32> = (0..self.positions.len() as u32).filter(|&point| is_own(point)).collect();
        let mut numbers = vec![u32::MAX; self.positions.len()];
        points.iter().zip(0..).for_each(|(&point, number)| numbers[point as usize] = number);
        let number = |point: u32| numbers.get(point as usize).copied().filter(|number| *number != u32::MAX);
        let own = |t: &[u32; 3]| Some([number(t[0])?, number(t[1])?, number(t[2])?]);
        let triangles: Vec<[u32; 3]> = self.triangles.iter().filter_map(own).collect();
        let mut borders = borders(&triangles);
        for border in &mut borders {
            border.vertices.iter_mut().for_each(|vertex| *vertex = points[*vertex as usize]);
            border.branch = border.branch.map(|vertex| points[vertex as usize]);
        }
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &point in &points {
            let p = self.at(point);
            (min, max) = (min.min(p), max.max(p));
        }
        let size = if points.is_empty() { 0.0 } else { (max - min).length() as f32 };
        Piece { points, triangles, borders, size }
    }

    pub(crate) fn at(&self, point: u32) -> DVec3 {
        self.positions.get(point as usize).map_or(DVec3::ZERO, |p| wide(*p))
    }
}

impl Piece {
    /// What the piece leads to within `radius` of some of its points in a row; all of it where it has no faces. With another such row it is
    /// shared between the two: where a slit is shut, the cloth on either side is to follow its own edge.
    pub(crate) fn near(
        &self,
        surfaces: &Surfaces<'_>,
        path: &[u32],
        beside: Option<&[u32]>,
        radius: f32,
    ) -> Near {
        let positions: Vec<[f32; 3]> =
            self.points.iter().map(|&point| surfaces.positions[point as usize]).collect();
        let Ok(terrain) = Terrain::unwelded(&positions, &self.triangles) else {
            return Near { vertices: self.points.clone(), factors: Vec::new() };
        };
        let local = |point: &u32| self.points.binary_search(point).ok().map(|local| local as u32);
        let line = |path: &[u32]| -> Vec<Step> {
            path.iter().filter_map(local).filter_map(|v| terrain.at_vertex(v)).collect()
        };
        let (radius, mut buffer) = (f64::from(radius), NearBuffer::default());
        let mut near = terrain.near(&line(path), radius, &mut buffer);
        if let Some(beside) = beside {
            let [own, other] =
                [path, beside].map(|path| terrain.ways(&line(path), REACH * radius, &mut buffer));
            share(&mut near, &own, &other);
        }
        near.vertices.iter_mut().for_each(|vertex| *vertex = self.points[*vertex as usize]);
        near
    }

    /// The triangles of the piece at each of some of its points.
    pub(crate) fn fans(&self, path: &[u32]) -> Vec<Vec<[u32; 3]>> {
        let places: BTreeMap<u32, usize> = path.iter().copied().zip(0..).collect();
        let mut fans = vec![Vec::new(); path.len()];
        for triangle in &self.triangles {
            let triangle = triangle.map(|v| self.points[v as usize]);
            for vertex in triangle {
                if let Some(&place) = places.get(&vertex) {
                    fans[place].push(triangle);
                }
            }
        }
        fans
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
