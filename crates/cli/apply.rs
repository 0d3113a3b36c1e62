//! `wirework apply`.

use std::path::Path;

use wirework::asset::{check_output, printable};
use wirework::preset::{Action, Effect};
use wirework::{
    BakeReport, CacheFacts, Fault, FinerMesh, Job, JobError, Report, Skeleton, VatFacts, VatJob, When, bake,
};

use crate::args::{Apply, Bake, VatFormat, VatNormals};
use crate::console::{Console, write_report};
use crate::exit::Failure;
use crate::{diagnostics, presets};

pub(crate) fn run(console: Console, args: &Apply) -> Result<(), Failure> {
    let bake = bake(args.bake);
    if args.joints > 0 && bake != bake::Bake::Skin {
        let message = "`--joints` puts joints on the bones of a skeleton: it needs `--bake skin`";
        return Err(Failure::new(Fault::Request, message.to_owned()));
    }
    let report_file = args.report.as_deref().filter(|path| *path != Path::new("-"));
    // A run that fails leaves what stood there.
    report_file.map_or(Ok(()), check_output).map_err(JobError::from)?;
    let preset =
        presets::read(console, &args.preset, &args.limits.preset(args.input.is_some()), args.strict)?;
    let job = Job {
        input: args.input.as_deref(),
        output: args.output.as_deref(),
        caches: args.cache.clone(),
        vat: vat(args),
        in_place: args.in_place,
        report: report_file,
        dry_run: args.dry_run,
        fps: args.fps,
        when: match (&args.frames, args.at) {
            (Some(frames), _) => When::Frames(frames.clone()),
            (None, Some(seconds)) => When::At(seconds),
            (None, None) => When::All,
        },
        bake,
        joints: usize::from(args.joints),
        tolerance: args.tolerance,
        max_targets: args.max_targets,
        clip: args.clip.as_deref(),
        into: Some(args.into.as_str()).filter(|into| *into != "new"),
        limits: args.limits.asset(),
        threads: args.threads,
        strict: args.strict,
        ..Job::new(&preset.parsed.preset, presets::named(&args.preset))
    };
    let job = Job { max_frames: args.limits.max_frames.unwrap_or(job.max_frames), ..job };
    let report = wirework::apply(&job, &mut |progress| console.progress(progress)).map_err(|error| {
        console.end_progress();
        console.fail_strict(&error);
        diagnostics::fail(console, &preset, error)
    })?;
    tell(console, args, &preset.parsed.preset.effects, &report)?;
    Ok(())
}

/// The texture that is asked for.
fn vat(args: &Apply) -> Option<VatJob<'_>> {
    let format = match args.vat_format {
        VatFormat::Png => bake::VatFormat::Png,
        VatFormat::Exr => bake::VatFormat::Exr,
    };
    let normals = match args.vat_normals {
        VatNormals::Packed => bake::VatNormals::Packed,
        VatNormals::Separate => bake::VatNormals::Separate,
    };
    args.vat.as_deref().map(|folder| VatJob { folder, format, normals })
}

/// How frames are baked.
fn bake(asked: Bake) -> bake::Bake {
    match asked {
        Bake::Auto => bake::Bake::Auto,
        Bake::Keys => bake::Bake::Keys,
        Bake::Basis => bake::Bake::Basis,
        Bake::Frames => bake::Bake::Frames,
        Bake::Skin => bake::Bake::Skin,
    }
}

/// Where effects have meshes made finer.
fn finer_where(effects: &[Effect]) -> &'static str {
    let sews = effects.iter().any(|effect| matches!(effect.action, Action::Stitch(_)));
    match (effects.iter().any(|effect| effect.refine), sews) {
        (false, true) => "along its seams",
        (true, true) => "where it folds and along its seams",
        (_, false) => "where it folds",
    }
}

