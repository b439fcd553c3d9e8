//! Images of any renderer: EXR of any layout that the codec decodes, and PFM.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{FlatSamples, MetaData, ReadChannels as _, ReadLayers as _, read};

use crate::error::Error;
use crate::film::LARGEST_FILM;

/// What a file says of radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [usize; 2],
    /// Where the upper left pixel lies in the frame.
    pub corner: [i32; 2],
    /// R, G and B, or Y.
    pub channels: Vec<&'static str>,
    /// The values of each channel, row by row from the top.
    pub values: Vec<Vec<f64>>,
    /// Standard errors of these, where the file has them: channels `stderr.R` and so on beside `R`.
    pub standard_errors: Option<Vec<Vec<f64>>>,
    /// How far values may be off by rounding, relative to them.
    pub rounding: f64,
}

/// Sums of many 32-bit floats are off by less than this share.
const FLOAT: f64 = 1e-5;
/// Half a unit in the last place of a 16-bit float.
const HALF: f64 = 1.0 / 2048.0;
const RGB: [&str; 3] = ["R", "G", "B"];

/// Decodes the bytes of a file, whose `path` is for messages. `layer` is what stands before the last dot of the
/// channels' names; needed where no channels are called just R, G, B or Y, and several layers have these.
///
/// # Errors
/// [`Error::Image`]: no such format, truncated, too large, no such layer, or a value that is no finite number.
pub fn decode(path: &Path, bytes: &[u8], layer: Option<&str>) -> Result<Picture, Error> {
    let decoded = match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => exr(bytes, layer),
        [b'P', b'F' | b'f', ..] if layer.is_some() => Err("a PFM has no layers".to_owned()),
        [b'P', b'F' | b'f', ..] => pfm(bytes),
        _ => Err("neither EXR nor PFM".to_owned()),
    };
    decoded.and_then(finite).map_err(|message| Error::Image { action: "read", path: path.to_owned(), message })
}

/// The same picture if all its values are finite, and all standard errors at least 0.
fn finite(picture: Picture) -> Result<Picture, String> {
    let width = picture.size[0];
    let fault = |what: &str, planes: &[Vec<f64>], good: fn(&f64) -> bool| {
        let (plane, at) = (0..planes.len()).find_map(|c| Some((c, planes[c].iter().position(|v| !good(v))?)))?;
        let (name, value) = (picture.channels[plane], planes[plane][at]);
        Some(format!("pixel ({}, {}), {what}{name}, is {value}", at % width, at / width))
    };
    let errors = picture.standard_errors.as_deref().unwrap_or_default();
    let fault = fault("", &picture.values, |value| value.is_finite())
        .or_else(|| fault("stderr.", errors, |value| value.is_finite() && *value >= 0.0));
    fault.map_or(Ok(picture), Err)
}

/// A header must not promise more than this: what is read is held in memory.
fn check_size(pixels: Option<usize>) -> Result<(), String> {
    let fits = pixels.is_some_and(|pixels| (1..=LARGEST_FILM as usize).contains(&pixels));
    if fits { Ok(()) } else { Err(format!("a size that is not from 1 to {LARGEST_FILM} pixels")) }
}

