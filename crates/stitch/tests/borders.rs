//! Seams along whole borders, and along slits of one piece.

#[expect(dead_code, reason = "each test file uses its own part")]
mod common;

use common::{Cloth, rim, sewn, stitch, wide};
use wirework_core::Keyed;
use wirework_stitch::{Continuity, Edge, Reversed, Run, Seam, Tear};
use wirework_surface::{grid, tube};

#[test]
fn loops_find_their_direction_and_their_start() {
    let ring = |turn: f32, flip: bool| {
        // A tube whose rings begin elsewhere, or run the other way round.
        let mut mesh = tube([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5, 24, 9, false).unwrap();
        for p in &mut mesh.positions {
            let (s, c) = turn.sin_cos();
            let [x, z] = [c * p[0] + s * p[2], c * p[2] - s * p[0]];
            *p = [if flip { -x } else { x }, p[1] + 1.3, z];
        }
        mesh
    };
    for (turn, flip) in [(0.0, false), (2.1, false), (0.7, true)] {
        let mut cloth = Cloth::default();
        cloth.add(&tube([0.0; 3], [0.0, 1.0, 0.0], 0.5, 24, 9, false).unwrap());
        cloth.add(&ring(turn, flip));
        let seam = Seam::new(rim(0, [0.0, 1.0, 0.0]), rim(1, [0.0, 1.3, 0.0]));
        let out = sewn(&cloth, &stitch(vec![seam]));
        let upper: Vec<_> =
            (0..cloth.points.len()).filter(|&v| (cloth.points[v][1] - 1.0).abs() < 1e-6).collect();
        assert_eq!(upper.len(), 24);
        for v in upper {
            // No twist: each goes up by half of the gap, and sideways by no more than half of an edge makes.
            let (p, q) = (wide(cloth.points[v]), wide(out[v]));
            assert!((q.y - p.y - 0.15).abs() < 1e-6);
            assert!((q - p).with_y(0.0).length() < 0.07, "{turn} {flip}: {p} {q}");
        }
    }
}

#[test]
fn loops_of_unlike_counts_are_not_twisted() {
    for (sides, turn) in [([48, 6], 0.3_f32), ([6, 48], 1.0), ([48, 4], 0.7), ([9, 7], 0.0)] {
        let mut cloth = Cloth::default();
        cloth.add(&tube([0.0; 3], [0.0, 1.0, 0.0], 0.5, sides[0], 5, false).unwrap());
        let mut upper = tube([0.0, 1.3, 0.0], [0.0, 2.3, 0.0], 0.5, sides[1], 5, false).unwrap();
        for p in &mut upper.positions {
            let (s, c) = turn.sin_cos();
            *p = [c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]];
        }
        cloth.add(&upper);
        let out = sewn(&cloth, &stitch(vec![Seam::new(rim(0, [0.0, 1.0, 0.0]), rim(1, [0.0, 1.3, 0.0]))]));
        // Half of an angle between vertices of the finer rim, and a little for corners cut off by the coarser.
        let most = std::f64::consts::PI / f64::from(sides[0].max(sides[1])) + 0.06;
        for (p, q) in cloth.points.iter().zip(&out).filter(|(p, q)| p != q) {
            let angle = |p: &[f32; 3]| f64::from(p[2]).atan2(f64::from(p[0]));
            let turned = (angle(q) - angle(p)).rem_euclid(std::f64::consts::TAU);
            let turned = turned.min(std::f64::consts::TAU - turned);
            assert!(turned < most, "{sides:?}: {turned}");
        }
    }
}

#[test]
fn a_hole_that_touches_itself_and_rims_with_points_twice_are_loops_as_others() {
    let mut cloth = Cloth::default();
    cloth.add(&grid([4.0, 4.0], [4, 4], [0.0, 1.0, 0.0]).unwrap());
    let mut kept = 0..;
    // Two squares that share a corner.
    cloth.triangles.retain(|_| ![5, 10].contains(&(kept.next().unwrap() / 2)));
    let hole = cloth.clone();
    cloth.add(&tube([0.0, 0.5, 0.0], [0.0, 1.5, 0.0], 0.5, 16, 5, false).unwrap());
    let seam = Seam::new(rim(0, [0.5, 0.0, 0.5]), rim(1, [0.0, 0.5, 0.0]));
    cloth.lay(&stitch(vec![seam])).unwrap();
    assert!(hole.triangles.len() == 28);
    // Patches with a side drawn together to a point, one over the other: they meet half-way, straight up.
    let mut cloth = Cloth::default();
    for y in [0.0, 0.4] {
        let rows: Vec<Vec<[f32; 3]>> = (0..4)
            .map(|i| (0..4).map(|j| [i as f32 / 3.0, y, i as f32 / 3.0 * (j as f32 / 3.0 - 0.5)]).collect())
            .collect();
        cloth.add_patch(&rows, 6);
    }
    let out = sewn(&cloth, &stitch(vec![Seam::new(rim(0, [1.0, 0.0, 0.0]), rim(1, [1.0, 0.4, 0.0]))]));
    for (p, q) in cloth.points.iter().zip(&out) {
        assert!((p[0] - q[0]).abs() < 1e-5 && (p[2] - q[2]).abs() < 1e-5, "{p:?} {q:?}");
    }
}

