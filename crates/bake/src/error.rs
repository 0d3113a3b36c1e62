//! Why frames cannot be baked.

use thiserror::Error;
use wirework_asset::AssetError;

/// Why frames cannot be baked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The document cannot be edited.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// A mesh would need more targets than are allowed.
    #[error(
        "the mesh {mesh} needs more than {limit} morph targets ({own} are its own): {fit} of ours fit, which is \
             until frame {frame} at {seconds} s; lower the frame rate, bake fewer frames or raise the limit \
             (--max-targets)"
    )]
    TooManyTargets {
        /// The name of the mesh or its index, control characters escaped.
        mesh: String,
        /// The limit.
        limit: usize,
        /// How many targets the mesh has of its own.
        own: usize,
        /// How many of ours fit.
        fit: usize,
        /// The first frame that does not fit, from 0.
        frame: usize,
        /// Its time.
        seconds: f64,
    },
    /// A mesh would need more targets than are allowed to keep the tolerance.
    #[error(
        "the mesh {mesh} needs {need} to stay within {tolerance} of the diagonal, and {room} morph targets of ours fit ({own} are its own, {limit} \
         are allowed): {remedy}"
    )]
    Tolerance {
        /// The name of the mesh or its index, control characters escaped.
        mesh: String,
        /// What it needs, in words: of key poses, of a basis.
        need: String,
        /// The tolerance, as a part of the diagonal.
        tolerance: f64,
        /// How many of ours fit.
        room: usize,
        /// How many targets the mesh has of its own.
        own: usize,
        /// The limit.
        limit: usize,
        /// What would fit.
        remedy: String,
    },
    /// The tolerance is not a number above 0.
    #[error("the tolerance is a part of the diagonal, a number above 0, and not {0}")]
    NoTolerance(f64),
    /// A frame has another number of vertices than the rest.
    #[error("frame {frame} has {found} vertices, the rest {expected}")]
    VertexCount {
        /// Which frame, from 0; of joints, which key.
        frame: usize,
        /// Vertices of the frame.
        found: usize,
        /// Vertices of the rest.
        expected: usize,
    },
    /// A deformed vertex or the time of a frame is not a finite number, or times do not rise.
    #[error("frame {frame} {problem}")]
    Frame {
        /// Which frame, from 0; of joints, which key.
        frame: usize,
        /// What is wrong with it.
        problem: &'static str,
    },
}
