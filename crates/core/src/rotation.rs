//! Rotations in float64: the least one between two directions, frames transported along a curve, and the continued
//! rotation vector of `bend: Transport`.

use glam::{DQuat, DVec3};

use crate::spans::{Cubic, Spans};

/// Directions count as opposite when the sine of their angle is below this: float32 control points of a reversed curve
/// are no more exact, and the axis would be noise.
pub(crate) const OPPOSITE: f64 = 1e-6;

/// The tangent turns by at most about this (radians) in one step of transport; the error of a step is of fifth order.
const TURN: f64 = 0.1;

/// At a cusp, where the tangent turns at once, a step is halved this often and then taken as a corner.
const DEPTH: u32 = 12;

/// The axis about which `a` turns into `−a`: perpendicular to it, and made with the coordinate axis least aligned with
/// it, the first of equals.
pub(crate) fn fixed_perpendicular(a: DVec3) -> DVec3 {
    let m = a.abs();
    let axis = if m.x <= m.y && m.x <= m.z {
        DVec3::X
    } else if m.y <= m.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    a.cross(axis).normalize_or_zero()
}

/// The least rotation of unit vector `a` to unit vector `b`; the identity where one is zero.
pub(crate) fn least_rotation(a: DVec3, b: DVec3) -> DQuat {
    if a == DVec3::ZERO || b == DVec3::ZERO {
        return DQuat::IDENTITY;
    }
    let (cross, dot) = (a.cross(b), a.dot(b));
    let sine = cross.length();
    if sine < OPPOSITE && dot < 0.0 {
        return DQuat::from_axis_angle(fixed_perpendicular(a), std::f64::consts::PI);
    }
    if sine == 0.0 {
        return DQuat::IDENTITY;
    }
    DQuat::from_axis_angle(cross / sine, sine.atan2(dot))
}

/// The rotation that carries a frame along a segment from `t0` to `t1` without turning about the tangent.
///
/// The frame turns by `R′×R″/‖R′‖²` a unit of `t`; a step is Magnus' expansion of fourth order at Gauss' two points,
/// then made to end at the tangent exactly.
pub(crate) fn transport(cubic: &Cubic, t0: f64, t1: f64) -> DQuat {
    transport_step(cubic, t0, t1, DEPTH)
}

fn transport_step(cubic: &Cubic, t0: f64, t1: f64, depth: u32) -> DQuat {
    let (a, b) = (cubic.tangent(t0), cubic.tangent(t1));
    let middle = 0.5 * (t0 + t1);
    let m = cubic.tangent(middle);
    let turning = |p: DVec3, q: DVec3| p.cross(q).length() > TURN * 0.5 || p.dot(q) < 0.5;
    if depth > 0 && (turning(a, m) || turning(m, b)) {
        let first = transport_step(cubic, t0, middle, depth - 1);
        return transport_step(cubic, middle, t1, depth - 1) * first;
    }
    let [w1, w2] = [-0.5, 0.5].map(|x| angular_velocity(cubic, middle + x * (t1 - t0) / 3.0_f64.sqrt()));
    let h = t1 - t0;
    let magnus = 0.5 * h * (w1 + w2) + 3.0_f64.sqrt() / 12.0 * h * h * w2.cross(w1);
    let step = if magnus.is_finite() && magnus.length() < 1.0 {
        DQuat::from_scaled_axis(magnus)
    } else {
        DQuat::IDENTITY
    };
    least_rotation((step * a).normalize_or_zero(), b) * step
}

fn angular_velocity(cubic: &Cubic, t: f64) -> DVec3 {
    let first = cubic.derivative(t);
    let second = 2.0 * cubic.0[2] + 6.0 * t * cubic.0[3];
    first.cross(second) / first.length_squared()
}

/// A frame that moves along a curve, as the rotation from its start.
#[derive(Clone)]
pub(crate) struct Traveller<'a> {
    spans: &'a Spans,
    place: (usize, f64),
    /// The rotation from the start to the present place.
    pub(crate) rotation: DQuat,
    /// The last tangent that was not zero.
    pub(crate) tangent: DVec3,
}

impl<'a> Traveller<'a> {
    /// Starts at `u = 0`; where the curve stands still there, with the first direction it takes.
    pub(crate) fn new(spans: &'a Spans) -> Self {
        let moving =
            |c: &Cubic| [0.0, 1e-3, 0.5].map(|t| c.tangent(t)).into_iter().find(|t| *t != DVec3::ZERO);
        let start = Some(spans.joint_tangent(0)).filter(|t| *t != DVec3::ZERO);
        let tangent = start.or_else(|| spans.cubics.iter().find_map(moving)).unwrap_or_default();
        Self { spans, place: (0, 0.0), rotation: DQuat::IDENTITY, tangent }
    }

    /// Moves on to place `t` of segment `span`, which may not lie behind. At a joint, `(span, 1)` is the side before it
    /// and `(span + 1, 0)` the side after it.
    pub(crate) fn travel(&mut self, span: usize, t: f64) {
        while self.place.0 < span {
            self.travel_in_segment(1.0);
            self.place = (self.place.0 + 1, 0.0);
            self.turn_to(self.spans.cubics[self.place.0].tangent(0.0));
        }
        self.travel_in_segment(t);
    }

