//! From an equation to its code, trials, tests, experiments and chapter, read from the sources: the
//! matrix in the book and the holes that a test reports.
//!
//! The sources cite equations by the names of their constants, pages by id.

use std::collections::BTreeMap;
use std::path::Path;

use whitefurnace::equation::{ALL, Equation};
use whitefurnace::harness::trial::Trial;

/// A source file: its path from the project's folder, and its text.
type File = (String, String);

/// All that is read.
pub struct Sources {
    /// The library without the registry of equations, the trials and the harness.
    code: Vec<File>,
    tests: Vec<File>,
    experiments: Vec<File>,
    /// The pages of the book.
    pages: Vec<File>,
    /// The constants of the registry, by id.
    names: BTreeMap<String, String>,
    recorded: Vec<File>,
}

/// An experiment as its source declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Experiment {
    /// Its id.
    pub id: String,
    /// Ids of the equations that it lists.
    pub equations: Vec<String>,
    /// Whether it loops over the registry of trials, and so bears on whatever they bear on.
    pub loops: bool,
    /// The file that declares it.
    file: String,
}

/// Where an equation is found.
pub struct Trace {
    /// The equation.
    pub equation: &'static Equation,
    /// `path: item` of the library.
    pub code: Vec<String>,
    /// Names of trials.
    pub trials: Vec<String>,
    /// Files of exact tests.
    pub tests: Vec<String>,
    /// Ids of experiments.
    pub experiments: Vec<String>,
    /// The page that shows it.
    pub chapter: Option<String>,
}

impl Sources {
    /// Reads the project in `root`.
    ///
    /// # Errors
    /// A file or folder cannot be read.
    pub fn read(root: &Path) -> std::io::Result<Self> {
        let registry = std::fs::read_to_string(root.join("src/equation.rs"))?;
        let mut code = files(root, "src", "rs")?;
        let apart = ["src/equation.rs", "src/harness/"];
        code.retain(|(path, _)| !apart.iter().any(|prefix| path.starts_with(prefix)));
        let tests = files(root, "tests/library", "rs")?;
        Ok(Self {
            code,
            tests,
            experiments: files(root, "experiments/src", "rs")?,
            pages: files(root, "book/pages", "md")?,
            names: names(&registry),
            recorded: files(root, "book/recorded", "json")?,
        })
    }

    /// The experiments that the sources declare.
    pub fn experiments(&self) -> Vec<Experiment> {
        let declared = self.experiments.iter().flat_map(|(file, text)| {
            text.split(": Experiment = Experiment {").skip(1).filter_map(|rest| {
                let id = between(rest, "id: \"", "\"")?.to_owned();
                let list = between(rest, "equations: &[", "],")?;
                let cited = self.names.iter().filter(|(_, name)| has_word(list, name));
                Some(Experiment {
                    id,
                    equations: cited.map(|(id, _)| id.clone()).collect(),
                    loops: text.contains("run.bears_on("),
                    file: file.clone(),
                })
            })
        });
        declared.collect()
    }

    /// A row for each equation, in the order of the report.
    pub fn matrix(&self, trials: &[Trial]) -> Vec<Trace> {
        let experiments = self.experiments();
        ALL.iter()
            .map(|equation| {
                let own = trials.iter().filter(|t| t.equation.id == equation.id);
                let trials: Vec<String> = own.map(|trial| trial.name.clone()).collect();
                let bears = |e: &&Experiment| {
                    e.equations.iter().any(|id| id == equation.id)
                        || (e.loops && !trials.is_empty())
                };
                Trace {
                    equation,
                    code: self.code_of(equation),
                    tests: self.tests_of(equation),
                    experiments: experiments.iter().filter(bears).map(|e| e.id.clone()).collect(),
                    chapter: self.chapter_of(equation),
                    trials,
                }
            })
            .collect()
    }

    /// What is missing, a line each.
    pub fn holes(&self, trials: &[Trial]) -> Vec<String> {
        let mut holes = Vec::new();
        for row in self.matrix(trials) {
            let id = row.equation.id;
            let mut hole = |empty: bool, what: &str| {
                if empty {
                    holes.push(format!("equation {id}: {what}"));
                }
            };
            hole(row.code.is_empty(), "no code cites it");
            let judged = !row.trials.is_empty() || !row.tests.is_empty();
            hole(!judged, "no trial, and no exact test cites it");
            hole(row.experiments.is_empty(), "no experiment bears on it");
            hole(row.chapter.is_none(), "no chapter shows it");
        }
        for trial in trials.iter().filter(|trial| trial.controls.is_empty()) {
            holes.push(format!("trial {}: no negative control", trial.name));
        }
        let experiments = self.experiments();
        for experiment in &experiments {
            let binary = format!("experiments/src/bin/{}.rs", experiment.id);
            if !self.experiments.iter().any(|(path, _)| *path == binary) {
                holes.push(format!("experiment {}: no binary {binary}", experiment.id));
            }
        }
        holes.extend(self.lost_figures(&experiments));
        holes
    }

