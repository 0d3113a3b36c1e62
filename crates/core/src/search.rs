//! The feet of all points near a wire, a tile at a time, and a block of 64 points at a time within.

use pulp::Simd;
use rayon::prelude::*;

use crate::block::{BLOCK, Block, Feet};
use crate::closest::{Candidate, Pieces};
use crate::domain::{DomainCurve, Footed, Side};
use crate::medial::{Profile, Weighted};
use crate::spans::Spans;
use crate::tiles::{Balls, TILE, Tile, Tiles};

/// A point's foot as it is kept: segment, place in it, distance and weight; an infinite distance means no foot in reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StoredFoot {
    pub(crate) span: u32,
    pub(crate) t: f32,
    pub(crate) distance: f64,
    /// 1 for a foot alone; those of several sum to 1.
    pub(crate) weight: f32,
}

const NO_FOOT: StoredFoot = StoredFoot { span: 0, t: 0.0, distance: f64::INFINITY, weight: 1.0 };

/// Feet of consecutive points, and how the points stand to each domain curve of the wire.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// The closest foot of each point.
    pub(crate) feet: Vec<StoredFoot>,
    /// For each domain curve how each point stands with that foot.
    pub(crate) sides: Vec<Vec<Side>>,
    /// Further feet of some points, by rising index of the point.
    pub(crate) more: Vec<(u32, StoredFoot)>,
    /// For each domain curve how the points stand with these.
    pub(crate) more_sides: Vec<Vec<Side>>,
}

impl Found {
    fn new(count: usize, domains: usize) -> Self {
        let sides = vec![vec![Side::BEHIND; count]; domains];
        Self { feet: vec![NO_FOOT; count], sides, more: Vec::new(), more_sides: vec![Vec::new(); domains] }
    }

    /// The part of points `from .. to`, which it counts from 0.
    pub(crate) fn part(&self, from: usize, to: usize) -> Self {
        let start = self.more.partition_point(|(point, _)| (*point as usize) < from);
        let end = self.more.partition_point(|(point, _)| (*point as usize) < to);
        let own = |(point, foot): &(u32, StoredFoot)| (point - from as u32, *foot);
        Self {
            feet: self.feet[from..to].to_vec(),
            sides: self.sides.iter().map(|sides| sides[from..to].to_vec()).collect(),
            more: self.more[start..end].iter().map(own).collect(),
            more_sides: self.more_sides.iter().map(|sides| sides[start..end].to_vec()).collect(),
        }
    }

    /// Adds the feet of the points that follow.
    fn append(&mut self, mut next: Self) {
        let first = self.feet.len() as u32;
        self.feet.append(&mut next.feet);
        self.more.extend(next.more.into_iter().map(|(point, foot)| (first + point, foot)));
        let sides = self.sides.iter_mut().zip(&mut next.sides);
        let more = self.more_sides.iter_mut().zip(&mut next.more_sides);
        sides.chain(more).for_each(|(all, next)| all.append(next));
    }

    /// The same where point `i` is number `order[i]`.
    fn reordered(self, order: &[u32]) -> Self {
        let mut new = Self::new(self.feet.len(), self.sides.len());
        for (i, &number) in order.iter().enumerate() {
            new.feet[number as usize] = self.feet[i];
            for (new, sides) in new.sides.iter_mut().zip(&self.sides) {
                new[number as usize] = sides[i];
            }
        }
        let mut slots: Vec<usize> = (0..self.more.len()).collect();
        // Stable: the feet of a point stay in their order along the curve.
        slots.sort_by_key(|&slot| order[self.more[slot].0 as usize]);
        new.more = slots.iter().map(|&slot| (order[self.more[slot].0 as usize], self.more[slot].1)).collect();
        let sorted = |sides: &Vec<Side>| slots.iter().map(|&slot| sides[slot]).collect();
        new.more_sides = self.more_sides.iter().map(sorted).collect();
        new
    }

    /// Replaces the closest foot of `point`, in a lane of a block, by all that count.
    #[cold]
    fn blend(&mut self, pieces: &Pieces, block: &Block, lane: usize, point: usize, profile: &mut Profile) {
        let feet = profile.feet(pieces, block.at(lane), self.feet[point].distance);
        let Some((closest, others)) = feet.split_first() else { return };
        let stored = |foot: &Weighted| StoredFoot {
            span: foot.span,
            t: foot.t as f32,
            distance: foot.distance,
            weight: foot.weight as f32,
        };
        self.feet[point] = stored(closest);
        self.more.extend(others.iter().map(|foot| (point as u32, stored(foot))));
    }
}

