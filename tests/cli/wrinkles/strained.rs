//! `drive: Strain`: folds rise where a clip pushes the surface together across them.

use std::collections::HashMap;

use glam::DVec3;

use super::made::{ARM, BENDING, arm};
use crate::oracle;
use crate::place::Place;

const HEIGHT: f64 = 0.012;
/// Half the way round a slender fold on the arm.
const THICK: f64 = 0.03;

/// Creases round the whole arm at its elbow, the first through the top, and what stands them.
fn preset(fields: &str) -> String {
    let round = 0.999 * std::f64::consts::TAU * ARM.0;
    format!(
        "Wrinkle(center: (0, {}, 0), direction: (0, 0, 1), size: ({round}, 0.2), creases: 3, thickness: {THICK}, \
         intensity: {HEIGHT}, drive: Strain, {fields})",
        ARM.0
    )
}

/// A document's own clip as it plays at a time.
fn played(glb: &[u8], seconds: f64) -> Vec<DVec3> {
    let clip = |document: &gltf::Document| document.animations().position(|a| a.name() == Some("bend"));
    oracle::evaluate_clip(glb, clip, seconds, true).swap_remove(0).positions
}

/// How far each vertex stands off where the clip alone has it, frame by frame.
struct Film {
    rest: Vec<DVec3>,
    offsets: Vec<Vec<DVec3>>,
}

fn film(sides: usize, rings: usize, fields: &str, fps: u32) -> Film {
    let place = Place::new();
    place.write("arm.glb", arm(sides, rings).glb());
    place.write("strain.ron", preset(fields));
    place
        .run(&format!("apply strain.ron arm.glb -o out.glb --into bend --fps {fps} --bake frames -q"))
        .expect(0);
    let [old, new] = ["arm.glb", "out.glb"].map(|name| place.read(name));
    let frames = (BENDING.0 * f64::from(fps)).ceil() as u32;
    let offsets = (0..=frames).map(|k| {
        let t = f64::from(k) / f64::from(fps);
        played(&new, t).iter().zip(played(&old, t)).map(|(q, p)| *q - p).collect()
    });
    Film { offsets: offsets.collect(), rest: oracle::evaluate(&old, None, 0.0).swap_remove(0).positions }
}

impl Film {
    /// The largest offset of the vertices that these hold at rest.
    fn largest(&self, frame: usize, holds: impl Fn(DVec3) -> bool) -> f64 {
        let pairs = self.offsets[frame].iter().zip(&self.rest).filter(|(_, p)| holds(**p));
        pairs.map(|(offset, _)| offset.length()).fold(0.0, f64::max)
    }
}

#[test]
fn the_inside_of_an_elbow_wrinkles_and_its_outside_does_not() {
    let film = film(64, 128, "", 24);
    let inside = |p: DVec3| p.y > 0.08;
    let outside = |p: DVec3| p.y < -0.04;
    let most = (0..film.offsets.len()).map(|k| film.largest(k, inside)).fold(0.0, f64::max);
    eprintln!("inside {:.3} of the intensity", most / HEIGHT);
    assert!(most > 0.8 * HEIGHT && most < 1.1 * HEIGHT, "{most}");
    for k in 0..film.offsets.len() {
        assert!(film.largest(k, outside) < 0.02 * HEIGHT, "frame {k}: {}", film.largest(k, outside));
    }
    // They rise when it bends and sink again.
    let last = film.offsets.len() - 1;
    for k in [0, last] {
        assert!(film.largest(k, |_| true) < 0.02 * HEIGHT, "straight at frame {k}");
    }
    // Bent most, where the two joints pull a vertex both ways, the skin flattens what it carries: by cos 50° here.
    assert!(film.largest(last / 2, inside) > 0.6 * HEIGHT, "{}", film.largest(last / 2, inside));
    assert!(film.largest(last / 2, |p| p.x.abs() > 0.25) < 1e-6, "far from the elbow");
}

#[test]
fn folds_rise_and_sink_smoothly() {
    let film = film(48, 80, "", 48);
    let heights: Vec<Vec<f64>> =
        film.offsets.iter().map(|frame| frame.iter().map(|offset| offset.length()).collect()).collect();
    let step =
        |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let steps: Vec<f64> = heights.windows(2).map(step).collect();
    let mut moving: Vec<f64> = steps.iter().copied().filter(|s| *s > 0.01 * HEIGHT).collect();
    moving.sort_by(f64::total_cmp);
    let (median, most) = (moving[moving.len() / 2], moving[moving.len() - 1]);
    eprintln!(
        "steps of {} frames: median {:.4}, most {:.4} of the intensity",
        moving.len(),
        median / HEIGHT,
        most / HEIGHT
    );
    assert!(most < 4.0 * median, "{most} where {median} is usual");
    // Their velocity neither jumps.
    let jerk = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(jerk < 0.5 * most, "{jerk} of {most}");
}

