//! One wire on a million points, and sixteen, beside a copy of the positions and the float64 reference, all in one run.
//!
//! `cargo bench -p wirework-core` prints medians of several rounds and, since machines differ and vary, every figure in
//! *copies*: the time one thread takes to copy the mesh's positions once.

use std::hint::black_box;
use std::time::Instant;

use wirework_core::{Binding, Blend, Curve, Domain, Locator, Wire};
use wirework_reference::Scene;

/// Points along a side of the grid.
const SIDE: usize = 1000;

/// Rounds, of which the median counts.
const ROUNDS: usize = 9;

/// Points given to the reference, spread over the grid: it is too slow for all.
const SAMPLE: usize = 2000;

fn main() {
    let grid = grid();
    let shuffled = shuffled(&grid);
    let copy = median(|| {
        let mut out = black_box(vec![[0.0_f32; 3]; grid.len()]);
        let start = Instant::now();
        out.copy_from_slice(black_box(&grid));
        black_box(&out);
        start.elapsed().as_secs_f64()
    });
    println!("copy of {} positions, one thread: {:.2} ms", grid.len(), copy * 1e3);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool of two threads");
    let wires = [moved(snake(0.0, 1.5))];
    let brute = reference(&wires, &grid);
    one.install(|| measure("1 wire, 1 thread, rows of a grid", &wires, &grid, copy, brute));
    one.install(|| measure("1 wire, 1 thread, shuffled", &wires, &shuffled, copy, brute));
    let bounded = [bounded(moved(snake(0.0, 1.5)))];
    let brute = reference(&bounded, &grid);
    let name = "1 wire with locators, domain and twist, 1 thread, ";
    one.install(|| measure(&format!("{name}rows"), &bounded, &grid, copy, brute));
    one.install(|| compare(&wires, &bounded, &grid));
    one.install(|| measure(&format!("{name}shuffled"), &bounded, &shuffled, copy, brute));
    one.install(|| compare(&wires, &bounded, &shuffled));
    let small = [moved(snake(0.0, 0.1))];
    let brute = reference(&small, &grid);
    one.install(|| measure("1 wire of small radius, 1 thread, rows", &small, &grid, copy, brute));
    let many: Vec<Wire> = (0..16).map(|i| moved(snake(0.06 * i as f32 - 0.5, 0.25))).collect();
    let brute = reference(&many, &grid);
    one.install(|| measure("16 wires, 1 thread, rows", &many, &grid, copy, brute));
    two.install(|| measure("16 wires, 2 threads, rows", &many, &grid, copy, brute));
}

fn grid() -> Vec<[f32; 3]> {
    let at = |i: usize| 2.0 * i as f32 / (SIDE - 1) as f32 - 1.0;
    (0..SIDE * SIDE).map(|i| [at(i % SIDE), 0.1 * (9.0 * at(i / SIDE)).sin(), at(i / SIDE)]).collect()
}

/// The same points in an order without neighbours.
fn shuffled(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut state = 1_u64;
    let mut points = points.to_vec();
    for i in (1..points.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        points.swap(i, (state >> 33) as usize % (i + 1));
    }
    points
}

/// A cubic of sixteen points that winds over the grid.
fn snake(offset: f32, radius: f32) -> Wire {
    let point = |i: u8| {
        let x = f32::from(i) / 7.5 - 1.0;
        [x, 0.0, 0.3 * (3.0 * x).sin() + offset]
    };
    Wire { radius, ..Wire::new(Curve::bspline(3, (0..16).map(point).collect()).expect("finite points")) }
}

/// The wire lifted and bent, with a scale: every step of the deformation has something to do.
fn moved(mut wire: Wire) -> Wire {
    for (i, p) in wire.pose.iter_mut().enumerate() {
        p[1] += 0.3 * (i as f32).sin();
        p[2] += 0.1;
    }
    Wire { scale: 1.2, ..wire }
}

