//! Portable float maps.

use std::ops::RangeInclusive;

use super::{ChannelKind, FLOAT_ROUNDING, LoadedImage, REC_709, check_size};

/// Values that an image may have other than 0; those of the wrong byte order are often beyond.
const PLAUSIBLE: RangeInclusive<f64> = 1e-12..=1e12;

/// Reads a PFM: `PF` or `Pf`, width, height and a scale, whose sign is the byte order, as text;
/// then rows of 32-bit floats from the bottom. Lines of the text may end in CR LF, and begin with #
/// for a comment; a line end may follow the pixels.
///
/// # Errors
/// A message: no such header, a scale that is neither 1 nor -1, or pixels that do not fill the
/// size.
pub(super) fn pfm(bytes: &[u8]) -> Result<LoadedImage, String> {
    let mut at = 0;
    let mut word = || {
        loop {
            at += bytes[at..]
                .iter()
                .position(|byte| !byte.is_ascii_whitespace())?;
            if bytes[at] != b'#' {
                break;
            }
            at += bytes[at..].iter().position(|byte| *byte == b'\n')?;
        }
        let length = bytes[at..].iter().position(u8::is_ascii_whitespace)?;
        let word = std::str::from_utf8(&bytes[at..at + length]).ok()?;
        at += length;
        Some(word)
    };
    let header = (
        word(),
        word().and_then(|w| w.parse().ok()),
        word().and_then(|h| h.parse().ok()),
    );
    let scale = word().and_then(|scale| scale.parse::<f64>().ok());
    let (Some(kind @ ("PF" | "Pf")), Some(width), Some(height), Some(scale)) =
        (header.0, header.1, header.2, scale)
    else {
        return Err("no header of a PFM: PF or Pf, width, height, scale".to_owned());
    };
    if scale.abs() != 1.0 {
        return Err(format!(
            "the scale of the PFM is {scale}, by which some programs multiply its values and some do not: multiply them or \
             not, and write 1.0, or -1.0 for little-endian"
        ));
    }
    let pixels = usize::checked_mul(width, height);
    check_size(pixels)?;
    let colours = if kind == "PF" { 3 } else { 1 };
    let expected = 4 * colours * width * height;
    let rest = pixel_bytes(&bytes[at..], expected).ok_or_else(|| {
        let found = bytes.len() - at - 1;
        format!("{found} bytes of pixels in place of {expected}: truncated, or another format")
    })?;
    let decode = |bytes: &[u8], is_little_endian: bool| {
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        f64::from(if is_little_endian {
            f32::from_le_bytes(bytes)
        } else {
            f32::from_be_bytes(bytes)
        })
    };
    let number = |bytes: &[u8]| decode(bytes, scale < 0.0);
    let are_plausible = |is_little_endian: bool| {
        let mut values = rest
            .chunks_exact(4)
            .map(|bytes| decode(bytes, is_little_endian).abs());
        values.all(|value| value == 0.0 || PLAUSIBLE.contains(&value))
    };
    if !are_plausible(scale < 0.0) && are_plausible(scale > 0.0) {
        let (order, other) = if scale < 0.0 {
            ("little", "1.0")
        } else {
            ("big", "-1.0")
        };
        return Err(format!(
            "values beyond {:e} or below {:e} as {order}-endian, which the scale {scale} states, but none in the other byte \
             order: write the scale {other}",
            PLAUSIBLE.end(),
            PLAUSIBLE.start()
        ));
    }
    let plane = |channel: usize| -> Vec<f64> {
        let rows = rest.chunks_exact(4 * colours * width).rev();
        rows.flat_map(|row| {
            row.chunks_exact(4)
                .skip(channel)
                .step_by(colours)
                .map(number)
        })
        .collect()
    };
    let names = if colours == 3 {
        &["R", "G", "B"][..]
    } else {
        &["grey"]
    };
    Ok(LoadedImage {
        size: [width, height],
        corner: [0; 2],
        kind: if colours == 3 {
            ChannelKind::Rgb
        } else {
            ChannelKind::Grey
        },
        channels: names.iter().map(|name| (*name).to_owned()).collect(),
        skipped_channels: Vec::new(),
        values: (0..colours).map(plane).collect(),
        standard_errors: None,
        rounding: FLOAT_ROUNDING,
        lossy_compression: None,
        primaries: REC_709,
        is_cube: false,
    })
}

/// Returns the bytes of the pixels after the header's last word: after one white space, or the rest
/// of its line; before the end of the file, or a last line end. The number of bytes decides, as
/// pixels may look like white space.
fn pixel_bytes(rest: &[u8], expected: usize) -> Option<&[u8]> {
    let blanks = rest
        .iter()
        .take_while(|byte| matches!(byte, b' ' | b'\t'))
        .count();
    let line = match rest[blanks..] {
        [b'\r', b'\n', ..] => blanks + 2,
        _ => blanks + 1,
    };
    let starts = [1, line];
    let exact = starts
        .iter()
        .find_map(|&start| rest.get(start..).filter(|rest| rest.len() == expected));
    let ended = || {
        starts.iter().rev().find_map(|&start| {
            let (pixels, end) = rest.get(start..)?.split_at_checked(expected)?;
            matches!(end, b"\n" | b"\r\n" | b"\r").then_some(pixels)
        })
    };
    exact.or_else(ended)
}
