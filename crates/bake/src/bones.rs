//! Joints that hang on each other, frame after frame, as tracks of translation, rotation and scale.
//!
//! A joint is to be where an affine map takes it, with what hangs on it stretched along a bone and scaled across it; an engine puts it
//! there by the products of translations, rotations and scales along its own axes from the root on. These make no shear: where a joint's
//! axes do not lie along the bone, or one before it is scaled unevenly, the nearest that there is is taken, and joints after it start from
//! that, so that faults do not add up.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use wirework_asset::{Clip, Gltf, JointTrack, Tracks};

use crate::BakeError;

/// A transform in the world: its columns x, y and z, and where it is.
pub type World = [[f64; 3]; 4];

/// Rounds of finding rotation and scale by turns; the error falls by more than half in each.
const ROUNDS: usize = 24;

/// A joint that gets tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bone {
    /// Its node.
    pub node: usize,
    /// The joint that it hangs on, one before it in the list; none for one that hangs on what is outside.
    pub parent: Option<usize>,
}

/// Where an engine puts joints at a moment.
#[derive(Clone, Debug)]
pub struct BonePose {
    /// Of each joint its translation, rotation and scale.
    local: Vec<(DVec3, DQuat, DVec3)>,
    /// Where these put it, and where what it hangs on is.
    world: Vec<DAffine3>,
    above: Vec<DAffine3>,
}

impl BonePose {
    /// The nearest that there is to joints at `places`, where `outside` says where that is on which a node hangs whose joint has no parent
    /// among `bones`. Each of these comes behind the one that it hangs on; `frame` is for errors alone.
    ///
    /// # Errors
    ///
    /// As many places as there are no joints; one without an inverse to start from, or that is not finite; a joint before the one that it
    /// hangs on.
    pub fn new(
        bones: &[Bone],
        frame: usize,
        outside: impl Fn(usize) -> World,
        places: &[World],
    ) -> Result<Self, BakeError> {
        let fault = |problem| Err(BakeError::Frame { frame, problem });
        if places.len() != bones.len() {
            return fault("has another number of joints");
        }
        let mut new = Self { local: Vec::new(), world: Vec::new(), above: Vec::new() };
        for (bone, place) in bones.iter().zip(places) {
            let above = match bone.parent.map(|parent| new.world.get(parent)) {
                None => affine(&outside(bone.node)),
                Some(Some(above)) => *above,
                Some(None) => return fault("has a joint before the one that it hangs on"),
            };
            let inverse = above.inverse();
            let local = inverse * affine(place);
            if !(inverse.is_finite() && local.is_finite()) {
                return fault("has a joint whose transform has no inverse or is not finite");
            }
            let (rotation, scale) = parts(local.matrix3);
            new.push(above, (local.translation, rotation, scale));
        }
        Ok(new)
    }

    fn push(&mut self, above: DAffine3, local: (DVec3, DQuat, DVec3)) {
        let (translation, rotation, scale) = local;
        self.world.push(above * DAffine3::from_scale_rotation_translation(scale, rotation, translation));
        self.above.push(above);
        self.local.push(local);
    }

    /// How far what hangs within `reach` of a joint, metres, is from where this pose has it when an engine goes `part` of the way from one
    /// pose of `bones` to another: 0 ..= 1.
    pub fn off(&self, bones: &[Bone], (from, to): (&Self, &Self), part: f64, reach: f64) -> f64 {
        let mut way = Self { local: Vec::new(), world: Vec::new(), above: Vec::new() };
        let mut most = 0.0_f64;
        for (k, bone) in bones.iter().enumerate() {
            let ((t0, r0, s0), (t1, r1, s1)) = (from.local[k], to.local[k]);
            // Nothing is known of what is outside but where it is now.
            let above = bone.parent.map_or(self.above[k], |parent| way.world[parent]);
            way.push(above, (t0.lerp(t1, part), r0.slerp(r1, part), s0.lerp(s1, part)));
            let at = self.world[k].translation;
            most = most.max(way.world[k].translation.distance(at));
            let moved = way.world[k] * self.world[k].inverse();
            if moved.is_finite() {
                let steps = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
                most = steps
                    .map(|step| at + step * reach)
                    .fold(most, |most, p| most.max(moved.transform_point3(p).distance(p)));
            }
        }
        most
    }
}

/// Takes joints frame after frame.
#[derive(Clone, Debug)]
pub struct BoneBaker {
    times: Vec<f32>,
    /// The last time as it was given.
    last: f64,
    tracks: Vec<JointTrack>,
}

impl BoneBaker {
    /// For these joints, each behind the one that it hangs on.
    pub fn new(bones: &[Bone]) -> Self {
        let track = |bone: &Bone| JointTrack { node: bone.node, ..JointTrack::default() };
        Self { times: Vec::new(), last: f64::NEG_INFINITY, tracks: bones.iter().map(track).collect() }
    }

