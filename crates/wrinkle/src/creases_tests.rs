use glam::DVec3;
use wirework_surface::{Mesh, NearestError, cuboid, grid, sphere, tube};

use wirework_core::{Curve, CurveKind};

use super::*;
use crate::test_support::{lay, wires};

fn wave() -> Curve {
    Curve::bspline(3, vec![[-0.8, 0.3, 0.0], [-0.3, 0.1, 0.6], [0.3, 0.3, -0.6], [0.8, 0.2, 0.0]]).unwrap()
}

fn circle(radius: f32, height: f32) -> Curve {
    let point = |i: i32| {
        let angle = i as f32 / 12.0 * std::f32::consts::TAU;
        [radius * angle.cos(), height, radius * angle.sin()]
    };
    Curve::new(CurveKind::CatmullRom, true, (0..12).map(point).collect()).unwrap()
}

/// `(R, W − R)` along a wire.
fn along(wire: &Wire) -> Vec<(DVec3, DVec3)> {
    let pose = wire.reference.posed(wire.pose.clone()).unwrap();
    (0..=997)
        .map(|i| {
            let u = i as f32 / 997.0;
            let r = wide(wire.reference.point(u));
            (r, wide(pose.point(u)) - r)
        })
        .collect()
}

/// Off the surface by little, and the crest along the given normal by `height` to 3 %.
fn assert_crest(wire: &Wire, height: f64, off: impl Fn(DVec3) -> f64, normal: impl Fn(DVec3) -> DVec3) {
    for (r, rise) in along(wire) {
        assert!(off(r).abs() <= 0.01 * f64::from(wire.radius), "{r} is {} off", off(r));
        let exact = normal(r) * height;
        assert!(rise.distance(exact) <= 0.03 * height, "{rise} for {exact} at {r}");
    }
}

#[test]
fn crests_stand_on_a_flat_grid() {
    let mesh = grid([2.0; 2], [7, 5], [0.0, 1.0, 0.0]).unwrap();
    for thickness in [0.01, 0.08, 0.5] {
        let settings = Wrinkle { thickness: Keyed::Constant(thickness), ..Wrinkle::drawn(vec![wave()]) };
        let wires = wires(&lay(&mesh, &settings).unwrap(), 0.0);
        assert_eq!((wires.len(), wires[0].radius, wires[0].rotation), (1, thickness, 0.0));
        assert_crest(&wires[0], 0.05, |r| r.y, |_| DVec3::Y);
        // Over the drawn curve: dropping was straight down.
        for i in 0..=40 {
            let p = wide(wires[0].reference.point(i as f32 / 40.0));
            let nearest = (0..=2000)
                .map(|j| wide(wave().point(j as f32 / 2000.0)) * DVec3::new(1.0, 0.0, 1.0))
                .map(|q| q.distance(p))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest < 2e-3 + 0.01 * f64::from(thickness), "{nearest}");
        }
    }
}

#[test]
fn crests_stand_off_a_tube_radially() {
    let mesh = tube([0.0; 3], [0.0, 2.0, 0.0], 0.4, 64, 33, true).unwrap();
    let spiral: Vec<_> = (0..10)
        .map(|i| i as f32 / 9.0)
        .map(|x| [0.5 * (4.0 * x).cos(), 0.4 + x, 0.5 * (4.0 * x).sin()])
        .collect();
    let settings = Wrinkle::drawn(vec![Curve::bspline(3, spiral).unwrap(), circle(0.45, 1.0)]);
    let wires = wires(&lay(&mesh, &settings).unwrap(), 0.0);
    assert!(wires[1].reference.closed());
    let radial = |r: DVec3| DVec3::new(r.x, 0.0, r.z).normalize();
    for wire in &wires {
        // The tube's facets lie up to 0.0005 inside its radius.
        assert_crest(wire, 0.05, |r| (r - radial(r) * 0.3997 - DVec3::Y * r.y).length() - 0.0003, radial);
    }
}

#[test]
fn meshes_of_one_surface_give_one_crease() {
    let settings = Wrinkle { thickness: Keyed::Constant(0.2), ..Wrinkle::drawn(vec![circle(0.9, 0.6)]) };
    let on = |segments| wires(&lay(&sphere([0.0; 3], 1.0, segments).unwrap(), &settings).unwrap(), 0.0);
    let (coarse, fine) = (on([48, 24]), on([200, 100]));
    for ((a, rise_a), (b, rise_b)) in along(&coarse[0]).into_iter().zip(along(&fine[0])) {
        assert!(a.distance(b) < 0.01 && rise_a.distance(rise_b) < 0.003);
    }
}

