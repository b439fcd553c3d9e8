//! Image files: EXR with linear radiance and its standard error, PNG for display.

pub mod read;

use std::fs::File;
use std::io::{BufWriter, Cursor, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Blocks, Compression, Encoding, FlatSamples, Image,
    Layer, LayerAttributes, LineOrder, MetaData, Text, WritableImage,
};

use glam::DVec4;

use crate::camera::Camera;
use crate::error::Error;
use crate::film::{Film, Pixel};

/// Conversion of linear radiance to 8-bit values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Display {
    /// Radiance × 2^`exposure`, clamped to 1, through the sRGB transfer curve (IEC 61966-2-1),
    /// rounded.
    Srgb {
        /// Exposure in stops.
        exposure: f64,
    },
    /// floor(255 · min(1, radiance)), as in the report's program.
    Truncated,
}

impl Display {
    /// Returns the 8-bit value of a linear radiance of at least 0.
    pub fn encode(self, radiance: f64) -> u8 {
        match self {
            Self::Srgb { exposure } => {
                let linear = (radiance * exposure.exp2()).clamp(0.0, 1.0);
                (255.0 * srgb(linear)).round() as u8
            }
            Self::Truncated => (255.0 * radiance.min(1.0)) as u8,
        }
    }
}

impl Display {
    /// Returns the mean 8-bit value of each channel over a film's pixels, as measured on the
    /// written image: each pixel's mean radiance is encoded, and the encoded values are averaged.
    pub fn encoded_mean(self, film: &Film) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in film.pixels() {
            for (sum, radiance) in sum.iter_mut().zip(pixel.mean().to_array()) {
                *sum += f64::from(self.encode(radiance));
            }
        }
        sum.map(|sum| sum / film.pixels().len() as f64)
    }
}

/// Applies the sRGB transfer curve, from linear [0, 1] to encoded [0, 1].
pub fn srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Writes the film as one EXR part of 32-bit floats: mean radiance in R, G, B (linear, not
/// clamped), its standard error in `stderr.*` ([`Pixel::standard_error`]), the number of camera
/// samples in `samples.Y`, and the first hit's `albedo.*`, `normal.*` and `depth.Z`, explained by
/// the attribute `comments`. `provenance` becomes the one text attribute of that name, `camera` the
/// standard attributes `worldToCamera` and `worldToNDC`: a point, as a row vector, times the first
/// matrix has coordinates to the right, upwards and ahead of the eye; times the second, those of
/// the image, from 0 to 1 from its top left to its bottom right corner, and the reciprocal of the
/// distance ahead.
///
/// # Errors
/// [`Error::File`] or [`Error::Image`]; no file is left behind then.
pub fn write_exr(path: &Path, film: &Film, camera: &Camera, provenance: &str) -> Result<(), Error> {
    let mut columns = CHANNELS.map(|_| Vec::with_capacity(film.pixels().len()));
    for pixel in film.pixels() {
        columns
            .iter_mut()
            .zip(values(pixel))
            .for_each(|(column, value)| column.push(value));
    }
    let channel = |(name, column)| AnyChannel::new(name, FlatSamples::F32(column));
    let [width, height] = film.size().map(|n| n as usize);
    let [to_camera, to_image] = matrices(film, camera).map(Some);
    let attributes = text_attributes(path, [("provenance", provenance)])?;
    let image = Image::from_layer(Layer::new(
        (width, height),
        LayerAttributes {
            world_to_camera: to_camera,
            world_to_normalized_device: to_image,
            ..attributes
        },
        Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
        AnyChannels::sort(CHANNELS.into_iter().zip(columns).map(channel).collect()),
    ));
    write_atomically(path, |file| {
        image.write().to_buffered(file).map_err(exr_error(path))
    })
}

/// Returns the provenance that [`write_exr`] gave a file of these bytes; `None` for any other file.
pub fn provenance(bytes: &[u8]) -> Option<String> {
    let headers = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .ok()?
        .headers;
    headers.iter().find_map(|header| {
        match header.own_attributes.other.get(&Text::from("provenance")) {
            Some(AttributeValue::Text(text)) => Some(text.to_string()),
            _ => None,
        }
    })
}

/// Names of the channels of an image.
pub(crate) const CHANNELS: [&str; 14] = [
    "R",
    "G",
    "B",
    "stderr.R",
    "stderr.G",
    "stderr.B",
    "albedo.R",
    "albedo.G",
    "albedo.B",
    "normal.X",
    "normal.Y",
    "normal.Z",
    "depth.Z",
    "samples.Y",
];

/// Returns a pixel's values in the order of [`CHANNELS`].
pub(crate) fn values(pixel: &Pixel) -> [f32; CHANNELS.len()] {
    let seen = pixel.features();
    let vectors = [
        pixel.mean(),
        pixel.standard_error(),
        seen.albedo,
        seen.normal,
    ];
    let mut values = vectors
        .into_iter()
        .flat_map(|vector| vector.to_array())
        .chain([seen.depth, f64::from(pixel.samples())]);
    CHANNELS.map(|_| values.next().unwrap_or_default() as f32)
}

/// Returns the matrices from the world to the camera and to the film, which may be a part of its
/// image; the first index is that of the row.
fn matrices(film: &Film, camera: &Camera) -> [[f32; 16]; 2] {
    let ([forward, right, up], half_height) = camera.frame();
    let [right, up, ahead] = [right, up, forward].map(|axis| axis.extend(-axis.dot(camera.eye)));
    let [width, height] = film.resolution().map(f64::from);
    let ([left, top], [across, down]) = (
        film.window().corner.map(f64::from),
        film.size().map(f64::from),
    );
    let pixels = height / (2.0 * half_height);
    let x = (right * pixels + ahead * (0.5 * width - left)) / across;
    let y = (ahead * (0.5 * height - top) - up * pixels) / down;
    let of_columns = |columns: [DVec4; 4]| std::array::from_fn(|at| columns[at % 4][at / 4] as f32);
    [
        of_columns([right, up, ahead, DVec4::W]),
        of_columns([x, y, DVec4::W, ahead]),
    ]
}

/// Explanation of the channels of [`Pixel::features`].
const COMMENTS: &str = "albedo.*, normal.* and depth.Z are means over the camera rays of a pixel that meet something, of \
                        what they meet first; 0 where none does. albedo.*: its colour, in [0, 1]. normal.*: its unit \
                        normal in world space, on the side of the camera. depth.Z: the distance from the eye along the \
                        ray, not its share along the line of sight, in the unit of the world.";

/// Returns text attributes of a file.
pub(crate) fn text_attributes<'a>(
    path: &Path,
    texts: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> Result<LayerAttributes, Error> {
    let mut attributes = LayerAttributes {
        comments: Text::new_or_none(COMMENTS),
        ..LayerAttributes::default()
    };
    for (name, text) in texts {
        let encoding_error =
            || encoding_error(path, format!("the {name} has characters outside Latin-1"));
        let text = Text::new_or_none(text).ok_or_else(encoding_error)?;
        attributes
            .other
            .insert(Text::from(name), AttributeValue::Text(text));
    }
    Ok(attributes)
}

fn encoding_error(path: &Path, message: String) -> Error {
    Error::Image {
        action: "write",
        path: path.to_owned(),
        message,
    }
}

pub(crate) fn exr_error(path: &Path) -> impl FnOnce(exr::error::Error) -> Error + '_ {
    |error| match error {
        exr::error::Error::Io(error) => Error::file("write", path)(error),
        other => encoding_error(path, other.to_string()),
    }
}

