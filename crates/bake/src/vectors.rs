//! Long lists of vectors, worked on in pieces: by many threads, and with sums in an order that does not depend on how many.

use rayon::prelude::*;

/// A displacement of a vertex, or of its normal.
pub(crate) type Vector = [f32; 3];

/// So many vectors are worked on by one thread at a time: what is needed of them stays in its cache.
pub(crate) const PIECE: usize = 1 << 13;

/// How many sums run side by side: as wide as vectors of float64 get.
const LANES: usize = 8;

/// The scalar products of `x` with each of `basis`.
pub(crate) fn products(basis: &[Vec<Vector>], x: &[Vector]) -> Vec<f64> {
    let piece = |(k, x): (usize, &[Vector])| -> Vec<f64> {
        let range = k * PIECE..k * PIECE + x.len();
        basis.iter().map(|q| q.get(range.clone()).map_or(0.0, |q| product(q, x))).collect()
    };
    let pieces: Vec<Vec<f64>> = x.par_chunks(PIECE).enumerate().map(piece).collect();
    let mut sums = vec![0.0; basis.len()];
    for piece in pieces {
        sums.iter_mut().zip(piece).for_each(|(sum, part)| *sum += part);
    }
    sums
}

fn product(a: &[Vector], b: &[Vector]) -> f64 {
    let ((a, a_rest), (b, b_rest)) =
        (a.as_flattened().as_chunks::<LANES>(), b.as_flattened().as_chunks::<LANES>());
    let mut sums = [0.0_f64; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += f64::from(a[lane]) * f64::from(b[lane]);
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
    sums.iter().sum::<f64>() + rest
}

/// Takes from `x` the parts `c` along `basis`. Gives the length of the longest vector that is left.
pub(crate) fn subtract(x: &mut [Vector], basis: &[Vec<Vector>], c: &[f64]) -> f64 {
    let piece = |(k, x): (usize, &mut [Vector])| {
        let range = k * PIECE..k * PIECE + x.len();
        let mut left: Vec<f64> = x.as_flattened().iter().map(|v| f64::from(*v)).collect();
        for (q, c) in basis.iter().zip(c) {
            let q = q.get(range.clone()).unwrap_or_default().as_flattened();
            left.iter_mut().zip(q).for_each(|(left, q)| *left -= c * f64::from(*q));
        }
        x.as_flattened_mut().iter_mut().zip(&left).for_each(|(x, left)| *x = *left as f32);
        longest(x)
    };
    x.par_chunks_mut(PIECE).enumerate().map(piece).reduce(|| 0.0, f64::max)
}

/// `x += f·y`.
pub(crate) fn add(x: &mut [Vector], f: f64, y: &[Vector]) {
    let piece = |(x, y): (&mut [Vector], &[Vector])| {
        for (x, y) in x.as_flattened_mut().iter_mut().zip(y.as_flattened()) {
            *x = (f64::from(*x) + f * f64::from(*y)) as f32;
        }
    };
    x.par_chunks_mut(PIECE).zip(y.par_chunks(PIECE)).for_each(piece);
}

/// The sum of `list`, each by its factor; of `count` vectors.
pub(crate) fn combined(list: &[Vec<Vector>], factors: &[f64], count: usize) -> Vec<Vector> {
    let mut out = vec![[0.0; 3]; count];
    let piece = |(k, out): (usize, &mut [Vector])| {
        let range = k * PIECE..k * PIECE + out.len();
        let mut sum = vec![0.0_f64; 3 * out.len()];
        for (part, factor) in list.iter().zip(factors).filter(|(_, factor)| **factor != 0.0) {
            let part = part.get(range.clone()).unwrap_or_default().as_flattened();
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += factor * f64::from(*part));
        }
        out.as_flattened_mut().iter_mut().zip(&sum).for_each(|(out, sum)| *out = *sum as f32);
    };
    out.par_chunks_mut(PIECE).enumerate().for_each(piece);
    out
}

/// The length of the longest of them.
pub(crate) fn longest(x: &[Vector]) -> f64 {
    let square = |v: &Vector| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    f64::from(x.iter().map(square).fold(0.0, |a, b| if b > a { b } else { a })).sqrt()
}

/// How far `b` is at most from `f` of the way from `a` to `c`.
pub(crate) fn bulge(a: &[Vector], b: &[Vector], c: &[Vector], f: f64) -> f64 {
    let f = f as f32;
    let piece = |((a, b), c): ((&[Vector], &[Vector]), &[Vector])| {
        let off = |((a, b), c): ((&Vector, &Vector), &Vector)| {
            let part = |k: usize| (b[k] - a[k]) - f * (c[k] - a[k]);
            part(0) * part(0) + part(1) * part(1) + part(2) * part(2)
        };
        a.iter().zip(b).zip(c).map(off).fold(0.0, |a, b| if b > a { b } else { a })
    };
    let pieces = a.par_chunks(PIECE).zip(b.par_chunks(PIECE)).zip(c.par_chunks(PIECE));
    f64::from(pieces.map(piece).reduce(|| 0.0, f32::max)).sqrt()
}
