//! whitefurnace: a global-illumination testbed in which every equation is on trial.
//!
//! It implements the report *Global Illumination Rendering With Monte Carlo Ray-tracing* (Blåwiik
//! and Nilsson, 2019) from its text: every equation stands once, as a small function beside its
//! formula, and cites its entry in the [`equation`] registry. Where the report is wrong, the
//! correct form is the default and the printed form stands beside it under a name that says so.
//!
//! # The house
//!
//! | room | what is in it |
//! |---|---|
//! | [`equation`] | the registry: id, formula, source, our verdict |
//! | [`shape`], [`watertight`] | (1)-(7): rays, triangles, spheres |
//! | [`radiometry`], [`form_factor`] | (8)-(9): cosine, geometry term, measures, form factors |
//! | [`fresnel`], [`bsdf`] | (10)-(15): interfaces and reflection models |
//! | [`moments`], [`sampling`], [`roulette`], [`pixel`] | (16)-(19), 2.6.2, 2.7: Monte Carlo |
//! | [`solid_angle`] | lights as they are seen: closed forms and uniform directions |
//! | [`scene`], [`emitter`], [`camera`], [`accel`] | what is rendered, as plain data |
//! | [`kd_tree`] | points by neighbourhood |
//! | [`estimator`] | how: estimators made of replaceable parts |
//! | [`outline`], [`adaptive`] | lights that the camera sees, at their edges; more samples where the noise is |
//! | [`render`], [`film`], [`splat`], [`image`] | the loop, the accumulators, the files |
//! | [`rng`], [`sampler`] | streams of random numbers, Owen-scrambled Sobol' points |
//! | [`real`], [`lanes`] | numbers and vectors of one ray or of several, and the loops in which estimators follow these |
//! | [`frame`], [`error`], [`nearest`], [`shard`] | coordinates, errors, the name that was probably meant, parts of work |
//! | [`harness`] | statistics, verdicts, trials as data: put your own code on trial with it |
//!
//! The trials of this library, and the faults that they must reject, are in the crate `registry`,
//! in the folder `tests`.
//!
//! # Three examples
//!
//! Render a scene:
//!
//! ```
//! use whitefurnace::integrator::{Path, Standard, Strategy};
//! use whitefurnace::film::Film;
//! use whitefurnace::sampling::pixel::PixelSampling;
//! use whitefurnace::render::{Numbers, Sampling, render};
//! use whitefurnace::scene::simple::cornell;
//!
//! # fn main() -> Result<(), whitefurnace::error::Error> {
//! let sampling = Sampling { pixel: PixelSampling::Random, numbers: Numbers::Independent, seed: 1, outlines: false };
//! let mut film = Film::new([32, 32], None, 1)?;
//! render(&cornell()?, &Path::new(Standard, Strategy::Mis), sampling, &mut film, &(0..4), &|_| true)?;
//! println!("mean {:.3}, known to {:.1} %", film.mean(), 100.0 * film.relative_error());
//! # Ok(())
//! # }
//! ```
//!
//! Put your own BSDF on trial. The model that passes is rendered with the very sampler and pdf that
//! passed: `Surface::new(Bsdf::model(Clay))`.
//!
//! ```
//! use glam::DVec3;
//! use whitefurnace::material::{Bsdf, Model};
//! use whitefurnace::harness::bsdf_checkup::{BsdfSubject, CheckUp, check_up};
//! use whitefurnace::harness::trial::{Context, assert_holds};
//! use whitefurnace::sampling::warp::{uniform_hemisphere, uniform_hemisphere_pdf};
//!
//! #[derive(Debug)]
//! struct Clay;
//!
//! impl Model for Clay {
//!     fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
//!         DVec3::splat(0.3 * (wo.z * wi.z).sqrt())
//!     }
//!     fn sample(&self, _: DVec3, random: [f64; 2]) -> Option<DVec3> {
//!         Some(uniform_hemisphere(random))
//!     }
//!     fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
//!         uniform_hemisphere_pdf(wi.z)
//!     }
//!     fn albedo(&self) -> DVec3 {
//!         DVec3::splat(0.5)
//!     }
//! }
//!
//! let context = Context::new(2019, 1.0).unwrap().named("clay");
//! assert_holds(&check_up(&BsdfSubject::of(Bsdf::model(Clay)), &CheckUp::default(), &context));
//! ```
//!
//! Compare two images, of any renderer, by the mean and variance of each pixel:
//!
//! ```
//! use whitefurnace::harness::trial::assert_holds;
//! use whitefurnace::harness::welch_map::{PixelStatistics, map};
//!
//! let (variance, count) = (vec![0.04; 12], vec![400; 12]);
//! let images = [0.500, 0.501].map(|level| vec![level; 12]);
//! let [a, b] = [&images[0], &images[1]]
//!     .map(|mean| PixelStatistics { mean, variance: &variance, count: &count });
//! // Four pixels across, judged one by one; the least p-value counts as one of twelve.
//! assert_holds(&[map(&a, &b, 4, 1).smallest("pixels", 400)]);
//! ```
//!
//! # Invariants
//!
//! - The library prints nothing and reads no clock. Only [`image`], [`scene::file`] and
//!   [`harness::trial`] touch files; only the latter reads the environment.
//! - Only [`rng`] makes generators. Randomness is an argument everywhere else.
//! - Same seed, same bytes: sums on the film are integers, so no order of threads can show.
//! - No clamp, depth limit or epsilon without a named constant and a sentence on the bias it
//!   brings.
//! - An estimator sees a scene only through its methods, and every decision it makes is a method of
//!   a trait that a trial can replace: see [`estimator`].
//! - Directions are unit vectors. Pdfs of directions are with respect to solid angle, of points
//!   with respect to area. Angles are in radians.
//!
//! # Departures from the report's literal text
//!
//! The finding of each [`equation`] says them one by one.

pub mod camera;
pub mod equation;
pub mod error;
pub mod film;
pub mod geometry;
pub mod harness;
pub mod image;
pub mod integrator;
pub mod light;
pub mod material;
pub mod math;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shard;
pub mod suggest;
