//! The parts of an asset that `only` and `mask` of a preset can name or use.

use std::collections::BTreeMap;

use serde::Serialize;
use wirework_asset::{AssetError, Gltf, Obj, Rest};
use wirework_surface::Mesh;

use super::MeshFacts;
use crate::MeshPart;

/// A node that can be named in `only`: by its name, or where that is missing by its number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct NodeFacts {
    /// Its number.
    pub node: usize,
    /// Its name.
    pub name: Option<String>,
    /// The mesh that it shows. With one, or with nodes below it that show some, it can stand in `only: Nodes(..)`.
    pub mesh: Option<usize>,
    /// How many nodes it means there: itself if it shows a mesh, else those below it that do.
    pub mesh_nodes: usize,
    /// The vertices that those show.
    pub vertices: usize,
    /// The skins that it is a joint of. With any it can stand in `only: Joints(..)`.
    pub joint_of: Vec<usize>,
    /// The vertices that hang on it as a joint, however little.
    pub joint_vertices: usize,
    /// Where it is in the world at rest, metres.
    pub position: [f32; 3],
}

/// A material, or a group of an OBJ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PartFacts {
    /// Its name.
    pub name: Option<String>,
    /// The vertices that `only` means by it; none where the file is refused before they are counted.
    pub vertices: Option<usize>,
}

pub(super) fn nodes(gltf: &Gltf, rest: &Rest) -> Result<Vec<NodeFacts>, AssetError> {
    let census = gltf.node_census(rest)?;
    let facts = census.into_iter().map(|entry| NodeFacts {
        node: entry.node,
        name: gltf.node_name(entry.node).map(str::to_owned),
        mesh: entry.mesh,
        mesh_nodes: entry.mesh_nodes,
        vertices: entry.vertices,
        joint_of: entry.joint_of,
        joint_vertices: entry.joint_vertices,
        position: entry.position,
    });
    Ok(facts.collect())
}

pub(super) fn materials(gltf: &Gltf, rest: &Rest) -> Result<Vec<PartFacts>, AssetError> {
    let fact = |(material, vertices)| PartFacts {
        name: gltf.material_name(material).map(str::to_owned),
        vertices: Some(vertices),
    };
    Ok(gltf.material_census(rest)?.into_iter().enumerate().map(fact).collect())
}

/// The groups of an OBJ; without any its parts are what can be named.
pub(super) fn groups(parts: &[MeshPart], obj: Option<&Obj>) -> Vec<PartFacts> {
    let mut census = obj.map(Obj::group_census).unwrap_or_default();
    if census.is_empty() {
        census.extend(parts.iter().map(|part| (part.name.clone(), part.count())));
    }
    named_parts(census)
}

pub(super) fn named_parts(census: BTreeMap<String, usize>) -> Vec<PartFacts> {
    census
        .into_iter()
        .map(|(name, vertices)| PartFacts { name: Some(name), vertices: Some(vertices) })
        .collect()
}

/// The one mesh of an OBJ. Colours that cannot be read are a warning.
pub(super) fn of_mesh(
    mesh: &Mesh,
    obj: Option<&Obj>,
    triangles: usize,
    warnings: &mut Vec<String>,
) -> MeshFacts {
    let colors = obj.map_or(Ok(None), Obj::colors).unwrap_or_else(|error| {
        warnings.push(broken_colors(&error));
        None
    });
    let mut mapped = vec![false; mesh.positions.len()];
    for corner in mesh.corners.iter().filter(|corner| corner.uv.is_some()) {
        if let Some(slot) = mapped.get_mut(corner.position as usize) {
            *slot = true;
        }
    }
    MeshFacts {
        primitives: 1,
        vertices: mesh.positions.len(),
        triangles,
        colored_vertices: colors.unwrap_or_default().iter().flatten().count(),
        mapped_vertices: mapped.into_iter().filter(|mapped| *mapped).count(),
        ..MeshFacts::default()
    }
}

/// What harms nobody but a mask.
pub(super) fn broken_colors(error: &AssetError) -> String {
    format!("{error}; a mask of vertex colours will be refused [colors]")
}
