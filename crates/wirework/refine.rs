//! A finer subject where a mesh is too coarse for what is to be seen on it.

use serde::Serialize;
use wirework_asset::{AssetError, Gltf, Limits, Obj, RefinedMesh, Rest};
use wirework_surface::{
    Cut, Mesh, MeshSubdivision, SubdivideError, SubdivideLimits, Subdivision, Wanted, cut_edges,
    smooth_normals, subdivide,
};

use crate::subject::{Model, Origin, Subject};
use crate::weld::Weld;
use crate::{ControlNet, JobError, MeshPart, Pieces, parts};

/// What was done to a subject.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Refinement {
    /// The meshes that became finer; none where all were fine enough.
    pub meshes: Vec<FinerMesh>,
    /// What could not be done.
    pub warnings: Vec<String>,
}

impl Refinement {
    /// Takes up meshes that became finer once more.
    pub(crate) fn take(&mut self, meshes: Vec<FinerMesh>) {
        for mesh in meshes {
            match self.meshes.iter_mut().find(|known| known.name == mesh.name && known.after == mesh.before) {
                Some(known) => known.after = mesh.after,
                None => self.meshes.push(mesh),
            }
        }
    }
}

/// A mesh that became finer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FinerMesh {
    /// What it is called in its file, or else by its number there.
    pub name: String,
    /// How many vertices it had: in a glTF document those that one node shows, elsewhere its positions.
    pub before: usize,
    /// How many it has now.
    pub after: usize,
}

/// Between normals that leave less than this the surface has no side.
const SIDELESS: f32 = 1e-3;
impl Subject {
    /// The subject with edges short enough, and what was done. `wanted` is, for each of [`Subject::points`], the longest
    /// an edge there may be: metres at rest, above 0, and [`f32::INFINITY`] where it does not matter.
    ///
    /// Edges are halved; the points there are keep their numbers and their bits, and new ones are numbered behind them.
    /// The wanted length is taken to be linear between points: no edge of a triangle is longer than what *all* its corners
    /// want, and whoever wants it fine in its middle says so at each of them. Where others do not care it grows by half of
    /// the way, so that fine passes into coarse gradually.
    ///
    /// In a glTF document the nodes then show finer copies of their meshes, as [`Gltf::refine`] makes them; the document's
    /// own stay in it. An OBJ file keeps its text, as [`Obj::refined`] says. Faces of polygon meshes without a long edge stay
    /// polygons. A subject that is fine enough is returned as it is.
    ///
    /// The control points of a patch are not touched, which is a warning: how finely it is tessellated is for the preset to say.
    ///
    /// # Errors
    ///
    /// [`JobError::Refine`]: a list of another length, a length that is not above 0. [`JobError::Asset`]: more vertices or
    /// indices than `limits` allow, counted before they are made; attributes that are malformed.
    pub fn refined(self, wanted: &[f32], limits: &Limits) -> Result<(Self, Refinement), JobError> {
        self.finer(Finer::Halved(wanted), limits)
    }

    /// The subject with edges cut where it is said, for each cut its new points in order, and what was done. The ends of
    /// cuts are [`Subject::points`], and their edge is one of a face: a polygon's diagonal is none.
    ///
    /// All triangles and faces at an edge are cut with it, and no others. All else is as with [`Subject::refined`]. A new
    /// point stays one of its own where there is another at the same place; vertices on the two sides of a seam, which
    /// share the points at the ends of the edge, share it.
    ///
    /// The control points of a patch are not touched, which is a warning, and there are no new points.
    ///
    /// # Errors
    ///
    /// [`JobError::Refine`]: an edge that is not there, or twice; shares that do not rise from 0 to 1.
    /// [`JobError::Asset`]: as with [`Subject::refined`].
    pub fn cut(self, cuts: &[Cut], limits: &Limits) -> Result<(Self, Vec<Vec<u32>>, Refinement), JobError> {
        let places = if self.net.is_some() {
            vec![Vec::new(); cuts.len()]
        } else {
            Cut::places(cuts, self.points.len())
        };
        let (mut subject, done) = self.finer(Finer::Cut(cuts), limits)?;
        subject.pieces.cut_sides(cuts, &places);
        Ok((subject, places, done))
    }

