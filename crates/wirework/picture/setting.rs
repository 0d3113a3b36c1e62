//! What a picture is made of, read once: the model, the effect on it and the clip that is played.

use std::path::Path;

use wirework_asset::{Gltf, Rest};
use wirework_preset::{Effect, Preset};
use wirework_surface::Bounds;

use crate::film::find_clip;
use crate::mask::{Masks, masks};
use crate::motion::Motion;
use crate::output::Scene;
use crate::picture::show::Show;
use crate::picture::{PictureJob, Shown};
use crate::source::{Source, parts, refused};
use crate::subject::unfit;
use crate::{ControlNet, Evaluation, JobError, Subject};

/// A model at rest and the effect that is to move it.
pub(crate) struct Setting {
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    net: Option<ControlNet>,
    /// The positions that the net's surface has at rest.
    surface: Vec<[f32; 3]>,
    bounds: Option<Bounds>,
    pub(crate) own: bool,
    pub(crate) gltf: Gltf,
    pub(crate) rest: Rest,
    pub(crate) point_of: Vec<u32>,
    masks: Masks,
    /// Files that the document refers to: none of them may be written over.
    parts: Vec<std::path::PathBuf>,
    warnings: Vec<String>,
}

impl<'a> PictureJob<'a> {
    /// What the effect reads; none without one.
    pub(crate) fn source(&'a self) -> Option<Source<'a>> {
        match self.shown {
            Shown::Preset { preset, path, input } => {
                Some(Source { preset, preset_path: path, input, limits: &self.limits })
            }
            Shown::Asset(_) => None,
        }
    }

    pub(crate) fn preset(&self) -> Option<&'a Preset> {
        match self.shown {
            Shown::Preset { preset, .. } => Some(preset),
            Shown::Asset(_) => None,
        }
    }

    fn effects(&self) -> &'a [Effect] {
        self.preset().map_or(&[], |preset| &preset.effects)
    }
}

impl Setting {
    /// Reads what is shown.
    pub(crate) fn read(job: &PictureJob<'_>) -> Result<Self, JobError> {
        let source = job.source();
        let subject = match (&source, job.shown) {
            (Some(source), _) => source.subject()?,
            (None, Shown::Asset(path) | Shown::Preset { path, .. }) => Subject::read(path, &job.limits)?,
        };
        let folder = source.map_or(Path::new(""), |source| source.folder());
        let masks = masks(&subject, job.effects(), folder, &job.limits)?.complete()?;
        let (warnings, bounds) = (subject.warnings(), subject.bounds());
        let document = match (&source, job.shown) {
            (Some(source), _) => source.input.map(Path::to_path_buf).or_else(|| source.own_object()),
            (None, Shown::Asset(path) | Shown::Preset { path, .. }) => Some(path.to_path_buf()),
        };
        let parts = parts(&subject.model, document);
        let Subject { points, triangles, model, net, point_of, own } = subject;
        let surface = if net.is_some() { model.mesh_positions() } else { Vec::new() };
        let Scene { gltf, rest, point_of } = Scene::new(model, point_of, &job.limits)?;
        Ok(Self {
            points,
            triangles,
            net,
            surface,
            bounds,
            own,
            gltf,
            rest,
            point_of,
            masks,
            parts,
            warnings,
        })
    }

    /// Binds the effect and prepares the clip.
    pub(crate) fn show<'a>(&'a self, job: &PictureJob<'a>) -> Result<Show<'a>, JobError> {
        let motion = match job.effects() {
            [] => None,
            effects => {
                let bound = Evaluation::masked(
                    effects,
                    self.masks.clone(),
                    &self.points,
                    &self.triangles,
                    self.bounds,
                );
                let motion = Motion::new(bound.map_err(unfit(self.own))?, &self.points, self.own);
                Some(match &self.net {
                    Some(net) => motion.controlling(net, &self.surface)?,
                    None => motion,
                })
            }
        };
        let clips = self.gltf.clip_names().len();
        let clip = match job.clip {
            Some(wanted) => Some(find_clip(&self.gltf, wanted)?),
            None => (motion.is_none() && clips > 0).then_some(0),
        };
        Show::new(self, motion, clip, &job.limits, self.warnings.clone())
    }

    /// Refuses to write over what is read.
    pub(crate) fn guard(&self, job: &PictureJob<'_>, path: &Path) -> Result<(), JobError> {
        match (job.source(), job.shown) {
            (Some(source), _) => source.guard(path, false)?,
            (None, Shown::Asset(asset)) if wirework_asset::same_file(asset, path) => {
                return Err(refused(path, "what is shown"));
            }
            _ => {}
        }
        if self.parts.iter().any(|part| wirework_asset::same_file(part, path)) {
            return Err(refused(path, "a file that the model reads"));
        }
        Ok(())
    }
}
