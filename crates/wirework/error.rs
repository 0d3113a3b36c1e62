//! What can go wrong between a preset and a file, and whose fault it is.

use std::path::PathBuf;

use thiserror::Error;
use wirework_asset::{AssetError, ErrorClass, printable};
use wirework_bake::map::MapError;
use wirework_bake::{BakeError, CacheError, VatError, VatNormals};
use wirework_core::BindError;
use wirework_preset::{ObjectError, PresetError, PresetErrorKind};
use wirework_render::{EncodeError, MAX_SIDE, RenderError};
use wirework_surface::{MeshError, NearestError, NormalsError, SubdivideError};
use wirework_wrinkle::WrinkleError;

use crate::{EvaluateError, ScheduleError};

/// Whose fault an error is; the command's exit codes are these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The work could not be finished: disk, memory, a bug. Exit code 1.
    Work,
    /// What was asked for. Exit code 2.
    Request,
    /// The input or another asset. Exit code 3.
    Asset,
    /// The preset. Exit code 4.
    Preset,
    /// A limit. Exit code 5.
    Limit,
}

/// Why an effect was not applied, or a picture not made. Nothing has been written then.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JobError {
    /// An asset cannot be read or written.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// A file that is neither glTF nor OBJ.
    #[error(
        "{}: found a file of unknown kind, expected a .glb, .gltf or .obj",
        printable(&.path.display().to_string())
    )]
    UnknownFile {
        /// The file.
        path: PathBuf,
    },
    /// The preset names no object and there is no input.
    #[error("the preset names no object to work on: give an input, or add `object: ..` to it")]
    NoObject,
    /// A name or an image that the preset asks for is not there, or cannot be used, or an effect does not fit the object through
    /// its own fault; with its place in the preset.
    #[error("{0}")]
    Preset(Box<PresetError>),
    /// The preset's object cannot be built.
    #[error("the preset's object cannot be built: {0}")]
    Object(#[from] ObjectError),
    /// A mesh is not consistent.
    #[error("the mesh is not consistent: {0}")]
    Mesh(#[from] MeshError),
    /// The moments asked for make no sense.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// The effect does not fit the object, through no fault of the preset.
    #[error("the effect cannot be applied: {0}")]
    Evaluate(#[from] EvaluateError),
    /// The effect does not fit the object in a file, through no fault of the preset.
    #[error("{}: the effect cannot be applied: {error}", printable(.file))]
    Unfit {
        /// The file.
        file: String,
        /// Why.
        error: EvaluateError,
    },
    /// The effect does not fit the object that its own preset brings along, through no fault of its own: a limit.
    #[error("the effect does not fit the preset's object: {0}")]
    OwnObject(EvaluateError),
    /// The effect throws a point out of the range of numbers.
    #[error("at {seconds} s the effect moves point {point} out of the range of 32-bit floats")]
    OutOfRange {
        /// Which point.
        point: usize,
        /// When.
        seconds: f64,
    },
    /// Normals cannot follow.
    #[error("the normals cannot be updated: {0}")]
    Normals(#[from] NormalsError),
    /// A surface cannot be made finer.
    #[error("the surface cannot be made finer: {0}")]
    Refine(#[from] SubdivideError),
    /// Maps cannot be made.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Maps would be larger than what may be held.
    #[error(
        "the maps take {bytes} bytes, more than the {limit} that are allowed: make smaller ones with `--size`, or raise the limit with \
         `--max-expanded-bytes`"
    )]
    MapSize {
        /// What they take.
        bytes: u64,
        /// What is allowed.
        limit: u64,
    },
    /// Nothing that maps are asked for has texture coordinates.
    #[error("{}: {found}, expected texture coordinates: a map needs them; unwrap the mesh, or choose a set with `--uv`", printable(.file))]
    NoTextureCoordinates {
        /// The model, or the preset that brings it along.
        file: String,
        /// The first mesh, and the set it lacks.
        found: String,
        /// Whether the object is made of numbers in the preset.
        own: bool,
    },
    /// Frames cannot be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A point cache would have too many points or frames.
    #[error(transparent)]
    Cache(#[from] CacheError),
    /// A texture would be too large.
    #[error("{0} ({less})", less = less(.0))]
    Vat(#[from] VatError),
    /// Frames that were kept on the disk cannot be read again.
    #[error("frames that were kept cannot be read again: {0}")]
    Store(String),
    /// The request does not fit itself or the input.
    #[error("{0}")]
    Request(String),
    /// A row of pictures would be too long.
    #[error(
        "{pictures} pictures in a row would be {width} pixels wide; at most {MAX_SIDE} are possible: take fewer, or smaller \
         ones with `--size`"
    )]
    Row {
        /// How many pictures.
        pictures: u32,
        /// Pixels across.
        width: u32,
    },
    /// A picture cannot be made.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture cannot be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// What is to be shown has no size, no area and no points.
    #[error(
        "{}: found nothing to see, expected a surface with an area, lines, or points that lie apart",
        printable(.file)
    )]
    NothingToSee {
        /// The model, or the preset that brings it along.
        file: String,
        /// Whether the object is made of numbers in the preset.
        own: bool,
    },
    /// There are warnings, and the request was to take them as errors.
    #[error("{} taken as errors, nothing was written", count(.0.len(), "warning"))]
    Strict(Vec<String>),
    /// The folder of the output is not there.
    #[error("{}: found no such folder, expected a folder to write into", printable(&.0.display().to_string()))]
    NoFolder(PathBuf),
    /// A file stands where the folder of the output is to be.
    #[error("{}: found a file, expected a folder to write into", printable(&.0.display().to_string()))]
    NotFolder(PathBuf),
    /// A pool of threads cannot be started.
    #[error("{0} threads cannot be started: {1}")]
    Threads(usize, String),
}

