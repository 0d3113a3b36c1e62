//! The table of exit codes, and what stands on which stream.

use crate::place::Place;

/// A wrong value, at line 1, column 78.
const TYPO: &str =
    "Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), radius: Kyes([(0, 1), (2, 3)]))])";

fn place() -> Place {
    let place = Place::new();
    place.write("typo.ron", TYPO);
    place.write(
        "bare.ron",
        "Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), twist: 90)])",
    );
    place.write(
        "lost.ron",
        "Deform(object: File(\"none.glb\"), wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), twist: 9)])",
    );
    place.write("newer.ron", "Deform(version: 99, wires: [])");
    place.write("huge.ron", "Deform(object: Grid(size: (1, 1), cells: (100000, 100000)), wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), twist: 9)])");
    place.write(
        "wild.ron",
        "Deform(object: Points([(0, 0, 0.1)]), wires: [Wire(curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), \
         pose: [(-1, 1e38, 0), (1, 1e38, 0)], amplitude: 1e30)])",
    );
    place.write("long.ron", "Deform(duration: 1e9, object: Points([(0, 0, 0)]), wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), amplitude: Keys([(0, 0), (1, 1)]), twist: 1)])");
    place.write(
        "cloud.ron",
        "Wrinkle(object: Points([(0, 0, 0)]), pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])]))",
    );
    place.write(
        "heap.ron",
        "Stack([Deform(object: Points([(0, 0, 0)]), wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), \
         pose: [(0, 1, 0), (1, 1, 0)])]), \
         Wrinkle(pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])]))])",
    );
    place.write("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 0 -1\nf 1 2 3\n");
    place.write(
        "burst.ron",
        "Stack([Deform(wires: [Wire(curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 5, \
         pose: [(-1, 1e38, 0), (1, 1e38, 0)], amplitude: 1e30)]), \
         Wrinkle(pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])]))])",
    );
    place.write("bad.glb", "glTF");
    place.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
    place.write("text.txt", "hello");
    place.write("empty.gltf", r#"{"asset": {"version": "2.0"}}"#);
    place
}

#[test]
fn every_failure_has_its_exit_code() {
    let place = place();
    let before = place.files();
    for (code, line) in [
        // 1, the work: no place for what is written.
        (1, "apply lift.ron -o nowhere/out.glb"),
        (1, "apply lift.ron -o out.glb --report nowhere/report.json"),
        (1, "apply lift.ron -o out.glb --report ."),
        // 2, the command line.
        (2, ""),
        (2, "stitch lift.ron -o out.glb"),
        (2, "render lift.ron"),
        (2, "apply"),
        (2, "apply lift.ron"),
        (2, "apply lift.ron -o out"),
        (2, "apply lift.ron -o out.fbx"),
        (2, "apply lift.ron -o out.glb --frames 3"),
        (2, "apply lift.ron -o out.glb --frames 3..3"),
        (2, "apply lift.ron -o out.glb --frames 0..3 --at 1"),
        (2, "apply lift.ron -o out.glb --at nan"),
        (2, "apply lift.ron -o out.glb --fps 0"),
        (2, "apply lift.ron -o out.glb --fps 1e12 --frames 4000000000..4000000002"),
        (2, "apply lift.ron -o out.glb --threads 0"),
        (2, "apply lift.ron -o out.glb --at 0.5 --bake skin"),
        (2, "apply lift.ron -o out.glb --bake nonsense"),
        (2, "apply lift.ron -o lift.ron"),
        // The report in the place of what is written or read.
        (2, "apply lift.ron -o out.glb --report out.glb"),
        (2, "apply lift.ron -o out.glb --report ./out.glb"),
        (2, "apply lift.ron -o ./out.glb --report out.glb --dry-run"),
        (2, "apply lift.ron -o f####.obj --report f0000.obj"),
        (2, "apply lift.ron -o out.gltf --report out.bin"),
        (2, "apply lift.ron -o out.glb --report ./lift.ron"),
        (2, "apply lift.ron bad.obj -o out.glb --report ./bad.obj"),
        (2, "apply lift.ron -o out.glb --clip nonsense"),
        (2, "apply lift.ron -o out.obj --at 0 --clip nonsense"),
        (2, "new limb"),
        (2, "new wrinkel"),
        (2, "check"),
        (2, "completions tcsh"),
        // 3, the asset.
        (3, "apply lift.ron none.glb -o out.glb"),
        (3, "apply lift.ron none -o out.glb"),
        (3, "apply lift.ron bad.glb -o out.glb"),
        (3, "apply lift.ron bad.obj -o out.glb"),
        (3, "apply lift.ron text.txt -o out.glb"),
        (3, "apply lift.ron empty.gltf -o out.glb"),
        (3, "apply lost.ron -o out.glb"),
        (3, "check lost.ron"),
        (3, "inspect bad.glb"),
        (3, "inspect none.obj"),
        // 4, the preset.
        (4, "apply none.ron -o out.glb"),
        (4, "apply typo.ron -o out.glb"),
        (4, "apply bare.ron -o out.glb"),
        (4, "apply newer.ron -o out.glb"),
        (4, "apply text.txt -o out.glb"),
        (4, "apply wild.ron -o out.glb"),
        (4, "check typo.ron"),
        (4, "check lift.ron typo.ron none.ron"),
        (4, "check ."),
        (4, "inspect typo.ron"),
        (4, "apply cloud.ron -o out.glb"),
        (4, "check cloud.ron"),
        (4, "apply heap.ron -o out.glb"),
        (4, "check heap.ron"),
        (4, "check wild.ron"),
        (4, "apply burst.ron triangle.obj -o out.glb"),
        // 5, a limit.
        (5, "apply huge.ron -o out.glb"),
        (5, "apply long.ron -o out.glb"),
        (5, "apply lift.ron -o out.glb --max-frames 3"),
        (5, "apply lift.ron -o out.glb --bake frames --max-targets 3"),
        (5, "apply lift.ron -o out.glb --max-preset-bytes 3"),
        (5, "apply lift.ron -o out.glb --max-vertices 3"),
        (5, "apply lift.ron bad.obj -o out.glb --max-file-bytes 3"),
    ] {
        let done = place.run(line);
        let err = done.err();
        assert_eq!(done.code(), code, "{line}: {err}");
        // What can be told of a model was asked for.
        let asked = line.starts_with("inspect") && code == 3;
        assert!(
            !err.is_empty() && (asked || done.out().is_empty()),
            "{line}: what is said is on standard error"
        );
        assert!(!err.contains("has a bug"), "{line}: {err}");
        assert!(code != 5 || err.contains("--max-"), "{line}: which flag raises the limit? {err}");
        assert_eq!(place.files(), before, "{line}: nothing is written");
    }
}

#[test]
fn what_succeeds_is_zero_and_warnings_do_not_change_that() {
    let place = place();
    place.write("odd.ron", "Deform(duration: 1, object: Points([(0, 0, 0)]), wires: [Wire(curve: Polyline(points: [(0, 0, 0)]))])");
    for line in [
        "--help",
        "--version",
        "apply --help",
        "check lift.ron",
        "check odd.ron",
        "inspect lift.ron",
        "man",
        "new deform",
    ] {
        let done = place.run(line).expect(0);
        let asked = !line.starts_with("check");
        assert_eq!(!done.out().is_empty(), asked, "{line}");
    }
    let done = place.run("check odd.ron").expect(0);
    assert!(done.err().contains("warning: this wire moves nothing"), "{}", done.err());
    place.run("check odd.ron --strict").expect(4);
    place.run("apply odd.ron --dry-run --strict").expect(4);
}

#[test]
fn a_preset_error_has_file_line_column_caret_and_the_nearest_name() {
    let place = place();
    let err = place.run("check typo.ron").expect(4).err();
    for part in ["typo.ron:1:78", "^^^^", "Kyes", "did you mean `Keys`?", "wires[0].radius"] {
        assert!(err.contains(part), "{part:?} in\n{err}");
    }
    let caret = err.lines().find(|line| line.contains("^^^^")).unwrap().find('^').unwrap();
    let source = err.lines().find(|line| line.contains("Kyes(")).unwrap().find("Kyes").unwrap();
    assert_eq!(caret, source, "the caret is under the name:\n{err}");
    // The same behind a byte order mark, from standard input.
    let marked = [b"\xef\xbb\xbf", TYPO.as_bytes()].concat();
    let err = place.run_with(["check", "-"], &marked).expect(4).err();
    assert!(err.contains("<stdin>:1:78"), "{err}");
}

#[test]
fn an_asset_error_has_its_json_pointer() {
    let place = place();
    let text = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 7}]}"#;
    place.write("in.gltf", text);
    let err = place.run("apply lift.ron in.gltf -o out.glb").expect(3).err();
    assert!(err.contains("in.gltf: /nodes/0/mesh: found"), "{err}");
}

