//! Choice of the channels of an EXR that are the image.

use std::io::Cursor;

use exr::compression::Compression;
use exr::meta::attribute::EnvironmentMap;
use exr::prelude::{FlatSamples, MetaData, ReadChannels as _, ReadLayers as _, read};

use super::{ChannelKind, FLOAT_ROUNDING, LoadedImage, REC_709, check_size, list_names};
use crate::math::HALF_ROUNDING;

/// Largest relative error of 32-bit floats that PXR24 rounds to 24 bits, plus that of sums.
const PXR24_ROUNDING: f64 = 1.0 / 65_536.0 + FLOAT_ROUNDING;

/// A channel of a file.
struct Channel {
    /// Index of its part, and index within the part.
    index: [usize; 2],
    /// Full name, with that of the part if there are several.
    name: String,
    /// Text before the last dot of the name; empty without one.
    layer: String,
    /// Text after the last dot, in lower case, without dots and brackets.
    component: String,
}

impl Channel {
    fn new(index: [usize; 2], name: String) -> Self {
        let dot = name
            .rfind('.')
            .filter(|&dot| dot > 0 && dot + 1 < name.len());
        let (layer, component) =
            dot.map_or(("", &name[..]), |dot| (&name[..dot], &name[dot + 1..]));
        let component = component.trim_matches(['.', '[', ']']).to_lowercase();
        Self {
            index,
            layer: layer.to_owned(),
            component,
            name,
        }
    }

    /// Returns whether its own name marks it as auxiliary, such as alpha or depth.
    fn is_auxiliary(&self) -> bool {
        ["a", "alpha", "z", "zback", "depth", "id"].contains(&&self.component[..])
    }
}

/// Names of red, green, blue and luminance channels.
const RED: &[&str] = &["r", "red"];
const GREEN: &[&str] = &["g", "green"];
const BLUE: &[&str] = &["b", "blue"];
const LUMINANCE: &[&str] = &["y", "l", "luminance", "grey", "gray"];

/// Words in the names of layers that are not the image, followed by names that are such words as a
/// whole.
const AUXILIARY: [&str; 8] = [
    "normal",
    "albedo",
    "depth",
    "crypto",
    "variance",
    "stderr",
    "samplecount",
    "velocity",
];
const AUXILIARY_WORDS: [&str; 24] = [
    "n", "ns", "ng", "nn", "p", "pos", "position", "z", "uv", "st", "id", "ao", "std", "mse",
    "var", "error", "motion", "samples", "vector", "matte", "mask", "mist", "indexob", "indexma",
];

/// Returns whether a layer's name marks it as auxiliary.
fn is_auxiliary_layer(layer: &str) -> bool {
    let layer = layer.to_lowercase();
    let whole = layer
        .split(|c: char| !c.is_alphanumeric())
        .any(|word| AUXILIARY_WORDS.contains(&word));
    whole || AUXILIARY.iter().any(|word| layer.contains(word))
}

/// Returns the interpretation of the channels and their order if they make exactly one image; else
/// `None`.
fn interpret<'a>(channels: &[&'a Channel]) -> Option<(ChannelKind, Vec<&'a Channel>)> {
    let has = |component: &str| {
        channels
            .iter()
            .any(|channel| channel.component == component)
    };
    let all = |names: &[&[&str]]| -> Option<Vec<&'a Channel>> {
        let one = |names: &&[&str]| {
            let mut found = channels
                .iter()
                .filter(|channel| names.contains(&&channel.component[..]));
            found.next().filter(|_| found.next().is_none()).copied()
        };
        names.iter().map(one).collect()
    };
    let colours = [RED, GREEN, BLUE].map(|names| names.iter().any(|name| has(name)));
    if colours.contains(&true) {
        return Some((ChannelKind::Rgb, all(&[RED, GREEN, BLUE])?));
    }
    let vector = all(&[&["x"], &["y"], &["z"]]).map(|found| (ChannelKind::Xyz, found));
    let is_more = has("x") || has("ry") || has("by");
    vector.or_else(|| {
        all(&[LUMINANCE])
            .filter(|_| !is_more)
            .map(|found| (ChannelKind::Luminance, found))
    })
}

