//! Progress bars and Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether Ctrl-C was pressed since [`catch_interrupt`].
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// From here on, the first Ctrl-C ends the work in hand, a second one the program.
pub fn catch_interrupt() {
    let handler = || {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        eprintln!("warning: Ctrl-C will end the program without writing ({error})");
    }
}

/// How a program shows progress: a bar on a terminal, nothing elsewhere.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    label: String,
}

impl Progress {
    /// Bars with a label.
    pub fn new(label: &str) -> Self {
        Self {
            label: label.to_owned(),
        }
    }

    /// A bar for so many samples.
    pub fn bar(&self, samples: u64) -> Bar {
        let bar = ProgressBar::new(samples);
        let template = "{prefix} {percent:>3}% {bar:24} {human_pos} of {human_len} samples, \
                        {per_sec}, {eta} left{msg}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.set_prefix(self.label.clone());
        Bar {
            bar,
            shown: Instant::now(),
        }
    }
}

/// One bar.
pub struct Bar {
    bar: ProgressBar,
    /// When the error was last shown.
    shown: Instant,
}

/// The error over all pixels is costly: it is shown about this often.
const ERROR_EVERY: Duration = Duration::from_secs(2);

impl Bar {
    /// Counts samples; false after Ctrl-C.
    pub fn advance(&self, samples: u64) -> bool {
        self.bar.inc(samples);
        !interrupted()
    }

    /// Shows the mean relative standard error of the pixels, from time to time.
    pub fn error(&mut self, relative: impl FnOnce() -> f64) {
        if self.bar.is_hidden() || self.shown.elapsed() < ERROR_EVERY {
            return;
        }
        self.shown = Instant::now();
        let relative = relative();
        if relative.is_finite() {
            self.bar
                .set_message(format!(", error {:.2} %", 100.0 * relative));
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
