//! Several pieces as one subject.

use std::collections::BTreeMap;
use std::path::Path;

use wirework_asset::{Gltf, Limits, Rest, printable};
use wirework_preset::{Named, Object, PatchDeform, Shape};
use wirework_surface::Mesh;

use super::{Pieces, SubjectPiece, sides};
use crate::output::Scene;
use crate::parts::{MeshPart, join};
use crate::subject::{Model, Origin, Subject};
use crate::weld::ANY;
use crate::{JobError, parts};

/// A piece before it is put together with others.
enum Source {
    /// Nodes of the base that show a mesh.
    Nodes(Vec<usize>),
    /// Positions of the base.
    Positions(Vec<bool>),
    /// An object of the preset's.
    Own(Box<Subject>),
}

/// A piece, and what the preset says of it.
struct Part<'a> {
    named: &'a Named,
    object: Option<&'a Object>,
    source: Source,
}

impl Part<'_> {
    fn piece(&self) -> SubjectPiece {
        let own = matches!(self.source, Source::Own(_));
        let distinct = match &self.source {
            Source::Own(subject) => matches!(&subject.model, Model::Mesh { obj: None, .. }),
            _ => false,
        };
        let sides = self.object.filter(|_| own).and_then(sides);
        SubjectPiece { name: self.named.name.clone(), sides, distinct, nodes: Vec::new() }
    }
}

impl Subject {
    /// Several pieces, each with a name and perhaps an object of the preset's, as one subject; [`Subject::pieces`] has them. `base`
    /// is the input, or else the preset's own object; `preset_dir` is the folder of the preset.
    ///
    /// A piece whose name a node of the base has is what that node shows, or else what the nodes below it show, whether it has an
    /// object or not: the input takes its place. In an OBJ file objects and groups are the nodes; without any it is one, with the
    /// name of the file. The objects of the others are put behind the base in the order of the pieces: as parts of one mesh
    /// where none of all is a glTF document, else as nodes of one document. A vertex that is in two pieces belongs to the
    /// one that stands first. Points of different pieces are never one, even where they are at one place.
    ///
    /// # Errors
    ///
    /// A name that nothing has, at its place in the preset; a patch that asks for its control points to be deformed; objects as in
    /// [`Subject::from_object`]; more than `limits` allow.
    pub fn from_pieces(
        base: Option<Self>,
        pieces: &[(&Named, Option<&Object>)],
        preset_dir: &Path,
        limits: &Limits,
    ) -> Result<Self, JobError> {
        let mut found = Vec::with_capacity(pieces.len());
        for &(named, object) in pieces {
            let source = match (find(base.as_ref(), named, object.is_none())?, object) {
                (Some(there), _) => there,
                (None, Some(object)) => Source::Own(Box::new(own(named, object, preset_dir, limits)?)),
                (None, None) => return Err(unknown(base.as_ref(), named)),
            };
            found.push(Part { named, object, source });
        }
        let is_gltf = |subject: &Self| matches!(subject.model, Model::Gltf { .. });
        let any = found.iter().any(|part| matches!(&part.source, Source::Own(subject) if is_gltf(subject)));
        if any || base.as_ref().is_some_and(is_gltf) {
            document(base, found, limits)
        } else {
            mesh(base, found, limits)
        }
    }
}

/// The object of a piece.
fn own(named: &Named, object: &Object, preset_dir: &Path, limits: &Limits) -> Result<Subject, JobError> {
    if matches!(object.shape, Shape::Patch { deform: PatchDeform::ControlPoints, .. }) {
        let message =
            "`deform: ControlPoints` is not for a piece: it is the points of its surface that are stitched";
        return Err(JobError::Preset(Box::new(named.refused(message))));
    }
    Subject::from_object(object, preset_dir, &named.name, limits)
}

