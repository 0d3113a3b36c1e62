//! From a preset and an input to files: read, bind, deform, shade, bake, write.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use wirework_asset::{HELD_BYTES, Limits, MadeFile, OutputFile, check_output, same_file, write_files_and};
use wirework_bake::{Bake, BakeError, Settings};
use wirework_preset::{Action, Chain, Effect, Preset};

use crate::film::{Film, check_clip, find_clip};
use crate::fineness::Span;
use crate::fit::{Fit, fit};
use crate::motion::Basis;
use crate::output::{Pattern, Scene, Target};
use crate::posing::Posing;
use crate::report::peak_bytes;
use crate::sides::{Recorders, Sides, all_apart};
use crate::source::{Source, parts};
use crate::strain::{Length, clip_seconds, driving_clip, found, sense};
use crate::subject::Model;
use crate::{BakeReport, JobError, Report, Schedule, Skeleton, Subject, VatJob, When, schedule};

/// What to apply, to what, and how.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// The effect.
    pub preset: &'a Preset,
    /// The preset's own file: files that it names are relative to its folder, and its name is that of a new node.
    pub preset_path: &'a Path,
    /// The model; takes the place of the preset's object. Default none.
    pub input: Option<&'a Path>,
    /// The file to write: its extension says what. Default none, which is for a dry run, or where there are `caches` or a `vat`.
    pub output: Option<&'a Path>,
    /// Point caches, `.pc2` or `.mdd`, to be written too; `{node}` in the name of one makes it a file for each node. Default none.
    pub caches: Vec<PathBuf>,
    /// A vertex animation texture to be written too. Default none.
    pub vat: Option<VatJob<'a>>,
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
    /// How far what plays may be from the effect, at any time, as a part of the diagonal; above 0. [`Bake::Frames`] is exact at its
    /// frames, and a skeleton is as far off as it is. Default 1e-4.
    pub tolerance: f64,
    /// With [`Bake::Skin`], places on each bone, between its ends, where the limb gets more joints. On a model's own skin each joint that
    /// something hangs on there gets one of its own. Default 0.
    pub joints: usize,
    /// The most morph targets a mesh may have, its own counted. Default 240.
    pub max_targets: usize,
    /// Bytes of morph targets that are held in memory until the output is written; more go to a file without a name in its folder
    /// meanwhile. The result does not depend on it. Default [`HELD_BYTES`].
    pub held_bytes: usize,
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
            caches: Vec::new(),
            vat: None,
            in_place: false,
            report: None,
            dry_run: false,
            fps: 24.0,
            when: When::All,
            max_frames: 100_000,
            bake: Bake::Auto,
            tolerance: Settings::default().tolerance,
            joints: 0,
            max_targets: Settings::default().max_targets,
            held_bytes: HELD_BYTES,
            clip: None,
            into: None,
            limits: Limits::default(),
            threads: None,
            strict: false,
        }
    }

    /// The clip of the input that effects look at: the one they are to play with, where none is named.
    fn looks_at(&self) -> Option<&'a str> {
        self.clip.or(self.into)
    }

    pub(crate) fn source(&self) -> Source<'_> {
        let Self { preset, preset_path, input, ref limits, .. } = *self;
        Source { preset, preset_path, input, limits }
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
pub fn apply(job: &Job<'_>, progress: &mut (dyn FnMut(Progress) + Send)) -> Result<Report, JobError> {
    on_threads(job.threads, || run(job, progress))
}

/// Works on a pool of so many threads, or else on rayon's own.
pub(crate) fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, JobError> + Send,
) -> Result<T, JobError> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| JobError::Threads(threads, error.to_string()))?.install(work)
}

