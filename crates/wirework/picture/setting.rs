//! What a picture is made of, read once: the model, the effect on it and the clip that is played.

use std::path::{Path, PathBuf};

use wirework_asset::{Gltf, Rest};
use wirework_preset::{Effect, Preset};

use crate::film::find_clip;
use crate::fineness::Span;
use crate::fit::{Fit, fit};
use crate::motion::Basis;
use crate::output::Scene;
use crate::picture::dress::Dress;
use crate::picture::show::Show;
use crate::picture::{PictureJob, Shown};
use crate::posing::Posing;
use crate::source::{Source, parts, refused};
use crate::strain::{clip_seconds, driving_clip, found, sense};
use crate::subject::Origin;
use crate::{JobError, Model, Subject, When, schedule};

/// A model at rest and the effect that is to move it.
pub(crate) struct Setting {
    basis: Basis,
    pub(crate) gltf: Gltf,
    pub(crate) rest: Rest,
    pub(crate) point_of: Vec<u32>,
    /// What moves it, in order.
    effects: Vec<Effect>,
    fit: Fit,
    /// Files that the document refers to: none of them may be written over.
    parts: Vec<PathBuf>,
    /// Colours of the vertices, linear, of a model that does not keep them in a document.
    pub(crate) colors: Option<Vec<[f32; 3]>>,
    /// The model, or the preset that brings it along, as messages name it.
    file: String,
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

    /// The time in which effects are looked at.
    fn span(&self, effects: &[Effect], model: &Model) -> Result<Span, JobError> {
        let Some(preset) = self.preset() else { return Ok(Span::new(0.0)) };
        let clip = match (self.clip, model) {
            (Some(wanted), Model::Gltf { gltf, .. }) => Some(find_clip(gltf, wanted)?),
            _ => driving_clip(effects, model, None)?,
        };
        let span = Span::new(preset.duration.max(clip_seconds(model, clip)?));
        match self.when {
            // As long as it lasts.
            When::All => Ok(span),
            ref when => Ok(span.with(&schedule(when, 0.0, false, self.fps, self.max_frames)?)),
        }
    }

    pub(crate) fn preset(&self) -> Option<&'a Preset> {
        match self.shown {
            Shown::Preset { preset, .. } => Some(preset),
            Shown::Asset(_) => None,
        }
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
        let (effects, unfound) = match job.preset() {
            Some(preset) => found(&subject, preset, (folder, &job.limits), job.clip)?,
            None => Default::default(),
        };
        let span = job.span(&effects, &subject.model)?;
        let duration = job.preset().map_or(0.0, |preset| preset.duration);
        let (subject, fit, refinement) = fit(subject, &effects, (span, duration), (folder, &job.limits))?;
        let mut warnings = subject.warnings();
        warnings.extend(unfound);
        warnings.extend(refinement.warnings);
        let document = match (&source, job.shown) {
            (Some(source), _) => source.input.map(Path::to_path_buf).or_else(|| source.own_object()),
            (None, Shown::Asset(path) | Shown::Preset { path, .. }) => Some(path.to_path_buf()),
        };
        let mut parts = parts(&subject.model, document);
        let (basis, model, point_of) = Basis::of(subject);
        let colors = obj_colors(&model, &mut warnings);
        let dress = match &model {
            Model::Mesh { mesh, obj: Some(obj), .. } => Dress::of(mesh, obj, &job.limits, &mut warnings),
            _ => None,
        };
        let Scene { mut gltf, mut rest, point_of, source } = Scene::new(model, point_of, &job.limits)?;
        if let Some(dress) = dress {
            parts.extend(dress.cut(&mut gltf, &job.limits, &mut warnings)?);
            // The same vertices: only what they are joined to has changed.
            rest = gltf.rest()?;
        }
        let of_vertices = |colors: Vec<[f32; 3]>| {
            let color = |&position: &u32| colors.get(position as usize).copied().unwrap_or([1.0; 3]);
            source.as_ref().map(|source| source.iter().map(color).collect())
        };
        let colors = colors.and_then(of_vertices);
        let file = match job.shown {
            Shown::Asset(path) | Shown::Preset { input: Some(path), .. } | Shown::Preset { path, .. } => path,
        };
        let file = file.display().to_string();
        Ok(Self { basis, gltf, rest, point_of, effects, fit, parts, colors, file, warnings })
    }

    /// Binds the effect and prepares the clip.
    pub(crate) fn show<'a>(&'a self, job: &PictureJob<'a>) -> Result<Show<'a>, JobError> {
        let mut motion = match self.effects.as_slice() {
            [] => None,
            effects => Some(self.basis.bind(effects, self.fit.clone())?),
        };
        let clips = self.gltf.clip_names().len();
        let driven = job.preset().is_none_or(|preset| preset.driven);
        let clip = match job.clip {
            Some(wanted) => Some(find_clip(&self.gltf, wanted)?),
            None => (driven && clips > 0).then_some(0),
        };
        if let (Some(motion), Some(clip)) = (&mut motion, clip)
            && motion.evaluation.is_driven()
        {
            sense(&mut motion.evaluation, &self.gltf, &self.rest, &self.point_of, clip)?;
        }
        if let (Some(motion), Some(clip)) = (&mut motion, clip)
            && motion.evaluation.watches_nodes()
        {
            let points = (motion.points, self.point_of.as_slice());
            motion.evaluation.pose_by(Posing::new((&self.gltf, &self.rest), clip, points)?);
        }
        if let (Some(motion), Some(preset)) = (&mut motion, job.preset()) {
            let clip = motion.evaluation.posing().map_or(0.0, |posing| posing.player().duration());
            motion.sense_before(preset.duration.max(clip))?;
        }
        Show::new(self, motion, clip, job, self.warnings.clone())
    }

    /// The error that there is nothing to see.
    pub(crate) fn nothing(&self) -> JobError {
        JobError::NothingToSee { file: self.file.clone(), own: self.basis.origin == Origin::Preset }
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

/// The colours of the positions of an OBJ file, linear; none where it has none, or they cannot be read.
fn obj_colors(model: &Model, warnings: &mut Vec<String>) -> Option<Vec<[f32; 3]>> {
    let Model::Mesh { obj: Some(obj), .. } = model else { return None };
    let colors = obj.colors().unwrap_or_else(|error| {
        warnings.push(format!("{error}; the colours of vertices are left out"));
        None
    })?;
    let shown = |color: Option<[f32; 4]>| color.map_or([1.0; 3], |[r, g, b, _]| [r, g, b].map(linear));
    Some(colors.into_iter().map(shown).collect())
}

/// The light of an sRGB component: the format does not say what its numbers are, and all who write them write what is seen.
pub(crate) fn linear(c: f32) -> f32 {
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
