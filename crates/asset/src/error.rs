//! What can be wrong with an asset, and where: an [`AssetError`] ends the work, a [`Warning`] names a repair or a
//! part that is passed through as it is.

use std::fmt;

/// What kind of failure it is; the command line maps it to its exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorClass {
    /// The input cannot be read, is malformed, or asks for something that is not supported.
    Asset,
    /// The input is larger than a limit of [`Limits`](crate::Limits).
    Limit,
    /// The output cannot be written.
    Io,
}

/// Where in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The file as a whole.
    File,
    /// A JSON pointer (RFC 6901), such as `/accessors/3/byteOffset`.
    Pointer(String),
    /// A line of a text file, from 1.
    Line(usize),
    /// A byte of a binary file, from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            // The document itself.
            Self::Pointer(pointer) if pointer.is_empty() => Ok(()),
            Self::Pointer(pointer) => write!(f, ": {}", printable(pointer)),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Byte(byte) => write!(f, ": byte {byte}"),
        }
    }
}

/// Why an asset cannot be read or written: the file, the place in it, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{place}: found {}, expected {}", printable(.file), printable(.found), printable(.expected))]
#[non_exhaustive]
pub struct AssetError {
    /// The kind of failure.
    pub class: ErrorClass,
    /// The file, as it was named.
    pub file: String,
    /// The place in it.
    pub place: Place,
    /// What was found there.
    pub found: String,
    /// What was expected.
    pub expected: String,
}

impl AssetError {
    pub(crate) fn new(place: Place, found: impl Into<String>, expected: impl Into<String>) -> Self {
        let (found, expected) = (found.into(), expected.into());
        Self { class: ErrorClass::Asset, file: String::new(), place, found, expected }
    }

    /// A failure of the whole file.
    pub(crate) fn file(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::new(Place::File, found, expected)
    }

    /// A failure of the output `path`.
    pub(crate) fn output(path: &std::path::Path, error: &std::io::Error, doing: &str) -> Self {
        let mut fault = Self::file(error.to_string(), format!("to {doing} it"));
        fault.class = ErrorClass::Io;
        fault.file = path.display().to_string();
        fault
    }

    pub(crate) fn of_class(mut self, class: ErrorClass) -> Self {
        self.class = class;
        self
    }

    /// Names the file, unless one is named already.
    pub(crate) fn in_file(mut self, file: &str) -> Self {
        if self.file.is_empty() {
            file.clone_into(&mut self.file);
        }
        self
    }
}

/// Something in an input that was repaired, or left as it is although it is not right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// A stable name: `weights-sum`, `bounds`, `normals-missing`, `zero-area`, and so on; of what is passed through as it is
    /// `value`, `index`, `missing`, `view` or `accessor`, and `faults` for more of them.
    pub code: &'static str,
    /// Where it is.
    pub place: Place,
    /// What it is and what was done about it.
    pub message: String,
}

impl Warning {
    pub(crate) fn new(code: &'static str, place: Place, message: impl Into<String>) -> Self {
        Self { code, place, message: message.into() }
    }

    /// The warning that an error is passed over, and what was `done` instead.
    pub fn instead(error: &AssetError, code: &'static str, done: &str) -> Self {
        let message = format!("found {}, expected {}; {done}", error.found, error.expected);
        Self { code, place: error.place.clone(), message }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = self.place.to_string();
        let place = place.trim_start_matches([':', ' ']);
        let line = if matches!(self.place, Place::Line(_)) { "line " } else { "" };
        let colon = if place.is_empty() { "" } else { ": " };
        write!(f, "{line}{place}{colon}{} [{}]", printable(&self.message), self.code)
    }
}

/// The text with control characters and the characters that turn the direction of text escaped, so that a name
/// from a file can be printed on a terminal.
pub fn printable(text: &str) -> String {
    let hidden = |c: char| {
        c.is_control()
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if hidden(c) {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_file_place_found_and_expected_without_control_characters() {
        let place = Place::Pointer("/nodes/0/name\u{1b}[2J".into());
        let error = AssetError::new(place, "\u{7}", "a name").in_file("a.glb").in_file("b.glb");
        assert_eq!(error.to_string(), r"a.glb: /nodes/0/name\u{1b}[2J: found \u{7}, expected a name");
        let warning = Warning::new("zero-area", Place::Line(3), "two\nlines");
        assert_eq!(warning.to_string(), r"line 3: two\nlines [zero-area]");
    }
}
