//! What `ron` says about text that is not RON, at its place and in a preset's words.

use std::ops::Range;

use crate::error::{PresetErrorKind, escape};
use crate::places::byte_at;
use crate::scan::{Scan, is_word};

/// Why a text is no tree: what, where, and of which kind.
pub(crate) struct Fault {
    pub(crate) message: String,
    pub(crate) span: Range<usize>,
    pub(crate) kind: PresetErrorKind,
    pub(crate) help: Option<String>,
}

/// Whether text ends in a name: what follows may have lost its colon.
fn after_name(text: &str) -> bool {
    let word = text.trim_end().rsplit(|c| !is_word(c)).next();
    word.and_then(|word| word.chars().next()).is_some_and(char::is_alphabetic)
}

/// A named field among values without a name, `Polyline([..], closed: true)`, where `ron` has read on to the byte `end` behind
/// the field's name.
fn unnamed(source: &str, end: usize) -> Option<Fault> {
    let before = source.get(..end)?.trim_end();
    let start = before
        .rfind(|c| !is_word(c))
        .map_or(0, |at| at + before[at..].chars().next().map_or(0, char::len_utf8));
    let mut scan = Scan::new(source, end);
    scan.space();
    let open = (scan.token().1 == ":").then(|| scan.open_before(start))??;
    let mut scan = Scan::new(source, open + 1);
    if !source.get(open..)?.starts_with('(') || scan.names_field() {
        return None;
    }
    let owner = source.get(..open)?.trim_end().rsplit(|c| !is_word(c)).next()?;
    let help = match (owner, scan.token().1.as_str()) {
        ("BSpline" | "Polyline" | "CatmullRom" | "Bezier" | "Points", "[") => "write `points: [..]`",
        ("File", "\"") => "write `path: \"..\"`",
        ("Image", "\"") => "write `file: \"..\"`",
        _ => "write `field: value` for each",
    };
    let field = escape(&before[start..]);
    Some(Fault {
        message: format!("a value without a name cannot stand beside the named field `{field}`"),
        span: start..before.len(),
        kind: PresetErrorKind::Syntax,
        help: Some(help.to_owned()),
    })
}

/// The fault that `ron` found.
pub(crate) fn fault(source: &str, error: &ron::error::SpannedError) -> Fault {
    use ron::Error as E;
    // These are about what stands at ron's cursor; of the others, ron says where they begin.
    let about_next = match &error.code {
        // ron reports a missing comma as a missing bracket, at the end of the value before.
        E::ExpectedStructLikeEnd | E::ExpectedOptionEnd => Some("expected `,` or `)`"),
        E::ExpectedArrayEnd => Some("expected `,` or `]`"),
        E::ExpectedMapEnd => Some("expected `,` or `}`"),
        E::ExpectedComma => Some("expected `,` or a closing bracket"),
        E::TrailingCharacters => Some("expected nothing after the preset"),
        E::Eof => Some("the preset ends too early"),
        E::ExpectedMapColon => Some("expected `:` after the name of a field"),
        E::ExpectedIdentifier => Some("expected the name of a field"),
        E::UnexpectedChar(_) => Some("expected a value"),
        _ => None,
    };
    let end = byte_at(source, error.span.end.line, error.span.end.col);
    let named = error.code == E::ExpectedComma && after_name(source.get(..end).unwrap_or(""));
    if let Some(fault) = named.then(|| unnamed(source, end)).flatten() {
        return fault;
    }
    let (span, message) = if let Some(expected) = about_next {
        let mut scan = Scan::new(source, end);
        scan.space();
        let (span, token) = scan.token();
        let expected =
            if named && token != ":" { "expected `:`, `,` or a closing bracket" } else { expected };
        let found = if scan.at_end() { String::new() } else { format!(", found `{token}`") };
        (span, expected.to_owned() + &found)
    } else {
        let start = byte_at(source, error.span.start.line, error.span.start.col);
        let text = escape(&error.code.to_string());
        let mut chars = text.chars();
        let first = chars.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
        (start..end.max(start), first + chars.as_str())
    };
    Fault { message, span, kind: PresetErrorKind::Syntax, help: None }
}
