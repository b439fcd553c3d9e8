//! Plots of the agreement matrix, and of the histograms of p-values behind it.

use super::*;

/// Result shown in a cell of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Agreement {
    /// Within the margin of methods without bias.
    Agrees,
    /// Within the wider margin of a bias of known cause.
    Biased,
    /// Different by the amount that the stated cause predicts.
    Explained,
    /// Too few samples to say.
    Undecided,
    /// Outside the margin without an explanation.
    Differs,
    /// The reference of the scene.
    Reference,
}

/// A cell of the matrix.
#[derive(Clone, Debug)]
pub struct MatrixCell {
    /// The number, such as "+0.02 ± 0.10 %"; lines end with line feeds.
    pub text: String,
    /// Result, shown by colour and border.
    pub agreement: Agreement,
}

const CELL: [f64; 2] = [138.0, 44.0];
/// Line spacing in a cell, pixels.
const LINE: f64 = 17.0;
const LEFT: f64 = 100.0;

/// Draws rows × columns. A cell that is `None` is struck through; the legend explains it by
/// `blank`.
pub fn agreement_matrix(
    path: &Path,
    title: &str,
    description: &str,
    rows: &[String],
    columns: &[String],
    blank: &str,
    matrix_cell: impl Fn(usize, usize) -> Option<MatrixCell>,
) -> Result<(), Error> {
    let right = LEFT + columns.len() as f64 * CELL[0] + 14.0;
    let right = right.max(width(title, TITLE) + 28.0);
    let entries = legend(right, blank);
    let above = entries.iter().map(|(_, _, [_, y])| y + 58.0);
    let above = above.fold(0.0, f64::max);
    let mut canvas = Canvas::new(
        [right, above + rows.len() as f64 * CELL[1] + 14.0],
        title,
        description,
    );
    canvas.text(title, [14.0, 20.0], Anchor::Left, TITLE);
    for (agreement, label, [x, y]) in entries {
        cell(&mut canvas, [x, y, x + 26.0, y + 18.0], agreement);
        canvas.text(label, [x + 32.0, y + 9.0], Anchor::Left, 13.0);
    }
    for (c, name) in columns.iter().enumerate() {
        canvas.text(
            name,
            [LEFT + (c as f64 + 0.5) * CELL[0], above - 12.0],
            Anchor::Center,
            LABEL,
        );
    }
    for (r, name) in rows.iter().enumerate() {
        let y = above + r as f64 * CELL[1];
        let middle = y + 0.5 * CELL[1];
        canvas.text(name, [LEFT - 8.0, middle], Anchor::Right, LABEL);
        for c in 0..columns.len() {
            let x = LEFT + c as f64 * CELL[0];
            let frame = [x, y, x + CELL[0], y + CELL[1]];
            let matrix_cell = matrix_cell(r, c);
            cell(
                &mut canvas,
                frame,
                matrix_cell.as_ref().map(|s| s.agreement),
            );
            if let Some(matrix_cell) = matrix_cell {
                let count = matrix_cell.text.lines().count() as f64;
                for (i, line) in matrix_cell.text.lines().enumerate() {
                    let down = LINE * (i as f64 + 0.5 * (1.0 - count));
                    canvas.text(
                        line,
                        [x + 0.5 * CELL[0], middle + down],
                        Anchor::Center,
                        13.0,
                    );
                }
            }
        }
    }
    canvas.write(path)
}

/// An entry of the legend and its upper left corner.
type Entry<'a> = (Option<Agreement>, &'a str, Point);

/// Lays out the legend in as many lines as it takes to end before `right`.
fn legend(right: f64, blank: &str) -> [Entry<'_>; 7] {
    let entries = [
        (Some(Agreement::Reference), "reference"),
        (Some(Agreement::Agrees), "agrees within the margin"),
        (Some(Agreement::Biased), "within the margin of a known bias"),
        (Some(Agreement::Explained), "differs for a stated reason"),
        (Some(Agreement::Undecided), "undecided"),
        (Some(Agreement::Differs), "differs"),
        (None, blank),
    ];
    let [mut x, mut y] = [14.0, 38.0];
    entries.map(|(agreement, label)| {
        let length = 34.0 + width(label, 13.0) + 14.0;
        if x + length > right {
            [x, y] = [14.0, y + 24.0];
        }
        let corner = [x, y];
        x += length;
        (agreement, label, corner)
    })
}

