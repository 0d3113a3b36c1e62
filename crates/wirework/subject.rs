//! What an effect works on: the object of a preset, an OBJ file or a glTF scene, as points and triangles.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use wirework_asset::{AssetError, Gltf, Limits, Obj, Rest};
use wirework_preset::{Action, Effect, Object, Piece, Preset, PresetError};
use wirework_surface::{Bounds, Mesh, Transform};

use crate::fit::Fit;
use crate::limbs::limbs;
use crate::mask::{Masks, masks};
use crate::parts::{MeshPart, of_positions};
use crate::posing::Posing;
use crate::sew::sew;
use crate::strain::{driving_clip, found, sense, sense_before};
use crate::unfit::unfit;
use crate::weld::{ANY, Weld};
use crate::{ControlNet, Evaluation, JobError, Pieces, SubjectPiece};

/// An object ready for an effect.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The points that wires act on, each place once, at rest and in world space; or the control points of a patch.
    pub points: Vec<[f32; 3]>,
    /// The triangles between them, counter-clockwise seen from outside; a point set has none.
    pub triangles: Vec<[u32; 3]>,
    /// Where the points come from and go to.
    pub model: Model,
    /// Where there is one, the points are its control points, and the model is the surface they make.
    pub net: Option<ControlNet>,
    /// Which points belong to which piece of a stitch; of other subjects there are none.
    pub pieces: Pieces,
    /// For each position of the model its point; with a net its point of the surface.
    pub(crate) point_of: Vec<u32>,
    pub(crate) origin: Origin,
}

/// Who answers for an object that an effect does not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A preset, which makes it of numbers.
    Preset,
    /// A program, which hands it over.
    Program,
    /// A file, as messages name it.
    File(String),
}

/// A model in the form that it came in.
#[derive(Clone, Debug)]
pub enum Model {
    /// A polygon mesh or a point set.
    Mesh {
        /// Its parts, a node each in a glTF document: the pieces of a stitch, and whatever else is one.
        parts: Vec<MeshPart>,
        /// The geometry of all of them.
        mesh: Mesh,
        /// The file it was read from, if there is one.
        obj: Option<Box<Obj>>,
    },
    /// A glTF scene.
    Gltf {
        /// The document.
        gltf: Box<Gltf>,
        /// Its rest geometry.
        rest: Box<Rest>,
    },
}

/// The kinds of files an effect can work on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A `.glb` or a `.gltf`.
    Gltf,
    /// A Wavefront OBJ.
    Obj,
}

impl FileKind {
    /// What a file is: by its extension, or else by its first bytes. None where neither says.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "glb" | "gltf" => return Some(Self::Gltf),
            "obj" => return Some(Self::Obj),
            _ => {}
        }
        let mut magic = [0; 4];
        File::open(path).and_then(|mut file| file.read_exact(&mut magic)).ok()?;
        (&magic == b"glTF").then_some(Self::Gltf)
    }
}

