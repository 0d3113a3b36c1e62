//! Seams between surfaces: stitched, torn, welded. \[SF98\] §5.2.

mod error;
mod settings;

pub use error::{EdgeFault, StitchError, StitchWarning};
pub use settings::{Continuity, Edge, Order, Pairing, Reversed, Run, Seam, SeamSide, Side, Stitch, Tear};
