//! From a preset and an input to files: read, bind, deform, shade, bake, write.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use wirework_asset::{Limits, same_file, write_files};
use wirework_bake::{Bake, Settings};
use wirework_preset::Preset;

use crate::film::{Controlled, Film, check_clip};
use crate::mask::{mask_files, masks};
use crate::output::{Scene, Target};
use crate::report::peak_bytes;
use crate::subject::{Model, Subject, unfit};
use crate::{ApplyError, Evaluation, Report, Schedule, When, schedule};

/// What to apply, to what, and how.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// The effect.
    pub preset: &'a Preset,
    /// The preset's own file: files that it names are relative to its folder, and its name is that of a new node.
    pub preset_path: &'a Path,
    /// The model; takes the place of the preset's object. Default none.
    pub input: Option<&'a Path>,
    /// The file to write: its extension says what. Default none, which is for a dry run only.
    pub output: Option<&'a Path>,
    /// Whether the output may be the input. Default no.
    pub in_place: bool,
    /// A file that the caller writes afterwards, such as a report: refused where the work reads or writes it. Default
    /// none.
    pub report: Option<&'a Path>,
    /// Do everything but write. Default no.
    pub dry_run: bool,
    /// Frames a second. Default 24.
    pub fps: f64,
    /// Which moments. Default all frames.
    pub when: When,
    /// The most frames there may be. Default 100 000, more than an hour at 24 frames a second.
    pub max_frames: u32,
    /// How frames become morph targets. Default [`Bake::Auto`].
    pub bake: Bake,
    /// The most morph targets a mesh may have, its own counted. Default 240.
    pub max_targets: usize,
    /// The clip of the input that an effect looks at which depends on one. Default the first.
    pub clip: Option<&'a str>,
    /// A clip of the input, by name or number, that takes the effect's channels. Default none: a new clip.
    pub into: Option<&'a str>,
    /// How large an input may be.
    pub limits: Limits,
    /// How many threads work; the result does not depend on it. Default rayon's own number.
    pub threads: Option<usize>,
    /// Take warnings as errors. Default no.
    pub strict: bool,
}

impl<'a> Job<'a> {
    /// A job with every setting at its default.
    pub fn new(preset: &'a Preset, preset_path: &'a Path) -> Self {
        Self {
            preset,
            preset_path,
            input: None,
            output: None,
            in_place: false,
            report: None,
            dry_run: false,
            fps: 24.0,
            when: When::All,
            max_frames: 100_000,
            bake: Bake::Auto,
            max_targets: Settings::default().max_targets,
            clip: None,
            into: None,
            limits: Limits::default(),
            threads: None,
            strict: false,
        }
    }
}

/// How far the work has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Frames that are done.
    pub done: usize,
    /// All frames.
    pub frames: usize,
}

/// Applies a preset and writes the result, telling `progress` after each frame.
///
/// The result is written whole or not at all, and is the same, bit for bit, for any number of threads.
///
/// # Errors
///
/// Whatever is wrong with request, preset, input or output; nothing is written then.
pub fn apply(job: &Job<'_>, progress: &mut (dyn FnMut(Progress) + Send)) -> Result<Report, ApplyError> {
    let Some(threads) = job.threads else { return run(job, progress) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| ApplyError::Threads(threads, error.to_string()))?;
    pool.install(|| run(job, progress))
}

fn run(job: &Job<'_>, progress: &mut (dyn FnMut(Progress) + Send)) -> Result<Report, ApplyError> {
    let start = Instant::now();
    let preset = job.preset;
    let schedule = schedule(&job.when, preset.duration, preset.animated, job.fps, job.max_frames)?;
    let target = target(job, &schedule)?;
    for path in [job.input, Some(job.preset_path), own_object(job).as_deref()].into_iter().flatten() {
        guard_report(job, path)?;
    }
    for path in mask_files(&preset.effects, preset_dir(job)) {
        guard_report(job, &path)?;
    }
    let subject = subject(job)?;
    let mut report = Report {
        points: subject.position_count(),
        frames: schedule.count(),
        threads: rayon::current_num_threads(),
        warnings: subject.warnings(),
        ..Report::default()
    };
    let masks = masks(&subject, &preset.effects, preset_dir(job), &job.limits)?.complete()?;
    let bounds = subject.bounds();
    let Subject { points, triangles, model, net, point_of, own } = subject;
    if let Some(clip) = job.clip {
        check_clip(&model, clip)?;
    }
    for path in parts(&model, job.input.map(Path::to_path_buf).or_else(|| own_object(job))) {
        guard_report(job, &path)?;
    }
    let evaluation = Evaluation::masked(&preset.effects, masks, &points, &triangles, bounds);
    let evaluation = evaluation.map_err(unfit(own))?;
    let surface = match (&net, &model) {
        (Some(net), Model::Mesh { mesh, .. }) => {
            let controlled = Controlled { surface: net.surface()?, controls: points.clone() };
            Some((controlled, mesh.positions.clone()))
        }
        _ => None,
    };
    let (net, surface) = surface.unzip();
    let points = surface.as_deref().unwrap_or(&points);
    let mut film = Film {
        now: points.to_vec(),
        points,
        evaluation,
        net,
        schedule,
        shade: Duration::ZERO,
        write: Duration::ZERO,
        own,
        progress,
    };
    let product = match (target, model) {
        (Target::Gltf(format), model) => film.gltf(job, format, Scene::new(model, point_of, &job.limits)?)?,
        (Target::Obj, model) => film.obj(None, model, point_of, job.output)?,
        (Target::ObjSequence(pattern), model) => film.obj(Some(&pattern), model, point_of, None)?,
    };
    report.warnings.extend(product.warnings);
    let file = preset_file(job);
    let of_effects = film.evaluation.warnings().into_iter().chain(film.evaluation.idle_warnings());
    report.warnings.extend(of_effects.map(|warning| format!("{file}{warning}")));
    report.clip = product.clip;
    if job.strict && !report.warnings.is_empty() {
        return Err(ApplyError::Strict(report.warnings));
    }
    let write = Instant::now();
    for file in product.files.iter().filter(|_| job.output.is_some()) {
        guard_report(job, &file.path)?;
    }
    if !job.dry_run {
        for file in product.files.iter().filter(|file| file.replace) {
            guard(job, &file.path)?;
        }
        write_files(&product.files)?;
    }
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let spent = film.evaluation.spent();
    report.wires = film.evaluation.wire_count();
    report.bind_ms = ms(spent.bind);
    report.deform_ms = ms(spent.deform);
    report.normals_ms = ms(film.shade);
    report.write_ms = ms(film.write + write.elapsed());
    report.peak_bytes = peak_bytes();
    report.total_ms = ms(start.elapsed());
    Ok(report)
}

