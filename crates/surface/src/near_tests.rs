use std::f64::consts::PI;

use super::*;
use crate::{Mesh, Nearest, grid, tube};

/// A walk as a line.
fn line(mesh: &Mesh, start: [f32; 3], heading: [f64; 3], length: f64) -> (Terrain, Vec<Step>) {
    let triangles = mesh.triangles().unwrap();
    let terrain = Terrain::new(&mesh.positions, &triangles).unwrap();
    let at = Nearest::new(&mesh.positions, &triangles).unwrap().nearest(start).unwrap();
    let mut walker = terrain.walker(&at, heading).unwrap();
    let mut steps = vec![walker.step()];
    walker.walk(length, |_, step| steps.push(step));
    (terrain, steps)
}

#[test]
fn on_a_plane_everything_near_is_found_and_counts() {
    for cells in [[40, 40], [7, 3], [1, 1]] {
        let mesh = grid([2.0, 2.0], cells, [0.0, 1.0, 0.0]).unwrap();
        let (terrain, steps) = line(&mesh, [-0.5, 0.0, 0.13], [1.0, 0.0, 0.3], 1.0);
        let ahead = DVec3::new(1.0, 0.0, 0.3).normalize();
        let start = DVec3::from(steps[0].position);
        for radius in [0.1, 0.5, 1.3] {
            let near = terrain.near(&steps, radius, &mut NearBuffer::default());
            let longest = steps
                .windows(2)
                .map(|pair| DVec3::from(pair[0].position).distance(DVec3::from(pair[1].position)));
            let most = radius.hypot(longest.fold(0.0, f64::max) / 2.0);
            for i in 0..mesh.positions.len() as u32 {
                let v = DVec3::from(mesh.positions[i as usize].map(f64::from)) - start;
                let off = v.distance(ahead * v.dot(ahead).clamp(0.0, 1.0));
                let found = near.vertices.binary_search(&i).is_ok();
                assert!(found || off >= radius - 1e-6, "{cells:?} {radius}: {i} is {off} off");
                assert!(!found || off <= most + 1e-6, "{cells:?} {radius}: {i} is {off} off");
            }
            assert!(near.factors.is_empty());
        }
    }
}

#[test]
fn another_sheet_is_never_met() {
    let mut mesh = grid([2.0, 2.0], [20, 20], [0.0, 1.0, 0.0]).unwrap();
    let other = grid([2.0, 2.0], [20, 20], [0.0, 1.0, 0.0]).unwrap();
    let (count, corners) = (mesh.positions.len() as u32, mesh.corners.len() as u32);
    mesh.positions.extend(other.positions.iter().map(|p| [p[0], -0.01, p[2]]));
    mesh.corners.extend(other.corners.iter().map(|c| crate::Corner {
        position: c.position + count,
        uv: None,
        normal: None,
    }));
    mesh.face_ends.extend(other.face_ends.iter().map(|end| end + corners));
    mesh.corners.iter_mut().for_each(|c| (c.uv, c.normal) = (None, None));
    let (terrain, steps) = line(&mesh, [-0.5, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0);
    let near = terrain.near(&steps, 0.3, &mut NearBuffer::default());
    assert!(near.vertices.len() > 50 && near.vertices.iter().all(|&v| v < count));
    assert!(near.factors.is_empty());
}

#[test]
fn round_a_thin_tube_the_far_side_fades_by_the_way_round() {
    let radius = 0.5;
    let mesh = tube([-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], radius, 48, 61, false).unwrap();
    let (terrain, steps) = line(&mesh, [-1.0, 0.6, 0.0], [1.0, 0.0, 0.0], 2.0);
    let mut buffer = NearBuffer::default();
    // From the line to the far side it is 1 through the air and π/2 over the surface.
    for reach in [0.45, 0.8, 0.9, 1.05, 1.3] {
        let near = terrain.near(&steps, reach, &mut buffer);
        let factor = |vertex: usize| match near.vertices.binary_search(&(vertex as u32)) {
            Ok(slot) => near.factors.get(slot).copied().unwrap_or(1.0),
            Err(_) => 0.0,
        };
        for (i, p) in mesh.positions.iter().enumerate().filter(|(_, p)| p[0].abs() < 0.9) {
            let round = f64::from(radius) * f64::from(p[2]).atan2(f64::from(p[1])).abs();
            let air = 2.0 * f64::from(radius) * (round / f64::from(radius) / 2.0).sin();
            if air < reach * 0.999 {
                let expected = fade(round / reach);
                assert!(
                    (f64::from(factor(i)) - expected).abs() < 0.12,
                    "{reach} {p:?}: {} {expected}",
                    factor(i)
                );
            } else if air > reach * 1.001 {
                assert_eq!(factor(i), 0.0);
            }
        }
    }
    assert!(fade(PI / 2.0 / 0.9) < 0.9 && fade(PI / 2.0 / 1.3) == 1.0);
    assert!(buffer.touched.is_empty() && buffer.air.iter().all(|known| *known == UNKNOWN));
    assert!(buffer.marched.is_empty() && buffer.over.iter().all(|known| known.0 == f64::INFINITY));
}

#[test]
fn a_sheet_that_is_folded_back_is_met_only_round_the_fold() {
    // Two layers 0.02 apart that hang together at x = 1.
    let mut mesh = grid([4.0, 1.0], [80, 20], [0.0, 1.0, 0.0]).unwrap();
    for p in &mut mesh.positions {
        if p[0] > 0.0 {
            *p = [-p[0], -0.02, p[2]];
        }
    }
    let of = |from: f32, radius: f64| {
        let (terrain, steps) = line(&mesh, [from, 0.0, -0.3], [0.0, 0.0, 1.0], 0.6);
        let near = terrain.near(&steps, radius, &mut NearBuffer::default());
        // What a wire of that radius would do below.
        let effect = |(i, &vertex): (usize, &u32)| {
            let [x, y, _] = mesh.positions[vertex as usize];
            let air = f64::from((x - from).hypot(y)) / radius;
            let influence = (1.0 - air * air).max(0.0).powi(2) as f32;
            if y < -0.01 { influence * near.factors.get(i).copied().unwrap_or(1.0) } else { 0.0 }
        };
        near.vertices.iter().enumerate().map(effect).fold(0.0_f32, f32::max)
    };
    assert_eq!(of(-1.0, 0.2), 0.0);
    assert_eq!(of(-0.5, 0.2), 0.0);
    assert!(of(-0.05, 0.2) > 0.9);
    // It comes and goes without a step.
    let mut before = of(-0.5, 0.2);
    for i in 1..=45 {
        let now = of(-0.5 + 0.01 * i as f32, 0.2);
        assert!((now - before).abs() < 0.2, "step {i}: {before} to {now}");
        before = now;
    }
}

#[test]
fn split_vertices_are_found_together() {
    let p = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, -1.0], [0.0, 0.0, -1.0]];
    let positions = [p[0], p[1], p[2], p[0], p[2], p[3]];
    let triangles = [[0, 1, 2], [3, 4, 5]];
    let terrain = Terrain::new(&positions, &triangles).unwrap();
    let at = Nearest::new(&positions, &triangles).unwrap().nearest([0.6, 0.0, -0.1]).unwrap();
    let steps = [terrain.walker(&at, [1.0, 0.0, 0.0]).unwrap().step()];
    let near = terrain.near(&steps, 0.95, &mut NearBuffer::default());
    assert_eq!(near.vertices, [0, 1, 3]);
    assert_eq!(terrain.near(&steps, 2.0, &mut NearBuffer::default()).vertices, [0, 1, 2, 3, 4, 5]);
}
