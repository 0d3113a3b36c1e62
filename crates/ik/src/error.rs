//! Why a chain cannot be a limb.

use thiserror::Error;

/// Why there is no limb. Joints, bones and pins count from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IkError {
    /// A chain needs a bone.
    #[error("a chain needs at least two joints, found {found}")]
    Joints {
        /// How many there are.
        found: usize,
    },
    /// A joint is NaN, infinite, or so far away that lengths overflow.
    #[error("joint {joint} is not finite")]
    NotFinite {
        /// Which joint.
        joint: usize,
    },
    /// A bone has no length: two joints are at one place, or as good as that.
    #[error("joint {joint} is at the place of joint {}: a bone needs a length", .joint - 1)]
    Coincident {
        /// The later of the two joints.
        joint: usize,
    },
    /// A list has a wrong number of values.
    #[error("`{field}` has {found} {} for {joints} joints, expected {expected}", if *.found == 1 { "value" } else { "values" })]
    Count {
        /// The name of the list.
        field: &'static str,
        /// Joints of the chain.
        joints: usize,
        /// How many it has.
        found: usize,
        /// How many it may have.
        expected: String,
    },
    /// A setting is out of range.
    #[error("`{field}` must be {expected}, not {found}")]
    Value {
        /// Its name.
        field: &'static str,
        /// Which value of a list.
        index: Option<usize>,
        /// What it must be.
        expected: &'static str,
        /// A value it has or takes.
        found: f32,
    },
    /// A pin is not of an inner joint or the root.
    #[error("pin {pin} holds joint {joint}, but only joints 0 to {last} can be held: the tip has the goal")]
    Pin {
        /// Which pin.
        pin: usize,
        /// Its joint.
        joint: usize,
        /// The last joint that can be held.
        last: usize,
    },
    /// Two pins hold one joint.
    #[error("pin {pin} holds joint {joint}, which an earlier pin holds already")]
    Pinned {
        /// The later of the two pins.
        pin: usize,
        /// Their joint.
        joint: usize,
    },
}

impl IkError {
    /// The field of a preset that it is about, such as `chain` or `pins[1]`.
    pub fn path(&self) -> String {
        match self {
            Self::Joints { .. } | Self::NotFinite { .. } | Self::Coincident { .. } => "chain".to_owned(),
            Self::Count { field, .. } | Self::Value { field, index: None, .. } => (*field).to_owned(),
            Self::Value { field, index: Some(index), .. } => format!("{field}[{index}]"),
            Self::Pin { pin, .. } | Self::Pinned { pin, .. } => format!("pins[{pin}]"),
        }
    }
}
