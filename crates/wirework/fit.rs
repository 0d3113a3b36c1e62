//! What effects have of the subject that they are bound to, and the subject as they need it.

use std::path::Path;

use wirework_asset::Limits;
use wirework_preset::Effect;

use crate::fineness::{Span, refined};
use crate::limbs::{Reach, limbs};
use crate::mask::Masks;
use crate::refine::Refinement;
use crate::sew::{Sewn, sew_welded};
use crate::{JobError, Subject};

/// What effects have of a subject.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fit {
    pub(crate) masks: Masks,
    /// Of each effect; none but of stitches.
    pub(crate) seams: Sewn,
    /// Of each effect its limb; none but of limbs.
    pub(crate) limbs: Vec<Option<Reach>>,
}

/// Makes the subject as fine as effects ask, cuts borders that are to be welded, and looks up in it what they name.
///
/// # Errors
///
/// As [`refined`], [`sew_welded`] and [`limbs`].
pub(crate) fn fit(
    subject: Subject,
    effects: &[Effect],
    (span, duration): (Span, f64),
    (folder, limits): (&Path, &Limits),
) -> Result<(Subject, Fit, Refinement), JobError> {
    let (subject, made, mut refinement) = refined(subject, effects, span, (folder, limits))?;
    let (subject, mut fit, cut) = sew_welded(subject, effects, made, (folder, limits))?;
    fit.limbs = limbs(&subject, effects, duration)?;
    refinement.warnings.extend(cut.warnings);
    refinement.take(cut.meshes);
    Ok((subject, fit, refinement))
}
