//! What keeps a rope in its shape.
//!
//! The energy of bending is `½ EI Σ |Dⱼ − Q D̂ⱼ|² / hⱼ`, with `Dⱼ` the difference of the directions of the two links at joint
//! `j`, `D̂ⱼ` the one at rest, `hⱼ` half the length of the two, and `Q` the rotation of the whole rope that makes it least, as in shape
//! matching \[Müller, Heidelberger, Teschner and Gross 2005\]. With `Q` given the energy is quadratic in the nodes, and implicit
//! integration is the same banded system at every step. `Q` is carried along as the rope turned in the last step, and drawn to the
//! least energy in each.
//!
//! # Notes
//!
//! - A rotation for each joint, carried from link to link without twist \[Iben, Meyer, Petrovic, Soares, Anderson and Witkin 2013,
//!   Artistic Simulation of Curly Hair\], keeps curls where a rope bends sharply. But the joints above feel no reaction to it: an
//!   undamped coil, let go, whirled at 16 m/s for ever.
//! - Only drawn, not carried, `Q` is late, since a stiff shape follows `Q` more than `Q` follows it: drawn twice a step, a bent cane
//!   swings as in honey, half as wide after each second.
//! - Drawn to the nodes before or after a step, not to the shape on which the forces act, it leaves a torque: a coil hung to rest spun
//!   on at 0.05 m/s for ever.

use glam::{DMat3, DQuat, DVec3};

use crate::links::{Links, outer};

/// `EI / (ρ g L³)` of the stiffest rope, `g` that of the earth: held level at one end it would sag by an eightieth of its length.
const STIFFEST: f64 = 10.0;
/// m/s². A constant, so that gravity does not change what ropes are made of.
const EARTH: f64 = 9.81;
/// Against rotations that the shape says nothing about, such as round a rope that is bent in one place only.
const LOOSE: f64 = 1e-6;

/// The joints of a rope, and the solved system of a step.
#[derive(Clone, Debug)]
pub(crate) struct Bending {
    /// `Q`
    turn: DQuat,
    joints: Vec<Joint>,
    matrix: Banded,
    moves: Vec<DVec3>,
    bent: Vec<DVec3>,
}

#[derive(Clone, Copy, Debug)]
struct Joint {
    /// `D̂`
    rest: DVec3,
    /// By how much the difference of directions changes with the node above, the joint itself and the node below.
    change: [f64; 3],
    /// `EI dt² / h`
    strength: f64,
}

impl Bending {
    /// Of a rope with `nodes` at rest; `None` where nothing bends.
    pub(crate) fn new(links: &Links, nodes: &[DVec3], stiffness: f64, step: f64) -> Option<Self> {
        if stiffness <= 0.0 || links.lengths.len() < 2 {
            return None;
        }
        let length: f64 = links.lengths.iter().sum();
        // The mass of the whole is 1, so ρ is 1 / L. The cube spreads what one sees evenly over the range.
        let strength = STIFFEST * stiffness.powi(3) * EARTH * length * length * step * step;
        let joint = |(at, pair): (&[DVec3], &[f64])| {
            let [above, below] = [1.0 / pair[0], 1.0 / pair[1]];
            let half = 0.5 * (pair[0] + pair[1]);
            let change = [above, -above - below, below];
            Joint { rest: difference(at, change), change, strength: strength / half }
        };
        let joints: Vec<Joint> = nodes.windows(3).zip(links.lengths.windows(2)).map(joint).collect();
        let matrix = Banded::new(&links.masses[1..], &joints);
        let moves = vec![DVec3::ZERO; links.lengths.len()];
        Some(Self { turn: DQuat::IDENTITY, joints, matrix, moves, bent: Vec::with_capacity(nodes.len()) })
    }

    /// As at rest again.
    pub(crate) fn restart(&mut self) {
        self.turn = DQuat::IDENTITY;
    }

    /// Moves `wanted` as the shape at rest asks for; the first node stays.
    pub(crate) fn bend(&mut self, wanted: &mut [DVec3]) {
        self.solve(wanted);
        let turned = |(joint, at): (&Joint, &[DVec3])| {
            (self.turn * joint.rest, difference(at, joint.change), joint.strength)
        };
        let turn = rotation(self.joints.iter().zip(self.bent.windows(3)).map(turned));
        self.turn = (turn * self.turn).normalize();
        wanted.copy_from_slice(&self.bent);
    }

    /// Turns `Q` as the rope has turned in a step, as it will in the next.
    pub(crate) fn carry(&mut self, before: &[DVec3], nodes: &[DVec3]) {
        let moved = |((joint, before), at): ((&Joint, &[DVec3]), &[DVec3])| {
            (difference(before, joint.change), difference(at, joint.change), joint.strength)
        };
        let turn = rotation(self.joints.iter().zip(before.windows(3)).zip(nodes.windows(3)).map(moved));
        self.turn = (turn * self.turn).normalize();
    }

