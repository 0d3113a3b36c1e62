//! Roots of a quintic on `[0, 1]`, isolated by proof.
//!
//! The feet of a point `P` on a cubic are roots of `g(s) = (R(s) − P)·R′(s)`, of degree five. Written in the
//! Bernstein basis, the number of sign changes of the coefficients bounds the number of roots and differs from it by
//! an even number (Descartes): no change, no root; one change, exactly one. With more the interval is halved by de
//! Casteljau's scheme, under which the sum of the changes never grows, so at most five branches live at any depth.
//!
//! A zero coefficient counts as positive. That is the same as moving the polynomial up by less than any number, so a
//! root at a boundary belongs to exactly one side.

/// Coefficients in the Bernstein basis of degree five.
pub(crate) type Bernstein = [f64; 6];

/// After so many halvings an interval that still has several sign changes holds roots closer together than
/// rounding can tell apart; its middle stands for them.
const DEPTH: u32 = 46;

/// Newton's method ends when a step is below this part of the interval: the root is then as exact even where it converges
/// linearly, and a place is kept in float32. Much less is below the rounding of the coefficients, and never reached.
const STEP: f64 = 1e-11;

const CHOOSE: [[f64; 6]; 6] = [
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0, 0.0],
    [1.0, 5.0, 10.0, 10.0, 5.0, 1.0],
];

/// Bernstein coefficients of degree five of `p₀ + p₁ s + p₂ s² + ..`, of any vector space.
pub(crate) fn from_powers<T>(powers: &[T]) -> [T; 6]
where
    T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    std::array::from_fn(|k| {
        powers
            .iter()
            .enumerate()
            .take(k + 1)
            .fold(T::default(), |sum, (i, &p)| sum + p * (CHOOSE[k][i] / CHOOSE[5][i]))
    })
}

/// How often the signs of the coefficients change.
fn sign_changes(c: &Bernstein) -> u32 {
    let mut changes = 0;
    for i in 0..5 {
        changes += u32::from((c[i] >= 0.0) != (c[i + 1] >= 0.0));
    }
    changes
}

/// Calls `found` with every root on `[0, 1]` at which the quintic passes from negative to positive, by rising `s`.
pub(crate) fn rising_roots(c: &Bernstein, found: &mut impl FnMut(f64)) {
    roots(c, &mut |s, rises| {
        if rises {
            found(s);
        }
    });
}

/// Calls `found` with every root on `[0, 1]` at which the sign changes, by rising `s`, and whether it becomes positive.
pub(crate) fn roots(c: &Bernstein, found: &mut impl FnMut(f64, bool)) {
    isolate(c, 0.0, 1.0, DEPTH, found);
}

fn isolate(c: &Bernstein, s0: f64, width: f64, depth: u32, found: &mut impl FnMut(f64, bool)) {
    let rises = c[0] < 0.0;
    let crosses = rises == (c[5] >= 0.0);
    match sign_changes(c) {
        0 => {}
        1 if rises => found(s0 + width * single_root(c), true),
        1 => found(s0 + width * single_root(&c.map(|c| -c)), false),
        _ if depth == 0 => {
            if crosses {
                found(s0 + 0.5 * width, rises);
            }
        }
        _ => {
            let (left, right) = halves(c);
            isolate(&left, s0, 0.5 * width, depth - 1, found);
            isolate(&right, s0 + 0.5 * width, 0.5 * width, depth - 1, found);
        }
    }
}

fn halves(c: &Bernstein) -> (Bernstein, Bernstein) {
    let (mut left, mut right) = (*c, *c);
    let mut row = *c;
    for level in 1..6 {
        for i in 0..6 - level {
            row[i] = 0.5 * (row[i] + row[i + 1]);
        }
        left[level] = row[0];
        right[5 - level] = row[5 - level];
    }
    (left, right)
}

/// The root of coefficients that change sign once, upwards: Newton's method inside a bracket.
pub(crate) fn single_root(c: &Bernstein) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // A zero at the start is no change of sign, and not the root that is sought.
    let mut s = if c[0] == 0.0 { 0.5 } else { c[0] / (c[0] - c[5]) };
    for _ in 0..100 {
        let (value, slope) = value_and_slope(c, s);
        if value < 0.0 {
            low = s;
        } else {
            high = s;
        }
        let newton = s - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - s).abs() <= STEP {
            return next;
        }
        s = next;
    }
    s
}

