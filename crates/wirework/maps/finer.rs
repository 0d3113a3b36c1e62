//! The finer copy that the effect is worked out on, and which triangle of the rest each of its triangles is a part of.

use wirework_preset::Effect;
use wirework_surface::{Mesh, MeshSubdivision, SubdivideLimits, Wanted, subdivide};

use crate::fineness::Span;
use crate::maps::curve::curve;
use crate::maps::ground::Ground;
use crate::maps::job::MapJob;
use crate::maps::wishes::wishes;
use crate::subject::Model;
use crate::{JobError, MeshPart, Subject};

/// The most triangles of a copy: some 10 s of work. Folds of more are worked out coarser, with a warning.
const MOST: f64 = 3e6;
/// The area of an equilateral triangle of side 1 is 0.43; halving leaves such of half that in the mean.
const AREA: f64 = 0.22;

/// For each triangle of a finer scene those of the coarse one that it may be a part of, a run of them: most often one.
pub(crate) type Lineage = Vec<std::ops::Range<u32>>;

/// The subject as fine as its folds need it, and the lineage of its triangles; none where it stays as it is.
pub(crate) fn finer(
    job: &MapJob<'_>,
    subject: Subject,
    effects: &[Effect],
    span: Span,
    ground: &Ground,
    warnings: &mut Vec<String>,
) -> Result<(Subject, Option<Lineage>), JobError> {
    if !job.refine || subject.net.is_some() {
        return Ok((subject, None));
    }
    let mut wanted = wishes(job, &subject, effects, span, ground)?;
    let triangles = expected(&subject, &wanted);
    if triangles > MOST {
        let factor = (triangles / MOST).sqrt();
        for wish in &mut wanted {
            *wish *= factor as f32;
        }
        warnings.push(format!(
            "the folds would need {:.1} million triangles; the map is made of a copy that is {factor:.1} times coarser \
             [map-coarse]",
            triangles / 1e6
        ));
    }
    let lineage = lineage(job, &subject, &wanted, ground)?;
    let (mut subject, _) = subject.refined(&wanted, &job.limits)?;
    curve(job, &mut subject, ground, &lineage)?;
    Ok((subject, Some(lineage)))
}

/// About how many triangles there will be.
fn expected(subject: &Subject, wanted: &[f32]) -> f64 {
    let parts = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| glam::DVec3::from(subject.points[v as usize].map(f64::from)));
        let wish = triangle.iter().map(|&v| f64::from(wanted[v as usize])).fold(0.0, f64::max);
        let parts = (b - a).cross(c - a).length() / 2.0 / (AREA * wish * wish);
        if parts > 1.0 { parts } else { 1.0 }
    };
    subject.triangles.iter().map(parts).sum()
}

fn lineage(
    job: &MapJob<'_>,
    subject: &Subject,
    wanted: &[f32],
    ground: &Ground,
) -> Result<Lineage, JobError> {
    let limits = SubdivideLimits { vertices: job.limits.vertices, triangles: job.limits.indices / 3 };
    let wanted = Wanted { places: &subject.points, place_of: &subject.point_of, longest: wanted };
    // As the subject itself is subdivided: the same input gives the same triangles.
    match &subject.model {
        Model::Gltf { rest, .. } => {
            let finer = subdivide(&rest.triangles, &wanted, limits)?;
            Ok(finer.sources.into_iter().map(|source| source..source + 1).collect())
        }
        Model::Mesh { parts, mesh, .. } => {
            let finer = mesh.subdivide(&wanted, limits)?;
            let coarse = runs(mesh);
            debug_assert_eq!(
                coarse.iter().map(ExactSizeIterator::len).sum::<usize>(),
                ground.scene.rest.triangles.len()
            );
            Ok(if finer.is_empty() { whole(&coarse) } else { of_faces(parts, &coarse, &finer) })
        }
    }
}

/// The triangles of each face, in the order of the faces, which is that of the parts.
fn runs(mesh: &Mesh) -> Vec<std::ops::Range<u32>> {
    let mut end = 0;
    mesh.faces()
        .map(|face| {
            let start = end;
            end += face.len() as u32 - 2;
            start..end
        })
        .collect()
}

fn whole(coarse: &[std::ops::Range<u32>]) -> Lineage {
    coarse.iter().flat_map(|run| run.clone().map(|t| t..t + 1)).collect()
}

/// Of a face that stays each triangle is itself; parts of others are of one of its triangles.
fn of_faces(parts: &[MeshPart], coarse: &[std::ops::Range<u32>], finer: &MeshSubdivision) -> Lineage {
    debug_assert!(parts.windows(2).all(|pair| pair[0].faces.end <= pair[1].faces.start));
    let mut out = Vec::with_capacity(finer.face_ends.len());
    let mut start = 0;
    for (&end, &source) in finer.face_ends.iter().zip(&finer.sources) {
        let (count, run) = ((end - start) - 2, coarse[source as usize].clone());
        start = end;
        if count == 1 {
            out.push(run);
        } else {
            out.extend(run.map(|t| t..t + 1));
        }
    }
    out
}
