//! Rotations from one direction to another.

use glam::{DQuat, DVec3};

/// Directions count as opposite where the sine of their angle is below this: their plane would be noise.
const OPPOSITE: f64 = 1e-9;

/// The least rotation from the direction of `a` to that of `b`; of opposite ones half a turn about what `axis` gives, a unit vector across them.
/// The identity where one is zero.
pub(crate) fn least_rotation(a: DVec3, b: DVec3, axis: impl FnOnce() -> DVec3) -> DQuat {
    let (cross, dot) = (a.cross(b), a.dot(b));
    let both = (a.length_squared() * b.length_squared()).sqrt();
    if both == 0.0 {
        return DQuat::IDENTITY;
    }
    if dot < 0.0 && cross.length() < OPPOSITE * both {
        return DQuat::from_axis_angle(axis(), std::f64::consts::PI);
    }
    // By half the angle: no function of angles is needed.
    DQuat::from_xyzw(cross.x, cross.y, cross.z, both + dot).normalize()
}

/// The unit vector across `direction` towards the coordinate axis least aligned with it, the first of equals.
pub(crate) fn aside(direction: DVec3) -> DVec3 {
    let m = direction.abs();
    let axis = if m.x <= m.y && m.x <= m.z {
        DVec3::X
    } else if m.y <= m.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    (axis - direction * direction.dot(axis)).normalize_or(DVec3::Y)
}

/// A point in double precision.
pub(crate) fn double(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_turn_the_short_way() {
        let a = DVec3::new(1.0, 2.0, 3.0);
        for b in [DVec3::X, DVec3::new(-1.0, -2.0, -2.9), a * 2.0] {
            let turned = least_rotation(a, b, || DVec3::X) * a.normalize();
            assert!(turned.distance(b.normalize()) < 1e-12, "{b}");
        }
        let axis = aside(a.normalize());
        assert!(axis.dot(a).abs() < 1e-12 && axis.x > 0.9);
        assert!((least_rotation(a, -a, || axis) * a + a).length() < 1e-12);
        assert!((least_rotation(a, -a, || axis) * axis - axis).length() < 1e-12);
        assert_eq!(least_rotation(a, DVec3::ZERO, || axis), DQuat::IDENTITY);
    }

    #[test]
    fn of_equal_axes_the_first_is_taken() {
        assert_eq!(aside(DVec3::X), DVec3::Y);
        assert_eq!(aside(DVec3::Y), DVec3::X);
        assert_eq!(aside(DVec3::Z), DVec3::X);
    }
}
