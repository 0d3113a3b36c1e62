//! Limbs from outside: where bones and rubber are, what follows them, over clips too, and what cannot be a limb.

mod faults;
mod goals;
mod hostile;
pub(crate) mod made;
mod posed;
mod stacks;
mod tube;

use std::f64::consts::PI;

use glam::DVec3;

use crate::place::Place;
use crate::wrinkles::{triangles, vertices};

/// The tube of most of these tests: from the origin along x, on three bones of one metre.
const LENGTH: f64 = 3.0;
const RADIUS: f64 = 0.1;
const SIDES: usize = 24;
const RINGS: usize = 121;

/// That tube, which has closed ends.
fn object() -> String {
    format!("Tube(from: (0, 0, 0), to: ({LENGTH}, 0, 0), radius: {RADIUS}, sides: {SIDES}, rings: {RINGS})")
}

/// A limb of it with these fields.
fn limb(fields: &str) -> String {
    format!("Ik(object: {}, chain: Joints([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]), {fields})", object())
}

fn point(p: DVec3) -> String {
    format!("({}, {}, {})", p.x, p.y, p.z)
}

/// What has become of the tube.
struct Shape {
    points: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Shape {
    fn ring(&self, ring: usize) -> &[DVec3] {
        &self.points[ring * SIDES..][..SIDES]
    }

    /// The middle of each ring.
    fn centers(&self) -> Vec<DVec3> {
        (0..RINGS).map(|ring| self.ring(ring).iter().sum::<DVec3>() / SIDES as f64).collect()
    }

    fn tip(&self) -> DVec3 {
        self.centers()[RINGS - 1]
    }

    /// The length of its middle line.
    fn length(&self) -> f64 {
        length(&self.centers())
    }

    /// How far the vertices of a ring are from its middle, least and most.
    fn radii(&self, ring: usize) -> [f64; 2] {
        let center = self.ring(ring).iter().sum::<DVec3>() / SIDES as f64;
        let radii = self.ring(ring).iter().map(|p| p.distance(center));
        [radii.clone().fold(f64::MAX, f64::min), radii.fold(0.0, f64::max)]
    }

    /// What its surface encloses.
    fn volume(&self) -> f64 {
        let part = |[a, b, c]: &[usize; 3]| self.points[*a].cross(self.points[*b]).dot(self.points[*c]) / 6.0;
        self.triangles.iter().map(part).sum::<f64>()
    }
}

/// The volume of the tube at rest, a prism.
fn whole() -> f64 {
    let sides = SIDES as f64;
    LENGTH * sides / 2.0 * RADIUS * RADIUS * (2.0 * PI / sides).sin()
}

fn length(line: &[DVec3]) -> f64 {
    line.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// How far apart two lists of points are where they are farthest.
#[track_caller]
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len(), "as many points");
    a.iter().zip(b).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
}

impl Place {
    /// What a limb of the tube is at a moment.
    fn shape(&self, preset: &str, seconds: f64) -> Shape {
        let points = self.still(preset, seconds);
        Shape { points, triangles: triangles(&self.read("still.obj")) }
    }

    /// The tube at rest, as an OBJ text.
    fn tube_at_rest(&self) -> Vec<u8> {
        let wire = "Wire(curve: Polyline([(0, 0, 0), (1, 0, 0)]), radius: 0.1)";
        self.write("rest.ron", format!("Deform(object: {}, wires: [{wire}])", object()));
        self.run("apply rest.ron -o rest.obj --at 0 -q").expect(0);
        self.read("rest.obj")
    }

    /// A model as an effect leaves it that reaches nothing.
    fn untouched(&self, model: &str, seconds: f64) -> Vec<DVec3> {
        let wire =
            "Wire(curve: Polyline([(99, 0, 0), (99, 1, 0)]), radius: 0.1, pose: [(98, 0, 0), (98, 1, 0)])";
        self.of(&format!("Deform(wires: [{wire}])"), model, seconds)
    }

    /// What a preset makes of a model at a moment.
    fn of(&self, preset: &str, model: &str, seconds: f64) -> Vec<DVec3> {
        self.write("still.ron", preset);
        self.run(&format!("apply still.ron {model} -o still.obj --at {seconds} -q")).expect(0);
        vertices(&self.read("still.obj"))
    }
}
