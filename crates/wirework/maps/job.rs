//! The whole road from a preset to the files of its maps.

use std::path::Path;
use std::time::Instant;

use wirework_asset::{Limits, OutputFile, write_files};
use wirework_bake::map::{self, Depth, Facts, Maps};
use wirework_preset::{Action, BoundsFrame, Chain, Effect, Preset, Units};

use crate::apply::on_threads;
use crate::error::count;
use crate::evaluate::{bounds_frame, has_extent};
use crate::fineness::Span;
use crate::fit::{Fit, fit};
use crate::maps::finer::{Lineage, finer};
use crate::maps::ground::Ground;
use crate::maps::groups::Groups;
use crate::maps::moment::{Length, telling};
use crate::maps::notes::{MapHeight, MapReport, texts};
use crate::maps::surface::{Moved, surface};
use crate::maps::target::MapTarget;
use crate::motion::{Basis, Motion};
use crate::output::Scene;
use crate::source::{Source, parts};
use crate::strain::{clip_seconds, driving_clip, found, sense};
use crate::subject::Model;
use crate::{JobError, Progress, Subject};

/// What to make maps of, for what, and how.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "each is a setting of its own")]
pub struct MapJob<'a> {
    /// The effect.
    pub preset: &'a Preset,
    /// The preset's own file: files that it names are relative to its folder.
    pub preset_path: &'a Path,
    /// The model; takes the place of the preset's object. Default none.
    pub input: Option<&'a Path>,
    /// What the names of the files begin with, or a folder for them: one that is there, or whose name ends in a slash.
    pub output: &'a Path,
    /// The moment, seconds. Default the one at which the effect has moved most.
    pub at: Option<f64>,
    /// Texels, samples and padding.
    pub settings: map::Settings,
    /// Bits of the normal map. Default 8.
    pub depth: Depth,
    /// Whether green points down, as DirectX has it. Default no.
    pub flip_green: bool,
    /// Only meshes of this node. Default all that the effect moves.
    pub node: Option<&'a str>,
    /// Only what has this material. Default all that the effect moves.
    pub material: Option<&'a str>,
    /// The set of texture coordinates. Default that of the material's normal map, else the first.
    pub uv: Option<usize>,
    /// Whether the effect is worked out on a finer copy where its folds need that. Default yes.
    pub refine: bool,
    /// Masks, for so many parts of each effect at most. Default none.
    pub masks: Option<usize>,
    /// Frames a second at which the weights of the parts are looked at. Default 24.
    pub fps: f64,
    /// The most frames there may be. Default 100 000.
    pub max_frames: u32,
    /// The clip of the input that drives effects. Default the first.
    pub clip: Option<&'a str>,
    /// How large an input, and all maps together, may be.
    pub limits: Limits,
    /// A file that the caller writes afterwards: refused where the work reads or writes it. Default none.
    pub report: Option<&'a Path>,
    /// Do everything but write. Default no.
    pub dry_run: bool,
    /// How many threads work; the maps do not depend on it. Default rayon's own number.
    pub threads: Option<usize>,
    /// Take warnings as errors. Default no.
    pub strict: bool,
}

impl<'a> MapJob<'a> {
    /// A job with every setting at its default.
    pub fn new(preset: &'a Preset, preset_path: &'a Path, output: &'a Path) -> Self {
        Self {
            preset,
            preset_path,
            input: None,
            output,
            at: None,
            settings: map::Settings::default(),
            depth: Depth::Eight,
            flip_green: false,
            node: None,
            material: None,
            uv: None,
            refine: true,
            masks: None,
            fps: 24.0,
            max_frames: 100_000,
            clip: None,
            limits: Limits::default(),
            report: None,
            dry_run: false,
            threads: None,
            strict: false,
        }
    }

    pub(crate) fn source(&self) -> Source<'_> {
        let Self { preset, preset_path, input, ref limits, .. } = *self;
        Source { preset, preset_path, input, limits }
    }
}

/// Makes the maps of a preset and writes them, telling `progress` after each moment that was looked at.
///
/// The maps are for the model at rest. They appear whole or not at all, and are the same, byte for byte, for any number of threads.
///
/// # Errors
///
/// Whatever is wrong with request, preset, input or output; nothing is written then.
pub fn bake_map(
    job: &MapJob<'_>,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<MapReport, JobError> {
    on_threads(job.threads, || run(job, progress))
}