fn run(job: &Job<'_>, progress: &mut (dyn FnMut(Progress) + Send)) -> Result<Report, JobError> {
    let start = Instant::now();
    let source = job.source();
    let mut sides = Sides::of(job, &source)?;
    let target = target(job, &expected(job)?, sides.is_empty())?;
    guard_reports(job, source.files())?;
    let Prepared { subject, effects, fit, clip, seconds, schedule, sought, mut report } =
        prepare(job, &source)?;
    let (basis, model, point_of) = Basis::of(subject);
    guard_reports(job, parts(&model, job.input.map(Path::to_path_buf).or_else(|| source.own_object())))?;
    let mut motion = basis.bind(&effects, fit)?;
    // Writing takes the model; what plays its clip needs one meanwhile.
    let played = match &model {
        Model::Gltf { gltf, rest } if clip.is_some() && motion.evaluation.watches_nodes() => {
            Some((gltf.clone(), rest.clone(), point_of.clone()))
        }
        _ => None,
    };
    if let (Some(clip), Model::Gltf { gltf, rest }) = (clip, &model) {
        sense(&mut motion.evaluation, gltf, rest, &point_of, clip)?;
    }
    if let (Some(clip), Some((gltf, rest, point_of))) = (clip, &played) {
        motion.evaluation.pose_by(Posing::new((gltf, rest), clip, (motion.points, point_of))?);
    }
    motion.sense_before(seconds)?;
    let besides = sides.meet(job, &model, &point_of, &schedule)?;
    let recorders = if job.dry_run {
        Recorders::default()
    } else {
        let clip = clip.filter(|_| !motion.evaluation.is_posed());
        sides.recorders(&model, &point_of, besides.as_ref(), clip)?
    };
    let (shade, write_time) = (Duration::ZERO, Duration::ZERO);
    let mut film = Film { motion, schedule, shade, write: write_time, recorders, progress };
    let product = match (target, model) {
        (Target::Gltf(format), model)
            if job.bake == Bake::Skin && matches!(film.schedule, Schedule::Frames { .. }) =>
        {
            film.skeleton(job, format, scene(job, model, point_of)?, clip)?
        }
        (Target::Gltf(format), model) => film.gltf(job, format, scene(job, model, point_of)?, clip)?,
        (Target::Obj, model) => film.obj(None, model, point_of, clip, job.output)?,
        (Target::ObjSequence(pattern), model) => film.obj(Some(&pattern), model, point_of, clip, None)?,
        (Target::Aside, _) => film.alone()?,
    };
    // A baker looks at moments in an order of its own.
    if film.recorders.wait() {
        film.alone()?;
    }
    let begin = Instant::now();
    let recorders = std::mem::take(&mut film.recorders);
    let mut aside = sides.finish(recorders, besides.as_ref(), &film.schedule, job.fps)?;
    film.write += begin.elapsed();
    aside.report(&mut report);
    report.warnings.extend(product.skeleton.as_ref().and_then(Skeleton::warning));
    report.warnings.extend(product.warnings);
    report.warnings.extend(source.effect_warnings(&film.motion.evaluation));
    report.engines = product.engines;
    (report.clip, report.skeleton) = (product.clip, product.skeleton);
    report.bake = product.played.map(BakeReport::from);
    report.notes.extend(product.note);
    if job.strict && !report.warnings.is_empty() {
        return Err(JobError::Strict(report.warnings));
    }
    let begin = Instant::now();
    let files: Vec<OutputFile> = product.files.into_iter().chain(aside.take_files()).collect();
    write(job, &source, &files, &aside.made())?;
    film.write += begin.elapsed();
    account(&film, sought, &mut report);
    report.total_ms = ms(start.elapsed());
    Ok(report)
}

/// The scene of a model, which puts what it does not hold in memory where the output goes: there must be room for that.
fn scene(job: &Job<'_>, model: Model, point_of: Vec<u32>) -> Result<Scene, JobError> {
    let mut scene = Scene::new(model, point_of, &job.limits)?;
    // A dry run has no business there.
    scene.gltf.spill_beyond(job.held_bytes, job.output.filter(|_| !job.dry_run).map(folder_of));
    Ok(scene)
}

/// The moments as far as they are known before anything is read: how long a clip is that the effect follows is not.
fn expected(job: &Job<'_>) -> Result<Schedule, JobError> {
    let preset = job.preset;
    times(job, Length { animated: preset.animated || preset.driven, ..Length::of(preset) })
}

