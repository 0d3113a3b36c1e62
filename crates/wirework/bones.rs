//! Limbs, or wires that only translate, as a skeleton: tracks of joints, which any engine plays, in the place of morph targets.
//!
//! Where the chain is one of the model's own, its joints are taken to where the limb has them: each turned and stretched as the middle of
//! its bone is; or, where there are more joints between them, each as the curve is where it lies. A chain that stands in the
//! preset gets joints made for it ([`rig`]), and so do wires, a joint a control point ([`wires`]). Either way what an engine then shows is compared with the effect itself, at frames and between keys.
//!
//! # Notes
//!
//! What stays however many joints there are: vertices that follow in part, which wires turn by a part of the angle and skins take a
//! part of the way; vertices that hang on four joints already and so on no more than the nearest of two; and, where joints do not pose
//! a vertex alike, as in a rest that is not the pose in which it was bound, that a wire moves the mean of what they make of it and
//! not each of them. With one joint more to a bone the residual may be larger than with none: from the middle of
//! a bone to its end a curve does not turn evenly.

mod keys;
mod rig;
mod wires;

use std::path::Path;
use std::time::Instant;

use glam::{DMat3, DQuat, DVec3};
use wirework_asset::{Clip, Format, Gltf, Rest, printable};
use wirework_bake::{Bone, BoneBaker, BonePose, World};
use wirework_core::{Station, Wire};
use wirework_ik::BoneFrame;
use wirework_preset::{Action, Chain, Effect};

use crate::film::{Film, Product, find_clip, new_clip};
use crate::limbs::Reach;
use crate::output::Scene;
use crate::shade::Vertices;
use crate::{Job, JobError, Progress, Skeleton};
use keys::{PART, straightened};

/// Where between two keys it is looked how far what is played is off: not where it has been looked before, and near to where ways that ease in
/// and out are most.
const BETWEEN: [f64; 2] = [0.22, 0.7];

/// Floats are no more exact than this part of the greatest coordinate, twice over.
const NOISE: f64 = 5e-7;

/// Nothing above a joint.
const WORLD: World = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// A model whose joints limbs move.
struct Rigged {
    gltf: Gltf,
    rest: Rest,
    joints: Vec<Joint>,
    /// How many were made for it.
    made: usize,
    /// Nodes that showed a mesh, and those that show it since it hangs on joints.
    shown: Vec<(usize, usize)>,
}

/// A joint that a limb takes along.
#[derive(Clone, Copy, Debug)]
struct Joint {
    node: usize,
    /// The joint that it hangs on, one before it.
    parent: Option<usize>,
    /// The number of the limb; joints of one are in a row.
    limb: usize,
    by: By,
}

/// How a limb takes a joint along.
#[derive(Clone, Copy, Debug)]
enum By {
    /// It lies on the limb's curve, at this parameter, and has the axes of the world at rest.
    Curve(f64),
    /// It goes where the limb has its bone of this number.
    Bone(usize),
    /// It lies at `step` from the node `own`, and goes where the limb's curve takes what is at the parameter `u`.
    Near { own: usize, step: DVec3, u: f64 },
}

/// A document with joints, and what they do at all times.
struct Animated {
    gltf: Gltf,
    rest: Rest,
    /// Nodes that showed a mesh, and those that show it since it hangs on joints.
    shown: Vec<(usize, usize)>,
    baker: BoneBaker,
    /// What is known of the skeleton so far.
    skeleton: Skeleton,
    warnings: Vec<String>,
}

