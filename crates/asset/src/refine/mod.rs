//! Finer copies of meshes: what a coarse one needs before small folds can be seen on it.
//!
//! The document's own meshes, accessors and views stay as they are. A mesh of which a node needs a finer version is copied,
//! and the node points to the copy; nodes that need the same share one, others keep the original. In the copy, a primitive that
//! is refined has attributes, targets and indices of its own; whatever else it has, and all other primitives, are as in the
//! original.

mod between;
mod skin;

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use wirework_surface::Subdivision;

use crate::document::Gltf;
use crate::edit::drop_compressed;
use crate::error::AssetError;
use crate::limits::Budget;
use crate::rest::{Block, Part, Rest};

/// Extensions of primitives and meshes that list edges, or triangles by their order: of a refined primitive they would tell
/// wrong things. All others, materials above all, hold as before.
const OUTDATED: [&str; 3] =
    ["CESIUM_primitive_outline", "EXT_mesh_manifold", "EXT_mesh_primitive_edge_visibility"];

/// What became of a document.
#[derive(Clone, Debug)]
pub struct Refined {
    /// Its rest as it is now; with the warnings of the rest before, for nothing else is wrong with it.
    pub rest: Rest,
    /// For each vertex of that rest which one of the subdivision it is.
    pub vertex_of: Vec<u32>,
    /// The copies, in the order of the meshes.
    pub meshes: Vec<RefinedMesh>,
}

/// A mesh that was copied and refined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefinedMesh {
    /// The mesh as it was, and still is.
    pub mesh: usize,
    /// Its finer copy.
    pub copy: usize,
    /// The nodes that show the copy.
    pub nodes: Vec<usize>,
    /// Vertices of the mesh as one node shows it.
    pub before: usize,
    /// Vertices of the copy.
    pub after: usize,
}

/// The vertices that a block gets.
#[derive(Clone, Debug, Default, PartialEq)]
struct Added {
    /// How many it has.
    old: usize,
    /// For each of them its parents, numbered from the block's first vertex on.
    parents: Vec<[u32; 2]>,
    /// For each of those how far it lies from its first parent towards the second.
    shares: Vec<f64>,
    /// For a skin what to add to what lies between their parents' positions; empty where that is nothing.
    shifts: Vec<[f32; 3]>,
    /// Their numbers in the subdivision.
    numbers: Vec<u32>,
}

/// A primitive that is refined.
#[derive(Clone, Debug)]
struct Piece {
    primitive: usize,
    block: usize,
    /// Numbered from the block's first vertex on, turned as in the mesh.
    triangles: Vec<[u32; 3]>,
}

impl Gltf {
    /// Gives nodes finer copies of their meshes. `finer` is a subdivision of the vertices and triangles of `rest`, the rest of
    /// this document.
    ///
    /// Attributes of new vertices are between those of their parents, as near to each as they are: as floats, which hold all that is there as it is
    /// read and what lies between well enough, but joints, which stay integers, and attributes of applications (`_NAME`),
    /// which keep their component type and are rounded. Normals and tangents are of length 1; weights are those of both
    /// parents in their shares, the largest of them in as many sets as there were, and add up to 1; where those of old vertices do not, or
    /// their normals are of another length, that is put right in the copy. Displacements of morph targets are between too. A
    /// skin's new vertices lie, at rest, on the line between their parents.
    ///
    /// # Errors
    ///
    /// Attributes that are malformed; the limits. The document is of no use then: part of it may have been appended.
    pub fn refine(&mut self, rest: &Rest, finer: &Subdivision) -> Result<Refined, AssetError> {
        let file = self.file.clone();
        self.append_finer(rest, finer).map_err(|error| error.in_file(&file))
    }

