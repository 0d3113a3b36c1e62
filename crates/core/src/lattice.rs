//! \[SF98\] §6, Figure 21: a lattice round an object, whose control points wires move and which then deforms the object.
//!
//! T. W. Sederberg, S. R. Parry, "Free-Form Deformation of Solid Geometric Models", SIGGRAPH 1986: with the coordinates
//! `s, t, u ∈ [0, 1]` of `P` in the box
//!
//! `P_def = P + Σ Bᵢ(s) Bⱼ(t) Bₖ(u) ΔCᵢⱼₖ`, `Bᵢ(s) = C(l, i) sⁱ (1 − s)ˡ⁻ⁱ`,
//!
//! `ΔC` the shifts of the control points. In shifts and not in places, so that what does not move keeps its bits; with the
//! control points evenly spaced both say the same.
//!
//! # Notes
//!
//! The weights are worked out anew in each frame from `s, t, u`: for cells (3, 3, 3) that is a tenth of the work of the
//! sum, and storing them would read four times the memory.

use pulp::Simd;
use rayon::prelude::*;
use thiserror::Error;

use crate::simd::{Floats, Vectors};
use crate::tiles::TILE;

/// The most cells along an axis: the weights' rounding grows with the degree, and the control points with its cube.
pub const MAX_LATTICE_CELLS: u8 = 32;

/// A point this far beyond a face, as a part of the face's coordinate, still lies on it: four steps of float32. Boxes are written
/// as parts of an object's bounds, or as sums; without this the object's own outermost points would fall out of them.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Most weights of an axis.
const WEIGHTS: usize = MAX_LATTICE_CELLS as usize + 1;

/// Rows are padded to a multiple of this, which every width of vectors divides.
const PAD: usize = 16;

/// A box of control points for free-form deformation. Aligned with the axes; points outside of it are not moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The corner with the least coordinates.
    pub min: [f32; 3],
    /// The opposite corner, greater along each axis.
    pub max: [f32; 3],
    /// `l, m, n`: cells along X, Y, Z, 1 to [`MAX_LATTICE_CELLS`] each; also the degrees of the polynomials. There is one control
    /// point more along each axis.
    pub cells: [u8; 3],
}

/// Why a lattice cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// A corner is NaN or infinite.
    #[error("a corner of the lattice is not finite")]
    NotFinite,
    /// The box is flat, or its corners are the wrong way round.
    #[error("the lattice has no volume: along {} it runs from {min} to {max}", AXES[*.axis % 3])]
    NoVolume {
        /// Which axis, 0 to 2.
        axis: usize,
        /// Its `min`.
        min: f32,
        /// Its `max`.
        max: f32,
    },
    /// There are no cells along an axis, or too many.
    #[error("a lattice has 1 to {MAX_LATTICE_CELLS} cells along each axis, not {cells} along {}", AXES[*.axis % 3])]
    Cells {
        /// Which axis, 0 to 2.
        axis: usize,
        /// What was asked for.
        cells: u8,
    },
    /// A list has another length than it should.
    #[error("{expected} {what} are expected, {found} are given")]
    Count {
        /// What is listed: control points, points or factors.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
}

const AXES: [&str; 3] = ["X", "Y", "Z"];

impl Lattice {
    /// Whether it has a volume and as many cells as it may.
    pub fn check(&self) -> Result<(), LatticeError> {
        if self.min.iter().chain(&self.max).any(|c| !c.is_finite()) {
            return Err(LatticeError::NotFinite);
        }
        for axis in 0..3 {
            let (min, max, cells) = (self.min[axis], self.max[axis], self.cells[axis]);
            if min >= max {
                return Err(LatticeError::NoVolume { axis, min, max });
            }
            if !(1..=MAX_LATTICE_CELLS).contains(&cells) {
                return Err(LatticeError::Cells { axis, cells });
            }
        }
        Ok(())
    }

    /// Control points along each axis.
    pub fn size(&self) -> [usize; 3] {
        self.cells.map(|cells| usize::from(cells) + 1)
    }

    /// The control points at rest, evenly spaced: X fastest, then Y, then Z.
    pub fn points(&self) -> Vec<[f32; 3]> {
        let [l, m, n] = self.size();
        let along = |axis: usize, i: usize| {
            let (min, max) = (f64::from(self.min[axis]), f64::from(self.max[axis]));
            let part = i as f64 / f64::from(self.cells[axis].max(1));
            // Exact at both ends.
            (min * (1.0 - part) + max * part) as f32
        };
        let row = |j: usize, k: usize| (0..l).map(move |i| [along(0, i), along(1, j), along(2, k)]);
        (0..n).flat_map(|k| (0..m).map(move |j| (j, k))).flat_map(|(j, k)| row(j, k)).collect()
    }

