//! What wires that only translate do, as weights: `P′ = P + Σ wⱼ·(Wⱼ − Rⱼ)` over their control points.
//!
//! With rotation and twist 0 and scale 1, \[SF98\] §2 is `ΔP = a·F·(W(p) − R(p))`, and a curve is `Σ Nⱼ(p)·Pⱼ` of its control points:
//! `wⱼ = a·F·Nⱼ(p)`, known since binding. Of several wires, §4, that holds times their share of the blend, where it does not
//! depend on how far they have moved: of the local blend `Fᵢ^k / Σ Fᵢ^k`, of the plain sum 1, and 1 wherever one wire alone reaches. It is what
//! an engine plays as a skin whose joints translate.

use rayon::prelude::*;
use thiserror::Error;

use crate::attributes::Attribute;
use crate::bind::BindError;
use crate::blend::pinned_weight;
use crate::bound_wire::BoundWire;
use crate::cells::Cell;
use crate::influence::FADES;
use crate::runs::TileRuns;
use crate::spans::{Factor, factors};
use crate::tiles::TILE;
use crate::{Blend, Bounded, Correspondence, Locator, Wire};

/// What a point has of the motion of one control point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// Which wire, from 0.
    pub wire: u32,
    /// Which of its control points, from 0.
    pub control: u32,
    /// The factor of `Wⱼ − Rⱼ`. From 0 to 1 where amplitudes are, but for a plain sum of wires; never 0.
    pub weight: f64,
}

/// The weights of all bound points, by rising wire and control point; none where no wire reaches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// Where those of each point end.
    ends: Vec<usize>,
    list: Vec<Weight>,
}

impl Weights {
    /// How many points there are.
    pub fn point_count(&self) -> usize {
        self.ends.len()
    }

    /// The weights of one point; none of a point that is not there.
    pub fn of(&self, point: usize) -> &[Weight] {
        let start = point.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.ends.get(point).and_then(|end| self.list.get(start..*end)).unwrap_or_default()
    }
}

/// Why wires are more than weights of their control points.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WeightsError {
    /// The wires are none that could be deformed by.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// A wire turns or scales what it moves.
    #[error("wire {wire}: the {attribute} is {found}; a wire that only translates has {expected}")]
    Attribute {
        /// Which wire, from 0.
        wire: usize,
        /// Which of its locators, from 0; none where it is the wire's own.
        locator: Option<usize>,
        /// `rotation`, `scale` or `twist`.
        attribute: &'static str,
        /// Its value.
        found: f32,
        /// The value that changes nothing.
        expected: f32,
    },
    /// The point of `W` is sought by arc length, which its control points change.
    #[error(
        "wire {wire}: which point of the pose belongs to one of the curve depends on lengths, and so on the pose"
    )]
    ArcLength {
        /// Which wire, from 0.
        wire: usize,
    },
    /// The knots of a Catmull-Rom spline depend on its control points.
    #[error("wire {wire}: a Catmull-Rom spline is not linear in its control points")]
    CatmullRom {
        /// Which wire, from 0.
        wire: usize,
    },
    /// Wires reach a point together, and their shares depend on how far they move.
    #[error("wires {} and {} reach the same points, and have shares there by how far they move", .wires[0], .wires[1])]
    Blend {
        /// The first two of them, from 0.
        wires: [usize; 2],
        /// The first such point.
        point: usize,
    },
}

/// The weights by bound wires, in their present state.
pub(crate) fn weights(
    bound: &[BoundWire],
    wires: &[Wire],
    blend: &Blend,
    points: usize,
) -> Result<Weights, WeightsError> {
    let mut curves = Vec::with_capacity(wires.len());
    for (number, wire) in wires.iter().enumerate() {
        check(number, wire)?;
        let (kind, closed, count) =
            (wire.reference.kind(), wire.reference.closed(), wire.reference.points().len());
        curves.push(factors(kind, closed, count).ok_or(WeightsError::CatmullRom { wire: number })?);
    }
    let tile = |tile: usize| {
        let pull = |number: usize| {
            let runs = bound[number].runs.of_tile(tile)?;
            Some(Pull::new(number, (&bound[number], &wires[number]), runs, &curves[number]))
        };
        let pulls: Vec<Pull> = (0..wires.len()).filter_map(pull).collect();
        rows(&pulls, blend, tile * TILE, (points - tile * TILE).min(TILE))
    };
    // In their order, so that of several faults always the same one is told.
    let tiles: Vec<_> = (0..points.div_ceil(TILE)).into_par_iter().map(tile).collect();
    let mut out = Weights::default();
    for rows in tiles {
        for row in rows? {
            out.list.extend(row);
            out.ends.push(out.list.len());
        }
    }
    Ok(out)
}

