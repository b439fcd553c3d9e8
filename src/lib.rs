//! whitefurnace: a global-illumination testbed in which every equation is on trial.
//!
//! It implements the report *Global Illumination Rendering With Monte Carlo Ray-tracing* (Blåwiik
//! and Nilsson, 2019) from its text: every equation stands once, as a small function beside its
//! formula, and cites its entry in the [`equation`] registry. Where the report is wrong, the
//! correct form is the default and the printed form stands beside it under a name that says so.
//!
//! # Modules
//!
//! Each folder imports only from those above it in this table.
//!
//! | module | contents |
//! |---|---|
//! | [`equation`], [`error`] | the registry of equations (id, formula, source, finding); errors |
//! | [`suggest`], [`shard`] | "did you mean" for misspelt names; one part of a divided render |
//! | [`math`] | numbers and vectors of one ray or several ([`real`](math::real), [`simd`](math::simd)), [`frame`](math::frame), (16) as [`moments`](math::moments), [`kd_tree`](math::kd_tree) |
//! | [`sampling`] | [`rng`](sampling::rng), Owen-scrambled Sobol' points ([`sampler`](sampling::sampler)), (17)-(19) as [`warp`](sampling::warp), positions in a [`pixel`](sampling::pixel) (2.7), Russian [`roulette`](sampling::roulette) (2.6.2) |
//! | [`film`] | pixels with exact moments and first-hit features; [`splat`](film::splat) buffers |
//! | [`geometry`] | (1)-(7): rays and [`shape`](geometry::shape)s, [`watertight`](geometry::watertight) intersection, the [`bvh`](geometry::bvh); (8)-(9): [`radiometry`](geometry::radiometry); [`form_factor`](geometry::form_factor), [`solid_angle`](geometry::solid_angle), [`specular_connection`](geometry::specular_connection), ray [`offsets`](geometry::offsets) |
//! | [`camera`], [`image`] | the pinhole camera; EXR, PNG, PFM and Radiance files |
//! | [`material`] | (10)-(15): [`fresnel`](material::fresnel) and BSDFs ([`ggx`](material::ggx), [`eon`](material::eon), [`rough_glass`](material::rough_glass)) |
//! | [`light`] | [`emitter`](light::emitter), [`environment`](light::environment) map, [`light_sampler`](light::light_sampler), [`light_tree`](light::light_tree) |
//! | [`scene`] | what is rendered: builder, TOML [`file`](scene::file), built-in rooms, [`specular_casters`](scene::specular_casters) |
//! | [`integrator`] | estimators of (8): path tracing, Whitted, the report's, BDPT, light tracing, [`photon`](integrator::photon) maps, [`radiosity`](integrator::radiosity) |
//! | [`render`] | the loop over pixels and samples, [`adaptive`](render::adaptive) sampling, emitter [`silhouette`](render::silhouette)s, [`checkpoint`](render::checkpoint)s |
//! | [`harness`] | statistics, verdicts, trials as data: put your own code on trial |
//!
//! The trials of this library, and the faults that they must reject, are in the crate `trials`,
//! in the folder `tests`.
//!
//! # Features
//!
//! Both are on by default. `whitefurnace = { default-features = false }` is the harness alone, with
//! [`equation`], [`error`], [`material`], [`sampling`], [`math`] and the shapes and radiometry of
//! [`geometry`].
//!
//! - `render`: [`camera`], [`film`], [`integrator`], [`light`], [`render`], [`scene`] with its
//!   builder, Sobol' points, SIMD lanes, the hierarchy over shapes. The harness compares images in
//!   parallel.
//! - `files`: [`image`] files, scene files with the built-in scenes that are written as such,
//!   [`checkpoint`](render::checkpoint)s, and [`suggest`]; it includes `render`.
//!
//! # Three examples
//!
//! Each is a program with a wrong variant that is rejected, in `experiments/examples`:
//! `cargo run --example sampler`, `bsdf` or `images`.
//!
//! Put your own sampler on trial:
//!
//! ```
//! use whitefurnace::harness::chi_square::sampler_against_partition;
//! use whitefurnace::harness::domain::{Domain, Partition};
//! use whitefurnace::harness::trial::assert_holds;
//! use whitefurnace::sampling::rng::{seed_for, stream, uniform2};
//!
//! fn sample([u, v]: [f64; 2]) -> [f64; 3] {
//!     let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
//!     [u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt()]
//! }
//!
//! // Twelve cells that are equally probable under cos θ/π.
//! let cells = Partition::equal(Domain::CosineHemisphere, 3, 4);
//! let mut rng = stream(seed_for(2019, "Malley's method"), 0, 0);
//! let direction = || Some(sample(uniform2(&mut rng)));
//! assert_holds(&[sampler_against_partition("cells", &cells, 2_000_000, direction)]);
//! ```
//!
//! Put your own BSDF on trial. The model that passes is rendered with the very sampler and pdf that
//! passed: `Surface::new(Bsdf::model(Clay))`.
//!
//! ```
//! use whitefurnace::glam::DVec3;
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
//! use whitefurnace::harness::images::{PixelStatistics, welch_map};
//!
//! let (variance, count) = (vec![0.04; 12], vec![400; 12]);
//! let images = [0.500, 0.501].map(|level| vec![level; 12]);
//! let [a, b] = [&images[0], &images[1]]
//!     .map(|mean| PixelStatistics { mean, variance: &variance, count: &count });
//! // Four pixels across, judged one by one; the least p-value counts as one of twelve.
//! assert_holds(&[welch_map(&a, &b, 4, 1).smallest("pixels", 400)]);
//! ```
//!
//! # Render a scene
//!
#![cfg_attr(feature = "files", doc = "```")]
#![cfg_attr(not(feature = "files"), doc = "```ignore")]
//! use whitefurnace::film::Film;
//! use whitefurnace::integrator::{DefaultParts, Path, Strategy};
//! use whitefurnace::render::render;
//! use whitefurnace::sampling::Sampling;
//! use whitefurnace::sampling::pixel::PixelSampling;
//! use whitefurnace::sampling::sampler::SamplerKind;
//! use whitefurnace::scene::simple::cornell;
//!
//! # fn main() -> Result<(), whitefurnace::error::Error> {
//! let sampling = Sampling {
//!     pixel: PixelSampling::Random,
//!     sampler: SamplerKind::Independent,
//!     seed: 1,
//!     silhouettes: false,
//! };
//! let mut film = Film::new([32, 32], None, 1)?;
//! let estimator = Path::new(Strategy::Mis);
//! render(&cornell()?, &estimator, sampling, &mut film, &(0..4), &|_| true)?;
//! println!("mean {:.3}, known to {:.1} %", film.mean(), 100.0 * film.relative_error());
//! # Ok(())
//! # }
//! ```
//!
//! # Invariants
//!
//! - The library prints nothing and reads no clock. Only [`image`], [`scene::file`] and
//!   [`harness::trial`] touch files; only the latter reads the environment.
//! - Only [`sampling::rng`] makes generators. Randomness is an argument everywhere else.
//! - Same seed, same bytes: sums on the film are integers, so no order of threads can show.
//! - No clamp, depth limit or epsilon without a named constant and a sentence on the bias it
//!   brings.
//! - An estimator sees a scene only through its methods, and every decision it makes is a method of
//!   a trait that a trial can replace: see [`integrator`].
//! - Directions are unit vectors. Pdfs of directions are with respect to solid angle, of points
//!   with respect to area. Angles are in radians.
//!
//! # Departures from the report's literal text
//!
//! The finding of each [`equation`] says them one by one.

// Functions that only the renderer and files call.
#![cfg_attr(not(all(feature = "render", feature = "files")), allow(dead_code))]

/// The crate of the vectors that the library's functions take and return.
///
/// A program with another version of it converts through arrays:
/// `whitefurnace::glam::DVec3::from(vector.to_array())`.
pub use glam;

#[cfg(feature = "render")]
pub mod camera;
pub mod equation;
pub mod error;
#[cfg(feature = "render")]
pub mod film;
pub mod geometry;
pub mod harness;
#[cfg(feature = "files")]
pub mod image;
#[cfg(feature = "render")]
pub mod integrator;
#[cfg(feature = "render")]
pub mod light;
pub mod material;
pub mod math;
#[cfg(feature = "render")]
pub mod render;
pub mod sampling;
#[cfg(feature = "render")]
pub mod scene;
pub mod shard;
#[cfg(feature = "files")]
pub mod suggest;
