//! A limb as a skeleton: tracks of joints, which any engine plays, in the place of morph targets.
//!
//! Where the chain is one of the model's own, its joints are taken to where the limb has them: each turned and stretched as the middle of
//! its bone is. A chain that stands in the preset gets joints made for it, on the curve of the limb, between which vertices hang by
//! arc length; `F` below 1 leaves the rest of a vertex to a joint that stays. Either way what an engine then shows is compared with
//! the effect itself, at every frame.

use std::path::Path;
use std::time::Instant;

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;
use wirework_asset::{Clip, Format, Gltf, NewJoint, NewSkin, Rest};
use wirework_bake::{BoneBaker, World};
use wirework_core::{Foot, Station};
use wirework_ik::{BoneFrame, Influence, Limb};

use crate::film::{Film, Product, find_clip, new_clip};
use crate::output::Scene;
use crate::shade::Vertices;
use crate::{Job, JobError, Progress, Skeleton};

/// Nothing above a joint.
const WORLD: World = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// On how many joints a vertex of a made skeleton hangs: the two between which it lies, and the one that stays.
const EACH: usize = 3;

/// Influences this near to 1 are 1.
const WHOLE: f32 = 1e-6;

/// A model whose joints a limb moves.
struct Rigged {
    gltf: Gltf,
    rest: Rest,
    /// From the root on, each the parent of the next.
    nodes: Vec<usize>,
    /// Parameters of the limb's curve where the joints are, of those that were made for it.
    made: Option<Vec<f64>>,
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
        let clip = job.into.map(|into| find_clip(&gltf, into).map(Clip::Into)).transpose()?;
        let start = Instant::now();
        let mut rigged = self.rigged(job, gltf, rest, &point_of)?;
        let mut baker = BoneBaker::new(&rigged.nodes);
        let root = rigged.nodes.first().copied().unwrap_or_default();
        let above = rigged.gltf.parent(root).filter(|_| rigged.made.is_none());
        let still = rigged.gltf.player(&rigged.rest, None)?;
        for (_, seconds) in self.schedule.moments() {
            self.motion.at(seconds)?;
            let evaluation = &self.motion.evaluation;
            let Some((reach, wire, _)) = evaluation.lone_limb() else { return Err(not_alone()) };
            let player = evaluation.posing().map_or(&still, |posing| posing.player());
            let world = |node: usize| player.node_transform(node).unwrap_or(WORLD);
            let joints: Vec<World> = match &rigged.made {
                Some(places) => wire.stations(places).iter().map(at_station).collect(),
                None => {
                    let frames = reach.bone_frames(seconds, wire);
                    let moved = |(node, frame): (&usize, &BoneFrame)| taken(&world(*node), frame);
                    rigged.nodes.iter().zip(&frames).map(moved).collect()
                }
            };
            baker.push(seconds, &above.map_or(WORLD, world), &joints)?;
        }
        drop(still);
        let posed = self.motion.evaluation.is_posed();
        let index = baker.finish(&mut rigged.gltf, clip, under.filter(|_| posed))?;
        self.write += start.elapsed();
        let skeleton = self.compare(&rigged, index, &point_of)?;
        let Rigged { gltf, .. } = rigged;
        let file = wirework_asset::printable(gltf.file());
        let warnings =
            gltf.warnings().iter().skip(known).map(|warning| format!("{file}: {warning}")).collect();
        let clip = new_clip(&gltf, clips);
        let start = Instant::now();
        let files = gltf.into_files(job.output.unwrap_or(Path::new("out.glb")), format)?;
        self.write += start.elapsed();
        Ok(Product { files, warnings, clip, skeleton: Some(skeleton) })
    }

    /// The model with the joints of the limb: its own, or made for it.
    fn rigged(&self, job: &Job<'_>, gltf: Gltf, rest: Rest, point_of: &[u32]) -> Result<Rigged, JobError> {
        let Some((reach, _, factors)) = self.motion.evaluation.lone_limb() else { return Err(not_alone()) };
        if !reach.nodes().is_empty() {
            if job.joints > 0 {
                return Err(JobError::Request(
                    "the chain is the model's own: `--joints` is for one that is made".to_owned(),
                ));
            }
            return Ok(Rigged { gltf, rest, nodes: reach.nodes().to_vec(), made: None });
        }
        make(gltf, &rest, reach.rest(), (factors, point_of), job.joints)
    }

    /// How far what an engine plays is from the effect itself.
    fn compare(
        &mut self,
        rigged: &Rigged,
        clip: Option<usize>,
        point_of: &[u32],
    ) -> Result<Skeleton, JobError> {
        let Rigged { gltf, rest, nodes, made } = rigged;
        let mut player = gltf.player(rest, clip)?;
        let mut vertices = Vertices::new(rest.positions.clone(), point_of.to_vec());
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        let mut out =
            Skeleton { joints: nodes.len(), made: made.as_ref().map_or(0, Vec::len), ..Skeleton::default() };
        let frames = self.schedule.count();
        for (done, (_, seconds)) in self.schedule.moments().enumerate() {
            self.motion.at(seconds)?;
            if let Some((moment, _)) = self.motion.evaluation.moment() {
                vertices = Vertices::new(moment.positions.clone(), point_of.to_vec());
            }
            vertices.place(self.motion.before(), &self.motion.now);
            player.pose_into(seconds, None, &mut positions, &mut normals)?;
            let double = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
            let off = positions.iter().zip(&vertices.positions).map(|(a, b)| double(a).distance(double(b)));
            let most = off.fold(0.0, f64::max);
            if most > out.residual {
                (out.residual, out.seconds) = (most, seconds);
            }
            (self.progress)(Progress { done: done + 1, frames });
        }
        let bounds = wirework_surface::Bounds::of(&rest.positions);
        let diagonal = bounds.map_or(0.0, |bounds| f64::from(bounds.diagonal()));
        out.residual_of_diagonal = if diagonal > 0.0 { out.residual / diagonal } else { 0.0 };
        Ok(out)
    }
}

