//! Random rigs for tests and benchmarks, biased to trouble: points on the wires, at exactly `r` and beyond the
//! ends, symmetric and folded curves, coincident control points, wires that only partly move, mixed exponents. What bounds
//! a wire's influence is added by `features.rs`.

use crate::features;
use crate::random::Random;
use crate::{closest, point};
use glam::{DQuat, DVec3};
use wirework_core::{
    Bend, Blend, Closest, Correspondence, Curve, CurveKind, Density, Interpolation, Locator, Mask, Profile,
    Wire,
};

/// Wires, their blend, and points to deform.
#[derive(Clone, Debug)]
pub struct Rig {
    /// 1 to 5.
    pub wires: Vec<Wire>,
    /// How they blend.
    pub blend: Blend,
    /// In mesh order: a grid, then points in trouble.
    pub points: Vec<[f32; 3]>,
    /// For every wire none, or a factor from 0 to 1 for each point.
    pub masks: Vec<Option<Vec<f32>>>,
}

impl Rig {
    /// The rig of a seed. Its size is a power of ten from 1e-3 to 1e3, its centre up to twice that off the origin.
    pub fn new(seed: u64) -> Self {
        let (mut rig, frame) = Self::of_seed(seed);
        features::add(&mut rig, &frame, &mut Random::new(!seed));
        rig
    }

    /// The same without directions, domain curves, blended feet and masks.
    pub fn plain(seed: u64) -> Self {
        Self::of_seed(seed).0
    }

    fn of_seed(seed: u64) -> (Self, Frame) {
        let mut random = Random::new(seed);
        let frame = Frame {
            size: 10_f64.powf(random.range(-3.0, 3.0)),
            center: if random.one_in(2) { DVec3::ZERO } else { DVec3::from_array(random.vector(2.0)) },
        };
        let count = 1 + random.below(5);
        let wires: Vec<Wire> = (0..count).map(|i| wire(&mut random, &frame, seed as usize + i)).collect();
        let blend = Blend {
            exponent: random.pick(&[1.0, 1.0, 0.0, 2.0, 5.0, -1.0, -2.0]),
            crossing: random.pick(&[0.0, 0.0, 0.4, 1.0]),
            localize: random.pick(&[0.0, 0.0, 0.3, 1.0]),
            locality: random.pick(&[1.0, 0.0, 2.5]),
            ..Blend::default()
        };
        let points = points(&mut random, &frame, &wires);
        let masks = vec![None; wires.len()];
        (Self { wires, blend, points, masks }, frame)
    }

    /// The masks as a binding takes them.
    pub fn masks(&self) -> Vec<Option<Mask<'_>>> {
        self.masks.iter().map(|mask| mask.as_deref().map(Mask::Dense)).collect()
    }

    /// The factor of every wire at one point.
    pub fn masks_at(&self, index: usize) -> Vec<f32> {
        self.masks.iter().map(|mask| mask.as_ref().map_or(1.0, |mask| mask[index])).collect()
    }

    /// Adds points, each with the factor 1.
    pub fn add(&mut self, points: impl IntoIterator<Item = [f32; 3]>) {
        self.points.extend(points);
        for mask in self.masks.iter_mut().flatten() {
            mask.resize(self.points.len(), 1.0);
        }
    }

    /// Puts the points in another order, and the masks with them.
    pub fn shuffle(&mut self, random: &mut Random) {
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        random.shuffle(&mut order);
        self.points = order.iter().map(|&i| self.points[i]).collect();
        for mask in self.masks.iter_mut().flatten() {
            *mask = order.iter().map(|&i| mask[i]).collect();
        }
    }

    /// A map applied to all that has a place, its linear part to all that has a direction, a factor to all that has a length.
    ///
    /// # Panics
    /// When the map leaves the range of float32.
    #[must_use]
    pub fn mapped(&self, map: impl Fn(DVec3) -> DVec3, factor: f32) -> Self {
        let mut rig = self.clone();
        let apply = |points: &[[f32; 3]]| -> Vec<[f32; 3]> {
            points.iter().map(|&p| map(crate::wide(p)).as_vec3().to_array()).collect()
        };
        rig.points = apply(&self.points);
        for wire in &mut rig.wires {
            let moved = |curve: &Curve| curve.posed(apply(curve.points())).expect("as many points");
            wire.reference = moved(&wire.reference);
            wire.pose = apply(&wire.pose);
            for domain in &mut wire.domains {
                domain.curve = moved(&domain.curve);
            }
            let radii = wire.locators.iter_mut().filter_map(|l| l.radius.as_mut());
            radii.chain([&mut wire.radius]).for_each(|r| *r *= factor);
            if let Closest::Blended(width) = &mut wire.closest {
                *width *= factor;
            }
            let axes = wire.locators.iter_mut().filter_map(|l| l.direction.as_mut());
            for axis in axes.chain(&mut wire.direction) {
                *axis = (map(crate::wide(*axis)) - map(DVec3::ZERO)).as_vec3().to_array();
            }
        }
        rig
    }

    /// The same wires at rest: nothing moves.
    #[must_use]
    pub fn at_rest(&self) -> Self {
        let mut rig = self.clone();
        for wire in &mut rig.wires {
            wire.pose = wire.reference.points().to_vec();
            (wire.scale, wire.twist) = (1.0, 0.0);
            for locator in &mut wire.locators {
                (locator.scale, locator.twist) = (None, None);
            }
        }
        rig
    }

    /// The diagonal of the box about the points and all control points, at rest and posed, and of domain curves.
    pub fn diagonal(&self) -> f64 {
        let of_wire = |wire: &Wire| {
            let domains = wire.domains.iter().flat_map(|domain| domain.curve.points().to_vec());
            [wire.reference.points().to_vec(), wire.pose.clone(), domains.collect()].concat()
        };
        let curves: Vec<[f32; 3]> = self.wires.iter().flat_map(of_wire).collect();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &p in self.points.iter().chain(&curves) {
            (low, high) = (low.min(crate::wide(p)), high.max(crate::wide(p)));
        }
        (high - low).length()
    }
}

