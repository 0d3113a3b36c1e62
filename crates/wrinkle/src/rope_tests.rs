use std::f64::consts::TAU;

use super::*;

const G: f64 = 9.81;
const GRAVITY: DVec3 = DVec3::new(0.0, -G, 0.0);

/// A straight rope of `links` links, `angle` off the vertical.
fn slanted(links: usize, length: f64, angle: f64) -> Vec<DVec3> {
    let direction = DVec3::new(angle.sin(), -angle.cos(), 0.0);
    (0..=links).map(|i| direction * (length * i as f64 / links as f64)).collect()
}

fn energy(rope: &Rope, gravity: DVec3) -> f64 {
    let of = |((mass, node), velocity): ((&f64, &DVec3), &DVec3)| {
        mass * (0.5 * velocity.length_squared() - gravity.dot(*node))
    };
    rope.links.masses.iter().zip(&rope.nodes).zip(&rope.velocities).map(of).sum()
}

fn stretch(rope: &Rope, nodes: &[DVec3]) -> f64 {
    let error = |(pair, length): (&[DVec3], &f64)| ((pair[1] - pair[0]).length() / length - 1.0).abs();
    nodes.windows(2).zip(&rope.links.lengths).map(error).fold(0.0, f64::max)
}

/// The mean period of what crosses zero, between steps by the straight line.
fn period(values: &[f64]) -> f64 {
    let crossings: Vec<f64> = values
        .windows(2)
        .enumerate()
        .filter(|(_, w)| w[0] > 0.0 && w[1] <= 0.0)
        .map(|(i, w)| i as f64 + w[0] / (w[0] - w[1]))
        .collect();
    let last = crossings.len() - 1;
    (crossings[last] - crossings[0]) / (last as f64 * f64::from(RATE))
}

#[test]
fn a_rope_that_hangs_stays_to_the_bit() {
    for stiffness in [0.0, 0.4, 1.0] {
        for (links, length) in [(1, 1.0), (7, 0.03), (40, 2.5), (200, 31.0)] {
            // Unequal links too.
            let nodes = slanted(links, 1.0, 0.0).into_iter().map(|p| p * p.length() * length).collect();
            let mut rope = Rope::new(nodes, stiffness);
            for _ in 0..20 * RATE {
                rope.step(DVec3::ZERO, GRAVITY, 0.0);
            }
            assert_eq!(rope.nodes, rope.rest);
        }
    }
}

#[test]
fn it_hangs_along_any_gravity() {
    let gravity = DVec3::new(0.3, -9.7, 0.9);
    let nodes: Vec<DVec3> = (0..=40).map(|i| gravity.normalize() * (0.05 * f64::from(i))).collect();
    let mut rope = Rope::new(nodes, 0.0);
    (0..20 * RATE).for_each(|_| rope.step(DVec3::ZERO, gravity, 0.0));
    assert_eq!(rope.nodes, rope.rest);
}

#[test]
fn one_link_is_a_pendulum() {
    for length in [0.1, 1.0, 4.0_f64] {
        let mut rope = Rope::new(slanted(1, length, 0.05), 0.0);
        let swing: Vec<f64> = (0..30 * RATE)
            .map(|_| {
                rope.step(DVec3::ZERO, GRAVITY, 0.0);
                rope.nodes[1].x
            })
            .collect();
        let (found, exact) = (period(&swing), TAU * (length / G).sqrt());
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} for {exact}");
    }
}

#[test]
fn many_links_swing_as_a_hanging_chain() {
    // Bernoulli's: J₀(2 ω √(s / g)) with s from the free end; its first zero is 2.404826.
    let (length, links) = (2.0, 60);
    let frequency = 2.404_825_557_7 / 2.0 * (G / length).sqrt();
    let bessel = |x: f64| {
        let terms = (1..20).scan(1.0, |term, k| {
            *term *= -x * x / (4.0 * f64::from(k * k));
            Some(*term)
        });
        1.0 + terms.sum::<f64>()
    };
    let node = |i: usize| {
        let way = length * i as f64 / f64::from(links as u32);
        let sideways = 0.01 * bessel(2.0 * frequency * ((length - way) / G).sqrt());
        DVec3::new(sideways, -way, 0.0)
    };
    let nodes: Vec<DVec3> = (0..=links).map(node).collect();
    let mut rope = Rope::new(nodes, 0.0);
    let swing: Vec<f64> = (0..20 * RATE)
        .map(|_| {
            rope.step(DVec3::ZERO, GRAVITY, 0.0);
            rope.nodes[links].x
        })
        .collect();
    let (found, exact) = (period(&swing), TAU / frequency);
    assert!((found / exact - 1.0).abs() < 5e-3, "{found} for {exact}");
    let last = swing[swing.len() - (exact * f64::from(RATE)) as usize..].iter().copied().fold(0.0, f64::max);
    assert!(last > 0.008, "{last}");
}

