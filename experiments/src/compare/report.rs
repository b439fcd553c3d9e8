//! The report of a comparison: one self-contained HTML file, and the numbers as JSON.

mod page;
mod pictures;

use std::path::Path;

use serde_json::{Value, json};
use whitefurnace::error::Error;
use whitefurnace::harness::images::{AreaKind, AreaTest};
use whitefurnace::harness::outcome::Verdict;

use super::ComparisonReport;
use crate::run::record::write_json;
use crate::run::write_text;

/// File name of the HTML report.
pub(super) const HTML: &str = "report.html";
/// Bins of the histogram of p-values.
const BINS: usize = 20;

/// Describes the position of an area in words.
pub(super) fn area_name(kind: &AreaKind, test: &AreaTest) -> String {
    let [x0, y0, x1, y1] = test.area;
    match kind.name {
        "image mean" => kind.name.to_owned(),
        "pixel" => format!("pixel ({x0}, {y0})"),
        name => format!("{name} x {x0}–{}, y {y0}–{}", x1 - 1, y1 - 1),
    }
}

/// Summarises the judgement of one kind of area.
pub(super) fn kind_summary(kind: &AreaKind) -> String {
    let (judged, rejected, varying) = (
        kind.judged().count(),
        kind.rejected().count(),
        kind.varying(),
    );
    let least = kind.judged().map(|test| test.p).fold(1.0, f64::min);
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
        &page::page(report).map_err(|error| Error::Option(error.to_string()))?,
    )
}

/// Counts the p-values of pixels in each bin.
fn histogram(pixels: &AreaKind) -> Vec<u64> {
    let mut counts = vec![0; BINS];
    for test in pixels.tests.iter().filter(|test| test.varies()) {
        counts[((test.p * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    counts
}

/// Returns all numbers except those of single pixels that do not differ.
fn numbers(report: &ComparisonReport) -> Value {
    let place = |kind: &AreaKind, test: &AreaTest| {
        json!({
            "area": test.area,
            "channel": report.a[0].picture.labels()[test.channel],
            "means": test.means,
            "difference": test.difference(),
            "interval": test.interval(kind.level),
            "standard_error": test.standard_error / test.scale,
            "dof": test.dof,
            "sigmas": test.sigmas,
            "skewness": test.skewness,
            "p": test.p,
            "judged": test.judged,
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
        "verdict": super::word(report.found.verdict),
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
        .map(|test| test.minimum_detectable_effect(means.level))
        .reduce(f64::max);
    let mut judged: Vec<&AreaTest> = tiles.judged().collect();
    judged.sort_by(|x, y| (x.standard_error / x.scale).total_cmp(&(y.standard_error / y.scale)));
    let median = judged
        .get(judged.len() / 2)
        .map(|test| test.minimum_detectable_effect(tiles.level));
    [
        ("image mean", mean),
        ("median tile", median.filter(|_| tiles.is_counted)),
    ]
}
