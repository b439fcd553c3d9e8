//! The harness: statistics that test a sampler, a BSDF, an estimator or an image.
//!
//! Nothing here needs this project's scenes or renderer: samplers and BSDFs come in as closures,
//! images as slices.
//!
//! | question | answer |
//! |---|---|
//! | do samples follow this pdf? | [`domain::Partition`], [`chi_square`] |
//! | do directions from any program follow this pdf? | [`directions`] |
//! | does this number follow this distribution? | [`ks`] |
//! | is the mean this closed form, or that other mean? | [`mean`] |
//! | do two images agree, or two sets of images? | [`images`] |
//! | is this BSDF right? | [`bsdf_checkup`] |
//! | in which precision does it compute, and what does rounding explain? | [`roundoff`] |
//! | how fast does the error fall, and by how much is one variance below another? | [`convergence`] |
//! | how large an effect would be detected, and how surely? | [`power`] |
//! | is an effect of exactly that size detected? | [`graded`] |
//! | is it large enough for the error budget? | [`guard`] |
//! | how is all this registered, run and reported? | [`trial`] |
//!
//! Every statistic returns an [`Outcome`](outcome::Outcome): statistic, p-value, estimate,
//! interval, minimum detectable effect, worst cell. Its [`Verdict`](outcome::Verdict) has three
//! values: a test that could not have detected the effect is *undecided*, never green.
//!
//! A complete test of a sampler:
//!
//! ```
//! use whitefurnace::harness::chi_square::sampler_against_partition;
//! use whitefurnace::harness::domain::{Domain, Partition};
//! use whitefurnace::harness::outcome::Verdict;
//! use whitefurnace::sampling::rng::{seed_for, stream, uniform2};
//! use whitefurnace::sampling::warp::cosine_hemisphere;
//!
//! let mut rng = stream(seed_for(2019, "my sampler"), 0, 0);
//! // Cells of equal probability under cos θ/π.
//! let cells = Partition::equal(Domain::CosineHemisphere, 3, 4);
//! let outcome = sampler_against_partition("cells", &cells, 8_000_000, || {
//!     Some(cosine_hemisphere(uniform2(&mut rng)))
//! });
//! assert_eq!(outcome.verdict(), Verdict::Holds, "{}", outcome.worst);
//! ```
use std::hint::black_box;

pub mod batches;
pub mod bsdf_checkup;
pub mod chi_square;
pub mod convergence;
pub mod directions;
pub mod domain;
pub mod graded;
pub mod guard;
pub mod images;
pub mod ks;
mod level;
pub mod mean;
pub mod outcome;
mod parallel;
pub mod pointwise;
pub mod power;
pub mod quadrature;
mod quantiles;
pub mod roundoff;
pub mod tails;
pub mod trial;

/// Passes an argument to a closure as another variable than the caller's own: built without
/// `incremental`, rustc (1.95 at least) lets closures change their caller's,
/// github.com/rust-lang/rust/issues/155241.
fn copied<T>(argument: T) -> T {
    black_box(argument)
}
