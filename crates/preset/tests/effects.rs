//! Presets through the engine: what they describe happens.

use std::path::Path;

use wirework_core::{Binding, Blend, LatticeBinding, Wire};
use wirework_preset::{Action, Limits, parse};
use wirework_surface::Mesh;
use wirework_wrinkle::{SurfaceView, creases};

/// The object of a preset and where its vertices are at some times.
fn run(name: &str, times: &[f64]) -> (Mesh, Vec<Vec<[f32; 3]>>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../presets").join(name);
    let preset = parse(&std::fs::read(path).expect("a preset"), &Limits::default()).expect("good").preset;
    let mesh = preset.object.expect("an object").build().expect("a mesh").expect("no file");
    let [effect] = preset.effects.as_slice() else { panic!("{name} is a stack") };
    let lattice = match &effect.action {
        Action::Deform(deform) => deform.lattice,
        Action::Wrinkle(_) | Action::Stitch(_) | Action::Ik(_) => None,
    };
    let at: Box<dyn Fn(f64) -> (Vec<Wire>, Blend)> = match effect.action.clone() {
        Action::Deform(deform) => Box::new(move |seconds| {
            (deform.wires.iter().map(|wire| wire.at(seconds)).collect(), deform.blend)
        }),
        Action::Wrinkle(settings) => {
            let triangles = mesh.triangles().expect("triangles");
            let surface = SurfaceView { positions: &mesh.positions, triangles: &triangles };
            let creases = creases(&surface, &settings).expect("creases");
            Box::new(move |seconds| {
                let mut wires = Vec::new();
                creases.clone().wires_at(seconds, &mut wires);
                (wires, creases.blend())
            })
        }
        Action::Stitch(_) | Action::Ik(_) => panic!("{name} is neither of wires nor of creases"),
    };
    let mut frames = Vec::new();
    for &seconds in times {
        let (wires, blend) = at(seconds);
        let mut out = lattice.map_or_else(|| mesh.positions.clone(), |lattice| lattice.points());
        let mut binding = Binding::new(&wires, &out).expect("a binding");
        binding.deform_into(&wires, &blend, &mut out).expect("a deformation");
        if let Some(lattice) = lattice {
            let controls = std::mem::replace(&mut out, mesh.positions.clone());
            let bound = LatticeBinding::new(&lattice, &mesh.positions, None).expect("a binding");
            bound.deform_into(&controls, &mut out).expect("a deformation");
        }
        frames.push(out);
    }
    (mesh, frames)
}

/// The largest distance between positions, and how many differ at all.
fn moved(a: &[[f32; 3]], b: &[[f32; 3]]) -> (f32, usize) {
    let distance =
        |p: &[f32; 3], q: &[f32; 3]| p.iter().zip(q).map(|(p, q)| (p - q).powi(2)).sum::<f32>().sqrt();
    let far = a.iter().zip(b).map(|(p, q)| distance(p, q)).fold(0.0, f32::max);
    (far, a.iter().zip(b).filter(|(p, q)| p != q).count())
}

#[test]
fn presets_begin_at_rest_and_move_what_they_say() {
    for (name, time, least, most) in [
        ("deform/lift.ron", 1.0, 0.4, 0.9),
        ("deform/twist.ron", 1.5, 0.3, 0.9),
        ("deform/bulge.ron", 1.0, 0.1, 0.25),
        ("deform/arm.ron", 0.5, 0.3, 0.7),
        ("deform/domain.ron", 2.0, 0.5, 0.6),
        ("deform/direction.ron", 1.5, 0.1, 0.18),
        ("deform/lattice.ron", 1.0, 1.0, 1.6),
        ("deform/wirelattice.ron", 2.0, 1.2, 1.5),
        ("wrinkle/forehead.ron", 1.5, 0.02, 0.06),
        ("wrinkle/sleeve.ron", 1.5, 0.07, 0.085),
    ] {
        let (mesh, frames) = run(name, &[0.0, time]);
        assert_eq!(mesh.positions, frames[0], "{name} begins at rest");
        let (far, count) = moved(&mesh.positions, &frames[1]);
        assert!((least..=most).contains(&far), "{name}: {far}");
        assert!(count > mesh.positions.len() / 20, "{name}: {count} of {}", mesh.positions.len());
        if let Ok(folder) = std::env::var("WIREWORK_TEST_OBJ") {
            write(&Path::new(&folder).join(name.replace('/', "_")), &mesh, &frames[1]);
        }
    }
}

#[test]
fn a_lattice_of_wires_moves_faces_without_ripples() {
    // At 1 s the right face is out, at 2 s its top row leans on and at 2.75 s it has swayed.
    let (mesh, frames) = run("deform/wirelattice.ron", &[1.0, 2.0, 2.75]);
    let at = |frame: usize, y: f32, z: f32| -> [f32; 3] {
        let here = |p: &[f32; 3]| p[0] == 1.0 && (p[1] - y).abs() < 1e-4 && (p[2] - z).abs() < 1e-4;
        let index = mesh.positions.iter().position(here).expect("a vertex");
        [0, 1, 2].map(|axis| frames[frame][index][axis] - mesh.positions[index][axis])
    };
    let places: Vec<f32> = (0_u8..=32).map(|i| f32::from(i) / 16.0 - 1.0).collect();
    let face: Vec<f32> = places
        .iter()
        .flat_map(|&y| places.iter().map(move |&z| (y, z)))
        .map(|(y, z)| at(0, y, z)[0])
        .collect();
    let (least, most) = face.iter().fold((f32::MAX, 0.0_f32), |(a, b), x| (a.min(*x), b.max(*x)));
    assert!(least > 0.5 && most < 0.8, "{least} to {most}");
    assert!(most - least < 0.1, "the face stays nearly flat: {least} to {most}");
    for z in [-1.0, 0.5, 1.0] {
        let rising: Vec<[f32; 3]> = places.iter().map(|&y| at(1, y, z)).collect();
        assert!(
            rising.windows(2).all(|w| w[1][0] > w[0][0] - 1e-3),
            "farther out from row to row: {rising:?}"
        );
        assert!(rising[32][0] > rising[0][0] + 0.4, "{rising:?}");
        assert!(at(2, 1.0, z)[2] > 0.3 && at(2, -1.0, z)[2] < 0.1);
    }
}

/// An OBJ to look at, where the environment asks for one.
fn write(path: &Path, mesh: &Mesh, positions: &[[f32; 3]]) {
    use std::fmt::Write as _;
    let mut text = String::new();
    for [x, y, z] in positions {
        writeln!(text, "v {x} {y} {z}").expect("a string");
    }
    for t in mesh.triangles().expect("triangles") {
        writeln!(text, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1).expect("a string");
    }
    std::fs::write(path.with_extension("obj"), text).expect("a file");
}
