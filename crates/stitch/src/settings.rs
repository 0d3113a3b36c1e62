//! What a stitch is, as a preset says it.

use wirework_core::{Density, Keyed};

use crate::StitchError;

/// The settings of a stitch. Lengths are in the unit of the surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stitch {
    /// The seams, each between two edges.
    pub seams: Vec<Seam>,
    /// Whether they are solved together. Default [`Order::Simultaneous`].
    pub order: Order,
}

/// How several seams are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Together: where seams meet they have one point, and the result does not depend on the order in which they are written.
    #[default]
    Simultaneous,
    /// One after the other, each on the result of those before: \[SF98\] §5.2.
    Sequential,
}

/// Two edges that are drawn to a common curve. [`Seam::new`] has the defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// The one edge.
    pub a: Edge,
    /// The other.
    pub b: Edge,
    /// Which end of `b` belongs to the first end of `a`. Default [`Reversed::Auto`].
    pub reversed: Reversed,
    /// Where the common seam lies: 0 on the edge of `a`, 1 on that of `b`. Default 0.5.
    pub bias: Keyed<f32>,
    /// 0 apart, 1 stitched. A seam that is apart is as none. Default 1.
    pub closure: Keyed<f32>,
    /// How far from each edge its surface follows, > 0. Default 0.4.
    pub radius: Keyed<f32>,
    /// Radial scale about each edge. Default 1.
    pub scale: Keyed<f32>,
    /// How the surfaces follow. Default the paper's quartic.
    pub density: Density,
    /// Which points of the edges belong together. Default [`Pairing::ArcLength`].
    pub pairing: Pairing,
    /// Where it is open. Default nowhere.
    pub tears: Vec<Tear>,
    /// How the surfaces meet. Default [`Continuity::Position`].
    pub continuity: Continuity,
    /// Whether the result is one surface along the seam: each side has a vertex wherever the other does, and normals are shared.
    /// Default no.
    pub weld: bool,
}

/// A run along the border of a piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The piece, by its number.
    pub piece: usize,
    /// Which part of its border.
    pub run: Run,
}

/// Part of a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Run {
    /// One of the four sides of a patch or a grid, in the direction in which `u` or `v` grows.
    Side(Side),
    /// From one point of a border to another; each end is the border's vertex nearest to what is given.
    Between {
        /// Where it begins.
        from: [f32; 3],
        /// Where it ends.
        to: [f32; 3],
        /// The longer of the two ways round. Default the shorter.
        long: bool,
    },
    /// The whole border loop that is nearest to a point, from its nearest vertex on, in the direction in which its faces go round.
    Loop([f32; 3]),
}

/// A side of a patch `(u, v)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// `u = 0`.
    UMin,
    /// `u = 1`.
    UMax,
    /// `v = 0`.
    VMin,
    /// `v = 1`.
    VMax,
}

/// Which end belongs to which.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reversed {
    /// The pairing with less twist: the points that belong together are nearer to each other, by the sum of the squares of their
    /// distances.
    #[default]
    Auto,
    /// As the edges run, or just the other way.
    Given(bool),
}

/// \[SF98\] §5.2: how two edges get a common parameter, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pairing {
    /// The fraction of arc length.
    #[default]
    ArcLength,
    /// Each edge from vertex to vertex alike: on a side of a patch its own `u` or `v`.
    Parameter,
    /// Each point of `a` with the nearest one of `b`, as far as they follow in order; ends belong to ends. `a` has the fraction of
    /// its arc length.
    Closest,
}

/// How surfaces meet at a seam.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Continuity {
    /// In position.
    #[default]
    Position,
    /// With a common tangent plane, too.
    Tangent,
}

