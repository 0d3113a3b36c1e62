//! Seams as wires: one along each edge, both to the common seam.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use wirework_core::{Blend, Locator, Wire};
use wirework_surface::Near;

use crate::corner::{Corner, corners};
use crate::error::{EdgeFault, StitchError, StitchWarning};
use crate::joint::Joints;
use crate::pairing::{Track, pair};
use crate::path::Path;
use crate::settings::{Continuity, SeamSide, Stitch};
use crate::side::Side;
use crate::surfaces::{Pieces, Surfaces};
use crate::tangent::{corner_normals, flatten, twists};
use crate::target::{Moment, Sides, Target, hold, meet, seams_alone, tear};
use crate::turn::rotations;

/// Seams laid on surfaces. Which vertices their edges have is settled once; where these are may change.
#[derive(Clone, Debug)]
pub struct Seams {
    pub(crate) settings: Stitch,
    pub(crate) sides: Vec<Sides>,
    corners: Vec<Corner>,
    near: Vec<Near>,
    pins: Vec<Pin>,
    joints: Joints,
    warnings: Vec<StitchWarning>,
}

/// A vertex of an edge that a closed seam takes just where it is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// The point.
    pub point: u32,
    /// The wire along its edge.
    pub wire: u32,
    /// Where it comes.
    pub goal: [f32; 3],
}

/// Finds the edges of seams and what of them belongs together.
///
/// # Errors
///
/// A setting out of range; an edge that is not there or has no length; seams that take the same stretch of a border.
pub fn seams(surfaces: &Surfaces<'_>, settings: &Stitch) -> Result<Seams, StitchError> {
    settings.check()?;
    let mut pieces = Pieces::new(surfaces);
    let paths = paths(settings, &mut pieces)?;
    check_crossings(&paths)?;
    let mut tracks = Vec::with_capacity(paths.len());
    for (index, (seam, [a, b])) in settings.seams.iter().zip(paths).enumerate() {
        if a.closed != b.closed {
            return Err(StitchError::LoopAndRun { seam: index });
        }
        tracks.push(pair(a, b, seam, surfaces));
    }
    lay(settings, tracks, pieces)
}

/// Lays wires along edges that have a common parameter.
pub(crate) fn lay(
    settings: &Stitch,
    tracks: Vec<[Track; 2]>,
    mut pieces: Pieces<'_>,
) -> Result<Seams, StitchError> {
    let surfaces = pieces.surfaces;
    let (mut sides, mut near) = (Vec::new(), Vec::new());
    for (index, (seam, tracks)) in settings.seams.iter().zip(tracks).enumerate() {
        let radius = seam.radius.values().copied().fold(0.0, f32::max);
        let mut side = |side: SeamSide, own: &Track, other: &Track| {
            let fail = |fault| StitchError::Edge { seam: index, side, fault };
            let number = seam.edge(side).piece;
            let piece = pieces.get(number).ok_or_else(|| fail(EdgeFault::NoPiece(number)))?;
            let beside = (seam.a.piece == seam.b.piece).then_some(&other.path.vertices[..]);
            near.push(piece.near(&own.path.vertices, beside, radius));
            let fans = piece.fans(&own.path.vertices);
            Side::new(own.clone(), other, fans, surfaces.positions).map_err(|_| fail(EdgeFault::NoLength))
        };
        let [a, b] = &tracks;
        sides.push([side(SeamSide::A, a, b)?, side(SeamSide::B, b, a)?]);
    }
    let tracks: Vec<[&Track; 2]> = sides.iter().map(|[a, b]| [&a.track, &b.track]).collect();
    let corners = corners(&tracks);
    let joints = Joints::of(settings, &sides);
    let warnings = junctions(settings, &sides);
    Ok(Seams { settings: settings.clone(), sides, corners, near, pins: Vec::new(), joints, warnings })
}

