//! Presets to begin with: every field with its default and what it does.

use thiserror::Error;

use crate::error::{escape, nearest, one_of};

/// The effects that have a template.
pub const TEMPLATES: [&str; 4] = ["deform", "wrinkle", "stitch", "ik"];

/// Why there is no template.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TemplateError {
    /// There is no such effect.
    #[error("there is no effect `{}`; expected {}{}", escape(.effect), one_of(TEMPLATES),
            .nearest.map(|near| format!(", did you mean `{near}`?")).unwrap_or_default())]
    Unknown {
        /// What was asked for.
        effect: String,
        /// The effect with the nearest name.
        nearest: Option<&'static str>,
    },
}

/// A preset of `effect`, by its name in any case, that runs as it stands.
pub fn template(effect: &str) -> Result<&'static str, TemplateError> {
    let name = effect.to_lowercase();
    match name.as_str() {
        "deform" => Ok(include_str!("template/deform.ron")),
        "wrinkle" => Ok(include_str!("template/wrinkle.ron")),
        "stitch" => Ok(include_str!("template/stitch.ron")),
        "ik" => Ok(include_str!("template/ik.ron")),
        _ => Err(TemplateError::Unknown { effect: effect.to_owned(), nearest: nearest(&name, TEMPLATES) }),
    }
}
