//! The report's claim that photon mapping would improve the rendering time because it reduces the number
//! of shadow rays: rays are counted, and errors compared at equal numbers of them.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use whitefurnace::equation;
use whitefurnace::error::Error;
use whitefurnace::estimator::{Estimator, Lookup, Parts, Path, PhotonMapping, Standard, Strategy};
use whitefurnace::film::Film;
use whitefurnace::moments::Moments;
use whitefurnace::pixel::PixelSampling;
use whitefurnace::render::{Numbers, Sampling, render};
use whitefurnace::rng::seed_for;
use whitefurnace::roulette;
use whitefurnace::scene::{Scene, room};

use crate::lab::{Experiment, Lab};

/// Counts the rays of path tracing and photon mapping in the diffuse room.
pub const SHADOW_RAYS: Experiment = Experiment {
    id: "shadow-rays",
    title: "shadow rays and error at equal numbers of rays: path tracing and photon mapping",
    version: 1,
    equations: &[&equation::PHOTON_DENSITY, &equation::RENDERING],
    run,
};

const SIZE: [u32; 2] = [64, 48];
/// Samples per pixel of photon mapping; path tracing gets as many as have the same number of rays.
const SAMPLES: u32 = 16;
const PARTICLES: u32 = 50_000;
const RADIUS: f64 = 0.2;

/// The standard parts with a count of rays.
struct Counted<'a>(&'a Rays);

/// Rays so far, but for one per camera sample.
#[derive(Default)]
struct Rays {
    shadow: AtomicU64,
    onward: AtomicU64,
    /// Emitters picked: once for each particle, and once at each vertex that sends a shadow ray.
    picks: AtomicU64,
}

impl Parts for Counted<'_> {
    fn visible(&self, scene: &Scene, x: (DVec3, DVec3), y: (DVec3, DVec3), glass: bool) -> bool {
        self.0.shadow.fetch_add(1, Ordering::Relaxed);
        scene.visible(x, y, glass)
    }

    fn survives(&self, r: f64, survival: f64) -> bool {
        let survives = roulette::survives(r, survival);
        self.0
            .onward
            .fetch_add(u64::from(survives), Ordering::Relaxed);
        survives
    }

    fn pick_emitter(&self, r: f64, count: usize) -> usize {
        self.0.picks.fetch_add(1, Ordering::Relaxed);
        Standard.pick_emitter(r, count)
    }
}

/// What several images by one method cost and miss.
#[derive(Default)]
struct Cost {
    shadow_per_sample: f64,
    rays_per_sample: f64,
    /// Relative mean squared error of an image, a value each.
    squared: Moments,
}

fn run(lab: &mut Lab) -> Result<(), Error> {
    let scene = room::diffuse()?;
    let images = lab.count(lab.by_tier(6, 24)).max(2) as u32;
    let reference = lab.count(lab.by_tier(2_000, 20_000)) as u32;
    let seed = seed_for(lab.seed(), "reference");
    let reference = film(&scene, &Path::<Standard>::default(), seed, reference)?;

    let gather = Lookup::Gather {
        caustic_particles: 1,
        caustic_radius: RADIUS,
    };
    let photon = |lookup| {
        let scene = &scene;
        move |rays: &Rays, seed| {
            let parts = Counted(rays);
            let map = (PARTICLES, RADIUS);
            let photons = PhotonMapping::new(parts, scene, lookup, map, (seed, 0))?;
            film(scene, &photons, seed, SAMPLES)
        }
    };
    let gathering = measure(
        lab,
        "gather",
        images,
        SAMPLES,
        &reference,
        photon(gather),
        true,
    )?;
    let direct = measure(
        lab,
        "direct",
        images,
        SAMPLES,
        &reference,
        photon(Lookup::Direct),
        true,
    )?;
    for (name, strategy) in [("mis", Strategy::Mis), ("light", Strategy::Light)] {
        let path = |samples| {
            let scene = &scene;
            move |rays: &Rays, seed| {
                let parts = Counted(rays);
                film(scene, &Path { parts, strategy }, seed, samples)
            }
        };
        let pilot = measure(lab, name, 2, 1, &reference, path(1), false)?;
        let samples = f64::from(SAMPLES) * gathering.rays_per_sample / pilot.rays_per_sample;
        let samples = samples.round().max(1.0) as u32;
        let cost = measure(lab, name, images, samples, &reference, path(samples), false)?;
        lab.claim(
            &format!("final gathering sends fewer shadow rays per sample than {name}"),
            format!(
                "{:.2} for {:.2}",
                gathering.shadow_per_sample, cost.shadow_per_sample
            ),
            gathering.shadow_per_sample < cost.shadow_per_sample,
        );
        lab.note(
            &format!("error of final gathering over that of {name} at the same number of rays"),
            format!(
                "{:.2}",
                (gathering.squared.mean() / cost.squared.mean()).sqrt()
            ),
        );
        lab.number(
            &format!("error_ratio.{name}"),
            (gathering.squared.mean() / cost.squared.mean()).sqrt(),
        );
    }
    lab.claim(
        "lookups at the first diffuse surface send no shadow rays",
        format!("{:.2} per sample", direct.shadow_per_sample),
        direct.shadow_per_sample == 0.0,
    );
    Ok(())
}

