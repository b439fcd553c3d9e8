//! Wavefront OBJ: vertices, faces and the names of their materials, with line numbers of errors.
//! Normals and texture coordinates do not affect the geometry; other lines that are ignored are
//! counted in notes.

use std::borrow::Cow;
use std::collections::BTreeMap;

use glam::DVec3;

use super::polygon::Polygons;
use super::reader::{LARGEST, error_at_line, quote};
use super::schema::Limits;
use super::signatures;
use crate::error::Error;

/// A mesh.
#[derive(Default)]
pub(super) struct Obj {
    pub vertices: Vec<DVec3>,
    /// Names that `usemtl` gives its faces, in the order of the file.
    pub materials: Vec<Name>,
    /// Triangles, each with the index of its material's name.
    pub triangles: Vec<(usize, [u32; 3])>,
    /// Notes that a user should know, one line each.
    pub notes: Vec<String>,
}

/// Name of the material of some faces.
pub(super) struct Name {
    /// Name; `None` for faces before the first `usemtl`.
    pub name: Option<String>,
    /// Line of the first of the faces.
    pub line: usize,
}

/// Parses the bytes of a file.
///
/// # Errors
/// [`Error::Scene`] with the line of the error, or the kind of the file if it is no OBJ.
pub(super) fn parse(file: &str, bytes: &[u8], limits: &mut Limits) -> Result<Obj, Error> {
    if let Some(kind) = signatures::kind(bytes) {
        return Err(error_at_line(
            file,
            1,
            format!("the file is {kind}; a Wavefront OBJ file is needed"),
        ));
    }
    let text = String::from_utf8_lossy(bytes);
    // Old programs end lines by CR alone.
    let text = if text.contains('\r') {
        Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
    } else {
        text
    };
    let (mut obj, mut polygons) = (Obj::default(), Polygons::default());
    let (mut weighted, mut unread) = (0, BTreeMap::<String, usize>::new());
    // The name of the current material, and its index once a face has it.
    let (mut name, mut material) = (None, None);
    let mut lines = (1..).zip(text.lines());
    while let Some((line, first)) = lines.next() {
        let wrong = |message: String| error_at_line(file, line, message);
        let (mut joined, mut piece) = (String::new(), content(first));
        while let Some(before) = piece
            .trim_end()
            .strip_suffix('\\')
            .filter(|_| !ends_with_name(first))
        {
            joined.extend([before, " "]);
            piece = lines.next().map_or("", |(_, next)| content(next));
        }
        let logical = if joined.is_empty() {
            Cow::from(piece)
        } else {
            Cow::from(joined + piece)
        };
        let mut words = logical.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        match keyword {
            "v" => {
                limits.vertices(1).map_err(wrong)?;
                let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
                // Three coordinates, perhaps a weight or a colour.
                let is_sound = |numbers: &Vec<f64>| {
                    (3..=8).contains(&numbers.len())
                        && numbers[..3].iter().all(|x| x.abs() <= LARGEST)
                };
                let numbers = numbers.filter(is_sound).ok_or_else(|| {
                    wrong(format!("a vertex needs three numbers from -{LARGEST} to {LARGEST} and no other words"))
                })?;
                weighted += usize::from(numbers.len() == 4 && numbers[3] != 1.0);
                obj.vertices.push(DVec3::from_slice(&numbers));
            }
            "f" | "fo" => {
                let count = obj.vertices.len();
                let corners = words.map(|word| {
                    corner(word, count).ok_or_else(|| {
                        let word = quote(word);
                        wrong(format!(
                            "a face's corner {word} is none of the {count} vertices before it"
                        ))
                    })
                });
                let corners = corners.collect::<Result<Vec<u32>, _>>()?;
                if corners.len() < 3 {
                    return Err(wrong("a face needs at least three corners".to_owned()));
                }
                limits.triangles(corners.len() - 2).map_err(wrong)?;
                let triangles = polygons
                    .add(&obj.vertices, &corners)
                    .map_err(|message| wrong(format!("the face {message}")))?;
                let of = *material.get_or_insert_with(|| {
                    let known = obj.materials.iter().position(|known| known.name == name);
                    known.unwrap_or_else(|| {
                        obj.materials.push(Name {
                            name: name.clone(),
                            line,
                        });
                        obj.materials.len() - 1
                    })
                });
                obj.triangles
                    .extend(triangles.into_iter().map(|triangle| (of, triangle)));
            }
            "usemtl" => {
                (name, material) = (name_in(first), None);
            }
            "vt" | "vn" | "o" | "g" | "s" => {}
            other => *unread.entry(quote(other)).or_default() += 1,
        }
    }
    if obj.materials.is_empty() {
        let hint = if unread.contains_key("\"newmtl\"") {
            ": it is a library of materials (MTL)".to_owned()
        } else if unread.is_empty() {
            String::new()
        } else {
            format!("; its other lines begin with {}", keywords(&unread))
        };
        return Err(error_at_line(
            file,
            text.lines().count().max(1),
            format!("the file ends without a face{hint}"),
        ));
    }
    let mut notes: Vec<String> = polygons.notes().collect();
    if weighted > 0 {
        notes.push(format!(
            "{weighted} vertices have a weight other than 1, which is not used"
        ));
    }
    if unread.remove("\"mtllib\"").is_some() {
        notes.push(
            "its mtllib is not read: the scene file has the materials, which usemtl names"
                .to_owned(),
        );
    }
    if !unread.is_empty() {
        notes.push(format!(
            "lines of other kinds are left out: {}",
            keywords(&unread)
        ));
    }
    obj.notes = notes.iter().map(|note| format!("{file}: {note}")).collect();
    Ok(obj)
}

/// Lists the keywords of lines that are not read, the first eight of them, with their counts.
fn keywords(unread: &BTreeMap<String, usize>) -> String {
    let counts = unread.iter().take(8);
    let counts: Vec<String> = counts
        .map(|(word, count)| format!("{word} ({count})"))
        .collect();
    let more = if unread.len() > 8 { " and others" } else { "" };
    counts.join(", ") + more
}

/// Returns a line without the byte-order mark before it and the comment behind it. The `#` of an
/// invalid number such as 1.#INF begins no comment.
fn content(line: &str) -> &str {
    let line = line.trim_start_matches('\u{feff}');
    let comment = line
        .match_indices('#')
        .find(|(at, _)| !line[..*at].ends_with('.'));
    comment.map_or(line, |(at, _)| &line[..at])
}

/// Returns whether a line ends with a name, in which a `\` is no continuation: it may be a path of
/// Windows.
fn ends_with_name(line: &str) -> bool {
    let keyword = content(line).split_ascii_whitespace().next();
    keyword.is_some_and(|keyword| ["o", "g", "usemtl", "mtllib"].contains(&keyword))
}

/// Returns the name after `usemtl`, which may hold blanks and `#`, but not a blank before `#`.
fn name_in(line: &str) -> Option<String> {
    let name = line.trim().split_once(char::is_whitespace)?.1.trim_start();
    let comment = name
        .match_indices('#')
        .find(|(at, _)| name[..*at].ends_with([' ', '\t']));
    Some(
        comment
            .map_or(name, |(at, _)| name[..at].trim_end())
            .to_owned(),
    )
}

/// Returns the index of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, where 1 is the first vertex and
/// −1 the latest.
fn corner(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 {
        count as i64 + number
    } else {
        number - 1
    };
    u32::try_from(index)
        .ok()
        .filter(|index| (*index as usize) < count)
}
