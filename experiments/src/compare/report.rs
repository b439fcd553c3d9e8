//! The report of a comparison: one self-contained HTML file, and the numbers as JSON.

use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use whitefurnace::error::Error;
use whitefurnace::harness::images::{AreaKind, AreaTest};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::image::{Display, encode_rgb};

use super::{ComparisonReport, percent};
use crate::plot::map::{NAN_COLOUR, diverging};
use crate::run::record::write_json;
use crate::run::write_text;

/// File name of the HTML report.
pub(super) const HTML: &str = "report.html";
/// Bins of the histogram of p-values.
const BINS: usize = 20;
/// Rows of the table of places.
const MAX_TABLE_ROWS: usize = 24;

/// Describes the position of a place in words.
pub(super) fn place_name(kind: &AreaKind, place: &AreaTest) -> String {
    let [x0, y0, x1, y1] = place.area;
    match kind.name {
        "image mean" => kind.name.to_owned(),
        "pixel" => format!("pixel ({x0}, {y0})"),
        name => format!("{name} x {x0}–{}, y {y0}–{}", x1 - 1, y1 - 1),
    }
}

/// Summarises the judgement of one kind of places.
pub(super) fn kind_summary(kind: &AreaKind) -> String {
    let (judged, rejected, varying) = (
        kind.judged().count(),
        kind.rejected().count(),
        kind.varying(),
    );
    let least = kind.judged().map(|place| place.p).fold(1.0, f64::min);
    let found = if kind.is_counted {
        format!(
            "{rejected} differ, least p {least:.1e}, threshold {:.1e}; {judged} of {varying} judged",
            kind.level
        )
    } else {
        format!("undecided: too skewed, only {judged} of {varying} can be judged")
    };
    format!("{}s: {found}", kind.name)
}

/// Writes the HTML and the JSON file.
pub(super) fn write(folder: &Path, report: &ComparisonReport) -> Result<(), Error> {
    write_json(&folder.join("compare.json"), &numbers(report))?;
    write_text(
        &folder.join(HTML),
        &page(report).map_err(|error| Error::Option(error.to_string()))?,
    )
}

