//! Frames of a deformation as glTF morph targets or tracks of joints, and a clip that plays them.
//!
//! [`bake`](bake()) looks at a motion at any time it likes and writes few targets that play it within a tolerance: key poses with linear
//! ways between them, or a basis, shapes of which all poses are weighted sums. A [`Baker`] takes the deformed state of all vertices
//! frame after frame and writes one target a frame, exact, and as large as the motion is long; frames that are equal share a target, and a
//! frame that equals the rest has none. Both write what they have at once, so that no more is kept than what the file will hold.
//!
//! Over an input that is animated already, each frame starts from what a clip shows then: [`Frame::moment`] is that moment, and the new
//! clip takes the channels of the other one along.
//!
//! What bones do needs no targets: a [`BoneBaker`] takes where joints are to be and gives them tracks.
//!
//! Engines and programs that take no morph targets get every vertex at every frame: in point caches ([`cache_head`],
//! [`cache_sample_into`]), or in a vertex animation texture ([`Vat`]). Both are plain bytes of plain numbers.
//!
//! What a moment does to a surface can be a picture too: [`map`] makes a normal map and a height map of it.

mod adapt;
mod areas;
mod bake;
mod bones;
mod cache;
mod error;
mod field;
mod frames;
pub mod map;
mod play;
mod principal;
mod settings;
mod span;
mod study;
mod subspace;
mod track;
mod vat;
mod vectors;
mod writer;

pub use adapt::Moments;
pub use bake::bake;
pub use bones::{Bone, BoneBaker, BonePose, World};
pub use cache::{CacheError, CacheFormat, CacheHead, cache_head, cache_sample_into};
pub use error::BakeError;
pub use frames::Baker;
pub use settings::{Bake, CROWDED, Settings};
pub use vat::{
    MAX_SIDE, Vat, VatClip, VatError, VatFormat, VatLayout, VatNormals, VatRange, remap_info, write_exr,
    write_png,
};
pub use writer::{Baked, Frame, NodeBake, Played};
