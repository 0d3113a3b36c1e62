//! What is shown, at any moment, as a scene to be rendered.

use wirework_asset::{LocalDeltas, Player, printable};
use wirework_render::Scene;

use crate::JobError;
use crate::motion::Motion;
use crate::picture::parts::{Drawn, drawn};
use crate::picture::setting::Setting;
use crate::picture::{PictureJob, overlay};
use crate::shade::Vertices;
use crate::source::Source;

/// A model with an effect on it and a clip that plays.
pub(crate) struct Show<'a> {
    pub(crate) setting: &'a Setting,
    motion: Option<Motion<'a>>,
    player: Option<Player<'a>>,
    vertices: Vertices,
    /// What each part of the model looks like; its places are filled in for each moment.
    drawn: Drawn,
    /// World positions and normals of all vertices at the present moment; no normals where the model has none.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    warnings: Vec<String>,
}

impl<'a> Show<'a> {
    pub(crate) fn new(
        setting: &'a Setting,
        motion: Option<Motion<'a>>,
        clip: Option<usize>,
        job: &PictureJob<'_>,
        mut warnings: Vec<String>,
    ) -> Result<Self, JobError> {
        let Setting { gltf, rest, point_of, colors, .. } = setting;
        let vertices = Vertices::of_scene(rest, point_of.clone())?;
        let player = clip.map(|clip| gltf.player(rest, Some(clip))).transpose()?;
        let drawn = drawn(gltf, rest, colors.as_deref(), &job.limits, &mut warnings)?;
        if drawn.is_empty(&rest.positions) {
            return Err(setting.nothing());
        }
        let doubts = player.iter().flat_map(Player::warnings).filter(|doubt| !gltf.tells_of(doubt));
        warnings.extend(doubts.map(|doubt| format!("{}: {doubt}", printable(gltf.file()))));
        // Wires of limbs go with the clip.
        let posed = motion.as_ref().is_some_and(|motion| motion.evaluation.is_posed());
        let moves = player.as_ref().is_some_and(Player::moves);
        warnings.extend(idle(job, motion.is_some(), (moves, posed)).into_iter().map(str::to_owned));
        let (positions, normals) = (rest.positions.clone(), Vec::new());
        Ok(Self { setting, motion, player, vertices, drawn, positions, normals, warnings })
    }

    /// The length of the clip that plays, 0 without one.
    pub(crate) fn clip_duration(&self) -> f64 {
        self.player.as_ref().map_or(0.0, Player::duration)
    }

    pub(crate) fn has_effect(&self) -> bool {
        self.motion.is_some()
    }

    /// Points of all wires as they were last worked out.
    pub(crate) fn wires(&self) -> Vec<[f32; 3]> {
        self.motion.as_ref().map_or_else(Vec::new, |motion| overlay::reach(&motion.evaluation))
    }

    /// World positions of all that is seen at a moment, before the effect or after it.
    pub(crate) fn places(&mut self, seconds: f64, before: bool) -> Result<Vec<[f32; 3]>, JobError> {
        self.play(seconds, before, false)?;
        Ok(self.drawn.seen.iter().filter_map(|&v| self.positions.get(v as usize).copied()).collect())
    }

    /// How far the effect has moved its points at the moment that was last worked out: the sum of the squares.
    pub(crate) fn moved(&self) -> f64 {
        let Some(motion) = &self.motion else { return 0.0 };
        let squares =
            motion.before().iter().zip(&motion.now).map(|(p, q)| {
                p.iter().zip(q).map(|(a, b)| (f64::from(*b) - f64::from(*a)).powi(2)).sum::<f64>()
            });
        squares.sum()
    }

    fn play(&mut self, seconds: f64, before: bool, shaded: bool) -> Result<(), JobError> {
        let rest = &self.setting.rest;
        if let Some(motion) = &mut self.motion {
            motion.at(seconds)?;
            if let Some((moment, _)) = motion.evaluation.moment() {
                self.vertices.repose(moment)?;
            }
            let now = if before { motion.before() } else { &motion.now };
            self.vertices.place(motion.before(), now);
            if shaded {
                let joints = motion.evaluation.joints().filter(|_| !before);
                self.vertices.shade(joints)?;
            }
        }
        let normals = self.vertices.normals();
        // Before its clip, too, a model is at rest; under an effect the clip is part of both.
        let posed = self.motion.as_ref().is_some_and(|motion| motion.evaluation.is_posed());
        let player = self.player.as_mut().filter(|_| (self.motion.is_some() || !before) && !posed);
        let Some(player) = player else {
            self.positions.clone_from(&self.vertices.positions);
            self.normals.clear();
            self.normals.extend_from_slice(normals.unwrap_or(&[]));
            return Ok(());
        };
        let moved = self.motion.is_some() && !before;
        let local = |block| rest.to_local(block, &self.vertices.positions, normals, None);
        let deltas: Option<Vec<LocalDeltas>> = moved.then(|| (0..rest.blocks.len()).map(local).collect());
        player.pose_into(seconds, deltas.as_deref(), &mut self.positions, &mut self.normals)?;
        if normals.is_none() {
            self.normals.clear();
        }
        Ok(())
    }

    /// The scene at a moment, before the effect or after it, on a ground, in a picture of so many rows; with the effect's wires
    /// where they are wanted.
    pub(crate) fn scene(
        &mut self,
        seconds: f64,
        before: bool,
        ground: Option<f32>,
        wires: bool,
        rows: u32,
    ) -> Result<Scene, JobError> {
        self.play(seconds, before, true)?;
        let mut scene = self.drawn.scene(&self.positions, &self.normals, rows);
        scene.ground = ground;
        if let Some(motion) = self.motion.as_ref().filter(|_| wires) {
            overlay::draw(&motion.evaluation, before, rows, &mut scene);
        }
        Ok(scene)
    }

    /// What was repaired, passed over, or is hardly meant.
    pub(crate) fn warnings(&self, source: Option<&Source<'_>>) -> Vec<String> {
        let mut all = self.warnings.clone();
        if let (Some(source), Some(motion)) = (source, &self.motion) {
            all.extend(source.effect_warnings(&motion.evaluation));
        }
        all
    }
}

/// What is asked for and shows nothing.
fn idle(job: &PictureJob<'_>, effect: bool, (clip, posed): (bool, bool)) -> Vec<&'static str> {
    let cases = [
        (job.wires && !effect, "a model alone has no wires to be drawn [no-wires]"),
        (
            job.wires && effect && clip && !posed,
            "wires are drawn where they lie at rest, from where the clip moves the model away [rest-wires]",
        ),
        (
            job.compare && !effect && !clip,
            "there is no effect and no clip: before and after are the same [no-effect]",
        ),
    ];
    cases.into_iter().filter_map(|(is, message)| is.then_some(message)).collect()
}
