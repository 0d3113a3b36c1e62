//! All creases of a wrinkle, at any moment.

use std::cell::RefCell;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use wirework_core::{Blend, Density, Keyed, Wire};
use wirework_surface::{Near, NearBuffer};

use crate::compression::Crests;
use crate::crease::{Crease, Fineness, SPANS, SPANS_A_THICKNESS};
use crate::doubts::{COARSE, apart, coarse};
use crate::ground::{Ground, wide};
use crate::height::{MIN_SPANS_VARYING, height};
use crate::pattern::{Fork, Lines, Prepared, lines, prepare};
use crate::ropes::{Hook, Ropes};
use crate::spread::Spread;
use crate::strain::{Gauges, Record};
use crate::{Motion, SurfaceView, Wrinkle, WrinkleError, WrinkleWarning};

/// Spans of all creases together: seconds of work and some 30 MB of wires. More is a thickness by mistake.
pub(crate) const MOST_SPANS: usize = 1 << 18;
/// What lies near a crease is sought a little farther than it reaches, since `R` leaves its line a little.
const NEAR: f64 = 1.06;

thread_local! {
    /// Grows to the largest surface and stays, so that creases that travel do not ask for it in every frame.
    static BUFFER: RefCell<NearBuffer> = RefCell::default();
}

/// The creases of a wrinkle on a surface, ready for any moment.
#[derive(Clone, Debug)]
pub struct Creases {
    ground: Arc<Ground>,
    prepared: Arc<Prepared>,
    settings: Arc<Wrinkle>,
    density: Density,
    /// The least it ever is, so that a keyed thickness does not move the references.
    thickness: f32,
    crests: Option<Crests>,
    gauges: Option<Gauges>,
    record: Record,
    ropes: Option<Ropes>,
    /// How far ropes hang from where they lie.
    hang: Vec<Vec<DVec3>>,
    list: Vec<Crease>,
    /// Creases of the pattern that are not there at 0 s.
    outside: usize,
    warnings: Vec<WrinkleWarning>,
}

/// Lays the creases of a wrinkle on a surface, as they are at 0 s.
///
/// # Errors
///
/// A setting is out of range, the surface has no faces, the pattern does not fit it, or following it would take for ever.
pub fn creases(surface: &SurfaceView<'_>, settings: &Wrinkle) -> Result<Creases, WrinkleError> {
    settings.check()?;
    let ground = Ground::new(surface)?;
    let least = |values: &Keyed<f32>| values.values().copied().fold(f32::INFINITY, f32::min);
    let thickness = least(&settings.thickness);
    check_fineness(thickness, settings.lengths().into_iter())?;
    let prepared = prepare(&ground, settings, thickness)?;
    let lines = lines(&ground, &prepared, settings, 0.0, thickness)?;
    // 1, 2, 4: half of the height lies at 0.29, 0.54 and 0.74 of the thickness.
    let density = Density::Fold(4.0_f32.powf(settings.stiffness));
    let mut creases = Creases {
        ground: Arc::new(ground),
        prepared: Arc::new(prepared),
        settings: Arc::new(settings.clone()),
        crests: None,
        gauges: None,
        record: Record::default(),
        ropes: None,
        hang: Vec::new(),
        density,
        thickness,
        list: Vec::new(),
        outside: 0,
        warnings: Vec::new(),
    };
    creases.list = creases.lay(&lines, false)?;
    creases.outside = lines.outside;
    creases.crests = creases.crests();
    creases.rest(surface.positions);
    creases.ropes = creases.ropes();
    creases.warnings = lines.warnings;
    let (terrain, list) = (&creases.ground.terrain, &creases.list);
    creases.warnings.extend(coarse(terrain, list, thickness));
    creases.warnings.extend(apart(terrain, list, thickness, surface));
    Ok(creases)
}

/// Refuses creases of such lengths that following them all would take for ever.
fn check_fineness(thickness: f32, lengths: impl Iterator<Item = f64>) -> Result<(), WrinkleError> {
    let spans = |length: f64| (length * SPANS_A_THICKNESS / f64::from(thickness)).ceil() as usize;
    let needed = lengths.map(|length| spans(length).clamp(*SPANS.start(), *SPANS.end())).sum();
    if needed > MOST_SPANS { Err(WrinkleError::TooFine { thickness, needed }) } else { Ok(()) }
}

impl Creases {
    /// How many creases there are: one a wire. A crease that a border cuts into parts counts as many.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// For each crease, or part of one that a border has cut, its number in the pattern, from 0; side branches count on behind the others.
    pub fn lines(&self) -> impl ExactSizeIterator<Item = usize> {
        self.list.iter().map(|crease| crease.index)
    }

    /// How the wires' displacements become one.
    pub fn blend(&self) -> Blend {
        self.settings.blend
    }

    /// What is less than was asked for, at 0 s and at the moments since.
    pub fn warnings(&self) -> &[WrinkleWarning] {
        &self.warnings
    }

    /// Whether compression of the surface raises them; until it is told they lie flat.
    pub fn is_driven(&self) -> bool {
        self.gauges.is_some()
    }

