use wirework_core::Curve;

use super::*;

type Moved = Vec<Vec<DVec3>>;

/// Straight ropes from places along x, 2 long, of 40 points.
fn lines(count: usize) -> Vec<Vec<DVec3>> {
    let line = |x: f64| (0..40).map(|i| DVec3::new(x, 3.0 - 2.0 * f64::from(i) / 39.0, 0.1)).collect();
    (0..count).map(|i| line(i as f64 / 10.0)).collect()
}

fn rail(keys: &[(f64, [f32; 3])]) -> Rail {
    let at = |shift: [f32; 3]| [0.0_f32, 2.0].map(|x| [x + shift[0], 3.0 + shift[1], shift[2]]).to_vec();
    let keys = keys.iter().map(|(time, shift)| (*time, at(*shift))).collect();
    let curve = Curve::polyline(at([0.0; 3])).unwrap();
    Rail { curve, points: Keyed::keys(keys, true).unwrap() }
}

/// Pulled along and across, in wind.
fn windy() -> Curtain {
    Curtain {
        rail: Some(rail(&[(0.0, [0.0; 3]), (0.5, [0.6, 0.1, 0.3]), (1.0, [0.0; 3])])),
        wind: Keyed::Constant([0.5, 0.0, 2.0]),
        ..Curtain::default()
    }
}

fn at(ropes: &mut Ropes, seconds: f64) -> Moved {
    let mut out = Vec::new();
    ropes.at(seconds, &mut out);
    out
}

#[test]
fn ropes_are_at_rest_at_0_s_whatever_pulls() {
    let mut bent = lines(3);
    bent[1].iter_mut().enumerate().for_each(|(i, p)| p.z += (i as f64).sin());
    let mut ropes = Ropes::new(&bent, &[], &windy(), 1);
    for seconds in [0.0, -3.0, f64::NAN, f64::NEG_INFINITY] {
        let moved = at(&mut ropes, seconds);
        assert!(moved.iter().flatten().all(|d| *d == DVec3::ZERO));
        assert!(moved.iter().all(|rope| rope.len() == 40));
    }
    assert!(at(&mut ropes, 0.1).iter().flatten().any(|d| *d != DVec3::ZERO));
}

#[test]
fn a_curtain_that_hangs_stays_to_the_bit() {
    let curtain = Curtain { damping: 0.0, settle: 5.0, ..Curtain::default() };
    let mut ropes = Ropes::new(&lines(2), &[], &curtain, 0);
    for seconds in [0.0, 0.013, 1.0, 9.7] {
        assert!(at(&mut ropes, seconds).iter().flatten().all(|d| *d == DVec3::ZERO));
    }
}

#[test]
fn a_moment_does_not_depend_on_what_was_asked_for_before() {
    let mut bent = lines(3);
    bent[1].iter_mut().enumerate().for_each(|(i, p)| p.z += 0.02 * (i as f64).sin());
    let curtain = Curtain { stiffness: 0.3, settle: 0.5, ..windy() };
    let fresh = |seconds: f64| at(&mut Ropes::new(&bent, &[], &curtain, 7), seconds);
    let mut ropes = Ropes::new(&bent, &[], &curtain, 7);
    for seconds in [0.3, 0.301, 1.7, 1.2, 1.2, 0.0, 2.0, 1.999] {
        assert_eq!(at(&mut ropes, seconds), fresh(seconds), "at {seconds}");
    }
}

#[test]
fn frames_of_24_and_60_a_second_agree_where_they_meet() {
    let run = |fps: u32| -> Vec<Moved> {
        let mut ropes = Ropes::new(&lines(2), &[], &windy(), 7);
        (0..=2 * fps).map(|i| at(&mut ropes, f64::from(i) / f64::from(fps))).collect()
    };
    let (film, smooth) = (run(24), run(60));
    for twelfth in 0..=24 {
        assert_eq!(film[2 * twelfth], smooth[5 * twelfth]);
    }
}

#[test]
fn tops_follow_the_rail() {
    let curtain = windy();
    let track = curtain.rail.clone().unwrap();
    let mut ropes = Ropes::new(&lines(5), &[], &curtain, 0);
    for i in 0..100 {
        let seconds = f64::from(i) * 0.0137;
        // Every place of this rail moves alike.
        let exact = wide(track.points.at(seconds)[0]) - wide(track.points.at(0.0)[0]);
        for rope in at(&mut ropes, seconds) {
            assert!(rope[0].distance(exact) < 1e-6, "{} for {exact}", rope[0]);
        }
    }
}

