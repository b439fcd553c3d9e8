//! The look of all plots: SVG, one typeface, colours that colour-blind readers can tell apart.

use std::path::Path;

use plotters::prelude::*;
use whitefurnace::error::Error;

use crate::lab::write_text;

/// Colours of Okabe and Ito: vermilion, bluish green, blue.
const RGB: [RGBColor; 3] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(0, 114, 178),
];
const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(215, 215, 215);
const FONT: &str = "sans-serif";

/// One panel per convention: for each region, how far each channel is from the published image.
///
/// # Errors
/// The file cannot be written.
pub fn differences(
    path: &Path,
    regions: &[&str],
    panels: &[(&str, Vec<[f64; 3]>)],
) -> Result<(), Error> {
    let mut svg = String::new();
    draw_differences(&mut svg, regions, panels).map_err(|error| Error::Image {
        action: "write",
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    write_text(path, &svg)
}

fn draw_differences(
    svg: &mut String,
    regions: &[&str],
    panels: &[(&str, Vec<[f64; 3]>)],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(svg, (960, 840)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, (title, rows)) in root.split_evenly((panels.len(), 1)).iter().zip(panels) {
        let largest = rows
            .iter()
            .flatten()
            .fold(3.0f64, |largest, d| largest.max(d.abs()))
            * 1.15;
        let mut chart = ChartBuilder::on(area)
            .caption(format!("convention {title}"), (FONT, 18, &INK))
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
            .label_style((FONT, 13, &INK))
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
            .y_desc("rendered − published (grey levels)")
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
            .label_font((FONT, 13, &INK))
            .draw()?;
    }
    root.present()?;
    Ok(())
}
