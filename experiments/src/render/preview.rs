//! An image is seen while it is made: in a PNG that is refreshed, and by the viewer tev.

use std::io::{Error as IoError, ErrorKind, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::{Display, write_rgb};

use super::work::Look;

/// Shows the mean radiance of all pixels; an error ends that.
type Show = Box<dyn FnMut(&[DVec3]) -> Result<(), Error> + Send + Sync>;

/// Something that shows an image from time to time, on a thread of its own: while that is at work,
/// however long, no image waits for it.
pub struct Preview {
    /// `None` while it is at work, and after an error.
    show: Option<Show>,
    at_work: Option<JoinHandle<Option<(Show, Duration)>>>,
    next: Instant,
    /// How long the last image may take.
    patience: Duration,
    name: String,
}

/// Showing happens at most so often, and takes at most this share of the time of a thread.
const EVERY: Duration = Duration::from_secs(1);
const SHARE: u32 = 10;

/// How long a viewer may take to be reached, and to take the last image.
const PATIENCE: Duration = Duration::from_secs(5);

/// Where tev listens unless it is told otherwise.
pub const TEV: &str = "127.0.0.1:14158";

/// Parses `HOST:PORT`.
pub fn parse_address(text: &str) -> Result<String, String> {
    let legal = text
        .rsplit_once(':')
        .filter(|(host, port)| !host.is_empty() && port.parse().is_ok_and(|n: u16| n > 0));
    legal
        .map(|_| text.to_owned())
        .ok_or_else(|| format!("must be HOST:PORT such as {TEV}"))
}

impl Preview {
    fn new(name: String, patience: Duration, show: Show) -> Self {
        Self {
            show: Some(show),
            at_work: None,
            next: Instant::now() + EVERY,
            patience,
            name,
        }
    }

    /// In a PNG, which is replaced as a whole.
    pub fn png(path: PathBuf, size: [u32; 2], display: Display) -> Self {
        let show = move |means: &[DVec3]| {
            let rgb: Vec<u8> = means
                .iter()
                .flat_map(|mean| mean.to_array().map(|value| display.encode(value)))
                .collect();
            write_rgb(&path, size, &rgb)
        };
        Self::new("--preview".to_owned(), Duration::MAX, Box::new(show))
    }

    /// By the tev that listens at this address, as an image of this name.
    pub fn tev(address: &str, image: &str, size: [u32; 2]) -> Result<Self, Error> {
        let name = format!("--tev {address}");
        let failed = |what: &'static str, name: &str| {
            let name = name.to_owned();
            move |error: IoError| Error::Option(format!("{name}: {what}: {error}"))
        };
        let mut viewer = connect(address).map_err(failed("no viewer is reached there", &name))?;
        viewer
            .write_all(&create(image, size))
            .map_err(failed("the viewer takes nothing", &name))?;
        let (image, gone) = (image.to_owned(), failed("the viewer is gone", &name));
        let show = move |means: &[DVec3]| {
            updates(&image, size, means)
                .try_for_each(|message| viewer.write_all(&message))
                .map_err(&gone)
        };
        Ok(Self::new(name, PATIENCE, Box::new(show)))
    }

    /// Shows what the film is at the end.
    pub fn finish(mut self, film: &Film) {
        let (start, patience, name) = (
            Instant::now(),
            self.patience,
            std::mem::take(&mut self.name),
        );
        let in_time = |at_work: &Option<JoinHandle<_>>| {
            while at_work.as_ref().is_some_and(|work| !work.is_finished()) {
                if start.elapsed() > patience {
                    eprintln!("warning: {name}: the last image was not taken in time");
                    return false;
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            true
        };
        if in_time(&self.at_work) {
            self.look(film);
            in_time(&self.at_work);
        }
    }
}

impl Look for Preview {
    fn due(&self) -> bool {
        let idle = self
            .at_work
            .as_ref()
            .map_or(self.show.is_some(), JoinHandle::is_finished);
        idle && Instant::now() >= self.next
    }

    fn look(&mut self, film: &Film) {
        let mut took = Duration::ZERO;
        if let Some(Ok(Some((show, last)))) = self.at_work.take().map(JoinHandle::join) {
            (self.show, took) = (Some(show), last);
        }
        let Some(mut show) = self.show.take() else {
            return;
        };
        let start = Instant::now();
        self.next = start + EVERY.max(took * SHARE);
        let means = film.means_so_far();
        self.at_work = Some(std::thread::spawn(move || match show(&means) {
            Ok(()) => Some((show, start.elapsed())),
            Err(error) => {
                eprintln!("warning: {error}; it is shown there no more, and work goes on");
                None
            }
        }));
    }
}

fn connect(address: &str) -> Result<TcpStream, IoError> {
    let mut failure = IoError::from(ErrorKind::AddrNotAvailable);
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => return Ok(stream),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// The channels of an image, and pixels of it in a message.
const CHANNELS: [&str; 3] = ["R", "G", "B"];
const AT_ONCE: usize = 1 << 16;

/// A message of tev's protocol: its length in bytes, its kind, whether the window comes to the
/// front, the image's name, and more. Numbers have their lowest byte first, texts end with a zero.
fn message(kind: u8, front: bool, image: &str, rest: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = vec![0, 0, 0, 0, kind, front.into()];
    put_text(&mut bytes, image);
    rest(&mut bytes);
    let length = bytes.len() as u32;
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    bytes
}

fn put_text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend(text.bytes().chain([0]));
}

fn put(bytes: &mut Vec<u8>, numbers: &[u32]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

/// An image of this size: size, number of channels, their names.
fn create(image: &str, [width, height]: [u32; 2]) -> Vec<u8> {
    message(4, true, image, |bytes| {
        put(bytes, &[width, height, CHANNELS.len() as u32]);
        CHANNELS.iter().for_each(|channel| put_text(bytes, channel));
    })
}

/// Its pixels, some rows at a time: number of channels, their names, first pixel, size, for each
/// channel where among the floats it begins, and how far it is from one of its values to the next;
/// the floats.
fn updates(image: &str, [width, _]: [u32; 2], means: &[DVec3]) -> impl Iterator<Item = Vec<u8>> {
    let rows = (AT_ONCE / width as usize).max(1);
    means
        .chunks(rows * width as usize)
        .enumerate()
        .map(move |(at, part)| {
            message(6, false, image, |bytes| {
                put(bytes, &[CHANNELS.len() as u32]);
                CHANNELS.iter().for_each(|channel| put_text(bytes, channel));
                put(
                    bytes,
                    &[0, (at * rows) as u32, width, part.len() as u32 / width],
                );
                [0_u64, 1, 2, 3, 3, 3]
                    .iter()
                    .for_each(|number| bytes.extend(number.to_le_bytes()));
                let floats = part
                    .iter()
                    .flat_map(|mean| mean.to_array())
                    .map(|value| value as f32);
                bytes.extend(floats.flat_map(f32::to_le_bytes));
            })
        })
}
