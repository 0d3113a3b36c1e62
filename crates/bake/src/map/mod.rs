//! A deformation as pictures in the texture coordinates of the surface that it deforms: a normal map, heights, and for parts of
//! the effect how much of it is theirs.
//!
//! The maps are for the *undeformed* surface: a viewer that lights it with the normal map sees the deformed one. Folds finer than
//! its triangles are the point of it, so there are two meshes: the *rest*, with normals and tangents as a viewer has them, and
//! a *fine* one that lies on it, has been deformed, and knows for each triangle the one of the rest that it is a part of.
//!
//! # A sample
//!
//! The fine triangle that covers it says how far the surface has moved there, `d`, and how its normal has turned, `t`, each
//! between its corners. The triangle of the rest says what a viewer interpolates at these texture coordinates: `N`, `T` and
//! `B = w·(N×T)`, each between the corners and brought to length 1. The height is `d·N`; the deformed normal `N + t`, of
//! length 1, is written as the `c` for which `T·c.x + B·c.y + N·c.z` points there, by the inverse of the matrix, for `T` and `B`
//! are not perpendicular to `N` between corners. So facets of the rest are in no map: what turns is measured against what a viewer shades, and where nothing has turned
//! `c` is (0, 0, 1) whatever the frame.
//!
//! A texel is the mean of its samples, a normal's brought to length 1. Texels beyond the islands take the mean of their neighbours, ring
//! after ring, as many as there is padding.
//!
//! # Conventions
//!
//! `v` runs downwards, as in glTF, so row 0 of a map is `v` = 0. Green is up, along `B`, as glTF and OpenGL have it.
//! What lies beyond 0..1 comes in again on the other side, as a repeating texture shows it.

mod encode;
mod frame;
mod padding;
mod raster;
mod texel;
mod turn;

use thiserror::Error;

pub use encode::{CHANNELS, Depth, Texts, gray, normals, shares};
pub use frame::{tangents, weights};
pub use turn::turned;

/// The most texels along a side.
pub const MAX_SIDE: u32 = 8192;
/// The most samples along a side of a texel.
pub const MAX_SAMPLES: u32 = 8;
/// The most rings of padding: farther than any mipmap that shows an island.
pub const MAX_PADDING: u32 = 256;

/// A corner of a triangle of the rest, as a viewer has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corner {
    /// Texture coordinates; `v` runs downwards.
    pub uv: [f32; 2],
    /// Unit normal.
    pub normal: [f32; 3],
    /// Unit tangent, and the sign of the bitangent.
    pub tangent: [f32; 4],
}

/// A fine triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Its vertices.
    pub vertices: [u32; 3],
    /// The triangle of the rest that it is a part of.
    pub face: u32,
}

/// A surface and what has become of it. Lists that belong to vertices are equally long.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// The triangles of the rest.
    pub faces: Vec<[Corner; 3]>,
    /// The fine triangles: of two in one place the first is seen.
    pub triangles: Vec<Triangle>,
    /// Texture coordinates of the fine vertices.
    pub uvs: Vec<[f32; 2]>,
    /// How far each has moved, metres.
    pub moved: Vec<[f32; 3]>,
    /// Its unit normal now less the one at rest, as [`turned()`] has it; exactly 0 where that has not turned.
    pub turned: Vec<[f32; 3]>,
    /// For each part of the effect how much of what moves a vertex is its, from 0 to 1.
    pub shares: Vec<Vec<f32>>,
}

/// How maps are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Texels across and down, 1 to [`MAX_SIDE`]. Default 1024 each.
    pub size: [u32; 2],
    /// Samples along each side of a texel, 1 to [`MAX_SAMPLES`]. Default 2: four a texel.
    pub samples: u32,
    /// Rings of texels beyond the islands, 0 to [`MAX_PADDING`]. Default 8.
    pub padding: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { size: [1024; 2], samples: 2, padding: 8 }
    }
}

