//! What a limb is to be, on a tube of three bones and on chains of other shapes.

mod tube;

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use wirework_core::Keyed;
use wirework_ik::{ChainCurve, Ik, Limb, Pin, Pose, ScaleBy, Tip};

use tube::{JOINTS, centers, double, length, limb, moved, rings, volume};

fn elastic(elasticity: f32) -> Ik {
    Ik { elasticity: Keyed::Constant(elasticity), ..Ik::default() }
}

fn joints(pose: &Pose) -> Vec<DVec3> {
    pose.joints().map(DVec3::from_array).collect()
}

fn bones(pose: &Pose) -> Vec<f64> {
    joints(pose).windows(2).map(|pair| pair[0].distance(pair[1])).collect()
}

/// Directions all over the sphere, none of them special.
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let angle = 2.399_963 * f64::from(i);
        DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z)
    })
}

/// Chains at rest: bent in a plane, to both sides, in space, with bones of unlike lengths.
fn chains() -> Vec<Vec<[f32; 3]>> {
    vec![
        JOINTS.to_vec(),
        vec![[0.0; 3], [1.0, -0.3, 0.0], [2.0, 0.0, 0.0]],
        vec![[0.0, 1.4, 0.1], [0.3, 1.38, 0.08], [0.55, 1.37, 0.12], [0.63, 1.36, 0.13]],
        vec![[0.0; 3], [1.0, 0.5, 0.0], [2.0, -0.5, 0.2], [2.5, 0.0, 0.6], [2.6, 1.0, 0.0]],
        vec![[0.0; 3], [0.2, 0.0, 0.0], [1.4, 0.0, 0.0], [1.5, 0.0, 0.0]],
        // A dog's leg, a Z, a coil.
        vec![[0.0, 1.0, 0.0], [0.15, 0.65, 0.0], [-0.15, 0.35, 0.0], [0.0; 3]],
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
        (0..9).map(|i| [(i as f32 * 1.1).cos(), (i as f32 * 1.1).sin(), i as f32 * 0.3]).collect(),
        (0..9)
            .map(|i| [i as f32 * 0.3, (i as f32 * 0.9).sin() * 0.2, (i as f32 * 0.9).cos() * 0.2])
            .collect(),
    ]
}

#[test]
fn rigid_bones_keep_their_length_and_reach() {
    for chain in chains() {
        let limb = Limb::new(&chain, &elastic(0.0)).unwrap();
        let root = double(chain[0]);
        let rest: Vec<f64> = chain.windows(2).map(|pair| double(pair[0]).distance(double(pair[1]))).collect();
        let total: f64 = rest.iter().sum();
        let longest = rest.iter().copied().fold(0.0, f64::max);
        let least = (2.0 * longest - total).max(0.0) / total;
        for direction in directions(40) {
            for part in [0.02, 0.1, 0.4, 0.7, 0.95, 0.999, 1.0, 1.5, 4.0] {
                let goal = root + direction * (part * total);
                let pose = limb.pose(goal.to_array(), 0.0);
                for (now, rest) in bones(&pose).iter().zip(&rest) {
                    assert!((now - rest).abs() < 1e-9 * total);
                }
                // What is out of reach is pointed at, by a straight limb; what is too near by one that is folded.
                let reach = f64::clamp(part, least, 1.0) * total;
                let tip = joints(&pose)[rest.len()];
                assert!(tip.distance(root + direction * reach) < 1e-7 * total, "{chain:?} {goal} {tip}");
            }
        }
    }
}

#[test]
fn the_goal_at_the_tip_is_the_rest_to_the_bit() {
    let points = rings(3.0, 0.2, 31);
    for chain in chains() {
        for elasticity in [0.0, 0.3, 1.0] {
            for curve in [ChainCurve::Rounded(0.25), ChainCurve::Chain] {
                for tip in [Tip::Follow, Tip::Hold([0.0; 3])] {
                    let pole = Some(Keyed::Constant([0.3, 5.0, 1.0]));
                    let pins = vec![Pin { joint: 1, point: Keyed::Constant(chain[1]) }];
                    let scale_by = ScaleBy::Local;
                    let settings = Ik { curve, tip, pole, pins, scale_by, ..elastic(elasticity) };
                    let limb = Limb::new(&chain, &settings).unwrap();
                    assert_eq!(moved(&limb, limb.tip(), &points), points);
                }
            }
        }
    }
    // Nearly there it is nearly so, whatever the pole.
    let limb = Limb::new(&chains()[1], &Ik { pole: Some(Keyed::Constant([1.0, 0.0, 9.0])), ..elastic(0.0) })
        .unwrap();
    let near = limb.pose([2.0, 1e-6, 0.0], 0.0);
    for (now, rest) in near.joints().zip(limb.joints()) {
        assert!(DVec3::from_array(now).distance(DVec3::from_array(rest)) < 1e-5);
    }
}

