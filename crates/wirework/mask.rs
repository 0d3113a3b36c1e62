//! What an effect may move and how much: `only` and `mask` of a preset as a factor of `F` for each point.
//!
//! A factor is a number from 0 to 1. With `only` a point, which stands for all vertices at one place, has the *least* factor
//! of its vertices: nothing moves that may not, and no seam opens. With a painted mask it has their *mean*. Where an effect has
//! several masks, its own and that of a wire, their factors are multiplied.

mod only;
mod paint;
mod plane;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use wirework_asset::{AssetError, Limits, printable};
use wirework_preset::{Action, Effect, Mask, Only, PresetError, PresetErrorKind};
use wirework_surface::Near;

use crate::{JobError, Model, Subject};

/// A factor for each point.
type Factors = Arc<[f32]>;

/// So many names that are not there are looked up for the nearest one; a preset may have as many as it has bytes.
const MISSING_LISTED: usize = 64;

/// Why there are no factors.
#[derive(Debug)]
enum Lack {
    /// The object lacks what the preset asks for: names, colours, texture coordinates.
    Missing(Vec<PresetError>),
    /// Whatever else is wrong.
    Other(JobError),
}

impl From<JobError> for Lack {
    fn from(error: JobError) -> Self {
        Self::Other(error)
    }
}

impl From<AssetError> for Lack {
    fn from(error: AssetError) -> Self {
        Self::Other(error.into())
    }
}

/// The masks of one effect.
#[derive(Clone, Debug, Default)]
pub(crate) struct EffectMasks {
    /// Of the effect as a whole; none: 1 everywhere.
    all: Option<Factors>,
    /// Of each wire, that of the effect multiplied in; empty where no wire has one of its own.
    wires: Vec<Option<Factors>>,
}

/// The masks of all effects of a preset.
#[derive(Clone, Debug, Default)]
pub(crate) struct Masks {
    /// One an effect, in their order.
    pub(crate) of_effects: Vec<EffectMasks>,
    /// What an effect asks for that is there, but has no vertex, and the like.
    pub(crate) warnings: Vec<String>,
    /// What effects ask for that the object lacks; its masks are left out.
    pub(crate) missing: Vec<PresetError>,
}

impl Masks {
    /// The masks, if nothing is missing.
    pub(crate) fn complete(mut self) -> Result<Self, JobError> {
        if self.missing.is_empty() { Ok(self) } else { Err(refused(self.missing.swap_remove(0))) }
    }
}

impl EffectMasks {
    /// Whether an effect, or a wire of it, has any.
    pub(crate) fn wanted(effect: &Effect) -> bool {
        effect.mask.is_some() || effect.only.is_some() || wires_own(effect).any(|own| own != (None, None))
    }

    /// What multiplies the effect as a whole.
    pub(crate) fn of_effect(&self) -> Option<&[f32]> {
        self.all.as_deref()
    }

    /// What multiplies `F` of each of the effect's `count` wires, which act only near themselves, where `near` says so.
    pub(crate) fn of_wires<'a>(&'a self, near: &'a [Near], count: usize) -> Vec<WireMask<'a>> {
        let own = |wire| self.wires.get(wire).map_or(self.of_effect(), Option::as_deref);
        let mask = |wire| match (own(wire), near.get(wire)) {
            (None, None) => WireMask::None,
            (Some(factors), None) => WireMask::All(factors),
            (None, Some(near)) => WireMask::Near(near, Cow::Borrowed(&near.factors)),
            (Some(factors), Some(near)) => WireMask::Near(near, Cow::Owned(product(near, factors))),
        };
        (0..count).map(mask).collect()
    }
}

/// What multiplies `F` of a wire.
pub(crate) enum WireMask<'a> {
    None,
    All(&'a [f32]),
    Near(&'a Near, Cow<'a, [f32]>),
}

impl WireMask<'_> {
    pub(crate) fn borrow(&self) -> Option<wirework_core::Mask<'_>> {
        match self {
            Self::None => None,
            Self::All(factors) => Some(wirework_core::Mask::Dense(factors)),
            Self::Near(near, factors) => {
                Some(wirework_core::Mask::Sparse { points: &near.vertices, factors })
            }
        }
    }
}