/// Makes images with seeds of their own and compares them with the reference. `picks_are_rays` where a
/// pick starts a particle or goes with a gathering ray.
fn measure(
    lab: &mut Lab,
    name: &str,
    images: u32,
    samples: u32,
    reference: &Film,
    make: impl Fn(&Rays, u64) -> Result<Film, Error>,
    picks_are_rays: bool,
) -> Result<Cost, Error> {
    let rays = Rays::default();
    let mut squared = Moments::default();
    for image in 0..images {
        let made = make(&rays, seed_for(lab.seed(), &format!("{name} {image}")))?;
        squared.push(difference(&made, reference));
    }
    let count = f64::from(images) * f64::from(samples) * reference.pixels().len() as f64;
    let per_sample = |counter: &AtomicU64| counter.load(Ordering::Relaxed) as f64 / count;
    let shadow = per_sample(&rays.shadow);
    let picks = if picks_are_rays {
        per_sample(&rays.picks)
    } else {
        0.0
    };
    let cost = Cost {
        shadow_per_sample: shadow,
        rays_per_sample: 1.0 + shadow + per_sample(&rays.onward) + picks,
        squared,
    };
    let error = cost.squared.mean().sqrt();
    lab.number(&format!("{name}.shadow_rays"), cost.shadow_per_sample);
    lab.number(&format!("{name}.rays"), cost.rays_per_sample);
    lab.number(&format!("{name}.error"), error);
    lab.note(
        &format!("{name}, {samples} samples per pixel"),
        format!(
            "{:.2} shadow rays and {:.2} rays in all per sample, relative root-mean-square error {:.2} %",
            cost.shadow_per_sample,
            cost.rays_per_sample,
            100.0 * error
        ),
    );
    Ok(cost)
}

fn film<E: Estimator>(
    scene: &Scene,
    estimator: &E,
    seed: u64,
    samples: u32,
) -> Result<Film, Error> {
    let sampling = Sampling {
        pixel: PixelSampling::Centre,
        numbers: Numbers::Independent,
        seed,
    };
    let mut film = Film::new(SIZE, None, 1)?;
    render(
        scene,
        estimator,
        sampling,
        &mut film,
        &(0..samples),
        &|_| true,
    )?;
    Ok(film)
}

/// Mean squared difference of the pixels, relative to the square of the reference's mean.
fn difference(film: &Film, reference: &Film) -> f64 {
    let pairs = film.pixels().iter().zip(reference.pixels());
    let sum: f64 = pairs
        .map(|(a, b)| (a.mean() - b.mean()).length_squared() / 3.0)
        .sum();
    sum / film.pixels().len() as f64 / reference.mean().powi(2)
}