fn exr(bytes: &[u8], layer: Option<&str>) -> Result<Picture, String> {
    let text = |error: exr::error::Error| error.to_string();
    for header in MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(text)?.headers {
        check_size(header.layer_size.0.checked_mul(header.layer_size.1))?;
    }
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(text)?;
    // All channels: what stands before the last dot, the component, and where it is.
    let mut channels = Vec::new();
    for (i, part) in image.layer_data.iter().enumerate() {
        let prefix = part.attributes.layer_name.as_ref().map(|name| format!("{name}.")).unwrap_or_default();
        for (k, channel) in part.channel_data.list.iter().enumerate() {
            let name = format!("{prefix}{}", channel.name);
            let (group, component) = name.rsplit_once('.').unwrap_or(("", &name));
            channels.push((group.to_owned(), component.to_uppercase(), (i, k)));
        }
    }
    // Where the channels of a group are, if it has all of them.
    let find = |group: &str, names: &[&str]| -> Option<Vec<(usize, usize)>> {
        let one = |name: &&str| channels.iter().find(|(g, c, _)| g == group && c == name).map(|found| found.2);
        names.iter().map(one).collect()
    };
    let mut groups: Vec<&str> = channels.iter().map(|(group, ..)| group.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    let named = |names: &[&str]| -> Vec<&str> {
        let having = groups.iter().copied().filter(|group| find(group, names).is_some());
        having.filter(|group| layer.is_none_or(|layer| layer == *group)).collect()
    };
    let (names, candidates) = match named(&RGB) {
        none if none.is_empty() => (&["Y"][..], named(&["Y"])),
        some => (&RGB[..], some),
    };
    let group = match candidates[..] {
        [one] => one,
        _ if candidates.contains(&"") => "",
        _ => {
            let all: Vec<&str> = groups.into_iter().filter(|group| !group.is_empty()).collect();
            let problem = layer.map_or("no one layer with channels R, G, B, or Y".to_owned(), |layer| {
                format!("no layer {layer:?} with channels R, G, B, or Y")
            });
            return Err(format!("{problem}; choose by --layer among: {}", all.join(", ")));
        }
    };
    let places = find(group, names).unwrap_or_default();
    let part = &image.layer_data[places[0].0];
    let planes = |places: &[(usize, usize)]| -> Result<Vec<Vec<f64>>, String> {
        let plane = |&(i, k): &(usize, usize)| {
            let samples = &image.layer_data[i].channel_data.list[k].sample_data;
            let values: Vec<f64> = samples.values_as_f32().map(f64::from).collect();
            // A subsampled channel, or one of a part of another size.
            if values.len() == part.size.area() { Ok(values) } else { Err("channels of several sizes".to_owned()) }
        };
        places.iter().map(plane).collect()
    };
    let errors = if group.is_empty() { "stderr".to_owned() } else { format!("{group}.stderr") };
    let is_half =
        |&(i, k): &(usize, usize)| matches!(image.layer_data[i].channel_data.list[k].sample_data, FlatSamples::F16(_));
    let corner = part.attributes.layer_position;
    Ok(Picture {
        size: [part.size.0, part.size.1],
        corner: [corner.0, corner.1],
        channels: if names.len() == 3 { RGB.to_vec() } else { vec!["Y"] },
        values: planes(&places)?,
        standard_errors: find(&errors, names).map(|places| planes(&places)).transpose()?,
        rounding: if places.iter().any(is_half) { HALF } else { FLOAT },
    })
}

/// Portable float map: `PF` or `Pf`, width, height and a scale, whose sign is the order of the bytes, as text; then
/// rows of 32-bit floats from the bottom.
fn pfm(bytes: &[u8]) -> Result<Picture, String> {
    let mut rest = bytes;
    let mut word = || {
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let length = rest[start..].iter().position(u8::is_ascii_whitespace)?;
        let word = std::str::from_utf8(&rest[start..start + length]).ok()?;
        // One white space ends the header.
        rest = &rest[start + length + 1..];
        Some(word)
    };
    let header = (word(), word().and_then(|w| w.parse().ok()), word().and_then(|h| h.parse().ok()));
    let scale = word().and_then(|scale| scale.parse::<f64>().ok());
    let (Some(kind @ ("PF" | "Pf")), Some(width), Some(height)) = header else {
        return Err("no header of a PFM: PF or Pf, width, height, scale".to_owned());
    };
    let Some(scale) = scale.filter(|scale| scale.abs() == 1.0) else {
        return Err("the scale of the PFM is not 1.0 or -1.0".to_owned());
    };
    let channels = if kind == "PF" { RGB.to_vec() } else { vec!["Y"] };
    let pixels = usize::checked_mul(width, height);
    check_size(pixels)?;
    let expected = 4 * channels.len() * width * height;
    if rest.len() != expected {
        return Err(format!("{} bytes of pixels in place of {expected}: truncated, or another format", rest.len()));
    }
    let number = |bytes: &[u8]| {
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        f64::from(if scale < 0.0 { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) })
    };
    let plane = |channel: usize| -> Vec<f64> {
        let rows = rest.chunks_exact(4 * channels.len() * width).rev();
        rows.flat_map(|row| row.chunks_exact(4).skip(channel).step_by(channels.len()).map(number)).collect()
    };
    let values = (0..channels.len()).map(plane).collect();
    Ok(Picture { size: [width, height], corner: [0; 2], channels, values, standard_errors: None, rounding: FLOAT })
}