#[test]
fn limbs_leave_their_rest_without_a_step() {
    for chain in chains() {
        for elasticity in [0.0, 0.5, 1.0] {
            let limb = Limb::new(&chain, &elastic(elasticity)).unwrap();
            let rest: Vec<DVec3> = chain.iter().map(|p| double(*p)).collect();
            let (tip, total) = (rest[rest.len() - 1], length(&rest));
            for direction in directions(24) {
                let pose = joints(&limb.pose((tip + direction * (1e-6 * total)).to_array(), 0.0));
                let most = pose.iter().zip(&rest).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
                // A straight one bends by the root of that.
                assert!(most < 3e-3 * total, "{chain:?} {elasticity} {direction}: {most}");
            }
        }
    }
}

#[test]
fn between_any_two_goals_there_is_no_step() {
    for chain in chains() {
        for elasticity in [0.0, 0.5, 1.0] {
            let limb = Limb::new(&chain, &elastic(elasticity)).unwrap();
            let rest: Vec<DVec3> = chain.iter().map(|p| double(*p)).collect();
            let (root, total) = (rest[0], length(&rest));
            let ahead = (rest[rest.len() - 1] - root).normalize();
            let pose = |goal: DVec3| joints(&limb.pose(goal.to_array(), 0.0));
            let apart =
                |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            for direction in directions(12).filter(|direction| direction.dot(ahead) > -0.8) {
                // Along a line from the root, in, out and beyond.
                let mut before = pose(root + direction * 0.02 * total);
                for i in 1..=300 {
                    let part = |i: f64| root + direction * total * (0.02 + 2.2 * i / 300.0);
                    let (mut a, mut b) = (f64::from(i) - 1.0, f64::from(i));
                    let now = pose(part(b));
                    if apart(&before, &now) > 0.05 * total {
                        // Halved until it vanishes, where it is no step.
                        let (mut at_a, mut at_b) = (before.clone(), now.clone());
                        for _ in 0..24 {
                            let middle = 0.5 * (a + b);
                            let at = pose(part(middle));
                            if apart(&at_a, &at) > apart(&at, &at_b) {
                                (b, at_b) = (middle, at);
                            } else {
                                (a, at_a) = (middle, at);
                            }
                        }
                        assert!(apart(&at_a, &at_b) < 0.01 * total, "{chain:?} {elasticity} {direction} {a}");
                    }
                    before = now;
                }
            }
        }
    }
}

#[test]
fn rubber_stretches_evenly_and_keeps_its_volume() {
    let points = rings(3.0, 0.2, 61);
    let (before, limb) = (volume(&points), limb(&Ik { max_stretch: 3.0, ..elastic(1.0) }));
    for stretch in [0.7, 0.9, 1.1, 1.5, 2.0] {
        let now = moved(&limb, [3.0 * stretch, 0.0, 0.0], &points);
        for (ring, center) in centers(&now).iter().enumerate() {
            let expected = 3.0 * stretch * ring as f64 / 60.0;
            assert!((center.x - expected).abs() < 1e-5 * stretch, "{center} {expected}");
            let radius = double(now[ring * tube::SIDES + 5]).distance(*center);
            assert!((radius / (0.2 * stretch.powf(-0.5)) - 1.0).abs() < 1e-4, "{radius}");
        }
        assert!((volume(&now) / before - 1.0).abs() < 1e-4);
    }
}

