//! Where a result goes: the kinds of output, and the files of each.

use std::path::{Path, PathBuf};

use wirework_asset::{Format, Gltf, Limits, NewMesh, OutputFile, Rest};
use wirework_bake::CacheFormat;
use wirework_surface::{Mesh, VertexMesh};

use crate::JobError;
use crate::parts::cut;
use crate::pieces::renumber;
use crate::subject::Model;

/// This many `#` in a row stand for the number of a frame.
const MARKS: usize = 4;

/// What is written, as the name of the output says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// A glTF document in one of its two forms: an animation or a still.
    Gltf(Format),
    /// One OBJ file: a still.
    Obj,
    /// An OBJ file for each frame.
    ObjSequence(Pattern),
    /// Nothing but point caches and textures, which are written beside the others too.
    Aside,
}

/// The name of the files of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Target {
    /// What `path` asks for by its extension, `.glb`, `.gltf`, `.obj`, `.pc2` or `.mdd`, and for an OBJ by `####` in its name.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        if let Some(format) = Format::of(path) {
            return Some(Self::Gltf(format));
        }
        if CacheFormat::of(path).is_some() {
            return Some(Self::Aside);
        }
        let extension = path.extension()?.to_str()?;
        if !extension.eq_ignore_ascii_case("obj") {
            return None;
        }
        Some(Pattern::of(path).map_or(Self::Obj, Self::ObjSequence))
    }
}

impl Pattern {
    /// The last run of at least four `#` in the name of the file.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let end = name.rfind(&"#".repeat(MARKS))? + MARKS;
        let before = name.get(..end)?.trim_end_matches('#');
        Some(Self {
            folder: path.parent().map(Path::to_path_buf).unwrap_or_default(),
            before: before.to_owned(),
            digits: end - before.len(),
            after: name.get(end..)?.to_owned(),
        })
    }

    /// The file of a frame, its number padded with zeros.
    pub(crate) fn file(&self, frame: u32) -> PathBuf {
        let Self { folder, before, digits, after } = self;
        folder.join(format!("{before}{frame:0digits$}{after}"))
    }

    /// What is written of a frame; for a sequence the folder is made.
    pub(crate) fn output(&self, frame: u32, bytes: Vec<u8>) -> OutputFile {
        OutputFile { folders: true, ..OutputFile::new(self.file(frame), bytes) }
    }
}

/// A glTF scene, and for each of its vertices the point.
pub(crate) struct Scene {
    pub(crate) gltf: Gltf,
    pub(crate) rest: Rest,
    pub(crate) point_of: Vec<u32>,
    /// Of a mesh, for each vertex the position it is made of.
    pub(crate) source: Option<Vec<u32>>,
}

impl Scene {
    /// The scene of a model; a mesh gets a document of its own.
    pub(crate) fn new(model: Model, point_of: Vec<u32>, limits: &Limits) -> Result<Self, JobError> {
        let (parts, mesh) = match model {
            Model::Gltf { gltf, rest } => {
                return Ok(Self { gltf: *gltf, rest: *rest, point_of, source: None });
            }
            Model::Mesh { parts, mesh, .. } => (parts, mesh),
        };
        let mut source = Vec::new();
        let mut nodes = Vec::with_capacity(parts.len());
        for part in &parts {
            let mut vertices = if parts.len() == 1 {
                VertexMesh::new(&mesh)?
            } else {
                let (own, positions) = cut(&mesh, part);
                let mut vertices = VertexMesh::new(&own)?;
                renumber(&mut vertices.source, &positions);
                vertices
            };
            source.append(&mut vertices.source);
            // glTF counts v downwards.
            vertices.uvs.iter_mut().flatten().for_each(|uv| uv[1] = 1.0 - uv[1]);
            nodes.push((part.name.as_str(), vertices));
        }
        let meshes: Vec<NewMesh<'_>> =
            nodes.iter().map(|(name, vertices)| new_mesh(name, vertices)).collect();
        let name = parts.first().map_or("", |part| part.name.as_str());
        let gltf = Gltf::from_meshes_within(name, &meshes, limits)?;
        let rest = gltf.rest()?;
        let point_of =
            source.iter().map(|&i| point_of.get(i as usize).copied().unwrap_or_default()).collect();
        Ok(Self { gltf, rest, point_of, source: Some(source) })
    }
}

fn new_mesh<'a>(name: &'a str, vertices: &'a VertexMesh) -> NewMesh<'a> {
    let VertexMesh { positions, normals, uvs, triangles, .. } = vertices;
    let normals = (!normals.is_empty()).then_some(normals.as_slice());
    NewMesh { name, positions, normals, uvs: uvs.as_deref(), triangles }
}

/// The present state of a scene as one mesh. Normals are written if every vertex in a face has one.
pub(crate) fn scene_mesh(rest: &Rest, positions: &[[f32; 3]], normals: Option<&[[f32; 3]]>) -> Mesh {
    let bare = |part: &wirework_asset::Part| {
        part.triangle_count > 0 && rest.blocks.get(part.block).is_none_or(|block| block.normals.is_none())
    };
    rest.to_mesh(positions, normals.filter(|_| !rest.parts.iter().any(bare)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_is_written() {
        let of = |path: &str| Target::of(Path::new(path));
        assert_eq!(of("a/b.glb"), Some(Target::Gltf(Format::Glb)));
        assert_eq!(of("b.GLTF"), Some(Target::Gltf(Format::Gltf)));
        assert_eq!(of("b.obj"), Some(Target::Obj));
        assert_eq!(of("b##.obj"), Some(Target::Obj));
        assert_eq!((of("b.pc2"), of("b.MDD")), (Some(Target::Aside), Some(Target::Aside)));
        assert_eq!(of("b.fbx"), None);
        assert_eq!(of("obj"), None);
        let Some(Target::ObjSequence(pattern)) = of("a/x_####_######.y.obj") else { panic!() };
        assert_eq!(pattern.file(7), Path::new("a/x_####_000007.y.obj"));
        let Some(Target::ObjSequence(pattern)) = of("####.obj") else { panic!() };
        assert_eq!(pattern.file(123_456), Path::new("123456.obj"));
    }
}
