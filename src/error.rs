//! What can go wrong with a user's input, each as one line that says what, where and how to mend
//! it.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A fault of the input or of the file system; programs print it as one line and exit with code 2.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}{}", path.display(), remedy(action, source))]
    File {
        /// "read", "write" or "create".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// An EXR or PNG file could not be decoded or encoded.
    #[error("cannot {action} {}: {message}", path.display())]
    Image {
        /// "read" or "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the codec said.
        message: String,
    },
    /// A signal to end came, such as that of Ctrl-C.
    #[error("interrupted; the same command goes on where it stopped")]
    Interrupted,
    /// An option's value makes no sense, alone or together with others.
    #[error("{0}")]
    Option(String),
    /// An estimator returned a value that no film can hold.
    #[error("an estimator returned the radiance {value:?}{place}; {}", radiance_remedy(*value))]
    Radiance {
        /// The value.
        value: f64,
        /// Which pixel and replication, as the end of a clause; empty if unknown.
        place: String,
    },
    /// A scene that cannot be rendered: not finite, degenerate, or referring to what is not there.
    #[error("scene {scene}: {message}")]
    Scene {
        /// The scene's name.
        scene: String,
        /// What is wrong and how to mend it.
        message: String,
    },
}

/// The largest radiance that an image holds, and the largest absolute value of
/// [`ExactMoments`](crate::math::moments::ExactMoments): 2²⁴.
pub const LARGEST_RADIANCE: f64 = 16_777_216.0;

/// The limit of radiances, and how a scene or an estimator can be mended.
fn radiance_remedy(value: f64) -> String {
    let remedy = if value.is_finite() && value > 0.0 {
        "the scene is too bright: multiply every emission and the background (materials.NAME.emission and background of a \
         scene file) by one factor below 1, and the image is multiplied by it; or an estimator divides by a pdf near zero"
    } else {
        "look for a zero or infinite pdf, or a path that does not end"
    };
    format!(
        "an image holds finite values from 0 to {}: {remedy}",
        LARGEST_RADIANCE
    )
}

/// What mends an error of the file system, where that can be said.
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
    /// The same error with the place of a radiance, if it is not known yet.
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

    /// For `map_err` on an operation on `path`.
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
