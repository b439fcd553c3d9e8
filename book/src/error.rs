//! What can go wrong while weaving: always a file, a line where there is one, and one sentence.

use std::fmt;
use std::path::PathBuf;

/// One fault of the book's sources.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Problem {
    /// The file to mend.
    pub file: PathBuf,
    /// Its line, from 1.
    pub line: usize,
    /// What is wrong and, where it can be guessed, what was meant.
    pub message: String,
}

impl Problem {
    /// A fault at a line of a file.
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

/// Why no book was woven.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The sources have faults; every one that was found, by file and line.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Problems(Vec<Problem>),
    /// A file could not be read or written.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The output folder holds something that is not a book.
    #[error(
        "{}: is not empty and holds no woven book; choose another folder with --out", .0.display()
    )]
    Occupied(PathBuf),
    /// The folder of a run holds none.
    #[error("{}: holds no results of a run; cargo run --release writes them to out", .0.display())]
    NoRun(PathBuf),
    /// mdBook refused.
    #[error("mdBook: {0}")]
    Mdbook(String),
}

impl Error {
    /// For `map_err` after an operation on `path`.
    pub fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        |source| Self::Io { path, source }
    }
}
