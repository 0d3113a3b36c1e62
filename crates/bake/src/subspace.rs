//! The poses of a node as sums of few shapes, found while they come in.
//!
//! A pose that the shapes so far do not make up to a fraction of the tolerance gives one more: what is left of it, at right angles to the
//! others. So what is kept grows with how many shapes a motion has and not with how long it lasts, and each pose is its coordinates.
//! Which of the shapes matter the coordinates tell ([`crate::principal`]).

use rayon::prelude::*;

use crate::vectors::{Vector, add, products, subtract};

/// Poses in terms of shapes.
#[derive(Debug)]
pub(crate) struct Subspace {
    /// Orthonormal lists.
    pub(crate) shapes: Vec<Vec<Vector>>,
    /// For each shape the sum of the directions of all poses, each by its coordinate.
    pub(crate) turned: Vec<Vec<Vector>>,
    /// The sum of all directions.
    pub(crate) sum: Vec<Vector>,
    /// Of each pose the coordinates; of shapes that came later they are 0, and left out.
    pub(crate) coordinates: Vec<Vec<f64>>,
    /// How far a vertex of a pose is at most from what its coordinates say, metres.
    pub(crate) left: f64,
    /// What may be left.
    exact: f64,
    /// The most shapes that are kept.
    limit: usize,
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
        }
    }

    /// Takes a pose. False where it needs one shape more than may be kept: the subspace is of no use then.
    pub(crate) fn push(&mut self, mut places: Vec<Vector>, directions: &[Vector]) -> bool {
        let mut coordinates = products(&self.shapes, &places);
        let mut left = subtract(&mut places, &self.shapes, &coordinates);
        if left > self.exact {
            if self.shapes.len() >= self.limit {
                return false;
            }
            // What is left of a long vector is not quite at right angles in floats.
            let more = products(&self.shapes, &places);
            left = subtract(&mut places, &self.shapes, &more);
            coordinates.iter_mut().zip(more).for_each(|(c, more)| *c += more);
            let length = crate::vectors::products(std::slice::from_ref(&places), &places)[0].sqrt();
            if left > self.exact && length > 0.0 {
                let unit = 1.0 / length;
                places.as_flattened_mut().iter_mut().for_each(|c| *c = (f64::from(*c) * unit) as f32);
                self.shapes.push(places);
                self.turned.push(vec![[0.0; 3]; directions.len()]);
                coordinates.push(length);
                left = 0.0;
            }
        }
        self.left = self.left.max(left);
        for (turned, c) in self.turned.iter_mut().zip(&coordinates) {
            add(turned, *c, directions);
        }
        add(&mut self.sum, 1.0, directions);
        self.coordinates.push(coordinates);
        true
    }

    /// How many vertices a shape moves.
    pub(crate) fn moved(&self) -> usize {
        let Some(first) = self.shapes.first() else { return 0 };
        let moves = |v: &usize| self.shapes.iter().any(|shape| shape.get(*v).is_some_and(|d| *d != [0.0; 3]));
        (0..first.len()).into_par_iter().filter(moves).count()
    }
}
