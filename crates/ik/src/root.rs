//! Where a function is zero.

/// Steps at most: every fourth halves the bracket at least, and false position is seldom that slow.
const STEPS: usize = 200;

/// Where `f`, which is continuous, changes its sign between `a` and `b`: `a` where `f(a) ≥ 0`, `b` where `f(b) ≤ 0`.
///
/// False position with the Illinois rule, by halves where that is slow: always inside a bracket, so that it ends at a root
/// whatever `f` does.
pub(crate) fn root(mut f: impl FnMut(f64) -> f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = ((a, f(a)), (b, f(b)));
    if low.1 >= 0.0 {
        return a;
    }
    if high.1 <= 0.0 {
        return b;
    }
    // The end that moved last: where the other stays twice, false position would creep.
    let (mut wide, mut moved_low) = (0, None);
    let mut best = if -low.1 < high.1 { low } else { high };
    for _ in 0..STEPS {
        let width = high.0 - low.0;
        let secant = low.0 - low.1 * width / (high.1 - low.1);
        let inside = wide < 3 && secant > low.0 && secant < high.0;
        let x = if inside { secant } else { 0.5 * (low.0 + high.0) };
        if x <= low.0 || x >= high.0 {
            break;
        }
        let y = f(x);
        if y.abs() <= best.1.abs() {
            best = (x, y);
        }
        if y == 0.0 {
            break;
        }
        let below = y < 0.0;
        if below {
            low = (x, y);
        } else {
            high = (x, y);
        }
        if moved_low == Some(below) {
            *(if below { &mut high.1 } else { &mut low.1 }) *= 0.5;
        }
        moved_low = Some(below);
        wide = if high.0 - low.0 > 0.5 * width { wide + 1 } else { 0 };
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found() {
        assert!((root(|x| x * x - 2.0, 0.0, 2.0) - 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((root(|x| x.powi(9) - 1e-9, 0.0, 1.0) - 0.1).abs() < 1e-12);
        assert!((root(|x| (x - 0.3).cbrt(), 0.0, 1.0) - 0.3).abs() < 1e-12);
        assert_eq!(root(|x| x + 1.0, 0.0, 1.0), 0.0);
        assert_eq!(root(|x| x - 2.0, 0.0, 1.0), 1.0);
        let step = |x: f64| if x < 0.7 { -1.0 } else { 1.0 };
        assert!((root(step, 0.0, 1.0) - 0.7).abs() < 1e-12);
    }
}
