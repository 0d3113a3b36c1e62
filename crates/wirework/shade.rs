//! The vertices that are written, and how they follow the points: places through the weld, normals and tangents through
//! the faces.

use std::collections::HashMap;

use wirework_asset::Rest;
use wirework_surface::{
    Corner, Mesh, MeshError, Normals, NormalsBuffer, NormalsError, Tangents, TangentsBuffer, smooth_normals,
};

use crate::joints::Joints;
use crate::motion::Motion;
use crate::weld::spread;

/// Vertices as a file has them, at rest and at the present moment.
#[derive(Debug)]
pub(crate) struct Vertices {
    rest: Vec<[f32; 3]>,
    point_of: Vec<u32>,
    shading: Option<Shading>,
    joints: Joints,
    /// Whose tangents follow; none: nobody's.
    who: Option<Follow>,
    /// Present positions.
    pub(crate) positions: Vec<[f32; 3]>,
}

#[derive(Debug)]
struct Shading {
    model: Normals,
    buffer: NormalsBuffer,
    now: Vec<[f32; 3]>,
    tangents: Option<Tangential>,
}

#[derive(Debug)]
struct Tangential {
    model: Tangents,
    buffer: TangentsBuffer,
    now: Vec<[f32; 3]>,
}

/// Whose tangents follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Follow {
    /// Those of normal-mapped primitives: morphing the others would cost each viewer and show nowhere.
    NormalMapped,
    /// All: a still replaces geometry, and what is left of the old would be wrong.
    All,
}

impl Vertices {
    /// Vertices without normals; `point_of` has the point of each.
    pub(crate) fn new(rest: Vec<[f32; 3]>, point_of: Vec<u32>) -> Self {
        let positions = rest.clone();
        Self { rest, point_of, shading: None, joints: Joints::default(), who: None, positions }
    }

    /// Gives each vertex a normal, which follows the triangles round it.
    fn shaded(mut self, normals: Vec<[f32; 3]>, triangles: &[[u32; 3]]) -> Result<Self, NormalsError> {
        let model = Normals::new(&self.rest, &normals, triangles)?;
        self.shading =
            Some(Shading { model, buffer: NormalsBuffer::default(), now: normals, tangents: None });
        Ok(self)
    }

    /// The vertices of a scene. Without any normals it has none afterwards.
    pub(crate) fn of_scene(rest: &Rest, point_of: Vec<u32>) -> Result<Self, NormalsError> {
        let mut normals = vec![[0.0; 3]; rest.positions.len()];
        let mut any = false;
        for block in &rest.blocks {
            if let (Some(own), Some(slots)) =
                (&block.normals, normals.get_mut(block.first..block.first + block.count))
            {
                any = true;
                slots.copy_from_slice(own);
            }
        }
        let vertices = Self::new(rest.positions.clone(), point_of);
        if any { vertices.shaded(normals, &rest.triangles) } else { Ok(vertices) }
    }

    /// Lets tangents follow as well, where the scene, that of [`Vertices::of_scene`], has any.
    pub(crate) fn with_tangents(mut self, rest: &Rest, who: Follow) -> Result<Self, NormalsError> {
        self.who = Some(who);
        let Some(shading) = &mut self.shading else { return Ok(self) };
        let mut tangents = vec![[0.0; 3]; self.rest.len()];
        let mut uvs = vec![[0.0; 2]; self.rest.len()];
        let mut triangles = Vec::new();
        let mut any = false;
        for (index, block) in rest.blocks.iter().enumerate() {
            let parts = || rest.parts.iter().filter(move |part| part.block == index);
            let Some(own) = &block.tangents else { continue };
            if who == Follow::NormalMapped && !parts().any(|part| part.normal_mapped) {
                continue;
            }
            any = true;
            let range = block.first..block.first + block.count;
            if let Some(slots) = tangents.get_mut(range.clone()) {
                slots.copy_from_slice(own);
            }
            if let (Some(slots), Some(own)) = (uvs.get_mut(range), block.tangent_uvs()) {
                slots.copy_from_slice(own);
            }
            let of = |part: &wirework_asset::Part| {
                rest.triangles.get(part.first_triangle..part.first_triangle + part.triangle_count)
            };
            triangles.extend(parts().filter_map(of).flatten());
        }
        if any {
            let model = Tangents::new(&self.rest, &shading.now, &tangents, &uvs, &triangles)?;
            shading.tangents = Some(Tangential { model, buffer: TangentsBuffer::default(), now: tangents });
        }
        Ok(self)
    }