#[test]
fn a_crease_goes_over_the_edge_of_a_box() {
    let mesh = cuboid([-1.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
    let over = Curve::polyline(vec![[0.0, 1.0, 0.1], [1.0, 1.0, 0.1], [1.0, 0.0, 0.1]]).unwrap();
    let wires = wires(&lay(&mesh, &Wrinkle::drawn(vec![over])).unwrap(), 0.0);
    let mut last = DVec3::NEG_X;
    for (r, rise) in along(&wires[0]) {
        let off = r.x.max(r.y) - 1.0;
        assert!(off.abs() < 0.05 * f64::from(wires[0].radius), "{r} is {off} off");
        assert!((rise.length() - 0.05).abs() < 0.03 * 0.05, "{}", rise.length());
        assert!(r.distance(last) < 0.02 || last == DVec3::NEG_X, "{r} after {last}");
        last = r;
    }
}

#[test]
fn the_front_runs_from_the_first_end() {
    let mesh = grid([2.0; 2], [8, 8], [0.0, 1.0, 0.0]).unwrap();
    let line = Curve::polyline(vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]).unwrap();
    let keys = Keyed::keys(vec![(0.0, 0.0), (1.0, 1.0)], false).unwrap();
    let settings = Wrinkle { propagation: keys, ..Wrinkle::drawn(vec![line]) };
    let creases = lay(&mesh, &settings).unwrap();
    let at = |seconds| along(&wires(&creases, seconds)[0]);
    assert!(at(0.0).iter().all(|(_, rise)| *rise == DVec3::ZERO));
    assert!(at(1.0).iter().all(|(_, rise)| (rise.y - 0.05).abs() < 1e-6));
    assert!(at(0.001).iter().all(|(_, rise)| rise.y.abs() < 0.001));
    for p in [0.1, 0.5, 0.8] {
        for (r, rise) in at(p) {
            let x = r.x + 0.5;
            assert!(x > p || (rise.y - 0.05).abs() < 0.03 * 0.05, "{} at {x} of {p}", rise.y);
            assert!(x < p + 0.13 || rise == DVec3::ZERO, "{rise} at {x} of {p}");
            assert!(rise.y >= 0.0 && rise.y <= 0.05 + 1e-6);
        }
    }
    let settings = Wrinkle { resistance: 1.0, propagation: Keyed::Constant(1.0), ..settings };
    let fading = along(&wires(&lay(&mesh, &settings).unwrap(), 0.0)[0]);
    assert!((fading[0].1.y - 0.05).abs() < 1e-6 && fading[997].1.y < 0.3 * 0.05);
    assert!(fading.windows(2).all(|w| w[1].1.y <= w[0].1.y + 1e-9));
}

#[test]
fn references_stay_and_wires_are_reused() {
    let mesh = grid([2.0; 2], [8, 8], [0.0, 1.0, 0.0]).unwrap();
    let keys = |a, b| Keyed::keys(vec![(0.0, a), (1.0, b)], true).unwrap();
    let settings = Wrinkle {
        thickness: keys(0.1, 0.3),
        intensity: keys(0.0, 0.2),
        randomness: 0.5,
        ..Wrinkle::drawn(vec![wave(), wave()])
    };
    let mut creases = lay(&mesh, &settings).unwrap();
    let (start, end) = (wires(&creases, 0.0), wires(&creases, 1.0));
    let mut reused = start.clone();
    reused.push(Wire::new(wave()));
    reused[0].reference = wave();
    creases.wires_at(1.0, &mut reused);
    assert_eq!(reused, end);
    for (a, b) in start.iter().zip(&end) {
        assert_eq!(a.reference, b.reference);
        assert_eq!((a.radius, b.radius), (0.1, 0.3));
        assert_eq!(a.pose, a.reference.points());
    }
}

#[test]
fn stiffness_is_the_exponent_of_the_fold() {
    let mesh = grid([2.0; 2], [2, 2], [0.0, 1.0, 0.0]).unwrap();
    for (stiffness, q) in [(0.0, 1.0), (0.5, 2.0), (1.0, 4.0)] {
        let settings = Wrinkle { stiffness, ..Wrinkle::drawn(vec![wave()]) };
        assert_eq!(wires(&lay(&mesh, &settings).unwrap(), 0.0)[0].density, Density::Fold(q));
    }
}

#[test]
fn what_makes_no_crease_is_refused() {
    let mesh = grid([2.0; 2], [8, 8], [0.0, 1.0, 0.0]).unwrap();
    let error = |curves| lay(&mesh, &Wrinkle::drawn(curves)).unwrap_err();
    let line = |a, b| Curve::polyline(vec![a, b]).unwrap();
    assert_eq!(error(vec![]), WrinkleError::NoCurves);
    let far = line([0.0, 2.0, 0.0], [1.0, 2.0, 0.0]);
    assert!(matches!(error(vec![wave(), far]), WrinkleError::TooFar { curve: 1, .. }));
    let post = line([0.0; 3], [0.0, 1.0, 0.0]);
    assert_eq!(error(vec![wave(), post]), WrinkleError::Collapsed { curve: 1 });
    let point = Curve::polyline(vec![[0.0; 3]]).unwrap();
    assert_eq!(error(vec![point]), WrinkleError::Collapsed { curve: 0 });
    let empty = lay(&Mesh::default(), &Wrinkle::drawn(vec![wave()])).unwrap_err();
    assert_eq!(empty, WrinkleError::Surface(NearestError::NoFaces));
    let flat = Mesh { positions: mesh.positions.iter().map(|p| [p[0], 0.0, 0.0]).collect(), ..mesh.clone() };
    assert_eq!(lay(&flat, &Wrinkle::drawn(vec![wave()])).unwrap_err(), WrinkleError::NoArea);
}

#[test]
fn creases_beyond_all_measure_are_refused_at_once() {
    let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
    let settings = |count, thickness| Wrinkle {
        thickness: Keyed::Constant(thickness),
        ..Wrinkle::drawn(vec![wave(); count])
    };
    let start = std::time::Instant::now();
    let error = lay(&mesh, &settings(2000, 1e-30)).unwrap_err();
    assert_eq!(error, WrinkleError::TooFine { thickness: 1e-30, needed: 2000 * 1024 });
    assert!(error.to_string().contains("262144"));
    assert!(start.elapsed().as_secs() < 2);
    assert_eq!(lay(&mesh, &settings(2, 1e-30)).unwrap().len(), 2);
    assert_eq!(lay(&mesh, &settings(300, 0.1)).unwrap().len(), 300);
}

#[test]
fn settings_out_of_range_are_named() {
    let mesh = grid([2.0; 2], [2, 2], [0.0, 1.0, 0.0]).unwrap();
    let base = || Wrinkle::drawn(vec![wave()]);
    let nan = f32::NAN;
    for (settings, name) in [
        (Wrinkle { thickness: Keyed::Constant(0.0), ..base() }, "thickness"),
        (Wrinkle { thickness: Keyed::Constant(nan), ..base() }, "thickness"),
        (Wrinkle { intensity: Keyed::Constant(f32::INFINITY), ..base() }, "intensity"),
        (Wrinkle { stiffness: 1.5, ..base() }, "stiffness"),
        (Wrinkle { resistance: -0.1, ..base() }, "resistance"),
        (Wrinkle { randomness: nan, ..base() }, "randomness"),
        (Wrinkle { propagation: Keyed::Constant(1.01), ..base() }, "propagation"),
    ] {
        let error = lay(&mesh, &settings).unwrap_err();
        assert!(matches!(error, WrinkleError::Value { field, .. } if field == name), "{error} for {name}");
    }
}

/// Where points go when the wires of a moment deform them.
fn deform(points: &[[f32; 3]], wires: &[Wire]) -> Vec<[f32; 3]> {
    let mut out = points.to_vec();
    let mut binding = wirework_core::Binding::new(wires, points).unwrap();
    binding.deform_into(wires, &Blend::default(), &mut out).unwrap();
    out
}

#[test]
fn the_deformed_surface_has_its_crest() {
    // Vertices lie on the line z = 0; the crease runs along it.
    let mesh = grid([2.0; 2], [40, 80], [0.0, 1.0, 0.0]).unwrap();
    let line = Curve::polyline(vec![[-0.8, 0.1, 0.0], [0.8, 0.2, 0.0]]).unwrap();
    for stiffness in [0.0, 0.5, 1.0] {
        let settings = Wrinkle { stiffness, ..Wrinkle::drawn(vec![line.clone()]) };
        let out = deform(&mesh.positions, &wires(&lay(&mesh, &settings).unwrap(), 0.0));
        for (p, q) in mesh.positions.iter().zip(&out) {
            if p[2] == 0.0 && p[0].abs() < 0.8 {
                assert!((q[1] - 0.05).abs() < 0.03 * 0.05, "{} at {p:?}", q[1]);
            }
            if p[2].abs() > 0.0801 || p[0].abs() > 0.8801 {
                assert_eq!(p, q);
            }
            assert!(q[1] >= 0.0 && q[1] <= 0.0501);
        }
    }
}

#[test]
fn points_of_a_ball_rise_along_its_radius() {
    let mesh = sphere([0.0; 3], 1.0, [160, 80]).unwrap();
    let settings = Wrinkle { stiffness: 0.5, ..Wrinkle::drawn(vec![circle(1.1, 0.3)]) };
    let wires = wires(&lay(&mesh, &settings).unwrap(), 0.0);
    let on_crease: Vec<[f32; 3]> = (0..100).map(|i| wires[0].reference.point(i as f32 / 100.0)).collect();
    for (p, q) in on_crease.iter().zip(deform(&on_crease, &wires)) {
        let rise = wide(q) - wide(*p);
        assert!(rise.distance(wide(*p).normalize() * 0.05) < 0.03 * 0.05, "{rise} at {p:?}");
    }
    // The nearest vertices are within half an edge of the crease and lose that much of the fold.
    let out = deform(&mesh.positions, &wires);
    let highest = out.iter().map(|&q| wide(q).length()).fold(0.0, f64::max);
    assert!((1.045..1.0505).contains(&highest), "{highest}");
}

/// The shared assets, where present: a real mesh with uneven triangles.
#[test]
fn a_crease_holds_its_height_on_a_scanned_body() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/body/spot.obj");
    let Ok(text) = std::fs::read_to_string(path) else {
        eprintln!("skipped: the shared assets are not here");
        return;
    };
    let mut mesh = Mesh::default();
    for line in text.lines() {
        let words = || line.split_whitespace().skip(1);
        if line.starts_with("v ") {
            let c: Vec<f32> = words().map(|w| w.parse().unwrap()).collect();
            mesh.positions.push([c[0], c[1], c[2]]);
        } else if line.starts_with("f ") {
            for word in words() {
                let position = word.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                mesh.corners.push(wirework_surface::Corner { position, uv: None, normal: None });
            }
            mesh.face_ends.push(mesh.corners.len() as u32);
        }
    }
    let ground = {
        let triangles = mesh.triangles().unwrap();
        Ground::new(&SurfaceView { positions: &mesh.positions, triangles: &triangles }).unwrap()
    };
    // Along a flank and round the belly.
    let flank = Curve::bspline(3, vec![[0.6, 0.1, -0.4], [0.6, 0.2, 0.0], [0.6, 0.0, 0.3]]).unwrap();
    let belly = circle(0.7, 0.0);
    for (stiffness, most) in [(0.0, 1026), (0.3, 500), (1.0, 300)] {
        let settings = Wrinkle { stiffness, ..Wrinkle::drawn(vec![flank.clone(), belly.clone()]) };
        for wire in wires(&lay(&mesh, &settings).unwrap(), 0.0) {
            assert!(wire.pose.len() <= most, "{} control points at {stiffness}", wire.pose.len());
            for (r, rise) in along(&wire) {
                let left = wire.density.at(ground.distance(r) / f64::from(wire.radius));
                let height = rise.length() * left / 0.05;
                assert!((height - 1.0).abs() < 0.03, "{height} of the height at {r}, stiffness {stiffness}");
            }
        }
    }
}

