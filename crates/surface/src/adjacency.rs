//! How the triangles of a surface hang together.
//!
//! Vertices at equal positions are one place, so that the split vertices of texture seams and hard edges part nothing.

use crate::distinct::Distinct;

/// Stands for no triangle: the edge is a border.
pub(crate) const BORDER: u32 = u32::MAX;
/// Stands for no single triangle: three or more meet at the edge, or two that do not agree which side is out.
pub(crate) const CROWDED: u32 = u32::MAX - 1;

/// The neighbours of triangles and places.
#[derive(Clone, Debug)]
pub(crate) struct Adjacency {
    /// For each vertex its place: the first vertex at its position.
    pub(crate) place_of: Vec<u32>,
    /// The triangles by places. One that has a place twice has no neighbours and is no neighbour.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Beyond the edge from corner `k` to the next: a triangle, [`BORDER`] or [`CROWDED`].
    across: Vec<[u32; 3]>,
    /// Where the triangles of each place start in `fans`.
    starts: Vec<u32>,
    fans: Vec<u32>,
    /// The places beside each place, and where those of each start.
    beside_starts: Vec<u32>,
    beside: Vec<u32>,
    /// Vertices that are not the first at their place: the place and the vertex, rising.
    split: Vec<(u32, u32)>,
}

impl Adjacency {
    /// Of triangles whose indices are in range.
    pub(crate) fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        Self::of_places(places(positions), triangles)
    }

    /// The same where vertices and places are told.
    pub(crate) fn of_places(place_of: Vec<u32>, triangles: &[[u32; 3]]) -> Self {
        let count = place_of.len();
        let triangles: Vec<[u32; 3]> =
            triangles.iter().map(|triangle| triangle.map(|v| place_of[v as usize])).collect();
        let (starts, fans) = fans(count, &triangles);
        let second = |(&place, vertex): (&u32, u32)| (place != vertex).then_some((place, vertex));
        let mut split: Vec<(u32, u32)> = place_of.iter().zip(0..).filter_map(second).collect();
        split.sort_unstable();
        let across = vec![[BORDER; 3]; triangles.len()];
        let (beside_starts, beside) = (vec![0], Vec::with_capacity(fans.len() + fans.len() / 8));
        let mut adjacency = Self { place_of, triangles, across, starts, fans, beside_starts, beside, split };
        for place in 0..count as u32 {
            adjacency.add_beside(place);
        }
        for triangle in 0..adjacency.triangles.len() {
            if proper(adjacency.triangles[triangle]) {
                adjacency.across[triangle] = [0, 1, 2].map(|edge| adjacency.find(triangle as u32, edge));
            }
        }
        adjacency
    }

    /// What lies beyond the edge of a triangle from corner `edge` to the next.
    pub(crate) fn across(&self, triangle: u32, edge: usize) -> u32 {
        self.across[triangle as usize][edge]
    }

    /// The triangles round a place, by rising number.
    pub(crate) fn fan(&self, place: u32) -> &[u32] {
        let place = place as usize;
        &self.fans[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    /// The places that share a triangle with a place, each once.
    pub(crate) fn beside(&self, place: u32) -> &[u32] {
        let place = place as usize;
        &self.beside[self.beside_starts[place] as usize..self.beside_starts[place + 1] as usize]
    }

    /// Finds those of the next place.
    fn add_beside(&mut self, place: u32) {
        let first = self.beside.len();
        let fan = self.starts[place as usize] as usize..self.starts[place as usize + 1] as usize;
        for slot in fan {
            for corner in self.triangles[self.fans[slot] as usize] {
                if corner != place && !self.beside[first..].contains(&corner) {
                    self.beside.push(corner);
                }
            }
        }
        self.beside_starts.push(self.beside.len() as u32);
    }

    /// The vertices at a place beside the first.
    pub(crate) fn split(&self, place: u32) -> &[(u32, u32)] {
        let start = self.split.partition_point(|(other, _)| *other < place);
        let count = self.split[start..].partition_point(|(other, _)| *other == place);
        &self.split[start..start + count]
    }

    fn find(&self, triangle: u32, edge: usize) -> u32 {
        let corners = self.triangles[triangle as usize];
        let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
        let mut beyond = BORDER;
        for &other in self.fan(a).iter().filter(|&&other| other != triangle) {
            let corners = self.triangles[other as usize];
            let Some(k) = (0..3).find(|&k| corners[k] == a) else { continue };
            if corners[(k + 1) % 3] == b || (corners[(k + 2) % 3] == b && beyond != BORDER) {
                return CROWDED;
            }
            if corners[(k + 2) % 3] == b {
                beyond = other;
            }
        }
        beyond
    }
}

/// Whether a triangle has three places.
pub(crate) fn proper([a, b, c]: [u32; 3]) -> bool {
    a != b && b != c && c != a
}

fn places(positions: &[[f32; 3]]) -> Vec<u32> {
    let Distinct { of, first } = Distinct::new(positions.len(), |i| positions[i]);
    of.into_iter().map(|place| first[place as usize]).collect()
}

fn fans(places: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let used = || triangles.iter().zip(0_u32..).filter(|(triangle, _)| proper(**triangle));
    let mut starts = vec![0_u32; places + 1];
    for place in used().flat_map(|(triangle, _)| triangle) {
        starts[*place as usize + 1] += 1;
    }
    for i in 0..places {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut fans = vec![0; starts[places] as usize];
    for (triangle, number) in used() {
        for &place in triangle {
            let slot = &mut next[place as usize];
            fans[*slot as usize] = number;
            *slot += 1;
        }
    }
    (starts, fans)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn neighbours_share_an_edge_in_opposite_directions() {
        let adjacency = Adjacency::new(&SQUARE, &[[0, 1, 2], [0, 2, 3]]);
        assert_eq!([0, 1, 2].map(|edge| adjacency.across(0, edge)), [BORDER, BORDER, 1]);
        assert_eq!([0, 1, 2].map(|edge| adjacency.across(1, edge)), [0, BORDER, BORDER]);
        assert_eq!((adjacency.fan(0), adjacency.fan(1)), (&[0, 1][..], &[0][..]));
    }

    #[test]
    fn split_vertices_part_nothing() {
        let positions = [SQUARE[0], SQUARE[1], SQUARE[2], [-0.0, 0.0, 0.0], SQUARE[2], SQUARE[3]];
        let adjacency = Adjacency::new(&positions, &[[0, 1, 2], [3, 4, 5]]);
        assert_eq!((adjacency.across(0, 2), adjacency.across(1, 0)), (1, 0));
        assert_eq!(adjacency.place_of, [0, 1, 2, 0, 2, 5]);
    }

    #[test]
    fn crowded_edges_lead_nowhere() {
        // Three at an edge; two that are turned against each other.
        let three = Adjacency::new(&SQUARE, &[[0, 1, 2], [0, 2, 3], [0, 2, 1]]);
        assert_eq!((three.across(0, 2), three.across(1, 0), three.across(2, 0)), (CROWDED, CROWDED, CROWDED));
        let turned = Adjacency::new(&SQUARE, &[[0, 1, 2], [0, 3, 2]]);
        assert_eq!((turned.across(0, 2), turned.across(1, 2)), (CROWDED, CROWDED));
    }

    #[test]
    fn a_triangle_that_has_a_place_twice_is_stepped_over() {
        let adjacency = Adjacency::new(&SQUARE, &[[0, 1, 2], [0, 2, 2], [0, 2, 3]]);
        assert_eq!((adjacency.across(0, 2), adjacency.across(2, 0)), (2, 0));
        assert_eq!(adjacency.across(1, 0), BORDER);
    }
}
