//! The page of a report as HTML. Without its script, it shows both means side by side and all
//! tables.

use std::fmt::Write as _;

use serde_json::json;
use whitefurnace::harness::images::{AreaKind, AreaTest};

use super::pictures::{
    cells, histogram_bars, map, mean_picture, relative, scale_limit, signed_log_p, values,
};
use super::{area_name, detectable_biases, histogram, kind_summary};
use crate::compare::files::{self, Input};
use crate::compare::{ComparisonReport, percent, word};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Rows of the table of the worst areas.
const MAX_TABLE_ROWS: usize = 24;
/// Largest distance of the exposure from its default, in stops.
const EXPOSURE_RANGE: f64 = 10.0;

/// Returns the page.
pub(super) fn page(report: &ComparisonReport) -> Result<String, png::EncodingError> {
    let exposure = exposure(report);
    Ok([
        header(report),
        viewer(report, exposure),
        means(report, exposure)?,
        maps(report)?,
        tables(report),
        decision(report),
        sources(report),
        script(report, exposure),
    ]
    .concat())
}

/// Returns the exposure in whole stops at which the second side's mean is a medium grey.
fn exposure(report: &ComparisonReport) -> f64 {
    let [means, ..] = &report.found.kinds;
    let sum: f64 = means.tests.iter().map(|test| test.means[1].abs()).sum();
    let overall = sum / means.tests.len() as f64;
    if overall > 0.0 {
        (0.2 / overall).log2().round()
    } else {
        0.0
    }
}

/// Returns the names of the sides, with the options that give them.
fn names(report: &ComparisonReport) -> [&'static str; 2] {
    let second = if report.exact {
        "B, the reference"
    } else {
        "B, the second"
    };
    ["A, the first", second]
}

/// Returns each side's name, its files and what `read` says of them.
fn captions(report: &ComparisonReport, read: fn(&[Input]) -> String) -> [String; 2] {
    let [first, second] = names(report);
    [(first, report.a), (second, report.b)]
        .map(|(name, inputs)| format!("{name}: {}; {}", files::count(inputs), read(inputs)))
}

/// Lists the channels that were read of the first image, with their layer.
fn channels_of(inputs: &[Input]) -> String {
    format!("channels {}", inputs[0].picture.channels.join(", "))
}

fn header(report: &ComparisonReport) -> String {
    let (word, why) = (word(report.found.verdict), escaped(&report.why()));
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>{word}: {why}</title><style>{STYLE}</style>\
         <header class=\"{word}\"><h1>{word}</h1><p>{why}.</p>",
    );
    let hint = report.hint.iter().map(|hint| format!("hint: {hint}"));
    let note = report.note.iter().map(|note| format!("note: {note}"));
    let readings = captions(report, |inputs| {
        format!("channels {}", files::readings(inputs))
    });
    for line in hint.chain(note).chain(readings) {
        html += &format!("<p>{}.</p>", escaped(&line));
    }
    html + "</header>"
}

/// Returns the viewer, which the script shows in place of the means.
fn viewer(report: &ComparisonReport, exposure: f64) -> String {
    let [low, high] = [-EXPOSURE_RANGE, EXPOSURE_RANGE].map(|stops| exposure + stops);
    let rows: String = (0..report.a[0].picture.channels.len())
        .map(|channel| {
            let name = report.channel(channel);
            format!("<tr id=\"reading-{channel}\"><td>{name}<td><td><td>")
        })
        .collect();
    format!(
        "<h2 id=\"images\">Images</h2><div id=\"viewer\" hidden><div class=\"controls\">\
         <button id=\"show-a\">A</button><button id=\"show-b\">B</button><span class=\"small\">key F flips</span>\
         <label>Exposure <input id=\"exposure\" type=\"range\" min=\"{low}\" max=\"{high}\" step=\"0.5\">\
         <output id=\"stops\"></output></label><button id=\"reset\">Reset</button>\
         <span class=\"small\">keys + and −</span></div><div id=\"caption\"></div>\
         <div id=\"stage\" tabindex=\"0\" role=\"application\" aria-label=\"the image: arrows move the pointer, Enter \
         goes to the row of the tile\"><canvas id=\"canvas\"></canvas><div id=\"mark\" hidden></div></div>\
         <table id=\"reading\"><tr><th id=\"where\"><th>A<th>B<th>difference{rows}</table>\
         <p class=\"small\">A click goes to the row of the tile, as does <a id=\"to-row\" href=\"#tiles\">this link</a> \
         or Enter; an area in a table leads back. Arrow keys move the pointer.</p></div>"
    )
}

/// Returns the means side by side.
fn means(report: &ComparisonReport, exposure: f64) -> Result<String, png::EncodingError> {
    let stops = if exposure == 0.0 {
        String::new()
    } else {
        format!("; {exposure:+} stops").replace('-', "−")
    };
    let mut html = "<div class=\"grid\" id=\"means\">".to_owned();
    for (side, caption) in captions(report, channels_of).iter().enumerate() {
        let caption = escaped(&format!("{caption}{stops}"));
        html += &mean_picture(report, side, exposure, &caption)?;
        html += "</figure>";
    }
    Ok(html + "</div>")
}

/// Returns the maps of differences and of p-values.
fn maps(report: &ComparisonReport) -> Result<String, png::EncodingError> {
    let [_, _, tiles, pixels] = &report.found.kinds;
    let mut html = "<h2>Where they differ</h2><div class=\"grid\">".to_owned();
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
    Ok(html
        + "</div><p class=\"small\">Full colour in the lower maps marks p-values at the threshold that is common to all \
           areas.</p>")
}