impl Film<'_> {
    /// A glTF document with tracks of joints; `under` is the clip that poses the model.
    pub(crate) fn skeleton(
        &mut self,
        job: &Job<'_>,
        format: Format,
        scene: Scene,
        under: Option<usize>,
    ) -> Result<Product, JobError> {
        let Scene { gltf, rest, point_of, .. } = scene;
        let (known, clips) = (gltf.warnings().len(), gltf.clip_names().len());
        let before = crate::engines(&gltf);
        let clip = job.into.map(|into| find_clip(&gltf, into).map(Clip::Into)).transpose()?;
        let start = Instant::now();
        let still = rest.clone();
        let animated = if self.motion.evaluation.lone_limbs().is_some() {
            self.limbs(job, gltf, rest, &point_of)
        } else {
            self.wires(job, gltf, &rest, &point_of)
        };
        let Animated { mut gltf, rest, shown, baker, mut skeleton, mut warnings } = animated?;
        let posed = self.motion.evaluation.is_posed();
        let keys: Vec<f64> = baker.times().iter().map(|time| f64::from(*time)).collect();
        let index = baker.finish(&mut gltf, clip, under.filter(|_| posed))?;
        self.write += start.elapsed();
        let from = vertices_from(&still, &rest, &shown);
        self.compare((&gltf, &rest), (index, &keys), (&still, &point_of, &from), &mut skeleton)?;
        let file = printable(gltf.file());
        warnings.extend(gltf.warnings().iter().skip(known).map(|warning| format!("{file}: {warning}")));
        let clip = new_clip(&gltf, clips, under.filter(|_| posed));
        let engines = crate::engines(&gltf);
        let note = engines.note(&before);
        let start = Instant::now();
        let files = gltf.into_files(job.output.unwrap_or(Path::new("out.glb")), format)?;
        self.write += start.elapsed();
        let engines = Some(engines);
        Ok(Product { files, warnings, clip, skeleton: Some(skeleton), engines, note, ..Product::default() })
    }

    /// The model with the joints of limbs: its own, or made for one.
    fn limbs(
        &mut self,
        job: &Job<'_>,
        gltf: Gltf,
        rest: Rest,
        point_of: &[u32],
    ) -> Result<Animated, JobError> {
        let Some(limbs) = self.motion.evaluation.lone_limbs() else { return Err(self.not_alone()) };
        let reaches: Vec<&Reach> = limbs.iter().map(|(reach, _)| *reach).collect();
        let is_made = |reach: &Reach| reach.nodes().is_empty();
        let Rigged { gltf, rest, joints, made, shown } = match reaches.as_slice() {
            [reach] if is_made(reach) => {
                let factors = self.motion.evaluation.first_factors();
                rig::make(gltf, &rest, reach.rest(), (factors, point_of), job.joints)?
            }
            reaches if reaches.iter().any(|reach| is_made(reach)) => return Err(self.not_alone()),
            reaches => rig::split_all(gltf, rest, reaches, job.joints)?,
        };
        let bone = |joint: &Joint| Bone { node: joint.node, parent: joint.parent };
        let bones: Vec<Bone> = joints.iter().map(bone).collect();
        let reach = reaches.iter().map(|reach| bone_length(reach)).fold(0.0, f64::max);
        let mut baker = BoneBaker::new(&bones);
        let still = gltf.player(&rest, None)?;
        let times = self.schedule.times_with(&job.preset.key_times);
        let mut look = |frame: usize, seconds: f64| -> Result<BonePose, JobError> {
            self.motion.at(seconds)?;
            let evaluation = &self.motion.evaluation;
            let Some(limbs) = evaluation.lone_limbs() else { return Err(self.not_alone()) };
            let player = evaluation.posing().map_or(&still, |posing| posing.player());
            let world = |node: usize| player.node_transform(node).unwrap_or(WORLD);
            let above = |node: usize| gltf.parent(node).map_or(WORLD, world);
            let places: Vec<World> = joints
                .chunk_by(|a, b| a.limb == b.limb)
                .flat_map(|own| places(own, limbs[own[0].limb], seconds, world))
                .collect();
            Ok(BonePose::new(&bones, frame, above, &places)?)
        };
        let off = |middle: &BonePose, ends: (&BonePose, &BonePose)| middle.off(&bones, ends, PART, reach);
        let mut take = |seconds: f64, pose: &BonePose| Ok(baker.push(seconds, pose)?);
        straightened(&times, allowed(&rest, job.tolerance), &mut look, &off, &mut take)?;
        drop(still);
        let skeleton = Skeleton { joints: joints.len(), made, ..Skeleton::default() };
        Ok(Animated { gltf, rest, shown, baker, skeleton, warnings: Vec::new() })
    }

    /// Refuses what no skeleton can do.
    fn not_alone(&self) -> JobError {
        let name = |effect: &Effect| match &effect.action {
            Action::Deform(_) => "`Deform`",
            Action::Wrinkle(_) => "`Wrinkle`",
            Action::Stitch(_) => "`Stitch`",
            Action::Ik(limb) if matches!(limb.chain, Chain::Skin { .. }) => "`Ik` of `Skin`",
            Action::Ik(_) => "`Ik` of `Joints`",
        };
        let found: Vec<&str> = self.motion.effects().iter().map(name).collect();
        let found = if found.is_empty() { "no effect".to_owned() } else { found.join(", ") };
        refused(&format!(
            "found {found}, expected one `Ik`, or more of them if all are of `Skin`, or one `Deform` whose wires only move, and nothing else"
        ))
    }

    /// How far what an engine plays is from the effect itself, at every frame and twice between all keys. That moves the vertices of `still`; `from`
    /// says which of them each one is.
    fn compare(
        &mut self,
        (gltf, rest): (&Gltf, &Rest),
        (clip, keys): (Option<usize>, &[f64]),
        (still, point_of, from): (&Rest, &[u32], &[usize]),
        out: &mut Skeleton,
    ) -> Result<(), JobError> {
        let mut player = gltf.player(rest, clip)?;
        let mut vertices = Vertices::of_scene(still, point_of.to_vec())?;
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        let frames = self.schedule.count();
        let shown = self.schedule.moments().map(|(_, seconds)| (seconds, true));
        let between = keys.windows(2).flat_map(|pair| {
            let times = BETWEEN.map(|part| pair[0] + part * (pair[1] - pair[0]));
            // Nothing is between times that are neighbours in files.
            let is_between = |time: &f64| (pair[0] as f32) < *time as f32 && (*time as f32) < pair[1] as f32;
            times.into_iter().filter(is_between).map(|time| (time, false)).collect::<Vec<_>>()
        });
        let mut times: Vec<(f64, bool)> = shown.chain(between).collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut done = 0;
        for (seconds, is_frame) in times {
            self.motion.at(seconds)?;
            if is_frame {
                self.record(seconds)?;
                done += 1;
                (self.progress)(Progress { done, frames });
            }
            if let Some((moment, _)) = self.motion.evaluation.moment() {
                vertices.repose(moment)?;
            }
            vertices.place(self.motion.before(), &self.motion.now);
            vertices.shade(self.motion.evaluation.joints())?;
            player.pose_into(seconds, None, &mut positions, &mut normals)?;
            let off =
                positions.iter().zip(from).map(|(a, v)| double(a).distance(double(&vertices.positions[*v])));
            let most = off.fold(0.0, f64::max);
            if most > out.residual {
                (out.residual, out.seconds) = (most, seconds);
            }
            let own = vertices.normals().into_iter().flat_map(|own| from.iter().map(|v| &own[*v]));
            let turned = own.zip(&normals).map(|(a, b)| double(a).angle_between(double(b)).to_degrees());
            // Vertices without a normal turn by no number.
            out.normals_degrees = turned.filter(|turn| turn.is_finite()).fold(out.normals_degrees, f64::max);
        }
        let diagonal = diagonal(rest);
        out.residual_of_diagonal = if diagonal > 0.0 { out.residual / diagonal } else { 0.0 };
        Ok(())
    }
}

