//! From values as typed to values that are known to be good.
//!
//! Every reading function takes a node and gives the checked value, or notes an error at the node and gives `None`;
//! reading goes on with a default, so that one run finds all that is wrong. Whoever calls [`Reader::into_result`]
//! never sees a value that stands in for a bad one.

use std::ops::Range;

use wirework_core::{Interpolate, Keyed};

use crate::error::{PresetError, PresetErrorKind, PresetErrors, escape, line_column, nearest, one_of};
use crate::later;
use crate::limits::Limits;
use crate::tree::{Body, Entry, Name, Node};

/// Errors after this many are not noted; nobody reads them.
const MAX_ERRORS: usize = 32;

/// Where a reader stands, and what it has found wrong.
pub(crate) struct Reader<'s> {
    source: &'s str,
    /// Bytes of the file before `source`: a byte order mark.
    offset: usize,
    path: Vec<String>,
    errors: Vec<PresetError>,
    warnings: Vec<PresetError>,
    pub(crate) limits: Limits,
}

/// The range a number must lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Within {
    /// Any finite number.
    Finite,
    /// Greater than 0.
    Positive,
    /// 0 or greater.
    NotNegative,
    /// 0 to 1.
    Unit,
}

impl Within {
    fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Finite => true,
                Self::Positive => x > 0.0,
                Self::NotNegative => x >= 0.0,
                Self::Unit => (0.0..=1.0).contains(&x),
            }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Finite => "a finite number",
            Self::Positive => "greater than 0",
            Self::NotNegative => "0 or greater",
            Self::Unit => "from 0 to 1",
        }
    }
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
}

impl<'s> Reader<'s> {
    /// A reader of `source`, which begins `offset` bytes into its file.
    pub(crate) fn new(source: &'s str, offset: usize, limits: Limits) -> Self {
        Self { source, offset, path: Vec::new(), errors: Vec::new(), warnings: Vec::new(), limits }
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
        span: Range<usize>,
        message: String,
        help: Option<String>,
    ) -> PresetError {
        let (line, column) = line_column(self.source, span.start);
        let span = span.start + self.offset..span.end + self.offset;
        PresetError { message, span, line, column, help, path: self.path.concat(), kind }
    }

    /// Notes an error.
    pub(crate) fn error(
        &mut self,
        kind: PresetErrorKind,
        span: &Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) {
        if self.errors.len() < MAX_ERRORS {
            self.errors.push(self.describe(kind, span.clone(), message.into(), help));
        }
    }

    /// Notes a bad value and gives `None`.
    pub(crate) fn bad<T>(&mut self, node: &Node, message: impl Into<String>) -> Option<T> {
        self.error(PresetErrorKind::Value, &node.span, message, None);
        None
    }

