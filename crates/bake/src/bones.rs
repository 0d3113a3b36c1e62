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

/// Takes joints frame after frame.
#[derive(Clone, Debug)]
pub struct BoneBaker {
    times: Vec<f32>,
    bones: Vec<Bone>,
    tracks: Vec<JointTrack>,
}

impl BoneBaker {
    /// For these joints, each behind the one that it hangs on.
    pub fn new(bones: &[Bone]) -> Self {
        let track = |bone: &Bone| JointTrack { node: bone.node, ..JointTrack::default() };
        Self { times: Vec::new(), bones: bones.to_vec(), tracks: bones.iter().map(track).collect() }
    }

    /// Takes the next frame: its time in seconds, where that is on which a node hangs whose joint has no parent in the list, and where each
    /// joint is to be.
    ///
    /// # Errors
    ///
    /// As many transforms as there are no joints; one without an inverse to start from, or that is not finite; times that do not rise;
    /// a joint before the one that it hangs on.
    pub fn push(
        &mut self,
        time: f64,
        outside: impl Fn(usize) -> World,
        joints: &[World],
    ) -> Result<(), BakeError> {
        let frame = self.times.len();
        let fault = |problem| Err(BakeError::Frame { frame, problem });
        if joints.len() != self.tracks.len() {
            return fault("has another number of joints");
        }
        let time = time as f32;
        if !(time.is_finite() && self.times.last().is_none_or(|last| *last < time)) {
            return fault("does not come after the one before it");
        }
        let mut made: Vec<DAffine3> = Vec::with_capacity(joints.len());
        let mut all = Vec::with_capacity(joints.len());
        for (bone, joint) in self.bones.iter().zip(joints) {
            let above = match bone.parent.map(|parent| made.get(parent)) {
                None => affine(&outside(bone.node)),
                Some(Some(above)) => *above,
                Some(None) => return fault("has a joint before the one that it hangs on"),
            };
            let inverse = above.inverse();
            let local = inverse * affine(joint);
            if !(inverse.is_finite() && local.is_finite()) {
                return fault("has a joint whose transform has no inverse or is not finite");
            }
            let (rotation, scale) = parts(local.matrix3);
            made.push(above * DAffine3::from_scale_rotation_translation(scale, rotation, local.translation));
            all.push((local.translation, rotation, scale));
        }
        for (track, (translation, rotation, scale)) in self.tracks.iter_mut().zip(all) {
            track.translations.push(translation.as_vec3().to_array());
            track.rotations.push(rotation.as_quat().to_array());
            track.scales.push(scale.as_vec3().to_array());
        }
        self.times.push(time);
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