    /// Goes to the end of the present segment; the rotation vector of the corner from there into segment `next`. At the
    /// start of a closed curve, from the mean tangent into the first segment.
    pub(crate) fn corner(&mut self, next: usize) -> DVec3 {
        if next < self.place.0 || (next == self.place.0 && self.place.1 > 0.0) {
            return DVec3::ZERO;
        }
        if next > self.place.0 {
            self.travel_in_segment(1.0);
        }
        least_rotation(self.tangent, self.spans.cubics[next].tangent(0.0)).to_scaled_axis()
    }

    fn travel_in_segment(&mut self, t: f64) {
        let (span, from) = self.place;
        let cubic = &self.spans.cubics[span];
        self.turn_to(cubic.tangent(from));
        if t <= from {
            return;
        }
        let end = cubic.tangent(t);
        self.rotation = transport(cubic, from, t) * self.rotation;
        if end != DVec3::ZERO {
            self.tangent = end;
        }
        self.place = (span, t);
    }

    fn turn_to(&mut self, tangent: DVec3) {
        if tangent != DVec3::ZERO {
            self.rotation = (least_rotation(self.tangent, tangent) * self.rotation).normalize();
            self.tangent = tangent;
        }
    }
}

/// The rotation vector of `q` nearest to `before`: of all angles that mean the same rotation the one that continues.
pub(crate) fn continued_vector(q: DQuat, before: DVec3) -> DVec3 {
    const TURN: f64 = std::f64::consts::TAU;
    let v = DVec3::new(q.x, q.y, q.z);
    let sine = v.length();
    let mut axis = if sine > 1e-12 { v / sine } else { before.normalize_or_zero() };
    let mut angle = 2.0 * sine.atan2(q.w);
    if axis.dot(before) < 0.0 {
        (axis, angle) = (-axis, -angle);
    }
    // Half a turn away both ways are as near: then the rotation's own axis and angle hold.
    let turns = (before.dot(axis) - angle) / TURN;
    if turns.abs() > 0.5 + 1e-9 {
        angle += TURN * turns.round();
    }
    axis * angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;

    #[test]
    fn the_least_rotation_turns_one_direction_to_the_other() {
        let a = DVec3::new(1.0, 2.0, 3.0).normalize();
        for b in [DVec3::X, -a, a, DVec3::new(-1.0, -2.0, -2.999).normalize()] {
            assert!((least_rotation(a, b) * a).distance(b) < 1e-5, "{b}");
        }
        assert_eq!(least_rotation(a, DVec3::ZERO), DQuat::IDENTITY);
    }

    #[test]
    fn transport_in_a_plane_turns_about_its_normal_and_in_space_converges() {
        let plane =
            Curve::bspline(3, vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
        let spans = Spans::new(&plane);
        let q = transport(&spans.cubics[0], 0.0, 1.0);
        assert!((q * DVec3::Z).distance(DVec3::Z) < 1e-12);
        assert!((q * DVec3::X).distance(-DVec3::X) < 1e-9);

        let space = vec![[0.0; 3], [1.0, 0.0, 0.4], [1.0, 1.0, -1.0], [0.0, 1.0, 2.0]];
        let cubic = Spans::new(&Curve::bspline(3, space).unwrap()).cubics[0];
        let coarse = transport(&cubic, 0.0, 1.0);
        let fine = (0..4096).fold(DQuat::IDENTITY, |q, i| {
            let t = |k: i32| cubic.tangent(f64::from(k) / 4096.0);
            least_rotation(t(i), t(i + 1)) * q
        });
        // The chain of least rotations converges with the square of its step.
        assert!(coarse.angle_between(fine) < 1e-6, "{}", coarse.angle_between(fine));
    }

    #[test]
    fn a_traveller_passes_corners_and_standstills() {
        let corner =
            Curve::polyline(vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]).unwrap();
        let spans = Spans::new(&corner);
        let mut traveller = Traveller::new(&spans);
        traveller.travel(2, 0.5);
        assert!((traveller.rotation * DVec3::X).distance(DVec3::Y) < 1e-12);
        assert!((traveller.rotation * DVec3::Z).distance(DVec3::Z) < 1e-12);
    }

    #[test]
    fn half_a_turn_starts_about_its_axis() {
        for a in [DVec3::X, DVec3::new(0.1, -2.0, 0.3).normalize()] {
            let vector = continued_vector(least_rotation(a, -a), DVec3::ZERO);
            assert!(vector.distance(fixed_perpendicular(a) * std::f64::consts::PI) < 1e-9, "{vector}");
        }
    }

    #[test]
    fn the_angle_goes_on_past_half_and_whole_turns() {
        let axis = DVec3::new(0.0, 0.6, 0.8);
        let mut vector = DVec3::ZERO;
        for i in 0..=200 {
            let angle = f64::from(i) * 0.05;
            vector = continued_vector(DQuat::from_axis_angle(axis, angle), vector);
            assert!(vector.distance(axis * angle) < 1e-9, "{angle}: {vector}");
        }
    }
}
