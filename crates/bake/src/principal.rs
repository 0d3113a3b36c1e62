//! From coordinates in a subspace to the fewest shapes whose weighted sums keep a tolerance.
//!
//! The matrix of the products of the shapes' coordinates over all poses is small, however many vertices there are; its eigenvectors are
//! the directions in which poses differ most. How far vertices are off with the first of them alone is measured, at every pose and
//! every vertex, for all numbers of them at once.
//!
//! Weights go from 0 to 1, since Blender holds them there: what the least weights make up is a shape of its own that is always there. A pose
//! that equals the rest has no weights at all, and is exact.

use nalgebra::{DMatrix, DVector, DVectorView, SymmetricEigen};
use rayon::prelude::*;

use crate::subspace::Subspace;
use crate::vectors::{Vector, add_wide, combined, longest, vectorized};

/// So many vertices are compared by one thread at a time: all shapes of them stay in its cache.
const PIECE: usize = 1 << 9;

/// So many vertices are compared side by side.
const LANES: usize = 16;

/// Shapes that contribute less than this part of the tolerance anywhere are as good as none.
const NOTHING: f64 = 1e-3;

/// Weights that depend on each other more closely than to this part cannot be told apart: normals then get the least that fit.
const DEPENDENT: f64 = 1e-10;

/// Shapes, and the weights at which each pose is their sum.
#[derive(Debug)]
pub(crate) struct Basis {
    /// Displacements of each shape, metres, and what it adds to normals and tangents.
    pub(crate) shapes: Vec<Shape>,
    /// Whether the last shape is the one that is always there.
    pub(crate) offset: bool,
    /// For each pose the weights of all shapes, 0 ..= 1.
    pub(crate) weights: Vec<Vec<f64>>,
    /// How far each shape moves a vertex at most, metres.
    pub(crate) reaches: Vec<f64>,
    /// How far a vertex of a pose is off at most, metres.
    pub(crate) error: f64,
}

#[derive(Debug)]
pub(crate) struct Shape {
    pub(crate) places: Vec<Vector>,
    pub(crate) directions: Vec<Vector>,
}

/// How many shapes a basis needs, and what fewer would do.
#[derive(Debug)]
pub(crate) struct Choice {
    axes: Axes,
    /// How many axes.
    rank: usize,
    /// What sums of the subspace's shapes may be off, metres; below 0 where these are too far from the poses themselves.
    tolerance: f64,
}

/// The principal axes of poses.
#[derive(Debug)]
struct Axes {
    /// What poses are counted from: the rest, or their mean.
    origin: DVector<f64>,
    /// One a column, the most important one first.
    directions: DMatrix<f64>,
    /// The coordinates of poses along them, one pose a row.
    along: DMatrix<f64>,
    /// How far a vertex is off at most with so many axes.
    errors: Vec<f64>,
}

impl Choice {
    /// Looks for the fewest shapes within `tolerance`, metres; `rests` says which poses equal the rest. These are counted from the rest, so that
    /// they are exact; a motion that never rests may be counted from its mean.
    pub(crate) fn new(subspace: &Subspace, rests: &[bool], tolerance: f64) -> Self {
        let tolerance = tolerance - subspace.left;
        let choice = |mean: bool| {
            let axes = Axes::new(subspace, mean, tolerance.max(0.0));
            let rank =
                axes.errors.iter().position(|error| *error <= tolerance).unwrap_or(axes.errors.len() - 1);
            Self { axes, rank, tolerance }
        };
        let from_rest = choice(false);
        if rests.iter().any(|rests| *rests) {
            return from_rest;
        }
        let from_mean = choice(true);
        if from_mean.count(rests) < from_rest.count(rests) { from_mean } else { from_rest }
    }

    /// How many targets that makes.
    pub(crate) fn count(&self, rests: &[bool]) -> usize {
        self.rank
            + usize::from(
                self.rank > 0 && self.has_offset(self.rank, rests) || self.rank == 0 && self.is_held(rests),
            )
    }

    /// Whether it keeps the tolerance: not where this is finer than the numbers.
    pub(crate) fn keeps(&self) -> bool {
        self.axes.errors[self.rank] <= self.tolerance
    }

    /// The least error that so many targets can keep, metres; none where they would show nothing but one pose.
    pub(crate) fn error_with(&self, subspace: &Subspace, rests: &[bool], targets: usize) -> Option<f64> {
        let Axes { directions: axes, along, errors: known, .. } = &self.axes;
        let most = targets.min(known.len() - 1);
        let rank = if self.has_offset(most, rests) { most.min(targets - 1) } else { most };
        (rank > 0).then(|| errors(&subspace.shapes, axes, along, f64::INFINITY)[rank])
    }

    /// Whether the least weights along so many axes are not nothing: at once from numbers, for shapes are unit vectors.
    fn has_offset(&self, rank: usize, rests: &[bool]) -> bool {
        let lows = (0..rank).map(|axis| self.range(axis, rests)[0]);
        lows.chain(self.axes.origin.iter().copied()).any(|low| low.abs() > NOTHING * self.tolerance)
    }