/// What of the base has the name of a piece. By its number a node is found only where nothing else can be meant.
fn find(base: Option<&Subject>, named: &Named, by_number: bool) -> Result<Option<Source>, JobError> {
    let Some(base) = base else { return Ok(None) };
    let name = named.name.as_str();
    let refused = |what: &str| {
        let message = format!("\"{}\" {what}", printable(name));
        Err(JobError::Preset(Box::new(named.refused(message))))
    };
    if base.net.is_some() {
        return refused(
            "cannot be a piece: `deform: ControlPoints` leaves no points of its surface to stitch",
        );
    }
    match &base.model {
        Model::Gltf { gltf, rest } => {
            let mut nodes: Vec<usize> =
                (0..gltf.node_count()).filter(|&node| gltf.node_name(node) == Some(name)).collect();
            if nodes.is_empty() && by_number {
                nodes.extend(name.parse().ok().filter(|&node: &usize| node < gltf.node_count()));
            }
            let there = !nodes.is_empty();
            let shown = |node: &usize| rest.blocks.iter().any(|block| block.node == *node);
            let nodes: Vec<usize> = gltf.mesh_nodes(&nodes).into_iter().filter(shown).collect();
            match nodes.as_slice() {
                [] if there && by_number => refused("shows no vertex of the scene"),
                [] => Ok(None),
                _ => Ok(Some(Source::Nodes(nodes))),
            }
        }
        Model::Mesh { parts, mesh, obj } => {
            let count = mesh.positions.len();
            let members = match obj.as_ref().filter(|obj| !obj.group_names().is_empty()) {
                Some(obj) if obj.group_names().iter().any(|group| group == name) => {
                    obj.in_groups(&[name]).of_positions
                }
                None => match parts.iter().position(|part| part.name == name) {
                    Some(part) => {
                        parts::of_positions(parts, count).iter().map(|&p| p as usize == part).collect()
                    }
                    None => return Ok(None),
                },
                Some(_) => return Ok(None),
            };
            if members.contains(&true) {
                return Ok(Some(Source::Positions(members)));
            }
            if by_number { refused("has no vertex of its own") } else { Ok(None) }
        }
    }
}

/// The error that nothing has the name of a piece.
fn unknown(base: Option<&Subject>, named: &Named) -> JobError {
    let Some(base) = base else {
        let message = "found no object, and no input whose node the piece could be; give it an `object`, or give an input";
        return JobError::Preset(Box::new(named.refused(message)));
    };
    let known: Vec<String> = match &base.model {
        Model::Gltf { gltf, rest } => {
            let name = |node: usize| gltf.node_name(node).map_or_else(|| node.to_string(), str::to_owned);
            let nodes: BTreeMap<usize, String> =
                rest.blocks.iter().map(|block| (block.node, name(block.node))).collect();
            nodes.into_values().collect()
        }
        Model::Mesh { parts, obj, .. } => {
            let groups = obj.as_ref().map(|obj| obj.group_names()).unwrap_or_default();
            if groups.is_empty() { parts.iter().map(|part| part.name.clone()).collect() } else { groups }
        }
    };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let error = named.unknown("piece", &known);
    let file = match &base.origin {
        Origin::File(file) => format!("{}: ", printable(file)),
        _ => String::new(),
    };
    let message = format!("{file}{}", error.message);
    JobError::Preset(Box::new(wirework_preset::PresetError { message, ..error }))
}

/// Gives positions that belong to no piece yet to a piece.
fn claim(of: &mut [u32], piece: u32, members: impl Iterator<Item = usize>) {
    for member in members {
        if let Some(slot) = of.get_mut(member).filter(|slot| **slot == Pieces::NONE) {
            *slot = piece;
        }
    }
}

/// The pieces as parts of one mesh.
fn mesh(base: Option<Subject>, found: Vec<Part<'_>>, limits: &Limits) -> Result<Subject, JobError> {
    let origin = base.as_ref().map_or(Origin::Preset, |base| base.origin.clone());
    let (mut parts, mut mesh, mut obj) = match base.map(|base| base.model) {
        Some(Model::Mesh { parts, mesh, obj }) => (parts, mesh, obj),
        _ => (Vec::new(), Mesh::default(), None),
    };
    let mut list = Vec::with_capacity(found.len());
    let mut of = vec![Pieces::NONE; mesh.positions.len()];
    for (index, part) in (0..).zip(found) {
        let mut piece = part.piece();
        match part.source {
            Source::Positions(members) => {
                claim(&mut of, index, (0..members.len()).filter(|&i| members.get(i) == Some(&true)));
            }
            Source::Own(subject) => {
                let Model::Mesh { mesh: more, .. } = subject.model else { continue };
                let first = mesh.positions.len();
                let vertices = (first as u64).saturating_add(more.positions.len() as u64);
                let corners = (mesh.corners.len() as u64).saturating_add(more.corners.len() as u64);
                limits.check_mesh(vertices, corners)?;
                piece.sides.iter_mut().flatten().flatten().for_each(|position| *position += first as u32);
                join(&mut mesh, &mut parts, more, &piece.name, piece.distinct);
                of.resize(mesh.positions.len(), index);
                // The text of a file holds no other mesh.
                obj = None;
            }
            Source::Nodes(_) => {}
        }
        list.push(piece);
    }
    Ok(Subject { origin, ..Subject::with_pieces(Model::Mesh { parts, mesh, obj }, list, &of, &[])? })
}

