//! Stills and a GIF of 48 frames, each beside a plain copy of the pixels it makes, all in one run.
//!
//! `cargo bench -p wirework-render` prints medians of several rounds on two threads and, since machines differ and vary, every
//! figure in *copies*: the time one thread takes to copy the pixels once.

use std::hint::black_box;
use std::time::Instant;

use wirework_render::{
    Animation, AnimationKind, Camera, Framing, Line, LineKind, Part, Picture, Renderer, Scene, Settings,
    View, png,
};
use wirework_surface::{grid, smooth_normals};

/// Cells along a side of the sheet: 99 458 triangles.
const CELLS: u32 = 223;

/// Rounds, of which the median counts.
const ROUNDS: usize = 7;

/// Frames of the animation.
const FRAMES: u16 = 48;

fn main() {
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool of two threads");
    two.install(|| {
        stills();
        animations();
    });
}

fn stills() {
    let settings = Settings::default();
    let (scene, camera) = (sheet(1.0), camera(settings.size));
    let picture = Renderer::default().render(&scene, &camera, &settings).expect("a picture");
    let copy = copy(&picture.pixels);
    println!("copy of {}×{} pixels, one thread: {:.3} ms", picture.width, picture.height, copy * 1e3);
    for (name, fast) in [("still of 99k triangles", false), ("the same, fast", true)] {
        let settings = Settings { fast, ..settings };
        let mut renderer = Renderer::default();
        let time = median(|| seconds(|| renderer.render(&scene, &camera, &settings)));
        report(name, time, copy);
    }
    report("png", median(|| seconds(|| png(&picture))), copy);
}

fn animations() {
    let settings = Settings { size: [640, 360], ..Settings::default() };
    let camera = camera(settings.size);
    let mut renderer = Renderer::default();
    let (mut frames, mut rendering) = (vec![], 0.0);
    for i in 0..FRAMES {
        let time = 0.5 - 0.5 * (f32::from(i) / f32::from(FRAMES) * std::f32::consts::TAU).cos();
        let scene = sheet(time);
        rendering += seconds(|| frames.push(renderer.render(&scene, &camera, &settings).expect("a picture")));
    }
    let pixels: Vec<[u8; 4]> = frames.iter().flat_map(|f| &f.pixels).copied().collect();
    let copy = copy(&pixels);
    println!("copy of {FRAMES} frames of 640×360 pixels, one thread: {:.2} ms", copy * 1e3);
    report("rendering (once)", rendering, copy);
    for (name, kind) in [("gif", AnimationKind::Gif), ("apng", AnimationKind::Apng)] {
        let mut bytes = 0;
        let time = median(|| seconds(|| bytes = encoded(kind, settings.size, &frames)));
        report(&format!("{name}, {bytes} bytes"), time, copy);
    }
}

fn encoded(kind: AnimationKind, size: [u32; 2], frames: &[Picture]) -> usize {
    let mut animation = Animation::new(kind, size, 24.0).expect("a size and a rate in range");
    for frame in frames {
        animation.push(frame).expect("a frame of that size");
    }
    animation.finish().expect("frames").len()
}

/// A sheet whose creases rise with time, and the wires that would make them.
fn sheet(time: f32) -> Scene {
    let at = [-0.44_f32, -0.22, 0.0, 0.22, 0.44];
    let center = |x: f32, z: f32| z + 0.05 * (3.0 * x).sin();
    let height = |x: f32, z: f32| {
        let crease = |a: &f32| (1.0 - ((z - center(x, *a)) / 0.085).powi(2)).max(0.0).powi(2);
        let fade = (1.0 - (x / 0.75).powi(2)).max(0.0).powi(2);
        0.06 * time * fade * at.iter().map(crease).sum::<f32>()
    };
    let mut mesh = grid([2.0, 1.6], [CELLS, CELLS], [0.0, 1.0, 0.0]).expect("a grid");
    mesh.positions.iter_mut().for_each(|p| p[1] += height(p[0], p[2]));
    let triangles = mesh.triangles().expect("quads");
    let normals = smooth_normals(&mesh.positions, &triangles);
    let part = Part { positions: mesh.positions, normals, triangles, ..Part::default() };
    let kind = LineKind::Wire;
    let wire = |a: f32| {
        let point = |i: u8| {
            let x = f32::from(i) / 40.0 * 1.5 - 0.75;
            [x, height(x, center(x, a)), center(x, a)]
        };
        Line { points: (0..=40).map(point).collect(), color: kind.color(), width: 2.5, kind }
    };
    Scene { parts: vec![part], lines: at.map(wire).to_vec(), dots: vec![], ground: Some(-0.05) }
}

fn camera(size: [u32; 2]) -> Camera {
    let mut framing = Framing::new(View::ThreeQuarter, size).expect("a view");
    for time in [0.0, 1.0] {
        framing.add(sheet(time).parts.into_iter().flat_map(|part| part.positions));
    }
    framing.camera().expect("points")
}

fn copy(pixels: &[[u8; 4]]) -> f64 {
    let mut out = black_box(vec![[0; 4]; pixels.len()]);
    median(|| {
        seconds(|| {
            out.copy_from_slice(black_box(pixels));
            black_box(&out);
        })
    })
}

fn report(name: &str, time: f64, copy: f64) {
    println!("  {name:34} {:8.1} ms  {:8.0} copies", time * 1e3, time / copy);
}

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

fn median(mut round: impl FnMut() -> f64) -> f64 {
    let mut times: Vec<f64> = (0..ROUNDS).map(|_| round()).collect();
    times.sort_unstable_by(f64::total_cmp);
    times[ROUNDS / 2]
}
