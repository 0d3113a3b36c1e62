//! RON presets: text → values as typed, each with its place → a checked effect in which no value is bad.
//!
//! ```
//! use wirework_preset::{Effect, Limits, parse};
//!
//! let text = "Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), radius: Keys([(0, 1), (2, 3)]))])";
//! let preset = parse(text.as_bytes(), &Limits::default()).unwrap().preset;
//! assert_eq!(preset.duration, 2.0);
//! let Effect::Deform(deform) = &preset.effect else { panic!() };
//! assert_eq!(deform.wires[0].at(1.0).radius, 2.0);
//!
//! let errors = parse(text.replace("Keys", "Kyes").as_bytes(), &Limits::default()).unwrap_err();
//! let error = &errors.errors()[0];
//! assert_eq!((error.line, error.column, error.path.as_str()), (1, 78, "wires[0].radius"));
//! assert_eq!(error.help.as_deref(), Some("did you mean `Keys`?"));
//! ```
//!
//! Degrees become radians, group names become numbers, and seconds stay seconds. No file is read here.

mod curve;
mod deform;
mod error;
mod later;
mod limits;
mod object;
mod preset;
mod read;
mod scan;
mod syntax;
mod template;
mod tree;
mod wrinkle;

pub use deform::{Deform, KeyedWire};
pub use error::{PresetError, PresetErrorKind, PresetErrors};
pub use limits::Limits;
pub use object::{Object, ObjectError, ObjectSize, Shape};
pub use preset::{Effect, FORMAT_VERSION, Parsed, Preset, parse};
pub use template::{TEMPLATES, TemplateError, template};
