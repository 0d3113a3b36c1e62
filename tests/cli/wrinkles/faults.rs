//! What cannot be wrinkled, and settings that cannot be: a clear word, the right exit code, at once, and nothing written.

use std::time::{Duration, Instant};

use super::{obj, sheet};
use crate::place::Place;

/// The longest that a refusal may take.
const AT_ONCE: Duration = Duration::from_secs(10);

const GRID: &str = "object: Grid(size: (2, 2), cells: (40, 40))";
const TUBE: &str = "object: Tube(from: (0, 0, 0), to: (0, 2, 0), radius: 0.3), center: (0, 1, 0.3)";
const BALL: &str = "object: Sphere(center: (0, 0, 0), radius: 1), center: (0, 1, 0)";

/// Runs a wrinkle of these fields on a model, or its own object.
fn run(place: &Place, fields: &str, model: &str) -> (i32, String) {
    place.write("fault.ron", format!("Wrinkle({fields})"));
    let before = place.files();
    let start = Instant::now();
    let done = place.run(&format!("apply fault.ron {model} -o out.glb"));
    let (code, err) = (done.code(), done.err());
    assert!(start.elapsed() < AT_ONCE, "{fields} {model} took {:?}", start.elapsed());
    assert!(!err.contains("panicked") && !err.contains("has a bug"), "{fields} {model}: {err}");
    if code == 0 {
        assert_eq!(place.files().len(), before.len() + 1, "{fields} {model}: all is written");
        gltf::Gltf::from_slice(&place.read("out.glb")).unwrap();
        std::fs::remove_file(place.path("out.glb")).unwrap();
    } else {
        assert_eq!(place.files(), before, "{fields} {model}: nothing is written");
    }
    (code, err)
}

#[track_caller]
fn refused(fields: &str, code: i32, word: &str) {
    let place = Place::new();
    let (found, err) = run(&place, fields, "");
    assert_eq!(found, code, "{fields}: {err}");
    assert!(err.contains(word), "{fields}: no {word:?} in {err}");
    assert!(err.lines().all(|line| line.len() < 400), "{fields}: {err}");
}

#[track_caller]
fn warned(fields: &str, word: &str) {
    let place = Place::new();
    let (found, err) = run(&place, fields, "");
    assert_eq!(found, 0, "{fields}: {err}");
    assert!(err.contains("warning") && err.contains(word), "{fields}: no {word:?} in {err}");
}

#[test]
fn values_out_of_range_are_refused_at_their_place() {
    for (fields, word) in [
        ("creases: 0", "`creases` must be at least 1, found 0"),
        ("creases: -3", "found `-3`"),
        ("creases: 2.5", "2.5"),
        ("creases: 1000000000", "1000000000 creases, branches included, are more than"),
        ("creases: 1000000000, pattern: Radial", "1000000000 creases"),
        ("creases: 1000000000, pattern: Ripple", "1000000000 creases"),
        ("creases: 1e30", "expected a whole number"),
        ("pattern: Radial, branches: (count: 1000000, depth: 1000000)", "creases, branches included"),
        ("pattern: Radial, branches: (count: 1, depth: 4294967295)", "creases, branches included"),
        ("pattern: Radial, branches: (count: 2, depth: 99999999999999999999)", "depth"),
        ("thickness: 0", "`thickness` must be greater than 0, found 0"),
        ("thickness: -0.1", "`thickness` must be greater than 0, found -0.1"),
        ("thickness: Keys([(0, 0.1), (1, -0.1)])", "found -0.1"),
        ("thickness: nan", "found `nan`"),
        ("thickness: inf", "inf"),
        ("intensity: nan", "found `nan`"),
        ("intensity: 1e39", "`intensity` must be a finite number"),
        ("size: (0, 1)", "`size` must be greater than 0"),
        ("size: (-1, 1)", "`size` must be greater than 0"),
        ("size: (1, nan)", "nan"),
        ("size: 1", "size"),
        ("center: (nan, 0, 0)", "nan"),
        ("center: (1e39, 0, 0)", "center"),
        ("direction: (0, 0, 0)", "a direction must not be (0, 0, 0)"),
        ("stiffness: -0.1", "`stiffness` must lie from 0 to 1"),
        ("stiffness: nan", "nan"),
        ("resistance: 1.1", "`resistance` must lie from 0 to 1"),
        ("propagation: 1.5", "`propagation` must lie from 0 to 1"),
        ("randomness: 2", "`randomness` must lie from 0 to 1"),
        ("seed: -1", "seed"),
        ("compression: 1", "`compression` must lie from 0 to less than 1"),
        ("compression: -0.1", "`compression` must lie from 0"),
        ("motion: Travelling(velocity: (1e39, 0))", "velocity"),
        ("motion: Travelling(velocity: (nan, 0))", "nan"),
        ("motion: Travelling", "Travelling"),
        ("motion: Curtain(settle: 1e9)", "`settle` must be between 0 and 60"),
        ("motion: Curtain(damping: -1)", "`damping`"),
        ("motion: Curtain, pattern: Ripple", "closed ones"),
        ("drive: Strain(from: 0.5, to: 0.2)", "`to` must be greater than `from`"),
        ("drive: Strain, motion: Travelling(velocity: (1, 0))", "cannot travel"),
        ("pattern: Drawn([])", "at least one curve"),
        ("pattern: Rippel", "did you mean `Ripple`?"),
        ("pattern: Drawn([Polyline([(nan, 0, 0), (1, 0, 0)])])", "nan"),
    ] {
        refused(&format!("{GRID}, {fields}"), 4, word);
        let place = Place::new();
        place.write("fault.ron", format!("Wrinkle(\n{GRID},\n    {fields})"));
        let err = place.run("check fault.ron").expect(4).err();
        assert!(err.contains("fault.ron:3:") && err.contains('^'), "{fields}: {err}");
    }
    for (object, word) in [
        ("object: Grid(size: (2, 2), cells: (0, 0))", "`cells` must be at least 1"),
        ("object: Grid(size: (0, 2), cells: (4, 4))", "`size` must be greater than 0"),
        ("object: Grid(size: (nan, 2))", "nan"),
        ("", "names no object"),
    ] {
        refused(object, 4, word);
    }
}

