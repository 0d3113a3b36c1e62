//! Hostile and broken files: each is refused or accepted as a table says, in a process of its own with little memory
//! and little time, and what is refused leaves no file behind.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// Address space of one command, kilobytes as `ulimit -v` counts: what a machine can always spare.
const MEMORY: u32 = 2 * 1024 * 1024;
/// Seconds that one command may take, of the clock and of the processor.
const SECONDS: u32 = 10;
/// A folder of files and the table of what to do with them.
const FOLDER: &str = "../shared/hostile";

/// Reaches into every object, whatever its size.
const ANY: &str = "Deform(units: Bounds, wires: [Wire(
    curve: Polyline(points: [(-0.5, 0, 0), (0.5, 0, 0)]), radius: 1.5,
    pose: Keys([(0, [(-0.5, 0, 0), (0.5, 0, 0)]), (0.1, [(-0.5, 0.2, 0), (0.5, 0.3, 0)])]),
)])";

/// One file of the table.
struct Case {
    path: PathBuf,
    name: String,
    expect: String,
}

fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(FOLDER);
    let Ok(table) = std::fs::read_to_string(folder.join("EXPECT.tsv")) else {
        eprintln!("skipped: the hostile files are not present");
        return Vec::new();
    };
    let case = |line: &str| {
        let mut columns = line.split('\t').map(str::to_owned);
        let (name, expect) = (columns.next()?, columns.next()?);
        let path = folder.join(&name);
        path.exists().then_some(Case { path, name, expect })
    };
    table.lines().skip(1).filter_map(case).collect()
}

/// How a command ended: its exit code, none where it was killed, and what it said.
struct Ended {
    code: Option<i32>,
    said: String,
}

/// Waits, and kills what takes too long.
fn wait(child: &mut Child) -> ExitStatus {
    let end = Instant::now() + Duration::from_secs(u64::from(SECONDS));
    loop {
        if let Some(status) = child.try_wait().expect("a status") {
            return status;
        }
        if Instant::now() > end {
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(3));
    }
}

fn run(folder: &Path, args: &[&str]) -> Ended {
    let log = folder.with_extension("log");
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY} && ulimit -t {SECONDS} && exec \"$@\""), "sh"])
        .arg(env!("CARGO_BIN_EXE_wirework"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&log).expect("a log"))
        .spawn()
        .expect("a shell");
    let status = wait(&mut child);
    Ended { code: status.code(), said: std::fs::read_to_string(&log).expect("UTF-8") }
}

/// What is wrong with how a command ended, if anything is.
fn judge(case: &Case, ended: &Ended, new: &[String]) -> Option<String> {
    let Some(code) = ended.code else { return Some("it was killed".to_owned()) };
    let refused = code == 3 || code == 5;
    let right = match case.expect.as_str() {
        "reject" => refused,
        "accept" => code == 0,
        _ => refused || code == 0,
    };
    if !right {
        return Some(format!("exit code {code}"));
    }
    if ended.said.contains("bug") || ended.said.chars().any(|c| c.is_control() && c != '\n') {
        return Some("a bad message".to_owned());
    }
    if code == 0 {
        return None;
    }
    if !new.is_empty() {
        return Some(format!("it left {new:?}"));
    }
    let named = ended.said.lines().any(|line| {
        line.split_once(&case.name).is_some_and(|(_, rest)| {
            is_place(rest) && ["expected ", "needs "].iter().any(|word| rest.contains(word))
        })
    });
    (!named).then(|| "its message names no file or no place".to_owned())
}

/// Whether what follows a file's name is a place and what was found there: a line, a JSON pointer, a byte; of what is
/// wrong with the whole file nothing but the finding, or what does not fit it.
fn is_place(rest: &str) -> bool {
    let line = rest.strip_prefix(':').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    line || [": /", ": byte ", ": found ", ": the effect cannot be applied: "]
        .iter()
        .any(|start| rest.starts_with(start))
}

/// Runs all cases on all processors, each in an empty folder beside the preset `any.ron`.
fn all(args: impl Fn(&str) -> Vec<String> + Sync) {
    let cases = cases();
    let (next, wrong) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        let place = TempDir::new().expect("a folder");
        std::fs::write(place.path().join("any.ron"), ANY).expect("a preset");
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let folder = place.path().join("out");
            std::fs::create_dir(&folder).expect("a folder");
            let args = args(case.path.to_str().expect("UTF-8"));
            let ended = run(&folder, &args.iter().map(String::as_str).collect::<Vec<_>>());
            let entries = std::fs::read_dir(&folder).expect("a folder");
            let new: Vec<String> = entries
                .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
                .collect();
            if let Some(fault) = judge(case, &ended, &new) {
                let said: String = ended.said.chars().take(300).collect();
                wrong.lock().unwrap().push(format!("{} ({}): {fault}: {said}", case.name, case.expect));
            }
            std::fs::remove_dir_all(&folder).expect("what it left");
        }
    };
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
}

fn words(line: &str) -> Vec<String> {
    line.split(' ').map(str::to_owned).collect()
}

#[test]
fn an_effect_is_applied_or_the_file_is_refused() {
    all(|file| words(&format!("apply ../any.ron {file} -o out.glb --fps 10 --threads 1 --progress none")));
}

#[test]
fn inspect_refuses_what_apply_refuses() {
    all(|file| words(&format!("inspect {file} --json")));
}

#[test]
fn a_picture_is_made_or_the_file_is_refused() {
    all(|file| words(&format!("render {file} -o out.png --fast --size 32x32 --threads 1 --progress none")));
}