fn times(job: &Job<'_>, length: Length) -> Result<Schedule, JobError> {
    Ok(schedule(&job.when, length.seconds, length.animated, job.fps, job.max_frames)?)
}

/// What is known before anything is bound.
struct Prepared {
    subject: Subject,
    effects: Vec<Effect>,
    fit: Fit,
    /// The clip that drives effects.
    clip: Option<usize>,
    /// How long they last.
    seconds: f64,
    schedule: Schedule,
    /// The time that it took to look where the subject is compressed.
    sought: Duration,
    report: Report,
}

/// Reads what effects work on, looks for what they leave open, and makes it as fine as they need it.
fn prepare(job: &Job<'_>, source: &Source<'_>) -> Result<Prepared, JobError> {
    let preset = job.preset;
    let subject = source.subject()?;
    if let Some(clip) = job.clip {
        check_clip(&subject.model, clip)?;
    }
    let begin = Instant::now();
    let (effects, unfound) = found(&subject, preset, (source.folder(), &job.limits), job.looks_at())?;
    let sought = begin.elapsed();
    let clip = driving_clip(&effects, &subject.model, job.looks_at())?;
    check_into(job, &effects, &subject.model, clip)?;
    let mut length = Length::of(preset);
    if clip.is_some() {
        length = length.with_clip(preset, clip_seconds(&subject.model, clip)?);
    }
    let schedule = times(job, length)?;
    let span = Span::new(preset.duration).with(&schedule);
    let (subject, fit, refinement) =
        fit(subject, &effects, (span, preset.duration), (source.folder(), &job.limits))?;
    let mut report = Report {
        points: subject.position_count(),
        frames: schedule.count(),
        threads: rayon::current_num_threads(),
        warnings: subject.warnings(),
        refined: refinement.meshes,
        ..Report::default()
    };
    report.warnings.extend(unfound);
    report.warnings.extend(stands_still(&effects, &subject.model, clip, length)?);
    report.warnings.extend(refinement.warnings);
    Ok(Prepared { subject, effects, fit, clip, seconds: length.seconds, schedule, sought, report })
}

/// Refuses to put a limb into another clip than the one that it starts from.
fn check_into(job: &Job<'_>, effects: &[Effect], model: &Model, clip: Option<usize>) -> Result<(), JobError> {
    let (Some(into), Some(clip), Model::Gltf { gltf, .. }) = (job.into, clip, model) else { return Ok(()) };
    if find_clip(gltf, into)? == clip || !effects.iter().any(is_posed) {
        return Ok(());
    }
    let message =
        "`--into` names another clip than `--clip`, the one that the limb starts from: leave one of them out";
    Err(JobError::Request(message.to_owned()))
}

/// Whether a clip poses what an effect works on.
fn is_posed(effect: &Effect) -> bool {
    matches!(&effect.action, Action::Ik(limb) if matches!(limb.chain, Chain::Skin { .. }))
}

/// The warning that a clip ends before an effect that it poses.
fn stands_still(
    effects: &[Effect],
    model: &Model,
    clip: Option<usize>,
    length: Length,
) -> Result<Option<String>, JobError> {
    let seconds = clip_seconds(model, clip)?;
    let ends = seconds > 0.0 && seconds < length.seconds && effects.iter().any(is_posed);
    Ok(ends.then(|| {
        format!(
            "the clip under the limb lasts {seconds:.2} s and the effect {:.2} s: then the model stands still [clip-ends]",
            length.seconds
        )
    }))
}

