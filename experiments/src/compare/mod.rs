//! The program `compare`: two renderers on trial by their images.

mod cautions;
mod files;
mod hint;
mod report;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use whitefurnace::error::Error;
use whitefurnace::harness::images::{self, Area, Comparison, Rules, Side};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::image::read::{ChannelKind, LoadedImage};

use crate::print_line;
use crate::run::cli::{integer, number, run_with_verdict, use_threads};
use files::{Input, Layer};

/// Decide whether the images of two renderers agree: image mean, regions, tiles and pixels, with
/// one bound on the probability of a false alarm for all of these, as far as the images sample
/// their brightest paths.
///
/// Examples:
///   compare --a 'a-*.exr' --b 'b-*.exr'            independent renders of two programs, 8 of each
///   compare --a a.exr --b b.exr                    one of each, with standard errors
///                                                  (channels stderr.R, ...)
///   compare --a 'a-*.pfm' --reference exact.pfm    against an image without error
///   compare --a 'a-*.exr' --b 'b-*.exr' --a-layer ViewLayer.Combined
///                                                  by the name of a layer
///
/// Images are EXR or PFM. Of an EXR the channels R, G, B are read, or else the only layer that can
/// be the image; the output says which. Differences are in percent of the second side. The folder
/// --out gets report.html, which needs no other file, and compare.json.
///
/// Two renderers agree if no difference exceeds the noise, and the confidence interval of the
/// difference of the image means lies within --margin. A difference beyond noise counts at any
/// size.
///
/// Exit codes: 0 if they agree, 1 if they differ, 2 if more images are needed to tell, 3 for bad
/// input.
#[derive(Parser)]
#[command(name = "compare", version, verbatim_doc_comment)]
pub struct Compare {
    /// Images on trial: files, or patterns with * and ?
    #[arg(long, required = true, num_args = 1.., value_name = "FILES")]
    a: Vec<String>,
    /// Images to compare with
    #[arg(long, num_args = 1.., value_name = "FILES", required_unless_present = "reference")]
    b: Vec<String>,
    /// An image without error, instead of --b
    #[arg(long, value_name = "FILE", conflicts_with = "b")]
    reference: Option<PathBuf>,
    /// Layer of both sides, for an EXR that has several; or one or three channels by their full
    /// names, with commas
    #[arg(long, value_name = "LAYER")]
    layer: Option<String>,
    /// Layer of the first side
    #[arg(long, value_name = "LAYER")]
    a_layer: Option<String>,
    /// Layer of the second side, or of the reference
    #[arg(long, value_name = "LAYER")]
    b_layer: Option<String>,
    /// Judge the part of the frame that all images have, where they differ in size or place;
    /// --region counts from its corner
    #[arg(long)]
    common: bool,
    /// Align the upper left pixels of all images, whatever position in the frame their files state
    #[arg(long)]
    ignore_place: bool,
    /// The margin in percent within which the confidence interval of the difference of the image
    /// means must lie to agree; a difference beyond noise counts at any size; from 0.000001 to 100
    #[arg(long, default_value_t = 1.0, allow_hyphen_values = true, value_parser = number(1e-6..=100.0))]
    margin: f64,
    /// Probability of calling correct renderers different, as far as their images sample their
    /// brightest paths; from 0.000000000001 to 0.5
    #[arg(long, default_value_t = 1e-3, allow_hyphen_values = true, value_parser = number(1e-12..=0.5))]
    level: f64,
    /// Side of a tile in pixels; from 2 to 65536
    #[arg(long, default_value_t = 16, allow_hyphen_values = true, value_parser = integer::<usize>(2..=65_536))]
    tile: usize,
    /// A region to judge in addition to nine equal ones: left, top, and the first column and row
    /// outside; may be repeated
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, value_parser = parse_region)]
    region: Vec<Area>,
    /// Threads; from 1 to 1024 [default: one per core]
    #[arg(long, allow_hyphen_values = true, value_parser = integer::<usize>(1..=1024))]
    threads: Option<usize>,
    /// Folder for the report
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    out: PathBuf,
}

fn parse_region(text: &str) -> Result<Area, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|number| number.parse().ok()).collect();
    let area = numbers.and_then(|numbers| Area::try_from(numbers).ok());
    let area = area.filter(|[x0, y0, x1, y1]| x0 < x1 && y0 < y1);
    area.ok_or_else(|| {
        "must be X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1, such as 0,0,64,32".to_owned()
    })
}

/// Runs the whole program.
pub fn main() -> ExitCode {
    run_with_verdict(run)
}

