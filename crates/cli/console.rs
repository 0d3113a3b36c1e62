//! Standard output for what was asked for, standard error for people.

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;

use wirework::asset::{OutputFile, write_files};
use wirework::{JobError, Progress};

use crate::args::{ProgressKind, Talk};
use crate::exit::Failure;

/// What is said on standard error, and how.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    verbose: bool,
    quiet: bool,
    progress: ProgressShown,
    color: bool,
}

/// Resolved from the flags and the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ProgressShown {
    Counter,
    Plain,
    Json,
    Nothing,
}

impl Console {
    pub(crate) fn new(talk: Talk) -> Self {
        let terminal = io::stderr().is_terminal();
        let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        let progress = match talk.progress {
            Some(ProgressKind::Plain) => ProgressShown::Plain,
            Some(ProgressKind::Json) => ProgressShown::Json,
            None if terminal && !talk.quiet && !dumb => ProgressShown::Counter,
            Some(ProgressKind::None) | None => ProgressShown::Nothing,
        };
        let color = terminal && !dumb && !set("NO_COLOR");
        Self { verbose: talk.verbose, quiet: talk.quiet, progress, color }
    }

    /// Whether text may be coloured.
    pub(crate) fn color(self) -> bool {
        self.color
    }

    /// A failure.
    pub(crate) fn fail(self, line: &str) {
        let (on, off) = if self.color { ("\u{1b}[1;31m", "\u{1b}[0m") } else { ("", "") };
        say(&format!("{on}error{off}: {line}"));
    }

    /// The warnings that were taken as errors.
    pub(crate) fn fail_strict(self, error: &JobError) {
        if let JobError::Strict(warnings) = error {
            for warning in warnings {
                self.fail(warning);
            }
        }
    }

    /// A warning, unless all is to be quiet.
    pub(crate) fn warn(self, line: &str) {
        if !self.quiet {
            let (on, off) = if self.color { ("\u{1b}[1;33m", "\u{1b}[0m") } else { ("", "") };
            say(&format!("{on}warning{off}: {line}"));
        }
    }

    /// A note, unless all is to be quiet.
    pub(crate) fn note(self, line: &str) {
        if !self.quiet {
            say(line);
        }
    }

    /// A note for those who want to know more.
    pub(crate) fn detail(self, line: &str) {
        if self.verbose {
            say(line);
        }
    }

    /// Tells how far the work has come.
    pub(crate) fn progress(self, progress: Progress) {
        let Progress { done, frames } = progress;
        let mut out = io::stderr();
        // A counter that is written more often than it is seen costs more than the frame.
        let tenth = done * 10 / frames.max(1) != (done - done.min(1)) * 10 / frames.max(1);
        let written = match self.progress {
            ProgressShown::Counter if done == frames => write!(out, "\r\u{1b}[K"),
            ProgressShown::Counter => write!(out, "\rframe {done} of {frames}"),
            ProgressShown::Plain if tenth => writeln!(out, "frame {done} of {frames}"),
            ProgressShown::Json => writeln!(out, "{{\"done\":{done},\"frames\":{frames}}}"),
            ProgressShown::Plain | ProgressShown::Nothing => Ok(()),
        };
        drop(written.and_then(|()| out.flush()));
    }

    /// Ends a counter that was cut short, so that what follows has a line of its own.
    pub(crate) fn end_progress(self) {
        if self.progress == ProgressShown::Counter {
            drop(write!(io::stderr(), "\r\u{1b}[K"));
        }
    }
}

/// A line for people; nobody hears that standard error is closed.
pub(crate) fn say(line: &str) {
    drop(writeln!(io::stderr(), "{line}"));
}

/// Writes a report where it was asked for: `-` is standard output.
pub(crate) fn write_report(place: Option<&Path>, json: String) -> Result<(), Failure> {
    match place {
        None => Ok(()),
        Some(path) if path == Path::new("-") => print(json.as_bytes()),
        Some(path) => write_files(&[OutputFile::new(path, json.into_bytes())])
            .map_err(|error| Failure::from(JobError::from(error))),
    }
}

/// Writes what was asked for. A reader that has seen enough is no failure.
pub(crate) fn print(text: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}
