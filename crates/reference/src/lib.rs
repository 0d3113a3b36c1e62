//! A wire deformer in plain float64: what the fast engine of `wirework-core` is judged against.
//!
//! It takes the plain data of `wirework-core` ([`Curve`], [`Wire`], [`Blend`]) and evaluates all of it itself, by
//! the most direct road there is: de Boor's recursion, dense sampling and bisection, numerical quadrature. It
//! shares no algorithm with the engine, is slow, and may be read as the specification.
//!
//! | file | \[SF98\] | is |
//! |---|---|---|
//! | `curve.rs` | §2 | `C(u)`, `C′(u)`, corners |
//! | `length.rs` | §2 | arc length and the correspondence by arc length |
//! | `foot.rs` | §2 | `p_R`, the closest point |
//! | `feet.rs` | §6 | several feet of one point, `closest: Blended` |
//! | `locators.rs` | §3.1 | attributes along the wire |
//! | `bounds.rs` | §3.1, §3.2 | directional dropoff, domain curves |
//! | `rotation.rs` | §2 | the least rotation, `bend: Tangent` |
//! | `transport.rs` | – | `bend: Transport` |
//! | `wire.rs` | §2 | one wire on one point |
//! | `blend.rs` | §4 | many wires on one point |
//! | `doubt.rs` | – | how well the answer is defined at a point |
//! | `rigs.rs`, `features.rs`, `random.rs` | – | random rigs to compare on |
//!
//! \[SF98\] is K. Singh, E. Fiume, "Wires: A Geometric Deformation Technique", SIGGRAPH 1998.
//!
//! # Corner cases
//!
//! - A point that is not finite stays as it is.
//! - A zero tangent, at either curve: no bend. A zero `R′`: no twist either.
//! - At a corner the tangent is the normalised mean of the unit tangents of both sides; a zero tangent on one
//!   side is left out, two that cancel give zero.
//! - `R′` and `W′` antiparallel: half a turn about `R′ × e`, `e` the coordinate axis least aligned with `R′`, the
//!   first such axis on ties.
//! - By arc length with a curve of length zero: `p′ = p`.
//! - A domain curve that passes through the foot, or a point on `R`: no angle, the wire's own radius.
//! - A direction along `R′`, or a point on `R` or beyond an end in line with it: no dropoff. A zero `R′`: `φ` is the
//!   angle in space.
//! - A span of `W` equal to that of `R` gives `ΔP = 0` exactly, at `s = 1` and twist 0.

mod blend;
mod bounds;
mod curve;
mod doubt;
mod features;
mod feet;
mod foot;
mod length;
mod locators;
mod random;
mod rigs;
mod rotation;
mod transport;
mod wire;

pub use blend::{Scene, deform};
pub use curve::{derivative, point, segment_count, tangent};
pub use doubt::{Doubt, unsteadiness};
pub use feet::feet;
pub use foot::{Foot, TIE, closest};
pub use length::{at_length, length};
pub use random::Random;
pub use rigs::Rig;
pub use rotation::least_rotation;
pub use wire::{displacement, influence};

#[cfg(doc)]
use wirework_core::{Blend, Curve, Wire};

/// A point of the plain data in float64, exactly.
fn wide(p: [f32; 3]) -> glam::DVec3 {
    glam::Vec3::from_array(p).as_dvec3()
}
