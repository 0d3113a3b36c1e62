//! Key poses and bases play a motion within the tolerance at any time, as another evaluation plays them.

use glam::DVec3;
use proptest::prelude::*;
use wirework_asset::{Gltf, NewMesh, Rest};
use wirework_bake::{Bake, BakeError, Baked, Frame, Moments, Settings, bake};

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;
use common::{ASSETS, instances, shared};

#[path = "../../asset/tests/oracle/mod.rs"]
#[expect(dead_code, reason = "each test file uses its own part")]
mod oracle;

/// Where a vertex at rest is at a time.
type Motion = dyn Fn(DVec3, f64) -> DVec3;

/// A motion of a scene.
struct Scene<'a> {
    rest: &'a Rest,
    motion: &'a Motion,
    positions: Vec<[f32; 3]>,
    looks: usize,
}

impl<'a> Scene<'a> {
    fn new(rest: &'a Rest, motion: &'a Motion) -> Self {
        Self { rest, motion, positions: rest.positions.clone(), looks: 0 }
    }
}

impl Moments for Scene<'_> {
    type Error = BakeError;

    fn at(&mut self, seconds: f64) -> Result<Frame<'_>, BakeError> {
        self.looks += 1;
        for (p, rest) in self.positions.iter_mut().zip(&self.rest.positions) {
            let rest = DVec3::from_array(rest.map(f64::from));
            *p = (self.motion)(rest, seconds).to_array().map(|c| c as f32);
        }
        Ok(Frame { moment: self.rest, positions: &self.positions, normals: None, tangents: None })
    }

    fn progress(&mut self, done: usize, all: usize) {
        assert!(done <= all);
    }
}

/// A sheet of 1 m, without normals.
fn sheet(cells: usize) -> Gltf {
    let side = cells + 1;
    let at = |k: usize| (k as f32 / cells as f32) - 0.5;
    let positions: Vec<[f32; 3]> = (0..side * side).map(|i| [at(i % side), 0.0, at(i / side)]).collect();
    let corner = |i: usize, j: usize| (j * side + i) as u32;
    let cell = |k: usize| {
        let (i, j) = (k % cells, k / cells);
        [
            [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1)],
            [corner(i, j), corner(i + 1, j + 1), corner(i + 1, j)],
        ]
    };
    let triangles: Vec<[u32; 3]> = (0..cells * cells).flat_map(cell).collect();
    let mesh =
        NewMesh { name: "sheet", positions: &positions, normals: None, uvs: None, triangles: &triangles };
    Gltf::from_meshes("sheet", &[mesh]).unwrap()
}

fn frames(count: usize) -> Vec<f64> {
    (0..=count).map(|k| k as f64 / 24.0).collect()
}

fn baked(
    gltf: Gltf,
    rest: &Rest,
    settings: Settings,
    times: &[f64],
    motion: &Motion,
) -> Result<Baked, BakeError> {
    bake(gltf, rest, settings, times, &mut Scene::new(rest, motion))
}

/// How far a vertex is off at most, in parts of the diagonal, at many times that are no frames; and whether all weights are 0 ..= 1.
fn off(out: &Baked, rest: &Rest, seconds: f64, motion: &Motion) -> f64 {
    let glb = out.gltf.to_glb().unwrap();
    let mut most = 0.0_f64;
    for k in 0..=60 {
        let time = (f64::from(k) * 0.618_034).fract() * seconds;
        let shown = oracle::evaluate(&glb, Some("wirework"), time as f32);
        let diagonal = oracle::diagonal(&oracle::evaluate(&glb, None, 0.0));
        for (part, shown) in rest.parts.iter().zip(&shown) {
            let block = &rest.blocks[part.block];
            for (v, played) in shown.positions.iter().enumerate() {
                let start = DVec3::from_array(rest.positions[block.first + v].map(f64::from));
                most = most.max(played.distance(motion(start, time)) / diagonal);
            }
        }
    }
    most
}

/// All weights that our clip has, target by target.
fn weights(out: &Baked) -> Vec<Vec<f32>> {
    let glb = out.gltf.to_glb().unwrap();
    let document = gltf::Gltf::from_slice(&glb).unwrap();
    let clip = document.animations().last().unwrap();
    let channel = clip.channels().next().unwrap();
    let reader = channel.reader(|_| document.blob.as_deref());
    let keys = reader.read_inputs().unwrap().count();
    let Some(gltf::animation::util::ReadOutputs::MorphTargetWeights(list)) = reader.read_outputs() else {
        panic!()
    };
    let all: Vec<f32> = list.into_f32().collect();
    let count = all.len() / keys;
    (0..count).map(|target| all.iter().skip(target).step_by(count).copied().collect()).collect()
}

