//! What nodes play, as players will show it: key poses on the way to targets, shapes and their weights, and how far both are off.

use std::rc::Rc;

use wirework_asset::{LocalDeltas, MeshTarget, MorphTarget, WeightTrack};

use crate::error::BakeError;
use crate::field::Field;
use crate::principal::{Basis, Shape};
use crate::study::{Plan, Study};
use crate::track::thinned;
use crate::vectors::add_scaled;
use crate::writer::{Frame, NodeClip, Poses, Sample, Writer, plain};

/// The part of the tolerance that weights may be off for having fewer keys.
const OF_KEYS: f64 = 0.04;

/// A node that plays something.
#[derive(Debug)]
pub(crate) struct Playing {
    pub(crate) node: usize,
    pub(crate) study: Study,
    pub(crate) way: Way,
}

/// How.
#[derive(Debug)]
pub(crate) enum Way {
    Still,
    Keys(KeyWay),
    Basis(BasisWay),
}

#[derive(Debug)]
pub(crate) struct KeyWay {
    /// The samples that are keys.
    keys: Vec<usize>,
    /// Of each of them that has been written its target; none where it equals the rest.
    targets: Vec<Option<usize>>,
    poses: Poses,
    /// The last two that were written: displacements by block.
    around: [Option<Rc<Sample>>; 2],
}

#[derive(Debug)]
pub(crate) struct BasisWay {
    basis: Basis,
    /// The samples that are keys, and how far the weights of others are off for it, metres.
    kept: Vec<usize>,
    slack: f64,
    /// The displacements of each shape, by block.
    shapes: Vec<Vec<(usize, LocalDeltas)>>,
}

/// How far players are off, at most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Off {
    /// Of a vertex, metres.
    pub(crate) metres: f64,
    /// When, seconds.
    pub(crate) seconds: f64,
    /// Of a normal, radians.
    pub(crate) radians: f64,
    /// Of all normals together, and how many these are.
    pub(crate) all: (f64, usize),
}

impl Playing {
    /// What plays a plan, and how far it is off at the samples; `tolerance` in metres.
    pub(crate) fn new(
        (node, field): (usize, &Field),
        study: Study,
        plan: Plan,
        tolerance: f64,
    ) -> (Self, f64) {
        let (way, error) = match plan {
            Plan::Still => (Way::Still, study.reach),
            Plan::Keys(keys, error) => {
                let (targets, poses) = (Vec::new(), Poses::default());
                (Way::Keys(KeyWay { keys, targets, poses, around: [None, None] }), error)
            }
            Plan::Basis(mut basis) => {
                let times: Vec<f64> = study.seen.iter().map(|seen| seen.time).collect();
                let rests: Vec<bool> = study.seen.iter().map(|seen| seen.rests).collect();
                let (kept, slack) =
                    thinned(&times, (&basis.weights, &rests), &basis.reaches, OF_KEYS * tolerance);
                let error = basis.error + slack;
                let apart = |shape: &mut Shape| {
                    let out = field.apart(&shape.places, &shape.directions);
                    (shape.places, shape.directions) = (Vec::new(), Vec::new());
                    out
                };
                let shapes = basis.shapes.iter_mut().map(apart).collect();
                (Way::Basis(BasisWay { basis, kept, slack, shapes }), error)
            }
        };
        (Self { node, study, way }, error)
    }

    /// The time of the key pose that has to be written before what is shown at `seconds` is known; none where it has been.
    pub(crate) fn wanted(&self, seconds: f64) -> Option<f64> {
        let Way::Keys(way) = &self.way else { return None };
        let time = |key: usize| self.study.seen[key].time;
        let before = way.targets.len().checked_sub(1).and_then(|last| way.keys.get(last));
        if before.is_some_and(|key| time(*key) >= seconds) {
            return None;
        }
        way.keys.get(way.targets.len()).map(|key| time(*key))
    }

