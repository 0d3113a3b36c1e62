//! `bend: Transport`: the rotation between frames carried along `R` and `W` without turning about the tangent
//! (rotation minimising frames), from `u = 0` on.
//!
//! Within a segment the frame is carried by many steps of the double reflection (Wang, Jüttler, Zheng, Liu 2008,
//! "Computation of Rotation Minimizing Frames"; its error falls with the fourth power of the step); at a joint it is
//! turned by the least rotation between the tangents of both sides, and exactly at the joint by half of that. With
//! `A(u)` the rotation of a curve's frame since `u = 0`, the bend at `p` is
//! `B(p) = A_W(p′) · B(0) · A_R(p)⁻¹`, where `B(0)` is the least rotation from `R′(0)` to `W′(0)`.
//! Its rotation vector is followed from `u = 0`, the nearest branch at each step, so that its angle may pass π.

use crate::curve::{Place, at, direction, one_sided_direction, segment_count};
use crate::length::Lengths;
use crate::rotation::{continued, least, quat};
use glam::{DQuat, DVec3};
use wirework_core::Curve;

/// Double reflections a segment, at least.
const STEPS: usize = 256;

/// A step over which the tangent turns by more (radians) is halved, but
const TURN: f64 = 0.02;

/// no more often than this: what is left is a cusp, and a corner.
const HALVINGS: usize = 24;

/// The rotation vector is followed over as many even steps a segment, and over all that were halved.
const STATIONS: usize = 256;

/// Steps in which the turn at a corner is followed.
const CORNER_STEPS: usize = 16;

/// The turning of one curve's frame.
#[derive(Clone, Debug)]
pub(crate) struct Turning {
    curve: Curve,
    /// Of each segment, by rising `t` from 0 to 1.
    nodes: Vec<Vec<Node>>,
    /// Of each joint, the rotation vector from its left to its right tangent.
    corners: Vec<DVec3>,
    /// The tangent at `u = 0`.
    start: DVec3,
}

/// The frame at one place within a segment.
#[derive(Clone, Copy, Debug)]
struct Node {
    t: f64,
    /// Since `u = 0`.
    rotation: DQuat,
    /// The unit tangent; where the curve stands still the one before.
    tangent: DVec3,
}

/// Where on a curve a frame is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Spot {
    /// Within a segment, its ends included: there the frame of that side.
    Inside(Place),
    /// At a joint, by number, with this part of the corner's turn made.
    Corner(usize, f64),
}

impl Turning {
    pub(crate) fn new(curve: &Curve) -> Self {
        let n = segment_count(curve);
        let raw = |segment, t| one_sided_direction(curve, Place { segment, t });
        // A zero tangent is passed over: the frame waits for the next direction.
        let mut all = (0..n).flat_map(|s| (0..=STEPS).map(move |i| (s, i as f64 / STEPS as f64)));
        let first = all.find_map(|(s, t)| Some(raw(s, t)).filter(|t| *t != DVec3::ZERO)).unwrap_or_default();
        let mean = direction(curve, Place { segment: 0, t: 0.0 });
        let start = if mean == DVec3::ZERO { first } else { mean };
        let mut turning = Self { curve: curve.clone(), nodes: Vec::new(), corners: Vec::new(), start };
        let (mut rotation, mut tangent) = (DQuat::IDENTITY, start);
        for segment in 0..n {
            let right = Some(raw(segment, 0.0)).filter(|t| *t != DVec3::ZERO).unwrap_or(tangent);
            let corner = least(tangent, right);
            turning.corners.push(corner);
            let mut nodes = vec![Node { t: 0.0, rotation: quat(corner) * rotation, tangent: right }];
            for i in 1..=STEPS {
                turning.advance(segment, &mut nodes, i as f64 / STEPS as f64, HALVINGS);
            }
            (rotation, tangent) = (nodes[nodes.len() - 1].rotation, nodes[nodes.len() - 1].tangent);
            turning.nodes.push(nodes);
        }
        turning
    }