/// What is searched.
#[derive(Clone, Copy)]
pub(crate) struct Sought<'a> {
    pub(crate) spans: &'a Spans,
    pub(crate) pieces: &'a Pieces,
    pub(crate) domains: &'a [DomainCurve],
    /// Feet beyond this are no use, but where a domain curve reaches farther.
    pub(crate) reach: f64,
}

impl Sought<'_> {
    /// The feet of all points, by their index.
    pub(crate) fn everywhere(self, tiles: &Tiles) -> Found {
        let all = self.pieces.all();
        let part = |(i, (tile, balls)): (usize, (&Tile, &Balls))| {
            let count = (tiles.count - i * TILE).min(TILE);
            self.tile(tile, balls, &all, count).unwrap_or_else(|| Found::new(count, self.domains.len()))
        };
        let parts: Vec<Found> = tiles.searched().par_iter().zip(&tiles.balls).enumerate().map(part).collect();
        let mut found = Found::new(0, self.domains.len());
        for part in parts {
            found.append(part);
        }
        match tiles.order() {
            None => found,
            Some(order) => found.reordered(order),
        }
    }

    /// The feet of the first `count` points of a tile; none where the wire reaches nothing of it.
    pub(crate) fn tile(self, tile: &Tile, balls: &Balls, all: &[Candidate], count: usize) -> Option<Found> {
        self.task(tile, balls, all, count).map(|task| pulp::Arch::new().dispatch(task))
    }

    /// The search of a tile; none where the wire reaches nothing of it.
    fn task<'a>(
        self,
        tile: &'a Tile,
        balls: &'a Balls,
        all: &'a [Candidate],
        count: usize,
    ) -> Option<Search<'a>>
    where
        Self: 'a,
    {
        let own = &self.pieces.ball;
        let domains = self.domains.iter().map(|domain| domain.reach(self.pieces));
        let reach = domains.fold(self.reach, f64::max);
        let ball = balls.tile?;
        if ball.center.distance(own.center) - ball.radius - own.radius > reach {
            return None;
        }
        let found = Found::new(count, self.domains.len());
        Some(Search { sought: self, reach, tile, balls, all, found })
    }

    /// The feet of a tile by vectors or one number at a time, as bits: segment, place, distance, weight.
    #[cfg(test)]
    pub(crate) fn both(
        self,
        tile: &Tile,
        balls: &Balls,
        count: usize,
        fast: bool,
    ) -> Vec<(u32, u32, u64, u32)> {
        let all = self.pieces.all();
        let Some(task) = self.task(tile, balls, &all, count) else { return Vec::new() };
        let found = if fast {
            pulp::Arch::new().dispatch(task)
        } else {
            pulp::WithSimd::with_simd(task, pulp::Scalar)
        };
        let feet = found.feet.iter().chain(found.more.iter().map(|(_, foot)| foot));
        feet.map(|f| (f.span, f.t.to_bits(), f.distance.to_bits(), f.weight.to_bits())).collect()
    }
}

/// The search, compiled for the vector instructions the processor has.
struct Search<'a> {
    sought: Sought<'a>,
    /// That of the whole wire.
    reach: f64,
    tile: &'a Tile,
    balls: &'a Balls,
    all: &'a [Candidate],
    found: Found,
}

