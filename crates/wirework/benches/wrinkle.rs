//! Twelve creases on 200 000 vertices: a frame, deformation and normals, beside a copy of the positions, all in one run.
//!
//! `cargo bench -p wirework --bench wrinkle` prints medians of several rounds in *copies*: the time one thread takes to copy the positions
//! once into memory that it has used before. Frames are worked out on two threads.

use std::hint::black_box;
use std::time::Instant;

use wirework::surface::{Normals, NormalsBuffer, grid, tube};
use wirework::{Evaluation, Mesh, parse, preset::Limits};

/// Frames, of which the median counts.
const FRAMES: usize = 15;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool of two threads");
    let sheet = grid([2.0, 2.0], [447, 447], [0.0, 1.0, 0.0]).expect("a grid");
    let hose = tube([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], 0.4, 447, 448, false).expect("a tube");
    let anchored = "size: (1.6, 1.6), creases: 12, thickness: Ease([(0, 0.07), (1, 0.08)]), intensity: Ease([(0, 0), (1, 0.05)])";
    let travelling = format!("{anchored}, motion: Travelling(velocity: (0.05, 0.1))");
    let ripple = format!("{anchored}, pattern: Ripple, motion: Travelling(velocity: (0.1, 0))");
    pool.install(|| {
        measure("a sheet", &sheet, "center: (0, 0, 0)", anchored);
        measure("a sheet, travelling", &sheet, "center: (0, 0, 0)", &travelling);
        measure("a sheet, travelling rings", &sheet, "center: (0, 0, 0)", &ripple);
        measure("a hose", &hose, "center: (0.4, 0, 0), direction: (0, 0, 1)", anchored);
        measure("a hose, travelling", &hose, "center: (0.4, 0, 0), direction: (0, 0, 1)", &travelling);
    });
}

fn measure(name: &str, mesh: &Mesh, place: &str, fields: &str) {
    let text = format!("Wrinkle({place}, {fields})");
    let preset = parse(text.as_bytes(), &Limits::default()).expect("a preset").preset;
    let triangles = mesh.triangles().expect("triangles");
    let rest = &mesh.positions;
    let smooth = wirework::surface::smooth_normals(rest, &triangles);
    let normals = Normals::new(rest, &smooth, &triangles).expect("normals");
    let start = Instant::now();
    let mut effect = Evaluation::new(&preset.effects, rest, &triangles).expect("creases");
    let bind = start.elapsed().as_secs_f64();
    let (mut points, mut directions, mut buffer) = (rest.clone(), smooth.clone(), NormalsBuffer::default());
    let mut times: [Vec<f64>; 3] = Default::default();
    for frame in 0..=FRAMES {
        let mut round = [0.0; 3];
        let timed = |time: &mut f64, work: &mut dyn FnMut()| {
            let start = Instant::now();
            work();
            *time = start.elapsed().as_secs_f64();
        };
        timed(&mut round[0], &mut || points.copy_from_slice(black_box(rest)));
        timed(&mut round[1], &mut || effect.at(frame as f64 / 24.0, &mut points).expect("a frame"));
        timed(&mut round[2], &mut || {
            normals.update_into(&points, &mut buffer, &mut directions).expect("normals");
        });
        black_box((&points, &directions));
        // The first frame finds its memory.
        if frame > 0 {
            times.iter_mut().zip(round).for_each(|(all, time)| all.push(time));
        }
    }
    let [copy, deform, shade] = times.map(median);
    println!(
        "{name}: {} vertices, a copy {:.3} ms; laid and bound in {:.0} copies; a frame {:.0} copies: {:.0} to deform, {:.0} for normals",
        rest.len(),
        copy * 1e3,
        bind / copy,
        (deform + shade) / copy,
        deform / copy,
        shade / copy
    );
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
