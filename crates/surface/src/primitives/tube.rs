//! A cylinder, open or capped.

use std::f64::consts::TAU;

use super::{Builder, PrimitiveError, check_count, check_finite, check_positive, check_size};
use crate::Mesh;
use crate::vector::{frame, wide};

/// A tube of `rings` vertex rings of `sides` vertices each, the first about `from`, the last about `to`.
///
/// Vertex `k · sides + j` is vertex `j` of ring `k`. It lies at the angle `j / sides` of a turn about the axis
/// (right-handed), from what `+X` becomes under the least rotation of `+Y` to the axis. With `caps` the centres
/// of the caps follow, first the one at `from`, then the one at `to`, each a fan of triangles with a hard edge.
/// `u` runs round the axis with a seam at vertex 0, `v` from `from` to `to`.
pub fn tube(
    from: [f32; 3],
    to: [f32; 3],
    radius: f32,
    sides: u32,
    rings: u32,
    caps: bool,
) -> Result<Mesh, PrimitiveError> {
    check_finite("from", &from)?;
    check_finite("to", &to)?;
    check_positive("radius", &[radius])?;
    check_count("sides", 3, &[sides])?;
    check_count("rings", 2, &[rings])?;
    check_size(&[[sides.saturating_add(1), rings]])?;
    let (start, way) = (wide(from), wide(to) - wide(from));
    let axis = way.try_normalize().ok_or(PrimitiveError::SameEnds)?;
    let [e1, _, e2] = frame(axis);
    let outwards = |j: u32| {
        let angle = f64::from(j) / f64::from(sides) * TAU;
        // X towards −Z is the right-handed turn about Y.
        e1 * angle.cos() - e2 * angle.sin()
    };
    let mut builder = Builder::default();
    for j in 0..sides {
        builder.normal(outwards(j));
    }
    for k in 0..rings {
        let x = f64::from(k) / f64::from(rings - 1);
        for j in 0..sides {
            builder.position(start + way * x + outwards(j) * f64::from(radius));
        }
        for j in 0..=sides {
            builder.uv(f64::from(j) / f64::from(sides), x);
        }
    }
    for k in 0..rings - 1 {
        for j in 0..sides {
            let next = (j + 1) % sides;
            let corner = |k: u32, j: u32, uv: u32| [k * sides + j, k * (sides + 1) + uv, j];
            builder.face(&[
                corner(k, j, j),
                corner(k, next, j + 1),
                corner(k + 1, next, j + 1),
                corner(k + 1, j, j),
            ]);
        }
    }
    if caps {
        cap(&mut builder, wide(from), -axis, sides, 0, true);
        cap(&mut builder, wide(to), axis, sides, (rings - 1) * sides, false);
    }
    builder.finish("radius")
}

/// A fan about `center` over the ring that starts at vertex `ring`; `flip` where the ring runs clockwise seen
/// from outside.
fn cap(builder: &mut Builder, center: glam::DVec3, axis: glam::DVec3, sides: u32, ring: u32, flip: bool) {
    let middle = [builder.position(center), builder.uv(0.5, 0.5), builder.normal(axis)];
    let mut rim = Vec::with_capacity(sides as usize);
    for j in 0..sides {
        let angle = f64::from(j) / f64::from(sides) * TAU;
        let turn = if flip { -angle } else { angle };
        rim.push([ring + j, builder.uv(0.5 + 0.5 * turn.cos(), 0.5 + 0.5 * turn.sin()), middle[2]]);
    }
    for j in 0..rim.len() {
        let (a, b) = (rim[j], rim[(j + 1) % rim.len()]);
        builder.face(&if flip { [middle, b, a] } else { [middle, a, b] });
    }
}

#[cfg(test)]
mod tests {
    use super::super::conformance;
    use super::*;

    #[test]
    fn counts_radius_and_volume() {
        for to in [[0.0, 2.0, 0.0], [3.0, 0.0, 0.0], [-1.0, -2.0, 0.5], [0.0, -1.0, 0.0]] {
            let mesh = tube([0.0; 3], to, 0.25, 32, 7, true).unwrap();
            assert_eq!((mesh.positions.len(), mesh.face_ends.len()), (32 * 7 + 2, 32 * 6 + 64));
            let volume = conformance::check(&mesh, true);
            let base = 32.0 / 2.0 * (TAU / 32.0).sin() * 0.25 * 0.25;
            assert!((volume - base * wide(to).length()).abs() < 1e-5, "{volume}");
            let axis = wide(to).normalize();
            for (i, &p) in mesh.positions[..32 * 7].iter().enumerate() {
                let (along, k) = (wide(p).dot(axis), (i / 32) as f64);
                assert!((along - k / 6.0 * wide(to).length()).abs() < 1e-6);
                assert!((wide(p).reject_from(axis).length() - 0.25).abs() < 1e-6);
            }
        }
        let open = tube([1.0; 3], [2.0; 3], 0.1, 3, 2, false).unwrap();
        assert_eq!((open.positions.len(), open.face_ends.len()), (6, 3));
        conformance::check(&open, false);
    }

    #[test]
    fn upright_tubes_start_at_plus_x() {
        let mesh = tube([0.0; 3], [0.0, 1.0, 0.0], 2.0, 4, 2, true).unwrap();
        assert_eq!(mesh.positions[0], [2.0, 0.0, 0.0]);
        assert!((wide(mesh.positions[1]) - glam::DVec3::new(0.0, 0.0, -2.0)).length() < 1e-6);
        assert_eq!(mesh.positions[8..], [[0.0; 3], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn bad_arguments_are_named() {
        let error = |to, radius, sides, rings| tube([0.0; 3], to, radius, sides, rings, true).unwrap_err();
        let to = [1.0; 3];
        assert_eq!(error([0.0; 3], 1.0, 8, 2), PrimitiveError::SameEnds);
        assert_eq!(error(to, -1.0, 8, 2), PrimitiveError::NotPositive { argument: "radius" });
        assert_eq!(error(to, f32::INFINITY, 8, 2), PrimitiveError::NotFinite { argument: "radius" });
        assert_eq!(error(to, 1.0, 2, 2), PrimitiveError::TooFew { argument: "sides", least: 3, found: 2 });
        assert_eq!(error(to, 1.0, 8, 1), PrimitiveError::TooFew { argument: "rings", least: 2, found: 1 });
    }
}
