//! A wire at one moment as the kernel wants it: for every cell the coefficients all its points share.

use glam::DVec3;

use crate::arclength::ArcLength;
use crate::attributes::Attribute;
use crate::cells::{Cell, Cells};
use crate::follow::{Places, Turns, tangent_near_joint};
use crate::spans::{Cubic, Spans, to_dvec3};
use crate::{Bend, Correspondence, Wire};

/// Powers of `t` of a vector polynomial, in float32.
pub(crate) type Powers<const N: usize> = [[f32; 3]; N];

/// How the frame turns from `R` to `W` in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Not at all.
    None,
    /// By the angle of the tangents.
    Tangent,
    /// By a vector looked up for each point.
    Table,
    /// By the same vector everywhere.
    Vector([f32; 3]),
}

/// What the points of one cell share. Curves are relative to [`Frame::origin`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellFrame {
    /// `R`.
    pub(crate) r: Powers<4>,
    /// `R′`, up to a factor.
    pub(crate) r_tangent: Powers<3>,
    /// `W − R`.
    pub(crate) d: Powers<4>,
    /// `W′`, up to a factor; equal to `r_tangent` where the curves run alike.
    pub(crate) w_tangent: Powers<3>,
    /// Where the cell begins; attributes are powers of the distance from there.
    pub(crate) t0: f32,
    /// `s − 1`.
    pub(crate) scale: [f32; 4],
    pub(crate) rotation: [f32; 4],
    pub(crate) amplitude: [f32; 4],
    pub(crate) twist: [f32; 4],
    pub(crate) turn: Turn,
    /// The first place of the cell's segment, in segments from the start of the curve.
    pub(crate) place: f64,
    /// Whether `W − R` and `W′` are looked up by arc length instead.
    pub(crate) by_length: bool,
    /// Whether all attributes are constant.
    pub(crate) uniform: bool,
    /// Whether nothing moves here: every displacement is exactly zero.
    pub(crate) still: bool,
}

/// One wire at one moment.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frame {
    pub(crate) cells: Vec<CellFrame>,
    pub(crate) origin: [f32; 3],
    /// Whether no cell moves anything.
    pub(crate) still: bool,
    /// `R`, kept where `W − R` is looked up by arc length.
    pub(crate) r: Spans,
    pub(crate) w: Spans,
    pub(crate) places: Places,
    pub(crate) turns: Turns,
    d: Spans,
}

impl Frame {
    /// Takes up the present state of `wire`, which is bound with segments `r`; reuses its buffers.
    pub(crate) fn build(&mut self, wire: &Wire, r: &Spans, r_lengths: &ArcLength, cells: &Cells) {
        let reference = &wire.reference;
        let (kind, closed, rest) = (reference.kind(), reference.closed(), reference.points());
        let count = rest.len();
        self.w.build(kind, closed, count, |i| to_dvec3(wire.pose[i]));
        if kind == crate::CurveKind::CatmullRom {
            // Not linear in its points: equal neighbourhoods still give equal cubics.
            self.d.cubics.clear();
            let pairs = self.w.cubics.iter().zip(&r.cubics);
            self.d.cubics.extend(pairs.map(|(w, r)| Cubic(std::array::from_fn(|k| w.0[k] - r.0[k]))));
        } else {
            self.d.build(kind, closed, count, |i| to_dvec3(wire.pose[i]) - to_dvec3(rest[i]));
        }
        let moved = rest != wire.pose;
        let by_length = moved && wire.correspondence == Correspondence::ArcLength;
        let transported = moved && wire.bend == Bend::Transport && r.moves() && self.w.moves();
        if by_length {
            self.places.build(r, r_lengths, &self.w);
            self.r.cubics.clone_from(&r.cubics);
            self.r.closed = r.closed;
        }
        if transported {
            self.turns.build(r, &self.w, by_length.then_some(&self.places));
        }
        let middle = rest.iter().map(|p| to_dvec3(*p)).sum::<DVec3>() / count as f64;
        self.origin = middle.as_vec3().to_array();
        self.cells.clear();
        for cell in &cells.list {
            let frame = self.cell(wire, r, *cell, by_length, transported);
            self.cells.push(frame);
        }
        self.still = self.cells.iter().all(|c| c.still);
    }

