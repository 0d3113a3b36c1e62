//! What is written beside the output, or without one: point caches, and a vertex animation texture.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use wirework_asset::{MadeFile, OutputFile, printable};
use wirework_bake::VatLayout;

use crate::apply::{check_place, folder_of, guard_report, same_place};
use crate::caches::{Caches, Member, Wanted, members, wanted, warnings};
use crate::motion::Motion;
use crate::output::Scene;
use crate::record::{Recorder, folder_there};
use crate::source::Source;
use crate::subject::Model;
use crate::vat::{Names, Texture, VatJob};
use crate::{Job, JobError, Report, Schedule};

/// What is asked for.
pub(crate) struct Sides<'a> {
    caches: Vec<Wanted>,
    vat: Option<(VatJob<'a>, Names)>,
    /// What is to be in the caches, once there is a model.
    members: Vec<Member>,
}

/// What takes the vertices in that they need.
#[derive(Default)]
pub(crate) struct Recorders<'a> {
    cache: Option<Recorder<'a>>,
    vat: Option<Recorder<'a>>,
}

/// What is to be written.
#[derive(Default)]
pub(crate) struct Aside {
    caches: Option<Caches>,
    texture: Option<Texture>,
    warnings: Vec<String>,
}

impl<'a> Sides<'a> {
    /// What a job asks for; refuses what cannot be before any work is done.
    pub(crate) fn of(job: &Job<'a>, source: &Source<'_>) -> Result<Self, JobError> {
        let vat = job.vat.map(|vat| Names::new(&vat).map(|names| (vat, names))).transpose()?;
        let new = Self { caches: wanted(job)?, vat, members: Vec::new() };
        let beside = job.output.filter(|output| !new.caches.iter().any(|wanted| wanted.path() == *output));
        let mut known: Vec<PathBuf> = beside.into_iter().map(Path::to_path_buf).collect();
        for path in new.paths() {
            source.guard(&path, false)?;
            guard_report(job, &path)?;
            if known.iter().any(|known| same_place(known, &path)) {
                return Err(twice(&path));
            }
            known.push(path);
        }
        if !job.dry_run {
            new.caches.iter().try_for_each(|wanted| check_place(wanted.path(), false))?;
            if let Some((_, names)) = &new.vat {
                names.all().iter().try_for_each(|path| check_place(path, true))?;
                names
                    .all()
                    .iter()
                    .filter(|path| path.exists())
                    .try_for_each(|path| check_place(path, false))?;
            }
        }
        Ok(new)
    }

    fn paths(&self) -> Vec<PathBuf> {
        let caches = self.caches.iter().map(|wanted| wanted.path().to_path_buf());
        caches.chain(self.vat.iter().flat_map(|(_, names)| names.all())).collect()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.caches.is_empty() && self.vat.is_none()
    }

    /// Looks at the model; gives a copy of its scene where one is needed besides.
    pub(crate) fn meet(
        &mut self,
        job: &Job<'_>,
        model: &Model,
        point_of: &[u32],
        schedule: &Schedule,
    ) -> Result<Option<Scene>, JobError> {
        if self.is_empty() {
            return Ok(None);
        }
        if !self.caches.is_empty() {
            self.members = members(model);
        }
        if self.vat.is_none() && matches!(model, Model::Mesh { .. }) {
            return Ok(None);
        }
        let scene = Scene::new(model.clone(), point_of.to_vec(), &job.limits)?;
        if let Some((vat, _)) = &self.vat {
            VatLayout::new(scene.rest.positions.len(), schedule.count(), vat.normals)?;
        }
        Ok(Some(scene))
    }

