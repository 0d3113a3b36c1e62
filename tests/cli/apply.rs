//! `wirework apply`, from outside: what it writes against closed forms, and what it leaves alone.

use std::collections::BTreeSet;

use glam::DVec3;
use wirework::asset::{Gltf, Limits, Obj};

use crate::oracle;
use crate::place::{Place, lifted};

/// How far what is written may be from the closed form, in metres of a scene of 2.8 m: f32 and the tolerance of frames.
const CLOSE: f64 = 1e-5;

/// The grid's own points, in its vertex order, `t` seconds in.
fn check_grid(positions: impl IntoIterator<Item = DVec3>, t: f64) {
    let mut count = 0;
    for (i, p) in positions.into_iter().enumerate() {
        let rest =
            DVec3::new(f64::from(i as u32 % 17) / 8.0 - 1.0, 0.0, f64::from(i as u32 / 17) / 8.0 - 1.0);
        let want = DVec3::new(rest.x, lifted(rest.z, t), rest.z);
        assert!(p.distance(want) < CLOSE, "vertex {i} at {t} s: {p}, not {want}");
        count += 1;
    }
    assert_eq!(count, 17 * 17);
}

fn wide(p: &[f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

#[test]
fn an_animation_plays_the_closed_form() {
    let place = Place::new();
    let done = place.run("apply lift.ron -o out.glb").expect(0);
    assert_eq!(done.out(), "", "standard output holds only what was asked for");
    let glb = place.read("out.glb");
    for frame in [0, 1, 11, 24] {
        let t = f64::from(frame) / 24.0;
        let shown = oracle::evaluate(&glb, Some("wirework"), t as f32);
        assert!(oracle::diagonal(&shown) > 2.8);
        let [oracle::Shown { node: 0, primitive: 0, positions, normals: Some(normals), .. }] =
            shown.as_slice()
        else {
            panic!("one primitive with normals")
        };
        check_grid(positions.iter().copied(), t);
        // The crest is level, its flanks are not.
        for (p, n) in positions.iter().zip(normals) {
            let flat = frame == 0 || p.z == 0.0 || p.z.abs() > 0.6;
            assert!(if flat { n.y > 0.999 } else { n.y < 1.0 && n.z * p.z > 0.0 }, "{frame} {p} {n}");
        }
    }
}

#[test]
fn stills_of_every_format_hold_the_same_moment() {
    let place = Place::new();
    for out in ["out.glb", "out.gltf", "out.obj"] {
        place.run(&format!("apply lift.ron -o {out} --at 0.75")).expect(0);
    }
    for name in ["out.glb", "out.gltf"] {
        let gltf = Gltf::read(&place.path(name), &Limits::default()).unwrap();
        assert!(gltf.clip_names().is_empty());
        check_grid(gltf.rest().unwrap().positions.iter().map(wide), 0.75);
    }
    let obj = Obj::read(&place.path("out.obj"), &Limits::default()).unwrap();
    check_grid(obj.mesh.positions.iter().map(wide), 0.75);
    assert_eq!(obj.mesh.face_ends.len(), 16 * 16, "quads stay quads");
}

#[test]
fn a_sequence_has_a_file_for_each_frame() {
    let place = Place::new();
    std::fs::create_dir(place.path("frames")).unwrap();
    place.run("apply lift.ron -o frames/a_#####.obj --fps 4").expect(0);
    for frame in 0..=4 {
        let path = place.path(&format!("frames/a_0000{frame}.obj"));
        let obj = Obj::read(&path, &Limits::default()).unwrap();
        check_grid(obj.mesh.positions.iter().map(wide), f64::from(frame) / 4.0);
    }
    assert!(!place.path("frames/a_00005.obj").exists());
    place.run("apply lift.ron -o ####.obj --frames 2..4").expect(0);
    assert_eq!(place.files(), ["0002.obj", "0003.obj", "frames", "lift.ron"]);
}

#[test]
fn a_lone_obj_holds_no_animation() {
    let place = Place::new();
    let err = place.run("apply lift.ron -o out.obj").expect(2).err();
    assert!(err.contains("####") && err.contains("--at"), "{err}");
    place.run("apply lift.ron -o ####.obj --at 1").expect(2);
    assert_eq!(place.files(), ["lift.ron"]);
    // Without keys there is nothing to animate.
    let still = crate::place::LIFT.replace(
        "Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.5, 0), (1, 0.5, 0)])])",
        "[(-1, 0.5, 0), (1, 0.5, 0)]",
    );
    place.write("still.ron", still);
    place.run("apply still.ron -o out.obj").expect(0);
    check_grid(
        Obj::read(&place.path("out.obj"), &Limits::default()).unwrap().mesh.positions.iter().map(wide),
        1.0,
    );
}

#[test]
fn frames_keep_their_numbers_and_times() {
    let place = Place::new();
    place.run("apply lift.ron -o out.glb --frames 12..19 --bake frames").expect(0);
    let glb = place.read("out.glb");
    let shown = oracle::evaluate(&glb, Some("wirework"), 0.5);
    check_grid(shown[0].positions.iter().copied(), 0.5);
    let document = gltf::Gltf::from_slice(&glb).unwrap();
    let input = document.animations().next().unwrap().samplers().next().unwrap().input();
    assert_eq!((input.count(), input.min().unwrap()[0].as_f64()), (7, Some(0.5)));
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let place = Place::new();
    let root = env!("CARGO_MANIFEST_DIR");
    for preset in ["presets/wrinkle/forehead.ron", "presets/deform/cross.ron"] {
        let mut all = BTreeSet::new();
        for threads in [1, 2, 5] {
            place.run(&format!("apply {root}/{preset} -o {threads}.glb --threads {threads}")).expect(0);
            all.insert(place.read(&format!("{threads}.glb")));
        }
        assert_eq!(all.len(), 1, "{preset}");
    }
}

#[test]
fn a_report_has_its_keys_and_they_add_up() {
    let place = Place::new();
    let done = place.run("apply lift.ron -o out.glb --report - --threads 1").expect(0);
    let report: gltf::json::Value = gltf::json::deserialize::from_str(&done.out()).unwrap();
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key} in {report}"));
    assert_eq!(["points", "wires", "frames", "threads"].map(number), [289.0, 1.0, 25.0, 1.0]);
    let phases = ["bind_ms", "deform_ms", "normals_ms", "write_ms"].map(number);
    assert!(phases.iter().all(|&ms| ms > 0.0) && phases.iter().sum::<f64>() <= number("total_ms"));
    if cfg!(target_os = "linux") {
        assert!(number("peak_bytes") > 1e6);
    }
    assert_eq!(report["warnings"], gltf::json::Value::Array(Vec::new()));
    let done = place.run("apply lift.ron -o out.glb --report report.json").expect(0);
    assert_eq!(done.out(), "");
    assert!(place.read("report.json").starts_with(b"{"));
}

#[test]
fn a_dry_run_does_all_but_write() {
    let place = Place::new();
    let done = place.run("apply lift.ron --dry-run --report -").expect(0);
    assert!(done.out().contains("\"frames\": 25"), "{}", done.out());
    place.run("apply lift.ron -o out.glb --dry-run").expect(0);
    place.run("apply lift.ron -o out.fbx --dry-run").expect(2);
    assert_eq!(place.files(), ["lift.ron"]);
}

#[test]
fn a_run_that_fails_leaves_what_was_there() {
    let place = Place::new();
    place.write("out.glb", "old");
    place.run("apply lift.ron -o out.glb --bake frames --max-targets 3").expect(5);
    place.write(
        "flat.ron",
        "Deform(wires: [Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), twist: 90)])",
    );
    place.write("bad.obj", "v 0 0 0\nv 1 0\n");
    place.run("apply flat.ron bad.obj -o out.glb").expect(3);
    place.run("apply lift.ron -o none/out.glb").expect(1);
    place.run("apply lift.ron -o .glb").expect(2);
    assert_eq!(place.read("out.glb"), b"old");
    assert_eq!(place.files(), ["bad.obj", "flat.ron", "lift.ron", "out.glb"]);
    place.run("apply lift.ron -o out.glb").expect(0);
    assert_eq!(place.read("out.glb")[..4], *b"glTF");
}

#[test]
fn the_input_is_overwritten_only_on_request() {
    let place = Place::new();
    place.run("apply lift.ron -o in.glb --at 0").expect(0);
    let before = place.read("in.glb");
    let err = place.run("apply lift.ron in.glb -o ./in.glb").expect(2).err();
    assert!(err.contains("--in-place"), "{err}");
    assert_eq!(place.read("in.glb"), before);
    place.run("apply lift.ron in.glb -o in.glb --in-place").expect(0);
    assert!(place.read("in.glb").len() > before.len());
    place.run("apply lift.ron in.glb -o out.glb --report in.glb").expect(2);
    place.write(
        "own.ron",
        "Deform(object: File(\"in.glb\"), wires: [Wire(curve: Polyline(points: [(0, 0, 0)]))])",
    );
    place.run("apply own.ron -o in.glb").expect(2);
}

#[test]
fn an_effect_goes_into_a_clip_of_the_input() {
    let place = Place::new();
    let err = place.run("apply lift.ron -o first.glb").expect(0).err();
    assert!(!err.contains("its clip"), "it is the only one: {err}");
    // The same node's weights move already in that clip.
    place.run("apply lift.ron first.glb -o second.glb --into wirework").expect(3);
    place.run("apply lift.ron first.glb -o second.glb --into 0").expect(3);
    let err = place.run("apply lift.ron first.glb -o second.glb --into walk").expect(2).err();
    assert!(err.contains("\"wirework\""), "it names the clips there are: {err}");
    place.run("apply lift.ron first.glb -o second.glb --clip walk").expect(2);
    place.run("apply lift.ron first.glb -o second.glb --at 0 --into 0").expect(2);
    let err = place.run("apply lift.ron first.glb -o second.glb --clip wirework --into new").expect(0).err();
    assert!(err.ends_with("; its clip is 1 \"wirework_2\"\n"), "{err}");
    let second = Gltf::read(&place.path("second.glb"), &Limits::default()).unwrap();
    assert_eq!(second.clip_names(), [Some("wirework"), Some("wirework_2")]);
    check_grid(
        oracle::evaluate(&place.read("second.glb"), Some("wirework_2"), 1.0)[0].positions.iter().copied(),
        1.0,
    );
}

#[test]
fn a_stack_works_on_the_result_before() {
    let place = Place::new();
    // Both halves lift by the same wire; the second finds the grid lifted by the first, and its own reference there.
    place.write(
        "stack.ron",
        "Stack([
            Deform(object: Grid(size: (2, 2), cells: (16, 16)), wires: [Wire(
                curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]),
                pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.25, 0), (1, 0.25, 0)])]), radius: 100)]),
            Deform(wires: [Wire(
                curve: Polyline(points: [(-1, 0.25, 0), (1, 0.25, 0)]),
                pose: [(-1, 0.75, 0), (1, 0.75, 0)], radius: 0.5)]),
        ])",
    );
    place.run("apply stack.ron -o out.obj --at 1").expect(0);
    let obj = Obj::read(&place.path("out.obj"), &Limits::default()).unwrap();
    for p in &obj.mesh.positions {
        let first = 0.25 * (1.0 - (f64::from(p[2]) / 100.0).powi(2)).powi(2);
        let distance = DVec3::new(0.0, first - 0.25, f64::from(p[2])).length();
        let want = first + lifted(distance, 1.0);
        assert!((f64::from(p[1]) - want).abs() < CLOSE, "{p:?} {want}");
    }
    // Half a second in the first effect has come half way, and the second binds anew.
    place.run("apply stack.ron -o out.obj --at 0.5").expect(0);
    let obj = Obj::read(&place.path("out.obj"), &Limits::default()).unwrap();
    let middle = obj.mesh.positions.iter().find(|p| p[0] == 0.0 && p[2] == 0.0).unwrap();
    assert!((f64::from(middle[1]) - (0.125 + lifted(0.125, 1.0))).abs() < CLOSE, "{middle:?}");
}

