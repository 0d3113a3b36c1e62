//! New documents, for objects that come from no glTF file.

use serde_json::json;

use crate::content::Contents;
use crate::document::{Buffer, Gltf, Source};
use crate::error::AssetError;
use crate::limits::Limits;

/// A mesh for a new document, as a renderer has it: one entry a vertex.
#[derive(Clone, Copy, Debug)]
pub struct NewMesh<'a> {
    /// The name of its node and its mesh.
    pub name: &'a str,
    /// Positions; at least one, all finite.
    pub positions: &'a [[f32; 3]],
    /// Unit normals, as many as positions.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Texture coordinates as glTF has them, `v` downwards, as many as positions.
    pub uvs: Option<&'a [[f32; 2]]>,
    /// Indices into the positions, counter-clockwise seen from outside; without any the mesh is a set of points.
    pub triangles: &'a [[u32; 3]],
}

impl Gltf {
    /// A document with one node and one mesh for each of `meshes`, in their order, the vertices in theirs.
    ///
    /// `name` stands for the document in messages.
    ///
    /// # Errors
    ///
    /// A mesh without vertices, lists of unequal length, numbers that are not finite, indices out of range, more than
    /// the default [`Limits`] allow.
    pub fn from_meshes(name: &str, meshes: &[NewMesh<'_>]) -> Result<Self, AssetError> {
        Self::from_meshes_within(name, meshes, &Limits::default())
    }

    /// [`Gltf::from_meshes`] with limits of the caller's, which the document keeps.
    ///
    /// # Errors
    ///
    /// Those of [`Gltf::from_meshes`], with `limits` in place of the default ones.
    pub fn from_meshes_within(
        name: &str,
        meshes: &[NewMesh<'_>],
        limits: &Limits,
    ) -> Result<Self, AssetError> {
        let (mut vertices, mut indices) = (0_u64, 0_u64);
        for mesh in meshes {
            vertices = vertices.saturating_add(mesh.positions.len() as u64);
            indices = indices.saturating_add(mesh.triangles.as_flattened().len() as u64);
        }
        limits.check_mesh(vertices, indices).map_err(|error| error.in_file(name))?;
        let generator = concat!("wirework ", env!("CARGO_PKG_VERSION"));
        let mut gltf = Self {
            undecoded: std::collections::BTreeMap::new(),
            file: name.to_owned(),
            folder: None,
            json: json!({
                "asset": { "version": "2.0", "generator": generator },
                "scene": 0,
                "scenes": [{ "nodes": (0..meshes.len()).collect::<Vec<_>>() }],
                "nodes": [],
                "meshes": [],
            }),
            binary: true,
            buffers: Vec::new(),
            orphan: None,
            chunks: Vec::new(),
            // What is read back was in memory before: it expands to nothing that was not asked for.
            limits: Limits { expanded_bytes: u64::MAX, ..*limits },
            warnings: Vec::new(),
            growing: None,
            written: crate::delta::Written::default(),
        };
        if meshes.iter().any(|mesh| !mesh.triangles.is_empty()) {
            // Not metallic, which is what a glTF material is without these lines, and seen from both sides, for
            // grids and garments have borders.
            let material = json!({
                "name": "plain",
                "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.8 },
                "doubleSided": true,
            });
            gltf.append("materials", material)?;
        }
        gltf.json["buffers"] = json!([{ "byteLength": 0 }]);
        gltf.buffers.push(Buffer { bytes: Contents::default(), length: 0, source: Source::Bin });
        for mesh in meshes {
            gltf.append_mesh(mesh).map_err(|error| error.in_file(name))?;
        }
        Ok(gltf)
    }

    fn append_mesh(&mut self, mesh: &NewMesh<'_>) -> Result<(), AssetError> {
        check(mesh)?;
        let mut attributes = json!({ "POSITION": self.append_vertices(copied(mesh.positions)?, true)? });
        if let Some(normals) = mesh.normals {
            attributes["NORMAL"] = json!(self.append_vertices(copied(normals)?, false)?);
        }
        if let Some(uvs) = mesh.uvs {
            attributes["TEXCOORD_0"] = json!(self.append_vertices(copied(uvs)?, false)?);
        }
        let mut primitive = json!({ "attributes": attributes });
        if mesh.triangles.is_empty() {
            primitive["mode"] = json!(0);
        } else {
            primitive["indices"] = json!(self.append_triangles(mesh.triangles, mesh.positions.len())?);
            primitive["material"] = json!(0);
        }
        let index = self.append("meshes", json!({ "name": mesh.name, "primitives": [primitive] }))?;
        self.append("nodes", json!({ "name": mesh.name, "mesh": index }))?;
        Ok(())
    }
}

/// A copy, or a limit error where memory does not suffice.
fn copied<T: Copy>(values: &[T]) -> Result<Vec<T>, AssetError> {
    let mut out = crate::limits::reserve(values.len())?;
    out.extend_from_slice(values);
    Ok(out)
}

fn check(mesh: &NewMesh<'_>) -> Result<(), AssetError> {
    let count = mesh.positions.len();
    let fault = |found: String, expected: &str| {
        Err(AssetError::file(format!("{found} in the mesh {:?}", mesh.name), expected))
    };
    if count == 0 || count > u32::MAX as usize {
        return fault(format!("{count} vertices"), "1 to 4 294 967 295");
    }
    for (what, length) in [("normals", mesh.normals.map(<[_]>::len)), ("uvs", mesh.uvs.map(<[_]>::len))] {
        if length.is_some_and(|length| length != count) {
            return fault(format!("{} {what} for {count} vertices", length.unwrap_or(0)), "as many");
        }
    }
    let vectors = mesh.positions.iter().chain(mesh.normals.unwrap_or(&[]));
    let numbers = vectors.flatten().chain(mesh.uvs.unwrap_or(&[]).as_flattened());
    if numbers.into_iter().any(|c| !c.is_finite()) {
        return fault("a number that is not finite".to_owned(), "finite numbers");
    }
    if let Some(index) = mesh.triangles.as_flattened().iter().find(|&&index| index as usize >= count) {
        return fault(format!("the index {index}"), "indices of vertices");
    }
    Ok(())
}
