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

const CELL: i32 = 17;
const LEFT: i32 = 270;

/// Draws rows × columns; pairs that were not tried stay empty.
///
/// # Errors
/// The file cannot be written.
pub fn matrix(
    path: &Path,
    rows: &[String],
    columns: &[String],
    seen: impl Fn(usize, usize) -> Option<Seen>,
) -> Result<(), Error> {
    let longest = columns
        .iter()
        .map(|name| name.chars().count())
        .max()
        .unwrap_or(0) as i32;
    let top = 60 + 7 * longest;
    let [width, height] = [columns.len() as i32 * CELL, rows.len() as i32 * CELL];
    let size = [
        (LEFT + width.max(240) + 20) as u32,
        (top + height + 20) as u32,
    ];
    write_svg(path, size, |root| {
        let text = |h| {
            (FONT, 13, &INK)
                .into_text_style(root)
                .pos(Pos::new(h, VPos::Center))
        };
        let legend = [Seen::Rejected, Seen::Missed, Seen::Undecided];
        for (i, seen) in legend.into_iter().enumerate() {
            let at = (14 + 165 * i as i32, 14);
            draw_cell(root, at, seen)?;
            let label = ["rejected", "not rejected", "undecided"][i];
            root.draw(&Text::new(
                label,
                (at.0 + CELL + 8, at.1 + CELL / 2),
                text(HPos::Left),
            ))?;
        }
        for (c, name) in columns.iter().enumerate() {
            let upright = text(HPos::Left).transform(FontTransform::Rotate270);
            let at = (LEFT + c as i32 * CELL + CELL / 2, top - 6);
            root.draw(&Text::new(name.as_str(), at, upright))?;
        }
        for (r, name) in rows.iter().enumerate() {
            let y = top + r as i32 * CELL;
            root.draw(&Text::new(
                name.as_str(),
                (LEFT - 8, y + CELL / 2),
                text(HPos::Right),
            ))?;
            for c in 0..columns.len() {
                let at = (LEFT + c as i32 * CELL, y);
                root.draw(&Rectangle::new([at, (at.0 + CELL, at.1 + CELL)], FAINT))?;
                if let Some(seen) = seen(r, c) {
                    draw_cell(root, at, seen)?;
                }
            }
        }
        Ok(())
    })
}

/// Filled with a cross, framed, or hatched: to be told apart without colour, too.
fn draw_cell(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    (x, y): (i32, i32),
    seen: Seen,
) -> super::Drawn {
    let corners = [(x + 1, y + 1), (x + CELL - 1, y + CELL - 1)];
    match seen {
        Seen::Rejected => root.draw(&Rectangle::new(corners, OKABE_ITO[2].filled()))?,
        Seen::Missed => {
            root.draw(&Rectangle::new(corners, OKABE_ITO[4].filled()))?;
            root.draw(&Cross::new((x + CELL / 2, y + CELL / 2), 4, INK))?;
        }
        Seen::Undecided => {
            root.draw(&Rectangle::new(corners, FAINT.filled()))?;
            root.draw(&Circle::new((x + CELL / 2, y + CELL / 2), 2, INK.filled()))?;
        }
    }
    Ok(())
}
