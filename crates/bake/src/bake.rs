//! All of it: look at a motion, choose what plays it, write that, and see how far it is off.

use std::rc::Rc;

use wirework_asset::{Gltf, Rest};
use wirework_surface::Bounds;

use crate::adapt::{Look, Moments, looked};
use crate::areas::Areas;
use crate::error::BakeError;
use crate::field::Field;
use crate::frames::Baker;
use crate::play::{Off, Playing, Way, worst};
use crate::settings::{Bake, Settings};
use crate::study::Study;
use crate::writer::{Baked, Frame, NodeBake, Played, Sample, Writer, key_time};

/// The part of the tolerance by which the way between two samples may be off.
const OF_WAYS: f64 = 0.25;

/// Where between two frames it is looked how far players are off: not in the middle, where it has been looked before.
const BETWEEN: f64 = 0.382;

/// Bakes what `moments` shows at `times`, seconds that rise from 0, and in between, into morph targets of `gltf` and a clip.
///
/// With [`Bake::Frames`] each time gets a target. Otherwise times between them are looked at, too, where the motion is not straight, so that
/// what plays is within [`Settings::tolerance`] at any time; how far it is off has been measured then ([`Baked::played`]).
///
/// # Errors
///
/// Those of `moments`; a tolerance that is none, and one that takes more targets than are allowed; times that do not rise, vertices that
/// are not finite or of another number than the rest's.
pub fn bake<M: Moments>(
    gltf: Gltf,
    rest: &Rest,
    settings: Settings,
    times: &[f64],
    moments: &mut M,
) -> Result<Baked, M::Error> {
    if settings.bake == Bake::Frames {
        let mut baker = Baker::new(gltf, rest, settings);
        for (done, &time) in times.iter().enumerate() {
            baker.push(time, &moments.at(time)?)?;
            moments.progress(done + 1, times.len());
        }
        return Ok(baker.finish()?);
    }
    check(times, settings.tolerance)?;
    let writer = Writer::new(gltf, rest, settings);
    let frames = times.len();
    let diagonal = diagonal(rest);
    let mut work = Work { writer, moments, frames, areas: Areas::new(rest), diagonal, cached: None };
    let (fields, studies) = work.studied(times)?;
    let (mut playing, off) = work.planned(&fields, studies)?;
    let off = worst(off, work.played(times, &fields, &mut playing)?);
    Ok(work.finish(playing, off)?)
}

fn check(times: &[f64], tolerance: f64) -> Result<(), BakeError> {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(BakeError::NoTolerance(tolerance));
    }
    let mut before = None;
    for (frame, &time) in times.iter().enumerate() {
        before = Some(key_time(frame, time, before)?);
    }
    Ok(())
}

