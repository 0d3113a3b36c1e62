//! Every picture in the project's pages is what the command under it makes.
//!
//! A line `wirework render ..` in one of [`PAGES`] writes a picture; the one of that name in `tests/pictures` has to look the
//! same. `WIREWORK_BLESS=1 cargo test --test goldens` makes them anew; look at them before they are committed. Where one
//! differs, expected, difference and actual stand side by side in `target/tmp`.
#![cfg(feature = "cli")]

mod compare;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use compare::{Frames, differ, strip};

/// Pages with pictures, from the project's root.
const PAGES: [&str; 2] = ["README.md", "presets/README.md"];

/// The variable that makes pictures anew.
const BLESS: &str = "WIREWORK_BLESS";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn golden(name: &str) -> PathBuf {
    root().join("tests/pictures").join(name)
}

/// A command of a page.
#[derive(Debug)]
struct Shot {
    page: &'static str,
    args: Vec<String>,
    /// The picture's name.
    output: String,
}

/// All commands that render, in the order of the pages.
fn shots() -> Vec<Shot> {
    let mut shots = Vec::new();
    for page in PAGES {
        let text = fs::read_to_string(root().join(page)).expect("a page");
        for line in text.lines() {
            let Some(rest) = line.strip_prefix("    wirework render ") else { continue };
            let args: Vec<String> = rest.split_whitespace().map(str::to_owned).collect();
            // A command on the reader's own files has no picture here.
            if !args.first().is_some_and(|first| first.starts_with("presets/")) {
                continue;
            }
            let at = args.iter().position(|arg| arg == "-o").expect("an output");
            shots.push(Shot { page, output: args[at + 1].clone(), args });
        }
    }
    shots
}

impl Shot {
    /// Runs the command at the project's root, but for its output.
    fn run(&self, folder: &Path, threads: &str) -> Vec<u8> {
        let out = folder.join(&self.output);
        let args =
            self.args.iter().map(|arg| if *arg == self.output { out.clone().into() } else { arg.into() });
        let args: Vec<std::ffi::OsString> = args.collect();
        let done = Command::new(env!("CARGO_BIN_EXE_wirework"))
            .arg("render")
            .args(args)
            .args(["--threads", threads])
            .current_dir(root())
            .output()
            .expect("the command");
        assert!(done.status.success(), "{self:?}: {}", String::from_utf8_lossy(&done.stderr));
        fs::read(out).expect("a picture")
    }

    /// What is wrong with its picture.
    fn check(&self, folder: &Path) -> Option<String> {
        let actual = self.run(folder, "2");
        let path = golden(&self.output);
        let told = Frames::decode(&actual);
        let expected = fs::read(&path).ok().map(|bytes| Frames::decode(&bytes));
        if std::env::var_os(BLESS).is_some() {
            fs::write(&path, &actual).expect("a new picture");
            return None;
        }
        let difference = match &expected {
            Some(frames) => differ(frames, &told)?,
            None => "there is no such picture".to_owned(),
        };
        let shown =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(Path::new(&self.output).with_extension("png"));
        strip(expected.as_ref(), &told).save(&shown).expect("a strip");
        Some(format!(
            "{} ({}): {difference}; see {}; {BLESS}=1 makes it anew",
            self.output,
            self.page,
            shown.display()
        ))
    }
}

#[test]
fn every_picture_is_what_its_command_makes() {
    let folder = tempfile::tempdir().expect("a folder");
    let shots = shots();
    assert!(shots.len() > 20, "{} commands in the pages", shots.len());
    let faults: Vec<String> = shots.iter().filter_map(|shot| shot.check(folder.path())).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_number_of_threads_does_not_show() {
    let folder = tempfile::tempdir().expect("a folder");
    let shots = shots();
    let has = |shot: &Shot, what: &str| shot.args.iter().any(|arg| arg.contains(what));
    let single = |shot: &Shot| !["--sheet", "--compare", ".gif"].iter().any(|what| has(shot, what));
    // One of each kind: a picture, one with wires, a row, a comparison, an animation.
    for kind in [".png", "--wires", "--sheet", "--compare", ".gif"] {
        let of_kind =
            |shot: &&Shot| has(shot, kind) && (single(shot) || !["--wires", ".png"].contains(&kind));
        let shot = shots.iter().find(of_kind).unwrap_or_else(|| panic!("a command with {kind}"));
        assert!(shot.run(folder.path(), "1") == shot.run(folder.path(), "3"), "{shot:?}");
    }
}

/// Pictures that no page shows are dead, and a preset that no page shows might as well not be there.
#[test]
fn pages_show_all_presets_and_all_pictures() {
    let shots = shots();
    let made: BTreeSet<&str> = shots.iter().map(|shot| shot.output.as_str()).collect();
    for entry in fs::read_dir(root().join("tests/pictures")).expect("the pictures") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        assert!(made.contains(name.as_str()), "no command makes {name}");
    }
    for shot in &shots {
        let text = fs::read_to_string(root().join(shot.page)).expect("a page");
        let shown = format!("tests/pictures/{})", shot.output);
        assert!(text.contains(&shown), "{} does not show {}", shot.page, shot.output);
    }
    for folder in ["presets/deform", "presets/wrinkle", "presets/stitch", "presets/ik"] {
        for entry in fs::read_dir(root().join(folder)).expect("presets") {
            let name = entry.expect("an entry").file_name().into_string().expect("a name");
            let preset = format!("{folder}/{name}");
            assert!(shots.iter().any(|shot| shot.args[0] == preset), "no picture of {preset}");
        }
    }
}
