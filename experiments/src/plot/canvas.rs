//! A drawing in SVG: shapes at decimal coordinates, with a title and a description for readers who
//! cannot see it. Lengths are in pixels, y points down.

use std::io;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use plotters::prelude::{
    Color as _, DrawingBackend as _, IntoFont as _, SVGBackend, TextStyle, WHITE,
};
pub(super) use plotters::style::text_anchor::HPos as Anchor;
use plotters::style::text_anchor::{Pos, VPos};
use plotters_backend::DrawingErrorKind;
use whitefurnace::error::Error;

use super::{INK, Rgb};
use crate::run::write_text;

/// A position: x to the right, y down.
pub(super) type Point = [f64; 2];

/// Left, top, right and bottom.
pub(super) type Area = [f64; 4];

#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub colour: Rgb,
    pub width: f64,
    /// Lengths of strokes and gaps; empty for a solid line.
    pub dash: &'static [f64],
}

impl Pen {
    /// Returns a pen for a solid line.
    pub const fn new(colour: Rgb, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: &[],
        }
    }
}

/// Shape of a mark. Shapes can be told apart without colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Disc,
    Square,
    Triangle,
    Diamond,
    Cross,
    Inverted,
    Plus,
    Bar,
}

/// A drawing under construction.
pub(super) struct Canvas {
    size: Point,
    title: String,
    description: String,
    body: String,
}

impl Canvas {
    /// Returns a white page. `title` is its title; `description` is for readers who cannot see it.
    pub fn new(size: Point, title: &str, description: &str) -> Self {
        Self {
            size,
            title: title.to_owned(),
            description: description.to_owned(),
            body: String::new(),
        }
    }