#[test]
fn a_travelling_sine_is_two_shapes_and_the_one_that_is_always_there() {
    let gltf = sheet(32);
    let rest = gltf.rest().unwrap();
    let wave = |p: DVec3, t: f64| p + DVec3::Y * 0.05 * (12.0 * p.x - 5.0 * t).sin();
    let out = baked(gltf, &rest, Settings::default(), &frames(48), &wave).unwrap();
    let played = out.played.as_ref().unwrap();
    assert_eq!((out.targets, played.nodes[0].bake), (3, Bake::Basis));
    let off = off(&out, &rest, 2.0, &wave);
    assert!(off <= 1e-4 && off < 1.1 * played.of_diagonal, "{off} {}", played.of_diagonal);
    let weights = weights(&out);
    assert!(weights.iter().flatten().all(|w| (0.0..=1.0).contains(w)));
    assert!(weights[2].iter().all(|w| *w == 1.0), "{:?}", weights[2]);
    let names = &out.gltf.json()["meshes"][0]["extras"]["targetNames"];
    assert_eq!(*names, serde_json::json!(["wirework_b00", "wirework_b01", "wirework_offset"]));
}

#[test]
fn one_shape_that_comes_and_goes_is_one_target() {
    let gltf = sheet(16);
    let rest = gltf.rest().unwrap();
    let bump = |p: DVec3, t: f64| {
        p + DVec3::new(0.1, 0.3, 0.0) * (-8.0 * p.length_squared()).exp() * (3.0 * t).sin().max(0.0)
    };
    let out = baked(gltf, &rest, Settings::default(), &frames(60), &bump).unwrap();
    assert_eq!(out.targets, 1);
    let off = off(&out, &rest, 2.5, &bump);
    assert!(off <= 1e-4, "{off}");
}

#[test]
fn what_rests_is_exact() {
    let gltf = sheet(16);
    let rest = gltf.rest().unwrap();
    // Both ways from the rest, and at rest in between for a while.
    let bump = |p: DVec3, t: f64| {
        let wave = (7.0 * p.x + 4.0 * t).sin() * 0.1;
        if (0.5..=1.0).contains(&t) { p } else { p + DVec3::Y * wave * (t - 0.5).abs().min((t - 1.0).abs()) }
    };
    for how in [Bake::Keys, Bake::Basis] {
        let settings = Settings { bake: how, ..Settings::default() };
        let out = baked(gltf.clone(), &rest, settings, &frames(36), &bump).unwrap();
        let off = off(&out, &rest, 1.5, &bump);
        assert!(off <= 1e-4, "{how:?} {off}");
        let glb = out.gltf.to_glb().unwrap();
        for k in 12..=24 {
            let shown = oracle::evaluate(&glb, Some("wirework"), k as f32 / 24.0);
            for (played, rest) in shown[0].positions.iter().zip(&rest.positions) {
                assert!(played.distance(DVec3::from_array(rest.map(f64::from))) < 1e-7, "{how:?} {k}");
            }
        }
    }
}

#[test]
fn straight_ways_need_their_ends_alone() {
    let gltf = sheet(8);
    let rest = gltf.rest().unwrap();
    let ramp = |p: DVec3, t: f64| p + DVec3::Y * p.x * t.min(1.0);
    let mut scene = Scene::new(&rest, &ramp);
    let settings = Settings { bake: Bake::Keys, ..Settings::default() };
    let out = bake(gltf, &rest, settings, &frames(48), &mut scene).unwrap();
    let played = out.played.unwrap();
    assert_eq!((out.targets, played.nodes[0].keys, played.samples), (1, 3, 49));
    assert!(scene.looks < 49 + 48 + 10, "{}", scene.looks);
}

#[test]
fn a_jump_takes_no_time_to_speak_of_and_what_cannot_be_followed_is_told() {
    let gltf = sheet(8);
    let rest = gltf.rest().unwrap();
    let jump = |p: DVec3, t: f64| if t < 0.51 { p } else { p + DVec3::Y * 0.5 };
    let out = baked(gltf.clone(), &rest, Settings::default(), &frames(24), &jump).unwrap();
    let glb = out.gltf.to_glb().unwrap();
    // A thousandth of a frame, on either side of the jump.
    for (time, lift) in [(0.5098, 0.0), (0.5102, 0.5)] {
        let shown = oracle::evaluate(&glb, Some("wirework"), time);
        assert!((shown[0].positions[0].y - lift).abs() < 1e-4, "{time}: {}", shown[0].positions[0].y);
    }
    let samples = out.played.as_ref().unwrap().samples;
    assert!(samples < 40, "{samples}");
    let told = |out: &Baked| out.gltf.warnings().iter().any(|warning| warning.code == "tolerance");
    assert!(!told(&out));
    // Thousands of times faster than frames.
    let noise = |p: DVec3, t: f64| p + DVec3::Y * (1e5 * t).sin();
    let out = baked(gltf, &rest, Settings::default(), &frames(24), &noise).unwrap();
    assert!(told(&out) && out.played.unwrap().of_diagonal > 1e-2);
}