/// The pieces as nodes of one document.
fn document(base: Option<Subject>, found: Vec<Part<'_>>, limits: &Limits) -> Result<Subject, JobError> {
    let origin = base.as_ref().map_or(Origin::Preset, |base| base.origin.clone());
    let name = found.first().map_or("pieces", |part| part.named.name.as_str()).to_owned();
    // Of a mesh, for each vertex that shows it the position.
    let mut base_source = None;
    let mut gltf = match base.map(|base| (base.model, base.point_of)) {
        None => Gltf::from_meshes_within(&name, &[], limits)?,
        Some((model, point_of)) => {
            let scene = Scene::new(model, point_of, limits)?;
            base_source = scene.source;
            scene.gltf
        }
    };
    let known = gltf.node_count();
    let mut list = Vec::with_capacity(found.len());
    // The piece of each node, and of nodes that show a mesh of ours the positions of their vertices.
    let mut of_nodes: BTreeMap<usize, u32> = BTreeMap::new();
    let mut sources: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    let mut of_base = Vec::new();
    for (index, part) in (0..).zip(found) {
        let mut piece = part.piece();
        let nodes = match part.source {
            Source::Nodes(nodes) => nodes,
            Source::Positions(members) => {
                of_base.push((index, members));
                Vec::new()
            }
            Source::Own(subject) => {
                let scene = Scene::new(named(subject.model, &piece.name), subject.point_of, limits)?;
                let roots = gltf.merge(scene.gltf, &piece.name)?;
                if let (Some(source), Some(&node)) = (scene.source, roots.first()) {
                    sources.insert(node, source);
                }
                let nodes = gltf.mesh_nodes(&roots);
                piece.nodes = roots;
                nodes
            }
        };
        for node in nodes {
            of_nodes.entry(node).or_insert(index);
        }
        list.push(piece);
    }
    let rest = gltf.rest()?;
    let mut of = vec![Pieces::NONE; rest.positions.len()];
    let mut own = vec![ANY; rest.positions.len()];
    for block in &rest.blocks {
        let range = block.first..block.first.saturating_add(block.count);
        let Some(&piece) = of_nodes.get(&block.node) else { continue };
        claim(&mut of, piece, range.clone());
        let facts = list.get_mut(piece as usize).filter(|piece| piece.distinct);
        if let (Some(source), Some(facts), Some(slots)) =
            (sources.get(&block.node), facts, own.get_mut(range))
        {
            slots.iter_mut().zip(source).for_each(|(slot, &position)| *slot = position);
            // Vertices come in the order of the positions.
            let vertex = |position: u32| block.first + source.partition_point(|&other| other < position);
            facts.sides.iter_mut().flatten().flatten().for_each(|p| *p = vertex(*p) as u32);
        }
    }
    for (index, members) in of_base {
        claim(&mut of, index, of_positions(&rest, known, base_source.as_deref(), &members).into_iter());
    }
    let model = Model::Gltf { gltf: Box::new(gltf), rest: Box::new(rest) };
    Ok(Subject { origin, ..Subject::with_pieces(model, list, &of, &own)? })
}

/// The vertices of some positions of the mesh that the first `known` nodes show.
fn of_positions(rest: &Rest, known: usize, source: Option<&[u32]>, members: &[bool]) -> Vec<usize> {
    let blocks = rest.blocks.iter().filter(|block| block.node < known);
    let vertices = blocks.flat_map(|block| block.first..block.first.saturating_add(block.count));
    let is_member = |position: &u32| members.get(*position as usize) == Some(&true);
    let of = vertices.zip(source.unwrap_or(&[]));
    of.filter(|(_, position)| is_member(position)).map(|(vertex, _)| vertex).collect()
}

/// A model whose one part has the name of its piece.
fn named(mut model: Model, name: &str) -> Model {
    if let Model::Mesh { parts, .. } = &mut model
        && let [MeshPart { name: own, .. }] = parts.as_mut_slice()
    {
        name.clone_into(own);
    }
    model
}
