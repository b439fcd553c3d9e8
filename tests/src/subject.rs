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
    Bidirectional, DefaultParts, Density, Estimator, FiniteElements, Heuristic, NextEvent, Path,
    Photons, Report, Sample, Strategy, TransportRules, Whitted,
};
use whitefurnace::light::emitter::{Emitter, EmitterPoint, LightSampling};
use whitefurnace::light::environment::EnvironmentMap;
use whitefurnace::light::light_sampler::PowerLightSampler;
use whitefurnace::material::{Bsdf, Scattering};
use whitefurnace::sampling::rng::{Stream, stream};
use whitefurnace::sampling::roulette::{RR_DEPTH, Roulette};
use whitefurnace::sampling::sampler::Sampler;
use whitefurnace::scene::Scene;
use whitefurnace::scene::specular_casters::SpecularCaster;

macro_rules! table {
    ($($group:ident {
        $($name:ident($($argument:ident: $kind:ty),*) -> $result:ty;)*
    })*) => {
        /// [`EstimatorParts`] as a table of functions: a fault is [`CORRECT`] with one function
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

/// All overridable components of all estimators.
pub trait EstimatorParts:
    Scattering + Roulette + NextEvent + Photons + Bidirectional + FiniteElements
{
}

impl<P> EstimatorParts for P where
    P: Scattering + Roulette + NextEvent + Photons + Bidirectional + FiniteElements
{
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

/// Everything that a fault can replace in an estimator: its components and its configuration.
#[derive(Clone, Copy)]
pub struct Configuration<P> {
    /// The components.
    pub parts: P,
    /// Longest path in segments, in place of the trial's own choice. [`Path`] ignores it unless it
    /// has a limit.
    pub segments: Option<u32>,
    /// Transport rules. [`Path`] ignores them; it is always physical.
    pub rules: TransportRules,
}

impl<P> Configuration<P> {
    /// Replaces the components and keeps the configuration.
    pub fn with<Q>(self, parts: Q) -> Configuration<Q> {
        Configuration {
            parts,
            segments: self.segments,
            rules: self.rules,
        }
    }
}

/// Subject of the trials of whole estimators. Without a table it stands for [`DefaultParts`], the
/// very code that programs run.
pub type EstimatorSubject = Configuration<Option<PartTable>>;

/// The correct subject.
pub const STANDARD: EstimatorSubject = Configuration {
    parts: None,
    segments: None,
    rules: TransportRules::PHYSICAL,
};

/// Returns the correct subject with other components.
pub const fn parts(table: PartTable) -> EstimatorSubject {
    Configuration {
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
    fn run<P: EstimatorParts + Copy>(
        &self,
        context: &Context,
        setup: Configuration<P>,
    ) -> Vec<Outcome>;
}

/// Returns a property as a function of the subject.
pub fn with_parts<Q: Property>(
    property: Q,
) -> impl Fn(&Context, EstimatorSubject) -> Vec<Outcome> + Send + Sync {
    move |context, subject| match subject.parts {
        None => property.run(context, subject.with(DefaultParts)),
        Some(parts) => property.run(context, subject.with(parts)),
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
    /// Returns one estimate of the radiance along each ray.
    pub fn radiances<P: EstimatorParts + Copy, R: Sampler>(
        self,
        setup: Configuration<P>,
        scene: &Scene,
        rays: impl Iterator<Item = (Ray, R)>,
    ) -> Vec<DVec3> {
        let Configuration { parts, rules, .. } = setup;
        let samples = rays.map(|(ray, rng)| Sample {
            ray,
            hit: None,
            rng,
        });
        let path = |strategy| Path::new(parts, strategy);
        match self {
            Self::Path => path(Strategy::Mis).radiances(scene, samples),
            Self::PathWith(strategy, lights, heuristic) => Path {
                lights,
                heuristic,
                ..path(strategy)
            }
            .radiances(scene, samples),
            Self::PathSpecularNee(heuristic) => Path {
                heuristic,
                specular_nee: true,
                ..path(Strategy::Mis)
            }
            .radiances(scene, samples),
            Self::PathSpecularNeeMaxSegments(segments) => {
                let bounces = Some(setup.segments.unwrap_or(segments) - 1);
                Path {
                    specular_nee: true,
                    bounces,
                    ..path(Strategy::Mis)
                }
                .radiances(scene, samples)
            }
            Self::PathWithRrDepth => Path {
                rr_depth: RR_DEPTH,
                ..path(Strategy::Bsdf)
            }
            .radiances(scene, samples),
            Self::Report(segments) => {
                let segments = setup.segments.unwrap_or(segments);
                Report {
                    parts,
                    rays: 1,
                    segments,
                    rules,
                }
                .radiances(scene, samples)
            }
            Self::Whitted(segments) => {
                let segments = setup.segments.unwrap_or(segments);
                Whitted {
                    parts,
                    segments,
                    rules,
                }
                .radiances(scene, samples)
            }
        }
    }

    /// Returns one estimate of the radiance along one ray.
    pub fn radiance<P: EstimatorParts + Copy, R: Sampler>(
        self,
        setup: Configuration<P>,
        scene: &Scene,
        ray: &Ray,
        rng: &mut R,
    ) -> DVec3 {
        self.radiances(setup, scene, std::iter::once((*ray, rng)))[0]
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
    pub ray: fn(&mut Stream) -> Ray,
}

impl Probe {
    /// Returns a source of estimates, one per call, each from a new ray and a random stream of its
    /// own under this seed. They are made in batches that keep all lanes busy.
    pub fn radiances<P: EstimatorParts + Copy>(
        &self,
        setup: Configuration<P>,
        seed: u64,
    ) -> impl FnMut() -> DVec3 + use<'_, P> {
        in_batches(seed, move |rngs| {
            let rays = rngs.map(|mut rng| ((self.ray)(&mut rng), rng));
            self.kind.radiances(setup, &self.scene, rays)
        })
    }
}

/// Number of estimates in a batch.
const BATCH: u64 = 256;

/// Returns a source of values, one per call, that are made in batches, each with a random stream of
/// its own under this seed.
pub fn in_batches(
    seed: u64,
    mut batch: impl FnMut(&mut dyn Iterator<Item = Stream>) -> Vec<DVec3>,
) -> impl FnMut() -> DVec3 {
    let (mut values, mut next) = (Vec::new().into_iter(), 0);
    move || {
        values.next().unwrap_or_else(|| {
            let mut rngs = (next..next + BATCH).map(|i| stream(seed, (i >> 32) as u32, i as u32));
            next += BATCH;
            values = batch(&mut rngs).into_iter();
            values.next().expect("a value for each stream")
        })
    }
}