    /// Notes what works but is hardly meant.
    pub(crate) fn warn(&mut self, span: &Range<usize>, message: impl Into<String>) {
        let warning = self.describe(PresetErrorKind::Value, span.clone(), message.into(), None);
        self.warnings.push(warning);
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
        let help = nearest(&name.text, expected.iter().copied()).map(|near| format!("did you mean `{near}`?"));
        let message =
            format!("there is no {what} `{}`; expected {}", escape(&name.text), one_of(expected.iter().copied()));
        self.error(PresetErrorKind::Name, &name.span, message, help);
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
        for (i, entry) in entries.iter().enumerate() {
            if entries[..i].iter().any(|before| before.key.text == entry.key.text) {
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
        // A misspelt field is reported once, as unknown.
        let misspelt = fields.entries.iter().any(|entry| nearest(&entry.key.text, [key]).is_some());
        if !misspelt {
            let owner = fields.owner;
            let start = fields.span.start;
            let head = start..(start + owner.len()).min(fields.span.end);
            let span = if self.source.get(head.clone()) == Some(owner) { head } else { start..start + 1 };
            self.error(PresetErrorKind::Name, &span, format!("`{owner}` needs a field `{key}`"), None);
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

    /// Closes a struct: fields of later versions may hold their defaults, all others do not exist.
    pub(crate) fn finish(&mut self, mut fields: Fields<'_>) {
        let owner = fields.owner;
        for field in later::FIELDS.iter().filter(|field| field.owner == owner) {
            if let Some(node) = fields.get(field.key) {
                self.within(field.key, |reader| later::check(reader, field, node));
            }
        }
        for entry in fields.entries {
            if fields.known.contains(&entry.key.text.as_str()) {
                continue;
            }
            let help =
                nearest(&entry.key.text, fields.known.iter().copied()).map(|near| format!("did you mean `{near}`?"));
            let message = format!(
                "`{}` has no field `{}`; expected {}",
                fields.owner,
                escape(&entry.key.text),
                one_of(fields.known.iter().copied())
            );
            self.error(PresetErrorKind::Name, &entry.key.span, message, help);
        }
    }

    /// A number as typed; NaN and infinities are for the caller to refuse.
    fn any_number(&mut self, node: &Node, expected: &str) -> Option<f64> {
        match node.body {
            Body::Number { value, .. } if node.name.is_none() => Some(value),
            _ => self.mismatch(node, expected),
        }
    }

    fn number_as(&mut self, node: &Node, within: Within, expected: &str) -> Option<f32> {
        let typed = self.any_number(node, expected)?;
        // Judged as it will be used: a number too small or too large for f32 is 0 or infinite.
        let value = typed as f32;
        if within.holds(f64::from(value)) {
            return Some(value);
        }
        let field = self.field_name();
        let shown = escape(self.source.get(node.span.clone()).unwrap_or(""));
        let range = if value.is_finite() { within } else { Within::Finite };
        let be = if within == Within::Unit && value.is_finite() { "lie" } else { "be" };
        self.bad(node, format!("{field} must {be} {}, found {shown}", range.text()))
    }

    /// A number.
    pub(crate) fn number(&mut self, node: &Node, within: Within) -> Option<f32> {
        self.number_as(node, within, "a number")
    }

    /// A time or a length of time in seconds, in full precision.
    pub(crate) fn seconds(&mut self, node: &Node, within: Within) -> Option<f64> {
        let value = self.any_number(node, "a number of seconds")?;
        if within.holds(value) {
            return Some(value);
        }
        let field = self.field_name();
        self.bad(node, format!("{field} must be {}, found {}", within.text(), found(node).trim_matches('`')))
    }

    /// A whole number of at least `least`.
    pub(crate) fn count(&mut self, node: &Node, least: u64) -> Option<u64> {
        let Body::Number { value, integer } = node.body else {
            return self.mismatch(node, "a whole number");
        };
        // 64.0 is a whole number, too; beyond 2^53 only integers are exact.
        let whole = integer.or((value.fract() == 0.0 && (0.0..9e15).contains(&value)).then_some(value as u64));
        match whole {
            Some(count) if count >= least => Some(count),
            Some(_) => {
                let field = self.field_name();
                self.bad(node, format!("{field} must be at least {least}, found {value}"))
            }
            None => self.mismatch(node, &format!("a whole number of at least {least}")),
        }
    }

    /// `true` or `false`.
    pub(crate) fn flag(&mut self, node: &Node) -> Option<bool> {
        match node.body {
            Body::Bool(value) => Some(value),
            _ => self.mismatch(node, "`true` or `false`"),
        }
    }

    /// A string.
    pub(crate) fn text<'n>(&mut self, node: &'n Node, what: &str) -> Option<&'n str> {
        match &node.body {
            Body::Text(text) => Some(text),
            _ => self.mismatch(node, &format!("{what} in quotes")),
        }
    }

    /// The `N` values of a tuple.
    pub(crate) fn tuple<'n, const N: usize>(&mut self, node: &'n Node, expected: &str) -> Option<&'n [Node; N]> {
        match &node.body {
            Body::Tuple(items) if node.name.is_none() => match items.as_slice().try_into() {
                Ok(items) => Some(items),
                Err(_) => self.mismatch(node, expected),
            },
            _ => self.mismatch(node, expected),
        }
    }

