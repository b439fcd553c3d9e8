//! Saved parts of an interrupted run, from which the next one with the same options continues.
//!
//! A run is a function of its options and of the files that existed when it began. So it is
//! continued by repeating it: from those files as they were, with the finished parts read back. The
//! results are those of a run without interruption, wherever it was interrupted.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use whitefurnace::error::Error;

use crate::run::progress::interrupted;
use crate::run::{read_json, recreate_folder, write_text};

/// A folder beside an experiment's files, from the beginning of a run to its end.
pub struct PartCache {
    folder: PathBuf,
}

impl PartCache {
    /// Begins in this folder, or continues what was begun there under the same fingerprint.
    pub fn begin(folder: PathBuf, fingerprint: &str) -> Result<Self, Error> {
        let run = folder.join("run");
        if std::fs::read_to_string(&run).is_ok_and(|begun| begun == fingerprint) {
            return Ok(Self { folder });
        }
        recreate_folder(&folder)?;
        write_text(&run, fingerprint)?;
        Ok(Self { folder })
    }

    /// Returns a part of the run: read from the folder if it was done, else made and saved there.
    /// `key` is part of the file's name.
    pub fn part<T: Serialize + DeserializeOwned>(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        let path = self.folder.join(format!("{key}.json"));
        if let Ok(part) = read_json(&path) {
            return Ok(part);
        }
        if interrupted() {
            return Err(Error::Interrupted);
        }
        let text = serde_json::to_string(&make()?);
        write_text(
            &path,
            &text.map_err(|error| Error::Option(format!("{}: {error}", path.display())))?,
        )?;
        // Read back, so that a new part takes the same path as a saved one.
        read_json(&path)
    }

    /// Returns a copy of a file of the experiment as it was when the run began; an empty one if
    /// there was none.
    pub fn before(&self, file: &Path) -> Result<PathBuf, Error> {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let copy = self.folder.join(format!("{name}.before"));
        if !copy.exists() {
            let text = match std::fs::read_to_string(file) {
                Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
                text => text.map_err(Error::file("read", file))?,
            };
            write_text(&copy, &text)?;
        }
        Ok(copy)
    }

    /// Ends the run, after its results have been written.
    pub fn end(self) -> Result<(), Error> {
        std::fs::remove_dir_all(&self.folder).map_err(Error::file("remove", &self.folder))
    }
}
