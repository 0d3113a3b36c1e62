//! The vertices of a node as one list of vectors: what is compared and summed of its samples.
//!
//! Displacements are scaled by what the way to the world makes of them at most, so that lengths are metres in the world.
//!
//! Normals and tangents have the length of the area round them ([`crate::areas`]).

use wirework_asset::{LocalDeltas, Rest};

use crate::vectors::Vector;
use crate::writer::{Node, Sample};

/// How the blocks of a node stand in its lists.
#[derive(Debug)]
pub(crate) struct Field {
    blocks: Vec<Part>,
    /// How many positions there are.
    pub(crate) count: usize,
    /// How many normals and tangents.
    pub(crate) turns: usize,
}

#[derive(Debug)]
struct Part {
    block: usize,
    count: usize,
    /// By what displacements grow on the way to the world.
    stretch: Vec<f32>,
    /// The first of its vertices.
    first: usize,
    /// Normals at rest, and tangents where these are wanted; empty where there are none.
    directions: [Vec<Vector>; 2],
}

impl Field {
    /// `mapped` are the blocks that get tangents.
    pub(crate) fn new(rest: &Rest, node: &Node, mapped: impl Fn(usize) -> bool) -> Self {
        let part = |&block: &usize| {
            let own = rest.blocks.get(block)?;
            let list = |list: Option<&[Vector]>| list.map(<[_]>::to_vec).unwrap_or_default();
            let tangents = own.local_tangents().filter(|_| mapped(block));
            Some(Part {
                block,
                count: own.count,
                first: own.first,
                stretch: rest.stretches(block),
                directions: [list(own.local_normals()), list(tangents)],
            })
        };
        let blocks: Vec<Part> = node.blocks.iter().filter_map(part).collect();
        let count = blocks.iter().map(|part| part.count).sum();
        let turns = blocks.iter().flat_map(|part| &part.directions).map(Vec::len).sum();
        Self { blocks, count, turns }
    }

    /// The displacements of a sample, metres.
    pub(crate) fn places(&self, sample: &Sample) -> Vec<Vector> {
        let mut out = Vec::with_capacity(self.count);
        for part in &self.blocks {
            let start = out.len();
            if let Some(deltas) = sample.blocks.get(part.block) {
                out.extend(deltas.positions.iter().zip(&part.stretch).map(|(d, s)| d.map(|c| c * s)));
            }
            out.resize(start + part.count, [0.0; 3]);
        }
        out
    }

    /// What a sample adds to normals and tangents.
    pub(crate) fn directions(&self, sample: &Sample) -> Vec<Vector> {
        let mut out = Vec::with_capacity(self.turns);
        for part in &self.blocks {
            let deltas = sample.blocks.get(part.block);
            let given =
                deltas.map_or([None, None], |deltas| [&deltas.normals, &deltas.tangents].map(Option::as_ref));
            for (base, given) in part.directions.iter().zip(given) {
                let end = out.len() + base.len();
                out.extend(given.into_iter().flatten().take(base.len()));
                out.resize(end, [0.0; 3]);
            }
        }
        out
    }

    /// Gives normals and tangents of a sample the length of `growth`, by which areas grow round all vertices.
    pub(crate) fn lengthen(&self, sample: &mut Sample, growth: &[f32]) {
        for part in &self.blocks {
            let Some(deltas) = sample.blocks.get_mut(part.block) else { continue };
            let growth = growth.get(part.first..).unwrap_or_default();
            for (base, own) in part.directions.iter().zip([&mut deltas.normals, &mut deltas.tangents]) {
                for ((delta, base), growth) in own.iter_mut().flatten().zip(base).zip(growth) {
                    *delta = lengthened(*base, *delta, *growth);
                }
            }
        }
    }

    /// Lists of the node as displacements of its blocks, each with the block's number.
    pub(crate) fn apart(&self, places: &[Vector], directions: &[Vector]) -> Vec<(usize, LocalDeltas)> {
        let (mut places, mut directions) = (places, directions);
        let mut out = Vec::with_capacity(self.blocks.len());
        for part in &self.blocks {
            let own = cut(&mut places, part.count);
            let unscaled = |(d, s): (&Vector, &f32)| if *s > 0.0 { d.map(|c| c / s) } else { [0.0; 3] };
            let positions = own.iter().zip(&part.stretch).map(unscaled).collect();
            let [normals, tangents] = [0, 1].map(|k| {
                let base = &part.directions[k];
                (!base.is_empty()).then(|| cut(&mut directions, base.len()).to_vec())
            });
            out.push((part.block, LocalDeltas { positions, normals, tangents, stuck: 0 }));
        }
        out
    }
}

fn cut<'a>(list: &mut &'a [Vector], count: usize) -> &'a [Vector] {
    let (head, tail) = list.split_at(count.min(list.len()));
    *list = tail;
    head
}

/// What is to be added to a unit direction so that it points along `base + delta`, with a length.
fn lengthened(base: Vector, delta: Vector, length: f32) -> Vector {
    std::array::from_fn(|k| (base[k] + delta[k]) * length - base[k])
}
