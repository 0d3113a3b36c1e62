use wirework_preset::{Limits, Preset, parse};
use wirework_surface::grid;

use super::*;

const RAISED: &str =
    "curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]), radius: 0.5, pose: [(-1, 1, 0), (1, 1, 0)]";
const RISING: &str = "curve: Polyline(points: [(-1, 1, 0), (1, 1, 0)]), radius: 0.5, \
                      pose: Keys([(0, [(-1, 1, 0), (1, 1, 0)]), (1, [(-1, 2, 0), (1, 2, 0)])])";

fn stack(first: &str, second: &str) -> Preset {
    let text = format!("Stack([Deform(wires: [Wire({first})]), Stack([Deform(wires: [Wire({second})])])])");
    parse(text.as_bytes(), &Limits::default()).unwrap().preset
}

/// The height of the middle at each time, and whether anything was bound after the first.
fn heights(preset: &Preset, times: &[f64]) -> (Vec<f32>, bool) {
    let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
    let mut effect = Evaluation::new(&preset.effects, &mesh.positions, &[]).unwrap();
    let mut out = mesh.positions.clone();
    let mut bound = Vec::new();
    let mut at = |&time: &f64| {
        effect.at(time, &mut out).unwrap();
        bound.push(effect.spent().bind);
        out[12][1]
    };
    let heights = times.iter().map(&mut at).collect();
    (heights, bound.first() != bound.last())
}

#[test]
fn a_stack_binds_again_only_where_the_result_before_has_changed() {
    let (found, again) = heights(&stack(RAISED, RISING), &[0.0, 0.5, 1.0]);
    assert_eq!((found, again), (vec![1.0, 1.5, 2.0], false));
    // Before 1 s the first effect has not come to where the second lies; then it has left the ground.
    let down = "curve: Polyline(points: [(-1, 2, 0), (1, 2, 0)]), radius: 0.5, pose: [(-1, 5, 0), (1, 5, 0)]";
    let rising = RISING.replace("(-1, 1, 0), (1, 1, 0)", "(-1, 0, 0), (1, 0, 0)");
    let (found, again) = heights(&stack(&rising, down), &[0.0, 0.5, 1.0]);
    assert_eq!((found, again), (vec![0.0, 1.0, 5.0], true));
}

#[test]
fn a_crease_stays_on_its_material_when_the_surface_moves() {
    // All of the grid goes sideways, across the crease, and up: a wire with a radius far beyond it, moved as a whole.
    let wrinkle = "Wrinkle(pattern: Drawn([Polyline(points: [(-0.8, 0, 0), (0.8, 0, 0)])]), thickness: 0.2)";
    let carry = "Deform(wires: [Wire(curve: Polyline(points: [(-2, 0, 0), (2, 0, 0)]), radius: 1e6, \
                 pose: Keys([(0, [(-2, 0, 0), (2, 0, 0)]), (1, [(-2, 0.25, 0.5), (2, 0.25, 0.5)])]))])";
    let read = |text: &str| parse(text.as_bytes(), &Limits::default()).unwrap().preset;
    let (alone, stack) = (read(wrinkle), read(&format!("Stack([{carry}, {wrinkle}])")));
    let mesh = grid([2.0, 2.0], [32, 32], [0.0, 1.0, 0.0]).unwrap();
    let triangles = mesh.triangles().unwrap();
    let mut want = mesh.positions.clone();
    Evaluation::new(&alone.effects, &mesh.positions, &triangles).unwrap().at(0.0, &mut want).unwrap();
    assert!(want[16 * 33 + 16][1] > 0.049, "there is a crest in the middle");
    // The still of a moment must not depend on the moments before it.
    for times in [&[0.0, 0.5, 1.0][..], &[1.0], &[0.5, 1.0, 0.0]] {
        let mut effect = Evaluation::new(&stack.effects, &mesh.positions, &triangles).unwrap();
        let mut out = mesh.positions.clone();
        for &t in times {
            effect.at(t, &mut out).unwrap();
            let way = [0.0, 0.25 * t as f32, 0.5 * t as f32];
            for (i, (found, want)) in out.iter().zip(&want).enumerate() {
                let off = (0..3).map(|a| (found[a] - want[a] - way[a]).abs()).fold(0.0, f32::max);
                assert!(off < 2e-5, "vertex {i} at {t} s of {times:?}: {found:?}, {off} off");
            }
        }
    }
}

#[test]
fn effects_that_reach_nothing_are_named_and_buffers_checked() {
    let far = RAISED.replace("0, 0)", "9, 9)").replace("1, 0)", "9, 9)");
    let preset = stack(&far, RAISED);
    let mesh = grid([2.0, 2.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
    let mut effect = Evaluation::new(&preset.effects, &mesh.positions, &[]).unwrap();
    let mut out = mesh.positions.clone();
    effect.at(0.0, &mut out).unwrap();
    assert_eq!(effect.idle().collect::<Vec<_>>(), [0]);
    assert_eq!(effect.wire_count(), 2);
    let idle = [
        "the effect reaches no vertex: nothing moves; the points lie between (-1, 0, -1) and (1, 0, 1) [no-reach]",
    ];
    assert_eq!(effect.idle_warnings(), idle);
    let signed = [[-0.0, -0.0, -1.0], [5.0, -0.0, -0.0]];
    let mut alone = Evaluation::new(&preset.effects[..1], &signed, &[]).unwrap();
    alone.at(0.0, &mut signed.clone()).unwrap();
    let idle = [
        "the effect reaches no vertex: nothing moves; the points lie between (0, 0, -1) and (5, 0, 0) [no-reach]",
    ];
    assert_eq!(alone.idle_warnings(), idle);
    assert_eq!(effect.at(0.0, &mut out[1..]), Err(EvaluateError::PointCount { points: 25, found: 24 }));
}
