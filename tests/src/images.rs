//! Trials of whole films, as `render` makes them with an estimator.

use std::ops::Range;

use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::harness::images::{ImageMoments, PixelStatistics, image_mean, welch_map};
use whitefurnace::integrator::{Report, Whitted};
use whitefurnace::render::render;
use whitefurnace::sampling::Sampling;
use whitefurnace::sampling::pixel::PixelSampling;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::simple::{Cap, cavity_cap, closed_cube, furnace_under};

use crate::prelude::*;
use crate::scenes::{FLOOR, LIGHT, ball, light, scene, seen_by, square, valid};

/// The replications of a scene's image that are rendered.
pub(super) struct Frames<'a> {
    pub scene: &'a Scene,
    pub size: [u32; 2],
    pub replications: Range<u32>,
}

impl<'a> Frames<'a> {
    /// Returns the first replications of an image.
    pub fn first(scene: &'a Scene, size: [u32; 2], count: u64) -> Self {
        Self {
            scene,
            size,
            replications: 0..count as u32,
        }
    }
}

/// Renders a film with every ray through its pixel's centre, so that edges add no noise; `None` if
/// the estimator returns a value that no film can hold, which is a fault.
pub(super) fn film(
    context: &Context,
    part: &str,
    frames: &Frames,
    estimator: &dyn Estimator,
) -> Option<Film> {
    let seed = context.seed_of(part);
    independent_film(frames, estimator, PixelSampling::Centre, seed).ok()
}

/// Renders a film by independent random numbers.
///
/// # Errors
/// Those of [`render`].
pub(super) fn independent_film(
    frames: &Frames,
    estimator: &dyn Estimator,
    pixel: PixelSampling,
    seed: u64,
) -> Result<Film, Error> {
    let Frames {
        scene,
        size,
        ref replications,
    } = *frames;
    let sampling = Sampling {
        sampler: SamplerKind::Independent,
        pixel,
        seed,
        silhouettes: false,
    };
    let mut film = Film::new(size, None, 1)?;
    render(scene, estimator, sampling, &mut film, replications, &|_| {
        true
    })?;
    Ok(film)
}

/// Weights of the channels in the one number that stands for a pixel: unequal, so that exchanged or
/// mixed channels change it.
pub(super) const CHANNEL_WEIGHTS: DVec3 = DVec3::new(1.0 / 7.0, 2.0 / 7.0, 4.0 / 7.0);

/// Statistics of each pixel's value, in which the channels are weighted by [`CHANNEL_WEIGHTS`].
pub(super) struct PixelMoments {
    mean: Vec<f64>,
    variance: Vec<f64>,
    count: Vec<u64>,
    skewness: Vec<f64>,
}

impl PixelMoments {
    /// Renders replication by replication, because a film keeps neither covariances of channels nor
    /// third moments.
    pub fn render(
        context: &Context,
        part: &str,
        frames: &Frames,
        estimator: &dyn Estimator,
    ) -> Option<Self> {
        let size = frames.size;
        let mut pixels = vec![Values::new(0.0); (size[0] * size[1]) as usize];
        for replication in frames.replications.clone() {
            let one = Frames {
                replications: replication..replication + 1,
                ..*frames
            };
            let film = film(context, part, &one, estimator)?;
            for (values, pixel) in pixels.iter_mut().zip(film.pixels()) {
                values.push(pixel.mean().dot(CHANNEL_WEIGHTS));
            }
        }
        let column = |of: fn(&Values) -> f64| pixels.iter().map(of).collect();
        Some(Self {
            mean: column(|v| v.moments.mean()),
            variance: column(|v| v.moments.variance()),
            count: pixels.iter().map(|v| v.moments.count()).collect(),
            skewness: column(Values::skewness),
        })
    }

    pub fn statistics(&self) -> PixelStatistics<'_> {
        PixelStatistics {
            mean: &self.mean,
            variance: &self.variance,
            count: &self.count,
        }
    }
}

/// Renders the images of an estimator and of the path tracer.
fn with_path(
    context: &Context,
    part: &str,
    frames: &Frames,
    estimator: &dyn Estimator,
) -> Option<[PixelMoments; 2]> {
    let image = PixelMoments::render(context, part, frames, estimator)?;
    Some([
        image,
        PixelMoments::render(context, "path", frames, &Path::default())?,
    ])
}

