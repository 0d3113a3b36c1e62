//! Textures: which image, at which coordinates.

use crate::attributes;
use crate::document::Gltf;
use crate::error::AssetError;
use crate::json::Json;
use crate::limits::Budget;
use crate::look::extension;
use crate::rest::Rest;

/// Extensions that put an image of another format in the place of a texture's own.
const SOURCES: [&str; 4] = ["EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"];

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TextureUse {
    /// The image, for [`Gltf::image`]. Where an extension offers another format beside the plain one, the plain one.
    pub image: usize,
    /// Which set of texture coordinates it uses.
    pub set: usize,
    /// What is done to them. Default nothing.
    pub transform: UvTransform,
    /// What is beyond the image, along u and along v. Default [`Wrap::Repeat`].
    pub wrap: [Wrap; 2],
}

/// What is beyond the edges of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// Its last pixels.
    Clamp,
    /// The image again, mirrored each time.
    Mirror,
}

/// Scales texture coordinates, turns them about the origin and moves them: `KHR_texture_transform`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// What is added last, in parts of the image. Default 0.
    pub offset: [f64; 2],
    /// Radians, counter-clockwise as one sees it: `v` runs downwards. Default 0.
    pub rotation: f64,
    /// Factors, applied first. Default 1.
    pub scale: [f64; 2],
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] }
    }
}

impl UvTransform {
    /// The coordinates at which the image is looked up.
    ///
    /// The formula printed in the extension's text turns the other way; this is the way of its words, of its test
    /// model and of other readers.
    pub fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        if *self == Self::default() {
            return uv;
        }
        let (sin, cos) = self.rotation.sin_cos();
        let (u, v) = (f64::from(uv[0]) * self.scale[0], f64::from(uv[1]) * self.scale[1]);
        let out = [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]];
        out.map(|c| c as f32)
    }
}

impl Gltf {
    /// Where the vertices of a part of `rest`, the rest of this document, are in a texture of its look: one pair a
    /// vertex of the part's block, the texture's transform applied; `v` runs downwards, from 0 to 1 in the image.
    ///
    /// # Errors
    ///
    /// A part that is not there or has no such coordinates, or coordinates that are no pairs of finite numbers; the
    /// limits.
    pub fn texture_coordinates(
        &self,
        rest: &Rest,
        part: usize,
        texture: &TextureUse,
    ) -> Result<Vec<[f32; 2]>, AssetError> {
        self.read_coordinates(rest, part, texture).map_err(|error| error.in_file(&self.file))
    }

    fn read_coordinates(
        &self,
        rest: &Rest,
        part: usize,
        texture: &TextureUse,
    ) -> Result<Vec<[f32; 2]>, AssetError> {
        let part =
            rest.parts.get(part).ok_or_else(|| AssetError::file("no such part", "a part of the rest"))?;
        let primitive = self.primitive(part)?;
        let mut budget = Budget::new(&self.limits);
        let uvs = attributes::texture_coordinates(self, primitive, texture.set, &mut budget, &mut Vec::new());
        let mut uvs = uvs?.unwrap_or_default();
        for uv in &mut uvs {
            *uv = texture.transform.apply(*uv);
        }
        let count = rest.blocks.get(part.block).map_or(0, |block| block.count);
        if uvs.len() == count && uvs.as_flattened().iter().all(|c| c.is_finite()) {
            return Ok(uvs);
        }
        let expected = format!("TEXCOORD_{}: pairs of finite numbers, one a vertex", texture.set);
        Err(primitive.need("attributes")?.found("other texture coordinates, or none", expected))
    }

    /// The texture that `material` uses as `key`.
    pub(crate) fn texture(
        &self,
        material: Json<'_>,
        key: &'static str,
    ) -> Result<Option<TextureUse>, AssetError> {
        let Some(info) = material.get(key)? else { return Ok(None) };
        let (_, texture) = self.follow("textures", info.need("index")?)?;
        let mut out = TextureUse {
            image: self.texture_image(texture)?,
            set: info.uint_or("texCoord", 0)?,
            transform: UvTransform::default(),
            wrap: self.wrap(texture)?,
        };
        if let Some(json) = extension(info, "KHR_texture_transform")? {
            let pair = |key, default| json.get(key)?.map_or(Ok(default), Json::floats::<2>);
            out.transform.offset = pair("offset", [0.0; 2])?;
            out.transform.scale = pair("scale", [1.0; 2])?;
            out.transform.rotation = json.get("rotation")?.map_or(Ok(0.0), Json::float)?;
            out.set = json.uint_or("texCoord", out.set)?;
        }
        Ok(Some(out))
    }

    /// The image of a texture: its own, else the first that an extension gives.
    fn texture_image(&self, texture: Json<'_>) -> Result<usize, AssetError> {
        if let Some(source) = texture.get("source")? {
            return Ok(self.follow("images", source)?.0);
        }
        for name in SOURCES {
            if let Some(json) = extension(texture, name)?
                && let Some(source) = json.get("source")?
            {
                return Ok(self.follow("images", source)?.0);
            }
        }
        Err(texture.found("no \"source\"", "an image"))
    }

    fn wrap(&self, texture: Json<'_>) -> Result<[Wrap; 2], AssetError> {
        let Some(sampler) = texture.get("sampler")? else { return Ok([Wrap::Repeat; 2]) };
        let (_, sampler) = self.follow("samplers", sampler)?;
        let one = |key| -> Result<Wrap, AssetError> {
            let Some(mode) = sampler.get(key)? else { return Ok(Wrap::Repeat) };
            match mode.uint()? {
                10497 => Ok(Wrap::Repeat),
                33071 => Ok(Wrap::Clamp),
                33648 => Ok(Wrap::Mirror),
                _ => Err(mode.fault("a wrap mode: 10497, 33071 or 33648")),
            }
        };
        Ok([one("wrapS")?, one("wrapT")?])
    }
}