    fn append_finer(&mut self, rest: &Rest, finer: &Subdivision) -> Result<Refined, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let mut added = added(rest, finer)?;
        let mut meshes: BTreeMap<usize, Vec<(usize, Vec<Piece>)>> = BTreeMap::new();
        for (part, piece) in pieces(rest, finer, &added)? {
            let nodes = meshes.entry(part.mesh).or_default();
            match nodes.last_mut() {
                Some((node, list)) if *node == part.node => list.push(piece),
                _ => nodes.push((part.node, vec![piece])),
            }
        }
        let parts = rest.first_parts();
        for (block, (added, part)) in added.iter_mut().zip(&parts).enumerate() {
            if let (Some(part), false) = (part, added.parents.is_empty()) {
                added.shifts = self.shifts(rest, block, part, added, &mut budget)?;
            }
        }
        let mut list = Vec::new();
        for (mesh, nodes) in meshes {
            for (pieces, nodes) in alike(nodes, &added) {
                let copy = self.copy_mesh(mesh, &nodes)?;
                self.refine_mesh(copy, &pieces, &added, &mut budget)?;
                let (before, after) = count(rest, &added, &nodes);
                list.push(RefinedMesh { mesh, copy, nodes, before, after });
            }
        }
        let mut now = self.rest()?;
        now.warnings.clone_from(&rest.warnings);
        let vertex_of = origins(rest, &now, &added)?;
        Ok(Refined { rest: now, vertex_of, meshes: list })
    }

    /// Refines primitives of a copy.
    fn refine_mesh(
        &mut self,
        copy: usize,
        pieces: &[Piece],
        added: &[Added],
        budget: &mut Budget,
    ) -> Result<(), AssetError> {
        let mut known: Vec<(usize, Map<String, Value>, Option<Value>)> = Vec::new();
        for piece in pieces {
            let of_block = &added[piece.block];
            if !known.iter().any(|(block, ..)| *block == piece.block) {
                let (attributes, targets) = self.append_grown(copy, piece.primitive, of_block, budget)?;
                known.push((piece.block, attributes, targets));
            }
            let indices =
                self.append_indices(piece.triangles.as_flattened(), of_block.old + of_block.parents.len())?;
            let place = self.primitives_mut(copy)?.get_mut(piece.primitive).and_then(Value::as_object_mut);
            let Some(primitive) = place else { continue };
            if let Some((_, attributes, targets)) = known.iter().find(|(block, ..)| *block == piece.block) {
                primitive.insert("attributes".to_owned(), Value::Object(attributes.clone()));
                if let Some(targets) = targets {
                    primitive.insert("targets".to_owned(), targets.clone());
                }
            }
            primitive.insert("indices".to_owned(), json!(indices));
            // What was a strip or a fan is a list.
            primitive.shift_remove("mode");
            drop_compressed(primitive);
            drop_outdated(primitive);
        }
        drop_outdated(self.entry_mut("meshes", copy)?);
        Ok(())
    }
}

fn other_rest() -> AssetError {
    AssetError::file("a subdivision of something else", "one of this document's vertices and triangles")
}

/// The new vertices of each block.
fn added(rest: &Rest, finer: &Subdivision) -> Result<Vec<Added>, AssetError> {
    if !finer.shares.is_empty() && finer.shares.len() != finer.parents.len() {
        return Err(other_rest());
    }
    let old = rest.positions.len() as u32;
    let empty = |block: &Block| Added { old: block.count, ..Added::default() };
    let mut out: Vec<Added> = rest.blocks.iter().map(empty).collect();
    // For each new vertex its block and its number there.
    let mut known: Vec<(usize, u32)> = Vec::with_capacity(finer.parents.len());
    for (k, (parents, share)) in finer.parents.iter().zip(finer.vertex_shares()).enumerate() {
        let place = |v: u32| {
            if let Some(new) = v.checked_sub(old) {
                return known.get(new as usize).copied();
            }
            let block = rest.blocks.partition_point(|block| block.first <= v as usize).checked_sub(1)?;
            Some((block, v - rest.blocks[block].first as u32))
        };
        let [Some(a), Some(b)] = parents.map(place) else { return Err(other_rest()) };
        let block = &mut out[a.0];
        if a.0 != b.0 || !(0.0..=1.0).contains(&share) {
            return Err(other_rest());
        }
        known.push((a.0, (block.old + block.parents.len()) as u32));
        block.parents.push([a.1, b.1]);
        block.shares.push(share);
        block.numbers.push(old + k as u32);
    }
    Ok(out)
}