/// Chooses the channels that `layer` names, or without it those that are the image.
fn choose_channels<'a>(
    channels: &'a [Channel],
    layer: Option<&str>,
    option: &str,
) -> Result<(ChannelKind, Vec<&'a Channel>), String> {
    let mut names: Vec<&str> = channels
        .iter()
        .map(|channel| channel.layer.as_str())
        .collect();
    names.sort_unstable();
    names.dedup();
    let of = |name: &str| -> Vec<&Channel> {
        channels
            .iter()
            .filter(|channel| channel.layer == name)
            .collect()
    };
    let found = match layer {
        Some(layer) => names
            .contains(&layer)
            .then(|| interpret(&of(layer)))
            .flatten()
            .or_else(|| find_named(channels, layer)),
        None => {
            let is_candidate = |name: &&&str| {
                !is_auxiliary_layer(name) && !of(name).iter().all(|channel| channel.is_auxiliary())
            };
            let candidates: Vec<&&str> = names.iter().filter(is_candidate).collect();
            let root = interpret(&of("")).filter(|(kind, _)| *kind == ChannelKind::Rgb);
            root.or_else(|| match candidates[..] {
                // A layer of X, Y, Z may be any vector.
                [one] => interpret(&of(one))
                    .filter(|(kind, _)| one.is_empty() || *kind != ChannelKind::Xyz),
                _ => None,
            })
        }
    };
    if let Some(found) = found {
        return Ok(found);
    }
    let chosen = layer.unwrap_or_default();
    let has = |component| {
        channels
            .iter()
            .any(|channel| channel.layer == chosen && channel.component == component)
    };
    if has("y") && has("ry") && has("by") {
        return Err(
            "luminance and chroma, channels Y, RY and BY, are not read: write R, G and B"
                .to_owned(),
        );
    }
    let problem = match layer {
        Some(layer) => format!("no layer {layer:?} of channels R, G, B, or Y, or X, Y, Z"),
        None => "which channels are the image is not clear".to_owned(),
    };
    let works = |name: &&str| {
        let (_, found) = interpret(&of(name))?;
        let full: Vec<&str> = found.iter().map(|channel| channel.name.as_str()).collect();
        Some(if name.is_empty() {
            full.join(",")
        } else {
            (*name).to_owned()
        })
    };
    let layers: Vec<String> = names.iter().filter_map(works).collect();
    Err(if layers.is_empty() {
        let full: Vec<String> = channels
            .iter()
            .map(|channel| channel.name.clone())
            .collect();
        format!(
            "{problem}; choose one or three channels, with commas, by {option} among: {}",
            list_names(&full)
        )
    } else {
        format!(
            "{problem}; choose by {option} among: {}",
            list_names(&layers)
        )
    })
}

/// Finds one or three channels by their full names.
fn find_named<'a>(channels: &'a [Channel], names: &str) -> Option<(ChannelKind, Vec<&'a Channel>)> {
    let one = |name: &str| {
        let mut found = channels
            .iter()
            .filter(|channel| channel.name == name.trim());
        found.next().filter(|_| found.next().is_none())
    };
    let found: Vec<&Channel> = names.split(',').map(one).collect::<Option<_>>()?;
    let is = |names: &[&[&str]]| {
        found
            .iter()
            .zip(names)
            .all(|(channel, names)| names.contains(&&channel.component[..]))
    };
    match found.len() {
        1 => Some((
            if is(&[LUMINANCE]) {
                ChannelKind::Luminance
            } else {
                ChannelKind::Grey
            },
            found,
        )),
        3 if is(&[RED, GREEN, BLUE]) => Some((ChannelKind::Rgb, found)),
        3 if is(&[&["x"], &["y"], &["z"]]) => Some((ChannelKind::Xyz, found)),
        3 => Some((ChannelKind::Three, found)),
        _ => None,
    }
}

