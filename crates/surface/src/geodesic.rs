//! Straightest lines on a surface.
//!
//! A walker goes straight ahead: its heading goes along with the least rotation from normal to normal (parallel transport), where
//! normals are those of the vertices, interpolated; in each triangle it walks as the heading is when turned into its plane.
//!
//! Polthier and Schmies, "Straightest geodesics on polyhedral surfaces" (1998), unfold the triangles instead, which is exact
//! on the polyhedron. But there all curvature sits in the vertices: a line that passes a row of them on one side is off by a term
//! in the length of an edge, and bends with the triangulation. Here the error is of second order in that length. On flat and on
//! prismatic surfaces both are exact. Looking at the normal in the middle of each step gained nothing.

use glam::DVec3;

use crate::adjacency::{Adjacency, BORDER, CROWDED, proper};
use crate::smooth::{fan_normal, smooth_normals};
use crate::vector::wide;
use crate::{NearestError, SurfacePoint};

/// A place this near a corner, in parts of the triangle, is the corner: beyond lies rounding.
const CORNER: f64 = 1.0 - 1e-9;
/// A triangle of less than this part of its longest side squared has no direction.
const SLIVER: f64 = 1e-12;
/// A heading may leave the triangles round a corner by this sine before it counts as leaving the surface.
const OUTSIDE: f64 = 1e-6;
/// Steps without progress after which a walker gives up: more than any sound fan of triangles needs.
const STUCK: usize = 256;
/// Interpolated normals shorter than this have cancelled.
const CANCELLED: f64 = 1e-3;

/// A surface to walk on.
#[derive(Clone, Debug)]
pub struct Terrain {
    pub(crate) adjacency: Adjacency,
    pub(crate) positions: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
}

/// A point of a surface by its material, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The triangle it lies in.
    pub triangle: u32,
    /// Weights of the triangle's corners, each 0 or more, adding up to 1.
    pub weights: [f64; 3],
    /// The point itself.
    pub position: [f64; 3],
}

/// Why a walk ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// It is as long as it was to be.
    Arrived,
    /// The surface ends here.
    Border,
    /// Three or more triangles meet here, or two whose outsides differ: there is no one way ahead.
    NonManifold,
}

/// Someone on a surface, with a heading.
#[derive(Clone, Debug)]
pub struct Walker<'a> {
    terrain: &'a Terrain,
    triangle: u32,
    weights: DVec3,
    from: From,
    /// Of length 1.
    normal: DVec3,
    /// Of length 1, perpendicular to the normal.
    heading: DVec3,
}

/// How a triangle was entered, and so by which edges it may be left.
#[derive(Clone, Copy, Debug, PartialEq)]
enum From {
    Inside,
    /// Across the edge from this corner to the next.
    Edge(usize),
    Corner(usize),
}

