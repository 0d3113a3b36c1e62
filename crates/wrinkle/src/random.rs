//! Jitter that depends on nothing but its arguments.

/// What is jittered; each takes numbers of its own, so that one more kind leaves the others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Jitter {
    Sideways = 1,
    Height = 2,
    Start = 3,
    End = 4,
    Askew = 5,
    Gust = 6,
    SharedGust = 7,
}

/// A number in `[0, 1)` for crease `index`: the splitmix64 generator (Steele, Lea and Flood 2014) as a hash.
pub(crate) fn unit(seed: u64, index: usize, what: Jitter) -> f64 {
    let mixed = mix(mix(mix(seed) ^ index as u64) ^ what as u64);
    // The upper 53 bits are a double without rounding.
    (mixed >> 11) as f64 / (1_u64 << 53) as f64
}

/// A number in `[-1, 1]` that varies smoothly with `x`: value noise, by the quintic of \[Perlin 2002\] from one random number to
/// the next, a unit of `x` apart, so that its second derivative is continuous too.
pub(crate) fn smooth(seed: u64, index: usize, what: Jitter, x: f64) -> f64 {
    let cell = x.floor();
    let corner = |cell: f64| 2.0 * unit(mix(seed) ^ (cell as i64 as u64), index, what) - 1.0;
    let t = x - cell;
    let share = t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    corner(cell) * (1.0 - share) + corner(cell + 1.0) * share
}

fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_is_splitmix64() {
        // The first output of the published generator for seed 0.
        assert_eq!(mix(0), 0xE220_A839_7B1D_CDAF);
    }

    #[test]
    fn numbers_are_spread_and_differ() {
        let all: Vec<f64> = (0..1000).map(|i| unit(7, i, Jitter::Height)).collect();
        let mean = all.iter().sum::<f64>() / 1000.0;
        assert!((mean - 0.5).abs() < 0.03 && all.iter().all(|x| (0.0..1.0).contains(x)));
        assert_ne!(unit(7, 0, Jitter::Start), unit(7, 0, Jitter::End));
        assert_ne!(unit(7, 0, Jitter::Start), unit(8, 0, Jitter::Start));
    }

    #[test]
    fn noise_is_smooth_and_takes_all_values() {
        let noise = |x: f64| smooth(3, 5, Jitter::Gust, x);
        let step = 1e-3;
        let all: Vec<f64> = (-50_000..50_000).map(|i| noise(f64::from(i) * step)).collect();
        // The quintic is steepest in its middle, 15/8, and bends by 10/√3 at most; a cell spans a height of 2 at most.
        for w in all.windows(3) {
            assert!(
                (w[1] - w[0]).abs() <= 3.75 * step && (w[0] - 2.0 * w[1] + w[2]).abs() <= 12.0 * step * step
            );
        }
        let range = all.iter().fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
        assert!(range.0 >= -1.0 && range.0 < -0.9 && range.1 > 0.9 && range.1 <= 1.0, "{range:?}");
        assert_ne!(noise(0.3), smooth(4, 5, Jitter::Gust, 0.3));
        assert_ne!(noise(0.3), smooth(3, 6, Jitter::Gust, 0.3));
    }
}
