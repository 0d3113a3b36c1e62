//! \[SF98\] §4: many wires on one point.
//!
//! `P_def = P + lerp(lerp(blend, Σ ΔPᵢ, crossing), local, localize)`, where over the wires with `ΔPᵢ ≠ 0`
//! `blend = Σ ΔPᵢ·wᵢ^mᵢ / Σ wᵢ^mᵢ`, `wᵢ = ‖ΔPᵢ‖ / maxⱼ ‖ΔPⱼ‖`, and over the wires with `Fᵢ > 0`
//! `local = Σ ΔPᵢ·Fᵢ^k / Σ Fᵢ^k`.

use crate::foot::Foot;
use crate::wide;
use crate::wire::Prepared;
use glam::DVec3;
use wirework_core::{Blend, Wire};

/// Distances of wires in a group tie when they differ by less than this part of the scene's extent: the rounding of float64.
/// More would let the end of a cut wire stand for feet beyond the cut.
const GROUP_TIE: f64 = 1e-13;

/// Where `points` go. A point of which no wire with `F > 0` moves anything comes back as it went in.
///
/// # Panics
/// When a wire's pose is not one of its reference.
pub fn deform(wires: &[Wire], blend: &Blend, points: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let scene = Scene::new(wires, blend);
    points.iter().map(|&p| scene.deform(p)).collect()
}

/// Wires and their blend, ready for many points.
#[derive(Clone, Debug)]
pub struct Scene {
    wires: Vec<Prepared>,
    blend: Blend,
}

impl Scene {
    /// # Panics
    /// When a wire's pose is not one of its reference.
    pub fn new(wires: &[Wire], blend: &Blend) -> Self {
        Self { wires: wires.iter().map(Prepared::new).collect(), blend: *blend }
    }

    /// Where one point goes.
    pub fn deform(&self, point: [f32; 3]) -> [f64; 3] {
        self.deform_masked(point, &[])
    }

    /// The same where `masks[i]` multiplies `F` of wire `i`; wires beyond their end have 1.
    pub fn deform_masked(&self, point: [f32; 3], masks: &[f32]) -> [f64; 3] {
        self.deform_but(wide(point), masks, 0.0).to_array()
    }

    /// `F` and `ΔP` of each wire at a point, groups considered: a wire that is not the nearest of its group has 0.
    pub fn contributions(&self, point: [f32; 3], masks: &[f32]) -> Vec<(f64, [f64; 3])> {
        let all = self.acting(wide(point), masks);
        all.into_iter().map(|(f, delta)| (f, delta.to_array())).collect()
    }

    /// The closest point to a point on each wire's `R`.
    pub fn feet(&self, point: [f32; 3]) -> Vec<Foot> {
        self.wires.iter().map(|wire| wire.feet.closest(wide(point))).collect()
    }

    /// Takes displacements up to `floor` for none.
    pub(crate) fn deform_but(&self, p: DVec3, masks: &[f32], floor: f64) -> DVec3 {
        if !p.is_finite() {
            return p;
        }
        let acting = self.acting(p, masks);
        let moved: Vec<(usize, DVec3)> =
            acting.iter().map(|a| a.1).enumerate().filter(|(_, delta)| delta.length() > floor).collect();
        if moved.is_empty() {
            return p;
        }
        let sum: DVec3 = moved.iter().map(|m| m.1).sum();
        let largest = moved.iter().map(|m| m.1.length()).fold(0.0, f64::max);
        let exponent = |i: usize| f64::from(self.wires[i].wire.exponent.unwrap_or(self.blend.exponent));
        let blend =
            mean(moved.iter().map(|&(i, delta)| (exponent(i) * (delta.length() / largest).ln(), delta)));
        let k = f64::from(self.blend.locality);
        let near = acting.iter().filter(|(f, _)| *f > 0.0);
        let local = mean(near.map(|&(f, delta)| (k * f.ln(), delta)));
        p + blend.lerp(sum, self.blend.crossing.into()).lerp(local, self.blend.localize.into())
    }

    /// `F` and `ΔP` of each wire. Of a group only the wire whose `R` is nearest acts, whatever its radius; of those
    /// that are equally near (to [`GROUP_TIE`]) the first. One that is masked out takes no part.
    fn acting(&self, p: DVec3, masks: &[f32]) -> Vec<(f64, DVec3)> {
        let distance = |wire: &Prepared| wire.wire.group.map(|_| wire.feet.closest(p).distance);
        let distances: Vec<Option<f64>> = self.wires.iter().map(distance).collect();
        let mask = |i: usize| masks.get(i).map_or(1.0, |&mask| f64::from(mask));
        let acts = |i: usize| {
            let Some(group) = self.wires[i].wire.group else { return true };
            let same = |&j: &usize| self.wires[j].wire.group == Some(group) && mask(j) > 0.0;
            let members = (0..self.wires.len()).filter(same);
            let members: Vec<(usize, f64)> = members.filter_map(|j| Some((j, distances[j]?))).collect();
            let least = members.iter().map(|m| m.1).fold(f64::INFINITY, f64::min);
            let extent = members.iter().map(|m| self.wires[m.0].feet.extent(p)).fold(0.0, f64::max);
            members.into_iter().find(|m| m.1 <= least + GROUP_TIE * extent).map(|m| m.0) == Some(i)
        };
        let one = |i: usize| if acts(i) { self.wires[i].act(p, mask(i)) } else { (0.0, DVec3::ZERO) };
        (0..self.wires.len()).map(one).collect()
    }
}

/// The mean of vectors by weights of which the logarithms are given, so that no power overflows.
fn mean(weighted: impl Iterator<Item = (f64, DVec3)> + Clone) -> DVec3 {
    let top = weighted.clone().map(|w| w.0).fold(f64::NEG_INFINITY, f64::max);
    let weights = weighted.clone().map(|w| (w.0 - top).exp()).sum::<f64>();
    weighted.map(|(log, v)| v * (log - top).exp()).sum::<DVec3>() / weights
}
