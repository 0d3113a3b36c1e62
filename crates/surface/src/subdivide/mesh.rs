//! The same for polygon meshes.

use std::collections::HashMap;

use super::{Halving, SubdivideError, SubdivideLimits, Subdivision, Wanted, check, graded};
use crate::triangulate::Triangulator;
use crate::vector::{narrow, wide};
use crate::{Corner, Mesh};

/// A finer polygon mesh, in terms of the one it is made from. Old positions, texture coordinates and normals keep
/// their numbers; the new ones are numbered behind them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshSubdivision {
    /// For each new position the two that it lies in the middle of; both come before it.
    pub positions: Vec<[u32; 2]>,
    /// For each new texture coordinate the two that it is the mean of.
    pub uvs: Vec<[u32; 2]>,
    /// For each new normal the two that it lies between.
    pub normals: Vec<[u32; 2]>,
    /// The corners of all faces, as in [`Mesh::corners`].
    pub corners: Vec<Corner>,
    /// Where each face ends, as in [`Mesh::face_ends`].
    pub face_ends: Vec<u32>,
    /// For each face the old one that it is, or is a part of; rising.
    pub sources: Vec<u32>,
}

impl Mesh {
    /// Halves edges until each is at most as long as both its ends want; `wanted.place_of` is of [`Mesh::positions`].
    ///
    /// A face none of whose edges is halved stays as it is, whatever its diagonals. Others become triangles: those of
    /// [`Mesh::triangles`], and their parts. Each new position is listed once for a pair of old ones.
    ///
    /// # Errors
    ///
    /// [`SubdivideError`]. Vertices are counted as a renderer has them: by position, texture coordinate and normal.
    pub fn subdivide(
        &self,
        wanted: &Wanted<'_>,
        limits: SubdivideLimits,
    ) -> Result<MeshSubdivision, SubdivideError> {
        self.check()?;
        if wanted.place_of.len() != self.positions.len() {
            let (index, count) = (wanted.place_of.len(), self.positions.len());
            return Err(SubdivideError::Index { what: "vertex", index, count });
        }
        check(&[], wanted)?;
        let vertices = Vertices::of(self);
        let at = wanted.places.iter().map(|&p| wide(p)).collect::<Vec<_>>();
        let place_of: Vec<u32> =
            vertices.corners.iter().map(|c| wanted.place_of[c.position as usize]).collect();
        let sides = self.faces().flat_map(sides);
        let edges: Vec<[u32; 2]> =
            sides.map(|side| side.map(|c| wanted.place_of[c.position as usize])).collect();
        let longest = graded(&at, wanted.longest, &edges);
        let old = place_of.len();
        let halving = Halving { at, longest, place_of, old, limits };
        let (touched, triangles) = self.touched(wanted.place_of, &vertices, &halving);
        Ok(self.assemble(&touched, vertices, &halving.run(&triangles)?))
    }

    /// The faces with an edge that is to be halved, rising, and their triangles.
    fn touched(&self, place_of: &[u32], vertices: &Vertices, halving: &Halving) -> (Vec<u32>, Vec<[u32; 3]>) {
        let (mut faces, mut triangles) = (Vec::new(), Vec::new());
        let mut triangulator = Triangulator::default();
        let mut first = 0;
        for (index, face) in self.faces().enumerate() {
            let is_long = |[c, d]: [Corner; 2]| {
                halving.is_long(place_of[c.position as usize], place_of[d.position as usize])
            };
            if sides(face).any(is_long) {
                faces.push(index as u32);
                let polygon = face.iter().map(|c| self.positions[c.position as usize]);
                triangulator.triangulate(polygon, first, &mut triangles);
            }
            first += face.len() as u32;
        }
        for corner in triangles.as_flattened_mut() {
            *corner = vertices.of_corners[*corner as usize];
        }
        (faces, triangles)
    }

    /// Puts the faces that stay and the parts of the others together.
    fn assemble(&self, touched: &[u32], mut vertices: Vertices, parts: &Subdivision) -> MeshSubdivision {
        let mut out = MeshSubdivision::default();
        vertices.grow(self, &parts.parents, &mut out);
        let mut parts = parts.sources.iter().zip(&parts.triangles).peekable();
        let mut touched = touched.iter().peekable();
        // The first triangle behind those of the faces so far.
        let mut end = 0;
        for (face, corners) in (0_u32..).zip(self.faces()) {
            if touched.next_if(|&&next| next == face).is_none() {
                out.push(face, corners);
                continue;
            }
            end += corners.len() as u32 - 2;
            while let Some((_, triangle)) = parts.next_if(|&(&source, _)| source < end) {
                out.push(face, &triangle.map(|v| vertices.corners[v as usize]));
            }
        }
        out
    }
}

