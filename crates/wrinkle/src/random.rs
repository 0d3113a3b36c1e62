//! Jitter that depends on nothing but its arguments.

/// What is jittered; each takes numbers of its own, so that one more kind leaves the others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Jitter {
    Sideways = 1,
    Height = 2,
    Start = 3,
    End = 4,
    Askew = 5,
}

/// A number in `[0, 1)` for crease `index`: the splitmix64 generator (Steele, Lea and Flood 2014) as a hash.
pub(crate) fn unit(seed: u64, index: usize, what: Jitter) -> f64 {
    let mixed = mix(mix(mix(seed) ^ index as u64) ^ what as u64);
    // The upper 53 bits are a double without rounding.
    (mixed >> 11) as f64 / (1_u64 << 53) as f64
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
}