#[test]
fn a_pattern_that_does_not_lie_on_the_surface_is_refused() {
    for pattern in ["Tangential", "Radial", "Ripple"] {
        let fields = format!("{GRID}, center: (0, 3, 0), pattern: {pattern}");
        refused(&fields, 4, "the center is 3 off the surface, more than the size of the pattern, 1");
        refused(&format!("{GRID}, center: (1e30, 3, 0), pattern: {pattern}"), 4, "off the surface");
        // A place near it is good, and so is one as far as the pattern is large.
        let place = Place::new();
        assert_eq!(run(&place, &format!("{GRID}, center: (0, 0.9, 0), pattern: {pattern}"), "").0, 0);
    }
    refused(&format!("{GRID}, size: (90, 90), pattern: Ripple, creases: 1"), 4, "has room on the surface");
    refused(
        &format!("{GRID}, pattern: Drawn([Polyline([(-0.5, 9, 0), (0.5, 9, 0)])])"),
        4,
        "nowhere nearer to the surface than 9",
    );
    refused(
        &format!("{GRID}, pattern: Drawn([Polyline([(0, 1, 0), (0, -1, 0)])])"),
        4,
        "comes down on the surface as a point",
    );
    warned(
        &format!("{GRID}, size: (9, 9)"),
        "4 of 5 creases lie beyond the surface and are left out [outside-surface]",
    );
    warned(&format!("{GRID}, size: (9, 9)"), "a border of the surface cuts creases short 2 times [border]");
    warned(
        &format!("{GRID}, size: (9, 9), pattern: Radial"),
        "a border of the surface cuts creases short 5 times [border]",
    );
    warned(&format!("{GRID}, size: (9, 9), pattern: Ripple"), "[outside-surface]");
    warned(&format!("{GRID}, direction: (0, 1, 0)"), "[upright]");
}

#[test]
fn enormous_numbers_do_not_take_for_ever() {
    let huge = "size: (1e30, 1e30)";
    for object in [GRID, TUBE, BALL] {
        for pattern in ["Tangential", "Radial", "Ripple", "Radial, branches: (count: 3, depth: 3)"] {
            let fields = format!("{object}, pattern: {pattern}, {huge}");
            refused(&fields, 4, "too long for this surface");
            refused(&format!("{fields}, thickness: 1e28"), 4, "too long for this surface");
            refused(&format!("{fields}, refine: Auto"), 4, "too long for this surface");
        }
        for pattern in ["Tangential", "Radial"] {
            for velocity in ["(1e30, 0)", "(0, 1e30)", "(-1e30, 1e30)"] {
                let fields =
                    format!("{object}, pattern: {pattern}, motion: Travelling(velocity: {velocity})");
                refused(&fields, 4, "too long for this surface");
            }
        }
        // Rings come in again; a crest so thin shows nowhere, and of that there is a word.
        let place = Place::new();
        let fields = format!("{object}, pattern: Ripple, motion: Travelling(velocity: (1e30, 0))");
        assert_eq!(run(&place, &fields, "").0, 0);
        for pattern in ["Tangential", "Radial", "Ripple"] {
            warned(&format!("{object}, pattern: {pattern}, thickness: 1e-30"), "[coarse]");
        }
        assert!([0, 4].contains(&run(&place, &format!("{object}, intensity: 3e38"), "").0));
        // What lies as near as can be to a point is a point.
        assert!([0, 4].contains(&run(&place, &format!("{object}, size: (1e-30, 1e-30)"), "").0));
        assert_eq!(run(&place, &format!("{object}, thickness: 1e30"), "").0, 0);
    }
    let drawn = "pattern: Drawn([Polyline([(-0.5, 0, 0), (0.5, 0, 0)])])";
    refused(
        &format!("{GRID}, {drawn}, motion: Travelling(velocity: (1e30, 0))"),
        4,
        "too long for this surface",
    );
    refused(&format!("{GRID}, creases: 30000"), 4, "spans in all");
    refused(
        &format!("{GRID}, creases: 1, pattern: Radial, branches: (count: 1, depth: 30000)"),
        4,
        "spans in all",
    );
    refused(&format!("{GRID}, thickness: 1e-6, creases: 1, refine: Auto"), 5, "--max-");
    refused(&format!("{GRID}, thickness: 1e-30, refine: Auto"), 5, "--max-");
    refused(&format!("{GRID}, duration: 1e6, motion: Curtain"), 5, "--max-frames");
    let place = Place::new();
    for forces in [
        "gravity: (0, -1e30, 0)",
        "wind: (1e30, 0, 0), gusts: 1",
        "damping: 1e30",
        "gravity: (0, 0, 0), stiffness: 1",
    ] {
        assert_eq!(run(&place, &format!("{GRID}, motion: Curtain({forces})"), "").0, 0, "{forces}");
    }
    // As many as a grid has rows and more.
    let (code, err) = run(&place, &format!("{GRID}, creases: 1000"), "");
    assert_eq!(code, 0, "{err}");
}