fn paths(settings: &Stitch, pieces: &mut Pieces<'_>) -> Result<Vec<[Path; 2]>, StitchError> {
    let surfaces = pieces.surfaces;
    let mut path = |seam: usize, side: SeamSide| {
        let edge = settings.seams[seam].edge(side);
        let fail = |fault| StitchError::Edge { seam, side, fault };
        let piece = pieces.get(edge.piece).ok_or_else(|| fail(EdgeFault::NoPiece(edge.piece)))?;
        Path::of(edge, piece, surfaces).map_err(fail)
    };
    (0..settings.seams.len()).map(|seam| Ok([path(seam, SeamSide::A)?, path(seam, SeamSide::B)?])).collect()
}

/// A border can be sewn once only; edges may share their ends.
fn check_crossings(paths: &[[Path; 2]]) -> Result<(), StitchError> {
    let mut taken: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
    let all =
        || paths.iter().enumerate().flat_map(|(seam, sides)| [(seam, 0, &sides[0]), (seam, 1, &sides[1])]);
    let clash = |seam: usize, other: usize| {
        if seam == other {
            StitchError::Itself { seam }
        } else {
            StitchError::Crossing { seam: seam.max(other), other: seam.min(other) }
        }
    };
    for (seam, side, path) in all() {
        for &vertex in path.inner() {
            match taken.insert(vertex, (seam, side)) {
                // A border may touch itself.
                Some(before) if before != (seam, side) => return Err(clash(seam, before.0)),
                _ => {}
            }
        }
    }
    for (seam, side, path) in all() {
        for end in path.ends().into_iter().flatten() {
            match taken.get(&end) {
                Some(&(other, of)) if (other, of) != (seam, side) => return Err(clash(seam, other)),
                _ => {}
            }
        }
    }
    // Two runs of one segment each have no inner vertices.
    let ends: Vec<_> = all().filter(|(.., path)| path.vertices.len() == 2).collect();
    for (i, (seam, _, path)) in ends.iter().enumerate() {
        let same =
            |other: &Path| other.vertices == path.vertices || other.vertices.iter().rev().eq(&path.vertices);
        if let Some((other, ..)) = ends[..i].iter().find(|(.., other)| same(other)) {
            return Err(clash(*seam, *other));
        }
    }
    Ok(())
}

/// Seams on which vertices of one edge have none on the other, and how wide cracks are there at 0 s.
fn junctions(settings: &Stitch, sides: &[Sides]) -> Vec<StitchWarning> {
    let moments: Vec<Moment> = settings.seams.iter().map(|seam| Moment::of(seam, 0.0)).collect();
    let targets = seams_alone(sides, &moments);
    let mut warnings = Vec::new();
    for (seam, (sides, targets)) in sides.iter().zip(&targets).enumerate() {
        let (mut vertices, mut widest) = (0, 0.0_f64);
        for own in [0, 1].into_iter().filter(|_| !settings.seams[seam].weld) {
            let (other, track) = (&targets[1 - own].seam, &sides[1 - own].track);
            let lone = sides[own].other.iter().zip(&targets[own].seam);
            for (place, p) in lone.filter(|(place, _)| track.vertex(**place).is_none()) {
                let next = other[(place.segment + 1) % other.len()];
                let width = other[place.segment].lerp(next, place.x).distance(*p);
                (vertices, widest) = (vertices + 1, widest.max(width));
            }
        }
        if vertices > 0 {
            warnings.push(StitchWarning::Junctions { seam, vertices, widest: widest as f32 });
        }
    }
    warnings
}

impl Seams {
    /// What each wire may move, two wires a seam: what the surface leads to from its edge.
    pub fn near(&self) -> &[Near] {
        &self.near
    }

    /// How the wires become one displacement: a point on a seam is moved by that alone.
    pub fn blend(&self) -> Blend {
        Blend { localize: 1.0, pinned: true, ..Blend::default() }
    }

    /// What is less than was asked for.
    pub fn warnings(&self) -> &[StitchWarning] {
        &self.warnings
    }

    /// Takes the edges to where the points are now, as many as there were.
    pub fn follow(&mut self, positions: &[[f32; 3]]) {
        self.sides.iter_mut().flatten().for_each(|side| side.follow(positions));
    }

