//! A preset as typed: a tree of values, each with its place in the source.
//!
//! `ron` decides what is RON, and reads numbers and strings. It gives no places for values, though, and its
//! `deserialize_any` drops the name of `Keys(..)`; so `scan` finds the places in text that `ron` has accepted.
//! Where the two should ever disagree, [`parse`] reports the place and does not guess.

use std::ops::Range;

use ron::extensions::Extensions;

use crate::error::PresetErrorKind;
use crate::scan::Scan;
use crate::syntax::Fault;

/// A value as typed.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// The bytes from the value's first to its last, its name included.
    pub(crate) span: Range<usize>,
    /// The name before the parenthesis, or the bare name.
    pub(crate) name: Option<Name>,
    /// What follows the name.
    pub(crate) body: Body,
}

/// A name and its place.
#[derive(Clone, Debug)]
pub(crate) struct Name {
    pub(crate) text: String,
    pub(crate) span: Range<usize>,
}

/// The shapes of values.
#[derive(Clone, Debug)]
pub(crate) enum Body {
    /// Nothing: a bare name.
    Bare,
    /// `(name: value, ..)`.
    Fields(Vec<Entry>),
    /// `(value, ..)`.
    Tuple(Vec<Node>),
    /// `[value, ..]`.
    List(Vec<Node>),
    /// A number; of integers `integer` is exact.
    Number { value: f64, integer: Option<u64> },
    /// A string.
    Text(String),
    /// `true` or `false`.
    Bool(bool),
    /// What no preset uses; says what it is.
    Other(&'static str),
}

/// A field as typed.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: Name,
    pub(crate) value: Node,
}

impl Node {
    /// The value in an explicit `Some(value)`, or the value itself.
    pub(crate) fn unwrap_some(&self) -> &Self {
        match (&self.name, &self.body) {
            (Some(name), Body::Tuple(items)) if name.text == "Some" => match items.as_slice() {
                [inner] => inner,
                _ => self,
            },
            _ => self,
        }
    }

    /// The field `key` of named fields.
    pub(crate) fn field(&self, key: &str) -> Option<&Self> {
        let Body::Fields(entries) = &self.body else { return None };
        entries.iter().find(|entry| entry.key.text == key).map(|entry| &entry.value)
    }

    /// The name, where there is one.
    pub(crate) fn name(&self) -> Option<&str> {
        self.name.as_ref().map(|name| name.text.as_str())
    }

    /// Whether this is the bare name `name`.
    pub(crate) fn is_bare(&self, name: &str) -> bool {
        matches!(self.body, Body::Bare) && self.name() == Some(name)
    }
}

/// The options that every preset is read with.
pub(crate) fn options() -> ron::Options {
    ron::Options::default().with_default_extension(
        Extensions::IMPLICIT_SOME | Extensions::UNWRAP_NEWTYPES | Extensions::UNWRAP_VARIANT_NEWTYPES,
    )
}

/// Reads a text into a tree.
pub(crate) fn parse(source: &str) -> Result<Node, Fault> {
    let mut scan = Scan::new(source, 0);
    scan.brackets()?;
    options()
        .from_str::<serde::de::IgnoredAny>(source)
        .map_err(|error| crate::syntax::fault(source, &error))?;
    scan.attributes();
    let node = scan.value(0);
    scan.space();
    match node {
        Some(node) if scan.at_end() => Ok(node),
        _ => {
            let (span, token) = scan.token();
            let message = format!("expected a value, found `{token}`");
            Err(Fault { message, span, kind: PresetErrorKind::Syntax, help: None })
        }
    }
}
