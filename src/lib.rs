//! whitefurnace: a global-illumination testbed in which every equation is on trial.
//!
//! It implements the report *Global Illumination Rendering With Monte Carlo Ray-tracing* (Blåwiik and
//! Nilsson, 2019) from its text: every equation stands once, as a small function beside its formula,
//! and cites its entry in the [`equation`] registry. Where the report is wrong, the correct form is the
//! default and the printed form stands beside it under a name that says so.
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
//! | [`estimator`] | how: estimators composed from replaceable parts |
//! | [`render`], [`film`], [`splat`], [`image`] | the loop, the accumulators, the files |
//! | [`rng`], [`sampler`] | streams of random numbers, Owen-scrambled Sobol' points |
//! | [`frame`], [`error`] | coordinates, errors |
//! | [`harness`] | statistics, verdicts, trials as data: put your own code on trial with it |
//!
//! The trials of this library, and the faults that they must reject, are in the crate `trials`, in the folder
//! `tests`.
//!
//! # Invariants
//!
//! - The library prints nothing and reads no clock. Only [`image`] and [`harness::trial`] touch files;
//!   only the latter reads the environment.
//! - Only [`rng`] makes generators. Randomness is an argument everywhere else.
//! - Same seed, same bytes: sums on the film are integers, so no order of threads can show.
//! - No clamp, depth limit or epsilon without a named constant and a sentence on the bias it brings.
//! - An estimator sees a scene only through its methods, and every decision it makes is a method of
//!   [`estimator::Parts`] that a trial can replace.
//! - Directions are unit vectors. Pdfs of directions are with respect to solid angle, of points with
//!   respect to area. Angles are in radians.
//!
//! # Departures from the report's literal text
//!
//! The finding of each [`equation`] says them one by one.

pub mod accel;
pub mod bsdf;
pub mod camera;
pub mod emitter;
pub mod equation;
pub mod error;
pub mod estimator;
pub mod film;
pub mod form_factor;
pub mod frame;
pub mod fresnel;
pub mod harness;
pub mod image;
pub mod kd_tree;
pub mod moments;
pub mod pixel;
pub mod radiometry;
pub mod render;
pub mod rng;
pub mod roulette;
pub mod sampler;
pub mod sampling;
pub mod scene;
pub mod shape;
pub mod solid_angle;
pub mod splat;
pub mod watertight;
