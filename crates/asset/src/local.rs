//! The way back from the world to the spaces of the meshes: what to add to their vertices.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::rest::Rest;
use crate::way::{difference, double, single};

/// So many vertices are taken back by one thread at a time.
const BLOCK: usize = 1 << 12;

/// Displacements of a block in the space of its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalDeltas {
    /// What to add to each position of the mesh, exactly 0 where the world position is that of the rest.
    pub positions: Vec<[f32; 3]>,
    /// What to add to each normal; none where the block has no normals.
    pub normals: Option<Vec<[f32; 3]>>,
    /// What to add to each tangent, whose handedness stays; none where the block has no tangents.
    pub tangents: Option<Vec<[f32; 3]>>,
    /// How many vertices should have moved but cannot, because their transform is singular.
    pub stuck: usize,
}

impl Rest {
    /// Takes the deformed state of the vertices of `block` back to the space of its mesh.
    ///
    /// `positions`, `normals` and `tangents` are those of *all* vertices, as long as [`Rest::positions`], in world space. What
    /// equals the rest, bit for bit, gets deltas of exactly 0; elsewhere position + delta, taken through node or
    /// skin, is the deformed position, to its last bit where the mesh is in the world as it is and a displacement in floats
    /// brings it there; and normal + delta, of length 1, points along the deformed normal. So does tangent + delta
    /// along the tangent; one that is 0 stays as it is.
    pub fn to_local<'a>(
        &'a self,
        block: usize,
        positions: &[[f32; 3]],
        normals: Option<&'a [[f32; 3]]>,
        tangents: Option<&'a [[f32; 3]]>,
    ) -> LocalDeltas {
        let mut out = LocalDeltas::default();
        let Some(b) = self.blocks.get(block) else { return out };
        let range = b.first..b.first + b.count;
        let (Some(rest), Some(now)) = (self.positions.get(range.clone()), positions.get(range.clone()))
        else {
            return out;
        };
        let given = |list: Option<&'a [[f32; 3]]>| list.and_then(|list| list.get(range.clone()));
        let normals = Directions::new(b.normals.as_deref(), b.local_normals.as_deref(), given(normals));
        let tangents = Directions::new(b.tangents.as_deref(), b.local_tangents.as_deref(), given(tangents));
        let zeros = || vec![[0.0; 3]; b.count];
        out.positions = zeros();
        out.normals = normals.as_ref().map(|_| zeros());
        out.tangents = tangents.as_ref().map(|_| zeros());
        let slots = blocks(&mut out).into_par_iter().enumerate();
        out.stuck = slots
            .map(|(k, slots)| {
                let range = k * BLOCK..(k * BLOCK + slots.positions.len());
                let mut stuck = 0;
                for (slot, v) in range.enumerate() {
                    let delta = double(now[v]) - double(rest[v]);
                    let moves = delta != DVec3::ZERO;
                    let turned = |list: &Option<Directions<'_>>| list.as_ref().and_then(|d| d.turned(v));
                    let (normal, tangent) = (turned(&normals), turned(&tangents));
                    if !moves && normal.is_none() && tangent.is_none() {
                        continue;
                    }
                    let way = b.frame.way(v);
                    // What cannot go back stays.
                    let Some(inverse) = way.inverse else {
                        stuck += usize::from(moves);
                        continue;
                    };
                    if moves {
                        slots.positions[slot] = clean(if way.identity {
                            std::array::from_fn(|k| difference(rest[v][k], now[v][k]))
                        } else {
                            single(inverse * delta)
                        });
                    }
                    // Normals go back by the transpose, what lies along the surface by the inverse.
                    if let (Some(turned), Some(slot)) = (normal, slots.normals.get_mut(slot)) {
                        *slot = direction_delta(way.transpose, turned);
                    }
                    if let (Some(turned), Some(slot)) = (tangent, slots.tangents.get_mut(slot)) {
                        *slot = direction_delta(inverse, turned);
                    }
                }
                stuck
            })
            .sum();
        out
    }
}

impl LocalDeltas {
    /// Whether anything differs from the rest.
    pub fn moves(&self) -> bool {
        let still = |deltas: &Vec<[f32; 3]>| deltas.iter().all(|d| *d == [0.0; 3]);
        let turned = [&self.normals, &self.tangents].into_iter().flatten();
        !still(&self.positions) || !turned.into_iter().all(still)
    }
}

/// Unit directions of a block: at rest in the world, in the mesh, and now in the world.
struct Directions<'a> {
    rest: &'a [[f32; 3]],
    base: &'a [[f32; 3]],
    now: &'a [[f32; 3]],
}

impl<'a> Directions<'a> {
    fn new(
        rest: Option<&'a [[f32; 3]]>,
        base: Option<&'a [[f32; 3]]>,
        now: Option<&'a [[f32; 3]]>,
    ) -> Option<Self> {
        Some(Self { rest: rest?, base: base?, now: now? })
    }

    /// The direction of a vertex in the mesh, and now in the world; nothing where it is that of the rest.
    fn turned(&self, v: usize) -> Option<[[f32; 3]; 2]> {
        let now = *self.now.get(v)?;
        (*self.rest.get(v)? != now).then_some([*self.base.get(v)?, now])
    }
}

/// A run of vertices of what comes out; empty where there are no normals or tangents.
struct Slots<'a> {
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    tangents: &'a mut [[f32; 3]],
}

fn blocks(out: &mut LocalDeltas) -> Vec<Slots<'_>> {
    let positions = out.positions.chunks_mut(BLOCK);
    let [mut normals, mut tangents] = [&mut out.normals, &mut out.tangents]
        .map(|list| list.as_deref_mut().unwrap_or_default().chunks_mut(BLOCK));
    let slots = |positions| Slots {
        positions,
        normals: normals.next().unwrap_or_default(),
        tangents: tangents.next().unwrap_or_default(),
    };
    positions.map(slots).collect()
}

/// What to add to a direction of a mesh so that it points, in the world, where it is to; `back` takes one back, but for its length.
fn direction_delta(back: DMat3, [base, now]: [[f32; 3]; 2]) -> [f32; 3] {
    let target = (back * double(now)).normalize_or_zero();
    if target == DVec3::ZERO { [0.0; 3] } else { clean(single(target - double(base))) }
}

/// Turns `−0` into `0` and what is not finite into 0, so that equal deltas have equal bits.
fn clean(v: [f32; 3]) -> [f32; 3] {
    v.map(|c| if c.is_finite() { c + 0.0 } else { 0.0 })
}
