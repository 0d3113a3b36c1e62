use std::f64::consts::TAU;

use glam::DVec3;
use wirework_core::{Binding, Curve, Keyed, Mask, Wire};
use wirework_surface::{Mesh, grid, sphere, tube};

use crate::{
    Branches, Creases, Curtain, Drawn, Layout, Motion, Pattern, SurfaceView, Wrinkle, WrinkleError,
    WrinkleWarning, creases,
};

const LAYOUT: Layout = Layout { center: [0.0; 3], direction: [1.0, 0.0, 0.0], size: [1.0, 1.0], creases: 5 };

fn lay(mesh: &Mesh, settings: &Wrinkle) -> Result<Creases, WrinkleError> {
    let triangles = mesh.triangles().unwrap();
    creases(&SurfaceView { positions: &mesh.positions, triangles: &triangles }, settings)
}

fn wires(creases: &Creases, seconds: f64) -> Vec<Wire> {
    let mut wires = vec![];
    creases.clone().wires_at(seconds, &mut wires);
    wires
}

fn plane(cells: u32) -> Mesh {
    grid([2.0; 2], [cells; 2], [0.0, 1.0, 0.0]).unwrap()
}

/// The points of a mesh as the creases of a moment move them.
fn deform(mesh: &Mesh, creases: &Creases, seconds: f64) -> Vec<[f32; 3]> {
    let (wires, near) = (wires(creases, seconds), creases.near());
    let masks: Vec<_> =
        near.iter().map(|n| Some(Mask::Sparse { points: &n.vertices, factors: &n.factors })).collect();
    let mut out = mesh.positions.clone();
    let mut binding = Binding::masked(&wires, &mesh.positions, &masks).unwrap();
    binding.deform_into(&wires, &creases.blend(), &mut out).unwrap();
    out
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// Local maxima of a section higher than `least`, its neighbours at least so far below.
fn crests(section: &[f64], least: f64) -> usize {
    let flat: Vec<f64> = section.to_vec();
    (1..flat.len() - 1)
        .filter(|&i| flat[i] > least && flat[i] > flat[i - 1] && flat[i] >= flat[i + 1])
        .count()
}

#[test]
fn parallel_creases_lie_where_they_are_to() {
    let settings = Wrinkle::new(Pattern::Tangential(LAYOUT));
    let wires = wires(&lay(&plane(64), &settings).unwrap(), 0.0);
    assert_eq!(wires.len(), 5);
    for (i, wire) in wires.iter().enumerate() {
        // Across is normal × direction: −z.
        let z = -((i as f64 + 0.5) / 5.0 - 0.5);
        for k in 0..=20 {
            let u = k as f32 / 20.0;
            let expected = DVec3::new(f64::from(u) - 0.5, 0.0, z);
            assert!(wide(wire.reference.point(u)).distance(expected) < 1e-5, "crease {i} at {u}");
        }
    }
}

#[test]
fn a_section_has_a_crest_for_each_crease_of_the_height_asked_for() {
    let mesh = plane(200);
    for creases in [1, 3, 8] {
        let layout = Layout { creases, ..LAYOUT };
        let laid = lay(
            &mesh,
            &Wrinkle { thickness: Keyed::Constant(0.06), ..Wrinkle::new(Pattern::Tangential(layout)) },
        );
        let out = deform(&mesh, &laid.unwrap(), 0.0);
        for x in [-0.4, 0.0, 0.3] {
            let section: Vec<f64> =
                out.iter().filter(|p| (p[0] - x).abs() < 0.004).map(|p| f64::from(p[1])).collect();
            assert_eq!(crests(&section, 0.02), creases as usize, "{creases} at {x}");
            let highest = section.iter().copied().fold(0.0, f64::max);
            assert!((highest - 0.05).abs() < 0.03 * 0.05, "{highest}");
        }
    }
}

#[test]
fn creases_wrap_round_a_tube_and_stand_off_it() {
    let radius = 0.4;
    let mesh = tube([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], radius, 128, 121, false).unwrap();
    // Round the tube, and nearly closed there.
    let layout = Layout { center: [0.5, 0.0, 0.0], direction: [0.0, 0.0, 1.0], size: [2.4, 0.8], creases: 4 };
    let laid = lay(&mesh, &Wrinkle::new(Pattern::Tangential(layout))).unwrap();
    assert_eq!(laid.warnings(), []);
    for (i, wire) in wires(&laid, 0.0).iter().enumerate() {
        let y = (i as f64 + 0.5) / 4.0 * 0.8 - 0.4;
        for k in 0..=40 {
            let u = k as f32 / 40.0;
            let (r, w) = (
                wide(wire.reference.point(u)),
                wide(wire.reference.posed(wire.pose.clone()).unwrap().point(u)),
            );
            let angle = -(f64::from(u) - 0.5) * 2.4 / f64::from(radius);
            let exact = DVec3::new(angle.cos(), 0.0, -angle.sin()) * f64::from(radius);
            // Normal × direction points down for a normal +X and a direction +Z.
            assert!(r.distance(exact - DVec3::Y * y) < 0.004, "{i} {u}: {r} {exact} {y}");
            let off = w - r;
            assert!(off.distance(exact.normalize() * 0.05) < 0.002, "{off} at {r}");
        }
    }
}

#[test]
fn radial_creases_start_along_the_direction_and_turn_towards_across() {
    let layout = Layout { creases: 6, ..LAYOUT };
    let laid = lay(&plane(40), &Wrinkle::new(Pattern::Radial(layout, Branches::default()))).unwrap();
    let wires = wires(&laid, 0.0);
    assert_eq!(wires.len(), 6);
    for (i, wire) in wires.iter().enumerate() {
        let angle = TAU * i as f64 / 6.0;
        let ahead = DVec3::new(angle.cos(), 0.0, -angle.sin());
        assert!(wide(wire.reference.point(1.0)).distance(ahead * 0.5) < 1e-5);
        let inner = wide(wire.reference.point(0.0));
        assert!(inner.distance(ahead * inner.length()) < 1e-5 && inner.length() <= 0.05);
    }
}

#[test]
fn branches_leave_their_stems_left_and_right() {
    let layout = Layout { creases: 3, ..LAYOUT };
    let branches = Branches { count: 2, depth: 2 };
    let settings = Wrinkle::new(Pattern::Radial(layout, branches));
    assert_eq!(settings.crease_count(), 3 * (1 + 2 + 4));
    let wires = wires(&lay(&plane(40), &settings).unwrap(), 0.0);
    assert_eq!(wires.len(), 21);
    let (start, end) =
        (|i: usize| wide(wires[i].reference.point(0.0)), |i: usize| wide(wires[i].reference.point(1.0)));
    // Stem, its first branch, that one's two, its second branch, ..
    for (parent, child, side) in [(0, 1, 1.0), (0, 4, -1.0), (1, 2, 1.0), (1, 3, -1.0)] {
        let stem = end(parent) - start(parent);
        let x = (start(child) - start(parent)).dot(stem) / stem.length_squared();
        assert!((start(child) - start(parent) - stem * x).length() < 1e-5 && x > 0.2 && x < 0.8);
        let left = DVec3::Y.cross(stem);
        assert!((end(child) - start(child)).dot(left) * side > 0.0);
        assert!(end(child).length() < 0.5);
    }
}

#[test]
fn branches_of_a_curtain_stay_on_their_stems() {
    // An upright sheet; the stems hang from the middle of it.
    let mesh = grid([2.0; 2], [40; 2], [0.0, 0.0, 1.0]).unwrap();
    let layout = Layout { direction: [0.3, -1.0, 0.0], size: [1.6, 1.0], creases: 3, ..LAYOUT };
    let curtain = Curtain { wind: Keyed::Constant([2.0, 0.0, 6.0]), ..Curtain::default() };
    for stiffness in [0.0, 0.4] {
        let settings = Wrinkle {
            motion: Motion::Curtain(Box::new(Curtain { stiffness, ..curtain.clone() })),
            ..Wrinkle::new(Pattern::Radial(layout, Branches { count: 2, depth: 2 }))
        };
        let laid = lay(&mesh, &settings).unwrap();
        let rest = wires(&laid, 0.0);
        for seconds in [0.0, 0.4, 1.1] {
            let wires = wires(&laid, seconds);
            for (stem, branch) in [(0, 1), (0, 4), (1, 2), (4, 6), (7, 8)] {
                let from = rest[branch].reference.point(0.0);
                let foot = rest[stem].reference.closest(from).unwrap();
                let posed =
                    |wire: &Wire, u: f32| wide(wire.reference.posed(wire.pose.clone()).unwrap().point(u));
                let off = posed(&wires[stem], foot.u).distance(posed(&wires[branch], 0.0));
                assert!(off < 0.01 * 0.08, "{branch} is {off} off {stem} at {seconds}");
            }
        }
    }
}

#[test]
fn rings_are_as_far_from_the_centre_as_they_are_to() {
    let layout = Layout { center: [0.1, 0.3, -0.2], creases: 4, ..LAYOUT };
    let wires = wires(&lay(&plane(50), &Wrinkle::new(Pattern::Ripple(layout))).unwrap(), 0.0);
    assert_eq!(wires.len(), 4);
    for (i, wire) in wires.iter().enumerate() {
        assert!(wire.reference.closed());
        for k in 0..40 {
            let r = wide(wire.reference.point(k as f32 / 40.0)).distance(DVec3::new(0.1, 0.0, -0.2));
            assert!((r - 0.125 * (i + 1) as f64).abs() < 5e-4, "ring {i}: {r}");
        }
    }
}

#[test]
fn a_ripple_reaches_round_a_tube() {
    let radius = 0.3;
    let mesh = tube([0.0, -2.0, 0.0], [0.0, 2.0, 0.0], radius, 64, 161, false).unwrap();
    let size = (f64::from(radius) * TAU) as f32;
    let layout =
        Layout { center: [0.3, 0.0, 0.0], size: [size, 1.0], creases: 3, direction: [0.0, 1.0, 0.0] };
    let laid =
        lay(&mesh, &Wrinkle { thickness: Keyed::Constant(0.06), ..Wrinkle::new(Pattern::Ripple(layout)) })
            .unwrap();
    let out = deform(&mesh, &laid, 0.0);
    // The far side is half the circumference away, where the last ring touches itself.
    let risen = |p: [f32; 3]| f64::from(p[0].hypot(p[2])) - f64::from(radius);
    let far = out.iter().filter(|p| p[1].abs() < 1e-3 && p[0] < -0.299).map(|p| risen(*p));
    let highest = far.fold(0.0, f64::max);
    assert!((highest - 0.05).abs() < 0.003, "{highest}");
    let near =
        out.iter().filter(|p| p[1].abs() < 1e-3 && p[0] > 0.299).map(|p| risen(*p)).fold(0.0, f64::max);
    assert!(near < 0.01, "{near}");
}

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

#[test]
fn travelling_folds_keep_their_height_and_speed_and_stop_at_a_border() {
    let mesh = plane(64);
    let layout = Layout { creases: 2, size: [0.6, 0.4], ..LAYOUT };
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity: [0.05, 0.1] },
        thickness: Keyed::Constant(0.1),
        ..Wrinkle::new(Pattern::Tangential(layout))
    };
    let mut creases = lay(&mesh, &settings).unwrap();
    assert!(creases.moves());
    for seconds in [0.0, 1.0, 3.5] {
        creases.at(seconds, None).unwrap();
        for (i, wire) in wires(&creases, seconds).iter().enumerate() {
            let middle = wide(wire.reference.point(0.5));
            let z = 0.2 * (0.5 - i as f64) - 0.1 * seconds;
            assert!(middle.distance(DVec3::new(0.05 * seconds, 0.0, z)) < 1e-5, "{middle} at {seconds}");
            assert!(wire.pose.iter().all(|p| (p[1] - 0.05).abs() < 1e-6));
        }
    }
    // The border is at z = −1: the first stops there, the second a thickness behind.
    let mut before = [f64::NAN; 2];
    for i in 0..=600 {
        let seconds = f64::from(i) * 0.05;
        creases.at(seconds, None).unwrap();
        let now = [0, 1].map(|i| wide(wires(&creases, seconds)[i].reference.point(0.5)).z);
        for (a, b) in before.into_iter().zip(now) {
            assert!(a.is_nan() || (b <= a + 1e-9 && a - b < 0.0051), "{a} to {b}");
        }
        before = now;
    }
    assert!((before[1] + 1.0).abs() < 1e-5 && (before[0] + 0.9).abs() < 1e-5, "{before:?}");
    assert!((wide(wires(&creases, 30.0)[0].reference.point(1.0)).x - 1.0).abs() < 1e-5);
}

