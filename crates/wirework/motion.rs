//! The points of an effect at any moment, and the surface that they control.

use wirework_preset::{Effect, ObjectError};
use wirework_surface::{Bounds, Tessellation};

use crate::fit::Fit;
use crate::stage::Take;
use crate::strain::sense_before;
use crate::subject::{Model, Origin, Subject};
use crate::unfit::unfit;
use crate::{ControlNet, Evaluation, JobError};

/// What an effect is bound to: the points of a subject at rest, taken out of it.
pub(crate) struct Basis {
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// What `units: Bounds` are parts of.
    bounds: Option<Bounds>,
    /// A net whose control points the points are, and the positions of its surface.
    net: Option<(ControlNet, Vec<[f32; 3]>)>,
    pub(crate) origin: Origin,
}

impl Basis {
    /// Takes a subject apart: what effects are bound to, the model, and for each of its positions the point.
    pub(crate) fn of(subject: Subject) -> (Self, Model, Vec<u32>) {
        let bounds = subject.bounds();
        let Subject { points, triangles, model, net, point_of, origin, pieces: _ } = subject;
        let surface = match (&net, &model) {
            (Some(_), Model::Mesh { mesh, .. }) => mesh.positions.clone(),
            _ => Vec::new(),
        };
        let net = net.map(|net| (net, surface));
        (Self { points, triangles, bounds, net, origin }, model, point_of)
    }

    /// Binds effects, with what they have of the subject, which has been made as fine as they ask for, where it could be.
    pub(crate) fn bind<'a>(&'a self, effects: &'a [Effect], fit: Fit) -> Result<Motion<'a>, JobError> {
        let Self { points, triangles, bounds, net, origin } = self;
        let mut evaluation =
            Evaluation::fitted(effects, fit, points, triangles, *bounds).map_err(unfit(origin, effects))?;
        // A net says itself that it cannot be made finer.
        if net.is_none() {
            evaluation.set_refined();
        }
        let motion = Motion { points, now: points.clone(), evaluation, net: None, origin, effects };
        let Some((net, surface)) = net else { return Ok(motion) };
        let controlled = Controlled { surface: net.surface()?, controls: points.clone() };
        Ok(Motion { points: surface, now: surface.clone(), net: Some(controlled), ..motion })
    }
}

/// An effect on its points.
pub(crate) struct Motion<'a> {
    /// What the model's positions are places of, at rest: the effect's points, or those of the surface that they control.
    pub(crate) points: &'a [[f32; 3]],
    /// The same at the present moment.
    pub(crate) now: Vec<[f32; 3]>,
    pub(crate) evaluation: Evaluation<'a>,
    net: Option<Controlled<'a>>,
    origin: &'a Origin,
    effects: &'a [Effect],
}

/// A surface whose control points the effect moves.
struct Controlled<'a> {
    surface: Tessellation<'a>,
    /// The control points where they are now.
    controls: Vec<[f32; 3]>,
}

impl Motion<'_> {
    /// Whether the effect moves control points of a surface, and not its vertices.
    pub(crate) fn is_net(&self) -> bool {
        self.net.is_some()
    }

    /// The effects as they were read.
    pub(crate) fn effects(&self) -> &[Effect] {
        self.effects
    }

    /// Where the points are without effects: at rest, or as a clip poses them at the moment.
    pub(crate) fn before(&self) -> &[[f32; 3]] {
        self.evaluation.moment().map_or(self.points, |(_, points)| points)
    }

    /// Tells effects that no clip drives how those before them compress the surface in the course of `duration` seconds.
    pub(crate) fn sense_before(&mut self, duration: f64) -> Result<(), JobError> {
        sense_before(&mut self.evaluation, duration).map_err(unfit(self.origin, self.effects))
    }

    /// Works out a moment, and hands each part of each effect to `take`, as [`Evaluation::portions`] does. Of a surface that is controlled
    /// by others there are none.
    pub(crate) fn portions(
        &mut self,
        seconds: f64,
        most: usize,
        take: &mut Take<'_>,
    ) -> Result<(), JobError> {
        if self.net.is_some() {
            return Ok(());
        }
        let mut part = self.now.clone();
        let buffers = (self.now.as_mut_slice(), part.as_mut_slice());
        self.evaluation.portions(seconds, most, buffers, take).map_err(unfit(self.origin, self.effects))
    }

    /// Works out where the points are at a moment.
    pub(crate) fn at(&mut self, seconds: f64) -> Result<(), JobError> {
        let moved = self.net.as_mut().map_or(&mut self.now, |net| &mut net.controls);
        self.evaluation.at(seconds, moved).map_err(unfit(self.origin, self.effects))?;
        if let Some(point) = moved.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            return Err(JobError::OutOfRange { point, seconds });
        }
        if let Some(Controlled { surface, controls }) = &self.net {
            surface.positions_into(controls, &mut self.now).map_err(ObjectError::from)?;
        }
        Ok(())
    }
}
