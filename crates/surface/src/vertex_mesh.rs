//! A mesh as a renderer and a glTF file want it: one vertex for every position, texture coordinate and normal that
//! occur together.

use std::cmp::Reverse;

use crate::smooth::smooth_normals;
use crate::vector::{narrow, wide};
use crate::{Mesh, MeshError};

/// Vertices and triangles. Without triangles a set of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexMesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one a vertex; empty without triangles.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one a vertex, `v` pointing up as in [`Mesh::uvs`]; `None` where the mesh has none.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Indices of vertices; triangle `i` is number `i` of [`Mesh::triangles`].
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex the position of the mesh it was made of: a deformation of [`Mesh::positions`] goes to the
    /// vertices through this.
    pub source: Vec<u32>,
}

impl VertexMesh {
    /// The vertices of a mesh.
    ///
    /// They come in the order of the positions, those of one position by their first corner: a mesh whose positions
    /// need no second vertex keeps its numbering. Positions in no face become vertices too. A corner without normal,
    /// or with one of length 0, gets the smooth normal of its position, weighted by angle (`+Y` where there is
    /// none); the rest are brought to length 1. A corner without texture coordinate gets `[0, 0]` if others have one.
    pub fn new(mesh: &Mesh) -> Result<Self, MeshError> {
        let mut triangles = mesh.corner_triangles()?;
        let (vertices, vertex_of_corner) = split(mesh);
        for triangle in &mut triangles {
            *triangle = triangle.map(|corner| vertex_of_corner[corner as usize]);
        }
        let positions = vertices.iter().map(|v| mesh.positions[v.position as usize]).collect();
        let normals = if triangles.is_empty() { vec![] } else { normals(mesh, &vertices)? };
        let has_uvs = mesh.corners.iter().any(|c| c.uv.is_some());
        let uv = |v: &Vertex| v.uv.map_or([0.0; 2], |i| mesh.uvs[i as usize]);
        let uvs = has_uvs.then(|| vertices.iter().map(uv).collect());
        let source = vertices.iter().map(|v| v.position).collect();
        Ok(Self { positions, normals, uvs, triangles, source })
    }
}

/// What a vertex is made of.
#[derive(Clone, Copy)]
struct Vertex {
    position: u32,
    uv: Option<u32>,
    normal: Option<u32>,
}

/// The vertices, and the vertex of each corner.
fn split(mesh: &Mesh) -> (Vec<Vertex>, Vec<u32>) {
    // The corners of each position: sorted by position, in their own order within one.
    let mut order: Vec<u32> = (0..mesh.corners.len() as u32).collect();
    order.sort_by_key(|&c| mesh.corners[c as usize].position);
    let mut vertices = Vec::with_capacity(mesh.positions.len());
    let mut vertex_of_corner = vec![0; mesh.corners.len()];
    let mut rest = order.as_mut_slice();
    let mut distinct: Vec<(u32, usize, usize)> = Vec::new();
    for position in 0..mesh.positions.len() as u32 {
        let count = rest.iter().take_while(|&&c| mesh.corners[c as usize].position == position).count();
        let (here, after) = rest.split_at_mut(count);
        rest = after;
        if here.is_empty() {
            vertices.push(Vertex { position, uv: None, normal: None });
            continue;
        }
        let key = |c: u32| (mesh.corners[c as usize].uv, mesh.corners[c as usize].normal);
        here.sort_by_key(|&c| (key(c), c));
        // Runs of equal corners, by their first corner.
        distinct.clear();
        let mut start = 0;
        for run in here.chunk_by(|&a, &b| key(a) == key(b)) {
            distinct.push((run[0], start, start + run.len()));
            start += run.len();
        }
        distinct.sort_unstable_by_key(|d| Reverse(d.0));
        while let Some((first, start, end)) = distinct.pop() {
            for &corner in &here[start..end] {
                vertex_of_corner[corner as usize] = vertices.len() as u32;
            }
            let (uv, normal) = key(first);
            vertices.push(Vertex { position, uv, normal });
        }
    }
    (vertices, vertex_of_corner)
}

fn normals(mesh: &Mesh, vertices: &[Vertex]) -> Result<Vec<[f32; 3]>, MeshError> {
    let given = |v: &Vertex| mesh.normals[v.normal? as usize].unit();
    let mut smooth = Vec::new();
    if vertices.iter().any(|v| given(v).is_none()) {
        smooth = smooth_normals(&mesh.positions, &mesh.triangles()?);
    }
    let fallback =
        |v: &Vertex| smooth.get(v.position as usize).and_then(|n| n.unit()).unwrap_or([0.0, 1.0, 0.0]);
    Ok(vertices.iter().map(|v| given(v).unwrap_or_else(|| fallback(v))).collect())
}

