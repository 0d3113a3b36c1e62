//! What a picture cannot be made of.

use thiserror::Error;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A side is 0 or above [`MAX_SIDE`](crate::MAX_SIDE).
    #[error("a picture of {width}×{height} pixels: each side must be 1 to {} pixels", crate::MAX_SIDE)]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// Width × height × samples × samples is above [`MAX_SAMPLES`](crate::MAX_SAMPLES).
    #[error(
        "a picture of {width}×{height} pixels with {samples}×{samples} samples each is too large: width × height may be at \
         most {}",
        crate::MAX_SAMPLES / u64::from((samples * samples).max(1))
    )]
    Samples {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Samples a pixel, along each side.
        samples: u32,
    },
    /// The number of samples along a pixel's side is not 1 to 4.
    #[error("{samples}×{samples} samples a pixel: 1 to 4 along each side are possible")]
    SamplesPerPixel {
        /// What was asked for.
        samples: u32,
    },
    /// The camera stands nowhere, looks nowhere or has no angle of view.
    #[error("the camera's {what}")]
    Camera {
        /// What is wrong, as the end of a sentence.
        what: &'static str,
    },
    /// A box to be framed that is empty, without size or not finite.
    #[error(
        "there is nothing to frame: the bounds from {min:?} to {max:?} are empty, without size or not finite"
    )]
    Bounds {
        /// The least coordinates.
        min: [f32; 3],
        /// The greatest coordinates.
        max: [f32; 3],
    },
    /// A setting of the light is negative, NaN or infinite.
    #[error("the light's {what} is {value}; it must be a finite number, 0 or more")]
    Light {
        /// The field.
        what: &'static str,
        /// Its value.
        value: f32,
    },
    /// A coordinate or colour is NaN or infinite.
    #[error("{what} {index} of {owner} {number} is not finite")]
    NotFinite {
        /// `"part"`, `"line"`, or `"dots"`.
        owner: &'static str,
        /// Which one, from 0.
        number: usize,
        /// `"position"`, `"texture coordinate"`, `"vertex colour"`, `"colour component"` or
        /// `"cutoff"`.
        what: &'static str,
        /// Which one, from 0.
        index: usize,
    },
    /// A position so far from what the camera looks at that it cannot be told from infinity.
    #[error("position {index} of {owner} {number} is more than {} pictures' heights away", crate::FARTHEST)]
    TooFar {
        /// `"part"`, `"line"`, or `"dots"`.
        owner: &'static str,
        /// Which one, from 0.
        number: usize,
        /// Which position, from 0.
        index: usize,
    },
    /// A list of a part that must be empty or as long as its positions is neither.
    #[error("part {part} has {positions} positions but {count} {what}")]
    Count {
        /// The part, from 0.
        part: usize,
        /// `"normals"`, `"texture coordinates"` or `"colours"`.
        what: &'static str,
        /// How many.
        count: usize,
        /// The number of positions.
        positions: usize,
    },
    /// A triangle refers to a vertex that is not there.
    #[error("triangle {triangle} of part {part} refers to vertex {vertex}, but there are {positions}")]
    Index {
        /// The part, from 0.
        part: usize,
        /// The triangle, from 0.
        triangle: usize,
        /// The index that was used.
        vertex: u32,
        /// The number of positions.
        positions: usize,
    },
    /// More triangles or vertices than 32 bits count.
    #[error("the scene has more than {} triangles or vertices", u32::MAX - 1)]
    TooMany,
    /// A texture's sides do not go with its pixels.
    #[error("a texture of {width}×{height} pixels cannot have {pixels} of them")]
    Texture {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels given.
        pixels: usize,
    },
}
