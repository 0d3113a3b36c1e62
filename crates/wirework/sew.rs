//! Seams of the effects that have any, on the points of a subject.

use std::path::Path;
use std::sync::Arc;

use wirework_asset::Limits;
use wirework_preset::{Action, Effect, Named, PresetErrorKind, Stitching};
use wirework_stitch::{Order, Seams, Stitch, StitchError, StitchWarning, Surfaces, merged, seams};
use wirework_surface::Cut;

use crate::evaluate::bounds_frame;
use crate::fit::Fit;
use crate::limbs::limbs;
use crate::mask::{Masks, masks};
use crate::refine::Refinement;
use crate::unfit::unfit;
use crate::{Evaluation, JobError, Subject};

/// How often borders are cut: those that several seams share, one after the other, pass vertices on to each other. Of seams that never
/// agree the rest stays as it is.
const ROUNDS: usize = 4;

/// Seams that are laid at once.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) seams: Seams,
    /// The number of the first of them in its stitch.
    pub(crate) first: usize,
    /// For each point its piece of the stitch.
    pub(crate) piece_of: Arc<[u32]>,
}

impl Part {
    /// What the seams lack, by their numbers in the stitch.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let first = self.first;
        let told = |warning: &StitchWarning| match warning {
            StitchWarning::Junctions { seam, vertices, widest } => {
                StitchWarning::Junctions { seam: seam + first, vertices: *vertices, widest: *widest }
                    .to_string()
            }
            other => other.to_string(),
        };
        let facing = |seam: usize| {
            format!(
                "seam {} is welded, but its sides disagree about the outside: normals cannot go on across it; turn a piece round, or set `reversed` [facing]",
                seam + first
            )
        };
        self.seams.warnings().iter().map(told).chain(self.seams.facing().map(facing)).collect()
    }
}

/// For each effect its seams: none but of a stitch; of one that is [`Order::Sequential`] each seam by itself.
pub(crate) type Sewn = Vec<Vec<Part>>;

/// Lays the seams of all effects. Each stitch is laid on what the effects before it, with their masks, make of the subject at 0 s.
///
/// # Errors
///
/// Seams that do not fit the subject, at their place in the preset.
pub(crate) fn sew(subject: &Subject, effects: &[Effect], masks: &Masks) -> Result<Sewn, JobError> {
    let mut sewn: Sewn = Vec::with_capacity(effects.len());
    for (index, effect) in effects.iter().enumerate() {
        sewn.push(match stitching(subject, effect) {
            Some(stitching) => lay(subject, effects, index, &stitching, (&sewn, masks))?,
            None => Vec::new(),
        });
    }
    Ok(sewn)
}

/// The same, with borders cut where seams are to be welded. Returns what was done to the subject besides.
///
/// # Errors
///
/// Also of [`Subject::cut`], and of [`masks`].
pub(crate) fn sew_welded(
    mut subject: Subject,
    effects: &[Effect],
    mut made: Masks,
    (folder, limits): (&Path, &Limits),
) -> Result<(Subject, Fit, Refinement), JobError> {
    let mut sewn = sew(&subject, effects, &made)?;
    let mut done = Refinement::default();
    for _ in 0..ROUNDS {
        // Of all seams at once, so that they are laid again only once.
        let cuts = merged(sewn.iter().flatten().flat_map(|part| part.seams.cuts()));
        if cuts.is_empty() {
            break;
        }
        let edges: Vec<Cut> =
            cuts.iter().map(|cut| Cut { ends: cut.ends, shares: cut.shares.clone() }).collect();
        let (cut, new, refinement) = subject.cut(&edges, limits)?;
        subject = cut;
        done.warnings.extend(refinement.warnings);
        done.take(refinement.meshes);
        if new.iter().all(Vec::is_empty) {
            break;
        }
        // Both at once might be more than the limits allow.
        drop(made);
        made = masks(&subject, effects, folder, limits)?.complete()?;
        resew(&subject, effects, (&mut sewn, &made), (&cuts, &new))?;
    }
    Ok((subject, Fit { masks: made, seams: sewn, ..Fit::default() }, done))
}

/// Lays all seams on a subject whose borders have been cut.
fn resew(
    subject: &Subject,
    effects: &[Effect],
    (sewn, masks): (&mut Sewn, &Masks),
    (cuts, new): (&[wirework_stitch::Cut], &[Vec<u32>]),
) -> Result<(), JobError> {
    for (index, effect) in effects.iter().enumerate() {
        let Some(stitching) = stitching(subject, effect) else { continue };
        let base = base(subject, effects, index, (sewn, masks))?;
        let (piece_of, sides) = (piece_of(subject, &stitching)?, sides(subject, &stitching)?);
        let surfaces =
            Surfaces { positions: &base, triangles: &subject.triangles, piece_of: &piece_of, sides: &sides };
        let fail = fault(effect);
        for part in &mut sewn[index] {
            part.seams = part.seams.cut(&surfaces, cuts, new).map_err(|error| fail(&error, part.first))?;
            part.piece_of = Arc::clone(&piece_of);
        }
    }
    Ok(())
}