/// Where random positions lie.
pub(crate) struct Frame {
    pub(crate) size: f64,
    center: DVec3,
}

impl Frame {
    pub(crate) fn place(&self, p: DVec3) -> [f32; 3] {
        (self.size * (self.center + p)).as_vec3().to_array()
    }
}

pub(crate) const KINDS: [CurveKind; 6] = [
    CurveKind::BSpline { degree: 3 },
    CurveKind::Polyline,
    CurveKind::BSpline { degree: 2 },
    CurveKind::CatmullRom,
    CurveKind::Bezier,
    CurveKind::BSpline { degree: 1 },
];

fn wire(random: &mut Random, frame: &Frame, turn: usize) -> Wire {
    // Each kind in turn, so that few seeds meet all.
    let (kind, closed) = (KINDS[turn % KINDS.len()], random.one_in(3));
    // A frame carried through a cusp leaves it turned by the last bit of the input: no matter for a comparison.
    let bend = random.pick(&[Bend::Tangent, Bend::Tangent, Bend::Transport]);
    let rest = controls(random, kind, closed, bend == Bend::Tangent);
    let posed = posed(random, &rest);
    let place = |points: &[DVec3]| points.iter().map(|p| frame.place(*p)).collect::<Vec<_>>();
    let reference = Curve::new(kind, closed, place(&rest)).expect("as many points as the kind needs");
    let attributes = |random: &mut Random| Locator {
        u: 0.0,
        radius: Some((frame.size * random.range(0.2, 1.2)) as f32),
        scale: Some(random.pick(&[1.0, 1.0, 0.0, 0.4, 1.8])),
        rotation: Some(random.pick(&[1.0, 1.0, 0.0, 0.5, -1.0])),
        amplitude: Some(random.pick(&[1.0, 1.0, 0.6, -0.5])),
        twist: Some(random.pick(&[0.0, 0.0, 0.7, -9.0])),
        direction: None,
        angle: None,
    };
    let own = attributes(random);
    let mut locators: Vec<Locator> = (0..random.pick(&[0, 0, 0, 1, 2, 3]))
        .map(|_| {
            let all = attributes(random);
            let anywhere = random.range(0.0, 1.0) as f32;
            let u = random.pick(&[0.0, 0.25, 0.5, 1.0, anywhere]);
            let mut some = |value: Option<f32>| value.filter(|_| random.one_in(2));
            Locator {
                radius: some(all.radius),
                scale: some(all.scale),
                rotation: some(all.rotation),
                amplitude: some(all.amplitude),
                twist: some(all.twist),
                direction: None,
                angle: None,
                u,
            }
        })
        .collect();
    locators.sort_by(|a, b| a.u.total_cmp(&b.u));
    locators.dedup_by_key(|l| l.u);
    let value = |v: Option<f32>| v.unwrap_or(1.0);
    Wire {
        pose: if random.one_in(12) { reference.points().to_vec() } else { place(&posed) },
        radius: value(own.radius),
        scale: value(own.scale),
        rotation: value(own.rotation),
        amplitude: value(own.amplitude),
        twist: value(own.twist),
        density: density(random),
        locators,
        interpolation: random.pick(&[Interpolation::Linear, Interpolation::Smooth]),
        correspondence: random.pick(&[Correspondence::Parameter, Correspondence::ArcLength]),
        bend,
        group: random.pick(&[None, None, None, Some(0), Some(1)]),
        exponent: random.pick(&[None, None, None, Some(0.0), Some(3.0), Some(-1.5)]),
        ..Wire::new(reference)
    }
}