/// Tests the means of two images for equality within a relative margin.
pub(super) fn same_mean(name: &str, a: &PixelMoments, b: &PixelMoments, margin: f64) -> Outcome {
    let statistics = [a, b].map(PixelMoments::statistics);
    let side = |i: usize| ImageMoments {
        statistics: &statistics[i],
        skewness: &[a, b][i].skewness,
    };
    image_mean(name, side(0), side(1), margin)
}

/// The outcome of an estimator whose values no film can hold.
pub(super) fn not_a_film(name: &str) -> Vec<Outcome> {
    let worst = "a radiance that no film holds";
    vec![Outcome::identity(name, 1, f64::NAN, 0.0, worst)]
}

/// Compares the mean of the pixels of the white furnace under a coloured sky with the sky's
/// radiance, the expectation of every pixel.
struct WhiteFurnace(Arc<Scene>);

const SKY: DVec3 = DVec3::new(1.0, 3.0, 0.5);

const FURNACE_SIZE: [u32; 2] = [24, 8];
const FURNACE_REPLICATIONS: u64 = 16_500;

/// Returns the camera of a wide image that the three bodies of the white furnace fill: pixels of
/// the sky have no noise, and a sample of few others is skewed.
pub(super) fn near_furnace() -> Camera {
    Camera::new(-8.0 * DVec3::Y, DVec3::ZERO, DVec3::Z, 0.13)
}

impl Property for WhiteFurnace {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let path = Path::new(Strategy::Mis).with_parts(setup.parts);
        let frames = Frames::first(&self.0, FURNACE_SIZE, 1);
        // One value per replication of the whole film: a mean of many pixels, nearly normal.
        let mut values = Values::new(1.0);
        for replication in 0..context.n(FURNACE_REPLICATIONS) {
            let part = format!("film {replication}");
            let Some(film) = film(context, &part, &frames, &path) else {
                return not_a_film("film");
            };
            let sum: DVec3 = film.pixels().iter().map(Pixel::mean).sum();
            let number = film.pixels().len() as f64;
            values.push((sum / SKY).element_sum() / (3.0 * number));
        }
        let claim = Claim::Equal { delta: IMAGE_DELTA };
        vec![mean("image mean", &values, 1.0, claim)]
    }
}

/// Compares the path tracer with the report's estimator under physical rules in the all-diffuse
/// room: two directions of sampling, two roulettes, with and without multiple importance sampling.
struct SameImage(Arc<Scene>);

const ROOM_SIZE: [u32; 2] = [32, 24];
const ROOM_REPLICATIONS: u64 = 1_200;
/// Segments of the report's estimator. The remainder is below 2⁻²⁰ of the whole, a thousandth of
/// the margin and less, as no albedo exceeds 1/2.
const ROOM_SEGMENTS: u32 = 20;
/// Absorption of all surfaces, which ends the report's paths.
const ROOM_ABSORPTION: f64 = 0.25;

/// Builds coloured balls in a coloured cube, without its light in sight.
///
/// A bounce multiplies the report's radiance by 2ρ cos θ/(1 − α), if the path survives. The third
/// moment of that is 2ρ³/(1 − α)², and must be below 1 for the sum over all bounces to have one:
/// else the sample skewness never settles. With albedos of 3/4, as in the report's room, it is 1.5.
fn coloured_room() -> Arc<Scene> {
    let camera = Camera::new(
        DVec3::new(-0.8, -0.7, 0.4),
        DVec3::new(0.6, 0.5, -0.7),
        DVec3::Z,
        0.5,
    );
    seen_by(camera, "coloured room", |s| {
        let surface = |albedo| Surface::new(Bsdf::Lambert { albedo }).absorbing(ROOM_ABSORPTION);
        let wall = s.surface(surface(DVec3::new(0.5, 0.4, 0.25)));
        closed_cube(s, 1.0, true, wall);
        let [red, green] = [DVec3::new(0.5, 0.2, 0.1), DVec3::new(0.3, 0.5, 0.2)].map(surface);
        ball(s, Sphere::new(DVec3::new(0.5, 0.1, -0.6), 0.4), red);
        ball(s, Sphere::new(DVec3::new(-0.1, 0.6, -0.5), 0.3), green);
        square(s, 0.99 * DVec3::Z, 0.4, false, light(LIGHT));
    })
}

/// Largest distance of the pixels' p-values from the uniform distribution.
const FLATNESS: f64 = 0.25;

