//! How surfaces look: base colours, their textures, what is see-through. Nothing here is an error, for a broken
//! material still has a shape: what cannot be read is as it would be without, with a warning.

use std::collections::BTreeMap;

use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::json::Json;
use crate::rest::{Part, Rest};
use crate::texture::TextureUse;

/// How a part looks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Look {
    /// The base colour, linear red, green, blue and alpha, each from 0 to 1; it multiplies the texture and the colours of
    /// vertices. None where the document states none, which stands for 1.
    pub color: Option<[f32; 4]>,
    /// The texture of the base colour.
    pub texture: Option<TextureUse>,
    /// What alpha means. Default [`Alpha::Opaque`].
    pub alpha: Alpha,
}

/// What the alpha of a part's colour means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Nothing.
    Opaque,
    /// What is below this is not there, the rest is opaque.
    Mask(f32),
    /// How much of what is behind is covered.
    Blend,
}

impl Default for Look {
    fn default() -> Self {
        Self { color: None, texture: None, alpha: Alpha::Opaque }
    }
}

impl Gltf {
    /// How the parts of `rest`, the rest of this document, look, one entry a part; and what could not be read of it.
    ///
    /// Base colours are those of `pbrMetallicRoughness`, or without it the diffuse ones of
    /// `KHR_materials_pbrSpecularGlossiness`.
    pub fn looks(&self, rest: &Rest) -> (Vec<Look>, Vec<Warning>) {
        let mut warnings = Vec::new();
        let mut known: BTreeMap<usize, Look> = BTreeMap::new();
        let mut out = Vec::new();
        for part in &rest.parts {
            let mut look = match part.material {
                None => Look::default(),
                Some(material) => {
                    known.entry(material).or_insert_with(|| self.material(material, &mut warnings)).clone()
                }
            };
            if let Some(texture) = &look.texture
                && let Err(error) = self.check_coordinates(part, texture)
            {
                warnings.push(Warning::instead(&error, "texcoord", "the texture is left out"));
                look.texture = None;
            }
            out.push(look);
        }
        (out, warnings)
    }

    fn material(&self, index: usize, warnings: &mut Vec<Warning>) -> Look {
        let mut look = Look::default();
        let found = self.root().need("materials").and_then(|table| table.item(index));
        let Some(material) = told(found.map(Some), None, warnings) else { return look };
        if let Some((base, [factor, texture])) = told(base(material), None, warnings) {
            look.color = told(color(base, factor), look.color, warnings);
            look.texture = told(self.texture(base, texture), None, warnings);
        }
        look.alpha = told(alpha(material), look.alpha, warnings);
        look
    }

    /// Whether a part has the coordinates that its texture needs.
    fn check_coordinates(&self, part: &Part, texture: &TextureUse) -> Result<(), AssetError> {
        let attributes = self.primitive(part)?.need("attributes")?;
        let key = format!("TEXCOORD_{}", texture.set);
        if attributes.value().get(&key).is_some() {
            return Ok(());
        }
        Err(attributes.found(format!("no {key}"), "the coordinates of the material's texture"))
    }
}

/// The value, or the other one with a warning.
fn told<T>(result: Result<T, AssetError>, otherwise: T, warnings: &mut Vec<Warning>) -> T {
    result.unwrap_or_else(|error| {
        warnings.push(Warning::instead(&error, "material", "the default is taken"));
        otherwise
    })
}

/// What holds the base colour, and the names of its factor and its texture in there.
fn base(material: Json<'_>) -> Result<Option<(Json<'_>, [&'static str; 2])>, AssetError> {
    if let Some(base) = material.get("pbrMetallicRoughness")? {
        return Ok(Some((base, ["baseColorFactor", "baseColorTexture"])));
    }
    let older = extension(material, "KHR_materials_pbrSpecularGlossiness")?;
    Ok(older.map(|base| (base, ["diffuseFactor", "diffuseTexture"])))
}

pub(crate) fn extension<'a>(json: Json<'a>, name: &'a str) -> Result<Option<Json<'a>>, AssetError> {
    json.get("extensions")?.map_or(Ok(None), |extensions| extensions.get(name))
}

fn color(base: Json<'_>, factor: &'static str) -> Result<Option<[f32; 4]>, AssetError> {
    let Some(factor) = base.get(factor)? else { return Ok(None) };
    Ok(Some(factor.floats::<4>()?.map(|c| c.clamp(0.0, 1.0) as f32)))
}

fn alpha(material: Json<'_>) -> Result<Alpha, AssetError> {
    /// What the standard says where a material does not.
    const CUTOFF: f64 = 0.5;
    let Some(mode) = material.get("alphaMode")? else { return Ok(Alpha::Opaque) };
    match mode.string()? {
        "OPAQUE" => Ok(Alpha::Opaque),
        "BLEND" => Ok(Alpha::Blend),
        "MASK" => {
            let cutoff = material.get("alphaCutoff")?.map_or(Ok(CUTOFF), Json::float)?;
            Ok(Alpha::Mask(cutoff as f32))
        }
        _ => Err(mode.fault("OPAQUE, MASK or BLEND")),
    }
}
