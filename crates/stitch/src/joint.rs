//! `weld: true`: both sides of a seam get vertices at the same places, and these become one.

use std::collections::BTreeMap;

use crate::error::StitchError;
use crate::seams::{Seams, lay};
use crate::settings::Stitch;
use crate::side::Frame;
use crate::surfaces::{Pieces, Surfaces};
use crate::target::{Moment, Sides, Targets};

/// Cuts this near to each other, in parts of a segment, are one: more than rounding makes of equal shares.
const SAME: f64 = 1e-6;

/// New vertices on a segment of a border.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The points that the segment runs between.
    pub ends: [u32; 2],
    /// Where on it, from the first end to the second: rising, between 0 and 1.
    pub shares: Vec<f64>,
}

/// Where a cut belongs: the seam, its side, and the segment.
type Home = (usize, usize, usize);

/// Points, and where on which seams they lie: the seam and the vertex of its first edge.
type Group = (Vec<u32>, Vec<(usize, usize)>);

/// Points that become one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Joints {
    points: Vec<Vec<u32>>,
    /// Of each group.
    places: Vec<Vec<(usize, usize)>>,
    /// How far each has come.
    closed: Vec<f32>,
}

impl Joints {
    /// The vertices that seams to be welded have on both sides.
    pub(crate) fn of(settings: &Stitch, sides: &[Sides]) -> Self {
        let mut group_of: BTreeMap<u32, usize> = BTreeMap::new();
        let mut groups: Vec<Group> = Vec::new();
        let welded = settings.seams.iter().zip(sides).enumerate().filter(|(_, (seam, _))| seam.weld);
        for (seam, (_, [a, b])) in welded {
            for (vertex, (&own, &place)) in a.track.path.vertices.iter().zip(&a.other).enumerate() {
                let Some(other) = b.track.vertex(place).map(|other| b.track.path.vertices[other]) else {
                    continue;
                };
                let mut group = (vec![own, other], vec![(seam, vertex)]);
                // Corners belong to several seams.
                for known in [own, other].map(|point| group_of.get(&point).copied()).into_iter().flatten() {
                    group.0.append(&mut groups[known].0);
                    group.1.append(&mut groups[known].1);
                }
                group.0.sort_unstable();
                group.0.dedup();
                group_of.extend(group.0.iter().map(|&point| (point, groups.len())));
                groups.push(group);
            }
        }
        groups.retain(|(points, _)| points.len() > 1);
        let closed = vec![0.0; groups.len()];
        let (points, places) = groups.into_iter().unzip();
        Self { points, places, closed }
    }

    /// Notes how far each has come. A corner has come as far as the least of its seams.
    pub(crate) fn close(&mut self, moments: &[Moment], targets: &[Targets]) {
        for (closed, places) in self.closed.iter_mut().zip(&self.places) {
            let of = |&(seam, vertex): &(usize, usize)| {
                let open = targets[seam][0].gaps.get(vertex).map_or(0.0, |gap| gap.open);
                (moments[seam].closure * (1.0 - open)) as f32
            };
            *closed = places.iter().map(of).fold(1.0, f32::min);
        }
    }

    pub(crate) fn groups(&self) -> impl Iterator<Item = (&[u32], f32)> {
        self.points.iter().map(Vec::as_slice).zip(self.closed.iter().copied())
    }
}

impl Seams {
    /// Where borders are to be cut so that seams to be welded have a vertex on each side wherever the other has one. For
    /// [`Seams::cut`], once that is done.
    pub fn cuts(&self) -> Vec<Cut> {
        self.homes().into_values().map(|(cut, _)| cut).collect()
    }

    /// Cuts with the parameters of their new vertices, by where they belong.
    fn homes(&self) -> BTreeMap<Home, (Cut, Vec<f64>)> {
        let mut homes: BTreeMap<Home, Vec<(f64, f64)>> = BTreeMap::new();
        for (index, (seam, sides)) in self.settings.seams.iter().zip(&self.sides).enumerate() {
            for own in 0..2 {
                let (side, other) = (&sides[own], &sides[1 - own].track);
                let lone =
                    side.other.iter().zip(&side.track.t).filter(|(place, _)| other.vertex(**place).is_none());
                for (place, &t) in lone.filter(|_| seam.weld) {
                    homes.entry((index, 1 - own, place.segment)).or_default().push((place.x, t));
                }
            }
        }
        let cut = |((seam, side, segment), mut places): (Home, Vec<(f64, f64)>)| {
            let vertices = &self.sides[seam][side].track.path.vertices;
            let ends = [segment, segment + 1].map(|i| vertices[i % vertices.len()]);
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            places.dedup_by(|a, b| a.0 == b.0);
            let (shares, t) = places.into_iter().unzip();
            ((seam, side, segment), (Cut { ends, shares }, t))
        };
        homes.into_iter().map(cut).collect()
    }

