//! The files of maps.

use std::path::{Path, PathBuf};

use wirework_asset::{OutputFile, same_file};

use crate::JobError;
use crate::apply::check_place;
use crate::maps::job::MapJob;
use crate::source::refused;

/// Where the files go.
#[derive(Clone, Debug)]
pub(crate) struct MapTarget {
    folder: PathBuf,
    stem: String,
    /// Whether the folder may have to be made.
    pub(crate) folders: bool,
}

impl MapTarget {
    /// What the job asks for; refuses what takes no files before any work is done.
    pub(crate) fn of(job: &MapJob<'_>) -> Result<Self, JobError> {
        let path = job.output;
        let slash = path.as_os_str().to_string_lossy().ends_with(['/', std::path::MAIN_SEPARATOR]);
        let target = if slash || path.is_dir() {
            let named = job.input.unwrap_or(job.preset_path).file_stem();
            let stem = named.map_or_else(|| "map".to_owned(), |stem| stem.to_string_lossy().into_owned());
            Self { folder: path.to_path_buf(), stem, folders: true }
        } else {
            let png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
            let name = if png { path.file_stem() } else { path.file_name() };
            let Some(name) = name else {
                let message =
                    "the output has no name: found a path that ends in `..`, expected a name or a folder";
                return Err(JobError::Request(message.to_owned()));
            };
            let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
            Self { folder, stem: name.to_string_lossy().into_owned(), folders: false }
        };
        if !job.dry_run {
            for name in ["normal.png", "height.png", "map.json"] {
                check_place(&target.path(name), target.folders)?;
            }
        }
        Ok(target)
    }

    /// The name of a file of so many characters behind the stem.
    pub(crate) fn name(&self, what: &str) -> String {
        format!("{}_{what}", self.stem)
    }

    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn path(&self, what: &str) -> PathBuf {
        self.beside(&self.name(what))
    }

    pub(crate) fn file(&self, what: &str, bytes: Vec<u8>) -> OutputFile {
        OutputFile { folders: self.folders, ..OutputFile::new(self.path(what), bytes) }
    }

    /// Refuses to write over what is read, or in the place of the report.
    pub(crate) fn guard(&self, job: &MapJob<'_>, read: &[PathBuf]) -> Result<(), JobError> {
        let masks = (1..=256).map(mask_name);
        let names = ["normal.png", "height.png", "map.json"].map(str::to_owned).into_iter().chain(masks);
        for path in names.map(|name| self.path(&name)) {
            if read.iter().any(|read| same_file(read, &path)) {
                return Err(refused(&path, "a file that is read"));
            }
            if job.report.is_some_and(|report| report == path || same_file(report, &path)) {
                return Err(refused(&path, "the report"));
            }
        }
        if let Some(report) = job.report.filter(|report| read.iter().any(|read| same_file(read, report))) {
            return Err(refused(report, "a file that is read"));
        }
        Ok(())
    }
}

/// What stands behind the stem in the name of a mask's file, from 1.
pub(crate) fn mask_name(index: usize) -> String {
    if index == 1 { "mask.png".to_owned() } else { format!("mask{index}.png") }
}