#[test]
fn bent_rubber_keeps_its_volume_too() {
    let points = rings(3.0, 0.2, 121);
    let before = volume(&points);
    let rest: Vec<[f32; 3]> = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    for (elasticity, goal) in
        [(1.0, [1.5, 3.0, 0.0]), (0.5, [1.0, 1.5, 0.5]), (0.0, [1.2, 0.3, 2.0]), (0.7, [0.0, 4.0, 0.0])]
    {
        for scale_by in [ScaleBy::Length, ScaleBy::Local] {
            let limb = Limb::new(&rest, &Ik { scale_by, ..elastic(elasticity) }).unwrap();
            let now = volume(&moved(&limb, goal, &points)) / before;
            assert!((now - 1.0).abs() < 0.02, "{elasticity} {goal:?} {scale_by:?}: {now}");
        }
    }
}

#[test]
fn the_middle_line_of_a_rigid_tube_is_as_long_as_its_bones() {
    let points = rings(3.0, 0.1, 121);
    for direction in directions(20) {
        for part in [0.3, 0.6, 0.9, 1.0] {
            let now = moved(&limb(&elastic(0.0)), (direction * 3.0 * part).to_array(), &points);
            let middle = length(&centers(&now));
            assert!((middle / 3.0 - 1.0).abs() < 0.05, "{direction} {part}: {middle}");
        }
    }
}

#[test]
fn length_grows_with_elasticity_up_to_the_greatest() {
    let mut before = 0.0;
    for i in 0..=20 {
        let elasticity = i as f32 / 20.0;
        let pose = limb(&elastic(elasticity)).pose([1.0, 20.0, 3.0], 0.0);
        assert!(pose.length() > before && pose.length() <= 6.0 + 1e-9, "{}", pose.length());
        before = pose.length();
    }
    assert!(before > 5.99, "{before}");
}

#[test]
fn joints_lie_between_rigid_and_elastic() {
    for chain in chains() {
        let pose = |e: f32| joints(&Limb::new(&chain, &elastic(e)).unwrap().pose([0.9, 1.1, 0.4], 0.0));
        let (rigid, rubber) = (pose(0.0), pose(1.0));
        for e in [0.25, 0.5, 0.8] {
            for ((now, r), e1) in pose(e).iter().zip(&rigid).zip(&rubber) {
                assert!(now.distance(r.lerp(*e1, f64::from(e))) < 1e-6);
            }
        }
    }
}

#[test]
fn rubber_carries_joints_by_their_fraction_of_length() {
    let chain = &chains()[3];
    let limb = Limb::new(chain, &Ik { min_stretch: 0.0, max_stretch: 9.0, ..elastic(1.0) }).unwrap();
    let goal = DVec3::new(3.0, 1.5, 0.5);
    let motion = goal - DVec3::from_array(limb.tip());
    let rest: Vec<DVec3> = chain.iter().map(|p| double(*p)).collect();
    let total = length(&rest);
    for (i, now) in joints(&limb.pose(goal.to_array(), 0.0)).iter().enumerate() {
        let expected = rest[i] + motion * (length(&rest[..=i]) / total);
        assert!(now.distance(expected) < 1e-9);
    }
}

#[test]
fn out_of_reach_rubber_is_straight_and_as_long_as_it_may_be() {
    for chain in chains() {
        for most in [1.0, 1.3, 2.0] {
            let limb = Limb::new(&chain, &Ik { max_stretch: most, softness: 0.0, ..elastic(1.0) }).unwrap();
            let rest: Vec<DVec3> = chain.iter().map(|p| double(*p)).collect();
            let total = length(&rest);
            for direction in directions(20) {
                let pose = limb.pose((rest[0] + direction * 10.0 * total).to_array(), 0.0);
                let tip = rest[0] + direction * total * f64::from(most);
                assert!(joints(&pose)[rest.len() - 1].distance(tip) < 1e-6 * total);
                assert!((pose.length() / total - f64::from(most)).abs() < 1e-6);
                // Nearer than that it reaches, and is never longer.
                for part in [0.3, 0.8, 0.99] {
                    let goal = rest[0] + direction * part * total * f64::from(most);
                    let pose = limb.pose(goal.to_array(), 0.0);
                    assert!(joints(&pose)[rest.len() - 1].distance(goal) < 1e-9 * total);
                    assert!(pose.length() <= (f64::from(most) + 1e-9) * total);
                    assert!(pose.length() >= (0.3 - 1e-9) * total);
                }
            }
        }
    }
}

