//! Free-form deformation against its formula in float64, closed forms and bits.

use proptest::prelude::*;
use wirework_core::{Lattice, LatticeBinding, LatticeError};

const BOX: Lattice = Lattice { min: [-1.0, 2.0, -3.0], max: [2.0, 4.0, 5.0], cells: [1, 1, 1] };

/// A number from 0 to 1 that looks random.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Points in the box, some of them on its faces and corners, and some about it.
fn points(lattice: &Lattice, count: u64, seed: u64) -> Vec<[f32; 3]> {
    let coordinate = |i: u64, a: usize| {
        let x = noise(seed ^ (i * 3 + a as u64));
        let part = match (noise(seed ^ (i * 7 + a as u64 + 1_000_000)) * 10.0) as u32 {
            0 => 0.0,
            1 => 1.0,
            2 => 1.4 * x - 0.2,
            _ => x,
        };
        let (min, max) = (f64::from(lattice.min[a]), f64::from(lattice.max[a]));
        (min * (1.0 - part) + max * part) as f32
    };
    (0..count).map(|i| [0, 1, 2].map(|a| coordinate(i, a))).collect()
}

fn inside(lattice: &Lattice, p: [f32; 3]) -> bool {
    (0..3).all(|a| (lattice.min[a]..=lattice.max[a]).contains(&p[a]))
}

/// `B_i(x)` of a degree by its definition.
fn bernstein(degree: u8, i: usize, x: f64) -> f64 {
    let (l, i) = (i32::from(degree), i32::try_from(i).unwrap());
    let choose = (0..i).fold(1.0, |c, k| c * f64::from(l - k) / f64::from(k + 1));
    choose * x.powi(i) * (1.0 - x).powi(l - i)
}

/// The formula, term by term.
fn brute_force(lattice: &Lattice, controls: &[[f32; 3]], p: [f32; 3], factor: f64) -> [f64; 3] {
    let place = [0, 1, 2].map(|a| {
        (f64::from(p[a]) - f64::from(lattice.min[a]))
            / (f64::from(lattice.max[a]) - f64::from(lattice.min[a]))
    });
    let mut out = p.map(f64::from);
    let [l, m, _] = lattice.size();
    for (index, (now, rest)) in controls.iter().zip(lattice.points()).enumerate() {
        let ijk = [index % l, index / l % m, index / (l * m)];
        let weight: f64 = (0..3).map(|a| bernstein(lattice.cells[a], ijk[a], place[a])).product();
        for a in 0..3 {
            out[a] += factor * weight * (f64::from(now[a]) - f64::from(rest[a]));
        }
    }
    out
}

fn deform(lattice: &Lattice, points: &[[f32; 3]], controls: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut out = vec![[f32::NAN; 3]; points.len()];
    LatticeBinding::new(lattice, points, None).unwrap().deform_into(controls, &mut out).unwrap();
    out
}