#[test]
fn an_effect_out_of_reach_is_a_warning() {
    let place = Place::new();
    place.write("far.obj", "v 9 9 9\nv 8 9 9\nv 9 8 9\nf 1 2 3\n");
    let done = place.run("apply lift.ron far.obj -o out.obj --at 1").expect(0);
    assert!(done.err().contains("reaches no vertex"), "{}", done.err());
    assert_eq!(place.read("out.obj"), place.read("far.obj"));
    place.run("apply lift.ron far.obj -o strict.obj --at 1 --strict").expect(3);
    assert!(!place.path("strict.obj").exists());
    let quiet = place.run("apply lift.ron far.obj -o out.obj --at 1 -q").expect(0);
    assert_eq!(quiet.err(), "");
}

#[test]
fn points_are_an_object_too() {
    let place = Place::new();
    place.write("points.obj", "# a cloud\nv 0 0 0\nv 0.5 0 0.25 # a comment\nv 0 0 3\n");
    place.run("apply lift.ron points.obj -o out.obj --at 1").expect(0);
    let text = String::from_utf8(place.read("out.obj")).unwrap();
    assert_eq!(text, "# a cloud\nv 0 0.5 0\nv 0.5 0.28125 0.25 # a comment\nv 0 0 3\n");
    place.run("apply lift.ron points.obj -o out.glb").expect(0);
    let shown = oracle::evaluate(&place.read("out.glb"), Some("wirework"), 1.0);
    assert!((shown[0].positions[1].y - 0.281_25).abs() < CLOSE);
    // A wrinkle needs a surface.
    place.write("wrinkle.ron", "Wrinkle(pattern: Drawn([Polyline(points: [(0, 0, 0), (1, 0, 0)])]))");
    place.run("apply wrinkle.ron points.obj -o out.obj").expect(3);
}

