//! Files that are written whole or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::mem::take;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread;

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::content::Content;
use crate::error::{AssetError, ErrorClass};
use crate::limits::reserve;
use crate::store::Store;

/// How the names of files begin that are written beside their places.
const PREFIX: &str = ".wirework-";

/// So many bytes are written before they are flushed while more are written: the disk and the system's copying work side by side, for
/// a tenth to a fifth less time in all. With fewer flushing itself takes longer.
const STEP: usize = 8 << 20;

/// A file to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// What, one part behind the other: so that large ones need not be copied into one.
    pub parts: Vec<Content>,
    /// Whether it may replace a file. Copies of files that belong to an input may not replace other files.
    pub replace: bool,
    /// Whether folders are made that are not there.
    pub folders: bool,
}

impl OutputFile {
    /// A file that replaces what stands at `path`.
    pub fn new(path: impl Into<PathBuf>, bytes: Vec<u8>) -> Self {
        Self { path: path.into(), parts: vec![bytes.into()], replace: true, folders: false }
    }

    /// All of what is written, in one.
    ///
    /// # Errors
    ///
    /// Of class [`ErrorClass::Io`]: the file that keeps some of it cannot be read. Of class [`ErrorClass::Limit`]: it does not fit into
    /// memory.
    pub fn bytes(&self) -> Result<Vec<u8>, AssetError> {
        let mut out = reserve(self.parts.iter().map(Content::len).sum())?;
        self.parts.iter().try_for_each(|part| part.read_onto(&mut out))?;
        Ok(out)
    }
}

/// Writes files, in their order: all are written beside their places and flushed before the first takes its place,
/// so that a failure leaves what was there before, and nothing else.
pub fn write_files(files: &[OutputFile]) -> Result<(), AssetError> {
    write_files_and(files, &[])
}

/// Writes the bytes of a file to what it is given.
pub type WriteBytes<'a> = Box<dyn Fn(&mut dyn Write) -> std::io::Result<()> + 'a>;

/// A file whose bytes are made while it is written, for they are too many to be kept. It replaces what stands in its place.
pub struct MadeFile<'a> {
    /// Where.
    pub path: PathBuf,
    /// Whether folders are made that are not there.
    pub folders: bool,
    /// Writes it.
    pub write: WriteBytes<'a>,
}

impl std::fmt::Debug for MadeFile<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MadeFile").field("path", &self.path).finish_non_exhaustive()
    }
}

/// Writes files as [`write_files`] does, and behind them those that are made meanwhile: all of them, or none.
pub fn write_files_and(files: &[OutputFile], made: &[MadeFile<'_>]) -> Result<(), AssetError> {
    let mut folders = Vec::new();
    let result = write_all(files, made, &mut folders);
    if result.is_err() {
        // Only folders that are still empty go, the innermost first.
        folders.iter().rev().for_each(|folder| drop(fs::remove_dir(folder)));
    }
    result
}

/// Files that are made one after the other and written together: until then they are kept out of memory, in a file without a name that
/// goes with the process.
#[derive(Debug)]
pub struct Spool {
    store: Arc<Store>,
    files: Vec<OutputFile>,
}

impl Spool {
    /// An empty one.
    ///
    /// # Errors
    ///
    /// The system's folder for temporary files takes none.
    pub fn new() -> Result<Self, AssetError> {
        Ok(Self { store: Arc::new(Store::new(None)?), files: Vec::new() })
    }

    /// Adds a file.
    ///
    /// # Errors
    ///
    /// The disk is full, or cannot be written.
    pub fn add(&mut self, mut file: OutputFile) -> Result<(), AssetError> {
        let parts = take(&mut file.parts).into_iter().map(|part| part.stored(&self.store));
        file.parts = parts.collect::<Result<_, _>>()?;
        self.files.push(file);
        Ok(())
    }

    /// How many files there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Writes all of them, as [`write_files`] does.
    ///
    /// # Errors
    ///
    /// A file cannot be written; then none is.
    pub fn write(self) -> Result<(), AssetError> {
        write_files(&self.files)
    }
}

/// What is in a file.
enum Body<'a> {
    Parts(&'a [Content]),
    Made(&'a WriteBytes<'a>),
}

impl Body<'_> {
    fn write(&self, mut file: &File) -> io::Result<()> {
        match self {
            Self::Parts(parts) => write_parts(file, parts, || {}),
            Self::Made(write) => write(&mut file),
        }
    }

    fn write_flushed(&self, mut file: &File) -> io::Result<()> {
        match self {
            Self::Parts(parts) => write_flushed(file, parts),
            Self::Made(write) => write(&mut file).and_then(|()| file.sync_all()),
        }
    }
}

