//! A finer subject where a mesh is too coarse for what is to be seen on it.

use serde::Serialize;
use wirework_asset::{AssetError, Gltf, Limits, Obj, RefinedMesh, Rest};
use wirework_surface::{
    Mesh, MeshSubdivision, SubdivideError, SubdivideLimits, Subdivision, Wanted, smooth_normals, subdivide,
};

use crate::subject::{Model, Origin, Subject};
use crate::weld::{ANY, Weld};
use crate::{ControlNet, JobError, MeshPart, Pieces, SubjectPiece, parts};

/// What was done to a subject.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Refinement {
    /// The meshes that became finer; none where all were fine enough.
    pub meshes: Vec<FinerMesh>,
    /// What could not be done.
    pub warnings: Vec<String>,
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
        if let Some(ControlNet { tessellation: [u, v], .. }) = &self.net {
            let warning = format!(
                "the object is a patch whose control points are deformed: its surface stays at {u} by {v} cells, as its \
                 `tessellation` says [refine-patch]"
            );
            return Ok((self, Refinement { warnings: vec![warning], ..Refinement::default() }));
        }
        let Self { points, triangles, model, net, pieces, point_of, origin } = self;
        let wanted = Wanted { places: &points, place_of: &point_of, longest: wanted };
        match model {
            Model::Mesh { parts, mesh, obj } => {
                let finer = mesh.subdivide(&wanted, room(limits)).map_err(refused(&origin, limits))?;
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
                let pieces = Split::of(pieces, &point_of, &finer.positions);
                let smooth = smooth(&mesh, &finer);
                let (mut mesh, obj) = finer_mesh(&mesh, obj.as_deref(), &finer, limits)?;
                if let Some(normals) = smooth {
                    mesh.normals = normals;
                    mesh.corners.iter_mut().for_each(|corner| corner.normal = Some(corner.position));
                }
                let subject = pieces.subject(Model::Mesh { parts: finer_parts, mesh, obj })?;
                Ok((Self { origin, ..subject }, Refinement { meshes: done, ..Refinement::default() }))
            }
            Model::Gltf { gltf, rest } => {
                let finer =
                    subdivide(&rest.triangles, &wanted, room(limits)).map_err(refused(&origin, limits))?;
                if finer.is_empty() {
                    let model = Model::Gltf { gltf, rest };
                    let same = Self { points, triangles, model, net, pieces, point_of, origin };
                    return Ok((same, Refinement::default()));
                }
                let (subject, done) = finer_scene((*gltf, &rest), (points, pieces), &point_of, &finer)?;
                Ok((Self { origin, ..subject }, done))
            }
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
    let own = Box::new(obj.refined(finer, limits)?);
    Ok((if *mesh == obj.mesh { own.mesh.clone() } else { finer.apply(mesh) }, Some(own)))
}

/// Normals of a mesh that has none, at its finer positions: those of the coarse one between them. From the finer faces themselves they would
/// be flat but at the old edges. None where it has its own, or has no side somewhere.
fn smooth(mesh: &Mesh, finer: &MeshSubdivision) -> Option<Vec<[f32; 3]>> {
    let triangles = mesh.triangles().ok().filter(|_| mesh.normals.is_empty())?;
    let coarse = smooth_normals(&mesh.positions, &triangles);
    let mut normals = Subdivision::middles(&coarse, &finer.positions);
    for normal in &mut normals {
        let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
        if length.is_nan() || length < SIDELESS {
            return None;
        }
        *normal = normal.map(|c| c / length);
    }
    Some(normals)
}

