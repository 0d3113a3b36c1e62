//! The engine against the float64 reference: random rigs with every curve, attribute, bend, correspondence, blend
//! and group, sizes from 1e-3 to 1e3, points in mesh order and shuffled.
//!
//! `WIREWORK_RIGS=5000` widens the search.

use std::cell::OnceCell;
use wirework_core::{Binding, Blend, Wire};
use wirework_reference::{Doubt, Random, Rig, Scene};

/// The contract: errors in parts of the scene's diagonal.
const TOLERANCE: f64 = 2e-5;

/// A point whose exact answer moves by a quarter of the tolerance when the input moves by two of float32's last
/// places is no test of the engine.
const INPUT_ROUNDING: f64 = 2.4e-7;

/// Share of points that may be left out so.
const LEFT_OUT: f64 = 0.01;

fn rigs() -> u64 {
    std::env::var("WIREWORK_RIGS").ok().and_then(|n| n.parse().ok()).unwrap_or(140)
}

fn deform(wires: &[Wire], blend: &Blend, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; points.len()];
    Binding::new(wires, points).unwrap().deform_into(wires, blend, &mut out).unwrap();
    out
}

fn bits(points: &[[f32; 3]]) -> Vec<[u32; 3]> {
    points.iter().map(|p| p.map(f32::to_bits)).collect()
}

