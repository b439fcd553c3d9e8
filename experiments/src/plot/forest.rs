//! A forest plot: estimates with intervals, a line each, in units of the effect that must be seen.

use std::path::Path;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use whitefurnace::error::Error;
use whitefurnace::harness::outcome::Verdict;

use super::{FAINT, FONT, INK, OKABE_ITO, write_svg};

/// One line.
#[derive(Clone, Debug)]
pub struct Line {
    /// What is estimated.
    pub label: String,
    /// Estimate minus reference, in units of δ.
    pub estimate: f64,
    /// The interval of the same.
    pub interval: [f64; 2],
    /// The verdict.
    pub verdict: Verdict,
}

/// The plot reaches to ± this many δ; what lies outside gets an arrowhead.
const REACH: f64 = 3.0;
const LEFT: i32 = 430;
const WIDTH: i32 = 900;
const ROW: i32 = 18;
const TOP: i32 = 58;

/// Draws the lines from top to bottom.
///
/// # Errors
/// The file cannot be written.
pub fn forest(path: &Path, title: &str, lines: &[Line]) -> Result<(), Error> {
    let bottom = TOP + ROW * lines.len() as i32;
    let size = [WIDTH as u32, (bottom + 78) as u32];
    let right = WIDTH - 24;
    let x = |value: f64| {
        let share = (value.clamp(-REACH, REACH) + REACH) / (2.0 * REACH);
        LEFT + ((right - LEFT) as f64 * share).round() as i32
    };
    write_svg(path, size, |root| {
        let anchored = |h| {
            (FONT, 13, &INK)
                .into_text_style(root)
                .pos(Pos::new(h, VPos::Center))
        };
        let [left_text, centre_text, right_text] =
            [HPos::Left, HPos::Center, HPos::Right].map(anchored);
        let heading = (FONT, 17, &INK).into_text_style(root);
        root.draw(&Text::new(title, (12, 12), heading))?;
        root.draw(&Rectangle::new(
            [(x(-1.0), TOP - 6), (x(1.0), bottom)],
            RGBColor(238, 243, 247).filled(),
        ))?;
        for tick in -3..=3 {
            let at = x(f64::from(tick));
            let style = if tick == 0 { INK } else { FAINT };
            root.draw(&PathElement::new(vec![(at, TOP - 6), (at, bottom)], style))?;
            root.draw(&Text::new(
                format!("{tick:+}").replace("+0", "0"),
                (at, bottom + 12),
                centre_text.clone(),
            ))?;
        }
        root.draw(&Text::new(
            "(estimate − reference)/δ, with its interval at level 1 − 1e-9",
            ((LEFT + right) / 2, bottom + 32),
            centre_text.clone(),
        ))?;
        for (i, line) in lines.iter().enumerate() {
            let y = TOP + ROW * i as i32 + ROW / 2;
            let colour = colour(line.verdict);
            root.draw(&Text::new(
                shortened(&line.label),
                (LEFT - 12, y),
                right_text.clone(),
            ))?;
            let [low, high] = line.interval;
            root.draw(&PathElement::new(
                vec![(x(low), y), (x(high), y)],
                colour.stroke_width(2),
            ))?;
            for (end, side) in [(low, -1), (high, 1)] {
                if end.abs() > REACH {
                    let tip = x(end);
                    let points = vec![(tip, y), (tip - 7 * side, y - 4), (tip - 7 * side, y + 4)];
                    root.draw(&Polygon::new(points, colour.filled()))?;
                }
            }
            if line.estimate.abs() <= REACH {
                draw_mark(root, (x(line.estimate), y), line.verdict)?;
            }
        }
        let legend = [
            Verdict::Holds,
            Verdict::Fails,
            Verdict::Undecided { needed: 0 },
        ];
        for (i, verdict) in legend.into_iter().enumerate() {
            let at = LEFT + 130 * i as i32 + 70;
            draw_mark(root, (at, bottom + 56), verdict)?;
            root.draw(&Text::new(
                verdict.word(),
                (at + 12, bottom + 56),
                left_text.clone(),
            ))?;
        }
        Ok(())
    })
}

/// Shape and colour say the same: disc, cross, square.
fn draw_mark(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    at: (i32, i32),
    verdict: Verdict,
) -> super::Drawn {
    let colour = colour(verdict);
    match verdict {
        Verdict::Holds => root.draw(&Circle::new(at, 4, colour.filled()))?,
        Verdict::Fails => root.draw(&Cross::new(at, 5, colour.stroke_width(3)))?,
        Verdict::Undecided { .. } => root
            .draw(&Rectangle::new(
                [(at.0 - 3, at.1 - 3), (at.0 + 3, at.1 + 3)],
                WHITE.filled(),
            ))
            .and_then(|()| {
                root.draw(&Rectangle::new(
                    [(at.0 - 3, at.1 - 3), (at.0 + 3, at.1 + 3)],
                    colour.stroke_width(2),
                ))
            })?,
    }
    Ok(())
}

fn colour(verdict: Verdict) -> RGBColor {
    match verdict {
        Verdict::Holds => OKABE_ITO[2],
        Verdict::Fails => OKABE_ITO[0],
        Verdict::Undecided { .. } => RGBColor(110, 110, 110),
    }
}

/// Labels must fit beside the plot.
fn shortened(label: &str) -> String {
    const MOST: usize = 64;
    if label.chars().count() <= MOST {
        return label.to_owned();
    }
    let start: String = label.chars().take(MOST - 1).collect();
    start + "…"
}
