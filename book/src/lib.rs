//! Weaves the whitefurnace book: mdBook as a library, with the project's equations, code, recorded
//! numbers and figures put in by directives. Nothing is read from the network or the clock.
//!
//! | directive | puts in |
//! |---|---|
//! | `{{#eq ID}}` | an equation of the registry with its verdict, finding and source |
//! | `{{#ref ID}}` | a link to the place that shows it |
//! | `{{#result EXPERIMENT.KEY [FORMAT]}}` | a recorded number, see [`records::number::format`] |
//! | `{{#figure EXPERIMENT/NAME.svg "caption"}}` | a recorded figure and the command that repeats it |
//! | `{{#code PATH ITEM...}}` | items of a source file, see `listing` |
//! | `{{#cite KEY}}` | a link into the bibliography |
//! | `{{#equations}}`, `{{#tally}}`, `{{#experiments}}`, `{{#bibliography}}` | generated tables |
//! | `{{#question "FAMILY: FAULT" TRIAL TRIAL...}}` | which of the trials reject the fault, from the recorded matrices |
//! | `{{#trials}}`, `{{#faults}}`, `{{#traceability}}` | tables from the registry of trials |
//! | `{{#run}}` | a link to the page that compares the reader's own run with the record |
//! | `{{#models}}` | the models of scene files, with their keys and ranges |
//! | `{{#mutants}}` | tables of the recorded mutants, see [`records::mutants::Record`] |
//!
//! The explorables' scripts in `pages/explore` compare their functions with the library's values,
//! which are written to `explore/reference.js`.
//!
//! The first use of a glossary's word on a page is linked to its entry, see `glossary`.
//!
//! Formulas are written `$…$` and `$$…$$`. Whatever is missing fails the build with file and line.

use std::path::{Path, PathBuf};

use mdbook_driver::MDBook;
use mdbook_driver::book::{BookItem, Chapter};
use records::results::Results;

mod bibliography;
pub mod check;
mod directives;
mod equations;
mod error;
mod explorables;
mod glossary;
mod links;
mod listing;
mod mathml;
mod mutants;
mod questions;
mod registry;
pub mod run;
mod scan;
pub mod trace;
mod weaver;

pub use error::Error;

/// Inputs and output of a weave.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder with `book.toml`, `bibliography.toml` and the pages.
    pub book: PathBuf,
    /// The project's folder, from which code is taken.
    pub sources: PathBuf,
    /// Folder of recorded results.
    pub results: PathBuf,
    /// Folder of a reader's own run, for a page that compares it with the record.
    pub run: Option<PathBuf>,
    /// Output folder. The files of an earlier weave are removed.
    pub out: PathBuf,
}

impl Default for Options {
    /// Returns the options for this project's book with its recorded results, in `out/book`.
    fn default() -> Self {
        let book = Path::new(env!("CARGO_MANIFEST_DIR"));
        Self {
            book: book.to_owned(),
            sources: book.parent().unwrap_or(book).to_owned(),
            results: book.join("recorded"),
            run: None,
            out: PathBuf::from("out/book"),
        }
    }
}

/// Weaves the book and returns the path of its first page. All errors in the sources are reported
/// together, and nothing is written then, except for errors that only the written pages show.
pub fn build(options: &Options) -> Result<PathBuf, Error> {
    let mdbook = |error: mdbook_driver::errors::Error| Error::Mdbook(format!("{error:#}"));
    let book = shorten(&options.book);
    let out = std::path::absolute(&options.out).map_err(Error::io(&options.out))?;
    check_output_folder(&options.out)?;
    let results = load(&options.results)?;
    let own = options.run.as_deref().map(own).transpose()?;
    let bibliography = bibliography::Bibliography::load(&book.join("bibliography.toml"))?;

    let config = book.join("book.toml");
    let mut config = mdbook_driver::config::Config::from_disk(&config).map_err(mdbook)?;
    let pages = book.join(&config.book.src);
    check::summary(&pages)?;
    config.build.build_dir.clone_from(&out);
    let mut mdbook_book = MDBook::load_with_config(&options.book, config).map_err(mdbook)?;

    let mut builder = weaver::BookBuilder::new(&pages, &options.sources, &results, &bibliography);
    builder.has_run = own.is_some();
    builder.build(&mut mdbook_book.book);
    check::fail_if(std::mem::take(&mut builder.problems))?;
    if let Some(own) = &own {
        let (text, figures) = run::page(&results, own);
        builder.figures.extend(figures);
        // After the introduction, which says what it is.
        let chapter = Chapter::new(run::TITLE, text, run::SOURCE, Vec::new());
        let items = &mut mdbook_book.book.items;
        items.insert(items.len().min(1), BookItem::Chapter(chapter));
    }
    check::pictures(builder.figures.values())?;
    mdbook_book.build().map_err(mdbook)?;
    for (name, file) in &builder.figures {
        let copy = out.join("figures").join(name);
        let folder = copy.parent().unwrap_or(&out);
        std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
        std::fs::copy(file, &copy).map_err(Error::io(file))?;
    }
    let explorables = out.join("explore");
    if explorables.is_dir() {
        let file = explorables.join("reference.js");
        std::fs::write(&file, explorables::reference()).map_err(Error::io(&file))?;
    }
    check::targets(&builder.targets, &out)?;
    check::output(&out)?;
    Ok(options.out.join("index.html"))
}

/// Loads all results in a folder.
fn load(folder: &Path) -> Result<Results, Error> {
    Results::load(&shorten(folder)).map_err(Error::Problems)
}

/// Loads the results of a reader's own run.
fn own(folder: &Path) -> Result<Results, Error> {
    let own = load(folder)?;
    if own.all().next().is_none() {
        return Err(Error::NoRun(folder.to_owned()));
    }
    Ok(own)
}

/// Refuses to empty a folder that holds something other than a woven book.
fn check_output_folder(out: &Path) -> Result<(), Error> {
    if !out.exists() {
        return Ok(());
    }
    let mut entries = std::fs::read_dir(out).map_err(Error::io(out))?;
    let woven = out.join("index.html").is_file() && out.join("toc.js").is_file();
    if entries.next().is_some() && !woven {
        return Err(Error::Occupied(out.to_owned()));
    }
    Ok(())
}

/// Returns `path` relative to the current folder where that is shorter, for messages.
fn shorten(path: &Path) -> PathBuf {
    std::env::current_dir()
        .ok()
        .and_then(|here| path.strip_prefix(here).ok().map(Path::to_owned))
        .unwrap_or_else(|| path.to_owned())
}
