//! A chart with lines, points and error bars over linear or logarithmic axes.

use super::axis::Scale;
use super::panel::{LEFT, TOP, axes, frame, heading, page};
use super::*;

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points.
    Line,
    /// Marks, with a shape that follows from the colour.
    Points,
    /// Dots, for scatter.
    Dots,
    /// Thin grey lines, for context.
    Faint,
}

/// Points with a name.
#[derive(Clone, Debug)]
pub struct Series {
    /// Text for the legend; empty for none.
    pub label: String,
    /// Index into the palette. Series of one colour share shape and dash.
    pub colour: usize,
    /// Style in which the points are drawn.
    pub mark: Mark,
    /// x and y.
    pub points: Vec<[f64; 2]>,
    /// Low and high end of each point's error bar; empty for none.
    pub bars: Vec<[f64; 2]>,
}

impl Series {
    /// Returns a series without error bars.
    pub fn new(
        label: &str,
        colour: usize,
        mark: Mark,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Self {
        let points = points.into_iter().collect();
        Self {
            label: label.to_owned(),
            colour,
            mark,
            points,
            bars: Vec::new(),
        }
    }

    /// Returns the line of a function at `steps` + 1 places from one end of a range to the other.
    pub fn curve(
        label: &str,
        colour: usize,
        [from, to]: [f64; 2],
        steps: u32,
        f: impl Fn(f64) -> f64,
    ) -> Self {
        let x = (0..=steps).map(|i| from + (to - from) * f64::from(i) / f64::from(steps));
        Self::new(label, colour, Mark::Line, x.map(|x| [x, f(x)]))
    }

    /// Returns marks with error bars from x, y and the half length of the bar of y.
    pub fn measured(
        label: &str,
        colour: usize,
        points: impl IntoIterator<Item = [f64; 3]>,
    ) -> Self {
        let mut series = Self::new(label, colour, Mark::Points, []);
        for [x, y, half] in points {
            series.points.push([x, y]);
            series.bars.push([y - half, y + half]);
        }
        series
    }

    /// Returns the series with these error bars.
    pub fn with_bars(self, bars: Vec<[f64; 2]>) -> Self {
        Self { bars, ..self }
    }
}

/// A chart; several are drawn one below the other.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title of the panel.
    pub title: String,
    /// Labels of the axes, with units.
    pub axes: [String; 2],
    /// Ranges of the axes, before the logarithm.
    pub ranges: [[f64; 2]; 2],
    /// True for each axis that is logarithmic.
    pub log: [bool; 2],
    /// Series, in drawing order.
    pub series: Vec<Series>,
}

impl Chart {
    /// Returns a chart with linear axes.
    pub fn new(
        title: impl Into<String>,
        axes: [&str; 2],
        ranges: [[f64; 2]; 2],
        series: Vec<Series>,
    ) -> Self {
        let axes = axes.map(str::to_owned);
        Self {
            title: title.into(),
            axes,
            ranges,
            log: [false, false],
            series,
        }
    }

    /// Makes the axes logarithmic where `log` is true.
    pub fn log(self, log: [bool; 2]) -> Self {
        Self { log, ..self }
    }
}

/// Draws charts one below the other; `size` is that of the figure in pixels.
pub fn charts(
    path: &Path,
    description: &str,
    size: [u32; 2],
    charts: &[Chart],
) -> Result<(), Error> {
    rows(path, description, size, 1, charts)
}

/// Draws charts in rows of `columns`; `size` is that of the figure in pixels.
pub fn rows(
    path: &Path,
    description: &str,
    size: [u32; 2],
    columns: usize,
    charts: &[Chart],
) -> Result<(), Error> {
    let styles = SeriesStyles::of(charts);
    let titles: Vec<&str> = charts.iter().map(|chart| chart.title.as_str()).collect();
    let (mut canvas, areas) = page(description, size, columns, &titles);
    for (area, chart) in areas.into_iter().zip(charts) {
        draw(&mut canvas, area, chart, &styles);
    }
    canvas.write(path)
}

/// Dashes and shapes of colours: the colours in the order in which a figure's series use them.
struct SeriesStyles(Vec<usize>);

impl SeriesStyles {
    fn of(charts: &[Chart]) -> Self {
        let mut colours = Vec::new();
        for series in charts.iter().flat_map(|chart| &chart.series) {
            let styled = !matches!(series.mark, Mark::Faint | Mark::Dots);
            // Black is for references: always a solid line.
            if styled && series.colour != BLACK && !colours.contains(&series.colour) {
                colours.push(series.colour);
            }
        }
        Self(colours)
    }

    fn style(&self, series: &Series) -> (&'static [f64], Shape) {
        let place = self.0.iter().position(|&colour| colour == series.colour);
        // A black series beside others has a shape of its own.
        place.map_or((&[][..], SERIES_STYLES[3].1), |place| {
            SERIES_STYLES[place % SERIES_STYLES.len()]
        })
    }

