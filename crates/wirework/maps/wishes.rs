//! How fine a copy maps need: as fine as its folds are, and no finer than texels.

use wirework_preset::{Action, Effect};
use wirework_wrinkle::{SurfaceView, creases};

use crate::evaluate::bounds_frame;
use crate::fineness::{Span, want};
use crate::maps::ground::{Ground, triangles};
use crate::maps::job::MapJob;
use crate::unfit::unfit;
use crate::{EvaluateError, JobError, Subject};

/// Edges in a thickness, or a radius: with 24 the normal between two vertices is off by less than a step of 8 bits at slopes of 45 degrees;
/// with 12 by three.
const EDGES: f32 = 24.0;
/// What creases themselves ask for: this many edges in a thickness.
const EDGES_OF_CREASES: f32 = 3.0;
/// Texels along an edge, at least: a map shows no more between its vertices than smooth normals do.
const TEXELS: f32 = 2.0;
/// Places along a wire, at least, at which its distance is looked at, and so many more for each of its control points.
const PLACES: usize = 32;
const PLACES_A_POINT: usize = 8;
/// Moments at which moving references are looked at.
const MOMENTS: u32 = 4;

/// For each point the longest edge that maps bear there, metres; infinite where nothing folds or no map is made.
pub(crate) fn wishes(
    job: &MapJob<'_>,
    subject: &Subject,
    effects: &[Effect],
    span: Span,
    ground: &Ground,
) -> Result<Vec<f32>, JobError> {
    let mut folds = vec![f32::INFINITY; subject.points.len()];
    let mut least = folds.clone();
    let frame = bounds_frame(subject.bounds());
    for (index, effect) in effects.iter().enumerate() {
        match effect.placed(&frame).action {
            Action::Wrinkle(wrinkle) => {
                let fail =
                    |error| unfit(&subject.origin, effects)(EvaluateError::Wrinkle { effect: index, error });
                let surface = SurfaceView { positions: &subject.points, triangles: &subject.triangles };
                let mut creases = creases(&surface, &wrinkle).map_err(fail)?;
                want(&mut creases, &wrinkle, span, &mut least).map_err(fail)?;
            }
            Action::Deform(deform) if deform.lattice.is_none() => {
                let moments = job
                    .at
                    .into_iter()
                    .chain((0..=MOMENTS).map(|k| job.preset.duration * f64::from(k) / f64::from(MOMENTS)));
                for seconds in moments {
                    for wire in &deform.wires {
                        near_wire(&wire.at(seconds), subject, &mut folds);
                    }
                }
            }
            _ => {}
        }
    }
    for (fold, least) in folds.iter_mut().zip(&least) {
        *fold = fold.min(*least * EDGES_OF_CREASES / EDGES);
    }
    let texels = texels(job, subject, ground);
    let wish = |((fold, least), texel): ((f32, f32), f32)| {
        if fold.is_finite() && texel.is_finite() {
            fold.max(TEXELS * texel).min(least)
        } else {
            f32::INFINITY
        }
    };
    Ok(folds.into_iter().zip(least).zip(texels).map(wish).collect())
}

/// Marks the corners of triangles that a wire may reach with a part of its radius.
fn near_wire(wire: &wirework_core::Wire, subject: &Subject, folds: &mut [f32]) {
    let own = wire.locators.iter().filter_map(|locator| locator.radius);
    let (small, large) = own.fold((wire.radius, wire.radius), |(a, b), r| (a.min(r), b.max(r)));
    let count = PLACES + PLACES_A_POINT * wire.reference.points().len();
    let places: Vec<[f32; 3]> = (0..=count).map(|k| wire.reference.point(k as f32 / count as f32)).collect();
    let gap = places.windows(2).map(|pair| distance(pair[0], pair[1])).fold(0.0, f32::max) / 2.0;
    let bound = |k: usize| {
        places.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])))
    };
    let bounds = [0, 1, 2].map(bound);
    for triangle in &subject.triangles {
        let [a, b, c] = triangle.map(|v| subject.points[v as usize]);
        let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        let reach = large + gap + [a, b, c].map(|p| distance(p, middle)).into_iter().fold(0.0, f32::max);
        let boxed = (0..3).all(|k| (bounds[k].0 - reach..=bounds[k].1 + reach).contains(&middle[k]));
        if boxed && places.iter().any(|place| distance(*place, middle) <= reach) {
            for &vertex in triangle {
                let fold = &mut folds[vertex as usize];
                *fold = fold.min(small / EDGES);
            }
        }
    }
}

/// For each point the length of a texel's side there, the least of the triangles round it; infinite where no map is made.
fn texels(job: &MapJob<'_>, subject: &Subject, ground: &Ground) -> Vec<f32> {
    let mut out = vec![f32::INFINITY; subject.points.len()];
    let rest = &ground.scene.rest;
    let [width, height] = job.settings.size.map(f64::from);
    for mapped in &ground.parts {
        let part = &rest.parts[mapped.index];
        let first = rest.blocks[part.block].first;
        for triangle in triangles(rest, part) {
            let uvs = triangle.map(|v| mapped.uvs[v as usize - first].map(f64::from));
            let [p, q, r] = triangle.map(|v| glam::DVec3::from(rest.positions[v as usize].map(f64::from)));
            let [a, b, c] = uvs;
            let texels =
                ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() * width * height;
            let texel = ((q - p).cross(r - p).length() / texels).sqrt() as f32;
            if !(texel > 0.0 && texel.is_finite()) {
                continue;
            }
            for vertex in triangle {
                if let Some(slot) =
                    ground.scene.point_of.get(*vertex as usize).and_then(|&p| out.get_mut(p as usize))
                {
                    *slot = slot.min(texel);
                }
            }
        }
    }
    out
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}