/// The number that a message gives for a flag.
fn number(message: &str, flag: &str) -> f64 {
    let (_, rest) = message.split_once(flag).unwrap();
    rest.trim_start_matches(' ').split('`').next().unwrap().parse().unwrap()
}

#[test]
fn what_several_meshes_need_is_told_at_once() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let middle = rest.positions.iter().map(|p| f64::from(p[0])).sum::<f64>() / rest.positions.len() as f64;
    // Of what lies farther along x more shapes.
    let motion = move |p: DVec3, t: f64| {
        let way = if p.x > middle { (9.0 * p.x - 9.0 * t).sin().powi(5) } else { (3.0 * t + p.z).sin() };
        p + DVec3::Y * 0.3 * way
    };
    let settings = |max_targets| Settings { max_targets, ..Settings::default() };
    let message = baked(gltf.clone(), &rest, settings(1), &frames(24), &motion).unwrap_err().to_string();
    let targets = number(&message, "--max-targets") as usize;
    assert!(baked(gltf.clone(), &rest, settings(targets), &frames(24), &motion).is_ok(), "{message}");
    assert!(baked(gltf, &rest, settings(targets - 1), &frames(24), &motion).is_err(), "{message}");
}

#[test]
fn a_tolerance_finer_than_floats_is_not_said_to_be_kept() {
    let gltf = sheet(8);
    let rest = gltf.rest().unwrap();
    let far = |p: DVec3, t: f64| p + DVec3::Y * 1000.0 * (t * (1.0 + p.x)).sin();
    for how in [Bake::Auto, Bake::Basis] {
        let settings = Settings { bake: how, tolerance: 1e-12, max_targets: 8, ..Settings::default() };
        let message = baked(gltf.clone(), &rest, settings, &frames(24), &far).unwrap_err().to_string();
        assert!(!message.contains("basis of") && !message.contains("--max-targets 0"), "{message}");
    }
}

#[test]
fn what_has_no_extent_is_measured_in_metres() {
    let point = [[0.5, 0.0, 0.0]; 3];
    let mesh =
        NewMesh { name: "point", positions: &point, normals: None, uvs: None, triangles: &[[0, 1, 2]] };
    let gltf = Gltf::from_meshes("point", &[mesh]).unwrap();
    let rest = gltf.rest().unwrap();
    let up = |p: DVec3, t: f64| p + DVec3::Y * t * t;
    let out = baked(gltf, &rest, Settings::default(), &frames(24), &up).unwrap();
    assert!(out.targets <= 2 && out.played.unwrap().of_diagonal <= 1e-4);
}

#[test]
fn what_does_not_fit_says_what_would() {
    let gltf = sheet(24);
    let rest = gltf.rest().unwrap();
    let peak = |p: DVec3, t: f64| p + DVec3::Y * 0.2 * (-200.0 * (p.x + 0.5 - t).powi(2)).exp();
    let settings = |max_targets, tolerance| Settings { max_targets, tolerance, ..Settings::default() };
    let fits = baked(gltf.clone(), &rest, settings(240, 1e-4), &frames(24), &peak).unwrap();
    assert!(fits.targets > 8, "{}", fits.targets);
    // As many as it needs are enough.
    let again = baked(gltf.clone(), &rest, settings(fits.targets, 1e-4), &frames(24), &peak).unwrap();
    assert_eq!(again.targets, fits.targets);
    // A tolerance at which nothing would move is no remedy.
    for room in [1, 2] {
        let short = baked(gltf.clone(), &rest, settings(room, 1e-4), &frames(24), &peak).unwrap_err();
        let message = short.to_string();
        assert!(message.contains("--max-targets") && !message.contains("--tolerance"), "{message}");
    }
    for room in [12, 18, fits.targets - 1] {
        let short = baked(gltf.clone(), &rest, settings(room, 1e-4), &frames(24), &peak).unwrap_err();
        let message = short.to_string();
        let BakeError::Tolerance { room: own_room, own: 0, remedy, .. } = short else { panic!("{message}") };
        assert_eq!(own_room, room);
        assert!(message.contains("\"sheet\" needs") && message.contains("a basis of"), "{message}");
        // What the message says is true.
        let (tolerance, targets) = (number(&remedy, "--tolerance"), number(&remedy, "--max-targets"));
        assert_eq!(targets, fits.targets as f64, "{message}");
        let relaxed = baked(gltf.clone(), &rest, settings(room, tolerance), &frames(24), &peak);
        assert!(relaxed.is_ok_and(|relaxed| (1..=room).contains(&relaxed.targets)), "{message}");
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = baked(gltf.clone(), &rest, settings(6, bad), &frames(24), &peak);
        assert!(matches!(refused, Err(BakeError::NoTolerance(_))), "{bad}");
    }
    let refused = baked(gltf, &rest, settings(6, 1e-4), &[0.5, 0.5], &peak);
    assert!(matches!(refused, Err(BakeError::Frame { frame: 1, .. })));
}