    /// Starts from another rest of the same scene, as a clip poses it.
    pub(crate) fn repose(&mut self, moment: &Rest) -> Result<(), NormalsError> {
        let point_of = std::mem::take(&mut self.point_of);
        if self.shading.is_none() {
            *self = Self { who: self.who, ..Self::new(moment.positions.clone(), point_of) };
            return Ok(());
        }
        let new = Self::of_scene(moment, point_of)?;
        *self = match self.who {
            Some(who) => new.with_tangents(moment, who)?,
            None => new,
        };
        Ok(())
    }

    /// Goes where the points of a motion are, with normals and tangents.
    pub(crate) fn follow(&mut self, motion: &Motion<'_>) -> Result<(), NormalsError> {
        if let Some((moment, _)) = motion.evaluation.moment() {
            self.repose(moment)?;
        }
        self.place(motion.before(), &motion.now);
        self.shade(motion.evaluation.joints())
    }

    /// Takes the present places of the points, at rest `points`, to the positions.
    pub(crate) fn place(&mut self, points: &[[f32; 3]], now: &[[f32; 3]]) {
        spread(&self.point_of, points, now, &self.rest, &mut self.positions);
    }

    /// Lets normals and tangents follow the positions; where `joints` of points come together, their normals do.
    pub(crate) fn shade<'a>(
        &mut self,
        joints: impl Iterator<Item = (&'a [u32], f32)>,
    ) -> Result<(), NormalsError> {
        let Some(Shading { model, buffer, now, tangents }) = &mut self.shading else { return Ok(()) };
        model.update_into(&self.positions, buffer, now)?;
        self.joints.join(joints, &self.point_of, &self.positions, now);
        match tangents {
            Some(tangents) => {
                let Tangential { model, buffer, now: out } = tangents;
                model.update_into(&self.positions, now, buffer, out)
            }
            None => Ok(()),
        }
    }

    /// Present normals, where the vertices have any.
    pub(crate) fn normals(&self) -> Option<&[[f32; 3]]> {
        self.shading.as_ref().map(|shading| shading.now.as_slice())
    }

    /// Present tangents, where vertices have any that follow; those of the others are 0.
    pub(crate) fn tangents(&self) -> Option<&[[f32; 3]]> {
        self.shading.as_ref()?.tangents.as_ref().map(|tangents| tangents.now.as_slice())
    }
}

/// The unit normals of a scene at rest: its own, smooth ones where it has none, and 0 where nothing has any.
pub(crate) fn rest_normals(rest: &Rest) -> Vec<[f32; 3]> {
    let mut out = vec![[0.0; 3]; rest.positions.len()];
    for block in &rest.blocks {
        let slots = out.get_mut(block.first..block.first + block.count);
        if let (Some(own), Some(slots)) = (&block.normals, slots) {
            slots.copy_from_slice(own);
        }
    }
    if out.contains(&[0.0; 3]) {
        let smooth = smooth_normals(&rest.positions, &rest.triangles);
        for (normal, smooth) in out.iter_mut().zip(smooth).filter(|(normal, _)| **normal == [0.0; 3]) {
            *normal = smooth;
        }
    }
    out
}