impl JobError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Asset(error) | Self::Bake(BakeError::Asset(error)) => of_asset(error),
            Self::UnknownFile { .. }
            | Self::Mesh(_)
            | Self::Strict(_)
            | Self::NoTextureCoordinates { own: false, .. }
            | Self::NothingToSee { own: false, .. } => Fault::Asset,
            Self::Evaluate(error) | Self::Unfit { error, .. } => of_evaluation(error),
            Self::OwnObject(error) => match of_evaluation(error) {
                Fault::Asset => Fault::Preset,
                other => other,
            },
            Self::Preset(error) if error.kind == PresetErrorKind::Limit => Fault::Limit,
            Self::NoObject
            | Self::Preset(_)
            | Self::Object(_)
            | Self::OutOfRange { .. }
            | Self::NothingToSee { own: true, .. }
            | Self::NoTextureCoordinates { own: true, .. }
            | Self::Bake(BakeError::Frame { .. }) => Fault::Preset,
            Self::Schedule(ScheduleError::TooMany { .. })
            | Self::Bake(BakeError::TooManyTargets { .. } | BakeError::Tolerance { .. })
            | Self::Refine(SubdivideError::TooMany { .. })
            | Self::Cache(_)
            | Self::Vat(_)
            | Self::MapSize { .. }
            | Self::Row { .. } => Fault::Limit,
            Self::Render(RenderError::Size { .. } | RenderError::Samples { .. } | RenderError::TooMany) => {
                Fault::Limit
            }
            Self::Schedule(_)
            | Self::Map(MapError::Range { .. })
            | Self::Request(_)
            | Self::Bake(BakeError::NoTolerance(_))
            | Self::Render(_)
            | Self::Encode(EncodeError::Fps { .. }) => Fault::Request,
            Self::Encode(_)
            | Self::Normals(_)
            | Self::Refine(_)
            | Self::Bake(_)
            | Self::Store(_)
            | Self::Map(_)
            | Self::NoFolder(_)
            | Self::NotFolder(_)
            | Self::Threads(..) => Fault::Work,
        }
    }
}

/// What makes less of a texture.
fn less(error: &VatError) -> &'static str {
    match error.normals {
        VatNormals::Packed => "`--frames`, a lower `--fps` or `--vat-normals separate` makes it less",
        VatNormals::Separate => "`--frames` or a lower `--fps` makes it less",
    }
}

fn of_asset(error: &AssetError) -> Fault {
    match error.class {
        ErrorClass::Limit => Fault::Limit,
        ErrorClass::Io => Fault::Work,
        _ => Fault::Asset,
    }
}

/// Whose fault it is that an effect does not fit an object from elsewhere.
pub(crate) fn of_evaluation(error: &EvaluateError) -> Fault {
    match error {
        // What stands below is the result of another effect.
        EvaluateError::Wrinkle {
            effect: 1..,
            error:
                WrinkleError::NoNormal { .. }
                | WrinkleError::NoNormalAtCenter
                | WrinkleError::NoArea
                | WrinkleError::Surface(NearestError::Vertex { .. }),
        } => Fault::Preset,
        // A point set, where the effect needs faces, or points at one place, where it needs an extent.
        EvaluateError::Wrinkle {
            error:
                WrinkleError::Surface(_)
                | WrinkleError::NoNormal { .. }
                | WrinkleError::NoNormalAtCenter
                | WrinkleError::NoArea,
            ..
        }
        | EvaluateError::NoExtent { .. }
        // It is a clip that poses it.
        | EvaluateError::Limb { .. } => Fault::Asset,
        EvaluateError::Bind { error: BindError::TooManyPoints(_), .. } => Fault::Limit,
        EvaluateError::Clip(error) => of_asset(error),
        EvaluateError::PointCount { .. } | EvaluateError::Scoped { .. } => Fault::Work,
        _ => Fault::Preset,
    }
}

/// `1 wire`, `2 wires`.
pub(crate) fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
