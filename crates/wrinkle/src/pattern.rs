//! Where creases run: lines on the surface, laid out from a centre by geodesics.

use wirework_surface::{Stop, Walker};

use crate::ground::{Ground, MOST_CROSSINGS, wide};
use crate::ripple::Rays;
use crate::trace::Trace;
use crate::{Layout, Pattern, Wrinkle, WrinkleError, WrinkleWarning, drawn, radial, tangential};

/// The part of a crease that may be missing without a word: less than anyone sees.
const SHORT: f64 = 1e-3;

/// A line on the surface for a crease to stand on.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) trace: Trace,
    pub(crate) closed: bool,
    /// Distances of its ends from the origin, as fractions of the crease.
    pub(crate) range: (f64, f64),
    /// Its own part of the height.
    pub(crate) strength: f64,
    /// The distance to the next creases at its ends.
    pub(crate) spacing: (f64, f64),
    /// Which crease of the pattern it is, or is a part of.
    pub(crate) index: usize,
    /// What it branches off.
    pub(crate) fork: Option<Fork>,
}

/// Where a branch leaves its stem.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fork {
    /// The stem's number among all lines; less than the branch's.
    pub(crate) stem: usize,
    /// The part of the stem's length up to there.
    pub(crate) at: f64,
}

/// All lines of a moment, and what is to be said of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lines {
    pub(crate) list: Vec<Line>,
    pub(crate) warnings: Vec<WrinkleWarning>,
    /// Creases of the pattern that are not there at all.
    pub(crate) outside: usize,
    /// Ends of creases that a border cut.
    pub(crate) cut: usize,
    /// Ends of creases that a non-manifold edge cut.
    pub(crate) crowded: usize,
    /// Ends of rings between geodesics that have parted.
    pub(crate) parted: usize,
}

/// What is prepared once.
#[derive(Debug, Default)]
pub(crate) struct Prepared {
    rays: Option<Rays>,
}

/// Prepares what all moments have in common.
pub(crate) fn prepare(ground: &Ground, settings: &Wrinkle, thickness: f32) -> Result<Prepared, WrinkleError> {
    let rays = match &settings.pattern {
        Pattern::Ripple(layout) => {
            let (walker, _) = start(ground, layout)?;
            Some(Rays::new(ground, &walker, f64::from(layout.size[0]) / 2.0, settings, f64::from(thickness))?)
        }
        _ => None,
    };
    Ok(Prepared { rays })
}

/// Refuses lines that would wind round the surface for ever. Rings do not walk once their rays have.
fn check_walks(ground: &Ground, settings: &Wrinkle, seconds: f64) -> Result<(), WrinkleError> {
    let [along, across] = settings.motion.velocity();
    let way = along.hypot(across) * seconds;
    let length = match &settings.pattern {
        Pattern::Drawn(_) | Pattern::Auto { .. } => 0.0,
        Pattern::Tangential(layout) => f64::from(layout.size[0].max(layout.size[1])),
        Pattern::Radial(layout, _) => f64::from(layout.size[0]) / 2.0,
        Pattern::Ripple(_) => return Ok(()),
    };
    ground.check_walks(settings.crease_count(), length + way, MOST_CROSSINGS)
}

/// The lines of a pattern at a moment.
pub(crate) fn lines(
    ground: &Ground,
    prepared: &Prepared,
    settings: &Wrinkle,
    seconds: f64,
    thickness: f32,
) -> Result<Lines, WrinkleError> {
    let mut lines = Lines::default();
    check_walks(ground, settings, seconds)?;
    match &settings.pattern {
        Pattern::Drawn(curves) => {
            for (index, drawn) in curves.iter().enumerate() {
                match drawn::drop(ground, &drawn.at(seconds), index, settings, seconds, thickness) {
                    Ok((line, passed)) => {
                        lines.list.push(line);
                        lines.cut += passed;
                    }
                    // What is drawn for another place is refused; what goes there later is gone.
                    Err(WrinkleError::Collapsed { .. } | WrinkleError::TooFar { .. }) if seconds != 0.0 => {
                        lines.outside += 1;
                    }
                    Err(error) => return Err(error),
                }
            }
        }
        Pattern::Tangential(layout) => {
            let walker = lines.start(ground, layout)?;
            tangential::lay(&walker, layout, settings, seconds, f64::from(thickness), &mut lines);
        }
        Pattern::Radial(layout, branches) => {
            let walker = lines.start(ground, layout)?;
            radial::lay(walker, layout, *branches, settings, seconds, f64::from(thickness), &mut lines);
        }
        Pattern::Auto { .. } => return Err(WrinkleError::Unmoved),
        Pattern::Ripple(layout) => {
            lines.start(ground, layout)?;
            if let Some(rays) = &prepared.rays {
                rays.lay(ground, layout, settings, seconds, f64::from(thickness), &mut lines);
            }
        }
    }
    lines.close(settings, seconds)
}

impl Lines {
    fn start<'a>(&mut self, ground: &'a Ground, layout: &Layout) -> Result<Walker<'a>, WrinkleError> {
        let (walker, upright) = start(ground, layout)?;
        if upright {
            self.warnings.push(WrinkleWarning::Upright);
        }
        Ok(walker)
    }

    /// Notes why a line ended that was to go on for `missing`, of a crease of a length; ends that rounding has cut are not worth a
    /// word.
    pub(crate) fn note(&mut self, stop: Stop, missing: f64, length: f64) {
        match stop {
            _ if missing <= SHORT * length => {}
            Stop::Arrived => {}
            Stop::Border => self.cut += 1,
            Stop::NonManifold => self.crowded += 1,
        }
    }

    fn close(mut self, settings: &Wrinkle, seconds: f64) -> Result<Self, WrinkleError> {
        let creases = settings.crease_count();
        if self.list.is_empty() && seconds == 0.0 {
            return Err(WrinkleError::NoRoom);
        }
        if self.outside > 0 {
            self.warnings.push(WrinkleWarning::Outside { outside: self.outside, creases });
        }
        if self.cut > 0 {
            self.warnings.push(WrinkleWarning::Border { ends: self.cut });
        }
        if self.crowded > 0 {
            self.warnings.push(WrinkleWarning::NonManifold { ends: self.crowded });
        }
        if self.parted > 0 {
            self.warnings.push(WrinkleWarning::Parted { ends: self.parted });
        }
        Ok(self)
    }
}

/// Someone at the centre of a pattern who looks along its first axis, and whether that stands upright on the surface and
/// another had to be taken.
fn start<'a>(ground: &'a Ground, layout: &Layout) -> Result<(Walker<'a>, bool), WrinkleError> {
    let hit = ground.nearest.nearest(layout.center).ok_or(WrinkleError::NoNormalAtCenter)?;
    let size = layout.size[0].max(layout.size[1]);
    if hit.distance > size {
        return Err(WrinkleError::CenterOff { distance: hit.distance, size });
    }
    let step = ground.terrain.step(&hit);
    ground.terrain.normal_at(&step).ok_or(WrinkleError::NoNormalAtCenter)?;
    let along = ground.terrain.walker(&hit, wide(layout.direction).to_array());
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let other = || axes.into_iter().find_map(|axis| ground.terrain.walker(&hit, axis));
    match along {
        Some(walker) => Ok((walker, false)),
        None => other().map(|walker| (walker, true)).ok_or(WrinkleError::NoNormalAtCenter),
    }
}