/// A scene with finer meshes. New vertices share a point where their parents do, even if rounding has put them apart: no
/// seam can open.
fn finer_scene(
    (mut gltf, rest): (Gltf, &Rest),
    (mut points, mut pieces): (Vec<[f32; 3]>, Pieces),
    point_of: &[u32],
    finer: &Subdivision,
) -> Result<(Subject, Refinement), JobError> {
    let refined = gltf.refine(rest, finer)?;
    let old = points.len();
    points.resize(old + finer.place_parents.len(), [f32::NAN; 3]);
    let mut of_vertices = Vec::with_capacity(refined.vertex_of.len());
    for (p, &vertex) in refined.rest.positions.iter().zip(&refined.vertex_of) {
        let vertex = vertex as usize;
        let place = point_of.get(vertex).or_else(|| finer.place_of.get(vertex - point_of.len()));
        let place = place.copied().unwrap_or_default();
        of_vertices.push(place);
        if let Some(point) = points.get_mut(place as usize).filter(|point| point[0].is_nan()) {
            *point = *p;
        }
    }
    // A new point may fall on another one, as where one side of a seam had a vertex that the other did not.
    let weld = if pieces.is_empty() { Weld::new(&points) } else { weld(&points, &mut pieces, finer) };
    let point_of: Vec<u32> = of_vertices.iter().map(|&place| weld.point_of[place as usize]).collect();
    let triangles = &refined.rest.triangles;
    let triangles = triangles.iter().map(|t| t.map(|v| point_of[v as usize])).collect();
    let meshes = refined.meshes.iter().map(|mesh| told(&gltf, mesh)).collect();
    let subject = Subject {
        points: weld.points,
        triangles,
        origin: Origin::File(gltf.file().to_owned()),
        model: Model::Gltf { gltf: Box::new(gltf), rest: Box::new(refined.rest) },
        net: None,
        pieces,
        point_of,
    };
    Ok((subject, Refinement { meshes, warnings: Vec::new() }))
}

/// The places of points in pieces, the first ones old. The new ones join the pieces of their parents and their sides.
fn weld(points: &[[f32; 3]], pieces: &mut Pieces, finer: &Subdivision) -> Weld {
    let old = points.len().saturating_sub(finer.place_parents.len());
    let new = || finer.place_parents.iter().copied().zip(old as u32..);
    for ([a, b], _) in new() {
        let piece = pieces.of(a).min(pieces.of(b));
        pieces.of_points.push(piece);
    }
    pieces.refine_sides(new());
    // Halved once for both its sides, an edge has no two middles that were to be one.
    let number = |(point, &piece): (u32, &u32)| if pieces.is_distinct(piece) { point } else { ANY };
    let own: Vec<u32> = (0..).zip(&pieces.of_points).map(number).collect();
    let weld = Weld::in_pieces(points, &pieces.of_points, &own);
    let list = std::mem::take(&mut pieces.list);
    *pieces = Pieces::of_model(list, &pieces.of_points, &weld.point_of, weld.points.len());
    weld
}

/// The pieces of a mesh that is made finer.
struct Split {
    pieces: Pieces,
    /// For each position its piece; empty without pieces.
    of_positions: Vec<u32>,
    parents: Vec<[u32; 2]>,
}

impl Split {
    fn of(pieces: Pieces, point_of: &[u32], parents: &[[u32; 2]]) -> Self {
        if pieces.is_empty() {
            return Self { pieces, of_positions: Vec::new(), parents: Vec::new() };
        }
        let mut of_positions: Vec<u32> = point_of.iter().map(|&point| pieces.of(point)).collect();
        let of = |list: &[u32], i: u32| list.get(i as usize).copied().unwrap_or(Pieces::NONE);
        for &[a, b] in parents {
            of_positions.push(of(&of_positions, a).min(of(&of_positions, b)));
        }
        Self { pieces, of_positions, parents: parents.to_vec() }
    }

    /// The subject of the finer model, whose old points have the numbers they had.
    fn subject(self, model: Model) -> Result<Subject, JobError> {
        let Self { pieces, of_positions, parents } = self;
        let bare = pieces.list.iter().map(|piece| SubjectPiece { sides: None, ..piece.clone() }).collect();
        let mut subject = Subject::with_pieces(model, bare, &of_positions, &[])?;
        for (new, old) in subject.pieces.list.iter_mut().zip(pieces.list) {
            new.sides = old.sides;
        }
        let point = |position: usize| subject.point_of.get(position).copied().unwrap_or_default();
        let first = of_positions.len() - parents.len();
        let new = parents.iter().zip(first..);
        let new = new.map(|(ends, middle)| (ends.map(|end| point(end as usize)), point(middle)));
        subject.pieces.refine_sides(new);
        Ok(subject)
    }
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
