//! Bytes kept out of memory, in a file without a name: it goes with the process, however that ends.

use std::env::temp_dir;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crate::content::Content;
use crate::error::AssetError;
use crate::limits::filled;

/// Bytes of displacements that a document holds in memory where nothing else is said: as much as a small effect has in all, so that it
/// needs no room on a disk, and little beside what a large one takes to be worked out.
pub const HELD_BYTES: usize = 128 << 20;

/// Bytes that are compared at a time: enough that asking for them costs little, and few beside one target.
const BLOCK: usize = 1 << 14;

/// A file without a name that grows at its end. Copies of a document share one: each refers to stretches of its own, and none is
/// written a second time.
#[derive(Debug)]
pub(crate) struct Store {
    folder: PathBuf,
    tail: Mutex<Tail>,
}

#[derive(Debug)]
struct Tail {
    file: File,
    /// Where the last stretch ends; what lies behind it was not written whole.
    end: u64,
}

impl Store {
    /// An empty one in `folder`, or where that takes no file, or there is none, in the system's folder for temporary ones.
    pub(crate) fn new(folder: Option<&Path>) -> Result<Self, AssetError> {
        let made =
            folder.and_then(|folder| Some((folder.to_path_buf(), tempfile::tempfile_in(folder).ok()?)));
        let (folder, file) = if let Some(made) = made {
            made
        } else {
            let folder = temp_dir();
            let made = tempfile::tempfile_in(&folder);
            let file = made.map_err(|error| AssetError::output(&folder, &error, "keep data in"))?;
            (folder, file)
        };
        Ok(Self { folder, tail: Mutex::new(Tail { file, end: 0 }) })
    }

    /// Takes bytes in.
    pub(crate) fn add(self: &Arc<Self>, bytes: &[u8]) -> Result<Stored, AssetError> {
        let mut tail = self.tail();
        let start = tail.end;
        let written = tail.file.seek(SeekFrom::Start(start)).and_then(|_| tail.file.write_all(bytes));
        written.map_err(|error| AssetError::output(&self.folder, &error, "keep data in"))?;
        tail.end += bytes.len() as u64;
        Ok(Stored { store: Arc::clone(self), start, length: bytes.len(), loaded: OnceLock::new() })
    }

    fn read(&self, start: u64, into: &mut [u8]) -> Result<(), AssetError> {
        let mut tail = self.tail();
        let read = tail.file.seek(SeekFrom::Start(start)).and_then(|_| tail.file.read_exact(into));
        read.map_err(|error| AssetError::output(&self.folder, &error, "read back what is kept in"))
    }

    /// The file; whoever panicked with it left what counts of it as it was.
    fn tail(&self) -> MutexGuard<'_, Tail> {
        self.tail.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A stretch of a store.
#[derive(Clone, Debug)]
pub(crate) struct Stored {
    store: Arc<Store>,
    start: u64,
    length: usize,
    /// Its bytes, once somebody looked at them.
    loaded: OnceLock<Vec<u8>>,
}

impl Stored {
    pub(crate) fn len(&self) -> usize {
        self.length
    }

    pub(crate) fn truncate(&mut self, length: usize) {
        self.length = self.length.min(length);
        self.loaded = OnceLock::new();
    }

    /// Its bytes, which are in memory from then on.
    pub(crate) fn bytes(&self) -> Result<&[u8], AssetError> {
        if let Some(bytes) = self.loaded.get() {
            return Ok(bytes);
        }
        let mut bytes = filled(self.length, 0)?;
        self.store.read(self.start, &mut bytes)?;
        Ok(self.loaded.get_or_init(|| bytes))
    }

    /// Puts its bytes behind others, and keeps none.
    pub(crate) fn read_onto(&self, out: &mut Vec<u8>) -> Result<(), AssetError> {
        let before = out.len();
        out.resize(before + self.length, 0);
        self.store.read(self.start, out.get_mut(before..).unwrap_or_default())
    }

    /// Whether its bytes from `offset` on begin with these. They are looked at block by block.
    pub(crate) fn holds(&self, offset: usize, bytes: &[u8]) -> Result<bool, AssetError> {
        if self.length.checked_sub(offset).is_none_or(|rest| rest < bytes.len()) {
            return Ok(false);
        }
        let mut there = [0; BLOCK];
        let mut start = self.start + offset as u64;
        for block in bytes.chunks(BLOCK) {
            let Some(there) = there.get_mut(..block.len()) else { return Ok(false) };
            self.store.read(start, there)?;
            if there != block {
                return Ok(false);
            }
            start += block.len() as u64;
        }
        Ok(true)
    }