/// Reads an EXR; see [`decode`](super::decode).
///
/// # Errors
/// A message.
pub(super) fn exr(bytes: &[u8], layer: Option<&str>, option: &str) -> Result<LoadedImage, String> {
    let text = |error: exr::error::Error| {
        let message = error.to_string();
        if message.contains("missing bytes") {
            "the file ends before its pixels do: has it been cut off, or is it still being written?"
                .to_owned()
        } else {
            message
        }
    };
    for header in MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(text)?
        .headers
    {
        check_size(header.layer_size.0.checked_mul(header.layer_size.1))?;
        if header.deep {
            return Err("deep data: write it flat".to_owned());
        }
        if let Some(channel) = header
            .channels
            .list
            .iter()
            .find(|channel| (channel.sampling.0, channel.sampling.1) != (1, 1))
        {
            return Err(format!(
                "channel {} has fewer values than pixels: write R, G and B of full size",
                channel.name
            ));
        }
    }
    let reader = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes();
    let file = reader.from_buffered(Cursor::new(bytes)).map_err(text)?;
    let parts = &file.layer_data;
    let mut channels = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let prefix = part
            .attributes
            .layer_name
            .as_ref()
            .filter(|_| parts.len() > 1);
        let prefix = prefix.map_or(String::new(), |name| format!("{name}."));
        for (k, channel) in part.channel_data.list.iter().enumerate() {
            let name = channel.name.to_string();
            let name = if name.starts_with(&prefix) {
                name
            } else {
                prefix.clone() + &name
            };
            channels.push(Channel::new([i, k], name));
        }
    }
    // Channels without a layer may also be addressed by the name of the only part.
    let only = if let [part] = &parts[..] {
        part.attributes.layer_name.as_ref().map(ToString::to_string)
    } else {
        None
    };
    let root = only.filter(|only| {
        layer == Some(only) && channels.iter().all(|channel| channel.layer != *only)
    });
    let (kind, chosen) = match root.and_then(|_| {
        interpret(
            &channels
                .iter()
                .filter(|c| c.layer.is_empty())
                .collect::<Vec<_>>(),
        )
    }) {
        Some(found) => found,
        None => choose_channels(&channels, layer, option)?,
    };
    let part = &parts[chosen[0].index[0]];
    let position = part.attributes.layer_position;
    let planes = |channels: &[&Channel]| -> Result<Vec<Vec<f64>>, String> {
        let plane = |channel: &&Channel| {
            let [i, k] = channel.index;
            if (parts[i].size, parts[i].attributes.layer_position) != (part.size, position) {
                return Err(format!(
                    "channels {} and {} differ in size or place",
                    chosen[0].name, channel.name
                ));
            }
            Ok(parts[i].channel_data.list[k]
                .sample_data
                .values_as_f32()
                .map(f64::from)
                .collect())
        };
        channels.iter().map(plane).collect()
    };
    let error_of = |channel: &&Channel| {
        let layer = if channel.layer.is_empty() {
            "stderr".to_owned()
        } else {
            format!("{}.stderr", channel.layer)
        };
        channels
            .iter()
            .find(|other| other.layer == layer && other.component == channel.component)
    };
    let errors: Option<Vec<&Channel>> = chosen.iter().map(error_of).collect();
    let is_read = |channel: &Channel| {
        let read = chosen.iter().chain(errors.iter().flatten());
        read.into_iter().any(|other| other.index == channel.index)
    };
    let mut skipped_channels: Vec<String> = Vec::new();
    for channel in channels.iter().filter(|channel| !is_read(channel)) {
        let whole = channel.layer.is_empty() || channel.layer == chosen[0].layer;
        let name = if whole { &channel.name } else { &channel.layer };
        if !skipped_channels.contains(name) {
            skipped_channels.push(name.clone());
        }
    }
    let is_half = |channel: &&Channel| {
        let [i, k] = channel.index;
        matches!(
            parts[i].channel_data.list[k].sample_data,
            FlatSamples::F16(_)
        )
    };
    let compression = part.encoding.compression;
    let is_dwa = matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
    let stated = file.attributes.chromaticities;
    let primaries = stated.map_or(REC_709, |c| {
        [c.red, c.green, c.blue, c.white].map(|xy| [xy.0, xy.1])
    });
    Ok(LoadedImage {
        size: [part.size.0, part.size.1],
        corner: [position.0, position.1],
        kind,
        channels: chosen.iter().map(|channel| channel.name.clone()).collect(),
        skipped_channels,
        values: planes(&chosen)?,
        standard_errors: errors.as_deref().map(planes).transpose()?,
        rounding: match (chosen.iter().any(is_half) || is_dwa, compression) {
            (true, _) => HALF_ROUNDING,
            (false, Compression::PXR24) => PXR24_ROUNDING,
            (false, _) => FLOAT_ROUNDING,
        },
        lossy_compression: match compression {
            _ if is_dwa => Some("DWA"),
            Compression::B44 | Compression::B44A if chosen.iter().any(is_half) => Some("B44"),
            _ => None,
        },
        primaries,
        is_cube: part.attributes.environment_map == Some(EnvironmentMap::Cube),
    })
}