/// What to write; refuses what cannot be before any work is done.
fn target(job: &Job<'_>, schedule: &Schedule) -> Result<Target, ApplyError> {
    let request = |message: &str| Err(ApplyError::Request(message.to_owned()));
    let Some(path) = job.output else {
        return if job.dry_run {
            Ok(Target::Gltf(wirework_asset::Format::Glb))
        } else {
            request("there is no output: give one, or do a dry run")
        };
    };
    guard(job, path)?;
    guard_report(job, path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !job.dry_run && !folder.is_dir()) {
        return Err(ApplyError::NoFolder(folder.to_path_buf()));
    }
    let name = wirework_asset::printable(&path.display().to_string());
    let Some(target) = Target::of(path) else {
        return request(&format!("{name}: found another extension, expected .glb, .gltf or .obj"));
    };
    match (&target, schedule) {
        (Target::Gltf(_), _) if name.contains("####") => request(&format!(
            "{name}: `####` stands for a file a frame, and only OBJ is written so; leave it out"
        )),
        (Target::Obj, Schedule::Frames { .. }) => request(&format!(
            "{name}: one OBJ file holds no animation; write `####` in its name for a file a frame, or ask for one \
             moment with `--at SECONDS`"
        )),
        (Target::ObjSequence(_), Schedule::Still(_)) if matches!(job.when, When::At(_)) => {
            request(&format!("{name}: a still is one file; leave `####` out of its name"))
        }
        (Target::Gltf(_), Schedule::Frames { .. }) => Ok(target),
        _ if job.into.is_some() => {
            request("a clip takes the effect only where it is written as a glTF animation")
        }
        _ => Ok(target),
    }
}

/// Refuses to write over what is read.
fn guard(job: &Job<'_>, path: &Path) -> Result<(), ApplyError> {
    let refuse = |what: &str| {
        let name = wirework_asset::printable(&path.display().to_string());
        Err(ApplyError::Request(format!("{name}: the output is {what}")))
    };
    if job.input.is_some_and(|input| same_file(input, path)) && !job.in_place {
        return refuse("the input; `--in-place` allows that");
    }
    if same_file(job.preset_path, path) {
        return refuse("the preset");
    }
    if mask_files(&job.preset.effects, preset_dir(job)).iter().any(|image| same_file(image, path)) {
        return refuse("an image that the preset reads");
    }
    if own_object(job).is_some_and(|object| same_file(&object, path)) && !job.in_place {
        return refuse("the preset's object; `--in-place` allows that");
    }
    Ok(())
}

/// Refuses a report in the place of a file that is read or written.
fn guard_report(job: &Job<'_>, path: &Path) -> Result<(), ApplyError> {
    match job.report {
        Some(report) if same_place(report, path) => {
            let name = wirework_asset::printable(&report.display().to_string());
            Err(ApplyError::Request(format!("{name}: the report needs a file of its own")))
        }
        _ => Ok(()),
    }
}

/// The files that a glTF document refers to.
fn parts(model: &Model, document: Option<PathBuf>) -> Vec<PathBuf> {
    let (Model::Gltf { gltf, .. }, Some(document)) = (model, document) else { return Vec::new() };
    let lists = ["buffers", "images"].into_iter().filter_map(|key| gltf.json().get(key)?.as_array());
    let uris = lists.flatten().filter_map(|entry| entry.get("uri")?.as_str());
    uris.filter(|uri| !uri.starts_with("data:")).map(|uri| document.with_file_name(uri)).collect()
}

/// Whether two paths are of one file, be it there or not yet.
fn same_place(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(folder.canonicalize().ok()?.join(path.file_name()?))
    };
    a == b || same_file(a, b) || place(a).is_some_and(|a| place(b) == Some(a))
}

/// The file that the preset names as its object, where no input takes its place.
fn own_object(job: &Job<'_>) -> Option<PathBuf> {
    let object = job.preset.object.as_ref().filter(|_| job.input.is_none())?;
    object.file(preset_dir(job))
}

/// What stands before a warning about the preset; nothing where it is no file.
fn preset_file(job: &Job<'_>) -> String {
    let file = Some(job.preset_path).filter(|path| path.is_file());
    file.map_or_else(String::new, |path| {
        format!("{}: ", wirework_asset::printable(&path.display().to_string()))
    })
}

/// The folder that names of files in the preset are relative to.
fn preset_dir<'a>(job: &Job<'a>) -> &'a Path {
    job.preset_path.parent().unwrap_or(Path::new(""))
}

fn subject(job: &Job<'_>) -> Result<Subject, ApplyError> {
    if let Some(input) = job.input {
        return Subject::read(input, &job.limits);
    }
    Subject::from_preset(job.preset, job.preset_path, &job.limits)?.ok_or(ApplyError::NoObject)
}