    /// The same seams on surfaces whose borders have been cut: at least as [`Seams::cuts`] has it, or for other seams, too, as
    /// [`merged`] has it. `points` are the new points of each cut, the old ones have kept their numbers.
    ///
    /// # Errors
    ///
    /// As [`seams`](crate::seams()).
    pub fn cut(
        &self,
        surfaces: &Surfaces<'_>,
        cuts: &[Cut],
        points: &[Vec<u32>],
    ) -> Result<Self, StitchError> {
        let known: BTreeMap<[u32; 2], (&Cut, &Vec<u32>)> =
            cuts.iter().zip(points).map(|(cut, new)| (sorted(cut.ends), (cut, new))).collect();
        let homes = if known.is_empty() { BTreeMap::new() } else { self.homes() };
        let track = |seam: usize, side: usize| {
            let mut track = self.sides[seam][side].track.clone();
            let count = track.path.vertices.len();
            // From behind, so that segments keep their numbers until it is their turn.
            for segment in (0..track.path.segments()).rev().filter(|_| !known.is_empty()) {
                let ends = [segment, (segment + 1) % count].map(|i| track.path.vertices[i]);
                let Some((cut, points)) = known.get(&sorted(ends)).filter(|(_, new)| !new.is_empty()) else {
                    continue;
                };
                let (mut shares, mut points) = (cut.shares.clone(), (*points).clone());
                if cut.ends != ends {
                    shares = shares.iter().rev().map(|share| 1.0 - share).collect();
                    points.reverse();
                }
                let range = [track.t[segment], track.end(segment)];
                let t = parameters(range, &shares, homes.get(&(seam, side, segment)));
                let next = segment + 1;
                track.t.splice(next..next, t);
                track.path.vertices.splice(next..next, points);
            }
            if track.path.closed {
                track.sort();
            }
            track
        };
        let tracks = (0..self.sides.len()).map(|seam| [track(seam, 0), track(seam, 1)]).collect();
        lay(&self.settings, tracks, Pieces::new(surfaces))
    }

    /// The same seams where the points are now: unlike [`Seams::follow`] it also looks anew what each wire may move, since distances over a
    /// surface that shrinks or grows are others.
    ///
    /// # Errors
    ///
    /// An edge that has lost its length.
    pub fn renewed(&self, surfaces: &Surfaces<'_>) -> Result<Self, StitchError> {
        self.cut(surfaces, &[], &[])
    }

    /// The seams to be welded along most of which the two sides disagree about the outside: there both surfaces lie on the same hand of
    /// whoever walks along the seam, upright on either. Front and back of a garment, which face opposite ways, do agree.
    pub fn facing(&self) -> impl Iterator<Item = usize> {
        let hand = |frame: Frame| frame.along.dot(frame.inward.cross(frame.normal));
        let disagree = move |[a, b]: &Sides| {
            let pairs = a.frames.iter().zip(&a.other);
            let count = pairs.filter(|(own, place)| hand(**own) * hand(b.frame_at(**place)) > 0.0);
            2 * count.count() > a.frames.len()
        };
        let welded = self.settings.seams.iter().zip(&self.sides).enumerate();
        welded.filter(move |(_, (seam, sides))| seam.weld && disagree(sides)).map(|(index, _)| index)
    }
}

/// Cuts of several [`Seams`] as one list, in which no segment stands twice.
pub fn merged(cuts: impl IntoIterator<Item = Cut>) -> Vec<Cut> {
    let mut all: BTreeMap<[u32; 2], Vec<f64>> = BTreeMap::new();
    for Cut { ends, shares } in cuts {
        let ahead = ends == sorted(ends);
        let own = shares.into_iter().map(|share| if ahead { share } else { 1.0 - share });
        all.entry(sorted(ends)).or_default().extend(own);
    }
    let cut = |(ends, mut shares): ([u32; 2], Vec<f64>)| {
        shares.sort_by(f64::total_cmp);
        shares.dedup_by(|next, kept| *next - *kept < SAME);
        Cut { ends, shares }
    };
    all.into_iter().map(cut).collect()
}

/// The parameters of new vertices on a segment that runs from the first to the second of `range`: those of their partners, where they are
/// made for these, so that both have the same bits.
fn parameters(range: [f64; 2], shares: &[f64], home: Option<&(Cut, Vec<f64>)>) -> Vec<f64> {
    let even: Vec<f64> = shares.iter().map(|share| range[0] + (range[1] - range[0]) * share).collect();
    // The last segment of a loop goes on behind 1 from 0.
    let ahead = |t: f64| if t < range[0] { t + 1.0 } else { t };
    let back = |t: &f64| if *t > 1.0 { t - 1.0 } else { *t };
    let mut out: Vec<f64> = even.iter().map(back).collect();
    for (share, t) in home.iter().flat_map(|(cut, t)| cut.shares.iter().zip(t)) {
        let next = shares.partition_point(|own| *own < share - SAME);
        if shares.get(next).is_some_and(|own| (own - share).abs() < SAME) {
            out[next] = *t;
        }
    }
    if out.windows(2).all(|pair| ahead(pair[0]) < ahead(pair[1])) {
        out
    } else {
        even.iter().map(back).collect()
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