impl pulp::WithSimd for Search<'_> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { sought, reach, tile, balls, all, mut found } = self;
        let Sought { pieces, domains, .. } = sought;
        let (mut of_tile, mut candidates) = (Vec::new(), Vec::new());
        let mut profile = Profile::default();
        let Some(ball) = balls.tile else { return found };
        let among = domains.iter().map(|domain| domain.near(ball)).collect();
        let mut stand = Stand { among, ..Stand::default() };
        // Feet that are not the closest weigh, even where they do not reach.
        pieces.cull(ball, reach + pieces.width, all, &mut of_tile);
        let reach = near_reach(sought, reach, &of_tile, &stand.among);
        let (mut block, mut feet) = (pieces.block(), Feet::new());
        for (k, ball) in balls.blocks.into_iter().enumerate() {
            let Some(ball) = ball else { continue };
            pieces.cull(ball, reach + pieces.width, &of_tile, &mut candidates);
            if candidates.is_empty() {
                continue;
            }
            let first = k * BLOCK;
            let count = (found.feet.len() - first).min(BLOCK);
            block.fill(tile, first, count);
            pieces.search(simd, &block, &candidates, reach + pieces.width, &mut feet);
            stand.clear();
            for lane in 0..count {
                if feet.distance[lane] >= reach {
                    continue;
                }
                let (span, t, distance) = (feet.span[lane], feet.t[lane], feet.distance[lane]);
                found.feet[first + lane] = StoredFoot { span, t: t as f32, distance, weight: 1.0 };
                let start = found.more.len();
                if pieces.width > 0.0 && feet.has_rival(lane, pieces.width) {
                    found.blend(pieces, &block, lane, first + lane, &mut profile);
                }
                if !domains.is_empty() {
                    let further = (start..found.more.len()).map(Slot::Further);
                    for slot in [Slot::Closest(first + lane)].into_iter().chain(further) {
                        stand.push(sought, tile, &found, slot);
                        if stand.points.len() == BLOCK {
                            stand.settle(simd, sought, &mut found);
                        }
                    }
                }
            }
            stand.settle(simd, sought, &mut found);
        }
        found
    }
}

/// Where a foot is kept in [`Found`].
#[derive(Clone, Copy)]
enum Slot {
    /// In `feet`.
    Closest(usize),
    /// In `more`.
    Further(usize),
}

/// Up to a block of feet whose points' standing to the domain curves is to be found.
#[derive(Default)]
struct Stand {
    /// For each domain curve its pieces that may hold the foot of a point of the tile.
    among: Vec<Vec<Candidate>>,
    points: Vec<Footed>,
    slots: Vec<Slot>,
    near: Vec<Candidate>,
    sides: Vec<Side>,
}

impl Stand {
    fn clear(&mut self) {
        self.points.clear();
        self.slots.clear();
    }

    fn push(&mut self, sought: Sought<'_>, tile: &Tile, found: &Found, slot: Slot) {
        let (point, foot) = match slot {
            Slot::Closest(point) => (point, found.feet[point]),
            Slot::Further(i) => (found.more[i].0 as usize, found.more[i].1),
        };
        let foot = sought.spans.cubics[foot.span as usize].at(f64::from(foot.t));
        self.points.push(Footed { point: tile.position(point), foot });
        self.slots.push(slot);
    }

    /// Notes how the points stand, and drops the feet that neither the wire's radius nor a domain curve reaches.
    #[inline(always)]
    fn settle<S: Simd>(&mut self, simd: S, sought: Sought<'_>, found: &mut Found) {
        if self.points.is_empty() {
            return;
        }
        let mut reach = [sought.reach; BLOCK];
        for (number, domain) in sought.domains.iter().enumerate() {
            self.sides.clear();
            domain.stand(simd, &self.points, &self.among[number], &mut self.near, &mut self.sides);
            for (i, (&slot, &side)) in self.slots.iter().zip(&self.sides).enumerate() {
                reach[i & (BLOCK - 1)] = domain.reaches(side).max(reach[i & (BLOCK - 1)]);
                match slot {
                    Slot::Closest(point) => found.sides[number][point] = side,
                    // They come in order.
                    Slot::Further(_) => found.more_sides[number].push(side),
                }
            }
        }
        for (&slot, reach) in self.slots.iter().zip(reach) {
            let foot = match slot {
                Slot::Closest(point) => &mut found.feet[point],
                Slot::Further(i) => &mut found.more[i].1,
            };
            if foot.distance >= reach {
                foot.distance = f64::INFINITY;
            }
        }
        self.clear();
    }
}

/// How far feet matter for the points of a tile, with their candidates on the wire and on each domain curve: no farther than `most`.
fn near_reach(sought: Sought<'_>, most: f64, of_tile: &[Candidate], among: &[Vec<Candidate>]) -> f64 {
    let Sought { pieces, domains, reach: own, .. } = sought;
    if most <= own {
        return own;
    }
    let near = domains.iter().zip(among).map(|(domain, among)| domain.reach_near(pieces, of_tile, among));
    near.fold(own, f64::max).min(most)
}
