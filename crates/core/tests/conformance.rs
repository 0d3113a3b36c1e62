//! The engine against the float64 reference: random rigs with every curve, attribute, bend, correspondence, blend, group,
//! direction, domain curve, blended feet and masks, sizes from 1e-3 to 1e3, points in mesh order and shuffled.
//!
//! `WIREWORK_RIGS=5000` widens the search.

use std::cell::OnceCell;
use wirework_core::{Binding, Mask};
use wirework_reference::{Doubt, Random, Rig, Scene};

/// The contract: errors in parts of the scene's diagonal.
const TOLERANCE: f64 = 2e-5;

/// A point whose exact answer moves by a quarter of the tolerance when the input moves by two of float32's last
/// places is no test of the engine.
const INPUT_ROUNDING: f64 = 2.4e-7;

/// Share of points that may be left out so.
const LEFT_OUT: f64 = 0.01;

fn rigs() -> u64 {
    std::env::var("WIREWORK_RIGS").ok().and_then(|n| n.parse().ok()).unwrap_or(280)
}

fn deform(rig: &Rig) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; rig.points.len()];
    let mut binding = Binding::masked(&rig.wires, &rig.points, &rig.masks()).unwrap();
    binding.deform_into(&rig.wires, &rig.blend, &mut out).unwrap();
    out
}

/// The rig of a seed, every other one without what bounds the influence.
fn rig(seed: u64) -> Rig {
    let (plain, seed) = (seed & 2 == 0, seed / 4 * 2 + seed % 2);
    if plain { Rig::plain(seed) } else { Rig::new(seed) }
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
    for (i, (&p, &found)) in rig.points.iter().zip(&deform(rig)).enumerate() {
        let masks = rig.masks_at(i);
        let exact = scene.deform_masked(p, &masks);
        let error = apart(found, exact) / diagonal;
        if error <= TOLERANCE {
            worst = worst.max(error);
            continue;
        }
        let doubt = doubt.get_or_init(|| Doubt::new(&rig.wires, &rig.blend, INPUT_ROUNDING));
        let moves = doubt.of_masked(p, &masks) / diagonal;
        assert!(
            moves > 0.25 * TOLERANCE,
            "seed {seed}: {p:?} went to {found:?}, not {exact:?}: off by {error:e} of the diagonal, where rounding \
             the input accounts for {moves:e}\n{:?}\n{:#?}\n{:?}",
            rig.blend,
            rig.wires,
            scene.contributions(p, &masks),
        );
        left_out += 1;
    }
    (left_out, worst)
}

/// Compares seeds from `first` in steps of `step`, so that two tests share the work of two cores.
fn compare_many(first: u64, step: usize) {
    let (mut left_out, mut all, mut worst) = (0, 0, 0.0_f64);
    for seed in (first..rigs()).step_by(step) {
        let mut rig = rig(seed);
        if seed % 3 == 0 {
            rig.shuffle(&mut Random::new(seed));
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
        let mut rig = rig(seed).at_rest();
        rig.add([[-0.0; 3], [f32::MIN_POSITIVE / 2.0, -0.0, 0.0]]);
        let found = deform(&rig);
        for ((p, a), b) in rig.points.iter().zip(bits(&rig.points)).zip(bits(&found)) {
            assert_eq!(a, b, "seed {seed}, {p:?}, {:?}", rig.wires);
        }
    }
}

#[test]
fn out_of_reach_every_bit_stays() {
    let mut met = 0;
    for seed in 0..rigs() {
        let mut rig = rig(seed);
        // Beyond all reach, with both zeros.
        let far = (rig.diagonal() * 4.0) as f32;
        rig.add([[-0.0, far, -0.0], [far, -0.0, 0.0], [-far, -far, far]]);
        let scene = Scene::new(&rig.wires, &rig.blend);
        let found = deform(&rig);
        for (p, q) in rig.points.iter().zip(&found) {
            // Clear of r, wherever along the wire.
            let clear = rig.wires.iter().zip(scene.feet(*p)).all(|(wire, foot)| {
                let radii = wire.locators.iter().filter_map(|l| l.radius).chain([wire.radius]);
                // A domain curve may carry the influence as far as itself.
                let domains = if wire.domains.is_empty() { 0.0 } else { rig.diagonal() };
                foot.distance > 1.001 * f64::from(radii.fold(0.0, f32::max)).max(domains)
            });
            if clear {
                met += 1;
                assert_eq!(bits(&[*p]), bits(&[*q]), "seed {seed}");
            }
        }
    }
    assert!(met > 1000, "{met} points out of reach");
}

/// The rig with enough points for several tiles.
fn crowd(mut rig: Rig, seed: u64) -> Rig {
    let mut random = Random::new(seed);
    let size = rig.diagonal() / 4.0;
    let around: Vec<usize> = (0..5000).map(|_| random.below(rig.points.len())).collect();
    let near = |p: [f32; 3], off: [f64; 3]| [0, 1, 2].map(|i| (f64::from(p[i]) + off[i] * 0.2) as f32);
    rig.points = around.iter().map(|&i| near(rig.points[i], random.vector(size))).collect();
    for mask in rig.masks.iter_mut().flatten() {
        *mask = around.iter().map(|&i| mask[i]).collect();
    }
    rig
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let pools: Vec<rayon::ThreadPool> =
        [1, 2, 5].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap()).into();
    for seed in 0..16 {
        let rig = crowd(rig(seed), seed);
        let found: Vec<_> = pools.iter().map(|pool| pool.install(|| bits(&deform(&rig)))).collect();
        assert!(found.windows(2).all(|w| w[0] == w[1]), "seed {seed}");
    }
}

