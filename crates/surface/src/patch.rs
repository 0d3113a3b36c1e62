//! \[SF98\] §2: tensor-product B-spline patches, one of the objects wires deform.
//!
//! A [`Patch`] is its control net. A [`Tessellation`] holds the basis functions at the vertices of a mesh of it,
//! so that a net that moves gives new positions and normals without being set up again: either the evaluated
//! points are deformed, or the control points are and the surface is evaluated from them.

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::primitives::MAX_VERTICES;
use crate::vector::{narrow, wide};
use crate::{Corner, Mesh};

/// A non-rational tensor-product B-spline surface with clamped uniform knots; `u, v ∈ [0, 1]`.
///
/// Made by [`Patch::new`], so that there are at least two rows and two columns of finite control points.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    degree: [u8; 2],
    size: [usize; 2],
    points: Vec<[f32; 3]>,
}

/// Why control points do not make a patch or a mesh of it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PatchError {
    /// A degree is not 1, 2 or 3.
    #[error("the degree of a patch is 1, 2 or 3 along u and v, not {degree}")]
    Degree {
        /// The degree that was asked for.
        degree: u8,
    },
    /// There are fewer than two points along `u` or `v`.
    #[error("a patch needs two control points or more along {along}, not {found}")]
    TooFew {
        /// `'u'` (rows) or `'v'` (points of a row).
        along: char,
        /// How many there are.
        found: usize,
    },
    /// A row has another length than the first.
    #[error("row {row} of the control points has {found} points, the first {expected}")]
    Ragged {
        /// Which row, from 0.
        row: usize,
        /// The length of the first row.
        expected: usize,
        /// The length of this row.
        found: usize,
    },
    /// A control point is NaN or infinite.
    #[error("control point {column} of row {row} is not finite")]
    NotFinite {
        /// Its row, `i`.
        row: usize,
        /// Its place in the row, `j`.
        column: usize,
    },
    /// A mesh needs one cell or more each way, and at most [`MAX_VERTICES`] vertices.
    #[error("a tessellation of {} by {} cells has no cells or too many", cells[0], cells[1])]
    Cells {
        /// What was asked for.
        cells: [u32; 2],
    },
    /// A net has another number of control points than the patch it stands for, or a buffer of vertices.
    #[error("the patch has {expected} points, the list {found}")]
    NetSize {
        /// Control points or vertices of the patch.
        expected: usize,
        /// Points of the list.
        found: usize,
    },
}