/// A mesh whose every normal belongs to one position, and its normals as vertices.
///
/// A flat face shares one normal among its positions, which part when it bends. A mesh whose normals are each of one
/// position already keeps their numbering.
pub(crate) fn own_normals(mesh: &Mesh, point_of: &[u32]) -> Result<(Mesh, Option<Vertices>), MeshOrNormals> {
    if mesh.normals.is_empty() {
        return Ok((mesh.clone(), None));
    }
    let mut owners: Vec<Option<u32>> = vec![None; mesh.normals.len()];
    let mut shared = false;
    for corner in &mesh.corners {
        if let Some(owner) = corner.normal.and_then(|n| owners.get_mut(n as usize)) {
            shared |= *owner.get_or_insert(corner.position) != corner.position;
        }
    }
    let mut out = mesh.clone();
    if shared {
        (out.normals, owners) = split(&mut out.corners, &mesh.normals);
    }
    // Corners without a normal still make faces that turn their neighbours: each position then gets a last vertex.
    let count = out.normals.len() as u32;
    let bare = if mesh.corners.iter().any(|corner| corner.normal.is_none()) {
        mesh.positions.len() as u32
    } else {
        0
    };
    let vertex = |corner: &Corner| corner.normal.unwrap_or(count + corner.position);
    let triangles: Vec<[u32; 3]> =
        out.corner_triangles()?.iter().map(|t| t.map(|c| vertex(&out.corners[c as usize]))).collect();
    let positions =
        owners.iter().map(|owner| owner.unwrap_or(0)).chain(0..bare).map(|position| position as usize);
    let rest: Vec<[f32; 3]> =
        positions.clone().map(|i| mesh.positions.get(i).copied().unwrap_or_default()).collect();
    let points = positions.map(|i| point_of.get(i).copied().unwrap_or(0)).collect();
    let mut normals = out.normals.clone();
    normals.resize(rest.len(), [0.0; 3]);
    let vertices = Vertices::new(rest, points).shaded(normals, &triangles)?;
    Ok((out, Some(vertices)))
}

/// Gives each pair of a position and a normal a normal of its own, in the order of the corners.
fn split(corners: &mut [Corner], normals: &[[f32; 3]]) -> (Vec<[f32; 3]>, Vec<Option<u32>>) {
    let mut known = HashMap::new();
    let (mut out, mut owners) = (Vec::new(), Vec::new());
    for corner in corners {
        let Some(old) = corner.normal else { continue };
        let new = *known.entry((corner.position, old)).or_insert_with(|| {
            out.push(normals.get(old as usize).copied().unwrap_or_default());
            owners.push(Some(corner.position));
            out.len() as u32 - 1
        });
        corner.normal = Some(new);
    }
    (out, owners)
}

/// What can be wrong with a mesh whose normals are to follow.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MeshOrNormals {
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Normals(#[from] NormalsError),
}

impl From<MeshOrNormals> for crate::JobError {
    fn from(error: MeshOrNormals) -> Self {
        match error {
            MeshOrNormals::Mesh(error) => error.into(),
            MeshOrNormals::Normals(error) => error.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use wirework_surface::{cuboid, sphere};

    use super::*;

    #[test]
    fn a_bent_flat_face_gets_a_normal_for_each_position() {
        let mesh = cuboid([-1.0; 3], [1.0; 3], [2, 2, 2]).unwrap();
        let points: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        let (out, vertices) = own_normals(&mesh, &points).unwrap();
        let mut vertices = vertices.unwrap();
        assert_eq!(out.normals.len(), 6 * 9, "nine positions a side");
        for (a, b) in mesh.corners.iter().zip(&out.corners) {
            assert_eq!(mesh.normals[a.normal.unwrap() as usize], out.normals[b.normal.unwrap() as usize]);
        }
        let mut now = mesh.positions.clone();
        let top = now.iter().position(|p| *p == [0.0, 1.0, 0.0]).unwrap();
        now[top][1] = 2.0;
        vertices.place(&mesh.positions, &now);
        vertices.shade(std::iter::empty()).unwrap();
        let corner =
            |p: [f32; 3]| out.corners.iter().find(|c| mesh.positions[c.position as usize] == p).unwrap();
        let normal = vertices.normals().unwrap()[corner([1.0, -1.0, 0.0]).normal.unwrap() as usize];
        assert!(normal == [1.0, 0.0, 0.0] || normal == [0.0, -1.0, 0.0], "{normal:?}");
        let turned = vertices.normals().unwrap().iter().zip(&out.normals).filter(|(a, b)| a != b);
        let rest: Vec<_> = turned.map(|(_, rest)| *rest).collect();
        assert!(
            rest.len() > 4 && rest.iter().all(|n| *n == [0.0, 1.0, 0.0]),
            "the top, and nothing else: {rest:?}"
        );
    }

    #[test]
    fn a_smooth_mesh_keeps_its_numbering() {
        let mesh = sphere([0.0; 3], 1.0, [16, 8]).unwrap();
        let points: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        let (out, _) = own_normals(&mesh, &points).unwrap();
        assert_eq!(out, mesh);
    }
}
