//! What is wrong with a preset, and where: plain data that any renderer can draw.

use std::fmt::{self, Display, Write as _};
use std::ops::Range;

use thiserror::Error;

/// One thing that is wrong with a preset, or worth a warning, at its place in the source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PresetError {
    /// What was found and what was expected; one line, control characters escaped.
    pub message: String,
    /// The bytes of the source it is about, for a caret. May be empty, at the end of the source for instance.
    pub span: Range<usize>,
    /// Line of the span's start, from 1.
    pub line: usize,
    /// Column of the span's start in characters, from 1.
    pub column: usize,
    /// What to do about it, the nearest valid name for instance.
    pub help: Option<String>,
    /// Which value, for instance `wires[0].locators[2].u`; empty for the whole preset and for syntax errors.
    pub path: String,
    /// What kind of error.
    pub kind: PresetErrorKind,
}

/// The kinds of preset errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PresetErrorKind {
    /// The text is not RON, or not UTF-8.
    Syntax,
    /// A field or variant has a name that does not exist, stands twice, or is missing.
    Name,
    /// A value has another type than expected, or lies outside its range.
    Value,
    /// The preset was written for a newer version of its format.
    Version,
    /// The preset, or the object it names, is larger than the limits allow.
    Limit,
}

impl Display for PresetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)?;
        match &self.help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

/// All that was found wrong with a preset, in the order of the source; never empty.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct PresetErrors(Vec<PresetError>);

impl PresetErrors {
    /// Puts errors, at least one, in order.
    pub(crate) fn new(mut errors: Vec<PresetError>) -> Self {
        errors.sort_by_key(|error| error.span.start);
        errors.dedup();
        Self(errors)
    }

    /// The errors, in the order of the source.
    pub fn errors(&self) -> &[PresetError] {
        &self.0
    }

    /// Whether a limit was reached: then the tool's exit code is a limit's and not a preset's.
    pub fn is_limit(&self) -> bool {
        self.0.iter().all(|error| error.kind == PresetErrorKind::Limit)
    }
}

impl Display for PresetErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_char('\n')?;
            }
            error.fmt(f)?;
        }
        Ok(())
    }
}

/// How much of a name or text is quoted in a message.
const QUOTE_CHARS: usize = 60;

/// Text from a preset as it may be shown: control characters escaped, long text cut.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::new();
    for (i, c) in text.chars().enumerate() {
        if i == QUOTE_CHARS {
            out.push('…');
            break;
        }
        // Besides control characters, the invisible marks that reorder or hide text on a terminal.
        if c.is_control()
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
        {
            out.extend(c.escape_unicode());
        } else {
            out.push(c);
        }
    }
    out
}

/// `a`, `b` or `c`, each in backquotes.
pub(crate) fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

/// The valid name nearest to a mistyped one, where one is near: up to one edit for each three letters, and not of all.
pub(crate) fn nearest<'a>(found: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer names are no slips of the pen, and the distance is quadratic in the length.
    if found.chars().count() > QUOTE_CHARS {
        return None;
    }
    let wanted = found.to_lowercase();
    let letters = wanted.chars().count();
    let reach = letters.div_ceil(3).min(letters.saturating_sub(1));
    names
        .into_iter()
        .map(|name| (name.to_lowercase(), name))
        // They are at least as far apart as they differ in length, and long ones take long to compare.
        .filter(|(lower, _)| lower.chars().count().abs_diff(letters) <= reach)
        .map(|(lower, name)| (strsim::osa_distance(&wanted, &lower), name))
        .filter(|&(distance, _)| distance <= reach)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}
