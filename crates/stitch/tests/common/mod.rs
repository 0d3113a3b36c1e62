//! Pieces put together, sewn, and looked at.

use glam::DVec3;
use wirework_core::{Binding, Mask, Wire};
use wirework_stitch::{Edge, Run, Seam, Seams, Side, Stitch, StitchError, Surfaces, seams};
use wirework_surface::{Mesh, Patch};

/// Pieces in one list of points.
#[derive(Clone, Default)]
pub(crate) struct Cloth {
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) piece_of: Vec<u32>,
    pub(crate) sides: Vec<Option<[Vec<u32>; 4]>>,
    /// The first point of each piece, and the end of the last.
    pub(crate) starts: Vec<usize>,
}

impl Cloth {
    pub(crate) fn add(&mut self, mesh: &Mesh) {
        let first = self.points.len() as u32;
        let piece = self.sides.len() as u32;
        self.starts.push(first as usize);
        self.points.extend(&mesh.positions);
        self.triangles.extend(mesh.triangles().unwrap().iter().map(|t| t.map(|v| v + first)));
        self.piece_of.extend(mesh.positions.iter().map(|_| piece));
        self.sides.push(None);
    }

    /// A patch by its control points, `cells` each way.
    pub(crate) fn add_patch(&mut self, rows: &[Vec<[f32; 3]>], cells: u32) {
        let patch = Patch::new([3, 3], rows).unwrap();
        let first = self.points.len() as u32;
        self.add(&patch.tessellate([cells; 2]).unwrap());
        let at = |i: u32, j: u32| first + i * (cells + 1) + j;
        let side = |of: &dyn Fn(u32) -> u32| (0..=cells).map(of).collect::<Vec<u32>>();
        let sides =
            [side(&|k| at(0, k)), side(&|k| at(cells, k)), side(&|k| at(k, 0)), side(&|k| at(k, cells))];
        *self.sides.last_mut().unwrap() = Some(sides);
    }

    pub(crate) fn surfaces(&self) -> Surfaces<'_> {
        let Self { points, triangles, piece_of, sides, .. } = self;
        Surfaces { positions: points, triangles, piece_of, sides }
    }

    pub(crate) fn side(&self, piece: usize, side: Side) -> &[u32] {
        &self.sides[piece].as_ref().unwrap()[side as usize]
    }

    pub(crate) fn piece(&self, piece: usize) -> std::ops::Range<usize> {
        self.starts[piece]..self.starts.get(piece + 1).copied().unwrap_or(self.points.len())
    }

    pub(crate) fn lay(&self, settings: &Stitch) -> Result<Seams, StitchError> {
        seams(&self.surfaces(), settings)
    }

    pub(crate) fn diagonal(&self) -> f64 {
        let fold = |f: fn(DVec3, DVec3) -> DVec3, start| self.points.iter().map(|p| wide(*p)).fold(start, f);
        (fold(DVec3::max, DVec3::NEG_INFINITY) - fold(DVec3::min, DVec3::INFINITY)).length()
    }
}

/// All points at a moment.
pub(crate) fn sewn_at(cloth: &Cloth, settings: &Stitch, seconds: f64) -> Vec<[f32; 3]> {
    let mut seams = cloth.lay(settings).unwrap();
    run(cloth, &mut seams, seconds)
}

pub(crate) fn run(cloth: &Cloth, seams: &mut Seams, seconds: f64) -> Vec<[f32; 3]> {
    let mut wires: Vec<Wire> = Vec::new();
    seams.wires_at(seconds, &mut wires);
    let masks: Vec<Option<Mask<'_>>> = seams
        .near()
        .iter()
        .map(|near| Some(Mask::Sparse { points: &near.vertices, factors: &near.factors }))
        .collect();
    let mut binding = Binding::masked(&wires, &cloth.points, &masks).unwrap();
    let mut out = cloth.points.clone();
    binding.deform_into(&wires, &seams.blend(), &mut out).unwrap();
    for pin in seams.pins() {
        out[pin.point as usize] = pin.goal;
    }
    out
}

pub(crate) fn sewn(cloth: &Cloth, settings: &Stitch) -> Vec<[f32; 3]> {
    sewn_at(cloth, settings, 0.0)
}

pub(crate) fn on_side(piece: usize, side: Side) -> Edge {
    Edge { piece, run: Run::Side(side) }
}

pub(crate) fn stitch(seams: Vec<Seam>) -> Stitch {
    Stitch { seams, ..Stitch::default() }
}

pub(crate) fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

pub(crate) fn gap(points: &[[f32; 3]], a: u32, b: u32) -> f64 {
    wide(points[a as usize]).distance(wide(points[b as usize]))
}

/// A patch of four by four control points over a rectangle, bulging by `bulge`.
pub(crate) fn sheet(x: [f32; 2], z: [f32; 2], bulge: f32) -> Vec<Vec<[f32; 3]>> {
    let at = |range: [f32; 2], k: usize| range[0] + (range[1] - range[0]) * k as f32 / 3.0;
    let rise = |i: usize, j: usize| {
        let inner = [i, j].iter().filter(|k| (1..3).contains(*k)).count();
        bulge * [0.0, 0.4, 1.0][inner]
    };
    (0..4).map(|i| (0..4).map(|j| [at(x, i), rise(i, j), at(z, j)]).collect()).collect()
}

/// The border nearest to a point.
pub(crate) fn rim(piece: usize, at: [f32; 3]) -> Edge {
    Edge { piece, run: Run::Loop(at) }
}