fn density(random: &mut Random) -> Density {
    let profile = Profile::new(&[(0.2, 0.9), (0.5, 0.3), (0.7, 0.3)]).expect("a density");
    random.pick(&[
        Density::Quartic,
        Density::Quartic,
        Density::Sextic,
        Density::Smoothstep,
        Density::Linear,
        Density::Fold(1.0),
        Density::Fold(3.5),
        Density::Profile(profile),
    ])
}

/// Control points; with `folds` also such that the curve stops, or goes back on itself.
pub(crate) fn controls(random: &mut Random, kind: CurveKind, closed: bool, folds: bool) -> Vec<DVec3> {
    let count = match (kind, closed) {
        (CurveKind::Bezier, false) => 1 + 3 * random.pick(&[1, 1, 2, 3]),
        (CurveKind::Bezier, true) => 3 * random.pick(&[1, 2, 3]),
        _ => random.pick(&[1, 2, 3, 4, 4, 5, 6, 8]),
    };
    let count = if closed && !folds { count.max(3) } else { count };
    let mut points: Vec<DVec3> = match random.below(if folds { 5 } else { 3 }) {
        // Anywhere.
        0 | 1 => (0..count).map(|_| DVec3::from_array(random.vector(1.0))).collect(),
        // Round a circle.
        2 => {
            let angle = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
            (0..count).map(|i| DVec3::new(angle(i).cos(), 0.0, angle(i).sin()) * 0.8).collect()
        }
        // Along a line, a little off it.
        3 => {
            let off = random.pick(&[0.0, 0.2]);
            let x = |i: usize| 2.0 * i as f64 / count as f64 - 1.0;
            (0..count).map(|i| DVec3::X * x(i) + DVec3::from_array(random.vector(off))).collect()
        }
        // On a coarse lattice: symmetric, with ties.
        _ => (0..count).map(|_| (DVec3::from_array(random.vector(1.0)) * 2.0).round() * 0.5).collect(),
    };
    if folds && count > 2 && random.one_in(6) {
        let i = random.below(count - 1);
        points[i + 1] = points[i];
    }
    if folds && count > 3 && random.one_in(8) {
        // A hairpin.
        points[count - 1] = points[count - 3] + DVec3::from_array(random.vector(0.02));
    }
    points
}

fn posed(random: &mut Random, rest: &[DVec3]) -> Vec<DVec3> {
    match random.below(5) {
        0 => {
            let turn = DQuat::from_scaled_axis(DVec3::from_array(random.vector(2.0)));
            let shift = DVec3::from_array(random.vector(0.5));
            rest.iter().map(|&p| turn * p + shift).collect()
        }
        1 => {
            // Only some points move.
            let first = random.below(rest.len());
            let shift = DVec3::from_array(random.vector(0.6));
            rest.iter().enumerate().map(|(i, &p)| if i < first { p } else { p + shift }).collect()
        }
        2 => rest.iter().rev().map(|&p| p + DVec3::Y * 0.1).collect(),
        _ => {
            let size = random.pick(&[0.02, 0.3, 0.8]);
            rest.iter().map(|&p| p + DVec3::from_array(random.vector(size))).collect()
        }
    }
}

/// Side of the grid of points.
const SIDE: usize = 10;

fn points(random: &mut Random, frame: &Frame, wires: &[Wire]) -> Vec<[f32; 3]> {
    let tilt = DQuat::from_scaled_axis(DVec3::from_array(random.vector(1.0)));
    let tilt = if random.one_in(2) { DQuat::IDENTITY } else { tilt };
    let cell = |i: usize| 2.6 * i as f64 / (SIDE - 1) as f64 - 1.3;
    let mut points: Vec<[f32; 3]> = (0..SIDE * SIDE)
        .map(|i| frame.place(tilt * DVec3::new(cell(i % SIDE), 0.05, cell(i / SIDE))))
        .collect();
    for wire in wires {
        let curve = &wire.reference;
        for _ in 0..12 {
            let anywhere = random.range(0.0, 1.0);
            let u = random.pick(&[0.0, 0.5, 1.0, anywhere, anywhere]);
            let on = DVec3::from_array(point(curve, u));
            let away = DVec3::from_array(random.vector(1.0)).normalize_or_zero();
            let r = f64::from(wire.radius);
            let reach = random.pick(&[0.0, 1e-6, 0.1, 0.5, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.5]) * r;
            points.push((on + away * reach).as_vec3().to_array());
            // At exactly r, or as near as float32 comes, from its own foot.
            let outside = on + away * frame.size;
            let foot = closest(curve, outside.to_array());
            let out = (outside - DVec3::from_array(foot.point)).normalize_or_zero();
            points.push((DVec3::from_array(foot.point) + out * r).as_vec3().to_array());
        }
        for (end, next) in [(0.0, 0.01), (1.0, 0.99)] {
            let (a, b) = (DVec3::from_array(point(curve, end)), DVec3::from_array(point(curve, next)));
            let beyond = (a - b).normalize_or_zero() * (frame.size * random.range(0.0, 0.4));
            points.push((a + beyond).as_vec3().to_array());
        }
    }
    points
}