#[test]
fn seams_of_an_obj_stay_shut() {
    let place = Place::new();
    // Two triangles with vertices of their own along a common edge, one of them at −0.
    place.write(
        "seam.obj",
        "v 0 0 0\nv 1 0 0\nv 0 0 0.25\nv -0 0 0.25\nv 1 0 0\nv 1 0 0.25\nf 1 3 2\nf 4 6 5\n",
    );
    place.run("apply lift.ron seam.obj -o out.obj --at 0.3").expect(0);
    let obj = Obj::read(&place.path("out.obj"), &Limits::default()).unwrap();
    let p = &obj.mesh.positions;
    assert_eq!((p[1], p[2]), (p[4], p[3]));
    assert!(p[2][1] > 0.05);
}

#[test]
fn what_happens_between_two_frames_is_played() {
    let place = Place::new();
    let [low, high] = [0.0, 0.4].map(|y| format!("[(-1, {y}, 0), (1, {y}, 0)]"));
    let keys = format!("Keys([(0, {low}), (0.53, {low}), (0.535, {high}), (0.54, {low}), (1, {low})])");
    let wire = format!("Wire(curve: Polyline(points: {low}), radius: 5, pose: {keys})");
    place.write("p.ron", format!("Deform(object: Grid(size: (2, 2), cells: (4, 4)), wires: [{wire}])"));
    place.run("apply p.ron -o out.glb").expect(0);
    for (seconds, lift) in [(0.53, 0.0), (0.5325, 0.2), (0.535, 0.4), (0.54, 0.0)] {
        let shown = oracle::evaluate(&place.read("out.glb"), Some("wirework"), seconds);
        let highest = shown[0].positions.iter().map(|p| p.y).fold(0.0, f64::max);
        assert!((highest - lift).abs() < 3e-4, "{highest} at {seconds} s");
    }
}

#[test]
fn an_effect_within_the_tolerance_is_told_to_be_lost() {
    let place = Place::new();
    let done = place.run("apply lift.ron -o out.glb --tolerance 1").expect(0);
    assert!(done.err().contains("[still]"), "{}", done.err());
    place.run("apply lift.ron -o out.glb --tolerance 1 --strict").expect(3);
}