/// A tear: a stretch of a seam that is open. [`Tear::new`] has the defaults.
///
/// It multiplies the closure of the seam by `1 − opening·(1 − x²)²`, `x` the distance from `at` in halves of `width`; where several
/// tears overlap, each does, and edges gape as by the one that draws them most.
#[derive(Clone, Debug, PartialEq)]
pub struct Tear {
    /// Its middle, as a fraction of the seam, 0 to 1.
    pub at: Keyed<f32>,
    /// All of its width, as a fraction of the seam, 0 or greater.
    pub width: Keyed<f32>,
    /// 0 shut, 1 open: the edges are in its middle where they are at rest. Default 1.
    pub opening: Keyed<f32>,
    /// How far each edge is drawn into its own surface besides, where the tear is open. Default 0.
    pub gape: Keyed<f32>,
    /// How much of the width is as open as the middle, 0 to 1: `x` counts from the end of that part. Default 0.
    pub plateau: Keyed<f32>,
}

impl Seam {
    /// A seam between two edges, everything else as by default.
    pub fn new(a: Edge, b: Edge) -> Self {
        Self {
            a,
            b,
            reversed: Reversed::default(),
            bias: Keyed::Constant(0.5),
            closure: Keyed::Constant(1.0),
            radius: Keyed::Constant(0.4),
            scale: Keyed::Constant(1.0),
            density: Density::Quartic,
            pairing: Pairing::default(),
            tears: Vec::new(),
            continuity: Continuity::default(),
            weld: false,
        }
    }

    /// The edge of `a` or that of `b`.
    pub fn edge(&self, end: SeamSide) -> &Edge {
        match end {
            SeamSide::A => &self.a,
            SeamSide::B => &self.b,
        }
    }
}

/// One of the two edges of a seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SeamSide {
    /// The edge `a`.
    A,
    /// The edge `b`.
    B,
}

impl SeamSide {
    /// The field of the seam that it is.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::B => "b",
        }
    }
}

impl Tear {
    /// A tear that is open, everything else as by default.
    pub fn new(at: f32, width: f32) -> Self {
        Self {
            at: Keyed::Constant(at),
            width: Keyed::Constant(width),
            opening: Keyed::Constant(1.0),
            gape: Keyed::Constant(0.0),
            plateau: Keyed::Constant(0.0),
        }
    }
}

impl Stitch {
    /// Refuses values out of range, and a stitch without seams.
    pub fn check(&self) -> Result<(), StitchError> {
        if self.seams.is_empty() {
            return Err(StitchError::NoSeams);
        }
        for (index, seam) in self.seams.iter().enumerate() {
            let fail = |tear| {
                move |(field, expected, found)| StitchError::Value {
                    seam: index,
                    tear,
                    field,
                    expected,
                    found,
                }
            };
            seam.check().map_err(fail(None))?;
            for (number, tear) in seam.tears.iter().enumerate() {
                tear.check().map_err(fail(Some(number)))?;
            }
        }
        Ok(())
    }
}

/// A field, what it must be, what was found.
type Misfit = (&'static str, &'static str, f32);

fn within(
    field: &'static str,
    values: &Keyed<f32>,
    expected: &'static str,
    good: fn(f32) -> bool,
) -> Result<(), Misfit> {
    values.values().find(|found| !good(**found)).map_or(Ok(()), |&found| Err((field, expected, found)))
}

fn unit(field: &'static str, values: &Keyed<f32>) -> Result<(), Misfit> {
    within(field, values, "between 0 and 1", |x| (0.0..=1.0).contains(&x))
}

impl Seam {
    fn check(&self) -> Result<(), Misfit> {
        unit("bias", &self.bias)?;
        unit("closure", &self.closure)?;
        within("radius", &self.radius, "greater than 0", |r| r > 0.0 && r.is_finite())?;
        within("scale", &self.scale, "finite", f32::is_finite)
    }
}

impl Tear {
    fn check(&self) -> Result<(), Misfit> {
        unit("at", &self.at)?;
        within("width", &self.width, "0 or greater", |w| w >= 0.0 && w.is_finite())?;
        unit("opening", &self.opening)?;
        within("gape", &self.gape, "finite", f32::is_finite)?;
        unit("plateau", &self.plateau)
    }
}
