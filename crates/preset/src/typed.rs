//! Where an effect stands in its preset, for what is found out only when it meets an object.

use std::fmt;
use std::sync::Arc;

use crate::deform::head;
use crate::error::{PresetError, PresetErrorKind};
use crate::places::Places;
use crate::scope::Place;
use crate::tree::{Body, Node};

/// An effect as it was typed, so that whoever finds it wrong can say where.
///
/// Effects are equal wherever they stand. One of a program's own stands nowhere, which is the default: errors about it are at
/// line 1, column 1.
#[derive(Clone, Default)]
pub struct Typed {
    /// The whole preset, which its effects share.
    script: Option<Arc<Script>>,
    /// The effect's own path in it: `[1]` for the second of a stack, empty for one that stands alone.
    path: String,
}

/// A preset as it was read.
pub(crate) struct Script {
    pub(crate) text: String,
    /// Bytes of the file before the text: a byte order mark.
    pub(crate) offset: usize,
    pub(crate) root: Node,
}

impl PartialEq for Typed {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Typed {}

impl fmt::Debug for Typed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The tree of the whole preset would bury what it is a part of.
        f.debug_tuple("Typed").field(&self.path).finish()
    }
}

impl Typed {
    pub(crate) fn at(path: String) -> Self {
        Self { script: None, path }
    }

    pub(crate) fn of(&mut self, script: &Arc<Script>) {
        self.script = Some(Arc::clone(script));
    }

    /// An error at a field of the effect, such as `center` or `wires[2].radius`; at the effect's name for an empty one. Where that
    /// was not typed, the error is at the deepest place on the way to it that was.
    pub fn error(
        &self,
        field: &str,
        kind: PresetErrorKind,
        message: impl Into<String>,
        help: Option<String>,
    ) -> PresetError {
        self.place(field).error(kind, message.into(), help)
    }

    /// How many values were typed in the list at a field; none where there is no list.
    pub fn listed(&self, field: &str) -> Option<usize> {
        let (node, path) = self.find(field)?;
        let whole = steps(&self.path).chain(steps(field)).eq(steps(&path));
        match &node.body {
            Body::List(items) if whole => Some(items.len()),
            _ => None,
        }
    }

    fn place(&self, field: &str) -> Place {
        let (Some(script), Some((node, path))) = (&self.script, self.find(field)) else {
            return Place::nowhere();
        };
        // A caret under a whole struct would be many lines long.
        let whole = path != self.path && !matches!(node.body, Body::Fields(_));
        let span = if whole { node.span.clone() } else { head(node) };
        let (line, column) = Places::new(&script.text).line_column(span.start);
        Place { span: span.start + script.offset..span.end + script.offset, line, column, path }
    }

    /// The deepest value that was typed on the way to a field, and its path.
    fn find(&self, field: &str) -> Option<(&Node, String)> {
        let script = self.script.as_ref()?;
        let (mut node, mut path) = (&script.root, String::new());
        let own = steps(&self.path).count();
        for (i, step) in steps(&self.path).chain(steps(field)).enumerate() {
            let Some(next) = node.step(step) else { break };
            if !step.starts_with('[') && !path.is_empty() {
                path.push('.');
            }
            path.push_str(step);
            // What is explicitly there is as good as what is there.
            node = if i < own { next } else { next.unwrap_some() };
        }
        Some((node, path))
    }
}

/// The steps of a path: `wires[2].radius` is `wires`, `[2]`, `radius`.
fn steps(path: &str) -> impl Iterator<Item = &str> {
    path.split('.').flat_map(|part| {
        let (name, indices) = part.split_at(part.find('[').unwrap_or(part.len()));
        let indices = indices.split_inclusive(']');
        std::iter::once(name).filter(|name| !name.is_empty()).chain(indices)
    })
}

impl Node {
    /// The value one step down: a named field, or `[3]` in a list or a tuple.
    fn step(&self, step: &str) -> Option<&Self> {
        let Some(index) = step.strip_prefix('[') else {
            return match &self.body {
                // A variant around a struct may be written with both parentheses.
                Body::Tuple(items) if items.len() == 1 => items.first()?.field(step),
                _ => self.field(step),
            };
        };
        let index: usize = index.strip_suffix(']')?.parse().ok()?;
        let items = match &self.body {
            Body::List(items) => items,
            // `Stack([..])`, `Drawn([..])`.
            Body::Tuple(items) => match items.as_slice() {
                [Node { body: Body::List(inner), .. }] => inner,
                _ => items,
            },
            _ => return None,
        };
        items.get(index)
    }
}
