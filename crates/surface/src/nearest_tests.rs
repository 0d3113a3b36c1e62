use proptest::prelude::*;

use super::*;
use crate::{grid, sphere};

/// The distance by minimising over the triangle's plane and edges, written without the code under test: projected
/// gradient on the barycentric weights, started from the best of a fine lattice of them.
fn brute(corners: [DVec3; 3], q: DVec3) -> f64 {
    let mut best = (f64::INFINITY, [0.0; 3]);
    let mut step = 1.0 / 16.0;
    for i in 0..=16 {
        for j in 0..=16 - i {
            let w = [f64::from(i) * step, f64::from(j) * step, f64::from(16 - i - j) * step];
            let d = blend(corners, w).distance(q);
            if d < best.0 {
                best = (d, w);
            }
        }
    }
    // The distance is convex in the weights: a pattern search that halves its step ends at the minimum.
    while step > 1e-9 {
        let at = best.1;
        for (from, to) in [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)] {
            let mut w = at;
            let move_by = step.min(w[from]);
            w[from] -= move_by;
            w[to] += move_by;
            let d = blend(corners, w).distance(q);
            if d < best.0 {
                best = (d, w);
            }
        }
        if best.1 == at {
            step *= 0.5;
        }
    }
    best.0
}

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), Just(1.0), Just(-1.0), -2.0_f32..2.0]
}

proptest! {
    #[test]
    fn distances_agree_with_a_search(
        points in prop::collection::vec(prop::array::uniform3(coordinate()), 3..20),
        picks in prop::collection::vec(prop::array::uniform3(0_usize..100), 1..30),
        query in prop::array::uniform3(coordinate()),
    ) {
        let triangles: Vec<[u32; 3]> = picks.iter().map(|t| t.map(|i| (i % points.len()) as u32)).collect();
        let found = Nearest::new(&points, &triangles).unwrap().nearest(query).unwrap();
        let distances: Vec<f64> =
            triangles.iter().map(|t| brute(t.map(|v| wide(points[v as usize])), wide(query))).collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        prop_assert!((f64::from(found.distance) - least).abs() < 1e-6, "{} for {least}", found.distance);
        prop_assert!(wide(found.position).distance(wide(query)) < least + 1e-6);
        prop_assert!(distances[found.triangle as usize] < least + 1e-6);
        let weights = found.barycentric;
        prop_assert!(weights.iter().all(|&w| w >= 0.0) && (weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn ties_go_to_the_first_triangle() {
    let mesh = grid([8.0, 8.0], [8, 8], [0.0, 1.0, 0.0]).unwrap();
    let triangles = mesh.triangles().unwrap();
    let nearest = Nearest::new(&mesh.positions, &triangles).unwrap();
    for (vertex, p) in mesh.positions.iter().enumerate() {
        let first = triangles.iter().position(|t| t.contains(&(vertex as u32))).unwrap();
        for height in [0.0, 1.0, 0.3] {
            let found = nearest.nearest([p[0], height, p[2]]).unwrap();
            assert_eq!((found.triangle as usize, found.position), (first, *p), "over vertex {vertex}");
        }
    }
    // The same triangle many times.
    let copies = vec![triangles[3]; 100];
    let found = Nearest::new(&mesh.positions, &copies).unwrap().nearest([0.3, 5.0, 0.1]).unwrap();
    assert_eq!(found.triangle, 0);
}

#[test]
fn a_point_inside_an_edge_is_a_tie_too() {
    // An edge of directions that round, and points along it.
    let positions = [[0.1, 0.2, 0.3], [1.7, 0.9, -0.4], [0.3, 1.5, 0.2], [1.2, -0.8, 0.3]];
    let nearest = Nearest::new(&positions, &[[1, 0, 3], [0, 1, 2]]).unwrap();
    for i in 1..50 {
        let x = i as f32 / 50.0;
        let p = [0, 1, 2].map(|a| positions[0][a] * (1.0 - x) + positions[1][a] * x);
        let found = nearest.nearest(p).unwrap();
        assert!(found.distance < 1e-6);
    }
}

#[test]
fn normals_are_interpolated_or_the_faces() {
    let mesh = sphere([0.0; 3], 1.0, [64, 32]).unwrap();
    let nearest = Nearest::new(&mesh.positions, &mesh.triangles().unwrap()).unwrap();
    let query = [0.3, 0.5, -0.9];
    let found = nearest.nearest(query).unwrap();
    let smooth = nearest.interpolated_normal(&found, &mesh.normals).unwrap();
    assert!(wide(smooth).distance(wide(found.position).normalize()) < 2e-3);
    let flat = nearest.interpolated_normal(&found, &[]).unwrap();
    assert_eq!(Some(flat), nearest.face_normal(found.triangle));
}

#[test]
fn surfaces_that_cannot_be_searched_are_errors() {
    let p = [[0.0; 3], [1.0, 0.0, 0.0], [f32::NAN; 3]];
    assert_eq!(Nearest::new(&p, &[]).unwrap_err(), NearestError::NoFaces);
    assert_eq!(
        Nearest::new(&p, &[[0, 1, 1], [0, 1, 2]]).unwrap_err(),
        NearestError::Vertex { triangle: 1, vertex: 2 }
    );
    assert_eq!(Nearest::new(&p, &[[0, 1, 7]]).unwrap_err(), NearestError::Vertex { triangle: 0, vertex: 7 });
    let line = Nearest::new(&p, &[[0, 1, 1]]).unwrap();
    assert_eq!(line.nearest([f32::INFINITY; 3]), None);
    assert_eq!(line.nearest([0.5, 2.0, 0.0]).unwrap().position, [0.5, 0.0, 0.0]);
    assert_eq!(line.face_normal(0), None);
}
