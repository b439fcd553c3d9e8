//! Maps of a signed quantity: cells in a diverging colour scale, with a colour bar.

use glam::DVec3;
use whitefurnace::image::{encode_rgb, srgb};

use super::axis::Scale;
use super::panel::{LEFT, TOP, axes, frame, heading, page};
use super::*;

/// A map; several share a file.
#[derive(Clone, Debug)]
pub struct Map {
    /// Title of the panel.
    pub title: String,
    /// Labels of the axes, with units.
    pub axes: [String; 2],
    /// Ranges of the axes.
    pub ranges: [[f64; 2]; 2],
    /// Columns and rows of cells.
    pub size: [u32; 2],
    /// Values of the cells, row by row from the top; NaN is grey.
    pub values: Vec<f64>,
    /// Absolute value from which the colour is saturated; cells with larger ones are marked.
    pub bound: f64,
    /// Name of the values, with their unit.
    pub unit: String,
}

/// Middle and ends of the scale in Oklab (Ottosson 2020): lightness, green to red, blue to yellow.
/// The ends, a blue and a vermilion, are equally dark and equally far from the middle, and
/// colour-blind readers can tell them apart.
const MIDDLE: DVec3 = DVec3::new(0.97, 0.0, 0.0);
const ENDS: [DVec3; 2] = [
    DVec3::new(0.45, -0.034, -0.131),
    DVec3::new(0.45, 0.108, 0.083),
];

/// Returns the colour of a value given as a fraction of the bound, 8-bit sRGB. Equal steps of the
/// fraction are equal steps in Oklab.
pub fn diverging(share: f64) -> [u8; 3] {
    let end = ENDS[usize::from(share > 0.0)];
    let [l, a, b] = MIDDLE.lerp(end, share.abs().min(1.0)).to_array();
    let [l, m, s] = [
        l + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        l - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        l - 0.089_484_177_5 * a - 1.291_485_548_0 * b,
    ]
    .map(|root| root.powi(3));
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
    .map(|linear| (255.0 * srgb(linear.clamp(0.0, 1.0))).round() as u8)
}

/// Draws maps in rows of `columns`; `size` is that of the figure in pixels.
pub fn maps(
    path: &Path,
    description: &str,
    size: [u32; 2],
    columns: usize,
    maps: &[Map],
) -> Result<(), Error> {
    let titles: Vec<&str> = maps.iter().map(|map| map.title.as_str()).collect();
    let (mut canvas, areas) = page(description, size, columns, &titles);
    let fault = |message| Error::Image {
        action: "write",
        path: path.to_owned(),
        message,
    };
    for (area, map) in areas.into_iter().zip(maps) {
        draw(&mut canvas, area, map).map_err(fault)?;
    }
    canvas.write(path)
}

/// Width of the bar and its distance from the map, and room for its labels, pixels.
const BAR: f64 = 16.0;
const GAP: f64 = 14.0;
const LABELS: f64 = 74.0;
/// Colour of cells that are NaN, outside the scale.
pub const NAN_COLOUR: [u8; 3] = [150, 150, 150];
/// Number of colours of the bar.
const STEPS: u32 = 64;
/// Least number of pixels on the longer side of a map, so that cells stay visible where a viewer
/// smooths the picture.
const MIN_PIXELS: u32 = 480;
/// Least size of a cell, in pixels, at which values off the scale are marked.
const MIN_MARKED_CELL: f64 = 9.0;