#[test]
fn near_goals_bend_rubber_that_may_not_shrink_further() {
    let limb = limb(&Ik { min_stretch: 0.5, ..elastic(1.0) });
    for distance in [0.01, 0.3, 1.0, 1.4] {
        let pose = limb.pose([distance, 0.0, 0.0], 0.0);
        assert!((pose.length() - 1.5).abs() < 1e-6, "{}", pose.length());
        assert!(joints(&pose)[3].distance(DVec3::X * distance) < 1e-9);
        assert!(joints(&pose)[1].y > 0.01);
    }
    assert!((limb.pose([1.6, 0.0, 0.0], 0.0).length() - 1.6).abs() < 1e-9);
}

#[test]
fn softness_eases_into_the_greatest_length_only() {
    let reach = |x: f64, softness: f32| {
        let limb = limb(&Ik { softness, ..elastic(1.0) });
        joints(&limb.pose([x, 0.0, 0.0], 0.0))[3].x
    };
    assert_eq!(reach(5.6, 0.1), 5.6);
    assert!((reach(5.7, 0.1) - 5.7).abs() < 1e-12);
    let eased = |x: f64| 5.7 + 0.3 * (1.0 - (-(x - 5.7) / 0.3).exp());
    assert!((reach(6.0, 0.1) - eased(6.0)).abs() < 1e-7);
    assert!((reach(60.0, 0.1) - 6.0).abs() < 1e-7);
    assert_eq!((reach(5.99, 0.0), reach(7.0, 0.0)), (5.99, 6.0));
}

#[test]
fn a_stiff_bone_keeps_its_length_and_soft_ones_make_up_for_it() {
    let settings = Ik { stiffness: vec![1.0, 0.0, 0.5], max_stretch: 3.0, ..elastic(1.0) };
    let pose = limb(&settings).pose([4.5, 0.0, 0.0], 0.0);
    let [a, b, c] = bones(&pose)[..] else { panic!() };
    assert!((a - 1.0).abs() < 1e-9 && (b - 2.0).abs() < 1e-9 && (c - 1.5).abs() < 1e-9, "{a} {b} {c}");
    for elasticity in [0.1, 0.5, 0.9] {
        let settings = Ik { elasticity: Keyed::Constant(elasticity), ..settings.clone() };
        let free = Ik { stiffness: vec![0.0; 3], ..settings.clone() };
        let pose = limb(&settings).pose([0.5, 2.0, 3.0], 0.0);
        assert!((bones(&pose)[0] - 1.0).abs() < 1e-9, "{elasticity}: {:?}", bones(&pose));
        assert!((bones(&limb(&free).pose([0.5, 2.0, 3.0], 0.0))[0] - 1.0).abs() > 1e-3);
    }
    // All stiff: rigid, and nearly so nearly rigid.
    let all = |k: f32| limb(&Ik { stiffness: vec![k; 3], ..elastic(1.0) }).pose([1.0, 4.0, 0.0], 0.0);
    assert!((all(1.0).length() - 3.0).abs() < 1e-9 && (all(0.999).length() - 3.0).abs() < 0.01);
}

#[test]
fn a_pole_says_to_which_side_a_limb_bends() {
    // Those that bend to one side: joints of a zigzag lie on both.
    for chain in chains().into_iter().take(5) {
        let root = double(chain[0]);
        let total = length(&chain.iter().map(|p| double(*p)).collect::<Vec<_>>());
        for (goal, pole) in directions(12).zip(directions(13).skip(1)) {
            let (goal, pole) = (root + goal * total * 0.7, root + pole * total * 3.0);
            let track = Keyed::Constant(pole.as_vec3().to_array());
            let limb = Limb::new(&chain, &Ik { pole: Some(track), ..elastic(0.0) }).unwrap();
            let joints = joints(&limb.pose(goal.to_array(), 0.0));
            let ahead = (goal - root).normalize();
            let side = (pole - root - ahead * ahead.dot(pole - root)).normalize();
            let mean: DVec3 = joints.iter().map(|j| *j - root).sum::<DVec3>() / joints.len() as f64;
            assert!(mean.dot(side) > 0.01 * total, "{chain:?} {mean} {side}");
            let normal = ahead.cross(side);
            // A chain in a plane stays in one.
            if chain.iter().all(|p| p[2] == 0.0) {
                assert!(joints.iter().all(|j| (*j - root).dot(normal).abs() < 1e-6 * total));
            }
        }
    }
}

