//! Where pictures go: the kinds of output, and the files of each.

use std::path::PathBuf;

use wirework_asset::{OutputFile, Spool, printable};
use wirework_render::{Animation, AnimationKind, EncodeError, MAX_SIDE, Picture, RenderError, png};

use crate::apply::check_place;
use crate::output::Pattern;
use crate::picture::PictureJob;
use crate::picture::panel::{GAP, row};
use crate::{JobError, When};

/// What is written, as the name of the output says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum PictureTarget {
    /// One picture of one moment.
    Still,
    /// One picture of so many moments.
    Sheet(u32),
    /// A picture for each frame.
    Sequence(Pattern),
    /// An animation in one file.
    Animation(AnimationKind),
}

impl PictureTarget {
    /// What the job asks for; refuses what does not go together.
    pub(crate) fn of(job: &PictureJob<'_>) -> Result<Self, JobError> {
        let name = printable(&job.output.display().to_string());
        let request = |message: &str| Err(JobError::Request(format!("{name}: {message}")));
        let extension = job.output.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let target = match (extension.to_ascii_lowercase().as_str(), Pattern::of(job.output), job.sheet) {
            ("png", Some(pattern), None) => Self::Sequence(pattern),
            ("png", None, None) => Self::Still,
            ("png", None, Some(moments)) => Self::Sheet(moments),
            ("gif", None, None) => Self::Animation(AnimationKind::Gif),
            ("apng", None, None) => Self::Animation(AnimationKind::Apng),
            ("png" | "gif" | "apng", _, Some(_)) => {
                return request("a sheet is one picture, a .png without `####` in its name");
            }
            ("gif" | "apng", Some(_), None) => {
                return request(
                    "`####` stands for a file a frame, and only .png is written so; leave it out",
                );
            }
            ("", ..) => return request("found no extension, expected .png, .gif or .apng"),
            _ => return request("found another extension, expected .png, .gif or .apng"),
        };
        target.check_size(job)?;
        let [least, most] = Animation::FPS;
        if matches!(target, Self::Animation(_)) && !(least..=most).contains(&job.fps) {
            return Err(EncodeError::Fps { fps: job.fps }.into());
        }
        check_place(job.output, matches!(target, Self::Sequence(_)))?;
        match (&target, &job.when) {
            (Self::Still, When::Frames(_)) => request(
                "one picture shows one moment: choose it with `--at SECONDS`, show several with `--sheet`, or write `####` \
                 in the name for a file a frame",
            ),
            (Self::Sheet(_), When::At(_)) => request("a sheet shows several moments; leave `--at` out"),
            (Self::Sequence(_), When::At(_)) => request("a still is one file; leave `####` out of its name"),
            _ => Ok(target),
        }
    }

    /// Pixels across and down of each picture.
    pub(crate) fn size(&self, job: &PictureJob<'_>) -> [u32; 2] {
        job.size.unwrap_or(match self {
            Self::Sheet(_) => [400, 300],
            _ if job.compare => [640, 480],
            Self::Still | Self::Sequence(_) => [960, 540],
            Self::Animation(_) => [640, 360],
        })
    }

    /// The files of a sequence.
    pub(crate) fn files(&self, moments: &[(u32, f64)]) -> impl Iterator<Item = PathBuf> {
        let pattern = if let Self::Sequence(pattern) = self { Some(pattern) } else { None };
        pattern.into_iter().flat_map(move |pattern| moments.iter().map(|&(frame, _)| pattern.file(frame)))
    }

    /// Refuses, before any work, pictures whose row would be too long.
    fn check_size(&self, job: &PictureJob<'_>) -> Result<(), JobError> {
        let [width, height] = self.size(job);
        let moments = if let Self::Sheet(moments) = self { *moments } else { 1 };
        let pictures = moments.saturating_mul(if job.compare { 2 } else { 1 });
        let wide = width.saturating_add(GAP).saturating_mul(pictures).saturating_sub(GAP);
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(RenderError::Size { width, height }.into());
        }
        if wide > MAX_SIDE { Err(JobError::Row { pictures, width: wide }) } else { Ok(()) }
    }
}

/// Takes the pictures and makes the files.
pub(crate) struct Writer {
    path: PathBuf,
    target: PictureTarget,
    pictures: Vec<Picture>,
    spool: Spool,
    animation: Option<Animation>,
    size: [u32; 2],
    fps: f64,
}

impl Writer {
    pub(crate) fn new(job: &PictureJob<'_>, target: PictureTarget) -> Result<Self, JobError> {
        let path = job.output.to_path_buf();
        let spool = Spool::new()?;
        Ok(Self { path, target, pictures: vec![], spool, animation: None, size: [0; 2], fps: job.fps })
    }

    pub(crate) fn push(&mut self, frame: u32, picture: Picture) -> Result<(), JobError> {
        self.size = [picture.width, picture.height];
        match &self.target {
            PictureTarget::Still | PictureTarget::Sheet(_) => self.pictures.push(picture),
            PictureTarget::Sequence(pattern) => {
                self.spool.add(pattern.output(frame, png(&picture)?))?;
            }
            PictureTarget::Animation(kind) => {
                let animation = match &mut self.animation {
                    Some(animation) => animation,
                    none => none.insert(Animation::new(*kind, self.size, self.fps)?),
                };
                animation.push(&picture)?;
            }
        }
        Ok(())
    }

    /// The files, and pixels across and down of each.
    pub(crate) fn finish(self) -> Result<(Spool, [u32; 2]), JobError> {
        let Self { path, pictures, mut spool, animation, mut size, .. } = self;
        if let Some(animation) = animation {
            spool.add(OutputFile::new(&path, animation.finish()?))?;
        }
        if !pictures.is_empty() {
            let picture = row(pictures)?;
            size = [picture.width, picture.height];
            spool.add(OutputFile::new(&path, png(&picture)?))?;
        }
        Ok((spool, size))
    }
}
