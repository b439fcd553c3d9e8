//! The program `compare`: two renderers on trial by their images.

mod files;
mod report;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use whitefurnace::error::Error;
use whitefurnace::harness::images::{self, Area, Comparison, Rules, Side};
use whitefurnace::harness::outcome::Verdict;

use crate::run::cli::{real, use_threads, verdict, whole};
use crate::say;
use files::Input;

/// Decide whether the images of two renderers agree: image mean, regions, tiles and pixels, with one bound on the
/// chance of a false alarm for all of these.
///
/// Examples:
///   compare --a 'a-*.exr' --b 'b-*.exr'               independent renders of two programs, four or more of each
///   compare --a a.exr --b b.exr                       one of each, with standard errors (channels stderr.R, ...)
///   compare --a 'a-*.pfm' --reference exact.pfm       against an image without error
///
/// Images are EXR or PFM. Differences are in percent of the second. Into the folder --out go report.html, which needs
/// no other file, and compare.json.
///
/// Exit codes: 0 if they agree, 1 if they differ, 2 if more images are needed to tell, 3 for bad input.
#[derive(Parser)]
#[command(name = "compare", version, verbatim_doc_comment)]
pub struct Compare {
    /// Images on trial: files, or patterns with * and ?
    #[arg(long, required = true, num_args = 1.., value_name = "FILES")]
    a: Vec<String>,
    /// Images to compare with
    #[arg(long, num_args = 1.., value_name = "FILES", required_unless_present = "reference")]
    b: Vec<String>,
    /// An image without error, in place of --b
    #[arg(long, value_name = "FILE", conflicts_with = "b")]
    reference: Option<PathBuf>,
    /// The layer of an EXR that has several
    #[arg(long)]
    layer: Option<String>,
    /// How far image means of renderers that agree may differ, percent; from 0.000001 to 100
    #[arg(long, default_value_t = 1.0, allow_hyphen_values = true, value_parser = real(1e-6..=100.0))]
    margin: f64,
    /// The chance that right renderers are called different; from 0.000000000001 to 0.5
    #[arg(long, default_value_t = 1e-3, allow_hyphen_values = true, value_parser = real(1e-12..=0.5))]
    level: f64,
    /// The side of a tile in pixels; from 2 to 65536
    #[arg(long, default_value_t = 16, allow_hyphen_values = true, value_parser = whole::<usize>(2..=65_536))]
    tile: usize,
    /// A region to judge beside nine equal ones: left, top, and the first column and row outside; may be repeated
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, value_parser = parse_region)]
    region: Vec<Area>,
    /// Threads; from 1 to 1024 [default: one per core]
    #[arg(long, allow_hyphen_values = true, value_parser = whole::<usize>(1..=1024))]
    threads: Option<usize>,
    /// Folder for the report
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    out: PathBuf,
}

fn parse_region(text: &str) -> Result<Area, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|number| number.parse().ok()).collect();
    let area = numbers.and_then(|numbers| Area::try_from(numbers).ok());
    let area = area.filter(|[x0, y0, x1, y1]| x0 < x1 && y0 < y1);
    area.ok_or_else(|| "must be X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1, such as 0,0,64,32".to_owned())
}

/// The whole program.
pub fn main() -> ExitCode {
    verdict(run)
}

fn run(options: &Compare) -> Result<u8, Error> {
    use_threads(options.threads)?;
    let a = files::read("--a", &options.a, options.layer.as_deref())?;
    let b = match &options.reference {
        Some(reference) => vec![files::read_one(reference, options.layer.as_deref())?],
        None => files::read("--b", &options.b, options.layer.as_deref())?,
    };
    files::check(&a, &b)?;
    let [width, height] = a[0].picture.size;
    if let Some(region) = options.region.iter().find(|region| region[2] > width || region[3] > height) {
        return Err(Error::Option(format!("--region {region:?} reaches beyond the images' {width} × {height} pixels")));
    }
    let sides = (0..a[0].picture.channels.len())
        .map(|channel| {
            let b = match options.reference {
                Some(_) => Ok(Side::Exact(&b[0].picture.values[channel])),
                None => side("--b", &b, channel),
            };
            Ok([side("--a", &a, channel)?, b?])
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let rules = Rules {
        level: options.level,
        margin: options.margin / 100.0,
        tile: options.tile,
        regions: options.region.clone(),
        rounding: a.iter().chain(&b).map(|input| input.picture.rounding).fold(0.0, f64::max),
    };
    std::fs::create_dir_all(&options.out).map_err(Error::file("create", &options.out))?;
    let found = images::compare(width, &sides, &rules);
    let trial = Trial { a: &a, b: &b, exact: options.reference.is_some(), rules: &rules, found: &found };
    report::write(&options.out, &trial)?;
    say!("{}", trial.summary());
    say!("{}", options.out.join(report::HTML).display());
    Ok(match found.verdict {
        Verdict::Holds => 0,
        Verdict::Fails => 1,
        Verdict::Undecided { .. } => 2,
    })
}

/// What the images of one side say of a channel.
fn side<'a>(option: &str, inputs: &'a [Input], channel: usize) -> Result<Side<'a>, Error> {
    match inputs {
        [one] => match &one.picture.standard_errors {
            Some(errors) => Ok(Side::Errors(&one.picture.values[channel], &errors[channel])),
            None => Err(Error::Option(format!(
                "{option} has one image, {}, without standard errors (channels stderr.R, ...): give two or more, at best \
                 four, or one as --reference",
                one.path.display()
            ))),
        },
        several => Ok(Side::Images(several.iter().map(|input| input.picture.values[channel].as_slice()).collect())),
    }
}

