//! The presets of the project: each runs as it stands.

use std::path::{Path, PathBuf};

use wirework_preset::{Limits, parse};

fn presets() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../presets");
    let mut found = Vec::new();
    for folder in ["deform", "wrinkle"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("the presets");
        found.extend(entries.map(|entry| entry.expect("an entry").path()));
    }
    found.sort();
    assert!(found.len() >= 7);
    found
}

#[test]
fn every_preset_is_good_animated_and_has_an_object() {
    for path in presets() {
        let bytes = std::fs::read(&path).expect("a preset");
        let parsed = parse(&bytes, &Limits::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert_eq!(parsed.warnings, [], "{}", path.display());
        assert!(parsed.preset.animated && parsed.preset.duration > 0.0, "{}", path.display());
        let mesh = parsed.preset.object.expect("an object").build().expect("a mesh").expect("no file");
        assert!(!mesh.face_ends.is_empty(), "{}", path.display());
    }
}

#[test]
fn the_readme_names_every_preset() {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../presets/README.md");
    let text = std::fs::read_to_string(readme).expect("the README");
    for path in presets() {
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(text.contains(name.as_ref()), "{name}");
    }
}
