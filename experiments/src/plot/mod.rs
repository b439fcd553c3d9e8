//! Common style of all plots: SVG, one typeface, colours that colour-blind readers can tell apart,
//! and shapes and dashes that carry the same information without colour.

pub mod agreement;
mod axis;
mod canvas;
pub mod chart;
pub mod differences;
pub mod forest;
pub mod map;
pub mod matrix;
mod panel;
pub mod trial_cells;

// Names that all plots use.
use std::path::Path;

use canvas::{Anchor, Area, Canvas, Pen, Point, Shape, width};
use plotters::style::RGBColor as Rgb;
use whitefurnace::error::Error;

/// Mixes a colour with white; a `share` of 1 is the colour itself.
fn tint(Rgb(r, g, b): Rgb, share: f64) -> Rgb {
    let mix = |c: u8| (255.0 + share * (f64::from(c) - 255.0)).round() as u8;
    Rgb(mix(r), mix(g), mix(b))
}

/// Colours of Okabe and Ito, which colour-blind readers can tell apart: vermilion, bluish green,
/// blue, reddish purple, orange, sky blue, black; and a grey.
const OKABE_ITO: [Rgb; 8] = [
    Rgb(213, 94, 0),
    Rgb(0, 158, 115),
    Rgb(0, 114, 178),
    Rgb(204, 121, 167),
    Rgb(230, 159, 0),
    Rgb(86, 180, 233),
    Rgb(0, 0, 0),
    Rgb(130, 130, 130),
];
const INK: Rgb = Rgb(40, 40, 40);
const FAINT: Rgb = Rgb(215, 215, 215);

/// Dashes of lines and shapes of marks that tell series apart without colour, in order of
/// appearance.
const SERIES_STYLES: [(&[f64], Shape); 8] = [
    (&[], Shape::Disc),
    (&[9.0, 4.0], Shape::Square),
    (&[2.5, 3.5], Shape::Triangle),
    (&[10.0, 3.5, 2.5, 3.5], Shape::Diamond),
    (&[18.0, 4.0], Shape::Inverted),
    (&[5.0, 2.5], Shape::Cross),
    (&[2.5, 2.0, 2.5, 7.0], Shape::Plus),
    (&[14.0, 3.0, 2.0, 3.0, 2.0, 3.0], Shape::Bar),
];

/// Font sizes in pixels: titles of figures, titles of panels, and all else.
const TITLE: f64 = 18.0;
const HEADING: f64 = 16.5;
const LABEL: f64 = 14.0;