fn apart(a: [f32; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (f64::from(a[i]) - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Compares one rig; gives how many points were left out, and the worst error of the others in diagonals.
fn compare(seed: u64, rig: &Rig) -> (usize, f64) {
    let scene = Scene::new(&rig.wires, &rig.blend);
    let diagonal = rig.diagonal();
    let doubt = OnceCell::new();
    let mut left_out = 0;
    let mut worst: f64 = 0.0;
    for (&p, &found) in rig.points.iter().zip(&deform(&rig.wires, &rig.blend, &rig.points)) {
        let exact = scene.deform(p);
        let error = apart(found, exact) / diagonal;
        if error <= TOLERANCE {
            worst = worst.max(error);
            continue;
        }
        let doubt = doubt.get_or_init(|| Doubt::new(&rig.wires, &rig.blend, INPUT_ROUNDING));
        let moves = doubt.of(p) / diagonal;
        assert!(
            moves > 0.25 * TOLERANCE,
            "seed {seed}: {p:?} went to {found:?}, not {exact:?}: off by {error:e} of the diagonal, where rounding \
             the input accounts for {moves:e}\n{:?}\n{:#?}\n{:?}",
            rig.blend,
            rig.wires,
            scene.contributions(p),
        );
        left_out += 1;
    }
    (left_out, worst)
}

/// Compares seeds from `first` in steps of `step`, so that two tests share the work of two cores.
fn compare_many(first: u64, step: usize) {
    let (mut left_out, mut all, mut worst) = (0, 0, 0.0_f64);
    for seed in (first..rigs()).step_by(step) {
        let mut rig = Rig::new(seed);
        if seed % 3 == 0 {
            Random::new(seed).shuffle(&mut rig.points);
        }
        let (out, error) = compare(seed, &rig);
        (left_out, all, worst) = (left_out + out, all + rig.points.len(), worst.max(error));
    }
    println!("{all} points, {left_out} left out, worst error {worst:e} diagonals");
    assert!((left_out as f64) < LEFT_OUT * all as f64, "{left_out} of {all} points left out");
}

#[test]
fn even_rigs_deform_as_the_reference() {
    compare_many(0, 2);
}

#[test]
fn odd_rigs_deform_as_the_reference() {
    compare_many(1, 2);
}

#[test]
fn a_rig_at_rest_keeps_every_bit() {
    for seed in 0..rigs() {
        let mut rig = Rig::new(seed).at_rest();
        rig.points.extend([[-0.0; 3], [f32::MIN_POSITIVE / 2.0, -0.0, 0.0]]);
        let found = deform(&rig.wires, &rig.blend, &rig.points);
        for ((p, a), b) in rig.points.iter().zip(bits(&rig.points)).zip(bits(&found)) {
            assert_eq!(a, b, "seed {seed}, {p:?}, {:?}", rig.wires);
        }
    }
}

#[test]
fn out_of_reach_every_bit_stays() {
    let mut met = 0;
    for seed in 0..rigs() {
        let mut rig = Rig::new(seed);
        // Beyond all reach, with both zeros.
        let far = (rig.diagonal() * 4.0) as f32;
        rig.points.extend([[-0.0, far, -0.0], [far, -0.0, 0.0], [-far, -far, far]]);
        let scene = Scene::new(&rig.wires, &rig.blend);
        let found = deform(&rig.wires, &rig.blend, &rig.points);
        for (p, q) in rig.points.iter().zip(&found) {
            // Clear of r, wherever along the wire.
            let clear = rig.wires.iter().zip(scene.feet(*p)).all(|(wire, foot)| {
                let radii = wire.locators.iter().filter_map(|l| l.radius).chain([wire.radius]);
                foot.distance > 1.001 * f64::from(radii.fold(0.0, f32::max))
            });
            if clear {
                met += 1;
                assert_eq!(bits(&[*p]), bits(&[*q]), "seed {seed}");
            }
        }
    }
    assert!(met > 1000, "{met} points out of reach");
}

/// Enough points for several tiles.
fn crowd(rig: &Rig, seed: u64) -> Vec<[f32; 3]> {
    let mut random = Random::new(seed);
    let size = rig.diagonal() / 4.0;
    let around: Vec<[f32; 3]> = rig.points.clone();
    (0..5000)
        .map(|_| {
            let (p, off) = (random.pick(&around), random.vector(size));
            [0, 1, 2].map(|i| (f64::from(p[i]) + off[i] * 0.2) as f32)
        })
        .collect()
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let pools: Vec<rayon::ThreadPool> =
        [1, 2, 5].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap()).into();
    for seed in 0..8 {
        let rig = Rig::new(seed);
        let points = crowd(&rig, seed);
        let found: Vec<_> = pools
            .iter()
            .map(|pool| pool.install(|| bits(&deform(&rig.wires, &rig.blend, &points))))
            .collect();
        assert!(found.windows(2).all(|w| w[0] == w[1]), "seed {seed}");
    }
}

#[test]
fn a_point_goes_the_same_way_in_any_company() {
    for seed in 0..8 {
        let rig = Rig::new(seed);
        let points = crowd(&rig, seed);
        let together = deform(&rig.wires, &rig.blend, &points);
        let mut order: Vec<usize> = (0..points.len()).collect();
        Random::new(seed).shuffle(&mut order);
        let shuffled: Vec<[f32; 3]> = order.iter().map(|&i| points[i]).collect();
        let diagonal = rig.diagonal();
        let mut unlike = 0;
        for (&i, q) in order.iter().zip(deform(&rig.wires, &rig.blend, &shuffled)) {
            unlike += usize::from(apart(q, together[i].map(f64::from)) > 1e-6 * diagonal);
        }
        assert!(unlike <= points.len() / 1000, "seed {seed}: {unlike} points");
    }
}

#[test]
fn a_binding_takes_up_what_changed() {
    for seed in 0..40 {
        let rig = Rig::new(seed);
        let mut binding = Binding::new(&rig.wires, &rig.points).unwrap();
        let mut found = vec![[0.0; 3]; rig.points.len()];
        binding.deform_into(&rig.wires, &rig.blend, &mut found).unwrap();
        assert_eq!(
            bits(&found),
            bits(&deform(&rig.wires, &rig.blend, &rig.points)),
            "seed {seed}, the first time"
        );

        let other = Rig::new(seed + 1000);
        let mut wires = rig.wires.clone();
        let mut random = Random::new(seed);
        for (i, wire) in wires.iter_mut().enumerate() {
            let donor = &other.wires[i % other.wires.len()];
            match random.below(4) {
                0 => wire.radius *= 1.7,
                1 => wire.density = donor.density.clone(),
                2 => wire.locators.clone_from(&donor.locators),
                _ => {
                    let moved = wire.reference.points().iter().map(|p| [p[0], p[1] * 0.9, p[2]]).collect();
                    wire.reference = wire.reference.posed(moved).unwrap();
                }
            }
            (wire.bend, wire.correspondence) = (donor.bend, donor.correspondence);
            (wire.twist, wire.group) = (donor.twist, donor.group);
        }
        for step in [&wires, &rig.wires, &wires] {
            binding.deform_into(step, &other.blend, &mut found).unwrap();
            assert_eq!(bits(&found), bits(&deform(step, &other.blend, &rig.points)), "seed {seed}, changed");
        }
    }
}