#[test]
fn the_triangles_of_an_arm_do_not_count() {
    let (coarse, fine) = (film(48, 96, "", 8), film(96, 192, "", 8));
    let key = |p: DVec3| (p * 1e4).round().to_array().map(|c| c as i64);
    let mut worst = 0.0_f64;
    for (a, b) in coarse.offsets.iter().zip(&fine.offsets) {
        let at: HashMap<[i64; 3], DVec3> = fine.rest.iter().map(|p| key(*p)).zip(b.iter().copied()).collect();
        let pairs: Vec<f64> =
            coarse.rest.iter().zip(a).filter_map(|(p, q)| Some(at.get(&key(*p))?.distance(*q))).collect();
        assert!(pairs.len() > 4000, "{}", pairs.len());
        worst = pairs.into_iter().fold(worst, f64::max);
    }
    eprintln!("a mesh twice as fine differs by {:.4} of the intensity", worst / HEIGHT);
    assert!(worst < 0.06 * HEIGHT, "{worst}");
}

#[test]
fn creases_along_the_compression_stay_down() {
    let place = Place::new();
    place.write("arm.glb", arm(48, 96).glb());
    // Along the top of the arm: across them nothing pushes.
    let along = format!(
        "Wrinkle(center: (0, {}, 0), direction: (1, 0, 0), size: (0.2, 0.1), creases: 2, thickness: {THICK}, \
         intensity: {HEIGHT}, drive: Strain)",
        ARM.0
    );
    place.write("flat.ron", along);
    place.run("apply flat.ron arm.glb -o out.glb --into bend -q").expect(0);
    let [old, new] = ["arm.glb", "out.glb"].map(|name| place.read(name));
    let off = played(&new, 1.0).iter().zip(played(&old, 1.0)).map(|(q, p)| q.distance(p)).fold(0.0, f64::max);
    assert!(off < 0.35 * HEIGHT, "{off}");
}

#[test]
fn a_still_of_a_driven_wrinkle_and_what_is_said_without_a_clip() {
    let place = Place::new();
    place.write("arm.glb", arm(24, 48).glb());
    place.write("strain.ron", preset(""));
    let mut still = arm(24, 48);
    still.json.as_object_mut().unwrap().remove("animations");
    place.write("still.glb", still.glb());
    let told = place.run("apply strain.ron still.glb -o out.glb").expect(0).err();
    assert!(told.contains("`drive: Strain` needs a model with a clip"), "{told}");
    assert!(place.run("apply strain.ron arm.glb -o no.glb --clip bnd").expect(2).err().contains("bend"));
    assert!(!place.files().contains(&"no.glb".to_owned()));
    // The clip says how long it lasts.
    let told = place.run("apply strain.ron arm.glb -o out.glb --fps 10").expect(0).err();
    assert!(told.contains("21 frames"), "{told}");
    let one = place.run("apply strain.ron arm.glb -o a.glb --fps 10 --threads 1").expect(0);
    place.run("apply strain.ron arm.glb -o b.glb --fps 10 --threads 2").expect(0);
    assert!(
        place.read("a.glb") == place.read("b.glb"),
        "any number of threads, the same bytes: {}",
        one.err()
    );
}

#[test]
fn stills_and_sequences_show_the_pose_and_the_folds() {
    let place = Place::new();
    place.write("arm.glb", arm(48, 96).glb());
    place.write("strain.ron", preset(""));
    place.run("apply strain.ron arm.glb -o out.glb --into bend --fps 4 --bake frames -q").expect(0);
    place.run("apply strain.ron arm.glb -o f####.obj --fps 4 -q").expect(0);
    place.run("apply strain.ron arm.glb -o still.obj --at 0.75 -q").expect(0);
    let shown = played(&place.read("out.glb"), 0.75);
    let frames = ["f0003.obj", "still.obj"].map(|name| super::vertices(&place.read(name)));
    assert_eq!(frames[0], frames[1]);
    let off = shown.iter().zip(&frames[1]).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
    assert!(shown.len() == frames[1].len() && off < 1e-4, "{off}");
    place.run("apply strain.ron arm.glb -o alone####.obj --fps 4 --frames 3..4 -q").expect(0);
    assert!(place.read("alone0003.obj") == place.read("f0003.obj"), "a frame alone is that of the run");
}