impl MeshSubdivision {
    /// Whether nothing is new.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The finer mesh. `mesh` is the one that was subdivided, or one with the same faces whose positions, texture coordinates or
    /// normals are others.
    ///
    /// # Panics
    ///
    /// If `mesh` has fewer positions, texture coordinates or normals than the one that was subdivided.
    #[must_use]
    pub fn apply(&self, mesh: &Mesh) -> Mesh {
        let mut uvs = mesh.uvs.clone();
        for &[a, b] in &self.uvs {
            let (a, b) = (uvs[a as usize], uvs[b as usize]);
            uvs.push([0, 1].map(|k| ((f64::from(a[k]) + f64::from(b[k])) * 0.5) as f32));
        }
        let mut normals = mesh.normals.clone();
        for &[a, b] in &self.normals {
            let (a, b) = (normals[a as usize], normals[b as usize]);
            // Opposite ones have none between them; either is as good.
            normals.push((wide(a) + wide(b)).try_normalize().map_or(a, narrow));
        }
        Mesh {
            positions: Subdivision::middles(&mesh.positions, &self.positions),
            uvs,
            normals,
            corners: self.corners.clone(),
            face_ends: self.face_ends.clone(),
        }
    }

    fn push(&mut self, source: u32, corners: &[Corner]) {
        self.corners.extend_from_slice(corners);
        self.face_ends.push(self.corners.len() as u32);
        self.sources.push(source);
    }
}

/// The distinct corners of a mesh, which is what a renderer's vertices are.
struct Vertices {
    corners: Vec<Corner>,
    /// For each corner of the mesh which of them it is.
    of_corners: Vec<u32>,
}

impl Vertices {
    fn of(mesh: &Mesh) -> Self {
        let mut known = HashMap::with_capacity(mesh.positions.len());
        let mut corners = Vec::new();
        let number = |corner: &Corner| {
            *known.entry(*corner).or_insert_with(|| {
                corners.push(*corner);
                corners.len() as u32 - 1
            })
        };
        let of_corners = mesh.corners.iter().map(number).collect();
        Self { corners, of_corners }
    }

    /// Adds the vertices in the middle of `parents`: their positions, texture coordinates and normals are each listed once
    /// for a pair of old ones.
    fn grow(&mut self, mesh: &Mesh, parents: &[[u32; 2]], out: &mut MeshSubdivision) {
        let mut positions = Pairs::behind(mesh.positions.len());
        let mut uvs = Pairs::behind(mesh.uvs.len());
        let mut normals = Pairs::behind(mesh.normals.len());
        for &[v, w] in parents {
            let (v, w) = (self.corners[v as usize], self.corners[w as usize]);
            let between = |pairs: &mut Pairs, a: Option<u32>, b: Option<u32>| Some(pairs.between(a?, b?));
            self.corners.push(Corner {
                position: positions.between(v.position, w.position),
                uv: between(&mut uvs, v.uv, w.uv),
                normal: between(&mut normals, v.normal, w.normal),
            });
        }
        (out.positions, out.uvs, out.normals) = (positions.list, uvs.list, normals.list);
    }
}

/// What lies between two of a list, numbered behind it; each pair once.
struct Pairs {
    first: usize,
    list: Vec<[u32; 2]>,
    known: HashMap<[u32; 2], u32>,
}

impl Pairs {
    fn behind(first: usize) -> Self {
        Self { first, list: Vec::new(), known: HashMap::new() }
    }

    fn between(&mut self, a: u32, b: u32) -> u32 {
        if a == b {
            return a;
        }
        let pair = [a.min(b), a.max(b)];
        *self.known.entry(pair).or_insert_with(|| {
            self.list.push(pair);
            (self.first + self.list.len() - 1) as u32
        })
    }
}