impl Property for SameImage {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let report = Report {
            parts: setup.parts,
            rays: 1,
            segments: setup.segments.unwrap_or(ROOM_SEGMENTS),
            rules: setup.rules,
        };
        let frames = Frames::first(&self.0, ROOM_SIZE, context.n(ROOM_REPLICATIONS));
        let Some([a, b]) = with_path(context, "report", &frames, &report) else {
            return not_a_film("film");
        };
        let pixels = welch_map(&a.statistics(), &b.statistics(), ROOM_SIZE[0] as usize, 1);
        // The bias of the limit on segments must not fail the test.
        let mean = same_mean("image mean", &a, &b, IMAGE_DELTA).as_equivalence();
        vec![mean, pixels.flatness("p-values of pixels", FLATNESS)]
    }
}

/// Compares Whitted's estimator with the path tracer on a convex diffuse object under a light that
/// reflects nothing: no light meets two diffuse surfaces, so Whitted leaves nothing out.
struct Convex(Arc<Scene>);

const CONVEX_SIZE: [u32; 2] = [32, 32];
const CONVEX_REPLICATIONS: u64 = 1_620;

impl Property for Convex {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let whitted = Whitted {
            parts: setup.parts,
            segments: setup.segments.unwrap_or(1),
            rules: setup.rules,
        };
        let frames = Frames::first(&self.0, CONVEX_SIZE, context.n(CONVEX_REPLICATIONS));
        let Some([a, b]) = with_path(context, "whitted", &frames, &whitted) else {
            return not_a_film("film");
        };
        vec![same_mean("image mean", &a, &b, BOUNCES_DELTA)]
    }
}

/// Builds a diffuse sphere under a square light, with nothing else.
fn convex() -> Arc<Scene> {
    scene("convex object", |s| {
        // Not in the light's proportions, so that no exchange of channels undoes the other's.
        let albedo = FLOOR * DVec3::new(0.9, 1.0, 0.5);
        ball(
            s,
            Sphere::new(DVec3::ZERO, 0.5),
            Surface::new(Bsdf::Lambert { albedo }),
        );
        square(s, 1.5 * DVec3::Z, 0.2, false, light(LIGHT));
    })
}

/// Compares the path tracer's three strategies in a diffuse cavity with an emitting black cap: most
/// paths find it, which keeps the variance of BSDF sampling low.
struct SameStrategies(Arc<Scene>);

const CAVITY_SIZE: [u32; 2] = [20, 15];
const CAVITY_REPLICATIONS: u64 = 4_200;

impl Property for SameStrategies {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let frames = Frames::first(&self.0, CAVITY_SIZE, context.n(CAVITY_REPLICATIONS));
        let [bsdf, light, mis] = [Strategy::Bsdf, Strategy::Light, Strategy::Mis].map(|strategy| {
            let path = Path::new(strategy).with_parts(setup.parts);
            PixelMoments::render(context, &format!("{strategy:?}"), &frames, &path)
        });
        let (Some(bsdf), Some(light), Some(mis)) = (bsdf, light, mis) else {
            return not_a_film("film");
        };
        vec![
            same_mean("bsdf and mis", &bsdf, &mis, IMAGE_DELTA),
            same_mean("light and mis", &light, &mis, IMAGE_DELTA),
        ]
    }
}

pub fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let furnace = furnace_under(SKY).and_then(|scene| scene.with_camera(near_furnace()));
    let white = WhiteFurnace(valid(furnace));
    let same = SameImage(coloured_room());
    let strategies = SameStrategies(valid(cavity_cap(0.9, Cap::Black)));
    vec![
        trial(
            "images/white-furnace",
            "the film of a white Lambert sphere, a mirror and glass has the mean of the coloured sky",
            "white, mirror and glass objects stand out from the sky, or take on a tint",
            &RENDERING,
            "render::render, integrator::Path",
            "t",
            with_parts(white),
        ),
        trial(
            "images/diffuse-room",
            "the path tracer and the report's estimator, unlimited, make the same image",
            "the report's method and path tracing show rooms of different brightness",
            &RENDERING,
            "render::render, integrator::Path, integrator::Report",
            "Welch, equivalence",
            with_parts(same),
        ),
        trial(
            "images/convex-object",
            "Whitted's estimator and the path tracer make the same image of a convex diffuse object",
            "Whitted's ray tracing lights a lone ball differently than path tracing does",
            &WHITTED,
            "render::render, integrator::Whitted, integrator::Path",
            "Welch",
            with_parts(Convex(convex())),
        ),
        trial(
            "images/three-strategies",
            "hits, shadow rays and both make the same image of a diffuse cavity with an emitting cap",
            "switching shadow rays on or off changes how bright an image is",
            &MIS,
            "render::render, integrator::Path",
            "Welch",
            with_parts(strategies),
        ),
    ]
}