fn run(options: &Compare) -> Result<u8, Error> {
    use_threads(options.threads)?;
    let layer = |of: &'_ Option<String>, option: &'static str| match (of, &options.layer) {
        (None, Some(both)) => Layer {
            name: Some(both.clone()),
            option: "--layer",
        },
        (of, _) => Layer {
            name: of.clone(),
            option,
        },
    };
    let (a_layer, b_layer) = (
        layer(&options.a_layer, "--a-layer"),
        layer(&options.b_layer, "--b-layer"),
    );
    let mut a = files::read("--a", &options.a, &a_layer)?;
    let mut b = match &options.reference {
        Some(reference) => vec![files::read_one(reference, &b_layer)?],
        None => files::read("--b", &options.b, &b_layer)?,
    };
    if options.ignore_place {
        a.iter_mut()
            .chain(&mut b)
            .for_each(|input| input.picture.corner = [0; 2]);
    }
    files::crop_to_common(&mut a, &mut b, options.common)?;
    files::check(&a, &b)?;
    files::fill_standard_errors("--a", &mut a)?;
    if options.reference.is_none() {
        files::fill_standard_errors("--b", &mut b)?;
    }
    cautions::check("--a", &a)?;
    if options.reference.is_none() {
        cautions::check("--b", &b)?;
    }
    let (a, b, exact) = (&a[..], &b[..], options.reference.is_some());
    let [width, height] = a[0].picture.size;
    if let Some(region) = options
        .region
        .iter()
        .find(|region| region[2] > width || region[3] > height)
    {
        return Err(Error::Option(format!(
            "--region {region:?} reaches beyond the images' {width} × {height} pixels"
        )));
    }
    let rules = Rules {
        level: options.level,
        margin: options.margin / 100.0,
        tile: options.tile,
        regions: options.region.clone(),
        rounding: a
            .iter()
            .chain(b)
            .map(|input| input.picture.rounding)
            .fold(0.0, f64::max),
        single_sums: !a.iter().chain(b).all(cautions::is_ours),
    };
    std::fs::create_dir_all(&options.out).map_err(Error::file("create", &options.out))?;
    let pictures = [a, b].map(|side| side.iter().map(|input| &input.picture).collect::<Vec<_>>());
    let found = images::compare(width, &sides([&pictures[0], &pictures[1]], exact), &rules);
    let hint = match found.verdict {
        Verdict::Fails => hint::hint([&pictures[0], &pictures[1]], exact, &rules, &found),
        _ => None,
    };
    let report = ComparisonReport {
        a,
        b,
        exact,
        rules: &rules,
        found: &found,
        hint,
        note: files::note(a, b),
    };
    report::write(&options.out, &report)?;
    print_line!("{}", report.summary());
    print_line!("{}", options.out.join(report::HTML).display());
    Ok(match found.verdict {
        Verdict::Holds => 0,
        Verdict::Fails => 1,
        Verdict::Undecided { .. } => 2,
    })
}

/// Returns both sides of each channel; the second is without error if it is `exact`.
fn sides<'a>(pictures: [&[&'a LoadedImage]; 2], exact: bool) -> Vec<[Side<'a>; 2]> {
    let side = |pictures: &[&'a LoadedImage], channel: usize, exact: bool| match (
        pictures,
        &pictures[0].standard_errors,
    ) {
        ([one], _) if exact => Side::Exact(&one.values[channel]),
        ([one], Some(errors)) => Side::Errors(&one.values[channel], &errors[channel]),
        (several, _) => Side::Images(
            several
                .iter()
                .map(|picture| picture.values[channel].as_slice())
                .collect(),
        ),
    };
    let channels = 0..pictures[0][0].channels.len();
    channels
        .map(|channel| {
            [
                side(pictures[0], channel, false),
                side(pictures[1], channel, exact),
            ]
        })
        .collect()
}

/// A comparison and all that its report shows.
struct ComparisonReport<'a> {
    a: &'a [Input],
    b: &'a [Input],
    exact: bool,
    rules: &'a Rules,
    found: &'a Comparison,
    /// A change that makes the sides agree.
    hint: Option<String>,
    /// A note on the files.
    note: Option<String>,
}

/// Returns the verdict on two renderers in one word.
pub fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "agree",
        Verdict::Fails => "differ",
        Verdict::Undecided { .. } => "undecided",
    }
}

/// Formats a fraction as a percentage with a sign.
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

