//! \[SF98\] §5.2: "we reparametrize the matching edges to a common domain".
//!
//! The common parameter runs from 0 to 1 along both edges. That of `a` is its own; that of `b` is turned, and on a loop shifted, so
//! that points that belong together are near each other.

use glam::DVec3;

use crate::path::Path;
use crate::settings::{Pairing, Reversed};
use crate::surfaces::Surfaces;

/// Samples that edges are compared by: enough for the turns that borders of garments take.
const SAMPLES: usize = 256;
/// How much a nearest-point pairing keeps of the pairing by length, so that it goes on everywhere: without it stretches of one edge
/// would belong to single points of the other.
const SLOPE: f64 = 0.02;
/// A vertex so near to one of the other edge, in parts of a segment there, is taken to belong to it: more than rounding of positions in
/// f32 makes of equal fractions, and far less than shows.
const SNAP: f64 = 1e-3;

/// A path with a parameter for each vertex.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Track {
    pub(crate) path: Path,
    /// Rising, from 0; of a run to 1.
    pub(crate) t: Vec<f64>,
}

/// A place on a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) segment: usize,
    /// 0 to 1; just 0 or 1 at a vertex.
    pub(crate) x: f64,
}

/// Two paths with a common parameter.
pub(crate) fn pair(
    a: Path,
    b: Path,
    pairing: Pairing,
    reversed: Reversed,
    surfaces: &Surfaces<'_>,
) -> [Track; 2] {
    let by_length = |path: &Path| fractions(&path.lengths(surfaces), path.closed);
    let own = |path: &Path| match pairing {
        Pairing::ArcLength | Pairing::Closest => by_length(path),
        Pairing::Parameter => fractions(&vec![1.0; path.segments()], path.closed),
    };
    let a = Track { t: own(&a), path: a };
    let b = Track { t: own(&b), path: b };
    let candidates = match reversed {
        Reversed::Given(reversed) => vec![turned(b, reversed)],
        Reversed::Auto => vec![turned(b.clone(), false), turned(b, true)],
    };
    let shape = a.samples(surfaces);
    let fit = |track: Track| started(&shape, track, surfaces);
    let fitted: Vec<(f64, Track)> = candidates.into_iter().map(fit).collect();
    // Of equal ones the first: as the edges run.
    let best = fitted.into_iter().reduce(|best, next| if next.0 < best.0 { next } else { best });
    let b = best.map_or_else(|| a.clone(), |(_, track)| track);
    let mut b = match pairing {
        Pairing::Closest => Track { t: a.closest(&b, surfaces), ..b },
        _ => b,
    };
    // What belongs together is to have the same parameter, not nearly so.
    for t in &mut b.t {
        if let Some(vertex) = a.vertex(a.place(*t)) {
            *t = a.t[vertex];
        }
    }
    [a, b]
}

/// Fractions of the whole where segments begin and, of a run, where the last ends.
fn fractions(lengths: &[f64], closed: bool) -> Vec<f64> {
    let total: f64 = lengths.iter().sum();
    let mut sum = 0.0;
    let mut out = vec![0.0];
    for length in lengths {
        sum += length;
        out.push(sum / total);
    }
    if closed {
        out.pop();
    } else if let Some(last) = out.last_mut() {
        *last = 1.0;
    }
    out
}

/// The track the other way round; a loop begins with the same vertex.
fn turned(mut track: Track, reversed: bool) -> Track {
    if !reversed {
        return track;
    }
    track.path.vertices.reverse();
    track.t.reverse();
    track.t.iter_mut().for_each(|t| *t = 1.0 - *t);
    if track.path.closed {
        track.path.vertices.rotate_right(1);
        track.t.rotate_right(1);
        track.t[0] = 0.0;
    }
    track
}

/// The track of a loop from the vertex on at which it fits a shape best, and how well: the mean square of the distances.
fn started(shape: &[DVec3], track: Track, surfaces: &Surfaces<'_>) -> (f64, Track) {
    let fit = |samples: &[DVec3], shift: f64| -> f64 {
        let at = |i: usize| lookup(samples, (i as f64 / SAMPLES as f64 + shift).fract());
        let pairs = shape.iter().enumerate();
        if track.path.closed {
            pairs.map(|(i, p)| p.distance_squared(at(i))).sum()
        } else {
            shape.iter().zip(samples).map(|(p, q)| p.distance_squared(*q)).sum()
        }
    };
    let samples = track.samples(surfaces);
    if !track.path.closed {
        return (fit(&samples, 0.0), track);
    }
    let fits = track.t.iter().map(|&t| fit(&samples, t)).enumerate();
    let best = fits.reduce(|best, next| if next.1 < best.1 { next } else { best });
    let Some((first, best)) = best else { return (0.0, track) };
    let Track { mut path, mut t } = track;
    let start = t[first];
    path.vertices.rotate_left(first);
    t.rotate_left(first);
    for t in &mut t {
        *t = (*t - start).rem_euclid(1.0);
    }
    (best, Track { path, t })
}

