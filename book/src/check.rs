//! Checks that need the written pages or `SUMMARY.md`.

use std::path::{Path, PathBuf};

use mdbook_markdown::pulldown_cmark::{Event, Parser, Tag};
use records::Problem;
use roxmltree::Document;

use crate::error::Error;
use crate::links::{Target, line};

/// Checks that every page that `SUMMARY.md` names exists.
pub fn summary(pages: &Path) -> Result<(), Error> {
    let file = pages.join("SUMMARY.md");
    let text = std::fs::read_to_string(&file).map_err(Error::io(&file))?;
    let mut problems = Vec::new();
    for (event, span) in Parser::new(&text).into_offset_iter() {
        if let Event::Start(Tag::Link { dest_url, .. }) = event
            && !dest_url.is_empty()
            && !pages.join(dest_url.as_ref()).is_file()
        {
            problems.push(Problem::new(
                &file,
                line(&text, span.start),
                format!("there is no page {dest_url}"),
            ));
        }
    }
    fail_if(problems)
}

/// Checks that the ids that links name exist on the written pages.
pub fn targets(targets: &[Target], out: &Path) -> Result<(), Error> {
    let mut problems = Vec::new();
    for target in targets {
        let page = out.join(target.page.with_extension("html"));
        if !has_id(
            &std::fs::read_to_string(&page).map_err(Error::io(&page))?,
            &target.id,
        ) {
            let message = format!("no heading #{} on {}", target.id, target.page.display());
            problems.push(Problem::new(&target.file, target.line, message));
        }
    }
    fail_if(problems)
}

/// Checks that the written pages load nothing from outside and link only to existing files.
pub fn output(out: &Path) -> Result<(), Error> {
    let mut problems = Vec::new();
    for file in files(out)? {
        let extension = file
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default();
        if !matches!(extension, "html" | "css") {
            continue;
        }
        let text = std::fs::read_to_string(&file).map_err(Error::io(&file))?;
        let marks: &[(&str, char)] = match extension {
            "html" => &[
                (" src=\"", '"'),
                (" href=\"", '"'),
                (" srcset=\"", '"'),
                (" action=\"", '"'),
            ],
            _ => &[("url(", ')'), ("@import ", ';')],
        };
        for (at, address) in marks
            .iter()
            .flat_map(|&(start, end)| addresses(&text, start, end))
        {
            if let Some(message) = link_error(&file, &text, address)? {
                problems.push(Problem::new(&file, line(&text, at), message));
            }
        }
    }
    problems.sort();
    fail_if(problems)
}

/// Checks that browsers can show these pictures. They do not show an SVG that is not well-formed,
/// and choose a size for one without.
pub fn pictures<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Error> {
    let mut problems = Vec::new();
    for file in files {
        let bytes = std::fs::read(file).map_err(Error::io(file))?;
        let fault = match file.extension().and_then(|e| e.to_str()) {
            Some("svg") => svg(&bytes),
            Some("png") => (!is_png(&bytes)).then(|| (1, "not a whole PNG".to_owned())),
            _ => Some((1, "a figure is an SVG or a PNG".to_owned())),
        };
        problems.extend(fault.map(|(line, message)| Problem::new(file, line, message)));
    }
    fail_if(problems)
}

/// Returns the line and the description of an error in an SVG.
fn svg(bytes: &[u8]) -> Option<(usize, String)> {
    let text = String::from_utf8_lossy(bytes);
    let document = match Document::parse(&text) {
        Ok(document) => document,
        Err(error) => return Some((error.pos().row as usize, error.to_string())),
    };
    let root = document.root_element();
    let line = document.text_pos_at(root.range().start).row as usize;
    if !root.has_tag_name(("http://www.w3.org/2000/svg", "svg")) {
        return Some((line, "the root is no svg element of SVG".to_owned()));
    }
    let positive = |text: &str| {
        text.parse()
            .is_ok_and(|length: f64| length > 0.0 && length.is_finite())
    };
    let view = root.attribute("viewBox").unwrap_or_default();
    let view: Vec<&str> = view.split_whitespace().collect();
    let has_size = ["width", "height"]
        .iter()
        .all(|side| root.attribute(*side).is_some_and(positive));
    let has_view = matches!(view[..], [_, _, width, height] if positive(width) && positive(height));
    (!has_size || !has_view).then(|| {
        (
            line,
            "needs width, height and viewBox in positive numbers".to_owned(),
        )
    })
}

/// Returns true if the bytes begin and end like a PNG.
fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82")
}

/// Returns every file below `folder`.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(Error::io(folder))? {
        let path = entry.map_err(Error::io(folder))?.path();
        if path.is_dir() {
            files.extend(self::files(&path)?);
        } else {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Returns the text between every `start` and the next `end`, with its position.
fn addresses<'a>(
    text: &'a str,
    start: &'static str,
    end: char,
) -> impl Iterator<Item = (usize, &'a str)> {
    text.match_indices(start).map(move |(at, found)| {
        let rest = &text[at + found.len()..];
        let end = rest.find(end).unwrap_or(rest.len());
        (at, rest[..end].trim_matches(['"', '\'', ' ']))
    })
}

/// Returns the error in an address in `file`, whose text is `text`; `None` if the address is right.
fn link_error(file: &Path, text: &str, address: &str) -> Result<Option<String>, Error> {
    if address.starts_with("data:") {
        return Ok(None);
    }
    if address.contains("://") || address.starts_with("//") || address.starts_with('/') {
        return Ok(Some(format!("address outside of the book: {address}")));
    }
    let (path, id) = address.split_once('#').unwrap_or((address, ""));
    let path = path.split('?').next().unwrap_or_default();
    let target = match path {
        "" => file.to_owned(),
        _ => file.parent().unwrap_or(Path::new("")).join(path),
    };
    if !target.is_file() {
        return Ok(Some(format!("no file for address {address}")));
    }
    if id.is_empty() || target.extension().is_none_or(|e| e != "html") {
        return Ok(None);
    }
    let found = if target == file {
        has_id(text, id)
    } else {
        has_id(
            &std::fs::read_to_string(&target).map_err(Error::io(&target))?,
            id,
        )
    };
    Ok((!found).then(|| format!("no element with the id of address {address}")))
}

fn has_id(html: &str, id: &str) -> bool {
    html.contains(&format!("id=\"{id}\""))
}

/// Returns all problems as an error, if there are any.
pub(crate) fn fail_if(problems: Vec<Problem>) -> Result<(), Error> {
    if problems.is_empty() {
        Ok(())
    } else {
        Err(Error::Problems(problems))
    }
}