/// The primitives of which triangles were cut, with their parts.
fn pieces<'a>(
    rest: &'a Rest,
    finer: &Subdivision,
    added: &[Added],
) -> Result<Vec<(&'a Part, Piece)>, AssetError> {
    let old = rest.positions.len() as u32;
    let mut local = vec![0; finer.parents.len()];
    for added in added {
        for (k, &number) in added.numbers.iter().enumerate() {
            local[(number - old) as usize] = (added.old + k) as u32;
        }
    }
    let mut out = Vec::new();
    for part in &rest.parts {
        let at = |triangle: usize| finer.sources.partition_point(|&source| (source as usize) < triangle);
        let range = at(part.first_triangle)..at(part.first_triangle + part.triangle_count);
        if range.len() == part.triangle_count {
            continue;
        }
        let block = rest.blocks.get(part.block).ok_or_else(other_rest)?;
        let own = |v: u32| match v.checked_sub(old) {
            Some(new) => local.get(new as usize).copied(),
            None => v.checked_sub(block.first as u32),
        };
        let mut triangles = Vec::with_capacity(range.len());
        for triangle in finer.triangles.get(range).ok_or_else(other_rest)? {
            let [Some(a), Some(b), Some(c)] = triangle.map(own) else { return Err(other_rest()) };
            triangles.push(if block.mirrored() { [a, c, b] } else { [a, b, c] });
        }
        out.push((part, Piece { primitive: part.primitive, block: part.block, triangles }));
    }
    Ok(out)
}

/// Nodes of one mesh that need the same, together.
fn alike(nodes: Vec<(usize, Vec<Piece>)>, added: &[Added]) -> Vec<(Vec<Piece>, Vec<usize>)> {
    let same = |a: &Piece, b: &Piece| {
        let (of_a, of_b) = (&added[a.block], &added[b.block]);
        a.primitive == b.primitive
            && a.triangles == b.triangles
            && of_a.parents == of_b.parents
            && of_a.shares == of_b.shares
            && of_a.shifts == of_b.shifts
    };
    let mut out: Vec<(Vec<Piece>, Vec<usize>)> = Vec::new();
    for (node, pieces) in nodes {
        let known = out.iter_mut().find(|(known, _)| {
            known.len() == pieces.len() && known.iter().zip(&pieces).all(|(a, b)| same(a, b))
        });
        match known {
            Some((_, list)) => list.push(node),
            None => out.push((pieces, vec![node])),
        }
    }
    out
}

/// How many vertices the first of some nodes shows, before and after.
fn count(rest: &Rest, added: &[Added], nodes: &[usize]) -> (usize, usize) {
    let shown = rest.blocks.iter().zip(added).filter(|(block, _)| nodes.first() == Some(&block.node));
    shown.fold((0, 0), |(before, after), (_, added)| {
        (before + added.old, after + added.old + added.parents.len())
    })
}

/// For each vertex of the new rest its number in the subdivision of the old one.
fn origins(old: &Rest, new: &Rest, added: &[Added]) -> Result<Vec<u32>, AssetError> {
    let mut out = Vec::with_capacity(new.positions.len());
    let first_parts = new.first_parts();
    for (block, part) in new.blocks.iter().zip(first_parts) {
        // Nodes and primitives are where they were, so the parts are the same.
        let index = part.and_then(|part| new.parts.iter().position(|other| std::ptr::eq(part, other)));
        let from = index.and_then(|index| old.parts.get(index)).ok_or_else(other_rest)?.block;
        let (from, added) = (&old.blocks[from], &added[from]);
        out.extend(from.first as u32..(from.first + from.count) as u32);
        if block.count == from.count + added.numbers.len() {
            out.extend(&added.numbers);
        } else if block.count != from.count {
            return Err(other_rest());
        }
    }
    Ok(out)
}

fn drop_outdated(entry: &mut Map<String, Value>) {
    let Some(extensions) = entry.get_mut("extensions").and_then(Value::as_object_mut) else { return };
    for name in OUTDATED {
        extensions.shift_remove(name);
    }
    if extensions.is_empty() {
        entry.shift_remove("extensions");
    }
}
