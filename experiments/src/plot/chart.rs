//! A plain chart: lines, points and error bars over linear or logarithmic axes.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use whitefurnace::error::Error;

use super::{Drawn, FAINT, FONT, INK, OKABE_ITO, write_svg};

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// Discs.
    Points,
    /// Thin grey lines, for context.
    Faint,
}

/// Points with a name.
#[derive(Clone, Debug)]
pub struct Series {
    /// For the legend; empty for none.
    pub label: String,
    /// Index into the palette.
    pub colour: usize,
    /// How it is drawn.
    pub mark: Mark,
    /// x and y.
    pub points: Vec<[f64; 2]>,
    /// Low and high end of each point's error bar; empty for none.
    pub bars: Vec<[f64; 2]>,
}

impl Series {
    /// A series without error bars.
    pub fn new(label: &str, colour: usize, mark: Mark, points: Vec<[f64; 2]>) -> Self {
        Self {
            label: label.to_owned(),
            colour,
            mark,
            points,
            bars: Vec::new(),
        }
    }
}

/// A chart; several are drawn one below the other.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// Labels of the axes, with units.
    pub axes: [String; 2],
    /// Ranges of the axes, before the logarithm.
    pub ranges: [[f64; 2]; 2],
    /// Which axes are logarithmic.
    pub log: [bool; 2],
    /// What is drawn, in this order.
    pub series: Vec<Series>,
    /// Where the legend stands.
    pub legend: Corner,
}

/// A corner of the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Top left.
    UpperLeft,
    /// Bottom left.
    LowerLeft,
    /// Bottom right.
    LowerRight,
    /// Top right.
    UpperRight,
}

/// Draws charts, one below the other, `size` in pixels for all together.
///
/// # Errors
/// The file cannot be written.
pub fn charts(path: &Path, size: [u32; 2], charts: &[Chart]) -> Result<(), Error> {
    write_svg(path, size, |root| {
        let areas = root.split_evenly((charts.len().max(1), 1));
        areas
            .iter()
            .zip(charts)
            .try_for_each(|(area, chart)| draw(area, chart))
    })
}

fn draw(area: &DrawingArea<SVGBackend<'_>, Shift>, chart: &Chart) -> Drawn {
    let scale = |axis: usize, value: f64| {
        if chart.log[axis] {
            value.max(f64::MIN_POSITIVE).log10()
        } else {
            value
        }
    };
    let point = |[x, y]: [f64; 2]| (scale(0, x), scale(1, y));
    let range = |axis: usize| {
        let [low, high] = chart.ranges[axis];
        scale(axis, low)..scale(axis, high)
    };
    let mut context = ChartBuilder::on(area)
        .caption(&chart.title, (FONT, 17, &INK))
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(74)
        .build_cartesian_2d(range(0), range(1))?;
    let label = |log: bool| {
        move |value: &f64| {
            if log {
                if (value - value.round()).abs() < 1e-6 {
                    format!("1e{value:.0}")
                } else {
                    String::new()
                }
            } else {
                plain(*value)
            }
        }
    };
    context
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT)
        .axis_style(INK)
        .label_style((FONT, 13, &INK))
        .x_desc(&chart.axes[0])
        .y_desc(&chart.axes[1])
        .x_label_formatter(&label(chart.log[0]))
        .y_label_formatter(&label(chart.log[1]))
        .draw()?;
    for series in &chart.series {
        let colour = OKABE_ITO[series.colour % OKABE_ITO.len()];
        let points = series.points.iter().copied().map(point);
        let drawn = match series.mark {
            Mark::Line => context.draw_series(LineSeries::new(points, colour.stroke_width(2)))?,
            Mark::Faint => {
                context.draw_series(LineSeries::new(points, RGBColor(150, 150, 150).mix(0.6)))?
            }
            Mark::Points => {
                context.draw_series(points.map(|point| Circle::new(point, 4, colour.filled())))?
            }
        };
        if !series.label.is_empty() {
            let mark = series.mark;
            drawn.label(&series.label).legend(move |(x, y)| match mark {
                Mark::Line => Rectangle::new([(x, y - 1), (x + 16, y + 1)], colour.filled()),
                Mark::Faint => {
                    Rectangle::new([(x, y), (x + 16, y + 1)], RGBColor(150, 150, 150).filled())
                }
                Mark::Points => Rectangle::new([(x + 4, y - 4), (x + 12, y + 4)], colour.filled()),
            });
        }
        let bars = series.points.iter().zip(&series.bars);
        context.draw_series(bars.map(|(&[x, _], &[low, high])| {
            PathElement::new(
                vec![point([x, low]), point([x, high])],
                colour.stroke_width(2),
            )
        }))?;
    }
    if chart.series.iter().any(|series| !series.label.is_empty()) {
        let position = match chart.legend {
            Corner::UpperLeft => SeriesLabelPosition::UpperLeft,
            Corner::LowerLeft => SeriesLabelPosition::LowerLeft,
            Corner::LowerRight => SeriesLabelPosition::LowerRight,
            Corner::UpperRight => SeriesLabelPosition::UpperRight,
        };
        context
            .configure_series_labels()
            .position(position)
            .background_style(WHITE.mix(0.85))
            .border_style(FAINT)
            .label_font((FONT, 13, &INK))
            .draw()?;
    }
    Ok(())
}

/// A label of a linear axis, without digits that say nothing.
fn plain(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    if rounded.abs() >= 1e5 {
        format!("{rounded:.0e}")
    } else {
        // Not "-0".
        format!("{}", rounded + 0.0)
    }
}
