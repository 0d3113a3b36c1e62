//! Frames of a deformation as glTF morph targets or tracks of joints, and a clip that plays them.
//!
//! A [`Baker`] takes the deformed state of all vertices frame after frame and writes what differs from the rest at
//! once, so that no more is kept than what the file will hold. [`Baker::finish`] then adds targets, weights and clip
//! to the document.
//!
//! Over an input that is animated already, each frame starts from what a clip shows then: [`Baker::push_from`] takes that moment,
//! and the new clip takes the channels of the other one along.
//!
//! What bones do needs no targets: a [`BoneBaker`] takes where joints are to be and gives them tracks.
//!
//! One target a frame is exact, and as large as the motion is long; frames that are equal share a target, and a frame
//! that equals the rest has none. Key poses and bases are other ways to the same clip and have their place in
//! [`Bake`].

mod bones;
mod frames;
mod settings;

pub use bones::{Bone, BoneBaker, World};
pub use frames::{BakeError, Baked, Baker};
pub use settings::{Bake, CROWDED, Settings};
