//! What holds of any limb: what hangs on it follows a goal without jumps, whatever its settings.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};
use wirework_core::Keyed;
use wirework_ik::{ChainCurve, Ik, Limb, ScaleBy};

/// Frames of a path.
const FRAMES: usize = 240;

/// Steps of a path in a frame, from which the frames are taken at one speed.
const FINE: usize = 40;

/// The plane of a bend turns without end where the goal passes opposite the rest, and a limb folded onto its root has none; paths keep off both.
const OFF: f64 = 5.0 * PI / 180.0;

/// Paths that are followed, and their seed: what is said of shares below is of these, so they are always the same.
const PATHS: usize = 600;
const SEED: u64 = 1;

/// A step of more medians than these is looked at closely.
const FEW: f64 = 4.0;

/// How often a step is halved, until it is no larger than the median of them all.
const HALVES: usize = 20;

/// The greatest step of a path over the median step: of half the paths, of 9 and of 99 in 100. What is large comes of paths that pass near
/// opposite the rest, where the plane of the bend turns with the inverse of the sine, and of bones that nearly fold onto the one before.
const SHARES: [(f64, f64); 3] = [(0.5, 2.5), (0.9, 6.0), (0.99, 15.0)];

#[derive(Clone, Debug)]
struct Case {
    joints: Vec<[f32; 3]>,
    settings: Ik,
    path: Vec<DVec3>,
}

