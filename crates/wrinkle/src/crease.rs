//! Creases: wires whose crest stands over a line on the surface.
//!
//! `R` passes through points of the surface at equal steps of arc length, so that its parameter *is* the fraction of
//! arc length; `W = R + intensity · height · N`, with `N` the outward unit normals. Both are quadratic B-splines of
//! the same nodes ([`fit`](crate::fit)). The wire only translates (`rotation` 0): bending the object with the
//! slope of the crest would lean the fold over.
//!
//! # How fine
//!
//! A point of the surface at distance `e` from `R` rises by `F = (1 − (e/r)^q)²` instead of 1, a loss of about
//! `2 (e/r)^q`: for the loss to stay under 1 %, a sharp crease (`q = 1`) must keep to 0.005 of its thickness, the quartic
//! (`q = 2`) to 0.07. `N` between its nodes may be off by another 1 %. Together they keep the crest within 3 %. A crease
//! starts with a span a third of the thickness, which on a surface of radius `ρ` leaves `e` about
//! `(r/3)⁴/(400 ρ³)`, and is refined where the surface (an edge, a facet) asks for more.

use wirework_core::{Blend, Curve, CurveKind, Density, Keyed, Wire};
use wirework_surface::smooth_normals;

use crate::drawn::{Anchor, Footing, Ground, Trace, wide};
use crate::fit::{interpolate, nodes};
use crate::height::{MIN_SPANS_VARYING, height};
use crate::random::{Jitter, unit};
use crate::{Pattern, SurfaceView, Wrinkle, WrinkleError};

/// The part of the height that may be lost because `R` leaves the surface.
const LOSS: f64 = 0.01;
/// How far `R` may leave the surface however little it costs, in parts of the thickness: what a viewer of the wires
/// would see.
const OFF_SURFACE: f64 = 0.05;
/// How far `N` may be from length 1 between its nodes.
const OFF_UNIT: f64 = 0.01;
/// Spans in the length of a thickness at the coarsest, and how often they are halved at most: a hard edge across
/// a crease never gets within [`LOSS`], and a span of 1/24 of the thickness cuts it by 1/70.
const SPANS_A_THICKNESS: f64 = 3.0;
const HALVINGS: usize = 3;
/// Spans of a crease: enough to follow a bend, and not so many that a tiny thickness takes for ever.
const SPANS: std::ops::RangeInclusive<usize> = 8..=1024;

/// Spans of all creases together: seconds of work and some 30 MB of wires. More is a thickness by mistake.
pub(crate) const MOST_SPANS: usize = 1 << 18;

/// The creases of a wrinkle on a surface, ready for any moment.
#[derive(Clone, Debug)]
pub struct Creases {
    list: Vec<Crease>,
    density: Density,
    thickness: Keyed<f32>,
    intensity: Keyed<f32>,
    propagation: Keyed<f32>,
    resistance: f64,
    blend: Blend,
}

#[derive(Clone, Debug)]
struct Crease {
    reference: Curve,
    /// What a height of 1 adds to each control point.
    lift: Vec<[f32; 3]>,
    /// Where on the surface each control point's node lies.
    anchors: Vec<Anchor>,
    /// Distance of each control point's node from the origin, as a fraction of the crease.
    fractions: Vec<f64>,
    /// Its own part of the height.
    strength: f64,
}

/// Lays the creases of a wrinkle on a surface; one a curve of the pattern, in their order.
pub fn creases(surface: &SurfaceView<'_>, settings: &Wrinkle) -> Result<Creases, WrinkleError> {
    settings.check()?;
    let ground = Ground::new(surface)?;
    let Pattern::Drawn(curves) = &settings.pattern;
    // The finest it will ever be, so that a keyed thickness does not move the references.
    let thickness = settings.thickness.values().copied().fold(f32::INFINITY, f32::min);
    // 1, 2, 4: half of the height lies at 0.29, 0.54 and 0.74 of the thickness.
    let q = 4.0_f32.powf(settings.stiffness);
    let reach = f64::from(thickness);
    let least = if settings.varies() { MIN_SPANS_VARYING } else { *SPANS.start() };
    let coarsest =
        |length: f64| ((length * SPANS_A_THICKNESS / reach).ceil() as usize).clamp(least, *SPANS.end());
    let needed: usize = curves.iter().map(|curve| coarsest(f64::from(curve.length()))).sum();
    if needed > MOST_SPANS {
        return Err(WrinkleError::TooFine { thickness, needed });
    }
    let fineness = Fineness {
        span: reach / SPANS_A_THICKNESS,
        off: reach * (LOSS / 2.0).powf(1.0 / f64::from(q)).min(OFF_SURFACE),
        least,
        refined: (MOST_SPANS / curves.len().max(1)).min(*SPANS.end()),
    };
    let lay = |(index, curve)| {
        let trace = Trace::drop(&ground, curve, index, settings, thickness)?;
        let strength =
            1.0 - 0.5 * f64::from(settings.randomness) * unit(settings.seed, index, Jitter::Height);
        Crease::new(&ground, &trace, curve.closed(), &fineness, strength)
            .ok_or(WrinkleError::NoNormal { curve: index })
    };
    Ok(Creases {
        list: curves.iter().enumerate().map(lay).collect::<Result<_, _>>()?,
        density: Density::Fold(q),
        thickness: settings.thickness.clone(),
        intensity: settings.intensity.clone(),
        propagation: settings.propagation.clone(),
        resistance: f64::from(settings.resistance),
        blend: settings.blend,
    })
}

impl Creases {
    /// How many creases there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How the wires' displacements become one.
    pub fn blend(&self) -> Blend {
        self.blend
    }

