use std::path::{Path, PathBuf};
use std::time::Duration;

use wirework_asset::Format;
use wirework_preset::Preset;
use wirework_surface::{grid, sphere};

use super::*;
use crate::film::Film;
use crate::fit::Fit;
use crate::mask::masks;
use crate::motion::Basis;
use crate::output::Scene;
use crate::sides::Recorders;
use crate::weld::bits;
use crate::{Fault, Job, When, schedule};

fn preset(text: &str) -> Preset {
    wirework_preset::parse(text.as_bytes(), &wirework_preset::Limits::default()).unwrap().preset
}

fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets").join(file);
    path.exists().then_some(path)
}

fn fine(subject: Subject, wanted: f32) -> (Subject, Refinement) {
    let wanted = vec![wanted; subject.points.len()];
    subject.refined(&wanted, &Limits::default()).unwrap()
}

/// The longest edge of the triangles.
fn longest(subject: &Subject) -> f32 {
    let far = |a: u32, b: u32| {
        let (a, b) = (subject.points[a as usize], subject.points[b as usize]);
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
    };
    subject.triangles.iter().map(|&[a, b, c]| far(a, b).max(far(b, c)).max(far(c, a))).fold(0.0, f32::max)
}

/// What is written of a subject, as `apply` does it: an animation, or the still of a moment.
fn written(subject: Subject, preset: &Preset, when: &When) -> Gltf {
    let limits = Limits::default();
    let masks = masks(&subject, &preset.effects, Path::new(""), &limits).unwrap().complete().unwrap();
    let (basis, model, point_of) = Basis::of(subject);
    let schedule = schedule(when, preset.duration, preset.animated, 8.0, 100).unwrap();
    let fit = Fit { masks, ..Fit::default() };
    let motion = basis.bind(&preset.effects, fit).unwrap();
    let (shade, write) = (Duration::ZERO, Duration::ZERO);
    let recorders = Recorders::default();
    let mut film = Film { motion, schedule, shade, write, recorders, progress: &mut |_| {} };
    let path = Path::new("preset.ron");
    let scene = Scene::new(model, point_of, &limits).unwrap();
    let product = film.gltf(&Job::new(preset, path), Format::Glb, scene, None).unwrap();
    let bytes = product.files.last().unwrap().bytes().unwrap();
    Gltf::from_slice(&bytes, "written", &limits).unwrap()
}

const WAVE: &str = "Deform(units: Bounds, wires: [Wire(
    curve: Polyline(points: [(-0.5, 0, 0), (0.5, 0, 0)]), radius: 0.8,
    pose: Keys([(0, [(-0.5, 0, 0), (0.5, 0, 0)]), (1, [(-0.5, 0.2, 0.1), (0.5, 0.3, 0)])]),
)])";

/// Vertices of one place are at one place, whatever moves.
fn assert_shut(subject: &Subject, gltf: &Gltf) -> usize {
    let rest = gltf.rest().unwrap();
    assert_eq!(rest.positions.len(), subject.point_of.len());
    let mut at = vec![None; subject.points.len()];
    let mut shared = 0;
    for (p, &point) in rest.positions.iter().zip(&subject.point_of) {
        match at[point as usize] {
            None => at[point as usize] = Some(*p),
            Some(other) => {
                let off = (0..3).map(|k| (p[k] - other[k]).abs()).fold(0.0, f32::max);
                assert!(
                    off <= 2e-6 * (1.0 + p.iter().fold(0.0_f32, |a, c| a.max(c.abs()))),
                    "a crack of {off}"
                );
                shared += 1;
            }
        }
    }
    shared
}

