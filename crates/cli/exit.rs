//! Failures and their exit codes.

use wirework::{Fault, JobError};

/// Why a command ends early.
#[derive(Debug)]
pub(crate) struct Failure {
    /// The exit code.
    pub(crate) code: u8,
    /// What is said; nothing where it has been said already.
    pub(crate) message: Option<String>,
}

/// The exit code of a fault.
pub(crate) fn code(fault: Fault) -> u8 {
    match fault {
        Fault::Request => 2,
        Fault::Asset => 3,
        Fault::Preset => 4,
        Fault::Limit => 5,
        // The work, and whatever is added.
        _ => 1,
    }
}

impl Failure {
    pub(crate) fn new(fault: Fault, message: String) -> Self {
        Self { code: code(fault), message: Some(message) }
    }

    /// The work could not be finished.
    pub(crate) fn work(message: String) -> Self {
        Self::new(Fault::Work, message)
    }

    /// A failure that has been explained already.
    pub(crate) fn said(fault: Fault) -> Self {
        Self { code: code(fault), message: None }
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        Self::new(error.fault(), error.to_string())
    }
}
