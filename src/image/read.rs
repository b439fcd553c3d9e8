//! Reading of images from any renderer: EXR of any layout that the codec decodes, PFM and Radiance
//! pictures.

mod hdr;
mod layers;
mod pfm;

use std::path::Path;

use crate::error::Error;
use crate::film::MAX_FILM_PIXELS;

/// Interpretation of an image's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelKind {
    /// Linear red, green and blue.
    Rgb,
    /// CIE X, Y, Z, or another vector of that name.
    Xyz,
    /// Luminance alone.
    Luminance,
    /// One channel of any meaning.
    Grey,
    /// Three channels of any meaning, chosen by name.
    Three,
}

/// Channels of an image file: radiance, or others that were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedImage {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Position of the upper left pixel in the full image.
    pub corner: [i32; 2],
    /// Interpretation of the channels.
    pub kind: ChannelKind,
    /// Names of the channels in the file, including their layer.
    pub channels: Vec<String>,
    /// Channels and layers of the file that were not read.
    pub skipped_channels: Vec<String>,
    /// Values of each channel, row by row from the top.
    pub values: Vec<Vec<f64>>,
    /// Standard errors of the values, where the file has them: channels `stderr.R` and so on beside
    /// `R`. `None` if one is infinite, as that of a single sample.
    pub standard_errors: Option<Vec<Vec<f64>>>,
    /// Largest relative rounding error of the values.
    pub rounding: f64,
    /// Name of the file's compression, if it changes values by more than rounding.
    pub lossy_compression: Option<&'static str>,
    /// Chromaticities x, y of red, green, blue and white: [`REC_709`] if the file states none.
    pub primaries: [[f32; 2]; 4],
    /// Whether the file states that it is the six sides of a cube, seen from within.
    pub is_cube: bool,
}

/// Primaries of Rec. 709 and sRGB, the default of an EXR.
pub const REC_709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];

impl LoadedImage {
    /// Returns the label of each channel: R, G, B; X, Y, Z; Y for luminance or grey; or its name.
    pub fn labels(&self) -> Vec<&str> {
        match self.kind {
            ChannelKind::Rgb => vec!["R", "G", "B"],
            ChannelKind::Xyz => vec!["X", "Y", "Z"],
            ChannelKind::Luminance | ChannelKind::Grey => vec!["Y"],
            ChannelKind::Three => self.channels.iter().map(String::as_str).collect(),
        }
    }

    /// Returns whether it has these primaries, to three digits.
    pub fn has_primaries(&self, other: [[f32; 2]; 4]) -> bool {
        self.primaries
            .iter()
            .flatten()
            .zip(other.iter().flatten())
            .all(|(x, y)| (x - y).abs() <= 2e-3)
    }

    /// Describes which channels were read, how they are interpreted, and what else the file holds.
    pub fn describe(&self) -> String {
        let kind = match self.kind {
            ChannelKind::Rgb => "RGB",
            ChannelKind::Xyz => "X, Y, Z",
            ChannelKind::Luminance => "luminance",
            ChannelKind::Grey => "one grey channel",
            ChannelKind::Three => "three channels",
        };
        let others = if self.skipped_channels.is_empty() {
            String::new()
        } else {
            "; not read: ".to_owned()
        };
        let lossy = self.lossy_compression.map_or(String::new(), |name| {
            format!(", changed by the compression {name}, whose errors count as differences")
        });
        format!(
            "{} as {kind}{lossy}{others}{}",
            self.channels.join(", "),
            list_names(&self.skipped_channels)
        )
    }