/// The factors of points near a wire, times those that hold everywhere.
fn product(near: &Near, factors: &[f32]) -> Vec<f32> {
    let own = |slot: usize| near.factors.get(slot).copied().unwrap_or(1.0);
    let factor =
        |(slot, point): (usize, &u32)| own(slot) * factors.get(*point as usize).copied().unwrap_or(0.0);
    near.vertices.iter().enumerate().map(factor).collect()
}

/// What a wire asks for itself.
type Own<'a> = (Option<&'a Only>, Option<&'a Mask>);

/// `only` and `mask` of each wire; the wires of a wrinkle have none of their own.
fn wires_own(effect: &Effect) -> impl Iterator<Item = Own<'_>> {
    let wires = match &effect.action {
        Action::Deform(deform) => deform.wires.as_slice(),
        Action::Wrinkle(_) | Action::Stitch(_) | Action::Ik(_) => &[],
    };
    wires.iter().map(|wire| (wire.only(), wire.mask()))
}

/// All painted masks of effects and their wires.
fn painted(effects: &[Effect]) -> impl Iterator<Item = &Mask> {
    let own = effects.iter().flat_map(|effect| wires_own(effect).filter_map(|(_, mask)| mask));
    own.chain(effects.iter().filter_map(|effect| effect.mask.as_ref()))
}

/// The images that masks are read from, by which nothing else is to be replaced.
pub(crate) fn mask_files(effects: &[Effect], preset_dir: &Path) -> Vec<PathBuf> {
    let file = |mask: &Mask| match mask {
        Mask::Image { file, .. } => Some(preset_dir.join(&file.name)),
        Mask::VertexColor { .. } => None,
    };
    painted(effects).filter_map(file).collect()
}

/// Whether the images that effects ask for can be read: what can be known of masks without an object. They are relative to
/// `preset_dir`.
///
/// # Errors
///
/// [`JobError::Preset`]: one that is not there, or cannot be read or used.
pub fn check_images(effects: &[Effect], preset_dir: &Path, limits: &Limits) -> Result<(), JobError> {
    painted(effects).try_for_each(|mask| paint::check(mask, preset_dir, limits))
}

/// The masks of `effects` on the points of `subject`, and what is missing for them; images are relative to `preset_dir`.
///
/// # Errors
///
/// [`JobError::Preset`]: an image that cannot be read; [`JobError::Asset`]: malformed colours or indices.
pub(crate) fn masks(
    subject: &Subject,
    effects: &[Effect],
    preset_dir: &Path,
    limits: &Limits,
) -> Result<Masks, JobError> {
    let mut maker = Maker {
        subject,
        preset_dir,
        limits,
        onlys: Vec::new(),
        paints: Vec::new(),
        made: 0,
        warnings: Vec::new(),
        missing: Vec::new(),
    };
    let of_effects = effects.iter().map(|effect| maker.effect(effect)).collect::<Result<_, _>>()?;
    Ok(Masks { of_effects, warnings: maker.warnings, missing: maker.missing })
}