/// The edges of a face.
fn sides(face: &[Corner]) -> impl Iterator<Item = [Corner; 2]> + Clone {
    face.iter().zip(face.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SubdivideLimits, cuboid, grid, sphere, tube};

    const ANY: SubdivideLimits = SubdivideLimits { vertices: 1 << 20, triangles: 1 << 21 };

    fn halved(mesh: &Mesh, longest: &[f32]) -> (MeshSubdivision, Mesh) {
        let place_of: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        let wanted = Wanted { places: &mesh.positions, place_of: &place_of, longest };
        let found = mesh.subdivide(&wanted, ANY).unwrap();
        let finer = found.apply(mesh);
        finer.check().unwrap();
        (found, finer)
    }

    #[test]
    fn faces_without_a_long_edge_stay_whatever_their_diagonals() {
        let mesh = grid([3.0, 3.0], [3, 3], [0.0, 1.0, 0.0]).unwrap();
        let (found, finer) = halved(&mesh, &[1.0; 16]);
        assert!(found.is_empty() && finer == mesh);
        assert_eq!(found.sources, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        // A corner of the grid: faces out of its reach stay quads.
        let mut longest = [f32::INFINITY; 16];
        longest[0] = 0.4;
        let (found, finer) = halved(&mesh, &longest);
        let quads = finer.faces().filter(|face| face.len() == 4).count();
        assert!(quads >= 5 && !found.is_empty(), "{quads}");
        for (face, source) in finer.faces().zip(&found.sources) {
            assert!(face.len() == 3 || face == mesh.faces().nth(*source as usize).unwrap());
        }
    }

    #[test]
    fn each_place_is_listed_once_and_no_t_junction_is_left() {
        let solids = [
            cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 2, 2]).unwrap(),
            tube([0.0; 3], [0.0, 2.0, 0.0], 0.5, 9, 3, true).unwrap(),
            sphere([0.0; 3], 1.0, [8, 5]).unwrap(),
        ];
        for mesh in solids {
            let longest: Vec<f32> = mesh.positions.iter().map(|p| 0.2 + p[1].abs()).collect();
            let (found, finer) = halved(&mesh, &longest);
            assert_eq!(finer.positions[..mesh.positions.len()], mesh.positions);
            let mut sorted: Vec<_> = finer.positions.iter().map(|p| p.map(f32::to_bits)).collect();
            sorted.sort_unstable();
            assert!(sorted.windows(2).all(|w| w[0] != w[1]), "a place twice");
            // A closed surface: each edge is there once in each direction.
            let mut edges: Vec<_> =
                finer.faces().flat_map(sides).map(|[a, b]| (a.position, b.position)).collect();
            edges.sort_unstable();
            assert!(edges.windows(2).all(|w| w[0] != w[1]));
            assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()), "a T-junction");
            for (n, count) in [(finer.normals.len(), mesh.normals.len()), (finer.uvs.len(), mesh.uvs.len())] {
                assert!(n >= count && n <= count + found.corners.len());
            }
            assert!(finer.normals.iter().all(|n| (wide(*n).length() - 1.0).abs() < 1e-6));
            for corner in &finer.corners {
                assert!(corner.uv.is_some() && corner.normal.is_some());
            }
        }
    }

    #[test]
    fn seams_keep_coordinates_of_their_own_and_flat_sides_their_normals() {
        let mesh = cuboid([0.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
        let (found, finer) = halved(&mesh, &[0.6; 8]);
        assert!(found.normals.is_empty(), "a flat side has one normal");
        assert!(found.uvs.len() > found.positions.len(), "the sides have uvs of their own");
        for (face, &source) in finer.faces().zip(&found.sources) {
            let normal = mesh.faces().nth(source as usize).unwrap()[0].normal;
            assert!(face.iter().all(|corner| corner.normal == normal));
        }
    }

    #[test]
    fn concave_faces_and_points_pass_and_faults_are_errors() {
        let corner = |position| Corner { position, uv: None, normal: None };
        let arrow = Mesh {
            positions: vec![[0.0; 3], [2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0], [9.0; 3]],
            corners: (0..4).map(corner).collect(),
            face_ends: vec![4],
            ..Mesh::default()
        };
        let (found, finer) = halved(&arrow, &[0.5; 5]);
        assert!(finer.positions.len() > 10 && found.uvs.is_empty());
        let area = |mesh: &Mesh| -> f64 {
            let at = |v: u32| wide(mesh.positions[v as usize]);
            let triangles = mesh.triangles().unwrap();
            triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).z * 0.5).sum()
        };
        assert!((area(&finer) - area(&arrow)).abs() < 1e-6);
        let points = Mesh { positions: arrow.positions.clone(), ..Mesh::default() };
        assert_eq!(halved(&points, &[0.1; 5]).1, points);
        let wanted = Wanted { places: &arrow.positions, place_of: &[0, 1, 2, 3], longest: &[1.0; 5] };
        assert!(arrow.subdivide(&wanted, ANY).is_err());
        let torn = Mesh { face_ends: vec![3], ..arrow.clone() };
        let wanted = Wanted { place_of: &[0, 1, 2, 3, 4], ..wanted };
        assert!(matches!(torn.subdivide(&wanted, ANY), Err(SubdivideError::Mesh(_))));
    }
}