    /// The times that have been taken, seconds.
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    /// Takes the next pose of the joints, and its time in seconds. Files keep times in 32 bits: of two that are closer than that the later one
    /// comes as soon as may be.
    ///
    /// # Errors
    ///
    /// A time that does not come after the one before it; a pose of another number of joints.
    pub fn push(&mut self, time: f64, pose: &BonePose) -> Result<(), BakeError> {
        let fault = |problem| Err(BakeError::Frame { frame: self.times.len(), problem });
        if pose.local.len() != self.tracks.len() {
            return fault("has another number of joints");
        }
        let key = self.times.last().map_or(time as f32, |last| (time as f32).max(last.next_up()));
        if !(key.is_finite() && self.last < time) {
            return fault("does not come after the one before it");
        }
        self.last = time;
        for (track, (translation, rotation, scale)) in self.tracks.iter_mut().zip(&pose.local) {
            track.translations.push(translation.as_vec3().to_array());
            track.rotations.push(rotation.as_quat().to_array());
            track.scales.push(scale.as_vec3().to_array());
        }
        self.times.push(key);
        Ok(())
    }

    /// Adds the tracks to a document, in `clip` or a new one, which gets the channels of `source` besides. Gives the index of the
    /// clip; none where nothing moves.
    ///
    /// # Errors
    ///
    /// As [`Gltf::add_tracks`].
    pub fn finish(
        self,
        gltf: &mut Gltf,
        clip: Option<Clip>,
        source: Option<usize>,
    ) -> Result<Option<usize>, BakeError> {
        let clip = clip.unwrap_or_else(|| Clip::New(gltf.unused_clip_name("wirework")));
        let tracks = Tracks { times: &self.times, joints: &self.tracks, source, ..Tracks::default() };
        Ok(gltf.add_tracks(&clip, &tracks)?)
    }
}

fn affine(world: &World) -> DAffine3 {
    let [x, y, z, w] = world.map(DVec3::from_array);
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), w)
}

/// The rotation and the scale whose product is nearest to a matrix.
fn parts(matrix: DMat3) -> (DQuat, DVec3) {
    let column = |m: &DMat3| [m.x_axis, m.y_axis, m.z_axis];
    let mut scale = DVec3::from_array(column(&matrix).map(DVec3::length));
    if matrix.determinant() < 0.0 {
        scale = -scale;
    }
    let mut rotation = DQuat::IDENTITY;
    for _ in 0..ROUNDS {
        // Of a scale the best rotation, of a rotation the best scale.
        rotation = nearest_rotation(matrix * DMat3::from_diagonal(scale), rotation);
        let back = DMat3::from_quat(rotation.inverse()) * matrix;
        scale = DVec3::new(back.x_axis.x, back.y_axis.y, back.z_axis.z);
    }
    (rotation, scale)
}

/// The rotation nearest to a matrix, from a guess: Müller, Bender, Chentanez and Macklin, "A robust method to extract the rotational
/// part of deformations", MIG 2016.
fn nearest_rotation(matrix: DMat3, guess: DQuat) -> DQuat {
    let mut rotation = guess;
    for _ in 0..64 {
        let turned = DMat3::from_quat(rotation);
        let pairs =
            [(turned.x_axis, matrix.x_axis), (turned.y_axis, matrix.y_axis), (turned.z_axis, matrix.z_axis)];
        let torque: DVec3 = pairs.iter().map(|(a, b)| a.cross(*b)).sum();
        let along: f64 = pairs.iter().map(|(a, b)| a.dot(*b)).sum();
        let turn = torque / (along.abs() + 1e-300);
        if !turn.is_finite() || turn.length() < 1e-13 {
            break;
        }
        rotation = (DQuat::from_scaled_axis(turn) * rotation).normalize();
    }
    rotation
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turns() -> impl Iterator<Item = DQuat> {
        (0..60).map(|i| {
            let axis = DVec3::new(f64::from(i % 5) - 2.0, f64::from(i % 7) - 3.1, f64::from(i % 3) - 0.9);
            DQuat::from_scaled_axis(axis.normalize() * f64::from(i) * 0.05)
        })
    }

    #[test]
    fn what_has_parts_gets_them() {
        for turn in turns() {
            for scale in [DVec3::ONE, DVec3::new(0.5, 2.0, 0.7), DVec3::new(-1.0, -1.2, -0.8)] {
                let matrix = DMat3::from_quat(turn) * DMat3::from_diagonal(scale);
                let (rotation, found) = parts(matrix);
                let made = DMat3::from_quat(rotation) * DMat3::from_diagonal(found);
                assert!(
                    (made - matrix).to_cols_array().iter().all(|c| c.abs() < 1e-9),
                    "{turn} {scale} {found}"
                );
            }
        }
    }

    #[test]
    fn what_is_sheared_gets_the_nearest() {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::new(0.0, -0.2, 1.1));
        for turn in turns() {
            let matrix = DMat3::from_quat(turn) * shear;
            let (rotation, scale) = parts(matrix);
            let miss = |rotation: DQuat, scale: DVec3| {
                let made = DMat3::from_quat(rotation) * DMat3::from_diagonal(scale);
                (made - matrix).to_cols_array().iter().map(|c| c * c).sum::<f64>()
            };
            let own = miss(rotation, scale);
            for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                for step in [-1e-3, 1e-3] {
                    assert!(miss(DQuat::from_scaled_axis(axis * step) * rotation, scale) >= own - 1e-12);
                    let mut other = scale;
                    other[k] += step;
                    assert!(miss(rotation, other) >= own - 1e-12);
                }
            }
        }
    }
}
