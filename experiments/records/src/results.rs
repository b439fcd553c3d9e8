//! Results of experiments: one folder per experiment with `result.json` and figures beside it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::suggest::did_you_mean;

use crate::Problem;

/// Id under which the record keeps the time of a default run, which is no experiment.
pub const DEFAULT_RUN: &str = "default-run";

/// Result of an experiment, stored as `result.json`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ExperimentResult {
    /// Name of the experiment and of its folder.
    pub id: String,
    /// Title of the experiment.
    pub title: String,
    /// Version that the experiment declared.
    pub version: u32,
    /// `quick` or `full`.
    pub tier: String,
    /// The master seed.
    pub seed: u64,
    /// Divisor of counts and pixels.
    pub shrink: u32,
    /// Command that repeats the run.
    pub command: String,
    /// Ids of the equations that it bears on.
    pub equations: Vec<String>,
    /// All recorded numbers, by name.
    pub numbers: BTreeMap<String, f64>,
    /// Figures and other files to look at, beside this one.
    pub figures: Vec<String>,
    /// Lines of the table.
    pub findings: Vec<Finding>,
    /// SHA-256 of each file that was in the folder at the end, so that results are kept only if
    /// their files are unchanged.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub digests: BTreeMap<String, String>,
    /// Hash of program and options, so that only results of the same program are kept.
    pub fingerprint: String,
}

/// One line of an experiment's table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Finding {
    /// Name of the measured quantity or claim.
    pub what: String,
    /// The number with its unit and error.
    pub value: String,
    /// Judgement of a claim about it; `None` where nothing is claimed.
    pub verdict: Option<Judgement>,
    /// True if it belongs to the last line above that is no detail; tables show details on request
    /// only.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub detail: bool,
}

/// Judgement of a claim by a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Judgement {
    /// The claim holds.
    Holds,
    /// The claim fails.
    Fails,
    /// The run is too small to tell.
    Undecided,
}

impl Judgement {
    /// Returns "holds", "fails" or "undecided".
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Undecided => "undecided",
        }
    }
}

impl From<bool> for Judgement {
    fn from(holds: bool) -> Self {
        if holds { Self::Holds } else { Self::Fails }
    }
}

impl From<Verdict> for Judgement {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Holds => Self::Holds,
            Verdict::Fails => Self::Fails,
            Verdict::Undecided { .. } => Self::Undecided,
        }
    }
}

/// All recorded results.
#[derive(Debug, Default)]
pub struct Results {
    folder: PathBuf,
    by_id: BTreeMap<String, ExperimentResult>,
}

impl Results {
    /// Reads every `*/result.json` of `folder`; a missing folder has no results.
    ///
    /// # Errors
    /// All files that cannot be read, in order.
    pub fn load(folder: &Path) -> Result<Self, Vec<Problem>> {
        let mut results = Self {
            folder: folder.to_owned(),
            by_id: BTreeMap::new(),
        };
        if !folder.exists() {
            return Ok(results);
        }
        let unreadable = |error: std::io::Error| {
            vec![Problem::new(folder, 1, format!("cannot be read: {error}"))]
        };
        let mut problems = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let file = entry.path().join("result.json");
            if !file.is_file() {
                continue;
            }
            let name = entry.file_name().to_string_lossy().into_owned();
            match read(&file, &name) {
                Ok(recorded) => {
                    results.by_id.insert(name, recorded);
                }
                Err(problem) => problems.push(problem),
            }
        }
        if problems.is_empty() {
            return Ok(results);
        }
        problems.sort();
        Err(problems)
    }

    /// Returns the folder that they were read from.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns every experiment, by name.
    pub fn all(&self) -> impl Iterator<Item = &ExperimentResult> {
        self.by_id.values()
    }

    /// Returns the experiment with this name.
    pub fn experiment(&self, id: &str) -> Result<&ExperimentResult, String> {
        let found = self.by_id.get(id);
        found.ok_or_else(|| {
            format!(
                "no recorded result of an experiment \"{id}\"{}",
                did_you_mean(id, self.by_id.keys())
            )
        })
    }

    /// Returns the number `EXPERIMENT.KEY`; the key may itself have dots.
    pub fn number(&self, name: &str) -> Result<f64, String> {
        let (id, key) = name
            .split_once('.')
            .ok_or_else(|| format!("\"{name}\" is not of the form EXPERIMENT.KEY"))?;
        let recorded = self.experiment(id)?;
        let numbers = &recorded.numbers;
        let unknown = || {
            format!(
                "experiment \"{id}\" recorded no number \"{key}\"{}",
                did_you_mean(key, numbers.keys())
            )
        };
        numbers.get(key).copied().ok_or_else(unknown)
    }

    /// Returns the experiment and the files of the figure `EXPERIMENT/NAME`: one, or the bands of a
    /// large picture from the top.
    pub fn figure(&self, name: &str) -> Result<(&ExperimentResult, Vec<PathBuf>), String> {
        let (id, file) = name
            .split_once('/')
            .ok_or_else(|| format!("\"{name}\" is not of the form EXPERIMENT/NAME.svg"))?;
        let recorded = self.experiment(id)?;
        if !recorded.figures.iter().any(|figure| figure == file) {
            return Err(format!(
                "experiment \"{id}\" recorded no figure \"{file}\"{}",
                did_you_mean(file, &recorded.figures)
            ));
        }
        let path = self.folder.join(id).join(file);
        if path.is_file() {
            return Ok((recorded, vec![path]));
        }
        let bands: Vec<PathBuf> = (1..)
            .map(|k| path.with_extension(format!("band-{k}.png")))
            .take_while(|band| band.is_file())
            .collect();
        if bands.is_empty() {
            let (path, command) = (path.display(), &recorded.command);
            return Err(format!(
                "figure \"{name}\" is recorded, but {path} is missing; run {command}"
            ));
        }
        Ok((recorded, bands))
    }
}

/// Reads one `result.json`.
fn read(file: &Path, folder: &str) -> Result<ExperimentResult, Problem> {
    let text = std::fs::read_to_string(file)
        .map_err(|error| Problem::new(file, 1, format!("cannot be read: {error}")))?;
    let recorded: ExperimentResult = serde_json::from_str(&text)
        .map_err(|error| Problem::new(file, error.line().max(1), error.to_string()))?;
    if recorded.id != folder {
        return Err(Problem::new(
            file,
            1,
            format!("the id is \"{}\", but the folder \"{folder}\"", recorded.id),
        ));
    }
    let plain = |name: &String| !name.contains(['/', '\\']) && !name.starts_with('.');
    if let Some(name) = recorded.figures.iter().find(|name| !plain(name)) {
        return Err(Problem::new(
            file,
            1,
            format!("\"{name}\" is not the name of a file beside this one"),
        ));
    }
    Ok(recorded)
}