/// What was found in the texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// Samples of the whole map.
    pub samples: u64,
    /// Those that a triangle covers.
    pub covered: u64,
    /// Those that triangles of more than one face cover.
    pub overlapping: u64,
    /// Those whose surface has turned by 90 degrees or more, which no map can say.
    pub folded: u64,
    /// Triangles that reach beyond 0..1.
    pub wrapped: usize,
    /// Triangles of the rest whose texture coordinates span no area, or no frame: they are in no map.
    pub degenerate: usize,
    /// Triangles that reach over more than [`Facts::TILES`] tiles, or too far away, and are in no map.
    pub tiled: usize,
}

impl Facts {
    /// The most tiles along a side that a triangle may reach over.
    pub const TILES: u32 = 16;
}

/// Maps as numbers, row after row from `v` = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// Texels across and down.
    pub size: [u32; 2],
    /// Unit normals in the tangent space of the rest; (0, 0, 1) where nothing is.
    pub normals: Vec<[f32; 3]>,
    /// Heights along the normal of the rest, metres; 0 where nothing is.
    pub heights: Vec<f32>,
    /// The shares of each texel, one after the other.
    pub shares: Vec<f32>,
    /// What was found.
    pub facts: Facts,
}

impl Maps {
    /// The largest distance of a height from 0, metres.
    pub fn reach(&self) -> f32 {
        self.heights.iter().fold(0.0, |most, height| height.abs().max(most))
    }

    /// Bytes that maps of this size and so many shares take while they are made, without files.
    pub fn bytes([width, height]: [u32; 2], shares: usize) -> u64 {
        // Normal, height, whether it is covered, and the same once more for a ring of padding.
        u64::from(width) * u64::from(height) * (2 * (12 + 4 + 1) + 8 * shares as u64)
    }
}

/// Why there are no maps.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MapError {
    /// A setting is out of range.
    #[error("{what} {found}: {least} to {most} are possible")]
    Range {
        /// `"a map's side of"`, `"samples"` or `"padding"`.
        what: &'static str,
        /// What was asked for.
        found: u32,
        /// The least there may be.
        least: u32,
        /// The most there may be.
        most: u32,
    },
    /// Lists or indices of a surface do not fit each other.
    #[error("{what} do not fit the {count} vertices or faces of the surface")]
    Surface {
        /// Which of them.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// The format's own writer refused, which it should not.
    #[error("the map cannot be written: {0}")]
    Format(String),
}

impl Settings {
    /// Refuses what is out of range.
    ///
    /// # Errors
    ///
    /// [`MapError::Range`].
    pub fn check(&self) -> Result<(), MapError> {
        let [width, height] = self.size;
        for (what, found, least, most) in [
            ("a map's side of", width, 1, MAX_SIDE),
            ("a map's side of", height, 1, MAX_SIDE),
            ("samples", self.samples, 1, MAX_SAMPLES),
            ("padding", self.padding, 0, MAX_PADDING),
        ] {
            if !(least..=most).contains(&found) {
                return Err(MapError::Range { what, found, least, most });
            }
        }
        Ok(())
    }
}

impl Surface {
    fn check(&self) -> Result<(), MapError> {
        let count = self.uvs.len();
        let fits =
            |fits: bool, what, count| if fits { Ok(()) } else { Err(MapError::Surface { what, count }) };
        fits(self.moved.len() == count, "displacements", count)?;
        fits(self.turned.len() == count, "normals", count)?;
        fits(self.shares.iter().all(|list| list.len() == count), "shares", count)?;
        let vertices = |t: &Triangle| t.vertices.iter().all(|&v| (v as usize) < count);
        fits(self.triangles.iter().all(vertices), "triangles", count)?;
        let face = |t: &Triangle| (t.face as usize) < self.faces.len();
        fits(self.triangles.iter().all(face), "faces of triangles", self.faces.len())
    }
}

/// Makes the maps of a surface; the same, bit for bit, for any number of threads.
///
/// # Errors
///
/// Settings out of range; a surface whose lists do not fit each other.
pub fn maps(surface: &Surface, settings: &Settings) -> Result<Maps, MapError> {
    settings.check()?;
    surface.check()?;
    let mut maps = texel::maps(surface, settings);
    let covered = std::mem::take(&mut maps.covered);
    let mut maps = maps.maps;
    padding::pad(&mut maps, covered, settings.padding, surface.shares.len());
    Ok(maps)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
