//! From values as typed to values that are known to be good.
//!
//! Every reading function takes a node and gives the checked value, or notes an error at the node and gives `None`;
//! reading goes on with a default, so that one run finds all that is wrong. Whoever calls [`Reader::into_result`]
//! never sees a value that stands in for a bad one.

mod keyed;
mod values;

use std::collections::BTreeSet;
use std::ops::Range;

pub(crate) use values::Within;

use crate::error::{PresetError, PresetErrorKind, PresetErrors, escape, nearest, one_of};
use crate::limits::Limits;
use crate::places::Places;
use crate::scope::{Named, Place};
use crate::tree::{Body, Entry, Name, Node};
use crate::typed::Typed;

/// Errors after this many are not noted, nor are warnings; nobody reads them.
const MOST_NOTED: usize = 32;

/// Control points that the checks of curves look at, some 4 µs each; then the rest goes unchecked. Presets that somebody wrote need
/// far fewer, and what is refused here does no harm to the engine.
const MOST_LOOKS: u64 = 1 << 19;

/// Where a reader stands, and what it has found wrong.
pub(crate) struct Reader<'s> {
    source: &'s str,
    places: Places<'s>,
    /// Bytes of the file before `source`: a byte order mark.
    offset: usize,
    path: Vec<String>,
    errors: Vec<PresetError>,
    warnings: Vec<PresetError>,
    pub(crate) limits: Limits,
    /// Bytes that generated wires would have if they were typed.
    pub(crate) generated: u64,
    /// Control points that checks of curves may still look at.
    looks: u64,
}

/// The fields of one named struct while they are read.
pub(crate) struct Fields<'n> {
    owner: &'static str,
    span: Range<usize>,
    entries: &'n [Entry],
    known: Vec<&'static str>,
}

impl<'n> Fields<'n> {
    /// The field as typed, if it is there. Every field that exists is asked for once.
    pub(crate) fn get(&mut self, key: &'static str) -> Option<&'n Node> {
        self.known.push(key);
        self.again(key)
    }

    /// A field that was asked for before.
    pub(crate) fn again(&self, key: &str) -> Option<&'n Node> {
        self.entries.iter().find(|entry| entry.key.text == key).map(|entry| &entry.value)
    }

    /// Whether another name may be meant to be `key`: that is reported once, as unknown.
    pub(crate) fn misspelt(&self, key: &str) -> bool {
        self.entries.iter().any(|entry| {
            !self.known.contains(&entry.key.text.as_str()) && nearest(&entry.key.text, [key]).is_some()
        })
    }
}

impl<'s> Reader<'s> {
    /// A reader of `source`, which begins `offset` bytes into its file.
    pub(crate) fn new(source: &'s str, offset: usize, limits: Limits) -> Self {
        Self {
            source,
            places: Places::new(source),
            offset,
            path: Vec::new(),
            errors: Vec::new(),
            warnings: Vec::new(),
            limits,
            generated: 0,
            looks: MOST_LOOKS,
        }
    }

    /// The value and the warnings, or the errors.
    pub(crate) fn into_result<T>(self, value: Option<T>) -> Result<(T, Vec<PresetError>), PresetErrors> {
        match value {
            Some(value) if self.errors.is_empty() => Ok((value, self.warnings)),
            _ => Err(self.into_errors()),
        }
    }

    /// The errors, of which there is at least one: whatever reads nothing notes why.
    pub(crate) fn into_errors(mut self) -> PresetErrors {
        if self.errors.is_empty() {
            self.error(PresetErrorKind::Value, &(0..0), "the preset cannot be read", None);
        }
        PresetErrors::new(self.errors)
    }

    fn describe(
        &self,
        kind: PresetErrorKind,
        span: &Range<usize>,
        message: String,
        help: Option<String>,
    ) -> PresetError {
        self.place(span).error(kind, message, help)
    }

    /// The place of `span` in the file.
    fn place(&self, span: &Range<usize>) -> Place {
        let (line, column) = self.places.line_column(span.start);
        let span = span.start + self.offset..span.end + self.offset;
        Place { span, line, column, path: self.path.concat() }
    }