impl Subject {
    /// Reads a `.glb`, `.gltf` or `.obj`.
    ///
    /// # Errors
    ///
    /// The file cannot be read, is malformed or larger than `limits`, or is of no known kind.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self, JobError> {
        match FileKind::of(path) {
            Some(FileKind::Obj) => {
                let obj = Obj::read(path, limits)?;
                Self::from_obj(stem(path), obj)
            }
            Some(FileKind::Gltf) => Ok(Self::from_gltf(Gltf::read(path, limits)?)?),
            // Reading it says what is wrong with it where it is missing.
            None => match Gltf::read(path, limits) {
                Err(error) if !path.is_file() => Err(error.into()),
                _ => Err(JobError::UnknownFile { path: path.to_path_buf() }),
            },
        }
    }

    /// What a preset works on: `input`, or else the object that the preset brings along, and the pieces of its stitches. None
    /// where an input is missing. The node of its object is called as the preset's file is.
    ///
    /// # Errors
    ///
    /// As [`Subject::from_object`] and [`Subject::from_pieces`].
    pub fn for_preset(
        input: Option<Self>,
        preset: &Preset,
        preset_path: &Path,
        limits: &Limits,
    ) -> Result<Option<Self>, JobError> {
        let base = match input {
            Some(input) => Some(input),
            None => Self::from_preset(preset, preset_path, limits)?,
        };
        let mut pieces = preset.pieces();
        if base.is_none() && pieces.first().is_some_and(|piece| piece.object.is_some()) {
            // Where the first stitch brings all of its own along, it is for others to say that there is no more.
            pieces.retain(|piece| piece.object.is_some() || of_first(preset, piece));
        }
        if pieces.is_empty() || (base.is_none() && pieces.iter().any(|piece| piece.object.is_none())) {
            return Ok(base);
        }
        let pieces: Vec<_> = pieces.into_iter().map(|piece| (&piece.name, piece.object.as_ref())).collect();
        let folder = preset_path.parent().unwrap_or(Path::new(""));
        Self::from_pieces(base, &pieces, folder, limits).map(Some)
    }

    /// The object that a preset brings along, if it does; its node is called as the preset's file is.
    ///
    /// # Errors
    ///
    /// As [`Subject::from_object`].
    pub fn from_preset(
        preset: &Preset,
        preset_path: &Path,
        limits: &Limits,
    ) -> Result<Option<Self>, JobError> {
        let folder = preset_path.parent().unwrap_or(Path::new(""));
        let object = preset.object.as_ref();
        object.map(|object| Self::from_object(object, folder, &stem(preset_path), limits)).transpose()
    }

    /// An object that a preset brings along. `name` is what its node is called; `preset_dir` is the folder of the preset.
    ///
    /// # Errors
    ///
    /// The object cannot be built, or its file cannot be read.
    pub fn from_object(
        object: &Object,
        preset_dir: &Path,
        name: &str,
        limits: &Limits,
    ) -> Result<Self, JobError> {
        let Some(path) = object.file(preset_dir) else {
            let size = object.shape.size();
            limits.check_mesh(size.vertices, size.indices)?;
            let mut mesh = object.build()?.unwrap_or_default();
            let Some((net, controls)) = ControlNet::of(object)? else {
                return Ok(Self { origin: Origin::Preset, ..Self::from_mesh(name, mesh)? });
            };
            // What does not move is to have the bits that evaluating it gives.
            net.evaluate_into(&controls.positions, &mut mesh.positions)?;
            let (triangles, points) = (controls.triangles()?, controls.positions);
            let subject = Self::from_mesh(name, mesh)?;
            return Ok(Self { origin: Origin::Preset, points, triangles, net: Some(net), ..subject });
        };
        let subject = Self::read(&path, limits)?;
        if object.transform == Transform::default() {
            return Ok(subject);
        }
        match subject.model {
            Model::Mesh { parts, mut mesh, obj } => {
                object.transform.apply_to_mesh(&mut mesh).map_err(|error| JobError::Object(error.into()))?;
                Self::new(Model::Mesh { parts, mesh, obj })
            }
            Model::Gltf { mut gltf, .. } => {
                gltf.place(&object.transform)?;
                Ok(Self::from_gltf(*gltf)?)
            }
        }
    }

    /// A mesh made by a program. `name` is what its node is called in a glTF document.
    ///
    /// # Errors
    ///
    /// The mesh is not consistent.
    pub fn from_mesh(name: &str, mesh: Mesh) -> Result<Self, JobError> {
        let parts = vec![MeshPart::whole(name, &mesh, true)];
        Self::new(Model::Mesh { parts, mesh, obj: None })
    }

    /// An OBJ file that has been read.
    fn from_obj(name: String, obj: Obj) -> Result<Self, JobError> {
        let parts = vec![MeshPart::whole(name, &obj.mesh, false)];
        Self::new(Model::Mesh { parts, mesh: obj.mesh.clone(), obj: Some(Box::new(obj)) })
    }

    /// The scene of a glTF document.
    ///
    /// # Errors
    ///
    /// Its geometry is malformed or larger than the limits, or there is none.
    pub fn from_gltf(gltf: Gltf) -> Result<Self, AssetError> {
        let rest = gltf.rest()?;
        let weld = Weld::new(&rest.positions);
        let triangles = weld.triangles(&rest.triangles);
        let origin = Origin::File(gltf.file().to_owned());
        let model = Model::Gltf { gltf: Box::new(gltf), rest: Box::new(rest) };
        Ok(Self::welded(weld, triangles, model, origin))
    }

    fn welded(weld: Weld, triangles: Vec<[u32; 3]>, model: Model, origin: Origin) -> Self {
        let Weld { points, point_of } = weld;
        Self { points, triangles, model, point_of, net: None, pieces: Pieces::default(), origin }
    }

    pub(crate) fn new(model: Model) -> Result<Self, JobError> {
        Self::with_pieces(model, Vec::new(), &[], &[])
    }

    /// A model in pieces: for each of its positions the piece, and in a glTF scene the number that sets a vertex apart from others
    /// of its piece at its place, or [`ANY`]; the sides of the pieces are lists of positions.
    pub(crate) fn with_pieces(
        model: Model,
        list: Vec<SubjectPiece>,
        of_positions: &[u32],
        own: &[u32],
    ) -> Result<Self, JobError> {
        let (weld, triangles, origin) = match &model {
            Model::Mesh { parts, mesh, obj } => {
                let triangles = mesh.triangles()?;
                let weld = weld_parts(parts, mesh, of_positions);
                let origin = obj.as_ref().map_or(Origin::Program, |obj| Origin::File(obj.file().to_owned()));
                (weld, triangles, origin)
            }
            Model::Gltf { gltf, rest } => {
                let weld = Weld::in_pieces(&rest.positions, of_positions, own);
                (weld, rest.triangles.clone(), Origin::File(gltf.file().to_owned()))
            }
        };
        let triangles = weld.triangles(&triangles);
        let pieces = Pieces::of_model(list, of_positions, &weld.point_of, weld.points.len());
        Ok(Self { pieces, ..Self::welded(weld, triangles, model, origin) })
    }

    /// Binds the effects of a preset to the points. Files that it names are relative to `preset_dir`. What a clip
    /// drives is driven by the first.
    ///
    /// # Errors
    ///
    /// An effect does not fit the object; a name or an image that an effect asks for is not there.
    pub fn bind<'a>(
        &'a self,
        preset: &Preset,
        preset_dir: &Path,
        limits: &Limits,
    ) -> Result<Evaluation<'a>, JobError> {
        let (effects, unfound) = found(self, preset, (preset_dir, limits), None)?;
        let masks = masks(self, &effects, preset_dir, limits)?.complete()?;
        self.bind_masked(&effects, masks, unfound, preset.duration)
    }

    /// The same, but names, colours and texture coordinates that the object lacks are no errors: they are listed beside, and
    /// the effects are bound without their `only` or `mask`.
    ///
    /// # Errors
    ///
    /// An effect does not fit the object; an image is not there or cannot be read.
    pub fn bind_lacking<'a>(
        &'a self,
        preset: &Preset,
        preset_dir: &Path,
        limits: &Limits,
    ) -> Result<(Evaluation<'a>, Vec<PresetError>), JobError> {
        let (effects, unfound) = found(self, preset, (preset_dir, limits), None)?;
        let mut masks = masks(self, &effects, preset_dir, limits)?;
        let missing = std::mem::take(&mut masks.missing);
        Ok((self.bind_masked(&effects, masks, unfound, preset.duration)?, missing))
    }

    fn bind_masked(
        &self,
        effects: &[Effect],
        masks: Masks,
        unfound: Vec<String>,
        duration: f64,
    ) -> Result<Evaluation<'_>, JobError> {
        let seams = sew(self, effects, &masks)?;
        let fit = Fit { masks, seams, limbs: limbs(self, effects, duration)? };
        let bound = Evaluation::fitted(effects, fit, &self.points, &self.triangles, self.bounds());
        let mut evaluation = bound.map_err(unfit(&self.origin, effects))?;
        evaluation.warnings.extend(unfound);
        if let (Some(clip), Model::Gltf { gltf, rest }) =
            (driving_clip(effects, &self.model, None)?, &self.model)
        {
            sense(&mut evaluation, gltf, rest, &self.point_of, clip)?;
            if evaluation.watches_nodes() {
                evaluation.pose_by(Posing::new((gltf, rest), clip, (&self.points, &self.point_of))?);
            }
        }
        sense_before(&mut evaluation, duration).map_err(unfit(&self.origin, effects))?;
        Ok(evaluation)
    }

    /// The box round the model at rest, which `units: Bounds` are parts of; none without a finite position.
    pub fn bounds(&self) -> Option<Bounds> {
        match &self.model {
            Model::Mesh { mesh, .. } => Bounds::of(&mesh.positions),
            Model::Gltf { .. } => Bounds::of(&self.points),
        }
    }

    /// How many positions the model has in its own form: those of a mesh, the vertices of a scene.
    pub fn position_count(&self) -> usize {
        self.point_of.len()
    }

    /// What was repaired or passed over when the model was read.
    pub fn warnings(&self) -> Vec<String> {
        let lines = |file: &str, warnings: &[wirework_asset::Warning]| -> Vec<String> {
            let file = wirework_asset::printable(file);
            warnings.iter().map(|warning| format!("{file}: {warning}")).collect()
        };
        match &self.model {
            Model::Mesh { obj, .. } => obj.as_ref().map_or_else(Vec::new, |o| lines(o.file(), &o.warnings)),
            Model::Gltf { gltf, rest } => {
                let mut all = lines(gltf.file(), gltf.warnings());
                all.extend(lines(gltf.file(), &rest.warnings));
                all
            }
        }
    }
}

