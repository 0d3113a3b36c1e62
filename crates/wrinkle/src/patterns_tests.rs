use wirework_core::{Binding, Curve, Keyed, Wire};
use wirework_surface::{Mesh, sphere, tube};

use crate::ground::wide;
use crate::test_support::{LAYOUT, deform, lay, plane, wires};
use crate::{Branches, Drawn, Layout, Motion, Pattern, Wrinkle, WrinkleError, WrinkleWarning};

#[test]
fn the_same_preset_gives_the_same_surface_on_a_finer_mesh() {
    for (name, pattern) in [
        ("tangential", Pattern::Tangential(Layout { center: [0.842, 0.337, 0.421], ..LAYOUT })),
        (
            "radial",
            Pattern::Radial(
                Layout { center: [0.842, 0.337, 0.421], ..LAYOUT },
                Branches { count: 2, depth: 1 },
            ),
        ),
        ("ripple", Pattern::Ripple(Layout { center: [0.842, 0.337, 0.421], ..LAYOUT })),
    ] {
        let settings = Wrinkle { thickness: Keyed::Constant(0.1), ..Wrinkle::new(pattern) };
        let on = |segments| wires(&lay(&sphere([0.0; 3], 1.0, segments).unwrap(), &settings).unwrap(), 0.0);
        let (coarse, fine) = (on([128, 64]), on([256, 128]));
        assert_eq!(coarse.len(), fine.len());
        // What a point of the ball feels of each wire.
        let points: Vec<[f32; 3]> = sphere([0.0; 3], 1.0, [180, 90]).unwrap().positions;
        let of = |wires: &[Wire]| {
            let mut out = points.clone();
            let mut binding = Binding::new(wires, &points).unwrap();
            binding.deform_into(wires, &settings.blend, &mut out).unwrap();
            out
        };
        let worst = of(&coarse)
            .into_iter()
            .zip(of(&fine))
            .map(|(a, b)| wide(a).distance(wide(b)))
            .fold(0.0, f64::max);
        assert!(worst < 0.02 * 0.05, "{name}: {worst}");
    }
}

/// The farthest that any reference point goes in a hundredth of a second, in ten seconds.
fn fastest(mesh: &Mesh, pattern: Pattern, velocity: [f32; 2]) -> f64 {
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity },
        thickness: Keyed::Constant(0.3),
        ..Wrinkle::new(pattern)
    };
    let mut creases = lay(mesh, &settings).unwrap();
    let mut ends = |seconds: f64| {
        creases.at(seconds, None).unwrap();
        let ends = |wire: &Wire| [0.0, 1.0].map(|u| wide(wire.reference.point(u)));
        wires(&creases, seconds).iter().map(ends).collect::<Vec<_>>()
    };
    let (mut before, mut most) = (ends(0.0), 0.0_f64);
    for i in 1..=1000 {
        let now = ends(f64::from(i) * 0.01);
        let pairs = before.iter().zip(&now).flat_map(|(a, b)| a.iter().zip(b));
        most = pairs.map(|(a, b)| a.distance(*b)).fold(most, f64::max);
        before = now;
    }
    most
}

#[test]
fn no_fold_jumps_where_it_meets_a_border() {
    let mesh = plane(40);
    let narrow = Layout { creases: 3, size: [0.5, 0.1], ..LAYOUT };
    let drawn =
        || Pattern::Drawn(vec![Curve::polyline(vec![[-0.3, 0.0, 0.1], [0.3, 0.0, 0.1]]).unwrap().into()]);
    for velocity in [[0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]] {
        for (name, pattern) in [("tangential", Pattern::Tangential(narrow)), ("drawn", drawn())] {
            let most = fastest(&mesh, pattern, velocity);
            assert!(most < 0.00501, "{name} {velocity:?}: {most}");
        }
    }
    // Radial creases are cut by the border as their centre nears it: the inner ends tell.
    let radial = Pattern::Radial(Layout { creases: 1, size: [0.2, 1.0], ..LAYOUT }, Branches::default());
    let most = fastest(&mesh, radial, [-0.5, 0.0]);
    assert!(most < 0.00501, "radial: {most}");
}

#[test]
fn creases_that_shrink_to_nothing_later_are_left_out_with_a_word() {
    // A disc: the chord gets shorter and is gone at the rim.
    let mut mesh = plane(60);
    for p in &mut mesh.positions {
        let (square, round) = (p[0].abs().max(p[2].abs()), p[0].hypot(p[2]));
        if round > 0.0 {
            (p[0], p[2]) = (p[0] * square / round, p[2] * square / round);
        }
    }
    let layout = Layout { creases: 1, size: [3.0, 0.4], ..LAYOUT };
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity: [0.0, 0.5] },
        thickness: Keyed::Constant(0.1),
        ..Wrinkle::new(Pattern::Tangential(layout))
    };
    let mut creases = lay(&mesh, &settings).unwrap();
    for i in 0..=40 {
        creases.at(f64::from(i) * 0.1, None).unwrap();
        deform(&mesh, &creases, f64::from(i) * 0.1);
    }
    let gone = |w: &&WrinkleWarning| matches!(w, WrinkleWarning::Gone { .. });
    assert!(creases.is_empty() && creases.warnings().iter().filter(gone).count() == 1);
    // A curve that is keyed away from the surface.
    let curve = Curve::polyline(vec![[-0.3, 0.0, 0.0], [0.3, 0.0, 0.0]]).unwrap();
    let keys = vec![(0.0, curve.points().to_vec()), (1.0, vec![[-0.3, 9.0, 0.0], [0.3, 9.0, 0.0]])];
    let drawn = Drawn { curve, points: Some(Keyed::keys(keys, false).unwrap()) };
    let mut creases = lay(&plane(20), &Wrinkle::new(Pattern::Drawn(vec![drawn]))).unwrap();
    creases.at(0.9, None).unwrap();
    assert!(creases.is_empty() && wires(&creases, 0.9).is_empty());
    assert_eq!(creases.warnings().iter().filter(gone).count(), 1);
    creases.at(0.0, None).unwrap();
    assert_eq!(creases.len(), 1);
}

