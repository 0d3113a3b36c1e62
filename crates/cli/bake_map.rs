//! `wirework bake-map`.

use std::path::Path;

use wirework::asset::{check_output, printable};
use wirework::bake::map::{self, Depth};
use wirework::{JobError, MapJob, MapReport, bake_map};

use crate::args::BakeMap;
use crate::console::{Console, write_report};
use crate::exit::Failure;
use crate::{diagnostics, presets};

pub(crate) fn run(console: Console, args: &BakeMap) -> Result<(), Failure> {
    let report_file = args.report.as_deref().filter(|path| *path != Path::new("-"));
    // A run that fails leaves what stood there.
    report_file.map_or(Ok(()), check_output).map_err(JobError::from)?;
    let preset =
        presets::read(console, &args.preset, &args.limits.preset(args.input.is_some()), args.strict)?;
    let job = MapJob::new(&preset.parsed.preset, presets::named(&args.preset), &args.output);
    let job = MapJob {
        input: args.input.as_deref(),
        at: args.at,
        settings: map::Settings { size: args.size, samples: args.samples, padding: args.padding },
        depth: if args.bits == "16" { Depth::Sixteen } else { Depth::Eight },
        flip_green: args.flip_green,
        node: args.node.as_deref(),
        material: args.material.as_deref(),
        uv: args.uv,
        refine: !args.no_refine,
        masks: args.masks.map(|groups| groups as usize),
        fps: args.fps,
        max_frames: args.limits.max_frames.unwrap_or(job.max_frames),
        clip: args.clip.as_deref(),
        limits: args.limits.asset(),
        report: report_file,
        dry_run: args.dry_run,
        threads: args.threads,
        strict: args.strict,
        ..job
    };
    let report = bake_map(&job, &mut |progress| console.progress(progress)).map_err(|error| {
        console.end_progress();
        console.fail_strict(&error);
        diagnostics::fail(console, &preset, error)
    })?;
    tell(console, args, &report);
    write_report(args.report.as_deref(), report.to_json())
}

fn tell(console: Console, args: &BakeMap, report: &MapReport) {
    for warning in &report.warnings {
        console.warn(warning);
    }
    console.detail(&format!(
        "prepare and bake {:.0} ms, write {:.0} ms, {} threads, {} triangles",
        report.prepare_ms, report.write_ms, report.threads, report.triangles
    ));
    let names: Vec<String> = report.meshes.iter().map(|mesh| printable(&mesh.name)).collect();
    console.note(&format!("for {}", names.join(", ")));
    let height = report.height;
    console.note(&format!(
        "heights from {:.4e} to {:.4e} m: metres = (value - {}) * {:.6e}",
        height.min, height.max, height.midlevel, height.scale
    ));
    let [width, down] = report.size;
    let moment = if report.chosen {
        format!(", at {:.2} s, where the effect has moved most (--at SECONDS chooses)", report.seconds)
    } else {
        format!(", at {:.2} s", report.seconds)
    };
    let what = if args.dry_run { "dry run, nothing is written of" } else { "wrote" };
    let files: Vec<String> = report.paths.iter().map(|path| printable(&path.display().to_string())).collect();
    let total = (report.prepare_ms + report.write_ms) / 1e3;
    console.note(&format!("{what} {}: {width}×{down}{moment}, {total:.2} s", files.join(", ")));
}
