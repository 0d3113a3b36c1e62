//! Adding an animation: tracks of morph weights and of joints, in a clip of their own or in one that is there.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::document::Gltf;
use crate::edit::whole;
use crate::error::{AssetError, Place};
use crate::joint_track::{Curve, JointTrack, Values};

/// Where new channels go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Clip {
    /// Into a clip of their own, of this name.
    New(String),
    /// Into the clip of this index, so that viewers that play one clip play both.
    Into(usize),
}

/// The weights of one node's morph targets at all keys.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightTrack {
    /// The node.
    pub node: usize,
    /// The times of its keys, as [`Tracks::times`] are; none where they are those.
    pub times: Option<Vec<f32>>,
    /// At each key the weights of all targets of the node's mesh, one key after the other.
    pub weights: Vec<f32>,
}

/// What a clip gets. Tracks without keys of their own have the same ones; all are interpolated linearly, rotations on the sphere.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracks<'a> {
    /// The times of the keys: seconds, rising, from 0.
    pub times: &'a [f32],
    /// Tracks of morph weights, one a node.
    pub weights: &'a [WeightTrack],
    /// Tracks of the transforms of nodes, one a node.
    pub joints: &'a [JointTrack],
    /// A clip all of whose channels a *new* clip gets besides, so that a viewer that plays only the new one shows the whole motion:
    /// but for channels of what our tracks move. They refer to the same accessors. Of no account for [`Clip::Into`].
    pub source: Option<usize>,
}

/// A clip as it is continued.
struct Parts {
    samplers: Vec<Value>,
    channels: Vec<Value>,
}

impl Gltf {
    /// Adds tracks of morph weights, interpolated linearly, with keys at `times`: seconds, rising, from 0.
    ///
    /// # Errors
    ///
    /// Those of [`Gltf::add_tracks`].
    pub fn add_clip(&mut self, clip: &Clip, times: &[f32], tracks: &[WeightTrack]) -> Result<(), AssetError> {
        self.add_tracks(clip, &Tracks { times, weights: tracks, ..Tracks::default() }).map(|_| ())
    }

    /// Adds tracks of morph weights and of joints. Gives the index of the clip; none where there is nothing to add, and then no
    /// clip is.
    ///
    /// A property of a joint that never changes gets one key; none at all where it is what the node has anyway, and
    /// no channel of the clip moves it. In a clip that is there, a channel of the same property plays our track instead of its own,
    /// whose data stay. A node with a matrix gets the translation, rotation and scale that make it, since only those can be animated.
    ///
    /// # Errors
    ///
    /// A clip that is not there, or that moves the weights of one of the nodes already: a clip may hold one track of
    /// them. Times that do not rise from 0, two tracks of one node, as many values as there are no keys, numbers that are not finite,
    /// rotations without length, nodes that are not there or whose matrix is sheared.
    pub fn add_tracks(&mut self, clip: &Clip, tracks: &Tracks<'_>) -> Result<Option<usize>, AssetError> {
        self.append_tracks(clip, tracks).map_err(|error| error.in_file(&self.file))
    }

    /// The first clip that moves a node or one above it; none where all clips leave it where it is.
    pub fn clip_that_moves(&self, node: usize) -> Option<usize> {
        let mut line = vec![node];
        while let Some(above) = self.parent(line[line.len() - 1]).filter(|above| !line.contains(above)) {
            line.push(above);
        }
        let moves = |channel: &Value| {
            target_of(channel).is_some_and(|(node, path)| path != "weights" && line.contains(&node))
        };
        self.list("animations").iter().position(|clip| {
            clip.get("channels").and_then(Value::as_array).is_some_and(|channels| channels.iter().any(moves))
        })
    }