/// For each vertex of a scene as it is `now` the one that it was, where these nodes show what others have shown.
fn vertices_from(before: &Rest, now: &Rest, shown: &[(usize, usize)]) -> Vec<usize> {
    let mut left: Vec<(usize, usize)> =
        before.blocks.iter().map(|block| (block.node, block.first)).rev().collect();
    let mut out = Vec::with_capacity(now.positions.len());
    for block in &now.blocks {
        let node = shown.iter().find(|(_, new)| *new == block.node).map_or(block.node, |(old, _)| *old);
        let place = left.iter().rposition(|(own, _)| *own == node);
        let first = place.map_or(block.first, |place| left.remove(place).1);
        out.extend(first..first + block.count);
    }
    out
}

/// The diagonal of what is shown at rest, metres; 0 of nothing.
fn diagonal(rest: &Rest) -> f64 {
    wirework_surface::Bounds::of(&rest.positions).map_or(0.0, |bounds| f64::from(bounds.diagonal()))
}

/// How far the way between keys may be off, metres: a part of the diagonal, and no less than floats can tell.
fn allowed(rest: &Rest, part: f64) -> f64 {
    let numbers = rest.positions.as_flattened().iter();
    let largest = numbers.fold(0.0_f64, |most, c| most.max(f64::from(c.abs())));
    (part * diagonal(rest)).max(NOISE * largest)
}

