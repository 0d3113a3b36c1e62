//! The transforms of the vertices of a block: one of their node, or those of a skin.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DAffine3, DMat3};
use rayon::prelude::*;

use crate::skin::Influences;
use crate::way::{Way, double, place};

/// So many vertices are taken to the world by one thread at a time.
const BLOCK: usize = 1 << 12;

/// The transforms of a block.
#[derive(Clone, Debug)]
pub(crate) enum Frame {
    Node(Way),
    /// Those of vertices are blended when they are needed: to keep them takes six times the memory of their shares.
    Skin {
        influences: Influences,
        joints: Arc<[DAffine3]>,
        mirrored: bool,
    },
}

impl Frame {
    /// That of a node, which takes positions and normals from its space to the world.
    ///
    /// # Errors
    ///
    /// What is wrong with a vertex.
    pub(crate) fn of_node(
        matrix: &DAffine3,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) -> Result<Self, &'static str> {
        let way = Way::new(matrix);
        in_blocks(positions, normals, |_, positions, normals| {
            for p in positions {
                *p = place(matrix, double(*p))?;
            }
            for n in normals {
                *n = way.normal(double(*n));
            }
            Ok(0)
        })?;
        Ok(Self::Node(way))
    }

    /// That of a skin, whose joints take positions and normals to the world.
    ///
    /// # Errors
    ///
    /// What is wrong with a vertex.
    pub(crate) fn of_skin(
        influences: Influences,
        joints: Arc<[DAffine3]>,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) -> Result<Self, &'static str> {
        let turns = skinned(&influences, &joints, positions, normals)?;
        Ok(Self::Skin { influences, joints, mirrored: turns < 0 })
    }

    /// Takes it to where the node or the joints of the skin are now, and with it positions and normals from the space of the mesh
    /// to the world. Whether a skin is mirrored stays, as the triangles do that were turned round for it.
    ///
    /// # Errors
    ///
    /// What is wrong with a vertex; the frame is as it was then.
    pub(crate) fn follow(
        &mut self,
        node: &DAffine3,
        joints: Option<&Arc<[DAffine3]>>,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) -> Result<(), &'static str> {
        match (&mut *self, joints) {
            (Self::Skin { influences, joints: own, .. }, Some(joints)) => {
                skinned(influences, joints, positions, normals)?;
                *own = Arc::clone(joints);
            }
            _ => *self = Self::of_node(node, positions, normals)?,
        }
        Ok(())
    }

    /// Directions along the surface of the mesh, one a vertex, in the world.
    pub(crate) fn tangents(&self, local: &[[f32; 3]]) -> Vec<[f32; 3]> {
        local.par_iter().enumerate().map(|(v, &t)| self.way(v).tangent(double(t))).collect()
    }

    pub(crate) fn way(&self, vertex: usize) -> Cow<'_, Way> {
        match self {
            Self::Node(way) => Cow::Borrowed(way),
            Self::Skin { influences, joints, .. } => Cow::Owned(Way::new(&influences.matrix(vertex, joints))),
        }
    }

    /// Whether a vertex is in the world where it is in the mesh.
    pub(crate) fn is_identity(&self, vertex: usize) -> bool {
        match self {
            Self::Node(way) => way.identity,
            Self::Skin { influences, joints, .. } => influences.matrix(vertex, joints) == DAffine3::IDENTITY,
        }
    }

    /// Whether most of it turns right-handed into left-handed, which turns triangles round.
    pub(crate) fn mirrored(&self) -> bool {
        match self {
            Self::Node(way) => handedness(&way.transpose) < 0,
            Self::Skin { mirrored, .. } => *mirrored,
        }
    }
}

/// Takes vertices by their joints to the world. Gives how many more stay right-handed than become left-handed.
fn skinned(
    influences: &Influences,
    joints: &[DAffine3],
    positions: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
) -> Result<i64, &'static str> {
    in_blocks(positions, normals, |first, positions, normals| {
        let mut turns = 0;
        for (k, p) in positions.iter_mut().enumerate() {
            let matrix = influences.matrix(first + k, joints);
            *p = place(&matrix, double(*p))?;
            turns += handedness(&matrix.matrix3.transpose());
            if let Some(normal) = normals.get_mut(k) {
                *normal = Way::new(&matrix).normal(double(*normal));
            }
        }
        Ok(turns)
    })
}

/// The sign of the determinant; 0 where there is none.
fn handedness(matrix: &DMat3) -> i64 {
    matrix.determinant().partial_cmp(&0.0).map_or(0, |order| order as i64)
}

/// Does `work` for each block of vertices, which may have no normals: its first vertex, positions and normals. Gives the sum.
fn in_blocks(
    positions: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
    work: impl Fn(usize, &mut [[f32; 3]], &mut [[f32; 3]]) -> Result<i64, &'static str> + Sync,
) -> Result<i64, &'static str> {
    let normals = normals.chunks_mut(BLOCK).chain(std::iter::repeat_with(Default::default));
    let blocks: Vec<_> = positions.chunks_mut(BLOCK).zip(normals).enumerate().collect();
    let work = |(k, (positions, normals)): (usize, (&mut [_], &mut [_]))| work(k * BLOCK, positions, normals);
    blocks.into_par_iter().map(work).try_reduce(|| 0, |a, b| Ok(a + b))
}
