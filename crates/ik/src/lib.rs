//! Limbs between bones and rubber, as wires. \[SF98\] §5.3.
//!
//! A chain of joints becomes a curve, the curve a wire, and what follows the wire bends like bones or like rubber and keeps its volume.
//! [`Limb::pose`] says where the joints are for a goal, [`Limb::wire_into`] makes a wire of that.
//!
//! ```
//! use wirework_core::{Binding, Blend, Keyed};
//! use wirework_ik::{Ik, Limb};
//!
//! // Three bones along X, half of rubber, pulled to twice their length.
//! let settings = Ik { elasticity: Keyed::Constant(1.0), softness: 0.0, ..Ik::default() };
//! let limb = Limb::new(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]], &settings)?;
//! let pose = limb.pose([6.0, 0.0, 0.0], 0.0);
//! assert!((pose.length() - 6.0).abs() < 1e-9);
//!
//! let points = [[1.5, 0.2, 0.0]];
//! let mut wires = [limb.wire()];
//! let mut binding = Binding::new(&wires, &points)?;
//! limb.wire_into(&pose, 0.0, &mut wires[0]);
//! let mut out = points;
//! binding.deform_into(&wires, &Blend::default(), &mut out)?;
//! // Thinner by the root of a half, which keeps the volume.
//! assert!((out[0][0] - 3.0).abs() < 1e-5 && (out[0][1] - 0.2 * 0.5_f32.sqrt()).abs() < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bow;
mod cones;
mod error;
mod limb;
mod root;
mod run;
mod settings;
mod turn;
mod wire;

pub use error::IkError;
pub use limb::{Limb, Pose};
pub use settings::{ChainCurve, Ik, Influence, Pin, ScaleBy, Tip};
pub use wire::BoneFrame;
