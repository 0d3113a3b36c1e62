use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::{Corner, Mesh, VertexMesh, cuboid, grid, sphere, tube};

const ANY: SubdivideLimits = SubdivideLimits { vertices: 1 << 20, triangles: 1 << 21 };

/// A shape split at its seams, with the place of each vertex and how many places there are.
struct Split {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    place_of: Vec<u32>,
    places: usize,
}

impl Split {
    fn new(mesh: &Mesh) -> Self {
        let VertexMesh { positions, triangles, .. } = VertexMesh::new(mesh).unwrap();
        let mut known = BTreeMap::new();
        let mut number = |p: &[f32; 3]| {
            let next = known.len() as u32;
            *known.entry(p.map(|c| (c + 0.0).to_bits())).or_insert(next)
        };
        let place_of = positions.iter().map(&mut number).collect();
        Self { places: known.len(), positions, triangles, place_of }
    }

    fn cut(&self, cuts: &[Cut]) -> Result<Subdivision, SubdivideError> {
        cut_edges(&self.triangles, &self.place_of, self.places, cuts, ANY)
    }

    /// All edges between places, the lesser first, with how often each is used in either direction.
    fn edges(&self, triangles: &[[u32; 3]], new: &[u32]) -> BTreeMap<[u32; 2], [usize; 2]> {
        let place = |v: u32| *self.place_of.iter().chain(new).nth(v as usize).unwrap();
        let mut out = BTreeMap::<_, [usize; 2]>::new();
        for [a, b] in triangles.iter().flat_map(|t| sides(*t)).map(|side| side.map(place)) {
            out.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
        out.retain(|[a, b], _| a != b);
        out
    }
}

fn shapes() -> Vec<Split> {
    let meshes = [
        cuboid([-1.0; 3], [1.0, 0.5, 2.0], [2, 1, 3]).unwrap(),
        tube([0.0; 3], [0.3, 2.0, 0.0], 0.5, 7, 4, true).unwrap(),
        sphere([0.2; 3], 1.0, [9, 6]).unwrap(),
        grid([2.0, 3.0], [2, 3], [0.1, 1.0, 0.2]).unwrap(),
    ];
    meshes.iter().map(Split::new).collect()
}

/// Every other edge, some of them from the greater end.
fn some_cuts(edges: &BTreeMap<[u32; 2], [usize; 2]>, skip: usize) -> Vec<Cut> {
    let lists = [&[0.3][..], &[0.1, 0.25, 0.9], &[], &[0.5, 0.625]];
    let cut = |(k, &[p, q]): (usize, &[u32; 2])| {
        let ends = if k % 3 == 0 { [q, p] } else { [p, q] };
        Cut { ends, shares: lists[k % 4].to_vec() }
    };
    edges.keys().enumerate().skip(skip).step_by(skip + 1).map(cut).collect()
}

fn cross(positions: &[[f32; 3]], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| wide(positions[v as usize]));
    (b - a).cross(c - a)
}

#[test]
fn each_cut_edge_becomes_its_parts_on_all_its_sides() {
    for shape in shapes() {
        let before = shape.edges(&shape.triangles, &[]);
        for skip in 0..3 {
            let cuts = some_cuts(&before, skip);
            let found = shape.cut(&cuts).unwrap();
            let after = shape.edges(&found.triangles, &found.place_of);
            let places = Cut::places(&cuts, shape.places);
            assert_eq!(places.concat().len(), found.place_parents.len());
            let mut whole: BTreeSet<[u32; 2]> = before.keys().copied().collect();
            for (cut, places) in cuts.iter().zip(&places) {
                let [p, q] = cut.ends;
                let [used, back] = before[&[p.min(q), p.max(q)]];
                let (used, back) = if p < q { (used, back) } else { (back, used) };
                let chain = [&[p][..], places, &[q]].concat();
                for pair in chain.windows(2) {
                    let (lesser, greater) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
                    let [there, against] = after[&[lesser, greater]];
                    let now = if pair[0] < pair[1] { (there, against) } else { (against, there) };
                    assert_eq!(now, (used, back), "a part is used as its edge was");
                }
                if !places.is_empty() {
                    whole.remove(&[p.min(q), p.max(q)]);
                    assert!(!after.contains_key(&[p.min(q), p.max(q)]), "a T-junction");
                }
                for (&place, share) in places.iter().zip(&cut.shares) {
                    let k = place as usize - shape.places;
                    assert_eq!((found.place_parents[k], found.place_shares[k]), (cut.ends, *share));
                }
            }
            assert!(whole.iter().all(|edge| after[edge] == before[edge]), "other edges stay");
            assert_in_place(&shape, &found);
        }
    }
}

