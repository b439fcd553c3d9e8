//! Records of experiments: results and mutants as files, and how numbers are formatted and
//! compared. Experiments write them; the book and the README show them.

pub mod mutants;
pub mod noise;
pub mod number;
pub mod readme;
pub mod results;

use std::fmt;
use std::path::PathBuf;

/// An error in a file that people write or record.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Problem {
    /// File with the error.
    pub file: PathBuf,
    /// Its line, from 1.
    pub line: usize,
    /// The error and, where it can be guessed, the likely intention.
    pub message: String,
}

impl Problem {
    /// Returns an error at a line of a file.
    pub fn new(file: impl Into<PathBuf>, line: usize, message: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            line,
            message: message.into(),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{}:{}: {}",
            self.file.display(),
            self.line,
            self.message
        )
    }
}
