//! A matrix of verdicts: which trial rejects which fault.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use whitefurnace::error::Error;

use super::{FAINT, FONT, INK, OKABE_ITO, write_svg};

/// What a cell says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The trial rejects the fault.
    Rejected,
    /// The trial holds although the fault is there.
    Missed,
    /// Too few samples to say.
    Undecided,
}

const CELL: i32 = 14;
/// Pixels per character of a label, about.
const CHARACTER: i32 = 6;

/// Draws rows × columns; pairs that were not tried stay empty. Neighbours in a row that say the same are
/// drawn as one.
///
/// # Errors
/// The file cannot be written.
pub fn matrix(
    path: &Path,
    rows: &[String],
    columns: &[String],
    seen: impl Fn(usize, usize) -> Option<Seen>,
) -> Result<(), Error> {
    let longest = |names: &[String]| {
        let lengths = names.iter().map(|name| name.chars().count());
        CHARACTER * lengths.max().unwrap_or(0) as i32
    };
    let (left, top) = (longest(rows) + 30, longest(columns) + 60);
    let [width, height] = [columns, rows].map(|names| names.len() as i32 * CELL);
    let size = [(left + width).max(520) + 20, top + height + 20].map(|n| n as u32);
    write_svg(path, size, |root| {
        let text = |h| {
            (FONT, 13, &INK)
                .into_text_style(root)
                .pos(Pos::new(h, VPos::Center))
        };
        let legend = [Seen::Rejected, Seen::Missed, Seen::Undecided];
        for (i, seen) in legend.into_iter().enumerate() {
            let at = (14 + 165 * i as i32, 14);
            draw_cells(root, at, 1, seen)?;
            let label = ["rejected", "not rejected", "undecided"][i];
            root.draw(&Text::new(
                label,
                (at.0 + CELL + 8, at.1 + CELL / 2),
                text(HPos::Left),
            ))?;
        }
        for (c, name) in columns.iter().enumerate() {
            let x = left + c as i32 * CELL;
            let upright = text(HPos::Left).transform(FontTransform::Rotate270);
            root.draw(&Text::new(name.as_str(), (x + CELL / 2, top - 6), upright))?;
            root.draw(&PathElement::new([(x, top), (x, top + height)], FAINT))?;
        }
        for (r, name) in rows.iter().enumerate() {
            let y = top + r as i32 * CELL;
            root.draw(&Text::new(
                name.as_str(),
                (left - 8, y + CELL / 2),
                text(HPos::Right),
            ))?;
            root.draw(&PathElement::new([(left, y), (left + width, y)], FAINT))?;
            let cells: Vec<Option<Seen>> = (0..columns.len()).map(|c| seen(r, c)).collect();
            let mut x = left;
            for run in cells.chunk_by(|a, b| a == b) {
                if let Some(seen) = run[0] {
                    draw_cells(root, (x, y), run.len() as i32, seen)?;
                }
                x += run.len() as i32 * CELL;
            }
        }
        Ok(())
    })
}

/// Dark, middling and pale: told apart by lightness alone, too.
fn draw_cells(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    (x, y): (i32, i32),
    count: i32,
    seen: Seen,
) -> super::Drawn {
    let corners = [(x + 1, y + 1), (x + count * CELL - 1, y + CELL - 1)];
    let colour = match seen {
        Seen::Rejected => OKABE_ITO[2],
        Seen::Missed => OKABE_ITO[4],
        Seen::Undecided => FAINT,
    };
    root.draw(&Rectangle::new(corners, colour.filled()))?;
    Ok(())
}
