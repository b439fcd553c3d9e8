//! A forest plot: estimates with intervals, a line each, in units of the claimed effect size δ.

use whitefurnace::harness::outcome::Verdict;
use whitefurnace::harness::trial::Row;

use super::*;

/// An estimate with its interval.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the estimated quantity.
    pub label: String,
    /// Estimate minus reference, in units of δ.
    pub estimate: f64,
    /// Confidence interval of `estimate`.
    pub interval: [f64; 2],
    /// The verdict.
    pub verdict: Verdict,
}

impl Line {
    /// Converts a row of a trial to units of its δ.
    pub fn of(label: String, row: &Row) -> Self {
        let o = &row.outcome;
        let units = |x: f64| (x - o.reference) / o.claim.size();
        let (estimate, interval) = (units(o.estimate), o.interval.map(units));
        Self {
            label,
            estimate,
            interval,
            verdict: row.verdict,
        }
    }
}

/// Result shown by a line's mark.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mark {
    Holds,
    Fails,
    /// The interval reaches out of the band.
    Wide,
    /// The interval lies within the band, but with so few samples its tails are not reliable.
    Few,
}

impl Mark {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Holds, "holds"),
        (Self::Fails, "fails"),
        (Self::Wide, "undecided: the interval leaves the band"),
        (Self::Few, "undecided: too few samples for an interval"),
    ];

    fn of(line: &Line) -> Self {
        match line.verdict {
            Verdict::Holds => Self::Holds,
            Verdict::Fails => Self::Fails,
            Verdict::Undecided { .. } if line.interval.iter().all(|end| end.abs() <= 1.0) => {
                Self::Few
            }
            Verdict::Undecided { .. } => Self::Wide,
        }
    }

    fn colour(self) -> Rgb {
        match self {
            Self::Holds => OKABE_ITO[2],
            Self::Fails => OKABE_ITO[0],
            Self::Wide | Self::Few => Rgb(110, 110, 110),
        }
    }

    /// Returns the pen of the interval: dotted if nothing may be concluded from it.
    fn pen(self) -> Pen {
        Pen {
            dash: if self == Self::Few { &[2.0, 3.0] } else { &[] },
            ..Pen::new(self.colour(), 2.0)
        }
    }

    /// Draws the mark. Shape and colour agree: disc, cross, hollow squares and diamonds.
    fn draw(self, canvas: &mut Canvas, at: [f64; 2]) {
        let colour = self.colour();
        let hollow = |canvas: &mut Canvas, shape, radius| {
            canvas.marks(&[at], shape, radius + 1.0, colour);
            canvas.marks(&[at], shape, radius - 1.5, Rgb(255, 255, 255));
        };
        match self {
            Self::Holds => canvas.marks(&[at], Shape::Disc, 4.2, colour),
            Self::Fails => canvas.marks(&[at], Shape::Cross, 5.0, colour),
            Self::Wide => hollow(canvas, Shape::Square, 4.2),
            Self::Few => hollow(canvas, Shape::Diamond, 4.2),
        }
    }
}

/// The plot covers ± this many δ; values outside get an arrowhead.
const AXIS_LIMIT: f64 = 3.0;
const LEFT: f64 = 462.0;
const WIDTH: f64 = 900.0;
const ROW: f64 = 20.0;
const TOP: f64 = 92.0;
/// Font size of the lines' labels, pixels.
const NAME_SIZE: f64 = 13.0;

/// Draws the lines from top to bottom under `title`; `interval` says how sure their intervals are.
pub fn forest(
    path: &Path,
    title: &str,
    description: &str,
    interval: &str,
    lines: &[Line],
) -> Result<(), Error> {
    let bottom = TOP + ROW * lines.len() as f64;
    let mut canvas = Canvas::new([WIDTH, bottom + 58.0], title, description);
    let x = |value: f64| {
        let share = (value.clamp(-AXIS_LIMIT, AXIS_LIMIT) + AXIS_LIMIT) / (2.0 * AXIS_LIMIT);
        LEFT + (WIDTH - 24.0 - LEFT) * share
    };
    canvas.text(title, [14.0, 20.0], Anchor::Left, TITLE);
    legend(&mut canvas, lines);
    canvas.fill([x(-1.0), TOP - 6.0, x(1.0), bottom], Rgb(238, 243, 247));
    for tick in -3..=3 {
        let at = x(f64::from(tick));
        canvas.line(
            &[[at, TOP - 6.0], [at, bottom]],
            Pen::new(if tick == 0 { INK } else { FAINT }, 1.0),
        );
        let label = match tick {
            0 => "0".to_owned(),
            _ => format!("{tick:+}").replace('-', "−"),
        };
        canvas.text(&label, [at, bottom + 13.0], Anchor::Center, LABEL);
    }
    let words = format!("(estimate − reference)/δ, with its {interval}");
    canvas.text(&words, [x(0.0), bottom + 38.0], Anchor::Center, LABEL);
    for (i, line) in lines.iter().enumerate() {
        let y = TOP + ROW * (i as f64 + 0.5);
        let mark = Mark::of(line);
        canvas.text(
            &shortened(&line.label),
            [LEFT - 12.0, y],
            Anchor::Right,
            NAME_SIZE,
        );
        let [low, high] = line.interval;
        canvas.line(&[[x(low), y], [x(high), y]], mark.pen());
        for (end, side) in [(low, -1.0), (high, 1.0)] {
            if end.abs() > AXIS_LIMIT {
                let tip = x(end);
                let back = tip - 8.0 * side;
                canvas.line(
                    &[[back, y - 4.0], [tip, y], [back, y + 4.0]],
                    Pen::new(mark.colour(), 2.0),
                );
            }
        }
        if line.estimate.abs() <= AXIS_LIMIT {
            mark.draw(&mut canvas, [x(line.estimate), y]);
        }
    }
    canvas.write(path)
}

/// Draws the legend: the marks that occur, and the band.
fn legend(canvas: &mut Canvas, lines: &[Line]) {
    let mut x = 20.0;
    for (mark, label) in Mark::ALL {
        if lines.iter().any(|line| Mark::of(line) == mark) {
            mark.draw(canvas, [x, 50.0]);
            canvas.text(label, [x + 13.0, 50.0], Anchor::Left, NAME_SIZE);
            x += 36.0 + width(label, NAME_SIZE);
        }
    }
    canvas.fill([14.0, 64.0, 36.0, 78.0], Rgb(238, 243, 247));
    let band = "± δ, the effect that must be seen: an interval within it holds";
    canvas.text(band, [44.0, 71.0], Anchor::Left, NAME_SIZE);
}

/// Shortens a label to fit beside the plot.
fn shortened(label: &str) -> String {
    const MAX_LENGTH: usize = 62;
    if label.chars().count() <= MAX_LENGTH {
        return label.to_owned();
    }
    let start: String = label.chars().take(MAX_LENGTH - 1).collect();
    start + "…"
}
