//! Shows the progress of a program: a line at the foot of a terminal, or else a line of text every
//! few seconds.

use std::io::IsTerminal as _;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

pub use crate::run::signals::interrupted;

/// A task in progress, and the unit it counts. The bar only counts; a bar of length 0 has no end and
/// shows what is done and the elapsed time.
type Task = (ProgressBar, &'static str);

/// Tasks in progress, sub-tasks last, and the line that shows them.
struct Shown {
    tasks: Vec<Task>,
    line: Option<ProgressBar>,
    /// Without a terminal: when the next line is due.
    due: Option<Instant>,
}

static SHOWN: Mutex<Shown> = Mutex::new(Shown {
    tasks: Vec::new(),
    line: None,
    due: None,
});

const DRAWN_EVERY: Duration = Duration::from_millis(200);
/// Without a terminal: time until the first line, and longest time between two lines.
const FIRST_WRITTEN: Duration = Duration::from_secs(1);
const WRITTEN_EVERY: Duration = Duration::from_secs(9);

fn shown() -> MutexGuard<'static, Shown> {
    // A panic elsewhere does not spoil the display.
    SHOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Shows progress on standard error from here on.
pub fn show() {
    let terminal = std::io::stderr().is_terminal();
    if terminal {
        shown().line = Some(new_line());
    }
    shown().due = Some(Instant::now() + FIRST_WRITTEN);
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(DRAWN_EVERY);
            let mut shown = shown();
            let Some(text) = describe(&shown.tasks) else {
                continue;
            };
            match &shown.line {
                Some(line) => {
                    line.set_message(text);
                    line.tick();
                }
                None if shown.due.is_none_or(|due| due <= Instant::now()) => {
                    eprintln!("{text}");
                    shown.due = Some(Instant::now() + WRITTEN_EVERY);
                }
                None => {}
            }
        }
    });
}

/// Notes that a line was printed: the next line of progress can wait.
pub fn postpone_output() {
    shown().due = Some(Instant::now() + WRITTEN_EVERY);
}

/// Prints while the line of progress is off the terminal.
pub fn print_above(print: impl FnOnce()) {
    match &shown().line {
        Some(line) => line.suspend(print),
        None => print(),
    }
}

fn new_line() -> ProgressBar {
    let line = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
        line.set_style(style);
    }
    line
}

/// Returns all labels, and the progress of the last task.
fn describe(tasks: &[Task]) -> Option<String> {
    let (last, unit) = tasks.last()?;
    let labels = tasks
        .iter()
        .map(|(task, _)| task.prefix())
        .filter(|label| !label.is_empty());
    let state = state(
        last.position(),
        last.length().unwrap_or(0),
        unit,
        last.elapsed(),
    );
    Some(format!(
        "{}: {state}{}",
        labels.collect::<Vec<_>>().join(", "),
        last.message()
    ))
}

/// Formats progress, such as "45 % of 27.0 million samples, 1.20 million/s, 12 s left". The rate is
/// the mean since the beginning; the remaining time follows from it.
pub fn state(done: u64, size: u64, unit: &str, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs_f64();
    if size == 0 {
        let count = match done {
            0 => String::new(),
            _ => format!("{} {unit}, ", quantity(done as f64)),
        };
        return count + &duration(seconds);
    }
    let mut text = format!(
        "{:.0} % of {} {unit}",
        // Unfinished work never shows as 100 %.
        (100.0 * done as f64 / size as f64).floor(),
        quantity(size as f64)
    );
    if done > 0 && seconds > 0.0 {
        let rate = done as f64 / seconds;
        text += &if rate >= 1.0 {
            format!(", {}/s", quantity(rate))
        } else {
            format!(", {:.1} per minute", 60.0 * rate)
        };
        text += &format!(
            ", {} left",
            duration(size.saturating_sub(done) as f64 / rate)
        );
    }
    text
}

/// Formats a number with three digits and a word.
fn quantity(value: f64) -> String {
    let scales = [
        (1e12, " trillion"),
        (1e9, " billion"),
        (1e6, " million"),
        (1e3, " thousand"),
    ];
    // Four digits need no word.
    let scale = scales
        .into_iter()
        .find(|&(unit, _)| value >= f64::max(unit, 1e4));
    match scale.map(|(unit, word)| (value / unit, word)) {
        None if value < 10.0 && value.fract() > 0.0 => format!("{value:.1}"),
        None => format!("{value:.0}"),
        Some((v, word)) if v < 10.0 => format!("{v:.2}{word}"),
        Some((v, word)) if v < 100.0 => format!("{v:.1}{word}"),
        Some((v, word)) => format!("{v:.0}{word}"),
    }
}

fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

/// Progress of a task, shown after [`show`] was called and until this is dropped.
pub struct Bar {
    task: ProgressBar,
    /// When the error was last computed.
    reckoned: Instant,
}

/// Interval at which the error over all pixels, which is costly, is computed.
const ERROR_EVERY: Duration = Duration::from_secs(2);

impl Bar {
    /// Creates a bar for `size` units; for 0, one without an end. The label may be empty.
    pub fn new(label: &str, size: u64, unit: &'static str) -> Self {
        let task = ProgressBar::with_draw_target(Some(size), ProgressDrawTarget::hidden());
        let task = task.with_prefix(label.to_owned());
        shown().tasks.push((task.clone(), unit));
        Self {
            task,
            reckoned: Instant::now(),
        }
    }

    /// Counts samples; false after a signal to end.
    pub fn advance(&self, samples: u64) -> bool {
        self.task.inc(samples);
        !interrupted()
    }

    /// Shows the mean relative standard error of the pixels, from time to time.
    pub fn error(&mut self, relative: impl FnOnce() -> f64) {
        if self.reckoned.elapsed() >= ERROR_EVERY {
            self.reckoned = Instant::now();
            let error = relative();
            let is_known = error > 0.0 && error.is_finite();
            self.task.set_message(if is_known {
                format!(", error {:.2} %", 100.0 * error)
            } else {
                String::new()
            });
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.task.abandon();
        let mut shown = shown();
        shown.tasks.retain(|(task, _)| !task.is_finished());
        if shown.tasks.is_empty()
            && let Some(line) = &mut shown.line
        {
            // The next output replaces the line.
            line.finish_and_clear();
            *line = new_line();
        }
    }
}