    fn pen(&self, series: &Series) -> Pen {
        match series.mark {
            Mark::Faint => Pen::new(Rgb(150, 150, 150), 1.0),
            _ => Pen {
                colour: colour(series),
                width: 2.0,
                dash: self.style(series).0,
            },
        }
    }
}

/// Index of black in the palette.
const BLACK: usize = 6;

fn colour(series: &Series) -> Rgb {
    OKABE_ITO[series.colour % OKABE_ITO.len()]
}

/// Room right of the plotted area and below it, pixels.
const RIGHT: f64 = 26.0;
const BOTTOM: f64 = 60.0;
/// Height of a line of the legend, pixels.
const LINE: f64 = 22.0;
const RADIUS: f64 = 4.2;

fn draw(canvas: &mut Canvas, area: Area, chart: &Chart, styles: &SeriesStyles) {
    let [left, top, right, bottom] = area;
    let lines = legend(canvas, area, chart, styles);
    let plot = [
        left + LEFT,
        top + TOP + LINE * lines as f64,
        right - RIGHT,
        bottom - BOTTOM,
    ];
    let divisions = chart.log.map(|log| {
        if log {
            Scale::Logarithmic
        } else {
            Scale::Linear
        }
    });
    let [x, y] = axes(plot, chart.ranges, divisions);
    frame(canvas, plot, [&x, &y], &chart.axes);
    heading(canvas, plot, top, &chart.title);
    let extents = [x.extent(), y.extent()];
    for series in &chart.series {
        let pen = styles.pen(series);
        let place = |&[a, b]: &[f64; 2]| [x.at(a), y.at(b)];
        let points: Vec<Point> = series.points.iter().map(place).collect();
        let bars: Vec<Vec<Point>> = points
            .iter()
            .zip(&series.bars)
            .flat_map(|(at, &[low, high])| {
                visible_parts(&[[at[0], y.at(low)], [at[0], y.at(high)]], extents)
            })
            .collect();
        canvas.lines(&bars, Pen::new(pen.colour, 1.8));
        match series.mark {
            Mark::Line | Mark::Faint => canvas.lines(&visible_parts(&points, extents), pen),
            Mark::Points | Mark::Dots => {
                let seen = series
                    .points
                    .iter()
                    .filter(|[a, b]| x.shows(*a) && y.shows(*b));
                let seen: Vec<Point> = seen.map(place).collect();
                let (shape, radius) = match series.mark {
                    Mark::Dots => (Shape::Disc, 1.3),
                    _ => (styles.style(series).1, RADIUS),
                };
                canvas.marks(&seen, shape, radius, colour(series));
            }
        }
    }
}

/// Draws the legend above the plot, where it hides nothing; returns the number of its lines.
fn legend(
    canvas: &mut Canvas,
    [left, top, right, _]: Area,
    chart: &Chart,
    styles: &SeriesStyles,
) -> usize {
    let start = left + LEFT;
    let (mut x, mut lines) = (start, 0);
    for series in chart.series.iter().filter(|s| !s.label.is_empty()) {
        let length = 36.0 + width(&series.label, LABEL) + 20.0;
        if lines == 0 || (x + length > right && x > start) {
            x = start;
            lines += 1;
        }
        let y = top + TOP + LINE * lines as f64 - LINE / 2.0 - 4.0;
        // A line's points are often a series without a name.
        let sample = chart.series.iter().filter(|other| {
            other.colour == series.colour
                && (other.mark == series.mark
                    || (other.label.is_empty() && other.mark != Mark::Faint))
        });
        let sample: Vec<&Series> = sample.collect();
        for part in &sample {
            if matches!(part.mark, Mark::Line | Mark::Faint) {
                canvas.line(&[[x, y], [x + 30.0, y]], styles.pen(part));
            }
        }
        if let Some(part) = sample
            .iter()
            .find(|s| matches!(s.mark, Mark::Points | Mark::Dots))
        {
            canvas.marks(&[[x + 15.0, y]], styles.style(part).1, RADIUS, colour(part));
        }
        canvas.text(&series.label, [x + 36.0, y], Anchor::Left, LABEL);
        x += length;
    }
    lines
}

/// Returns the parts of a line that lie within the ranges, cut where it leaves them.
fn visible_parts(points: &[Point], ranges: [[f64; 2]; 2]) -> Vec<Vec<Point>> {
    let mut runs: Vec<Vec<Point>> = Vec::new();
    for ends in points.windows(2) {
        let Some([from, to]) = clipped(ends[0], ends[1], ranges) else {
            continue;
        };
        match runs.last_mut() {
            Some(run) if run.last() == Some(&from) => run.push(to),
            _ => runs.push(vec![from, to]),
        }
    }
    runs
}

/// Returns the part of a segment within a rectangle (Liang and Barsky 1984).
fn clipped(a: Point, b: Point, ranges: [[f64; 2]; 2]) -> Option<[Point; 2]> {
    let along = [b[0] - a[0], b[1] - a[1]];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for ((start, along), [low, high]) in a.into_iter().zip(along).zip(ranges) {
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
        _ => [a[0] + share * along[0], a[1] + share * along[1]],
    };
    (enter <= leave).then(|| [at(enter), at(leave)])
}