/// Makes masks, each once: the many wires of a lattice share theirs.
struct Maker<'a> {
    subject: &'a Subject,
    preset_dir: &'a Path,
    limits: &'a Limits,
    onlys: Vec<(&'a Only, Option<Factors>)>,
    paints: Vec<(&'a Mask, Option<Factors>)>,
    /// How many lists there are.
    made: u64,
    warnings: Vec<String>,
    missing: Vec<PresetError>,
}

impl<'a> Maker<'a> {
    fn effect(&mut self, effect: &'a Effect) -> Result<EffectMasks, JobError> {
        let only = effect.only.as_ref().map_or(Ok(None), |only| self.only(only))?;
        let paint = effect.mask.as_ref().map_or(Ok(None), |mask| self.paint(mask))?;
        let mut all = self.product(only, paint)?;
        if let Action::Ik(_) = &effect.action {
            let factors = only::weighed(effect, self.subject, &mut self.warnings);
            let weights = self.take(factors)?;
            all = self.product(all, weights)?;
        }
        if wires_own(effect).all(|own| own == (None, None)) {
            return Ok(EffectMasks { all, wires: Vec::new() });
        }
        let mut known: Vec<(Own<'_>, Option<Factors>)> = Vec::new();
        let mut wires = Vec::new();
        for own in wires_own(effect) {
            if own == (None, None) {
                wires.push(all.clone());
                continue;
            }
            if let Some((_, mask)) = known.iter().find(|(other, _)| *other == own) {
                wires.push(mask.clone());
                continue;
            }
            let only = own.0.map_or(Ok(None), |only| self.only(only))?;
            let paint = own.1.map_or(Ok(None), |mask| self.paint(mask))?;
            let both = self.product(only, paint)?;
            let mask = self.product(all.clone(), both)?;
            known.push((own, mask.clone()));
            wires.push(mask);
        }
        Ok(EffectMasks { all, wires })
    }

    fn only(&mut self, only: &'a Only) -> Result<Option<Factors>, JobError> {
        if let Some((_, known)) = self.onlys.iter().find(|(other, _)| *other == only) {
            return Ok(known.clone());
        }
        if self.missing.len() >= MISSING_LISTED {
            return Ok(None);
        }
        let factors = only::factors(only, self.subject, &mut self.warnings);
        let factors = self.take(factors)?;
        self.onlys.push((only, factors.clone()));
        Ok(factors)
    }

    fn paint(&mut self, mask: &'a Mask) -> Result<Option<Factors>, JobError> {
        if let Some((_, known)) = self.paints.iter().find(|(other, _)| *other == mask) {
            return Ok(known.clone());
        }
        let factors = paint::factors(mask, self.subject, self.preset_dir, self.limits, &mut self.warnings);
        let factors = self.take(factors)?;
        self.paints.push((mask, factors.clone()));
        Ok(factors)
    }

    fn product(&mut self, a: Option<Factors>, b: Option<Factors>) -> Result<Option<Factors>, JobError> {
        match (a, b) {
            (Some(a), Some(b)) => self.keep(a.iter().zip(b.iter()).map(|(a, b)| a * b).collect()),
            (a, b) => Ok(a.or(b)),
        }
    }

    /// The factors, or a note of what is missing for them.
    fn take(&mut self, factors: Result<Vec<f32>, Lack>) -> Result<Option<Factors>, JobError> {
        match factors {
            Ok(factors) => self.keep(factors),
            Err(Lack::Other(error)) => Err(error),
            Err(Lack::Missing(errors)) => {
                let file = match &self.subject.model {
                    Model::Gltf { gltf, .. } => Some(gltf.file()),
                    Model::Mesh { obj, .. } => obj.as_ref().map(|obj| obj.file()),
                };
                let file = file.map_or_else(String::new, |file| format!("{}: ", printable(file)));
                self.missing.extend(errors.into_iter().map(|error| {
                    let message = format!("{file}{}", error.message);
                    PresetError { message, ..error }
                }));
                Ok(None)
            }
        }
    }

    /// The factors, unless all are 1. All lists together must keep within the limit on expanded bytes.
    fn keep(&mut self, factors: Vec<f32>) -> Result<Option<Factors>, JobError> {
        if factors.iter().all(|&factor| factor == 1.0) {
            return Ok(None);
        }
        self.made += 1;
        let bytes = self.made.saturating_mul(size_of_val(factors.as_slice()) as u64);
        if bytes > self.limits.expanded_bytes {
            let limit = self.limits.expanded_bytes;
            let message = format!(
                "the masks need {bytes} bytes; at most {limit} are allowed (--max-expanded-bytes raises it)"
            );
            return Err(refused(PresetError { kind: PresetErrorKind::Limit, ..nowhere(message) }));
        }
        Ok(Some(factors.into()))
    }
}

fn refused(error: PresetError) -> JobError {
    JobError::Preset(Box::new(error))
}

/// An error about the masks as a whole.
fn nowhere(message: String) -> PresetError {
    let kind = PresetErrorKind::Value;
    PresetError { message, span: 0..0, line: 1, column: 1, help: None, path: String::new(), kind }
}