/// The length of the bones of a limb in the mean, metres: as far as most hangs from a joint.
fn bone_length(reach: &Reach) -> f64 {
    let joints: Vec<DVec3> = reach.rest().joints().map(DVec3::from_array).collect();
    let length: f64 = joints.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    length / joints.len().saturating_sub(1).max(1) as f64
}

fn double(p: &[f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

fn refused(why: &str) -> JobError {
    JobError::Request(format!("`--bake skin`: {why}; `--bake auto` takes it"))
}

/// Refuses what is to hang on new joints where a clip of the input moves it.
fn check_unmoved(gltf: &Gltf, nodes: &[usize]) -> Result<(), JobError> {
    for &node in nodes {
        let Some(clip) = gltf.clip_that_moves(node) else { continue };
        let called =
            gltf.node_name(node).map_or_else(String::new, |name| format!(" \"{}\"", printable(name)));
        return Err(refused(&format!(
            "clip {clip} of the input moves node {node}{called}, and a mesh that hangs on joints does not follow its node"
        )));
    }
    Ok(())
}

/// Where joints of a limb are to be at a time, to which `wire` has been brought; `world` is where nodes are then without the limb.
fn places(
    joints: &[Joint],
    (reach, wire): (&Reach, &Wire),
    seconds: f64,
    world: impl Fn(usize) -> World,
) -> Vec<World> {
    let frames = reach.bone_frames(seconds, wire);
    let u = |joint: &Joint| match joint.by {
        By::Curve(u) | By::Near { u, .. } => u,
        By::Bone(_) => 0.0,
    };
    let stations = wire.stations(&joints.iter().map(u).collect::<Vec<_>>());
    let place = |(joint, station): (&Joint, &Station)| match joint.by {
        By::Curve(_) => on_curve(station),
        By::Bone(bone) => frames.get(bone).map_or(WORLD, |frame| taken(&world(joint.node), frame)),
        By::Near { own, step, .. } => near(&world(own), step, station),
    };
    joints.iter().zip(&stations).map(place).collect()
}

/// Where a joint is to be that a bone of a limb takes along.
fn taken(joint: &World, frame: &BoneFrame) -> World {
    let along = DVec3::from_array(frame.along);
    let outer = DMat3::from_cols(along * along.x, along * along.y, along * along.z);
    let stretch = DMat3::from_diagonal(DVec3::splat(frame.scale)) + outer * (frame.stretch - frame.scale);
    let map = DMat3::from_quat(DQuat::from_array(frame.rotation)) * stretch;
    moved(joint, map, frame.from, frame.to)
}

/// Where a joint on the curve of a limb is to be, which at rest has the axes of the world.
fn on_curve(station: &Station) -> World {
    moved(&WORLD, turned(station), [0.0; 3], station.to)
}

/// Where what lies at `step` from a joint is to be. It is scaled along the curve as across it: between joints that agree in that, how far
/// the curve stretches is in their distances alone, and nothing is sheared.
fn near(joint: &World, step: DVec3, station: &Station) -> World {
    let [x, y, z, at] = joint.map(DVec3::from_array);
    let at = at + DMat3::from_cols(x, y, z) * step;
    moved(&[joint[0], joint[1], joint[2], at.to_array()], turned(station), station.from, station.to)
}

fn turned(station: &Station) -> DMat3 {
    DMat3::from_quat(DQuat::from_array(station.rotation)) * station.scale
}

/// A transform, taken along by a map about `from` that comes to be at `to`.
fn moved(joint: &World, map: DMat3, from: [f64; 3], to: [f64; 3]) -> World {
    let [x, y, z, at] = joint.map(DVec3::from_array);
    let to = DVec3::from_array(to) + map * (at - DVec3::from_array(from));
    [map * x, map * y, map * z, to].map(|column| column.to_array())
}