trait Unit: Sized {
    /// Of length 1, the same bits where it is so already up to rounding; `None` without length.
    fn unit(self) -> Option<Self>;
}

impl Unit for [f32; 3] {
    fn unit(self) -> Option<Self> {
        // What rounding a unit vector to f32 leaves, with room.
        const ROUNDING: f64 = 1e-6;
        let n = wide(self);
        if (n.length_squared() - 1.0).abs() <= ROUNDING { Some(self) } else { n.try_normalize().map(narrow) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Corner, cuboid, grid, sphere, tube};

    /// Every corner's attributes arrive at its vertex, and no vertex is there twice.
    fn assert_faithful(mesh: &Mesh, vertices: &VertexMesh) {
        let n = vertices.positions.len();
        assert!(vertices.normals.len() == n && vertices.source.len() == n);
        assert!(vertices.source.is_sorted());
        let mut keys = vec![];
        for i in 0..n {
            assert_eq!(vertices.positions[i], mesh.positions[vertices.source[i] as usize]);
            let uv = vertices.uvs.as_ref().unwrap()[i];
            keys.push((vertices.source[i], uv.map(f32::to_bits), vertices.normals[i].map(f32::to_bits)));
        }
        keys.sort_unstable();
        assert!(keys.windows(2).all(|w| w[0] != w[1]));
        for (t, c) in vertices.triangles.iter().zip(mesh.corner_triangles().unwrap()) {
            for (&vertex, corner) in t.iter().zip(c) {
                let (v, corner) = (vertex as usize, mesh.corners[corner as usize]);
                assert_eq!(vertices.source[v], corner.position);
                assert_eq!(vertices.normals[v], mesh.normals[corner.normal.unwrap() as usize]);
                assert_eq!(vertices.uvs.as_ref().unwrap()[v], mesh.uvs[corner.uv.unwrap() as usize]);
            }
        }
    }

    #[test]
    fn seams_and_hard_edges_split_and_nothing_else() {
        let count = |mesh: Mesh| {
            let vertices = VertexMesh::new(&mesh).unwrap();
            assert_faithful(&mesh, &vertices);
            vertices.positions.len()
        };
        assert_eq!(count(grid([1.0; 2], [3, 4], [0.0, 1.0, 0.0]).unwrap()), 20);
        assert_eq!(count(cuboid([0.0; 3], [1.0; 3], [1, 1, 1]).unwrap()), 24);
        assert_eq!(count(tube([0.0; 3], [1.0; 3], 1.0, 8, 3, true).unwrap()), 9 * 3 + 2 * 9);
        assert_eq!(count(sphere([0.0; 3], 1.0, [8, 4]).unwrap()), 9 * 3 + 2 * 8);
    }

    #[test]
    fn a_grid_keeps_its_numbering() {
        let mesh = grid([1.0; 2], [3, 4], [0.0, 1.0, 0.0]).unwrap();
        let vertices = VertexMesh::new(&mesh).unwrap();
        assert_eq!(vertices.positions, mesh.positions);
        assert_eq!(vertices.triangles, mesh.triangles().unwrap());
    }

    #[test]
    fn missing_normals_become_smooth_ones() {
        let mut mesh = sphere([0.0; 3], 1.0, [32, 16]).unwrap();
        mesh.normals = vec![[0.0; 3]];
        mesh.corners.iter_mut().enumerate().for_each(|(i, c)| c.normal = (i % 2 == 0).then_some(0));
        mesh.positions.push([9.0; 3]);
        let vertices = VertexMesh::new(&mesh).unwrap();
        let last = vertices.positions.len() - 1;
        for (n, p) in vertices.normals[..last].iter().zip(&vertices.positions) {
            assert!(wide(*n).distance(wide(*p)) < 0.03, "{n:?} at {p:?}");
        }
        assert_eq!((vertices.positions[last], vertices.normals[last]), ([9.0; 3], [0.0, 1.0, 0.0]));
    }

    #[test]
    fn long_normals_are_shortened_and_point_sets_have_none() {
        let corner = |position| Corner { position, uv: None, normal: Some(0) };
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 5.0]],
            corners: (0..3).map(corner).collect(),
            face_ends: vec![3],
            ..Mesh::default()
        };
        assert_eq!(VertexMesh::new(&mesh).unwrap().normals, [[0.0, 0.0, 1.0]; 3]);
        let points = Mesh { positions: mesh.positions, ..Mesh::default() };
        let vertices = VertexMesh::new(&points).unwrap();
        assert_eq!((vertices.positions.len(), vertices.normals.len(), vertices.uvs), (3, 0, None));
        assert_eq!(vertices.source, [0, 1, 2]);
    }
}