#[test]
fn each_top_follows_its_own_place() {
    // The rail is pulled apart: a place moves by as much as it is along.
    let curve = Curve::polyline(vec![[0.0, 3.0, 0.0], [1.0, 3.0, 0.0]]).unwrap();
    let wider = vec![[0.0, 3.0, 0.0], [2.0, 3.0, 0.0]];
    let points = Keyed::keys(vec![(0.0, curve.points().to_vec()), (1.0, wider)], false).unwrap();
    let curtain = Curtain { rail: Some(Rail { curve, points }), ..Curtain::default() };
    let moved = at(&mut Ropes::new(&lines(11), &[], &curtain, 0), 1.0);
    for (i, rope) in moved.iter().enumerate() {
        assert!(rope[0].distance(DVec3::X * i as f64 / 10.0) < 1e-6);
    }
}

#[test]
fn lengths_hold_at_every_moment() {
    let cut = rail(&[(0.0, [0.0; 3]), (0.5, [0.0; 3]), (0.500_001, [2.0, 0.0, 0.0]), (1.0, [2.0, 1.0, 0.5])]);
    let (lines, curtain) = (lines(3), Curtain { rail: Some(cut), ..windy() });
    let mut ropes = Ropes::new(&lines, &[], &curtain, 0);
    for i in 0..1000 {
        let moved = at(&mut ropes, f64::from(i) * 0.0021);
        for (line, moved) in lines.iter().zip(&moved) {
            let place = |i: usize| line[i] + moved[i];
            for i in 1..line.len() {
                let ratio = place(i).distance(place(i - 1)) / line[i].distance(line[i - 1]);
                assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
            }
        }
    }
}

#[test]
fn a_cut_takes_the_ropes_along() {
    let cut = rail(&[(0.0, [0.0; 3]), (0.5, [0.0; 3]), (0.500_001, [50.0, 0.0, 0.0])]);
    let moved =
        at(&mut Ropes::new(&lines(1), &[], &Curtain { rail: Some(cut), ..Curtain::default() }, 0), 0.51);
    assert!(moved[0].iter().all(|d| (d.x - 50.0).abs() < 0.2), "{:?}", moved[0]);
}

#[test]
fn a_mirrored_curtain_moves_mirrored() {
    let mirror = |p: DVec3| DVec3::new(p.x, p.y, -p.z);
    let flip = |p: &[f32; 3]| [p[0], p[1], -p[2]];
    let bent: Vec<Vec<DVec3>> = lines(3)
        .into_iter()
        .map(|line| line.into_iter().map(|p| p + DVec3::Z * 0.1 * (4.0 * p.y + p.x).sin()).collect())
        .collect();
    let curtain = Curtain { stiffness: 0.3, ..windy() };
    let track = curtain.rail.clone().unwrap();
    let points = track.points.map(|points| points.iter().map(flip).collect());
    let mirrored_rail = Rail { curve: track.curve, points };
    let mirrored = Curtain { rail: Some(mirrored_rail), wind: curtain.wind.map(flip), ..curtain.clone() };
    let lines: Vec<Vec<DVec3>> = bent.iter().map(|l| l.iter().copied().map(mirror).collect()).collect();
    for seconds in [0.2, 1.0, 3.0] {
        let one = at(&mut Ropes::new(&bent, &[], &curtain, 3), seconds);
        let other = at(&mut Ropes::new(&lines, &[], &mirrored, 3), seconds);
        for (a, b) in one.iter().flatten().zip(other.iter().flatten()) {
            assert!(mirror(*a).distance(*b) < 1e-9, "{a} and {b}");
        }
    }
}

#[test]
fn a_seed_is_its_gusts() {
    let seeded = |seed| at(&mut Ropes::new(&lines(2), &[], &windy(), seed), 2.0);
    assert_eq!(seeded(4), seeded(4));
    assert_ne!(seeded(4), seeded(5));
    let ropes = seeded(4);
    assert_ne!(ropes[0], ropes[1]);
}

#[test]
fn with_settle_it_hangs_at_0_s() {
    let slanted: Vec<DVec3> = (0..20).map(|i| DVec3::new(0.05, -0.05, 0.02) * f64::from(i)).collect();
    let length = slanted[19].length();
    let curtain = Curtain { settle: 20.0, ..Curtain::default() };
    let moved = at(&mut Ropes::new(std::slice::from_ref(&slanted), &[], &curtain, 0), 0.0);
    assert!((slanted[19] + moved[0][19]).distance(DVec3::NEG_Y * length) < 1e-4 * length);
    // And is at rest.
    let later = at(&mut Ropes::new(std::slice::from_ref(&slanted), &[], &curtain, 0), 1.0);
    assert!(later[0][19].distance(moved[0][19]) < 1e-4 * length);
}

