//! How fast the estimators and their kernels are on this machine. Times decide nothing: they are numbers
//! only.

use std::hint::black_box;
use std::time::Instant;

use clap::ValueEnum as _;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Deserialize;
use whitefurnace::frame::Frame;

use crate::experiments::prelude::*;
use crate::render::{EngineName, OutlinesName, SamplerName};

pub(super) const SPEED: Experiment = Experiment {
    id: "speed",
    title: "camera samples and rays per second, on one thread and on all",
    version: 2,
    equations: &[&equation::ESTIMATOR],
    run,
};

/// The samples of figure 6: its pixels, 512 times.
const FIGURE_6: f64 = 1024.0 * 768.0 * 512.0;
/// Each time is the least of this many: what else the machine does only adds.
const ROUNDS: u32 = 3;

fn run(run: &mut Run) -> Result<(), Error> {
    let all = rayon::current_num_threads();
    run.number("threads", all as f64);
    let pools = [("one", pool(1)?), ("all", pool(all)?)];
    let base = Job { size: run.by_tier([64, 48], [256, 192]), spp: 16, ..Job::default() };
    for scene in [SceneName::Report, SceneName::DiffuseRoom] {
        for &estimator in EstimatorName::value_variants() {
            // One takes no number of samples, the other is measured by the rules of its own room.
            if matches!(estimator, EstimatorName::Radiosity | EstimatorName::Report) {
                continue;
            }
            let mut job = Job { scene: scene.into(), estimator, ..base };
            if matches!(estimator, EstimatorName::Photon | EstimatorName::Sppm) {
                job.photons.photons = base.size[0] * base.size[1];
            }
            image(run, &pools, (&name(scene), &name(estimator)), job)?;
        }
        variants(run, &pools, &name(scene), Job { scene: scene.into(), ..base })?;
    }
    let report = Job { convention: ConventionName::Report, estimator: EstimatorName::Report, ..base };
    let rate = image(run, &pools, ("seven-segments", "report"), report)?;
    image(run, &pools, ("seven-segments", "report-scalar"), Job { engine: EngineName::Scalar, ..report })?;
    run.number("figure-6.seconds", FIGURE_6 / rate);
    rays(run)?;
    peers(run)
}

/// Records `mis` one path at a time, with points for the outlines of lights, and with Sobol' points as well.
fn variants(run: &mut Run, pools: &[(&str, ThreadPool)], scene: &str, mis: Job) -> Result<(), Error> {
    let outlines = Job { outlines: OutlinesName::Yes, ..mis };
    for (method, job) in [
        ("mis-scalar", Job { engine: EngineName::Scalar, ..mis }),
        ("mis-outlines", outlines),
        ("mis-sobol", Job { sampler: SamplerName::Sobol, ..outlines }),
    ] {
        image(run, pools, (scene, method), job)?;
    }
    Ok(())
}

fn pool(threads: usize) -> Result<ThreadPool, Error> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| Error::Option(format!("{threads} threads cannot be started: {error}")))
}

/// Records millions of camera samples per second with each pool, maps of photons and all, and the
/// efficiency: one over the product of a sample's variance and its time. Returns samples per second with
/// the last pool.
fn image(run: &mut Run, pools: &[(&str, ThreadPool)], (scene, method): (&str, &str), job: Job) -> Result<f64, Error> {
    let job = run.prepared(job);
    let samples = f64::from(job.size[0] * job.size[1] * job.spp);
    let mut rate = 0.0;
    for (threads, pool) in pools {
        let mut made = None;
        let seconds = least_seconds(|| {
            made = Some(pool.install(|| run.render(&job, method))?);
            Ok(())
        })?;
        rate = samples / seconds;
        let key = format!("{scene}.{method}.{threads}");
        run.number(&key, rate / 1e6);
        run.note(&key, format!("{:.3} million samples/s", rate / 1e6));
        if let (Some(film), "one") = (made, *threads) {
            let efficiency = film.pixels().len() as f64 / (squared_error(&film) * seconds);
            run.number(&format!("{scene}.{method}.efficiency"), efficiency);
        }
    }
    Ok(rate)
}

