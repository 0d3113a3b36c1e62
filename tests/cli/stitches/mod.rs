//! Stitches from outside: where seams lie, where they open, what follows them, and what cannot be sewn.

mod corners;
pub(crate) mod faults;
mod meshes;
mod objects;
mod played;
mod seams;
mod stacks;
mod tangent;
mod tears;
mod uneven;
mod weld;

use std::f64::consts::PI;

use glam::DVec3;

use crate::document::{Document, list};
use crate::place::Place;
use crate::player::play;
use crate::wrinkles::vertices;

/// How far apart points may be that are one, in parts of the diagonal.
const ONE: f64 = 1e-6;
/// The same of results and closed forms, which the contract allows f32.
const EXACT: f64 = 2e-5;

/// A patch: its control points, and how many quads it becomes along u and v.
#[derive(Clone)]
struct Patch {
    points: Vec<Vec<DVec3>>,
    cells: [usize; 2],
}

/// One of those of its sides that are sewn.
#[derive(Clone, Copy)]
enum Side {
    UMin,
    UMax,
    VMin,
}

impl Patch {
    /// A bicubic one whose control points are where `at` has them, u and v from 0 to 1.
    fn new(cells: [usize; 2], at: impl Fn(f64, f64) -> DVec3) -> Self {
        let row = |i: i32| (0..4).map(|j| at(f64::from(i) / 3.0, f64::from(j) / 3.0)).collect();
        Self { points: (0..4).map(row).collect(), cells }
    }

    /// A flat one over x and z: with such control points u and v are what they say.
    fn flat(x: [f64; 2], z: [f64; 2], cells: [usize; 2]) -> Self {
        Self::new(cells, |u, v| DVec3::new(x[0] + (x[1] - x[0]) * u, 0.0, z[0] + (z[1] - z[0]) * v))
    }

    fn piece(&self, name: &str) -> String {
        format!("Piece(name: \"{name}\", object: {})", self.object())
    }

    fn object(&self) -> String {
        let point = |p: &DVec3| format!("({}, {}, {})", p.x, p.y, p.z);
        let row = |row: &Vec<DVec3>| format!("[{}]", row.iter().map(point).collect::<Vec<_>>().join(", "));
        let rows: Vec<String> = self.points.iter().map(row).collect();
        let [u, v] = self.cells;
        format!("Patch(points: [{}], tessellation: ({u}, {v}))", rows.join(", "))
    }

    fn count(&self) -> usize {
        (self.cells[0] + 1) * (self.cells[1] + 1)
    }

    /// The vertices of a side, in the direction in which u or v grows.
    fn side(&self, side: Side) -> Vec<usize> {
        let [u, v] = self.cells;
        let at = |i: usize, j: usize| i * (v + 1) + j;
        match side {
            Side::UMin => (0..=v).map(|j| at(0, j)).collect(),
            Side::UMax => (0..=v).map(|j| at(u, j)).collect(),
            Side::VMin => (0..=u).map(|i| at(i, 0)).collect(),
        }
    }
}

/// Two sheets that bulge, a bent gap between them. Sewn are `UMax` of "left" and `UMin` of "right".
fn pair(left: [usize; 2], right: [usize; 2]) -> [Patch; 2] {
    let wave = |v: f64| (PI * v).sin();
    [
        Patch::new(left, |u, v| {
            DVec3::new(-1.3 + u * (1.0 + 0.15 * wave(v)), 0.2 * wave(u) + 0.1 * u * wave(v), 1.6 * v - 0.8)
        }),
        Patch::new(right, |u, v| {
            DVec3::new(0.3 + u + 0.2 * (1.0 - u) * v * v, 0.4 * (1.0 - u) * (v - 0.4), 1.5 * v - 0.8)
        }),
    ]
}

