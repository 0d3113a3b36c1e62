//! The borders of a surface: edges with a face on one side only, one after the other.

use std::collections::BTreeMap;

/// A border, vertex after vertex, in the direction in which the face of its first edge goes round.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Border {
    /// Behind the last comes the first, unless it branches. One that touches itself in a vertex has it more than once.
    pub(crate) vertices: Vec<u32>,
    /// A vertex in which three or more edges of border meet, so that there is no one way on.
    pub(crate) branch: Option<u32>,
}

/// All borders of a surface whose triangles are these, each as its vertices in a row: runs and loops of seams lie on them. A border begins
/// with its vertex of the least number; one that has no one way on, since three edges of border meet in a vertex, ends there.
pub fn border_loops(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    borders(triangles).into_iter().map(|border| border.vertices).collect()
}

/// An edge of the border, as its face has it.
#[derive(Clone, Copy, Debug)]
struct Rim {
    ends: [u32; 2],
}

/// All borders of a surface, each from its vertex with the least number. Triangles without three vertices do not count.
pub(crate) fn borders(triangles: &[[u32; 3]]) -> Vec<Border> {
    let rims = rims(triangles);
    let at = meetings(&rims, triangles);
    let mut done = vec![false; rims.len()];
    let mut out = Vec::new();
    for first in 0..rims.len() {
        if !done[first] {
            out.push(trace(first, &rims, &at, &mut done));
        }
    }
    out
}

/// The edges that only one face has, in order.
fn rims(triangles: &[[u32; 3]]) -> Vec<Rim> {
    let mut sides: Vec<([u32; 2], [u32; 2])> = Vec::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a) {
        sides.extend([[a, b], [b, c], [c, a]].map(|[u, v]| ([u.min(v), u.max(v)], [u, v])));
    }
    sides.sort_unstable();
    let single = sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let mut rims: Vec<Rim> = single.map(|same| Rim { ends: same[0].1 }).collect();
    rims.sort_unstable_by_key(|rim| rim.ends);
    rims
}

/// For each vertex of a border the pairs of its edges that follow each other: those of one fan of faces.
fn meetings(rims: &[Rim], triangles: &[[u32; 3]]) -> BTreeMap<u32, Vec<Vec<usize>>> {
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, rim) in rims.iter().enumerate() {
        rim.ends.iter().for_each(|end| at.entry(*end).or_default().push(index));
    }
    let crowded = |vertex: &u32| at.get(vertex).is_some_and(|edges| edges.len() > 2);
    let mut faces: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (face, triangle) in (0_u32..).zip(triangles) {
        for vertex in triangle.iter().filter(|vertex| crowded(vertex)) {
            faces.entry(*vertex).or_default().push(face);
        }
    }
    let groups = |(vertex, edges): (u32, Vec<usize>)| match faces.get(&vertex) {
        None => (vertex, vec![edges]),
        Some(faces) => (vertex, fans(vertex, &edges, faces, rims, triangles)),
    };
    at.clone().into_iter().map(groups).collect()
}

