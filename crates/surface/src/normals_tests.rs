use std::f32::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::{VertexMesh, cuboid, grid, sphere, tube};

fn update(mesh: &VertexMesh, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let normals = Normals::new(&mesh.positions, &mesh.normals, &mesh.triangles).unwrap();
    let mut out = vec![[0.0; 3]; positions.len()];
    normals.update_into(positions, &mut NormalsBuffer::default(), &mut out).unwrap();
    out
}

fn moved(mesh: &VertexMesh, f: impl Fn(Vec3) -> Vec3) -> Vec<[f32; 3]> {
    mesh.positions.iter().map(|&p| f(Vec3::from(p)).to_array()).collect()
}

fn solids() -> Vec<VertexMesh> {
    [
        cuboid([-1.0; 3], [1.0; 3], [3, 2, 4]).unwrap(),
        tube([0.0; 3], [0.0, 3.0, 0.0], 0.5, 12, 9, true).unwrap(),
        sphere([0.0; 3], 1.0, [24, 12]).unwrap(),
    ]
    .iter()
    .map(|mesh| VertexMesh::new(mesh).unwrap())
    .collect()
}

#[test]
fn rest_is_the_identity() {
    for mesh in solids() {
        assert_eq!(update(&mesh, &mesh.positions), mesh.normals);
    }
}

#[test]
fn what_has_not_moved_keeps_its_bits() {
    let mesh = VertexMesh::new(&sphere([0.0; 3], 1.0, [24, 12]).unwrap()).unwrap();
    let out = update(&mesh, &moved(&mesh, |p| if p.y > 0.8 { p * 1.5 } else { p }));
    let mut changed = 0;
    for ((n, rest), p) in out.iter().zip(&mesh.normals).zip(&mesh.positions) {
        // One ring below the moved ones is the last that sees them.
        assert!(p[1] > 0.5 || n == rest);
        changed += usize::from(n != rest);
    }
    assert!(changed > 0);
}

#[test]
fn a_wave_on_a_grid_has_its_closed_form_normals() {
    let mesh = VertexMesh::new(&grid([2.0; 2], [200, 200], [0.0, 1.0, 0.0]).unwrap()).unwrap();
    let wave = |p: Vec3| Vec3::new(p.x, 0.1 * (3.0 * p.x).sin() * (2.0 * p.z).cos(), p.z);
    let out = update(&mesh, &moved(&mesh, wave));
    for (n, p) in out.iter().zip(&mesh.positions) {
        let (dx, dz) =
            (0.3 * (3.0 * p[0]).cos() * (2.0 * p[2]).cos(), -0.2 * (3.0 * p[0]).sin() * (2.0 * p[2]).sin());
        let exact = Vec3::new(-dx, 1.0, -dz).normalize();
        let border = p[0].abs().max(p[2].abs()) > 0.99;
        assert!(Vec3::from(*n).distance(exact) < if border { 1e-2 } else { 2e-4 }, "{n:?} {exact} at {p:?}");
    }
}

#[test]
fn a_stretched_sphere_keeps_smooth_normals_near_the_exact_ones() {
    let mesh = VertexMesh::new(&sphere([0.0; 3], 1.0, [96, 48]).unwrap()).unwrap();
    let out = update(&mesh, &moved(&mesh, |p| p * Vec3::new(1.0, 2.0, 1.0)));
    for (n, p) in out.iter().zip(&mesh.positions) {
        let exact = (Vec3::from(*p) / Vec3::new(1.0, 2.0, 1.0)).normalize();
        assert!(Vec3::from(*n).distance(exact) < 5e-3, "{n:?} {exact}");
    }
}

#[test]
fn seams_stay_shut_and_edges_hard() {
    for mesh in solids() {
        let out = update(
            &mesh,
            &moved(&mesh, |p| p + Vec3::new(0.2 * (2.0 * p.y).sin(), 0.1 * p.x * p.x, 0.2 * p.z)),
        );
        for i in 0..out.len() {
            for j in 0..i {
                let shared = mesh.positions[i] == mesh.positions[j];
                if shared && mesh.normals[i] == mesh.normals[j] {
                    assert_eq!(out[i].map(f32::to_bits), out[j].map(f32::to_bits));
                } else if shared {
                    let dot = Vec3::from(out[i]).dot(Vec3::from(out[j]));
                    assert!(dot < 0.9, "a hard edge went soft");
                }
            }
        }
    }
}

