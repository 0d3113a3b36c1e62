//! A frame allocates nothing. Alone in its file: the counter sees the whole process.

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use wirework_core::Binding;
use wirework_reference::{Random, Rig};

#[global_allocator]
static COUNTER: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[test]
fn a_frame_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for seed in 0..24 {
        let rig = Rig::new(seed);
        let mut random = Random::new(seed);
        let points: Vec<[f32; 3]> = (0..3000)
            .map(|_| {
                let (p, off) = (random.pick(&rig.points), random.vector(0.05 * rig.diagonal()));
                [0, 1, 2].map(|i| (f64::from(p[i]) + off[i]) as f32)
            })
            .collect();
        let mut moved = rig.wires.clone();
        for wire in &mut moved {
            for p in &mut wire.pose {
                p[1] += p[0] * 0.1;
            }
            (wire.scale, wire.twist, wire.amplitude) =
                (wire.scale * 1.1, wire.twist + 0.3, wire.amplitude * 0.9);
            // A radius may shrink without a new binding.
            wire.radius *= 0.9;
            for radius in wire.locators.iter_mut().filter_map(|l| l.radius.as_mut()) {
                *radius *= 0.9;
            }
        }
        let mut out = vec![[0.0; 3]; points.len()];
        let counted = pool.install(|| {
            let mut binding = Binding::new(&rig.wires, &points).unwrap();
            // The first frames may set buffers up.
            for wires in [&rig.wires, &moved] {
                binding.deform_into(wires, &rig.blend, &mut out).unwrap();
            }
            let region = Region::new(COUNTER);
            for wires in [&rig.wires, &moved, &rig.wires] {
                binding.deform_into(wires, &rig.blend, &mut out).unwrap();
            }
            region.change()
        });
        let total = counted.allocations + counted.reallocations;
        assert_eq!(total, 0, "seed {seed}: {counted:?}, {:?}", rig.wires);
    }
}