    /// `s, t, u` of a point in the box, to whose boundary it belongs; nothing outside.
    fn place(&self, p: [f32; 3]) -> Option<[f32; 3]> {
        let mut place = [0.0; 3];
        for (a, slot) in place.iter_mut().enumerate() {
            let (min, max, x) = (f64::from(self.min[a]), f64::from(self.max[a]), f64::from(p[a]));
            let slack = ROUNDING * min.abs().max(max.abs());
            if !(min - slack..=max + slack).contains(&x) {
                return None;
            }
            *slot = ((x - min) / (max - min)).clamp(0.0, 1.0) as f32;
        }
        Some(place)
    }
}

/// Points bound to a lattice. Made once; [`LatticeBinding::deform_into`] then follows the control points.
#[derive(Clone, Debug)]
pub struct LatticeBinding {
    lattice: Lattice,
    rest: Vec<[f32; 3]>,
    points: Vec<[f32; 3]>,
    tiles: Vec<Held>,
    outside: usize,
}

/// The points of a tile that a lattice moves: which of the tile's, their places in the box, the factors on their shifts.
#[derive(Clone, Debug, Default)]
struct Held {
    index: Vec<u16>,
    place: [Vec<f32>; 3],
    factor: Vec<f32>,
}

impl LatticeBinding {
    /// Binds `points` (any number, in any order) to a lattice. `mask`, where there is one, has a factor on the shift of each
    /// point.
    ///
    /// Points outside the box (by more than the rounding of its corners), and those with a coordinate that is not a number,
    /// are bound to nothing. Uses rayon's current pool; the result does not depend on its size.
    pub fn new(lattice: &Lattice, points: &[[f32; 3]], mask: Option<&[f32]>) -> Result<Self, LatticeError> {
        lattice.check()?;
        if let Some(mask) = mask
            && mask.len() != points.len()
        {
            let (expected, found) = (points.len(), mask.len());
            return Err(LatticeError::Count { what: "factors", expected, found });
        }
        let tile = |(index, points): (usize, &[[f32; 3]])| {
            let mask = mask.and_then(|mask| mask.get(index * TILE..index * TILE + points.len()));
            Held::new(lattice, points, mask)
        };
        let tiles: Vec<(Held, usize)> = points.par_chunks(TILE).enumerate().map(tile).collect();
        let outside = tiles.iter().map(|(_, outside)| outside).sum();
        let tiles = tiles.into_iter().map(|(held, _)| held).collect();
        Ok(Self { lattice: *lattice, rest: lattice.points(), points: points.to_vec(), tiles, outside })
    }

    /// How many of the points lie outside the box and so are never moved; those with a factor of 0 do not count.
    pub fn outside(&self) -> usize {
        self.outside
    }

    /// How many points the lattice can move: those in the box whose factor is not 0.
    pub fn held(&self) -> usize {
        self.tiles.iter().map(|held| held.index.len()).sum()
    }

    /// The points as the lattice deforms them, into `out`, as many as were bound. `controls` are the control points where they
    /// are now, in the order of [`Lattice::points`].
    ///
    /// Points that are not moved keep their bits: those outside, those with a factor of 0, and those whose every control point
    /// that weighs rests.
    pub fn deform_into(&self, controls: &[[f32; 3]], out: &mut [[f32; 3]]) -> Result<(), LatticeError> {
        for (what, expected, found) in
            [("control points", self.rest.len(), controls.len()), ("points", self.points.len(), out.len())]
        {
            if expected != found {
                return Err(LatticeError::Count { what, expected, found });
            }
        }
        let rows = Rows::new(self.lattice.size(), &self.rest, controls);
        let cells = self.lattice.cells.map(Binomials::new);
        let tiles = self.tiles.par_iter().zip(self.points.par_chunks(TILE));
        tiles.zip(out.par_chunks_mut(TILE)).for_each(|((held, points), out)| {
            out.copy_from_slice(points);
            if !rows.list.is_empty() {
                pulp::Arch::new().dispatch(DeformHeld { held, rows: &rows, cells: &cells, out });
            }
        });
        Ok(())
    }
}

impl Held {
    /// Those of a tile's points that are held, and how many of those with a factor lie outside.
    fn new(lattice: &Lattice, points: &[[f32; 3]], mask: Option<&[f32]>) -> (Self, usize) {
        let (mut held, mut outside) = (Self::default(), 0);
        for (index, &point) in points.iter().enumerate() {
            let factor = mask.and_then(|mask| mask.get(index)).copied().unwrap_or(1.0);
            if factor == 0.0 {
                continue;
            }
            let Some(place) = lattice.place(point) else {
                outside += 1;
                continue;
            };
            held.index.push(index as u16);
            held.factor.push(factor);
            for (row, c) in held.place.iter_mut().zip(place) {
                row.push(c);
            }
        }
        let padded = held.index.len().next_multiple_of(PAD);
        held.factor.resize(padded, 0.0);
        held.place.iter_mut().for_each(|row| row.resize(padded, 0.0));
        (held, outside)
    }
}

