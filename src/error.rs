//! Errors of a user's input, each as one line that says what is wrong, where, and how to mend it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// An error of the input or of the file system; programs print it as one line and exit with code 2.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}{}", path.display(), remedy(action, source))]
    File {
        /// "read", "write" or "create".
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// An EXR or PNG file could not be decoded or encoded.
    #[error("cannot {action} {}: {message}", path.display())]
    Image {
        /// "read" or "write".
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Message of the codec.
        message: String,
    },
    /// A signal to end came, such as that of Ctrl-C.
    #[error("interrupted; the same command resumes where it stopped")]
    Interrupted,
    /// An option's value is invalid, alone or together with others.
    #[error("{0}")]
    Option(String),
    /// An estimator returned a value that no film can hold.
    #[error("an estimator returned the radiance {value:?}{place}; {}", radiance_remedy(*value))]
    Radiance {
        /// Radiance returned.
        value: f64,
        /// Pixel and replication, as the end of a clause; empty if unknown.
        place: String,
    },
    /// A scene that cannot be rendered: not finite, degenerate, or with an invalid reference.
    #[error("scene {scene}: {message}")]
    Scene {
        /// Name of the scene.
        scene: String,
        /// Description of the error and how to mend it.
        message: String,
    },
}

/// Largest radiance of an image, and largest absolute value of
/// [`ExactMoments`](crate::math::moments::ExactMoments): 2²⁴.
pub const MAX_RADIANCE: f64 = 16_777_216.0;

/// Returns the limit of radiances, and how a scene or an estimator can be mended.
fn radiance_remedy(value: f64) -> String {
    let remedy = if value.is_finite() && value > 0.0 {
        "the scene is too bright: multiply every emission and the background (materials.NAME.emission and background of a \
         scene file) by one factor below 1, and the image is multiplied by it; or an estimator divides by a pdf near zero"
    } else {
        "look for a zero or infinite pdf, or a path that does not end"
    };
    format!("an image holds finite values from 0 to {MAX_RADIANCE}: {remedy}")
}

/// Returns advice on an error of the file system, or an empty text.
fn remedy(action: &str, source: &std::io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory if action == "read" => " (check its name)",
        ErrorKind::PermissionDenied if action == "read" => " (check that it may be read)",
        ErrorKind::NotFound
        | ErrorKind::NotADirectory
        | ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem => " (check that the folder exists and may be written)",
        ErrorKind::IsADirectory => " (choose another name, or remove the folder)",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => " (make room, or choose another disk)",
        _ => "",
    }
}

impl Error {
    /// Adds the place of a radiance, if it is not known yet.
    #[must_use]
    pub fn at(self, place: impl FnOnce() -> String) -> Self {
        match self {
            Self::Radiance { value, place: old } if old.is_empty() => Self::Radiance {
                value,
                place: place(),
            },
            other => other,
        }
    }

    /// Returns a function for `map_err` on an operation on `path`.
    pub fn file<'a>(
        action: &'static str,
        path: &'a Path,
    ) -> impl FnOnce(std::io::Error) -> Self + 'a {
        move |source| Self::File {
            action,
            path: path.to_owned(),
            source,
        }
    }
}