#[test]
fn a_straight_chain_bends_towards_the_axis_that_it_is_least_aligned_with() {
    for (tip, expected) in
        [([3.0, 0.0, 0.0], DVec3::Y), ([0.0, 3.0, 0.0], DVec3::X), ([2.0, 0.5, 1.0], DVec3::Y)]
    {
        let joint = |part: f32| tip.map(|c| c * part);
        let limb = Limb::new(&[joint(0.0), joint(0.3), joint(0.7), joint(1.0)], &elastic(0.0)).unwrap();
        let goal = double(tip) * 0.6;
        let middle = joints(&limb.pose(goal.to_array(), 0.0))[1];
        let ahead = goal.normalize();
        let side = (expected - ahead * ahead.dot(expected)).normalize();
        let bend = middle - ahead * ahead.dot(middle);
        assert!(bend.normalize().dot(side) > 1.0 - 1e-9, "{tip:?}: {bend}");
    }
}

#[test]
fn the_plane_of_the_bend_turns_as_little_as_the_goal() {
    let chain = [[0.0; 3], [1.0, -0.4, 0.0], [2.0, 0.0, 0.0]];
    let limb = Limb::new(&chain, &elastic(0.0)).unwrap();
    for direction in directions(30).filter(|d| d.x > -0.9) {
        let joints = joints(&limb.pose((direction * 1.3).to_array(), 0.0));
        let turn = DQuat::from_rotation_arc(DVec3::X, direction);
        assert!(joints[1].dot(turn * DVec3::Z).abs() < 1e-9 && joints[1].dot(turn * -DVec3::Y) > 0.1);
    }
}

#[test]
fn joints_keep_within_their_cones_and_still_reach() {
    let limits = vec![0.6, 0.7, 0.8];
    for elasticity in [0.0, 0.5, 1.0] {
        let limb = limb(&Ik { limits: limits.clone(), ..elastic(elasticity) });
        for direction in directions(60) {
            for part in [0.4, 0.8, 1.2] {
                let goal = direction * 3.0 * part;
                let joints = joints(&limb.pose(goal.to_array(), 0.0));
                let mut before = DVec3::X;
                for (pair, limit) in joints.windows(2).zip(&limits) {
                    let bone = pair[1] - pair[0];
                    assert!(before.angle_between(bone) < f64::from(*limit) + 1e-6);
                    before = bone;
                }
            }
        }
        // Within reach of the cones it is there: both turns to one side.
        let (a, b, c) = (0.3_f64, 0.8_f64, 1.4_f64);
        let goal = DVec3::new(a.cos() + b.cos() + c.cos(), a.sin() + b.sin() + c.sin(), 0.0);
        let tip = joints(&limb.pose(goal.to_array(), 0.0))[3];
        // Rubber is as long as the straight way, and what turns aside comes short.
        let short = if elasticity == 0.0 { 1e-3 } else { 2e-2 };
        assert!(tip.distance(goal) < short * 3.0, "{elasticity}: {tip} {goal}");
    }
}

#[test]
fn pins_hold_joints_and_the_rest_goes_on_from_there() {
    let pin = |joint, point| Pin { joint, point: Keyed::Constant(point) };
    for elasticity in [0.0, 0.4, 1.0] {
        let pins = vec![pin(1, [0.8, 0.6, 0.0]), pin(0, [0.0; 3])];
        let pose = limb(&Ik { pins, ..elastic(elasticity) }).pose([1.5, 0.4, 1.0], 0.0);
        let joints = joints(&pose);
        assert!(joints[1].distance(DVec3::new(0.8, 0.6, 0.0)) < 1e-6);
        assert!(joints[3].distance(DVec3::new(1.5, 0.4, 1.0)) < 1e-6);
    }
    // Stiff behind a pin and soft before it: the stiff part starts where the soft one ends.
    let pins = vec![pin(1, [1.5, 0.5, 0.0])];
    let stiffness = vec![0.0, 0.9, 0.9];
    let pose = limb(&Ik { pins, stiffness, ..elastic(1.0) }).pose([2.5, 1.5, 0.0], 0.0);
    let joints_now = joints(&pose);
    assert!(joints_now[1].distance(DVec3::new(1.5, 0.5, 0.0)) < 1e-9);
    assert!(joints_now[3].distance(DVec3::new(2.5, 1.5, 0.0)) < 1e-9, "{}", joints_now[3]);
    // Held apart from its place, the root takes the limb along.
    let away = limb(&Ik { pins: vec![pin(0, [0.0, 5.0, 0.0])], ..elastic(0.0) }).pose([3.0, 5.0, 0.0], 0.0);
    assert!(joints(&away)[2].distance(DVec3::new(2.0, 5.0, 0.0)) < 1e-9);
    // A pin out of reach of rubber, too.
    let far = limb(&Ik { pins: vec![pin(2, [0.0, 0.0, 9.0])], ..elastic(1.0) }).pose([3.0, 0.0, 0.0], 0.0);
    assert!(joints(&far)[2].z < 4.0 && joints(&far)[2].z > 3.9);
}

