//! The smaller commands: `new`, `check`, `inspect`, `completions`, `man`, and the presets of the project.

use std::path::{Path, PathBuf};

use gltf::json::Value;

use crate::place::Place;

fn presets() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets");
    let mut found = Vec::new();
    for folder in std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()) {
        if folder.is_dir() {
            found.extend(std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
        }
    }
    found.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
    found.sort();
    assert!(found.len() >= 7);
    found
}

/// How many targets the table of the presets says that a preset takes.
fn told_of(table: &str, preset: &str) -> u64 {
    let (_, place) = preset.rsplit_once("presets/").unwrap();
    let row = table.lines().find(|line| line.starts_with('|') && line.contains(&format!("]({place})")));
    let cells: Vec<&str> = row.unwrap_or_else(|| panic!("{place} has no row")).split('|').collect();
    cells[2].split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn every_preset_runs_as_it_stands_and_bakes_as_its_table_says() {
    let place = Place::new();
    let table = include_str!("../../presets/README.md");
    for preset in presets() {
        let preset = preset.to_str().unwrap();
        let args = ["apply", preset, "-o", "out.glb", "--strict", "--report", "report.json"];
        let done = place.run_with(args, b"").expect(0);
        let report: Value = serde_json::from_slice(&place.read("report.json")).unwrap();
        let off = report["bake"]["error_of_diagonal"].as_f64().unwrap();
        assert!(off <= 1e-4, "{preset}: {off} of the diagonal off");
        let nodes = report["bake"]["nodes"].as_array().unwrap().iter();
        let most = nodes.map(|node| node["targets"].as_u64().unwrap()).max().unwrap();
        let told = told_of(table, preset);
        assert!(most.abs_diff(told) <= told / 20, "{preset}: {most} targets, its table says {told}");
        assert!(!done.err().contains("warning"), "{}", done.err());
        let document = gltf::Gltf::from_slice(&place.read("out.glb")).unwrap();
        let clip = document.animations().next().unwrap_or_else(|| panic!("{preset}: a clip"));
        assert_eq!(clip.name(), Some("wirework"));
        let name = Path::new(preset).file_stem().unwrap().to_str();
        let first = document.nodes().next().unwrap();
        let table = place.run_with(["inspect", preset], b"").expect(0).out();
        let pieces = table.contains("piece 0 ");
        assert!(pieces || !preset.contains("/presets/stitch/"), "{table}");
        if pieces {
            // Its nodes are called as its pieces.
            let line = format!("piece 0      \"{}\"", first.name().unwrap());
            assert!(table.contains(&line), "{line} in\n{table}");
        } else {
            assert_eq!(first.name(), name, "a node is called as its preset");
        }
        place.run_with(["apply", preset, "-o", "out.obj", "--at", "1"], b"").expect(0);
    }
}

#[test]
fn what_new_prints_is_good_and_runs() {
    let place = Place::new();
    for effect in ["deform", "wrinkle", "stitch", "ik", "Wrinkle"] {
        let printed = place.run(&format!("new {effect}")).expect(0);
        assert_eq!(printed.err(), "");
        let checked = place.run_with(["check", "-", "--strict"], printed.out().as_bytes()).expect(0);
        assert_eq!(checked.err(), "<stdin>: ok\n");
        place.run_with(["apply", "-", "-o", "out.glb"], printed.out().as_bytes()).expect(0);
    }
    let err = place.run("new limb").expect(2).err();
    assert!(err.contains("no effect `limb`") && err.contains("`deform`") && err.contains("`ik`"), "{err}");
}

#[test]
fn check_says_which_are_good() {
    let place = Place::new();
    place.write("bad.ron", "Deform()");
    let done = place.run("check lift.ron bad.ron lift.ron").expect(4);
    assert_eq!(done.err().matches("lift.ron: ok").count(), 2, "{}", done.err());
    assert_eq!(done.out(), "");
    assert_eq!(place.run("check -q lift.ron").expect(0).err(), "");
}

#[test]
fn inspect_tells_what_apply_made() {
    let place = Place::new();
    place.run("apply lift.ron -o lift.glb --bake frames").expect(0);
    let done = place.run("inspect lift.glb --json").expect(0);
    let facts: Value = gltf::json::deserialize::from_str(&done.out()).unwrap();
    assert_eq!((facts["container"].as_str(), facts["vertices"].as_u64()), (Some("glb"), Some(289)));
    assert_eq!((facts["triangles"].as_u64(), facts["nodes"].as_u64()), (Some(512), Some(1)));
    assert_eq!(facts["meshes"][0]["morph_targets"].as_u64(), Some(24));
    assert_eq!(facts["animations"][0]["name"].as_str(), Some("wirework"));
    assert_eq!(facts["animations"][0]["duration"].as_f64(), Some(1.0));
    assert_eq!(facts["bounds"]["max"][0].as_f64(), Some(1.0));
    let table = place.run("inspect lift.glb").expect(0).out();
    for part in [
        "289 vertices",
        "512 triangles",
        "24 morph targets",
        "\"wirework\": 1 s, 1 channel",
        "(-1, 0, -1) to (1, 0, 1)",
        "border 0     64 vertices, 8.000 long, round (0.000, 0.000, 0.000), one at (-1.000, 0.000, ",
    ] {
        assert!(table.contains(part), "{part} in\n{table}");
    }
    place.run("apply lift.ron -o lift.obj --at 0").expect(0);
    let table = place.run("inspect lift.obj").expect(0).out();
    assert!(table.contains("container    obj") && table.contains("289 vertices, 512 triangles"), "{table}");
}

#[test]
fn inspect_reads_presets() {
    let place = Place::new();
    let table = place.run("inspect lift.ron").expect(0).out();
    assert_eq!(table, "object       Grid\neffect 0     Deform: 1 wire\nduration     1 s\nanimated     yes\n");
    let done = place.run("inspect lift.ron --json").expect(0);
    let facts: Value = gltf::json::deserialize::from_str(&done.out()).unwrap();
    assert_eq!(facts["effects"][0]["wires"].as_u64(), Some(1));
    assert_eq!(facts["animated"].as_bool(), Some(true));
}

#[test]
fn of_stitches_inspect_tells_pieces_and_seams() {
    let place = Place::new();
    let printed = place.run("new stitch").expect(0).out();
    place.write("new.ron", &printed);
    let table = place.run("inspect new.ron").expect(0).out();
    for line in [
        "object       none: it brings pieces",
        "effect 0     Stitch: 2 pieces, 1 seam",
        "piece 1      \"back\": Patch",
        "seam 0       \"front\" and \"back\", 1 tear",
    ] {
        assert!(table.lines().any(|own| own == line), "{line} in\n{table}");
    }
    place.write(
        "nodes.ron",
        "Stitch(seams: [Seam(a: Edge(piece: \"x\", side: UMin), b: Edge(piece: \"y\", side: UMax))])",
    );
    let table = place.run("inspect nodes.ron").expect(0).out();
    assert!(table.contains("it needs an input") && table.contains("\"x\": the node of that name"), "{table}");
}

#[test]
fn apply_says_where_welds_made_meshes_finer() {
    let place = Place::new();
    let sleeve = "presets/stitch/sleeve.ron";
    let sleeve = Path::new(env!("CARGO_MANIFEST_DIR")).join(sleeve);
    let told = place.run_with(["apply", sleeve.to_str().unwrap(), "-o", "out.glb"], b"").expect(0).err();
    assert!(told.contains("along its seams") && !told.contains("folds"), "{told}");
}

#[test]
fn stitches_are_checked_on_their_pieces() {
    let place = Place::new();
    let printed = place.run("new stitch").expect(0).out();
    place.write("off.ron", printed.replace("side: UMin)", "from: (9, 9, 9), to: (0.2, 1, 0))"));
    let err = place.run("check off.ron").expect(4).err();
    assert!(err.contains("no boundary runs here") && err.contains("at seams[0].b.from"), "{err}");
    place.write("new.ron", printed);
    // The pieces stand beside a model that has no nodes of their names.
    place.run("apply lift.ron -o lift.glb").expect(0);
    place.run("check new.ron --on lift.glb").expect(0);
    // They are its nodes where it has them.
    place.run("apply new.ron -o new.glb").expect(0);
    let nodes = "Stitch(seams: [Seam(a: Edge(piece: \"front\", loop: (-0.2, 1, 0)), b: Edge(piece: \"back\", loop: (0.2, 1, 0)))])";
    place.write("nodes.ron", nodes);
    place.run("check nodes.ron --on new.glb").expect(0);
    let err = place.run("check nodes.ron --on lift.glb").expect(4).err();
    assert!(err.contains("there is no piece \"front\""), "{err}");
}

#[test]
fn shells_get_completions_and_readers_a_manual() {
    let place = Place::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let done = place.run(&format!("completions {shell}")).expect(0);
        assert!(done.out().contains("max-targets") && done.err().is_empty(), "{shell}");
    }
    let man = place.run("man").expect(0).out();
    assert!(man.starts_with(".ie") || man.starts_with(".TH"), "{}", &man[..40]);
    assert!(man.contains("max\\-targets"));
}

#[test]
fn help_names_what_there_is() {
    let place = Place::new();
    let help = place.run("--help").expect(0).out();
    for command in ["apply", "render", "check", "new", "inspect", "completions", "man", "Exit codes"] {
        assert!(help.contains(command), "{command}");
    }
}

#[test]
fn progress_is_told_in_the_form_that_is_asked_for() {
    let place = Place::new();
    let apply = |flags: &str| place.run(&format!("apply lift.ron -o out.glb -q {flags}")).expect(0).err();
    assert_eq!(apply(""), "", "no terminal, no counter");
    assert_eq!(apply("--progress none"), "");
    let json = apply("--progress json");
    assert_eq!(json.lines().count(), 25);
    assert_eq!(json.lines().last(), Some("{\"done\":25,\"frames\":25}"));
    let plain = apply("--progress plain");
    assert!(plain.ends_with("frame 25 of 25\n") && plain.lines().count() <= 11, "{plain}");
}
