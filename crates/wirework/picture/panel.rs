//! One moment as a picture: framed once for all moments, and compared with the state before the effect where that is asked for.

use wirework_render::{
    Camera, Corner, Framing, LineKind, Picture, RenderError, Renderer, Scene, Settings, caption, legend,
    row as beside,
};
use wirework_surface::Bounds;

use crate::JobError;
use crate::picture::moments::looked_at;
use crate::picture::output::PictureTarget;
use crate::picture::show::Show;
use crate::picture::{PictureJob, Viewpoint};

/// Pixels between pictures that stand in a row.
pub(crate) const GAP: u32 = 4;

/// Where and how all moments are rendered.
pub(crate) struct Panel<'a> {
    job: &'a PictureJob<'a>,
    camera: Camera,
    settings: Settings,
    /// The height of the ground.
    ground: Option<f32>,
    /// Whether pictures say what time it is.
    timed: bool,
}

impl<'a> Panel<'a> {
    /// Frames what is shown, at all moments alike.
    pub(crate) fn new(
        job: &'a PictureJob<'a>,
        target: &PictureTarget,
        show: &mut Show<'_>,
        shown: &[(u32, f64)],
    ) -> Result<Self, JobError> {
        let size = target.size(job);
        let settings = Settings { size, fast: job.fast, ..Settings::default() };
        let mut framing = Framing::new(job.viewpoint.view, size)?;
        let mut reach = Reach::default();
        for seconds in looked_at(job, shown, show) {
            for before in [true, false].into_iter().skip(usize::from(!job.compare)) {
                let places = show.places(seconds, before)?;
                reach.add(&places);
                framing.add(places);
            }
            if job.wires {
                framing.add(show.wires());
            }
        }
        // One place alone has no size to fill a picture with: it gets a metre.
        if let Some(Bounds { min, max }) = reach.bounds().filter(|bounds| bounds.min == bounds.max) {
            framing.add([min.map(|c| c - 0.5), max.map(|c| c + 0.5)]);
        }
        let bounds = reach.bounds().ok_or_else(|| show.setting.nothing())?;
        let camera = camera(&job.viewpoint, &framing, bounds).map_err(|error| match error {
            RenderError::Bounds { .. } => show.setting.nothing(),
            error => error.into(),
        })?;
        Ok(Self {
            job,
            camera,
            settings,
            ground: Some(bounds.min[1]),
            timed: matches!(target, PictureTarget::Sheet(_)) && shown.len() > 1,
        })
    }

    /// The picture of a moment; in a sheet the `first` one has the legend for all.
    pub(crate) fn picture(
        &self,
        show: &mut Show<'_>,
        renderer: &mut Renderer,
        seconds: f64,
        first: bool,
    ) -> Result<Picture, JobError> {
        let mut pictures = Vec::new();
        let mut kinds = Vec::new();
        for (before, title) in [(true, "before"), (false, "after")] {
            if before && !self.job.compare {
                continue;
            }
            let scene = show.scene(seconds, before, self.ground, self.job.wires, self.settings.size[1])?;
            self.check_camera(&scene, seconds)?;
            let mut picture = renderer.render(&scene, &self.camera, &self.settings)?;
            if self.job.compare {
                caption(&mut picture, title, Corner::TopLeft);
            }
            if self.job.wires {
                kinds.extend(scene.lines.iter().map(|line| line.kind));
                kinds.extend(scene.dots.iter().map(|dots| dots.kind));
            }
            pictures.push(picture);
        }
        let mut picture = row(pictures)?;
        if self.timed {
            caption(&mut picture, &format!("{seconds:.2} s"), Corner::TopRight);
        }
        // A model's own points and lines need no word.
        kinds.retain(|kind| *kind != LineKind::Point);
        if first || !self.timed {
            legend(&mut picture, &kinds);
        }
        Ok(picture)
    }

    /// Refuses a camera that was put into the object: it would see the inside of one colour.
    fn check_camera(&self, scene: &Scene, seconds: f64) -> Result<(), JobError> {
        if self.job.viewpoint.eye.is_none() || !scene.encloses(self.camera.eye) {
            return Ok(());
        }
        let [x, y, z] = self.camera.eye;
        Err(JobError::Request(format!(
            "at {seconds} s the camera at {x},{y},{z} stands inside the object; put it outside, or leave `--eye` out"
        )))
    }
}

/// Pictures side by side; one alone as it is.
pub(crate) fn row(mut pictures: Vec<Picture>) -> Result<Picture, JobError> {
    match pictures.pop() {
        Some(only) if pictures.is_empty() => Ok(only),
        last => {
            pictures.extend(last);
            Ok(beside(&pictures, GAP)?)
        }
    }
}

fn camera(viewpoint: &Viewpoint, framing: &Framing, bounds: Bounds) -> Result<Camera, RenderError> {
    let framed = framing.camera()?;
    let camera = match viewpoint.eye {
        None => framed,
        Some(eye) => {
            let target = viewpoint.target.unwrap_or_else(|| bounds.center());
            Camera { eye, target, up: upward(eye, target), ..framed }
        }
    };
    viewpoint.zoom.map_or(Ok(camera), |factor| camera.zoomed(factor))
}

/// Up in the picture: +Y, or −Z for a camera that looks straight up or down, as nearly as one can say by a target that is the middle
/// of something.
fn upward(eye: [f32; 3], target: [f32; 3]) -> [f32; 3] {
    const STRAIGHT: f32 = 1e-3;
    let [x, y, z] = [0, 1, 2].map(|k| eye[k] - target[k]);
    if x.hypot(z) <= STRAIGHT * y.abs() { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] }
}

/// The box round everything that was shown.
#[derive(Default)]
struct Reach(Vec<[f32; 3]>);

impl Reach {
    fn add(&mut self, places: &[[f32; 3]]) {
        if let Some(bounds) = Bounds::of(places) {
            self.0.extend([bounds.min, bounds.max]);
        }
    }

    fn bounds(&self) -> Option<Bounds> {
        Bounds::of(&self.0)
    }
}
