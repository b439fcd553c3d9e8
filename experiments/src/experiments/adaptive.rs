//! Variance reduction by adaptive sampling, which distributes the samples over pixels by a pilot.

use super::variants::{Variant, claim_gain};
use crate::experiments::prelude::*;
use crate::render::{AdaptiveName, SamplerName, SilhouettesName};

pub(super) const ADAPTIVE: Experiment = Experiment {
    id: "adaptive",
    title: "as many samples for all pixels, or more for those with more noise: variance",
    headline: "samples where there is noise: variance {report.gain %.2f} times smaller in the report's room, {cornell.gain %.2f} in Cornell's",
    version: 3,
    equations: &[&equation::ADAPTIVE, &equation::SOBOL],
    run,
};

/// Samples per pixel on average.
const SAMPLES: u32 = 128;

/// Scenes, with one claim each.
const ROOMS: [SceneName; 3] = [
    SceneName::Report,
    SceneName::DiffuseRoom,
    SceneName::Cornell,
];

fn run(run: &mut Run) -> Result<(), Error> {
    let groups = run.by_tier(4, 24);
    let mut shown = Vec::new();
    for scene in ROOMS {
        let room = name(scene);
        let variant = |adaptive| Variant {
            label: format!("{room}, {adaptive:?}"),
            bar: room.clone(),
            job: Job {
                scene: scene.into(),
                sampler: SamplerName::Sobol,
                silhouettes: SilhouettesName::Yes,
                spp: SAMPLES,
                adaptive,
                size: [128, 96],
                ..Job::default()
            },
        };
        let variants = [variant(AdaptiveName::No), variant(AdaptiveName::Yes)];
        let variances = [
            variants[0].render(run, groups)?.variance,
            variants[1].render(run, groups)?.variance,
        ];
        shown.push(samples(&room, &variants[1].film(run, 0)?));
        let level = FAMILYWISE_LEVEL / ROOMS.len() as f64;
        let gain = claim_gain(
            run,
            &format!("{room}: samples go where noise is"),
            variances.each_ref(),
            level,
        );
        run.number(&format!("{room}.gain"), gain);
    }
    let description = "Blue: fewer samples than the mean; vermilion: more. They leave the background, and go to what glass and \
               mirrors show.";
    maps(run, "samples.svg", description, [1200, 900], 2, &shown)
}

/// Returns a map of the numbers of samples of a film's pixels.
fn samples(room: &str, film: &Film) -> Map {
    let size = film.size();
    let [width, height] = size.map(f64::from);
    let doublings = |samples: u32| (f64::from(samples) / f64::from(SAMPLES)).log2();
    Map {
        title: format!("{room}: samples of a pixel, {SAMPLES} in the mean"),
        axes: ["pixels from the left", "pixels from the bottom"].map(str::to_owned),
        ranges: [[0.0, width], [0.0, height]],
        size,
        values: film
            .pixels()
            .iter()
            .map(|pixel| doublings(pixel.samples()))
            .collect(),
        bound: 3.0,
        unit: "doublings of the mean".to_owned(),
    }
}
