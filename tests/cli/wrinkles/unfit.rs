//! Effects that do not fit their object are shown at their place in the preset.

use super::{obj, sheet};
use crate::place::Place;

const GRID: &str = "object: Grid(size: (2, 2), cells: (40, 40))";

/// Runs a preset with every command and on a model, and looks for the error at the mark `«`.
#[track_caller]
fn at(preset: &str, path: &str, why: &str) {
    let place = Place::new();
    let mark = preset.find('«').expect("a mark");
    let line = 1 + preset[..mark].matches('\n').count();
    let column = 1 + preset[..mark].rsplit('\n').next().unwrap().chars().count();
    let (points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [40, 40]);
    place.write("sheet.obj", obj(&points, &faces));
    place.write("bad.ron", preset.replace('«', ""));
    for (command, words) in [
        ("check bad.ron", "the effect does not fit the preset's object: "),
        ("apply bad.ron -o out.glb", "the effect does not fit the preset's object: "),
        ("render bad.ron -o out.png --fast --size 32x32", "the effect does not fit the preset's object: "),
        ("apply bad.ron sheet.obj -o out.glb", "sheet.obj: the effect cannot be applied: "),
        ("check bad.ron --on sheet.obj", "sheet.obj: the effect cannot be applied: "),
    ] {
        // `check` looks at 0 s only.
        if command.starts_with("check") && preset.contains("Travelling") {
            continue;
        }
        let err = place.run(command).expect(4).err();
        assert!(err.contains(&format!("{words}{why}")), "{command}: {err}");
        assert!(err.contains(&format!("bad.ron:{line}:{column}\n")), "{command}: {line}:{column} in {err}");
        let label = if path.is_empty() { "^".to_owned() } else { format!("^ at {path}") };
        assert!(err.contains(&label), "{command}: no {label:?} in {err}");
    }
    assert_eq!(place.files(), ["bad.ron", "lift.ron", "sheet.obj"], "nothing is written");
}

#[test]
fn the_field_that_does_not_fit_is_shown() {
    at(
        &format!("Wrinkle(\n    {GRID},\n    creases: 3, center: «(0, 3, 0),\n)"),
        "center",
        "the center is 3 off the surface",
    );
    at(
        &format!("\u{feff}Wrinkle({GRID}, creases: 1, pattern: Ripple,\n  size: «(90, 90))"),
        "size",
        "no crease of the pattern",
    );
    at(
        &format!(
            "Wrinkle({GRID}, pattern: Drawn([\n Polyline([(0, 0, 0), (1, 0, 0)]),\n «Polyline([(0, 9, 0), (1, 9, 0)])]))"
        ),
        "pattern[1]",
        "curve 1 is 1 long but nowhere nearer",
    );
    at(&format!("Wrinkle({GRID},\n    motion: «Travelling(velocity: (1e30, 0)))"), "motion", "5 lines of");
    at(&format!("Wrinkle({GRID}, size: «(1e30, 1e30), refine: Auto)"), "size", "5 lines of");
    at(&format!("Wrinkle({GRID}, thickness: «0.0001, creases: 3000)"), "thickness", "creases of thickness");
}

#[test]
fn a_field_that_is_not_there_is_missed_at_the_effect() {
    let preset = format!("Wrinkle({GRID}, units: Metres, pattern: Auto, drive: Strain)");
    at(&preset.replace("pattern: Auto", "pattern: «Auto"), "pattern", "`pattern: Auto` looks for");
    // The default center lies 3 below.
    let away = "Stack([\n    Deform(object: Grid(size: (2, 2), cells: (8, 8)), wires: [\n        Wire(curve: \
                Polyline([(-1, 0, 0), (1, 0, 0)]), pose: [(-1, 3, 0), (1, 3, 0)], radius: 1e6)]),\n    \
                «Wrinkle(),\n])";
    at(away, "[1]", "effect 1 of the stack (from 0): the center is");
}

#[test]
fn the_effect_of_a_stack_is_named() {
    let deform = "Deform(object: Grid(size: (2, 2), cells: (40, 40)), wires: [Wire(curve: Polyline([(-1, 0, 0), (1, 0, 0)]))])";
    at(
        &format!("Stack([\n    {deform},\n    Stack([Wrinkle(center: «(0, 3, 0))]),\n])"),
        "[1][0].center",
        "effect 1 of the stack (from 0): the center is 3 off",
    );
}

#[test]
fn an_object_that_no_effect_fits_is_the_assets_fault_or_its_presets() {
    let place = Place::new();
    place.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\n");
    place.write("bad.ron", "Wrinkle(object: Points([(0, 0, 0), (1, 0, 0)]))");
    let err = place.run("apply bad.ron points.obj -o out.glb").expect(3).err();
    assert!(err.contains("points.obj: the effect cannot be applied") && !err.contains("bad.ron:1"), "{err}");
    let err = place.run("apply bad.ron -o out.glb").expect(4).err();
    assert!(err.contains("the surface has no faces") && err.contains("bad.ron:1:1\n"), "{err}");
    place.write("bad.ron", "Deform(object: Points([(1, 0, 0), (1, 0, 0)]),\n units: Bounds, wires: [Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), scale: 2)])");
    let err = place.run("apply bad.ron -o out.glb").expect(4).err();
    assert!(
        err.contains("`units: Bounds` needs an object with an extent") && err.contains("bad.ron:2:9\n"),
        "{err}"
    );
    place.write("spot.obj", "v 1 0 0\nv 1 0 0\n");
    place.run("apply bad.ron spot.obj -o out.glb").expect(3);
}
