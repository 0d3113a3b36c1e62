//! From a preset or an asset to pictures: read, bind, pose, frame, render, compose, write.

mod dress;
mod moments;
mod output;
mod overlay;
mod panel;
mod parts;
mod setting;
mod show;

use std::path::Path;
use std::time::{Duration, Instant};

use wirework_asset::Limits;
use wirework_preset::Preset;
use wirework_render::{Renderer, View};

use crate::apply::on_threads;
use crate::{JobError, Progress, When};

use moments::moments;
use output::{PictureTarget, Writer};
use panel::Panel;
use setting::Setting;

/// What is shown.
#[derive(Clone, Copy, Debug)]
pub enum Shown<'a> {
    /// An effect, on its own object or on a model.
    Preset {
        /// The effect.
        preset: &'a Preset,
        /// Its file: files that it names are relative to the folder of this one.
        path: &'a Path,
        /// The model; takes the place of the preset's object.
        input: Option<&'a Path>,
    },
    /// A `.glb`, `.gltf` or `.obj`.
    Asset(&'a Path),
}

/// A place and a direction for the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// The side from which all that moves is framed. Default [`View::ThreeQuarter`].
    pub view: View,
    /// Where the camera stands instead, metres. Default none: as far away as framing asks for.
    pub eye: Option<[f32; 3]>,
    /// What a camera with an `eye` looks at, metres. Default the middle of what is shown.
    pub target: Option<[f32; 3]>,
    /// Larger by this factor, > 0: a longer lens from the same place; below 1 the camera steps back. Default none: 1.
    pub zoom: Option<f32>,
}

/// What to show, when, from where, and where to.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub struct PictureJob<'a> {
    /// What is shown.
    pub shown: Shown<'a>,
    /// The file to write: `.png` a picture, with `####` in its name one a frame; `.gif` and `.apng` an animation.
    pub output: &'a Path,
    /// Which moments. Default all frames; of one picture the moment at which the effect has moved most.
    pub when: When,
    /// Frames a second. Default 24.
    pub fps: f64,
    /// The most frames there may be. Default 100 000.
    pub max_frames: u32,
    /// Pixels across and down of each picture, of which a sheet or a comparison has several. Default none:
    /// 960×540, animations 640×360, sheets 400×300, comparisons 640×480.
    pub size: Option<[u32; 2]>,
    /// Where the camera stands. Default in front, to the right and above, all of it in the picture at all times.
    pub viewpoint: Viewpoint,
    /// Whether wires, references, domain curves, locators and lattices are drawn. Default no.
    pub wires: bool,
    /// Whether so many moments stand in a row in one picture. Default none.
    pub sheet: Option<u32>,
    /// Whether the state before the effect stands beside the one after it. Default no.
    pub compare: bool,
    /// No rays: neither shadows nor occlusion, in about a fifth of the time. Default no.
    pub fast: bool,
    /// The clip that is played, by name or number. Default the first of an asset, none under a preset.
    pub clip: Option<&'a str>,
    /// How large an input may be.
    pub limits: Limits,
    /// How many threads work; the pictures do not depend on it. Default rayon's own number.
    pub threads: Option<usize>,
    /// Take warnings as errors. Default no.
    pub strict: bool,
}

impl<'a> PictureJob<'a> {
    /// A job with every setting at its default.
    pub fn new(shown: Shown<'a>, output: &'a Path) -> Self {
        Self {
            shown,
            output,
            when: When::All,
            fps: 24.0,
            max_frames: 100_000,
            size: None,
            viewpoint: Viewpoint::default(),
            wires: false,
            sheet: None,
            compare: false,
            fast: false,
            clip: None,
            limits: Limits::default(),
            threads: None,
            strict: false,
        }
    }
}

/// What was rendered, and what it took.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PictureReport {
    /// Moments that were rendered.
    pub moments: usize,
    /// The first of them, seconds.
    pub first: f64,
    /// Whether that was chosen for how far the effect has moved then.
    pub chosen: bool,
    /// Pixels across and down of what was written.
    pub size: [u32; 2],
    /// Files.
    pub files: usize,
    /// Reading, binding and framing, milliseconds.
    pub prepare_ms: f64,
    /// Deforming and rendering, milliseconds.
    pub render_ms: f64,
    /// Encoding and writing, milliseconds.
    pub write_ms: f64,
    /// What was repaired, passed over, or is hardly meant.
    pub warnings: Vec<String>,
}

/// Renders and writes, telling `progress` after each moment.
///
/// What is written appears whole or not at all, and is the same, byte for byte, for any number of threads.
///
/// # Errors
///
/// Whatever is wrong with request, preset, asset or output; nothing is written then.
pub fn picture(
    job: &PictureJob<'_>,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<PictureReport, JobError> {
    on_threads(job.threads, || run(job, progress))
}

fn run(job: &PictureJob<'_>, progress: &mut (dyn FnMut(Progress) + Send)) -> Result<PictureReport, JobError> {
    let start = Instant::now();
    let target = PictureTarget::of(job)?;
    let setting = Setting::read(job)?;
    setting.guard(job, job.output)?;
    let mut show = setting.show(job)?;
    let (moments, chosen) = moments(job, &target, &mut show)?;
    for path in target.files(&moments) {
        setting.guard(job, &path)?;
    }
    let panel = Panel::new(job, &target, &mut show, &moments)?;
    let mut writer = Writer::new(job, target)?;
    let prepare = start.elapsed();
    let mut renderer = Renderer::default();
    let (mut rendering, mut writing) = (Duration::ZERO, Duration::ZERO);
    for (done, &(frame, seconds)) in moments.iter().enumerate() {
        let begin = Instant::now();
        let picture = panel.picture(&mut show, &mut renderer, seconds, done == 0)?;
        let rendered = Instant::now();
        rendering += rendered - begin;
        writer.push(frame, picture)?;
        writing += rendered.elapsed();
        progress(Progress { done: done + 1, frames: moments.len() });
    }
    let warnings = show.warnings(job.source().as_ref());
    if job.strict && !warnings.is_empty() {
        return Err(JobError::Strict(warnings));
    }
    let begin = Instant::now();
    let (spool, size) = writer.finish()?;
    let files = spool.len();
    spool.write()?;
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    Ok(PictureReport {
        moments: moments.len(),
        first: moments.first().map_or(0.0, |&(_, seconds)| seconds),
        chosen,
        size,
        files,
        prepare_ms: ms(prepare),
        render_ms: ms(rendering),
        write_ms: ms(writing + begin.elapsed()),
        warnings,
    })
}