    /// Adds what `draw` draws, with SVG attributes that plotters does not support.
    fn draw(
        &mut self,
        attributes: &str,
        draw: impl FnOnce(&mut SVGBackend) -> Result<(), DrawingErrorKind<io::Error>>,
    ) {
        let mut page = String::new();
        // Writing to a string cannot fail.
        let _ = draw(&mut SVGBackend::with_string(
            &mut page,
            self.size.map(|side| hundredths(side) as u32).into(),
        ));
        for line in page.lines().filter(|line| !line.contains("svg")) {
            match line.split_once(' ') {
                Some((tag, rest)) if line.starts_with('<') && !attributes.is_empty() => {
                    self.body.push_str(&format!("{tag} {attributes} {rest}\n"));
                }
                _ => self.body.push_str(&format!("{line}\n")),
            }
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, [left, top, right, bottom]: Area, colour: Rgb) {
        let corners = [place([left, top]), place([right, bottom])];
        self.draw("", |page| {
            page.draw_rect(corners[0], corners[1], &colour.filled(), true)
        });
    }

    /// Draws the border of a rectangle.
    pub fn frame(&mut self, [left, top, right, bottom]: Area, pen: Pen) {
        self.line(
            &[
                [left, top],
                [right, top],
                [right, bottom],
                [left, bottom],
                [left, top],
            ],
            pen,
        );
    }

    pub fn line(&mut self, points: &[Point], pen: Pen) {
        let dash: Vec<String> = pen
            .dash
            .iter()
            .map(|&length| hundredths(length).to_string())
            .collect();
        let dashed = || format!("stroke-dasharray=\"{}\"", dash.join(" "));
        let attributes = if dash.is_empty() {
            String::new()
        } else {
            dashed()
        };
        let stroke = pen.colour.stroke_width(hundredths(pen.width) as u32);
        self.draw(&attributes, |page| {
            page.draw_path(points.iter().map(|&at| place(at)), &stroke)
        });
    }

    pub fn lines(&mut self, lines: &[Vec<Point>], pen: Pen) {
        lines.iter().for_each(|line| self.line(line, pen));
    }

    /// Draws marks of one shape and colour, each of about this `radius`.
    pub fn marks(&mut self, at: &[Point], shape: Shape, radius: f64, colour: Rgb) {
        // A thin white rim separates marks that overlap.
        let rim = if radius > 2.0 { RIM } else { "" };
        for &[x, y] in at {
            let at = |&[dx, dy]: &Point| [x + radius * dx, y + radius * dy];
            let corners: Vec<Point> = shape.corners().iter().map(at).collect();
            match shape {
                Shape::Disc => self.draw("", |page| {
                    let at = place([x, y]);
                    if !rim.is_empty() {
                        page.draw_circle(at, hundredths(radius + 0.3) as u32, &WHITE, true)?;
                    }
                    page.draw_circle(at, hundredths(radius) as u32, &colour.filled(), true)
                }),
                Shape::Cross | Shape::Plus => {
                    corners
                        .chunks(2)
                        .for_each(|stroke| self.line(stroke, Pen::new(colour, 2.0)));
                }
                _ => self.draw(rim, |page| {
                    page.fill_polygon(corners.into_iter().map(place), &colour.filled())
                }),
            }
        }
    }

    /// Draws a text, centred vertically on the point.
    pub fn text(&mut self, text: &str, at: Point, anchor: Anchor, size: f64) {
        self.rotated_text(text, at, anchor, size, 0);
    }

    /// Draws a text turned by `degrees` about its point, clockwise.
    pub fn rotated_text(&mut self, text: &str, at: Point, anchor: Anchor, size: f64, degrees: i32) {
        let (x, y) = place(at);
        let turn = match degrees {
            0 => String::new(),
            _ => format!("transform=\"rotate({degrees} {x} {y})\""),
        };
        // Plotters writes font sizes divided by 1.24.
        let font = ("sans-serif", 1.24 * f64::from(hundredths(size))).into_font();
        let style = TextStyle::from(font)
            .color(&INK)
            .pos(Pos::new(anchor, VPos::Center));
        self.draw(&turn, |page| page.draw_text(text, &style, (x, y)));
    }

    /// Draws a picture stretched over a rectangle, which plotters does not support.
    pub fn picture(&mut self, [left, top, right, bottom]: Area, png: &[u8]) {
        let [x, y, width, height] = [left, top, right - left, bottom - top].map(hundredths);
        let data = STANDARD.encode(png);
        self.body.push_str(&format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{data}\"/>\n"
        ));
    }

    pub fn write(self, path: &Path) -> Result<(), Error> {
        let [width, height] = self.size;
        let [across, down] = self.size.map(hundredths);
        let [title, description] = [escaped(&self.title), escaped(&self.description)];
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {across} {down}\" role=\"img\" aria-labelledby=\"title see\">\n\
             <title id=\"title\">{title}</title>\n<desc id=\"see\">{description}</desc>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        );
        write_text(path, &text)
    }
}

/// Estimates the width of a text, pixels.
pub(super) fn width(text: &str, size: f64) -> f64 {
    0.59 * size * text.chars().count() as f64
}

/// Attributes of the rim of a mark.
const RIM: &str = "stroke=\"#fff\" stroke-width=\"60\"";

/// Converts a length to hundredths of a pixel: plotters draws at whole coordinates.
fn hundredths(length: f64) -> i32 {
    (100.0 * length).round() as i32
}

fn place([x, y]: Point) -> (i32, i32) {
    (hundredths(x), hundredths(y))
}

impl Shape {
    /// Returns the corners of a mark of radius 1; for crosses the ends of both strokes; for a disc
    /// none.
    fn corners(self) -> &'static [Point] {
        match self {
            Self::Disc => &[],
            Self::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
            Self::Triangle => &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
            Self::Inverted => &[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]],
            Self::Diamond => &[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]],
            Self::Bar => &[[-1.4, -0.45], [1.4, -0.45], [1.4, 0.45], [-1.4, 0.45]],
            Self::Cross => &[[-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]],
            Self::Plus => &[[-1.2, 0.0], [1.2, 0.0], [0.0, -1.2], [0.0, 1.2]],
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
