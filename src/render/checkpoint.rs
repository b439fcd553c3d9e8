//! Files of films that are unfinished, or a part of a whole, from which rendering resumes.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::{ChunkWriter, ChunksWriter as _};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;
use exr::prelude::{
    AttributeValue, Compression, FlatSamples, Image, LineOrder, MetaData, ReadChannels as _,
    ReadLayers as _, Text, read,
};
use glam::DVec3;

use crate::error::{Error, MAX_RADIANCE};
use crate::film::{Film, PartialReplication, Pixel, SUMS, WORDS, Window};
use crate::image::{CHANNELS, exr_error, text_attributes, values, write_atomically};

/// Text attributes of a file besides the film, by name: short texts of Latin-1.
pub type Attributes = BTreeMap<String, String>;

/// Channels beyond the sums: a pixel's sums of 64-bit floats over the passes of an unfinished
/// replication.
const PARTIAL_SUMS: [&str; 3] = ["begun.R", "begun.G", "begun.B"];
const ALL_WORDS: usize = WORDS + 2 * PARTIAL_SUMS.len();
/// Text attribute of the format itself, which describes the film.
const FILM: &str = "film";
/// Number of pixels whose words are written at once.
const BATCH_SIZE: usize = 32;
const CHECKSUM: &str = "checksum";

/// Returns the channel names of a pixel's words, in order.
fn names() -> impl Iterator<Item = String> {
    let groups = SUMS.into_iter().chain(PARTIAL_SUMS.map(|name| (name, 2)));
    groups.flat_map(|(group, words)| (0..words).map(move |word| format!("sums.{group}.{word}")))
}

/// Returns the words of the pixel with this index.
fn words(film: &Film, at: usize) -> [u32; ALL_WORDS] {
    let mut all = [0; ALL_WORDS];
    all[..WORDS].copy_from_slice(&film.pixels()[at].words());
    if let Some(partial) = &film.partial {
        let halves = partial.sums[at]
            .to_array()
            .map(f64::to_bits)
            .map(|bits| [bits as u32, (bits >> 32) as u32]);
        all[WORDS..].copy_from_slice(halves.as_flattened());
    }
    all
}

/// FNV-1a checksum by words of 64 bits, of texts and then pixels: any single changed word changes
/// it.
struct Checksum(u64);

impl Checksum {
    fn of(film: &str, attributes: &Attributes) -> Self {
        let mut checksum = Self(0xcbf2_9ce4_8422_2325);
        for text in attributes
            .iter()
            .flat_map(|(name, text)| [name.as_str(), text])
            .chain([film])
        {
            text.bytes()
                .map(u64::from)
                .chain([u64::MAX])
                .for_each(|byte| checksum.add(byte));
        }
        checksum
    }

    fn add(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    }

    fn add_pixel(&mut self, words: &[u32; ALL_WORDS]) {
        let (pairs, rest) = words.as_chunks();
        pairs
            .iter()
            .for_each(|&[low, high]| self.add(u64::from(high) << 32 | u64::from(low)));
        rest.iter().for_each(|&word| self.add(word.into()));
    }

    fn text(&self) -> String {
        format!("{:016x}", self.0)
    }
}

