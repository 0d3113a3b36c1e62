//! From a scene to a picture, step by step.

use glam::Vec3;
use rayon::prelude::*;

use crate::gather::{NOBODY, Pixel, Tracer, cavity, gather, same, smooth};
use crate::hit::{GROUND, Hit, Stage};
use crate::light::Lamps;
use crate::raster::{Seen, rasterize};
use crate::rays::Rays;
use crate::scene::check;
use crate::shade::{Open, Shader, background};
use crate::space::{Geometry, Space};
use crate::tone::encode;
use crate::{Camera, RenderError, Scene, Settings, lines};

/// A picture of opaque sRGB pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Red, green, blue and 255, row by row from the top left.
    pub pixels: Vec<[u8; 4]>,
}

/// Makes pictures one after the other and keeps what the next can use: memory, and the tree that rays walk, which is
/// built once for each set of triangles and then only fitted to where their vertices have gone.
#[derive(Default)]
pub struct Renderer {
    rays: Rays,
    seen: Vec<Seen>,
}

/// One picture. For several of the same triangles keep a [`Renderer`].
pub fn render(scene: &Scene, camera: &Camera, settings: &Settings) -> Result<Picture, RenderError> {
    Renderer::default().render(scene, camera, settings)
}

impl Renderer {
    /// One picture. The same scene, camera and settings give the same bytes, whatever was rendered before and
    /// whatever the number of threads.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<Picture, RenderError> {
        settings.check()?;
        check(scene)?;
        let space = Space::new(camera, settings, scene.ground)?;

        let geometry = Geometry::new(scene, &space)?;

        let stage = Stage { scene, geometry: &geometry, space: &space, samples: settings.samples as usize };
        rasterize(stage, &mut self.seen);

        let lamps = Lamps::new(&space);
        let traced = !settings.fast && !geometry.triangles.is_empty();
        if traced {
            self.rays.fit(&geometry);
        }

        let tracer = traced.then(|| Tracer::new(&self.rays, &lamps, stage));
        let samples = stage.samples;
        let columns = settings.size[0] as usize;
        let footprint = samples as f32 / space.focal;
        let mut pixels = gather(stage, &self.seen, tracer.as_ref());

        if tracer.is_some() {
            smooth(&mut pixels, columns, footprint);
        }

        let shader = Shader { light: settings.light, lamps: &lamps, up: space.up };
        let finish =
            Finish { stage, seen: &self.seen, pixels: &pixels, columns, footprint, samples, tracer, shader };
        let mut colors = vec![Vec3::ZERO; pixels.len()];
        colors.par_chunks_mut(columns).enumerate().for_each(|(y, row)| {
            for (x, color) in row.iter_mut().enumerate() {
                *color = finish.pixel(x, y, background(settings, x, y));
            }
        });

        lines::draw(scene, &space, samples, &self.seen, &mut colors)?;

        let [width, height] = settings.size;
        let bytes = |c: &Vec3| [encode(c.x), encode(c.y), encode(c.z), 255];
        Ok(Picture { width, height, pixels: colors.par_iter().map(bytes).collect() })
    }
}

/// What the last step reads.
struct Finish<'a> {
    stage: Stage<'a>,
    seen: &'a [Seen],
    pixels: &'a [Pixel],
    columns: usize,
    footprint: f32,
    samples: usize,
    tracer: Option<Tracer<'a>>,
    shader: Shader<'a>,
}

impl Finish<'_> {
    /// The mean of a pixel's samples, linear, as it is on the screen.
    fn pixel(&self, x: usize, y: usize, background: Vec3) -> Vec3 {
        let bend = cavity(self.pixels, self.columns, x, y);
        if let Some(&Pixel { position, normal, color, owner, open, whole: true }) =
            self.pixels.get(y * self.columns + x)
        {
            return match owner {
                NOBODY => background,
                GROUND => self.shader.ground(background, open),
                _ => self.shader.surface(normal, position, color, open, bend),
            };
        }
        let mut sum = Vec3::ZERO;
        for i in 0..self.samples * self.samples {
            let (column, row) = (x * self.samples + i % self.samples, y * self.samples + i / self.samples);
            let seen = self.seen[row * self.stage.space.size[0] + column];
            sum += match self.stage.hit(seen, [column as f32 + 0.5, row as f32 + 0.5]) {
                None => background,
                Some(hit) => {
                    let (open, own) = self.open(&hit, [x, y], i);
                    if hit.owner == GROUND {
                        self.shader.ground(background, open)
                    } else {
                        let cavity = if own { bend } else { 0.0 };
                        self.shader.surface(hit.normal, hit.position, self.stage.color(&hit), open, cavity)
                    }
                }
            };
        }
        sum / (self.samples * self.samples) as f32
    }

    /// How open a sample lies: as its pixel does if it shows the sample's surface, or else the first neighbour that does,
    /// or else by rays of its own. And whether it was the pixel's own.
    fn open(&self, hit: &Hit, [x, y]: [usize; 2], sample: usize) -> (Open, bool) {
        let fits = |pixel: &&Pixel| {
            pixel.owner != NOBODY && same(pixel, hit.owner, hit.position, hit.normal, self.footprint)
        };
        let at = y * self.columns + x;
        let center = self.pixels.get(at).filter(fits);
        if let Some(pixel) = center {
            return (pixel.open, true);
        }
        let Some(tracer) = &self.tracer else { return (Open::FULL, false) };
        for (dx, dy) in [(0, 1), (1, 0), (2, 1), (1, 2), (0, 0), (2, 0), (0, 2), (2, 2)] {
            let (Some(nx), Some(ny)) = ((x + dx).checked_sub(1), (y + dy).checked_sub(1)) else { continue };
            let neighbour = self.pixels.get(ny * self.columns + nx).filter(|_| nx < self.columns);
            if let Some(pixel) = neighbour.filter(fits) {
                return (pixel.open, false);
            }
        }
        (tracer.open(hit, [x, y], sample), false)
    }
}
