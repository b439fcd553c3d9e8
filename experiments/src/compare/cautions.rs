//! Warnings about assumptions on the noise of images that cannot be tested, and signs that one of
//! them may fail.

use clap::ValueEnum as _;
use whitefurnace::error::Error;
use whitefurnace::harness::images::MAX_BRIGHT_FRACTION;

use super::ComparisonReport;
use super::files::Input;
use crate::render::{EstimatorName, name};

/// Returns the value of a key in the provenance of an image that `render` made.
fn provenance_value<'a>(input: &'a Input, key: &str) -> Option<&'a str> {
    let lines = || {
        input
            .provenance
            .iter()
            .flat_map(|text| text.lines().filter_map(|line| line.split_once('=')))
    };
    let of = |key: &str| lines().find(|(k, _)| *k == key).map(|(_, value)| value);
    of("program")
        .filter(|program| *program == "whitefurnace")
        .and_then(|_| of(key))
}

/// Returns true if `render` made the image; it adds samples exactly.
pub(super) fn is_ours(input: &Input) -> bool {
    provenance_value(input, "estimator").is_some()
}

/// Refuses a single image whose pixels share paths or photons: its standard errors leave out the
/// common noise.
pub(super) fn check(option: &str, inputs: &[Input]) -> Result<(), Error> {
    let [one] = inputs else { return Ok(()) };
    let estimator = provenance_value(one, "estimator")
        .and_then(|estimator| EstimatorName::from_str(estimator, false).ok());
    match estimator.filter(|estimator| estimator.has_correlated_pixels()) {
        Some(estimator) => Err(Error::Option(format!(
            "{option} has one image, {}, of --estimator {}, whose pixels share paths, which standard errors of pixels leave \
             out: give three or more of other seeds",
            one.path.display(),
            name(estimator)
        ))),
        None => Ok(()),
    }
}

impl ComparisonReport<'_> {
    /// Returns lines on the assumptions about the images, and a warning where a few values carry
    /// much of the noise.
    pub(super) fn cautions(&self) -> Vec<String> {
        let second: &[Input] = if self.exact { &[] } else { self.b };
        let sides = [self.a, second];
        let mut lines = Vec::new();
        if sides
            .iter()
            .any(|side| side.len() == 1 && !is_ours(&side[0]) && side[0].has_noise())
        {
            lines.push(
                "assumed: pixels of a single image are independent, its standard errors complete"
                    .to_owned(),
            );
        }
        let all = self.found.brightest.iter().enumerate();
        let all = all.flat_map(|(channel, both)| [0, 1].map(|side| (channel, side, both[side])));
        let most = all.filter(|(.., brightest)| brightest.variance_fraction > MAX_BRIGHT_FRACTION);
        if let Some((channel, side, brightest)) =
            most.max_by(|x, y| x.2.variance_fraction.total_cmp(&y.2.variance_fraction))
        {
            let [image, pixel] = brightest.at;
            let width = self.a[0].picture.size[0];
            lines.push(format!(
                "warning: {} of the {}'s values in {}, the brightest at pixel ({}, {}) of {}, carry {:.0} % of its variance: \
                 rarer and brighter ones may be missing",
                brightest.count,
                ["first", "second"][side],
                self.channel(channel),
                pixel % width,
                pixel / width,
                sides[side][image].path.display(),
                100.0 * brightest.variance_fraction
            ));
        }
        lines
    }
}
