//! Frames on their way into files that have another order than they come in, kept out of memory.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::error::AssetError;

/// Points at every frame, in a file without a name that goes with the process: whoever ends it leaves nothing behind.
#[derive(Debug)]
pub struct FrameStore {
    file: File,
    /// The folder that the file is in.
    folder: PathBuf,
    points: usize,
    frames: usize,
}

impl FrameStore {
    /// An empty one for frames of so many points, on the disk of `folder`.
    ///
    /// # Errors
    ///
    /// The folder takes no file.
    pub fn new_in(folder: &Path, points: usize) -> Result<Self, AssetError> {
        let file = tempfile::tempfile_in(folder);
        let file = file.map_err(|error| AssetError::output(folder, &error, "keep frames in"))?;
        Ok(Self { file, folder: folder.to_path_buf(), points, frames: 0 })
    }

    /// Adds a frame; what it has of points too many is left out, what it has too few of is 0.
    ///
    /// # Errors
    ///
    /// The disk is full, or cannot be written.
    pub fn push(&mut self, frame: &[[f32; 3]]) -> Result<(), AssetError> {
        let own = frame.get(..self.points).unwrap_or(frame);
        let write = |file: &mut File| {
            file.write_all(bytemuck::cast_slice(own))?;
            file.write_all(&vec![0; 12 * (self.points - own.len())])
        };
        write(&mut self.file).map_err(|error| AssetError::output(&self.folder, &error, "keep frames in"))?;
        self.frames += 1;
        Ok(())
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// How many points each has.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Reads points of a frame from `first` on, as many as `out` takes.
    ///
    /// # Errors
    ///
    /// There is no such frame, or not so many points; the disk cannot be read.
    pub fn read(&self, frame: usize, first: usize, out: &mut [[f32; 3]]) -> std::io::Result<()> {
        if frame >= self.frames || first + out.len() > self.points {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        let mut file = &self.file;
        file.seek(SeekFrom::Start(12 * (frame as u64 * self.points as u64 + first as u64)))?;
        file.read_exact(bytemuck::cast_slice_mut(out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_in_any_order_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = FrameStore::new_in(folder.path(), 3).unwrap();
        let frame = |k: f32| [[k, -k, 0.5], [f32::MIN_POSITIVE, -0.0, k], [1.0, 2.0, 3.0]];
        (0..5).for_each(|k| store.push(&frame(k as f32)).unwrap());
        store.push(&[[7.0; 3]]).unwrap();
        assert_eq!((store.frames(), store.points()), (6, 3));
        let mut out = [[0.0; 3]; 2];
        for k in [4, 0, 3] {
            store.read(k, 1, &mut out).unwrap();
            assert_eq!(
                out.map(|p| p.map(f32::to_bits)),
                [1, 2].map(|i| frame(k as f32)[i].map(f32::to_bits))
            );
        }
        store.read(5, 0, &mut out).unwrap();
        assert_eq!(out, [[7.0; 3], [0.0; 3]]);
        assert!(store.read(6, 0, &mut out).is_err() && store.read(0, 2, &mut out).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
