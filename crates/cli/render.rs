//! `wirework render`.

use wirework::asset::printable;
use wirework::{Fault, FileKind, JobError, PictureJob, PictureReport, Shown, Viewpoint, When, picture};

use crate::args::Render;
use crate::console::Console;
use crate::exit::Failure;
use crate::{diagnostics, presets};

pub(crate) fn run(console: Console, args: &Render) -> Result<(), Failure> {
    // What is no model by its name or its first bytes is a preset.
    if presets::is_preset(&args.shown) || FileKind::of(&args.shown).is_none() {
        let preset =
            presets::read(console, &args.shown, &args.limits.preset(args.input.is_some()), args.strict)?;
        let shown = Shown::Preset {
            preset: &preset.parsed.preset,
            path: presets::named(&args.shown),
            input: args.input.as_deref(),
        };
        return make(console, args, shown, |error| diagnostics::fail(console, &preset, error));
    }
    if args.input.is_some() {
        let name = printable(&args.shown.display().to_string());
        let message = format!("{name}: found a model, expected a preset before the model it is shown on");
        return Err(Failure::new(Fault::Request, message));
    }
    make(console, args, Shown::Asset(&args.shown), Failure::from)
}

fn make(
    console: Console,
    args: &Render,
    shown: Shown<'_>,
    fail: impl FnOnce(JobError) -> Failure,
) -> Result<(), Failure> {
    let made = picture(&job(args, shown), &mut |progress| console.progress(progress));
    let report = made.map_err(|error| {
        console.end_progress();
        console.fail_strict(&error);
        fail(error)
    })?;
    tell(console, args, &report);
    Ok(())
}

fn job<'a>(args: &'a Render, shown: Shown<'a>) -> PictureJob<'a> {
    let job = PictureJob::new(shown, &args.output);
    PictureJob {
        when: match (&args.frames, args.at) {
            (Some(frames), _) => When::Frames(frames.clone()),
            (None, Some(seconds)) => When::At(seconds),
            (None, None) => When::All,
        },
        fps: args.fps,
        max_frames: args.limits.max_frames.unwrap_or(job.max_frames),
        size: args.size,
        viewpoint: Viewpoint {
            view: args.view,
            eye: args.eye,
            target: args.target,
            zoom: args.zoom.map(|zoom| zoom as f32),
        },
        wires: args.wires,
        sheet: args.sheet,
        compare: args.compare,
        fast: args.fast,
        clip: args.clip.as_deref(),
        limits: args.limits.asset(),
        threads: args.threads,
        strict: args.strict,
        ..job
    }
}

fn tell(console: Console, args: &Render, report: &PictureReport) {
    for warning in &report.warnings {
        console.warn(warning);
    }
    console.detail(&format!(
        "prepare {:.0} ms, render {:.0} ms, write {:.0} ms",
        report.prepare_ms, report.render_ms, report.write_ms
    ));
    let [width, height] = report.size;
    let what = match (report.files, report.moments) {
        (files @ 2.., _) => format!("{files} pictures of {width}×{height}"),
        (_, 1) => format!("{width}×{height}{}", moment(report)),
        (_, moments) => format!("{moments} moments, {width}×{height}"),
    };
    let total = (report.prepare_ms + report.render_ms + report.write_ms) / 1e3;
    let path = printable(&args.output.display().to_string());
    console.note(&format!("wrote {path}: {what}, {total:.2} s"));
}

/// Which moment a picture shows, where there was a choice.
fn moment(report: &PictureReport) -> String {
    let seconds = report.first;
    if report.chosen {
        format!(", at {seconds:.2} s, where the effect has moved most (--at SECONDS chooses)")
    } else if seconds == 0.0 {
        String::new()
    } else {
        format!(", at {seconds:.2} s")
    }
}
