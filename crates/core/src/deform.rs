//! All wires on a tile: \[SF98\] §2 for each, §4 for all.

use crate::blend::{self, Sums};
use crate::bound_wire::BoundWire;
use crate::kernel::{Displacements, displace};
use crate::tiles::Tile;
use crate::{Blend, Wire};

/// Room for the wires of one tile.
pub(crate) type Scratch = (Vec<Displacements>, Option<Box<Sums>>);

/// Deforms one tile; compiled for the vector instructions the processor has.
pub(crate) struct DeformTile<'a> {
    pub(crate) bound: &'a [BoundWire],
    pub(crate) wires: &'a [Wire],
    pub(crate) blend: &'a Blend,
    pub(crate) unit: f32,
    pub(crate) index: usize,
    pub(crate) tile: &'a Tile,
    pub(crate) scratch: &'a mut Scratch,
    pub(crate) out: &'a mut [[f32; 3]],
}

impl pulp::WithSimd for DeformTile<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let (displacements, sums) = self.scratch;
        let mut used = 0;
        for (bound, wire) in self.bound.iter().zip(self.wires) {
            let Some(runs) = bound.runs.of_tile(self.index) else { continue };
            // A wire that has not moved still anchors its surroundings in the local blend.
            if bound.frame.still && self.blend.localize == 0.0 {
                continue;
            }
            if displacements.len() == used {
                displacements.push(Displacements::new());
            }
            let out = &mut displacements[used];
            out.clear();
            out.exponent = wire.exponent.unwrap_or(self.blend.exponent);
            out.amplitude = wire.amplitude;
            used += 1;
            for run in &runs.list {
                let cell = &bound.frame.cells[run.cell as usize];
                let points = runs.points(run);
                if !cell.still {
                    displace(simd, self.tile, &bound.frame, cell, points, out);
                } else if self.blend.localize != 0.0 {
                    points.anchor(out);
                }
            }
        }
        let used = &mut displacements[..used];
        if used.len() > 1 {
            sums.get_or_insert_with(|| Box::new(Sums::new())).combine(simd, used, self.blend, self.unit);
        }
        blend::write(self.tile, used.first(), self.out);
    }
}