impl Terrain {
    /// Makes a surface ready. Vertices at equal positions are one; triangles may be without area.
    ///
    /// # Errors
    ///
    /// There are no triangles, or one refers to a vertex that is missing or not finite.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, NearestError> {
        crate::nearest::check(positions, triangles)?;
        let normals = smooth_normals(positions, triangles);
        Ok(Self {
            adjacency: Adjacency::new(positions, triangles),
            positions: positions.iter().copied().map(wide).collect(),
            normals: normals.into_iter().map(wide).collect(),
        })
    }

    /// A walker at a point of the surface that looks along `heading`, laid into the tangent plane. `None` where the
    /// surface has no normal, or the heading has nothing along the surface.
    pub fn walker(&self, at: &SurfacePoint, heading: [f64; 3]) -> Option<Walker<'_>> {
        self.adjacency.triangles.get(at.triangle as usize)?;
        self.walker_at(&self.step(at), heading)
    }

    /// The same at a point that another walker has come to.
    pub fn walker_at(&self, at: &Step, heading: [f64; 3]) -> Option<Walker<'_>> {
        let weights = DVec3::from(at.weights);
        self.adjacency.triangles.get(at.triangle as usize)?;
        let normal = self.normal(at.triangle, weights)?;
        let heading = DVec3::from(heading).try_normalize()?;
        let flat = heading - normal * heading.dot(normal);
        if flat.length() < OUTSIDE {
            return None;
        }
        let heading = flat.normalize();
        Some(Walker { terrain: self, triangle: at.triangle, weights, from: From::Inside, normal, heading })
    }

    /// How many vertices there are.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// The edges of a triangle, each from a corner to the next; none for a triangle that is not there.
    pub fn edges(&self, triangle: u32) -> impl Iterator<Item = [f64; 3]> {
        let corners = self.adjacency.triangles.get(triangle as usize).map(|_| self.corners(triangle));
        corners.into_iter().flat_map(|c| [0, 1, 2].map(|i| (c[(i + 1) % 3] - c[i]).to_array()))
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    ///
    /// There is no such triangle.
    pub fn corners_of(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.corners(triangle).map(|corner| corner.to_array())
    }

    /// The vertices of a triangle, of several at one position always the first.
    ///
    /// # Panics
    ///
    /// There is no such triangle.
    pub fn places_of(&self, triangle: u32) -> [u32; 3] {
        self.adjacency.triangles[triangle as usize]
    }

    /// The vertices at one position with a vertex, itself among them.
    ///
    /// # Panics
    ///
    /// There is no such vertex.
    pub fn at_place(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let place = self.adjacency.place_of[vertex as usize];
        std::iter::once(place).chain(self.adjacency.split(place).iter().map(|(_, vertex)| *vertex))
    }

    /// The corners of all triangles that meet in a vertex, with all vertices at their positions; some more than once.
    ///
    /// # Panics
    ///
    /// There is no such vertex.
    pub fn around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let fan = self.adjacency.fan(self.adjacency.place_of[vertex as usize]);
        let corners = fan.iter().flat_map(|&triangle| self.adjacency.triangles[triangle as usize]);
        corners.flat_map(|corner| self.at_place(corner))
    }

    /// The triangles across the edges of a triangle, where there is just one.
    ///
    /// # Panics
    ///
    /// There is no such triangle.
    pub fn neighbours(&self, triangle: u32) -> impl Iterator<Item = u32> {
        [0, 1, 2]
            .into_iter()
            .map(move |edge| self.adjacency.across(triangle, edge))
            .filter(|next| *next < CROWDED)
    }

    /// The shell of each vertex: those that faces connect have one number. A vertex without faces has [`u32::MAX`].
    pub fn shells(&self) -> Vec<u32> {
        let mut shells = vec![u32::MAX; self.positions.len()];
        let (mut next, mut stack) = (0, Vec::new());
        for place in 0..shells.len() as u32 {
            if shells[place as usize] != u32::MAX || self.adjacency.fan(place).is_empty() {
                continue;
            }
            shells[place as usize] = next;
            stack.push(place);
            while let Some(place) = stack.pop() {
                let corners = self.adjacency.fan(place).iter();
                for corner in corners.flat_map(|&triangle| self.adjacency.triangles[triangle as usize]) {
                    if shells[corner as usize] == u32::MAX {
                        shells[corner as usize] = next;
                        stack.push(corner);
                    }
                }
            }
            next += 1;
        }
        for (vertex, &place) in self.adjacency.place_of.iter().enumerate() {
            shells[vertex] = shells[place as usize];
        }
        shells
    }

    /// A point that was found on the surface.
    pub fn step(&self, at: &SurfacePoint) -> Step {
        let weights = DVec3::from(at.barycentric.map(f64::from));
        // Rounded to f32 the weights add up to 1 only nearly, which far from the origin would be seen.
        let weights = (weights / weights.element_sum()).to_array();
        Step { triangle: at.triangle, weights, position: wide(at.position).to_array() }
    }

    /// The outward unit normal at a point of the surface, between those of the vertices; the triangle's own where these cancel,
    /// `None` where that has no area either.
    pub fn normal_at(&self, step: &Step) -> Option<[f64; 3]> {
        self.normal(step.triangle, DVec3::from(step.weights)).map(|normal| normal.to_array())
    }

    /// A point in the plane of a triangle as a point of the triangle; `None` where that has no area.
    pub fn within(&self, triangle: u32, point: [f64; 3]) -> Option<Step> {
        let corners = self.corners(triangle);
        let facet = Facet::new(corners)?;
        let weights = facet.rates(DVec3::from(point) - corners[0]) + DVec3::X;
        let weights = weights.max(DVec3::ZERO);
        let weights = weights / weights.element_sum();
        let position = self.position(triangle, weights).to_array();
        Some(Step { triangle, weights: weights.to_array(), position })
    }

    /// Where a point of the surface is, and its normal, when the vertices have moved to `positions`; `None` where it has no
    /// normal, or vertices are missing.
    pub fn moved(
        &self,
        triangle: u32,
        weights: [f64; 3],
        positions: &[[f32; 3]],
    ) -> Option<([f64; 3], [f64; 3])> {
        let corners = *self.adjacency.triangles.get(triangle as usize)?;
        let (mut position, mut normal) = (DVec3::ZERO, DVec3::ZERO);
        for (place, weight) in corners.into_iter().zip(weights) {
            position += wide(*positions.get(place as usize)?) * weight;
            normal += self.normal_of(place, positions) * weight;
        }
        if normal.length() <= CANCELLED {
            let [a, b, c] = corners.map(|place| positions.get(place as usize).copied().map(wide));
            normal = (b? - a?).cross(c? - a?);
        }
        Some((position.to_array(), normal.try_normalize()?.to_array()))
    }

    /// The normal of a place when the vertices have moved: that of [`smooth_normals`].
    fn normal_of(&self, place: u32, positions: &[[f32; 3]]) -> DVec3 {
        let fan = self.adjacency.fan(place).iter();
        fan_normal(fan.filter_map(|&triangle| {
            let corners = self.adjacency.triangles[triangle as usize];
            let k = corners.iter().position(|&corner| corner == place)?;
            let at = |i: usize| positions.get(corners[i] as usize).copied().map(wide);
            Some(([at(0)?, at(1)?, at(2)?], k))
        }))
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.adjacency.triangles[triangle as usize].map(|place| self.positions[place as usize])
    }

    fn position(&self, triangle: u32, weights: DVec3) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        a * weights.x + b * weights.y + c * weights.z
    }

    /// The interpolated unit normal; the triangle's own where that has cancelled. `None` where there is neither.
    pub(crate) fn normal(&self, triangle: u32, weights: DVec3) -> Option<DVec3> {
        let [a, b, c] = self.adjacency.triangles[triangle as usize].map(|place| self.normals[place as usize]);
        let normal = a * weights.x + b * weights.y + c * weights.z;
        if normal.length() > CANCELLED {
            return Some(normal.normalize());
        }
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).try_normalize()
    }
}