#[test]
fn a_mesh_becomes_finer_where_it_is_wanted() {
    let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
    let subject = Subject::from_mesh("sheet", mesh.clone()).unwrap();
    let wanted: Vec<f32> =
        mesh.positions.iter().map(|p| if p[0] < -0.4 { 0.1 } else { f32::INFINITY }).collect();
    let (finer, done) = subject.refined(&wanted, &Limits::default()).unwrap();
    assert_eq!(finer.points[..25], mesh.positions[..]);
    let [told] = done.meshes.as_slice() else { panic!("{done:?}") };
    assert_eq!((told.name.as_str(), told.before, told.after), ("sheet", 25, finer.points.len()));
    for triangle in &finer.triangles {
        let [a, b, c] = triangle.map(|v| finer.points[v as usize]);
        if a[0].max(b[0]).max(c[0]) < -0.49 {
            let side = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
            assert!(side <= 0.101, "{side}");
        }
    }
    let Model::Mesh { mesh, .. } = &finer.model else { panic!() };
    assert!(mesh.faces().any(|face| face.len() == 4), "far away there are quads");
    let (same, done) = fine(finer.clone(), 9.0);
    assert_eq!((same.points, done), (finer.points, Refinement::default()));
}

#[test]
fn a_scene_with_seams_stays_shut_on_all_roads() {
    let preset = preset(WAVE);
    let mesh = sphere([0.0; 3], 1.0, [12, 8]).unwrap();
    let glb = written(Subject::from_mesh("ball", mesh).unwrap(), &preset, &When::At(0.0)).to_glb().unwrap();
    let gltf = Gltf::from_slice(&glb, "ball.glb", &Limits::default()).unwrap();
    let coarse = Subject::from_gltf(gltf).unwrap();
    let points = coarse.points.clone();
    let (subject, done) = fine(coarse, 0.2);
    assert_eq!(subject.points[..points.len()], points[..]);
    assert!(longest(&subject) <= 0.2001 && done.meshes[0].after > 4 * done.meshes[0].before);
    let again = Subject::from_gltf(match &subject.model {
        Model::Gltf { gltf, .. } => (**gltf).clone(),
        Model::Mesh { .. } => panic!(),
    });
    assert_eq!(again.unwrap().point_of, subject.point_of, "read again it is the same");
    let still = written(subject.clone(), &preset, &When::At(1.0));
    assert!(assert_shut(&subject, &still) > 20);
    let rest = still.rest().unwrap();
    let moved = rest.positions.iter().zip(&subject.point_of);
    assert!(moved.filter(|(p, point)| **p != subject.points[**point as usize]).count() > 300);
    let film = written(subject.clone(), &preset, &When::All);
    assert_shut(&subject, &film);
    assert_eq!(film.clip_names().len(), 1);
    // Its end is the still.
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let own = film.rest().unwrap();
    film.player(&own, Some(0)).unwrap().pose_into(1.0, None, &mut positions, &mut normals).unwrap();
    for (p, q) in positions.iter().zip(&rest.positions) {
        assert!((0..3).all(|k| (p[k] - q[k]).abs() < 1e-3), "{p:?} {q:?}");
    }
}

#[test]
fn limits_hold_for_what_is_made() {
    let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
    let subject = Subject::from_mesh("sheet", mesh).unwrap();
    for limits in
        [Limits { vertices: 1000, ..Limits::default() }, Limits { indices: 3000, ..Limits::default() }]
    {
        let error = subject.clone().refined(&[0.01; 25], &limits).unwrap_err();
        assert_eq!(error.fault(), Fault::Limit);
        assert!(error.to_string().contains("--max-"), "{error}");
    }
    assert!(matches!(subject.clone().refined(&[0.1; 24], &Limits::default()), Err(JobError::Refine(_))));
    let zero = subject.refined(&[0.0; 25], &Limits::default()).unwrap_err();
    assert!(zero.to_string().contains("not above 0"), "{zero}");
}

