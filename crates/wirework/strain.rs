//! The compression of a model by one of its clips, for the effects that it drives.

use wirework_asset::{Gltf, Rest};
use wirework_preset::Preset;

use crate::film::find_clip;
use crate::motion::Motion;
use crate::{Evaluation, JobError, Model};

/// Looks at a clip in steps of so many seconds: twice as fine as what films show.
const STEP: f64 = 1.0 / 60.0;
/// Looks at a clip at most; of a longer one in coarser steps.
const MOST: usize = 4096;

/// The clip that drives an effect: the one asked for, or else the first. None where no effect is driven, or there is no clip.
///
/// # Errors
///
/// There is no clip of that name.
pub(crate) fn driving_clip(
    evaluation: &Evaluation<'_>,
    model: &Model,
    wanted: Option<&str>,
) -> Result<Option<usize>, JobError> {
    let Model::Gltf { gltf, .. } = model else { return Ok(None) };
    if !evaluation.is_driven() {
        return Ok(None);
    }
    match wanted {
        Some(wanted) => find_clip(gltf, wanted).map(Some),
        None => Ok((!gltf.clip_names().is_empty()).then_some(0)),
    }
}

/// How long an effect lasts, and whether it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Length {
    pub(crate) seconds: f64,
    pub(crate) animated: bool,
}

impl Length {
    /// What the preset says.
    pub(crate) fn of(preset: &Preset) -> Self {
        Self { seconds: preset.duration, animated: preset.animated }
    }

    /// The same where a clip of so many seconds drives the effect.
    pub(crate) fn with_clip(self, preset: &Preset, clip: f64) -> Self {
        let seconds = if preset.follows_clip { self.seconds.max(clip) } else { self.seconds };
        Self { seconds, animated: self.animated || clip > 0.0 }
    }
}

/// Plays a clip of the scene that a motion moves, and tells its effects how the surface is compressed. Returns the clip's length in
/// seconds.
///
/// # Errors
///
/// The clip is malformed.
pub(crate) fn sense(
    motion: &mut Motion<'_>,
    gltf: &Gltf,
    rest: &Rest,
    point_of: &[u32],
    clip: usize,
) -> Result<f64, JobError> {
    let mut player = gltf.player(rest, Some(clip))?;
    let duration = player.duration();
    let steps = ((duration / STEP).ceil() as usize).clamp(1, MOST);
    let step = duration / steps as f64;
    let mut sensing = Sensing::new(&motion.evaluation);
    let (mut positions, mut normals) = (rest.positions.clone(), Vec::new());
    let mut now = motion.points.to_vec();
    for i in 0..=steps {
        player.pose_into(step * i as f64, None, &mut positions, &mut normals)?;
        // Backwards, so that the first vertex at a place speaks for it.
        for (&point, position) in point_of.iter().zip(&positions).rev() {
            if let Some(place) = now.get_mut(point as usize) {
                *place = *position;
            }
        }
        sensing.read(&motion.evaluation, &now);
    }
    motion.evaluation.record(step, sensing.readings);
    Ok(duration)
}

/// Readings for each effect, at each time.
struct Sensing {
    readings: Vec<Vec<Vec<f32>>>,
}

impl Sensing {
    fn new(evaluation: &Evaluation<'_>) -> Self {
        Self { readings: vec![Vec::new(); evaluation.effect_count()] }
    }

    fn read(&mut self, evaluation: &Evaluation<'_>, now: &[[f32; 3]]) {
        for (effect, readings) in self.readings.iter_mut().enumerate() {
            readings.push(evaluation.compression(effect, now));
        }
    }
}
