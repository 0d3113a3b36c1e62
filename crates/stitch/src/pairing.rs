//! \[SF98\] §5.2: "we reparametrize the matching edges to a common domain".
//!
//! The common parameter runs from 0 to 1 along both edges. That of `a` is its own; that of `b` is turned, and on a loop shifted, so
//! that points that belong together are near each other.

use glam::DVec3;

use crate::path::Path;
use crate::settings::{Pairing, Reversed, Seam};
use crate::surfaces::Surfaces;

/// Samples that edges are compared by: enough for the turns that borders of garments take.
const SAMPLES: usize = 256;
/// How much a nearest-point pairing keeps of the pairing by length, so that it goes on everywhere: without it stretches of one edge
/// would belong to single points of the other.
const SLOPE: f64 = 0.02;
/// Vertices of the two edges that are so near to each other, in parts of the shortest segment beside them, are taken to belong together:
/// more than rounding of positions in f32 makes of equal fractions, and far less than shows.
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
pub(crate) fn pair(a: Path, b: Path, seam: &Seam, surfaces: &Surfaces<'_>) -> [Track; 2] {
    let by_length = |path: &Path| fractions(&path.lengths(surfaces), path.closed);
    let own = |path: &Path| match seam.pairing {
        Pairing::ArcLength | Pairing::Closest => by_length(path),
        Pairing::Parameter => fractions(&vec![1.0; path.segments()], path.closed),
    };
    let a = Track { t: own(&a), path: a };
    let b = Track { t: own(&b), path: b };
    let candidates = match seam.reversed {
        Reversed::Given(reversed) => vec![turned(b, reversed)],
        Reversed::Auto => vec![turned(b.clone(), false), turned(b, true)],
    };
    let fitted = candidates.into_iter().map(|track| started(&a, track, surfaces));
    // Of equal ones the first: as the edges run.
    let best = fitted.reduce(|best, next| if next.0 < best.0 { next } else { best });
    let mut b = best.map_or_else(|| a.clone(), |(_, track)| track);
    if seam.pairing == Pairing::Closest {
        b.t = a.closest(&b, surfaces);
    }
    a.draw(&mut b);
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

/// A loop shifted so that it fits another track best, vertex to vertex; and how well a track fits, the sum of the squares of the
/// distances.
fn started(a: &Track, mut b: Track, surfaces: &Surfaces<'_>) -> (f64, Track) {
    let [shape, samples] = [a, &b].map(|track| track.samples(surfaces));
    // The point of `b` that is to have the parameter 0, in samples.
    let fit = |shift: usize| -> f64 {
        shape.iter().enumerate().map(|(i, p)| p.distance_squared(samples[(i + shift) % SAMPLES])).sum()
    };
    if !b.path.closed {
        return (fit(0), b);
    }
    let fits: Vec<f64> = (0..SAMPLES).map(fit).collect();
    let best = (0..SAMPLES).fold(0, |best, shift| if fits[shift] < fits[best] { shift } else { best });
    // The least of a parabola through it and its neighbours.
    let [before, here, after] = [SAMPLES - 1, 0, 1].map(|step| fits[(best + step) % SAMPLES]);
    let bend = before - 2.0 * here + after;
    let between = if bend > 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    let shift = (best as f64 + between) / SAMPLES as f64;
    // A vertex of the one comes to a vertex of the other, whichever takes the least turning.
    let off = |turn: f64| turn - turn.round();
    let mut least = (f64::INFINITY, 0.0);
    for own in &a.t {
        for other in &b.t {
            let turn = off(other - own - shift);
            if turn.abs() < least.0 - 1e-9 {
                least = (turn.abs(), shift + turn);
            }
        }
    }
    b.shift(least.1);
    (here, b)
}

impl Track {
    /// Where a parameter lies.
    pub(crate) fn place(&self, t: f64) -> Place {
        let count = self.t.len();
        let next = self.t.partition_point(|own| *own <= t);
        // On a loop what is before the first vertex is behind the last.
        let (segment, t) = match next {
            0 if self.path.closed => (count - 1, t + 1.0),
            0 => (0, t),
            _ => ((next - 1).min(self.path.segments().saturating_sub(1)), t),
        };
        let start = self.t[segment];
        let end = self.end(segment);
        let x = if end > start { ((t - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 };
        Place { segment, x }
    }

    /// The parameter at which a segment ends; of the last one of a loop beyond 1.
    pub(crate) fn end(&self, segment: usize) -> f64 {
        self.t.get(segment + 1).copied().unwrap_or_else(|| 1.0 + self.t.first().copied().unwrap_or(0.0))
    }

    /// The shortest segment at a vertex, in the parameter.
    fn least(&self, vertex: usize) -> f64 {
        let segments = self.path.segments();
        let before = match vertex {
            0 if self.path.closed => Some(segments - 1),
            _ => vertex.checked_sub(1),
        };
        let after = (vertex < segments).then_some(vertex);
        let length = |segment: usize| self.end(segment) - self.t[segment];
        before.into_iter().chain(after).map(length).fold(f64::INFINITY, f64::min)
    }

    /// Gives vertices of another track that are near to one of this the parameter of that.
    fn draw(&self, other: &mut Track) {
        let last = other.t.len() - 1;
        for vertex in 0..other.t.len() {
            let t = other.t[vertex];
            // The ends of runs belong to each other.
            if !self.path.closed && (vertex == 0 || vertex == last) {
                continue;
            }
            let Place { segment, x } = self.place(t);
            let near = if x < 0.5 { segment } else { segment + 1 };
            let (own, to) = match self.t.get(near) {
                Some(&own) => (near, own),
                None => (0, self.end(segment)),
            };
            if (!self.path.closed && (own == 0 || own + 1 == self.t.len())) || to > 1.0 {
                continue;
            }
            // Of less than half of every segment, so that no two are drawn to one.
            let room = self.least(own).min(other.least(vertex));
            if (t - to).abs() <= SNAP * room {
                other.t[vertex] = to;
            }
        }
    }

    /// Shifts a loop so that what has the parameter `by` gets 0.
    fn shift(&mut self, by: f64) {
        let moved: Vec<f64> = self.t.iter().map(|t| (t - by).rem_euclid(1.0)).collect();
        let first = (0..moved.len()).fold(0, |first, i| if moved[i] < moved[first] { i } else { first });
        self.path.vertices.rotate_left(first);
        self.t = moved;
        self.t.rotate_left(first);
        // Points at one place before the first come to 0, too; they are the last.
        for i in 1..self.t.len() {
            if self.t[i] < self.t[i - 1] {
                self.t[i] += 1.0;
            }
        }
    }

    /// Brings the vertices of a loop into the order of their parameters.
    pub(crate) fn sort(&mut self) {
        let Some(first) =
            (0..self.t.len()).reduce(|first, i| if self.t[i] < self.t[first] { i } else { first })
        else {
            return;
        };
        self.path.vertices.rotate_left(first);
        self.t.rotate_left(first);
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
                let end = self.end(segment);
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
