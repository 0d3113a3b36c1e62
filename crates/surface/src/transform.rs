//! Where an object stands: scale, then rotation, then translation.

use glam::{DMat3, DVec3};
use thiserror::Error;

use crate::Mesh;
use crate::vector::{narrow, wide};

/// A placement `p ↦ translation + R · (scale ∘ p)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// In metres. Default 0.
    pub translation: [f32; 3],
    /// Degrees about X, then about Y, then about Z, each a fixed axis: `R = Rz · Ry · Rx`. Default 0.
    pub rotation: [f32; 3],
    /// Factor along each of the object's own axes; negative ones mirror, and faces turn over so that they still
    /// face outwards. Default 1.
    pub scale: [f32; 3],
}

impl Default for Transform {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: [0.0; 3], scale: [1.0; 3] }
    }
}

/// Why an object cannot be placed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TransformError {
    /// A number of the transform is NaN or infinite.
    #[error("`{field}` is not finite")]
    NotFinite {
        /// `"translation"`, `"rotation"` or `"scale"`.
        field: &'static str,
    },
    /// A position would leave the range of f32.
    #[error("the transform takes point {index} out of the range of f32")]
    Overflow {
        /// Which position, from 0.
        index: usize,
    },
}

impl Transform {
    /// Moves points; those that are not finite afterwards are an error, and `points` is then left half moved.
    pub fn apply_to_points(&self, points: &mut [[f32; 3]]) -> Result<(), TransformError> {
        self.check()?;
        if *self == Self::default() {
            return Ok(());
        }
        let (matrix, translation) = (self.linear(), wide(self.translation));
        for (index, point) in points.iter_mut().enumerate() {
            *point = narrow(matrix * wide(*point) + translation);
            if point.iter().any(|c| !c.is_finite()) {
                return Err(TransformError::Overflow { index });
            }
        }
        Ok(())
    }

    /// Moves a mesh: positions, normals (by the inverse transpose) and, where it mirrors, the order of the corners
    /// of each face, the first corner staying first.
    pub fn apply_to_mesh(&self, mesh: &mut Mesh) -> Result<(), TransformError> {
        self.apply_to_points(&mut mesh.positions)?;
        if *self == Self::default() {
            return Ok(());
        }
        let matrix = self.linear();
        let mirrors = matrix.determinant() < 0.0;
        // The cofactor matrix is the inverse transpose times the determinant; it also exists for a flattening scale.
        let cofactor = DMat3::from_cols(
            matrix.y_axis.cross(matrix.z_axis),
            matrix.z_axis.cross(matrix.x_axis),
            matrix.x_axis.cross(matrix.y_axis),
        ) * if mirrors { -1.0 } else { 1.0 };
        for normal in &mut mesh.normals {
            let turned: DVec3 = cofactor * wide(*normal);
            *normal = turned.try_normalize().map_or(*normal, narrow);
        }
        if mirrors {
            let mut start = 0;
            for &end in &mesh.face_ends {
                if let Some([_, rest @ ..]) = mesh.corners.get_mut(start..end as usize) {
                    rest.reverse();
                }
                start = end as usize;
            }
        }
        Ok(())
    }

    fn check(&self) -> Result<(), TransformError> {
        for (field, values) in
            [("translation", self.translation), ("rotation", self.rotation), ("scale", self.scale)]
        {
            if values.iter().any(|v| !v.is_finite()) {
                return Err(TransformError::NotFinite { field });
            }
        }
        Ok(())
    }

    /// Rotation and scale.
    fn linear(&self) -> DMat3 {
        let [x, y, z] = self.rotation.map(|degrees| f64::from(degrees).to_radians());
        DMat3::from_rotation_z(z)
            * DMat3::from_rotation_y(y)
            * DMat3::from_rotation_x(x)
            * DMat3::from_diagonal(wide(self.scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{cuboid, tube};

    fn volume(mesh: &Mesh) -> f64 {
        let at = |i: u32| wide(mesh.positions[i as usize]);
        mesh.triangles().unwrap().iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum()
    }

    #[test]
    fn rotation_is_about_x_then_y_then_z() {
        let rotate = |rotation, p| {
            let mut points = [p];
            Transform { rotation, ..Transform::default() }.apply_to_points(&mut points).unwrap();
            points[0].map(f32::round)
        };
        assert_eq!(rotate([90.0, 0.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(rotate([0.0, 90.0, 0.0], [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(rotate([0.0, 0.0, 90.0], [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        // Y goes to Z about X, then to X about Y, then to Y about Z.
        assert_eq!(rotate([90.0, 90.0, 90.0], [0.0, 1.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(rotate([90.0, 90.0, 0.0], [0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_mirrored_box_still_faces_outwards() {
        for scale in [[2.0, 1.0, 3.0], [-2.0, 1.0, 3.0], [-2.0, -1.0, 3.0], [-2.0, -1.0, -3.0]] {
            let mut mesh = cuboid([-1.0; 3], [1.0; 3], [2, 2, 2]).unwrap();
            let transform = Transform { scale, rotation: [10.0, 20.0, 30.0], translation: [5.0, 0.0, 0.0] };
            transform.apply_to_mesh(&mut mesh).unwrap();
            assert!((volume(&mesh) - 48.0).abs() < 1e-4, "{scale:?}: {}", volume(&mesh));
            assert_normals_agree(&mesh);
        }
    }

    #[test]
    fn normals_of_a_squashed_tube_stay_perpendicular() {
        let mut mesh = tube([0.0; 3], [0.0, 1.0, 0.0], 1.0, 256, 2, false).unwrap();
        Transform { scale: [3.0, 1.0, 1.0], ..Transform::default() }.apply_to_mesh(&mut mesh).unwrap();
        for corner in &mesh.corners {
            let p = wide(mesh.positions[corner.position as usize]);
            let n = wide(mesh.normals[corner.normal.unwrap() as usize]);
            let exact = DVec3::new(p.x / 9.0, 0.0, p.z).normalize();
            assert!(n.distance(exact) < 1e-6);
        }
    }

    fn assert_normals_agree(mesh: &Mesh) {
        for t in mesh.corner_triangles().unwrap() {
            let corners = t.map(|c| mesh.corners[c as usize]);
            let [a, b, c] = corners.map(|c| wide(mesh.positions[c.position as usize]));
            let n = wide(mesh.normals[corners[0].normal.unwrap() as usize]);
            assert!(n.dot((b - a).cross(c - a).normalize()) > 0.999_99);
        }
    }

    #[test]
    fn flattening_keeps_normals_and_bad_numbers_are_errors() {
        let mut mesh = cuboid([-1.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
        Transform { scale: [1.0, 0.0, 1.0], ..Transform::default() }.apply_to_mesh(&mut mesh).unwrap();
        assert!(mesh.check().is_ok());
        let bad = Transform { rotation: [f32::NAN, 0.0, 0.0], ..Transform::default() };
        assert_eq!(bad.apply_to_mesh(&mut mesh), Err(TransformError::NotFinite { field: "rotation" }));
        let large = Transform { scale: [f32::MAX; 3], translation: [f32::MAX; 3], ..Transform::default() };
        assert!(matches!(large.apply_to_mesh(&mut mesh), Err(TransformError::Overflow { .. })));
    }
}
