//! The same for polygon meshes.

use std::collections::HashMap;

use super::{
    Halving, SubdivideError, SubdivideLimits, Subdivision, Wanted, check, graded, mix, shares_or_half,
};
use crate::triangulate::Triangulator;
use crate::vector::{narrow, wide};
use crate::{Corner, Mesh};

/// A finer polygon mesh, in terms of the one it is made from. Old positions, texture coordinates and normals keep
/// their numbers; the new ones are numbered behind them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshSubdivision {
    /// For each new position the two that it lies between; both come before it.
    pub positions: Vec<[u32; 2]>,
    /// For each new position how far it lies from the first of them towards the second, as a part of the way from 0 to 1;
    /// empty where all lie in the middle.
    pub position_shares: Vec<f64>,
    /// For each new position its place; new places are numbered behind the old ones.
    pub place_of: Vec<u32>,
    /// For each new texture coordinate the two that it lies between.
    pub uvs: Vec<[u32; 2]>,
    /// The same of texture coordinates as [`MeshSubdivision::position_shares`].
    pub uv_shares: Vec<f64>,
    /// For each new normal the two that it lies between.
    pub normals: Vec<[u32; 2]>,
    /// The same of normals as [`MeshSubdivision::position_shares`].
    pub normal_shares: Vec<f64>,
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
        let (touched, triangles) = self.touched(wanted.place_of, &vertices, |p, q| halving.is_long(p, q));
        Ok(self.assemble(&touched, vertices, &halving.run(&triangles)?))
    }

    /// The faces with an edge between places that is to be cut, rising, and their triangles.
    pub(super) fn touched(
        &self,
        place_of: &[u32],
        vertices: &Vertices,
        is_cut: impl Fn(u32, u32) -> bool,
    ) -> (Vec<u32>, Vec<[u32; 3]>) {
        let (mut faces, mut triangles) = (Vec::new(), Vec::new());
        let mut triangulator = Triangulator::default();
        let mut first = 0;
        for (index, face) in self.faces().enumerate() {
            let place = |corner: Corner| place_of[corner.position as usize];
            if sides(face).any(|[c, d]| is_cut(place(c), place(d))) {
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
    pub(super) fn assemble(
        &self,
        touched: &[u32],
        mut vertices: Vertices,
        parts: &Subdivision,
    ) -> MeshSubdivision {
        let mut out = MeshSubdivision::default();
        vertices.grow(self, parts, &mut out);
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

    /// How far each new position lies from its first parent towards the second: [`MeshSubdivision::position_shares`], or
    /// half for all.
    pub fn shares_of_positions(&self) -> impl Iterator<Item = f64> {
        shares_or_half(&self.position_shares).take(self.positions.len())
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
        for (&[a, b], share) in self.uvs.iter().zip(shares_or_half(&self.uv_shares)) {
            let (a, b) = (uvs[a as usize], uvs[b as usize]);
            uvs.push([0, 1].map(|k| (f64::from(a[k]) * (1.0 - share) + f64::from(b[k]) * share) as f32));
        }
        let mut normals = mesh.normals.clone();
        for (&[a, b], share) in self.normals.iter().zip(shares_or_half(&self.normal_shares)) {
            let (a, b) = (normals[a as usize], normals[b as usize]);
            // Opposite ones have none in the middle between them; either is as good.
            normals.push(mix(wide(a), wide(b), share).try_normalize().map_or(a, narrow));
        }
        Mesh {
            positions: Subdivision::between(&mesh.positions, &self.positions, &self.position_shares),
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
pub(super) struct Vertices {
    pub(super) corners: Vec<Corner>,
    /// For each corner of the mesh which of them it is.
    of_corners: Vec<u32>,
}

impl Vertices {
    pub(super) fn of(mesh: &Mesh) -> Self {
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

    /// Adds the new vertices: their positions, texture coordinates and normals are each listed once for what they lie
    /// between, and where.
    fn grow(&mut self, mesh: &Mesh, parts: &Subdivision, out: &mut MeshSubdivision) {
        let mut positions = Pairs::behind(mesh.positions.len());
        let mut uvs = Pairs::behind(mesh.uvs.len());
        let mut normals = Pairs::behind(mesh.normals.len());
        for (k, (&[v, w], &place)) in parts.parents.iter().zip(&parts.place_of).enumerate() {
            let share = parts.shares.get(k).copied();
            let (v, w) = (self.corners[v as usize], self.corners[w as usize]);
            let between =
                |pairs: &mut Pairs, a: Option<u32>, b: Option<u32>| Some(pairs.between(a?, b?, share));
            let position = positions.between(v.position, w.position, share);
            if positions.list.len() > out.place_of.len() {
                out.place_of.push(place);
            }
            let (uv, normal) = (between(&mut uvs, v.uv, w.uv), between(&mut normals, v.normal, w.normal));
            self.corners.push(Corner { position, uv, normal });
        }
        (out.positions, out.position_shares) = (positions.list, positions.shares);
        (out.uvs, out.uv_shares) = (uvs.list, uvs.shares);
        (out.normals, out.normal_shares) = (normals.list, normals.shares);
    }
}

/// What lies between two of a list, numbered behind it; each once.
struct Pairs {
    first: usize,
    list: Vec<[u32; 2]>,
    /// Empty where all lie in the middle.
    shares: Vec<f64>,
    /// By the pair and the bits of the share.
    known: HashMap<([u32; 2], u64), u32>,
}

impl Pairs {
    fn behind(first: usize) -> Self {
        Self { first, list: Vec::new(), shares: Vec::new(), known: HashMap::new() }
    }

    fn between(&mut self, a: u32, b: u32, share: Option<f64>) -> u32 {
        if a == b {
            return a;
        }
        // To turn a pair with a share would round that.
        let pair = if share.is_none() { [a.min(b), a.max(b)] } else { [a, b] };
        *self.known.entry((pair, share.unwrap_or(0.5).to_bits())).or_insert_with(|| {
            self.list.push(pair);
            self.shares.extend(share);
            (self.first + self.list.len() - 1) as u32
        })
    }
}

/// The edges of a face.
pub(super) fn sides(face: &[Corner]) -> impl Iterator<Item = [Corner; 2]> + Clone {
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
