//! Plots the data file that a failing trial writes.

use std::fs::File;
use std::path::Path;

use whitefurnace::error::Error;
use whitefurnace::harness::outcome::Cell;

use crate::plot::chart::{Chart, Mark, Series, charts};

const HEADER: [&str; 4] = ["place", "expected", "observed", "sigmas"];

/// Reads a data file.
pub fn read(path: &Path) -> Result<Vec<Cell>, Error> {
    let mut reader = csv::Reader::from_reader(File::open(path).map_err(Error::file("read", path))?);
    let wrong = |line: u64, message: &str| {
        Error::Option(format!("{} line {line}: {message}", path.display()))
    };
    if reader
        .headers()
        .is_ok_and(|header| header != HEADER.as_slice())
    {
        return Err(wrong(
            1,
            &format!("expected the columns {}", HEADER.join(",")),
        ));
    }
    let mut cells = Vec::new();
    for row in reader.deserialize() {
        let (place, expected, observed, sigmas) = row.map_err(|error| {
            wrong(
                error.position().map_or(1, csv::Position::line),
                "expected a quoted place and three numbers",
            )
        })?;
        cells.push(Cell {
            place,
            expected,
            observed,
            sigmas,
        });
    }
    if cells.is_empty() {
        Err(wrong(2, "no cells"))
    } else {
        Ok(cells)
    }
}

/// Draws residuals above, expected and observed values below.
pub fn plot(cells: &[Cell], title: &str, path: &Path) -> Result<(), Error> {
    let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
    let points = |value: fn(&Cell) -> f64| -> Vec<[f64; 2]> {
        cells
            .iter()
            .enumerate()
            .map(|(i, cell)| [i as f64 + 1.0, finite(value(cell))])
            .collect()
    };
    let residuals = points(|cell| cell.sigmas);
    let largest = residuals
        .iter()
        .fold(3.0f64, |most, point| most.max(point[1].abs()))
        * 1.15;
    let x = [0.0, cells.len() as f64 + 1.0];
    let axis = format!("cell (1 to {}, in the order of the file)", cells.len());
    let worst = cells
        .iter()
        .max_by(|a, b| finite(a.sigmas).abs().total_cmp(&finite(b.sigmas).abs()));
    let place = worst.map_or("", |cell| cell.place.as_str());
    let stems = residuals.iter().map(|point| [0.0, point[1]]).collect();
    let stems = Series::new("", 0, Mark::Points, residuals).with_bars(stems);
    let zero = Series::new("", 6, Mark::Line, [[x[0], 0.0], [x[1], 0.0]]);
    let (expected, observed) = (points(|cell| cell.expected), points(|cell| cell.observed));
    let both = || expected.iter().chain(&observed).map(|point| point[1]);
    let (low, high) = (
        both().fold(f64::MAX, f64::min),
        both().fold(f64::MIN, f64::max),
    );
    let room = 0.08 * (high - low).max(1e-3 * high.abs()).max(f64::MIN_POSITIVE);
    let title = format!("{title}: worst at {place}");
    let above = Chart::new(
        title,
        [&axis, "(observed − expected)/σ"],
        [x, [-largest, largest]],
        vec![zero, stems],
    );
    let series = vec![
        Series::new("expected", 6, Mark::Line, expected),
        Series::new("observed", 0, Mark::Points, observed),
    ];
    let axes = [&axis, "value (counts, or the units of the estimate)"];
    let below = Chart::new(
        "expected and observed",
        axes,
        [x, [low - room, high + 3.0 * room]],
        series,
    );
    let description = "Above: how far each cell is from what is expected. Below: both values.";
    charts(path, description, [900, 820], &[above, below])
}
