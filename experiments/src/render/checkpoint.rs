//! Checkpoints of an unfinished run, from which it can be resumed: see [`write_checkpoint`].

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use whitefurnace::camera::Camera;
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::Display;
use whitefurnace::render::checkpoint::{Attributes, read_checkpoint, write_checkpoint};

use super::{Job, Observer};

/// Replications of a job that one film holds, and the number of all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReplicationRange {
    /// Replications of the film.
    pub range: Range<u32>,
    /// Number of all replications.
    pub total: u32,
}

impl ReplicationRange {
    fn parse(text: &str) -> Option<Self> {
        let (range, total) = text.split_once(" of ")?;
        let (start, end) = range.split_once("..")?;
        let part = Self {
            range: start.parse().ok()?..end.parse().ok()?,
            total: total.parse().ok()?,
        };
        (part.range.start < part.range.end && part.range.end <= part.total).then_some(part)
    }
}

impl std::fmt::Display for ReplicationRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}..{} of {}",
            self.range.start, self.range.end, self.total
        )
    }
}

/// A film that is unfinished or a part of a whole, and the job it belongs to.
pub struct Checkpoint {
    /// Accumulated samples.
    pub film: Film,
    /// [Provenance](Job::provenance) of the job.
    pub job: String,
    /// Replications that the film is to hold.
    pub part: ReplicationRange,
    /// Display transform of the film's PNG.
    pub display: Display,
    /// Camera of the job's scene.
    pub camera: Camera,
}

impl Checkpoint {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let (film, mut attributes) = read_checkpoint(path)?;
        let mut attribute = |name| attributes.remove(name).unwrap_or_default();
        let (job, part, display) = (
            attribute("provenance"),
            ReplicationRange::parse(&attribute("replications")),
            attribute("display"),
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

    /// Returns the attributes that are written with the film.
    pub fn attributes(
        job: &Job,
        camera: &Camera,
        part: &ReplicationRange,
        exposure: f64,
    ) -> Attributes {
        let display = match job.display(exposure) {
            Display::Srgb { exposure } => format!("exposure {exposure}"),
            Display::Truncated => "truncated".to_owned(),
        };
        let provenance = job.provenance(camera, false);
        let attributes = [
            ("provenance", provenance),
            ("replications", part.to_string()),
            ("display", display),
        ];
        attributes
            .map(|(name, text)| (name.to_owned(), text))
            .into()
    }
}

/// Describes the lines in which two provenances differ; `None` if there are none.
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

/// Largest amount of unsaved work that a kill may cost, less a second for the samples in progress.
const MAX_LOSS: Duration = Duration::from_secs(9);
/// Saving takes at most 1/[`MAX_SAVE_TIME_DIVISOR`] of the time, where [`MAX_LOSS`] allows it, and
/// happens at most once per [`MIN_SAVE_INTERVAL`].
const MAX_SAVE_TIME_DIVISOR: u32 = 100;
const MIN_SAVE_INTERVAL: Duration = Duration::from_secs(1);

/// The film that was saved, how long saving took, and its result.
type SaveResult = (Film, Duration, Result<(), Error>);

/// Saves a film from time to time while rendering continues.
pub struct CheckpointWriter {
    path: PathBuf,
    attributes: Attributes,
    next: Instant,
    saving: Option<JoinHandle<SaveResult>>,
    /// The last saved film, whose memory is reused for the next.
    copy: Option<Film>,
    failing: bool,
}

impl CheckpointWriter {
    /// Saves to this file, with these attributes.
    pub fn new(path: PathBuf, attributes: Attributes) -> Self {
        Self {
            path,
            attributes,
            next: Instant::now() + MIN_SAVE_INTERVAL,
            saving: None,
            copy: None,
            failing: false,
        }
    }

    /// Waits for the last file. A full disk does not end the run: the last file that was saved
    /// stays, and saving is tried again later.
    pub fn finish(&mut self) -> Duration {
        let Some(Ok((copy, took, result))) = self.saving.take().map(JoinHandle::join) else {
            return Duration::ZERO;
        };
        self.warn_once(result);
        self.copy = Some(copy);
        took
    }

    /// Warns of the first failure after a success.
    fn warn_once(&mut self, result: Result<(), Error>) {
        let failing = result.is_err();
        match result {
            Err(error) if !self.failing => {
                eprintln!(
                    "warning: {error}; the last saved file stays, rendering continues, and saving is tried again"
                );
            }
            _ => {}
        }
        self.failing = failing;
    }
}

impl Observer for CheckpointWriter {
    /// Returns true if it is time to save, and the last file has been written.
    fn is_due(&self) -> bool {
        Instant::now() >= self.next && self.saving.as_ref().is_none_or(JoinHandle::is_finished)
    }

    fn observe(&mut self, film: &Film) {
        let took = self.finish();
        let start = Instant::now();
        // A kill costs all work since the last file, including the time that writing takes.
        let most = MAX_LOSS.saturating_sub(took).max(took);
        self.next = start + (took * MAX_SAVE_TIME_DIVISOR).clamp(MIN_SAVE_INTERVAL.min(most), most);
        let copy = match self.copy.take() {
            Some(mut copy) => {
                copy.assign(film);
                copy
            }
            None => film.clone(),
        };
        let (path, attributes) = (self.path.clone(), self.attributes.clone());
        let saver = std::thread::Builder::new()
            .name("saver".to_owned())
            .spawn(move || {
                let result = write_checkpoint(&path, &copy, &attributes);
                (copy, start.elapsed(), result)
            });
        match saver {
            Ok(saver) => self.saving = Some(saver),
            Err(error) => self.warn_once(Err(Error::file("write", &self.path)(error))),
        }
    }
}