/// Whether a wire does no more than translate, by the same part of its control points in every pose.
fn check(wire: usize, own: &Wire) -> Result<(), WeightsError> {
    type Get = fn(&Locator) -> Option<f32>;
    let attributes: [(&'static str, f32, Get, f32); 3] = [
        ("rotation", own.rotation, |locator| locator.rotation, 0.0),
        ("scale", own.scale, |locator| locator.scale, 1.0),
        ("twist", own.twist, |locator| locator.twist, 0.0),
    ];
    for (attribute, value, get, expected) in attributes {
        let mut carried: Vec<(Option<usize>, f32)> = own
            .locators
            .iter()
            .enumerate()
            .filter_map(|(i, locator)| Some((Some(i), get(locator)?)))
            .collect();
        if carried.is_empty() {
            carried.push((None, value));
        }
        if let Some(&(locator, found)) = carried.iter().find(|(_, value)| *value != expected) {
            return Err(WeightsError::Attribute { wire, locator, attribute, found, expected });
        }
    }
    if own.correspondence == Correspondence::ArcLength {
        return Err(WeightsError::ArcLength { wire });
    }
    Ok(())
}

/// One wire on the points of a tile, before the blend.
struct Pull {
    wire: usize,
    /// The wire's own, which a pinned blend looks at.
    amplitude: f32,
    /// `F` of each point.
    influence: Vec<f64>,
    /// What points have of control points: their indices in the tile.
    parts: Vec<(u16, Weight)>,
}

impl Pull {
    fn new(
        number: usize,
        (bound, wire): (&BoundWire, &Wire),
        runs: &TileRuns,
        factors: &[Vec<Factor>],
    ) -> Self {
        let spans = bound.spans.cubics.len();
        let fades = FADES.iter().position(|bounds| *bounds == Bounded::Amplitude).map(|k| &runs.fades[k]);
        let (mut influence, mut parts) = (vec![0.0; TILE], Vec::new());
        for run in &runs.list {
            let cell = bound.cells.list[run.cell as usize];
            let amplitude = cell.attribute(wire, Attribute::Amplitude, spans);
            let t0 = if let Cell::Stretch { t0, .. } = cell { t0 } else { 0.0 };
            for i in run.start as usize..run.end as usize {
                let (index, t) = (runs.index[i], f64::from(runs.t[i]));
                let share = runs.weight.get(i).map_or(1.0, |share| f64::from(*share));
                let f = share * f64::from(runs.influence[i]);
                influence[usize::from(index)] += f;
                let fade = fades.and_then(|fade| fade.get(i)).map_or(1.0, |fade| f64::from(*fade));
                let factor = f * fade * polynomial(&amplitude, t - t0);
                let (span, place) = cell.place(t, spans);
                for (control, powers) in &factors[span] {
                    let weight = factor * polynomial(powers, place);
                    let control = *control as u32;
                    parts.push((index, Weight { wire: number as u32, control, weight }));
                }
            }
        }
        Self { wire: number, amplitude: wire.amplitude, influence, parts }
    }
}

fn polynomial([a, b, c, d]: &[f64; 4], t: f64) -> f64 {
    a + t * (b + t * (c + t * d))
}

/// The weights of the `count` points of a tile, of which `first` is the first.
fn rows(pulls: &[Pull], blend: &Blend, first: usize, count: usize) -> Result<Vec<Vec<Weight>>, WeightsError> {
    let shares = |point| {
        shares(pulls, blend, point).map_err(|wires| WeightsError::Blend { wires, point: first + point })
    };
    let shares = (0..count).map(shares).collect::<Result<Vec<_>, _>>()?;
    let mut out: Vec<Vec<Weight>> = vec![Vec::new(); count];
    for (k, pull) in pulls.iter().enumerate() {
        for (index, part) in &pull.parts {
            let point = usize::from(*index);
            let share = shares[point].iter().find(|(own, _)| *own == k).map_or(0.0, |(_, share)| *share);
            out[point].push(Weight { weight: part.weight * share, ..*part });
        }
    }
    for row in &mut out {
        // A point with several feet has several parts of a control point.
        row.sort_by_key(|part| (part.wire, part.control));
        row.dedup_by(|next, kept| {
            let same = (next.wire, next.control) == (kept.wire, kept.control);
            if same {
                kept.weight += next.weight;
            }
            same
        });
        row.retain(|part| part.weight != 0.0);
    }
    Ok(out)
}

/// The wires that reach a point, and their shares there.
///
/// # Errors
///
/// Two wires whose shares depend on how far they move.
fn shares(pulls: &[Pull], blend: &Blend, point: usize) -> Result<Vec<(usize, f64)>, [usize; 2]> {
    let reach: Vec<usize> = (0..pulls.len()).filter(|k| pulls[*k].influence[point] > 0.0).collect();
    match reach[..] {
        [alone] => return Ok(vec![(alone, 1.0)]),
        [a, b, ..] if blend.localize != 1.0 && blend.crossing != 1.0 => {
            return Err([pulls[a].wire, pulls[b].wire]);
        }
        _ => {}
    }
    let plain = 1.0 - f64::from(blend.localize);
    let local = local_shares(pulls, &reach, blend, point);
    Ok(reach.into_iter().zip(local).map(|(k, local)| (k, plain + local)).collect())
}

/// The shares of wires that reach a point in the local part of the blend, times how much that counts.
fn local_shares(pulls: &[Pull], reach: &[usize], blend: &Blend, point: usize) -> Vec<f64> {
    let f = |k: &usize| pulls[*k].influence[point];
    let weights: Vec<f64> = if blend.pinned {
        reach.iter().map(|k| pinned_weight(pulls[*k].amplitude, f(k))).collect()
    } else {
        let logs: Vec<f64> = reach.iter().map(|k| f64::from(blend.locality) * f(k).ln()).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        logs.iter().map(|log| (log - most).exp()).collect()
    };
    let sum: f64 = weights.iter().sum();
    let part = |weight: &f64| if sum > 0.0 { weight / sum * f64::from(blend.localize) } else { 0.0 };
    weights.iter().map(part).collect()
}
