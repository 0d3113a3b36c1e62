//! Wrinkles: crease wires on a surface.
//!
//! A crease is one wire. Its reference curve `R` lies on the undeformed surface, its wire curve `W` stands over it
//! by the height of the crest, along the outward normals; the wire's density is the cross-section of the fold. What
//! depends on the surface is worked out once, by [`creases`]; the wires of a moment are then a few products a
//! control point ([`Creases::wires_at`]). References move only where the pattern does, over the surface ([`Creases::at`]), and a crease acts
//! only on what the surface leads to from it ([`Creases::near`]).
//!
//! Where creases run is a [`Pattern`], what moves them a [`Motion`], how high they stand an intensity, a compression, or the
//! [`Strain`] of the surface; [`Field`] finds where that is greatest.
//!
//! ```
//! use wirework_core::Curve;
//! use wirework_surface::grid;
//! use wirework_wrinkle::{SurfaceView, Wrinkle, creases};
//!
//! let mesh = grid([2.0, 2.0], [32, 32], [0.0, 1.0, 0.0])?;
//! let drawn = Curve::bspline(3, vec![[-0.8, 0.2, 0.0], [-0.2, 0.2, 0.5], [0.2, 0.2, -0.5], [0.8, 0.2, 0.0]])?;
//! let settings = Wrinkle { stiffness: 0.5, ..Wrinkle::drawn(vec![drawn]) };
//!
//! let triangles = mesh.triangles()?;
//! let mut creases = creases(&SurfaceView { positions: &mesh.positions, triangles: &triangles }, &settings)?;
//! let mut wires = Vec::new();
//! creases.wires_at(0.0, &mut wires);
//! assert!((wires[0].pose[3][1] - 0.05).abs() < 1e-6); // the crest stands `intensity` over the grid
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bending;
mod compression;
mod crease;
mod creases;
mod curtain;
mod doubts;
mod drawn;
mod error;
mod field;
mod fit;
mod ground;
mod height;
mod links;
mod pattern;
mod radial;
mod random;
mod ripple;
mod rope;
mod ropes;
mod settings;
mod spread;
mod strain;
mod tangential;
mod trace;
mod travel;
mod wind;

pub use creases::{Creases, creases};
pub use curtain::{Curtain, Rail};
pub use error::{WrinkleError, WrinkleWarning};
pub use field::Field;
pub use settings::{Branches, Drawn, Layout, Motion, Pattern, SurfaceView, Wrinkle};
pub use strain::Strain;

#[cfg(test)]
mod patterns_tests;
#[cfg(test)]
mod test_support;
