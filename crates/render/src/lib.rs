//! Pictures of meshes and wires, made on the processor, the same bytes on every run.
//!
//! A small rasteriser finds what each sample sees; rays find what lies in the shade; light grazes the surface, since light
//! from above or from the camera hides wrinkles. There is no scene graph and there are no materials but a base colour: the
//! pictures are made to judge shapes by.
//!
//! ```
//! use wirework_render::{
//!     Camera, Corner, Line, LineKind, Part, Scene, Settings, View, caption, legend, png, render,
//! };
//! use wirework_surface::sphere;
//!
//! let ball = Part::new(&sphere([0.0, 1.0, 0.0], 1.0, [48, 24])?)?;
//! let equator = (0..=64).map(|i| {
//!     let (sin, cos) = (f32::from(i as u8) / 64.0 * std::f32::consts::TAU).sin_cos();
//!     [1.02 * cos, 1.0, 1.02 * sin]
//! });
//! let kind = LineKind::Wire;
//! let line = Line { points: equator.collect(), color: kind.color(), width: 2.0, kind };
//! let scene = Scene { parts: vec![ball], lines: vec![line], dots: vec![], ground: Some(0.0) };
//!
//! let settings = Settings { size: [160, 90], ..Settings::default() };
//! let bounds = scene.bounds().ok_or("nothing to see")?;
//! let camera = Camera::framing(bounds, View::ThreeQuarter, settings.size)?;
//! let mut picture = render(&scene, &camera, &settings)?;
//! caption(&mut picture, "rest", Corner::TopLeft);
//! legend(&mut picture, &[kind]);
//! let file = png(&picture)?;
//! assert!(file.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What moves is framed moment by moment ([`Framing`]), drawn by one [`Renderer`], and becomes an [`Animation`], GIF or
//! animated PNG, or a [`row()`] of moments:
//!
//! ```
//! # use wirework_render::*;
//! # use wirework_surface::sphere;
//! let moment = |x: f32| -> Result<Scene, Box<dyn std::error::Error>> {
//!     let ball = Part::new(&sphere([x, 1.0, 0.0], 1.0, [48, 24])?)?;
//!     Ok(Scene { parts: vec![ball], ground: Some(0.0), ..Scene::default() })
//! };
//! let settings = Settings { size: [96, 54], fast: true, ..Settings::default() };
//! let mut framing = Framing::new(View::Around { azimuth: -30.0, elevation: 15.0 }, settings.size)?;
//! for x in [0.0, 0.5, 1.0] {
//!     framing.add(moment(x)?.parts.into_iter().flat_map(|part| part.positions));
//! }
//! let (camera, mut renderer) = (framing.camera()?, Renderer::default());
//! let mut animation = Animation::new(AnimationKind::Gif, settings.size, 24.0)?;
//! let mut moments = vec![];
//! for x in [0.0, 0.5, 1.0] {
//!     let picture = renderer.render(&moment(x)?, &camera, &settings)?;
//!     animation.push(&picture)?;
//!     moments.push(picture);
//! }
//! assert!(animation.finish()?.starts_with(b"GIF89a"));
//! assert_eq!(row(&moments, 2)?.width, 3 * 96 + 2 * 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Steps
//!
//! 1. All positions go to the camera's space, with the picture's height at the camera's target as unit.
//! 2. Triangles are cut to what is in front of the camera and filled into samples, 2×2 a pixel by default. Where a
//!    texture is clear ([`Part::cutoff`]) they have holes, for samples and for rays.
//! 3. Each pixel's nearest surface gets rays to the sky (ambient occlusion) and to the key light (soft shadow), four and
//!    two, from a set that is spread over 4×4 pixels; a blur along the surface gives every pixel the whole set.
//! 4. Each sample is shaded with its own normal and colour: key light, fill, dome, gloss, rim, and the bend of the
//!    surface round the pixel, so that shallow wrinkles read; a filmic curve; the mean of the samples.
//! 5. Lines and dots are drawn over it, tested against the samples' depths.
//! 6. Words and legends are written on the finished picture, in sRGB as it is seen, mixed as light.

mod camera;
mod compose;
mod enclose;
mod encode;
mod error;
mod gather;
mod hit;
mod legend;
mod light;
mod lines;
mod paint;
mod pattern;
mod raster;
mod rays;
mod renderer;
mod scene;
mod settings;
mod shade;
mod space;
mod text;
mod texture;
mod tone;

pub use camera::{Camera, Framing, View};
pub use compose::{Corner, caption, row};
pub use encode::{Animation, AnimationKind, EncodeError, png};
pub use error::RenderError;
pub use legend::legend;
pub use renderer::{Picture, Renderer, render};
pub use scene::{CLAY, Dots, Line, LineKind, Part, Scene};
pub use settings::{FARTHEST, Light, MAX_SAMPLES, MAX_SIDE, Settings};
pub use texture::{Texture, Wrap};
