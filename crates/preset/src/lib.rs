//! RON presets: text → values as typed, each with its place → a checked effect in which no value is bad.
//!
//! ```
//! use wirework_preset::{Action, Limits, parse};
//!
//! let text = "Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), radius: Keys([(0, 1), (2, 3)]))])";
//! let preset = parse(text.as_bytes(), &Limits::default()).unwrap().preset;
//! assert_eq!(preset.duration, 2.0);
//! let Action::Deform(deform) = &preset.effects[0].action else { panic!() };
//! assert_eq!(deform.wires[0].at(1.0).radius, 2.0);
//!
//! let errors = parse(text.replace("Keys", "Kyes").as_bytes(), &Limits::default()).unwrap_err();
//! let error = &errors.errors()[0];
//! assert_eq!((error.line, error.column, error.path.as_str()), (1, 78, "wires[0].radius"));
//! assert_eq!(error.help.as_deref(), Some("did you mean `Keys`?"));
//! ```
//!
//! Degrees become radians, group names become numbers, and seconds stay seconds. No file is read here.

mod bounds_frame;
mod curve;
mod deform;
mod direction;
mod domain;
mod error;
mod ik;
mod keyed_wire;
mod lattice;
mod limits;
mod locators;
mod moments;
mod object;
mod places;
mod preset;
mod read;
mod scan;
mod scope;
mod stitch;
mod syntax;
mod template;
mod translation;
mod tree;
mod typed;
mod wire;
mod wrinkle;

pub use bounds_frame::BoundsFrame;
pub use deform::Deform;
pub use error::{PresetError, PresetErrorKind, PresetErrors};
pub use ik::{Chain, Goal, Limb};
pub use keyed_wire::KeyedWire;
pub use limits::Limits;
pub use object::{Object, ObjectError, ObjectSize, PatchDeform, Shape};
pub use preset::{Action, Effect, FORMAT_VERSION, Parsed, Preset, parse};
pub use scope::{Channel, Mask, Named, Only, Units};
pub use stitch::{Piece, Stitching};
pub use template::{TEMPLATES, TemplateError, template};
pub use translation::PoseKeys;
pub use typed::Typed;