#[test]
fn odd_lines_are_ropes_too() {
    let point = DVec3::new(0.3, 3.0, 0.0);
    let double: Vec<DVec3> = lines(1)[0].iter().flat_map(|p| [*p, *p]).collect();
    let fine: Vec<DVec3> =
        (0..5000).map(|i| point + DVec3::new(1.0, -1.0, 0.0) * f64::from(i) / 5000.0).collect();
    let there_and_back = vec![point, point - DVec3::Y, point, point - DVec3::Y];
    let all = [vec![], vec![point], vec![point; 4], double, fine, there_and_back];
    let mut ropes = Ropes::new(&all, &[], &windy(), 0);
    for seconds in [0.0, 0.4, 1.0, 3.0] {
        let moved = at(&mut ropes, seconds);
        for (line, moved) in all.iter().zip(&moved) {
            assert_eq!(line.len(), moved.len());
            assert!(moved.iter().all(|d| d.is_finite()));
        }
        assert!(moved[1][0] == moved[2][3] && moved[1][0].distance(moved[4][0]) < 1e-6);
        // Equal points stay together, and what lies between nodes moves evenly.
        assert!(moved[3].chunks(2).all(|pair| pair[0] == pair[1]));
        assert!(moved[4].windows(2).all(|w| w[0].distance(w[1]) < 1e-3));
    }
}

#[test]
fn no_time_takes_for_ever() {
    let mut ropes = Ropes::new(&[vec![DVec3::ZERO, DVec3::X]], &[], &Curtain::default(), 0);
    assert_eq!(at(&mut ropes, 1e9), at(&mut ropes, LAST));
    assert_eq!(at(&mut ropes, f64::INFINITY), at(&mut ropes, LAST));
}

#[test]
fn a_look_between_two_frames_costs_the_steps_between_them() {
    let mut bent = lines(1);
    bent[0].iter_mut().enumerate().for_each(|(i, p)| p.z += 0.02 * (i as f64).sin());
    let Ropes { mut trees, forces } = Ropes::new(&bent, &[], &windy(), 1);
    let walked = |tree: &mut Tree, steps: u64| {
        let made = tree.walk(steps, &forces);
        let mut other = Ropes::new(&bent, &[], &windy(), 1).trees.remove(0);
        other.walk(steps, &forces);
        assert_eq!(tree.ropes[0].rope.nodes, other.ropes[0].rope.nodes, "after {steps}");
        made
    };
    let tree = &mut trees[0];
    // Frames, and between them what is asked for late: as a baker does that looks closer.
    for (steps, made) in
        [(20, 20), (40, 20), (60, 20), (30, 10), (25, 5), (35, 5), (80, 20), (50, 10), (90, 10)]
    {
        assert_eq!(walked(tree, steps), made, "to {steps}");
    }
    // Few are remembered.
    for step in 91..110 {
        walked(tree, step);
    }
    assert_eq!(tree.known.len(), REMEMBERED);
    assert_eq!(walked(tree, 40), 40);
}

#[test]
fn ropes_that_hang_from_ropes_stay_on_them() {
    let stem = lines(1).remove(0);
    let (a, b) = (stem[12], stem[13]);
    let from = a.lerp(b, 0.3);
    let side: Vec<DVec3> = (0..20).map(|i| from + DVec3::new(0.04, -0.02, 0.01) * f64::from(i)).collect();
    let twig: Vec<DVec3> = (0..9).map(|i| side[10] + DVec3::new(0.0, 0.0, 0.03) * f64::from(i)).collect();
    let all = [lines(2).remove(1), stem.clone(), side.clone(), twig, lines(4).remove(3)];
    let hook = |rope, point, below| Some(Hook { rope, point, below });
    let hooks = [None, None, hook(1, 12, 0.3), hook(2, 10, 0.0), None];
    for curtain in [windy(), Curtain { stiffness: 0.3, settle: 1.0, ..windy() }] {
        let mut ropes = Ropes::new(&all, &hooks, &curtain, 3);
        for seconds in [0.0, 0.1, 0.1003, 0.7, 0.31, 2.0] {
            let moved = at(&mut ropes, seconds);
            assert!(moved[2][0].distance(moved[1][12].lerp(moved[1][13], 0.3)) < 1e-12, "at {seconds}");
            assert!(moved[3][0].distance(moved[2][10]) < 1e-12, "at {seconds}");
            for i in 1..20 {
                let ratio = (side[i] + moved[2][i]).distance(side[i - 1] + moved[2][i - 1])
                    / side[i].distance(side[i - 1]);
                assert!((ratio - 1.0).abs() < 1e-9, "{ratio} at {seconds}");
            }
            assert_eq!(moved, at(&mut Ropes::new(&all, &hooks, &curtain, 3), seconds));
            // What hangs from a rope does not pull at it.
            let alone = at(&mut Ropes::new(&all[..2], &[], &curtain, 3), seconds);
            assert_eq!(moved[..2], alone);
        }
    }
}
