//! Traces an equation to its code, trials, tests, experiments and chapter, for the matrix in the
//! book and the missing links that a test reports: code, tests and pages from the current files,
//! experiments from their recorded results.
//!
//! The sources cite equations by the names of their constants, pages by id.

use std::path::Path;

use records::results::Results;
use whitefurnace::equation::{ALL, Equation};
use whitefurnace::harness::trial::Trial;

use crate::check;
use crate::error::Error;
use crate::listing::declared;

/// A source file: its path from the project's folder, and its text.
type File = (String, String);

/// Source files of the project.
pub struct Sources {
    /// The library without the registry of equations, the trials and the harness.
    code: Vec<File>,
    tests: Vec<File>,
    pages: Vec<File>,
}

/// Places of an equation.
pub(crate) struct Trace {
    pub equation: &'static Equation,
    /// `path: item` of the library.
    pub code: Vec<String>,
    pub trials: Vec<String>,
    /// Files of exact tests.
    pub tests: Vec<String>,
    /// Ids of experiments.
    pub experiments: Vec<String>,
    /// True if a page shows it.
    pub is_shown: bool,
}

impl Sources {
    /// Reads the project in `root`.
    pub fn read(root: &Path) -> Result<Self, Error> {
        let mut code = files(root, "src", "rs")?;
        code.retain(|(path, _)| {
            !["src/equation.rs", "src/harness/"]
                .iter()
                .any(|prefix| path.starts_with(prefix))
        });
        Ok(Self {
            code,
            tests: files(root, "tests/library", "rs")?,
            pages: files(root, "book/pages", "md")?,
        })
    }

    /// Returns a row for each equation, in the order of the report.
    pub(crate) fn matrix(&self, trials: &[Trial], results: &Results) -> Vec<Trace> {
        ALL.iter()
            .map(|equation| {
                let own = trials.iter().filter(|t| t.source == equation.id);
                let shown = format!("{{{{#eq {}}}}}", equation.id);
                let bears = results
                    .all()
                    .filter(|e| e.equations.iter().any(|id| id == equation.id));
                Trace {
                    equation,
                    code: self.code_of(equation),
                    trials: own.map(|trial| trial.name.clone()).collect(),
                    tests: self.tests_of(equation),
                    experiments: bears.map(|experiment| experiment.id.clone()).collect(),
                    is_shown: self.pages.iter().any(|(_, text)| text.contains(&shown)),
                }
            })
            .collect()
    }

    /// Returns the missing links, a line each.
    pub fn missing_links(&self, trials: &[Trial], results: &Results) -> Vec<String> {
        let mut missing_links = Vec::new();
        for row in self.matrix(trials, results) {
            let judged = !row.trials.is_empty() || !row.tests.is_empty();
            for (there, what) in [
                (!row.code.is_empty(), "no code cites it"),
                (judged, "no trial, and no exact test cites it"),
                (
                    !row.experiments.is_empty(),
                    "no recorded experiment bears on it",
                ),
                (row.is_shown, "no chapter shows it"),
            ] {
                if !there {
                    missing_links.push(format!("equation {}: {what}", row.equation.id));
                }
            }
        }
        for trial in trials.iter().filter(|trial| trial.controls.is_empty()) {
            missing_links.push(format!("trial {}: no negative control", trial.name));
        }
        missing_links
    }

    /// Returns the items whose documentation cites the equation.
    fn code_of(&self, equation: &Equation) -> Vec<String> {
        let citation = format!("equation::{}", equation.name);
        let mut found = Vec::new();
        for (path, text) in &self.code {
            let lines: Vec<&str> = text.lines().collect();
            for (at, line) in lines.iter().enumerate() {
                if !has_word(line, &citation) {
                    continue;
                }
                let item = if line.trim_start().starts_with("//!") {
                    path.clone()
                } else {
                    format!(
                        "{path}: {}",
                        lines[at..]
                            .iter()
                            .find_map(|line| declared(line))
                            .unwrap_or("?")
                    )
                };
                if !found.contains(&item) {
                    found.push(item);
                }
            }
        }
        found
    }

    fn tests_of(&self, equation: &Equation) -> Vec<String> {
        let cites = |text: &str| text.contains("equation::") && has_word(text, equation.name);
        self.tests
            .iter()
            .filter(|(_, text)| cites(text))
            .map(|(path, _)| path.clone())
            .collect()
    }
}

/// Returns the files of a folder with this extension, in order.
fn files(root: &Path, folder: &str, extension: &str) -> Result<Vec<File>, Error> {
    let mut found = Vec::new();
    for path in check::files(&root.join(folder))? {
        if path.extension().is_some_and(|e| e == extension) {
            let name = path
                .strip_prefix(root)
                .unwrap_or(&path)
                .to_string_lossy()
                .into_owned();
            found.push((
                name,
                std::fs::read_to_string(&path).map_err(Error::io(path))?,
            ));
        }
    }
    Ok(found)
}

/// Returns true if `word` occurs in `text` as a whole word.
fn has_word(text: &str, word: &str) -> bool {
    let part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(word).any(|(at, _)| {
        !part(text[..at].chars().next_back()) && !part(text[at + word.len()..].chars().next())
    })
}
