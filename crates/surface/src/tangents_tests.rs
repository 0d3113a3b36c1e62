use std::f32::consts::{PI, TAU};

use glam::Quat;
use proptest::prelude::*;

use super::*;
use crate::{Corner, Mesh, Normals, NormalsBuffer, VertexMesh, sphere, tube};

/// Vertices with tangents that `MikkTSpace` made.
struct Model {
    mesh: VertexMesh,
    uvs: Vec<[f32; 2]>,
    tangents: Vec<[f32; 3]>,
}

impl Model {
    fn new(mesh: &Mesh) -> Self {
        let mesh = VertexMesh::new(mesh).unwrap();
        let uvs = mesh.uvs.clone().unwrap();
        let tangents = mikktspace(&mesh, &uvs, &mesh.positions, &mesh.normals);
        Self { mesh, uvs, tangents }
    }

    fn moved(&self, f: impl Fn(Vec3) -> Vec3) -> Vec<[f32; 3]> {
        self.mesh.positions.iter().map(|&p| f(Vec3::from(p)).to_array()).collect()
    }

    /// Normals and tangents of deformed positions.
    fn update(&self, positions: &[[f32; 3]]) -> [Vec<[f32; 3]>; 2] {
        let mesh = &self.mesh;
        let mut normals = mesh.normals.clone();
        let model = Normals::new(&mesh.positions, &mesh.normals, &mesh.triangles).unwrap();
        model.update_into(positions, &mut NormalsBuffer::default(), &mut normals).unwrap();
        let tangents = &self.tangents;
        let model =
            Tangents::new(&mesh.positions, &mesh.normals, tangents, &self.uvs, &mesh.triangles).unwrap();
        let mut out = vec![[0.0; 3]; tangents.len()];
        model.update_into(positions, &normals, &mut TangentsBuffer::default(), &mut out).unwrap();
        [normals, out]
    }
}

struct Faces<'a> {
    mesh: &'a VertexMesh,
    uvs: &'a [[f32; 2]],
    positions: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
    sums: Vec<Vec3>,
}

impl bevy_mikktspace::Geometry for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.mesh.triangles[face][corner] as usize]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.mesh.triangles[face][corner] as usize]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.mesh.triangles[face][corner] as usize]
    }

    fn set_tangent(&mut self, space: Option<bevy_mikktspace::TangentSpace>, face: usize, corner: usize) {
        let vertex = self.mesh.triangles[face][corner] as usize;
        self.sums[vertex] += space.map_or(Vec3::ZERO, |space| Vec3::from(space.tangent()));
    }
}

/// The tangents of `MikkTSpace`, their mean over the corners of each vertex.
fn mikktspace(
    mesh: &VertexMesh,
    uvs: &[[f32; 2]],
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
) -> Vec<[f32; 3]> {
    let mut faces = Faces { mesh, uvs, positions, normals, sums: vec![Vec3::ZERO; positions.len()] };
    bevy_mikktspace::generate_tangents(&mut faces).unwrap();
    faces.sums.iter().map(|sum| sum.normalize_or_zero().to_array()).collect()
}

