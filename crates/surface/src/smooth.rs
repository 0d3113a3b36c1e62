//! Smooth normals of triangles: the mean over the faces round a vertex, weighted by the angle of each there.
//!
//! The angle makes the result independent of how the surface is cut into triangles.

use glam::DVec3;

use crate::distinct::Distinct;
use crate::vector::wide;

/// Where the mean of the unit normals round a vertex is shorter than this there is no outside: both sides of a
/// sheet meet there. A fold sharper than 0.1 degrees would be mistaken for one.
const NO_SIDE: f64 = 1e-3;

/// A triangle's unit normal, `None` without area, and its angles in radians.
pub(crate) fn face_normal(corners: [DVec3; 3]) -> Option<DVec3> {
    let [a, b, c] = corners;
    (b - a).cross(c - a).try_normalize()
}

/// The angle of a triangle at each of its corners, radians.
pub(crate) fn angles(corners: [DVec3; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        let (e, f) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
        // Good for slivers, where acos of the cosine is not.
        e.cross(f).length().atan2(e.dot(f))
    })
}

/// The smooth unit normal at each vertex, `[0, 0, 0]` where there is none (no face, or both sides of a sheet).
///
/// Vertices at equal positions share one normal: the surface is taken as closed across texture seams and hard
/// edges. Triangles with an index out of range are passed over.
pub fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let Distinct { of: group, first } = Distinct::new(positions.len(), |i| positions[i]);
    let mut sums = vec![(DVec3::ZERO, 0.0); first.len()];
    for triangle in triangles {
        if triangle.iter().any(|&i| i as usize >= positions.len()) {
            continue;
        }
        let corners = triangle.map(|i| wide(positions[i as usize]));
        let Some(normal) = face_normal(corners) else { continue };
        for (angle, &vertex) in angles(corners).iter().zip(triangle) {
            let (sum, weight) = &mut sums[group[vertex as usize] as usize];
            *sum += normal * *angle;
            *weight += angle;
        }
    }
    let normal = |&g: &u32| {
        let (sum, weight) = sums[g as usize];
        if sum.length() > NO_SIDE * weight { sum.normalize_or_zero().as_vec3().to_array() } else { [0.0; 3] }
    };
    group.iter().map(normal).collect()
}

/// The smooth unit normal where triangles meet in one of their corners, each with which corner it is; zero where there is none.
pub(crate) fn fan_normal(fan: impl Iterator<Item = ([DVec3; 3], usize)>) -> DVec3 {
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for (corners, corner) in fan {
        let Some(normal) = face_normal(corners) else { continue };
        let angle = angles(corners)[corner];
        sum += normal * angle;
        weight += angle;
    }
    if sum.length() > NO_SIDE * weight { sum.normalize_or_zero() } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{cuboid, sphere};

    #[test]
    fn spheres_and_box_corners() {
        let mesh = sphere([0.0; 3], 2.0, [48, 24]).unwrap();
        let normals = smooth_normals(&mesh.positions, &mesh.triangles().unwrap());
        for (n, p) in normals.iter().zip(&mesh.positions) {
            assert!(wide(*n).distance(wide(*p) / 2.0) < 0.01);
        }
        let mesh = cuboid([-1.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
        let normals = smooth_normals(&mesh.positions, &mesh.triangles().unwrap());
        for (n, p) in normals.iter().zip(&mesh.positions) {
            assert!(wide(*n).distance(wide(*p).normalize()) < 1e-6, "the angle weighs each side equally");
        }
    }

    #[test]
    fn sheets_with_two_sides_and_lone_vertices_have_none() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0; 3]];
        let normals = smooth_normals(&positions, &[[0, 1, 2], [0, 2, 1], [0, 1, 99]]);
        assert_eq!(normals, [[0.0; 3]; 4]);
    }
}
