//! Long lists of vectors, worked on in pieces: by many threads, and with sums in an order that does not depend on how many.

use rayon::prelude::*;

/// A displacement of a vertex, or of its normal.
pub(crate) type Vector = [f32; 3];

/// So many vectors are worked on by one thread at a time: what is needed of them stays in its cache.
pub(crate) const PIECE: usize = 1 << 12;

/// So many are worked on while several lists are held against each other.
const SLICE: usize = 1 << 9;

/// How many products are summed side by side.
const LANES: usize = 16;

/// Sums of so many products in float32 go on in float64.
const SHORT: usize = 64;

/// Works with the widest vectors that the processor has. Numbers come out equal with any: sums have an order, and nothing fuses.
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// The scalar products of each of `lists` with each of `basis`, in float64, of products in float32.
pub(crate) fn products(basis: &[Vec<Vector>], lists: &[Vec<Vector>]) -> Vec<Vec<f64>> {
    let count = lists.first().map_or(0, Vec::len);
    let piece = |start: usize| {
        let mut sums = vec![vec![0.0_f64; basis.len()]; lists.len()];
        for range in slices(start, count) {
            for (k, shape) in basis.iter().enumerate() {
                for (list, sums) in lists.iter().zip(&mut sums) {
                    sums[k] += product(&shape[range.clone()], &list[range.clone()]);
                }
            }
        }
        sums
    };
    let pieces: Vec<Vec<Vec<f64>>> = starts(count).map(piece).collect();
    let mut sums = vec![vec![0.0; basis.len()]; lists.len()];
    for part in pieces.iter().flat_map(|piece| piece.iter().enumerate()) {
        sums[part.0].iter_mut().zip(part.1).for_each(|(sum, part)| *sum += part);
    }
    sums
}

fn starts(count: usize) -> impl IndexedParallelIterator<Item = usize> {
    (0..count.div_ceil(PIECE)).into_par_iter().map(|k| k * PIECE)
}

/// The slices of the piece that starts there.
fn slices(start: usize, count: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    let end = (start + PIECE).min(count);
    (start..end).step_by(SLICE).map(move |first| first..(first + SLICE).min(end))
}

fn product(a: &[Vector], b: &[Vector]) -> f64 {
    vectorized(
        #[inline(always)]
        || product_in_lanes(a, b),
    )
}

#[inline(always)]
fn product_in_lanes(a: &[Vector], b: &[Vector]) -> f64 {
    let ((a, a_rest), (b, b_rest)) =
        (a.as_flattened().as_chunks::<LANES>(), b.as_flattened().as_chunks::<LANES>());
    let mut sum = 0.0;
    for (a, b) in a.chunks(SHORT).zip(b.chunks(SHORT)) {
        let mut lanes = [0.0_f32; LANES];
        for (a, b) in a.iter().zip(b) {
            for lane in 0..LANES {
                lanes[lane] += a[lane] * b[lane];
            }
        }
        sum += lanes.iter().map(|lane| f64::from(*lane)).sum::<f64>();
    }
    sum + a_rest.iter().zip(b_rest).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>()
}

/// Adds `factor` times `list` to `sum`.
pub(crate) fn add_scaled(sum: &mut [f32], factor: f32, list: &[f32]) {
    vectorized(|| sum.iter_mut().zip(list).for_each(|(sum, x)| *sum += factor * x));
}

/// The same in float64.
pub(crate) fn add_wide(sum: &mut [f64], factor: f64, list: &[f32]) {
    vectorized(|| sum.iter_mut().zip(list).for_each(|(sum, x)| *sum += factor * f64::from(*x)));
}

/// Takes from each of `lists` the parts along `basis` that its factors say. Gives for each the length of the longest vector that is left.
pub(crate) fn subtract(lists: &mut [Vec<Vector>], basis: &[Vec<Vector>], factors: &[Vec<f64>]) -> Vec<f64> {
    let count = lists.first().map_or(0, Vec::len);
    let mut pieces: Vec<Vec<&mut [Vector]>> = (0..count.div_ceil(PIECE)).map(|_| Vec::new()).collect();
    for list in lists.iter_mut() {
        pieces.iter_mut().zip(list.chunks_mut(PIECE)).for_each(|(piece, part)| piece.push(part));
    }
    let lists = factors.len();
    let piece = |(k, mut parts): (usize, Vec<&mut [Vector]>)| {
        let mut longest_left = vec![0.0_f64; lists];
        for range in slices(k * PIECE, count) {
            let own = range.start - k * PIECE..range.end - k * PIECE;
            let double = |part: &&mut [Vector]| -> Vec<f64> {
                part[own.clone()].as_flattened().iter().map(|x| f64::from(*x)).collect()
            };
            let mut left: Vec<Vec<f64>> = parts.iter().map(double).collect();
            for (k, shape) in basis.iter().enumerate() {
                let shape = shape[range.clone()].as_flattened();
                for (left, factors) in left.iter_mut().zip(factors) {
                    add_wide(left, -factors[k], shape);
                }
            }
            for ((part, left), most) in parts.iter_mut().zip(left).zip(&mut longest_left) {
                let part = &mut part[own.clone()];
                part.as_flattened_mut().iter_mut().zip(left).for_each(|(x, left)| *x = left as f32);
                *most = most.max(longest(part));
            }
        }
        longest_left
    };
    let pieces = pieces.into_par_iter().enumerate().map(piece);
    pieces.reduce(|| vec![0.0; lists], |a, b| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect())
}

/// Adds all `lists` to each of `sums`, each by its factor for it: `factors` has those of a list for all sums. A list without one adds nothing.
pub(crate) fn add(sums: &mut [Vec<Vector>], lists: &[Vec<Vector>], factors: &[Vec<f64>]) {
    sums.par_iter_mut().enumerate().for_each(|(k, sum)| {
        let own: Vec<(f32, &Vec<Vector>)> =
            lists.iter().zip(factors).filter_map(|(list, own)| Some((*own.get(k)? as f32, list))).collect();
        for (slice, part) in sum.chunks_mut(SLICE).enumerate() {
            let range = slice * SLICE..slice * SLICE + part.len();
            for (factor, list) in &own {
                let list = list[range.clone()].as_flattened();
                add_scaled(part.as_flattened_mut(), *factor, list);
            }
        }
    });
}

/// The sum of `list`, each by its factor; of `count` vectors.
pub(crate) fn combined(list: &[Vec<Vector>], factors: &[f64], count: usize) -> Vec<Vector> {
    let mut out = vec![[0.0; 3]; count];
    let piece = |(k, out): (usize, &mut [Vector])| {
        let range = k * PIECE..k * PIECE + out.len();
        let mut sum = vec![0.0_f64; 3 * out.len()];
        for (part, factor) in list.iter().zip(factors).filter(|(_, factor)| **factor != 0.0) {
            let part = part.get(range.clone()).unwrap_or_default().as_flattened();
            add_wide(&mut sum, *factor, part);
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
