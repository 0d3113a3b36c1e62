//! Whose fault it is that an effect does not fit an object, and where in the preset.

use wirework_asset::printable;
use wirework_core::BindError;
use wirework_preset::{Action, Effect, PresetErrorKind, Units};
use wirework_wrinkle::{Motion, Pattern, Wrinkle, WrinkleError};

use crate::error::of_evaluation;
use crate::subject::Origin;
use crate::{EvaluateError, Fault, JobError};

/// What comes of an effect that does not fit: an error at its place in the preset, where that is at fault, as it always is where it
/// brings the object along. Numbers of effects count in `effects`.
pub(crate) fn unfit<'a>(
    origin: &'a Origin,
    effects: &'a [Effect],
) -> impl Fn(EvaluateError) -> JobError + use<'a> {
    move |error| {
        let own = *origin == Origin::Preset;
        let preset = match of_evaluation(&error) {
            Fault::Preset => true,
            Fault::Asset => own,
            _ => false,
        };
        let effect = error.effect().and_then(|index| Some((index, effects.get(index)?)));
        match (effect.filter(|_| preset), origin) {
            (Some((index, effect)), _) => {
                let message = message(origin, &error, index, effects.len());
                let place = field(&error, effect);
                JobError::Preset(Box::new(effect.typed.error(&place, PresetErrorKind::Value, message, None)))
            }
            (None, Origin::Preset) => JobError::OwnObject(error),
            (None, Origin::Program) => JobError::Evaluate(error),
            (None, Origin::File(file)) => JobError::Unfit { file: file.clone(), error },
        }
    }
}

/// What is wrong, in a line; which effect it is only where there are several.
fn message(origin: &Origin, error: &EvaluateError, index: usize, effects: usize) -> String {
    let text = error.to_string();
    let why = text.strip_prefix(&format!("effect {index}: ")).unwrap_or(&text);
    let which = if effects > 1 { format!("effect {index} of the stack (from 0): ") } else { String::new() };
    let what = match origin {
        Origin::Preset => "the effect does not fit the preset's object".to_owned(),
        Origin::Program => "the effect cannot be applied".to_owned(),
        Origin::File(file) => format!("{}: the effect cannot be applied", printable(file)),
    };
    format!("{what}: {which}{why}")
}

/// The field of an effect that an error is about; empty for the whole of it.
fn field(error: &EvaluateError, effect: &Effect) -> String {
    match (error, &effect.action) {
        (EvaluateError::Bind { error: BindError::Wire { wire, .. }, .. }, Action::Deform(deform)) => {
            // The wires of a `WireLattice` are many in one place.
            let each = effect.typed.listed("wires") == Some(deform.wires.len());
            if each { format!("wires[{wire}]") } else { "wires".to_owned() }
        }
        (EvaluateError::Bind { error: BindError::Blend(part), .. }, _) => format!("blend.{part}"),
        (EvaluateError::Lattice { .. }, _) => "lattice".to_owned(),
        (EvaluateError::NoExtent { .. }, _) => "units".to_owned(),
        (EvaluateError::Limb { error, .. }, _) => error.path(),
        (EvaluateError::Wrinkle { error, .. }, Action::Wrinkle(wrinkle)) => {
            of_wrinkle(error, wrinkle, effect.units)
        }
        _ => String::new(),
    }
}

fn of_wrinkle(error: &WrinkleError, wrinkle: &Wrinkle, units: Units) -> String {
    let field = match error {
        WrinkleError::Value { field, .. } => field,
        WrinkleError::TooFine { .. } => "thickness",
        WrinkleError::TooLong { length, .. } => return of_length(*length, wrinkle, units),
        WrinkleError::TooMany { .. } | WrinkleError::NoCreases => "creases",
        WrinkleError::DrivenMoves | WrinkleError::ClosedRopes => "motion",
        WrinkleError::CenterOff { .. } | WrinkleError::NoNormalAtCenter => "center",
        WrinkleError::NoRoom => "size",
        WrinkleError::TooFar { curve, .. } | WrinkleError::Collapsed { curve } => {
            return format!("pattern[{curve}]");
        }
        WrinkleError::Undriven
        | WrinkleError::Unmoved
        | WrinkleError::NoCurves
        | WrinkleError::NoNormal { .. } => "pattern",
        // What lies below it is wrong, not what it says.
        _ => "",
    };
    field.to_owned()
}

/// What makes lines of a length in metres too long: the way they have gone, or else what they are laid out by.
fn of_length(length: f32, wrinkle: &Wrinkle, units: Units) -> String {
    let (size, field) = match &wrinkle.pattern {
        Pattern::Tangential(layout) | Pattern::Radial(layout, _) | Pattern::Ripple(layout) => {
            (layout.size[0].max(layout.size[1]), "size")
        }
        _ => (0.0, "pattern"),
    };
    let travels = matches!(wrinkle.motion, Motion::Travelling { .. });
    // How large a size in parts of an object is is not known here; it is seldom what goes far.
    if travels && (units == Units::Bounds || length > 2.0 * size) { "motion" } else { field }.to_owned()
}
