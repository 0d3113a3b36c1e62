//! What tests of patterns have in common.

use wirework_core::{Binding, Mask, Wire};
use wirework_surface::{Mesh, grid};

use crate::{Creases, Layout, SurfaceView, Wrinkle, WrinkleError, creases};

pub(crate) const LAYOUT: Layout =
    Layout { center: [0.0; 3], direction: [1.0, 0.0, 0.0], size: [1.0, 1.0], creases: 5 };

/// The creases of settings on a mesh.
pub(crate) fn lay(mesh: &Mesh, settings: &Wrinkle) -> Result<Creases, WrinkleError> {
    let triangles = mesh.triangles().unwrap();
    creases(&SurfaceView { positions: &mesh.positions, triangles: &triangles }, settings)
}

/// Their wires at a moment.
pub(crate) fn wires(creases: &Creases, seconds: f64) -> Vec<Wire> {
    let mut wires = vec![];
    creases.clone().wires_at(seconds, &mut wires);
    wires
}

/// A sheet of 2 × 2, its outside up.
pub(crate) fn plane(cells: u32) -> Mesh {
    grid([2.0; 2], [cells; 2], [0.0, 1.0, 0.0]).unwrap()
}

/// The points of a mesh as the creases of a moment move them.
pub(crate) fn deform(mesh: &Mesh, creases: &Creases, seconds: f64) -> Vec<[f32; 3]> {
    let (wires, near) = (wires(creases, seconds), creases.near());
    let masks: Vec<_> =
        near.iter().map(|n| Some(Mask::Sparse { points: &n.vertices, factors: &n.factors })).collect();
    let mut out = mesh.positions.clone();
    let mut binding = Binding::masked(&wires, &mesh.positions, &masks).unwrap();
    binding.deform_into(&wires, &creases.blend(), &mut out).unwrap();
    out
}