/// Writes a film with its exact sums, so that [`read_checkpoint`] restores the identical film.
///
/// The file is one EXR part without compression. Viewers show the channels of
/// [`write_exr`](crate::image::write_exr), for the samples so far. The others are 32-bit unsigned
/// integers: `sums.<sum>.<k>` is bits 32k to 32k + 31 of an integer in two's complement. Sums are
/// `replications`, `samples` and `hits`, counts of a pixel; `R`, `G`, `B`, over its replications,
/// of radiance in multiples of 2⁻³², and `R2`, `G2`, `B2` of its square in multiples of 2⁻⁶⁴;
/// `albedo.R` to `albedo.B`, `normal.X` to `normal.Z` and `depth`, over its hits in multiples of
/// 2⁻³²; and `begun.R` to `begun.B`, the bits of 64-bit floats: sums over the passes of an
/// unfinished replication. A channel that is 0 everywhere is left out.
///
/// The text attribute `film` holds seven numbers: width and height of the full image, x and y of
/// the window's first pixel, samples per replication, passes done of an unfinished replication,
/// pixels. `checksum` covers texts and sums. The other text attributes are `attributes`.
///
/// # Errors
/// [`Error::File`] or [`Error::Image`]; no file is left behind then, and an existing file stays as
/// it was.
pub fn write_checkpoint(path: &Path, film: &Film, attributes: &Attributes) -> Result<(), Error> {
    let [width, height] = film.resolution();
    let [x, y] = film.window().corner;
    let partial = film.partial.as_ref();
    let (samples, passes) = (
        film.samples_per_replication(),
        partial.map_or(0, |partial| partial.passes),
    );
    let film_text = format!(
        "{width} {height} {x} {y} {samples} {passes} {}",
        film.pixels().len()
    );
    let (mut checksum, mut used) = (Checksum::of(&film_text, attributes), [0; ALL_WORDS]);
    for at in 0..film.pixels().len() {
        let words = words(film, at);
        checksum.add_pixel(&words);
        used.iter_mut()
            .zip(words)
            .for_each(|(used, word)| *used |= word);
    }
    // In the order of their names, as the format requires.
    let sums = names().enumerate().filter(|&(k, _)| used[k] != 0);
    let sums = sums.map(|(k, name)| {
        (
            ChannelDescription::new(name.as_str(), SampleType::U32, false),
            k,
        )
    });
    let shown = CHANNELS.into_iter().enumerate();
    let shown = shown.map(|(k, name)| {
        (
            ChannelDescription::new(name, SampleType::F32, false),
            ALL_WORDS + k,
        )
    });
    let mut channels: Vec<(ChannelDescription, usize)> = sums.chain(shown).collect();
    channels.sort_by(|(a, _), (b, _)| a.name.cmp(&b.name));
    let (channels, columns): (_, Vec<usize>) = channels.into_iter().unzip();

    let (attributes, checksum) = (
        attributes
            .iter()
            .map(|(name, text)| (name.as_str(), text.as_str())),
        checksum.text(),
    );
    let [width, height] = film.size().map(|n| n as usize);
    let header = Header::new(Text::default(), (width, height), channels)
        .with_encoding(
            Compression::Uncompressed,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
        .with_attributes(text_attributes(
            path,
            attributes.chain([(FILM, film_text.as_str()), (CHECKSUM, &checksum)]),
        )?);
    let row = |y: usize| {
        let mut bytes = vec![0; 4 * width * columns.len()];
        // Some pixels at a time: a single one would touch as many cache lines as there are
        // channels.
        for first in (0..width).step_by(BATCH_SIZE) {
            let pixels = first..width.min(first + BATCH_SIZE);
            let pixel = |x: usize| {
                (
                    words(film, y * width + x),
                    values(&film.pixels()[y * width + x]),
                )
            };
            let pixels: Vec<_> = pixels.map(pixel).collect();
            for (channel, &k) in bytes.chunks_exact_mut(4 * width).zip(&columns) {
                let places = channel[4 * first..].as_chunks_mut().0;
                for (place, (words, values)) in places.iter_mut().zip(&pixels) {
                    let word = if k < ALL_WORDS {
                        words[k]
                    } else {
                        values[k - ALL_WORDS].to_bits()
                    };
                    *place = word.to_le_bytes();
                }
            }
        }
        CompressedScanLineBlock {
            y_coordinate: y as i32,
            compressed_pixels_le: bytes,
        }
    };
    write_atomically(path, |file| {
        let rows = |_, writer: &mut ChunkWriter<_>| {
            (0..height).try_for_each(|y| {
                let compressed_block = CompressedBlock::ScanLine(row(y));
                writer.write_chunk(
                    y,
                    Chunk {
                        layer_index: 0,
                        compressed_block,
                    },
                )
            })
        };
        exr::block::write(file, [header].into_iter().collect(), true, rows).map_err(exr_error(path))
    })
}

/// Reads a film written by [`write_checkpoint`].
///
/// # Errors
/// [`Error::File`]; [`Error::Image`] for any other file, and for one that is damaged or truncated.
pub fn read_checkpoint(path: &Path) -> Result<(Film, Attributes), Error> {
    let bytes = std::fs::read(path).map_err(Error::file("read", path))?;
    decode_checkpoint(&bytes).map_err(|message| Error::Image {
        action: "read",
        path: path.to_owned(),
        message,
    })
}

/// Decodes a file's bytes; the error is a message.
///
/// # Errors
/// A message where [`read_checkpoint`] returns [`Error::Image`].
pub fn decode_checkpoint(bytes: &[u8]) -> Result<(Film, Attributes), String> {
    let damaged = |what: &str| format!("damaged or truncated: {what}");
    let codec = |error: exr::error::Error| damaged(&error.to_string());
    let foreign = || "no film with sums, as render writes of unfinished work and shards".to_owned();
    let headers = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(codec)?
        .headers;
    let [header] = headers.as_slice() else {
        return Err(foreign());
    };
    let texts = header
        .own_attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
            _ => None,
        });
    let mut attributes: Attributes = texts.collect();
    let (Some(film_text), Some(expected)) = (attributes.remove(FILM), attributes.remove(CHECKSUM))
    else {
        return Err(foreign());
    };
    let numbers: Option<Vec<u32>> = film_text
        .split(' ')
        .map(|number| number.parse().ok())
        .collect();
    let Some(&[width, height, x, y, samples, passes, pixels]) = numbers
        .as_deref()
        .and_then(|all| <&[u32; 7]>::try_from(all).ok())
    else {
        return Err(damaged("its attribute film"));
    };
    // The promised pixels must be there before memory is allocated for them.
    let size = header.layer_size;
    let promised = size.area().checked_mul(header.channels.bytes_per_pixel);
    let is_there = header.compression == Compression::Uncompressed
        && promised.is_some_and(|n| n <= bytes.len());
    if !is_there || size.area() != pixels as usize {
        return Err(damaged("fewer pixels than its header says"));
    }
    let window = Window {
        corner: [x, y],
        size: [size.0 as u32, size.1 as u32],
    };
    let mut film = Film::new([width, height], Some(window), samples)
        .map_err(|error| damaged(&error.to_string()))?;

    let reader = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes();
    let image: Image<_> = reader.from_buffered(Cursor::new(bytes)).map_err(codec)?;
    let list = &image.layer_data.channel_data.list;
    let column = |name: String| {
        let found = list.iter().find(|channel| channel.name.eq(name.as_str()));
        found.and_then(|channel| match &channel.sample_data {
            FlatSamples::U32(words) => Some(words.as_slice()),
            _ => None,
        })
    };
    let columns: Vec<Option<&[u32]>> = names().map(column).collect();
    let words = |at: usize| -> [u32; ALL_WORDS] {
        std::array::from_fn(|k| {
            columns[k]
                .and_then(|words| words.get(at))
                .copied()
                .unwrap_or(0)
        })
    };
    let mut checksum = Checksum::of(&film_text, &attributes);
    (0..film.pixels().len()).for_each(|at| checksum.add_pixel(&words(at)));
    if checksum.text() != expected {
        return Err(damaged("its sums and texts have another checksum"));
    }
    for (at, pixel) in film.pixels_mut().iter_mut().enumerate() {
        let words = words(at);
        let sums = words.first_chunk().and_then(Pixel::from_words);
        *pixel = sums.ok_or_else(|| damaged("sums that no samples have"))?;
    }
    if passes > 0 {
        let sum = |at: usize| {
            let words = words(at);
            let float = |k: usize| {
                f64::from_bits(u64::from(words[WORDS + k + 1]) << 32 | u64::from(words[WORDS + k]))
            };
            DVec3::from_array([0, 2, 4].map(float))
        };
        let sums: Vec<DVec3> = (0..film.pixels().len()).map(sum).collect();
        let max_sum = MAX_RADIANCE * f64::from(passes);
        let is_valid = |sum: &DVec3| {
            sum.to_array()
                .iter()
                .all(|value| (-1.0..=max_sum).contains(value))
        };
        if passes >= samples || !sums.iter().all(is_valid) {
            return Err(damaged("passes that no replication has"));
        }
        film.partial = Some(PartialReplication { passes, sums });
    }
    Ok((film, attributes))
}
