//! Between the API's `[f32; 3]` and the vectors that compute.

use glam::DVec3;

/// In double precision.
pub(crate) fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

/// Rounded to single precision.
pub(crate) fn narrow(p: DVec3) -> [f32; 3] {
    p.as_vec3().to_array()
}

/// The vectors `(e₁, axis, e₂)` that `+X, +Y, +Z` become under the least rotation of `+Y` to the unit vector
/// `axis`; for `−Y` half a turn about X.
pub(crate) fn frame(axis: DVec3) -> [DVec3; 3] {
    let c = axis.y;
    // Exactly −Y: every axis of rotation is equally good. Anything else has a least rotation of its own.
    if axis.x == 0.0 && axis.z == 0.0 {
        return [DVec3::X, DVec3::Y * c.signum(), DVec3::Z * c.signum()];
    }
    // v = Y × axis, rotated p = p·c + v × p + v (v·p) / (1 + c), with 1 + c = |v|² / (1 − c) where c < 0.
    let v = DVec3::Y.cross(axis);
    let k = if c < 0.0 { (1.0 - c) / v.length_squared() } else { 1.0 / (1.0 + c) };
    let [e1, e2] =
        [DVec3::X, DVec3::Z].map(|p| (p * c + v.cross(p) + v * (v.dot(p) * k)).normalize_or_zero());
    [e1, axis, e2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_orthonormal_even_near_the_opposite() {
        let near = DVec3::new(1e-9, -1.0, 2e-9).normalize();
        for axis in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, near, DVec3::ONE.normalize()] {
            let [a, b, c] = frame(axis);
            assert_eq!(b, axis);
            assert!((a.cross(b) - c).length() < 1e-12 && a.dot(b).abs() < 1e-12, "{axis}: {a} {b} {c}");
        }
        assert_eq!(frame(DVec3::Y), [DVec3::X, DVec3::Y, DVec3::Z]);
        assert!((frame(DVec3::X)[0] - DVec3::NEG_Y).length() < 1e-15);
    }
}
