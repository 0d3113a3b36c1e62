//! The links of a rope, which keep their lengths.
//!
//! A step of position-based dynamics moves the nodes to where they would go freely, `x*`, and from there to the nearest
//! shape of the rope: the `x` that minimises `½ Σ mᵢ |xᵢ − xᵢ*|²` with all links `|xᵢ₊₁ − xᵢ|` as long as they were
//! \[Macklin, Storey, Lu, Terdiman, Chentanez, Jeschke and Müller 2019, Small Steps in Physics Simulation; Goldenthal, Harmon, Fattal, Bercovier
//! and Grinspun 2007, Efficient Simulation of Inextensible Cloth\].
//!
//! A rope has no branches, so Newton's method for that costs one walk up and one down, as for the joints of a robot \[Featherstone 1983\].
//! Walking up, what hangs from a node is summed into how it resists: a force `r − A δ` if the node moves by `δ`. Over a
//! link of direction `d` and tension `μ`, whose lower end may move by `e ⟂ d` against its upper end,
//!
//! ```text
//! (A + γ) e + μ d = r − A δ,   γ = μ / ℓ      so   e = P (r − A δ),   P the inverse of A + γ across d
//! what the upper end feels:  (1 − A P) r − (A − A P A) δ
//! ```
//!
//! `γ` is what a taut link does against turning. With it the result is that of implicit integration: stable however taut the rope
//! and however short its links, where the usual solve for the tensions alone breaks down at a tension of `m ℓ / dt²`.
//!
//! After each walk the links are laid at their lengths again, from the top down, so that the lengths hold to rounding whatever happens.
//!
//! # Notes
//!
//! For a rope of 40 links, 2 m long, that swings for 20 s at 480 steps a second:
//!
//! - One sweep of Gauss-Seidel a step, from the top down, leaves it 3.1 % too long, ten sweeps 0.3 %: a correction travels one link
//!   a sweep. Here it is right to 1e-14.
//! - Laying the links down without the walks \[Müller, Kim and Chentanez 2012\] keeps lengths too, but the rope hardly swings at
//!   all: what hangs from a link does not pull at it.
//! - Without `γ` all is well at 2 m, but 0.2 m swing 1 % too slowly and 0.05 m 31 %, buzzing.

use glam::{DMat3, DVec3};

/// Walks in a step at most. A swing takes 1.2, a pull of 24 lengths a second 2.4 on average, all eight in some steps; the shape is then
/// not quite the nearest one.
const WALKS: usize = 8;
/// A walk that turns no link by more than this, in radians, was the last. What is left is about its square: a hundred thousandth of
/// what gravity moves in a step.
const ARRIVED: f64 = 1e-4;
/// Below this part of its length a link has no direction.
const NO_DIRECTION: f64 = 1e-9;

/// A rope's links, from the top to the free end.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    pub(crate) lengths: Vec<f64>,
    /// Of the nodes; the total is 1.
    pub(crate) masses: Vec<f64>,
    /// The tension of each link times the square of a step, from the last walk.
    tensions: Vec<f64>,
    hanging: Vec<Hanging>,
}

/// What hangs from a link, and how the link lets it move.
#[derive(Clone, Copy, Debug, Default)]
struct Hanging {
    /// `A`
    inertia: DMat3,
    /// `r`
    force: DVec3,
    /// `P`
    give: DMat3,
    /// `d`
    direction: DVec3,
}

impl Links {
    /// Of a rope through `nodes`, at least one, no two neighbours equal. Each link shares its mass, its part of the
    /// length, between its ends.
    pub(crate) fn new(nodes: &[DVec3]) -> Self {
        let lengths: Vec<f64> = nodes.windows(2).map(|pair| (pair[1] - pair[0]).length()).collect();
        let total: f64 = lengths.iter().sum();
        let mut masses = vec![0.0; nodes.len()];
        for (i, length) in lengths.iter().enumerate() {
            masses[i] += 0.5 * length / total;
            masses[i + 1] += 0.5 * length / total;
        }
        let (tensions, hanging) = (vec![0.0; lengths.len()], vec![Hanging::default(); lengths.len()]);
        Self { lengths, masses, tensions, hanging }
    }