#[test]
fn moved_creases_are_those_of_the_rest_moved() {
    let mesh = tube([0.0; 3], [0.0, 2.0, 0.0], 0.4, 24, 16, true).unwrap();
    let triangles = mesh.triangles().unwrap();
    let ring = circle(0.4, 1.0);
    let line = Curve::bspline(3, vec![[0.4, 0.3, 0.0], [0.4, 0.8, 0.1], [0.4, 1.2, -0.1], [0.4, 1.7, 0.0]]);
    let laid = lay(&mesh, &Wrinkle::drawn(vec![ring, line.unwrap()])).unwrap();
    // A quarter turn about y, and a step that is large against the tube.
    let turn = |p: DVec3| DVec3::new(p.z, p.y, -p.x);
    let step = DVec3::new(30.0, -20.0, 5.0);
    let positions: Vec<[f32; 3]> =
        mesh.positions.iter().map(|&p| (turn(wide(p)) + step).as_vec3().to_array()).collect();
    let moved = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| {
        let mut moved = laid.clone();
        moved.at(0.0, Some(&SurfaceView { positions, triangles })).map(|()| moved)
    };
    let there = moved(&positions, &triangles).unwrap();
    for (before, after) in wires(&laid, 0.0).iter().zip(&wires(&there, 0.0)) {
        assert_eq!(before.reference.points().len(), after.reference.points().len());
        for ((r, rise), (moved_r, moved_rise)) in along(before).into_iter().zip(along(after)) {
            assert!(moved_r.distance(turn(r) + step) < 1e-5, "{moved_r} for {r}");
            assert!(moved_rise.distance(turn(rise)) < 1e-5, "{moved_rise} for {rise}");
        }
    }
    let mut broken = positions.clone();
    broken.fill([f32::NAN; 3]);
    let broken = moved(&broken, &triangles);
    assert!(matches!(broken, Err(WrinkleError::Surface(NearestError::Vertex { .. }))));
    let flat = moved(&vec![[0.0; 3]; positions.len()], &triangles);
    assert!(matches!(flat, Err(WrinkleError::NoNormal { curve: 0 })));
    assert!(moved(&positions, &[]).is_err());
}