#[test]
fn a_point_goes_the_same_way_in_any_company() {
    for seed in 0..16 {
        let rig = crowd(rig(seed), seed);
        let together = deform(&rig);
        let mut order: Vec<usize> = (0..rig.points.len()).collect();
        Random::new(seed).shuffle(&mut order);
        let mut shuffled = rig.clone();
        shuffled.shuffle(&mut Random::new(seed));
        let diagonal = rig.diagonal();
        let mut unlike = 0;
        for (&i, q) in order.iter().zip(deform(&shuffled)) {
            unlike += usize::from(apart(q, together[i].map(f64::from)) > 1e-6 * diagonal);
        }
        assert!(unlike <= rig.points.len() / 1000, "seed {seed}: {unlike} points");
    }
}

/// The rig with some of what another one has.
fn changed(rig: &Rig, other: &Rig, random: &mut Random) -> Rig {
    let mut rig = rig.clone();
    for (i, wire) in rig.wires.iter_mut().enumerate() {
        let donor = &other.wires[i % other.wires.len()];
        match random.below(8) {
            0 => wire.radius *= 1.7,
            1 => wire.density = donor.density.clone(),
            2 => wire.locators.clone_from(&donor.locators),
            3 => wire.domains.clone_from(&donor.domains),
            4 => wire.closest = donor.closest,
            5 => (wire.direction, wire.angle) = (donor.direction, donor.angle),
            6 => wire.domains.iter_mut().for_each(|domain| (domain.delta, domain.exponent) = (0.4, -1.0)),
            _ => {
                let moved = wire.reference.points().iter().map(|p| [p[0], p[1] * 0.9, p[2]]).collect();
                wire.reference = wire.reference.posed(moved).unwrap();
            }
        }
        (wire.bend, wire.correspondence) = (donor.bend, donor.correspondence);
        (wire.twist, wire.group) = (donor.twist, donor.group);
    }
    rig.blend = other.blend;
    rig
}

#[test]
fn a_binding_takes_up_what_changed() {
    for seed in 0..120 {
        let rig = rig(seed);
        let mut binding = Binding::masked(&rig.wires, &rig.points, &rig.masks()).unwrap();
        let mut found = vec![[0.0; 3]; rig.points.len()];
        binding.deform_into(&rig.wires, &rig.blend, &mut found).unwrap();
        assert_eq!(bits(&found), bits(&deform(&rig)), "seed {seed}, the first time");
        let mut random = Random::new(seed);
        let other = changed(&rig, &Rig::new(seed + 1000), &mut random);
        for step in [&other, &rig, &other] {
            binding.deform_into(&step.wires, &step.blend, &mut found).unwrap();
            assert_eq!(bits(&found), bits(&deform(step)), "seed {seed}, changed");
        }
    }
}

#[test]
fn sparse_masks_do_what_dense_ones_do() {
    for seed in 0..60 {
        let rig = rig(seed);
        let mut random = Random::new(seed + 77);
        // A band of points in some tiles, single ones in others.
        let keep = |i: usize, random: &mut Random| (i / 300) % 3 == 1 || random.range(0.0, 1.0) < 0.01;
        let points: Vec<u32> =
            (0..rig.points.len() as u32).filter(|&i| keep(i as usize, &mut random)).collect();
        let factors: Vec<f32> = points.iter().map(|_| random.range(-0.2, 1.2) as f32).collect();
        let mut dense = vec![0.0; rig.points.len()];
        points.iter().zip(&factors).for_each(|(&i, &f)| dense[i as usize] = f);
        let sparse = vec![Some(Mask::Sparse { points: &points, factors: &factors }); rig.wires.len()];
        let dense = vec![Some(Mask::Dense(&dense)); rig.wires.len()];
        let of = |masks: &[Option<Mask<'_>>], again: bool| {
            let first = if again { rig.masks() } else { masks.to_vec() };
            let mut binding = Binding::masked(&rig.wires, &rig.points, &first).unwrap();
            if again {
                binding.rebind(&rig.wires, masks).unwrap();
            }
            let mut found = vec![[0.0; 3]; rig.points.len()];
            binding.deform_into(&rig.wires, &rig.blend, &mut found).unwrap();
            bits(&found)
        };
        let expected = of(&dense, false);
        for (masks, again) in [(&sparse, false), (&sparse, true), (&dense, true)] {
            assert_eq!(of(masks, again), expected, "seed {seed}");
        }
    }
}
