//! Extracts items from the project's Rust sources, so that no code is typed into the book.
//!
//! It relies only on the sources being formatted by rustfmt, which CI enforces: an item starts at
//! the line that declares its name and ends at the first line of the same indentation that ends
//! with `}` or `;`.

use std::path::{Component, Path};

use whitefurnace::suggest::did_you_mean;

/// An item as it stands in its file, without its outer indentation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listing {
    /// Documentation, attributes and code.
    pub code: String,
    /// Line of its declaration, from 1.
    pub line: usize,
}

/// Keywords that declare an item.
const KEYWORDS: [&str; 8] = [
    "fn", "struct", "enum", "trait", "const", "static", "type", "mod",
];

/// Reads `path`, relative to `root` and inside it.
pub fn read(root: &Path, path: &str) -> Result<String, String> {
    let relative = Path::new(path);
    let inside = relative
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    if !inside || relative.extension().is_none_or(|e| e != "rs") {
        return Err(format!(
            "\"{path}\" is not the path of a Rust file inside the project, such as src/material/fresnel.rs"
        ));
    }
    std::fs::read_to_string(root.join(relative)).map_err(|error| {
        format!(
            "cannot read {path}: {error}{}",
            did_you_mean(path, siblings(root, relative))
        )
    })
}

/// Returns the Rust files in the folder of `relative`.
fn siblings(root: &Path, relative: &Path) -> Vec<String> {
    let folder = relative.parent().unwrap_or(Path::new(""));
    let Ok(entries) = std::fs::read_dir(root.join(folder)) else {
        return Vec::new();
    };
    let mut names: Vec<_> = entries
        .flatten()
        .map(|entry| folder.join(entry.file_name()).display().to_string())
        .filter(|name| name.ends_with(".rs"))
        .collect();
    names.sort();
    names
}

/// Returns the item `name` of `source`: `reflectance`, or `OrenNayar::new` for an item of an `impl`
/// or trait.
pub fn item(source: &str, name: &str) -> Result<Listing, String> {
    let lines: Vec<&str> = source.lines().collect();
    let starts: Vec<usize> = match name.split_once("::") {
        Some((owner, item)) => (0..lines.len())
            .filter(|&at| indentation(lines[at]) == 0 && is_block_of(lines[at], owner))
            .flat_map(|at| {
                let block = at + 1..=end(&lines, at).unwrap_or(at);
                block.filter(|&at| indentation(lines[at]) == 4)
            })
            .filter(|&at| declared(lines[at]) == Some(item))
            .collect(),
        None => {
            let all = (0..lines.len()).filter(|&at| declared(lines[at]) == Some(name));
            let (outer, inner): (Vec<_>, Vec<_>) = all.partition(|&at| indentation(lines[at]) == 0);
            if outer.is_empty() { inner } else { outer }
        }
    };
    match starts[..] {
        [start] => extract(&lines, start, name),
        [] => {
            let known = lines.iter().filter_map(|line| declared(line));
            Err(format!(
                "no item \"{name}\" in it{}",
                did_you_mean(name, known)
            ))
        }
        _ => {
            let at: Vec<_> = starts.iter().map(|at| (at + 1).to_string()).collect();
            Err(format!(
                "more than one item \"{name}\" in it, at lines {}; write Type::{name}",
                at.join(", ")
            ))
        }
    }
}

/// Returns the item that starts at line `start`, with the documentation and attributes above it.
fn extract(lines: &[&str], start: usize, name: &str) -> Result<Listing, String> {
    let end = end(lines, start).ok_or_else(|| format!("item \"{name}\" has no end"))?;
    let above = lines[..start]
        .iter()
        .rev()
        .take_while(|line| {
            let line = line.trim_start();
            line.starts_with("///") || line.starts_with("#[")
        })
        .count();
    let indentation = indentation(lines[start]);
    let code: Vec<&str> = lines[start - above..=end]
        .iter()
        .map(|line| line.get(indentation..).unwrap_or_default())
        .collect();
    Ok(Listing {
        code: code.join("\n"),
        line: start + 1,
    })
}

/// Returns the last line of the item that starts at `start`.
fn end(lines: &[&str], start: usize) -> Option<usize> {
    let outer = indentation(lines[start]);
    (start..lines.len()).find(|&at| {
        let line = lines[at];
        !line.is_empty() && indentation(line) == outer && line.ends_with(['}', ';'])
    })
}

fn indentation(line: &str) -> usize {
    line.len() - line.trim_start_matches(' ').len()
}

/// Returns the name that a line declares.
pub(crate) fn declared(line: &str) -> Option<&str> {
    let mut words = line.split_whitespace().peekable();
    while let Some(word) = words.next() {
        let next = words.peek().copied().unwrap_or_default();
        let qualifies = matches!(word, "pub" | "async" | "unsafe" | "default")
            || word.starts_with("pub(")
            || (word == "const" && matches!(next, "fn" | "unsafe" | "async"));
        if qualifies {
            continue;
        }
        if KEYWORDS.contains(&word) {
            return identifier(next);
        }
        return None;
    }
    None
}

/// Returns the identifier at the start of `text`.
fn identifier(text: &str) -> Option<&str> {
    let end = text
        .find(|c: char| !c.is_alphanumeric() && c != '_')
        .unwrap_or(text.len());
    (end > 0).then(|| &text[..end])
}

/// Returns true if the line opens an `impl` of `owner`, or the trait `owner`.
fn is_block_of(line: &str, owner: &str) -> bool {
    if line.starts_with("impl") {
        let target = line.rsplit(" for ").next().unwrap_or(line);
        let target = target.split(" where ").next().unwrap_or(target);
        target
            .split(|c: char| !c.is_alphanumeric() && c != '_')
            .any(|word| word == owner)
    } else {
        line.contains("trait ") && declared(line) == Some(owner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = include_str!("listing/sample.txt");

    fn code(name: &str) -> String {
        item(SOURCE, name).expect(name).code
    }

    #[test]
    fn items_come_whole_with_their_documentation() {
        assert_eq!(
            code("LIMIT"),
            "/// A constant.\npub const LIMIT: f64 = 1.0;"
        );
        assert!(code("TABLE").ends_with("    2,\n];"));
        let twice = item(SOURCE, "twice").expect("twice");
        assert!(
            twice
                .code
                .starts_with("/// Twice.\n///\n/// More.\n#[inline]\npub fn")
        );
        assert!(twice.code.ends_with("\n    2.0 * x\n}"));
        assert_eq!(twice.line, 16);
        assert_eq!(code("A"), "pub struct A;");
    }

    #[test]
    fn methods_are_named_by_their_type() {
        assert_eq!(
            code("A::new"),
            "/// New A.\npub const fn new() -> Self {\n    A\n}"
        );
        assert!(code("B::new").contains("x: f64"));
        assert!(code("from").contains("_: A"));
    }

    #[test]
    fn ambiguous_names_are_told() {
        let ambiguous = item(SOURCE, "new").expect_err("ambiguous");
        assert!(ambiguous.contains("lines 29, 41"), "{ambiguous}");
    }
}
