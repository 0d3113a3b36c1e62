//! `mask`: a channel of the vertex colours, or of an image at the texture coordinates.

use std::collections::BTreeSet;
use std::path::Path;

use wirework_asset::{Limits, printable};
use wirework_preset::{Channel, Mask, Named, PresetError, PresetErrorKind};
use wirework_surface::Mesh;

use super::plane::Plane;
use super::{Lack, refused};
use crate::error::count;
use crate::{JobError, Model, Subject};

/// The factor of each point: the mean of its vertices, 1 where none of them has a colour or a texture coordinate.
///
/// The numbers are those of the file: no colour space is undone. Where an OBJ file or a preset's own object has several texture
/// coordinates at a position, each counts once.
pub(super) fn factors(
    mask: &Mask,
    subject: &Subject,
    preset_dir: &Path,
    limits: &Limits,
    warnings: &mut Vec<String>,
) -> Result<Vec<f32>, Lack> {
    let mut means = Means { sums: vec![(0.0, 0); subject.points.len()] };
    // Control points of a patch are no vertices: they have neither.
    let has_vertices = subject.net.is_none();
    let (what, at) = match mask {
        Mask::VertexColor { channel, typed } => {
            if !(has_vertices && means.colors(subject, *channel)?) {
                let message = "`mask: VertexColor(..)` needs vertex colours; the object has none";
                return Err(Lack::Missing(vec![typed.refused(message)]));
            }
            ("vertex colours", "VertexColor".to_owned())
        }
        Mask::Image { file, channel } => {
            let plane = Plane::read(&preset_dir.join(&file.name), *channel, limits);
            let plane = plane.map_err(|refusal| refused(unusable(file, &refusal.message, refusal.limit)))?;
            if !(has_vertices && means.image(subject, &plane)) {
                let message = "the object has no texture coordinates, at which the image would be read";
                return Err(Lack::Missing(vec![file.refused(message)]));
            }
            ("texture coordinates", format!("Image(\"{}\")", printable(&file.name)))
        }
    };
    let bare = means.sums.iter().filter(|(_, n)| *n == 0).count();
    if bare > 0 {
        warnings.push(format!(
            "`mask: {at}`: {} without {what}; there it is 1 [mask-part]",
            count(bare, "point")
        ));
    }
    Ok(means.finish())
}

/// Whether the image of a mask can be read, whatever object it is for.
pub(super) fn check(mask: &Mask, preset_dir: &Path, limits: &Limits) -> Result<(), JobError> {
    let Mask::Image { file, channel } = mask else { return Ok(()) };
    let plane = Plane::read(&preset_dir.join(&file.name), *channel, limits);
    plane.map(drop).map_err(|refusal| refused(unusable(file, &refusal.message, refusal.limit)))
}

fn unusable(file: &Named, message: &str, limit: bool) -> PresetError {
    let error = file.refused(format!("the image \"{}\" {message}", printable(&file.name)));
    if limit { PresetError { kind: PresetErrorKind::Limit, ..error } } else { error }
}

/// Sums at points, and how many numbers they are of.
struct Means {
    sums: Vec<(f64, u32)>,
}

impl Means {
    fn add(&mut self, point: Option<&u32>, value: f32) {
        if let Some((sum, n)) = point.and_then(|&point| self.sums.get_mut(point as usize)) {
            *sum += f64::from(value);
            *n += 1;
        }
    }

    fn finish(self) -> Vec<f32> {
        let mean = |(sum, n)| if n == 0 { 1.0 } else { (sum / f64::from(n)) as f32 };
        self.sums.into_iter().map(mean).collect()
    }

    /// Adds the colours of all vertices; false where there are none.
    fn colors(&mut self, subject: &Subject, channel: Channel) -> Result<bool, JobError> {
        let channel = channel as usize;
        let mut any = false;
        match &subject.model {
            Model::Gltf { gltf, rest } => {
                for (block, colors) in rest.blocks.iter().zip(gltf.colors(rest)?) {
                    let vertices = subject.point_of.get(block.first..).unwrap_or(&[]);
                    for (point, color) in vertices.iter().zip(colors.into_iter().flatten()) {
                        self.add(Some(point), color[channel]);
                        any = true;
                    }
                }
            }
            Model::Mesh { obj: Some(obj), .. } => {
                let colors = obj.colors()?.unwrap_or_default();
                for (point, color) in subject.point_of.iter().zip(colors) {
                    if let Some(color) = color {
                        self.add(Some(point), color[channel]);
                        any = true;
                    }
                }
            }
            Model::Mesh { obj: None, .. } => {}
        }
        Ok(any)
    }

    /// Adds what an image has at the texture coordinates of all vertices; false where there are none.
    fn image(&mut self, subject: &Subject, plane: &Plane) -> bool {
        let mut any = false;
        match &subject.model {
            Model::Gltf { rest, .. } => {
                for block in &rest.blocks {
                    let vertices = subject.point_of.get(block.first..).unwrap_or(&[]);
                    for (point, uv) in vertices.iter().zip(block.uvs.iter().flatten()) {
                        self.add(Some(point), plane.at(uv[0], uv[1]));
                        any = true;
                    }
                }
            }
            Model::Mesh { mesh, .. } => {
                for (position, uv) in mapped(mesh) {
                    if let Some(uv) = mesh.uvs.get(uv as usize) {
                        // Meshes count `v` upwards, images rows downwards.
                        self.add(subject.point_of.get(position as usize), plane.at(uv[0], 1.0 - uv[1]));
                        any = true;
                    }
                }
            }
        }
        any
    }
}

/// The positions of a mesh with each of their texture coordinates once.
fn mapped(mesh: &Mesh) -> BTreeSet<(u32, u32)> {
    mesh.corners.iter().filter_map(|corner| Some((corner.position, corner.uv?))).collect()
}