    fn cell(&self, wire: &Wire, r: &Spans, cell: Cell, by_length: bool, transported: bool) -> CellFrame {
        let n = r.cubics.len();
        let curves = match cell {
            Cell::Stretch { span, .. } => self.stretch(r, span),
            Cell::Joint { joint, .. } => self.joint(r, joint, by_length),
        };
        let place = match cell {
            Cell::Stretch { span, .. } => span as f64,
            Cell::Joint { joint, .. } => joint as f64,
        };
        let attribute = |a| cell.attribute(wire, a, n).map(|c| c as f32);
        let mut scale = attribute(Attribute::Scale);
        scale[0] -= 1.0;
        let (rotation, amplitude) = (attribute(Attribute::Rotation), attribute(Attribute::Amplitude));
        let twist = attribute(Attribute::Twist);
        let by_length = by_length && matches!(cell, Cell::Stretch { .. });
        let turn = match cell {
            _ if rotation == [0.0; 4] => Turn::None,
            Cell::Stretch { .. } if transported => Turn::Table,
            Cell::Joint { joint, .. } if transported => Turn::Vector(self.turns.at_joint(joint)),
            _ if by_length || curves.r_tangent != curves.w_tangent => Turn::Tangent,
            _ => Turn::None,
        };
        let bends = !matches!(turn, Turn::None | Turn::Vector([0.0, 0.0, 0.0]));
        let moves = by_length || bends || curves.d != [[0.0; 3]; 4] || scale != [0.0; 4] || twist != [0.0; 4];
        let constant = |p: &[f32; 4]| p[1..] == [0.0; 3];
        CellFrame {
            r: curves.r,
            r_tangent: curves.r_tangent,
            d: curves.d,
            w_tangent: curves.w_tangent,
            t0: if let Cell::Stretch { t0, .. } = cell { t0 as f32 } else { 0.0 },
            uniform: [&scale, &rotation, &amplitude, &twist].into_iter().all(constant),
            still: !moves || amplitude == [0.0; 4],
            scale,
            rotation,
            amplitude,
            twist,
            turn,
            place,
            by_length,
        }
    }

    fn stretch(&self, r: &Spans, span: usize) -> Curves {
        let origin = to_dvec3(self.origin);
        let mut relative = r.cubics[span].0;
        relative[0] -= origin;
        Curves {
            r: powers(relative),
            d: powers(self.d.cubics[span].0),
            r_tangent: tangent_powers(&r.cubics[span]),
            w_tangent: tangent_powers(&self.w.cubics[span]),
        }
    }

    /// At a joint everything is constant; an arc length there may lead anywhere on `W`.
    fn joint(&self, r: &Spans, joint: usize, by_length: bool) -> Curves {
        let (span, t) = Cell::Joint { joint, u: 0.0 }.place(0.0, r.cubics.len());
        let constant = |v: DVec3| [v, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO];
        let on_r = r.cubics[span].at(t);
        let (d, w_tangent) = if by_length {
            let (w_span, w_t) = self.places.at(joint as f64, &self.w);
            (self.w.cubics[w_span].at(w_t) - on_r, tangent_near_joint(&self.w, w_span, w_t))
        } else {
            (self.d.cubics[span].at(t), self.w.joint_tangent(joint))
        };
        let tangent = |v: DVec3| [v.as_vec3().to_array(), [0.0; 3], [0.0; 3]];
        Curves {
            r: powers(constant(on_r - to_dvec3(self.origin))),
            d: powers(constant(d)),
            r_tangent: tangent(r.joint_tangent(joint)),
            w_tangent: tangent(w_tangent),
        }
    }
}

struct Curves {
    r: Powers<4>,
    r_tangent: Powers<3>,
    d: Powers<4>,
    w_tangent: Powers<3>,
}

fn powers<const N: usize>(v: [DVec3; N]) -> Powers<N> {
    v.map(|c| c.as_vec3().to_array())
}

/// The derivative divided by its bound, so that its size says nothing of the scene's units.
fn tangent_powers(cubic: &Cubic) -> Powers<3> {
    let c = &cubic.0;
    let bound = cubic.speed_bound();
    let inverse = if bound > 0.0 { 1.0 / bound } else { 0.0 };
    powers([c[1] * inverse, 2.0 * c[2] * inverse, 3.0 * c[3] * inverse])
}