fn write_all(files: &[OutputFile], more: &[MadeFile<'_>], made: &mut Vec<PathBuf>) -> Result<(), AssetError> {
    // Closed, for a process may not have thousands of files open.
    let mut ready: Vec<(TempPath, PathBuf)> = Vec::new();
    let mut devices = Vec::new();
    let of_parts = files.iter().map(|file| (&file.path, Body::Parts(&file.parts), file.folders, Some(file)));
    let of_made = more.iter().map(|file| (&file.path, Body::Made(&file.write), file.folders, None));
    for (path, body, folders, file) in of_parts.chain(of_made) {
        let path = resolve(path);
        let metadata = fs::metadata(&path).ok();
        if metadata.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(refused(&path, "a folder", "a file, or no file yet"));
        }
        if let Some(file) = file.filter(|file| !file.replace && metadata.is_some()) {
            let bytes = file.bytes()?;
            if fs::read(&path).is_ok_and(|there| there == bytes) {
                continue;
            }
            return Err(refused(
                &path,
                "another file of the name of one that belongs to the input",
                "none: write a .glb, or into another folder",
            ));
        }
        if metadata.as_ref().is_some_and(|metadata| !metadata.is_file()) {
            devices.push((path, body));
            continue;
        }
        if folders {
            make_folders(folder_of(&path), made)?;
        }
        ready.push((prepare(&path, &body, metadata.as_ref())?.into_temp_path(), path));
    }
    for (path, body) in devices {
        let written = fs::OpenOptions::new().write(true).open(&path).and_then(|file| body.write(&file));
        written.map_err(|error| AssetError::output(&path, &error, "write"))?;
    }
    let mut folders = BTreeSet::new();
    for (temporary, path) in ready {
        temporary.persist(&path).map_err(|error| AssetError::output(&path, &error.error, "replace"))?;
        folders.insert(folder_of(&path).to_path_buf());
    }
    for folder in folders {
        // The files stand; whether the folder reaches the disk now or later is no failure of theirs.
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
    Ok(())
}

/// Makes the folders that a copied file stands in, and notes them.
fn make_folders(folder: &Path, made: &mut Vec<PathBuf>) -> Result<(), AssetError> {
    let missing: Vec<&Path> =
        folder.ancestors().take_while(|a| !a.as_os_str().is_empty() && !a.exists()).collect();
    for folder in missing.into_iter().rev() {
        fs::create_dir(folder).map_err(|error| AssetError::output(folder, &error, "make"))?;
        made.push(folder.to_path_buf());
    }
    Ok(())
}

/// Writes the parts, and `told` of every so many bytes.
fn write_parts(file: &File, parts: &[Content], mut told: impl FnMut()) -> io::Result<()> {
    // Small parts go together; large ones pass the buffer by.
    let mut out = BufWriter::new(file);
    let mut fresh = 0;
    for part in parts {
        for start in (0..part.len()).step_by(STEP) {
            let end = part.len().min(start + STEP);
            part.write(start..end, &mut out)?;
            fresh += end - start;
            if fresh >= STEP {
                told();
                fresh = 0;
            }
        }
    }
    out.flush()
}

/// Writes the parts and flushes them. Of a large file the disk gets what there is while the rest is being written.
fn write_flushed(file: &File, parts: &[Content]) -> io::Result<()> {
    let large = parts.iter().map(Content::len).sum::<usize>() >= 4 * STEP;
    let early = thread::scope(|scope| {
        let (tell, told) = channel();
        let flush = move || {
            while told.recv().is_ok() {
                // What has been written meanwhile goes together.
                while told.try_recv().is_ok() {}
                file.sync_data()?;
            }
            Ok(())
        };
        // Without a thread it is flushed at the end, as a small one is.
        let early = if large { thread::Builder::new().spawn_scoped(scope, flush).ok() } else { None };
        // Nobody hears it where there is no thread, or where flushing has failed.
        write_parts(file, parts, || tell.send(()).unwrap_or_default())?;
        drop(tell);
        // A failure is told once, to whoever flushes next.
        early.map_or(Ok(()), |early| early.join().unwrap_or_else(|_| Err(io::Error::other("no flush"))))
    });
    early.and_then(|()| file.sync_all())
}

/// Writes a new file in the folder of `path`.
fn prepare(path: &Path, body: &Body<'_>, old: Option<&fs::Metadata>) -> Result<NamedTempFile, AssetError> {
    let fail = |error: &std::io::Error| AssetError::output(path, error, "write");
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(refused(folder, "no such folder", "a folder to write into"));
    }
    let mut builder = Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    {
        // As any new file: readable as the user's mask says, not private as temporary files are.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder).map_err(|error| fail(&error))?;
    if let Some(old) = old {
        if old.permissions().readonly() {
            return Err(refused(path, "a file that is read-only", "one that may be replaced"));
        }
        file.as_file().set_permissions(old.permissions()).map_err(|error| fail(&error))?;
    }
    body.write_flushed(file.as_file()).map_err(|error| fail(&error))?;
    Ok(file)
}

/// The file that a path stands for: what a link points to, so that the link stays.
fn resolve(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn refused(path: &Path, found: &str, expected: &str) -> AssetError {
    AssetError::file(found, expected).of_class(ErrorClass::Io).in_file(&path.display().to_string())
}

/// Whether two paths lead to one file, by whatever names and links. A path without a file is no other's file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    // Comparing opens them, and to open a pipe is to wait for its other end.
    let regular =
        |path: &Path| fs::metadata(path).is_ok_and(|metadata| metadata.is_file() || metadata.is_dir());
    regular(a) && regular(b) && same_file::is_same_file(a, b).unwrap_or(false)
}

/// Whether a new file can stand at `path`: before there is anything to write, and without leaving anything.
///
/// # Errors
///
/// Of class [`ErrorClass::Io`]: there is a folder in its place, or the folder it is to stand in takes no files.
pub fn check_output(path: &Path) -> Result<(), AssetError> {
    let path = resolve(path);
    match fs::metadata(&path) {
        Ok(metadata) if metadata.is_dir() => {
            return Err(refused(&path, "a folder", "a file, or no file yet"));
        }
        // A pipe or a terminal takes what it is given.
        Ok(metadata) if !metadata.is_file() => return Ok(()),
        Ok(metadata) if metadata.permissions().readonly() => {
            return Err(refused(&path, "a file that is read-only", "one that may be replaced"));
        }
        _ => {}
    }
    let folder = folder_of(&path);
    if !folder.is_dir() {
        return Err(refused(&path, "no such folder", "a folder to write into"));
    }
    // Only making a file tells whether one can be made; this one goes at once.
    match Builder::new().prefix(PREFIX).tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(error) => {
            Err(refused(&path, &format!("no place for it ({})", error.kind()), "a folder to write into"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.bin"), "old").unwrap();
        fs::create_dir(at("b.gltf")).unwrap();
        let files =
            [OutputFile::new(at("a.bin"), b"new".to_vec()), OutputFile::new(at("b.gltf"), b"new".to_vec())];
        let error = write_files(&files).unwrap_err();
        assert_eq!(error.class, ErrorClass::Io);
        assert_eq!(fs::read(at("a.bin")).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file stays");
        assert!(write_files(&[OutputFile::new(at("none/a.bin"), Vec::new())]).is_err());
    }

    #[test]
    fn files_are_replaced_and_foreign_ones_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_files(&[OutputFile::new(&path, b"1".to_vec())]).unwrap();
        write_files(&[OutputFile::new(&path, b"2".to_vec())]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"2");
        let copy = |bytes: &[u8]| [OutputFile { replace: false, ..OutputFile::new(&path, bytes.to_vec()) }];
        write_files(&copy(b"2")).unwrap();
        assert!(write_files(&copy(b"3")).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"2");
    }

    #[test]
    fn a_spool_writes_more_files_than_may_be_open() {
        const MANY: usize = 1100;
        let folder = tempfile::tempdir().unwrap();
        let at = |k: usize| folder.path().join(format!("new/{k}"));
        let mut spool = Spool::new().unwrap();
        for k in 0..MANY {
            let file = OutputFile::new(at(k), k.to_string().into_bytes());
            spool.add(OutputFile { folders: true, ..file }).unwrap();
        }
        assert_eq!((spool.len(), fs::read_dir(folder.path()).unwrap().count()), (MANY, 0));
        spool.write().unwrap();
        assert!((0..MANY).all(|k| fs::read(at(k)).unwrap() == k.to_string().as_bytes()));
        let mut spool = Spool::new().unwrap();
        spool.add(OutputFile::new(at(0), b"new".to_vec())).unwrap();
        spool.add(OutputFile::new(folder.path(), b"new".to_vec())).unwrap();
        assert!(spool.write().is_err() && fs::read(at(0)).unwrap() == b"0", "none is written");
    }

    #[test]
    fn files_that_are_made_stand_or_fall_with_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let file = [OutputFile::new(at("a"), b"a".to_vec())];
        let made = |name: &str, fails: bool| MadeFile {
            path: at(name),
            folders: true,
            write: Box::new(move |out| {
                out.write_all(b"made")?;
                if fails { Err(std::io::Error::other("no more")) } else { Ok(()) }
            }),
        };
        let error = write_files_and(&file, &[made("new/b", false), made("c", true)]).unwrap_err();
        assert!(error.class == ErrorClass::Io && error.to_string().contains("no more"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "neither files nor folders");
        write_files_and(&file, &[made("new/b", false), made("c", false)]).unwrap();
        assert!(fs::read(at("new/b")).unwrap() == b"made" && fs::read(at("a")).unwrap() == b"a");
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_never_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(
            std::process::Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success())
        );
        fs::write(folder.path().join("a"), "x").unwrap();
        assert!(!same_file(&pipe, &folder.path().join("a")) && check_output(&pipe).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_to_their_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "x").unwrap();
        fs::write(at("other"), "x").unwrap();
        fs::hard_link(at("a"), at("hard")).unwrap();
        std::os::unix::fs::symlink(at("a"), at("soft")).unwrap();
        assert!(same_file(&at("a"), &at("hard")) && same_file(&at("a"), &at("soft")));
        assert!(same_file(
            &at("a"),
            &folder.path().join("../").join(folder.path().file_name().unwrap()).join("a")
        ));
        assert!(!same_file(&at("a"), &at("other")) && !same_file(&at("a"), &at("none")));
        write_files(&[OutputFile::new(at("soft"), b"new".to_vec())]).unwrap();
        assert!(fs::symlink_metadata(at("soft")).unwrap().is_symlink());
        assert_eq!(fs::read(at("a")).unwrap(), b"new");
    }
}