/// The places of a mesh. What a preset makes lists each position once; files may not.
fn weld_parts(parts: &[MeshPart], mesh: &Mesh, pieces: &[u32]) -> Weld {
    match parts {
        _ if parts.iter().all(|part| part.distinct) => Weld::distinct(&mesh.positions),
        [_] if pieces.is_empty() => Weld::new(&mesh.positions),
        _ => {
            let of = of_positions(parts, mesh.positions.len());
            let is_distinct = |part: u32| parts.get(part as usize).is_some_and(|part| part.distinct);
            let number = |(i, &part): (u32, &u32)| if is_distinct(part) { i } else { ANY };
            let own: Vec<u32> = (0..).zip(&of).map(number).collect();
            // Parts that are no pieces are apart from each other, too.
            let apart: Vec<u32> = if pieces.is_empty() { of } else { pieces.to_vec() };
            Weld::in_pieces(&mesh.positions, &apart, &own)
        }
    }
}

/// Whether the first effect is a stitch that names a piece.
fn of_first(preset: &Preset, piece: &Piece) -> bool {
    let action = preset.effects.first().map(|effect| &effect.action);
    matches!(action, Some(Action::Stitch(stitching)) if stitching.pieces.contains(piece))
}

/// The name of a file without folder and extension.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "object".to_owned(), |stem| stem.to_string_lossy().into_owned())
}