    /// Whether one pose, which is not the rest, is held all the time.
    fn is_held(&self, rests: &[bool]) -> bool {
        self.axes.errors.len() > 1 && self.has_offset(self.rank, rests)
    }

    /// The least and the greatest coordinate along an axis.
    fn range(&self, axis: usize, rests: &[bool]) -> [f64; 2] {
        let column = self.axes.along.column(axis);
        let own = column.iter().zip(rests).filter(|(_, rests)| !**rests).map(|(c, _)| *c);
        let (mut low, mut high) =
            own.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)));
        // Where some poses rest the way starts from there, if it goes to one side only.
        if rests.contains(&true) || low > 0.0 && low < 0.5 * high {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        [low, high]
    }

    /// The shapes and the weights.
    pub(crate) fn basis(self, subspace: Subspace, count: usize, rests: &[bool]) -> Basis {
        let offset = self.count(rests) > self.rank;
        let ranges: Vec<[f64; 2]> = (0..self.rank).map(|axis| self.range(axis, rests)).collect();
        let Self { axes: Axes { origin, directions: axes, along, errors }, rank, .. } = self;
        let weight = |pose: usize, axis: usize| {
            let [low, high] = ranges[axis];
            ((along[(pose, axis)] - low) / (high - low)).clamp(0.0, 1.0)
        };
        let mut weights: Vec<Vec<f64>> = Vec::with_capacity(rests.len());
        for (pose, rests) in rests.iter().enumerate() {
            let own = (0..rank).map(|axis| if *rests { 0.0 } else { weight(pose, axis) });
            weights.push(own.chain(offset.then_some(f64::from(u8::from(!rests)))).collect());
        }
        // Each shape as a sum of those of the subspace.
        let mut factors: Vec<Vec<f64>> = (0..rank)
            .map(|axis| axes.column(axis).iter().map(|c| c * (ranges[axis][1] - ranges[axis][0])).collect())
            .collect();
        if offset {
            let mut from = origin.clone();
            for (axis, [low, _]) in ranges.iter().enumerate() {
                from += axes.column(axis) * *low;
            }
            factors.push(from.iter().copied().collect());
        }
        let own = subspace.shapes.len();
        let mut of_sums = DMatrix::zeros(factors.len(), own + 1);
        for (axis, [low, high]) in ranges.iter().enumerate() {
            let column = axes.column(axis);
            for (k, c) in column.iter().enumerate() {
                of_sums[(axis, k)] = c / (high - low);
            }
            of_sums[(axis, own)] = -(column.dot(&origin) + low) / (high - low);
        }
        if offset {
            of_sums[(rank, own)] = 1.0;
        }
        let turns = turn_factors(&weights, &of_sums);
        let Subspace { shapes, turned, left, .. } = subspace;
        // One list after the other, so that not all of both are there at once.
        let places: Vec<Vec<Vector>> = factors.iter().map(|own| combined(&shapes, own, count)).collect();
        drop(shapes);
        let directions = turned.last().map_or(0, Vec::len);
        let shape = |(places, own): (Vec<Vector>, &Vec<f64>)| Shape {
            places,
            directions: combined(&turned, own, directions),
        };
        let shapes: Vec<Shape> = places.into_iter().zip(&turns).map(shape).collect();
        let reaches = shapes.iter().map(|shape| longest(&shape.places)).collect();
        Basis { shapes, offset, weights, reaches, error: errors[rank] + left }
    }
}

/// For each shape the factors of the sums of directions that make what it adds to normals: the least squares over all poses. `of_sums` says
/// how the products of weights and directions are sums of those that were kept, the plain sum last.
fn turn_factors(weights: &[Vec<f64>], of_sums: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let count = of_sums.nrows();
    let w = DMatrix::from_fn(weights.len(), count, |pose, k| weights[pose][k]);
    let factors = solved(&w.tr_mul(&w), of_sums).unwrap_or_else(|| DMatrix::zeros(count, of_sums.ncols()));
    (0..count).map(|k| factors.row(k).iter().copied().collect()).collect()
}

/// `a⁻¹·b` for a symmetric `a`, by what of it can be inverted.
fn solved(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    if a.is_empty() {
        return None;
    }
    let eigen = SymmetricEigen::try_new(a.clone(), f64::EPSILON, 0)?;
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let inverse = eigen.eigenvalues.map(|v| if v > DEPENDENT * largest { 1.0 / v } else { 0.0 });
    let v = &eigen.eigenvectors;
    Some(v * DMatrix::from_diagonal(&inverse) * v.tr_mul(b))
}