/// Two flat sheets with straight edges along z, from -1 to 1, at `-half` and `half`.
fn straight(half: f64, cells: [usize; 2]) -> [Patch; 2] {
    [[-1.0 - half, -half], [half, 1.0 + half]].map(|x| Patch::flat(x, [-1.0, 1.0], cells))
}

/// A stitch of "left" and "right" along the edges between them; `fields` are those of the seam.
fn sewn(patches: &[Patch; 2], fields: &str) -> String {
    let [left, right] = patches;
    format!(
        "Stitch(patches: [{}, {}], seams: [Seam(a: Edge(piece: \"left\", side: UMax), \
         b: Edge(piece: \"right\", side: UMin), {fields})])",
        left.piece("left"),
        right.piece("right"),
    )
}

/// Both edges of that seam, in vertices of the result.
fn edges(patches: &[Patch; 2]) -> [Vec<usize>; 2] {
    let [left, right] = patches;
    let behind = right.side(Side::UMin).into_iter().map(|i| i + left.count());
    [left.side(Side::UMax), behind.collect()]
}

fn at(points: &[DVec3], list: &[usize]) -> Vec<DVec3> {
    list.iter().map(|&i| points[i]).collect()
}

fn diagonal(points: &[DVec3]) -> f64 {
    let least = points.iter().fold(DVec3::MAX, |m, p| m.min(*p));
    let most = points.iter().fold(DVec3::MIN, |m, p| m.max(*p));
    least.distance(most)
}

/// How far apart two lists of points are where they are farthest.
#[track_caller]
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len(), "as many points");
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

/// How far a point is from a line through points.
fn off(p: DVec3, line: &[DVec3]) -> f64 {
    let to = |ends: &[DVec3]| {
        let along = ends[1] - ends[0];
        let square = along.length_squared();
        let x = if square > 0.0 { ((p - ends[0]).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        p.distance(ends[0] + along * x)
    };
    line.windows(2).map(to).fold(f64::INFINITY, f64::min)
}

/// The lines of an OBJ that say where its vertices are.
fn lines(text: &[u8]) -> Vec<&str> {
    let text = std::str::from_utf8(text).unwrap();
    text.lines().filter(|line| line.starts_with("v ")).collect()
}

impl Place {
    /// What patches are at rest, one behind the other, with no stitch: an OBJ text.
    fn rest(&self, patches: &[Patch]) -> Vec<u8> {
        let mut text = Vec::new();
        for patch in patches {
            let wire = "Wire(curve: Polyline(points: [(0, 0, 0), (1, 0, 0)]), radius: 0.1)";
            self.write("rest.ron", format!("Deform(object: {}, wires: [{wire}])", patch.object()));
            self.run("apply rest.ron -o rest.obj --at 0 -q").expect(0);
            let own = self.read("rest.obj");
            text.extend(lines(&own).join("\n").into_bytes());
            text.push(b'\n');
        }
        text
    }

    fn rest_points(&self, patches: &[Patch]) -> Vec<DVec3> {
        vertices(&self.rest(patches))
    }

    /// Writes what a preset makes of its own object, as an animation.
    fn film(&self, preset: &str, more: &str) -> Film {
        self.write("film.ron", preset);
        self.run(&format!("apply film.ron -o film.glb -q {more}")).expect(0);
        Film::open(self, "film.glb")
    }
}

/// A document whose nodes with meshes are pieces.
struct Film(Document);

impl Film {
    fn open(place: &Place, name: &str) -> Self {
        Self(Document::open(&place.path(name)))
    }

    /// The names of the nodes that show something.
    fn names(&self) -> Vec<&str> {
        let nodes = list(&self.0.json, "nodes").iter().filter(|node| node.get("mesh").is_some());
        nodes.map(|node| node["name"].as_str().unwrap()).collect()
    }

    /// Each piece at a moment of the clip "wirework", or at rest.
    fn at(&self, seconds: Option<f64>) -> Vec<Vec<DVec3>> {
        play(&self.0, seconds.map(|_| "wirework"), seconds.unwrap_or(0.0))
    }
}
