//! Links from the first use of a word on each page to its entry in the glossary.
//!
//! The page `glossary.md` has an entry `**Word, other form.** Meaning.` per line that begins so. A
//! word is found with a capital or an s, and with hyphens for spaces.

use std::ops::Range;
use std::path::Path;

use crate::scan::Page;

/// The glossary's page.
pub const PAGE: &str = "glossary.md";

/// Words that have another meaning on many pages; links to their entries are written by hand.
const AMBIGUOUS: [&str; 3] = ["effect", "level", "power"];

/// An entry of the glossary.
#[derive(Debug)]
pub struct Entry {
    /// Position of the entry in the glossary's text.
    at: usize,
    id: String,
    /// Forms of the word, in small letters unless they are abbreviations.
    forms: Vec<String>,
}

/// Returns the entries of the glossary.
pub fn entries(text: &str) -> Vec<Entry> {
    let mut at = 0;
    let mut entries = Vec::new();
    for line in text.split_inclusive('\n') {
        let name = line.strip_prefix("**").and_then(|l| l.split_once(".**"));
        if let Some((name, _)) = name {
            let forms: Vec<String> = name.split(", ").map(uncapitalised).collect();
            let id = forms[0].replace(|c: char| !c.is_alphanumeric(), "-");
            let id = format!("term-{}", id.to_lowercase());
            entries.push(Entry { at, id, forms });
        }
        at += line.len();
    }
    entries
}

/// Returns the edits of a page: ids for the entries of the glossary itself, links on other pages.
pub fn edits(
    entries: &[Entry],
    path: &Path,
    text: &str,
    page: &Page,
) -> Vec<(Range<usize>, String)> {
    if path == Path::new(PAGE) {
        let id = |entry: &Entry| format!("<span id=\"{}\"></span>", entry.id);
        return entries.iter().map(|e| (e.at..e.at, id(e))).collect();
    }
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    // Of forms that overlap, as "equivalence test" and "equivalence", the longest is linked.
    let mut entries: Vec<&Entry> = entries.iter().collect();
    let longest = |entry: &Entry| entry.forms.iter().map(String::len).max();
    entries.sort_by_key(|entry| std::cmp::Reverse(longest(entry)));
    for entry in entries {
        let is_free = |span: &Range<usize>| {
            let overlaps = |other: &Range<usize>| other.start < span.end && span.start < other.end;
            !page.directives.iter().any(|d| overlaps(&d.span))
                && !edits.iter().any(|(other, _)| overlaps(other))
        };
        let uses = page.prose.iter().flat_map(|prose| {
            let uses = entry
                .forms
                .iter()
                .flat_map(|form| uses(&text[prose.clone()], form));
            uses.map(|span| span.start + prose.start..span.end + prose.start)
        });
        let first = uses
            .filter(is_free)
            .min_by_key(|span| (span.start, std::cmp::Reverse(span.end)));
        if let Some(span) = first {
            let link = format!("[{}]({PAGE}#{})", &text[span.clone()], entry.id);
            edits.push((span, link));
        }
    }
    edits
}

/// Returns where `form` stands as a whole word.
fn uses(prose: &str, form: &str) -> Vec<Range<usize>> {
    if AMBIGUOUS.contains(&form) {
        return Vec::new();
    }
    let plain = |text: &str| text.replace(['\n', '-'], " ");
    let (prose, form) = (plain(prose), plain(form));
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let at = |(start, first): (usize, char)| {
        let rest = prose[start + first.len_utf8()..].strip_prefix(form.get(1..)?)?;
        let starts = form.starts_with(first) || form.starts_with(first.to_ascii_lowercase());
        let rest = rest.strip_prefix('s').unwrap_or(rest);
        let whole = !rest.starts_with(is_word) && !prose[..start].ends_with(is_word);
        (starts && whole).then(|| start..prose.len() - rest.len())
    };
    prose.char_indices().filter_map(at).collect()
}

/// Returns a word with a small first letter, unless it is an abbreviation or a name.
fn uncapitalised(word: &str) -> String {
    let is_name = word.starts_with("Bonferroni") || word.starts_with("Russian");
    let mut letters = word.chars();
    match letters.next() {
        Some(first) if !is_name && letters.clone().any(char::is_lowercase) => {
            first.to_lowercase().chain(letters).collect()
        }
        _ => word.to_owned(),
    }
}