fn tables(report: &ComparisonReport) -> String {
    let [means, regions, tiles, pixels] = &report.found.kinds;
    let mut html = String::from(
        "<h2>Image mean</h2><div class=\"scroll\"><table class=\"areas\"><tr><th>channel<th><th>first<th>second\
         <th>difference<th>from<th>to<th>standard errors<th>p<th>smallest detectable",
    );
    // Writing to a string cannot fail.
    for test in &means.tests {
        let [low, high] = test.interval(means.level).map(percent);
        let _ = write!(
            html,
            "<tr{}><td>{}<td>{}<td>{:.5}<td>{:.5}<td>{}<td>{low}<td>{high}<td>{:.2}<td>{:.1e}<td>{}",
            row_class(means, test),
            report.channel(test.channel),
            if test.judged { "" } else { "not judged" },
            test.means[0],
            test.means[1],
            percent(test.difference()),
            test.sigmas,
            test.p,
            percent(test.minimum_detectable_effect(means.level)).replace('+', "")
        );
    }
    let all = [means, regions, tiles, pixels]
        .into_iter()
        .flat_map(|kind| kind.tests.iter().map(move |p| (kind, p)));
    let mut worst: Vec<(&AreaKind, &AreaTest)> = all.filter(|(_, test)| test.varies()).collect();
    let strength = |(kind, test): &(&AreaKind, &AreaTest)| {
        let told = kind.is_counted && test.judged;
        (!told, test.p / kind.level, -test.sigmas.abs())
    };
    worst.sort_by(|x, y| {
        strength(x)
            .partial_cmp(&strength(y))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    html += &format!("</table></div><h2>Areas, worst first</h2>{AREA_TABLE_HEAD}");
    for (kind, test) in worst.iter().take(MAX_TABLE_ROWS) {
        html += &row(report, kind, test, "");
    }
    let count = tiles.grid[0] * tiles.grid[1];
    html += &format!(
        "</table></div><h2>Tiles</h2><p class=\"small\">Each in the channel with its least p.</p>\
         <details id=\"tiles\"><summary>All {count} tiles</summary>{AREA_TABLE_HEAD}"
    );
    for i in 0..count {
        let channels = tiles.tests.iter().skip(i).step_by(count);
        if let Some(test) = channels.min_by(|x, y| x.p.total_cmp(&y.p)) {
            html += &row(report, tiles, test, &format!(" id=\"tile-{i}\""));
        }
    }
    html += "</table></div></details><h2>p-values of pixels</h2>";
    html + &histogram_bars(&histogram(pixels))
}

/// Head of a table of areas.
const AREA_TABLE_HEAD: &str = "<div class=\"scroll\"><table class=\"areas\"><tr><th>area<th>channel<th>first<th>second\
                      <th>difference<th>standard errors<th>p<th>threshold of p<th>";

/// Returns the row of an area, whose name leads to the images.
fn row(report: &ComparisonReport, kind: &AreaKind, test: &AreaTest, id: &str) -> String {
    let told = kind.is_counted && test.judged;
    let [x0, y0, x1, y1] = test.area;
    let sigmas = match test.sigmas {
        sigmas if sigmas.is_nan() => "–".to_owned(),
        sigmas => format!("{sigmas:.2}"),
    };
    format!(
        "<tr{id}{} data-area=\"{x0} {y0} {x1} {y1}\"><td><a href=\"#images\">{}</a><td>{}<td>{:.5}<td>{:.5}<td>{}\
         <td>{sigmas}<td>{:.1e}<td>{:.1e}<td>{}",
        row_class(kind, test),
        area_name(kind, test),
        report.channel(test.channel),
        test.means[0],
        test.means[1],
        percent(test.difference()),
        test.p,
        kind.level,
        if told { "" } else { "not judged" }
    )
}

fn decision(report: &ComparisonReport) -> String {
    let mut html = String::from(
        "<p class=\"small\">Flat where both renderers are right and the noise is not skewed; high at the left where they \
             differ. No verdict rests on this histogram.</p><h2>How it was decided</h2>",
    );
    let _ = write!(
        html,
        "<p>Two right renderers are called different with a chance of at most {}: a quarter of it for each kind of area, \
         divided among its areas and channels. Each area is judged by Welch's test, if skewness, as the images show it, \
         leaves its tail valid, as far as the images show their brightest paths: noise that has not been met has no test. A kind \
         counts if at least half of its areas that vary are judged, and a difference must be more than that of one pixel. \
         Renderers agree if no \
         area differs, however little, and the interval of the image mean's difference lies within ±{} %. Where no \
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
    html + "</ul>"
}

/// Lists the files.
fn sources(report: &ComparisonReport) -> String {
    let mut html = String::new();
    let [first, second] = names(report);
    for (name, inputs) in [(first, report.a), (second, report.b)] {
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
    html
}

/// Returns the script with the values that it shows, and the end of the page.
fn script(report: &ComparisonReport, exposure: f64) -> String {
    let (step, values) = values(report);
    let picture = &report.a[0].picture;
    let channels: Vec<&str> = (0..picture.channels.len())
        .map(|channel| report.channel(channel))
        .collect();
    let layout = json!({
        "size": picture.size,
        "step": step,
        "tile": report.rules.tile,
        "channels": channels,
        "exposure": exposure,
        "captions": captions(report, channels_of),
    });
    let layout = layout.to_string().replace('<', "\\u003c");
    format!(
        "<script type=\"application/json\" id=\"layout\">{layout}</script>\
         <script type=\"text/plain\" id=\"values\">{values}</script><script>{SCRIPT}</script></html>\n"
    )
}

/// Returns the CSS class of a row that is rejected.
fn row_class(kind: &AreaKind, test: &AreaTest) -> &'static str {
    if kind.rejects(test) {
        " class=\"bad\""
    } else {
        ""
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}
