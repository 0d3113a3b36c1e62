//! A surface to walk on: its triangles and how they meet, its normals.

use glam::DVec3;

use crate::adjacency::{Adjacency, BORDER, CROWDED};
use crate::smooth::{fan_normal, smooth_normals};
use crate::vector::wide;
use crate::{NearestError, SurfacePoint};

/// A triangle of less than this part of its longest side squared has no direction.
const SLIVER: f64 = 1e-12;
/// A point is on an edge where the weight of the corner opposite is less: found in f32, it has so many digits.
const ON_EDGE: f64 = 1e-6;
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

impl Terrain {
    /// Makes a surface ready. Vertices at equal positions are one; triangles may be without area.
    ///
    /// # Errors
    ///
    /// There are no triangles, or one refers to a vertex that is missing or not finite.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, NearestError> {
        crate::nearest::check(positions, triangles)?;
        Ok(Self::on(Adjacency::new(positions, triangles), positions, triangles))
    }

    /// The same where vertices at equal positions are several all the same, as on the two sides of a slit that is shut: no way leads
    /// from one to the other.
    ///
    /// # Errors
    ///
    /// As [`Terrain::new`].
    pub fn unwelded(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Self, NearestError> {
        crate::nearest::check(positions, triangles)?;
        let places = (0..positions.len() as u32).collect();
        Ok(Self::on(Adjacency::of_places(places, triangles), positions, triangles))
    }

    fn on(adjacency: Adjacency, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let normals = smooth_normals(positions, triangles);
        Self {
            adjacency,
            positions: positions.iter().copied().map(wide).collect(),
            normals: normals.into_iter().map(wide).collect(),
        }
    }

    /// How many vertices there are.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// The triangles that meet in a vertex and those at its position, by rising number.
    ///
    /// # Panics
    ///
    /// There is no such vertex.
    pub fn fan(&self, vertex: u32) -> &[u32] {
        self.adjacency.fan(self.adjacency.place_of[vertex as usize])
    }

    /// The outward unit normal at a vertex; `None` where there is none, or no such vertex.
    pub fn normal_of_vertex(&self, vertex: u32) -> Option<[f64; 3]> {
        let place = *self.adjacency.place_of.get(vertex as usize)?;
        Some(self.normals[place as usize].try_normalize()?.to_array())
    }

    /// A vertex as a point of the surface; `None` where it has no faces, or is not there.
    pub fn at_vertex(&self, vertex: u32) -> Option<Step> {
        let place = *self.adjacency.place_of.get(vertex as usize)?;
        let &triangle = self.adjacency.fan(place).first()?;
        let corner = self.adjacency.triangles[triangle as usize].iter().position(|&c| c == place)?;
        let position = self.positions[place as usize].to_array();
        Some(Step { triangle, weights: DVec3::AXES[corner].to_array(), position })
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

    /// Whether a point of the surface lies on its border: on an edge that only one triangle has.
    pub fn on_border(&self, step: &Step) -> bool {
        let Some(corners) = self.adjacency.triangles.get(step.triangle as usize) else { return false };
        let open = |triangle: u32, edge: usize| self.adjacency.across(triangle, edge) == BORDER;
        // At a corner the edge may be that of another triangle.
        if let Some(corner) = (0..3).find(|&k| step.weights[k] > 1.0 - ON_EDGE) {
            let place = corners[corner];
            return self.adjacency.fan(place).iter().any(|&triangle| {
                let corners = self.adjacency.triangles[triangle as usize];
                (0..3).any(|k| corners[k] == place && (open(triangle, k) || open(triangle, (k + 2) % 3)))
            });
        }
        (0..3).any(|edge| step.weights[(edge + 2) % 3] < ON_EDGE && open(step.triangle, edge))
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

    pub(crate) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.adjacency.triangles[triangle as usize].map(|place| self.positions[place as usize])
    }

    pub(crate) fn position(&self, triangle: u32, weights: DVec3) -> DVec3 {
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

/// A triangle with an area.
pub(crate) struct Facet {
    pub(crate) corners: [DVec3; 3],
    pub(crate) normal: DVec3,
    /// Twice its area.
    area: f64,
}

impl Facet {
    pub(crate) fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let area = normal.length();
        (area > SLIVER * longest && area > 0.0).then(|| Self { corners, normal: normal / area, area })
    }

    /// How the weights of the corners change along a direction in its plane, in a unit of length.
    pub(crate) fn rates(&self, direction: DVec3) -> DVec3 {
        let rate = |i: usize| {
            let edge = self.corners[(i + 2) % 3] - self.corners[(i + 1) % 3];
            edge.cross(direction).dot(self.normal) / self.area
        };
        DVec3::new(rate(0), rate(1), rate(2))
    }
}
