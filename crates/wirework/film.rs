//! An effect on its way through time, and what is made of its moments: a glTF animation, a still, OBJ files.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;
use wirework_asset::{
    Clip, Format, Gltf, LocalDeltas, Obj, ObjPart, OutputFile, Player, Rest, write_obj, write_obj_parts,
};
use wirework_bake::{Bake, Frame, Moments, Played, Settings};
use wirework_surface::Mesh;

use crate::engines::engines;
use crate::error::count;
use crate::joints::as_one;
use crate::motion::Motion;
use crate::output::{Pattern, Scene, scene_mesh};
use crate::parts::MeshPart;
use crate::shade::{Follow, Vertices, own_normals};
use crate::sides::Recorders;
use crate::subject::Model;
use crate::{Engines, Evaluation, Job, JobError, NewClip, Progress, Schedule, Skeleton};

/// What came out.
#[derive(Default)]
pub(crate) struct Product {
    pub(crate) files: Vec<OutputFile>,
    pub(crate) warnings: Vec<String>,
    /// The clip that was added.
    pub(crate) clip: Option<NewClip>,
    pub(crate) skeleton: Option<Skeleton>,
    /// How well morph targets play the effect.
    pub(crate) played: Option<Played>,
    /// What engines do not take of what was added.
    pub(crate) note: Option<String>,
    /// What engines make of the document.
    pub(crate) engines: Option<Engines>,
}

/// An effect on its way through time.
pub(crate) struct Film<'a> {
    pub(crate) motion: Motion<'a>,
    pub(crate) schedule: Schedule,
    pub(crate) shade: Duration,
    pub(crate) write: Duration,
    /// What takes in every moment besides.
    pub(crate) recorders: Recorders<'a>,
    pub(crate) progress: &'a mut (dyn FnMut(Progress) + Send),
}

