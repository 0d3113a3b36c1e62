//! How well the answer is defined at a point.
//!
//! The deformation is not continuous everywhere: the foot jumps across the medial axis, a corner's tangent steps,
//! a domain curve without transition has two sides, a direction none on the wire itself, `m < 0` steps where an influence
//! ends. There the answer hangs on the last bit of the input, and two
//! right implementations may differ. A test leaves such points out, counts them, and bounds their number.

use crate::blend::Scene;
use crate::random::Random;
use crate::wide;
use glam::DVec3;
use wirework_core::{Blend, Wire};

/// How far the answer moves, at most, over some disturbances of the point and of all control points, those of domain curves
/// too, by `part` of their largest absolute coordinate, and of directions by `part` of their length.
///
/// # Panics
/// When a wire's pose is not one of its reference.
pub fn unsteadiness(wires: &[Wire], blend: &Blend, point: [f32; 3], part: f64) -> f64 {
    Doubt::new(wires, blend, part).of(point)
}

/// A scene and some disturbances of it, ready for many points.
#[derive(Clone, Debug)]
pub struct Doubt {
    scene: Scene,
    disturbed: Vec<Scene>,
    part: f64,
    extent: f64,
}

impl Doubt {
    /// # Panics
    /// When a wire's pose is not one of its reference.
    pub fn new(wires: &[Wire], blend: &Blend, part: f64) -> Self {
        let domains = |wire: &'_ Wire| wire.domains.iter().flat_map(|d| d.curve.points().to_vec()).collect();
        let curves = wires.iter().flat_map(|wire| {
            let domains: Vec<[f32; 3]> = domains(wire);
            [wire.reference.points(), &wire.pose, &domains].concat()
        });
        let extent = curves.map(|c| wide(c).abs().max_element()).fold(0.0, f64::max);
        let mut noise = Noise(Random::new(0x5EED));
        let disturbed = (0..CURVE_SHIFTS).map(|_| {
            let wires: Vec<Wire> = wires.iter().map(|wire| noise.disturb(wire, part, extent)).collect();
            Scene::new(&wires, blend)
        });
        Self { disturbed: disturbed.collect(), scene: Scene::new(wires, blend), part, extent }
    }

    /// How far the answer at a point moves at most.
    pub fn of(&self, point: [f32; 3]) -> f64 {
        self.of_masked(point, &[])
    }

    /// The same where `masks[i]` multiplies `F` of wire `i`.
    pub fn of_masked(&self, point: [f32; 3], masks: &[f32]) -> f64 {
        let p = wide(point);
        let step = self.part * self.extent.max(p.abs().max_element());
        let answer = self.scene.deform_but(p, masks, 0.0) - p;
        let mut noise = Noise(Random::new(0x5EED));
        let moves = |scene: &Scene, shift: DVec3| {
            let moved = scene.deform_but(p + shift, masks, 0.0) - (p + shift);
            moved.distance(answer)
        };
        // A displacement no larger than that may as well be none, which for m ≤ 0 is a difference.
        let mut worst = (self.scene.deform_but(p, masks, step) - p).distance(answer);
        for _ in 0..POINT_SHIFTS {
            worst = worst.max(moves(&self.scene, noise.vector() * step));
        }
        for scene in &self.disturbed {
            worst = worst.max(moves(scene, DVec3::ZERO)).max(moves(scene, noise.vector() * step));
        }
        worst
    }
}

const POINT_SHIFTS: usize = 16;
const CURVE_SHIFTS: usize = 8;

/// Random disturbances, the same every time.
struct Noise(Random);

impl Noise {
    /// Components in `[-1, 1)`.
    fn vector(&mut self) -> DVec3 {
        DVec3::from_array(self.0.vector(1.0))
    }

    /// Control points stay float32: each coordinate moves by that part of the extent, or by its own last bit where that is more.
    fn disturb(&mut self, wire: &Wire, part: f64, extent: f64) -> Wire {
        let mut wire = wire.clone();
        let mut shift = |p: &[f32; 3]| (wide(*p) + self.vector() * (part * extent)).as_vec3().to_array();
        let moved: Vec<[f32; 3]> = wire.reference.points().iter().map(&mut shift).collect();
        // What has not moved stays so: equal control points get equal shifts.
        let pose = wire.pose.iter().zip(wire.reference.points()).zip(&moved);
        wire.pose = pose.map(|((w, r), moved)| if w == r { *moved } else { shift(w) }).collect();
        wire.reference = wire.reference.posed(moved).expect("as many points, all finite");
        for domain in &mut wire.domains {
            let moved = domain.curve.points().iter().map(&mut shift).collect();
            domain.curve = domain.curve.posed(moved).expect("as many points, all finite");
        }
        for direction in
            wire.locators.iter_mut().filter_map(|l| l.direction.as_mut()).chain(&mut wire.direction)
        {
            let axis = wide(*direction);
            *direction = (axis + self.vector() * (part * axis.length())).as_vec3().to_array();
        }
        wire
    }
}
