//! Presets as files.

use std::path::Path;

use thiserror::Error;
use wirework_asset::printable;
use wirework_preset::{Limits, Parsed, PresetErrors, parse};

/// Why a preset file is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PresetFileError {
    /// The file cannot be read.
    #[error("{}: the preset cannot be read: {error}", printable(.file))]
    Read {
        /// The file.
        file: String,
        /// Why.
        error: std::io::Error,
    },
    /// There are errors in it.
    #[error("{}:{errors}", printable(.file))]
    Content {
        /// The file.
        file: String,
        /// What is in it, for showing the places of the errors.
        text: Vec<u8>,
        /// All of them.
        errors: PresetErrors,
    },
}

/// A preset, and the bytes it was read from.
#[derive(Clone, Debug)]
pub struct PresetFile {
    /// The file as it was named.
    pub file: String,
    /// What is in it, for showing the places of warnings.
    pub text: Vec<u8>,
    /// The preset and its warnings.
    pub parsed: Parsed,
}

/// Reads and checks a preset.
///
/// # Errors
///
/// The file cannot be read, or its content is not a preset.
pub fn read_preset(path: &Path, limits: &Limits) -> Result<PresetFile, PresetFileError> {
    let file = path.display().to_string();
    let read = || {
        use std::io::Read;
        let mut text = Vec::new();
        // One byte more than allowed is enough to see that there are too many.
        std::fs::File::open(path)?.take(limits.bytes.saturating_add(1)).read_to_end(&mut text)?;
        Ok(text)
    };
    match read() {
        Ok(text) => parse_preset(file, text, limits),
        Err(error) => Err(PresetFileError::Read { file, error }),
    }
}

/// Checks a preset from memory; `file` stands for it in messages.
///
/// # Errors
///
/// The content is not a preset.
pub fn parse_preset(file: String, text: Vec<u8>, limits: &Limits) -> Result<PresetFile, PresetFileError> {
    match parse(&text, limits) {
        Ok(parsed) => Ok(PresetFile { file, text, parsed }),
        Err(errors) => Err(PresetFileError::Content { file, text, errors }),
    }
}