/// Writes the files, unless it is a dry run.
fn write(
    job: &Job<'_>,
    source: &Source<'_>,
    files: &[OutputFile],
    made: &[MadeFile<'_>],
) -> Result<(), JobError> {
    let all =
        || files.iter().map(|file| file.path.as_path()).chain(made.iter().map(|file| file.path.as_path()));
    if job.output.is_some() || !made.is_empty() {
        guard_reports(job, all().map(Path::to_path_buf))?;
    }
    if !job.dry_run {
        for file in files.iter().filter(|file| file.replace) {
            source.guard(&file.path, job.in_place)?;
        }
        made.iter().try_for_each(|file| source.guard(&file.path, false))?;
        if !made.is_empty() {
            all_apart(all())?;
        }
        write_files_and(files, made)?;
    }
    Ok(())
}

/// What the work has taken.
fn account(film: &Film<'_>, sought: Duration, report: &mut Report) {
    let spent = film.motion.evaluation.spent();
    report.wires = film.motion.evaluation.wire_count();
    report.bind_ms = ms(sought + spent.bind);
    report.deform_ms = ms(spent.deform);
    report.normals_ms = ms(film.shade);
    report.write_ms = ms(film.write);
    report.peak_bytes = peak_bytes();
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses a place that takes no file, before any work is done. Files of a `sequence` may have a folder made for them.
pub(crate) fn check_place(path: &Path, sequence: bool) -> Result<(), JobError> {
    let folder = folder_of(path);
    if !sequence && !folder.exists() {
        return Err(JobError::NoFolder(folder.to_path_buf()));
    }
    let there =
        folder.ancestors().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    match there.into_iter().find(|folder| folder.exists()) {
        Some(there) if !there.is_dir() => Err(JobError::NotFolder(there.to_path_buf())),
        Some(there) => Ok(check_output(&if sequence { there.join("0") } else { path.to_path_buf() })?),
        None => Err(JobError::NoFolder(folder.to_path_buf())),
    }
}

const NO_TRACKS: &str =
    "`--bake skin` writes tracks of joints: it needs a .glb or .gltf, and an effect that moves in time";
const NO_CLIP: &str = "a clip takes the effect only where it is written as a glTF animation";

/// What to write; refuses what cannot be before any work is done.
fn target(job: &Job<'_>, schedule: &Schedule, alone: bool) -> Result<Target, JobError> {
    let request = |message: &str| Err(JobError::Request(message.to_owned()));
    if !(job.tolerance > 0.0 && job.tolerance.is_finite()) {
        return Err(BakeError::NoTolerance(job.tolerance).into());
    }
    let Some(path) = job.output else {
        return match (alone, job.dry_run) {
            (false, _) if job.bake == Bake::Skin => request(NO_TRACKS),
            (false, _) if job.into.is_some() => request(NO_CLIP),
            (false, _) => Ok(Target::Aside),
            (true, true) => Ok(Target::Gltf(wirework_asset::Format::Glb)),
            (true, false) => request("there is no output: give one, or do a dry run"),
        };
    };
    job.source().guard(path, job.in_place)?;
    guard_report(job, path)?;
    if !job.dry_run {
        check_place(path, Pattern::of(path).is_some())?;
    }
    let name = wirework_asset::printable(&path.display().to_string());
    let Some(target) = Target::of(path) else {
        return request(&format!(
            "{name}: found another extension, expected .glb, .gltf, .obj, .pc2 or .mdd"
        ));
    };
    let animation = matches!((&target, schedule), (Target::Gltf(_), Schedule::Frames { .. }));
    match (&target, schedule) {
        _ if job.bake == Bake::Skin && !animation => request(NO_TRACKS),
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
        _ if job.into.is_some() => request(NO_CLIP),
        _ => Ok(target),
    }
}

/// Refuses a report in the place of any of these files.
fn guard_reports(job: &Job<'_>, paths: impl IntoIterator<Item = PathBuf>) -> Result<(), JobError> {
    paths.into_iter().try_for_each(|path| guard_report(job, &path))
}

/// Refuses a report in the place of a file that is read or written.
pub(crate) fn guard_report(job: &Job<'_>, path: &Path) -> Result<(), JobError> {
    match job.report {
        Some(report) if same_place(report, path) => {
            let name = wirework_asset::printable(&report.display().to_string());
            Err(JobError::Request(format!("{name}: the report needs a file of its own")))
        }
        _ => Ok(()),
    }
}

/// Whether two paths are of one file, be it there or not yet.
pub(crate) fn same_place(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?));
    a == b || same_file(a, b) || place(a).is_some_and(|a| place(b) == Some(a))
}
