//! Running the command as a user does.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A wire across a grid that rises by half a metre in a second: at distance `z` a point rises by
/// `(1 − (z/0.5)²)² · t/2`.
pub(crate) const LIFT: &str = "Deform(
    object: Grid(size: (2, 2), cells: (16, 16)),
    wires: [Wire(
        curve: Polyline(points: [(-1, 0, 0), (1, 0, 0)]),
        pose: Keys([(0, [(-1, 0, 0), (1, 0, 0)]), (1, [(-1, 0.5, 0), (1, 0.5, 0)])]),
        radius: 0.5,
    )],
)
";

/// The height of a point of [`LIFT`] at rest distance `z`, `t` seconds in.
pub(crate) fn lifted(z: f64, t: f64) -> f64 {
    let x = (z / 0.5).abs().min(1.0);
    (1.0 - x * x).powi(2) * 0.5 * t
}

/// A folder of its own with the preset `lift.ron` in it.
pub(crate) struct Place {
    folder: TempDir,
}

impl Place {
    pub(crate) fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().expect("a folder") };
        place.write("lift.ron", LIFT);
        place
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("a file");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder");
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
        let mut names: Vec<String> =
            entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs the command in this folder; arguments are split at spaces.
    pub(crate) fn run(&self, line: &str) -> Done {
        self.run_with(line.split_whitespace(), b"")
    }

    /// Runs it with these arguments and something on standard input.
    pub(crate) fn run_with<'a>(&self, args: impl IntoIterator<Item = &'a str>, input: &[u8]) -> Done {
        let mut child = Command::new(env!("CARGO_BIN_EXE_wirework"))
            .args(args)
            .current_dir(self.folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command");
        let mut stdin = child.stdin.take().expect("standard input");
        // A command that does not read it closes it.
        let _ = stdin.write_all(input);
        drop(stdin);
        Done(child.wait_with_output().expect("its output"))
    }
}

/// A command that has ended.
pub(crate) struct Done(Output);

impl Done {
    pub(crate) fn code(&self) -> i32 {
        self.0.status.code().expect("an exit code")
    }

    pub(crate) fn out(&self) -> String {
        String::from_utf8(self.0.stdout.clone()).expect("UTF-8")
    }

    pub(crate) fn err(&self) -> String {
        String::from_utf8(self.0.stderr.clone()).expect("UTF-8")
    }

    /// Ends the test unless the exit code is `code`.
    #[track_caller]
    pub(crate) fn expect(self, code: i32) -> Self {
        assert_eq!(self.code(), code, "{}", self.err());
        self
    }
}

/// One of the shared assets, where they are present.
pub(crate) fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/assets").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("the shared assets are not present: {name} is passed over");
    None
}
