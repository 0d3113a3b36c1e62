//! Rotations as vectors, axis times angle, and the least rotation between two directions: `bend: Tangent`.

use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// The sine below which two opposite directions are antiparallel, their cross product being no axis any more.
const ANTIPARALLEL: f64 = 1e-6;

/// The least rotation that turns `from` to `to`, as axis times angle; zero where one of them is. Opposite
/// directions turn about `from × e`, `e` the coordinate axis least aligned with `from`, the first of equal ones.
pub fn least_rotation(from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    least(DVec3::from_array(from), DVec3::from_array(to)).to_array()
}

pub(crate) fn least(from: DVec3, to: DVec3) -> DVec3 {
    let (from, to) = (from.normalize_or_zero(), to.normalize_or_zero());
    if from == DVec3::ZERO || to == DVec3::ZERO || from == to {
        return DVec3::ZERO;
    }
    let (cross, dot) = (from.cross(to), from.dot(to));
    if cross.length() < ANTIPARALLEL && dot < 0.0 {
        return PI * from.cross(least_aligned_axis(from)).normalize();
    }
    cross.normalize_or_zero() * cross.length().atan2(dot)
}

fn least_aligned_axis(v: DVec3) -> DVec3 {
    let [x, y, z] = v.abs().to_array();
    if x <= y && x <= z {
        DVec3::X
    } else if y <= z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// `v` turned by a rotation vector; exactly `v` when that is zero.
pub(crate) fn turn(v: DVec3, rotation: DVec3) -> DVec3 {
    if rotation == DVec3::ZERO {
        return v;
    }
    let angle = rotation.length();
    let axis = rotation / angle;
    let (sin, cos) = angle.sin_cos();
    v * cos + axis.cross(v) * sin + axis * axis.dot(v) * (1.0 - cos)
}

pub(crate) fn quat(rotation: DVec3) -> DQuat {
    DQuat::from_scaled_axis(rotation)
}

/// Of all rotation vectors of `q` the one nearest to `previous`. They lie on one line, 2π apart, except those of the
/// identity, which fill spheres.
pub(crate) fn continued(q: DQuat, previous: DVec3) -> DVec3 {
    /// A sine of half the angle this small is rounding: `q` is the identity.
    const IDENTITY: f64 = 1e-14;
    let q = q.normalize();
    let sin = q.xyz().length();
    if sin < IDENTITY {
        return (previous.length() / TAU).round() * TAU * previous.normalize_or_zero();
    }
    let axis = q.xyz() / sin;
    let angle = 2.0 * sin.atan2(q.w);
    axis * (angle + TAU * ((previous.dot(axis) - angle) / TAU).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_rotation_carries_one_direction_to_the_other() {
        for (from, to) in [
            (DVec3::X, DVec3::Y),
            (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-3.0, 0.1, 0.2)),
            (DVec3::X, -DVec3::X),
            (DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, -1.0, -1.0)),
        ] {
            let turned = turn(from.normalize(), least(from, to));
            assert!(turned.distance(to.normalize()) < 1e-12, "{from} to {to}: {turned}");
        }
    }

    #[test]
    fn half_a_turn_takes_the_documented_axis() {
        // Y and Z are equally unaligned with X, the first of them is Y: X × Y = Z.
        assert_eq!(least(DVec3::X, -DVec3::X), PI * DVec3::Z);
        assert_eq!(least(DVec3::Y, -DVec3::Y), -PI * DVec3::Z);
    }

    #[test]
    fn a_continued_angle_passes_whole_turns() {
        let mut vector = DVec3::ZERO;
        for i in 0..=400 {
            vector = continued(quat(DVec3::Z * 0.05 * f64::from(i)), vector);
        }
        assert!(vector.distance(DVec3::Z * 20.0) < 1e-9, "{vector}");
    }
}
