//! What is in a picture, as plain data.

use std::sync::Arc;

use glam::DVec3;
use wirework_surface::{Bounds, Mesh, MeshError, VertexMesh};

use crate::enclose::winding;
use crate::{RenderError, Texture, Wrap};

/// The colour of things that have none, linear: warm grey clay, on which relief reads well.
pub const CLAY: [f32; 3] = [0.52, 0.415, 0.345];

/// The winding number about a point inside: less than 1 by what rounding and a pinhole or two make of it. A tube ten radii deep
/// has 0.995 in its middle, and one can look out of it.
const CLOSED: f64 = 0.999;

/// Surfaces, lines and points.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The surfaces.
    pub parts: Vec<Part>,
    /// Curves drawn over them, later ones on top.
    pub lines: Vec<Line>,
    /// Points drawn over both, later ones on top.
    pub dots: Vec<Dots>,
    /// The height (y, metres) of a ground that catches shadows and is otherwise the background; `None`: no ground. It is
    /// not seen from below. Give it once for an animation, so that it does not move with the object.
    pub ground: Option<f32>,
}

impl Scene {
    /// The box round all finite positions of parts, lines and dots; `None` without any.
    pub fn bounds(&self) -> Option<Bounds> {
        let parts = self.parts.iter().map(|p| p.positions.as_slice());
        let lines = self.lines.iter().map(|l| l.points.as_slice());
        let dots = self.dots.iter().map(|d| d.points.as_slice());
        let mut corners = Vec::new();
        for bounds in parts.chain(lines).chain(dots).filter_map(Bounds::of) {
            corners.extend([bounds.min, bounds.max]);
        }
        Bounds::of(&corners)
    }

    /// Whether a point (metres) lies inside the surfaces, by their winding number: faces that turn outwards are in the way
    /// whichever way one looks, but for a thousandth of all directions. A room whose walls face inwards does not
    /// enclose it, nor does a sheet, nor a tube out of which one can look.
    pub fn encloses(&self, point: [f32; 3]) -> bool {
        let point = DVec3::from(point.map(f64::from));
        self.parts.iter().map(|part| winding(part, point)).sum::<f64>() > CLOSED
    }
}

/// A surface of triangles, seen from both sides.
///
/// Default: nothing, of clay.
#[derive(Clone, Debug)]
pub struct Part {
    /// Vertex positions, metres.
    pub positions: Vec<[f32; 3]>,
    /// Normals, one a vertex, of any length; empty for flat faces. Where one is zero or not finite the face's own is
    /// taken.
    pub normals: Vec<[f32; 3]>,
    /// Vertices of each triangle. Triangles without area are not seen.
    pub triangles: Vec<[u32; 3]>,
    /// Base colour, linear, each component from 0 to 1; multiplies the texture.
    pub color: [f32; 3],
    /// Linear colours, one a vertex, that multiply the base colour; empty for none.
    pub colors: Vec<[f32; 3]>,
    /// Texture coordinates, one a vertex, `v` pointing down as in glTF; empty without texture.
    pub uvs: Vec<[f32; 2]>,
    /// The base colour's picture.
    pub texture: Option<Arc<Texture>>,
    /// What is beyond its edges, across and down. Default: the picture again.
    pub wrap: [Wrap; 2],
    /// Where the texture's alpha is below this, 0 to 1, there is no surface. For glTF's `MASK` that is its cutoff divided by
    /// the base colour's alpha. Default: `None`, there is surface everywhere.
    pub cutoff: Option<f32>,
}

impl Default for Part {
    fn default() -> Self {
        Self {
            positions: vec![],
            normals: vec![],
            triangles: vec![],
            color: CLAY,
            colors: vec![],
            uvs: vec![],
            texture: None,
            wrap: [Wrap::Repeat; 2],
            cutoff: None,
        }
    }
}

impl Part {
    /// Whether there may be holes in it.
    pub(crate) fn has_holes(&self) -> bool {
        self.cutoff.is_some() && self.texture.is_some() && !self.uvs.is_empty()
    }

    /// A part of clay with smooth normals (hard edges where the mesh has them).
    pub fn new(mesh: &Mesh) -> Result<Self, MeshError> {
        let VertexMesh { positions, normals, uvs, triangles, .. } = VertexMesh::new(mesh)?;
        let uvs = uvs.unwrap_or_default().into_iter().map(|[u, v]| [u, 1.0 - v]).collect();
        let normals = if triangles.is_empty() { vec![] } else { normals };
        Ok(Self { positions, normals, triangles, uvs, ..Self::default() })
    }
}

/// A polyline of constant width on the screen. Where a surface hides it, it is dimmed.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its points, metres; one point is a disc.
    pub points: Vec<[f32; 3]>,
    /// Linear colour; [`LineKind::color`] has one for each kind.
    pub color: [f32; 3],
    /// Width in pixels.
    pub width: f32,
    /// What it shows, for a legend.
    pub kind: LineKind,
}

