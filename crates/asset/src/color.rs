//! Vertex colours, read when something asks for them: a file whose colours are broken serves all who do not.

use crate::accessor::{Accessor, Component};
use crate::document::Gltf;
use crate::error::AssetError;
use crate::json::Json;
use crate::limits::{Budget, Of, reserve};
use crate::rest::{Block, Part, Rest};

impl Gltf {
    /// The vertex colours of `rest`, the rest of this document: for each of its blocks the attribute `COLOR_0`, one
    /// colour a vertex as red, green, blue and alpha; none where the block has no colours.
    ///
    /// The numbers are those of the file, brought into the range from 0 to 1 as the standard asks; alpha is 1 where
    /// there is none.
    ///
    /// # Errors
    ///
    /// Colours of another type than the standard's, or numbers that are not finite; the limits.
    pub fn colors(&self, rest: &Rest) -> Result<Vec<Option<Vec<[f32; 4]>>>, AssetError> {
        let mut budget = Budget::new(&self.limits);
        let blocks = rest.blocks.iter().zip(rest.first_parts());
        let one = |(block, part)| self.block_colors(block, part, &mut budget);
        blocks.map(one).collect::<Result<_, _>>().map_err(|error| error.in_file(&self.file))
    }

    fn block_colors(
        &self,
        block: &Block,
        part: Option<&Part>,
        budget: &mut Budget,
    ) -> Result<Option<Vec<[f32; 4]>>, AssetError> {
        let Some(part) = part else { return Ok(None) };
        let Some(reference) = self.primitive(part)?.need("attributes")?.get("COLOR_0")? else {
            return Ok(None);
        };
        let accessor = self.accessor(reference)?;
        if accessor.count != block.count {
            let (found, expected) = (accessor.count, block.count);
            return Err(reference.found(format!("{found} colours"), format!("{expected}, one a vertex")));
        }
        decode(&accessor, budget).map(Some)
    }

    /// The primitive that `part` shows.
    pub(crate) fn primitive(&self, part: &Part) -> Result<Json<'_>, AssetError> {
        let mesh = self.root().need("meshes")?.item(part.mesh)?;
        mesh.need("primitives")?.item(part.primitive)
    }
}

impl Rest {
    /// For each block the first part made of it.
    pub(crate) fn first_parts(&self) -> Vec<Option<&Part>> {
        let mut out = vec![None; self.blocks.len()];
        for part in &self.parts {
            if let Some(slot) = out.get_mut(part.block) {
                slot.get_or_insert(part);
            }
        }
        out
    }
}

fn decode(accessor: &Accessor<'_>, budget: &mut Budget) -> Result<Vec<[f32; 4]>, AssetError> {
    let typed = match accessor.component {
        Component::F32 => !accessor.normalized,
        Component::U8 | Component::U16 => accessor.normalized,
        _ => false,
    };
    let mut colors = match accessor.lanes {
        4 if typed => accessor.floats::<4>(budget)?,
        3 if typed => {
            let bytes = (accessor.count as u64).saturating_mul(size_of::<[f32; 4]>() as u64);
            budget.charge(Of::ExpandedBytes, bytes, || accessor.json.place())?;
            let mut out = reserve(accessor.count)?;
            out.extend(accessor.floats::<3>(budget)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]));
            out
        }
        _ => {
            let expected = "colours: VEC3 or VEC4 of floats or of normalised 8 or 16 bit unsigned integers";
            return Err(accessor.json.found("an accessor of another type", expected));
        }
    };
    for (i, color) in colors.iter_mut().enumerate() {
        if color.iter().any(|c| !c.is_finite()) {
            return Err(accessor.json.found(format!("element {i} is {color:?}"), "finite numbers"));
        }
        *color = color.map(|c| c.clamp(0.0, 1.0));
    }
    Ok(colors)
}
