//! Wavefront OBJ: vertices and faces, with the line of what is wrong. All else in it (normals, textures, materials,
//! groups, lines, points) says nothing of a surface's geometry and is left unread.

use glam::DVec3;

use super::reader::{LARGEST, fault, shown};
use super::schema::{Limits, fan};
use crate::error::Error;

/// A mesh, and how many of its triangles were left out for want of area.
pub(super) struct Obj {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a text; faces are divided into triangles from their first corner.
pub(super) fn parse(file: &str, text: &str, limits: &mut Limits) -> Result<Obj, Error> {
    let mut obj = Obj { vertices: Vec::new(), triangles: Vec::new() };
    for (line, text) in (1..).zip(text.lines()) {
        let wrong = |message: String| fault(file, line, message);
        let mut words = text.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                limits.vertices(1).map_err(wrong)?;
                let number = |word: &str| word.parse().ok().filter(|x: &f64| x.abs() <= LARGEST);
                let numbers: Option<Vec<f64>> = words.take(3).map(number).collect();
                let numbers = numbers.filter(|numbers| numbers.len() == 3);
                let needs = || wrong(format!("a vertex needs three numbers from -{LARGEST} to {LARGEST}"));
                obj.vertices.push(DVec3::from_slice(&numbers.ok_or_else(needs)?));
            }
            Some("f") => {
                let count = obj.vertices.len();
                let corners = words.map(|word| {
                    corner(word, count).ok_or_else(|| {
                        let word = shown(word);
                        wrong(format!("a face's corner {word} is none of the {count} vertices before it"))
                    })
                });
                let corners = corners.collect::<Result<Vec<u32>, _>>()?;
                if corners.len() < 3 {
                    return Err(wrong("a face needs at least three corners".to_owned()));
                }
                limits.triangles(corners.len() - 2).map_err(wrong)?;
                obj.triangles.extend(fan(&corners));
            }
            _ => {}
        }
    }
    if obj.triangles.is_empty() {
        return Err(fault(file, text.lines().count().max(1), "the file ends without a face"));
    }
    Ok(obj)
}

/// The index of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, where 1 is the first vertex and −1 the latest.
fn corner(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    u32::try_from(index).ok().filter(|index| (*index as usize) < count)
}
