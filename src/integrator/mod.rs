//! Estimators of the rendering equation (8), composed from replaceable parts.
//!
//! Every random decision and every equation that an estimator uses is a method of a trait next to
//! the code that it serves ([`Scattering`], [`Roulette`], [`NextEvent`], [`Photons`],
//! [`Bidirectional`], [`FiniteElements`]), whose default is the library's own function.
//! [`DefaultParts`] overrides nothing and is what programs run; a trial injects a fault by
//! [replacing](Parts::replaced) one method.

mod bdpt;
mod bsdf_sample;
mod direct_light;
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

use std::fmt;
use std::ops::Deref;

use glam::DVec3;

pub use crate::sampling::mis::{Heuristic, Strategy};
pub use bdpt::{Bdpt, Connections};
pub(crate) use bsdf_sample::BsdfSample;
use direct_light::ShadowRays;
pub(crate) use interaction::{ScalarShadingPoint, ShadingPoint, SurfaceInteraction};
pub use light_tracer::LightTracer;
pub use next_event::NextEvent;
pub use path::Path;
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
pub use crate::material::DefaultParts;
use crate::material::Scattering;
use crate::math::simd::{LANES, Lanes};
use crate::sampling::roulette::Roulette;
use crate::sampling::sampler::{ImagePass, SampleStream, Sampler};
use crate::scene::Scene;

/// Maximum number of vertices of a path without a bounce limit. Where survival is at most
/// [`crate::sampling::roulette::MAX_SURVIVAL`], a path gets there with a probability below
/// 10⁻¹⁸⁰, so one that does will not end: this is reported as an error, the path is never
/// truncated. Its radiance is NaN, which no film holds.
pub const MAX_PATH_VERTICES: u32 = 1 << 13;

/// An estimator, unbiased or with a stated bias, of the radiance that arrives along a ray.
pub trait Estimator: Sync {
    /// Returns one estimate of the radiance that arrives at `ray.origin` from `ray.direction` (a
    /// unit vector), where `hit` is the result of [`Scene::intersect`] for the ray.
    fn radiance(&self, scene: &Scene, ray: &Ray, hit: Option<Hit>, rng: &mut dyn Sampler) -> DVec3;

    /// Returns the approximate number of samples per call at which [`radiances`](Self::radiances)
    /// is fastest.
    fn batch_size(&self) -> u32 {
        256
    }

    /// Estimates the radiance along several rays, in their order. Each estimate is the same as for
    /// the ray alone; rays may be traced in any order.
    fn radiances(&self, scene: &Scene, samples: &mut dyn Iterator<Item = Sample>) -> Vec<DVec3> {
        samples
            .map(|Sample { ray, hit, mut rng }| self.radiance(scene, &ray, hit, &mut rng))
            .collect()
    }

    /// Returns whether any number of mirrors may precede the first hit without changing the
    /// estimate, so that silhouette sampling may follow mirrors first.
    fn sees_in_mirrors(&self) -> bool {
        false
    }
}

/// A ray along which radiance is estimated.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Ray with a unit direction.
    pub ray: Ray,
    /// Result of [`Scene::intersect`] for the ray.
    pub hit: Option<Hit>,
    /// Random numbers of the sample.
    pub rng: SampleStream,
}

/// An estimator of a whole image, for methods in which one path contributes to many pixels.
pub trait ImageEstimator: Sync {
    /// Returns one estimate of the mean radiance over each pixel of an image of this
    /// `resolution` (width, height), row by row from the top. It is a function of its arguments
    /// alone, independent of the number of threads. Passes of different replications are
    /// independent.
    ///
    /// # Errors
    /// [`Error::Radiance`] for a value that no film can hold.
    fn image(
        &self,
        scene: &Scene,
        resolution: [u32; 2],
        pass: ImagePass,
    ) -> Result<Vec<DVec3>, Error>;

    /// Returns pass `index` with independent random numbers; each pass is a replication.
    ///
    /// # Errors
    /// Those of [`image`](Self::image).
    fn pass(
        &self,
        scene: &Scene,
        resolution: [u32; 2],
        seed: u64,
        index: u32,
    ) -> Result<Vec<DVec3>, Error> {
        self.image(scene, resolution, ImagePass::independent(seed, index))
    }
}

impl Roulette for DefaultParts {}
impl NextEvent for DefaultParts {}
impl Photons for DefaultParts {}
impl Bidirectional for DefaultParts {}
impl FiniteElements for DefaultParts {}

