//! The agreement matrix, and the histograms of p-values behind it.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use whitefurnace::error::Error;

use super::{FAINT, FONT, INK, OKABE_ITO, write_svg};

/// What a cell of the matrix says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Within the margin.
    Agrees,
    /// Outside the margin or a bias of known size, for a reason that is stated.
    Explained,
    /// Too few samples to say.
    Undecided,
    /// Outside the margin, and nothing explains it.
    Differs,
    /// What the others are compared with.
    Reference,
}

/// A cell of the matrix.
#[derive(Clone, Debug)]
pub struct Square {
    /// The number, such as "+0.02 ± 0.10 %"; lines end with line feeds.
    pub text: String,
    /// How it stands.
    pub standing: Standing,
}

const CELL: (i32, i32) = (124, 44);
const LINE: i32 = 16;
const LEFT: i32 = 120;
const TOP: i32 = 92;

/// Draws rows × columns; what an estimator cannot handle stays empty.
///
/// # Errors
/// The file cannot be written.
pub fn squares(
    path: &Path,
    title: &str,
    rows: &[String],
    columns: &[String],
    square: impl Fn(usize, usize) -> Option<Square>,
) -> Result<(), Error> {
    let width = LEFT + columns.len() as i32 * CELL.0 + 16;
    let height = TOP + rows.len() as i32 * CELL.1 + 16;
    write_svg(path, [width as u32, height as u32], |root| {
        let text = |size: i32, h| {
            (FONT, size, &INK)
                .into_text_style(root)
                .pos(Pos::new(h, VPos::Center))
        };
        root.draw(&Text::new(title, (14, 16), text(16, HPos::Left)))?;
        let legend = [
            (Standing::Agrees, "agrees"),
            (Standing::Explained, "differs for a stated reason"),
            (Standing::Undecided, "undecided"),
            (Standing::Differs, "differs"),
            (Standing::Reference, "reference"),
        ];
        let mut x = 14;
        for (standing, label) in legend {
            draw(root, ((x, 36), (x + 26, 54)), standing)?;
            root.draw(&Text::new(label, (x + 32, 45), text(13, HPos::Left)))?;
            x += 52 + 7 * label.len() as i32;
        }
        for (c, name) in columns.iter().enumerate() {
            let at = (LEFT + c as i32 * CELL.0 + CELL.0 / 2, TOP - 12);
            root.draw(&Text::new(name.as_str(), at, text(13, HPos::Center)))?;
        }
        for (r, name) in rows.iter().enumerate() {
            let y = TOP + r as i32 * CELL.1;
            let at = (LEFT - 8, y + CELL.1 / 2);
            root.draw(&Text::new(name.as_str(), at, text(13, HPos::Right)))?;
            for c in 0..columns.len() {
                let x = LEFT + c as i32 * CELL.0;
                let frame = [(x, y), (x + CELL.0, y + CELL.1)];
                root.draw(&Rectangle::new(frame, FAINT))?;
                if let Some(square) = square(r, c) {
                    let inner = ((x + 1, y + 1), (x + CELL.0 - 1, y + CELL.1 - 1));
                    draw(root, inner, square.standing)?;
                    let count = square.text.lines().count() as i32;
                    for (i, line) in square.text.lines().enumerate() {
                        let offset = LINE * (2 * i as i32 + 1 - count) / 2;
                        let at = (x + CELL.0 / 2, y + CELL.1 / 2 + offset);
                        root.draw(&Text::new(line, at, text(12, HPos::Center)))?;
                    }
                }
            }
        }
        Ok(())
    })
}

/// Fills and borders can be told apart without colour.
fn draw(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    (from, to): ((i32, i32), (i32, i32)),
    standing: Standing,
) -> super::Drawn {
    let fill = match standing {
        Standing::Agrees => OKABE_ITO[1].mix(0.35),
        Standing::Explained => OKABE_ITO[5].mix(0.35),
        Standing::Undecided => FAINT.mix(0.6),
        Standing::Differs => OKABE_ITO[0].mix(0.6),
        Standing::Reference => WHITE.mix(1.0),
    };
    root.draw(&Rectangle::new([from, to], fill.filled()))?;
    match standing {
        Standing::Explained => {
            root.draw(&PathElement::new(
                vec![(from.0, to.1 - 2), (to.0, to.1 - 2)],
                OKABE_ITO[2].stroke_width(3),
            ))?;
        }
        Standing::Differs => {
            root.draw(&PathElement::new(vec![from, to], INK))?;
            root.draw(&PathElement::new(vec![(from.0, to.1), (to.0, from.1)], INK))?;
        }
        Standing::Reference => root.draw(&Rectangle::new([from, to], INK))?,
        Standing::Agrees | Standing::Undecided => {}
    }
    Ok(())
}

const PANEL: (i32, i32) = (150, 104);
const ACROSS: usize = 6;

/// Histograms of p-values in equal bins of [0, 1], a small panel each, relative to a flat one.
///
/// # Errors
/// The file cannot be written.
pub fn histograms(path: &Path, title: &str, panels: &[(String, Vec<u64>)]) -> Result<(), Error> {
    let rows = panels.len().div_ceil(ACROSS).max(1) as i32;
    let size = [
        (ACROSS as i32 * PANEL.0 + 28) as u32,
        (rows * PANEL.1 + 76) as u32,
    ];
    write_svg(path, size, |root| {
        let text = |size: i32, h| {
            (FONT, size, &INK)
                .into_text_style(root)
                .pos(Pos::new(h, VPos::Center))
        };
        root.draw(&Text::new(title, (14, 16), text(16, HPos::Left)))?;
        for (i, (name, counts)) in panels.iter().enumerate() {
            let x = 14 + (i % ACROSS) as i32 * PANEL.0;
            let y = 36 + (i / ACROSS) as i32 * PANEL.1;
            let (left, right, base, top) = (x + 6, x + PANEL.0 - 12, y + 92, y + 22);
            root.draw(&Text::new(
                name.as_str(),
                (left, y + 10),
                text(12, HPos::Left),
            ))?;
            let flat = counts.iter().sum::<u64>() as f64 / counts.len().max(1) as f64;
            // A flat histogram reaches half of the height.
            let scale = 0.5 * f64::from(base - top) / flat.max(1.0);
            let bin = f64::from(right - left) / counts.len().max(1) as f64;
            for (k, &count) in counts.iter().enumerate() {
                let height = (count as f64 * scale).min(f64::from(base - top));
                let corners = [
                    (left + (k as f64 * bin) as i32, base - height as i32),
                    (left + ((k + 1) as f64 * bin) as i32 - 1, base),
                ];
                root.draw(&Rectangle::new(corners, OKABE_ITO[2].mix(0.7).filled()))?;
            }
            let level = (base + top) / 2;
            root.draw(&PathElement::new(
                vec![(left, level), (right, level)],
                OKABE_ITO[0],
            ))?;
            root.draw(&PathElement::new(vec![(left, base), (right, base)], INK))?;
        }
        let foot = size[1] as i32 - 16;
        let note = "p from 0 (left) to 1 (right); the line is a flat histogram";
        root.draw(&Text::new(note, (14, foot), text(13, HPos::Left)))?;
        Ok(())
    })
}