    /// What takes vertices in: those of `model`, and of its `scene`, as `clip` poses them where that drives the effect.
    pub(crate) fn recorders<'s>(
        &self,
        model: &Model,
        point_of: &[u32],
        scene: Option<&'s Scene>,
        clip: Option<usize>,
    ) -> Result<Recorders<'s>, JobError> {
        let posed = |recorder: Recorder<'s>| match (model, scene, clip) {
            (Model::Gltf { .. }, Some(scene), Some(clip)) => {
                recorder.posed_by(&scene.gltf, &scene.rest, clip)
            }
            _ => Ok(recorder),
        };
        let mut out = Recorders::default();
        if let Some(first) = self.caches.first() {
            let positions = match model {
                Model::Gltf { rest, .. } => &rest.positions,
                Model::Mesh { mesh, .. } => &mesh.positions,
            };
            out.cache =
                Some(posed(Recorder::of_positions(positions, point_of, &folder_there(first.path()))?)?);
        }
        if let (Some((_, names)), Some(scene)) = (&self.vat, scene) {
            let folder = folder_there(&names.all()[0]);
            out.vat = Some(posed(Recorder::of_scene(&scene.rest, &scene.point_of, &folder)?)?);
        }
        Ok(out)
    }

    /// Makes what is to be written of what was taken in.
    pub(crate) fn finish(
        self,
        recorders: Recorders<'_>,
        scene: Option<&Scene>,
        schedule: &Schedule,
        fps: f64,
    ) -> Result<Aside, JobError> {
        let Self { caches: wanted, vat, members } = self;
        let mut out = Aside { warnings: warnings(&wanted, &members), ..Aside::default() };
        if let Some(recorder) = recorders.cache {
            out.caches = Some(Caches::new(&wanted, &members, recorder.into_stores().0, (schedule, fps))?);
        }
        if let (Some(recorder), Some((job, names)), Some(scene)) = (recorders.vat, vat, scene)
            && let (positions, Some(normals)) = recorder.into_stores()
        {
            out.texture = Some(Texture::new(names, &job, scene, (&positions, &normals), (schedule, fps))?);
        }
        Ok(out)
    }
}

impl Recorders<'_> {
    /// Whether there is one that has taken nothing in yet.
    pub(crate) fn wait(&self) -> bool {
        self.cache.iter().chain(&self.vat).any(Recorder::waits)
    }

    /// Takes in the present moment.
    pub(crate) fn take(&mut self, motion: &Motion<'_>, seconds: f64) -> Result<(), JobError> {
        let Self { cache, vat } = self;
        cache.iter_mut().chain(vat).try_for_each(|recorder| recorder.take(motion, seconds))
    }
}

impl Aside {
    /// Tells what there is.
    pub(crate) fn report(&mut self, report: &mut Report) {
        report.warnings.append(&mut self.warnings);
        report.caches = self.caches.as_ref().map_or_else(Vec::new, Caches::facts);
        if let Some(texture) = &mut self.texture {
            report.warnings.append(&mut texture.warnings);
            report.vat = Some(texture.facts());
        }
    }

    /// The files of which all is known.
    pub(crate) fn take_files(&mut self) -> Vec<OutputFile> {
        self.texture.as_mut().map_or_else(Vec::new, |texture| std::mem::take(&mut texture.files))
    }

    /// The files that are made while they are written.
    pub(crate) fn made(&self) -> Vec<MadeFile<'_>> {
        let caches = self.caches.as_ref().map_or_else(Vec::new, Caches::made);
        caches.into_iter().chain(self.texture.as_ref().map_or_else(Vec::new, Texture::made)).collect()
    }
}

/// Refuses two files in one place.
pub(crate) fn all_apart<'p>(paths: impl Iterator<Item = &'p Path>) -> Result<(), JobError> {
    let mut places = BTreeSet::new();
    for path in paths {
        let folder = folder_of(path);
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
        if !places.insert((folder, path.file_name())) {
            return Err(twice(path));
        }
    }
    Ok(())
}

fn twice(path: &Path) -> JobError {
    let path = printable(&path.display().to_string());
    JobError::Request(format!("{path}: two of the files to write have this place; each needs its own"))
}
