//! `wirework check`.

use std::path::Path;

use wirework::asset::printable;
use wirework::{ApplyError, PresetFile, Subject, check_images};

use crate::args::Check;
use crate::console::Console;
use crate::exit::Failure;
use crate::{diagnostics, presets};

/// Checks every preset; the first failure gives the exit code.
pub(crate) fn run(console: Console, args: &Check) -> Result<(), Failure> {
    let mut failure: Option<Failure> = None;
    for path in &args.presets {
        match one(console, path, args) {
            Ok(file) => console.note(&format!("{}: ok", printable(&file))),
            Err(mut found) => {
                if let Some(message) = found.message.take() {
                    console.fail(&message);
                }
                failure.get_or_insert(found);
            }
        }
    }
    failure.map_or(Ok(()), Err)
}

fn one(console: Console, path: &Path, args: &Check) -> Result<String, Failure> {
    let preset = presets::read(console, path, &args.limits.preset(), args.strict)?;
    match fit(&preset, path, args) {
        Ok(warnings) if args.strict && !warnings.is_empty() => {
            for warning in &warnings {
                console.fail(warning);
            }
            Err(Failure::from(ApplyError::Strict(warnings)))
        }
        Ok(warnings) => {
            for warning in &warnings {
                console.warn(warning);
            }
            Ok(preset.file)
        }
        Err(error) => {
            let mut failure = diagnostics::fail(console, &preset, error);
            failure.message =
                failure.message.map(|message| format!("{}: {message}", printable(&preset.file)));
            Err(failure)
        }
    }
}

/// Whether a preset fits its own object; without one, whether what it reads is there.
fn fit(preset: &PresetFile, path: &Path, args: &Check) -> Result<Vec<String>, ApplyError> {
    let (path, preset) = (presets::named(path), &preset.parsed.preset);
    let (folder, limits) = (path.parent().unwrap_or(Path::new("")), args.limits.asset());
    let Some(subject) = Subject::from_preset(preset, path, &limits)? else {
        check_images(&preset.effects, folder, &limits)?;
        return Ok(Vec::new());
    };
    let mut now = subject.points.clone();
    let mut evaluation = subject.bind(preset, folder, &limits)?;
    evaluation.at(0.0, &mut now)?;
    if let Some(point) = now.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(ApplyError::OutOfRange { point, seconds: 0.0 });
    }
    let mut warnings = subject.warnings();
    warnings.extend(evaluation.warnings());
    Ok(warnings)
}
