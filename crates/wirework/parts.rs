//! The parts of a mesh: each is a node where it is written as glTF, and an object where as OBJ.

use std::collections::HashMap;
use std::ops::Range;

use wirework_surface::{Mesh, MeshSubdivision};

/// A part of a mesh, with a name of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshPart {
    /// What its node is called in a glTF document, or its object in an OBJ file.
    pub name: String,
    /// Its positions among those of the mesh, ranges in rising order. Each position belongs to one part.
    pub positions: Vec<Range<u32>>,
    /// Its faces.
    pub faces: Range<u32>,
    /// Whether each of its positions is a point of its own, as in what a preset makes. Those of a file share points where they are
    /// equal.
    pub distinct: bool,
}

impl MeshPart {
    /// All of a mesh.
    pub fn whole(name: impl Into<String>, mesh: &Mesh, distinct: bool) -> Self {
        let (positions, faces) = (0..mesh.positions.len() as u32, 0..mesh.face_ends.len() as u32);
        Self { name: name.into(), positions: std::iter::once(positions).collect(), faces, distinct }
    }

    /// How many positions it has.
    pub fn count(&self) -> usize {
        self.positions.iter().map(ExactSizeIterator::len).sum()
    }
}

/// For each of `count` positions its part.
pub(crate) fn of_positions(parts: &[MeshPart], count: usize) -> Vec<u32> {
    let mut out = vec![0; count];
    for (index, part) in (0..).zip(parts) {
        for range in &part.positions {
            if let Some(slots) = out.get_mut(range.start as usize..range.end as usize) {
                slots.fill(index);
            }
        }
    }
    out
}

/// Puts a mesh behind another, as a part.
pub(crate) fn join(whole: &mut Mesh, parts: &mut Vec<MeshPart>, mesh: Mesh, name: &str, distinct: bool) {
    let end = |list: usize| list as u32;
    let (positions, faces) = (end(whole.positions.len()), end(whole.face_ends.len()));
    let (uvs, normals, corners) = (end(whole.uvs.len()), end(whole.normals.len()), end(whole.corners.len()));
    whole.positions.extend(mesh.positions);
    whole.uvs.extend(mesh.uvs);
    whole.normals.extend(mesh.normals);
    whole.face_ends.extend(mesh.face_ends.iter().map(|face| face.saturating_add(corners)));
    whole.corners.extend(mesh.corners.into_iter().map(|mut corner| {
        corner.position = corner.position.saturating_add(positions);
        corner.uv = corner.uv.map(|uv| uv.saturating_add(uvs));
        corner.normal = corner.normal.map(|normal| normal.saturating_add(normals));
        corner
    }));
    let own = positions..end(whole.positions.len());
    parts.push(MeshPart {
        name: name.to_owned(),
        positions: std::iter::once(own).collect(),
        faces: faces..end(whole.face_ends.len()),
        distinct,
    });
}

/// A part as a mesh of its own, and for each of its positions that of the whole.
pub(crate) fn cut(whole: &Mesh, part: &MeshPart) -> (Mesh, Vec<u32>) {
    let source: Vec<u32> = part.positions.iter().flat_map(Clone::clone).collect();
    let position = |i: &u32| whole.positions.get(*i as usize).copied().unwrap_or_default();
    let mut mesh = Mesh { positions: source.iter().map(position).collect(), ..Mesh::default() };
    let (mut uvs, mut normals) = (HashMap::new(), HashMap::new());
    let faces = part.faces.len();
    for face in whole.faces().skip(part.faces.start as usize).take(faces) {
        for corner in face {
            let mut own = *corner;
            // The ranges rise, and so do the positions.
            own.position = source.partition_point(|&i| i < corner.position) as u32;
            own.uv = corner.uv.map(|old| renumbered(old, &mut uvs, &whole.uvs, &mut mesh.uvs));
            own.normal =
                corner.normal.map(|old| renumbered(old, &mut normals, &whole.normals, &mut mesh.normals));
            mesh.corners.push(own);
        }
        mesh.face_ends.push(mesh.corners.len() as u32);
    }
    (mesh, source)
}

/// The number of an entry in a list that takes in what is used.
fn renumbered<T: Copy>(old: u32, known: &mut HashMap<u32, u32>, from: &[T], to: &mut Vec<T>) -> u32 {
    *known.entry(old).or_insert_with(|| {
        to.extend(from.get(old as usize).copied());
        (to.len() as u32).saturating_sub(1)
    })
}

/// The parts of a mesh of `count` positions after it has become finer: a new position is where its parents are.
pub(crate) fn refined(parts: &[MeshPart], count: usize, finer: &MeshSubdivision) -> Vec<MeshPart> {
    let mut of = of_positions(parts, count);
    for [parent, _] in &finer.positions {
        of.push(of.get(*parent as usize).copied().unwrap_or(0));
    }
    let face = |old: u32| finer.sources.partition_point(|&source| source < old) as u32;
    let part = |part: &MeshPart| MeshPart {
        positions: Vec::new(),
        faces: face(part.faces.start)..face(part.faces.end),
        ..part.clone()
    };
    let mut out: Vec<MeshPart> = parts.iter().map(part).collect();
    let mut start = 0;
    for run in of.chunk_by(|a, b| a == b) {
        let end = start + run.len() as u32;
        if let Some(part) = run.first().and_then(|&part| out.get_mut(part as usize)) {
            part.positions.push(start..end);
        }
        start = end;
    }
    out
}

#[cfg(test)]
mod tests {
    use wirework_surface::{cuboid, grid};

    use super::*;

    #[test]
    fn what_is_joined_can_be_cut_out_again() {
        let meshes =
            [grid([1.0; 2], [2, 3], [0.0, 1.0, 0.0]).unwrap(), cuboid([0.0; 3], [1.0; 3], [2; 3]).unwrap()];
        let (mut whole, mut parts) = (Mesh::default(), Vec::new());
        for (mesh, name) in meshes.iter().zip(["a", "b"]) {
            join(&mut whole, &mut parts, mesh.clone(), name, true);
        }
        whole.check().unwrap();
        assert_eq!((parts[1].name.as_str(), parts[1].count()), ("b", meshes[1].positions.len()));
        for (mesh, part) in meshes.iter().zip(&parts) {
            let (own, source) = cut(&whole, part);
            own.check().unwrap();
            assert!(own.positions == mesh.positions && own.face_ends == mesh.face_ends);
            assert!(own.corners.iter().zip(&mesh.corners).all(|(a, b)| a.position == b.position
                && own.uvs[a.uv.unwrap() as usize] == mesh.uvs[b.uv.unwrap() as usize]
                && own.normals[a.normal.unwrap() as usize] == mesh.normals[b.normal.unwrap() as usize]));
            assert!(source.iter().all(|&i| part.positions[0].contains(&i)));
        }
    }
}
