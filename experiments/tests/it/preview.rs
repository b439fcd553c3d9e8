//! Tests that a preview shows the image while it is made, without changing its bytes.

use std::io::Read as _;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};

use whitefurnace::image::read::decode;

use crate::signals::{ENDLESS, Running};
use crate::{folder, refused, render, renders, text};

/// A message of tev's protocol, parsed according to its description.
struct Message {
    bytes: Vec<u8>,
    at: usize,
}

impl Message {
    fn read(stream: &mut TcpStream) -> Option<Self> {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut bytes).ok()?;
        Some(Self { bytes, at: 0 })
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.at += N;
        self.bytes[self.at - N..self.at]
            .try_into()
            .expect("as many")
    }

    fn numbers<const N: usize>(&mut self) -> [usize; N] {
        [0; N].map(|_| i32::from_le_bytes(self.take()) as usize)
    }

    fn text(&mut self) -> String {
        let length = self.bytes[self.at..]
            .iter()
            .position(|byte| *byte == 0)
            .expect("an end");
        self.at += length + 1;
        text(&self.bytes[self.at - 1 - length..self.at - 1])
    }
}

/// Starts a viewer of one image, which sends its content whenever the last row has arrived.
fn viewer(image: &'static str, size: [usize; 2]) -> (String, Receiver<Vec<f32>>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let (shown, images) = channel();
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a renderer");
        let mut create = Message::read(&mut stream).expect("a message");
        assert_eq!((create.take(), create.text()), ([4, 1], image.to_owned()));
        assert_eq!(create.numbers(), [size[0], size[1], 3]);
        assert_eq!([0; 3].map(|_| create.text()), ["R", "G", "B"]);
        assert_eq!(create.at, create.bytes.len());
        let mut floats = vec![f32::NAN; 3 * size[0] * size[1]];
        while let Some(mut update) = Message::read(&mut stream) {
            assert_eq!((update.take(), update.text()), ([6, 0], image.to_owned()));
            assert_eq!(update.numbers(), [3]);
            assert_eq!([0; 3].map(|_| update.text()), ["R", "G", "B"]);
            let [x, y, width, height] = update.numbers();
            let [offsets, strides] =
                [0; 2].map(|_| [0; 3].map(|_| i64::from_le_bytes(update.take()) as usize));
            let (values, []) = update.bytes[update.at..].as_chunks() else {
                panic!("half a float")
            };
            assert!(
                values.len() == 3 * width * height && x + width <= size[0] && y + height <= size[1]
            );
            for pixel in 0..width * height {
                let there = (y + pixel / width) * size[0] + x + pixel % width;
                for channel in 0..3 {
                    let value = values[offsets[channel] + pixel * strides[channel]];
                    floats[3 * there + channel] = f32::from_le_bytes(value);
                }
            }
            if y + height == size[1] && shown.send(floats.clone()).is_err() {
                return;
            }
        }
    });
    (address, images)
}

/// Returns R, G and B of each pixel of a file.
fn pixels(path: &Path) -> Vec<f32> {
    let picture =
        decode(path, &std::fs::read(path).expect("there"), None, "--layer").expect("an image");
    let [red, green, blue] = [0, 1, 2].map(|channel| &picture.values[channel]);
    red.iter()
        .zip(green)
        .zip(blue)
        .flat_map(|((r, g), b)| [*r as f32, *g as f32, *b as f32])
        .collect()
}

#[test]
fn what_is_seen_ends_as_the_image_and_changes_none_of_its_bytes() {
    let folder = folder("previews");
    let bytes = |file: &str| std::fs::read(folder.join(file)).expect("there");
    // More rows than a message holds; and several passes per replication.
    for (options, size) in [
        ("--scene cornell --size 300x250 --spp 4", [300, 250]),
        (
            "--scene cornell --estimator bdpt --size 12x9 --spp 8 --scrambles 2",
            [12, 9],
        ),
    ] {
        let (address, images) = viewer("a.exr", size);
        renders(
            &folder,
            &format!("{options} --out a.exr --preview view.png --tev {address}"),
        );
        renders(&folder, &format!("{options} --out b.exr"));
        assert!(
            bytes("a.exr") == bytes("b.exr") && bytes("a.png") == bytes("b.png"),
            "{options}"
        );
        assert!(bytes("view.png") == bytes("a.png"), "{options}");
        assert!(
            images.iter().last().expect("an image") == pixels(&folder.join("a.exr")),
            "{options}"
        );
    }
}

#[test]
fn what_is_seen_goes_on_while_it_is_made() {
    let folder = folder("live");
    for options in ["", "--estimator bdpt --scrambles 4 "] {
        let (address, images) = viewer("a.exr", [64, 48]);
        let words = format!("{ENDLESS}1 --preview view.png --tev {address} {options}");
        let words = if options.is_empty() {
            words
        } else {
            words.replace("4000000000", "40000")
        };
        let mut render = Running::render(&words, &folder);
        let mut seen: Vec<Vec<f32>> = Vec::new();
        while seen.len() < 3 {
            seen.push(images.recv().expect("an image"));
            let last = seen.last().expect("one");
            assert!(
                last.iter().any(|value| *value > 0.0) && !last.iter().any(|value| value.is_nan())
            );
        }
        assert!(
            seen.windows(2).all(|two| two[0] != two[1]),
            "it stands still"
        );
        assert!(folder.join("view.png").exists());
        render.signal("-TERM");
        render.wait_for("interrupted");
        assert_eq!(render.end(), Some(143));
        if options.is_empty() {
            assert!(
                images.iter().last().expect("an image") == pixels(&folder.join("a.partial.exr"))
            );
            assert_eq!(
                std::fs::read(folder.join("view.png")).expect("there"),
                std::fs::read(folder.join("a.partial.png")).expect("there")
            );
        }
    }
}

#[test]
fn a_viewer_that_is_not_there_or_goes_away_or_is_stuck() {
    let folder = folder("viewers");
    let listen = || TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = |listener: &TcpListener| listener.local_addr().expect("an address").port();
    // Nobody listens at this port, and no other test gets it.
    refused(
        &render(&folder, "--spp 1 --size 8x6 --tev localhost:1"),
        "no viewer is reached there",
    );
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 0);

    // This viewer reads nothing, and the image is larger than the system's buffer. The renderer
    // waits for it while the other viewer goes away.
    let stuck = listen();
    let options = "--scene environment --size 2000x1250 --spp 1 --out";
    let words = format!("{options} stuck.exr --tev 127.0.0.1:{}", port(&stuck));
    let mut waiting = Running::render(&words, &folder);

    let listener = listen();
    let words = format!("{ENDLESS}1 --tev localhost:{}", port(&listener));
    let mut render = Running::render(&words, &folder);
    drop(listener.accept().expect("a renderer"));
    render.wait_for("the viewer has closed the connection");
    render.wait_for("% of");
    render.signal("-TERM");
    assert_eq!(render.end(), Some(143));

    renders(&folder, &format!("{options} whole.exr"));
    waiting.wait_for("the last image was not accepted in time");
    assert_eq!(waiting.end(), Some(0));
    let bytes = |file: &str| std::fs::read(folder.join(file)).expect("there");
    assert!(bytes("stuck.exr") == bytes("whole.exr"));
}
