//! Estimators of the rendering equation (8), composed from plain parts.
//!
//! Every random decision and every equation that an estimator uses is a method of [`Parts`], whose
//! default is the library's own function. [`Standard`] overrides nothing and is what programs run; a
//! trial puts a faulty part in by overriding one method. All of it is resolved by the compiler.

mod bdpt;
mod diffuse;
mod emission;
mod light_tracer;
mod particle;
mod path;
mod photon;
pub mod photon_map;
mod published;
pub mod radiosity;
mod report;
mod sppm;
mod strategies;
mod vertex;
mod walk;
mod whitted;

use glam::DVec3;

pub use bdpt::Bdpt;
pub use diffuse::{DiffuseSample, sample_cosine, sample_uniform};
pub use light_tracer::LightTracer;
pub use path::{Heuristic, Path, Strategy};
pub use photon::{Lookup, PhotonMapping};
pub use published::{Published, Quirks};
pub use radiosity::Radiosity;
pub use report::Report;
pub use sppm::{Sppm, radius_squared};
pub use strategies::{Density, weight};
pub use whitted::Whitted;

use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::emitter::{Emitter, EmitterPoint};
use crate::error::Error;
use crate::form_factor::{self, Polygon};
use crate::sampler::Sampler;
use crate::scene::{Hit, Scene};
use crate::shape::Ray;
use crate::{fresnel, radiometry, roulette, sampling};

/// The most vertices of a path without a limit of its own. Where survival is at most
/// [`roulette::HIGHEST_SURVIVAL`] a path gets there with a probability below 10⁻¹⁸⁰, so one that does will
/// not end: it is an error, never a cut. Its radiance is NaN, which no film holds.
pub const LONGEST_PATH: u32 = 1 << 13;

/// An unbiased or stated-bias estimate of the radiance that arrives along a ray.
pub trait Estimator: Sync {
    /// One estimate of the radiance that arrives at `ray.origin` from `ray.direction` (a unit vector),
    /// where `hit` is what [`Scene::intersect`] returns for the ray.
    fn radiance<R: Sampler>(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: Option<Hit>,
        rng: &mut R,
    ) -> DVec3;
}

/// An estimate of a whole image at once, for methods in which one path reaches many pixels.
pub trait ImageEstimator: Sync {
    /// Pass `index`: one estimate of the mean radiance over each pixel of the `frame` (width, height),
    /// row by row from the top. Passes are independent replications, each a function of its arguments
    /// alone, whatever the threads.
    ///
    /// # Errors
    /// [`Error::Radiance`] for a value that no film can hold.
    fn pass(
        &self,
        scene: &Scene,
        frame: [u32; 2],
        seed: u64,
        index: u32,
    ) -> Result<Vec<DVec3>, Error>;
}

