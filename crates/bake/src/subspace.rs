//! The poses of a node as sums of few shapes, found while they come in.
//!
//! A pose that the shapes so far do not make up to a fraction of the tolerance gives one more: what is left of it, at right angles to the
//! others. They are taken several at a time, so that each shape is fetched from memory once for all of them. So what is kept grows with how many shapes a motion has and not with how long it lasts, and each pose is its coordinates.
//! Which of the shapes matter the coordinates tell ([`crate::principal`]).

use rayon::prelude::*;

use crate::vectors::{Vector, add, products, subtract};

/// So many poses are taken together.
const BATCH: usize = 8;

/// Poses in terms of shapes.
#[derive(Debug)]
pub(crate) struct Subspace {
    /// Orthonormal lists.
    pub(crate) shapes: Vec<Vec<Vector>>,
    /// For each shape the sum of the directions of all poses, each by its coordinate; behind them, at last, the plain sum.
    pub(crate) turned: Vec<Vec<Vector>>,
    /// Of each pose the coordinates; of shapes that came later they are 0, and left out.
    pub(crate) coordinates: Vec<Vec<f64>>,
    /// How far a vertex of a pose is at most from what its coordinates say, metres.
    pub(crate) left: f64,
    /// What may be left.
    exact: f64,
    /// The most shapes that are kept.
    limit: usize,
    sum: Vec<Vector>,
    /// Poses that wait to be taken, and their directions.
    waiting: [Vec<Vec<Vector>>; 2],
}

impl Subspace {
    pub(crate) fn new(turns: usize, exact: f64, limit: usize) -> Self {
        Self {
            shapes: Vec::new(),
            turned: Vec::new(),
            sum: vec![[0.0; 3]; turns],
            coordinates: Vec::new(),
            left: 0.0,
            exact,
            limit,
            waiting: [Vec::new(), Vec::new()],
        }
    }

    /// Takes a pose. False where it needs one shape more than may be kept: the subspace is of no use then.
    pub(crate) fn push(&mut self, places: Vec<Vector>, directions: Vec<Vector>) -> bool {
        self.waiting[0].push(places);
        self.waiting[1].push(directions);
        self.waiting[0].len() < BATCH || self.take()
    }

    /// Takes what waits. It has to be, before the shapes are used.
    pub(crate) fn finish(mut self) -> Option<Self> {
        let enough = self.take();
        self.turned.push(std::mem::take(&mut self.sum));
        enough.then_some(self)
    }

    fn take(&mut self) -> bool {
        let [mut poses, directions] = std::mem::take(&mut self.waiting);
        let mut coordinates = products(&self.shapes, &poses);
        let left = subtract(&mut poses, &self.shapes, &coordinates);
        let known = self.shapes.len();
        for ((mut pose, coordinates), mut left) in poses.into_iter().zip(&mut coordinates).zip(left) {
            if left > self.exact {
                // Shapes that this batch has brought count, too; and what is left of a long vector is not quite at right angles
                // in floats.
                for from in [known, 0] {
                    let pair = std::slice::from_mut(&mut pose);
                    let more = products(&self.shapes[from..], pair);
                    left = subtract(pair, &self.shapes[from..], &more)[0];
                    coordinates.resize(self.shapes.len(), 0.0);
                    coordinates[from..].iter_mut().zip(&more[0]).for_each(|(c, more)| *c += more);
                }
                let length = pose.as_flattened().iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
                if left > self.exact && length > 0.0 {
                    if self.shapes.len() >= self.limit {
                        return false;
                    }
                    pose.as_flattened_mut().iter_mut().for_each(|x| *x = (f64::from(*x) / length) as f32);
                    self.shapes.push(pose);
                    self.turned.push(vec![[0.0; 3]; self.sum.len()]);
                    coordinates.push(length);
                    left = 0.0;
                }
            }
            self.left = self.left.max(left);
        }
        add(&mut self.turned, &directions, &coordinates);
        add(std::slice::from_mut(&mut self.sum), &directions, &vec![vec![1.0]; directions.len()]);
        self.coordinates.append(&mut coordinates);
        true
    }

    /// How many vertices a shape moves.
    pub(crate) fn moved(&self) -> usize {
        let Some(first) = self.shapes.first() else { return 0 };
        let moves = |v: &usize| self.shapes.iter().any(|shape| shape.get(*v).is_some_and(|d| *d != [0.0; 3]));
        (0..first.len()).into_par_iter().filter(moves).count()
    }
}