#[test]
fn meshes_without_faces_or_area_are_refused_as_assets() {
    let place = Place::new();
    place.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\n");
    place.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\nf 2 3 4\n");
    place.write("spot.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
    place.write("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n");
    place.write("empty.obj", "# nothing\n");
    for pattern in ["Tangential", "Radial", "Ripple", "Drawn([Polyline([(0, 0, 0), (1, 0, 0)])])"] {
        for refine in ["Off", "Auto"] {
            for (model, word) in [
                ("points.obj", "the surface has no faces"),
                ("line.obj", "the surface has no area"),
                ("spot.obj", "the surface has no area"),
                ("nan.obj", "found \"nan\", expected a finite number"),
                ("empty.obj", "empty.obj"),
            ] {
                let (code, err) = run(&place, &format!("pattern: {pattern}, refine: {refine}"), model);
                assert_eq!(code, 3, "{pattern} {model}: {err}");
                assert!(err.contains(model) && err.contains(word), "{pattern} {model}: {err}");
            }
        }
    }
    refused("object: Points([(0, 0, 0), (1, 0, 0)])", 4, "the surface has no faces");
}

#[test]
fn odd_meshes_are_wrinkled_with_a_word() {
    let place = Place::new();
    place.write("two.obj", "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3\nf 1 3 4\n");
    let (code, err) = run(&place, "creases: 3", "two.obj");
    assert!(code == 0 && err.contains("[coarse]") && err.contains("[no-reach]"), "{err}");
    let (code, err) = run(&place, "creases: 3, refine: Auto", "two.obj");
    assert!(code == 0 && err.contains("where it folds") && !err.contains("warning"), "{err}");
    // Numbers near the ends of f32.
    for (size, name) in [("1e30", "huge.obj"), ("1e-30", "tiny.obj")] {
        place.write(name, format!("v -{size} 0 -{size}\nv -{size} 0 {size}\nv {size} 0 {size}\nv {size} 0 -{size}\nf 1 2 3\nf 1 3 4\n"));
        for units in ["Metres", "Bounds"] {
            for pattern in ["Tangential", "Radial", "Ripple"] {
                for refine in ["Off", "Auto"] {
                    let fields =
                        format!("units: {units}, size: (0.5, 0.5), pattern: {pattern}, refine: {refine}");
                    let (code, err) = run(&place, &fields, name);
                    assert!([0, 4, 5].contains(&code), "{fields} {name}: {err}");
                }
            }
        }
    }
    // One good sheet among faces without area, points without faces, and other shells.
    let (points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [40, 40]);
    let mut text = obj(&points, &faces);
    text += "v 5 5 5\nv 0 0.05 0\nv 0.1 0.05 0\nv 0 0.05 0.1\nf 1 1 2\nf 1 2 2\nf -3 -1 -2\n";
    place.write("odd.obj", text);
    let (code, err) = run(&place, "thickness: 0.16", "odd.obj");
    assert!(code == 0 && err.contains("[apart]"), "{err}");
    place.write("fault.ron", "Wrinkle(thickness: 0.16)");
    place.run("apply fault.ron odd.obj -o strict.obj --at 0 --strict").expect(3);
    assert!(!place.files().contains(&"strict.obj".to_owned()));
}

#[test]
fn what_check_and_render_say_of_them() {
    let place = Place::new();
    place.write("off.ron", format!("Wrinkle({GRID}, center: (0, 3, 0))"));
    place.write("good.ron", format!("Wrinkle({GRID}, thickness: 0.2, refine: Auto)"));
    for line in ["check off.ron", "render off.ron -o out.png --fast --size 32x32", "apply off.ron --dry-run"]
    {
        let err = place.run(line).expect(4).err();
        assert!(err.contains("the center is 3 off the surface"), "{line}: {err}");
    }
    assert!(!place.files().contains(&"out.png".to_owned()));
    assert!(place.run("check good.ron").expect(0).err().contains("good.ron: ok"));
    place.run("render good.ron -o out.png --fast --size 64x48 --wires").expect(0);
    assert!(place.read("out.png").starts_with(b"\x89PNG"));
}
