//! How high a crest stands along its crease, as a part of `intensity`.

/// How far past the front the height eases to nothing, as a fraction of the crease. Shorter would need more control
/// points to follow ([`MIN_SPANS_VARYING`]).
const EASE: f64 = 0.1;
/// The front's progress over which the crest rises at the origin. At `propagation` 0 nothing moves and just beyond it
/// the height is full up to the front: this makes a ramp of that step.
const START: f64 = 0.05;
/// Spans a crease needs for four control points to lie on the ease behind the front.
pub(crate) const MIN_SPANS_VARYING: usize = 40;

/// The height at `x`, the distance from the origin as a fraction of the crease; 0 to 1.
///
/// `resistance` 0 to 1 takes that part of the height away at the far end, smoothly. `propagation`: 0 nothing,
/// up to it full height, easing to nothing over a tenth of the crease beyond, 1 everywhere.
pub(crate) fn height(x: f64, resistance: f64, propagation: f64) -> f64 {
    (1.0 - resistance * smooth(x)) * front(x, propagation)
}

fn front(x: f64, p: f64) -> f64 {
    if p >= 1.0 { 1.0 } else { smooth(p / START) * (1.0 - smooth((x - p) / EASE)) }
}

/// `3x² − 2x³`, constant outside `[0, 1]`.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_full_behind_and_nothing_ahead() {
        for p in [0.05, 0.3, 0.5, 0.95] {
            for i in 0..=100 {
                let x = f64::from(i) / 100.0;
                let h = height(x, 0.0, p);
                assert!(x > p || h == 1.0);
                assert!(x < p + EASE || h == 0.0);
            }
        }
        for i in 0..=10 {
            let x = f64::from(i) / 10.0;
            assert_eq!((height(x, 0.0, 0.0), height(x, 0.0, 1.0)), (0.0, 1.0));
        }
    }

    #[test]
    fn heights_are_continuous_in_place_and_time() {
        let step = 1e-4;
        for i in 0..1000 {
            for j in 0..200 {
                let (x, p) = (f64::from(i) / 1000.0, f64::from(j) / 200.0);
                let h = height(x, 0.7, p);
                assert!((height(x + step, 0.7, p) - h).abs() < 0.01);
                assert!((height(x, 0.7, p + step) - h).abs() < 0.01, "at {x}, {p}");
            }
        }
    }

    #[test]
    fn resistance_takes_the_far_end() {
        assert_eq!(height(1.0, 1.0, 1.0), 0.0);
        assert!(height(0.9, 1.0, 1.0) < 0.3 && height(0.1, 1.0, 1.0) > 0.95);
        assert_eq!((height(0.0, 0.4, 1.0), height(1.0, 0.4, 1.0)), (1.0, 0.6));
    }
}
