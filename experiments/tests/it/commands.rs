//! Tests of the commands that the book and the README give: programs, options, tests and
//! experiments exist, and those of answers to exercises run.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Command, CommandFactory};
use experiments::compare::Compare;
use experiments::experiments::EXPERIMENTS;
use experiments::experiments::answers::COMMANDS;
use experiments::export::Export;
use experiments::judge::Judge;
use experiments::metamorphic::Metamorphic;
use experiments::render::command::Render;
use trials::all;
use whitefurnace::harness::trial::Trial;

use crate::job;

/// A command of a page.
struct PageCommand {
    page: String,
    words: Vec<String>,
    /// Whether it stands in an answer to an exercise.
    is_answer: bool,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Splits a command line at blanks, except in quotes.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '\'' | '"' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            _ => words.last_mut().expect("one").push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Collects the commands of `cargo` on a page: lines of its blocks of code, and code in its text.
fn commands(file: &Path) -> Vec<PageCommand> {
    let text = fs::read_to_string(file).expect("a page");
    let page = file.file_name().expect("a name").to_string_lossy();
    let mut found = Vec::new();
    let (mut is_code, mut is_answer) = (false, false);
    for line in text.lines() {
        is_answer = (is_answer || line.contains("<summary>Answer")) && !line.contains("</details>");
        if line.starts_with("```") {
            is_code = !is_code;
            continue;
        }
        let parts: Vec<&str> = match is_code {
            true => vec![line],
            false => line.split('`').skip(1).step_by(2).collect(),
        };
        for part in parts.into_iter().filter(|part| part.starts_with("cargo ")) {
            found.push(PageCommand {
                page: page.clone().into_owned(),
                words: words(part),
                is_answer,
            });
        }
    }
    found
}

fn all_commands() -> Vec<PageCommand> {
    let pages = fs::read_dir(root().join("book/pages")).expect("the pages");
    let mut files: Vec<PathBuf> = pages.map(|entry| entry.expect("an entry").path()).collect();
    files.push(root().join("README.md"));
    files.retain(|file| file.extension().is_some_and(|e| e == "md"));
    files.iter().flat_map(|file| commands(file)).collect()
}

impl PageCommand {
    /// Returns the word after an option.
    fn after(&self, option: &str) -> Option<&str> {
        let place = self.words.iter().position(|word| word == option)?;
        self.words.get(place + 1).map(String::as_str)
    }

    /// Returns the program's own options, after `--`.
    fn options(&self) -> Vec<&str> {
        let words = self.words.iter().map(String::as_str);
        words.skip_while(|word| *word != "--").skip(1).collect()
    }
}

/// Returns the options of a program that has them in the library; `None` for others.
fn parser(program: &str) -> Option<Command> {
    Some(match program {
        "render" => Render::command(),
        "compare" => Compare::command(),
        "judge" => Judge::command(),
        "export" => Export::command(),
        "metamorphic" => Metamorphic::command(),
        _ => return None,
    })
}

/// Names of all trials, and of all faults of each.
fn test_names() -> Vec<String> {
    let of = |trial: &Trial| {
        let faults = trial
            .controls
            .iter()
            .map(|c| format!("{}!{}", trial.name, c.name));
        faults.chain([trial.name.clone()]).collect::<Vec<_>>()
    };
    all().iter().flat_map(of).collect()
}

#[test]
fn commands_on_pages_are_those_of_the_programs() {
    let names = test_names();
    let is_experiment = |id: &str| EXPERIMENTS.iter().any(|experiment| experiment.id == id);
    let mut wrong = Vec::new();
    // The pages' name for the reader's own scene.
    let scene = root().join("tests/library/data/scenes/knot.toml");
    let scene = scene.display().to_string();
    let all = all_commands();
    assert!(all.len() > 40, "{} commands", all.len());
    for command in &all {
        let mut says = |what: String| {
            wrong.push(format!(
                "{}: {}: {what}",
                command.page,
                command.words.join(" ")
            ));
        };
        let options = command.options();
        match command.words[1].as_str() {
            "run" => {
                let program = command.after("--bin").unwrap_or("reproduce");
                if let Some(parser) = parser(program) {
                    let own = |word: &str| word.replace("room.toml", &scene);
                    let words = options.iter().map(|word| own(word));
                    let line = [program.to_owned()].into_iter().chain(words);
                    if let Err(error) = parser.try_get_matches_from(line) {
                        says(error.to_string());
                    }
                } else if !is_experiment(program) && !is_program(program) {
                    says("no such program".to_owned());
                }
                let only = options
                    .iter()
                    .skip_while(|option| **option != "--only")
                    .nth(1);
                for id in only.iter().flat_map(|ids| ids.split(',')) {
                    if !is_experiment(id) {
                        says(format!("no experiment {id}"));
                    }
                }
            }
            "test" => {
                let pattern = command.words.get(2).filter(|word| !word.starts_with('-'));
                if pattern.is_some_and(|pattern| !names.iter().any(|name| name.contains(pattern))) {
                    says("no such trial or fault".to_owned());
                }
            }
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Returns whether a program of this name has a source file.
fn is_program(name: &str) -> bool {
    let file = root().join(format!("experiments/src/bin/{name}.rs"));
    file.is_file()
}

/// Options of a command that decide no pixel, or by which an answer's runs differ.
const APART: [&str; 3] = ["--out", "--threads", "--seed"];

/// Every render of an answer is one of the experiment `answers`, or runs here, with few pixels. Its
/// tests exist: see above.
#[test]
fn commands_of_answers_run() {
    let mut rendered = 0;
    for command in all_commands().iter().filter(|command| command.is_answer) {
        if command.after("--bin") != Some("render") {
            continue;
        }
        let mut options = command.options();
        while let Some(place) = options.iter().position(|option| APART.contains(option)) {
            options.drain(place..place + 2);
        }
        let options = options.join(" ");
        rendered += 1;
        if COMMANDS.contains(&options.as_str()) {
            continue;
        }
        let mut job = job(&format!("render {options}"));
        job.size = [8, 6];
        let film = job
            .render("")
            .unwrap_or_else(|error| panic!("{options}: {error}"));
        assert!(film.into_complete().is_ok(), "{options}");
    }
    assert!(rendered > 10, "{rendered} renders in answers");
}
