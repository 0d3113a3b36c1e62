//! One sampler of a clip: values at times, and what is between them.

use glam::{DQuat, DVec3};

use crate::accessor::{Accessor, Component};
use crate::document::Gltf;
use crate::error::{AssetError, Warning};
use crate::graph::unit;
use crate::json::Json;
use crate::limits::Budget;

/// What a track moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Path {
    Translation,
    Rotation,
    Scale,
    /// The weights of so many morph targets.
    Weights(usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    /// Each key has an in-tangent, a value and an out-tangent.
    Cubic,
}

/// Values in time.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Seconds, at least one, not falling.
    times: Vec<f32>,
    /// Key after key; of a cubic track three values a key.
    values: Vec<f32>,
    /// Numbers of one value.
    lanes: usize,
    interpolation: Interpolation,
}

/// Where a time is among the keys.
enum At {
    /// On a key, or outside of all and so on the first or the last.
    Key(usize),
    /// Between a key and the next: what part of the way, and how many seconds it takes.
    Between(usize, f64, f64),
}

impl Track {
    /// Reads a sampler that moves `path`.
    pub(crate) fn read(
        gltf: &Gltf,
        sampler: Json<'_>,
        path: Path,
        budget: &mut Budget,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, AssetError> {
        let interpolation = match sampler.get("interpolation")? {
            None => Interpolation::Linear,
            Some(name) => match name.string()? {
                "STEP" => Interpolation::Step,
                "LINEAR" => Interpolation::Linear,
                "CUBICSPLINE" => Interpolation::Cubic,
                _ => return Err(name.fault("an interpolation: STEP, LINEAR or CUBICSPLINE")),
            },
        };
        let times = times(gltf, sampler.need("input")?, budget, warnings)?;
        let output = gltf.accessor(sampler.need("output")?)?;
        let lanes = path.lanes();
        let each = lanes.saturating_mul(interpolation.parts());
        // The accessor of weights has one element a weight, the others one a value.
        let elements = each / if matches!(path, Path::Weights(_)) { 1 } else { lanes };
        let expected = times.len().saturating_mul(elements);
        if output.count != expected {
            let expected = format!("{expected}, for {} keys", times.len());
            return Err(output.json.found(format!("{} elements", output.count), expected));
        }
        Ok(Self { times, values: values(&output, path, budget)?, lanes, interpolation })
    }

    /// The last key, seconds.
    pub(crate) fn end(&self) -> f64 {
        self.times.last().map_or(0.0, |&t| f64::from(t))
    }

    /// Whether there is more than one key.
    pub(crate) fn moves(&self) -> bool {
        self.times.len() > 1
    }

    /// The value at a time: as many numbers as `out` has.
    pub(crate) fn sample(&self, seconds: f64, out: &mut [f64]) {
        match (self.at(seconds), self.interpolation) {
            (At::Key(key) | At::Between(key, ..), Interpolation::Step) | (At::Key(key), _) => {
                out.iter_mut().enumerate().for_each(|(k, slot)| *slot = self.value(key, k));
            }
            (At::Between(key, x, _), Interpolation::Linear) => {
                for (k, slot) in out.iter_mut().enumerate() {
                    *slot = self.value(key, k) * (1.0 - x) + self.value(key + 1, k) * x;
                }
            }
            (At::Between(key, x, span), Interpolation::Cubic) => {
                let (x2, x3) = (x * x, x * x * x);
                let rise = 3.0 * x2 - 2.0 * x3;
                let (leave, arrive) = ((x3 - 2.0 * x2 + x) * span, (x3 - x2) * span);
                for (k, slot) in out.iter_mut().enumerate() {
                    *slot = (1.0 - rise) * self.value(key, k)
                        + leave * self.part(key, 2, k)
                        + rise * self.value(key + 1, k)
                        + arrive * self.part(key + 1, 0, k);
                }
            }
        }
    }

    /// The value of a track of three numbers.
    pub(crate) fn vector(&self, seconds: f64) -> DVec3 {
        let mut out = [0.0; 3];
        self.sample(seconds, &mut out);
        DVec3::from_array(out)
    }

    /// The value of a track of rotations: of length 1, and between two keys the shorter way.
    pub(crate) fn rotation(&self, seconds: f64) -> DQuat {
        let key = |key| unit(DQuat::from_array(std::array::from_fn(|k| self.value(key, k))));
        match self.at(seconds) {
            At::Between(from, x, _) if self.interpolation == Interpolation::Linear => {
                unit(key(from).slerp(key(from + 1), x))
            }
            _ => {
                let mut out = [0.0; 4];
                self.sample(seconds, &mut out);
                unit(DQuat::from_array(out))
            }
        }
    }

    fn at(&self, seconds: f64) -> At {
        let after = self.times.partition_point(|&t| f64::from(t) <= seconds);
        match (after.checked_sub(1), self.times.get(after)) {
            (None, _) => At::Key(0),
            (Some(last), None) => At::Key(last),
            (Some(key), Some(&next)) => {
                // The span is above 0: the one key is not after the time, the other is.
                let start = f64::from(self.times[key]);
                let span = f64::from(next) - start;
                At::Between(key, (seconds - start) / span, span)
            }
        }
    }

    /// Number `k` of the value of a key, which stands between its tangents where it has them.
    fn value(&self, key: usize, k: usize) -> f64 {
        self.part(key, self.interpolation.parts() / 2, k)
    }

    /// Number `k` of a value or tangent of a key.
    fn part(&self, key: usize, part: usize, k: usize) -> f64 {
        let at = (key * self.interpolation.parts() + part) * self.lanes + k;
        self.values.get(at).map_or(0.0, |&value| f64::from(value))
    }
}

impl Interpolation {
    /// How many values a key has.
    fn parts(self) -> usize {
        if self == Self::Cubic { 3 } else { 1 }
    }
}

impl Path {
    fn lanes(self) -> usize {
        match self {
            Self::Translation | Self::Scale => 3,
            Self::Rotation => 4,
            Self::Weights(targets) => targets,
        }
    }
}

fn times(
    gltf: &Gltf,
    reference: Json<'_>,
    budget: &mut Budget,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<f32>, AssetError> {
    let accessor = gltf.accessor(reference)?;
    if accessor.component != Component::F32 || accessor.lanes != 1 || accessor.normalized {
        return Err(accessor.json.found("an accessor of another type", "times: scalars of floats"));
    }
    let times = accessor.floats::<1>(budget)?.into_flattened();
    if let Some(i) = times.iter().position(|t| !t.is_finite()) {
        return Err(accessor.json.found(format!("element {i} is {}", times[i]), "finite numbers"));
    }
    let mut equal = 0_usize;
    for (i, pair) in times.windows(2).enumerate() {
        if pair[1] < pair[0] {
            let found = format!("element {} is {} after {}", i + 1, pair[1], pair[0]);
            return Err(accessor.json.found(found, "rising times"));
        }
        equal += usize::from(pair[1] == pair[0]);
    }
    if equal > 0 {
        let message = format!("{equal} keys are at the time of the one before; the last of them counts");
        warnings.push(Warning::new("key-times", accessor.json.place(), message));
    }
    Ok(times)
}

/// All numbers of an output.
fn values(output: &Accessor<'_>, path: Path, budget: &mut Budget) -> Result<Vec<f32>, AssetError> {
    let float = output.component == Component::F32 && !output.normalized;
    let small = output.normalized && !matches!(output.component, Component::F32 | Component::U32);
    let (typed, lanes, expected) = match path {
        Path::Translation | Path::Scale => (float, 3, "VEC3 of floats"),
        Path::Rotation => (float || small, 4, "VEC4 of floats or of normalised 8 or 16 bit integers"),
        Path::Weights(_) => (float || small, 1, "scalars of floats or of normalised 8 or 16 bit integers"),
    };
    if !typed || output.lanes != lanes {
        return Err(output.json.found("an accessor of another type", expected));
    }
    let values = match lanes {
        3 => output.floats::<3>(budget)?.into_flattened(),
        4 => output.floats::<4>(budget)?.into_flattened(),
        _ => output.floats::<1>(budget)?.into_flattened(),
    };
    match values.iter().position(|value| !value.is_finite()) {
        Some(i) => Err(output.json.found(format!("element {} is not finite", i / lanes), "finite numbers")),
        None => Ok(values),
    }
}
