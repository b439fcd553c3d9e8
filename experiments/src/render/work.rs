//! Renders jobs: whole, or replication by replication.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use whitefurnace::error::Error;
use whitefurnace::film::{Film, Pixel};
use whitefurnace::integrator::radiosity::Mesh;
use whitefurnace::integrator::{
    Bdpt, Connections, Estimator, Heuristic, ImageEstimator, LightTracer, Parts, Path,
    PhotonMapping, Published, Radiosity, Report, Sppm, Strategy, TransportRules, Whitted,
};
use whitefurnace::light::emitter::LightSampling;
use whitefurnace::render::adaptive::Pilot;
use whitefurnace::render::{
    CHUNK_SAMPLES, ImageRenderer, LaneEstimator, LaneRenderer, Precision, PreparedRenderer,
    RayRenderer, Renderer, check_single_precision,
};
use whitefurnace::sampling::rng::seed_for;
use whitefurnace::sampling::sampler::ImagePass;
use whitefurnace::scene::Scene;

use super::defaults::RR_DEPTH;
use super::{
    AdaptiveName, ConventionName, EstimatorName, HeuristicName, Job, LightSamplingName,
    PrecisionName, SpecularNeeName, name,
};
use crate::run::progress::{Bar, interrupted};

/// The renderer of a job, or an error.
type RendererResult = Result<Box<dyn Renderer>, Error>;

/// Largest number of replications between two looks at the error.
const LARGEST_RANGE: u32 = 64;

/// Number of images of replications rendered at once.
const IMAGES_PER_BATCH: u32 = 64;

/// Observes a film from time to time while it is rendered.
pub trait Observer: Sync {
    /// Returns true if it is time to observe.
    fn is_due(&self) -> bool;
    /// Observes the film in its current state.
    fn observe(&mut self, film: &Film);
}

/// A film, and whether it has all the samples that were asked for.
pub struct Rendered {
    /// Accumulated samples.
    pub film: Film,
    /// False after a signal to end.
    pub complete: bool,
}

impl Rendered {
    /// Returns the film if it is complete; an error after a signal to end.
    pub fn into_complete(self) -> Result<Film, Error> {
        if self.complete {
            Ok(self.film)
        } else {
            Err(Error::Interrupted)
        }
    }
}

impl Job {
    /// Renders the job.
    pub fn render(&self, label: &str) -> Result<Rendered, Error> {
        self.check()?;
        let scene = self.build_scene()?;
        self.render_all(&scene, &*self.renderer(&scene, label)?, label)
    }

    /// Renders the job with an estimator of single rays that has no name, and equal numbers of
    /// samples in all pixels.
    pub fn render_by(&self, estimator: impl Estimator, label: &str) -> Result<Rendered, Error> {
        self.check()?;
        let job = Self {
            adaptive: AdaptiveName::No,
            ..*self
        };
        job.render_all(&self.build_scene()?, &self.by_rays(estimator), label)
    }

    /// Renders each replication of the range as an image of its own and hands its pixel means to
    /// `each`, row by row from the top. All pixels have the same number of samples. A photon map is
    /// built anew for each, so that the images are independent.
    pub fn replications(&self, range: Range<u32>, each: impl FnMut(&[DVec3])) -> Result<(), Error> {
        self.check()?;
        let label = name(self.estimator);
        let scene = self.build_scene()?;
        if self.estimator != EstimatorName::Photon {
            let renderer = self.renderer(&scene, &label)?;
            return in_order(range, |index| self.image(&scene, &*renderer, index), each);
        }
        let image = |index| {
            let job = Self {
                seed: seed_for(self.seed, &format!("photons {index}")),
                ..*self
            };
            job.image(&scene, &*job.renderer(&scene, &label)?, 0)
        };
        in_order(range, image, each)
    }

    /// Renders each replication of the range with an estimator of single rays that has no name; see
    /// [`replications`](Self::replications).
    pub fn replications_by(
        &self,
        estimator: impl Estimator,
        range: Range<u32>,
        each: impl FnMut(&[DVec3]),
    ) -> Result<(), Error> {
        self.check()?;
        let (scene, renderer) = (self.build_scene()?, self.by_rays(estimator));
        in_order(range, |index| self.image(&scene, &renderer, index), each)
    }

    /// Returns the number of replications.
    pub fn all_replications(&self) -> u32 {
        self.spp / self.samples_per_replication()
    }

    /// Returns the number of samples of a replication.
    pub fn samples_per_replication(&self) -> u32 {
        let sampling = self.sampling();
        if self.estimator.is_image_estimator() {
            sampling.sampler.samples()
        } else {
            sampling.samples_per_replication()
        }
    }