impl Film<'_> {
    /// Works out every moment, lets `vertices` follow, and hands each to `take`: frame, time and vertices.
    pub(crate) fn play(
        &mut self,
        vertices: &mut [Vertices],
        mut take: impl FnMut(u32, f64, &[Vertices], &Evaluation<'_>) -> Result<(), JobError>,
    ) -> Result<(), JobError> {
        let frames = self.schedule.count();
        for (done, (frame, seconds)) in self.schedule.moments().enumerate() {
            self.motion.at(seconds)?;
            self.record(seconds)?;
            let start = Instant::now();
            vertices.iter_mut().try_for_each(|list| list.follow(&self.motion))?;
            let shaded = Instant::now();
            self.shade += shaded - start;
            take(frame, seconds, vertices, &self.motion.evaluation)?;
            self.write += shaded.elapsed();
            (self.progress)(Progress { done: done + 1, frames });
        }
        Ok(())
    }

    /// Lets what is written besides take in the present moment.
    pub(crate) fn record(&mut self, seconds: f64) -> Result<(), JobError> {
        let start = Instant::now();
        self.recorders.take(&self.motion, seconds)?;
        self.write += start.elapsed();
        Ok(())
    }

    /// Nothing but what takes in the moments.
    pub(crate) fn alone(&mut self) -> Result<Product, JobError> {
        self.play(&mut [], |_, _, _, _| Ok(()))?;
        Ok(Product::default())
    }

    /// A glTF document; `under` is the clip that poses what the effect works on.
    pub(crate) fn gltf(
        &mut self,
        job: &Job<'_>,
        format: Format,
        scene: Scene,
        under: Option<usize>,
    ) -> Result<Product, JobError> {
        let Scene { mut gltf, rest, point_of, .. } = scene;
        let (known, before) = (gltf.warnings().len(), engines(&gltf));
        let clips = gltf.clip_names().len();
        let start = Instant::now();
        let still = matches!(self.schedule, Schedule::Still(_));
        let who = if still { Follow::All } else { Follow::NormalMapped };
        let vertices = Vertices::of_scene(&rest, point_of)?.with_tangents(&rest, who)?;
        self.shade += start.elapsed();
        // What starts from a clip is nothing without it.
        let under = under.filter(|_| self.motion.evaluation.is_posed());
        let mut played = None;
        if still {
            self.still(&mut gltf, &rest, vertices)?;
        } else {
            (gltf, played) = self.animated(job, (gltf, &rest), vertices, under)?;
        }
        if played.as_ref().is_some_and(|played| played.nodes.is_empty() && played.error > 0.0) {
            let message = "the effect moves nothing farther than the tolerance, and is not in the file";
            gltf.warn("still", message.to_owned());
        }
        let engines = engines(&gltf);
        let warnings = gltf.warnings().iter().skip(known);
        let file = wirework_asset::printable(gltf.file());
        let warnings = warnings.map(|warning| format!("{file}: {warning}")).collect();
        let note = engines.note(&before);
        let clip = new_clip(&gltf, clips, under);
        let start = Instant::now();
        let files = gltf.into_files(job.output.unwrap_or(Path::new("out.glb")), format)?;
        self.write += start.elapsed();
        Ok(Product { files, warnings, clip, played, engines: Some(engines), note, ..Product::default() })
    }

    /// Puts the only moment in the place of the rest.
    fn still(&mut self, gltf: &mut Gltf, rest: &Rest, vertices: Vertices) -> Result<(), JobError> {
        self.play(&mut [vertices], |_, _, vertices, evaluation| {
            let [vertices] = vertices else { return Ok(()) };
            if let Some(posing) = evaluation.posing() {
                gltf.pose_nodes(&posing.player().node_poses())?;
            }
            let now = evaluation.moment().map_or(rest, |(moment, _)| moment);
            let stuck = gltf.set_still(now, &vertices.positions, vertices.normals(), vertices.tangents())?;
            if stuck > 0 {
                let who = if stuck == 1 { "vertex stays" } else { "vertices stay" };
                gltf.warn("singular", format!("{stuck} {who} in place: the transform has no inverse"));
            }
            Ok(())
        })
    }

    /// Bakes all moments into targets and a clip; `source` is the clip that they start from.
    fn animated(
        &mut self,
        job: &Job<'_>,
        (gltf, rest): (Gltf, &Rest),
        vertices: Vertices,
        source: Option<usize>,
    ) -> Result<(Gltf, Option<Played>), JobError> {
        let clip = job.into.map(|into| find_clip(&gltf, into).map(Clip::Into)).transpose()?;
        let Job { bake, tolerance, max_targets, .. } = *job;
        let settings = Settings { bake, tolerance, max_targets, clip, source, ..Settings::default() };
        // What happens between two frames shows at its keys.
        let keys = if bake == Bake::Frames { &[][..] } else { &job.preset.key_times };
        let times = self.schedule.times_with(keys);
        let start = Instant::now();
        let mut takes = Takes { film: self, rest, vertices, worked: Duration::ZERO, told: 0 };
        let baked = wirework_bake::bake(gltf, rest, settings, &times, &mut takes)?;
        let worked = takes.worked;
        self.write += start.elapsed().saturating_sub(worked);
        Ok((baked.gltf, baked.played))
    }

    /// Files of a scene or a mesh. A scene is as `clip` poses it, where that drives the effect; else at rest.
    pub(crate) fn obj(
        &mut self,
        pattern: Option<&Pattern>,
        model: Model,
        point_of: Vec<u32>,
        clip: Option<usize>,
        output: Option<&Path>,
    ) -> Result<Product, JobError> {
        let mut files = Vec::new();
        let mut keep = |frame, bytes| match (pattern, output) {
            (Some(pattern), _) => files.push(pattern.output(frame, bytes)),
            (None, Some(path)) => files.push(OutputFile::new(path, bytes)),
            (None, None) => {}
        };
        let start = Instant::now();
        match model {
            Model::Gltf { gltf, rest } => {
                let mut vertices = [Vertices::of_scene(&rest, point_of)?];
                let clip = clip.filter(|_| !self.motion.evaluation.is_posed());
                let mut posed = clip.map(|clip| Posed::new(&gltf, &rest, clip)).transpose()?;
                self.shade += start.elapsed();
                self.play(&mut vertices, |frame, seconds, vertices, _| {
                    let [vertices] = vertices else { return Ok(()) };
                    let (mut positions, mut normals) = (vertices.positions.as_slice(), vertices.normals());
                    if let Some(posed) = &mut posed {
                        posed.pose(&rest, seconds, positions, normals)?;
                        positions = &posed.positions;
                        normals = normals.and(Some(&posed.normals));
                    }
                    keep(frame, write_obj(&scene_mesh(&rest, positions, normals)));
                    Ok(())
                })?;
            }
            Model::Mesh { parts, mesh, obj } => {
                let (mut mesh, normals) = own_normals(&mesh, &point_of)?;
                let own = point_of.clone();
                let places = Vertices::new(mesh.positions.clone(), point_of);
                let mut vertices: Vec<Vertices> = [places].into_iter().chain(normals).collect();
                self.shade += start.elapsed();
                self.play(&mut vertices, |frame, _, vertices, _| {
                    follow(&mut mesh, vertices);
                    // The frames of a sequence are to have the same vertices.
                    if pattern.is_some() {
                        keep(frame, obj_text(obj.as_deref(), &parts, &mesh));
                    }
                    Ok(())
                })?;
                if pattern.is_none() {
                    let (one, parts) = as_one(&mesh, &parts, self.motion.evaluation.joints(), &own);
                    // A file keeps its text where nothing has become one.
                    let obj = obj.filter(|_| one.positions.len() == mesh.positions.len());
                    keep(0, obj_text(obj.as_deref(), &parts, &one));
                }
            }
        }
        Ok(Product { files, ..Product::default() })
    }
}

/// A film as the baker looks at it: at any moment, in any order.
struct Takes<'t, 'a> {
    film: &'t mut Film<'a>,
    rest: &'t Rest,
    vertices: Vertices,
    /// How long it took to work moments out.
    worked: Duration,
    /// How many frames have been told of as done.
    told: usize,
}

impl Moments for Takes<'_, '_> {
    type Error = JobError;