    /// Figures on pages that no experiment makes.
    fn lost_figures(&self, experiments: &[Experiment]) -> Vec<String> {
        let mut lost = Vec::new();
        for (page, text) in &self.pages {
            for rest in text.split("{{#figure ").skip(1) {
                let name = rest.split([' ', '}']).next().unwrap_or_default();
                if !self.makes(experiments, name) {
                    lost.push(format!("{page}: no experiment makes the figure {name}"));
                }
            }
        }
        lost
    }

    /// Whether the experiment's source names the figure, or its recorded result lists it.
    fn makes(&self, experiments: &[Experiment], name: &str) -> bool {
        let Some((id, file)) = name.split_once('/') else {
            return false;
        };
        let Some(experiment) = experiments.iter().find(|e| e.id == id) else {
            return false;
        };
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        let literals = [format!("\"{file}\""), format!("\"{stem}\"")];
        let says = |text: &String| literals.iter().any(|literal| text.contains(literal));
        let recorded = format!("book/recorded/{id}/result.json");
        let source = |(path, _): &&File| *path == experiment.file || *path == recorded;
        let mut sources = self.experiments.iter().chain(&self.recorded);
        sources.any(|found| source(&found) && says(&found.1))
    }

    fn name(&self, equation: &Equation) -> &str {
        self.names.get(equation.id).map_or("", String::as_str)
    }

    /// The items whose documentation cites the equation.
    fn code_of(&self, equation: &Equation) -> Vec<String> {
        let citation = format!("equation::{}", self.name(equation));
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
                    let declared = lines[at..].iter().find_map(|line| declared(line));
                    format!("{path}: {}", declared.unwrap_or("?"))
                };
                if !found.contains(&item) {
                    found.push(item);
                }
            }
        }
        found
    }

    fn tests_of(&self, equation: &Equation) -> Vec<String> {
        let name = self.name(equation);
        let cites = |text: &str| text.contains("equation::") && has_word(text, name);
        let tests = self.tests.iter().filter(|(_, text)| cites(text));
        tests.map(|(path, _)| path.clone()).collect()
    }

    fn chapter_of(&self, equation: &Equation) -> Option<String> {
        let directive = format!("{{{{#eq {}}}}}", equation.id);
        let mut pages = self.pages.iter();
        let page = pages.find(|(_, text)| text.contains(&directive))?;
        page.0.strip_prefix("book/pages/").map(str::to_owned)
    }
}

/// The files of a folder with this extension, in order; a missing folder holds none.
fn files(root: &Path, folder: &str, extension: &str) -> std::io::Result<Vec<File>> {
    let mut found = Vec::new();
    let path = root.join(folder);
    if !path.is_dir() {
        return Ok(found);
    }
    for entry in std::fs::read_dir(path)? {
        let entry = entry?;
        let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            found.extend(files(root, &name, extension)?);
        } else if entry.path().extension().is_some_and(|e| e == extension) {
            found.push((name, std::fs::read_to_string(entry.path())?));
        }
    }
    found.sort();
    Ok(found)
}

/// Lines such as `FRESNEL_S = "fresnel.s", ...` of the registry.
fn names(registry: &str) -> BTreeMap<String, String> {
    let entries = registry.lines().filter_map(|line| {
        let (name, rest) = line.trim().split_once(" = \"")?;
        let (id, _) = rest.split_once('"')?;
        let constant = name.chars().all(|c| c.is_ascii_uppercase() || c == '_');
        constant.then(|| (id.to_owned(), name.to_owned()))
    });
    entries.collect()
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(start)?;
    rest.split_once(end).map(|(found, _)| found)
}

/// Whether `word` stands in `text` and is not part of a longer name.
fn has_word(text: &str, word: &str) -> bool {
    let part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    !word.is_empty()
        && text.match_indices(word).any(|(at, _)| {
            !part(text[..at].chars().next_back()) && !part(text[at + word.len()..].chars().next())
        })
}

/// The name that a line declares.
fn declared(line: &str) -> Option<&str> {
    let mut words =
        line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
    if line.trim_start().starts_with("//") {
        return None;
    }
    words.find(|word| ["fn", "struct", "enum", "trait", "const", "type"].contains(word))?;
    words.next()
}