    /// Tells where the surface is at rest, which its compression is measured against. Until then that is where the creases
    /// were laid.
    pub fn rest(&mut self, rest: &[[f32; 3]]) {
        self.gauges = self.gauges().map(|gauges| gauges.against(rest));
    }

    /// How much the surface is compressed across the creases at each of their nodes, where it has moved from its rest to `now`; for
    /// [`Creases::record`]. Empty where nothing drives them.
    pub fn compression(&self, now: &[[f32; 3]]) -> Vec<f32> {
        self.gauges.as_ref().map_or_else(Vec::new, |gauges| gauges.read(now))
    }

    /// Tells the compression of the surface at equal steps, in seconds, from 0 s on; a single one holds at all times. Each is from
    /// [`Creases::compression`].
    pub fn record(&mut self, step: f64, readings: Vec<Vec<f32>>) {
        let Some(strain) = self.settings.drive else { return };
        let spread = Spread::new(&self.list, f64::from(self.thickness));
        self.record = Record::new(step, readings, &strain, &spread);
    }

    /// The greatest compression across a crease that was told of, and when, seconds, where none is large enough to raise any.
    pub fn unraised(&self) -> Option<(f32, f64)> {
        let from = self.settings.drive?.from;
        self.record.most().filter(|(most, _)| *most <= from)
    }

    /// Whether references move over the surface, so that [`Creases::at`] is to be called for each moment.
    pub fn moves(&self) -> bool {
        self.settings.moves()
    }

    /// Brings the references to a moment: where the pattern moves over the surface, and on `surface` if that has moved
    /// since the creases were laid. Each node stays at its place in its triangle, so that a crease does not slide over a surface that moves
    /// below it.
    ///
    /// # Errors
    ///
    /// The surface has other triangles than the one they were laid on, is not finite, or has no normal at a crease.
    pub fn at(&mut self, seconds: f64, surface: Option<&SurfaceView<'_>>) -> Result<(), WrinkleError> {
        if self.moves() {
            let lines = lines(&self.ground, &self.prepared, &self.settings, seconds, self.thickness)?;
            self.list = self.lay(&lines, true)?;
            let gone = lines.outside + (lines.list.len() - self.list.len());
            if gone > self.outside && !self.warnings.iter().any(|w| matches!(w, WrinkleWarning::Gone { .. }))
            {
                self.warnings.push(WrinkleWarning::Gone { seconds });
            }
        }
        let Some(surface) = surface else { return Ok(()) };
        for anchor in self.list.iter().flat_map(|crease| &crease.anchors) {
            anchor.check(surface)?;
        }
        for crease in &mut self.list {
            let moved = crease.moved(&self.ground, surface.positions);
            (crease.reference, crease.lift) = moved.ok_or(WrinkleError::NoNormal { curve: crease.index })?;
        }
        Ok(())
    }

    /// The wires at `seconds`, one a crease, in place of what `wires` held. Their references are those that [`Creases::at`]
    /// was last asked for. Wires of an earlier moment are updated without allocating.
    pub fn wires_at(&mut self, seconds: f64, wires: &mut Vec<Wire>) {
        if let Some(ropes) = &mut self.ropes {
            ropes.at(seconds, &mut self.hang);
        }
        wires.truncate(self.list.len());
        for (i, crease) in self.list.iter().enumerate() {
            match wires.get_mut(i) {
                Some(wire) if wire.reference == crease.reference => {}
                Some(wire) => *wire = self.wire(crease),
                None => wires.push(self.wire(crease)),
            }
        }
        let settings = &*self.settings;
        let intensity = f64::from(settings.intensity.at(seconds));
        let propagation = f64::from(settings.propagation.at(seconds));
        let radius = settings.thickness.at(seconds);
        let resistance = f64::from(settings.resistance);
        let mut first = 0;
        for (index, (wire, crease)) in wires.iter_mut().zip(&self.list).enumerate() {
            wire.radius = radius;
            let hang = self.hang.get(index).map_or(&[][..], Vec::as_slice);
            let raised = |node: usize| match &settings.drive {
                Some(_) => self.record.raise(seconds, first + node),
                None => 1.0,
            };
            let full = |node: usize| match &self.crests {
                Some(crests) => crests.at(f64::from(radius), crease.spacings[node]),
                None => intensity,
            };
            let rise = |node: usize| {
                let part = crease.strength * raised(node);
                full(node) * part * height(crease.fractions[node], resistance, propagation)
            };
            let points = crease.reference.points().iter().zip(&crease.lift).enumerate();
            wire.pose.clear();
            wire.pose.extend(points.map(|(node, (p, lift))| {
                let rise = rise(node);
                let hang = hang.get(node).copied().unwrap_or_default();
                [0, 1, 2].map(|a| (f64::from(p[a]) + f64::from(lift[a]) * rise + hang[a]) as f32)
            }));
            first += crease.fractions.len();
        }
    }

