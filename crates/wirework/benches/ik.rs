//! A limb of eight bones over 100 000 vertices: a frame beside a copy of the positions, and the solver alone beside a frame, by turns in
//! one run.
//!
//! `cargo bench -p wirework --bench ik` prints medians in *copies*: the time one thread takes to copy the positions once into memory that
//! it has used before. Frames are worked out on two threads; a frame may take [`MOST`] copies. The solver is a pose and the wire of it, on
//! one thread, and may take one part in [`PARTS`] of a frame.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use wirework::asset::Limits;
use wirework::ik::Limb;
use wirework::preset::{Action, Chain, Goal};
use wirework::{Subject, parse};

/// Frames, of which the median counts.
const FRAMES: usize = 41;

/// Copies that a frame may take.
const MOST: f64 = 40.0;

/// Parts of a frame of which the solver may take one.
const PARTS: f64 = 50.0;

/// Poses in a turn of the solver, which alone are too short for the clock.
const POSES: usize = 8;

/// How many bones there are, each this long.
const BONES: usize = 8;
const BONE: f64 = 0.25;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool of two threads");
    pool.install(|| {
        for (name, fields) in [
            ("rigid", "elasticity: 0"),
            ("elasticity 0.5", "elasticity: 0.5"),
            ("rubber", "elasticity: 1"),
            ("with a pole", "elasticity: 0.5, pole: Keys([(0, (0, 5, 1)), (1, (0, 3, 4))])"),
            ("twist, local scale", "elasticity: 0.5, twist: Keys([(0, 0), (1, 180)]), scale_by: Local"),
            ("limits", "elasticity: 0.5, limits: [60, 30, 30, 30, 30, 30, 30, 30]"),
            ("limits out of reach", "elasticity: 0.5, limits: [5, 5, 5, 5, 5, 5, 5, 5]"),
            (
                "stiffness, pins",
                "elasticity: 0.5, stiffness: [0, 1, 0.5, 0, 0, 1, 0, 0], pins: [(4, (0.9, 0.4, 0))]",
            ),
            ("held tip", "elasticity: 0.5, tip: Hold((0, 0, 30))"),
            ("the paper's curve", "elasticity: 0.5, curve: Chain"),
            ("blended feet", "elasticity: 0.5, closest: Blended(0.05)"),
        ] {
            measure(name, fields);
        }
    });
}

/// A hose along a chain that is a little bent, and a goal that goes through most of what it can reach.
fn preset(fields: &str) -> String {
    let mut joints = String::new();
    for joint in 0..=BONES {
        let x = joint as f64 * BONE;
        let _ = write!(joints, "({x}, {}, 0), ", 0.1 * (x * std::f64::consts::FRAC_PI_2).sin());
    }
    let length = BONES as f64 * BONE;
    format!(
        "Ik(object: Tube(from: (0, 0, 0), to: ({length}, 0, 0), radius: 0.15, sides: 250, rings: 400), chain: Joints([{joints}]),
        goal: Keys([(0, (1.9, 0.2, 0)), (0.4, (0.6, 1.1, 0.4)), (0.7, (0.9, -0.5, 0.8)), (1, (2.4, 0.9, 0.3))]), {fields})"
    )
}

fn measure(name: &str, fields: &str) {
    let text = preset(fields);
    let preset = parse(text.as_bytes(), &wirework::preset::Limits::default()).expect("a preset").preset;
    let Action::Ik(ik) = &preset.effects[0].action else { unreachable!("a limb") };
    let (Chain::Joints(joints), Goal::Point(goal)) = (&ik.chain, &ik.goal) else { unreachable!("points") };
    let subject = Subject::from_preset(&preset, Path::new(""), &Limits::default());
    let subject = subject.expect("a hose").expect("an object");
    let start = Instant::now();
    let mut effect = subject.bind(&preset, Path::new(""), &Limits::default()).expect("a limb");
    let bind = start.elapsed().as_secs_f64();
    let limb = Limb::new(joints, &ik.ik).expect("a chain");
    let mut wire = limb.wire();
    let mut points = subject.points.clone();
    let mut times: [Vec<f64>; 3] = Default::default();
    for frame in 0..=FRAMES {
        let seconds = frame as f64 / FRAMES as f64;
        let start = Instant::now();
        points.copy_from_slice(black_box(&subject.points));
        let copied = Instant::now();
        effect.at(seconds, &mut points).expect("a frame");
        let deformed = Instant::now();
        for _ in 0..POSES {
            let pose = limb.pose(black_box(goal.at(seconds).map(f64::from)), seconds);
            limb.wire_into(&pose, seconds, &mut wire);
            black_box(&wire);
        }
        let solved = deformed.elapsed().as_secs_f64() / POSES as f64;
        black_box(&points);
        // The first frame finds its memory.
        if frame > 0 {
            let round = [(copied - start).as_secs_f64(), (deformed - copied).as_secs_f64(), solved];
            times.iter_mut().zip(round).for_each(|(all, time)| all.push(time));
        }
    }
    let most = times[2].iter().copied().fold(0.0, f64::max);
    let [copy, frame, solver] = times.map(median);
    let judge = |kept: bool| if kept { "" } else { " (TOO MANY)" };
    println!(
        "{name}: {} points, a copy {:.4} ms; bound in {:.0} copies; a frame {:.1} copies{}, {:.3} ms; the solver one part in {:.0}{}, \
         {:.1} µs, at most {:.1} µs",
        points.len(),
        copy * 1e3,
        bind / copy,
        frame / copy,
        judge(frame <= MOST * copy),
        frame * 1e3,
        frame / solver,
        judge(solver * PARTS <= frame),
        solver * 1e6,
        most * 1e6
    );
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
