//! Objects that a preset brings along: primitives, patches, points, or a file.

mod read;

use std::path::{Path, PathBuf};

use thiserror::Error;
use wirework_surface::{Mesh, Patch, PatchError, PrimitiveError, Transform, TransformError};

pub(crate) use self::read::{object, within_limit};

/// What a preset is shown on where the command line names no input.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// What it is.
    pub shape: Shape,
    /// Where it stands.
    pub transform: Transform,
}

/// The kinds of objects. Sizes are metres; vertex orders are documented at the functions of `wirework-surface`.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A flat rectangle about the origin.
    Grid {
        /// Along its first and its second side.
        size: [f32; 2],
        /// Quads along each side. Default 32 × 32.
        cells: [u32; 2],
        /// Where it faces. Default +Y: its sides then are along X and Z.
        normal: [f32; 3],
    },
    /// A cylinder.
    Tube {
        /// Centre of the first ring.
        from: [f32; 3],
        /// Centre of the last ring.
        to: [f32; 3],
        /// Its radius.
        radius: f32,
        /// Vertices of a ring. Default 32.
        sides: u32,
        /// Rings, both ends included. Default 33.
        rings: u32,
        /// Whether its ends are closed. Default true.
        caps: bool,
    },
    /// A sphere by latitude and longitude.
    Sphere {
        /// Its centre. Default the origin.
        center: [f32; 3],
        /// Its radius.
        radius: f32,
        /// Segments round Y and from pole to pole. Default 64 and 32.
        segments: [u32; 2],
    },
    /// A box.
    Box {
        /// The corner with the least coordinates.
        min: [f32; 3],
        /// The opposite corner.
        max: [f32; 3],
        /// Quads along each axis. Default 8 each.
        cells: [u32; 3],
    },
    /// Points without faces.
    Points(Vec<[f32; 3]>),
    /// A tensor-product B-spline surface.
    Patch {
        /// Its control net. Default degree 3 both ways.
        patch: Patch,
        /// Quads along `u` and `v`. Default 32 × 32.
        tessellation: [u32; 2],
        /// What an effect moves. Default the points of the surface.
        deform: PatchDeform,
    },
    /// A file of its own; as typed, relative to the preset.
    File(PathBuf),
}

/// What an effect moves of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchDeform {
    /// The points of the tessellated surface.
    #[default]
    Points,
    /// The control points; the surface they make is tessellated afterwards.
    ControlPoints,
}

/// Why an object cannot be built although each of its values is good: what `f32` makes of them together, a radius
/// added to a far centre for instance.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ObjectError {
    /// A primitive.
    #[error(transparent)]
    Primitive(#[from] PrimitiveError),
    /// A patch.
    #[error(transparent)]
    Patch(#[from] PatchError),
    /// Its placement.
    #[error(transparent)]
    Transform(#[from] TransformError),
}

/// How large an object is once it is built, known before anything of it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectSize {
    /// Vertices as a renderer counts them, those of seams and hard edges once for each side. At most so many.
    pub vertices: u64,
    /// Indices of its triangles. At most so many.
    pub indices: u64,
}

impl Shape {
    /// How large it will be. 0 for a file, which says so itself.
    pub fn size(&self) -> ObjectSize {
        let product = |a: u32, b: u32| u64::from(a).saturating_mul(u64::from(b));
        // Vertices and quads of a sheet of cells.
        let sheet = |a: u32, b: u32| [product(a.saturating_add(1), b.saturating_add(1)), product(a, b)];
        let [vertices, quads] = match self {
            Self::Grid { cells: [a, b], .. }
            | Self::Sphere { segments: [a, b], .. }
            | Self::Patch { tessellation: [a, b], .. } => sheet(*a, *b),
            Self::Tube { sides, rings, caps, .. } => {
                let [vertices, quads] = sheet(*sides, rings.saturating_sub(1));
                // A cap is a fan: half a quad, a vertex of the rim and the centre.
                let caps = if *caps { u64::from(*sides) } else { 0 };
                [vertices.saturating_add(2 * (caps + 1)), quads.saturating_add(caps)]
            }
            Self::Box { cells: [l, m, n], .. } => {
                let sides = [sheet(*l, *m), sheet(*m, *n), sheet(*n, *l)];
                [0, 1]
                    .map(|i| sides.iter().fold(0, |sum: u64, side| sum.saturating_add(side[i])))
                    .map(|half| half.saturating_mul(2))
            }
            Self::Points(points) => [points.len() as u64, 0],
            Self::File(_) => [0, 0],
        };
        ObjectSize { vertices, indices: quads.saturating_mul(6) }
    }
}

impl Object {
    /// The file to read, for an object that is one; `preset_dir` is the folder of the preset.
    pub fn file(&self, preset_dir: &Path) -> Option<PathBuf> {
        match &self.shape {
            Shape::File(path) => Some(preset_dir.join(path)),
            _ => None,
        }
    }

    /// The object as a mesh where it stands. `None` for a file: reading that, and placing it by
    /// [`Object::transform`], is the caller's.
    pub fn build(&self) -> Result<Option<Mesh>, ObjectError> {
        let mut mesh = match &self.shape {
            Shape::Grid { size, cells, normal } => wirework_surface::grid(*size, *cells, *normal)?,
            Shape::Tube { from, to, radius, sides, rings, caps } => {
                wirework_surface::tube(*from, *to, *radius, *sides, *rings, *caps)?
            }
            Shape::Sphere { center, radius, segments } => {
                wirework_surface::sphere(*center, *radius, *segments)?
            }
            Shape::Box { min, max, cells } => wirework_surface::cuboid(*min, *max, *cells)?,
            Shape::Points(points) => Mesh { positions: points.clone(), ..Mesh::default() },
            Shape::Patch { patch, tessellation, .. } => patch.tessellate(*tessellation)?,
            Shape::File(_) => return Ok(None),
        };
        self.transform.apply_to_mesh(&mut mesh)?;
        Ok(Some(mesh))
    }
}
