//! A deformed state as the document's own geometry, without a clip.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::attributes::vectors;
use crate::document::Gltf;
use crate::edit::drop_compressed;
use crate::error::AssetError;
use crate::json::Json;
use crate::limits::Budget;
use crate::local::LocalDeltas;
use crate::rest::Rest;

/// What a node's primitives become: for each what becomes of its vertices, none where nothing moves.
type Change<'a> = Vec<Option<&'a Moved>>;

/// What becomes of the vertices of a block.
#[derive(PartialEq)]
struct Moved {
    deltas: LocalDeltas,
    /// The places themselves of vertices whose mesh is in the world as it is, so that those that are given equal places
    /// have them, whatever they come from. Empty where there are none.
    exact: Vec<Option<[f32; 3]>>,
}

impl Gltf {
    /// Makes the deformed state of all vertices, in world space, the geometry of the document. Vertex counts and
    /// orders stay; what did not move keeps its accessors. Gives the number of vertices that should have moved but
    /// cannot, because their transform is singular. Where a mesh is in the world as it is, without a transform, a skin or morph targets
    /// that show, positions are the given ones, bit for bit.
    ///
    /// `normals` and `tangents` are as long as `positions`; without them normals and tangents stay as they are. Tangents are
    /// replaced whatever the material: those of the old geometry would be wrong, and right ones cost a viewer nothing. Their
    /// handedness stays.
    pub fn set_still(
        &mut self,
        rest: &Rest,
        positions: &[[f32; 3]],
        normals: Option<&[[f32; 3]]>,
        tangents: Option<&[[f32; 3]]>,
    ) -> Result<usize, AssetError> {
        let file = self.file.clone();
        self.write_still(rest, positions, normals, tangents).map_err(|error| error.in_file(&file))
    }

    fn write_still(
        &mut self,
        rest: &Rest,
        positions: &[[f32; 3]],
        normals: Option<&[[f32; 3]]>,
        tangents: Option<&[[f32; 3]]>,
    ) -> Result<usize, AssetError> {
        let moved = |block| Moved {
            deltas: rest.to_local(block, positions, normals, tangents),
            exact: exact(rest, block, positions),
        };
        let moved: Vec<Moved> = (0..rest.blocks.len()).map(moved).collect();
        let mut meshes: BTreeMap<usize, Vec<(usize, Change<'_>)>> = BTreeMap::new();
        for part in &rest.parts {
            let nodes = meshes.entry(part.mesh).or_default();
            if nodes.last().is_none_or(|(node, _)| *node != part.node) {
                nodes.push((part.node, Change::new()));
            }
            if let Some((_, change)) = nodes.last_mut() {
                change.resize(change.len().max(part.primitive + 1), None);
                change[part.primitive] = moved.get(part.block).filter(|moved| moved.deltas.moves());
            }
        }
        for (mesh, nodes) in meshes {
            self.change_mesh(mesh, nodes)?;
        }
        Ok(moved.iter().map(|moved| moved.deltas.stuck).sum())
    }

    /// Changes a mesh as its nodes need it; nodes that need it otherwise get copies.
    fn change_mesh(&mut self, mesh: usize, nodes: Vec<(usize, Change<'_>)>) -> Result<(), AssetError> {
        let moving = nodes.into_iter().filter(|(_, change)| change.iter().any(Option::is_some)).collect();
        for (mesh, change) in self.meshes_for(mesh, moving)? {
            self.change_primitives(mesh, &change)?;
        }
        Ok(())
    }

    fn change_primitives(&mut self, mesh: usize, change: &Change<'_>) -> Result<(), AssetError> {
        let mut written: Vec<(usize, &Moved, usize)> = Vec::new();
        for (index, moved) in change.iter().enumerate() {
            let Some(moved) = moved else { continue };
            let deltas = &moved.deltas;
            let all = [
                ("POSITION", Some(&deltas.positions)),
                ("NORMAL", deltas.normals.as_ref()),
                ("TANGENT", deltas.tangents.as_ref()),
            ];
            for (key, values) in all {
                let Some(values) = values else { continue };
                let base = self.base(mesh, index, key)?;
                let known = written.iter().find(|(of, known, _)| *of == base && *known == *moved);
                let accessor = if let Some((_, _, accessor)) = known {
                    *accessor
                } else {
                    let accessor = self.append_sum(base, key, values, &moved.exact)?;
                    written.push((base, moved, accessor));
                    accessor
                };
                let primitive = self.primitives_mut(mesh)?.get_mut(index).and_then(Value::as_object_mut);
                let Some(primitive) = primitive else { continue };
                drop_compressed(primitive);
                if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
                    attributes.insert(key.to_owned(), json!(accessor));
                }
            }
        }
        Ok(())
    }

    /// The accessor that a primitive has now.
    fn base(&self, mesh: usize, primitive: usize, key: &'static str) -> Result<usize, AssetError> {
        let json = self.root().need("meshes")?.item(mesh)?.need("primitives")?.item(primitive)?;
        Ok(self.accessor(json.need("attributes")?.need(key)?)?.index)
    }

    /// Appends the values of an accessor with deltas added to the first three numbers of each; those of positions that are known
    /// exactly are these.
    fn append_sum(
        &mut self,
        base: usize,
        key: &str,
        deltas: &[[f32; 3]],
        exact: &[Option<[f32; 3]>],
    ) -> Result<usize, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let index = json!(base);
        let reference = Json::root(&index);
        if key == "TANGENT" {
            let values = self.accessor(reference)?.floats::<4>(&mut budget)?;
            let sum = |(&[x, y, z, w], d): (&[f32; 4], &[f32; 3])| {
                let [x, y, z] = add([x, y, z], *d);
                [x, y, z, w]
            };
            let sums: Vec<[f32; 4]> = values.iter().zip(deltas).map(sum).collect();
            return self.append_vertices(sums, false);
        }
        let values = vectors(self, reference)?.floats::<3>(&mut budget)?;
        let mut sums: Vec<[f32; 3]> = values.iter().zip(deltas).map(|(b, d)| add(*b, *d)).collect();
        let positions = key == "POSITION";
        for (sum, exact) in sums.iter_mut().zip(exact).filter(|_| positions) {
            *sum = exact.unwrap_or(*sum);
        }
        self.append_vertices(sums, positions)
    }
}

/// The places of the vertices of a block that moved, where the mesh stores places in the world.
fn exact(rest: &Rest, block: usize, positions: &[[f32; 3]]) -> Vec<Option<[f32; 3]>> {
    let Some(b) = rest.blocks.get(block) else { return Vec::new() };
    let range = b.first..b.first + b.count;
    let (Some(before), Some(now)) = (rest.positions.get(range.clone()), positions.get(range)) else {
        return Vec::new();
    };
    if b.weights.iter().any(|&weight| weight != 0.0) {
        return Vec::new();
    }
    let stored = |v: usize| (before[v] != now[v] && b.frame.is_identity(v)).then_some(now[v]);
    let stored: Vec<Option<[f32; 3]>> = (0..b.count).into_par_iter().map(stored).collect();
    if stored.iter().any(Option::is_some) { stored } else { Vec::new() }
}

fn add(base: [f32; 3], delta: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| if delta[k] == 0.0 { base[k] } else { base[k] + delta[k] })
}
