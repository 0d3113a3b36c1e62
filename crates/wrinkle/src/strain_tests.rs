use wirework_core::Keyed;
use wirework_surface::{Mesh, grid, tube};

use crate::{Creases, Layout, Pattern, Strain, SurfaceView, Wrinkle, WrinkleError, creases};

use super::*;

const LAYOUT: Layout = Layout { center: [0.0; 3], direction: [0.0, 0.0, 1.0], size: [1.0, 1.0], creases: 4 };

fn lay(mesh: &Mesh, layout: Layout, strain: Strain) -> Creases {
    let settings = Wrinkle {
        drive: Some(strain),
        thickness: Keyed::Constant(0.1),
        ..Wrinkle::new(Pattern::Tangential(layout))
    };
    let triangles = mesh.triangles().unwrap();
    creases(&SurfaceView { positions: &mesh.positions, triangles: &triangles }, &settings).unwrap()
}

fn map(mesh: &Mesh, f: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    mesh.positions.iter().map(|p| f(*p)).collect()
}

/// The highest point of all wires.
fn highest(creases: &Creases, seconds: f64) -> f32 {
    let mut wires = Vec::new();
    creases.clone().wires_at(seconds, &mut wires);
    wires.iter().flat_map(|wire| &wire.pose).fold(0.0, |high, p| high.max(p[1]))
}

#[test]
fn compression_is_read_across_the_crease_only() {
    let mesh = grid([2.0, 2.0], [23, 17], [0.0, 1.0, 0.0]).unwrap();
    // Creases run along z, so that x is across.
    let laid = lay(&mesh, LAYOUT, Strain::default());
    let read = |now: Vec<[f32; 3]>| laid.compression(&now);
    let all = |readings: Vec<f32>, expected: f32| {
        assert!(!readings.is_empty());
        for reading in readings {
            assert!((reading - expected).abs() < 1e-5, "{reading} for {expected}");
        }
    };
    all(read(mesh.positions.clone()), 0.0);
    all(read(map(&mesh, |[x, y, z]| [0.8 * x, y, z])), 0.2);
    all(read(map(&mesh, |[x, y, z]| [1.3 * x, y, z])), -0.3);
    all(read(map(&mesh, |[x, y, z]| [x, y, 0.5 * z])), 0.0);
    // Turned, carried off, and bent without a change of length.
    all(read(map(&mesh, |[x, y, z]| [z + 3.0, 0.9 * x, y])), 0.1);
    // Chords are shorter than arcs by little.
    let bent = read(map(&mesh, |[x, _, z]| [0.5 * (2.0 * x).sin(), 0.5 - 0.5 * (2.0 * x).cos(), z]));
    assert!(bent.iter().all(|reading| (0.0..0.003).contains(reading)), "{bent:?}");
}

impl Creases {
    fn at_once(&self, now: &[[f32; 3]]) -> Self {
        let mut driven = self.clone();
        driven.record(0.0, vec![self.compression(now)]);
        driven
    }
}

#[test]
fn creases_rise_where_the_surface_is_pushed_together() {
    let mesh = grid([2.0, 2.0], [40, 40], [0.0, 1.0, 0.0]).unwrap();
    let laid = lay(&mesh, LAYOUT, Strain::default());
    assert!(laid.is_driven());
    assert_eq!(highest(&laid, 0.0), 0.0);
    let height = |x: f32| highest(&laid.at_once(&map(&mesh, |p| [x * p[0], p[1], p[2]])), 0.0);
    assert_eq!([height(1.2), height(1.0), height(0.985)], [0.0; 3]);
    assert!((height(0.7) - 0.05).abs() < 1e-6);
    assert!((height(0.89) - 0.025).abs() < 1e-3);
    // Only the half that is compressed.
    let half = laid.at_once(&map(&mesh, |[x, y, z]| [if x > 0.0 { 0.6 * x } else { x }, y, z]));
    let mut wires = Vec::new();
    half.clone().wires_at(0.0, &mut wires);
    for wire in &wires {
        let risen = wire.pose[0][1] > 0.049;
        assert_eq!(risen, wire.reference.points()[0][0] > 0.0, "{:?}", wire.reference.points()[0]);
    }
}