impl Walker<'_> {
    /// Where it is.
    pub fn step(&self) -> Step {
        let position = self.position().to_array();
        Step { triangle: self.triangle, weights: self.weights.to_array(), position }
    }

    /// The outward unit normal where it is.
    pub fn normal(&self) -> [f64; 3] {
        self.normal.to_array()
    }

    /// The way it looks, of length 1, in the tangent plane.
    pub fn heading(&self) -> [f64; 3] {
        self.heading.to_array()
    }

    /// Turns by an angle in radians, counter-clockwise seen from outside.
    pub fn turn(&mut self, angle: f64) {
        let (sin, cos) = angle.sin_cos();
        self.heading = (self.heading * cos + self.normal.cross(self.heading) * sin).normalize();
        // It may look out of the triangle that it stood ready to cross.
        self.from = From::Inside;
    }

    /// Walks straight ahead over `distance`, in the unit of the surface; `seen` is called at every edge that is crossed, and at
    /// the end, with the way so far. Returns the way in all and why it ended.
    pub fn walk(&mut self, distance: f64, mut seen: impl FnMut(f64, Step)) -> (f64, Stop) {
        let (mut walked, mut idle) = (0.0, 0);
        while walked < distance {
            if let Err(stop) = self.enter() {
                return (walked, stop);
            }
            let way = self.cross(distance - walked);
            walked += way;
            if way > 0.0 {
                idle = 0;
                seen(walked, self.step());
            } else {
                idle += 1;
                if idle > STUCK {
                    return (walked, Stop::NonManifold);
                }
            }
            if walked < distance
                && let Err(stop) = self.leave()
            {
                return (walked, stop);
            }
        }
        (walked, Stop::Arrived)
    }

    fn position(&self) -> DVec3 {
        self.terrain.position(self.triangle, self.weights)
    }

    /// On a corner chooses the triangle ahead.
    fn enter(&mut self) -> Result<(), Stop> {
        let corner = (0..3).find(|&i| self.weights[i] >= CORNER);
        match (corner, self.from) {
            (Some(corner), From::Inside | From::Edge(_)) => self.choose(corner),
            _ => Ok(()),
        }
    }

    /// Chooses the triangle round a corner into which the heading points, seen along the normal.
    fn choose(&mut self, corner: usize) -> Result<(), Stop> {
        let adjacency = &self.terrain.adjacency;
        let place = adjacency.triangles[self.triangle as usize][corner];
        let before = self.triangle;
        self.face(corner);
        let left = self.normal.cross(self.heading);
        let here = self.terrain.positions[place as usize];
        let mut best = (-OUTSIDE, None);
        for &triangle in adjacency.fan(place) {
            let corners = adjacency.triangles[triangle as usize];
            let Some(k) = (0..3).find(|&k| corners[k] == place) else { continue };
            let side = |step: usize| {
                let edge = self.terrain.positions[corners[(k + step) % 3] as usize] - here;
                let flat = edge - self.normal * edge.dot(self.normal);
                (flat.dot(self.heading), flat.dot(left), flat.length())
            };
            let ((x, y, r), (p, q, s)) = (side(1), side(2));
            // Counter-clockwise from an edge on the right to one on the left, less than half a turn.
            let margin = (-y / r).min(q / s);
            if margin > best.0 && x * q - y * p > 0.0 && (x > 0.0 || p > 0.0) {
                best = (margin, Some((triangle, k)));
            }
        }
        let Some((triangle, k)) = best.1.filter(|(ahead, _)| self.joined(place, before, *ahead)) else {
            return Err(self.edge_of(place));
        };
        (self.triangle, self.from) = (triangle, From::Corner(k));
        self.weights = DVec3::AXES[k];
        Ok(())
    }

    /// Whether one comes from one triangle at a corner to another round it, by edges of two triangles that agree about the outside.
    fn joined(&self, place: u32, from: u32, to: u32) -> bool {
        let adjacency = &self.terrain.adjacency;
        // One that has a corner twice has no neighbours.
        if !proper(adjacency.triangles[from as usize]) {
            return true;
        }
        [0, 2].into_iter().any(|side| {
            let mut triangle = from;
            for _ in adjacency.fan(place) {
                if triangle == to {
                    return true;
                }
                let corners = adjacency.triangles[triangle as usize];
                let Some(k) = corners.iter().position(|&corner| corner == place) else { return false };
                triangle = adjacency.across(triangle, (k + side) % 3);
                if triangle >= CROWDED {
                    return false;
                }
            }
            triangle == to
        })
    }

    /// Why there is no way ahead at a corner.
    fn edge_of(&self, place: u32) -> Stop {
        let adjacency = &self.terrain.adjacency;
        let crowded = |&t: &u32| (0..3).any(|edge| adjacency.across(t, edge) == CROWDED);
        if adjacency.fan(place).iter().any(crowded) { Stop::NonManifold } else { Stop::Border }
    }

    /// Takes the heading to the normal of a corner.
    fn face(&mut self, corner: usize) {
        self.weights = DVec3::AXES[corner];
        if let Some(normal) = self.terrain.normal(self.triangle, self.weights) {
            self.lean(normal);
        }
    }

    /// Parallel transport: the heading goes along with the least rotation from the normal to another.
    fn lean(&mut self, normal: DVec3) {
        let heading = transport(self.heading, self.normal, normal);
        (self.normal, self.heading) = (normal, heading);
    }

    /// Crosses the present triangle, or a part of it as long as `most`, and returns the way.
    fn cross(&mut self, most: f64) -> f64 {
        let corners = self.terrain.corners(self.triangle);
        let Some(facet) = Facet::new(corners) else { return self.cross_sliver(corners) };
        let way = facet.way(self.weights, self.from, transport(self.heading, self.normal, facet.normal));
        let length = way.length.min(most);
        let mut weights = (self.weights + way.rates * length).max(DVec3::ZERO);
        if length == way.length {
            weights[way.opposite] = 0.0;
        }
        self.weights = weights / weights.element_sum();
        if let Some(normal) = self.terrain.normal(self.triangle, self.weights) {
            self.lean(normal);
        }
        self.from = if length == way.length { From::Edge((way.opposite + 1) % 3) } else { From::Inside };
        length
    }

    /// A triangle without area is a line: it is left at the same place by another edge.
    fn cross_sliver(&mut self, corners: [DVec3; 3]) -> f64 {
        let here = self.position();
        let entered = if let From::Edge(edge) = self.from { edge } else { 3 };
        let others = (0..3).filter(|&edge| edge != entered);
        let nearest = others
            .map(|edge| {
                let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
                let along = (b - a).length_squared();
                let x = if along > 0.0 { ((here - a).dot(b - a) / along).clamp(0.0, 1.0) } else { 0.0 };
                (here.distance(a.lerp(b, x)), edge, x)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, edge, x)) = nearest {
            self.weights = DVec3::ZERO;
            self.weights[edge] = 1.0 - x;
            self.weights[(edge + 1) % 3] = x;
            self.from = From::Edge(edge);
        }
        0.0
    }

    /// Steps over the edge on which it stands into the next triangle.
    fn leave(&mut self) -> Result<(), Stop> {
        let From::Edge(edge) = self.from else { return Ok(()) };
        if self.weights.max_element() >= CORNER {
            return Ok(());
        }
        let adjacency = &self.terrain.adjacency;
        let next = match adjacency.across(self.triangle, edge) {
            BORDER => return Err(Stop::Border),
            CROWDED => return Err(Stop::NonManifold),
            next => next,
        };
        let corners = adjacency.triangles[self.triangle as usize];
        let beyond = adjacency.triangles[next as usize];
        let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
        let Some(k) = (0..3).find(|&k| beyond[k] == b && beyond[(k + 1) % 3] == a) else {
            return Err(Stop::NonManifold);
        };
        let mut weights = DVec3::ZERO;
        weights[k] = self.weights[(edge + 1) % 3];
        weights[(k + 1) % 3] = self.weights[edge];
        (self.triangle, self.weights, self.from) = (next, weights, From::Edge(k));
        Ok(())
    }
}

