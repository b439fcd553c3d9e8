//! Pictures of a report: means, maps of differences, the histogram of p-values, and the means'
//! values for the page's script.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use whitefurnace::harness::images::{AreaKind, AreaTest};
use whitefurnace::image::{Display, encode_rgb};

use crate::compare::ComparisonReport;
use crate::plot::map::{NAN_COLOUR, diverging};

/// Returns an image embedded in the page.
fn picture(size: [usize; 2], rgb: &[u8], caption: &str) -> Result<String, png::EncodingError> {
    let data = STANDARD.encode(encode_rgb(size.map(|side| side as u32), rgb)?);
    Ok(format!(
        "<figure class=\"map\"><figcaption>{caption}</figcaption><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\">"
    ))
}

/// Draws a map of signed values with a colour bar; NaN is grey.
pub(super) fn map(
    caption: &str,
    size: [usize; 2],
    values: &[f64],
    scale_limit: f64,
    labels: [&str; 3],
) -> Result<String, png::EncodingError> {
    let colour = |value: &f64| {
        if value.is_nan() {
            NAN_COLOUR
        } else {
            diverging(value / scale_limit)
        }
    };
    let rgb: Vec<u8> = values.iter().flat_map(colour).collect();
    let stops: Vec<String> = (0..=16)
        .map(|i| diverging(f64::from(i) / 8.0 - 1.0))
        .map(|[r, g, b]| format!("rgb({r},{g},{b})"))
        .collect();
    let [low, middle, high] = labels;
    Ok(format!(
        "{}<div class=\"ramp\" style=\"background:linear-gradient(90deg,{})\">\
         </div><div class=\"scale\"><span>{low}</span><span>{middle}</span><span>{high}</span></div></figure>",
        picture(size, &rgb, caption)?,
        stops.join(",")
    ))
}

/// Applies a function to the channels of each cell of a kind of area.
pub(super) fn cells(kind: &AreaKind, value: impl Fn(&[&AreaTest]) -> f64) -> Vec<f64> {
    let count = kind.grid[0] * kind.grid[1];
    (0..count)
        .map(|i| value(&kind.tests.iter().skip(i).step_by(count).collect::<Vec<_>>()))
        .collect()
}

/// Draws the mean image of a side in sRGB, with an exposure.
pub(super) fn mean_picture(
    report: &ComparisonReport,
    side: usize,
    exposure: f64,
    caption: &str,
) -> Result<String, png::EncodingError> {
    let pixels = &report.found.kinds[3];
    let count = pixels.grid[0] * pixels.grid[1];
    let channels = pixels.tests.len() / count;
    let value =
        |i: usize, channel: usize| pixels.tests[channel.min(channels - 1) * count + i].means[side];
    let display = Display::Srgb { exposure };
    let rgb: Vec<u8> = (0..count)
        .flat_map(|i| [0, 1, 2].map(|channel| display.encode(value(i, channel))))
        .collect();
    picture(pixels.grid, &rgb, caption)
}

/// Largest number of pixels whose values the page holds: 2¹⁹ in three channels of two sides are 17
/// megabytes of text.
const MAX_VALUES: usize = 1 << 19;

/// Returns the means of both sides, side by side and channel by channel, as base64 of 32-bit floats
/// (little-endian), each that of a block of n × n pixels, and n: 1 unless the image is large.
pub(super) fn values(report: &ComparisonReport) -> (usize, String) {
    let pixels = &report.found.kinds[3];
    let [width, height] = pixels.grid;
    let blocks = |step: &usize| width.div_ceil(*step) * height.div_ceil(*step);
    let step = (1..).find(|step| blocks(step) <= MAX_VALUES).unwrap_or(1);
    let mut bytes = Vec::new();
    for side in 0..2 {
        for channel in pixels.tests.chunks_exact(width * height) {
            for y in (0..height).step_by(step) {
                for x in (0..width).step_by(step) {
                    let (right, below) = ((x + step).min(width), (y + step).min(height));
                    let rows = (y..below).map(|y| &channel[y * width..][x..right]);
                    let sum: f64 = rows.flatten().map(|pixel| pixel.means[side]).sum();
                    let mean = sum / ((right - x) * (below - y)) as f64;
                    bytes.extend((mean as f32).to_le_bytes());
                }
            }
        }
    }
    (step, STANDARD.encode(bytes))
}

/// Returns the difference relative to the second side, summed over channels.
pub(super) fn relative(areas: &[&AreaTest]) -> f64 {
    let sum = |f: fn(&AreaTest) -> f64| areas.iter().map(|test| f(test)).sum::<f64>();
    sum(|test| test.means[0] - test.means[1]) / sum(|test| test.scale)
}

/// Returns −log₁₀ p with the sign of the difference, for the channel where p is least.
pub(super) fn signed_log_p(areas: &[&AreaTest]) -> f64 {
    let least = areas
        .iter()
        .filter(|test| test.varies())
        .min_by(|x, y| x.p.total_cmp(&y.p));
    least.map_or(f64::NAN, |test| {
        -test.p.max(1e-300).log10() * test.sigmas.signum()
    })
}

/// Returns a round number at or above the 90 % quantile of the magnitudes.
pub(super) fn scale_limit(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values
        .iter()
        .map(|value| value.abs())
        .filter(|size| size.is_finite())
        .collect();
    sizes.sort_by(f64::total_cmp);
    let size = sizes
        .get(sizes.len() * 9 / 10)
        .copied()
        .unwrap_or(1.0)
        .clamp(1e-5, 1e5);
    let power = 10f64.powf(size.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|&b| b >= size)
        .unwrap_or(size)
}

/// Draws the histogram, with a line at the height of a uniform distribution.
pub(super) fn histogram_bars(counts: &[u64]) -> String {
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let flat = counts.iter().sum::<u64>() as f64 / counts.len() as f64;
    let height = |count: f64| 150.0 * count / most;
    let width = 600.0 / counts.len() as f64;
    let mut svg = String::from(
        "<svg viewBox=\"0 0 620 190\" role=\"img\" aria-label=\"histogram of p-values\">",
    );
    for (i, &count) in counts.iter().enumerate() {
        let (x, h) = (10.0 + width * i as f64, height(count as f64));
        let (y, w) = (160.0 - h, width - 2.0);
        let _ = write!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"var(--bar)\"/>"
        );
    }
    let y = 160.0 - height(flat);
    let _ = write!(
        svg,
        "<path d=\"M10 {y:.1}H610\" stroke=\"var(--fg)\" stroke-dasharray=\"5 4\"/><path d=\"M10 160H610\" \
         stroke=\"var(--muted)\"/><text x=\"10\" y=\"178\">p = 0</text><text x=\"610\" y=\"178\" text-anchor=\"end\">1\
         </text></svg>"
    );
    svg
}