#[test]
fn a_net_keeps_its_tessellation() {
    let text = "Deform(object: Patch(degree: (1, 1), points: [[(0,0,0), (1,0,0)], [(0,0,1), (1,0,1)]], tessellation: (4, 4),
        deform: ControlPoints), wires: [Wire(curve: Polyline(points: [(0,0,0), (1,0,0)]))])";
    let object = preset(text).object.unwrap();
    let subject = Subject::from_object(&object, Path::new(""), "net", &Limits::default()).unwrap();
    let (same, done) = fine(subject.clone(), 0.01);
    assert_eq!((same.points, done.meshes.len(), done.warnings.len()), (subject.points, 0, 1));
}

#[test]
fn real_files_become_finer_and_lose_nothing() {
    let preset = preset(WAVE);
    for (file, wanted) in [("rigged/cesium_man.glb", 0.03), ("rigged/robot.glb", 0.1)] {
        let Some(path) = shared(file) else { continue };
        let coarse = Subject::read(&path, &Limits::default()).unwrap();
        let (points, warnings) = (coarse.points.clone(), coarse.warnings());
        let (subject, done) = fine(coarse, wanted);
        for (a, b) in points.iter().zip(&subject.points) {
            assert_eq!(bits(*a), bits(*b), "{file}");
        }
        assert!(longest(&subject) <= wanted * 1.001, "{file}: {}", longest(&subject));
        assert!(!done.meshes.is_empty());
        assert_eq!(subject.warnings(), warnings, "nothing new to tell");
        assert_shut(&subject, &written(subject.clone(), &preset, &When::At(1.0)));
    }
    for (file, wanted) in [("garment/male_casualsuit04.obj", 0.2), ("garment/plane_30x30.obj", 0.02)] {
        let Some(path) = shared(file) else { continue };
        let coarse = Subject::read(&path, &Limits::default()).unwrap();
        let points = coarse.points.clone();
        let (subject, done) = fine(coarse, wanted);
        assert_eq!(subject.points[..points.len()], points[..], "{file}");
        assert!(done.meshes[0].after > done.meshes[0].before);
        let Model::Mesh { mesh, obj: Some(obj), .. } = &subject.model else { panic!() };
        assert!(mesh.positions == obj.mesh.positions && mesh.face_ends == obj.mesh.face_ends, "{file}");
        // What had no normals is as smooth as it was.
        assert!(obj.mesh.normals.is_empty() || mesh.normals == obj.mesh.normals, "{file}");
        assert!(mesh.normals.iter().all(|n| (n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-4));
        assert!(mesh.corners.iter().all(|corner| corner.normal.is_some()), "{file}");
        let still = written(subject.clone(), &preset, &When::At(1.0));
        assert!(still.rest().unwrap().positions.len() >= mesh.positions.len());
    }
}

/// The uses of edges between points: each border edge, which is used once.
fn borders(subject: &Subject) -> Vec<[u32; 2]> {
    let edges = || subject.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: std::collections::HashSet<[u32; 2]> = edges().collect();
    edges().filter(|&[a, b]| !all.contains(&[b, a])).collect()
}

#[test]
fn edges_are_cut_where_it_is_said() {
    let mesh = grid([2.0, 2.0], [2, 2], [0.0, 1.0, 0.0]).unwrap();
    let glb = written(Subject::from_mesh("sheet", mesh.clone()).unwrap(), &preset(WAVE), &When::At(0.0));
    let glb = Gltf::from_slice(&glb.to_glb().unwrap(), "sheet.glb", &Limits::default()).unwrap();
    for subject in [Subject::from_mesh("sheet", mesh).unwrap(), Subject::from_gltf(glb).unwrap()] {
        let before = borders(&subject);
        let cuts: Vec<Cut> =
            before.iter().take(3).map(|&ends| Cut { ends, shares: vec![0.125, 0.7] }).collect();
        let points = subject.points.clone();
        let (finer, places, done) = subject.cut(&cuts, &Limits::default()).unwrap();
        assert!(done.meshes.len() == 1 && done.warnings.is_empty());
        assert_eq!(finer.points[..points.len()], points[..]);
        assert_eq!(finer.points.len(), points.len() + 6);
        let after = borders(&finer);
        for (Cut { ends: [p, q], shares }, new) in cuts.iter().zip(&places) {
            for pair in [&[*p][..], new, &[*q]].concat().windows(2) {
                assert!(after.contains(&[pair[0], pair[1]]), "a part of the border");
            }
            for (&point, &share) in new.iter().zip(shares) {
                let (a, b) = (points[*p as usize], points[*q as usize]);
                let mix = |k: usize| f64::from(a[k]) * (1.0 - share) + f64::from(b[k]) * share;
                assert_eq!(finer.points[point as usize], [0, 1, 2].map(|k| mix(k) as f32));
            }
        }
        assert_eq!(after.len(), before.len() + 6, "no other border");
    }
}

#[test]
fn borders_that_lie_on_each_other_stay_two_and_seams_stay_one() {
    // Two sheets whose borders cross in their middles; they are joined in points of their own.
    let text = b"v 0 0 0\nv 2 0 0\nv 0 2 0\nv 1 -1 0\nv 1 1 0\nv 3 0 0\nv 0 0 0\nf 1 2 3\nf 4 6 5\nf 2 7 4\n";
    let obj = Obj::from_slice(text, "two.obj", &Limits::default()).unwrap();
    let mesh = obj.mesh.clone();
    let subject = Subject::new(Model::Mesh {
        parts: vec![MeshPart::whole("two", &mesh, false)],
        mesh,
        obj: Some(Box::new(obj)),
    })
    .unwrap();
    assert_eq!((subject.points.len(), subject.point_of[6]), (6, 0));
    let cuts = [[0, 1], [4, 3]].map(|ends| Cut { ends, shares: vec![0.5] });
    let (finer, places, _) = subject.cut(&cuts, &Limits::default()).unwrap();
    assert_eq!(places, [[6], [7]]);
    assert_eq!(finer.points[6], finer.points[7]);
    // Both sides of the first edge have positions of their own, and one point.
    assert_eq!(finer.point_of[7..], [6, 6, 7]);
    let Model::Mesh { mesh, obj: Some(obj), .. } = &finer.model else { panic!() };
    assert!(mesh.positions.len() == 10 && obj.mesh.positions == mesh.positions);
    // Halving does not join them either.
    let (again, _) = fine(finer.clone(), 0.9);
    assert_eq!(again.points[..8], finer.points[..]);
}

#[test]
fn what_cannot_be_cut_is_told() {
    let subject = Subject::from_mesh("sheet", grid([1.0; 2], [2, 2], [0.0, 1.0, 0.0]).unwrap()).unwrap();
    let cut = |ends, shares: &[f64]| [Cut { ends, shares: shares.to_vec() }];
    let limits = Limits::default();
    for bad in [cut([0, 8], &[0.5]), cut([0, 1], &[1.0]), cut([0, 9], &[0.5])] {
        assert!(matches!(subject.clone().cut(&bad, &limits), Err(JobError::Refine(_))));
    }
    let few = Limits { vertices: 10, ..limits };
    let error = subject.clone().cut(&cut([0, 1], &[0.1, 0.2]), &few).unwrap_err();
    assert_eq!(error.fault(), Fault::Limit);
    let (same, places, _) = subject.clone().cut(&[], &limits).unwrap();
    assert!(same.points == subject.points && places.is_empty());
    let text = "Deform(object: Patch(degree: (1, 1), points: [[(0,0,0), (1,0,0)], [(0,0,1), (1,0,1)]], tessellation: (4, 4),
        deform: ControlPoints), wires: [Wire(curve: Polyline(points: [(0,0,0), (1,0,0)]))])";
    let object = preset(text).object.unwrap();
    let net = Subject::from_object(&object, Path::new(""), "net", &limits).unwrap();
    let (same, places, done) = net.clone().cut(&cut([0, 1], &[0.5]), &limits).unwrap();
    assert_eq!((same.points, places, done.warnings.len()), (net.points, vec![vec![]], 1));
}
