//! \[SF98\] §2: control points of a patch as the deformed object.

use wirework_preset::{Object, ObjectError, PatchDeform, Shape};
use wirework_surface::{Mesh, Patch, Tessellation};

use crate::JobError;

/// A patch whose control points are deformed, and whose surface is evaluated from them.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlNet {
    /// The patch where it stands, at rest.
    pub patch: Patch,
    /// Quads of its surface along `u` and `v`.
    pub tessellation: [u32; 2],
}

impl ControlNet {
    /// The net of an object that asks for its control points to be deformed, and the net as a mesh; its faces look to where
    /// those of the object do.
    pub(crate) fn of(object: &Object) -> Result<Option<(Self, Mesh)>, ObjectError> {
        let Shape::Patch { patch, tessellation, deform: PatchDeform::ControlPoints } = &object.shape else {
            return Ok(None);
        };
        let mut mesh = patch.net();
        object.transform.apply_to_mesh(&mut mesh)?;
        let patch = patch.with_points(mesh.positions.clone())?;
        Ok(Some((Self { patch, tessellation: *tessellation }, mesh)))
    }

    /// The surface for any control points, into a buffer as long as its vertices are many. A vertex whose control points are
    /// those at rest has the bits it has at rest.
    pub fn evaluate_into(&self, controls: &[[f32; 3]], out: &mut [[f32; 3]]) -> Result<(), JobError> {
        Ok(self.surface()?.positions_into(controls, out).map_err(ObjectError::from)?)
    }

    /// The surface, to be evaluated often.
    pub(crate) fn surface(&self) -> Result<Tessellation<'_>, JobError> {
        Ok(self.patch.tessellation(self.tessellation).map_err(ObjectError::from)?)
    }
}