/// Counts the p-values of pixels in each bin.
fn histogram(pixels: &AreaKind) -> Vec<u64> {
    let mut counts = vec![0; BINS];
    for place in pixels.tests.iter().filter(|place| place.varies()) {
        counts[((place.p * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    counts
}

/// Returns all numbers except those of single pixels that do not differ.
fn numbers(report: &ComparisonReport) -> Value {
    let place = |kind: &AreaKind, place: &AreaTest| {
        json!({
            "area": place.area,
            "channel": report.a[0].picture.labels()[place.channel],
            "means": place.means,
            "difference": place.difference(),
            "interval": place.interval(kind.level),
            "standard_error": place.standard_error / place.scale,
            "dof": place.dof,
            "sigmas": place.sigmas,
            "skewness": place.skewness,
            "p": place.p,
            "judged": place.judged,
        })
    };
    let kind = |kind: &AreaKind| {
        let kept = |p: &&AreaTest| kind.name != "pixel" || kind.rejects(p);
        json!({
            "name": kind.name,
            "level": kind.level,
            "places": kind.tests.len(),
            "varying": kind.varying(),
            "judged": kind.judged().count(),
            "counts": kind.is_counted,
            "differ": kind.rejected().count(),
            "found": kind.tests.iter().filter(kept).map(|p| place(kind, p)).collect::<Vec<_>>(),
        })
    };
    let files = |inputs: &[super::Input]| -> Vec<Value> {
        let file = |input: &super::Input| {
            json!({
                "path": input.path.display().to_string(),
                "sha256": input.digest,
                "channels": input.picture.channels,
                "read": input.picture.describe(),
                "not_read": input.picture.skipped_channels,
            })
        };
        inputs.iter().map(file).collect()
    };
    json!({
        "verdict": report.word(),
        "why": report.why(),
        "hint": report.hint,
        "note": report.note,
        "cautions": report.cautions(),
        "times_as_many_images": match report.found.verdict { Verdict::Undecided { needed } => Some(needed), _ => None },
        "level": report.rules.level,
        "margin": report.rules.margin,
        "tile": report.rules.tile,
        "size": report.a[0].picture.size,
        "smallest_bias": detectable_biases(report).map(|(what, seen)| json!({"of": what, "relative": seen})),
        "kinds": report.found.kinds.iter().map(kind).collect::<Vec<_>>(),
        "pixel_p_values": histogram(&report.found.kinds[3]),
        "a": files(report.a),
        "b": files(report.b),
        "b_is_exact": report.exact,
    })
}

/// Returns the smallest detectable biases: of the image mean, in the channel where that is largest,
/// and of the median tile.
fn detectable_biases(report: &ComparisonReport) -> [(&'static str, Option<f64>); 2] {
    let [means, _, tiles, _] = &report.found.kinds;
    let mean = means
        .judged()
        .map(|place| place.minimum_detectable_effect(means.level))
        .reduce(f64::max);
    let mut judged: Vec<&AreaTest> = tiles.judged().collect();
    judged.sort_by(|x, y| (x.standard_error / x.scale).total_cmp(&(y.standard_error / y.scale)));
    let median = judged
        .get(judged.len() / 2)
        .map(|place| place.minimum_detectable_effect(tiles.level));
    [
        ("image mean", mean),
        ("median tile", median.filter(|_| tiles.is_counted)),
    ]
}

const STYLE: &str = "
:root{color-scheme:light dark;--bg:#fdfdfb;--fg:#1d1f23;--muted:#5c6068;--rule:#d9d9d4;--panel:#f2f2ec;--bar:#0072b2;--differ:#b3470b;--agree:#00714f;--undecided:#6a5acd}
@media(prefers-color-scheme:dark){:root{--bg:#15181e;--fg:#d5d7dc;--muted:#9aa0aa;--rule:#343a45;--panel:#1c2028;--bar:#56b4e9;--differ:#f0905a;--agree:#4fc79b;--undecided:#a79bf0}}
*{box-sizing:border-box}body{margin:0 auto;max-width:68rem;padding:1.5rem 1rem 4rem;background:var(--bg);color:var(--fg);font:16px/1.5 system-ui,sans-serif}
h1{font-size:2rem;margin:0;}h1::first-letter,header p::first-letter{text-transform:uppercase}h2{font-size:1.15rem;margin:2.2rem 0 .6rem}p{margin:.4rem 0;max-width:46rem}
header{border-left:.5rem solid var(--tone);background:var(--panel);padding:1rem 1.2rem;border-radius:.3rem}header h1{color:var(--tone)}
.differ{--tone:var(--differ)}.agree{--tone:var(--agree)}.undecided{--tone:var(--undecided)}
.small{color:var(--muted);font-size:.88rem}.grid{display:grid;gap:1.2rem}@media(min-width:42rem){.grid{grid-template-columns:1fr 1fr}}
figure{margin:0}figure img{width:100%;display:block;image-rendering:pixelated;border:1px solid var(--rule)}figcaption{font-size:.9rem;margin-bottom:.3rem}
.scale{display:flex;justify-content:space-between;font-size:.8rem;color:var(--muted)}.ramp{height:.6rem;margin-top:.35rem}
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums;width:100%}th,td{text-align:right;padding:.25rem .6rem;border-bottom:1px solid var(--rule);white-space:nowrap}
th{font-weight:600}th:first-child,td:first-child,th:nth-child(2),td:nth-child(2){text-align:left}tr.bad td{color:var(--differ);font-weight:600}
svg{width:100%;height:auto;max-width:46rem}svg text{fill:var(--muted);font:12px system-ui,sans-serif}code{font-size:.8rem;overflow-wrap:anywhere}
";

/// Returns an image embedded in the page.
fn picture(size: [usize; 2], rgb: &[u8], caption: &str) -> Result<String, png::EncodingError> {
    let data = STANDARD.encode(encode_rgb(size.map(|side| side as u32), rgb)?);
    Ok(format!(
        "<figure><figcaption>{caption}</figcaption><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\">"
    ))
}

/// Draws a map of signed values with a colour bar; NaN is grey.
fn map(
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

/// Applies a function to the channels of each cell of a kind of places.
fn cells(kind: &AreaKind, value: impl Fn(&[&AreaTest]) -> f64) -> Vec<f64> {
    let count = kind.grid[0] * kind.grid[1];
    (0..count)
        .map(|i| value(&kind.tests.iter().skip(i).step_by(count).collect::<Vec<_>>()))
        .collect()
}

/// Draws the mean image of a side in sRGB, with an exposure.
fn mean_picture(
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

/// Returns the difference relative to the second side, summed over channels.
fn relative(places: &[&AreaTest]) -> f64 {
    let sum = |f: fn(&AreaTest) -> f64| places.iter().map(|place| f(place)).sum::<f64>();
    sum(|place| place.means[0] - place.means[1]) / sum(|place| place.scale)
}

/// Returns −log₁₀ p with the sign of the difference, for the channel where p is least.
fn signed_log_p(places: &[&AreaTest]) -> f64 {
    let least = places
        .iter()
        .filter(|place| place.varies())
        .min_by(|x, y| x.p.total_cmp(&y.p));
    least.map_or(f64::NAN, |place| {
        -place.p.max(1e-300).log10() * place.sigmas.signum()
    })
}

/// Returns a round number at or above the 90 % quantile of the magnitudes.
fn scale_limit(values: &[f64]) -> f64 {
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

fn page(report: &ComparisonReport) -> Result<String, png::EncodingError> {
    let [means, regions, tiles, pixels] = &report.found.kinds;
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{word}: {why}</title><style>{STYLE}</style>\
         <header class=\"{word}\"><h1>{word}</h1><p>{why}.</p>",
        word = report.word(),
        why = escaped(&report.why())
    );
    let hint = report.hint.iter().map(|hint| format!("hint: {hint}"));
    for line in hint
        .chain(report.readings())
        .chain(report.note.iter().map(|note| format!("note: {note}")))
    {
        html += &format!("<p>{}.</p>", escaped(&line));
    }
    html += "</header>";
    // Writing to a string cannot fail.
    let overall = means
        .tests
        .iter()
        .map(|place| place.means[1].abs())
        .sum::<f64>()
        / means.tests.len() as f64;
    let exposure = if overall > 0.0 {
        (0.2 / overall).log2().round()
    } else {
        0.0
    };
    html += "<h2>Means</h2><div class=\"grid\">";
    for (side, inputs) in [report.a, report.b].into_iter().enumerate() {
        let name = ["First", "Second"][side];
        let stops = if exposure == 0.0 {
            String::new()
        } else {
            format!(", {exposure:+} stops")
        };
        let caption = format!("{name}: {}{stops}", escaped(&super::files::count(inputs)));
        html += &mean_picture(report, side, exposure, &caption)?;
        html += "</figure>";
    }
    html += "</div><h2>Where they differ</h2><div class=\"grid\">";
    for kind in [tiles, pixels] {
        let values = cells(kind, relative);
        let scale_limit = scale_limit(&values);
        let [low, high] = [-scale_limit, scale_limit].map(percent);
        html += &map(
            &format!("Difference of {}s, percent of the second", kind.name),
            kind.grid,
            &values,
            scale_limit,
            [&low, "0", &high],
        )?;
    }
    for kind in [tiles, pixels] {
        let scale_limit = -kind.level.log10();
        let [low, high] =
            ["below", "above"].map(|end| format!("p = {:.0e}, first {end}", kind.level));
        let caption = format!(
            "p-values of {}s, of the channel where they are least; grey: nothing varies",
            kind.name
        );
        html += &map(
            &caption,
            kind.grid,
            &cells(kind, signed_log_p),
            scale_limit,
            [&low, "p = 1", &high],
        )?;
    }
    html += "</div><p class=\"small\">Full colour in the lower maps marks p-values at the threshold that is common to all places.</p>";
    html += "<h2>Image mean</h2><div class=\"scroll\"><table><tr><th>channel<th><th>first<th>second<th>difference<th>from\
             <th>to<th>standard errors<th>p<th>smallest detectable";
    for place in &means.tests {
        let [low, high] = place.interval(means.level).map(percent);
        let _ = write!(
            html,
            "<tr{}><td>{}<td>{}<td>{:.5}<td>{:.5}<td>{}<td>{low}<td>{high}<td>{:.2}<td>{:.1e}<td>{}",
            row_class(means, place),
            report.channel(place.channel),
            if place.judged { "" } else { "not judged" },
            place.means[0],
            place.means[1],
            percent(place.difference()),
            place.sigmas,
            place.p,
            percent(place.minimum_detectable_effect(means.level)).replace('+', "")
        );
    }
    html += "</table></div><h2>Places, worst first</h2><div class=\"scroll\"><table><tr><th>place<th>channel<th>first\
             <th>second<th>difference<th>standard errors<th>p<th>threshold of p<th>";
    let all = [means, regions, tiles, pixels]
        .into_iter()
        .flat_map(|kind| kind.tests.iter().map(move |p| (kind, p)));
    let mut worst: Vec<(&AreaKind, &AreaTest)> = all.filter(|(_, place)| place.varies()).collect();
    let strength = |(kind, place): &(&AreaKind, &AreaTest)| {
        let told = kind.is_counted && place.judged;
        (!told, place.p / kind.level, -place.sigmas.abs())
    };
    worst.sort_by(|x, y| {
        strength(x)
            .partial_cmp(&strength(y))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    for (kind, place) in worst.iter().take(MAX_TABLE_ROWS) {
        let told = kind.is_counted && place.judged;
        let _ = write!(
            html,
            "<tr{}><td>{}<td>{}<td>{:.5}<td>{:.5}<td>{}<td>{:.2}<td>{:.1e}<td>{:.1e}<td>{}",
            row_class(kind, place),
            place_name(kind, place),
            report.channel(place.channel),
            place.means[0],
            place.means[1],
            percent(place.difference()),
            place.sigmas,
            place.p,
            kind.level,
            if told { "" } else { "not judged" }
        );
    }
    html += "</table></div><h2>p-values of pixels</h2>";
    html += &histogram_bars(&histogram(pixels));
    html += "<p class=\"small\">Flat where both renderers are right and the noise is not skewed; high at the left where they \
             differ. No verdict rests on this histogram.</p><h2>How it was decided</h2>";
    let _ = write!(
        html,
        "<p>Two right renderers are called different with a chance of at most {}: a quarter of it for each kind of place, \
         divided among its places and channels. Each place is judged by Welch's test, if skewness, as the images show it, \
         leaves its tail valid, as far as the images show their brightest paths: noise that has not been met has no test. A kind \
         counts if at least half of its places that vary are judged, and a difference must be more than that of one pixel. \
         Renderers agree if no \
         place differs, however little, and the interval of the image mean's difference lies within ±{} %. Where no \
         value varies, values are compared as they stand.</p><ul>",
        report.rules.level,
        100.0 * report.rules.margin
    );
    for kind in &report.found.kinds {
        let _ = write!(html, "<li>{}", kind_summary(kind));
    }
    for (what, seen) in detectable_biases(report) {
        if let Some(seen) = seen {
            let _ = write!(
                html,
                "<li>{what}: a bias of {} would be detected in other images like these with probability 90 %",
                percent(seen)
            );
        }
    }
    for line in report.cautions() {
        let _ = write!(html, "<li>{}", escaped(&line));
    }
    html += "</ul>";
    for (name, inputs) in [
        ("First", report.a),
        (if report.exact { "Reference" } else { "Second" }, report.b),
    ] {
        let _ = write!(html, "<h2>{name}: files and their SHA-256</h2><p>");
        for input in inputs {
            let _ = write!(
                html,
                "{}<br><code>{}</code><br>",
                escaped(&input.path.display().to_string()),
                input.digest
            );
        }
    }
    Ok(html + "</html>\n")
}

/// Returns the CSS class of a row that is rejected.
fn row_class(kind: &AreaKind, place: &AreaTest) -> &'static str {
    if kind.rejects(place) {
        " class=\"bad\""
    } else {
        ""
    }
}

/// Draws the histogram, with a line at the height of a uniform distribution.
fn histogram_bars(counts: &[u64]) -> String {
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

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}