/// Draws a cell's fill and border, which can be told apart without colour.
fn cell(canvas: &mut Canvas, frame: Area, agreement: Option<Agreement>) {
    let [left, top, right, bottom] = frame;
    let fill = match agreement {
        Some(Agreement::Agrees) => tint(OKABE_ITO[1], 0.35),
        Some(Agreement::Biased | Agreement::Explained) => tint(OKABE_ITO[5], 0.35),
        Some(Agreement::Undecided) => tint(FAINT, 0.6),
        Some(Agreement::Differs) => tint(OKABE_ITO[0], 0.6),
        Some(Agreement::Reference) | None => Rgb(255, 255, 255),
    };
    canvas.fill([left + 1.0, top + 1.0, right - 1.0, bottom - 1.0], fill);
    canvas.frame(frame, Pen::new(FAINT, 1.0));
    let inner = [left + 2.0, top + 2.0, right - 2.0, bottom - 2.0];
    let under = [[left + 1.0, bottom - 2.5], [right - 1.0, bottom - 2.5]];
    let blue = Pen::new(OKABE_ITO[2], 3.0);
    match agreement {
        Some(Agreement::Agrees) => {}
        Some(Agreement::Biased) => canvas.line(
            &under,
            Pen {
                dash: &[6.0, 4.0],
                ..blue
            },
        ),
        Some(Agreement::Explained) => canvas.line(&under, blue),
        Some(Agreement::Undecided) => {
            canvas.frame(
                inner,
                Pen {
                    dash: &[2.0, 3.0],
                    ..Pen::new(Rgb(120, 120, 120), 1.0)
                },
            );
        }
        Some(Agreement::Differs) => canvas.frame(inner, Pen::new(OKABE_ITO[0], 3.0)),
        Some(Agreement::Reference) => canvas.frame(inner, Pen::new(INK, 1.4)),
        None => canvas.line(
            &[[left, bottom], [right, top]],
            Pen::new(Rgb(190, 190, 190), 1.0),
        ),
    }
}

const PANEL: [f64; 2] = [178.0, 108.0];
const COLUMNS: usize = 5;

/// Draws histograms of p-values in equal bins of [0, 1], a small panel each, relative to a uniform
/// one.
pub fn histograms(
    path: &Path,
    title: &str,
    description: &str,
    panels: &[(String, Vec<u64>)],
) -> Result<(), Error> {
    let rows = panels.len().div_ceil(COLUMNS).max(1);
    let mut canvas = Canvas::new(
        [
            COLUMNS as f64 * PANEL[0] + 20.0,
            rows as f64 * PANEL[1] + 72.0,
        ],
        title,
        description,
    );
    canvas.text(title, [14.0, 20.0], Anchor::Left, TITLE);
    let note =
        "p from 0 (left) to 1 (right); the line is a flat histogram; an arrowhead: the bar goes on";
    canvas.text(note, [14.0, 44.0], Anchor::Left, 13.0);
    for (i, (name, counts)) in panels.iter().enumerate() {
        let corner = [
            14.0 + (i % COLUMNS) as f64 * PANEL[0],
            62.0 + (i / COLUMNS) as f64 * PANEL[1],
        ];
        histogram(&mut canvas, corner, name, counts);
    }
    canvas.write(path)
}

fn histogram(canvas: &mut Canvas, [x, y]: [f64; 2], name: &str, counts: &[u64]) {
    let (right, base, top) = (x + PANEL[0] - 16.0, y + 94.0, y + 22.0);
    canvas.text(name, [x, y + 8.0], Anchor::Left, 12.0);
    let flat = counts.iter().sum::<u64>() as f64 / counts.len().max(1) as f64;
    // A uniform histogram reaches half of the height.
    let scale = 0.5 * (base - top) / flat.max(1.0);
    let bin = (right - x) / counts.len().max(1) as f64;
    for (k, &count) in counts.iter().enumerate() {
        let height = count as f64 * scale;
        let left = x + k as f64 * bin;
        canvas.fill(
            [left, base - height.min(base - top), left + bin - 1.0, base],
            tint(OKABE_ITO[2], 0.7),
        );
        if height > base - top {
            canvas.marks(
                &[[left + 0.5 * (bin - 1.0), top - 4.0]],
                Shape::Triangle,
                3.6,
                OKABE_ITO[2],
            );
        }
    }
    let level = 0.5 * (base + top);
    canvas.line(&[[x, level], [right, level]], Pen::new(OKABE_ITO[0], 1.2));
    canvas.line(&[[x, base], [right, base]], Pen::new(INK, 1.2));
}