    fn append_tracks(&mut self, clip: &Clip, tracks: &Tracks<'_>) -> Result<Option<usize>, AssetError> {
        if tracks.times.is_empty() || (tracks.weights.is_empty() && tracks.joints.is_empty()) {
            return Ok(None);
        }
        check(tracks)?;
        let mut parts = match clip {
            Clip::Into(index) => {
                let parts = self.parts_of(*index)?;
                check_free(*index, &parts.channels, tracks.weights)?;
                parts
            }
            Clip::New(_) => match tracks.source {
                Some(source) => self.parts_of(source)?,
                None => Parts { samplers: Vec::new(), channels: Vec::new() },
            },
        };
        let moved: BTreeSet<(usize, &str)> = parts.channels.iter().filter_map(target_of).collect();
        let curves = self.joint_curves(tracks.times.len(), tracks.joints, &moved)?;
        if curves.is_empty() && tracks.weights.is_empty() {
            return Ok(None);
        }
        if let Clip::New(_) = clip {
            let ours = curves.iter().map(|curve| (curve.node, curve.path));
            let ours = ours.chain(tracks.weights.iter().map(|track| (track.node, "weights")));
            parts = parts.without(&ours.collect());
        }
        self.write_tracks(&mut parts, tracks, curves)?;
        let index = match clip {
            Clip::Into(index) => *index,
            Clip::New(name) => self.append("animations", json!({ "name": name }))?,
        };
        let animation = self.entry_mut("animations", index)?;
        animation.insert("channels".to_owned(), Value::Array(parts.channels));
        animation.insert("samplers".to_owned(), Value::Array(parts.samplers));
        Ok(Some(index))
    }

    fn write_tracks(
        &mut self,
        parts: &mut Parts,
        tracks: &Tracks<'_>,
        curves: Vec<Curve>,
    ) -> Result<(), AssetError> {
        // What never changes has its only key where all others begin.
        let starts = |constant: bool| if constant { &tracks.times[..1] } else { tracks.times };
        let mut inputs = [None, None];
        let mut input = |gltf: &mut Self, constant: bool| -> Result<usize, AssetError> {
            let slot = &mut inputs[usize::from(constant)];
            let known = match *slot {
                Some(known) => known,
                None => gltf.append_scalars(starts(constant).to_vec(), true)?,
            };
            *slot = Some(known);
            Ok(known)
        };
        let mut own_inputs: Vec<(&[f32], usize)> = Vec::new();
        for track in tracks.weights {
            let known = track.times.as_ref().map(|own| own_inputs.iter().find(|(times, _)| times == own));
            let input = match (&track.times, known) {
                (None, _) => input(self, false)?,
                (Some(_), Some(Some((_, known)))) => *known,
                (Some(own), _) => {
                    let new = self.append_scalars(own.clone(), true)?;
                    own_inputs.push((own, new));
                    new
                }
            };
            let output = self.append_scalars(track.weights.clone(), false)?;
            parts.play(track.node, "weights", input, output);
        }
        for Curve { node, path, values, constant } in curves {
            let input = input(self, constant)?;
            let output = match values {
                Values::Vectors(values) => self.append_tuples(values, "VEC3")?,
                Values::Rotations(values) => self.append_tuples(values, "VEC4")?,
            };
            self.unfold_matrix(node)?;
            parts.play(node, path, input, output);
        }
        Ok(())
    }

    /// Samplers and channels of a clip, as they are.
    fn parts_of(&self, clip: usize) -> Result<Parts, AssetError> {
        let clips = self.list("animations");
        let Some(animation) = clips.get(clip) else {
            let found = format!("{} clips", clips.len());
            return Err(AssetError::new(
                Place::Pointer("/animations".into()),
                found,
                format!("a clip {clip}"),
            ));
        };
        let list = |key: &str| {
            animation.get(key).and_then(Value::as_array).cloned().ok_or_else(|| {
                AssetError::new(
                    Place::Pointer(format!("/animations/{clip}/{key}")),
                    "a value of another kind",
                    "an array",
                )
            })
        };
        let parts = Parts { samplers: list("samplers")?, channels: list("channels")? };
        for (k, channel) in parts.channels.iter().enumerate() {
            if sampler_of(channel).is_none_or(|sampler| sampler >= parts.samplers.len()) {
                let place = Place::Pointer(format!("/animations/{clip}/channels/{k}"));
                return Err(AssetError::new(
                    place,
                    "a channel without a sampler",
                    "one of the clip's samplers",
                ));
            }
        }
        Ok(parts)
    }
}

