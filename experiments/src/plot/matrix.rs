//! A matrix of results: which trial rejects which fault.

use super::*;

/// Result of a trial under a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detection {
    /// The trial rejects the fault.
    Rejected,
    /// The trial holds although the fault is there.
    Missed,
    /// Too few samples to say.
    Undecided,
}

impl Detection {
    /// All results.
    pub const ALL: [Self; 3] = [Self::Rejected, Self::Missed, Self::Undecided];

    /// Returns the word in the legend.
    pub fn word(self) -> &'static str {
        match self {
            Self::Rejected => "rejected",
            Self::Missed => "not rejected",
            Self::Undecided => "undecided",
        }
    }
}

const CELL: f64 = 17.0;
/// Font size of the names of rows and columns, pixels.
const NAME_SIZE: f64 = 13.0;

/// Draws rows × columns; pairs that were not tried stay empty. Neighbours in a row with the same
/// result are drawn as one.
pub fn matrix(
    path: &Path,
    title: &str,
    description: &str,
    rows: &[String],
    columns: &[String],
    seen: impl Fn(usize, usize) -> Option<Detection>,
) -> Result<(), Error> {
    let longest = |names: &[String]| {
        names
            .iter()
            .map(|name| width(name, NAME_SIZE))
            .fold(0.0, f64::max)
    };
    let (left, top) = (longest(rows) + 26.0, longest(columns) + 84.0);
    let [across, down] = [columns, rows].map(|names| names.len() as f64 * CELL);
    let least = width(title, TITLE).max(560.0);
    let mut canvas = Canvas::new(
        [(left + across).max(least) + 20.0, top + down + 16.0],
        title,
        description,
    );
    canvas.text(title, [14.0, 20.0], Anchor::Left, TITLE);
    let mut x = 14.0;
    for seen in Detection::ALL.map(Some).into_iter().chain([None]) {
        let label = seen.map_or("not tried", Detection::word);
        let at = [x, 40.0];
        canvas.frame([x, 40.0, x + CELL, 40.0 + CELL], Pen::new(FAINT, 1.0));
        if let Some(seen) = seen {
            cells(&mut canvas, at, 1, seen);
        }
        canvas.text(
            label,
            [x + CELL + 8.0, 40.0 + 0.5 * CELL],
            Anchor::Left,
            LABEL,
        );
        x += CELL + 32.0 + width(label, LABEL);
    }
    let faint = Pen::new(FAINT, 1.0);
    for (c, name) in columns.iter().enumerate() {
        let x = left + c as f64 * CELL;
        canvas.rotated_text(
            name,
            [x + 0.5 * CELL, top - 6.0],
            Anchor::Left,
            NAME_SIZE,
            -90,
        );
        canvas.line(&[[x, top], [x, top + down]], faint);
    }
    for (r, name) in rows.iter().enumerate() {
        let y = top + r as f64 * CELL;
        canvas.text(name, [left - 8.0, y + 0.5 * CELL], Anchor::Right, NAME_SIZE);
        canvas.line(&[[left, y], [left + across, y]], faint);
        let verdicts: Vec<Option<Detection>> = (0..columns.len()).map(|c| seen(r, c)).collect();
        let mut x = left;
        for run in verdicts.chunk_by(|a, b| a == b) {
            if let Some(seen) = run[0] {
                cells(&mut canvas, [x, y], run.len(), seen);
            }
            x += run.len() as f64 * CELL;
        }
    }
    canvas.frame([left, top, left + across, top + down], faint);
    canvas.write(path)
}

/// Draws cells, dark, pale with a cross, or grey, so that they can be told apart without colour.
fn cells(canvas: &mut Canvas, [x, y]: [f64; 2], count: usize, seen: Detection) {
    let right = x + count as f64 * CELL;
    let colour = match seen {
        Detection::Rejected => OKABE_ITO[2],
        Detection::Missed => tint(OKABE_ITO[4], 0.6),
        Detection::Undecided => FAINT,
    };
    canvas.fill([x + 1.0, y + 1.0, right - 1.0, y + CELL - 1.0], colour);
    if seen == Detection::Missed {
        let at: Vec<[f64; 2]> = (0..count)
            .map(|i| [x + (i as f64 + 0.5) * CELL, y + 0.5 * CELL])
            .collect();
        canvas.marks(&at, Shape::Cross, 3.2, Rgb(90, 60, 0));
    }
}
