//! Maps of a signed quantity: cells in a diverging scale of colours, with a bar that says what they mean.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use whitefurnace::error::Error;
use whitefurnace::image::{encode_rgb, srgb};

use super::chart::Axis;
use super::{Drawn, FONT, INK, svg};
use crate::lab::write_text;

/// A map; several share a file.
#[derive(Clone, Debug)]
pub struct Map {
    /// What it shows.
    pub title: String,
    /// Labels of the axes, with units.
    pub axes: [String; 2],
    /// Ranges of the axes.
    pub ranges: [[f64; 2]; 2],
    /// Columns and rows of cells.
    pub size: [u32; 2],
    /// The cells, row by row from the top.
    pub values: Vec<f64>,
    /// Values from here on, of either sign, have the full colour.
    pub bound: f64,
    /// What the values are, with their unit.
    pub unit: String,
}

/// The middle of the scale and its ends, in Oklab (Ottosson 2020): lightness, green to red, blue to yellow.
/// The ends, a blue and a vermilion, are equally dark and equally far from the middle, and colour-blind
/// readers can tell them apart.
const MIDDLE: DVec3 = DVec3::new(0.97, 0.0, 0.0);
const ENDS: [DVec3; 2] = [
    DVec3::new(0.45, -0.034, -0.131),
    DVec3::new(0.45, 0.108, 0.083),
];

/// The colour of a share of the bound, 8-bit sRGB. Equal steps of the share are equal steps in Oklab.
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

/// Draws maps in rows of `columns`, `size` in pixels for all together.
///
/// # Errors
/// The file cannot be written.
pub fn maps(path: &Path, size: [u32; 2], columns: usize, maps: &[Map]) -> Result<(), Error> {
    let fault = |message: String| Error::Image {
        action: "write",
        path: path.to_owned(),
        message,
    };
    let mut corners = Vec::new();
    let text = svg(path, size, |root| {
        let areas = root.split_evenly((maps.len().div_ceil(columns).max(1), columns));
        for (area, map) in areas.iter().zip(maps) {
            corners.push(draw(area, map)?);
        }
        Ok(())
    })?;
    // The cells are a PNG within the SVG: a rectangle for each would take many times the room.
    let mut images = String::new();
    for (map, [x, y, width, height]) in maps.iter().zip(corners) {
        let colours: Vec<u8> = map
            .values
            .iter()
            .flat_map(|value| diverging(value / map.bound))
            .collect();
        let png = encode_rgb(map.size, &colours).map_err(|error| fault(error.to_string()))?;
        images += &format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             preserveAspectRatio=\"none\" style=\"image-rendering: pixelated\" \
             href=\"data:image/png;base64,{}\"/>\n",
            STANDARD.encode(&png)
        );
    }
    write_text(path, &text.replace("</svg>", &(images + "</svg>")))
}

/// Room for the title, pixels.
const TITLE: i32 = 38;
/// Width of the bar and its distance from the map, and room for its labels, pixels.
const BAR: i32 = 16;
const GAP: i32 = 14;
const LABELS: i32 = 74;
/// Colours of the bar.
const STEPS: i32 = 64;

/// Draws all but the cells; returns where these belong: left, top, width and height.
fn draw(area: &DrawingArea<SVGBackend<'_>, Shift>, map: &Map) -> Result<[i32; 4], super::Fault> {
    let [x, y] = map.ranges.map(|range| Axis::new(range, false));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_top(TITLE)
        .margin_right(10 + GAP + BAR + LABELS)
        .x_label_area_size(46)
        .y_label_area_size(62)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(INK)
        .label_style((FONT, 15, &INK))
        .x_desc(&map.axes[0])
        .y_desc(&map.axes[1])
        .draw()?;
    let (across, down) = chart.plotting_area().get_pixel_range();
    let (base_x, base_y) = area.get_base_pixel();
    let left = across.end + GAP - base_x;
    let [top, height] = [down.start - base_y, down.end - down.start];
    bar(area, [left, top, height], map)?;
    let middle = (across.start + across.end) / 2 - base_x;
    let style = (FONT, 19, &INK).into_text_style(area);
    let style = style.pos(Pos::new(HPos::Center, VPos::Center));
    let title = Text::new(map.title.as_str(), (middle, top - TITLE / 2), style);
    area.draw(&title)?;
    Ok([across.start, down.start, across.end - across.start, height])
}

/// The scale, from +bound at the top to −bound.
fn bar(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    [left, top, height]: [i32; 3],
    map: &Map,
) -> Drawn {
    let at = |step: i32| top + height * step / STEPS;
    for step in 0..STEPS {
        let share = 1.0 - (2.0 * f64::from(step) + 1.0) / f64::from(STEPS);
        let [r, g, b] = diverging(share);
        // To the bottom, under the next: no seams show.
        let corners = [(left, at(step)), (left + BAR, at(STEPS))];
        area.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled()))?;
    }
    let text = (FONT, 15, &INK).into_text_style(area);
    for quarter in 0..=4 {
        let value = map.bound * (1.0 - f64::from(quarter) / 2.0);
        let label = if value == 0.0 {
            "0".to_owned()
        } else {
            format!("{value:+}").replace('-', "−")
        };
        let y = top + height * quarter / 4;
        area.draw(&PathElement::new(
            [(left + BAR, y), (left + BAR + 4, y)],
            INK,
        ))?;
        let middle = text.pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(label, (left + BAR + 7, y), middle))?;
    }
    let upright = text
        .pos(Pos::new(HPos::Center, VPos::Top))
        .transform(FontTransform::Rotate90);
    let place = (left + BAR + LABELS, top + height / 2);
    area.draw(&Text::new(map.unit.as_str(), place, upright))?;
    Ok(())
}
