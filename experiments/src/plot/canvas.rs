//! A drawing in SVG: shapes at decimal coordinates, with a title and a description for those who cannot
//! see it. Lengths are in pixels, y points down.

use std::fmt;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use whitefurnace::error::Error;

use super::{INK, Rgb};
use crate::run::write_text;

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
        Self { colour, width, dash: "" }
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
        Self { size, title: title.to_owned(), see: see.to_owned(), body: String::new() }
    }

    /// A filled rectangle.
    pub fn fill(&mut self, area: Area, colour: Rgb) {
        let [left, top, right, bottom] = area.map(fine);
        let (width, height) = (right - left, bottom - top);
        self.body += &format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" opacity=\"1\" \
             fill=\"{colour}\" stroke=\"none\"/>\n"
        );
    }

    /// The border of a rectangle.
    pub fn frame(&mut self, [left, top, right, bottom]: Area, pen: Pen) {
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        let [a, b, c, d] = corners;
        self.line(&[a, b, c, d, a], pen);
    }

    /// A line through points.
    pub fn line(&mut self, points: &[Point], pen: Pen) {
        let lengths = pen.dash.split_whitespace().filter_map(|n| n.parse().ok());
        let dash: Vec<String> = lengths.map(|n: f64| fine(n).to_string()).collect();
        let dash = match dash.as_slice() {
            [] => String::new(),
            lengths => format!("stroke-dasharray=\"{}\" ", lengths.join(" ")),
        };
        let (colour, width, points) = (pen.colour, fine(pen.width), list(points));
        self.body += &format!(
            "<polyline {dash}fill=\"none\" opacity=\"1\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             points=\"{points}\"/>\n"
        );
    }

    /// Lines that look alike.
    pub fn lines(&mut self, lines: &[Vec<Point>], pen: Pen) {
        lines.iter().for_each(|line| self.line(line, pen));
    }

    /// Marks of one shape and colour, each about `radius` in all directions.
    pub fn marks(&mut self, at: &[Point], shape: Shape, radius: f64, colour: Rgb) {
        // A thin white rim keeps marks apart that overlap.
        let rim = if radius > 2.0 { RIM } else { "" };
        for &[x, y] in at {
            let corners = |offsets: &[Point]| -> Vec<Point> {
                let at = |&[dx, dy]: &Point| [x + radius * dx, y + radius * dy];
                offsets.iter().map(at).collect()
            };
            match shape.outline() {
                Outline::Disc => {
                    if !rim.is_empty() {
                        self.disc([x, y], radius + 0.3, Rgb(255, 255, 255));
                    }
                    self.disc([x, y], radius, colour);
                }
                Outline::Corners(offsets) => {
                    let points = list(&corners(offsets));
                    self.body += &format!(
                        "<polygon {rim}opacity=\"1\" fill=\"{colour}\" points=\"{points}\"/>\n"
                    );
                }
                Outline::Strokes(strokes) => {
                    for stroke in strokes {
                        self.line(&corners(stroke), Pen::new(colour, 2.0));
                    }
                }
            }
        }
    }

    fn disc(&mut self, at: Point, radius: f64, colour: Rgb) {
        let ([x, y], radius) = (at.map(fine), fine(radius));
        self.body += &format!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" opacity=\"1\" fill=\"{colour}\" stroke=\"none\" \
             stroke-width=\"1\"/>\n"
        );
    }

    /// A text whose middle is at the height of the point.
    pub fn text(&mut self, text: &str, at: Point, anchor: Anchor, size: f64) {
        self.turned(text, at, anchor, size, 0);
    }

    /// A text turned by `degrees` about its point, clockwise.
    pub fn turned(&mut self, text: &str, at: Point, anchor: Anchor, size: f64, degrees: i32) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let ([x, y], size) = (at.map(fine), fine(size));
        let turn = match degrees {
            0 => String::new(),
            _ => format!("transform=\"rotate({degrees} {x} {y})\" "),
        };
        let text = escaped(text).replace('"', "&quot;").replace('\'', "&apos;");
        self.body += &format!(
            "<text {turn}x=\"{x}\" y=\"{y}\" dy=\"0.5ex\" text-anchor=\"{anchor}\" \
             font-family=\"sans-serif\" font-size=\"{size}\" opacity=\"1\" fill=\"{INK}\">\n{text}\n</text>\n"
        );
    }

    /// A picture, stretched over a rectangle.
    pub fn picture(&mut self, [left, top, right, bottom]: Area, png: &[u8]) {
        let [x, y, width, height] = [left, top, right - left, bottom - top].map(fine);
        let data = STANDARD.encode(png);
        self.body += &format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{data}\"/>\n"
        );
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(self, path: &Path) -> Result<(), Error> {
        let [width, height] = self.size;
        let [across, down] = self.size.map(fine);
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {across} {down}\" role=\"img\" aria-labelledby=\"title see\">\n\
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

/// The rim of a mark.
const RIM: &str = "stroke=\"#fff\" stroke-width=\"60\" ";

/// Whole hundredths of a pixel, which are finer than any screen shows.
fn fine(length: f64) -> i32 {
    (100.0 * length).round() as i32
}

/// Points as the attributes of lines and polygons list them.
fn list(points: &[Point]) -> String {
    points.iter().map(|&[x, y]| format!("{},{} ", fine(x), fine(y))).collect()
}

impl fmt::Display for Rgb {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "#{:02X}{:02X}{:02X}", self.0, self.1, self.2)
    }
}

/// How a mark of radius 1 is drawn.
enum Outline {
    Disc,
    Corners(&'static [Point]),
    Strokes(&'static [[Point; 2]; 2]),
}

impl Shape {
    fn outline(self) -> Outline {
        match self {
            Self::Disc => Outline::Disc,
            Self::Square => Outline::Corners(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
            Self::Triangle => Outline::Corners(&[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
            Self::Inverted => Outline::Corners(&[[0.0, 1.2], [1.1, -0.8], [-1.1, -0.8]]),
            Self::Diamond => {
                Outline::Corners(&[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]])
            }
            Self::Bar => {
                Outline::Corners(&[[-1.4, -0.45], [1.4, -0.45], [1.4, 0.45], [-1.4, 0.45]])
            }
            Self::Cross => {
                Outline::Strokes(&[[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]]])
            }
            Self::Plus => Outline::Strokes(&[[[-1.2, 0.0], [1.2, 0.0]], [[0.0, -1.2], [0.0, 1.2]]]),
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