    fn finer(self, how: Finer<'_>, limits: &Limits) -> Result<(Self, Refinement), JobError> {
        if let Some(ControlNet { tessellation: [u, v], .. }) = &self.net {
            let warning = format!(
                "the object is a patch whose control points are deformed: its surface stays at {u} by {v} cells, as its \
                 `tessellation` says [refine-patch]"
            );
            return Ok((self, Refinement { warnings: vec![warning], ..Refinement::default() }));
        }
        let Self { points, triangles, model, net, pieces, point_of, origin } = self;
        let places = (points.as_slice(), point_of.as_slice());
        match model {
            Model::Mesh { parts, mesh, obj } => {
                let finer = how.of_mesh(&mesh, places, room(limits)).map_err(refused(&origin, limits))?;
                if finer.is_empty() {
                    let model = Model::Mesh { parts, mesh, obj };
                    let same = Self { points, triangles, model, net, pieces, point_of, origin };
                    return Ok((same, Refinement::default()));
                }
                let positions = mesh.positions.len() + finer.positions.len();
                limits
                    .check_mesh(positions as u64, finer.corners.len() as u64)
                    .map_err(|error| in_file(error, &origin))?;
                let finer_parts = parts::refined(&parts, mesh.positions.len(), &finer);
                let done = parts.iter().zip(&finer_parts).filter(|(a, b)| a.count() < b.count());
                let done = done.map(|(a, b)| told_part(a, b)).collect();
                let smooth = smooth(&mesh, &finer);
                let (mut mesh, obj) = finer_mesh(&mesh, obj.as_deref(), &finer, limits)?;
                if let Some(normals) = smooth {
                    mesh.normals = normals;
                    mesh.corners.iter_mut().for_each(|corner| corner.normal = Some(corner.position));
                }
                let weld = with_new(points, [point_of, finer.place_of].concat(), &mesh.positions);
                let first = weld.point_of.len() - finer.positions.len();
                let point = |position: u32| weld.point_of[position as usize];
                let new = finer.positions.iter().zip(&weld.point_of[first..]);
                let new = new.map(|(ends, &new)| (ends.map(point), new));
                let pieces = pieces.grown(new, how.halves());
                let triangles = weld.triangles(&mesh.triangles()?);
                let Weld { points, point_of } = weld;
                let model = Model::Mesh { parts: finer_parts, mesh, obj };
                let subject = Self { points, triangles, model, net, pieces, point_of, origin };
                Ok((subject, Refinement { meshes: done, ..Refinement::default() }))
            }
            Model::Gltf { gltf, rest } => {
                let finer = how.of_triangles(&rest.triangles, places, room(limits));
                let finer = finer.map_err(refused(&origin, limits))?;
                if finer.is_empty() {
                    let model = Model::Gltf { gltf, rest };
                    let same = Self { points, triangles, model, net, pieces, point_of, origin };
                    return Ok((same, Refinement::default()));
                }
                let (subject, done) =
                    finer_scene((*gltf, &rest), (points, pieces), &point_of, (&finer, how))?;
                Ok((Self { origin, ..subject }, done))
            }
        }
    }
}

/// How a subject becomes finer.
#[derive(Clone, Copy)]
enum Finer<'a> {
    /// For each point the longest an edge there may be.
    Halved(&'a [f32]),
    Cut(&'a [Cut]),
}

impl Finer<'_> {
    fn halves(self) -> bool {
        matches!(self, Self::Halved(_))
    }

    fn of_mesh(
        self,
        mesh: &Mesh,
        (places, place_of): (&[[f32; 3]], &[u32]),
        limits: SubdivideLimits,
    ) -> Result<MeshSubdivision, SubdivideError> {
        match self {
            Self::Halved(longest) => mesh.subdivide(&Wanted { places, place_of, longest }, limits),
            Self::Cut(cuts) => mesh.cut(place_of, places.len(), cuts, limits),
        }
    }

    fn of_triangles(
        self,
        triangles: &[[u32; 3]],
        (places, place_of): (&[[f32; 3]], &[u32]),
        limits: SubdivideLimits,
    ) -> Result<Subdivision, SubdivideError> {
        match self {
            Self::Halved(longest) => subdivide(triangles, &Wanted { places, place_of, longest }, limits),
            Self::Cut(cuts) => cut_edges(triangles, place_of, places.len(), cuts, limits),
        }
    }
}

/// A mesh and the file it comes from, if there is one, both finer. The mesh is the file's own unless it has been placed
/// elsewhere.
fn finer_mesh(
    mesh: &Mesh,
    obj: Option<&Obj>,
    finer: &MeshSubdivision,
    limits: &Limits,
) -> Result<(Mesh, Option<Box<Obj>>), AssetError> {
    let Some(obj) = obj else { return Ok((finer.apply(mesh), None)) };
    // Normals that it got when it became finer before are not the file's.
    let is_smooth = obj.mesh.normals.is_empty() && !mesh.normals.is_empty();
    let bare = is_smooth.then(|| without_normals(finer));
    let own = Box::new(obj.refined(bare.as_ref().unwrap_or(finer), limits)?);
    Ok((if *mesh == obj.mesh { own.mesh.clone() } else { finer.apply(mesh) }, Some(own)))
}