/// The replaceable parts of the estimators.
pub trait Parts: Sync {
    /// R of (12).
    #[inline]
    fn fresnel(&self, cos_1: f64, n1: f64, n2: f64) -> f64 {
        fresnel::reflectance(cos_1, n1, n2)
    }
    /// The refracted direction.
    #[inline]
    fn refract(&self, d: DVec3, n: DVec3, n1: f64, n2: f64) -> Option<DVec3> {
        fresnel::refract(d, n, n1, n2)
    }
    /// The factor of refracted radiance.
    #[inline]
    fn radiance_factor(&self, n1: f64, n2: f64) -> f64 {
        fresnel::radiance_factor(n1, n2)
    }
    /// The mirror direction.
    #[inline]
    fn mirror(&self, d: DVec3, n: DVec3) -> DVec3 {
        fresnel::mirror(d, n)
    }
    /// f_r of (13) or (14), local directions.
    #[inline]
    fn brdf(&self, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
        bsdf.eval(wo, wi)
    }
    /// cos θ of (9).
    #[inline]
    fn cosine(&self, normal: DVec3, direction: DVec3) -> f64 {
        radiometry::cosine(normal, direction)
    }
    /// A direction by (18) and (19), local.
    #[inline]
    fn uniform_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        sampling::uniform_hemisphere(random)
    }
    /// Its pdf (17) with respect to solid angle.
    #[inline]
    fn uniform_hemisphere_pdf(&self, cos_theta: f64) -> f64 {
        sampling::uniform_hemisphere_pdf(cos_theta)
    }
    /// A cosine-weighted direction, local.
    #[inline]
    fn cosine_hemisphere(&self, random: [f64; 2]) -> DVec3 {
        sampling::cosine_hemisphere(random)
    }
    /// Its pdf with respect to solid angle.
    #[inline]
    fn cosine_hemisphere_pdf(&self, cos_theta: f64) -> f64 {
        sampling::cosine_hemisphere_pdf(cos_theta)
    }
    /// The path tracer's survival policy.
    #[inline]
    fn survival_by_throughput(&self, throughput: DVec3) -> f64 {
        roulette::by_throughput(throughput)
    }
    /// The report's survival policy.
    #[inline]
    fn survival_by_absorption(&self, absorption: f64) -> f64 {
        roulette::by_absorption(absorption)
    }
    /// Whether a path survives.
    #[inline]
    fn survives(&self, r: f64, survival: f64) -> bool {
        roulette::survives(r, survival)
    }
    /// What a survivor is multiplied by.
    #[inline]
    fn roulette_weight(&self, survival: f64) -> f64 {
        roulette::weight(survival)
    }
    /// Which of `count` ≥ 1 emitters a shadow ray picks; each with probability 1/count.
    #[inline]
    fn pick_emitter(&self, r: f64, count: usize) -> usize {
        ((r * count as f64) as usize).min(count - 1)
    }
    /// A point on an emitter.
    #[inline]
    fn sample_emitter(&self, emitter: &Emitter, random: [f64; 2]) -> EmitterPoint {
        emitter.sample(random)
    }
    /// Its pdf with respect to area.
    #[inline]
    fn emitter_pdf_area(&self, emitter: &Emitter) -> f64 {
        emitter.pdf_area()
    }
    /// Solid angle per area of an emitter.
    #[inline]
    fn solid_angle_per_area(&self, cosine_at_emitter: f64, distance_squared: f64) -> f64 {
        radiometry::solid_angle_per_area(cosine_at_emitter, distance_squared)
    }
    /// A point on an emitter whose direction is uniform in the solid angle seen from a point, and its
    /// pdf with respect to that; `None` for emitters that are sampled by area alone.
    #[inline]
    fn sample_solid_angle(
        &self,
        emitter: &Emitter,
        from: DVec3,
        random: [f64; 2],
    ) -> Option<(EmitterPoint, f64)> {
        emitter.sample_solid_angle(from, random)
    }
    /// The same pdf for any point of the emitter's front.
    #[inline]
    fn pdf_solid_angle(&self, emitter: &Emitter, from: DVec3) -> Option<f64> {
        emitter.pdf_solid_angle(from)
    }
    /// Whether two points see each other.
    #[inline]
    fn visible(&self, scene: &Scene, x: (DVec3, DVec3), y: (DVec3, DVec3), glass: bool) -> bool {
        scene.visible(x, y, glass)
    }
    /// The form factor of a polygon above the horizon, relative to the receiver.
    #[inline]
    fn form_factor(&self, normal: DVec3, corners: &[DVec3]) -> f64 {
        form_factor::polygon(normal, corners)
    }
    /// How much a point of an emitter counts in the share of it that is seen: its geometry term, by the
    /// receiver's cosine and the solid angle per area.
    #[inline]
    fn seen_weight(&self, cosine: f64, solid_angle: f64) -> f64 {
        cosine * solid_angle
    }
    /// Whether a part of a sphere is so near for its area that it is divided.
    #[inline]
    fn is_near(&self, area: f64, distance_squared: f64) -> bool {
        radiosity::is_near(area, distance_squared)
    }
    /// The part of a polygon above the horizon.
    #[inline]
    fn horizon(&self, normal: DVec3, polygon: &Polygon) -> Polygon {
        polygon.above(normal)
    }
    /// The radiance that leaves a Lambert surface.
    #[inline]
    fn leaving(&self, albedo: DVec3, emitted: DVec3, irradiance: DVec3) -> DVec3 {
        radiosity::leaving(albedo, emitted, irradiance)
    }
    /// What patches send each other of the radiance that leaves them: all but what they emit, which
    /// arrives as direct light.
    #[inline]
    fn exchanged(&self, leaving: DVec3, emitted: DVec3) -> DVec3 {
        leaving - emitted
    }
    /// Whether the radiosities are good enough after so many sweeps.
    #[inline]
    fn solved(&self, residual: f64, _sweeps: u32) -> bool {
        residual <= radiosity::RESIDUAL
    }
    /// The weight of a sample in multiple importance sampling by the balance heuristic.
    #[inline]
    fn mis_weight(&self, pdf: f64, other: f64) -> f64 {
        radiometry::balance(pdf, other)
    }
    /// The same by the power heuristic.
    #[inline]
    fn mis_power_weight(&self, pdf: f64, other: f64) -> f64 {
        radiometry::power(pdf, other)
    }
    /// Whether light that a path hits counts if it is not weighted by pdfs; `sampled` if shadow rays
    /// look for the same light (in [`Report`]: or if its rules leave it out).
    #[inline]
    fn hit_counts(&self, strategy: Strategy, sampled: bool) -> bool {
        !(sampled && strategy == Strategy::Light)
    }
    /// ΔΦ of one particle of `emitted`, whatever the number of photons that they left.
    #[inline]
    fn photon_flux(&self, flux: DVec3, emitted: u32, _stored: usize) -> DVec3 {
        photon_map::flux_share(flux, emitted)
    }
    /// Whether light that met so many mirrors and glass surfaces, and nothing else, before it arrives at a
    /// diffuse surface is a caustic. Light that met none is found by shadow rays.
    #[inline]
    fn is_caustic(&self, specular: u32) -> bool {
        specular > 0
    }
    /// Whether a photon lies on the same surface and side as a point, by their normals.
    #[inline]
    fn same_side(&self, at_photon: DVec3, at_point: DVec3) -> bool {
        photon_map::same_side(at_photon, at_point)
    }
    /// What one photon adds to the reflected radiance. Its direction `_wi`, local, has no say but by the
    /// BRDF: flux per area is irradiance, which holds the cosine.
    #[inline]
    fn photon_density(&self, brdf: DVec3, flux: DVec3, _wi: DVec3, radius_squared: f64) -> DVec3 {
        photon_map::density(brdf, flux, radius_squared)
    }
    /// Whether an eye path that has met a diffuse surface counts emitters that it hits: not where shadow
    /// rays and caustic photons bring the same light.
    #[inline]
    fn gathers_emission(&self) -> bool {
        false
    }
    /// r² of a pass of stochastic progressive photon mapping.
    #[inline]
    fn pass_radius_squared(&self, first: f64, index: u32) -> f64 {
        radius_squared(first, index)
    }
    /// What refraction does to the flux of a particle: nothing, whatever the factor of radiance.
    #[inline]
    fn flux_factor(&self, _radiance_factor: f64) -> f64 {
        1.0
    }
    /// W(ω) of the pixel through which a direction leaves the eye.
    #[inline]
    fn importance(&self, camera: &Camera, size: [u32; 2], direction: DVec3) -> f64 {
        camera.importance(size, direction)
    }
    /// The weight of the strategy with `s` light vertices among all that make the same path.
    #[inline]
    fn strategy_weight(&self, path: &[Density], s: usize) -> f64 {
        weight(path, s)
    }
}

/// The parts that programs run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Standard;

impl Parts for Standard {}

/// What light the conventions let through and show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRules {
    /// What a ray shows of an emitter that it hits, where hits count; `None` for its radiance.
    pub seen: Option<f64>,
    /// Whether shadow rays pass through glass, straight and unweakened.
    pub shadows_pass_glass: bool,
    /// Whether light that reaches a diffuse surface by way of mirrors and glass, where no shadow ray
    /// looks for it, counts when a path hits the emitter. What shadow rays pass through has been looked
    /// behind.
    pub caustics: bool,
    /// Whether refraction scales radiance by (n₁/n₂)².
    pub radiance_factor: bool,
}

impl LightRules {
    /// Energy-consistent.
    pub const PHYSICAL: Self =
        Self { seen: None, shadows_pass_glass: false, caustics: true, radiance_factor: true };
    /// What the report's figures show: an emitter that is seen shows 1, glass casts no shadow,
    /// T = 1 − R is all that refraction does, and light that mirrors and glass throw on diffuse surfaces
    /// is lost.
    pub const REPORT: Self =
        Self { seen: Some(1.0), shadows_pass_glass: true, caustics: false, radiance_factor: false };
}