fn value_and_slope(c: &Bernstein, s: f64) -> (f64, f64) {
    let mut row = *c;
    for level in 1..5 {
        for i in 0..6 - level {
            row[i] += s * (row[i + 1] - row[i]);
        }
    }
    (row[0] + s * (row[1] - row[0]), 5.0 * (row[1] - row[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power coefficients of `scale · Π (s − rᵢ)`.
    fn product(roots: [f64; 5], scale: f64) -> [f64; 6] {
        let mut p = [0.0; 6];
        p[0] = scale;
        for (degree, r) in roots.into_iter().enumerate() {
            for i in (0..=degree + 1).rev() {
                p[i] = if i > 0 { p[i - 1] } else { 0.0 } - r * p[i];
            }
        }
        p
    }

    fn roots_of(p: &[f64; 6]) -> Vec<f64> {
        let mut found = Vec::new();
        rising_roots(&from_powers(p), &mut |s| found.push(s));
        found
    }

    #[test]
    fn five_roots_close_together_are_told_apart() {
        for gap in [0.2, 1e-2, 1e-3] {
            let r = [0.3, 0.3 + gap, 0.3 + 2.0 * gap, 0.3 + 3.0 * gap, 0.3 + 3.4 * gap];
            let found = roots_of(&product(r, 1.0));
            let rising = [r[0], r[2], r[4]].into_iter().filter(|r| *r < 1.0);
            let rising: Vec<f64> = rising.collect();
            assert_eq!(found.len(), rising.len(), "gap {gap}: {found:?}");
            // The condition of a cluster of five: the root of rounding, divided by the gaps.
            let tolerance = 1e-15 / gap.powi(4);
            assert!(found.iter().zip(&rising).all(|(a, b)| (a - b).abs() < tolerance.max(1e-12)));
        }
    }

    #[test]
    fn a_falling_root_is_no_foot() {
        assert!(roots_of(&product([0.5, 2.0, 3.0, 4.0, 5.0], -1.0)).is_empty());
        assert_eq!(roots_of(&product([0.5, 2.0, 3.0, 4.0, 5.0], 1.0)).len(), 1);
    }

    #[test]
    fn roots_rise_and_fall_by_turns_and_a_zero_at_the_start_is_none() {
        let all = |p: &[f64; 6]| {
            let mut found = Vec::new();
            roots(&from_powers(p), &mut |s, rises| found.push((s, rises)));
            found
        };
        let three = all(&product([0.2, 0.5, 0.9, 4.0, -5.0], 1.0));
        assert_eq!(three.iter().map(|r| r.1).collect::<Vec<_>>(), [false, true, false]);
        // Rises from 0 at 0 and falls through 0.7.
        let found = all(&product([0.0, 0.7, -2.0, -3.0, 4.0], 1.0));
        assert!(found.len() == 1 && (found[0].0 - 0.7).abs() < 1e-9 && !found[0].1, "{found:?}");
    }

    #[test]
    fn nothing_is_found_in_the_zero_polynomial_and_a_double_root_ends() {
        assert!(roots_of(&[0.0; 6]).is_empty());
        assert!(roots_of(&product([0.5, 0.5, 3.0, 4.0, 5.0], 1.0)).len() <= 1);
        assert_eq!(roots_of(&product([0.5, 0.5, 0.5, 4.0, 5.0], 1.0)).len(), 1);
    }

    #[test]
    fn a_root_at_an_end_belongs_to_one_side() {
        let p = product([0.5, -2.0, -3.0, 4.0, 5.0], 1.0);
        let (left, right) = halves(&from_powers(&p));
        let count = |c| {
            let mut n = 0;
            rising_roots(c, &mut |_| n += 1);
            n
        };
        let before_next = usize::from(left[5] < 0.0 && right[0] >= 0.0);
        assert_eq!(count(&left) + count(&right) + before_next, 1);
    }
}