#[test]
fn a_face_turned_over_gives_opposite_normals() {
    let mesh = VertexMesh::new(&grid([1.0; 2], [1, 1], [0.0, 1.0, 0.0]).unwrap()).unwrap();
    for tilt in [0.0, 1e-9, 1e-6, 1e-3, 0.1] {
        let out = update(&mesh, &moved(&mesh, |p| Vec3::new(p.x, tilt * p.x, -p.z)));
        let exact = Vec3::new(tilt, -1.0, 0.0).normalize();
        assert!(out.iter().all(|&n| Vec3::from(n).distance(exact) < 1e-6), "{tilt}: {out:?}");
    }
}

#[test]
fn degenerate_faces_keep_the_rest_normal() {
    let mesh = VertexMesh::new(&cuboid([-1.0; 3], [1.0; 3], [2, 2, 2]).unwrap()).unwrap();
    assert_eq!(update(&mesh, &moved(&mesh, |_| Vec3::ONE)), mesh.normals);
    assert_eq!(update(&mesh, &moved(&mesh, |p| Vec3::X * p.x)), mesh.normals);
    assert_eq!(update(&mesh, &moved(&mesh, |_| Vec3::NAN)), mesh.normals);
    // Two sides of one sheet: the sum is zero.
    let (positions, normals) = (vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0.0, 0.0, 1.0]; 3]);
    let model = Normals::new(&positions, &normals, &[[0, 1, 2], [0, 2, 1]]).unwrap();
    let mut out = [[0.0; 3]; 3];
    let lifted: Vec<[f32; 3]> = positions.iter().map(|p| [p[0], p[1], p[0]]).collect();
    model.update_into(&lifted, &mut NormalsBuffer::default(), &mut out).unwrap();
    assert_eq!(out[..], normals);
}

#[test]
fn wrong_lengths_and_indices_are_errors() {
    let p = [[0.0; 3]; 3];
    let error = Normals::new(&p, &p, &[[0, 1, 3]]).unwrap_err();
    assert_eq!(error, NormalsError::Index { triangle: 0, vertex: 3, vertices: 3 });
    assert!(Normals::new(&p, &p[..2], &[]).is_err());
    let model = Normals::new(&p, &p, &[[0, 1, 2]]).unwrap();
    let mut buffer = NormalsBuffer::default();
    assert!(model.update_into(&p[..1], &mut buffer, &mut [[0.0; 3]; 3]).is_err());
    assert!(model.update_into(&p, &mut buffer, &mut []).is_err());
    assert!(Normals::new(&[], &[], &[]).unwrap().update_into(&[], &mut buffer, &mut []).is_ok());
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = VertexMesh::new(&sphere([0.0; 3], 1.0, [200, 100]).unwrap()).unwrap();
    let positions = moved(&mesh, |p| p + 0.1 * Vec3::new((9.0 * p.y).sin(), (7.0 * p.z).cos(), p.x * p.y));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| update(&mesh, &positions))
    };
    let one = run(1);
    assert!(one == run(2) && one == run(7));
}

proptest! {
    /// A rigid motion turns the normals with it.
    #[test]
    fn rigid_motions_commute(
        axis in prop::array::uniform3(-1.0_f32..1.0),
        angle in prop_oneof![Just(PI), Just(PI * 0.5), -PI..PI, -1e-4_f32..1e-4],
        solid in 0_usize..3,
    ) {
        let axis = Vec3::from(axis).normalize_or(Vec3::X);
        let rotation = glam::Quat::from_axis_angle(axis, angle);
        let mesh = &solids()[solid];
        let out = update(mesh, &moved(mesh, |p| rotation * p + Vec3::ONE));
        for (n, rest) in out.iter().zip(&mesh.normals) {
            // The least rotation leaves out a turn about the normal itself, which matters only as far as the
            // rest normal and the computed one differ.
            let exact = rotation * Vec3::from(*rest);
            let allowed = if solid == 2 { 5e-2 } else { 1e-5 };
            prop_assert!(Vec3::from(*n).distance(exact) < allowed, "{n:?} {exact}");
            prop_assert!((Vec3::from(*n).length() - 1.0).abs() < 1e-5);
        }
    }
}