/// Parts of a random walk.
pub trait PathParts: Scattering + Roulette + NextEvent {}

impl<P: Scattering + Roulette + NextEvent + ?Sized> PathParts for P {}

/// All functions of estimators that can be replaced.
pub trait Replacement:
    Scattering + Roulette + NextEvent + Photons + Bidirectional + FiniteElements
{
}

impl<P: Scattering + Roulette + NextEvent + Photons + Bidirectional + FiniteElements> Replacement
    for P
{
}

/// The parts of an estimator: [`DefaultParts`] unless they are replaced.
///
/// Each estimator is compiled twice, both times in this crate: for the default parts, which are
/// called directly, and for replaced ones behind a pointer. It dereferences to the functions.
#[derive(Clone, Copy, Default)]
pub struct Parts<'a>(Option<&'a dyn Replacement>);

impl<'a> Parts<'a> {
    /// Returns these functions in place of the library's own.
    pub const fn replaced(by: &'a dyn Replacement) -> Self {
        Self(Some(by))
    }

    /// Returns whether nothing is replaced.
    pub const fn are_default(self) -> bool {
        self.0.is_none()
    }
}

impl<'a> Deref for Parts<'a> {
    type Target = dyn Replacement + 'a;
    fn deref(&self) -> &Self::Target {
        self.0.unwrap_or(&DefaultParts)
    }
}

impl fmt::Debug for Parts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.are_default() {
            "DefaultParts"
        } else {
            "replaced parts"
        })
    }
}

/// Evaluates an expression with a reference to the parts, of either type.
macro_rules! with_parts {
    ($parts:expr, |$name:ident| $value:expr) => {
        match $parts.0 {
            None => {
                let $name = &$crate::integrator::DefaultParts;
                $value
            }
            Some($name) => $value,
        }
    };
}
pub(crate) use with_parts;

/// Rules of a convention for which light is transported and shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransportRules {
    /// Radiance that a ray sees at an emitter, where hits count; `None` for the emitter's own.
    pub emitted_radiance: Option<f64>,
    /// Whether shadow rays pass through glass, straight and unattenuated.
    pub shadows_pass_glass: bool,
    /// Whether caustics count: light that reaches a diffuse surface through mirrors and glass,
    /// where no shadow ray samples it, and that is found when a path hits the emitter. Where shadow
    /// rays pass through glass, light behind it has been sampled and does not count again.
    pub caustics: bool,
    /// Whether refraction scales radiance by (n₁/n₂)².
    pub radiance_factor: bool,
}

impl TransportRules {
    /// Energy-conserving transport.
    pub const PHYSICAL: Self = Self {
        emitted_radiance: None,
        shadows_pass_glass: false,
        caustics: true,
        radiance_factor: true,
    };
    /// Rules of the report's figures: a visible emitter has radiance 1, glass casts no shadow,
    /// refraction only weights by T = 1 − R, and caustics on diffuse surfaces are lost.
    pub const REPORT: Self = Self {
        emitted_radiance: Some(1.0),
        shadows_pass_glass: true,
        caustics: false,
        radiance_factor: false,
    };

    /// Returns shadow rays to points uniform in the area of emitters.
    fn shadow_rays(&self) -> ShadowRays {
        ShadowRays {
            lights: LightSampling::Area,
            pass_glass: self.shadows_pass_glass,
        }
    }
}

// Not for all integrators at once: such code would be compiled where it is used.
macro_rules! estimators {
    ($($name:ident),*) => {$(
        impl Estimator for $name<'_> {
            fn radiance(
                &self,
                scene: &Scene,
                ray: &Ray,
                _: Option<Hit>,
                rng: &mut dyn Sampler,
            ) -> DVec3 {
                let rays = &mut std::iter::once((*ray, rng));
                with_parts!(self.parts, |parts| {
                    radiances::<_, _, _, f64, 1>(scene, self, parts, rays)[0]
                })
            }

            fn radiances(
                &self,
                scene: &Scene,
                samples: &mut dyn Iterator<Item = Sample>,
            ) -> Vec<DVec3> {
                let rays = &mut samples.map(|Sample { ray, rng, .. }| (ray, rng));
                with_parts!(self.parts, |parts| {
                    radiances::<_, _, _, Lanes, LANES>(scene, self, parts, rays)
                })
            }

            fn sees_in_mirrors(&self) -> bool {
                Integrator::sees_in_mirrors(self)
            }
        }
    )*};
}

estimators!(Path, Report, Whitted);