/// A grid with a slit along x from −0.5 to 0.5, open by `open` in the middle: the cloth, the vertices on the one side, and the first on
/// the other.
fn slit(open: f32) -> (Cloth, Vec<usize>, usize) {
    let mesh = grid([2.0, 2.0], [20, 20], [0.0, 1.0, 0.0]).unwrap();
    let mut cloth = Cloth::default();
    cloth.add(&mesh);
    let on_slit = |p: [f32; 3]| p[2].abs() < 1e-6 && p[0].abs() < 0.45;
    let slit: Vec<usize> = (0..mesh.positions.len()).filter(|&v| on_slit(mesh.positions[v])).collect();
    assert_eq!(slit.len(), 9);
    let count = mesh.positions.len() as u32;
    let twin = |v: u32| slit.iter().position(|&s| s as u32 == v).map_or(v, |k| count + k as u32);
    for triangle in &mut cloth.triangles {
        let middle: f32 = triangle.iter().map(|&v| mesh.positions[v as usize][2]).sum();
        if middle > 0.0 {
            *triangle = triangle.map(twin);
        }
    }
    for &v in &slit {
        let p = mesh.positions[v];
        let open = open * (1.0 - (p[0] / 0.5).powi(2));
        cloth.points[v] = [p[0], 0.0, -open];
        cloth.points.push([p[0], 0.0, open]);
        cloth.piece_of.push(0);
    }
    (cloth, slit, count as usize)
}

fn along_slit() -> Seam {
    let run = |long| Run::Between { from: [-0.5, 0.0, 0.0], to: [0.5, 0.0, 0.0], long };
    Seam::new(Edge { piece: 0, run: run(false) }, Edge { piece: 0, run: run(true) })
}

#[test]
fn a_slit_closes_from_both_sides() {
    let (cloth, slit, first) = slit(0.1);
    let out = sewn(&cloth, &stitch(vec![Seam { reversed: Reversed::Auto, ..along_slit() }]));
    for (k, &v) in slit.iter().enumerate() {
        let other = out[first + k];
        assert_eq!(out[v], other);
        assert!(other[2].abs() < 1e-6);
    }
    // The cloth beside it follows its own side.
    for (sign, z) in [(1.0, -0.1), (-1.0, 0.1)] {
        let v = cloth.points.iter().position(|p| p[0].abs() < 1e-6 && (p[2] - z).abs() < 1e-6).unwrap();
        let moved = (out[v][2] - cloth.points[v][2]) * sign;
        assert!(moved > 0.03, "{moved} at {z}");
    }
}

#[test]
fn a_slit_that_is_shut_gapes_with_the_cloth_on_its_sides() {
    let (cloth, ..) = slit(0.0);
    let tear = Tear { gape: Keyed::Constant(0.05), ..Tear::new(0.5, 1.0) };
    let out = sewn(&cloth, &stitch(vec![Seam { tears: vec![tear], ..along_slit() }]));
    let rows =
        |z: f32| cloth.points.iter().position(|p| p[0].abs() < 1e-6 && (p[2] - z).abs() < 1e-6).unwrap();
    for z in [-0.2_f32, -0.1, 0.1, 0.2] {
        let moved = (out[rows(z)][2] - z) * z.signum();
        assert!(moved > 0.02, "{moved} at {z}");
    }
    // Beyond its ends both sides are one cloth, and stay.
    let beyond = cloth.points.iter().position(|p| (p[0] - 0.6).abs() < 1e-6 && p[2].abs() < 1e-6).unwrap();
    assert!(wide(out[beyond]).distance(wide(cloth.points[beyond])) < 2e-3);
}

#[test]
fn a_slit_stays_flat_and_whole_whatever_opens_or_turns_it() {
    let (cloth, slit, first) = slit(0.06);
    for continuity in [Continuity::Position, Continuity::Tangent] {
        let tears = vec![Tear { gape: Keyed::Constant(0.02), ..Tear::new(0.0, 0.6) }];
        let seam = Seam { continuity, tears, ..along_slit() };
        let out = sewn(&cloth, &stitch(vec![seam]));
        for (p, q) in cloth.points.iter().zip(&out) {
            assert!(q[1].abs() < 1e-5, "{continuity:?}: {p:?} comes to {q:?}");
        }
        // The end that both edges share goes to neither side.
        let end = cloth.points.iter().position(|p| (p[0] + 0.5).abs() < 1e-6 && p[2].abs() < 1e-6).unwrap();
        assert!(out[end][2].abs() < 1e-5, "{:?}", out[end]);
        assert!(out[slit[0]][2] < out[first][2]);
    }
}
