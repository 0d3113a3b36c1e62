//! The surface at rest that maps are for: which of its parts, in which texture coordinates, in which frames.

use wirework_asset::{Gltf, Part, Rest, printable};
use wirework_bake::map::{Corner, tangents};

use crate::maps::job::MapJob;
use crate::maps::notes::MapMesh;
use crate::output::Scene;
use crate::shade::rest_normals;
use crate::subject::Origin;
use crate::{JobError, Subject};

/// The rest, coarse as a viewer has it.
pub(crate) struct Ground {
    pub(crate) scene: Scene,
    /// The parts that maps are for.
    pub(crate) parts: Vec<Mapped>,
}

/// A part that maps are for.
pub(crate) struct Mapped {
    /// Which of the rest's.
    pub(crate) index: usize,
    /// Its set of texture coordinates.
    pub(crate) set: usize,
    /// One pair a vertex of its block.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Its triangles as a viewer has them.
    pub(crate) faces: Vec<[Corner; 3]>,
}

impl Ground {
    /// Looks for the parts that the job asks for.
    pub(crate) fn of(
        job: &MapJob<'_>,
        subject: &Subject,
        warnings: &mut Vec<String>,
    ) -> Result<Self, JobError> {
        let scene = Scene::new(subject.model.clone(), subject.point_of.clone(), &job.limits)?;
        let unshaded = scene.rest.blocks.iter().any(|block| block.normals.is_none());
        if unshaded && scene.rest.parts.iter().any(|part| part.triangle_count > 0) {
            warnings.push(
                "the model has no normals, and viewers shade it flat; the map is for smooth ones [map-normals]"
                    .to_owned(),
            );
        }
        let normals = rest_normals(&scene.rest);
        let asked = asked(job, &scene)?;
        let (mut parts, mut bare) = (Vec::new(), Vec::new());
        for index in asked {
            let part = &scene.rest.parts[index];
            let set = match job.uv {
                Some(set) => set,
                None => scene.gltf.normal_map_set(part)?.unwrap_or(0),
            };
            match scene.gltf.uv_set(&scene.rest, part, set)? {
                Some(uvs) => {
                    let faces = faces(&scene, (index, set), &uvs, &normals)?;
                    parts.push(Mapped { index, set, uvs, faces });
                }
                None => bare.push((mesh_name(&scene.gltf, part), set)),
            }
        }
        bare.dedup();
        let told = |(name, set): &(String, usize)| format!("mesh {} has no TEXCOORD_{set}", printable(name));
        match (parts.is_empty(), bare.first()) {
            (true, Some(first)) => {
                let file = match &subject.origin {
                    Origin::File(file) => file.clone(),
                    _ => job.preset_path.display().to_string(),
                };
                let own = !matches!(subject.origin, Origin::File(_));
                return Err(JobError::NoTextureCoordinates { file, found: told(first), own });
            }
            (true, None) => {
                return Err(JobError::Request("there are no triangles to make a map for".to_owned()));
            }
            (false, _) => {
                warnings
                    .extend(bare.iter().map(|bare| format!("{}: it is in no map [map-no-uv]", told(bare))));
            }
        }
        Ok(Self { scene, parts })
    }

    /// What is told of a part.
    pub(crate) fn facts(&self, mapped: &Mapped) -> MapMesh {
        let Scene { gltf, rest, .. } = &self.scene;
        let part = &rest.parts[mapped.index];
        let material = part.material.and_then(|material| gltf.material_name(material));
        MapMesh {
            name: mesh_name(gltf, part),
            material: material.map(str::to_owned),
            uv: mapped.set,
            triangles: part.triangle_count,
        }
    }
}

/// The triangles of a part at rest as a viewer has them, on a set of texture coordinates.
fn faces(
    Scene { gltf, rest, .. }: &Scene,
    (index, set): (usize, usize),
    uvs: &[[f32; 2]],
    normals: &[[f32; 3]],
) -> Result<Vec<[Corner; 3]>, JobError> {
    let part = &rest.parts[index];
    let block = &rest.blocks[part.block];
    let own = |v: u32| v as usize - block.first;
    let triangles = triangles(rest, part);
    let given = gltf.map_tangents(rest, part, set)?;
    let computed = if given.is_some() {
        Vec::new()
    } else {
        let range = block.first..block.first + block.count;
        let local: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| own(v) as u32)).collect();
        tangents(&rest.positions[range.clone()], &normals[range], uvs, &local)
    };
    let corner = |triangle: usize, k: usize| {
        let v = triangles[triangle][k];
        let tangent = given.as_ref().map_or_else(|| computed[triangle][k], |list| list[own(v)]);
        Corner { uv: uvs[own(v)], normal: normals[v as usize], tangent }
    };
    Ok((0..triangles.len()).map(|t| [0, 1, 2].map(|k| corner(t, k))).collect())
}

/// The triangles of a part, among those of the rest.
pub(crate) fn triangles<'a>(rest: &'a Rest, part: &Part) -> &'a [[u32; 3]] {
    rest.triangles.get(part.first_triangle..part.first_triangle + part.triangle_count).unwrap_or_default()
}

/// What a part is called: its mesh, else its node, else its number.
pub(crate) fn mesh_name(gltf: &Gltf, part: &Part) -> String {
    let name = gltf.mesh_name(part.mesh).or_else(|| gltf.node_name(part.node));
    name.map_or_else(|| part.mesh.to_string(), str::to_owned)
}

/// The parts with triangles that the job asks for.
fn asked(job: &MapJob<'_>, scene: &Scene) -> Result<Vec<usize>, JobError> {
    let Scene { gltf, rest, .. } = scene;
    let nodes = job.node.map(|wanted| {
        let named: Vec<usize> =
            (0..gltf.node_count()).filter(|&node| gltf.node_name(node) == Some(wanted)).collect();
        (wanted, gltf.mesh_nodes(&named))
    });
    let shown = |part: &Part| nodes.as_ref().is_none_or(|(_, nodes)| nodes.contains(&part.node));
    let named = |part: &Part| part.material.and_then(|material| gltf.material_name(material));
    let solid = || rest.parts.iter().enumerate().filter(|(_, part)| part.triangle_count > 0);
    let out: Vec<usize> = solid()
        .filter(|(_, part)| shown(part) && job.material.is_none_or(|wanted| named(part) == Some(wanted)))
        .map(|(index, _)| index)
        .collect();
    if !out.is_empty() || (job.node.is_none() && job.material.is_none()) {
        return Ok(out);
    }
    let (kind, wanted, mut known): (_, _, Vec<&str>) = match &nodes {
        Some((wanted, nodes)) if nodes.is_empty() || job.material.is_none() => (
            "node with triangles",
            *wanted,
            solid().filter_map(|(_, part)| gltf.node_name(part.node)).collect(),
        ),
        _ => (
            "material",
            job.material.unwrap_or_default(),
            solid().filter_map(|(_, part)| named(part)).collect(),
        ),
    };
    known.sort_unstable();
    known.dedup();
    let shown: Vec<String> = known.iter().take(MOST_NAMES).map(|name| format!("{name:?}")).collect();
    let there = match (shown.len(), known.len() - shown.len()) {
        (0, _) => "none has a name".to_owned(),
        (_, 0) => format!("there are {}", shown.join(", ")),
        (_, more) => format!("there are {} and {more} more", shown.join(", ")),
    };
    Err(JobError::Request(format!("there is no {kind} called {wanted:?}; {there}")))
}

/// How many names a message lists.
const MOST_NAMES: usize = 8;
