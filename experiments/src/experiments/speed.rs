//! Speed of the estimators and their kernels on this machine, and its dependence on sizes. Times
//! are recorded as numbers; no claim depends on them.

pub(super) mod growth;
mod kernels;
mod memory;

use std::time::Instant;

use clap::ValueEnum as _;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Deserialize;

use crate::experiments::prelude::*;
use crate::render::{PrecisionName, SamplerName, SilhouettesName, SpecularNeeName};

pub(super) const SPEED: Experiment = Experiment {
    id: "speed",
    title: "camera samples and rays per second, what they depend on, and what a sample is worth",
    headline: "the report's room: {report.mis.all %.2f} million camera samples per second by path tracing on all threads",
    version: 5,
    equations: &[&equation::ESTIMATOR, &equation::SINGLE_PRECISION],
    run,
};

/// Number of camera samples of figure 6: its pixels, 512 times.
const FIGURE_6: f64 = 1024.0 * 768.0 * 512.0;
/// Number of measurements, of which the least counts: other load on the machine only adds time.
const ROUNDS: u32 = 3;

fn run(run: &mut Run) -> Result<(), Error> {
    estimators(run)?;
    growth::with_threads(run)?;
    growth::with_samples(run)?;
    growth::with_triangles(run)?;
    kernels::rays(run)?;
    kernels::eight_rays(run)?;
    memory::of_an_image(run)?;
    peers(run)
}

fn estimators(run: &mut Run) -> Result<(), Error> {
    let all = rayon::current_num_threads();
    run.number("threads", all as f64);
    let pools = [("one", pool(1)?), ("all", pool(all)?)];
    let base = Job {
        size: run.by_tier([16, 12], [128, 96]),
        ..Job::default()
    };
    for scene in [SceneName::Report, SceneName::DiffuseRoom] {
        for &estimator in EstimatorName::value_variants() {
            // Radiosity takes no number of samples, and the report's estimator uses other rules in
            // its own room.
            if matches!(estimator, EstimatorName::Radiosity | EstimatorName::Report) {
                continue;
            }
            let mut job = Job {
                scene: scene.into(),
                estimator,
                ..base
            };
            if matches!(estimator, EstimatorName::Photon | EstimatorName::Sppm) {
                job.photons.photons = base.size[0] * base.size[1];
            } else {
                sobol(run, &pools, &name(scene), &name(estimator), job)?;
            }
            image(run, &pools, &name(scene), &name(estimator), job)?;
        }
        let mis = Job {
            scene: scene.into(),
            ..base
        };
        let single = Job {
            precision: PrecisionName::Single,
            ..mis
        };
        let silhouettes = Job {
            silhouettes: SilhouettesName::Yes,
            ..mis
        };
        for (method, job) in [("mis-single", single), ("mis-outlines", silhouettes)] {
            image(run, &pools, &name(scene), method, job)?;
            sobol(run, &pools, &name(scene), method, job)?;
        }
        if scene == SceneName::Report {
            let straight = Job {
                specular_nee: SpecularNeeName::No,
                ..silhouettes
            };
            sobol(run, &pools, &name(scene), "mis-straight", straight)?;
        }
    }
    let report = Job {
        convention: ConventionName::Report,
        estimator: EstimatorName::Report,
        ..base
    };
    let rate = image(run, &pools, "seven-segments", "report", report)?;
    run.number("figure-6.seconds", FIGURE_6 / rate);
    let rate = image(
        run,
        &pools,
        "seven-segments",
        "report-single",
        Job {
            precision: PrecisionName::Single,
            ..report
        },
    )?;
    run.number("figure-6.single.seconds", FIGURE_6 / rate);
    Ok(())
}

fn pool(threads: usize) -> Result<ThreadPool, Error> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| Error::Option(format!("{threads} threads cannot be started: {error}")))
}

/// Records speed and efficiency with Sobol' points, on one thread: they change the efficiency of a
/// sample.
fn sobol(
    run: &mut Run,
    pools: &[(&str, ThreadPool); 2],
    scene: &str,
    method: &str,
    job: Job,
) -> Result<(), Error> {
    let job = Job {
        sampler: SamplerName::Sobol,
        ..job
    };
    image(run, &pools[..1], scene, &format!("{method}.sobol"), job)?;
    Ok(())
}