/// A closed list of samples at a fraction.
fn lookup(samples: &[DVec3], t: f64) -> DVec3 {
    let x = t * samples.len() as f64;
    let i = x.floor() as usize % samples.len();
    samples[i].lerp(samples[(i + 1) % samples.len()], x - x.floor())
}

impl Track {
    /// Where a parameter lies.
    pub(crate) fn place(&self, t: f64) -> Place {
        let next = self.t.partition_point(|own| *own <= t);
        let segment = next.saturating_sub(1).min(self.path.segments().saturating_sub(1));
        let start = self.t[segment];
        let end = self.t.get(segment + 1).copied().unwrap_or(1.0);
        let x = if end > start { ((t - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        let x = if x < SNAP {
            0.0
        } else if x > 1.0 - SNAP {
            1.0
        } else {
            x
        };
        Place { segment, x }
    }

    /// The vertex at a place, if there is one.
    pub(crate) fn vertex(&self, place: Place) -> Option<usize> {
        match place.x {
            0.0 => Some(place.segment),
            1.0 => Some((place.segment + 1) % self.path.vertices.len()),
            _ => None,
        }
    }

    fn at(&self, t: f64, surfaces: &Surfaces<'_>) -> DVec3 {
        let Place { segment, x } = self.place(t);
        let vertices = &self.path.vertices;
        let [a, b] = [segment, segment + 1].map(|i| surfaces.at(vertices[i % vertices.len()]));
        a.lerp(b, x)
    }

    /// Points at equal steps of the parameter; of a run with both ends.
    fn samples(&self, surfaces: &Surfaces<'_>) -> Vec<DVec3> {
        let steps = if self.path.closed { SAMPLES } else { SAMPLES - 1 } as f64;
        (0..SAMPLES).map(|i| self.at(i as f64 / steps, surfaces)).collect()
    }

    /// Parameters for the vertices of `b` such that each point of this track belongs to the nearest of `b`, as far as they follow in
    /// order. `b` runs as this track does.
    fn closest(&self, b: &Track, surfaces: &Surfaces<'_>) -> Vec<f64> {
        let nodes: Vec<f64> = (0..=SAMPLES).map(|i| i as f64 / SAMPLES as f64).collect();
        let mut feet: Vec<f64> = nodes.iter().map(|&t| b.foot(self.at(t, surfaces), t, surfaces)).collect();
        // Ends belong to ends; a loop begins at its start.
        (feet[0], feet[SAMPLES]) = (0.0, 1.0);
        monotone(&mut feet);
        for (foot, t) in feet.iter_mut().zip(&nodes) {
            *foot = (1.0 - SLOPE) * *foot + SLOPE * t;
        }
        let inverse = |s: f64| {
            let next = feet.partition_point(|foot| *foot <= s).clamp(1, SAMPLES);
            let (low, high) = (feet[next - 1], feet[next]);
            nodes[next - 1] + (nodes[next] - nodes[next - 1]) * ((s - low) / (high - low)).clamp(0.0, 1.0)
        };
        b.t.iter().map(|&s| inverse(s)).collect()
    }

    /// The parameter of the point nearest to `p`; on a loop the one of its turn that is nearest to `near`.
    fn foot(&self, p: DVec3, near: f64, surfaces: &Surfaces<'_>) -> f64 {
        let vertices = &self.path.vertices;
        let mut best = (f64::INFINITY, 0.0);
        for segment in 0..self.path.segments() {
            let [a, b] = [segment, segment + 1].map(|i| surfaces.at(vertices[i % vertices.len()]));
            let along = b - a;
            let square = along.length_squared();
            let x = if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
            let off = (a + along * x).distance_squared(p);
            if off < best.0 {
                let end = self.t.get(segment + 1).copied().unwrap_or(1.0);
                best = (off, self.t[segment] + (end - self.t[segment]) * x);
            }
        }
        if !self.path.closed {
            return best.1;
        }
        let turns = [best.1 - 1.0, best.1, best.1 + 1.0];
        turns
            .into_iter()
            .fold(best.1, |kept, t| if (t - near).abs() < (kept - near).abs() { t } else { kept })
    }
}

/// The rising sequence nearest to a sequence, by the sum of squares: neighbours that fall become their mean.
fn monotone(values: &mut [f64]) {
    let mut pools: Vec<(f64, usize)> = Vec::with_capacity(values.len());
    for &value in values.iter() {
        pools.push((value, 1));
        while let [.., (low, m), (high, n)] = pools[..] {
            if low <= high {
                break;
            }
            pools.truncate(pools.len() - 2);
            pools.push(((low * m as f64 + high * n as f64) / (m + n) as f64, m + n));
        }
    }
    let all = pools.into_iter().flat_map(|(value, count)| std::iter::repeat_n(value.clamp(0.0, 1.0), count));
    values.iter_mut().zip(all).for_each(|(value, next)| *value = next);
}