    /// Forgets the tensions of earlier steps.
    pub(crate) fn slacken(&mut self) {
        self.tensions.fill(0.0);
    }

    /// Moves `nodes` to the shape nearest to `wanted`; the first stays where it is wanted.
    pub(crate) fn hold(&mut self, wanted: &[DVec3], nodes: &mut [DVec3]) {
        nodes.copy_from_slice(wanted);
        self.lay(nodes);
        for _ in 0..WALKS {
            self.gather(wanted, nodes);
            let moved = self.spread(nodes);
            self.lay(nodes);
            if moved <= ARRIVED {
                break;
            }
        }
    }

    /// Gives each link its length, from the top down, in the direction it has. Where the lengths are right nothing moves by a bit.
    pub(crate) fn lay(&self, nodes: &mut [DVec3]) {
        let (mut above, mut shift, mut direction) = (nodes[0], DVec3::ZERO, DVec3::NEG_Y);
        for (node, length) in nodes[1..].iter_mut().zip(&self.lengths) {
            let edge = *node - above;
            let long = edge.length();
            if long > NO_DIRECTION * length {
                shift += edge * (length / long - 1.0);
                direction = edge / long;
            } else {
                shift += direction * *length - edge;
            }
            above = *node;
            *node += shift;
        }
    }

    /// The walk up: what hangs from each link.
    fn gather(&mut self, wanted: &[DVec3], nodes: &[DVec3]) {
        let (mut inertia, mut force) = (DMat3::ZERO, DVec3::ZERO);
        for i in (0..self.lengths.len()).rev() {
            let mass = self.masses[i + 1];
            inertia += DMat3::from_diagonal(DVec3::splat(mass));
            force += (wanted[i + 1] - nodes[i + 1]) * mass;
            let direction = (nodes[i + 1] - nodes[i]) / self.lengths[i];
            let taut = self.tensions[i].max(0.0) / self.lengths[i];
            let give = inverse_across(inertia + DMat3::from_diagonal(DVec3::splat(taut)), direction);
            self.hanging[i] = Hanging { inertia, force, give, direction };
            let passed = inertia * give;
            force -= passed * force;
            inertia -= passed * inertia;
            // Rounding must not make it unsymmetric: links turn that into a hundred times as much, each.
            inertia = (inertia + inertia.transpose()) * 0.5;
        }
    }

    /// The walk down: moves the nodes, and returns the most that one moved against the one above, in lengths of its link.
    fn spread(&mut self, nodes: &mut [DVec3]) -> f64 {
        let (mut moved, mut most) = (DVec3::ZERO, 0.0_f64);
        for (i, below) in self.hanging.iter().enumerate() {
            let force = below.force - below.inertia * moved;
            let turn = below.give * force;
            let tension = below.direction.dot(force - below.inertia * turn);
            // Overflow, by accelerations of 1e30: what is laid at its lengths is good enough.
            if !(turn.is_finite() && tension.is_finite()) {
                self.tensions.fill(0.0);
                return 0.0;
            }
            self.tensions[i] = tension;
            moved += turn;
            nodes[i + 1] += moved;
            most = most.max(turn.length() / self.lengths[i]);
        }
        most
    }
}

/// The inverse of a symmetric `matrix` in the plane across the unit vector `normal`, zero along it. By the adjugate, not in two axes
/// of the plane, so that it is the same for a mirrored rope.
fn inverse_across(matrix: DMat3, normal: DVec3) -> DMat3 {
    let along = matrix * normal;
    let twice = outer(along, normal) + outer(normal, along);
    let plane = outer(normal, normal);
    let across = matrix - twice + plane * normal.dot(along);
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let determinant =
        normal.dot(DVec3::new(normal.dot(y.cross(z)), normal.dot(z.cross(x)), normal.dot(x.cross(y))));
    let trace = across.x_axis.x + across.y_axis.y + across.z_axis.z;
    ((DMat3::IDENTITY - plane) * trace - across) * determinant.recip()
}

/// `a bᵀ`
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
#[path = "links_tests.rs"]
mod tests;
