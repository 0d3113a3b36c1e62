//! The values of a clip's channels, with the `gltf` crate's reader.

use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf::animation::util::ReadOutputs;
use gltf::animation::{Interpolation, Property};

/// A clip at a time.
pub(super) struct Moment<'a> {
    pub(super) clip: Option<gltf::Animation<'a>>,
    pub(super) blob: &'a [u8],
    pub(super) seconds: f64,
    /// Whether nodes move too, or weights only.
    pub(super) nodes: bool,
}

impl Moment<'_> {
    /// The numbers of one property of a node, if the clip moves it.
    fn of(&self, node: usize, property: Property) -> Option<Vec<f64>> {
        let moves = |c: &gltf::animation::Channel<'_>| {
            c.target().node().index() == node && c.target().property() == property
        };
        let channel = self.clip.as_ref()?.channels().find(moves)?;
        let reader = channel.reader(|_| Some(self.blob));
        let times: Vec<f64> = reader.read_inputs()?.map(f64::from).collect();
        let values: Vec<f32> = match reader.read_outputs()? {
            ReadOutputs::Translations(values) | ReadOutputs::Scales(values) => values.flatten().collect(),
            ReadOutputs::Rotations(values) => values.into_f32().flatten().collect(),
            ReadOutputs::MorphTargetWeights(values) => values.into_f32().collect(),
        };
        let values: Vec<f64> = values.into_iter().map(f64::from).collect();
        Some(between(&times, &values, &channel, self.seconds))
    }

    pub(super) fn weights(&self, node: usize) -> Option<Vec<f32>> {
        Some(self.of(node, Property::MorphTargetWeights)?.into_iter().map(|w| w as f32).collect())
    }

    pub(super) fn local(&self, node: &gltf::Node<'_>) -> DMat4 {
        if let gltf::scene::Transform::Matrix { matrix } = node.transform() {
            return DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)));
        }
        let (translation, rotation, scale) = node.transform().decomposed();
        let value = |property, rest: &[f32]| {
            let played = if self.nodes { self.of(node.index(), property) } else { None };
            played.unwrap_or_else(|| rest.iter().map(|&x| f64::from(x)).collect())
        };
        let t = DVec3::from_slice(&value(Property::Translation, &translation));
        let q = DQuat::from_slice(&value(Property::Rotation, &rotation)).normalize();
        let s = DVec3::from_slice(&value(Property::Scale, &scale));
        DMat4::from_scale_rotation_translation(s, q, t)
    }
}

fn between(times: &[f64], values: &[f64], channel: &gltf::animation::Channel<'_>, seconds: f64) -> Vec<f64> {
    let interpolation = channel.sampler().interpolation();
    let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let lanes = values.len() / times.len() / parts;
    let at = |key: usize, part: usize| &values[(key * parts + part) * lanes..][..lanes];
    let last = times.len() - 1;
    let seconds = seconds.clamp(times[0], times[last]);
    let key = (0..=last).rev().find(|&key| times[key] <= seconds).unwrap_or(0);
    let (from, next) = (at(key, parts / 2), (key + 1).min(last));
    if next == key || interpolation == Interpolation::Step {
        return from.to_vec();
    }
    let (to, span) = (at(next, parts / 2), times[next] - times[key]);
    let x = (seconds - times[key]) / span;
    let mix = |a: f64, b: f64| (0..lanes).map(|k| a * from[k] + b * to[k]).collect();
    match interpolation {
        Interpolation::CubicSpline => {
            let (x2, x3) = (x * x, x * x * x);
            let (leave, arrive) = (at(key, 2), at(next, 0));
            let one = |k: usize| {
                (2.0 * x3 - 3.0 * x2 + 1.0) * from[k]
                    + span * (x3 - 2.0 * x2 + x) * leave[k]
                    + (3.0 * x2 - 2.0 * x3) * to[k]
                    + span * (x3 - x2) * arrive[k]
            };
            (0..lanes).map(one).collect()
        }
        _ if channel.target().property() == Property::Rotation => {
            let dot = DVec4::from_slice(from).normalize().dot(DVec4::from_slice(to).normalize());
            let angle = dot.abs().min(1.0).acos();
            if angle < 1e-9 {
                return mix(1.0 - x, dot.signum() * x);
            }
            mix(((1.0 - x) * angle).sin() / angle.sin(), dot.signum() * (x * angle).sin() / angle.sin())
        }
        _ => mix(1.0 - x, x),
    }
}
