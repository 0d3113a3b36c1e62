//! `wirework check`.

use std::path::Path;

use wirework::asset::printable;
use wirework::preset::PresetError;
use wirework::{Fault, FileKind, JobError, PresetFile, Subject, check_images};

use crate::args::Check;
use crate::console::Console;
use crate::exit::Failure;
use crate::{diagnostics, presets};

/// Checks every preset; the first failure gives the exit code.
pub(crate) fn run(console: Console, args: &Check) -> Result<(), Failure> {
    let limits = args.limits.asset();
    let model = args.on.as_deref().map(|path| Subject::read(path, &limits)).transpose()?;
    tell(console, model.as_ref().map_or_else(Vec::new, Subject::warnings), args)?;
    let mut failure: Option<Failure> = None;
    for path in &args.presets {
        match one(console, path, model.as_ref(), args) {
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

fn one(console: Console, path: &Path, model: Option<&Subject>, args: &Check) -> Result<String, Failure> {
    refuse_model(path)?;
    let preset = presets::read(console, path, &args.limits.preset(model.is_some()), args.strict)?;
    let Doubts { missing, warnings } = fit(&preset, path, model, args).map_err(|error| {
        let mut failure = diagnostics::fail(console, &preset, error);
        failure.message = failure.message.map(|message| format!("{}: {message}", printable(&preset.file)));
        failure
    })?;
    diagnostics::lacks(console, &preset, &missing, model.is_none(), args.strict)?;
    tell(console, warnings, args)?;
    Ok(preset.file)
}

/// Shows warnings; where they are taken as errors they end the work.
fn tell(console: Console, warnings: Vec<String>, args: &Check) -> Result<(), Failure> {
    let say = if args.strict { Console::fail } else { Console::warn };
    for warning in &warnings {
        say(console, warning);
    }
    if args.strict && !warnings.is_empty() { Err(JobError::Strict(warnings).into()) } else { Ok(()) }
}

/// Refuses a model in the place of a preset.
fn refuse_model(path: &Path) -> Result<(), Failure> {
    // A pipe without a name of its own is not to be touched: its first bytes would be lost.
    if (path.extension().is_some() || path.is_file()) && FileKind::of(path).is_some() {
        let name = printable(&path.display().to_string());
        let message =
            format!("{name}: found a model, expected a preset; `--on {name}` checks presets against it");
        return Err(Failure::new(Fault::Request, message));
    }
    Ok(())
}

/// What is hardly meant.
#[derive(Default)]
struct Doubts {
    /// What the preset asks for and the object lacks.
    missing: Vec<PresetError>,
    warnings: Vec<String>,
}

/// Whether a preset fits the model, or else its own object; without one, whether what it reads is there.
fn fit(file: &PresetFile, path: &Path, model: Option<&Subject>, args: &Check) -> Result<Doubts, JobError> {
    let (path, preset) = (presets::named(path), &file.parsed.preset);
    let (folder, limits) = (path.parent().unwrap_or(Path::new("")), args.limits.asset());
    // A model is shared between presets, but where pieces are put together on it.
    let own = match model {
        Some(_) if preset.pieces().is_empty() => None,
        _ => Subject::for_preset(model.cloned(), preset, path, &limits)?,
    };
    let Some(subject) = own.as_ref().or(model) else {
        check_images(&preset.effects, folder, &limits)?;
        return Ok(Doubts::default());
    };
    let (mut evaluation, missing) = subject.bind_lacking(preset, folder, &limits)?;
    let mut now = subject.points.clone();
    evaluation.at(0.0, &mut now)?;
    if let Some(point) = now.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(JobError::OutOfRange { point, seconds: 0.0 });
    }
    // Those of a model are told once for all presets.
    let mut warnings = if model.is_none() { subject.warnings() } else { Vec::new() };
    let name = printable(&file.file);
    warnings.extend(evaluation.warnings().into_iter().map(|warning| format!("{name}: {warning}")));
    Ok(Doubts { missing, warnings })
}