/// A stitch in metres.
fn stitching(subject: &Subject, effect: &Effect) -> Option<Stitching> {
    match effect.placed(&bounds_frame(subject.bounds())).action {
        Action::Stitch(stitching) => Some(*stitching),
        _ => None,
    }
}

fn lay(
    subject: &Subject,
    effects: &[Effect],
    index: usize,
    stitching: &Stitching,
    before: (&Sewn, &Masks),
) -> Result<Vec<Part>, JobError> {
    let base = base(subject, effects, index, before)?;
    let (piece_of, sides) = (piece_of(subject, stitching)?, sides(subject, stitching)?);
    let surfaces =
        Surfaces { positions: &base, triangles: &subject.triangles, piece_of: &piece_of, sides: &sides };
    let fail = fault(&effects[index]);
    let settings = &stitching.stitch;
    let part = |first: usize, settings: &Stitch| {
        let seams = seams(&surfaces, settings).map_err(|error| fail(&error, first))?;
        Ok(Part { seams, first, piece_of: Arc::clone(&piece_of) })
    };
    if settings.order == Order::Simultaneous {
        return Ok(vec![part(0, settings)?]);
    }
    let alone = |(number, seam): (usize, &wirework_stitch::Seam)| {
        part(number, &Stitch { seams: vec![seam.clone()], ..settings.clone() })
    };
    settings.seams.iter().enumerate().map(alone).collect()
}

/// What an effect works on at 0 s.
fn base(
    subject: &Subject,
    effects: &[Effect],
    index: usize,
    (sewn, masks): (&Sewn, &Masks),
) -> Result<Vec<[f32; 3]>, JobError> {
    let mut points = subject.points.clone();
    if index > 0 {
        let before = &effects[..index];
        let of_effects = masks.of_effects.iter().take(index).cloned().collect();
        let seams = sewn.iter().take(index).cloned().collect();
        // Where a goal is at 0 s does not depend on how long it takes.
        let limbs = limbs(subject, before, 0.0)?;
        let fit = Fit { masks: Masks { of_effects, ..Masks::default() }, seams, limbs };
        let fail = unfit(&subject.origin, effects);
        let bounds = subject.bounds();
        let mut evaluation =
            Evaluation::fitted(before, fit, &subject.points, &subject.triangles, bounds).map_err(&fail)?;
        evaluation.at(0.0, &mut points).map_err(&fail)?;
    }
    Ok(points)
}

/// For each piece of a stitch that of the subject.
fn numbers(subject: &Subject, stitching: &Stitching) -> Result<Vec<usize>, JobError> {
    let list = &subject.pieces.list;
    let number = |named: &Named| {
        let found = list.iter().position(|piece| piece.name == named.name);
        found.ok_or_else(|| {
            let known: Vec<&str> = list.iter().map(|piece| piece.name.as_str()).collect();
            JobError::Preset(Box::new(named.unknown("piece", &known)))
        })
    };
    stitching.pieces.iter().map(|piece| number(&piece.name)).collect()
}

/// For each point the piece of a stitch.
fn piece_of(subject: &Subject, stitching: &Stitching) -> Result<Arc<[u32]>, JobError> {
    let mut own = vec![u32::MAX; subject.pieces.list.len()];
    for (number, piece) in (0..).zip(numbers(subject, stitching)?) {
        own[piece] = number;
    }
    let of = |piece: &u32| own.get(*piece as usize).copied().unwrap_or(u32::MAX);
    Ok(subject.pieces.of_points.iter().map(of).collect())
}

/// The sides of the pieces of a stitch.
fn sides(subject: &Subject, stitching: &Stitching) -> Result<Vec<Option<[Vec<u32>; 4]>>, JobError> {
    let numbers = numbers(subject, stitching)?;
    Ok(numbers.into_iter().map(|piece| subject.pieces.list[piece].sides.clone()).collect())
}

/// What is wrong with the seams of an effect, at its place; those of a sequential stitch count from the first of all.
fn fault(effect: &Effect) -> impl Fn(&StitchError, usize) -> JobError + use<'_> {
    move |error, first| {
        let path = error.path();
        let path = match path.strip_prefix("seams[0]").filter(|_| first > 0) {
            Some(rest) => format!("seams[{first}]{rest}"),
            None => path,
        };
        let message = error.to_string();
        JobError::Preset(Box::new(effect.typed.error(&path, PresetErrorKind::Value, message, None)))
    }
}
