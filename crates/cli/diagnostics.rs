//! Errors and warnings of presets with the line they are about and a caret.

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use wirework::asset::printable;
use wirework::preset::PresetError;
use wirework::{Fault, JobError, PresetFile, PresetFileError};

use crate::console::{Console, say};
use crate::exit::Failure;

/// How many are shown of one file: more scroll away.
const MOST: usize = 20;

/// A byte order mark. It is no character of the first line.
const MARK: &str = "\u{feff}";

/// Says why a preset is refused.
pub(crate) fn refuse(console: Console, error: &PresetFileError) -> Failure {
    match error {
        PresetFileError::Content { file, text, errors } => {
            for error in errors.errors().iter().take(MOST) {
                say(&draw(console, Level::ERROR, file, text, error));
            }
            if errors.errors().len() > MOST {
                say(&format!("and {} more errors", errors.errors().len() - MOST));
            }
            Failure::said(if errors.is_limit() { Fault::Limit } else { Fault::Preset })
        }
        other => Failure::new(Fault::Preset, other.to_string()),
    }
}

/// Says why an effect is not applied: where the preset is at fault at a place of it, with that place.
pub(crate) fn fail(console: Console, preset: &PresetFile, error: JobError) -> Failure {
    let JobError::Preset(found) = &error else { return Failure::from(error) };
    say(&draw(console, Level::ERROR, &preset.file, &preset.text, found));
    Failure::said(error.fault())
}

/// Shows the warnings of a preset; with `strict` they are errors and end the work.
pub(crate) fn warn(console: Console, preset: &PresetFile, strict: bool) -> Result<(), Failure> {
    let warnings = &preset.parsed.warnings;
    for warning in warnings.iter().take(MOST) {
        let level = if strict { Level::ERROR } else { Level::WARNING };
        let text = draw(console, level, &preset.file, &preset.text, warning);
        if strict { say(&text) } else { console.note(&text) }
    }
    if warnings.len() > MOST {
        console.note(&format!("and {} more warnings", warnings.len() - MOST));
    }
    if strict && !warnings.is_empty() { Err(Failure::said(Fault::Preset)) } else { Ok(()) }
}

/// Shows what a preset asks for and an object lacks. That is an error, but a warning where it is the preset's own object and
/// not `strict`: a model that it is for may have it.
pub(crate) fn lacks(
    console: Console,
    preset: &PresetFile,
    missing: &[PresetError],
    own: bool,
    strict: bool,
) -> Result<(), Failure> {
    const NOTE: &str = "this is about the preset's own object; `--on MODEL` checks against a model";
    let warn = own && !strict;
    let tell = |line: &str| if warn { console.note(line) } else { say(line) };
    for error in missing.iter().take(MOST) {
        let help = match &error.help {
            Some(help) if own => Some(format!("{help} ({NOTE})")),
            None if own => Some(NOTE.to_owned()),
            help => help.clone(),
        };
        let error = PresetError { help, ..error.clone() };
        let level = if warn { Level::WARNING } else { Level::ERROR };
        tell(&draw(console, level, &preset.file, &preset.text, &error));
    }
    if missing.len() > MOST {
        tell(&format!("and {} more {}", missing.len() - MOST, if warn { "warnings" } else { "errors" }));
    }
    if warn || missing.is_empty() { Ok(()) } else { Err(Failure::said(Fault::Preset)) }
}

fn draw(console: Console, level: Level<'_>, file: &str, text: &[u8], error: &PresetError) -> String {
    let valid = match std::str::from_utf8(text) {
        Ok(text) => text,
        Err(error) => str::from_utf8(&text[..error.valid_up_to()]).unwrap_or_default(),
    };
    let (source, offset) = valid.strip_prefix(MARK).map_or((valid, 0), |source| (source, MARK.len()));
    let bound = |byte: usize| source.floor_char_boundary(byte.saturating_sub(offset).min(source.len()));
    let (start, end) = (bound(error.span.start), bound(error.span.end));
    // A span over many lines is shown by its first: a caret under a whole wire would be many lines long.
    let line = source[start..end.max(start)].find(['\n', '\r']).map_or(end.max(start), |at| start + at);
    let path = printable(file);
    let place = if error.path.is_empty() { String::new() } else { format!("at {}", printable(&error.path)) };
    let annotation = AnnotationKind::Primary.span(start..line).label(place);
    let snippet = Snippet::source(source).path(&path).line_start(1).annotation(annotation);
    let mut group = level.primary_title(&error.message).element(snippet);
    if let Some(help) = &error.help {
        group = group.element(Level::HELP.message(help));
    }
    let renderer = if console.color() { Renderer::styled() } else { Renderer::plain() };
    renderer.render(&[group])
}