    /// For each crease the vertices of the surface it was laid on that it may move: those within its thickness that the surface leads to from it.
    /// Another sheet, though near, is not among them.
    pub fn near(&self) -> Vec<Near> {
        let widest = self.settings.thickness.values().copied().fold(0.0, f32::max);
        let near = |crease: &Crease| {
            BUFFER.with_borrow_mut(|buffer| {
                self.ground.terrain.near(&crease.steps, f64::from(widest) * NEAR, buffer)
            })
        };
        self.list.par_iter().map(near).collect()
    }

    /// Marks the vertices of the surface they were laid on whose triangles a crease reaches, where it is now, with the longest
    /// edge that shows the fold: a third of the thickness, if that is less than what is there. One number a vertex.
    pub fn want_edges(&self, wanted: &mut [f32]) {
        let terrain = &self.ground.terrain;
        let longest = self.thickness * COARSE as f32;
        let mut want = |vertex: u32| {
            if let Some(wanted) = wanted.get_mut(vertex as usize) {
                *wanted = wanted.min(longest);
            }
        };
        for vertex in self.near().into_iter().flat_map(|near| near.vertices) {
            // The corners of all its triangles, so that these are cut.
            terrain.around(vertex).for_each(&mut want);
        }
        // Of triangles larger than the fold no corner may be near.
        for step in self.list.iter().flat_map(|crease| &crease.steps) {
            for corner in terrain.places_of(step.triangle) {
                terrain.at_place(corner).for_each(&mut want);
            }
        }
    }

    /// Those that come to a place without a normal are left out where they have `gone` there.
    fn lay(&self, lines: &Lines, gone: bool) -> Result<Vec<Crease>, WrinkleError> {
        let reach = f64::from(self.thickness);
        let varies = self.settings.varies() && lines.list.iter().any(|line| line.range.0 != line.range.1);
        let least = if varies { MIN_SPANS_VARYING } else { *SPANS.start() };
        let coarsest =
            |length: f64| ((length * SPANS_A_THICKNESS / reach).ceil() as usize).clamp(least, *SPANS.end());
        let needed: usize = lines.list.iter().map(|line| coarsest(line.trace.length())).sum();
        if needed > MOST_SPANS {
            return Err(WrinkleError::TooFine { thickness: self.thickness, needed });
        }
        let most = (MOST_SPANS / lines.list.len().max(1)).min(*SPANS.end());
        let Density::Fold(q) = self.density else { return Ok(Vec::new()) };
        let fineness = Fineness::new(reach, f64::from(q), least, most);
        let crease = |line| match Crease::new(&self.ground, line, &fineness) {
            None if gone => None,
            crease => Some(crease.ok_or(WrinkleError::NoNormal { curve: line.index })),
        };
        lines.list.par_iter().filter_map(crease).collect()
    }

    fn wire(&self, crease: &Crease) -> Wire {
        Wire { rotation: 0.0, density: self.density.clone(), ..Wire::new(crease.reference.clone()) }
    }

    /// The heights that a compression asks for.
    fn crests(&self) -> Option<Crests> {
        let compression = f64::from(self.settings.compression?);
        let spacings = || self.list.iter().flat_map(|crease| &crease.spacings).filter(|s| **s > 0.0);
        let widest = self.settings.thickness.values().copied().fold(0.0, f32::max);
        let most = f64::from(widest) / spacings().copied().fold(f64::INFINITY, f64::min);
        let least = f64::from(self.thickness) / spacings().copied().fold(0.0, f64::max);
        let ratios = (least.max(1e-6), most.clamp(1e-6, 1e3));
        Some(Crests::new(compression, &self.density, &self.settings.blend, ratios))
    }

    /// The creases as ropes, if they are to hang.
    fn ropes(&self) -> Option<Ropes> {
        let Motion::Curtain(curtain) = &self.settings.motion else { return None };
        let line = |crease: &Crease| crease.reference.points().iter().map(|p| wide(*p)).collect();
        let lines: Vec<Vec<DVec3>> = self.list.iter().map(line).collect();
        let hook = |crease: &Crease| {
            let Fork { stem, at } = crease.fork?;
            let (point, below) = self.list.get(stem)?.place(at);
            Some(Hook { rope: stem, point, below })
        };
        let hooks: Vec<Option<Hook>> = self.list.iter().map(hook).collect();
        Some(Ropes::new(&lines, &hooks, curtain, self.settings.seed))
    }

    fn gauges(&self) -> Option<Gauges> {
        let strain = self.settings.drive?;
        let radius = strain.radius.unwrap_or(2.0 * self.thickness);
        Some(Gauges::new(&self.ground, &self.list, f64::from(radius)))
    }

    /// Whether edges across the folds are too long to show them, where the creases are at the moment that [`Creases::at`] was last
    /// asked for: [`WrinkleWarning::Coarse`]. [`Creases::warnings`] has it for 0 s.
    pub fn coarse(&self) -> Option<WrinkleWarning> {
        coarse(&self.ground.terrain, &self.list, self.thickness)
    }
}

#[cfg(test)]
#[path = "creases_tests.rs"]
mod tests;
