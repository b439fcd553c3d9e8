//! What a run leaves while it works, and goes on from: see [`write_unfinished`].

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use whitefurnace::camera::Camera;
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::Display;
use whitefurnace::render::checkpoint::{Notes, read_unfinished, write_unfinished};

use super::{Job, Look};

/// Replications of a job: those that a film is to have, and how many there are in all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Those of the film.
    pub range: Range<u32>,
    /// All.
    pub of: u32,
}

impl Part {
    fn parse(text: &str) -> Option<Self> {
        let (range, of) = text.split_once(" of ")?;
        let (start, end) = range.split_once("..")?;
        let part = Self {
            range: start.parse().ok()?..end.parse().ok()?,
            of: of.parse().ok()?,
        };
        (part.range.start < part.range.end && part.range.end <= part.of).then_some(part)
    }
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}..{} of {}", self.range.start, self.range.end, self.of)
    }
}

/// A film that is not finished or a part of a whole, and of what.
pub struct Unfinished {
    /// The film.
    pub film: Film,
    /// The [provenance](Job::provenance) of its job.
    pub job: String,
    /// Its replications.
    pub part: Part,
    /// How its PNG shows it.
    pub display: Display,
    /// What sees it.
    pub camera: Camera,
}

impl Unfinished {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let (film, mut notes) = read_unfinished(path)?;
        let mut note = |name| notes.remove(name).unwrap_or_default();
        let (job, part, display) = (
            note("provenance"),
            Part::parse(&note("replications")),
            note("display"),
        );
        let display = match display.strip_prefix("exposure ").map(str::parse) {
            Some(Ok(exposure)) => Some(Display::Srgb { exposure }),
            _ => (display == "truncated").then_some(Display::Truncated),
        };
        match (part, display, Camera::parse(&job)) {
            (Some(part), Some(display), Some(camera))
                if film
                    .pixels()
                    .iter()
                    .all(|pixel| pixel.replications() <= part.range.end - part.range.start) =>
            {
                Ok(Self {
                    film,
                    job,
                    part,
                    display,
                    camera,
                })
            }
            _ => Err(Error::Image {
                action: "read",
                path: path.to_owned(),
                message: "it does not say which part of an image it is".to_owned(),
            }),
        }
    }

    /// The texts that go with the film.
    pub fn notes(job: &Job, camera: &Camera, part: &Part, exposure: f64) -> Notes {
        let display = match job.display(exposure) {
            Display::Srgb { exposure } => format!("exposure {exposure}"),
            Display::Truncated => "truncated".to_owned(),
        };
        let provenance = job.provenance(camera, false);
        let notes = [
            ("provenance", provenance),
            ("replications", part.to_string()),
            ("display", display),
        ];
        notes.map(|(name, text)| (name.to_owned(), text)).into()
    }
}

/// The lines in which two provenances differ, in words.
pub fn difference(there: &str, here: &str) -> Option<String> {
    let only = |one: &str, other: &str| {
        let lines: Vec<&str> = one
            .lines()
            .filter(|line| !other.lines().any(|same| same == *line))
            .collect();
        if lines.is_empty() {
            "nothing of it".to_owned()
        } else {
            lines.join(", ")
        }
    };
    (there != here).then(|| format!("{} there, {} here", only(there, here), only(here, there)))
}

/// What a kill may cost at most, of work that is not yet on the disk; less a second for the samples
/// in hand.
const LOSS: Duration = Duration::from_secs(9);
/// Saving takes this share of the time, where the loss allows it; and happens at most so often.
const SHARE: u32 = 100;
const EVERY: Duration = Duration::from_secs(1);

/// What was saved, how long it took, and what came of it.
type Saved = (Film, Duration, Result<(), Error>);

/// Saves a film from time to time, while work goes on.
pub struct Checkpoints {
    path: PathBuf,
    notes: Notes,
    next: Instant,
    saving: Option<JoinHandle<Saved>>,
    /// The last film, whose memory the next takes.
    copy: Option<Film>,
    failing: bool,
}

impl Checkpoints {
    /// Into this file, with these texts.
    pub fn new(path: PathBuf, notes: Notes) -> Self {
        Self {
            path,
            notes,
            next: Instant::now() + EVERY,
            saving: None,
            copy: None,
            failing: false,
        }
    }

    /// Waits for the last file. A disk that is full for a while is no reason to end: what was saved
    /// stays, and the next file is tried in its time.
    pub fn finish(&mut self) -> Duration {
        let Some(Ok((copy, took, result))) = self.saving.take().map(JoinHandle::join) else {
            return Duration::ZERO;
        };
        self.said(result);
        self.copy = Some(copy);
        took
    }

    /// Warns of the first failure after a success.
    fn said(&mut self, result: Result<(), Error>) {
        let failing = result.is_err();
        match result {
            Err(error) if !self.failing => {
                eprintln!(
                    "warning: {error}; what was saved before stays, work goes on, and saving is tried again"
                );
            }
            _ => {}
        }
        self.failing = failing;
    }
}

impl Look for Checkpoints {
    /// When the last file is written, too.
    fn due(&self) -> bool {
        Instant::now() >= self.next && self.saving.as_ref().is_none_or(JoinHandle::is_finished)
    }

    fn look(&mut self, film: &Film) {
        let took = self.finish();
        let start = Instant::now();
        // A kill costs what is done until the next file is written.
        let most = LOSS.saturating_sub(took).max(took);
        self.next = start + (took * SHARE).clamp(EVERY.min(most), most);
        let copy = match self.copy.take() {
            Some(mut copy) => {
                copy.assign(film);
                copy
            }
            None => film.clone(),
        };
        let (path, notes) = (self.path.clone(), self.notes.clone());
        let saver = std::thread::Builder::new()
            .name("saver".to_owned())
            .spawn(move || {
                let result = write_unfinished(&path, &copy, &notes);
                (copy, start.elapsed(), result)
            });
        match saver {
            Ok(saver) => self.saving = Some(saver),
            Err(error) => self.said(Err(Error::file("write", &self.path)(error))),
        }
    }
}
