//! Radiance pictures: one byte per colour channel and one for their exponent.

use super::{ChannelKind, LoadedImage, REC_709, check_size};

/// Relative error: a mantissa of eight bits is truncated, and may be as small as 128.
const RGBE_ROUNDING: f64 = 1.0 / 128.0;

/// Reads a Radiance picture of red, green and blue, with scanlines from the top or the bottom, flat
/// or run-length encoded: a byte m with the exponent e is m 2^(e − 136), and 0 where e is 0.
/// Source: Ward, "Real Pixels", Graphics Gems II, 1991.
///
/// # Errors
/// A message: no such header, values in X, Y, Z or with an exposure or a gamma, columns in place of
/// rows, or truncated pixels.
pub(super) fn hdr(bytes: &[u8]) -> Result<LoadedImage, String> {
    let mut rest = bytes;
    let mut line = || {
        let end = rest
            .iter()
            .position(|byte| *byte == b'\n')
            .ok_or("no header of a Radiance picture")?;
        let line = String::from_utf8_lossy(&rest[..end]).trim().to_owned();
        rest = &rest[end + 1..];
        Ok::<_, String>(line)
    };
    loop {
        let line = line()?;
        match line
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
        {
            Some(("FORMAT", format)) if format != "32-bit_rle_rgbe" => {
                return Err(format!("{line}: write RGBE"));
            }
            Some(("EXPOSURE" | "COLORCORR" | "GAMMA", value))
                if value.split_whitespace().any(|v| v.parse() != Ok(1.0_f64)) =>
            {
                return Err(format!(
                    "{line}, by which some programs change its values and some do not: write it without"
                ));
            }
            Some(("PRIMARIES", _)) => {
                return Err(format!(
                    "{line}: write it with the primaries of Rec. 709, without this line"
                ));
            }
            None if line.is_empty() => break,
            _ => {}
        }
    }
    let resolution = line()?;
    let words: Vec<&str> = resolution.split_whitespace().collect();
    let [rows @ ("-Y" | "+Y"), height, columns @ ("+X" | "-X"), width] = words[..] else {
        return Err(format!(
            "size {resolution:?}: write it row by row, such as \"-Y 512 +X 1024\""
        ));
    };
    let number = |text: &str| {
        text.parse::<usize>()
            .map_err(|_| format!("size {resolution:?} is no two numbers"))
    };
    let (width, height) = (number(width)?, number(height)?);
    check_size(width.checked_mul(height))?;
    let mut values = vec![Vec::new(); 3];
    for _ in 0..height {
        for [red, green, blue, exponent] in
            scanline(&mut rest, width).ok_or("truncated, or no run-length code")?
        {
            let unit = if exponent == 0 {
                0.0
            } else {
                (f64::from(exponent) - 136.0).exp2()
            };
            values
                .iter_mut()
                .zip([red, green, blue])
                .for_each(|(plane, m)| plane.push(f64::from(m) * unit));
        }
    }
    let picture = LoadedImage {
        size: [width, height],
        corner: [0; 2],
        kind: ChannelKind::Rgb,
        channels: ["R", "G", "B"].map(str::to_owned).to_vec(),
        skipped_channels: Vec::new(),
        values,
        standard_errors: None,
        rounding: RGBE_ROUNDING,
        lossy_compression: None,
        primaries: REC_709,
        is_cube: false,
    };
    Ok(picture.remapped(picture.size, |x, y| {
        [
            if columns == "+X" { x } else { width - 1 - x },
            if rows == "-Y" { y } else { height - 1 - y },
        ]
    }))
}

/// Returns the pixels of a row; `None` if the file ends within it.
fn scanline(rest: &mut &[u8], width: usize) -> Option<Vec<[u8; 4]>> {
    let mut row = Vec::with_capacity(width);
    let is_new = matches!(**rest, [2, 2, high, low, ..] if high < 128 && usize::from(high) << 8 | usize::from(low) == width);
    if is_new && (8..1 << 15).contains(&width) {
        *rest = &rest[4..];
        row.resize(width, [0; 4]);
        for component in 0..4 {
            let mut at = 0;
            while at < width {
                let count = take_bytes(rest, 1)?[0];
                // A count above 128 repeats one value count − 128 times; else count values follow.
                let run = usize::from(if count > 128 { count - 128 } else { count });
                let bytes = take_bytes(rest, if count > 128 { 1 } else { run })?;
                for (i, pixel) in row
                    .get_mut(at..at + run)
                    .filter(|_| run > 0)?
                    .iter_mut()
                    .enumerate()
                {
                    pixel[component] = bytes[i.min(bytes.len() - 1)];
                }
                at += run;
            }
        }
        return Some(row);
    }
    let mut shift = 0;
    while row.len() < width {
        match *take_bytes(rest, 4)? {
            [1, 1, 1, count] if shift < 24 => {
                let (last, run) = (*row.last()?, usize::from(count) << shift);
                if row.len() + run > width {
                    return None;
                }
                row.resize(row.len() + run, last);
                shift += 8;
            }
            [red, green, blue, exponent] => {
                row.push([red, green, blue, exponent]);
                shift = 0;
            }
            _ => return None,
        }
    }
    Some(row)
}

/// Takes the next bytes.
fn take_bytes<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, left) = rest.split_at_checked(count)?;
    *rest = left;
    Some(taken)
}