fn tell(console: Console, args: &Apply, effects: &[Effect], report: &Report) -> Result<(), Failure> {
    for warning in &report.warnings {
        console.warn(warning);
    }
    for note in &report.notes {
        console.note(note);
    }
    let Report { points, wires, frames, threads, .. } = report;
    console.detail(&format!(
        "bind {:.1} ms, deform {:.1} ms, normals {:.1} ms, write {:.1} ms, {threads} threads, {:.0} MB at most",
        report.bind_ms,
        report.deform_ms,
        report.normals_ms,
        report.write_ms,
        report.peak_bytes as f64 / 1e6
    ));
    for FinerMesh { name, before, after } in &report.refined {
        let place = finer_where(effects);
        console.note(&format!("mesh {}: {before} vertices are {after} {place}", printable(name)));
    }
    if let Some(skeleton) = &report.skeleton {
        let Skeleton { joints, made, residual, residual_of_diagonal, seconds, normals_degrees, .. } =
            skeleton;
        let of_them = if *made > 0 { format!(", {made} of them made for it") } else { String::new() };
        console.note(&format!(
            "a skeleton plays it: {joints} joints{of_them}; at most {residual:.2e} m, {residual_of_diagonal:.1e} of the diagonal, off the \
             effect itself, at {seconds:.2} s; normals at most {normals_degrees:.0}°"
        ));
        if let Some(gain) = skeleton.gains.iter().find(|gain| **gain != 1.0) {
            console.note(&format!("joints go {gain:.3} times as far as the control points of their wires"));
        }
    }
    if let Some(bake) = &report.bake {
        console.note(&played(bake));
    }
    tell_aside(console, report);
    let written = [args.output.as_ref(), args.vat.as_ref(), args.cache.first()].into_iter().flatten().next();
    let what = match (written, args.dry_run) {
        (Some(path), false) => format!("wrote {}", printable(&path.display().to_string())),
        _ => "dry run, nothing is written".to_owned(),
    };
    let plural = |n: &usize| if *n == 1 { "" } else { "s" };
    console.note(&format!(
        "{what}: {frames} frame{}, {wires} wire{}, {points} point{}, {:.2} s{}",
        plural(frames),
        plural(wires),
        plural(points),
        report.total_ms / 1e3,
        added(report).filter(|_| args.output.is_some() && !args.dry_run).unwrap_or_default()
    ));
    write_report(args.report.as_deref(), report.to_json())
}

/// What morph targets play the effect, and how well.
fn played(bake: &BakeReport) -> String {
    let most = bake.nodes.iter().max_by_key(|node| node.targets);
    let Some(most) = most else {
        return "the effect stays within the tolerance: there are no morph targets".to_owned();
    };
    let what = match (most.bake, most.targets) {
        ("keys", 1) => "one key pose plays it".to_owned(),
        ("keys", targets) => format!("{targets} key poses play it"),
        (_, 1) => "one shape plays it".to_owned(),
        (_, targets) => format!("a basis of {targets} shapes plays it"),
    };
    let meshes = match bake.nodes.len() {
        1 => String::new(),
        nodes => format!(", and no more on the other {} meshes", nodes - 1),
    };
    format!(
        "{what}{meshes}; at most {:.1e} m, {:.1e} of the diagonal, off; normals {:.2}° in the mean, {:.0}° at most",
        bake.error, bake.error_of_diagonal, bake.normal_mean_degrees, bake.normal_degrees
    )
}

/// What was written besides.
fn tell_aside(console: Console, report: &Report) {
    let name = |path: &Path| printable(&path.display().to_string());
    for CacheFacts { path, points, frames, .. } in &report.caches {
        let plural = if *frames == 1 { "" } else { "s" };
        console.note(&format!("{}: {frames} frame{plural} of {points} points", name(path)));
    }
    if let Some(VatFacts { folder, size: [width, height], vertices, frames, rounding, .. }) = &report.vat {
        console.note(&format!(
            "{}: a texture of {width}×{height} for {vertices} vertices in {frames} frames; at most {rounding:.1e} m are rounded away",
            name(folder)
        ));
    }
}

/// Where the animation is, if the input has clips of its own: many viewers play one at a time.
fn added(report: &Report) -> Option<String> {
    let clip = report.clip.as_ref().filter(|clip| clip.index > 0)?;
    let joins = match clip.could_join.as_slice() {
        [] => String::new(),
        _ if clip.plays.is_some() => ", which plays the input's own with it".to_owned(),
        [own] => format!(", --into {own} joins it with the input's own"),
        _ => ", --into CLIP joins it with one of the input's own".to_owned(),
    };
    Some(format!("; its clip is {} \"{}\"{joins}", clip.index, printable(&clip.name)))
}
