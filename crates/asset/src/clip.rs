//! Adding an animation of morph weights.

use serde_json::{Value, json};

use crate::document::Gltf;
use crate::edit::whole;
use crate::error::{AssetError, Place};

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
    /// At each key the weights of all targets of the node's mesh, one key after the other.
    pub weights: Vec<f32>,
}

impl Gltf {
    /// Adds tracks of morph weights, interpolated linearly, with keys at `times`: seconds, rising, from 0.
    ///
    /// # Errors
    ///
    /// A clip that is not there, or that moves the weights of one of the nodes already: a clip may hold one track of
    /// them.
    pub fn add_clip(&mut self, clip: &Clip, times: &[f32], tracks: &[WeightTrack]) -> Result<(), AssetError> {
        let file = self.file.clone();
        self.append_clip(clip, times, tracks).map_err(|error| error.in_file(&file))
    }

    fn append_clip(&mut self, clip: &Clip, times: &[f32], tracks: &[WeightTrack]) -> Result<(), AssetError> {
        if tracks.is_empty() || times.is_empty() {
            return Ok(());
        }
        if let Clip::Into(index) = clip {
            self.check_free(*index, tracks)?;
        }
        let input = self.append_scalars(times.to_vec(), true)?;
        let mut outputs = Vec::with_capacity(tracks.len());
        for track in tracks {
            outputs.push(self.append_scalars(track.weights.clone(), false)?);
        }
        let index = match clip {
            Clip::Into(index) => *index,
            Clip::New(name) => {
                self.append("animations", json!({ "name": name, "channels": [], "samplers": [] }))?
            }
        };
        let animation = self.entry_mut("animations", index)?;
        let malformed = |key: &str| {
            AssetError::new(
                Place::Pointer(format!("/animations/{index}/{key}")),
                "a value of another kind",
                "an array",
            )
        };
        let samplers = animation
            .get_mut("samplers")
            .and_then(Value::as_array_mut)
            .ok_or_else(|| malformed("samplers"))?;
        let first = samplers.len();
        for &output in &outputs {
            samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        }
        let channels = animation
            .get_mut("channels")
            .and_then(Value::as_array_mut)
            .ok_or_else(|| malformed("channels"))?;
        for (k, track) in tracks.iter().enumerate() {
            channels
                .push(json!({ "sampler": first + k, "target": { "node": track.node, "path": "weights" } }));
        }
        Ok(())
    }

    fn check_free(&self, clip: usize, tracks: &[WeightTrack]) -> Result<(), AssetError> {
        let Some(animation) = self.list("animations").get(clip) else {
            let found = format!("{} clips", self.list("animations").len());
            return Err(AssetError::new(
                Place::Pointer("/animations".into()),
                found,
                format!("a clip {clip}"),
            ));
        };
        let channels = animation.get("channels").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        for (k, channel) in channels.iter().enumerate() {
            let target = channel.get("target");
            let path = target.and_then(|target| target.get("path")?.as_str());
            let node = target.and_then(|target| target.get("node")).and_then(whole);
            if path == Some("weights") && tracks.iter().any(|track| Some(track.node) == node) {
                return Err(AssetError::new(
                    Place::Pointer(format!("/animations/{clip}/channels/{k}")),
                    "a track of the weights of a node that the effect moves",
                    "a clip without one: put the effect into a clip of its own",
                ));
            }
        }
        Ok(())
    }
}