fn draw(canvas: &mut Canvas, area: Area, map: &Map) -> Result<(), String> {
    let [left, top, right, bottom] = area;
    let plot = [
        left + LEFT,
        top + TOP,
        right - 12.0 - GAP - BAR - LABELS,
        bottom - 58.0,
    ];
    let [x, y] = axes(plot, map.ranges, [Scale::Linear; 2]);
    frame(canvas, plot, [&x, &y], &map.axes);
    heading(canvas, plot, top, &map.title);
    canvas.picture(plot, &cells(map)?);
    let [columns, rows] = map.size.map(f64::from);
    let cell = [(plot[2] - plot[0]) / columns, (plot[3] - plot[1]) / rows];
    if cell[0].min(cell[1]) >= MIN_MARKED_CELL {
        for (sign, shape) in [(1.0, Shape::Triangle), (-1.0, Shape::Inverted)] {
            let beyond = (0..map.values.len()).filter(|&i| sign * map.values[i] > map.bound);
            let middle = |i: usize| {
                let [column, row] = [i % map.size[0] as usize, i / map.size[0] as usize];
                [
                    plot[0] + (column as f64 + 0.5) * cell[0],
                    plot[1] + (row as f64 + 0.5) * cell[1],
                ]
            };
            let at: Vec<[f64; 2]> = beyond.map(middle).collect();
            canvas.marks(&at, shape, 3.0, Rgb(255, 255, 255));
        }
    }
    bar(
        canvas,
        [plot[2] + GAP, plot[1], plot[2] + GAP + BAR, plot[3]],
        map,
    );
    Ok(())
}

/// Encodes the cells as a PNG, which is far smaller than a rectangle for each.
fn cells(map: &Map) -> Result<Vec<u8>, String> {
    let [width, height] = map.size;
    let times = MIN_PIXELS.div_ceil(width.max(height).max(1));
    let colour = |value: &f64| {
        if value.is_nan() {
            NAN_COLOUR
        } else {
            diverging(value / map.bound)
        }
    };
    let colours: Vec<[u8; 3]> = map.values.iter().map(colour).collect();
    let mut pixels = Vec::new();
    for row in colours.chunks(width.max(1) as usize) {
        let line: Vec<u8> = row
            .iter()
            .flat_map(|&c| std::iter::repeat_n(c, times as usize))
            .flatten()
            .collect();
        (0..times).for_each(|_| pixels.extend_from_slice(&line));
    }
    encode_rgb([width * times, height * times], &pixels).map_err(|error| error.to_string())
}

/// Draws the colour bar from +bound at the top to −bound, with arrowheads if values lie beyond it.
fn bar(canvas: &mut Canvas, [left, top, right, bottom]: Area, map: &Map) {
    let at = |share: f64| bottom + 0.5 * (share + 1.0) * (top - bottom);
    for step in 0..STEPS {
        let share = 1.0 - (2.0 * f64::from(step) + 1.0) / f64::from(STEPS);
        let [r, g, b] = diverging(share);
        // Each step extends to the bottom, under the next, so that no seams show.
        let upper = at(1.0 - 2.0 * f64::from(step) / f64::from(STEPS));
        canvas.fill([left, upper, right, bottom], Rgb(r, g, b));
    }
    let middle = 0.5 * (left + right);
    for (sign, shape) in [(1.0, Shape::Triangle), (-1.0, Shape::Inverted)] {
        if map.values.iter().any(|value| sign * value > map.bound) {
            let [r, g, b] = diverging(sign);
            canvas.marks(&[[middle, at(sign) - 8.0 * sign]], shape, 7.0, Rgb(r, g, b));
        }
    }
    for quarter in [1.0, 0.5, 0.0, -0.5, -1.0] {
        let value = map.bound * quarter;
        let label = if value == 0.0 {
            "0".to_owned()
        } else {
            format!("{value:+}").replace('-', "−")
        };
        let y = at(quarter);
        canvas.line(&[[right, y], [right + 4.0, y]], Pen::new(INK, 1.0));
        canvas.text(&label, [right + 8.0, y], Anchor::Left, LABEL);
    }
    if map.values.iter().any(|value| value.is_nan()) {
        let [r, g, b] = NAN_COLOUR;
        canvas.fill(
            [left - 8.0, bottom + 24.0, left + 4.0, bottom + 36.0],
            Rgb(r, g, b),
        );
        canvas.text(
            "not judged",
            [left + 9.0, bottom + 30.0],
            Anchor::Left,
            13.0,
        );
    }
    canvas.rotated_text(
        &map.unit,
        [right + LABELS - 12.0, 0.5 * (top + bottom)],
        Anchor::Center,
        LABEL,
        90,
    );
}
