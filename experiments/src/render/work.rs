//! From a job to what is done with its estimator.

use std::ops::Range;

use glam::DVec3;
use whitefurnace::emitter::LightSampling;
use whitefurnace::error::Error;
use whitefurnace::estimator::radiosity::Mesh;
use whitefurnace::estimator::{
    Bdpt, Estimator, Heuristic, ImageEstimator, LightRules, LightTracer, Path, PhotonMapping,
    Published, Radiosity, Report, Sppm, Standard, Strategy, Whitted,
};
use whitefurnace::film::{Film, Pixel};
use whitefurnace::render::{render, render_passes};
use whitefurnace::rng::seed_for;
use whitefurnace::scene::Scene;

use super::{ConventionName, EstimatorName, HeuristicName, Job, LightSamplingName, name};
use crate::run::progress::{Progress, interrupted};

/// What is done with the estimator of a job, of whichever type it is.
pub trait Work {
    /// What comes of it.
    type Done;
    /// With an estimator of single rays.
    ///
    /// # Errors
    /// What the work refuses.
    fn rays<E: Estimator>(
        self,
        job: &Job,
        scene: &Scene,
        estimator: &E,
    ) -> Result<Self::Done, Error>;
    /// With an estimator of whole images.
    ///
    /// # Errors
    /// What the work refuses.
    fn images<E: ImageEstimator>(
        self,
        job: &Job,
        scene: &Scene,
        estimator: &E,
    ) -> Result<Self::Done, Error>;
}

/// A film and whether all the samples that were asked for are on it.
pub struct Rendered {
    /// The film.
    pub film: Film,
    /// False after a signal to end.
    pub complete: bool,
}

impl Rendered {
    /// The film with all its samples.
    ///
    /// # Errors
    /// [`Error::Interrupted`] after a signal to end.
    pub fn whole(self) -> Result<Film, Error> {
        if self.complete { Ok(self.film) } else { Err(Error::Interrupted) }
    }
}

impl Job {
    /// Renders the job.
    ///
    /// # Errors
    /// What [`check`](Self::check), [`Film::new`] and [`render`](render()) refuse.
    pub fn render(&self, progress: &Progress) -> Result<Rendered, Error> {
        self.with_estimator(progress, Whole { progress })
    }

    /// Renders each replication of the range as an image of its own and shows it: pixel means row by row
    /// from the top. A photon map is made anew for each, so that they are independent.
    ///
    /// # Errors
    /// As [`render`](Self::render), and what `each` returns.
    pub fn replications(
        &self,
        range: Range<u32>,
        mut each: impl FnMut(&[DVec3]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let progress = Progress::new(&name(self.estimator));
        if self.estimator != EstimatorName::Photon {
            return self.with_estimator(&progress, Replications { range, each: &mut each });
        }
        for index in range {
            let job = Self { seed: seed_for(self.seed, &format!("photons {index}")), ..*self };
            let work = Replications { range: 0..1, each: &mut each };
            job.with_estimator(&progress, work)?;
        }
        Ok(())
    }

    /// The same with an estimator of single rays that no name of the program stands for.
    ///
    /// # Errors
    /// As [`replications`](Self::replications).
    pub fn replications_by<E: Estimator>(
        &self,
        estimator: &E,
        range: Range<u32>,
        mut each: impl FnMut(&[DVec3]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.check()?;
        let work = Replications { range, each: &mut each };
        work.rays(self, &self.build_scene()?, estimator)
    }

    /// Checks the job, makes its scene and estimator, and works with them.
    fn with_estimator<W: Work>(&self, progress: &Progress, work: W) -> Result<W::Done, Error> {
        self.check()?;
        let scene = self.build_scene()?;
        let rules = match self.convention {
            ConventionName::Physical => LightRules::PHYSICAL,
            ConventionName::Report | ConventionName::Published => LightRules::REPORT,
        };
        match (self.estimator, self.convention) {
            (EstimatorName::Bsdf, _) => work.rays(self, &scene, &self.path(Strategy::Bsdf)),
            (EstimatorName::Light, _) => work.rays(self, &scene, &self.path(Strategy::Light)),
            (EstimatorName::Mis, _) => work.rays(self, &scene, &self.path(Strategy::Mis)),
            (EstimatorName::LightTracer, _) => {
                work.images(self, &scene, &LightTracer::<Standard>::default())
            }
            (EstimatorName::Bdpt, _) => work.images(self, &scene, &Bdpt::<Standard>::default()),
            (EstimatorName::Photon, _) => {
                let (map, lookup) = (self.photons.map(), self.photons.lookup(true));
                let photons = PhotonMapping::new(Standard, &scene, lookup, map, (self.seed, 0))?;
                work.rays(self, &scene, &photons)
            }
            (EstimatorName::Sppm, _) => {
                let (particles, radius) = self.photons.map();
                let sppm = Sppm { parts: Standard, particles, radius };
                work.images(self, &scene, &sppm)
            }
            (EstimatorName::Radiosity, _) => {
                let fineness = self.fineness();
                let nodes = Mesh::new(&scene, fineness)?.nodes() as u64;
                let bar = progress.bar(nodes);
                let node_done = |nodes| bar.advance(nodes);
                let solved = Radiosity::new(Standard, &scene, fineness, &node_done)?;
                bar.finish();
                work.rays(self, &scene, &solved)
            }
            (EstimatorName::Whitted, _) => work.rays(self, &scene, &Whitted::new(rules)),
            (EstimatorName::Report, ConventionName::Published) => {
                work.rays(self, &scene, &Published::default())
            }
            (EstimatorName::Report, _) => {
                let report = Report { rays: self.rays, rules, ..Report::default() };
                work.rays(self, &scene, &report)
            }
        }
    }

    fn path(&self, strategy: Strategy) -> Path {
        Path {
            parts: Standard,
            strategy,
            lights: match self.light_sampling {
                LightSamplingName::Area => LightSampling::Area,
                LightSamplingName::SolidAngle => LightSampling::SolidAngle,
            },
            heuristic: match self.heuristic {
                HeuristicName::Balance => Heuristic::Balance,
                HeuristicName::Power => Heuristic::Power,
            },
        }
    }
}

/// Renders the whole job.
pub struct Whole<'a> {
    /// Shows how far it is.
    pub progress: &'a Progress,
}

/// Largest number of replications in one pass over the image.
const LARGEST_PASS: u32 = 16;

impl Work for Whole<'_> {
    type Done = Rendered;

