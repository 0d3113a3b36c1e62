//! Between the space of a mesh and the world: where vertices are, which way their normals point, and back.

use glam::{DAffine3, DMat3, DVec3};

/// The linear part of a transform, both ways; nothing for the inverse of a singular one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Takes displacements back.
    pub(crate) inverse: Option<DMat3>,
    /// Takes normals back, but for their length: the transpose of the linear part.
    pub(crate) transpose: DMat3,
    /// Whether it leads nowhere: the mesh is in the world as it is.
    pub(crate) identity: bool,
}

impl Way {
    pub(crate) fn new(matrix: &DAffine3) -> Self {
        let identity = *matrix == DAffine3::IDENTITY;
        Self { inverse: inverse(matrix), transpose: matrix.matrix3.transpose(), identity }
    }

    /// A direction along the surface of the mesh, in the world.
    pub(crate) fn tangent(&self, t: DVec3) -> [f32; 3] {
        single((self.transpose.transpose() * t).normalize_or_zero())
    }

    /// A normal of the mesh in the world.
    pub(crate) fn normal(&self, n: DVec3) -> [f32; 3] {
        let world = self.inverse.map_or(n, |inverse| inverse.transpose() * n);
        single(world.normalize_or_zero())
    }
}

/// The inverse of the linear part of `matrix`, unless it is singular.
fn inverse(matrix: &DAffine3) -> Option<DMat3> {
    /// A volume this small, of the box that the columns would span if they were perpendicular, means that a whole
    /// direction is lost: displacements along it would be blown up by the inverse.
    const SINGULAR: f64 = 1e-9;
    let m = matrix.matrix3;
    let size = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length);
    let box_volume = size.iter().product::<f64>();
    let largest = size.iter().copied().fold(0.0, f64::max);
    let flat = size.iter().any(|&s| s < SINGULAR * largest) || m.determinant().abs() < SINGULAR * box_volume;
    (largest > 0.0 && box_volume > 0.0 && !flat).then(|| m.inverse()).filter(DMat3::is_finite)
}

/// Where `matrix` takes a vertex of a mesh; nothing where floats do not reach.
pub(crate) fn place(matrix: &DAffine3, vertex: DVec3) -> Result<[f32; 3], &'static str> {
    let world = single(matrix.transform_point3(vertex));
    if world.iter().all(|c| c.is_finite()) { Ok(world) } else { Err("a vertex beyond the range of floats") }
}

/// The displacement that brings `base` to `target` where players add it, in floats: the rounded difference, unless that misses
/// and one beside it does not, as happens at powers of two. There may be none, as where `target` is much nearer to 0 than `base`.
pub(crate) fn difference(base: f32, target: f32) -> f32 {
    let rounded = (f64::from(target) - f64::from(base)) as f32;
    let near = [rounded, rounded.next_up(), rounded.next_down()];
    near.into_iter().find(|delta| base + delta == target).unwrap_or(rounded)
}

pub(crate) fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

pub(crate) fn single(v: DVec3) -> [f32; 3] {
    v.to_array().map(|c| c as f32)
}
