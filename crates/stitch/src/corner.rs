//! Where seams meet: \[SF98\] §5.2, Figure 19.
//!
//! Ends of seams that share a vertex of a piece are one corner. All of them come to lie in the mean of where each would lie by
//! itself, so that no seam goes before another.

use std::collections::BTreeMap;

use crate::pairing::Track;

/// One end of a seam: the first, 0, or the last, 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct End {
    pub(crate) seam: usize,
    pub(crate) last: bool,
}

impl End {
    /// Its place in a list of two.
    pub(crate) fn index(self) -> usize {
        usize::from(self.last)
    }
}

/// Ends that meet, rising.
pub(crate) type Corner = Vec<End>;

/// All corners; an end that meets no other is one by itself.
pub(crate) fn corners(seams: &[[&Track; 2]]) -> Vec<Corner> {
    let mut at: BTreeMap<u32, Vec<End>> = BTreeMap::new();
    for (seam, tracks) in seams.iter().enumerate() {
        for ends in tracks.iter().filter_map(|track| track.path.ends()) {
            for (vertex, last) in ends.into_iter().zip([false, true]) {
                at.entry(vertex).or_default().push(End { seam, last });
            }
        }
    }
    let mut corner_of: BTreeMap<End, usize> = BTreeMap::new();
    let mut corners: Vec<Corner> = Vec::new();
    for ends in at.into_values() {
        let mut known: Vec<usize> = ends.iter().filter_map(|end| corner_of.get(end).copied()).collect();
        known.sort_unstable();
        known.dedup();
        let mut all = ends;
        for &corner in &known {
            all.append(&mut corners[corner]);
        }
        all.sort_unstable();
        all.dedup();
        let home = known.first().copied().unwrap_or_else(|| {
            corners.push(Vec::new());
            corners.len() - 1
        });
        corner_of.extend(all.iter().map(|end| (*end, home)));
        corners[home] = all;
    }
    corners.retain(|corner| !corner.is_empty());
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Path;

    fn track(vertices: &[u32]) -> Track {
        let t = (0..vertices.len()).map(|i| i as f64 / (vertices.len() - 1) as f64).collect();
        Track { path: Path { vertices: vertices.to_vec(), closed: false }, t }
    }

    #[test]
    fn four_patches_meet_in_one_point() {
        // Patches 0, 10, 20, 30; each has its corner at the middle at its number.
        let seams =
            [[0, 10], [20, 30], [0, 20], [10, 30]].map(|[a, b]| [track(&[a, a + 1]), track(&[b, b + 2])]);
        let tracks: Vec<[&Track; 2]> = seams.iter().map(|[a, b]| [a, b]).collect();
        let found = corners(&tracks);
        let middle: Corner = (0..4).map(|seam| End { seam, last: false }).collect();
        assert!(found.contains(&middle), "{found:?}");
        assert_eq!(found.iter().map(Vec::len).sum::<usize>(), 8);
    }
}