fn run(job: &MapJob<'_>, progress: &mut (dyn FnMut(Progress) + Send)) -> Result<MapReport, JobError> {
    let start = Instant::now();
    job.settings.check()?;
    room(job, 0)?;
    let target = MapTarget::of(job)?;
    let source = job.source();
    let Prepared { effects, ground, lineage, subject, fit, clip, length, mut warnings } =
        prepare(job, &source, &target)?;
    let (basis, model, point_of) = Basis::of(subject);
    let mut motion = basis.bind(&effects, fit)?;
    if let (Some(clip), Model::Gltf { gltf, rest }) = (clip, &model) {
        sense(&mut motion.evaluation, gltf, rest, &point_of, clip)?;
    }
    motion.sense_before(length.seconds)?;
    let scene = Scene::new(model, point_of, &job.limits)?;
    let at = match job.at {
        Some(at) => at,
        None => telling(&length, &mut motion, progress)?,
    };
    let mut groups = job.masks.map(|most| Groups::at(&mut motion, at, most)).transpose()?;
    room(job, groups.as_ref().map_or(0, Groups::len))?;
    motion.at(at)?;
    let moved = Moved::new(&motion, &scene);
    let (surface, meshes) =
        surface(job, (ground, lineage), (&scene, &moved), groups.as_ref(), &mut warnings)?;
    let found = map::maps(&surface, &job.settings)?;
    let triangles = surface.triangles.len();
    drop((surface, moved));
    if let Some(groups) = &mut groups {
        groups.weigh(job, &length, &mut motion, progress)?;
        warnings.extend(groups.warnings());
    }
    warnings.extend(doubts(&found.facts));
    warnings.extend(source.effect_warnings(&motion.evaluation));
    if job.strict && !warnings.is_empty() {
        return Err(JobError::Strict(warnings));
    }
    let mut report = MapReport {
        seconds: at,
        chosen: job.at.is_none() && length.animated,
        size: job.settings.size,
        triangles,
        meshes,
        height: MapHeight::new(&found),
        green: if job.flip_green { "down" } else { "up" },
        masks: groups.map_or_else(Vec::new, |groups| groups.masks(&target)),
        warnings,
        threads: rayon::current_num_threads(),
        prepare_ms: ms(start),
        ..MapReport::default()
    };
    let begin = Instant::now();
    write(job, &target, &found, &mut report)?;
    report.write_ms = ms(begin);
    Ok(report)
}

/// What is known before anything is bound.
struct Prepared {
    effects: Vec<Effect>,
    ground: Ground,
    lineage: Option<Lineage>,
    /// As fine as the maps need it.
    subject: Subject,
    fit: Fit,
    /// The clip that drives effects.
    clip: Option<usize>,
    length: Length,
    warnings: Vec<String>,
}

/// Reads what the effects work on, looks for the parts that maps are for, and makes a copy that is fine enough.
fn prepare(job: &MapJob<'_>, source: &Source<'_>, target: &MapTarget) -> Result<Prepared, JobError> {
    let subject = source.subject()?;
    let (effects, unfound) = found(&subject, job.preset, (source.folder(), &job.limits), job.clip)?;
    refuse_posed(&effects)?;
    let clip = driving_clip(&effects, &subject.model, job.clip)?;
    let seconds = clip_seconds(&subject.model, clip)?;
    let span = Span::new(job.preset.duration.max(seconds)).at(job.at);
    let read = job.input.map(Path::to_path_buf).or_else(|| source.own_object());
    let mut files = parts(&subject.model, read);
    files.extend(source.files());
    target.guard(job, &files)?;
    let frame = bounds_frame(subject.bounds());
    let mut warnings = subject.warnings();
    warnings.extend(unfound);
    let ground = Ground::of(job, &subject, &mut warnings)?;
    let (subject, lineage) = finer(job, subject, &effects, span, &ground, &mut warnings)?;
    let effects = if lineage.is_some() { settled(effects, &frame) } else { effects };
    // The copy is as fine as it is to be, and without one a map is for the triangles that there are.
    let asked = |effect: &Effect| effect.refine && lineage.is_none() && job.refine;
    let effects = effects.into_iter().map(|effect| Effect { refine: asked(&effect), ..effect });
    let effects: Vec<Effect> = effects.collect();
    let (subject, fit, refinement) =
        fit(subject, &effects, (span, job.preset.duration), (source.folder(), &job.limits))?;
    warnings.extend(refinement.warnings);
    let length = Length::new(job, seconds);
    Ok(Prepared { effects, ground, lineage, subject, fit, clip, length, warnings })
}

