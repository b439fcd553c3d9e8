//! Plots differences of regions, channel by channel, in panels on one scale.

use super::axis::Scale;
use super::panel::{LEFT, areas, axes, frame, heading};
use super::*;

/// A title, and the differences of red, green and blue for each region.
pub type Panel<'a> = (&'a str, Vec<[f64; 3]>);

/// Settings shared by all panels.
pub struct PanelSettings<'a> {
    /// Regions, and the largest absolute difference allowed in each: the band.
    pub regions: &'a [(&'a str, f64)],
    /// Label of the axis, with its unit.
    pub axis: &'a str,
    /// Name of the band in the legend.
    pub band: &'a str,
}

const CHANNELS: [(&str, Rgb, Shape); 3] = [
    ("red", OKABE_ITO[0], Shape::Disc),
    ("green", OKABE_ITO[1], Shape::Square),
    ("blue", OKABE_ITO[2], Shape::Triangle),
];
const BAND: Rgb = Rgb(224, 232, 240);
const RADIUS: f64 = 4.6;

/// Draws the panels one below the other, all on one scale: linear about zero, logarithmic farther
/// from it.
pub fn differences(
    path: &Path,
    title: &str,
    description: &str,
    common: &PanelSettings<'_>,
    panels: &[Panel<'_>],
) -> Result<(), Error> {
    let size = [900.0, 46.0 + 280.0 * panels.len() as f64];
    let mut canvas = Canvas::new(size, title, description);
    legend(&mut canvas, common.band);
    let largest = panels
        .iter()
        .flat_map(|(_, rows)| rows)
        .flatten()
        .fold(10.0f64, |largest, d| largest.max(d.abs()));
    for (area, panel) in areas([size[0], size[1] - 46.0], 1, panels.len())
        .into_iter()
        .zip(panels)
    {
        let [left, top, right, bottom] = area;
        draw(
            &mut canvas,
            [left, top + 46.0, right, bottom + 46.0],
            common,
            panel,
            1.4 * largest,
        );
    }
    canvas.write(path)
}

fn legend(canvas: &mut Canvas, band: &str) {
    let mut x = LEFT;
    for (name, colour, shape) in CHANNELS {
        canvas.marks(&[[x, 24.0]], shape, RADIUS, colour);
        canvas.text(name, [x + 12.0, 24.0], Anchor::Left, LABEL);
        x += 84.0;
    }
    canvas.fill([x, 15.0, x + 26.0, 33.0], BAND);
    canvas.text(band, [x + 34.0, 24.0], Anchor::Left, LABEL);
}

fn draw(canvas: &mut Canvas, area: Area, common: &PanelSettings<'_>, panel: &Panel<'_>, most: f64) {
    let [left, top, right, bottom] = area;
    let plot = [left + LEFT, top + 34.0, right - 16.0, bottom - 44.0];
    let step = (plot[2] - plot[0]) / common.regions.len() as f64;
    let middle = |i: usize| plot[0] + (i as f64 + 0.5) * step;
    let [mut x, y] = axes(
        plot,
        [[0.0, 1.0], [-most, most]],
        [Scale::Linear, Scale::Signed],
    );
    for (i, &(_, allowed)) in common.regions.iter().enumerate() {
        let [from, to] = [-0.5, 0.5].map(|half| middle(i) + half * step);
        canvas.fill([from, y.at(allowed), to, y.at(-allowed)], BAND);
    }
    // The horizontal axis has the regions' names for labels.
    x.ticks.clear();
    frame(
        canvas,
        plot,
        [&x, &y],
        &[String::new(), common.axis.to_owned()],
    );
    canvas.line(
        &[[plot[0], y.at(0.0)], [plot[2], y.at(0.0)]],
        Pen::new(INK, 1.2),
    );
    for i in 1..common.regions.len() {
        let at = middle(i) - 0.5 * step;
        canvas.line(&[[at, plot[1]], [at, plot[3]]], Pen::new(FAINT, 1.0));
    }
    for (i, (name, _)) in common.regions.iter().enumerate() {
        let lines = name.rsplit_once(' ').unwrap_or((name, ""));
        for (line, down) in [(lines.0, 14.0), (lines.1, 29.0)] {
            canvas.text(line, [middle(i), plot[3] + down], Anchor::Center, 13.0);
        }
    }
    let (title, rows) = panel;
    for (c, (_, colour, shape)) in CHANNELS.into_iter().enumerate() {
        let place = |(i, row): (usize, &[f64; 3])| {
            [middle(i) + (c as f64 - 1.0) * 0.22 * step, y.at(row[c])]
        };
        let points: Vec<[f64; 2]> = rows.iter().enumerate().map(place).collect();
        canvas.marks(&points, shape, RADIUS, colour);
    }
    heading(canvas, plot, top, title);
}
