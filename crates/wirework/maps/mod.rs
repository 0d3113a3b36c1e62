//! From a preset to maps for the surface that it deforms: a normal map, heights, and masks for parts of the effect.
//!
//! Wires act on what lies between the vertices of a coarse mesh as on any other point; so the effect is worked out on a finer
//! copy of it, and the maps say of the coarse one what the fine one shows.

mod curve;
mod finer;
mod ground;
mod groups;
mod job;
mod moment;
mod notes;
mod surface;
mod target;
mod wishes;

pub use job::{MapJob, bake_map};
pub use notes::{MapGroup, MapHeight, MapMask, MapMesh, MapReport};