impl Patch {
    /// A patch of `degree` (along `u`, along `v`), each 1 to 3, with control points `rows[i][j]`, `i` along `u` and `j`
    /// along `v`. With too few points a degree drops to one less than the points, as for curves.
    pub fn new(degree: [u8; 2], rows: &[Vec<[f32; 3]>]) -> Result<Self, PatchError> {
        if let Some(&degree) = degree.iter().find(|d| !(1..=3).contains(*d)) {
            return Err(PatchError::Degree { degree });
        }
        let expected = rows.first().map_or(0, Vec::len);
        for (along, found) in [('u', rows.len()), ('v', expected)] {
            if found < 2 {
                return Err(PatchError::TooFew { along, found });
            }
        }
        for (row, points) in rows.iter().enumerate() {
            if points.len() != expected {
                return Err(PatchError::Ragged { row, expected, found: points.len() });
            }
            if let Some(column) = points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
                return Err(PatchError::NotFinite { row, column });
            }
        }
        let size = [rows.len(), expected];
        let degree = [0, 1].map(|a| degree[a].min(u8::try_from(size[a] - 1).unwrap_or(u8::MAX)));
        Ok(Self { degree, size, points: rows.concat() })
    }

    /// The control net, row after row: point `(i, j)` is number `i · size[1] + j`.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// Rows, and points in a row.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The degrees in use, after dropping.
    pub fn degree(&self) -> [u8; 2] {
        self.degree
    }

    /// The point at `(u, v)`, each clamped to `[0, 1]`.
    pub fn point(&self, u: f64, v: f64) -> [f32; 3] {
        let (a, b) = (Basis::at(self.degree[0], self.size[0], u), Basis::at(self.degree[1], self.size[1], v));
        narrow(evaluate(&self.points, self.size[1], &a, &b)[0])
    }

    /// The unit normal `∂u × ∂v` at `(u, v)`. Where it vanishes (a side drawn together to a point), the one a
    /// little towards the middle; on a patch without area `+Y`.
    pub fn normal(&self, u: f64, v: f64) -> [f32; 3] {
        let (a, b) = (Basis::at(self.degree[0], self.size[0], u), Basis::at(self.degree[1], self.size[1], v));
        let [_, du, dv] = evaluate(&self.points, self.size[1], &a, &b);
        narrow(unit(du, dv).unwrap_or_else(|| self.inner_normal(&self.points, u, v)))
    }

    /// Steps towards the middle until there is a normal.
    fn inner_normal(&self, net: &[[f32; 3]], u: f64, v: f64) -> DVec3 {
        // Near a collapsed side the cross product is in proportion to the step: 1e-3 stands well clear of rounding.
        [1e-3, 1e-2, 1e-1]
            .iter()
            .find_map(|step| {
                let inwards = |x: f64| x + (0.5 - x) * step;
                let a = Basis::at(self.degree[0], self.size[0], inwards(u));
                let b = Basis::at(self.degree[1], self.size[1], inwards(v));
                let [_, du, dv] = evaluate(net, self.size[1], &a, &b);
                unit(du, dv)
            })
            .unwrap_or(DVec3::Y)
    }

    /// The vertices of a mesh of `cells` quads along `u` and `v`, ready to be evaluated.
    pub fn tessellation(&self, cells: [u32; 2]) -> Result<Tessellation<'_>, PatchError> {
        let vertices = cells.iter().fold(1_u64, |n, &c| n.saturating_mul(u64::from(c) + 1));
        if cells.contains(&0) || vertices > MAX_VERTICES {
            return Err(PatchError::Cells { cells });
        }
        let bases = [0, 1].map(|a| {
            let at = |i: u32| Basis::at(self.degree[a], self.size[a], f64::from(i) / f64::from(cells[a]));
            (0..=cells[a]).map(at).collect()
        });
        Ok(Tessellation { patch: self, cells, bases })
    }

    /// The control net as a mesh: a vertex a control point, in their order, and a quad between each four, facing as the patch
    /// does. Without normals and texture coordinates.
    pub fn net(&self) -> Mesh {
        let mut mesh = Mesh { positions: self.points.clone(), ..Mesh::default() };
        let corner = |p: u32| Corner { position: p, uv: None, normal: None };
        quads(&mut mesh, self.size.map(|n| n as u32 - 1), corner);
        mesh
    }

    /// The same patch on other control points, as many as it has and finite.
    pub fn with_points(&self, points: Vec<[f32; 3]>) -> Result<Self, PatchError> {
        let (expected, found) = (self.points.len(), points.len());
        if expected != found {
            return Err(PatchError::NetSize { expected, found });
        }
        if let Some(bad) = points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            return Err(PatchError::NotFinite { row: bad / self.size[1], column: bad % self.size[1] });
        }
        Ok(Self { points, ..*self })
    }

    /// The mesh of [`Patch::tessellation`] of the patch's own net: `(cells[0] + 1)(cells[1] + 1)` vertices.
    pub fn tessellate(&self, cells: [u32; 2]) -> Result<Mesh, PatchError> {
        self.tessellation(cells)?.mesh(&self.points)
    }
}

/// A patch's basis functions at the vertices of a mesh.
///
/// Vertex `i · (cells[1] + 1) + j` is the one at `u = i / cells[0]`, `v = j / cells[1]`, the order of the control
/// points. Texture coordinates are `(u, v)`; normals are smooth, one a vertex.
#[derive(Clone, Debug)]
pub struct Tessellation<'a> {
    patch: &'a Patch,
    cells: [u32; 2],
    bases: [Vec<Basis>; 2],
}

impl Tessellation<'_> {
    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.bases[0].len() * self.bases[1].len()
    }

    /// The positions and unit normals of the vertices for a net of as many points as [`Patch::points`], in that order.
    /// The buffers are refilled.
    pub fn evaluate_into(
        &self,
        net: &[[f32; 3]],
        positions: &mut Vec<[f32; 3]>,
        normals: &mut Vec<[f32; 3]>,
    ) -> Result<(), PatchError> {
        let (expected, found) = (self.patch.points.len(), net.len());
        if expected != found {
            return Err(PatchError::NetSize { expected, found });
        }
        positions.clear();
        normals.clear();
        for (i, a) in self.bases[0].iter().enumerate() {
            for (j, b) in self.bases[1].iter().enumerate() {
                let [p, du, dv] = evaluate(net, self.patch.size[1], a, b);
                let normal = unit(du, dv).unwrap_or_else(|| {
                    let (u, v) = (i as f64 / f64::from(self.cells[0]), j as f64 / f64::from(self.cells[1]));
                    self.patch.inner_normal(net, u, v)
                });
                positions.push(narrow(p));
                normals.push(narrow(normal));
            }
        }
        Ok(())
    }

    /// The positions alone, into a buffer of as many points as there are vertices; the same bits as
    /// [`Tessellation::evaluate_into`] gives. A vertex none of whose control points has moved keeps its own. Uses rayon's current
    /// pool; the result does not depend on its size.
    pub fn positions_into(&self, net: &[[f32; 3]], out: &mut [[f32; 3]]) -> Result<(), PatchError> {
        for (expected, found) in [(self.patch.points.len(), net.len()), (self.vertices(), out.len())] {
            if expected != found {
                return Err(PatchError::NetSize { expected, found });
            }
        }
        let [across, along] = &self.bases;
        out.par_chunks_mut(along.len()).zip(across).for_each(|(row, a)| {
            for (slot, b) in row.iter_mut().zip(along) {
                *slot = narrow(evaluate(net, self.patch.size[1], a, b)[0]);
            }
        });
        Ok(())
    }

    /// The mesh for a net.
    pub fn mesh(&self, net: &[[f32; 3]]) -> Result<Mesh, PatchError> {
        let mut mesh = Mesh::default();
        self.evaluate_into(net, &mut mesh.positions, &mut mesh.normals)?;
        let [nu, nv] = self.cells;
        for i in 0..=nu {
            for j in 0..=nv {
                mesh.uvs.push([(f64::from(i) / f64::from(nu)) as f32, (f64::from(j) / f64::from(nv)) as f32]);
            }
        }
        quads(&mut mesh, self.cells, |p| Corner { position: p, uv: Some(p), normal: Some(p) });
        Ok(mesh)
    }
}

