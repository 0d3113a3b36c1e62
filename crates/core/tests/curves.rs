//! Curve queries against the float64 reference, on the curves of random rigs.

use wirework_core::{Blend, Curve, Wire};
use wirework_reference as reference;
use wirework_reference::{Random, Rig, Scene};

const RIGS: u64 = 120;

/// Answers are stored as float32; a few of its last places, as a part of the largest coordinate.
const ROUNDING: f64 = 4e-7;

fn curves() -> impl Iterator<Item = (u64, Curve)> {
    (0..RIGS).flat_map(|seed| Rig::new(seed).wires.into_iter().map(move |w| (seed, w.reference)))
}

fn extent(curve: &Curve) -> f64 {
    curve.points().iter().flatten().fold(0.0, |a: f64, c| a.max(f64::from(c.abs())))
}

fn apart(a: [f32; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (f64::from(a[i]) - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn points_are_the_references() {
    for (seed, curve) in curves() {
        for i in 0..=60_u8 {
            let u = f32::from(i) / 60.0;
            let error = apart(curve.point(u), reference::point(&curve, u.into()));
            // A parameter is off by its last place too: half of 2⁻²⁴ of the derivative.
            assert!(error <= ROUNDING * extent(&curve), "seed {seed}, u = {u}: off by {error}, {curve:?}");
        }
    }
}

#[test]
fn lengths_are_the_references() {
    for (seed, curve) in curves() {
        let (found, exact) = (f64::from(curve.length()), reference::length(&curve));
        assert!((found - exact).abs() <= 1e-6 * exact, "seed {seed}: {found}, not {exact}, {curve:?}");
    }
}

#[test]
fn tangents_are_the_references() {
    for (seed, curve) in curves() {
        let n = reference::segment_count(&curve) as f64;
        for i in 0..=60_u8 {
            let u = f32::from(i) / 60.0;
            // Inside a segment and not where the curve nearly stops; joints follow.
            let x = f64::from(u) * n;
            let speed = apart([0.0; 3], reference::derivative(&curve, u.into()));
            if (x - x.round()).abs() < 1e-4 || speed < 1e-2 * extent(&curve) {
                continue;
            }
            let error = apart(curve.tangent(u), reference::tangent(&curve, u.into()));
            assert!(error < 2e-5, "seed {seed}, u = {u}: off by {error}, {curve:?}");
        }
    }
}

#[test]
fn tangents_at_joints_are_the_mean_of_both_sides() {
    let mut joints = 0;
    for (seed, curve) in curves() {
        let n = reference::segment_count(&curve);
        for i in 0..=n {
            // The float32 nearest to a joint is the joint.
            let u = i as f32 / n as f32;
            let exact = reference::tangent(&curve, i as f64 / n as f64);
            let error = apart(curve.tangent(u), exact);
            // Two sides that nearly cancel leave rounding over.
            let h = 1e-7;
            let sides = [-h, h].map(|h| reference::tangent(&curve, i as f64 / n as f64 + h));
            let dot: f64 = (0..3).map(|k| sides[0][k] * sides[1][k]).sum();
            if dot < -0.999 {
                continue;
            }
            joints += 1;
            assert!(error < 1e-5, "seed {seed}, joint {i} of {n}: off by {error}, {curve:?}");
        }
    }
    assert!(joints > 500);
}

#[test]
fn feet_are_the_references() {
    let (mut all, mut unlike) = (0_u32, 0_u32);
    for (seed, curve) in curves() {
        let mut random = Random::new(seed);
        let size = extent(&curve).max(1e-3);
        let scene = Scene::new(&[Wire::new(curve.clone())], &Blend::default());
        for _ in 0..60 {
            let near = reference::point(&curve, random.range(0.0, 1.0));
            let off = random.pick(&[0.01, 0.3, 1.5]) * size;
            let shift = random.vector(off);
            let p = [0, 1, 2].map(|i| (near[i] + shift[i]) as f32);
            let exact = scene.feet(p)[0];
            let foot = curve.closest(p).expect("a finite point");
            let extent = p.iter().fold(extent(&curve), |a, c| a.max(f64::from(c.abs())));
            let error = (f64::from(foot.distance) - exact.distance).abs();
            assert!(error < 6e-7 * extent, "seed {seed}, {p:?}: {foot:?}, not {exact:?}, {curve:?}");
            all += 1;
            if apart(foot.point, exact.point) > 1e-5 * extent {
                // Another of several feet, or the bottom of a flat minimum.
                assert!(
                    exact.ambiguous || exact.sharpness < 1e-3,
                    "seed {seed}, {p:?}: {foot:?}, not {exact:?}"
                );
                unlike += 1;
            }
        }
    }
    assert!(unlike * 1000 < all, "{unlike} of {all} feet differ");
}

#[test]
fn ties_as_stored_give_the_smallest_parameter() {
    // Symmetric shapes turned and shifted: as float32 no longer symmetric to the last place.
    let mut random = Random::new(7);
    let mut met = 0_u32;
    for _ in 0..400 {
        let turn = glam::DQuat::from_scaled_axis(glam::DVec3::from_array(random.vector(3.0)));
        let shift = glam::DVec3::from_array(random.vector(1.0));
        let place = |p: [f64; 3]| (turn * glam::DVec3::from_array(p) + shift).as_vec3().to_array();
        let vee = [[-1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(place);
        // The parabola has its centre of curvature at 1.5: above it two feet.
        let polyline = (Curve::polyline(vee.to_vec()).unwrap(), place([0.0, 0.9, 0.0]));
        let parabola = (Curve::bspline(2, vee.to_vec()).unwrap(), place([0.0, 1.8, 0.0]));
        for (curve, p) in [polyline, parabola] {
            let exact = reference::closest(&curve, p.map(f64::from));
            if exact.u < 0.5 {
                met += 1;
                assert!(curve.closest(p).unwrap().u < 0.5, "{p:?}, {curve:?}");
            }
        }
    }
    assert!(met > 600, "{met} ties");
}