#[test]
fn drawn_creases_travel_along_themselves_and_across() {
    let mesh = plane(64);
    let line = Curve::polyline(vec![[-0.5, 0.2, 0.3], [0.5, 0.2, 0.3]]).unwrap();
    let with = |velocity| {
        let settings = Wrinkle {
            motion: Motion::Travelling { velocity },
            thickness: Keyed::Constant(0.1),
            ..Wrinkle::drawn(vec![line.clone()])
        };
        let mut creases = lay(&mesh, &settings).unwrap();
        move |seconds: f64| {
            creases.at(seconds, None).unwrap();
            let wire = wires(&creases, seconds).remove(0);
            assert!(wire.pose.iter().all(|p| (p[1] - 0.05).abs() < 1e-6));
            [0.0, 1.0].map(|u| wide(wire.reference.point(u)))
        }
    };
    let near = |found: [DVec3; 2], expected: [[f64; 2]; 2]| {
        for (found, [x, z]) in found.into_iter().zip(expected) {
            assert!(found.distance(DVec3::new(x, 0.0, z)) < 1e-5, "{found} for {x}, {z}");
        }
    };
    // Across is normal × along: −z.
    let mut across = with([0.0, 0.2]);
    near(across(2.0), [[-0.5, -0.1], [0.5, -0.1]]);
    near(across(30.0), [[-0.5, -1.0], [0.5, -1.0]]);
    let mut along = with([0.1, 0.0]);
    near(along(3.0), [[-0.2, 0.3], [0.8, 0.3]]);
    near(along(60.0), [[0.0, 0.3], [1.0, 0.3]]);
    let mut back = with([-0.1, 0.0]);
    near(back(2.0), [[-0.7, 0.3], [0.3, 0.3]]);
    near(back(60.0), [[-1.0, 0.3], [0.0, 0.3]]);
}

