//! Limbs between bones and rubber, as wires. \[SF98\] §5.3.

mod settings;

pub use settings::{ChainCurve, Ik, Influence, Pin, ScaleBy, Tip};