#[test]
fn folds_rise_and_fade_along_their_crease_within_their_thickness() {
    let profile = |cells: u32| {
        let mesh = grid([2.0, 2.0], [cells; 2], [0.0, 1.0, 0.0]).unwrap();
        // Gauges that see little: a short stretch, and from there on all of it.
        let strain = Strain { radius: Some(0.02), ..Strain::default() };
        let laid = lay(&mesh, Layout { size: [1.6, 1.0], ..LAYOUT }, strain);
        let stretch = |z: f32| (-0.33..-0.3).contains(&z) || z > 0.2;
        let now = map(&mesh, |[x, y, z]| [if stretch(z) { 0.6 * x } else { x }, y, z]);
        let mut wires = Vec::new();
        laid.at_once(&now).wires_at(0.0, &mut wires);
        let wire = &wires[0];
        wire.reference.points().iter().zip(&wire.pose).map(|(r, p)| (r[2], p[1])).collect::<Vec<_>>()
    };
    let (coarse, fine) = (profile(100), profile(260));
    for heights in [&coarse, &fine] {
        // No steeper than the whole height in a thickness, and neither gone nor full where compressed for less than that.
        for pair in heights.windows(2) {
            let slope = (pair[1].1 - pair[0].1).abs() / (pair[1].0 - pair[0].0).abs();
            assert!(slope < 1.05 * 0.05 / 0.1, "{slope} at {}", pair[0].0);
        }
        let most = heights.iter().filter(|(z, _)| *z < -0.1).map(|(_, h)| *h).fold(0.0, f32::max);
        assert!((0.005..0.03).contains(&most), "{most}");
        assert!(heights.iter().filter(|(z, _)| *z > 0.32).all(|(_, h)| (h - 0.05).abs() < 1e-5));
    }
}

