//! How long a frame is shown.

/// The shortest time that players of GIF keep, hundredths of a second; shorter ones they take for ten.
const SHORTEST: u64 = 2;

/// Which of `count` frames a GIF has, and for how many hundredths of a second each: rounded so that no error adds up. Above
/// 50 frames a second not all of them, so that the speed is right.
pub(super) fn delays(count: usize, fps: f64) -> Vec<(usize, u16)> {
    // The end of what is shown while `shown` frames would be, hundredths of a second.
    let end = |shown: usize| (shown as f64 * 100.0 / fps).round() as u64;
    let short = |delay: u64| u16::try_from(delay).unwrap_or(u16::MAX);
    if fps <= 100.0 / SHORTEST as f64 {
        return (0..count).map(|i| (i, short(end(i + 1) - end(i)))).collect();
    }
    let total = end(count).max(SHORTEST);
    let slots = total / SHORTEST;
    let frame = |slot: u64| (((slot * SHORTEST) as f64 * fps / 100.0).round() as usize).min(count - 1);
    let delay = |slot: u64| if slot + 1 == slots { total - SHORTEST * slot } else { SHORTEST };
    (0..slots).map(|slot| (frame(slot), short(delay(slot)))).collect()
}

/// One frame's time as a fraction of a second, each part below 65536: the nearest by continued fractions, so that 29.97 and
/// 30000/1001 are exact.
pub(super) fn fraction(fps: f64) -> (u16, u16) {
    /// What is left of a number below this is rounding.
    const ROUNDING: f64 = 1e-9;
    let limit = f64::from(u16::MAX);
    let (mut rest, mut last, mut now) = (1.0 / fps, (0.0, 1.0), (1.0, 0.0));
    // Each step doubles the denominator at least: 32 would overflow it twice.
    for _ in 0..32 {
        let whole = rest.floor();
        let next = (whole * now.0 + last.0, whole * now.1 + last.1);
        if next.0 > limit || next.1 > limit {
            break;
        }
        (last, now) = (now, next);
        if rest - whole < ROUNDING * rest.max(1.0) {
            break;
        }
        rest = 1.0 / (rest - whole);
    }
    (now.0 as u16, now.1 as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_add_up_to_the_whole_time() {
        for fps in [
            0.01, 1.0, 12.0, 15.0, 23.976, 24.0, 25.0, 29.97, 30.0, 33.0, 49.0, 50.0, 50.1, 60.0, 120.0,
            1000.0,
        ] {
            for count in [1, 2, 3, 7, 48, 240] {
                let frames = delays(count, fps);
                let total: u64 = frames.iter().map(|(_, delay)| u64::from(*delay)).sum();
                let wanted = count as f64 * 100.0 / fps;
                assert!(
                    (total as f64 - wanted).abs() <= 0.5 || total == SHORTEST,
                    "{count} at {fps}: {total}"
                );
                let mut start = 0_u64;
                for (i, (frame, delay)) in frames.iter().enumerate() {
                    assert!(u64::from(*delay) >= SHORTEST && *frame < count);
                    assert!(i == 0 || frames[i - 1].0 < *frame, "{count} at {fps}");
                    // No frame comes a whole frame or hundredth too early or late.
                    let late = start as f64 - *frame as f64 * 100.0 / fps;
                    assert!(late.abs() <= 0.5_f64.max(50.0 / fps) + 1e-9, "{late}");
                    start += u64::from(*delay);
                }
            }
        }
        assert_eq!(delays(4, 24.0), [(0, 4), (1, 4), (2, 5), (3, 4)]);
        assert_eq!(delays(6, 60.0), [(0, 2), (1, 2), (2, 2), (4, 2), (5, 2)]);
    }

    #[test]
    fn usual_rates_are_exact_fractions() {
        for (fps, expected) in [
            (24.0, (1, 24)),
            (29.97, (100, 2997)),
            (30_000.0 / 1001.0, (1001, 30_000)),
            (24_000.0 / 1001.0, (1001, 24_000)),
            (12.5, (2, 25)),
            (1.0, (1, 1)),
            (0.01, (100, 1)),
            (0.4, (5, 2)),
            (1000.0, (1, 1000)),
        ] {
            assert_eq!(fraction(fps), expected, "{fps}");
        }
        for i in 1..2000 {
            let fps = f64::from(i) * 0.499_317;
            let (over, under) = fraction(fps);
            // What the next convergent, which has no room, would have improved at most: a second in a day.
            let error = (f64::from(over) / f64::from(under) * fps - 1.0).abs();
            assert!(error < 1.0 / f64::from(u16::MAX), "{fps}");
        }
    }
}