    /// Writes a range of its bytes to a file, without them passing through memory of ours where the system can do that.
    pub(crate) fn copy(&self, range: Range<usize>, out: &mut &File) -> io::Result<()> {
        let length = range.end.min(self.length).saturating_sub(range.start) as u64;
        let tail = self.store.tail();
        (&tail.file).seek(SeekFrom::Start(self.start + range.start as u64))?;
        match io::copy(&mut (&tail.file).take(length), out)? {
            copied if copied == length => Ok(()),
            _ => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }
}

/// How much a document holds in memory, and where it puts the rest.
#[derive(Clone, Debug)]
pub(crate) struct Spill {
    /// Bytes it may hold, and holds.
    most: usize,
    held: usize,
    folder: Option<PathBuf>,
    store: Option<Arc<Store>>,
}

impl Default for Spill {
    fn default() -> Self {
        Self::new(HELD_BYTES, None)
    }
}

impl Spill {
    pub(crate) fn new(most: usize, folder: Option<&Path>) -> Self {
        Self { most, held: 0, folder: folder.map(Path::to_path_buf), store: None }
    }

    /// Content as it is while there is room for it in memory, and kept out of it from then on.
    pub(crate) fn keep(&mut self, content: Content) -> Result<Content, AssetError> {
        let held = self.held.saturating_add(content.len());
        if held <= self.most {
            self.held = held;
            return Ok(content);
        }
        let store = match &self.store {
            Some(store) => store,
            None => self.store.insert(Arc::new(Store::new(self.folder.as_deref())?)),
        };
        content.stored(store)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorClass;

    #[test]
    fn stretches_are_what_was_put_in_and_do_not_touch() {
        let folder = tempfile::tempdir().unwrap();
        let store = Arc::new(Store::new(Some(folder.path())).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "it has no name");
        let long: Vec<u8> = (0..2 * BLOCK + 5).map(|i| (i % 251) as u8).collect();
        let first = store.add(&long).unwrap();
        let mut second = store.add(b"abcdef").unwrap();
        assert_eq!((first.bytes().unwrap(), second.bytes().unwrap()), (&long[..], &b"abcdef"[..]));
        second.truncate(4);
        let mut all = b"0".to_vec();
        second.read_onto(&mut all).unwrap();
        assert_eq!((&all[..], second.bytes().unwrap()), (&b"0abcd"[..], &b"abcd"[..]));
        assert!(first.holds(0, &long).unwrap() && first.holds(7, &long[7..BLOCK + 9]).unwrap());
        assert!(!first.holds(1, &long).unwrap() && !second.holds(0, b"abcde").unwrap());
        assert!(!first.holds(0, &[&long[..BLOCK + 3], &[0]].concat()).unwrap());
        assert!(!second.holds(usize::MAX, b"").unwrap());
    }

    #[test]
    fn copies_go_to_a_file_from_where_it_stands() {
        let store = Arc::new(Store::new(None).unwrap());
        let (a, b) = (store.add(b"abc").unwrap(), store.add(b"defg").unwrap());
        let mut out = tempfile::tempfile().unwrap();
        for (stored, range) in [(&b, 0..4), (&a, 0..3), (&b, 1..3), (&a, 3..3)] {
            stored.copy(range, &mut &out).unwrap();
        }
        let mut text = String::new();
        out.rewind().unwrap();
        out.read_to_string(&mut text).unwrap();
        assert_eq!(text, "defgabcef");
    }

    #[test]
    fn another_folder_serves_where_one_does_not() {
        let store = Store::new(Some(Path::new("none/of/these"))).unwrap();
        assert_eq!(store.folder, temp_dir());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_of_the_output() {
        let file = File::options().read(true).write(true).open("/dev/full").unwrap();
        let store = Arc::new(Store { folder: "full".into(), tail: Mutex::new(Tail { file, end: 0 }) });
        let error = store.add(b"abc").unwrap_err();
        assert_eq!((error.class, error.file.as_str()), (ErrorClass::Io, "full"));
        assert!(error.found.contains("No space"), "{error}");
        assert_eq!(store.tail().end, 0);
    }
}