    /// Returns the picture whose pixel at column x and row y is that of `from(x, y)` in this one.
    ///
    /// # Panics
    /// If `from` leads outside.
    #[must_use]
    pub fn remapped(&self, size: [usize; 2], from: impl Fn(usize, usize) -> [usize; 2]) -> Self {
        let index = |i: usize| {
            let [x, y] = from(i % size[0], i / size[0]);
            y * self.size[0] + x
        };
        let planes = |planes: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            planes
                .iter()
                .map(|plane| (0..size[0] * size[1]).map(|i| plane[index(i)]).collect())
                .collect()
        };
        let (values, standard_errors) = (
            planes(&self.values),
            self.standard_errors.as_ref().map(planes),
        );
        let (channels, skipped_channels) = (self.channels.clone(), self.skipped_channels.clone());
        let &Self {
            corner,
            kind,
            rounding,
            lossy_compression,
            primaries,
            is_cube,
            ..
        } = self;
        Self {
            size,
            corner,
            kind,
            channels,
            skipped_channels,
            values,
            standard_errors,
            rounding,
            lossy_compression,
            primaries,
            is_cube,
        }
    }

    /// Returns the part of this size whose upper left pixel is at `corner` of the full image.
    ///
    /// # Panics
    /// If it is not within the picture.
    #[must_use]
    pub fn cropped(&self, corner: [i32; 2], size: [usize; 2]) -> Self {
        let [left, top] =
            [0, 1].map(|i| (i64::from(corner[i]) - i64::from(self.corner[i])) as usize);
        Self {
            corner,
            ..self.remapped(size, |x, y| [x + left, y + top])
        }
    }
}

/// Lists names for a message, the first twenty of them.
fn list_names(names: &[String]) -> String {
    const MAX_NAMES: usize = 20;
    let more = names.len().saturating_sub(MAX_NAMES);
    let more = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    names[..names.len().min(MAX_NAMES)].join(", ") + &more
}

/// Largest relative error of sums of many 32-bit floats.
const FLOAT_ROUNDING: f64 = 1e-5;

/// Decodes the bytes of a file, whose `path` is for messages. `layer` is the part of the channels'
/// names before the last dot, or one or three full names of channels with commas; `option` is how a
/// user gives it, for messages.
///
/// Without `layer` the channels R, G, B outside any layer are read. If there are none, the only
/// layer of R, G, B or Y that is not known to be something else, such as normals or depth, or X, Y,
/// Z without a layer; all of these only if no other layer could be the image.
///
/// # Errors
/// [`Error::Image`] for an unknown format, a truncated or too large file, a missing layer, several
/// layers that may be the image, or a value that is not finite.
pub fn decode(
    path: &Path,
    bytes: &[u8],
    layer: Option<&str>,
    option: &str,
) -> Result<LoadedImage, Error> {
    let decoded = match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => layers::exr(bytes, layer, option),
        [b'P', b'F' | b'f', ..] | [b'#', b'?', ..] if layer.is_some() => Err(format!(
            "a PFM or Radiance picture has no layers: leave out {option}"
        )),
        [b'P', b'F' | b'f', ..] => pfm::pfm(bytes),
        [b'#', b'?', ..] => hdr::hdr(bytes),
        _ => Err("neither EXR nor PFM nor Radiance picture (.hdr)".to_owned()),
    };
    decoded
        .and_then(check_finite)
        .map_err(|message| Error::Image {
            action: "read",
            path: path.to_owned(),
            message,
        })
}

/// Checks that all values are finite, and all standard errors at least 0.
fn check_finite(mut picture: LoadedImage) -> Result<LoadedImage, String> {
    let width = picture.size[0];
    let fault = |what: &str, planes: &[Vec<f64>], good: fn(&f64) -> bool| {
        let (plane, at) =
            (0..planes.len()).find_map(|c| Some((c, planes[c].iter().position(|v| !good(v))?)))?;
        let (name, value) = (&picture.channels[plane], planes[plane][at]);
        Some(format!(
            "pixel ({}, {}), {what}{name}, is {value}",
            at % width,
            at / width
        ))
    };
    let errors = picture.standard_errors.as_deref().unwrap_or_default();
    let fault = fault("", &picture.values, |value| value.is_finite())
        .or_else(|| fault("the standard error of ", errors, |value| *value >= 0.0));
    let known = errors.iter().flatten().all(|error| error.is_finite());
    picture.standard_errors = picture.standard_errors.filter(|_| known);
    fault.map_or(Ok(picture), Err)
}

/// Refuses a header that promises too many pixels, as the image is held in memory.
fn check_size(pixels: Option<usize>) -> Result<(), String> {
    let fits = pixels.is_some_and(|pixels| (1..=MAX_FILM_PIXELS as usize).contains(&pixels));
    if fits {
        Ok(())
    } else {
        Err(format!(
            "a size that is not from 1 to {MAX_FILM_PIXELS} pixels"
        ))
    }
}