    /// Writes the next key pose.
    pub(crate) fn write_key(
        &mut self,
        writer: &mut Writer<'_>,
        sample: &Rc<Sample>,
    ) -> Result<(), BakeError> {
        let Way::Keys(way) = &mut self.way else { return Ok(()) };
        let mut target = None;
        if writer.moves(self.node, sample) {
            let mut written: Vec<Option<MorphTarget>> = vec![None; sample.blocks.len()];
            for block in writer.nodes[self.node].blocks.clone() {
                let deltas = sample.blocks.get(block).filter(|deltas| deltas.moves());
                written[block] = deltas.map(|deltas| writer.block(block, deltas.clone())).transpose()?;
            }
            let content = writer.content(self.node, |block| written.get(block).copied().flatten())?;
            let (prefix, key) = (plain(&writer.settings.prefix), way.targets.len());
            target = Some(way.poses.take(content, || format!("{prefix}_k{key:04}")));
        }
        way.targets.push(target);
        way.around.swap(0, 1);
        way.around[1] = Some(Rc::clone(sample));
        Ok(())
    }

    /// How far what is shown at a moment is off: `sample` is what `frame` should be.
    pub(crate) fn off(&self, blocks: &[usize], frame: &Frame<'_>, sample: &Sample) -> Off {
        let index = self.study.seen.partition_point(|seen| seen.time <= sample.time).saturating_sub(1);
        let mut off = Off { seconds: sample.time, ..Off::default() };
        let slack = if let Way::Basis(way) = &self.way { way.slack } else { 0.0 };
        for &block in blocks {
            let Some(wanted) = sample.blocks.get(block) else { continue };
            let shown = self.shown(block, sample.time, index);
            let apart = frame.moment.apart(block, &wanted.positions, &shown.positions);
            off.metres = off.metres.max(apart + slack);
            if let (Some(normals), Some(now)) = (&shown.normals, frame.normals) {
                let (most, sum, count) = frame.moment.askew(block, normals, now);
                off.radians = off.radians.max(most);
                off.all = (off.all.0 + sum, off.all.1 + count);
            }
        }
        off
    }

    /// The displacements of a block that players show at a time after the sample `index`.
    fn shown(&self, block: usize, seconds: f64, index: usize) -> LocalDeltas {
        match &self.way {
            Way::Still => mixed(&[]),
            Way::Keys(way) => {
                let ends = [&way.around[0], &way.around[1]].map(Option::as_ref);
                let of = |sample: &Rc<Sample>| sample.time;
                let [Some(a), Some(b)] = ends else { return mixed(&[]) };
                let part = ((seconds - of(a)) / (of(b) - of(a))).clamp(0.0, 1.0);
                let list = [(1.0 - part, a.blocks.get(block)), (part, b.blocks.get(block))];
                mixed(&list.map(|(weight, deltas)| (weight as f32, deltas)))
            }
            Way::Basis(way) => {
                let seen = &self.study.seen;
                let [a, b] = [index, index + 1].map(|k| k.min(seen.len() - 1));
                let part = if b > a { (seconds - seen[a].time) / (seen[b].time - seen[a].time) } else { 0.0 };
                let weight = |k: usize| {
                    let [a, b] = [a, b].map(|sample| way.basis.weights[sample][k]);
                    (a + part * (b - a)) as f32
                };
                let of_block =
                    |shape: &[(usize, LocalDeltas)]| shape.iter().position(|(own, _)| *own == block);
                let shapes = way.shapes.iter().enumerate();
                let list: Vec<_> =
                    shapes.map(|(k, shape)| (weight(k), of_block(shape).map(|at| &shape[at].1))).collect();
                mixed(&list)
            }
        }
    }

    /// How many targets it gets.
    pub(crate) fn target_count(&self) -> usize {
        match &self.way {
            Way::Still => 0,
            Way::Keys(way) => way.poses.targets.len(),
            Way::Basis(way) => way.shapes.len(),
        }
    }

