//! The report's claim that photon mapping would reduce the rendering time because it reduces the
//! number of shadow rays: rays are counted, and errors compared at equal numbers of them.

use std::sync::atomic::{AtomicU64, Ordering};

use whitefurnace::integrator::{Bidirectional, FiniteElements, NextEvent, Photons};
use whitefurnace::light::emitter::{Emitter, EmitterPoint};
use whitefurnace::material::Scattering;
use whitefurnace::sampling::roulette;
use whitefurnace::sampling::roulette::Roulette;
use whitefurnace::sampling::sampler::ImagePass;

use crate::experiments::prelude::*;

pub(super) const SHADOW_RAYS: Experiment = Experiment {
    id: "shadow-rays",
    title: "shadow rays and error at equal numbers of rays: path tracing and photon mapping",
    headline: "final gathering sends {gather.shadow_rays %.2f} shadow rays per sample, path tracing {mis.shadow_rays %.2f}; at equal rays its error is {error_ratio.mis %.2f} of path tracing's",
    version: 1,
    equations: &[&equation::PHOTON_DENSITY, &equation::RENDERING],
    run,
};

const SIZE: [u32; 2] = [64, 48];
/// Samples per pixel of photon mapping; path tracing gets as many as use the same number of rays.
const SAMPLES: u32 = 16;
const PARTICLES: u32 = 50_000;
const RADIUS: f64 = 0.2;

/// The standard parts of an estimator, with counters of rays.
struct CountingParts<'a>(&'a Rays);

/// Numbers of rays so far, without the camera rays.
#[derive(Default)]
struct Rays {
    shadow: AtomicU64,
    onward: AtomicU64,
    /// Points sampled on emitters: one for each particle, and one at each vertex that sends a
    /// shadow ray.
    picks: AtomicU64,
}

impl Roulette for CountingParts<'_> {
    fn survives(&self, r: f64, survival: f64) -> bool {
        let survives = roulette::survives(r, survival);
        self.0
            .onward
            .fetch_add(u64::from(survives), Ordering::Relaxed);
        survives
    }
}

impl NextEvent for CountingParts<'_> {
    fn visible(&self, scene: &Scene, x: SurfacePoint, y: SurfacePoint, glass: bool) -> bool {
        self.0.shadow.fetch_add(1, Ordering::Relaxed);
        scene.visible(x, y, glass)
    }
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        self.0.picks.fetch_add(1, Ordering::Relaxed);
        DefaultParts.sample_emitter(emitter, random)
    }
}

impl Scattering for CountingParts<'_> {}
impl Photons for CountingParts<'_> {}
impl Bidirectional for CountingParts<'_> {}
impl FiniteElements for CountingParts<'_> {}

/// Cost of a method's images per camera sample, and their error.
#[derive(Clone, Copy)]
struct Cost {
    shadow: f64,
    rays: f64,
    picks: f64,
    /// Root-mean-square error of the pixels, relative to the mean.
    error: f64,
}

impl Cost {
    /// Adds the sampled emitter points to the rays: with photon mapping each starts a particle or
    /// belongs to a gathering ray.
    fn with_picks(self) -> Self {
        Self {
            rays: self.rays + self.picks,
            ..self
        }
    }
}