/// Rows of quads; positions and normals by `f` of texture coordinates from 0 to 1.
fn sheet(cells: [u32; 2], f: impl Fn(f32, f32) -> [Vec3; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=cells[1] {
        for i in 0..=cells[0] {
            let uv = [i as f32 / cells[0] as f32, j as f32 / cells[1] as f32];
            let [position, normal] = f(uv[0], uv[1]);
            mesh.positions.push(position.to_array());
            mesh.normals.push(normal.to_array());
            mesh.uvs.push(uv);
        }
    }
    for j in 0..cells[1] {
        for i in 0..cells[0] {
            let at = |i: u32, j: u32| j * (cells[0] + 1) + i;
            for position in [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] {
                let own = Some(position);
                mesh.corners.push(Corner { position, uv: own, normal: own });
            }
            mesh.face_ends.push(mesh.corners.len() as u32);
        }
    }
    mesh
}

/// The unit square, `u` along x.
fn square(cells: u32) -> Model {
    Model::new(&sheet([cells; 2], |u, v| [Vec3::new(u, v, 0.0), Vec3::Z]))
}

fn torus() -> Model {
    Model::new(&sheet([96, 48], |u, v| {
        let out = Vec3::new((TAU * u).cos(), (TAU * u).sin(), 0.0);
        let normal = out * (TAU * v).cos() + Vec3::Z * (TAU * v).sin();
        [out + 0.3 * normal, normal]
    }))
}

fn ball() -> Model {
    Model::new(&sphere([0.0; 3], 1.0, [96, 48]).unwrap())
}

fn pipe() -> Model {
    Model::new(&tube([0.0; 3], [0.0, 3.0, 0.0], 0.3, 48, 61, true).unwrap())
}

fn angle(a: [f32; 3], b: [f32; 3]) -> f32 {
    let (a, b) = (Vec3::from(a), Vec3::from(b));
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Bends the y axis to a circle about the z axis.
fn bend(p: Vec3) -> Vec3 {
    let (sin, cos) = (0.6 * p.y).sin_cos();
    let out = 1.0 / 0.6 - p.x;
    Vec3::new(1.0 / 0.6 - out * cos, out * sin, p.z)
}

fn twist(p: Vec3) -> Vec3 {
    Quat::from_axis_angle(Vec3::Y, 0.8 * p.y) * p
}

#[test]
fn rest_is_the_identity() {
    for model in [square(3), torus(), ball(), pipe()] {
        assert_eq!(model.update(&model.mesh.positions)[1], model.tangents);
    }
}

#[test]
fn stretch_and_shear_have_their_closed_forms() {
    let model = square(4);
    for map in [
        glam::Mat3::from_diagonal(Vec3::new(3.0, 0.5, 1.0)),
        glam::Mat3::from_cols(Vec3::new(1.0, 0.7, 0.2), Vec3::new(0.4, 1.3, -0.5), Vec3::Z),
    ] {
        let [normals, tangents] = model.update(&model.moved(|p| map * p));
        let exact = [map.x_axis.cross(map.y_axis), map.x_axis].map(|v| v.normalize().to_array());
        for (n, t) in normals.iter().zip(&tangents) {
            assert!(angle(*n, exact[0]) < 1e-3 && angle(*t, exact[1]) < 1e-3, "{n:?} {t:?} {exact:?}");
        }
    }
}

#[test]
fn bend_and_twist_have_their_closed_forms() {
    let model = square(100);
    // Bent along u, so that the tangent turns in the plane of x and z, and twisted about y, along v.
    let rolled = |p: Vec3| Vec3::new((2.0 * p.x).sin() / 2.0, p.y, (1.0 - (2.0 * p.x).cos()) / 2.0);
    let along_roll = |p: Vec3| Vec3::new((2.0 * p.x).cos(), 0.0, (2.0 * p.x).sin());
    let along_twist = |p: Vec3| Quat::from_axis_angle(Vec3::Y, 0.8 * p.y) * Vec3::X;
    let rolled = (model.update(&model.moved(rolled)), &along_roll as &dyn Fn(Vec3) -> Vec3);
    let twisted = (model.update(&model.moved(twist)), &along_twist as &dyn Fn(Vec3) -> Vec3);
    for ([_, tangents], exact) in [rolled, twisted] {
        for (t, p) in tangents.iter().zip(&model.mesh.positions) {
            let border = p[0].min(p[1]).min(1.0 - p[0]).min(1.0 - p[1]) < 1e-3;
            let off = angle(*t, exact(Vec3::from(*p)).to_array());
            // One-sided differences at the border: half a cell of the bend.
            assert!(off < if border { 0.7 } else { 0.02 }, "{off} at {p:?}");
        }
    }
}

#[test]
fn deformed_tangents_are_those_of_mikktspace() {
    /// The mean over all vertices, degrees, where tangents turn by 30 to 140 degrees. Most of it is that weights are
    /// the angles of the rest.
    const MEAN: f32 = 0.1;
    /// The worst vertex: at a cap's rim where the wave folds the ring of faces round it.
    const WORST: f32 = 3.5;
    let wave = |p: Vec3| p + 0.15 * Vec3::new((4.0 * p.y).sin(), (3.0 * p.z).cos(), (5.0 * p.x).sin());
    for (name, model) in [("torus", torus()), ("ball", ball()), ("pipe", pipe())] {
        let moves = [("wave", model.moved(wave)), ("bend", model.moved(bend)), ("twist", model.moved(twist))];
        for (how, now) in moves {
            let [normals, tangents] = model.update(&now);
            let exact = mikktspace(&model.mesh, &model.uvs, &now, &normals);
            let off: Vec<f32> = tangents.iter().zip(&exact).map(|(a, b)| angle(*a, *b)).collect();
            let turned = tangents.iter().zip(&model.tangents).map(|(a, b)| angle(*a, *b));
            assert!(turned.fold(0.0, f32::max) > 30.0, "{name}, {how}");
            let (worst, sum) = (off.iter().copied().fold(0.0, f32::max), off.iter().sum::<f32>());
            let mean = sum / off.len() as f32;
            assert!(worst < WORST && mean < MEAN, "{name}, {how}: {worst}, {mean} degrees");
        }
    }
}

#[test]
fn the_computed_tangents_of_the_rest_are_those_of_mikktspace() {
    for model in [torus(), ball(), pipe()] {
        let mesh = &model.mesh;
        let made =
            Tangents::new(&mesh.positions, &mesh.normals, &model.tangents, &model.uvs, &mesh.triangles)
                .unwrap();
        for group in &made.groups {
            let off = angle(group.computed, group.tangent);
            assert!(off < 0.01, "{off} degrees at {:?}", mesh.positions[group.vertex as usize]);
        }
    }
}

#[test]
fn what_has_not_moved_keeps_its_bits() {
    let model = ball();
    let [_, out] = model.update(&model.moved(|p| if p.y > 0.8 { p * 1.5 } else { p }));
    let changed = out.iter().zip(&model.tangents).zip(&model.mesh.positions).filter(|((t, rest), p)| {
        // Normals see one ring below the moved ones, and tangents no more than those.
        assert!(p[1] > 0.5 || t.map(f32::to_bits) == rest.map(f32::to_bits));
        t != rest
    });
    assert!(changed.count() > 0);
}

#[test]
fn other_tangents_keep_their_angle_to_those_of_the_coordinates() {
    let mut model = square(4);
    // As of coordinates turned by 30 degrees, of another length, and not quite in the plane.
    model.tangents.fill([3.0_f32.sqrt(), 1.0, 0.1]);
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 2.0);
    for t in &model.update(&model.moved(|p| turn * p))[1] {
        assert!(Vec3::from(*t).distance(turn * Vec3::from(model.tangents[0])) < 1e-5);
    }
    for t in &model.update(&model.moved(|p| p + Vec3::Y * p.x))[1] {
        assert!((angle(*t, Vec3::new(1.0, 1.0, 0.0).normalize().to_array()) - 30.0).abs() < 4.0, "{t:?}");
    }
}

#[test]
fn without_coordinates_they_turn_with_the_normals() {
    let mut model = square(4);
    model.uvs.fill([0.5; 2]);
    let turn = Quat::from_rotation_y(1.0);
    for t in &model.update(&model.moved(|p| turn * p))[1] {
        assert!(Vec3::from(*t).distance(turn * Vec3::X) < 1e-5, "{t:?}");
    }
    // A face that is drawn to a line has a normal no more, and says nothing of tangents.
    assert_eq!(model.update(&model.moved(|p| Vec3::X * p.x))[1], model.tangents);
    assert_eq!(model.update(&model.moved(|_| Vec3::NAN))[1], model.tangents);
}

#[test]
fn vertices_without_normal_or_tangent_stay_as_they_are() {
    let mut model = square(2);
    model.mesh.normals[0] = [0.0; 3];
    model.tangents[1] = [0.0; 3];
    let kept = model.tangents.clone();
    let [_, out] = model.update(&model.moved(bend));
    assert_eq!((out[0], out[1]), (kept[0], [0.0; 3]));
    assert!(out[8] != kept[8]);
}

#[test]
fn wrong_lengths_and_indices_are_errors() {
    let (p, uvs) = ([[0.0; 3]; 3], [[0.0; 2]; 3]);
    let error = Tangents::new(&p, &p, &p, &uvs, &[[0, 1, 3]]).unwrap_err();
    assert_eq!(error, NormalsError::Index { triangle: 0, vertex: 3, vertices: 3 });
    assert!(Tangents::new(&p, &p[..2], &p, &uvs, &[]).is_err());
    assert!(Tangents::new(&p, &p, &p[..2], &uvs, &[]).is_err());
    assert!(Tangents::new(&p, &p, &p, &uvs[..2], &[]).is_err());
    let model = Tangents::new(&p, &p, &p, &uvs, &[[0, 1, 2]]).unwrap();
    let mut buffer = TangentsBuffer::default();
    assert!(model.update_into(&p[..1], &p, &mut buffer, &mut [[0.0; 3]; 3]).is_err());
    assert!(model.update_into(&p, &p[..1], &mut buffer, &mut [[0.0; 3]; 3]).is_err());
    assert!(model.update_into(&p, &p, &mut buffer, &mut []).is_err());
    assert!(
        Tangents::new(&[], &[], &[], &[], &[]).unwrap().update_into(&[], &[], &mut buffer, &mut []).is_ok()
    );
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let model = Model::new(&sphere([0.0; 3], 1.0, [200, 100]).unwrap());
    let positions = model.moved(|p| p + 0.1 * Vec3::new((9.0 * p.y).sin(), (7.0 * p.z).cos(), p.x * p.y));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| model.update(&positions))
    };
    let one = run(1);
    assert!(one == run(2) && one == run(7));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Whatever moves, if it does not tear: unit, perpendicular, shared where shared, the input's where nothing has moved.
    #[test]
    fn frames_stay_frames(
        shift in prop::array::uniform3(-0.3_f32..0.3),
        pitch in prop::array::uniform3(-6.0_f32..6.0),
        floor in -1.0_f32..1.0,
        which in 0_usize..3,
    ) {
        let model = [torus, ball, pipe][which]();
        let now = model.moved(|p| {
            let rise = (p.y - floor).max(0.0);
            p + rise * Vec3::from(shift) * (Vec3::from(pitch) * Vec3::new(p.y, p.z, p.x)).map(f32::sin)
        });
        let [normals, tangents] = model.update(&now);
        let mut shared = HashMap::new();
        for (v, (t, n)) in tangents.iter().zip(&normals).enumerate() {
            let length = Vec3::from(*t).length();
            let rest = [model.mesh.positions[v], model.mesh.normals[v], model.tangents[v]];
            if rest[2] == [0.0; 3] {
                prop_assert_eq!(t, &rest[2]);
                continue;
            }
            prop_assert!((length - 1.0).abs() < 1e-5, "length {}", length);
            // The normals themselves are only as perpendicular as their own turn has left them.
            prop_assert!(Vec3::from(*t).dot(Vec3::from(*n)).abs() < 1e-5, "{:?} {:?}", t, n);
            if model.mesh.positions[v][1] < floor - 0.2 {
                prop_assert_eq!(t.map(f32::to_bits), rest[2].map(f32::to_bits));
            }
            let first = *shared.entry(rest.map(|v| v.map(|c| (c + 0.0).to_bits()))).or_insert(v);
            prop_assert_eq!(t, &tangents[first]);
        }
    }

    /// A rigid motion turns the tangents with it.
    #[test]
    fn rigid_motions_commute(
        axis in prop::array::uniform3(-1.0_f32..1.0),
        angle in prop_oneof![Just(PI), Just(PI * 0.5), -PI..PI, -1e-4_f32..1e-4],
        which in 0_usize..3,
    ) {
        let rotation = Quat::from_axis_angle(Vec3::from(axis).normalize_or(Vec3::X), angle);
        let model = [torus, ball, pipe][which]();
        // Exact normals: those that follow leave out a turn about the normal itself.
        let normals: Vec<[f32; 3]> =
            model.mesh.normals.iter().map(|n| (rotation * Vec3::from(*n)).to_array()).collect();
        let mesh = &model.mesh;
        let made =
            Tangents::new(&mesh.positions, &mesh.normals, &model.tangents, &model.uvs, &mesh.triangles).unwrap();
        let mut out = vec![[0.0; 3]; normals.len()];
        let now = model.moved(|p| rotation * p);
        made.update_into(&now, &normals, &mut TangentsBuffer::default(), &mut out).unwrap();
        for (t, rest) in out.iter().zip(&model.tangents) {
            let exact = rotation * Vec3::from(*rest);
            prop_assert!(Vec3::from(*t).distance(exact) < 1e-4, "{:?} {}", t, exact);
        }
    }
}
