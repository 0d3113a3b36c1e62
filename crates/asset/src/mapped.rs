//! What a map of a part is painted in: its texture coordinates, and the handedness of its tangents.

use crate::attributes::texture_coordinates;
use crate::document::Gltf;
use crate::error::AssetError;
use crate::limits::Budget;
use crate::rest::{Part, Rest};

impl Gltf {
    /// The set of texture coordinates that the first normal map of a part's material uses; none without one, or where nothing of it looks at
    /// tangents.
    ///
    /// # Errors
    ///
    /// A part that is not of this document.
    pub fn normal_map_set(&self, part: &Part) -> Result<Option<usize>, AssetError> {
        Ok(self.tangent_set(self.primitive(part)?))
    }

    /// A set of texture coordinates of a part of `rest`, the rest of this document, one pair a vertex of the part's block, `v` downwards;
    /// none where there are none, or no pairs of finite numbers.
    ///
    /// # Errors
    ///
    /// Coordinates that are malformed; the limits.
    pub fn uv_set(&self, rest: &Rest, part: &Part, set: usize) -> Result<Option<Vec<[f32; 2]>>, AssetError> {
        let read = || {
            let mut budget = Budget::new(&self.limits);
            texture_coordinates(self, self.primitive(part)?, set, &mut budget, &mut Vec::new())
        };
        let count = rest.blocks.get(part.block).map_or(0, |block| block.count);
        let uvs = read().map_err(|error| error.in_file(&self.file))?;
        Ok(uvs.filter(|uvs| uvs.len() == count))
    }

    /// The tangents of a part in world space with the signs of their bitangents, one a vertex of the part's block: those of the file, where a
    /// viewer takes them for a map on this `set` of texture coordinates. In the world a mirroring node turns bitangents round, as it does the texture.
    ///
    /// # Errors
    ///
    /// Tangents that are malformed; the limits.
    pub fn map_tangents(
        &self,
        rest: &Rest,
        part: &Part,
        set: usize,
    ) -> Result<Option<Vec<[f32; 4]>>, AssetError> {
        let Some(block) = rest.blocks.get(part.block) else { return Ok(None) };
        let primitive = self.primitive(part)?;
        if self.tangent_set(primitive).unwrap_or(0) != set {
            return Ok(None);
        }
        let Some(tangents) = &block.tangents else { return Ok(None) };
        let Some(reference) = primitive.need("attributes")?.get("TANGENT")? else { return Ok(None) };
        let mut budget = Budget::new(&self.limits);
        let signs = self.accessor(reference).and_then(|accessor| accessor.floats::<4>(&mut budget));
        let signs = signs.map_err(|error| error.in_file(&self.file))?;
        if signs.len() != tangents.len() {
            return Ok(None);
        }
        let mirrored = if block.mirrored() { -1.0 } else { 1.0 };
        let sign = |w: f32| if w < 0.0 { -mirrored } else { mirrored };
        let whole = |(&[x, y, z], &[.., w]): (&[f32; 3], &[f32; 4])| [x, y, z, sign(w)];
        Ok(Some(tangents.iter().zip(&signs).map(whole).collect()))
    }
}
