//! `weld: true`: both sides of a seam get vertices at the same places, and these become one.

use std::collections::BTreeMap;

use crate::error::StitchError;
use crate::pairing::Track;
use crate::seams::{Seams, lay};
use crate::settings::Stitch;
use crate::surfaces::{Pieces, Surfaces};
use crate::target::{Moment, Sides, Targets};

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

    /// The same seams on surfaces whose borders have been cut as [`Seams::cuts`] has it; `points` are the new points of each cut, the
    /// old ones have kept their numbers.
    ///
    /// # Errors
    ///
    /// As [`seams`](crate::seams()).
    pub fn cut(&self, surfaces: &Surfaces<'_>, points: &[Vec<u32>]) -> Result<Self, StitchError> {
        let mut tracks: Vec<[Track; 2]> =
            self.sides.iter().map(|sides| [0, 1].map(|side| sides[side].track.clone())).collect();
        // From behind, so that segments keep their numbers until it is their turn.
        for (((seam, side, segment), (_, t)), points) in self.homes().into_iter().zip(points).rev() {
            let (track, next) = (&mut tracks[seam][side], segment + 1);
            track.path.vertices.splice(next..next, points.iter().copied());
            track.t.splice(next..next, t);
        }
        tracks.iter_mut().flatten().filter(|track| track.path.closed).for_each(Track::sort);
        lay(&self.settings, tracks, Pieces::new(surfaces))
    }
}
