//! Previews of an unfinished image: a PNG that is refreshed, and the viewer tev.

use std::io::{Error as IoError, ErrorKind, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::DVec3;
use whitefurnace::error::Error;
use whitefurnace::film::Film;
use whitefurnace::image::{Display, write_rgb};

use super::work::Observer;

/// Shows the mean radiance of all pixels; after an error the preview stops.
type ShowImage = Box<dyn FnMut(&[DVec3]) -> Result<(), Error> + Send + Sync>;

/// Shows an image from time to time on its own thread. Rendering does not wait for it: an image
/// that comes while it is busy is skipped.
pub struct Preview {
    /// `None` while the thread is busy, and after an error.
    show: Option<ShowImage>,
    worker: Option<JoinHandle<Option<(ShowImage, Duration)>>>,
    next: Instant,
    /// Time that the last image may take.
    timeout: Duration,
    name: String,
}

/// Shortest time between two images; showing takes at most 1/[`MAX_TIME_DIVISOR`] of the time of
/// its thread.
const MIN_INTERVAL: Duration = Duration::from_secs(1);
const MAX_TIME_DIVISOR: u32 = 10;

/// Time limit for connecting to a viewer, and for sending the last image.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Default address of tev.
pub const TEV: &str = "127.0.0.1:14158";

/// Parses `HOST:PORT`.
pub fn parse_address(text: &str) -> Result<String, String> {
    let valid = text
        .rsplit_once(':')
        .filter(|(host, port)| !host.is_empty() && port.parse().is_ok_and(|n: u16| n > 0));
    valid
        .map(|_| text.to_owned())
        .ok_or_else(|| format!("must be HOST:PORT such as {TEV}"))
}

impl Preview {
    fn new(name: String, timeout: Duration, show: ShowImage) -> Self {
        Self {
            show: Some(show),
            worker: None,
            next: Instant::now() + MIN_INTERVAL,
            timeout,
            name,
        }
    }

    /// Shows the image in a PNG, which is replaced as a whole.
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

    /// Shows the image, under this name, in the tev that listens at this address.
    pub fn tev(address: &str, image: &str, size: [u32; 2]) -> Result<Self, Error> {
        let name = format!("--tev {address}");
        let failed = |what: &'static str, name: &str| {
            let name = name.to_owned();
            move |error: IoError| Error::Option(format!("{name}: {what}: {error}"))
        };
        let mut viewer = connect(address).map_err(failed("no viewer is reached there", &name))?;
        viewer
            .write_all(&create(image, size))
            .map_err(failed("the viewer accepts nothing", &name))?;
        let (image, gone) = (
            image.to_owned(),
            failed("the viewer has closed the connection", &name),
        );
        let show = move |means: &[DVec3]| {
            updates(&image, size, means)
                .try_for_each(|message| viewer.write_all(&message))
                .map_err(&gone)
        };
        Ok(Self::new(name, TIMEOUT, Box::new(show)))
    }

    /// Shows the final state of the film.
    pub fn finish(mut self, film: &Film) {
        let (start, timeout, name) = (Instant::now(), self.timeout, std::mem::take(&mut self.name));
        let in_time = |worker: &Option<JoinHandle<_>>| {
            while worker.as_ref().is_some_and(|work| !work.is_finished()) {
                if start.elapsed() > timeout {
                    eprintln!("warning: {name}: the last image was not accepted in time");
                    return false;
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            true
        };
        if in_time(&self.worker) {
            self.observe(film);
            in_time(&self.worker);
        }
    }
}

impl Observer for Preview {
    fn is_due(&self) -> bool {
        let idle = self
            .worker
            .as_ref()
            .map_or(self.show.is_some(), JoinHandle::is_finished);
        idle && Instant::now() >= self.next
    }

    fn observe(&mut self, film: &Film) {
        let mut took = Duration::ZERO;
        if let Some(Ok(Some((show, last)))) = self.worker.take().map(JoinHandle::join) {
            (self.show, took) = (Some(show), last);
        }
        let Some(mut show) = self.show.take() else {
            return;
        };
        let start = Instant::now();
        self.next = start + MIN_INTERVAL.max(took * MAX_TIME_DIVISOR);
        let means = film.means_so_far();
        self.worker = Some(std::thread::spawn(move || match show(&means) {
            Ok(()) => Some((show, start.elapsed())),
            Err(error) => {
                eprintln!("warning: {error}; the preview stops, and rendering continues");
                None
            }
        }));
    }
}

fn connect(address: &str) -> Result<TcpStream, IoError> {
    let mut failure = IoError::from(ErrorKind::AddrNotAvailable);
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, TIMEOUT) {
            Ok(stream) => return Ok(stream),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// Channels of an image; and number of pixels per message.
const CHANNELS: [&str; 3] = ["R", "G", "B"];
const PIXELS_PER_MESSAGE: usize = 1 << 16;

/// Encodes a message of tev's protocol: its length in bytes, its kind, whether the window comes to
/// the front, the image's name, and the rest. Numbers are little-endian, texts end with a zero.
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

/// Encodes the message that creates an image: size, number of channels, their names.
fn create(image: &str, [width, height]: [u32; 2]) -> Vec<u8> {
    message(4, true, image, |bytes| {
        put(bytes, &[width, height, CHANNELS.len() as u32]);
        CHANNELS.iter().for_each(|channel| put_text(bytes, channel));
    })
}

/// Encodes the messages that send the pixels, some rows at a time: number of channels, their names,
/// first pixel, size, for each channel the offset and the stride of its values among the floats;
/// the floats.
fn updates(image: &str, [width, _]: [u32; 2], means: &[DVec3]) -> impl Iterator<Item = Vec<u8>> {
    let rows = (PIXELS_PER_MESSAGE / width as usize).max(1);
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