/// All that a report tells.
struct Trial<'a> {
    a: &'a [Input],
    b: &'a [Input],
    exact: bool,
    rules: &'a Rules,
    found: &'a Comparison,
}

/// A share in percent, with a sign.
fn percent(share: f64) -> String {
    let decimals = if share.abs() >= 0.0995 {
        1
    } else if share.abs() >= 0.00995 {
        2
    } else {
        3
    };
    format!("{:+.decimals$} %", 100.0 * share).replace('-', "−")
}

impl Trial<'_> {
    /// One word.
    fn word(&self) -> &'static str {
        match self.found.verdict {
            Verdict::Holds => "agree",
            Verdict::Fails => "differ",
            Verdict::Undecided { .. } => "undecided",
        }
    }

    fn channel(&self, channel: usize) -> &'static str {
        match self.a[0].picture.channels[channel] {
            "R" => "red",
            "G" => "green",
            "B" => "blue",
            _ => "grey",
        }
    }

    /// The reason of the verdict, a sentence.
    fn why(&self) -> String {
        let kinds = &self.found.kinds;
        let [means, ..] = kinds;
        match self.found.verdict {
            Verdict::Fails => {
                // Of what is rejected, the most telling.
                let rejected = kinds.iter().flat_map(|kind| kind.rejected().map(move |place| (kind, place)));
                let strength = |(kind, place): &(&images::Kind, &images::Place)| place.p / kind.level;
                let worst = rejected.min_by(|x, y| strength(x).total_cmp(&strength(y)));
                worst.map_or(String::new(), |(kind, place)| {
                    format!(
                        "the {} in {} is {} off the second's (p = {:.1e}, where {:.1e} is enough)",
                        report::place_name(kind, place),
                        self.channel(place.channel),
                        percent(place.difference()),
                        place.p,
                        kind.level
                    )
                })
            }
            Verdict::Holds => format!(
                "nothing that could be judged differs, and the image mean is equal within {} %",
                100.0 * self.rules.margin
            ),
            Verdict::Undecided { needed } => {
                let unknown = means.places.iter().any(|place| place.varies() && place.skewness[0].is_nan());
                if means.varying() == 0 {
                    "no pixel varies between images, so nothing is known of their error".to_owned()
                } else if unknown {
                    "two images do not tell how skewed their noise is: give three or more of a side, at best eight"
                        .to_owned()
                } else {
                    let invalid = means.places.iter().any(|place| place.varies() && !place.judged);
                    let what = if invalid {
                        "the noise is too skewed to judge the image mean"
                    } else {
                        "nothing differs, but noise leaves the image mean uncertain by more than the margin"
                    };
                    format!("{what}; about {needed} times as many images, or samples in each, would decide")
                }
            }
        }
    }

    /// At most nine lines.
    fn summary(&self) -> String {
        let [means, others @ ..] = &self.found.kinds;
        let [width, height] = self.a[0].picture.size;
        let mut lines = vec![
            format!("{}: {}", self.word().to_uppercase(), self.why()),
            format!(
                "{} against {}{} of {width} × {height} pixels; chance of a false alarm at most {}",
                files::count(self.a),
                if self.exact { "a reference, " } else { "" },
                files::count(self.b),
                self.rules.level
            ),
        ];
        for place in &means.places {
            let [low, high] = place.interval(means.level).map(percent);
            let seen = percent(place.seen(means.level)).replace('+', "");
            let judged = if place.judged { "" } else { "; not judged: too skewed, or without noise" };
            let channel = self.channel(place.channel);
            lines.push(format!(
                "image mean, {channel}: {} (from {low} to {high}), p {:.1e}; {seen} would have been seen{judged}",
                percent(place.difference()),
                place.p
            ));
        }
        lines.extend(others.iter().map(report::kind_line));
        lines.join("\n")
    }
}