/// Writes the film's mean radiance as an 8-bit PNG, each pixel as a block of `magnification`² equal
/// ones.
///
/// # Errors
/// [`Error::File`] or [`Error::Image`]; no file is left behind then.
pub fn write_png(
    path: &Path,
    film: &Film,
    display: Display,
    magnification: u32,
) -> Result<(), Error> {
    let [width, height] = film.size().map(|n| n * magnification);
    let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let mean = film.pixel(x / magnification, y / magnification).mean();
            rgb.extend(mean.to_array().map(|radiance| display.encode(radiance)));
        }
    }
    write_rgb(path, [width, height], &rgb)
}

/// Writes 8-bit sRGB triples, row by row from the top, as a PNG of `size` pixels.
///
/// # Errors
/// [`Error::File`] or [`Error::Image`], for triples that do not fill the size, too; no file is left
/// behind then.
pub fn write_rgb(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), Error> {
    let bytes = encode_rgb(size, rgb).map_err(|error| Error::Image {
        action: "write",
        path: path.to_owned(),
        message: error.to_string(),
    })?;
    write_atomically(path, |file| {
        file.write_all(&bytes).map_err(Error::file("write", path))
    })
}

/// Encodes 8-bit sRGB triples, row by row from the top, as the bytes of a PNG.
///
/// # Errors
/// If there are not 3 × width × height values.
pub fn encode_rgb([width, height]: [u32; 2], rgb: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.write_header()?.write_image_data(rgb)?;
    Ok(bytes)
}

/// Writes a file whole or not at all: into a temporary file beside it, which is renamed once it is
/// on the disk, so that even a power cut leaves the old file or the new one.
///
/// # Errors
/// [`Error::File`] if the file cannot be created or renamed, or the error of `fill`.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), Error>,
) -> Result<(), Error> {
    let temporary = temporary_path(path);
    let result = File::create(&temporary)
        .map_err(Error::file("create", path))
        .and_then(|file| {
            let mut file = BufWriter::new(file);
            fill(&mut file)?;
            file.flush()
                .and_then(|()| file.get_ref().sync_all())
                .map_err(Error::file("write", path))
        })
        .and_then(|()| std::fs::rename(&temporary, path).map_err(Error::file("write", path)));
    if result.is_err() {
        // The first error is the one to report; there may be nothing to remove.
        drop(std::fs::remove_file(&temporary));
    }
    result
}

/// Checks, before hours of work, that `path` can be written: its folder exists or can be made,
/// takes a file, and `path` is not a folder. Removes temporary files of it that killed programs
/// left.
///
/// # Errors
/// [`Error::File`].
pub fn check_writable(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        let source = std::io::Error::from(std::io::ErrorKind::IsADirectory);
        return Err(Error::file("write", path)(source));
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(Error::file("create", folder))?;
    }
    let temporary = temporary_path(path);
    File::create(&temporary).map_err(Error::file("create", path))?;
    let folder = temporary
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    remove_temporaries(path, folder).map_err(Error::file("create", path))
}

/// Removes the temporary files of this file that killed programs left.
fn remove_temporaries(path: &Path, folder: &Path) -> std::io::Result<()> {
    let prefix = format!(".{}.", path.file_name().unwrap_or_default().display());
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if name
            .to_string_lossy()
            .strip_prefix(&prefix)
            .is_some_and(|rest| rest.ends_with(".tmp"))
        {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

fn temporary_path(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.tmp", std::process::id()));
    path.with_file_name(name)
}
