//! What the tests of bad presets share.

use wirework_preset::{Limits, PresetError, PresetErrorKind, parse};

/// All that is wrong with a text.
pub(crate) fn errors(text: &str) -> Vec<PresetError> {
    match parse(text.as_bytes(), &Limits::default()) {
        Ok(_) => Vec::new(),
        Err(errors) => errors.errors().to_vec(),
    }
}

/// The text with `«` and `»` taken out, and the bytes between them: where the error must be.
fn marked(text: &str) -> (String, std::ops::Range<usize>) {
    let start = text.find('«').expect("a mark");
    let end = text.find('»').expect("a mark") - '«'.len_utf8();
    (text.replace(['«', '»'], ""), start..end)
}

/// Checks that there is exactly one error, at the mark.
pub(crate) fn check(text: &str, kind: PresetErrorKind, message: &str, help: Option<&str>) {
    let (source, span) = marked(text);
    let found = errors(&source);
    let [error] = found.as_slice() else { panic!("{source}\n{} errors: {found:#?}", found.len()) };
    assert_eq!(source.get(error.span.clone()), source.get(span.clone()), "{source}\n{error:#?}");
    assert_eq!(error.span, span, "{source}\n{error:#?}");
    let line = 1 + source[..span.start].matches('\n').count();
    let column = 1 + source[..span.start].rsplit('\n').next().map_or(0, |text| text.chars().count());
    assert_eq!((error.line, error.column), (line, column), "{source}\n{error:#?}");
    assert!(error.message.contains(message), "{source}\n{error:#?}\nshould contain {message:?}");
    assert_eq!(error.kind, kind, "{source}\n{error:#?}");
    match help {
        Some(help) => assert!(error.help.as_deref().is_some_and(|h| h.contains(help)), "{error:#?}"),
        None => assert_eq!(error.help, None, "{source}"),
    }
    assert!(!error.message.contains('\n'), "{error:#?}");
}
