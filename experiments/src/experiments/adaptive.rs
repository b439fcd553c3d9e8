//! Variance reduction by adaptive sampling, which distributes the samples over pixels by a pilot.

use whitefurnace::render::adaptive::REPLICATIONS;

use super::scrambles::claim_gain;
use crate::experiments::prelude::*;
use crate::render::{AdaptiveName, SamplerName, SilhouettesName};

pub(super) const ADAPTIVE: Experiment = Experiment {
    id: "adaptive",
    title: "as many samples for all pixels, or more for those with more noise: variance",
    headline: "samples where there is noise: variance {report.gain %.2f} times smaller in the report's room, {cornell.gain %.2f} in Cornell's",
    version: 2,
    equations: &[&equation::ADAPTIVE, &equation::SOBOL],
    run,
};

/// Samples per pixel on average, and that number including the pilot's.
const SAMPLES: u32 = 128;
const WITH_PILOT: u32 = SAMPLES + REPLICATIONS;

/// Number of films whose spread is one estimate of the variance.
const GROUP: usize = 4;

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
        let film = |adaptive, k: usize| {
            let spp = if adaptive == AdaptiveName::Yes {
                SAMPLES
            } else {
                WITH_PILOT
            };
            let (sampler, silhouettes, size) =
                (SamplerName::Sobol, SilhouettesName::Yes, [128, 96]);
            let job = Job {
                scene: scene.into(),
                sampler,
                silhouettes,
                spp,
                adaptive,
                size,
                ..Job::default()
            };
            let seed = seed_for(run.seed(), &format!("{room}, {adaptive:?} {k}"));
            Job {
                seed,
                ..run.with_run_options(job)
            }
            .render(&room)?
            .into_complete()
        };
        let mut variances = [Moments::default(); 2];
        for (variances, adaptive) in variances
            .iter_mut()
            .zip([AdaptiveName::No, AdaptiveName::Yes])
        {
            for group in 0..groups {
                let films = (0..GROUP)
                    .map(|k| film(adaptive, GROUP * group + k))
                    .collect::<Result<Vec<_>, _>>()?;
                variances.push(variance(&films));
            }
        }
        shown.push(samples(&room, &film(AdaptiveName::Yes, 0)?));
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
    maps(
        &run.figure("samples.svg"),
        description,
        [1200, 900],
        2,
        &shown,
    )
}

/// Returns the mean over pixels and channels of the variance among films.
pub(super) fn variance(films: &[Film]) -> f64 {
    let pixels = films[0].pixels().len();
    let of = |at: usize, channel: usize| {
        films
            .iter()
            .map(|film| film.pixels()[at].mean()[channel])
            .collect::<Moments>()
            .variance()
    };
    (0..pixels)
        .map(|at| (0..3).map(|channel| of(at, channel)).sum::<f64>())
        .sum::<f64>()
        / (3.0 * pixels as f64)
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