/// The edges of border at a vertex, by the fan of faces that they bound: those that hang together by edges at the vertex.
fn fans(
    vertex: u32,
    edges: &[usize],
    faces: &[u32],
    rims: &[Rim],
    triangles: &[[u32; 3]],
) -> Vec<Vec<usize>> {
    // By the far ends of edges at the vertex: each leads to another of its fan, and at last to the one that stands for it.
    let mut leads: BTreeMap<u32, u32> = BTreeMap::new();
    let find = |leads: &mut BTreeMap<u32, u32>, mut end: u32| {
        while let Some(&next) = leads.get(&end).filter(|next| **next != end) {
            let after = leads.get(&next).copied().unwrap_or(next);
            leads.insert(end, after);
            end = next;
        }
        end
    };
    for &face in faces {
        let mut ends = triangles[face as usize].into_iter().filter(|other| *other != vertex);
        if let (Some(one), Some(two)) = (ends.next(), ends.next()) {
            let [one, two] = [one, two].map(|end| find(&mut leads, end));
            leads.insert(one.max(two), one.min(two));
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &edge in edges {
        let [a, b] = rims[edge].ends;
        groups.entry(find(&mut leads, a ^ b ^ vertex)).or_default().push(edge);
    }
    groups.into_values().collect()
}

/// Follows the border from an edge on.
fn trace(first: usize, rims: &[Rim], at: &BTreeMap<u32, Vec<Vec<usize>>>, done: &mut [bool]) -> Border {
    let [start, mut vertex] = rims[first].ends;
    let mut vertices = vec![start];
    let mut edge = first;
    done[first] = true;
    loop {
        let group = at.get(&vertex).and_then(|groups| groups.iter().find(|group| group.contains(&edge)));
        let next = match group.map(Vec::as_slice) {
            Some(&[one, two]) => one ^ two ^ edge,
            _ => return Border { vertices, branch: Some(vertex) },
        };
        if next == first {
            return Border { vertices, branch: None };
        }
        if std::mem::replace(&mut done[next], true) {
            return Border { vertices, branch: Some(vertex) };
        }
        vertices.push(vertex);
        let [a, b] = rims[next].ends;
        vertex ^= a ^ b;
        edge = next;
    }
}

#[cfg(test)]
mod tests {
    use wirework_surface::{Mesh, cuboid, grid, tube};

    use super::*;

    fn of(mesh: &Mesh) -> Vec<Border> {
        borders(&mesh.triangles().unwrap())
    }

    #[test]
    fn a_grid_has_one_a_tube_two_and_a_box_none() {
        let found = of(&grid([1.0, 1.0], [3, 2], [0.0, 1.0, 0.0]).unwrap());
        assert_eq!((found.len(), found[0].vertices.len(), found[0].branch), (1, 10, None));
        let found = of(&tube([0.0; 3], [0.0, 1.0, 0.0], 0.5, 7, 3, false).unwrap());
        assert_eq!(found.iter().map(|b| b.vertices.len()).collect::<Vec<_>>(), [7, 7]);
        assert!(of(&cuboid([0.0; 3], [1.0; 3], [2, 2, 2]).unwrap()).is_empty());
    }

    #[test]
    fn borders_run_as_their_faces_do() {
        let found = borders(&[[0, 1, 2], [0, 2, 3]]);
        assert_eq!(found, [Border { vertices: vec![0, 1, 2, 3], branch: None }]);
        // Faces that disagree about the outside have one border all the same.
        let found = borders(&[[0, 1, 2], [0, 3, 2]]);
        assert_eq!((found.len(), found[0].vertices.len(), found[0].branch), (1, 4, None));
    }

    #[test]
    fn sheets_that_touch_in_a_point_have_a_border_each() {
        let found = borders(&[[0, 1, 2], [2, 3, 4]]);
        assert_eq!(found.iter().map(|b| &b.vertices[..]).collect::<Vec<_>>(), [&[0, 1, 2][..], &[2, 3, 4]]);
        assert!(found.iter().all(|border| border.branch.is_none()));
    }

    #[test]
    fn a_hole_that_touches_itself_is_one_border_and_large_fans_take_no_time() {
        // Two square holes of a sheet that share a corner.
        let mesh = grid([4.0, 4.0], [4, 4], [0.0, 1.0, 0.0]).unwrap();
        let kept: Vec<[u32; 3]> = (0..)
            .zip(mesh.triangles().unwrap())
            .filter(|(i, _)| ![5, 10].contains(&(i / 2)))
            .map(|(_, t)| t)
            .collect();
        let found = borders(&kept);
        assert!(found.iter().all(|border| border.branch.is_none()));
        assert_eq!(found.iter().map(|border| border.vertices.len()).sum::<usize>(), 16 + 8);
        // A fan and a face beside it that shares the middle alone.
        let n = 20_000_u32;
        let fan = (1..n).map(|k| [0, k, k + 1]).chain([[0, n + 1, n + 2]]).collect::<Vec<_>>();
        assert_eq!(
            borders(&fan).iter().map(|border| border.vertices.len()).sum::<usize>(),
            n as usize + 1 + 3
        );
    }

    #[test]
    fn where_three_faces_meet_in_an_edge_the_border_branches() {
        let found = borders(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert!(found.iter().any(|border| border.branch.is_some()), "{found:?}");
        assert!(borders(&[[0, 0, 1], [2, 2, 2]]).is_empty());
    }
}