fn run(run: &mut Run) -> Result<(), Error> {
    let scene = &room::diffuse()?;
    let images = run.count(run.by_tier(3, 24)).max(2) as u32;
    let reference = run.count(run.by_tier(2_000, 20_000)) as u32;
    let seed = seed_for(run.seed(), "reference");
    let reference = render_paths(scene, Path::default(), pixel_centres(seed), SIZE, reference)?;

    let gather = Lookup::FinalGather {
        caustic_particles: 1,
        caustic_radius: RADIUS,
    };
    let photon = |lookup| {
        move |rays: &Rays, seed| {
            let parts = CountingParts(rays);
            let photons = PhotonMapping::new(
                Parts::replaced(&parts),
                scene,
                lookup,
                PARTICLES,
                RADIUS,
                ImagePass::independent(seed, 0),
            )?;
            film(scene, &photons, seed, SAMPLES)
        }
    };
    let master = run.seed();
    let bar = Bar::new("", u64::from(4 * images), "samples");
    let trace = |name, images, samples, make: &dyn Fn(&Rays, u64) -> Result<Film, Error>| {
        measure(
            seed_for(master, name),
            images,
            samples,
            &reference,
            &bar,
            make,
        )
    };
    let gathering = trace("gather", images, SAMPLES, &photon(gather))?.with_picks();
    let direct = trace(
        "direct",
        images,
        SAMPLES,
        &photon(Lookup::DirectVisualization),
    )?
    .with_picks();
    report(run, "gather", SAMPLES, &gathering);
    report(run, "direct", SAMPLES, &direct);
    for (name, strategy) in [("mis", Strategy::Mis), ("light", Strategy::Light)] {
        let path = |samples| {
            move |rays: &Rays, seed| {
                let parts = CountingParts(rays);
                let path = Path::new(strategy).with_parts(Parts::replaced(&parts));
                film(scene, &path, seed, samples)
            }
        };
        let pilot = trace("pilot", 2, 1, &path(1))?;
        let samples = f64::from(SAMPLES) * gathering.rays / pilot.rays;
        let samples = samples.round().max(1.0) as u32;
        let cost = trace(name, images, samples, &path(samples))?;
        report(run, name, samples, &cost);
        let what = format!("final gathering sends fewer shadow rays per sample than {name}");
        run.claim(
            &what,
            format!("{:.2} for {:.2}", gathering.shadow, cost.shadow),
            gathering.shadow < cost.shadow,
        );
        let ratio = gathering.error / cost.error;
        let what =
            format!("error of final gathering over that of {name} at the same number of rays");
        run.note(&what, format!("{ratio:.2}"));
        run.number(&format!("error_ratio.{name}"), ratio);
    }
    run.claim(
        "lookups at the first diffuse surface send no shadow rays",
        format!("{:.2} per sample", direct.shadow),
        direct.shadow == 0.0,
    );
    Ok(())
}

/// Renders images with different seeds and compares them with the reference.
fn measure(
    seed: u64,
    images: u32,
    samples: u32,
    reference: &Film,
    bar: &Bar,
    make: &dyn Fn(&Rays, u64) -> Result<Film, Error>,
) -> Result<Cost, Error> {
    let rays = Rays::default();
    let mut squared = Moments::default();
    for image in 0..images {
        squared.push(difference(
            &make(&rays, seed_for(seed, &image.to_string()))?,
            reference,
        ));
        if !bar.advance(1) {
            return Err(Error::Interrupted);
        }
    }
    let count = f64::from(images) * f64::from(samples) * reference.pixels().len() as f64;
    let per_sample = |counter: &AtomicU64| counter.load(Ordering::Relaxed) as f64 / count;
    let shadow = per_sample(&rays.shadow);
    Ok(Cost {
        shadow,
        rays: 1.0 + shadow + per_sample(&rays.onward),
        picks: per_sample(&rays.picks),
        error: squared.mean().sqrt(),
    })
}

fn report(run: &mut Run, name: &str, samples: u32, cost: &Cost) {
    let Cost {
        shadow,
        rays,
        error,
        ..
    } = *cost;
    run.numbers(
        name,
        [("shadow_rays", shadow), ("rays", rays), ("error", error)],
    );
    let percent = 100.0 * error;
    let value = format!(
        "{shadow:.2} shadow rays and {rays:.2} rays in all per sample, relative root-mean-square error {percent:.2} %"
    );
    run.note(&format!("{name}, {samples} samples per pixel"), value);
}

fn film(scene: &Scene, estimator: &dyn Estimator, seed: u64, samples: u32) -> Result<Film, Error> {
    render_samples(scene, estimator, pixel_centres(seed), SIZE, samples)
}

/// Returns the mean squared difference of the pixels, relative to the square of the reference's
/// mean.
fn difference(film: &Film, reference: &Film) -> f64 {
    let pairs = film.pixels().iter().zip(reference.pixels());
    let sum: f64 = pairs
        .map(|(a, b)| (a.mean() - b.mean()).length_squared() / 3.0)
        .sum();
    sum / film.pixels().len() as f64 / reference.mean().powi(2)
}

#[cfg(test)]
mod tests {
    use whitefurnace::scene::simple::furnace_box;

    use super::*;

    /// Emitting black walls scatter nothing, so a sample is its camera ray.
    #[test]
    fn a_camera_ray_counts() {
        let scene = &furnace_box(0.0).expect("a scene");
        let reference = film(scene, &Path::default(), 1, 1).expect("a film");
        let make = |rays: &Rays, seed| {
            let parts = CountingParts(rays);
            let path = Path::new(Strategy::Mis).with_parts(Parts::replaced(&parts));
            film(scene, &path, seed, 2)
        };
        let cost = measure(1, 2, 2, &reference, &Bar::new("", 1, ""), &make).expect("a cost");
        assert_eq!([cost.rays, cost.shadow], [1.0, 0.0]);
    }
}