fn not_alone() -> JobError {
    JobError::Request(
        "`--bake skin` is for a preset of one limb, `Ik`: what else effects do no skeleton can".to_owned(),
    )
}

/// Where a joint is to be that a limb takes along.
fn taken(joint: &World, frame: &BoneFrame) -> World {
    let [x, y, z, at] = joint.map(DVec3::from_array);
    let along = DVec3::from_array(frame.along);
    let outer = DMat3::from_cols(along * along.x, along * along.y, along * along.z);
    let stretch = DMat3::from_diagonal(DVec3::splat(frame.scale)) + outer * (frame.stretch - frame.scale);
    let map = DMat3::from_quat(DQuat::from_array(frame.rotation)) * stretch;
    let to = DVec3::from_array(frame.to) + map * (at - DVec3::from_array(frame.from));
    [map * x, map * y, map * z, to].map(|column| column.to_array())
}

/// A joint on the curve of a limb, which at rest has the axes of the world.
fn at_station(station: &Station) -> World {
    let map = DMat3::from_quat(DQuat::from_array(station.rotation)) * station.scale;
    [map.x_axis.to_array(), map.y_axis.to_array(), map.z_axis.to_array(), station.to]
}

/// Makes joints on the curve of a limb, `between` of them on each bone, and hangs all that is shown on them.
fn make(
    mut gltf: Gltf,
    rest: &Rest,
    limb: &Limb,
    (factors, point_of): (Option<&[f32]>, &[u32]),
    between: usize,
) -> Result<Rigged, JobError> {
    let mut shown: Vec<usize> = rest.blocks.iter().map(|block| block.node).collect();
    shown.dedup();
    let places = limb.places(between);
    let curve = &limb.wire().reference;
    let lengths = curve.lengths(places.iter().copied());
    let names: Vec<String> = std::iter::once("limb_rest".to_owned())
        .chain((0..places.len()).map(|i| format!("limb_{i:02}")))
        .collect();
    let at: Vec<[f64; 3]> = curve.at(places.iter().copied()).into_iter().map(|(place, _)| place).collect();
    let feet: Vec<Option<Foot>> =
        rest.positions.par_iter().map(|position| curve.closest(*position)).collect();
    let along = curve.lengths(feet.iter().map(|foot| foot.map_or(0.0, |foot| f64::from(foot.u))));
    let radius = radius(limb);
    let (mut indices, mut weights) = (Vec::new(), Vec::new());
    let mut stays = false;
    for ((foot, along), point) in feet.iter().zip(&along).zip(point_of) {
        let factor = factors.and_then(|factors| factors.get(*point as usize)).copied().unwrap_or(1.0);
        let near =
            radius.map_or(1.0, |radius| density(foot.map_or(f32::INFINITY, |foot| foot.distance) / radius));
        let (own, by) = hanging(&lengths, *along, factor * near);
        stays |= by[EACH - 1] > 0.0;
        indices.extend(own);
        weights.extend(by);
    }
    // Where nothing stays there is no joint for it.
    let first = usize::from(stays);
    let joint = |(i, name): (usize, &'_ String)| {
        let above = if i > 0 { at[i - 1] } else { [0.0; 3] };
        let step: [f32; 3] = std::array::from_fn(|k| (at[i][k] - above[k]) as f32);
        (name.clone(), (i > 0).then(|| first + i - 1), step)
    };
    let mut joints: Vec<(String, Option<usize>, [f32; 3])> =
        if stays { vec![(names[0].clone(), None, [0.0; 3])] } else { Vec::new() };
    joints.extend(names[1..].iter().enumerate().map(joint));
    let joints: Vec<NewJoint<'_>> = joints
        .iter()
        .map(|(name, parent, translation)| NewJoint {
            name,
            parent: *parent,
            translation: *translation,
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [1.0; 3],
        })
        .collect();
    for (slot, index) in indices.iter_mut().enumerate() {
        // The last of each vertex is the one that stays.
        *index = if slot % EACH == EACH - 1 { 0 } else { *index + first as u16 };
    }
    let skin = NewSkin { name: "limb", joints: &joints, each: EACH, indices: &indices, weights: &weights };
    let nodes = gltf.add_skin(rest, &shown, &skin)?;
    let rest = gltf.rest()?;
    Ok(Rigged { gltf, rest, nodes: nodes[first..].to_vec(), made: Some(places) })
}

/// How far a limb reaches.
fn radius(limb: &Limb) -> Option<f32> {
    match limb.settings().influence {
        Influence::Radius(radius) => Some(radius),
        Influence::All | Influence::SkinWeights => None,
    }
}

/// `f` of a limb's wire, the paper's.
fn density(x: f32) -> f32 {
    if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 }
}

/// The two joints between which a vertex lies, and one that stays; and its weights. `lengths` are the arc lengths up to the joints, `along`
/// that up to the vertex's foot.
fn hanging(lengths: &[f64], along: f64, influence: f32) -> ([u16; EACH], [f32; EACH]) {
    let before = lengths.partition_point(|length| *length <= along).clamp(1, lengths.len() - 1) - 1;
    let (a, b) = (lengths[before], lengths[before + 1]);
    let part = if b > a { ((along - a) / (b - a)).clamp(0.0, 1.0) as f32 } else { 0.0 };
    let whole = if influence > 1.0 - WHOLE { 1.0 } else { influence };
    ([before as u16, before as u16 + 1, 0], [whole * (1.0 - part), whole * part, 1.0 - whole])
}