#[test]
fn only_the_sheet_that_a_crease_lies_on_moves() {
    // A thin flat hose: front and back are 0.04 apart, the fold is twice as thick.
    let mut mesh = tube([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.5, 128, 65, false).unwrap();
    mesh.positions.iter_mut().for_each(|p| p[2] *= 0.04);
    let layout =
        Layout { center: [0.0, 0.0, 0.02], direction: [0.0, 1.0, 0.0], size: [1.0, 0.2], creases: 2 };
    let laid = lay(&mesh, &Wrinkle::new(Pattern::Tangential(layout))).unwrap();
    let out = deform(&mesh, &laid, 0.0);
    let mut front = 0;
    for (p, q) in mesh.positions.iter().zip(&out) {
        if p[2] < 0.0 {
            assert_eq!(p, q);
        }
        front += usize::from(p != q);
    }
    assert!(front > 100);
}

#[test]
fn patterns_that_do_not_fit_say_so() {
    let mesh = plane(20);
    let with = |layout| lay(&mesh, &Wrinkle::new(Pattern::Tangential(layout)));
    let off = with(Layout { center: [0.0, 1.5, 0.0], ..LAYOUT }).unwrap_err();
    assert!(matches!(off, WrinkleError::CenterOff { size: 1.0, .. }), "{off}");
    assert_eq!(with(Layout { creases: 0, ..LAYOUT }).unwrap_err(), WrinkleError::NoCreases);
    assert!(matches!(
        with(Layout { creases: u32::MAX, ..LAYOUT }).unwrap_err(),
        WrinkleError::TooMany { .. }
    ));
    let branches = Branches { count: 9, depth: u32::MAX };
    let many = lay(&mesh, &Wrinkle::new(Pattern::Radial(LAYOUT, branches))).unwrap_err();
    assert!(matches!(many, WrinkleError::TooMany { .. }));
    for size in [[0.0, 1.0], [1.0, -1.0], [f32::NAN, 1.0], [1.0, f32::INFINITY]] {
        let error = with(Layout { size, ..LAYOUT }).unwrap_err();
        assert!(matches!(error, WrinkleError::Value { field: "size", .. }), "{error}");
    }
    let warnings = |layout| with(layout).unwrap().warnings().to_vec();
    let coarse = |w: &WrinkleWarning| matches!(w, WrinkleWarning::Coarse { .. });
    let but_coarse = |layout| warnings(layout).into_iter().filter(|w| !coarse(w)).collect::<Vec<_>>();
    assert_eq!(but_coarse(Layout { direction: [0.0, 1.0, 0.0], ..LAYOUT }), [WrinkleWarning::Upright]);
    assert_eq!(but_coarse(Layout { size: [4.0, 1.0], ..LAYOUT }), [WrinkleWarning::Border { ends: 10 }]);
    let wide = but_coarse(Layout { size: [1.0, 4.0], ..LAYOUT });
    assert_eq!(wide, [WrinkleWarning::Outside { outside: 2, creases: 5 }]);
    assert!(warnings(LAYOUT).iter().any(coarse) && !warnings(LAYOUT).is_empty());
}

#[test]
fn jitter_stays_in_its_bounds_and_follows_its_seed() {
    let layout = Layout { creases: 8, ..LAYOUT };
    for pattern in [
        Pattern::Tangential(layout),
        Pattern::Radial(layout, Branches { count: 1, depth: 1 }),
        Pattern::Ripple(layout),
    ] {
        let with = |randomness, seed| {
            let settings = Wrinkle { randomness, seed, ..Wrinkle::new(pattern.clone()) };
            wires(&lay(&plane(40), &settings).unwrap(), 0.0)
        };
        assert_eq!(with(0.0, 1), with(0.0, 2));
        assert_eq!(with(0.7, 1), with(0.7, 1));
        assert_ne!(with(0.7, 1), with(0.7, 2));
        for wire in with(1.0, 5) {
            let heights = wire.pose.iter().map(|p| p[1]);
            assert!(heights.clone().all(|h| (0.0249..0.0501).contains(&h)));
            assert!(wire.reference.points().iter().all(|p| p[0].hypot(p[2]) < 0.75));
        }
    }
}
