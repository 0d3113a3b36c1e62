//! When to look: at every frame, and between frames where the way from one to the next is not straight.

use crate::error::BakeError;
use crate::field::Field;
use crate::vectors::{Vector, bulge};
use crate::writer::{Frame, Sample};

/// What has a state at any time, looked at in any order.
pub trait Moments {
    /// Why it cannot be looked at.
    type Error: From<BakeError>;

    /// All vertices at a time in seconds.
    ///
    /// # Errors
    ///
    /// Whatever keeps them from being worked out.
    fn at(&mut self, seconds: f64) -> Result<Frame<'_>, Self::Error>;

    /// Hears how far the work has come: `done` of `all` steps of about the same length.
    fn progress(&mut self, done: usize, all: usize);
}

/// How often the way between two frames is halved wherever that is needed: a fast motion would be looked at for ever.
const HALVINGS: usize = 4;

/// And where it is needed on one side only, as where a motion has a corner.
const AT_CORNERS: usize = 9;

/// Halves of a way that is off by no more times what is allowed are not: of a smooth one they are off by a quarter of it, at a corner by half.
const HALVED: f64 = 2.5;

/// Halvings after which that tells anything: a short event may show in halves only.
const ALWAYS: usize = 3;

/// A motion that has not settled so often is not looked at so closely any more.
const PATIENCE: usize = 16;

/// Where both halves are off by more than this part of what the whole is, the motion is not smooth at all, and looking closer is no use.
const JUMPY: f64 = 0.9;

/// A way is looked at only where the curvature before and after it says that it is off by more than one in so many parts of what is allowed.
const SURE: f64 = 4.0;

/// A moment, and the displacements of each node as lists.
#[derive(Debug)]
pub(crate) struct Look {
    pub(crate) sample: Sample,
    pub(crate) places: Vec<Vec<Vector>>,
}

impl Look {
    pub(crate) fn new(sample: Sample, fields: &[Field]) -> Self {
        let places = fields.iter().map(|field| field.places(&sample)).collect();
        Self { sample, places }
    }

    fn time(&self) -> f64 {
        self.sample.time
    }
}

/// Looks at all `times` and, where what is in between is farther than `tolerance` from the straight way, metres, there too. Gives `take` what
/// it has seen, in the order of time.
pub(crate) fn looked<E>(
    times: &[f64],
    tolerance: f64,
    look: &mut impl FnMut(f64) -> Result<Look, E>,
    take: &mut impl FnMut(&Look) -> Result<(), E>,
) -> Result<(), E> {
    let mut between = Between { tolerance, unsettled: 0, look, take };
    let mut frames: Vec<Look> = Vec::with_capacity(3);
    // Of the frames before; unknown at the start.
    let mut before = None;
    for &time in times {
        frames.push((between.look)(time)?);
        if let [first] = frames.as_slice() {
            (between.take)(first)?;
        }
        if let [a, b, c] = frames.as_slice() {
            let after = curvature(a, b, c);
            between.straightened(a, b, after.max(before.unwrap_or(0.0)))?;
            (between.take)(b)?;
            before = Some(after);
            frames.remove(0);
        }
    }
    if let [a, b] = frames.as_slice() {
        between.straightened(a, b, before.unwrap_or(f64::INFINITY))?;
        (between.take)(b)?;
    }
    Ok(())
}

/// The greatest second derivative of a vertex, metres a second squared.
fn curvature(a: &Look, b: &Look, c: &Look) -> f64 {
    let (before, after) = (b.time() - a.time(), c.time() - b.time());
    2.0 * bulges(a, b, c) / (before * after)
}

fn bulges(a: &Look, b: &Look, c: &Look) -> f64 {
    let part = (b.time() - a.time()) / (c.time() - a.time());
    let nodes = a.places.iter().zip(&b.places).zip(&c.places);
    nodes.map(|((a, b), c)| bulge(a, b, c, part)).fold(0.0, f64::max)
}

struct Between<'a, L, T> {
    tolerance: f64,
    /// How often looking closer has been no use.
    unsettled: usize,
    look: &'a mut L,
    take: &'a mut T,
}

impl<E, L: FnMut(f64) -> Result<Look, E>, T: FnMut(&Look) -> Result<(), E>> Between<'_, L, T> {
    /// Looks between two frames where the curvature tells to.
    fn straightened(&mut self, a: &Look, b: &Look, curvature: f64) -> Result<(), E> {
        let step = b.time() - a.time();
        if SURE * curvature * step * step / 8.0 <= self.tolerance {
            return Ok(());
        }
        if let Some((middle, off)) = self.bulging(a, b)? {
            self.halved(a, (&middle, off), b, 1)?;
        }
        Ok(())
    }

    /// What is in the middle of a way where that is off, and by how much.
    fn bulging(&mut self, a: &Look, b: &Look) -> Result<Option<(Look, f64)>, E> {
        let middle = a.time().midpoint(b.time());
        // Files keep times as 32-bit floats.
        let [start, between, end] = [a.time(), middle, b.time()].map(|time| time as f32);
        if between <= start || end <= between {
            return Ok(None);
        }
        let middle = (self.look)(middle)?;
        let off = bulges(a, &middle, b);
        Ok((off > self.tolerance).then_some((middle, off)))
    }

    /// Takes what is in the middle of a way, and looks on both sides of it where it is off so far that they may be.
    fn halved(&mut self, a: &Look, (middle, off): (&Look, f64), b: &Look, times: usize) -> Result<(), E> {
        if times >= AT_CORNERS || off <= HALVED * self.tolerance {
            return (self.take)(middle);
        }
        let sides = [self.bulging(a, middle)?, self.bulging(middle, b)?];
        let still_off = |part: f64| sides.iter().flatten().filter(|(_, side)| *side > part * off).count();
        let patient = times < ALWAYS && self.unsettled < PATIENCE;
        let settles = patient || still_off(JUMPY) < 2;
        self.unsettled += usize::from(!settles);
        let goes_on = settles && (times < HALVINGS || still_off(0.0) == 1);
        let [before, after] = sides.map(|side| side.filter(|_| goes_on));
        if let Some((before, off)) = before {
            self.halved(a, (&before, off), middle, times + 1)?;
        }
        (self.take)(middle)?;
        after.map_or(Ok(()), |(after, off)| self.halved(middle, (&after, off), b, times + 1))
    }
}
