//! What of creases that have been laid may not look as it is meant to.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use wirework_surface::{Step, Terrain};

use crate::crease::Crease;
use crate::ground::wide;
use crate::trace::position;
use crate::{SurfaceView, WrinkleWarning};

/// Edges across a fold longer than this part of its thickness make it jagged.
pub(crate) const COARSE: f64 = 1.0 / 3.0;

/// Whether edges across the folds are too long to show them.
pub(crate) fn coarse(terrain: &Terrain, creases: &[Crease], thickness: f32) -> Option<WrinkleWarning> {
    let across = |crease: &Crease| {
        let edges = crease.steps.windows(2).map(|pair| {
            let along = (position(&pair[1]) - position(&pair[0])).normalize_or_zero();
            let edges = terrain.edges(pair[1].triangle).map(DVec3::from);
            let mut across: Vec<f64> = edges.map(|e| (e - along * e.dot(along)).length()).collect();
            across.sort_unstable_by(f64::total_cmp);
            // The longest of a half of a square is its diagonal, beside which there is another corner.
            across.get(1).copied().unwrap_or(0.0)
        });
        edges.fold(0.0, f64::max)
    };
    let edge = creases.iter().map(across).fold(0.0, f64::max);
    // Rounding of positions is no reason for a word.
    let coarse = edge > f64::from(thickness) * COARSE * 1.001;
    coarse.then_some(WrinkleWarning::Coarse { edge: edge as f32, thickness })
}

/// Whether parts of the surface that hang together with no crease are near one.
pub(crate) fn apart(
    terrain: &Terrain,
    creases: &[Crease],
    thickness: f32,
    surface: &SurfaceView<'_>,
) -> Option<WrinkleWarning> {
    let shells = terrain.shells();
    if shells.iter().all(|shell| *shell == shells[0]) {
        return None;
    }
    let steps = || creases.iter().flat_map(|crease| &crease.steps);
    let corner = |step: &Step| surface.triangles.get(step.triangle as usize).map(|t| shells[t[0] as usize]);
    let own: HashSet<u32> = steps().filter_map(corner).collect();
    let cells = Cells::new(steps().map(position), f64::from(thickness));
    let other = |shell: u32| shell != u32::MAX && !own.contains(&shell);
    let points = surface.positions.iter().zip(&shells);
    let points = points.filter(|(p, shell)| other(**shell) && cells.near(wide(**p))).count();
    (points > 0).then_some(WrinkleWarning::Apart { points })
}

/// Points in cubes as large as a radius: what is within it lies in the cube of a place or in one beside.
struct Cells {
    radius: f64,
    points: HashMap<[i64; 3], Vec<DVec3>>,
}

impl Cells {
    fn new(all: impl Iterator<Item = DVec3>, radius: f64) -> Self {
        let mut cells = Self { radius, points: HashMap::new() };
        for point in all {
            cells.points.entry(cells.at(point)).or_default().push(point);
        }
        cells
    }

    fn at(&self, p: DVec3) -> [i64; 3] {
        // Saturates where the radius is next to nothing.
        (p / self.radius).floor().to_array().map(|c| c as i64)
    }

    /// Whether a point is within the radius of a place.
    fn near(&self, p: DVec3) -> bool {
        let at = self.at(p);
        let beside = (0..27_i64).map(|k| [k % 3, k / 3 % 3, k / 9]);
        beside.map(|k| [0, 1, 2].map(|a| at[a].saturating_add(k[a] - 1))).any(|cell| {
            self.points.get(&cell).is_some_and(|all| all.iter().any(|q| q.distance(p) < self.radius))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_find_what_all_pairs_do() {
        let noise = |i: u32, a: u32| {
            f64::from((i.wrapping_mul(2_654_435_761) ^ a.wrapping_mul(40_503)) % 1009) / 1009.0 - 0.5
        };
        let points: Vec<DVec3> = (0..300).map(|i| DVec3::from([0, 1, 2].map(|a| noise(i, a)))).collect();
        let places: Vec<DVec3> =
            (300..900).map(|i| DVec3::from([5, 6, 7].map(|a| 1.2 * noise(i, a)))).collect();
        for radius in [1e-300, 0.01, 0.07, 0.3, 5.0] {
            let cells = Cells::new(points.iter().copied(), radius);
            for place in &places {
                let near = points.iter().any(|p| p.distance(*place) < radius);
                assert_eq!(cells.near(*place), near, "{place} within {radius}");
            }
        }
    }
}