#[test]
fn drawn_creases_follow_the_keys_of_their_curves() {
    let mesh = plane(64);
    let curve = Curve::polyline(vec![[-0.5, 0.1, 0.0], [0.5, 0.1, 0.0]]).unwrap();
    let keys = vec![(0.0, curve.points().to_vec()), (1.0, vec![[-0.5, 0.1, 0.4], [0.5, 0.1, 0.8]])];
    let drawn = Drawn { curve, points: Some(Keyed::keys(keys, false).unwrap()) };
    let mut creases = lay(&mesh, &Wrinkle::new(Pattern::Drawn(vec![drawn]))).unwrap();
    assert!(creases.moves());
    for (seconds, z) in [(0.0, [0.0, 0.0]), (0.5, [0.2, 0.4]), (2.0, [0.4, 0.8])] {
        creases.at(seconds, None).unwrap();
        let wire = wires(&creases, seconds).remove(0);
        for (u, z) in [0.0, 1.0].into_iter().zip(z) {
            let p = wire.reference.point(u);
            assert!((f64::from(p[2]) - z).abs() < 1e-4 && p[1].abs() < 1e-6, "{p:?} at {seconds}");
        }
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
fn travelling_rings_come_in_again_without_a_step() {
    let layout = Layout { creases: 3, ..LAYOUT };
    let settings = Wrinkle {
        motion: Motion::Travelling { velocity: [0.2, 0.0] },
        thickness: Keyed::Constant(0.08),
        ..Wrinkle::new(Pattern::Ripple(layout))
    };
    let mesh = plane(80);
    for seed in 0..4 {
        let mut jittered = lay(&mesh, &Wrinkle { randomness: 1.0, seed, ..settings.clone() }).unwrap();
        let mut before = deform(&mesh, &jittered, 0.0);
        for i in 1..=400 {
            jittered.at(f64::from(i) * 0.01, None).unwrap();
            let now = deform(&mesh, &jittered, f64::from(i) * 0.01);
            let pairs = before.iter().zip(&now).map(|(a, b)| wide(*a).distance(wide(*b)));
            let step = pairs.fold(0.0, f64::max);
            assert!(step < 0.006, "seed {seed}, step {i}: {step}");
            before = now;
        }
    }
    let mut creases = lay(&mesh, &settings).unwrap();
    let mut at = |seconds: f64| {
        creases.at(seconds, None).unwrap();
        deform(&mesh, &creases, seconds)
    };
    let still = lay(&mesh, &Wrinkle { motion: Motion::Anchored, ..settings.clone() }).unwrap();
    let rest = deform(&mesh, &still, 0.0);
    let worst = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.iter().zip(b).map(|(a, b)| wide(*a).distance(wide(*b))).fold(0.0, f64::max)
    };
    assert!(worst(&rest, &at(0.0)) < 1e-5);
    let mut before = at(0.0);
    for i in 1..=250 {
        let now = at(f64::from(i) * 0.02);
        assert!(worst(&before, &now) < 0.01, "step {i}: {}", worst(&before, &now));
        before = now;
    }
    // A cycle is one ring longer than the pattern.
    assert!(worst(&rest, &at((0.5 + 0.5 / 3.0) / 0.2)) < 1e-4);
}

#[test]
fn compression_takes_up_that_part_of_the_length() {
    let mesh = grid([2.0, 2.0], [4, 2000], [0.0, 1.0, 0.0]).unwrap();
    for compression in [0.03, 0.1, 0.25] {
        let layout = Layout { creases: 8, size: [1.9, 1.6], ..LAYOUT };
        let settings = Wrinkle {
            compression: Some(compression),
            thickness: Keyed::Constant(0.11),
            stiffness: 0.5,
            ..Wrinkle::new(Pattern::Tangential(layout))
        };
        let out = deform(&mesh, &lay(&mesh, &settings).unwrap(), 0.0);
        // From crest to crest over six folds.
        let section: Vec<DVec3> =
            out.iter().filter(|p| p[0] == 0.0 && p[2].abs() <= 0.6001).map(|p| wide(*p)).collect();
        let folded: f64 = section.windows(2).map(|w| w[0].distance(w[1])).sum();
        let taken = 1.0 - 1.2 / folded;
        assert!((taken / f64::from(compression) - 1.0).abs() < 0.02, "{compression}: {taken}");
    }
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
fn rings_that_a_border_cuts_are_arcs_up_to_it() {
    let layout = Layout { center: [0.7, 0.0, 0.0], size: [1.2, 1.0], creases: 3, ..LAYOUT };
    let laid = lay(&plane(80), &Wrinkle::new(Pattern::Ripple(layout))).unwrap();
    let wires = wires(&laid, 0.0);
    assert_eq!(wires.len(), 3);
    assert!(laid.warnings().contains(&WrinkleWarning::Border { ends: 4 }));
    for (wire, r) in wires.iter().zip([0.2, 0.4, 0.6]) {
        assert_eq!(wire.reference.closed(), r < 0.3);
        for k in 0..=50 {
            let p = wide(wire.reference.point(k as f32 / 50.0));
            assert!((p.distance(DVec3::new(0.7, 0.0, 0.0)) - r).abs() < 2e-3, "{p}");
        }
        if r > 0.3 {
            assert!(
                (wire.reference.point(0.0)[0] - 1.0).abs() < 1e-4
                    && (wire.reference.point(1.0)[0] - 1.0).abs() < 1e-4
            );
        }
    }
}

#[test]
fn rings_say_what_cuts_them() {
    let layout = Layout { center: [-0.3, 0.0, 0.0], size: [1.4, 1.0], creases: 1, ..LAYOUT };
    let ripple = Wrinkle::new(Pattern::Ripple(layout));
    let said = |mesh: &Mesh| {
        let coarse = |w: &WrinkleWarning| matches!(w, WrinkleWarning::Coarse { .. });
        let mut all = lay(mesh, &ripple).unwrap().warnings().to_vec();
        all.retain(|w| !coarse(w));
        all
    };
    assert_eq!(said(&plane(40)), []);
    // A fin stands on the sheet along x = 0.2, where three faces meet.
    let mut mesh = plane(40);
    let rows: Vec<u32> = (0..mesh.positions.len() as u32)
        .filter(|&v| (mesh.positions[v as usize][0] - 0.2).abs() < 1e-4)
        .collect();
    for pair in rows.windows(2) {
        let top = mesh.positions.len() as u32;
        let [x, _, z] = mesh.positions[pair[0] as usize];
        mesh.positions.push([x, 0.5, z]);
        let corner = |position| wirework_surface::Corner { position, uv: None, normal: None };
        mesh.corners.extend([pair[0], pair[1], top].map(corner));
        mesh.face_ends.push(mesh.corners.len() as u32);
    }
    assert_eq!(said(&mesh), [WrinkleWarning::NonManifold { ends: 2 }]);
    // The border of the sheet.
    let layout = Layout { center: [0.7, 0.0, 0.0], size: [1.2, 1.0], creases: 1, ..LAYOUT };
    let cut = Wrinkle::new(Pattern::Ripple(layout));
    assert!(lay(&plane(80), &cut).unwrap().warnings().contains(&WrinkleWarning::Border { ends: 2 }));
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

#[test]
fn the_front_of_a_ripple_runs_outwards() {
    let keys = Keyed::keys(vec![(0.0, 0.0), (1.0, 1.0)], false).unwrap();
    let layout = Layout { creases: 4, ..LAYOUT };
    let laid =
        lay(&plane(80), &Wrinkle { propagation: keys, ..Wrinkle::new(Pattern::Ripple(layout)) }).unwrap();
    let risen = |seconds| wires(&laid, seconds).iter().filter(|w| w.pose[0][1] > 0.04).count();
    assert_eq!([0.0, 0.3, 0.6, 0.8, 1.0].map(risen), [0, 1, 2, 3, 4]);
}
