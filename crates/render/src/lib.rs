//! Pictures of meshes and wires, made on the processor, the same bytes on every run.
//!
//! A small rasteriser finds what each sample sees; rays find what lies in the shade; light grazes the surface, since light
//! from above or from the camera hides wrinkles. There is no scene graph and there are no materials but a base colour: the
//! pictures are made to judge shapes by.
//!
//! ```
//! use wirework_render::{Camera, Line, LineKind, Part, Scene, Settings, View, render};
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
//! let picture = render(&scene, &camera, &settings)?;
//! assert_eq!(picture.pixels.len(), 160 * 90);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Steps
//!
//! 1. All positions go to the camera's space, with the picture's height at the camera's target as unit.
//! 2. Triangles are cut to what is in front of the camera and filled into samples, 2×2 a pixel by default.
//! 3. Each pixel's nearest surface gets rays to the sky (ambient occlusion) and to the key light (soft shadow), four and
//!    two, from a set that is spread over 4×4 pixels; a blur along the surface gives every pixel the whole set.
//! 4. Each sample is shaded with its own normal and colour: key light, fill, dome, gloss, rim, and the bend of the
//!    surface round the pixel, so that shallow wrinkles read; a filmic curve; the mean of the samples.
//! 5. Lines and dots are drawn over it, tested against the samples' depths.

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