#[test]
fn a_bent_tube_wrinkles_on_its_inside() {
    // The bend: about z at (0.6, 0), from straight to a right angle between y = −0.3 and 0.3.
    for [sides, rings] in [[24, 41], [64, 121], [65, 90]] {
        let mesh = tube([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.3, sides, rings, false).unwrap();
        let round = Layout { direction: [0.0, 0.0, 1.0], size: [1.8, 0.6], creases: 5, ..LAYOUT };
        let on = |x: f32| lay(&mesh, Layout { center: [x, 0.0, 0.0], ..round }, Strain::default());
        let bent = map(&mesh, |[x, y, z]| {
            let angle = y.clamp(-0.3, 0.3) / 0.6 * std::f32::consts::FRAC_PI_2;
            let rest = y - y.clamp(-0.3, 0.3);
            let (sin, cos) = angle.sin_cos();
            let r = 0.6 - x;
            [0.6 - r * cos + rest * sin, r * sin + rest * cos, z]
        });
        let heights = |laid: &Creases| {
            let driven = laid.at_once(&bent);
            let mut wires = Vec::new();
            driven.clone().wires_at(0.0, &mut wires);
            let nodes = wires.iter().flat_map(|w| w.reference.points().iter().zip(&w.pose));
            nodes.map(|(r, p)| (r[0], wide(*p).distance(wide(*r)))).collect::<Vec<_>>()
        };
        let (inside, outside) = (heights(&on(0.3)), heights(&on(-0.3)));
        let middle: Vec<f64> = inside.iter().filter(|(x, _)| *x > 0.28).map(|(_, h)| *h).collect();
        assert!(middle.iter().all(|h| *h > 0.025), "{sides} {rings}: {middle:?}");
        assert!(
            outside.iter().filter(|(x, _)| *x < -0.1).all(|(_, h)| *h < 1e-4),
            "{sides} {rings}: {outside:?}"
        );
    }
}

#[test]
fn readings_hardly_depend_on_the_triangles() {
    let reading = |cells: [u32; 2]| {
        let mesh = grid([2.0, 2.0], cells, [0.0, 1.0, 0.0]).unwrap();
        let laid =
            lay(&mesh, Layout { creases: 1, ..LAYOUT }, Strain { radius: Some(0.3), ..Strain::default() });
        let now = map(&mesh, |[x, y, z]| [x - 0.08 * (3.0 * x).sin(), y, z]);
        let all = laid.compression(&now);
        all[all.len() / 2]
    };
    let (coarse, odd, fine) = (reading([20, 20]), reading([31, 13]), reading([160, 160]));
    assert!((coarse - fine).abs() < 0.02 * fine && (odd - fine).abs() < 0.03 * fine, "{coarse} {odd} {fine}");
}

#[test]
fn readings_are_smoothed_in_time() {
    let step = 0.02;
    let jump: Vec<Vec<f32>> = (0..100).map(|i| vec![if i < 50 { 0.0 } else { 0.3 }]).collect();
    let strain = Strain { from: 0.0, to: 0.3, ..Strain::default() };
    let record = |settle| Record::new(step, jump.clone(), &Strain { settle, ..strain }, &Spread::default());
    let sharp = record(0.0);
    assert_eq!((sharp.raise(0.98, 0), sharp.raise(1.0, 0)), (0.0, 1.0));
    let soft = record(0.4);
    let at = |seconds| soft.raise(seconds, 0);
    assert_eq!((at(-5.0), at(0.7), at(1.3), at(50.0)), (0.0, 0.0, 1.0, 1.0));
    for i in 0..200 {
        let seconds = f64::from(i) * 0.01;
        let change = at(seconds + 0.01) - at(seconds);
        assert!((0.0..0.15).contains(&change), "{change} at {seconds}");
    }
    assert_eq!(Record::default().raise(1.0, 0), 0.0);
}

#[test]
fn a_clip_without_length_and_a_window_beyond_all_measure_are_one_mean() {
    let strain = Strain { from: 0.0, to: 0.4, ..Strain::default() };
    for settle in [0.0, 0.1, 1e30] {
        let strain = Strain { settle, ..strain };
        let pose = Record::new(0.0, vec![vec![0.4], vec![0.4]], &strain, &Spread::default());
        assert_eq!((pose.raise(0.0, 0), pose.raise(3.0, 0)), (1.0, 1.0));
    }
    let ramp: Vec<Vec<f32>> = (0..=100).map(|i| vec![0.004 * i as f32]).collect();
    let flat = Record::new(0.02, ramp, &Strain { settle: 1e30, ..strain }, &Spread::default());
    let all: Vec<f64> = (0..=100).map(|i| flat.raise(f64::from(i) * 0.02, 0)).collect();
    assert!(all.iter().all(|h| (h - 0.5).abs() < 0.3 && h.is_finite()), "{all:?}");
}

#[test]
fn a_radius_beyond_all_measure_looks_at_so_many_triangles() {
    let mesh = grid([2.0, 2.0], [300, 300], [0.0, 1.0, 0.0]).unwrap();
    let laid = lay(&mesh, LAYOUT, Strain { radius: Some(1e20), ..Strain::default() });
    let now = map(&mesh, |[x, y, z]| [0.8 * x, y, z]);
    assert!(laid.compression(&now).iter().all(|c| (c - 0.2).abs() < 1e-3));
}

#[test]
fn triangles_that_are_no_numbers_or_have_collapsed_say_nothing() {
    let mesh = grid([2.0, 2.0], [40, 40], [0.0, 1.0, 0.0]).unwrap();
    let laid = lay(&mesh, LAYOUT, Strain::default());
    let read = |gone: [f32; 3]| {
        laid.compression(&map(&mesh, |p| if p[2] > 0.05 { gone } else { [0.8 * p[0], p[1], p[2]] }))
    };
    let wires = {
        let mut wires = Vec::new();
        laid.clone().wires_at(0.0, &mut wires);
        wires
    };
    let places: Vec<f32> = wires.iter().flat_map(|w| w.reference.points()).map(|p| p[2]).collect();
    for gone in [[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]] {
        for (reading, z) in read(gone).into_iter().zip(&places) {
            let expected = if *z > 0.3 { 0.0 } else { 0.2 };
            assert!((reading - expected).abs() < 1e-4 || (0.2..0.3).contains(z), "{reading} at {z}");
        }
    }
    let hidden = laid.compression(&map(&mesh, |_| [0.3, 0.0, 0.3]));
    assert!(hidden.iter().all(|reading| *reading == 0.0));
    // The half that is hidden says nothing; those between are pulled long.
    let half = laid.compression(&map(&mesh, |p| if p[2] > 0.0 { [p[0], 0.0, 0.0] } else { p }));
    assert!(half.iter().all(|reading| *reading < 1e-4), "{half:?}");
}

#[test]
fn settings_out_of_range_are_named() {
    let base = Strain::default();
    for (strain, name) in [
        (Strain { from: -0.1, ..base }, "from"),
        (Strain { from: 0.3, ..base }, "to"),
        (Strain { to: f32::NAN, ..base }, "to"),
        (Strain { radius: Some(0.0), ..base }, "radius"),
        (Strain { settle: -1.0, ..base }, "settle"),
    ] {
        let error = strain.check().unwrap_err();
        assert!(matches!(error, WrinkleError::Value { field, .. } if field == name), "{error} for {name}");
    }
    assert_eq!(base.check(), Ok(()));
}