    /// The same creases on the same material of a surface that has moved: each node stays at its place in its triangle,
    /// so that a crease neither slides over the surface nor changes its number of control points.
    ///
    /// # Errors
    ///
    /// The surface has other triangles than the one they were laid on, is not finite, or has no normal at a crease.
    pub fn moved(&self, surface: &SurfaceView<'_>) -> Result<Self, WrinkleError> {
        for anchor in self.list.iter().flat_map(|crease| &crease.anchors) {
            anchor.check(surface)?;
        }
        let normals = smooth_normals(surface.positions, surface.triangles);
        let moved = |(curve, crease): (usize, &Crease)| {
            crease.moved(surface, &normals).ok_or(WrinkleError::NoNormal { curve })
        };
        Ok(Self { list: self.list.iter().enumerate().map(moved).collect::<Result<_, _>>()?, ..self.clone() })
    }

    /// The wires at `seconds`, one a crease, in place of what `wires` held. Their references are the same at all times,
    /// bit for bit. Wires of an earlier moment are updated without allocating.
    pub fn wires_at(&self, seconds: f64, wires: &mut Vec<Wire>) {
        wires.truncate(self.list.len());
        for (i, crease) in self.list.iter().enumerate() {
            match wires.get_mut(i) {
                Some(wire) if wire.reference == crease.reference => {}
                Some(wire) => *wire = self.wire(crease),
                None => wires.push(self.wire(crease)),
            }
        }
        let intensity = f64::from(self.intensity.at(seconds));
        let propagation = f64::from(self.propagation.at(seconds));
        let radius = self.thickness.at(seconds);
        for (wire, crease) in wires.iter_mut().zip(&self.list) {
            wire.radius = radius;
            let rise = |x: f64| intensity * crease.strength * height(x, self.resistance, propagation);
            let points = crease.reference.points().iter().zip(&crease.lift).zip(&crease.fractions);
            wire.pose.clear();
            wire.pose.extend(points.map(|((p, lift), &x)| {
                let rise = rise(x);
                [0, 1, 2].map(|a| (f64::from(p[a]) + f64::from(lift[a]) * rise) as f32)
            }));
        }
    }

    fn wire(&self, crease: &Crease) -> Wire {
        Wire { rotation: 0.0, density: self.density.clone(), ..Wire::new(crease.reference.clone()) }
    }
}

/// How fine a crease is.
struct Fineness {
    /// Length of a span at the coarsest.
    span: f64,
    /// How far `R` may be off the surface.
    off: f64,
    /// Spans at least.
    least: usize,
    /// Spans up to which a crease may be refined: its part of [`MOST_SPANS`].
    refined: usize,
}

impl Crease {
    /// `None` where the surface has no normal.
    fn new(ground: &Ground, trace: &Trace, closed: bool, fineness: &Fineness, strength: f64) -> Option<Self> {
        let coarsest = (trace.length() / fineness.span).ceil() as usize;
        let mut spans = coarsest.clamp(fineness.least, *SPANS.end());
        for _ in 0..HALVINGS {
            let crease = Self::of_spans(ground, trace, closed, spans, strength)?;
            if spans >= fineness.refined || crease.follows(ground, fineness.off, spans) {
                return Some(crease);
            }
            spans = (spans * 2).min(fineness.refined);
        }
        Self::of_spans(ground, trace, closed, spans, strength)
    }

    fn of_spans(ground: &Ground, trace: &Trace, closed: bool, spans: usize, strength: f64) -> Option<Self> {
        let nodes = nodes(spans, closed);
        let footings: Option<Vec<Footing>> = nodes.iter().map(|&u| trace.footing(ground, u)).collect();
        let footings = footings?;
        let (reference, lift) = through(&footings, closed)?;
        let anchors = footings.iter().map(|footing| footing.anchor).collect();
        // A closed crease grows both ways from its first end.
        let fraction = |u: f64| if closed { 2.0 * u.min(1.0 - u) } else { u };
        let fractions = nodes.into_iter().map(fraction).collect();
        Some(Self { reference, lift, anchors, fractions, strength })
    }

    fn moved(&self, surface: &SurfaceView<'_>, normals: &[[f32; 3]]) -> Option<Self> {
        let footings: Option<Vec<Footing>> =
            self.anchors.iter().map(|anchor| anchor.footing(surface, normals)).collect();
        let (reference, lift) = through(&footings?, self.reference.closed())?;
        Some(Self { reference, lift, ..self.clone() })
    }

    /// Whether it keeps to the surface and to its height between the nodes: where spans meet.
    fn follows(&self, ground: &Ground, allowed: f64, spans: usize) -> bool {
        let Ok(lift) = self.reference.posed(self.lift.clone()) else { return true };
        (0..=spans).all(|i| {
            let u = i as f32 / spans as f32;
            let off = ground.distance(wide(self.reference.point(u)));
            off <= allowed && (wide(lift.point(u)).length() - 1.0).abs() <= OFF_UNIT
        })
    }
}

/// The reference curve through points of the surface, and what a height of 1 adds to each of its control points.
fn through(footings: &[Footing], closed: bool) -> Option<(Curve, Vec<[f32; 3]>)> {
    let points = |value: fn(&Footing) -> glam::DVec3| -> Vec<[f32; 3]> {
        let values: Vec<glam::DVec3> = footings.iter().map(value).collect();
        interpolate(&values, closed).iter().map(|p| p.as_vec3().to_array()).collect()
    };
    let reference = Curve::new(CurveKind::BSpline { degree: 2 }, closed, points(|f| f.position)).ok()?;
    Some((reference, points(|f| f.normal)))
}

#[cfg(test)]
#[path = "crease_tests.rs"]
mod tests;