/// The shifts of the control points, row by row along X; rows at rest are left out.
struct Rows {
    shifts: Vec<[f32; 3]>,
    /// `k`, `j` and where the row starts in `shifts`, by rising `k`, then `j`.
    list: Vec<(usize, usize, usize)>,
    /// Length of a row.
    length: usize,
}

impl Rows {
    fn new([length, m, _]: [usize; 3], rest: &[[f32; 3]], controls: &[[f32; 3]]) -> Self {
        let shift = |(c, rest): (&[f32; 3], &[f32; 3])| [c[0] - rest[0], c[1] - rest[1], c[2] - rest[2]];
        let shifts: Vec<[f32; 3]> = controls.iter().zip(rest).map(shift).collect();
        let moves = |row: &[[f32; 3]]| row.iter().any(|shift| *shift != [0.0; 3]);
        let rows = shifts.chunks(length).enumerate().filter(|(_, row)| moves(row));
        let list = rows.map(|(row, _)| (row / m, row % m, row * length)).collect();
        Self { shifts, list, length }
    }
}

/// The binomial coefficients of a degree.
struct Binomials {
    value: [f32; WEIGHTS],
    degree: usize,
}

impl Binomials {
    fn new(degree: u8) -> Self {
        let (mut value, mut exact) = ([0.0; WEIGHTS], 1_u64);
        for (i, slot) in (0..=u64::from(degree)).zip(&mut value) {
            *slot = exact as f32;
            exact = exact * (u64::from(degree) - i) / (i + 1);
        }
        Self { value, degree: usize::from(degree) }
    }

    /// `B₀(x) .. B_l(x)`.
    #[inline(always)]
    fn weights<S: Simd>(&self, x: Floats<S>) -> [Floats<S>; WEIGHTS] {
        let one = Floats::splat(x.0, 1.0);
        let mut out = [one; WEIGHTS];
        let (rest, mut power) = (one - x, one);
        for (slot, c) in out.iter_mut().zip(self.value).take(self.degree + 1) {
            *slot = Floats::splat(x.0, c) * power;
            power = power * x;
        }
        power = one;
        for slot in out.iter_mut().take(self.degree + 1).rev() {
            *slot = *slot * power;
            power = power * rest;
        }
        out
    }
}

/// Deforms the points of one tile; compiled for the vector instructions the processor has.
struct DeformHeld<'a> {
    held: &'a Held,
    rows: &'a Rows,
    cells: &'a [Binomials; 3],
    out: &'a mut [[f32; 3]],
}

impl pulp::WithSimd for DeformHeld<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { held, rows, cells, out } = self;
        let [s, t, u] = &held.place;
        let (s, t, u) = (Floats::<S>::vectors(s), Floats::<S>::vectors(t), Floats::<S>::vectors(u));
        let factors = Floats::<S>::vectors(&held.factor);
        for (block, index) in held.index.chunks(S::F32_LANES).enumerate() {
            let bs = cells[0].weights(Floats(simd, s[block]));
            let bt = cells[1].weights(Floats(simd, t[block]));
            let bu = cells[2].weights(Floats(simd, u[block]));
            let shift = contract(simd, rows, &bs, &bt, &bu).times(Floats(simd, factors[block]));
            let mut lanes = [[0.0; PAD]; 3];
            for (lane, x) in lanes.iter_mut().zip(shift.0) {
                Floats::<S>::vectors_mut(lane)[0] = x.1;
            }
            for (lane, &i) in index.iter().enumerate() {
                let Some(point) = out.get_mut(usize::from(i)) else { continue };
                for (c, shifts) in point.iter_mut().zip(&lanes) {
                    let by = shifts[lane & (PAD - 1)];
                    // Adding 0 to −0 would change its bits.
                    if by != 0.0 {
                        *c += by;
                    }
                }
            }
        }
    }
}

/// `Σ Bₖ(u) Σ Bⱼ(t) Σ Bᵢ(s) ΔCᵢⱼₖ`: a weight of `t` or `u` is multiplied once a row or layer, not once a control point.
#[inline(always)]
fn contract<S: Simd>(
    simd: S,
    rows: &Rows,
    bs: &[Floats<S>; WEIGHTS],
    bt: &[Floats<S>; WEIGHTS],
    bu: &[Floats<S>; WEIGHTS],
) -> Vectors<S> {
    let zero = Vectors::splat(simd, [0.0; 3]);
    let (mut sum, mut layer, mut of) = (zero, zero, 0);
    for &(k, j, start) in &rows.list {
        if k != of {
            sum = sum + layer.times(bu[of]);
            (layer, of) = (zero, k);
        }
        let mut row = zero;
        for (shift, &b) in rows.shifts[start..start + rows.length].iter().zip(bs) {
            row = row + Vectors::splat(simd, *shift).times(b);
        }
        layer = layer + row.times(bt[j]);
    }
    sum + layer.times(bu[of])
}
