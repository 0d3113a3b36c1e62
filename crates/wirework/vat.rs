//! A vertex animation texture: a folder with the model at rest, the texture, and what its numbers mean.

use std::path::{Path, PathBuf};

use serde::Serialize;
use wirework_asset::{Flat, Format, FrameStore, MadeFile, OutputFile};
use wirework_bake::{Vat, VatClip, VatFormat, VatLayout, VatNormals, VatRange, remap_info};

use crate::output::Scene;
use crate::shade::rest_normals;
use crate::{JobError, Schedule};

/// A clip whose last frame is as near to its first as this part of all that moves goes round without a jump.
const SEAMLESS: f32 = 1e-4;

/// What `OpenVAT` puts behind the name of a folder, and of a texture.
const SUFFIX: &str = "_vat";

/// A vertex animation texture that is asked for, in `OpenVAT`'s layout.
#[derive(Clone, Copy, Debug)]
pub struct VatJob<'a> {
    /// The folder that takes its files, made where it is not there. They are called as it is, without a `_vat` at the end.
    pub folder: &'a Path,
    /// How the texture is kept. Default [`VatFormat::Png`].
    pub format: VatFormat,
    /// Where normals go. Default [`VatNormals::Packed`].
    pub normals: VatNormals,
}

/// A vertex animation texture that was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct VatFacts {
    /// The folder.
    pub folder: PathBuf,
    /// Width and height of the texture.
    pub size: [usize; 2],
    /// Vertices of the model.
    pub vertices: usize,
    /// Frames.
    pub frames: usize,
    /// How far a vertex is at most from where it is to be, metres: what the texture rounds away.
    pub rounding: f64,
}

/// Where the files of a texture go.
#[derive(Clone, Debug)]
pub(crate) struct Names {
    folder: PathBuf,
    name: String,
    extension: &'static str,
}

impl Names {
    pub(crate) fn new(job: &VatJob<'_>) -> Result<Self, JobError> {
        let whole = job.folder.file_name().map(|name| name.to_string_lossy().into_owned());
        let name = whole.map(|name| name.strip_suffix(SUFFIX).map(str::to_owned).unwrap_or(name));
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            let folder = wirework_asset::printable(&job.folder.display().to_string());
            let message = format!(
                "{folder}: a folder without a name of its own; `--vat` calls its files as the folder"
            );
            return Err(JobError::Request(message));
        };
        Ok(Self { folder: job.folder.to_path_buf(), name, extension: job.format.extension() })
    }

    fn model(&self) -> PathBuf {
        self.folder.join(format!("{}.glb", self.name))
    }

    fn info(&self) -> PathBuf {
        self.folder.join(format!("{}-remap_info.json", self.name))
    }

    fn positions(&self) -> PathBuf {
        self.folder.join(format!("{}{SUFFIX}.{}", self.name, self.extension))
    }

    fn normals(&self) -> PathBuf {
        self.folder.join(format!("{}_vnrm.{}", self.name, self.extension))
    }

    /// All of them, that of the normals whether there is one or not.
    pub(crate) fn all(&self) -> [PathBuf; 4] {
        [self.model(), self.info(), self.positions(), self.normals()]
    }
}

/// A texture on the way to its files.
pub(crate) struct Texture {
    names: Names,
    vat: Vat,
    pub(crate) files: Vec<OutputFile>,
    pub(crate) warnings: Vec<String>,
}

impl Texture {
    /// Makes it of what was taken in: positions and normals of a scene.
    pub(crate) fn new(
        names: Names,
        job: &VatJob<'_>,
        scene: &Scene,
        (positions, normals): (&FrameStore, &FrameStore),
        (schedule, fps): (&Schedule, f64),
    ) -> Result<Self, JobError> {
        let Scene { gltf, rest, .. } = scene;
        let frames = schedule.count();
        let layout = VatLayout::new(rest.positions.len(), frames, job.normals)?;
        let failed = |error: std::io::Error| JobError::Store(error.to_string());
        let mut range = VatRange::NONE;
        let [mut now, mut facing] = [(); 2].map(|()| vec![[0.0; 3]; rest.positions.len()]);
        let (mut first, mut apart) = (Vec::new(), 0.0_f32);
        for frame in 0..frames {
            positions.read(frame, 0, &mut now).map_err(failed)?;
            range.grow(&rest.positions, &now);
            if frame == 0 {
                first.clone_from(&now);
            }
        }
        for (a, b) in first.as_flattened().iter().zip(now.as_flattened()) {
            apart = apart.max((a - b).abs());
        }
        let mut vat = Vat::new(layout, range, job.format);
        for frame in 0..frames {
            positions.read(frame, 0, &mut now).map_err(failed)?;
            normals.read(frame, 0, &mut facing).map_err(failed)?;
            vat.set(frame, &rest.positions, &now, &facing);
        }
        let reach = (0..3).map(|k| range.max[k] - range.min[k]).fold(0.0, f32::max);
        let looping = frames > 1 && apart <= SEAMLESS * reach;
        let info = remap_info(&range, frames, &VatClip { name: "wirework", fps, looping });
        let uvs: Vec<[f32; 2]> = (0..rest.positions.len()).map(|i| layout.uv(i)).collect();
        let mut normals = rest_normals(rest);
        // A file's normals are never 0.
        normals.iter_mut().filter(|normal| **normal == [0.0; 3]).for_each(|normal| *normal = [0.0, 1.0, 0.0]);
        let flat = gltf.flat(rest, &Flat { normals: &normals, uvs: &uvs })?;
        let file = wirework_asset::printable(gltf.file());
        let warnings = flat.warnings().iter().map(|warning| format!("{file}: {warning}")).collect();
        let mut files = flat.into_files(&names.model(), Format::Glb)?;
        files.push(OutputFile::new(names.info(), info.into_bytes()));
        for file in &mut files {
            file.folders = true;
        }
        Ok(Self { names, vat, files, warnings })
    }

    /// The pictures to write.
    pub(crate) fn made(&self) -> Vec<MadeFile<'_>> {
        let picture = |path: PathBuf, texels| MadeFile {
            path,
            folders: true,
            write: Box::new(move |out| self.vat.write(texels, out)),
        };
        let normals = self.vat.normals().map(|texels| picture(self.names.normals(), texels));
        [picture(self.names.positions(), self.vat.positions())].into_iter().chain(normals).collect()
    }

    pub(crate) fn facts(&self) -> VatFacts {
        let VatLayout { width, height, vertices, frames, .. } = *self.vat.layout();
        let (folder, rounding) = (self.names.folder.clone(), self.vat.rounding());
        VatFacts { folder, size: [width, height], vertices, frames, rounding }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_called_as_their_folder() {
        let names = |folder: &str| {
            let job =
                VatJob { folder: Path::new(folder), format: VatFormat::Exr, normals: VatNormals::Packed };
            Names::new(&job).ok().map(|names| names.all().map(|path| path.display().to_string()))
        };
        let want = ["cloth.glb", "cloth-remap_info.json", "cloth_vat.exr", "cloth_vnrm.exr"];
        assert_eq!(names("out/cloth_vat"), Some(want.map(|name| format!("out/cloth_vat/{name}"))));
        assert_eq!(names("out/cloth/"), Some(want.map(|name| format!("out/cloth/{name}"))));
        assert_eq!((names(".."), names("/"), names("_vat")), (None, None, None));
    }
}