fn distance(a: [f32; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (f64::from(a[i]) - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(f32::to_bits) == b.map(f32::to_bits)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_formula_term_by_term(
        cells in prop_oneof![
            4 => (1_u8..5, 1_u8..5, 1_u8..5),
            1 => (prop_oneof![Just(32_u8), Just(31)], 1_u8..3, 1_u8..3),
            1 => (1_u8..3, 1_u8..3, 20_u8..=32),
        ],
        seed in any::<u64>(),
        still in 0.0..1.0_f64,
        masked in any::<bool>(),
    ) {
        let lattice = Lattice { cells: [cells.0, cells.1, cells.2], ..BOX };
        let points = points(&lattice, 2500, seed);
        let mut controls = lattice.points();
        let mut most = 0.0_f64;
        for (i, c) in controls.iter_mut().enumerate() {
            if noise(seed ^ (i as u64 * 17)) >= still {
                for (a, x) in c.iter_mut().enumerate() {
                    let by = 4.0 * noise(seed ^ (i as u64 * 5 + a as u64 + 77)) - 2.0;
                    most = most.max(by.abs());
                    *x += by as f32;
                }
            }
        }
        let mask: Vec<f32> = (0..points.len() as u64).map(|i| noise(seed ^ (i + 9)) as f32).collect();
        let mask = masked.then_some(mask.as_slice());
        let binding = LatticeBinding::new(&lattice, &points, mask).unwrap();
        let mut out = vec![[f32::NAN; 3]; points.len()];
        binding.deform_into(&controls, &mut out).unwrap();
        let mut outside = 0;
        for (i, (&p, &now)) in points.iter().zip(&out).enumerate() {
            if inside(&lattice, p) {
                let exact = brute_force(&lattice, &controls, p, mask.map_or(1.0, |m| f64::from(m[i])));
                // Rounding of place, of about three times the degree many products, and of the result.
                let degree = f64::from(cells.0.max(cells.1).max(cells.2));
                let bound = 6e-8 * (6.0 + (6.0 + 4.0 * degree) * most * 1.8);
                prop_assert!(distance(now, exact) <= bound, "{p:?}: {now:?}, {exact:?}");
            } else {
                outside += 1;
                prop_assert!(same_bits(p, now), "{p:?} lies outside and moved to {now:?}");
            }
        }
        prop_assert!(outside > 0);
        prop_assert_eq!(binding.outside(), outside);
    }

    #[test]
    fn affine_motions_are_reproduced(
        cells in (1_u8..=32, 1_u8..6, 1_u8..6),
        numbers in prop::array::uniform12(-2.0_f64..2.0),
        seed in any::<u64>(),
    ) {
        let lattice = Lattice { cells: [cells.0, cells.1, cells.2], ..BOX };
        let affine = |p: [f32; 3]| {
            let p = p.map(f64::from);
            [0, 1, 2].map(|a| {
                let row = &numbers[a * 4..a * 4 + 4];
                row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]
            })
        };
        let controls: Vec<[f32; 3]> = lattice.points().into_iter().map(|p| affine(p).map(|c| c as f32)).collect();
        let points = points(&lattice, 300, seed);
        for (&p, now) in points.iter().zip(deform(&lattice, &points, &controls)) {
            if inside(&lattice, p) {
                // The diagonal is 8.8, the controls reach to 24; 1e-5 is well under 2e-5 of the diagonal.
                prop_assert!(distance(now, affine(p)) < 2e-5 * 8.8, "{p:?}: {now:?}, {:?}", affine(p));
            }
        }
    }
}

#[test]
fn one_cell_is_trilinear() {
    let mut controls = BOX.points();
    assert_eq!(controls.len(), 8);
    // X fastest, then Y, then Z.
    assert_eq!(controls[1], [2.0, 2.0, -3.0]);
    assert_eq!(controls[2], [-1.0, 4.0, -3.0]);
    assert_eq!(controls[4], [-1.0, 2.0, 5.0]);
    controls[5][1] += 8.0; // s = 1, t = 0, u = 1
    let points = [[0.5, 2.5, -1.0], [2.0, 2.0, 5.0], [-1.0, 2.0, 5.0], [0.5, 3.0, 1.0]];
    let out = deform(&BOX, &points, &controls);
    let rise = |s: f32, t: f32, u: f32| 8.0 * s * (1.0 - t) * u;
    assert_eq!(out[0], [0.5, 2.5 + rise(0.5, 0.25, 0.25), -1.0]);
    assert_eq!(out[1], [2.0, 10.0, 5.0], "a corner goes with its control point");
    assert!(same_bits(out[2], points[2]), "the weight of another corner is 0");
    assert_eq!(out[3], [0.5, 4.0, 1.0], "an eighth in the middle");
}

#[test]
fn the_corners_of_the_box_are_control_points() {
    let lattice = Lattice { min: [0.1, -1e6, 3.3e-5], max: [0.7, 1e7, 3.4e-5], cells: [3, 7, 32] };
    let points = lattice.points();
    assert_eq!(points.len(), 4 * 8 * 33);
    assert_eq!((points[0], points[points.len() - 1]), (lattice.min, lattice.max));
    assert_eq!(points[3], [0.7, -1e6, 3.3e-5]);
    assert_eq!(LatticeBinding::new(&lattice, &points, None).unwrap().outside(), 0);
}

#[test]
fn what_rests_keeps_its_bits() {
    let lattice = Lattice { min: [-1.0; 3], max: [1.0; 3], cells: [4, 3, 2] };
    let nan = f32::NAN;
    let points = [
        [-0.0, 0.0, -0.0],
        [1.0, -0.0, 0.25],
        [-1.0, 0.3, 0.1],
        [1.000_01, 0.0, 0.0],
        [0.0, nan, 0.0],
        [f32::INFINITY, 0.0, 0.0],
        [f32::MIN_POSITIVE / 8.0, 1.0, 1.0],
    ];
    let binding = LatticeBinding::new(&lattice, &points, None).unwrap();
    assert_eq!((binding.outside(), binding.held()), (3, 4));
    let mut out = [[9.0; 3]; 7];
    binding.deform_into(&lattice.points(), &mut out).unwrap();
    assert!(points.iter().zip(out).all(|(p, q)| same_bits(*p, q)), "all control points rest");

    // The layer at x = 1 moves: what lies at x = −1 has no part in it, and −0 stays −0 across the motion.
    let mut controls = lattice.points();
    controls.iter_mut().filter(|c| c[0] == 1.0).for_each(|c| c[1] += 1.0);
    binding.deform_into(&controls, &mut out).unwrap();
    assert!(same_bits(out[2], points[2]));
    assert_eq!(out[1], [1.0, 1.0, 0.25]);
    assert!(same_bits([out[0][0], 0.0, out[0][2]], [-0.0, 0.0, -0.0]) && out[0][1] == 1.0 / 16.0);
    assert!((3..6).all(|i| same_bits(out[i], points[i])));
}

#[test]
fn points_on_a_face_lie_in_the_box_whatever_rounding_makes_of_the_face() {
    // Faces one and two steps of float32 inside of the points.
    let (min, max) = (0.1_f32, 7.3_f32);
    let lattice = Lattice { min: [min.next_up().next_up(); 3], max: [max.next_down(); 3], cells: [2, 2, 2] };
    let points = [[min; 3], [max, min, max], [min, max * 1.000_01, min], [-1e-30, min, min]];
    let binding = LatticeBinding::new(&lattice, &points, None).unwrap();
    assert_eq!((binding.held(), binding.outside()), (2, 2));
    let controls: Vec<[f32; 3]> = lattice.points().iter().map(|c| [c[0] + 1.0, c[1], c[2]]).collect();
    let mut out = points;
    binding.deform_into(&controls, &mut out).unwrap();
    for (now, p) in out.iter().zip(&points).take(2) {
        assert!((now[0] - p[0] - 1.0).abs() < 1e-6 && now[1..] == p[1..], "{p:?}: {now:?}");
    }
}

#[test]
fn a_factor_of_zero_holds_a_point_and_a_half_moves_it_by_half() {
    let points: Vec<[f32; 3]> = (0..3000).map(|_| [0.5, 3.0, 1.0]).collect();
    let mask: Vec<f32> = (0..3000).map(|i| [0.0, 0.5, 1.0][i % 3]).collect();
    let binding = LatticeBinding::new(&BOX, &points, Some(&mask)).unwrap();
    assert_eq!((binding.outside(), binding.held()), (0, 2000));
    let away = LatticeBinding::new(&BOX, &[[9.0; 3]; 3], Some(&[0.0, 0.5, 1.0])).unwrap();
    assert_eq!((away.outside(), away.held()), (2, 0));
    let controls: Vec<[f32; 3]> = BOX.points().iter().map(|c| [c[0], c[1], c[2] + 2.0]).collect();
    let mut out = points.clone();
    binding.deform_into(&controls, &mut out).unwrap();
    assert!(out.iter().zip(&mask).all(|(p, f)| *p == [0.5, 3.0, 1.0 + 2.0 * f]));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let lattice = Lattice { cells: [3, 5, 4], ..BOX };
    let points = points(&lattice, 20_000, 5);
    let controls: Vec<[f32; 3]> =
        lattice.points().iter().map(|c| [c[0] + c[1].sin(), c[1] * 1.1, c[2] - c[0] * c[1]]).collect();
    let at = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| deform(&lattice, &points, &controls))
    };
    let one = at(1);
    assert!(at(3).iter().zip(&one).all(|(a, b)| same_bits(*a, *b)));
    // Nor does it matter who the neighbours are.
    let alone = deform(&lattice, &points[777..778], &controls);
    assert!(same_bits(alone[0], one[777]));
}

