//! The command from outside, as a user runs it.
#![cfg(feature = "cli")]

mod apply;
mod commands;
mod exit_codes;
mod place;
mod real_files;

#[path = "../../crates/asset/tests/oracle/mod.rs"]
mod oracle;
