//! Procedural effects on *wires*, for glTF and OBJ models: the library behind the command `wirework`.
//!
//! K. Singh, E. Fiume, "Wires: A Geometric Deformation Technique", SIGGRAPH 1998, is cited as \[SF98\].
//!
//! # A tour
//!
//! A **curve** is control points and a rule. A **wire** is a pair of curves: where it lies on the object, `R`, and
//! where it is now, `W`; what is within its radius of `R` is carried along.
//!
//! ```
//! use wirework::{Curve, Wire};
//!
//! let along = Curve::bspline(3, vec![[-1.0, 0.0, 0.0], [-0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [1.0, 0.0, 0.0]])?;
//! assert_eq!(along.point(0.5), [0.0; 3]);
//!
//! let mut wire = Wire { radius: 0.5, ..Wire::new(along) };
//! wire.pose[1][1] = 0.4; // lift the two inner control points of W
//! wire.pose[2][1] = 0.4;
//! # Ok::<(), wirework::core::CurveError>(())
//! ```
//!
//! Points are **bound** once, which finds for each the nearest point of every wire, and **deformed** as often as
//! the wires move, into a buffer of yours. Points are `[f32; 3]`, to which any engine's vectors can be cast.
//!
//! ```
//! use wirework::{Binding, Blend, surface::grid};
//! # use wirework::{Curve, Wire};
//! # let along = Curve::bspline(3, vec![[-1.0, 0.0, 0.0], [-0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [1.0, 0.0, 0.0]])?;
//! # let mut wires = [Wire { radius: 0.5, ..Wire::new(along) }];
//!
//! let mesh = grid([2.0, 2.0], [64, 64], [0.0, 1.0, 0.0])?;
//! let mut points = mesh.positions.clone();
//! let mut binding = Binding::new(&wires, &mesh.positions)?;
//! for frame in 0..24 {
//!     wires[0].pose[1][1] = frame as f32 / 24.0;
//!     binding.deform_into(&wires, &Blend::default(), &mut points)?;
//! }
//! assert_eq!(points[0], mesh.positions[0]); // a corner, out of reach: the same bits
//! assert!(points[32 * 65 + 32][1] > 0.3); // the middle
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A **preset** is an effect as text: wires with keys, or a wrinkle on a surface. An [`Evaluation`] binds its effects
//! to points and gives them back at any time.
//!
//! ```
//! use wirework::{Evaluation, parse, preset::Limits, surface::sphere};
//!
//! let text = "Wrinkle(
//!     pattern: Drawn([CatmullRom(points: [(-0.5, 0.6, 0.7), (0, 0.7, 0.8), (0.5, 0.6, 0.7)])]),
//!     intensity: Ease([(0, 0), (1, 0.05)]),
//! )";
//! let preset = parse(text.as_bytes(), &Limits::default())?.preset;
//! let skin = sphere([0.0; 3], 1.0, [64, 32])?;
//! let triangles = skin.triangles()?;
//! let mut wrinkle = Evaluation::new(&preset.effects, &skin.positions, &triangles)?;
//! let mut points = skin.positions.clone();
//! wrinkle.at(1.0, &mut points)?;
//! assert_eq!(wrinkle.wire_count(), 1);
//! assert!(points.iter().any(|p| p.iter().map(|c| c * c).sum::<f32>() > 1.04 * 1.04));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! And [`apply`] does the whole of it, from files to a **saved** animation: whatever the effect does not touch in a
//! glTF document, other clips too, comes out as it went in.
//!
//! ```
//! use wirework::{Job, apply, parse, preset::Limits};
//!
//! let text = "Deform(
//!     object: Grid(size: (2, 2), cells: (16, 16)),
//!     wires: [Wire(
//!         curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]),
//!         pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.5, 0), (1, 0.5, 0)])]),
//!     )],
//! )";
//! let preset = parse(text.as_bytes(), &Limits::default())?.preset;
//! let folder = tempfile::tempdir()?;
//! let out = folder.path().join("lift.glb");
//! let job = Job { output: Some(&out), ..Job::new(&preset, "lift.ron".as_ref()) };
//! let report = apply(&job, &mut |_| {})?;
//! assert_eq!((report.points, report.frames), (17 * 17, 25));
//! assert!(out.exists());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! To **see** it, [`picture`] renders a preset or an asset: a still, a row of moments, an animation.
//!
//! ```
//! use wirework::{PictureJob, Shown, picture, parse, preset::Limits};
//!
//! # let text = "Deform(
//! #     object: Grid(size: (2, 2), cells: (16, 16)),
//! #     wires: [Wire(curve: Polyline([(-1, 0, 0), (1, 0, 0)]), pose: [(-1, 0.5, 0), (1, 0.5, 0)])],
//! # )";
//! let preset = parse(text.as_bytes(), &Limits::default())?.preset;
//! # let folder = tempfile::tempdir()?;
//! # let out = folder.path().join("lift.png");
//! let shown = Shown::Preset { preset: &preset, path: "lift.ron".as_ref(), input: None };
//! let job = PictureJob { wires: true, size: Some([160, 90]), ..PictureJob::new(shown, &out) };
//! let report = picture(&job, &mut |_| {})?;
//! assert_eq!((report.size, report.moments), ([160, 90], 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The crates
//!
//! | module | its job |
//! |---|---|
//! | [`core`] | curves, wires, lattices, binding, deforming |
//! | [`surface`] | meshes, primitives, patches, normals, the nearest point, geodesics |
//! | [`wrinkle`] | crease wires from a pattern on a surface |
//! | [`preset`] | RON text to a checked effect |
//! | [`asset`] | glTF and OBJ: reading, and writing behind what was there |
//! | [`bake`] | frames to morph targets and a clip, to point caches, to a texture |
//! | [`render`] | pictures of meshes and wires |
//!
//! Here they are put together: [`Subject`] is what an effect works on, [`Evaluation`] the effect at any time,
//! [`schedule`] which times, [`apply`] and [`picture`] all of it. Nothing here prints.

