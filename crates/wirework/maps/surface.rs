//! The surface that maps are made of: fine triangles, what moves them, and the faces they lie on.

use wirework_bake::map::{Corner, Surface, Triangle, turned};
use wirework_preset::{Action, Effect, PresetErrorKind};

use crate::JobError;
use crate::maps::finer::Lineage;
use crate::maps::ground::{Ground, Mapped, triangles};
use crate::maps::groups::Groups;
use crate::maps::job::MapJob;
use crate::maps::notes::MapMesh;
use crate::motion::Motion;
use crate::output::Scene;
use crate::shade::rest_normals;
use crate::weld::{bits, spread};

/// What has become of the vertices of a fine scene.
pub(crate) struct Moved {
    positions: Vec<[f32; 3]>,
    ways: Vec<[f32; 3]>,
    turned: Vec<[f32; 3]>,
}

impl Moved {
    pub(crate) fn new(motion: &Motion<'_>, scene: &Scene) -> Self {
        let Scene { rest, point_of, .. } = scene;
        let mut positions = rest.positions.clone();
        spread(point_of, motion.before(), &motion.now, &rest.positions, &mut positions);
        let way = |(now, rest): (&[f32; 3], &[f32; 3])| {
            if bits(*now) == bits(*rest) { [0.0; 3] } else { [0, 1, 2].map(|k| now[k] - rest[k]) }
        };
        let ways: Vec<[f32; 3]> = positions.iter().zip(&rest.positions).map(way).collect();
        let turned = turned(&rest.positions, &rest_normals(rest), &rest.triangles, &ways);
        Self { positions, ways, turned }
    }
}

/// Refuses a seam that cuts borders, at its place.
fn cut(effects: &[Effect]) -> JobError {
    let message = "a weld that cuts borders changes the triangles, and a map is for those that the model has: found `weld: true`, \
                   expected `weld: false`";
    let welds = |effect: &Effect| match &effect.action {
        Action::Stitch(stitching) => {
            (0..stitching.stitch.seams.len()).filter(|seam| stitching.stitch.seams[*seam].weld).collect()
        }
        _ => Vec::new(),
    };
    let sewn = effects.iter().map(|effect| (effect, welds(effect))).find(|(_, welds)| !welds.is_empty());
    match sewn {
        Some((effect, welds)) => {
            // Which of several cuts is not known.
            let place = if let [seam] = welds.as_slice() {
                format!("seams[{seam}].weld")
            } else {
                "seams".to_owned()
            };
            let error = effect.typed.error(&place, PresetErrorKind::Value, message, None);
            JobError::Preset(Box::new(error))
        }
        None => JobError::Request(message.to_owned()),
    }
}

/// Puts the surface together, of the parts that anything has moved in, and tells which meshes these are.
pub(crate) fn surface(
    job: &MapJob<'_>,
    (ground, lineage): (Ground, Option<Lineage>),
    (scene, moved): (&Scene, &Moved),
    groups: Option<&Groups>,
    warnings: &mut Vec<String>,
) -> Result<(Surface, Vec<MapMesh>), JobError> {
    let rest = &scene.rest;
    let lineage = lineage.filter(|list| list.len() == rest.triangles.len());
    // What an effect has cut besides is a rest of its own; its triangles are those of the maps.
    let same = ground.scene.rest.triangles.len() == rest.triangles.len();
    let lineage = match lineage {
        Some(lineage) => lineage,
        None if same => (0..rest.triangles.len() as u32).map(|t| t..t + 1).collect(),
        None => return Err(cut(&job.preset.effects)),
    };
    let mut out = Surface { shares: vec![Vec::new(); groups.map_or(0, Groups::len)], ..Surface::default() };
    let is_moved = |mapped: &&Mapped| {
        let moves = |&v: &u32| moved.positions[v as usize] != rest.positions[v as usize];
        triangles(rest, &rest.parts[mapped.index]).as_flattened().iter().any(moves)
    };
    let mut parts: Vec<&Mapped> = ground.parts.iter().filter(is_moved).collect();
    if parts.is_empty() {
        warnings.push("at this moment the effect moves nothing: the maps are flat [map-still]".to_owned());
        parts = ground.parts.iter().collect();
    }
    let mut number = vec![u32::MAX; rest.positions.len()];
    for mapped in &parts {
        add(&mut out, (&ground, mapped), (scene, moved), (&lineage, &mut number), groups, job)?;
    }
    Ok((out, parts.into_iter().map(|mapped| ground.facts(mapped)).collect()))
}

fn add(
    out: &mut Surface,
    (ground, mapped): (&Ground, &Mapped),
    (scene, moved): (&Scene, &Moved),
    (lineage, number): (&Lineage, &mut [u32]),
    groups: Option<&Groups>,
    job: &MapJob<'_>,
) -> Result<(), JobError> {
    let faces = &mapped.faces;
    let first_face = out.faces.len() as u32;
    let coarse = &ground.scene.rest.parts[mapped.index];
    let rest = &scene.rest;
    let part = &rest.parts[mapped.index];
    let first = rest.blocks[part.block].first;
    let missing =
        || JobError::Request(format!("{}: the copy has lost its texture coordinates", job.output.display()));
    let uvs = scene.gltf.uv_set(rest, part, mapped.set)?.ok_or_else(missing)?;
    number.fill(u32::MAX);
    for (offset, triangle) in triangles(rest, part).iter().enumerate() {
        let corners = triangle.map(|v| uvs[v as usize - first]);
        let run = lineage[part.first_triangle + offset].clone();
        let run = run.start.saturating_sub(coarse.first_triangle as u32)
            ..run.end.saturating_sub(coarse.first_triangle as u32);
        let Some(face) = best(faces, run, corners) else { continue };
        let vertices = triangle.map(|v| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = out.uvs.len() as u32;
                out.uvs.push(uvs[v as usize - first]);
                out.moved.push(moved.ways[v as usize]);
                out.turned.push(moved.turned[v as usize]);
                let point = scene.point_of.get(v as usize).copied().unwrap_or_default();
                for (group, list) in out.shares.iter_mut().enumerate() {
                    list.push(groups.map_or(0.0, |groups| groups.share(group, point as usize)));
                }
            }
            *slot
        });
        out.triangles.push(Triangle { vertices, face: first_face + face });
    }
    out.faces.extend_from_slice(faces);
    Ok(())
}

/// Of a run of faces of a part the one in which the middle of a triangle lies deepest.
pub(crate) fn best(faces: &[[Corner; 3]], run: std::ops::Range<u32>, corners: [[f32; 2]; 3]) -> Option<u32> {
    if run.len() == 1 {
        return Some(run.start).filter(|&face| (face as usize) < faces.len());
    }
    let middle = [0, 1].map(|k| corners.iter().map(|c| f64::from(c[k])).sum::<f64>() / 3.0);
    let depth = |face: u32| {
        let Some(corners) = faces.get(face as usize) else { return f64::NEG_INFINITY };
        let [a, b, c] = corners.map(|corner| corner.uv.map(f64::from));
        let area = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let whole = area(a, b, c);
        let parts = [area(middle, b, c), area(a, middle, c), area(a, b, middle)].map(|part| part / whole);
        let least = parts.into_iter().fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { f64::NEG_INFINITY }
    };
    run.filter(|&face| (face as usize) < faces.len())
        .max_by(|a, b| depth(*a).total_cmp(&depth(*b)).then(b.cmp(a)))
}
