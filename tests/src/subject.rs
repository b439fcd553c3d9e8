//! Whole estimators as subjects: the components that programs run, or a table of components of
//! which some are faulty.

use std::sync::Arc;

use glam::DVec3;

use whitefurnace::camera::Camera;
use whitefurnace::geometry::form_factor::Polygon;
use whitefurnace::geometry::shape::{Ray, SurfacePoint};
use whitefurnace::geometry::specular_connection::SpecularConnection;
use whitefurnace::harness::outcome::Outcome;
use whitefurnace::harness::trial::Context;
use whitefurnace::integrator::{
    Bidirectional, DefaultParts, Density, Estimator, FiniteElements, Heuristic, NextEvent, Parts,
    Path, Photons, Report, Sample, Strategy, TransportRules, Whitted,
};
use whitefurnace::light::emitter::{Emitter, EmitterPoint, LightSampling};
use whitefurnace::light::environment::EnvironmentMap;
use whitefurnace::light::light_sampler::PowerLightSampler;
use whitefurnace::material::{Bsdf, Scattering};
use whitefurnace::sampling::rng::stream;
use whitefurnace::sampling::roulette::{RR_DEPTH, Roulette};
use whitefurnace::sampling::sampler::{SampleStream, Sampler};
use whitefurnace::scene::Scene;
use whitefurnace::scene::specular_casters::SpecularCaster;

use crate::faults::FamilyTrial;
use crate::mean_radiance::Rays;

macro_rules! table {
    ($($group:ident {
        $($name:ident($($argument:ident: $kind:ty),*) -> $result:ty;)*
    })*) => {
        /// Parts of estimators as a table of functions: a fault is [`CORRECT`] with one function
        /// replaced.
        #[derive(Clone, Copy)]
        pub struct PartTable {
            $($(
                #[doc = concat!("In place of [`", stringify!($group), "::", stringify!($name), "`].")]
                pub $name: fn($($kind),*) -> $result,
            )*)*
        }

        /// Table of the functions of [`DefaultParts`].
        pub const CORRECT: PartTable = PartTable {
            $($($name: |$($argument),*| DefaultParts.$name($($argument),*),)*)*
        };

        $(impl $group for PartTable {
            $(fn $name(&self, $($argument: $kind),*) -> $result {
                (self.$name)($($argument),*)
            })*
        })*
    };
}

table! {
    Scattering {
        fresnel(cos_1: f64, n1: f64, n2: f64) -> f64;
        refract(d: DVec3, n: DVec3, n1: f64, n2: f64) -> Option<DVec3>;
        radiance_factor(n1: f64, n2: f64) -> f64;
        mirror(d: DVec3, n: DVec3) -> DVec3;
        brdf(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3;
        cosine(normal: DVec3, direction: DVec3) -> f64;
        uniform_hemisphere(random: [f64; 2]) -> DVec3;
        uniform_hemisphere_pdf(cos_theta: f64) -> f64;
        cosine_hemisphere(random: [f64; 2]) -> DVec3;
        cosine_hemisphere_pdf(cos_theta: f64) -> f64;
    }
    Roulette {
        survival_by_throughput(throughput: DVec3, early: bool) -> f64;
        survival_by_absorption(absorption: f64) -> f64;
        survives(r: f64, survival: f64) -> bool;
        roulette_weight(survival: f64) -> f64;
        rescaled(r: f64, survival: f64) -> f64;
    }
    NextEvent {
        pick_emitter(r: f64, picks: &PowerLightSampler) -> usize;
        emitter_importance(emitter: &Emitter, from: DVec3) -> f64;
        pick_by_probability(r: f64, shares: &[f64]) -> (usize, f64);
        pdf_of_pick(pdf: f64, probability: f64) -> f64;
        sample_emitter(emitter: &Emitter, random: [f64; 2]) -> EmitterPoint;
        emitter_pdf_area(emitter: &Emitter) -> f64;
        solid_angle_per_area(cosine_at_emitter: f64, distance_squared: f64) -> f64;
        sample_solid_angle(emitter: &Emitter, from: DVec3, random: [f64; 2]) -> Option<(EmitterPoint, f64)>;
        pdf_solid_angle(emitter: &Emitter, from: DVec3) -> Option<f64>;
        map_probability(count: usize) -> f64;
        sample_map(map: &EnvironmentMap, random: [f64; 2]) -> (DVec3, f64);
        map_pdf(map: &EnvironmentMap, direction: DVec3) -> f64;
        sees_background(scene: &Scene, x: SurfacePoint, direction: DVec3) -> bool;
        visible(scene: &Scene, x: SurfacePoint, y: SurfacePoint, glass: bool) -> bool;
        mis_weight(pdf: f64, other: f64) -> f64;
        mis_power_weight(pdf: f64, other: f64) -> f64;
        connection(caster: &SpecularCaster, number: usize, connection: SpecularConnection<DVec3>) -> Option<SpecularConnection<DVec3>>;
        caster_throughput(caster: &SpecularCaster, cosine: f64) -> (DVec3, f64);
        counts_emission(strategy: Strategy, sampled: bool) -> bool;
    }
    Photons {
        photon_flux(flux: DVec3, emitted: u32, stored: usize) -> DVec3;
        is_caustic(specular: u32) -> bool;
        same_side(at_photon: DVec3, at_point: DVec3) -> bool;
        photon_density(brdf: DVec3, flux: DVec3, wi: DVec3, radius_squared: f64) -> DVec3;
        gathers_emission() -> bool;
        pass_radius_squared(first: f64, index: u32) -> f64;
    }
    Bidirectional {
        flux_factor(radiance_factor: f64) -> f64;
        importance(camera: &Camera, size: [u32; 2], direction: DVec3) -> f64;
        strategy_weight(path: &[Density], s: usize) -> f64;
    }
    FiniteElements {
        form_factor(normal: DVec3, corners: &[DVec3]) -> f64;
        visibility_weight(cosine: f64, solid_angle: f64) -> f64;
        is_near(area: f64, distance_squared: f64) -> bool;
        clip_to_horizon(normal: DVec3, polygon: &Polygon) -> Polygon;
        leaving(albedo: DVec3, emitted: DVec3, irradiance: DVec3) -> DVec3;
        reflected(leaving: DVec3, emitted: DVec3) -> DVec3;
        has_converged(residual: f64, sweeps: u32) -> bool;
    }
}

/// Subject of the trials of whole estimators: everything that a fault can replace.
#[derive(Clone, Copy)]
pub struct EstimatorSubject {
    /// Table in place of the default parts, if any.
    pub parts: Option<PartTable>,
    /// Longest path in segments, in place of the trial's own choice. [`Path`] ignores it unless it
    /// has a limit.
    pub segments: Option<u32>,
    /// Transport rules. [`Path`] ignores them; it is always physical.
    pub rules: TransportRules,
}

impl EstimatorSubject {
    /// Returns the subject with its table of parts changed.
    #[must_use]
    pub fn altered(self, change: impl FnOnce(PartTable) -> PartTable) -> Self {
        Self {
            parts: Some(change(self.parts.unwrap_or(CORRECT))),
            ..self
        }
    }

    /// Returns the subject for estimators.
    pub fn configuration(&self) -> Configuration<'_> {
        Configuration {
            parts: self
                .parts
                .as_ref()
                .map_or(Parts::default(), |table| Parts::replaced(table)),
            segments: self.segments,
            rules: self.rules,
        }
    }
}

