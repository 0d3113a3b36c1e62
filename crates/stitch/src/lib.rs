//! Seams between surfaces: stitched, torn, welded. \[SF98\] §5.2.
//!
//! A seam joins two edges: runs along the borders of pieces. Both get a common parameter ([`Pairing`]); along each lies a wire, its
//! reference `R` on the edge, its wire curve `W` on the common seam between the two, or back at the edge where a [`Tear`] opens it.
//! The surfaces follow as wires have it, but for one thing: a point on a closed seam is moved by that seam alone
//! ([`wirework_core::Blend::pinned`]).
//!
//! ```
//! use wirework_core::Binding;
//! use wirework_stitch::{Edge, Run, Seam, Side, Stitch, Surfaces, seams};
//! use wirework_surface::grid;
//!
//! // Two squares side by side, a gap of 0.4 between them.
//! let square = grid([1.0, 1.0], [8, 8], [0.0, 1.0, 0.0])?;
//! let beside = square.positions.iter().map(|p| [p[0] + 1.4, p[1], p[2]]);
//! let points: Vec<[f32; 3]> = square.positions.iter().copied().chain(beside).collect();
//! let own = square.triangles()?;
//! let triangles: Vec<[u32; 3]> = own.iter().copied().chain(own.iter().map(|t| t.map(|v| v + 81))).collect();
//! let piece_of: Vec<u32> = (0..162).map(|point| point / 81).collect();
//!
//! let edge = |piece, x: f32| Edge {
//!     piece,
//!     run: Run::Between { from: [x, 0.0, -0.5], to: [x, 0.0, 0.5], long: false },
//! };
//! let settings = Stitch { seams: vec![Seam::new(edge(0, 0.5), edge(1, 0.9))], ..Stitch::default() };
//! let surfaces = Surfaces { positions: &points, triangles: &triangles, piece_of: &piece_of, sides: &[None, None] };
//! let mut seams = seams(&surfaces, &settings)?;
//!
//! let mut wires = Vec::new();
//! seams.wires_at(0.0, &mut wires);
//! let mut binding = Binding::new(&wires, &points)?;
//! let mut out = points.clone();
//! binding.deform_into(&wires, &seams.blend(), &mut out)?;
//! let at_seam = out.iter().filter(|p| (p[0] - 0.7).abs() < 1e-6);
//! assert_eq!(at_seam.count(), 18); // nine vertices of each square
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod border;
mod corner;
mod error;
mod joint;
mod pairing;
mod path;
mod seams;
mod settings;
mod side;
mod surfaces;
mod tangent;
mod target;
mod tear;
mod turn;

pub use border::border_loops;
pub use error::{EdgeFault, StitchError, StitchWarning};
pub use joint::{Cut, merged};
pub use seams::{Pin, Seams, seams};
pub use settings::{Continuity, Edge, Order, Pairing, Reversed, Run, Seam, SeamSide, Side, Stitch, Tear};
pub use surfaces::Surfaces;
