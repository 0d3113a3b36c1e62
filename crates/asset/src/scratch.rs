//! New documents, for objects that come from no glTF file.

use serde_json::json;

use crate::content::Contents;
use crate::document::{Buffer, Gltf, Source};
use crate::error::AssetError;
use crate::image::media_type;
use crate::json::Json;
use crate::limits::Limits;
use crate::primitive::Mode;

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

/// A primitive of a new mesh: some of its vertices, joined in one way.
#[derive(Clone, Debug)]
pub struct NewPart {
    /// What they are joined to.
    pub mode: Mode,
    /// Indices of vertices of the mesh.
    pub indices: Vec<u32>,
    /// The material, an index that [`Gltf::append_look`] gave; none for the standard's own.
    pub material: Option<usize>,
}

/// A material of a new document.
#[derive(Clone, Copy, Debug, Default)]
pub struct NewLook<'a> {
    /// Its name.
    pub name: &'a str,
    /// Base colour, linear, and alpha, from 0 to 1. Default none: white, opaque.
    pub color: Option<[f32; 4]>,
    /// The picture of the base colour, an index that [`Gltf::append_image`] gave. Default none.
    pub image: Option<usize>,
    /// Whether the picture ends at its edges, and does not repeat. Default no.
    pub clamp: bool,
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
            spill: crate::store::Spill::default(),
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
            let flat = mesh.triangles.as_flattened();
            primitive["indices"] = json!(self.append_indices(flat, mesh.positions.len())?);
            primitive["material"] = json!(0);
        }
        let index = self.append("meshes", json!({ "name": mesh.name, "primitives": [primitive] }))?;
        self.append("nodes", json!({ "name": mesh.name, "mesh": index }))?;
        Ok(())
    }

    /// Cuts the one primitive of a new mesh into `parts`, which share its vertices.
    ///
    /// # Errors
    ///
    /// A mesh that is not there; an index of no vertex.
    pub fn cut(&mut self, mesh: usize, parts: &[NewPart]) -> Result<(), AssetError> {
        let Some(attributes) = self.primitives_mut(mesh)?.first().map(|first| first["attributes"].clone())
        else {
            return Err(AssetError::file("a mesh without primitives", "one primitive"));
        };
        let vertices = self.accessor(Json::root(&attributes["POSITION"]))?.count;
        let mut primitives = Vec::with_capacity(parts.len());
        for NewPart { mode, indices, material } in parts {
            if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices) {
                return Err(AssetError::file(format!("the index {index}"), "indices of vertices"));
            }
            let indices = self.append_indices(indices, vertices)?;
            let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": *mode as u8 });
            if let Some(material) = material {
                primitive["material"] = json!(material);
            }
            primitives.push(primitive);
        }
        *self.primitives_mut(mesh)? = primitives;
        Ok(())
    }

    /// Appends an image, the bytes of a file called `name`, and gives its index.
    pub fn append_image(&mut self, name: &str, bytes: Vec<u8>) -> Result<usize, AssetError> {
        let media = media_type(&bytes).unwrap_or("image/png");
        let view = self.append_view(bytes, None)?;
        self.append("images", json!({ "name": name, "bufferView": view, "mimeType": media }))
    }

    /// Appends a material, not metallic and seen from both sides, and gives its index.
    pub fn append_look(&mut self, look: &NewLook<'_>) -> Result<usize, AssetError> {
        let mut base = json!({ "metallicFactor": 0.0, "roughnessFactor": 0.8 });
        if let Some(color) = look.color {
            base["baseColorFactor"] = json!(color);
        }
        if let Some(image) = look.image {
            let wrap = if look.clamp { 33071 } else { 10497 };
            let sampler = self.append("samplers", json!({ "wrapS": wrap, "wrapT": wrap }))?;
            let texture = self.append("textures", json!({ "source": image, "sampler": sampler }))?;
            base["baseColorTexture"] = json!({ "index": texture });
        }
        let through = look.color.is_some_and(|[.., alpha]| alpha < 1.0);
        let mode = if through { "BLEND" } else { "OPAQUE" };
        let material = json!({ "name": look.name, "pbrMetallicRoughness": base, "alphaMode": mode, "doubleSided": true });
        self.append("materials", material)
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