/// An [`EstimatorSubject`] whose parts an estimator can take.
#[derive(Clone, Copy)]
pub struct Configuration<'a> {
    /// The parts.
    pub parts: Parts<'a>,
    /// As in [`EstimatorSubject`].
    pub segments: Option<u32>,
    /// As in [`EstimatorSubject`].
    pub rules: TransportRules,
}

/// The correct subject.
pub const STANDARD: EstimatorSubject = EstimatorSubject {
    parts: None,
    segments: None,
    rules: TransportRules::PHYSICAL,
};

/// Returns the correct subject with other components.
pub const fn parts(table: PartTable) -> EstimatorSubject {
    EstimatorSubject {
        parts: Some(table),
        ..STANDARD
    }
}

/// Builds one entry of a table of faults: name, equation, the error in words, the functions that
/// replace those of `CORRECT`, and the trials that must reject it. Fields without a type are
/// components of an estimator.
macro_rules! fault {
    ($name:expr, $equation:expr, $wrong:expr, { $($part:ident: $with:expr),* $(,)? }, $($by:expr),+) => {{
        use $crate::subject::{CORRECT, PartTable, parts};
        let table = PartTable { $($part: $with,)* ..CORRECT };
        $crate::faults::fault($name, &$equation, $wrong, parts(table), &[$($by),+])
    }};
    ($name:expr, $equation:expr, $wrong:expr, = $subject:expr, $($by:expr),+) => {
        $crate::faults::fault($name, &$equation, $wrong, $subject, &[$($by),+])
    };
    ($name:expr, $equation:expr, $wrong:expr, $kind:ident: { $($field:ident: $with:expr),* $(,)? }, $($by:expr),+) => {
        $crate::faults::fault($name, &$equation, $wrong, $kind { $($field: $with,)* ..CORRECT }, &[$($by),+])
    };
}
pub(crate) use fault;

/// A property that is checked on any estimator's components.
pub trait Property: Send + Sync + 'static {
    /// Runs the trial.
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome>;
}

/// Returns a property as a function of the subject.
pub fn with_parts<Q: Property>(
    property: Q,
) -> impl Fn(&Context, EstimatorSubject) -> Vec<Outcome> + Send + Sync {
    move |context, subject| property.run(context, subject.configuration())
}

/// Returns a trial that changes the parts of its subject first, faulty or not.
pub fn with_altered_parts(
    family_trial: FamilyTrial<EstimatorSubject>,
    change: impl Fn(PartTable) -> PartTable + Send + Sync + 'static,
) -> FamilyTrial<EstimatorSubject> {
    let inner = Arc::clone(&family_trial.on);
    FamilyTrial {
        on: Arc::new(move |context, subject| inner(context, subject.altered(&change))),
        ..family_trial
    }
}