    /// A name that is looked up later.
    pub(crate) fn named(&self, name: &str, span: &Range<usize>) -> Named {
        Named::at(name, self.place(span))
    }

    /// Where an effect stands that is being read.
    pub(crate) fn typed(&self) -> Typed {
        Typed::at(self.path.concat())
    }

    /// Takes looks at so many control points from those that are left; none where there are too few.
    pub(crate) fn look(&mut self, points: usize) -> Option<()> {
        self.looks = self.looks.checked_sub(points as u64)?;
        Some(())
    }

    /// Notes an error.
    pub(crate) fn error(
        &mut self,
        kind: PresetErrorKind,
        span: &Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) {
        if self.errors.len() < MOST_NOTED {
            self.errors.push(self.describe(kind, span, message.into(), help));
        }
    }

    /// Notes a bad value and gives `None`.
    pub(crate) fn bad<T>(&mut self, node: &Node, message: impl Into<String>) -> Option<T> {
        self.error(PresetErrorKind::Value, &node.span, message, None);
        None
    }

    /// Notes what works but is hardly meant.
    pub(crate) fn warn(&mut self, span: &Range<usize>, message: impl Into<String>) {
        if self.warnings.len() < MOST_NOTED {
            let warning = self.describe(PresetErrorKind::Value, span, message.into(), None);
            self.warnings.push(warning);
        }
    }

    /// Notes that `node` is of another type than expected, and gives `None`.
    pub(crate) fn mismatch<T>(&mut self, node: &Node, expected: &str) -> Option<T> {
        self.bad(node, format!("expected {expected}, found {}", found(node)))
    }

    /// Reads at a deeper place of the path.
    pub(crate) fn within<T>(&mut self, step: impl Into<String>, read: impl FnOnce(&mut Self) -> T) -> T {
        let mut step = step.into();
        if !step.starts_with('[') && !self.path.is_empty() {
            step.insert(0, '.');
        }
        self.path.push(step);
        let value = read(self);
        self.path.pop();
        value
    }

    /// The name of the field that is being read, for messages.
    fn field_name(&self) -> String {
        let field = self.path.iter().rev().find(|step| !step.starts_with('['));
        field.map_or("the value".to_owned(), |step| format!("`{}`", step.trim_start_matches('.')))
    }

    /// Notes a name that does not exist.
    pub(crate) fn unknown_name(&mut self, name: &Name, what: &str, expected: &[&str]) {
        let help =
            nearest(&name.text, expected.iter().copied()).map(|near| format!("did you mean `{near}`?"));
        let message = format!(
            "there is no {what} `{}`; expected {}",
            escape(&name.text),
            one_of(expected.iter().copied())
        );
        self.error(PresetErrorKind::Name, &name.span, message, help);
    }