impl Parts {
    /// Without the channels of what is `replaced`, and without samplers that no channel uses then.
    fn without(mut self, replaced: &BTreeSet<(usize, &str)>) -> Self {
        self.channels.retain(|channel| target_of(channel).is_none_or(|target| !replaced.contains(&target)));
        let mut places = vec![None; self.samplers.len()];
        let mut samplers = Vec::new();
        for channel in &mut self.channels {
            let Some(sampler) = sampler_of(channel) else { continue };
            let place = *places[sampler].get_or_insert_with(|| {
                samplers.push(self.samplers[sampler].clone());
                samplers.len() - 1
            });
            channel["sampler"] = json!(place);
        }
        Self { samplers, channels: self.channels }
    }

    /// Has a property of a node moved by a new sampler: by the channel that it has already, else by a new one.
    fn play(&mut self, node: usize, path: &str, input: usize, output: usize) {
        let sampler = self.samplers.len();
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        match self.channels.iter_mut().find(|channel| target_of(channel) == Some((node, path))) {
            Some(channel) => channel["sampler"] = json!(sampler),
            None => {
                self.channels.push(json!({ "sampler": sampler, "target": { "node": node, "path": path } }));
            }
        }
    }
}

fn sampler_of(channel: &Value) -> Option<usize> {
    whole(channel.get("sampler")?)
}

/// The node and the property that a channel moves, by the standard's own target or by `KHR_animation_pointer`.
pub(crate) fn target_of(channel: &Value) -> Option<(usize, &str)> {
    let target = channel.get("target")?;
    if let Some(pointer) = target.pointer("/extensions/KHR_animation_pointer/pointer") {
        let (node, path) = pointer.as_str()?.strip_prefix("/nodes/")?.split_once('/')?;
        return Some((node.parse().ok()?, path));
    }
    Some((whole(target.get("node")?)?, target.get("path")?.as_str()?))
}

fn check(tracks: &Tracks<'_>) -> Result<(), AssetError> {
    let fault = |found: String, expected: &str| Err(AssetError::file(found, expected));
    for times in tracks.weights.iter().filter_map(|track| track.times.as_deref()).chain([tracks.times]) {
        let mut before = None;
        for &time in times {
            if !(time.is_finite() && time >= 0.0 && before.is_none_or(|before| before < time)) {
                return fault(format!("a key at {time} s"), "finite times that rise from 0");
            }
            before = Some(time);
        }
    }
    let (mut with_weights, mut joints) = (BTreeSet::new(), BTreeSet::new());
    let again = tracks.weights.iter().map(|track| track.node).find(|&node| !with_weights.insert(node));
    let again =
        again.or_else(|| tracks.joints.iter().map(|track| track.node).find(|&node| !joints.insert(node)));
    match again {
        Some(node) => fault(format!("two tracks of node {node}"), "one track a node"),
        None => Ok(()),
    }
}

fn check_free(clip: usize, channels: &[Value], tracks: &[WeightTrack]) -> Result<(), AssetError> {
    for (k, channel) in channels.iter().enumerate() {
        let Some((node, "weights")) = target_of(channel) else { continue };
        if tracks.iter().any(|track| track.node == node) {
            return Err(AssetError::new(
                Place::Pointer(format!("/animations/{clip}/channels/{k}")),
                "a track of the weights of a node that the effect moves",
                "a clip without one: put the effect into a clip of its own",
            ));
        }
    }
    Ok(())
}
