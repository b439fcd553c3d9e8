//! Estimators of the rendering equation (8), composed from plain parts.
//!
//! Every random decision and every equation that an estimator uses is a method of a trait beside
//! the code that it serves ([`Scattering`], [`Roulette`], [`NextEvent`], [`Photons`],
//! [`Bidirectional`], [`FiniteElements`]), whose default is the library's own function.
//! [`Standard`] overrides nothing and is what programs run; a trial puts a faulty part in by
//! overriding one method. All of it is resolved by the compiler.

mod bdpt;
mod bsdf_sample;
mod emission;
mod interaction;
mod lanewise;
mod light_sampling;
mod light_tracer;
mod next_event;
mod particle;
mod path;
mod path_state;
pub mod photon;
mod published;
pub mod radiosity;
mod report;
mod specular_nee;
mod strategies;
mod trace;
mod walk;
mod whitted;

use glam::DVec3;

pub use bdpt::{Bdpt, Connections};
pub(crate) use bsdf_sample::BsdfSample;
pub(crate) use interaction::{BsdfAt, ShadingPoint, SurfaceInteraction};
pub(crate) use lanewise::{Lanewise, vectors};
pub use light_tracer::LightTracer;
pub use next_event::NextEvent;
use next_event::ShadowRays;
pub use path::{Heuristic, Path, Strategy};
pub(crate) use path_state::{Arrival, Integrator, PathState};
pub use photon::photon_map::Photons;
pub use photon::photon_map::radius_squared;
pub use photon::sppm::Sppm;
pub use photon::{Lookup, PhotonMapping};
pub use published::{Published, Quirks};
pub use radiosity::{FiniteElements, Radiosity};
pub use report::Report;
pub(crate) use specular_nee::SpecularChains;
pub use strategies::{Bidirectional, Density, weight};
pub(crate) use trace::radiances;
pub use whitted::Whitted;

use crate::error::Error;
use crate::geometry::shape::{Hit, Ray};
use crate::light::emitter::LightSampling;
use crate::material::Scattering;
pub use crate::material::Standard;
use crate::math::simd::{LANES, Lanes};
use crate::sampling::roulette::Roulette;
use crate::sampling::sampler::{Pass, Sampler};
use crate::scene::Scene;

/// The most vertices of a path without a limit of its own. Where survival is at most
/// [`crate::sampling::roulette::HIGHEST_SURVIVAL`] a path gets there with a probability below 10⁻¹⁸⁰, so one
/// that does will not end: it is an error, never a cut. Its radiance is NaN, which no film holds.
pub const LONGEST_PATH: u32 = 1 << 13;

/// An unbiased or stated-bias estimate of the radiance that arrives along a ray.
pub trait Estimator: Sync {
    /// One estimate of the radiance that arrives at `ray.origin` from `ray.direction` (a unit
    /// vector), where `hit` is what [`Scene::intersect`] returns for the ray.
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3;

    /// About how many samples at a time are the least work.
    const TOGETHER: u32 = 256;

    /// The same along several rays, each as it is alone, in whatever order they are taken.
    fn radiances<R: Sampler>(
        &self,
        scene: &Scene,
        samples: impl Iterator<Item = Sample<R>>,
    ) -> Vec<DVec3> {
        samples
            .map(|Sample { ray, hit, mut rng }| self.radiance(scene, &ray, hit, &mut rng))
            .collect()
    }

    /// Whether it sees in mirrors what there is, however many there are: then a ray may follow some
    /// before it begins.
    fn sees_in_mirrors(&self) -> bool {
        false
    }
}

/// A ray along which radiance is estimated.
#[derive(Clone, Debug)]
pub struct Sample<R> {
    /// The ray, of a unit direction.
    pub ray: Ray,
    /// What [`Scene::intersect`] returns for it.
    pub hit: Option<Hit>,
    /// Its random numbers.
    pub rng: R,
}

/// An estimate of a whole image at once, for methods in which one path reaches many pixels.
pub trait ImageEstimator: Sync {
    /// One estimate of the mean radiance over each pixel of the `frame` (width, height), row by row
    /// from the top: a function of its arguments alone, whatever the threads. Passes of different
    /// replications are independent.
    ///
    /// # Errors
    /// [`Error::Radiance`] for a value that no film can hold.
    fn image(&self, scene: &Scene, frame: [u32; 2], pass: Pass) -> Result<Vec<DVec3>, Error>;

    /// Pass `index` by independent numbers, where each is a replication.
    ///
    /// # Errors
    /// Those of [`image`](Self::image).
    fn pass(
        &self,
        scene: &Scene,
        frame: [u32; 2],
        seed: u64,
        index: u32,
    ) -> Result<Vec<DVec3>, Error> {
        self.image(scene, frame, (seed, index).into())
    }
}

impl Roulette for Standard {}
impl NextEvent for Standard {}
impl Photons for Standard {}
impl Bidirectional for Standard {}
impl FiniteElements for Standard {}

/// What a random walk is made of.
pub trait Walking: Scattering + Roulette + NextEvent {}

impl<P: Scattering + Roulette + NextEvent> Walking for P {}

/// What light the conventions let through and show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRules {
    /// What a ray shows of an emitter that it hits, where hits count; `None` for its radiance.
    pub seen: Option<f64>,
    /// Whether shadow rays pass through glass, straight and unweakened.
    pub shadows_pass_glass: bool,
    /// Whether light that reaches a diffuse surface by way of mirrors and glass, where no shadow
    /// ray looks for it, counts when a path hits the emitter. What shadow rays pass through has
    /// been looked behind.
    pub caustics: bool,
    /// Whether refraction scales radiance by (n₁/n₂)².
    pub radiance_factor: bool,
}

impl LightRules {
    /// Energy-consistent.
    pub const PHYSICAL: Self = Self {
        seen: None,
        shadows_pass_glass: false,
        caustics: true,
        radiance_factor: true,
    };
    /// What the report's figures show: an emitter that is seen shows 1, glass casts no shadow, T =
    /// 1 − R is all that refraction does, and light that mirrors and glass throw on diffuse
    /// surfaces is lost.
    pub const REPORT: Self = Self {
        seen: Some(1.0),
        shadows_pass_glass: true,
        caustics: false,
        radiance_factor: false,
    };

    /// Shadow rays to points uniform in the area of emitters.
    fn shadow_rays(&self) -> ShadowRays {
        ShadowRays {
            lights: LightSampling::Area,
            pass_glass: self.shadows_pass_glass,
        }
    }
}

impl<E: Integrator> Estimator for E {
    fn radiance<S: Sampler>(&self, scene: &Scene, ray: &Ray, _: Option<Hit>, rng: &mut S) -> DVec3 {
        radiances::<E, &mut S, f64, 1>(scene, self, std::iter::once((*ray, rng)))[0]
    }

    fn radiances<S: Sampler>(
        &self,
        scene: &Scene,
        samples: impl Iterator<Item = Sample<S>>,
    ) -> Vec<DVec3> {
        let rays = samples.map(|Sample { ray, rng, .. }| (ray, rng));
        radiances::<E, S, Lanes, LANES>(scene, self, rays)
    }

    fn sees_in_mirrors(&self) -> bool {
        Integrator::sees_in_mirrors(self)
    }
}
