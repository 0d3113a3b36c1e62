//! What can be wrong with a wrinkle, and what of it is less than was asked for.

use thiserror::Error;
use wirework_surface::NearestError;

use crate::settings::MOST_CREASES;

/// Why there are no creases.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WrinkleError {
    /// A setting is out of range.
    #[error("`{field}` must be {expected}, not {found}")]
    Value {
        /// Its name.
        field: &'static str,
        /// What it must be.
        expected: &'static str,
        /// A value it has or takes.
        found: f32,
    },
    /// There is nothing to wrinkle, or the surface refers to vertices that are not there.
    #[error(transparent)]
    Surface(#[from] NearestError),
    /// The creases are so many and so thin that following them all would take for ever.
    #[error(
        "creases of thickness {thickness} need {needed} spans in all, the most are {}: use a larger `thickness` or \
         fewer curves",
        crate::creases::MOST_SPANS
    )]
    TooFine {
        /// The least thickness.
        thickness: f32,
        /// Spans they would have.
        needed: usize,
    },
    /// All its faces are lines or points.
    #[error("the surface has no area")]
    NoArea,
    /// The creases are so long, or have gone so far, that walking over the surface would take for ever.
    #[error(
        "{lines} lines of {length} in length are too long for this surface: to follow them over it would take for ever"
    )]
    TooLong {
        /// Lines that were to be followed.
        lines: usize,
        /// The length of each.
        length: f32,
    },
    /// There are so many creases that laying them would take for ever.
    #[error("{creases} creases, branches included, are more than {MOST_CREASES}")]
    TooMany {
        /// Creases the pattern would have.
        creases: usize,
    },
    /// Nothing says where the surface is compressed.
    #[error("`pattern: Auto` looks for where the surface is compressed: it needs `drive: Strain(..)`")]
    Undriven,
    /// The surface does not move, so that it is nowhere compressed.
    #[error(
        "`pattern: Auto` looks for where the surface is compressed: it needs a model with a clip, or effects before it"
    )]
    Unmoved,
    /// What compression raises is read where creases lie, and these move.
    #[error("creases that `drive` raises stay where they are: they cannot travel or be keyed")]
    DrivenMoves,
    /// Creases that are to hang have no end to hang from.
    #[error(
        "creases of a curtain hang from their first end: closed ones, such as those of a ripple, have none"
    )]
    ClosedRopes,
    /// The pattern has no creases.
    #[error("a pattern needs at least one crease")]
    NoCreases,
    /// The centre of the pattern is farther off the surface than the pattern is large: it was made for something else.
    #[error("the center is {distance} off the surface, more than the size of the pattern, {size}")]
    CenterOff {
        /// Its distance from the surface.
        distance: f32,
        /// The pattern's larger extent.
        size: f32,
    },
    /// There is no outside at the centre of the pattern: only triangles without area.
    #[error("the surface has no normal at the center of the pattern")]
    NoNormalAtCenter,
    /// No crease of the pattern lies on the surface.
    #[error("no crease of the pattern has room on the surface; it ends before them")]
    NoRoom,
    /// The pattern has no curves.
    #[error("a drawn pattern needs at least one curve")]
    NoCurves,
    /// No point of a drawn curve comes as near to the surface as the curve is long: it was drawn for something else.
    #[error("curve {curve} is {length} long but nowhere nearer to the surface than {distance}")]
    TooFar {
        /// Which curve, from 0.
        curve: usize,
        /// Its least distance from the surface.
        distance: f32,
        /// Its length.
        length: f32,
    },
    /// A drawn curve becomes a point on the surface.
    #[error("curve {curve} comes down on the surface as a point")]
    Collapsed {
        /// Which curve, from 0.
        curve: usize,
    },
    /// There is no outside where a crease should rise: only triangles without area.
    #[error("the surface has no normal where crease {curve} lies")]
    NoNormal {
        /// Which crease, from 0.
        curve: usize,
    },
}

/// `once`, `3 times`.
fn times(n: usize) -> String {
    if n == 1 { "once".to_owned() } else { format!("{n} times") }
}

/// What is less than was asked for.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WrinkleWarning {
    /// The first axis has nothing along the surface.
    #[error(
        "`direction` stands upright on the surface at the center; the pattern lies along a coordinate axis [upright]"
    )]
    Upright,
    /// The pattern is larger than the surface.
    #[error("{outside} of {creases} creases lie beyond the surface and are left out [outside-surface]")]
    Outside {
        /// Creases that are left out.
        outside: usize,
        /// Creases of the pattern.
        creases: usize,
    },
    /// The pattern is larger than the surface.
    #[error("a border of the surface cuts creases short {} [border]", times(*ends))]
    Border {
        /// How many ends.
        ends: usize,
    },
    /// Creases have gone where the surface has no room for them.
    #[error(
        "from {seconds:.2} s on creases have left the surface, or shrunk to nothing, and are left out [gone]"
    )]
    Gone {
        /// The first moment that was worked out at which any had.
        seconds: f64,
    },
    /// The surface is not a manifold where creases run.
    #[error(
        "an edge where the surface is not a manifold (more than two faces, or two that disagree about the outside) cuts \
         creases short {} [non-manifold]",
        times(*ends)
    )]
    NonManifold {
        /// How many ends.
        ends: usize,
    },
    /// Rings end where the geodesics that they are the ends of have parted.
    #[error("geodesics from the center part, at a hole or a sharp rise, and rings end there {} [parted]", times(*ends))]
    Parted {
        /// How many ends.
        ends: usize,
    },
    /// The mesh is too coarse for the folds.
    #[error(
        "edges of {edge} are longer than a third of the thickness {thickness}: folds come out jagged; use a finer mesh, a larger `thickness`, or `refine: Auto` [coarse]"
    )]
    Coarse {
        /// The longest edge that a crease reaches.
        edge: f32,
        /// The least thickness.
        thickness: f32,
    },
    /// Faces that hang together with nothing a crease lies on are near it.
    #[error(
        "{points} vertices within reach of a crease belong to parts that do not hang together with the one it lies on; they stay where they are [apart]"
    )]
    Apart {
        /// How many.
        points: usize,
    },
}