fn double(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

fn length(path: &[DVec3]) -> f64 {
    path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// A smooth path about the root, at one speed, from a tenth of the length of the limb to twice and a half of it.
fn path(total: f64, w: &[f64]) -> Vec<DVec3> {
    let at = |t: f64| {
        let wave = |k: usize| w[k] + w[k + 1] * (TAU * (t * (0.5 + w[k + 2].abs()) + w[k + 3])).sin();
        let direction = DVec3::new(wave(0), wave(4), wave(8)).normalize_or(DVec3::X);
        direction * total * (0.75 + 0.6 * w[12] * (TAU * (t + w[13])).sin()).clamp(0.1, 2.5)
    };
    let steps = FRAMES * FINE;
    let fine: Vec<DVec3> = (0..=steps).map(|i| at(i as f64 / steps as f64)).collect();
    let (whole, mut gone, mut out) = (length(&fine), 0.0, vec![fine[0]]);
    for pair in fine.windows(2) {
        gone += pair[0].distance(pair[1]);
        if gone >= whole * out.len() as f64 / FRAMES as f64 {
            out.push(pair[1]);
        }
    }
    out
}

fn case() -> impl Strategy<Value = Case> {
    let chain = (2_usize..9, prop::collection::vec(-1.0_f32..1.0, 24), 0.0_f32..2.0);
    let numbers = prop::collection::vec(0.0_f32..=1.0, 20);
    let kinds = prop::collection::vec(any::<bool>(), 5);
    (chain, prop::collection::vec(-1.0_f64..1.0, 14), numbers, kinds).prop_map(
        |((bones, noise, bend), w, numbers, kinds)| {
            let mut joints = vec![[0.0; 3]];
            for i in 0..bones {
                let ([x, y, z], n) = (joints[i], |k: usize| noise[(3 * i + k) % noise.len()]);
                joints.push([x + 0.4 + 0.3 * n(0).abs(), y + bend * n(1) * 0.5, z + bend * n(2) * 0.2]);
            }
            let settings = Ik {
                elasticity: Keyed::Constant(numbers[0]),
                stiffness: if kinds[0] { numbers[1..=bones].to_vec() } else { Vec::new() },
                limits: if kinds[1] {
                    numbers[9..9 + bones].iter().map(|n| 0.2 + 2.0 * n).collect()
                } else {
                    Vec::new()
                },
                max_stretch: 1.0 + numbers[17] * 2.0,
                min_stretch: 0.5 * numbers[18],
                softness: numbers[19],
                curve: if kinds[2] { ChainCurve::Chain } else { ChainCurve::Rounded(0.25) },
                scale_by: if kinds[3] { ScaleBy::Local } else { ScaleBy::Length },
                twist: Keyed::Constant(if kinds[4] { 10.0 } else { 0.0 }),
                ..Ik::default()
            };
            let total = length(&joints.iter().map(|p| double(*p)).collect::<Vec<_>>());
            Case { path: path(total, &w), joints, settings }
        },
    )
}

/// Joints, and points at a tenth of the length from the curve, where the goal is.
fn places(limb: &Limb, goal: DVec3) -> Vec<DVec3> {
    let rest = DVec3::from_array(limb.tip());
    let across = rest.any_orthonormal_vector() * rest.length() * 0.1;
    let mut wire = limb.wire();
    let pose = limb.pose(goal.to_array(), 0.0);
    limb.wire_into(&pose, 0.0, &mut wire);
    let stations = wire.stations(&[0.0, 0.27, 0.5, 0.81, 1.0]);
    let points = stations.iter().map(|station| {
        DVec3::from_array(station.to) + DQuat::from_array(station.rotation) * across * station.scale
    });
    pose.joints().map(DVec3::from_array).chain(points).collect()
}

/// Up to which distance bones of which one is longer than all others are folded flat onto it, and may step from side to side.
fn folded_flat(joints: &[[f32; 3]]) -> f64 {
    let lengths: Vec<f64> = joints.windows(2).map(|pair| double(pair[0]).distance(double(pair[1]))).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    2.0 * longest - lengths.iter().sum::<f64>()
}

/// How far what went farthest went.
fn step(pair: &[Vec<DVec3>]) -> f64 {
    pair[0].iter().zip(&pair[1]).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// What is left of the step between two goals when the half of the way with more of it has been taken again and again, up to where it
/// is `small`.
fn halved(limb: &Limb, mut goals: [DVec3; 2], small: f64) -> f64 {
    let mut ends = goals.map(|goal| places(limb, goal));
    for _ in 0..HALVES {
        if step(&ends) <= small {
            break;
        }
        let goal = goals[0].midpoint(goals[1]);
        let [a, b] = ends;
        let middle = places(limb, goal);
        let halves = [[a, middle.clone()], [middle, b]];
        let second = step(&halves[1]) > step(&halves[0]);
        goals[usize::from(!second)] = goal;
        let [first, last] = halves;
        ends = if second { last } else { first };
    }
    step(&ends)
}

#[test]
fn nothing_jumps() {
    let config = ProptestConfig { rng_seed: RngSeed::Fixed(SEED), ..ProptestConfig::default() };
    let mut runner = TestRunner::new(config);
    let mut ratios = Vec::new();
    while ratios.len() < PATHS {
        let mut case = case().new_tree(&mut runner).unwrap().current();
        // Cones that cannot be kept leave two ways round, and a limb steps from the one to the other.
        case.settings.limits.clear();
        let limb = Limb::new(&case.joints, &case.settings).unwrap();
        let rest = DVec3::from_array(limb.tip());
        if case.path.iter().any(|goal| goal.angle_between(-rest) < OFF) {
            continue;
        }
        let frames: Vec<Vec<DVec3>> = case.path.iter().map(|goal| places(&limb, *goal)).collect();
        assert!(frames.iter().flatten().all(|point| point.is_finite()), "{case:?}");
        let steps: Vec<f64> = frames.windows(2).map(step).collect();
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let (median, most) = (sorted[steps.len() / 2], sorted[steps.len() - 1]);
        let folded = folded_flat(&case.joints);
        for (step, goals) in steps.iter().zip(case.path.windows(2)) {
            let is_folded = goals.iter().any(|goal| goal.length() <= folded);
            if *step > FEW * median && !is_folded {
                let left = halved(&limb, [goals[0], goals[1]], median);
                assert!(left <= median, "{left} of {step}, median {median}, at {goals:?} of {case:?}");
            }
        }
        ratios.push(most / median);
    }
    ratios.sort_by(f64::total_cmp);
    for (part, most) in SHARES {
        let ratio = ratios[((PATHS - 1) as f64 * part) as usize];
        assert!(ratio < most, "{ratio} at {part}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn limbs_are_where_they_may_be(case in case()) {
        let limb = Limb::new(&case.joints, &case.settings).unwrap();
        let rest: Vec<DVec3> = limb.joints().map(DVec3::from_array).collect();
        let (total, most) = (length(&rest), f64::from(case.settings.max_stretch));
        let stiff = !case.settings.stiffness.is_empty();
        for goal in case.path.iter().step_by(16) {
            let joints: Vec<DVec3> = limb.pose(goal.to_array(), 0.0).joints().map(DVec3::from_array).collect();
            prop_assert!(joints.iter().all(|joint| joint.is_finite()) && joints[0] == DVec3::ZERO);
            // Bones that keep their length make others longer.
            prop_assert!(stiff || length(&joints) < (most + 1e-6) * total);
            let mut frame = DQuat::IDENTITY;
            for (i, limit) in case.settings.limits.iter().enumerate() {
                let (axis, bone) = (frame * (rest[i + 1] - rest[i]), joints[i + 1] - joints[i]);
                let angle = axis.angle_between(bone);
                prop_assert!(angle < f64::from(*limit) + 1e-3, "joint {i}: {angle} of {limit}");
                frame = DQuat::from_rotation_arc(axis.normalize(), bone.normalize()) * frame;
            }
        }
    }

    #[test]
    fn limbs_turn_with_the_world(case in case(), turn in prop::array::uniform3(-3.0_f64..3.0)) {
        // Straight chains bend towards an axis of the world.
        let turn = DQuat::from_scaled_axis(DVec3::from_array(turn));
        let mut joints = case.joints.clone();
        joints[1][1] += 0.2;
        let turned: Vec<[f32; 3]> = joints.iter().map(|p| (turn * double(*p)).as_vec3().to_array()).collect();
        let settings = Ik { limits: Vec::new(), ..case.settings };
        let limbs = [&joints, &turned].map(|joints| Limb::new(joints, &settings).unwrap());
        let rest = DVec3::from_array(limbs[0].tip());
        for goal in case.path.iter().step_by(24).filter(|goal| goal.angle_between(-rest) > OFF) {
            let [a, b] = [(&limbs[0], *goal), (&limbs[1], turn * *goal)]
                .map(|(limb, goal)| limb.pose(goal.to_array(), 0.0).joints().map(DVec3::from_array).collect::<Vec<_>>());
            for (a, b) in a.iter().zip(&b) {
                prop_assert!((turn * *a).distance(*b) < 1e-3, "{a} {b}");
            }
        }
    }
}