impl ComparisonReport<'_> {
    fn channel(&self, channel: usize) -> &str {
        let picture = &self.a[0].picture;
        match picture.kind {
            ChannelKind::Rgb => ["red", "green", "blue"][channel],
            ChannelKind::Luminance => "luminance",
            ChannelKind::Grey => "grey",
            ChannelKind::Xyz | ChannelKind::Three => picture.labels()[channel],
        }
    }

    /// Returns true if no channel has noise.
    fn is_noiseless(&self) -> bool {
        self.found.kinds[0].tests.iter().all(|test| test.noiseless)
    }

    /// Describes the channels that were read of the sides, in one line or two.
    fn readings(&self) -> Vec<String> {
        let [first, second] = [self.a, self.b].map(files::readings);
        if first == second {
            return vec![format!("channels of both: {first}")];
        }
        vec![
            format!("channels of the first: {first}"),
            format!("channels of the second: {second}"),
        ]
    }

    /// Returns the reason for the verdict, a sentence.
    fn why(&self) -> String {
        let kinds = &self.found.kinds;
        let [means, ..] = kinds;
        match self.found.verdict {
            Verdict::Fails => {
                // Of the rejections, the most telling one.
                let rejected = kinds
                    .iter()
                    .flat_map(|kind| kind.rejected().map(move |test| (kind, test)));
                let strength =
                    |(kind, test): &(&images::AreaKind, &images::AreaTest)| test.p / kind.level;
                let worst = rejected.min_by(|x, y| strength(x).total_cmp(&strength(y)));
                worst.map_or(String::new(), |(kind, test)| {
                    let evidence = match test.noiseless {
                        true => "and neither side has noise".to_owned(),
                        false => format!("p = {:.1e}, threshold {:.1e}", test.p, kind.level),
                    };
                    let within = means.tests.iter().all(|mean| {
                        mean.varies()
                            && mean
                                .interval(means.level)
                                .iter()
                                .all(|end| end.abs() <= self.rules.margin)
                    });
                    format!(
                        "the {} in {} is {} off the second's ({evidence}){}",
                        report::area_name(kind, test),
                        self.channel(test.channel),
                        percent(test.difference()),
                        if within {
                            "; image means are within the margin, but this is more than noise"
                        } else {
                            ""
                        }
                    )
                })
            }
            Verdict::Holds if self.is_noiseless() => {
                let black = means.tests.iter().all(|test| test.means == [0.0; 2]);
                let what = if black { ": all are black" } else { "" };
                format!("neither side has noise, and no value differs by more than rounding{what}")
            }
            Verdict::Holds => format!(
                "nothing that could be judged differs, and the image mean is equal within {} %",
                100.0 * self.rules.margin
            ),
            Verdict::Undecided { .. }
                if kinds.iter().any(|kind| kind.rejected().next().is_some()) =>
            {
                format!(
                    "the difference exceeds the noise, but nowhere {:.3} %, the rounding error of 4096 samples added one by one in \
                 single precision: add them in double precision to tell",
                    100.0 * images::SINGLE_SUM_ERROR
                )
            }
            Verdict::Undecided { needed } => {
                let unknown = means
                    .tests
                    .iter()
                    .any(|test| test.varies() && test.skewness[0].is_nan());
                if means.varying() == 0 {
                    "no pixel varies between images, but these are too few values to conclude that there is no noise".to_owned()
                } else if unknown {
                    "two images do not show how skewed their noise is: give three or more of a side, at best eight"
                        .to_owned()
                } else {
                    let invalid = means.tests.iter().any(|test| test.varies() && !test.judged);
                    let what = if invalid {
                        "the noise is too skewed to judge the image mean"
                    } else {
                        "nothing differs, but noise leaves the image mean uncertain by more than the margin"
                    };
                    format!(
                        "{what}; about {needed} times as many images, or samples in each, would decide"
                    )
                }
            }
        }
    }

    /// Returns the summary, at most fifteen lines.
    fn summary(&self) -> String {
        let [means, others @ ..] = &self.found.kinds;
        let [width, height] = self.a[0].picture.size;
        let word = word(self.found.verdict).to_uppercase();
        let mut lines = vec![format!("{word}: {}", self.why())];
        lines.extend(self.hint.iter().map(|hint| format!("hint: {hint}")));
        lines.extend(self.readings());
        lines.extend(self.note.iter().map(|note| format!("note: {note}")));
        lines.push(format!(
            "{} against {}{} of {width} × {height} pixels; chance of a false alarm at most {}, as far as \
             these show their brightest paths",
            files::count(self.a),
            if self.exact { "a reference, " } else { "" },
            files::count(self.b),
            self.rules.level
        ));
        for test in &means.tests {
            let [low, high] = test.interval(means.level).map(percent);
            let seen = percent(test.minimum_detectable_effect(means.level)).replace('+', "");
            let judged = if test.judged {
                ""
            } else {
                "; not judged: too skewed, or without noise"
            };
            let channel = self.channel(test.channel);
            lines.push(format!(
                "image mean, {channel}: {} (from {low} to {high}), p {:.1e}; smallest detectable {seen}{judged}",
                percent(test.difference()),
                test.p
            ));
        }
        lines.extend(others.iter().map(report::kind_summary));
        lines.extend(self.cautions());
        lines.join("\n")
    }
}
