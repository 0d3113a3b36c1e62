//! The points of an effect at any moment, and the surface that they control.

use wirework_preset::ObjectError;
use wirework_surface::Tessellation;

use crate::subject::unfit;
use crate::{ControlNet, Evaluation, JobError};

/// An effect on its points.
pub(crate) struct Motion<'a> {
    /// What the model's positions are places of, at rest: the effect's points, or those of the surface that they control.
    pub(crate) points: &'a [[f32; 3]],
    /// The same at the present moment.
    pub(crate) now: Vec<[f32; 3]>,
    pub(crate) evaluation: Evaluation<'a>,
    net: Option<Controlled<'a>>,
    /// Whether the object is made of numbers in the preset.
    own: bool,
}

/// A surface whose control points the effect moves.
struct Controlled<'a> {
    surface: Tessellation<'a>,
    /// The control points where they are now.
    controls: Vec<[f32; 3]>,
}

impl<'a> Motion<'a> {
    /// An effect on a model's own points; `own`: whether the object is made of numbers in the preset.
    pub(crate) fn new(evaluation: Evaluation<'a>, points: &'a [[f32; 3]], own: bool) -> Self {
        Self { points, now: points.to_vec(), evaluation, net: None, own }
    }

    /// The effect moves the control points of a net, and the model's positions are those of its surface.
    pub(crate) fn controlling(self, net: &'a ControlNet, surface: &'a [[f32; 3]]) -> Result<Self, JobError> {
        let controlled = Controlled { surface: net.surface()?, controls: self.points.to_vec() };
        Ok(Self { points: surface, now: surface.to_vec(), net: Some(controlled), ..self })
    }

    /// Works out where the points are at a moment.
    pub(crate) fn at(&mut self, seconds: f64) -> Result<(), JobError> {
        let moved = self.net.as_mut().map_or(&mut self.now, |net| &mut net.controls);
        self.evaluation.at(seconds, moved).map_err(unfit(self.own))?;
        if let Some(point) = moved.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            return Err(JobError::OutOfRange { point, seconds });
        }
        if let Some(Controlled { surface, controls }) = &self.net {
            surface.positions_into(controls, &mut self.now).map_err(ObjectError::from)?;
        }
        Ok(())
    }
}