/// Discs of constant size on the screen. Where a surface hides one, it is dimmed.
#[derive(Clone, Debug)]
pub struct Dots {
    /// Their centres, metres.
    pub points: Vec<[f32; 3]>,
    /// Linear colour.
    pub color: [f32; 3],
    /// Diameter in pixels.
    pub width: f32,
    /// What they show, for a legend.
    pub kind: LineKind,
}

/// What a line or dot stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum LineKind {
    /// A wire curve W.
    Wire,
    /// A reference curve R.
    Reference,
    /// A domain curve.
    Domain,
    /// A locator on a curve.
    Locator,
    /// The control grid of a free-form lattice; thin lines.
    Lattice,
    /// A seam of pieces.
    Seam,
    /// A point of an object.
    Point,
}

impl LineKind {
    /// The legend's colour, linear. They differ in lightness as well as in hue, by a tenth of the way from black to white
    /// and more, so that whoever sees fewer hues, or a print in grey, can tell them apart.
    pub fn color(self) -> [f32; 3] {
        match self {
            Self::Wire => [0.84, 0.06, 0.015],
            Self::Reference => [0.012, 0.115, 0.50],
            Self::Domain => [0.04, 0.46, 0.20],
            Self::Locator => [0.97, 0.66, 0.04],
            Self::Lattice => [0.93, 0.93, 0.93],
            Self::Seam => [0.20, 0.008, 0.16],
            Self::Point => [0.012, 0.012, 0.014],
        }
    }

    /// Whether it is shown by discs.
    pub(crate) fn is_dot(self) -> bool {
        matches!(self, Self::Locator | Self::Point)
    }

    /// The legend's word.
    pub fn label(self) -> &'static str {
        match self {
            Self::Wire => "wire",
            Self::Reference => "reference",
            Self::Domain => "domain curve",
            Self::Locator => "locator",
            Self::Lattice => "lattice",
            Self::Seam => "seam",
            Self::Point => "point",
        }
    }
}

/// Refuses what [`RenderError`] names: lists of the wrong length, indices out of range, numbers that are not finite.
pub(crate) fn check(scene: &Scene) -> Result<(), RenderError> {
    let (mut triangles, mut vertices) = (0usize, 0usize);
    for (number, part) in scene.parts.iter().enumerate() {
        check_part(number, part)?;
        triangles = triangles.saturating_add(part.triangles.len());
        vertices = vertices.saturating_add(part.positions.len());
    }
    // The last numbers stand for the ground and for nothing.
    if triangles.max(vertices) >= (u32::MAX - 1) as usize {
        return Err(RenderError::TooMany);
    }
    for (number, line) in scene.lines.iter().enumerate() {
        finite("line", number, "position", &line.points)?;
        finite("line", number, "colour component", &[line.color, [line.width; 3]])?;
    }
    for (number, dots) in scene.dots.iter().enumerate() {
        finite("dots", number, "position", &dots.points)?;
        finite("dots", number, "colour component", &[dots.color, [dots.width; 3]])?;
    }
    if scene.ground.is_some_and(|y| !y.is_finite()) {
        return Err(RenderError::NotFinite { owner: "ground", number: 0, what: "height", index: 0 });
    }
    Ok(())
}

fn check_part(number: usize, part: &Part) -> Result<(), RenderError> {
    let positions = part.positions.len();
    let lists = [
        ("normals", part.normals.len()),
        ("texture coordinates", part.uvs.len()),
        ("colours", part.colors.len()),
    ];
    for (what, count) in lists {
        if count != 0 && count != positions {
            return Err(RenderError::Count { part: number, what, count, positions });
        }
    }
    finite("part", number, "position", &part.positions)?;
    finite("part", number, "texture coordinate", &part.uvs)?;
    finite("part", number, "colour component", &part.color.map(|c| [c]))?;
    finite("part", number, "vertex colour", &part.colors)?;
    finite("part", number, "cutoff", &[[part.cutoff.unwrap_or(0.0)]])?;
    for (triangle, corners) in part.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= positions) {
            return Err(RenderError::Index { part: number, triangle, vertex, positions });
        }
    }
    Ok(())
}

fn finite<const N: usize>(
    owner: &'static str,
    number: usize,
    what: &'static str,
    values: &[[f32; N]],
) -> Result<(), RenderError> {
    match values.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
        Some(index) => Err(RenderError::NotFinite { owner, number, what, index }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_lines_differ_in_lightness() {
        let kinds = [
            LineKind::Wire,
            LineKind::Reference,
            LineKind::Domain,
            LineKind::Locator,
            LineKind::Lattice,
            LineKind::Seam,
            LineKind::Point,
        ];
        // CIE L*, from 0 to 100.
        let lightness = |kind: LineKind| {
            let [r, g, b] = kind.color();
            116.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt() - 16.0
        };
        let mut all: Vec<f32> = kinds.into_iter().map(lightness).collect();
        all.sort_by(f32::total_cmp);
        assert!(all.windows(2).all(|l| l[1] - l[0] > 10.0), "{all:?}");
    }
}