impl Axes {
    fn new(subspace: &Subspace, mean: bool, enough: f64) -> Self {
        let (poses, count) = (subspace.coordinates.len(), subspace.shapes.len());
        let mut along = DMatrix::from_fn(poses, count, |pose, k| {
            subspace.coordinates[pose].get(k).copied().unwrap_or(0.0)
        });
        let mut origin = DVector::zeros(count);
        if mean {
            origin = along.row_mean().transpose();
            for mut row in along.row_iter_mut() {
                row -= origin.transpose();
            }
        }
        let mut axes = principal(along.tr_mul(&along));
        let mut along = along * &axes;
        // Poses are to go further along an axis than against it.
        for k in 0..count {
            if along.column(k).max() < -along.column(k).min() {
                axes.column_mut(k).neg_mut();
                along.column_mut(k).neg_mut();
            }
        }
        let errors = errors(&subspace.shapes, &axes, &along, enough);
        Self { origin, directions: axes, along, errors }
    }
}

/// Eigenvectors, that of the greatest value first.
fn principal(products: DMatrix<f64>) -> DMatrix<f64> {
    let count = products.nrows();
    if count == 0 {
        return products;
    }
    let Some(eigen) = SymmetricEigen::try_new(products, f64::EPSILON, 0) else {
        return DMatrix::identity(count, count);
    };
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    DMatrix::from_fn(count, count, |row, k| eigen.eigenvectors[(row, order[k])])
}

/// For each number of axes how far a vertex is off at most with these alone, at any pose; infinite for numbers below one that is off by more
/// than `enough`, since those are no better.
fn errors(shapes: &[Vec<Vector>], axes: &DMatrix<f64>, along: &DMatrix<f64>, enough: f64) -> Vec<f64> {
    let count = shapes.len();
    let vertices = shapes.first().map_or(0, Vec::len);
    // A pose a column, so that its coordinates lie beside each other.
    let along = DMatrix::from_fn(count, along.nrows(), |axis, pose| along[(pose, axis)] as f32);
    let enough = (enough * enough) as f32;
    let starts: Vec<usize> = (0..vertices).step_by(PIECE).collect();
    let piece = |start: usize| {
        let shapes = turned(shapes, axes, start..(start + PIECE).min(vertices));
        let lanes = shapes.first().map_or(0, |[x, _, _]| x.len());
        let mut most = vec![0.0_f32; count + 1];
        let mut left = [0, 1, 2].map(|_| vec![[0.0_f32; LANES]; lanes]);
        let mut first = 0;
        for pose in along.column_iter() {
            for list in &mut left {
                list.fill([0.0; LANES]);
            }
            for axis in (first..count).rev() {
                let far = added(&mut left, pose[axis], &shapes[axis]);
                most[axis] = most[axis].max(far);
                if most[axis] > enough {
                    first = axis;
                }
            }
        }
        most[..first].fill(f32::INFINITY);
        most
    };
    let most = starts
        .into_par_iter()
        .map(piece)
        .reduce(|| vec![0.0; count + 1], |a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect());
    most.into_iter().map(|square| f64::from(square).sqrt()).collect()
}

/// One coordinate of vertices, many at a time.
type Lanes = Vec<[f32; LANES]>;

/// Adds `c` times a shape. Gives the square of the longest of what comes out.
fn added(left: &mut [Lanes; 3], c: f32, shape: &[Lanes; 3]) -> f32 {
    vectorized(
        #[inline(always)]
        || added_in_lanes(left, c, shape),
    )
}

#[inline(always)]
fn added_in_lanes([x, y, z]: &mut [Lanes; 3], c: f32, [sx, sy, sz]: &[Lanes; 3]) -> f32 {
    let mut far = [0.0_f32; LANES];
    for (((x, y), z), ((sx, sy), sz)) in x.iter_mut().zip(y).zip(z).zip(sx.iter().zip(sy).zip(sz)) {
        for lane in 0..LANES {
            x[lane] += c * sx[lane];
            y[lane] += c * sy[lane];
            z[lane] += c * sz[lane];
            let square = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
            far[lane] = if square > far[lane] { square } else { far[lane] };
        }
    }
    far.into_iter().fold(0.0, f32::max)
}

/// The shapes along the axes, of a range of vertices: for each its three coordinates.
fn turned(shapes: &[Vec<Vector>], axes: &DMatrix<f64>, range: std::ops::Range<usize>) -> Vec<[Lanes; 3]> {
    let of_axis = |factors: DVectorView<'_, f64>| {
        let mut sum = vec![[0.0_f64; 3]; range.len()];
        for (shape, factor) in shapes.iter().zip(factors.iter()) {
            let own = shape.get(range.clone()).unwrap_or_default().as_flattened();
            add_wide(sum.as_flattened_mut(), *factor, own);
        }
        [0, 1, 2].map(|k| {
            let lanes =
                |group: &[[f64; 3]]| std::array::from_fn(|lane| group.get(lane).map_or(0.0, |s| s[k] as f32));
            sum.chunks(LANES).map(lanes).collect()
        })
    };
    axes.column_iter().map(of_axis).collect()
}
