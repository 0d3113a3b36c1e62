//! How high folds stand that take up a given part of the length of cloth.
//!
//! Cloth of length `L₀` pushed together to `L = (1 − c)·L₀` is longer than what it lies on, and stands up in folds. For a sine of
//! wavelength `λ` the crest is `(2λ/π)·√(L₀/L − 1)` over its trough, to first order. Here the arc length of the very cross-section that
//! the wires make is solved for: a fold each `λ`, blended where they overlap.

use wirework_core::{Blend, Density};

/// Samples of a cross-section over half a wavelength.
const SAMPLES: usize = 256;
/// Halvings of the range in which the height is sought: to a millionth of it.
const HALVINGS: usize = 24;
/// No fold is higher than so many wavelengths: where folds overlap so much that they leave no hollows, none would be high enough.
const HIGHEST: f64 = 4.0;
/// Ratios of thickness to wavelength for which heights are worked out, a step in each power of two.
const STEPS: f64 = 32.0;

/// Heights in wavelengths, by the ratio of thickness to wavelength.
#[derive(Clone, Debug)]
pub(crate) struct Crests {
    /// The binary logarithm of the first ratio.
    first: f64,
    heights: Vec<f64>,
}

impl Crests {
    /// For folds that take up the part `compression` of the length, with ratios of thickness to wavelength in a range.
    pub(crate) fn new(compression: f64, density: &Density, blend: &Blend, ratios: (f64, f64)) -> Self {
        let first = ratios.0.log2();
        let count = ((ratios.1.log2() - first) * STEPS).ceil().clamp(0.0, 1024.0) as usize + 2;
        let height = |i: usize| height(compression, density, blend, (first + i as f64 / STEPS).exp2());
        Self { first, heights: (0..count).map(height).collect() }
    }

    /// The height of folds of a thickness at a wavelength.
    pub(crate) fn at(&self, thickness: f64, wavelength: f64) -> f64 {
        if wavelength <= 0.0 {
            return 0.0;
        }
        let last = (self.heights.len() - 2) as f64;
        let x = (((thickness / wavelength).log2() - self.first) * STEPS).clamp(0.0, last + 1.0);
        let i = x.floor().min(last);
        let (a, b) = (self.heights[i as usize], self.heights[i as usize + 1]);
        (a + (b - a) * (x - i)) * wavelength
    }
}

/// The height in wavelengths.
fn height(compression: f64, density: &Density, blend: &Blend, ratio: f64) -> f64 {
    let section = section(density, blend, ratio);
    let wanted = 1.0 / (1.0 - compression);
    let (mut low, mut high) = (0.0, HIGHEST);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if length(&section, middle) < wanted { low = middle } else { high = middle }
    }
    low
}

/// Half a wavelength of the cross-section of a train of folds of height 1, from crest to hollow.
fn section(density: &Density, blend: &Blend, ratio: f64) -> Vec<f64> {
    let around = ratio.ceil().min(63.0) as i32 + 1;
    let sample = |i: usize| {
        let x = i as f64 / SAMPLES as f64 / 2.0;
        let folds = (-around..=around).map(|k| density.at((x - f64::from(k)).abs() / ratio));
        blended(&folds.filter(|f| *f > 0.0).collect::<Vec<_>>(), blend)
    };
    (0..=SAMPLES).map(sample).collect()
}

/// \[SF98\] §4 for parallel displacements of these lengths, which are the influences too.
fn blended(folds: &[f64], blend: &Blend) -> f64 {
    let highest = folds.iter().copied().fold(0.0, f64::max);
    if highest <= 0.0 {
        return 0.0;
    }
    let mean = |exponent: f32| {
        let weight = |f: f64| (f / highest).powf(f64::from(exponent));
        folds.iter().map(|&f| f * weight(f)).sum::<f64>() / folds.iter().map(|&f| weight(f)).sum::<f64>()
    };
    let sum = folds.iter().sum::<f64>();
    let all = mean(blend.exponent) + (sum - mean(blend.exponent)) * f64::from(blend.crossing);
    all + (mean(blend.locality) - all) * f64::from(blend.localize)
}

/// The length of a cross-section of a height, in wavelengths.
fn length(section: &[f64], height: f64) -> f64 {
    let step = 1.0 / (SAMPLES as f64);
    section.windows(2).map(|pair| step.hypot(2.0 * height * (pair[1] - pair[0]))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_are_as_long_as_the_cloth_was() {
        for q in [1.0, 2.0, 4.0] {
            let density = Density::Fold(q);
            for compression in [0.01, 0.1, 0.4] {
                let crests = Crests::new(compression, &density, &Blend::default(), (0.2, 0.9));
                for ratio in [0.2, 0.33, 0.5, 0.77, 0.9] {
                    let height = crests.at(ratio * 3.0, 3.0) / 3.0;
                    // Brute force over a whole wavelength.
                    let profile = |x: f64| {
                        let folds = [-1.0, 0.0, 1.0, 2.0].map(|k: f64| density.at((x - k).abs() / ratio));
                        let sum: f64 = folds.iter().sum();
                        if sum > 0.0 { height * folds.iter().map(|f| f * f).sum::<f64>() / sum } else { 0.0 }
                    };
                    let step = 1e-5;
                    let length: f64 = (0..100_000)
                        .map(|i| f64::from(i) * step)
                        .map(|x| step.hypot(profile(x + step) - profile(x)))
                        .sum();
                    let found = 1.0 - 1.0 / length;
                    assert!((found / compression - 1.0).abs() < 0.01, "{q} {compression} {ratio}: {found}");
                }
            }
        }
    }

    #[test]
    fn small_heights_follow_the_square_root() {
        // The paper's quartic with thickness of half a wavelength is nearly a raised sine.
        let of = |c| height(c, &Density::Quartic, &Blend { crossing: 1.0, ..Blend::default() }, 0.5);
        let first = |c: f64| 2.0 / std::f64::consts::PI * (1.0 / (1.0 - c) - 1.0).sqrt();
        for c in [0.001, 0.01, 0.05] {
            assert!((of(c) / first(c) - 1.0).abs() < 0.15, "{c}: {} {}", of(c), first(c));
        }
        assert!((of(0.004) / of(0.001) - 2.0).abs() < 0.02);
    }

    #[test]
    fn nothing_taken_up_is_no_height_and_smooth_cloth_has_a_limit() {
        assert!(height(0.0, &Density::Quartic, &Blend::default(), 0.5) < 1e-6);
        assert!(height(0.3, &Density::Quartic, &Blend::default(), 40.0) <= HIGHEST);
        let crests = Crests::new(0.1, &Density::Quartic, &Blend::default(), (0.5, 0.5));
        assert_eq!(crests.at(0.1, 0.0), 0.0);
        assert!(crests.at(0.1, 0.2) > 0.0);
    }
}