#[test]
fn bad_lattices_and_lengths_are_refused() {
    let check = |lattice: Lattice| lattice.check().unwrap_err();
    let flat = Lattice { max: [2.0, 2.0, 5.0], ..BOX };
    assert_eq!(check(flat), LatticeError::NoVolume { axis: 1, min: 2.0, max: 2.0 });
    assert_eq!(check(Lattice { max: [2.0, 4.0, f32::NAN], ..BOX }), LatticeError::NotFinite);
    assert_eq!(check(Lattice { min: [f32::NEG_INFINITY; 3], ..BOX }), LatticeError::NotFinite);
    assert_eq!(check(Lattice { cells: [1, 1, 0], ..BOX }), LatticeError::Cells { axis: 2, cells: 0 });
    assert_eq!(check(Lattice { cells: [33, 1, 1], ..BOX }), LatticeError::Cells { axis: 0, cells: 33 });
    assert!(LatticeBinding::new(&flat, &[], None).is_err());
    let huge = Lattice { min: [-f32::MAX; 3], max: [f32::MAX; 3], cells: [2, 2, 2] };
    assert_eq!(huge.points()[13], [0.0; 3], "the sides of a box may be longer than the largest number");
    assert_eq!(deform(&huge, &[[1.0; 3]], &huge.points()), [[1.0; 3]]);

    let points = [[0.0; 3]; 2];
    let count = |what, expected, found| LatticeError::Count { what, expected, found };
    let short = LatticeBinding::new(&BOX, &points, Some(&[1.0]));
    assert_eq!(short.unwrap_err(), count("factors", 2, 1));
    let binding = LatticeBinding::new(&BOX, &points, None).unwrap();
    assert_eq!(binding.deform_into(&[], &mut [[0.0; 3]; 2]), Err(count("control points", 8, 0)));
    assert_eq!(binding.deform_into(&BOX.points(), &mut [[0.0; 3]]), Err(count("points", 2, 1)));
}
