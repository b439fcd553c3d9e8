//! The look of all plots: SVG, one typeface, colours that colour-blind readers can tell apart.

pub mod agreement;
pub mod chart;
pub mod forest;
pub mod map;
pub mod matrix;

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use whitefurnace::error::Error;

use crate::lab::write_text;

/// Colours of Okabe and Ito, which colour-blind readers can tell apart: vermilion, bluish green, blue,
/// reddish purple, orange, sky blue, black; and a grey.
const OKABE_ITO: [RGBColor; 8] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(0, 114, 178),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(130, 130, 130),
];
/// For the channels red, green and blue.
const RGB: [RGBColor; 3] = [OKABE_ITO[0], OKABE_ITO[1], OKABE_ITO[2]];
const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(215, 215, 215);
const FONT: &str = "sans-serif";

/// One panel per title: for each region, a difference of each channel.
///
/// # Errors
/// The file cannot be written.
pub fn differences(
    path: &Path,
    regions: &[&str],
    axis: &str,
    panels: &[(&str, Vec<[f64; 3]>)],
) -> Result<(), Error> {
    write_svg(path, [960, 840], |root| {
        draw_differences(root, regions, axis, panels)
    })
}

/// What may go wrong in drawing.
type Fault = Box<dyn std::error::Error>;
/// What drawing may end with.
type Drawn = Result<(), Fault>;

/// Writes an SVG of this size in pixels on a white ground.
fn write_svg(
    path: &Path,
    size: [u32; 2],
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawn,
) -> Result<(), Error> {
    write_text(path, &svg(path, size, draw)?)
}

/// The text of such an SVG; `path` is for the message.
fn svg(
    path: &Path,
    [width, height]: [u32; 2],
    draw: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Drawn,
) -> Result<String, Error> {
    let mut svg = String::new();
    let drawn = || -> Drawn {
        let root = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
        Ok(())
    };
    drawn().map_err(|error| Error::Image {
        action: "write",
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    Ok(svg)
}

fn draw_differences(
    root: &DrawingArea<SVGBackend<'_>, Shift>,
    regions: &[&str],
    axis: &str,
    panels: &[(&str, Vec<[f64; 3]>)],
) -> Drawn {
    for (area, (title, rows)) in root.split_evenly((panels.len(), 1)).iter().zip(panels) {
        let largest = rows
            .iter()
            .flatten()
            .fold(3.0f64, |largest, d| largest.max(d.abs()))
            * 1.15;
        let mut chart = ChartBuilder::on(area)
            .caption(*title, (FONT, 20, &INK))
            .margin(10)
            .x_label_area_size(28)
            .y_label_area_size(70)
            .build_cartesian_2d(-0.5..regions.len() as f64 - 0.5, -largest..largest)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .axis_style(INK)
            .label_style((FONT, 15, &INK))
            .x_labels(regions.len())
            .x_label_formatter(&|x| {
                let index = x.round();
                if (x - index).abs() > 1e-6 || index < 0.0 {
                    return String::new();
                }
                regions
                    .get(index as usize)
                    .map_or_else(String::new, ToString::to_string)
            })
            .y_labels(5)
            .y_label_formatter(&|y| format!("{y:+.0}"))
            .y_desc(axis)
            .draw()?;
        chart.draw_series(LineSeries::new(
            [(-0.5, 0.0), (regions.len() as f64 - 0.5, 0.0)],
            INK,
        ))?;
        for (channel, colour) in RGB.into_iter().enumerate() {
            let offset = (channel as f64 - 1.0) * 0.18;
            let points = rows
                .iter()
                .enumerate()
                .map(|(i, row)| (i as f64 + offset, row[channel]));
            let series =
                chart.draw_series(points.map(|point| Circle::new(point, 5, colour.filled())))?;
            series
                .label(["red", "green", "blue"][channel])
                .legend(move |(x, y)| Circle::new((x + 8, y), 5, colour.filled()));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .background_style(WHITE.mix(0.85))
            .border_style(FAINT)
            .label_font((FONT, 15, &INK))
            .draw()?;
    }
    Ok(())
}