#[test]
fn a_stiff_rope_bends_as_a_beam() {
    // The first mode of a beam that is hinged at one end and free at the other: β L = 3.926602.
    let (length, links, stiffness) = (1.0, 50, 0.2_f64);
    let beta = 3.926_602_3;
    let rigidity = 10.0 * 9.81 * stiffness.powi(3);
    let frequency = beta * beta * rigidity.sqrt();
    let mut rope = Rope::new(slanted(links, length, 0.0), stiffness);
    for (node, rest) in rope.nodes.iter_mut().zip(&rope.rest) {
        let x = -rest.y * beta;
        node.x += 1e-3 * (x.sin() + beta.sin() / beta.sinh() * x.sinh());
    }
    let swing: Vec<f64> = (0..4 * RATE)
        .map(|_| {
            rope.step(DVec3::ZERO, DVec3::ZERO, 0.0);
            rope.nodes[links].x
        })
        .collect();
    let (found, exact) = (period(&swing), TAU / frequency);
    assert!((found / exact - 1.0).abs() < 0.01, "{found} for {exact}");
}

/// The energy of bending of a rope that is straight at rest.
fn bent(rope: &Rope, stiffness: f64) -> f64 {
    let lengths = &rope.links.lengths;
    let direction = |i: usize| (rope.nodes[i + 1] - rope.nodes[i]) / lengths[i];
    let joint = |i: usize| (direction(i) - direction(i - 1)).length_squared() / (lengths[i] + lengths[i - 1]);
    10.0 * 9.81 * stiffness.powi(3) * rope.length.powi(2) * (1..lengths.len()).map(joint).sum::<f64>()
}

#[test]
fn energy_never_grows() {
    for (links, angle, stiffness) in
        [(1, 1.5, 0.0), (2, 2.5, 0.0), (40, 1.5, 0.0), (40, 3.0, 0.0), (40, 1.5, 0.3), (40, 2.5, 0.8)]
    {
        let mut rope = Rope::new(slanted(links, 2.0, angle), stiffness);
        let mut least = energy(&rope, GRAVITY);
        for _ in 0..20 * RATE {
            rope.step(DVec3::ZERO, GRAVITY, 0.0);
            let now = energy(&rope, GRAVITY) + bent(&rope, stiffness);
            assert!(
                now - least <= 1e-6 * G * 2.0,
                "{links} links, stiffness {stiffness}: {now} after {least}"
            );
            least = least.min(now);
        }
    }
}

#[test]
fn a_curved_stiff_rope_comes_to_rest_by_itself() {
    let coil = |i: i32| {
        let turn = 0.3 * f64::from(i);
        DVec3::new(0.1 * turn.cos() - 0.1, -0.03 * f64::from(i), 0.1 * turn.sin())
    };
    for stiffness in [0.1, 0.3, 0.6, 1.0] {
        let mut rope = Rope::new((0..=40).map(coil).collect(), stiffness);
        let mut fastest = [0.0_f64; 4];
        for part in &mut fastest {
            for _ in 0..10 * RATE {
                rope.step(DVec3::ZERO, GRAVITY, 0.0);
                *part = rope.velocities.iter().fold(*part, |most, v| most.max(v.length()));
            }
        }
        assert!(fastest[3] < 0.8 * fastest[0], "{stiffness}: {fastest:?}");
    }
}

#[test]
fn damping_takes_its_share() {
    let mut rope = Rope::new(slanted(1, 1.0, 0.05), 0.0);
    let mut last_second = 0.0_f64;
    for i in 0..4 * RATE {
        rope.step(DVec3::ZERO, GRAVITY, 1.5);
        if i >= 2 * RATE {
            last_second = last_second.max(rope.nodes[1].x);
        }
    }
    // The second turn is a period later, and the scheme takes a little too.
    let time = TAU / (G - 0.75 * 0.75).sqrt();
    let exact = 0.05_f64.sin() * (-(0.75 + 0.5 * G / f64::from(RATE)) * time).exp();
    assert!((last_second / exact - 1.0).abs() < 0.01, "{last_second} for {exact}");
}