    /// Returns an empty film for the job.
    pub fn film(&self) -> Result<Film, Error> {
        Film::new(self.size, self.window, self.samples_per_replication())
    }

    /// Adds to the film the samples that it lacks of these replications; observers look at it in
    /// the meantime.
    pub fn render_onto(
        &self,
        label: &str,
        film: Film,
        range: &Range<u32>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Rendered, Error> {
        self.check()?;
        let scene = self.build_scene()?;
        self.render_missing(
            &scene,
            &*self.renderer(&scene, label)?,
            label,
            film,
            range,
            observers,
        )
    }

    pub(super) fn render_all(
        &self,
        scene: &Scene,
        renderer: &dyn Renderer,
        label: &str,
    ) -> Result<Rendered, Error> {
        self.render_missing(
            scene,
            renderer,
            label,
            self.film()?,
            &(0..self.all_replications()),
            &mut [],
        )
    }

    /// Takes the first samples of an adaptive job, unless the film has all, and gives its pixels the
    /// numbers of samples that they decide.
    fn adapt(
        &self,
        renderer: &dyn PreparedRenderer,
        film: &mut Film,
        range: &Range<u32>,
    ) -> Result<(), Error> {
        let (mean, all) = (film.samples_per_replication(), range.end - range.start);
        let is_adaptive = self.adaptive == AdaptiveName::Yes && self.adapts() && mean > 1;
        if !is_adaptive || film.replications() >= all {
            return Ok(());
        }
        let bar = Bar::new("pilot", 0, "samples");
        let advance = |samples| {
            bar.advance(samples);
            !interrupted()
        };
        let pilot = Pilot::take(renderer, film, self.all_replications(), range, &advance)?
            .ok_or(Error::Interrupted)?;
        let counts = pilot.counts();
        pilot.begin(film, counts)
    }

    /// Renders the missing replications of a range, in ranges that double up to a largest one, so
    /// that error and image are known early.
    fn render_missing(
        &self,
        scene: &Scene,
        renderer: &dyn Renderer,
        label: &str,
        mut film: Film,
        range: &Range<u32>,
        observers: &mut [&mut dyn Observer],
    ) -> Result<Rendered, Error> {
        let prepared = renderer.prepare(scene, film.resolution())?;
        self.adapt(&*prepared, &mut film, range)?;
        let mut bar = Bar::new(
            label,
            film.missing_samples(range.end - range.start),
            "samples",
        );
        let largest = (CHUNK_SAMPLES / renderer.samples_per_replication()).clamp(1, LARGEST_RANGE);
        loop {
            let had = film.replications();
            let start = range.start + had;
            if start >= range.end || interrupted() {
                return Ok(Rendered {
                    film,
                    complete: start >= range.end,
                });
            }
            let end = range.end.min(start + had.clamp(1, largest));
            let due = || observers.iter().any(|observer| observer.is_due());
            let whole = prepared.add(&mut film, start..end, &|samples| {
                bar.advance(samples) && !due()
            })?;
            if !whole && !interrupted() {
                observers
                    .iter_mut()
                    .filter(|observer| observer.is_due())
                    .for_each(|observer| observer.observe(&film));
            }
            bar.error(|| film.relative_error());
        }
    }

    /// Returns the pixel means of one replication, rendered on a film of its own.
    fn image(
        &self,
        scene: &Scene,
        renderer: &dyn Renderer,
        index: u32,
    ) -> Result<Vec<DVec3>, Error> {
        let mut film = Film::new(self.size, None, renderer.samples_per_replication())?;
        if !renderer.add(scene, &mut film, index..index + 1, &|_| !interrupted())? {
            return Err(Error::Interrupted);
        }
        Ok(film.pixels().iter().map(Pixel::mean).collect())
    }

    fn by_rays<E: Estimator>(&self, estimator: E) -> RayRenderer<E> {
        RayRenderer {
            estimator,
            sampling: self.sampling(),
        }
    }

    fn by_passes(&self, estimator: impl ImageEstimator + 'static) -> Box<dyn Renderer> {
        Box::new(ImageRenderer {
            estimator,
            sampler: self.sampling().sampler,
            seed: self.seed,
        })
    }

    /// Builds the estimator that the job names, for its scene.
    pub(super) fn renderer(&self, scene: &Scene, label: &str) -> RendererResult {
        let rules = match self.convention {
            ConventionName::Physical => TransportRules::PHYSICAL,
            ConventionName::Report | ConventionName::Published => TransportRules::REPORT,
        };
        let (sampler, seed) = (self.sampling().sampler, self.seed);
        Ok(match (self.estimator, self.convention) {
            (EstimatorName::Bsdf, _) => self.by_paths(scene, Strategy::Bsdf)?,
            (EstimatorName::Light, _) => self.by_paths(scene, Strategy::Light)?,
            (EstimatorName::Mis, _) => self.by_paths(scene, Strategy::Mis)?,
            (EstimatorName::LightTracer, _) => self.by_passes(LightTracer::default()),
            (EstimatorName::Bdpt, _) => self.by_passes(Bdpt::new(Parts::default())),
            (EstimatorName::BdptEnds, _) => self.by_passes(Bdpt {
                parts: Parts::default(),
                connections: Connections::Endpoints,
            }),
            (EstimatorName::Photon, _) => {
                let ((particles, radius), lookup) = (self.photons.map(), self.photons.lookup(true));
                let photons = PhotonMapping::new(
                    Parts::default(),
                    scene,
                    lookup,
                    particles,
                    radius,
                    ImagePass {
                        sampler,
                        seed,
                        index: 0,
                    },
                )?;
                Box::new(self.by_rays(photons))
            }
            (EstimatorName::Sppm, _) => {
                let (particles, radius) = self.photons.map();
                self.by_passes(Sppm {
                    parts: Parts::default(),
                    particles,
                    radius,
                })
            }
            (EstimatorName::Radiosity, _) => {
                let resolution = self.resolution();
                let nodes = Mesh::new(scene, resolution)?.nodes() as u64;
                let bar = Bar::new(label, nodes, "samples");
                let node_done = |nodes| bar.advance(nodes);
                let solved = Radiosity::new(Parts::default(), scene, resolution, &node_done)?;
                Box::new(self.by_rays(solved))
            }
            (EstimatorName::Whitted, _) => {
                self.by_lanes(scene, LaneEstimator::Whitted(Whitted::new(rules)))?
            }
            (EstimatorName::Report, ConventionName::Published) => {
                Box::new(self.by_rays(Published::default()))
            }
            (EstimatorName::Report, _) => {
                let report = Report {
                    rays: self.rays,
                    rules,
                    ..Report::default()
                };
                self.by_lanes(scene, LaneEstimator::Report(report))?
            }
        })
    }

    fn by_paths(&self, scene: &Scene, strategy: Strategy) -> RendererResult {
        self.by_lanes(scene, LaneEstimator::Path(self.path(strategy)))
    }

    fn by_lanes(&self, scene: &Scene, estimator: LaneEstimator<'static>) -> RendererResult {
        let precision = match self.precision {
            PrecisionName::Double => Precision::Double,
            PrecisionName::Single => {
                check_single_precision(scene).map_err(|error| {
                    Error::Option(format!(
                        "--precision single: {error}; take --precision double"
                    ))
                })?;
                Precision::Single
            }
        };
        Ok(Box::new(LaneRenderer {
            estimator,
            sampling: self.sampling(),
            precision,
        }))
    }

    fn path(&self, strategy: Strategy) -> Path<'static> {
        Path {
            parts: Parts::default(),
            strategy,
            lights: match self.light_sampler {
                LightSamplingName::Area => LightSampling::Area,
                LightSamplingName::SolidAngle => LightSampling::SolidAngle,
                LightSamplingName::SphereAngle => LightSampling::SphereAngle,
                LightSamplingName::Importance => LightSampling::Importance,
            },
            heuristic: match self.heuristic {
                HeuristicName::Balance => Heuristic::Balance,
                HeuristicName::Power => Heuristic::Power,
            },
            rr_depth: RR_DEPTH,
            specular_nee: self.specular_nee == SpecularNeeName::Yes,
            bounces: self.bounces,
        }
    }
}

/// Shows images in order while several are rendered at once: a small image has too few rows for
/// many threads.
fn in_order(
    range: Range<u32>,
    image: impl Fn(u32) -> Result<Vec<DVec3>, Error> + Sync,
    mut each: impl FnMut(&[DVec3]),
) -> Result<(), Error> {
    for first in range.clone().step_by(IMAGES_PER_BATCH as usize) {
        let images = (first..range.end.min(first.saturating_add(IMAGES_PER_BATCH)))
            .into_par_iter()
            .map(&image);
        images
            .collect::<Result<Vec<_>, _>>()?
            .iter()
            .for_each(|image| each(image));
    }
    Ok(())
}
