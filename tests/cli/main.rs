//! The command from outside, as a user runs it.
#![cfg(feature = "cli")]

mod apply;
mod caches;
mod commands;
mod document;
mod effects;
mod elements;
mod engines;
mod exit_codes;
mod faults;
mod hostile;
mod inspect;
mod limbs;
mod made_files;
mod maps;
mod masks;
mod morphs;
mod nothing_lost;
mod obj_looks;
mod place;
mod player;
mod real_files;
mod render;
mod skeleton;
mod stitches;
mod storage;
mod tangents;
mod textures;
mod wire_skins;
mod wrinkles;

#[path = "../../crates/asset/tests/oracle/mod.rs"]
mod oracle;

#[path = "../../crates/asset/tests/make/mod.rs"]
#[expect(dead_code, reason = "the tests of the asset crate use more of it")]
mod make;
