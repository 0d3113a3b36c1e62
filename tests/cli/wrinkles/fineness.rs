//! How fine a mesh becomes: where creases come to at any moment that is asked for, where a mask lets them, and what is said where it is
//! not enough.

use std::fmt::Write;

use super::{HIGH, WIDE, finer::longest, obj, sheet, triangles};
use crate::place::Place;

#[test]
fn a_moment_after_the_end_is_looked_at_too() {
    let place = Place::new();
    let preset = |intensity: f64| {
        format!(
            "Wrinkle(object: Grid(size: (2, 8), cells: (8, 32)), center: (0, 0, 3), size: (0.8, 0.4), creases: 2, \
             thickness: {WIDE}, intensity: {intensity}, motion: Travelling(velocity: (0, 0.6)), refine: Auto)"
        )
    };
    // It lasts 2 s where nothing says more.
    let (rest, now) = (place.still(&preset(0.0), 8.0), place.still(&preset(HIGH), 8.0));
    assert!(now.iter().any(|p| p.y > 0.9 * HIGH && p.z < -1.0), "they have come far");
    let edge = longest(&rest, &now, &triangles(&place.read("still.obj")));
    assert!(edge <= WIDE / 3.0 * 1.001, "{edge}");
}

#[test]
fn what_a_mask_holds_stays_coarse() {
    let place = Place::new();
    let (points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [16, 16]);
    let mut text = obj(&points, &[]);
    for (material, left) in [("left", true), ("right", false)] {
        writeln!(text, "usemtl {material}").unwrap();
        let side = |face: &&[usize; 3]| (face.iter().map(|v| points[*v].x).sum::<f64>() < 0.0) == left;
        for [a, b, c] in faces.iter().filter(side) {
            writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
        }
    }
    place.write("sheet.obj", text);
    let preset = |only: &str| {
        format!(
            "Wrinkle(size: (1.6, 0.8), creases: 3, thickness: {WIDE}, intensity: {HIGH}, {only}refine: Auto)"
        )
    };
    let (all, _) = place.still_of(&preset(""), "sheet.obj", 0.0);
    let (left, told) = place.still_of(&preset("only: Materials([\"left\"]), "), "sheet.obj", 0.0);
    assert!(left.len() < all.len() * 2 / 3, "{} of {}", left.len(), all.len());
    assert!(!told.contains("[coarse]"), "where nothing moves it need not be fine: {told}");
    let high = |x: f64| left.iter().filter(|p| (p.x - x).abs() < 0.05).map(|p| p.y).fold(0.0, f64::max);
    assert!(high(-0.4) > 0.9 * HIGH && high(0.4) == 0.0, "{} {}", high(-0.4), high(0.4));
    let fine = |x: f64| left.iter().filter(|p| (p.x - x).abs() < 0.2).count();
    assert!(fine(-0.4) > 4 * fine(0.6), "{} {}", fine(-0.4), fine(0.6));
}

#[test]
fn creases_that_come_to_where_it_is_coarse_say_so() {
    let place = Place::new();
    let (mut points, faces) = sheet([-1.0, -1.0], [1.0, 1.0], [80, 80]);
    for p in &mut points {
        // Below 0 every cell is eight times as long.
        p.z = if p.z < 0.0 { 8.0 * p.z } else { p.z };
    }
    place.write("sheet.obj", obj(&points, &faces));
    let preset = format!(
        "Wrinkle(center: (0, 0, 0.6), size: (0.8, 0.2), creases: 1, thickness: {WIDE}, intensity: {HIGH}, \
         motion: Travelling(velocity: (0, 1)))"
    );
    let (_, told) = place.still_of(&preset, "sheet.obj", 0.0);
    assert!(!told.contains("[coarse]"), "{told}");
    let (_, told) = place.still_of(&preset, "sheet.obj", 2.0);
    assert!(told.contains("edges of 0.2") && told.contains("[coarse]"), "{told}");
    assert_eq!(told.matches("[coarse]").count(), 1, "{told}");
}

#[test]
fn what_stays_coarse_in_spite_of_refining_is_said() {
    let place = Place::new();
    let preset = |x: f64| {
        format!(
            "Stack([
                Deform(object: Grid(size: (1, 1), cells: (20, 20)),
                    wires: [Wire(curve: Polyline(points: [(-0.5, 0, -0.5), (-0.5, 0, 0.5)]), radius: 1, density: Linear,
                        pose: [({x}, 0, -0.5), ({x}, 0, 0.5)])]),
                Wrinkle(direction: (0, 0, 1), size: (0.6, 0.6), creases: 3, thickness: 0.08, intensity: 0.02, refine: Auto),
            ])"
        )
    };
    place.write("stack.ron", preset(-0.6));
    let told = place.run("apply stack.ron -o out.glb").expect(0).err();
    assert!(!told.contains("warning"), "{told}");
    place.write("stack.ron", preset(-5.0));
    let told = place.run("apply stack.ron -o out.glb").expect(0).err();
    assert!(told.contains("even on the finer copy edges of 0.") && told.contains("[coarse]"), "{told}");
    let told = place.run("check stack.ron").expect(0).err();
    assert!(!told.contains("[coarse]"), "what is still to be made finer is not coarse: {told}");
}
