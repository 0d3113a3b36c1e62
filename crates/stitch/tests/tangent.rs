//! Tangent planes along seams.

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;

use common::{Cloth, on_side, sewn, stitch, wide};
use glam::DVec3;
use wirework_core::Keyed;
use wirework_stitch::{Continuity, Pairing, Seam, Side};

/// Patches on both sides of z, the one flat, the other rising at an angle, apart by `apart`.
fn roof(cells: u32, degrees: f32, apart: f32) -> Cloth {
    let (s, c) = degrees.to_radians().sin_cos();
    let rows = |along: &dyn Fn(f32) -> [f32; 2]| -> Vec<Vec<[f32; 3]>> {
        let row = |i: usize| {
            let [x, y] = along(i as f32 / 3.0);
            (0..4).map(|j| [x, y, j as f32 / 3.0 - 0.5]).collect()
        };
        (0..4).map(row).collect()
    };
    let mut cloth = Cloth::default();
    cloth.add_patch(&rows(&|t| [t - 1.0 - apart / 2.0, 0.0]), cells);
    cloth.add_patch(&rows(&|t| [apart / 2.0 + c * t, s * t]), cells);
    cloth
}

fn seam(continuity: Continuity) -> Seam {
    Seam {
        continuity,
        pairing: Pairing::Parameter,
        ..Seam::new(on_side(0, Side::UMax), on_side(1, Side::UMin))
    }
}

/// The normal of the faces of one piece at a point, by area.
fn normal(cloth: &Cloth, points: &[[f32; 3]], v: u32) -> DVec3 {
    let fan = cloth.triangles.iter().filter(|t| t.contains(&v));
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| wide(points[v as usize]));
        (b - a).cross(c - a)
    };
    fan.map(area).sum::<DVec3>().normalize()
}

fn largest_angle(cloth: &Cloth, points: &[[f32; 3]], pairs: &[(u32, u32)]) -> f64 {
    let angle = |&(a, b): &(u32, u32)| {
        let [m, n] = [a, b].map(|v| normal(cloth, points, v));
        m.cross(n).length().atan2(m.dot(n)).to_degrees()
    };
    pairs.iter().map(angle).fold(0.0, f64::max)
}

fn pairs(cloth: &Cloth, a: (usize, Side), b: (usize, Side)) -> Vec<(u32, u32)> {
    cloth.side(a.0, a.1).iter().copied().zip(cloth.side(b.0, b.1).iter().copied()).collect()
}

#[test]
fn planes_that_meet_at_forty_degrees_become_one_in_the_limit() {
    let mut last = f64::INFINITY;
    for (cells, apart) in [(32, 0.1), (64, 0.1), (128, 0.1)] {
        let cloth = roof(cells, 40.0, apart);
        let pairs = pairs(&cloth, (0, Side::UMax), (1, Side::UMin));
        let kink = largest_angle(&cloth, &sewn(&cloth, &stitch(vec![seam(Continuity::Position)])), &pairs);
        let smooth = largest_angle(&cloth, &sewn(&cloth, &stitch(vec![seam(Continuity::Tangent)])), &pairs);
        assert!(kink > 25.0, "{kink} at {cells}");
        assert!(smooth < 0.6 * last, "{smooth} at {cells}, {last} before");
        last = smooth;
    }
    assert!(last < 1.0, "{last}");
}

#[test]
fn bias_says_whose_plane_it_is() {
    let cloth = roof(64, 40.0, 0.0);
    for (bias, expected) in [(0.0, 0.0), (1.0, 40.0), (0.25, 10.0)] {
        let seam = Seam { bias: Keyed::Constant(bias), ..seam(Continuity::Tangent) };
        let out = sewn(&cloth, &stitch(vec![seam]));
        let v = cloth.side(0, Side::UMax)[32];
        let n = normal(&cloth, &out, v);
        // The patches face down.
        let tilt = n.x.atan2(-n.y).to_degrees();
        assert!((tilt - expected).abs() < 1.0, "{tilt} at bias {bias}");
    }
}

#[test]
fn a_fold_that_is_shut_opens_outwards() {
    // Front and back of a cushion: outwards is up for the one and down for the other.
    let mut cloth = Cloth::default();
    let flat = |flip: bool| -> Vec<Vec<[f32; 3]>> {
        let z = |j: usize| (if flip { 3 - j } else { j }) as f32 / 3.0;
        (0..4).map(|i| (0..4).map(|j| [-(i as f32) / 3.0, 0.0, z(j)]).collect()).collect()
    };
    cloth.add_patch(&flat(true), 48);
    cloth.add_patch(&flat(false), 48);
    let seam = Seam { b: on_side(1, Side::UMin), a: on_side(0, Side::UMin), ..seam(Continuity::Tangent) };
    let out = sewn(&cloth, &stitch(vec![seam]));
    for (piece, vertex) in [(0, 24), (1, 24)] {
        let up = normal(&cloth, &cloth.points, cloth.side(piece, Side::UMin)[vertex]).y;
        // A row farther in.
        let inner = cloth.piece(piece).find(|&v| {
            let p = cloth.points[v];
            (p[0] + 4.0 / 48.0).abs() < 1e-5 && (p[2] - 0.5).abs() < 1e-5
        });
        let rise = f64::from(out[inner.unwrap()][1]) * up;
        assert!(rise > 0.05, "{rise} of piece {piece}");
    }
}

#[test]
fn in_a_corner_four_planes_become_one() {
    let mut last = f64::INFINITY;
    for cells in [32, 64, 128] {
        let mut cloth = Cloth::default();
        // Four leaves of a shallow tent, apart.
        for (sx, sz) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let at = |k: usize, s: f32| if s < 0.0 { k as f32 / 3.0 - 1.05 } else { k as f32 / 3.0 + 0.05 };
            let rows: Vec<Vec<[f32; 3]>> = (0..4)
                .map(|i| {
                    (0..4)
                        .map(|j| (at(i, sx), at(j, sz)))
                        .map(|(x, z)| [x, -0.35 * x.abs() - 0.2 * z.abs(), z])
                        .collect()
                })
                .collect();
            cloth.add_patch(&rows, cells);
        }
        let join = |a, s, b, t| Seam {
            continuity: Continuity::Tangent,
            pairing: Pairing::Parameter,
            ..Seam::new(on_side(a, s), on_side(b, t))
        };
        let seams = vec![
            join(0, Side::UMax, 1, Side::UMin),
            join(2, Side::UMax, 3, Side::UMin),
            join(0, Side::VMax, 2, Side::VMin),
            join(1, Side::VMax, 3, Side::VMin),
        ];
        let out = sewn(&cloth, &stitch(seams));
        let corners =
            [(0, Side::UMax, true), (1, Side::UMin, true), (2, Side::UMax, false), (3, Side::UMin, false)];
        let normals = corners.map(|(piece, side, last)| {
            let side = cloth.side(piece, side);
            let v = if last { side[side.len() - 1] } else { side[0] };
            normal(&cloth, &out, v)
        });
        let most = normals.iter().map(|n| n.angle_between(normals[0]).to_degrees()).fold(0.0, f64::max);
        assert!(most < 0.7 * last, "{most} at {cells}, {last} before");
        last = most;
    }
    assert!(last < 2.0, "{last}");
}
