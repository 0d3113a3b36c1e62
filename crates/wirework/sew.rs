//! Seams of the effects that have any, on the points of a subject.

use wirework_asset::Limits;
use wirework_preset::{Action, Effect, Named, PresetErrorKind, Stitching};
use wirework_stitch::{Order, Seams, Stitch, StitchError, Surfaces, seams};
use wirework_surface::Cut;

use crate::evaluate::bounds_frame;
use crate::fit::Fit;
use crate::refine::Refinement;
use crate::unfit::unfit;
use crate::{Evaluation, JobError, Subject};

/// For each effect its seams: none but of a stitch; of one that is [`Order::Sequential`] each seam by itself.
pub(crate) type Sewn = Vec<Vec<Seams>>;

/// Lays the seams of all effects. Each stitch is laid on what the effects before it make of the subject at 0 s.
///
/// # Errors
///
/// Seams that do not fit the subject, at their place in the preset.
pub(crate) fn sew(subject: &Subject, effects: &[Effect]) -> Result<Sewn, JobError> {
    let mut sewn: Sewn = Vec::with_capacity(effects.len());
    for (index, effect) in effects.iter().enumerate() {
        sewn.push(match stitching(subject, effect) {
            Some(stitching) => lay(subject, effects, index, &stitching, &sewn)?,
            None => Vec::new(),
        });
    }
    Ok(sewn)
}

/// The same, with borders cut where seams are to be welded. Returns what was done to the subject besides.
///
/// # Errors
///
/// Also of [`Subject::cut`].
pub(crate) fn sew_welded(
    mut subject: Subject,
    effects: &[Effect],
    limits: &Limits,
) -> Result<(Subject, Sewn, Refinement), JobError> {
    let mut sewn = sew(&subject, effects)?;
    let mut done = Refinement::default();
    for index in 0..sewn.len() {
        for part in 0..sewn[index].len() {
            let cuts: Vec<Cut> = sewn[index][part]
                .cuts()
                .into_iter()
                .map(|wirework_stitch::Cut { ends, shares }| Cut { ends, shares })
                .collect();
            if cuts.is_empty() {
                continue;
            }
            let (cut, new, refinement) = subject.cut(&cuts, limits)?;
            subject = cut;
            done.warnings.extend(refinement.warnings);
            done.take(refinement.meshes);
            resew(&subject, effects, &mut sewn, (index, part), &new)?;
        }
    }
    Ok((subject, sewn, done))
}

/// Lays all seams on a subject of which borders have been cut for one of them.
fn resew(
    subject: &Subject,
    effects: &[Effect],
    sewn: &mut Sewn,
    cut: (usize, usize),
    new: &[Vec<u32>],
) -> Result<(), JobError> {
    for (index, effect) in effects.iter().enumerate() {
        let Some(stitching) = stitching(subject, effect) else { continue };
        let base = base(subject, effects, index, sewn)?;
        let (piece_of, sides) = (piece_of(subject, &stitching)?, sides(subject, &stitching)?);
        let surfaces =
            Surfaces { positions: &base, triangles: &subject.triangles, piece_of: &piece_of, sides: &sides };
        let fail = fault(effect);
        for (part, seams) in sewn[index].iter_mut().enumerate() {
            // The others only have to know of the new points.
            let new = if (index, part) == cut { new } else { &[] };
            *seams = seams.cut(&surfaces, new).map_err(|error| fail(&error, part))?;
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
    sewn: &Sewn,
) -> Result<Vec<Seams>, JobError> {
    let base = base(subject, effects, index, sewn)?;
    let (piece_of, sides) = (piece_of(subject, stitching)?, sides(subject, stitching)?);
    let surfaces =
        Surfaces { positions: &base, triangles: &subject.triangles, piece_of: &piece_of, sides: &sides };
    let fail = fault(&effects[index]);
    let settings = &stitching.stitch;
    if settings.order == Order::Simultaneous {
        return Ok(vec![seams(&surfaces, settings).map_err(|error| fail(&error, 0))?]);
    }
    let alone = |(number, seam): (usize, &wirework_stitch::Seam)| {
        let settings = Stitch { seams: vec![seam.clone()], ..settings.clone() };
        seams(&surfaces, &settings).map_err(|error| fail(&error, number))
    };
    settings.seams.iter().enumerate().map(alone).collect()
}

/// What an effect works on at 0 s.
fn base(subject: &Subject, effects: &[Effect], index: usize, sewn: &Sewn) -> Result<Vec<[f32; 3]>, JobError> {
    let mut points = subject.points.clone();
    if index > 0 {
        let before = &effects[..index];
        let fit = Fit { seams: sewn.iter().take(index).cloned().collect(), ..Fit::default() };
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
fn piece_of(subject: &Subject, stitching: &Stitching) -> Result<Vec<u32>, JobError> {
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