/// The wire with three locators, a twist, and a domain curve beside it that bounds one side.
fn bounded(mut wire: Wire) -> Wire {
    let beside = wire.reference.points().iter().map(|p| [p[0], p[1] + 0.1, p[2] + 0.7]).collect();
    let domain = Curve::bspline(3, beside).expect("finite points");
    wire.domains = vec![Domain { delta: 0.3, ..Domain::new(domain) }];
    let locator = |u, radius, scale, twist| Locator {
        u,
        radius: Some(radius),
        scale: Some(scale),
        twist: Some(twist),
        ..Locator::default()
    };
    wire.locators =
        vec![locator(0.1, 1.5, 1.2, 0.0), locator(0.4, 1.3, 0.9, 0.8), locator(0.8, 1.5, 1.1, -0.4)];
    wire
}

/// Seconds a point of the float64 reference, its curves prepared beforehand: for the feet alone, and for the whole.
fn reference(wires: &[Wire], points: &[[f32; 3]]) -> (f64, f64) {
    let sample: Vec<[f32; 3]> = points.iter().step_by(points.len() / SAMPLE).copied().collect();
    let scene = Scene::new(wires, &Blend::default());
    let seconds = |work: &dyn Fn([f32; 3])| {
        let start = Instant::now();
        for p in &sample {
            work(*p);
        }
        start.elapsed().as_secs_f64() / sample.len() as f64
    };
    let feet = seconds(&|p| {
        black_box(scene.feet(p));
    });
    let whole = seconds(&|p| {
        black_box(scene.deform(p));
    });
    (feet, whole)
}

fn measure(name: &str, wires: &[Wire], points: &[[f32; 3]], copy: f64, (brute_bind, brute): (f64, f64)) {
    let count = points.len() as f64;
    let bind = median(|| {
        let start = Instant::now();
        black_box(Binding::new(wires, points).expect("wires in range"));
        start.elapsed().as_secs_f64()
    });
    let mut binding = Binding::new(wires, points).expect("wires in range");
    let mut out = vec![[0.0; 3]; points.len()];
    let deform = median(|| {
        let start = Instant::now();
        binding.deform_into(wires, &Blend::default(), black_box(&mut out)).expect("the bound wires");
        start.elapsed().as_secs_f64()
    });
    let pairs = binding.pair_count() as f64;
    println!("{name}: {:.2} pairs a point", pairs / count);
    println!(
        "  bind   {:8.2} ms  {:6.1} copies  {:6.1} ns a point   reference / bind   {:6.0}",
        bind * 1e3,
        bind / copy,
        bind / count * 1e9,
        brute_bind * count / bind
    );
    println!(
        "  deform {:8.2} ms  {:6.1} copies  {:6.2} ns a pair    reference / both   {:6.0}",
        deform * 1e3,
        deform / copy,
        deform / pairs * 1e9,
        brute * count / (bind + deform)
    );
}

/// Prints the time of wires in parts of that of plain ones, in rounds by turns: the machine is the same for both.
fn compare(plain: &[Wire], wires: &[Wire], points: &[[f32; 3]]) {
    let mut out = vec![[0.0; 3]; points.len()];
    let mut times: [Vec<f64>; 4] = Default::default();
    for _ in 0..ROUNDS {
        for (i, wires) in [plain, wires].into_iter().enumerate() {
            let start = Instant::now();
            let mut binding = Binding::new(wires, points).expect("wires in range");
            times[i].push(start.elapsed().as_secs_f64());
            let mut deform =
                || binding.deform_into(wires, &Blend::default(), &mut out).expect("the bound wires");
            deform();
            let start = Instant::now();
            deform();
            times[2 + i].push(start.elapsed().as_secs_f64());
        }
    }
    let [a, b, c, d] = times.map(|mut times| {
        let mut next = times.drain(..);
        median(|| next.next().unwrap_or_default())
    });
    println!("  beside the plain wire: bind {:.2}, deform {:.2}", b / a, d / c);
}

fn median(mut round: impl FnMut() -> f64) -> f64 {
    let mut times: Vec<f64> = (0..ROUNDS).map(|_| round()).collect();
    times.sort_unstable_by(f64::total_cmp);
    times[ROUNDS / 2]
}