#[test]
fn an_effect_before_it_drives_it_too() {
    let place = Place::new();
    // A sheet of 1 m, pushed together by a quarter along x, evenly.
    let preset = "Stack([
        Deform(object: Grid(size: (1, 1), cells: (100, 40)),
            wires: [Wire(curve: Polyline(points: [(-0.5, 0, -0.5), (-0.5, 0, 0.5)]), radius: 1, density: Linear,
                pose: [(-0.5, 0, -0.5), (-0.5, 0, 0.5)])]),
        Wrinkle(direction: (0, 0, 1), size: (0.6, 0.6), creases: 3, thickness: 0.05, intensity: 0.02, drive: Strain),
    ])";
    let flat = place.still(preset, 0.0);
    assert!(flat.iter().all(|p| p.y.abs() < 1e-6), "nothing pushes it together");
    let pushed = preset
        .replace("pose: [(-0.5, 0, -0.5), (-0.5, 0, 0.5)]", "pose: [(-0.25, 0, -0.5), (-0.25, 0, 0.5)]");
    let folded = place.still(&pushed, 0.0);
    let top = folded.iter().map(|p| p.y).fold(0.0, f64::max);
    assert!(top > 0.5 * 0.02 && top < 0.0202, "{top}");
}

#[test]
fn an_effect_that_finds_nothing_keeps_its_number() {
    let place = Place::new();
    let stack = |last: &str| {
        format!(
            "Stack([
                Deform(object: Grid(size: (1, 1), cells: (40, 40)),
                    wires: [Wire(curve: Polyline([(-0.5, 0, 0), (0.5, 0, 0)]), pose: [(-0.5, 0.1, 0), (0.5, 0.1, 0)])]),
                Wrinkle(pattern: Auto, drive: Strain(from: 0.9, to: 1)),
                Wrinkle(center: (0, 0.1, 0), thickness: 0.2, size: (0.5, 0.5), {last}),
            ])"
        )
    };
    place.write("stack.ron", stack("direction: (0, 1, 0)"));
    let told = place.run("apply stack.ron -o out.glb").expect(0).err();
    assert!(
        told.contains("the wrinkle (number 1 of the stack, from 0): nothing is compressed enough"),
        "{told}"
    );
    assert!(
        told.contains("the wrinkle (number 2 of the stack, from 0): `direction` stands upright"),
        "{told}"
    );
    assert!(!told.contains("[no-reach]"), "{told}");
    place.write("stack.ron", stack("pattern: Drawn([Polyline([(0, 9, 0), (0.1, 9, 0)])])"));
    let told = place.run("apply stack.ron -o out.glb").expect(4).err();
    assert!(
        told.contains("effect 2 of the stack (from 0): curve 0") && told.contains("[2].pattern[0]"),
        "{told}"
    );
}

#[test]
fn what_effects_before_it_push_together_settles_in_time() {
    let place = Place::new();
    // Pushed together at once, a second in.
    let preset = |settle: f64| {
        format!(
            "Stack([
                Deform(object: Grid(size: (1, 1), cells: (100, 40)), duration: 2,
                    wires: [Wire(curve: Polyline([(-0.5, 0, -0.5), (-0.5, 0, 0.5)]), radius: 1, density: Linear,
                        pose: Keys([(1, [(-0.5, 0, -0.5), (-0.5, 0, 0.5)]), (1.02, [(-0.25, 0, -0.5), (-0.25, 0, 0.5)])]))]),
                Wrinkle(direction: (0, 0, 1), size: (0.6, 0.6), creases: 3, thickness: 0.05, intensity: 0.02,
                    drive: Strain(settle: {settle})),
            ])"
        )
    };
    let top = |settle, seconds| place.still(&preset(settle), seconds).iter().map(|p| p.y).fold(0.0, f64::max);
    let full = top(0.0, 2.0);
    assert!(top(0.0, 0.9) < 1e-6 && full > 0.01, "at once without it");
    let rising = [0.6, 0.9, 1.01, 1.1, 1.4].map(|seconds| top(0.6, seconds));
    assert!(rising.is_sorted() && rising[0] < 1e-6, "{rising:?}");
    assert!(
        rising[1] > 0.02 * full && rising[1] < 0.9 * full && rising[3] < 0.999 * full,
        "{rising:?} of {full}"
    );
    assert!((rising[4] - full).abs() < 1e-6, "{rising:?} of {full}");
    assert!((top(0.6, 60.0) - full).abs() < 1e-6, "it stays after the end");
    assert!(top(0.6, -3.0) < 1e-6);
    // Whichever frames are asked for.
    place.write("settle.ron", preset(0.6));
    place.run("apply settle.ron -o all####.obj --fps 10 -q").expect(0);
    place.run("apply settle.ron -o one####.obj --fps 10 --frames 9..10 -q").expect(0);
    assert!(place.read("all0009.obj") == place.read("one0009.obj"));
}
