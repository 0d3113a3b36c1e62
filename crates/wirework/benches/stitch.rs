//! Eight seams over sixteen patches of 64 × 64 quads: a frame beside a copy of the positions, all in one run.
//!
//! `cargo bench -p wirework --bench stitch` prints medians of several rounds in *copies*: the time one thread takes to copy the positions
//! once into memory that it has used before. Frames are worked out on two threads.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use wirework::asset::Limits;
use wirework::preset::Action;
use wirework::{Subject, parse};

/// Frames, of which the median counts.
const FRAMES: usize = 25;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool of two threads");
    pool.install(|| {
        measure("closing", "closure: Ease([(0, 0), (1, 1)])");
        measure(
            "torn, tangent",
            "bias: Ease([(0, 0.2), (1, 0.8)]), continuity: Tangent, \
             tears: [Tear(at: Ease([(0, 0.2), (1, 0.8)]), width: 0.4, gape: 0.02)]",
        );
    });
}

/// Pairs of patches, each beside the next, with a seam in each.
fn preset(fields: &str) -> String {
    let (mut pieces, mut seams) = (String::new(), String::new());
    for pair in 0..8 {
        let z = f64::from(pair) * 1.2;
        for (name, x) in [("a", 0.0), ("b", 1.2)] {
            let rows: Vec<String> = (0..4)
                .map(|i| {
                    let at = |j: i32| {
                        let rise = 0.1 * f64::from(i * j % 3);
                        format!("({}, {rise}, {})", x + f64::from(i) / 3.0, z + f64::from(j) / 3.0)
                    };
                    format!("[{}]", (0..4).map(at).collect::<Vec<_>>().join(", "))
                })
                .collect();
            let rows = rows.join(", ");
            let _ = write!(
                pieces,
                "Piece(name: \"{name}{pair}\", object: Patch(points: [{rows}], tessellation: (64, 64))), "
            );
        }
        let edges =
            format!("a: Edge(piece: \"a{pair}\", side: UMax), b: Edge(piece: \"b{pair}\", side: UMin)");
        let _ = write!(seams, "Seam({edges}, radius: 0.5, {fields}), ");
    }
    format!("Stitch(patches: [{pieces}], seams: [{seams}])")
}

fn measure(name: &str, fields: &str) {
    let text = preset(fields);
    let preset = parse(text.as_bytes(), &wirework::preset::Limits::default()).expect("a preset").preset;
    let Action::Stitch(stitch) = &preset.effects[0].action else { unreachable!("a stitch") };
    let pieces: Vec<_> = stitch.pieces.iter().map(|piece| (&piece.name, piece.object.as_ref())).collect();
    let subject =
        Subject::from_pieces(None, &pieces, Path::new(""), &Limits::default()).expect("sixteen patches");
    let start = Instant::now();
    let mut effect = subject.bind(&preset, Path::new(""), &Limits::default()).expect("seams");
    let bind = start.elapsed().as_secs_f64();
    let mut points = subject.points.clone();
    let mut times: [Vec<f64>; 2] = Default::default();
    for frame in 0..=FRAMES {
        let start = Instant::now();
        points.copy_from_slice(black_box(&subject.points));
        let copied = Instant::now();
        effect.at(frame as f64 / FRAMES as f64, &mut points).expect("a frame");
        let round = [(copied - start).as_secs_f64(), copied.elapsed().as_secs_f64()];
        black_box(&points);
        // The first frame finds its memory.
        if frame > 0 {
            times.iter_mut().zip(round).for_each(|(all, time)| all.push(time));
        }
    }
    let [copy, deform] = times.map(median);
    println!(
        "{name}: {} points, a copy {:.4} ms; laid and bound in {:.0} copies; a frame {:.0} copies, {:.3} ms",
        points.len(),
        copy * 1e3,
        bind / copy,
        deform / copy,
        deform * 1e3
    );
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
