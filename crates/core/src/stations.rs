//! What a wire does at places along it, for those who need its frames and not points near it: bones along a limb.

use glam::{DQuat, DVec3};

use crate::arclength::ArcLength;
use crate::attributes::{Attribute, polynomial};
use crate::follow::{Places, Turns};
use crate::rotation::least_rotation;
use crate::spans::{Spans, to_dvec3};
use crate::{Bend, Correspondence, Curve, Wire};

/// What a wire does at one place, where its influence is 1: it takes `P` to `to + rotation·(P − from)·scale`, but for its amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// `R(p)`.
    pub from: [f64; 3],
    /// `W(p′)`.
    pub to: [f64; 3],
    /// The twist about `R′`, then the bend: a unit quaternion, `[x, y, z, w]`.
    pub rotation: [f64; 4],
    /// `s`.
    pub scale: f64,
}

impl Wire {
    /// What the wire does at these parameters of `R`, each clamped to `[0, 1]`. Empty where the pose does not fit the reference.
    pub fn stations(&self, parameters: &[f64]) -> Vec<Station> {
        let reference = &self.reference;
        if self.pose.len() != reference.points().len() {
            return Vec::new();
        }
        let (r, mut w) = (Spans::new(reference), Spans::default());
        w.build(reference.kind(), reference.closed(), self.pose.len(), |i| to_dvec3(self.pose[i]));
        let by_length = self.correspondence == Correspondence::ArcLength;
        let mut places = Places::default();
        if by_length {
            places.build(&r, &ArcLength::new(&r), &w);
        }
        let places = by_length.then_some(&places);
        let mut turns = Turns::default();
        if self.bend == Bend::Transport && r.moves() && w.moves() {
            turns.build(&r, &w, places);
        }
        let station = |&u: &f64| {
            let u = u.clamp(0.0, 1.0);
            let (span, t) = r.locate(u);
            let (w_span, w_t) = places.map_or((span, t), |places| places.at(span as f64 + t, &w));
            let tangent = r.tangent(u);
            let bend = match self.bend {
                _ if !(r.moves() && w.moves()) => DVec3::ZERO,
                Bend::Tangent => least_rotation(tangent, w.tangent_in(w_span, w_t)).to_scaled_axis(),
                Bend::Transport => {
                    let x = span as f64 + t;
                    let vector = if x == x.round() { turns.at_joint(x as usize) } else { turns.at(x) };
                    to_dvec3(vector)
                }
            };
            let own = |attribute| polynomial(self, attribute, u, 1.0, u)[0];
            let bend = DQuat::from_scaled_axis(bend * own(Attribute::Rotation));
            let twist = DQuat::from_scaled_axis(tangent * own(Attribute::Twist));
            Station {
                from: r.cubics[span].at(t).to_array(),
                to: w.cubics[w_span].at(w_t).to_array(),
                rotation: (bend * twist).normalize().to_array(),
                scale: own(Attribute::Scale),
            }
        };
        parameters.iter().map(station).collect()
    }
}

impl Curve {
    /// The arc length from the start of the curve to each of these parameters, which are clamped to `[0, 1]`. In double precision, for
    /// those who compute with differences of them.
    pub fn lengths(&self, parameters: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let spans = Spans::new(self);
        let lengths = ArcLength::new(&spans);
        let length = |u: f64| {
            let (span, t) = spans.locate(u.clamp(0.0, 1.0));
            lengths.at(&spans, span, t)
        };
        parameters.into_iter().map(length).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Binding, Blend, Locator};

    fn wire(bend: Bend, correspondence: Correspondence) -> Wire {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.1, 0.0], [3.0, 0.0, 0.2]];
        let mut wire = Wire::new(Curve::bspline(2, points).unwrap());
        wire.pose = vec![[0.0, 0.1, 0.0], [0.5, 1.0, 0.3], [1.0, 1.4, -0.2], [0.2, 2.2, 0.1]];
        wire.radius = 1e15;
        (wire.bend, wire.correspondence) = (bend, correspondence);
        let locator =
            |u, twist, scale| Locator { u, twist: Some(twist), scale: Some(scale), ..Locator::default() };
        wire.locators = vec![locator(0.0, 0.0, 1.0), locator(0.6, 1.0, 1.5), locator(1.0, 4.0, 0.7)];
        wire
    }

    #[test]
    fn stations_are_what_points_do() {
        for bend in [Bend::Tangent, Bend::Transport] {
            for correspondence in [Correspondence::Parameter, Correspondence::ArcLength] {
                let wire = wire(bend, correspondence);
                // Off joints, and on one.
                let us = [0.03, 0.31, 0.5, 0.77, 0.99];
                let stations = wire.stations(&us);
                let tangents = wire.reference.at(us);
                for (station, (_, tangent)) in stations.iter().zip(tangents) {
                    let across = DVec3::from_array(tangent).any_orthonormal_vector() * 0.05;
                    let p = DVec3::from_array(station.from) + across;
                    let mut out = [p.as_vec3().to_array()];
                    let mut binding = Binding::new(std::slice::from_ref(&wire), &out).unwrap();
                    binding.deform_into(std::slice::from_ref(&wire), &Blend::default(), &mut out).unwrap();
                    let rotation = DQuat::from_array(station.rotation);
                    let expected = DVec3::from_array(station.to) + rotation * across * station.scale;
                    assert!(expected.distance(to_dvec3(out[0])) < 2e-5, "{expected} {:?}", out[0]);
                }
            }
        }
    }

    #[test]
    fn a_point_is_a_curve_without_directions() {
        let mut wire = Wire::new(Curve::polyline(vec![[1.0, 2.0, 3.0]]).unwrap());
        wire.pose = vec![[2.0, 2.0, 3.0]];
        let [station] = wire.stations(&[0.5])[..] else { panic!() };
        assert_eq!((station.from, station.to), ([1.0, 2.0, 3.0], [2.0, 2.0, 3.0]));
        assert_eq!(station.rotation, [0.0, 0.0, 0.0, 1.0]);
        wire.pose.clear();
        assert!(wire.stations(&[0.5]).is_empty());
    }

    #[test]
    fn lengths_add_up() {
        let curve = wire(Bend::Tangent, Correspondence::Parameter).reference;
        let lengths = curve.lengths([-1.0, 0.0, 0.4, 1.0, 2.0]);
        assert_eq!((lengths[0], lengths[1], lengths[3]), (0.0, 0.0, lengths[4]));
        assert!((lengths[3] - f64::from(curve.length())).abs() < 1e-6);
        let steps = curve.at((0..=4000).map(|i| f64::from(i) * 1e-4));
        let sum: f64 =
            steps.windows(2).map(|p| DVec3::from_array(p[0].0).distance(DVec3::from_array(p[1].0))).sum();
        assert!((lengths[2] - sum).abs() < 1e-6);
    }
}
