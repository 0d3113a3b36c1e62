//! tour
#![allow(missing_docs)]
mod apply;
mod error;
mod evaluate;
mod output;
mod preset_file;
mod report;
mod schedule;
mod shade;
mod subject;
mod weld;

pub use wirework_asset as asset;
pub use wirework_bake as bake;
pub use wirework_core as core;
pub use wirework_preset as preset;
pub use wirework_surface as surface;
pub use wirework_wrinkle as wrinkle;

pub use wirework_core::{Binding, Blend, Curve, Wire};
pub use wirework_preset::parse;

pub use apply::{Job, Progress, apply};
pub use error::{ApplyError, Fault};
pub use evaluate::{EvaluateError, Evaluation, Spent};
pub use output::{Pattern, Target};
pub use preset_file::{PresetFile, PresetFileError, parse_preset, read_preset};
pub use report::Report;
pub use schedule::{Schedule, ScheduleError, When, schedule};
pub use subject::{FileKind, Model, Subject};
