//! What a job reads: a preset, its file, and the model that takes the place of the preset's own object.

use std::path::{Path, PathBuf};

use wirework_asset::{Limits, printable, same_file};
use wirework_preset::Preset;

use crate::mask::mask_files;
use crate::subject::{Model, Subject};
use crate::{Evaluation, JobError};

/// A preset and what it is applied to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) preset: &'a Preset,
    pub(crate) preset_path: &'a Path,
    pub(crate) input: Option<&'a Path>,
    pub(crate) limits: &'a Limits,
}

impl<'a> Source<'a> {
    /// Reads the input, or else makes the preset's own object.
    pub(crate) fn subject(&self) -> Result<Subject, JobError> {
        let input = self.input.map(|input| Subject::read(input, self.limits)).transpose()?;
        let subject = Subject::for_preset(input, self.preset, self.preset_path, self.limits)?;
        subject.ok_or(JobError::NoObject)
    }

    /// The folder that names of files in the preset are relative to.
    pub(crate) fn folder(&self) -> &'a Path {
        self.preset_path.parent().unwrap_or(Path::new(""))
    }

    /// The file that the preset names as its object, where no input takes its place.
    pub(crate) fn own_object(&self) -> Option<PathBuf> {
        let object = self.preset.object.as_ref().filter(|_| self.input.is_none())?;
        object.file(self.folder())
    }

    /// The files that the preset names as pieces.
    fn piece_files(&self) -> impl Iterator<Item = PathBuf> {
        let folder = self.folder();
        self.preset.pieces().into_iter().filter_map(move |piece| piece.object.as_ref()?.file(folder))
    }

    /// Every file that is read but those that a document refers to: [`parts`] has these.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let named = [self.input, Some(self.preset_path)].into_iter().flatten().map(Path::to_path_buf);
        named
            .chain(self.own_object())
            .chain(self.piece_files())
            .chain(mask_files(&self.preset.effects, self.folder()))
            .collect()
    }

    /// Refuses to write over what is read; over the model only unless `in_place`.
    pub(crate) fn guard(&self, path: &Path, in_place: bool) -> Result<(), JobError> {
        let refuse = |what: &str| Err(refused(path, what));
        if self.input.is_some_and(|input| same_file(input, path)) && !in_place {
            return refuse("the input; `--in-place` allows that");
        }
        if same_file(self.preset_path, path) {
            return refuse("the preset");
        }
        if mask_files(&self.preset.effects, self.folder()).iter().any(|image| same_file(image, path)) {
            return refuse("an image that the preset reads");
        }
        if self.own_object().is_some_and(|object| same_file(&object, path)) && !in_place {
            return refuse("the preset's object; `--in-place` allows that");
        }
        if self.piece_files().any(|piece| same_file(&piece, path)) {
            return refuse("a piece of the preset");
        }
        Ok(())
    }

    /// What effects ask for and lack, each after the name of the preset's file.
    pub(crate) fn effect_warnings(&self, evaluation: &Evaluation<'_>) -> Vec<String> {
        // A preset from a pipe has no file to name.
        let file = Some(self.preset_path).filter(|path| path.is_file());
        let file =
            file.map_or_else(String::new, |path| format!("{}: ", printable(&path.display().to_string())));
        let all = evaluation.warnings().into_iter().chain(evaluation.idle_warnings());
        all.map(|warning| format!("{file}{warning}")).collect()
    }
}

/// The error that an output stands in the place of something else.
pub(crate) fn refused(path: &Path, what: &str) -> JobError {
    JobError::Request(format!("{}: the output is {what}", printable(&path.display().to_string())))
}

/// The files that a glTF document at `document` refers to.
pub(crate) fn parts(model: &Model, document: Option<PathBuf>) -> Vec<PathBuf> {
    let (Model::Gltf { gltf, .. }, Some(document)) = (model, document) else { return Vec::new() };
    let lists = ["buffers", "images"].into_iter().filter_map(|key| gltf.json().get(key)?.as_array());
    let uris = lists.flatten().filter_map(|entry| entry.get("uri")?.as_str());
    uris.filter(|uri| !uri.starts_with("data:")).map(|uri| document.with_file_name(uri)).collect()
}