/// An estimator of radiance along rays, with its own limit on segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorKind {
    /// [`Path`] with its defaults.
    Path,
    /// [`Path`] by BSDF sampling alone, with the relaxed roulette at the first [`RR_DEPTH`] hits of
    /// the program `render`.
    PathWithRrDepth,
    /// [`Path`] with another strategy, light sampling and heuristic for direct light.
    PathWith(Strategy, LightSampling, Heuristic),
    /// [`Path`] with specular next-event estimation.
    PathSpecularNee(Heuristic),
    /// [`Path`] with specular next-event estimation, the balance heuristic and at most this many
    /// segments, which is one more than its bounces.
    PathSpecularNeeMaxSegments(u32),
    /// [`Report`] with one sample ray and at most this many segments.
    Report(u32),
    /// [`Whitted`] with at most this many segments.
    Whitted(u32),
}

impl EstimatorKind {
    /// Returns the estimator of a configuration.
    pub fn estimator(self, setup: Configuration<'_>) -> Box<dyn Estimator + '_> {
        let Configuration { parts, rules, .. } = setup;
        let path = |strategy| Path::new(strategy).with_parts(parts);
        match self {
            Self::Path => Box::new(path(Strategy::Mis)),
            Self::PathWith(strategy, lights, heuristic) => Box::new(Path {
                lights,
                heuristic,
                ..path(strategy)
            }),
            Self::PathSpecularNee(heuristic) => Box::new(Path {
                heuristic,
                specular_nee: true,
                ..path(Strategy::Mis)
            }),
            Self::PathSpecularNeeMaxSegments(segments) => Box::new(Path {
                specular_nee: true,
                bounces: Some(setup.segments.unwrap_or(segments) - 1),
                ..path(Strategy::Mis)
            }),
            Self::PathWithRrDepth => Box::new(Path {
                rr_depth: RR_DEPTH,
                ..path(Strategy::Bsdf)
            }),
            Self::Report(segments) => Box::new(Report {
                parts,
                rays: 1,
                segments: setup.segments.unwrap_or(segments),
                rules,
            }),
            Self::Whitted(segments) => Box::new(Whitted {
                parts,
                segments: setup.segments.unwrap_or(segments),
                rules,
            }),
        }
    }

    /// Returns one estimate of the radiance along each ray.
    pub fn radiances<R: Into<SampleStream>>(
        self,
        setup: Configuration<'_>,
        scene: &Scene,
        rays: impl Iterator<Item = (Ray, R)>,
    ) -> Vec<DVec3> {
        let mut samples = rays.map(|(ray, rng)| sample(ray, rng));
        self.estimator(setup).radiances(scene, &mut samples)
    }

    /// Returns one estimate of the radiance along one ray.
    pub fn radiance(
        self,
        setup: Configuration<'_>,
        scene: &Scene,
        ray: &Ray,
        rng: &mut dyn Sampler,
    ) -> DVec3 {
        self.estimator(setup).radiance(scene, ray, None, rng)
    }
}

/// A scene, an estimator and rays into the scene.
#[derive(Clone)]
pub struct Probe {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The estimator.
    pub kind: EstimatorKind,
    /// The rays, from random numbers.
    pub ray: Rays,
}

impl Probe {
    /// Returns a source of estimates along new rays, as [`estimates`] does.
    pub fn radiances<'a>(&'a self, setup: Configuration<'a>, seed: u64) -> impl FnMut() -> DVec3 {
        estimates(seed, &self.scene, self.kind.estimator(setup), self.ray)
    }
}

/// Returns a sample along a ray whose hit is not known yet.
pub fn sample(ray: Ray, rng: impl Into<SampleStream>) -> Sample {
    Sample {
        ray,
        hit: None,
        rng: rng.into(),
    }
}

/// Number of estimates in a batch.
const BATCH: u64 = 1024;

/// Returns a source of estimates, one per call, each along a new ray and from a random stream of
/// its own under this seed. They are made in batches that keep all lanes busy.
pub fn estimates<'a>(
    seed: u64,
    scene: &'a Scene,
    estimator: Box<dyn Estimator + 'a>,
    mut ray: impl FnMut(&mut SampleStream) -> Ray + 'a,
) -> impl FnMut() -> DVec3 + 'a {
    let mut next = 0;
    in_batches(move || {
        let mut samples = (next..next + BATCH).map(|i| {
            let mut rng = SampleStream::from(stream(seed, (i >> 32) as u32, i as u32));
            sample(ray(&mut rng), rng)
        });
        next += BATCH;
        estimator.radiances(scene, &mut samples)
    })
}

/// Returns a source of values, one per call, that are made in batches.
pub fn in_batches<T>(mut batch: impl FnMut() -> Vec<T>) -> impl FnMut() -> T {
    let mut values = Vec::new().into_iter();
    move || {
        values.next().unwrap_or_else(|| {
            values = batch().into_iter();
            values.next().expect("a value in each batch")
        })
    }
}
