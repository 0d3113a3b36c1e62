//! Parts of effects with a mask and a weight each, so that an engine can bring folds in and out.
//!
//! A part is a run of neighbouring creases, or wires, of one effect. Its mask is its share of what moves a point at the moment of
//! the maps, `|ΔP_g| / Σ|ΔP_h|`: the masks of all parts add up to 1 wherever anything moves, so that with all weights at 1 the map is
//! whole. Its weight at another moment is the factor that brings its shape then nearest to its shape in the map,
//! `ΔP_g(t)·ΔP_g / |ΔP_g|²` over all points.

use crate::maps::job::MapJob;
use crate::maps::moment::Length;
use crate::maps::notes::{MapGroup, MapMask};
use crate::maps::target::{MapTarget, mask_name};
use crate::motion::Motion;
use crate::stage::Portion;
use crate::{JobError, Progress};

/// Keys of weights are left out where the line between others is this close: a quarter of a step of 8 bits.
const CLOSE: f64 = 1e-3;
/// What weights leave over, in parts of a part's largest motion, that is told: more shows.
const LEFT: f64 = 0.25;

/// The parts of effects.
pub(crate) struct Groups {
    list: Vec<Group>,
    most: usize,
    /// Sum of the lengths of what moves each point.
    sums: Vec<f32>,
}

struct Group {
    portion: Portion,
    /// How it moves each point at the moment of the maps.
    full: Vec<[f32; 3]>,
    square: f64,
    /// What weights left over at the worst moment, a square, and the largest square of its motion.
    left: f64,
    largest: f64,
    weights: Vec<(f64, f64)>,
}

impl Groups {
    /// Works out what each part does at a moment.
    pub(crate) fn at(motion: &mut Motion<'_>, seconds: f64, most: usize) -> Result<Self, JobError> {
        let mut list: Vec<Group> = Vec::new();
        let mut sums = vec![0.0_f32; motion.points.len()];
        motion.portions(seconds, most, &mut |portion, base, now| {
            let full: Vec<[f32; 3]> =
                base.iter().zip(now).map(|(a, b)| [0, 1, 2].map(|k| b[k] - a[k])).collect();
            let square = full.iter().map(|d| dot(*d, *d)).sum();
            for (sum, way) in sums.iter_mut().zip(&full) {
                *sum += length(*way);
            }
            let known = list.iter_mut().find(|group| group.portion == portion);
            // An effect of several stages is one part of each.
            match known {
                Some(group) => {
                    for (a, b) in group.full.iter_mut().zip(&full) {
                        *a = [0, 1, 2].map(|k| a[k] + b[k]);
                    }
                    group.square = group.full.iter().map(|d| dot(*d, *d)).sum();
                }
                None => {
                    list.push(Group { portion, full, square, left: 0.0, largest: 0.0, weights: Vec::new() });
                }
            }
        })?;
        Ok(Self { list, most, sums })
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// How much of what moves a point is a part's.
    pub(crate) fn share(&self, group: usize, point: usize) -> f32 {
        let (Some(group), Some(&sum)) = (self.list.get(group), self.sums.get(point)) else { return 0.0 };
        let own = group.full.get(point).map_or(0.0, |way| length(*way));
        if sum > 0.0 && sum.is_finite() { (own / sum).min(1.0) } else { 0.0 }
    }

    /// Works out the weights at all frames.
    pub(crate) fn weigh(
        &mut self,
        job: &MapJob<'_>,
        length: &Length,
        motion: &mut Motion<'_>,
        progress: &mut (dyn FnMut(Progress) + Send),
    ) -> Result<(), JobError> {
        let times = length.times(job)?;
        for (done, &seconds) in times.iter().enumerate() {
            let list = &mut self.list;
            motion.portions(seconds, self.most, &mut |portion, base, now| {
                if let Some(group) = list.iter_mut().find(|group| group.portion == portion) {
                    group.weigh(seconds, base, now);
                }
            })?;
            progress(Progress { done: done + 1, frames: times.len() });
        }
        Ok(())
    }

    /// Parts whose motion is no factor of what is in the map.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let told = |group: &Group| {
            let Portion { effect, lines } = &group.portion;
            let name = match lines.end.saturating_sub(1) {
                last if last > lines.start => format!("effect {effect}, lines {} to {last}", lines.start),
                _ => format!("effect {effect}, line {}", lines.start),
            };
            let left = (group.left / group.largest.max(f64::MIN_POSITIVE)).sqrt();
            if group.square == 0.0 {
                Some(format!(
                    "{name}: it moves nothing at the moment of the map, and is in no mask [map-mask-empty]"
                ))
            } else if left > LEFT {
                let part = 100.0 * left;
                Some(format!(
                    "{name}: {part:.0} % of its motion is no weight of one map: its folds travel or change; bake more \
                     moments with `--at` [map-mask-moves]"
                ))
            } else {
                None
            }
        };
        self.list.iter().filter_map(told).collect()
    }

    /// What is told of the masks, with their files.
    pub(crate) fn masks(&self, target: &MapTarget) -> Vec<MapMask> {
        let one = self.list.len() == 1;
        let chunks = self.list.chunks(wirework_bake::map::CHANNELS).enumerate();
        chunks
            .map(|(index, groups)| MapMask {
                file: target.name(&mask_name(index + 1)),
                groups: groups
                    .iter()
                    .zip(["r", "g", "b", "a"])
                    .map(|(g, c)| g.facts(if one { "gray" } else { c }))
                    .collect(),
            })
            .collect()
    }
}