    /// The shape that `wanted` becomes, with `Q` as it is.
    fn solve(&mut self, wanted: &[DVec3]) {
        self.moves.fill(DVec3::ZERO);
        for (j, (joint, at)) in self.joints.iter().zip(wanted.windows(3)).enumerate() {
            let force = (self.turn * joint.rest - difference(at, joint.change)) * joint.strength;
            for k in 0..3 {
                if let Some(node) = (j + k).checked_sub(1) {
                    self.moves[node] += force * joint.change[k];
                }
            }
        }
        self.matrix.solve(&mut self.moves);
        self.bent.clear();
        self.bent.push(wanted[0]);
        self.bent.extend(wanted[1..].iter().zip(&self.moves).map(|(node, moved)| *node + *moved));
    }
}

/// Towards the rotation that turns vectors `a` to vectors `b` best: a step of Newton's method for the largest `Σ w (Q a)·b`. In
/// place of the second derivative it has `Σ w |a| |b| (1 − (â âᵀ + b̂ b̂ᵀ) / 2)`, the same where they agree and never less,
/// so that the sum never falls.
fn rotation(triples: impl Iterator<Item = (DVec3, DVec3, f64)>) -> DQuat {
    let (mut slope, mut bound, mut along) = (DVec3::ZERO, 0.0, DMat3::ZERO);
    for (a, b, weight) in triples {
        let [long, other] = [a.length_squared(), b.length_squared()];
        if long > 0.0 && other > 0.0 {
            let product = (long * other).sqrt();
            slope += a.cross(b) * weight;
            bound += product * weight;
            along += (outer(a, a) * (product / long) + outer(b, b) * (product / other)) * (0.5 * weight);
        }
    }
    if bound <= 0.0 {
        return DQuat::IDENTITY;
    }
    let curvature = DMat3::from_diagonal(DVec3::splat(bound * (1.0 + LOOSE))) - along;
    let half = curvature.inverse() * slope * 0.5;
    // Overflow, by accelerations of 1e30, turns nothing.
    if half.is_finite() { DQuat::from_xyzw(half.x, half.y, half.z, 1.0).normalize() } else { DQuat::IDENTITY }
}

/// The difference of the directions of two links through three nodes.
fn difference(nodes: &[DVec3], change: [f64; 3]) -> DVec3 {
    nodes[0] * change[0] + nodes[1] * change[1] + nodes[2] * change[2]
}

/// A symmetric positive definite matrix with two diagonals beside the main one, as `L D Lᵀ`.
#[derive(Clone, Debug)]
struct Banded {
    /// `1 / D`, and `L` one and two to the left of the diagonal.
    rows: Vec<[f64; 3]>,
}

impl Banded {
    /// Masses on the diagonal and what the joints add; row `i` is node `i + 1`.
    fn new(masses: &[f64], joints: &[Joint]) -> Self {
        let mut rows: Vec<[f64; 3]> = masses.iter().map(|&mass| [mass, 0.0, 0.0]).collect();
        for (j, joint) in joints.iter().enumerate() {
            for k in 0..3 {
                let Some(row) = (j + k).checked_sub(1) else { continue };
                for (beside, entry) in rows[row].iter_mut().enumerate().take(k.min(row) + 1) {
                    *entry += joint.strength * joint.change[k] * joint.change[k - beside];
                }
            }
        }
        for i in 0..rows.len() {
            let before = |n: usize| i.checked_sub(n).map_or([0.0; 3], |i| rows[i]);
            let ([one_inverse, one_left, _], [two_inverse, ..]) = (before(1), before(2));
            let [mut diagonal, mut one, mut two] = rows[i];
            // `two` and `one` are L D until they are divided.
            one -= two * one_left;
            diagonal -= two * two * two_inverse + one * one * one_inverse;
            (two, one) = (two * two_inverse, one * one_inverse);
            rows[i] = [diagonal.recip(), one, two];
        }
        Self { rows }
    }

    fn solve(&self, values: &mut [DVec3]) {
        for (i, [_, one, two]) in self.rows.iter().enumerate() {
            if i > 0 {
                values[i] -= values[i - 1] * *one;
            }
            if i > 1 {
                values[i] -= values[i - 2] * *two;
            }
        }
        for i in (0..values.len()).rev() {
            values[i] *= self.rows[i][0];
            if let Some([_, one, _]) = self.rows.get(i + 1) {
                values[i] -= values[i + 1] * *one;
            }
            if let Some([_, _, two]) = self.rows.get(i + 2) {
                values[i] -= values[i + 2] * *two;
            }
        }
    }
}

#[cfg(test)]
#[path = "bending_tests.rs"]
mod tests;