/// Records millions of camera samples per second with each thread pool, including photon maps, and
/// the efficiency: one over the product of a sample's variance, relative to the squared mean of the
/// image, and its time in microseconds. Returns samples per second with the last pool.
fn image(
    run: &mut Run,
    pools: &[(&str, ThreadPool)],
    scene: &str,
    method: &str,
    job: Job,
) -> Result<f64, Error> {
    let mut rate = 0.0;
    for (threads, pool) in pools {
        let (film, seconds) = rendered(run, pool, job, method)?;
        rate = samples(&film) / seconds;
        record_rate(run, &format!("{scene}.{method}.{threads}"), rate);
        if *threads == "one" {
            let variance = squared_error(&film) / film.mean().powi(2);
            let efficiency = film.pixels().len() as f64 / (variance * seconds * 1e6);
            run.number(&format!("{scene}.{method}.efficiency"), efficiency);
        }
    }
    Ok(rate)
}

fn record_rate(run: &mut Run, key: &str, rate: f64) {
    run.number(key, rate / 1e6);
    run.note(key, format!("{:.3} million samples/s", rate / 1e6));
}

/// Renders a job's image and returns it with the seconds that these threads took.
fn rendered(run: &Run, pool: &ThreadPool, job: Job, label: &str) -> Result<(Film, f64), Error> {
    let job = run.with_run_options(job);
    least_seconds(run, || pool.install(|| run.render(&job, label)))
}

/// Returns the number of samples of all pixels.
fn samples(film: &Film) -> f64 {
    f64::from(film.replications())
        * f64::from(film.samples_per_replication())
        * film.pixels().len() as f64
}

/// Returns the mean squared standard error of a pixel's channel: the variance of a sample over
/// their number. It is not the whole error of methods whose pixels share photons or whose lookups
/// are biased.
fn squared_error(film: &Film) -> f64 {
    let sum: f64 = film
        .pixels()
        .iter()
        .map(|p| p.standard_error().length_squared())
        .sum();
    sum / (3.0 * film.pixels().len() as f64)
}

/// Runs the work up to [`ROUNDS`] times and returns its result and the least duration in seconds.
/// Long work, which other load disturbs less, is repeated less often.
fn least_seconds<T>(
    run: &Run,
    mut work: impl FnMut() -> Result<T, Error>,
) -> Result<(T, f64), Error> {
    let enough = run.by_tier(0.1, 2.0);
    let begin = Instant::now();
    let mut least = f64::INFINITY;
    let mut rounds = 0;
    loop {
        let start = Instant::now();
        let made = work()?;
        least = least.min(start.elapsed().as_secs_f64());
        rounds += 1;
        if rounds == ROUNDS || begin.elapsed().as_secs_f64() > enough {
            return Ok((made, least));
        }
    }
}

/// Recorded speeds of other renderers, not measured by this run.
#[derive(Deserialize)]
struct Peers {
    /// Place and method of the measurement.
    source: String,
    peers: Vec<Peer>,
}

/// Millions of camera samples per second.
#[derive(Deserialize)]
struct Peer {
    name: String,
    title: String,
    /// Rate with at most seven bounces.
    seven: Option<f64>,
    /// Rate without a limit, with Russian roulette.
    unlimited: Option<f64>,
}

fn peers(run: &mut Run) -> Result<(), Error> {
    let peers: Peers = recorded("peers.json", include_str!("speed/peers.json"))?;
    run.note("peers", peers.source);
    for peer in peers.peers {
        for (limit, rate) in [("seven", peer.seven), ("unlimited", peer.unlimited)] {
            if let Some(rate) = rate {
                let key = format!("peer.{}.{limit}", peer.name);
                run.number(&key, rate);
                let value = format!("{rate} million samples/s, {}", peer.title);
                run.note(&key, value);
            }
        }
    }
    Ok(())
}