/// Mean squared standard error of a pixel's channel: the variance of a sample over their number. Not the
/// whole error of methods whose pixels share photons or whose lookups are biased.
fn squared_error(film: &Film) -> f64 {
    let sum: f64 = film.pixels().iter().map(|p| p.standard_error().length_squared()).sum();
    sum / (3.0 * film.pixels().len() as f64)
}

fn least_seconds(mut work: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        work()?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// Records millions of rays per second on one thread: the nearest hit and the shadow ray, from where
/// camera rays hit the room.
fn rays(run: &mut Run) -> Result<(), Error> {
    let scene = room::diffuse()?;
    let seed = seed_for(run.seed(), "speed rays");
    let bounced: Vec<Ray> = (0..1024).filter_map(|i| bounced(&scene, &mut stream(seed, 0, i))).collect();
    let light = DVec3::new(4.0, 0.0, 4.99);
    let shadow: Vec<Ray> = bounced.iter().map(|ray| Ray::new(ray.origin, light - ray.origin)).collect();
    let closest = |ray: &Ray| {
        black_box(scene.bvh().closest(ray, f64::INFINITY));
    };
    let occluded = |ray: &Ray| {
        black_box(scene.bvh().occluded(ray, 1.0, |_| true));
    };
    query(run, "closest", &bounced, closest)?;
    query(run, "occluded", &shadow, occluded)
}

/// Records how many millions of these rays, again and again, are asked for per second.
fn query(run: &mut Run, key: &str, rays: &[Ray], ask: impl Fn(&Ray)) -> Result<(), Error> {
    let count = run.count(run.by_tier(100_000, 2_000_000));
    let seconds = least_seconds(|| {
        rays.iter().cycle().take(count as usize).for_each(|ray| ask(black_box(ray)));
        Ok(())
    })?;
    let rate = count as f64 / seconds / 1e6;
    run.number(&format!("rays.{key}"), rate);
    run.note(&format!("rays.{key}"), format!("{rate:.2} million rays/s"));
    Ok(())
}

/// A diffuse bounce off the first surface that a camera ray through a random place of the image meets.
fn bounced(scene: &Scene, rng: &mut Stream) -> Option<Ray> {
    let [x, y] = uniform2(rng);
    let hit = scene.intersect(&scene.camera().ray([4, 3], 4.0 * x, 3.0 * y))?;
    let direction = Frame::new(hit.normal).world(cosine_hemisphere(uniform2(rng)));
    Some(scene.leave(hit.point, hit.normal, direction))
}

/// What other renderers reach, from a record and not from this run.
#[derive(Deserialize)]
struct Peers {
    /// Where and how it was measured.
    source: String,
    peers: Vec<Peer>,
}

/// Millions of camera samples per second.
#[derive(Deserialize)]
struct Peer {
    name: String,
    title: String,
    /// With at most seven bounces.
    seven: Option<f64>,
    /// Without a limit, by roulette.
    unlimited: Option<f64>,
}

fn peers(run: &mut Run) -> Result<(), Error> {
    let peers: Peers = serde_json::from_str(include_str!("peers.json"))
        .map_err(|error| Error::Option(format!("peers.json cannot be read: {error}")))?;
    run.note("peers", peers.source);
    for peer in peers.peers {
        for (limit, rate) in [("seven", peer.seven), ("unlimited", peer.unlimited)] {
            if let Some(rate) = rate {
                run.number(&format!("peer.{}.{limit}", peer.name), rate);
                run.note(&format!("peer.{}.{limit}", peer.name), format!("{rate} million samples/s, {}", peer.title));
            }
        }
    }
    Ok(())
}
