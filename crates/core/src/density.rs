//! \[SF98\] §2, the density `f`: how influence falls with the distance from the wire, as a fraction of the radius.
//!
//! `f(0) = 1`, `f(x ≥ 1) = 0`, falling. A deformed surface is as smooth as `f`, so all but
//! [`Density::Linear`] have a continuous first derivative, across the wire as well: `f′(0) = f′(1) = 0`
//! (footnote 1 of the paper).

use thiserror::Error;

/// The fall of influence from the wire outwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Density {
    /// `(1 − x²)²`, the paper's.
    #[default]
    Quartic,
    /// `(1 − x²)³`, C².
    Sextic,
    /// `1 − 3x² + 2x³`.
    Smoothstep,
    /// `1 − x`, a ridge.
    Linear,
    /// `(1 − x^q)²`, `q ≥ 1`: a sharp crease at 1, the quartic at 2, a broad fold beyond. Half of its height lies
    /// at `x = 0.293^(1/q)`.
    Fold(f32),
    /// A monotone cubic through given points.
    Profile(Profile),
}

impl Density {
    /// `f(x)`; 1 below 0 and 0 from 1 on.
    pub fn at(&self, x: f64) -> f64 {
        if x >= 1.0 || x.is_nan() {
            return 0.0;
        }
        let x = x.max(0.0);
        match self {
            Self::Quartic => (1.0 - x * x).powi(2),
            Self::Sextic => (1.0 - x * x).powi(3),
            Self::Smoothstep => 1.0 - x * x * (3.0 - 2.0 * x),
            Self::Linear => 1.0 - x,
            Self::Fold(q) => (1.0 - x.powf(f64::from(*q))).powi(2),
            Self::Profile(profile) => profile.at(x),
        }
    }
}

/// A density drawn as points `(x, f)`: a monotone cubic (Fritsch and Butland 1984) with slope 0 at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// `(x, f, slope)`, from `(0, 1)` to `(1, 0)`.
    knots: Vec<[f64; 3]>,
}

/// Why points do not make a density.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// A number is NaN or infinite, or lies outside `[0, 1]`.
    #[error("point {index} of the profile lies outside the square from (0, 0) to (1, 1)")]
    Outside {
        /// Which point, from 0.
        index: usize,
    },
    /// `x` does not rise or `f` rises.
    #[error("point {index} of the profile must lie to the right of the one before and not above it")]
    Order {
        /// Which point, from 0.
        index: usize,
    },
    /// The profile starts or ends at another value than a density's.
    #[error("point {index} of the profile contradicts f(0) = 1 and f(1) = 0")]
    Ends {
        /// Which point, from 0.
        index: usize,
    },
}

impl Profile {
    /// The monotone cubic through `points`, by strictly rising `x` and falling `f`. `(0, 1)` and `(1, 0)` are added
    /// where they are missing.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, ProfileError> {
        let mut line: Vec<(f64, f64)> = Vec::with_capacity(points.len() + 2);
        for (index, &(x, f)) in points.iter().enumerate() {
            if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&f) {
                return Err(ProfileError::Outside { index });
            }
            if (x == 0.0 && f != 1.0) || (x == 1.0 && f != 0.0) {
                return Err(ProfileError::Ends { index });
            }
            if index == 0 && x > 0.0 {
                line.push((0.0, 1.0));
            }
            if line.last().is_some_and(|&(x0, f0)| x <= x0 || f > f0) {
                return Err(ProfileError::Order { index });
            }
            line.push((x, f));
        }
        if line.is_empty() {
            line.push((0.0, 1.0));
        }
        if line.last().is_some_and(|&(x, _)| x < 1.0) {
            line.push((1.0, 0.0));
        }
        let secant = |i: usize| (line[i + 1].1 - line[i].1) / (line[i + 1].0 - line[i].0);
        let slope = |i: usize| {
            if i == 0 || i + 1 == line.len() {
                return 0.0;
            }
            let (a, b) = (secant(i - 1), secant(i));
            if a * b <= 0.0 {
                return 0.0;
            }
            let (h0, h1) = (line[i].0 - line[i - 1].0, line[i + 1].0 - line[i].0);
            let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
            (w0 + w1) / (w0 / a + w1 / b)
        };
        Ok(Self { knots: (0..line.len()).map(|i| [line[i].0, line[i].1, slope(i)]).collect() })
    }

    fn at(&self, x: f64) -> f64 {
        let i = self.knots.partition_point(|k| k[0] <= x).clamp(1, self.knots.len() - 1);
        let ([x0, f0, s0], [x1, f1, s1]) = (self.knots[i - 1], self.knots[i]);
        let h = x1 - x0;
        let t = (x - x0) / h;
        let (a, b) = (s0 * h - (f1 - f0), (f1 - f0) - s1 * h);
        let bulge = a * (1.0 - t) + b * t;
        (f0 + (f1 - f0) * t + t * (1.0 - t) * bulge).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_density_falls_from_one_to_zero() {
        let profile = Profile::new(&[(0.2, 0.9), (0.5, 0.2), (0.6, 0.2)]).unwrap();
        for f in [
            Density::Quartic,
            Density::Sextic,
            Density::Smoothstep,
            Density::Linear,
            Density::Fold(1.0),
            Density::Fold(4.0),
            Density::Profile(profile),
        ] {
            assert_eq!((f.at(0.0), f.at(1.0), f.at(7.0), f.at(-1.0)), (1.0, 0.0, 0.0, 1.0), "{f:?}");
            let samples: Vec<f64> = (0..=1000).map(|i| f.at(f64::from(i) / 1000.0)).collect();
            assert!(samples.windows(2).all(|w| w[1] <= w[0]), "{f:?} rises");
        }
    }

    #[test]
    fn a_profile_passes_through_its_points_with_a_continuous_slope() {
        let points = [(0.1, 0.95), (0.4, 0.5), (0.7, 0.1)];
        let f = Density::Profile(Profile::new(&points).unwrap());
        for (x, y) in points {
            assert!((f.at(x) - y).abs() < 1e-12);
            let h = 1e-6;
            let (left, right) = ((f.at(x) - f.at(x - h)) / h, (f.at(x + h) - f.at(x)) / h);
            assert!((left - right).abs() < 1e-4, "slopes {left} and {right} at {x}");
        }
        let h = 1e-7;
        assert!((f.at(h) - 1.0).abs() / h < 1e-4 && f.at(1.0 - h) / h < 1e-4);
    }

    #[test]
    fn a_profile_that_is_no_density_is_refused_at_its_point() {
        assert_eq!(Profile::new(&[(0.0, 0.5)]), Err(ProfileError::Ends { index: 0 }));
        assert_eq!(Profile::new(&[(0.3, 0.5), (0.3, 0.4)]), Err(ProfileError::Order { index: 1 }));
        assert_eq!(Profile::new(&[(0.3, 0.5), (0.4, 0.6)]), Err(ProfileError::Order { index: 1 }));
        assert_eq!(Profile::new(&[(0.3, f64::NAN)]), Err(ProfileError::Outside { index: 0 }));
        assert!(Profile::new(&[]).is_ok());
    }
}
