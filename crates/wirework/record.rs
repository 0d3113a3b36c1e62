//! Where vertices are at every frame, kept for files that are written when all frames are known.

use std::path::{Path, PathBuf};

use wirework_asset::{FrameStore, Gltf, Rest};
use wirework_surface::smooth_normals;

use crate::JobError;
use crate::film::Posed;
use crate::motion::Motion;
use crate::shade::Vertices;

/// A normal for vertices that have no face.
const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// Takes in vertices while an effect plays.
pub(crate) struct Recorder<'a> {
    vertices: Vertices,
    posed: Option<(&'a Rest, Posed<'a>)>,
    positions: FrameStore,
    normals: Option<Shaded<'a>>,
}

/// Normals that are kept too.
struct Shaded<'a> {
    store: FrameStore,
    triangles: &'a [[u32; 3]],
    /// Whether some vertices have none of their own.
    bare: bool,
}

impl<'a> Recorder<'a> {
    /// For positions alone; they are kept on the disk of `folder`.
    pub(crate) fn of_positions(
        positions: &[[f32; 3]],
        point_of: &[u32],
        folder: &Path,
    ) -> Result<Self, JobError> {
        let store = FrameStore::new_in(folder, positions.len())?;
        let vertices = Vertices::new(positions.to_vec(), point_of.to_vec());
        Ok(Self { vertices, posed: None, positions: store, normals: None })
    }

    /// For the vertices of a scene with normals, of which every vertex gets one.
    pub(crate) fn of_scene(rest: &'a Rest, point_of: &[u32], folder: &Path) -> Result<Self, JobError> {
        let [positions, store] = [(); 2].map(|()| FrameStore::new_in(folder, rest.positions.len()));
        let bare = rest.blocks.iter().any(|block| block.normals.is_none());
        let normals = Some(Shaded { store: store?, triangles: &rest.triangles, bare });
        let vertices = Vertices::of_scene(rest, point_of.to_vec())?;
        Ok(Self { vertices, posed: None, positions: positions?, normals })
    }

    /// Takes vertices from now on as a clip poses them, where that drives the effect.
    pub(crate) fn posed_by(mut self, gltf: &'a Gltf, rest: &'a Rest, clip: usize) -> Result<Self, JobError> {
        self.posed = Some((rest, Posed::new(gltf, rest, clip)?));
        Ok(self)
    }

    /// Takes in the present moment.
    pub(crate) fn take(&mut self, motion: &Motion<'_>, seconds: f64) -> Result<(), JobError> {
        let Self { vertices, posed, positions: store, normals: shaded } = self;
        vertices.follow(motion)?;
        let (mut positions, mut normals) = (vertices.positions.as_slice(), vertices.normals());
        if let Some((rest, posed)) = posed {
            posed.pose(rest, seconds, positions, normals)?;
            positions = &posed.positions;
            normals = normals.and(Some(&posed.normals));
        }
        store.push(positions)?;
        if let Some(shaded) = shaded {
            shaded.push(positions, normals)?;
        }
        Ok(())
    }

    /// Whether nothing has been taken in yet.
    pub(crate) fn waits(&self) -> bool {
        self.positions.frames() == 0
    }

    /// What was taken in: positions, and normals if they were to be kept.
    pub(crate) fn into_stores(self) -> (FrameStore, Option<FrameStore>) {
        (self.positions, self.normals.map(|shaded| shaded.store))
    }
}

impl Shaded<'_> {
    fn push(&mut self, positions: &[[f32; 3]], normals: Option<&[[f32; 3]]>) -> Result<(), JobError> {
        let mut all = normals.map_or_else(|| vec![[0.0; 3]; positions.len()], <[_]>::to_vec);
        if self.bare {
            let smooth = smooth_normals(positions, self.triangles);
            let without = all.iter_mut().zip(smooth).filter(|(normal, _)| **normal == [0.0; 3]);
            without.for_each(|(normal, own)| *normal = own);
        }
        all.iter_mut().filter(|normal| **normal == [0.0; 3]).for_each(|normal| *normal = UP);
        Ok(self.store.push(&all)?)
    }
}

/// The folder nearest to a path that is there already: the one it is in, or one above that.
pub(crate) fn folder_there(path: &Path) -> PathBuf {
    let above = path.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
    above.map(Path::to_path_buf).find(|folder| folder.is_dir()).unwrap_or_else(|| PathBuf::from("."))
}
