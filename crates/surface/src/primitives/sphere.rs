//! A sphere by latitude and longitude.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Builder, PrimitiveError, check_count, check_finite, check_positive, check_size};
use crate::Mesh;
use crate::vector::wide;

/// A sphere of `segments[0]` segments round the Y axis and `segments[1]` from pole to pole.
///
/// Vertex 0 is the pole at `+Y`; `1 + (k − 1) · segments[0] + j` is vertex `j` of ring `k` of
/// `1 .. segments[1]`, counted from that pole, at the angle `j / segments[0]` of a right-handed turn about Y from
/// `+X`; the pole at `−Y` is last. Triangles at the poles, quads between. `u` runs round the axis with a
/// seam at vertex 0 of each ring, `v` from `−Y` to `+Y`.
pub fn sphere(center: [f32; 3], radius: f32, segments: [u32; 2]) -> Result<Mesh, PrimitiveError> {
    check_finite("center", &center)?;
    check_positive("radius", &[radius])?;
    let [around, down] = segments;
    check_count("segments", 3, &[around])?;
    check_count("segments", 2, &[down])?;
    check_size(&[[around.saturating_add(1), down.saturating_add(1)]])?;
    let mut builder = Builder::default();
    let add = |builder: &mut Builder, n: DVec3| {
        builder.position(wide(center) + n * f64::from(radius));
        builder.normal(n);
    };
    add(&mut builder, DVec3::Y);
    for k in 1..down {
        let (sin, cos) = (f64::from(k) / f64::from(down) * PI).sin_cos();
        for j in 0..around {
            let angle = f64::from(j) / f64::from(around) * TAU;
            add(&mut builder, DVec3::new(sin * angle.cos(), cos, -sin * angle.sin()));
        }
    }
    add(&mut builder, DVec3::NEG_Y);
    faces(&mut builder, around, down);
    builder.finish("radius")
}

fn faces(builder: &mut Builder, around: u32, down: u32) {
    let last = 1 + (down - 1) * around;
    // One texture coordinate a column, and one more than columns on the rings between the poles.
    for k in 0..=down {
        let pole = k == 0 || k == down;
        for j in 0..=around {
            let shift = if pole && j < around { 0.5 } else { 0.0 };
            builder.uv((f64::from(j) + shift) / f64::from(around), 1.0 - f64::from(k) / f64::from(down));
        }
    }
    let corner = |k: u32, j: u32| {
        let position = match k {
            0 => 0,
            k if k == down => last,
            k => 1 + (k - 1) * around + j % around,
        };
        [position, k * (around + 1) + j, position]
    };
    for k in 0..down {
        for j in 0..around {
            let (a, b) = (corner(k + 1, j), corner(k + 1, j + 1));
            let (c, d) = (corner(k, j + 1), corner(k, j));
            if k == 0 {
                builder.face(&[a, b, d]);
            } else if k == down - 1 {
                builder.face(&[a, c, d]);
            } else {
                builder.face(&[a, b, c, d]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::conformance;
    use super::*;

    #[test]
    fn counts_radius_and_volume() {
        for [around, down] in [[64, 32], [3, 2], [5, 3]] {
            let mesh = sphere([1.0, 2.0, 3.0], 0.5, [around, down]).unwrap();
            assert_eq!(mesh.positions.len() as u32, around * (down - 1) + 2);
            assert_eq!(mesh.face_ends.len() as u32, around * down);
            let volume = conformance::check(&mesh, true);
            let ball = 4.0 / 3.0 * PI * 0.125;
            assert!(volume < ball && (around < 64 || volume > 0.99 * ball), "{volume} of {ball}");
            for &p in &mesh.positions {
                assert!((wide(p).distance(DVec3::new(1.0, 2.0, 3.0)) - 0.5).abs() < 1e-6);
            }
            assert_eq!((mesh.positions[0], *mesh.positions.last().unwrap()), ([1., 2.5, 3.], [1., 1.5, 3.]));
        }
    }

    #[test]
    fn bad_arguments_are_named() {
        let error = |radius, segments| sphere([0.0; 3], radius, segments).unwrap_err();
        assert_eq!(error(0.0, [8, 8]), PrimitiveError::NotPositive { argument: "radius" });
        let far = sphere([f32::MAX; 3], f32::MAX, [8, 8]);
        assert_eq!(far, Err(PrimitiveError::NotFinite { argument: "radius" }));
        assert_eq!(error(1.0, [2, 8]), PrimitiveError::TooFew { argument: "segments", least: 3, found: 2 });
        assert_eq!(error(1.0, [8, 1]), PrimitiveError::TooFew { argument: "segments", least: 2, found: 1 });
    }
}