    fn at(&mut self, seconds: f64) -> Result<Frame<'_>, JobError> {
        let Self { film, rest, vertices, worked, .. } = self;
        let start = Instant::now();
        film.motion.at(seconds)?;
        let deformed = Instant::now();
        vertices.follow(&film.motion)?;
        film.shade += deformed.elapsed();
        *worked += start.elapsed();
        let moment = film.motion.evaluation.moment().map_or(*rest, |(moment, _)| moment);
        let (normals, tangents) = (vertices.normals(), vertices.tangents());
        Ok(Frame { moment, positions: &vertices.positions, normals, tangents })
    }

    fn progress(&mut self, done: usize, all: usize) {
        // A frame may be looked at more than once.
        let frames = self.film.schedule.count();
        let done = done * frames / all.max(1);
        if done > self.told {
            self.told = done;
            (self.film.progress)(Progress { done, frames });
        }
    }
}

/// A scene as a clip poses it, with an effect on it.
pub(crate) struct Posed<'a> {
    player: Player<'a>,
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
}

impl<'a> Posed<'a> {
    pub(crate) fn new(gltf: &'a Gltf, rest: &Rest, clip: usize) -> Result<Self, JobError> {
        Ok(Self { player: gltf.player(rest, Some(clip))?, positions: Vec::new(), normals: Vec::new() })
    }

    /// Poses vertices that the effect has moved from the rest.
    pub(crate) fn pose(
        &mut self,
        rest: &Rest,
        seconds: f64,
        positions: &[[f32; 3]],
        normals: Option<&[[f32; 3]]>,
    ) -> Result<(), JobError> {
        let local = |block| rest.to_local(block, positions, normals, None);
        let deltas: Vec<LocalDeltas> = (0..rest.blocks.len()).map(local).collect();
        self.player.pose_into(seconds, Some(&deltas), &mut self.positions, &mut self.normals)?;
        Ok(())
    }
}

/// The clip that stands behind the `known` ones, if there is one, and the one that it plays besides.
pub(crate) fn new_clip(gltf: &Gltf, known: usize, plays: Option<usize>) -> Option<NewClip> {
    let name = gltf.clip_names().get(known)?.unwrap_or_default().to_owned();
    let clips = gltf.json().get("animations")?.as_array()?;
    let weights = |channel: &Value| channel.pointer("/target/path").is_some_and(|path| path == "weights");
    let moves_weights = |clip: &Value| clip.get("channels")?.as_array().map(|all| all.iter().any(weights));
    let own = clips.iter().take(known).enumerate();
    let could_join = own.filter(|(_, clip)| moves_weights(clip) != Some(true)).map(|(index, _)| index);
    Some(NewClip { index: known, name, could_join: could_join.collect(), plays })
}

/// Puts present positions, and normals where there are any, into a mesh.
fn follow(mesh: &mut Mesh, vertices: &[Vertices]) {
    let (Some(places), normals) = (vertices.first(), vertices.get(1)) else { return };
    mesh.positions.copy_from_slice(&places.positions);
    if let Some(now) = normals.and_then(|normals| normals.normals()?.get(..mesh.normals.len())) {
        mesh.normals.copy_from_slice(now);
    }
}

fn obj_text(obj: Option<&Obj>, parts: &[MeshPart], mesh: &Mesh) -> Vec<u8> {
    let object = |part: &MeshPart| ObjPart {
        name: part.name.clone(),
        positions: part.positions.first().map_or(0, |range| range.end),
        faces: part.faces.clone(),
    };
    match (obj, parts) {
        (Some(obj), _) => obj.write(mesh),
        (None, [_]) => write_obj(mesh),
        (None, parts) => write_obj_parts(mesh, &parts.iter().map(object).collect::<Vec<_>>()),
    }
}

/// Whether the clip that is asked for is there, whatever is written.
pub(crate) fn check_clip(model: &Model, wanted: &str) -> Result<(), JobError> {
    let names = match model {
        Model::Gltf { gltf, .. } => gltf.clip_names(),
        Model::Mesh { .. } => Vec::new(),
    };
    clip_of(&names, wanted).map(|_| ())
}

/// The clip of a name, or else of a number.
pub(crate) fn find_clip(gltf: &Gltf, wanted: &str) -> Result<usize, JobError> {
    clip_of(&gltf.clip_names(), wanted)
}

fn clip_of(names: &[Option<&str>], wanted: &str) -> Result<usize, JobError> {
    let by_number = || wanted.parse().ok().filter(|&index: &usize| index < names.len());
    names.iter().position(|name| *name == Some(wanted)).or_else(by_number).ok_or_else(|| {
        let known: Vec<String> = names
            .iter()
            .enumerate()
            .map(|(index, name)| name.map_or_else(|| index.to_string(), |name| format!("{name:?}")))
            .collect();
        let there = match known.as_slice() {
            [] => "the input has no clips".to_owned(),
            known => format!("the input has {}: {}", count(known.len(), "clip"), known.join(", ")),
        };
        JobError::Request(format!("there is no clip {wanted:?}; {there}"))
    })
}
