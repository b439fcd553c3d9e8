//! Errors of weaving: each has a file, a line where there is one, and one sentence.

use std::fmt;
use std::path::PathBuf;

/// One error in the book's sources.
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

/// Reason why no book was woven.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The sources have errors: all that were found, by file and line.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Problems(Vec<Problem>),
    /// A file could not be read or written.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The output folder holds something that is not a book.
    #[error(
        "{}: is not empty and holds no woven book; choose another folder with --out", .0.display()
    )]
    Occupied(PathBuf),
    /// The folder of a run has no results.
    #[error("{}: holds no results of a run; cargo run --release writes them to out", .0.display())]
    NoRun(PathBuf),
    /// An error of mdBook.
    #[error("mdBook: {0}")]
    Mdbook(String),
}

impl Error {
    /// Returns a function for `map_err` after an operation on `path`.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        |source| Self::Io { path, source }
    }
}