    /// The wires at a moment, two for each seam in their order: along `a`, then along `b`. Old ones in the list are reused.
    pub fn wires_at(&mut self, seconds: f64, wires: &mut Vec<Wire>) {
        let moments: Vec<Moment> = self.settings.seams.iter().map(|seam| Moment::of(seam, seconds)).collect();
        let mut targets = seams_alone(&self.sides, &moments);
        meet(&self.sides, &moments, &self.corners, &mut targets);
        let normals = corner_normals(&self.sides, &self.settings.seams, &moments, &self.corners, &targets);
        for ((sides, normals), targets) in self.sides.iter().zip(&normals).zip(&mut targets) {
            flatten(sides, normals, targets);
        }
        self.joints.close(&moments, &targets);
        tear(&self.sides, &mut targets);
        hold(&self.sides, &moments, &self.corners, &mut targets);
        let laid = self.sides.iter().flatten().skip(wires.len());
        wires.extend(laid.map(|side| Wire::new(side.reference.clone())));
        wires.truncate(2 * self.sides.len());
        wires.par_iter_mut().enumerate().for_each(|(number, wire)| {
            let (index, own) = (number / 2, number % 2);
            self.pose((index, own), seconds, &targets[index][own], &normals[index], wire);
        });
        self.pins.clear();
        for ((number, wire), side) in (0..).zip(&*wires).zip(self.sides.iter().flatten()) {
            if wire.amplitude == 1.0 {
                let points = side.track.path.vertices.iter().zip(&wire.pose);
                self.pins.extend(points.map(|(&point, &goal)| Pin { point, wire: number, goal }));
            }
        }
    }

    /// Brings one wire to a moment.
    fn pose(
        &self,
        (index, own): (usize, usize),
        seconds: f64,
        target: &Target,
        normals: &[Option<DVec3>; 2],
        wire: &mut Wire,
    ) {
        let (seam, side) = (&self.settings.seams[index], &self.sides[index][own]);
        if wire.reference != side.reference {
            wire.reference = side.reference.clone();
        }
        wire.pose.clear();
        wire.pose.extend(target.goal.iter().map(|p| p.as_vec3().to_array()));
        wire.density = seam.density.clone();
        wire.radius = seam.radius.at(seconds);
        wire.scale = seam.scale.at(seconds);
        wire.amplitude = seam.closure.at(seconds);
        let Ok(pose) = wire.reference.posed(wire.pose.clone()) else { return };
        let (smooth, torn) = (seam.continuity == Continuity::Tangent, !seam.tears.is_empty());
        let held = if torn || !smooth { rotations(side, &pose, f64::from(wire.radius)) } else { None };
        if held.is_some() || torn || !wire.locators.is_empty() {
            let values = held.unwrap_or_else(|| vec![1.0; side.own.len()]);
            along(wire, side, values, |locator, value| locator.rotation = Some(value));
        }
        if smooth {
            let bias = f64::from(seam.bias.at(seconds));
            let values = twists(&self.sides[index], own, bias, normals, target, &pose);
            along(wire, side, values, |locator, value| locator.twist = Some(value));
        }
    }

    /// Where vertices of edges come whose seams are closed, at the moment of the last [`Seams::wires_at`]. What the wires give there is
    /// that up to rounding; a seam is shut only where both sides have the same bits. A vertex at which several seams meet stands
    /// here for each of them, with the same goal.
    pub fn pins(&self) -> &[Pin] {
        &self.pins
    }

    /// Points that seams to be welded make one, in groups, and how far they have come: 0 apart, 1 one point. At the moment of the last
    /// [`Seams::wires_at`]; for whoever makes normals continuous.
    pub fn joints(&self) -> impl Iterator<Item = (&[u32], f32)> {
        self.joints.groups()
    }

    /// How many seams there are.
    pub fn count(&self) -> usize {
        self.sides.len()
    }
}

/// Sets an attribute at each vertex along a wire.
fn along(wire: &mut Wire, side: &Side, values: Vec<f64>, set: impl Fn(&mut Locator, f32)) {
    if wire.locators.len() != values.len() {
        wire.locators = side.parameters().map(|u| Locator { u: u as f32, ..Locator::default() }).collect();
    }
    wire.locators.iter_mut().zip(values).for_each(|(locator, value)| set(locator, value as f32));
}