impl Group {
    fn weigh(&mut self, seconds: f64, base: &[[f32; 3]], now: &[[f32; 3]]) {
        let (mut along, mut all) = (0.0, 0.0);
        for ((a, b), full) in base.iter().zip(now).zip(&self.full) {
            let way = [0, 1, 2].map(|k| b[k] - a[k]);
            along += dot(way, *full);
            all += dot(way, way);
        }
        let weight = if self.square > 0.0 { along / self.square } else { 0.0 };
        match self.weights.last_mut() {
            Some((time, sum)) if *time == seconds => *sum += weight,
            _ => self.weights.push((seconds, weight)),
        }
        self.left = self.left.max(all - weight * along);
        self.largest = self.largest.max(all);
    }

    fn facts(&self, channel: &'static str) -> MapGroup {
        MapGroup {
            channel,
            effect: self.portion.effect,
            lines: [self.portion.lines.start, self.portion.lines.end],
            left: (self.left / self.largest.max(f64::MIN_POSITIVE)).max(0.0).sqrt(),
            weights: thinned(&self.weights).into_iter().map(|(t, w)| [rounded(t), rounded(w)]).collect(),
        }
    }
}

/// Numbers for people and engines: a millionth is enough.
fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// Keys without those that the line between others replaces: of a run as many as one line is close to.
fn thinned(keys: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = keys.first().copied().into_iter().collect();
    let mut start = 0;
    for end in 2..keys.len() {
        let ((t0, w0), (t1, w1)) = (keys[start], keys[end]);
        let off = |&(t, w): &(f64, f64)| (w0 + (w1 - w0) * (t - t0) / (t1 - t0) - w).abs() > CLOSE;
        if keys[start + 1..end].iter().any(off) {
            start = end - 1;
            out.push(keys[start]);
        }
    }
    out.extend(keys.last().copied().filter(|_| keys.len() > 1));
    out
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|k| f64::from(a[k]) * f64::from(b[k])).sum()
}

fn length(a: [f32; 3]) -> f32 {
    dot(a, a).sqrt() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_on_a_line_are_left_out() {
        let line: Vec<(f64, f64)> =
            (0..=48).map(|k| (f64::from(k) / 24.0, f64::from(k.min(24)) / 24.0)).collect();
        assert_eq!(thinned(&line), [(0.0, 0.0), (1.0, 1.0), (2.0, 1.0)]);
        assert_eq!(thinned(&line[..1]), [(0.0, 0.0)]);
        assert_eq!(thinned(&line[..2]), line[..2]);
        let wave: Vec<(f64, f64)> =
            (0..=48).map(|k| (f64::from(k) / 24.0, (f64::from(k) / 8.0).sin())).collect();
        let keys = thinned(&wave);
        for (t, w) in &wave {
            let k = keys.partition_point(|key| key.0 <= *t).clamp(1, keys.len() - 1);
            let ((t0, w0), (t1, w1)) = (keys[k - 1], keys[k]);
            assert!((w0 + (w1 - w0) * (t - t0) / (t1 - t0) - w).abs() <= CLOSE);
        }
    }
}