mod apply;
mod bones;
mod caches;
mod decode;
mod engines;
mod error;
mod evaluate;
mod film;
mod fineness;
mod fit;
mod inspect;
mod joints;
mod limbs;
mod maps;
mod mask;
mod motion;
mod net;
mod output;
mod parts;
mod picture;
mod pieces;
mod posing;
mod preset_file;
mod reach;
mod record;
mod refine;
mod report;
mod schedule;
mod sew;
mod shade;
mod sides;
mod source;
mod stage;
mod strain;
mod subject;
mod unfit;
mod vat;
mod weld;

pub use wirework_asset as asset;
pub use wirework_bake as bake;
pub use wirework_core as core;
pub use wirework_ik as ik;
pub use wirework_preset as preset;
pub use wirework_render as render;
pub use wirework_stitch as stitch;
pub use wirework_surface as surface;
pub use wirework_wrinkle as wrinkle;

pub use wirework_core::{Binding, Blend, Curve, Wire};
pub use wirework_preset::parse;
pub use wirework_surface::Mesh;

pub use apply::{Job, Progress, apply};
pub use caches::CacheFacts;
pub use engines::{About, EngineMemory, Engines, Finding, Severity, engines};
pub use error::{Fault, JobError};
pub use evaluate::{EvaluateError, Evaluation, Spent};
pub use inspect::{
    AnimationFacts, AssetFacts, BorderFacts, BoundsFacts, EffectFacts, MeshFacts, NodeFacts, PartFacts,
    PieceFacts, PresetFacts, RefusedAsset, SeamFacts, SkinFacts, inspect_asset,
};
pub use maps::{MapGroup, MapHeight, MapJob, MapMask, MapMesh, MapReport, bake_map};
pub use mask::check_images;
pub use net::ControlNet;
pub use parts::MeshPart;
pub use picture::{PictureJob, PictureReport, Shown, Viewpoint, picture};
pub use pieces::{Pieces, SubjectPiece};
pub use preset_file::{PresetFile, PresetFileError, parse_preset, read_preset};
pub use refine::{FinerMesh, Refinement};
pub use report::{BakeReport, NewClip, NodeReport, Report, Skeleton};
pub use schedule::{Schedule, ScheduleError, When, schedule};
pub use subject::{FileKind, Model, Subject};
pub use vat::{VatFacts, VatJob};