#[test]
fn control_characters_never_reach_the_terminal() {
    let place = place();
    place.write("esc.ron", "Deform(\u{1b}[31mwires: [], \"\u{1b}[2J\": 3)");
    place.write("name.ron", "Deform(object: File(\"\u{1b}[2J.glb\"), wires: [Wire(curve: Polyline(points: [(0, 0, 0)]), twist: 9)])");
    place.write("in.gltf", r#"{"asset": {"version": "\u001b[2J"}}"#);
    for (code, args) in [
        (4, vec!["check", "esc.ron"]),
        (3, vec!["check", "name.ron"]),
        (4, vec!["check", "no\u{1b}[2Jsuch.ron"]),
        (3, vec!["inspect", "in.gltf"]),
        (3, vec!["inspect", "\u{1b}[2J.obj"]),
        (2, vec!["apply", "lift.ron", "-o", "\u{1b}[2J.fbx"]),
        (2, vec!["new", "\u{1b}[2J"]),
    ] {
        let done = place.run_with(args.iter().copied(), b"").expect(code);
        assert!(!done.err().contains('\u{1b}'), "{args:?}: {}", done.err());
    }
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let place = place();
    for args in [&["man"][..], &["completions", "zsh"], &["new", "deform"], &["inspect", "lift.ron"]] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_wirework"))
            .args(args)
            .current_dir(place.path("."))
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let done = child.wait_with_output().unwrap();
        assert!(done.status.success(), "{args:?}: {:?}", String::from_utf8_lossy(&done.stderr));
        assert!(done.stderr.is_empty());
    }
}

