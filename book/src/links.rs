//! Links of the pages: their targets, and the addresses that the weave writes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use records::Problem;
use whitefurnace::suggest::did_you_mean;

use crate::scan::Page;

/// A link to a heading or another id, to be checked when the pages are written.
#[derive(Debug)]
pub struct Target {
    pub file: PathBuf,
    pub line: usize,
    /// Page it leads to, relative to the pages.
    pub page: PathBuf,
    /// Id after `#`.
    pub id: String,
}

/// Checks the links and images of one page as far as the sources show.
///
/// `path` is the page relative to the folder `pages`, `text` its source, `known` all pages of the
/// book. Links that can only be checked on the written pages are returned; errors go to `problems`.
pub fn check(
    pages: &Path,
    path: &Path,
    text: &str,
    page: &Page,
    known: &BTreeSet<PathBuf>,
    problems: &mut Vec<Problem>,
) -> Vec<Target> {
    let mut targets = Vec::new();
    for (span, link) in &page.links {
        let line = line(text, span.start);
        let mut problem = |message| problems.push(Problem::new(pages.join(path), line, message));
        let (file, id) = link.split_once('#').unwrap_or((link, ""));
        if link.starts_with("//") || file.contains(':') {
            problem(format!(
                "link to the outside, {link}; cite the work instead"
            ));
            continue;
        }
        let resolved = match file {
            "" => path.to_owned(),
            _ => join(path.parent().unwrap_or(Path::new("")), file),
        };
        if resolved.extension().is_some_and(|e| e == "md") {
            if !known.contains(&resolved) {
                let names = known.iter().filter_map(|page| page.to_str());
                problem(format!(
                    "no page {file} in SUMMARY.md{}",
                    did_you_mean(file, names)
                ));
            } else if !id.is_empty() {
                targets.push(Target {
                    file: pages.join(path),
                    line,
                    page: resolved,
                    id: id.to_owned(),
                });
            }
        } else if !pages.join(&resolved).is_file() {
            problem(format!("no file {file} beside this page"));
        }
    }
    targets
}

/// Returns the line of a byte, from 1.
pub fn line(text: &str, at: usize) -> usize {
    1 + text[..at].matches('\n').count()
}

/// Returns `../` once per folder above the page.
pub fn to_root(page: &Path) -> String {
    "../".repeat(page.components().count().saturating_sub(1))
}

/// Returns the relative address of an id on another page.
pub fn address(from: &Path, page: &Path, id: &str) -> String {
    format!(
        "{}{}#{id}",
        to_root(from),
        page.with_extension("html").display()
    )
}

/// Returns `file` relative to `folder`, with `..` resolved.
fn join(folder: &Path, file: &str) -> PathBuf {
    let mut path = folder.to_owned();
    for part in file.split('/') {
        match part {
            "." | "" => {}
            ".." if path.pop() => {}
            part => path.push(part),
        }
    }
    path
}