/// A frame in the spaces of the meshes, with normals as long as the area round them, so that those of sums, and between two poses, are
/// right, too.
fn lengthened(
    (writer, areas, fields): (&Writer<'_>, &Areas, &[Field]),
    (index, time): (usize, f64),
    frame: &Frame<'_>,
) -> Result<Sample, BakeError> {
    let mut sample = writer.sample(index, time, frame)?;
    let growth = areas.growth(writer.rest, &frame.moment.positions, frame.positions);
    for field in fields {
        field.lengthen(&mut sample, &growth);
    }
    Ok(sample)
}

/// The diagonal of what is shown at rest, metres; 1 where that has no extent.
fn diagonal(rest: &Rest) -> f64 {
    let diagonal = Bounds::of(&rest.positions).map_or(0.0, |bounds| f64::from(bounds.diagonal()));
    if diagonal > 0.0 { diagonal } else { 1.0 }
}

struct Work<'a, 'm, M> {
    writer: Writer<'a>,
    moments: &'m mut M,
    /// How many frames were asked for.
    frames: usize,
    areas: Areas,
    /// Of the rest, metres.
    diagonal: f64,
    /// The last key pose, which several nodes may want.
    cached: Option<Rc<Sample>>,
}

impl<M: Moments> Work<'_, '_, M> {
    /// What is allowed, metres.
    fn tolerance(&self) -> f64 {
        self.writer.settings.tolerance * self.diagonal
    }

    /// Looks at the whole motion.
    fn studied(&mut self, times: &[f64]) -> Result<(Vec<Field>, Vec<Study>), M::Error> {
        let tolerance = self.tolerance();
        let Self { writer, moments, frames, areas, diagonal, .. } = self;
        let fields =
            writer.nodes.iter().map(|node| Field::new(writer.rest, node, |block| writer.is_mapped(block)));
        let fields: Vec<Field> = fields.collect();
        let mut studies = Study::all(&fields, writer.rest, writer.settings.bake, (tolerance, *diagonal));
        let (mut stuck, mut done) = (0, 0);
        let mut look = |time: f64| -> Result<Look, M::Error> {
            let sample = lengthened((writer, areas, &fields), (done, time), &moments.at(time)?)?;
            if times.get(done).is_some_and(|frame| *frame == time) {
                done += 1;
                moments.progress(done, 2 * *frames);
            }
            stuck = stuck.max(sample.stuck);
            Ok(Look::new(sample, &fields))
        };
        let mut take = |look: &Look| -> Result<(), M::Error> {
            for (node, (study, places)) in studies.iter_mut().zip(&look.places).enumerate() {
                let (rests, own) =
                    (!writer.moves(node, &look.sample), writer.own_weights(node, &look.sample));
                let directions = fields[node].directions(&look.sample);
                study.push(look.sample.time, rests, own, places, directions);
            }
            Ok(())
        };
        looked(times, OF_WAYS * tolerance, &mut look, &mut take)?;
        self.writer.stuck = stuck;
        Ok((fields, studies))
    }

    /// Chooses what each node plays.
    fn planned(&self, fields: &[Field], studies: Vec<Study>) -> Result<(Vec<Playing>, Off), BakeError> {
        let mut off = Off::default();
        let (mut playing, mut needs) = (Vec::with_capacity(studies.len()), Vec::new());
        let mut short = None;
        for (node, mut study) in studies.into_iter().enumerate() {
            let own = self.writer.nodes[node].own;
            match study.plan(self.writer.settings.room(own)) {
                Ok((plan, targets)) => {
                    needs.push((own, Some(targets)));
                    let (one, error) = Playing::new((node, &fields[node]), study, plan, self.tolerance());
                    off.metres = off.metres.max(error);
                    playing.push(one);
                }
                Err(own_short) => {
                    needs.push((own, own_short.targets));
                    short = Some(match short {
                        None => (node, own_short),
                        Some((first, known)) => (first, own_short.also(known)),
                    });
                }
            }
        }
        let Some((node, short)) = short else { return Ok((playing, off)) };
        Err(short.error(
            (self.writer.mesh_name(node), self.writer.nodes[node].own),
            &needs,
            &self.writer.settings,
        ))
    }

    /// Writes key poses, and looks between frames how far what is shown is off.
    fn played(&mut self, times: &[f64], fields: &[Field], playing: &mut [Playing]) -> Result<Off, M::Error> {
        let mut off = Off::default();
        for (index, pair) in times.windows(2).enumerate() {
            let time = pair[0] + BETWEEN * (pair[1] - pair[0]);
            self.keys_up_to(fields, playing, time)?;
            let frame = self.moments.at(time)?;
            let sample = self.writer.sample(index, time, &frame)?;
            for one in playing.iter() {
                off = worst(off, one.off(&self.writer.nodes[one.node].blocks, &frame, &sample));
            }
            let done = self.frames + (index + 1) * self.frames / times.len();
            self.moments.progress(done, 2 * self.frames);
        }
        self.keys_up_to(fields, playing, f64::INFINITY)?;
        self.moments.progress(2 * self.frames, 2 * self.frames);
        Ok(off)
    }

    /// Writes the key poses that are needed to know what is shown at a time.
    fn keys_up_to(
        &mut self,
        fields: &[Field],
        playing: &mut [Playing],
        seconds: f64,
    ) -> Result<(), M::Error> {
        for one in playing {
            while let Some(time) = one.wanted(seconds) {
                let known = self.cached.as_ref().filter(|sample| sample.time == time);
                let sample = if let Some(known) = known {
                    Rc::clone(known)
                } else {
                    let frame = self.moments.at(time)?;
                    Rc::new(lengthened((&self.writer, &self.areas, fields), (0, time), &frame)?)
                };
                self.cached = Some(Rc::clone(&sample));
                one.write_key(&mut self.writer, &sample)?;
            }
        }
        Ok(())
    }

    fn finish(self, playing: Vec<Playing>, off: Off) -> Result<Baked, BakeError> {
        let tolerance = self.tolerance();
        let mut writer = self.writer;
        let mut clips = Vec::with_capacity(playing.len());
        let mut nodes = Vec::new();
        let samples = playing.first().map_or(0, |one| one.study.seen.len());
        for one in playing {
            let bake = match one.way {
                Way::Still => None,
                Way::Keys(_) => Some(Bake::Keys),
                Way::Basis(_) => Some(Bake::Basis),
            };
            let (node, targets) = (writer.nodes[one.node].index, one.target_count());
            let clip = one.clip(&mut writer)?;
            let keys = clip.track.times.as_ref().map_or(0, Vec::len);
            nodes.extend(bake.filter(|_| targets > 0).map(|bake| NodeBake { node, bake, targets, keys }));
            clips.push(clip);
        }
        if off.metres > tolerance {
            let message = format!(
                "at {:.3} s a vertex is {:.2e} m off, and {tolerance:.2e} m are allowed: the motion jumps there, is too fast to be followed, or \
                 that is finer than 32-bit floats",
                off.seconds, off.metres
            );
            writer.gltf.warn("tolerance", message);
        }
        let played = Played {
            error: off.metres,
            of_diagonal: off.metres / self.diagonal,
            normals: off.radians,
            normals_mean: off.all.0 / off.all.1.max(1) as f64,
            samples,
            nodes,
        };
        Ok(Baked { played: Some(played), ..writer.finish(&[0.0], clips)? })
    }
}