fn without_normals(finer: &MeshSubdivision) -> MeshSubdivision {
    let mut out = finer.clone();
    (out.normals, out.normal_shares) = (Vec::new(), Vec::new());
    out.corners.iter_mut().for_each(|corner| corner.normal = None);
    out
}

/// Normals of a mesh that has none, at its finer positions: those of the coarse one between them. From the finer faces themselves they would
/// be flat but at the old edges. None where it has its own, or has no side somewhere.
fn smooth(mesh: &Mesh, finer: &MeshSubdivision) -> Option<Vec<[f32; 3]>> {
    let triangles = mesh.triangles().ok().filter(|_| mesh.normals.is_empty())?;
    let coarse = smooth_normals(&mesh.positions, &triangles);
    let mut normals = Subdivision::between(&coarse, &finer.positions, &finer.position_shares);
    for normal in &mut normals {
        let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
        if length.is_nan() || length < SIDELESS {
            return None;
        }
        *normal = normal.map(|c| c / length);
    }
    Some(normals)
}

/// Points behind the old ones for the new places of positions. New positions share a point where their parents do, even if
/// rounding has put them apart: no seam can open. Where they fall on another point they do not share it: two borders that
/// lie on each other stay two.
fn with_new(mut points: Vec<[f32; 3]>, point_of: Vec<u32>, positions: &[[f32; 3]]) -> Weld {
    for (p, &place) in positions.iter().zip(&point_of) {
        let place = place as usize;
        if place >= points.len() {
            points.resize(place + 1, [f32::NAN; 3]);
        }
        if points[place][0].is_nan() {
            points[place] = *p;
        }
    }
    Weld { points, point_of }
}

/// A scene with finer meshes.
fn finer_scene(
    (mut gltf, rest): (Gltf, &Rest),
    (points, pieces): (Vec<[f32; 3]>, Pieces),
    point_of: &[u32],
    (finer, how): (&Subdivision, Finer<'_>),
) -> Result<(Subject, Refinement), JobError> {
    let refined = gltf.refine(rest, finer)?;
    let first = points.len() as u32;
    let pieces = pieces.grown(finer.place_parents.iter().copied().zip(first..), how.halves());
    let place = |&vertex: &u32| {
        let new = || finer.place_of.get(vertex as usize - point_of.len());
        point_of.get(vertex as usize).or_else(new).copied().unwrap_or_default()
    };
    let weld = with_new(points, refined.vertex_of.iter().map(place).collect(), &refined.rest.positions);
    let triangles = weld.triangles(&refined.rest.triangles);
    let meshes = refined.meshes.iter().map(|mesh| told(&gltf, mesh)).collect();
    let subject = Subject {
        points: weld.points,
        triangles,
        origin: Origin::File(gltf.file().to_owned()),
        model: Model::Gltf { gltf: Box::new(gltf), rest: Box::new(refined.rest) },
        net: None,
        pieces,
        point_of: weld.point_of,
    };
    Ok((subject, Refinement { meshes, warnings: Vec::new() }))
}

fn told_part(before: &MeshPart, after: &MeshPart) -> FinerMesh {
    FinerMesh { name: before.name.clone(), before: before.count(), after: after.count() }
}

fn told(gltf: &Gltf, refined: &RefinedMesh) -> FinerMesh {
    let own = gltf.json()["meshes"][refined.mesh]["name"].as_str();
    let name = own.or_else(|| gltf.node_name(*refined.nodes.first()?));
    let name = name.map_or_else(|| format!("mesh {}", refined.mesh), str::to_owned);
    FinerMesh { name, before: refined.before, after: refined.after }
}

fn room(limits: &Limits) -> SubdivideLimits {
    SubdivideLimits { vertices: limits.vertices, triangles: limits.indices / 3 }
}

/// What is wrong with a subdivision: too large is a limit as any other.
fn refused(origin: &Origin, limits: &Limits) -> impl Fn(SubdivideError) -> JobError {
    move |error| match error {
        SubdivideError::TooMany { vertices, triangles } => {
            match limits.check_mesh(vertices, triangles.saturating_mul(3)) {
                Err(limit) => in_file(limit, origin).into(),
                Ok(()) => JobError::Refine(error),
            }
        }
        SubdivideError::Mesh(error) => error.into(),
        error => JobError::Refine(error),
    }
}

fn in_file(mut error: AssetError, origin: &Origin) -> AssetError {
    if error.file.is_empty() {
        match origin {
            Origin::File(file) => file.clone_into(&mut error.file),
            Origin::Preset => "the preset's object".clone_into(&mut error.file),
            Origin::Program => {}
        }
    }
    error
}

#[cfg(test)]
#[path = "refine_tests.rs"]
mod tests;
