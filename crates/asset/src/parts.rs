//! Translation, rotation and scale of nodes, of those with a matrix too where they are what it is made of.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::graph::{Pose, unit};

/// How far, in parts of their lengths, the axes of a matrix may be from perpendicular and still be those of a rotation with a scale:
/// some units in the last place of the decimals that exporters print.
const SQUARE: f64 = 1e-6;

/// The transform of a node in the space of its parent: it is scaled first, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeParts {
    /// Metres.
    pub translation: [f64; 3],
    /// A quaternion x, y, z, w of length 1.
    pub rotation: [f64; 4],
    /// Along the node's own axes; negative where it mirrors.
    pub scale: [f64; 3],
}

impl NodeParts {
    /// Those of a node; none where its matrix is sheared, or has no inverse.
    pub(crate) fn of(pose: &Pose) -> Option<Self> {
        let (translation, rotation, scale) = match *pose {
            Pose::Parts { translation, rotation, scale } => (translation, rotation, scale),
            Pose::Matrix(matrix) => decomposed(&matrix)?,
        };
        Some(Self {
            translation: translation.to_array(),
            rotation: rotation.to_array(),
            scale: scale.to_array(),
        })
    }
}

fn decomposed(matrix: &DAffine3) -> Option<(DVec3, DQuat, DVec3)> {
    let m = matrix.matrix3;
    let mut scale = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    if m.determinant() < 0.0 {
        scale.x = -scale.x;
    }
    let axes = [m.x_axis / scale.x, m.y_axis / scale.y, m.z_axis / scale.z];
    let [x, y, z] = axes;
    let skew = [x.dot(y), y.dot(z), z.dot(x)].into_iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    // Not a number, where an axis has no length, is not square either.
    let square = skew <= SQUARE && axes.iter().all(|axis| axis.is_finite());
    let turn = DMat3::from_cols(x, y, z);
    square.then(|| (matrix.translation, unit(DQuat::from_mat3(&turn)), scale))
}
