//! Panels of a figure: position, title, and axes with labels and a grid.

use super::axis::{Axis, Scale};
use super::*;

/// Room left of the plotted area, and above it, pixels.
pub(super) const LEFT: f64 = 84.0;
pub(super) const TOP: f64 = 38.0;

/// Returns a page of `size` pixels for panels with these titles, in rows of `columns`, and the
/// areas of the panels.
pub(super) fn page(
    description: &str,
    size: [u32; 2],
    columns: usize,
    titles: &[&str],
) -> (Canvas, Vec<Area>) {
    let size = size.map(f64::from);
    (
        Canvas::new(size, &titles.join("; "), description),
        areas(size, columns, titles.len()),
    )
}

/// Divides a drawing into equal areas, row by row.
pub(super) fn areas([width, height]: Point, columns: usize, count: usize) -> Vec<Area> {
    let rows = count.div_ceil(columns).max(1);
    let [w, h] = [width / columns as f64, height / rows as f64];
    let corner = |i: usize| [(i % columns) as f64 * w, (i / columns) as f64 * h];
    (0..count)
        .map(corner)
        .map(|[x, y]| [x, y, x + w, y + h])
        .collect()
}

/// Returns the axes along the lower and the left side of the plotted area.
pub(super) fn axes(plot: Area, [x, y]: [[f64; 2]; 2], divisions: [Scale; 2]) -> [Axis; 2] {
    let [left, top, right, bottom] = plot;
    [
        Axis::new(x, divisions[0], [left, right]),
        Axis::new(y, divisions[1], [bottom, top]),
    ]
}

/// Draws the title of a panel, centred over its plot.
pub(super) fn heading(canvas: &mut Canvas, [left, _, right, _]: Area, top: f64, title: &str) {
    canvas.text(
        title,
        [0.5 * (left + right), top + 19.0],
        Anchor::Center,
        HEADING,
    );
}

/// Draws the axes with their labels, and a grid.
pub(super) fn frame(
    canvas: &mut Canvas,
    [left, top, right, bottom]: Area,
    [x, y]: [&Axis; 2],
    [across, up]: &[String; 2],
) {
    let grid = Pen::new(FAINT, 1.0);
    let axis = Pen::new(INK, 1.2);
    for &tick in &x.ticks {
        let at = x.at(tick);
        canvas.line(&[[at, top], [at, bottom]], grid);
        canvas.line(&[[at, bottom], [at, bottom + 5.0]], axis);
        canvas.text(&x.label(tick), [at, bottom + 15.0], Anchor::Center, LABEL);
    }
    for &tick in &y.ticks {
        let at = y.at(tick);
        canvas.line(&[[left, at], [right, at]], grid);
        canvas.line(&[[left - 5.0, at], [left, at]], axis);
        canvas.text(&y.label(tick), [left - 9.0, at], Anchor::Right, LABEL);
    }
    canvas.line(&[[left, top], [left, bottom], [right, bottom]], axis);
    let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
    canvas.text(across, [middle[0], bottom + 39.0], Anchor::Center, LABEL);
    canvas.rotated_text(up, [left - 66.0, middle[1]], Anchor::Center, LABEL, -90);
}
