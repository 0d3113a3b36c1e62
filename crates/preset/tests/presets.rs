//! The presets of the project: each runs as it stands.

use std::path::{Path, PathBuf};

use wirework_preset::{Limits, PresetErrorKind, parse};

fn presets() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../presets");
    let mut found = Vec::new();
    for folder in ["deform", "wrinkle", "stitch", "ik"] {
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
        // Of its own, or of the pieces that it sews.
        let pieces = parsed.preset.pieces();
        let objects: Vec<_> = parsed
            .preset
            .object
            .iter()
            .chain(pieces.iter().filter_map(|piece| piece.object.as_ref()))
            .collect();
        assert!(!objects.is_empty(), "{}", path.display());
        for object in objects {
            let mesh = object.build().expect("a mesh").expect("no file");
            assert!(!mesh.face_ends.is_empty(), "{}", path.display());
        }
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

/// The names of the fields that a struct in a preset has, found by asking for one that it has not.
fn fields(text: &str) -> Vec<String> {
    let errors = parse(text.as_bytes(), &Limits::default()).expect_err("no field `nowhere`");
    let error = errors.errors().iter().find(|error| error.message.contains("has no field `nowhere`"));
    let error = error.unwrap_or_else(|| panic!("{text}\n{errors}"));
    assert_eq!(error.kind, PresetErrorKind::Name);
    error.message.split('`').skip(5).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_readme_names_every_field() {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../presets/README.md");
    let text = std::fs::read_to_string(readme).expect("the README");
    let wire = |inside: &str| format!("Deform(wires: [Wire(curve: Polyline([(0, 0, 0)]), {inside})])");
    let object = |object: &str| format!("Deform(object: {object}, wires: [])");
    for preset in [
        "Deform(nowhere: 1)".to_owned(),
        "Wrinkle(nowhere: 1)".to_owned(),
        "Stitch(nowhere: 1)".to_owned(),
        "Ik(nowhere: 1)".to_owned(),
        "Deform(blend: Blend(nowhere: 1))".to_owned(),
        "Deform(lattice: Lattice(nowhere: 1))".to_owned(),
        "Deform(wires: [WireLattice(nowhere: 1)])".to_owned(),
        "Deform(wires: [WireLattice(moves: [Move(nowhere: 1)])])".to_owned(),
        wire("nowhere: 1"),
        wire("domains: [Domain(nowhere: 1)]"),
        wire("locators: [Locator(nowhere: 1)]"),
        "Deform(wires: [Wire(curve: BSpline(nowhere: 1))])".to_owned(),
        object("Grid(nowhere: 1)"),
        object("Tube(nowhere: 1)"),
        object("Sphere(nowhere: 1)"),
        object("Box(nowhere: 1)"),
        object("Patch(nowhere: 1)"),
    ] {
        let fields = fields(&preset);
        assert!(fields.len() >= 3, "{preset}");
        for field in fields {
            // In backquotes, alone or within a value.
            let mut quoted = text.split('`').skip(1).step_by(2);
            let whole =
                |code: &str| code.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == field);
            assert!(quoted.any(whole), "`{field}` of {preset}");
        }
    }
}