    /// Notes that no `what` has the name `name`, among those with the names `known`.
    pub(crate) fn unknown_text<'a>(
        &mut self,
        name: &str,
        span: &Range<usize>,
        what: &str,
        known: impl Iterator<Item = &'a str>,
    ) {
        if self.errors.len() < MOST_NOTED {
            let known: Vec<&str> = known.collect();
            self.errors.push(self.named(name, span).unknown(what, &known));
        }
    }

    /// Notes that a struct lacks something, at its name where it has one.
    pub(crate) fn lacks(&mut self, fields: &Fields<'_>, message: impl Into<String>) {
        let start = fields.span.start;
        let head = start..(start + fields.owner.len()).min(fields.span.end);
        let named = self.source.get(head.clone()) == Some(fields.owner);
        let span = if named { head } else { start..start + 1 };
        self.error(PresetErrorKind::Name, &span, message, None);
    }

    /// Opens `Owner(field: value, ..)`; the name may be left out.
    pub(crate) fn fields<'n>(&mut self, node: &'n Node, owner: &'static str) -> Option<Fields<'n>> {
        if let Some(name) = node.name.as_ref().filter(|name| name.text != owner) {
            self.unknown_name(name, "struct", &[owner]);
            return None;
        }
        self.unnamed_fields(node, owner)
    }

    /// Opens the fields of a node whose name was looked at before.
    pub(crate) fn unnamed_fields<'n>(&mut self, node: &'n Node, owner: &'static str) -> Option<Fields<'n>> {
        let entries = match &node.body {
            Body::Fields(entries) => entries.as_slice(),
            Body::Tuple(items) if items.is_empty() => &[],
            // A variant around a struct may be written with both parentheses.
            Body::Tuple(items) => match items.as_slice() {
                [inner] if matches!(inner.body, Body::Fields(_)) => return self.fields(inner, owner),
                _ => return self.mismatch(node, &format!("`{owner}(field: value, ..)`")),
            },
            _ => return self.mismatch(node, &format!("`{owner}(field: value, ..)`")),
        };
        let mut before = BTreeSet::new();
        for entry in entries {
            if !before.insert(&entry.key.text) {
                let message = format!("the field `{}` stands here twice", escape(&entry.key.text));
                self.error(PresetErrorKind::Name, &entry.key.span, message, None);
            }
        }
        Some(Fields { owner, span: node.span.clone(), entries, known: Vec::new() })
    }

    /// A field with a default, which also stands in for a bad value.
    pub(crate) fn field<'n, T>(
        &mut self,
        fields: &mut Fields<'n>,
        key: &'static str,
        default: T,
        read: impl FnOnce(&mut Self, &'n Node) -> Option<T>,
    ) -> T {
        match fields.get(key) {
            None => default,
            Some(node) => self.within(key, |reader| read(reader, node)).unwrap_or(default),
        }
    }

    /// A field that must be there.
    pub(crate) fn required<'n, T>(
        &mut self,
        fields: &mut Fields<'n>,
        key: &'static str,
        read: impl FnOnce(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<T> {
        if let Some(node) = fields.get(key) {
            return self.within(key, |reader| read(reader, node));
        }
        if !fields.misspelt(key) {
            self.lacks(fields, format!("`{}` needs a field `{key}`", fields.owner));
        }
        None
    }

    /// A field that may be `None`, `Some(value)` or the value alone.
    pub(crate) fn optional<'n, T>(
        &mut self,
        fields: &mut Fields<'n>,
        key: &'static str,
        read: impl FnOnce(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<T> {
        let node = fields.get(key)?;
        if node.is_bare("None") {
            return None;
        }
        self.within(key, |reader| read(reader, node.unwrap_some()))
    }

    /// Closes a struct: fields that were not asked for do not exist.
    pub(crate) fn finish(&mut self, fields: Fields<'_>) {
        let Fields { owner, entries, known, .. } = fields;
        let unknown = entries.iter().filter(|entry| !known.contains(&entry.key.text.as_str()));
        for entry in unknown.take(MOST_NOTED) {
            let help =
                nearest(&entry.key.text, known.iter().copied()).map(|near| format!("did you mean `{near}`?"));
            let message = format!(
                "`{owner}` has no field `{}`; expected {}",
                escape(&entry.key.text),
                one_of(known.iter().copied())
            );
            self.error(PresetErrorKind::Name, &entry.key.span, message, help);
        }
    }
}

/// What a node is, in words.
pub(crate) fn found(node: &Node) -> String {
    if let Some(name) = &node.name {
        return format!("`{}`", escape(&name.text));
    }
    match &node.body {
        Body::Bare => "nothing".to_owned(),
        Body::Fields(_) => "named fields".to_owned(),
        Body::Tuple(items) if items.len() == 1 => "1 value in parentheses".to_owned(),
        Body::Tuple(items) => format!("{} values in parentheses", items.len()),
        Body::List(_) => "a list".to_owned(),
        Body::Number { value, .. } => format!("`{value}`"),
        Body::Text(text) => format!("the text \"{}\"", escape(text)),
        Body::Bool(value) => format!("`{value}`"),
        Body::Other(what) => (*what).to_owned(),
    }
}