    /// Adds the node at `t`, and others before it where the tangent turns fast.
    fn advance(&self, segment: usize, nodes: &mut Vec<Node>, t: f64, halvings: usize) {
        let last = nodes[nodes.len() - 1];
        let next = self.step(segment, last, t);
        if halvings > 0 && least(last.tangent, next.tangent).length() > TURN {
            self.advance(segment, nodes, 0.5 * (last.t + t), halvings - 1);
            self.advance(segment, nodes, t, halvings - 1);
        } else {
            nodes.push(next);
        }
    }

    /// The node at `t`, one double reflection on from another.
    fn step(&self, segment: usize, from: Node, t: f64) -> Node {
        let next = one_sided_direction(&self.curve, Place { segment, t });
        if next == DVec3::ZERO || t == from.t {
            return Node { t, ..from };
        }
        let place = |t| at(&self.curve, Place { segment, t });
        let turn = double_reflection(place(t) - place(from.t), from.tangent, next);
        Node { t, rotation: (turn * from.rotation).normalize(), tangent: next }
    }

    fn end(&self, segment: usize) -> DQuat {
        self.nodes[segment][self.nodes[segment].len() - 1].rotation
    }

    /// Where the rotation vector must be looked at, in segments from the start.
    fn stations(&self) -> impl Iterator<Item = f64> {
        let even = |t: f64| (t * STATIONS as f64).fract() == 0.0;
        let halved = |t: f64| (t * STEPS as f64).fract() != 0.0;
        let of_segment = move |(segment, nodes): (usize, &Vec<Node>)| {
            let places = nodes.iter().map(|n| n.t).filter(move |&t| t < 1.0 && (even(t) || halved(t)));
            places.map(move |t| segment as f64 + t).collect::<Vec<_>>()
        };
        self.nodes.iter().enumerate().flat_map(of_segment)
    }

    /// The rotation of the frame since `u = 0`.
    pub(crate) fn rotation(&self, spot: Spot) -> DQuat {
        match spot {
            Spot::Inside(Place { segment, t }) => {
                let nodes = &self.nodes[segment];
                let before = nodes.partition_point(|n| n.t <= t).max(1) - 1;
                self.step(segment, nodes[before], t).rotation
            }
            // The start of a closed curve is its mean tangent: only the second half of that corner is turned.
            Spot::Corner(0, part) => quat(self.corners[0] * (2.0 * part - 1.0).max(0.0)),
            Spot::Corner(joint, part) => match self.corners.get(joint) {
                Some(&corner) => quat(corner * part) * self.end(joint - 1),
                None => self.end(joint - 1),
            },
        }
    }
}

/// The rotation that carries a frame with tangent `from` along `chord` to the tangent `to`: a reflection in the plane
/// that halves the chord, and one in the plane that halves the reflected tangent and `to`.
fn double_reflection(chord: DVec3, from: DVec3, to: DVec3) -> DQuat {
    let first = chord.normalize_or_zero();
    let reflected = from - 2.0 * from.dot(first) * first;
    let second = (to - reflected).normalize_or_zero();
    if first == DVec3::ZERO || second == DVec3::ZERO || from.dot(to) <= 0.0 {
        // No chord, or a cusp inside the step.
        return quat(least(from, to));
    }
    let axis = second.cross(first);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, -second.dot(first)).normalize()
}

/// The bend of a wire along its whole length.
#[derive(Clone, Debug)]
pub(crate) struct Transport {
    reference: Turning,
    pose: Turning,
    lengths: Option<(Lengths, Lengths)>,
    /// Whether one of the curves has no tangent anywhere: no rotation.
    still: bool,
    start: DQuat,
    /// By rising parameter of `R` in segments: the rotation vector there.
    stations: Vec<(f64, DVec3)>,
}