/// Adds the faces of `nu · nv` quads on rows of vertices, facing `∂u × ∂v`.
fn quads(mesh: &mut Mesh, [nu, nv]: [u32; 2], corner: impl Fn(u32) -> Corner) {
    for i in 0..nu {
        for j in 0..nv {
            let a = i * (nv + 1) + j;
            mesh.corners.extend([a, a + nv + 1, a + nv + 2, a + 1].map(&corner));
            mesh.face_ends.push(mesh.corners.len() as u32);
        }
    }
}

/// The basis functions that are not zero at one parameter, and their derivatives.
#[derive(Clone, Debug)]
struct Basis {
    first: usize,
    count: usize,
    value: [f64; 4],
    slope: [f64; 4],
}

impl Basis {
    /// Cox and de Boor's recurrence on the knots `0 … 0 1 2 … s … s`, `s` the number of spans. At 0 and 1 exactly one
    /// value is 1 and the others are 0, so that equal control points at an edge give equal bits.
    fn at(degree: u8, points: usize, u: f64) -> Self {
        let p = usize::from(degree);
        let spans = points - p;
        let x = u.clamp(0.0, 1.0) * spans as f64;
        let span = (x as usize).min(spans - 1);
        let knot = |i: usize| i.saturating_sub(p).min(spans) as f64;
        let mut value = [1.0, 0.0, 0.0, 0.0];
        let mut lower = value;
        for d in 1..=p {
            lower = value;
            let mut carry = 0.0;
            for (r, low) in lower.iter().enumerate().take(d) {
                // Knots round the span: span + p is the index of its left end.
                let (left, right) = (knot(span + p + 1 + r - d), knot(span + p + 1 + r));
                let part = low / (right - left);
                value[r] = carry + (right - x) * part;
                carry = (x - left) * part;
            }
            value[d] = carry;
        }
        let mut slope = [0.0; 4];
        for r in 0..p {
            let (left, right) = (knot(span + 1 + r), knot(span + p + 1 + r));
            let part = lower[r] * p as f64 * spans as f64 / (right - left);
            slope[r] -= part;
            slope[r + 1] += part;
        }
        Self { first: span, count: p + 1, value, slope }
    }
}

/// The point, `∂u` and `∂v`.
fn evaluate(net: &[[f32; 3]], row: usize, a: &Basis, b: &Basis) -> [DVec3; 3] {
    let mut sums = [DVec3::ZERO; 3];
    for i in 0..a.count {
        let start = (a.first + i) * row + b.first;
        let Some(points) = net.get(start..start + b.count) else { continue };
        let (mut value, mut slope) = (DVec3::ZERO, DVec3::ZERO);
        for (j, &p) in points.iter().enumerate() {
            value += wide(p) * b.value[j];
            slope += wide(p) * b.slope[j];
        }
        sums[0] += value * a.value[i];
        sums[1] += value * a.slope[i];
        sums[2] += slope * a.value[i];
    }
    sums
}

/// `∂u × ∂v` of length 1; `None` where it vanishes against the lengths of both.
fn unit(du: DVec3, dv: DVec3) -> Option<DVec3> {
    // Parallel up to the rounding of control points to f32.
    const PARALLEL: f64 = 1e-7;
    let cross = du.cross(dv);
    // A derivative that is only rounding has no direction: compare with the larger of the two.
    let scale = du.length().max(dv.length());
    if cross.length() > PARALLEL * scale * scale { cross.try_normalize() } else { None }
}

#[cfg(test)]
#[path = "patch_tests.rs"]
mod tests;