#[test]
fn lengths_hold_under_a_rail_that_jumps() {
    for jump in [0.01, 0.09, 0.3, 2.0, 1e6] {
        let mut rope = Rope::new(slanted(40, 2.0, 0.1), 0.0);
        let mut out = Vec::new();
        for i in 0..4 * RATE {
            let top = DVec3::X * if i / 100 % 2 == 1 { jump } else { 0.0 };
            rope.step(top, GRAVITY, 1.5);
            assert_eq!(rope.nodes[0], top);
            rope.between(0.37, top, &mut out);
            let tolerance = 1e-12 * jump.max(1.0);
            assert!(stretch(&rope, &rope.nodes) < tolerance && stretch(&rope, &out) < tolerance);
        }
    }
}

#[test]
fn a_pull_is_felt_and_a_cut_is_not() {
    let fastest = |way: f64| {
        let mut rope = Rope::new(slanted(40, 2.0, 0.0), 0.0);
        let mut fastest = 0.0_f64;
        for i in 0..RATE {
            rope.step(DVec3::X * way * f64::from(i.min(4)), GRAVITY, 1.5);
            fastest = rope.velocities.iter().fold(fastest, |most, v| most.max(v.length()));
        }
        fastest
    };
    let all = [0.01, 0.1, 2.0, 1e3].map(fastest);
    assert!(all[0] > 4.0 && all[1] > 40.0 && all[2] < 3.0 && all[3] < 0.1, "{all:?}");
}

#[test]
fn wind_lifts_a_rope_by_its_share_of_gravity() {
    let mut rope = Rope::new(slanted(20, 1.0, 0.0), 0.0);
    (0..20 * RATE).for_each(|_| rope.step(DVec3::ZERO, GRAVITY + DVec3::X * G, 1.5));
    for (node, exact) in rope.nodes.iter().zip(slanted(20, 1.0, TAU / 8.0)) {
        assert!(node.distance(exact) < 1e-5, "{node} for {exact}");
    }
}

#[test]
fn a_stiff_rope_keeps_its_shape_and_beads_do_not() {
    let nodes: Vec<DVec3> =
        (0..=30).map(|i| f64::from(i) / 30.0).map(|s| DVec3::new(0.1 * (6.0 * s).sin(), -s, 0.0)).collect();
    let hung = |stiffness| {
        let mut rope = Rope::new(nodes.clone(), stiffness);
        (0..15 * RATE).for_each(|_| rope.step(DVec3::ZERO, GRAVITY, 1.5));
        // The distance of its ends, from the one at rest to all of its length.
        let length: f64 = rope.links.lengths.iter().sum();
        let long = rope.nodes[30].length();
        (long - nodes[30].length()) / (length - nodes[30].length())
    };
    let all = [0.0, 0.1, 0.3, 1.0].map(hung);
    assert!(all[0] > 0.999 && all[3] < 0.05 && all.is_sorted_by(|a, b| a > b), "{all:?}");
}

#[test]
fn huge_accelerations_end_in_no_nan() {
    for acceleration in [1e10, 1e30, f64::from(f32::MAX)] {
        let mut nodes = slanted(20, 1.0, 0.5);
        nodes.iter_mut().enumerate().for_each(|(i, node)| node.z = 0.05 * (i as f64).sin());
        let mut rope = Rope::new(nodes, 0.5);
        (0..2 * RATE).for_each(|i| {
            rope.step(DVec3::ZERO, DVec3::new(f64::from(i % 3) - 1.0, -1.0, 0.3) * acceleration, 0.0);
        });
        (0..RATE).for_each(|_| rope.step(DVec3::ZERO, GRAVITY, 1.5));
        assert!(rope.nodes.iter().all(|p| p.is_finite() && p.length() < 1.001 * rope.length));
    }
}

#[test]
fn a_bent_cane_swings_as_a_straight_one() {
    let width = |bend: f64| {
        let node = |i: i32| DVec3::new(bend * (f64::from(i) / 5.0).sin(), -f64::from(i) / 30.0, 0.0);
        let mut rope = Rope::new((0..=30).map(node).collect(), 1.0);
        (0..10 * RATE).for_each(|_| rope.step(DVec3::ZERO, GRAVITY, 1.5));
        let rest = rope.nodes[30];
        (0..RATE / 4).for_each(|_| rope.step(DVec3::ZERO, GRAVITY + DVec3::X * 5.0, 0.0));
        (0..8 * RATE).for_each(|_| rope.step(DVec3::ZERO, GRAVITY, 0.0));
        let mut most = 0.0_f64;
        for _ in 0..2 * RATE {
            rope.step(DVec3::ZERO, GRAVITY, 0.0);
            most = most.max(rope.nodes[30].distance(rest));
        }
        most
    };
    let (bent, straight) = (width(0.1), width(0.0));
    assert!((bent / straight - 1.0).abs() < 0.05, "{bent} and {straight}");
}
