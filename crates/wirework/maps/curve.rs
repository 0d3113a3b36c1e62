//! The smooth surface that a viewer shades, in the place of flat triangles.
//!
//! Creases that run over the edges between the flat sides of a coarse mesh bend there, and a map would show it. So the fine copy is
//! bent to what the normals of the coarse one say: each point goes half of the way to its projections onto the tangent planes of the
//! corners round it, in their shares (T. Boubekeur, M. Alexa, "Phong Tessellation", 2008; at a half, in place of their three
//! quarters, a chord becomes the arc). Corners stay where they are, and so does all that is flat.

use glam::DVec3;
use wirework_bake::map::weights;

use crate::maps::finer::Lineage;
use crate::maps::ground::{Ground, triangles};
use crate::maps::job::MapJob;
use crate::maps::surface::best;
use crate::output::Scene;
use crate::subject::Model;
use crate::weld::spread;
use crate::{JobError, Subject};

/// How far a point goes: at a half the middle of a chord comes to that of the arc whose normals are at its ends.
const PART: f64 = 0.5;

/// Bends a fine copy; nothing where its triangles are not those of the lineage.
pub(crate) fn curve(
    job: &MapJob<'_>,
    subject: &mut Subject,
    ground: &Ground,
    lineage: &Lineage,
) -> Result<(), JobError> {
    let scene = Scene::new(subject.model.clone(), subject.point_of.clone(), &job.limits)?;
    if scene.rest.triangles.len() != lineage.len() {
        return Ok(());
    }
    let mut sums = vec![(DVec3::ZERO, 0_u32); subject.points.len()];
    for mapped in &ground.parts {
        let part = &scene.rest.parts[mapped.index];
        let coarse = &ground.scene.rest.parts[mapped.index];
        let first = scene.rest.blocks[part.block].first;
        let Some(uvs) = scene.gltf.uv_set(&scene.rest, part, mapped.set)? else { continue };
        let faces = &mapped.faces;
        let places = triangles(&ground.scene.rest, coarse);
        for (offset, triangle) in triangles(&scene.rest, part).iter().enumerate() {
            let run = lineage[part.first_triangle + offset].clone();
            let own = |t: u32| t.saturating_sub(coarse.first_triangle as u32);
            let corners = triangle.map(|v| uvs[v as usize - first]);
            let Some(face) = best(faces, own(run.start)..own(run.end), corners) else { continue };
            let face = face as usize;
            let at = places[face].map(|v| wide(ground.scene.rest.positions[v as usize]));
            let normals = faces[face].map(|corner| wide(corner.normal).normalize_or_zero());
            let flat = faces[face].map(|corner| corner.uv.map(f64::from));
            for (&vertex, uv) in triangle.iter().zip(corners) {
                let Some(weights) = weights(&flat, uv.map(f64::from)) else { continue };
                let (sum, count) = &mut sums[scene.point_of[vertex as usize] as usize];
                *sum += offset_of(&at, &normals, weights);
                *count += 1;
            }
        }
    }
    let moved = |(p, (sum, count)): (&[f32; 3], &(DVec3, u32))| {
        if *sum == DVec3::ZERO { *p } else { (wide(*p) + *sum / f64::from(*count)).as_vec3().to_array() }
    };
    let points: Vec<[f32; 3]> = subject.points.iter().zip(&sums).map(moved).collect();
    let positions = match &mut subject.model {
        Model::Mesh { mesh, .. } => &mut mesh.positions,
        Model::Gltf { rest, .. } => &mut rest.positions,
    };
    let rest = positions.clone();
    spread(&subject.point_of, &subject.points, &points, &rest, positions);
    subject.points = points;
    Ok(())
}

/// How far a place in a triangle goes, which has these shares of its corners.
fn offset_of(corners: &[DVec3; 3], normals: &[DVec3; 3], weights: [f64; 3]) -> DVec3 {
    if normals[0] == normals[1] && normals[1] == normals[2] {
        return DVec3::ZERO;
    }
    let place: DVec3 = corners.iter().zip(weights).map(|(p, w)| *p * w).sum();
    let down = |k: usize| normals[k] * (place - corners[k]).dot(normals[k]) * weights[k];
    (down(0) + down(1) + down(2)) * -PART
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chord_becomes_its_arc_and_corners_stay() {
        let at = |angle: f64| DVec3::new(angle.sin(), angle.cos(), 0.0);
        let normals = [at(-0.2), at(0.2), at(0.2)];
        let corners = [normals[0], normals[1], normals[2] + DVec3::Z];
        for k in 0..=10 {
            let w = f64::from(k) / 10.0;
            let flat = corners[0] * (1.0 - w) + corners[1] * w;
            let bent = flat + offset_of(&corners, &normals, [1.0 - w, w, 0.0]);
            // Of the fiftieth that the chord is off, a thirtieth is left in its middle.
            assert!((bent.length() - 1.0).abs() < 6e-4, "{} at {w}", bent.length());
        }
        assert_eq!(offset_of(&corners, &normals, [0.0, 1.0, 0.0]).length(), 0.0);
        assert_eq!(offset_of(&corners, &[DVec3::Y; 3], [0.2, 0.3, 0.5]), DVec3::ZERO);
    }
}
