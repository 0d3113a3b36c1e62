//! The wire of K. Singh and E. Fiume, "Wires: A Geometric Deformation Technique", SIGGRAPH 1998
//! (cited as \[SF98\]): curves, the exact closest point, binding points to wires and deforming them.
//!
//! A *wire* is a pair of curves. The *reference curve* `R` says where the wire lies on the undeformed
//! object, the *wire curve* `W` where it is now. A point near `R` is carried along by the difference.
//! Data flows one way: [`Wire`]s and points → [`Binding::new`] → [`Binding::deform_into`], once a frame.
//!
//! # Notation
//!
//! | letter | is | here |
//! |---|---|---|
//! | `P` | a point of the undeformed object | `points` |
//! | `R` | reference curve | [`Wire::reference`] |
//! | `W` | wire curve | [`Wire::pose`] |
//! | `p_R` | parameter of the point of `R` closest to `P` | [`Foot::u`] |
//! | `r` | radius of influence | [`Wire::radius`] |
//! | `s` | radial scale | [`Wire::scale`] |
//! | `f` | density | [`Wire::density`] |
//! | `F` | influence, `f(‖P − R(p_R)‖ / r)` | |
//! | `θ` | angle between `R′` and `W′` | |
//! | `m` | exponent of the blend of many wires | [`Blend::exponent`] |
//! | `k` | exponent of the local influence | [`Blend::locality`] |
//!
//! Positions are `[f32; 3]`, so that any engine's vector can be cast to them; angles are radians.
//! The crate knows no files, no clock and no random numbers.

mod arclength;
mod attributes;
mod bind;
mod blend;
mod block;
mod bound_wire;
mod cells;
mod closest;
mod curve;
mod deform;
mod density;
mod domain;
mod flood;
mod follow;
mod frame;
mod influence;
mod kernel;
mod keyed;
mod lattice;
mod mask;
mod medial;
mod piece;
mod quintic;
mod rotation;
mod runs;
mod search;
mod simd;
mod spans;
mod stations;
mod tiles;
mod trig;
mod weights;
mod wire;

pub use bind::{BindError, Binding};
pub use closest::Foot;
pub use curve::{Curve, CurveError, CurveKind};
pub use density::{Density, Profile, ProfileError};
pub use keyed::{Interpolate, Keyed, Keys, KeysError};
pub use lattice::{Lattice, LatticeBinding, LatticeError, MAX_LATTICE_CELLS};
pub use mask::Mask;
pub use stations::Station;
pub use weights::{Weight, Weights, WeightsError};
pub use wire::{
    Bend, Blend, Bounded, Closest, Correspondence, Domain, Interpolation, LARGEST_TWIST, Locator, Wire,
    WireError,
};
