//! Errors of weaving: each has a file, a line where there is one, and one sentence.

use std::path::PathBuf;

use records::Problem;

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