#[test]
fn twist_is_spread_by_length_and_turns_go_on() {
    let points = rings(3.0, 0.2, 61);
    for turn in [0.5, PI, 4.0 * PI, -7.0 * PI] {
        for curve in [ChainCurve::Rounded(0.25), ChainCurve::Chain] {
            let limb = limb(&Ik { curve, twist: Keyed::Constant(turn as f32), ..elastic(1.0) });
            let now = moved(&limb, [3.0, 0.0, 0.0], &points);
            for ring in 0..61 {
                let angle = turn * ring as f64 / 60.0;
                let expected = DQuat::from_rotation_x(angle) * double(points[ring * tube::SIDES]);
                let found = double(now[ring * tube::SIDES]);
                // A hundredth of a turn along the limb.
                assert!(found.distance(expected) < 0.2 * 2e-3 * turn.abs().max(1.0), "{turn} {ring}");
            }
        }
    }
}

#[test]
fn a_held_tip_keeps_its_orientation() {
    let mut points = rings(3.0, 0.2, 31);
    points.push([3.4, 0.1, 0.05]);
    let angles = [0.3_f32, -0.5, 1.2];
    let turn = DQuat::from_rotation_z(1.2) * DQuat::from_rotation_y(-0.5) * DQuat::from_rotation_x(0.3);
    for (tip, turn) in [(Tip::Hold(angles), turn), (Tip::Hold([0.0; 3]), DQuat::IDENTITY)] {
        for curve in [ChainCurve::Rounded(0.25), ChainCurve::Chain] {
            for goal in [[2.0, 1.0, 0.5], [0.0, 2.5, -1.0], [3.0, 0.0, 0.0]] {
                let limb = limb(&Ik { tip, curve, volume: 0.0, ..elastic(0.0) });
                let now = moved(&limb, goal, &points);
                // What lies beyond the tip turns with it.
                let beyond = double(now[points.len() - 1]) - DVec3::from_array(goal);
                let expected = turn * DVec3::new(0.4, 0.1, 0.05);
                assert!(beyond.distance(expected) < 1e-3, "{beyond} {expected}");
            }
        }
    }
}

#[test]
fn curves_rounded_up_to_the_middles_of_bones_have_no_notch() {
    // A ring lies in the very middle of the second bone.
    let points = rings(3.0, 0.1, 61);
    let at = |part| {
        let limb = limb(&Ik { curve: ChainCurve::Rounded(part), ..elastic(0.0) });
        moved(&limb, [1.5, 1.2, 0.0], &points)
    };
    for (half, nearly) in at(0.5).iter().zip(&at(0.499)) {
        assert!(double(*half).distance(double(*nearly)) < 0.01, "{half:?} {nearly:?}");
    }
}

#[test]
fn bones_frames_are_what_their_middles_do() {
    let settings = Ik { twist: Keyed::Constant(1.0), ..elastic(0.6) };
    for chain in chains() {
        let limb = Limb::new(&chain, &settings).unwrap();
        let (pose, mut wire) = (limb.pose([0.7, 0.9, 0.3], 0.0), limb.wire());
        limb.wire_into(&pose, 0.0, &mut wire);
        let frames = limb.bone_frames(&pose, &wire);
        assert_eq!(frames.len(), chain.len());
        for (pair, joints) in frames.windows(2).zip(joints(&pose).windows(2)) {
            let [a, b] = [&pair[0], &pair[1]];
            let bone = DVec3::from_array(b.from) - DVec3::from_array(a.from);
            let now = DVec3::from_array(a.to) + DQuat::from_array(a.rotation) * bone * a.stretch;
            assert!(now.distance(joints[1]) < 1e-9, "a frame takes a bone from joint to joint");
        }
    }
}
