//! Splits pictures that are too large for one recorded file into bands of rows.

use std::fs::File;
use std::io::{BufReader, Write as _};
use std::path::Path;

use whitefurnace::error::Error;
use whitefurnace::image::{encode_rgb, write_atomically};

/// Bands have a multiple of this many rows.
const ROWS_PER_BAND: u32 = 8;

/// Writes the picture `source`, an 8-bit RGB PNG, as `STEM.band-1.png`, `STEM.band-2.png` ... in
/// the folder `to`: the fewest bands that keep each file at most `largest` bytes. All bands but the
/// last have a multiple of eight rows, so that a page that shows them at half or a quarter of their
/// size has no seams between them.
pub fn split_png(source: &Path, to: &Path, largest: u64) -> Result<(), Error> {
    let fault = |message: String| Error::Image {
        action: "divide",
        path: source.to_owned(),
        message,
    };
    let file = File::open(source).map_err(Error::file("read", source))?;
    let mut reader = png::Decoder::new(BufReader::new(file))
        .read_info()
        .map_err(|error| fault(error.to_string()))?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| fault("too large for memory".to_owned()))?;
    let mut pixels = vec![0; size];
    let info = reader
        .next_frame(&mut pixels)
        .map_err(|error| fault(error.to_string()))?;
    if (info.color_type, info.bit_depth) != (png::ColorType::Rgb, png::BitDepth::Eight) {
        return Err(fault("not an 8-bit RGB picture".to_owned()));
    }
    let stem = source
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let bands = (2..=info.height)
        .find_map(|count| {
            let rows = info.height.div_ceil(count).next_multiple_of(ROWS_PER_BAND) as usize;
            let bands: Vec<Vec<u8>> = pixels
                .chunks(rows * info.line_size)
                .map(|band| encode_rgb([info.width, (band.len() / info.line_size) as u32], band))
                .collect::<Result<_, _>>()
                .ok()?;
            bands
                .iter()
                .all(|band| band.len() as u64 <= largest)
                .then_some(bands)
        })
        .ok_or_else(|| {
            fault(format!(
                "{ROWS_PER_BAND} rows take more than {largest} bytes"
            ))
        })?;
    for (i, band) in bands.iter().enumerate() {
        let path = to.join(format!("{stem}.band-{}.png", i + 1));
        write_atomically(&path, |file| {
            file.write_all(band).map_err(Error::file("write", &path))
        })?;
    }
    Ok(())
}
