//! What can be wrong with a stitch, and what of it is less than was asked for.

use thiserror::Error;

use crate::settings::SeamSide;

/// Why there are no seams. Seams count from 0, in the order in which they are written.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StitchError {
    /// There is nothing to sew.
    #[error("a stitch needs at least one seam")]
    NoSeams,
    /// A setting of a seam is out of range.
    #[error("`{field}` must be {expected}, not {found}")]
    Value {
        /// The seam.
        seam: usize,
        /// The tear, for a setting of one.
        tear: Option<usize>,
        /// Its name.
        field: &'static str,
        /// What it must be.
        expected: &'static str,
        /// A value it has or takes.
        found: f32,
    },
    /// What is wrong with one edge of a seam.
    #[error("{fault}")]
    Edge {
        /// The seam.
        seam: usize,
        /// Which of its edges.
        side: SeamSide,
        /// What is wrong.
        fault: EdgeFault,
    },
    /// One edge goes all round, the other has ends.
    #[error("one edge is a whole loop, the other has two ends: both must be the one or the other")]
    LoopAndRun {
        /// The seam.
        seam: usize,
    },
    /// Both edges are one.
    #[error("both edges run along the same border: a seam needs two")]
    Itself {
        /// The seam.
        seam: usize,
    },
    /// Two seams take the same stretch of a border.
    #[error(
        "this seam and seam {other} share more than ends of the border of one piece: a border can be sewn once only"
    )]
    Crossing {
        /// The later of the two.
        seam: usize,
        /// The earlier.
        other: usize,
    },
}

/// What can be wrong with an edge.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EdgeFault {
    /// There is no piece of its number.
    #[error("there is no piece {0}")]
    NoPiece(usize),
    /// The piece has no sides that could be named.
    #[error(
        "only patches and grids of a preset have the sides `UMin`, `UMax`, `VMin`, `VMax`; of tubes, files and nodes name points of the \
         border instead"
    )]
    NoSides,
    /// The piece has no faces, or is closed.
    #[error("the piece has no border: no edge of it has a face on one side only")]
    NoBorder,
    /// A point is too far from every border to say which vertex is meant.
    #[error(
        "`{field}` is {distance:.3} off the border of the piece, whose nearest vertex is at ({}, {}, {}): no boundary runs here",
        nearest[0], nearest[1], nearest[2]
    )]
    OffBorder {
        /// The field: `from`, `to` or `loop`.
        field: &'static str,
        /// Its distance from the border.
        distance: f32,
        /// The nearest vertex of a border.
        nearest: [f32; 3],
    },
    /// The two ends are not on one loop.
    #[error("`from` and `to` lie on two borders that do not hang together")]
    Apart,
    /// The two ends are one vertex.
    #[error(
        "`from` and `to` are nearest to the same vertex of the border: the edge has no length; `loop` takes all of a border"
    )]
    OneEnd,
    /// All its vertices are in one place.
    #[error("the edge has no length")]
    NoLength,
    /// Three or more runs of border meet in a vertex of it, so that there is no one way on.
    #[error("the border branches at ({}, {}, {}), so that it has no one way on", at[0], at[1], at[2])]
    Branches {
        /// Where.
        at: [f32; 3],
    },
}

impl StitchError {
    /// Where in the settings it stands, as a path of fields: `seams[1].b.from`.
    pub fn path(&self) -> String {
        match self {
            Self::NoSeams => "seams".to_owned(),
            Self::Value { seam, tear: Some(tear), field, .. } => {
                format!("seams[{seam}].tears[{tear}].{field}")
            }
            Self::Value { seam, tear: None, field, .. } => format!("seams[{seam}].{field}"),
            Self::Edge { seam, side, fault } => {
                let field = match fault {
                    EdgeFault::NoPiece(_) => ".piece",
                    EdgeFault::NoSides => ".side",
                    EdgeFault::OffBorder { field, .. } => &format!(".{field}"),
                    _ => "",
                };
                format!("seams[{seam}].{}{field}", side.name())
            }
            Self::LoopAndRun { seam } | Self::Itself { seam } | Self::Crossing { seam, .. } => {
                format!("seams[{seam}]")
            }
        }
    }
}

/// What is less than was asked for.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StitchWarning {
    /// Vertices of one side meet an edge of the other, not a vertex.
    #[error(
        "seam {seam} has {vertices} vertices that meet an edge of the other side, not a vertex: hairline cracks, of up to {widest:.1e}, can show; \
         `weld: true` gives both sides the same vertices [t-junction]"
    )]
    Junctions {
        /// The seam.
        seam: usize,
        /// How many vertices.
        vertices: usize,
        /// The widest crack, were the seam shut at 0 s; where it is straight, rounding.
        widest: f32,
    },
}
