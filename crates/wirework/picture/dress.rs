//! An OBJ file in the colours of its materials and with its lines, for pictures.

use std::collections::BTreeMap;
use std::path::PathBuf;

use wirework_asset::{Gltf, Limits, Mode, NewLook, NewPart, Obj, ObjElements, ObjMaterial, printable};
use wirework_surface::{Mesh, VertexMesh};

use crate::JobError;
use crate::picture::setting::linear;

/// An OBJ file to be shown.
pub(crate) struct Dress {
    mesh: Mesh,
    obj: Obj,
    elements: ObjElements,
    library: BTreeMap<String, ObjMaterial>,
}

impl Dress {
    /// What there is to be shown of an OBJ file besides its faces; nothing where there is nothing.
    pub(crate) fn of(mesh: &Mesh, obj: &Obj, limits: &Limits, warnings: &mut Vec<String>) -> Option<Self> {
        let elements = obj.elements();
        let (library, doubts) = obj.materials(limits);
        let file = printable(obj.file());
        warnings.extend(doubts.iter().map(|doubt| format!("{file}: {doubt}")));
        let missing: Vec<&String> =
            elements.materials.iter().filter(|name| !library.contains_key(*name)).collect();
        if let (false, [first, ..]) = (library.is_empty(), missing.as_slice()) {
            let rest = match missing.len() - 1 {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let first = printable(first);
            warnings.push(format!("{file}: the material {first:?}{rest} is in no library [material]"));
        }
        let shown = missing.len() < elements.materials.len() || !elements.lines.is_empty();
        shown.then(|| Self { mesh: mesh.clone(), obj: obj.clone(), elements, library })
    }

    /// Cuts the one mesh of the document that was made of the file into its materials and lines. Gives the textures that were read.
    pub(crate) fn cut(
        &self,
        gltf: &mut Gltf,
        limits: &Limits,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<PathBuf>, JobError> {
        let vertices = VertexMesh::new(&self.mesh)?;
        let mut textures = Textures { dress: self, limits, images: BTreeMap::new(), warnings };
        let mut looks = BTreeMap::new();
        let mut look = |gltf: &mut Gltf, material: Option<u32>| -> Result<Option<usize>, JobError> {
            let name = material.and_then(|material| self.elements.materials.get(material as usize));
            let Some((name, own)) = name.and_then(|name| self.library.get_key_value(name)) else {
                return Ok(None);
            };
            if let Some(&known) = looks.get(name) {
                return Ok(Some(known));
            }
            let image = textures.image(gltf, name, own, vertices.uvs.is_some())?;
            let covers = |[r, g, b]: [f32; 3]| [linear(r), linear(g), linear(b), own.alpha];
            let color = own.color.or((own.alpha < 1.0).then_some([1.0; 3])).map(covers);
            let clamp = own.texture.as_ref().is_some_and(|texture| texture.clamp);
            let index = gltf.append_look(&NewLook { name, color, image, clamp })?;
            looks.insert(name, index);
            Ok(Some(index))
        };
        // Without a material of its own a face has the first of the document, which has no colour.
        let plain = (!vertices.triangles.is_empty()).then_some(0);
        let mut parts: BTreeMap<(u8, Option<usize>), NewPart> = BTreeMap::new();
        let mut add = |mode: Mode, material: Option<usize>, indices: &[u32]| {
            let part = || NewPart { mode, indices: Vec::new(), material };
            parts.entry((mode as u8, material)).or_insert_with(part).indices.extend_from_slice(indices);
        };
        let mut triangles = vertices.triangles.as_slice();
        for (face, &material) in self.mesh.faces().zip(&self.elements.of_faces) {
            let (own, rest) = triangles.split_at(face.len().saturating_sub(2).min(triangles.len()));
            triangles = rest;
            add(Mode::Triangles, look(gltf, material)?.or(plain), own.as_flattened());
        }
        let vertex = |position: u32| vertices.source.partition_point(|&source| source < position) as u32;
        for (material, line) in &self.elements.lines {
            let material = look(gltf, *material)?;
            for ends in line.windows(2) {
                add(Mode::Lines, material, &[vertex(ends[0]), vertex(ends[1])]);
            }
        }
        let files = textures.images.into_keys().map(|file| self.obj.beside(&file)).collect();
        gltf.cut(0, &parts.into_values().collect::<Vec<_>>())?;
        Ok(files)
    }
}

/// Textures, each file read once.
struct Textures<'a> {
    dress: &'a Dress,
    limits: &'a Limits,
    images: BTreeMap<PathBuf, Option<usize>>,
    warnings: &'a mut Vec<String>,
}

impl Textures<'_> {
    /// The image of a material, where it can be read and the file has coordinates for it.
    fn image(
        &mut self,
        gltf: &mut Gltf,
        name: &str,
        material: &ObjMaterial,
        mapped: bool,
    ) -> Result<Option<usize>, JobError> {
        let Some(texture) = &material.texture else { return Ok(None) };
        let file = printable(self.dress.obj.file());
        let name = printable(name);
        if !mapped {
            let message = "its texture needs texture coordinates, and there are none; it is left out";
            self.warnings.push(format!("{file}: the material {name:?}: {message} [texcoord]"));
            return Ok(None);
        }
        if let Some(&known) = self.images.get(&texture.file) {
            return Ok(known);
        }
        let image = match self.dress.obj.texture(texture, self.limits) {
            Ok(bytes) => Some(gltf.append_image(&texture.file.display().to_string(), bytes)?),
            Err(error) => {
                let found = format!("found {}, expected {}", printable(&error.found), error.expected);
                self.warnings.push(format!("{file}: the material {name:?}: {found}; it is left out [image]"));
                None
            }
        };
        self.images.insert(texture.file.clone(), image);
        Ok(image)
    }
}