    /// Writes what has not been written, and gives targets and track.
    pub(crate) fn clip(self, writer: &mut Writer<'_>) -> Result<NodeClip, BakeError> {
        let seen = &self.study.seen;
        let times: Vec<f64> = seen.iter().map(|seen| seen.time).collect();
        let (targets, kept, weights) = match self.way {
            Way::Still => (Vec::new(), Vec::new(), Vec::new()),
            Way::Keys(way) => {
                let weights = one_by_one(&way, &times);
                (way.poses.targets, way.keys, weights)
            }
            Way::Basis(way) => {
                let mut targets = Vec::with_capacity(way.shapes.len());
                for (k, shape) in way.shapes.into_iter().enumerate() {
                    let mut written = Vec::with_capacity(shape.len());
                    for (block, deltas) in shape {
                        written.push((
                            block,
                            if deltas.moves() { Some(writer.block(block, deltas)?) } else { None },
                        ));
                    }
                    let of_block = |block: usize| written.iter().find(|(own, _)| *own == block)?.1;
                    let primitives = writer.content(self.node, of_block)?;
                    let prefix = plain(&writer.settings.prefix);
                    let is_offset = way.basis.offset && k + 1 == way.basis.reaches.len();
                    let name =
                        if is_offset { format!("{prefix}_offset") } else { format!("{prefix}_b{k:02}") };
                    targets.push(MeshTarget { name, primitives });
                }
                (targets, way.kept, way.basis.weights)
            }
        };
        // Weights of the mesh's own targets are as they are at every sample.
        let own_move = seen.windows(2).any(|pair| pair[0].own != pair[1].own);
        let kept = if own_move { (0..times.len()).collect() } else { kept };
        let mut track = Vec::with_capacity(kept.len() * (weights.first().map_or(0, Vec::len)));
        for &key in &kept {
            track.extend(&seen[key].own);
            track.extend(weights.get(key).into_iter().flatten().map(|w| *w as f32));
        }
        let times = kept.iter().map(|&key| times[key] as f32).collect();
        let node = writer.nodes[self.node].index;
        Ok(NodeClip { targets, track: WeightTrack { node, times: Some(times), weights: track } })
    }
}

/// At each sample the weights of key poses.
fn one_by_one(way: &KeyWay, times: &[f64]) -> Vec<Vec<f64>> {
    let count = way.poses.targets.len();
    let mut out = vec![vec![0.0; count]; times.len()];
    let mut put = |sample: usize, target: Option<usize>, weight: f64| {
        if let Some(slot) = target.and_then(|target| out[sample].get_mut(target)) {
            *slot += weight;
        }
    };
    let keys: Vec<(usize, Option<usize>)> =
        way.keys.iter().copied().zip(way.targets.iter().copied()).collect();
    if let Some(&(first, target)) = keys.first() {
        put(first, target, 1.0);
    }
    for pair in keys.windows(2) {
        let [(a, from), (b, to)] = [pair[0], pair[1]];
        for sample in a + 1..=b {
            let part = (times[sample] - times[a]) / (times[b] - times[a]);
            put(sample, from, 1.0 - part);
            put(sample, to, part);
        }
    }
    out
}

/// The sum of displacements of a block, each by its weight.
fn mixed(list: &[(f32, Option<&LocalDeltas>)]) -> LocalDeltas {
    let sum = |pick: fn(&LocalDeltas) -> Option<&Vec<[f32; 3]>>| {
        let mut out: Vec<[f32; 3]> = Vec::new();
        for (weight, deltas) in list {
            let Some(own) = deltas.and_then(pick).filter(|_| *weight != 0.0) else { continue };
            out.resize(own.len(), [0.0; 3]);
            add_scaled(out.as_flattened_mut(), *weight, own.as_flattened());
        }
        out
    };
    let positions = sum(|deltas| Some(&deltas.positions));
    // Without any they are those of the rest.
    LocalDeltas { positions, normals: Some(sum(|deltas| deltas.normals.as_ref())), tangents: None, stuck: 0 }
}

/// The largest of what was off.
pub(crate) fn worst(a: Off, b: Off) -> Off {
    let larger = if b.metres > a.metres { b } else { a };
    Off { radians: a.radians.max(b.radians), all: (a.all.0 + b.all.0, a.all.1 + b.all.1), ..larger }
}