    /// In passes that double up to a largest number of replications, so that error and image are known early.
    fn rays<E: Estimator>(
        self,
        job: &Job,
        scene: &Scene,
        estimator: &E,
    ) -> Result<Rendered, Error> {
        let sampling = job.sampling();
        let per_replication = sampling.samples_per_replication();
        let mut film = Film::new(job.size, job.window, per_replication)?;
        let replications = job.spp / per_replication;
        let [width, height] = film.size().map(u64::from);
        let mut bar = self.progress.bar(width * height * u64::from(job.spp));
        let mut done = 0;
        while done < replications {
            let end = replications.min(done + done.clamp(1, LARGEST_PASS));
            let row_done = |samples| bar.advance(samples);
            let range = done..end;
            if !render(scene, estimator, sampling, &mut film, &range, &row_done)? {
                break;
            }
            done = end;
            bar.error(|| film.relative_error());
        }
        bar.finish();
        Ok(Rendered { film, complete: done == replications })
    }

    /// Each image a replication.
    fn images<E: ImageEstimator>(
        self,
        job: &Job,
        scene: &Scene,
        estimator: &E,
    ) -> Result<Rendered, Error> {
        let mut film = Film::new(job.size, job.window, 1)?;
        let [width, height] = film.size().map(u64::from);
        let mut bar = self.progress.bar(width * height * u64::from(job.spp));
        let pass_done = |samples| bar.advance(samples);
        let range = 0..job.spp;
        let complete = render_passes(scene, estimator, job.seed, &mut film, range, &pass_done)?;
        bar.error(|| film.relative_error());
        bar.finish();
        Ok(Rendered { film, complete })
    }
}

/// Shows replications one by one.
struct Replications<'a> {
    range: Range<u32>,
    each: &'a mut dyn FnMut(&[DVec3]) -> Result<(), Error>,
}

impl Work for Replications<'_> {
    type Done = ();

    fn rays<E: Estimator>(self, job: &Job, scene: &Scene, estimator: &E) -> Result<(), Error> {
        let sampling = job.sampling();
        for index in self.range {
            let mut film = Film::new(job.size, None, sampling.samples_per_replication())?;
            let range = index..index + 1;
            if !render(scene, estimator, sampling, &mut film, &range, &|_| !interrupted())? {
                return Err(Error::Interrupted);
            }
            let image: Vec<DVec3> = film.pixels().iter().map(Pixel::mean).collect();
            (self.each)(&image)?;
        }
        Ok(())
    }

    fn images<E: ImageEstimator>(
        self,
        job: &Job,
        scene: &Scene,
        estimator: &E,
    ) -> Result<(), Error> {
        for index in self.range {
            if interrupted() {
                return Err(Error::Interrupted);
            }
            (self.each)(&estimator.pass(scene, job.size, job.seed, index)?)?;
        }
        Ok(())
    }
}
