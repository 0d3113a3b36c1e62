//! Presets from files and from standard input.

use std::io::Read;
use std::path::Path;

use wirework::preset::Limits;
use wirework::{Fault, PresetFile, parse_preset, read_preset};

use crate::console::Console;
use crate::diagnostics;
use crate::exit::Failure;

/// Reads a preset, `-` from standard input, and shows what is wrong with it.
pub(crate) fn read(
    console: Console,
    path: &Path,
    limits: &Limits,
    strict: bool,
) -> Result<PresetFile, Failure> {
    let result = if path == Path::new("-") {
        let mut text = Vec::new();
        let bytes = std::io::stdin().lock().take(limits.bytes.saturating_add(1)).read_to_end(&mut text);
        bytes.map_err(|error| {
            Failure::new(Fault::Preset, format!("standard input cannot be read: {error}"))
        })?;
        parse_preset("<stdin>".to_owned(), text, limits)
    } else {
        read_preset(path, limits)
    };
    let preset = result.map_err(|error| diagnostics::refuse(console, &error))?;
    diagnostics::warn(console, &preset, strict)?;
    Ok(preset)
}

/// The path of a preset. One from standard input stands in the current folder, and its object needs a name.
pub(crate) fn named(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new("preset.ron") } else { path }
}

/// Whether a file that may be a preset or a model is a preset, by its name.
pub(crate) fn is_preset(path: &Path) -> bool {
    let ron = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ron"));
    ron || path == Path::new("-")
}
