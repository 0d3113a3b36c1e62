//! What the format names and this version does not do yet. A later version only shortens this list.

use crate::error::PresetErrorKind;
use crate::read::Reader;
use crate::tree::Node;

/// Effects of later versions.
pub(crate) const EFFECTS: &[&str] = &["Ik"];

/// Refuses a name of a later version.
pub(crate) fn refuse(reader: &mut Reader<'_>, node: &Node, name: &str) {
    let span = node.name.as_ref().map_or(&node.span, |name| &name.span);
    let message = format!("`{name}` is not available in this version");
    reader.error(PresetErrorKind::Unavailable, span, message, None);
}
