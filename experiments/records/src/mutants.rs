//! The record of mutation testing: the results of cargo-mutants in each source file, and why
//! survivors live.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// Name of the file in the folder of recorded results.
pub const FILE: &str = "mutants.json";

/// Results for the mutants of every source file that was tried.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// Name and version of the program.
    pub tool: String,
    /// Counts by source file.
    pub files: BTreeMap<String, Counts>,
    /// Mutants that no test kills, in the order of the files.
    pub survivors: Vec<Survivor>,
}

/// Counts of a file's mutants by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// A test failed.
    pub caught: usize,
    /// The tests did not end in time, which counts as caught.
    pub timeout: usize,
    /// The tests passed.
    pub missed: usize,
    /// The mutant did not compile, and does not count.
    pub unviable: usize,
    /// Number of mutants of the file, where only a sample was tried; written by hand, like the
    /// reasons.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_of: Option<usize>,
}

/// A mutant that no test kills.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Survivor {
    /// Name of the mutant: `path:line:column: what is replaced by what`.
    pub mutant: String,
    /// Reason why it may live; formulas as on the pages.
    pub reason: String,
}

impl Counts {
    /// Returns the number of mutants that compile.
    pub fn viable(&self) -> usize {
        self.caught + self.timeout + self.missed
    }

    /// Returns the number of mutants that some test kills.
    pub fn killed(&self) -> usize {
        self.caught + self.timeout
    }

    fn add(self, other: Self) -> Self {
        Self {
            caught: self.caught + other.caught,
            timeout: self.timeout + other.timeout,
            missed: self.missed + other.missed,
            unviable: self.unviable + other.unviable,
            sample_of: None,
        }
    }
}

/// Returns a mutant's name without line and column, which change with any edit above.
fn description(mutant: &str) -> String {
    let mut parts = mutant.splitn(4, ':');
    match [parts.next(), parts.next(), parts.next(), parts.next()] {
        [Some(path), Some(_), Some(_), Some(what)] => format!("{path}:{what}"),
        _ => mutant.to_owned(),
    }
}

impl Record {
    /// Reads the record in a folder of recorded results.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(FILE);
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("{} cannot be read: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Returns the sum of the counts of all files.
    pub fn total(&self) -> Counts {
        self.files
            .values()
            .copied()
            .fold(Counts::default(), Counts::add)
    }

    /// Replaces the counts and survivors of a file; survivors keep the reasons of mutants with the
    /// same text.
    pub fn replace(&mut self, file: &str, counts: Counts, missed: &[String]) {
        let of_file = |survivor: &Survivor| survivor.mutant.starts_with(&format!("{file}:"));
        let known: Vec<Survivor> = self
            .survivors
            .iter()
            .filter(|s| of_file(s))
            .cloned()
            .collect();
        self.survivors.retain(|survivor| !of_file(survivor));
        self.survivors.extend(missed.iter().map(|mutant| {
            let same = known.iter().find(|s| s.mutant == *mutant);
            let alike = || {
                known
                    .iter()
                    .find(|s| description(&s.mutant) == description(mutant))
            };
            Survivor {
                mutant: mutant.clone(),
                reason: same
                    .or_else(alike)
                    .map_or_else(String::new, |s| s.reason.clone()),
            }
        }));
        // By file; within one the order is the tool's, that of the lines.
        self.survivors
            .sort_by_key(|s| s.mutant.split(':').next().map(str::to_owned));
        self.files.insert(file.to_owned(), counts);
    }
}
