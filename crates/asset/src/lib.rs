//! glTF and OBJ: checked reading and append-only writing.
//!
//! Only this crate knows the two formats. A [`Gltf`] keeps the document as it was read; [`Gltf::rest`] gives what
//! its scene shows, in world space, as plain arrays; an effect deforms them; [`Rest::to_local`] takes the result
//! back through nodes and skins; [`Gltf::player`] plays clips, with or without it, and [`Player::rest_into`] makes a rest of
//! any moment of one; and what is added to the document comes after everything that was there, so that no index moves and
//! whatever the effect does not touch comes out as it went in.
//!
//! Nothing is trusted: ranges, counts and types are checked where they are read, and [`Limits`] before memory is
//! asked for. No input makes this crate panic.

mod accessor;
mod attributes;
mod census;
mod channels;
mod clip;
mod color;
mod container;
mod content;
mod delta;
mod document;
mod edit;
mod error;
mod even;
mod flat;
mod frame;
mod frame_store;
mod graph;
mod hang;
mod image;
mod joint_track;
mod json;
mod limits;
mod lineage;
mod local;
mod look;
mod mapped;
mod merge;
mod meshopt;
mod moment;
mod morph;
mod names;
mod obj;
mod output;
mod parts;
mod place;
mod played;
mod player;
mod pose;
mod primitive;
mod refine;
mod rest;
mod rooted;
mod save;
mod schema;
mod scratch;
mod select;
mod shown;
mod skeleton;
mod skin;
mod split;
mod still;
mod store;
mod stroke;
mod survey;
mod tangent;
mod texture;
mod track;
mod uri;
mod way;

pub use census::NodeCensus;
pub use clip::{Clip, Tracks, WeightTrack};
pub use content::Content;
pub use document::{Gltf, Outline};
pub use error::{AssetError, ErrorClass, Place, Warning, printable};
pub use flat::Flat;
pub use frame_store::FrameStore;
pub use image::EncodedImage;
pub use joint_track::JointTrack;
pub use limits::Limits;
pub use local::LocalDeltas;
pub use look::{Alpha, Look};
pub use morph::{MeshTarget, MorphTarget};
pub use obj::{Obj, ObjElements, ObjMaterial, ObjMembers, ObjPart, ObjTexture, write_obj, write_obj_parts};
pub use output::{
    MadeFile, OutputFile, Spool, WriteBytes, check_output, same_file, write_files, write_files_and,
};
pub use parts::NodeParts;
pub use player::Player;
pub use pose::NodePose;
pub use primitive::Mode;
pub use refine::{Refined, RefinedMesh};
pub use rest::{Block, Part, Rest};
pub use save::Format;
pub use scratch::{NewLook, NewMesh, NewPart};
pub use select::JointWeights;
pub use skeleton::{Hung, NewJoint, NewSkin};
pub use split::{Knot, Split};
pub use store::HELD_BYTES;
pub use stroke::Stroke;
pub use texture::{TextureUse, UvTransform, Wrap};