/// Effects on a finer copy count in parts of the model that it is of.
fn settled(effects: Vec<Effect>, frame: &BoundsFrame) -> Vec<Effect> {
    let one = |effect: Effect| Effect { units: Units::Metres, ..effect.placed(frame) };
    if has_extent(frame) { effects.into_iter().map(one).collect() } else { effects }
}

/// Refuses limbs of a model's own skin: they move the model, not its surface.
fn refuse_posed(effects: &[Effect]) -> Result<(), JobError> {
    let posed = |effect: &Effect| matches!(&effect.action, Action::Ik(limb) if matches!(limb.chain, Chain::Skin { .. }) || limb.watches());
    if !effects.iter().any(posed) {
        return Ok(());
    }
    let message = "a limb of a model's skin moves the model itself, which no map can show: found one, expected wrinkles or \
                   other effects on the surface; `wirework apply` is for limbs";
    Err(JobError::Request(message.to_owned()))
}

/// Refuses maps that are larger than what may be decoded, before any of them is made.
fn room(job: &MapJob<'_>, shares: usize) -> Result<(), JobError> {
    let (bytes, limit) = (Maps::bytes(job.settings.size, shares), job.limits.expanded_bytes);
    if bytes > limit { Err(JobError::MapSize { bytes, limit }) } else { Ok(()) }
}

/// What of the maps may not look as it is meant to.
fn doubts(facts: &Facts) -> Vec<String> {
    let part = |n: u64, of: u64| 100.0 * n as f64 / of.max(1) as f64;
    let mut out = Vec::new();
    let Facts { samples, covered, overlapping, folded, wrapped, degenerate, tiled } = *facts;
    if covered == 0 {
        out.push("no texel is covered: the maps are flat [map-empty]".to_owned());
    }
    if overlapping > 0 {
        out.push(format!(
            "islands overlap on {:.2} % of what they cover ({:.2} % of the map): the first is seen there; `--node`, \
             `--material` and `--uv` choose one [map-overlap]",
            part(overlapping, covered),
            part(overlapping, samples)
        ));
    }
    if folded > 0 {
        out.push(format!(
            "the surface turns by 90 degrees or more on {:.2} % of what is covered, which no normal map can show \
             [map-folded]",
            part(folded, covered)
        ));
    }
    if wrapped > 0 {
        out.push(format!(
            "{} beyond the map, where a repeating texture comes in again on the other side [map-wrapped]",
            if wrapped == 1 { "1 triangle lies".to_owned() } else { format!("{wrapped} triangles lie") }
        ));
    }
    if degenerate > 0 {
        let what = count(degenerate, "triangle");
        out.push(format!("{what} without an area in texture coordinates: left out [map-degenerate]"));
    }
    if tiled > 0 {
        let (what, most) = (count(tiled, "triangle"), Facts::TILES);
        out.push(format!(
            "{what} over more than {most} tiles of the map, or too far away: left out [map-tiled]"
        ));
    }
    out
}

fn write(job: &MapJob<'_>, target: &MapTarget, maps: &Maps, report: &mut MapReport) -> Result<(), JobError> {
    let texts = texts(report);
    let texts: Vec<(&str, &str)> = texts.iter().map(|(keyword, text)| (*keyword, text.as_str())).collect();
    let heights = map::gray(maps, report.height.reach, &texts)?;
    let normals = map::normals(maps, job.depth, job.flip_green, &[])?;
    let mut files = vec![target.file("normal.png", normals), target.file("height.png", heights)];
    let groups: usize = report.masks.iter().map(|mask| mask.groups.len()).sum();
    for (index, mask) in report.masks.iter().enumerate() {
        let bytes = map::shares(maps, index * map::CHANNELS, groups)?;
        files.push(OutputFile {
            folders: target.folders,
            ..OutputFile::new(target.beside(&mask.file), bytes)
        });
    }
    let name = |file: &OutputFile| file.path.file_name().map(|name| name.to_string_lossy().into_owned());
    report.files = files.iter().filter_map(name).collect();
    files.push(target.file("map.json", report.to_json().into_bytes()));
    report.paths = files.iter().map(|file| file.path.clone()).collect();
    if !job.dry_run {
        write_files(&files)?;
    }
    Ok(())
}

fn ms(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Where the points of an effect are, for those who only look.
pub(crate) fn squares(motion: &Motion<'_>) -> f64 {
    let way = |(p, q): (&[f32; 3], &[f32; 3])| {
        p.iter().zip(q).map(|(a, b)| (f64::from(*b) - f64::from(*a)).powi(2)).sum::<f64>()
    };
    motion.before().iter().zip(&motion.now).map(way).sum()
}
