//! The borders of a surface: edges with a face on one side only, one after the other.

use std::collections::BTreeMap;

/// A border, vertex after vertex, in the direction in which the face of its first edge goes round.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Border {
    /// Each once; behind the last comes the first, unless it branches.
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
    face: u32,
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
    let mut sides: Vec<([u32; 2], u32, [u32; 2])> = Vec::with_capacity(3 * triangles.len());
    for (face, &[a, b, c]) in (0_u32..).zip(triangles).filter(|(_, [a, b, c])| a != b && b != c && c != a) {
        sides.extend([[a, b], [b, c], [c, a]].map(|[u, v]| ([u.min(v), u.max(v)], face, [u, v])));
    }
    sides.sort_unstable();
    let single = sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let mut rims: Vec<Rim> = single.map(|same| Rim { ends: same[0].2, face: same[0].1 }).collect();
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

/// The edges of border at a vertex, by the fan of faces that they bound.
fn fans(
    vertex: u32,
    edges: &[usize],
    faces: &[u32],
    rims: &[Rim],
    triangles: &[[u32; 3]],
) -> Vec<Vec<usize>> {
    let mut fan_of: BTreeMap<u32, usize> = faces.iter().copied().zip(0..).collect();
    let others = |face: u32| triangles[face as usize].into_iter().filter(move |other| *other != vertex);
    // Faces that share an edge at the vertex are of one fan; a few at most, so that each may be held against each.
    for (i, &one) in faces.iter().enumerate() {
        for &two in &faces[..i] {
            if others(one).any(|end| others(two).any(|other| other == end)) {
                let (from, to) = (fan_of[&one], fan_of[&two]);
                fan_of.values_mut().filter(|fan| **fan == from).for_each(|fan| *fan = to);
            }
        }
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &edge in edges {
        groups.entry(fan_of.get(&rims[edge].face).copied().unwrap_or(usize::MAX)).or_default().push(edge);
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
    fn where_three_faces_meet_in_an_edge_the_border_branches() {
        let found = borders(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert!(found.iter().any(|border| border.branch.is_some()), "{found:?}");
        assert!(borders(&[[0, 0, 1], [2, 2, 2]]).is_empty());
    }
}