/// Vertices are where their places are, parts turn as their triangles do and are all of them.
fn assert_in_place(shape: &Split, found: &Subdivision) {
    let all = Subdivision::between(&shape.positions, &found.parents, &found.shares);
    let mut at = BTreeMap::new();
    let place_of: Vec<u32> = shape.place_of.iter().chain(&found.place_of).copied().collect();
    for (p, place) in all.iter().zip(&place_of) {
        assert_eq!(*at.entry(*place).or_insert(*p), *p, "a crack");
    }
    assert_eq!(at.len(), shape.places + found.place_parents.len());
    for (k, &[v, w]) in found.parents.iter().enumerate() {
        let place = found.place_of[k] as usize - shape.places;
        assert_eq!([v, w].map(|v| shape.place_of[v as usize]), found.place_parents[place]);
        assert_eq!(found.shares[k].to_bits(), found.place_shares[place].to_bits());
    }
    let mut sums = vec![DVec3::ZERO; shape.triangles.len()];
    assert!(found.sources.is_sorted());
    for (&source, &part) in found.sources.iter().zip(&found.triangles) {
        let whole = cross(&shape.positions, shape.triangles[source as usize]);
        assert!(cross(&all, part).dot(whole) > 0.0, "turned, or without area");
        sums[source as usize] += cross(&all, part);
    }
    for (sum, &triangle) in sums.iter().zip(&shape.triangles) {
        assert!((*sum - cross(&shape.positions, triangle)).length() < 1e-5);
    }
}

#[test]
fn the_order_of_triangles_does_not_count() {
    for mut shape in shapes() {
        let cuts = some_cuts(&shape.edges(&shape.triangles, &[]), 0);
        let one = shape.cut(&cuts).unwrap();
        shape.triangles.rotate_left(5);
        shape.triangles.iter_mut().for_each(|triangle| triangle.rotate_left(1));
        let other = shape.cut(&cuts).unwrap();
        assert!(one.parents == other.parents && one.place_of == other.place_of);
        let set = |found: &Subdivision| -> BTreeSet<[u32; 3]> {
            let least = |t: &[u32; 3]| (0..3).map(|k| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]).min().unwrap();
            found.triangles.iter().map(least).collect()
        };
        assert!(set(&one) == set(&other));
    }
}

#[test]
fn new_vertices_lie_where_they_are_asked_for() {
    let mesh = grid([4.0, 2.0], [4, 2], [0.0, 1.0, 0.0]).unwrap();
    let places: Vec<u32> = (0..15).collect();
    let shares = vec![0.1, 1.0 / 3.0, 0.8];
    let cuts = [Cut { ends: [1, 0], shares: shares.clone() }, Cut { ends: [13, 14], shares: vec![0.7] }];
    let found = mesh.cut(&places, 15, &cuts, ANY).unwrap();
    let finer = found.apply(&mesh);
    finer.check().unwrap();
    assert_eq!(finer.positions[..15], mesh.positions);
    assert_eq!(found.place_of, [15, 16, 17, 18]);
    assert_eq!(Cut::places(&cuts, 15), [vec![15, 16, 17], vec![18]]);
    let mix = |a: f32, b: f32, share: f64| (f64::from(a) * (1.0 - share) + f64::from(b) * share) as f32;
    let wanted = shares.iter().map(|share| ([1, 0], *share)).chain([([13, 14], 0.7)]);
    for (k, ([a, b], share)) in wanted.enumerate() {
        let (a, b) = (mesh.positions[a], mesh.positions[b]);
        assert_eq!(finer.positions[15 + k], [0, 1, 2].map(|i| mix(a[i], b[i], share)));
        // The grid's texture coordinates are linear in its positions.
        let corner = finer.corners.iter().find(|corner| corner.position as usize == 15 + k).unwrap();
        let own = mesh.corners.iter().find(|corner| corner.position == found.positions[k][0]).unwrap();
        let other = mesh.corners.iter().find(|corner| corner.position == found.positions[k][1]).unwrap();
        let uv = |corner: &Corner| finer.uvs[corner.uv.unwrap() as usize];
        assert_eq!(uv(corner), [0, 1].map(|i| mix(uv(own)[i], uv(other)[i], share)));
        assert_eq!(finer.normals[corner.normal.unwrap() as usize], [0.0, 1.0, 0.0]);
    }
    let quads = finer.faces().filter(|face| face.len() == 4).count();
    assert_eq!((quads, finer.faces().count()), (6, 6 + 5 + 3));
}

