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

use crate::SurfacePoint;
use crate::adjacency::{BORDER, CROWDED, proper};
use crate::terrain::{Facet, Step, Terrain};

/// A place this near a corner, in parts of the triangle, is the corner: beyond lies rounding.
const CORNER: f64 = 1.0 - 1e-9;
/// A heading may leave the triangles round a corner by this sine before it counts as leaving the surface.
const OUTSIDE: f64 = 1e-6;
/// Edges that a walk crosses at most: hundreds of times round a limb. Whoever asks for more means no place in particular.
const MOST_EDGES: usize = 1 << 16;
/// Steps without progress after which a walker gives up: more than any sound fan of triangles needs.
const STUCK: usize = 256;

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
    }

    /// Walks straight ahead over `distance`, in the unit of the surface; `seen` is called at every edge that is crossed, and at
    /// the end, with the way so far. Returns the way in all and why it ended. A walk over more than 65 536 edges, which only a
    /// closed surface is large enough for, is taken to have arrived.
    pub fn walk(&mut self, distance: f64, mut seen: impl FnMut(f64, Step)) -> (f64, Stop) {
        // No number is no way.
        let distance = distance.max(0.0);
        // An edge on which the last walk ended has not been crossed yet.
        self.from = From::Inside;
        let (mut walked, mut idle) = (0.0, 0);
        for _ in 0..MOST_EDGES {
            if walked >= distance {
                break;
            }
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

/// A way across a triangle.
struct Way {
    /// Change of the corners' weights in a unit of length.
    rates: DVec3,
    length: f64,
    /// The corner opposite the edge where it leaves.
    opposite: usize,
}

impl Facet {
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
