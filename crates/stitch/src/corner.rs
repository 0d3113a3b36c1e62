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

/// Ends that meet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    /// Rising.
    pub(crate) ends: Vec<End>,
    /// Pairs of them, by their places in the list, that share a vertex.
    links: Vec<[usize; 2]>,
}

impl Corner {
    /// For each end how much each of the ends counts for it: their closures, times the least closure on the way from the one to the other.
    /// So a seam that is apart joins no others, and all between which the way is closed have the same.
    pub(crate) fn weights(&self, closure: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let count = self.ends.len();
        let own: Vec<f64> = self.ends.iter().map(|end| closure(end.seam)).collect();
        if own.iter().all(|c| *c == 1.0) {
            return vec![vec![1.0; count]; count];
        }
        let mut ways = vec![vec![0.0_f64; count]; count];
        for (i, way) in ways.iter_mut().enumerate() {
            way[i] = 1.0;
        }
        for &[i, j] in &self.links {
            (ways[i][j], ways[j][i]) = (1.0, 1.0);
        }
        for (k, own) in own.iter().enumerate() {
            let through: Vec<f64> = ways[k].iter().map(|way| way.min(*own)).collect();
            for way in &mut ways {
                let to = way[k];
                way.iter_mut().zip(&through).for_each(|(way, through)| *way = way.max(to.min(*through)));
            }
        }
        ways.iter().map(|way| way.iter().zip(&own).map(|(way, own)| way * own).collect()).collect()
    }
}

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
    let mut groups: Vec<Vec<End>> = Vec::new();
    for ends in at.values() {
        let mut known: Vec<usize> = ends.iter().filter_map(|end| corner_of.get(end).copied()).collect();
        known.sort_unstable();
        known.dedup();
        let mut all = ends.clone();
        for &corner in &known {
            all.append(&mut groups[corner]);
        }
        all.sort_unstable();
        all.dedup();
        let home = known.first().copied().unwrap_or_else(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        corner_of.extend(all.iter().map(|end| (*end, home)));
        groups[home] = all;
    }
    let mut links: Vec<Vec<[usize; 2]>> = vec![Vec::new(); groups.len()];
    for ends in at.values() {
        let Some(&home) = ends.first().and_then(|end| corner_of.get(end)) else { continue };
        let places: Vec<usize> = ends.iter().filter_map(|end| groups[home].binary_search(end).ok()).collect();
        for (i, &one) in places.iter().enumerate() {
            links[home].extend(places[..i].iter().map(|&two| [one, two]));
        }
    }
    let all = groups.into_iter().zip(links).map(|(ends, links)| Corner { ends, links });
    all.filter(|corner| !corner.ends.is_empty()).collect()
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
        let middle: Vec<End> = (0..4).map(|seam| End { seam, last: false }).collect();
        let corner = found.iter().find(|corner| corner.ends == middle).unwrap();
        assert_eq!(found.iter().map(|corner| corner.ends.len()).sum::<usize>(), 8);
        // Seam 0 and 1 share no vertex: with both seams between them apart they know nothing of each other.
        assert_eq!(corner.weights(|_| 1.0), vec![vec![1.0; 4]; 4]);
        let apart = corner.weights(|seam| if seam < 2 { 1.0 } else { 0.0 });
        assert_eq!(
            apart,
            [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]]
        );
        let half = corner.weights(|seam| [1.0, 1.0, 0.5, 0.25][seam]);
        assert_eq!(half[0], [1.0, 0.5, 0.5, 0.25]);
    }
}