/// A direction in the tangent plane of `from` as it is in that of `to`: the least rotation between the two.
fn transport(direction: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let (axis, cos) = (from.cross(to), from.dot(to));
    let turned = if cos > -0.9 {
        direction * cos + axis.cross(direction) + axis * (axis.dot(direction) / (1.0 + cos))
    } else {
        // No direction of turning is least: what lies along the surface stays.
        direction
    };
    let flat = turned - to * turned.dot(to);
    flat.try_normalize().unwrap_or(direction)
}

/// A triangle with an area.
struct Facet {
    corners: [DVec3; 3],
    normal: DVec3,
    /// Twice its area.
    area: f64,
}

/// A way across a triangle.
struct Way {
    /// Change of the corners' weights in a unit of length.
    rates: DVec3,
    length: f64,
    /// The corner opposite the edge where it leaves.
    opposite: usize,
}

impl Facet {
    fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let area = normal.length();
        (area > SLIVER * longest && area > 0.0).then(|| Self { corners, normal: normal / area, area })
    }

    fn rates(&self, direction: DVec3) -> DVec3 {
        let rate = |i: usize| {
            let edge = self.corners[(i + 2) % 3] - self.corners[(i + 1) % 3];
            edge.cross(direction).dot(self.normal) / self.area
        };
        DVec3::new(rate(0), rate(1), rate(2))
    }

    /// The way from `weights` along a unit direction in the plane to an edge by which it may be left.
    fn way(&self, weights: DVec3, from: From, direction: DVec3) -> Way {
        let mut rates = self.rates(direction);
        let entered = if let From::Edge(edge) = from { Some((edge + 2) % 3) } else { None };
        if let Some(corner) = entered.filter(|&corner| rates[corner] <= 0.0) {
            // Back over the edge that was crossed: only rounding and leaning normals ask for that. Along it, then.
            let (a, b) = (self.corners[(corner + 1) % 3], self.corners[(corner + 2) % 3]);
            let edge = (b - a).normalize();
            rates = self.rates(if edge.dot(direction) < 0.0 { -edge } else { edge });
            rates[corner] = 0.0;
        }
        let allowed = |&corner: &usize| match from {
            From::Corner(own) => corner == own,
            _ => Some(corner) != entered,
        };
        let exit = |corner: usize| (rates[corner] < 0.0).then(|| (weights[corner] / -rates[corner], corner));
        let exits = (0..3).filter(allowed).filter_map(exit);
        // None only by rounding; then it stays, on the edge that is nearest.
        let stay = || {
            (
                0.0,
                if weights.x <= weights.y.min(weights.z) {
                    0
                } else if weights.y <= weights.z {
                    1
                } else {
                    2
                },
            )
        };
        let (length, opposite) = exits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_else(stay);
        Way { rates, length: length.max(0.0), opposite }
    }
}

#[cfg(test)]
#[path = "geodesic_tests.rs"]
mod tests;