#[test]
fn frames_at_rest_are_exact_however_slowly_it_comes_to_rest() {
    let gltf = sheet(12);
    let rest = gltf.rest().unwrap();
    let motion = |p: DVec3, t: f64| {
        p + DVec3::new(0.02 * p.z, 0.05 * (3.0 * p.x).cos(), 0.0) * (0.8 - t).max(0.0).powi(3)
    };
    for tolerance in [1e-4, 1e-2] {
        let settings = Settings { bake: Bake::Basis, tolerance, ..Settings::default() };
        let out = baked(gltf.clone(), &rest, settings, &frames(30), &motion).unwrap();
        let glb = out.gltf.to_glb().unwrap();
        for frame in 20..=30 {
            let shown = oracle::evaluate(&glb, Some("wirework"), (f64::from(frame) / 24.0) as f32);
            for (a, b) in shown[0].positions.iter().zip(&rest.positions) {
                let off = a.distance(DVec3::from_array(b.map(f64::from)));
                assert!(off < 1e-6, "{tolerance} at frame {frame}: {off}");
            }
        }
        assert!(off(&out, &rest, 1.25, &motion) <= out.played.unwrap().of_diagonal + 1e-6);
    }
}

#[test]
fn nodes_with_transforms_are_within_the_tolerance_in_the_world() {
    let gltf = instances();
    let rest = gltf.rest().unwrap();
    let swing = |p: DVec3, t: f64| p + DVec3::new(p.y, p.z, -p.x) * 0.3 * (6.0 * t + p.x).sin();
    for how in [Bake::Keys, Bake::Basis] {
        let settings = Settings { bake: how, tolerance: 1e-3, ..Settings::default() };
        let out = baked(gltf.clone(), &rest, settings, &frames(24), &swing).unwrap();
        let off = off(&out, &rest, 1.0, &swing);
        assert!(off <= 1e-3, "{how:?} {off}");
    }
}

#[test]
fn real_files_play_within_the_tolerance() {
    for name in ASSETS {
        let Some(path) = shared(name) else { return };
        let gltf = Gltf::read(&path, &wirework_asset::Limits::default()).unwrap();
        let rest = gltf.rest().unwrap();
        let ends = rest.positions.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], p| {
            let p = DVec3::from_array(p.map(f64::from));
            [a.min(p), b.max(p)]
        });
        let (low, size) = (ends[0], ends[0].distance(ends[1]));
        let bow = move |p: DVec3, t: f64| {
            p + DVec3::X * 0.1 * size * (2.0 * t).sin() * ((p - low).y / size * 3.0 + t).cos()
        };
        let settings = Settings { tolerance: 5e-4, ..Settings::default() };
        let out = baked(gltf, &rest, settings, &frames(18), &bow).unwrap();
        let off = off(&out, &rest, 0.75, &bow);
        assert!(off <= 5e-4, "{name}: {off}");
        assert!(out.targets <= 8 * out.nodes.max(1), "{name}: {}", out.targets);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// Sums of shapes that come and go at different times, with corners.
    #[test]
    fn any_motion_is_within_its_tolerance(
        numbers in prop::collection::vec(-1.0_f64..1.0, 24),
        exponent in 2.5_f64..4.5,
        keys in any::<bool>(),
    ) {
        let gltf = sheet(10);
        let rest = gltf.rest().unwrap();
        let motion = move |p: DVec3, t: f64| {
            let mut out = p;
            for n in numbers.chunks(6) {
                let place = DVec3::new(n[0], 0.0, n[1]) * 0.5;
                let shape = (-6.0 * p.distance_squared(place)).exp();
                let way = if n[5] > 0.0 { ((t - n[2].abs()) * 4.0 * n[3]).sin() } else { (t - n[2].abs()).abs() * n[3] };
                out += DVec3::new(n[4], n[3], n[5]) * 0.2 * shape * way;
            }
            out
        };
        let tolerance = 10.0_f64.powf(-exponent);
        let bake = if keys { Bake::Keys } else { Bake::Auto };
        let settings = Settings { bake, tolerance, max_targets: 2000, ..Settings::default() };
        let out = baked(gltf, &rest, settings, &frames(24), &motion).unwrap();
        let off = off(&out, &rest, 1.0, &motion);
        prop_assert!(off <= 1.1 * tolerance + 1e-6, "{off} of {tolerance}, {} targets", out.targets);
    }
}