impl Transport {
    /// `lengths`, of `R` and `W`, for the correspondence by arc length.
    pub(crate) fn new(reference: &Curve, pose: &Curve, lengths: Option<(Lengths, Lengths)>) -> Self {
        let (reference, pose) = (Turning::new(reference), Turning::new(pose));
        let first = least(reference.start, pose.start);
        let still = reference.start == DVec3::ZERO || pose.start == DVec3::ZERO;
        let mut bend =
            Self { reference, pose, lengths, still, start: quat(first), stations: vec![(0.0, first)] };
        let mut vector = first;
        for (x, r, w) in bend.path() {
            vector = continued(bend.bend(r, w), vector);
            bend.stations.push((x, vector));
        }
        bend
    }

    /// The rotation vector of the bend at a place of `R`.
    pub(crate) fn vector(&self, place: Place, partner: Place) -> DVec3 {
        if self.still {
            return DVec3::ZERO;
        }
        let x = place.segment as f64 + place.t;
        let (r, w) = (spot(&self.reference.curve, place), spot(&self.pose.curve, partner));
        // Up to a corner only its first half counts.
        let after = self.stations.partition_point(|s| s.0 < x);
        let at_x = self.stations[after..].iter().take_while(|s| s.0 == x).count();
        let near = (after + at_x / 2).saturating_sub(usize::from(at_x == 0));
        continued(self.bend(r, w), self.stations[near.min(self.stations.len() - 1)].1)
    }

    fn bend(&self, r: Spot, w: Spot) -> DQuat {
        self.pose.rotation(w) * self.start * self.reference.rotation(r).conjugate()
    }

    /// The way along `R`, with the places on `W` that belong to it: station after station within the segments, and
    /// step after step through the corners of either curve.
    fn path(&self) -> Vec<(f64, Spot, Spot)> {
        let (r, w) = (&self.reference.curve, &self.pose.curve);
        let n = segment_count(r);
        let mut places: Vec<f64> = self.reference.stations().chain([n as f64]).collect();
        match &self.lengths {
            None => places.extend(self.pose.stations()),
            Some((of_r, of_w)) => {
                // Joints and fast turns of W; where R has a joint at the same place it is there already.
                let on_w = self.pose.stations().map(|x| Place { segment: x as usize, t: x.fract() });
                let back = on_w.filter_map(|place| of_r.place(of_w.fraction(place)));
                let clear = |x: &f64| (x - x.round()).abs() > 2e-6;
                places.extend(back.map(|place| place.segment as f64 + place.t).filter(clear));
            }
        }
        places.sort_by(f64::total_cmp);
        places.dedup();
        let mut path = Vec::new();
        for x in places {
            let segment = (x.floor() as usize).min(n - 1);
            let place = Place { segment, t: x - segment as f64 };
            let partner = partner(self.lengths.as_ref(), place);
            let (jr, jw) = (joint_number(r, place), joint_number(w, partner));
            for i in 0..=CORNER_STEPS {
                let part = i as f64 / CORNER_STEPS as f64;
                let spot = |joint: Option<usize>, place| {
                    joint.map_or(Spot::Inside(place), |j| Spot::Corner(j, part))
                };
                path.push((x, spot(jr, place), spot(jw, partner)));
                if jr.is_none() && jw.is_none() {
                    break;
                }
            }
        }
        path
    }
}

/// The place on `W` that belongs to one on `R`: the same, or the one at the same fraction of the length.
pub(crate) fn partner(lengths: Option<&(Lengths, Lengths)>, place: Place) -> Place {
    lengths.and_then(|(r, w)| (r.total() > 0.0).then(|| w.place(r.fraction(place)))?).unwrap_or(place)
}

/// A joint stands for half of its corner, one whose sides cancel for the end of the side before it.
fn spot(curve: &Curve, place: Place) -> Spot {
    match joint_number(curve, place) {
        Some(joint) if direction(curve, place) == DVec3::ZERO => Spot::Corner(joint, 0.0),
        Some(joint) => Spot::Corner(joint, 0.5),
        None => Spot::Inside(place),
    }
}

/// The number of the joint at a place; the end of a curve is the joint after its last segment.
fn joint_number(curve: &Curve, place: Place) -> Option<usize> {
    place.joint(curve)?;
    Some(place.segment + usize::from(place.t == 1.0))
}