#[test]
fn directions_turn_as_far_as_the_share_says() {
    let corner = |v| Corner { position: v, uv: Some(v), normal: Some(v) };
    let mesh = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        uvs: vec![[0.0, 0.0], [1.0, 0.5], [0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        corners: (0..3).map(corner).collect(),
        face_ends: vec![3],
    };
    let found = mesh.cut(&[0, 1, 2], 3, &[Cut { ends: [0, 1], shares: vec![0.25] }], ANY).unwrap();
    let finer = found.apply(&mesh);
    let length = (0.75_f64.powi(2) + 0.25_f64.powi(2)).sqrt();
    assert_eq!(finer.normals[3], [0.25 / length, 0.0, 0.75 / length].map(|c| c as f32));
    assert_eq!(finer.uvs[3], [0.25, 0.125]);
}

#[test]
fn a_seam_that_runs_along_or_meets_an_edge_keeps_both_its_sides() {
    // Two squares side by side with texture coordinates of their own: the seam meets the border at 1 and at 4.
    let corner = |position, uv| Corner { position, uv: Some(uv), normal: None };
    let mesh = Mesh {
        positions: (0..6).map(|k| [(k % 3) as f32, (k / 3) as f32, 0.0]).collect(),
        uvs: (0..8).map(|k| [k as f32, 0.0]).collect(),
        corners: [(0, 0), (1, 1), (4, 3), (3, 2), (1, 4), (2, 5), (5, 7), (4, 6)]
            .map(|(p, t)| corner(p, t))
            .to_vec(),
        face_ends: vec![4, 8],
        ..Mesh::default()
    };
    let places: Vec<u32> = (0..6).collect();
    let cuts = [([0, 1], 0.75), ([2, 1], 0.25), ([4, 1], 0.125)];
    let cuts = cuts.map(|(ends, share)| Cut { ends, shares: vec![share] });
    let found = mesh.cut(&places, 6, &cuts, ANY).unwrap();
    let finer = found.apply(&mesh);
    assert_eq!(finer.positions[6..], [[0.75, 0.0, 0.0], [1.75, 0.0, 0.0], [1.0, 0.875, 0.0]]);
    let uvs_at = |position: u32| -> BTreeSet<u32> {
        let there = finer.corners.iter().filter(|corner| corner.position == position);
        there.map(|corner| (1000.0 * finer.uvs[corner.uv.unwrap() as usize][0]) as u32).collect()
    };
    assert_eq!(uvs_at(6), [750].into());
    assert_eq!(uvs_at(7), [4750].into());
    assert_eq!(uvs_at(8), [2750, 5750].into(), "one on each side of the seam");
}

#[test]
fn what_is_not_cut_stays() {
    for shape in shapes() {
        let edge = *shape.edges(&shape.triangles, &[]).keys().next().unwrap();
        for cuts in [vec![], vec![Cut { ends: edge, shares: vec![] }]] {
            let found = shape.cut(&cuts).unwrap();
            assert!(found.is_empty() && found.triangles == shape.triangles);
            assert!(found.sources.iter().copied().eq(0..shape.triangles.len() as u32));
        }
    }
    let mesh = grid([1.0; 2], [2, 2], [0.0, 1.0, 0.0]).unwrap();
    let places: Vec<u32> = (0..9).collect();
    let found = mesh.cut(&places, 9, &[Cut { ends: [0, 1], shares: vec![] }], ANY).unwrap();
    assert!(found.is_empty() && found.apply(&mesh) == mesh);
}

#[test]
fn degenerate_triangles_pass() {
    let place_of = [0, 1, 0, 1, 2];
    let triangles = [[0, 1, 2], [1, 0, 0], [0, 1, 4], [2, 3, 4], [0, 1, 3]];
    let cuts = [Cut { ends: [1, 0], shares: vec![0.2, 0.4] }, Cut { ends: [2, 0], shares: vec![0.5] }];
    let found = cut_edges(&triangles, &place_of, 3, &cuts, ANY).unwrap();
    let places: Vec<u32> = place_of.iter().chain(&found.place_of).copied().collect();
    for [a, b] in found.triangles.iter().flat_map(|t| sides(*t)) {
        let mut edge = [places[a as usize], places[b as usize]];
        edge.sort_unstable();
        assert!(edge != [0, 1] && edge != [0, 2], "an edge that is whole");
    }
}

#[test]
fn what_cannot_be_cut_is_an_error() {
    let mesh = grid([1.0; 2], [2, 2], [0.0, 1.0, 0.0]).unwrap();
    let places: Vec<u32> = (0..9).collect();
    let triangles = mesh.triangles().unwrap();
    let both = |cuts: &[Cut]| {
        let one = cut_edges(&triangles, &places, 9, cuts, ANY).unwrap_err();
        assert_eq!(one, mesh.cut(&places, 9, cuts, ANY).unwrap_err());
        one
    };
    let cut = |ends, shares: &[f64]| Cut { ends, shares: shares.to_vec() };
    let good = cut([0, 1], &[0.5]);
    for shares in
        [&[0.0][..], &[1.0], &[f64::NAN], &[0.5, 0.5], &[0.5, 0.4], &[-0.1, 0.5], &[0.5, f64::INFINITY]]
    {
        assert_eq!(both(&[good.clone(), cut([1, 2], shares)]), SubdivideError::Shares(1));
    }
    for ends in [[0, 2], [0, 8], [3, 3], [1, 0]] {
        assert_eq!(both(&[good.clone(), cut(ends, &[0.5])]), SubdivideError::Edge(1), "{ends:?}");
    }
    let beyond = SubdivideError::Index { what: "place", index: 9, count: 9 };
    assert_eq!(both(&[cut([9, 0], &[0.5])]), beyond);
    // The diagonal of a face is an edge of its triangles only.
    let diagonal = triangles[0].into_iter().flat_map(|a| triangles[0].map(|b| [a, b]));
    let diagonal = diagonal.into_iter().find(|&[a, b]| a < b && b - a != 1 && b - a != 3).unwrap();
    assert!(cut_edges(&triangles, &places, 9, &[cut(diagonal, &[0.5])], ANY).is_ok());
    assert_eq!(mesh.cut(&places, 9, &[cut(diagonal, &[0.5])], ANY), Err(SubdivideError::Edge(0)));
    assert!(mesh.cut(&places[..8], 9, &[], ANY).is_err());
    assert!(cut_edges(&triangles, &places, 8, &[], ANY).is_err());
    assert!(cut_edges(&[[0, 1, 9]], &places, 9, &[], ANY).is_err());
    let many = cut([0, 1], &(1..1000).map(|k| f64::from(k) / 1000.0).collect::<Vec<_>>());
    for limits in [SubdivideLimits { vertices: 1007, ..ANY }, SubdivideLimits { triangles: 1006, ..ANY }] {
        let found = cut_edges(&triangles, &places, 9, std::slice::from_ref(&many), limits);
        assert_eq!(found, Err(SubdivideError::TooMany { vertices: 1008, triangles: 1007 }));
    }
}