#[test]
fn a_report_never_takes_the_place_of_anything() {
    let place = Place::new();
    place.run("apply lift.ron -o in.gltf --at 0").expect(0);
    place.write("out.glb", "precious");
    let buffer = place.read("in.bin");
    for line in [
        "apply lift.ron -o out.glb --report ./out.glb",
        "apply lift.ron in.gltf -o new.glb --report in.bin",
        "apply lift.ron in.gltf -o new.glb --report ./in.bin --dry-run",
    ] {
        place.run(line).expect(2);
        assert!(place.read("out.glb") == b"precious" && place.read("in.bin") == buffer, "{line}");
        assert!(!place.files().contains(&"new.glb".to_owned()), "{line}");
    }
    // A report that cannot be written is found before the output is.
    let err = place.run("apply lift.ron -o out.glb --report nowhere/report.json").expect(1).err();
    assert!(err.contains("nowhere/report.json") && err.contains("expected a folder"), "{err}");
    assert!(place.read("out.glb") == b"precious");
    // One beside the output is none of that, and an older one is replaced.
    for _ in 0..2 {
        place.run("apply lift.ron -o out.glb --report out.json").expect(0);
    }
    assert!(place.read("out.json").starts_with(b"{"));
}

#[test]
fn the_object_that_a_model_replaces_may_be_as_large_as_it_likes() {
    let place = place();
    for (line, own) in [
        ("apply lift.ron {} -o out.glb --at 1", "apply lift.ron -o out.glb --at 1"),
        (
            "render lift.ron {} -o out.png --at 1 --fast --size 32x32",
            "render lift.ron -o out.png --at 1 --fast --size 32x32",
        ),
        ("check lift.ron --on {}", "check lift.ron"),
    ] {
        let on =
            |limit: u32| place.run(&format!("{} --max-vertices {limit}", line.replace("{}", "triangle.obj")));
        on(3).expect(0);
        // The model is not.
        assert!(on(2).expect(5).err().contains("triangle.obj"), "{line}");
        let err = place.run(&format!("{own} --max-vertices 3")).expect(5).err();
        assert!(err.contains("lift.ron:2:13") && err.contains("--max-vertices raises it"), "{err}");
    }
}
