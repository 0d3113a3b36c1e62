//! What the format names and this version does not do yet. A later version only shortens this list.

use crate::error::PresetErrorKind;
use crate::read::{Reader, found};
use crate::tree::{Body, Node};

/// Effects of later versions.
pub(crate) const EFFECTS: &[&str] = &["Stitch", "Ik"];

/// A field of a later version: only its default may be written.
pub(crate) struct LaterField {
    /// The struct it belongs to.
    pub(crate) owner: &'static str,
    /// Its name.
    pub(crate) key: &'static str,
    /// Its default, as it is typed.
    pub(crate) default: Default,
    /// Values that exist in later versions. Empty: all values do.
    pub(crate) values: &'static [&'static str],
}

/// Shapes of defaults.
pub(crate) enum Default {
    /// A bare name.
    Name(&'static str),
    /// Named numbers that are all 0.
    Zeros(&'static [&'static str]),
}

impl Default {
    /// As it is typed.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Name(name) => (*name).to_owned(),
            Self::Zeros(keys) => {
                let zeros: Vec<String> = keys.iter().map(|key| format!("{key}: 0")).collect();
                format!("({})", zeros.join(", "))
            }
        }
    }

    fn is(&self, node: &Node) -> bool {
        match (self, &node.body) {
            (Self::Name(name), _) => node.is_bare(name),
            (Self::Zeros(keys), Body::Fields(entries)) => entries.iter().all(|entry| {
                keys.contains(&entry.key.text.as_str())
                    && matches!(entry.value.body, Body::Number { value, .. } if value == 0.0)
            }),
            _ => false,
        }
    }
}

const fn later(
    owner: &'static str,
    key: &'static str,
    default: Default,
    values: &'static [&'static str],
) -> LaterField {
    LaterField { owner, key, default, values }
}

/// All fields of later versions.
pub(crate) const FIELDS: &[LaterField] = &[later("Wrinkle", "drive", Default::Name("None"), &["Strain"])];

/// Refuses a field of a later version unless it holds its default.
pub(crate) fn check(reader: &mut Reader<'_>, field: &LaterField, node: &Node) {
    let default = field.default.text();
    if field.default.is(node.unwrap_some()) {
        return;
    }
    let known = field.values.is_empty() || node.name().is_none_or(|name| field.values.contains(&name));
    match &node.name {
        Some(name) if !known => {
            let names: Vec<&str> =
                [default.as_str()].into_iter().chain(field.values.iter().copied()).collect();
            reader.unknown_name(name, &format!("value of `{}`", field.key), &names);
        }
        _ => {
            let help = format!("leave `{}` out, or write `{}: {default}`", field.key, field.key);
            let message = format!(
                "`{}: {}` is not available in this version",
                field.key,
                found(node).trim_matches('`')
            );
            reader.error(PresetErrorKind::Unavailable, &node.span, message, Some(help));
        }
    }
}

/// Refuses a name of a later version.
pub(crate) fn refuse(reader: &mut Reader<'_>, node: &Node, name: &str, help: Option<&str>) {
    let span = node.name.as_ref().map_or(&node.span, |name| &name.span);
    let message = format!("`{name}` is not available in this version");
    reader.error(PresetErrorKind::Unavailable, span, message, help.map(str::to_owned));
}