    /// The values of a list.
    pub(crate) fn list<'n>(&mut self, node: &'n Node, expected: &str) -> Option<&'n [Node]> {
        match &node.body {
            Body::List(items) => Some(items),
            _ => self.mismatch(node, expected),
        }
    }

    /// Every value of a list through `read`; `None` where one is bad.
    pub(crate) fn each<'n, T>(
        &mut self,
        items: &'n [Node],
        mut read: impl FnMut(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        let read: Vec<Option<T>> = items
            .iter()
            .enumerate()
            .map(|(i, item)| self.within(format!("[{i}]"), |reader| read(reader, item)))
            .collect();
        read.into_iter().collect()
    }

    /// A point `(x, y, z)`.
    pub(crate) fn point(&mut self, node: &Node) -> Option<[f32; 3]> {
        let items: &[Node; 3] = self.tuple(node, "a point `(x, y, z)`")?;
        let read = self.each(items, |reader, item| reader.number(item, Within::Finite))?;
        read.try_into().ok()
    }

    /// A list of points.
    pub(crate) fn points(&mut self, node: &Node) -> Option<Vec<[f32; 3]>> {
        let items = self.list(node, "a list of points `[(x, y, z), ..]`")?;
        self.each(items, Self::point)
    }

    /// One of some bare names.
    pub(crate) fn choice<T: Clone>(
        &mut self,
        node: &Node,
        what: &str,
        options: &[(&'static str, T)],
    ) -> Option<T> {
        let names: Vec<&str> = options.iter().map(|(name, _)| *name).collect();
        let Some(name) = &node.name else {
            return self.mismatch(node, &one_of(names));
        };
        match options.iter().find(|(option, _)| *option == name.text) {
            Some((_, value)) if matches!(node.body, Body::Bare) => Some(value.clone()),
            Some((option, _)) => self.bad(node, format!("`{option}` stands alone, without parentheses")),
            None => {
                self.unknown_name(name, what, &names);
                None
            }
        }
    }

    /// A † value: `value`, `Keys([(seconds, value), ..])` or `Ease([..])`, each value through `read`.
    pub(crate) fn keyed<'n, T: Interpolate>(
        &mut self,
        node: &'n Node,
        what: &str,
        mut read: impl FnMut(&mut Self, &'n Node) -> Option<T>,
    ) -> Option<Keyed<T>> {
        let Some(name) = &node.name else {
            return read(self, node).map(Keyed::Constant);
        };
        let ease = match name.text.as_str() {
            "Keys" => false,
            "Ease" => true,
            other => {
                let help = nearest(other, ["Keys", "Ease"]).map(|near| format!("did you mean `{near}`?"));
                let message = format!(
                    "expected {what}, `Keys([(seconds, value), ..])` or `Ease([..])`, found `{}`",
                    escape(other)
                );
                self.error(PresetErrorKind::Name, &name.span, message, help);
                return None;
            }
        };
        let items = match &node.body {
            Body::Tuple(inner) if inner.len() == 1 => self.list(&inner[0], "a list of keys `[(seconds, value), ..]`")?,
            _ => return self.mismatch(node, &format!("`{}([(seconds, value), ..])`", name.text)),
        };
        if items.is_empty() {
            return self.bad(node, format!("`{}` needs at least one key", name.text));
        }
        let mut last: Option<f64> = None;
        let keys = self.each(items, |reader, item| {
            let [time, value]: &[Node; 2] = reader.tuple(item, "a key `(seconds, value)`")?;
            let seconds = reader.seconds(time, Within::Finite);
            let value = read(reader, value);
            if let (Some(before), Some(now)) = (last, seconds)
                && now <= before
            {
                return reader.bad(time, format!("a key must come after the one before, at {before} s; found {now} s"));
            }
            last = seconds.or(last);
            Some((seconds?, value?))
        })?;
        match Keyed::keys(keys, ease) {
            Ok(keyed) => Some(keyed),
            Err(error) => self.bad(node, error.to_string()),
        }
    }

    /// A † number.
    pub(crate) fn keyed_number(&mut self, node: &Node, within: Within) -> Option<Keyed<f32>> {
        self.keyed(node, "a number", |reader, value| reader.number(value, within))
    }

    /// A † angle, degrees as typed, radians as read.
    pub(crate) fn keyed_degrees(&mut self, node: &Node) -> Option<Keyed<f32>> {
        self.keyed(node, "a number of degrees", |reader, value| {
            // In f64: 180 degrees are to be f32's π.
            reader.number(value, Within::Finite).map(|degrees| f64::from(degrees).to_radians() as f32)
        })
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
