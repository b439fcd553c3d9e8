//! A drawing in SVG: shapes at decimal coordinates, with a title and a description for those who cannot
//! see it. Lengths are in pixels, y points down.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use whitefurnace::error::Error;

use super::{INK, Rgb};
use crate::lab::write_text;

/// Across and down.
pub(super) type Point = [f64; 2];

/// Left, top, right and bottom.
pub(super) type Area = [f64; 4];

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    /// Its colour.
    pub colour: Rgb,
    /// Its width.
    pub width: f64,
    /// Lengths of strokes and gaps; empty for a line without gaps.
    pub dash: &'static str,
}

impl Pen {
    /// A line without gaps.
    pub const fn new(colour: Rgb, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: "",
        }
    }
}

/// The shape of a mark. Each can be told from the others without colour.
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

/// Where a text stands with respect to its point.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing in the making.
pub(super) struct Canvas {
    size: Point,
    title: String,
    see: String,
    body: String,
}

impl Canvas {
    /// A white page. `title` says what it shows, `see` what there is to see.
    pub fn new(size: Point, title: &str, see: &str) -> Self {
        Self {
            size,
            title: title.to_owned(),
            see: see.to_owned(),
            body: String::new(),
        }
    }

    /// An element that ends in itself.
    fn element(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "<{text}/>");
    }

    /// A filled rectangle.
    pub fn fill(&mut self, [left, top, right, bottom]: Area, colour: Rgb) {
        let [x, y, width, height] = [left, top, right - left, bottom - top].map(decimal);
        self.element(format_args!(
            "rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{colour}\""
        ));
    }

    /// The border of a rectangle.
    pub fn frame(&mut self, [left, top, right, bottom]: Area, pen: Pen) {
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        let [a, b, c, d] = corners;
        self.line(&[a, b, c, d, a], pen);
    }

    /// A line through points.
    pub fn line(&mut self, points: &[Point], pen: Pen) {
        self.path(&polyline(points), pen);
    }

    /// Lines that look alike.
    pub fn lines(&mut self, lines: &[Vec<Point>], pen: Pen) {
        let path: String = lines.iter().map(|line| polyline(line)).collect();
        if !path.is_empty() {
            self.path(&path, pen);
        }
    }

    fn path(&mut self, path: &str, pen: Pen) {
        let dash = if pen.dash.is_empty() {
            String::new()
        } else {
            format!(" stroke-dasharray=\"{}\"", pen.dash)
        };
        let (colour, width) = (pen.colour, decimal(pen.width));
        self.element(format_args!(
            "path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash} \
             stroke-linejoin=\"round\""
        ));
    }

    /// Marks of one shape and colour, each about `radius` in all directions.
    pub fn marks(&mut self, at: &[Point], shape: Shape, radius: f64, colour: Rgb) {
        let path: String = at.iter().map(|&at| mark(at, shape, radius)).collect();
        if path.is_empty() {
            return;
        }
        let paint = match shape {
            Shape::Cross | Shape::Plus => {
                format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"")
            }
            // A thin white rim keeps marks apart that overlap.
            _ if radius > 2.0 => format!("fill=\"{colour}\" stroke=\"#fff\" stroke-width=\"0.6\""),
            _ => format!("fill=\"{colour}\""),
        };
        self.element(format_args!("path d=\"{path}\" {paint}"));
    }

    /// A text whose middle is at the height of the point.
    pub fn text(&mut self, text: &str, at: Point, anchor: Anchor, size: f64) {
        self.turned(text, at, anchor, size, 0);
    }

    /// A text turned by `degrees` about its point, clockwise.
    pub fn turned(&mut self, text: &str, [x, y]: Point, anchor: Anchor, size: f64, degrees: i32) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let turn = match degrees {
            0 => String::new(),
            _ => format!(
                " transform=\"rotate({degrees} {} {})\"",
                decimal(x),
                decimal(y)
            ),
        };
        // From the baseline to the middle of small letters and capitals.
        let (x, y) = (decimal(x), decimal(y + 0.35 * size));
        let (size, text) = (decimal(size), escaped(text));
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor}{turn}>{text}</text>"
        );
    }

    /// A picture, stretched over a rectangle.
    pub fn picture(&mut self, [left, top, right, bottom]: Area, png: &[u8]) {
        let [x, y, width, height] = [left, top, right - left, bottom - top].map(decimal);
        let data = STANDARD.encode(png);
        self.element(format_args!(
            "image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{data}\""
        ));
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(self, path: &Path) -> Result<(), Error> {
        let [width, height] = self.size.map(decimal);
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"title see\" \
             font-family=\"sans-serif\" fill=\"{INK}\">\n\
             <title id=\"title\">{}</title>\n<desc id=\"see\">{}</desc>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            escaped(&self.title),
            escaped(&self.see),
            self.body
        );
        write_text(path, &text)
    }
}

/// About how wide a text is.
pub(super) fn width(text: &str, size: f64) -> f64 {
    0.59 * size * text.chars().count() as f64
}

/// With two decimals at most: finer than any screen shows.
fn decimal(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}

fn polyline(points: &[Point]) -> String {
    let mut path = String::new();
    for (i, &[x, y]) in points.iter().enumerate() {
        let letter = if i == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{} {}", decimal(x), decimal(y));
    }
    path
}

fn mark([x, y]: Point, shape: Shape, r: f64) -> String {
    let closed = |corners: &[Point]| {
        let corners: Vec<Point> = corners
            .iter()
            .map(|[dx, dy]| [x + r * dx, y + r * dy])
            .collect();
        polyline(&corners) + "Z"
    };
    match shape {
        Shape::Disc => {
            let [left, y, r, across] = [x - r, y, r, 2.0 * r].map(decimal);
            format!("M{left} {y}a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0 -{across} 0")
        }
        Shape::Square => closed(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
        Shape::Triangle => closed(&[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
        Shape::Inverted => closed(&[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]]),
        Shape::Diamond => closed(&[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]]),
        Shape::Bar => closed(&[[-1.4, -0.45], [1.4, -0.45], [1.4, 0.45], [-1.4, 0.45]]),
        Shape::Cross => {
            polyline(&[[x - r, y - r], [x + r, y + r]])
                + &polyline(&[[x - r, y + r], [x + r, y - r]])
        }
        Shape::Plus => {
            polyline(&[[x - 1.2 * r, y], [x + 1.2 * r, y]])
                + &polyline(&[[x, y - 1.2 * r], [x, y + 1.2 * r]])
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
