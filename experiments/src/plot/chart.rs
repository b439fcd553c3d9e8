//! A plain chart: lines, points and error bars over linear or logarithmic axes.

use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
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
    /// Dots, for scatter.
    Dots,
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
    rows(path, size, 1, charts)
}

/// Draws charts in rows of `columns`, `size` in pixels for all together.
///
/// # Errors
/// The file cannot be written.
pub fn rows(path: &Path, size: [u32; 2], columns: usize, charts: &[Chart]) -> Result<(), Error> {
    write_svg(path, size, |root| {
        let areas = root.split_evenly((charts.len().div_ceil(columns).max(1), columns));
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
    let [x, y] = [0, 1].map(|axis| Axis::new(chart.ranges[axis], chart.log[axis]));
    let within = |&(a, b): &(f64, f64)| x.reaches(a) && y.reaches(b);
    let mut context = ChartBuilder::on(area)
        .caption(&chart.title, (FONT, 20, &INK))
        .margin(12)
        .margin_right(28)
        .x_label_area_size(52)
        .y_label_area_size(80)
        .build_cartesian_2d(x.clone(), y.clone())?;
    context
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT)
        .axis_style(INK)
        .label_style((FONT, 15, &INK))
        .x_desc(&chart.axes[0])
        .y_desc(&chart.axes[1])
        .draw()?;
    for series in &chart.series {
        let colour = match series.mark {
            Mark::Faint => RGBColor(150, 150, 150),
            _ => OKABE_ITO[series.colour % OKABE_ITO.len()],
        };
        let width = if series.mark == Mark::Faint { 1 } else { 2 };
        let points: Vec<(f64, f64)> = series.points.iter().copied().map(point).collect();
        match series.mark {
            Mark::Line | Mark::Faint => {
                let lines = runs(&points, [x.ends, y.ends]).into_iter();
                context.draw_series(
                    lines.map(|line| PathElement::new(line, colour.stroke_width(width))),
                )?
            }
            Mark::Points | Mark::Dots => {
                let radius = if series.mark == Mark::Dots { 1 } else { 4 };
                let seen = points.iter().copied().filter(within);
                context.draw_series(seen.map(|at| Circle::new(at, radius, colour.filled())))?
            }
        };
        let bars = points.iter().zip(&series.bars);
        let bars = bars.filter(|(at, _)| x.reaches(at.0));
        context.draw_series(bars.flat_map(|(at, &[low, high])| {
            let ends = [(at.0, scale(1, low)), (at.0, scale(1, high))];
            runs(&ends, [x.ends, y.ends])
                .into_iter()
                .map(|bar| PathElement::new(bar, colour.stroke_width(2)))
        }))?;
        if !series.label.is_empty() {
            let mark = series.mark;
            // An empty series, for the legend alone.
            let named = context.draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())?;
            named.label(&series.label).legend(move |(x, y)| match mark {
                Mark::Line | Mark::Faint => {
                    PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(width)).into_dyn()
                }
                Mark::Points | Mark::Dots => Circle::new((x + 9, y), 4, colour.filled()).into_dyn(),
            });
        }
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
            .label_font((FONT, 15, &INK))
            .draw()?;
    }
    Ok(())
}

/// An axis in the coordinates of the drawing: logarithms to base ten where it is logarithmic.
#[derive(Clone)]
pub(super) struct Axis {
    ends: [f64; 2],
    ticks: Vec<f64>,
    log: bool,
    /// Decimals of a linear axis' labels.
    decimals: usize,
}

impl Axis {
    /// With labels at round numbers: up to ten on a linear axis, powers of ten on a logarithmic one, and 2
    /// and 5 times these if it spans few.
    pub(super) fn new([low, high]: [f64; 2], log: bool) -> Self {
        if log {
            let ends = [low, high].map(f64::log10);
            let decades = ends[1] - ends[0];
            let multiples: &[f64] = if decades <= 2.5 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let step = (decades / 10.0).ceil().max(1.0) as usize;
            let powers = (ends[0].floor() as i32..=ends[1].ceil() as i32).step_by(step);
            let ticks =
                powers.flat_map(|k| multiples.iter().map(move |m| f64::from(k) + m.log10()));
            Self {
                ends,
                ticks: ticks.filter(|t| inside(ends, *t)).collect(),
                log,
                decimals: 0,
            }
        } else {
            let least = (high - low) / 10.0;
            let power = 10f64.powf(least.log10().floor());
            let multiples = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
            let step = multiples.into_iter().find(|m| *m >= least * (1.0 - 1e-9));
            let step = step.unwrap_or(least);
            let ticks = ((low / step).ceil() as i64..=(high / step).floor() as i64)
                .map(|i| i as f64 * step);
            Self {
                ends: [low, high],
                ticks: ticks.collect(),
                log,
                decimals: (-(step * (1.0 + 1e-9)).log10().floor()).max(0.0) as usize,
            }
        }
    }

    fn reaches(&self, value: f64) -> bool {
        inside(self.ends, value)
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, &value: &f64) -> String {
        let decimals = self.decimals;
        if !self.log {
            return if self.ends[1].abs().max(self.ends[0].abs()) >= 1e6 {
                format!("{value:.0e}")
            } else {
                // Not "-0".
                format!("{:.decimals$}", value + 0.0)
            };
        }
        let power = (value + 1e-9).floor();
        let digit = 10f64.powf(value - power).round();
        if self.ends.iter().any(|end| end.abs() > 4.5) {
            let first = if digit == 1.0 {
                String::new()
            } else {
                format!("{digit}·")
            };
            return format!("{first}10{}", superscript(power as i32));
        }
        let decimals = (-power).max(0.0) as usize;
        format!("{:.decimals$}", digit * 10f64.powf(power))
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let [low, high] = self.ends;
        from + ((value - low) / (high - low) * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.ticks.clone()
        }
    }

    fn range(&self) -> Range<f64> {
        self.ends[0]..self.ends[1]
    }
}

fn inside([low, high]: [f64; 2], value: f64) -> bool {
    let slack = 1e-9 * (high - low);
    (low - slack..=high + slack).contains(&value)
}

fn superscript(power: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    power.to_string().chars().map(raised).collect()
}

/// The parts of a line that lie within the ranges, cut where it leaves them.
fn runs(points: &[(f64, f64)], ranges: [[f64; 2]; 2]) -> Vec<Vec<(f64, f64)>> {
    let mut runs: Vec<Vec<(f64, f64)>> = Vec::new();
    for ends in points.windows(2) {
        let Some([from, to]) = clipped(ends[0], ends[1], &ranges) else {
            continue;
        };
        match runs.last_mut() {
            Some(run) if run.last() == Some(&from) => run.push(to),
            _ => runs.push(vec![from, to]),
        }
    }
    runs
}

/// The part of a segment within a rectangle (Liang and Barsky 1984).
fn clipped(a: (f64, f64), b: (f64, f64), ranges: &[[f64; 2]; 2]) -> Option<[(f64, f64); 2]> {
    let along = [b.0 - a.0, b.1 - a.1];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for ((start, along), &[low, high]) in [a.0, a.1].into_iter().zip(along).zip(ranges) {
        if along == 0.0 {
            if start < low || start > high {
                return None;
            }
            continue;
        }
        let [s, t] = [low, high].map(|end| (end - start) / along);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    let at = |share: f64| match share {
        0.0 => a,
        1.0 => b,
        _ => (a.0 + share * along[0], a.1 + share * along[1]),
    };
    (enter <= leave).then(|| [at(enter), at(leave)])
}
